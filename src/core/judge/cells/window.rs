//! The cells that the control rules see at one record.

use super::{CELLS, COLUMNS, Cell, DAYS_A_YEAR, looked_at};
use crate::core::judge::{Rule, Series, reset_before};
use crate::core::time::UtcMicros;

/// The cells that the control rules see at one record, oldest first.
#[derive(Debug, Clone, Copy)]
pub(in crate::core::judge) struct Window {
    len: usize,
    columns: [[Point; CELLS]; COLUMNS],
}

/// One coefficient in one cell.
#[derive(Debug, Clone, Copy)]
pub(in crate::core::judge) struct Point {
    /// The cell's first record.
    pub first: UtcMicros,
    /// Years from the judged record, so that t <= 0.
    pub t: f64,
    /// None where a week's records are of several.
    pub station: Option<u32>,
    /// Mean figure, deg/(h g0).
    pub x: f64,
    /// Standard deviation of the mean that the stations' own give.
    pub sd: Option<f64>,
}

impl Point {
    /// Seen from a record at `now`.
    fn of(cell: &Cell, column: usize, now: UtcMicros) -> Self {
        let (days, x) = cell.mean(column);
        Self {
            first: cell.first,
            t: (cell.first.days_since(now) + days) / DAYS_A_YEAR,
            station: cell.station,
            x,
            sd: cell.variances[column].map(|variance| variance.sqrt() / f64::from(cell.records)),
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
        let nothing = Point { first: now, t: 0.0, station: None, x: 0.0, sd: None };
        let mut columns = [[nothing; CELLS]; COLUMNS];
        for (column, points) in columns.iter_mut().enumerate() {
            points.iter_mut().zip(cells).for_each(|(point, cell)| *point = Point::of(cell, column, now));
        }
        Self { len: cells.len(), columns }
    }

    /// The cells of one coefficient: 0 is D_I, 1 is D_S.
    pub fn column(&self, column: usize) -> &[Point] {
        &self.columns[column][..self.len]
    }
}
