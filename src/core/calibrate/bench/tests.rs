//! Outputs made from eq. (5) by hand: y = K I.w + K (D_F + D_I a_I + D_S a_S + D_II a_I^2 + D_SS a_S^2 + D_O a_O).

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Rotation3;

use super::*;
use crate::core::calibrate::outcome::{Outcome, evaluate};
use crate::core::campaign::made_for_tests::{self, name};
use crate::core::campaign::{CampaignGyro, Dwell, Site, StationPart, StationUncertainty};
use crate::core::frames::Rotation;
use crate::core::model::Terms;
use crate::core::mounting::Slot;
use crate::core::record::Plausibility;

/// D_F, D_I, D_S, D_II, D_SS, D_O.
type Drift = [f64; 6];
const DRIFT: Drift = [0.4, 2.5, -3.5, 0.06, -0.02, 0.03];
const NAMES: [&str; 6] = ["D_F", "D_I", "D_S", "D_II", "D_SS", "D_O"];
const EARTH: f64 = 15.041_067;

/// A position: direction of the specific force and of the Earth's rate on the gyro's axes I, S, O.
type Position = ([f64; 3], [f64; 3]);

fn output(k: f64, d: &Drift, (a, w): &Position) -> f64 {
    k * (w[0] + d[0] + d[1] * a[0] + d[2] * a[1] + d[3] * a[0] * a[0] + d[4] * a[1] * a[1] + d[5] * a[2])
}

/// The orthogonal geometry's G1: I along x, S along y, O along z of the fixture.
fn bench(
    test: TestKind,
    positions: &[Position],
    outputs: &[f64],
    sem: Option<f64>,
    known_e: Option<[f64; 3]>,
) -> Campaign {
    let dwell = |(k, ((a, w), y)): (usize, (&Position, &f64))| Dwell {
        output_sem_pulse_s: sem.map(|sem| vec![sem]),
        ..made_for_tests::dwell(k, Vector3::from(*a), Vector3::from(*w), vec![*y])
    };
    let gyro = CampaignGyro { slot: Slot::G1, serial: name("A"), known_e: known_e.map(Vector3::from) };
    let dwells = positions.iter().zip(outputs).enumerate().map(dwell).collect();
    Campaign { test, ..made_for_tests::campaign(vec![gyro], dwells) }
}

/// A tumble about the output axis: a_I^2 + a_S^2 = 1 everywhere; the Earth's rate turns with it at another phase.
fn tumble() -> Vec<Position> {
    (0..24)
        .map(|k| {
            let turn = std::f64::consts::TAU * f64::from(k) / 24.0;
            let (s, c) = turn.sin_cos();
            let (ws, wc) = (turn + 0.9).sin_cos();
            ([c, s, 0.0], [EARTH * 0.8 * wc, EARTH * 0.8 * ws, EARTH * 0.6])
        })
        .collect()
}

/// Positions all over the sphere, force and rate apart.
fn all_over() -> Vec<Position> {
    (0..40)
        .map(|k| {
            let (height, turn) = (-0.95 + 1.9 * f64::from(k) / 39.0, 2.4 * f64::from(k));
            let flat = (1.0 - height * height).sqrt();
            let a = [flat * turn.cos(), height, flat * turn.sin()];
            let (along, up) = (1.7 * f64::from(k) + 0.3, 0.9 * (1.1 * f64::from(k)).sin());
            let level = (1.0 - up * up).sqrt();
            (a, [EARTH * level * along.cos(), EARTH * level * along.sin(), EARTH * up])
        })
        .collect()
}

fn fitted(campaign: &Campaign) -> BenchCalibration {
    calibrate_bench(campaign).unwrap_or_else(|why| panic!("{why}"))
}

fn outputs(k: f64, drift: &Drift, positions: &[Position]) -> Vec<f64> {
    positions.iter().map(|position| output(k, drift, position)).collect()
}

#[test]
fn a_stated_scale_that_the_earths_rate_contradicts_is_refused() {
    let asked = |positions: &[Position], sign: f64, e: f64| {
        let outputs: Vec<f64> = outputs(1.47, &DRIFT, positions).iter().map(|y| sign * y).collect();
        calibrate_bench(&bench(TestKind::TorqueFeedback, positions, &outputs, Some(1e-3), Some([e, 0.0, 0.0])))
    };
    assert!(asked(&all_over(), 1.0, 1.47).is_ok());
    for (sign, e, expected) in [(-1.0, 1.47, -1.0), (1.0, 1.0, 1.47)] {
        match asked(&all_over(), sign, e) {
            Err(NotFitted::NotAsStated { found }) => assert!((found - expected).abs() < 1e-6, "{found}"),
            other => panic!("{other:?}"),
        }
    }
    assert!(asked(&tumble(), -1.0, 1.47).is_ok(), "in a tumble the Earth's rate tells nothing of E");
}

#[test]
fn a_tumble_about_the_input_axis_does_not_determine_what_lies_along_it() {
    let about_input = |off: f64| -> Vec<Position> {
        let tumble = tumble().into_iter().enumerate();
        let turned = tumble.map(|(k, ([c, s, _], w))| ([off * (0.7 * k as f64).sin(), c, s], w));
        turned.collect()
    };
    // Off the fixture by 1 and 17 minutes of arc, by 3 degrees.
    for (off, is_told) in [(3e-4, false), (5e-3, false), (5e-2, true)] {
        let positions = about_input(off);
        let outputs = outputs(1.47, &DRIFT, &positions);
        let campaign = bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), Some([1.47, 0.0, 0.0]));
        match calibrate_bench(&campaign) {
            Err(NotFitted::Undetermined(of)) => assert!(!is_told && of == ["D_I"], "{off}: {of:?}"),
            Ok(found) => assert!(is_told && (found.coefficient("D_I").unwrap().value - DRIFT[1]).abs() < 1e-6),
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn a_torque_feedback_test_gives_back_scale_and_coefficients() {
    let positions = all_over();
    let campaign = bench(TestKind::TorqueFeedback, &positions, &outputs(1.47, &DRIFT, &positions), Some(1e-3), None);
    let found = fitted(&campaign);
    assert_eq!(
        (found.method, found.scale_source, found.gauge),
        (BenchMethod::TorqueFeedback, ScaleSource::Fitted, None)
    );
    assert!((found.e - Vector3::new(1.47, 0.0, 0.0)).norm() < 1e-9, "{}", found.e);
    for (name, value) in NAMES.into_iter().zip(DRIFT) {
        let coefficient = found.coefficient(name).unwrap_or_else(|| panic!("{name}"));
        assert!((coefficient.value - value).abs() < 1e-8, "{name}: {}", coefficient.value);
        let unit = match name {
            "D_F" => "deg/h",
            "D_II" | "D_SS" => "deg/(h*g0^2)",
            _ => "deg/(h*g0)",
        };
        assert_eq!(coefficient.unit, unit);
    }
    assert_eq!((found.rank, found.dof), (9, 40 - 9));
    assert!(found.residuals.amax() < 1e-9 && (found.leverage.sum() - 9.0).abs() < 1e-9);
    let mean = positions.iter().map(|(a, _)| a[0] * a[0] + a[1] * a[1]).sum::<f64>() / 40.0;
    let null: Vec<(&str, f64)> = found.null_direction().collect();
    let length = (mean * mean + 2.0).sqrt();
    for ((name, part), (expected, of)) in null.into_iter().zip([("D_F", mean), ("D_II", -1.0), ("D_SS", -1.0)]) {
        assert!(name == expected && (part - of / length).abs() < 1e-9, "{name}: {part}");
    }
    let result = found.result(&campaign);
    assert!((result.d_i - DRIFT[1]).abs() < 1e-8 && (result.d_s - DRIFT[2]).abs() < 1e-8);
    assert_eq!((result.method, result.d_i_sd), (BenchMethod::TorqueFeedback, found.coefficient("D_I").unwrap().sd));
}

#[test]
fn the_axes_follow_the_input_axis_that_the_earths_rate_shows() {
    // The gyro sits 10 arcmin off about the fixture's z: I and S turn together, and outputs are made on the turned
    // axes.
    let turn = (10.0_f64 / 60.0).to_radians();
    let (s, c) = turn.sin_cos();
    let positions = all_over();
    let on_gyro = |v: &[f64; 3]| [c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2]];
    let turned: Vec<Position> = positions.iter().map(|(a, w)| (on_gyro(a), on_gyro(w))).collect();
    let found = fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs(2.0, &DRIFT, &turned), Some(1e-3), None));
    assert!((found.e - Vector3::new(2.0 * c, 2.0 * s, 0.0)).norm() < 1e-6, "{}", found.e);
    assert!((found.axes.row(1) - Vector3::new(-s, c, 0.0).transpose()).norm() < 1e-6, "{}", found.axes);
    for (name, value) in NAMES.into_iter().zip(DRIFT) {
        let of = found.coefficient(name).unwrap().value;
        assert!((of - value).abs() < 1e-5, "{name}: {of}");
    }
}

#[test]
fn a_tumble_about_the_output_axis_is_one_rank_short_and_says_its_gauge() {
    let positions = tumble();
    let drift = [0.4, 2.5, -3.5, 0.04, -0.04, 0.0];
    let outputs = outputs(1.47, &drift, &positions);
    let campaign = bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), Some([1.47, 0.0, 0.0]));
    let found = fitted(&campaign);
    assert_eq!((found.gauge, found.scale_source), (Some(GAUGE), ScaleSource::Held));
    for (name, value) in NAMES.into_iter().zip(drift).take(5) {
        let of = found.coefficient(name).unwrap_or_else(|| panic!("{name}")).value;
        assert!((of - value).abs() < 1e-9, "{name}: {of}");
    }
    assert!(found.coefficient("D_O").is_none(), "nothing shows it");
    // Four columns of unit harmonics over 24 positions with sd s: var = s^2/24 for D_F, 2 s^2/24 for the harmonics,
    // over K.
    for (name, share) in [("D_F", 1.0), ("D_I", 2.0), ("D_S", 2.0), ("D_II", 2.0), ("D_SS", 2.0)] {
        let sd = found.coefficient(name).unwrap().sd.unwrap();
        assert!((sd / (1e-3 / 1.47 * (share / 24.0_f64).sqrt()) - 1.0).abs() < 1e-9, "{name}: {sd}");
    }
    let null: Vec<f64> = found.null_direction().map(|(_, part)| part).collect();
    assert!((null[0] - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12 && (null[1] + 1.0 / 3.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_fitted_scale_takes_part_in_the_standard_deviations() {
    // By brute force: the coefficient's change with every output, squared and added up.
    let positions = all_over();
    let of = |outputs: &[f64]| fitted(&bench(TestKind::TorqueFeedback, &positions, outputs, Some(2e-4), None));
    // With a large D_O and D_S, what the turn of the axes brings in is not small.
    let turned = DRIFT.map(|d| 40.0 * d.abs());
    for (drift, name) in [DRIFT, turned].iter().flat_map(|d| ["D_F", "D_I", "D_S", "D_O"].map(|name| (d, name))) {
        let exact = outputs(1.47, drift, &positions);
        let found = of(&exact);
        let variance: f64 = (0..positions.len())
            .map(|k| {
                let moved = |step: f64| {
                    let mut outputs = exact.clone();
                    outputs[k] += step;
                    of(&outputs).coefficient(name).unwrap().value
                };
                let by_output = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                (by_output * 2e-4).powi(2)
            })
            .sum();
        let stated = found.coefficient(name).unwrap().sd.unwrap();
        assert!((stated / variance.sqrt() - 1.0).abs() < 1e-3, "{name}: {stated} {}", variance.sqrt());
    }
}

#[test]
fn a_servo_test_answers_in_table_rate_with_either_sign() {
    let positions = all_over();
    let found = |k: f64| {
        let outputs = outputs(k, &DRIFT, &positions);
        calibrate_bench(&bench(TestKind::TurntableServo, &positions, &outputs, Some(1e-3), None))
    };
    for k in [1.0, -1.0] {
        let found = found(k).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!((found.scale_source, found.method), (ScaleSource::Held, BenchMethod::TurntableServo));
        assert_eq!(found.e, Vector3::new(k, 0.0, 0.0));
        for (name, value) in NAMES.into_iter().zip(DRIFT) {
            let of = found.coefficient(name).unwrap().value;
            assert!((of - value).abs() < 1e-8, "{k} {name}: {of}");
        }
    }
    let Err(NotFitted::NotATableRate { found }) = found(1.3) else { panic!("1.3 is no table rate") };
    assert!((found - 1.3).abs() < 1e-6);
}

#[test]
fn what_the_positions_do_not_show_is_said() {
    let still: Vec<Position> = vec![([1.0, 0.0, 0.0], [EARTH, 0.0, 0.0]); 12];
    let one_direction = outputs(1.0, &DRIFT, &still);
    let error = |test, positions: &[Position], outputs: &[f64], known_e| {
        calibrate_bench(&bench(test, positions, outputs, Some(1e-3), known_e)).expect_err("it cannot be fitted")
    };
    let why = error(TestKind::TorqueFeedback, &still, &one_direction, Some([1.0, 0.0, 0.0]));
    assert_eq!(why, NotFitted::Undetermined(vec!["D_F", "D_I", "D_S"]));
    assert_eq!(error(TestKind::TorqueFeedback, &still, &one_direction, None), NotFitted::NoScale);
    assert_eq!(error(TestKind::Imu, &still, &one_direction, None), NotFitted::NotABench);
    // A scale that is lost in the noise divides nothing.
    let positions = all_over();
    let nothing: Vec<f64> = (0..positions.len()).map(|k| 1e-3 * ((k * 37 % 11) as f64 - 5.0)).collect();
    let lost = calibrate_bench(&bench(TestKind::TorqueFeedback, &positions, &nothing, Some(3e-3), None));
    assert_eq!(lost.expect_err("no scale"), NotFitted::NoScale);
    // One next to nothing divides outputs next to nothing, but not what is stated of them.
    let little = outputs(1e-158, &DRIFT, &positions);
    let why = error(TestKind::TorqueFeedback, &positions, &little, Some([1e-158, 0.0, 0.0]));
    assert_eq!(why, NotFitted::NoScale);
}

/// The same positions under rates along the input axis alone.
fn along_input() -> Vec<Position> {
    all_over().into_iter().map(|(a, w)| (a, [w[0], 0.0, 0.0])).collect()
}

/// Standard deviation of E along the input axis for outputs of standard deviation one, from the full matrices.
#[expect(clippy::disallowed_methods, reason = "the other route, by the textbook: the normal equations")]
fn sd_of_scale(positions: &[Position]) -> f64 {
    let row = |(a, w): &Position| [w[0], 1.0, a[0], a[1], a[0] * a[0], a[1] * a[1], a[2]];
    let design = DMatrix::from_row_iterator(positions.len(), 7, positions.iter().flat_map(row));
    (design.transpose() * design).try_inverse().expect("it is determined")[(0, 0)].sqrt()
}

#[test]
fn a_torquer_wired_the_other_way_round_and_rates_along_the_input_axis_alone_change_no_coefficient() {
    for (positions, rank) in [(all_over(), 9), (along_input(), 7)] {
        for k in [1.47, -1.47] {
            let outputs = outputs(k, &DRIFT, &positions);
            let found = fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), None));
            assert_eq!((found.scale_source, found.rank), (ScaleSource::Fitted, rank));
            assert!((found.e - Vector3::new(k, 0.0, 0.0)).norm() < 1e-9, "{}", found.e);
            for (name, value) in NAMES.into_iter().zip(DRIFT) {
                let of = found.coefficient(name).unwrap().value;
                assert!((of - value).abs() < 1e-8, "{k} {name}: {of}");
            }
        }
    }
}

#[test]
fn a_fitted_scale_must_be_ten_of_its_standard_deviations() {
    let positions = along_input();
    let found = |ratio: f64, k: f64| {
        let sem = Some(k.abs() / (ratio * sd_of_scale(&positions)));
        calibrate_bench(&bench(TestKind::TorqueFeedback, &positions, &outputs(k, &DRIFT, &positions), sem, None))
    };
    for k in [1.47, -1.47] {
        assert_eq!(found(9.9, k), Err(NotFitted::NoScale));
        assert!(found(10.1, k).is_ok());
    }
}

#[test]
fn a_servo_tests_scale_passes_for_one_within_its_noise_or_two_per_cent() {
    let positions = along_input();
    let found = |k: f64, sd: f64| {
        let sem = Some(sd / sd_of_scale(&positions));
        calibrate_bench(&bench(TestKind::TurntableServo, &positions, &outputs(k, &DRIFT, &positions), sem, None))
            .map(|found| found.e.x)
    };
    for k in [1.1, 0.9, -1.1, -0.9] {
        assert_eq!(found(k, 0.0202), Ok(k.signum()), "five of its deviations are more than a tenth");
        assert!(matches!(found(k, 0.0198), Err(NotFitted::NotATableRate { found }) if (found - k).abs() < 1e-9));
    }
    for k in [1.019, 0.981, -1.019] {
        assert_eq!(found(k, 1e-6), Ok(k.signum()));
    }
    assert!(found(1.021, 1e-6).is_err() && found(0.979, 1e-6).is_err());
    // The sign must be seen, beyond five of its deviations, or stated: the other one negates all coefficients.
    assert_eq!([found(-0.5, 0.2), found(-1.1, 0.23), found(1.1, 0.23)], [const { Err(NotFitted::NoServoSign) }; 3]);
    assert_eq!([found(-1.1, 0.21), found(1.1, 0.21)], [Ok(-1.0), Ok(1.0)]);
    let still: Vec<Position> = all_over().into_iter().map(|(a, _)| (a, [9.0, 0.0, 0.0])).collect();
    let tested = |k: f64, known_e| {
        calibrate_bench(&bench(TestKind::TurntableServo, &still, &outputs(k, &DRIFT, &still), Some(1e-3), known_e))
    };
    assert_eq!(tested(1.0, None), Err(NotFitted::NoServoSign));
    for k in [1.0, -1.0] {
        let found = tested(k, Some([k, 0.0, 0.0])).expect("it is stated");
        assert!((found.coefficient("D_I").unwrap().value - DRIFT[1]).abs() < 1e-9);
    }
}

#[test]
fn a_product_that_hides_in_a_coefficient_is_said_with_what_it_does() {
    // A tumble with the output axis at 30 degrees: a_O = 1/2 throughout, so that D_IO a_I a_O is D_I of half of it.
    let (across, along) = (0.75_f64.sqrt(), 0.5);
    let positions: Vec<Position> = (0..12)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::FRAC_PI_6;
            let a = [across * angle.cos(), across * angle.sin(), along];
            (a, [EARTH * a[0], EARTH * a[1], EARTH * a[2]])
        })
        .collect();
    let outputs = outputs(1.5, &DRIFT, &positions);
    let found = fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), Some([1.5, 0.0, 0.0])));
    let moved: Vec<(&str, &str)> = found.aliases.iter().map(|alias| (alias.product, alias.coefficient)).collect();
    assert_eq!(moved, [("D_IO", "D_I"), ("D_OS", "D_S")]);
    assert!(found.aliases.iter().all(|alias| (alias.moves - 0.5).abs() < 1e-9), "{:?}", found.aliases);
}

#[test]
fn terms_of_the_third_degree_are_said_with_what_they_do_to_d_i_and_d_s() {
    let of = |cubic: f64, sd: f64| {
        let outputs: Vec<f64> =
            tumble().iter().map(|place| output(1.4, &DRIFT, place) + 1.4 * cubic * place.0[0].powi(3)).collect();
        fitted(&bench(TestKind::TorqueFeedback, &tumble(), &outputs, Some(sd), Some([1.4, 0.0, 0.0])))
    };
    let note = |found: &BenchCalibration| found.all_notes().into_iter().find(|note| note.code() == "cubic_aliased");
    let plain = of(0.0, 1e-3);
    let Some(CampaignNote::CubicAliased { size, aliases }) = note(&plain) else { panic!("{:?}", plain.all_notes()) };
    let moved = aliases.iter().find(|alias| (alias.product, alias.coefficient) == ("D_III", "D_I")).expect("a_I^3");
    let bent = of(size, 1e-3);
    let by = ["D_I", "D_S"].map(|name| bent.coefficient(name).unwrap().value - plain.coefficient(name).unwrap().value);
    assert!((by[0] - size * moved.moves).abs() < 1e-9 && by[1].abs() < 1e-9, "{by:?} {moved:?}");
    // cos^3 x is 3/4 cos x + 1/4 cos 3x.
    assert!((moved.moves - 0.75).abs() < 1e-9 && size == 0.01, "{moved:?}");
    assert_eq!(note(&of(0.0, 0.5)), None, "it hardly moves them beside the noise");
}

#[test]
fn what_eq_5_does_not_fit_shows_in_its_p_value() {
    let positions = all_over();
    let p_value = |curve: f64| {
        let outputs: Vec<f64> = outputs(1.5, &DRIFT, &positions)
            .iter()
            .zip(&positions)
            .enumerate()
            .map(|(k, (y, (a, _)))| y + 1e-3 * ((k * 37 % 11) as f64 / 5.0 - 1.0) + curve * a[0].powi(3))
            .collect();
        fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), None))
            .p_value
            .expect("errors are stated")
    };
    assert!(p_value(0.0) > 0.05 && p_value(0.1) < 1e-6, "{} {}", p_value(0.0), p_value(0.1));
}

#[test]
fn repeats_say_how_far_a_bench_tests_errors_can_be_trusted() {
    // Each of the tumble's positions twice, 0.3 apart where 0.1 is stated: chi2 24 (0.3/0.1)^2/2 = 108 on 24, f^2 =
    // 112/28 or better.
    let mut positions = tumble();
    positions.extend(tumble());
    let drift = [0.4, 2.5, -3.5, 0.04, -0.04, 0.0];
    let made: Vec<f64> = outputs(2.0, &drift, &positions)
        .iter()
        .enumerate()
        .map(|(k, y)| y + if k < 24 { 0.15 } else { -0.15 })
        .collect();
    let fitted_with = |sem| fitted(&bench(TestKind::TorqueFeedback, &positions, &made, sem, Some([2.0, 0.0, 0.0])));
    let found = fitted_with(Some(0.1));
    assert_eq!(found.repeats.len(), 24);
    assert!((found.noise.pure_error.chi2 - 108.0).abs() < 1e-9 && found.noise.pure_error.dof == 24);
    // The residuals beyond the repeats are none, 0 on 20: together (108 + 4)/(24 + 4 + 20), over two less for the t.
    let f = (112.0_f64 / 48.0).sqrt();
    assert!((found.noise.factor.unwrap() / f - 1.0).abs() < 1e-9, "{:?}", found.noise);
    let sd = 0.1 / 2.0 * (112.0_f64 / 46.0 * 2.0 / 48.0).sqrt();
    assert!((found.coefficient("D_I").unwrap().sd.unwrap() / sd - 1.0).abs() < 1e-9);
    // Four columns of equal leverage each, 4/48; the tumble's own harmonics fit nothing of what repeats differ by.
    let own = 0.15 / (0.1 * f * (1.0 - found.leverage[0]).sqrt());
    assert!((found.leverage.sum() - 4.0).abs() < 1e-9);
    assert!((found.sigma.as_ref().unwrap()[0] / (0.1 * f) - 1.0).abs() < 1e-9);
    assert!((found.standardised.as_ref().unwrap()[0] / own - 1.0).abs() < 1e-9);
    // Without stated errors the scatter itself: 48 of 0.15^2 on 44.
    let bare = fitted_with(None);
    assert!((bare.noise.factor.unwrap() / (0.15 * (48.0_f64 / 44.0).sqrt()) - 1.0).abs() < 1e-9);
}

/// Errors of half and of twice the noise by turns, and noise that is as large in all, goes with them or against them.
#[test]
fn errors_that_scatter_are_shrunk_to_their_law_unless_residuals_follow_them() {
    let positions = [tumble(), tumble()].concat();
    let of = |size: &dyn Fn(usize) -> f64, sem: &dyn Fn(usize) -> f64| {
        let noise = |k: usize| 1e-3 * size(k) * if (k * k % 7).is_multiple_of(2) { 1.0 } else { -1.0 };
        let outputs = positions.iter().enumerate().map(|(k, place)| output(1.4, &DRIFT, place) + noise(k));
        let outputs: Vec<f64> = outputs.collect();
        let mut campaign = bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1.0), Some([1.4, 0.0, 0.0]));
        for (k, dwell) in campaign.dwells.iter_mut().enumerate() {
            dwell.output_sem_pulse_s = Some(vec![1e-3 * sem(k)]);
        }
        calibrate_bench(&campaign).unwrap()
    };
    let by_turns = |k: usize| -> f64 { if k * k % 5 == 1 { 2.0 } else { 0.5 } };
    for size in [&(|_| 1.0) as &dyn Fn(usize) -> f64, &|k| by_turns(k).recip()] {
        let (shrunk, even) = (of(size, &by_turns), of(size, &|_| 1.3));
        assert!(shrunk.errors_scatter.is_some_and(|scatter| (0.4..0.8).contains(&scatter)), "{shrunk:?}");
        for name in ["D_I", "D_S"] {
            let [own, even] = [&shrunk, &even].map(|fitted| fitted.coefficient(name).unwrap().value);
            assert!((own - even).abs() < 1e-4, "{name}: {own} {even}");
        }
    }
    assert_eq!(of(&by_turns, &by_turns).errors_scatter, None);
    assert_eq!(of(&|_| 1.0, &|_| 1.0).errors_scatter, None);
}

/// Products of forces across a skewed fixture are, over balanced faces, combinations of 1 and the squares.
#[test]
fn a_product_that_hides_in_the_squares_is_said_unless_residuals_show_it() {
    let (input, spin) =
        (Vector3::new(0.577350, -0.408248, FRAC_1_SQRT_2).normalize(), Vector3::new(0.0, 0.866025, 0.5));
    let spin = (spin - input * input.dot(&spin)).normalize();
    let skewed = Matrix3::from_rows(&[input.transpose(), spin.transpose(), input.cross(&spin).transpose()]);
    let faces = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let faces: Vec<Position> = (0..24)
        .map(|k| {
            let along = |v: Vector3<f64>| <[f64; 3]>::from(skewed * v);
            (along(faces[k % 6]), along(faces[(k + 2 + k / 6) % 6] * EARTH))
        })
        .collect();
    let aliases = |positions: &[Position]| {
        let outputs = outputs(1.5, &DRIFT, positions);
        fitted(&bench(TestKind::TorqueFeedback, positions, &outputs, Some(1e-3), Some([1.5, 0.0, 0.0]))).aliases
    };
    let found = aliases(&faces);
    assert!(found.iter().any(|alias| alias.coefficient == "D_II" && alias.moves.abs() > 0.5), "{found:?}");
    // What is said is what a product does.
    for (product, [a, b]) in [("D_SI", [1, 0]), ("D_IO", [0, 2]), ("D_OS", [2, 1])] {
        let with = |size: f64| {
            let add = |position: &Position| output(1.5, &DRIFT, position) + 1.5 * size * position.0[a] * position.0[b];
            let outputs: Vec<f64> = faces.iter().map(add).collect();
            fitted(&bench(TestKind::TorqueFeedback, &faces, &outputs, Some(1e-3), Some([1.5, 0.0, 0.0])))
        };
        let (without, with) = (with(0.0), with(0.01));
        for alias in found.iter().filter(|alias| alias.product == product) {
            let [before, after] = [&without, &with].map(|fit| fit.coefficient(alias.coefficient).unwrap().value);
            assert!((after - before - 0.01 * alias.moves).abs() < 1e-9, "{alias:?}");
        }
    }
    // All over the sphere residuals show any product.
    assert!(aliases(&all_over()).iter().all(|alias| ["D_I", "D_S"].contains(&alias.coefficient)));
}

/// Attitudes all over, and positions as a table shows them that is turned by `nav` (rad; east, north, up), the gyro by
/// `body` in its fixture.
fn turned(nav: Vector3<f64>, body: Vector3<f64>) -> Vec<(Rotation3<f64>, Position)> {
    let (force, earth) = (Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 12.4, 8.5));
    let of_dwell = |k: usize| {
        let k = k as f64;
        let attitude = Rotation3::from_euler_angles(1.3 * k, 0.4 * k * k, 2.1 * k + 0.5);
        let turned = Rotation3::new(body) * attitude * Rotation3::new(nav);
        (attitude, ((turned * force).into(), (turned * earth).into()))
    };
    (0..24).map(of_dwell).collect()
}

/// Fitted as if nothing were turned.
fn on_table(nav: Vector3<f64>, body: Vector3<f64>, known_e: Option<[f64; 3]>, stated: StationUncertainty) -> Campaign {
    let drift = [0.4, 2.5, -3.5, 0.0, 0.0, 0.8];
    let positions: Vec<Position> = turned(nav, body).into_iter().map(|(_, position)| position).collect();
    let outputs = outputs(1.4, &drift, &positions);
    let commanded = turned(Vector3::zeros(), Vector3::zeros());
    let positions: Vec<Position> = commanded.iter().map(|(_, position)| *position).collect();
    let mut campaign = bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-4), known_e);
    for (dwell, (attitude, _)) in campaign.dwells.iter_mut().zip(commanded) {
        dwell.attitude = Some(Rotation::stated_as(attitude));
    }
    Campaign { station_uncertainty: stated, ..campaign }
}

#[test]
fn what_is_stated_of_the_station_moves_coefficients_as_the_sd_says() {
    let stated = StationUncertainty { levelling: Some(1e-4), azimuth: Some(2e-4), fixture: Some(5e-5) };
    let none = Vector3::zeros();
    for known_e in [Some([1.4, 0.0, 0.0]), None] {
        let of = |nav, body, stated| fitted(&on_table(nav, body, known_e, stated));
        let (level, plain) = (of(none, none, stated), of(none, none, StationUncertainty::default()));
        for name in ["D_F", "D_I", "D_S", "D_O"] {
            let moved = |nav, body| {
                of(nav, body, stated).coefficient(name).unwrap().value - plain.coefficient(name).unwrap().value
            };
            let rss = |moved: &[f64]| moved.iter().map(|by| by * by).sum::<f64>().sqrt();
            let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
            let parts = [
                rss(&[x, y].map(|axis| moved(axis * 1e-4, none))),
                rss(&[moved(z * 2e-4, none)]),
                rss(&[x, y, z].map(|axis| moved(none, axis * 5e-5))),
            ];
            let coefficient = level.coefficient(name).unwrap();
            let budget = coefficient.uncertainty.unwrap();
            for (part, said) in parts.into_iter().zip(budget.of_station) {
                assert!((said.unwrap() - part).abs() < 1e-3 * part + 1e-7, "{name} {known_e:?}: {said:?} {part}");
            }
            let [sd, of_fit] = [coefficient, plain.coefficient(name).unwrap()].map(|c| c.sd.unwrap());
            assert!((sd / of_fit.hypot(rss(&parts)) - 1.0).abs() < 1e-3, "{name}: {sd}");
        }
    }
    // What it leaves in the residuals is no lack of fit, and what nothing tells is said.
    let tilted = on_table(Vector3::new(1e-4, 1e-4, 0.0), none, None, stated);
    assert!(fitted(&tilted).p_value.unwrap() > 0.05);
    let mut blind = tilted;
    blind.dwells.iter_mut().for_each(|dwell| dwell.attitude = None);
    let codes: Vec<&str> = fitted(&blind).all_notes().iter().map(CampaignNote::code).collect();
    assert!(codes.contains(&"station_left_out"), "{codes:?}");
}

#[test]
fn a_rotation_that_contradicts_what_is_stated_is_told_and_in_the_sd() {
    let stated = StationUncertainty { levelling: Some(1e-4), azimuth: None, fixture: None };
    let of = |tilt: f64| fitted(&on_table(Vector3::new(tilt, tilt, 0.0), Vector3::zeros(), None, stated));
    let (level, within, beyond) = (of(0.0), of(1e-4), of(1.2e-3));
    let told = |found: &BenchCalibration| found.notes.iter().any(|note| note.code() == "station_contradicted");
    assert_eq!([&level, &within, &beyond].map(told), [false, false, true]);
    let Some(CampaignNote::StationContradicted { part: StationPart::Levelling, times, arcsec }) = beyond.notes.first()
    else {
        panic!("{:?}", beyond.notes)
    };
    assert!((times / 12.0 - 1.0).abs() < 0.2 && (arcsec - 20.626_5).abs() < 1e-3, "{times} {arcsec}");
    assert!(beyond.p_value.unwrap() < 1e-3, "it is no longer taken out of the residuals");
    let [off, plain] = [&beyond, &level].map(|found| *found.coefficient("D_I").unwrap());
    let (error, sd, budget) = ((off.value - plain.value).abs(), off.sd.unwrap(), off.uncertainty.unwrap());
    assert!(error > 3.0 * plain.sd.unwrap() && error < 2.0 * sd, "{error} {sd}");
    assert!(budget.discrepancy.unwrap() > 5.0 * budget.station.unwrap(), "{budget:?}");
}

#[test]
fn a_direction_of_e_that_the_positions_do_not_show_is_told_as_held() {
    // The rate along S goes with a_S and that along O with D_F; that along I is told.
    let of_input = |(k, (a, _)): (usize, Position)| {
        let turn = std::f64::consts::TAU * k as f64 / 24.0;
        (a, [EARTH * 0.8 * (3.0 * turn).cos(), EARTH * 0.8 * turn.sin(), EARTH * 0.6])
    };
    let positions: Vec<Position> = tumble().into_iter().enumerate().map(of_input).collect();
    let outputs = outputs(1.4, &DRIFT, &positions);
    for known_e in [Some([1.4, 0.0, 0.0]), None] {
        let campaign = bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-4), known_e);
        let Ok(Outcome::Bench(found)) = evaluate(&campaign, &Plausibility::ever()) else { panic!("it can be fitted") };
        assert!(found.holds_direction, "{known_e:?}");
        assert!(found.notes.iter().any(|note| note.code() == "held_scale"), "{known_e:?}: {:?}", found.notes);
    }
}

#[test]
fn a_drift_between_dwells_is_found_and_widens_what_it_moves() {
    let positions = [tumble(), tumble()].concat();
    let of = |drift: f64, sem: Option<f64>| {
        let noise = |k: usize| 1e-3 * if (k * k % 7).is_multiple_of(2) { 1.0 } else { -1.0 } + drift * k as f64;
        let outputs = positions.iter().enumerate().map(|(k, place)| output(1.4, &DRIFT, place) + noise(k));
        fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs.collect::<Vec<_>>(), sem, Some([1.4, 0.0, 0.0])))
    };
    for sem in [None, Some(1e-3)] {
        let (still, drifts) = (of(0.0, sem), of(1e-3, sem));
        let remembers = |found: &BenchCalibration| found.all_notes().iter().any(|n| n.code() == "residuals_remember");
        assert_eq!([remembers(&still), remembers(&drifts)], [false, true], "{:?}", drifts.noise_found);
        let off = |name| {
            let found = drifts.coefficient(name).unwrap();
            (found.value - still.coefficient(name).unwrap().value).abs() / found.sd.unwrap()
        };
        assert!(["D_I", "D_S", "D_II"].iter().all(|name| off(name) < 3.0), "{:?}", drifts.coefficients);
    }
}

#[test]
fn errors_that_are_far_too_large_are_noted() {
    let positions = [tumble(), tumble()].concat();
    let noise = |k: usize| 1e-3 * if (k * k % 7).is_multiple_of(2) { 1.0 } else { -1.0 };
    let outputs = positions.iter().enumerate().map(|(k, place)| output(1.4, &DRIFT, place) + noise(k));
    let outputs: Vec<f64> = outputs.collect();
    for (sem, said) in [(Some(1e-3), false), (Some(5e-3), true), (None, false)] {
        let found = fitted(&bench(TestKind::TorqueFeedback, &positions, &outputs, sem, Some([1.4, 0.0, 0.0])));
        assert_eq!(found.all_notes().iter().any(|note| note.code() == "standard_errors_overstated"), said, "{sem:?}");
    }
}

#[test]
fn what_is_held_and_what_the_latitude_may_be_are_told_by_what_they_move() {
    let none = Vector3::zeros();
    let notes = |campaign: &Campaign| match evaluate(campaign, &Plausibility::ever()) {
        Ok(Outcome::Bench(bench)) => bench.notes,
        other => panic!("{other:?}"),
    };
    let held = on_table(none, none, Some([1.4, 0.0, 0.0]), StationUncertainty::default());
    let [CampaignNote::HeldScale { arcsec, moves: turned, .. }, CampaignNote::HeldSize { share, moves: sized, .. }] =
        notes(&held)[..]
    else {
        panic!("{:?}", notes(&held))
    };
    let of = |e: Vector3<f64>| {
        let found = fitted(&on_table(none, none, Some(e.into()), StationUncertainty::default()));
        ["D_I", "D_S"].map(|name| found.coefficient(name).unwrap().value)
    };
    let ([d_i, d_s], longer) = (of(Vector3::x() * 1.4), of(Vector3::x() * 1.4 * (1.0 + share)));
    let most = (longer[0] - d_i).abs().max((longer[1] - d_s).abs());
    assert!((most / sized - 1.0).abs() < 1e-9 && arcsec == 20.0 && turned > 1e-5, "{most} {sized} {turned}");
    let free = on_table(none, none, None, StationUncertainty::default());
    assert_eq!(notes(&free), []);
    // North taken for south: the vertical part of the Earth's rate has the other sign, and the site with it.
    let mut south = free;
    south.site = Some(Site { latitude: -34.4_f64.to_radians(), gravity_g0: 1.0, magnetic_field_nav: None });
    assert_eq!(notes(&south), [], "D_I is 2.5");
    let shift = 2.0 * 8.5;
    for dwell in &mut south.dwells {
        let up = dwell.specific_force_g0;
        dwell.output_pulse_s[0] += 1.4 * (shift - 2.0) * up.x;
    }
    assert_eq!(notes(&south).iter().map(CampaignNote::code).collect::<Vec<_>>(), ["latitude_sign"]);
}

#[test]
fn too_few_positions_for_scale_and_squares_are_refused_and_a_gauge_is_said() {
    let faces = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let positions: Vec<Position> = faces
        .into_iter()
        .enumerate()
        .map(|(k, up)| (up.into(), (up * 8.5 + faces[(k + 2) % 6] * 12.4).into()))
        .collect();
    let outputs = outputs(1.4, &DRIFT, &positions);
    let test = |known_e| bench(TestKind::TorqueFeedback, &positions, &outputs, Some(1e-3), known_e);
    assert_eq!(calibrate_bench(&test(None)), Err(NotFitted::ScaleOrSquares));
    let linear = Campaign { model: Some(Terms::of(&[Term::Bias, Term::GLinear, Term::Scale])), ..test(None) };
    assert!(calibrate_bench(&linear).is_ok(), "it asks for no squares");
    let held = fitted(&test(Some([1.4, 0.0, 0.0])));
    assert!(held.coefficient("D_SS").is_some() && held.gauge.is_none());
    let code = |found: &BenchCalibration| found.all_notes().iter().any(|note| note.code() == "d_f_in_gauge");
    let outputs = self::outputs(1.4, &DRIFT, &tumble());
    let tumbled = bench(TestKind::TorqueFeedback, &tumble(), &outputs, Some(1e-3), Some([1.4, 0.0, 0.0]));
    assert!(!code(&held) && code(&fitted(&tumbled)));
}

#[test]
fn a_drift_that_positions_follow_is_told_by_what_it_moves() {
    let faces = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let in_order: Vec<Position> = (0..24)
        .map(|k| (faces[k / 4].into(), (faces[k / 4] * 8.5 + faces[(k / 4 + 2 + k % 4) % 6] * 12.4).into()))
        .collect();
    let mixed: Vec<Position> = (0..24).map(|k| in_order[k * 5 % 24]).collect();
    let of = |positions: &[Position], drift: f64| {
        let drifts =
            |(k, place): (usize, &Position)| output(1.4, &DRIFT, place) + 1.4 * drift * k as f64 * 240.0 / 3600.0;
        let outputs: Vec<f64> = positions.iter().enumerate().map(drifts).collect();
        fitted(&bench(TestKind::TorqueFeedback, positions, &outputs, Some(1e-4), Some([1.4, 0.0, 0.0])))
    };
    let (still, drifts) = (of(&in_order, 0.0), of(&in_order, 1e-3));
    let told = |found: &BenchCalibration| found.all_notes().into_iter().find(|note| note.code() == "drift_aliased");
    let Some(CampaignNote::DriftAliased { drift, d_i, d_s, .. }) = told(&still) else {
        panic!("{:?}", still.all_notes())
    };
    assert_eq!(drift, 1e-3);
    for (name, said) in [("D_I", d_i), ("D_S", d_s)] {
        let moved = drifts.coefficient(name).unwrap().value - still.coefficient(name).unwrap().value;
        assert!((moved.abs() - said).abs() < 1e-9, "{name}: {moved} {said}");
    }
    assert_eq!(told(&of(&mixed, 0.0)), None);
}
