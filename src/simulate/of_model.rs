//! A scenario whose IMU is one that a model file describes: its gyros, its effects, its noise.

use nalgebra::{Matrix3, Vector3};

use super::scenario::{AxesChoice, GeometryChoice, GyroChoice, Scenario, StatedE};
use super::station::Earth;
use super::{Stream, gaussian, random};
use crate::core::augmented::{AugmentedModel, KnownEffect};
use crate::core::campaign::{Campaign, CampaignGyro};
use crate::core::effects::Estimate;
use crate::core::fault::Faults;
use crate::core::imu_model::{Identified, ModelGyro, Of, drawn};
use crate::core::model::Term;
use crate::core::mounting::{Geometry, Slot};
use crate::core::units::EARTH_RATE_DEG_H;

const ARCMIN_PER_RADIAN: f64 = 180.0 * 60.0 / std::f64::consts::PI;

/// The IMU as one of those that the model's covariance allows, by the scenario's seed, in that scenario; and the model
/// with the coefficients drawn, for [`super::augment::augment`]. A scenario of which nothing but the seed is stated is
/// one of those that the model has seen.
pub fn drawn_from(base: &Scenario, model: &AugmentedModel) -> Result<(Scenario, AugmentedModel), Faults> {
    let Some(identified) = &model.identified else { return Ok((base.clone(), model.clone())) };
    let mut rng = random(base.seed, Stream::Model);
    let z: Vec<f64> = (0..2 * identified.coefficients.len()).map(|_| gaussian(&mut rng)).collect();
    let one = drawn(identified, &z);
    let is_left_open = *base == Scenario { seed: base.seed, ..Scenario::default() };
    let seen = is_left_open.then(|| as_seen(base, identified));
    let scenario = scenario_of(seen.as_ref().unwrap_or(base), &one)?;
    let estimates = |known: &KnownEffect| -> Vec<Estimate> {
        let place = one.effects.iter().position(|own| *own == known.adopted);
        let mut estimates = known.estimates.clone();
        for place in place.map(|place| one.of_effect(place)).unwrap_or_default() {
            let c = one.coefficients[place];
            let Of::Effect(_, number) = c.of else { continue };
            let name = known.adopted.effect.entry().coefficients(known.adopted.shape)[number].name;
            if let Some(own) = estimates.iter_mut().find(|e| e.slot == c.slot && e.name == name) {
                own.value = c.value;
            }
        }
        estimates
    };
    let effects = model.effects.iter().map(|k| KnownEffect { adopted: k.adopted.clone(), estimates: estimates(k) });
    Ok((scenario, AugmentedModel { effects: effects.collect(), ..model.clone() }))
}

/// The scenario on the day after the model's newest campaign, at its station, with temperatures and rates as it has seen.
fn as_seen(base: &Scenario, model: &Identified) -> Scenario {
    let next_day = model.measured_at.plus_days(1.0).date();
    let mut scenario = Scenario { measured_at: format!("{next_day}T12:00:00Z"), ..base.clone() };
    if let Some(newest) = model.campaigns.iter().max_by_key(|fitted| fitted.measured_at) {
        scenario.station = newest.station.to_string();
    }
    if let Some([low, high]) = model.validity.temperature_c {
        scenario.temperature.mean_c = 0.5 * (low + high);
        scenario.temperature.size_k = scenario.temperature.size_k.min(0.25 * (high - low));
    }
    let rates = &mut scenario.programme.rates_arcsec_s;
    let most = rates.iter().copied().fold(0.0, f64::max);
    // The Earth's rate comes beside the table's; arcsec/s is the same number in deg/h.
    let share = (model.validity.rate_arcsec_s - EARTH_RATE_DEG_H) / most;
    rates.iter_mut().for_each(|rate| *rate *= share.min(1.0));
    rates.retain(|rate| *rate > EARTH_RATE_DEG_H);
    scenario
}

/// Divides the standard errors that the campaign states by the factor that the model has found on those of its station:
/// it states them as that does.
pub fn state_as_fitted(campaign: &mut Campaign, model: &AugmentedModel) {
    let Some(identified) = &model.identified else { return };
    let factor = |gyro: &CampaignGyro| identified.gyro(gyro.slot).and_then(|own| own.noise.sem_factor).unwrap_or(1.0);
    let factors: Vec<f64> = campaign.gyros.iter().map(factor).collect();
    for stated in campaign.dwells.iter_mut().filter_map(|dwell| dwell.output_sem_pulse_s.as_mut()) {
        stated.iter_mut().zip(&factors).for_each(|(sem, factor)| *sem /= factor);
    }
}

/// The scenario with the IMU of the model as it is estimated.
pub fn scenario_of(base: &Scenario, model: &Identified) -> Result<Scenario, Faults> {
    let gravity = Earth::at(&base.site)?.gravity.norm();
    let mean = |of: &dyn Fn(&ModelGyro) -> f64| {
        (model.gyros.iter().map(|gyro| of(gyro).powi(2)).sum::<f64>() / model.gyros.len() as f64).sqrt()
    };
    let mut scenario = Scenario {
        imu: model.imu.to_string(),
        geometry: geometry(&model.geometry),
        gyros: model.gyros.iter().map(|gyro| choice(model, gyro, gravity)).collect(),
        ..base.clone()
    };
    scenario.noise.angle_random_walk_deg_per_sqrt_h = mean(&|gyro| gyro.noise.random_walk);
    scenario.noise.rate_noise_ppm = mean(&|gyro| gyro.noise.rate_ppm);
    Ok(scenario)
}

fn geometry(geometry: &Geometry) -> GeometryChoice {
    match geometry {
        Geometry::Skewed => GeometryChoice::Named("skewed".into()),
        Geometry::Orthogonal => GeometryChoice::Named("orthogonal".into()),
        Geometry::Custom(_) => {
            let axes = |slot: Slot| {
                let triad = geometry.triad(slot)?;
                let axes = AxesChoice { input: triad.input().into(), spin: triad.spin().into() };
                Some((slot.name().to_owned(), axes))
            };
            GeometryChoice::Axes(Slot::ALL.into_iter().filter_map(axes).collect())
        }
    }
}

/// Eq. (5) of one gyro from its row of model (6).
///
/// S is turned about I to where G lies, so that D_O = 0; P becomes products along the gyro's axes, whose O^2 is
/// g^2 - I^2 - S^2.
fn choice(model: &Identified, gyro: &ModelGyro, gravity: f64) -> GyroChoice {
    let values = model.values();
    let vector = |term| model.of_term(gyro.slot, term).map(|places| Vector3::from(places.map(|place| values[place])));
    let e = vector(Term::Scale).filter(|_| !gyro.e_held).unwrap_or(gyro.e);
    let scale = e.norm();
    let y = vector(Term::GLinear).unwrap_or_default() / scale;
    let nominal = model.geometry.triad(gyro.slot).map_or_else(Matrix3::identity, |triad| triad.mat_gyro_body());
    let input = e / scale;
    let turn = nalgebra::Rotation3::rotation_between(&nominal.row(0).transpose(), &input);
    let carried = turn.unwrap_or_else(nalgebra::Rotation3::identity) * nominal.row(1).transpose();
    let across = y - input * y.dot(&input);
    let sign = if across.dot(&carried) < 0.0 { -1.0 } else { 1.0 };
    let spin = if across.norm() > 1e-9 { sign * across.normalize() } else { carried };
    let axes = Matrix3::from_rows(&[input.transpose(), spin.transpose(), input.cross(&spin).transpose()]);
    let p = vector(Term::GSquared).unwrap_or_default() / scale;
    let m = axes * Matrix3::from_diagonal(&p) * axes.transpose();
    let bias = model.coefficients.iter().find(|c| c.slot == Some(gyro.slot) && c.of == Of::Term(Term::Bias, 0));
    let mount = nalgebra::Rotation3::from_matrix_unchecked(axes.transpose() * nominal);
    GyroChoice {
        slot: gyro.slot.name().into(),
        serial: Some(gyro.serial.to_string()),
        scale_factor: Some(scale),
        d_f: Some(bias.map_or(0.0, |c| c.value / scale) + m[(2, 2)] * gravity * gravity),
        d_i: Some(y.dot(&input)),
        d_s: Some(y.dot(&spin)),
        d_io: Some(2.0 * m[(0, 2)]),
        d_os: Some(2.0 * m[(2, 1)]),
        d_si: Some(2.0 * m[(1, 0)]),
        d_ii: Some(m[(0, 0)] - m[(2, 2)]),
        d_ss: Some(m[(1, 1)] - m[(2, 2)]),
        misalignment_arcmin: Some((ARCMIN_PER_RADIAN * mount.scaled_axis()).into()),
        states_e: if gyro.e_held { StatedE::True } else { StatedE::No },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::imu_model::{CampaignSample, compare, identify};
    use crate::core::judge::{Limits, State, forecast};
    use crate::simulate::simulate;

    /// A model of one campaign whose station states its errors `times` as large as they are.
    fn fitted(times: f64) -> AugmentedModel {
        let mut scenario = Scenario { seed: 7, ..Scenario::default() };
        scenario.programme.rates_arcsec_s = vec![360.0, 1800.0];
        scenario.temperature.mean_c = 38.0;
        let mut campaign = simulate(&scenario).unwrap().campaign;
        let errors = campaign.dwells.iter_mut().filter_map(|dwell| dwell.output_sem_pulse_s.as_mut());
        errors.flatten().for_each(|sem| *sem *= times);
        let plain = AugmentedModel::default();
        let sample = CampaignSample { campaign: &campaign, source: None, occasions: Vec::new() };
        identify(&[sample], &plain).unwrap().into_model(&plain)
    }

    #[test]
    fn an_imu_drawn_from_its_model_comes_out_as_the_model_foretells_whatever_the_station_states_of_its_errors() {
        for times in [0.5, 1.0, 3.0] {
            let model = fitted(times);
            let identified = model.identified.as_ref().unwrap();
            let (mut squares, mut count) = (0.0, 0.0);
            for seed in 0..6 {
                let open = Scenario { seed, ..Scenario::default() };
                let (scenario, drawn) = drawn_from(&open, &model).unwrap();
                let mut campaign = simulate(&scenario).unwrap().campaign;
                state_as_fitted(&mut campaign, &drawn);
                let found = compare(identified, &campaign).unwrap();
                squares += found.rms_over_sd.powi(2) * found.count as f64;
                count += found.count as f64;
                let verdict = forecast(&found.foretold(identified), Limits::default().forecast()).unwrap();
                assert_eq!(verdict.state, State::Within, "{times} {seed}: {verdict}");
            }
            assert!((f64::sqrt(squares / count) - 1.0).abs() < 0.1, "{times}: {}", f64::sqrt(squares / count));
        }
    }
}
