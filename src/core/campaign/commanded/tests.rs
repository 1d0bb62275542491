//! Commanded vectors of a few dwells, exact by eye. `tests/commanded.rs` has whole populations.

use nalgebra::Vector3;

use super::*;
use crate::core::campaign::made_for_tests::{self, name};
use crate::core::campaign::{Campaign, CampaignGyro, Dwell, Phase, Site};
use crate::core::mounting::Slot;

const OMEGA: f64 = 15.041_067;

/// Six faces in two headings at latitude 30 (sin 1/2) without attitudes, orthogonal gyros of 2 pulse/arcsec that
/// drift with 3 deg/(h g0) along I.
fn faces() -> Campaign {
    let (up, north) = (0.5 * OMEGA, 0.866_025_404 * OMEGA);
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut dwells = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            for heading in [1, 2] {
                let f = sign * axes[axis] * 0.998;
                let w = sign * up * axes[axis] + north * axes[(axis + heading) % 3];
                let noise = |j: usize| 1e-4 * ((dwells.len() * 7 + j * 3) as f64).sin();
                let output = (0..3).map(|j| 2.0 * (w[j] + 3.0 * f[j]) + noise(j)).collect();
                dwells.push(Dwell {
                    output_sem_pulse_s: Some(vec![1e-4; 3]),
                    ..made_for_tests::dwell(dwells.len(), f, w, output)
                });
            }
        }
    }
    let gyro = |slot: Slot| CampaignGyro { slot, serial: name(slot.name()), known_e: Some(2.0 * axes[slot.index()]) };
    Campaign {
        site: Some(Site { latitude: 30_f64.to_radians(), gravity_g0: 0.998, magnetic_field_nav: None }),
        ..made_for_tests::campaign(Slot::ALL.map(gyro).to_vec(), dwells)
    }
}

fn with(change: impl Fn(usize, &mut Dwell)) -> Vec<CommandFinding> {
    let mut campaign = faces();
    campaign.dwells.iter_mut().enumerate().for_each(|(k, dwell)| change(k, dwell));
    findings(&campaign)
}

fn only(mut found: Vec<CommandFinding>) -> CommandFinding {
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

#[test]
fn what_the_earth_allows_is_no_finding() {
    assert_eq!(with(|_, _| {}), []);
    let rounded = |x: f64| (x * 100.0).round() / 100.0;
    assert_eq!(with(|_, d| d.rate_arcsec_s = d.rate_arcsec_s.map(rounded)), [], "two printed decimals");
}

#[test]
fn a_reversed_force_and_a_reversed_latitude_are_one_to_vectors_without_attitudes() {
    let finding = only(with(|_, d| d.specific_force_g0 *= -1.0));
    assert_eq!(finding.causes, [MistakeKind::ForceReversed, MistakeKind::LatitudeReversed]);
    assert_eq!((finding.symptom, finding.dwells.len(), finding.of), (Symptom::VerticalRate, 12, 12));
    assert!(
        (finding.measured() + 7.520_53).abs() < 1e-4 && finding.expected.is_some_and(|e| (e - 7.520_53).abs() < 1e-4)
    );
    assert!(finding.matters && !finding.single);
}

#[test]
fn single_dwells_are_named_and_the_others_believed() {
    let finding = only(with(|k, d| {
        if k == 4 {
            d.specific_force_g0 *= -1.0;
        }
    }));
    assert_eq!(finding.dwells.iter().map(|(k, _)| *k).collect::<Vec<_>>(), [4]);
    assert!(finding.single && finding.matters && finding.causes.contains(&MistakeKind::ForceReversed), "{finding:?}");
    let finding = only(with(|k, d| {
        if k == 7 {
            d.rate_arcsec_s.fill(0.0);
        }
    }));
    assert_eq!((finding.causes, finding.dwells), (vec![MistakeKind::EarthRateLeftOut], vec![(7, 0.0)]));
}

#[test]
fn a_common_scale_of_the_force_is_seen_where_it_moves_drift_by_a_tenth_of_the_budget() {
    // 1/0.998 of 3 deg/(h g0) is 0.006 of it; 1.0002 is 0.0006.
    let finding = only(with(|_, d| d.specific_force_g0 /= 0.998));
    assert_eq!((finding.symptom, finding.causes), (Symptom::Gravity, vec![MistakeKind::ForceNormalised]));
    assert!(finding.matters);
    assert_eq!(with(|_, d| d.specific_force_g0 *= 1.0002), []);
    let finding = only(with(|_, d| d.specific_force_g0 *= 1.001));
    assert!(matches!(finding.causes[..], [MistakeKind::ForceScale { ratio }] if (ratio - 1.001).abs() < 1e-9));
    assert!(finding.matters);
}

#[test]
fn what_the_noise_hides_does_not_matter() {
    let noisy = |k: usize, d: &mut Dwell| {
        let scatter = |j: usize| 60.0 * ((k * 13 + j * 5) as f64 * 1.7).sin();
        d.output_pulse_s = (0..3).map(|j| 2.0 * scatter(j)).collect();
        d.output_sem_pulse_s = Some(vec![40.0; 3]);
        d.rate_arcsec_s.fill(0.0);
    };
    let finding = only(with(noisy));
    assert_eq!(finding.causes, [MistakeKind::EarthRateLeftOut]);
    assert!(!finding.matters);
    let small_errors = |k: usize, d: &mut Dwell| {
        noisy(k, d);
        d.output_sem_pulse_s = Some(vec![1e-3; 3]);
    };
    assert!(!only(with(small_errors)).matters, "what is stated is not what the outputs show");
}

#[test]
fn units_are_told_by_the_earths_own_rate() {
    for (unit, size) in [("deg/s", 3600.0), ("rad/s", 206_264.806), ("arcmin/s", 60.0)] {
        let finding = only(with(|_, d| d.rate_arcsec_s /= size));
        assert!(
            matches!(finding.causes[..], [MistakeKind::RateUnit { unit: told, .. }] if told == unit),
            "{finding:?}"
        );
    }
    let finding = only(with(|_, d| d.specific_force_g0 *= 9.80665));
    assert_eq!(finding.causes, [MistakeKind::ForceUnit { unit: "m/s^2" }]);
}

#[test]
fn one_axis_is_told_by_the_dwells_that_it_spoils() {
    let finding = only(with(|_, d| d.specific_force_g0.y *= -1.0));
    assert_eq!(finding.causes, [MistakeKind::AxisReversed { axis: 1, of: Vectors::Force }]);
    assert_eq!(finding.dwells.len(), 4, "a third of them has it up or down");
    let finding = only(with(|_, d| d.rate_arcsec_s.swap_rows(0, 2)));
    assert_eq!(finding.causes, [MistakeKind::AxesExchanged { axes: (0, 2), of: Vectors::Rate }]);
    let finding = only(with(|_, d| {
        d.rate_arcsec_s.swap_rows(0, 1);
        d.specific_force_g0.swap_rows(0, 1);
    }));
    assert_eq!((finding.symptom, finding.matters), (Symptom::Output, true), "only the outputs tell: {finding:?}");
    assert!(finding.causes.contains(&MistakeKind::AxesExchanged { axes: (0, 1), of: Vectors::Both }), "{finding:?}");
}

/// The faces, and each of them turning at 1 deg/s, to and fro.
fn with_turns() -> Campaign {
    let mut campaign = faces();
    for (k, still) in campaign.dwells.clone().into_iter().enumerate() {
        let turn = if k.is_multiple_of(2) { 3600.0 } else { -3600.0 };
        let w = (turn + 0.5 * OMEGA) * still.specific_force_g0 / 0.998;
        let output_pulse_s = (0..3).map(|j| 2.0 * (w[j] + 3.0 * still.specific_force_g0[j])).collect();
        let start_s = still.start_s + 2880.0;
        campaign.dwells.push(Dwell { phase: Phase::Rate, start_s, rate_arcsec_s: w, output_pulse_s, ..still });
    }
    campaign
}

#[test]
fn axes_that_are_exchanged_in_one_kind_of_dwells_are_told_and_the_latitude_is_not_blamed() {
    assert_eq!(findings(&with_turns()), []);
    for (phase, symptom) in [(Phase::Rate, Symptom::TurningRate), (Phase::Static, Symptom::VerticalRate)] {
        let mut campaign = with_turns();
        let of_kind = campaign.dwells.iter_mut().filter(|dwell| dwell.phase == phase);
        of_kind.for_each(|dwell| dwell.rate_arcsec_s.swap_rows(0, 1));
        let finding = only(findings(&campaign));
        assert_eq!(finding.causes, [MistakeKind::AxesExchanged { axes: (0, 1), of: Vectors::Rate }], "{phase:?}");
        assert_eq!((finding.symptom, finding.single, finding.matters), (symptom, false, true));
    }
}

#[test]
fn turning_rates_that_are_the_tables_alone_are_told_by_the_outputs() {
    let with_turning = |change: &dyn Fn(&mut Dwell)| {
        let mut campaign = with_turns();
        campaign.dwells.iter_mut().filter(|dwell| dwell.phase == Phase::Rate).for_each(change);
        findings(&campaign)
    };
    let up = |dwell: &Dwell| dwell.specific_force_g0 / 0.998;
    let finding = only(with_turning(&|dwell| dwell.rate_arcsec_s -= 0.5 * OMEGA * up(dwell)));
    assert_eq!((finding.symptom, finding.causes), (Symptom::Output, vec![MistakeKind::EarthRateLeftOut]));
    assert!(finding.matters && finding.dwells.len() == 12);
    let reversed = only(with_turning(&|dwell| dwell.rate_arcsec_s -= OMEGA * up(dwell)));
    assert_eq!((reversed.symptom, reversed.causes), (Symptom::Output, vec![MistakeKind::NedForEnu]));
    // A table that makes up for the Earth's rate is believed: the gyros measure what it says.
    let made_up_for = |dwell: &mut Dwell| {
        dwell.rate_arcsec_s -= 0.5 * OMEGA * up(dwell);
        let w = dwell.rate_arcsec_s + 3.0 * dwell.specific_force_g0;
        dwell.output_pulse_s = w.iter().map(|w| 2.0 * w).collect();
    };
    assert_eq!(with_turning(&made_up_for), []);
}

#[test]
fn rates_of_another_latitude_are_told_beyond_printed_digits_and_refused_beyond_the_budget() {
    let of = |latitude: f64, round: f64| {
        let mut campaign = faces();
        campaign.site = campaign.site.map(|site| Site { latitude: latitude.to_radians(), ..site });
        let rounded = |x: f64| (x / round).round() * round;
        campaign.dwells.iter_mut().for_each(|dwell| dwell.rate_arcsec_s = dwell.rate_arcsec_s.map(rounded));
        (findings(&campaign).len(), latitude_of_rates(&campaign))
    };
    let (found, told) = of(30.0312, 1e-7);
    let (degrees, off) = told.expect("more than its digits");
    let expected = OMEGA * 0.0312_f64.to_radians() * 0.866;
    assert!(found == 0 && (degrees - 30.0).abs() < 1e-3 && (off - expected).abs() < 1e-5, "{degrees} {off}");
    assert_eq!(of(30.0512, 1e-7).0, 1, "D_I is off by more than its budget");
    assert_eq!(of(30.1, 1e-7).0, 1, "no rounding of 30");
    for (latitude, round) in [(30.0, 1e-7), (30.004, 1e-2), (30.0, 1e-2)] {
        assert_eq!(of(latitude, round), (0, None), "{latitude} {round}");
    }
}

#[test]
fn a_mistake_that_is_not_known_is_not_called_the_latitude_that_is_stated() {
    let mut campaign = with_turns();
    let turning = campaign.dwells.iter_mut().filter(|dwell| dwell.phase == Phase::Rate).enumerate();
    turning.for_each(|(k, dwell)| dwell.rate_arcsec_s = Vector3::new(k as f64, 1000.0, -700.0));
    let finding = only(findings(&campaign));
    assert_eq!((finding.symptom, finding.causes), (Symptom::TurningRate, Vec::new()));
}
