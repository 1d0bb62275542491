//! Hooks and deliveries as clients read them.

use crate::alert::{DIGEST_EVENT, event_name};
use crate::core::alert_decision::Action;
use crate::core::delivery::{DeliveryState, QueueState};
use crate::pipeline::prelude::*;
use crate::store::{AttemptRow, DeliveryRow, DeliverySubject, HookRow};
use crate::wire::hook::{AttemptBody, DeliveryBody, FilterBody, HookBody, QueueBody};
use crate::wire::message::{MessageBody, from_stored};
use crate::wire::time;
use crate::words;

/// The action of a delivery that is a digest.
pub(super) const DIGEST: &str = "digest";

pub(super) fn hook(row: HookRow, queue: QueueState, now: UtcMicros) -> Result<HookBody, StoreError> {
    let filter = filter(&row)?;
    let expect = row.expect.as_deref().map(serde_json::from_str).transpose();
    let expect =
        expect.map_err(|error| StoreError::damaged(format_args!("what hook {} is to hear: {error}", row.id)))?;
    let old_secret = row.old_secret.filter(|(_, until)| now < *until);
    Ok(HookBody {
        id: row.id.to_string(),
        name: row.name,
        kind: row.kind,
        url: row.url,
        authorized: row.authorization.is_some(),
        signed: row.secret.is_some(),
        old_secret_until: old_secret.map(|(_, until)| time::format(until)),
        filter,
        enabled: row.enabled,
        batch: row.batch,
        expect,
        disabled_because: row.disabled_because.map(|why| words::asked().words(&from_stored(&why))),
        created_at: time::format(row.created_at),
        changed_at: time::format(row.changed_at),
        queue: QueueBody { open: queue.open, oldest_open: queue.oldest_open.map(time::format), dead: queue.dead },
        secret: None,
    })
}

pub(super) fn filter(row: &HookRow) -> Result<FilterBody, StoreError> {
    serde_json::from_str(&row.filter)
        .map_err(|error| StoreError::damaged(format_args!("the filter of hook {}: {error}", row.id)))
}

/// The identifier of a message, the same at every attempt and replay; that of a single step also at every hook.
pub(in crate::pipeline) fn webhook_id(delivery: Id, subject: DeliverySubject) -> String {
    match subject {
        DeliverySubject::Step { step, .. } => format!("evt_{step}"),
        DeliverySubject::Many | DeliverySubject::Test => format!("evt_{delivery}"),
    }
}

pub(super) fn delivery(row: DeliveryRow) -> DeliveryBody {
    let due_at = row.due_at.max(row.queued_at);
    DeliveryBody {
        id: row.id.to_string(),
        hook: row.hook.to_string(),
        webhook_id: webhook_id(row.id, row.subject),
        event: match row.action.as_deref() {
            Some(DIGEST) => DIGEST_EVENT,
            action => event_name(action.and_then(Action::from_name)),
        },
        alert: row.alert.map(|alert| alert.to_string()),
        queued_at: time::format(row.queued_at),
        state: row.state.name(),
        due_at: (row.state == DeliveryState::Waiting).then(|| time::format(due_at)),
        finished_at: row.finished_at.map(time::format),
        attempts: row.attempts.into_iter().map(attempt).collect(),
    }
}

fn attempt(row: AttemptRow) -> AttemptBody {
    let took = Duration::from_micros(row.took_us.unsigned_abs());
    let AttemptRow { status, detail, answer, .. } = row;
    let said = Some(from_stored(&detail)).filter(|_| !detail.is_empty());
    let detail = said.as_ref().map(|said| words::asked().words(said)).unwrap_or_default();
    let message = said.map(|said| MessageBody::of(&said, words::asked()));
    AttemptBody { at: time::format(row.at), status, message, detail, answer, took_ms: took.as_secs_f64() * 1e3 }
}
