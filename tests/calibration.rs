//! Raw campaigns are fitted: figures against another program's, errors against sigmas, measured data against what
//! others found in them.

use gyrowatch::core::augmented::Options;
use gyrowatch::core::calibrate::outcome::evaluate;
use gyrowatch::core::calibrate::{Calibration, GyroCalibration, calibrate, calibrate_in_white_noise};
use gyrowatch::core::campaign::Campaign;
use gyrowatch::core::diagnose::diagnose;
use gyrowatch::core::model::{Term, Terms};
use gyrowatch::core::record::Plausibility;
use gyrowatch::core::separate::{JudgedMethod, Separation};
use gyrowatch::wire::calibration::CampaignAnswer;
use gyrowatch::wire::diagnosis::DiagnosisBody;
use gyrowatch::wire::document::parse;

fn read(name: &str) -> Campaign {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    parse(&text).unwrap_or_else(|faults| panic!("{path}: {faults}"))
}

fn separations(campaign: &Campaign, calibration: &Calibration) -> Vec<Separation> {
    let limits = Plausibility::default();
    calibration.separate(&campaign.geometry, &limits).into_iter().map(|s| s.expect("separable")).collect()
}

/// `python3 scripts/fit_reference.py tests/data/practice/campaign-00.json` (numpy 2.4.6, scipy 1.17.1).
const SCIPY: [(f64, [(&str, f64, f64); 13]); 3] = [
    (
        73.868811,
        [
            ("D0", 2.4259881827e+00, 1.778022e-04),
            ("G_x", 3.0078679046e+00, 3.207637e-04),
            ("G_y", -1.9314431771e+00, 2.992661e-04),
            ("G_z", 3.8123621990e+00, 3.056650e-04),
            ("P_x", -2.1022309104e-02, 2.570132e-04),
            ("P_y", -5.0979759717e-03, 2.481813e-04),
            ("P_z", 2.6120285293e-02, 2.505052e-04),
            ("E_x", 8.5281975668e-01, 1.229949e-07),
            ("E_y", -6.0051415779e-01, 1.123459e-07),
            ("E_z", 1.0504692025e+00, 1.361646e-07),
            ("D_I", 3.5273258783e+00, 2.092497e-04),
            ("D_S", 1.4540779728e-01, 2.032579e-04),
            ("D_O", -1.0628821036e-04, 2.130192e-04),
        ],
    ),
    (
        81.239585,
        [
            ("D0", -3.3909030724e+00, 1.730969e-04),
            ("G_x", -4.2293326700e+00, 3.116645e-04),
            ("G_y", 3.7099400513e+00, 2.922350e-04),
            ("G_z", 4.7434503660e+00, 2.961170e-04),
            ("P_x", 9.4412578497e-03, 2.504163e-04),
            ("P_y", -4.0752159353e-03, 2.419230e-04),
            ("P_z", -5.3660406508e-03, 2.433528e-04),
            ("E_x", 8.4640410817e-01, 1.145606e-07),
            ("E_y", -5.9650000256e-01, 1.067057e-07),
            ("E_z", -1.0340687012e+00, 1.324483e-07),
            ("D_I", -4.9954266504e+00, 2.055537e-04),
            ("D_S", 5.7635087905e-01, 2.003554e-04),
            ("D_O", -8.6539524017e-04, 2.092811e-04),
        ],
    ),
    (
        64.223422,
        [
            ("D0", -3.6130941495e+00, 1.771094e-04),
            ("G_x", -3.4756843871e+00, 3.326524e-04),
            ("G_y", -4.9167967126e+00, 3.116142e-04),
            ("G_z", -7.3103111392e+00, 2.739984e-04),
            ("P_x", -5.5903080685e-02, 2.616419e-04),
            ("P_y", 1.5428043344e-03, 2.526496e-04),
            ("P_z", 5.4360276368e-02, 2.379859e-04),
            ("E_x", 8.4986341029e-01, 1.189157e-07),
            ("E_y", 1.2005234132e+00, 1.403354e-07),
            ("E_z", 2.7542151766e-06, 8.578209e-08),
            ("D_I", -4.0936017063e+00, 2.167460e-04),
            ("D_S", -4.9699761536e+00, 1.862824e-04),
            ("D_O", 2.7571419513e-03, 2.214878e-04),
        ],
    ),
];

#[test]
fn a_campaign_is_fitted_as_scipy_fits_it() {
    let campaign = read("practice/campaign-00.json");
    let calibration = calibrate_in_white_noise(&campaign, Terms::MODEL_6);
    let drifts = separations(&campaign, &calibration);
    for ((gyro, drift), (chi2, reference)) in calibration.gyros.iter().zip(&drifts).zip(&SCIPY) {
        assert_eq!((gyro.rank, gyro.dof, gyro.parameters.len()), (9, 69, 10));
        assert!((gyro.chi2 / chi2 - 1.0).abs() < 1e-7, "{} is not {chi2}", gyro.chi2);
        // scipy's covariance is that of the standard errors as given.
        let scale = gyro.noise.covariance_scale().expect("standard errors are given").sqrt();
        for (name, value, sd) in reference {
            let (found, found_sd) = figure(gyro, drift, name);
            assert!((found - value).abs() < 1e-3 * sd, "{name}: {found} is not {value}");
            assert!((found_sd / scale / sd - 1.0).abs() < 1e-5, "{name}: sd {} is not {sd}", found_sd / scale);
        }
    }
}

fn figure(gyro: &GyroCalibration, drift: &Separation, name: &str) -> (f64, f64) {
    let [sd_i, sd_s, sd_o] = drift.rigid.sd().expect("a covariance");
    match name {
        "D_I" => (drift.rigid.d_i, sd_i),
        "D_S" => (drift.rigid.d_s, sd_s),
        "D_O" => (drift.rigid.d_o, sd_o),
        _ => {
            let p = gyro.parameters.iter().find(|p| p.name == name).expect("every parameter is fitted");
            (p.value, p.sd.expect("determined"))
        }
    }
}

#[test]
fn practice_campaigns_without_an_effect_give_the_true_drift() {
    let key: serde_json::Value =
        serde_json::from_slice(&std::fs::read("tests/data/practice/key.json").expect("the key")).expect("JSON");
    let clean: Vec<&String> = key
        .as_object()
        .expect("by file")
        .iter()
        .filter(|(_, k)| k["effects"].as_array().is_some_and(Vec::is_empty))
        .map(|(name, _)| name)
        .collect();
    assert!(clean.len() >= 2, "{clean:?}");
    for name in clean {
        let campaign = read(&format!("practice/{name}"));
        let drifts = separations(&campaign, &calibrate(&campaign, Terms::MODEL_6));
        for (drift, truth) in drifts.iter().zip(key[name]["truth"].as_array().expect("by gyro")) {
            let [sd_i, sd_s, _] = drift.rigid.sd().expect("a noise scale");
            for (found, sd, truth) in [(drift.rigid.d_i, sd_i, &truth["D_I"]), (drift.rigid.d_s, sd_s, &truth["D_S"])] {
                let error = found - truth.as_f64().expect("a number");
                assert!(error.abs() < 3.0 * sd && sd < 1e-3, "{name} {}: {error} +- {sd}", drift.slot.name());
            }
        }
    }
}

/// What an independent analysis found for the Xsens MTi: deg/s per g, +- 0.004.
#[test]
fn the_measured_xsens_campaign_gives_its_known_g_sensitivities() {
    let campaign = read("measured/xsens-mti.json");
    let calibration = calibrate(&campaign, Terms::of(&[Term::Bias, Term::GLinear]));
    let known = [[0.008, 0.026, 0.057], [-0.118, 0.003, 0.075], [-0.063, -0.073, 0.019]];
    for (gyro, known) in calibration.gyros.iter().zip(known) {
        let g = gyro.g().expect("fitted") / 3600.0;
        for axis in 0..3 {
            assert!((g[axis] - known[axis]).abs() < 0.004, "{}: {g} is not {known:?}", gyro.slot.name());
        }
    }
    assert_eq!(separations(&campaign, &calibration).len(), 3);
}

#[test]
fn measured_campaigns_take_any_set_of_terms() {
    for name in ["measured/xsens-mti.json", "measured/mimu-imu1-run4.json"] {
        let campaign = read(name);
        for mask in 1..16u8 {
            let chosen: Vec<Term> = Term::ALL.into_iter().filter(|t| mask & (1 << *t as u8) != 0).collect();
            let calibration = calibrate(&campaign, Terms::of(&chosen));
            for gyro in &calibration.gyros {
                assert!(gyro.parameters.iter().all(|p| p.value.is_finite() && p.sd.is_none_or(f64::is_finite)));
            }
        }
    }
}

#[test]
fn standard_errors_that_are_far_too_large_are_told() {
    let campaign = read("practice/campaign-00.json");
    let told = |times: f64| {
        let mut campaign = campaign.clone();
        for sem in campaign.dwells.iter_mut().filter_map(|dwell| dwell.output_sem_pulse_s.as_mut()).flatten() {
            *sem *= times;
        }
        let answer =
            CampaignAnswer::of(&campaign, &evaluate(&campaign, &Plausibility::default()).unwrap(), JudgedMethod::Rigid);
        let diagnosis = diagnose(&campaign, &Options::default()).unwrap();
        let of_fit = answer.notes.into_iter().map(|note| note.detail).collect::<Vec<_>>();
        [of_fit, DiagnosisBody::from(&diagnosis).notes].map(|notes| {
            notes.into_iter().filter(|note| note.contains("larger than the scatter of the dwells")).collect::<Vec<_>>()
        })
    };
    assert_eq!(told(1.0), [vec![], vec![]] as [Vec<String>; 2]);
    for notes in told(10.0) {
        assert!(matches!(&notes[..], [note] if note.contains("G1 ") && note.contains("G3 ")), "{notes:?}");
    }
}

#[test]
fn chi_square_of_a_campaign_is_that_of_its_gyros_over_all_that_is_left_over() {
    let mut campaign = read("practice/campaign-00.json");
    let stated = calibrate_in_white_noise(&campaign, Terms::MODEL_6).reduced_chi2().expect("dwells are left over");
    let of_scipy: f64 = SCIPY.iter().map(|(chi2, _)| chi2).sum();
    assert!((stated / (of_scipy / (3.0 * 69.0)) - 1.0).abs() < 1e-7, "{stated}");
    // Without standard errors repeats give the noise, and the residuals are about as large.
    campaign.dwells.iter_mut().for_each(|dwell| dwell.output_sem_pulse_s = None);
    let found = calibrate_in_white_noise(&campaign, Terms::MODEL_6).reduced_chi2().expect("dwells are repeated");
    assert!((0.5..2.0).contains(&found), "{found}");
}

#[test]
fn how_far_a_bias_wanders_is_said_in_deg_per_h_whatever_a_pulse_is_worth() {
    const STEP: f64 = 2.0;
    let campaign = read("practice/campaign-00.json");
    // deg/h is arcsec/s: the output of a gyro is E pulse/s to the deg/h.
    let wandering = |pulses: f64| {
        let (mut campaign, mut walk, mut state) = (campaign.clone(), [0.0; 3], 1_u64);
        for dwell in &mut campaign.dwells {
            let errors = dwell.output_sem_pulse_s.as_mut().expect("errors are stated");
            for ((output, error), walk) in dwell.output_pulse_s.iter_mut().zip(errors).zip(&mut walk) {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                *walk += if state >> 63 == 0 { STEP } else { -STEP } * *error;
                *output = (*output + *walk) * pulses;
                *error *= pulses;
            }
        }
        let memory = calibrate(&campaign, Terms::MODEL_6).noise_found.memory.expect("it wanders");
        memory.deg_per_h.into_iter().map(|(_, deg_per_h)| deg_per_h).collect::<Vec<f64>>()
    };
    let (as_it_is, sevenfold) = (wandering(1.0), wandering(7.0));
    let usual = campaign.errors_of(0).expect("errors are stated")[0];
    // At mid-campaign a walk has gone the root of half its steps.
    let expected = STEP * usual * (campaign.dwells.len() as f64 / 2.0).sqrt();
    for (one, seven) in as_it_is.iter().zip(&sevenfold) {
        assert!((seven / one - 1.0).abs() < 1e-3, "{one} and {seven}");
        assert!((0.4..2.5).contains(&(one / expected)), "{one} is not about {expected}");
    }
}
