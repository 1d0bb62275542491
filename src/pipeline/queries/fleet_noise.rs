//! The noise constants of the whole fleet, from its history.

use crate::core::judge::{FleetNoise, Series, fit_fleet};
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, marks_of, sample_of};
use crate::pipeline::prelude::*;
use crate::pipeline::queries::fleet::Fleet;

/// Gyros whose histories are read at once.
const AT_ONCE: usize = 64;

impl Fleet {
    /// Fits correlation and walk to every gyro's stored history. Reads all of it.
    pub async fn noise(&self) -> Result<FleetNoise, StorageError> {
        let gyros: Vec<u32> = self.store.names().read().gyros.numbers();
        let method = self.config.judging.method;
        let mut all: Vec<Series> = Vec::with_capacity(gyros.len());
        for some in gyros.chunks(AT_ONCE) {
            let mut marks = marks_of(&self.store, some).await?;
            let ever: Vec<_> = some.iter().map(|gyro| (*gyro, Span::EVER)).collect();
            for (gyro, rows) in some.iter().zip(store::histories::oldest(&self.store, &ever, i32::MAX as usize).await?)
            {
                let samples = rows.iter().map(|figures| sample_of(figures, method)).collect();
                all.push(GyroWindow::of_all(samples, marks.remove(gyro).unwrap_or_default()).samples().clone());
            }
        }
        Ok(fit_fleet(&all))
    }
}
