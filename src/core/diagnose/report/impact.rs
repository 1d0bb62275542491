//! What the adopted effects do to D_I and D_S: the coefficients of the plain and of the augmented model.

use crate::core::calibrate::Calibration;
use crate::core::diagnose::diagnosis::{BUDGET_DEG_PER_H_G0, Impact};
use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::model::Term;
use crate::core::mounting::Geometry;
use crate::core::record::Plausibility;
use crate::core::separate::Rigid;

/// Shift of D_I and D_S of every gyro that both models separate, where anything is named; before G was in the model,
/// they are counted as zero.
pub(crate) fn impact(fits: &Calibrated, geometry: &Geometry) -> Vec<Impact> {
    let Some(named) = &fits.named else { return Vec::new() };
    let g_in_model = fits.plain.terms.contains(Term::GLinear);
    let (plain, augmented) = (drift(&fits.plain, geometry), drift(named, geometry));
    let mut all = Vec::new();
    for ((gyro, plain), augmented) in named.gyros.iter().zip(plain).zip(augmented) {
        let before = if g_in_model { plain.map(|d| ([d.d_i, d.d_s], d.sd())) } else { Some(([0.0; 2], None)) };
        let after = augmented.and_then(|d| Some(([d.d_i, d.d_s], d.sd()?)));
        let (Some((before, before_sd)), Some((after, sd))) = (before, after) else { continue };
        all.extend(["D_I", "D_S"].into_iter().enumerate().map(|(i, coefficient)| Impact {
            slot: gyro.slot,
            coefficient,
            plain: before[i],
            plain_sd: before_sd.map(|sd| sd[i]),
            augmented: after[i],
            augmented_sd: sd[i],
            shift: after[i] - before[i],
            of_budget: (after[i] - before[i]).abs() / BUDGET_DEG_PER_H_G0,
        }));
    }
    all
}

fn drift(calibration: &Calibration, geometry: &Geometry) -> Vec<Option<Rigid>> {
    let separations = calibration.separate(geometry, &Plausibility::ever());
    separations.into_iter().map(|separation| separation.ok().map(|s| s.rigid)).collect()
}
