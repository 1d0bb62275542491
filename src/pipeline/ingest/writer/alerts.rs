//! The writer's part in alerts: they follow what a group's judging finds, and what people say.

use super::heads::{self, touched};
use super::shared_shifts::{SharedLook, SharedShifts};
use super::state::WriterState;
use crate::pipeline::alerts::{AlertCache, AlertContext, Causes, NameLookup, follow_clock, follow_group};
use crate::pipeline::hooks::OutboxContext;
use crate::pipeline::ingest::judge::Judged;
use crate::pipeline::prelude::*;
use crate::pipeline::queries::agreement::{Agreement, agreement_after};
use crate::pipeline::{AlertOrder, Calibration, SilenceOrder};
use crate::store::AlertOf;
use crate::wire::alert::AlertBody;

/// Stations with gyros that are remembered.
const MOST_SEEN: usize = 1_000_000;

impl WriterState {
    /// How the methods agree on the gyros of a group that benches have measured.
    pub(super) async fn agreements(&mut self, changes: &Changes) -> Result<Vec<Agreement>, StoreError> {
        let withdrawn = changes.withdrawn.benches.iter().map(|(_, gyro)| *gyro);
        let measured: BTreeSet<u32> = changes.benches.iter().map(|bench| bench.gyro).chain(withdrawn).collect();
        let touched = changes.history.iter().map(|row| row.gyro).chain(changes.events.iter().map(|event| event.gyro));
        let touched = touched.chain(changes.withdrawn.gyros()).chain(changes.rejudged.gyros_restated());
        let touched: Vec<u32> = touched.collect::<BTreeSet<u32>>().into_iter().collect();
        self.learn_benched(&touched).await?;
        let known = touched.into_iter().filter(|gyro| self.benched[gyro]);
        let mut agreements = Vec::new();
        for gyro in known.chain(measured).collect::<BTreeSet<_>>() {
            agreements.extend(agreement_after(&self.store, &self.config.judging, gyro, changes).await?);
        }
        Ok(agreements)
    }

    /// Asks which of these gyros benches have measured, where that is not known.
    pub(super) async fn learn_benched(&mut self, gyros: &[u32]) -> Result<(), StoreError> {
        let unknown: Vec<u32> = gyros.iter().copied().filter(|gyro| !self.benched.contains_key(gyro)).collect();
        if !unknown.is_empty() {
            let on_benches: HashSet<u32> = store::bench::on_benches(&self.store, &unknown).await?.into_iter().collect();
            self.benched.extend(unknown.into_iter().map(|gyro| (gyro, on_benches.contains(&gyro))));
        }
        Ok(())
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
        let shifts = if self.writer.is_one_of_many() {
            Vec::new()
        } else {
            self.shared_shifts(now).of_arrivals(found, changes).await?
        };
        self.alerts.learn_mates(&shifts);
        {
            let naming = NameLookup { tables: &self.store.names().read(), new: Some(changes) };
            let (writer, late) = (&mut self.writer, causes.late());
            let mut context = AlertContext { now, writer, naming, cause: None, late, in_order: None };
            shifts.iter().for_each(|one| self.alerts.follow_shared(one, &mut context));
            follow_group(&mut self.alerts, &self.judge, found, sent, agreements, causes, &mut context);
        }
        self.note(changes, now).await
    }

    /// Lets `work` change alerts, of what has names already.
    pub(super) fn change_alerts<T>(
        &mut self,
        now: UtcMicros,
        late: Late,
        work: impl FnOnce(&mut AlertCache, &mut AlertContext<'_>) -> T,
    ) -> T {
        let naming = NameLookup { tables: &self.store.names().read(), new: None };
        let writer = &mut self.writer;
        work(&mut self.alerts, &mut AlertContext { now, writer, naming, cause: None, late, in_order: None })
    }

    /// Enters what has become of alerts into a transaction, with a delivery for each hook that is to be told.
    pub(super) async fn note(&mut self, changes: &mut Changes, now: UtcMicros) -> Result<(), StoreError> {
        let updates = self.alerts.write(changes);
        if updates.is_empty() {
            return Ok(());
        }
        self.hooks.recall(&self.store, &updates).await?;
        self.hooks.notify(&updates, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    /// Enters into a transaction how the gyros will stand that it touches: the last thing before it is committed. The
    /// alerts are those in memory, which are as they will be stored.
    pub(super) async fn enter_heads(&mut self, changes: &mut Changes) -> Result<(), StoreError> {
        let gyros: Vec<u32> = touched(changes).into_iter().collect();
        if gyros.is_empty() {
            return Ok(());
        }
        self.alerts.recall(&self.store, gyros.iter().copied(), self.clock.now()).await?;
        changes.heads.rows = heads::rows(self, &gyros, changes).await?;
        self.enter_stations(changes);
        Ok(())
    }

    /// Enters which stations have calibrated gyros, where that may be new.
    fn enter_stations(&mut self, changes: &mut Changes) {
        if self.seen_at.len() > MOST_SEEN {
            self.seen_at.clear();
        }
        let pairs: BTreeSet<[u32; 2]> = changes.history.iter().map(|row| [row.figures.station, row.gyro]).collect();
        changes.heads.seen = pairs.into_iter().filter(|pair| self.seen_at.insert(*pair)).collect();
    }

    pub(super) fn shared_look(&self, now: UtcMicros) -> SharedLook {
        SharedLook { store: self.store.clone(), config: self.config.clone(), now, nothing: self.nothing_shared }
    }

    pub(super) fn shared_shifts(&self, now: UtcMicros) -> SharedShifts<'_> {
        let Self { store, config, alerts, .. } = self;
        SharedShifts { store, config, alerts, now }
    }

    /// Gyros of which the clock may begin or end that they are overdue.
    pub(super) async fn may_be_overdue(&self, now: UtcMicros) -> Result<BTreeSet<u32>, StoreError> {
        if !self.config.judging.has_intervals() {
            return Ok(BTreeSet::new());
        }
        Ok(store::head::newly_overdue_or_not(&self.store, now).await?.into_iter().collect())
    }

    /// Lets the alerts of these gyros, which are in memory, follow the clock.
    pub(super) async fn follow_overdue(&mut self, gyros: &[u32], late: Late, now: UtcMicros) -> Result<(), StoreError> {
        let out_of_use = heads::out_of_use(self, gyros).await?;
        let newest = store::histories::last(&self.store, gyros).await?;
        let naming = NameLookup { tables: &self.store.names().read(), new: None };
        let writer = &mut self.writer;
        let mut context = AlertContext { now, writer, naming, cause: None, late, in_order: None };
        for (gyro, newest) in newest {
            let in_use = |newest: &Figures| out_of_use.get(&gyro).is_none_or(|(at, _)| *at < newest.at);
            match newest.filter(in_use) {
                Some(Figures { at, imu, .. }) => {
                    follow_clock(&mut self.alerts, &self.judge, gyro, at, imu, &mut context);
                }
                None => self.alerts.reset(gyro, |row| row.rule == Rule::Overdue, &mut context),
            }
        }
        Ok(())
    }

    /// An import has come to its end: what waits for its digest is told, with what the clock finds of it.
    pub(super) async fn notify_digest(&mut self) -> Result<(), Refused> {
        let (now, mut changes) = (self.clock.now(), Changes::default());
        let told = match self.may_be_overdue(now).await {
            Ok(overdue) => self.digest(&mut changes, &overdue, now).await,
            Err(error) => Err(error),
        };
        self.commit_or_forget(told, &mut changes).await
    }

    /// `overdue`: gyros of which the clock has not told yet that they are.
    pub(super) async fn digest(
        &mut self,
        changes: &mut Changes,
        overdue: &BTreeSet<u32>,
        now: UtcMicros,
    ) -> Result<(), StoreError> {
        let waiting = store::alerts::for_digest(&self.store).await?.into_iter().map(|row| row.of);
        let waiting: BTreeSet<AlertOf> = waiting.chain(overdue.iter().map(|gyro| AlertOf::Gyro(*gyro))).collect();
        store::names::look_up_gyros(&self.store, overdue.iter().copied().collect()).await?;
        self.alerts.recall(&self.store, gyros_of(&waiting), now).await?;
        let fires = |gyro: u32| self.alerts.firing(gyro).any(|row| row.rule == Rule::Overdue);
        let newly: Vec<u32> = overdue.iter().copied().filter(|gyro| !fires(*gyro)).collect();
        self.follow_overdue(&newly, Late::Digest, now).await?;
        self.change_alerts(now, Late::Clock, |alerts, context| alerts.notify_digest(&waiting, context));
        let updates = self.alerts.write(changes);
        if updates.is_empty() {
            return Ok(());
        }
        self.hooks.recall(&self.store, &updates).await?;
        self.hooks
            .notify_digest(&updates, &mut OutboxContext { now, ids: self.writer.ids(), outbox: &mut changes.outbox })
    }

    /// What was `noted`, once it is on disk.
    pub(super) async fn commit_or_forget<T>(
        &mut self,
        noted: Result<T, StoreError>,
        changes: &mut Changes,
    ) -> Result<T, Refused> {
        let written = match noted {
            Ok(noted) => self.commit_with_heads(changes).await.map(|()| noted),
            Err(error) => Err(error),
        };
        if written.is_err() {
            self.alerts.forget();
            self.hooks.forget();
        }
        Ok(written?)
    }

    /// Enters how gyros will stand and commits, where there is anything to write.
    pub(super) async fn commit_with_heads(&mut self, changes: &mut Changes) -> Result<(), StoreError> {
        self.enter_heads(changes).await?;
        if changes.is_empty() { Ok(()) } else { self.commit(changes).await }
    }

    /// Begins or ends a silence of many alerts.
    pub(super) async fn order_silence(&mut self, order: &SilenceOrder, by: &Actor) -> Result<Id, Refused> {
        let now = self.clock.now();
        let all = store::alerts::all(&self.store).await?.into_iter().filter_map(|row| row.of.gyro());
        self.alerts.recall(&self.store, all, now).await?;
        let known = match order {
            SilenceOrder::Begin { .. } => None,
            SilenceOrder::End { silence, .. } => store::silence::get(&self.store, *silence).await?,
        };
        let ordered =
            self.change_alerts(now, Late::Clock, |alerts, context| alerts.order_silence(order, known, by, context));
        let (id, mut changes) = ordered?;
        let noted = self.note(&mut changes, now).await;
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(id)
    }

    /// Does what somebody has said of an alert.
    pub(super) async fn apply_order(&mut self, order: &AlertOrder, by: &Actor) -> Result<AlertBody, Refused> {
        let now = self.clock.now();
        let gyro = store::alerts::get(&self.store, order.alert).await?.and_then(|row| row.of.gyro());
        self.alerts.recall(&self.store, gyro, now).await?;
        let said = self.change_alerts(now, Late::Quiet, |alerts, context| {
            let before = alerts.alert(order.alert).map(|row| context.naming.alert(row, now)).transpose()?;
            let row = alerts.apply_order(order, context)?;
            Ok::<_, Refused>((before, context.naming.alert(&row, now)?))
        });
        let ((before, body), mut changes) = (said?, Changes::default());
        let (line, action) = (self.writer.next_id(now), order.change.name());
        let audit = by.line(line, now, (action, format!("alerts/{}", order.alert)), before.as_ref(), Some(&body));
        changes.access.audit.push(audit);
        let noted = self.note(&mut changes, now).await;
        self.commit_or_forget(noted, &mut changes).await?;
        Ok(body)
    }
}

pub(super) fn gyros_of(alerts: &BTreeSet<AlertOf>) -> impl Iterator<Item = u32> {
    alerts.iter().filter_map(|of| of.gyro())
}
