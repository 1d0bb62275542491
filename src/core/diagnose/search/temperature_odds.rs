//! That temperature is suspected first where it moved.

use crate::core::effects::Setting;

/// Change of temperature within a campaign that is usual, K; what each further kelvin adds to the ln of prior odds;
/// and the most of it.
const USUAL_K: f64 = 10.0;
const ODDS_PER_K: f64 = 0.5;
const MOST_ODDS: f64 = 25.0;

/// ln of prior odds of temperature against other causes, noise with a memory among them.
pub(super) fn odds_of_temperature(s: &Setting) -> f64 {
    let Some(temperature) = &s.temperature else { return 0.0 };
    let extremes = temperature.iter().fold((0.0_f64, 0.0_f64), |(low, high), t| (low.min(*t), high.max(*t)));
    (ODDS_PER_K * (extremes.1 - extremes.0 - USUAL_K)).clamp(0.0, MOST_ODDS)
}
