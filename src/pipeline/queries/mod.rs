//! What is asked of the database: fleet, histories, records, stations, agreement of methods, verification.

pub(super) mod agreement;
mod calibration_preview;
mod changes_explained;
mod common_shift;
mod dues;
mod entries;
mod fleet;
mod gyro_history;
pub(super) mod gyro_status;
pub(super) mod heads;
mod record;
mod status;
mod today;
mod verify;

use crate::core::suspect_window::{SuspectWindow, in_force};
use crate::pipeline::Reader;
use crate::pipeline::prelude::*;

pub use crate::pipeline::ingest::judge::gyro_window::sample_of;
pub use agreement::{Compared, Comparison};
pub use calibration_preview::{CalibrationPreview, GyroPreview};
pub use changes_explained::ExplainedHistory;
pub use common_shift::{CommonFactor, CommonShift};
pub use dues::{DueDate, Dues};
pub use fleet::{BEYOND, Fleet, FleetFilter, FleetPage, RecentValues, Seats, StatusFilter};
pub use gyro_history::{Baseline, GyroTimeline, Histories, Levels, Tested};
pub use gyro_status::{GyroStatus, Violation};
pub use record::{ListFilter, Names, Records, StoredCampaign, StoredRecord};
pub use status::Statuses;
pub use today::{FEW_RECORDS, LINES, Today, today};
pub use verify::Verified;

/// What is stored, as it is asked for. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Queries {
    store: Store,
    pub records: Records,
    pub fleet: Fleet,
    pub histories: Histories,
    pub dues: Dues,
}

impl Queries {
    pub(super) fn new(store: &Store, config: &Arc<Config>, clock: &Clock, reader: &Reader) -> Self {
        let (store, config, clock, reader) = (store.clone(), config.clone(), clock.clone(), reader.clone());
        let histories = Histories { store: store.clone(), config: config.clone(), clock: clock.clone() };
        let dues = Dues::new(histories.clone());
        let records = Records { store: store.clone(), config: config.clone(), reader };
        let known = Default::default();
        let fleet = Fleet { store: store.clone(), config, clock, records: records.clone(), known };
        Self { store, records, fleet, histories, dues }
    }

    /// Whether a station of that name has measured anything.
    pub async fn is_station(&self, name: &str) -> Result<bool, StoreError> {
        Ok(self.station_number(name).await?.is_some())
    }

    /// The windows of a station in which what it measures does not count, oldest first; none of an unknown station.
    pub async fn suspect_windows(&self, name: &str) -> Result<Option<Vec<SuspectWindow>>, StoreError> {
        let Some(station) = self.station_number(name).await? else { return Ok(None) };
        let rows = store::suspect_window::of_stations(&self.store, &[station]).await?;
        Ok(Some(in_force(rows.iter().map(|row| &row.mark))))
    }

    async fn station_number(&self, name: &str) -> Result<Option<u32>, StoreError> {
        store::names::look_up(&self.store, [Vec::new(), vec![name], Vec::new()]).await?;
        Ok(self.names().station_number(name))
    }

    /// The names of what is stored. Not to be held for long: new names wait for it.
    pub fn names(&self) -> Names<'_> {
        Names(self.store.names().read())
    }
}
