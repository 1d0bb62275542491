//! Long texts that an earlier version stored as they were sent: deflated after a start, in the background, a few a
//! transaction. What was broken off goes on at the next start.

use std::time::Duration;

use crate::core::id::Id;
use crate::pipeline::diagnoses::background::IdleDetector;
use crate::pipeline::error::{StorageError, WriteError};
use crate::pipeline::write_queue::{Job, WeakWriteQueue};
use crate::store;
use crate::store::{Store, StoreError};

/// Nothing has come in for this long before a few texts are deflated,
const QUIET: Duration = Duration::from_millis(100);
/// or it has given way for this long.
const GIVES_WAY: Duration = Duration::from_secs(1);
/// Of one transaction: some ten milliseconds of work.
const AT_ONCE: u32 = 16;
/// Texts after which it is said how far it has come.
const SAID_EVERY: usize = 64 * AT_ONCE as usize;

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

    async fn pack_all(&self) -> Result<usize, WriteError> {
        let of = store::record::count_unpacked(&self.store).await.map_err(written)?;
        let (mut done, mut after) = (0, Id(0));
        while let Some((texts, last)) = store::record::unpacked(&self.store, after, AT_ONCE).await.map_err(written)? {
            self.idle.wait_for_idle(QUIET, GIVES_WAY).await;
            let Some(queue) = self.queue.upgrade() else { break };
            done += texts.len();
            queue.ask_in_turn(|reply| Job::Pack { texts, reply }).await?;
            if done % SAID_EVERY < AT_ONCE as usize {
                tracing::info!(done, of, "long texts of an earlier version are deflated");
            }
            after = last;
        }
        Ok(done)
    }
}

fn written(error: StoreError) -> WriteError {
    StorageError::from(error).into()
}
