//! Alerts and their verdicts in the words that clients and hooks read.

use crate::core::judge::{Severity, State, Status};
use crate::core::mounting::Slot;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow, NewName, Remark, Table, Tables};
use crate::wire::alert::{AcknowledgementBody, AlertBody, AlertFindingBody, SilenceBody};
use crate::wire::body::{ToBody, bodies};
use crate::wire::reason::Reason;
use crate::wire::{time, unit};

/// Where the judged figures come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    pub at: UtcMicros,
    /// Record or bench result; none where the clock alone decided.
    pub item: Option<Id>,
    pub imu: Option<u32>,
    pub slot: Option<Slot>,
    pub station: Option<u32>,
    /// Of production, where it is judged as such.
    pub batch: Option<Arc<str>>,
}

impl Origin {
    /// Of an instant; what else there is to say is left open.
    pub fn at(at: UtcMicros) -> Self {
        Self { at, item: None, imu: None, slot: None, station: None, batch: None }
    }
}

impl From<&Figures> for Origin {
    fn from(figures: &Figures) -> Self {
        let Figures { at, record, imu, slot, station, .. } = *figures;
        Self { item: Some(record), imu: Some(imu), slot: Some(slot), station: Some(station), ..Self::at(at) }
    }
}

/// The names of what is stored, and of what the group under construction adds.
#[derive(Clone, Copy)]
pub struct NameLookup<'a> {
    pub tables: &'a Tables,
    pub new: Option<&'a Changes>,
}

impl NameLookup<'_> {
    pub fn gyro(&self, number: u32) -> String {
        self.name(&self.tables.gyros, |new| &new.gyros, number)
    }

    /// Empty for what is no gyro.
    pub fn serial(&self, of: AlertOf) -> String {
        of.gyro().map(|gyro| self.gyro(gyro)).unwrap_or_default()
    }

    pub fn imu(&self, number: u32) -> String {
        self.name(&self.tables.imus, |new| &new.imus, number)
    }

    pub fn station(&self, number: u32) -> String {
        self.name(&self.tables.stations, |new| &new.stations, number)
    }

    /// As it is stored, or else as the group adds it.
    fn name(&self, stored: &Table, added: fn(&Changes) -> &Vec<NewName>, number: u32) -> String {
        let of_group = || added(self.new?).iter().find(|new| new.number == number).map(|new| new.name.as_str());
        stored.name(number).or_else(of_group).unwrap_or_default().to_owned()
    }

    pub fn finding(&self, verdict: &Verdict, origin: &Origin) -> AlertFindingBody {
        AlertFindingBody {
            value: verdict.value,
            limit: verdict.limit,
            unit: verdict.unit().name().into(),
            sd: verdict.sd,
            probability: verdict.probability,
            reason: Reason::of(verdict),
            record: origin.item.map(|id| id.to_string()),
            calibrated_at: Some(time::format(origin.at)),
            imu: origin.imu.map(|number| self.imu(number)),
            slot: origin.slot.map(|slot| slot.name().into()),
            station: origin.station.map(|number| self.station(number)),
            batch: origin.batch.as_deref().map(str::to_owned),
            with_imu: None,
        }
    }

    pub fn alert(&self, row: &AlertRow, now: UtcMicros) -> Result<AlertBody, StoreError> {
        let finding = finding_of(row)?;
        Ok(AlertBody {
            id: row.id.to_string(),
            subject: subject(row.of).into(),
            serial: self.serial(row.of),
            coefficient: row.coefficient.name().into(),
            rule: row.rule.name().into(),
            state: row.alert.standing(now).name().into(),
            status: Some(status_of(row, &finding).name().into()),
            severity: row.alert.severity.name().into(),
            since: Some(time::format(row.alert.since)),
            fired_at: time::format(row.alert.fired_at),
            resolved_at: row.alert.resolved_at.map(time::format),
            finding,
            acknowledged: row.acknowledged.to_body(),
            silenced: silence_of(row, now),
            inhibited_by: row.inhibited_by.map(|id| id.to_string()),
        })
    }
}

bodies! { AcknowledgementBody of Remark: by, reason, at; }

/// The silence that holds for an alert the longest.
fn silence_of(row: &AlertRow, now: UtcMicros) -> Option<SilenceBody> {
    let own = row.silenced.as_ref().zip(row.alert.silenced_until).map(|(said, until)| (until, None, said));
    let muted =
        row.muted.as_ref().zip(row.alert.muted_until).map(|((silence, said), until)| (until, Some(*silence), said));
    let holding = [own, muted].into_iter().flatten().filter(|(until, ..)| now < *until);
    holding.max_by_key(|(until, ..)| *until).map(|(until, silence, said)| SilenceBody {
        silence: silence.map(|id| id.to_string()),
        by: said.by.clone(),
        reason: said.reason.clone(),
        at: time::format(said.at),
        until: time::format(until),
    })
}

/// The last verdict that an alert has followed. Earlier versions spelled its unit as people do.
pub fn finding_of(row: &AlertRow) -> Result<AlertFindingBody, StoreError> {
    let mut finding: AlertFindingBody = serde_json::from_str(&row.finding)
        .map_err(|error| StoreError::damaged(format_args!("the finding of alert {}: {error}", row.id)))?;
    finding.unit = unit::of_machines(&finding.unit).into();
    Ok(finding)
}

/// What the gyro is, by an alert and the last verdict that it has followed.
pub fn status_of(row: &AlertRow, finding: &AlertFindingBody) -> Status {
    if row.alert.resolved_at.is_some() {
        return Status::InTolerance;
    }
    let confirmed = row.alert.severity == Severity::Critical;
    Status::of(row.rule, State::Exceeded, finding.value, finding.limit, finding.sd, confirmed)
}

fn subject(of: AlertOf) -> &'static str {
    match of {
        AlertOf::Gyro(_) => AlertBody::OF_GYRO,
        AlertOf::Station(_) => AlertBody::OF_STATION,
        AlertOf::Imu(_) => AlertBody::OF_IMU,
        AlertOf::Batch(_) => AlertBody::OF_BATCH,
    }
}
