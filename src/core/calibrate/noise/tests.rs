//! Scales by hand, and tails from the tables of F and chi-square.

use super::*;

fn evidence(chi2: f64, dof: usize, repeats: (f64, usize)) -> Evidence {
    Evidence::of(chi2, dof, PureError { chi2: repeats.0, dof: repeats.1 })
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} is not {b}");
}

/// f^2, its degrees of freedom, and what a covariance is multiplied by.
fn figures(noise: &NoiseScale) -> (f64, f64, Option<f64>) {
    (noise.factor.expect("a scale").powi(2), noise.dof, noise.covariance_scale())
}

#[test]
fn repeats_of_all_gyros_are_pooled_unless_one_is_odd() {
    // 30 on 20 and 34 on 20, and residuals that are far larger: f^2 = (30 + 34 + 4)/(40 + 4).
    let alike = [evidence(900.0, 60, (30.0, 20)), evidence(950.0, 60, (34.0, 20))];
    for (noise, own) in noise(&alike, true).iter().zip([30.0, 34.0]) {
        assert_eq!((noise.source, noise.pure_error.chi2), (NoiseSource::SemAndRepeats, own));
        let (squared, dof, scale) = figures(noise);
        close(squared, 68.0 / 44.0);
        close(dof, 44.0);
        close(scale.expect("44 dof"), 68.0 / 42.0);
        close(noise.factor_sd.expect("44 dof"), (68.0 / 44.0_f64).sqrt() / 88.0_f64.sqrt());
    }
    // F of 20 and 20 exceeds 6.02 with a chance of 1e-4: ten times the others' spread is odd, both ways, and each
    // keeps its own.
    let odd = [evidence(9e3, 60, (200.0, 20)), evidence(9e3, 60, (20.0, 20))];
    let noises = noise(&odd, true);
    close(figures(&noises[0]).0, 204.0 / 24.0);
    close(figures(&noises[1]).0, 24.0 / 24.0);
    // Three times is not: the tables have 2.94 for 1 % and 3.66 for 0.3 %.
    let chance = noise(&[evidence(9e3, 60, (60.0, 20)), evidence(9e3, 60, (20.0, 20))], true);
    close(figures(&chance[0]).0, 84.0 / 44.0);
}

#[test]
fn residuals_that_scatter_no_more_than_repeats_join_them() {
    // Beyond the repeats 36 on 40, against (20 + 4)/(20 + 4): together (24 + 36)/(24 + 40).
    let agreeing = noise(&[evidence(56.0, 60, (20.0, 20))], true)[0];
    assert_eq!(agreeing.source, NoiseSource::SemRepeatsAndResiduals);
    let (squared, dof, scale) = figures(&agreeing);
    close(squared, 60.0 / 64.0);
    close(dof, 64.0);
    close(scale.expect("64 dof"), 60.0 / 62.0);
    // F of 40 and 24 exceeds 1.892 with a chance of 5 %.
    for (ratio, joins) in [(1.88, true), (1.91, false)] {
        let source = noise(&[evidence(20.0 + 40.0 * ratio, 60, (20.0, 20))], true)[0].source;
        assert_eq!(source == NoiseSource::SemRepeatsAndResiduals, joins, "{ratio}");
    }
    // Their chance is told against the repeats with what is stated.
    let p = |ratio: f64| {
        let evidence = evidence(20.0 + 40.0 * ratio, 60, (20.0, 20));
        noise(&[evidence], true)[0].p_value(&evidence).expect("both are there")
    };
    assert!((p(1.892) - 0.05).abs() < 1e-3, "{}", p(1.892));
    // Where nothing is left over beyond repeats, there is nothing to hold against them.
    let all = evidence(20.0, 20, (20.0, 20));
    assert_eq!(noise(&[all], true)[0].source, NoiseSource::SemAndRepeats);
    assert_eq!(noise(&[all], true)[0].p_value(&all), None);
}

#[test]
fn stated_errors_alone_hold_until_all_residuals_exceed_them() {
    // Chi-square of 20 exceeds 45.31 with a chance of 1e-3; the two gyros have ten each.
    for (chi2, source) in [(44.9, NoiseSource::Sem), (45.8, NoiseSource::SemAndResiduals)] {
        let both = [evidence(chi2 - 12.0, 10, (0.0, 0)), evidence(12.0, 10, (0.0, 0))];
        for (noise, own) in noise(&both, true).iter().zip(&both) {
            assert_eq!(noise.source, source);
            let (squared, dof, scale) = figures(noise);
            if source == NoiseSource::Sem {
                assert_eq!((squared, dof, scale, noise.factor_sd), (1.0, f64::INFINITY, Some(1.0), Some(0.0)));
            } else {
                close(squared, chi2 / 20.0);
                close(dof, 20.0);
                close(scale.expect("20 dof"), chi2 / 18.0);
            }
            assert_eq!(noise.p_value(own), chi2_tail(own.chi2, 10));
        }
    }
}

#[test]
fn without_stated_errors_each_gyro_speaks_for_itself() {
    // Residuals of 3 on 12; and 8 beyond repeats of 2 on 4, that is 1 and 1/2: no lack of fit.
    let noises = noise(&[evidence(3.0, 12, (0.0, 0)), evidence(10.0, 12, (2.0, 4))], false);
    for (noise, chi2) in noises.iter().zip([3.0, 10.0]) {
        assert_eq!(noise.source, NoiseSource::Residuals);
        close(figures(noise).0, chi2 / 12.0);
        close(figures(noise).2.expect("12 dof"), chi2 / 10.0);
    }
    // F of 10 and 10 exceeds 8.75 with a chance of 1e-3: then the repeats alone speak.
    for (ratio, source) in [(8.6, NoiseSource::Residuals), (8.9, NoiseSource::Repeats)] {
        let evidence = evidence(5.0 + 5.0 * ratio, 20, (5.0, 10));
        let noise = noise(&[evidence], false)[0];
        assert_eq!(noise.source, source);
        let (squared, dof) =
            if source == NoiseSource::Repeats { (0.5, 10.0) } else { ((5.0 + 5.0 * ratio) / 20.0, 20.0) };
        close(figures(&noise).0, squared);
        close(figures(&noise).1, dof);
        assert!((noise.p_value(&evidence).expect("both") - 1e-3).abs() < 2e-4);
    }
    let nothing = evidence(0.0, 0, (0.0, 0));
    let none = noise(&[nothing], false)[0];
    assert_eq!((none.source, none.factor, none.factor_sd), (NoiseSource::None, None, None));
    assert_eq!((none.covariance_scale(), none.p_value(&nothing)), (None, None));
    // A t of two degrees of freedom has no variance; of three it has three times its scale.
    let scale = |dof: usize| noise(&[evidence(dof as f64, dof, (0.0, 0))], false)[0].covariance_scale();
    assert_eq!((scale(2), scale(3)), (None, Some(3.0)));
}

#[test]
fn the_scatter_of_stated_errors_counts_up_to_a_quarter() {
    // sem sqrt(duration) is exp(-0.2 .. 0.2) over any durations: the standard deviation of -0.2, -0.1, 0, 0.1, 0.2 is
    // sqrt(0.1/4).
    let sems = |n: usize| {
        (0..n).map(|k| {
            let duration = 60.0 * (k + 1) as f64;
            ((0.1 * (k as f64 - 2.0)).exp() / duration.sqrt(), duration)
        })
    };
    close(sem_scatter(sems(5)), 0.025_f64.sqrt());
    assert_eq!(sem_scatter(sems(4)), 0.0, "four are too few");
    let scale = |scatter: f64| {
        let sem = noise(&[evidence(10.0, 10, (0.0, 0))], true)[0].with_scatter(scatter);
        sem.covariance_scale().expect("at their word")
    };
    close(scale(0.1), 1.04);
    close(scale(0.25), 1.25);
    close(scale(0.26), 1.0);
}

#[test]
fn errors_are_overstated_where_the_dwells_scatter_far_less() {
    // chi2 of 100 and mean 100 has a standard deviation of sqrt(200): below 50, of a normal's 1e-6 at 4.75
    // deviations, 41.
    assert_eq!(overstated(25.0, 100), Some(2.0));
    assert_eq!(overstated(60.0, 100), None, "chance has it seldom, but errors are usually wrong by so much");
    assert_eq!(overstated(3.0, 10), None, "chance alone");
    assert_eq!(overstated(0.0, 0), None);
    // Of very many dwells chance has neither, and half of the expected is the limit.
    assert!(overstated(499.0, 1000).is_some() && overstated(501.0, 1000).is_none());
}

#[test]
fn mean_squares_are_compared_as_the_table_of_f_has_it() {
    // Upper 5 % of F: 3.478 of 4 and 10.
    let tail = mean_squares_tail((4.0 * 3.478, 4.0), (10.0, 10.0)).expect("both are there");
    assert!((tail - 0.05).abs() < 1e-4, "{tail}");
    for (numerator, denominator) in [((1.0, 0.0), (1.0, 1.0)), ((1.0, 1.0), (1.0, 0.0)), ((1.0, 1.0), (0.0, 1.0))] {
        assert_eq!(mean_squares_tail(numerator, denominator), None);
    }
}

#[test]
fn what_the_model_leaves_out_is_in_the_variance_once_or_beside_it() {
    let share = |evidence: Evidence, has_sem: bool, is_other: bool| {
        let share = noise(&[evidence], has_sem)[0].share(&evidence, is_other);
        (share.statistical, share.discrepancy)
    };
    // Raised to the Birge ratio, f^2 = 400/100: a quarter of the variance is noise.
    assert_eq!(share(evidence(400.0, 100, (0.0, 0)), true, false), (0.25, Some(0.75)));
    assert_eq!(share(evidence(400.0, 100, (0.0, 0)), true, true), (1.0, Some(0.0)));
    assert_eq!(share(evidence(100.0, 100, (0.0, 0)), true, false), (1.0, Some(0.0)));
    // Repeats give f^2 = (20 + 4)/(20 + 4), and chi2/dof = 4: three times the variance beside it.
    assert_eq!(share(evidence(400.0, 100, (20.0, 20)), true, false), (1.0, Some(3.0)));
    // Residuals without anything to hold them against.
    assert_eq!(share(evidence(400.0, 100, (0.0, 0)), false, false), (1.0, None));
}
