//! History and limits in, verdicts with their reasons out.
//!
//! A verdict judges one record of one gyro by one rule. Rules are pure functions of a bounded stretch of history
//! ([`history::Need`] says how much), so a record that arrives late, or is voided, is dealt with by judging the records
//! after it again. No words are made here: [`Verdict::messages`] says what there is to say, by code and parameters.

pub mod history;
pub mod limits;

mod budget_projection;
mod cells;
mod coefficient;
mod decide;
mod event;
mod extremes;
mod load;
mod noise;
mod range_summary;
mod reason;
mod rule;
mod rules;
mod sample;
mod series;
mod suggestion;
mod verdict;

pub use budget_projection::{BudgetCrossing, BudgetProjection};
pub use coefficient::Coefficient;
pub use event::{Event, FixedLevels, Mark, baseline_since, reset_before, stated_level};
pub use history::{History, Need};
pub use limits::{DriftLimits, Limit, LimitKey, Limits, ShiftLimits, TrendLimits};
pub use load::Load;
pub use noise::{FleetNoise, NoiseParameters, Spacing, fit_fleet};
pub use range_summary::Older;
pub use reason::{digits, sd_digits};
pub use rule::{FigureSource, Finding, LimitKind, Rule, Unit, Unseen};
pub use rules::{
    ExplicableVerdict, FALSE_ALARMS, ForecastErrors, Group, GroupShiftCriteria, GyroForecastErrors, ImuShiftCriteria,
    LATELY, NewestCalibration, SourcedResult, agreement, forecast, group_shift, has_grown, imu_shift, in_common,
    is_explained, overdue, requirement, shift_began,
};
pub use sample::{BASELINE_RECORDS, Measured, Sample, Seat};
pub use series::Series;
pub use suggestion::{Suggestion, SuggestionInput, suggest};
pub use verdict::{Severity, State, Status, Verdict};

use cells::Window;
use rules::Case;

/// Judges record `k` of a history by every rule of that history that has a limit, appending to `verdicts`.
///
/// Used for the latest record as for any earlier one that has to be judged again: records after `k` have no part in it.
/// [`requirement`], [`agreement`] and [`overdue`] are judged apart: they need no history.
///
/// ```
/// use gyrowatch::core::judge::{Coefficient, History, Limits, Measured, Rule, Sample, Seat, Series, Status, judge};
/// use gyrowatch::core::time::UtcMicros;
///
/// // Four calibrations of one gyro, 30 days apart; at the last one D_I is 0.02 deg/(h g0) higher.
/// let sample = |day: f64, d_i: f64| {
///     let d = [d_i, 4.618, 0.004].map(|value| Measured { value, sd: Some(3e-4) });
///     Sample { at: UtcMicros(0).plus_days(20_000.0 + day), seat: Seat::default(), station: 0, d }
/// };
/// let samples = vec![sample(0.0, 2.957), sample(30.0, 2.957), sample(60.0, 2.958), sample(90.0, 2.977)];
/// let (series, mut verdicts) = (Series::new(samples, vec![]), vec![]);
/// judge(&History::whole(&series, 3), 3, &Limits::from_budget(0.01), &mut verdicts);
/// let step = verdicts.iter().find(|v| v.rule == Rule::Step && v.coefficient == Coefficient::DI).unwrap();
/// assert_eq!(step.status(), Status::Unconfirmed); // beyond the budget, and a second campaign is to confirm it
/// ```
///
/// # Panics
/// Where `k` is not an index of `history.samples`.
pub fn judge(history: &History<'_>, k: usize, limits: &Limits, verdicts: &mut Vec<Verdict>) {
    let window = &Window::at(history.samples, k);
    let case = |coefficient, column| Case { history, k, coefficient, column, limits, window };
    rules::of_drift(&case(Coefficient::DI, 0), &limits.d_i, verdicts);
    rules::of_drift(&case(Coefficient::DS, 1), &limits.d_s, verdicts);
    verdicts.extend(limits.closure.map(|limit| rules::closure(&case(Coefficient::DO, 2), limit)));
}

#[cfg(test)]
mod tests;
