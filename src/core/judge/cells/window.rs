//! The cells that the control rules see at one record.

use super::{CELLS, COLUMNS, Cell, DAYS_A_YEAR, looked_at};
use crate::core::judge::event::reset_before;
use crate::core::judge::rule::Rule;
use crate::core::judge::series::Series;
use crate::core::time::UtcMicros;

/// The cells that the control rules see at one record, oldest first: years before it (so t <= 0), mean figures, and
/// the standard deviations of these means that the stations' own give.
#[derive(Debug, Clone, Copy)]
pub(in crate::core::judge) struct Window {
    pub len: usize,
    pub first: [UtcMicros; CELLS],
    pub t: [f64; CELLS],
    stations: [Option<u32>; CELLS],
    pub(super) x: [[f64; CELLS]; COLUMNS],
    pub(super) sd: [[Option<f64>; CELLS]; COLUMNS],
}

/// One column of a [`Window`], or its newest cells.
#[derive(Debug, Clone, Copy)]
pub(in crate::core::judge) struct Points<'a> {
    pub first: &'a [UtcMicros],
    /// Years before the judged record.
    pub t: &'a [f64],
    /// None where a week's records are of several.
    pub stations: &'a [Option<u32>],
    /// deg/(h g0).
    pub x: &'a [f64],
    pub sd: &'a [Option<f64>],
}

impl<'a> Points<'a> {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// The last `n` cells, or all where there are fewer.
    pub fn newest(self, n: usize) -> Self {
        let start = self.len() - n.min(self.len());
        Self {
            first: &self.first[start..],
            t: &self.t[start..],
            stations: &self.stations[start..],
            x: &self.x[start..],
            sd: &self.sd[start..],
        }
    }
}

impl Window {
    /// At record `k`. Records after it have no part.
    pub fn at(samples: &Series, k: usize) -> Self {
        let now = &samples[k];
        let reset = [Rule::Shift, Rule::Trend].map(|rule| reset_before(samples.marks(), now.at, rule));
        let reset = reset.into_iter().flatten().max();
        let all = samples.cells();
        let end = all.partition_point(|cell| cell.first <= now.at);
        let own = samples[..=k].partition_point(|sample| sample.at < all[end - 1].first);
        let mut cells = [Cell::of(now); CELLS];
        let since = all[..end].partition_point(|cell| reset.is_some_and(|reset| cell.first < reset));
        let len = looked_at(&all[since..end], now.at);
        cells[..len].copy_from_slice(&all[end - len..end]);
        // The newest cell may hold records after the judged one.
        let mut newest = Cell::of(&samples[own]);
        samples[own + 1..=k].iter().for_each(|sample| newest.add(sample));
        cells[len - 1] = newest;
        Self::of(&cells[..len], now.at)
    }

    pub(super) fn of(cells: &[Cell], now: UtcMicros) -> Self {
        let mut window = Self {
            len: cells.len(),
            first: [now; CELLS],
            t: [0.0; CELLS],
            stations: [None; CELLS],
            x: [[0.0; CELLS]; COLUMNS],
            sd: [[None; CELLS]; COLUMNS],
        };
        for (i, cell) in cells.iter().enumerate() {
            let records = f64::from(cell.records);
            window.first[i] = cell.first;
            window.stations[i] = cell.station;
            window.t[i] = (cell.first.days_since(now) + cell.days / records) / DAYS_A_YEAR;
            for column in 0..COLUMNS {
                window.x[column][i] = cell.values[column] / records;
                window.sd[column][i] = cell.variances[column].map(|variance| variance.sqrt() / records);
            }
        }
        window
    }

    /// The cells of one coefficient: 0 is D_I, 1 is D_S.
    pub fn column(&self, column: usize) -> Points<'_> {
        let n = self.len;
        Points {
            first: &self.first[..n],
            t: &self.t[..n],
            stations: &self.stations[..n],
            x: &self.x[column][..n],
            sd: &self.sd[column][..n],
        }
    }
}
