//! The report: the signals of a log with the intervals that were averaged, so that a person sees what the dwells are.

use std::fmt::Write;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::campaign::LogCampaign;
use super::gather::{LogSeries, Role};
use crate::core::dwells::blocks::{Series, Track};
use crate::words::Language;

const WIDTH: f64 = 1100.0;
const HEIGHT: f64 = 110.0;
/// Columns of a plot: each shows the least and the most of what it covers.
const PIECES: usize = 1100;

const STYLE: &str = "body{font:14px/1.4 system-ui,sans-serif;max-width:1160px;margin:2em auto;padding:0 1em;\
    color:#1b2733}table{border-collapse:collapse;font-variant-numeric:tabular-nums}td,th{padding:.15em .6em;\
    text-align:right;border-bottom:1px solid #d8dee4}svg{display:block;margin:.2em 0 1em;background:#f6f8fa}\
    h2{font-size:1.1em;margin:1.2em 0 .2em}.static{fill:#9cc4e4}.rate{fill:#f2c48d}";

/// One page that needs nothing else.
pub fn report(made: &LogCampaign, title: &str, language: Language) -> String {
    let page = html! {
        (DOCTYPE)
        html lang=(language.tag()) {
            head { meta charset="utf-8"; title { (title) } style { (STYLE) } }
            body {
                h1 { (title) }
                p { (made.body.imu) ", " (made.body.station) ", " (made.body.measured_at) }
                (shown(made, language))
            }
        }
    };
    page.into_string()
}

/// What was noticed, the intervals over the signals, and the dwells.
pub fn shown(made: &LogCampaign, language: Language) -> Markup {
    html! {
        ul { @for remark in &made.remarks { li { (language.words(remark)) } } }
        @if let Some(gathered) = &made.gathered {
            @for (class, code) in [("static", "static_dwells"), ("rate", "rate_dwells")] {
                svg width="16" height="10" { rect class=(class) width="16" height="10" {} }
                p { (language.word(code)) }
            }
            @for (role, track) in gathered.roles.iter().zip(&gathered.series.tracks) {
                @if let Some(name) = name(*role) { h2 { (name) } (plot(made, gathered, track)) }
            }
        }
        (table(made))
    }
}

fn name(role: Role) -> Option<String> {
    let axis = |k: usize| ["x", "y", "z"].get(k).copied().unwrap_or_default();
    Some(match role {
        Role::Raw(k) => format!("output {} (pulse/s)", k + 1),
        Role::Force(k) => format!("force {} (g0)", axis(k)),
        Role::Rate(k) => format!("rate {} (arcsec/s)", axis(k)),
        Role::Turn(k) => format!("table axis {} (arcsec/s)", k + 1),
        Role::Temperature => "temperature (deg C)".to_owned(),
        Role::Output(_) | Role::Cosine(_) | Role::Sine(_) | Role::Attitude(_) | Role::Spin(_) | Role::Interval => {
            return None;
        }
    })
}

fn plot(made: &LogCampaign, gathered: &LogSeries, track: &Track) -> Markup {
    let series = &gathered.series;
    let blocks = series.number.len();
    let (begin, end) = (series.start_s(0), series.end_s(blocks));
    let x = |time: f64| WIDTH * (time - begin) / (end - begin);
    let (least, most) = track.mean.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let range = if most > least { most - least } else { 1.0 };
    let y = |value: f64| HEIGHT - 4.0 - (HEIGHT - 8.0) * (value - least) / range;
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) width="100%" role="img" {
            @for dwell in &made.dwells {
                @let (from, to) = (x(dwell.start_s), x(dwell.start_s + dwell.duration_s));
                rect class=(dwell.commanded.phase.name()) y="0" height=(HEIGHT)
                    x=(format!("{from:.1}")) width=(format!("{:.1}", to - from)) {}
            }
            (PreEscaped(line(series, track, &x, &y)))
            text x="4" y="12" font-size="11" { (format!("{most:.6}")) }
            text x="4" y=(HEIGHT - 2.0) font-size="11" { (format!("{least:.6}")) }
            text x=(WIDTH - 4.0) y=(HEIGHT - 2.0) font-size="11" text-anchor="end" { (format!("{end:.0} s")) }
        }
    }
}

fn line(series: &Series, track: &Track, x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64) -> String {
    let blocks = track.mean.len();
    let step = blocks.div_ceil(PIECES).max(1);
    let mut path = String::from("<path fill=\"none\" stroke=\"#24445c\" stroke-width=\"1\" d=\"");
    for from in (0..blocks).step_by(step) {
        let piece = &track.mean[from..(from + step).min(blocks)];
        let (least, most) = piece.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let command = if from == 0 { 'M' } else { 'L' };
        let at = x(series.start_s(from));
        write!(path, "{command}{at:.1} {:.1}L{at:.1} {:.1}", y(least), y(most)).expect("a string takes everything");
    }
    path.push_str("\"/>");
    path
}

fn table(made: &LogCampaign) -> Markup {
    let figures =
        |values: &[f64], digits: usize| values.iter().map(|v| format!("{v:.digits$}")).collect::<Vec<_>>().join(", ");
    html! {
        table {
            tr { th { "#" } th { "phase" } th { "start_s" } th { "duration_s" } th { "specific_force_g0" }
                 th { "rate_arcsec_s" } th { "output_pulse_s" } th { "output_sem_pulse_s" } th { "temperature_c" } }
            @for (k, d) in made.dwells.iter().enumerate() {
                tr {
                    td { (k + 1) } td { (d.commanded.phase.name()) }
                    td { (figures(&[d.start_s], 1)) } td { (figures(&[d.duration_s], 1)) }
                    td { (figures(d.commanded.force_g0.as_slice(), 5)) } td { (figures(d.commanded.rate_arcsec_s.as_slice(), 3)) }
                    td { (figures(&d.output, 5)) } td { (figures(&d.output_sem, 5)) }
                    td { (d.temperature_c.map_or(String::new(), |t| figures(&[t], 2))) }
                }
            }
        }
    }
}
