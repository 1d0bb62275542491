//! Alerts of what gyros of a station or an IMU share, and alerts of gyros that these explain: told as one, and not as
//! one of each gyro.

use std::collections::{BTreeMap, BTreeSet};

use super::body::{Naming, Origin, finding_of};
use crate::core::alert_decision::Status;
use crate::core::id::Id;
use crate::core::judge::{Coefficient, Measured, Severity, State, Suspected, Verdict, is_explained};
use crate::core::message::{Message, Parameter};
use crate::core::time::UtcMicros;
use crate::store::{AlertOf, AlertRow};
use crate::wire::alert::FindingBody;

/// What gyros of a station or an IMU share, judged by the clock.
#[derive(Debug, Clone)]
pub(crate) struct SharedVerdict {
    pub of: AlertOf,
    pub verdict: Verdict,
    /// The newest calibration by the station, or of the IMU.
    pub origin: Origin,
}

/// What a gyro exceeds a limit by, since when, and where, by a rule that may be shared.
struct Excess {
    station: Option<u32>,
    imu: Option<u32>,
    coefficient: Coefficient,
    severity: Severity,
    since: UtcMicros,
    suspected: Option<Suspected>,
}

/// The alerts of what is shared, among all that are known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedAlerts<'a> {
    pub(super) alerts: &'a BTreeMap<AlertOf, Vec<AlertRow>>,
    /// With which something exceeds its limit.
    pub(super) confidence: f64,
}

impl<'a> SharedAlerts<'a> {
    /// Those that fire.
    pub fn firing(&self) -> impl Iterator<Item = &'a AlertRow> + use<'a> {
        let not_gyros = self.alerts.iter().filter(|(of, _)| of.gyro().is_none());
        not_gyros.flat_map(|(_, rows)| rows).filter(|row| fires(row))
    }

    fn firing_of(&self, of: AlertOf, coefficient: Coefficient) -> Option<&'a AlertRow> {
        self.alerts.get(&of)?.iter().find(|row| row.coefficient == coefficient && fires(row))
    }

    /// Since when an alert of a station or an IMU fires.
    pub fn since(&self, of: AlertOf, coefficient: Coefficient) -> Option<UtcMicros> {
        self.firing_of(of, coefficient).map(|row| row.alert.since)
    }

    /// Those that fire and are judged no more: their rule has been switched off.
    pub fn not_judged(&self, found: &[SharedVerdict]) -> impl Iterator<Item = &'a AlertRow> {
        let judges = |one: &SharedVerdict, row: &AlertRow| {
            (one.of, one.verdict.rule, one.verdict.coefficient) == (row.of, row.rule, row.coefficient)
        };
        self.firing().filter(move |row| !found.iter().any(|one| judges(one, row)))
    }

    /// The alert of a station that fires, and the shift that it tells of.
    fn shift(&self, station: u32, coefficient: Coefficient) -> Option<(&'a AlertRow, Measured)> {
        let row = self.firing_of(AlertOf::Station(station), coefficient)?;
        let FindingBody { value, sd, reason, .. } = finding_of(row).ok()?;
        let sign = if is_above(&reason.0)? { 1.0 } else { -1.0 };
        Some((row, Measured { value: sign * value?, sd }))
    }

    /// The alert of the station or IMU by which a gyro exceeds a limit since an instant, where that is no less severe.
    pub(super) fn explaining(&self, verdict: &Verdict, origin: &Origin, since: UtcMicros) -> Option<Id> {
        let (severity, coefficient) =
            (verdict.severity().filter(|_| verdict.rule.can_be_shared())?, verdict.coefficient);
        let suspected = Suspected::of(verdict);
        let Origin { station, imu, .. } = *origin;
        self.explaining_excess(&Excess { station, imu, coefficient, severity, since, suspected })
    }

    /// As [`SharedAlerts::explaining`], of an alert by the last verdict that it has followed.
    pub(super) fn explaining_row(&self, row: &AlertRow, naming: &Naming<'_>) -> Option<Id> {
        let AlertRow { of, coefficient, rule, alert, .. } = row;
        let fires = alert.status == Status::Firing && rule.can_be_shared();
        of.gyro().filter(|_| fires)?;
        let FindingBody { value, limit, sd, reason, station, imu, .. } = finding_of(row).ok()?;
        let above = is_above(&reason.0);
        self.explaining_excess(&Excess {
            station: station.and_then(|name| naming.tables.stations.number(&name)),
            imu: imu.and_then(|name| naming.tables.imus.number(&name)),
            coefficient: *coefficient,
            severity: alert.severity,
            since: alert.since,
            suspected: value.map(|value| Suspected { rule: *rule, value, limit, sd, above }),
        })
    }

    fn explaining_excess(&self, of: &Excess) -> Option<Id> {
        let by_station = || {
            let (row, shift) = self.shift(of.station?, of.coefficient)?;
            is_explained(of.suspected.as_ref()?, shift, self.confidence).then_some(row)
        };
        // What a gyro does before its IMU, or after, is its own.
        let by_imu = || {
            let row = self.firing_of(AlertOf::Imu(of.imu?), of.coefficient)?;
            (row.alert.since == of.since).then_some(row)
        };
        let no_less_severe = |row: &&AlertRow| row.alert.severity >= of.severity;
        let row = by_station().filter(no_less_severe).or_else(|| by_imu().filter(no_less_severe))?;
        Some(row.id)
    }

    /// Whether a verdict changes the alert of its station or IMU.
    pub fn is_moved_by(&self, found: &SharedVerdict, naming: &Naming<'_>) -> bool {
        let SharedVerdict { of, verdict, origin } = found;
        match self.firing_of(*of, verdict.coefficient) {
            None => verdict.severity().is_some(),
            Some(_) if verdict.value.is_none() || verdict.state == State::Within => true,
            Some(row) => verdict.state == State::Exceeded && row.finding != naming.finding(verdict, origin).kept(),
        }
    }

    /// Gyros among these alerts that another explains, and did not, or do not any more.
    pub fn explained_anew(&self, rows: &[AlertRow], naming: &Naming<'_>) -> BTreeSet<u32> {
        // Where none fires there is nothing to be read from findings.
        let explains = self.firing().next().is_some();
        let anew = rows.iter().filter(|row| explains || row.inhibited_by.is_some());
        let anew = anew.filter(|row| self.explaining_row(row, naming) != row.inhibited_by);
        anew.filter_map(|row| row.of.gyro()).collect()
    }
}

fn fires(row: &AlertRow) -> bool {
    row.alert.status == Status::Firing && row.rule.explains_others()
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
