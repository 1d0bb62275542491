//! Columns of effects beside model (6): which of them these dwells can tell.

use nalgebra::DVector;

use crate::core::effects::{Coefficient, Effect};
use crate::core::numerics::basis::Basis;

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

/// Which columns leave something over beside `basis` and those before them, each with the power of the regressor that
/// it stands for; and `basis` with what they leave after it.
pub(super) fn adding(mut basis: Basis, columns: impl Iterator<Item = (f64, DVector<f64>)>) -> (Vec<bool>, Basis) {
    let adds =
        |(power, column): (f64, DVector<f64>)| basis.push_beyond(column.data.into(), LEAST_VISIBLE * power).is_some();
    (columns.map(adds).collect(), basis)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_adds_something_where_more_than_a_millionth_of_its_power_is_left() {
        let mut basis = Basis::default();
        basis.push_beyond(vec![1.0, 0.0, 0.0], 0.0);
        let column = |left: f64| DVector::from_vec(vec![100.0, left, 0.0]);
        // Squares of 0.2 and 0.05 are left of a power of 1e4, of which a millionth is 0.01.
        let (adds, basis) = adding(basis, [(1e4, column(0.2)), (1e4, column(0.05))].into_iter());
        assert_eq!((adds, basis.rank()), (vec![true, false], 2));
        let (adds, _) = adding(Basis::default(), [(1e4, column(0.0)), (1e4, column(0.05))].into_iter());
        assert_eq!(adds, [true, false]);
    }
}
