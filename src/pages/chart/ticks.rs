//! Round figures and dates along an axis.

use crate::core::time::{UtcDate, UtcMicros};

/// A figure beside an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Figures {
    pub at: f64,
    /// Whether it was asked for by its value.
    pub named: bool,
}

/// Round numbers within, about so many, and their decimals: steps of 1, 2 or 5 times a power of ten.
pub(super) fn round_steps((a, b): (f64, f64), about: f64) -> (Vec<f64>, usize) {
    let raw = (b - a) / about;
    let power = 10_f64.powf(raw.log10().floor());
    let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= raw).unwrap_or(10.0);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (a / step).ceil() as i64;
    let last = (b / step).floor() as i64;
    // Minus nothing is nothing.
    ((first..=last).map(|k| k as f64 * step + 0.0).collect(), decimals)
}

/// The figures of an axis that is `height` pixels long: those that are named come first, round ones where they stand
/// at least `apart` pixels from every other. The decimals show both.
pub(super) fn figures_apart(ends: (f64, f64), height: f64, apart: f64, named: &[f64]) -> (Vec<Figures>, usize) {
    let (round, decimals) = round_steps(ends, 6.0);
    let pixels = |value: f64| (value - ends.0) / (ends.1 - ends.0) * height;
    let mut shown: Vec<Figures> = Vec::new();
    let named =
        named.iter().filter(|value| (ends.0..=ends.1).contains(value)).map(|at| Figures { at: *at, named: true });
    for figure in named.chain(round.into_iter().map(|at| Figures { at, named: false })) {
        if shown.iter().all(|other| (pixels(other.at) - pixels(figure.at)).abs() >= apart) {
            shown.push(figure);
        }
    }
    let needed =
        |value: f64| (0..9).find(|d| (value * 10_f64.powi(*d) - (value * 10_f64.powi(*d)).round()).abs() < 1e-6);
    let of_named = shown.iter().filter(|figure| figure.named).filter_map(|figure| needed(figure.at)).max().unwrap_or(0);
    (shown, decimals.max(of_named as usize))
}

/// Days and months between two dates that a picture shows, the closest first.
const DAYS: [i64; 4] = [1, 2, 5, 10];
const MONTHS: [i64; 8] = [1, 2, 3, 6, 12, 24, 60, 120];
const MOST_DATES: i64 = 6;

/// Milliseconds and words: the first of a month or of a year, or days where a picture shows less than that.
pub(super) fn dates((from, until): (f64, f64)) -> Vec<(f64, String)> {
    let at = |ms: f64| UtcMicros((ms as i64).saturating_mul(1000));
    let ms = |at: UtcMicros| at.0.div_euclid(1000) as f64;
    let days = (until - from) / 864e5;
    if days < 0.5 {
        let steps = 4;
        let one = |k: i32| from + (until - from) * (f64::from(k) + 0.5) / f64::from(steps);
        return (0..steps).map(one).map(|t| (t, clock(t))).collect();
    }
    if let Some(step) = DAYS.into_iter().find(|step| days / (*step as f64) <= MOST_DATES as f64) {
        let first = (from / 864e5).ceil() as i64;
        let all = (first..).take_while(|day| *day as f64 * 864e5 <= until).filter(|day| day % step == 0);
        return all.map(|day| (day as f64 * 864e5, at(day as f64 * 864e5).date().to_string())).collect();
    }
    let months = |date: UtcDate| date.year * 12 + i64::from(date.month) - 1;
    let (first, last) = (months(at(from).date()), months(at(until).date()));
    let step = MONTHS.into_iter().find(|step| (last - first) / step < MOST_DATES).unwrap_or(240);
    let start = |month: i64| UtcDate { year: month.div_euclid(12), month: (month.rem_euclid(12) + 1) as u8, day: 1 };
    let all = (first..=last).filter(|month| month % step == 0).map(start);
    let label = |date: &UtcDate| {
        if step % 12 == 0 { date.year.to_string() } else { format!("{}-{:02}", date.year, date.month) }
    };
    all.map(|date| (ms(date.midnight()), label(&date))).filter(|(t, _)| (from..=until).contains(t)).collect()
}

fn clock(t: f64) -> String {
    let minutes = (t / 60_000.0).floor() as i64;
    format!("{:02}:{:02} UTC", minutes.div_euclid(60).rem_euclid(24), minutes.rem_euclid(60))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_within() {
        let (steps, decimals) = round_steps((-0.013, 0.027), 4.0);
        assert_eq!(
            steps.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>(),
            ["-0.01", "0.00", "0.01", "0.02"]
        );
        assert_eq!(round_steps((0.0, 40.0), 4.0), (vec![0.0, 10.0, 20.0, 30.0, 40.0], 0));
    }

    #[test]
    fn named_figures_stand_and_round_ones_keep_away_from_them() {
        let (shown, decimals) = figures_apart((-0.0115, 0.0115), 170.0, 12.0, &[0.01, -0.01, 0.0]);
        let at = |named: bool| {
            shown.iter().filter(|figure| figure.named == named).map(|figure| figure.at).collect::<Vec<_>>()
        };
        assert_eq!((at(true), decimals), (vec![0.01, -0.01, 0.0], 3));
        assert!(at(false).iter().any(|at| (at - 0.005).abs() < 1e-12), "{shown:?}");
        // Ten budgets on either side: the three would lie over one another.
        let (shown, _) = figures_apart((-0.1, 0.1), 170.0, 12.0, &[0.01, -0.01, 0.0]);
        assert_eq!(shown.iter().filter(|figure| figure.named).count(), 2, "{shown:?}");
        let pixels: Vec<f64> = shown.iter().map(|figure| figure.at * 850.0).collect();
        for (k, a) in pixels.iter().enumerate() {
            assert!(pixels[..k].iter().all(|b| (a - b).abs() >= 12.0), "{shown:?}");
        }
    }

    #[test]
    fn dates_are_first_days_and_few() {
        let ms = |year, month, day| UtcDate { year, month, day }.midnight().0 as f64 / 1000.0;
        let of = |from, until| dates((from, until)).into_iter().map(|(_, label)| label).collect::<Vec<_>>();
        assert_eq!(of(ms(2024, 11, 15), ms(2026, 12, 1)), ["2025-01", "2025-07", "2026-01", "2026-07"]);
        assert_eq!(of(ms(2010, 3, 1), ms(2026, 12, 1)), ["2015", "2020", "2025"]);
        assert_eq!(
            of(ms(2026, 2, 25), ms(2026, 3, 3)),
            ["2026-02-25", "2026-02-26", "2026-02-27", "2026-02-28", "2026-03-01", "2026-03-02", "2026-03-03"]
        );
        assert_eq!(dates((ms(2025, 7, 1), ms(2026, 7, 2)))[0], (ms(2025, 7, 1), "2025-07".to_owned()));
        assert_eq!(of(ms(2026, 3, 1), ms(2026, 3, 1) + 36e5)[0], "00:07 UTC");
    }
}
