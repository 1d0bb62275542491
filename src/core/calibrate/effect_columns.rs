//! Effects that the model holds beyond model (6), as columns of the fit.

use nalgebra::{DMatrix, DVector};

use super::design::Design;
use crate::core::calibrate::shared_coefficients::Shared;
use crate::core::campaign::{Campaign, CampaignNote, LeftOut};
use crate::core::diagnose::{self, Adopted};
use crate::core::effects::{Coefficient, Effect, Scope};
use crate::core::numerics::least_squares::Factor;

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

/// The regressors of the adopted effects.
pub(super) struct Regressors {
    /// Of each gyro for itself.
    pub own: Vec<Vec<Regressor>>,
    /// Of coefficients that all gyros share.
    pub shared: Vec<Shared>,
    /// Why some cannot be formed.
    pub notes: Vec<CampaignNote>,
}

pub(super) fn regressors(campaign: &Campaign, adopted: &[Adopted]) -> Regressors {
    let none = |notes| Regressors { own: vec![Vec::new(); campaign.gyros.len()], shared: Vec::new(), notes };
    if adopted.is_empty() {
        return none(Vec::new());
    }
    let (setting, notes) = match diagnose::setting(campaign) {
        Ok(found) => found,
        Err(why) => return none(vec![CampaignNote::EffectsLeftOut { why }]),
    };
    let mut all = none(notes);
    for adopted in adopted {
        let entry = adopted.effect.entry();
        if let Some(missing) = (entry.missing)(&setting) {
            let (effect, why) = (adopted.effect, LeftOut::Lacks(missing));
            all.notes.push(CampaignNote::EffectLeftOut { slot: None, effect, why });
            continue;
        }
        let coefficients = (entry.coefficients)(adopted.shape);
        let first = all.shared.len();
        if entry.scope == Scope::Common {
            all.shared.resize_with(first + coefficients.len(), || vec![None; campaign.gyros.len()]);
        }
        for (j, axes) in setting.gyros.iter().enumerate().filter(|(_, axes)| adopted.slots.contains(&axes.slot)) {
            let columns = (entry.columns)(&setting, j, adopted.shape);
            for (c, (column, coefficient)) in columns.into_iter().zip(&coefficients).enumerate() {
                let column = axes.scale * DVector::from_vec(column);
                let regressor = Regressor { effect: adopted.effect, coefficient: *coefficient, column };
                match entry.scope {
                    Scope::Gyro => all.own[j].push(regressor),
                    Scope::Common => all.shared[first + c][j] = Some(regressor),
                }
            }
        }
    }
    all
}

/// The regressors that leave something over beside model (6) and those before them, and the effects that do not.
pub(super) fn visible(base: &Factor, regressors: Vec<Regressor>) -> (Vec<Regressor>, Vec<Effect>) {
    let whitened = regressors.iter().map(|regressor| regressor.column.component_mul(base.weights()));
    let (adds, _) = adding(base.basis().clone(), whitened.map(|column| (column.norm_squared(), column)));
    told_apart(regressors, &adds, |regressor| Some(regressor.effect))
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

/// The design with the regressors after model (6)'s columns.
pub(super) fn extended(design: &Design, regressors: &[Regressor]) -> Design {
    let (n, q) = design.reduced.shape();
    let (p, m) = (design.expand.nrows(), regressors.len());
    let mut reduced = design.reduced.clone().resize(n, q + m, 0.0);
    for (c, regressor) in regressors.iter().enumerate() {
        reduced.set_column(q + c, &regressor.column);
    }
    let mut expand = design.expand.clone().resize(p + m, q + m, 0.0);
    expand.view_mut((p, q), (m, m)).copy_from(&DMatrix::identity(m, m));
    let gauge = design.gauge.as_ref().map(|direction| direction.clone().resize_vertically(p + m, 0.0));
    Design { terms: design.terms, reduced, expand, gauge }
}

#[cfg(test)]
mod tests;
