//! Outputs with effects put in by hand, and what an augmented model makes of them.

use nalgebra::{Rotation3, Vector3};

use super::*;
use crate::core::augmented::Options;
use crate::core::calibrate::{Calibration, EffectParameter, calibrate_at_station, calibrate_augmented};
use crate::core::campaign::made_for_tests::{self, name};
use crate::core::campaign::{CampaignGyro, Dwell};
use crate::core::effects::{HypothesisDefinition, MissingInput, OwnHypothesis, Refusal, Shape, own};
use crate::core::frames::Rotation;
use crate::core::model::{Term, Terms};
use crate::core::mounting::Slot;

const RAMP: f64 = 0.5;
const BY_TEMPERATURE: [f64; 2] = [0.04, -0.07];
const AZIMUTH: f64 = 0.004;
const SCALES: [f64; 2] = [1.6, 2.5];

/// Two gyros along x and y whose north is off by [`AZIMUTH`]; G1 drifts with time, both with temperature.
fn campaign() -> Campaign {
    let earth = Vector3::new(0.0, 11.5, 9.7);
    let north_off = earth + Vector3::new(0.0, 0.0, AZIMUTH).cross(&earth);
    let temperature = |k: usize| 20.0 + (1.9 * k as f64).sin();
    let mean = (0..30).map(temperature).sum::<f64>() / 30.0;
    let dwell = |k: usize| {
        let turn = k as f64;
        let attitude = Rotation3::from_euler_angles(2.4 * turn, 1.1 * turn, 0.7 * turn);
        let force = attitude * Vector3::z();
        let output = |j: usize| {
            let own = if j == 0 { RAMP * 240.0 * turn / 3600.0 } else { 0.0 };
            let drift = 0.3 + 2.0 * force.x - force.y + own + BY_TEMPERATURE[j] * (temperature(k) - mean);
            SCALES[j] * ((attitude * north_off)[j] + drift)
        };
        Dwell {
            attitude: Some(Rotation::stated_as(attitude)),
            temperature_c: Some(temperature(k)),
            output_sem_pulse_s: Some(vec![1e-3; 2]),
            ..made_for_tests::dwell(k, force, attitude * earth, vec![output(0), output(1)])
        }
    };
    let gyro = |slot, e| CampaignGyro { slot, serial: name("A"), known_e: Some(e) };
    let gyros = vec![gyro(Slot::G1, Vector3::x() * SCALES[0]), gyro(Slot::G2, Vector3::y() * SCALES[1])];
    made_for_tests::campaign(gyros, (0..30).map(dwell).collect())
}

fn adopted(effect: Effect, shape: Shape, slots: &[Slot]) -> Adopted {
    Adopted { effect, shape, slots: slots.to_vec() }
}

fn values(of: &[EffectParameter]) -> Vec<(Effect, &'static str, f64)> {
    of.iter().map(|e| (e.effect, e.coefficient.unit, e.value)).collect()
}

fn is(found: &[(Effect, &str, f64)], expected: &[(Effect, &str, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!((found.0, found.1), (expected.0, expected.1));
        assert!((found.2 - expected.2).abs() < 1e-8, "{found:?} is not {expected:?}");
    }
}

#[test]
fn adopted_effects_come_back_for_the_gyros_that_have_them() {
    let both = [Slot::G1, Slot::G2];
    let model = [
        adopted(Effect::Azimuth, Shape::Linear, &both),
        adopted(Effect::TimeRamp, Shape::Linear, &both[..1]),
        adopted(Effect::TemperatureBias, Shape::Linear, &both),
        // After the first instant of all it is the bias itself.
        adopted(Effect::BiasStep, Shape::Instant(-1.0), &both[1..]),
    ];
    let mut campaign = campaign();
    let found = calibrate_augmented(&campaign, Terms::MODEL_6, &model);
    let (ramp, azimuth) = ((Effect::TimeRamp, "deg/h/h", RAMP), (Effect::Azimuth, "rad", AZIMUTH));
    let by_temperature = BY_TEMPERATURE.map(|k| (Effect::TemperatureBias, "deg/h/K", k));
    is(&values(&found.gyros[0].effects), &[ramp, by_temperature[0], azimuth]);
    is(&values(&found.gyros[1].effects), &[by_temperature[1], azimuth]);
    let step = CampaignNote::EffectLeftOut {
        slot: Some(Slot::G2),
        effect: Effect::BiasStep,
        why: EffectNotFitted::NotDistinguished,
    };
    assert_eq!(found.notes, [step]);
    for (fit, scale) in found.gyros.iter().zip(SCALES) {
        // The drift is on the body's axes, so G is the same but for the scale.
        let g = fit.g().expect("fitted") / scale;
        assert!((g - Vector3::new(2.0, -1.0, 0.0)).norm() < 1e-8 && fit.chi2 < 1e-9, "{g} {}", fit.chi2);
    }

    // Without a temperature that effect alone is left out, and says why.
    campaign.dwells.iter_mut().for_each(|dwell| dwell.temperature_c = None);
    let found = calibrate_augmented(&campaign, Terms::MODEL_6, &model[1..3]);
    let why = EffectNotFitted::Lacks(MissingInput::Temperature);
    assert_eq!(found.notes, [CampaignNote::EffectLeftOut { slot: None, effect: Effect::TemperatureBias, why }]);
    assert_eq!(found.gyros[0].effects.len(), 1);

    // Outputs that never change have no axes, and so no effects.
    campaign.dwells.iter_mut().for_each(|dwell| dwell.output_pulse_s[1] = 7.0);
    let found = calibrate_augmented(&campaign, Terms::MODEL_6, &model[1..2]);
    let why = Refusal::NoOutput("G2");
    assert_eq!(found.notes, [CampaignNote::EffectsLeftOut { why }]);
    assert!(found.gyros.iter().all(|gyro| gyro.effects.is_empty()));
}

#[test]
fn a_column_adds_where_it_leaves_more_than_a_millionth_of_its_power() {
    // Beside the unit vector e1: (1, t) keeps t^2/(1 + t^2) of its power.
    let base = DMatrix::from_column_slice(3, 1, &[1.0, 0.0, 0.0]);
    let with = |t: f64| DVector::from_vec(vec![1.0, t, 0.0]);
    let pairs = |columns: Vec<DVector<f64>>| columns.into_iter().map(|c| (c.norm_squared(), c));
    let (adds, basis) = adding(
        Basis::of_orthonormal(&base),
        pairs(vec![with(0.9e-3), with(1.1e-3), with(5.0), DVector::from_vec(vec![0.0, 3.0, 4.0])]),
    );
    assert_eq!(adds, [false, true, false, true]);
    assert!((basis.matrix(3) - DMatrix::identity(3, 3)).norm() < 1e-9);
    let (kept, hidden) = told_apart(vec![1, 2, 3, 4], &adds, |one| (*one == 3).then_some(Effect::Azimuth));
    assert_eq!((kept, hidden), (vec![2, 4], vec![Effect::Azimuth]));
}

#[test]
fn an_effect_of_several_shared_coefficients_comes_back_beside_another() {
    let both = [Slot::G1, Slot::G2];
    let model = [Effect::Azimuth, Effect::Levelling].map(|effect| adopted(effect, Shape::Linear, &both));
    let shared = regressors(&campaign(), (&model, &[]), None).shared;
    let names: Vec<&str> = shared.iter().map(|gyros| gyros[0].as_ref().expect("G1 has it").coefficient.name).collect();
    let of = |effect: Effect| effect.entry().coefficients(Shape::Linear);
    let expected = [of(Effect::Azimuth), of(Effect::Levelling)].concat();
    assert_eq!(names, expected.iter().map(|c| c.name).collect::<Vec<_>>());
    assert!(shared.iter().all(|gyros| gyros.iter().all(Option::is_some)));
    assert_eq!(names.len(), 3);
}

#[test]
fn further_columns_are_parameters_of_their_own_that_no_gauge_touches() {
    let terms = Terms::of(&[crate::core::model::Term::Bias, crate::core::model::Term::GSquared]);
    let plain = Design::new(&campaign().dwells, terms);
    let coefficient = Effect::Levelling.entry().coefficients(Shape::Linear)[0];
    let column = |from: usize| DVector::from_fn(30, |k, _| (from + k) as f64);
    let regressor = |from| Regressor { effect: Effect::Levelling, coefficient, column: column(from) };
    let more = extended(&plain, &[regressor(100), regressor(200)]);
    // D0 and three P less the gauge, then two.
    assert_eq!((more.reduced.shape(), more.expand.shape()), ((30, 5), (6, 5)));
    assert_eq!(more.reduced.columns(0, 3), plain.reduced.columns(0, 3));
    assert_eq!((more.reduced.column(3), more.reduced.column(4)), (column(100).column(0), column(200).column(0)));
    let mut expand = DMatrix::zeros(6, 5);
    expand.view_mut((0, 0), (4, 3)).copy_from(&plain.expand);
    (expand[(4, 3)], expand[(5, 4)]) = (1.0, 1.0);
    assert_eq!(more.expand, expand);
    let gauge = more.gauge.expect("|a| is 1");
    assert_eq!((gauge.len(), gauge.rows(0, 4).into_owned()), (6, plain.gauge.expect("|a| is 1")));
    assert_eq!((gauge[4], gauge[5]), (0.0, 0.0));
}

#[test]
fn what_the_model_knows_better_is_held_and_states_the_bias_at_its_temperature() {
    let both = [Slot::G1, Slot::G2];
    let adopted = vec![
        adopted(Effect::Azimuth, Shape::Linear, &both),
        adopted(Effect::TimeRamp, Shape::Linear, &both[..1]),
        adopted(Effect::TemperatureBias, Shape::Linear, &both),
    ];
    let known = |sd: f64| -> Vec<KnownCoefficient> {
        let one = |(slot, value): (Slot, f64)| KnownCoefficient {
            slot,
            effect: Effect::TemperatureBias,
            name: "k",
            value,
            sd,
        };
        both.into_iter().zip(BY_TEMPERATURE).map(one).collect()
    };
    let mut campaign = campaign();
    let mean = campaign.dwells.iter().filter_map(|dwell| dwell.temperature_c).sum::<f64>() / 30.0;
    let fit = |campaign: &Campaign, known: Vec<KnownCoefficient>| {
        let model = Options { adopted: adopted.clone(), known, ..Options::default() };
        calibrate_at_station(campaign, Terms::MODEL_6, &model, Some(mean))
    };
    let bias = |found: &Calibration, j: usize| {
        let bias = found.gyros[j].parameters.iter().find(|one| one.term == Term::Bias).expect("fitted");
        (bias.value / SCALES[j], bias.sd.expect("stated") / SCALES[j])
    };
    // What these dwells tell as well is fitted, and what they contradict.
    for known in
        [known(1.0), known(1e-6).into_iter().map(|one| KnownCoefficient { value: one.value + 0.1, ..one }).collect()]
    {
        let found = fit(&campaign, known);
        assert!(found.notes.is_empty() && (bias(&found, 1).0 - 0.3).abs() < 1e-8, "{:?}", found.notes);
    }
    // 3 K warmer without any change they do not tell it.
    for dwell in &mut campaign.dwells {
        let before = dwell.temperature_c.replace(mean + 3.0).expect("stated") - mean;
        for (j, output) in dwell.output_pulse_s.iter_mut().enumerate() {
            *output += SCALES[j] * BY_TEMPERATURE[j] * (3.0 - before);
        }
    }
    let found = fit(&campaign, known(0.01));
    let note = |slot| {
        let (slot, effect) = (Some(slot), Effect::TemperatureBias);
        CampaignNote::EffectLeftOut { slot, effect, why: EffectNotFitted::Held }
    };
    assert_eq!(found.notes, both.map(note));
    for j in 0..2 {
        let (value, sd) = bias(&found, j);
        assert!((value - 0.3).abs() < 1e-8 && (sd - 0.03).abs() < 1e-3, "{value} +- {sd}");
    }
    assert!((bias(&fit(&campaign, Vec::new()), 1).0 - 0.09).abs() < 1e-8, "without it the bias steps");
    // The same where the temperature is stated of the whole campaign alone.
    campaign.dwells.iter_mut().for_each(|dwell| dwell.temperature_c = None);
    campaign.temperature_c = Some(mean + 3.0);
    assert!((bias(&fit(&campaign, known(0.01)), 1).0 - 0.3).abs() < 1e-8, "{:?}", fit(&campaign, known(0.01)).notes);
    // The rank is that of model (6), whatever is fitted beside it.
    let plain = calibrate_at_station(&campaign, Terms::MODEL_6, &Options::default(), None);
    let ranks = |found: &Calibration| found.gyros.iter().map(|gyro| gyro.rank).collect::<Vec<usize>>();
    assert_eq!(ranks(&fit(&campaign, known(0.01))), ranks(&plain));
    // Nobody states one: the bias is as measured, and any temperature (36 K about 20 deg C) may have made it.
    campaign.temperature_c = None;
    let found = fit(&campaign, known(0.01));
    for (j, by_temperature) in BY_TEMPERATURE.into_iter().enumerate() {
        let (value, sd) = bias(&found, j);
        let square = crate::core::campaign::any_kelvin(mean).map(|(kelvin, weight)| weight * kelvin * kelvin);
        let expected = by_temperature.hypot(0.01) * square.sum::<f64>().sqrt();
        assert!(
            (value - 0.3 - 3.0 * by_temperature).abs() < 1e-8 && (sd / expected - 1.0).abs() < 1e-3,
            "{value} {sd}"
        );
        assert!(found.gyros[j].effects.iter().all(|one| one.effect != Effect::TemperatureBias));
    }
    let any =
        |note: &CampaignNote| matches!(note, CampaignNote::EffectLeftOut { why: EffectNotFitted::AnyTemperature, .. });
    assert!(found.notes.len() == 2 && found.notes.iter().all(any), "{:?}", found.notes);
    // Of a gyro that was exchanged nothing is known, and it is said.
    let found = fit(&campaign, known(0.01).into_iter().filter(|one| one.slot == Slot::G2).collect());
    let left_out = CampaignNote::EffectLeftOut {
        slot: Some(Slot::G1),
        effect: Effect::TemperatureBias,
        why: EffectNotFitted::Lacks(MissingInput::Temperature),
    };
    assert!(found.notes.contains(&left_out) && bias(&found, 0).1 < 1e-2, "{:?}", found.notes);
}

#[test]
fn what_any_temperature_does_need_not_be_linear_in_it() {
    let written = HypothesisDefinition {
        id: "bent_bias".into(),
        words: "bent".into(),
        cause: "oil".into(),
        equation: "k * T^2".into(),
        unit: "deg/(h K^2)".into(),
        plausible: 1.0,
        typical: [1e-6, 1e-3],
        common: false,
        range: None,
    };
    let effect = own(OwnHypothesis::of(written).expect("it makes sense")).expect("there is room");
    let known = vec![KnownCoefficient { slot: Slot::G2, effect, name: "k", value: 1e-3, sd: 0.0 }];
    let model = Options { adopted: vec![adopted(effect, Shape::Linear, &[Slot::G2])], known, ..Options::default() };
    let mut campaign = campaign();
    campaign.dwells.iter_mut().for_each(|dwell| dwell.temperature_c = None);
    let sd_of_bias = |options: &Options| {
        let found = calibrate_at_station(&campaign, Terms::MODEL_6, options, Some(20.0));
        let bias = found.gyros[1].parameters.iter().find(|one| one.term == Term::Bias).expect("fitted");
        bias.sd.expect("stated") / SCALES[1]
    };
    let (of_both, of_noise) = (sd_of_bias(&model), sd_of_bias(&Options::default()));
    // T^4 from -40 to 85 deg C about 20 is (65^5 + 60^5)/625 on the mean.
    let (of_effect, expected) = ((of_both.powi(2) - of_noise.powi(2)).sqrt(), 1e-3 * 3_100_625.0_f64.sqrt());
    assert!((of_effect / expected - 1.0).abs() < 1e-3, "{of_effect} {expected} beside {of_noise}");
}

/// A torquer's scale factor follows temperature: it multiplies all that the gyro senses, D_I and D_S alike.
#[test]
fn a_scale_factor_at_another_temperature_leaves_the_drift_as_it_is() {
    const BY_KELVIN: f64 = 5e-4;
    let both = [Slot::G1, Slot::G2];
    let known = both.map(|slot| {
        let (effect, value, sd) = (Effect::TemperatureScale, BY_KELVIN, 1e-6);
        KnownCoefficient { slot, effect, name: "k", value, sd }
    });
    let mut campaign = campaign();
    for dwell in &mut campaign.dwells {
        dwell.temperature_c = Some(26.0);
        let (rate, force) = (dwell.rate_arcsec_s, dwell.specific_force_g0);
        for (j, output) in dwell.output_pulse_s.iter_mut().enumerate() {
            *output = SCALES[j] * (1.0 + 6.0 * BY_KELVIN) * (rate[j] + 0.3 + 2.0 * force.x - force.y);
        }
    }
    campaign.gyros.iter_mut().for_each(|gyro| gyro.known_e = None);
    let adopted = vec![adopted(Effect::TemperatureScale, Shape::Linear, &both)];
    let model = Options { adopted, known: known.to_vec(), ..Options::default() };
    let found = calibrate_at_station(&campaign, Terms::MODEL_6, &model, Some(20.0));
    for (gyro, scale) in found.gyros.iter().zip(SCALES) {
        let (e, g) = (gyro.e().expect("fitted").norm(), gyro.g().expect("fitted"));
        assert!((e / scale - 1.0).abs() < 1e-5, "{e} {scale}: {:?}", found.notes);
        assert!((g / e - Vector3::new(2.0, -1.0, 0.0)).norm() < 1e-4, "{g} {e}");
    }
}
