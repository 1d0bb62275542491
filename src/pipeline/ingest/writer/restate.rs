//! A model comes into force: the stored calibrations of its IMU are stated by it and judged again in the same transaction,
//! so that an adoption is no step in D_I and D_S. Where this version states something otherwise than an earlier one, the
//! same happens without an adoption.

use super::forecasts::ForecastAlerts;
use super::state::WriterState;
use crate::pipeline::alerts::Causes;
use crate::pipeline::diagnoses::models::adopted;
use crate::pipeline::ingest::admit::rows_as_stated;
use crate::pipeline::ingest::campaign::Restated;
use crate::pipeline::prelude::*;
use crate::pipeline::{Adoption, Calibration};

pub(super) struct Restating<'a> {
    pub state: &'a mut WriterState,
    pub now: UtcMicros,
}

impl Restating<'_> {
    /// Puts a model in force; `restated`: the calibrations of its IMU as far as they have been stated by it.
    pub async fn adopt(
        &mut self,
        (adoption, restated): &(Adoption, Restated),
        by: &Actor,
    ) -> Result<Accepted, OrderError> {
        let (store, models) = (&self.state.store, &self.state.after.models);
        let changes = adopted(store, &mut self.state.writer, &self.state.clock, models, adoption, by).await?;
        let mut changes = match changes {
            Ok(changes) => changes,
            Err(there) => return Ok(there),
        };
        let restated = self.state.reader().restated(&adoption.imu, &adoption.model, restated.clone()).await?;
        let imu = changes.models[0].imu;
        let model = changes.models[0].id;
        let done = match (ForecastAlerts { state: self.state, now: self.now }).end(imu, adoption).await {
            Ok(()) => self.restate(&mut changes, &restated, model).await,
            Err(error) => Err(error),
        };
        if let Err(error) = done {
            // What is remembered is ahead of what is stored.
            self.state.start_over();
            return Err(error.into());
        }
        let row = &changes.models[0];
        self.state.after.models.note(row)?;
        Ok(Accepted::stored(row.id))
    }

    /// States calibrations of an IMU as the model does that was in force when they were computed, quietly. One that
    /// counts no more stays as it is; a model that has come into force since has stated them all.
    pub async fn state_anew(&mut self, (imu, model, stale): &(u32, Id, Restated)) -> Result<(), WriteError> {
        if self.state.after.models.of(Some(*imu)).id != Some(*model) {
            return Ok(());
        }
        let heads = store::record::of_imu(&self.state.store, *imu, u32::MAX).await.map_err(StorageError::from)?;
        let counting: HashSet<Id> = heads.into_iter().map(|head| head.id).collect();
        let stale = stale.iter().filter(|(id, _)| counting.contains(id));
        let stale: Restated = stale.map(|(id, stated)| (*id, stated.clone())).collect();
        let done = self.restate(&mut Changes::default(), &stale, *model).await;
        if let Err(error) = done {
            self.state.start_over();
            return Err(StorageError::from(error).into());
        }
        Ok(())
    }

    async fn restate(&mut self, changes: &mut Changes, restated: &Restated, model: Id) -> Result<(), StoreError> {
        let now = self.now;
        let mut sent: HashMap<Id, &Calibration> = HashMap::new();
        for (id, calibration) in restated {
            let stored = if calibration.is_some() { store::record::get(&self.state.store, *id).await? } else { None };
            let rows = calibration.as_ref().zip(stored.as_ref());
            let rows = rows.and_then(|(stated, stored)| rows_as_stated(&self.state.store, stored, stated));
            let (Some(calibration), Some(rows)) = (calibration, rows) else {
                tracing::warn!(calibration = %id, "cannot be stated by the model that is adopted, and stays as it is");
                continue;
            };
            sent.insert(*id, calibration);
            changes.rejudged.restated.extend(rows);
            changes.models_used.push((*id, model));
        }
        let found = self.state.judge.judge(changes).await?;
        let agreements = self.state.agreements(changes).await?;
        let gyros = changes.rejudged.gyros_restated();
        self.state.alerts.recall(&self.state.store, gyros.iter().copied(), now).await?;
        self.state.follow(&sent, changes, (&found, &agreements), &Causes::default(), now).await?;
        self.state.enter_heads(changes).await?;
        self.state.commit(changes).await?;
        self.state.memory.forget_of(gyros);
        Ok(())
    }
}
