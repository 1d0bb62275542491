//! A gyro's history as the diagnosis of change needs it, with the fleet beside it.

use std::collections::{HashMap, HashSet};

use crate::core::changes::{Entry, GyroHistory, HistoryDiagnosis, diagnose_history};
use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::time::Span;
use crate::pipeline::error::StorageError;
use crate::pipeline::ingest::judge::gyro_window::{load_marks, sample_of};
use crate::pipeline::queries::gyro_history::Histories;
use crate::store;
use crate::store::StoreError;
use crate::words;

/// Newest records of the gyro itself, and of each peer, that are looked at. The search tries every instant, and the
/// stations' offsets take one column a peer.
const OWN_RECORDS: usize = 300;
const PEER_RECORDS: usize = 100;
/// Most peers that count, and most gyros that are asked whether they are one: those with the nearest numbers, which
/// came to the service at the same time.
const PEERS: usize = 40;
const ASKED: usize = 200;

/// Why a gyro's coefficients changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainedHistory {
    /// Other gyros that met the same stations.
    pub peers: usize,
    /// D_I, D_S, D_O.
    pub coefficients: Vec<HistoryDiagnosis>,
}

impl Histories {
    /// Diagnoses the history of a gyro. Computes for some milliseconds, on a thread for that.
    pub async fn explain(&self, gyro: u32) -> Result<ExplainedHistory, StorageError> {
        let own = store::history::newest(&self.store, gyro, Span::EVER, OWN_RECORDS).await?;
        let stations: HashSet<u32> = own.iter().map(|figures| figures.station).collect();
        let temperatures = store::history::temperatures(&self.store, gyro).await?.into_iter().collect();
        let history = self.history_of(gyro, &own, &temperatures).await?;
        let mut peers = Vec::new();
        for other in self.neighbours(gyro) {
            let rows = store::history::newest(&self.store, other, Span::EVER, PEER_RECORDS).await?;
            if rows.iter().any(|figures| stations.contains(&figures.station)) {
                peers.push(self.history_of(other, &rows, &HashMap::new()).await?);
            }
            if peers.len() == PEERS {
                break;
            }
        }
        let explained = words::spawn_blocking(move || {
            let coefficients = diagnose_history(&history, &peers);
            ExplainedHistory { peers: peers.len(), coefficients }
        });
        let failed =
            |error| StoreError::Damaged(format!("the history of gyro number {gyro} could not be diagnosed: {error}"));
        Ok(explained.await.map_err(failed)?)
    }

    /// Other gyros, nearest number first.
    fn neighbours(&self, gyro: u32) -> Vec<u32> {
        let mut others: Vec<u32> = self.store.names().read().gyros.iter().map(|(number, _)| number).collect();
        others.retain(|&number| number != gyro);
        others.sort_by_key(|number| number.abs_diff(gyro));
        others.truncate(ASKED);
        others
    }

    async fn history_of(
        &self,
        gyro: u32,
        rows: &[Figures],
        temperatures: &HashMap<Id, f64>,
    ) -> Result<GyroHistory, StoreError> {
        let marks = load_marks(&self.store, gyro).await?;
        let tables = self.store.names().read();
        let name = |name: Option<&std::sync::Arc<str>>| name.map_or_else(String::new, |name| name.to_string());
        let entries = rows.iter().map(|figures| Entry {
            at: figures.at,
            station: name(tables.stations.name(figures.station)),
            seat: format!("{}/{}", name(tables.imus.name(figures.imu)), figures.slot.name()),
            temperature_c: temperatures.get(&figures.record).copied(),
            d: sample_of(figures, self.config.judging.method).d,
        });
        Ok(GyroHistory { entries: entries.collect(), marks })
    }
}
