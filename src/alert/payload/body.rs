//! What bodies of all dialects share.

use serde::Serialize;

use crate::alert::message::HookEvent;
use crate::core::judge::Severity;
use crate::core::message::text;
use crate::core::time::UtcMicros;
use crate::message;
use crate::wire::alert::AlertBody;
use crate::words::asked;

/// What a hook is told, ready to be sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Payload {
    pub content_type: &'static str,
    pub body: Vec<u8>,
}

impl Payload {
    pub(super) fn json(content_type: &'static str, body: &impl Serialize) -> Self {
        let body = serde_json::to_vec(body);
        let body = body.expect("bodies have string keys, and every figure in them is finite or written as null");
        Self { content_type, body }
    }
}

/// What bodies say about the service and the hook itself.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The hook's name: the `receiver` of Alertmanager's body.
    pub hook: &'a str,
    /// Where people reach the service's pages, without a slash at its end; none where nobody has said.
    pub external_url: Option<&'a str>,
    /// How often what fires is pushed to an Alertmanager again, in microseconds.
    pub resend_every: i64,
    pub now: UtcMicros,
}

/// Alerts that a digest lists; the rest are counted.
pub(super) const MOST_LISTED: usize = 100;

/// Alerts that a message lists at the most.
pub(super) fn most_listed(event: &HookEvent) -> usize {
    if matches!(event, HookEvent::Digest(..)) { MOST_LISTED } else { usize::MAX }
}

/// The page of what an alert is about: its path alone where nobody has said where the service is reached.
pub(super) fn page(context: &Context<'_>, alert: &AlertBody) -> String {
    context.external_url.unwrap_or_default().to_owned() + &alert.page()
}

pub(super) fn alert_page(context: &Context<'_>, alert: &AlertBody) -> String {
    format!("{}/alerts/{}", context.external_url.unwrap_or_default(), alert.id)
}

/// One line for people: `LFG-0101: D_I step fires (warning)`.
pub(super) fn summary(alert: &AlertBody, resolved: bool) -> String {
    let AlertBody { coefficient, rule, severity, .. } = alert;
    let [serial, coefficient, rule] = [alert.name(), coefficient, rule].map(text);
    asked().words(&match Severity::from_name(severity) {
        Some(severity) if !resolved => {
            message!("alert_fires", serial, coefficient, rule, severity = severity.word())
        }
        _ => message!("alert_is_resolved", serial, coefficient, rule),
    })
}
