//! A diagnosis and a calibration of one campaign give one set of figures: chi-square, ratio of real to stated noise,
//! D_I and D_S.

use gyrowatch::blindcheck::draw::{Case, Draw};
use gyrowatch::core::augmented::{AugmentedModel, Options};
use gyrowatch::core::calibrate::drift::NotSeparated;
use gyrowatch::core::calibrate::{Calibration, calibrate_augmented};
use gyrowatch::core::campaign::Campaign;
use gyrowatch::core::diagnose::{Diagnosis, diagnose};
use gyrowatch::core::record::Plausibility;
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::scenario::StandardErrors;
use gyrowatch::simulate::simulate;

fn calibrated(campaign: &Campaign, model: &AugmentedModel) -> Calibration {
    let options = model.options(campaign);
    calibrate_augmented(campaign, options.terms.expect("set"), &options.adopted)
}

/// Sum of squares over the noise, stated or found, and degrees of freedom of all gyros.
fn reduced_chi2(fit: &Calibration) -> f64 {
    let sum: f64 = fit
        .gyros
        .iter()
        .map(|gyro| match &gyro.sigma {
            Some(sigma) if !fit.has_sem => {
                gyro.residuals.iter().zip(sigma.iter()).map(|(r, sd)| (r / sd).powi(2)).sum()
            }
            _ => gyro.chi2,
        })
        .sum();
    sum / fit.gyros.iter().map(|gyro| gyro.dof).sum::<usize>() as f64
}

/// Root mean square over the gyros; 1 where nothing is stated.
fn real_over_stated(fit: &Calibration) -> f64 {
    let squares = fit.gyros.iter().map(|gyro| gyro.noise.factor.expect("a noise").powi(2)).sum::<f64>();
    if fit.has_sem { (squares / fit.gyros.len() as f64).sqrt() } else { 1.0 }
}

fn same(diagnosed: f64, fitted: f64, what: &str) {
    assert!((diagnosed / fitted - 1.0).abs() < 1e-9, "{what}: {diagnosed} in the diagnosis, {fitted} in the fit");
}

/// Holds a diagnosis against the fits without and with what it named; answers how many coefficients were compared.
fn compared(campaign: &Campaign) -> usize {
    let diagnosis: Diagnosis = diagnose(campaign, &Options::default()).expect("it can be diagnosed");
    let model = AugmentedModel::default();
    let (plain, augmented) =
        (calibrated(campaign, &model), calibrated(campaign, &model.adopting(campaign, &diagnosis)));
    same(diagnosis.gap.reduced_chi2, reduced_chi2(&plain), "chi-square before");
    same(diagnosis.remaining.reduced_chi2, reduced_chi2(&augmented), "chi-square after");
    same(diagnosis.noise_floor.sem_factor, real_over_stated(&augmented), "real over stated noise");
    for (floor, gyro) in diagnosis.noise_floor.gyros.iter().zip(&augmented.gyros) {
        assert_eq!((floor.slot, floor.repeat_dof), (gyro.slot, gyro.noise.pure_error.dof));
    }
    let drift = |fit: &Calibration| fit.separate(&campaign.geometry, &Plausibility::default());
    let (before, after) = (drift(&plain), drift(&augmented));
    for impact in &diagnosis.impact {
        let j = plain.gyros.iter().position(|gyro| gyro.slot == impact.slot).expect("a gyro of the campaign");
        let i = ["D_I", "D_S"].iter().position(|name| *name == impact.coefficient).expect("one of both");
        match &before[j] {
            Ok(before) => {
                same(impact.plain, [before.rigid.d_i, before.rigid.d_s][i], "before");
                let sd = impact.plain_sd.expect("a noise");
                same(sd, before.rigid.sd().expect("a noise")[i], "its standard deviation");
            }
            // G was not in the model.
            Err(why) => assert!(matches!(why, NotSeparated::NoDrift) && impact.plain == 0.0, "{why}"),
        }
        let after = after[j].as_ref().expect("it is separated").rigid;
        same(impact.augmented, [after.d_i, after.d_s][i], "after");
        same(impact.augmented_sd, after.sd().expect("a noise")[i], "its standard deviation");
    }
    diagnosis.impact.len()
}

#[test]
fn of_campaigns_with_and_without_standard_errors_repeats_growth_and_other_durations() {
    for which in [StandardErrors::Exact, StandardErrors::Noisy, StandardErrors::Absent] {
        for (repeats, rate_noise_ppm, whole_turns) in
            [(6, 0.0, false), (0, 0.0, true), (6, 30.0, true), (0, 30.0, false)]
        {
            for seed in 0..3 {
                let mut scenario = preset("24-position").expect("a preset");
                scenario.seed = seed;
                scenario.columns.standard_errors = which;
                scenario.noise.rate_noise_ppm = rate_noise_ppm;
                scenario.programme.repeats = repeats;
                scenario.programme.whole_turns = whole_turns;
                compared(&simulate(&scenario).expect("it runs").campaign);
            }
        }
    }
}

#[test]
fn of_campaigns_with_effects_before_and_after_they_are_in_the_model() {
    let cases = vec![Case::One, Case::Pair, Case::Withheld];
    let draw = Draw { seed: 515, cases, effects: vec![], detectability: vec![12.0] };
    let compared: Vec<usize> = (0..30).map(|number| compared(&draw.trial(number).simulated.campaign)).collect();
    assert!(compared.iter().filter(|coefficients| **coefficients > 0).count() > 15, "{compared:?}");
}
