//! The way of a record, a campaign or a bench result: read, admitted, judged, stored with its alerts, answered.

mod accepted;
pub(super) mod admit;
pub(super) mod campaign;
pub(super) mod judge;
mod reader;
mod same_content;
pub(super) mod stale;
pub(super) mod submission;
pub(super) mod unpacked;
pub(super) mod writer;

use tokio::sync::oneshot;

use super::diagnoses::background::IdleDetector;
use super::write_queue::{Job, StoreJob, WriteQueue};
use crate::pipeline::prelude::*;
use crate::store::IdSource;
use admit::{Admission, Group, Lookup, Prefetched, RecentRecords};

pub use accepted::{Accepted, Judged, Reply};
pub use campaign::ReadCampaign;
pub(super) use campaign::Restated;
pub use reader::Reader;
pub use same_content::Origin;
pub use submission::{
    AttributesOrder, CalibratedGyro, Calibration, Confirmation, Corrected, Correction, EventOrder, SetAsideOrder,
    Submission, WindowMark,
};

/// Beyond every identifier of this century.
const NEVER_STORED: i64 = i64::MAX - (1 << 40);

/// What would become of a document.
#[derive(Debug, Clone)]
pub enum Preview {
    /// It would be stored with these notes, or is there already and says the same.
    Taken {
        notes: Arc<[Note]>,
    },
    Refused(Refused),
    /// An earlier one of these documents, counted from 0, holds its place with other content.
    Contradicts(usize),
}

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
    /// [`Refused`]; then nothing of it is stored, but after [`StoreError::Unanswered`] that is not known.
    pub async fn submit(&self, item: Submission) -> Result<Accepted, Refused> {
        self.submit_late(item, Late::Quiet).await
    }

    /// As [`Ingest::submit`], with a say in how what is found late is told.
    pub async fn submit_late(&self, item: Submission, late: Late) -> Result<Accepted, Refused> {
        self.activity.note_activity();
        let partition = self.queue.partition_of(&self.store, &item);
        let (reply, answer) = oneshot::channel();
        let (items, by) = (vec![item], Actor::by_caller());
        self.queue.offer_to(partition, Job::Store(StoreJob { items, by, with_verdicts: true, late, reply }))?;
        let mut replies = answer.await.map_err(|_| Refused::Stopping)?;
        replies.pop().unwrap_or(Err(Refused::Stopping))
    }

    /// As [`Ingest::submit`] for many, each with an answer of its own that leaves out the verdicts. Waits for room in
    /// the queues; what it then returns waits for the disk, so that the next items can be made ready meanwhile.
    pub async fn enqueue(&self, items: Vec<Submission>, late: Late) -> impl Future<Output = Vec<Reply>> + use<> {
        self.activity.note_activity();
        let mut partitions: BTreeMap<usize, (Vec<usize>, Vec<Submission>)> = BTreeMap::new();
        let count = items.len();
        for (place, item) in items.into_iter().enumerate() {
            let (places, of_partition) = partitions.entry(self.queue.partition_of(&self.store, &item)).or_default();
            places.push(place);
            of_partition.push(item);
        }
        let mut answers = Vec::with_capacity(partitions.len());
        for (partition, (places, items)) in partitions {
            let (reply, answer) = oneshot::channel();
            let job = StoreJob { items, by: Actor::by_caller(), with_verdicts: false, late, reply };
            // Where the writer is gone, the reply is dropped with the job, and the answer says so.
            let _queued = self.queue.send_to(partition, Job::Store(job)).await;
            answers.push((places, answer));
        }
        async move {
            let mut replies: Vec<Reply> = vec![Err(Refused::Stopping); count];
            for (places, answer) in answers {
                for (place, reply) in places.into_iter().zip(answer.await.unwrap_or_default()) {
                    replies[place] = reply;
                }
            }
            replies
        }
    }

    /// An import has come to its end: hooks are told in one message each what it has left firing since long ago.
    ///
    /// # Errors
    /// [`Refused`]; then it is told when nothing has come for a while.
    pub async fn end_import(&self) -> Result<(), Refused> {
        self.queue.ask_in_turn(Job::Digest).await
    }

    /// Has alerts of what gyros share follow what has been written, before the clock does.
    ///
    /// # Errors
    /// [`Refused`]; then the clock does.
    pub async fn look_at_shared(&self) -> Result<(), Refused> {
        self.queue.ask_in_turn(Job::Shared).await
    }

    /// The id, where an item that was already there says the same as the one sent: however it is written, in whatever
    /// order of members or gyros, unit of time or offset.
    pub async fn settle(&self, accepted: &Accepted, sent: Option<&Origin>) -> Result<Id, Refused> {
        let (existing, same_bytes) = match accepted {
            Accepted::Stored { id, .. } => (*id, true),
            Accepted::There { id, same_bytes, .. } => (*id, *same_bytes),
        };
        let Some(sent) = sent.filter(|_| !same_bytes) else { return Ok(existing) };
        let differences = same_content::differences(&self.store, existing, sent).await?;
        if differences.is_empty() { Ok(existing) } else { Err(Refused::Differs { existing, differences }) }
    }

    /// What would become of each of these documents if they were stored now, in this order: admitted to a group that is
    /// then dropped. Each takes queries of its own. Somebody else may store something in between.
    pub async fn preview(&self, documents: &[&Submission]) -> Vec<Preview> {
        let origins: Vec<Option<Origin>> = documents.iter().map(|sent| Origin::of(sent)).collect();
        // Its identifiers are seen by nobody; they only have to differ from those that are stored.
        let mut ids = IdSource::after(NEVER_STORED);
        let (mut memory, ahead, nobody) = (RecentRecords::default(), Prefetched::default(), Actor::by_caller());
        let mut admission = Admission {
            known: Lookup {
                store: &self.store,
                memory: &mut memory,
                benched: &HashMap::new(),
                ahead: &ahead,
                group: Group::default(),
            },
            ids: &mut ids,
            config: &self.config,
            now: self.clock.now(),
            by: &nobody,
        };
        let mut new = HashMap::new();
        let mut previews = Vec::with_capacity(documents.len());
        for (place, document) in documents.iter().enumerate() {
            let admitted = admission.admit(document).await;
            if let Ok(Accepted::Stored { id, .. }) = &admitted {
                new.insert(*id, place);
            }
            previews.push(self.outcome(admitted, place, &origins, &new).await);
        }
        previews
    }

    /// `new`: which document would be stored under an identifier.
    async fn outcome(
        &self,
        admitted: Result<Accepted, Refused>,
        place: usize,
        origins: &[Option<Origin>],
        new: &HashMap<Id, usize>,
    ) -> Preview {
        match admitted {
            Ok(Accepted::Stored { notes, .. }) => Preview::Taken { notes },
            Ok(Accepted::There { counts: false, .. }) => Preview::Taken { notes: [Note::Withdrawn].into() },
            Ok(there @ Accepted::There { id, same_bytes, .. }) => match new.get(&id) {
                Some(&first) if same_bytes || Origin::say_the_same(&origins[first], &origins[place]) => {
                    Preview::Taken { notes: [].into() }
                }
                Some(&first) => Preview::Contradicts(first),
                None => match self.settle(&there, origins[place].as_ref()).await {
                    Ok(_) => Preview::Taken { notes: [].into() },
                    Err(refused) => Preview::Refused(refused),
                },
            },
            Err(Refused::GyroElsewhere { existing, .. }) if new.contains_key(&existing) => {
                Preview::Contradicts(new[&existing])
            }
            Err(refused) => Preview::Refused(refused),
        }
    }
}
