//! What an earlier version of this program made otherwise of the model in force: stated anew after a start, in the
//! background, one IMU after the other. What is stated so already is left alone: nothing is done twice, and what was
//! broken off goes on at the next start.

use super::admit::rows_as_stated;
use super::campaign::Restated;
use crate::pipeline::Reader;
use crate::pipeline::diagnoses::background::{IdleDetector, WorkPriority, beside_others};
use crate::pipeline::diagnoses::models::InForce;
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::{Job, WeakWriteQueue};
use crate::store::{RecordRow, RestatedRow};

/// Looks for calibrations that are not stated by the model in force of their IMU, and has them stated so.
pub(in crate::pipeline) struct StaleCalibrations {
    pub reader: Reader,
    /// Weak: the writer ends when nobody but this could send to it.
    pub queue: WeakWriteQueue,
    pub idle: IdleDetector,
}

impl StaleCalibrations {
    /// Once through all IMUs with effects in their models.
    pub async fn run(self) {
        for (imu, in_force) in self.reader.models.with_effects() {
            match self.stale_of(imu, &in_force).await {
                Ok(stale) if stale.is_empty() => {}
                Ok(stale) => self.restate((imu, &in_force), stale).await,
                Err(_) if self.queue.upgrade().is_none() => return,
                Err(error) => {
                    tracing::warn!(%error, imu, "whether an IMU's calibrations are stated by its model cannot be told; the next start tries again")
                }
            }
        }
    }

    async fn stale_of(&self, imu: u32, in_force: &InForce) -> Result<Restated, StoreError> {
        let mut stale = Restated::new();
        for head in store::record::of_imu(&self.reader.store, imu, u32::MAX).await? {
            self.idle.give_way().await;
            if self.queue.upgrade().is_none() {
                return Ok(Restated::new());
            }
            let Some(row) = store::record::get(&self.reader.store, head.id).await? else { continue };
            let (row, (reader, in_force)) = (Arc::new(row), (self.reader.clone(), in_force.clone()));
            let stored = Arc::clone(&row);
            let stated = move || reader.stated_by(&stored, &in_force);
            let Some(Ok(stated)) = beside_others("restating", WorkPriority::Background, stated).await else { continue };
            let rows = rows_as_stated(&self.reader.store, &row, &stated).unwrap_or_default();
            if self.differs(&row, &rows).await? {
                stale.insert(head.id, Some(stated));
            }
        }
        Ok(stale)
    }

    async fn differs(&self, stored: &RecordRow, rows: &[RestatedRow]) -> Result<bool, StoreError> {
        let then = Span { from: stored.calibrated_at, to: stored.calibrated_at };
        let gyros: Vec<_> = rows.iter().map(|restated| (restated.row.gyro, then)).collect();
        let histories = store::histories::oldest(&self.reader.store, &gyros, 1).await?;
        let is_other = |(restated, stored): (&RestatedRow, &Vec<_>)| {
            stored.first().is_some_and(|stored| !restated.row.figures.agrees(stored))
        };
        Ok(rows.iter().zip(&histories).any(is_other))
    }

    async fn restate(&self, (imu, in_force): (u32, &InForce), stale: Restated) {
        let (Some(queue), Some(model)) = (self.queue.upgrade(), in_force.id) else { return };
        let (count, stale) = (stale.len(), Box::new((imu, model, stale)));
        let done: Result<(), Refused> = queue.ask_in_turn(|reply| Job::Restate { stale, reply }).await;
        match done {
            Ok(()) => tracing::info!(
                imu,
                calibrations = count,
                "an IMU's calibrations are stated by its model as this version does"
            ),
            Err(error) => {
                tracing::warn!(%error, imu, "an IMU's calibrations could not be stated anew; the next start tries again")
            }
        }
    }
}
