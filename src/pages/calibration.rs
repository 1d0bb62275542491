//! `/records/{id}` and `/campaigns/{id}`: one calibration of an IMU, from its verdicts down to its residuals.

use std::borrow::Cow;

use axum::response::Redirect;

use super::layout::{joined, noted};
use super::parameters::{self, Parameters};
use super::prelude::*;
use super::verdicts::{self, SeenVerdict};
use super::{corrections, residuals, separation};
use crate::core::diagnose::{ClosureDiagnosis, GyroClosure};
use crate::core::judge::{State, Verdict};
use crate::core::kind::Kind;
use crate::core::message::text;
use crate::core::mounting::Slot;
use crate::core::name::normal_form;
use crate::pipeline::{StoredCampaign, StoredRecord};
use crate::wire::answer::VerdictBody;
use crate::wire::calibration::GyroFitBody;
use crate::wire::campaign::CampaignBody;
use crate::wire::record::RecordBody;
use crate::wire::sender::SenderBody;

pub(super) async fn record(
    PageContext(ref pages, ref viewer): PageContext,
    Path(id): Path<String>,
) -> Result<Response, Problem> {
    let stored = stored_record(pages, &id).await?;
    match stored.item.kind {
        Kind::Campaign => Ok(Redirect::to(&format!("/campaigns/{id}")).into_response()),
        Kind::Record => Ok(record_page(pages, viewer, &stored).await?.into_response()),
    }
}

async fn stored_record(pages: &Pages, id: &str) -> Result<StoredRecord, Problem> {
    let number = problem::id(id, Problem::no_such_record)?;
    pages.pipeline.queries.records.record(number).await?.ok_or_else(|| Problem::no_such_record(id))
}

pub(super) async fn stored_campaign(pages: &Pages, id: &str) -> Result<StoredCampaign, Problem> {
    let number = problem::id(id, Problem::no_such_campaign)?;
    pages.pipeline.queries.records.campaign(number).await?.ok_or_else(|| Problem::no_such_campaign(id))
}

async fn record_page(pages: &Pages, viewer: &Viewer, stored: &StoredRecord) -> Result<Page, Problem> {
    let t = viewer.text();
    let StoredRecord { item, answer, seen, closures } = stored;
    let body: RecordBody = serde_json::from_str(&item.body).map_err(|_| unreadable(&item.id))?;
    let gyros: Vec<Parameters> = body.gyros.iter().map(Parameters::stated).collect();
    let serials: Vec<_> = body.gyros.iter().map(|gyro| (gyro.slot, normal_form(&gyro.serial))).collect();
    let title = format!("{} · {}", t.record, body.imu);
    let standing = corrections::standing(pages, viewer, item.kind, item.id).await?;
    let sender = pages.pipeline.queries.records.sender(item.sent_by).await?;
    let markup = html! {
        h1 { (t.record) " " a href={ "/imus/" (encoded(&body.imu)) } { (body.imu) } }
        p.lead { (t.station) " " (body.station) " · " (t.calibrated) " " (instant(item.calibrated_at)) }
        p.note {
            (t.received) " " (instant(item.received_at)) " · " (t.identifier) " "
            a href={ "/v1/records/" (item.id) } { code { (item.id) } }
            (sent_by(t, sender.as_ref()))
            @if let Some(operator) = &body.operator { " · " (t.operator) " " (operator) }
            @if let Some(temperature) = body.temperature_c { " · " (temperature) " °C" }
        }
        @if let Some(note) = &body.note { p translate="no" { (note) } }
        (standing.said)
        (noted(t, &answer.notes))
        (judged(t, serials.iter().map(|(slot, serial)| (*slot, &**serial)), (&answer.verdicts, seen), standing.counts))
        section { h2 { (t.separated) } (separation::tables(t, &answer.separations)) }
        (closure(t, item.id, closures, &serials, &answer.verdicts))
        section { h2 { (t.parameters) } (parameters::tables(t, &gyros, parameters::required(&pages.config.judging, &body.imu, &body.geometry))) }
    };
    Ok(Page { title, section: Section::Fleet, body: markup })
}

fn sent_by(t: &Text, sender: Option<&SenderBody>) -> Markup {
    let Some(SenderBody { name, address, agent, .. }) = sender else { return html! {} };
    let from = [Some(address.as_str()).filter(|address| !address.is_empty()), agent.as_deref()];
    let from = from.into_iter().flatten().collect::<Vec<_>>().join(", ");
    html! { " · " (t.sent_by) " " span translate="no" { (name) @if !from.is_empty() { " (" (from) ")" } } }
}

/// What D_O says by itself: folded, and without advice, unless its rule speaks.
fn closure(
    t: &Text,
    id: Id,
    closures: &ClosureDiagnosis,
    serials: &[(Slot, Cow<'_, str>)],
    verdicts: &[VerdictBody],
) -> Markup {
    let out: Vec<&GyroClosure> = closures.gyros.iter().filter(|gyro| gyro.stands_out).collect();
    let slots: Vec<&str> = out.iter().map(|gyro| gyro.slot.name()).collect();
    let serial = |slot: Slot| serials.iter().find(|(own, _)| *own == slot).map_or("", |(_, serial)| &**serial);
    let speaks = |one: &&VerdictBody| one.rule == Rule::Closure.name() && one.state == State::Exceeded.name();
    let beyond: Vec<&str> = verdicts.iter().filter(speaks).map(|one| &*one.serial).collect();
    let moved = closures.gyros.iter().filter(|gyro| beyond.contains(&serial(gyro.slot)));
    let change = |gyro: &GyroClosure| Some(format!("{} {:.2}", gyro.slot.name(), gyro.telling_change?));
    let changes: Vec<String> = moved.filter_map(change).collect();
    html! {
        details #closure open[!beyond.is_empty()] {
            summary { (t.closure_diagnosis) }
            p {
                @if slots.is_empty() { (t.closure_within) }
                @else { strong { (slots.join(", ")) } ": " (t.closure_stands_out) }
                " " a href={ "/v1/records/" (id) "/diagnosis" } { "JSON" }
            }
            (wide_table("cards", html! {
                th { (t.serial) } th.n { (symbol("D_O")) } th.n { (t.adjusted_p) }
                th.n { (t.if_clocked) ", ′" } th.n { (t.if_clocked) ", " (symbol("D_S")) }
            }, html! { @for gyro in &closures.gyros { tr {
                @let clocking = gyro.stands_out.then(|| figure::signed(60.0 * gyro.clocking.to_degrees(), 1));
                th scope="row" { (gyro.slot.name()) " " (serial(gyro.slot)) }
                td.n { (label("", "D_O")) (figure::signed_drift(gyro.d_o, gyro.sd)) }
                td.n data-label=(t.adjusted_p) { (or_dash(gyro.p_value.map(figure::short))) }
                td.n data-label={ (t.if_clocked) ", ′" } { (or_dash(clocking)) }
                td.n {
                    (label(t.if_clocked, "D_S"))
                    @if gyro.stands_out { (figure::drift(gyro.d_s, gyro.sd)) " → " (figure::drift(gyro.d_s + gyro.d_s_shift, gyro.sd)) } @else { "–" }
                }
            } } }))
            p.note { (t.unit) }
            @if !beyond.is_empty() {
                h3 { (t.measure_next) }
                ol {
                    @if !changes.is_empty() { li { (t.tell_by_history) " " (changes.join(", ")) " " (t.unit) (t.stop) } }
                    li { (t.tell_by_seat) }
                    li { (t.tell_by_bench) }
                }
            }
        }
    }
}

pub(super) async fn campaign(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref id): Path<String>,
) -> Result<Page, Problem> {
    let stored = &stored_campaign(pages, id).await?;
    let t = viewer.text();
    let StoredCampaign { item, answer, seen } = stored;
    let body: CampaignBody = serde_json::from_str(&item.body).map_err(|_| unreadable(&item.id))?;
    let fits = &answer.calibration.gyros;
    let gyros: Vec<Parameters> = fits.iter().map(Parameters::fitted).collect();
    let title = format!("{} · {}", t.campaign, answer.imu);
    let standing = corrections::standing(pages, viewer, item.kind, item.id).await?;
    let sender = pages.pipeline.queries.records.sender(item.sent_by).await?;
    let markup = html! {
        h1 { (t.campaign) " " a href={ "/imus/" (encoded(&answer.imu)) } { (answer.imu) } }
        p.lead {
            (t.station) " " (answer.station) " · " (t.measured) " " (instant(item.calibrated_at)) " · "
            (answer.calibration.dwells) " " (t.dwells)
        }
        p.note {
            (t.received) " " (instant(item.received_at)) " · " (t.identifier) " "
            a href={ "/v1/campaigns/" (item.id) } { code { (item.id) } }
            (sent_by(t, sender.as_ref()))
        }
        p { a.action href={ "/campaigns/" (item.id) "/diagnosis" } { (t.diagnose) } }
        (standing.said)
        @let slots = fits.iter().map(|gyro| (gyro.slot, gyro.serial.as_str()));
        (judged(t, slots, (&answer.verdicts, seen), standing.counts))
        section {
            h2 { (t.separated) }
            (separation::tables(t, &answer.separations))
            @for gyro in &answer.not_separated { p { (gyro.serial) ": " (gyro.reason) } }
        }
        section { h2 { (t.parameters) } (parameters::tables(t, &gyros, parameters::required(&pages.config.judging, &body.imu, &body.geometry))) }
        section {
            h2 { (t.fit_quality) }
            (quality(t, fits))
            @for gyro in fits { (blind_directions(t, gyro)) }
            @for note in &answer.notes { p.note { (note.detail) } }
        }
        section {
            h2 { (t.residuals_by_dwell) }
            p.note { (t.residuals_note) }
            @let extent = residuals::extent(fits.iter().filter_map(|gyro| gyro.residuals.standardised.as_ref()).flatten());
            @for gyro in fits {
                h3 { (gyro.slot.name()) " " (gyro.serial) }
                @if let Some(standardised) = &gyro.residuals.standardised {
                    (residuals::strip(t, standardised, extent))
                } @else { p { (t.no_noise) } }
            }
            (residual_table(t, fits))
        }
    };
    Ok(Page { title, section: Section::Fleet, body: markup })
}

fn unreadable(id: &Id) -> Problem {
    Problem::new(500, "title_damaged_database", message!("body_unreadable", id = text(id)))
}

fn judged<'a>(
    t: &Text,
    gyros: impl Iterator<Item = (Slot, &'a str)>,
    (bodies, seen): (&[VerdictBody], &[Option<Verdict>]),
    counts: bool,
) -> Markup {
    html! {
        section.uncounted[!counts] {
            h2 { (t.verdicts_of_record) }
            @if !counts { p.note { (t.uncounted_note) } }
            @for (slot, serial) in gyros {
                @let own = SeenVerdict::of_gyro(serial, bodies, seen);
                h3 { (slot.name()) " " a href={ "/gyros/" (encoded(serial)) } { (serial) } }
                @if own.is_empty() { p.quiet { (t.not_judged) } } @else { (verdicts::list(t, &own)) }
            }
        }
    }
}

fn quality(t: &Text, fits: &[GyroFitBody]) -> Markup {
    let short = |value: Option<f64>| or_dash(value.map(figure::short));
    html! {
        (wide_table("cards", html! {
            th { (t.serial) } th.n { (t.rank) } th.n { (t.freedom) }
            th.n { "χ²/" (t.freedom) } th.n { "p, " (t.lack_of_fit) }
            th.n { (t.noise) ", " (t.rate_unit) } th.n { (t.sem_factor) } th { (t.noise_from) }
        }, html! { @for gyro in fits { tr {
            th scope="row" { (gyro.slot.name()) " " (gyro.serial) }
            td.n data-label=(t.rank) { (gyro.rank) " / " (gyro.parameters.len()) }
            td.n data-label=(t.freedom) { (gyro.dof) }
            td.n data-label="χ²/ν" { (short(gyro.reduced_chi2)) }
            td.n data-label={ "p, " (t.lack_of_fit) } { (short(gyro.p_value)) }
            td.n data-label={ (t.noise) ", " (t.rate_unit) } { (short(gyro.noise.rms_deg_per_h)) }
            td.n data-label=(t.sem_factor) { (short(gyro.noise.sem_factor)) }
            td data-label=(t.noise_from) { (t.noise_source(&gyro.noise.source)) }
        } } }))
    }
}

/// What no dwell can see, and by which condition it was fixed.
fn blind_directions(t: &Text, gyro: &GyroFitBody) -> Markup {
    html! {
        @for null in &gyro.null_directions {
            p.note {
                (gyro.serial) ": " (t.not_seen) " "
                (joined(", ", null.direction.iter().map(|(name, share)| html! {
                    (symbol(name)) " " (figure::short(*share))
                })))
                @if let Some(gauge) = &null.gauge { "; " (t.fixed_by) " " (gauge) }
            }
        }
    }
}

fn residual_table(t: &Text, fits: &[GyroFitBody]) -> Markup {
    let dwells = fits.iter().map(|gyro| gyro.residuals.pulse_per_s.len()).max().unwrap_or(0);
    html! {
        details {
            summary { (t.every_residual) }
            (tall_table("", html! {
                th.n { (t.dwell) } @for gyro in fits { th.n { (gyro.serial) ", " (t.rate_unit) } th.n { "σ" } }
            }, html! { @for dwell in 0..dwells { tr {
                td.n { (dwell) }
                @for gyro in fits {
                    @let of = |list: &Option<Vec<f64>>| list.as_ref().and_then(|list| list.get(dwell).copied());
                    td.n { @if let Some(value) = of(&gyro.residuals.deg_per_h) { (figure::short(value)) } }
                    td.n { @if let Some(value) = of(&gyro.residuals.standardised) { (format!("{value:+.1}")) } }
                }
            } } }))
        }
    }
}
