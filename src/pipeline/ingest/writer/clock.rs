//! Alerts follow the clock: what becomes overdue, is to be repeated or told of as one, and what stations do.

use std::collections::{BTreeMap, BTreeSet};

use super::alerts::gyros_of;
use super::state::WriterState;
use super::stations::StationShifts;
use crate::core::alert_decision::{Late, Status};
use crate::core::figures::Figures;
use crate::core::judge::Rule;
use crate::core::time::{Span, UtcMicros};
use crate::pipeline::alerts::{Naming, Pen, StationVerdict, follow_clock};
use crate::store;
use crate::store::{AlertOf, AlertRow, Cells, Changes, Duty, StoreError};

/// Gyros that the clock may have something to do with, in one place.
#[derive(Debug, Default)]
struct OfClock {
    /// With alerts of which it changes something.
    alerted: BTreeSet<AlertOf>,
    /// Those that may begin or end to be overdue.
    overdue: BTreeSet<u32>,
}

/// One look at the clock.
pub(super) struct ClockTick<'a> {
    pub state: &'a mut WriterState,
    pub now: UtcMicros,
}

impl ClockTick<'_> {
    /// Lets the alerts follow the clock.
    pub async fn tick(&mut self) {
        if !self.state.store.is_on_duty(Duty::Clock) {
            return;
        }
        let followed = self.try_tick().await;
        self.state.writer.give_back().await;
        if let Err(error) = followed {
            self.state.start_over();
            tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
        }
    }

    /// A transaction for each cell in which the clock changes something; in a file, one.
    async fn try_tick(&mut self) -> Result<(), StoreError> {
        let now = self.now;
        let mut rows = store::alerts::of_clock(&self.state.store).await?;
        if self.follow_stations(&rows).await? {
            rows = store::alerts::of_clock(&self.state.store).await?;
        }
        let mut by_cell: BTreeMap<u8, OfClock> = BTreeMap::new();
        let overdue = self.may_be_overdue(&rows).await?;
        let alerted: BTreeSet<AlertOf> =
            rows.iter().filter(|row| self.state.alerts.is_moved_by_clock(row, now)).map(|row| row.of).collect();
        store::names::look_up_gyros(&self.state.store, overdue.iter().copied().chain(gyros_of(&alerted)).collect())
            .await?;
        {
            let tables = self.state.store.names().read();
            let home = |gyro: &u32| tables.gyros.cell(*gyro).unwrap_or_default();
            overdue.iter().for_each(|gyro| _ = by_cell.entry(home(gyro)).or_default().overdue.insert(*gyro));
            let home_of = |of: &AlertOf| of.gyro().map_or(0, |gyro| home(&gyro));
            alerted.iter().for_each(|of| _ = by_cell.entry(home_of(of)).or_default().alerted.insert(*of));
        }
        for (cell, found) in by_cell {
            self.state.begin(&Cells::one(cell)).await?;
            self.tick_in_turn(&found).await?;
            self.state.writer.give_back().await;
        }
        let digest =
            rows.iter().filter_map(|row| row.alert.hushed.filter(|hushed| hushed.digest)).map(|it| it.at).max();
        if digest.is_some_and(|since| is_over(since, now)) {
            self.state.begin(&Cells::all()).await?;
            let mut changes = Changes::default();
            self.state.digest(&mut changes, now).await?;
            self.state.enter_heads(&mut changes).await?;
            if !changes.is_empty() {
                self.state.commit(&changes).await?;
            }
        }
        Ok(())
    }

    /// Gyros of which the clock may begin or end that they are overdue.
    async fn may_be_overdue(&self, rows: &[AlertRow]) -> Result<BTreeSet<u32>, StoreError> {
        let now = self.now;
        if !self.state.judge.has_intervals() {
            return Ok(BTreeSet::new());
        }
        let is_firing = |row: &&AlertRow| row.rule == Rule::Overdue && row.alert.status == Status::Firing;
        let firing: BTreeSet<u32> = rows.iter().filter(is_firing).filter_map(|row| row.of.gyro()).collect();
        let overdue: BTreeSet<u32> = store::head::overdue(&self.state.store, now).await?.into_iter().collect();
        Ok(&firing ^ &overdue)
    }

    async fn tick_in_turn(&mut self, found: &OfClock) -> Result<(), StoreError> {
        let now = self.now;
        let mut changes = Changes::default();
        self.state
            .alerts
            .recall(&self.state.store, gyros_of(&found.alerted).chain(found.overdue.iter().copied()), now)
            .await?;
        let gyros: Vec<u32> = found.overdue.iter().copied().collect();
        let out_of_use = self.state.heads().out_of_use(&gyros).await?;
        let ever: Vec<_> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        let newest = store::histories::newest(&self.state.store, &ever, 1).await?;
        {
            let naming = Naming { tables: &self.state.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.state.writer, naming, cause: None, late: Late::Clock };
            for (gyro, newest) in gyros.into_iter().zip(newest) {
                let in_use = |newest: &&Figures| out_of_use.get(&gyro).is_none_or(|(at, _)| *at < newest.at);
                match newest.last().filter(in_use) {
                    Some(newest) => {
                        follow_clock(&mut self.state.alerts, &self.state.judge, gyro, newest.at, newest.imu, &mut pen);
                    }
                    None => self.state.alerts.reset(gyro, |row| row.rule == Rule::Overdue, &mut pen),
                }
            }
            self.state.alerts.tick(&found.alerted, &mut pen);
        }
        self.state.note(&mut changes, now).await?;
        self.state.enter_heads(&mut changes).await?;
        if changes.is_empty() { Ok(()) } else { self.state.commit(&changes).await }
    }

    /// Lets the alerts of stations follow the clock, and those of gyros that they explain. `rows`: every alert that the
    /// clock may change. False where nothing was to be changed.
    async fn follow_stations(&mut self, rows: &[AlertRow]) -> Result<bool, StoreError> {
        let now = self.now;
        self.state.alerts.recall(&self.state.store, [], now).await?;
        let found = self.stations().all().await?;
        let is_anything = {
            let tables = self.state.store.names().read();
            let naming = Naming { tables: &tables, new: None };
            let is_off = self.stations().are_switched_off() && self.state.alerts.stations().firing().next().is_some();
            is_off
                || found.iter().any(|one| self.state.alerts.stations().is_moved_by(one, &naming))
                || !self.state.alerts.stations().explained_anew(rows, &naming).is_empty()
        };
        if !is_anything {
            return Ok(false);
        }
        self.state.begin(&Cells::all()).await?;
        let done = self.follow_stations_in_turn().await;
        self.state.writer.give_back().await;
        done.map(|()| true)
    }

    async fn follow_stations_in_turn(&mut self) -> Result<(), StoreError> {
        let now = self.now;
        let rows = store::alerts::of_clock(&self.state.store).await?;
        let gyros: BTreeSet<u32> = rows.iter().filter_map(|row| row.of.gyro()).collect();
        self.state.alerts.recall(&self.state.store, gyros, now).await?;
        let (found, mut changes) = (self.stations().all().await?, Changes::default());
        let off = self.stations().are_switched_off();
        {
            let naming = Naming { tables: &self.state.store.names().read(), new: None };
            let mut pen = Pen { now, writer: &mut self.state.writer, naming, cause: None, late: Late::Clock };
            if off {
                let firing: Vec<u32> = self.state.alerts.stations().firing().map(|(station, _)| station).collect();
                let ends = |row: &AlertRow| row.rule == Rule::StationShift;
                firing.into_iter().for_each(|one| self.state.alerts.reset(AlertOf::Station(one), ends, &mut pen));
            }
            for StationVerdict { station, verdict, origin } in &found {
                self.state.alerts.follow(AlertOf::Station(*station), verdict, origin, &mut pen);
            }
            let anew = self.state.alerts.stations().explained_anew(&rows, &naming);
            self.state.alerts.explain(&anew, &mut pen);
        }
        self.state.note(&mut changes, now).await?;
        self.state.enter_heads(&mut changes).await?;
        if changes.is_empty() { Ok(()) } else { self.state.commit(&changes).await }
    }

    fn stations(&self) -> StationShifts<'_> {
        self.state.stations(self.now)
    }
}

/// An import of which nothing has come for so long was broken off: what it has found is told.
const BROKEN_OFF: f64 = 15.0 / (24.0 * 60.0);

fn is_over(since: UtcMicros, now: UtcMicros) -> bool {
    now.days_since(since).abs() > BROKEN_OFF
}
