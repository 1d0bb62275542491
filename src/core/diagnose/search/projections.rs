//! Products of the bank's columns with residuals and with what has been adopted: all that a score is made of.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DVector, Matrix3, Vector3};

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
    pub rss: f64,
    pub nu: f64,
}

/// An IMU's gyros.
pub(crate) const MAX_GYROS: usize = 3;

pub(crate) type State = Vec<GyroState>;

/// The model in use with further columns adopted.
pub(crate) fn state(frame: &Frame, extras: Vec<Basis>) -> State {
    let mut gyros = each_by_itself(frame, extras);
    if frame.noise.stated {
        let mut scatter: Vec<Scatter> = gyros.iter().map(|gyro| Scatter { rss: gyro.rss, nu: gyro.nu }).collect();
        pool(&mut scatter);
        gyros.iter_mut().zip(scatter).for_each(|(gyro, scatter)| (gyro.rss, gyro.nu) = (scatter.rss, scatter.nu));
    }
    gyros
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
            let Scatter { rss, nu } = frame.noise.with_stated(dot(&residual, &residual).max(rounding * dof), dof);
            GyroState { rss, nu, residual, extra }
        })
        .collect()
}

/// As many rows as make the library multiply by blocks and not column by column.
const BLOCK: usize = 6;

impl GyroState {
    /// Of every column with the residual, and with the adopted columns: adopted x columns.
    fn products(&self, columns: DMatrixView<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let adopted = self.extra.rank();
        let mut rows = DMatrix::zeros((1 + adopted).max(BLOCK), self.residual.len());
        rows.row_mut(0).copy_from_slice(&self.residual);
        for (i, vector) in self.extra.vectors().iter().enumerate() {
            rows.row_mut(1 + i).copy_from_slice(vector);
        }
        let products = rows * columns;
        (products.row(0).transpose(), products.rows(1, adopted).into_owned())
    }
}

/// Products of every column of the bank with residuals and adopted columns.
pub(crate) struct Products {
    /// Adopted x columns, so that what belongs to one column lies together.
    with_extra: Vec<DMatrix<f64>>,
    with_residual: Vec<DVector<f64>>,
}

impl Products {
    /// Of every column of the bank.
    pub fn of(bank: &Bank, state: &State) -> Self {
        let (with_residual, with_extra) =
            state.iter().zip(&bank.columns).map(|(gyro, c)| gyro.products(c.as_view())).unzip();
        Self { with_extra, with_residual }
    }

    /// Of the columns of some hypotheses alone; the others' products are left at zero.
    pub fn of_some(bank: &Bank, hypotheses: &[Hypothesis], state: &State) -> Self {
        let some = state.iter().zip(&bank.columns).enumerate().map(|(j, (gyro, columns))| {
            let Range { start, end } = columns_of(hypotheses, j);
            let (own_residual, own_extra) = gyro.products(columns.columns(start, end - start));
            let mut with_residual = DVector::zeros(columns.ncols());
            with_residual.rows_mut(start, end - start).copy_from(&own_residual);
            let mut with_extra = DMatrix::zeros(own_extra.nrows(), columns.ncols());
            with_extra.columns_mut(start, end - start).copy_from(&own_extra);
            (with_residual, with_extra)
        });
        let (with_residual, with_extra) = some.unzip();
        Self { with_extra, with_residual }
    }

    /// By gyro, the products with the residual sum of squares and the degrees of freedom that go with them.
    pub fn seen<'a>(&'a self, state: &State) -> Vec<Seen<'a>> {
        (0..state.len())
            .map(|j| Seen {
                with_residual: self.with_residual[j].as_slice(),
                with_extra: self.with_extra[j].as_slice(),
                adopted: self.with_extra[j].nrows(),
                rss: state[j].rss,
                nu: state[j].nu,
            })
            .collect()
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
