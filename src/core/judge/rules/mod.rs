//! One rule a file. Each is a function of a [`Case`] and of its limit.

mod agreement;
mod baseline;
mod before_after;
mod case;
mod closure;
mod forecast;
mod group_shift;
mod imu_shift;
mod overdue;
mod range;
mod requirement;
mod rms_successive;
mod shift;
mod step;
mod trend;

pub use agreement::{SourcedResult, agreement};
pub use forecast::{FALSE_ALARMS, ForecastErrors, GyroForecastErrors, forecast};
pub use group_shift::{
    ExplicableVerdict, Group, GroupShiftCriteria, LATELY, NewestCalibration, group_shift, has_grown, in_common,
    is_explained, shift_began,
};
pub use imu_shift::{ImuShiftCriteria, imu_shift};
pub use overdue::overdue;
pub use requirement::requirement;

pub(super) use case::Case;
pub(super) use closure::closure;

use baseline::baseline;
use before_after::before_after;
use range::range;
use rms_successive::rms_successive;
use shift::shift;
use step::step;
use trend::trend;

use crate::core::judge::{DriftLimits, Rule, Verdict};

/// By every rule of D_I or D_S that has a limit.
pub(super) fn of_drift(case: &Case<'_>, drift: &DriftLimits, verdicts: &mut Vec<Verdict>) {
    verdicts.extend(drift.of(Rule::Step).map(|limit| step(case, limit)));
    verdicts.extend(drift.of(Rule::Range).map(|limit| range(case, limit)));
    verdicts.extend(drift.of(Rule::Baseline).map(|limit| baseline(case, limit, drift.fixed_baseline)));
    verdicts.extend(drift.trend.map(|limits| trend(case, &limits, drift.fixed_baseline)));
    verdicts.extend(drift.shift.map(|limits| shift(case, &limits)));
    verdicts.extend(drift.of(Rule::RmsSuccessive).map(|limit| rms_successive(case, limit)));
    verdicts.extend(drift.of(Rule::BeforeAfter).and_then(|limit| before_after(case, limit)));
}
