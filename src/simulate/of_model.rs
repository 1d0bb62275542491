//! A scenario whose IMU is one that a model file describes: its gyros, its effects, its noise.

use nalgebra::{Matrix3, Vector3};

use super::scenario::{AxesChoice, GeometryChoice, GyroChoice, Scenario, StatedE};
use super::station::Earth;
use super::{Stream, gaussian, random};
use crate::core::augmented::{AugmentedModel, KnownEffect};
use crate::core::effects::Estimate;
use crate::core::fault::Faults;
use crate::core::imu_model::{Identified, ModelGyro, Of, drawn};
use crate::core::model::Term;
use crate::core::mounting::{Geometry, Slot};

const ARCMIN_PER_RADIAN: f64 = 180.0 * 60.0 / std::f64::consts::PI;

/// The IMU as one of those that the model's covariance allows, by the scenario's seed, in that scenario; and the model
/// with the coefficients drawn, for [`super::augment::augment`].
pub fn drawn_from(base: &Scenario, model: &AugmentedModel) -> Result<(Scenario, AugmentedModel), Faults> {
    let Some(identified) = &model.identified else { return Ok((base.clone(), model.clone())) };
    let mut rng = random(base.seed, Stream::Model);
    let z: Vec<f64> = (0..2 * identified.coefficients.len()).map(|_| gaussian(&mut rng)).collect();
    let one = drawn(identified, &z);
    let scenario = scenario_of(base, &one)?;
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
