//! What each station does to results: how its calibrations scatter, and what D_I and D_S did when a gyro came to it.

use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;
use std::sync::Arc;

use crate::config::JudgedMethod;
use crate::core::figures::Figures;
use crate::core::numerics::median::median_of;
use crate::core::numerics::normal::SD_OF_MEDIAN;
use crate::core::time::Span;
use crate::core::time::UtcMicros;
use crate::pipeline::ingest::judge::gyro_window::{marks_of, sample_of};
use crate::store;
use crate::store::{Store, StoreError, Stretch};

/// Newest records of each gyro that count.
const RECORDS: usize = 60;
/// Gyros that are looked through together.
const AT_ONCE: usize = 128;

/// One station over the fleet, deg/(h g0).
#[derive(Debug, Clone, PartialEq)]
pub struct StationEffect {
    pub name: Arc<str>,
    pub last: UtcMicros,
    pub records: usize,
    /// Scatter of one calibration of D_I and D_S, from the median of successive differences; none without one.
    pub scatter: [Option<f64>; 2],
    /// Gyros that came from another station, counted each time.
    pub arrivals: usize,
    /// Mean change of D_I and D_S when they came, and its standard error where there are two or more.
    pub arrival: [Option<(f64, Option<f64>)>; 2],
}

/// What has been seen of one station so far.
#[derive(Debug)]
struct Seen {
    last: UtcMicros,
    records: usize,
    /// Differences of successive calibrations here, D_I and D_S.
    differences: Vec<[f64; 2]>,
    /// Differences to the calibration before, at another station.
    arrivals: Vec<[f64; 2]>,
}

/// Every station that calibrated a gyro lately, by name.
pub(super) async fn station_effects(store: &Store, method: JudgedMethod) -> Result<Vec<StationEffect>, StoreError> {
    let gyros: Vec<u32> = store.names().read().gyros.iter().map(|(number, _)| number).collect();
    let mut seen = BTreeMap::<u32, Seen>::new();
    for some in gyros.chunks(AT_ONCE) {
        let ever: Vec<Stretch> = some.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        let histories = store::histories::newest(store, &ever, RECORDS).await?;
        let marks = marks_of(store, some).await?;
        for (gyro, rows) in some.iter().zip(&histories) {
            let marks = marks.get(gyro).into_iter().flatten();
            let resets: Vec<UtcMicros> =
                marks.filter(|mark| mark.event.resets_baseline()).map(|mark| mark.at).collect();
            look_through(method, rows, &resets, &mut seen);
        }
    }
    let tables = store.names().read();
    let named = seen.into_iter().filter_map(|(number, seen)| Some(seen.summed_up(tables.stations.name(number)?)));
    let mut effects: Vec<StationEffect> = named.collect();
    effects.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(effects)
}

fn look_through(method: JudgedMethod, rows: &[Figures], resets: &[UtcMicros], seen: &mut BTreeMap<u32, Seen>) {
    let values = |figures: &Figures| {
        let [d_i, d_s, _] = sample_of(figures, method).d;
        [d_i.value, d_s.value]
    };
    for (i, row) in rows.iter().enumerate() {
        let of_station = seen.entry(row.station).or_insert_with(|| Seen {
            last: row.at,
            records: 0,
            differences: Vec::new(),
            arrivals: Vec::new(),
        });
        of_station.records += 1;
        of_station.last = of_station.last.max(row.at);
        let Some(before) = i.checked_sub(1).map(|i| &rows[i]) else { continue };
        // Over a repair or a new seat it is another gyro: its change says nothing about the station.
        if resets.iter().any(|at| (before.at..=row.at).contains(at)) {
            continue;
        }
        let (old, new) = (values(before), values(row));
        let difference = [new[0] - old[0], new[1] - old[1]];
        if before.station == row.station {
            of_station.differences.push(difference);
        } else {
            of_station.arrivals.push(difference);
        }
    }
}

impl Seen {
    fn summed_up(&self, name: &Arc<str>) -> StationEffect {
        StationEffect {
            name: name.clone(),
            last: self.last,
            records: self.records,
            scatter: [0, 1].map(|column| scatter(&self.differences, column)),
            arrivals: self.arrivals.len(),
            arrival: [0, 1].map(|column| mean(&self.arrivals, column)),
        }
    }
}

/// The standard deviation of one of two values with such differences. From their median, because a gyro that stepped
/// differs once by any amount: that is the gyro's doing and not the station's, and squares would let it decide alone.
fn scatter(differences: &[[f64; 2]], column: usize) -> Option<f64> {
    let sizes = differences.iter().map(|difference| difference[column].abs());
    Some(SD_OF_MEDIAN * median_of(sizes)? / SQRT_2)
}

/// The mean, and its standard error.
fn mean(all: &[[f64; 2]], column: usize) -> Option<(f64, Option<f64>)> {
    let n = all.len() as f64;
    let mean = all.iter().map(|one| one[column]).sum::<f64>() / n;
    let variance = all.iter().map(|one| (one[column] - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (!all.is_empty()).then(|| (mean, (all.len() > 1).then(|| (variance / n).sqrt())))
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, Normal};

    use super::*;

    #[test]
    fn scatter_and_arrivals_are_summed_up() {
        let seen = Seen {
            last: UtcMicros(5),
            records: 4,
            differences: vec![[0.003, 0.0], [-0.003, 0.0]],
            arrivals: vec![[0.01, 0.0], [0.02, 0.0], [0.03, 0.0]],
        };
        let effect = seen.summed_up(&"ST-1".into());
        assert!((effect.scatter[0].unwrap() - 1.4826 * 0.003 / SQRT_2).abs() < 1e-7);
        let (change, error) = effect.arrival[0].unwrap();
        assert!((change - 0.02).abs() < 1e-12 && (error.unwrap() - 0.01 / 3_f64.sqrt()).abs() < 1e-12);
        assert_eq!((mean(&[], 0), scatter(&[], 0)), (None, None));
        assert_eq!(mean(&[[0.5, 1.0]], 1), Some((1.0, None)));
    }

    #[test]
    fn a_gyro_that_steps_does_not_count_against_its_station() {
        // Quantiles in place of noise: their standard deviation is known.
        let normal = Normal::new(0.0, 6e-4 * SQRT_2).unwrap();
        let quiet: Vec<[f64; 2]> = (0..100).map(|k| [normal.inverse_cdf((f64::from(k) + 0.5) / 100.0), 0.0]).collect();
        let told = |differences: &[[f64; 2]]| scatter(differences, 0).unwrap();
        assert!((told(&quiet) / 6e-4 - 1.0).abs() < 0.02, "{}", told(&quiet));
        // It steps there and back, ten times.
        let mut stepping = quiet.clone();
        stepping.extend((0..10).map(|k| [if k % 2 == 0 { 0.02 } else { -0.02 }, 0.0]));
        assert!((told(&stepping) / told(&quiet) - 1.0).abs() < 0.2, "{}", told(&stepping));
    }
}
