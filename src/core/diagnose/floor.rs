//! The noise floor: stated standard errors, repeated dwells and residuals, weighed together.

use statrs::function::gamma::checked_gamma_ur;

use super::answer::{Gap, GyroFloor, NoiseFloor};
use super::basis::dot;
use super::frame::{Frame, GyroFrame};

/// Prior weight, in degrees of freedom, of the statement that the stated standard errors are right. Standard errors
/// are met that are wrong by tens of per cent: a factor with a scatter of 22 % is worth 1/(2 x 0.22^2) = 10.
pub(super) const STATED_DOF: f64 = 10.0;

/// What one gyro's dwells say about the factor between the real noise and `sd`, independently of any effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PureError {
    /// Sum of squares within repeats, in units of `sd`.
    pub sum: f64,
    pub dof: usize,
}

/// Scatter within groups of repeated dwells, weighted: sum over groups of (y - weighted group mean)^2 / sd^2.
pub(super) fn pure_error(frame: &Frame, gyro: &GyroFrame) -> PureError {
    let mut pure = PureError { sum: 0.0, dof: 0 };
    for group in &frame.noise.repeats {
        // Within a group the design is constant, so residuals differ as outputs do.
        let weights: Vec<f64> = group.iter().map(|&k| gyro.sd[k].powi(-2)).collect();
        let total: f64 = weights.iter().sum();
        let value = |k: usize| gyro.residual[k] * gyro.sd[k];
        let mean = group.iter().zip(&weights).map(|(&k, w)| w * value(k)).sum::<f64>() / total;
        pure.sum += group.iter().zip(&weights).map(|(&k, w)| w * (value(k) - mean).powi(2)).sum::<f64>();
        pure.dof += group.len() - 1;
    }
    pure
}

/// Variance factor of one gyro. `rss` over `dof` is what the best model leaves; it joins where nothing significant
/// remains in it, otherwise only repeats and stated errors count.
#[expect(dead_code, reason = "the floor after adoption takes it")]
pub(super) fn variance(stated: bool, pure: PureError, left: Option<(f64, f64)>) -> f64 {
    let prior = if stated { STATED_DOF } else { 0.0 };
    match left {
        Some((rss, dof)) => (prior + rss) / (prior + dof),
        None if stated || pure.dof > 0 => {
            // Without any residual to lean on, an unstated noise still has the robust residual scale behind it.
            let prior = prior.max(2.0);
            (prior + pure.sum) / (prior + pure.dof as f64)
        }
        None => 1.0,
    }
}

pub(super) fn report(frame: &Frame, variances: &[f64], from_residual: bool) -> NoiseFloor {
    let repeats = !frame.noise.repeats.is_empty();
    let source = match (frame.noise.stated, repeats) {
        (true, true) => "repeats+sem",
        (true, false) => "sem",
        (false, true) if !from_residual => "repeats",
        (false, true) => "repeats+residual",
        (false, false) => "residual",
    };
    let gyros: Vec<GyroFloor> = frame
        .gyros
        .iter()
        .zip(variances)
        .enumerate()
        .map(|(j, (gyro, variance))| GyroFloor {
            slot: frame.setting.gyros[j].slot,
            deg_per_h: (variance * dot(&gyro.sd, &gyro.sd) / gyro.sd.len() as f64).sqrt(),
            repeat_dof: pure_error(frame, gyro).dof,
        })
        .collect();
    let mean_square = gyros.iter().map(|g| g.deg_per_h.powi(2)).sum::<f64>() / gyros.len() as f64;
    let factor = (variances.iter().sum::<f64>() / variances.len() as f64).sqrt();
    NoiseFloor {
        deg_per_h: mean_square.sqrt(),
        source,
        sem_factor: if frame.noise.stated { factor } else { 1.0 },
        gyros,
    }
}

/// Residual sum of squares against the floor's variances.
pub(super) fn gap(frame: &Frame, variances: &[f64]) -> Gap {
    let chi2: f64 = frame.gyros.iter().zip(variances).map(|(gyro, variance)| gyro.rss() / variance).sum();
    let dof: usize = frame.gyros.iter().map(GyroFrame::dof).sum();
    Gap {
        rms_deg_per_h: rms(frame, frame.gyros.iter().map(|gyro| gyro.residual.as_slice())),
        reduced_chi2: chi2 / dof as f64,
        p_value: checked_gamma_ur(0.5 * dof as f64, 0.5 * chi2).unwrap_or(0.0),
    }
}

/// Root mean square of whitened residuals, deg/h.
pub(super) fn rms<'a>(frame: &Frame, residuals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (gyro, residual) in frame.gyros.iter().zip(residuals) {
        sum += residual.iter().zip(&gyro.sd).map(|(r, sd)| (r * sd).powi(2)).sum::<f64>();
        count += residual.len();
    }
    (sum / count as f64).sqrt()
}
