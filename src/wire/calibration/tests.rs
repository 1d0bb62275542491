use nalgebra::Vector3;

use super::*;
use crate::core::calibrate::outcome::evaluate;
use crate::core::campaign::made_for_tests::{self, name};
use crate::core::campaign::{CampaignGyro, Dwell, TestKind};
use crate::core::record::Plausibility;

/// A tumble about the output axis with D_I of 2.5, D_S of -3.5 deg/(h g0) and a product of their forces, noise of a
/// thousandth.
fn tumble(product: f64) -> Campaign {
    let dwell = |k: usize| {
        let turn = std::f64::consts::TAU * k as f64 / 24.0;
        let (a, w) = (turn.sin_cos(), (turn + 0.9).sin_cos());
        let noise = 1e-3 * if k.is_multiple_of(3) { 1.0 } else { -0.7 };
        let output = 12.0 * w.1 + 0.4 + 2.5 * a.1 - 3.5 * a.0 + product * a.0 * a.1 + noise;
        let (force, rate) = (Vector3::new(a.1, a.0, 0.0), Vector3::new(12.0 * w.1, 12.0 * w.0, 9.0));
        Dwell { output_sem_pulse_s: Some(vec![1e-3]), ..made_for_tests::dwell(k, force, rate, vec![output]) }
    };
    let gyro = CampaignGyro { slot: Slot::G1, serial: name("A"), known_e: Some(Vector3::x()) };
    let dwells = (0..24).map(dwell).collect();
    Campaign { test: TestKind::TorqueFeedback, ..made_for_tests::campaign(vec![gyro], dwells) }
}

#[test]
fn residuals_of_a_bench_test_that_exceed_the_noise_are_noted() {
    for (product, noted) in [(0.0, false), (0.05, true)] {
        let campaign = tumble(product);
        let outcome = evaluate(&campaign, &Plausibility::ever()).expect("sound");
        let answer = CampaignAnswer::of(&campaign, &outcome, JudgedMethod::default());
        assert_eq!(answer.notes.iter().any(|note| note.code == "residuals_exceed_noise"), noted, "{:?}", answer.notes);
    }
}
