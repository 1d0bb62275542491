//! `overdue`: a gyro not calibrated for longer than its interval. The only rule that needs to know what time it is.

use crate::core::judge::decide::Conformity;
use crate::core::judge::{Coefficient, Finding, Limit, Measured, Rule, Verdict};
use crate::core::time::UtcMicros;

/// The value is the days from the gyro's `last` calibration to `now`, the limit is the interval in days.
pub fn overdue(last: UtcMicros, now: UtcMicros, interval_days: Limit) -> Verdict {
    let days = now.days_since(last).max(0.0);
    let undecided = Verdict::undecided(Coefficient::All, Rule::Overdue, interval_days, Finding::Overdue { last });
    Conformity::certain(days > interval_days.value).of(Measured::exact(days), undecided)
}
