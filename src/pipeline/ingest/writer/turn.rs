//! A writer among others: it holds the cells of what it writes, learns what others have written there, and tries again
//! what the database has broken off. Alone on a file it holds everything, and nothing is missed.

use super::homes::Homes;
use super::state::{Item, WriterState};
use crate::pipeline::prelude::*;
use crate::pipeline::{Reader, Submission};
use crate::store::{Cells, ChangeFeed, ChangeTopic, RemoteChanges};

const MOST_TRIES: u32 = 4;
const FIRST_PAUSE: Duration = Duration::from_millis(30);

/// Does `$work` while `$cells` are held; tries again where the database has broken it off.
macro_rules! in_turn {
    ($state:expr, $cells:expr, $work:expr) => {{
        let mut tries = 0;
        loop {
            let done = match $state.begin(&$cells).await {
                Ok(()) => $work.await,
                Err(error) => Err(error.into()),
            };
            $state.writer.give_back().await;
            if !$crate::pipeline::ingest::writer::turn::to_be_tried_again(&done, &mut tries).await {
                break done;
            }
            $state.start_over();
        }
    }};
}

pub(super) use in_turn;

/// Whether nothing was stored and another try may do better; waits before it.
pub(super) async fn another_try(error: &StoreError, tries: &mut u32) -> bool {
    *tries += 1;
    let may_do_better = matches!(error, StoreError::Unreachable(_) | StoreError::Overtaken(_));
    let worth_it = may_do_better && *tries < MOST_TRIES;
    if worth_it {
        tracing::warn!(%error, tries, "the database broke a transaction off; trying again");
        tokio::time::sleep(FIRST_PAUSE * 3_u32.pow(*tries - 1)).await;
    }
    worth_it
}

pub(super) async fn to_be_tried_again<T>(done: &Result<T, Refused>, tries: &mut u32) -> bool {
    match done {
        Err(Refused::Storage(error)) => another_try(error, tries).await,
        _ => false,
    }
}

/// What is written next; never where no other server can be.
pub(super) async fn next_of(change_feed: &mut Option<ChangeFeed>) -> Option<RemoteChanges> {
    match change_feed {
        Some(change_feed) => change_feed.next().await,
        None => std::future::pending().await,
    }
}

impl WriterState {
    /// Holds `cells` and catches up with what others have written in them.
    pub(super) async fn begin(&mut self, cells: &Cells) -> Result<(), StoreError> {
        let remote_changes = self.writer.lock_cells(cells).await?;
        if std::mem::take(&mut self.behind) {
            self.start_over();
        }
        let caught_up = self.catch_up(&remote_changes).await;
        self.behind = caught_up.is_err();
        caught_up
    }

    async fn catch_up(&mut self, remote_changes: &RemoteChanges) -> Result<(), StoreError> {
        if !remote_changes.cells.is_empty() {
            self.forget_cells(&remote_changes.cells.iter().copied().collect());
        }
        if remote_changes.brings(ChangeTopic::Settings) {
            self.alerts.forget_settings();
            self.hooks.forget();
        }
        self.read_again(remote_changes).await
    }

    /// Reads again the models and who may use the service, where somebody else has changed them.
    async fn read_again(&self, remote_changes: &RemoteChanges) -> Result<(), StoreError> {
        if remote_changes.brings(ChangeTopic::Access) {
            self.after.guard.read_again().await?;
        }
        if remote_changes.brings(ChangeTopic::Models) {
            self.after.models.read_again(&self.store).await?;
        }
        Ok(())
    }

    /// Forgets what is remembered of the gyros that are at home in `cells`.
    fn forget_cells(&mut self, cells: &HashSet<u8>) {
        let tables = self.store.names().read();
        let lost = |gyro| tables.gyros.cell(gyro).is_none_or(|cell| cells.contains(&cell));
        self.judge.forget_where(lost);
        self.memory.forget_where(lost);
        self.alerts.forget_where(lost);
        self.benched.retain(|gyro, _| !lost(*gyro));
        self.hooks.forget_heard();
    }

    /// As [`WriterState::begin`], of what `items` are about, whose names are known then.
    pub(super) async fn begin_group(&mut self, items: &[Item<'_>]) -> Result<(), StoreError> {
        if !self.writer.is_one_of_many() {
            return self.begin(&Cells::default()).await;
        }
        let mut cells = self.homes().of_items(items).await?;
        loop {
            self.begin(&cells).await?;
            store::names::look_up(&self.store, names_of(items)).await?;
            let wanted = self.homes().of_items(items).await?;
            if cells.is_superset(&wanted) {
                return Ok(());
            }
            // Somebody else has just taken a new gyro home.
            self.writer.give_back().await;
            cells.extend(wanted);
        }
    }

    /// Commits, and wakes the worker where that gave it something to do.
    pub(super) async fn commit(&mut self, changes: &Changes) -> Result<(), StoreError> {
        self.writer.commit(changes).await?;
        self.wake(changes);
        Ok(())
    }

    /// Wakes the worker where what has been committed gives it something to do.
    pub(super) fn wake(&self, changes: &Changes) {
        if !changes.outbox.queued.is_empty() {
            self.after.wake.send_modify(|moved| *moved += 1);
        }
    }

    /// Keeps what is remembered within its bounds; when all of it is stored.
    pub(super) fn tidy(&mut self) {
        self.judge.tidy();
        self.alerts.tidy();
        self.hooks.tidy();
        if self.memory.is_full() {
            self.memory.forget();
            self.benched.clear();
        }
    }

    /// Forgets what is remembered of gyros and alerts: it is ahead of what is stored.
    pub(super) fn start_over(&mut self) {
        self.judge.forget();
        self.memory.forget();
        self.alerts.forget();
        self.benched.clear();
        self.seen_at.clear();
        self.hooks.forget();
        self.nothing_shared = None;
    }

    /// Hooks have changed, or have something new to be told.
    pub(super) fn look_at_hooks(&mut self) {
        self.hooks.forget();
        self.after.wake.send_modify(|moved| *moved += 1);
    }

    pub(super) fn reader(&self) -> Reader {
        Reader {
            store: self.store.clone(),
            config: self.config.clone(),
            clock: self.clock.clone(),
            models: self.after.models.clone(),
        }
    }

    pub(super) fn homes(&self) -> Homes<'_> {
        Homes { store: &self.store, among_others: self.writer.is_one_of_many() }
    }

    /// Tells those who read and those who work in the background of what was written, by whomever.
    pub(super) async fn apply_remote_changes(&mut self, remote_changes: &RemoteChanges) {
        if remote_changes.brings(ChangeTopic::Outbox) || remote_changes.brings(ChangeTopic::Settings) {
            self.after.wake.send_modify(|moved| *moved += 1);
        }
        if remote_changes.brings(ChangeTopic::Diagnoses) {
            self.after.due.send_modify(|moved| *moved += 1);
        }
        if let Err(error) = self.read_again(remote_changes).await {
            tracing::warn!(%error, "what another server has written cannot be read; its next change is");
        }
    }
}

/// Names of IMUs, stations and gyros.
fn names_of<'a>(items: &[Item<'a>]) -> [Vec<&'a str>; 3] {
    let [mut imus, mut stations, mut gyros] = [const { Vec::new() }; 3];
    for item in items {
        stations.extend(item.sent.station());
        gyros.extend(item.sent.serial());
        if let Submission::Window(sent) = item.sent {
            stations.push(sent.station.as_str());
        }
        if let Some(sent) = item.sent.calibration() {
            imus.push(sent.imu.as_str());
            gyros.extend(sent.gyros.iter().map(|gyro| gyro.serial.as_str()));
        }
    }
    [imus, stations, gyros]
}
