//! Records that a rule looks back to and that are not there one by one any more.

use super::extremes::Extremes;
use super::sample::{COLUMNS, Measured, Sample};
use crate::core::time::UtcMicros;

/// A figure and when it was measured.
pub(crate) type Figure = (UtcMicros, Measured);

/// How many records there are in a stretch, and the extremes of each column of [`Sample::d`]: all that `range` asks
/// of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Older {
    pub(crate) records: usize,
    pub(crate) extremes: [Extremes<Figure>; COLUMNS],
}

impl Older {
    pub const NONE: Self = Self { records: 0, extremes: [Extremes::NONE; COLUMNS] };

    /// Of records in the order of time.
    pub fn of(samples: &[Sample]) -> Self {
        let of_column = |column: usize| {
            let figures = samples.iter().map(|sample| (sample.at, sample.d[column]));
            Extremes::of(figures.map(|figure| (figure, figure.1.value)))
        };
        Self { records: samples.len(), extremes: std::array::from_fn(of_column) }
    }

    /// Of both stretches, `later` being the later one.
    #[must_use]
    pub fn and(self, later: &Self) -> Self {
        let extremes = std::array::from_fn(|column| self.extremes[column].and(later.extremes[column]));
        Self { records: self.records + later.records, extremes }
    }
}
