//! A diagnosis, section by section: of its page, and of the report that `diagnose --report` writes.

use crate::core::effects::{Effect, regressor_unit};
use crate::pages::figure::{percent, short};
use crate::pages::layout::{effect_named, effect_word, joined};
use crate::pages::prelude::*;
use crate::pages::residuals::Setting;
use crate::pages::{figure, forecast, layout, residuals};
use crate::wire::diagnosis::{
    CandidateBody, DiagnosisBody, EffectBody, EstimateBody, HeldOutBody, ImpactBody, TableBody,
};

/// Slot and serial of each gyro in `gyros`; how each dwell was set; `against`: the gap against a reference.
pub(super) fn of(
    t: &Text,
    d: &DiagnosisBody,
    (gyros, settings): (&[(String, String)], &[Setting]),
    against: &Markup,
) -> Markup {
    html! {
        (summary(t, d))
        (impact(t, d))
        (effects(t, d, gyros))
        (against)
        (forecast::of_campaign(t, d.forecast.as_ref(), d.effects_against_model.as_ref()))
        (located(t, d, gyros, settings))
        (before_and_after(t, d, gyros))
        (next(t, d))
        (candidates(t, d))
        (blind_spots(t, d))
        @if !d.notes.is_empty() { section { h2 { (t.notes) } ul { @for note in &d.notes { li { (note) } } } } }
    }
}

/// What was found with its size, the way from the gap to the noise, and what it does to D_I and D_S.
fn summary(t: &Text, d: &DiagnosisBody) -> Markup {
    html! {
        p.lead { strong { (d.verdict_in_words(t.language())) } }
        (found(t, d))
        p.lead { (consequence(t, d)) }
        (beside(t, d))
        (ladder(t, d))
        p.note {
            (t.gap_word) " " (short(d.gap.rms_deg_per_h)) " " (t.rate_unit)
            " · " (t.noise_floor) " " (short(d.noise_floor.deg_per_h)) " " (t.rate_unit) ", " (t.noise_source(&d.noise_floor.source))
            " · χ²/ν " (short(d.gap.reduced_chi2)) " → " (short(d.remaining.reduced_chi2))
            " · " (t.adjusted_p) " " (short(d.gap.p_value)) " → " (short(d.remaining.p_value))
            " · " (t.model_in_use) " " code translate="no" { (d.model.listed()) }
        }
        @for sign in &d.remaining.signs {
            p { (t.sign_of_more) ": " (sign.in_words(t.language())) " (" (sign.gyros.join(", ")) "), p = " (short(sign.p_value)) }
        }
    }
}

/// What was named, with its sizes.
pub(in crate::pages) fn found(t: &Text, d: &DiagnosisBody) -> Markup {
    html! {
        @if !d.effects.is_empty() {
            ul.found {
                @for effect in &d.effects {
                    li { strong { (effect_word(t, &effect.effect)) } ": " span translate="no" { (sizes(t, effect)) } }
                }
            }
        }
    }
}

/// `G1 -1.108 ± 0.087 ppm; G2 …`: the coefficients as an engineer writes them.
fn sizes(t: &Text, effect: &EffectBody) -> String {
    let size = |estimate: &EstimateBody| {
        let slot = if estimate.slot == "all" { String::new() } else { format!("{} ", estimate.slot) };
        let name = if estimate.name == "k" { String::new() } else { format!("{} = ", estimate.name) };
        let (value, unit) = sized(t, estimate);
        format!("{slot}{name}{value} {unit}").trim_end().to_owned()
    };
    effect.estimates.iter().map(size).collect::<Vec<_>>().join(t.semicolon)
}

/// An estimate and its unit, as an engineer writes them.
fn sized(t: &Text, estimate: &EstimateBody) -> (String, String) {
    let (factor, unit) =
        if is_shape(estimate) { (1.0, estimate.unit.trim_matches('1')) } else { in_engineers_units(&estimate.unit) };
    let decimals = if estimate.name == "dwell" { 0 } else { 3 };
    let value = figure::with_sd(factor * estimate.value, Some(factor * estimate.sd).filter(|sd| *sd > 0.0), decimals);
    (value, t.unit_of(unit))
}

/// Whether an estimate is of the effect's shape: a time constant, an instant, a dwell. Its regressors are linear in the
/// others alone.
fn is_shape(estimate: &EstimateBody) -> bool {
    matches!(estimate.name.as_str(), "tau" | "instant" | "period" | "dwell" | "field_azimuth")
}

/// What a figure is multiplied by, and the unit that it has then.
fn in_engineers_units(unit: &str) -> (f64, &str) {
    match unit {
        "1" => (1e6, "ppm"),
        "1/K" => (1e6, "ppm/K"),
        "1/g0" => (1e6, "ppm/g0"),
        "rad" => (3600.0 * 1.0_f64.to_degrees(), "arcsec"),
        other => (1.0, other),
    }
}

/// What all of it does to D_I and D_S, in a sentence.
fn consequence(t: &Text, d: &DiagnosisBody) -> Markup {
    let of_drift = |one: &&ImpactBody| matches!(one.coefficient.as_str(), "D_I" | "D_S");
    let moved: Vec<&ImpactBody> = d.impact.iter().filter(of_drift).collect();
    html! {
        @let untold = moved.is_empty() && d.impact_within_noise.is_empty();
        @if d.effects.is_empty() || untold { }
        @else if moved.is_empty() { (layout::with_symbols(t.impact_none)) }
        @else {
            (t.impact_some) " "
            @for (k, one) in moved.iter().enumerate() {
                @if k > 0 { (t.semicolon) }
                (one.slot) " " (layout::symbol(&one.coefficient)) " "
                (figure::signed_drift(one.shift, Some(one.augmented_sd))) " (" (percent(one.of_budget)) ")"
            }
        }
    }
}

/// What limits that: a campaign outside its forecast, and effects that it hardly shows.
fn beside(t: &Text, d: &DiagnosisBody) -> Markup {
    let outside = d.forecast.as_ref().and_then(|point| point.compared.as_ref()).filter(|one| one.is_outside());
    // What no campaign ever shows is part of G, and judged by its closure.
    let is_of_dwells = |id: &&str| Effect::from_id(id).is_none_or(|effect| !effect.entry().closure_only);
    let hardly: Vec<&str> = d.not_identifiable.iter().map(|one| one.effect.as_str()).filter(is_of_dwells).collect();
    html! {
        @if let Some(compared) = outside {
            p { (t.forecast) (t.colon) " " (forecast::state(t, compared)) }
        }
        @if !hardly.is_empty() {
            p.note {
                (t.hardly_shown)
                @for (k, effect) in hardly.into_iter().enumerate() { (if k > 0 { ", " } else { " " }) (effect_word(t, effect)) }
            }
        }
    }
}

/// From the gap down to the noise: the error on dwells that were held out, after each effect in the order of adoption,
/// all on one scale.
fn ladder(t: &Text, d: &DiagnosisBody) -> Markup {
    let first = match d.effects.first() {
        Some(effect) => (t.held_out_before.to_owned(), effect.held_out.before_deg_per_h),
        None => (t.gap_word.to_owned(), d.gap.rms_deg_per_h),
    };
    let after = |effect: &EffectBody| format!("{} {}", t.after_effect, effect_word(t, &effect.effect));
    let steps = d.effects.iter().map(|effect| (after(effect), effect.held_out.after_deg_per_h));
    let steps: Vec<(String, f64)> = std::iter::once(first).chain(steps).collect();
    forecast::rungs(
        t,
        if d.effects.is_empty() { t.ladder_of_fit } else { t.ladder_note },
        &steps,
        d.noise_floor.deg_per_h,
    )
}

fn effects(t: &Text, d: &DiagnosisBody, gyros: &[(String, String)]) -> Markup {
    html! {
        section {
            h2 { (t.what_parts_them) }
            @if d.effects.is_empty() { p { (t.no_effect) } }
            @for effect in &d.effects { (one_effect(t, d, effect, gyros)) }
        }
    }
}

/// Residuals without the effect against what the effect adds, with the line of its fit: one picture a gyro, all on one
/// scale. Where it has one coefficient, x is its regressor.
fn evidence(t: &Text, d: &DiagnosisBody, effect: &EffectBody, gyros: &[(String, String)]) -> Markup {
    let single = |slot: &str| {
        let own: Vec<&EstimateBody> =
            effect.estimates.iter().filter(|one| !is_shape(one) && (one.slot == slot || one.slot == "all")).collect();
        match own.as_slice() {
            [one] if one.value != 0.0 => (one.value, t.unit_of(&regressor_unit(&one.unit))),
            _ => (1.0, t.rate_unit.to_owned()),
        }
    };
    let after = |slot: &str, dwell: usize| {
        d.residuals
            .iter()
            .find(|one| one.slot == slot && one.index == dwell)
            .map(|one| (one.after_deg_per_h, one.sd_deg_per_h))
    };
    let pictures: Vec<residuals::Evidence> = (effect.drift.iter())
        .map(|drift| {
            let points = drift.deg_per_h.iter().enumerate();
            let (slope, unit) = single(&drift.slot);
            let point = |(dwell, added): (usize, &f64)| {
                let (left, sd) = after(&drift.slot, dwell)?;
                Some(residuals::point(t, dwell, added / slope, left + added, sd))
            };
            let serial = gyros.iter().find(|(slot, _)| *slot == drift.slot).map_or("", |(_, serial)| serial.as_str());
            let name = format!("{} {serial}", drift.slot).trim_end().to_owned();
            residuals::Evidence { name, points: points.filter_map(point).collect(), slope, unit }
        })
        .collect();
    html! {
        @if !pictures.is_empty() {
            p.note { (t.evidence_note) }
            (residuals::evidence(t, &pictures))
        }
    }
}

fn one_effect(t: &Text, d: &DiagnosisBody, effect: &EffectBody, gyros: &[(String, String)]) -> Markup {
    html! {
        article.effect {
            h3 { (effect_named(t, &effect.effect)) " · " (effect.gyros.join(", ")) }
            @if let Some(entry) = Effect::from_id(&effect.effect).map(Effect::entry) {
                p.note { code { (entry.equation) } }
            }
            (evidence(t, d, effect, gyros))
            (closure(t, &effect.held_out))
            p.note {
                (t.adjusted_p) " " (short(effect.p_value_adjusted)) " · " (t.detectability) " " (short(effect.detectability))
            }
            @if effect.class.len() > 1 { p { strong { (t.cannot_tell_from) } " " (others(t, effect, &effect.class)) } }
            @for wider in &effect.wider_in {
                p { strong { (wider.slot) " " (t.alone_cannot_tell_from) } " " (others(t, effect, &wider.class)) }
            }
            (wide_table("", html! {
                th { (t.slot) } th { (t.parameter) } th.n { (t.value) } th { (t.unit_word) }
            }, html! { @for estimate in &effect.estimates {
                @let (value, unit) = sized(t, estimate);
                tr {
                    td { (if estimate.slot == "all" { t.all_gyros } else { &estimate.slot }) } td { (estimate.name) }
                    td.n { (value) } td { (unit) }
                }
            } }))
        }
    }
}

/// A class without the effect itself.
fn others(t: &Text, effect: &EffectBody, class: &[String]) -> Markup {
    joined("; ", class.iter().filter(|id| **id != effect.effect).map(|id| effect_named(t, id)))
}

/// How far the error of dwells that were held out shrinks.
fn closure(t: &Text, held_out: &HeldOutBody) -> Markup {
    let interval = Some(held_out.interval);
    html! {
        p {
            (residuals::closure_bar(held_out.closure, interval)) (figure::share(held_out.closure, interval)) " " (t.held_out)
        }
    }
}

fn located(t: &Text, d: &DiagnosisBody, slots: &[(String, String)], settings: &[Setting]) -> Markup {
    let names: Vec<String> = slots.iter().map(|(slot, _)| slot.clone()).collect();
    let serial = |slot: &str| slots.iter().find(|(name, _)| name == slot).map_or("", |(_, serial)| serial.as_str());
    html! {
        section {
            h2 { (t.located) }
            p.note { (t.heat_note) }
            (residuals::signed_maps(t, &d.residuals, &names, settings))
            @if d.verdict != "no_gap" { (wide_table("", html! { th { (t.place) } th.n { (t.share) } }, html! {
                @for gyro in &d.located.gyros {
                    tr { td { (gyro.slot) " " (serial(&gyro.slot)) } td.n { (percent(gyro.share)) } }
                }
                @for phase in &d.located.phases { tr { td { (t.phase(&phase.phase)) } td.n { (percent(phase.share)) } } }
                @for dwell in &d.located.dwells {
                    tr {
                        td { (t.dwell) " " (dwell.index) ", " (dwell.slot) ": " (short(dwell.residual_deg_per_h)) " " (t.rate_unit) }
                        td.n { (percent(dwell.share)) }
                    }
                }
            })) }
        }
    }
}

/// What was ruled out, in three groups: what explains the same as what is named, what explains less, what is within the
/// noise.
fn candidates(t: &Text, d: &DiagnosisBody) -> Markup {
    let named = |id: &String| d.effects.iter().any(|effect| effect.class.contains(id));
    let same = |one: &&CandidateBody| named(&one.effect) || !one.within_noise && one.finding.code == "one_class_with";
    let (same, others): (Vec<&CandidateBody>, Vec<&CandidateBody>) = d.candidates.iter().partition(same);
    let (within, weaker): (Vec<&CandidateBody>, Vec<&CandidateBody>) =
        others.into_iter().partition(|one| one.within_noise);
    html! {
        @if !d.candidates.is_empty() {
            section {
                h2 { (t.what_else) }
                (group(t, t.ruled_out_same, &same))
                (group(t, t.ruled_out_weaker, &weaker))
                @if !within.is_empty() {
                    details {
                        summary { (t.ruled_out_within) " (" (within.len()) ")" }
                        p { (joined(t.semicolon, within.iter().map(|one| effect_word(t, &one.effect)))) }
                        (listed(t, &within))
                    }
                }
            }
        }
    }
}

fn group(t: &Text, name: &str, all: &[&CandidateBody]) -> Markup {
    html! { @if !all.is_empty() { details { summary { (name) " (" (all.len()) ")" } (listed(t, all)) } } }
}

fn listed(t: &Text, all: &[&CandidateBody]) -> Markup {
    html! {
        (wide_table("", html! {
            th { (t.effect) } th { (t.serial) } th { (t.closes_alone) } th.n { (t.adjusted_p) } th { (t.why_not) }
        }, html! { @for candidate in all { tr {
            td.words { (effect_named(t, &candidate.effect)) } td { (candidate.gyros.join(", ")) }
            td.nowrap {
                @if candidate.closure.is_some() && candidate.within_noise {
                    (t.within_noise)
                } @else if let Some(closure) = candidate.closure {
                    (residuals::closure_bar(closure, candidate.interval)) (figure::share(closure, candidate.interval))
                } @else { "–" }
            }
            td.n { (short(candidate.p_value_adjusted)) } td.words { (candidate.why_not) }
        } } }))
    }
}

fn impact(t: &Text, d: &DiagnosisBody) -> Markup {
    let coefficients = d.drift_before_and_after();
    html! {
        @if !d.impact.is_empty() {
            section {
                h2 { (t.impact) }
                (wide_table("", html! {
                    th { (t.serial) } th { (t.coefficient) } th.n { (t.plain) }
                    th.n { (t.with_effects) } th.n { (t.shift) } th.n { (t.of_budget) }
                }, html! { @for (one, moved) in coefficients {
                    @let sd = Some(one.augmented_sd);
                    tr {
                        td { (one.slot) } td { (layout::symbol(&one.coefficient)) }
                        td.n { (figure::with_sd(one.plain, one.plain_sd, 6)) } td.n { (figure::with_sd(one.augmented, sd, 6)) }
                        td.n { (figure::signed(one.shift, figure::places_beside(sd, 6))) }
                        td.n { @if moved { (percent(one.of_budget)) } @else { (t.within_noise) } }
                    }
                } }))
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
            @let all = d.residuals.iter().flat_map(|one| [&one.before_deg_per_h, &one.after_deg_per_h]);
            @let extent = residuals::extent(all);
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
                (wide_table("", html! {
                    th { (t.effect) } th.n { (t.visible) } th { (t.why) } th { (t.would_show) }
                }, html! { @for one in &d.not_identifiable { tr {
                    td.words { (effect_named(t, &one.effect)) } td.n { (percent(one.visible_fraction)) }
                    td.words { (layout::with_symbols(&one.reason)) } td.words { (layout::with_symbols(&one.needs)) }
                } } }))
            }
        }
    }
}

/// As `gyrowatch dwells --programme` reads it: body directions, and the rate of a turn.
fn programme_row(table: &TableBody) -> String {
    let three = |of: [f64; 3]| of.map(|x| format!("{:.6}", x + 0.0)).join(" ");
    let rate = if table.rate_deg_s == 0.0 { String::new() } else { format!("{:.6}", table.rate_deg_s) };
    format!("{},{},{rate}", three(table.up), three(table.north))
}

fn next(t: &Text, d: &DiagnosisBody) -> Markup {
    let settings: Vec<(&TableBody, &[String])> =
        d.next_dwells.iter().filter_map(|dwell| Some((dwell.table.as_ref()?, &*dwell.separates))).collect();
    html! {
        @if !settings.is_empty() {
            section {
                h2 { (t.measure_next) }
                (wide_table("", html! {
                    th { (t.up_axis) } th { (t.north_axis) } th.n { (t.table_rate) ", " (t.unit_of("deg/s")) }
                    th { (t.separates) }
                }, html! { @for (table, separates) in &settings { tr {
                    td { (TableBody::direction(table.up)) } td { (TableBody::direction(table.north)) }
                    td.n { (format!("{:.3}", table.rate_deg_s)) }
                    td.words { (joined("; ", separates.iter().map(|id| effect_named(t, id)))) }
                } } }))
                details {
                    summary { (t.as_programme) }
                    pre translate="no" { "up,north,rate_deg_s\n" @for (table, _) in &settings { (programme_row(table)) "\n" } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn a_dwell_to_measure_is_what_a_programme_says() {
        let table = TableBody { up: [0.0, 0.0, -1.0], north: [0.5, 0.75_f64.sqrt(), 0.0], rate_deg_s: 0.0 };
        assert_eq!([table.up, table.north].map(TableBody::direction), ["-Z", "+Y 30° +X"]);
        assert_eq!(programme_row(&table), "0.000000 0.000000 -1.000000,0.500000 0.866025 0.000000,");
        let turning = TableBody { rate_deg_s: -2.5, ..table };
        assert!(programme_row(&turning).ends_with(",-2.500000"));
        assert_eq!(TableBody::direction([0.6, 0.64, 0.48]), "0.6000 0.6400 0.4800");
    }

    #[test]
    fn sizes_are_in_units_that_an_engineer_writes() {
        let estimate = |slot: &str, name: &str, value: f64, sd: f64, unit: &str| EstimateBody {
            slot: slot.into(),
            name: name.into(),
            value,
            sd,
            unit: unit.into(),
        };
        let of = |estimates: Vec<EstimateBody>| {
            let held_out =
                HeldOutBody { before_deg_per_h: 1.0, after_deg_per_h: 0.5, closure: 0.9, interval: [0.8, 1.0] };
            let effect = EffectBody {
                effect: "scale_asymmetry".into(),
                class: vec![],
                wider_in: vec![],
                gyros: vec![],
                acts_in: None,
                estimates,
                held_out,
                p_value_adjusted: 0.0,
                detectability: 9.0,
                drift: vec![],
            };
            sizes(Language::English.text(), &effect)
        };
        let asymmetry = vec![estimate("G1", "k", -1.108e-6, 8.7e-8, "1"), estimate("G2", "k", -7.3e-7, 1.0e-7, "1")];
        assert_eq!(of(asymmetry), "G1 -1.108 ± 0.087 ppm; G2 -0.73 ± 0.10 ppm");
        assert_eq!(of(vec![estimate("all", "dwell", 17.0, 0.0, "1")]), "dwell = 17");
        let tilt = vec![estimate("all", "north", 1e-4, 1e-5, "rad")];
        assert_eq!(of(tilt), "north = 20.6 ± 2.1 arcsec");
        assert_eq!(of(vec![estimate("G3", "k", 1e-3, 1e-4, "deg/h/K")]), "G3 0.00100 ± 0.00010 deg/h/K");
    }
}
