//! The writer's part in alerts of stations and IMUs: what the newest calibrations of the fleet say that their gyros
//! share.
//!
//! A file's writer asks with every group in which a gyro begins to exceed a limit, so that the group's other gyros are
//! told of as one; the clock asks at every tick. Among several servers only the clock does, which holds every cell.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::config::Config;
use crate::core::judge::{
    Calibrated, Coefficient, ImuQuestion, Measured, Rule, Severity, ShiftQuestion, State, Verdict, imu_shift,
    station_shift,
};
use crate::core::time::UtcMicros;
use crate::pipeline::alerts::{AlertCache, Naming, Origin, SharedVerdict};
use crate::pipeline::ingest::judge::{Judged, Newest};
use crate::store;
use crate::store::{AlertOf, AlertRow, Changes, Store, StoreError};

/// Calibrations that count for the comparison of stations, days.
const LATELY: f64 = 60.0;

/// A gyro exceeds a limit since an instant, of D_I (column 0) or D_S (1), by a rule that may be shared.
#[derive(Debug, Clone, Copy)]
struct Exceeding {
    gyro: u32,
    column: usize,
    since: UtcMicros,
    severity: Severity,
}

impl Exceeding {
    fn of(row: &AlertRow) -> Option<Self> {
        let alert = &row.alert;
        row.rule.can_be_shared().then_some(())?;
        let (gyro, column) = (row.of.gyro()?, row.coefficient.column()?);
        Some(Self { gyro, column, since: alert.since, severity: alert.severity })
    }
}

/// What gyros share, by station and by IMU.
pub(super) struct SharedShifts<'a> {
    pub store: &'a Store,
    pub config: &'a Config,
    pub alerts: &'a AlertCache,
    pub now: UtcMicros,
}

impl SharedShifts<'_> {
    /// What the gyros of a group share, where one of them begins to exceed a limit, or exceeds it more gravely.
    pub async fn of_group(&self, found: &Judged, changes: &Changes) -> Result<Vec<SharedVerdict>, StoreError> {
        let is_news = |newest: &Newest, verdict: &Verdict| {
            let is_known = |row: &AlertRow| {
                (row.coefficient, row.rule) == (verdict.coefficient, verdict.rule)
                    && Some(row.alert.severity) >= verdict.severity()
            };
            verdict.severity().is_some()
                && verdict.rule.can_be_shared()
                && !self.alerts.firing(newest.gyro).any(is_known)
        };
        let verdicts = |newest: &Newest| found.verdicts.get(&(newest.figures.record, newest.gyro));
        let has_news =
            |newest: &&Newest| verdicts(newest).into_iter().flatten().any(|verdict| is_news(newest, verdict));
        let exceeding: Vec<&Newest> = found.newest.iter().filter(has_news).collect();
        if exceeding.is_empty() {
            return Ok(Vec::new());
        }
        let stations: BTreeSet<u32> = exceeding.iter().map(|newest| newest.figures.station).collect();
        let imus: BTreeSet<u32> = exceeding.iter().map(|newest| newest.figures.imu).collect();
        let mut exceed: Vec<Exceeding> = Vec::new();
        for newest in &found.newest {
            let firing = || self.alerts.firing(newest.gyro);
            exceed.extend(firing().filter_map(Exceeding::of));
            for verdict in verdicts(newest).into_iter().flatten().filter(|verdict| verdict.rule.can_be_shared()) {
                let is_its = |row: &&AlertRow| (row.coefficient, row.rule) == (verdict.coefficient, verdict.rule);
                let since = firing().find(is_its).map_or(newest.figures.at, |row| row.alert.since);
                let (column, severity) = (verdict.coefficient.column(), verdict.severity());
                let of = |(column, severity)| Exceeding { gyro: newest.gyro, column, since, severity };
                exceed.extend(column.zip(severity).map(of));
            }
        }
        // Whether a station has shifted its own newest calibrations tell; the fleet's are only asked whether it alone has.
        let mut near = Vec::new();
        for station in &stations {
            near.extend(self.calibrated(Some(*station)).await?);
        }
        let mut calibrated = self.with_group(near, found, changes);
        let mut judged = self.of_stations(&calibrated, &stations);
        if judged.iter().any(|one| one.verdict.state == State::Exceeded) {
            calibrated = self.with_group(self.calibrated(None).await?, found, changes);
            judged = self.of_stations(&calibrated, &stations);
        }
        // Of what is over the clock judges, which knows every gyro of an IMU.
        let of_imus = self.of_imus(&calibrated, &imus, &judged, &exceed);
        judged.extend(of_imus.into_iter().filter(|one| one.verdict.severity().is_some()));
        Ok(judged)
    }

    /// Stored calibrations with those of a group in their place.
    fn with_group(&self, stored: Vec<Calibrated>, found: &Judged, changes: &Changes) -> Vec<Calibrated> {
        let mut newest: HashMap<u32, Calibrated> = stored.into_iter().map(|row| (row.gyro, row)).collect();
        let tables = self.store.names().read();
        let naming = Naming { tables: &tables, new: Some(changes) };
        for Newest { gyro, figures } in &found.newest {
            let loads = changes.heads.outlooks.get(&(figures.record, *gyro)).map_or([None; 3], |outlook| outlook.load);
            let budgets = self.budgets(&naming.imu(figures.imu), &naming.gyro(*gyro));
            let deviation = [0, 1].map(|column| times(loads[column], budgets[column]));
            let batch = newest.remove(gyro).and_then(|known| known.batch);
            let (imu, station, at) = (figures.imu, figures.station, figures.at);
            newest.insert(*gyro, Calibrated { gyro: *gyro, imu, station, at, deviation, batch });
        }
        newest.into_values().collect()
    }

    /// What the gyros of every station and IMU have done lately, and of those that have an alert. `firing`: alerts of
    /// gyros that may be shared.
    pub async fn all(&self, firing: &[AlertRow]) -> Result<Vec<SharedVerdict>, StoreError> {
        let newest = self.calibrated(None).await?;
        let recent = self.now.plus_days(-self.config.alerts.backfill_days);
        let recent = || newest.iter().filter(|one| one.at >= recent);
        let told = || self.alerts.shared().firing().map(|row| row.of);
        let stations = recent().map(|one| one.station).chain(told().filter_map(AlertOf::station)).collect();
        let imus = recent().map(|one| one.imu).chain(told().filter_map(AlertOf::imu)).collect();
        let mut judged = self.of_stations(&newest, &stations);
        let of_imus =
            self.of_imus(&newest, &imus, &judged, &firing.iter().filter_map(Exceeding::of).collect::<Vec<_>>());
        judged.extend(of_imus);
        Ok(judged)
    }

    fn of_stations(&self, newest: &[Calibrated], stations: &BTreeSet<u32>) -> Vec<SharedVerdict> {
        let limits = self.config.judging.limits("", "");
        let budgets = self.budgets("", "");
        let mut found = Vec::new();
        for (station, column) in stations.iter().flat_map(|station| [(*station, 0), (*station, 1)]) {
            let limit = [&limits.d_i, &limits.d_s][column].of(Rule::StationShift);
            let Some((limit, budget)) = limit.zip(budgets[column]) else { continue };
            let of = AlertOf::Station(station);
            let fires = |row: &AlertRow| row.of == of && row.coefficient.column() == Some(column);
            let fires = self.alerts.shared().firing().any(fires);
            let asked = ShiftQuestion { limit, budget, confidence: limits.confidence, fires };
            let verdict = station_shift(newest, station, column, &asked);
            let last = newest.iter().filter(|one| one.station == station).map(|one| one.at).max();
            let at = last.unwrap_or(self.now);
            let origin = Origin { at, item: None, imu: None, slot: None, station: Some(station) };
            found.push(SharedVerdict { of, verdict, origin });
        }
        found
    }

    /// What the gyros of IMUs have done beside what their stations have.
    fn of_imus(
        &self,
        newest: &[Calibrated],
        imus: &BTreeSet<u32>,
        of_stations: &[SharedVerdict],
        exceed: &[Exceeding],
    ) -> Vec<SharedVerdict> {
        let mut exceeding: HashMap<(u32, usize), Vec<&Exceeding>> = HashMap::new();
        exceed.iter().for_each(|one| exceeding.entry((one.gyro, one.column)).or_default().push(one));
        let mut gyros: BTreeMap<u32, Vec<&Calibrated>> = imus.iter().map(|imu| (*imu, Vec::new())).collect();
        newest.iter().for_each(|one| gyros.get_mut(&one.imu).into_iter().for_each(|gyros| gyros.push(one)));
        let mut found = Vec::new();
        for (imu, gyros) in gyros {
            let of = AlertOf::Imu(imu);
            let limits = self.config.judging.limits(&self.name_of(imu), "");
            let last = gyros.iter().max_by_key(|one| one.at);
            let (at, station) = last.map_or((self.now, None), |one| (one.at, Some(one.station)));
            for (column, coefficient) in [Coefficient::DI, Coefficient::DS].into_iter().enumerate() {
                let Some(limit) = [&limits.d_i, &limits.d_s][column].of(Rule::ImuShift) else { continue };
                let its = || gyros.iter().filter_map(|one| exceeding.get(&(one.gyro, column))).flatten();
                let told = self.alerts.shared().since(of, coefficient);
                let since = told.unwrap_or(at);
                let asked = ImuQuestion {
                    limit,
                    confidence: limits.confidence,
                    station: shift_of(station, coefficient, of_stations),
                    one_did_before: told.is_none() && its().any(|one| one.since < at),
                    confirmed: its().any(|one| one.since == since && one.severity == Severity::Critical),
                };
                let verdict = imu_shift(&gyros, column, &asked);
                let origin = Origin { at, item: None, imu: Some(imu), slot: None, station };
                found.push(SharedVerdict { of, verdict, origin });
            }
        }
        found
    }

    fn name_of(&self, imu: u32) -> String {
        // Without overrides all have the same limits.
        if self.config.judging.overrides.is_empty() {
            return String::new();
        }
        Naming { tables: &self.store.names().read(), new: None }.imu(imu)
    }

    /// The newest calibrations of the fleet, or of one station; where a shared alert fires, those since it does.
    async fn calibrated(&self, station: Option<u32>) -> Result<Vec<Calibrated>, StoreError> {
        let began = self.alerts.shared().firing().map(|row| row.alert.since).min().unwrap_or(self.now);
        let rows = store::head::calibrated_since(self.store, self.now.plus_days(-LATELY).min(began), station).await?;
        let mut budgets: BTreeMap<(String, String), [Option<f64>; 2]> = BTreeMap::new();
        let calibrated = rows.into_iter().map(|row| {
            let of = (row.imu_name, row.serial);
            // Without overrides all have the same.
            let of = if self.config.judging.overrides.is_empty() { Default::default() } else { of };
            let budgets = *budgets.entry(of).or_insert_with_key(|(imu, serial)| self.budgets(imu, serial));
            let deviation = [0, 1].map(|column| times(row.load[column], budgets[column]));
            let store::head::CalibratedRow { gyro, imu, station, at, batch, .. } = row;
            Calibrated { gyro, imu, station, at, deviation, batch }
        });
        Ok(calibrated.collect())
    }

    /// What loads are shares of, deg/(h g0).
    fn budgets(&self, imu: &str, serial: &str) -> [Option<f64>; 2] {
        let limits = self.config.judging.limits(imu, serial);
        [limits.d_i, limits.d_s].map(|drift| drift.of(Rule::Baseline).map(|limit| limit.value))
    }
}

/// What a station has done to all, where it has.
fn shift_of(station: Option<u32>, coefficient: Coefficient, found: &[SharedVerdict]) -> Option<Measured> {
    let of = AlertOf::Station(station?);
    let of_station = |one: &&SharedVerdict| one.of == of && one.verdict.coefficient == coefficient;
    found.iter().find(of_station)?.verdict.station_shift()
}

fn times(load: Option<Measured>, budget: Option<f64>) -> Option<Measured> {
    let (load, budget) = load.zip(budget)?;
    Some(Measured { value: load.value * budget, sd: load.sd.map(|sd| sd * budget) })
}
