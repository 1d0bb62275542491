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

/// Gyros of which a second campaign has confirmed what they exceed, by column: 0 for D_I, 1 for D_S.
type Confirmed = BTreeSet<(u32, usize)>;

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
        let confirmed = |newest: &Newest| {
            let critical =
                |verdict: &&Verdict| verdict.rule.can_be_shared() && verdict.severity() == Some(Severity::Critical);
            let found = verdicts(newest).into_iter().flatten().filter(critical);
            let found = found.filter_map(|verdict| Some((newest.gyro, verdict.coefficient.column()?)));
            found.collect::<Vec<_>>()
        };
        let mut confirmed: Confirmed = found.newest.iter().flat_map(confirmed).collect();
        confirmed.extend(found.newest.iter().flat_map(|newest| confirmed_of(self.alerts.firing(newest.gyro))));
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
        let of_imus = self.of_imus(&calibrated, &imus, &judged, &confirmed);
        judged.extend(of_imus);
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
        let of_imus = self.of_imus(&newest, &imus, &judged, &confirmed_of(firing.iter()).collect());
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
        confirmed: &Confirmed,
    ) -> Vec<SharedVerdict> {
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
                let is_confirmed = gyros.iter().any(|one| confirmed.contains(&(one.gyro, column)));
                let asked = ImuQuestion {
                    limit,
                    confidence: limits.confidence,
                    station: shift_of(station, coefficient, of_stations),
                    confirmed: is_confirmed,
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

    /// Whether no limit is set for a rule of what is shared.
    pub fn is_switched_off(&self, rule: Rule) -> bool {
        let limits = self.config.judging.limits("", "");
        [limits.d_i, limits.d_s].iter().all(|drift| drift.of(rule).is_none())
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

/// Those of these alerts that a second campaign has confirmed.
fn confirmed_of<'a>(firing: impl Iterator<Item = &'a AlertRow>) -> impl Iterator<Item = (u32, usize)> {
    let critical = firing.filter(|row| row.rule.can_be_shared() && row.alert.severity == Severity::Critical);
    critical.filter_map(|row| Some((row.of.gyro()?, row.coefficient.column()?)))
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
