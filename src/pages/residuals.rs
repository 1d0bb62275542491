//! Residuals dwell by dwell, and gyro by dwell, as pictures without a script.

use maud::{Markup, html};

use super::text::Text;
use crate::wire::diagnosis::ResidualBody;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 8.0;
/// Residuals of so many standard deviations are shown at full shade.
const FULL_SHADE: f64 = 6.0;

fn tenth(value: f64) -> String {
    format!("{value:.1}")
}

/// Residuals over their own standard deviations; two of them to either side are a band.
pub(super) fn strip(t: &Text, standardised: &[f64]) -> Markup {
    let points: Vec<_> = standardised.iter().enumerate().map(|(dwell, &value)| (dwell, value)).collect();
    picture(t.residuals_by_dwell, "σ", &[(&points, "dot")], Some(2.0))
}

/// One gyro of a diagnosis, deg/h: hollow before, filled with the named effects added.
pub(super) fn before_and_after(t: &Text, all: &[ResidualBody], slot: &str) -> Markup {
    let own = || all.iter().filter(|residual| residual.slot == slot);
    let before: Vec<_> = own().map(|r| (r.index, r.before_deg_per_h)).collect();
    let after: Vec<_> = own().map(|r| (r.index, r.after_deg_per_h)).collect();
    let sd = own().map(|r| r.sd_deg_per_h).sum::<f64>() / own().count().max(1) as f64;
    picture(t.residuals_by_dwell, "deg/h", &[(&before, "hollow"), (&after, "dot")], Some(2.0 * sd))
}

/// Series of (dwell, value), each with its class; a band from -band to band.
fn picture(label: &str, unit: &str, series: &[(&[(usize, f64)], &str)], band: Option<f64>) -> Markup {
    let all = || series.iter().flat_map(|(points, _)| points.iter());
    let dwells = all().map(|(dwell, _)| dwell + 1).max().unwrap_or(1);
    let extent = all().map(|(_, value)| value.abs()).chain(band).fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let x = |dwell: usize| LEFT + (WIDTH - LEFT - RIGHT) * (dwell as f64 + 0.5) / dwells as f64;
    let y = |value: f64| (HEIGHT - 20.0) / 2.0 * (1.0 - value / extent) + 2.0;
    let marked = extent / 1.08;
    html! {
        svg.dwells viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(label) {
            @if let Some(band) = band {
                rect.band x=(LEFT) y=(tenth(y(band))) width=(WIDTH - LEFT - RIGHT) height=(tenth(y(-band) - y(band))) {}
            }
            @for value in [-marked, 0.0, marked] {
                line x1=(LEFT) x2=(WIDTH - RIGHT) y1=(tenth(y(value))) y2=(tenth(y(value))) {}
                text x=(LEFT - 4.0) y=(tenth(y(value) + 4.0)) text-anchor="end" { (super::figure::short(value)) }
            }
            @for (points, class) in series {
                @for &(dwell, value) in *points {
                    circle class=(class) cx=(tenth(x(dwell))) cy=(tenth(y(value))) r="3" {
                        title { (dwell) ": " (super::figure::short(value)) " " (unit) }
                    }
                }
            }
            text x=(LEFT) y=(HEIGHT - 3.0) { "0" }
            text x=(WIDTH - RIGHT) y=(HEIGHT - 3.0) text-anchor="end" { (dwells - 1) " · " (unit) }
        }
    }
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
    fn nothing_to_draw_is_no_trouble() {
        assert!(!strip(Language::English.text(), &[]).into_string().contains("NaN"));
        assert!(!heat_map(Language::English.text(), &[], &[]).into_string().contains("NaN"));
    }
}
