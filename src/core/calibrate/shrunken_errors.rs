//! Weights where standard errors are themselves estimates of few values each.
//!
//! A standard error of m sub-averages scatters by 1/sqrt(2 (m - 1)) about what it estimates. Weights of its inverse
//! square then favour dwells that happened to scatter little, and residuals over it follow Student's t of m - 1 degrees
//! of freedom: they look like noise with a memory, or like more than noise. Errors that scatter about a law of duration
//! and rate are therefore shrunk to it,
//!
//! ```text
//! sd = law (sem/law)^b,   b = 0, 1/4, 1/2 or 1
//! ```
//!
//! b is whichever has the largest restricted likelihood of the residuals of all gyros: 1 where dwells differ as they
//! state (nothing between it and 1/2, which chance likes to make of 1), near 0 where they do not. The law's mean square
//! is that of the errors, whose squares are without bias.

use nalgebra::DVector;

use super::gyro_fit::GyroFit;
use crate::core::campaign::Campaign;

/// Scatter of standard errors (of their logarithms, about the law) from which on they are doubted: of thirteen
/// sub-averages.
const DOUBTED: f64 = 0.2;

/// ln of likelihood by which residuals have to speak against what is stated, for every gyro but one. Those of one alone
/// are few, and errors shrunk in vain cost it precision only.
const LEAST_GAIN: f64 = 0.5;
/// ln of likelihood from which they clearly do.
const CLEAR_GAIN: f64 = 1.0;

/// b that are tried where errors scatter.
const TRIED: [f64; 3] = [0.0, 0.25, 0.5];

/// Standard errors shrunk to the law that they scatter about.
pub(super) struct ShrunkenErrors {
    /// By gyro and dwell, pulse/s.
    pub sd: Vec<Vec<f64>>,
    /// Scatter of what is stated, where that is clear: standard deviation of its logarithm about the law.
    pub scatter: Option<f64>,
}

/// Standard errors, by gyro and dwell, and the law that they may scatter about, pulse/s.
pub(super) struct ScatteringErrors {
    gyros: Vec<(Vec<f64>, Vec<f64>)>,
    /// Standard deviation of their logarithms about the law.
    scatter: f64,
}

impl ScatteringErrors {
    /// None where no dwell states any, or they hardly scatter.
    pub fn of(campaign: &Campaign) -> Option<Self> {
        let stated: Vec<Vec<f64>> = (0..campaign.gyros.len()).map(|j| campaign.errors_of(j)).collect::<Option<_>>()?;
        if !may_scatter(&stated) {
            return None;
        }
        let laws = campaign.laws_of_errors()?;
        let gyros: Vec<(Vec<f64>, Vec<f64>)> = stated
            .into_iter()
            .zip(laws)
            .map(|(sem, law)| {
                let law = with_mean_square(law, &sem);
                (sem, law)
            })
            .collect();
        let all = gyros.iter().flat_map(|(sem, law)| sem.iter().zip(law));
        let logs = DVector::from_vec(all.map(|(sem, law)| (sem / law).ln()).collect());
        let scatter = logs.variance().sqrt();
        (scatter >= DOUBTED).then_some(Self { gyros, scatter })
    }

    /// law (sem/law)^b by gyro and dwell, pulse/s.
    fn shrunken(&self, b: f64) -> Vec<Vec<f64>> {
        let of_dwell = |(sem, law): (&f64, &f64)| law * (sem / law).powf(b);
        self.gyros.iter().map(|(sem, law)| sem.iter().zip(law).map(of_dwell).collect()).collect()
    }

    /// Those of the b below 1 that is likeliest by more than every gyro but one is to tell; `likelihood` is the logarithm
    /// of that of the residuals.
    pub fn likeliest(&self, likelihood: impl Fn(&[Vec<f64>]) -> Option<f64>) -> Option<ShrunkenErrors> {
        let likelihood = |b: f64| likelihood(&self.shrunken(b));
        let stated = likelihood(1.0)?;
        let least = LEAST_GAIN * (self.gyros.len() - 1) as f64;
        let tried = TRIED.into_iter().filter_map(|b| Some((b, likelihood(b)? - stated)));
        let (b, gain) = tried.filter(|(_, gain)| *gain > least).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(ShrunkenErrors { sd: self.shrunken(b), scatter: (gain > CLEAR_GAIN).then_some(self.scatter) })
    }
}

/// Whether standard errors, by gyro and dwell, scatter so much about their own mean that they may about a law.
pub(super) fn may_scatter(stated: &[Vec<f64>]) -> bool {
    let of_gyro = |sems: &Vec<f64>| {
        let logs = DVector::from_iterator(sems.len(), sems.iter().map(|sem| sem.ln()));
        logs.variance()
    };
    stated.iter().map(of_gyro).sum::<f64>() > DOUBTED * DOUBTED * stated.len() as f64
}

/// None where standard errors hardly scatter, or residuals follow them. `fits` are those of the errors as stated.
pub(super) fn shrunken(campaign: &Campaign, fits: &[GyroFit]) -> Option<ShrunkenErrors> {
    let is_exact = |fit: &GyroFit| fit.left().0.norm() == 0.0;
    let errors = ScatteringErrors::of(campaign).filter(|_| !fits.iter().any(is_exact))?;
    errors.likeliest(|sd| {
        let of_gyro = |(fit, sd): (&GyroFit, &Vec<f64>)| {
            let found = fit.fitted().independent(&DVector::from_column_slice(sd), true);
            found.map(|(log, _)| log)
        };
        fits.iter().zip(sd).map(of_gyro).sum::<Option<f64>>()
    })
}

/// A law with the mean square of the errors that scatter about it.
fn with_mean_square(law: Vec<f64>, sem: &[f64]) -> Vec<f64> {
    let times = (sem.iter().zip(&law).map(|(sem, law)| (sem / law).powi(2)).sum::<f64>() / sem.len() as f64).sqrt();
    law.into_iter().map(|law| law * times).collect()
}
