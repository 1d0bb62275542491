//! How far the outputs can be trusted: standard errors as given, corrected by repeats, or the residuals themselves.
//!
//! All scales are squared ratios to the standard deviations used as weights (the standard errors, or 1 pulse/s
//! without any).
//!
//! * **Standard errors and repeats.** The spread of repeats (pure error) estimates the square of a factor f that is
//!   common to all standard errors. Repeats are few, so what the station states counts too, as
//!   [`PRIOR_DOF`] degrees of freedom in favour of f = 1: f^2 = (chi2 + PRIOR_DOF)/(dof + PRIOR_DOF). The repeats of
//!   all gyros are pooled (one electronics, one procedure) unless one gyro's differ beyond chance.
//! * **Standard errors alone.** Taken at their word, unless the residuals exceed them beyond chance: then f^2 is
//!   the reduced chi-square of all gyros (the Birge ratio), which covers what the model leaves out.
//! * **Neither standard errors.** Weights are equal. The residuals give the scale; where repeats say that the model
//!   leaves something out (lack of fit), the repeats alone give it.
//!
//! An estimated scale makes errors follow a t distribution. Standard deviations are reported as those of that t:
//! a factor sqrt(dof/(dof - 2)), so that rms(error/sd) is 1 whatever the dof. Below three dof no such deviation
//! exists and none is reported.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use super::repeats::PureError;

/// Weight of the stated standard errors against repeats: as much as four repeats. A station's standard errors are
/// right to some 35 % (1/sqrt(2 x 4)) before any repeat is seen.
pub const PRIOR_DOF: f64 = 4.0;

/// Chance below which one gyro's repeats no longer pool with the others', or residuals overrule standard errors.
const BEYOND_CHANCE: f64 = 1e-3;
/// Chance below which repeats say that the model leaves something out.
const LACK_OF_FIT: f64 = 0.05;

/// Where the scale of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Standard errors at their word.
    Sem,
    /// Standard errors times a factor from repeats.
    SemAndRepeats,
    /// Standard errors times the Birge ratio.
    SemAndResiduals,
    /// Repeats alone, equal weights.
    Repeats,
    /// Residuals alone, equal weights.
    Residuals,
    /// Nothing: no standard errors, no repeats, no residual degree of freedom.
    None,
}

impl Source {
    pub fn name(self) -> &'static str {
        match self {
            Source::Sem => "sem",
            Source::SemAndRepeats => "repeats+sem",
            Source::SemAndResiduals => "residuals+sem",
            Source::Repeats => "repeats",
            Source::Residuals => "residuals",
            Source::None => "none",
        }
    }
}

/// The noise scale of one gyro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    pub source: Source,
    /// f: what the weights' standard deviations are multiplied by; a factor on the standard errors, or the noise of
    /// one dwell in pulse/s where there are none. None without a source.
    pub factor: Option<f64>,
    /// Standard deviation of the factor; zero where standard errors are taken at their word.
    pub factor_sd: Option<f64>,
    /// Degrees of freedom behind the factor, infinite where it is taken at its word.
    pub dof: f64,
    pub pure_error: PureError,
}

impl Noise {
    fn of(source: Source, squared: f64, dof: f64, pure_error: PureError) -> Self {
        let factor = squared.sqrt();
        Self { source, factor: Some(factor), factor_sd: Some(factor / (2.0 * dof).sqrt()), dof, pure_error }
    }

    /// What a covariance for the weights as given is multiplied by: f^2 dof/(dof - 2).
    pub fn covariance_scale(&self) -> Option<f64> {
        let f = self.factor?;
        let t_variance = if self.dof.is_infinite() { 1.0 } else { self.dof / (self.dof - 2.0) };
        (self.dof > 2.0).then_some(f * f * t_variance)
    }
}

/// What the fits and the repeats of one gyro say, with weights as given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    pub chi2: f64,
    pub dof: usize,
    pub pure_error: PureError,
}

/// The noise scale of every gyro, from that of all.
pub fn noise(evidence: &[Evidence], has_sem: bool) -> Vec<Noise> {
    if !has_sem {
        return evidence.iter().map(unweighted).collect();
    }
    let pooled = evidence.iter().fold(PureError::default(), |sum, e| sum.plus(e.pure_error));
    if pooled.dof > 0 {
        return evidence.iter().map(|e| with_repeats(e.pure_error, pooled)).collect();
    }
    let (chi2, dof) = evidence.iter().fold((0.0, 0), |(c, d), e| (c + e.chi2, d + e.dof));
    let exceeded = chi2_tail(chi2, dof).is_some_and(|p| p < BEYOND_CHANCE);
    let of = |e: &Evidence| match exceeded {
        true => Noise::of(Source::SemAndResiduals, chi2 / dof as f64, dof as f64, e.pure_error),
        false => Noise::of(Source::Sem, 1.0, f64::INFINITY, e.pure_error),
    };
    evidence.iter().map(of).collect()
}

fn with_repeats(own: PureError, pooled: PureError) -> Noise {
    let others = PureError { chi2: (pooled.chi2 - own.chi2).max(0.0), dof: pooled.dof - own.dof };
    let odd = f_tail(own, others).is_some_and(|p| p.min(1.0 - p) < 0.5 * BEYOND_CHANCE);
    let used = if odd { own } else { pooled };
    let dof = used.dof as f64 + PRIOR_DOF;
    Noise::of(Source::SemAndRepeats, (used.chi2 + PRIOR_DOF) / dof, dof, own)
}

fn unweighted(e: &Evidence) -> Noise {
    let repeats = e.pure_error;
    let rest = PureError { chi2: (e.chi2 - repeats.chi2).max(0.0), dof: e.dof.saturating_sub(repeats.dof) };
    if f_tail(rest, repeats).is_some_and(|p| p < LACK_OF_FIT) {
        return Noise::of(Source::Repeats, repeats.chi2 / repeats.dof as f64, repeats.dof as f64, repeats);
    }
    if e.dof == 0 {
        return Noise { source: Source::None, factor: None, factor_sd: None, dof: 0.0, pure_error: repeats };
    }
    Noise::of(Source::Residuals, e.chi2 / e.dof as f64, e.dof as f64, repeats)
}

/// P(chi-square of `dof` > `chi2`); none without degrees of freedom.
pub fn chi2_tail(chi2: f64, dof: usize) -> Option<f64> {
    (dof > 0).then(|| ChiSquared::new(dof as f64).expect("positive dof").sf(chi2))
}

/// P(F > the ratio of the two mean squares); none where either has no dof, or the denominator is zero.
pub fn f_tail(numerator: PureError, denominator: PureError) -> Option<f64> {
    if numerator.dof == 0 || denominator.dof == 0 || denominator.chi2 <= 0.0 {
        return None;
    }
    let (n, d) = (numerator.dof as f64, denominator.dof as f64);
    let ratio = (numerator.chi2 / n) / (denominator.chi2 / d);
    Some(FisherSnedecor::new(n, d).expect("positive dof").sf(ratio))
}
