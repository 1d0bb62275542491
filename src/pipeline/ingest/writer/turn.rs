//! A writer among others: it holds the cells of what it writes, learns what others have written there, and tries again
//! what the database has broken off. Alone on a file it holds everything, and nothing is missed.

use std::collections::HashSet;
use std::time::Duration;

use super::state::{Item, Task};
use crate::core::id::Id;
use crate::pipeline::error::Unwritten;
use crate::pipeline::hooks::Found;
use crate::pipeline::ingest::submission::{Calibration, Corrected, Submission};
use crate::store;
use crate::store::{Cells, Missed, Moves, StoreError};

const MOST_TRIES: u32 = 4;
const FIRST_PAUSE: Duration = Duration::from_millis(30);

/// Does `$work` while `$cells` are held; tries again where the database has broken it off.
macro_rules! in_turn {
    ($task:ident, $cells:expr, $work:expr) => {{
        let mut tries = 0;
        loop {
            let done = match $task.begin(&$cells).await {
                Ok(()) => $work.await,
                Err(error) => Err(error.into()),
            };
            $task.writer.give_back().await;
            if !$crate::pipeline::ingest::writer::turn::to_be_tried_again(&done, &mut tries).await {
                break done;
            }
            $task.start_over();
        }
    }};
}

pub(super) use in_turn;

/// Whether nothing was stored and another try may do better; waits before it.
pub(super) async fn another_try(error: &StoreError, tries: &mut u32) -> bool {
    *tries += 1;
    let may_do_better = matches!(error, StoreError::Unreachable(_) | StoreError::Overtaken(_));
    let worth_it = may_do_better && *tries < MOST_TRIES;
    if worth_it {
        tracing::warn!(%error, tries, "the database broke a transaction off; trying again");
        tokio::time::sleep(FIRST_PAUSE * 3_u32.pow(*tries - 1)).await;
    }
    worth_it
}

pub(super) async fn to_be_tried_again<T>(done: &Result<T, impl Unwritten>, tries: &mut u32) -> bool {
    match done.as_ref().err().and_then(Unwritten::store_error) {
        Some(error) => another_try(error, tries).await,
        None => false,
    }
}

/// What is written next; never where no other server can be.
pub(super) async fn next_of(moves: &mut Option<Moves>) -> Option<Missed> {
    match moves {
        Some(moves) => moves.next().await,
        None => std::future::pending().await,
    }
}

impl Task {
    /// Holds `cells` and catches up with what others have written in them.
    pub(super) async fn begin(&mut self, cells: &Cells) -> Result<(), StoreError> {
        let missed = self.writer.take_turn(cells).await?;
        if std::mem::take(&mut self.behind) {
            self.start_over();
        }
        let caught_up = self.catch_up(&missed).await;
        self.behind = caught_up.is_err();
        caught_up
    }

    async fn catch_up(&mut self, missed: &Missed) -> Result<(), StoreError> {
        if !missed.cells.is_empty() {
            self.forget_cells(&missed.cells.iter().copied().collect());
        }
        if missed.settings {
            self.alerts.forget_settings();
            self.hooks.forget();
        }
        if missed.models {
            self.after.models.read_again(&self.store).await?;
        }
        if missed.access {
            self.after.guard.read_again().await?;
        }
        Ok(())
    }

    /// Forgets what is remembered of the gyros that are at home in `cells`.
    fn forget_cells(&mut self, cells: &HashSet<u8>) {
        let tables = self.store.names().read();
        let lost = |gyro| tables.gyros.cell(gyro).is_none_or(|cell| cells.contains(&cell));
        self.judge.forget_where(lost);
        self.memory.forget_where(lost);
        self.alerts.forget_where(lost);
        self.benched.retain(|gyro, _| !lost(*gyro));
        self.hooks.forget_heard();
    }

    /// As [`Task::begin`], of what `items` are about, whose names are known then.
    pub(super) async fn begin_group(&mut self, items: &[Item<'_>]) -> Result<(), StoreError> {
        if !self.writer.is_one_of_many() {
            return self.begin(&Cells::default()).await;
        }
        let mut cells = self.cells_of(items).await?;
        loop {
            self.begin(&cells).await?;
            store::names::look_up(&self.store, names_of(items)).await?;
            let wanted = self.cells_of(items).await?;
            if cells.contains(&wanted) {
                return Ok(());
            }
            // Somebody else has just taken a new gyro home.
            self.writer.give_back().await;
            cells.extend(wanted.iter());
        }
    }

    /// Where everything is at home that `items` are about.
    async fn cells_of(&self, items: &[Item<'_>]) -> Result<Cells, StoreError> {
        let mut cells = Cells::default();
        for item in items {
            match item.sent {
                Submission::Calibration(sent) => self.cells_of_calibration(sent, &mut cells),
                Submission::Bench(sent) => {
                    cells.insert(store::names::cell_of_gyro(&self.store, sent.result.serial.as_str()));
                }
                Submission::Event(sent) => cells.insert(store::names::cell_of_gyro(&self.store, sent.serial.as_str())),
                Submission::Correction(sent) => {
                    // The alert of an IMU is there.
                    cells.insert(0);
                    sent.replacement.iter().for_each(|new| self.cells_of_calibration(new, &mut cells));
                    match sent.item {
                        Corrected::Calibration { id, .. } => self.cells_of_record(id, &mut cells).await?,
                        Corrected::Bench(id) => {
                            let bench = store::bench::get(&self.store, id).await?;
                            self.cells_of_gyros(bench.map(|bench| bench.gyro).into_iter().collect(), &mut cells)
                                .await?;
                        }
                    }
                }
                Submission::Attributes(sent) => {
                    cells.insert(store::names::cell_of_gyro(&self.store, sent.serial.as_str()));
                }
                Submission::Doubt(sent) => self.cells_of_record(sent.id, &mut cells).await?,
                Submission::Confirmation(sent) => self.cells_of_record(sent.id, &mut cells).await?,
            }
        }
        // What is about nothing that is stored is refused under any.
        if cells.iter().next().is_none() {
            cells.insert(0);
        }
        Ok(cells)
    }

    fn cells_of_calibration(&self, sent: &Calibration, cells: &mut Cells) {
        let home = store::names::cell_of_imu(&self.store, sent.imu.as_str());
        let tables = self.store.names().read();
        let known = |serial: &str| tables.gyros.number(serial).and_then(|gyro| tables.gyros.cell(gyro));
        cells.insert(home);
        cells.extend(sent.gyros.iter().map(|gyro| known(gyro.serial.as_str()).unwrap_or(home)));
    }

    async fn cells_of_record(&self, id: Id, cells: &mut Cells) -> Result<(), StoreError> {
        let Some((imu, gyros)) = store::record::whose(&self.store, id).await? else { return Ok(()) };
        cells.extend(self.store.names().read().imus.cell(imu));
        self.cells_of_gyros(gyros, cells).await
    }

    async fn cells_of_gyros(&self, gyros: Vec<u32>, cells: &mut Cells) -> Result<(), StoreError> {
        store::names::look_up_gyros(&self.store, gyros.clone()).await?;
        let tables = self.store.names().read();
        cells.extend(gyros.into_iter().filter_map(|gyro| tables.gyros.cell(gyro)));
        Ok(())
    }

    /// Where the gyros of alerts are at home.
    pub(super) async fn cells_of_alerts(&self, gyros: Vec<u32>) -> Result<Cells, StoreError> {
        let mut cells = Cells::one(0);
        if self.writer.is_one_of_many() {
            self.cells_of_gyros(gyros, &mut cells).await?;
        }
        Ok(cells)
    }

    /// What delivery queues have found out is about the alerts that were told.
    pub(super) async fn cells_of_findings(&self, found: &[&Found]) -> Result<Cells, StoreError> {
        if !self.writer.is_one_of_many() {
            return Ok(Cells::default());
        }
        let attempted = |found: &&&Found| match found {
            Found::Attempted(attempted) => Some(attempted.delivery),
            Found::Back(_) => None,
        };
        let deliveries: Vec<Id> = found.iter().filter_map(|found| attempted(&found)).collect();
        self.cells_of_alerts(store::outbox::gyros_of(&self.store, &deliveries).await?).await
    }

    /// Tells those who read and those who work in the background of what was written, by whomever.
    pub(super) async fn hear_of(&mut self, missed: &Missed) {
        if missed.outbox || missed.settings {
            self.after.wake.send_modify(|moved| *moved += 1);
        }
        if missed.diagnoses {
            self.after.due.send_modify(|moved| *moved += 1);
        }
        let models = if missed.models { self.after.models.read_again(&self.store).await } else { Ok(()) };
        let access = if missed.access { self.after.guard.read_again().await } else { Ok(()) };
        if let Err(error) = models.and(access) {
            tracing::warn!(%error, "what another server has written cannot be read; its next change is");
        }
    }
}

/// Names of IMUs, stations and gyros.
fn names_of<'a>(items: &[Item<'a>]) -> [Vec<&'a str>; 3] {
    let [mut imus, mut stations, mut gyros] = [const { Vec::new() }; 3];
    for item in items {
        let calibration: Option<&Calibration> = match item.sent {
            Submission::Calibration(sent) => Some(sent),
            Submission::Correction(sent) => sent.replacement.as_ref(),
            Submission::Bench(sent) => {
                stations.push(sent.result.station.as_str());
                gyros.push(sent.result.serial.as_str());
                None
            }
            Submission::Event(sent) => {
                gyros.push(sent.serial.as_str());
                None
            }
            Submission::Attributes(sent) => {
                gyros.push(sent.serial.as_str());
                None
            }
            Submission::Confirmation(_) | Submission::Doubt(_) => None,
        };
        if let Some(sent) = calibration {
            imus.push(sent.imu.as_str());
            stations.push(sent.station.as_str());
            gyros.extend(sent.gyros.iter().map(|gyro| gyro.serial.as_str()));
        }
    }
    [imus, stations, gyros]
}
