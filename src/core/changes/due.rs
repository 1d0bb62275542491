//! When a coefficient that ages leaves its budget.
//!
//! With level a and slope b at the newest record and their covariance, the chance that it has left the budget L by t is
//! P(T <= (a + b t - L)/sd(a + b t)) (Fieller 1954); the ends of an interval are the times at which that is its tails.

use super::answer::{Due, YEAR_DAYS};
use super::search::{Level, student};
use crate::core::time::UtcMicros;

/// What a coefficient may differ from its baseline by, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    pub baseline: f64,
    pub limit: f64,
    /// The first records from this instant on made the baseline, by their stations; none where it is stated.
    pub measured_since: Option<UtcMicros>,
}

/// Years beyond which no date is given.
const FARTHEST: f64 = 200.0;

/// The newest record is so many days younger than the row at which `level` stands.
pub(super) fn due(level: &Level, younger: f64, budget: Budget) -> Option<Due> {
    if !level.ages || level.slope == 0.0 {
        return None;
    }
    let sign = level.slope.signum();
    let beyond = sign * (level.value - budget.baseline) - budget.limit;
    let slope = level.slope.abs();
    let [v, w, c] = level.covariance;
    let chance = |t: f64| {
        let sd = (v + t * t * w + 2.0 * t * c).max(f64::MIN_POSITIVE).sqrt();
        student((beyond + slope * t) / sd, level.freedom)
    };
    let when = |p: f64| {
        let (mut early, mut late) = (-FARTHEST, FARTHEST);
        if chance(late) < p || chance(early) > p {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (early + late);
            if chance(middle) < p { early = middle } else { late = middle }
        }
        Some(late * YEAR_DAYS - younger)
    };
    let days = -beyond / slope * YEAR_DAYS - younger;
    (days.abs() < FARTHEST * YEAR_DAYS).then(|| Due {
        days,
        p80: [when(0.1), when(0.9)],
        p95: [when(0.025), when(0.975)],
        calibrate_by: when(0.05),
    })
}
