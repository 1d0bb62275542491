//! Cholesky's factor of a symmetric positive definite matrix of a dozen rows, without a general library's overhead.

use super::basis::dot;

pub(crate) struct Lower {
    size: usize,
    /// Row by row; what lies above the diagonal is not looked at.
    rows: Vec<f64>,
}

impl Lower {
    /// Of the lower triangle of `matrix`, row by row; none where it is not positive definite.
    pub fn of(mut matrix: Vec<f64>, size: usize) -> Option<Self> {
        for i in 0..size {
            let (above, rest) = matrix.split_at_mut(i * size);
            let row = &mut rest[..size];
            for j in 0..i {
                let other = &above[j * size..][..size];
                row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
            }
            let left = row[i] - dot(&row[..i], &row[..i]);
            // Not a number is not positive either.
            if left > 0.0 {
                row[i] = left.sqrt();
            } else {
                return None;
            }
        }
        Some(Self { size, rows: matrix })
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.rows[i * self.size + j]
    }

    /// x with A x = `side`.
    pub fn solve(&self, mut side: Vec<f64>) -> Vec<f64> {
        for i in 0..self.size {
            let known = dot(&self.rows[i * self.size..][..i], &side[..i]);
            side[i] = (side[i] - known) / self.at(i, i);
        }
        for i in (0..self.size).rev() {
            let known: f64 = (i + 1..self.size).map(|k| self.at(k, i) * side[k]).sum();
            side[i] = (side[i] - known) / self.at(i, i);
        }
        side
    }

    /// tr A^-1, the sum of squares of the factor's inverse.
    pub fn inverse_trace(&self) -> f64 {
        let mut trace = 0.0;
        let mut column = vec![0.0; self.size];
        for c in 0..self.size {
            for i in c..self.size {
                let known = dot(&self.rows[i * self.size..][c..i], &column[c..i]);
                column[i] = (f64::from(u8::from(i == c)) - known) / self.at(i, i);
                trace += column[i] * column[i];
            }
        }
        trace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_and_inverts_what_a_hand_multiplies() {
        // A = [4 2 0.6; 2 5 1; 0.6 1 3], A x with x = (1, -2, 0.5); det A = 44.6 (Sarrus), the minors on the diagonal
        // 14, 11.64 and 16.
        let matrix = vec![4.0, 0.0, 0.0, 2.0, 5.0, 0.0, 0.6, 1.0, 3.0];
        let lower = Lower::of(matrix, 3).unwrap();
        let x = lower.solve(vec![0.3, -7.5, 0.1]);
        for (found, x) in x.iter().zip([1.0, -2.0, 0.5]) {
            assert!((found - x).abs() < 1e-14);
        }
        assert!((lower.inverse_trace() - (14.0 + 11.64 + 16.0) / 44.6).abs() < 1e-14);
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        assert!(Lower::of(vec![1.0, 0.0, 2.0, 1.0], 2).is_none());
        assert!(Lower::of(vec![f64::NAN], 1).is_none());
    }
}
