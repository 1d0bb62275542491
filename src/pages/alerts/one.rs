//! `/alerts/{id}`: one alert, what became of it step by step, and what people said.

use super::table::table;
use crate::core::alert_decision::Action;
use crate::core::gyro_event::GyroEvent;
use crate::pages::form::who;
use crate::pages::gyro_head::doubts;
use crate::pages::history::event_name;
use crate::pages::prelude::*;
use crate::pipeline::AlertStep;

pub(in crate::pages) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref id): Path<String>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let number = problem::id(id, Problem::unknown_alert)?;
    let record = pages.pipeline.alerts.get(number).await?.ok_or_else(|| Problem::unknown_alert(id))?;
    let alert = &record.alert;
    let here = format!("/alerts/{}", alert.id);
    let of_gyro = format!("/alerts?state=all&serial={}", encoded(&alert.serial));
    let gyro = pages.pipeline.queries.names().gyro_number(&alert.serial);
    let events = match gyro {
        Some(gyro) if alert.is_of_gyro() => pages.pipeline.queries.histories.events(gyro).await?,
        _ => Vec::new(),
    };
    let of_record = alert.finding.record.as_ref().filter(|_| alert.is_of_gyro()).and_then(|id| id.parse::<Id>().ok());
    let judged = match of_record {
        Some(id) => pages.pipeline.queries.records.record(id).await?.map(|stored| (id, stored.answer.notes)),
        None => None,
    };
    let doubted = judged.map(|(id, notes)| {
        (id, notes.into_iter().filter(|note| note.doubts_figures_of(alert.name())).collect::<Vec<_>>())
    });
    let inhibited = pages.pipeline.alerts.inhibited_by(number).await?;
    let body = html! {
        h1 { (t.alert) " · " span.id { (alert.name()) } " " (symbol(&alert.coefficient)) }
        (table(viewer, std::iter::once(alert), true, Some(&here)))
        @if let Some((id, notes)) = doubted { (doubts(t, id, &notes)) }
        @if !inhibited.is_empty() {
            h2 { (t.inhibited_by_it) }
            (table(viewer, inhibited.iter(), true, None))
        }
        h2 { (t.what_became) }
        (wide_table("", html! {
            th { (t.date) } th { (t.what_word) } th { (t.author) } th { (t.reason_word) } th { (t.told_word) }
        }, html! { @for step in record.steps.iter().rev() {
            @let event = ended_by(step, &events);
            @let author = step.author.as_deref().or(event.and_then(|event| event.author.as_deref()));
            @let reason = step.reason.as_ref().map(|reason| t.words(reason));
            @let reason = reason.as_deref().or(event.map(|event| event.reason.as_str()));
            tr {
                td { (instant(step.at)) }
                td { (t.alert_step(&step.action)) }
                td translate="no" { (author.unwrap_or_default()) }
                td.words {
                    @if let Some(event) = event { (event_name(t, event)) " " (instant(event.at)) (t.colon) }
                    (reason.unwrap_or_default())
                }
                td { @if step.told { (t.told_yes) } }
            }
        } }))
        @if viewer.may(Role::Engineer) {
            h2 { (t.comment) }
            form.deed action="/alerts/bulk" method="post" {
                input type="hidden" name="alert" value=(alert.id);
                input type="hidden" name="deed" value="comment";
                input type="hidden" name="back" value=(here);
                (who(t, viewer.signed_in.as_deref().unwrap_or_default()))
                label { (t.reason_word) textarea name="reason" rows="3" required maxlength="4096" {} }
                p { button.primary { (t.comment) } }
            }
        }
        @if alert.is_of_gyro() { p { a href=(of_gyro) { (t.alerts_of_gyro) } } }
    };
    Ok(Page { title: format!("{} {}", t.alert, alert.name()), section: Section::Alerts, body })
}

/// The event that ended an alert: one that cut its history off, for nobody has said why it ended.
fn ended_by<'a>(step: &AlertStep, events: &'a [(Id, GyroEvent)]) -> Option<&'a GyroEvent> {
    if step.action != Action::Resolve.name() || step.author.is_some() {
        return None;
    }
    let rule = Rule::from_name(&step.alert.rule).filter(|rule| *rule != Rule::Overdue)?;
    let at = |text: &Option<String>| time::parse(text.as_deref()?).ok();
    let (since, judged) = (at(&step.alert.since)?, at(&step.alert.finding.calibrated_at)?);
    // What was judged after it, with figures, ended by itself.
    let cuts = |(id, event): &&(Id, GyroEvent)| {
        let is_between = since < event.at && (judged <= event.at || step.alert.finding.value.is_none());
        *id < step.id && event.event.resets(rule) && is_between
    };
    events.iter().filter(cuts).max_by_key(|(id, _)| *id).map(|(_, event)| event)
}
