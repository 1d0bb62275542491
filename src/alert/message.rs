//! What is told, and in whose dialect.

use crate::core::alert_decision::Action;
use crate::core::named::named;
use crate::core::time::UtcMicros;
use crate::wire::alert::AlertBody;
use crate::wire::hook::DigestBody;

named! {
/// The dialect that a hook's target understands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HookKind {
    /// Signed events after the Standard Webhooks specification 1.0.
    StandardWebhooks = "standard-webhooks",
    /// The body that Alertmanager posts to its webhook receivers, version 4.
    AlertmanagerWebhook = "alertmanager-webhook",
    /// An Alertmanager: pushed to `/api/v2/alerts`, again and again while the alert fires.
    Alertmanager = "alertmanager",
    /// CloudEvents 1.0, structured JSON.
    CloudEvents = "cloudevents",
    /// E-mail to the addresses of a `mailto:` URL, by way of the mail server of the configuration.
    Email = "email",
}
}

/// One thing told to a hook. Rendered anew at every attempt; but for an Alertmanager's `endsAt`, always to the same
/// bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct HookMessage {
    /// Stays the same over attempts, replays and hooks: receivers recognise repetitions by it.
    pub id: String,
    /// When it came about, not when it is sent.
    pub at: UtcMicros,
    pub event: HookEvent,
}

#[derive(Debug, Clone, PartialEq)]
pub enum HookEvent {
    /// What has become of alerts, the gravest first; never none.
    Alerts(Vec<AlertTransition>),
    /// What an import has left firing since long ago.
    Digest(DigestBody, Vec<AlertTransition>),
    /// Somebody tries the hook out.
    Test,
}

/// What has become of an alert.
#[derive(Debug, Clone, PartialEq)]
pub struct AlertTransition {
    /// Never [`Action::Silent`]: that is not told.
    pub action: Action,
    pub alert: AlertBody,
}

impl HookEvent {
    /// Its `type` in messages: `alert.fired`, `alerts.digest`, `hook.test`.
    pub fn name(&self) -> &'static str {
        match self {
            HookEvent::Alerts(changes) => event_name(changes.first().map(|change| change.action)),
            HookEvent::Digest(..) => DIGEST_EVENT,
            HookEvent::Test => event_name(None),
        }
    }

    /// The alerts that it tells of, the gravest first; none in a test.
    pub fn changes(&self) -> &[AlertTransition] {
        match self {
            HookEvent::Alerts(changes) | HookEvent::Digest(_, changes) => changes,
            HookEvent::Test => &[],
        }
    }
}

/// Type of a digest's event.
pub const DIGEST_EVENT: &str = "alerts.digest";

/// Type of an event, as Standard Webhooks names it; CloudEvents puts `gyrowatch.` before it. No action: a test.
pub fn event_name(action: Option<Action>) -> &'static str {
    match action {
        Some(Action::Fire) => "alert.fired",
        Some(Action::Escalate) => "alert.escalated",
        Some(Action::Lower) => "alert.lowered",
        Some(Action::Repeat | Action::Silent) => "alert.repeated",
        Some(Action::Resolve) => "alert.resolved",
        None => "hook.test",
    }
}
