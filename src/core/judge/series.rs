//! A gyro's records in a row and what was done to it, with weekly means and the extremes of any stretch at hand.

use std::ops::{Deref, Range};

use super::cells::{self, Cell};
use super::event::Mark;
use super::extremes::Extremes;
use super::sample::{COLUMNS, Sample};
use crate::core::time::UtcMicros;

/// Records of one gyro, oldest first, no two at the same instant, and its events.
///
/// Rules that look back over days may have thousands of records before them, so the extremes of runs of 16, 256, 4096
/// ... records are kept: those of any stretch take some thirty steps for each power of sixteen in its length. Cells
/// outlast the records that were [forgotten](Series::forget).
#[derive(Debug, Clone, Default)]
pub struct Series {
    samples: Vec<Sample>,
    /// Oldest first.
    marks: Vec<Mark>,
    cells: Vec<Cell>,
    /// Of each length of run, those of every run that is complete, by column of [`Sample::d`].
    runs: Vec<Vec<[Extremes<usize>; COLUMNS]>>,
}

/// Records, or shorter runs, in a run.
const RUN: usize = 16;

impl Series {
    /// Records and events, both oldest first.
    pub fn new(samples: Vec<Sample>, marks: Vec<Mark>) -> Self {
        let mut series = Self { samples, marks, ..Self::default() };
        series.complete(0);
        series.rebuild_cells(UtcMicros(i64::MIN));
        series
    }

    /// Adds a record that is not older than the last one.
    pub fn push(&mut self, sample: Sample) {
        self.samples.push(sample);
        cells::push(&mut self.cells, &sample, &self.marks);
        self.complete(0);
    }

    /// Events, oldest first.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cells between events that restart the control rules.
    pub(super) fn undisturbed_cells(&self) -> impl Iterator<Item = &[Cell]> {
        let restarted = |a: &Cell, b: &Cell| {
            self.marks.iter().any(|mark| cells::ends_cell(mark) && a.first < mark.at && mark.at <= b.first)
        };
        self.cells.chunk_by(move |a, b| !restarted(a, b))
    }

    /// Whether the control rules find every cell that they look back to, if the first records of the oldest cell may
    /// be missing.
    pub fn reaches_all_cells(&self) -> bool {
        let (Some(newest), [_, complete @ ..]) = (self.samples.last(), &self.cells[..]) else { return false };
        complete.len() > cells::looked_at(complete, newest.at) + cells::SPARE
    }

    /// Forgets the oldest cell, whose first records are missing.
    pub fn forget_first_cell(&mut self) {
        self.cells.drain(..1.min(self.cells.len()));
    }

    /// Puts records in their places by time.
    pub fn insert(&mut self, samples: impl IntoIterator<Item = Sample>) {
        let before = self.samples.len();
        self.samples.extend(samples);
        let Some(first) = self.samples[before..].iter().map(|new| new.at).min() else { return };
        let place = self.samples[..before].partition_point(|there| there.at < first);
        self.samples[place..].sort_by_key(|sample| sample.at);
        self.rebuild(place);
        self.rebuild_cells(first);
    }

    /// Forgets the oldest `count` records, and the cells that no rule looks back to.
    pub fn forget(&mut self, count: usize) {
        self.samples.drain(..count);
        self.rebuild(0);
        if let Some(newest) = self.samples.last() {
            let keep = cells::looked_at(&self.cells, newest.at) + cells::SPARE;
            self.cells.drain(..self.cells.len().saturating_sub(keep));
        }
    }

    /// The extremes of a column over a stretch of places.
    pub(crate) fn extremes(&self, column: usize, Range { start, end }: Range<usize>) -> Extremes<usize> {
        let (mut found, mut at) = (Extremes::NONE, start);
        while at < end {
            let begins_and_ends = |(length, _): &(usize, _)| at.is_multiple_of(*length) && at + length <= end;
            let lengths = std::iter::successors(Some(RUN), |length| Some(length * RUN));
            let longest = lengths.zip(&self.runs).take_while(begins_and_ends).last();
            let (length, part) = longest.map_or_else(
                || (1, Extremes::of(std::iter::once((at, self.samples[at].d[column].value)))),
                |(length, runs)| (length, runs[at / length][column]),
            );
            found = found.and(part);
            at += length;
        }
        found
    }

    /// Makes the cells anew that hold a record at `first` or after it. The records of the first of them must not have
    /// been forgotten.
    fn rebuild_cells(&mut self, first: UtcMicros) {
        let cell = self.cells.partition_point(|cell| cell.ends_before(first, &self.marks));
        let begin = self.cells.get(cell).map_or(first, |cell| cell.first.min(first));
        self.cells.truncate(cell);
        let place = self.samples.partition_point(|sample| sample.at < begin);
        for sample in &self.samples[place..] {
            cells::push(&mut self.cells, sample, &self.marks);
        }
    }

    /// Makes anew what holds a record at `place` or after it.
    fn rebuild(&mut self, place: usize) {
        let mut length = RUN;
        for runs in &mut self.runs {
            runs.truncate(place / length);
            length *= RUN;
        }
        self.complete(0);
    }

    /// Adds the runs that have become complete, from the `level`-th length on.
    fn complete(&mut self, level: usize) {
        let shorter = level.checked_sub(1).map_or(self.samples.len(), |shorter| self.runs[shorter].len());
        if self.runs.len() == level {
            if shorter < RUN {
                return;
            }
            self.runs.push(Vec::new());
        }
        let before = self.runs[level].len();
        for run in before..shorter / RUN {
            let parts = run * RUN..(run + 1) * RUN;
            let of = |column: usize| match level.checked_sub(1) {
                None => Extremes::of(parts.clone().map(|at| (at, self.samples[at].d[column].value))),
                Some(shorter) => {
                    self.runs[shorter][parts.clone()].iter().fold(Extremes::NONE, |found, part| found.and(part[column]))
                }
            };
            let extremes = std::array::from_fn(of);
            self.runs[level].push(extremes);
        }
        if self.runs[level].len() > before || self.runs.len() > level + 1 {
            self.complete(level + 1);
        }
    }
}

impl From<Vec<Sample>> for Series {
    /// `samples` are oldest first, and nothing was done to the gyro.
    fn from(samples: Vec<Sample>) -> Self {
        Self::new(samples, Vec::new())
    }
}

impl Deref for Series {
    type Target = [Sample];

    fn deref(&self) -> &[Sample] {
        &self.samples
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;
    use crate::core::judge::{Event, Measured, Seat};

    fn sample(at: i64, value: i32) -> Sample {
        let d = [value, -value, value % 3].map(|value| Measured::exact(f64::from(value)));
        Sample { at: UtcMicros(at), seat: Seat::default(), station: 0, d }
    }

    /// By sorting: what is left without the lowest, and without the highest.
    fn by_sorting(values: &[f64]) -> (usize, usize, f64) {
        let place = |wanted: f64| values.iter().position(|value| *value == wanted).expect("it is one of them");
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len() - 1;
        let left = (sorted[last] - sorted[1]).min(sorted[last - 1] - sorted[0]);
        (place(sorted[0]), place(sorted[last]), left)
    }

    proptest! {
        #[test]
        fn late_records_and_forgotten_ones_leave_the_cells_that_all_records_make(
            hours in prop::collection::vec(1_i64..200, 30..300),
            late in prop::collection::vec(0_usize..20, 0..4),
            repaired in 0.0..1.0,
        ) {
            let hour = |hours: i64| hours * 3_600_000_000;
            let mut at = 0;
            let all: Vec<Sample> = hours.iter().map(|step| { at += step; sample(hour(at), (at * 37 % 91) as i32) }).collect();
            let marks = vec![Mark::of(UtcMicros((repaired * hour(at) as f64) as i64), Event::Repair)];
            let is_late = |k: usize| late.iter().any(|late| k + 1 + late == all.len());
            let mut series = Series::new(Vec::new(), marks.clone());
            all.iter().enumerate().filter(|(k, _)| !is_late(*k)).for_each(|(_, sample)| series.push(*sample));
            series.insert(all.iter().enumerate().filter(|(k, _)| is_late(*k)).map(|(_, sample)| *sample));
            let whole = Series::new(all.clone(), marks);
            prop_assert_eq!(series.cells(), whole.cells());
            series.forget(all.len() - 1);
            let left = series.cells();
            prop_assert_eq!(left, &whole.cells()[whole.cells().len() - left.len()..]);
            prop_assert!(left.len() >= cells::looked_at(whole.cells(), all[all.len() - 1].at));
            let parts = whole.undisturbed_cells().count();
            let parted = all[0].at < whole.marks()[0].at;
            prop_assert_eq!(parts, 1 + usize::from(parted && whole.marks()[0].at <= all[all.len() - 1].at));
        }

        #[test]
        fn every_stretch_has_the_extremes_that_sorting_finds(
            values in prop::collection::vec(-40..40, 2..700),
            late in prop::collection::vec((0.0..1.0, -60..60), 0..4),
            forgotten in 0.0..0.5,
            ends in prop::array::uniform2(0.0..1.0),
        ) {
            let mut series = Series::default();
            values.iter().zip(0..).for_each(|(value, at)| series.push(sample(2 * at, *value)));
            let late = late.into_iter().map(|(at, value)| (2 * (at * values.len() as f64) as i64 - 1, value));
            series.insert(late.collect::<BTreeMap<_, _>>().into_iter().rev().map(|(at, value)| sample(at, value)));
            series.forget((forgotten * values.len() as f64) as usize);
            prop_assert!(series.is_sorted_by_key(|there| there.at));
            let anew = Series::from(series.to_vec());
            let [a, b] = ends.map(|end| (end * series.len() as f64) as usize);
            let (start, end) = (a.min(b), a.max(b) + 1);
            for column in 0..COLUMNS {
                let found = series.extremes(column, start..end);
                prop_assert_eq!(found, anew.extremes(column, start..end));
                let of_stretch: Vec<f64> = series[start..end].iter().map(|s| s.d[column].value).collect();
                if let [_, _, ..] = of_stretch[..] {
                    let (lowest, highest, left) = by_sorting(&of_stretch);
                    prop_assert_eq!((found.lowest, found.highest), (Some(start + lowest), Some(start + highest)));
                    prop_assert_eq!(found.range_without_one(), left);
                }
            }
        }
    }
}
