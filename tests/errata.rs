//! Each slip of the paper's print, proved from what else the paper says: orthogonality, its own tables, its units.
//! (Cheng et al., J. Harbin Inst. Tech. 47(1), 2015. The list is in `docs/method.md`.)

use gyrowatch::core::model::Terms;
use gyrowatch::core::mounting::{Geometry, Slot, Triad};
use gyrowatch::core::separate::{Branch, Separation, separate};
use gyrowatch::core::units::EARTH_RATE_DEG_H;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

const HALF_CONE_DEG: f64 = 54.7356;
const SQRT3: f64 = 1.732_050_807_568_877_2;

fn skewed(slot: Slot) -> Triad {
    Geometry::Skewed.triad(slot).expect("the skewed geometry has all slots")
}

fn cos_deg(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

fn angles_deg(v: &Vector3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|r| v[r].acos().to_degrees())
}

/// The I-S pair of a slot turned by `degrees` about its output axis.
fn turned_about_output(slot: Slot, degrees: f64) -> (Vector3<f64>, Vector3<f64>) {
    let triad = skewed(slot);
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(triad.output()), degrees.to_radians());
    (turn * triad.input(), turn * triad.spin())
}

/// (change of the S angle)/(change of the I angle) to each body axis, for such a turn; signed.
fn ratios(slot: Slot, degrees: f64) -> [f64; 3] {
    let triad = skewed(slot);
    let (input, spin) = turned_about_output(slot, degrees);
    let (i0, s0) = (angles_deg(&triad.input()), angles_deg(&triad.spin()));
    let (i, s) = (angles_deg(&input), angles_deg(&spin));
    [0, 1, 2].map(|r| (s[r] - s0[r]) / (i[r] - i0[r]))
}

fn of_pair(slot: Slot, input: &Vector3<f64>, g: Vector3<f64>) -> Separation {
    separate(&Geometry::Skewed, slot, input, &g, None).expect("a unit row separates")
}

#[test]
fn the_scalar_equation_of_g2_needs_the_minus_sign_of_the_matrix() {
    let (c, s) = (cos_deg(HALF_CONE_DEG), HALF_CONE_DEG.to_radians().sin());
    let p = |g2_z: f64| Matrix3::new(c, -0.5 * s, SQRT3 / 2.0 * s, c, -0.5 * s, g2_z * s, c, s, 0.0);
    let orthogonality_error = |p: Matrix3<f64>| (p * p.transpose() - Matrix3::identity()).amax();
    assert!(orthogonality_error(p(-SQRT3 / 2.0)) < 1e-6, "the right sign");
    assert!(orthogonality_error(p(SQRT3 / 2.0)) > 0.9, "the printed sign makes G1 and G2 the same gyro");
    let g2 = skewed(Slot::G2).input();
    assert!((g2 - Vector3::new(c, -0.5 * s, -SQRT3 / 2.0 * s)).amax() < 1e-6);
}

#[test]
fn equations_3_and_4_need_arccos_and_cos_120() {
    let s = HALF_CONE_DEG.to_radians().sin();
    let (z, y) = ([cos_deg(30.0) * s, cos_deg(150.0) * s], cos_deg(120.0) * s);
    assert!((z[0].acos().to_degrees() - 45.0).abs() < 1e-4);
    assert!((z[1].acos().to_degrees() - 135.0).abs() < 1e-4, "Table 1 has 135");
    assert!((z[1].asin().to_degrees() - 135.0).abs() > 100.0, "the printed arcsin gives -45");
    assert!((y.acos().to_degrees() - 114.095).abs() < 2e-4, "Table 1 has 114.095");
    assert!((z[1].acos().to_degrees() - 114.095).abs() > 20.0, "the printed cos 150 gives 135");
}

#[test]
fn d_i_and_d_s_multiply_specific_force_for_a_gyro_at_rest_drifts_by_them() {
    // On a table at rest the angular acceleration is zero; a drift that followed it would be zero too.
    let mut row = Vec::new();
    let up = Vector3::new(0.0, 0.0, 1.0);
    Terms::MODEL_6.push_row(&up, &Vector3::zeros(), &mut row);
    let (e, g) = (skewed(Slot::G3).input(), skewed(Slot::G3).spin() * -6.75);
    let parameters: Vec<f64> = [&[0.0][..], g.as_slice(), &[0.0; 3], e.as_slice()].concat();
    let drift: f64 = row.iter().zip(&parameters).map(|(x, p)| x * p).sum();
    assert!((drift - of_pair(Slot::G3, &e, g).rigid.d_s * up.dot(&skewed(Slot::G3).spin())).abs() < 1e-12);
    assert!(drift.abs() > 6.0);
}

#[test]
fn the_nine_g_are_the_drift_coefficients_and_the_nine_e_only_divide() {
    let (e, g) = (skewed(Slot::G1).input() * 1.4676, Vector3::new(2.4210, 4.0554, 6.5179));
    let once = separate(&Geometry::Skewed, Slot::G1, &e, &g, None).unwrap().rigid;
    let g_twice = separate(&Geometry::Skewed, Slot::G1, &e, &(g * 2.0), None).unwrap().rigid;
    let e_twice = separate(&Geometry::Skewed, Slot::G1, &(e * 2.0), &g, None).unwrap().rigid;
    assert!((g_twice.d_i - 2.0 * once.d_i).abs() < 1e-12);
    assert!((e_twice.d_i - 0.5 * once.d_i).abs() < 1e-12);
}

#[test]
fn table_3_is_in_pulse_per_arcsec() {
    // A calibration that resolves E to four digits needs many pulses of Earth rate a second, not one in three minutes.
    let pulses_per_s = |pulse_per_arcsec: f64| pulse_per_arcsec * EARTH_RATE_DEG_H;
    assert!((pulses_per_s(1.4676) - 22.07).abs() < 0.01);
    assert!(pulses_per_s(1.4676 / 3600.0) < 0.01, "read as the printed pulse/deg");
}

#[test]
fn the_constants_are_ratios_of_angles_for_one_turn_of_five_degrees() {
    let near = |got: f64, want: f64| assert!((got - want).abs() < 5e-4, "{got} instead of {want}");
    let g1 = ratios(Slot::G1, -5.0);
    near(g1[0], -18.7265);
    near(g1[1], 0.8860);
    near(g1[2], -1.1102);
    let g3 = ratios(Slot::G3, 5.0);
    near(g3[0], 18.7265);
    near(g3[1], 13.2848);
    near(g3[2], -1.0);
    // The x ratio is no constant: S is perpendicular to X, so the I angle moves with the square of the turn there.
    for (turn, want) in [(1.0, 93.6), (0.1, 936.0)] {
        let x = ratios(Slot::G3, turn)[0];
        assert!((x / want - 1.0).abs() < 2e-3, "at {turn} deg the ratio is {x}");
    }
}

#[test]
fn the_z_row_of_equation_10_needs_the_minus_sign() {
    // The I-S pair of G2 turned so that (10) applies: all of its rows must then name one direction, the turned S.
    let (input, spin) = turned_about_output(Slot::G2, -5.0);
    let separation = of_pair(Slot::G2, &input, spin);
    let published = separation.published.unwrap();
    assert_eq!(published.branch, Branch::Eq10);
    let d: Vec<f64> = angles_deg(&input).iter().zip([54.7356, 114.095, 135.0]).map(|(a, b)| a - b).collect();
    let s = |sign: f64| {
        let angles = [90.0 - d[0] * 18.7292, 30.0 + d[1] * 0.8861, 120.0 + sign * d[2] * 1.1103];
        Vector3::from(angles.map(cos_deg))
    };
    assert!(s(-1.0).dot(&input).abs() < 1e-3, "I.S = 0 with the sign turned: {}", s(-1.0).dot(&input));
    assert!(s(1.0).dot(&input).abs() > 0.05, "and not as printed: {}", s(1.0).dot(&input));
    assert!((published.d_s - 1.0).abs() < 1e-3 && published.d_i.abs() < 1e-3);
    assert!((separation.as_printed.unwrap().d_i - published.d_i).abs() > 0.05);
}

#[test]
fn equation_12_needs_its_own_axes_angles_and_s_at_zero_degrees() {
    // Over the full turn of 5 degrees only: (12)'s condition asks d_x and d_y for the same sign, which to first order
    // cos^2 + cos^2 + cos^2 = 1 forbids.
    let (input, spin) = turned_about_output(Slot::G3, 5.0);
    let separation = of_pair(Slot::G3, &input, spin);
    let published = separation.published.unwrap();
    assert_eq!(published.branch, Branch::Eq12);
    assert!((published.d_s - 1.0).abs() < 1e-3, "{published:?}");
    assert!(published.d_i.abs() < 1e-3 && published.closure_rms < 1e-3, "{published:?}");
    let d: Vec<f64> = angles_deg(&input).iter().zip([54.7356, 35.2644, 90.0]).map(|(a, b)| a - b).collect();
    let own_axes = Vector3::from([90.0 - d[0] * 18.7292, 90.0 - d[1] * 13.2839, 180.0 - d[2]].map(cos_deg));
    assert!((own_axes + spin).amax() < 1e-3, "with each row's own angle, the printed form is -S: {own_axes}");
    assert!((skewed(Slot::G3).spin() - Vector3::z()).amax() < 1e-15, "Table 2 and (13) have S at 0 deg from Z");
    let printed = separation.as_printed.unwrap();
    assert!(printed.closure_rms > 0.1, "as printed, with alpha_x in all rows, no D_I and D_S fit: {printed:?}");
}

#[test]
fn the_untilted_branches_are_table_2() {
    for (slot, branch) in [(Slot::G1, Branch::Eq9), (Slot::G2, Branch::Eq11), (Slot::G3, Branch::Eq13)] {
        // A turn about S leaves S where Table 2 has it, and moves I so that the tilted condition does not hold.
        let triad = skewed(slot);
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(triad.spin()), 0.01);
        let input = turn * triad.input();
        let separation = of_pair(slot, &input, input * 2.0 - triad.spin() * 3.0);
        let published = separation.published.unwrap();
        assert_eq!(published.branch, branch);
        assert!((published.d_i - 2.0).abs() < 1e-12 && (published.d_s + 3.0).abs() < 1e-12, "{published:?}");
    }
}

/// Tables 3 and 4, and the separation column of Table 5.
const E: [[f64; 3]; 3] = [[0.8473, -0.6011, 1.0367], [0.8478, -0.6000, -1.0381], [0.8533, 1.2062, -0.0008]];
const G: [[f64; 3]; 3] = [[2.4210, 4.0554, 6.5179], [0.8634, 4.6419, -3.4081], [0.9901, 1.4495, -9.9775]];
const TABLE_5: [[f64; 2]; 3] = [[4.192621, 5.771440], [1.584334, 6.131210], [1.686447, -9.976657]];

/// S by every equation that could be meant for the slot: tilted, untilted, tilted as printed, and the rigid S^.
fn spin_axes(slot: Slot, input: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let (i, s) = (angles_deg(&skewed(slot).input()), angles_deg(&skewed(slot).spin()));
    let d: Vec<f64> = angles_deg(input).iter().zip(i).map(|(a, b)| a - b).collect();
    let gains = match slot {
        Slot::G1 => [[-18.7292, 0.8861, -1.1102], [0.0; 3], [-18.7292, 0.8861, -1.1102]],
        Slot::G2 => [[-18.7292, 0.8861, -1.1103], [0.0; 3], [-18.7292, 0.8861, 1.1103]],
        Slot::G3 => [[18.7292, 13.2839, 1.0], [0.0; 3], [-18.7292, -13.2839, -1.0]],
    };
    let tilted = gains.map(|gain| Vector3::from_fn(|r, _| cos_deg(s[r] + gain[r] * d[r])));
    tilted.into_iter().chain([of_pair(slot, input, Vector3::x()).rigid.spin_axis]).collect()
}

/// D_I and D_S by least squares over the rows that are kept.
fn solved(input: &Vector3<f64>, spin: &Vector3<f64>, y: &Vector3<f64>, kept: &Vector3<f64>) -> [f64; 2] {
    let (i, s, y) = (input.component_mul(kept), spin.component_mul(kept), y.component_mul(kept));
    let determinant = i.dot(&i) * s.dot(&s) - i.dot(&s).powi(2);
    [
        (s.dot(&s) * i.dot(&y) - i.dot(&s) * s.dot(&y)) / determinant,
        (i.dot(&i) * s.dot(&y) - i.dot(&s) * i.dot(&y)) / determinant,
    ]
}

#[test]
fn table_5_does_not_follow_from_tables_3_and_4_in_any_reading() {
    let permutations = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs = (0..8).map(|bits| Vector3::from_fn(|r, _| if bits >> r & 1 == 1 { -1.0 } else { 1.0 }));
    let signs: Vec<Vector3<f64>> = signs.collect();
    let kept = [[1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]].map(Vector3::from);
    let (mut readings, mut nearest) = (0, f64::INFINITY);
    for slot in Slot::ALL {
        let e = Vector3::from(E[slot.index()]);
        let input = e.normalize();
        for (g, unit) in G.iter().flat_map(|g| [1.0 / e.norm(), 1.0, e.norm()].map(|unit| (g, unit))) {
            for (order, sign) in permutations.iter().flat_map(|order| signs.iter().map(move |sign| (order, sign))) {
                let y = Vector3::from_fn(|r, _| g[order[r]] * sign[r] * unit);
                for (spin, kept) in spin_axes(slot, &input).iter().flat_map(|s| kept.iter().map(move |k| (s, k))) {
                    let d = solved(&input, spin, &y, kept);
                    let want = TABLE_5[slot.index()];
                    nearest = nearest.min((d[0] - want[0]).abs().max((d[1] - want[1]).abs()));
                    readings += 1;
                }
            }
        }
    }
    println!("{readings} readings, the nearest misses a gyro of Table 5 by {nearest:.4} deg/(h g0)");
    assert_eq!(readings, 20_736);
    assert!(nearest > 1e-2, "a reading was found: {nearest}");
}

#[test]
fn table_5_implies_another_g_than_table_4() {
    let implied_minus_printed = |divided: bool| {
        let mut largest = 0.0_f64;
        for slot in Slot::ALL {
            let e = Vector3::from(E[slot.index()]);
            let input = e.normalize();
            let spin = spin_axes(slot, &input)[usize::from(slot == Slot::G3)]; // (8), (10), (13)
            let [d_i, d_s] = TABLE_5[slot.index()];
            let scale = if divided { 1.0 } else { e.norm() };
            let implied = (input * d_i + spin * d_s) * scale;
            largest = largest.max((implied - Vector3::from(G[slot.index()])).amax());
        }
        largest
    };
    // Even read as already divided by |E|, Table 4 is 0.78 off; read as its unit says, 4.8.
    assert!((implied_minus_printed(true) - 0.78).abs() < 0.005, "{}", implied_minus_printed(true));
    assert!((implied_minus_printed(false) - 4.76).abs() < 0.02, "{}", implied_minus_printed(false));
}

#[test]
fn the_angles_of_equation_14_are_not_those_of_table_3() {
    let printed = [[54.7406, 114.1869, 45.0613], [54.7415, 114.1241, 134.9941], [54.7271, 35.2787, 90.0377]];
    let mut largest = 0.0_f64;
    for ((angles, e), sum) in printed.iter().zip(E).zip([1.00005, 1.00018, 0.99990]) {
        let squares: f64 = angles.iter().map(|&a| cos_deg(a).powi(2)).sum();
        assert!((squares - sum).abs() < 6e-6, "{squares}");
        let measured = angles_deg(&Vector3::from(e).normalize());
        largest = angles.iter().zip(measured).fold(largest, |largest, (a, b)| largest.max((a - b).abs()));
    }
    assert!((0.009..0.01).contains(&largest), "{largest}");
}

/// Singular values of a design that are more than rounding.
fn rank(columns: &[fn(f64, f64, f64) -> f64]) -> usize {
    let steps = (0..40).map(|k| (f64::from(k) * 0.7).sin_cos());
    let rows: Vec<f64> = steps
        .enumerate()
        .flat_map(|(k, (s, c))| {
            let (i, spin, o) = (s * (k as f64 * 0.31).cos(), c, s * (k as f64 * 0.31).sin() * 1.3);
            columns.iter().map(move |column| column(i, spin, o)).collect::<Vec<_>>()
        })
        .collect();
    nalgebra::DMatrix::from_row_slice(40, columns.len(), &rows).rank(1e-9)
}

#[test]
fn d_si_of_equation_5_multiplies_a_product_and_not_the_square_of_d_ss() {
    let common: [fn(f64, f64, f64) -> f64; 7] =
        [|_, _, _| 1.0, |i, _, _| i, |_, s, _| s, |i, _, o| i * o, |_, s, o| o * s, |i, _, _| i * i, |_, s, _| s * s];
    let with = |d_si: fn(f64, f64, f64) -> f64| rank(&[&common[..], &[d_si]].concat());
    assert_eq!(with(|i, s, _| s * i), 8, "as in the equation");
    assert_eq!(with(|_, s, _| s * s), 7, "as the words below it have it");
}
