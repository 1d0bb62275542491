//! Hooks: read and checked, kept, and shown with their deliveries.
//!
//! Whatever changes a hook or its queue is an [`Order`] to the one writer ([`commands`]), so that changes never overlap.

mod commands;
pub(super) mod delivery;
mod read;
mod registry;
mod show;

pub use crate::pipeline::hooks::commands::Order;
pub(super) use crate::pipeline::hooks::commands::{Attempted, Found, HookDesk};
pub(super) use crate::pipeline::hooks::registry::{HookBook, Scribe, Standing};
pub use read::{HookPatch, NewHook};
pub(super) use show::webhook_id;

use super::access::Actor;
use super::{Job, Pipeline, Refused};
use crate::alert::sign::Secret;
use crate::core::fault::Faults;
use crate::store;
use crate::store::{DeliveryState, Id, StoreError};
use crate::wire::hook::{DeliveryBody, HookBody};
use tokio::sync::oneshot;

/// A page of deliveries: their state, if it matters, and where the page before ended.
#[derive(Debug, Clone, Copy)]
pub struct DeliveryPage {
    pub state: Option<DeliveryState>,
    pub before: Option<Id>,
    pub limit: u32,
}

impl Pipeline {
    /// Reads a hook to be set up; a secret is drawn where its kind needs one.
    ///
    /// # Errors
    /// Every fault by its place.
    pub fn read_hook(&self, bytes: &[u8]) -> Result<NewHook, Faults> {
        read::new_hook(bytes, &self.config.target_policy())
    }

    /// Reads what is to change of a hook.
    ///
    /// # Errors
    /// Every fault by its place.
    pub fn read_hook_patch(&self, bytes: &[u8]) -> Result<HookPatch, Faults> {
        read::patch(bytes, &self.config.target_policy())
    }

    /// Has the writer carry out an order. Returns once it is on disk, with the identifier of the hook or delivery that
    /// it is about.
    ///
    /// # Errors
    /// [`Refused`]; then nothing has changed, but after [`StoreError::Unanswered`](crate::store::StoreError) that is not known.
    pub async fn order(&self, order: Order) -> Result<Id, Refused> {
        let (reply, answer) = oneshot::channel();
        self.offer(Job::Hook { order, by: Actor::by_caller(), reply })?;
        answer.await.map_err(|_| Refused::Stopping)?
    }

    /// Writes down what a lane has found out; waits for room in the queue.
    pub(super) async fn write_down(&self, found: Found) -> Result<(), Refused> {
        let (reply, answer) = oneshot::channel();
        self.jobs.send(Job::Found { found, reply }).await.map_err(|_| Refused::Stopping)?;
        answer.await.map_err(|_| Refused::Stopping)?
    }

    /// Every hook, oldest first.
    pub async fn hooks(&self) -> Result<Vec<HookBody>, StoreError> {
        let mut bodies = Vec::new();
        for row in store::hook::all(&self.store).await? {
            let queue = store::outbox::queue_state(&self.store, row.id).await?;
            bodies.push(show::hook(row, queue, self.clock.now())?);
        }
        Ok(bodies)
    }

    /// One hook. `drawn`: the secret that has just been drawn for it, which is shown this once.
    pub async fn hook(&self, id: Id, drawn: Option<&Secret>) -> Result<Option<HookBody>, StoreError> {
        let Some(row) = store::hook::get(&self.store, id).await? else { return Ok(None) };
        let queue = store::outbox::queue_state(&self.store, id).await?;
        let body = show::hook(row, queue, self.clock.now())?;
        Ok(Some(HookBody { secret: drawn.map(Secret::reveal), ..body }))
    }

    /// Deliveries of a hook, newest first, with all their attempts.
    pub async fn deliveries(&self, hook: Id, page: DeliveryPage) -> Result<Vec<DeliveryBody>, StoreError> {
        let rows = store::outbox::of_hook(&self.store, hook, page.state, page.before, page.limit).await?;
        Ok(rows.into_iter().map(show::delivery).collect())
    }

    pub async fn delivery(&self, id: Id) -> Result<Option<DeliveryBody>, StoreError> {
        Ok(store::outbox::get(&self.store, id).await?.map(show::delivery))
    }
}
