//! A writer: takes what has queued up as a group, stores it in one transaction, answers everyone. A file has one; of a
//! database server a process has several, and one of them carries out orders and follows the clock.

pub(crate) mod alerts;
mod clock;
mod forecasts;
mod group;
mod heads;
mod homes;
pub(crate) mod overlapped;
mod restate;
mod shared_shifts;
mod state;
pub(crate) mod turn;

use std::ops::RangeInclusive;
use std::time::Instant;

use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Interval, MissedTickBehavior, interval_at};

use super::admit::RecentRecords;
use crate::pipeline::access::{Secret, order_access};
use crate::pipeline::alerts::AlertCache;
use crate::pipeline::diagnoses::{order_diagnoses, order_hypothesis};
use crate::pipeline::hooks::{Found, HookCache, HookHandler};
use crate::pipeline::ingest::judge::Judge;
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::{Job, ReplyTo, StoreJob};
use crate::pipeline::{AccessOrder, DiagnosisOrder, HypothesisOrder, Order, Reply, Submission};
use crate::store::{Cells, LeasedTask, Writer, all_cells};
use crate::telemetry;
use group::{answer, prepare, settle};
use state::{Item, WriterState, items_of};
use turn::in_turn;

pub(crate) use heads::make_missing;
pub(crate) use state::{Task, WriteNotifier, WriterRole};

/// How long a transaction may keep others from its cells, as far as that can be foretold.
const TURN: Duration = Duration::from_millis(500);
/// The clock is looked at for the first time so long after the start.
const AFTER_START: Duration = Duration::from_secs(1);
/// Items of one transaction, as many as are stored in a [`TURN`].
const ITEMS: RangeInclusive<usize> = 64..=8192;

/// Gyros that are looked at within the turn that corrects a record of one.
const SMALL_FLEET: usize = 10_000;

/// Orders that concern hooks, and where their answers go.
type Orders = Vec<(Order, Actor, ReplyTo<Id>)>;

type Findings = Vec<(Found, ReplyTo<()>)>;

/// What is done once all that was queued with it is stored.
#[derive(Default)]
struct AfterCommit {
    orders: Orders,
    findings: Findings,
    digests: Vec<ReplyTo<()>>,
    shared: Vec<ReplyTo<()>>,
}

impl Task {
    pub fn new(
        store: Store,
        writer: Writer,
        config: Arc<Config>,
        clock: Clock,
        after: WriteNotifier,
        role: WriterRole,
    ) -> Self {
        let mut judging = config.judging.clone();
        if writer.is_one_of_many() {
            judging.remembered_records /= config.database.writers;
        }
        let judge = Judge::new(store.clone(), judging, config.alerts.policy());
        let alerts = AlertCache::new(config.alerts.policy(), config.judging.confidence);
        let state = WriterState {
            store,
            writer,
            clock,
            config,
            memory: RecentRecords::default(),
            judge,
            alerts,
            benched: HashMap::new(),
            seen_at: HashSet::new(),
            hooks: HookCache::default(),
            after,
            behind: false,
            nothing_shared: None,
        };
        Self { state, role, under_way: None, looks: JoinSet::new(), items_at_once: 1024 }
    }

    /// Works until every sender is gone and the queue is empty; gives back what it has written with.
    pub async fn run(mut self, mut queue: mpsc::Receiver<Job>) -> Writer {
        let max_group = self.state.config.database.max_group;
        let mut jobs = Vec::with_capacity(max_group);
        let mut ticks = self.ticks();
        let is_for_orders = self.role == WriterRole::Orders;
        let mut change_feed = if is_for_orders { self.state.store.change_feed() } else { None };
        loop {
            let room = max_group.saturating_sub(jobs.len()).max(1);
            tokio::select! {
                received = queue.recv_many(&mut jobs, room) => if received == 0 {
                    self.finish().await;
                    if jobs.is_empty() {
                        break;
                    }
                },
                () = overlapped::written(&mut self.under_way), if self.under_way.is_some() => self.finish().await,
                _ = ticks.tick(), if is_for_orders && self.looks.is_empty() => {
                    if self.state.store.holds_lease(LeasedTask::Clock) {
                        let now = self.state.clock.now();
                        self.looks.spawn(self.state.shared_look(now).nothing());
                    }
                }
                Some(looked) = self.looks.join_next() => {
                    self.finish().await;
                    let nothing = looked.unwrap_or_else(|error| std::panic::resume_unwind(error.into_panic()));
                    clock::tick(&mut self.state, nothing).await;
                }
                Some(remote_changes) = turn::next_of(&mut change_feed) => self.state.apply_remote_changes(&remote_changes).await,
            }
            if self.is_to_wait(&jobs) {
                continue;
            }
            self.drain(&mut jobs).await;
        }
        self.looks.shutdown().await;
        self.state.writer
    }

    async fn drain(&mut self, jobs: &mut Vec<Job>) {
        // Orders are for what is stored, and are carried out when nothing is under way.
        let mixed = jobs.iter().any(|job| !matches!(job, Job::Store(_)));
        if mixed {
            self.finish().await;
        }
        let (mut group, mut items) = (Vec::new(), 0);
        let most = if self.state.writer.committer().is_some() { overlapped::MAX_ITEMS } else { self.items_at_once };
        let mut later = AfterCommit::default();
        for job in jobs.drain(..) {
            let Some(job) = self.handle(job, &mut later).await else { continue };
            if items + job.items.len() > most && items > 0 {
                self.process(std::mem::take(&mut group)).await;
                if mixed {
                    self.finish().await;
                }
                items = 0;
            }
            items += job.items.len();
            group.push(job);
        }
        if !group.is_empty() {
            self.process(group).await;
        }
        if mixed {
            self.finish().await;
        }
        // After what was queued before.
        if !later.shared.is_empty() {
            clock::look_at_shared(&mut self.state).await;
            later.shared.into_iter().for_each(|reply| drop(reply.send(Ok(()))));
        }
        for reply in later.digests {
            let _gone = reply.send(in_turn!(self.state, all_cells(), self.state.notify_digest()));
        }
        self.carry_out(later.orders, later.findings).await;
    }

    /// Carries out an order, or puts it off; what is to be stored is handed back, to be stored in a group.
    async fn handle(&mut self, job: Job, later: &mut AfterCommit) -> Option<StoreJob> {
        match job {
            Job::Store(job) => return Some(job),
            Job::Hook { order, by, reply } => later.orders.push((order, by, reply)),
            Job::Found { found, reply } => later.findings.push((found, reply)),
            Job::Digest(reply) => later.digests.push(reply),
            Job::Shared(reply) => later.shared.push(reply),
            Job::Model { adoption, by, reply } => {
                // Its gyros may have come from anywhere.
                let _gone =
                    reply.send(in_turn!(self.state, all_cells(), restate::adopt(&mut self.state, &adoption, &by)));
                self.state.after.due.send_modify(|moved| *moved += 1);
            }
            Job::Restate { stale, reply } => {
                let _gone = reply.send(in_turn!(self.state, all_cells(), restate::state_anew(&mut self.state, &stale)));
            }
            Job::Pack { texts, reply } => {
                let cells = self.state.homes().of_texts(&texts);
                let changes = Changes { packed: texts, ..Changes::default() };
                let commit = async |state: &mut WriterState| Ok::<_, Refused>(state.commit(&changes).await?);
                let _gone = reply.send(in_turn!(self.state, cells, commit(&mut self.state)));
            }
            Job::Hypothesis { order, by, reply } => {
                let _gone = reply.send(in_turn!(self.state, Cells::from([0]), self.order_hypothesis(&order, &by)));
            }
            Job::Diagnoses { order, by, reply } => {
                let _gone = reply.send(in_turn!(self.state, Cells::from([0]), self.order_diagnoses(&order, &by)));
            }
            Job::Diagnosed { made, reply } => {
                let _gone = reply.send(in_turn!(self.state, Cells::from([0]), forecasts::keep(&mut self.state, &made)));
            }
            Job::Alert { order, by, reply } => {
                let cells = self.state.homes().of_alert(order.alert).await;
                let _gone = reply.send(in_turn!(self.state, cells, self.state.apply_order(&order, &by)));
            }
            Job::Silence { order, by, reply } => {
                let _gone = reply.send(in_turn!(self.state, all_cells(), self.state.order_silence(&order, &by)));
            }
            Job::Access { order, by, reply } => {
                let _gone = reply.send(in_turn!(self.state, Cells::from([0]), self.register(&order, &by)));
            }
            Job::Probe(reply) => {
                let _gone = reply.send(self.state.writer.probe().await.map_err(Refused::from));
            }
        }
        None
    }

    fn ticks(&self) -> Interval {
        let period = Duration::from_secs_f64(self.state.config.alerts.tick_s);
        // Of a large fleet the first takes a second: who waits for the start does not wait for that.
        let mut ticks = interval_at(tokio::time::Instant::now() + period.min(AFTER_START), period);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        ticks
    }

    async fn process(&mut self, jobs: Vec<StoreJob>) {
        if let Some(jobs) = self.write_overlapped(jobs).await {
            self.store_all(jobs).await;
        }
    }

    /// What people order has one transaction each, what delivery queues have found out shares one.
    async fn carry_out(&mut self, orders: Orders, findings: Findings) {
        let changes_the_hook =
            |found: &Found| matches!(found, Found::Attempted(attempted) if attempted.changes_the_hook());
        let any_changes = findings.iter().any(|(found, _)| changes_the_hook(found));
        let changed = !orders.is_empty() || any_changes;
        for (order, by, reply) in orders {
            let _gone = reply.send(in_turn!(self.state, all_cells(), self.hook_handler().carry_out(&order, &by)));
        }
        if !findings.is_empty() {
            let found: Vec<&Found> = findings.iter().map(|(found, _)| found).collect();
            let cells = if any_changes { Ok(all_cells()) } else { self.state.homes().of_findings(&found).await };
            let written = match cells {
                Ok(cells) => in_turn!(self.state, cells, self.hook_handler().write_down(found.iter().copied())),
                Err(error) => Err(error.into()),
            };
            for (_, reply) in findings {
                let _gone = reply.send(written.clone());
            }
        }
        if changed {
            self.state.look_at_hooks();
        }
    }

    fn hook_handler(&mut self) -> HookHandler<'_> {
        let WriterState { store, writer, clock, config, .. } = &mut self.state;
        let now = clock.now();
        HookHandler { store, writer, now, old_secret_until: config.hooks.old_secret_until(now), alerts: None }
    }

    /// Begins or cancels an order of diagnoses, and has what is new worked off.
    async fn order_diagnoses(&mut self, order: &DiagnosisOrder, by: &Actor) -> Result<Accepted, Refused> {
        let (now, program) = (self.state.clock.now(), self.state.after.models.competing().program.clone());
        let done = order_diagnoses(&self.state.store, &mut self.state.writer, now, program, order, by).await;
        self.state.after.due.send_modify(|moved| *moved += 1);
        done
    }

    async fn order_hypothesis(&mut self, order: &HypothesisOrder, by: &Actor) -> Result<Accepted, Refused> {
        let (store, now, cache) = (&self.state.store, self.state.clock.now(), &self.state.after.models);
        let done = order_hypothesis(store, &mut self.state.writer, now, cache, order, by).await;
        // One that was being made meanwhile is not kept, and is due again.
        self.state.after.due.send_modify(|moved| *moved += 1);
        done
    }

    /// Changes who may use the service.
    async fn register(&mut self, order: &AccessOrder, by: &Actor) -> Result<Option<Secret>, Refused> {
        let known = store::access::tokens(&self.state.store).await?;
        let (guard, writer, now) = (&self.state.after.guard, &mut self.state.writer, self.state.clock.now());
        order_access(guard, writer, now, order, by, &known).await
    }

    /// One transaction for all; where the database refuses it, one for each, so that only the culprit is refused.
    async fn store_all(&mut self, jobs: Vec<StoreJob>) {
        let items: Vec<Item<'_>> = jobs.iter().flat_map(items_of).collect();
        let mut replies = Vec::with_capacity(items.len());
        let begun = Instant::now();
        let stored = self.store_group(&items).await;
        let a_turn = items.len() as f64 * TURN.as_secs_f64() / begun.elapsed().as_secs_f64();
        self.items_at_once = (a_turn as usize).clamp(*ITEMS.start(), *ITEMS.end());
        match stored {
            Ok(stored) => replies = stored,
            Err(StoreError::Refused(why) | StoreError::Overtaken(why)) if items.len() > 1 => {
                tracing::warn!(%why, items = items.len(), "a group was refused; its items are stored one by one");
                for item in &items {
                    let reply = self.store_group(&[*item]).await;
                    replies.extend(reply.unwrap_or_else(|error| vec![Err(error.into())]));
                }
            }
            Err(error) => {
                tracing::error!(%error, items = items.len(), "a group could not be stored");
                replies.resize(items.len(), Err(error.into()));
            }
        }
        let is_corrected =
            |(item, reply): (&Item<'_>, &Reply)| reply.is_ok() && matches!(item.sent, Submission::Correction(_));
        if items.iter().zip(&replies).any(is_corrected) {
            self.look_at_imus().await;
        }
        answer(jobs, replies);
    }

    /// What an IMU's gyros shared by a record that counts no more is over with it; in a large fleet with the next tick,
    /// because it takes a look at all of them.
    async fn look_at_imus(&mut self) {
        let is_small = self.state.store.names().read().gyros.len() <= SMALL_FLEET;
        if is_small && self.state.alerts.shared().firing().any(|row| row.rule == Rule::ImuShift) {
            clock::look_at_shared(&mut self.state).await;
        }
    }

    async fn store_group(&mut self, items: &[Item<'_>]) -> Result<Vec<Reply>, StoreError> {
        let mut tries = 0;
        loop {
            let stored = match self.state.begin_group(items).await {
                Ok(()) => self.try_group(items).await,
                Err(error) => Err(error),
            };
            self.state.writer.give_back().await;
            match stored {
                Ok(replies) => {
                    self.state.tidy();
                    return Ok(replies);
                }
                Err(error) => {
                    self.state.start_over();
                    if !turn::another_try(&error, &mut tries).await {
                        return Err(error);
                    }
                }
            }
        }
    }

    async fn try_group(&mut self, items: &[Item<'_>]) -> Result<Vec<Reply>, StoreError> {
        // The model in force cannot change from here to the commit: an adoption needs this turn.
        let reader = self.state.reader();
        let mut anew = Vec::with_capacity(items.len());
        for item in items {
            anew.push(reader.read_anew(item.sent).await?);
        }
        let mut items: Vec<Item<'_>> = items.to_vec();
        for (item, anew) in items.iter_mut().zip(&anew) {
            item.sent = anew.as_ref().unwrap_or(item.sent);
        }
        let prepared = prepare(&mut self.state, &items).await?;
        let changes = &prepared.changes;
        if !changes.is_empty() {
            let committing = Instant::now();
            self.state.commit(changes).await?;
            metrics::histogram!(telemetry::COMMIT).record(committing.elapsed());
            self.state.benched.extend(changes.benches.iter().map(|bench| (bench.gyro, true)));
        }
        Ok(settle(&items, prepared, &self.state.after.due))
    }
}
