//! What judging a group has found.

use crate::core::alert_decision::Alert;
use crate::core::judge::Coefficient;
use crate::pipeline::prelude::*;
use crate::store::HistoryRow;

/// Verdicts by record and gyro number.
pub(crate) type Verdicts = HashMap<(Id, u32), Vec<Verdict>>;

/// What judging a group has found.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    /// On every new record, and on the newest of a gyro where that was judged again.
    pub verdicts: Verdicts,
    /// What was the newest of its gyro, in the order of time: each new record that came in order, else the newest
    /// after all.
    pub newest: Vec<HistoryRow>,
    /// Gyros of which something counts no more.
    pub undone: BTreeMap<u32, Undone>,
    /// Of others records have come late; what fires by all of them, where that was [asked](super::Judge::follow_late).
    pub late: BTreeMap<u32, Option<Firing>>,
}

impl Judged {
    /// What fires of a gyro by all its records, followed in the order of time, where not all came in that order.
    pub fn in_order(&self, gyro: u32) -> Option<&Firing> {
        let undone = || self.undone.get(&gyro)?.fires.as_ref();
        self.late.get(&gyro).and_then(Option::as_ref).or_else(undone)
    }
}

/// What fires of a gyro in the order of time; `fired_at` is the last record that exceeds.
pub(crate) type Firing = HashMap<(Coefficient, Rule), Alert>;

/// What has become of a gyro's alerts now that something counts no more, and who said so, and why.
#[derive(Debug)]
pub(crate) struct Undone {
    /// What would fire if nothing but what counts now had ever come; none where only a bench result was voided.
    pub fires: Option<Firing>,
    /// Of its records that count no more.
    pub gone: Vec<UtcMicros>,
    pub author: String,
    pub reason: String,
}
