//! Effects that the model holds beyond model (6), as columns of the fit.

use nalgebra::{DMatrix, DVector};

use super::design::Design;
use super::regressor::{Regressor, adding, told_apart};
use crate::core::augmented::Adopted;
use crate::core::calibrate::shared_coefficients::Shared;
use crate::core::campaign::{Campaign, CampaignNote, LeftOut};
use crate::core::effects::{Effect, Scope, axes};
use crate::core::numerics::basis::Basis;
use crate::core::numerics::least_squares::Factor;

/// The regressors of the adopted effects.
pub(super) struct Regressors {
    /// Of each gyro for itself.
    pub own: Vec<Vec<Regressor>>,
    /// Of coefficients that all gyros share.
    pub shared: Vec<Shared>,
    /// Why some cannot be formed.
    pub notes: Vec<CampaignNote>,
}

pub(super) fn regressors(campaign: &Campaign, adopted: &[Adopted], reference_c: Option<f64>) -> Regressors {
    let none = |notes| Regressors { own: vec![Vec::new(); campaign.gyros.len()], shared: Vec::new(), notes };
    if adopted.is_empty() {
        return none(Vec::new());
    }
    let (setting, notes) = match axes::setting(campaign) {
        Ok((setting, notes)) => (setting.referred_to(campaign, reference_c), notes),
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
        let coefficients = entry.coefficients(adopted.shape);
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
    let (adds, _) = adding(Basis::of_orthonormal(base.basis()), whitened.map(|column| (column.norm_squared(), column)));
    told_apart(regressors, &adds, |regressor| Some(regressor.effect))
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
