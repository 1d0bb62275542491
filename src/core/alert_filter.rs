//! Which alerts are meant: by who asks, and by a silence.

use crate::core::alert_decision::AlertState;
use crate::core::judge::{Coefficient, Rule, Severity};

/// Which alerts are asked for; what is left out does not matter.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AlertFilter {
    pub standing: Option<AlertState>,
    pub gyro: Option<u32>,
    pub coefficient: Option<Coefficient>,
    pub rule: Option<Rule>,
    pub severity: Option<Severity>,
    /// The IMU of the record that was judged last.
    pub imu: Option<String>,
}

/// Which alerts a silence is of; what is left out matches all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Matchers {
    pub serial: Option<String>,
    pub imu: Option<String>,
    pub station: Option<String>,
    pub rule: Option<Rule>,
}
