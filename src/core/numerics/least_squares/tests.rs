use super::*;

fn assert_close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

/// y = b0 + b1 x at x = -1, 0, 1, 2 with unit weights. By hand: n = 4, mean x = 1/2, Sxx = 5, y = 1, 3, 4, 8:
/// mean y = 4, Sxy = sum (x - 1/2)(y - 4) = (-3/2)(-3) + (-1/2)(-1) + 0 + (3/2)(4) = 11, so b1 = 11/5, b0 = 29/10;
/// fitted 0.7, 2.9, 5.1, 7.3, residuals 0.3, 0.1, -1.1, 0.7, chi2 = 1.8;
/// var b1 = 1/5, var b0 = 1/4 + (1/4)/5 = 0.3, cov = -0.1; leverage 1/4 + (x - 1/2)^2/5 = 0.7, 0.3, 0.3, 0.7.
#[test]
fn a_line_through_four_points_is_fitted_as_by_hand() {
    let x = [-1.0, 0.0, 1.0, 2.0];
    let design = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
    let fit = Factor::new(design, &[1.0; 4]).fit(&DVector::from_row_slice(&[1.0, 3.0, 4.0, 8.0]));
    for (found, by_hand) in [
        (fit.estimate[0], 2.9),
        (fit.estimate[1], 2.2),
        (fit.covariance[(0, 0)], 0.3),
        (fit.covariance[(1, 1)], 0.2),
        (fit.covariance[(0, 1)], -0.1),
        (fit.chi2, 1.8),
    ] {
        assert_close(found, by_hand, 1e-14);
    }
    for (k, (residual, leverage)) in [(0.3, 0.7), (0.1, 0.3), (-1.1, 0.3), (0.7, 0.7)].into_iter().enumerate() {
        assert_close(fit.residuals[k], residual, 1e-14);
        assert_close(fit.leverage[k], leverage, 1e-14);
    }
    assert_eq!((fit.rank, fit.dof, fit.null_directions.ncols()), (2, 2, 0));
}

/// Two measurements of one constant, 1 with sd 1 and 4 with sd 2: (1 + 4/4)/(1 + 1/4) = 1.6, variance 1/1.25.
#[test]
fn weights_are_inverse_squares_of_the_standard_deviations() {
    let fit = Factor::new(DMatrix::from_element(2, 1, 1.0), &[1.0, 2.0]).fit(&DVector::from_row_slice(&[1.0, 4.0]));
    assert_close(fit.estimate[0], 1.6, 1e-15);
    assert_close(fit.covariance[(0, 0)], 0.8, 1e-15);
    assert_close(fit.chi2, 0.36 + 1.44, 1e-14);
}

/// Columns a, b, a + b: one short. The null direction is (1, 1, -1)/sqrt 3 and the fitted values are unique.
#[test]
fn rank_loss_is_a_value_with_its_null_direction() {
    let design = DMatrix::from_row_slice(4, 3, &[1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 1.0, -1.0, 0.0]);
    let factor = Factor::new(design.clone(), &[0.5; 4]);
    let truth = DVector::from_row_slice(&[2.0, -1.0, 0.5]);
    let fit = factor.fit(&(&design * &truth));
    assert_eq!((fit.rank, fit.dof), (2, 2));
    assert_close(
        fit.null_directions.column(0).dot(&DVector::from_row_slice(&[1.0, 1.0, -1.0])).abs(),
        3f64.sqrt(),
        1e-14,
    );
    assert!(fit.residuals.amax() < 1e-14);
    assert!(factor.determines(&DVector::from_row_slice(&[1.0, 0.0, 1.0])));
    assert!(!factor.determines(&DVector::from_row_slice(&[1.0, 0.0, 0.0])));
}

#[test]
fn fewer_rows_than_columns_fit_what_they_can() {
    let design = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 0.0, 1.0, -2.0, 0.0]);
    let factor = Factor::new(design, &[1.0; 2]);
    let fit = factor.fit(&DVector::from_row_slice(&[5.0, 1.0]));
    assert_eq!((fit.rank, fit.dof), (2, 0));
    assert_close(fit.estimate[0], 3.0, 1e-14);
    assert_close(fit.estimate[1], 1.0, 1e-14);
    assert_eq!(fit.estimate[2], 0.0);
    assert!(!factor.determines(&DVector::from_row_slice(&[0.0, 0.0, 1.0])));
}

/// Its coefficient would have a variance of 1e300 and more.
#[test]
fn a_column_of_next_to_nothing_determines_nothing() {
    for tiny in [1e-101, 1e-160, 5e-324] {
        let design = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { tiny * i as f64 });
        let factor = Factor::new(design, &[1.0; 4]);
        let fit = factor.fit(&DVector::from_row_slice(&[1.0, 2.0, 4.0, 5.0]));
        assert_eq!((fit.rank, fit.estimate[1]), (1, 0.0), "{tiny:e}");
        assert_close(fit.estimate[0], 3.0, 1e-14);
        assert!(fit.covariance.iter().all(|c| c.is_finite()), "{tiny:e}");
        assert!(!factor.determines(&DVector::from_row_slice(&[0.0, 1.0])), "{tiny:e}");
    }
}

#[test]
fn a_design_of_zeros_has_rank_zero() {
    let fit = Factor::new(DMatrix::zeros(3, 2), &[1.0; 3]).fit(&DVector::from_element(3, 1.0));
    assert_eq!((fit.rank, fit.dof, fit.null_directions.ncols()), (0, 3, 2));
    assert_close(fit.chi2, 3.0, 0.0);
}

/// The other route: column-pivoted QR of the plainly whitened design, no column scaling, no singular values.
#[expect(clippy::disallowed_methods, reason = "the other route, by the textbook; R is triangular and well conditioned")]
fn by_pivoted_qr(design: &DMatrix<f64>, sd: &[f64], y: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let mut whitened = design.clone();
    let mut rhs = y.clone();
    for (i, s) in sd.iter().enumerate() {
        whitened.row_mut(i).unscale_mut(*s);
        rhs[i] /= s;
    }
    let qr = whitened.col_piv_qr();
    let r = qr.r();
    let mut estimate = r.solve_upper_triangular(&(qr.q().transpose() * rhs)).expect("full rank");
    qr.p().inv_permute_rows(&mut estimate);
    let mut inverse = r.try_inverse().expect("full rank");
    qr.p().inv_permute_rows(&mut inverse);
    (estimate, &inverse * inverse.transpose())
}

proptest::proptest! {
    #[test]
    fn two_routes_agree_on_designs_of_full_rank(
        numbers in proptest::collection::vec(-1.0f64..1.0, 12 * 4),
        sd in proptest::collection::vec(0.1f64..10.0, 12),
        y in proptest::collection::vec(-5.0f64..5.0, 12),
        size in -3i32..=3,
    ) {
        let mut design = DMatrix::from_row_slice(12, 4, &numbers);
        design.column_mut(2).scale_mut(10f64.powi(size));
        let y = DVector::from_vec(y);
        let fit = Factor::new(design.clone(), &sd).fit(&y);
        proptest::prop_assume!(fit.rank == 4);
        let (estimate, covariance) = by_pivoted_qr(&design, &sd, &y);
        for i in 0..4 {
            let sd_i = covariance[(i, i)].sqrt();
            proptest::prop_assert!((fit.estimate[i] - estimate[i]).abs() < 1e-9 * sd_i.max(estimate[i].abs()));
            proptest::prop_assert!((fit.covariance[(i, i)] / covariance[(i, i)] - 1.0).abs() < 1e-8);
        }
        proptest::prop_assert!((fit.leverage.sum() - 4.0).abs() < 1e-10);
    }
}

#[test]
#[should_panic(expected = "finite numbers converge")]
fn a_design_that_is_not_finite_is_a_panic_and_not_an_endless_loop() {
    let mut design = DMatrix::from_fn(8, 4, |i, j| ((i * 4 + j) as f64).sin());
    design[(3, 2)] = f64::NAN;
    Factor::new(design, &[1.0; 8]);
}

/// Unit columns e1, e2 and e1 cos t + e3 sin t: the smallest singular value is tan(t/2) of the largest, and the
/// product of the Frobenius norms of R and its inverse is sqrt(6)/t, to first order in t.
#[test]
fn the_rank_is_the_same_by_either_way_and_so_is_the_estimate() {
    let factor = |t: f64| {
        let design =
            DMatrix::from_row_slice(4, 3, &[1.0, 0.0, t.cos(), 0.0, 1.0, 0.0, 0.0, 0.0, t.sin(), 0.0, 0.0, 0.0]);
        let r = design.clone().qr().r();
        (Factor::new(design, &[1.0; 4]), by_inverse(&r).is_some())
    };
    for (t, rank, inverted) in [(1.9e-4, 2, false), (2.2e-4, 3, false), (3e-4, 3, true), (0.5, 3, true)] {
        let (factor, by_inverse) = factor(t);
        assert_eq!((factor.rank(), by_inverse), (rank, inverted), "{t}");
        if rank == 3 {
            // y = 2 e1 - e2 + 3 e3 + 5 e4: the last two coefficients follow from e2 and e3 alone.
            let fit = factor.fit(&DVector::from_row_slice(&[2.0, -1.0, 3.0, 5.0]));
            for (found, by_hand) in [(0, 2.0 - 3.0 / t.tan()), (1, -1.0), (2, 3.0 / t.sin())] {
                let found = fit.estimate[found];
                assert!((found - by_hand).abs() <= 1e-10 * by_hand.abs(), "{t}: {found} is not {by_hand}");
            }
            let variance = fit.covariance[(2, 2)] * t.sin().powi(2);
            assert!((variance - 1.0).abs() < 1e-8, "{t}: {variance}");
            assert_close(fit.chi2, 25.0, 1e-9);
        }
    }
}
