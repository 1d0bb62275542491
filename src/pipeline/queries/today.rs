//! What there is to be done: what has become worse, what soon will, what is due, and where several gyros moved at once.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::fleet::Fleet;
use super::standing::Standing;
use crate::core::id::Id;
use crate::core::judge::{Measured, in_common};
use crate::core::time::UtcMicros;
use crate::pipeline::diagnoses::outside_forecasts;
use crate::pipeline::error::StorageError;
use crate::store;
use crate::store::head::CalibratedRow;
use crate::wire::diagnoses::OutsideForecastBody;

/// Days ahead for which calibrations are due.
pub const DUE_DAYS: f64 = 14.0;
/// Gyros that a station must have calibrated for a shift of theirs to be told.
const LEAST_GYROS: usize = 8;
/// A shift is told where its median is so many standard errors of it from zero, and more than so much of the budget.
const ERRORS: f64 = 4.0;
const LEAST_SHIFT: f64 = 0.1;
/// All gyros of an IMU so many budgets from their baselines: hardly all of them at once.
const MOVED: f64 = 5.0;

/// The first of a list, and how long it is.
#[derive(Debug, Clone)]
pub struct FirstOf<T> {
    pub first: Vec<T>,
    pub of: usize,
}

/// What there is to be done.
#[derive(Debug, Clone)]
pub struct Today {
    /// Of which something began to be worse, the newest first.
    pub worse: FirstOf<Standing>,
    /// Within their limits, and carried to the budget by an established trend, the first to reach it first.
    pub approaching: FirstOf<Standing>,
    pub overdue: FirstOf<DueImu>,
    /// Within [`DUE_DAYS`].
    pub due: FirstOf<DueImu>,
    pub shifts: Vec<CommonShift>,
    pub moved: Vec<MovedImu>,
    /// Campaigns outside what was foretold of them, the newest first.
    pub outside: FirstOf<OutsideForecastBody>,
}

/// An IMU with gyros to be calibrated.
#[derive(Debug, Clone, PartialEq)]
pub struct DueImu {
    pub imu: Arc<str>,
    /// When the first of them was or is due.
    pub at: UtcMicros,
    pub gyros: usize,
}

/// What gyros have in common that moved together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Together {
    Station(Arc<str>),
    Batch(Arc<str>),
}

/// The newest calibrations of a station's gyros, or of a batch, lie to one side of their baselines.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonShift {
    pub of: Together,
    /// 0: D_I, 1: D_S.
    pub column: usize,
    pub shift: Shift,
    /// The first and the last of these calibrations.
    pub between: [UtcMicros; 2],
}

/// What gyros have in common, in budgets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    pub median: f64,
    /// Standard error of the median.
    pub error: f64,
    pub gyros: usize,
}

/// An IMU of which every gyro lies far from its baseline.
#[derive(Debug, Clone, PartialEq)]
pub struct MovedImu {
    pub imu: Arc<str>,
    pub record: Id,
    pub at: UtcMicros,
    pub gyros: usize,
    /// That of the gyro that lies nearest, in budgets.
    pub least: f64,
}

/// What has become worse since an instant, what soon will, what is due, and where several gyros moved at once; of
/// each as many as `most`.
///
/// # Errors
/// [`StorageError`].
pub async fn today(fleet: &Fleet, since: UtcMicros, most: usize) -> Result<Today, StorageError> {
    let (store, now) = (&fleet.store, fleet.clock.now());
    let worse = store::head::changed(store, since, most).await?;
    let approaching = store::head::approaching(store, now, most).await?;
    let due_by = now.plus_days(DUE_DAYS);
    let overdue = store::head::due(store, [UtcMicros(i64::MIN), now], most).await?;
    let due = store::head::due(store, [now, due_by], most).await?;
    let newest = store::head::calibrated_since(store, since, None).await?;
    let moved = store::head::moved(store, since, MOVED, most).await?;
    let (first, of) = outside_forecasts(store, since, most).await?;
    let outside = FirstOf { first, of };
    let (worse, approaching) = (first_of(fleet, worse).await?, first_of(fleet, approaching).await?);
    let tables = store.names().read();
    let imu = |number: u32| tables.imus.name(number).cloned().unwrap_or_default();
    let imus = |(rows, of): (Vec<(u32, UtcMicros, usize)>, usize)| FirstOf {
        first: rows.into_iter().map(|(number, at, gyros)| DueImu { imu: imu(number), at, gyros }).collect(),
        of,
    };
    let moved = moved.into_iter().map(|row| {
        let store::head::MovedRow { record, at, gyros, least, .. } = row;
        MovedImu { imu: imu(row.imu), record, at, gyros, least }
    });
    let station = |station: u32| tables.stations.name(station).cloned().unwrap_or_default();
    Ok(Today {
        worse,
        approaching,
        overdue: imus(overdue),
        due: imus(due),
        shifts: shifts_of(&newest, station),
        moved: moved.collect(),
        outside,
    })
}

async fn first_of(fleet: &Fleet, (gyros, of): (Vec<u32>, usize)) -> Result<FirstOf<Standing>, StorageError> {
    Ok(FirstOf { first: fleet.standings_of(&gyros).await?, of })
}

fn shifts_of(newest: &[CalibratedRow], name: impl Fn(u32) -> Arc<str>) -> Vec<CommonShift> {
    let mut together: BTreeMap<Together, Vec<&CalibratedRow>> = BTreeMap::new();
    for row in newest {
        together.entry(Together::Station(name(row.station))).or_default().push(row);
        if let Some(batch) = &row.batch {
            together.entry(Together::Batch(batch.clone())).or_default().push(row);
        }
    }
    let mut shifts = Vec::new();
    for (of, rows) in together {
        for column in 0..2 {
            let loads: Vec<f64> = rows.iter().filter_map(|row| row.load[column]).map(|load| load.value).collect();
            let Some(shift) = common(&loads) else { continue };
            let times = || rows.iter().map(|row| row.at);
            let between = [times().min().unwrap_or(UtcMicros(0)), times().max().unwrap_or(UtcMicros(0))];
            shifts.push(CommonShift { of: of.clone(), column, shift, between });
        }
    }
    shifts.sort_by(|a, b| b.shift.median.abs().total_cmp(&a.shift.median.abs()));
    shifts
}

/// What values have in common that scatter independently about it: none where zero is as likely. By the median, so
/// that a few gyros which moved by themselves do not count.
fn common(values: &[f64]) -> Option<Shift> {
    let gyros = values.len();
    if gyros < LEAST_GYROS {
        return None;
    }
    let Measured { value: median, sd } = in_common(values, gyros, 0.0)?;
    let error = sd?;
    (median.abs() > LEAST_SHIFT && median.abs() > ERRORS * error).then_some(Shift { median, error, gyros })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    fn drawn(rng: &mut ChaCha8Rng, gyros: usize, shift: f64) -> Vec<f64> {
        let noise = Normal::new(shift, 0.1).unwrap();
        (0..gyros).map(|_| noise.sample(rng)).collect()
    }

    #[test]
    fn gyros_that_share_nothing_show_no_shift_and_those_that_do_show_its_size() {
        let mut rng = ChaCha8Rng::seed_from_u64(23);
        for gyros in [8, 12, 30] {
            let told = (0..2000).filter(|_| common(&drawn(&mut rng, gyros, 0.0)).is_some()).count();
            assert!(told <= 10, "{told} of 2000 with {gyros} gyros");
            let found: Vec<Shift> = (0..500).filter_map(|_| common(&drawn(&mut rng, gyros, 0.35))).collect();
            assert!(found.len() > 480, "{} of 500 with {gyros} gyros", found.len());
            let mean = found.iter().map(|shift| shift.median).sum::<f64>() / found.len() as f64;
            assert!((mean - 0.35).abs() < 0.01, "{mean}");
        }
    }

    #[test]
    fn gyros_that_moved_by_themselves_are_no_shift_and_a_few_gyros_tell_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut loads = drawn(&mut rng, 20, 0.0);
        loads[..6].iter_mut().for_each(|load| *load += 3.0);
        assert_eq!(common(&loads), None);
        assert_eq!(common(&[0.5; 7]), None);
        let row = |k: u32| CalibratedRow {
            gyro: k,
            imu: k,
            station: k % 2,
            at: UtcMicros(i64::from(k)),
            load: [0.35, 0.0].map(|load| Some(Measured::exact(load))),
            batch: None,
        };
        let mut rows: Vec<CalibratedRow> = (0..8).map(row).collect();
        let name = |station: u32| Arc::from(format!("ST-{station}"));
        assert!(shifts_of(&rows, name).is_empty(), "four gyros a station");
        rows.iter_mut().for_each(|row| row.batch = Some("B-7".into()));
        let of_batch = shifts_of(&rows, name);
        assert_eq!(of_batch.iter().map(|one| &one.of).collect::<Vec<_>>(), [&Together::Batch("B-7".into())]);
        rows.iter_mut().for_each(|row| row.station = 1);
        let shifts = shifts_of(&rows, name);
        assert_eq!((shifts.len(), shifts[0].column), (2, 0));
        assert_eq!(shifts[0].between, [UtcMicros(0), UtcMicros(7)]);
    }
}
