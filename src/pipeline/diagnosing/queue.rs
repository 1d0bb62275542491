//! What waits to be diagnosed, worked off: newly stored campaigns first, then what orders wait for.
//!
//! The queue is the database. What a crash or a stop interrupts is still waiting there, and is taken up again; what was done
//! has been kept. Only a page of it is in memory at a time. Nobody waits for it, so it gives way to what comes in.

use std::collections::HashSet;
use std::future::ready;
use std::time::Duration;

use futures::StreamExt;
use futures::stream;
use tokio::sync::watch;

use super::{Diagnoser, Made, Outcome};
use crate::pipeline::background::Awaited;
use crate::store::{Duty, Id, Kind, StoreError};

/// How many due campaigns are looked up at once.
const PAGE: u32 = 64;
/// How many tasks of orders: few, so that a canceled order ends soon and a campaign that has just been stored comes soon.
const TASKS: u32 = 16;
/// How long to wait where the database takes no diagnoses or cannot be read.
const PAUSE: Duration = Duration::from_secs(5);
/// A diagnosis begins when nothing has come in for this long,
const QUIET: Duration = Duration::from_millis(100);
/// or when it has given way for this long.
const GIVES_WAY: Duration = Duration::from_secs(1);

impl Diagnoser {
    /// Makes what is due and what is ordered, until nobody can make anything due any more.
    pub async fn run(self, mut due: watch::Receiver<u64>) {
        let mut hopeless = HashSet::new();
        loop {
            due.mark_unchanged();
            let made = if self.is_on_duty() {
                match self.make_due(&due, &mut hopeless).await {
                    Ok(()) => self.work_off(&due).await,
                    Err(error) => Err(error),
                }
            } else {
                Ok(Worked::Nothing)
            };
            let changed = match made {
                Ok(Worked::Off) => due.changed().await,
                stuck => {
                    if let Err(error) = stuck {
                        tracing::warn!(%error, "what is to be diagnosed cannot be read; it is tried again");
                    }
                    tokio::time::timeout(PAUSE, due.changed()).await.unwrap_or(Ok(()))
                }
            };
            if changed.is_err() {
                break;
            }
        }
    }

    /// Whether no other server makes what nobody waits for.
    fn is_on_duty(&self) -> bool {
        self.store.is_on_duty(Duty::Diagnoses)
    }

    /// One pass over all campaigns that are due; what cannot be diagnosed is told once and left alone.
    async fn make_due(&self, due: &watch::Receiver<u64>, hopeless: &mut HashSet<Id>) -> Result<(), StoreError> {
        let mut before = Id(i64::MAX);
        loop {
            let mut page = self.store.diagnoses_due(before, PAGE).await?;
            let Some(last) = page.last() else { return Ok(()) };
            before = *last;
            page.retain(|id| !hopeless.contains(id));
            let mut made = stream::iter(page)
                .take_while(|_| ready(self.is_on_duty() && due.has_changed().is_ok()))
                .map(|id| async move {
                    self.bustle.lull(QUIET, GIVES_WAY).await;
                    (id, self.diagnosis(id, Awaited::ByNobody, Duration::MAX).await)
                })
                .buffer_unordered(self.at_once);
            while let Some((id, made)) = made.next().await {
                if let Err(error) = made {
                    tracing::warn!(%error, campaign = %id, "a campaign could not be diagnosed; it will be when it is asked for");
                    hopeless.insert(id);
                }
            }
            if due.has_changed().is_err() || !self.is_on_duty() {
                return Ok(());
            }
        }
    }

    /// What orders wait for, until something else is due.
    async fn work_off(&self, due: &watch::Receiver<u64>) -> Result<Worked, StoreError> {
        let mut before = Vec::new();
        loop {
            let page = self.store.tasks_waiting(TASKS).await?;
            if page.is_empty() || due.has_changed().unwrap_or(true) || !self.is_on_duty() {
                return Ok(Worked::Off);
            }
            // Nothing of it could be kept.
            if page == before {
                return Ok(Worked::Nothing);
            }
            stream::iter(page.iter().copied())
                .take_while(|_| ready(self.is_on_duty() && due.has_changed().is_ok()))
                .map(|id| self.settle(id))
                .buffer_unordered(self.at_once)
                .for_each(ready)
                .await;
            before = page;
        }
    }

    /// Makes a diagnosis that orders wait for, whether or not there is one. Where the database cannot be read now it goes on
    /// waiting; what can never be read has failed.
    async fn settle(&self, id: Id) {
        self.bustle.lull(QUIET, GIVES_WAY).await;
        let begun_at = self.clock.now();
        match self.make(id).await {
            Ok(()) => {}
            Err(StoreError::Damaged(why)) => {
                let ended_at = self.clock.now();
                self.have_kept(Made { campaign: id, begun_at, ended_at, outcome: Outcome::Failed(why) }).await;
            }
            Err(error) => tracing::warn!(%error, campaign = %id, "a campaign could not be read; it is tried again"),
        }
    }

    /// Returns once it is kept, or can never be.
    async fn make(&self, id: Id) -> Result<(), StoreError> {
        let missing = || StoreError::Damaged(format!("campaign {id} is missing"));
        let row = self.store.record(id).await?.filter(|row| row.kind == Kind::Campaign).ok_or_else(missing)?;
        let in_force = self.models.of(Some(row.imu));
        let mut end = self.begin(&row, in_force, Awaited::ByNobody)?;
        // An end without an answer has been written down as well.
        let _broken_off = end.wait_for(Option::is_some).await;
        Ok(())
    }
}

/// How far orders were worked off.
enum Worked {
    /// Nothing waits, or something else comes first.
    Off,
    /// Nothing could be kept, or another server is at it: it is tried again after a pause.
    Nothing,
}
