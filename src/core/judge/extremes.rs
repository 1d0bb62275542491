//! The extremes of figures in a row, and how those of two stretches make those of both.

/// The extremes of a stretch of figures, which stand at places `P`, and what would be the extremes without them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extremes<P> {
    /// Place of the lowest figure, of the first where several are alike. None where there are no figures.
    pub lowest: Option<P>,
    /// Place of the highest.
    pub highest: Option<P>,
    min: f64,
    second_min: f64,
    max: f64,
    second_max: f64,
}

impl<P: Copy> Extremes<P> {
    /// Those of nothing at all.
    pub const NONE: Self = Self {
        lowest: None,
        highest: None,
        min: f64::INFINITY,
        second_min: f64::INFINITY,
        max: f64::NEG_INFINITY,
        second_max: f64::NEG_INFINITY,
    };

    /// Of figures at their places, in order.
    pub fn of(figures: impl Iterator<Item = (P, f64)>) -> Self {
        figures.fold(Self::NONE, |found, (place, x)| {
            found.and(Self { lowest: Some(place), highest: Some(place), min: x, max: x, ..Self::NONE })
        })
    }

    /// Of both stretches, `later` being the later one.
    pub fn and(self, later: Self) -> Self {
        let (lowest, min, second_min) = if later.min < self.min {
            (later.lowest, later.min, self.min.min(later.second_min))
        } else {
            (self.lowest, self.min, self.second_min.min(later.min))
        };
        let (highest, max, second_max) = if later.max > self.max {
            (later.highest, later.max, self.max.max(later.second_max))
        } else {
            (self.highest, self.max, self.second_max.max(later.max))
        };
        Self { lowest, highest, min, second_min, max, second_max }
    }

    /// At other places.
    pub fn at<Q>(self, place: impl Fn(P) -> Q) -> Extremes<Q> {
        let Self { lowest, highest, min, second_min, max, second_max } = self;
        Extremes { lowest: lowest.map(&place), highest: highest.map(&place), min, second_min, max, second_max }
    }

    /// The smaller of the two ranges that remain when the lowest or the highest figure is left out. Of two figures or
    /// more.
    pub fn range_without_one(&self) -> f64 {
        (self.max - self.second_min).min(self.second_max - self.min)
    }
}
