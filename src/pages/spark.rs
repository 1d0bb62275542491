//! A gyro's last values as a line the height of a word.

use super::prelude::*;
use crate::core::time::Span;

const WIDTH: f64 = 56.0;
const HEIGHT: f64 = 22.0;
const EDGE: f64 = 3.0;

/// The values within `span`, which is the same for every line, the budget about the level as a band, the newest
/// marked. Said in words beside it.
pub(super) fn line(values: &[(UtcMicros, f64)], span: Span, level: Option<f64>, budget: Option<f64>) -> Markup {
    let within: Vec<_> = values.iter().copied().filter(|(at, _)| (span.from..=span.to).contains(at)).collect();
    let Some(&(last, newest)) = within.last() else { return html! {} };
    let band = level.zip(budget).map(|(level, budget)| (level - budget, level + budget));
    let shown = within.iter().map(|(_, value)| *value).chain(band.into_iter().flat_map(|(low, high)| [low, high]));
    let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    // Values that are all the same lie in the middle.
    let (high, height) = if high > low { (high, high - low) } else { (high + 0.5, 1.0) };
    let part = |at: UtcMicros| at.days_since(span.from) / span.to.days_since(span.from).max(f64::MIN_POSITIVE);
    let x = |at: UtcMicros| EDGE + (WIDTH - 2.0 * EDGE) * part(at);
    let y = |value: f64| EDGE + (HEIGHT - 2.0 * EDGE) * (high - value) / height;
    let points: String = within.iter().map(|&(at, value)| format!("{:.0},{:.1} ", x(at), y(value))).collect();
    let outside = band.is_some_and(|(low, high)| newest < low || newest > high);
    html! {
        svg.spark viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } aria-hidden="true" {
            @if let Some((low, high)) = band {
                rect.band x="0" y=(format!("{:.1}", y(high))) width=(WIDTH) height=(format!("{:.1}", y(low) - y(high))) {}
            }
            polyline points=(points.trim_end()) {}
            circle class=[outside.then_some("out")] cx=(format!("{:.0}", x(last))) cy=(format!("{:.1}", y(newest))) r="2.5" {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const YEAR: Span = Span { from: UtcMicros(0), to: UtcMicros(360 * UtcMicros::DAY) };

    fn at(day: i64, value: f64) -> (UtcMicros, f64) {
        (UtcMicros(day * UtcMicros::DAY), value)
    }

    #[test]
    fn the_newest_value_outside_the_budget_is_marked() {
        let drawn = |values: &[_]| line(values, YEAR, Some(1.0), Some(0.01)).into_string();
        assert!(drawn(&[at(1, 1.0), at(2, 1.005)]).contains("<circle cx"));
        assert!(drawn(&[at(1, 1.0), at(2, 1.02)]).contains("class=\"out\""));
        assert_eq!(drawn(&[]), "");
    }

    #[test]
    fn values_stand_where_their_time_is_and_older_ones_nowhere() {
        let drawn = line(&[at(-5, 9.0), at(0, 2.0), at(90, 2.0), at(360, 2.0)], YEAR, None, None).into_string();
        // A quarter of the way is 3 + 50 / 4; equal values lie in the middle.
        assert!(drawn.contains("points=\"3,11.0 16,11.0 53,11.0\""), "{drawn}");
        assert_eq!(line(&[at(-5, 9.0)], YEAR, None, None).into_string(), "");
    }
}
