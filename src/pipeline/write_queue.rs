//! The way to the writers: what they can be asked to do.

use tokio::sync::{mpsc, oneshot};

use crate::pipeline::access::Secret;
use crate::pipeline::diagnoses::FinishedDiagnosis;
use crate::pipeline::hooks::Found;
use crate::pipeline::ingest::Restated;
use crate::pipeline::prelude::*;
use crate::pipeline::{
    AccessOrder, Adoption, AlertOrder, DiagnosisOrder, HypothesisOrder, Order, Reply, SilenceOrder, Submission,
};
use crate::store::PackedText;
use crate::wire::alert::AlertBody;

/// Where an answer goes.
pub(super) type ReplyTo<T> = oneshot::Sender<Result<T, Refused>>;

/// What the writer is asked to do.
#[derive(Debug)]
pub(super) enum Job {
    /// Something is to be stored.
    Store(StoreJob),
    /// A hook or its queue is to change.
    Hook { order: Order, by: Actor, reply: ReplyTo<Id> },
    /// How an attempt to tell a hook went, or that its target is back, is to be written down.
    Found { found: Found, reply: ReplyTo<()> },
    /// A model is to be in force for an IMU, whose campaigns have been fitted with it.
    Model { adoption: Box<(Adoption, Restated)>, by: Actor, reply: ReplyTo<Accepted> },
    /// Calibrations of an IMU by its number, as the model states them that is in force.
    Restate { stale: Box<(u32, Id, Restated)>, reply: ReplyTo<()> },
    /// Texts of stored records are deflated.
    Pack { texts: Vec<PackedText>, reply: ReplyTo<()> },
    /// A hypothesis is to compete in all diagnoses, or no longer.
    Hypothesis { order: HypothesisOrder, by: Actor, reply: ReplyTo<Accepted> },
    /// Many campaigns are to be diagnosed, or no longer.
    Diagnoses { order: DiagnosisOrder, by: Actor, reply: ReplyTo<Accepted> },
    /// A diagnosis is to be kept.
    Diagnosed { made: FinishedDiagnosis, reply: ReplyTo<()> },
    /// What somebody says of an alert.
    Alert { order: AlertOrder, by: Actor, reply: ReplyTo<AlertBody> },
    /// A silence of many alerts is to begin or to end.
    Silence { order: SilenceOrder, by: Actor, reply: ReplyTo<Id> },
    /// An import has come to its end: what waits for its digest is told.
    Digest(ReplyTo<()>),
    /// What gyros share is to be looked at before the clock does: many records have been set aside, or count again.
    Shared(ReplyTo<()>),
    /// Who may use the service is to change.
    Access { order: AccessOrder, by: Actor, reply: ReplyTo<Option<Secret>> },
    /// Whether it could.
    Probe(ReplyTo<()>),
}

/// Submissions of one sender that are to be answered together, in order.
#[derive(Debug)]
pub(super) struct StoreJob {
    pub items: Vec<Submission>,
    pub by: Actor,
    /// Whether they are answered with verdicts.
    pub with_verdicts: bool,
    /// How what is found late is told.
    pub late: Late,
    pub reply: oneshot::Sender<Vec<Reply>>,
}

/// Cheap to clone. The writers end when the last clone is gone.
#[derive(Debug, Clone)]
pub(super) struct WriteQueue {
    /// To the one who carries out orders, and stores where there is nobody else.
    orders: mpsc::Sender<Job>,
    /// To those who store: each of them what is at home in its share of the cells.
    partitions: Arc<[mpsc::Sender<Job>]>,
}

/// As a [`WriteQueue`], but the writers do not wait for its end.
#[derive(Debug, Clone)]
pub(super) struct WeakWriteQueue {
    orders: mpsc::WeakSender<Job>,
    partitions: Arc<[mpsc::WeakSender<Job>]>,
}

impl WriteQueue {
    /// To one writer for orders, and `partitions` others who store; with none, the one does all. Each has `room`.
    pub fn new(room: usize, partitions: usize) -> (Self, Vec<mpsc::Receiver<Job>>) {
        let (orders, queue) = mpsc::channel(room);
        let mut queues = vec![queue];
        let others = (0..partitions).map(|_| {
            let (partition, queue) = mpsc::channel(room);
            queues.push(queue);
            partition
        });
        let partitions: Vec<_> = others.collect();
        let partitions = if partitions.is_empty() { vec![orders.clone()] } else { partitions };
        (Self { orders, partitions: partitions.into() }, queues)
    }

    pub fn downgrade(&self) -> WeakWriteQueue {
        let partitions = self.partitions.iter().map(mpsc::Sender::downgrade).collect();
        WeakWriteQueue { orders: self.orders.downgrade(), partitions }
    }

    /// Writes that wait, and how many may.
    pub fn waiting(&self) -> (usize, usize) {
        let waiting = |queue: &mpsc::Sender<Job>| queue.max_capacity() - queue.capacity();
        let orders = Some(&self.orders).filter(|orders| !self.partitions[0].same_channel(orders));
        let queues = || self.partitions.iter().chain(orders);
        (queues().map(waiting).sum(), queues().map(mpsc::Sender::max_capacity).sum())
    }

    /// Whose it is to store an item.
    pub fn partition_of(&self, store: &Store, item: &Submission) -> usize {
        if self.partitions.len() == 1 {
            return 0;
        }
        let cell = match item {
            Submission::Calibration(sent) => store::names::cell_of_imu(store, sent.imu.as_str()),
            _ => item.serial().map_or(0, |serial| store::names::cell_of_gyro(store, serial)),
        };
        usize::from(cell) % self.partitions.len()
    }

    /// Queues what is to be stored.
    pub fn offer_to(&self, partition: usize, job: Job) -> Result<(), Refused> {
        offer(&self.partitions[partition], job)
    }

    /// As [`WriteQueue::offer_to`], but waits for room.
    pub async fn send_to(&self, partition: usize, job: Job) -> Result<(), Refused> {
        self.partitions[partition].send(job).await.map_err(|_| Refused::Stopping)
    }

    /// Queues an order that need not be answered here; waits for room.
    pub async fn send(&self, job: Job) -> Result<(), Refused> {
        self.orders.send(job).await.map_err(|_| Refused::Stopping)
    }

    /// Has the writer do something; returns its answer.
    pub async fn ask<T>(&self, job: impl FnOnce(ReplyTo<T>) -> Job) -> Result<T, Refused> {
        let (reply, answer) = oneshot::channel();
        offer(&self.orders, job(reply))?;
        answer.await.map_err(|_| Refused::Stopping)?
    }

    /// As [`WriteQueue::ask`], but waits for room.
    pub async fn ask_in_turn<T>(&self, job: impl FnOnce(ReplyTo<T>) -> Job) -> Result<T, Refused> {
        let (reply, answer) = oneshot::channel();
        self.send(job(reply)).await?;
        answer.await.map_err(|_| Refused::Stopping)?
    }
}

fn offer(queue: &mpsc::Sender<Job>, job: Job) -> Result<(), Refused> {
    queue.try_send(job).map_err(|error| match error {
        mpsc::error::TrySendError::Full(_) => Refused::Busy,
        mpsc::error::TrySendError::Closed(_) => Refused::Stopping,
    })
}

impl WeakWriteQueue {
    pub fn upgrade(&self) -> Option<WriteQueue> {
        let partitions = self.partitions.iter().map(mpsc::WeakSender::upgrade).collect::<Option<Vec<_>>>()?;
        Some(WriteQueue { orders: self.orders.upgrade()?, partitions: partitions.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_waits_in_any_queue_is_counted_once() {
        for (partitions, most) in [(0, 4), (2, 12)] {
            let (queue, _queues) = WriteQueue::new(4, partitions);
            let probe = || Job::Probe(oneshot::channel().0);
            queue.send(probe()).await.unwrap();
            queue.send_to(0, probe()).await.unwrap();
            assert_eq!(queue.waiting(), (2, most), "{partitions} partitions");
        }
    }
}
