//! Symmetric positive definite systems of at most three unknowns, on the stack: the search solves millions of them.

/// Most unknowns.
pub(crate) const MOST: usize = 3;

pub(crate) type Matrix = [[f64; MOST]; MOST];
pub(crate) type Vector = [f64; MOST];

/// Cholesky's lower factor of the leading `size` rows and columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factor {
    size: usize,
    lower: Matrix,
}

impl Factor {
    /// None where the matrix is not positive definite.
    pub fn of(size: usize, matrix: &Matrix) -> Option<Self> {
        let mut lower = [[0.0; MOST]; MOST];
        for i in 0..size {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let left = matrix[i][j] - known;
                if i != j {
                    lower[i][j] = left / lower[j][j];
                } else if left > 0.0 {
                    lower[i][i] = left.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Self { size, lower })
    }

    /// x with A x = `side`.
    pub fn solve(&self, side: &Vector) -> Vector {
        let mut x = *side;
        for i in 0..self.size {
            let known: f64 = (0..i).map(|k| self.lower[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i][i];
        }
        for i in (0..self.size).rev() {
            let known: f64 = (i + 1..self.size).map(|k| self.lower[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i][i];
        }
        x
    }

    /// ln of the determinant.
    pub fn log_det(&self) -> f64 {
        2.0 * (0..self.size).map(|i| self.lower[i][i]).product::<f64>().ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_a_hand_multiplies() {
        let matrix = [[4.0, 2.0, 0.6], [2.0, 5.0, 1.0], [0.6, 1.0, 3.0]];
        let x = [1.0, -2.0, 0.5];
        let side = matrix.map(|row| row.iter().zip(&x).map(|(a, b)| a * b).sum());
        let factor = Factor::of(3, &matrix).unwrap();
        for (found, x) in factor.solve(&side).iter().zip(x) {
            assert!((found - x).abs() < 1e-14);
        }
        // Sarrus: 60 + 1.2 + 1.2 - 1.8 - 4 - 12.
        assert!((factor.log_det() - 44.6_f64.ln()).abs() < 1e-14);
        // The leading 2 x 2 alone: 20 - 4.
        assert!((Factor::of(2, &matrix).unwrap().log_det() - 16.0_f64.ln()).abs() < 1e-14);
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        assert!(Factor::of(2, &[[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0; 3]]).is_none());
        assert!(Factor::of(1, &[[f64::NAN, 0.0, 0.0], [0.0; 3], [0.0; 3]]).is_none());
    }
}
