//! Orders to diagnose many campaigns: how they go, a form to begin one, a button to cancel one; and what somebody wrote
//! into the fields of such a form.

use axum::extract::State as Held;

use crate::pages::form::{fault_list, said, see_other};
use crate::pages::prelude::*;
use crate::pages::status;
use crate::pipeline::DiagnosisOrder;
use crate::wire::diagnoses::{FailureBody, JobBody, WhichBody};

/// Orders that are shown, and failures of each.
const ORDERS: u32 = 10;
const FAILURES: u32 = 20;

/// Which campaigns are to be diagnosed, as the form says it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::pages) struct DiagnosisForm {
    imu: String,
    station: String,
    since: String,
    until: String,
    again: String,
}

impl DiagnosisForm {
    pub fn which(&self) -> WhichBody {
        WhichBody {
            imu: said(&self.imu),
            station: said(&self.station),
            since: beginning(&self.since),
            until: end(&self.until),
            again: self.again == "yes",
        }
    }
}

pub(in crate::pages) async fn cancel(Held(pages): Held<Pages>, Path(id): Path<String>) -> Result<Response, Problem> {
    pages.pipeline.diagnoses.order(DiagnosisOrder::Cancel(problem::id(&id, Problem::no_such_diagnoses)?)).await?;
    Ok(see_other("/diagnoses#orders"))
}

/// The newest orders with their progress.
pub(super) async fn section(pages: &Pages, viewer: &Viewer) -> Result<Markup, Problem> {
    let t = viewer.text();
    let orders = pages.pipeline.diagnoses.jobs(None, ORDERS).await?;
    let mut failed = Vec::new();
    for order in orders.iter().filter(|order| order.counts.failed > 0) {
        if let Ok(id) = order.id.parse()
            && let Some(detail) = pages.pipeline.diagnoses.job(id, None, FAILURES).await?
        {
            failed.push(detail);
        }
    }
    Ok(html! {
        section #orders {
            h2 { (t.orders) }
            @if orders.is_empty() { p { (t.no_orders) } } @else {
                (wide_table("", html! {
                    th { (t.ordered) } th { (t.which_campaigns) }
                    th { (t.status_word) } th { (t.progress) } th.n { (t.failed_word) }
                    th { (t.ended) } th { (t.actions_word) }
                }, html! { @for order in &orders { (line(viewer, order)) } }))
            }
            @for order in &failed {
                details {
                    summary { (t.not_diagnosed) " " (written(&order.job.asked_at)) " (" (order.job.counts.failed) ")" }
                    (failures(t, &order.failures))
                    @if order.next.is_some() { p { a href={ "/v1/diagnoses/" (order.job.id) } { "JSON" } } }
                }
            }
        }
    })
}

fn line(viewer: &Viewer, order: &JobBody) -> Markup {
    let t = viewer.text();
    let counts = &order.counts;
    let settled = counts.campaigns - counts.waiting;
    let (state, shape) = match order.state.as_str() {
        "done" => (t.order_done, Some(Status::InTolerance)),
        "canceled" => (t.order_canceled, None),
        "running" => (t.order_running, Some(Status::Borderline)),
        _ => (t.order_waiting, Some(Status::NotEnoughData)),
    };
    let open = order.ended_at.is_none();
    html! {
        tr {
            th scope="row" { (written(&order.asked_at)) " " span.quiet translate="no" { (order.asked_by) } }
            td.words { (which(t, &order.asked)) }
            td { (status::said(shape, state)) }
            td.nowrap {
                @if open { progress value=(settled) max=(counts.campaigns) aria-label=(t.progress) {} " " }
                (settled) " / " (counts.campaigns)
            }
            td.n { (counts.failed) }
            td { (or_dash(order.ended_at.as_deref().map(written))) }
            td { @if open && viewer.may(Role::Engineer) {
                form action={ "/diagnoses/" (order.id) "/cancel" } method="post" { button { (t.cancel) } }
            } }
        }
    }
}

fn which(t: &Text, asked: &WhichBody) -> Markup {
    let all = asked.imu.is_none() && asked.station.is_none() && asked.since.is_none() && asked.until.is_none();
    html! {
        @if all { (t.all_campaigns) " " }
        @if let Some(imu) = &asked.imu { (t.imu) " " span translate="no" { (imu) } " " }
        @if let Some(station) = &asked.station { (t.station) " " span translate="no" { (station) } " " }
        @if let Some(since) = &asked.since { (t.measured_since) " " (written(since)) " " }
        @if let Some(until) = &asked.until { (t.measured_until) " " (written(until)) " " }
        @if asked.again { span.quiet { (t.again_short) } }
    }
}

fn failures(t: &Text, failures: &[FailureBody]) -> Markup {
    html! {
        (wide_table("", html! {
            th { (t.imu) } th { (t.campaign) } th { (t.why) }
        }, html! { @for failure in failures { tr {
            td translate="no" { (failure.imu) }
            td { a href={ "/campaigns/" (failure.campaign) } { (written(&failure.measured_at)) } }
            td.words { (failure.reason) }
        } } }))
    }
}

/// A form that begins an order, with what was written into it.
pub(super) fn form(t: &Text, wanted: &DiagnosisForm, wrong: Option<&Faults>) -> Markup {
    html! {
        section {
            h2 { (t.new_order) }
            p.note { (t.new_order_note) }
            @if let Some(wrong) = wrong { (fault_list(t, wrong)) }
            form.deed action="/diagnoses" method="post" {
                label { (t.imu) input name="imu" value=(wanted.imu) placeholder=(t.any); }
                label { (t.station) input name="station" value=(wanted.station) placeholder=(t.any); }
                label { (t.measured_since) input type="date" name="since" value=(wanted.since); }
                label { (t.measured_until) input type="date" name="until" value=(wanted.until); }
                label.sure { input type="checkbox" name="again" value="yes" checked[wanted.again == "yes"]; span { (t.again_word) } }
                p { button.primary { (t.start_order) } }
            }
        }
    }
}

/// A date stands for its first instant, in UTC.
pub(super) fn beginning(text: &str) -> Option<String> {
    said(text).map(|text| if time::is_day(&text) { text + "T00:00:00Z" } else { text })
}

/// A date stands for its last instant, in UTC.
fn end(text: &str) -> Option<String> {
    said(text).map(|text| if time::is_day(&text) { text + "T23:59:59.999999Z" } else { text })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_stands_for_the_whole_day_and_a_time_for_itself() {
        assert_eq!(beginning(" 2026-03-01 ").as_deref(), Some("2026-03-01T00:00:00Z"));
        assert_eq!(end("2026-03-01").as_deref(), Some("2026-03-01T23:59:59.999999Z"));
        assert_eq!(end("2026-03-01T08:00:00Z").as_deref(), Some("2026-03-01T08:00:00Z"));
        assert_eq!((beginning(""), end("  ")), (None, None));
    }
}
