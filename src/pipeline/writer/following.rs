//! The writer's part in alerts: they follow what a group's judging finds, the clock, and what people say.

use std::collections::{BTreeSet, HashMap};
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior, interval};

use super::Task;
use crate::core::judge::Rule;
use crate::core::time::UtcMicros;
use crate::pipeline::agreement::{Agreement, agreement_after};
use crate::pipeline::alerting::{AlertOrder, Naming, Pen, follow_clock, follow_group};
use crate::pipeline::judging::Judged;
use crate::pipeline::read::Calibration;
use crate::pipeline::{Actor, Refused};
use crate::store::{Changes, Duty, Id, NewDelivery, StoreError, Subject};
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
        found: &Judged,
        agreements: &[Agreement],
        now: UtcMicros,
    ) -> Result<(), StoreError> {
        {
            let naming = Naming { tables: &self.store.names().read(), new: Some(changes) };
            let mut pen = Pen { now, writer: &mut self.writer, naming };
            follow_group(&mut self.alerts, &self.judge, found, sent, agreements, &mut pen);
        }
        self.note(changes, now)
    }

    /// Enters what has become of alerts into a transaction, with a delivery for each hook that is to be told.
    fn note(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        self.alerts.write(changes);
        for step in changes.alert_steps.iter().filter(|step| step.told) {
            let body: AlertBody = serde_json::from_str(&step.body)
                .map_err(|error| StoreError::Damaged(format!("a step of alert {}: {error}", step.alert)))?;
            let subject = Subject::Step { step: step.id, alert: step.alert };
            for hook in self.hooks.wanting(&body) {
                let id = self.writer.next_id(now);
                changes.outbox.queued.push(NewDelivery { id, hook, subject, queued_at: now });
            }
        }
        Ok(())
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
        if !self.store.is_on_duty(Duty::Clock) {
            return;
        }
        let followed = match self.begin().await {
            Ok(()) => self.try_tick().await,
            Err(error) => Err(error),
        };
        self.writer.give_back().await;
        if let Err(error) = followed {
            self.alerts.forget();
            tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
        }
    }

    async fn try_tick(&mut self) -> Result<(), StoreError> {
        self.alerts.refresh(&self.store).await?;
        let (now, mut changes) = (self.clock.now(), Changes::default());
        let out_of_use = if self.judge.has_intervals() { self.store.out_of_use().await? } else { HashMap::new() };
        {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming };
            if self.judge.has_intervals() {
                for (gyro, last, imu) in self.newest.gyros() {
                    if out_of_use.get(&gyro).is_some_and(|at| *at >= last) {
                        self.alerts.reset(gyro, |row| row.rule == Rule::Overdue, &mut pen);
                        continue;
                    }
                    follow_clock(&mut self.alerts, &self.judge, gyro, last, imu, &mut pen);
                }
            }
            self.alerts.tick(&mut pen);
        }
        self.note(&mut changes, now)?;
        if changes.is_empty() { Ok(()) } else { self.commit(&changes).await }
    }

    /// Does what somebody has said of an alert.
    pub(super) async fn obey(&mut self, order: &AlertOrder, by: &Actor) -> Result<AlertBody, Refused> {
        self.alerts.refresh(&self.store).await?;
        let now = self.clock.now();
        let (before, body) = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let before = self.alerts.alert(order.alert).map(|row| naming.alert(row, now)).transpose()?;
            let mut pen = Pen { now, writer: &mut self.writer, naming };
            let row = self.alerts.obey(order, &mut pen)?;
            (before, naming.alert(&row, now)?)
        };
        let mut changes = Changes::default();
        let (line, action) = (self.writer.next_id(now), order.change.name());
        let audit = by.line(line, now, (action, format!("alerts/{}", order.alert)), before.as_ref(), Some(&body));
        changes.access.audit.push(audit);
        let noted = self.note(&mut changes, now);
        let written = if noted.is_ok() { self.commit(&changes).await } else { noted };
        if written.is_err() {
            self.alerts.forget();
        }
        written?;
        Ok(body)
    }
}
