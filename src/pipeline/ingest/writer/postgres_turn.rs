//! The writer among other servers: it takes its turn, learns what the others have written, and tries again what the
//! database has broken off. Alone on a file it is always its turn, and nothing is missed.

use std::time::Duration;

use super::state::Task;
use super::{HookCache, Newest};
use crate::core::id::Id;
use crate::pipeline::error::Unwritten;
use crate::store;
use crate::store::{Missed, Moves, StoreError};

/// Records of others that are looked at one by one; after more everything is read again.
const FEW: u32 = 20_000;
const MOST_TRIES: u32 = 4;
const FIRST_PAUSE: Duration = Duration::from_millis(30);

/// Does `$work` in a turn; tries again where the database has broken it off.
macro_rules! in_turn {
    ($task:ident, $work:expr) => {{
        let mut tries = 0;
        loop {
            let done = match $task.begin().await {
                Ok(()) => $work.await,
                Err(error) => Err(error.into()),
            };
            $task.writer.give_back().await;
            if !$crate::pipeline::ingest::writer::postgres_turn::to_be_tried_again(&done, &mut tries).await {
                break done;
            }
        }
    }};
}

pub(super) use in_turn;

/// Whether nothing was stored and another try may do better; waits before it.
pub(super) async fn another_try(error: &StoreError, tries: &mut u32) -> bool {
    *tries += 1;
    let worth_it = matches!(error, StoreError::Unreachable(_)) && *tries < MOST_TRIES;
    if worth_it {
        tracing::warn!(%error, tries, "the database broke a transaction off; trying again");
        tokio::time::sleep(FIRST_PAUSE * 3_u32.pow(*tries - 1)).await;
    }
    worth_it
}

pub(super) async fn to_be_tried_again<T>(done: &Result<T, impl Unwritten>, tries: &mut u32) -> bool {
    match done.as_ref().err().and_then(Unwritten::store_error) {
        Some(error) => another_try(error, tries).await,
        None => false,
    }
}

/// What is written next; never where no other server can be.
pub(super) async fn next_of(moves: &mut Option<Moves>) -> Option<Missed> {
    match moves {
        Some(moves) => moves.next().await,
        None => std::future::pending().await,
    }
}

impl Task {
    /// Takes the turn and catches up with what others have written since the last.
    pub(super) async fn begin(&mut self) -> Result<(), StoreError> {
        let missed = self.writer.take_turn().await?;
        let caught_up = if std::mem::take(&mut self.behind) {
            self.catch_up(&Missed::EVERYTHING).await
        } else {
            self.catch_up(&missed).await
        };
        self.behind = caught_up.is_err();
        caught_up
    }

    async fn catch_up(&mut self, missed: &Missed) -> Result<(), StoreError> {
        if missed.everything {
            self.read_all_again().await?;
        }
        if let Some(after) = missed.records_after {
            self.learn_records(after).await?;
        }
        if let Some(version) = missed.touched_after {
            self.learn_touched(version).await?;
        }
        if missed.outbox {
            self.hooks = HookCache::load(&self.store).await?;
        }
        if missed.models {
            self.after.models.read_again(&self.store).await?;
        }
        if missed.access {
            self.after.guard.read_again().await?;
        }
        Ok(())
    }

    async fn read_all_again(&mut self) -> Result<(), StoreError> {
        self.judge.forget();
        self.memory.forget();
        self.alerts.forget();
        self.newest = Newest::load(&self.store).await?;
        self.benched = store::bench::gyros_on_benches(&self.store).await?.into_iter().collect();
        Ok(())
    }

    async fn learn_records(&mut self, after: Id) -> Result<(), StoreError> {
        let records = store::record::since(&self.store, after, FEW).await?;
        if records.len() == FEW as usize {
            return self.read_all_again().await;
        }
        for (imu, at, gyros) in records {
            self.newest.learn_of(imu, at, &gyros);
            self.judge.forget_of(&gyros);
            self.memory.forget_of(gyros);
        }
        Ok(())
    }

    /// Gyros to which others have done something are looked at anew, and no others.
    async fn learn_touched(&mut self, version: i64) -> Result<(), StoreError> {
        let gyros = store::standing::touched_since(&self.store, version).await?;
        self.judge.forget_of(&gyros);
        self.memory.forget_of(gyros.iter().copied());
        self.newest.read_again(&self.store, &gyros).await?;
        self.benched.extend(store::bench::on_benches(&self.store, &gyros).await?);
        self.alerts.refresh_of(&gyros, &self.store, self.clock.now()).await
    }

    /// Tells those who read and those who work in the background of what was written, by whomever.
    pub(super) async fn hear_of(&mut self, missed: &Missed) {
        if missed.outbox {
            self.after.wake.send_modify(|moved| *moved += 1);
        }
        if missed.diagnoses {
            self.after.due.send_modify(|moved| *moved += 1);
        }
        let models = if missed.models { self.after.models.read_again(&self.store).await } else { Ok(()) };
        let access = if missed.access { self.after.guard.read_again().await } else { Ok(()) };
        if let Err(error) = models.and(access) {
            tracing::warn!(%error, "what another server has written cannot be read; its next change is");
        }
    }
}
