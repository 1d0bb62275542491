//! Figures in words: an answer names some two hundred of them, and the standard library rounds each by exact arithmetic.

use std::fmt::{self, Display, Formatter};

/// A figure written with the decimals and the sign that the format asks for, as `{:+.5}` does for a number.
///
/// Rounded in floating point, |v| 10^p to the nearest whole number: off from exact rounding only where the digits
/// beyond the last lie within 1e-15 of a half.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decimal(pub f64);

const POWERS: [f64; 13] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12];
/// Whole numbers are exact in floating point up to here.
const EXACT: f64 = 9e15;

impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let decimals = f.precision().unwrap_or(0);
        let scaled = POWERS.get(decimals).map(|power| (self.0.abs() * power).round()).filter(|scaled| *scaled < EXACT);
        let Some(scaled) = scaled else { return Display::fmt(&self.0, f) };
        // Sixteen digits at most, the point and the sign.
        let mut text = [b'0'; 18];
        let (mut start, mut rest) = (text.len(), scaled as u64);
        for place in 0.. {
            if place > decimals && rest == 0 {
                break;
            }
            if place == decimals && decimals > 0 {
                start -= 1;
                text[start] = b'.';
            }
            start -= 1;
            text[start] = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
        if self.0.is_sign_negative() || f.sign_plus() {
            start -= 1;
            text[start] = if self.0.is_sign_negative() { b'-' } else { b'+' };
        }
        f.write_str(str::from_utf8(&text[start..]).expect("digits, a point and a sign are ASCII"))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn figures_read_as_the_standard_library_writes_them() {
        let large = [1e12, -4.2e15, 8.9e15, 9.1e15, 1e300, f64::INFINITY, f64::NAN];
        for value in
            [0.0, -0.0, 0.04, -0.04, 0.05001, 0.999_999_9, 9.995_1, 10.0, -123.456, 1e-9].into_iter().chain(large)
        {
            for decimals in 0..15 {
                assert_eq!(format!("{:.decimals$}", Decimal(value)), format!("{value:.decimals$}"));
                assert_eq!(format!("{:+.decimals$}", Decimal(value)), format!("{value:+.decimals$}"));
            }
        }
    }

    proptest! {
        #[test]
        fn any_figure_is_rounded_to_within_half_a_unit(value in -1e6_f64..1e6, decimals in 0_usize..=12) {
            prop_assume!(value.abs() * POWERS[decimals] < EXACT);
            let read: f64 = format!("{:+.decimals$}", Decimal(value)).parse().expect("a number");
            let half = 0.5 / POWERS[decimals];
            prop_assert!((read - value).abs() <= half * (1.0 + 1e-9) + 4.0 * f64::EPSILON * value.abs());
        }
    }
}
