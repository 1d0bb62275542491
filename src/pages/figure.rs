//! Figures as people write them: value and uncertainty to the same place.

use crate::core::judge::{Limit, Rule};

/// Digits of a figure whose uncertainty nobody has stated: a ten-thousandth of the usual budget of 1e-2 deg/(h g0),
/// as the paper's Table 5 prints.
const DRIFT_DECIMALS: usize = 6;

/// A drift coefficient, deg/(h g0).
pub(super) fn drift(value: f64, sd: Option<f64>) -> String {
    with_sd(value, sd, DRIFT_DECIMALS)
}

/// `4.1926 ± 0.0004`: two digits of the standard deviation, the value to the same place; `decimals` where none is
/// known.
pub(crate) fn with_sd(value: f64, sd: Option<f64>, decimals: usize) -> String {
    match sd.filter(|sd| *sd > 0.0 && sd.is_finite()) {
        // Nobody counts zeros behind the point.
        Some(sd) if (1e-5..1e7).contains(&value.abs().max(sd)) && sd >= 1e-8 => {
            let places = places(sd, 2);
            format!("{} ± {sd:.places$}", unsigned_zero(format!("{value:.places$}")))
        }
        Some(sd) => {
            // One power of ten for both, so that they can still be compared.
            let power = value.abs().max(sd).log10().floor();
            let (value, sd) = (value / 10_f64.powf(power), sd / 10_f64.powf(power));
            let places = places(sd, 2);
            format!("({} ± {sd:.places$})e{power}", unsigned_zero(format!("{value:.places$}")))
        }
        None => fixed(value, decimals),
    }
}

/// The same of a difference: with its sign.
pub(super) fn signed_drift(value: f64, sd: Option<f64>) -> String {
    let written = drift(value, sd);
    let size = written.trim_start_matches('(').split(' ').next().unwrap_or_default();
    let is_nothing = size.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if value > 0.0 && !is_nothing { format!("+{written}") } else { written }
}

/// Decimals of a figure that stands beside its standard deviation in a table; `decimals` where none is known.
pub(super) fn places_beside(sd: Option<f64>, decimals: usize) -> usize {
    sd.filter(|sd| (1e-8..1e7).contains(sd)).map_or(decimals, |sd| places(sd, 2))
}

/// A number of so many decimals; of those that round to nothing, three digits with an exponent.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let lost = value != 0.0 && value.abs() < 0.5 * 10_f64.powi(-(decimals as i32));
    if lost { format!("{value:.2e}") } else { unsigned_zero(text) }
}

/// A number of so many decimals with its sign.
pub(super) fn signed(value: f64, decimals: usize) -> String {
    unsigned_zero(format!("{value:+.decimals$}"))
}

/// What rounds to nothing has no sign.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix(['-', '+']) {
        Some(rest) if rest.bytes().all(|byte| matches!(byte, b'0' | b'.')) => rest.to_owned(),
        _ => text,
    }
}

/// Three significant digits, without an exponent where a person would not write one.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if (1e-4..1e6).contains(&size) {
        let places = places(size, 3);
        format!("{value:.places$}")
    } else {
        format!("{value:.2e}")
    }
}

/// A limit as it is set: what a level may shift by is this at least, and three standard deviations where those are more.
pub(super) fn limit(rule: Rule, limit: Limit) -> String {
    format!("{}{}", if rule == Rule::Shift { "≥ " } else { "" }, short(limit.value))
}

pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent != 0.0 && percent.abs() < 0.95 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

/// `52 % (48 – 55 %)`: a share with its interval, where it has one.
pub(super) fn share(share: f64, interval: Option<[f64; 2]>) -> String {
    match interval {
        Some([low, high]) if low < high => {
            format!("{} ({:.0} – {})", percent(share), 100.0 * low, percent(high))
        }
        _ => percent(share),
    }
}

/// Days that are over.
pub(super) fn whole_days(days: f64) -> String {
    format!("{:.0}", days.floor().max(0.0))
}

/// Decimals that show `digits` significant digits of `size`.
fn places(size: f64, digits: i32) -> usize {
    let decimals = |size: f64| (digits - 1 - size.log10().floor() as i32).max(0) as usize;
    // Rounding may carry into another digit: 0.00996 to two digits is 0.010.
    let first = decimals(size);
    let rounded = (size * 10_f64.powi(first as i32)).round() / 10_f64.powi(first as i32);
    decimals(rounded).min(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_and_uncertainty_end_at_the_same_place() {
        for (value, sd, text) in [
            (4.192621, Some(0.000404), "4.19262 ± 0.00040"),
            (-9.976657, Some(0.01), "-9.977 ± 0.010"),
            (1.5, Some(0.00996), "1.500 ± 0.010"),
            (12345.6, Some(37.0), "12346 ± 37"),
            (2.957643, None, "2.957643"),
            (2.0, Some(0.0), "2.000000"),
            (2.0, Some(f64::NAN), "2.000000"),
            (3e-9, None, "3.00e-9"),
            (0.0, None, "0.000000"),
            (-1e-7, Some(2.2e-4), "0.00000 ± 0.00022"),
            (2.05e-9, Some(2e-10), "(2.05 ± 0.20)e-9"),
            (-1.108e-6, Some(8.7e-8), "(-1.108 ± 0.087)e-6"),
            (0.0, Some(1.0e-6), "(0.0 ± 1.0)e-6"),
            (-3.0e-9, Some(2.6e-7), "(0.0 ± 2.6)e-7"),
            (4.19e-4, Some(3e-6), "0.0004190 ± 0.0000030"),
        ] {
            assert_eq!(drift(value, sd), text);
        }
    }

    #[test]
    fn a_difference_has_its_sign_unless_it_rounds_to_nothing() {
        for (value, sd, text) in [
            (0.0123, Some(4e-4), "+0.01230 ± 0.00040"),
            (-0.0123, Some(4e-4), "-0.01230 ± 0.00040"),
            (1e-7, Some(2.2e-4), "0.00000 ± 0.00022"),
            (-3.0e-9, Some(2.6e-7), "(0.0 ± 2.6)e-7"),
            (2.05e-9, Some(2e-10), "+(2.05 ± 0.20)e-9"),
        ] {
            assert_eq!(signed_drift(value, sd), text);
        }
    }

    #[test]
    fn figures_in_columns_end_where_their_uncertainty_does() {
        for (sd, places) in [(Some(0.0004), 5), (Some(0.00996), 3), (Some(12.0), 0), (Some(0.0), 6), (None, 6)] {
            assert_eq!(places_beside(sd, 6), places, "{sd:?}");
        }
    }

    #[test]
    fn short_figures_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (-1.2345, "-1.23"),
            (999.6, "1000"),
            (1e-7, "1.00e-7"),
            (2.5e9, "2.50e9"),
        ] {
            assert_eq!(short(value), text);
        }
        assert_eq!(share(0.52, Some([0.48, 0.553])), "52 % (48 – 55 %)");
        assert_eq!((share(1.0, None), share(1.0, Some([1.0, 1.0]))), ("100 %".into(), "100 %".into()));
        assert_eq!((percent(0.5), percent(0.004), percent(0.0)), ("50 %".into(), "0.4 %".into(), "0 %".into()));
    }
}
