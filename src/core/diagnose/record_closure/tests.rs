use nalgebra::Vector3;

use super::*;
use crate::core::mounting::Geometry;
use crate::core::separate::{diagonal_covariance, separate};

/// A nominally mounted G2 with 1 pulse/arcsec.
fn gyro(d_s: f64, d_o: f64, g_sd: Option<f64>) -> Separation {
    let triad = Geometry::Skewed.triad(Slot::G2).unwrap().mat_gyro_body();
    let e = triad.row(0).transpose();
    let g = triad.transpose() * Vector3::new(1.0, d_s, d_o);
    let sd = g_sd.map(Vector3::repeat);
    let covariance = diagonal_covariance(Some(&Vector3::repeat(1e-9)), sd.as_ref()).filter(|_| g_sd.is_some());
    separate(&Geometry::Skewed, Slot::G2, &e, &g, covariance.as_ref()).unwrap()
}

#[test]
fn the_readings_of_a_closure_are_what_nothing_but_a_closure_shows() {
    let closure_only = crate::core::effects::CATALOGUE.iter().filter(|entry| entry.closure_only);
    assert_eq!(closure_only.map(|entry| entry.effect).collect::<Vec<_>>(), CLOSURE_CLASS);
}

fn diagnosed(separation: &Separation) -> ClosureDiagnosis {
    closures([(Slot::G2, separation)].into_iter())
}

#[test]
fn without_its_noise_a_closure_counts_from_the_budget_on() {
    assert_eq!(diagnosed(&gyro(4.0, 0.009, None)).verdict, Verdict::NoGap);
    let above = diagnosed(&gyro(4.0, -0.011, None));
    assert_eq!(above.verdict, Verdict::PartlyExplained);
    assert!((above.gyros[0].of_budget - 1.1).abs() < 1e-9 && above.gyros[0].p_value.is_none());
}

#[test]
fn with_its_noise_a_closure_counts_where_noise_cannot_make_it() {
    // Three standard deviations: 0.0027. Two: 0.0455.
    let three = diagnosed(&gyro(4.0, 0.03, Some(0.01)));
    assert!((three.gyros[0].p_value.unwrap() - 0.0027).abs() < 1e-4);
    assert_eq!(three.verdict, Verdict::PartlyExplained);
    assert_eq!(diagnosed(&gyro(4.0, 0.02, Some(0.01))).verdict, Verdict::NoGap);
}

#[test]
fn clocking_turns_a_longer_d_s_into_what_is_seen_whatever_its_sign() {
    for (d_s, d_o) in [(3.0, 0.4), (-3.0, 0.4), (3.0, -0.4), (-3.0, -0.4)] {
        let closure = &diagnosed(&gyro(d_s, d_o, None)).gyros[0];
        let true_d_s = d_s + closure.d_s_shift;
        assert!((true_d_s * closure.clocking.cos() - d_s).abs() < 1e-9, "{d_s} {d_o}");
        assert!((true_d_s * closure.clocking.sin() - d_o).abs() < 1e-9, "{d_s} {d_o}");
    }
}

#[test]
fn the_telling_change_moves_a_clocked_d_o_by_three_of_its_deviations() {
    let closure = &diagnosed(&gyro(4.0, 0.2, Some(0.01))).gyros[0];
    let moved = closure.clocking.tan() * closure.telling_change.unwrap();
    assert!((moved - 3.0 * 0.01 * 2.0_f64.sqrt()).abs() < 1e-6, "{moved}");
    let aligned = &diagnosed(&gyro(0.0, 0.2, None)).gyros[0];
    assert!(aligned.telling_change.is_some_and(|change| change == 0.0) && aligned.clocking > 1.5);
}
