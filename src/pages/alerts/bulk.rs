//! One word for many alerts: of the gyros that are ticked, or of those that are named.

use super::table::{known, open_ones, table};
use crate::core::alert_decision::AlertState;
use crate::core::fault::Fault;
use crate::pages::form::{fault_list, see_other, who};
use crate::pages::prelude::*;
use crate::pages::silences::{days_field, silent_until};
use crate::pages::viewer::is_local;
use crate::pipeline::{AlertChange, AlertOrder};
use crate::wire::text;

/// Alerts of one form, and gyros that are looked through for them.
const MOST: usize = 500;
/// Alerts of which an address says what has just been done to them.
const MOST_DONE: usize = 60;

/// What is said of alerts, and of which.
#[derive(Debug, Default)]
struct BulkForm {
    gyros: Vec<String>,
    alerts: Vec<String>,
    deed: String,
    by: String,
    reason: String,
    days: String,
    back: String,
}

impl BulkForm {
    fn of(fields: Vec<(String, String)>) -> Self {
        let mut said = Self::default();
        for (name, value) in fields {
            match name.as_str() {
                "gyro" => said.gyros.push(value),
                "alert" => said.alerts.push(value),
                "deed" => said.deed = value,
                "by" => said.by = value,
                "reason" => said.reason = value,
                "days" => said.days = value,
                "back" => said.back = value,
                _ => {}
            }
        }
        said
    }

    fn back(&self) -> &str {
        if is_local(&self.back) { &self.back } else { "/alerts" }
    }

    /// The alerts that are meant: of a gyro all that are not resolved.
    async fn found(&self, pages: &Pages) -> Result<Vec<AlertBody>, Problem> {
        let mut found: Vec<AlertBody> = Vec::new();
        for serial in self.gyros.iter().take(MOST) {
            let gyro = pages.pipeline.queries.names().gyro_number(serial);
            let gyro = gyro.ok_or_else(|| Problem::unknown_gyro(serial))?;
            found.extend(open_ones(pages, gyro).await?);
        }
        for id in self.alerts.iter().take(MOST) {
            found.push(known(pages, id).await?.1);
        }
        found.truncate(MOST);
        Ok(found)
    }
}

pub(in crate::pages) async fn ask(
    PageContext(ref pages, ref viewer): PageContext,
    Query(fields): Query<Vec<(String, String)>>,
) -> Result<Page, Problem> {
    let said = BulkForm::of(fields);
    let found = said.found(pages).await?;
    Ok(form(viewer, &said, &found, &Faults::default()))
}

pub(in crate::pages) async fn act(
    PageContext(ref pages, ref viewer): PageContext,
    Form(fields): Form<Vec<(String, String)>>,
) -> Result<Response, Problem> {
    let said = BulkForm::of(fields);
    let found = said.found(pages).await?;
    let by = viewer.signed_in.clone().filter(|_| said.by.trim().is_empty()).unwrap_or_else(|| said.by.clone());
    let mut faults = Faults::default();
    text::required_short("by", by.clone(), &mut faults);
    let change = match said.deed.as_str() {
        "unacknowledge" => AlertChange::Unacknowledge,
        "comment" => AlertChange::Comment,
        "unsilence" => AlertChange::Unsilence,
        "silence" => AlertChange::Silence { until: silent_until(pages, &said.days, &mut faults) },
        _ => AlertChange::Acknowledge,
    };
    let is_brief = !matches!(change, AlertChange::Silence { .. } | AlertChange::Comment);
    // Whoever has signed in is known; that they know of it needs no reason.
    if !(is_brief && viewer.signed_in.is_some() && said.reason.trim().is_empty()) {
        text::required_note("reason", said.reason.clone(), &mut faults);
    }
    if found.is_empty() {
        faults.0.push(Fault { pointer: "alert".into(), message: message!("no_alert_selected") });
    }
    if !faults.is_empty() {
        return Ok((StatusCode::UNPROCESSABLE_ENTITY, form(viewer, &said, &found, &faults)).into_response());
    }
    let mut done = Vec::new();
    for alert in &found {
        let Ok(id) = alert.id.parse::<Id>() else { continue };
        // Who knows already has said so better.
        if change == AlertChange::Acknowledge && alert.acknowledged.is_some() {
            continue;
        }
        let order = AlertOrder { alert: id, change, by: by.clone(), reason: said.reason.trim().to_owned() };
        pages.pipeline.alerts.change(order).await?;
        done.push(alert.id.clone());
    }
    let back = said.back();
    let is_list = back == "/" || back == "/alerts" || back.starts_with("/alerts?");
    if undo_of(change.name()).is_some() && is_list && (1..=MOST_DONE).contains(&done.len()) {
        let joint = if back.contains('?') { '&' } else { '?' };
        return Ok(see_other(&format!("{back}{joint}deed={}&done={}", change.name(), done.join(","))));
    }
    Ok(see_other(back))
}

fn form(viewer: &Viewer, said: &BulkForm, found: &[AlertBody], faults: &Faults) -> Page {
    let t = viewer.text();
    let by = if said.by.is_empty() { viewer.signed_in.as_deref().unwrap_or_default() } else { &said.by };
    let deeds = [
        ("acknowledge", t.acknowledge),
        ("silence", t.silence),
        ("comment", t.comment),
        ("unacknowledge", t.unacknowledge),
        ("unsilence", t.unsilence),
    ];
    let chosen = deeds.iter().position(|(name, _)| *name == said.deed).unwrap_or(0);
    let body = html! {
        h1 { (t.bulk_title) }
        (fault_list(t, faults))
        @if found.is_empty() { p.lead { (t.no_alerts) } } @else { (table(viewer, found.iter(), true, None)) }
        p.note { strong { (t.acknowledge) (t.colon) } (t.acknowledge_what) }
        p.note { strong { (t.silence) (t.colon) } (t.silence_what) }
        form.deed action="/alerts/bulk" method="post" {
            input type="hidden" name="back" value=(said.back());
            @for alert in found { input type="hidden" name="alert" value=(alert.id); }
            label { (t.action_word) select name="deed" {
                @for (k, (name, word)) in deeds.iter().enumerate() { option value=(name) selected[k == chosen] { (word) } }
            } }
            (who(t, by))
            label { (t.reason_word) textarea name="reason" rows="3" maxlength="4096" required[viewer.signed_in.is_none()] { (said.reason) } }
            (days_field(t, &said.days, false))
            p { button.primary { (t.confirm_short) } " " a href=(said.back()) { (t.go_back) } }
        }
    };
    Page { title: t.bulk_title.into(), section: Section::Alerts, body }
}

/// One form for the gyros that are ticked.
pub(super) fn bar(viewer: &Viewer, here: &str) -> Markup {
    let t = viewer.text();
    let deeds = [("acknowledge", t.acknowledge), ("silence", t.silence), ("comment", t.comment)];
    html! {
        form.selection.no-print #bulk method="post" action="/alerts/bulk" {
            input type="hidden" name="back" value=(here);
            label hidden { input type="checkbox" data-all="gyro"; " " (t.all_of_them) }
            span.quiet { (t.with_selected) }
            @if viewer.signed_in.is_none() {
                label { (t.who) " " input name="by" maxlength="128" autocomplete="name" size="10"; }
            }
            label { (t.reason_word) " " input name="reason" maxlength="4096" size="16"; }
            (days_field(t, "", false))
            @for (name, word) in deeds { button name="deed" value=(name) { (word) } }
        }
    }
}

/// At once for whoever has signed in; others are asked who they are.
pub(super) fn acknowledge(viewer: &Viewer, serial: &str, here: &str) -> Markup {
    let method = if viewer.signed_in.is_some() { "post" } else { "get" };
    html! {
        form.no-print action="/alerts/bulk" method=(method) {
            input type="hidden" name="gyro" value=(serial);
            input type="hidden" name="deed" value="acknowledge";
            input type="hidden" name="back" value=(here);
            button { (viewer.text().acknowledge) }
        }
    }
}

/// How alerts stand after a deed, and the deed that takes it back.
fn undo_of(deed: &str) -> Option<(AlertState, &'static str)> {
    match deed {
        "acknowledge" => Some((AlertState::Acknowledged, "unacknowledge")),
        "silence" => Some((AlertState::Silenced, "unsilence")),
        _ => None,
    }
}

/// What has just been done to alerts, parted by commas, and the way to take that back.
pub(in crate::pages) fn done(viewer: &Viewer, deed: &str, alerts: &str, here: &str) -> Markup {
    let t = viewer.text();
    let Some((standing, undo)) = undo_of(deed) else { return html! {} };
    let ids: Vec<&str> = alerts.split(',').filter(|id| id.parse::<Id>().is_ok()).take(MOST_DONE).collect();
    let method = if viewer.signed_in.is_some() { "post" } else { "get" };
    html! {
        @if !ids.is_empty() {
            form.done role="status" action="/alerts/bulk" method=(method) {
                span { (t.standing(standing.name())) (t.colon) (ids.len()) }
                input type="hidden" name="deed" value=(undo);
                input type="hidden" name="back" value=(here);
                @for id in ids { input type="hidden" name="alert" value=(id); }
                button { (t.undo) }
            }
        }
    }
}
