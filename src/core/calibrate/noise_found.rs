//! What is found of the noise beyond white, independent and as stated, by a fit or a diagnosis.

use crate::core::message::{Message, figure, signed, significant};
use crate::core::mounting::Slot;
use crate::message;

/// What is found of the noise; empty where it is white, independent and as stated, or where nothing asked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NoiseFound {
    /// Correlations of gyros.
    pub between_gyros: Vec<(Slot, Slot, f64)>,
    pub memory: Option<CorrelatedNoiseFound>,
    pub laws: Vec<LawFound>,
}

/// A bias that wanders from dwell to dwell.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelatedNoiseFound {
    /// `flicker` or `random_walk`, whichever is likelier.
    pub kind: &'static str,
    /// Its standard deviation in each gyro, of a random walk at mid-campaign.
    pub deg_per_h: Vec<(Slot, f64)>,
    /// That there is any.
    pub probability: f64,
}

/// How the noise goes where the standard errors do not say so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawFound {
    /// It falls with duration to this power.
    Duration { power: f64 },
    /// So many times as large at the fastest rate as at rest.
    Rate { times: f64, is_bound: bool },
    /// So many times as large at the end as at the beginning.
    Time { times: f64, is_bound: bool },
}

impl LawFound {
    /// Whether that is the most that is tried: the noise may grow, or fall, by more. Nearly as much may pass for it.
    pub fn is_bound(self) -> bool {
        matches!(self, Self::Rate { is_bound: true, .. } | Self::Time { is_bound: true, .. })
    }

    /// In words.
    pub fn message(self) -> Message {
        match self {
            Self::Duration { power } => message!("noise_of_duration", power = figure(power, 2)),
            Self::Rate { times, is_bound } => {
                message!("noise_of_rate", times = figure(times, 1), bound = bound(times, is_bound))
            }
            Self::Time { times, is_bound } => {
                message!("noise_of_time", times = figure(times, 1), bound = bound(times, is_bound))
            }
        }
    }

    /// Laws found one beside the other, each kind as one: powers add, factors multiply.
    pub(crate) fn together(laws: impl Iterator<Item = Self>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for law in laws {
            let joined = all.iter_mut().any(|held| match (held, law) {
                (Self::Duration { power }, Self::Duration { power: more }) => {
                    *power += more;
                    true
                }
                (Self::Rate { times, is_bound }, Self::Rate { times: more, is_bound: last })
                | (Self::Time { times, is_bound }, Self::Time { times: more, is_bound: last }) => {
                    (*times, *is_bound) = (*times * more, last);
                    true
                }
                _ => false,
            });
            if !joined {
                all.push(law);
            }
        }
        all
    }
}

impl CorrelatedNoiseFound {
    /// Standard deviation in the gyro that wanders most, deg/h.
    pub fn largest(&self) -> f64 {
        self.deg_per_h.iter().map(|(_, size)| *size).fold(0.0, f64::max)
    }
}

impl NoiseFound {
    /// Whether nothing is said of the noise: white, as stated, each gyro by itself.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The correlation of the two gyros that share most noise; none where none is said.
    pub fn largest_correlation(&self) -> Option<f64> {
        let correlations = self.between_gyros.iter().map(|(.., correlation)| *correlation);
        correlations.max_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// In words.
    pub(crate) fn notes(&self) -> Vec<Message> {
        let mut notes = Vec::new();
        notes.extend(self.largest_correlation().map(|r| message!("noise_shared", correlation = signed(r, 2))));
        notes.extend(self.memory.as_ref().map(|memory| {
            let probability = figure(memory.probability.min(0.999), 3);
            message!("noise_memory", probability, size = significant(memory.largest(), 2))
        }));
        notes.extend(self.laws.iter().map(|law| law.message()));
        notes
    }
}

/// On which side the true growth may lie where what is said is the most that is tried.
fn bound(times: f64, is_bound: bool) -> &'static str {
    match is_bound {
        true if times > 1.0 => "least",
        true => "most",
        false => "none",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn laws_of_one_kind_are_said_as_one() {
        let rate = |times, is_bound| LawFound::Rate { times, is_bound };
        let time = |times, is_bound| LawFound::Time { times, is_bound };
        let laws = [rate(2.0, true), time(3.0, true), rate(1.5, false), time(3.0, true)];
        assert_eq!(LawFound::together(laws.into_iter()), [rate(3.0, false), time(9.0, true)]);
        let durations = [0.25, 0.5].map(|power| LawFound::Duration { power });
        assert_eq!(LawFound::together(durations.into_iter()), [LawFound::Duration { power: 0.75 }]);
    }

    #[test]
    fn the_size_of_a_wander_is_said_in_two_digits() {
        for (size, said) in [(0.046_744_88, "0.047 deg/h"), (123.4, "123 deg/h"), (4.56e-6, "0.0000046 deg/h")] {
            let memory = CorrelatedNoiseFound { kind: "flicker", deg_per_h: vec![(Slot::G1, size)], probability: 0.99 };
            let found = NoiseFound { memory: Some(memory), ..NoiseFound::default() };
            let words = Language::English.words(&found.notes()[0]);
            assert!(words.contains(&format!("about {said}")), "{words}");
        }
    }
}
