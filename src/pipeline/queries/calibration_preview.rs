//! What a calibration that is not stored would be judged to be, beside the last that is.

use super::gyro_status::violations;
use super::status;
use crate::core::judge::{BudgetProjection, Measured, Need, Older, Status};
use crate::pipeline::ingest::admit::figures_of;
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, sample_of};
use crate::pipeline::prelude::*;
use crate::pipeline::{Calibration, Queries, Violation};
use crate::store::StoredVerdict;

/// A number that nothing stored has.
const UNKNOWN: u32 = u32::MAX;

/// One gyro of a calibration that is not stored.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroPreview {
    /// Whether the serial is known.
    pub is_known: bool,
    /// Its last calibration before, D_I, D_S and D_O by the judged method.
    pub last: Option<(UtcMicros, [Measured; 3])>,
    /// By the judged method.
    pub d: [Measured; 3],
    /// (value - last value) / budget; none without a last value, and where the rule `baseline` (of D_O `closure`) is
    /// off.
    pub change: [Option<Measured>; 3],
    pub projection: BudgetProjection,
    /// Of D_I, D_S and D_O.
    pub drift: [Status; 3],
    /// The worst of these.
    pub status: Status,
    /// Requirements on E and G that it does not meet.
    pub unmet: Vec<Violation>,
}

/// What a calibration would come to.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationPreview {
    /// In the order of the calibration's gyros.
    pub gyros: Vec<GyroPreview>,
    pub imu_is_known: bool,
    /// Whether the station is known; where none is, that says nothing.
    pub station_is_known: bool,
}

impl Queries {
    /// What would be said of a calibration if it were stored now, by what is stored before it.
    pub async fn preview_calibration(&self, calibration: &Calibration) -> Result<CalibrationPreview, StoreError> {
        let (imu, station, has_stations) = {
            let tables = self.store.names().read();
            let station = tables.stations.number(calibration.station.as_str());
            (tables.imus.number(calibration.imu.as_str()), station, !tables.stations.is_empty())
        };
        let (judging, at) = (&self.fleet.config.judging, calibration.calibrated_at);
        let before = Span { to: UtcMicros(at.0.saturating_sub(1)), ..Span::EVER };
        let mut gyros = Vec::with_capacity(calibration.gyros.len());
        for gyro in &calibration.gyros {
            let limits = judging.limits(calibration.imu.as_str(), gyro.serial.as_str());
            let number = self.store.names().read().gyros.number(gyro.serial.as_str());
            let (mut window, last) = match number {
                Some(number) => (
                    GyroWindow::load(&self.store, number, before.to, Need::of(&limits), judging.method).await?,
                    store::history::newest(&self.store, number, before, 1).await?.pop(),
                ),
                None => (GyroWindow::default(), None),
            };
            let place = (imu.unwrap_or(UNKNOWN), station.unwrap_or(UNKNOWN));
            let figures = Figures { slot: gyro.slot, ..figures_of(&gyro.separation, Id(0), at, place.0, place.1) };
            let sample = sample_of(&figures, judging.method);
            window.append(sample);
            let verdicts: Vec<Verdict> = window.judge_newest(&limits, Older::NONE);
            let projection = BudgetProjection::of(&verdicts);
            let stored: Vec<StoredVerdict> = verdicts.iter().map(StoredVerdict::from).collect();
            let required: Vec<StoredVerdict> = gyro.requirements.iter().flatten().map(StoredVerdict::from).collect();
            let last = last.map(|figures| (figures.at, sample_of(&figures, judging.method).d));
            let budgets = limits.budgets();
            let change = |column: usize| {
                let ((_, old), budget) = last.as_ref().zip(budgets[column])?;
                let (new, old) = (sample.d[column], old[column]);
                let sd = new.sd.zip(old.sd).map(|(a, b)| a.hypot(b) / budget);
                Some(Measured { value: (new.value - old.value) / budget, sd })
            };
            gyros.push(GyroPreview {
                is_known: number.is_some(),
                change: [0, 1, 2].map(change),
                last,
                d: sample.d,
                projection,
                drift: status::of_drift(&stored),
                status: status::of_gyro(&stored),
                unmet: violations(&required, &[]).collect(),
            });
        }
        let station_is_known = station.is_some() || !has_stations;
        Ok(CalibrationPreview { gyros, imu_is_known: imu.is_some(), station_is_known })
    }
}
