//! How far the outputs can be trusted: standard errors as given, corrected by repeats, or the residuals themselves.
//!
//! All scales are squared ratios to the standard deviations used as weights (the standard errors, or 1 pulse/s
//! without any).
//!
//! * **Standard errors and repeats.** The spread of repeats (pure error) estimates the square of a factor f that is
//!   common to all standard errors. Repeats are few, so what the station states counts too, as
//!   [`PRIOR_DOF`] degrees of freedom in favour of f = 1: f^2 = (chi2 + PRIOR_DOF)/(dof + PRIOR_DOF). The repeats of
//!   all gyros are pooled (one electronics, one procedure) unless one gyro scatters in a way of its own; what is
//!   stated of all does not count for that one. Where the residuals of the fit scatter no more than that (lack of fit
//!   is not significant), they join in, and f is known well.
//! * **Standard errors alone.** Taken at their word, unless the residuals exceed them beyond chance: then f^2 is
//!   the reduced chi-square of all gyros (the Birge ratio), which covers what the model leaves out.
//! * **No standard errors.** Weights are equal. The residuals give the scale, and how it goes with rate and duration
//!   ([`super::growth`]); where repeats say that the model leaves something out (lack of fit), the repeats alone give
//!   it.
//!
//! Standard errors are estimates themselves. Where those of the static dwells scatter by c (relative) about one
//! another, weights made of them are not the best ones: to the order of c^2 the estimates' variance is 1 + 4 c^2 of
//! the least possible, while the covariance promises 1/(1 + 3 c^2) of it. Residuals show the second, so f^2 holds it;
//! the first is put on the covariance. Above [`LARGEST_SCATTER`] the scatter is taken for real differences of noise.
//!
//! An estimated scale makes errors follow a t distribution. Standard deviations are reported as those of that t:
//! a factor sqrt(dof/(dof - 2)), so that rms(error/sd) is 1 whatever the dof. Below three dof no such deviation
//! exists and none is reported.

use statrs::function::gamma::ln_gamma;

use crate::core::campaign::repeats::PureError;
use crate::core::named::named;
use crate::core::numerics::tails::{chi2_tail, f_tail};

/// Weight of the stated standard errors against repeats: as much as four repeats. A station's standard errors are
/// right to some 35 % (1/sqrt(2 x 4)) before any repeat is seen.
pub const PRIOR_DOF: f64 = 4.0;

/// Largest relative scatter of standard errors that passes for their own uncertainty.
pub const LARGEST_SCATTER: f64 = 0.25;

/// Chance below which one gyro's repeats do not pool with the others', residuals overrule standard errors, or
/// repeats overrule residuals. Small on purpose: a scale that is chosen because it came out small is too small.
const BEYOND_CHANCE: f64 = 1e-3;

/// Chance below which residuals scatter more than repeats and standard errors allow, and are kept out of the noise.
const LACK_OF_FIT: f64 = 0.05;

named! {
/// Where the scale of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// Standard errors at their word.
    Sem = "sem",
    /// Standard errors times a factor from repeats.
    SemAndRepeats = "repeats+sem",
    /// The same, confirmed and sharpened by residuals that agree.
    SemRepeatsAndResiduals = "repeats+residuals+sem",
    /// Standard errors times the Birge ratio.
    SemAndResiduals = "residuals+sem",
    /// Repeats alone, equal weights.
    Repeats = "repeats",
    /// Residuals alone, equal weights.
    Residuals = "residuals",
    /// Nothing: no standard errors, no repeats, no residual degree of freedom.
    None = "none",
}
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseScale {
    pub source: NoiseSource,
    /// f: what the weights' standard deviations are multiplied by; a factor on the standard errors, or the noise of
    /// one dwell in pulse/s where there are none. None without a source.
    pub factor: Option<f64>,
    /// Standard deviation of the factor; zero where standard errors are taken at their word.
    pub factor_sd: Option<f64>,
    /// Degrees of freedom behind the factor, infinite where it is taken at its word.
    pub dof: f64,
    pub pure_error: PureError,
    /// What residuals are held against where repeats speak: sum of squares and degrees of freedom in which they have
    /// no part.
    repeated: (f64, f64),
    /// c: relative scatter of the static dwells' standard errors about one another; zero without any, or where it
    /// is too large to be their own uncertainty.
    pub sem_scatter: f64,
}

impl NoiseScale {
    fn of(source: NoiseSource, squared: f64, dof: f64, pure_error: PureError) -> Self {
        let factor = squared.sqrt();
        let factor_sd = Some(factor / (2.0 * dof).sqrt());
        let repeated = (pure_error.chi2, pure_error.dof as f64);
        Self { source, factor: Some(factor), factor_sd, dof, pure_error, repeated, sem_scatter: 0.0 }
    }

    fn held_against(self, repeated: (f64, f64)) -> Self {
        Self { repeated, ..self }
    }

    /// The same with the scatter of the gyro's standard errors.
    pub fn with_scatter(self, scatter: f64) -> Self {
        Self { sem_scatter: if scatter <= LARGEST_SCATTER { scatter } else { 0.0 }, ..self }
    }

    /// f^2 without what the model leaves out: the Birge ratio covers that too.
    pub fn floor(&self) -> Option<f64> {
        if self.source == NoiseSource::SemAndResiduals { Some(1.0) } else { self.factor.map(|f| f * f) }
    }

    /// What a covariance for the weights as given is multiplied by: f^2 dof/(dof - 2) (1 + 4 c^2).
    pub fn covariance_scale(&self) -> Option<f64> {
        let f = self.factor?;
        (self.dof > 2.0).then_some(f * f * t_variance(self.dof) * (1.0 + 4.0 * self.sem_scatter.powi(2)))
    }

    /// What the variance of one output by the weights as given is multiplied by: f^2 dof/(dof - 2), and (1 + 3 c^2)
    /// where no residuals have shown that.
    pub fn output_scale(&self) -> Option<f64> {
        let f = self.factor?;
        let unseen = if self.source == NoiseSource::Sem { 3.0 * self.sem_scatter.powi(2) } else { 0.0 };
        (self.dof > 2.0).then_some(f * f * t_variance(self.dof) * (1.0 + unseen))
    }

    /// Chance of residuals as large as these if the model is right: against the standard errors as stated
    /// (chi-square), or against repeats, with what is stated where there is that (F).
    pub fn p_value(&self, evidence: &Evidence) -> Option<f64> {
        match self.source {
            NoiseSource::Sem | NoiseSource::SemAndResiduals => chi2_tail(evidence.chi2, evidence.dof),
            NoiseSource::None => None,
            _ => mean_squares_tail(evidence.lack_of_fit(), self.repeated),
        }
    }

    /// Where residuals exceed the noise (p < 0.001), the Birge ratio R = sqrt(chi2/dof)/f (Phys. Rev. 40, 1932) says by
    /// how much: 1 - 1/f^2 of the variance where f is that ratio itself, R^2 - 1 beside it where f is of repeats.
    /// `is_other_noise`: what exceeds it is noise of another kind, and in the variance as such.
    pub fn share(&self, evidence: &Evidence, is_other_noise: bool) -> Share {
        let (statistical, discrepancy) = match (self.source, self.p_value(evidence), self.factor, evidence.residual) {
            (_, None, ..) | (_, _, None, _) | (.., None) => (1.0, None),
            (_, Some(p), ..) if p >= BEYOND_CHANCE && self.source != NoiseSource::SemAndResiduals => (1.0, Some(0.0)),
            _ if is_other_noise => (1.0, Some(0.0)),
            (NoiseSource::SemAndResiduals, _, Some(f), _) => (1.0 / (f * f), Some(1.0 - 1.0 / (f * f))),
            (_, _, Some(f), Some((squared, _))) => (1.0, Some((squared / (f * f) - 1.0).max(0.0))),
        };
        Share { statistical, discrepancy }
    }
}

/// Variance of a t distribution: of an error over its estimated standard deviation; above 2 degrees of freedom.
pub fn t_variance(dof: f64) -> f64 {
    if dof.is_infinite() { 1.0 } else { dof / (dof - 2.0) }
}

/// How the variance of a fit is shared between noise and what the model leaves out; over that variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    pub statistical: f64,
    /// In the variance already where the two add up to one, beside it otherwise. None where nothing tests the fit.
    pub discrepancy: Option<f64>,
}

/// Relative scatter of standard errors given with their dwells' durations: the standard deviation of
/// ln(sem sqrt(duration)), as means over longer times scatter less. Zero for fewer than five.
pub fn sem_scatter(sems: impl Iterator<Item = (f64, f64)>) -> f64 {
    let logs: Vec<f64> = sems.map(|(sem, duration)| (sem * duration.sqrt()).ln()).collect();
    if logs.len() < 5 {
        return 0.0;
    }
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (logs.len() - 1) as f64).sqrt()
}

/// What the fit and the repeats of one gyro say, with standard deviations as given (or relative ones, without).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    pub chi2: f64,
    pub dof: usize,
    pub pure_error: PureError,
    /// Estimate of f^2 from the residuals, and its degrees of freedom; the reduced chi-square and `dof` unless the
    /// variances are unequal and the weights are not.
    pub residual: Option<(f64, f64)>,
}

impl Evidence {
    /// Of a fit whose weights are as its variances.
    pub fn of(chi2: f64, dof: usize, pure_error: PureError) -> Self {
        let residual = (dof > 0).then(|| (chi2 / dof as f64, dof as f64));
        Self { chi2, dof, pure_error, residual }
    }

    fn plus(&self, other: &Self) -> Self {
        Self::of(self.chi2 + other.chi2, self.dof + other.dof, self.pure_error.plus(other.pure_error))
    }

    /// What the residuals hold beyond the spread of repeats: sum of squares, dof.
    pub fn lack_of_fit(&self) -> (f64, f64) {
        let dof = self.dof.saturating_sub(self.pure_error.dof);
        ((self.chi2 - self.pure_error.chi2).max(0.0), dof as f64)
    }
}

/// The noise scale of every gyro, from that of all.
pub fn noise(evidence: &[Evidence], has_sem: bool) -> Vec<NoiseScale> {
    if !has_sem {
        return evidence.iter().map(unweighted).collect();
    }
    let alone = alone(evidence);
    let of = |(j, e): (usize, &Evidence)| {
        let is_peer = |i: &usize| *i == j || !(alone[*i] || alone[j]);
        let pooled = (0..evidence.len()).filter(is_peer).map(|i| evidence[i]).reduce(|sum, e| sum.plus(&e))?;
        if pooled.pure_error.dof > 0 {
            return Some(with_repeats(e, &pooled, if alone[j] { 0.0 } else { PRIOR_DOF }));
        }
        let (chi2, dof) = (pooled.chi2, pooled.dof);
        Some(match chi2_tail(chi2, dof).is_some_and(|p| p < BEYOND_CHANCE) {
            true => NoiseScale::of(NoiseSource::SemAndResiduals, chi2 / dof as f64, dof as f64, e.pure_error),
            false => NoiseScale::of(NoiseSource::Sem, 1.0, f64::INFINITY, e.pure_error),
        })
    };
    evidence.iter().enumerate().filter_map(of).collect()
}

/// Which gyros scatter in a way of their own: none, one, or every one, whichever is likeliest by the residuals, with
/// the scale integrated out. The one electronics and procedure that all have in common speak for none.
fn alone(evidence: &[Evidence]) -> Vec<bool> {
    const ALIKE: f64 = 0.8;
    let log_likelihood = |alone: &[bool]| {
        let of_scale = |(chi2, dof): (f64, f64)| {
            let a = 0.5 * (dof + PRIOR_DOF);
            ln_gamma(a) - ln_gamma(0.5 * PRIOR_DOF) + 0.5 * PRIOR_DOF * PRIOR_DOF.ln() - a * (PRIOR_DOF + chi2).ln()
        };
        let sums = |e: &Evidence| (e.chi2, e.dof as f64);
        let own: f64 = evidence.iter().zip(alone).filter(|(_, alone)| **alone).map(|(e, _)| of_scale(sums(e))).sum();
        let rest = evidence.iter().zip(alone).filter(|(_, alone)| !**alone).map(|(e, _)| sums(e));
        own + of_scale(rest.fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1)))
    };
    let n = evidence.len();
    let none = vec![false; n];
    let one = (0..n).map(|j| (0..n).map(|i| i == j).collect());
    let others: Vec<Vec<bool>> = one.chain([vec![true; n]]).filter(|_| n > 1).collect();
    let least = log_likelihood(&none) - ((1.0 - ALIKE) / ALIKE / others.len().max(1) as f64).ln();
    let likelier = others.into_iter().map(|alone| (log_likelihood(&alone), alone)).filter(|(log, _)| *log > least);
    likelier.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(none, |(_, alone)| alone)
}

/// A sum of squares over standard errors, and its degrees of freedom, with what is stated counted in.
pub fn with_stated(chi2: f64, dof: f64) -> (f64, f64) {
    (chi2 + PRIOR_DOF, dof + PRIOR_DOF)
}

/// `prior` degrees of freedom speak for what is stated.
fn with_repeats(own: &Evidence, pooled: &Evidence, prior: f64) -> NoiseScale {
    let (mine, all) = (own.pure_error, pooled.pure_error);
    let others = (all.chi2 - mine.chi2, (all.dof - mine.dof) as f64);
    let odd =
        mean_squares_tail((mine.chi2, mine.dof as f64), others).is_some_and(|p| p.min(1.0 - p) < 0.5 * BEYOND_CHANCE);
    let used = if odd { own } else { pooled };
    let stated = (used.pure_error.chi2 + prior, used.pure_error.dof as f64 + prior);
    let rest = used.lack_of_fit();
    if rest.1 > 0.0 && mean_squares_tail(rest, stated).is_some_and(|p| p >= LACK_OF_FIT) {
        let (chi2, dof) = (stated.0 + rest.0, stated.1 + rest.1);
        return NoiseScale::of(NoiseSource::SemRepeatsAndResiduals, chi2 / dof, dof, mine).held_against(stated);
    }
    NoiseScale::of(NoiseSource::SemAndRepeats, stated.0 / stated.1, stated.1, mine).held_against(stated)
}

fn unweighted(e: &Evidence) -> NoiseScale {
    let repeats = e.pure_error;
    let spread = (repeats.chi2, repeats.dof as f64);
    if mean_squares_tail(e.lack_of_fit(), spread).is_some_and(|p| p < BEYOND_CHANCE) {
        return NoiseScale::of(NoiseSource::Repeats, spread.0 / spread.1, spread.1, repeats);
    }
    match e.residual {
        Some((squared, dof)) => NoiseScale::of(NoiseSource::Residuals, squared, dof, repeats),
        None => {
            let none = NoiseScale::of(NoiseSource::None, 0.0, 0.0, repeats);
            NoiseScale { factor: None, factor_sd: None, ..none }
        }
    }
}

/// How many times the stated standard errors are too large for the scatter of the dwells: sqrt(dof/chi2), where the
/// residuals are smaller by more than standard errors are usually wrong and chance would have it once in a million
/// campaigns.
pub fn overstated(chi2: f64, dof: usize) -> Option<f64> {
    const USUAL: f64 = 0.5;
    const CHANCE: f64 = 1e-6;
    let less = chi2_tail(chi2, dof)? > 1.0 - CHANCE && chi2 < USUAL * dof as f64;
    less.then(|| (dof as f64 / chi2).sqrt())
}

/// P(F > the ratio of the two mean squares), each given as (sum of squares, dof); none where either has no dof, or
/// the denominator is zero.
pub fn mean_squares_tail(numerator: (f64, f64), denominator: (f64, f64)) -> Option<f64> {
    let ratio = (numerator.0 / numerator.1) / (denominator.0 / denominator.1);
    let are_there = numerator.1 > 0.0 && denominator.1 > 0.0 && denominator.0 > 0.0 && !ratio.is_nan();
    are_there.then(|| f_tail(ratio, numerator.1, denominator.1))
}

#[cfg(test)]
mod tests;
