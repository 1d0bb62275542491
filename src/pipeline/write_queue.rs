//! The way to the one writer: what it can be asked to do.

use tokio::sync::{mpsc, oneshot};

use crate::core::alert_decision::Late;
use crate::core::id::Id;
use crate::pipeline::access::{AccessError, AccessOrder, Actor, Secret};
use crate::pipeline::alerts::{AlertError, AlertOrder, SilenceOrder};
use crate::pipeline::diagnoses::{Adoption, DiagnosisError, DiagnosisOrder, Made};
use crate::pipeline::error::WriteError;
use crate::pipeline::hooks::{Found, HookError, Order};
use crate::pipeline::ingest::{Accepted, ReplySender, Submission};
use crate::wire::alert::AlertBody;

/// Where an answer goes.
pub(super) type Reply<T, E> = oneshot::Sender<Result<T, E>>;

/// What the writer is asked to do.
#[derive(Debug)]
pub(super) enum Job {
    /// Submissions of one sender that are to be answered together, in order; whether with the verdicts on them, and
    /// ahead of the disk; how what is found late is told.
    Store { items: Vec<Submission>, by: Actor, with_verdicts: bool, late: Late, reply: ReplySender },
    /// A hook or its queue is to change.
    Hook { order: Order, by: Actor, reply: Reply<Id, HookError> },
    /// How an attempt to tell a hook went, or that its target is back, is to be written down.
    Found { found: Found, reply: Reply<(), WriteError> },
    /// A model is to be in force for an IMU.
    Model { adoption: Box<Adoption>, by: Actor, reply: Reply<Accepted, DiagnosisError> },
    /// Many campaigns are to be diagnosed, or no longer.
    Diagnoses { order: DiagnosisOrder, by: Actor, reply: Reply<Accepted, DiagnosisError> },
    /// A diagnosis is to be kept.
    Diagnosed { made: Made, reply: Reply<(), WriteError> },
    /// What somebody says of an alert.
    Alert { order: AlertOrder, by: Actor, reply: Reply<AlertBody, AlertError> },
    /// A silence of many alerts is to begin or to end.
    Silence { order: SilenceOrder, by: Actor, reply: Reply<Id, AlertError> },
    /// An import has come to its end: what waits for its digest is told.
    Digest(Reply<(), WriteError>),
    /// Who may use the service is to change.
    Access { order: AccessOrder, by: Actor, reply: Reply<Option<Secret>, AccessError> },
    /// Whether it could.
    Probe(Reply<(), WriteError>),
}

/// Cheap to clone. The writer ends when the last clone is gone.
#[derive(Debug, Clone)]
pub(super) struct WriteQueue(mpsc::Sender<Job>);

/// As a [`WriteQueue`], but the writer does not wait for its end.
#[derive(Debug, Clone)]
pub(super) struct WeakWriteQueue(mpsc::WeakSender<Job>);

impl WriteQueue {
    pub fn new(room: usize) -> (Self, mpsc::Receiver<Job>) {
        let (jobs, queue) = mpsc::channel(room);
        (Self(jobs), queue)
    }

    pub fn downgrade(&self) -> WeakWriteQueue {
        WeakWriteQueue(self.0.downgrade())
    }

    /// Writes that wait, and how many may.
    pub fn waiting(&self) -> (usize, usize) {
        let most = self.0.max_capacity();
        (most - self.0.capacity(), most)
    }

    /// Queues what need not be answered here.
    pub fn offer(&self, job: Job) -> Result<(), WriteError> {
        self.0.try_send(job).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => WriteError::Busy,
            mpsc::error::TrySendError::Closed(_) => WriteError::Stopping,
        })
    }

    /// As [`WriteQueue::offer`], but waits for room.
    pub async fn send(&self, job: Job) -> Result<(), WriteError> {
        self.0.send(job).await.map_err(|_| WriteError::Stopping)
    }

    /// Has the writer do something; returns its answer.
    pub async fn ask<T, E: From<WriteError>>(&self, job: impl FnOnce(Reply<T, E>) -> Job) -> Result<T, E> {
        let (reply, answer) = oneshot::channel();
        self.offer(job(reply))?;
        answer.await.map_err(|_| WriteError::Stopping)?
    }

    /// As [`WriteQueue::ask`], but waits for room.
    pub async fn ask_in_turn<T, E: From<WriteError>>(&self, job: impl FnOnce(Reply<T, E>) -> Job) -> Result<T, E> {
        let (reply, answer) = oneshot::channel();
        self.send(job(reply)).await?;
        answer.await.map_err(|_| WriteError::Stopping)?
    }
}

impl WeakWriteQueue {
    pub fn upgrade(&self) -> Option<WriteQueue> {
        self.0.upgrade().map(WriteQueue)
    }
}
