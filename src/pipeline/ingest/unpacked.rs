//! Long texts that an earlier version stored as they were sent: deflated after a start, in the background, a few a
//! transaction. What was broken off goes on at the next start.

use crate::pipeline::diagnoses::background::{IdleDetector, WorkPriority, beside_others};
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::{Job, WeakWriteQueue};
use crate::store::{LongText, PackedText};

/// Of one transaction.
const AT_ONCE: u32 = 16;
/// Transactions after which it is said how far it has come.
const SAID_EVERY: usize = 64;

/// Has them deflated.
pub(in crate::pipeline) struct UnpackedTexts {
    pub store: Store,
    /// Weak: the writer ends when nobody but this could send to it.
    pub queue: WeakWriteQueue,
    pub idle: IdleDetector,
}

impl UnpackedTexts {
    /// Once through all of them.
    pub async fn run(self) {
        match self.pack_all().await {
            Ok(0) => {}
            Ok(texts) => tracing::info!(texts, "long texts of an earlier version are deflated; the room is used again"),
            Err(_) if self.queue.upgrade().is_none() => {}
            Err(error) => {
                tracing::warn!(%error, "long texts of an earlier version could not be deflated; the next start tries again");
            }
        }
    }

    async fn pack_all(&self) -> Result<usize, Refused> {
        let of = store::record::count_unpacked(&self.store).await?;
        let (mut done, mut after) = (0, Id(0));
        for transaction in 1.. {
            self.idle.give_way().await;
            let found = store::record::unpacked(&self.store, after, AT_ONCE).await?;
            let (Some(last), Some(queue)) = (found.last(), self.queue.upgrade()) else { break };
            after = last.record;
            // One that does not become shorter stays as it is.
            let deflated = move || found.iter().filter_map(LongText::packed).collect::<Vec<PackedText>>();
            let texts = beside_others("deflating", WorkPriority::Background, deflated).await.unwrap_or_default();
            if texts.is_empty() {
                continue;
            }
            done += texts.len();
            queue.ask_in_turn(|reply| Job::Pack { texts, reply }).await?;
            if transaction % SAID_EVERY == 0 {
                tracing::info!(done, of, "long texts of an earlier version are deflated");
            }
        }
        Ok(done)
    }
}
