//! Products of the bank's columns with residuals and with what has been adopted: all that a score is made of.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::core::diagnose::residuals::pooled_noise::{Scatter, pool};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::hypotheses::{Bank, Block, Hypothesis};
use crate::core::numerics::basis::{Basis, dot};

/// Residuals of one gyro under the model and what has been adopted so far.
#[derive(Debug, Clone)]
pub(crate) struct GyroState {
    /// Adopted columns, orthonormal and orthogonal to the model's.
    pub extra: Basis,
    pub residual: Vec<f64>,
    /// Sum of squares and degrees of freedom that say how large the noise is: stated errors counted in, and the other
    /// gyros' where they are alike.
    pub scatter: Scatter,
}

/// An IMU's gyros.
pub(crate) const MAX_GYROS: usize = 3;

pub(crate) type State = Vec<GyroState>;

/// The model in use with further columns adopted.
pub(crate) fn state(frame: &Frame, extras: Vec<Basis>) -> State {
    let mut gyros = each_by_itself(frame, extras);
    let known = from_one_another(frame, &gyros).into_iter().flatten();
    gyros.iter_mut().zip(known).for_each(|(gyro, all)| gyro.scatter = all);
    gyros
}

/// The scatter of each gyro where gyros know their noise from one another; none where each knows its own alone.
pub(crate) fn from_one_another(frame: &Frame, gyros: &State) -> Option<Vec<Scatter>> {
    let mut scatter: Vec<Scatter> = gyros.iter().map(|gyro| gyro.scatter).collect();
    (frame.noise.stated && pool(&mut scatter)).then_some(scatter)
}

/// As [`state`], with each gyro's noise from its own residuals alone: what one gyro holds is no noise in another.
pub(crate) fn each_by_itself(frame: &Frame, extras: Vec<Basis>) -> State {
    frame
        .gyros
        .iter()
        .zip(extras)
        .zip(&frame.noise.rounding)
        .map(|((gyro, extra), rounding)| {
            let mut residual = gyro.residual.clone();
            extra.project_out(&mut residual);
            let dof = (gyro.dof() - extra.rank().min(gyro.dof())) as f64;
            // What lies below rounding is no residual that anything could explain.
            let scatter = frame.noise.with_stated(dot(&residual, &residual).max(rounding * dof), dof);
            GyroState { scatter, residual, extra }
        })
        .collect()
}

/// As many rows as make the library multiply by blocks and not column by column.
const BLOCK: usize = 6;

/// Products of every column of the bank with residuals and adopted columns.
pub(crate) struct Products {
    /// Adopted x columns, so that what belongs to one column lies together.
    with_extra: Vec<DMatrix<f64>>,
    with_residual: Vec<DVector<f64>>,
    /// Gyros x columns of each gyro's bank: with every gyro's residual, what was adopted in the column's gyro taken
    /// out of it.
    pub across: Vec<DMatrix<f64>>,
}

impl Products {
    /// Of every column of the bank.
    pub fn of(bank: &Bank, state: &State) -> Self {
        Self::of_columns(bank, state, |j| 0..bank.columns[j].ncols())
    }

    /// Of the columns of some hypotheses alone; the others' products are left at zero.
    pub fn of_some(bank: &Bank, hypotheses: &[Hypothesis], state: &State) -> Self {
        Self::of_columns(bank, state, |j| columns_of(hypotheses, j))
    }

    fn of_columns(bank: &Bank, state: &State, of_gyro: impl Fn(usize) -> Range<usize>) -> Self {
        let mut all = Self { with_extra: Vec::new(), with_residual: Vec::new(), across: Vec::new() };
        let gyros = state.len();
        for (j, (gyro, columns)) in state.iter().zip(&bank.columns).enumerate() {
            let adopted = gyro.extra.rank();
            let mut rows = DMatrix::zeros((gyros + adopted).max(BLOCK), gyro.residual.len());
            for (i, other) in state.iter().enumerate() {
                let mut residual = other.residual.clone();
                if i != j {
                    gyro.extra.project_out(&mut residual);
                }
                rows.row_mut(i).copy_from_slice(&residual);
            }
            for (i, vector) in gyro.extra.vectors().iter().enumerate() {
                rows.row_mut(gyros + i).copy_from_slice(vector);
            }
            let Range { start, end } = of_gyro(j);
            let products = rows * columns.columns(start, end - start);
            let placed = |first: usize, count: usize| {
                let mut placed = DMatrix::zeros(count, columns.ncols());
                placed.columns_mut(start, end - start).copy_from(&products.rows(first, count));
                placed
            };
            let across = placed(0, gyros);
            all.with_residual.push(across.row(j).transpose());
            all.across.push(across);
            all.with_extra.push(placed(gyros, adopted));
        }
        all
    }

    /// By gyro, the products with the noise that goes with them.
    pub fn seen<'a>(&'a self, state: &State) -> Vec<Seen<'a>> {
        self.seen_in(&state.iter().map(|gyro| gyro.scatter).collect::<Vec<_>>())
    }

    /// By gyro, with the noise that each is held to have.
    pub fn seen_in<'a>(&'a self, scatter: &[Scatter]) -> Vec<Seen<'a>> {
        let of_gyro = |(j, scatter): (usize, &Scatter)| Seen {
            with_residual: self.with_residual[j].as_slice(),
            with_extra: self.with_extra[j].as_slice(),
            adopted: self.with_extra[j].nrows(),
            rss: scatter.rss,
            nu: scatter.nu,
        };
        scatter.iter().enumerate().map(of_gyro).collect()
    }
}

/// What the evidence of one gyro is made of.
pub(crate) struct Seen<'a> {
    /// Products of the gyro's columns with its residual.
    pub with_residual: &'a [f64],
    /// Products of what has been adopted with the gyro's columns, those of one column together.
    pub with_extra: &'a [f64],
    /// Number of adopted columns.
    pub adopted: usize,
    pub rss: f64,
    pub nu: f64,
}

impl Seen<'_> {
    /// Products of column `c` with what has been adopted.
    pub fn taken(&self, c: usize) -> &[f64] {
        &self.with_extra[c * self.adopted..][..self.adopted]
    }

    /// Gram matrix of a small block's columns, adopted columns projected out.
    pub fn gram(&self, block: &Block) -> Matrix3<f64> {
        let mut gram = block.gram;
        for (i, j) in (0..block.len).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let taken: f64 =
                self.taken(block.start + i).iter().zip(self.taken(block.start + j)).map(|(a, b)| a * b).sum();
            gram[(i, j)] -= taken;
            gram[(j, i)] = gram[(i, j)];
        }
        gram
    }

    /// Products of a small block's columns with the residual.
    pub fn side(&self, block: &Block) -> Vector3<f64> {
        let mut side = Vector3::zeros();
        side.as_mut_slice()[..block.len].copy_from_slice(&self.with_residual[block.start..][..block.len]);
        side
    }

    /// -nu/2 ln(1 - explained/R), safe where rounding explains a little more than there is.
    pub fn gain(&self, explained: f64) -> f64 {
        -0.5 * self.nu * (1.0 - (explained / self.rss).clamp(0.0, 1.0 - 1e-12)).ln()
    }
}

/// The columns of gyro `j` among which those of the hypotheses lie.
fn columns_of(hypotheses: &[Hypothesis], j: usize) -> Range<usize> {
    let blocks = || hypotheses.iter().map(|hypothesis| &hypothesis.blocks[j]);
    let start = blocks().map(|block| block.start).min().unwrap_or(0);
    start..blocks().map(|block| block.start + block.len).max().unwrap_or(start)
}
