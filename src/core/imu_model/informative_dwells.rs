//! Which dwells of a programme tell most of what the model does not know.

use nalgebra::DMatrix;

use super::identified::Identified;
use super::programme::{CoefficientEstimate, NoForecast, StackedDesign};
use crate::core::campaign::Campaign;

/// A dwell that is worth measuring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InformativeDwell {
    pub dwell: usize,
    /// What measuring it tells of the coefficients after those before it: 0.5 sum ln(1 + x'Cx/noise^2), nats.
    pub information: f64,
    /// Standard deviation of what the model foretells of it, in those of its noise; of the gyro of which it is largest.
    pub sd_over_noise: f64,
}

/// The dwells of a programme that tell most, the best first: each with the most information beside those chosen before
/// it (Lindley 1956), as many as `most` and no more than tell anything.
///
/// # Errors
/// [`NoForecast`].
pub fn most_telling(model: &Identified, campaign: &Campaign, most: usize) -> Result<Vec<InformativeDwell>, NoForecast> {
    let programme = StackedDesign::of(model, campaign)?;
    let mut covariance = CoefficientEstimate::of(model, campaign, &programme, model.effects.len()).covariance;
    let mut chosen: Vec<InformativeDwell> = Vec::new();
    while chosen.len() < most {
        let left = (0..programme.dwells).filter(|k| chosen.iter().all(|one| one.dwell != *k));
        let told = left.map(|k| information(&programme, &covariance, k));
        let Some(best) = told.max_by(|a, b| a.information.total_cmp(&b.information)) else { break };
        if best.information < LEAST {
            break;
        }
        for row in rows(&programme, best.dwell) {
            let column = programme.columns.row(row).transpose();
            let spread = &covariance * &column;
            let variance = column.dot(&spread).max(0.0) + programme.noise[row].powi(2);
            covariance.ger(-1.0 / variance, &spread, &spread, 1.0);
        }
        chosen.push(best);
    }
    Ok(chosen)
}

/// Nats below which a dwell tells nothing.
const LEAST: f64 = 1e-3;

fn rows(programme: &StackedDesign, dwell: usize) -> impl Iterator<Item = usize> {
    let n = programme.dwells;
    (0..programme.gyros.len()).map(move |j| j * n + dwell)
}

fn information(programme: &StackedDesign, covariance: &DMatrix<f64>, dwell: usize) -> InformativeDwell {
    let ratios = rows(programme, dwell).map(|row| {
        let column = programme.columns.row(row).transpose();
        column.dot(&(covariance * &column)).max(0.0) / programme.noise[row].powi(2)
    });
    let (mut information, mut largest) = (0.0, 0.0_f64);
    for ratio in ratios {
        information += 0.5 * ratio.ln_1p();
        largest = largest.max(ratio);
    }
    InformativeDwell { dwell, information, sd_over_noise: largest.sqrt() }
}
