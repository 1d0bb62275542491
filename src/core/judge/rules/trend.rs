//! `trend`: where a straight course carries the coefficient, how certain that is, and when it reaches the budget.

mod line;

use super::Case;
use super::baseline::{BaselineLevel, LEVEL_RECORDS};
use crate::core::judge::decide::Conformity;
use crate::core::judge::noise::ScatterPrior;
use crate::core::judge::{Finding, Measured, Rule, TrendLimits, Verdict};
use line::{Line, LinePrediction};

/// Cells that a slope is taken over, the longest first: a course that bends within one is looked at over the next.
pub const TREND_CELLS: [usize; 5] = [24, 20, 16, 12, 8];
/// Standard deviations that a bend may have.
const STRAIGHT: f64 = 2.0;

/// The value is |deviation from the baseline that the line leads to| at the horizon, the limit is the budget.
///
/// The line is that of least squares through the last 24 cells, one or two cells that are four standard deviations off
/// the rest left out; where it bends by more than two standard deviations, through the last 20, 16, 12 or 8. Its
/// standard deviation counts the level and the slope together, the baseline, the scatter with its correlation, the walk
/// of the level, now and until the date, and what stations differ by where they are several. A slope is established
/// where it is more than the normal quantile of `limits.confidence` (3.3) times its standard deviation; a step explains
/// it away where that fits the cells better. The horizon is `limits.horizon_days`, but never longer than the cells
/// span: nine days of records do not foretell a quarter. Dates are where the 95 % band of the line crosses the budget;
/// while the course is younger than the window, they are provisional: where the window was shortened, or the line
/// through it begins at the baseline or beyond. `confirmed` is never set, many campaigns have spoken already.
pub(crate) fn trend(case: &Case<'_>, limits: &TrendLimits, fixed: Option<Measured>) -> Verdict {
    let (points, limit) = (case.points(), limits.budget);
    let [longest, .., shortest] = TREND_CELLS;
    if points.len() < shortest {
        return case.too_few(Rule::Trend, limit, points.len(), shortest);
    }
    let level = match BaselineLevel::of(case, fixed, case.history.baseline) {
        Ok(level) => level,
        Err(have) => return case.too_few(Rule::Trend, limit, have, LEVEL_RECORDS),
    };
    let (noise, prior) = (&case.limits.noise, ScatterPrior::of(limit.value, points.iter().map(|point| point.sd)));
    let now = case.now().at;
    let nothing = |deviation: f64, step| {
        let cells = points.len().min(longest);
        let finding = Finding::NoTrend { cells, since: points[points.len() - cells].first, step };
        case.verdict(Rule::Trend, limit, Measured::exact(deviation), Conformity::certain(false), finding)
    };
    let straight = TREND_CELLS.iter().filter(|n| **n <= points.len()).find_map(|n| {
        let line = Line::through(&points[points.len() - n..], noise, prior, case.between_stations());
        let flat = *n == longest && !line.has_slope(limits.confidence);
        (flat || line.bend().abs() <= STRAIGHT).then_some(line)
    });
    let Some(line) = straight else { return nothing(points[points.len() - 1].x - level.level.value, None) };
    if !line.has_slope(limits.confidence) {
        return nothing(line.now() - level.level.value, None);
    }
    if let Some(step) = line.step_that_fits_better() {
        return nothing(line.now() - level.level.value, Some(step));
    }
    let forecast = LinePrediction::of(&line, &level, now);
    let horizon = limits.horizon_days.min(line.span_days());
    let ahead = forecast.at(horizon);
    let finding = Finding::Trend {
        cells: line.cells(),
        since: line.first(),
        until: now,
        per_year: line.slope(),
        deviation: forecast.at(0.0).value,
        horizon_days: horizon,
        reach: forecast.reaches(limit.value).map(|days| days.map(|days| now.plus_days(days))),
        provisional: line.cells() < longest || !forecast.had_begun(line.span_days()),
        of_fleet: noise.of_fleet,
    };
    case.verdict(Rule::Trend, limit, ahead, case.beyond(ahead, limit.value), finding)
        .between_stations(forecast.between_stations(horizon))
}
