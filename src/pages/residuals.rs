//! Residuals dwell by dwell, and gyro by dwell, as pictures without a script.

use nalgebra::Vector3;

use super::chart::{Chart, DataPoint, Level, Track, XAxis, bounds, widened};
use super::figure::{percent, short};
use super::prelude::*;
use crate::core::campaign::{Campaign, Dwell, Phase};
use crate::wire::diagnosis::{ResidualBody, TableBody};

const WIDTH: f64 = 960.0;
/// Of one strip, pixels.
const HEIGHT: f64 = 110.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 8.0;
/// Residuals of so many standard deviations are shown at full shade.
const FULL_SHADE: f64 = 6.0;
/// Height of a gyro's row in the map.
const ROW: f64 = 34.0;
/// Of what stands under them.
const LANE: f64 = 16.0;
/// The part of a direction that still counts as none, for the name of a face.
const NEARLY: f64 = 0.05;

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
    let unit = t.rate_unit;
    picture(t, name, unit, vec![track("dot", residuals.iter().copied().enumerate(), unit, t)], None, extent)
}

/// One gyro of a diagnosis, deg/h: hollow before, filled with the named effects added.
pub(super) fn before_and_after(t: &Text, all: &[ResidualBody], slot: &str, extent: f64) -> Markup {
    let unit = t.rate_unit;
    let own = || all.iter().filter(|residual| residual.slot == slot);
    let before = track("hollow", own().map(|r| (r.index, r.before_deg_per_h)), unit, t);
    let after = track("dot", own().map(|r| (r.index, r.after_deg_per_h)), unit, t);
    let sd = own().map(|r| r.sd_deg_per_h).sum::<f64>() / own().count().max(1) as f64;
    picture(t, "", unit, vec![before, after], Some(2.0 * sd), extent)
}

fn track(class: &str, values: impl Iterator<Item = (usize, f64)>, unit: &str, t: &Text) -> Track {
    let dots = values.map(|(dwell, y)| DataPoint {
        x: dwell as f64,
        y,
        said: said(t, dwell, y, unit),
        ..DataPoint::default()
    });
    Track { class: class.into(), dots: dots.collect(), ..Track::default() }
}

fn said(t: &Text, dwell: usize, y: f64, unit: &str) -> String {
    format!("{} {dwell}: {} {unit}", t.dwell, short(y))
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
        ..Chart::new(format!("{} {name}", t.residuals_by_dwell), caption, XAxis::Figure(t.dwell.to_owned()), x)
    };
    chart.markup()
}

/// One dwell: the figure that an effect follows, deg/h that it does not leave unexplained, and their uncertainty.
pub(super) fn point(t: &Text, dwell: usize, x: f64, y: f64, sd: f64) -> DataPoint {
    DataPoint { x, y, sd: Some(sd), said: said(t, dwell, y, t.rate_unit), ..DataPoint::default() }
}

/// An effect in one gyro.
pub(super) struct Evidence {
    pub name: String,
    /// Of its dwells, as [`point`] has them.
    pub points: Vec<DataPoint>,
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
    let unit = t.rate_unit;
    let chart = |one: &Evidence| Chart {
        range: Some((-reach, reach)),
        height: HEIGHT,
        tracks: vec![Track { class: "dot".into(), dots: one.points.clone(), ..Track::default() }],
        lines: vec![("fit", [x.0, x.1].map(|x| (x, one.slope * x)).to_vec())],
        ..Chart::new(
            format!("{}: {}", one.name, t.evidence_note),
            html! { span { (one.name) (t.colon) " " (t.residual_word) ", " (unit) } },
            XAxis::Figure(format!("{}, {}", t.regressor, one.unit)),
            x,
        )
    };
    html! { div.charts.three { @for one in all { (chart(one).markup()) } } }
}

/// How a dwell was set.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The body direction that was up, or about which the table turned.
    direction: Vector3<f64>,
    /// Of a rate dwell.
    deg_per_s: Option<f64>,
}

impl Setting {
    /// Of every dwell of a campaign.
    pub fn of_all(campaign: &Campaign) -> Vec<Self> {
        let of = |dwell: &Dwell| match dwell.phase {
            Phase::Static => Self { direction: dwell.specific_force_g0.normalize(), deg_per_s: None },
            Phase::Rate => {
                let rate = dwell.rate_arcsec_s;
                Self { direction: rate.normalize(), deg_per_s: Some(rate.norm() / 3600.0) }
            }
        };
        campaign.dwells.iter().map(of).collect()
    }

    /// A face that is not quite level is still that face.
    fn axis(&self) -> String {
        let plain = self.direction.map(|x| if x.abs() < NEARLY { 0.0 } else { x });
        TableBody::direction(plain.into())
    }

    fn said(&self, t: &Text) -> String {
        match self.deg_per_s {
            None => format!("{} {}", t.up_axis, self.axis()),
            Some(rate) => format!("{} {}, {rate:.3} {}", t.table_rate, self.axis(), t.unit_of("deg/s")),
        }
    }
}

/// Gyros down, dwells across, by time, and folded by attitude and rate.
pub(super) fn signed_maps(t: &Text, all: &[ResidualBody], slots: &[String], settings: &[Setting]) -> Markup {
    let dwells = all.iter().map(|residual| residual.index + 1).max().unwrap_or(0).max(settings.len());
    let by_time: Vec<usize> = (0..dwells).collect();
    let mut by_attitude = by_time.clone();
    let key = |dwell: usize| settings.get(dwell).map(|one| (one.deg_per_s.is_some(), one.axis()));
    let rate = |dwell: usize| settings.get(dwell).and_then(|one| one.deg_per_s).unwrap_or(0.0);
    by_attitude.sort_by(|&a, &b| key(a).cmp(&key(b)).then(rate(a).total_cmp(&rate(b))));
    html! {
        (signed_map(t, all, slots, settings, &by_time))
        @if !settings.is_empty() && by_attitude != by_time {
            details { summary { (t.by_attitude) } (signed_map(t, all, slots, settings, &by_attitude)) }
        }
    }
}

/// What is above zero fills the upper half of a cell, what is below it the lower half; the shade is the residual over
/// its standard deviation. Under them the phases, the body axis that was up or turned about, and the rate. By time each
/// cell says what it is; once on a page is enough.
fn signed_map(t: &Text, all: &[ResidualBody], slots: &[String], settings: &[Setting], order: &[usize]) -> Markup {
    let cell = (WIDTH - LEFT - RIGHT) / order.len().max(1) as f64;
    let mut places = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, &dwell)| places[dwell] = place);
    let x = |dwell: usize| tenth(LEFT + cell * places[dwell] as f64);
    let wide = tenth((cell - 0.5).max(0.6));
    let phases = ROW * slots.len() as f64 + 4.0;
    let axes = phases + LANE;
    let foot = axes + 3.0 * LANE;
    let fastest = settings.iter().filter_map(|setting| setting.deg_per_s).fold(0.0, f64::max);
    let height = if settings.is_empty() { phases } else { foot + LANE } + LANE;
    let in_order: Vec<&Setting> = order.iter().filter_map(|&dwell| settings.get(dwell)).collect();
    let mut phases_from: Vec<(usize, usize, bool)> = Vec::new();
    for run in in_order.chunk_by(|a, b| a.deg_per_s.is_some() == b.deg_per_s.is_some()) {
        let from = phases_from.last().map_or(0, |(from, count, _)| from + count);
        phases_from.push((from, run.len(), run[0].deg_per_s.is_some()));
    }
    html! {
        div.scroll tabindex="0" { svg.dwells viewBox={ "0 0 " (WIDTH) " " (tenth(height)) } role="img" aria-label=(t.heat_map) {
            @for (line, slot) in slots.iter().enumerate() {
                @let middle = ROW * (line as f64 + 0.5);
                text x=(LEFT - 6.0) y=(tenth(middle + 4.0)) text-anchor="end" { (slot) }
                @for residual in all.iter().filter(|residual| residual.slot == *slot) {
                    @let ratio = if residual.sd_deg_per_h > 0.0 { residual.before_deg_per_h / residual.sd_deg_per_h } else { 0.0 };
                    @let (class, top) = if ratio < 0.0 { ("heat below", middle) } else { ("heat", middle - 0.5 * ROW + 2.0) };
                    rect class=(class) x=(x(residual.index)) y=(tenth(top)) width=(tenth(cell.max(0.6)))
                        height=(0.5 * ROW - 2.0) fill-opacity=(shade(ratio)) {
                        @if order.is_sorted() { title {
                            (slot) ", " (t.dwell) " " (residual.index)
                            @if let Some(setting) = settings.get(residual.index) { " (" (setting.said(t)) ")" }
                            ": " (format!("{ratio:+.1}")) " σ"
                        } }
                    }
                }
                line x1=(LEFT) x2=(WIDTH - RIGHT) y1=(middle) y2=(middle) {}
            }
            @for (from, count, turning) in phases_from {
                @let (class, name) = if turning { ("lane1", t.phase_rate) } else { ("lane0", t.phase_static) };
                @let (left, width) = (LEFT + cell * from as f64, cell * count as f64);
                rect class=(class) x=(tenth(left)) y=(phases) width=(tenth(width - 1.0)) height=(LANE - 3.0) {
                    title { (name) }
                }
                @if width > 44.0 {
                    text.own x=(tenth(left + 0.5 * width)) y=(phases + 11.0) text-anchor="middle" { (name) }
                }
            }
            @if !settings.is_empty() {
                @for (line, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
                    @let middle = axes + LANE * (line as f64 + 0.5);
                    text x=(LEFT - 6.0) y=(tenth(middle + 4.0)) text-anchor="end" { (axis) }
                    line x1=(LEFT) x2=(WIDTH - RIGHT) y1=(middle) y2=(middle) {}
                    @for (dwell, setting) in settings.iter().enumerate() {
                        @let along = setting.direction[line];
                        @if along.abs() > NEARLY {
                            @let size = along.abs() * (0.5 * LANE - 1.0);
                            rect.set x=(x(dwell)) y=(tenth(if along < 0.0 { middle } else { middle - size })) width=(wide) height=(tenth(size)) {}
                        }
                    }
                }
            }
            @if fastest > 0.0 {
                @let base = foot + LANE - 2.0;
                text x=(LEFT - 6.0) y=(tenth(base)) text-anchor="end" {
                    (format!("{fastest:.*} {}", usize::from(fastest < 1.0), t.unit_of("deg/s")))
                }
                @for (dwell, rate) in settings.iter().enumerate().filter_map(|(dwell, one)| Some((dwell, one.deg_per_s?))) {
                    @let size = (LANE - 4.0) * rate / fastest;
                    rect.set x=(x(dwell)) y=(tenth(base - size)) width=(wide) height=(tenth(size)) {}
                }
            }
            (key(t, order, height - 4.0))
        } }
    }
}

/// How many dwells there are, where they stand by time, and what the shades mean; on one line at `y`.
fn key(t: &Text, order: &[usize], y: f64) -> Markup {
    html! {
        @if order.is_sorted() {
            text x=(LEFT) y=(tenth(y)) { (t.dwell) " 0" }
            text x=(WIDTH - RIGHT) y=(tenth(y)) text-anchor="end" { (order.len().saturating_sub(1)) }
        }
        @for k in (-6_i32..=6).filter(|k| *k != 0) {
            @let top = if k < 0 { y - 4.0 } else { y - 10.0 };
            rect class={ "heat" @if k < 0 { " below" } } x=(tenth(0.5 * WIDTH + 14.0 * f64::from(k))) y=(tenth(top)) width="13" height="6"
                fill-opacity=(shade(f64::from(k))) {}
        }
        text x=(tenth(0.5 * WIDTH - 90.0)) y=(tenth(y)) text-anchor="end" { "-6 σ" }
        text x=(tenth(0.5 * WIDTH + 104.0)) y=(tenth(y)) { "+6 σ" }
    }
}

fn shade(ratio: f64) -> String {
    format!("{:.2}", (ratio.abs() / FULL_SHADE).min(1.0))
}

/// How much of the gap is closed, from 0 to 1, with its interval as a whisker.
pub(super) fn closure_bar(closure: f64, interval: Option<[f64; 2]>) -> Markup {
    let x = |share: f64| 2.0 + 156.0 * share.clamp(0.0, 1.0);
    html! {
        svg.closure viewBox="0 0 160 14" role="img" aria-label=(percent(closure)) {
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
    use crate::wire::campaign;
    use crate::words::Language;

    fn residual(index: usize, slot: &str, before: f64) -> ResidualBody {
        ResidualBody { index, slot: slot.into(), before_deg_per_h: before, after_deg_per_h: 0.0, sd_deg_per_h: 0.01 }
    }

    #[test]
    fn a_large_residual_is_dark_and_its_sign_is_where_it_stands() {
        let all = [residual(0, "G1", 0.0), residual(1, "G1", -0.12), residual(0, "G2", 0.03), residual(1, "G2", 0.0)];
        let map = signed_maps(Language::English.text(), &all, &["G1".into(), "G2".into()], &[]).into_string();
        let cells: Vec<&str> = map.split("<rect ").filter(|cell| cell.contains("<title>")).collect();
        assert_eq!(cells.len(), 4);
        // In the upper half of its row where it is above zero, in the lower one where it is below.
        assert!(cells[1].starts_with(r#"class="heat below" x="507.0" y="17.0""#), "{map}");
        assert!(cells[1].contains(r#"fill-opacity="1.00"><title>G1, dwell 1: -12.0 σ"#), "{map}");
        assert!(cells[2].starts_with(r#"class="heat" x="62.0" y="36.0""#), "{map}");
        assert!(cells[2].contains(r#"fill-opacity="0.50"><title>G2, dwell 0: +3.0 σ"#), "{map}");
    }

    #[test]
    fn under_the_map_stand_phases_directions_and_rates_and_the_same_by_attitude() {
        let campaign = campaign::parse_json(&std::fs::read("tests/data/practice/campaign-02.json").unwrap()).unwrap();
        let settings = Setting::of_all(&campaign);
        let faces: Vec<String> = settings.iter().map(Setting::axis).collect();
        for face in ["+X", "-X", "+Y", "-Y", "+Z", "-Z"] {
            assert!(faces.iter().any(|own| own == face), "{face} among {faces:?}");
        }
        let all: Vec<ResidualBody> = (0..settings.len()).map(|dwell| residual(dwell, "G1", 0.01)).collect();
        let maps = signed_maps(Language::English.text(), &all, &["G1".into()], &settings).into_string();
        let turning = settings.iter().filter(|setting| setting.deg_per_s.is_some()).count();
        let along = settings.iter().flat_map(|setting| setting.direction.iter()).filter(|x| x.abs() > NEARLY).count();
        assert!(turning > 0);
        let drawn: Vec<usize> = maps.split("<summary>").map(|map| map.matches("<rect class=\"set\"").count()).collect();
        assert_eq!(drawn, [turning + along; 2], "by time and by attitude");
        assert!(maps.contains(">static</text>") && maps.contains(">rate</text>") && !maps.contains("NaN"));
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
        let t = Language::English.text();
        let point = |k: i32| point(t, 0, f64::from(k), 0.002 * f64::from(k), 1e-4);
        let one = Evidence { name: "G1".into(), points: (-3..=3).map(point).collect(), slope: 0.002, unit: "K".into() };
        let drawn = evidence(t, &[one]).into_string();
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
        assert!(!signed_maps(Language::English.text(), &[], &[], &[]).into_string().contains("NaN"));
    }
}
