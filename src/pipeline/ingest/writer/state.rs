//! What the writer knows, and what passes through it.

use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};

use super::shared_shifts::NothingShared;
use crate::core::judge::{State, Status};
use crate::pipeline::alerts::AlertCache;
use crate::pipeline::diagnoses::models::ModelCache;
use crate::pipeline::hooks::HookCache;
use crate::pipeline::ingest::admit::RecentRecords;
use crate::pipeline::ingest::judge::{Judge, Verdicts};
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::StoreJob;
use crate::pipeline::{Calibration, Guard, Reply, Submission};
use crate::store::{Writer, Written};
use crate::telemetry;

/// Takes what has queued up and has it stored.
pub(crate) struct Task {
    pub(super) state: WriterState,
    pub(super) role: WriterRole,
    /// A group that is being written while the next is made ready.
    pub(super) under_way: Option<WritingGroup>,
    /// The look of the clock that is under way.
    pub(super) looks: JoinSet<Result<Option<NothingShared>, StoreError>>,
    /// Items from which on no more are added to a transaction among other writers.
    pub(super) items_at_once: usize,
}

/// What a writer writes with, and what it remembers of gyros and their alerts.
pub(super) struct WriterState {
    pub(super) store: Store,
    pub(super) writer: Writer,
    pub(super) clock: Clock,
    pub(super) config: Arc<Config>,
    pub(super) memory: RecentRecords,
    pub(super) judge: Judge,
    pub(super) alerts: AlertCache,
    /// Whether a bench has measured a gyro, so that its methods are to agree.
    pub(super) benched: HashMap<u32, bool>,
    /// Stations with gyros that they are known to have calibrated.
    pub(super) seen_at: HashSet<[u32; 2]>,
    pub(super) hooks: HookCache,
    pub(super) after: WriteNotifier,
    /// What others have written could not be read: everything is read again.
    pub(super) behind: bool,
    /// None where that is to be looked at.
    pub(super) nothing_shared: Option<NothingShared>,
}

/// Where a writer stands among those of its process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WriterRole {
    /// It stores, and nothing else.
    Partition,
    /// It carries out orders and follows the clock; alone, it stores as well.
    Orders,
}

/// A submission of a group.
#[derive(Clone, Copy)]
pub(super) struct Item<'a> {
    pub(super) sent: &'a Submission,
    pub(super) by: &'a Actor,
    /// Whether its answer is to hold the verdicts on it.
    pub(super) with_verdicts: bool,
    /// How what is found late is told.
    pub(super) late: Late,
}

pub(super) fn items_of(job: &StoreJob) -> impl Iterator<Item = Item<'_>> {
    let StoreJob { items, by, with_verdicts, late, .. } = job;
    items.iter().map(|sent| Item { sent, by, with_verdicts: *with_verdicts, late: *late })
}

/// Who is told of what has been written.
#[derive(Clone)]
pub(crate) struct WriteNotifier {
    /// Moves when a hook has changed or has something new to be told.
    pub wake: watch::Sender<u64>,
    pub models: ModelCache,
    /// Moves when diagnoses have become due.
    pub due: watch::Sender<u64>,
    pub guard: Guard,
}

/// What a group comes to, before it is written.
pub(super) struct Prepared {
    pub changes: Changes,
    /// One an item; they hold when the changes are on disk.
    pub replies: Vec<Reply>,
    pub(super) tally: Tally,
}

/// A group that is being written.
pub(super) struct WritingGroup {
    pub(super) jobs: Vec<StoreJob>,
    /// Without its changes, which are with the thread that writes them.
    pub(super) prepared: Prepared,
    /// When the newest record of each of its IMUs was made.
    pub(super) newest: HashMap<u32, UtcMicros>,
    pub(super) writing: JoinHandle<Written>,
    pub(super) written: Option<Written>,
}

impl WritingGroup {
    pub async fn wait(&mut self) {
        if self.written.is_none() {
            let written = (&mut self.writing).await;
            self.written = Some(written.unwrap_or_else(|error| std::panic::resume_unwind(error.into_panic())));
        }
    }

    pub fn is_stored(&self) -> bool {
        self.written.as_ref().is_some_and(|written| written.outcome.is_ok())
    }
}

/// Verdicts on new records, by rule, state and status: a record has dozens.
#[derive(Debug, Default)]
pub(super) struct Tally([([u64; State::ALL.len()], [u64; Status::ALL.len()]); Rule::ALL.len()]);

impl Tally {
    /// Of the records of a group that are new: what needs no history is with what was sent.
    pub fn of(sent: &HashMap<Id, &Calibration>, changes: &Changes, verdicts: &Verdicts) -> Self {
        let mut tally = Self::default();
        for sent in sent.values() {
            tally.add(sent.gyros.iter().flat_map(|gyro| gyro.requirements.iter().flatten()));
        }
        let new: HashSet<Id> = changes.records.iter().map(|record| record.id).collect();
        for (_, verdicts) in verdicts.iter().filter(|((record, _), _)| new.contains(record)) {
            tally.add(verdicts);
        }
        tally
    }

    pub fn add<'a>(&mut self, verdicts: impl IntoIterator<Item = &'a Verdict>) {
        for verdict in verdicts {
            let (states, statuses) = &mut self.0[verdict.rule as usize];
            states[verdict.state as usize] += 1;
            statuses[verdict.status() as usize] += 1;
        }
    }

    pub fn count(&self) {
        for (rule, (states, statuses)) in Rule::ALL.iter().zip(&self.0) {
            for (state, count) in State::ALL.iter().zip(states).filter(|(_, count)| **count > 0) {
                metrics::counter!(telemetry::VERDICTS, "rule" => rule.name(), "state" => state.name())
                    .increment(*count);
            }
            for (status, count) in Status::ALL.iter().zip(statuses).filter(|(_, count)| **count > 0) {
                metrics::counter!(telemetry::STATUSES, "rule" => rule.name(), "status" => status.name())
                    .increment(*count);
            }
        }
    }
}
