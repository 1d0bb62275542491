//! From a message to the body that a hook's target understands: pure mappings, one file a dialect. Everything that
//! tells of a gyro holds a link to its page.

mod alertmanager;
mod body;
mod cloudevents;
mod email;
mod standard;

use super::message::{HookKind, HookMessage};

pub use alertmanager::push_firing;
pub use body::{Context, Payload};

/// Body and headers of a message in the form of one kind of hook.
pub fn render(kind: HookKind, message: &HookMessage, context: &Context<'_>) -> Payload {
    match kind {
        HookKind::StandardWebhooks => standard::render(message, context),
        HookKind::AlertmanagerWebhook => alertmanager::render_webhook(message, context),
        HookKind::Alertmanager => alertmanager::render_push(message, context),
        HookKind::CloudEvents => cloudevents::render(message, context),
        HookKind::Email => email::render(message, context),
    }
}

#[cfg(test)]
mod tests;
