//! A course over time, drawn by the service: measured points, and lines of what explains them.

use super::chart::{Chart, DataPoint, Flag, Level, Track, XAxis, bounds, millis, widened};
use super::history_plot::{MOST_FLAGS, list};
use super::prelude::*;

/// One coefficient.
pub(super) struct CoefficientSeries<'a> {
    /// `D_I`.
    pub symbol: &'a str,
    pub name: &'a str,
    /// Either side of zero.
    pub budget: Option<f64>,
    /// With standard deviations where they are known.
    pub points: Vec<(UtcMicros, f64, Option<f64>)>,
    /// By class of the style sheet.
    pub lines: Vec<(&'static str, Vec<(UtcMicros, f64)>)>,
    /// Instants with a label.
    pub marks: Vec<(UtcMicros, String)>,
}

impl CoefficientSeries<'_> {
    pub fn markup(&self, t: &Text) -> Markup {
        let lines = || self.lines.iter().flat_map(|(_, line)| line.iter().map(|(at, _)| millis(*at)));
        let ends = bounds(self.points.iter().map(|(at, ..)| millis(*at)).chain(lines())).unwrap_or((0.0, 0.0));
        let dot = |(at, y, sd): &(UtcMicros, f64, Option<f64>)| DataPoint {
            x: millis(*at),
            y: *y,
            sd: *sd,
            said: format!("{} · {} {} {}", at.date(), self.symbol, figure::drift(*y, *sd), t.unit),
            ..DataPoint::default()
        };
        let flag = |(k, (at, label)): (usize, &(UtcMicros, String))| Flag {
            x: millis(*at),
            until: None,
            number: k + 1,
            anchor: format!("{}-{}", self.symbol, k + 1),
            label: format!("{} {label}", at.date()),
        };
        let track = Track { class: "measured".into(), dots: self.points.iter().map(dot).collect(), ..Track::default() };
        let line = |(class, line): &(&'static str, Vec<(UtcMicros, f64)>)| {
            (*class, line.iter().map(|(at, y)| (millis(*at), *y)).collect())
        };
        let (x, budget) = (widened(ends, 0.02, 8.64e7), self.budget);
        let level = Level { from: x.0, until: x.1, budget, ..Level::default() };
        let caption = html! {
            span { (symbol(self.symbol)) ", " (t.unit) }
            @if budget.is_some() { span.quiet { (t.percent_of_budget) } }
        };
        let earlier = self.marks.len().saturating_sub(MOST_FLAGS);
        let flags: Vec<Flag> = self.marks.iter().enumerate().skip(earlier).map(flag).collect();
        let named = if self.points.is_empty() { Markup::default() } else { list(&flags) };
        let label = format!("{} {}", self.name, self.symbol);
        let chart = Chart {
            around: budget.unwrap_or(1e-3),
            whole: budget,
            signed: true,
            levels: budget.map(|_| level).into_iter().collect(),
            tracks: vec![track],
            lines: self.lines.iter().map(line).collect(),
            flags,
            ..Chart::new(label, caption, XAxis::Time, x)
        };
        html! { (chart.markup()) (named) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn points_and_lines_are_drawn_and_higher_values_stand_higher() {
        let t = Language::English.text();
        let day = |k: i64| UtcMicros(k * UtcMicros::DAY);
        let course = CoefficientSeries {
            symbol: "D_I",
            name: "A",
            budget: None,
            points: vec![(day(0), 1.0, Some(0.1)), (day(9), 2.0, None)],
            lines: vec![("explained", vec![(day(0), 1.0), (day(9), 2.0)])],
            marks: vec![(day(4), "transport".into())],
        };
        let drawn = course.markup(t).into_string();
        let of = |what: &str| drawn.matches(what).count();
        assert_eq!((of("<circle class=\"plain\""), of("<polyline class=\"explained\"")), (2, 1), "{drawn}");
        assert!(drawn.contains("1970-01-05 transport</title>") && !drawn.contains("NaN"), "{drawn}");
        let heights: Vec<f64> =
            drawn.split("cy=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert!(heights[1] < heights[0], "{heights:?}");
        let none = CoefficientSeries { points: vec![], lines: vec![], ..course };
        assert_eq!(none.markup(t).into_string(), "");
    }
}
