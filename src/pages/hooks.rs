//! `/hooks`: whom the service tells, how that goes, and what is done about it.

mod actions;
mod deliveries;

use super::prelude::*;
use super::status;
use crate::core::judge::Severity;
use crate::wire::hook::{FilterBody, HookBody};

pub(super) use crate::pages::hooks::actions::{DeleteHook, add, ask_add, redeliver, redeliver_dead, switch, test};
pub(super) use deliveries::page as one;

pub(super) async fn page(PageContext(ref pages, ref viewer): PageContext) -> Result<Page, Problem> {
    let t = viewer.text();
    let hooks = pages.pipeline.hooks.all().await?;
    let body = html! {
        h1 { (t.hooks) }
        p.note { (t.hooks_note) }
        @if viewer.may(Role::Admin) { p { a.action href="/hooks/new" { (t.add_hook) } } }
        @if hooks.is_empty() { p.lead { (t.no_hooks) } } @else {
            (wide_table("cards", html! {
                th { (t.hook) } th { (t.kind) } th { (t.hook_url) } th { (t.status_word) }
                th.n { (t.open_deliveries) } th.n { (t.dead_letters) } th { (t.actions_word) }
            }, html! { @for hook in &hooks { (line(viewer, hook)) } }))
        }
    };
    Ok(Page { title: t.hooks.into(), section: Section::Hooks, body })
}

fn line(viewer: &Viewer, hook: &HookBody) -> Markup {
    let t = viewer.text();
    html! {
        tr {
            th scope="row" translate="no" { a href={ "/hooks/" (hook.id) } { (hook.name) } }
            td.nowrap { (hook.kind) }
            td.words { code { (hook.url) } (filter(t, &hook.filter)) }
            td { (state(t, hook)) }
            td.n data-label=(t.open_deliveries) {
                (hook.queue.open)
                @if let Some(oldest) = &hook.queue.oldest_open { br; span.quiet { (written(oldest)) } }
            }
            td.n data-label=(t.dead_letters) {
                @if hook.queue.dead > 0 { a href={ "/hooks/" (hook.id) "?state=dead" } { (hook.queue.dead) } } @else { "0" }
            }
            td { (buttons(viewer, hook)) }
        }
    }
}

fn state(t: &Text, hook: &HookBody) -> Markup {
    html! {
        @if hook.enabled { (status::said(Some(Status::InTolerance), t.enabled)) }
        @else { (status::said(Some(Status::OutOfTolerance), t.disabled)) }
        @if let Some(why) = &hook.disabled_because { br; span.quiet { (why) } }
    }
}

/// What it is told of, where that is not everything.
fn filter(t: &Text, filter: &FilterBody) -> Markup {
    let rules: Vec<&str> =
        filter.rules.iter().map(|name| Rule::from_name(name).map_or(name.as_str(), |rule| t.rule(rule))).collect();
    let is_of_confirmed = filter.min_severity.as_deref() == Some(Severity::Critical.name());
    html! {
        @if !rules.is_empty() { br; span.quiet { (t.rule_word) ": " (rules.join(", ")) } }
        @if !filter.gyros.is_empty() { br; span.quiet { (t.serial) ": " (filter.gyros.join(", ")) } }
        @if is_of_confirmed { br; span.quiet { (t.alerts) ": " (t.status(Status::Confirmed)) } }
    }
}

fn buttons(viewer: &Viewer, hook: &HookBody) -> Markup {
    let t = viewer.text();
    let post = |deed: &str| format!("/hooks/{}/{deed}", hook.id);
    html! {
        div.actions {
            @if hook.enabled { form action=(post("test")) method="post" { button { (t.test_hook) } } }
            @if viewer.may(Role::Admin) {
                form action=(post("enabled")) method="post" {
                    input type="hidden" name="enabled" value=(!hook.enabled);
                    button { (if hook.enabled { t.disable } else { t.enable }) }
                }
                a href=(post("delete")) { (t.delete_hook) }
            }
        }
    }
}

/// The hook of that identifier.
async fn known(pages: &Pages, id: &str) -> Result<(Id, HookBody), Problem> {
    let number = problem::id(id, Problem::no_such_hook)?;
    Ok((number, pages.pipeline.hooks.get(number, None).await?.ok_or_else(|| Problem::no_such_hook(id))?))
}
