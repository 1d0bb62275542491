//! What a station that is not quite level, north or seated does to a fit: sensitivities, and the covariance that
//! follows (GUM 2008, 5.1.2 and 5.2.2).
//!
//! A rotation d (rad) that all dwells share changes what gyro j sees in dwell k by
//!
//! ```text
//! x_jk = G.dA + E.dw     dA = C(d x f), dw = C(d x w)  of the table, d along east, north or up
//!                        dA = d x A,    dw = d x w     of the IMU in its fixture, d along a body axis
//! ```
//!
//! per radian: the columns that the catalogue has for `levelling`, `azimuth` and `reseating` (a tilted table turns
//! about its own vertical: over whole turns only what lies along it stays). The weighted fit that makes the estimates
//! makes S = A+ x of them. The covariance is S diag(u^2) S'. P is left out of x: 2 P A dA is usually below a hundredth
//! of G.dA.

use nalgebra::{DMatrix, DVector};

use super::gyro_fit::{GyroFit, SharedFactors};
use super::shared_coefficients::{self, CommonFit, OwnFit};
use super::uncertainty::StationResponse;
use crate::core::campaign::{Campaign, CampaignNote, StationLack, StationPart, StationUncertainty};
use crate::core::effects::{Effect, GyroAxes, Setting, Shape};
use crate::core::numerics::least_squares::Fit;
use crate::core::numerics::normal_equations::{NormalEquations, Solution};

/// A rotation of its standard uncertainty: what it makes of each gyro's outputs, pulse/s.
pub struct StationRotation {
    part: StationPart,
    /// By gyro of the setting.
    pub columns: Vec<DVector<f64>>,
}

/// The rotations that a station states: x u of the equation above, for the gyros of the setting. Those of the table
/// need attitudes.
pub fn rotations(setting: &Setting, stated: &StationUncertainty) -> Vec<StationRotation> {
    let mut rotations = Vec::new();
    for part in StationPart::ALL {
        let (effect, shape) = match part {
            StationPart::Levelling => (Effect::Levelling, Shape::Tilt { with_rate: false }),
            StationPart::Azimuth => (Effect::Azimuth, Shape::Linear),
            // From before the first dwell on: in all of them.
            StationPart::Fixture => (Effect::Reseating, Shape::Instant(f64::NEG_INFINITY)),
        };
        let Some(sd) = stated.of(part).filter(|_| part == StationPart::Fixture || setting.nav_to_body.is_some()) else {
            continue;
        };
        let scaled = |j: usize| {
            let columns = (effect.entry().columns)(setting, j, shape).into_iter();
            columns.map(move |column| setting.gyros[j].scale * sd * DVector::from_vec(column)).collect::<Vec<_>>()
        };
        let of_gyros: Vec<Vec<DVector<f64>>> = (0..setting.gyros.len()).map(scaled).collect();
        for c in 0..of_gyros.first().map_or(0, Vec::len) {
            rotations
                .push(StationRotation { part, columns: of_gyros.iter().map(|of_gyro| of_gyro[c].clone()).collect() });
        }
    }
    rotations
}

/// Hands each fit its responses, and what the station may have left in its residuals is no noise. Answers what cannot
/// be told.
pub(super) fn spread(
    campaign: &Campaign,
    stated: &StationUncertainty,
    fits: &mut [GyroFit],
    common: Option<&CommonFit>,
    (has_sem, shared): (bool, &SharedFactors),
) -> Vec<CampaignNote> {
    let (rotations, places, notes) = of_fits(campaign, stated, fits, shared);
    for rotation in &rotations {
        let nothing = DVector::zeros(campaign.dwells.len());
        let of_gyro =
            |(fit, column): (&GyroFit, &Option<&DVector<f64>>)| fit.factor(shared).fit(column.unwrap_or(&nothing));
        let columns: Vec<_> = places.iter().map(|place| place.map(|place| &rotation.columns[place])).collect();
        let mut seen: Vec<_> = fits.iter().zip(&columns).map(of_gyro).collect();
        if let Some(common) = common {
            let own = |(j, seen): (usize, _)| {
                let seen: &Fit = seen;
                let (factor, variance) = (fits[j].factor(shared), common.variances[j]);
                OwnFit { factor, residuals: &seen.residuals, variance }
            };
            let owns: Vec<OwnFit> = seen.iter().enumerate().map(own).collect();
            let taken = shared_coefficients::fit(common.kept.clone(), &owns).estimate;
            for (j, seen) in seen.iter_mut().enumerate() {
                for (regressor, k) in common.kept.iter().zip(taken.iter()) {
                    let Some(regressor) = &regressor[j] else { continue };
                    let absorbed = fits[j].factor(shared).fit(&regressor.column);
                    seen.estimate.axpy(-k, &absorbed.estimate, 1.0);
                    seen.residuals.axpy(-k, &absorbed.residuals, 1.0);
                }
            }
        }
        for ((fit, seen), column) in fits.iter_mut().zip(seen).zip(&columns) {
            let response = StationResponse { part: rotation.part, estimate: seen.estimate, residuals: seen.residuals };
            fit.station.extend(column.map(|_| response));
        }
    }
    take_out(fits, has_sem, shared);
    notes
}

/// The rotations of the gyros whose E is known, the place of each fit's among them, and what cannot be told.
fn of_fits(
    campaign: &Campaign,
    stated: &StationUncertainty,
    fits: &[GyroFit],
    shared: &SharedFactors,
) -> (Vec<StationRotation>, Vec<Option<usize>>, Vec<CampaignNote>) {
    let parts = || StationPart::ALL.into_iter().filter(|part| stated.of(*part).is_some());
    let left_out = |parts: Vec<StationPart>, why| CampaignNote::StationLeftOut { parts, why };
    let (mut notes, mut known, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (gyro, fit) in campaign.gyros.iter().zip(fits) {
        let axes = campaign.geometry.triad(gyro.slot).zip(fit.e_and_g(shared));
        if axes.is_none() {
            notes.push(left_out(parts().collect(), StationLack::Scale(gyro.slot)));
        }
        places.push(axes.is_some().then_some(known.len()));
        known.extend(axes.map(|(triad, (e, g))| GyroAxes::carried(gyro.slot, triad.mat_gyro_body(), e, g)));
    }
    let setting = Setting::of(campaign, known);
    let of_table: Vec<StationPart> = parts().filter(|part| *part != StationPart::Fixture).collect();
    if setting.nav_to_body.is_none() && !of_table.is_empty() && !setting.gyros.is_empty() {
        notes.push(left_out(of_table, StationLack::Attitude));
    }
    (rotations(&setting, stated), places, notes)
}

/// Rounds in which the noise, where nothing states it, and what the station leaves in the residuals are told apart.
const ROUNDS: usize = 4;

/// The residuals without what the rotations, each N(0, u^2) and one for all gyros, most likely left in them (ridge
/// regression): what the station's own uncertainty explains is neither noise nor lack of fit, and not counted twice.
fn take_out(fits: &mut [GyroFit], has_sem: bool, shared: &SharedFactors) {
    let m = fits.iter().map(|fit| fit.station.len()).max().unwrap_or(0);
    let whitened = |fit: &GyroFit, v: &DVector<f64>| v.component_mul(fit.factor(shared).weights());
    let left: Vec<DMatrix<f64>> = fits
        .iter()
        .map(|fit| {
            let columns: Vec<_> = fit.station.iter().map(|response| whitened(fit, &response.residuals)).collect();
            if columns.len() == m && m > 0 {
                DMatrix::from_columns(&columns)
            } else {
                DMatrix::zeros(fit.fit.residuals.len(), m)
            }
        })
        .collect();
    let residuals: Vec<DVector<f64>> = fits.iter().map(|fit| whitened(fit, &fit.fit.residuals)).collect();
    let scatter = |j: usize, net: &DVector<f64>, taken: f64| {
        let dof = fits[j].fit.dof as f64 - taken;
        if dof > 0.0 { (net.norm_squared() / dof).max(f64::MIN_POSITIVE) } else { 1.0 }
    };
    let mut variances: Vec<f64> =
        (0..fits.len()).map(|j| if has_sem { 1.0 } else { scatter(j, &residuals[j], 0.0) }).collect();
    let mut net: Vec<(DVector<f64>, f64)> = Vec::new();
    for _ in 0..if has_sem { 1 } else { ROUNDS } {
        let mut normal = NormalEquations { matrix: DMatrix::identity(m, m), right: DVector::zeros(m) };
        for j in 0..fits.len() {
            normal.matrix += left[j].tr_mul(&left[j]) / variances[j];
            normal.right += left[j].tr_mul(&residuals[j]) / variances[j];
        }
        let Some(Solution { estimate: likely, covariance }) = normal.solve_beyond(&normal.matrix.diagonal(), 0.0)
        else {
            return;
        };
        let of_gyro = |j: usize| {
            let taken = (&covariance * left[j].tr_mul(&left[j])).trace() / variances[j];
            (&residuals[j] - &left[j] * &likely, taken)
        };
        net = (0..fits.len()).map(of_gyro).collect();
        if !has_sem {
            variances = net.iter().enumerate().map(|(j, (net, taken))| scatter(j, net, *taken)).collect();
        }
    }
    let (net, taken): (Vec<_>, Vec<f64>) = net.into_iter().unzip();
    let taken = shared_coefficients::in_whole_numbers(taken.into_iter());
    for ((fit, net), taken) in fits.iter_mut().zip(net).zip(taken) {
        fit.leave(net, taken, shared);
    }
}
