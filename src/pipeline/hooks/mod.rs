//! Hooks: read and checked, kept, and shown with their deliveries.
//!
//! Whatever changes a hook or its queue is an [`Order`] to the one writer ([`commands`]), so that changes never
//! overlap.

mod commands;
mod delivery;
mod read;
mod registry;
mod show;

pub use crate::pipeline::hooks::commands::Order;
pub(super) use crate::pipeline::hooks::commands::{Attempted, Found, HookHandler};
pub(super) use crate::pipeline::hooks::registry::{HookCache, OutboxContext};
pub use delivery::Outbox;
pub use read::{HookPatch, NewHook};
pub(super) use show::webhook_id;

use tokio::sync::watch;

use super::write_queue::{Job, WriteQueue};
use crate::alert::sign::Secret;
use crate::core::delivery::{DeliveryState, QueueState};
use crate::pipeline::prelude::*;
use crate::wire::hook::{DeliveryBody, HookBody, HookPatchBody, NewHookBody};
use crate::wire::message::from_stored;
use delivery::heartbeat::Heartbeat;

/// What is told to whom. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Hooks {
    store: Store,
    config: Arc<Config>,
    clock: Clock,
    queue: WriteQueue,
    /// Moves when a hook has changed or has something new to be told.
    pub(super) wake: watch::Sender<u64>,
    heartbeat: Heartbeat,
}

impl Hooks {
    pub(super) fn new(store: Store, config: Arc<Config>, clock: Clock, queue: WriteQueue) -> Self {
        Self { store, config, clock, queue, wake: watch::Sender::default(), heartbeat: Heartbeat::default() }
    }

    /// Checks a hook to be set up; a secret is drawn where its kind needs one.
    pub fn check(&self, body: NewHookBody) -> Result<NewHook, Faults> {
        read::new_hook(body, &self.config.target_policy(), self.has_mail())
    }

    fn has_mail(&self) -> bool {
        !self.config.hooks.smtp_url.is_empty()
    }

    pub fn check_patch(&self, body: HookPatchBody) -> Result<HookPatch, Faults> {
        read::patch(body, &self.config.target_policy(), self.has_mail())
    }

    /// Has the writer carry out an order. Returns once it is on disk, with the identifier of the hook or delivery that
    /// it is about.
    pub async fn order(&self, order: Order) -> Result<Id, Refused> {
        let by = Actor::by_caller();
        self.queue.ask(|reply| Job::Hook { order, by, reply }).await
    }

    /// Writes down what a delivery queue has found out; waits for room with the writer.
    pub(super) async fn write_down(&self, found: Found) -> Result<(), Refused> {
        self.queue.ask_in_turn(|reply| Job::Found { found, reply }).await
    }

    /// Every hook, oldest first.
    pub async fn all(&self) -> Result<Vec<HookBody>, StoreError> {
        let mut bodies = Vec::new();
        for row in store::hook::all(&self.store).await? {
            let queue = store::delivery::queue_state(&self.store, row.id).await?;
            bodies.push(show::hook(row, queue, self.clock.now())?);
        }
        Ok(bodies)
    }

    /// One hook. `drawn`: the secret that has just been drawn for it, which is shown this once.
    pub async fn get(&self, id: Id, drawn: Option<&Secret>) -> Result<Option<HookBody>, StoreError> {
        let Some(row) = store::hook::get(&self.store, id).await? else { return Ok(None) };
        let queue = store::delivery::queue_state(&self.store, id).await?;
        let body = show::hook(row, queue, self.clock.now())?;
        Ok(Some(HookBody { secret: drawn.map(Secret::reveal), ..body }))
    }

    /// The hooks that the service itself has disabled, oldest first: which, its name, and why.
    pub async fn disabled(&self) -> Result<Vec<(Id, String, Message)>, StoreError> {
        let disabled = store::hook::disabled(&self.store).await?.into_iter();
        Ok(disabled.map(|(id, name, why)| (id, name, from_stored(&why))).collect())
    }

    /// Deliveries of a hook older than `before`, newest first, with all their attempts.
    pub async fn deliveries(
        &self,
        hook: Id,
        state: Option<DeliveryState>,
        before: Option<Id>,
        limit: usize,
    ) -> Result<Vec<DeliveryBody>, StoreError> {
        let rows = store::delivery::of_hook(&self.store, hook, state, before, limit as u32).await?;
        Ok(rows.into_iter().map(show::delivery).collect())
    }

    pub async fn delivery(&self, id: Id) -> Result<Option<DeliveryBody>, StoreError> {
        Ok(store::delivery::get(&self.store, id).await?.map(show::delivery))
    }

    /// Whether the delivery worker is at work.
    pub fn delivers(&self) -> bool {
        self.heartbeat.is_alive()
    }

    /// How the queues of all hooks stand together.
    pub async fn outbox_totals(&self) -> Result<QueueState, StoreError> {
        store::delivery::totals(&self.store).await
    }
}
