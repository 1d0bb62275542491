//! The law that the standard errors of a campaign show, for dwells that state none.
//!
//! Of gyro j in dwell k: sem^2 = s_j^2 (1 + rho x) duration^-p, x = (w_I/W)^2 with w_I the rate along the nominal input
//! axis and W the largest rate of the campaign. rho and p are common to all gyros, as one station states them. Each
//! law counts as much as the stated errors lie near to it (Laplace's distribution of their logarithms), and what is
//! filled in is the root of the mean variance over all of them: where duration or rate is not told, it is the wider.

use nalgebra::{DVector, Vector3};

use crate::core::calibrate::growth::Exposure;
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::median::median_of;

/// Values of p.
const FALLS: [f64; 3] = [0.0, 0.5, 1.0];

/// Values of rho, each as likely beforehand as 1/(1 + rho).
const GROWTHS: [f64; 11] = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// Scatter of the logarithms about a law that is none, and the largest that widens what is filled in.
const ROUNDING: f64 = 0.03;
const LARGEST_SCATTER: f64 = 0.5;

/// Standard deviation over mean absolute deviation, of normal errors.
const NORMAL: f64 = 1.2533;

/// What the campaign has of one gyro.
pub(super) struct Stated {
    /// Standard errors by dwell, as far as they are stated.
    pub errors: Vec<Option<f64>>,
    /// Nominal input axis; the whole rate counts where it is not known.
    pub input: Option<Vector3<f64>>,
}

/// What the stated errors of each gyro go by in dwells of these durations and rates (arcsec/s), some of which state them.
pub(super) fn laws(dwells: &[(f64, Vector3<f64>)], gyros: &[Stated]) -> Vec<Vec<f64>> {
    let (durations, rates): (Vec<f64>, Vec<Vector3<f64>>) = dwells.iter().copied().unzip();
    let exposure = |gyro: &Stated| Exposure::of(&rates, &durations, gyro.input.as_ref());
    let shares: Vec<DVector<f64>> = gyros.iter().map(|gyro| exposure(gyro).rate).collect();
    let laws = FALLS.into_iter().flat_map(|fall| GROWTHS.map(|growth| (fall, growth)));
    let tried: Vec<(f64, Vec<Vec<f64>>)> = laws
        .map(|(fall, growth)| {
            let shape = |gyro: usize| {
                let dwells = durations.iter().zip(shares[gyro].iter());
                dwells.map(move |(duration, x)| 0.5 * ((1.0 + growth * x).ln() - fall * duration.ln()))
            };
            let (mut deviations, mut levels) = (Vec::new(), Vec::new());
            for (gyro, stated) in gyros.iter().enumerate() {
                let over: Vec<f64> =
                    stated.errors.iter().zip(shape(gyro)).filter_map(|(sem, law)| Some((*sem)?.ln() - law)).collect();
                let median = median_of(over.iter().copied()).unwrap_or(0.0);
                deviations.extend(over.iter().map(|ln| (ln - median).abs()));
                levels.push(median);
            }
            let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
            let free = deviations.len().saturating_sub(gyros.len()) as f64;
            let scatter = (NORMAL * mean).min(LARGEST_SCATTER);
            // The mean of squares whose logarithms scatter.
            let of_gyro = |(j, level)| shape(j).map(|law| 2.0 * (level + law + scatter * scatter)).collect();
            let log_variances = levels.into_iter().enumerate().map(of_gyro).collect();
            (-free * (mean + ROUNDING).ln() - (1.0 + growth).ln(), log_variances)
        })
        .collect();
    let weights = LogSum::of(&tried.iter().map(|(weight, _)| *weight).collect::<Vec<_>>()).log();
    let usual = |j: usize, k: usize| {
        let all: Vec<f64> = tried.iter().map(|(weight, log_variances)| weight + log_variances[j][k]).collect();
        (0.5 * (LogSum::of(&all).log() - weights)).exp()
    };
    (0..gyros.len()).map(|j| (0..dwells.len()).map(|k| usual(j, k)).collect()).collect()
}
