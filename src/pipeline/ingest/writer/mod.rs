//! The one writer: takes what has queued up as a group, stores it in one transaction, answers everyone.

pub(crate) mod alerts;
mod group;
mod heads;
pub(crate) mod overlapped;
pub(crate) mod postgres_turn;
mod state;

use std::collections::HashMap;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::mpsc;

use super::admit::{Memory, Newest};
use crate::config::Config;
use crate::core::id::Id;
use crate::pipeline::access::{AccessHandler, AccessOrder, Actor, Secret};
use crate::pipeline::alerts::AlertCache;
use crate::pipeline::diagnoses::models::adopt;
use crate::pipeline::diagnoses::{DiagnosisHandler, DiagnosisOrder};
use crate::pipeline::error::StorageError;
use crate::pipeline::hooks::{Found, HookCache, HookHandler, Order};
use crate::pipeline::ingest::judge::Judge;
use crate::pipeline::ingest::writer::postgres_turn::in_turn;
use crate::pipeline::write_queue;
use crate::pipeline::write_queue::Job;
use crate::pipeline::{Accepted, AccessError, DiagnosisError, HookError, Reply, WriteError};
use crate::store;
use crate::store::{Store, StoreError, Writer};
use crate::system::Clock;
use crate::telemetry;
use group::{Told, answer, foretell};
use state::{Item, StoreJob, items_of};

pub(crate) use heads::make_missing;
pub(crate) use state::{After, Task};

/// How long a transaction may take others' turn, as far as that can be foretold.
const TURN: Duration = Duration::from_millis(500);
/// Items of one transaction, as many as are stored in a [`TURN`].
const ITEMS: RangeInclusive<usize> = 64..=8192;

/// Orders that concern hooks, and where their answers go.
type Orders = Vec<(Order, Actor, write_queue::Reply<Id, HookError>)>;

type Findings = Vec<(Found, write_queue::Reply<(), WriteError>)>;

impl Task {
    pub async fn new(
        store: Store,
        writer: Writer,
        config: Arc<Config>,
        clock: Clock,
        after: After,
    ) -> Result<Self, StoreError> {
        let newest = Newest::load(&store).await?;
        let hooks = HookCache::load(&store).await?;
        let judge = Judge::new(store.clone(), config.judging.clone(), config.alerts.policy());
        let alerts = AlertCache::load(&store, config.alerts.policy(), clock.now()).await?;
        let benched = store::bench::gyros_on_benches(&store).await?.into_iter().collect();
        Ok(Self {
            store,
            writer,
            clock,
            config,
            newest,
            memory: Memory::default(),
            judge,
            alerts,
            benched,
            hooks,
            after,
            under_way: None,
            items_at_once: 1024,
            behind: false,
        })
    }

    /// Works until every sender is gone and the queue is empty, then closes the database.
    pub async fn run(mut self, mut queue: mpsc::Receiver<Job>) {
        let max_group = self.config.database.max_group;
        let mut jobs = Vec::with_capacity(max_group);
        let mut ticks = self.ticks();
        let mut moves = store::other_servers::moves(&self.store);
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
                _ = ticks.tick() => {
                    self.finish().await;
                    self.tick().await;
                }
                Some(missed) = postgres_turn::next_of(&mut moves) => self.hear_of(&missed).await,
            }
            if self.is_to_wait(&jobs) {
                continue;
            }
            // Orders are for what is stored, and are carried out when nothing is under way.
            let mixed = jobs.iter().any(|job| !matches!(job, Job::Store { .. }));
            if mixed {
                self.finish().await;
            }
            let (mut group, mut items) = (Vec::new(), 0);
            let most = if self.writer.committer().is_some() { overlapped::MAX_ITEMS } else { self.items_at_once };
            let (mut orders, mut findings, mut digests) = (Orders::new(), Findings::new(), Vec::new());
            for job in jobs.drain(..) {
                let job = match job {
                    Job::Store { items, by, with_verdicts, late, reply } => {
                        StoreJob { items, by, with_verdicts, late, teller: reply }
                    }
                    Job::Hook { order, by, reply } => {
                        orders.push((order, by, reply));
                        continue;
                    }
                    Job::Found { found, reply } => {
                        findings.push((found, reply));
                        continue;
                    }
                    Job::Model { adoption, by, reply } => {
                        let adopted = in_turn!(self, {
                            let (store, models) = (&self.store, &self.after.models);
                            adopt(store, &mut self.writer, &self.clock, models, &adoption, &by)
                        });
                        let _gone = reply.send(adopted);
                        self.after.due.send_modify(|moved| *moved += 1);
                        continue;
                    }
                    Job::Diagnoses { order, by, reply } => {
                        let done = in_turn!(self, self.order_diagnoses(&order, &by));
                        let _gone = reply.send(done);
                        continue;
                    }
                    Job::Diagnosed { made, reply } => {
                        let kept = in_turn!(self, made.keep(&mut self.writer, &self.after.models));
                        let _gone = reply.send(kept);
                        continue;
                    }
                    Job::Alert { order, by, reply } => {
                        let done = in_turn!(self, self.obey(&order, &by));
                        let _gone = reply.send(done);
                        continue;
                    }
                    Job::Silence { order, by, reply } => {
                        let done = in_turn!(self, self.order_silence(&order, &by));
                        let _gone = reply.send(done);
                        continue;
                    }
                    Job::Digest(reply) => {
                        digests.push(reply);
                        continue;
                    }
                    Job::Access { order, by, reply } => {
                        let done = in_turn!(self, self.register(&order, &by));
                        let _gone = reply.send(done);
                        continue;
                    }
                    Job::Probe(reply) => {
                        let _gone = reply.send(self.writer.probe().await.map_err(WriteError::from));
                        continue;
                    }
                };
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
            for reply in digests {
                let told = in_turn!(self, self.tell_digest());
                let _gone = reply.send(told);
            }
            self.carry_out(orders, findings).await;
        }
        self.store.close().await;
        if let Err(error) = self.writer.close().await {
            tracing::error!(%error, "the database could not be closed in order; its log is kept and read at the next start");
        }
    }

    async fn process(&mut self, jobs: Vec<StoreJob>) {
        if let Some(jobs) = self.write_beside(jobs).await {
            self.store_all(jobs).await;
        }
    }

    /// What people order has one transaction each, what delivery queues have found out shares one.
    async fn carry_out(&mut self, orders: Orders, findings: Findings) {
        let is_gone = |found: &Found| matches!(found, Found::Attempted(attempted) if attempted.gone.is_some());
        let changed = !orders.is_empty() || findings.iter().any(|(found, _)| is_gone(found));
        for (order, by, reply) in orders {
            let done = in_turn!(self, self.order_hook(&order, &by));
            let _gone = reply.send(done);
        }
        if !findings.is_empty() {
            let written = in_turn!(self, self.hook_handler(None).write_down(findings.iter().map(|(found, _)| found)));
            for (_, reply) in findings {
                let _gone = reply.send(written.clone());
            }
        }
        if changed {
            self.look_at_hooks().await;
        }
    }

    async fn order_hook(&mut self, order: &Order, by: &Actor) -> Result<Id, HookError> {
        let now = self.clock.now();
        self.alerts.refresh(&self.store, now).await?;
        self.hooks.refresh(&self.store).await?;
        self.hook_handler(Some(order)).carry_out(order, by).await
    }

    /// `order`: what it is about to carry out; none where no hook is to hear anything new.
    fn hook_handler(&mut self, order: Option<&Order>) -> HookHandler<'_> {
        let now = self.clock.now();
        let old_secret_until = self.config.hooks.old_secret_until(now);
        let (alerts, heard) = match order {
            Some(Order::Create(_)) => (self.standings(now), HashMap::new()),
            Some(Order::Change(hook, _)) => (self.standings(now), self.hooks.has_heard(*hook)),
            Some(Order::Delete(_) | Order::Test(_) | Order::Redeliver(_)) | None => Default::default(),
        };
        HookHandler { store: &self.store, writer: &mut self.writer, now, old_secret_until, alerts, heard }
    }

    /// Begins or cancels an order of diagnoses, and has what is new worked off.
    async fn order_diagnoses(&mut self, order: &DiagnosisOrder, by: &Actor) -> Result<Accepted, DiagnosisError> {
        let mut admission = DiagnosisHandler { store: &self.store, writer: &mut self.writer, now: self.clock.now() };
        let done = admission.carry_out(order, by).await;
        self.after.due.send_modify(|moved| *moved += 1);
        done
    }

    /// Changes who may use the service.
    async fn register(&mut self, order: &AccessOrder, by: &Actor) -> Result<Option<Secret>, AccessError> {
        let known = store::access::tokens(&self.store).await?;
        let (guard, writer, now) = (&self.after.guard, &mut self.writer, self.clock.now());
        AccessHandler { guard, writer, now }.carry_out(order, by, &known).await
    }

    /// Hooks have changed, or have something new to be told.
    async fn look_at_hooks(&mut self) {
        match HookCache::load(&self.store).await {
            Ok(hooks) => self.hooks = hooks,
            Err(error) => tracing::error!(%error, "the hooks cannot be read; those known before are told"),
        }
        self.after.wake.send_modify(|moved| *moved += 1);
    }

    /// One transaction for all; where the database refuses it, one for each, so that only the culprit is refused.
    async fn store_all(&mut self, jobs: Vec<StoreJob>) {
        let items: Vec<Item<'_>> = jobs.iter().flat_map(items_of).collect();
        let mut replies = Vec::with_capacity(items.len());
        let begun = Instant::now();
        let stored = self.store_group(&items, &jobs).await;
        let a_turn = items.len() as f64 * TURN.as_secs_f64() / begun.elapsed().as_secs_f64();
        self.items_at_once = (a_turn as usize).clamp(*ITEMS.start(), *ITEMS.end());
        match stored {
            Ok(stored) => return answer(jobs, stored, Told::Ahead),
            Err(StoreError::Refused(why)) if items.len() > 1 => {
                tracing::warn!(%why, items = items.len(), "a group was refused; its items are stored one by one");
                for item in &items {
                    let reply = self.store_group(&[*item], &[]).await;
                    replies.extend(reply.unwrap_or_else(|error| vec![Err(error.into())]));
                }
            }
            Err(error) => {
                tracing::error!(%error, items = items.len(), "a group could not be stored");
                let error = WriteError::from(StorageError::from(error));
                replies.resize(items.len(), Err(error.into()));
            }
        }
        answer(jobs, replies, Told::Now);
    }

    /// Stores `items`: those of `to_foretell`, who are told what will be answered, or any, while nobody is.
    async fn store_group(&mut self, items: &[Item<'_>], to_foretell: &[StoreJob]) -> Result<Vec<Reply>, StoreError> {
        let mut tries = 0;
        loop {
            let stored = match self.begin().await {
                Ok(()) => self.try_group(items, to_foretell).await,
                Err(error) => Err(error),
            };
            self.writer.give_back().await;
            match stored {
                Ok(replies) => {
                    self.judge.tidy();
                    if self.memory.is_full() {
                        self.memory.forget();
                    }
                    return Ok(replies);
                }
                Err(error) => {
                    self.start_over();
                    if !postgres_turn::another_try(&error, &mut tries).await {
                        return Err(error);
                    }
                }
            }
        }
    }

    async fn try_group(&mut self, items: &[Item<'_>], to_foretell: &[StoreJob]) -> Result<Vec<Reply>, StoreError> {
        let prepared = self.prepare(items).await?;
        foretell(to_foretell, &prepared.replies);
        let changes = &prepared.changes;
        if !changes.is_empty() {
            let committing = Instant::now();
            self.commit(changes).await?;
            metrics::histogram!(telemetry::COMMIT).record(committing.elapsed());
            self.newest.learn(changes, &prepared.newest);
            self.benched.extend(changes.benches.iter().map(|bench| bench.gyro));
        }
        Ok(self.settle(items, prepared))
    }
}
