//! The columns of every coefficient in the outputs of a campaign's gyros.

use nalgebra::DMatrix;

use super::identified::{ModelCoefficient, Of};
use crate::core::augmented::Adopted;
use crate::core::effects::{Effect, MissingInput, Setting};
use crate::core::model::Term;

/// The columns, pulse/s per unit of each coefficient: gyro by gyro, dwell by dwell.
pub(super) struct Columns {
    pub matrix: DMatrix<f64>,
    /// Effects whose regressors the campaign lacks: their columns are zero.
    pub lacking: Vec<(Effect, MissingInput)>,
}

pub(super) fn columns(setting: &Setting, coefficients: &[ModelCoefficient], effects: &[Adopted]) -> Columns {
    let n = setting.dwells();
    let mut matrix = DMatrix::zeros(setting.gyros.len() * n, coefficients.len());
    let mut lacking = Vec::new();
    let missing: Vec<Option<MissingInput>> = effects.iter().map(|a| (a.effect.entry().missing)(setting)).collect();
    for (adopted, lack) in effects.iter().zip(&missing) {
        // At the reference temperature throughout, an effect of temperature adds nothing.
        lacking.extend(lack.filter(|lack| *lack != MissingInput::TemperatureChange).map(|lack| (adopted.effect, lack)));
    }
    for (j, gyro) in setting.gyros.iter().enumerate() {
        let of_effects: Vec<Vec<Vec<f64>>> = effects
            .iter()
            .zip(&missing)
            .map(|(adopted, missing)| match missing {
                None if adopted.slots.contains(&gyro.slot) => {
                    adopted.effect.entry().regressors(setting, j, adopted.shape)
                }
                _ => Vec::new(),
            })
            .collect();
        for (c, coefficient) in coefficients.iter().enumerate() {
            if coefficient.slot.is_some_and(|slot| slot != gyro.slot) {
                continue;
            }
            let mut column = matrix.view_mut((j * n, c), (n, 1));
            match coefficient.of {
                Of::Term(term, part) => {
                    for k in 0..n {
                        column[k] = match term {
                            Term::Bias => 1.0,
                            Term::GLinear => setting.force[k][part],
                            Term::GSquared => setting.force[k][part].powi(2),
                            Term::Scale => setting.rate[k][part],
                        };
                    }
                }
                Of::Effect(effect, number) => {
                    if let Some(regressor) = of_effects[effect].get(number) {
                        (0..n).for_each(|k| column[k] = gyro.scale * regressor[k]);
                    }
                }
            }
        }
    }
    Columns { matrix, lacking }
}
