//! What each hook has heard, and what it is to be told.

use std::cmp::Reverse;

use super::show::{self, DIGEST};
use crate::core::alert_decision::{self, Action};
use crate::core::judge::Severity;
use crate::pipeline::alerts::AlertUpdate;
use crate::pipeline::prelude::*;
use crate::store::{DeliverySubject, HookRow, IdSource, NewDelivery, OutboxChanges, Part};
use crate::wire::alert::AlertBody;
use crate::wire::hook::{DigestBody, FilterBody};
use crate::wire::json;

/// Alerts of one message; more of them are several messages.
const MOST_OF_A_MESSAGE: usize = 1000;

/// Alerts from which on it is forgotten what has been heard of them.
const MOST_ALERTS: usize = 10_000;

/// The enabled hooks, what each wants to hear, and what it has heard of the alerts that are looked at.
#[derive(Debug, Default)]
pub(crate) struct HookCache {
    /// None before they are read.
    hooks: Option<Vec<Subscription>>,
    /// By alert: the hooks that have heard that it fires, with which severity.
    heard: HashMap<Id, HashMap<Id, Severity>>,
}

/// A hook that listens.
#[derive(Debug, Clone)]
pub(crate) struct Subscription {
    pub hook: Id,
    pub filter: FilterBody,
    pub batch: bool,
}

impl Subscription {
    pub fn of(row: &HookRow) -> Result<Self, StoreError> {
        Ok(Self { hook: row.id, filter: show::filter(row)?, batch: row.batch })
    }
}

/// Where what hooks are told is written.
pub(crate) struct OutboxContext<'a> {
    pub now: UtcMicros,
    pub ids: &'a mut IdSource,
    pub outbox: &'a mut OutboxChanges,
}

impl OutboxContext<'_> {
    fn enter(
        &mut self,
        hook: Id,
        subject: DeliverySubject,
        action: Option<&'static str>,
        parts: Vec<Part>,
        digest: Option<String>,
    ) {
        let (id, queued_at) = (self.ids.next(self.now), self.now);
        self.outbox.queued.push(NewDelivery { id, hook, subject, queued_at, action, parts, digest });
    }
}

impl HookCache {
    /// What was noted is not what was committed, or hooks have changed: all is read again before it is used.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Others have written about alerts.
    pub fn forget_heard(&mut self) {
        self.heard.clear();
    }

    /// Keeps the memory within its bounds, when all that was noted is stored.
    pub fn tidy(&mut self) {
        if self.heard.len() > MOST_ALERTS {
            self.heard.clear();
        }
    }

    /// Reads the hooks, where they are not known, and what they have heard of these alerts.
    pub async fn recall(&mut self, store: &Store, news: &[AlertUpdate]) -> Result<(), StoreError> {
        if self.hooks.is_none() {
            let enabled = store::hook::all(store).await?.into_iter().filter(|hook| hook.enabled);
            self.hooks = Some(enabled.map(|hook| Subscription::of(&hook)).collect::<Result<_, _>>()?);
        }
        let unknown: BTreeSet<Id> = news.iter().map(|news| news.id).filter(|id| !self.heard.contains_key(id)).collect();
        if self.subscriptions().is_empty() || unknown.is_empty() {
            return Ok(());
        }
        let unknown: Vec<Id> = unknown.into_iter().collect();
        let heard = store::hook::heard_of(store, &unknown).await?;
        self.heard.extend(unknown.into_iter().map(|alert| (alert, HashMap::new())));
        for (hook, alert, severity) in heard {
            let unknown = || StoreError::damaged(format_args!("what hook {hook} has heard: unknown severity"));
            let severity = Severity::from_name(&severity).ok_or_else(unknown)?;
            self.heard.entry(alert).or_default().insert(hook, severity);
        }
        Ok(())
    }

    fn subscriptions(&self) -> &[Subscription] {
        self.hooks.as_deref().unwrap_or_default()
    }

    /// Queues what each hook is to be told of what has become of alerts.
    pub fn notify(&mut self, news: &[AlertUpdate], context: &mut OutboxContext<'_>) -> Result<(), StoreError> {
        for subscription in self.subscriptions().to_vec() {
            // All that one record has caused; without batches each change by itself.
            let mut messages: Vec<(Option<Id>, Vec<Notification<'_>>)> = Vec::new();
            for one in news {
                let Some(told) = self.notification_for(&subscription, one, context)? else { continue };
                match messages.iter_mut().find(|(cause, _)| subscription.batch && *cause == one.cause) {
                    Some((_, all)) => add(all, told),
                    None => messages.push((one.cause, vec![told])),
                }
            }
            messages.into_iter().for_each(|(_, told)| queue(subscription.hook, told, context));
        }
        Ok(())
    }

    /// Queues the digest of an import: for each hook one message about all that it lets through.
    pub fn notify_digest(&mut self, news: &[AlertUpdate], context: &mut OutboxContext<'_>) -> Result<(), StoreError> {
        for subscription in self.subscriptions().to_vec() {
            let heard = news.iter().filter_map(|one| self.notification_for(&subscription, one, context).transpose());
            let mut told: Vec<Notification<'_>> = heard.collect::<Result<_, _>>()?;
            if told.is_empty() {
                continue;
            }
            told.sort_by_key(Notification::rank);
            let digest = json::written(&DigestBody::of(&told.iter().map(|one| one.body).collect::<Vec<_>>()));
            let parts = told.into_iter().map(|one| one.part).collect();
            context.enter(subscription.hook, DeliverySubject::Many, Some(DIGEST), parts, Some(digest));
        }
        Ok(())
    }

    /// What a hook is told of one piece of news; it has heard that then.
    fn notification_for<'n>(
        &mut self,
        subscription: &Subscription,
        news: &'n AlertUpdate,
        context: &mut OutboxContext<'_>,
    ) -> Result<Option<Notification<'n>>, StoreError> {
        let heard = self.heard.entry(news.id).or_default();
        let told = notification(subscription, heard.get(&subscription.hook).copied(), news, context)?;
        match &told {
            Some(told) if told.action == Action::Resolve => drop(heard.remove(&subscription.hook)),
            Some(told) => drop(heard.insert(subscription.hook, told.severity)),
            None => {}
        }
        Ok(told)
    }
}

/// What a hook that has `heard` so of an alert is told of one piece of news.
fn notification<'n>(
    subscription: &Subscription,
    heard: Option<Severity>,
    news: &'n AlertUpdate,
    context: &mut OutboxContext<'_>,
) -> Result<Option<Notification<'n>>, StoreError> {
    let AlertUpdate { id, alert, step, .. } = *news;
    let damaged = || StoreError::damaged(format_args!("what has become of alert {id} cannot be read"));
    let body = news.body.as_ref().ok_or_else(damaged)?;
    let action = alert_decision::for_hook(&alert, heard, news.action, context.now);
    let Some(action) = action.filter(|action| bypasses_filter(*action) || subscription.filter.wants(body)) else {
        return Ok(None);
    };
    let hears = (action != Action::Resolve).then_some(alert.severity);
    context.outbox.heard.push((subscription.hook, id, hears));
    let part = Part { alert: id, action: action.name(), step, body: step.is_none().then(|| body.kept()) };
    Ok(Some(Notification { severity: alert.severity, action, part, body }))
}

/// Tells a hook that begins to listen, or to more than before, how things stand: what fires and it has not heard, and
/// the end of what it has heard fire. `heard`: what it has heard.
pub(crate) fn introduce<'a>(
    subscription: &Subscription,
    heard: &HashMap<Id, Severity>,
    alerts: impl Iterator<Item = &'a AlertUpdate>,
    context: &mut OutboxContext<'_>,
) -> Result<(), StoreError> {
    let told =
        alerts.filter_map(|one| notification(subscription, heard.get(&one.id).copied(), one, context).transpose());
    let told: Vec<Notification<'_>> = told.collect::<Result<_, _>>()?;
    if subscription.batch {
        queue(subscription.hook, told, context);
    } else {
        told.into_iter().for_each(|one| queue(subscription.hook, vec![one], context));
    }
    Ok(())
}

/// A hook that was told that an alert fires is told that it is less grave, or ends, whatever the filter lets through.
fn bypasses_filter(action: Action) -> bool {
    matches!(action, Action::Lower | Action::Resolve)
}

/// An alert of a message under construction.
struct Notification<'n> {
    severity: Severity,
    action: Action,
    part: Part,
    /// The alert as clients read it.
    body: &'n AlertBody,
}

impl Notification<'_> {
    /// The gravest comes first.
    fn rank(&self) -> (bool, Reverse<Severity>, u8) {
        let urgency = match self.action {
            Action::Escalate => 0,
            Action::Fire => 1,
            Action::Lower | Action::Repeat => 2,
            Action::Resolve | Action::Silent => 3,
        };
        (self.action == Action::Resolve, Reverse(self.severity), urgency)
    }
}

/// One message tells of an alert once: what it comes to.
fn add<'n>(all: &mut Vec<Notification<'n>>, new: Notification<'n>) {
    let Some(place) = all.iter().position(|told| told.part.alert == new.part.alert) else {
        return all.push(new);
    };
    match (all[place].action, new.action) {
        // It never heard that it fires.
        (Action::Fire, Action::Resolve) => drop(all.remove(place)),
        (Action::Fire, _) => {
            let part = Part { action: Action::Fire.name(), ..new.part };
            all[place] = Notification { action: Action::Fire, part, ..new };
        }
        _ => all[place] = new,
    }
}

/// Queues one message, the gravest alert first; several where there are very many.
fn queue(hook: Id, mut told: Vec<Notification<'_>>, context: &mut OutboxContext<'_>) {
    told.sort_by_key(Notification::rank);
    let parts: Vec<Part> = told.into_iter().map(|one| one.part).collect();
    for parts in parts.chunks(MOST_OF_A_MESSAGE) {
        let (subject, of_many) = match *parts {
            [Part { alert, step: Some(step), .. }] => (DeliverySubject::Step { step, alert }, Vec::new()),
            _ => (DeliverySubject::Many, parts.to_vec()),
        };
        context.enter(hook, subject, parts.first().map(|part| part.action), of_many, None);
    }
}
