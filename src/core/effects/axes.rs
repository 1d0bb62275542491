//! The axes of the gyros as the dwells of a campaign show them.

use nalgebra::Vector3;

use super::refusal::Refusal;
use super::setting::{GyroAxes, Setting};
use crate::core::calibrate::design::model_matrix;
use crate::core::campaign::{Campaign, CampaignNote};
use crate::core::model::Terms;

/// The columns of a campaign with the axes of its gyros as its own dwells show them, and notes on those axes.
pub(crate) fn setting(campaign: &Campaign) -> Result<(Setting, Vec<CampaignNote>), Refusal> {
    let mut notes = Vec::new();
    let axes = (0..campaign.gyros.len()).map(|j| axes_of(campaign, j, &mut notes)).collect::<Result<Vec<_>, _>>()?;
    Ok((Setting::of(campaign, axes), notes))
}

/// Largest angle between the fitted and the nominal input axis that is believed, rad.
const BELIEVED_MISALIGNMENT: f64 = 0.1;

/// |E|, axes, G and bias of one gyro: from the E that is held, else from a fit of model (6), else nominal.
fn axes_of(campaign: &Campaign, j: usize, notes: &mut Vec<CampaignNote>) -> Result<GyroAxes, Refusal> {
    let gyro = &campaign.gyros[j];
    let slot = gyro.slot;
    let nominal = campaign.geometry.triad(slot).ok_or(Refusal::NoAxes(slot.name()))?.mat_gyro_body();
    if campaign.is_silent(j) {
        let (dwells, parameters) = (campaign.dwells.len(), gyro.fitted_terms(campaign.terms()).columns());
        let is_few = dwells <= parameters;
        return Err(if is_few { Refusal::TooFewDwells { dwells, parameters } } else { Refusal::NoOutput(slot.name()) });
    }
    let (bias, g, e) = rough_fit(campaign, j);
    let carried = |e: Vector3<f64>| GyroAxes { bias: bias / e.norm(), ..GyroAxes::carried(slot, nominal, e, g) };
    if let Some(e) = gyro.known_e {
        return Ok(carried(e));
    }
    let input = nominal.row(0).transpose();
    if e.iter().all(|x| x.is_finite()) && e.norm() > 0.0 && e.angle(&input) < BELIEVED_MISALIGNMENT {
        return Ok(carried(e));
    }
    let along = e.dot(&input);
    let size = if along.is_finite() && along > 1e-6 { along } else { 1.0 };
    notes.push(CampaignNote::NominalAxis { slot, scale: size });
    Ok(carried(size * input))
}

/// D0, G and E, in pulse, by plain least squares over what rank the campaign has (minimum norm).
fn rough_fit(campaign: &Campaign, j: usize) -> (f64, Vector3<f64>, Vector3<f64>) {
    let known = campaign.gyros[j].known_e;
    let mut design = model_matrix(&campaign.dwells, campaign.gyros[j].fitted_terms(Terms::MODEL_6));
    let norms: Vec<f64> = design.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    for (c, norm) in norms.iter().enumerate() {
        design.column_mut(c).scale_mut(1.0 / norm);
    }
    let output = nalgebra::DVector::from_iterator(campaign.dwells.len(), campaign.free_outputs(j));
    let Ok(fit) = design.svd(true, true).solve(&output, 1e-7) else {
        return (0.0, Vector3::zeros(), Vector3::zeros());
    };
    let value = |c: usize| fit[c] / norms[c];
    let g = Vector3::new(value(1), value(2), value(3));
    let e = known.unwrap_or_else(|| Vector3::new(value(7), value(8), value(9)));
    (value(0), g, e)
}
