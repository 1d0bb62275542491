//! What every rule is given.

use std::f64::consts::SQRT_2;

use crate::core::judge::cells::{Point, Window};
use crate::core::judge::decide::{Conformity, beyond};
use crate::core::judge::{Coefficient, Finding, History, Limit, Limits, Measured, Rule, Sample, State, Verdict};

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
    /// The judged record.
    pub fn now(&self) -> &'a Sample {
        &self.history.samples[self.k]
    }

    /// The coefficient of a record, deg/(h g0).
    pub fn value(&self, sample: &Sample) -> Measured {
        sample.d[self.column]
    }

    /// The records that the rule may look at, the judged one last.
    pub fn since_reset(&self, rule: Rule) -> &'a [Sample] {
        self.history.since_reset(self.k, rule)
    }

    /// The weekly means that the control rules look at, of D_I or D_S.
    pub fn points(&self) -> &'a [Point] {
        self.window.column(self.column)
    }

    /// A difference of `sample` from a level of some records. Where these are of other stations, what stations differ
    /// by counts beside their own standard deviations, and is answered.
    pub fn apart(&self, difference: Measured, sample: &Sample, level: &[Sample]) -> (Measured, Option<f64>) {
        let share = -1.0 / level.len() as f64;
        let of_level = level.iter().map(|one| (one.station, share));
        let between = self.of_stations(std::iter::once((sample.station, 1.0)).chain(of_level));
        (difference.beside(between.unwrap_or(0.0)), between)
    }

    /// What stations bring into a sum of figures whose weights w add up to zero, a standard deviation: the figures of a
    /// station share its offset, so sigma_b sqrt(sum over stations of (sum of its w)^2). None of one station.
    pub fn of_stations<S: Copy + PartialEq>(&self, figures: impl Iterator<Item = (S, f64)> + Clone) -> Option<f64> {
        let (first, _) = figures.clone().next()?;
        let sigma = self.between_stations();
        if sigma == 0.0 || figures.clone().all(|(station, _)| station == first) {
            return None;
        }
        let is_new =
            |(k, (station, _)): &(usize, (S, f64))| figures.clone().take(*k).all(|(known, _)| known != *station);
        let weight = |station: S| figures.clone().filter(|(of, _)| *of == station).map(|(_, w)| w).sum::<f64>();
        let stations = figures.clone().enumerate().filter(is_new).map(|(_, (station, _))| station);
        Some(sigma * stations.map(|station| weight(station).powi(2)).sum::<f64>().sqrt())
    }

    /// Standard deviation of what one station adds to the column.
    pub fn between_stations(&self) -> f64 {
        self.limits.between_stations.get(self.column).copied().unwrap_or(0.0)
    }

    /// Standard deviation of what two stations differ by.
    pub fn between_two_stations(&self) -> f64 {
        SQRT_2 * self.between_stations()
    }

    /// Where |`difference`| is against `limit`, both deg/(h g0), at the configured confidence.
    pub fn beyond(&self, difference: Measured, limit: f64) -> Conformity {
        beyond(difference, limit, self.limits.confidence)
    }

    /// Whether |`difference`| is beyond `limit` at that confidence.
    pub fn exceeds(&self, difference: Measured, limit: f64) -> bool {
        self.beyond(difference, limit).state == State::Exceeded
    }

    /// Whether both lie beyond the limit, on the same side.
    pub fn both_exceed(&self, a: Measured, b: Measured, limit: f64) -> bool {
        a.value.is_sign_positive() == b.value.is_sign_positive() && self.exceeds(a, limit) && self.exceeds(b, limit)
    }

    /// The verdict of a rule that needs more records than there are.
    pub fn too_few(&self, rule: Rule, limit: Limit, have: usize, need: usize) -> Verdict {
        self.nothing(rule, limit, Finding::TooFew { have, need })
    }

    /// An undecided verdict, without a value.
    pub fn nothing(&self, rule: Rule, limit: Limit, finding: Finding) -> Verdict {
        Verdict::undecided(self.coefficient, rule, limit, finding)
    }

    /// A verdict on |`value`|, deg/(h g0), with the state and probability of `outcome`.
    pub fn verdict(&self, rule: Rule, limit: Limit, value: Measured, outcome: Conformity, finding: Finding) -> Verdict {
        outcome.of(value.size(), self.nothing(rule, limit, finding))
    }
}
