//! E-mail: the subject, an empty line, and what a person reads.

use super::body::{Context, MOST_LISTED, Payload, page, summary};
use crate::alert::message::{AlertTransition, HookEvent, HookMessage};
use crate::message;
use crate::wire::time;
use crate::words::asked;

pub fn render(message: &HookMessage, context: &Context<'_>) -> Payload {
    let changes = message.event.changes();
    let line = |AlertTransition { alert, .. }: &AlertTransition| summary(alert, alert.state == "resolved");
    let subject = match (&message.event, changes) {
        (HookEvent::Test, _) | (_, []) => asked().words(&message!("mail_test", hook = context.hook.to_owned())),
        (_, [only]) => line(only),
        (_, [gravest, rest @ ..]) => {
            let others = rest.len();
            format!("{} (+{others})", line(gravest))
        }
    };
    let mut text = format!("{subject}\n\n");
    for change in changes.iter().take(MOST_LISTED) {
        let finding = &change.alert.finding;
        text.push_str(&format!("{}\n  {}\n", line(change), finding.reason.words(asked())));
        if let (Some(imu), Some(at)) = (&finding.imu, &finding.calibrated_at) {
            text.push_str(&format!("  {imu}, {at}\n"));
        }
        text.push_str(&format!("  {}\n\n", page(context, &change.alert)));
    }
    if changes.len() > MOST_LISTED {
        text.push_str(&format!("+{}\n\n", changes.len() - MOST_LISTED));
    }
    text.push_str(&format!("gyrowatch, {}\n", time::format(message.at)));
    Payload { content_type: "text/plain; charset=utf-8", body: text.into_bytes() }
}
