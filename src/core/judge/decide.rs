//! Conformity with uncertainty: exceeded, within, or indeterminate with the probability (after JCGM 106:2012, 7-8).

use std::f64::consts::SQRT_2;

use statrs::function::erf::erfc;

use super::State;
use super::history::Measured;

/// The standard normal distribution function.
pub(crate) fn normal_cdf(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

/// Judges |difference| against `limit`. With a standard deviation, the probability is that of |true difference| >
/// limit for a true difference ~ N(value, sd^2), and a verdict is reached where it passes `confidence` or falls
/// below 1 - confidence. Without one, the figures are compared as they stand.
pub(crate) fn beyond(difference: Measured, limit: f64, confidence: f64) -> (State, Option<f64>) {
    let Some(sd) = difference.sd.filter(|&sd| sd > 0.0) else {
        return (plain(difference.value.abs(), limit), None);
    };
    let above = normal_cdf((difference.value - limit) / sd);
    let below = normal_cdf((-limit - difference.value) / sd);
    let probability = (above + below).min(1.0);
    (by_probability(probability, confidence), Some(probability))
}

pub(crate) fn plain(value: f64, limit: f64) -> State {
    if value > limit { State::Exceeded } else { State::Within }
}

pub(crate) fn by_probability(probability: f64, confidence: f64) -> State {
    if probability >= confidence {
        State::Exceeded
    } else if probability <= 1.0 - confidence {
        State::Within
    } else {
        State::Indeterminate
    }
}
