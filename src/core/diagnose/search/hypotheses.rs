//! Every hypothesis of the search with its regressors, whitened and with the model in use projected out.
//!
//! A hypothesis is a catalogue entry, or a competitor, at one value of its non-linear parameter. Its columns sit side
//! by side with all others in one matrix a gyro, so that one product with a residual scores the whole catalogue.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use nalgebra::{DMatrix, DVector, DVectorView, Matrix3};

use crate::core::augmented::Adopted;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::{COMPETITORS, Effect, Entry, Prior, Scope, Shape};
use crate::core::numerics::basis::{Basis, dot, scale};

/// Share of an effect's whitened power below which the design does not show it (amplitude below one in a thousand).
pub(crate) const INVISIBLE: f64 = 1e-6;

/// Prior power, in squared standard deviations, of each coefficient of a flat hypothesis along a unit column, by the
/// number of coefficients: effects at the limit of detection (d = 5 is 25 in all), above it and of any size, whatever the
/// number. Without the last, a prior that knows no strong effects would rather have a strong one explained by a
/// competitor with many columns.
const FLAT_POWER: [[f64; 3]; 4] = [[10.0, 50.0, 1e5], [5.0, 25.0, 5e4], [3.0, 16.0, 3.3e4], [2.0, 10.0, 2e4]];
/// Most columns of a block whose systems are solved on the stack: the search has millions of them.
pub(crate) const SMALL: usize = 3;

/// Prior power of a whole smooth hypothesis.
const SMOOTH_POWER: [f64; 3] = [30.0, 150.0, 800.0];

#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub kind: Effect,
    pub shape: Shape,
    /// Logarithm of the share of the kind's prior weight.
    pub log_weight: f64,
    pub common: bool,
    pub powers: &'static [f64],
    /// Per gyro: its columns in the gyro's matrix.
    pub blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub start: usize,
    pub len: usize,
    /// Squared lengths of the columns, which are orthogonal to one another; empty where all are 1.
    pub lengths: Vec<f64>,
    /// Products of the columns with one another, where there are at most [`SMALL`].
    pub gram: Matrix3<f64>,
    /// Sum of ln(1 + power x length) over the columns, for each of the hypothesis' powers.
    pub log_dets: Vec<f64>,
    /// Share of the raw columns' whitened power that is left.
    pub visible: f64,
}

impl Block {
    fn empty(start: usize, visible: f64) -> Self {
        Self { start, len: 0, lengths: Vec::new(), gram: Matrix3::zeros(), log_dets: Vec::new(), visible }
    }

    /// Squared length of column `i`.
    pub fn length(&self, i: usize) -> f64 {
        self.lengths.get(i).copied().unwrap_or(1.0)
    }
}

#[derive(Debug)]
pub(crate) struct Bank {
    /// Sorted by kind; contract entries before competitors.
    pub hypotheses: Vec<Hypothesis>,
    /// Ranges of `hypotheses` of one kind each.
    pub kinds: Vec<(Effect, Range<usize>)>,
    /// Per gyro: dwells x columns.
    pub columns: Vec<DMatrix<f64>>,
    /// Number of leading columns that belong to contract entries, per gyro.
    pub contract_columns: Vec<usize>,
    /// Per gyro: its whitened residual under the model in use.
    residuals: Vec<Vec<f64>>,
    /// By gyro and factor, as far as they were asked for.
    products: RefCell<HashMap<(usize, Factor), Rc<DVector<f64>>>>,
}

/// What the columns of a gyro are multiplied with: something of one of the gyros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Factor {
    Residual(usize),
    /// A column of its matrix.
    Column(usize, usize),
}

/// Raw columns of one hypothesis, before projection.
#[derive(Clone)]
struct Raw {
    kind: Effect,
    shape: Shape,
    log_weight: f64,
    common: bool,
    prior: Prior,
    columns: Vec<Vec<Vec<f64>>>,
}

/// What is asked of a campaign and its model in use, whatever the noise.
pub(crate) struct Candidates {
    raws: Vec<Raw>,
    /// Number of leading ones that are contract entries.
    contract: usize,
}

impl Candidates {
    /// Contract entries that could be a cause for this model, each with the shapes of its grid and those of `more`,
    /// and all competitors.
    pub fn of(frame: &Frame, more: &[(Effect, Shape)]) -> Self {
        Self::against(frame, more, |entry| !entry.only_closer)
    }

    /// The same with competitors that are asked only where something would be named.
    pub fn closer(frame: &Frame, more: &[(Effect, Shape)]) -> Self {
        Self::against(frame, more, |_| true)
    }

    fn against(frame: &Frame, more: &[(Effect, Shape)], asked: impl Fn(&Entry) -> bool) -> Self {
        let mut raws: Vec<Raw> = Vec::new();
        for entry in frame.nameable().filter(|entry| could_be_a_cause(frame, entry)) {
            push_shapes(&mut raws, frame, entry, more);
        }
        let contract = raws.len();
        for entry in COMPETITORS.into_iter().filter(|entry| asked(entry)) {
            push_shapes(&mut raws, frame, entry, more);
        }
        if !frame.hypotheses.is_empty() {
            let (named, competing) = raws.split_at(contract);
            let kept: Vec<Raw> =
                competing.iter().filter(|raw| !named.iter().any(|own| is_what_is(own, raw))).cloned().collect();
            raws.truncate(contract);
            raws.extend(kept);
        }
        Self { raws, contract }
    }
}

impl Bank {
    /// `candidates` under the noise of `frame`.
    pub fn of(frame: &Frame, candidates: &Candidates) -> Self {
        let Candidates { raws, contract } = candidates;
        let mut hypotheses: Vec<Hypothesis> = raws
            .iter()
            .map(|raw| Hypothesis {
                kind: raw.kind,
                shape: raw.shape,
                log_weight: raw.log_weight,
                common: raw.common,
                powers: match raw.prior {
                    Prior::Flat => &FLAT_POWER[raw.columns[0].len().clamp(1, FLAT_POWER.len()) - 1],
                    Prior::Smooth => &SMOOTH_POWER,
                },
                blocks: Vec::new(),
            })
            .collect();
        let mut columns = Vec::new();
        let mut contract_columns = Vec::new();
        for j in 0..frame.gyros.len() {
            let (matrix, blocks) = project_gyro(frame, j, raws);
            contract_columns.push(blocks[..*contract].last().map_or(0, |block| block.start + block.len));
            for (hypothesis, block) in hypotheses.iter_mut().zip(blocks) {
                hypothesis.blocks.push(block);
            }
            columns.push(matrix);
        }
        for hypothesis in hypotheses.iter_mut() {
            scale_together(hypothesis, &mut columns);
        }
        let residuals = frame.gyros.iter().map(|gyro| gyro.residual.clone()).collect();
        let products = RefCell::default();
        Self { kinds: kinds_of(&hypotheses), hypotheses, columns, contract_columns, residuals, products }
    }

    /// Products of all columns of gyro `j` with one factor.
    pub fn products(&self, j: usize, factor: Factor) -> Rc<DVector<f64>> {
        if let Some(known) = self.products.borrow().get(&(j, factor)) {
            return Rc::clone(known);
        }
        let products = Rc::new(match factor {
            Factor::Residual(i) => self.columns[j].tr_mul(&DVector::from_column_slice(&self.residuals[i])),
            Factor::Column(i, c) => self.columns[j].tr_mul(&self.column(i, c)),
        });
        self.products.borrow_mut().insert((j, factor), Rc::clone(&products));
        products
    }

    /// The projected, whitened columns of a hypothesis in a gyro, each n long.
    pub fn columns_of(&self, hypothesis: usize, gyro: usize) -> impl Iterator<Item = DVectorView<'_, f64>> {
        let block = &self.hypotheses[hypothesis].blocks[gyro];
        (block.start..block.start + block.len).map(move |index| self.column(gyro, index))
    }

    /// One projected, whitened column of a gyro, n long; `index` counts in its matrix.
    pub fn column(&self, gyro: usize, index: usize) -> DVectorView<'_, f64> {
        self.columns[gyro].column(index)
    }
}

/// Whether dwell residuals may show it and the model in use does not hold it.
fn could_be_a_cause(frame: &Frame, entry: &Entry) -> bool {
    let common = |adopted: &Adopted| adopted.effect == entry.effect && entry.scope == Scope::Common;
    let held = frame.terms.iter().any(|term| term.name() == entry.id) || frame.adopted.iter().any(common);
    !held && !entry.closure_only && (entry.missing)(&frame.setting).is_none()
}

/// An entry at the shapes of its grid and at those of `more` that are its own.
fn push_shapes(raws: &mut Vec<Raw>, frame: &Frame, entry: &Entry, more: &[(Effect, Shape)]) {
    let own = more.iter().filter(|(effect, _)| *effect == entry.effect).map(|(_, shape)| (*shape, 1.0));
    let shapes: Vec<(Shape, f64)> = (entry.shapes)(&frame.setting).into_iter().chain(own).collect();
    let total: f64 = shapes.iter().map(|(_, weight)| weight).sum();
    for (shape, weight) in shapes {
        raws.push(Raw {
            kind: entry.effect,
            shape,
            log_weight: (entry.standing as f64 * weight / total).ln(),
            common: entry.scope == Scope::Common,
            prior: entry.prior,
            columns: (0..frame.gyros.len()).map(|j| (entry.columns)(&frame.setting, j, shape)).collect(),
        });
    }
}

/// Whether a competitor is, in every gyro, a hypothesis of one's own: who asks for it by name is not told that it is
/// something without a name.
fn is_what_is(own: &Raw, competitor: &Raw) -> bool {
    let same = |(own, competitor): (&Vec<Vec<f64>>, &Vec<Vec<f64>>)| {
        let span = Basis::of(own.iter().cloned());
        own.len() == competitor.len()
            && competitor.iter().all(|column| {
                let mut left = column.clone();
                span.project_out(&mut left);
                dot(&left, &left) <= 1e-12 * dot(column, column)
            })
    };
    own.kind.hypothesis().is_some() && own.columns.iter().zip(&competitor.columns).all(same)
}

/// One gyro's matrix: everything whitened, the model's basis projected out twice, flat blocks made orthonormal.
fn project_gyro(frame: &Frame, j: usize, raws: &[Raw]) -> (DMatrix<f64>, Vec<Block>) {
    let gyro = &frame.gyros[j];
    let n = frame.dwells();
    let total: usize = raws.iter().map(|raw| raw.columns[j].len()).sum();
    let mut matrix = DMatrix::zeros(n, total);
    let mut before = Vec::with_capacity(total);
    let columns = raws.iter().flat_map(|raw| &raw.columns[j]);
    for (column, target) in columns.zip(matrix.as_mut_slice().chunks_exact_mut(n)) {
        target.iter_mut().zip(column).zip(&gyro.sd).for_each(|((target, x), sd)| *target = x / sd);
    }
    if let Some(unlike) = &gyro.unlike {
        matrix = unlike * matrix;
    }
    for target in matrix.as_mut_slice().chunks_exact_mut(n) {
        // Coefficients have units from 1 to 1e-14: bring every column to unit length first.
        let norm = dot(target, target).sqrt();
        if norm > 0.0 && norm.is_finite() {
            scale(1.0 / norm, target);
        } else {
            target.fill(0.0);
        }
        before.push(norm);
    }
    let q = gyro.basis.matrix(n);
    let q_transposed = q.transpose();
    for _ in 0..2 {
        let along = &q_transposed * &matrix;
        matrix.gemm(-1.0, &q, &along, 1.0);
    }
    let mut blocks = Vec::with_capacity(raws.len());
    let mut kept = 0;
    let mut next = 0;
    let columns = matrix.as_mut_slice();
    for raw in raws {
        let len = raw.columns[j].len();
        let range = next..next + len;
        next += len;
        let block = match raw.prior {
            _ if raw.common => keep_as_is(columns, n, range, &before, kept),
            Prior::Smooth => keep_as_is(columns, n, range, &before, kept),
            Prior::Flat => keep_orthonormal(columns, n, range, kept),
        };
        kept += block.len;
        blocks.push(block);
    }
    (matrix.resize_horizontally(kept, 0.0), blocks)
}

/// Moves the columns of `range` to `kept..`, at their raw lengths relative to the longest; columns have `n` numbers.
fn keep_as_is(columns: &mut [f64], n: usize, range: Range<usize>, before: &[f64], kept: usize) -> Block {
    let len = range.len();
    let raw: f64 = range.clone().map(|c| before[c] * before[c]).sum();
    let mut left = 0.0;
    for (i, c) in range.enumerate() {
        columns.copy_within(c * n..(c + 1) * n, (kept + i) * n);
        let column = &mut columns[(kept + i) * n..][..n];
        scale(before[c], column);
        left += dot(column, column);
    }
    let visible = if raw > 0.0 { left / raw } else { 0.0 };
    let shown = visible > INVISIBLE;
    let lengths = if shown { vec![0.0; len] } else { Vec::new() };
    Block { len: if shown { len } else { 0 }, lengths, ..Block::empty(kept, visible) }
}

/// Orthonormal columns with the span of `range`, at `kept..`; fewer where some of it is invisible.
fn keep_orthonormal(columns: &mut [f64], n: usize, range: Range<usize>, kept: usize) -> Block {
    let count = range.len().max(1) as f64;
    let (mut own, mut visible) = (Basis::default(), 0.0);
    for c in range {
        let column = &columns[c * n..][..n];
        let before = dot(column, column);
        visible += before / count;
        if before > INVISIBLE {
            // A column that the block's others span already brings rounding only.
            own.push_beyond(column.to_vec(), 1e-9 * before);
        }
    }
    for (target, vector) in columns[kept * n..].chunks_exact_mut(n).zip(own.vectors()) {
        target.copy_from_slice(vector);
    }
    Block { len: own.rank(), ..Block::empty(kept, visible) }
}

/// Gives common and smooth blocks a stated total power and turns their columns so that they are orthogonal; a common
/// hypothesis has one turn for all gyros only if it has one column, so its Gram matrices are kept apart.
fn scale_together(hypothesis: &mut Hypothesis, columns: &mut [DMatrix<f64>]) {
    let scaled = hypothesis.blocks.iter().any(|block| !block.lengths.is_empty());
    if scaled {
        let powers: Vec<f64> = (hypothesis.blocks.iter().zip(columns.iter()))
            .map(|(block, columns)| columns.columns(block.start, block.len).norm_squared())
            .collect();
        let widest = hypothesis.blocks.iter().map(|block| block.len).max().unwrap_or(0) as f64;
        for (j, block) in hypothesis.blocks.iter_mut().enumerate() {
            // A common hypothesis keeps the proportions between gyros; a smooth one has unit power in each.
            let size = if hypothesis.common { powers.iter().sum::<f64>() / widest } else { powers[j] };
            if size > 0.0 {
                let mut view = columns[j].columns_mut(block.start, block.len);
                view.scale_mut(1.0 / size.sqrt());
            }
            if !hypothesis.common {
                make_orthogonal(block, &mut columns[j]);
            }
        }
    }
    for (block, columns) in hypothesis.blocks.iter_mut().zip(columns.iter()) {
        block.log_dets = (hypothesis.powers.iter())
            .map(|power| (0..block.len).map(|i| (power * block.length(i)).ln_1p()).sum())
            .collect();
        if block.len <= SMALL && block.lengths.is_empty() {
            (0..block.len).for_each(|i| block.gram[(i, i)] = 1.0);
        } else if block.len <= SMALL {
            let own = columns.columns(block.start, block.len);
            for i in 0..block.len {
                (0..block.len).for_each(|j| block.gram[(i, j)] = own.column(i).dot(&own.column(j)));
            }
        }
    }
}

/// Turns a block's columns to the principal axes of their Gram matrix and drops those without power.
fn make_orthogonal(block: &mut Block, columns: &mut DMatrix<f64>) {
    // A block that the design hides altogether has no axes.
    if block.len == 0 {
        return;
    }
    let view = columns.columns(block.start, block.len).into_owned();
    let axes = (view.transpose() * &view).symmetric_eigen();
    let mut order: Vec<usize> = (0..block.len).collect();
    order.sort_by(|&a, &b| axes.eigenvalues[b].total_cmp(&axes.eigenvalues[a]));
    order.retain(|&i| axes.eigenvalues[i] > 1e-4);
    for (place, &i) in order.iter().enumerate() {
        columns.set_column(block.start + place, &(&view * axes.eigenvectors.column(i)));
    }
    block.lengths = order.iter().map(|&i| axes.eigenvalues[i]).collect();
    block.len = order.len();
}

fn kinds_of(hypotheses: &[Hypothesis]) -> Vec<(Effect, Range<usize>)> {
    let mut kinds: Vec<(Effect, Range<usize>)> = Vec::new();
    for (i, hypothesis) in hypotheses.iter().enumerate() {
        match kinds.last_mut() {
            Some((kind, range)) if *kind == hypothesis.kind => range.end = i + 1,
            _ => kinds.push((hypothesis.kind, i..i + 1)),
        }
    }
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::augmented::Options;
    use crate::core::diagnose::search::bayes_factor::scores;
    use crate::core::diagnose::search::projections::{Extra, state};
    use crate::core::effects::{HypothesisDefinition, OwnHypothesis, own};

    fn own_of(id: &str, equation: &str, unit: &str) -> Effect {
        let written = HypothesisDefinition {
            id: id.into(),
            words: id.into(),
            cause: id.into(),
            equation: equation.into(),
            unit: unit.into(),
            plausible: 100.0,
            typical: [1e-3, 1e-2],
            common: false,
            range: None,
        };
        own(OwnHypothesis::of(written).unwrap()).unwrap()
    }

    fn frame(hypotheses: Vec<Effect>) -> Frame {
        let campaign = std::fs::read("tests/data/practice/campaign-02.json").unwrap();
        let campaign = crate::wire::campaign::parse_json(&campaign).unwrap();
        Frame::of(&campaign, &Options { hypotheses, ..Options::default() }).unwrap()
    }

    #[test]
    fn a_hypothesis_that_is_an_entry_has_its_evidence() {
        let twins = [
            ("temperature_bias", own_of("own_bias", "k * T", "deg/h/K")),
            ("temperature_scale", own_of("own_scale", "k * T * w_I", "1/K")),
            ("time_ramp", own_of("own_ramp", "k * t", "deg/h/h")),
            ("hysteresis", own_of("own_set", "k * a_O_before", "deg/(h g0)")),
        ];
        let frame = frame(twins.iter().map(|(_, own)| *own).collect());
        let bank = Bank::of(&frame, &Candidates::of(&frame, &[]));
        let state = state(&frame, vec![Extra::default(); frame.gyros.len()]);
        let scores = scores(&bank, &state);
        let evidence = |id: &str| scores.iter().find(|score| score.kind.id() == id).unwrap().log_evidence;
        for (id, own) in twins {
            let (theirs, mine) = (evidence(id), evidence(own.id()));
            assert!((theirs - mine).abs() < 1e-6 * theirs.abs().max(1.0), "{id}: {theirs} {mine}");
        }
        assert!(evidence("temperature_bias") > 20.0);
    }

    #[test]
    fn a_competitor_that_somebody_asks_for_by_name_competes_no_more() {
        let kinds = |hypotheses: Vec<Effect>| {
            let frame = frame(hypotheses);
            Bank::of(&frame, &Candidates::of(&frame, &[]))
                .hypotheses
                .iter()
                .map(|h| (h.kind.id(), h.shape))
                .collect::<Vec<_>>()
        };
        let slope = |kinds: &[(&str, Shape)]| kinds.iter().filter(|(id, _)| *id == "temperature_rate").count();
        let (plain, asked) = (kinds(Vec::new()), kinds(vec![own_of("own_slope", "k * dT/dt", "deg/K")]));
        assert_eq!((slope(&plain), slope(&asked)), (2, 1));
        assert_eq!(asked.len(), plain.len(), "one more, one less");
    }
}
