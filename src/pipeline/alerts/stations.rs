//! Alerts of stations, and alerts of gyros that these explain: told as one, and not as one of each gyro.

use std::collections::{BTreeMap, BTreeSet};

use super::body::{Naming, Origin, finding_of};
use crate::core::alert_decision::Status;
use crate::core::id::Id;
use crate::core::judge::{Coefficient, Measured, Rule, State, Suspected, Verdict, is_explained};
use crate::core::message::{Message, Parameter};
use crate::store::{AlertOf, AlertRow};
use crate::wire::alert::FindingBody;

/// What a station does, judged by the clock.
#[derive(Debug, Clone)]
pub(crate) struct StationVerdict {
    pub station: u32,
    pub verdict: Verdict,
    /// The newest calibration by the station.
    pub origin: Origin,
}

/// The alerts of stations among all that are known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StationAlerts<'a> {
    pub(super) alerts: &'a BTreeMap<AlertOf, Vec<AlertRow>>,
    /// With which something exceeds its limit.
    pub(super) confidence: f64,
}

impl<'a> StationAlerts<'a> {
    /// The alert of a station that fires, and the shift that it tells of.
    fn shift(&self, station: u32, coefficient: Coefficient) -> Option<(&'a AlertRow, Measured)> {
        let rows = self.alerts.get(&AlertOf::Station(station))?;
        let row = rows.iter().find(|row| row.coefficient == coefficient && row.alert.status == Status::Firing)?;
        let FindingBody { value, sd, reason, .. } = finding_of(row).ok()?;
        let sign = if is_above(&reason.0)? { 1.0 } else { -1.0 };
        Some((row, Measured { value: sign * value?, sd }))
    }

    /// The alert of the station by which a gyro exceeds a limit, where that is no less severe.
    pub(super) fn explaining(&self, of: AlertOf, verdict: &Verdict, origin: &Origin) -> Option<Id> {
        let (station, severity) = (origin.station.filter(|_| of.gyro().is_some())?, verdict.severity()?);
        let (row, shift) = self.shift(station, verdict.coefficient)?;
        let explained = is_explained(&Suspected::of(verdict)?, shift, self.confidence);
        (row.alert.severity >= severity && explained).then_some(row.id)
    }

    /// As [`StationAlerts::explaining`], of an alert by the last verdict that it has followed.
    pub(super) fn explaining_row(&self, row: &AlertRow, naming: &Naming<'_>) -> Option<Id> {
        let fires = row.alert.status == Status::Firing && row.rule.is_explained_by_station();
        row.of.gyro().filter(|_| fires)?;
        let finding = finding_of(row).ok()?;
        let station = naming.tables.stations.number(finding.station.as_deref()?)?;
        let (of_station, shift) = self.shift(station, row.coefficient)?;
        let FindingBody { value, limit, sd, reason, .. } = finding;
        let suspected = Suspected { rule: row.rule, value: value?, limit, sd, above: is_above(&reason.0) };
        let explained = is_explained(&suspected, shift, self.confidence);
        (of_station.alert.severity >= row.alert.severity && explained).then_some(of_station.id)
    }

    /// Whether a verdict changes the alert of its station.
    pub fn is_moved_by(&self, found: &StationVerdict, naming: &Naming<'_>) -> bool {
        let StationVerdict { station, verdict, origin } = found;
        let rows = self.alerts.get(&AlertOf::Station(*station)).into_iter().flatten();
        let mut firing = rows.filter(|row| row.alert.status == Status::Firing);
        match firing.find(|row| row.coefficient == verdict.coefficient) {
            None => verdict.severity().is_some(),
            Some(_) if verdict.value.is_none() || verdict.state == State::Within => true,
            Some(row) => verdict.state == State::Exceeded && row.finding != naming.finding(verdict, origin).kept(),
        }
    }

    /// Stations of which an alert fires.
    pub fn firing(&self) -> impl Iterator<Item = (u32, &'a AlertRow)> + use<'a> {
        let firing = |row: &&AlertRow| row.alert.status == Status::Firing && row.rule == Rule::StationShift;
        let rows = self.alerts.iter().filter_map(|(of, rows)| Some((of.station()?, rows)));
        rows.flat_map(move |(station, rows)| rows.iter().filter(firing).map(move |row| (station, row)))
    }

    /// Gyros among these alerts that stations explain, and did not, or do not any more.
    pub fn explained_anew(&self, rows: &[AlertRow], naming: &Naming<'_>) -> BTreeSet<u32> {
        // Where no station's alert fires there is nothing to be read from findings.
        let explains = self.firing().next().is_some();
        let anew = rows.iter().filter(|row| explains || row.inhibited_by.is_some());
        let anew = anew.filter(|row| self.explaining_row(row, naming) != row.inhibited_by);
        anew.filter_map(|row| row.of.gyro()).collect()
    }
}

/// On which side of its level a finding says that a figure is.
fn is_above(said: &[Message]) -> Option<bool> {
    let of = |name: &str| said.iter().find_map(|message| message.parameter(name));
    match (of("side"), of("deviation")) {
        (Some(side), _) => Some(*side == Parameter::from("above")),
        (None, Some(deviation)) => Some(!deviation.to_string().starts_with('-')),
        (None, None) => None,
    }
}
