//! Two causes that hide one another from a search that takes one at a time: a slope and the step that brings it back.

use crate::core::numerics::basis::dot;
use crate::core::numerics::log_sum::LogSum;

use super::candidates::CandidateCause;
use super::fitted_rows::FittedRows;

/// Share of two columns' squared lengths below which nothing tells them apart.
const APART: f64 = 1e-4;

/// Significance of two together against a coefficient that wanders: walks look like two steps more often than like one.
/// Of 1,800 that move a coefficient by three to nine standard deviations none gets a name by it.
const TOGETHER: f64 = 3e-6;

/// ln L with one candidate or two, under white noise and as its mean over all models.
#[derive(Clone, Copy, Default)]
struct Evidence {
    white: f64,
    others: LogSum,
}

impl Evidence {
    fn add(&mut self, model: usize, ln_likelihood: f64) {
        if model == 0 {
            self.white = ln_likelihood;
        } else {
            self.others.add(ln_likelihood);
        }
    }

    fn mean(&self, others: usize) -> f64 {
        LogSum::of(&[self.white, self.others.log_mean(others)]).log() - std::f64::consts::LN_2
    }
}

/// The two candidates of the largest evidence, where each is significant beside the other and both together are,
/// against white noise and against a coefficient that wanders (`levels` of each), corrected for all that was tried.
/// With columns `c_a`, `c_b` whitened and off what is named, `r` what is left, `b = c'r` and `g = c'c`, they take
/// `(b_a^2 g_bb - 2 b_a b_b g_ab + b_b^2 g_aa)/(g_aa g_bb - g_ab^2)` of its squares. A regressor that is not known
/// everywhere takes no part.
pub(super) fn best(
    fitted: &FittedRows,
    pool: &[CandidateCause],
    white: &[Vec<Vec<f64>>],
    levels: [f64; 2],
    kinds: usize,
) -> Option<[usize; 2]> {
    let known: Vec<usize> = (0..pool.len()).filter(|k| pool[*k].missing.is_empty()).collect();
    if fitted.n < fitted.parameters() + 4 {
        return None;
    }
    let count = known.len();
    let mut one = vec![Evidence::default(); count];
    let mut two = vec![Evidence::default(); count * count];
    for (m, basis) in fitted.bases.iter().enumerate() {
        let columns: Vec<Vec<f64>> = (known.iter())
            .map(|k| {
                let mut column = white[*k][m].clone();
                basis.project_out(&mut column);
                column
            })
            .collect();
        let along: Vec<[f64; 2]> =
            columns.iter().map(|column| [dot(column, &fitted.left[m]), dot(column, column)]).collect();
        let ln_likelihood = |taken: f64| fitted.ln_likelihood(m, (fitted.squares[m] - taken).max(0.0));
        for a in 0..count {
            let [b_a, g_a] = along[a];
            one[a].add(m, ln_likelihood(if g_a > 0.0 { b_a * b_a / g_a } else { 0.0 }));
            for b in a + 1..count {
                let ([b_b, g_b], g_ab) = (along[b], dot(&columns[a], &columns[b]));
                let determinant = g_a * g_b - g_ab * g_ab;
                let apart = determinant > APART * g_a * g_b;
                let taken = (b_a * b_a * g_b - 2.0 * b_a * b_b * g_ab + b_b * b_b * g_a) / determinant;
                two[a * count + b].add(m, ln_likelihood(if apart { taken } else { 0.0 }));
            }
        }
    }
    let others = fitted.models.len() - 1;
    let is_significant = |pair: &Evidence, before: [f64; 2], more: f64, tried: [usize; 2], levels: [f64; 2]| {
        let p = |gain: f64, tried: usize| fitted.significance(gain, more) * tried as f64;
        p(pair.white - before[0], tried[0]) < levels[0] && p(pair.mean(others) - before[1], tried[1]) < levels[1]
    };
    let mut leads: Option<(f64, [usize; 2])> = None;
    for (a, b) in (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))) {
        let pair = &two[a * count + b];
        let evidence = pair.mean(others);
        if leads.is_some_and(|(most, _)| evidence <= most) {
            continue;
        }
        let tried = [a, b].map(|k| pool[known[k]].tried);
        let beside = |k: usize, other: usize| {
            let before = [one[other].white, one[other].mean(others)];
            is_significant(pair, before, 1.0, [kinds * tried[k], tried[k]], levels)
        };
        let none = [fitted.white(), fitted.evidence()];
        let of_both = tried[0] * tried[1];
        let needed = beside(0, b)
            && beside(1, a)
            && is_significant(pair, none, 2.0, [kinds * kinds * of_both, of_both], [levels[0], TOGETHER]);
        if needed {
            leads = Some((evidence, [known[a], known[b]]));
        }
    }
    leads.map(|(_, pair)| pair)
}
