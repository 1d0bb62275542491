//! What waits to be diagnosed, worked off: newly stored campaigns first, then what orders wait for.
//!
//! The queue is the database. What a crash or a stop interrupts is still waiting there, and is taken up again; what
//! was done has been kept. Only a page of it is in memory at a time. Nobody waits for it, so it gives way to what
//! comes in. Servers that share a database claim what they make, a few at a time.

use std::future::ready;

use futures::{StreamExt, stream};
use tokio::sync::watch;
use tokio::time::Instant;

use super::diagnoser::Diagnoser;
use super::finished::{DiagnosisOutcome, FinishedDiagnosis};
use crate::pipeline::diagnoses::background::WorkPriority;
use crate::pipeline::prelude::*;
use crate::wire::message::to_stored;

/// How many due campaigns are looked up at once.
const PAGE: u32 = 64;
/// How many tasks of orders: more than a dozen other servers can have claimed.
const TASKS: u32 = 256;
/// How many are claimed at once, for each that is computed at the same time: few, for others to have their share.
const CLAIMED_EACH: usize = 4;
/// How long to wait where the database takes no diagnoses or cannot be read, or where other servers are at all that
/// is left.
const PAUSE: Duration = Duration::from_secs(5);
/// One that cannot be kept is made again after that, then after twice as long, up to this.
const LONGEST_PAUSE: Duration = Duration::from_secs(600);

impl Diagnoser {
    /// Makes what is due and what is ordered, until nobody can make anything due any more.
    pub async fn run(self, mut due: watch::Receiver<u64>) {
        let (mut hopeless, mut postponed) = (HashSet::new(), Postponed::default());
        loop {
            due.mark_unchanged();
            let made = match self.make_due(&due, &mut hopeless, &mut postponed).await {
                Ok(due_left) => self.drain(&due, &mut postponed).await.map(|orders_left| due_left.max(orders_left)),
                Err(error) => Err(error),
            };
            let changed = match made {
                Ok(PassOutcome::Nothing) => due.changed().await,
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

    /// One pass over all campaigns that are due; what can never be read is told once and left alone.
    async fn make_due(
        &self,
        due: &watch::Receiver<u64>,
        hopeless: &mut HashSet<Id>,
        postponed: &mut Postponed,
    ) -> Result<PassOutcome, StoreError> {
        let (mut before, mut left) = (Id(i64::MAX), PassOutcome::Nothing);
        loop {
            let mut page = store::diagnosis::due(&self.reader.store, before, PAGE).await?;
            let Some(last) = page.last() else { return Ok(left) };
            before = *last;
            page.retain(|id| !hopeless.contains(id));
            left = left.max(postponed.take_from(&mut page, Instant::now()));
            while !page.is_empty() {
                let claimed = store::claim::claim(&self.reader.store, &page, self.claimed_at_once()).await?;
                if claimed.is_empty() {
                    left = PassOutcome::Something;
                    break;
                }
                page.retain(|id| !claimed.contains(id));
                let made = stream::iter(claimed.iter().copied())
                    .take_while(|_| ready(due.has_changed().is_ok()))
                    .map(|id| async move {
                        self.idle.give_way().await;
                        (id, self.diagnosis(id, WorkPriority::Background, Duration::MAX).await)
                    })
                    .buffer_unordered(self.at_once)
                    .collect();
                let made: Vec<_> = store::claim::while_claimed(&self.reader.store, &claimed, made).await;
                for (id, made) in made {
                    let is_kept = store::diagnosis::get(&self.reader.store, id).await?.is_some();
                    match made {
                        Ok(_) if is_kept => postponed.settled(id),
                        Ok(_) => {
                            postponed.postpone(id, Instant::now());
                            left = PassOutcome::Something;
                        }
                        Err(error @ StoreError::Damaged(_)) => {
                            tracing::warn!(%error, campaign = %id, "a campaign could not be diagnosed; it will be when it is asked for");
                            hopeless.insert(id);
                        }
                        Err(error) => {
                            tracing::warn!(%error, campaign = %id, "a campaign could not be diagnosed; it is tried again");
                            postponed.postpone(id, Instant::now());
                            left = PassOutcome::Something;
                        }
                    }
                }
                if due.has_changed().is_err() {
                    return Ok(left);
                }
            }
        }
    }

    /// What orders wait for, until something else is due.
    async fn drain(&self, due: &watch::Receiver<u64>, postponed: &mut Postponed) -> Result<PassOutcome, StoreError> {
        let mut tried = HashSet::new();
        loop {
            let mut page = store::diagnosis_job::tasks_waiting(&self.reader.store, TASKS).await?;
            if page.is_empty() || due.has_changed().unwrap_or(true) {
                return Ok(PassOutcome::Nothing);
            }
            // What still waits could not be kept.
            for id in tried.drain() {
                if page.contains(&id) { postponed.postpone(id, Instant::now()) } else { postponed.settled(id) }
            }
            let left = postponed.take_from(&mut page, Instant::now());
            let claimed = store::claim::claim(&self.reader.store, &page, self.claimed_at_once()).await?;
            // Others are at the rest.
            if claimed.is_empty() {
                return Ok(if page.is_empty() { left } else { PassOutcome::Something });
            }
            let settled = stream::iter(claimed.iter().copied())
                .take_while(|_| ready(due.has_changed().is_ok()))
                .map(|id| self.settle(id))
                .buffer_unordered(self.at_once)
                .for_each(ready);
            store::claim::while_claimed(&self.reader.store, &claimed, settled).await;
            tried.extend(claimed);
        }
    }

    fn claimed_at_once(&self) -> usize {
        CLAIMED_EACH * self.at_once
    }

    /// Makes a diagnosis that orders wait for, whether or not there is one. Where the database cannot be read now it
    /// goes on waiting; what can never be read has failed.
    async fn settle(&self, id: Id) {
        self.idle.give_way().await;
        let begun_at = self.reader.clock.now();
        match self.make(id).await {
            Ok(()) => {}
            Err(StoreError::Damaged(why)) => {
                let ended_at = self.reader.clock.now();
                let outcome = DiagnosisOutcome::Failed(to_stored(&why));
                self.have_kept(FinishedDiagnosis { campaign: id, begun_at, ended_at, outcome }).await;
            }
            Err(error) => tracing::warn!(%error, campaign = %id, "a campaign could not be read; it is tried again"),
        }
    }

    /// Returns once it is kept, or can never be.
    async fn make(&self, id: Id) -> Result<(), StoreError> {
        let missing = || StoreError::damaged(format_args!("campaign {id} is missing"));
        let row = self.campaign(id).await?.ok_or_else(missing)?;
        let in_force = self.reader.models.of(Some(row.imu));
        let mut end = self.begin(&row, in_force, WorkPriority::Background)?;
        // An end without an answer has been written down as well.
        let _broken_off = end.wait_for(Option::is_some).await;
        Ok(())
    }
}

/// What could not be made or kept: until when each is left alone, and for how long that was.
#[derive(Debug, Default)]
struct Postponed(HashMap<Id, (Instant, Duration)>);

impl Postponed {
    fn postpone(&mut self, id: Id, now: Instant) {
        let pause = self.0.get(&id).map_or(PAUSE, |(_, pause)| (2 * *pause).min(LONGEST_PAUSE));
        self.0.insert(id, (now + pause, pause));
    }

    fn settled(&mut self, id: Id) {
        self.0.remove(&id);
    }

    /// Takes those out that are left alone now.
    fn take_from(&self, ids: &mut Vec<Id>, now: Instant) -> PassOutcome {
        let before = ids.len();
        ids.retain(|id| self.0.get(id).is_none_or(|(until, _)| *until <= now));
        if ids.len() < before { PassOutcome::Something } else { PassOutcome::Nothing }
    }
}

/// What a pass leaves behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum PassOutcome {
    /// Nothing waits, or something else comes first.
    Nothing,
    /// What other servers are at, or what could not be kept: it is looked at again after a pause.
    Something,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_kept_is_made_again_ever_more_seldom() {
        let (mut postponed, id, begun) = (Postponed::default(), Id(7), Instant::now());
        let mut made = Vec::new();
        for looks in 0..720 {
            let now = begun + looks * PAUSE;
            if postponed.take_from(&mut vec![id], now) == PassOutcome::Nothing {
                made.push((now - begun).as_secs());
                postponed.postpone(id, now);
            }
        }
        assert_eq!(made[..5], [0, 5, 15, 35, 75]);
        assert!(made.len() < 15, "of an hour's 720 looks: {made:?}");
        postponed.settled(id);
        assert_eq!(postponed.take_from(&mut vec![id], begun), PassOutcome::Nothing);
    }
}
