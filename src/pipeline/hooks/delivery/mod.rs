//! The delivery worker: takes what waits in the outbox to the targets of hooks, at least once, in order per alert.
//!
//! ```text
//! worker      one queue for every enabled hook                a target that hangs holds up its own queue alone
//! queue       what is due -> attempts, a few at a time        the store hands out the first of each alert's line only
//! message     a row of the outbox -> a signed request         the same bytes and `webhook-id` at every attempt
//! attempt     the status, or what went wrong
//! order       to the one writer: done, dead, or when again    on disk before the next of the line is looked for
//! ```
//!
//! What was sent but not yet written down when the process died is sent again: receivers know it by its `webhook-id`.

mod circuit;
pub(super) mod heartbeat;
pub(crate) mod message;
mod queue;

use tokio::sync::watch;
use tokio::task::{Id as TaskId, JoinError, JoinHandle, JoinSet};

use crate::alert::deliver::Courier;
use crate::alert::mail::MailError;
use crate::pipeline::hooks::Hooks;
use crate::pipeline::hooks::delivery::message::{DeliveryContext, OFF_DUTY};
use crate::pipeline::prelude::*;
use crate::store::LeasedTask;
use crate::words::Language;

use crate::pipeline::hooks::delivery::queue::DeliveryQueue;

/// How often the worker looks around when nothing wakes it.
const ROUND: Duration = Duration::from_secs(5);
/// At a stop, attempts under way get so long; what they were sent is sent again after the next start.
const DRAIN: Duration = Duration::from_secs(5);
/// Before a queue that broke down is started again.
const BREATH: Duration = Duration::from_secs(1);

/// Why the worker cannot start.
#[derive(Debug, thiserror::Error)]
pub enum OutboxError {
    #[error("hooks.ca_file {path} cannot be read: {source}")]
    Authority { path: String, source: std::io::Error },
    #[error("the client for hooks cannot be made (hooks.ca_file, hooks.proxy): {0}")]
    Client(#[from] reqwest::Error),
    #[error("hooks.smtp_url: {}", Language::English.words(&.0.message()))]
    Mail(MailError),
}

/// The worker, running. It holds a way to the writer, so stop it for the writer to end.
#[derive(Debug)]
pub struct Outbox {
    stop: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl Outbox {
    /// Starts to deliver.
    ///
    /// # Errors
    /// [`OutboxError`] where the configuration names certificates that cannot be used.
    pub fn start(hooks: &Hooks) -> Result<Self, OutboxError> {
        let config = &hooks.config.hooks;
        let roots = config.ca_file.as_ref().map(|path| {
            std::fs::read(path).map_err(|source| OutboxError::Authority { path: path.display().to_string(), source })
        });
        let roots = roots.transpose()?;
        let (policy, mailer) = (hooks.config.target_policy(), config.mailer(roots.as_deref()));
        let mut courier = Courier::through(&config.proxies(), policy, config.limits(), roots.as_deref())?;
        courier.mailer = mailer.map_err(OutboxError::Mail)?;
        let (stop, stopping) = watch::channel(false);
        let context =
            Arc::new(DeliveryContext { hooks: hooks.clone(), courier, retry_schedule: config.retry_schedule() });
        context.hooks.heartbeat.beat();
        let task = tokio::spawn(Worker { context, stopping, queues: JoinSet::new(), hooks: HashMap::new() }.run());
        Ok(Self { stop, task })
    }

    /// Begins no more attempts; returns once those under way are over, or have been given up.
    pub async fn stop(self) {
        let _ended_already = self.stop.send(true);
        if let Err(error) = self.task.await {
            tracing::error!(%error, "the delivery worker broke down");
        }
    }
}

struct Worker {
    context: Arc<DeliveryContext>,
    stopping: watch::Receiver<bool>,
    queues: JoinSet<()>,
    hooks: HashMap<TaskId, Id>,
}

impl Worker {
    async fn run(mut self) {
        let mut wake = self.context.hooks.wake.subscribe();
        while !*self.stopping.borrow_and_update() {
            self.context.hooks.heartbeat.beat();
            let holds_lease = self.context.hooks.store.holds_lease(LeasedTask::Deliveries);
            if !holds_lease {
                // What was under way is sent again by whoever delivers now.
                self.queues.shutdown().await;
                self.hooks.clear();
            } else if let Err(error) = self.open_lanes().await {
                tracing::warn!(%error, "the hooks cannot be read; trying again");
            }
            tokio::select! {
                Some(ended) = self.queues.join_next_with_id() => self.clear_away(ended).await,
                _ = wake.changed() => {}
                _ = self.stopping.changed() => {}
                () = tokio::time::sleep(if holds_lease { ROUND } else { OFF_DUTY }) => {}
            }
        }
        let drained = async { while self.queues.join_next().await.is_some() {} };
        if tokio::time::timeout(DRAIN, drained).await.is_err() {
            tracing::info!("attempts still under way were given up; they are made again after the next start");
            self.queues.shutdown().await;
        }
    }

    /// Every enabled hook has a queue; a queue ends by itself when its hook is disabled or deleted.
    async fn open_lanes(&mut self) -> Result<(), StoreError> {
        for hook in store::hook::all(&self.context.hooks.store).await? {
            if hook.enabled && !self.hooks.values().any(|open| *open == hook.id) {
                let queue = DeliveryQueue::new(Arc::clone(&self.context), hook.id, self.stopping.clone());
                let task = self.queues.spawn(queue.run());
                self.hooks.insert(task.id(), hook.id);
            }
        }
        Ok(())
    }

    async fn clear_away(&mut self, ended: Result<(TaskId, ()), JoinError>) {
        let task = match ended {
            Ok((task, ())) => task,
            Err(error) => {
                tracing::error!(%error, "the deliveries of a hook broke down; they start anew");
                tokio::time::sleep(BREATH).await;
                error.id()
            }
        };
        self.hooks.remove(&task);
    }
}
