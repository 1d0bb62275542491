//! A diagnosis, section by section: of its page, and of the report that `diagnose --report` writes.

use maud::{Markup, html};

use crate::core::effects::Effect;
use crate::pages::figure::{percent, short};
use crate::pages::text::Text;
use crate::pages::{figure, layout, residuals};
use crate::wire::diagnosis::{CandidateBody, DiagnosisBody, EffectBody, HeldOutBody};

/// Slot and serial of each gyro in `gyros`; `against`: the gap against a reference.
pub(super) fn of(t: &Text, d: &DiagnosisBody, gyros: &[(String, String)], against: &Markup) -> Markup {
    html! {
        (summary(t, d))
        (effects(t, d))
        (against)
        (located(t, d, gyros))
        (candidates(t, &d.candidates))
        (impact(t, d))
        (before_and_after(t, d, gyros))
        (blind_spots(t, d))
        (next(t, d))
        @if !d.notes.is_empty() { section { h2 { (t.notes) } ul { @for note in &d.notes { li { (note) } } } } }
    }
}

fn summary(t: &Text, d: &DiagnosisBody) -> Markup {
    let gap = |rms: f64, chi2: f64, p: f64| html! { td.n { (short(rms)) } td.n { (short(chi2)) } td.n { (short(p)) } };
    html! {
        p.lead { strong { (d.verdict_in_words(t.language())) } }
        div.scroll tabindex="0" { table {
            thead { tr { th {} th.n { "rms, deg/h" } th.n { "χ²/ν" } th.n { (t.adjusted_p) } } }
            tbody {
                tr { th scope="row" { (t.gap_before) } (gap(d.gap.rms_deg_per_h, d.gap.reduced_chi2, d.gap.p_value)) }
                tr {
                    th scope="row" { (t.noise_alone) } td.n { (short(d.gap.noise_alone_deg_per_h)) } td colspan="2" {}
                }
                tr {
                    th scope="row" { (t.gap_after) }
                    (gap(d.remaining.rms_deg_per_h, d.remaining.reduced_chi2, d.remaining.p_value))
                }
                tr { th scope="row" { (t.model_in_use) } td colspan="3" { code translate="no" { (d.model.listed()) } } }
                tr {
                    th scope="row" { (t.noise_floor) } td.n { (short(d.noise_floor.deg_per_h)) }
                    td.quiet colspan="2" { (t.noise_source(&d.noise_floor.source)) }
                }
            }
        } }
        @for sign in &d.remaining.signs {
            p { (t.sign_of_more) ": " (t.sign(&sign.kind)) " (" (sign.gyros.join(", ")) "), p = " (short(sign.p_value)) }
        }
    }
}

/// An effect by its name in words, with the identifier that the interface uses.
fn named(t: &Text, id: &str) -> Markup {
    html! { @if let Some(effect) = Effect::from_id(id) { (t.effect(effect)) " " } code.quiet { (id) } }
}

fn effects(t: &Text, d: &DiagnosisBody) -> Markup {
    html! {
        section {
            h2 { (t.what_parts_them) }
            @if d.effects.is_empty() { p { (t.no_effect) } }
            @for effect in &d.effects { (one_effect(t, effect)) }
            @if let Some(all) = d.closure.as_ref().filter(|_| d.effects.len() > 1) {
                p.note { (t.in_order) }
                p { (t.all_together) ": " } (closure(t, all))
            }
        }
    }
}

fn one_effect(t: &Text, effect: &EffectBody) -> Markup {
    html! {
        article.effect {
            h3 { (named(t, &effect.effect)) " · " (effect.gyros.join(", ")) }
            @if let Some(entry) = Effect::from_id(&effect.effect).map(Effect::entry) {
                p.note { code { (entry.equation) } }
            }
            (closure(t, &effect.held_out))
            p.note {
                (t.adjusted_p) " " (short(effect.p_value_adjusted)) " · " (t.detectability) " " (short(effect.detectability))
            }
            @if effect.class.len() > 1 { p { strong { (t.cannot_tell_from) } " " (others(t, effect, &effect.class)) } }
            @for wider in &effect.wider_in {
                p { strong { (wider.slot) " " (t.alone_cannot_tell_from) } " " (others(t, effect, &wider.class)) }
            }
            div.scroll tabindex="0" { table {
                thead { tr { th { (t.serial) } th { (t.parameter) } th.n { (t.value) } th { (t.unit_word) } } }
                tbody { @for estimate in &effect.estimates {
                    tr {
                        td { (if estimate.slot == "all" { t.all_gyros } else { &estimate.slot }) } td { (estimate.name) }
                        td.n { (figure::with_sd(estimate.value, Some(estimate.sd), 6)) } td { (estimate.unit) }
                    }
                } }
            } }
        }
    }
}

/// A class without the effect itself.
fn others(t: &Text, effect: &EffectBody, class: &[String]) -> Markup {
    let others = class.iter().filter(|id| **id != effect.effect).enumerate();
    html! { @for (i, id) in others { @if i > 0 { "; " } (named(t, id)) } }
}

/// How far the error of dwells that were held out shrinks.
fn closure(t: &Text, held_out: &HeldOutBody) -> Markup {
    let [low, high] = held_out.interval;
    html! {
        p {
            (residuals::closure_bar(held_out.closure, Some(held_out.interval)))
            strong { (percent(held_out.closure)) } " (" (percent(low)) " – " (percent(high)) ") "
            (t.held_out) " " (short(held_out.before_deg_per_h)) " → " (short(held_out.after_deg_per_h)) " deg/h"
        }
    }
}

fn located(t: &Text, d: &DiagnosisBody, slots: &[(String, String)]) -> Markup {
    let names: Vec<String> = slots.iter().map(|(slot, _)| slot.clone()).collect();
    let serial = |slot: &str| slots.iter().find(|(name, _)| name == slot).map_or("", |(_, serial)| serial.as_str());
    html! {
        section {
            h2 { (t.located) }
            p.note { (t.heat_note) }
            (residuals::heat_map(t, &d.residuals, &names))
            div.scroll tabindex="0" { table {
                thead { tr { th { (t.place) } th.n { (t.share) } } }
                tbody {
                    @for gyro in &d.located.gyros { tr { td { (gyro.slot) " " (serial(&gyro.slot)) } td.n { (percent(gyro.share)) } } }
                    @for phase in &d.located.phases { tr { td { (t.phase(&phase.phase)) } td.n { (percent(phase.share)) } } }
                    @for dwell in &d.located.dwells {
                        tr {
                            td { (t.dwell) " " (dwell.index) ", " (dwell.slot) ": " (short(dwell.residual_deg_per_h)) " deg/h" }
                            td.n { (percent(dwell.share)) }
                        }
                    }
                }
            } }
        }
    }
}

fn candidates(t: &Text, all: &[CandidateBody]) -> Markup {
    html! {
        @if !all.is_empty() {
            section {
                h2 { (t.what_else) }
                div.scroll tabindex="0" { table {
                    thead { tr { th { (t.effect) } th { (t.serial) } th { (t.closes_alone) } th.n { (t.adjusted_p) } th { (t.why_not) } } }
                    tbody { @for candidate in all {
                        tr {
                            td.words { (named(t, &candidate.effect)) } td { (candidate.gyros.join(", ")) }
                            td.nowrap {
                                @if candidate.closure.is_some() && candidate.within_noise {
                                    (t.within_noise)
                                } @else if let Some(closure) = candidate.closure {
                                    (residuals::closure_bar(closure, candidate.interval)) (percent(closure))
                                    @if let Some([low, high]) = candidate.interval { " (" (percent(low)) " – " (percent(high)) ")" }
                                } @else { "–" }
                            }
                            td.n { (short(candidate.p_value_adjusted)) } td.words { (candidate.why_not) }
                        }
                    } }
                } }
            }
        }
    }
}

fn impact(t: &Text, d: &DiagnosisBody) -> Markup {
    let coefficients = d.drift_before_and_after();
    html! {
        @if !coefficients.is_empty() {
            section {
                h2 { (t.impact) }
                @if d.impact.is_empty() { p { (t.impact_within_noise) } }
                div.scroll tabindex="0" { table {
                    thead { tr {
                        th { (t.serial) } th {} th.n { (t.plain) } th.n { (t.with_effects) } th.n { (t.shift) } th.n { (t.of_budget) }
                    } }
                    tbody { @for (one, moved) in coefficients {
                        @let sd = Some(one.augmented_sd);
                        tr {
                            td { (one.slot) } td { (layout::symbol(&one.coefficient)) }
                            td.n { (figure::with_sd(one.plain, sd, 6)) } td.n { (figure::with_sd(one.augmented, sd, 6)) }
                            td.n { (format!("{:+.*}", figure::places_beside(sd, 6), one.shift)) }
                            td.n { @if moved { (percent(one.of_budget)) } @else { (t.within_noise) } }
                        }
                    } }
                } }
                p.note { (t.unit) }
            }
        }
    }
}

fn before_and_after(t: &Text, d: &DiagnosisBody, slots: &[(String, String)]) -> Markup {
    html! {
        section {
            h2 { (t.how_far) }
            p.note { (t.before_after_note) }
            @let extent = residuals::extent(d.residuals.iter().flat_map(|one| [&one.before_deg_per_h, &one.after_deg_per_h]));
            @for (slot, serial) in slots {
                h3 { (slot) " " (serial) }
                (residuals::before_and_after(t, &d.residuals, slot, extent))
            }
        }
    }
}

fn blind_spots(t: &Text, d: &DiagnosisBody) -> Markup {
    html! {
        @if !d.not_identifiable.is_empty() {
            section {
                h2 { (t.cannot_be_told) }
                div.scroll tabindex="0" { table {
                    thead { tr { th { (t.effect) } th.n { (t.visible) } th { (t.why) } th { (t.would_show) } } }
                    tbody { @for one in &d.not_identifiable {
                        tr {
                            td.words { (named(t, &one.effect)) } td.n { (percent(one.visible_fraction)) }
                            td.words { (one.reason) } td.words { (one.needs) }
                        }
                    } }
                } }
            }
        }
    }
}

fn next(t: &Text, d: &DiagnosisBody) -> Markup {
    let three = |v: [f64; 3], decimals: usize| v.map(|x| format!("{x:.decimals$}")).join(", ");
    html! {
        @if !d.next_dwells.is_empty() {
            section {
                h2 { (t.measure_next) }
                div.scroll tabindex="0" { table {
                    thead { tr { th { (t.phase_word) } th { (t.specific_force) ", g0" } th { (t.rate_word) ", arcsec/s" } th { (t.separates) } } }
                    tbody { @for dwell in &d.next_dwells {
                        tr {
                            td { (t.phase(&dwell.phase)) } td.n { (three(dwell.specific_force_g0, 4)) }
                            td.n { (three(dwell.rate_arcsec_s, 1)) }
                            td.words { @for (i, id) in dwell.separates.iter().enumerate() { @if i > 0 { "; " } (named(t, id)) } }
                        }
                    } }
                } }
            }
        }
    }
}
