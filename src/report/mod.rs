//! A diagnosis as one HTML file that needs nothing else: no script, no font, no network. It can be mailed, printed
//! and filed with the campaign.

mod plot;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::wire::diagnosis::{CandidateBody, DiagnosisBody, EffectBody, HeldOutBody, ImpactBody};
use crate::wire::split::SplitBody;

/// Whose campaign it is, in words for the head of the report.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    pub imu: String,
    pub station: String,
    pub measured_at: String,
    pub dwells: usize,
    /// Slot and serial of each gyro.
    pub gyros: Vec<(String, String)>,
}

/// The whole report as an HTML document.
pub fn html(subject: &Subject, diagnosis: &DiagnosisBody) -> String {
    let title = format!("Diagnosis of {} at {}", subject.imu, subject.measured_at);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                (head(subject, diagnosis))
                @if let Some(split) = &diagnosis.reference { (reference(split)) }
                (effects(diagnosis))
                (residuals(subject, diagnosis))
                (located(diagnosis))
                (candidates(&diagnosis.candidates))
                (impact(diagnosis))
                (blind_spots(diagnosis))
                (next(diagnosis))
                (notes(&diagnosis.notes))
            }
        }
    }
    .into_string()
}

/// The verdict in a sentence or two.
pub fn verdict_in_words(d: &DiagnosisBody) -> String {
    let verdict = match d.verdict.as_str() {
        "no_gap" => "The model predicts this campaign to within its noise: there is no gap, and nothing to explain.",
        "explained" => "There is a gap; what is named below explains it, and nothing significant remains.",
        "partly_explained" => {
            "There is a gap; what is named below explains part of it, and something significant remains."
        }
        _ => "There is a gap, and nothing in the catalogue earns the blame.",
    };
    if d.stands_out_by_pattern() { format!("{verdict} {BY_PATTERN}") } else { verdict.to_owned() }
}

/// Of a gap that is no larger than what noise alone would leave.
const BY_PATTERN: &str = "As a whole the residuals are no larger than noise alone would leave them: the gap stands out by its \
                          pattern over the dwells, not by its size.";

/// The error model in use in words: its terms, and the effects that it holds beside them.
pub fn model_in_words(d: &DiagnosisBody) -> String {
    let beside = d.model.effects.iter().map(|e| format!("{} ({})", e.effect, e.gyros.join(" ")));
    let effects: Vec<String> = beside.collect();
    let terms = d.model.terms.join(", ");
    if effects.is_empty() { terms } else { format!("{terms}; effects {}", effects.join(", ")) }
}

/// D_I and D_S of every gyro before and after the named effects entered the model, in order, and whether they moved beyond their noise.
pub fn drift_before_and_after(d: &DiagnosisBody) -> Vec<(&ImpactBody, bool)> {
    let moved = d.impact.iter().map(|one| (one, true));
    let mut all: Vec<_> = moved.chain(d.impact_within_noise.iter().map(|one| (one, false))).collect();
    all.sort_by_key(|(one, _)| (one.slot.as_str(), one.coefficient.as_str()));
    all
}

fn head(subject: &Subject, d: &DiagnosisBody) -> Markup {
    html! {
        p class="verdict" { strong { (d.verdict) } ": " (verdict_in_words(d)) }
        table {
            tr { th { "Station" } td { (subject.station) } }
            tr { th { "Gyros" } td {
                @for (i, (slot, serial)) in subject.gyros.iter().enumerate() { @if i > 0 { ", " } (slot) " " (serial) }
            } }
            tr { th { "Dwells" } td { (subject.dwells) } }
            tr { th { "Model in use" } td { (model_in_words(d)) } }
            tr { th { "Noise floor" } td {
                (figure(d.noise_floor.deg_per_h)) " deg/h, from " (d.noise_floor.source)
                ", real over stated standard errors " (figure(d.noise_floor.sem_factor))
            } }
            tr { th { "Gap before" } td {
                (figure(d.gap.rms_deg_per_h)) " deg/h rms, where noise alone would leave "
                (figure(d.gap.noise_alone_deg_per_h)) "; reduced chi-square " (figure(d.gap.reduced_chi2))
                ", adjusted p of all tests " (figure(d.gap.p_value))
            } }
            tr { th { "Left after" } td {
                (figure(d.remaining.rms_deg_per_h)) " deg/h rms, reduced chi-square " (figure(d.remaining.reduced_chi2))
                ", adjusted p of all tests " (figure(d.remaining.p_value))
            } }
            @for sign in &d.remaining.signs {
                tr { th { "Sign of more" } td { (sign.kind) " in " (sign.gyros.join(", ")) ", p = " (figure(sign.p_value)) } }
            }
        }
    }
}

/// The gap against a reference, in its three parts.
fn reference(split: &SplitBody) -> Markup {
    let rows = [("all", &split.all)].into_iter().chain(split.gyros.iter().map(|g| (g.slot.as_str(), &g.parts)));
    html! {
        h2 { "Against the reference" }
        p { (split.imu) ", measured by " (split.station) " at " (split.measured_at)
            ". Root mean squares over dwells, deg/h; the squares of the parts add up." }
        table {
            thead { tr { th { "Gyro" } th { "Gap" } th { "Parameters" } th { "Structure" } th { "Noise" } th { "p, parameters" } } }
            tbody { @for (slot, p) in rows {
                tr { td { (slot) }
                    @for x in [p.whole_deg_per_h, p.parameters_deg_per_h, p.structure_deg_per_h, p.noise_deg_per_h, p.p_value] {
                        td class="n" { (figure(x)) }
                    }
                }
            } }
        }
        table {
            thead { tr { th { "Gyro" } th { "Coefficient" } th { "Reference" } th { "Now" } th { "Shift" } th { "1 sigma" } th { "Unit" } } }
            tbody { @for m in &split.moved {
                tr { td { (m.slot) } td { (m.coefficient) } td class="n" { (format!("{:.6}", m.reference)) }
                    td class="n" { (format!("{:.6}", m.now)) } td class="n" { (figure(m.shift)) }
                    td class="n" { @if let Some(sd) = m.sd { (figure(sd)) } @else { "-" } } td { (m.unit) } }
            } }
        }
        (notes(&split.notes))
    }
}

fn effects(d: &DiagnosisBody) -> Markup {
    html! {
        h2 { "What parts them" }
        @if d.effects.is_empty() { p { "No effect is named." } }
        @for effect in &d.effects { (one_effect(effect)) }
        @if let Some(all) = d.closure.as_ref().filter(|_| d.effects.len() > 1) {
            p { "Each closes of what those above it have left: their closures do not compare, their detectabilities do." }
            p { "All together: " (closure(all)) }
        }
    }
}

fn one_effect(effect: &EffectBody) -> Markup {
    html! {
        h3 { (effect.effect) " in " (effect.gyros.join(", ")) }
        @if effect.class.len() > 1 {
            p { "This campaign cannot tell it from: " (effect.class.iter().filter(|id| **id != effect.effect).cloned().collect::<Vec<_>>().join(", ")) "." }
        }
        @for wider in &effect.wider_in {
            p { (wider.slot) " alone cannot tell it from: " (wider.class.iter().filter(|id| **id != effect.effect).cloned().collect::<Vec<_>>().join(", ")) "." }
        }
        p { (closure(&effect.held_out)) " Adjusted p = " (figure(effect.p_value_adjusted)) ", detectability " (figure(effect.detectability)) "." }
        table {
            thead { tr { th { "Gyro" } th { "Parameter" } th { "Value" } th { "1 sigma" } th { "Unit" } } }
            tbody { @for e in &effect.estimates {
                tr { td { (e.slot) } td { (e.name) } td class="n" { (figure(e.value)) } td class="n" { (figure(e.sd)) } td { (e.unit) } }
            } }
        }
    }
}

fn closure(h: &HeldOutBody) -> Markup {
    html! {
        "On dwells that were held out the error falls from " (figure(h.before_deg_per_h)) " to "
        (figure(h.after_deg_per_h)) " deg/h; it closes " (figure(h.closure)) " of the reducible gap (95 % interval " (figure(h.interval[0]))
        " to " (figure(h.interval[1])) ") "
        (PreEscaped(plot::bar(h.closure, Some(h.interval))))
    }
}

fn residuals(subject: &Subject, d: &DiagnosisBody) -> Markup {
    html! {
        h2 { "Residual of each dwell" }
        p { "Hollow: after the fit of the model in use. Filled: with the named effects added. Grey band: two standard uncertainties of a dwell." }
        @for (slot, serial) in &subject.gyros {
            h3 { (slot) " " (serial) }
            (PreEscaped(plot::residuals(&d.residuals, slot)))
        }
        h3 { "Gyro by dwell" }
        p { "Shade: residual before over its standard uncertainty; full at six." }
        (PreEscaped(plot::heat_map(&d.residuals, &subject.gyros.iter().map(|g| g.0.as_str()).collect::<Vec<_>>())))
    }
}

fn located(d: &DiagnosisBody) -> Markup {
    html! {
        h2 { "Where" }
        table {
            thead { tr { th { "Place" } th { "Share of the gap" } } }
            tbody {
                @for g in &d.located.gyros { tr { td { (g.slot) } td class="n" { (percent(g.share)) } } }
                @for p in &d.located.phases { tr { td { (p.phase) } td class="n" { (percent(p.share)) } } }
                @for w in &d.located.dwells {
                    tr { td { "dwell " (w.index) ", " (w.slot) " (" (figure(w.residual_deg_per_h)) " deg/h)" } td class="n" { (percent(w.share)) } }
                }
            }
        }
    }
}

fn candidates(all: &[CandidateBody]) -> Markup {
    html! {
        h2 { "What else was tried" }
        table {
            thead { tr { th { "Effect" } th { "Gyros" } th { "Closes alone, of the reducible gap" } th { "" } th { "Adjusted p" } th { "Why it was not taken" } } }
            tbody { @for c in all {
                tr {
                    td { (c.effect) } td { (c.gyros.join(", ")) }
                    td class="n" {
                        @match c.closure { None => "-", Some(_) if c.within_noise => "within the noise", Some(x) => (percent(x)) }
                    }
                    td { @if let Some(x) = c.closure.filter(|_| !c.within_noise) { (PreEscaped(plot::bar(x, c.interval))) } }
                    td class="n" { (figure(c.p_value_adjusted)) } td { (c.why_not) }
                }
            } }
        }
    }
}

fn impact(d: &DiagnosisBody) -> Markup {
    html! {
        @if !(d.impact.is_empty() && d.impact_within_noise.is_empty()) {
            h2 { "What it does to the drift coefficients" }
            p { "Before and after the named effects entered the model, deg/(h g0)." }
            table {
                thead { tr { th { "Gyro" } th { "Coefficient" } th { "Before" } th { "After" } th { "1 sigma" } th { "Shift" } th { "Of the budget" } th { "Moved" } } }
                tbody { @for (i, moved) in drift_before_and_after(d) {
                    tr {
                        td { (i.slot) } td { (i.coefficient) } td class="n" { (format!("{:.6}", i.plain)) }
                        td class="n" { (format!("{:.6}", i.augmented)) } td class="n" { (figure(i.augmented_sd)) }
                        td class="n" { (format!("{:+.6}", i.shift)) } td class="n" { (percent(i.of_budget)) }
                        td { (moved_in_words(moved)) }
                    }
                } }
            }
        }
    }
}

/// Whether a coefficient moved.
pub fn moved_in_words(moved: bool) -> &'static str {
    if moved { "yes" } else { "no: within its noise" }
}

fn blind_spots(d: &DiagnosisBody) -> Markup {
    html! {
        @if !d.not_identifiable.is_empty() {
            h2 { "What this campaign cannot tell" }
            table {
                thead { tr { th { "Effect" } th { "Visible" } th { "Why" } th { "What would show it" } } }
                tbody { @for n in &d.not_identifiable {
                    tr { td { (n.effect) } td class="n" { (percent(n.visible_fraction)) } td { (n.reason) } td { (n.needs) } }
                } }
            }
        }
    }
}

fn next(d: &DiagnosisBody) -> Markup {
    html! {
        @if !d.next_dwells.is_empty() {
            h2 { "What to measure next" }
            table {
                thead { tr { th { "Phase" } th { "Specific force, g0" } th { "Rate, arcsec/s" } th { "Separates" } } }
                tbody { @for n in &d.next_dwells {
                    tr { td { (n.phase) } td class="n" { (triple(n.specific_force_g0, 4)) } td class="n" { (triple(n.rate_arcsec_s, 1)) } td { (n.separates.join(", ")) } }
                } }
            }
        }
    }
}

fn notes(notes: &[String]) -> Markup {
    html! {
        @if !notes.is_empty() {
            h2 { "Notes" }
            ul { @for note in notes { li { (note) } } }
        }
    }
}

/// Three significant digits, without an exponent where a person would not write one.
fn figure(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-4..1e5).contains(&size) {
        format!("{x:.2e}")
    } else {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    }
}

fn percent(x: f64) -> String {
    format!("{:.0} %", 100.0 * x)
}

fn triple(v: [f64; 3], digits: usize) -> String {
    v.map(|x| format!("{x:.digits$}")).join(", ")
}

const STYLE: &str = "\
:root{color-scheme:light dark}body{font:16px/1.45 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem}\
table{border-collapse:collapse;margin:.5rem 0}th,td{padding:.15rem .6rem;text-align:left;vertical-align:top;\
border-bottom:1px solid #8884}td.n{text-align:right;font-variant-numeric:tabular-nums}.verdict{font-size:1.15rem}\
svg{max-width:100%;height:auto}svg.bar{width:160px;vertical-align:middle}svg text{fill:currentColor;font-size:11px}\
@media print{h2{break-after:avoid}table,svg{break-inside:avoid}}";

#[cfg(test)]
mod tests;
