//! The deliveries of one hook, a few at a time.

use std::collections::VecDeque;
use std::time::Instant;

use futures::StreamExt;
use futures::future::BoxFuture;
use futures::stream::FuturesUnordered;
use tokio::sync::watch;

use crate::alert::HookKind;
use crate::alert::deliver::{Attempt, DeliveryOutcome};
use crate::alert::retry_schedule::HORIZON;
use crate::core::delivery::DeliveryState;
use crate::pipeline::hooks::delivery::circuit::Circuit;
use crate::pipeline::hooks::delivery::message::{self, Addressee, DeliveryContext, OFF_DUTY};
use crate::pipeline::hooks::{Attempted, Found};
use crate::pipeline::prelude::*;
use crate::store::{DeadLetters, DueDelivery, LeasedTask, Progress};
use crate::telemetry;
use crate::wire::alert::AlertBody;

/// Deliveries that are fetched at a time.
const FETCH: u32 = 64;
/// When nothing tells a queue anything, it looks for itself.
const IDLE: Duration = Duration::from_secs(30);
/// After a failure to read or write the database.
const BREATH: Duration = Duration::from_secs(1);

/// What has happened to a delivery under way.
enum QueueEvent {
    Attempted(Arc<Addressee>, Box<DueDelivery>, Attempt),
    WrittenDown(Id),
    /// What waits has been made due.
    Hastened,
    /// The writer has gone. It is attempted no more, for nobody would ever know.
    Unwritten,
}

pub(super) struct DeliveryQueue {
    context: Arc<DeliveryContext>,
    hook: Id,
    stopping: watch::Receiver<bool>,
    wake: watch::Receiver<u64>,
    health: Circuit,
    /// The hook as it was when [`DeliveryQueue::health`] was last without blemish for its sake.
    changed_at: Option<UtcMicros>,
    /// Due and fetched, not yet begun.
    ready: VecDeque<DueDelivery>,
    under_way: FuturesUnordered<BoxFuture<'static, QueueEvent>>,
    /// The deliveries that are under way.
    held: HashSet<Id>,
    /// There may be more due than `ready` holds.
    look_again: bool,
    /// What was due then has been fetched, but for what it takes to [look again](DeliveryQueue::look_again) for.
    looked_at: UtcMicros,
    resend_at: Instant,
    /// What the target never took.
    dead: Arc<DeadLetters>,
}

impl DeliveryQueue {
    pub fn new(context: Arc<DeliveryContext>, hook: Id, stopping: watch::Receiver<bool>) -> Self {
        let wake = context.hooks.wake.subscribe();
        Self {
            context,
            hook,
            stopping,
            wake,
            health: Circuit::default(),
            changed_at: None,
            ready: VecDeque::new(),
            under_way: FuturesUnordered::new(),
            held: HashSet::new(),
            look_again: true,
            looked_at: UtcMicros(i64::MIN),
            resend_at: Instant::now(),
            dead: Arc::default(),
        }
    }

    /// Delivers until the hook is disabled or deleted, or the service stops; then finishes what is under way.
    pub async fn run(mut self) {
        while !*self.stopping.borrow() {
            match self.addressee().await {
                Ok(Some(to)) => {
                    if let Err(error) = self.serve(&to).await {
                        self.report_error(&error).await;
                    }
                }
                Ok(None) => break,
                Err(error) => self.report_error(&error).await,
            }
        }
        while let Some(event) = self.under_way.next().await {
            self.go_on(event);
        }
    }

    async fn report_error(&mut self, error: &StoreError) {
        tracing::warn!(%error, hook = %self.hook, "the outbox cannot be read; trying again");
        tokio::time::sleep(BREATH).await;
    }

    /// The hook as it is now; none where it is told no more.
    async fn addressee(&mut self) -> Result<Option<Arc<Addressee>>, StoreError> {
        self.wake.borrow_and_update();
        let Some(row) = store::hook::get(&self.context.hooks.store, self.hook).await?.filter(|row| row.enabled) else {
            return Ok(None);
        };
        // Whoever has changed the hook has mended something.
        if self.changed_at.replace(row.changed_at) != Some(row.changed_at) {
            self.health = Circuit::default();
        }
        let to = Addressee::of(row).map_err(|why| StoreError::damaged(format_args!("hook {}: {why}", self.hook)))?;
        Ok(Some(Arc::new(to)))
    }

    /// Delivers until something wakes it: the hook may have changed, or what waited have been thrown away.
    async fn serve(&mut self, to: &Arc<Addressee>) -> Result<(), StoreError> {
        self.ready.clear();
        self.look_again = true;
        loop {
            let pause = self.begin(to).await?;
            tokio::select! {
                Some(event) = self.under_way.next() => self.go_on(event),
                _ = self.wake.changed() => return Ok(()),
                _ = self.stopping.changed() => return Ok(()),
                () = tokio::time::sleep(pause) => self.look_again = true,
            }
        }
    }

    /// Begins all attempts that can begin. Returns after how long there may be more.
    async fn begin(&mut self, to: &Arc<Addressee>) -> Result<Duration, StoreError> {
        if !self.holds_lease() {
            // By then others may have delivered what was fetched.
            self.ready.clear();
            self.look_again = true;
            return Ok(OFF_DUTY);
        }
        if to.kind == HookKind::Alertmanager && Instant::now() >= self.resend_at {
            // Alone, or what fires might overtake that it is resolved.
            if !self.under_way.is_empty() {
                return Ok(IDLE);
            }
            self.resend(to).await?;
            if !self.holds_lease() {
                return Ok(OFF_DUTY);
            }
        }
        let at_once = self.health.at_once(self.context.hooks.config.hooks.attempts_at_once, Instant::now());
        while self.under_way.len() < at_once {
            if self.ready.is_empty() && self.look_again {
                self.fetch().await?;
            }
            let Some(due) = self.ready.pop_front() else { break };
            self.attempt(to, due);
        }
        let until_resend = match to.kind {
            HookKind::Alertmanager => self.resend_at.saturating_duration_since(Instant::now()),
            _ => IDLE,
        };
        Ok(self.until_more(at_once).await?.min(until_resend).min(IDLE))
    }

    fn holds_lease(&self) -> bool {
        self.context.hooks.store.holds_lease(LeasedTask::Deliveries)
    }

    async fn until_more(&mut self, at_once: usize) -> Result<Duration, StoreError> {
        if at_once == 0 {
            return Ok(self.health.resume_at().map_or(IDLE, |at| at.saturating_duration_since(Instant::now())));
        }
        if self.under_way.len() >= at_once {
            return Ok(IDLE);
        }
        let now = self.context.hooks.clock.now();
        // What has become due since it was last looked for is still to be fetched. The clock may have gone back.
        let next = store::delivery::next_due(&self.context.hooks.store, self.hook, self.looked_at.min(now)).await?;
        // A millisecond more, so that it is due indeed.
        let until =
            next.map(|at| Duration::from_micros((at.0 - now.0).max(0).unsigned_abs()) + Duration::from_millis(1));
        Ok(until.unwrap_or(IDLE))
    }

    async fn fetch(&mut self) -> Result<(), StoreError> {
        let now = self.context.hooks.clock.now();
        let horizon = UtcMicros(now.0.saturating_add(HORIZON.as_micros() as i64));
        let limit = FETCH + self.held.len() as u32;
        let store = &self.context.hooks.store;
        let due = store::delivery::due_of_hook(store, self.hook, now, horizon, limit).await?;
        self.dead = Arc::new(store::hook::dead_letters(store, self.hook).await?);
        self.look_again = due.len() == limit as usize;
        self.looked_at = now;
        self.ready.extend(due.into_iter().filter(|due| !self.held.contains(&due.id)));
        Ok(())
    }

    fn attempt(&mut self, to: &Arc<Addressee>, due: DueDelivery) {
        self.held.insert(due.id);
        let (context, to, dead) = (Arc::clone(&self.context), Arc::clone(to), Arc::clone(&self.dead));
        self.under_way.push(Box::pin(async move {
            let attempt = context.attempt(&to, &due, &dead.fires).await;
            QueueEvent::Attempted(to, Box::new(due), attempt)
        }));
    }

    fn go_on(&mut self, event: QueueEvent) {
        match event {
            QueueEvent::Attempted(to, due, attempt) => {
                // What an address does that the hook has no longer says nothing of the one that it has.
                let is_current = self.changed_at == Some(to.row.changed_at);
                let hasten =
                    is_current && self.health.note(&attempt, self.context.retry_schedule.first_wait(), Instant::now());
                let at = self.context.hooks.clock.now();
                let attempted = message::report(&to, &due, &attempt, at, &self.context.retry_schedule);
                // It takes messages, so that it can be told what it was not there for.
                let is_taken = attempt.outcome == DeliveryOutcome::Delivered;
                let renotify = is_taken && !(self.dead.fires.is_empty() && self.dead.ends.is_empty());
                let attempted = Attempted { hasten, renotify, ..attempted };
                count(to.kind, &attempted, &attempt);
                let context = Arc::clone(&self.context);
                self.under_way.push(Box::pin(async move {
                    let delivery = attempted.attempt.delivery;
                    let written = context.write_down(Found::Attempted(attempted)).await;
                    if written { QueueEvent::WrittenDown(delivery) } else { QueueEvent::Unwritten }
                }));
            }
            QueueEvent::WrittenDown(delivery) => {
                self.held.remove(&delivery);
                self.look_again = true;
            }
            QueueEvent::Hastened => self.look_again = true,
            QueueEvent::Unwritten => {}
        }
    }

    async fn resend(&mut self, to: &Addressee) -> Result<(), StoreError> {
        self.resend_at = Instant::now() + self.context.hooks.config.hooks.resend_every();
        let damaged = |error: serde_json::Error| StoreError::damaged(format_args!("a step of an alert: {error}"));
        let mut firing: Vec<(String, AlertBody)> = Vec::new();
        for (severity, body) in store::alerts::heard_firing(&self.context.hooks.store, self.hook).await? {
            firing.push((severity, serde_json::from_str(&body).map_err(damaged)?));
        }
        if firing.is_empty() {
            return Ok(());
        }
        let attempt = self.context.resend(to, &firing).await;
        if self.health.note(&attempt, self.context.retry_schedule.first_wait(), Instant::now()) {
            let (context, back) = (Arc::clone(&self.context), Found::Back(self.hook));
            self.under_way.push(Box::pin(async move {
                if context.write_down(back).await { QueueEvent::Hastened } else { QueueEvent::Unwritten }
            }));
        }
        if attempt.outcome != DeliveryOutcome::Delivered {
            tracing::warn!(hook = %self.hook, why = said(&attempt), "an Alertmanager could not be sent what fires");
        }
        Ok(())
    }
}

impl DeliveryContext {
    /// Sees to it that it is written down, however long the disk may be full: what was delivered and is not known to be
    /// would be sent again. False where the writer has gone.
    async fn write_down(&self, mut found: Found) -> bool {
        loop {
            match self.hooks.write_down(found.clone()).await {
                Ok(()) => return true,
                Err(Refused::Stopping) => return false,
                Err(error) => {
                    match &mut found {
                        Found::Attempted(attempted) => {
                            let delivery = attempted.attempt.delivery;
                            tracing::warn!(%error, %delivery, "an attempt cannot be written down; trying again");
                            attempted.perhaps_written |= matches!(error, Refused::Storage(StoreError::Unanswered(_)));
                        }
                        Found::Back(hook) => {
                            tracing::warn!(%error, %hook, "what waits cannot be hastened; trying again")
                        }
                    }
                    tokio::time::sleep(BREATH).await;
                }
            }
        }
    }
}

/// What went wrong, for the log.
fn said(attempt: &Attempt) -> String {
    attempt.detail.as_ref().map(ToString::to_string).unwrap_or_default()
}

fn count(kind: HookKind, attempted: &Attempted, attempt: &Attempt) {
    let outcome = match (attempted.progress, attempt.outcome) {
        (_, DeliveryOutcome::Gone) => "gone",
        (_, DeliveryOutcome::Needless) => "needless",
        (Progress::Done(DeliveryState::Dead), _) => "dead",
        (Progress::Done(_), _) => "delivered",
        (Progress::RetryAt(_), _) => "failed",
    };
    if matches!(outcome, "gone" | "dead") {
        let why = said(attempt);
        tracing::warn!(hook = %attempted.hook, delivery = %attempted.attempt.delivery, why, "a delivery was given up");
    }
    metrics::counter!(telemetry::ATTEMPTS, "kind" => kind.name(), "outcome" => outcome).increment(1);
    metrics::histogram!(telemetry::ATTEMPT_TIME, "kind" => kind.name()).record(attempt.took);
}
