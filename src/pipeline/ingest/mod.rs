//! The way of a record, a campaign or a bench result: read, admitted, judged, stored with its alerts, answered.

pub(super) mod admit;
pub(super) mod campaign;
mod document;
pub(super) mod fitted;
pub(super) mod judge;
mod outcome;
mod preview;
mod reader;
mod refused;
mod reply;
mod same_content;
pub(super) mod submission;
pub(super) mod writer;

use std::sync::Arc;

use super::access::Actor;
use super::diagnoses::background::IdleDetector;
use super::error::WriteError;
use super::write_queue::{Job, WriteQueue};
use crate::config::Config;
use crate::core::alert_decision::Late;
use crate::core::id::Id;
use crate::store::Store;
use crate::system::Clock;

pub use document::{Origin, ReadDocument};
pub use fitted::{Fitted, ReadCampaign};
pub use outcome::{Accepted, Judged, Reply};
pub use preview::Preview;
pub use reader::Reader;
pub use refused::Refused;
pub(super) use reply::ReplySender;
pub use same_content::Sent;
pub use submission::{
    BenchTest, CalibratedGyro, Calibration, Confirmation, Corrected, Correction, GyroEvent, Submission,
};

/// The way in. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Ingest {
    pub(super) store: Store,
    pub(super) config: Arc<Config>,
    pub(super) clock: Clock,
    pub(super) queue: WriteQueue,
    pub(super) activity: IdleDetector,
}

impl Ingest {
    /// Stores and judges one item; returns once it is on disk.
    ///
    /// # Errors
    /// [`Refused`]; then nothing of it is stored, but after [`StorageFault::Unanswered`](super::StorageFault) that is
    /// not known.
    pub async fn submit(&self, item: Submission) -> Result<Accepted, Refused> {
        let (accepted, ()) = self.submit_worded(item, |_| ()).await?;
        Ok(accepted)
    }

    /// As [`Ingest::submit`], with what `put_into_words` makes of what becomes of the item. It is called while the
    /// disk works, so what it makes may be told to nobody before this returns; it is called again where something
    /// else came true.
    ///
    /// # Errors
    /// As [`Ingest::submit`].
    pub async fn submit_worded<T>(
        &self,
        item: Submission,
        put_into_words: impl FnMut(&Accepted) -> T,
    ) -> Result<(Accepted, T), Refused> {
        self.submit_late(item, Late::Quiet, put_into_words).await
    }

    /// As [`Ingest::submit_worded`], with a say in how what is found late is told.
    ///
    /// # Errors
    /// As [`Ingest::submit`].
    pub async fn submit_late<T>(
        &self,
        item: Submission,
        late: Late,
        mut put_into_words: impl FnMut(&Accepted) -> T,
    ) -> Result<(Accepted, T), Refused> {
        self.activity.note_activity();
        let (reply, listener) = reply::channel();
        self.queue.offer(Job::Store { items: vec![item], by: Actor::by_caller(), with_verdicts: true, late, reply })?;
        let heard = listener.hear(|replies| replies.first()?.as_ref().ok().map(&mut put_into_words)).await;
        let (mut replies, words) = heard.ok_or(WriteError::Stopping)?;
        let accepted = replies.pop().unwrap_or(Err(WriteError::Stopping.into()))?;
        Ok((accepted, words.expect("the one reply was accepted, so it was put into words")))
    }

    /// As [`Ingest::submit`] for many, each with an answer of its own that leaves out the verdicts. Waits for room in
    /// the queue; what it then returns waits for the disk, so that the next items can be made ready meanwhile.
    pub async fn enqueue(&self, items: Vec<Submission>, late: Late) -> impl Future<Output = Vec<Reply>> + use<> {
        self.activity.note_activity();
        let count = items.len();
        let (reply, listener) = reply::channel();
        // Where the writer is gone, the reply is dropped with the job, and the answer says so.
        let _queued =
            self.queue.send(Job::Store { items, by: Actor::by_caller(), with_verdicts: false, late, reply }).await;
        async move {
            let heard = listener.hear(|_| ()).await;
            heard.map_or_else(|| vec![Err(WriteError::Stopping.into()); count], |(replies, ())| replies)
        }
    }

    /// An import has come to its end: hooks are told in one message each what it has left firing since long ago.
    ///
    /// # Errors
    /// [`WriteError`]; then it is told when nothing has come for a while.
    pub async fn end_import(&self) -> Result<(), WriteError> {
        self.queue.ask_in_turn(Job::Digest).await
    }

    /// The id, where an item that was already there says the same as the one sent: however it is written, in whatever
    /// order of members or gyros, unit of time or offset.
    ///
    /// # Errors
    /// [`Refused::Differs`] with the members that differ.
    pub async fn settle(&self, accepted: &Accepted, sent: Sent<'_>) -> Result<Id, Refused> {
        let (existing, same_bytes) = match accepted {
            Accepted::Stored { id, .. } => (*id, true),
            Accepted::There { id, same_bytes } => (*id, *same_bytes),
        };
        if same_bytes {
            return Ok(existing);
        }
        let differences = same_content::differences(&self.store, existing, sent).await?;
        if differences.is_empty() { Ok(existing) } else { Err(Refused::Differs { existing, differences }) }
    }

    /// As [`Ingest::settle`], of a document.
    ///
    /// # Errors
    /// [`Refused::Differs`] where it is there with other content.
    pub async fn settle_document(&self, accepted: &Accepted, origin: &Origin) -> Result<Id, Refused> {
        self.settle(accepted, origin.sent()).await
    }
}
