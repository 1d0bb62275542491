//! `/setup`: the limits in force and where each comes from; who may use the service, and what was done with it.

use super::prelude::*;
use crate::config::{Config, Layer};
use crate::core::access::{AuditEntry, AuditFilter, Token};
use crate::core::judge::Limit;
use crate::core::judge::limits::{Bounds, LimitKey, Requirement};
use crate::core::mounting::Slot;

/// Lines of the audit trail that are shown.
const LINES: u32 = 50;

/// What the audit trail calls what was done, and the code of its words.
const ACTIONS: [(&str, &str); 31] = [
    ("store", "audit_store"),
    ("revise", "audit_revise"),
    ("void", "audit_void"),
    ("confirm", "audit_confirm"),
    ("suspect", "audit_suspect"),
    ("suspect window", "audit_suspect_window"),
    ("trust window", "audit_trust_window"),
    ("mark event", "audit_mark_event"),
    ("set attributes", "audit_set_attributes"),
    ("adopt model", "audit_adopt_model"),
    ("acknowledge", "audit_acknowledge"),
    ("unacknowledge", "audit_unacknowledge"),
    ("silence", "audit_silence"),
    ("unsilence", "audit_unsilence"),
    ("comment", "audit_comment"),
    ("begin silence", "audit_begin_silence"),
    ("end silence", "audit_end_silence"),
    ("create hook", "audit_create_hook"),
    ("change hook", "audit_change_hook"),
    ("disable hook", "audit_disable_hook"),
    ("delete hook", "audit_delete_hook"),
    ("test hook", "audit_test_hook"),
    ("redeliver", "audit_redeliver"),
    ("sign in", "audit_sign_in"),
    ("sign out", "audit_sign_out"),
    ("create token", "audit_create_token"),
    ("revoke token", "audit_revoke_token"),
    ("start diagnoses", "audit_start_diagnoses"),
    ("cancel diagnoses", "audit_cancel_diagnoses"),
    ("add hypothesis", "audit_add_hypothesis"),
    ("end hypothesis", "audit_end_hypothesis"),
];

/// What was done, in the viewer's language; as the trail has it where there are no words for it.
fn action<'a>(t: &Text, done: &'a str) -> &'a str {
    let known = ACTIONS.iter().find(|(action, _)| *action == done);
    known.map_or(done, |(_, code)| t.language().word(code))
}

pub(super) async fn page(PageContext(ref pages, ref viewer): PageContext) -> Result<Page, Problem> {
    let t = viewer.text();
    let access = match viewer.may(Role::Admin) {
        true => {
            let tokens = pages.pipeline.access.tokens().await?;
            let audit = pages.pipeline.access.audit(&AuditFilter::default(), None, LINES).await?;
            html! { (self::tokens(pages, t, &tokens)) (trail(t, &audit)) }
        }
        false => html! {},
    };
    let body = html! {
        h1 { (t.setup) }
        p {
            a href="/hooks" { (t.hooks) } " · " a href="/docs" { (t.api) }
        }
        (limits(t, &pages.config))
        (access)
    };
    Ok(Page { title: t.setup.into(), section: Section::Setup, body })
}

/// A key, and whether its value is a default, or a file's, or the environment's.
fn set_by(t: &Text, config: &Config, from: LimitKey) -> Markup {
    let key = from.to_string();
    let layer = match config.stated.layer_of(&key) {
        Layer::Default => t.layer_default,
        Layer::File => t.layer_file,
        Layer::Environment => t.layer_environment,
    };
    html! { code { (key) } " " span.quiet { (layer) } }
}

fn limits(t: &Text, config: &Config) -> Markup {
    let judging = &config.judging;
    let limits = judging.limits("", "");
    let row = |name: &str, rule: Rule, limit: Limit, unit: &str| {
        html! {
            tr {
                td { (symbol(name)) } th scope="row" { (t.rule(rule)) }
                td.n { (figure::limit(rule, limit)) } td { (unit) } td { (set_by(t, config, limit.from)) }
            }
        }
    };
    html! {
        section {
            h2 { (t.setup_limits) }
            p.note { (t.limits_note) }
            (wide_table("", html! {
                th { (t.coefficient) } th { (t.rule_word) }
                th.n { (t.limit) } th { (t.unit_word) } th { (t.set_by_key) }
            }, html! {
                @for (name, drift) in DRIFTS.iter().zip([&limits.d_i, &limits.d_s]) {
                    @for rule in Rule::ALL { @if let Some(limit) = drift.stated(rule) { (row(name, rule, limit, t.unit)) } }
                }
                @if let Some(closure) = limits.closure { (row(DRIFTS[2], Rule::Closure, closure, t.unit)) }
                @if let Some(interval) = limits.interval_days { (row("all", Rule::Overdue, interval, t.days_word)) }
            }))
            (requirements(t, config))
            @if !judging.overrides.is_empty() {
                h3 { (t.overrides) }
                ul { @for (place, one) in judging.overrides.iter().enumerate() {
                    li {
                        code { "judging.overrides[" (place) "]" } " "
                        @if let Some(imu) = &one.imu { (t.imu) " " span translate="no" { (imu) } " " }
                        @if let Some(serial) = &one.serial { (t.serial) " " span translate="no" { (serial) } " " }
                        @if let Some(budget) = one.budget { (t.budget_line) " " (figure::short(budget)) }
                    }
                } }
            }
        }
    }
}

/// What E and G of gyros of the skewed geometry must keep.
fn requirements(t: &Text, config: &Config) -> Markup {
    let required = Slot::ALL.map(|slot| (slot, config.judging.requirement(true, slot, "", "")));
    let names = ["|E|", "E_x", "E_y", "E_z", "G_x", "G_y", "G_z"];
    let bounds = |of: &Requirement| {
        let all = std::iter::once(of.e_norm).chain(of.e).chain(of.g);
        names.into_iter().zip(all).filter_map(|(name, bounds)| Some((name, bounds?))).collect::<Vec<_>>()
    };
    let unit = |name: &str| if name.starts_with('G') { "pulse/(s g0)" } else { "pulse/arcsec" };
    let any = required.iter().any(|(_, of)| !bounds(of).is_empty());
    html! {
        h3.capital { (t.rule(Rule::Requirement)) }
        @if any {
            (wide_table("small", html! {
                th { (t.slot) } th { (t.parameter) } th.n { (t.limit) } th { (t.unit_word) } th { (t.set_by_key) }
            }, html! { @for (slot, of) in &required { @for (name, Bounds { low, high, from }) in bounds(of) { tr {
                td { (slot.name()) } th scope="row" { (symbol(name)) }
                td.n { (low) " … " (high) } td { (t.unit_of(unit(name))) } td { (set_by(t, config, from)) }
            } } } }))
        } @else {
            p { (t.nothing_required) " " (set_by(t, config, LimitKey { place: None, key: "requirements" })) }
        }
    }
}

fn tokens(pages: &Pages, t: &Text, tokens: &[Token]) -> Markup {
    let now = pages.clock.now();
    html! {
        section {
            h2 { (t.tokens) }
            p.note { (t.tokens_note) }
            @if tokens.is_empty() { p { (t.no_tokens) } } @else { (wide_table("", html! {
                th { (t.name_word) } th { (t.role_word) } th { (t.station) }
                th { (t.created) } th { (t.expires) } th { (t.status_word) }
            }, html! { @for token in tokens { tr {
                th scope="row" translate="no" { (token.name) }
                td { (t.role(token.role)) }
                td translate="no" { (token.station.as_deref().unwrap_or("–")) }
                td { (instant(token.created_at)) }
                td { @if let Some(at) = token.expires_at { (instant(at)) } @else { (t.never) } }
                td { @if token.is_valid(now) { (t.valid) } @else { span.quiet { (t.not_valid) } } }
            } } })) }
        }
    }
}

fn trail(t: &Text, lines: &[AuditEntry]) -> Markup {
    html! {
        section {
            h2 { (t.audit) }
            p.note { (t.audit_note) " " code { "GET /v1/audit" } }
            (wide_table("", html! {
                th { (t.date) } th { (t.name_word) } th { (t.what_word) } th { (t.subject) } th { (t.from_where) }
            }, html! { @for line in lines { tr {
                td { (instant(line.at)) }
                td translate="no" { (line.who) }
                td { (action(t, &line.action)) }
                td translate="no" { code { (line.subject) } }
                td translate="no" { (line.source) }
            } } }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn the_trail_is_told_in_the_language_of_the_page() {
        let [english, chinese] = [Language::English, Language::Chinese].map(Language::text);
        for (done, _) in ACTIONS {
            assert_eq!(action(english, done), done);
            assert!(!action(chinese, done).is_empty() && !action(chinese, done).is_ascii(), "{done}");
        }
        assert_eq!(action(chinese, "of tomorrow"), "of tomorrow");
    }
}
