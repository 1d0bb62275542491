//! Two causes that hide one another from a search that takes one at a time: a slope and the step that brings it back.

use crate::core::numerics::basis::dot;

use super::candidates::CandidateCause;
use super::fitted_rows::FittedRows;

/// Share of two columns' squared lengths below which nothing tells them apart.
const APART: f64 = 1e-4;

/// Significance of two together against a coefficient that wanders: walks look like two steps more often than like one.
/// Of 1,800 that move a coefficient by three to nine standard deviations none gets a name by it.
const TOGETHER: f64 = 3e-6;

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
    // By candidate and model: the column off what is named, b and g.
    let off = |k: &usize| -> Vec<Vec<f64>> {
        white[*k].iter().enumerate().map(|(m, column)| fitted.projected(m, column)).collect()
    };
    let columns: Vec<Vec<Vec<f64>>> = known.iter().map(off).collect();
    let along = |(m, column): (usize, &Vec<f64>)| [dot(column, &fitted.left[m]), dot(column, column)];
    let along: Vec<Vec<[f64; 2]>> = columns.iter().map(|all| all.iter().enumerate().map(along).collect()).collect();
    // ln L under white noise and as the mean over all models, where so much is taken of the squares of each.
    let evidence = |taken: &dyn Fn(usize) -> f64| {
        let ln_likelihood = |m: usize| fitted.ln_likelihood(m, (fitted.squares[m] - taken(m)).max(0.0));
        [ln_likelihood(0), fitted.mean(ln_likelihood)]
    };
    let of_one =
        |along: &Vec<[f64; 2]>| evidence(&|m| if along[m][1] > 0.0 { along[m][0].powi(2) / along[m][1] } else { 0.0 });
    let one: Vec<[f64; 2]> = along.iter().map(of_one).collect();
    let of_two = |a: usize, b: usize, m: usize| {
        let ([b_a, g_a], [b_b, g_b], g_ab) = (along[a][m], along[b][m], dot(&columns[a][m], &columns[b][m]));
        let determinant = g_a * g_b - g_ab * g_ab;
        let taken = (b_a * b_a * g_b - 2.0 * b_a * b_b * g_ab + b_b * b_b * g_a) / determinant;
        if determinant > APART * g_a * g_b { taken } else { 0.0 }
    };
    let none = [fitted.white(), fitted.evidence()];
    let is_significant = |after: [f64; 2], before: [f64; 2], more: f64, tried: [usize; 2], levels: [f64; 2]| {
        (0..2).all(|k| fitted.significance(after[k] - before[k], more) * (tried[k] as f64) < levels[k])
    };
    let mut leads: Option<(f64, [usize; 2])> = None;
    for (a, b) in (0..known.len()).flat_map(|a| (a + 1..known.len()).map(move |b| (a, b))) {
        let two = evidence(&|m| of_two(a, b, m));
        if leads.is_some_and(|(most, _)| two[1] <= most) {
            continue;
        }
        let tried = [a, b].map(|k| pool[known[k]].tried);
        let beside =
            |k: usize, other: usize| is_significant(two, one[other], 1.0, [kinds * tried[k], tried[k]], levels);
        let of_both = tried[0] * tried[1];
        let together = [levels[0], TOGETHER];
        if beside(0, b) && beside(1, a) && is_significant(two, none, 2.0, [kinds * kinds * of_both, of_both], together)
        {
            leads = Some((two[1], [known[a], known[b]]));
        }
    }
    leads.map(|(_, pair)| pair)
}
