//! What a group will be asked about, read ahead in a handful of questions: one by one, each takes its own way to the
//! database and back.

use super::recent_records::RecentRecords;
use crate::core::suspect_window::Mark;
use crate::pipeline::ingest::submission::{Calibration, Submission};
use crate::pipeline::prelude::*;
use crate::store::RecordAt;

/// What is stored where a group's items are about to go. What is not in here was not asked for.
#[derive(Debug, Default)]
pub(crate) struct Prefetched {
    keys: HashMap<String, Option<(Id, Vec<u8>)>>,
    /// The records of an IMU at an instant.
    records: HashMap<(u32, UtcMicros), Vec<RecordAt>>,
    /// The record that holds a gyro's row at an instant.
    rows: HashMap<(u32, UtcMicros), Option<Id>>,
    /// How the windows of the group's stations are marked that were not remembered.
    pub marks: HashMap<u32, Vec<Mark>>,
}

impl Prefetched {
    pub async fn read<'a>(
        store: &Store,
        memory: &RecentRecords,
        items: impl Iterator<Item = &'a Submission>,
    ) -> Result<Self, StoreError> {
        let sent: Vec<&Calibration> = items.filter_map(Submission::calibration).collect();
        let mut ahead = Self::default();
        let keys: HashSet<&str> = sent.iter().filter_map(|sent| sent.idempotency_key.as_deref()).collect();
        let (mut at_imus, mut at_gyros, mut stations) = (HashSet::new(), HashSet::new(), BTreeSet::new());
        {
            let tables = store.names().read();
            for sent in &sent {
                let at = sent.calibrated_at;
                at_imus.extend(tables.imus.number(sent.imu.as_str()).map(|imu| (imu, at)));
                let station = tables.stations.number(sent.station.as_str());
                stations.extend(station.filter(|station| memory.marks(*station).is_none()));
                let gyros = sent.gyros.iter().filter_map(|gyro| tables.gyros.number(gyro.serial.as_str()));
                at_gyros.extend(gyros.filter(|gyro| !memory.is_newer(*gyro, at)).map(|gyro| (gyro, at)));
            }
        }
        let keys: Vec<&str> = keys.into_iter().collect();
        if !keys.is_empty() {
            let mut used: HashMap<String, (Id, Vec<u8>)> =
                store::keys::get_many(store, &keys).await?.into_iter().collect();
            ahead.keys = keys.into_iter().map(|key| (key.to_owned(), used.remove(key))).collect();
        }
        let at_imus: Vec<(u32, UtcMicros)> = at_imus.into_iter().collect();
        let records = store::record::at_many(store, &at_imus).await?;
        ahead.records = at_imus.into_iter().zip(records).collect();
        let at_gyros: Vec<(u32, UtcMicros)> = at_gyros.into_iter().collect();
        let spans: Vec<_> = at_gyros.iter().map(|(gyro, at)| (*gyro, Span { from: *at, to: *at })).collect();
        let rows = store::histories::oldest(store, &spans, 1).await?;
        let held = |rows: Vec<Figures>| rows.first().map(|figures| figures.record);
        ahead.rows = at_gyros.into_iter().zip(rows.into_iter().map(held)).collect();
        let stations: Vec<u32> = stations.into_iter().collect();
        ahead.marks = stations.iter().map(|station| (*station, Vec::new())).collect();
        if !stations.is_empty() {
            for row in store::suspect_window::of_stations(store, &stations).await? {
                ahead.marks.entry(row.station).or_default().push(row.mark);
            }
        }
        Ok(ahead)
    }

    /// How the windows of a station of the group are marked, oldest mark first.
    pub(super) async fn marks(&self, station: u32, store: &Store) -> Result<Vec<Mark>, StoreError> {
        match self.marks.get(&station) {
            Some(known) => Ok(known.clone()),
            None => {
                let rows = store::suspect_window::of_stations(store, &[station]).await?;
                Ok(rows.into_iter().map(|row| row.mark).collect())
            }
        }
    }

    /// What a key was used for.
    pub(super) async fn key(&self, key: &str, store: &Store) -> Result<Option<(Id, Vec<u8>)>, StoreError> {
        match self.keys.get(key) {
            Some(known) => Ok(known.clone()),
            None => store::keys::get(store, key).await,
        }
    }

    pub(super) async fn records_at(&self, imu: u32, at: UtcMicros, store: &Store) -> Result<Vec<RecordAt>, StoreError> {
        match self.records.get(&(imu, at)) {
            Some(known) => Ok(known.clone()),
            None => store::record::at(store, imu, at).await,
        }
    }

    /// The stored record that holds a gyro's row at an instant.
    pub(super) async fn row_at(&self, gyro: u32, at: UtcMicros, store: &Store) -> Result<Option<Id>, StoreError> {
        match self.rows.get(&(gyro, at)) {
            Some(known) => Ok(*known),
            None => {
                let rows = store::history::oldest(store, gyro, Span { from: at, to: at }, 1).await?;
                Ok(rows.first().map(|figures| figures.record))
            }
        }
    }
}
