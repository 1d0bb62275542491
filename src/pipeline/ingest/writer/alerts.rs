//! The writer's part in alerts: they follow what a group's judging finds, the clock, and what people say.

use std::collections::{BTreeSet, HashMap};
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior, interval};

use super::state::Task;
use crate::core::alert_decision::Late;
use crate::core::id::Id;
use crate::core::judge::Rule;
use crate::core::time::UtcMicros;
use crate::pipeline::access::Actor;
use crate::pipeline::alerts::{AlertError, AlertOrder, Causes, Naming, Pen, SilenceOrder, follow_clock, follow_group};
use crate::pipeline::error::WriteError;
use crate::pipeline::hooks::{OutboxContext, Standing};
use crate::pipeline::ingest::judge::Judged;
use crate::pipeline::ingest::submission::Calibration;
use crate::pipeline::queries::agreement::{Agreement, agreement_after};
use crate::store;
use crate::store::{AlertRow, Changes, Duty, StoreError};
use crate::wire::alert::AlertBody;

impl Task {
    /// How the methods agree on the gyros of a group that benches have measured.
    pub(super) async fn agreements(&self, changes: &Changes) -> Result<Vec<Agreement>, StoreError> {
        let withdrawn = changes.withdrawn.benches.iter().map(|(_, gyro)| *gyro);
        let measured: BTreeSet<u32> = changes.benches.iter().map(|bench| bench.gyro).chain(withdrawn).collect();
        let touched = changes.history.iter().map(|row| row.gyro).chain(changes.events.iter().map(|event| event.gyro));
        let known = touched.chain(changes.withdrawn.gyros()).filter(|gyro| self.benched.contains(gyro));
        let mut agreements = Vec::new();
        for gyro in known.chain(measured.iter().copied()).collect::<BTreeSet<_>>() {
            agreements.extend(agreement_after(&self.store, &self.config.judging, gyro, changes).await?);
        }
        Ok(agreements)
    }

    /// Lets the alerts follow the verdicts; what becomes of them goes into the same transaction.
    pub(super) fn follow(
        &mut self,
        sent: &HashMap<Id, &Calibration>,
        changes: &mut Changes,
        (found, agreements): (&Judged, &[Agreement]),
        causes: &Causes,
        now: UtcMicros,
    ) -> Result<(), StoreError> {
        {
            let naming = Naming { tables: &self.store.names().read(), new: Some(changes) };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Quiet };
            follow_group(&mut self.alerts, &self.judge, found, sent, agreements, causes, &mut pen);
        }
        self.note(changes, now)
    }

    /// Enters what has become of alerts into a transaction, with a delivery for each hook that is to be told.
    fn note(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        let news = self.alerts.write(changes);
        if news.is_empty() {
            return Ok(());
        }
        self.hooks.tell(&news, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    /// Every alert as it stands.
    pub(super) fn standings(&self, now: UtcMicros) -> Vec<Standing> {
        let naming = Naming { tables: &self.store.names().read(), new: None };
        // One that cannot be read is told to nobody; the next look at it names the damage.
        let standing =
            |row: &AlertRow| Some(Standing { id: row.id, alert: row.alert, body: naming.alert(row, now).ok()? });
        self.alerts.all().filter_map(standing).collect()
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

    pub(super) fn ticks(&self) -> Interval {
        let mut ticks = interval(Duration::from_secs_f64(self.config.alerts.tick_s));
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        ticks
    }

    /// Lets the alerts follow the clock.
    pub(super) async fn tick(&mut self) {
        if !store::other_servers::is_on_duty(&self.store, Duty::Clock) {
            return;
        }
        let followed = match self.begin().await {
            Ok(()) => self.try_tick().await,
            Err(error) => Err(error),
        };
        self.writer.give_back().await;
        if let Err(error) = followed {
            self.alerts.forget();
            self.hooks.forget();
            tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
        }
    }

    async fn try_tick(&mut self) -> Result<(), StoreError> {
        let (now, mut changes) = (self.clock.now(), Changes::default());
        let out_of_use =
            if self.judge.has_intervals() { store::event::out_of_use(&self.store).await? } else { HashMap::new() };
        self.alerts.refresh(&self.store, now).await?;
        self.hooks.refresh(&self.store).await?;
        {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            if self.judge.has_intervals() {
                for (gyro, last, imu) in self.newest.gyros() {
                    if out_of_use.get(&gyro).is_some_and(|(at, _)| *at >= last) {
                        self.alerts.reset(gyro, |row| row.rule == Rule::Overdue, &mut pen);
                        continue;
                    }
                    follow_clock(&mut self.alerts, &self.judge, gyro, last, imu, &mut pen);
                }
            }
            self.alerts.tick(&mut pen);
        }
        self.note(&mut changes, now)?;
        if self.alerts.digest_waits_since().is_some_and(|since| is_over(since, now)) {
            self.digest(&mut changes, now)?;
        }
        self.enter_heads(&mut changes).await?;
        if changes.is_empty() { Ok(()) } else { self.commit(&changes).await }
    }

    /// An import has come to its end: what waits for its digest is told.
    pub(super) async fn tell_digest(&mut self) -> Result<(), WriteError> {
        let (now, mut changes) = (self.clock.now(), Changes::default());
        self.alerts.refresh(&self.store, now).await?;
        self.hooks.refresh(&self.store).await?;
        let told = self.digest(&mut changes, now);
        self.commit_or_forget(told, &mut changes).await
    }

    fn digest(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        let any = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            self.alerts.tell_digest(&mut pen)
        };
        if !any {
            return Ok(());
        }
        let news = self.alerts.write(changes);
        self.hooks.tell_digest(&news, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    async fn commit_or_forget(
        &mut self,
        noted: Result<(), StoreError>,
        changes: &mut Changes,
    ) -> Result<(), WriteError> {
        let entered = match noted {
            Ok(()) => self.enter_heads(changes).await,
            Err(error) => Err(error),
        };
        let written = match entered {
            Ok(()) if changes.is_empty() => Ok(()),
            Ok(()) => self.commit(changes).await,
            Err(error) => Err(error),
        };
        if written.is_err() {
            self.alerts.forget();
            self.hooks.forget();
        }
        Ok(written?)
    }

    /// Begins or ends a silence of many alerts.
    pub(super) async fn order_silence(&mut self, order: &SilenceOrder, by: &Actor) -> Result<Id, AlertError> {
        let now = self.clock.now();
        self.alerts.refresh(&self.store, now).await?;
        self.hooks.refresh(&self.store).await?;
        let known = match order {
            SilenceOrder::Begin { .. } => None,
            SilenceOrder::End { silence, .. } => store::silence::get(&self.store, *silence).await?,
        };
        let (id, mut changes) = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            self.alerts.order_silence(order, known, by, &mut pen)?
        };
        let noted = self.note(&mut changes, now);
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(id)
    }

    /// Does what somebody has said of an alert.
    pub(super) async fn obey(&mut self, order: &AlertOrder, by: &Actor) -> Result<AlertBody, AlertError> {
        let now = self.clock.now();
        self.alerts.refresh(&self.store, now).await?;
        self.hooks.refresh(&self.store).await?;
        let (before, body) = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let before = self.alerts.alert(order.alert).map(|row| naming.alert(row, now)).transpose()?;
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Quiet };
            let row = self.alerts.obey(order, &mut pen)?;
            (before, naming.alert(&row, now)?)
        };
        let mut changes = Changes::default();
        let (line, action) = (self.writer.next_id(now), order.change.name());
        let audit = by.line(line, now, (action, format!("alerts/{}", order.alert)), before.as_ref(), Some(&body));
        changes.access.audit.push(audit);
        let noted = self.note(&mut changes, now);
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(body)
    }
}

/// An import of which nothing has come for so long was broken off: what it has found is told.
const BROKEN_OFF: f64 = 15.0 / (24.0 * 60.0);

fn is_over(since: UtcMicros, now: UtcMicros) -> bool {
    now.days_since(since).abs() > BROKEN_OFF
}
