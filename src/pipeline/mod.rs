//! From what was sent to what is stored and judged, readable top to bottom.
//!
//! ```text
//! read      bytes -> Calibration | Bench | Event      whatever can be refused is refused here, by the caller's task
//! submit    a bounded queue to a writer                full: 503 with Retry-After
//! hold      the cells of its IMU and gyros             ┐
//! admit     new, the same again, or in conflict        │
//! judge     each gyro touched, late arrivals in place  │ one group at a time, by the writer
//! alert     follow the newest verdicts of each gyro    │
//! commit    one transaction, on disk                   ┘
//! answer    the verdicts, or what stands in the way
//! outbox    what hooks are to be told, from the database to their targets
//! ```
//!
//! The writer takes all that has queued up while the last group was committed, so that many senders share one flush
//! of the disk. A group is judged in its end state: each gyro once, whatever the order of arrival. Of an import in
//! order of time one group is judged while the one before is still being written (`ingest/writer/overlapped.rs`).

mod access;
mod alerts;
mod cached_answer;
mod diagnoses;
mod error;
mod hooks;
mod ingest;
mod prelude;
mod queries;
mod suspect;
mod write_queue;

use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinHandle;

use crate::config::Config;
use crate::store::{Store, StoreError, Writer};
use crate::system::Clock;
use diagnoses::Diagnoser;
use diagnoses::background::IdleDetector;
use diagnoses::models::ModelCache;
use ingest::stale::StaleCalibrations;
use ingest::unpacked::UnpackedTexts;
use ingest::writer::{self, WriterRole};
use write_queue::{Job, WriteQueue};

pub use crate::alert::HookKind;
pub use access::{
    Access, AccessOrder, Actor, Caller, Credential, Denied, Guard, NewToken, SESSION_COOKIE, create_beside,
    revoke_beside,
};
pub use alerts::{AlertChange, AlertOrder, AlertStep, Alerts, SilenceOrder};
pub use diagnoses::{
    AdoptedModel, Adoption, Conclusion, Diagnoses, DiagnosisAnswer, DiagnosisOrder, HypothesisOrder, StoredHypothesis,
};
pub use error::Refused;
pub use hooks::{Hooks, Order, Outbox};
pub use ingest::{
    Accepted, AttributesOrder, CalibratedGyro, Calibration, Confirmation, Corrected, Correction, EventOrder, Ingest,
    Judged, Origin, Preview, ReadCampaign, Reader, Reply, SetAsideOrder, Submission, WindowMark,
};
pub use queries::{
    BEYOND, Baseline, CalibrationPreview, CommonFactor, CommonShift, Compared, Comparison, DueDate, ExplainedHistory,
    FEW_RECORDS, FleetFilter, FleetPage, GyroPreview, GyroStatus, GyroTimeline, LINES, Levels, ListFilter, Names,
    Queries, RecentValues, Seats, StatusFilter, Statuses, StoredCampaign, StoredRecord, Tested, Today, Verified,
    Violation, sample_of, today,
};

pub use suspect::WindowOutcome;

/// The rooms: each with its own types and errors. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Pipeline {
    pub access: Access,
    pub alerts: Alerts,
    pub diagnoses: Diagnoses,
    pub hooks: Hooks,
    pub ingest: Ingest,
    pub reader: Reader,
    pub queries: Queries,
    store: Store,
    queue: WriteQueue,
}

impl Pipeline {
    /// Starts the writers. They end, and the database is closed, when the last clone of the pipeline is gone.
    pub async fn start(
        store: Store,
        mut writer: Writer,
        config: Arc<Config>,
        clock: Clock,
    ) -> Result<(Self, JoinHandle<()>), StoreError> {
        writer::make_missing(&store, &mut writer, &config).await?;
        let partitions: Vec<Writer> = (0..config.database.writers).map_while(|_| writer.another()).collect();
        let (queue, queues) = WriteQueue::new(config.database.max_waiting_writes, partitions.len());
        let pipeline = Self::assemble(store, config, clock, queue).await?;
        let (due, watched) = watch::channel(0);
        let Self { access, diagnoses, hooks, ingest, reader, .. } = &pipeline;
        let (wake, models, guard) = (hooks.wake.clone(), reader.models.clone(), access.guard.clone());
        let after = writer::WriteNotifier { wake, models, due, guard };
        // It ends when the writers, who alone tell it of more, are gone.
        tokio::spawn(diagnoses.diagnoser.clone().run(watched));
        let (queue, idle) = (pipeline.queue.downgrade(), ingest.activity.clone());
        tokio::spawn(UnpackedTexts { store: ingest.store.clone(), queue: queue.clone(), idle: idle.clone() }.run());
        tokio::spawn(StaleCalibrations { reader: reader.clone(), queue, idle }.run());
        let writers = std::iter::once((writer, WriterRole::Orders))
            .chain(partitions.into_iter().map(|partition| (partition, WriterRole::Partition)));
        // Each on a thread of its own: among other tasks a writer would wait its turn behind all whom it has just
        // answered.
        let runtime = Handle::current();
        let at_work = writers.zip(queues).map(|((writer, duties), jobs)| {
            let (store, config, clock) = (ingest.store.clone(), ingest.config.clone(), ingest.clock.clone());
            let task = writer::Task::new(store, writer, config, clock, after.clone(), duties);
            let runtime = runtime.clone();
            tokio::task::spawn_blocking(move || runtime.block_on(task.run(jobs)))
        });
        let (at_work, store): (Vec<_>, _) = (at_work.collect(), ingest.store.clone());
        drop(after);
        let ended = tokio::spawn(async move {
            let ended = futures::future::join_all(at_work).await;
            store.close().await;
            for writer in ended {
                let writer = writer.unwrap_or_else(|error| std::panic::resume_unwind(error.into_panic()));
                if let Err(error) = writer.close().await {
                    tracing::error!(%error, "the database could not be closed in order; its log is kept and read at the next start");
                }
            }
        });
        Ok((pipeline, ended))
    }

    /// A pipeline that answers what is asked of it and takes nothing in.
    pub async fn to_read(store: Store, config: Arc<Config>, clock: Clock) -> Result<Self, StoreError> {
        let (queue, _closed) = WriteQueue::new(1, 0);
        Self::assemble(store, config, clock, queue).await
    }

    async fn assemble(store: Store, config: Arc<Config>, clock: Clock, queue: WriteQueue) -> Result<Self, StoreError> {
        let models = ModelCache::load(&store).await?;
        let guard = Guard::start(store.clone(), config.access.clone(), config.server.is_behind_proxy()).await?;
        let activity = IdleDetector::new();
        let weak = queue.downgrade();
        let reader = Reader { store: store.clone(), config: config.clone(), clock: clock.clone(), models };
        let diagnoser = Diagnoser::new(reader.clone(), weak, activity.clone());
        Ok(Self {
            access: Access { store: store.clone(), clock: clock.clone(), guard, queue: queue.clone() },
            alerts: Alerts { store: store.clone(), clock: clock.clone(), queue: queue.clone(), counts: Arc::default() },
            diagnoses: Diagnoses { store: store.clone(), diagnoser, queue: queue.clone(), reader: reader.clone() },
            hooks: Hooks::new(store.clone(), config.clone(), clock.clone(), queue.clone()),
            ingest: Ingest {
                store: store.clone(),
                config: config.clone(),
                clock: clock.clone(),
                queue: queue.clone(),
                activity,
            },
            queries: Queries::new(&store, &config, &clock, &reader),
            reader,
            store,
            queue,
        })
    }

    /// Whether the database can be read.
    pub async fn ping(&self) -> Result<(), StoreError> {
        self.store.ping().await
    }

    /// Of the database and of its log, in bytes.
    pub async fn sizes(&self) -> Result<(u64, u64), StoreError> {
        self.store.sizes().await
    }

    /// Writes that wait, and how many may.
    pub fn waiting(&self) -> (usize, usize) {
        self.queue.waiting()
    }

    /// Whether a record would be stored now: the writer lives and the database can be written.
    pub async fn probe(&self) -> Result<(), Refused> {
        self.queue.ask(Job::Probe).await
    }
}
