//! What the separation is worth: its error against a known truth, its sigmas against its errors, its symmetries.
//!
//! Truth is made by turning the triads with nalgebra's rotations; nothing here uses the separation's own formulas.

use gyrowatch::core::mounting::{Geometry, Slot, Triad};
use gyrowatch::core::record::{GyroParameters, Name};
use gyrowatch::core::separate::{CovarianceEg, Separation, diagonal_covariance, separate, stated_covariance};
use gyrowatch::core::units::radians_from_arcmin;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn normal_vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(rng))
}

/// A gyro mounted with an error of `sigma` radians about each body axis, and what model (6) says of it.
struct Truth {
    slot: Slot,
    d_i: f64,
    d_s: f64,
    e: Vector3<f64>,
    g: Vector3<f64>,
}

impl Truth {
    fn draw(rng: &mut ChaCha8Rng, sigma: f64) -> Self {
        let slot = Slot::ALL[rand::RngExt::random_range(rng, 0..3)];
        let triad = Geometry::Skewed.triad(slot).expect("every slot");
        let turn = Rotation3::new(normal_vector(rng) * sigma);
        let (input, spin) = (turn * triad.input(), turn * triad.spin());
        let (d_i, d_s) = (5.0 * normal(rng), 7.0 * normal(rng));
        let scale = 1.47;
        Self { slot, d_i, d_s, e: input * scale, g: (input * d_i + spin * d_s) * scale }
    }

    fn separated(&self, covariance: Option<&CovarianceEg>) -> Separation {
        separate(&Geometry::Skewed, self.slot, &self.e, &self.g, covariance).expect("a small mounting error")
    }
}

#[derive(Default)]
struct Rms {
    sum: f64,
    n: usize,
}

impl Rms {
    fn add(&mut self, x: f64) {
        self.sum += x * x;
        self.n += 1;
    }

    fn value(&self) -> f64 {
        (self.sum / self.n as f64).sqrt()
    }
}

/// Rms errors (D_I, D_S) of the published method where it took the tilted and the untilted branch, and of rigid.
fn method_errors(arcmin: f64, gyros: usize) -> [(f64, f64); 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(arcmin.to_bits());
    let mut rms: [(Rms, Rms); 3] = Default::default();
    for _ in 0..gyros {
        let truth = Truth::draw(&mut rng, radians_from_arcmin(arcmin));
        let got = truth.separated(None);
        let published = got.published.expect("skewed");
        let tilted = matches!(published.branch.name(), "8" | "10" | "12");
        for (row, d_i, d_s) in [(usize::from(!tilted), published.d_i, published.d_s), (2, got.rigid.d_i, got.rigid.d_s)]
        {
            rms[row].0.add(d_i - truth.d_i);
            rms[row].1.add(d_s - truth.d_s);
        }
    }
    rms.map(|(i, s)| (i.value(), s.value()))
}

#[test]
fn the_table_of_method_errors_in_the_documentation_holds() {
    // (arcmin, tilted D_I / D_S, untilted D_I / D_S, rigid D_S), deg/(h g0): docs/method.md. The figures are of
    // another program (400,000 draws in numpy).
    let table = [
        (1.0, (1.19e-2, 6.2e-4), (1.9e-3, 5.6e-7), 5.1e-7),
        (6.0, (7.3e-2, 5.0e-3), (1.14e-2, 2.0e-5), 1.9e-5),
        (20.0, (2.39e-1, 3.9e-2), (3.8e-2, 2.3e-4), 2.0e-4),
    ];
    for (arcmin, tilted, untilted, rigid_d_s) in table {
        let got = method_errors(arcmin, 60_000);
        let [(t_i, t_s), (u_i, u_s), (r_i, r_s)] = got;
        println!(
            "{arcmin:>5} arcmin  tilted {t_i:.2e} / {t_s:.1e}  untilted {u_i:.2e} / {u_s:.1e}  rigid {r_i:.0e} / {r_s:.1e}"
        );
        // The errors are products of normal variables: the rms of their squares scatters widely.
        for (what, got, want, tolerance) in [
            ("tilted D_I", t_i, tilted.0, 0.06),
            ("tilted D_S", t_s, tilted.1, 0.25),
            ("untilted D_I", u_i, untilted.0, 0.03),
            ("untilted D_S", u_s, untilted.1, 0.25),
            ("rigid D_S", r_s, rigid_d_s, 0.1),
        ] {
            assert!((got / want - 1.0).abs() < tolerance, "{what} at {arcmin} arcmin: {got:.2e} instead of {want:.1e}");
        }
        assert!(got[2].0 < 1e-14, "rigid D_I is exact: {:e}", got[2].0);
    }
}

#[test]
fn the_rigid_error_grows_with_the_square_of_the_clocking_and_d_i_stays_exact() {
    let at = |arcmin| method_errors(arcmin, 20_000)[2];
    let (small, large) = (at(0.1), at(60.0));
    assert!(small.0 < 1e-14 && large.0 < 1e-13);
    let ratio = large.1 / small.1;
    assert!((ratio / 360_000.0 - 1.0).abs() < 0.15, "600 times the angle, 360000 times the error: {ratio}");
}

#[test]
fn the_clocking_angle_is_the_turn_about_the_input_axis() {
    for slot in Slot::ALL {
        let triad = Geometry::Skewed.triad(slot).expect("every slot");
        let psi = radians_from_arcmin(17.0);
        let spin = triad.spin() * psi.cos() + triad.output() * psi.sin();
        let g = triad.input() * 2.0 + spin * 5.0;
        let got = separate(&Geometry::Skewed, slot, &triad.input(), &g, None).expect("nominal").rigid;
        assert!((got.clocking() - psi).abs() < 1e-12);
        assert!((got.d_s - 5.0 * psi.cos()).abs() < 1e-12 && (got.d_o - 5.0 * psi.sin()).abs() < 1e-12);
    }
}

/// A covariance whose cross terms are as large as its variances: L L^T of a random L, in the units of E and G.
fn correlated_covariance(rng: &mut ChaCha8Rng) -> (Matrix6<f64>, CovarianceEg) {
    let units = Matrix6::from_diagonal(&Vector6::new(3e-5, 3e-5, 3e-5, 3e-4, 3e-4, 3e-4));
    let root = units * Matrix6::from_fn(|_, _| normal(rng));
    (root, root * root.transpose())
}

fn perturbed(truth: &Truth, root: &Matrix6<f64>, rng: &mut ChaCha8Rng) -> Truth {
    let noise = root * Vector6::from_fn(|_, _| normal(rng));
    let (e, g) = (noise.fixed_rows::<3>(0).into_owned(), noise.fixed_rows::<3>(3).into_owned());
    Truth { e: truth.e + e, g: truth.g + g, ..*truth }
}

/// (error)/(reported sigma) of every figure that carries one, for a noisy measurement of `truth`.
fn standardised_errors(truth: &Truth, noisy: &Truth, covariance: &CovarianceEg) -> Vec<(&'static str, f64)> {
    let (exact, got) = (truth.separated(None), noisy.separated(Some(covariance)));
    let sd = got.rigid.sd().expect("a covariance was given");
    let mut errors = vec![
        ("scale factor", (got.scale_factor - exact.scale_factor) / got.scale_factor_sd.expect("given")),
        ("D_I", (got.rigid.d_i - exact.rigid.d_i) / sd[0]),
        ("D_S", (got.rigid.d_s - exact.rigid.d_s) / sd[1]),
        ("D_O", (got.rigid.d_o - exact.rigid.d_o) / sd[2]),
        // A linear combination, so that the covariances between the three are tested too.
        ("D_I - D_S + D_O", {
            let (c, w) = (got.rigid.covariance.expect("given"), Vector3::new(1.0, -1.0, 1.0));
            let error = (got.rigid.d_i - exact.rigid.d_i) - (got.rigid.d_s - exact.rigid.d_s)
                + (got.rigid.d_o - exact.rigid.d_o);
            error / w.dot(&(c * w)).sqrt()
        }),
    ];
    if truth.d_s.abs() > 1.0 {
        let clocking_sd = got.rigid.clocking_sd().expect("D_S is not zero");
        let error = got.rigid.clocking() - exact.rigid.clocking();
        errors.push(("clocking", error.sin() / clocking_sd)); // sin: the angle may pass from pi to -pi
    }
    let (published, nominal) = (got.published.expect("skewed"), exact.published.expect("skewed"));
    if published.branch == nominal.branch {
        let sd = published.sd().expect("a covariance was given");
        errors.push(("published D_I", (published.d_i - nominal.d_i) / sd[0]));
        errors.push(("published D_S", (published.d_s - nominal.d_s) / sd[1]));
    }
    errors
}

#[test]
fn reported_sigmas_are_neither_too_small_nor_too_large() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut rms: std::collections::BTreeMap<&str, Rms> = std::collections::BTreeMap::new();
    for _ in 0..20_000 {
        let truth = Truth::draw(&mut rng, radians_from_arcmin(20.0));
        let (root, covariance) = correlated_covariance(&mut rng);
        let noisy = perturbed(&truth, &root, &mut rng);
        for (what, error) in standardised_errors(&truth, &noisy, &covariance) {
            rms.entry(what).or_default().add(error);
        }
    }
    for (what, rms) in &rms {
        println!("{what:>16}: error/sigma rms {:.3} over {}", rms.value(), rms.n);
        assert!((0.95..1.05).contains(&rms.value()), "{what}: {}", rms.value());
    }
    assert_eq!(rms.len(), 8);
}

#[test]
fn cross_terms_between_e_and_g_count() {
    // E and G in error by the same relative amount: the quotient, and so every coefficient, has no error at all.
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let truth = Truth::draw(&mut rng, radians_from_arcmin(5.0));
    let common = Vector6::from_iterator(truth.e.iter().chain(truth.g.iter()).map(|x| x * 1e-3));
    let covariance = common * common.transpose();
    let sd = truth.separated(Some(&covariance)).rigid.sd().expect("given");
    assert!(sd.iter().all(|&sd| sd < 1e-9), "{sd:?}");
    let diagonal = Matrix6::from_diagonal(&covariance.diagonal());
    assert!(truth.separated(Some(&diagonal)).rigid.sd().expect("given")[1] > 1e-3);
}

#[test]
fn sigmas_appear_only_where_both_of_e_and_g_have_them() {
    let sd = Vector3::repeat(1e-4);
    assert!(diagonal_covariance(Some(&sd), None).is_none());
    assert!(diagonal_covariance(None, Some(&sd)).is_none());
    let both = diagonal_covariance(Some(&sd), Some(&sd)).expect("both are there");
    assert!((both - Matrix6::identity() * 1e-8).amax() < 1e-20);
}

#[test]
fn where_the_ratio_is_stated_an_error_of_the_scale_factor_does_not_reach_d_i_and_d_s() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let nominal = Geometry::Skewed.triad(Slot::G1).expect("a slot");
    let (e, ratio) = (nominal.input() * 1.5, nominal.spin() * 5.0 + nominal.input() * 0.3);
    let (e_sd, ratio_sd) = (Vector3::repeat(1.5e-3), Vector3::repeat(1e-4));
    let stated = |e: Vector3<f64>, ratio: Vector3<f64>| GyroParameters {
        slot: Slot::G1,
        serial: Name::parse("A").expect("a name"),
        e,
        g: ratio * e.norm(),
        p: Vector3::zeros(),
        bias: 0.0,
        e_sd: Some(e_sd),
        g_sd: Some(ratio_sd * e.norm()),
        g_is_ratio: true,
    };
    let separated = |gyro: &GyroParameters| {
        let covariance = stated_covariance(gyro);
        separate(&Geometry::Skewed, gyro.slot, &gyro.e, &gyro.g, covariance.as_ref()).expect("separates").rigid
    };
    let said = separated(&stated(e, ratio)).sd().expect("both are stated");
    let mut noise = |sd: Vector3<f64>| normal_vector(&mut rng).component_mul(&sd);
    const DRAWS: usize = 20_000;
    let draws: Vec<[f64; 3]> = (0..DRAWS)
        .map(|_| {
            let drawn = separated(&stated(e + noise(e_sd), ratio + noise(ratio_sd)));
            [drawn.d_i, drawn.d_s, drawn.d_o]
        })
        .collect();
    for (i, said) in said.into_iter().enumerate() {
        let mean = draws.iter().map(|d| d[i]).sum::<f64>() / DRAWS as f64;
        let sd = (draws.iter().map(|d| (d[i] - mean).powi(2)).sum::<f64>() / DRAWS as f64).sqrt();
        assert!((sd / said - 1.0).abs() < 0.03, "coefficient {i}: {said} said, {sd} seen");
    }
    // Of the ratio's own error; that of |E|, a thousandth of 5 deg/(h g0), would be fifty times as large.
    assert!(said[1] < 4e-4, "{said:?}");
}

fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-range..range, -range..range, -range..range].prop_map(Vector3::from)
}

fn any_f64_vector() -> impl Strategy<Value = Vector3<f64>> {
    [prop::num::f64::ANY, prop::num::f64::ANY, prop::num::f64::ANY].prop_map(Vector3::from)
}

fn any_slot() -> impl Strategy<Value = Slot> {
    prop::sample::select(Slot::ALL.to_vec())
}

fn custom(slot: Slot, input: Vector3<f64>, spin: Vector3<f64>) -> Geometry {
    let mut triads = [None; 3];
    triads[slot.index()] = Some(Triad::from_stated_axes(input, spin).expect("orthonormal"));
    Geometry::Custom(triads)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn turning_the_body_axes_turns_the_axes_and_leaves_the_coefficients(
        slot in any_slot(), mounting in vector(0.3), turn in vector(3.0), g in vector(10.0)
    ) {
        let nominal = Geometry::Skewed.triad(slot).expect("every slot");
        let e = Rotation3::new(mounting) * nominal.input() * 1.4;
        let c = Rotation3::new(turn);
        let here = separate(&Geometry::Skewed, slot, &e, &g, None).expect("separates").rigid;
        let turned_geometry = custom(slot, c * nominal.input(), c * nominal.spin());
        let there = separate(&turned_geometry, slot, &(c * e), &(c * g), None).expect("separates").rigid;
        for (a, b) in [(here.d_i, there.d_i), (here.d_s, there.d_s), (here.d_o, there.d_o)] {
            prop_assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
        prop_assert!((c * here.spin_axis - there.spin_axis).amax() < 1e-12);
    }

    #[test]
    fn the_carried_triad_is_orthonormal_and_right_handed(slot in any_slot(), mounting in vector(0.8), g in vector(10.0)) {
        let nominal = Geometry::Skewed.triad(slot).expect("every slot");
        let e = Rotation3::new(mounting) * nominal.input();
        let got = separate(&Geometry::Skewed, slot, &e, &g, None).expect("separates");
        let m = Matrix3::from_columns(&[got.input_axis, got.rigid.spin_axis, got.rigid.output_axis]);
        prop_assert!((m.transpose() * m - Matrix3::identity()).amax() < 1e-13);
        prop_assert!((m.determinant() - 1.0).abs() < 1e-13);
        // The three coefficients hold all of G/|E|: nothing is lost in the separation.
        prop_assert!((m * Vector3::new(got.rigid.d_i, got.rigid.d_s, got.rigid.d_o) * got.scale_factor - g).amax() < 1e-12);
    }

    #[test]
    fn coefficients_follow_g_and_go_against_e(slot in any_slot(), mounting in vector(0.01), g in vector(10.0), power in -30i32..30) {
        let factor = 2.0_f64.powi(power);
        let e = Rotation3::new(mounting) * Geometry::Skewed.triad(slot).expect("every slot").input();
        let of = |e: Vector3<f64>, g: Vector3<f64>| separate(&Geometry::Skewed, slot, &e, &g, None).expect("separates");
        let (once, g_times, e_times) = (of(e, g), of(e, g * factor), of(e * factor, g));
        prop_assert_eq!(once.rigid.d_s * factor, g_times.rigid.d_s);
        prop_assert!((once.rigid.d_s / factor - e_times.rigid.d_s).abs() <= 1e-14 * (once.rigid.d_s / factor).abs().max(1e-14));
        prop_assert_eq!(once.published.expect("skewed").branch, e_times.published.expect("skewed").branch);
        prop_assert_eq!(once.alpha, e_times.alpha);
    }

    #[test]
    fn no_input_makes_it_panic_or_answer_what_is_not_finite(
        slot in any_slot(), e in any_f64_vector(), g in any_f64_vector(), e_sd in any_f64_vector(), g_sd in any_f64_vector()
    ) {
        let covariance = diagonal_covariance(Some(&e_sd), Some(&g_sd));
        for geometry in [Geometry::Skewed, Geometry::Orthogonal] {
            if let Ok(got) = separate(&geometry, slot, &e, &g, covariance.as_ref()) {
                let mut figures = vec![got.scale_factor, got.rigid.d_i, got.rigid.d_s, got.rigid.d_o, got.rigid.clocking()];
                figures.extend(got.alpha);
                figures.extend(got.rigid.sd().into_iter().flatten());
                figures.extend(got.rigid.clocking_sd());
                for published in [got.published, got.as_printed].into_iter().flatten() {
                    figures.extend([published.d_i, published.d_s, published.closure_rms]);
                    figures.extend(published.sd().into_iter().flatten());
                }
                prop_assert!(figures.iter().all(|x| x.is_finite()), "{figures:?}");
            }
        }
    }

    #[test]
    fn rows_of_any_magnitude_separate(slot in any_slot(), mounting in vector(0.01), e_power in -900i32..900, g in vector(10.0)) {
        let scale = 2.0_f64.powi(e_power);
        let e = Rotation3::new(mounting) * Geometry::Skewed.triad(slot).expect("every slot").input();
        let once = separate(&Geometry::Skewed, slot, &e, &g, None).expect("separates");
        let far = separate(&Geometry::Skewed, slot, &(e * scale), &(g * scale), None).expect("separates too");
        prop_assert!((once.rigid.d_i - far.rigid.d_i).abs() < 1e-12);
        prop_assert!((once.rigid.d_s - far.rigid.d_s).abs() < 1e-12);
    }
}

#[test]
fn rows_without_a_usable_direction_are_named() {
    let try_e = |e: [f64; 3]| {
        separate(&Geometry::Skewed, Slot::G1, &Vector3::from(e), &Vector3::x(), None).unwrap_err().to_string()
    };
    assert!(try_e([0.0; 3]).contains("zero_scale"));
    assert!(try_e([f64::NAN, 0.0, 1.0]).contains("quotient_not_finite"));
    assert!(try_e([f64::MAX; 3]).contains("quotient_not_finite"));
    assert!(try_e([-0.8473, 0.6011, -1.0367]).contains("points_away"));
    let bare = Geometry::Custom([None; 3]);
    let error = separate(&bare, Slot::G2, &Vector3::x(), &Vector3::x(), None).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("no_axes_for") && said.contains("G2"), "{said}");
}
