//! A model comes into force: the stored calibrations of its IMU are stated by it and judged again in the same transaction,
//! so that an adoption is no step in D_I and D_S. Where this version states something otherwise than an earlier one, the
//! same happens without an adoption.

use super::forecasts;
use super::state::WriterState;
use crate::pipeline::alerts::Causes;
use crate::pipeline::diagnoses::models::adopted;
use crate::pipeline::ingest::admit::rows_as_stated;
use crate::pipeline::ingest::campaign::Restated;
use crate::pipeline::prelude::*;
use crate::pipeline::{Adoption, Calibration};

/// Puts a model in force; `restated`: the calibrations of its IMU as far as they have been stated by it.
pub(super) async fn adopt(
    state: &mut WriterState,
    (adoption, restated): &(Adoption, Restated),
    by: &Actor,
) -> Result<Accepted, Refused> {
    let (store, models) = (&state.store, &state.after.models);
    let changes = adopted(store, &mut state.writer, &state.clock, models, adoption, by).await?;
    let mut changes = match changes {
        Ok(changes) => changes,
        Err(there) => return Ok(there),
    };
    let restated = state.reader().restated(&adoption.imu, &adoption.model, restated.clone()).await?;
    let imu = changes.models[0].imu;
    let model = changes.models[0].id;
    let done = match forecasts::end(state, imu, adoption, state.clock.now()).await {
        Ok(()) => restate(state, &mut changes, &restated, model).await,
        Err(error) => Err(error),
    };
    if let Err(error) = done {
        // What is remembered is ahead of what is stored.
        state.start_over();
        return Err(error.into());
    }
    let row = &changes.models[0];
    state.after.models.note(row)?;
    Ok(Accepted::stored(row.id))
}

/// States calibrations of an IMU as the model does that was in force when they were computed, quietly. One that
/// counts no more stays as it is; a model that has come into force since has stated them all.
pub(super) async fn state_anew(
    state: &mut WriterState,
    (imu, model, stale): &(u32, Id, Restated),
) -> Result<(), Refused> {
    if state.after.models.of(Some(*imu)).id != Some(*model) {
        return Ok(());
    }
    let heads = store::record::of_imu(&state.store, *imu, u32::MAX).await?;
    let counting: HashSet<Id> = heads.into_iter().map(|head| head.id).collect();
    let stale = stale.iter().filter(|(id, _)| counting.contains(id));
    let stale: Restated = stale.map(|(id, stated)| (*id, stated.clone())).collect();
    let done = restate(state, &mut Changes::default(), &stale, *model).await;
    if let Err(error) = done {
        state.start_over();
        return Err(error.into());
    }
    Ok(())
}

async fn restate(
    state: &mut WriterState,
    changes: &mut Changes,
    restated: &Restated,
    model: Id,
) -> Result<(), StoreError> {
    let now = state.clock.now();
    let mut sent: HashMap<Id, &Calibration> = HashMap::new();
    for (id, calibration) in restated {
        let stored = if calibration.is_some() { store::record::get(&state.store, *id).await? } else { None };
        let rows = calibration.as_ref().zip(stored.as_ref());
        let rows = rows.and_then(|(stated, stored)| rows_as_stated(&state.store, stored, stated));
        let (Some(calibration), Some(rows)) = (calibration, rows) else {
            tracing::warn!(calibration = %id, "cannot be stated by the model that is adopted, and stays as it is");
            continue;
        };
        sent.insert(*id, calibration);
        changes.rejudged.restated.extend(rows);
        changes.models_used.push((*id, model));
    }
    let found = state.judge.judge(changes).await?;
    let agreements = state.agreements(changes).await?;
    let gyros = changes.rejudged.gyros_restated();
    state.alerts.recall(&state.store, gyros.iter().copied(), now).await?;
    state.follow(&sent, changes, (&found, &agreements), &Causes::default(), now).await?;
    state.enter_heads(changes).await?;
    state.commit(changes).await?;
    state.memory.forget_of(gyros);
    Ok(())
}
