use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::calibration::GAUGE;
use super::noise_found::LawFound;
use super::*;
use crate::core::campaign::made_for_tests::{self, name};
use crate::core::campaign::{CampaignGyro, Site, StationPart};
use crate::core::model::Term;
use crate::core::mounting::Slot;
use crate::core::record::Plausibility;
use crate::words::Language;

/// Commanded specific force, rate, output, standard error.
type Row = ([f64; 3], [f64; 3], f64, Option<f64>);

fn campaign(rows: &[Row], known_e: Option<[f64; 3]>) -> Campaign {
    let dwell = |(k, (a, w, y, sem)): (usize, &Row)| Dwell {
        phase: if Vector3::from(*w).norm() > 20.0 { Phase::Rate } else { Phase::Static },
        output_sem_pulse_s: sem.map(|s| vec![s]),
        ..made_for_tests::dwell(k, Vector3::from(*a), Vector3::from(*w), vec![*y])
    };
    let gyro = CampaignGyro { slot: Slot::G1, serial: name("A"), known_e: known_e.map(Vector3::from) };
    made_for_tests::campaign(vec![gyro], rows.iter().enumerate().map(dwell).collect())
}

const FACES: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

fn value(fit: &GyroCalibration, name: &str) -> (f64, f64) {
    let p = fit.parameters.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("{name} was fitted"));
    (p.value, p.sd.unwrap_or(f64::NAN))
}

fn assert_close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} is not {b}");
}

/// E held at (2, 0, 0), at rest on six faces: half a step of the vertical rate is 2 of it in G_x (GUM 2008, 4.3.7).
#[test]
fn what_rounding_makes_of_the_earths_rate_in_all_dwells_alike_is_in_the_sd_of_g() {
    let sd_of_g_x = |vertical: f64, across: f64| {
        let row = |(a, y): (&[f64; 3], f64)| {
            let rate = Vector3::from(*a) * vertical + Vector3::new(a[2], a[0], a[1]) * across;
            (*a, rate.into(), y, Some(1e-3))
        };
        let rows: Vec<Row> = FACES.iter().zip([7.0, 1.0, 5.0, 3.0, 9.0, 11.0]).map(row).collect();
        value(&calibrate(&campaign(&rows, Some([2.0, 0.0, 0.0])), Terms::MODEL_6).gyros[0], "G_x").1
    };
    let noise = 1e-6 / 2.0;
    assert_close(sd_of_g_x(8.47, 12.43), (noise + (2.0 * 0.01_f64).powi(2) / 12.0).sqrt());
    assert_close(sd_of_g_x(8.465_121_7, 12.432_849_3), noise.sqrt());
}

/// Six faces, E held at (2, 0, 0), no rates, outputs 7, 1, 5, 3, 9, 11 +- 0.3. By hand: G is half the difference
/// of a pair, (3, 1, -1), var sigma^2/2. Half the sums are (4, 4, 10) = D0 + P; with P_x + P_y + P_z = 0,
/// D0 = 6, var sigma^2/6, and P = (-2, -2, 4), var sigma^2/2 - sigma^2/6 = sigma^2/3.
/// D_I = G_x/2, D_S = G_y/2 on the orthogonal mounting of G1, sd sigma/sqrt 2/2.
#[test]
fn six_faces_are_fitted_as_by_hand() {
    let outputs = [7.0, 1.0, 5.0, 3.0, 9.0, 11.0];
    let rows: Vec<Row> = FACES.iter().zip(outputs).map(|(a, y)| (*a, [0.0; 3], y, Some(0.3))).collect();
    let campaign = campaign(&rows, Some([2.0, 0.0, 0.0]));
    let calibration = calibrate(&campaign, Terms::MODEL_6);
    let fit = &calibration.gyros[0];
    let sigma = |share: f64| 0.3 * share.sqrt();
    for (name, by_hand, sd) in [
        ("D0", 6.0, sigma(1.0 / 6.0)),
        ("G_x", 3.0, sigma(0.5)),
        ("G_y", 1.0, sigma(0.5)),
        ("G_z", -1.0, sigma(0.5)),
        ("P_x", -2.0, sigma(1.0 / 3.0)),
        ("P_y", -2.0, sigma(1.0 / 3.0)),
        ("P_z", 4.0, sigma(1.0 / 3.0)),
    ] {
        assert_close(value(fit, name).0, by_hand);
        assert_close(value(fit, name).1, sd);
    }
    assert_eq!((fit.rank, fit.dof, fit.scale_source), (6, 0, ScaleSource::Held));
    assert_eq!(fit.null_directions.len(), 1);
    let null = &fit.null_directions[0];
    assert_eq!(null.gauge, Some(GAUGE));
    for (found, by_hand) in null.direction.iter().zip([0.5, 0.0, 0.0, 0.0, -0.5, -0.5, -0.5]) {
        assert_close(*found, by_hand);
    }
    let drift = fit.separate(&campaign.geometry, &Plausibility::default()).expect("E is held, G is seen");
    assert_close(drift.rigid.d_i, 1.5);
    assert_close(drift.rigid.d_s, 0.5);
    assert_close(drift.rigid.sd().expect("standard errors are given")[0], sigma(0.5) / 2.0);
}

/// One axis, turned at +-1000 arcsec/s with Z up, E = (0, 0, 2), D0 = 3: E_z = (y+ - y-)/2000, D0 = (y+ + y-)/2.
#[test]
fn two_rates_give_scale_and_bias_and_nothing_else() {
    let z = [0.0, 0.0, 1.0];
    let rows = [(z, [0.0, 0.0, 1000.0], 2003.0, Some(1.0)), (z, [0.0, 0.0, -1000.0], -1997.0, Some(1.0))];
    let fit = &calibrate(&campaign(&rows, None), Terms::of(&[Term::Bias, Term::Scale])).gyros[0];
    assert_close(value(fit, "E_z").0, 2.0);
    assert_close(value(fit, "E_z").1, 0.5f64.sqrt() / 1000.0);
    assert_close(value(fit, "D0").0, 3.0);
    let undetermined: Vec<&str> = fit.parameters.iter().filter(|p| !p.determined).map(|p| p.name).collect();
    assert_eq!(undetermined, ["E_x", "E_y"]);
    assert!(value(fit, "E_x").1.is_nan(), "what is not determined has no standard deviation");
}

fn reason(rows: &[Row], known_e: Option<[f64; 3]>, terms: Terms) -> String {
    let campaign = campaign(rows, known_e);
    let calibration = calibrate(&campaign, terms);
    for fit in &calibration.gyros {
        assert!(fit.parameters.iter().all(|p| p.value.is_finite() && p.sd.is_none_or(f64::is_finite)));
        assert!(fit.residuals.iter().chain(fit.leverage.iter()).all(|x| x.is_finite()));
        assert!(fit.standardised.iter().flat_map(|s| s.iter()).all(|x| x.is_finite()));
    }
    let separations = calibration.separate(&campaign.geometry, &Plausibility::default());
    Language::English.words(&separations[0].as_ref().expect_err("no drift").message())
}

#[test]
fn a_campaign_that_cannot_carry_the_model_says_what_is_missing() {
    let still = |a: [f64; 3], y: f64| (a, [0.0; 3], y, Some(0.1));
    let e = Some([2.0, 0.0, 0.0]);
    let all = Terms::MODEL_6;
    let one_face = [still(FACES[4], 1.0), still(FACES[4], 1.1)];
    assert!(
        reason(&one_face, e, all)
            .starts_with("the dwells do not determine G_x, G_y, G_z; dwells with other directions")
    );
    assert!(reason(&one_face[..1], None, all).contains("G_z, E_x, E_y, E_z"), "one dwell");
    let faces: Vec<Row> = FACES.iter().map(|a| still(*a, a[0])).collect();
    assert!(reason(&faces, None, all).contains("do not determine E_x, E_y, E_z; dwells with other rates"), "no rates");
    assert!(reason(&faces, None, all.without(Term::Scale)).contains("neither fitted (no scale term) nor held"));
    assert!(reason(&faces, e, all.without(Term::GLinear)).contains("no g_linear term"));
    assert!(reason(&faces[..2], e, all).contains("G_y, G_z") || reason(&faces[..2], e, all).contains("G_x"), "too few");
    let zero: Vec<Row> = FACES.iter().map(|a| (*a, [0.0; 3], 0.0, None)).collect();
    assert!(reason(&zero, None, all).contains("E_x"), "all outputs zero");
}

#[test]
fn e_of_another_slot_is_refused_with_the_angle() {
    let turn = |w: [f64; 3]| ([0.0, 0.0, 1.0], w, 2.0 * w[1], Some(0.1));
    let mut rows: Vec<Row> = FACES.iter().map(|a| (*a, [0.0; 3], 0.0, Some(0.1))).collect();
    rows.extend([[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 1e3]].map(turn));
    let words = reason(&rows, None, Terms::MODEL_6);
    assert!(words.contains("the fitted E is impossible") && words.contains("90.000 deg"), "{words}");
}

#[test]
fn standard_errors_are_rescaled_by_repeats() {
    // Twenty repeats of one position scatter by 0.2 about their mean where 0.1 is stated.
    let scatter = |k: usize| if k.is_multiple_of(2) { 0.2 } else { -0.2 };
    let rows: Vec<Row> = (0..20).map(|k| (FACES[0], [0.0; 3], 5.0 + scatter(k), Some(0.1))).collect();
    let mut calibration = calibrate_in_white_noise(&campaign(&rows, Some([1.0, 0.0, 0.0])), Terms::of(&[Term::Bias]));
    let mut quiet = calibration.gyros[0].clone();
    quiet.noise.factor = Some(1.0);
    calibration.gyros.push(quiet);
    // The root mean square of both gyros'.
    assert_close(calibration.sem_factor().expect("errors are stated"), ((84.0f64 / 23.0 + 1.0) / 2.0).sqrt());
    let fit = &calibration.gyros[0];
    let noise = fit.noise;
    assert_eq!((noise.source, noise.pure_error.dof), (noise::NoiseSource::SemAndRepeats, 19));
    // chi2 = 20 (0.2/0.1)^2 = 80; with four degrees of freedom in favour of 1, f^2 = 84/23.
    assert_close(noise.factor.expect("estimated"), (84.0f64 / 23.0).sqrt());
    // And the t of 23 degrees of freedom: sd^2 = (0.1^2/20) (84/23) (23/21).
    assert_close(value(fit, "D0").1, (0.01 / 20.0 * 84.0 / 21.0f64).sqrt());
}

/// Six faces with turns about each, `repeats` times over; the noise is `sd` of each rate, errors are stated as 0.1.
fn turning(repeats: usize, sd: impl Fn(f64) -> f64, left_out: impl Fn(f64) -> f64, seed: u64) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let rates = [0.0, 0.0, 600.0, -600.0, 1800.0, -1800.0];
    let rows: Vec<Row> = (0..36 * repeats)
        .map(|k| {
            // No turn is repeated: each round is faster than the one before.
            let (up, rate) = (FACES[k % 6], rates[k / 6 % 6] * (1.0 + 0.1 * (k / 36) as f64));
            let noise = sd(rate) * rng.sample::<f64, _>(StandardNormal);
            let y = up[0] * 3.0 + up[1] + up[0] * rate * 2.0 + left_out(up[0] * rate) + noise;
            (up, up.map(|a| a * rate), y, Some(0.1))
        })
        .collect();
    campaign(&rows, None)
}

#[test]
fn residuals_that_exceed_the_noise_are_said_with_the_law_that_would_explain_them() {
    let law = |sd: &dyn Fn(f64) -> f64, left_out: &dyn Fn(f64) -> f64, seed| {
        let notes = calibrate(&turning(2, sd, left_out, seed), Terms::MODEL_6).all_notes();
        notes.into_iter().find_map(|note| match note {
            CampaignNote::ResidualsExceedNoise { law, .. } => Some(law),
            _ => None,
        })
    };
    let grows = |rate: f64| 0.1 * (1.0 + 24.0 * (rate / 1800.0).powi(2)).sqrt();
    for seed in 500..510 {
        let found = law(&grows, &|_| 0.0, seed);
        assert!(matches!(found, Some(Some(LawFound::Rate { .. }))), "{seed}: {found:?}");
    }
    // What a face leaves out is of no law.
    let of_up = |rate: f64| if rate > 500.0 && rate < 700.0 { 1.5 } else { 0.0 };
    assert_eq!(law(&|_| 0.1, &of_up, 520), Some(None));
}

#[test]
fn a_drift_that_the_order_of_dwells_hides_is_told_by_what_it_moves() {
    // Turns first; then each face five times, up along all axes before down, or the faces in turn.
    let of = |in_order: bool, drift: f64| {
        let turns = [[600.0, 0.0, 0.0], [0.0, 600.0, 0.0], [0.0, 0.0, 600.0]];
        let turns = turns.iter().flat_map(|w| [*w, w.map(|w| -w)]).map(|w| (FACES[4], w));
        let faces = (0..30).map(|k| (FACES[if in_order { [0, 2, 4, 1, 3, 5][k / 5] } else { k % 6 }], [0.0; 3]));
        let rows: Vec<Row> = turns
            .chain(faces)
            .enumerate()
            .map(|(k, (a, w))| {
                let noise = if (k * k % 7).is_multiple_of(2) { 1e-3 } else { -1e-3 };
                (a, w, 3.0 * a[0] + a[1] + noise + 2.0 * (w[0] + drift * k as f64 / 15.0), Some(1e-3))
            })
            .collect();
        let found = outcome::evaluate(&campaign(&rows, None), &Plausibility::default());
        let Ok(outcome::Outcome::Imu { calibration, separations, .. }) = found else { panic!("{found:?}") };
        let rigid = &separations[0].as_ref().expect("it is separated").rigid;
        let note = calibration.all_notes().into_iter().find(|note| note.code() == "drift_aliased");
        (note, [rigid.d_i, rigid.d_s])
    };
    let (told, still) = of(true, 0.0);
    let Some(CampaignNote::DriftAliased { of: Some(of_gyro), drift, d_i, d_s }) = told else { panic!("{told:?}") };
    let (_, moved) = of(true, drift);
    for (moved, (still, said)) in moved.iter().zip(still.iter().zip([d_i, d_s])) {
        assert!(((moved - still).abs() - said).abs() < 1e-9, "{moved} {still} {said}");
    }
    // 36 dwells, one every four minutes.
    assert!(of_gyro.slot == Slot::G1 && (of_gyro.whole - drift * 35.0 / 15.0).abs() < 1e-12, "{of_gyro:?}");
    assert_eq!(of(false, 0.0).0, None);
}

#[test]
fn gyros_that_share_their_noise_are_said_with_its_correlation() {
    let rows: Vec<Row> = (0..40).map(|_| (FACES[0], [0.0; 3], 5.0, Some(0.1))).collect();
    let calibration = calibrate_in_white_noise(&campaign(&rows, Some([1.0, 0.0, 0.0])), Terms::of(&[Term::Bias]));
    // Three patterns of signs at right angles; G2 is as loud as it likes, and correlated with G1 by 0.8.
    let sign = |period: usize, k: usize| if k % period < period / 2 { 1.0 } else { -1.0 };
    let of = |slot: Slot, residual: &dyn Fn(usize) -> f64| GyroCalibration {
        slot,
        dof: 39,
        standardised: Some(nalgebra::DVector::from_fn(40, |k, _| residual(k))),
        ..calibration.gyros[0].clone()
    };
    let [first, third] = [of(Slot::G1, &|k| 3.0 * sign(2, k)), of(Slot::G3, &|k| 0.5 * sign(8, k))];
    let second = |shared: f64, own: f64| of(Slot::G2, &move |k| 7.0 * (shared * sign(2, k) + own * sign(4, k)));
    let found = noise_report::between(&[first.clone(), second(0.8, 0.6), third.clone()]);
    for ((one, other, correlation), expected) in
        found.iter().zip([(Slot::G1, Slot::G2, 0.8), (Slot::G1, Slot::G3, 0.0), (Slot::G2, Slot::G3, 0.0)])
    {
        assert_eq!((*one, *other), (expected.0, expected.1));
        assert_close(*correlation, expected.2);
    }
    assert_eq!(found.len(), 3);
    assert!(noise_report::between(&[first, second(0.1, 0.99), third]).is_empty(), "a tenth is chance");
}

#[test]
fn without_standard_errors_the_residuals_or_the_repeats_speak() {
    let line = |k: usize, bend: f64| {
        let x = k as f64 / 10.0 - 0.5;
        let noise = if k.is_multiple_of(3) { 0.02 } else { -0.01 };
        ([0.0, 0.0, 1.0], [0.0, 0.0, 10.0 * x], 3.0 + 20.0 * x + bend * x * x + noise, None)
    };
    let terms = Terms::of(&[Term::Bias, Term::Scale]);
    let straight: Vec<Row> = (0..11).map(|k| line(k, 0.0)).collect();
    let fit = &calibrate(&campaign(&straight, None), terms).gyros[0];
    assert_eq!(fit.noise.source, noise::NoiseSource::Residuals);
    assert_close(fit.noise.factor.expect("nine left over"), (fit.chi2 / 9.0).sqrt());

    let mut bent: Vec<Row> = (0..11).map(|k| line(k, 50.0)).collect();
    bent.extend((0..11).map(|k| line(k, 50.0)).map(|(a, w, y, s)| (a, w, y + 0.01, s)));
    let fit = &calibrate(&campaign(&bent, None), terms).gyros[0];
    assert_eq!(fit.noise.source, noise::NoiseSource::Repeats, "a bend is not noise");
    assert!(fit.noise.factor.expect("eleven pairs") < 0.01);
}

#[test]
fn standard_errors_that_residuals_contradict_are_raised() {
    let e = Some([2.0, 0.0, 0.0]);
    let at =
        |k: usize, size: f64| (FACES[k % 6], [0.0, 0.0, 1e-2 * k as f64], size * (k as f64 * 2.4).sin(), Some(0.1));
    let source = |size: f64| {
        let rows: Vec<Row> = (0..36).map(|k| at(k, size)).collect();
        calibrate(&campaign(&rows, e), Terms::MODEL_6).gyros[0].noise
    };
    assert_eq!(source(0.14).source, noise::NoiseSource::Sem);
    assert_eq!(source(1.0).source, noise::NoiseSource::SemAndResiduals);
    assert!(source(1.0).factor.is_some_and(|f| (4.0..10.0).contains(&f)));
}

#[test]
fn equal_positions_are_found_as_repeats_and_near_ones_are_not() {
    let rows: Vec<Row> = [0, 2, 0, 4, 2, 0]
        .into_iter()
        .enumerate()
        .map(|(k, face)| (FACES[face], [0.0, 0.0, if k == 5 { 1.0 } else { 0.0 }], 0.0, None))
        .collect();
    assert_eq!(crate::core::campaign::repeats::repeats(&campaign(&rows, None).dwells), [vec![0, 2], vec![1, 4]]);
}

#[test]
fn each_term_is_read_from_its_own_columns() {
    // D0 = 3, G = (1, -2, 4), P = (2, -3, 1), E = (0.6, 0, 0.8), without noise.
    let turn = |k: usize| (2.4 * k as f64, 1.1 * k as f64);
    let rows: Vec<Row> = (0..30)
        .map(|k| {
            let (s, t) = turn(k);
            let a = Vector3::new(s.cos() * t.cos(), s.sin() * t.cos(), t.sin());
            let w = 10.0 * Vector3::new((1.7 * t).sin(), (0.6 * s).cos(), (1.3 * s + 0.4 * t).cos());
            let squares = 2.0 * a.x * a.x - 3.0 * a.y * a.y + a.z * a.z;
            let y = 3.0 + a.x - 2.0 * a.y + 4.0 * a.z + squares + 0.6 * w.x + 0.8 * w.z;
            (a.into(), w.into(), y, Some(0.1))
        })
        .collect();
    let near = |found: Option<Vector3<f64>>, x: f64, y: f64, z: f64| {
        found.is_some_and(|found| (found - Vector3::new(x, y, z)).norm() < 1e-9)
    };
    let fit = |known_e, terms| calibrate(&campaign(&rows, known_e), terms).gyros.remove(0);
    let full = fit(None, Terms::MODEL_6);
    assert_close(full.bias().expect("fitted") * 1e-3, 3e-3);
    assert!(near(full.g(), 1.0, -2.0, 4.0) && near(full.p(), 2.0, -3.0, 1.0) && near(full.e(), 0.6, 0.0, 0.8));
    assert!((full.scale_factor().expect("determined") - 1.0).abs() < 1e-9);
    assert_eq!(full.reduced_chi2(), Some(full.chi2 / 21.0));
    let held = fit(Some([0.6, 0.0, 0.8]), Terms::MODEL_6);
    assert!(near(held.e(), 0.6, 0.0, 0.8) && held.of(Term::Scale).is_none() && near(held.p(), 2.0, -3.0, 1.0));
    assert_close(held.scale_factor().expect("held"), 1.0);
    // Without a term its figures are not there; and a scale that nothing shows is none.
    let scale = fit(None, Terms::of(&[Term::Scale]));
    assert_eq!((scale.bias(), scale.g(), scale.p()), (None, None, None));
    let one = calibrate(&campaign(&rows[..1], None), Terms::of(&[Term::Scale])).gyros.remove(0);
    assert_eq!((one.scale_factor(), one.reduced_chi2()), (None, Some(0.0).filter(|_| one.dof > 0)));
    let left = fit(None, Terms::of(&[Term::Bias]));
    assert_eq!((left.e(), left.scale_factor(), left.scale_source), (None, None, ScaleSource::Missing));
}

#[test]
fn how_the_figures_came_about_is_noted() {
    let face = |k: usize, sem: Option<f64>| (FACES[k % 6], [0.0, 0.0, 1e-2 * (k / 6) as f64], k as f64, sem);
    let fitted = |sem: Option<f64>, again: bool| {
        let mut rows: Vec<Row> = (0..18).map(|k| face(k, sem)).collect();
        rows.extend(again.then(|| face(0, sem)));
        // These outputs go with the time, which would be noted too.
        calibrate_in_white_noise(&campaign(&rows, Some([2.0, 0.0, 0.0])), Terms::MODEL_6)
    };
    let gyros = vec![Slot::G1];
    let mut with = fitted(Some(0.1), true);
    with.gyros[0].p_value = Some(0.5);
    assert_eq!(with.all_notes(), []);
    with.gyros[0].p_value = Some(0.9e-3);
    assert_eq!(with.all_notes(), [CampaignNote::ResidualsExceedNoise { gyros: gyros.clone(), law: None }]);
    with.gyros[0].p_value = Some(1e-3);
    (with.gyros[0].chi2, with.gyros[0].dof) = (25.0, 100);
    assert_eq!(with.all_notes(), [CampaignNote::ErrorsOverstated { gyros: vec![(Slot::G1, 2.0)] }]);
    with.gyros[0].chi2 = 100.0;
    // Repeats that scatter three times as much as what is stated are an honest guess gone wrong, no other unit.
    with.gyros[0].noise.pure_error = PureError { chi2: 9.0 * 40.0, dof: 40 };
    assert_eq!(with.all_notes(), []);
    with.gyros[0].noise.pure_error = PureError { chi2: 1e6 * 40.0, dof: 40 };
    assert_eq!(with.all_notes(), [CampaignNote::ErrorsUnderstated { gyros, times: 1e3 }]);
    with.gyros[0].noise.pure_error = PureError::default();
    with.repeats.clear();
    assert_eq!(with.all_notes(), [CampaignNote::NoRepeats]);

    // Without any, nothing is overstated; and what chance may show does not grow.
    let mut without = fitted(None, true);
    without.gyros[0].p_value = None;
    (without.gyros[0].chi2, without.gyros[0].dof) = (25.0, 100);
    (without.growth, without.growth_chance) = (3.0, 0.01);
    assert_eq!(without.all_notes(), [CampaignNote::NoStandardErrors]);
    without.growth_chance = 0.009;
    assert_eq!(without.all_notes(), [CampaignNote::NoStandardErrors, CampaignNote::NoiseGrows { times: 2.0 }]);
}

#[test]
fn the_gauge_is_imposed_where_the_force_is_constant_to_two_per_cent() {
    // |a|^2 is 1 +- d in turn: its standard deviation over its mean is d.
    let design = |d: f64, terms: Terms| {
        let rows: Vec<Row> = (0..24)
            .map(|k| {
                let size = f64::sqrt(if k < 12 { 1.0 + d } else { 1.0 - d });
                (FACES[k % 6].map(|a| size * a), [0.0; 3], 0.0, None)
            })
            .collect();
        design::Design::new(&campaign(&rows, None).dwells, terms)
    };
    let both = Terms::of(&[Term::Bias, Term::GSquared]);
    let gauged = design(0.019, both);
    // D0 gains |a|^2 = 1 and each P loses 1: a unit vector of length 2.
    for (found, by_hand) in gauged.gauge.as_ref().expect("constant").iter().zip([0.5, -0.5, -0.5, -0.5]) {
        assert_close(*found, by_hand);
    }
    assert_eq!(gauged.reduced.ncols(), 3);
    let free = design(0.021, both);
    assert!(free.gauge.is_none() && free.reduced.ncols() == 4);
    assert!(design(0.0, Terms::of(&[Term::GSquared])).gauge.is_none(), "one of both has no partner");
    assert!(design(0.0, Terms::of(&[Term::Bias])).gauge.is_none());
    let units = [Term::Bias, Term::GLinear, Term::GSquared, Term::Scale].map(design::unit);
    assert_eq!(units, ["pulse/s", "pulse/(s*g0)", "pulse/(s*g0^2)", "pulse/arcsec"]);
}

#[test]
fn the_scatter_of_stated_errors_is_that_of_the_still_dwells() {
    // Still: sem of exp(-0.2 .. 0.2); turning: a hundred times as much, which says nothing of how well a sem is known.
    let mut rows: Vec<Row> = (0..5).map(|k| (FACES[k], [0.0; 3], 0.0, Some((0.1 * (k as f64 - 2.0)).exp()))).collect();
    rows.extend((0..5).map(|k| (FACES[5], [0.0, 0.0, 100.0 * (k + 1) as f64], 0.0, Some(100.0))));
    let scatter = sem_scatter(&campaign(&rows, None).dwells, 0);
    assert_close(scatter, 0.025f64.sqrt());
}

#[test]
fn a_scale_that_is_held_is_told_where_its_direction_shows_and_nobody_states_it() {
    let evaluated = |sem: f64, known_e, fixture| {
        let rows: Vec<Row> = (0..24)
            .map(|k| {
                // The vertical part of the Earth's rate along the face, the horizontal one along the next axis.
                let mut rate = FACES[k % 6].map(|up| 8.5 * up);
                rate[(k % 6 / 2 + 1) % 3] = 12.0;
                (FACES[k % 6], rate, 2.0 * rate[0] + 3.0 * FACES[k % 6][0] + 1e-4 * (k / 6) as f64, Some(sem))
            })
            .collect();
        let mut campaign = campaign(&rows, known_e);
        campaign.station_uncertainty.fixture = fixture;
        match outcome::evaluate(&campaign, &Plausibility::ever()) {
            Ok(outcome::Outcome::Imu { calibration, .. }) => (calibration, campaign.geometry),
            other => panic!("{other:?}"),
        }
    };
    let told = |sem: f64, known_e, fixture| {
        let (calibration, _) = evaluated(sem, known_e, fixture);
        calibration.all_notes().iter().find_map(|note| match note {
            CampaignNote::HeldScale { moves, arcsec, .. } => Some((*moves, *arcsec)),
            _ => None,
        })
    };
    let held = Some([2.0, 0.0, 0.0]);
    let (moves, arcsec) = told(1e-3, held, None).unwrap();
    assert!(moves > 3e-4, "{moves}");
    // What the station's own share is where it states as much.
    let (stated, geometry) = evaluated(1e-3, held, Some((arcsec / 3600.0).to_radians()));
    let budgets = stated.gyros[0].budgets(&geometry, false).unwrap();
    let of_fixture = |k: usize| budgets[k].of_station[StationPart::Fixture as usize].unwrap();
    assert_close(moves, of_fixture(0).max(of_fixture(1)));
    assert_eq!(told(1e-3, held, Some(1e-4)), None, "the station states it");
    assert_eq!(told(1.0, held, None), None, "the noise hides it");
}

#[test]
fn a_force_that_is_not_quite_the_sites_gravity_is_told_where_it_shows() {
    let told = |sem: f64, gravity_g0: f64, round: f64| {
        let rows: Vec<Row> = (0..24)
            .map(|k| {
                let mut rate = FACES[k % 6].map(|up| 8.5 * up);
                rate[(k % 6 / 2 + 1) % 3] = 12.0;
                let force = FACES[k % 6].map(|up| (0.999_100_7 * up / round).round() * round);
                (force, rate, 2.0 * rate[0] + 40.0 * FACES[k % 6][1] + sem * [1.0, -1.0][k / 6 % 2], Some(sem))
            })
            .collect();
        let mut campaign = campaign(&rows, Some([2.0, 0.0, 0.0]));
        campaign.site = Some(Site { latitude: 0.6, gravity_g0, magnetic_field_nav: None });
        let Ok(outcome::Outcome::Imu { calibration, .. }) = outcome::evaluate(&campaign, &Plausibility::ever()) else {
            return None;
        };
        calibration.notes.iter().find_map(|note| match note {
            CampaignNote::GravityOff { share, moves, .. } => Some((*share, *moves)),
            _ => None,
        })
    };
    // 5e-5 of 20 deg/(h g0).
    let (share, moves) = told(1e-3, 0.99905, 1e-9).expect("it shows");
    assert!((share - 5.07e-5).abs() < 1e-6 && (moves - 1e-3).abs() < 2e-5, "{share} {moves}");
    assert_eq!(told(1e-3, 0.9991, 1e-9), None);
    assert_eq!(told(1.0, 0.99905, 1e-9), None, "the noise hides it");
    assert_eq!(told(1e-3, 0.99905, 1e-3), None, "rounding explains it, and is told");
    assert!(told(5e-3, 0.99905, 1e-4).is_some(), "rounding explains it, and the noise of a dwell hides that");
    assert_eq!(told(1e-3, 0.999, 1e-9), None, "of the site's gravity");
}

/// Outputs of two positions exchanged, which have no repeat: repeats agree, and the model does not fit at all.
#[test]
fn what_a_model_leaves_out_is_in_the_sd_once() {
    let text = std::fs::read("tests/data/practice/campaign-00.json").expect("it is kept");
    let plain: Campaign = crate::wire::document::parse(&text).expect("it is whole");
    let limits = Plausibility::default();
    let repeated: Vec<usize> = crate::core::campaign::repeats::repeats(&plain.dwells).concat();
    let up = |axis: usize| {
        let is_free = |k: &usize| !repeated.contains(k) && plain.dwells[*k].phase == Phase::Static;
        (0..plain.dwells.len()).filter(is_free).find(|k| plain.dwells[*k].specific_force_g0[axis] > 0.9)
    };
    let (a, b) = (up(0).expect("there is one"), up(1).expect("there is one"));
    let mut exchanged = plain.clone();
    exchanged.dwells[a].output_pulse_s.clone_from(&plain.dwells[b].output_pulse_s);
    exchanged.dwells[b].output_pulse_s.clone_from(&plain.dwells[a].output_pulse_s);
    let [right, wrong] = [&plain, &exchanged].map(|campaign| calibrate(campaign, Terms::MODEL_6));
    let all = |calibration: &Calibration| calibration.separate(&plain.geometry, &limits);
    for (j, (right, off)) in all(&right).into_iter().zip(all(&wrong)).enumerate() {
        let (right, off) = (right.expect("it is clean").rigid, off.expect("|E| is known well").rigid);
        let [sd, ..] = off.sd().expect("its noise is known");
        let budget = wrong.gyros[j].budgets(&plain.geometry, false).expect("the same")[0];
        assert!((sd / budget.combined - 1.0).abs() < 1e-9, "{budget:?}");
        let error = (off.d_i - right.d_i).abs();
        assert!(error < 4.0 * sd && sd < 5.0, "off by {error}, {budget:?}");
        // The Birge ratio on the noise of repeats: a root of chi-square over its degrees of freedom.
        let white = calibrate_in_white_noise(&exchanged, Terms::MODEL_6).gyros[j]
            .budgets(&plain.geometry, false)
            .expect("the same")[0];
        assert!(budget.discrepancy.expect("repeats test it") < 1.001 * white.discrepancy.expect("the same"));
    }
}
