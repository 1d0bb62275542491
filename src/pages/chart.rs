//! A gyro's history drawn by the service: what a page without scripts, and paper, show of it.

use maud::{Markup, html};

use super::layout::symbol;
use super::plot::{ALONE, Band, Plot, Series, Strip};
use crate::core::judge::Status;
use crate::core::time::UtcMicros;

/// Width and height of one strip, with the room that its axes take.
pub(super) const WIDTH: f64 = 760.0;
pub(super) const HEIGHT: f64 = 190.0;
pub(super) const LEFT: f64 = 74.0;
pub(super) const RIGHT: f64 = 12.0;
pub(super) const TOP: f64 = 10.0;
pub(super) const BOTTOM: f64 = 24.0;
/// Dates under a strip, and figures beside it, about.
pub(super) const DATES: usize = 5;
pub(super) const FIGURES: f64 = 6.0;

/// From the numbers of a strip to places in its picture.
struct Scale {
    /// Milliseconds since 1970.
    t: (f64, f64),
    v: (f64, f64),
}

impl Scale {
    /// All that is measured and the budgets about the baselines; none where nothing is measured.
    fn of(plot: &Plot, strip: &Strip) -> Option<Self> {
        let times = plot.strips.iter().flat_map(|strip| &strip.series).flat_map(|series| &series.t);
        let t = bounds(times.map(|t| *t as f64))?;
        let measured = strip.series.iter().flat_map(|series| &series.v).copied();
        let measured = bounds(measured)?;
        let edges = strip.bands.iter().flat_map(|(_, _, level, budget, _)| {
            let half = budget.unwrap_or(0.0);
            [level - half, level + half]
        });
        let v = bounds(edges.chain([measured.0, measured.1]))?;
        Some(Self { t: widened(t, 0.02, ALONE as f64), v: widened(v, 0.06, strip.around) })
    }

    fn x(&self, t: i64) -> f64 {
        LEFT + (t as f64 - self.t.0) / (self.t.1 - self.t.0) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, v: f64) -> f64 {
        let share = (v - self.v.0) / (self.v.1 - self.v.0);
        HEIGHT - BOTTOM - share.clamp(0.0, 1.0) * (HEIGHT - TOP - BOTTOM)
    }
}

pub(super) fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |bounds, v| bounds.map_or(Some((v, v)), |(a, b): (f64, f64)| Some((a.min(v), b.max(v)))))
}

/// By a share on either side; where there is no width, by `least`.
pub(super) fn widened((a, b): (f64, f64), share: f64, least: f64) -> (f64, f64) {
    let edge = (share * (b - a)).max(if b > a { 0.0 } else { least });
    (a - edge, b + edge)
}

/// Round numbers within, about so many, and their decimals: steps of 1, 2 or 5 times a power of ten.
pub(super) fn round_steps((a, b): (f64, f64), about: f64) -> (Vec<f64>, usize) {
    let raw = (b - a) / about;
    let power = 10_f64.powf(raw.log10().floor());
    let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= raw).unwrap_or(10.0);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (a / step).ceil() as i64;
    let last = (b / step).floor() as i64;
    ((first..=last).map(|k| k as f64 * step).collect(), decimals)
}

/// Every strip of a history, one below the other.
pub(super) fn strips(plot: &Plot) -> Markup {
    html! { @for strip in &plot.strips { @if let Some(scale) = Scale::of(plot, strip) { (one(plot, strip, &scale)) } } }
}

fn one(plot: &Plot, strip: &Strip, scale: &Scale) -> Markup {
    let (figures, decimals) = round_steps(scale.v, FIGURES);
    html! {
        figure.chart {
            figcaption { (symbol(strip.symbol)) ", " (plot.unit) }
            svg role="img" aria-label={ (plot.name) " " (strip.symbol) } viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } {
                @for one in &strip.bands { (band(scale, one)) }
                @for figure in figures {
                    @let y = place(scale.y(figure));
                    line.grid x1=(LEFT) x2=(WIDTH - RIGHT) y1=(y) y2=(y) {}
                    text x=(LEFT - 6.0) y=(place(scale.y(figure) + 4.0)) text-anchor="end" { (format!("{figure:.decimals$}")) }
                }
                @for k in 0..DATES {
                    @let t = scale.t.0 + (scale.t.1 - scale.t.0) * (k as f64 + 0.5) / DATES as f64;
                    text x=(place(scale.x(t as i64))) y=(HEIGHT - 6.0) text-anchor="middle" { (UtcMicros(t as i64 * 1000).date()) }
                }
                @for mark in &plot.marks {
                    @let x = place(scale.x(mark.t));
                    @if let Some(until) = mark.until {
                        @let (from, to) = (scale.x(mark.t).clamp(LEFT, WIDTH - RIGHT), scale.x(until).clamp(LEFT, WIDTH - RIGHT));
                        rect.test x=(place(from)) y=(TOP) width=(place((to - from).max(1.0))) height=(HEIGHT - TOP - BOTTOM) { title { (mark.label) } }
                    } @else {
                        line.(if mark.event { "event" } else { "change" }) x1=(x) x2=(x) y1=(TOP) y2=(HEIGHT - BOTTOM) { title { (mark.label) } }
                    }
                }
                @for series in &strip.series { (points(scale, series)) }
            }
        }
    }
}

fn band(scale: &Scale, &(from, to, level, budget, control): &Band) -> Markup {
    let (x1, x2) = (scale.x(from), scale.x(to));
    html! {
        @if let Some(budget) = budget {
            @let (top, bottom) = (scale.y(level + budget), scale.y(level - budget));
            rect.band x=(place(x1)) y=(place(top)) width=(place((x2 - x1).max(1.0))) height=(place(bottom - top)) {}
        }
        @for limit in control.into_iter().flat_map(|control| [level - control, level + control]) {
            line.control x1=(place(x1)) x2=(place(x2)) y1=(place(scale.y(limit))) y2=(place(scale.y(limit))) {}
        }
        line.level x1=(place(x1)) x2=(place(x2)) y1=(place(scale.y(level))) y2=(place(scale.y(level))) {}
    }
}

/// Error bars, and a shape for each status: a triangle where a rule says that a limit is passed.
fn points(scale: &Scale, series: &Series) -> Markup {
    let sd = |k: usize| series.sd.as_ref().and_then(|sd| sd[k]);
    html! {
        @for (k, (&t, &v)) in series.t.iter().zip(&series.v).enumerate() {
            @let (x, y) = (scale.x(t), scale.y(v));
            @if let Some(sd) = sd(k) { line.bar x1=(place(x)) x2=(place(x)) y1=(place(scale.y(v - sd))) y2=(place(scale.y(v + sd))) {} }
            @if series.bench { path.bench d={ "M" (place(x)) " " (place(y - 5.0)) "l4 5l-4 5l-4-5z" } {} }
            @else {
                @let status = Status::ALL[usize::from(series.status[k])];
                @if status >= Status::Drifting {
                    path.(status.name()) d={ "M" (place(x)) " " (place(y - 4.5)) "l4 7h-8z" } {}
                } @else { circle.(status.name()) cx=(place(x)) cy=(place(y)) r="2.8" {} }
            }
        }
    }
}

/// A tenth of a pixel is enough.
pub(super) fn place(pixels: f64) -> String {
    format!("{pixels:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Measured;
    use crate::pages::plot::{Mark, Point};

    #[test]
    fn steps_are_round_and_within() {
        let (steps, decimals) = round_steps((-0.013, 0.027), 4.0);
        assert_eq!(
            steps.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>(),
            ["-0.01", "0.00", "0.01", "0.02"]
        );
        assert_eq!(round_steps((0.0, 40.0), 4.0), (vec![0.0, 10.0, 20.0, 30.0, 40.0], 0));
    }

    fn plot(values: &[f64]) -> Plot {
        let point = |(k, v): (usize, &f64)| Point {
            at: UtcMicros(k as i64 * UtcMicros::DAY),
            measured: Measured { value: *v, sd: Some(0.001) },
            status: Some(if *v > 1.5 { Status::Confirmed } else { Status::InTolerance }),
            place: String::new(),
        };
        let points: Vec<Point> = values.iter().enumerate().map(point).collect();
        let strip = Strip {
            symbol: "D_I",
            series: vec![Series::new("rigid", false, &points, |point| point.measured.value, Point::clone)],
            bands: vec![(0, 86_400_000, 1.0, Some(0.5), Some(0.2))],
            around: 0.5,
        };
        let mark = |until, label: &str| Mark { t: 43_200_000, until, label: label.into(), event: true };
        let marks = vec![mark(None, "repair"), mark(Some(86_400_000), "vibration")];
        Plot {
            name: "A".into(),
            unit: "deg/(h g0)",
            strips: vec![strip],
            marks,
            statuses: [("", ""); 9],
            since: None,
            alone: ALONE,
        }
    }

    #[test]
    fn every_point_is_drawn_in_its_shape_and_higher_values_stand_higher() {
        let drawn = strips(&plot(&[1.0, 1.2, 2.0])).into_string();
        assert_eq!((drawn.matches("<circle").count(), drawn.matches("class=\"confirmed\"").count()), (2, 1), "{drawn}");
        assert!(
            drawn.contains("class=\"event\"")
                && drawn.contains("class=\"band\"")
                && drawn.matches("class=\"control\"").count() == 2
                && drawn.contains("repair")
                && drawn.matches("class=\"test\"").count() == 1
                && drawn.contains("<title>vibration</title>")
        );
        let heights: Vec<f64> =
            drawn.split("cy=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
        assert!(heights[1] < heights[0], "{heights:?}");
    }

    #[test]
    fn a_gyro_without_a_history_has_no_picture_and_one_point_has_one() {
        assert_eq!(strips(&plot(&[])).into_string(), "");
        let mut alone = plot(&[1.0]);
        alone.strips[0].bands.clear();
        let one = strips(&alone).into_string();
        assert!(one.contains("<circle") && !one.contains("NaN"), "{one}");
        for figure in ["0.6", "1.0", "1.4", "1969-12-20", "1970-01-01", "1970-01-13"] {
            assert!(one.contains(&format!(">{figure}</text>")), "the budget and a month about it, {figure}: {one}");
        }
    }
}
