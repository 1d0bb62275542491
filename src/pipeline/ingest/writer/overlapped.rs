//! Many records at once: a group is judged while the one before it is written.
//!
//! The next group is judged by what is remembered of its gyros, which holds what is still being written. Nothing but
//! the newest records of known gyros is therefore taken ahead: for all else the database is asked, and has to hold
//! everything first. (What it is asked of very many records that are no longer remembered one by one, it has long
//! held.) A small group is not worth it: while it waited, more would come that can share its transaction.

use super::group::{answer, prepare, settle};
use super::state::{Item, Prepared, Task, WritingGroup, items_of};
use crate::core::history_note::FAR_DAYS;
use crate::pipeline::ingest::submission::Submission;
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::{Job, StoreJob};
use crate::store::{Committer, Tables, Written};
use crate::telemetry;

/// Items from which on a group is written beside.
const MANY: usize = 128;
/// Items from which on the next group is begun while one is under way. The more there are in a group, the more rows a
/// page takes that has to be written anyway.
const ENOUGH: usize = 384;

/// Items from which on no more are added to a group. An import has three such groups of records under way: while one
/// is written and the next judged, lines of a third are read.
pub(super) const MAX_ITEMS: usize = 640;

/// Waits until what is under way has been written, or could not be. Nothing is waited for where nothing is.
pub(super) async fn written(under_way: &mut Option<WritingGroup>) {
    if let Some(under_way) = under_way {
        under_way.wait().await;
    }
}

impl Task {
    /// Whether more is to be waited for before the next group is begun: until what is under way has been written, or
    /// enough has come.
    pub(super) fn is_to_wait(&self, jobs: &[Job]) -> bool {
        let to_store = |job: &Job| match job {
            Job::Store(job) => Some(job.items.len()),
            _ => None,
        };
        let waiting = jobs.iter().map(to_store).sum::<Option<usize>>();
        let may_wait = self.under_way.is_some() && jobs.len() < self.state.config.database.max_group;
        may_wait && waiting.is_some_and(|items| items < ENOUGH)
    }

    /// Has a group written beside, where it can be; otherwise gives it back, and nothing is under way.
    pub(super) async fn write_overlapped(&mut self, jobs: Vec<StoreJob>) -> Option<Vec<StoreJob>> {
        let items: Vec<Item<'_>> = jobs.iter().flat_map(items_of).collect();
        if !self.can_go_beside(&items) {
            self.finish().await;
            return Some(jobs);
        }
        let prepared = prepare(&mut self.state, &items).await;
        written(&mut self.under_way).await;
        let before = self.under_way.take();
        let holds = before.as_ref().is_none_or(WritingGroup::is_stored);
        if let (Ok(prepared), true, Some(committer)) = (prepared, holds, self.state.writer.committer()) {
            self.under_way = Some(self.begin_beside(jobs, prepared, committer));
            self.conclude(before).await;
            return None;
        }
        self.conclude(before).await;
        self.state.start_over();
        Some(jobs)
    }

    fn begin_beside(&mut self, jobs: Vec<StoreJob>, mut prepared: Prepared, committer: Committer) -> WritingGroup {
        let changes = std::mem::take(&mut prepared.changes);
        let mut newest = HashMap::new();
        for record in &changes.records {
            let newest = newest.entry(record.imu).or_insert(record.calibrated_at);
            *newest = record.calibrated_at.max(*newest);
        }
        let writing = committer.commit(changes);
        WritingGroup { jobs, prepared, newest, writing, written: None }
    }

    fn can_go_beside(&self, items: &[Item<'_>]) -> bool {
        let reader = self.state.reader();
        if items.iter().filter_map(|item| item.sent.calibration()).any(|sent| reader.is_outdated(sent)) {
            return false;
        }
        let tables = self.state.store.names().read();
        let room = !self.state.behind
            && !self.state.judge.is_full()
            && !self.state.memory.is_full()
            && self.state.writer.committer().is_some();
        room && items.len() >= MANY && items.iter().all(|item| self.asks_nothing(item, &tables))
    }

    /// Whether an item can be judged by what is remembered, and by what has long been stored: a calibration of a known
    /// IMU, station and gyros that is newer than all there is of them, but not by decades.
    fn asks_nothing(&self, item: &Item<'_>, tables: &Tables) -> bool {
        let Submission::Calibration(sent) = item.sent else { return false };
        let at = sent.calibrated_at;
        let newest_of_imu = |imu: u32| {
            let under_way = self.under_way.as_ref().and_then(|group| group.newest.get(&imu)).copied();
            under_way.max(store::record::newest_in_file(&self.state.store, imu))
        };
        let follows = |gyro: u32| {
            let newest = self.state.memory.newest_of(gyro);
            newest.is_some_and(|newest| newest < at && at.days_since(newest) <= FAR_DAYS)
                && self.state.benched.get(&gyro) == Some(&false)
        };
        sent.idempotency_key.is_none()
            && tables.stations.number(sent.station.as_str()).is_some()
            && tables.imus.number(sent.imu.as_str()).and_then(newest_of_imu).is_some_and(|newest| newest < at)
            && sent.gyros.iter().all(|gyro| tables.gyros.number(gyro.serial.as_str()).is_some_and(follows))
    }

    /// Waits for what is under way, and answers it.
    pub(super) async fn finish(&mut self) {
        written(&mut self.under_way).await;
        let under_way = self.under_way.take();
        self.conclude(under_way).await;
    }

    /// Answers a group that has been written. One that could not be is tried once more, by itself: nothing else is
    /// under way then.
    async fn conclude(&mut self, group: Option<WritingGroup>) {
        let Some(WritingGroup { jobs, mut prepared, written, .. }) = group else { return };
        match written {
            Some(Written { changes, outcome: Ok(()), took }) => {
                metrics::histogram!(telemetry::COMMIT).record(took);
                self.state.wake(&changes);
                prepared.changes = changes;
                let items: Vec<Item<'_>> = jobs.iter().flat_map(items_of).collect();
                let replies = settle(&items, prepared, &self.state.after.due);
                answer(jobs, replies);
            }
            _ => {
                self.state.start_over();
                self.store_all(jobs).await;
            }
        }
    }
}
