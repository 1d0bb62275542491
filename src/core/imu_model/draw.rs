//! One IMU of all that the model allows.

use nalgebra::DVector;

use super::identified::Identified;

/// The model with coefficients theta + L z: one of those that its covariance allows, for independent standard normal
/// `z`, one a coefficient and one more a coefficient for what differs from campaign to campaign.
///
/// L from the eigenvectors: a gauge leaves the covariance singular. Along what no campaign shows (a variance beyond
/// anything possible) the estimate stays.
pub fn drawn(model: &Identified, z: &[f64]) -> Identified {
    let p = model.coefficients.len();
    let sd: DVector<f64> = model.covariance.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
    let correlation = model.covariance.map_with_location(|i, j, c| c / (sd[i] * sd[j]));
    let eigen = correlation.symmetric_eigen();
    let within = eigen.eigenvectors
        * eigen.eigenvalues.map(|v| v.max(0.0).sqrt()).component_mul(&DVector::from_fn(p, |i, _| z[i]));
    let mut coefficients = model.coefficients.clone();
    for (i, c) in coefficients.iter_mut().enumerate() {
        let step = if sd[i] < UNKNOWN { sd[i] * within[i] } else { 0.0 };
        c.value += step + c.between * z[p + i];
    }
    Identified { coefficients, ..model.clone() }
}

/// Standard deviation from which on nothing is known.
const UNKNOWN: f64 = 10.0;
