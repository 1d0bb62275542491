//! Simulated campaigns: the fit recovers what was put in, without bias, and its sigmas are right from both sides.

use gyrowatch::core::calibrate::bench::calibrate_bench;
use gyrowatch::core::calibrate::{Calibration, calibrate};
use gyrowatch::core::record::Plausibility;
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::programme::Positions;
use gyrowatch::simulate::scenario::{AxesChoice, GeometryChoice, GyroChoice, Scenario, StandardErrors, StatedE};
use gyrowatch::simulate::{Simulated, simulate};
use std::collections::BTreeMap;

/// Errors in units of their own sigma, by quantity.
#[derive(Default)]
struct Ratios(BTreeMap<String, Vec<f64>>);

impl Ratios {
    fn add(&mut self, name: &str, found: f64, truth: f64, sd: f64) {
        self.0.entry(name.to_owned()).or_default().push((found - truth) / sd);
    }

    fn add_campaign(&mut self, run: &Simulated, calibration: &Calibration) {
        let drifts = calibration.separate(&run.campaign.geometry, &Plausibility::default());
        for ((gyro, drift), truth) in calibration.gyros.iter().zip(drifts).zip(&run.world.gyros) {
            let drift = drift.expect("these designs determine everything");
            let sd = drift.rigid.sd().expect("a noise scale");
            self.add("D_I", drift.rigid.d_i, truth.drift.d_i, sd[0]);
            // S can be turned about I by the mounting, which E does not show: D_S and D_O together are known.
            let (true_s, true_o) = {
                let g = truth.input() * truth.drift.d_i + truth.spin() * truth.drift.d_s;
                (g.dot(&drift.rigid.spin_axis), g.dot(&drift.rigid.output_axis))
            };
            self.add("D_S", drift.rigid.d_s, true_s, sd[1]);
            self.add("D_O", drift.rigid.d_o, true_o, sd[2]);
            let k = truth.scale_factor;
            let g = (truth.input() * truth.drift.d_i + truth.spin() * truth.drift.d_s) * k;
            let e = truth.e();
            let expected = |name: &str| match name.split_at(1) {
                ("D", _) => k * truth.drift.d_f,
                ("G", axis) => g[axis_index(axis)],
                ("E", axis) => e[axis_index(axis)],
                _ => 0.0,
            };
            for p in &gyro.parameters {
                self.add(p.name, p.value, expected(p.name), p.sd.expect("determined"));
            }
        }
    }

    /// rms(error/sd) from 0.9 to 1.1, and a mean that chance explains. `--nocapture` shows the figures.
    fn assert_honest(&self, what: &str) {
        assert!(!self.0.is_empty());
        let mut extremes = (f64::MAX, f64::MIN, 0.0_f64);
        for (name, ratios) in &self.0 {
            eprintln!("{name} {:?}", (ratios.iter().map(|x| x * x).sum::<f64>() / ratios.len() as f64).sqrt());
            let n = ratios.len() as f64;
            let rms = (ratios.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
            let bias = ratios.iter().sum::<f64>() / n.sqrt();
            extremes = (extremes.0.min(rms), extremes.1.max(rms), extremes.2.max(bias.abs()));
            assert!((0.9..1.1).contains(&rms), "{what}: rms(error/sd) of {name} is {rms:.3}");
            assert!(bias.abs() < 4.0 * rms, "{what}: the mean error of {name} is {bias:.1} of its own sigma");
        }
        let (low, high, bias) = extremes;
        println!("| {what} | {} | {low:.2} to {high:.2} | {bias:.1} |", self.0.len());
    }
}

fn axis_index(suffix: &str) -> usize {
    ["_x", "_y", "_z"].iter().position(|s| *s == suffix).expect("an axis")
}

const SEEDS: u64 = 300;

/// Runs a preset with all seeds, `change` made to every scenario and `sem_factor` to all stated standard errors.
fn recover(name: &str, change: impl Fn(&mut Scenario), sem_factor: f64) -> Ratios {
    let mut scenario = preset(name).expect("a preset");
    change(&mut scenario);
    let mut ratios = Ratios::default();
    for seed in 0..SEEDS {
        let mut run = simulate(&Scenario { seed, ..scenario.clone() }).expect("a scenario that runs");
        for sem in run.campaign.dwells.iter_mut().flat_map(|d| d.output_sem_pulse_s.iter_mut().flatten()) {
            *sem *= sem_factor;
        }
        ratios.add_campaign(&run, &calibrate(&run.campaign, run.campaign.terms()));
    }
    ratios
}

fn standard_errors(which: StandardErrors) -> impl Fn(&mut Scenario) {
    move |scenario| scenario.columns.standard_errors = which
}

#[test]
fn every_design_is_recovered_with_honest_sigmas() {
    for design in ["24-position", "24-bare", "36-position", "60-position"] {
        for which in [StandardErrors::Exact, StandardErrors::Noisy, StandardErrors::Absent] {
            let what = format!("{design}, standard errors {}", which.name());
            recover(design, standard_errors(which), 1.0).assert_honest(&what);
        }
    }
}

#[test]
fn repeats_correct_standard_errors_that_are_wrong_by_half() {
    for factor in [0.67, 1.5] {
        recover("24-position", |_| (), factor).assert_honest(&format!("standard errors {factor} times the true ones"));
    }
}

#[test]
fn residuals_correct_standard_errors_that_are_too_small_where_nothing_repeats() {
    let without_repeats = |scenario: &mut Scenario| scenario.programme.repeats = 0;
    recover("24-position", without_repeats, 0.5).assert_honest("half the true standard errors, no repeats");
}

#[test]
fn one_gyro_alone_is_recovered_as_well() {
    let one = |scenario: &mut Scenario| scenario.gyros.truncate(1);
    recover("24-position", one, 1.0).assert_honest("one gyro");
}

#[test]
fn whatever_is_left_of_a_design_is_fitted_or_named_and_never_panics() {
    for keep in 1..40usize {
        let mut run = simulate(&preset("24-position").expect("a preset")).expect("it runs");
        run.campaign.dwells.truncate(keep);
        let calibration = calibrate(&run.campaign, run.campaign.terms());
        for (gyro, drift) in
            calibration.gyros.iter().zip(calibration.separate(&run.campaign.geometry, &Plausibility::default()))
        {
            assert!(gyro.rank <= keep.min(9) && gyro.rank + gyro.null_directions.len() == 10);
            match drift {
                Ok(drift) => assert!(drift.rigid.d_i.is_finite()),
                Err(why) => assert!(!why.to_string().is_empty()),
            }
        }
    }
}

/// One gyro on a fixture: input along the fixture's X, spin along Y, turned by what the mounting leaves.
fn on_a_bench(test: &str, positions: Positions, states_e: StatedE, change: impl Fn(&mut Scenario)) -> Ratios {
    let axes = AxesChoice { input: [1.0, 0.0, 0.0], spin: [0.0, 1.0, 0.0] };
    let mut scenario = Scenario {
        test: test.into(),
        geometry: GeometryChoice::Axes([("G1".to_owned(), axes)].into()),
        gyros: vec![GyroChoice { slot: "G1".into(), states_e, ..GyroChoice::default() }],
        ..Scenario::default()
    };
    scenario.programme.positions = positions;
    scenario.programme.rates_arcsec_s = Vec::new();
    change(&mut scenario);
    let mut ratios = Ratios::default();
    for seed in 0..4 * SEEDS {
        let run = simulate(&Scenario { seed, ..scenario.clone() }).expect("a scenario that runs");
        let bench = calibrate_bench(&run.campaign).unwrap_or_else(|why| panic!("{test}: {why}"));
        let truth = &run.world.gyros[0];
        let drift = truth.input() * truth.drift.d_i + truth.spin() * truth.drift.d_s;
        for (name, expected) in [
            ("D_F", truth.drift.d_f),
            ("D_I", drift.dot(&bench.axes.row(0).transpose())),
            ("D_S", drift.dot(&bench.axes.row(1).transpose())),
            ("D_O", drift.dot(&bench.axes.row(2).transpose())),
        ] {
            let found = bench.coefficient(name).expect("these positions show it");
            ratios.add(name, found.value, expected, found.sd.expect("a noise scale"));
        }
        for name in ["D_II", "D_SS"] {
            if let Some(found) = bench.coefficient(name) {
                ratios.add(name, found.value, 0.0, found.sd.expect("a noise scale"));
            }
        }
    }
    ratios
}

#[test]
fn raw_bench_tests_are_recovered_with_honest_sigmas() {
    let tumble = on_a_bench("torque_feedback", Positions::PolarTumble, StatedE::True, |_| ());
    assert!(tumble.0.contains_key("D_SS"), "a tumble shows D_II - D_SS");
    tumble.assert_honest("polar-axis tumble, E stated");
    let edges = on_a_bench("torque_feedback", Positions::WithEdges, StatedE::No, |_| ());
    edges.assert_honest("36 positions, E from the Earth's rate");
    let servo = |scenario: &mut Scenario| {
        scenario.population.scale_factor = 1.0;
        scenario.population.scale_factor_sd = 0.0;
        scenario.population.misalignment_arcmin = 0.0;
    };
    on_a_bench("turntable_servo", Positions::WithEdges, StatedE::No, servo).assert_honest("servo turntable");
}

#[test]
fn a_servo_table_that_cancels_the_gyro_is_recognised_by_the_earths_rate() {
    let servo = |sign: f64| {
        let mut scenario = Scenario { test: "turntable_servo".into(), ..Scenario::default() };
        scenario.gyros.truncate(1);
        scenario.population.scale_factor = 1.0;
        scenario.population.scale_factor_sd = 0.0;
        scenario.programme.rates_arcsec_s = Vec::new();
        let mut run = simulate(&scenario).expect("it runs");
        run.campaign.dwells.iter_mut().flat_map(|d| &mut d.output_pulse_s).for_each(|y| *y *= sign);
        calibrate_bench(&run.campaign).map(|bench| bench.result(&run.campaign))
    };
    let (plain, cancelling) = (servo(1.0).expect("a table rate"), servo(-1.0).expect("a table rate"));
    assert!((plain.d_i - cancelling.d_i).abs() < 1e-12 && (plain.d_s - cancelling.d_s).abs() < 1e-12);
    let words = servo(1.47).expect_err("pulses are no table rate").to_string();
    assert!(words.contains("not_a_table_rate"), "{words}");
}

#[test]
fn a_bench_test_in_one_position_is_refused_with_the_reason() {
    let mut scenario = Scenario { test: "torque_feedback".into(), ..Scenario::default() };
    scenario.gyros.truncate(1);
    let mut run = simulate(&scenario).expect("it runs");
    let first = run.campaign.dwells[0].clone();
    run.campaign.dwells.iter_mut().for_each(|d| *d = first.clone());
    run.campaign.gyros[0].known_e = Some(run.world.gyros[0].e());
    let words = calibrate_bench(&run.campaign).expect_err("one position").to_string();
    assert!(words.contains("bench_undetermined") && words.contains("D_I"), "{words}");
    run.campaign.gyros[0].known_e = None;
    let words = calibrate_bench(&run.campaign).expect_err("no Earth's rate to go by").to_string();
    assert!(words.contains("bench_no_scale"), "{words}");
}
