//! Silences of many alerts: which alerts match, and how they read.

use super::body::{NameLookup, Origin, finding_of};
use crate::core::alert_filter::Matchers;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow, Remark, SilenceRow};
use crate::wire::body::{ToBody, bodies};
use crate::wire::silence::{EndedSilenceBody, MatchersBody, MatchingSilenceBody};
use crate::wire::time;

/// Silences in force at a time.
pub(super) const MOST_SILENCES: u32 = 1000;

/// Those in force.
#[derive(Debug, Default)]
pub(super) struct Silences(pub(super) Vec<SilenceRow>);

impl Silences {
    pub async fn load(store: &Store, now: UtcMicros) -> Result<Self, StoreError> {
        store::silence::list(store, Some(now), MOST_SILENCES).await.map(Self)
    }

    /// Those whose time has come are in force no more.
    pub fn pass(&mut self, now: UtcMicros) {
        self.0.retain(|silence| now < silence.until);
    }

    /// What silences the alert of a verdict the longest: the silence, and until when.
    pub fn of(
        &self,
        of: AlertOf,
        verdict: &Verdict,
        origin: &Origin,
        naming: &NameLookup<'_>,
        now: UtcMicros,
    ) -> Option<((Id, Remark), UtcMicros)> {
        if self.0.is_empty() {
            return None;
        }
        let finding = naming.finding(verdict, origin);
        self.longest((&naming.serial(of), finding.imu.as_deref(), finding.station.as_deref(), verdict.rule), now)
    }

    pub fn of_row(&self, row: &AlertRow, naming: &NameLookup<'_>, now: UtcMicros) -> Option<((Id, Remark), UtcMicros)> {
        // A finding that cannot be read names no place: the next look at the alert names the damage.
        let finding = finding_of(row).ok();
        let place = finding.as_ref().map(|finding| (finding.imu.as_deref(), finding.station.as_deref()));
        let (imu, station) = place.unwrap_or_default();
        self.longest((&naming.serial(row.of), imu, station, row.rule), now)
    }

    fn longest(
        &self,
        (serial, imu, station, rule): (&str, Option<&str>, Option<&str>, Rule),
        now: UtcMicros,
    ) -> Option<((Id, Remark), UtcMicros)> {
        let fits = |wanted: &Option<String>, is: Option<&str>| wanted.is_none() || wanted.as_deref() == is;
        let matching = self.0.iter().filter(|SilenceRow { matchers, until, .. }| {
            now < *until
                && fits(&matchers.serial, Some(serial))
                && fits(&matchers.imu, imu)
                && fits(&matchers.station, station)
                && matchers.rule.is_none_or(|wanted| wanted == rule)
        });
        matching.max_by_key(|silence| silence.until).map(|one| ((one.id, one.said.clone()), one.until))
    }
}

bodies! {
    MatchersBody of Matchers: serial, imu, station, rule;
    EndedSilenceBody of Remark: by, reason, at;
}

pub(super) fn body(row: &SilenceRow, now: UtcMicros) -> MatchingSilenceBody {
    MatchingSilenceBody {
        id: row.id.to_string(),
        matchers: row.matchers.to_body(),
        until: time::format(row.until),
        by: row.said.by.clone(),
        reason: row.said.reason.clone(),
        at: time::format(row.said.at),
        active: row.ended.is_none() && now < row.until,
        ended: row.ended.to_body(),
    }
}
