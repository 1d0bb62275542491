//! What every rule is given.

use std::f64::consts::SQRT_2;

use crate::core::judge::cells::{Points, Window};
use crate::core::judge::coefficient::Coefficient;
use crate::core::judge::decide::{Outcome, beyond};
use crate::core::judge::history::History;
use crate::core::judge::limits::{Limit, Limits};
use crate::core::judge::rule::Finding;
use crate::core::judge::rule::Rule;
use crate::core::judge::sample::{Measured, Sample};
use crate::core::judge::verdict::{State, Verdict};

/// One coefficient of the record to be judged, and the history before it.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    pub history: &'a History<'a>,
    /// Index of the judged record in `history.samples`.
    pub k: usize,
    pub coefficient: Coefficient,
    /// Its place in [`Sample::d`].
    pub column: usize,
    pub limits: &'a Limits,
    pub window: &'a Window,
}

impl<'a> Case<'a> {
    pub fn now(&self) -> &'a Sample {
        &self.history.samples[self.k]
    }

    pub fn value(&self, sample: &Sample) -> Measured {
        sample.d[self.column]
    }

    /// The records that the rule may look at, the judged one last.
    pub fn since_reset(&self, rule: Rule) -> &'a [Sample] {
        self.history.since_reset(self.k, rule)
    }

    /// The weekly means that the control rules look at, of D_I or D_S.
    pub fn points(&self) -> Points<'a> {
        self.window.column(self.column)
    }

    /// A difference of `sample` from a level of some records. Where these are of other stations, what stations differ
    /// by counts beside their own standard deviations, and is answered: a station s has the weight w_s = [s is the
    /// sample's] - its share of the records, and their offsets bring in sigma_b sqrt(sum w_s^2).
    pub fn apart(&self, difference: Measured, sample: &Sample, level: &[Sample]) -> (Measured, Option<f64>) {
        let sigma = self.between_stations();
        let share =
            |station: u32| level.iter().filter(|one| one.station == station).count() as f64 / level.len().max(1) as f64;
        let is_first = |k: usize| level[..k].iter().all(|earlier| earlier.station != level[k].station);
        let others = (0..level.len()).filter(|k| level[*k].station != sample.station && is_first(*k));
        let squares = others.map(|k| share(level[k].station).powi(2)).sum::<f64>();
        let between = sigma * ((1.0 - share(sample.station)).powi(2) + squares).sqrt();
        if level.is_empty() || between == 0.0 {
            return (difference, None);
        }
        (difference.beside(between), Some(between))
    }

    /// Standard deviation of what one station adds to the column.
    fn between_stations(&self) -> f64 {
        self.limits.between_stations.get(self.column).copied().unwrap_or(0.0)
    }

    /// Standard deviation of what two stations differ by.
    pub fn between_two_stations(&self) -> f64 {
        SQRT_2 * self.between_stations()
    }

    pub fn beyond(&self, difference: Measured, limit: f64) -> Outcome {
        beyond(difference, limit, self.limits.confidence)
    }

    pub fn exceeds(&self, difference: Measured, limit: f64) -> bool {
        self.beyond(difference, limit).state == State::Exceeded
    }

    /// Whether both lie beyond the limit, on the same side.
    pub fn both_exceed(&self, a: Measured, b: Measured, limit: f64) -> bool {
        a.value.is_sign_positive() == b.value.is_sign_positive() && self.exceeds(a, limit) && self.exceeds(b, limit)
    }

    pub fn too_few(&self, rule: Rule, limit: Limit, have: usize, need: usize) -> Verdict {
        self.nothing(rule, limit, Finding::TooFew { have, need })
    }

    pub fn nothing(&self, rule: Rule, limit: Limit, finding: Finding) -> Verdict {
        Verdict::undecided(self.coefficient, rule, limit, finding)
    }

    pub fn verdict(&self, rule: Rule, limit: Limit, value: Measured, outcome: Outcome, finding: Finding) -> Verdict {
        Verdict {
            state: outcome.state,
            value: Some(value.value.abs()),
            sd: value.sd,
            probability: outcome.probability,
            ..self.nothing(rule, limit, finding)
        }
    }
}
