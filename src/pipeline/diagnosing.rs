//! Diagnoses of stored campaigns: computed in the background once they are stored, kept while they are asked for.
//!
//! A diagnosis is a function of the stored campaign and the model in force for its IMU, and takes some tenths of a
//! second. It is not stored: what is answered is always what this version of the program finds, against the model in
//! force now. One that is not there (after a restart, or forgotten) is computed when it is asked for.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};

use super::Pipeline;
use super::campaign::damaged;
use super::models::ModelBook;
use crate::core::campaign::Campaign;
use crate::core::diagnose::{Diagnosis, Options, Refusal, diagnose};
use crate::store::{Id, Kind, Store, StoreError};
use crate::wire::campaign;

/// Computed at the same time: records are to be stored meanwhile.
const AT_ONCE: usize = 2;
/// How many are kept: what came in lately, and what a few engineers look at in turn.
const KEPT: usize = 256;
/// Campaigns that wait for the background. Beyond, they are computed when they are asked for.
pub(super) const MOST_WAITING: usize = 256;
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

/// One diagnosis, and what it was computed against.
#[derive(Debug, Clone)]
struct Known {
    campaign: Id,
    imu: u32,
    model: Option<Id>,
    diagnosed: Diagnosed,
}

/// Who computes diagnoses and keeps them. Cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct Diagnoser {
    store: Store,
    models: ModelBook,
    turns: Arc<Semaphore>,
    known: Arc<Mutex<VecDeque<Known>>>,
}

impl Diagnoser {
    pub fn new(store: Store, models: ModelBook) -> Self {
        Self { store, models, turns: Arc::new(Semaphore::new(AT_ONCE)), known: Arc::default() }
    }

    /// Diagnoses what has been stored, one after the other, until nobody can store any more.
    pub async fn run(self, mut stored: mpsc::Receiver<Id>) {
        while let Some(id) = stored.recv().await {
            if let Err(error) = self.diagnosis(id, Duration::MAX).await {
                tracing::warn!(%error, campaign = %id, "a campaign could not be diagnosed; it will be when it is asked for");
            }
        }
    }

    /// What was computed against an earlier model of the IMU is computed again.
    pub fn model_changed(&self, imu: Option<u32>, queue: &mpsc::Sender<Id>) {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        for known in known.iter().filter(|known| Some(known.imu) == imu) {
            // Where the queue is full it is computed when it is asked for.
            let _full = queue.try_send(known.campaign);
        }
    }

    /// The diagnosis of a stored campaign against the model in force, computed on a thread for that.
    async fn diagnosis(&self, id: Id, patience: Duration) -> Result<Asked, StoreError> {
        if let Some(diagnosed) = self.recall(id) {
            return Ok(Asked::Answered(diagnosed));
        }
        let Some(row) = self.store.record(id).await?.filter(|row| row.kind == Kind::Campaign) else {
            return Ok(Asked::NoSuchCampaign);
        };
        let Some(turn) = self.turn(patience).await else { return Ok(Asked::Waiting) };
        // Whoever asked at the same time may have had the turn before.
        if let Some(diagnosed) = self.recall(id) {
            return Ok(Asked::Answered(diagnosed));
        }
        let campaign = campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(id, &faults))?;
        let in_force = self.models.of(Some(row.imu));
        let options = in_force.model.options_as_asked(&campaign);
        let known = |diagnosed| Known { campaign: id, imu: row.imu, model: in_force.id, diagnosed };
        let diagnosed = self.compute(campaign, options, turn).await?;
        self.keep(known(Arc::clone(&diagnosed)));
        Ok(Asked::Answered(diagnosed))
    }

    async fn turn(&self, patience: Duration) -> Option<OwnedSemaphorePermit> {
        let turn = tokio::time::timeout(patience, Arc::clone(&self.turns).acquire_owned()).await;
        turn.ok().and_then(Result::ok)
    }

    async fn compute(
        &self,
        campaign: Campaign,
        options: Options,
        turn: OwnedSemaphorePermit,
    ) -> Result<Diagnosed, StoreError> {
        let work = tokio::task::spawn_blocking(move || {
            // The turn is over when the work is, whether or not the caller has gone.
            let _turn = turn;
            Arc::new(diagnose(&campaign, &options))
        });
        work.await.map_err(|error| StoreError::Damaged(format!("a diagnosis failed: {error}")))
    }

    fn recall(&self, id: Id) -> Option<Diagnosed> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.iter().find(|known| known.campaign == id)?;
        (self.models.of(Some(found.imu)).id == found.model).then(|| Arc::clone(&found.diagnosed))
    }

    fn keep(&self, new: Known) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|known| known.campaign != new.campaign);
        known.truncate(KEPT - 1);
        known.push_front(new);
    }
}

impl Pipeline {
    /// The diagnosis of a stored campaign against the model in force for its IMU.
    ///
    /// # Errors
    /// [`StoreError`], where the campaign cannot be read.
    pub async fn diagnosis(&self, id: Id) -> Result<Asked, StoreError> {
        self.diagnoser.diagnosis(id, PATIENCE).await
    }
}
