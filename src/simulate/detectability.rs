//! How visible a cause is: the whitened power of its response that the model cannot absorb.

use crate::core::model::Terms;
use nalgebra::Vector3;

/// Relative length below which a column is taken for a combination of those before it.
const DEPENDENT: f64 = 1e-9;

/// The part of what the station writes down that a fit of its model could use, for one gyro.
#[derive(Debug, Clone)]
pub struct Sight {
    /// Standard deviation of each dwell's mean.
    sd: Vec<f64>,
    /// Orthonormal columns that span the whitened model.
    basis: Vec<Vec<f64>>,
}

impl Sight {
    /// What a design with these `terms` can see of a response. `commanded` holds each dwell's specific force (g0) and
    /// inertial rate (arcsec/s) in body axes, `sd` the true standard deviation of its mean output (pulse/s); both are
    /// of the same length.
    pub fn new(terms: Terms, commanded: &[(Vector3<f64>, Vector3<f64>)], sd: &[f64]) -> Self {
        let rows: Vec<Vec<f64>> = commanded.iter().map(|(a, w)| terms_of(terms, a, w)).collect();
        let columns = rows.first().map_or(0, Vec::len);
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for c in 0..columns {
            extend(&mut basis, rows.iter().zip(sd).map(|(row, s)| row[c] / s).collect());
        }
        Self { sd: sd.to_vec(), basis }
    }

    /// d of a response in pulse/s: length of the whitened response off the model's columns.
    pub fn detectability(&self, response: &[f64]) -> f64 {
        norm(&self.left_over(response))
    }

    /// The whitened response itself, off the model's columns.
    pub fn left_over(&self, response: &[f64]) -> Vec<f64> {
        without(&self.basis, self.whitened(response))
    }

    /// Length of the whitened response itself.
    pub fn power(&self, response: &[f64]) -> f64 {
        norm(&self.whitened(response))
    }

    fn whitened(&self, response: &[f64]) -> Vec<f64> {
        response.iter().zip(&self.sd).map(|(r, s)| r / s).collect()
    }
}

/// The model's regressors, written out again here: this check shares nothing with the fit.
fn terms_of(terms: Terms, a: &Vector3<f64>, w: &Vector3<f64>) -> Vec<f64> {
    use crate::core::model::Term::{Bias, GLinear, GSquared, Scale};
    let groups: [(_, Vec<f64>); 4] = [
        (Bias, vec![1.0]),
        (GLinear, vec![a.x, a.y, a.z]),
        (GSquared, vec![a.x * a.x, a.y * a.y, a.z * a.z]),
        (Scale, vec![w.x, w.y, w.z]),
    ];
    groups.into_iter().filter(|(term, _)| terms.contains(*term)).flat_map(|(_, columns)| columns).collect()
}

/// Adds the direction of `column` off the span of `basis`, where it has one.
pub fn extend(basis: &mut Vec<Vec<f64>>, column: Vec<f64>) {
    let length = norm(&column);
    let rest = without(basis, column);
    if norm(&rest) > DEPENDENT * length {
        let unit = 1.0 / norm(&rest);
        basis.push(rest.into_iter().map(|x| x * unit).collect());
    }
}

/// `v` less its part in the span of `basis`; twice, because once leaves rounding along the basis.
pub fn without(basis: &[Vec<f64>], mut v: Vec<f64>) -> Vec<f64> {
    for _ in 0..2 {
        for b in basis {
            let along: f64 = b.iter().zip(&v).map(|(x, y)| x * y).sum();
            v.iter_mut().zip(b).for_each(|(y, x)| *y -= along * x);
        }
    }
    v
}

/// Root of the sum of squares.
pub fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::model::Term;

    #[test]
    fn a_step_seen_against_a_constant_by_hand() {
        // Ten dwells of noise 0.5, a step of 2 after the fourth: residual power 4 * (4*6/10) / 0.25 = 38.4.
        let commanded = vec![(Vector3::zeros(), Vector3::zeros()); 10];
        let sight = Sight::new(Terms::of(&[Term::Bias]), &commanded, &[0.5; 10]);
        let step: Vec<f64> = (0..10).map(|k| if k < 4 { 0.0 } else { 2.0 }).collect();
        assert!((sight.detectability(&step).powi(2) - 38.4).abs() < 1e-10);
        assert!((sight.power(&step).powi(2) - 96.0).abs() < 1e-10);
    }

    #[test]
    fn six_faces_absorb_every_function_of_specific_force() {
        let faces: Vec<Vector3<f64>> =
            (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 })).collect();
        let commanded: Vec<_> = faces.iter().chain(&faces).map(|a| (*a, Vector3::zeros())).collect();
        let sight = Sight::new(Terms::MODEL_6.without(Term::Scale), &commanded, &[1e-3; 12]);
        let odd: Vec<f64> = commanded.iter().map(|(a, _)| (1.0 + 2.0 * a.x - 0.7 * a.z).powi(5).sin()).collect();
        assert!(sight.detectability(&odd) < 1e-9 * sight.power(&odd));
        assert!(sight.power(&odd) > 1.0);
    }
}
