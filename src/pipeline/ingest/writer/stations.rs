//! The writer's part in alerts of stations: what the newest calibrations of the fleet say that a station does.
//!
//! A file's writer asks with every group in which a gyro begins to exceed a limit, so that the group's other gyros are
//! told of as one; the clock asks at every tick. Among several servers only the clock does, which holds every cell.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::config::Config;
use crate::core::judge::{Calibrated, Measured, Rule, ShiftQuestion, State, Verdict, station_shift};
use crate::core::time::UtcMicros;
use crate::pipeline::alerts::{AlertCache, Naming, Origin, StationVerdict};
use crate::pipeline::ingest::judge::{Judged, Newest};
use crate::store;
use crate::store::{AlertRow, Changes, Store, StoreError};

/// Calibrations that count for the comparison of stations, days.
const LATELY: f64 = 60.0;

/// What stations do to what they calibrate.
pub(super) struct StationShifts<'a> {
    pub store: &'a Store,
    pub config: &'a Config,
    pub alerts: &'a AlertCache,
    pub now: UtcMicros,
}

impl StationShifts<'_> {
    /// What stations have done to a group, where one of its gyros begins to exceed a limit.
    pub async fn of_group(&self, found: &Judged, changes: &Changes) -> Result<Vec<StationVerdict>, StoreError> {
        let begins = |newest: &Newest, verdict: &Verdict| {
            let fires = |row: &AlertRow| (row.coefficient, row.rule) == (verdict.coefficient, verdict.rule);
            verdict.severity().is_some()
                && verdict.rule.is_explained_by_station()
                && !self.alerts.firing(newest.gyro).any(fires)
        };
        let verdicts = |newest: &Newest| found.verdicts.get(&(newest.figures.record, newest.gyro));
        let begin = |newest: &&Newest| verdicts(newest).into_iter().flatten().any(|verdict| begins(newest, verdict));
        let stations: BTreeSet<u32> = found.newest.iter().filter(begin).map(|newest| newest.figures.station).collect();
        if stations.is_empty() {
            return Ok(Vec::new());
        }
        // Whether a station has shifted its own newest calibrations tell; the fleet's are only asked whether it alone has.
        let mut near = Vec::new();
        for station in &stations {
            near.extend(self.calibrated(Some(*station)).await?);
        }
        let judged = self.judged(&self.with_group(near, found, changes), &stations);
        if judged.iter().all(|one| one.verdict.state != State::Exceeded) {
            return Ok(judged);
        }
        let all = self.calibrated(None).await?;
        Ok(self.judged(&self.with_group(all, found, changes), &stations))
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

    /// What every station has done lately, and those that have an alert.
    pub async fn all(&self) -> Result<Vec<StationVerdict>, StoreError> {
        let newest = self.calibrated(None).await?;
        let recent = self.now.plus_days(-self.config.alerts.backfill_days);
        let stations = newest.iter().filter(|one| one.at >= recent).map(|one| one.station);
        let stations: BTreeSet<u32> = stations.chain(self.alerts.stations().firing().map(|(one, _)| one)).collect();
        Ok(self.judged(&newest, &stations))
    }

    fn judged(&self, newest: &[Calibrated], stations: &BTreeSet<u32>) -> Vec<StationVerdict> {
        let limits = self.config.judging.limits("", "");
        let budgets = self.budgets("", "");
        let mut found = Vec::new();
        for (station, column) in stations.iter().flat_map(|station| [(*station, 0), (*station, 1)]) {
            let limit = [&limits.d_i, &limits.d_s][column].of(Rule::StationShift);
            let Some((limit, budget)) = limit.zip(budgets[column]) else { continue };
            let column_of = |row: &AlertRow| row.coefficient.column() == Some(column);
            let fires = self.alerts.stations().firing().any(|(one, row)| one == station && column_of(row));
            let asked = ShiftQuestion { limit, budget, confidence: limits.confidence, fires };
            let verdict = station_shift(newest, station, column, &asked);
            let last = newest.iter().filter(|one| one.station == station).map(|one| one.at).max();
            let origin =
                Origin { at: last.unwrap_or(self.now), item: None, imu: None, slot: None, station: Some(station) };
            found.push(StationVerdict { station, verdict, origin });
        }
        found
    }

    /// Whether no rule compares stations.
    pub fn are_switched_off(&self) -> bool {
        let limits = self.config.judging.limits("", "");
        [limits.d_i, limits.d_s].iter().all(|drift| drift.of(Rule::StationShift).is_none())
    }

    /// The newest calibrations of the fleet, or of one station; where a station's alert fires, those since it does.
    async fn calibrated(&self, station: Option<u32>) -> Result<Vec<Calibrated>, StoreError> {
        let began = self.alerts.stations().firing().map(|(_, row)| row.alert.since).min().unwrap_or(self.now);
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

fn times(load: Option<Measured>, budget: Option<f64>) -> Option<Measured> {
    let (load, budget) = load.zip(budget)?;
    Some(Measured { value: load.value * budget, sd: load.sd.map(|sd| sd * budget) })
}
