//! The error model in force for each IMU: adopted by people, used by every later fit and diagnosis of that IMU;
//! and the hypotheses of one's own that compete in every diagnosis of the service.

use std::sync::{PoisonError, RwLock};

use crate::core::augmented::AugmentedModel;
use crate::core::diagnose::METHOD;
use crate::core::effects::Effect;
use crate::pipeline::prelude::*;
use crate::store::{HypothesisRow, ModelRow, Writer};
use crate::wire::hypothesis::HypothesisBody;
use crate::wire::model;

/// A model that somebody wants to be used for an IMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Adoption {
    pub imu: String,
    pub model: Arc<AugmentedModel>,
    pub author: String,
    pub reason: String,
}

/// A model with its identifier; none for the plain model that holds where nothing was adopted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InForce {
    pub id: Option<Id>,
    pub model: Arc<AugmentedModel>,
}

impl InForce {
    /// The model that records are stated by: one that knows effects of temperature.
    pub fn of_records(&self) -> Option<Id> {
        self.id.filter(|_| self.model.restates_at().is_some())
    }
}

/// One that competes.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredHypothesis {
    pub effect: Effect,
    pub row: HypothesisRow,
}

/// Which program a kept diagnosis is of, without hypotheses of one's own.
fn program() -> String {
    format!("{}, method {METHOD}", env!("CARGO_PKG_VERSION"))
}

/// Those that compete, and the program that makes diagnoses with them.
#[derive(Debug, Clone)]
pub(crate) struct Competing {
    pub hypotheses: Vec<StoredHypothesis>,
    pub program: String,
}

impl Default for Competing {
    fn default() -> Self {
        Self { hypotheses: Vec::new(), program: program() }
    }
}

impl Competing {
    pub async fn read(store: &Store) -> Result<Self, StoreError> {
        let rows = store::hypothesis::in_force(store).await?;
        let mut hasher = crc32fast::Hasher::new();
        rows.iter().for_each(|row| hasher.update(row.body.as_bytes()));
        let program =
            if rows.is_empty() { program() } else { format!("{}, hypotheses {:08x}", program(), hasher.finalize()) };
        Ok(Self { hypotheses: rows.into_iter().map(stored).collect::<Result<_, _>>()?, program })
    }

    pub fn effects(&self) -> impl Iterator<Item = Effect> {
        self.hypotheses.iter().map(|stored| stored.effect)
    }
}

/// As it is used.
fn stored(row: HypothesisRow) -> Result<StoredHypothesis, StoreError> {
    let damaged = |why: &dyn std::fmt::Display| StoreError::damaged(format_args!("hypothesis {}: {why}", row.id));
    let body: HypothesisBody = serde_json::from_str(&row.body).map_err(|error| damaged(&error))?;
    let effect = body.to_core().map_err(|faults: Faults| damaged(&faults))?;
    Ok(StoredHypothesis { effect, row })
}

/// The newest model of each IMU, by its number, and the hypotheses that compete in all diagnoses.
#[derive(Debug, Clone, Default)]
pub(crate) struct ModelCache(Arc<RwLock<HashMap<u32, InForce>>>, Arc<RwLock<Arc<Competing>>>);

impl ModelCache {
    pub async fn load(store: &Store) -> Result<Self, StoreError> {
        let cache = Self::default();
        cache.read_again(store).await?;
        Ok(cache)
    }

    /// Takes over what others have adopted.
    pub async fn read_again(&self, store: &Store) -> Result<(), StoreError> {
        let competing = Competing::read(store).await?;
        *self.1.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(competing);
        store::model::in_force(store).await?.iter().try_for_each(|row| self.note(row))
    }

    /// Hypotheses of one's own that compete in all diagnoses.
    pub fn competing(&self) -> Arc<Competing> {
        Arc::clone(&self.1.read().unwrap_or_else(PoisonError::into_inner))
    }

    pub fn of(&self, imu: Option<u32>) -> InForce {
        let cache = self.0.read().unwrap_or_else(PoisonError::into_inner);
        imu.and_then(|imu| cache.get(&imu)).cloned().unwrap_or_default()
    }

    /// IMUs by their numbers, and their models in force that hold effects.
    pub fn with_effects(&self) -> Vec<(u32, InForce)> {
        let cache = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let with_effects = cache.iter().filter(|(_, in_force)| !in_force.model.effects.is_empty());
        with_effects.map(|(imu, in_force)| (*imu, in_force.clone())).collect()
    }

    /// A model that was read before a newer one was noted changes nothing.
    pub fn note(&self, row: &ModelRow) -> Result<(), StoreError> {
        let in_force = read(row)?;
        let mut cache = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if cache.get(&row.imu).is_none_or(|known| known.id < in_force.id) {
            cache.insert(row.imu, in_force);
        }
        Ok(())
    }
}

/// A stored model.
pub(crate) fn read(row: &ModelRow) -> Result<InForce, StoreError> {
    let damaged = |faults: Faults| StoreError::damaged(format_args!("model {} cannot be read: {faults}", row.id));
    let model = model::parse_stored(row.body.as_bytes()).map_err(damaged)?;
    Ok(InForce { id: Some(row.id), model: Arc::new(model) })
}

/// What an adoption writes; or the one in force, where it is the same.
pub(crate) async fn adopted(
    store: &Store,
    writer: &mut Writer,
    clock: &Clock,
    cache: &ModelCache,
    adoption: &Adoption,
    by: &Actor,
) -> Result<Result<Changes, Accepted>, Refused> {
    let unknown = || Problem::new(404, "title_unknown_imu", message!("unknown_imu", imu = adoption.imu.clone()));
    let imu = store.names().read().imus.number(&adoption.imu).ok_or_else(unknown)?;
    let body = model::to_json(&adoption.model);
    if let Some(newest) = store::model::of_imu(store, imu).await?.first()
        && (&newest.body, &newest.author, &newest.reason) == (&body, &adoption.author, &adoption.reason)
    {
        return Ok(Err(Accepted::there(newest.id)));
    }
    let now = clock.now();
    let id = writer.next_id(now);
    let (author, reason) = (adoption.author.clone(), adoption.reason.clone());
    let audited = serde_json::json!({ "id": id.to_string(), "author": author, "reason": reason, "model": serde_json::from_str::<serde_json::Value>(&body).unwrap_or_default() });
    let before = cache.of(Some(imu)).id.map(|id| serde_json::json!({ "id": id.to_string() }));
    let what = ("adopt model", format!("imus/{}/model", adoption.imu));
    let mut changes = Changes::default();
    changes.access.audit.push(by.line(writer.next_id(now), now, what, before.as_ref(), Some(&audited)));
    changes.models.push(ModelRow { id, imu, adopted_at: now, author, reason, body });
    Ok(Ok(changes))
}
