//! Columns of effects beside model (6): which of them these dwells can tell.

use nalgebra::{DMatrix, DVector};

use crate::core::effects::{Coefficient, Effect};

/// Share of a regressor's whitened power that the columns before it must leave over for it to be fitted: below that,
/// the effect and model (6) are one to this campaign, and both would be lost.
const LEAST_VISIBLE: f64 = 1e-6;

/// One coefficient's regressor in the output of one gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct Regressor {
    pub effect: Effect,
    pub coefficient: Coefficient,
    /// pulse/s per unit coefficient, by dwell.
    pub column: DVector<f64>,
}

/// Which columns leave something over beside an orthonormal `base` and those before them, each with the power of the regressor
/// that it stands for; and `base` with what they leave after it.
pub(super) fn adding(
    base: DMatrix<f64>,
    columns: impl Iterator<Item = (f64, DVector<f64>)>,
) -> (Vec<bool>, DMatrix<f64>) {
    let mut basis = base;
    let mut adds = Vec::new();
    for (power, mut left) in columns {
        for _ in 0..2 {
            left -= &basis * basis.tr_mul(&left);
        }
        let new = left.norm_squared() > LEAST_VISIBLE * power;
        if new {
            let rank = basis.ncols();
            basis = basis.insert_column(rank, 0.0);
            basis.set_column(rank, &left.normalize());
        }
        adds.push(new);
    }
    (adds, basis)
}

/// Those that add something, and each effect of which something does not.
pub(super) fn told_apart<T>(
    all: Vec<T>,
    adds: &[bool],
    effect: impl Fn(&T) -> Option<Effect>,
) -> (Vec<T>, Vec<Effect>) {
    let (mut kept, mut hidden) = (Vec::new(), Vec::new());
    for (one, adds) in all.into_iter().zip(adds) {
        if *adds {
            kept.push(one);
        } else if let Some(effect) = effect(&one).filter(|effect| !hidden.contains(effect)) {
            hidden.push(effect);
        }
    }
    (kept, hidden)
}
