//! What was foretold of an IMU's campaigns, and how far it came true: over time, step by step, and which adopted
//! coefficients are others now.

use super::chart::{Chart, DataPoint, Track, XAxis, bounds, millis, widened};
use super::figure::short;
use super::layout::effect_word;
use super::prelude::*;
use crate::core::augmented::AugmentedModel;
use crate::pipeline::AdoptedModel;
use crate::wire::diagnosis::{InUseBody, InUseEffectBody};
use crate::wire::forecast::{ChangedBody, ClosingBody, ComparedBody, ForecastPointBody, ThenNowBody};
use crate::wire::model::ModelBody;

/// The forecasts of an IMU's campaigns, oldest first; nothing where there are none.
pub(super) fn series(t: &Text, points: &[ForecastPointBody]) -> Markup {
    let newest = points.iter().rev().find_map(|point| Some((point, point.compared.as_ref()?)));
    html! {
        @if !points.is_empty() {
            section #forecasts {
                h2 { (t.forecasts) }
                @if let Some((newest, compared)) = newest {
                    p.note { (t.forecasts_note) }
                    (picture(t, points))
                    (ladder(t, &format!("{} · {}", &newest.measured_at[..10], t.forecast_ladder), compared))
                }
                (tall_table("", html! {
                    th { (t.measured_at) } th { (t.forecast) } th.n { (t.error_in_sd) } th { (t.effects_close) }
                    th { (t.foretold_by) }
                }, html! { @for point in points.iter().rev() { (line(t, point)) } }))
            }
        }
    }
}

/// What a model holds: terms, effects beside them, sizes that its gyros may have.
pub(super) fn held(t: &Text, model: &AugmentedModel) -> String {
    if model.is_plain() {
        return t.plain_model.to_owned();
    }
    let ModelBody { terms, effects, plausible_sizes, .. } = ModelBody::from(model);
    let effects = effects.into_iter().map(|known| InUseEffectBody { effect: known.effect, gyros: known.gyros });
    let sizes = plausible_sizes.iter().map(|(id, size)| format!(" |{id}| ≤ {size}"));
    InUseBody { terms, effects: effects.collect() }.listed() + &sizes.collect::<String>()
}

/// The models that were adopted for an IMU, the one in force first; nothing where none was.
pub(super) fn versions(viewer: &Viewer, imu: &str, models: &[AdoptedModel]) -> Markup {
    let t = viewer.text();
    let may_undo = viewer.may(Role::Engineer);
    html! {
        @if !models.is_empty() {
            section #models {
                h2 { (t.adopted_models) }
                (wide_table("", html! {
                    th { (t.adopted_at) } th { (t.model_word) }
                    th { (symbol("D_I")) ", " (symbol("D_S")) " " (t.stated_at) } th.n { (t.campaigns_stated) }
                    th { (t.author) } th { (t.reason_word) }
                }, html! { @for (k, one) in models.iter().enumerate() { tr {
                    td { (instant(one.row.adopted_at)) @if k == 0 {
                        br; strong { (t.in_force) }
                        @if may_undo { " " a href={ "/imus/" (encoded(imu)) "/model/undo" } { (t.undo) } }
                    } }
                    td.words { code translate="no" { (held(t, &one.model)) } }
                    @let reference_c = one.model.identified.as_ref().and_then(|own| own.reference_c);
                    td.nowrap { (or_dash(reference_c.map(|celsius| format!("{celsius:.1} °C")))) }
                    td.n { (one.campaigns) } td { (one.row.author) } td.words { (one.row.reason) }
                } } }))
                p.note { (t.adopted_models_note) }
            }
        }
    }
}

fn line(t: &Text, point: &ForecastPointBody) -> Markup {
    html! {
        tr {
            td { a href={ "/campaigns/" (point.campaign) "/diagnosis" } { (written(&point.measured_at)) } }
            @if let Some(compared) = &point.compared {
                td { (state(t, compared)) }
                td.n { (short(compared.rms_over_sd)) }
                td.nowrap { (or_dash(compared.closing.map(|closing| closed(t, closing)))) }
            } @else { td.words colspan="3" { (point.why_not.as_deref().unwrap_or(t.not_foretold)) } }
            td.words {
                @if let Some(model) = &point.model {
                    (written(&model.measured_at)) " · " (t.words(&message!("campaigns_counted", count = model.campaigns)))
                    @for effect in &model.effects { " + " (effect_word(t, effect)) }
                }
            }
        }
    }
}

fn state_word(t: &Text, compared: &ComparedBody) -> &'static str {
    if compared.is_outside() {
        t.outside_forecast
    } else if compared.is_indeterminate() {
        t.forecast_indeterminate
    } else {
        t.as_foretold
    }
}

pub(super) fn state(t: &Text, compared: &ComparedBody) -> Markup {
    html! { @if compared.is_outside() { strong { (t.outside_forecast) } } @else { (state_word(t, compared)) } }
}

fn closed(t: &Text, closing: ClosingBody) -> Markup {
    let share = |interval| figure::share(closing.closure, Some(interval));
    html! { (closing.interval.map_or_else(|| t.nothing_to_close.to_owned(), share)) }
}

/// Forecast error of each campaign with the adopted effects and without them, and the noise.
fn picture(t: &Text, points: &[ForecastPointBody]) -> Markup {
    let told: Vec<(f64, UtcMicros, &ForecastPointBody, &ComparedBody)> = points
        .iter()
        .filter_map(|point| {
            let at = time::parse(&point.measured_at).ok()?;
            Some((millis(at), at, point, point.compared.as_ref()?))
        })
        .collect();
    let Some(ends) = bounds(told.iter().map(|(x, ..)| *x)) else { return html! {} };
    let dot = |x: f64, y: f64, outside: bool, said: String, campaign: &str| DataPoint {
        x,
        y,
        status: outside.then_some(Status::Drifting),
        href: Some(format!("/campaigns/{campaign}/diagnosis")),
        said,
        ..DataPoint::default()
    };
    let with = told.iter().map(|(x, at, point, c)| {
        let (error, state) = (short(c.rms_deg_per_h), state_word(t, c));
        let said = format!("{} · {error} {}, {} sd · {state}", at.date(), t.rate_unit, short(c.rms_over_sd));
        dot(*x, c.rms_deg_per_h, c.is_outside(), said, &point.campaign)
    });
    let without = told.iter().filter_map(|(x, at, point, c)| {
        let plain = c.ladder.first().filter(|_| c.ladder.len() > 1)?;
        let said = format!("{} · {} {} {}", at.date(), t.without_effects, short(plain.rms_deg_per_h), t.rate_unit);
        Some(dot(*x, plain.rms_deg_per_h, false, said, &point.campaign))
    });
    let track =
        |class: &str, dots: Vec<DataPoint>| Track { class: class.into(), dots, joined: true, ..Track::default() };
    let noise = told.iter().map(|(x, .., c)| (*x, c.noise_deg_per_h)).collect();
    let caption = html! { span { (t.forecast_error) ", " (t.rate_unit) } };
    let chart = Chart {
        tracks: vec![track("k1", without.collect()), track("k0", with.collect())],
        lines: vec![("station", noise)],
        ..Chart::new(t.forecast_error.to_owned(), caption, XAxis::Time, widened(ends, 0.02, 8.64e7))
    };
    chart.markup()
}

/// One campaign's forecast error, from model (6) over each effect to the noise.
fn ladder(t: &Text, caption: &str, compared: &ComparedBody) -> Markup {
    let name = |effect: &Option<String>| match effect {
        Some(effect) => format!("+ {}", effect_word(t, effect)),
        None => t.model_6.to_owned(),
    };
    let steps: Vec<(String, f64)> =
        compared.ladder.iter().map(|rung| (name(&rung.effect), rung.rms_deg_per_h)).collect();
    rungs(t, caption, &steps, compared.noise_deg_per_h)
}

/// Errors as bars on one scale, and the noise floor under them.
pub(super) fn rungs(t: &Text, caption: &str, steps: &[(String, f64)], floor: f64) -> Markup {
    let most = steps.iter().map(|(_, size)| *size).fold(floor, f64::max).max(f64::MIN_POSITIVE);
    let width = |size: f64| format!("{:.1}%", 100.0 * size / most);
    let row = |name: &str, size: f64, has_bar: bool| {
        html! {
            tr {
                th scope="row" { (name) }
                td { svg.rung width="100%" height="18" aria-hidden="true" {
                    @if has_bar { rect x="0" y="3" height="12" width=(width(size)) {} }
                    line x1=(width(floor)) x2=(width(floor)) y1="0" y2="18" {}
                } }
                td.n { (short(size)) " " (t.rate_unit) }
            }
        }
    };
    html! {
        table.ladder {
            caption { (caption) }
            tbody {
                @for (name, size) in steps { (row(name, *size, true)) }
                (row(t.noise_floor, floor, false))
            }
        }
    }
}

/// What was foretold of one campaign, in a section of its diagnosis.
pub(super) fn of_campaign(t: &Text, point: Option<&ForecastPointBody>, changed: Option<&ChangedBody>) -> Markup {
    html! {
        @if point.is_some() || changed.is_some() {
            section #forecast {
                h2 { (t.forecast) }
                @if let Some(point) = point { (came_true(t, point)) }
                @if let Some(changed) = changed { (against_model(t, changed)) }
            }
        }
    }
}

fn came_true(t: &Text, point: &ForecastPointBody) -> Markup {
    html! {
        @if let Some(compared) = &point.compared {
            p {
                (state(t, compared)) " · " (t.error_in_sd) " " (short(compared.rms_over_sd))
                @if let Some(furthest) = compared.furthest() { " · " (furthest.slot) ": p " (short(furthest.p_value)) }
                @if let Some(model) = &point.model {
                    " · " (t.foretold_by) " " (written(&model.measured_at)) ", " (t.words(&message!("campaigns_counted", count = model.campaigns)))
                }
            }
            @if let Some(verdict) = compared.verdict.as_ref().filter(|verdict| !verdict.is_within()) { p { (verdict.reason) } }
            @if let Some(closing) = compared.closing {
                p { (t.effects_close) ": " (closed(t, closing))
                    @if let Some(promised) = point.promised { " · " (t.promised) " " (closed(t, promised)) } }
            }
            (ladder(t, t.forecast_ladder, compared))
        } @else { p { (point.why_not.as_deref().unwrap_or(t.not_foretold)) } }
        @for note in &point.notes { p.note { (note) } }
    }
}

/// Adopted coefficients then and now, and what the changed ones do to D_I and D_S.
fn against_model(t: &Text, changed: &ChangedBody) -> Markup {
    let with = |c: &ThenNowBody, value: f64, sd: f64| {
        html! {
            (figure::with_sd(value, Some(sd), 6))
            @if c.unit != "1" { " " (t.unit_of(&c.unit)) }
        }
    };
    html! {
        h3 { (t.effects_then_and_now) }
        (wide_table("", html! {
            th { (t.effect) } th { (t.serial) } th { (t.parameter) } th.n { (t.in_model) } th.n { (t.in_campaign) }
            th.n { (t.adjusted_p) } th { (t.changed_word) }
        }, html! { @for effect in &changed.effects { @for c in &effect.coefficients { tr {
            td.words { (effect_word(t, &effect.effect)) }
            td { (if effect.slot == "all" { t.all_gyros } else { &effect.slot }) } td { (c.name) }
            td.n { (with(c, c.model, c.model_sd)) } td.n { (with(c, c.now, c.now_sd)) }
            td.n { (short(effect.p_value)) }
            td {
                @if effect.changed { strong { (t.yes) } }
                @else if effect.undecided { (t.cannot_tell) }
                @else { (t.no) }
            }
        } } } }))
        @for (beyond_seen, why) in [(false, t.change_undecided), (true, t.change_beyond_seen)] {
            @if changed.effects.iter().any(|effect| effect.undecided && effect.beyond_seen == beyond_seen) {
                p.note { (why) }
            }
        }
        @for shift in &changed.shifts {
            p { (shift.slot) " " (symbol(&shift.coefficient)) " " (figure::signed_drift(shift.shift, Some(shift.sd)))
                " " (t.unit) " " (t.by_the_change) }
        }
    }
}
