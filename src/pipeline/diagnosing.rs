//! Diagnoses of stored campaigns: computed when they are asked for, a few at a time, the last ones remembered.
//!
//! A diagnosis is a function of the stored campaign alone and takes some tenths of a second, so it is not stored: what is
//! answered is always what this version of the program finds.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Semaphore;

use super::Pipeline;
use super::campaign::damaged;
use crate::core::diagnose::{Diagnosis, Options, Refusal, diagnose};
use crate::store::{Id, Kind, StoreError};
use crate::wire::campaign;

/// Computed at the same time: records are to be stored meanwhile.
const AT_ONCE: usize = 2;
/// How many are remembered: what a few engineers look at in turn.
const REMEMBERED: usize = 64;
/// How long a caller waits for its turn.
const PATIENCE: Duration = Duration::from_secs(10);

/// Why there is a diagnosis, or none.
pub type Diagnosed = Arc<Result<Diagnosis, Refusal>>;

/// What has become of the question.
#[derive(Debug, Clone)]
pub enum Asked {
    NoSuchCampaign,
    /// Others are being computed; ask again.
    Waiting,
    Answered(Diagnosed),
}

#[derive(Debug)]
pub(super) struct Diagnoses {
    turns: Arc<Semaphore>,
    remembered: Mutex<VecDeque<(Id, Diagnosed)>>,
}

impl Default for Diagnoses {
    fn default() -> Self {
        Self { turns: Arc::new(Semaphore::new(AT_ONCE)), remembered: Mutex::default() }
    }
}

impl Diagnoses {
    fn recall(&self, id: Id) -> Option<Diagnosed> {
        let remembered = self.remembered.lock().unwrap_or_else(PoisonError::into_inner);
        remembered.iter().find(|(known, _)| *known == id).map(|(_, diagnosed)| Arc::clone(diagnosed))
    }

    fn remember(&self, id: Id, diagnosed: &Diagnosed) {
        let mut remembered = self.remembered.lock().unwrap_or_else(PoisonError::into_inner);
        remembered.truncate(REMEMBERED - 1);
        remembered.push_front((id, Arc::clone(diagnosed)));
    }
}

impl Pipeline {
    /// The diagnosis of a stored campaign against its own model, computed on a thread for that.
    pub async fn diagnosis(&self, id: Id) -> Result<Asked, StoreError> {
        if let Some(diagnosed) = self.diagnoses.recall(id) {
            return Ok(Asked::Answered(diagnosed));
        }
        let Some(row) = self.store.record(id).await?.filter(|row| row.kind == Kind::Campaign) else {
            return Ok(Asked::NoSuchCampaign);
        };
        let campaign = campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(id, &faults))?;
        let turn = tokio::time::timeout(PATIENCE, Arc::clone(&self.diagnoses.turns).acquire_owned()).await;
        let Ok(Ok(turn)) = turn else { return Ok(Asked::Waiting) };
        // Whoever asked at the same time may have had the turn before.
        if let Some(diagnosed) = self.diagnoses.recall(id) {
            return Ok(Asked::Answered(diagnosed));
        }
        let diagnoses = Arc::clone(&self.diagnoses);
        let work = tokio::task::spawn_blocking(move || {
            // The turn is over when the work is, whether or not the caller has gone.
            let _turn = turn;
            let diagnosed = Arc::new(diagnose(&campaign, &Options::default()));
            diagnoses.remember(id, &diagnosed);
            diagnosed
        });
        let diagnosed = work.await.map_err(|error| StoreError::Damaged(format!("diagnosis of {id}: {error}")))?;
        Ok(Asked::Answered(diagnosed))
    }
}
