//! From what was sent to what is stored and judged, readable top to bottom.
//!
//! ```text
//! read      bytes -> Calibration | Bench | Event      whatever can be refused is refused here, by the caller's task
//! submit    a bounded queue to the one writer          full: 503 with Retry-After
//! admit     new, the same again, or in conflict        ┐
//! judge     each gyro touched, late arrivals in place  │ one group at a time, by the writer
//! alert     follow the newest verdicts of each gyro    │
//! commit    one transaction, on disk                   ┘
//! word      the answer, by the caller's task while the disk works
//! answer    the verdicts, or what stands in the way, when it is on disk
//! outbox    what hooks are to be told, from the database to their targets
//! ```
//!
//! The writer takes all that has queued up while the last group was committed, so that many senders share one flush
//! of the disk. A group is judged in its end state: each gyro once, whatever the order of arrival. Of an import in order of time
//! one group is judged while the one before is still being written (`ingest/writer/overlapped.rs`).

mod access;
mod alerts;
mod diagnoses;
mod hooks;
mod ingest;
mod queries;

use std::fmt;
use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::JoinHandle;

use crate::config::Config;
use crate::core::alert_decision::Late;
use crate::core::judge::Verdict;
use crate::core::message::{Message, list, text};
use crate::core::note::Note;
use crate::message;
pub(crate) use crate::store;
use crate::store::{Store, Writer};
use crate::system::Clock;
use crate::wire::alert::AlertBody;
use crate::wire::differences::Differences;

pub use crate::alert::HookKind;
pub use access::{
    AccessOrder, Actor, By, Caller, Denied, Guard, NewToken, SESSION_COOKIE, Secret, SignedIn, create_beside,
    revoke_beside,
};
pub use alerts::{AlertChange, AlertOrder, AlertRecord, AlertStep, SilenceOrder};
pub use diagnoses::models::{Adoption, InForce};
pub use diagnoses::{Asked, Diagnosed, DiagnosisOrder, NotSplit, SummaryFilter, WantedDiagnoses};
pub use hooks::delivery::{Outbox, OutboxError};
pub use hooks::{DeliveryPage, HookPatch, NewHook, Order};
pub use ingest::campaign::{Fitted, ReadCampaign, StoredCampaign};
pub use ingest::document::{Origin, ReadDocument};
pub use ingest::judge::gyro_window::sample_of;
pub use ingest::preview::Foreseen;
pub use ingest::same_content::Sent;
pub use queries::agreement::{Compared, Comparison};
pub use queries::changes_explained::ExplainedHistory;
pub use queries::fleet::{Glimpse, Seats, Standing, Violation};
pub use queries::gyro_history::{Baseline, Course, Tested};
pub use queries::record::StoredRecord;
// What the store hands out passes through here: whoever asks the pipeline need not know the store.
pub use crate::store::{
    AlertFilter, AuditFilter, AuditRow, BenchRow, Beside, CorrectionRow, DeliveryState, EventRow, Figures,
    GyroCorrection, Id, Kind, Matchers, ModelRow, Names, RecordHead, Span, StoreError, Tables, TokenRow,
};
pub use ingest::submission::{
    BenchTest, CalibratedGyro, Calibration, Confirmation, Corrected, Correction, GyroEvent, Submission,
};
pub use queries::stations::StationEffect;
pub use queries::status::Statuses;
pub use queries::verify::Verified;

/// The way in, and the way back to what is stored. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Pipeline {
    store: Store,
    config: Arc<Config>,
    clock: Clock,
    jobs: mpsc::Sender<Job>,
    bustle: diagnoses::background::Bustle,
    models: diagnoses::models::ModelBook,
    diagnoser: diagnoses::Diagnoser,
    /// Moves when a hook has changed or has something new to be told.
    wake: watch::Sender<u64>,
    pulse: hooks::delivery::Pulse,
    guard: Guard,
}

/// What the writer is asked to do.
#[derive(Debug)]
enum Job {
    /// Submissions of one sender that are to be answered together, in order; whether with the verdicts on them, and ahead of the disk; how what is found
    /// late is told.
    Store { items: Vec<Submission>, by: Actor, with_verdicts: bool, late: Late, reply: ingest::reply::Teller },
    /// A hook or its queue is to change.
    Hook { order: Order, by: Actor, reply: oneshot::Sender<Result<Id, Refused>> },
    /// How an attempt to tell a hook went, or that its target is back, is to be written down.
    Found { found: hooks::Found, reply: oneshot::Sender<Result<(), Refused>> },
    /// A model is to be in force for an IMU.
    Model { adoption: Box<Adoption>, by: Actor, reply: oneshot::Sender<Result<Accepted, Refused>> },
    /// Many campaigns are to be diagnosed, or no longer.
    Diagnoses { order: DiagnosisOrder, by: Actor, reply: oneshot::Sender<Result<Accepted, Refused>> },
    /// A diagnosis is to be kept.
    Diagnosed { made: diagnoses::Made, reply: oneshot::Sender<Result<(), Refused>> },
    /// What somebody says of an alert.
    Alert { order: AlertOrder, by: Actor, reply: oneshot::Sender<Result<AlertBody, Refused>> },
    /// A silence of many alerts is to begin or to end.
    Silence { order: SilenceOrder, by: Actor, reply: oneshot::Sender<Result<Id, Refused>> },
    /// An import has come to its end: what waits for its digest is told.
    Digest(oneshot::Sender<Result<(), Refused>>),
    /// Who may use the service is to change.
    Access { order: AccessOrder, by: Actor, reply: oneshot::Sender<Result<Option<access::Secret>, Refused>> },
    /// Whether it could.
    Probe(oneshot::Sender<Result<(), StoreError>>),
}

/// The answer to one submission.
pub type Reply = Result<Accepted, Refused>;

/// What has become of a submission.
#[derive(Debug, Clone, PartialEq)]
pub enum Accepted {
    /// It is new, and on disk once [`Pipeline::submit`] or [`Pipeline::submit_worded`] has returned it.
    Stored { id: Id, judged: Arc<[Judged]>, notes: Arc<[Note]> },
    /// An item with the same key has been there before; whether it says the same is for [`Pipeline::settle`] to find out.
    There { id: Id, same_bytes: bool },
}

impl Accepted {
    /// It is new, and there is nothing to be said of it.
    fn stored(id: Id) -> Self {
        Self::Stored { id, judged: [].into(), notes: [].into() }
    }
}

/// A gyro's verdicts on the record that was submitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    pub serial: Arc<str>,
    pub verdicts: Vec<Verdict>,
}

/// Why a submission was not taken.
#[derive(Debug, Clone)]
pub enum Refused {
    Differs { existing: Id, differences: Differences },
    KeyReused { existing: Id },
    GyroElsewhere { existing: Id, index: usize, serial: String },
    UnknownRecord { id: Id },
    UnknownBench { id: Id },
    AlreadyCorrected { id: Id, existing: Id },
    NotSetAside { id: Id },
    AnotherImu,
    TimeTaken { existing: Id, kind: Kind },
    UnknownGyro { serial: String },
    UnknownImu { imu: String },
    NoSuchHook { id: Id },
    NoSuchToken { id: Id },
    OtherStation { station: String },
    SetupOver,
    NoRandomNumbers,
    NoSuchDelivery { id: Id },
    HookDisabled { id: Id },
    StillBehind { id: Id },
    SecretNeeded,
    TooManyHooks { most: usize },
    NoSuchDiagnoses { id: Id },
    DiagnosesEnded { id: Id },
    UnknownAlert { id: Id },
    AlertResolved { id: Id },
    UnknownSilence { id: Id },
    TooManySilences { most: usize },
    Busy,
    Stopping,
    Store(Arc<StoreError>),
}

impl Refused {
    pub fn message(&self) -> Message {
        match self {
            Self::Differs { existing, differences } => differs(*existing, differences),
            Self::KeyReused { existing } => message!("key_reused", id = text(existing)),
            Self::GyroElsewhere { existing, serial, .. } => {
                message!("gyro_elsewhere", serial = serial.clone(), id = text(existing))
            }
            Self::UnknownRecord { id } => message!("no_such_record", id = text(id)),
            Self::UnknownBench { id } => message!("no_such_bench_result", id = text(id)),
            Self::AlreadyCorrected { id, .. } => message!("corrected_otherwise", id = text(id)),
            Self::NotSetAside { id } => message!("not_set_aside", id = text(id)),
            Self::AnotherImu => message!("another_imu"),
            Self::TimeTaken { existing, .. } => message!("time_taken", id = text(existing)),
            Self::UnknownGyro { serial } => message!("unknown_gyro", serial = serial.clone()),
            Self::UnknownImu { imu } => message!("unknown_imu", imu = imu.clone()),
            Self::NoSuchHook { id } => message!("no_such_hook", id = text(id)),
            Self::NoSuchToken { id } => message!("no_such_token", id = text(id)),
            Self::OtherStation { station } => message!("other_station", station = station.clone()),
            Self::SetupOver => message!("setup_over"),
            Self::NoRandomNumbers => message!("no_random_numbers"),
            Self::NoSuchDelivery { id } => message!("no_such_delivery", id = text(id)),
            Self::HookDisabled { id } => message!("hook_disabled", id = text(id)),
            Self::StillBehind { id } => message!("still_behind", id = text(id)),
            Self::SecretNeeded => message!("secret_needed"),
            Self::TooManyHooks { most } => message!("too_many_hooks", most = *most),
            Self::NoSuchDiagnoses { id } => message!("no_such_diagnoses", id = text(id)),
            Self::DiagnosesEnded { id } => message!("diagnoses_ended", id = text(id)),
            Self::UnknownAlert { id } => message!("unknown_alert", id = text(id)),
            Self::AlertResolved { id } => message!("alert_resolved", id = text(id)),
            Self::UnknownSilence { id } => message!("unknown_silence", id = text(id)),
            Self::TooManySilences { most } => message!("too_many_silences", most = *most),
            Self::Busy => message!("busy"),
            Self::Stopping => message!("stopping"),
            Self::Store(error) => of_store(error),
        }
    }
}

fn differs(existing: Id, differences: &Differences) -> Message {
    let (id, further) = (text(existing), differences.further);
    let places = list(differences.pointers.iter().cloned());
    match differences.pointers.iter().any(String::is_empty) {
        true => message!("differs_in_everything", id = id),
        false if further > 0 => message!("differs_further", id = id, places = places, further = further),
        false => message!("differs", id = id, places = places),
    }
}

/// What a client is told of a failure of the store. The log has the rest.
pub fn of_store(error: &StoreError) -> Message {
    match error {
        StoreError::Full => message!("disk_full"),
        StoreError::ReadOnly(_) | StoreError::Busy | StoreError::Unreachable(_) => message!("cannot_write"),
        StoreError::Unanswered(_) => message!("perhaps_stored"),
        StoreError::NotDurable(_) => message!("disk_failed"),
        StoreError::Damaged(what) => message!("database_damaged", what = what.to_string()),
        StoreError::Refused(_)
        | StoreError::InUse(_)
        | StoreError::File(_)
        | StoreError::Key(_)
        | StoreError::Other(_) => message!("service_failed"),
    }
}

/// For logs: what refused it, in no language.
impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Store(error) => error.fmt(f),
            other => other.message().fmt(f),
        }
    }
}

impl std::error::Error for Refused {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Store(error) => error.source(),
            _ => None,
        }
    }
}

impl From<StoreError> for Refused {
    fn from(error: StoreError) -> Self {
        Self::Store(Arc::new(error))
    }
}

impl Pipeline {
    /// Starts the writer. It ends, and closes the database, when the last clone of the pipeline is gone.
    pub async fn start(
        store: Store,
        writer: Writer,
        config: Arc<Config>,
        clock: Clock,
    ) -> Result<(Self, JoinHandle<()>), StoreError> {
        let (jobs, queue) = mpsc::channel(config.database.max_waiting_writes);
        let wake = watch::Sender::default();
        let models = diagnoses::models::ModelBook::load(&store).await?;
        let guard = Guard::start(store.clone(), config.access.clone(), config.server.is_behind_proxy()).await?;
        let (due, watched) = watch::channel(0);
        let bustle = diagnoses::background::Bustle::new();
        let diagnoser =
            diagnoses::Diagnoser::new(store.clone(), models.clone(), clock.clone(), jobs.downgrade(), bustle.clone());
        let after = ingest::writer::After { wake: wake.clone(), models: models.clone(), due, guard: guard.clone() };
        let task = ingest::writer::Task::new(store.clone(), writer, config.clone(), clock.clone(), after).await?;
        // It ends when the writer, who alone tells it of more, is gone.
        tokio::spawn(diagnoser.clone().run(watched));
        // On a thread of its own: among other tasks the writer would wait its turn behind all whom it has just answered.
        let runtime = Handle::current();
        let handle = tokio::task::spawn_blocking(move || runtime.block_on(task.run(queue)));
        let pulse = hooks::delivery::Pulse::default();
        Ok((Self { store, config, clock, jobs, bustle, models, diagnoser, wake, pulse, guard }, handle))
    }

    /// A pipeline that answers what is asked of it and takes nothing in.
    ///
    /// # Errors
    /// [`StoreError`] where the adopted models or the tokens cannot be read.
    pub async fn to_read(store: Store, config: Arc<Config>, clock: Clock) -> Result<Self, StoreError> {
        let (jobs, _closed) = mpsc::channel(1);
        let models = diagnoses::models::ModelBook::load(&store).await?;
        let bustle = diagnoses::background::Bustle::new();
        let diagnoser =
            diagnoses::Diagnoser::new(store.clone(), models.clone(), clock.clone(), jobs.downgrade(), bustle.clone());
        let guard = Guard::start(store.clone(), config.access.clone(), config.server.is_behind_proxy()).await?;
        let (wake, pulse) = (watch::Sender::default(), hooks::delivery::Pulse::default());
        Ok(Self { store, config, clock, jobs, bustle, models, diagnoser, wake, pulse, guard })
    }

    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Writes that wait, and how many may.
    pub fn waiting(&self) -> (usize, usize) {
        let most = self.jobs.max_capacity();
        (most - self.jobs.capacity(), most)
    }

    /// Whether a record would be stored now: the writer lives and the database can be written.
    ///
    /// # Errors
    /// [`Refused`], as a record would be.
    pub async fn probe(&self) -> Result<(), Refused> {
        let (reply, answer) = oneshot::channel();
        self.offer(Job::Probe(reply))?;
        Ok(answer.await.map_err(|_| Refused::Stopping)??)
    }

    fn offer(&self, job: Job) -> Result<(), Refused> {
        self.jobs.try_send(job).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => Refused::Busy,
            mpsc::error::TrySendError::Closed(_) => Refused::Stopping,
        })
    }

    /// Stores and judges one item; returns once it is on disk.
    ///
    /// # Errors
    /// [`Refused`]; then nothing of it is stored, but after [`StoreError::Unanswered`](crate::store::StoreError) that is not known.
    pub async fn submit(&self, item: Submission) -> Result<Accepted, Refused> {
        let (accepted, ()) = self.submit_worded(item, |_| ()).await?;
        Ok(accepted)
    }

    /// As [`Pipeline::submit`], with what `put_into_words` makes of what becomes of the item. It is called while the disk works, so what it
    /// makes may be told to nobody before this returns; it is called again where something else came true.
    ///
    /// # Errors
    /// As [`Pipeline::submit`].
    pub async fn submit_worded<T>(
        &self,
        item: Submission,
        put_into_words: impl FnMut(&Accepted) -> T,
    ) -> Result<(Accepted, T), Refused> {
        self.submit_late(item, Late::Quiet, put_into_words).await
    }

    /// As [`Pipeline::submit_worded`], with a say in how what is found late is told.
    ///
    /// # Errors
    /// As [`Pipeline::submit`].
    pub async fn submit_late<T>(
        &self,
        item: Submission,
        late: Late,
        mut put_into_words: impl FnMut(&Accepted) -> T,
    ) -> Result<(Accepted, T), Refused> {
        self.bustle.stir();
        let (reply, listener) = ingest::reply::channel();
        self.offer(Job::Store { items: vec![item], by: Actor::by_caller(), with_verdicts: true, late, reply })?;
        let heard = listener.hear(|replies| replies.first()?.as_ref().ok().map(&mut put_into_words)).await;
        let (mut replies, words) = heard.ok_or(Refused::Stopping)?;
        let accepted = replies.pop().unwrap_or(Err(Refused::Stopping))?;
        Ok((accepted, words.expect("the one reply was accepted, so it was put into words")))
    }

    /// As [`Pipeline::submit`] for many, each with an answer of its own that leaves out the verdicts. Waits for room in the queue; what it then returns waits
    /// for the disk, so that the next items can be made ready meanwhile.
    pub async fn enqueue(&self, items: Vec<Submission>, late: Late) -> impl Future<Output = Vec<Reply>> + use<> {
        self.bustle.stir();
        let count = items.len();
        let (reply, listener) = ingest::reply::channel();
        // Where the writer is gone, the reply is dropped with the job, and the answer says so.
        let _queued =
            self.jobs.send(Job::Store { items, by: Actor::by_caller(), with_verdicts: false, late, reply }).await;
        async move {
            let heard = listener.hear(|_| ()).await;
            heard.map_or_else(|| vec![Err(Refused::Stopping); count], |(replies, ())| replies)
        }
    }

    /// An import has come to its end: hooks are told in one message each what it has left firing since long ago.
    ///
    /// # Errors
    /// [`Refused`]; then it is told when nothing has come for a while.
    pub async fn end_import(&self) -> Result<(), Refused> {
        let (reply, answer) = oneshot::channel();
        self.jobs.send(Job::Digest(reply)).await.map_err(|_| Refused::Stopping)?;
        answer.await.map_err(|_| Refused::Stopping)?
    }
}
