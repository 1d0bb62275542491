//! Simulated campaigns: the fit recovers what was put in, without bias, and its sigmas are right from both sides.

use gyrowatch::core::calibrate::{Calibration, calibrate};
use gyrowatch::core::record::Plausibility;
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::scenario::{Scenario, StandardErrors};
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

    /// rms(error/sd) from 0.9 to 1.1, and a mean that chance explains.
    fn assert_honest(&self, what: &str) {
        assert!(!self.0.is_empty());
        for (name, ratios) in &self.0 {
            let n = ratios.len() as f64;
            let rms = (ratios.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
            let bias = ratios.iter().sum::<f64>() / n.sqrt();
            assert!((0.9..1.1).contains(&rms), "{what}: rms(error/sd) of {name} is {rms:.3}");
            assert!(bias.abs() < 4.0 * rms, "{what}: the mean error of {name} is {bias:.1} of its own sigma");
        }
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
