//! Conformity with uncertainty: exceeded, within, or indeterminate with the probability (after JCGM 106:2012, 7-8).

use std::f64::consts::SQRT_2;

use super::extremes::Extremes;
use crate::core::judge::{Measured, State, Verdict};
use crate::core::numerics::normal::{normal_cdf, range_cdf};

/// A state, and the probability that the true value lies beyond the limit, where uncertainty is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conformity {
    pub state: State,
    pub probability: Option<f64>,
}

impl Conformity {
    /// Of a figure that is taken as it stands.
    pub fn certain(is_beyond: bool) -> Self {
        Self { state: if is_beyond { State::Exceeded } else { State::Within }, probability: None }
    }

    /// Of a figure that lies beyond its limit or not, from the probability that the true value does: uncertainty alone
    /// exceeds nothing.
    pub fn by_probability(is_beyond: bool, probability: f64, confidence: f64) -> Self {
        Self::of_side(is_beyond, [probability; 2], confidence)
    }

    /// As [`Conformity::by_probability`], where a figure may lie beyond on either side. `probabilities`: that the true value
    /// lies beyond on that of the figure, and on any. A figure whose standard deviation is far larger than what lies
    /// between the limits is beyond one of them for sure, and nobody knows which.
    fn of_side(is_beyond: bool, probabilities: [f64; 2], confidence: f64) -> Self {
        let [of_its_side, probability] = probabilities;
        let state = if is_beyond && of_its_side >= confidence {
            State::Exceeded
        } else if !is_beyond && probability <= 1.0 - confidence {
            State::Within
        } else {
            State::Indeterminate
        };
        Self { state, probability: Some(probability) }
    }

    /// The verdict that is `undecided` without it, on `value`.
    pub fn of(self, value: Measured, undecided: Verdict) -> Verdict {
        let Self { state, probability } = self;
        Verdict { state, value: Some(value.value), sd: value.sd, probability, ..undecided }
    }
}

/// Judges |difference| against `limit`.
pub(crate) fn beyond(difference: Measured, limit: f64, confidence: f64) -> Conformity {
    outside(difference, -limit, limit, confidence)
}

/// Judges whether a figure lies outside [low, high]. With a standard deviation the probability is that of a true
/// value ~ N(value, sd^2), and a verdict is reached where it passes `confidence` on the figure's side or falls below
/// 1 - confidence on both.
/// Without one, the figure is compared as it stands. A figure that lies inside never exceeds, however uncertain it
/// is.
pub(crate) fn outside(figure: Measured, low: f64, high: f64, confidence: f64) -> Conformity {
    let Measured { value, sd } = figure;
    let is_outside = value < low || value > high;
    let Some(sd) = sd.filter(|&sd| sd > 0.0) else { return Conformity::certain(is_outside) };
    let [above, below] = [normal_cdf((value - high) / sd), normal_cdf((low - value) / sd)];
    Conformity::of_side(is_outside, [above.max(below), (above + below).min(1.0)], confidence)
}

/// Two figures, the lower one first, and what each belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<T> {
    pub low: (T, Measured),
    pub high: (T, Measured),
    /// Standard deviation of what their stations differ by.
    pub between: f64,
}

impl<T> Pair<T> {
    /// High less low. Its variance holds both figures' and what their stations differ by.
    pub fn difference(&self) -> Measured {
        self.high.1.minus(self.low.1).beside(self.between)
    }

    /// Judges their difference, which is the widest among `n` figures.
    pub fn outcome(&self, n: usize, limit: f64, confidence: f64) -> Conformity {
        range_beyond(self.difference(), n, limit, confidence)
    }

    /// Excess over the limit in standard deviations, squared and with its sign: in the order of the probability to
    /// exceed. Then the difference itself.
    fn rank(&self, limit: f64) -> (f64, f64) {
        let Measured { value, sd } = self.difference();
        let excess = value - limit;
        let rank = match sd.filter(|sd| *sd > 0.0) {
            Some(sd) => (excess / sd) * (excess / sd).abs(),
            None if excess > 0.0 => f64::INFINITY,
            None => f64::NEG_INFINITY,
        };
        (rank, value)
    }
}

/// The pair that exceeds the limit with the largest probability, and the smaller of the two ranges that are left
/// without the lowest or the highest figure. None of fewer than two figures. `between`: what the stations of two differ
/// by, a standard deviation.
pub(crate) fn widest<T: Copy>(
    figures: &[(T, Measured)],
    between: impl Fn(&T, &T) -> f64,
    limit: f64,
) -> Option<(Pair<T>, f64)> {
    let pairs = figures.iter().enumerate().flat_map(|(i, a)| figures[..i].iter().map(move |b| (*b, *a)));
    let ordered = pairs.map(|(a, b)| {
        let (low, high) = if a.1.value <= b.1.value { (a, b) } else { (b, a) };
        Pair { low, high, between: between(&a.0, &b.0) }
    });
    let ranked = ordered.map(|pair| (pair.rank(limit), pair));
    let before = |a: (f64, f64), b: (f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    let (_, pair) = ranked.reduce(|best, next| if before(next.0, best.0).is_gt() { next } else { best })?;
    let extremes = Extremes::of(figures.iter().map(|(_, measured)| ((), measured.value)));
    Some((pair, extremes.range_without_one()))
}

/// Judges max - min over `n` figures, where `range` carries the standard deviation of the difference of the two
/// extremes.
///
/// The extremes were chosen because they are extreme, so the range of noisy figures is too large. Below the limit the
/// probability is that of the pair; above it, it is 1 - p/2 where p is the chance that noise alone opens the range of n
/// equal figures by the excess (Tukey's studentised range; Kramer's form for unequal standard deviations). For n = 2
/// both are the same formula.
pub(crate) fn range_beyond(range: Measured, n: usize, limit: f64, confidence: f64) -> Conformity {
    let excess = range.value - limit;
    let Some(sd) = range.sd.filter(|&sd| sd > 0.0) else { return Conformity::certain(range.value > limit) };
    let inside = normal_cdf(excess / sd) + normal_cdf((-limit - range.value) / sd);
    let probability = if excess <= 0.0 { inside } else { 1.0 - 0.5 * (1.0 - range_cdf(excess / sd * SQRT_2, n)) };
    Conformity::by_probability(excess > 0.0, probability, confidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_may_as_well_lie_beyond_the_other_limit_exceeds_none() {
        let of = |value, sd| beyond(Measured { value, sd: Some(sd) }, 0.01, 0.95);
        let unknown = of(0.56, 1.0);
        assert_eq!(unknown.state, State::Indeterminate, "1.6 sd from zero is no evidence");
        assert!(unknown.probability.unwrap() > 0.98, "though it lies beyond one of the two");
        // By hand: (value - limit)/sd = 1.6449 is 95 % on its side.
        assert_eq!([of(1.60, 1.0), of(1.66, 1.0), of(-1.66, 1.0)].map(|it| it.state), {
            use State::{Exceeded, Indeterminate};
            [Indeterminate, Exceeded, Exceeded]
        });
        assert_eq!(of(0.002, 0.003).state, State::Within);
    }

    #[test]
    fn a_range_of_two_is_the_difference_of_two() {
        let range = |value| Measured { value, sd: Some(0.002) };
        for value in [0.004, 0.009, 0.01, 0.011, 0.016] {
            let (r, d) = (range_beyond(range(value), 2, 0.01, 0.95), beyond(range(value), 0.01, 0.95));
            assert!((r.probability.unwrap() - d.probability.unwrap()).abs() < 1e-6, "{value}");
        }
    }

    #[test]
    fn the_widest_of_many_noisy_records_does_not_exceed_by_noise_alone() {
        // Thirty equal records of sd 0.004 span 0.0164 on average: more than the limit, and nothing has moved.
        let sd = Some(0.004 * SQRT_2);
        assert_eq!(range_beyond(Measured { value: 0.0164, sd }, 30, 0.01, 0.95).state, State::Indeterminate);
        assert_eq!(beyond(Measured { value: 0.0164, sd: Some(0.003) }, 0.01, 0.95).state, State::Exceeded);
    }

    #[test]
    fn pairs_rank_by_their_excess_in_standard_deviations() {
        let pair = |value: f64, sd: Option<f64>| Pair {
            low: ((), Measured { value: 0.0, sd: sd.map(|_| 0.0) }),
            high: ((), Measured { value, sd }),
            between: 0.0,
        };
        let rank = |value, sd| pair(value, sd).rank(0.01).0;
        assert!((rank(0.02, Some(0.002)) - 25.0).abs() < 1e-9);
        assert!((rank(0.004, Some(0.002)) + 9.0).abs() < 1e-9);
        assert_eq!((rank(0.02, None), rank(0.004, None)), (f64::INFINITY, f64::NEG_INFINITY));
    }
}
