//! `/hooks/{id}`: what one hook was told, newest first, with the dead letters.

use axum::http::header::REFRESH;

use super::{buttons, filter, known, state, written};
use crate::core::delivery::DeliveryState;
use crate::pages::prelude::*;
use crate::pages::verdicts::violated;
use crate::pages::{fleet, status};
use crate::wire::hook::DeliveryBody;

/// Deliveries on one page.
const ROWS: usize = 60;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::pages) struct Filters {
    /// A state by its name; all, where it is left out.
    state: String,
    /// Only older ones than this.
    before: String,
}

/// Where something on it is about to be sent, what comes of it appears by itself.
pub(in crate::pages) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref id): Path<String>,
    Query(ref filters): Query<Filters>,
) -> Result<Response, Problem> {
    let t = viewer.text();
    let (number, hook) = known(pages, id).await?;
    let asked = fleet::named("state", &filters.state)?;
    let mut deliveries = pages.pipeline.hooks.deliveries(number, asked, filters.before.parse().ok(), ROWS + 1).await?;
    let more = deliveries.len() > ROWS;
    deliveries.truncate(ROWS);
    let is_pending = hook.enabled
        && filters.before.is_empty()
        && deliveries.iter().any(|delivery| delivery.state == "waiting" && delivery.attempts.is_empty());
    let alerts: Vec<Id> = deliveries.iter().filter_map(|one| one.alert.as_ref()?.parse().ok()).collect();
    let alerts = pages.pipeline.alerts.of(&alerts).await?;
    let to = |state: &str, before: &str| format!("/hooks/{id}?state={state}&before={before}");
    let body = html! {
        h1 { span translate="no" { (hook.name) } " " (state(t, &hook)) }
        p { (hook.kind) " · " code { (hook.url) } (filter(t, &hook.filter)) }
        (buttons(viewer, &hook))
        h2 { (t.deliveries) }
        nav.tabs aria-label=(t.status_word) {
            a href={ "/hooks/" (id) } aria-current=[filters.state.is_empty().then_some("true")] { (t.all_states) }
            @for state in [DeliveryState::Waiting, DeliveryState::Delivered, DeliveryState::Dead].map(DeliveryState::name) {
                a href=(to(state, "")) aria-current=[(filters.state == state).then_some("true")] { (t.delivery(state)) }
            }
        }
        @if hook.queue.dead > 0 && hook.enabled {
            form action={ "/hooks/" (hook.id) "/redeliver" } method="post" {
                button { (t.redeliver_dead) " (" (hook.queue.dead) ")" }
            }
        }
        @if deliveries.is_empty() { p { (t.no_deliveries) } } @else { (wide_table("cards", html! {
            th { (t.message) } th { (t.serial) } th { (t.queued) } th { (t.status_word) }
            th.n { (t.attempts) } th { (t.last_attempt) } th { (t.actions_word) }
        }, html! { @for delivery in &deliveries {
            @let alert = alerts.iter().find(|alert| Some(&alert.id) == delivery.alert.as_ref());
            (line(t, id, delivery, alert))
        } })) }
        @if more && let Some(last) = deliveries.last() {
            nav.pager aria-label=(t.deliveries) { a rel="next" href=(to(&filters.state, &last.id)) { (t.older) } }
        }
    };
    let refresh = is_pending.then_some([(REFRESH, "2")]);
    Ok((refresh, Page { title: hook.name.clone(), section: Section::Hooks, body }).into_response())
}

fn line(t: &Text, hook: &str, delivery: &DeliveryBody, alert: Option<&AlertBody>) -> Markup {
    let shape = match delivery.state {
        "delivered" => Some(Status::InTolerance),
        "dead" => Some(Status::OutOfTolerance),
        "dropped" => None,
        _ => Some(Status::Borderline),
    };
    html! {
        tr {
            th.nowrap scope="row" { (delivery.event) br; span.quiet { (delivery.webhook_id) } }
            td data-label=(t.serial) {
                @if let Some(alert) = alert {
                    a.id href={ "/alerts/" (alert.id) } { (alert.serial) } " "
                    span.nowrap { (violated(t, alert)) }
                }
            }
            td data-label=(t.queued) { (written(&delivery.queued_at)) }
            td {
                (status::said(shape, t.delivery(delivery.state)))
                @if let Some(due) = &delivery.due_at { br; span.quiet { (t.next_attempt) " " (written(due)) } }
            }
            td.n data-label=(t.attempts) { (delivery.attempts.len()) }
            td.words {
                @if let Some(last) = delivery.attempts.last() {
                    (written(&last.at)) " " @if let Some(status) = last.status { (status) " " }
                    span.quiet { (last.detail) " " (format!("{:.0} ms", last.took_ms)) }
                    @if let Some(answer) = &last.answer { details { summary { (t.answer) } code translate="no" { (answer) } } }
                }
            }
            td {
                @if matches!(delivery.state, "delivered" | "dead" | "waiting") {
                    form action={ "/hooks/" (hook) "/deliveries/" (delivery.id) "/redeliver" } method="post" {
                        button { (t.redeliver) }
                    }
                }
            }
        }
    }
}
