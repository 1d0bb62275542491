//! What else physics and table work produce, beyond the contract: competitors and signs, never names.
//!
//! A contract entry that merely resembles one of these must not get its name, so they take part in the search. Where
//! one of them wins, the answer says what kind of structure is there and that the catalogue does not explain it.

mod orientation;
mod rate;
mod thermal;
mod time;

use super::{Effect, Setting, Shape, Typical};

/// How the coefficients of a competitor's columns are distributed before the data speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prior {
    /// Any direction in the span of the columns alike.
    Flat,
    /// In proportion to the columns' own lengths: a smooth curve as a sum of ever smaller waves.
    Smooth,
}

/// A kind of structure outside the contract.
#[derive(Debug, Clone, Copy)]
pub struct Competitor {
    pub id: &'static str,
    /// What it looks like, for people.
    pub looks_like: &'static str,
    pub cause: &'static str,
    /// Drift added, deg/h, with the letters of the crate page.
    pub equation: &'static str,
    /// Of the coefficients.
    pub unit: &'static str,
    pub typical: Typical,
    /// What a campaign must hold for it to be told from the contract's entries.
    pub needs: &'static str,
    pub confused_with: &'static [Effect],
    pub prior: Prior,
    pub shapes: fn(&Setting) -> Vec<(Shape, f64)>,
    pub columns: fn(&Setting, usize, Shape) -> Vec<Vec<f64>>,
}

/// The competitors that follow any course of the bias in time, from smooth to a random walk.
pub const WANDERING: [&str; 3] = ["curve_in_time", "wander_in_time", "correlated_in_time"];

pub const COMPETITORS: &[&Competitor] = &[
    &time::CURVE_IN_TIME,
    &time::WANDER_IN_TIME,
    &time::CORRELATED_IN_TIME,
    &time::BEND_IN_TIME,
    &time::BURST,
    &time::DRIFTING_MASS_UNBALANCE,
    &time::DRIFTING_SCALE,
    &thermal::BENT_TEMPERATURE,
    &thermal::TEMPERATURE_RATE,
    &thermal::TEMPERATURE_LAG,
    &thermal::TEMPERATURE_AND_TIME,
    &thermal::TEMPERATURE_G_SQUARED,
    &orientation::ORIENTATION_HARMONICS,
    &orientation::FRICTION,
    &orientation::HEADING,
    &orientation::EARTH_RATE,
    &rate::RATE_EVEN,
    &rate::RATE_ODD,
    &rate::RATE_CURVE,
    &rate::RATE_AND_FORCE,
    &rate::STATIC_TO_RATE,
    &orientation::ORIENTATION_BEFORE,
    &rate::TORQUER_HEATING,
    &rate::RATE_BEFORE,
];

fn one(_: &Setting) -> Vec<(Shape, f64)> {
    vec![(Shape::Linear, 1.0)]
}

fn picked(shape: Shape) -> &'static [usize] {
    match shape {
        Shape::Only(picked) => picked,
        _ => &[],
    }
}

/// Time from -1 at the first dwell to +1 at the last.
fn mid(s: &Setting, k: usize) -> f64 {
    let span = s.span();
    if span > 0.0 { 2.0 * s.elapsed(k) / span - 1.0 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_competitor_says_what_it_is_and_what_it_passes_for() {
        let mut ids: Vec<&str> = COMPETITORS.iter().map(|competitor| competitor.id).collect();
        for competitor in COMPETITORS {
            let words =
                [competitor.looks_like, competitor.cause, competitor.equation, competitor.unit, competitor.needs];
            assert!(
                words.iter().all(|text| !text.is_empty()) && !competitor.typical.source.is_empty(),
                "{}",
                competitor.id
            );
            assert!(
                competitor.typical.low < competitor.typical.high && !competitor.confused_with.is_empty(),
                "{}",
                competitor.id
            );
            assert_eq!(Effect::from_id(competitor.id), None, "the contract's entries are no competitors");
        }
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), COMPETITORS.len());
        assert!(WANDERING.iter().all(|id| ids.contains(id)));
    }
}
