//! Temperatures of the dwells that can be relied on.
//!
//! A thermometer that fails states a value far from its neighbours: 999, -273.15, 0, the 85 of a sensor after
//! power-up. A thermal mass does not jump and come back between two dwells, so a dwell outside the range of the
//! medians of those before and of those after it is left out; a ramp, a step and a cycle stay within.

use super::Campaign;
use crate::core::numerics::median::median_of;

/// Dwells on either side that a temperature is held against: three faults in a row are seen.
const BESIDE: usize = 5;

/// Smallest departure that is no temperature, K; and in typical steps from dwell to dwell.
const DEPARTURE_K: f64 = 5.0;
const DEPARTURE_STEPS: f64 = 10.0;

/// At either end of the campaign, where only one side speaks, so many times as much.
const AT_AN_END: f64 = 3.0;

/// What failing or unread sensors state, deg C.
const FAULT_VALUES: [f64; 10] = [-999.0, -273.15, -273.0, -127.0, -55.0, 0.0, 85.0, 127.0, 999.0, 1000.0];

/// Share of dwells with a temperature below which none is believed in between.
const LEAST_SHARE: f64 = 0.5;

/// Temperatures of which a calibration that states none may have had any, deg C: those that IMUs are specified for.
const ANY_TEMPERATURE: [f64; 2] = [-40.0, 85.0];

/// Steps that a mean over [`ANY_TEMPERATURE`] is taken in (Simpson): an even number.
const STEPS: usize = 20;

/// What a temperature that nobody states may be less `reference_c`, K, with weights that add up to 1: a rectangular
/// distribution (GUM 2008, 4.3.7).
pub fn any_kelvin(reference_c: f64) -> impl Iterator<Item = (f64, f64)> {
    let [low, high] = ANY_TEMPERATURE;
    (0..=STEPS).map(move |i| {
        let weight = match i {
            0 | STEPS => 1.0,
            _ => 2.0 + 2.0 * (i % 2) as f64,
        };
        let celsius = low + (high - low) * i as f64 / STEPS as f64;
        (celsius - reference_c, weight / (3 * STEPS) as f64)
    })
}

/// The temperatures of a campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Temperatures {
    /// By dwell, deg C; between dwells where one states none that can be relied on. None where too few do.
    pub filled: Option<Vec<f64>>,
    /// Dwells whose temperature is a sensor's fault value, and what they state.
    pub outliers: Vec<(usize, f64)>,
    /// Median of the others.
    pub median: f64,
}

impl Temperatures {
    /// Sets fault values of the sensor aside and fills gaps along the times of the dwells.
    pub fn of(campaign: &Campaign) -> Self {
        let stated: Vec<Option<f64>> = campaign.dwells.iter().map(|d| d.temperature_c).collect();
        let outliers = outliers(&stated);
        let mut known = stated;
        for (k, _) in &outliers {
            known[*k] = None;
        }
        let times: Vec<f64> = campaign.dwells.iter().map(|d| d.mid_s()).collect();
        let median = median_of(known.iter().copied().flatten()).unwrap_or(0.0);
        Self { filled: filled(&times, &known), outliers, median }
    }

    /// By dwell, deg C; of the whole campaign where its dwells state none. What varies within it is not to be had then.
    pub fn stated(campaign: &Campaign) -> Option<Vec<f64>> {
        let of_all = || campaign.temperature_c.map(|t| vec![t; campaign.dwells.len()]);
        Self::of(campaign).filled.or_else(of_all)
    }
}

fn outliers(stated: &[Option<f64>]) -> Vec<(usize, f64)> {
    let known: Vec<(usize, f64)> = stated.iter().enumerate().filter_map(|(k, t)| Some((k, (*t)?))).collect();
    let steps = known.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs());
    let room = DEPARTURE_K.max(DEPARTURE_STEPS * median_of(steps).unwrap_or(0.0));
    let is_fault = |t: f64| FAULT_VALUES.contains(&t);
    let beside = |others: &mut dyn Iterator<Item = &(usize, f64)>| {
        median_of(others.map(|(_, t)| *t).filter(|t| !is_fault(*t)).take(BESIDE))
    };
    let departs = |i: usize| {
        let t = known[i].1;
        let sides = [beside(&mut known[..i].iter().rev()), beside(&mut known[i + 1..].iter())];
        let distances = || sides.iter().flatten().map(|side| t - side);
        // With one side alone a step or a steep ramp at the end looks the same.
        let room = if sides.iter().flatten().count() == 2 { room } else { AT_AN_END * room };
        let nearest = distances().fold(f64::INFINITY, |least, d| least.min(d.abs()));
        let same_side = distances().all(|d| d > 0.0) || distances().all(|d| d < 0.0);
        nearest.is_finite() && same_side && nearest > room
    };
    (0..known.len()).filter(|i| departs(*i)).map(|i| known[i]).collect()
}

fn filled(times: &[f64], known: &[Option<f64>]) -> Option<Vec<f64>> {
    let there: Vec<(f64, f64)> = times.iter().zip(known).filter_map(|(time, t)| Some((*time, (*t)?))).collect();
    if there.is_empty() || (there.len() as f64) < LEAST_SHARE * times.len() as f64 {
        return None;
    }
    let between = |time: f64| {
        let after = there.partition_point(|(t, _)| *t < time);
        match (there[..after].last(), there.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (time - a.0) / (b.0 - a.0),
            (Some(only), None) | (None, Some(only)) => only.1,
            (None, None) => 0.0,
        }
    };
    Some(times.iter().zip(known).map(|(time, t)| t.unwrap_or_else(|| between(*time))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(temperatures: &[f64]) -> Vec<usize> {
        let stated: Vec<Option<f64>> = temperatures.iter().map(|t| Some(*t)).collect();
        outliers(&stated).into_iter().map(|(k, _)| k).collect()
    }

    #[test]
    fn fault_values_of_a_sensor_are_found_wherever_they_stand() {
        let calm: Vec<f64> = (0..40).map(|k| 45.0 + 0.6 * (f64::from(k) * 0.7).sin()).collect();
        assert_eq!(found(&calm), [0; 0]);
        for fault in [999.0, -273.15, 0.0, 85.0, 78.0, -999.0, 62.0] {
            for places in [vec![0], vec![39], vec![17], vec![5, 6], vec![5, 20, 33], vec![10, 11, 12]] {
                let mut broken = calm.clone();
                places.iter().for_each(|k| broken[*k] = fault);
                assert_eq!(found(&broken), places, "{fault}");
            }
        }
        let mut long = calm.clone();
        (10..30).for_each(|k| long[k] = 85.0);
        assert_eq!(found(&long), (10..30).collect::<Vec<_>>(), "a run of a known fault value");
    }

    #[test]
    fn real_courses_of_temperature_are_left_alone() {
        let courses: [(&str, Vec<f64>); 7] = [
            ("ramp of a chamber", (0..30).map(|k| 1.0 + 2.25 * f64::from(k)).collect()),
            ("ramp through zero and 85", (0..60).map(|k| -20.0 + 2.0 * f64::from(k)).collect()),
            ("step", (0..40).map(|k| if k < 17 { 25.0 } else { 60.0 }).collect()),
            ("steps", (0..40).map(|k| 10.0 * f64::from(k / 8) + 0.1 * f64::from(k).sin()).collect()),
            ("cycle", (0..40).map(|k| 45.0 + 4.0 * (f64::from(k) * 0.9).sin()).collect()),
            ("warm-up", (0..40).map(|k| 45.0 - 22.0 * (-f64::from(k) / 6.0).exp()).collect()),
            ("constant", vec![45.0; 12]),
        ];
        for (name, course) in courses {
            assert_eq!(found(&course), [0; 0], "{name}");
        }
    }

    #[test]
    fn a_temperature_that_nobody_states_is_anywhere_between_the_ends_alike() {
        // 125 K wide, its mean 22.5 deg C: 36.084 K about it, 42.524 K about 45 deg C.
        let mean = |power: i32| any_kelvin(22.5).map(|(kelvin, weight)| weight * kelvin.powi(power)).sum::<f64>();
        assert!((mean(0) - 1.0).abs() < 1e-12 && mean(1).abs() < 1e-12);
        let rms = |reference_c| any_kelvin(reference_c).map(|(k, weight)| weight * k * k).sum::<f64>().sqrt();
        assert!((rms(22.5) - 36.084).abs() < 1e-3 && (rms(45.0) - 42.524).abs() < 1e-3);
        // 62.5^4/5 about the middle.
        assert!((mean(4) / (62.5_f64.powi(4) / 5.0) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_missing_temperature_is_between_its_neighbours() {
        let times = [0.0, 100.0, 400.0, 500.0];
        assert_eq!(filled(&times, &[Some(40.0), None, Some(44.0), None]), Some(vec![40.0, 41.0, 44.0, 44.0]));
        assert_eq!(filled(&times, &[Some(40.0), None, None, None]), None, "one of four is too few");
        assert_eq!(filled(&times, &[None; 4]), None);
    }
}
