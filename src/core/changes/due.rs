//! When a coefficient that ages leaves its budget.
//!
//! With level a and slope b at the newest record and their covariance, the chance that it has left the budget L by t is
//! P(T <= (a + b t - L)/sd(a + b t)) (Fieller 1954); the ends of an interval are the times at which that is its tails.
//! Where it is not known when the ageing began, that is the mean over the instants, weighted by their likelihoods.

use super::answer::{Due, YEAR_DAYS};
use super::search::NewestLevel;
use crate::core::numerics::bisection::bisect;
use crate::core::numerics::tails::t_cdf;
use crate::core::time::UtcMicros;

/// What a coefficient may differ from its baseline by, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftBudget {
    pub baseline: f64,
    pub limit: f64,
    /// The first records from this instant on made the baseline, by their stations; none where it is stated.
    pub measured_since: Option<UtcMicros>,
}

/// Years beyond which no date is given.
const FARTHEST: f64 = 200.0;

/// `levels` with their weights, that of what is named first. The newest record is so many days younger than the row at
/// which they stand.
pub(super) fn due(levels: &[(f64, NewestLevel)], younger: f64, budget: DriftBudget) -> Option<Due> {
    let (_, first) = levels.first().filter(|(_, first)| first.ages && first.slope != 0.0)?;
    let sign = first.slope.signum();
    let whole: f64 = levels.iter().map(|(weight, _)| weight).sum();
    let chance = |t: f64| {
        let of = |(weight, level): &(f64, NewestLevel)| {
            let [v, w, c] = level.covariance;
            let sd = (v + t * t * w + 2.0 * t * c).max(f64::MIN_POSITIVE).sqrt();
            let beyond = sign * (level.value + level.slope * t - budget.baseline) - budget.limit;
            weight * t_cdf(beyond / sd, level.freedom)
        };
        levels.iter().map(of).sum::<f64>() / whole
    };
    let when = |p: f64| {
        if chance(FARTHEST) < p || chance(-FARTHEST) > p {
            return None;
        }
        let (_, years) = bisect(-FARTHEST, FARTHEST, 60, |t| chance(t) < p);
        Some(years * YEAR_DAYS - younger)
    };
    let days = when(0.5)?;
    Some(Due { days, p80: [when(0.1), when(0.9)], p95: [when(0.025), when(0.975)], calibrate_by: when(0.05) })
}
