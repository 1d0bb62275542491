//! How far each IMU and gyro has come.

use std::collections::HashMap;

use crate::core::history_note::FAR_DAYS;
use crate::core::time::Span;
use crate::core::time::UtcMicros;
use crate::pipeline::ingest::judge;
use crate::pipeline::ingest::submission::Calibration;
use crate::store;
use crate::store::{Changes, HistoryRow, RecordRow, Store, StoreError, Tables};

/// The newest record of each IMU, and of each gyro with its IMU: what is newer still is new, without asking the
/// database.
#[derive(Debug, Default)]
pub(crate) struct Newest {
    pub(super) imus: HashMap<u32, UtcMicros>,
    gyros: HashMap<u32, (UtcMicros, u32)>,
}

impl Newest {
    pub async fn load(store: &Store) -> Result<Self, StoreError> {
        let imus = store::record::newest_of_imus(store).await?.into_iter().collect();
        let gyros = store::gyro::newest_of_gyros(store, 0, u32::MAX).await?.into_iter();
        Ok(Self { imus, gyros: gyros.filter_map(|(gyro, figures)| figures.map(|f| (gyro, (f.at, f.imu)))).collect() })
    }

    /// Whether the IMU has nothing at this instant, and nothing newer.
    pub(super) fn is_new(&self, imu: u32, at: UtcMicros) -> bool {
        self.imus.get(&imu).is_none_or(|newest| *newest < at)
    }

    /// As [`Newest::is_new`], of a gyro.
    pub(super) fn is_new_of(&self, gyro: u32, at: UtcMicros) -> bool {
        self.gyros.get(&gyro).is_none_or(|(newest, _)| *newest < at)
    }

    /// Whether a calibration is of a known IMU, station and gyros, and newer than all there is of them, but not by
    /// decades: then nothing that is stored can stand in its way.
    pub fn passed_by(&self, sent: &Calibration, tables: &Tables) -> bool {
        let at = sent.calibrated_at;
        let imu = tables.imus.number(sent.imu.as_str()).and_then(|imu| self.imus.get(&imu));
        let newest = |serial| tables.gyros.number(serial).and_then(|gyro| self.gyros.get(&gyro));
        imu.is_some_and(|newest| *newest < at)
            && tables.stations.number(sent.station.as_str()).is_some()
            && sent.gyros.iter().all(|gyro| {
                newest(gyro.serial.as_str())
                    .is_some_and(|(newest, _)| *newest < at && at.days_since(*newest) <= FAR_DAYS)
            })
    }

    /// What is known of the IMUs and gyros that `changes` are of.
    pub fn of(&self, changes: &Changes) -> Self {
        let of_record = |record: &RecordRow| Some((record.imu, *self.imus.get(&record.imu)?));
        let of_row = |row: &HistoryRow| Some((row.gyro, *self.gyros.get(&row.gyro)?));
        let imus = changes.records.iter().filter_map(of_record).collect();
        Self { imus, gyros: changes.history.iter().filter_map(of_row).collect() }
    }

    /// Takes back what was learned of changes that were not committed: `before` is what was known of theirs, which
    /// was known of all.
    pub fn unlearn(&mut self, before: Self) {
        self.imus.extend(before.imus);
        self.gyros.extend(before.gyros);
    }

    /// Takes note of what has been committed, or is about to be.
    pub fn learn(&mut self, changes: &Changes, found: &[judge::Newest]) {
        for record in &changes.records {
            let newest = self.imus.entry(record.imu).or_insert(record.calibrated_at);
            *newest = record.calibrated_at.max(*newest);
        }
        for row in &changes.history {
            let seen = (row.figures.at, row.figures.imu);
            let newest = self.gyros.entry(row.gyro).or_insert(seen);
            *newest = seen.max(*newest);
        }
        for gyro in changes.withdrawn.gyros() {
            match found.iter().rfind(|newest| newest.gyro == gyro) {
                Some(newest) => self.gyros.insert(gyro, (newest.figures.at, newest.figures.imu)),
                None => self.gyros.remove(&gyro),
            };
        }
    }

    /// Takes note of a record that another server has committed.
    pub fn learn_of(&mut self, imu: u32, at: UtcMicros, gyros: &[u32]) {
        let newest = self.imus.entry(imu).or_insert(at);
        *newest = at.max(*newest);
        for gyro in gyros {
            let newest = self.gyros.entry(*gyro).or_insert((at, imu));
            *newest = (at, imu).max(*newest);
        }
    }

    /// Reads the newest records of some gyros again.
    pub async fn read_again(&mut self, store: &Store, gyros: &[u32]) -> Result<(), StoreError> {
        let ever: Vec<_> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        for (gyro, rows) in gyros.iter().zip(store::histories::newest(store, &ever, 1).await?) {
            match rows.last() {
                Some(newest) => self.gyros.insert(*gyro, (newest.at, newest.imu)),
                None => self.gyros.remove(gyro),
            };
        }
        Ok(())
    }

    /// Each gyro with its newest record's instant and IMU.
    pub fn gyros(&self) -> impl Iterator<Item = (u32, UtcMicros, u32)> {
        self.gyros.iter().map(|(&gyro, &(at, imu))| (gyro, at, imu))
    }
}
