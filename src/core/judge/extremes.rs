//! The extremes of figures in a row, and how those of two stretches make those of both.

/// The extremes of a stretch of figures, and what would be the extremes without them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extremes {
    /// Place of the lowest figure, of the first where several are alike.
    pub lowest: usize,
    /// Place of the highest.
    pub highest: usize,
    min: f64,
    second_min: f64,
    max: f64,
    second_max: f64,
}

impl Extremes {
    /// Those of nothing at all.
    pub const NONE: Self = Self {
        lowest: 0,
        highest: 0,
        min: f64::INFINITY,
        second_min: f64::INFINITY,
        max: f64::NEG_INFINITY,
        second_max: f64::NEG_INFINITY,
    };

    /// Of `values`, which stand at the places from `first` on.
    pub fn of(first: usize, values: impl Iterator<Item = f64>) -> Self {
        values.enumerate().fold(Self::NONE, |found, (i, x)| {
            let place = first + i;
            found.and(Self { lowest: place, highest: place, min: x, max: x, ..Self::NONE })
        })
    }

    /// Of both stretches, `later` at the greater places.
    pub fn and(self, later: Self) -> Self {
        let (lowest, min, above) = if later.min < self.min {
            (later.lowest, later.min, self.min.min(later.second_min))
        } else {
            (self.lowest, self.min, self.second_min.min(later.min))
        };
        let (highest, max, below) = if later.max > self.max {
            (later.highest, later.max, self.max.max(later.second_max))
        } else {
            (self.highest, self.max, self.second_max.max(later.max))
        };
        Self { lowest, highest, min, second_min: above, max, second_max: below }
    }

    /// The smaller of the two ranges that remain when the lowest or the highest figure is left out. Of two figures or more.
    pub fn range_without_one(&self) -> f64 {
        (self.max - self.second_min).min(self.second_max - self.min)
    }
}
