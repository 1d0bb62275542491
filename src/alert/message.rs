//! What is told, and in whose dialect.

use crate::core::notify::Action;
use crate::core::time::UtcMicros;
use crate::wire::alert::AlertBody;

/// The dialect that a hook's target understands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HookKind {
    /// Signed events after the Standard Webhooks specification 1.0.
    StandardWebhooks,
    /// The body that Alertmanager posts to its webhook receivers, version 4.
    AlertmanagerWebhook,
    /// An Alertmanager: pushed to `/api/v2/alerts`, again and again while the alert fires.
    Alertmanager,
    /// CloudEvents 1.0, structured JSON.
    CloudEvents,
}

impl HookKind {
    pub const ALL: [HookKind; 4] =
        [HookKind::StandardWebhooks, HookKind::AlertmanagerWebhook, HookKind::Alertmanager, HookKind::CloudEvents];

    pub fn name(self) -> &'static str {
        match self {
            HookKind::StandardWebhooks => "standard-webhooks",
            HookKind::AlertmanagerWebhook => "alertmanager-webhook",
            HookKind::Alertmanager => "alertmanager",
            HookKind::CloudEvents => "cloudevents",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// One thing told to a hook. Rendered anew at every attempt; but for an Alertmanager's `endsAt`, always to the same bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Stays the same over attempts, replays and hooks: receivers recognise repetitions by it.
    pub id: String,
    /// When it came about, not when it is sent.
    pub at: UtcMicros,
    pub event: Event,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Never [`Action::Silent`]: that is not told.
    Alert(Action, Box<AlertBody>),
    /// Somebody tries the hook out.
    Test,
}

impl Event {
    /// Type of the event, as Standard Webhooks names it; CloudEvents puts `gyrowatch.` before it.
    pub fn name(&self) -> &'static str {
        match self {
            Event::Alert(Action::Fire, _) => "alert.fired",
            Event::Alert(Action::Escalate, _) => "alert.escalated",
            Event::Alert(Action::Repeat | Action::Silent, _) => "alert.repeated",
            Event::Alert(Action::Resolve, _) => "alert.resolved",
            Event::Test => "hook.test",
        }
    }
}
