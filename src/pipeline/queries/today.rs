//! What there is to be done: what has become worse, what soon will, what is due, and where several gyros moved at once.

use super::common_shift::shifts_of;
use super::fleet::Fleet;
use crate::core::first_of::{DueImu, FirstOf, MovedImu};
use crate::pipeline::diagnoses::outside_forecasts;
use crate::pipeline::prelude::*;
use crate::pipeline::{CommonShift, GyroStatus};
use crate::store::head::CalibratedRow;
use crate::wire::diagnoses::OutsideForecastBody;

/// Lines of each list.
pub const LINES: usize = 6;
/// Days ahead for which calibrations are due.
pub const DUE_DAYS: f64 = 14.0;
/// Gyros whose trends reach the budget that are looked at: those that their station carries there are one line.
const APPROACHING: usize = 100;
/// All gyros of an IMU so many budgets from their baselines: hardly all of them at once.
const MOVED: f64 = 5.0;

/// A gyro of so few records may be another one under a misspelt name.
pub const FEW_RECORDS: usize = 3;
/// The newest of such names that are looked at.
const ALIKE: usize = 20;

/// What there is to be done.
#[derive(Debug, Clone)]
pub struct Today {
    /// Of which something began to be worse, the newest first.
    pub worse: FirstOf<GyroStatus>,
    /// Within their limits, and carried to the budget by an established trend, the first to reach it first: those that
    /// should be there by now among them.
    pub approaching: FirstOf<GyroStatus>,
    pub overdue: FirstOf<DueImu>,
    /// Within [`DUE_DAYS`].
    pub due: FirstOf<DueImu>,
    pub shifts: Vec<CommonShift>,
    pub moved: Vec<MovedImu>,
    /// Campaigns outside what was foretold of them, the newest first.
    pub outside: FirstOf<OutsideForecastBody>,
    /// Gyros of few records whose names look like that of a known one: both names, the newest last.
    pub misspelt: Vec<[String; 2]>,
}

/// What has become worse since an instant, what soon will, what is due, and where several gyros moved at once; of
/// each as many as [`LINES`], but of those that soon will.
pub async fn today(fleet: &Fleet, since: UtcMicros) -> Result<Today, StoreError> {
    let (store, now) = (&fleet.store, fleet.clock.now());
    let worse = store::head::changed(store, since, LINES).await?;
    let approaching = store::head::approaching(store, APPROACHING).await?;
    let dues = fleet.known.dues.at(store::head::version(store), now, dues(store, now)).await?;
    let calibrated = fleet.known.calibrated.at(store::head::version(store), since, calibrated(store, since)).await?;
    let moved = store::head::moved(store, since, MOVED, LINES).await?;
    let outside = outside_forecasts(store, since, LINES).await?;
    let misspelt = misspelt(store).await?;
    let (worse, approaching) = (first_of(fleet, worse).await?, first_of(fleet, approaching).await?);
    let tables = store.names().read();
    let [overdue, due] = (*dues).clone();
    let station = |number: u32| Arc::from(tables.stations.text(number));
    let shifts = shifts_of(&calibrated, station);
    Ok(Today { worse, approaching, overdue, due, shifts, moved, outside, misspelt })
}

/// IMUs that are overdue and that soon will be, and until when they are the same.
async fn dues(store: &Store, now: UtcMicros) -> Result<([FirstOf<DueImu>; 2], UtcMicros), StoreError> {
    let due_by = now.plus_days(DUE_DAYS);
    let overdue = store::head::due(store, [UtcMicros(i64::MIN), now], LINES).await?;
    let due = store::head::due(store, [now, due_by], LINES).await?;
    let next = store::head::next_overdue(store, now).await?;
    let next_due = store::head::next_overdue(store, due_by).await?;
    Ok(([overdue, due], next.min(UtcMicros(next_due.0 - (due_by.0 - now.0)))))
}

/// The newest calibrations since an instant, and until which instant they are the same.
async fn calibrated(store: &Store, since: UtcMicros) -> Result<(Vec<CalibratedRow>, UtcMicros), StoreError> {
    let newest = store::head::calibrated_since(store, since, None).await?;
    let first = newest.iter().map(|row| row.at).min().unwrap_or(since);
    Ok((newest, first))
}

async fn misspelt(store: &Store) -> Result<Vec<[String; 2]>, StoreError> {
    let named: Vec<(u32, [String; 2])> = {
        let gyros = &store.names().read().gyros;
        let newest = gyros.alike().iter().rev().take(ALIKE).rev();
        let both = |number: &u32| Some((*number, [gyros.name(*number)?, gyros.look_alike(gyros.name(*number)?)?]));
        newest.filter_map(both).map(|(number, names)| (number, names.map(str::to_owned))).collect()
    };
    let asked: Vec<u32> = named.iter().map(|(number, _)| *number).collect();
    let rows = store::histories::newest_ever(store, &asked, FEW_RECORDS + 1).await?;
    let is_few = |rows: &[Figures]| (1..=FEW_RECORDS).contains(&rows.len());
    Ok(named.into_iter().zip(rows).filter(|(_, rows)| is_few(rows)).map(|((_, names), _)| names).collect())
}

async fn first_of(fleet: &Fleet, gyros: FirstOf<u32>) -> Result<FirstOf<GyroStatus>, StoreError> {
    Ok(FirstOf { first: fleet.standings_of(&gyros.first).await?, of: gyros.of })
}
