//! The writer's part in alerts: they follow what a group's judging finds, the clock, and what people say.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::time::Duration;

use tokio::time::{Interval, MissedTickBehavior, interval};

use super::state::Task;
use crate::core::alert_decision::{Late, Status};
use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::judge::Rule;
use crate::core::time::{Span, UtcMicros};
use crate::pipeline::access::Actor;
use crate::pipeline::alerts::{
    AlertError, AlertOrder, Causes, Naming, Pen, SilenceOrder, StationVerdict, follow_clock, follow_group,
};
use crate::pipeline::error::WriteError;
use crate::pipeline::hooks::{OutboxContext, Standing};
use crate::pipeline::ingest::judge::Judged;
use crate::pipeline::ingest::submission::Calibration;
use crate::pipeline::queries::agreement::{Agreement, agreement_after};
use crate::store;
use crate::store::{AlertOf, AlertRow, Cells, Changes, Duty, StoreError};
use crate::wire::alert::AlertBody;

/// Gyros that the clock may have something to do with, in one place.
#[derive(Debug, Default)]
struct OfClock {
    /// With alerts of which it changes something.
    alerted: BTreeSet<AlertOf>,
    /// Those that may begin or end to be overdue.
    overdue: BTreeSet<u32>,
}

impl Task {
    /// How the methods agree on the gyros of a group that benches have measured.
    pub(super) async fn agreements(&mut self, changes: &Changes) -> Result<Vec<Agreement>, StoreError> {
        let withdrawn = changes.withdrawn.benches.iter().map(|(_, gyro)| *gyro);
        let measured: BTreeSet<u32> = changes.benches.iter().map(|bench| bench.gyro).chain(withdrawn).collect();
        let touched = changes.history.iter().map(|row| row.gyro).chain(changes.events.iter().map(|event| event.gyro));
        let touched = touched.chain(changes.withdrawn.gyros()).chain(changes.rejudged.gyros_restated());
        let touched: BTreeSet<u32> = touched.collect();
        let unknown: Vec<u32> = touched.iter().copied().filter(|gyro| !self.benched.contains_key(gyro)).collect();
        if !unknown.is_empty() {
            let on_benches: HashSet<u32> = store::bench::on_benches(&self.store, &unknown).await?.into_iter().collect();
            self.benched.extend(unknown.into_iter().map(|gyro| (gyro, on_benches.contains(&gyro))));
        }
        let known = touched.into_iter().filter(|gyro| self.benched[gyro]);
        let mut agreements = Vec::new();
        for gyro in known.chain(measured).collect::<BTreeSet<_>>() {
            agreements.extend(agreement_after(&self.store, &self.config.judging, gyro, changes).await?);
        }
        Ok(agreements)
    }

    /// Lets the alerts follow the verdicts; what becomes of them goes into the same transaction.
    pub(super) async fn follow(
        &mut self,
        sent: &HashMap<Id, &Calibration>,
        changes: &mut Changes,
        (found, agreements): (&Judged, &[Agreement]),
        causes: &Causes,
        now: UtcMicros,
    ) -> Result<(), StoreError> {
        let shifts = self.shifts_of_group(found, changes, now).await?;
        {
            let naming = Naming { tables: &self.store.names().read(), new: Some(changes) };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: causes.late() };
            for StationVerdict { station, verdict, origin } in &shifts {
                self.alerts.follow(AlertOf::Station(*station), verdict, origin, &mut pen);
            }
            follow_group(&mut self.alerts, &self.judge, found, sent, agreements, causes, &mut pen);
        }
        self.note(changes, now).await
    }

    /// Enters what has become of alerts into a transaction, with a delivery for each hook that is to be told.
    pub(super) async fn note(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        let news = self.alerts.write(changes);
        if news.is_empty() {
            return Ok(());
        }
        self.hooks.recall(&self.store, &news).await?;
        self.hooks.tell(&news, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    /// Every alert as it stands.
    pub(super) async fn standings(&self, now: UtcMicros) -> Result<Vec<Standing>, StoreError> {
        let rows = store::alerts::all(&self.store).await?;
        let naming = Naming { tables: &self.store.names().read(), new: None };
        // One that cannot be read is told to nobody; the next look at it names the damage.
        let standing =
            |row: &AlertRow| Some(Standing { id: row.id, alert: row.alert, body: naming.alert(row, now).ok()? });
        Ok(rows.iter().filter_map(standing).collect())
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
        let followed = self.try_tick().await;
        self.writer.give_back().await;
        if let Err(error) = followed {
            self.start_over();
            tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
        }
    }

    /// A transaction for each cell in which the clock changes something; in a file, one.
    async fn try_tick(&mut self) -> Result<(), StoreError> {
        let now = self.clock.now();
        let mut rows = store::alerts::of_clock(&self.store).await?;
        if self.follow_stations(&rows, now).await? {
            rows = store::alerts::of_clock(&self.store).await?;
        }
        let mut by_cell: BTreeMap<u8, OfClock> = BTreeMap::new();
        let overdue = self.may_be_overdue(&rows, now).await?;
        let alerted: BTreeSet<AlertOf> =
            rows.iter().filter(|row| self.alerts.is_moved_by_clock(row, now)).map(|row| row.of).collect();
        store::names::look_up_gyros(&self.store, overdue.iter().copied().chain(gyros_of(&alerted)).collect()).await?;
        {
            let tables = self.store.names().read();
            let home = |gyro: &u32| tables.gyros.cell(*gyro).unwrap_or_default();
            overdue.iter().for_each(|gyro| _ = by_cell.entry(home(gyro)).or_default().overdue.insert(*gyro));
            let home_of = |of: &AlertOf| of.gyro().map_or(0, |gyro| home(&gyro));
            alerted.iter().for_each(|of| _ = by_cell.entry(home_of(of)).or_default().alerted.insert(*of));
        }
        for (cell, found) in by_cell {
            self.begin(&Cells::one(cell)).await?;
            self.tick_in_turn(&found, now).await?;
            self.writer.give_back().await;
        }
        let digest =
            rows.iter().filter_map(|row| row.alert.hushed.filter(|hushed| hushed.digest)).map(|it| it.at).max();
        if digest.is_some_and(|since| is_over(since, now)) {
            self.begin(&Cells::all()).await?;
            let mut changes = Changes::default();
            self.digest(&mut changes, now).await?;
            self.enter_heads(&mut changes).await?;
            if !changes.is_empty() {
                self.commit(&changes).await?;
            }
        }
        Ok(())
    }

    /// Gyros of which the clock may begin or end that they are overdue.
    async fn may_be_overdue(&self, rows: &[AlertRow], now: UtcMicros) -> Result<BTreeSet<u32>, StoreError> {
        if !self.judge.has_intervals() {
            return Ok(BTreeSet::new());
        }
        let is_firing = |row: &&AlertRow| row.rule == Rule::Overdue && row.alert.status == Status::Firing;
        let firing: BTreeSet<u32> = rows.iter().filter(is_firing).filter_map(|row| row.of.gyro()).collect();
        let overdue: BTreeSet<u32> = store::head::overdue(&self.store, now).await?.into_iter().collect();
        Ok(&firing ^ &overdue)
    }

    async fn tick_in_turn(&mut self, found: &OfClock, now: UtcMicros) -> Result<(), StoreError> {
        let mut changes = Changes::default();
        self.alerts.recall(&self.store, gyros_of(&found.alerted).chain(found.overdue.iter().copied()), now).await?;
        let gyros: Vec<u32> = found.overdue.iter().copied().collect();
        let out_of_use = self.out_of_use(&gyros).await?;
        let ever: Vec<_> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        let newest = store::histories::newest(&self.store, &ever, 1).await?;
        {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            for (gyro, newest) in gyros.into_iter().zip(newest) {
                let in_use = |newest: &&Figures| out_of_use.get(&gyro).is_none_or(|(at, _)| *at < newest.at);
                match newest.last().filter(in_use) {
                    Some(newest) => {
                        follow_clock(&mut self.alerts, &self.judge, gyro, newest.at, newest.imu, &mut pen);
                    }
                    None => self.alerts.reset(gyro, |row| row.rule == Rule::Overdue, &mut pen),
                }
            }
            self.alerts.tick(&found.alerted, &mut pen);
        }
        self.note(&mut changes, now).await?;
        self.enter_heads(&mut changes).await?;
        if changes.is_empty() { Ok(()) } else { self.commit(&changes).await }
    }

    /// An import has come to its end: what waits for its digest is told.
    pub(super) async fn tell_digest(&mut self) -> Result<(), WriteError> {
        let (now, mut changes) = (self.clock.now(), Changes::default());
        let told = self.digest(&mut changes, now).await;
        self.commit_or_forget(told, &mut changes).await
    }

    async fn digest(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        let waiting = store::alerts::of_clock(&self.store).await?;
        let waiting = waiting.iter().filter(|row| row.alert.hushed.is_some_and(|hushed| hushed.digest));
        let waiting: BTreeSet<AlertOf> = waiting.map(|row| row.of).collect();
        self.alerts.recall(&self.store, gyros_of(&waiting), now).await?;
        let any = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            self.alerts.tell_digest(&waiting, &mut pen)
        };
        if !any {
            return Ok(());
        }
        let news = self.alerts.write(changes);
        self.hooks.recall(&self.store, &news).await?;
        self.hooks.tell_digest(&news, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    pub(super) async fn commit_or_forget(
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
        let all = store::alerts::all(&self.store).await?.into_iter().filter_map(|row| row.of.gyro());
        self.alerts.recall(&self.store, all, now).await?;
        let known = match order {
            SilenceOrder::Begin { .. } => None,
            SilenceOrder::End { silence, .. } => store::silence::get(&self.store, *silence).await?,
        };
        let (id, mut changes) = {
            let naming = Naming { tables: &self.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.writer, naming, cause: None, late: Late::Clock };
            self.alerts.order_silence(order, known, by, &mut pen)?
        };
        let noted = self.note(&mut changes, now).await;
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(id)
    }

    /// The cells of an alert, which may not exist.
    pub(super) async fn cells_of_alert(&self, alert: Id) -> Cells {
        let row = store::alerts::get(&self.store, alert).await.ok().flatten();
        self.cells_of_alerts(row.and_then(|row| row.of.gyro()).into_iter().collect()).await.unwrap_or(Cells::one(0))
    }

    /// Does what somebody has said of an alert.
    pub(super) async fn obey(&mut self, order: &AlertOrder, by: &Actor) -> Result<AlertBody, AlertError> {
        let now = self.clock.now();
        let gyro = store::alerts::get(&self.store, order.alert).await?.and_then(|row| row.of.gyro());
        self.alerts.recall(&self.store, gyro, now).await?;
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
        let noted = self.note(&mut changes, now).await;
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(body)
    }
}

fn gyros_of(alerts: &BTreeSet<AlertOf>) -> impl Iterator<Item = u32> {
    alerts.iter().filter_map(|of| of.gyro())
}

/// An import of which nothing has come for so long was broken off: what it has found is told.
const BROKEN_OFF: f64 = 15.0 / (24.0 * 60.0);

fn is_over(since: UtcMicros, now: UtcMicros) -> bool {
    now.days_since(since).abs() > BROKEN_OFF
}
