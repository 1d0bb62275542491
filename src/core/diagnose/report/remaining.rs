//! What is left after adoption, tested by means that know no catalogue.
//!
//! Each test is a quadratic form `r' W r` of the residuals (`test`). `W` says which dwells should be independent:
//! neighbours in time, in temperature, of one orientation, of neighbouring orientations, of similar rates.
//! Beside them stand the spread against the noise floor and repeats against the rest.

use nalgebra::DMatrix;

use crate::core::campaign::Phase;
use crate::core::campaign::repeats::PureError;
use crate::core::diagnose::diagnosis::Sign;
use crate::core::diagnose::report::quadratic_form::{Score, Weights};
use crate::core::diagnose::residuals::noise_floor::pure_error;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::Setting;
use crate::core::mounting::Slot;
use crate::core::numerics::basis::{Basis, dot};
use crate::core::numerics::normal::normal_cdf;
use crate::core::numerics::tails::f_tail;

/// What one test says of one gyro, or of all together where `gyro` is none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tested {
    pub kind: &'static str,
    pub gyro: Option<usize>,
    pub p_value: f64,
}

/// Residuals of each gyro with all that was fitted to them.
pub(crate) struct FittedResiduals<'a> {
    pub frame: &'a Frame,
    /// Adopted columns, beyond the model's.
    pub extras: &'a [Basis],
    /// Whitened.
    pub residuals: &'a [Vec<f64>],
}

impl FittedResiduals<'_> {
    fn basis(&self, j: usize) -> DMatrix<f64> {
        self.frame.gyros[j].basis.with(&self.extras[j]).matrix(self.frame.dwells())
    }

    fn dof(&self, j: usize) -> f64 {
        (self.frame.gyros[j].dof() - self.extras[j].rank().min(self.frame.gyros[j].dof())) as f64
    }

    /// Every test of every gyro, and of all gyros together.
    pub fn tests(&self) -> Vec<Tested> {
        // Rounding has patterns of its own.
        let rounded =
            |j: usize| dot(&self.residuals[j], &self.residuals[j]) <= self.frame.noise.rounding[j] * self.dof(j);
        if (0..self.residuals.len()).all(rounded) {
            return Vec::new();
        }
        let bases: Vec<DMatrix<f64>> = (0..self.residuals.len()).map(|j| self.basis(j)).collect();
        let mut tests = Vec::new();
        for (kind, weights) in structure_weights(&self.frame.setting) {
            let scores: Vec<Score> = (0..bases.len())
                .map(|j| weights.test(&bases[j], self.dof(j)).map_or(Score::NONE, |it| it.score(&self.residuals[j])))
                .collect();
            tests.extend(scores.iter().enumerate().map(|(j, score)| Tested {
                kind,
                gyro: Some(j),
                p_value: score.p_value(),
            }));
            if scores.len() > 1 {
                tests.push(Tested { kind, gyro: None, p_value: Score::together(&scores).p_value() });
            }
        }
        tests.extend(self.spread());
        tests.extend(self.lack_of_fit());
        tests
    }

    /// A named cause must have its form: `columns`, whitened, hold what it would leave if it had another, and are
    /// tested against the rest of the residual (F).
    pub fn of_form(&self, kind: &'static str, j: usize, columns: Vec<Vec<f64>>) -> Option<Tested> {
        let mut basis = self.frame.gyros[j].basis.clone();
        for vector in self.extras[j].vectors() {
            basis.push(vector.clone());
        }
        let fitted = basis.rank();
        for column in columns {
            basis.push(column);
        }
        let beyond = basis.split_off(fitted);
        let residual = &self.residuals[j];
        let power: f64 = beyond.vectors().iter().map(|v| dot(v, residual).powi(2)).sum();
        let (columns, rest) = (beyond.rank() as f64, self.dof(j) - beyond.rank() as f64);
        let f = power / columns / ((dot(residual, residual) - power).max(0.0) / rest);
        (columns > 0.0 && rest >= 1.0 && f.is_finite()).then(|| Tested {
            kind,
            gyro: Some(j),
            p_value: f_tail(f, columns, rest),
        })
    }

    /// Scatter against the stated standard errors, corrected by what repeats say of them: of each gyro, and of all
    /// together, whose factor is taken for a common one. Beside a name they are not corrected: it may be what is left of
    /// something that scatters in repeats as well.
    fn spread(&self) -> Vec<Tested> {
        if !self.frame.noise.stated {
            return Vec::new();
        }
        let is_named = self.extras.iter().any(|extra| extra.rank() > 0);
        let mut tests = Vec::new();
        let (mut of_all, mut repeats_of_all) = ((0.0, 0.0), PureError::default());
        for (j, (gyro, residual)) in self.frame.gyros.iter().zip(self.residuals).enumerate() {
            let repeats = if is_named { PureError::default() } else { pure_error(self.frame, gyro, residual) };
            let rest = (dot(residual, residual) - repeats.chi2, self.dof(j) - repeats.dof as f64);
            if rest.1 >= 1.0 {
                tests.push(Tested { kind: SPREAD, gyro: Some(j), p_value: beyond_stated(rest, repeats) });
                of_all = (of_all.0 + rest.0, of_all.1 + rest.1);
                repeats_of_all = repeats_of_all.plus(repeats);
            }
        }
        if tests.len() > 1 {
            tests.push(Tested { kind: SPREAD, gyro: None, p_value: beyond_stated(of_all, repeats_of_all) });
        }
        tests
    }

    /// Scatter between orientations and rates against scatter within repeats: the classical lack-of-fit F.
    fn lack_of_fit(&self) -> Vec<Tested> {
        let (mut between, mut within, mut between_dof, mut within_dof) = (0.0, 0.0, 0.0, 0.0);
        let mut tests = Vec::new();
        for (j, gyro) in self.frame.gyros.iter().enumerate() {
            let pure = pure_error(self.frame, gyro, &self.residuals[j]);
            let rss = dot(&self.residuals[j], &self.residuals[j]);
            let dof = self.dof(j) - pure.dof as f64;
            if pure.dof == 0 || dof < 1.0 || pure.chi2 <= 0.0 {
                continue;
            }
            let lack = (rss - pure.chi2).max(0.0);
            tests.push(Tested {
                kind: "lack_of_fit",
                gyro: Some(j),
                p_value: f_tail(lack / dof / (pure.chi2 / pure.dof as f64), dof, pure.dof as f64),
            });
            // Gyros of different noise are put on one scale by all of their scatter.
            let scale = rss / self.dof(j);
            between += lack / scale;
            within += pure.chi2 / scale;
            between_dof += dof;
            within_dof += pure.dof as f64;
        }
        if tests.len() > 1 {
            let f = between / between_dof / (within / within_dof);
            tests.push(Tested { kind: "lack_of_fit", gyro: None, p_value: f_tail(f, between_dof, within_dof) });
        }
        tests
    }
}

pub(super) const SPREAD: &str = "spread";

/// By how much the standard errors of a whole campaign may be wrong (standard deviation of the logarithm), and how
/// often that is so. Single ones scatter more, but that averages out. Without repeats the first is taken: a campaign
/// whose scatter lies a fifth above what its station states has a gap, in its dwells or in its standard errors.
const WRONG_BY: [(f64, f64); 2] = [(0.07, 0.8), (0.25, 0.2)];

/// Repeats that scatter less than this over what is stated speak against it no more.
const LEAST_OF_REPEATS: f64 = 0.3;

/// Probability that noise scatters as much as `rest`, a sum of squares over the stated variances and its degrees of
/// freedom. Each way in which these may be wrong counts as much as it makes the repeats likely, and is corrected by
/// them (the logarithm of a mean square of nu degrees of freedom has the mean -1/nu and the variance 2/nu + 2/nu^2).
fn beyond_stated((sum, dof): (f64, f64), repeats: PureError) -> f64 {
    let repeated = repeats.dof as f64;
    let seen = (repeats.chi2 / repeated).max(LEAST_OF_REPEATS).ln() + 1.0 / repeated;
    let of_repeats = 2.0 / repeated + 2.0 / repeated.powi(2);
    let (mut p_value, mut weights) = (0.0, 0.0);
    for (factor, often) in WRONG_BY.into_iter().take(if repeats.dof > 0 { WRONG_BY.len() } else { 1 }) {
        let stated = (2.0 * factor).powi(2);
        let (weight, corrected, unsure) = match repeats.dof {
            0 => (1.0, 0.0, stated),
            _ => {
                let both = stated + of_repeats;
                let weight = often * (-0.5 * seen * seen / both).exp() / both.sqrt();
                (weight, (seen * stated / both).max(0.0), stated * of_repeats / both)
            }
        };
        let excess = (sum / dof).max(1e-300).ln() - corrected;
        p_value += weight * normal_cdf(-excess / (unsure + 2.0 / dof).sqrt());
        weights += weight;
    }
    if weights > 0.0 { p_value / weights } else { 1.0 }
}

/// Weight of all tests of spread together: the one test that compares no dwells.
const SPREAD_WEIGHT: f64 = 0.3;

/// Probability that something significant is left, over all tests: Cauchy's combination (Liu and Xie 2020), weighted,
/// which holds whatever the tests share.
pub(crate) fn combined(tests: &[Tested]) -> f64 {
    use std::f64::consts::PI;
    let spread = tests.iter().filter(|test| test.kind == SPREAD).count();
    let others = tests.len() - spread;
    let (mut sum, mut weights) = (0.0, 0.0);
    for test in tests {
        let weight =
            if test.kind == SPREAD { SPREAD_WEIGHT / spread as f64 } else { (1.0 - SPREAD_WEIGHT) / others as f64 };
        let p = test.p_value.clamp(1e-15, 1.0 - 1e-3);
        sum += weight * if p < 1e-8 { 1.0 / (p * PI) } else { ((0.5 - p) * PI).tan() };
        weights += weight;
    }
    if tests.is_empty() {
        return 1.0;
    }
    let mean: f64 = sum / weights;
    if mean > 1e6 { 1.0 / (mean * PI) } else { 0.5 - mean.atan() / PI }
}

/// Tests as signs, the strongest first, one a kind, where they alone would be significant among all.
pub(crate) fn signs(tests: &[Tested], slots: &[Slot], level: f64) -> Vec<Sign> {
    let mut signs: Vec<Sign> = Vec::new();
    let mut order: Vec<&Tested> = tests.iter().collect();
    order.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    for test in order {
        let p_value = (test.p_value * tests.len() as f64).min(1.0);
        let seen = signs.iter_mut().find(|sign| sign.kind == test.kind);
        match (seen, test.gyro) {
            _ if p_value > level => break,
            (Some(sign), Some(j)) if !sign.slots.contains(&slots[j]) => sign.slots.push(slots[j]),
            (Some(_), _) => {}
            (None, gyro) => {
                let of = gyro.map_or_else(|| slots.to_vec(), |j| vec![slots[j]]);
                signs.push(Sign::of_no_dwell(test.kind, of, p_value));
            }
        }
    }
    signs
}

/// Pairs of dwells that a gap would make alike, row by row; zero diagonal.
fn structure_weights(s: &Setting) -> Vec<(&'static str, Weights)> {
    let n = s.dwells();
    let pairs = |like: &dyn Fn(usize, usize) -> f64| {
        Weights::new(DMatrix::from_fn(n, n, |a, b| if a == b { 0.0 } else { like(a.min(b), a.max(b)) }))
    };
    let rested = |k: usize| s.phase[k] == Phase::Static;
    let alike = |yes: bool| f64::from(u8::from(yes));
    let mut kinds = vec![
        ("neighbours_in_time", pairs(&|a, b| alike(b - a == 1))),
        ("runs_in_time", pairs(&|a, b| (-((b - a) as f64 / 5.0)).exp())),
        (
            "same_specific_force",
            pairs(&|a, b| alike(rested(a) && rested(b) && (s.force[a] - s.force[b]).norm() < 1e-3)),
        ),
        (
            "neighbouring_orientations",
            pairs(&|a, b| {
                let apart = s.force[a].angle(&s.force[b]);
                if rested(a) && rested(b) && apart > 1e-3 { (-(apart / 0.5).powi(2)).exp() } else { 0.0 }
            }),
        ),
        (
            "similar_rates",
            pairs(&|a, b| {
                let (p, q) = (s.rate[a].norm(), s.rate[b].norm());
                alike(!rested(a) && !rested(b) && (s.rate[a] - s.rate[b]).norm() < 0.3 * p.max(q))
            }),
        ),
        ("same_orientation_before", pairs(&|a, b| alike(a > 0 && (s.force[a - 1] - s.force[b - 1]).norm() < 1e-3))),
    ];
    if let Some(t) = s.temperature.as_ref().filter(|t| t.iter().any(|x| *x != 0.0)) {
        let width = 0.15 * (dot(t, t) / n as f64).sqrt();
        kinds.push(("similar_temperatures", pairs(&|a, b| (-((t[a] - t[b]) / width).powi(2)).exp())));
    }
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_beyond_what_is_stated_is_a_gap_unless_repeats_scatter_as_much() {
        // ln 1.5 over sqrt(0.14^2 + 2/200) = 2.357: 0.0092 of a normal distribution.
        let alone = beyond_stated((300.0, 200.0), PureError::default());
        assert!((alone - 0.0092).abs() < 1e-4, "{alone}");
        let repeats = |times: f64| PureError { chi2: 27.0 * times, dof: 27 };
        // Standard errors three quarters of the noise.
        let with = beyond_stated((356.0, 200.0), repeats(1.78));
        assert!(with > 0.05 && beyond_stated((356.0, 200.0), PureError::default()) < 1e-3, "{with}");
        // The power of an effect with d = 15.
        let gap = beyond_stated((425.0, 200.0), repeats(1.0));
        assert!(gap < 2e-3, "{gap}");
        assert!(beyond_stated((200.0, 200.0), repeats(0.5)) > 0.3, "repeats that scatter less by chance are no gap");
    }
}
