//! A course over time, drawn by the service: measured points, and lines of what explains them.

use maud::{Markup, html};

use super::chart::{BOTTOM, DATES, FIGURES, HEIGHT, LEFT, RIGHT, TOP, WIDTH, bounds, place, round_steps, widened};
use super::layout::symbol;
use crate::core::time::UtcMicros;

/// One coefficient.
pub(super) struct Course<'a> {
    /// `D_I`.
    pub symbol: &'a str,
    pub unit: &'a str,
    pub name: &'a str,
    /// With standard deviations where they are known.
    pub points: Vec<(UtcMicros, f64, Option<f64>)>,
    /// By class of the style sheet.
    pub lines: Vec<(&'static str, Vec<(UtcMicros, f64)>)>,
    /// Instants with a label.
    pub marks: Vec<(UtcMicros, String)>,
}

impl Course<'_> {
    pub fn markup(&self) -> Markup {
        let millis = |at: UtcMicros| (at.0 / 1000) as f64;
        let times = self.points.iter().map(|(at, ..)| millis(*at));
        let lines = || self.lines.iter().flat_map(|(_, line)| line);
        let bars = self.points.iter().flat_map(|(_, v, sd)| [v - sd.unwrap_or(0.0), v + sd.unwrap_or(0.0)]);
        let Some((t, v)) = bounds(times).zip(bounds(bars.chain(lines().map(|(_, v)| *v)))) else { return html! {} };
        let (t, v) = (widened(t, 0.02, 8.64e7), widened(v, 0.06, 1e-3));
        let x = |at: UtcMicros| LEFT + (millis(at) - t.0) / (t.1 - t.0) * (WIDTH - LEFT - RIGHT);
        let y = |value: f64| HEIGHT - BOTTOM - (value - v.0) / (v.1 - v.0) * (HEIGHT - TOP - BOTTOM);
        let (figures, decimals) = round_steps(v, FIGURES);
        let (left, right, top, bottom) = (LEFT, WIDTH - RIGHT, TOP, HEIGHT - BOTTOM);
        let corner = |(at, v): &(UtcMicros, f64)| format!("{},{}", place(x(*at)), place(y(*v)));
        let corners = |line: &[(UtcMicros, f64)]| line.iter().map(corner).collect::<Vec<_>>().join(" ");
        let date = |k: usize| UtcMicros(((t.0 + (t.1 - t.0) * (k as f64 + 0.5) / DATES as f64) * 1000.0) as i64);
        html! {
            figure.chart {
                figcaption { (symbol(self.symbol)) ", " (self.unit) }
                svg role="img" aria-label={ (self.name) " " (self.symbol) } viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } {
                    @for figure in figures {
                        @let height = y(figure);
                        line.grid x1=(left) x2=(right) y1=(place(height)) y2=(place(height)) {}
                        text x=(left - 6.0) y=(place(height + 4.0)) text-anchor="end" {
                            (format!("{figure:.decimals$}"))
                        }
                    }
                    @for at in (0..DATES).map(date) {
                        text x=(place(x(at))) y=(HEIGHT - 6.0) text-anchor="middle" { (at.date()) }
                    }
                    @for (at, label) in &self.marks {
                        @let at = place(x(*at));
                        line.event x1=(at) x2=(at) y1=(top) y2=(bottom) { title { (label) } }
                    }
                    @for (class, line) in &self.lines { polyline.(class) points=(corners(line)) {} }
                    @for (at, v, sd) in &self.points {
                        @let at = place(x(*at));
                        @if let Some(sd) = sd {
                            line.bar x1=(at) x2=(at) y1=(place(y(v - sd))) y2=(place(y(v + sd))) {}
                        }
                        circle.measured cx=(at) cy=(place(y(*v))) r="2.8" {}
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_lines_are_drawn_and_higher_values_stand_higher() {
        let day = |k: i64| UtcMicros(k * UtcMicros::DAY);
        let course = Course {
            symbol: "D_I",
            unit: "deg/(h g0)",
            name: "A",
            points: vec![(day(0), 1.0, Some(0.1)), (day(9), 2.0, None)],
            lines: vec![("explained", vec![(day(0), 1.0), (day(9), 2.0)])],
            marks: vec![(day(4), "transport".into())],
        };
        let drawn = course.markup().into_string();
        assert_eq!((drawn.matches("<circle").count(), drawn.matches("<polyline").count()), (2, 1), "{drawn}");
        assert!(drawn.contains("<title>transport</title>") && !drawn.contains("NaN"), "{drawn}");
        let heights: Vec<f64> =
            drawn.split("cy=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert!(heights[1] < heights[0], "{heights:?}");
        let none = Course { points: vec![], lines: vec![], marks: vec![], ..course };
        assert_eq!(none.markup().into_string(), "");
    }
}
