//! Small plots as inline SVG. Shapes carry the meaning as well as colours do.

use std::fmt::Write;

use crate::wire::diagnosis::ResidualBody;

const WIDTH: f64 = 920.0;
const HEIGHT: f64 = 200.0;
const LEFT: f64 = 62.0;
const BOTTOM: f64 = 24.0;
/// Residuals of so many standard uncertainties are shown at full shade.
const FULL_SHADE: f64 = 6.0;

/// A bar from 0 to 1, with an interval drawn as a whisker.
pub(super) fn bar(value: f64, interval: Option<[f64; 2]>) -> String {
    let x = |v: f64| 2.0 + 156.0 * v.clamp(0.0, 1.0);
    let mut svg = format!(
        "<svg class=\"bar\" viewBox=\"0 0 160 14\" role=\"img\" aria-label=\"{value:.2}\">\
         <rect x=\"2\" y=\"3\" width=\"156\" height=\"8\" fill=\"none\" stroke=\"#888\"/>\
         <rect x=\"2\" y=\"3\" width=\"{:.1}\" height=\"8\" fill=\"#0072b2\"/>",
        x(value) - 2.0
    );
    if let Some([low, high]) = interval {
        let (a, b) = (x(low), x(high));
        push(
            &mut svg,
            format_args!("<path d=\"M{a:.1} 7H{b:.1}M{a:.1} 1V13M{b:.1} 1V13\" stroke=\"#d55e00\" fill=\"none\"/>"),
        );
    }
    svg + "</svg>"
}

/// One gyro's residuals against the dwell's index: before (hollow), after (filled), and the band of two sigma.
pub(super) fn residuals(all: &[ResidualBody], slot: &str) -> String {
    let own: Vec<&ResidualBody> = all.iter().filter(|r| r.slot == slot).collect();
    let Some(last) = own.iter().map(|r| r.index).max() else { return String::new() };
    let extent = own
        .iter()
        .flat_map(|r| [r.before_deg_per_h.abs(), r.after_deg_per_h.abs(), 2.0 * r.sd_deg_per_h])
        .fold(f64::MIN_POSITIVE, f64::max)
        * 1.05;
    let x = |index: usize| LEFT + (WIDTH - LEFT - 8.0) * (index as f64 + 0.5) / (last + 1) as f64;
    let y = |value: f64| (HEIGHT - BOTTOM) / 2.0 * (1.0 - value / extent) + 4.0;
    let mut svg =
        format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"residuals of {slot} by dwell\">");
    for r in &own {
        let (top, bottom) = (y(2.0 * r.sd_deg_per_h), y(-2.0 * r.sd_deg_per_h));
        let width = (WIDTH - LEFT - 8.0) / (last + 1) as f64;
        push(
            &mut svg,
            format_args!(
                "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{width:.2}\" height=\"{:.1}\" fill=\"#888\" fill-opacity=\".18\"/>",
                x(r.index) - width / 2.0,
                bottom - top
            ),
        );
    }
    for value in [-extent / 1.05, 0.0, extent / 1.05] {
        let at = y(value);
        push(
            &mut svg,
            format_args!(
                "<path d=\"M{LEFT} {at:.1}H{}\" stroke=\"#8886\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                WIDTH - 8.0,
                LEFT - 4.0,
                at + 4.0,
                super::figure(value)
            ),
        );
    }
    for r in &own {
        let at = x(r.index);
        push(
            &mut svg,
            format_args!(
                "<circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"3.2\" fill=\"none\" stroke=\"#d55e00\"/>\
                 <circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"2\" fill=\"#0072b2\"><title>dwell {}: {} before, {} after</title></circle>",
                y(r.before_deg_per_h),
                y(r.after_deg_per_h),
                r.index,
                super::figure(r.before_deg_per_h),
                super::figure(r.after_deg_per_h)
            ),
        );
    }
    push(&mut svg, format_args!("<text x=\"{LEFT}\" y=\"{}\">dwell 0</text>", HEIGHT - 6.0));
    push(
        &mut svg,
        format_args!(
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">dwell {last} (deg/h)</text>",
            WIDTH - 8.0,
            HEIGHT - 6.0
        ),
    );
    svg + "</svg>"
}

/// Gyros down, dwells across; a cell's shade is |residual| over its standard uncertainty.
pub(super) fn heat_map(all: &[ResidualBody], slots: &[&str]) -> String {
    let Some(last) = all.iter().map(|r| r.index).max() else { return String::new() };
    let (row, cell) = (22.0, (WIDTH - LEFT - 8.0) / (last + 1) as f64);
    let height = row * slots.len() as f64;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"residual over uncertainty, gyro by dwell\">"
    );
    for (line, slot) in slots.iter().enumerate() {
        let top = row * line as f64;
        push(
            &mut svg,
            format_args!("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{slot}</text>", LEFT - 4.0, top + 15.0),
        );
        for r in all.iter().filter(|r| r.slot == *slot) {
            let ratio = if r.sd_deg_per_h > 0.0 { r.before_deg_per_h.abs() / r.sd_deg_per_h } else { 0.0 };
            push(
                &mut svg,
                format_args!(
                    "<rect x=\"{:.1}\" y=\"{}\" width=\"{:.2}\" height=\"{}\" fill=\"#d55e00\" fill-opacity=\"{:.2}\">\
                     <title>{slot}, dwell {}: {ratio:.1} sigma</title></rect>",
                    LEFT + cell * r.index as f64,
                    top + 1.0,
                    cell,
                    row - 2.0,
                    (ratio / FULL_SHADE).min(1.0),
                    r.index
                ),
            );
        }
    }
    svg + "</svg>"
}

fn push(svg: &mut String, piece: std::fmt::Arguments<'_>) {
    svg.write_fmt(piece).expect("writing to a String cannot fail");
}
