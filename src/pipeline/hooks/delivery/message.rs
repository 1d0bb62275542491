//! From a row of the outbox to a request, and from how it went to what is written down.

use crate::alert::deliver::{Attempt, Courier, DeliveryOutcome, Destination};
use crate::alert::payload::{self, Context, Payload};
use crate::alert::retry_schedule::{RetryDecision, RetrySchedule};
use crate::alert::sign::{self, Secret};
use crate::alert::{AlertTransition, HookEvent, HookKind, HookMessage};
use crate::core::alert_decision::Action;
use crate::core::delivery::DeliveryState;
use crate::core::message::sent;
use crate::pipeline::hooks::{Attempted, Hooks, webhook_id};
use crate::pipeline::prelude::*;
use crate::store::{AttemptRow, DeliverySubject, DueDelivery, HookRow, Progress};
use crate::system;
use crate::wire::alert::AlertBody;
use crate::wire::hook::ExpectBody;
use crate::wire::message::to_stored;

/// How often while another server delivers, or the lease is only late in being renewed.
pub(super) const OFF_DUTY: Duration = Duration::from_secs(1);

/// What all delivery queues share.
pub(super) struct DeliveryContext {
    pub hooks: Hooks,
    pub courier: Courier,
    pub retry_schedule: RetrySchedule,
}

/// A hook, ready to send to.
#[derive(Clone)]
pub(super) struct Addressee {
    pub row: HookRow,
    pub kind: HookKind,
    pub expect: Option<ExpectBody>,
}

impl Addressee {
    pub fn of(row: HookRow) -> Result<Self, String> {
        let kind = HookKind::from_name(&row.kind).ok_or_else(|| format!("unknown kind {:?}", row.kind))?;
        let expect = row.expect.as_deref().map(serde_json::from_str).transpose();
        Ok(Self { kind, expect: expect.map_err(|error| format!("expect: {error}"))?, row })
    }

    /// The secrets that sign now: while one is being replaced, both.
    fn secrets(&self, now: UtcMicros) -> Vec<Secret> {
        let old = self.row.old_secret.as_ref().filter(|(_, until)| now < *until).map(|(secret, _)| secret);
        self.row.secret.iter().chain(old).filter_map(|text| Secret::parse(text).ok()).collect()
    }

    fn destination(&self) -> Destination<'_> {
        let HookRow { url, authorization, .. } = &self.row;
        Destination { kind: self.kind, url, authorization: authorization.as_deref(), expect: self.expect.as_ref() }
    }
}

impl DeliveryContext {
    /// Makes one attempt at a delivery. `never_taken`: alerts whose beginning the target never took.
    pub async fn attempt(&self, to: &Addressee, due: &DueDelivery, never_taken: &HashSet<Id>) -> Attempt {
        let now = self.hooks.clock.now();
        let unsent = |outcome, detail| Attempt { outcome, status: None, detail, answer: None, took: Duration::ZERO };
        match message(due, never_taken) {
            Ok(Some(message)) => {
                let payload = payload::render(to.kind, &message, &self.context(&to.row.name, now));
                self.send(to, &message.id, payload, now).await
            }
            Ok(None) => unsent(DeliveryOutcome::Needless, Some(message!("end_of_what_was_never_told"))),
            Err(why) => {
                let detail = message!("stored_message_unreadable", why);
                unsent(DeliveryOutcome::Failed { retry_after: None }, Some(detail))
            }
        }
    }

    /// Sends what fires to an Alertmanager once more.
    pub async fn resend(&self, to: &Addressee, firing: &[(String, AlertBody)]) -> Attempt {
        let now = self.hooks.clock.now();
        let payload = payload::push_firing(firing, &self.context(&to.row.name, now));
        self.send(to, &format!("resend_{}", now.0), payload, now).await
    }

    async fn send(&self, to: &Addressee, id: &str, payload: Payload, now: UtcMicros) -> Attempt {
        if to.kind == HookKind::Email {
            return self.courier.mail(to.destination(), id, &payload).await;
        }
        let signature = sign::headers(id, now, &payload.body, &to.secrets(now));
        self.courier.attempt(to.destination(), &signature, payload, now).await
    }

    fn context<'a>(&'a self, hook: &'a str, now: UtcMicros) -> Context<'a> {
        let hooks = &self.hooks.config.hooks;
        let resend_every = hooks.resend_every().as_micros() as i64;
        Context { hook, external_url: hooks.external_url(), resend_every, now }
    }
}

/// What a delivery tells, as the target has to hear it: what it never took begins, and does not end. None where
/// nothing is left.
fn message(due: &DueDelivery, never_taken: &HashSet<Id>) -> Result<Option<HookMessage>, Message> {
    let id = webhook_id(due.id, due.subject);
    let at = due.at.unwrap_or(due.queued_at);
    if due.subject == DeliverySubject::Test {
        return Ok(Some(HookMessage { id, at, event: HookEvent::Test }));
    }
    if due.content.is_empty() {
        return Err(message!("stored_message_empty"));
    }
    let changes = due.content.iter().map(|(action, body)| {
        let action = Action::from_name(action).ok_or_else(|| message!("not_done_to_alerts", action = sent(action)))?;
        let alert: AlertBody = serde_json::from_str(body).map_err(Message::verbatim)?;
        let is_news = alert.id.parse().is_ok_and(|id| never_taken.contains(&id));
        Ok(match action {
            Action::Resolve if is_news => None,
            _ if is_news => Some(AlertTransition { action: Action::Fire, alert }),
            _ => Some(AlertTransition { action, alert }),
        })
    });
    let changes: Vec<AlertTransition> = changes.filter_map(Result::transpose).collect::<Result<_, Message>>()?;
    if changes.is_empty() {
        return Ok(None);
    }
    let event = match &due.digest {
        Some(counts) => HookEvent::Digest(serde_json::from_str(counts).map_err(Message::verbatim)?, changes),
        None => HookEvent::Alerts(changes),
    };
    Ok(Some(HookMessage { id, at, event }))
}

/// What is written down of an attempt that was made at `at`.
pub(super) fn report(
    to: &Addressee,
    due: &DueDelivery,
    attempt: &Attempt,
    at: UtcMicros,
    retry_schedule: &RetrySchedule,
) -> Attempted {
    let again = |retry_after| {
        let first = due.first_attempt_at.unwrap_or(at);
        let tried_for = Duration::from_micros(u64::try_from(at.0 - first.0).unwrap_or_default());
        match retry_schedule.next(due.attempts + 1, tried_for, retry_after, jitter()) {
            RetryDecision::RetryIn(wait) => Progress::RetryAt(UtcMicros(at.0.saturating_add(wait.as_micros() as i64))),
            RetryDecision::Dead => Progress::Done(DeliveryState::Dead),
        }
    };
    let progress = match attempt.outcome {
        DeliveryOutcome::Delivered => Progress::Done(DeliveryState::Delivered),
        DeliveryOutcome::Refused | DeliveryOutcome::Gone => Progress::Done(DeliveryState::Dead),
        DeliveryOutcome::Needless => Progress::Done(DeliveryState::Dropped),
        DeliveryOutcome::Failed { retry_after } => again(retry_after),
        DeliveryOutcome::Partly => again(None),
    };
    Attempted {
        attempt: AttemptRow {
            id: Id(0),
            delivery: due.id,
            at,
            status: attempt.status,
            detail: attempt.detail.as_ref().map(to_stored).unwrap_or_default(),
            answer: attempt.answer.clone(),
            took_us: i64::try_from(attempt.took.as_micros()).unwrap_or(i64::MAX),
        },
        hook: due.hook,
        progress,
        gone: (attempt.outcome == DeliveryOutcome::Gone).then(|| to.row.url.clone()),
        hasten: false,
        renotify: false,
        perhaps_written: false,
    }
}

/// From 0 to 1; 0 where the system has no random numbers, which spreads nothing and harms nothing.
fn jitter() -> f64 {
    let mut bytes = [0; 4];
    let _none_is_no_jitter = system::fill_random(&mut bytes);
    f64::from(u32::from_le_bytes(bytes)) / f64::from(u32::MAX)
}
