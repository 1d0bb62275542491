//! Residuals dwell by dwell, and gyro by dwell, as pictures without a script.

use maud::{Markup, html};

use super::chart::{Across, Chart, Dot, Level, Track, bounds, widened};
use super::figure::short;
use super::text::Text;
use crate::wire::diagnosis::ResidualBody;

const WIDTH: f64 = 960.0;
/// Of one strip, pixels.
const HEIGHT: f64 = 110.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 8.0;
/// Residuals of so many standard deviations are shown at full shade.
const FULL_SHADE: f64 = 6.0;

fn tenth(value: f64) -> String {
    format!("{value:.1}")
}

/// The largest of all, which the pictures of all gyros reach to.
pub(super) fn extent<'a>(all: impl Iterator<Item = &'a f64>) -> f64 {
    all.map(|value| value.abs()).filter(|size| size.is_finite()).fold(0.0, f64::max)
}

/// Residuals over their own standard deviations; two of them to either side are a band.
pub(super) fn strip(t: &Text, standardised: &[f64], extent: f64) -> Markup {
    let dots = standardised.iter().copied().enumerate();
    picture(t, "", "σ", vec![track("dot", dots, "σ", t)], Some(2.0), extent)
}

/// Residuals of one gyro in one campaign, deg/h.
pub(super) fn in_rate(t: &Text, name: &str, residuals: &[f64], extent: f64) -> Markup {
    picture(t, name, "deg/h", vec![track("dot", residuals.iter().copied().enumerate(), "deg/h", t)], None, extent)
}

/// One gyro of a diagnosis, deg/h: hollow before, filled with the named effects added.
pub(super) fn before_and_after(t: &Text, all: &[ResidualBody], slot: &str, extent: f64) -> Markup {
    let own = || all.iter().filter(|residual| residual.slot == slot);
    let before = track("hollow", own().map(|r| (r.index, r.before_deg_per_h)), "deg/h", t);
    let after = track("dot", own().map(|r| (r.index, r.after_deg_per_h)), "deg/h", t);
    let sd = own().map(|r| r.sd_deg_per_h).sum::<f64>() / own().count().max(1) as f64;
    picture(t, "", "deg/h", vec![before, after], Some(2.0 * sd), extent)
}

fn track(class: &str, values: impl Iterator<Item = (usize, f64)>, unit: &str, t: &Text) -> Track {
    let dot = |(dwell, y): (usize, f64)| Dot {
        x: dwell as f64,
        y,
        said: format!("{} {dwell}: {} {unit}", t.dwell, short(y)),
        ..Dot::default()
    };
    Track { class: class.into(), dots: values.map(dot).collect(), ..Track::default() }
}

/// Dwells across; a band to either side of zero; the y axis reaches to `extent` on either side.
fn picture(t: &Text, name: &str, unit: &str, tracks: Vec<Track>, band: Option<f64>, extent: f64) -> Markup {
    let last = tracks.iter().flat_map(|track| &track.dots).map(|dot| dot.x).fold(0.0, f64::max);
    let reach = 1.08 * extent.max(band.unwrap_or(0.0)).max(f64::MIN_POSITIVE);
    let x = (-0.5, last + 0.5);
    let caption = html! { span { @if !name.is_empty() { (name) ", " } (unit) } };
    let chart = Chart {
        range: Some((-reach, reach)),
        height: HEIGHT,
        levels: vec![Level { from: x.0, until: x.1, shade: band, ..Level::default() }],
        tracks,
        ..Chart::new(format!("{} {name}", t.residuals_by_dwell), caption, Across::Figure(t.dwell.to_owned()), x)
    };
    chart.markup()
}

/// One dwell: the figure that an effect follows, deg/h that it does not leave unexplained, and their uncertainty.
pub(super) struct Point {
    pub dwell: usize,
    pub x: f64,
    pub y: f64,
    pub sd: f64,
}

/// An effect in one gyro.
pub(super) struct Evidence {
    pub name: String,
    pub points: Vec<Point>,
    /// Of the fit through zero, deg/h per unit of x.
    pub slope: f64,
    /// Of x.
    pub unit: String,
}

/// Residuals against what an effect follows, with its fit, all gyros on one scale.
pub(super) fn evidence(t: &Text, all: &[Evidence]) -> Markup {
    let points = || all.iter().flat_map(|one| &one.points);
    let reach = 1.08 * extent(points().map(|point| &point.y)).max(f64::MIN_POSITIVE);
    let Some(x) = bounds(points().map(|point| point.x)) else { return html! {} };
    let x = widened(x, 0.05, 1.0);
    let chart = |one: &Evidence| {
        let dot = |point: &Point| Dot {
            x: point.x,
            y: point.y,
            sd: Some(point.sd),
            said: format!("{} {}: {} deg/h", t.dwell, point.dwell, short(point.y)),
            ..Dot::default()
        };
        Chart {
            range: Some((-reach, reach)),
            height: HEIGHT,
            tracks: vec![Track { class: "dot".into(), dots: one.points.iter().map(dot).collect(), ..Track::default() }],
            lines: vec![("fit", [x.0, x.1].map(|x| (x, one.slope * x)).to_vec())],
            ..Chart::new(
                format!("{}: {}", one.name, t.evidence_note),
                html! { span { (one.name) ", deg/h" } },
                Across::Figure(format!("{}, {}", t.regressor, one.unit)),
                x,
            )
        }
    };
    html! { div.charts.three { @for one in all { (chart(one).markup()) } } }
}

/// Gyros down, dwells across; the shade of a cell is its residual over its standard deviation.
pub(super) fn heat_map(t: &Text, all: &[ResidualBody], slots: &[String]) -> Markup {
    let dwells = all.iter().map(|residual| residual.index + 1).max().unwrap_or(1);
    let (row, cell) = (26.0, (WIDTH - LEFT - RIGHT) / dwells as f64);
    html! {
        svg.dwells viewBox={ "0 0 " (WIDTH) " " (row * slots.len() as f64 + 18.0) } role="img" aria-label=(t.heat_map) {
            @for (line, slot) in slots.iter().enumerate() {
                @let top = row * line as f64;
                text x=(LEFT - 6.0) y=(tenth(top + 17.0)) text-anchor="end" { (slot) }
                @for residual in all.iter().filter(|residual| residual.slot == *slot) {
                    @let ratio = if residual.sd_deg_per_h > 0.0 { residual.before_deg_per_h / residual.sd_deg_per_h } else { 0.0 };
                    rect.heat x=(tenth(LEFT + cell * residual.index as f64)) y=(tenth(top + 1.0)) width=(tenth(cell.max(0.6)))
                        height=(row - 2.0) fill-opacity=(format!("{:.2}", (ratio.abs() / FULL_SHADE).min(1.0))) {
                        title { (slot) ", " (t.dwell) " " (residual.index) ": " (format!("{ratio:+.1}")) " σ" }
                    }
                }
            }
            text x=(LEFT) y=(row * slots.len() as f64 + 14.0) { (t.dwell) " 0" }
            text x=(WIDTH - RIGHT) y=(row * slots.len() as f64 + 14.0) text-anchor="end" { (dwells - 1) }
        }
    }
}

/// How much of the gap is closed, from 0 to 1, with its interval as a whisker.
pub(super) fn closure_bar(closure: f64, interval: Option<[f64; 2]>) -> Markup {
    let x = |share: f64| 2.0 + 156.0 * share.clamp(0.0, 1.0);
    html! {
        svg.closure viewBox="0 0 160 14" role="img" aria-label=(super::figure::percent(closure)) {
            rect.frame x="2" y="3" width="156" height="8" {}
            rect.filled x="2" y="3" width=(tenth(x(closure) - 2.0)) height="8" {}
            @if let Some([low, high]) = interval {
                path d=(format!("M{a:.1} 7H{b:.1}M{a:.1} 1V13M{b:.1} 1V13", a = x(low), b = x(high))) {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    fn residual(index: usize, slot: &str, before: f64) -> ResidualBody {
        ResidualBody { index, slot: slot.into(), before_deg_per_h: before, after_deg_per_h: 0.0, sd_deg_per_h: 0.01 }
    }

    #[test]
    fn a_large_residual_is_dark_and_every_dwell_is_there() {
        let all = [residual(0, "G1", 0.0), residual(1, "G1", -0.12), residual(0, "G2", 0.03), residual(1, "G2", 0.0)];
        let map = heat_map(Language::English.text(), &all, &["G1".into(), "G2".into()]).into_string();
        assert_eq!(map.matches("<rect").count(), 4);
        assert!(map.contains(r#"fill-opacity="1.00"><title>G1, dwell 1: -12.0 σ"#), "{map}");
        assert!(map.contains(r#"fill-opacity="0.50"><title>G2, dwell 0: +3.0 σ"#), "{map}");
    }

    #[test]
    fn the_strips_of_all_gyros_have_one_scale_and_the_unit_of_their_own_axis() {
        let t = Language::English.text();
        let all = [residual(0, "G1", 0.5), residual(0, "G2", 0.001)];
        let extent = extent(all.iter().map(|one| &one.before_deg_per_h));
        for slot in ["G1", "G2"] {
            let drawn = before_and_after(t, &all, slot, extent).into_string();
            assert!(drawn.contains(">0.4</text>") && drawn.contains(">-0.4</text>"), "{slot}: {drawn}");
            assert!(drawn.contains("<figcaption><span>deg/h</span>"), "{drawn}");
            assert!(drawn.contains("text-anchor=\"end\">dwell</text>"), "{drawn}");
        }
    }

    #[test]
    fn the_fit_of_an_effect_goes_through_its_points() {
        let point = |k: i32| Point { dwell: 0, x: f64::from(k), y: 0.002 * f64::from(k), sd: 1e-4 };
        let one = Evidence { name: "G1".into(), points: (-3..=3).map(point).collect(), slope: 0.002, unit: "K".into() };
        let drawn = evidence(Language::English.text(), &[one]).into_string();
        let line = drawn.split("<polyline class=\"fit\" points=\"").nth(1).unwrap();
        let ends: Vec<f64> = line
            .split('"')
            .next()
            .unwrap()
            .split([',', ' '])
            .filter(|n| !n.is_empty())
            .map(|n| n.parse().unwrap())
            .collect();
        assert!(ends[1] > ends[3] && (ends[1] + ends[3] - HEIGHT).abs() < 0.2, "{ends:?}");
        assert!(drawn.contains("regressor, K<"), "x has its unit: {drawn}");
        assert_eq!(drawn.matches("<circle class=\"plain\"").count(), 7);
    }

    #[test]
    fn nothing_to_draw_is_no_trouble() {
        assert_eq!(strip(Language::English.text(), &[], 0.0).into_string(), "");
        assert!(!heat_map(Language::English.text(), &[], &[]).into_string().contains("NaN"));
    }
}
