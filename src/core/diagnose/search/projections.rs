//! Products of the bank's columns with residuals and with what has been adopted: all that a score is made of.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::core::diagnose::residuals::pooled_noise::{Scatter, pool};
use crate::core::diagnose::residuals::whitened::{Frame, GyroFrame};
use crate::core::diagnose::search::hypotheses::{Bank, Block, Factor};
use crate::core::numerics::basis::{Basis, dot};

/// What has been adopted in one gyro: columns of its bank, made orthonormal.
#[derive(Debug, Clone, Default)]
pub(crate) struct Extra {
    /// Orthogonal to the model's basis too.
    pub basis: Basis,
    /// The column of the bank that each vector was made of.
    columns: Vec<usize>,
}

impl Extra {
    /// Adopts a column of the gyro's bank; one that adds nothing is left out.
    pub fn push(&mut self, bank: &Bank, gyro: usize, column: usize) {
        if self.basis.push(bank.column(gyro, column).as_slice().to_vec()) > 0.0 {
            self.columns.push(column);
        }
    }
}

/// Of columns that are in no bank: nothing is asked of [`Products`] there.
impl From<Basis> for Extra {
    fn from(basis: Basis) -> Self {
        Self { basis, columns: Vec::new() }
    }
}

/// Residuals of one gyro under the model and what has been adopted so far.
#[derive(Debug, Clone)]
pub(crate) struct GyroState {
    pub extra: Extra,
    pub residual: Vec<f64>,
    /// Products of the adopted vectors with the residual before they were adopted.
    along: Vec<f64>,
    /// Sum of squares and degrees of freedom that say how large the noise is: stated errors counted in, and the other
    /// gyros' where they are alike.
    pub scatter: Scatter,
}

impl GyroState {
    /// Of a gyro whose residual under the model is `residual`; `scatter` of what is left of it and its degrees of freedom.
    pub fn of(extra: Extra, mut residual: Vec<f64>, scatter: impl FnOnce(&[f64]) -> Scatter) -> Self {
        let along = extra.basis.vectors().iter().map(|q| dot(q, &residual)).collect();
        extra.basis.project_out(&mut residual);
        Self { scatter: scatter(&residual), extra, residual, along }
    }
}

/// An IMU's gyros.
pub(crate) const MAX_GYROS: usize = 3;

pub(crate) type State = Vec<GyroState>;

/// The model in use with further columns adopted.
pub(crate) fn state(frame: &Frame, extras: Vec<Extra>) -> State {
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
pub(crate) fn each_by_itself(frame: &Frame, extras: Vec<Extra>) -> State {
    let gyros = frame.gyros.iter().zip(extras).zip(&frame.noise.rounding);
    let of_gyro = |((gyro, extra), rounding): ((&GyroFrame, Extra), &f64)| {
        let dof = (gyro.dof() - extra.basis.rank().min(gyro.dof())) as f64;
        // What lies below rounding is no residual that anything could explain.
        let scatter = |residual: &[f64]| frame.noise.with_stated(dot(residual, residual).max(rounding * dof), dof);
        GyroState::of(extra, gyro.residual.clone(), scatter)
    };
    gyros.map(of_gyro).collect()
}

/// Products of every column of the bank with residuals and adopted columns.
///
/// Adopted vectors and residuals are sums of few columns of the bank and of the residuals under the model alone. The
/// products of those are kept with the bank: no state needs a pass over the dwells.
pub(crate) struct Products {
    /// Adopted x columns, so that what belongs to one column lies together.
    with_extra: Vec<DMatrix<f64>>,
    with_residual: Vec<DVector<f64>>,
    /// Of the gyros as their state has it.
    scatter: Vec<Scatter>,
}

impl Products {
    /// Of every column of the bank.
    pub fn of(bank: &Bank, state: &State) -> Self {
        let of_gyro = |(j, gyro): (usize, &GyroState)| {
            let with_extra = with_adopted(bank, j, j, &gyro.extra);
            let mut with_residual = DVector::clone(&bank.products(j, Factor::Residual(j)));
            with_residual.gemv_tr(-1.0, &with_extra, &DVector::from_column_slice(&gyro.along), 1.0);
            (with_extra, with_residual)
        };
        let (with_extra, with_residual) = state.iter().enumerate().map(of_gyro).unzip();
        Self { with_extra, with_residual, scatter: state.iter().map(|gyro| gyro.scatter).collect() }
    }

    /// Gyros x columns of each gyro's bank: with every gyro's residual, what was adopted in the column's gyro taken out
    /// of it.
    pub fn across(&self, bank: &Bank, state: &State) -> Vec<DMatrix<f64>> {
        let of_gyro = |(j, own): (usize, &GyroState)| {
            let mut across = DMatrix::zeros(state.len(), bank.columns[j].ncols());
            for (i, other) in state.iter().enumerate() {
                if i == j {
                    across.row_mut(i).tr_copy_from(&self.with_residual[j]);
                    continue;
                }
                let mut row = DVector::clone(&bank.products(j, Factor::Residual(i)));
                let taken = with_adopted(bank, j, i, &other.extra);
                row.gemv_tr(-1.0, &taken, &DVector::from_column_slice(&other.along), 1.0);
                let along = own.extra.basis.vectors().iter().map(|q| dot(q, &other.residual));
                let along = DVector::from_iterator(own.extra.basis.rank(), along);
                row.gemv_tr(-1.0, &self.with_extra[j], &along, 1.0);
                across.row_mut(i).tr_copy_from(&row);
            }
            across
        };
        state.iter().enumerate().map(of_gyro).collect()
    }

    /// By gyro, the products with the noise that goes with them.
    pub fn seen(&self) -> Vec<GyroStatistics<'_>> {
        self.seen_in(&self.scatter)
    }

    /// By gyro, with the noise that each is held to have.
    pub fn seen_in(&self, scatter: &[Scatter]) -> Vec<GyroStatistics<'_>> {
        let of_gyro = |(j, scatter): (usize, &Scatter)| GyroStatistics {
            with_residual: self.with_residual[j].as_slice(),
            with_extra: self.with_extra[j].as_slice(),
            adopted: self.with_extra[j].nrows(),
            rss: scatter.rss,
            nu: scatter.nu,
        };
        scatter.iter().enumerate().map(of_gyro).collect()
    }
}

/// Adopted x columns: products of the columns of gyro `j` with the vectors adopted in gyro `i`. Each vector is its
/// column less what the vectors before it span, and so are its products.
fn with_adopted(bank: &Bank, j: usize, i: usize, extra: &Extra) -> DMatrix<f64> {
    let vectors = extra.basis.vectors();
    assert_eq!(vectors.len(), extra.columns.len(), "adopted columns are the bank's");
    let made_of: Vec<_> = extra.columns.iter().map(|&c| bank.products(j, Factor::Column(i, c))).collect();
    let along = |k: usize, m: usize| dot(&vectors[m], bank.column(i, extra.columns[k]).as_slice());
    let along: Vec<Vec<f64>> = (0..vectors.len()).map(|k| (0..=k).map(|m| along(k, m)).collect()).collect();
    let mut products = DMatrix::zeros(vectors.len(), bank.columns[j].ncols());
    for (c, mut column) in products.column_iter_mut().enumerate() {
        for (k, along) in along.iter().enumerate() {
            let before: f64 = (0..k).map(|m| along[m] * column[m]).sum();
            column[k] = (made_of[k][c] - before) / along[k];
        }
    }
    products
}

/// What the evidence of one gyro is made of.
pub(crate) struct GyroStatistics<'a> {
    /// Products of the gyro's columns with its residual.
    pub with_residual: &'a [f64],
    /// Products of what has been adopted with the gyro's columns, those of one column together.
    pub with_extra: &'a [f64],
    /// Number of adopted columns.
    pub adopted: usize,
    pub rss: f64,
    pub nu: f64,
}

impl GyroStatistics<'_> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::augmented::Options;
    use crate::core::diagnose::search::hypotheses::Candidates;

    #[test]
    fn products_are_those_of_a_pass_over_the_dwells() {
        let campaign = std::fs::read("tests/data/practice/campaign-02.json").unwrap();
        let campaign = crate::wire::campaign::parse_json(&campaign).unwrap();
        let frame = Frame::of(&campaign, &Options::default()).unwrap();
        let bank = Bank::of(&frame, &Candidates::of(&frame, &[]));
        let gyros = frame.gyros.len();
        // Other columns in each gyro, one of them twice: it adds nothing the second time.
        let extra = |j: usize| {
            let mut extra = Extra::default();
            [3, 40 + j, 3, 7].into_iter().for_each(|column| extra.push(&bank, j, column));
            extra
        };
        let state = each_by_itself(&frame, (0..gyros).map(extra).collect());
        assert!(state.iter().all(|gyro| gyro.extra.basis.rank() == 3));
        let products = Products::of(&bank, &state);
        let across = products.across(&bank, &state);
        let (seen, n) = (products.seen(), frame.dwells());
        for (j, gyro) in state.iter().enumerate() {
            let columns = &bank.columns[j];
            let with_extra = gyro.extra.basis.matrix(n).tr_mul(columns);
            for (c, column) in with_extra.column_iter().enumerate() {
                let found = DVector::from_column_slice(seen[j].taken(c));
                assert!((found - column).norm() < 1e-10, "adopted, gyro {j}, column {c}");
            }
            for (i, other) in state.iter().enumerate() {
                let mut residual = other.residual.clone();
                gyro.extra.basis.project_out(&mut residual);
                let expected = columns.tr_mul(&DVector::from_vec(residual.clone()));
                let size = dot(&residual, &residual).sqrt();
                assert!((across[j].row(i).transpose() - &expected).amax() < 1e-10 * size, "gyro {j}, residual of {i}");
                if i == j {
                    let own = DVector::from_column_slice(seen[j].with_residual);
                    assert!((own - expected).amax() < 1e-10 * size, "gyro {j}, its own residual");
                }
            }
        }
    }
}
