//! The cells in which everything is at home that a transaction is about.

use super::state::Item;
use crate::pipeline::hooks::Found;
use crate::pipeline::ingest::submission::{Calibration, Corrected, Submission};
use crate::pipeline::prelude::*;
use crate::store::{Cells, PackedText, all_cells};

pub(super) struct Homes<'a> {
    pub store: &'a Store,
    /// Whether other servers may write too; otherwise nothing is held.
    pub among_others: bool,
}

impl Homes<'_> {
    /// Of everything that `items` are about.
    pub async fn of_items(&self, items: &[Item<'_>]) -> Result<Cells, StoreError> {
        let mut cells = Cells::default();
        for item in items {
            match item.sent {
                Submission::Calibration(sent) => self.of_calibration(sent, &mut cells),
                Submission::Bench(_) | Submission::Event(_) | Submission::Attributes(_) => {
                    cells.extend(item.sent.serial().map(|serial| store::names::cell_of_gyro(self.store, serial)));
                }
                Submission::Correction(sent) => {
                    // The alert of an IMU is there.
                    cells.insert(0);
                    sent.replacement.iter().for_each(|new| self.of_calibration(new, &mut cells));
                    match sent.item {
                        Corrected::Calibration { id, .. } => self.of_record(id, &mut cells).await?,
                        Corrected::Bench(id) => {
                            let bench = store::bench::get(self.store, id).await?;
                            self.of_gyros(bench.map(|bench| bench.gyro).into_iter().collect(), &mut cells).await?;
                        }
                    }
                }
                // What others are storing meanwhile may lie in the window.
                Submission::Window(_) => cells.extend(all_cells()),
                Submission::SetAside(sent) => self.of_record(sent.id, &mut cells).await?,
                Submission::Confirmation(sent) => self.of_record(sent.id, &mut cells).await?,
            }
        }
        // What is about nothing that is stored is refused under any.
        if cells.is_empty() {
            cells.insert(0);
        }
        Ok(cells)
    }

    fn of_calibration(&self, sent: &Calibration, cells: &mut Cells) {
        let home = store::names::cell_of_imu(self.store, sent.imu.as_str());
        let tables = self.store.names().read();
        let known = |serial: &str| tables.gyros.number(serial).and_then(|gyro| tables.gyros.cell(gyro));
        cells.insert(home);
        cells.extend(sent.gyros.iter().map(|gyro| known(gyro.serial.as_str()).unwrap_or(home)));
    }

    async fn of_record(&self, id: Id, cells: &mut Cells) -> Result<(), StoreError> {
        let Some((imu, gyros)) = store::record::whose(self.store, id).await? else { return Ok(()) };
        cells.extend(self.store.names().read().imus.cell(imu));
        self.of_gyros(gyros, cells).await
    }

    async fn of_gyros(&self, gyros: Vec<u32>, cells: &mut Cells) -> Result<(), StoreError> {
        store::names::look_up_gyros(self.store, gyros.clone()).await?;
        let tables = self.store.names().read();
        cells.extend(gyros.into_iter().filter_map(|gyro| tables.gyros.cell(gyro)));
        Ok(())
    }

    /// Of the IMUs whose records they are.
    pub fn of_texts(&self, texts: &[PackedText]) -> Cells {
        let tables = self.store.names().read();
        texts.iter().filter_map(|text| tables.imus.cell(text.imu)).collect()
    }

    pub async fn of_alerts(&self, gyros: Vec<u32>) -> Result<Cells, StoreError> {
        let mut cells = Cells::from([0]);
        if self.among_others {
            self.of_gyros(gyros, &mut cells).await?;
        }
        Ok(cells)
    }

    /// What delivery queues have found out is about the alerts that were told.
    pub async fn of_findings(&self, found: &[&Found]) -> Result<Cells, StoreError> {
        if !self.among_others {
            return Ok(Cells::default());
        }
        let attempted = |found: &&&Found| match found {
            Found::Attempted(attempted) => Some(attempted.attempt.delivery),
            Found::Back(_) => None,
        };
        let deliveries: Vec<Id> = found.iter().filter_map(|found| attempted(&found)).collect();
        self.of_alerts(store::delivery::gyros_of(self.store, &deliveries).await?).await
    }

    /// Of an alert, which may not exist.
    pub async fn of_alert(&self, alert: Id) -> Cells {
        let row = store::alerts::get(self.store, alert).await.ok().flatten();
        self.of_alerts(row.and_then(|row| row.of.gyro()).into_iter().collect()).await.unwrap_or(Cells::from([0]))
    }
}
