//! Laws by which the noise of a dwell may go beside what is stated: with its duration, its rate, or the time.

use nalgebra::Vector3;

use super::growth::SLOW_ARCSEC_S;
use super::noise_found::LawFound;
use crate::core::campaign::Dwell;
use crate::core::numerics::median::median_of;

/// Prior probability that the noise goes as stated; the laws share the rest.
pub const AS_STATED: f64 = 0.8;

/// Share by which durations must differ to say anything of how noise goes with them, as a logarithm.
const OTHER_DURATION: f64 = 0.2;

/// What the laws take of the dwells.
#[derive(Debug, Clone)]
pub struct DwellConditions {
    /// Of the middle of each dwell, s.
    pub times: Vec<f64>,
    pub durations: Vec<f64>,
    pub rates: Vec<Vector3<f64>>,
    /// g0.
    pub forces: Vec<Vector3<f64>>,
}

/// By how much the standard deviation of a dwell departs from what is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Times (median duration/duration)^power.
    Duration(f64),
    /// Times sqrt(1 + (growth w/top)^2), w the rate.
    Rate(f64),
    /// Times exp(growth x), x the time from -1/2 to 1/2 of the campaign.
    Time(f64),
}

impl DwellConditions {
    /// Of the dwells of a campaign.
    pub fn of(dwells: &[Dwell]) -> Self {
        Self {
            times: dwells.iter().map(Dwell::mid_s).collect(),
            durations: dwells.iter().map(|d| d.duration_s).collect(),
            rates: dwells.iter().map(|d| d.rate_arcsec_s).collect(),
            forces: dwells.iter().map(|d| d.specific_force_g0).collect(),
        }
    }

    fn usual_duration(&self) -> f64 {
        median_of(self.durations.iter().copied()).unwrap_or(1.0)
    }

    fn top(&self) -> f64 {
        self.rates.iter().map(|w| w.norm()).fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// What is tried of growth with rate and in time.
const RATES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
const GROWTHS: [f64; 4] = [-1.1, -0.55, 0.55, 1.1];

impl Law {
    /// Those that these dwells let tell apart.
    pub fn all(course: &DwellConditions) -> Vec<Self> {
        let usual = course.usual_duration();
        let unequal = course.durations.iter().any(|d| (d / usual).ln().abs() > OTHER_DURATION);
        let durations = [0.25, 0.5].into_iter().filter(|_| unequal).map(Self::Duration);
        let turns = course.top() > SLOW_ARCSEC_S;
        let rates = RATES.into_iter().filter(|_| turns).map(Self::Rate);
        durations.chain(rates).chain(GROWTHS.map(Self::Time)).collect()
    }

    /// On the standard deviation of each dwell.
    pub fn factors(self, course: &DwellConditions) -> Vec<f64> {
        match self {
            Self::Duration(power) => {
                let usual = course.usual_duration();
                course.durations.iter().map(|d| (usual / d).powf(power)).collect()
            }
            Self::Rate(growth) => {
                let top = course.top();
                course.rates.iter().map(|w| (1.0 + (growth * w.norm() / top).powi(2)).sqrt()).collect()
            }
            Self::Time(growth) => {
                let (first, last) = (course.times[0], course.times[course.times.len() - 1]);
                let span = (last - first).max(f64::MIN_POSITIVE);
                course.times.iter().map(|t| (growth * ((t - first) / span - 0.5)).exp()).collect()
            }
        }
    }

    /// The law as answers say it: the power of duration, or by how many times the noise grows to the fastest rate or to
    /// the end.
    pub fn found(self) -> LawFound {
        match self {
            Self::Duration(power) => LawFound::Duration { power },
            Self::Rate(growth) => {
                LawFound::Rate { times: (1.0 + growth * growth).sqrt(), is_bound: growth >= RATES[3] }
            }
            Self::Time(growth) => LawFound::Time { times: growth.exp(), is_bound: growth.abs() >= GROWTHS[3] },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise_found::NoiseFound;
    use super::*;
    use crate::words::Language;

    const TIMES: [f64; 5] = [100.0, 200.0, 300.0, 400.0, 500.0];

    fn turning(arcsec_s: [f64; 5]) -> Vec<Vector3<f64>> {
        arcsec_s.map(|rate| Vector3::new(0.0, -rate, 0.0)).to_vec()
    }

    #[test]
    fn laws_go_with_duration_rate_and_time_as_defined() {
        let course = DwellConditions {
            times: TIMES.to_vec(),
            durations: vec![50.0, 100.0, 200.0, 400.0, 100.0],
            rates: turning([0.0, 40.0, 80.0, 20.0, 10.0]),
            forces: Vec::new(),
        };
        let close = |found: Vec<f64>, expected: [f64; 5]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} is not {expected:?}");
        };
        close(Law::Duration(0.5).factors(&course), [2.0, 1.0, 0.5, 0.25, 1.0].map(f64::sqrt));
        close(Law::Rate(2.0).factors(&course), [1.0, 2.0, 5.0, 1.25, 1.0625].map(f64::sqrt));
        close(Law::Time(1.1).factors(&course), [-0.55, -0.275, 0.0, 0.275, 0.55].map(f64::exp));
        assert_eq!(Law::Duration(0.25).found(), LawFound::Duration { power: 0.25 });
        assert_eq!(Law::Rate(2.0).found(), LawFound::Rate { times: 5.0_f64.sqrt(), is_bound: false });
        assert_eq!(Law::Time(-1.1).found(), LawFound::Time { times: (-1.1_f64).exp(), is_bound: true });
    }

    #[test]
    fn growth_at_the_end_of_what_is_tried_is_said_as_a_bound() {
        let said = |law: Law| {
            let found = NoiseFound { laws: vec![law.found()], ..NoiseFound::default() };
            [Language::English, Language::Chinese].map(|language| language.words(&found.notes()[0]))
        };
        for (law, [english, chinese]) in [
            (Law::Rate(4.0), ["the noise is about 4.1 or more times as large at the fastest", "静止时的4.1倍或更大"]),
            (Law::Rate(2.0), ["the noise is 2.2 times as large at the fastest", "时噪声为静止时的2.2倍"]),
            (Law::Time(1.1), ["the noise is about 3.0 or more times as large at the end", "开始时的3.0倍或更大"]),
            (Law::Time(-1.1), ["the noise is about 0.3 or less times as large at the end", "开始时的0.3倍或更小"]),
            (Law::Time(0.55), ["the noise is 1.7 times as large at the end", "时噪声为开始时的1.7倍"]),
        ] {
            let [in_english, in_chinese] = said(law);
            assert!(in_english.starts_with(english) && in_chinese.contains(chinese), "{in_english} {in_chinese}");
        }
    }

    #[test]
    fn only_laws_that_the_dwells_can_show_are_tried() {
        let of = |durations: [f64; 5], rates: [f64; 5]| {
            let (times, durations, rates) = (TIMES.to_vec(), durations.to_vec(), turning(rates));
            Law::all(&DwellConditions { times, durations, rates, forces: Vec::new() })
        };
        let (even, still) = ([100.0, 100.0, 110.0, 90.0, 100.0], [0.0, 15.0, 15.0, 0.0, 15.0]);
        assert_eq!(of(even, still), [-1.1, -0.55, 0.55, 1.1].map(Law::Time), "noise may grow as well as fall");
        let laws = of([100.0, 100.0, 100.0, 100.0, 200.0], still);
        assert_eq!(laws[..2], [Law::Duration(0.25), Law::Duration(0.5)]);
        assert_eq!(of([100.0, 100.0, 100.0, 100.0, 60.0], still), laws, "shorter or longer");
        assert_eq!(of(even, [0.0, 0.0, 25.0, 0.0, 0.0])[..4], [0.5, 1.0, 2.0, 4.0].map(Law::Rate));
    }
}
