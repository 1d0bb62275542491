//! What gyros that moved together have in common: their station, or their batch.

use crate::core::judge::{Measured, in_common};
use crate::pipeline::prelude::*;
use crate::store::head::CalibratedRow;

/// Gyros that a station must have calibrated for a shift of theirs to be told.
const LEAST_GYROS: usize = 8;
/// A shift is told where its median is so many standard errors of it from zero, and more than so much of the budget.
const ERRORS: f64 = 4.0;
const LEAST_SHIFT: f64 = 0.1;

/// What gyros have in common that moved together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum CommonFactor {
    Station(Arc<str>),
    Batch(Arc<str>),
}

/// The newest calibrations of a station's gyros, or of a batch, lie to one side of their baselines.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonShift {
    pub of: CommonFactor,
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

pub(super) fn shifts_of(newest: &[CalibratedRow], name: impl Fn(u32) -> Arc<str>) -> Vec<CommonShift> {
    let mut together: BTreeMap<CommonFactor, Vec<&CalibratedRow>> = BTreeMap::new();
    for row in newest {
        together.entry(CommonFactor::Station(name(row.station))).or_default().push(row);
        if let Some(batch) = &row.batch {
            together.entry(CommonFactor::Batch(batch.clone())).or_default().push(row);
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
        assert_eq!(of_batch.iter().map(|one| &one.of).collect::<Vec<_>>(), [&CommonFactor::Batch("B-7".into())]);
        rows.iter_mut().for_each(|row| row.station = 1);
        let shifts = shifts_of(&rows, name);
        assert_eq!((shifts.len(), shifts[0].column), (2, 0));
        assert_eq!(shifts[0].between, [UtcMicros(0), UtcMicros(7)]);
    }
}
