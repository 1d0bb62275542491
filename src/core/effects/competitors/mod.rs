//! What else physics and table work produce, beyond the contract: competitors and signs, never names.
//!
//! A contract entry that merely resembles one of these must not get its name, so they take part in the search. Where
//! one of them wins, the answer says what kind of structure is there and that the catalogue does not explain it.

mod entry;
mod orientation;
mod rate;
mod thermal;
mod time;

pub use entry::{Competitor, Prior};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::effects::Effect;

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
