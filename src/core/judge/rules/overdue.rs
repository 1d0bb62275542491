//! `overdue`: a gyro not calibrated for longer than its interval. The only rule that needs to know what time it is.

use crate::core::judge::decide::plain;
use crate::core::judge::limits::Limit;
use crate::core::judge::{Coefficient, Finding, Rule, Verdict};
use crate::core::time::UtcMicros;

/// The value is the days from the gyro's `last` calibration to `now`, the limit is the interval in days.
pub fn overdue(last: UtcMicros, now: UtcMicros, interval_days: Limit) -> Verdict {
    let days = now.days_since(last).max(0.0);
    Verdict {
        coefficient: Coefficient::All,
        rule: Rule::Overdue,
        state: plain(days, interval_days.value),
        value: Some(days),
        limit: interval_days.value,
        limit_from: interval_days.from,
        sd: None,
        probability: None,
        confirmed: false,
        finding: Finding::Overdue { last },
    }
}
