//! Rows of the history as the diagnosis of change takes them.

use crate::config::JudgedMethod;
use crate::core::changes::{GyroHistory, HistoryEntry};
use crate::pipeline::ingest::judge::gyro_window::sample_of;
use crate::pipeline::prelude::*;

/// Newest records of each gyro that tell what stations do.
pub(super) const PEER_RECORDS: usize = 100;
/// Most gyros by which stations are compared, and fewest of each station where it has so many.
const FLEET: usize = 600;
const FEWEST: usize = 20;
/// They are taken from so many parts of the fleet.
const PARTS: u32 = 4;

/// Records of the fleet's gyros, without their temperatures and events; of a large fleet, of as many gyros of every
/// station, spread over it.
pub(super) async fn fleet_histories(store: &Store, method: JudgedMethod) -> Result<Vec<GyroHistory>, StoreError> {
    let (mut gyros, stations): (Vec<u32>, Vec<u32>) = {
        let tables = store.names().read();
        (tables.gyros.numbers(), tables.stations.numbers())
    };
    if gyros.len() > FLEET {
        let each = (FLEET / stations.len().max(1)).max(FEWEST).div_ceil(PARTS as usize);
        let last = gyros.iter().max().copied().unwrap_or_default();
        let mut some = BTreeSet::new();
        for (station, part) in stations.iter().flat_map(|station| (0..PARTS).map(move |part| (*station, part))) {
            some.extend(store::head::near(store, station, last / (PARTS - 1) * part, each).await?);
        }
        gyros = some.into_iter().collect();
    }
    let rows = store::histories::newest_ever(store, &gyros, PEER_RECORDS).await?;
    let history =
        |rows: &Vec<Figures>| GyroHistory { entries: entries(store, method, rows, &HashMap::new()), marks: Vec::new() };
    Ok(rows.iter().map(history).collect())
}

pub(super) fn entries(
    store: &Store,
    method: JudgedMethod,
    rows: &[Figures],
    temperatures: &HashMap<Id, f64>,
) -> Vec<HistoryEntry> {
    let tables = store.names().read();
    let entry = |figures: &Figures| HistoryEntry {
        at: figures.at,
        station: tables.stations.text(figures.station).into(),
        imu: tables.imus.text(figures.imu).into(),
        slot: figures.slot,
        temperature_c: temperatures.get(&figures.record).copied(),
        d: sample_of(figures, method).d,
    };
    rows.iter().map(entry).collect()
}
