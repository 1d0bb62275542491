//! Diagnoses of stored campaigns: made in the background once a campaign is stored, kept, made again when the model in force
//! for its IMU or the program has changed.
//!
//! A campaign is due from the transaction that stores it, its IMU's from the one that adopts a model: what was due when
//! the service stopped is made after its start. Whoever asks for one that is due comes first, and waits or asks again.
//!
//! [`jobs`] takes orders to diagnose many campaigns, [`queue`] works them off behind what is due, [`summary`] says what many
//! diagnoses say together, from the [`digest`] that is kept of each.

pub(super) mod background;
pub(super) mod digest;
mod jobs;
pub(super) mod models;
mod queue;
mod summary;

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{Semaphore, mpsc, oneshot, watch};

use super::{Job, Pipeline, Refused};
use crate::core::campaign::Campaign;
use crate::core::diagnose::{METHOD, NoReference, Reference, diagnose, split};
use crate::core::message::Message;
use crate::core::time::UtcMicros;
use crate::message;
use crate::pipeline::diagnoses::background::{Awaited, Bustle, beside_others};
use crate::pipeline::diagnoses::digest::{Gist, Seat, seats};
use crate::pipeline::diagnoses::models::{InForce, ModelBook};
use crate::pipeline::ingest::campaign::damaged;
use crate::pipeline::ingest::submission::anything;
use crate::store;
use crate::store::{
    Changes, DiagnosisRow, Id, JobChanges, Kind, NewDiagnosis, RecordRow, SettledTask, Store, StoreError, Writer,
};
use crate::system::Clock;
use crate::telemetry;
use crate::wire::campaign;
use crate::wire::diagnosis::{DiagnosisBody, residuals};
use crate::wire::message::{from_stored, to_stored};
use crate::wire::record::parse_record;
use crate::wire::split::SplitBody;

pub(super) use jobs::JobDesk;
pub use jobs::{DiagnosisOrder, WantedDiagnoses};
pub use summary::SummaryFilter;

/// Computed at the same time at the least, where there is but one processor: one asked for need not wait for another.
const AT_ONCE: usize = 2;
/// How many are kept in memory: what came in lately, and what a few engineers look at in turn.
const IN_MEMORY: usize = 32;
/// The answer, or why there is none.
pub type Diagnosed = Arc<Result<DiagnosisBody, Message>>;

/// What has become of the question.
#[derive(Debug, Clone)]
pub enum Asked {
    NoSuchCampaign,
    /// It is being made; ask again.
    Waiting,
    Answered(Diagnosed),
}

/// One diagnosis, and what it was made against.
#[derive(Debug, Clone)]
struct Known {
    campaign: Id,
    imu: u32,
    model: Option<Id>,
    diagnosed: Diagnosed,
}

/// What has come of a campaign that was to be diagnosed.
#[derive(Debug)]
pub(super) struct Made {
    campaign: Id,
    begun_at: UtcMicros,
    ended_at: UtcMicros,
    outcome: Outcome,
}

#[derive(Debug)]
enum Outcome {
    Known {
        known: Known,
        gyros: Vec<Seat>,
    },
    /// There is no answer, not even why the campaign leaves none: a fault of the program or of the disk.
    Failed(String),
}

/// Those who wait for one that is being made learn of its end.
type UnderWay = HashMap<(Id, Option<Id>), watch::Receiver<Option<Diagnosed>>>;

/// Who makes diagnoses and has them kept. Cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct Diagnoser {
    store: Store,
    models: ModelBook,
    clock: Clock,
    /// Weak: the writer ends when nobody but this could send to it.
    jobs: mpsc::WeakSender<Job>,
    bustle: Bustle,
    /// How many are computed at the same time.
    at_once: usize,
    turns: Arc<Semaphore>,
    under_way: Arc<Mutex<UnderWay>>,
    known: Arc<Mutex<VecDeque<Known>>>,
}

/// Which program a kept diagnosis is of.
fn program() -> String {
    format!("{}, method {METHOD}", env!("CARGO_PKG_VERSION"))
}

impl Known {
    fn row(&self) -> DiagnosisRow {
        let (refused, body) = match &*self.diagnosed {
            Ok(body) => (false, text(body)),
            Err(why) => (true, to_stored(why)),
        };
        DiagnosisRow { record: self.campaign, model: self.model, program: program(), refused, body }
    }
}

fn text(body: &impl serde::Serialize) -> String {
    serde_json::to_string(body).expect("strings and finite numbers always serialise")
}

impl Made {
    /// What the writer does with it: one transaction, unless another model has come into force meanwhile. Orders that wait for
    /// the campaign are told in the same.
    pub async fn keep(&self, writer: &mut Writer, models: &ModelBook) -> Result<(), Refused> {
        let Self { campaign, begun_at, ended_at, outcome } = self;
        let mut changes = Changes::default();
        let failed = match outcome {
            Outcome::Known { known, .. } if models.of(Some(known.imu)).id != known.model => return Ok(()),
            Outcome::Known { known, gyros } => {
                let gist = text(&Gist::of(gyros.clone(), &known.diagnosed));
                changes.diagnoses.push(NewDiagnosis { row: known.row(), gist });
                known.diagnosed.as_ref().as_ref().err().map(to_stored)
            }
            Outcome::Failed(why) => Some(why.clone()),
        };
        let settled = vec![SettledTask { record: *campaign, begun_at: *begun_at, ended_at: *ended_at, failed }];
        changes.diagnosis_jobs = JobChanges { settled, ..JobChanges::default() };
        Ok(writer.commit(&changes).await?)
    }
}

impl Diagnoser {
    pub fn new(store: Store, models: ModelBook, clock: Clock, jobs: mpsc::WeakSender<Job>, bustle: Bustle) -> Self {
        let at_once = std::thread::available_parallelism().map_or(AT_ONCE, |n| n.get().max(AT_ONCE));
        let turns = Arc::new(Semaphore::new(at_once));
        Self { store, models, clock, jobs, bustle, at_once, turns, under_way: Arc::default(), known: Arc::default() }
    }

    /// The diagnosis of a stored campaign against the model in force: as it was kept, or made now.
    async fn diagnosis(&self, id: Id, awaited: Awaited, patience: Duration) -> Result<Asked, StoreError> {
        if let Some(diagnosed) = self.recall(id) {
            return Ok(Asked::Answered(diagnosed));
        }
        let Some(row) = store::record::get(&self.store, id).await?.filter(|row| row.kind == Kind::Campaign) else {
            return Ok(Asked::NoSuchCampaign);
        };
        let in_force = self.models.of(Some(row.imu));
        if let Some(diagnosed) = self.kept(&row, &in_force).await? {
            return Ok(Asked::Answered(diagnosed));
        }
        let mut end = self.begin(&row, in_force, awaited)?;
        let ended = tokio::time::timeout(patience, end.wait_for(Option::is_some)).await;
        let Ok(ended) = ended else { return Ok(Asked::Waiting) };
        let gone = || StoreError::Damaged(format!("the diagnosis of campaign {id} failed"));
        let diagnosed = ended.map_err(|_| gone())?.clone().ok_or_else(gone)?;
        Ok(Asked::Answered(diagnosed))
    }

    /// As it was kept by this program against the model in force.
    async fn kept(&self, row: &RecordRow, in_force: &InForce) -> Result<Option<Diagnosed>, StoreError> {
        let kept = store::diagnosis::get(&self.store, row.id).await?;
        let Some(kept) = kept.filter(|kept| kept.program == program() && kept.model == in_force.id) else {
            return Ok(None);
        };
        let read = |body: &str| {
            serde_json::from_str(body).map_err(|error| {
                StoreError::Damaged(format!("the diagnosis of campaign {} cannot be read: {error}", row.id))
            })
        };
        let diagnosed = Arc::new(if kept.refused { Err(from_stored(&kept.body)) } else { Ok(read(&kept.body)?) });
        self.remember(Known { campaign: row.id, imu: row.imu, model: kept.model, diagnosed: Arc::clone(&diagnosed) });
        Ok(Some(diagnosed))
    }

    /// Has it made by a task of its own, whether or not the caller stays; once, however many ask.
    fn begin(
        &self,
        row: &RecordRow,
        in_force: InForce,
        awaited: Awaited,
    ) -> Result<watch::Receiver<Option<Diagnosed>>, StoreError> {
        let key = (row.id, in_force.id);
        let mut under_way = self.under_way.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(end) = under_way.get(&key) {
            return Ok(end.clone());
        }
        let campaign = campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(row.id, &faults))?;
        let (ended, end) = watch::channel(None);
        under_way.insert(key, end.clone());
        let (diagnoser, imu) = (self.clone(), row.imu);
        tokio::spawn(async move {
            let gyros = seats(&campaign);
            let (begun_at, made) = diagnoser.compute(campaign, &in_force, awaited).await;
            let (campaign, model) = key;
            let outcome = match &made {
                Some(diagnosed) => {
                    let known = Known { campaign, imu, model, diagnosed: Arc::clone(diagnosed) };
                    diagnoser.remember(known.clone());
                    Outcome::Known { known, gyros }
                }
                None => Outcome::Failed(to_stored(&message!("computation_broke_off"))),
            };
            diagnoser.have_kept(Made { campaign, begun_at, ended_at: diagnoser.clock.now(), outcome }).await;
            if made.is_some() {
                ended.send_replace(made);
            }
            diagnoser.under_way.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
        });
        Ok(end)
    }

    /// When it is its turn: since when, and the answer; none where it panicked.
    async fn compute(
        &self,
        campaign: Campaign,
        in_force: &InForce,
        awaited: Awaited,
    ) -> (UtcMicros, Option<Diagnosed>) {
        // Nobody closes it: a turn always comes.
        let _turn = self.turns.acquire().await;
        let (begun_at, begun) = (self.clock.now(), Instant::now());
        let options = in_force.model.options_as_asked(&campaign);
        let work = move || match diagnose(&campaign, &options) {
            Ok(diagnosis) => Ok(DiagnosisBody::from(&diagnosis)),
            Err(why) => Err(why.message()),
        };
        let made = beside_others("diagnosis", awaited, work).await;
        let outcome = match &made {
            Some(Ok(_)) => "made",
            Some(Err(_)) => "refused",
            None => "failed",
        };
        metrics::counter!(telemetry::DIAGNOSES, "outcome" => outcome).increment(1);
        metrics::histogram!(telemetry::DIAGNOSIS_TIME).record(begun.elapsed());
        (begun_at, made.map(Arc::new))
    }

    /// Puts it on disk. Where that fails it is made again after the next start, or for the orders that wait for it.
    async fn have_kept(&self, made: Made) {
        let Some(jobs) = self.jobs.upgrade() else { return };
        let campaign = made.campaign;
        let (reply, answer) = oneshot::channel();
        if jobs.send(Job::Diagnosed { made, reply }).await.is_err() {
            return;
        }
        drop(jobs);
        if let Ok(Err(error)) = answer.await {
            tracing::warn!(%error, %campaign, "a diagnosis could not be kept");
        }
    }

    fn recall(&self, id: Id) -> Option<Diagnosed> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.iter().find(|known| known.campaign == id)?;
        (self.models.of(Some(found.imu)).id == found.model).then(|| Arc::clone(&found.diagnosed))
    }

    fn remember(&self, new: Known) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|known| known.campaign != new.campaign);
        known.truncate(IN_MEMORY - 1);
        known.push_front(new);
    }
}

/// Why a diagnosis cannot be held against a reference.
#[derive(Debug, thiserror::Error)]
pub enum NotSplit {
    #[error("there is no campaign or record {0}")]
    NoSuchReference(Id),
    #[error(transparent)]
    NoReference(#[from] NoReference),
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Pipeline {
    /// The diagnosis of a stored campaign against the model in force for its IMU; [`Asked::Waiting`] where it is not made
    /// within `patience`.
    ///
    /// # Errors
    /// [`StoreError`], where the campaign cannot be read.
    pub async fn diagnosis(&self, id: Id, patience: Duration) -> Result<Asked, StoreError> {
        self.diagnoser.diagnosis(id, Awaited::BySomebody, patience).await
    }

    /// The gap of a diagnosed campaign against another stored campaign or record of its IMU. Computing, a few milliseconds.
    ///
    /// # Errors
    /// [`NotSplit`], where that is no reference for it.
    pub async fn split(&self, id: Id, diagnosis: &DiagnosisBody, reference: Id) -> Result<SplitBody, NotSplit> {
        let unknown = |id| move || NotSplit::NoSuchReference(id);
        let row = store::record::get(&self.store, id).await?.ok_or_else(unknown(id))?;
        let held_against = store::record::get(&self.store, reference).await?.ok_or_else(unknown(reference))?;
        let campaign = campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(id, &faults))?;
        let body = held_against.body.as_bytes();
        let reference = match held_against.kind {
            Kind::Campaign => campaign::parse_json(body).map(Reference::Campaign),
            Kind::Record => parse_record(body, &anything()).map(Reference::Record),
        };
        let reference = reference.map_err(|faults| damaged(held_against.id, &faults))?;
        let options = self.models.of(Some(row.imu)).model.options_as_asked(&campaign);
        let split = split(&campaign, &options, &residuals(&diagnosis.residuals), &reference)?;
        Ok(SplitBody::from(&split))
    }
}
