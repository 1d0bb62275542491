//! The noise floor: stated standard errors, repeated dwells and residuals, weighed together.

use crate::core::calibrate::Calibration;
use crate::core::campaign::repeats::PureError;
use crate::core::diagnose::diagnosis::{GyroFloor, NoiseFloor};
use crate::core::diagnose::residuals::whitened::{Frame, GyroFrame};
use crate::core::numerics::basis::dot;

/// Scatter of whitened residuals within groups of repeated dwells: sum of (y - weighted group mean)^2 / sd^2. Within a
/// group the model's design is constant, so its residuals differ as outputs do; what adopted effects of time,
/// temperature or order explain is no pure error, hence residuals and not outputs.
pub(crate) fn pure_error(frame: &Frame, gyro: &GyroFrame, residual: &[f64]) -> PureError {
    PureError::of(&frame.noise.repeats, |k| residual[k] * gyro.sd[k], |k| gyro.sd[k])
}

/// `repeat_dof` of each gyro, and the ratio of real to stated noise, are those of the fit.
pub(crate) fn report(frame: &Frame, variances: &[f64], from_residual: bool, fit: &Calibration) -> NoiseFloor {
    let repeats = !frame.noise.repeats.is_empty();
    let source = match (frame.noise.stated, repeats, from_residual) {
        (true, true, true) => "repeats+residuals+sem",
        (true, true, false) => "repeats+sem",
        (true, false, true) => "residuals+sem",
        (true, false, false) => "sem",
        (false, true, true) => "repeats+residual",
        (false, true, false) => "repeats",
        (false, false, _) => "residual",
    };
    let gyros: Vec<GyroFloor> = frame
        .gyros
        .iter()
        .zip(variances)
        .zip(&fit.gyros)
        .map(|((gyro, variance), fit)| GyroFloor {
            slot: fit.slot,
            deg_per_h: (variance * dot(&gyro.sd, &gyro.sd) / gyro.sd.len() as f64).sqrt(),
            repeat_dof: fit.noise.pure_error.dof,
        })
        .collect();
    let mean_square = gyros.iter().map(|g| g.deg_per_h.powi(2)).sum::<f64>() / gyros.len() as f64;
    NoiseFloor { deg_per_h: mean_square.sqrt(), source, sem_factor: fit.sem_factor().unwrap_or(1.0), gyros }
}

/// Root mean square that noise alone leaves in the residuals of the model in use, deg/h: with `Q` an orthonormal
/// basis of the whitened design, the residual of dwell k has the variance `v sd_k^2 (1 - (Q Q')_kk)`.
pub(crate) fn expected_rms(frame: &Frame, variances: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (gyro, variance) in frame.gyros.iter().zip(variances) {
        for (k, sd) in gyro.sd.iter().enumerate() {
            sum += variance * sd * sd * (1.0 - gyro.basis.leverage(k)).max(0.0);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

/// Root mean square of whitened residuals, deg/h.
pub(crate) fn rms<'a>(frame: &Frame, residuals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (gyro, residual) in frame.gyros.iter().zip(residuals) {
        sum += residual.iter().zip(&gyro.sd).map(|(r, sd)| (r * sd).powi(2)).sum::<f64>();
        count += residual.len();
    }
    (sum / count as f64).sqrt()
}
