//! Records of one week taken as one: what the control rules look at, so that a gyro calibrated daily is judged like one
//! calibrated every other week.

use crate::core::judge::{Mark, Rule, Sample};
use crate::core::time::UtcMicros;

mod window;

pub(super) use window::{Point, Window};

/// Length of a cell. Cells are fixed weeks (counted from 1970-01-01T00:00Z); an event that restarts the control rules
/// ends one early.
const CELL: i64 = 7 * UtcMicros::DAY;
/// Cells that the rules look back over, the judged record's among them.
pub(super) const CELLS: usize = 40;
/// Nor farther than so many days,
const MOST_DAYS: f64 = 550.0;
/// but at least over so many cells, where there are so many.
const LEAST_CELLS: usize = 12;
/// Cells that are kept beyond those, for records that come a little late.
pub(super) const SPARE: usize = 4;
/// D_I and D_S.
const COLUMNS: usize = 2;

/// The records of one cell, added up in the order of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    /// Its first record.
    pub first: UtcMicros,
    last: UtcMicros,
    /// Of all its records; none where they are of several.
    station: Option<u32>,
    records: u32,
    /// Days since the first record.
    days: f64,
    values: [f64; COLUMNS],
    /// Of the stated standard deviations; none where one is missing.
    variances: [Option<f64>; COLUMNS],
}

impl Cell {
    fn of(sample: &Sample) -> Self {
        Self {
            first: sample.at,
            last: sample.at,
            station: Some(sample.station),
            records: 1,
            days: 0.0,
            values: [0, 1].map(|i| sample.d[i].value),
            variances: [0, 1].map(|i| sample.d[i].sd.map(|sd| sd * sd)),
        }
    }

    fn add(&mut self, sample: &Sample) {
        let new = Self::of(sample);
        self.last = sample.at;
        self.station = self.station.filter(|station| *station == sample.station);
        self.records += 1;
        self.days += sample.at.days_since(self.first);
        for i in 0..COLUMNS {
            self.values[i] += new.values[i];
            self.variances[i] = self.variances[i].zip(new.variances[i]).map(|(a, b)| a + b);
        }
    }

    /// Mean time in days since its first record, and mean figure.
    pub fn mean(&self, column: usize) -> (f64, f64) {
        (self.days / f64::from(self.records), self.values[column] / f64::from(self.records))
    }

    /// Whether all of its records, and all that belong to it, come before `at`.
    pub fn ends_before(&self, at: UtcMicros, marks: &[Mark]) -> bool {
        self.last < at && !self.takes(at, marks)
    }

    /// Whether a record belongs to it.
    fn takes(&self, at: UtcMicros, marks: &[Mark]) -> bool {
        let week = |at: UtcMicros| at.0.div_euclid(CELL);
        week(self.last) == week(at) && !marks.iter().any(|mark| ends_cell(mark) && self.last < mark.at && mark.at <= at)
    }
}

pub(super) fn ends_cell(mark: &Mark) -> bool {
    mark.event.resets(Rule::Shift) || mark.event.resets(Rule::Trend)
}

/// Adds a record that is newer than all others.
pub(super) fn push(cells: &mut Vec<Cell>, sample: &Sample, marks: &[Mark]) {
    match cells.last_mut().filter(|last| last.takes(sample.at, marks)) {
        Some(last) => last.add(sample),
        None => cells.push(Cell::of(sample)),
    }
}

/// How many of the cells up to a record (`cells`, its own the last) the rules look at.
pub(super) fn looked_at(cells: &[Cell], now: UtcMicros) -> usize {
    let near = cells.iter().rev().take_while(|cell| now.days_since(cell.first) <= MOST_DAYS).count();
    near.clamp(LEAST_CELLS, CELLS).min(cells.len())
}

/// How many of the records after `changed` (oldest first) look back to it.
pub(super) fn reach(changed: UtcMicros, later: &[Sample]) -> usize {
    let near = later.partition_point(|sample| sample.at.days_since(changed) <= MOST_DAYS);
    // A mark only makes more cells of them.
    let (mut cells, mut last) = (1, changed.0.div_euclid(CELL));
    let beyond = later.iter().position(|sample| {
        let week = sample.at.0.div_euclid(CELL);
        cells += usize::from(week != last);
        last = week;
        cells > LEAST_CELLS
    });
    near.max(beyond.unwrap_or(later.len()))
}

pub(super) const DAYS_A_YEAR: f64 = 365.25;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Event;
    use crate::core::judge::sample::{Measured, Seat};

    const DAY: i64 = UtcMicros::DAY;

    fn samples(points: &[(i64, f64)]) -> Vec<Sample> {
        let sample = |&(at, value): &(i64, f64)| {
            let d = [Measured { value, sd: Some(0.1) }, Measured::exact(2.0), Measured::exact(0.0)];
            Sample { at: UtcMicros(at), seat: Seat::default(), station: 0, d }
        };
        points.iter().map(sample).collect()
    }

    fn cells(samples: &[Sample], marks: &[Mark]) -> Vec<Cell> {
        let mut cells = Vec::new();
        samples.iter().for_each(|sample| push(&mut cells, sample, marks));
        cells
    }

    #[test]
    fn a_cell_stands_at_the_mean_of_its_records() {
        let cells = cells(&samples(&[(700 * DAY, 3.0), (702 * DAY, 3.5)]), &[]);
        let window = Window::of(&cells, UtcMicros(710 * DAY));
        assert_eq!(cells.len(), 1);
        assert!((window.column(0)[0].t - (-9.0 / DAYS_A_YEAR)).abs() < 1e-15, "days 700 and 702, seen from day 710");
        assert_eq!(window.column(0)[0].x, 3.25);
        assert!((window.column(0)[0].sd.unwrap() - 0.1 / 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(window.column(1)[0].sd, None, "one standard deviation is missing");
    }

    #[test]
    fn an_event_that_restarts_the_control_rules_ends_a_cell_and_a_note_does_not() {
        let records = samples(&[(700 * DAY, 3.0), (702 * DAY, 3.5)]);
        let of = |event| cells(&records, &[Mark::of(UtcMicros(701 * DAY), event)]).len();
        assert_eq!([of(Event::Note), of(Event::Repair)], [1, 2]);
    }
}
