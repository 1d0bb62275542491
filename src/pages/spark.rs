//! A gyro's last values as a line the height of a word.

use std::fmt::Write;

use maud::{Markup, html};

const WIDTH: f64 = 120.0;
const HEIGHT: f64 = 30.0;
const EDGE: f64 = 4.0;

/// The values from left to right, the budget about the level as a band, the newest marked. `label` says it in words.
pub(super) fn line(values: &[f64], level: Option<f64>, budget: Option<f64>, label: &str) -> Markup {
    let Some(&newest) = values.last() else { return html! {} };
    let band = level.zip(budget).map(|(level, budget)| (level - budget, level + budget));
    let shown = values.iter().copied().chain(band.into_iter().flat_map(|(low, high)| [low, high]));
    let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    // Values that are all the same lie in the middle.
    let (high, height) = if high > low { (high, high - low) } else { (high + 0.5, 1.0) };
    let x = |i: usize| EDGE + (WIDTH - 2.0 * EDGE) * i as f64 / (values.len() - 1).max(1) as f64;
    let y = |value: f64| EDGE + (HEIGHT - 2.0 * EDGE) * (high - value) / height;
    let mut points = String::with_capacity(9 * values.len());
    for (i, &value) in values.iter().enumerate() {
        write!(points, "{:.0},{:.1} ", x(i), y(value)).expect("writing to a string cannot fail");
    }
    let outside = band.is_some_and(|(low, high)| newest < low || newest > high);
    let (cx, cy) = (format!("{:.0}", x(values.len() - 1)), format!("{:.1}", y(newest)));
    html! {
        svg.spark viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(label) {
            @if let Some((low, high)) = band {
                rect.band x="0" y=(format!("{:.1}", y(high))) width=(WIDTH) height=(format!("{:.1}", y(low) - y(high))) {}
            }
            polyline points=(points.trim_end()) {}
            circle class=[outside.then_some("out")] cx=(cx) cy=(cy) r="3" {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_value_outside_the_budget_is_marked() {
        let drawn = |values: &[f64]| line(values, Some(1.0), Some(0.01), "a \"b\"").into_string();
        assert!(drawn(&[1.0, 1.005]).contains("<circle cx"));
        assert!(drawn(&[1.0, 1.02]).contains("class=\"out\""));
        assert!(drawn(&[1.0]).contains("a &quot;b&quot;"));
        assert_eq!(line(&[], None, None, "").into_string(), "");
    }

    #[test]
    fn equal_values_lie_in_the_middle() {
        let drawn = line(&[2.0; 5], None, None, "").into_string();
        assert!(drawn.contains("cy=\"15.0\"") && !drawn.contains("NaN"), "{drawn}");
    }
}
