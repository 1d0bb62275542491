//! Alerts follow the clock: what becomes overdue, is to be repeated or told of as one, and what gyros share.

use super::alerts::gyros_of;
use super::shared_look::{NothingShared, shared_and_explicable};
use super::state::WriterState;
use crate::core::alert_decision::Late;
use crate::pipeline::alerts::SharedVerdict;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, Cells};

/// Gyros, stations and IMUs that one transaction of the clock is about.
const AT_ONCE: usize = 1000;

/// One look at the clock.
pub(super) struct ClockTick<'a> {
    pub state: &'a mut WriterState,
    pub now: UtcMicros,
}

impl ClockTick<'_> {
    /// Lets the alerts follow the clock, and what a look has found that gyros share.
    pub async fn tick(&mut self, nothing: Result<Option<NothingShared>, StoreError>) {
        let followed = self.try_tick(nothing).await;
        self.end(followed).await;
    }

    /// Lets the alerts of what is shared follow what has been written, whichever server the clock is on.
    pub async fn look_at_shared(&mut self) {
        let nothing = self.state.shared_look(self.now).nothing().await;
        let followed = self.follow_shared(nothing).await;
        self.end(followed).await;
    }

    async fn end(&mut self, followed: Result<(), StoreError>) {
        self.state.writer.give_back().await;
        if let Err(error) = followed {
            self.state.start_over();
            tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
        }
    }

    /// Transactions of each cell in which the clock changes something; in a file all is one cell.
    async fn try_tick(&mut self, nothing: Result<Option<NothingShared>, StoreError>) -> Result<(), StoreError> {
        let now = self.now;
        self.follow_shared(nothing).await?;
        let overdue = self.state.may_be_overdue(now).await?;
        let repeated = now.plus_days(-self.state.config.alerts.repeat_days);
        let due = store::alerts::due(&self.state.store, now, repeated).await?;
        let moved = due.iter().filter(|row| self.state.alerts.is_moved_by_clock(row, now)).map(|row| row.of);
        let found: BTreeSet<AlertOf> = moved.chain(overdue.iter().map(|gyro| AlertOf::Gyro(*gyro))).collect();
        store::names::look_up_gyros(&self.state.store, gyros_of(&found).collect()).await?;
        let found = {
            let tables = self.state.store.names().read();
            let cell = |of: &AlertOf| of.gyro().and_then(|gyro| tables.gyros.cell(gyro)).unwrap_or_default();
            let mut found: Vec<(u8, AlertOf)> = found.iter().map(|of| (cell(of), *of)).collect();
            found.sort_unstable();
            found
        };
        for some in found.chunk_by(|(a, _), (b, _)| a == b).flat_map(|of_cell| of_cell.chunks(AT_ONCE)) {
            self.state.begin(&Cells::one(some[0].0)).await?;
            self.tick_in_turn(&some.iter().map(|(_, of)| *of).collect(), &overdue).await?;
            self.state.writer.give_back().await;
            self.state.tidy();
        }
        if store::alerts::digest_began(&self.state.store)
            .await?
            .is_some_and(|since| now.days_since(since).abs() > BROKEN_OFF)
        {
            self.state.begin(&Cells::all()).await?;
            let mut changes = Changes::default();
            self.state.digest(&mut changes, &BTreeSet::new(), now).await?;
            self.state.commit_with_heads(&mut changes).await?;
        }
        Ok(())
    }

    async fn tick_in_turn(&mut self, found: &BTreeSet<AlertOf>, overdue: &BTreeSet<u32>) -> Result<(), StoreError> {
        let now = self.now;
        let mut changes = Changes::default();
        self.state.alerts.recall(&self.state.store, gyros_of(found), now).await?;
        let gyros: Vec<u32> = gyros_of(found).filter(|gyro| overdue.contains(gyro)).collect();
        self.state.follow_overdue(&gyros, Late::Clock, now).await?;
        self.state.change_alerts(now, Late::Clock, |alerts, context| alerts.tick(found, context));
        self.state.note(&mut changes, now).await?;
        self.state.commit_with_heads(&mut changes).await
    }

    /// Lets the alerts of what is shared follow the clock, and those of gyros that they explain.
    async fn follow_shared(&mut self, nothing: Result<Option<NothingShared>, StoreError>) -> Result<(), StoreError> {
        self.state.nothing_shared = nothing?;
        if self.state.nothing_shared.is_some() {
            return Ok(());
        }
        self.state.begin(&Cells::all()).await?;
        let done = self.follow_shared_in_turn().await;
        self.state.writer.give_back().await;
        done
    }

    async fn follow_shared_in_turn(&mut self) -> Result<(), StoreError> {
        let now = self.now;
        let WriterState { store, config, alerts, .. } = &mut *self.state;
        let (found, rows) = shared_and_explicable(store, config, alerts, now).await?;
        let gyros: BTreeSet<u32> = rows.iter().filter_map(|row| row.of.gyro()).collect();
        self.state.alerts.recall(&self.state.store, gyros, now).await?;
        let mut changes = Changes::default();
        // What lies long ago is history, whenever it is found.
        self.state.change_alerts(now, Late::Quiet, |alerts, context| {
            let off: Vec<(AlertOf, Id)> = alerts.shared().not_judged(&found).map(|row| (row.of, row.id)).collect();
            off.into_iter().for_each(|(of, id)| alerts.reset(of, |row| row.id == id, context));
            for SharedVerdict { of, verdict, origin, .. } in &found {
                alerts.follow(*of, verdict, origin, context);
            }
            let anew = alerts.shared().explained_anew(&rows, &context.naming);
            alerts.explain(&anew, context);
        });
        self.state.note(&mut changes, now).await?;
        self.state.commit_with_heads(&mut changes).await
    }
}

/// An import of which nothing has come for so long was broken off: what it has found is told.
const BROKEN_OFF: f64 = 15.0 / (24.0 * 60.0);
