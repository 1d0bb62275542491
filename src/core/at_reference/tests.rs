//! Records at another temperature than their model's, with figures worked out by hand.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::*;
use crate::core::augmented::KnownEffect;
use crate::core::effects::{Estimate, HypothesisDefinition, OwnHypothesis, Shape, own};
use crate::core::imu_model::{Identified, ModelGyro, NoiseLaw, Validity};
use crate::core::model::Terms;
use crate::core::mounting::{Geometry, Slot};
use crate::core::record::Name;
use crate::core::time::UtcMicros;

/// I and S of G1 along x and y.
const SCALE: f64 = 1.5;
const REFERENCE_C: f64 = 20.0;
/// Mean of T^2 and T^4 from -40 to 85 deg C about 20: (65^3 + 60^3)/375 and (65^5 + 60^5)/625.
const SQUARE: f64 = 1_308.333_333;
const FOURTH: f64 = 3_100_625.0;

fn name(text: &str) -> Name {
    Name::parse(text).expect("a name")
}

fn gyro() -> GyroParameters {
    GyroParameters {
        slot: Slot::G1,
        serial: name("LFG-0"),
        e: Vector3::x() * SCALE,
        g: Vector3::new(2.0, -1.0, 0.0) * SCALE,
        p: Vector3::zeros(),
        bias: 0.0,
        e_sd: Some(Vector3::repeat(1e-6)),
        g_sd: Some(Vector3::repeat(1e-4)),
        g_is_ratio: false,
    }
}

fn record(temperature_c: Option<f64>) -> Record {
    Record {
        imu: name("IMU-07"),
        station: name("ST-2"),
        calibrated_at: UtcMicros(0),
        geometry: Geometry::Orthogonal,
        gyros: vec![gyro()],
        temperature_c,
        campaign: None,
        operator: None,
        note: None,
    }
}

/// What the model knows of G1, or of all gyros in common.
fn model((effect, shape): (Effect, Shape), slot: Option<Slot>, values: &[f64], sd: f64) -> AugmentedModel {
    let coefficients = effect.entry().coefficients(shape).into_iter().zip(values);
    let estimates = coefficients.map(|(c, value)| Estimate { slot, name: c.name, value: *value, sd, unit: c.unit });
    let noise = NoiseLaw { sem_factor: None, random_walk: 1e-3, rate_ppm: 0.0, dof: 60.0 };
    let GyroParameters { slot, serial, e, g, .. } = gyro();
    let identified = Identified {
        imu: name("IMU-07"),
        geometry: Geometry::Orthogonal,
        terms: Terms::MODEL_6,
        reference_c: Some(REFERENCE_C),
        measured_at: UtcMicros(0),
        gyros: vec![ModelGyro { slot, serial, e_held: false, e, g, noise }],
        effects: Vec::new(),
        coefficients: Vec::new(),
        covariance: DMatrix::zeros(0, 0),
        campaigns: Vec::new(),
        validity: Validity { temperature_c: None, rate_arcsec_s: 0.0, directions: Vec::new() },
    };
    let adopted = Adopted { effect, shape, slots: vec![Slot::G1] };
    AugmentedModel {
        effects: vec![KnownEffect { adopted, estimates: estimates.collect() }],
        identified: Some(Arc::new(identified)),
        ..AugmentedModel::default()
    }
}

fn square_of_temperature(common: bool) -> Effect {
    let written = HypothesisDefinition {
        id: if common { "bent_in_common" } else { "bent" }.into(),
        words: "bent".into(),
        cause: "oil".into(),
        equation: "k * T^2 * a_S".into(),
        unit: "deg/(h g0 K^2)".into(),
        plausible: 1.0,
        typical: [1e-4, 1e-2],
        common,
        range: None,
    };
    own(OwnHypothesis::of(written).unwrap()).unwrap()
}

/// G/|E| and the covariance that was added to it, deg/(h g0).
fn found(model: &AugmentedModel, temperature_c: Option<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let at = at_reference(model, &record(temperature_c), &gyro(), None);
    assert_eq!(at.unknown, []);
    let (restated, covariance) = at.restated.expect("it is known");
    let added = covariance.expect("stated").fixed_view::<3, 3>(3, 3) - Matrix3::identity() * 1e-8;
    (restated.g / SCALE, added / (SCALE * SCALE))
}

#[test]
fn an_equation_that_is_not_linear_in_temperature_has_its_mean_square_where_none_is_stated() {
    let model = model((square_of_temperature(false), Shape::Linear), Some(Slot::G1), &[0.01], 0.001);
    let (g, added) = found(&model, Some(REFERENCE_C + 6.0));
    assert!((g - Vector3::new(2.0, -1.36, 0.0)).norm() < 1e-12, "{g}");
    assert!((added - Matrix3::from_diagonal(&Vector3::new(0.0, 0.036 * 0.036, 0.0))).norm() < 1e-12, "{added}");
    let (g, added) = found(&model, None);
    assert!((g - Vector3::new(2.0, -1.0, 0.0)).norm() < 1e-12, "as measured: {g}");
    let expected = (0.01 * 0.01 + 0.001 * 0.001) * FOURTH;
    assert!((added[(1, 1)] / expected - 1.0).abs() < 1e-3 && added[(0, 0)] == 0.0, "{added} {expected}");
}

#[test]
fn one_temperature_moves_d_i_and_d_s_together() {
    let model = model((Effect::TemperatureG, Shape::InputSpin), Some(Slot::G1), &[0.003, -0.002], 0.0);
    let (g, _) = found(&model, Some(REFERENCE_C + 6.0));
    assert!((g - Vector3::new(1.982, -0.988, 0.0)).norm() < 1e-12, "{g}");
    let (_, added) = found(&model, None);
    for (place, product) in [((0, 0), 9e-6), ((1, 1), 4e-6), ((0, 1), -6e-6), ((2, 2), 0.0)] {
        assert!((added[place] - product * SQUARE).abs() < 1e-8, "{place:?}: {added}");
    }
}

#[test]
fn what_does_not_move_g_restates_nothing_and_what_is_known_of_others_is_said() {
    for effect in [Effect::TemperatureBias, Effect::TemperatureScale] {
        let model = model((effect, Shape::Linear), Some(Slot::G1), &[0.01], 0.001);
        assert_eq!(at_reference(&model, &record(None), &gyro(), None), AtReference::default(), "{effect:?}");
    }
    let effect = square_of_temperature(false);
    let exchanged = GyroParameters { serial: name("LFG-9"), ..gyro() };
    let of_other = model((effect, Shape::Linear), Some(Slot::G1), &[0.01], 0.001);
    let in_common = square_of_temperature(true);
    let of_all = model((in_common, Shape::Linear), None, &[0.01], 0.001);
    for (model, gyro, effect) in [(of_other, exchanged, effect), (of_all, gyro(), in_common)] {
        for temperature_c in [Some(26.0), None] {
            let at = at_reference(&model, &record(temperature_c), &gyro, None);
            assert_eq!(at, AtReference { restated: None, unknown: vec![effect] });
        }
    }
}
