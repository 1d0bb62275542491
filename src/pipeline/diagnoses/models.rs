//! The error model in force for each IMU: adopted by people, used by every later fit and diagnosis of that IMU.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

use crate::core::augmented::AugmentedModel;
use crate::core::fault::Faults;
use crate::core::id::Id;
use crate::pipeline::access::Actor;
use crate::pipeline::diagnoses::error::DiagnosisError;
use crate::pipeline::ingest::Accepted;
use crate::store;
use crate::store::{AccessChanges, Changes, ModelRow, Store, StoreError, Writer};
use crate::system::Clock;
use crate::wire::model;

/// A model that somebody wants to be used for an IMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Adoption {
    pub imu: String,
    pub model: AugmentedModel,
    pub author: String,
    pub reason: String,
}

/// A model with its identifier; none for the plain model that holds where nothing was adopted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InForce {
    pub id: Option<Id>,
    pub model: Arc<AugmentedModel>,
}

/// The newest model of each IMU, by its number.
#[derive(Debug, Clone, Default)]
pub(crate) struct ModelCache(Arc<RwLock<HashMap<u32, InForce>>>);

impl ModelCache {
    pub async fn load(store: &Store) -> Result<Self, StoreError> {
        let cache = Self::default();
        cache.read_again(store).await?;
        Ok(cache)
    }

    /// Takes over what others have adopted.
    pub async fn read_again(&self, store: &Store) -> Result<(), StoreError> {
        store::model::in_force(store).await?.iter().try_for_each(|row| self.note(row))
    }

    pub fn of(&self, imu: Option<u32>) -> InForce {
        let cache = self.0.read().unwrap_or_else(PoisonError::into_inner);
        imu.and_then(|imu| cache.get(&imu)).cloned().unwrap_or_default()
    }

    fn note(&self, row: &ModelRow) -> Result<(), StoreError> {
        let in_force = read(row)?;
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(row.imu, in_force);
        Ok(())
    }
}

/// A stored model.
pub(crate) fn read(row: &ModelRow) -> Result<InForce, StoreError> {
    let damaged = |faults: Faults| StoreError::Damaged(format!("model {} cannot be read: {faults}", row.id));
    let model = model::parse(row.body.as_bytes()).map_err(damaged)?;
    Ok(InForce { id: Some(row.id), model: Arc::new(model) })
}

/// What the writer does with an adoption: one transaction; the same again changes nothing.
pub(crate) async fn adopt(
    store: &Store,
    writer: &mut Writer,
    clock: &Clock,
    cache: &ModelCache,
    adoption: &Adoption,
    by: &Actor,
) -> Result<Accepted, DiagnosisError> {
    let unknown = || DiagnosisError::UnknownImu { imu: adoption.imu.clone() };
    let imu = store.names().read().imus.number(&adoption.imu).ok_or_else(unknown)?;
    let body = model::to_json(&adoption.model);
    if let Some(newest) = store::model::of_imu(store, imu).await?.first()
        && (&newest.body, &newest.author, &newest.reason) == (&body, &adoption.author, &adoption.reason)
    {
        return Ok(Accepted::There { id: newest.id, same_bytes: true });
    }
    let now = clock.now();
    let id = writer.next_id(now);
    let (author, reason) = (adoption.author.clone(), adoption.reason.clone());
    let audited = serde_json::json!({ "id": id.to_string(), "author": author, "reason": reason, "model": serde_json::from_str::<serde_json::Value>(&body).unwrap_or_default() });
    let before = cache.of(Some(imu)).id.map(|id| serde_json::json!({ "id": id.to_string() }));
    let what = ("adopt model", format!("imus/{}/model", adoption.imu));
    let audit = vec![by.line(writer.next_id(now), now, what, before.as_ref(), Some(&audited))];
    let row = ModelRow { id, imu, adopted_at: now, author, reason, body };
    let access = AccessChanges { audit, ..AccessChanges::default() };
    let changes = Changes { models: vec![row], access, ..Changes::default() };
    writer.commit(&changes).await?;
    cache.note(&changes.models[0])?;
    Ok(Accepted::stored(id))
}
