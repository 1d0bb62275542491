//! Alerts of what gyros of a station, a batch or an IMU share, and alerts of gyros that these explain: told as one, and not
//! as one of each gyro.

use super::body::{NameLookup, Origin, finding_of};
use crate::core::alert_decision::Status;
use crate::core::judge::{Coefficient, ExplicableVerdict, Measured, Severity, State, has_grown, is_explained};
use crate::core::message::Parameter;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow};
use crate::wire::alert::AlertFindingBody;
use crate::wire::time;

/// What gyros of a station, a batch or an IMU share, judged by the clock.
#[derive(Debug, Clone)]
pub(crate) struct SharedVerdict {
    pub of: AlertOf,
    pub verdict: Verdict,
    /// The newest calibration by the station, or of the batch or the IMU.
    pub origin: Origin,
    /// When it began, where the alert is to say so though it fires already.
    pub since: Option<UtcMicros>,
    /// Of a batch.
    pub gyros: Vec<u32>,
}

/// What explains that a gyro exceeds a limit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Explained {
    pub by: Option<Id>,
    /// What it exceeded it by when the alert of its IMU began, where it began with that.
    pub with_imu: Option<f64>,
}

/// What a gyro exceeds a limit by, since when, and where, by a rule that may be shared.
struct CoefficientExcess<'a> {
    gyro: u32,
    station: Option<u32>,
    imu: Option<u32>,
    coefficient: Coefficient,
    severity: Severity,
    since: UtcMicros,
    /// The calibration that shows it.
    at: Option<UtcMicros>,
    suspected: Option<ExplicableVerdict>,
    /// Its alert, where that fires already.
    row: Option<&'a AlertRow>,
}

/// The alerts of what is shared, among all that are known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedAlerts<'a> {
    pub(super) alerts: &'a BTreeMap<AlertOf, Vec<AlertRow>>,
    /// Gyros of batches that have an alert, and the gyro by which the batch goes.
    pub(super) mates: &'a BTreeMap<u32, u32>,
    /// With which something exceeds its limit.
    pub(super) confidence: f64,
}

impl<'a> SharedAlerts<'a> {
    /// Those that fire.
    pub fn firing(&self) -> impl Iterator<Item = &'a AlertRow> + use<'a> {
        let not_gyros = self.alerts.iter().filter(|(of, _)| of.gyro().is_none());
        not_gyros.flat_map(|(_, rows)| rows).filter(|row| fires(row))
    }

    /// The gyro by which each batch goes that has had an alert.
    pub fn batches(&self) -> BTreeMap<String, u32> {
        let of_batches = self.alerts.iter().filter_map(|(of, rows)| Some((of.batch()?, rows)));
        let named = of_batches
            .flat_map(|(gyro, rows)| rows.iter().filter_map(move |row| Some((finding_of(row).ok()?.batch?, gyro))));
        named.collect()
    }

    /// What may explain the alerts of gyros, once what was `found` is told: what fires or will, and the gyros of batches.
    pub fn that_explain(&self, found: &[SharedVerdict]) -> (BTreeSet<AlertOf>, Vec<u32>) {
        let will_fire = found.iter().filter(|one| one.verdict.severity().is_some()).map(|one| one.of);
        let subjects: BTreeSet<AlertOf> = self.firing().map(|row| row.of).chain(will_fire).collect();
        let is_of_these = |(_, batch): &(&u32, &u32)| subjects.contains(&AlertOf::Batch(**batch));
        let gyros = self.mates.iter().filter(is_of_these).map(|(gyro, _)| *gyro).collect();
        (subjects, gyros)
    }

    fn firing_of(&self, of: AlertOf, coefficient: Coefficient) -> Option<&'a AlertRow> {
        self.alerts.get(&of)?.iter().find(|row| row.coefficient == coefficient && fires(row))
    }

    pub fn knows(&self, of: AlertOf, coefficient: Coefficient) -> bool {
        self.alerts.get(&of).is_some_and(|rows| rows.iter().any(|row| row.coefficient == coefficient))
    }

    /// The alert that an IMU shifts, whether it fires or not.
    pub fn of_imu(&self, imu: u32, coefficient: Coefficient) -> Option<&'a AlertRow> {
        let mut rows = self.alerts.get(&AlertOf::Imu(imu))?.iter();
        rows.find(|row| row.rule == Rule::ImuShift && row.coefficient == coefficient)
    }

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

    /// The alert of a station or a batch that fires, and the shift that it tells of.
    fn shift(&self, of: AlertOf, coefficient: Coefficient) -> Option<(&'a AlertRow, Measured)> {
        let row = self.firing_of(of, coefficient)?;
        let AlertFindingBody { value, sd, reason, .. } = finding_of(row).ok()?;
        let sign = if is_above(&reason.0)? { 1.0 } else { -1.0 };
        Some((row, Measured { value: sign * value?, sd }))
    }

    /// The alert of the station, batch or IMU by which a gyro exceeds a limit since an instant, where that is no less
    /// severe. `row`: the gyro's alert, where it fires already; `by_clock`: IMUs are judged by the clock alone.
    pub(super) fn explaining(
        &self,
        gyro: u32,
        verdict: &Verdict,
        origin: &Origin,
        since: UtcMicros,
        (row, by_clock): (Option<&AlertRow>, bool),
    ) -> Explained {
        let Some(severity) = verdict.severity().filter(|_| verdict.rule.can_be_shared()) else {
            return Explained::default();
        };
        let (coefficient, suspected) = (verdict.coefficient, ExplicableVerdict::of(verdict));
        let Origin { station, imu, .. } = *origin;
        // Where late records have told that it began at another time, the clock sees whether its IMU's shift did, too.
        let by_imu = imu.and_then(|imu| self.firing_of(AlertOf::Imu(imu), coefficient));
        let held = by_imu.filter(|by| row.is_some_and(|row| row.inhibited_by == Some(by.id)));
        let since = held.map_or(since, |by| by.alert.since);
        // Nor has the clock seen yet that it has become graver.
        let severity = held.filter(|_| by_clock).map_or(severity, |by| by.alert.severity.min(severity));
        let at = Some(origin.at);
        let of = CoefficientExcess { gyro, station, imu, coefficient, severity, since, at, suspected, row };
        self.explaining_excess(&of)
    }

    /// As [`SharedAlerts::explaining`], of an alert by the last verdict that it has followed.
    pub(super) fn explaining_row(&self, row: &AlertRow, naming: &NameLookup<'_>) -> Explained {
        let AlertRow { of, coefficient, rule, alert, .. } = row;
        let fires = alert.status == Status::Firing && rule.can_be_shared();
        let Some((gyro, finding)) = of.gyro().filter(|_| fires).zip(finding_of(row).ok()) else {
            return Explained::default();
        };
        let AlertFindingBody { value, limit, sd, reason, station, imu, calibrated_at, .. } = finding;
        let above = is_above(&reason.0);
        self.explaining_excess(&CoefficientExcess {
            gyro,
            station: station.and_then(|name| naming.tables.stations.number(&name)),
            imu: imu.and_then(|name| naming.tables.imus.number(&name)),
            coefficient: *coefficient,
            severity: alert.severity,
            since: alert.since,
            at: calibrated_at.and_then(|at| time::parse(&at).ok()),
            suspected: value.map(|value| ExplicableVerdict { rule: *rule, value, limit, sd, above }),
            row: Some(row),
        })
    }

    fn explaining_excess(&self, of: &CoefficientExcess<'_>) -> Explained {
        let Some(suspected) = &of.suspected else { return Explained::default() };
        let by_group = |group: AlertOf| {
            let (row, shift) = self.shift(group, of.coefficient)?;
            is_explained(suspected, shift, self.confidence).then_some(row)
        };
        let groups = [of.station.map(AlertOf::Station), self.mates.get(&of.gyro).copied().map(AlertOf::Batch)];
        let no_less_severe = |row: &&AlertRow| row.alert.severity >= of.severity;
        // What was measured before a station or batch moved, however late it comes, is none of its doing.
        let moved = |row: &&AlertRow| of.at.is_none_or(|at| at >= row.alert.since);
        let by_group = groups.into_iter().flatten().filter_map(by_group).filter(moved).find(no_less_severe);
        // What a gyro does before its IMU, or after, is its own, and so is what it grows by.
        let imu = of.imu.and_then(|imu| self.firing_of(AlertOf::Imu(imu), of.coefficient));
        let imu = imu.filter(|row| row.alert.since == of.since);
        let known = of.row.filter(|_| imu.is_some()).and_then(|row| finding_of(row).ok()?.with_imu);
        let with_imu = imu.map(|_| known.unwrap_or(suspected.value));
        let has_grown = |then: f64| has_grown(suspected, then, self.confidence);
        let by_imu = imu.filter(no_less_severe).filter(|_| !with_imu.is_some_and(has_grown));
        Explained { by: by_group.or(by_imu).map(|row| row.id), with_imu }
    }

    /// Whether a verdict changes the alert of its station, batch or IMU.
    pub fn is_moved_by(&self, found: &SharedVerdict, naming: &NameLookup<'_>) -> bool {
        let SharedVerdict { of, verdict, origin, since, .. } = found;
        match self.firing_of(*of, verdict.coefficient) {
            None => verdict.severity().is_some(),
            Some(row) if since.is_some_and(|since| since != row.alert.since) => true,
            Some(_) if verdict.value.is_none() || verdict.state == State::Within => true,
            Some(row) => verdict.state == State::Exceeded && row.finding != naming.finding(verdict, origin).kept(),
        }
    }

    /// Gyros among these alerts that another explains, and did not, or do not any more.
    pub fn explained_anew(&self, rows: &[AlertRow], naming: &NameLookup<'_>) -> BTreeSet<u32> {
        // Where none of its coefficient fires there is nothing to be read from a finding.
        let fire: BTreeSet<&str> = self.firing().map(|row| row.coefficient.name()).collect();
        let may_be = |row: &&AlertRow| row.inhibited_by.is_some() || fire.contains(row.coefficient.name());
        let anew = rows.iter().filter(may_be);
        let anew = anew.filter(|row| self.explaining_row(row, naming).by != row.inhibited_by);
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
