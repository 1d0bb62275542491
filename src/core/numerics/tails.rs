//! Tails of the distributions that sums of squares are held against, for every number that a sum may be.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::beta::checked_beta_reg;
use statrs::function::gamma::checked_gamma_ur;

use super::bisection::bisect;
use super::normal::normal_cdf;

/// P(chi-square of `dof` > `chi2`); none without degrees of freedom.
pub fn chi2_tail(chi2: f64, dof: usize) -> Option<f64> {
    (dof > 0).then(|| match chi2 {
        chi2 if chi2.is_infinite() => 0.0,
        chi2 if chi2 > 0.0 => checked_gamma_ur(0.5 * dof as f64, 0.5 * chi2).unwrap_or(1.0),
        _ => 1.0,
    })
}

/// The value that chi-square of `dof` is below with probability `p`.
pub fn chi2_quantile(p: f64, dof: f64) -> f64 {
    ChiSquared::new(dof).map_or(dof, |chi2| chi2.inverse_cdf(p))
}

/// P(F of `numerator` and `denominator` degrees of freedom > `f`) = I_x(d2/2, d1/2), x = d2/(d2 + d1 f) (Abramowitz
/// and Stegun 26.6.2). That form loses nothing where the probability is small, and holds up to an `f` beyond all
/// numbers.
pub fn f_tail(f: f64, numerator: f64, denominator: f64) -> f64 {
    let x = denominator / (denominator + numerator * f.max(0.0));
    checked_beta_reg(0.5 * denominator, 0.5 * numerator, x).unwrap_or(1.0)
}

/// P(t of `dof` degrees of freedom < `t`); normal where they are infinite.
pub fn t_cdf(t: f64, dof: f64) -> f64 {
    if dof.is_infinite() {
        return normal_cdf(t);
    }
    let beyond = 0.5 * f_tail(t * t, 1.0, dof);
    if t < 0.0 { beyond } else { 1.0 - beyond }
}

/// P of a sum of `count` squares as large over a variance that `dof` degrees of freedom tell: F, chi-square for one
/// that is known.
pub fn squares_tail(squares: f64, count: usize, dof: f64) -> f64 {
    if count == 0 {
        return 1.0;
    }
    if dof.is_finite() {
        f_tail(squares / count as f64, count as f64, dof)
    } else {
        chi2_tail(squares, count).unwrap_or(1.0)
    }
}

/// The sum of squares that [`squares_tail`] gives the probability `p`, by bisection of its logarithm.
pub fn squares_quantile(p: f64, count: usize, dof: f64) -> f64 {
    bisect(-60.0, 60.0, 100, |log| squares_tail(log.exp(), count, dof) > p).0.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_quantiles_have_their_probabilities() {
        // Tables of Abramowitz and Stegun: 26.8 and 26.9.
        for (chi2, dof, p) in [(3.84146, 1, 0.05), (18.30704, 10, 0.05), (135.80672, 100, 0.01)] {
            assert!((chi2_tail(chi2, dof).unwrap() / p - 1.0).abs() < 1e-4, "{chi2} {dof}");
        }
        for (f, d1, d2, p) in [(161.4476, 1.0, 1.0, 0.05), (3.325835, 5.0, 10.0, 0.05), (4.849147, 10.0, 10.0, 0.01)] {
            assert!((f_tail(f, d1, d2) / p - 1.0).abs() < 1e-4, "{f} {d1} {d2}");
        }
    }

    #[test]
    fn students_t_is_that_of_the_tables() {
        // Abramowitz and Stegun 26.10.
        for (t, dof, p) in [(2.228139, 10.0, 0.975), (-6.313752, 1.0, 0.05), (1.644854, f64::INFINITY, 0.95)] {
            assert!((t_cdf(t, dof) - p).abs() < 1e-6, "{t} {dof}");
        }
    }

    #[test]
    fn quantiles_of_sums_of_squares_are_those_of_the_tables() {
        // 10 F of 10 and 10 degrees of freedom at 1 %; chi-square of 100 at 1 % (Abramowitz and Stegun 26.8, 26.9).
        for (p, count, dof, squares) in [(0.01, 10, 10.0, 48.49147), (0.01, 100, f64::INFINITY, 135.80672)] {
            assert!((squares_quantile(p, count, dof) / squares - 1.0).abs() < 1e-4, "{count} {dof}");
        }
    }

    #[test]
    fn a_tail_far_out_is_small_and_not_nothing() {
        // With two degrees of freedom above, P = (1 + 2 f/d2)^(-d2/2).
        for f in [1e3, 1e6, 1e12] {
            let exact = (1.0_f64 + 2.0 * f / 20.0).powi(-10);
            assert!((f_tail(f, 2.0, 20.0) / exact - 1.0).abs() < 1e-9, "{f}");
        }
        assert!((chi2_tail(600.0, 2).unwrap() / (-300.0_f64).exp() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn no_sum_of_squares_is_too_large_or_too_small() {
        for f in [0.0, 1e-320, 1e300, 1.7e308, f64::INFINITY, -1.0] {
            for (d1, d2) in [(1.0, 1.0), (12.0, 60.0), (1e3, 2.0)] {
                let p = f_tail(f, d1, d2);
                assert!((0.0..=1.0).contains(&p), "{f} {d1} {d2}: {p}");
            }
            let p = chi2_tail(f, 5).unwrap();
            assert!((0.0..=1.0).contains(&p), "{f}: {p}");
        }
        assert_eq!((f_tail(f64::INFINITY, 3.0, 7.0), chi2_tail(f64::INFINITY, 7)), (0.0, Some(0.0)));
    }
}
