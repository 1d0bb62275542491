//! What changes hooks and their queues, carried out by the one writer.

use serde::Serialize;

use super::read::{HookPatch, NewHook};
use crate::alert::HookKind;
use crate::core::access::AuditEntry;
use crate::core::alert_decision::{Action, Alert, Status};
use crate::core::delivery::DeliveryState;
use crate::core::judge::Severity;
use crate::pipeline::alerts::{AlertUpdate, NameLookup};
use crate::pipeline::hooks::registry::{OutboxContext, Subscription, introduce};
use crate::pipeline::prelude::*;
use crate::store::{
    AlertRow, AttemptRow, DeadLetters, DeliverySubject, HookRow, NewDelivery, OutboxChanges, Progress, Writer,
};
use crate::wire::body::bodies;
use crate::wire::json;
use crate::wire::message::to_stored;
use crate::wire::time;

/// Each hook costs a task and a queue.
const MOST_HOOKS: usize = 1000;

/// What the writer is asked to do with hooks and their queues.
#[derive(Debug)]
pub enum Order {
    Create(NewHook),
    Change(Id, HookPatch),
    /// Throws its queue away too.
    Delete(Id),
    /// Queues a message that says that nothing is wrong.
    Test(Id),
    /// Sends a delivery again that is done, or one that waits at once.
    Redeliver(Id),
}

/// A hook as the audit trail has it. Of what is secret it says whether it is there; the address may hold a token, so
/// that only where it leads is said: of e-mail, to whom.
#[derive(Serialize)]
struct AuditedHook {
    name: String,
    kind: String,
    origin: String,
    authorized: bool,
    signed: bool,
    filter: String,
    enabled: bool,
    batch: bool,
    expect: Option<String>,
}

bodies! {
    AuditedHook of HookRow: name, kind, origin: |hook| origin(&hook.url),
        authorized: |hook| hook.authorization.is_some(), signed: |hook| hook.secret.is_some(), filter, enabled, batch,
        expect;
}

fn origin(url: &str) -> String {
    match url::Url::parse(url) {
        Ok(parsed) if parsed.scheme() == "mailto" => url.to_owned(),
        Ok(parsed) => parsed.origin().ascii_serialization(),
        Err(_) => String::new(),
    }
}

/// What a delivery queue has found out and is to be written down.
#[derive(Debug, Clone)]
pub enum Found {
    Attempted(Attempted),
    /// The hook's target is back, and it was no delivery that found it so: what waits is due now.
    Back(Id),
}

/// An attempt was made.
#[derive(Debug, Clone)]
pub struct Attempted {
    /// The writer gives it its identifier.
    pub attempt: AttemptRow,
    pub hook: Id,
    pub progress: Progress,
    /// The address that answered 410: nothing more is sent there.
    pub gone: Option<String>,
    /// The target is back: what waits is due now.
    pub hasten: bool,
    /// The target takes messages: it is told anew of the alerts whose beginning or end it never took.
    pub renotify: bool,
    /// It was written down already, but whether that came about is not known.
    pub perhaps_written: bool,
}

impl Attempted {
    /// More than the delivery itself: whether the hook is told anything, and what.
    pub fn changes_the_hook(&self) -> bool {
        self.gone.is_some() || self.renotify
    }
}

/// The writer at work on orders.
pub(crate) struct HookHandler<'a> {
    pub store: &'a Store,
    pub writer: &'a mut Writer,
    pub now: UtcMicros,
    /// How long a secret that is replaced signs as well.
    pub old_secret_until: UtcMicros,
    /// Every alert as it stands, once a hook may hear of them.
    pub alerts: Option<Vec<AlertUpdate>>,
}

impl HookHandler<'_> {
    /// Carries out one order; on disk, with its line in the audit trail, when this returns.
    pub async fn carry_out(&mut self, order: &Order, by: &Actor) -> Result<Id, Refused> {
        let mut changes = Changes::default();
        let about = match order {
            Order::Create(new) => self.create(new, &mut changes).await?,
            Order::Change(id, patch) => self.change(*id, patch, &mut changes).await?,
            Order::Delete(id) => {
                let hook = self.hook(*id).await?;
                changes.hooks.push(HookRow { deleted_at: Some(self.now), changed_at: self.now, ..hook });
                changes.outbox.dropped.push((*id, self.now));
                changes.outbox.forgotten.push(*id);
                *id
            }
            Order::Test(hook) => self.test(*hook, &mut changes).await?,
            Order::Redeliver(delivery) => self.redeliver(*delivery, &mut changes.outbox).await?,
        };
        let line = self.audited(order, by, about, &changes).await?;
        changes.access.audit.push(line);
        store::hook::hide(self.store, &mut changes.hooks)?;
        self.writer.commit(&changes).await?;
        Ok(about)
    }

    async fn audited(
        &mut self,
        order: &Order,
        by: &Actor,
        about: Id,
        changes: &Changes,
    ) -> Result<AuditEntry, Refused> {
        let (action, subject) = match order {
            Order::Create(_) => ("create hook", format!("hooks/{about}")),
            Order::Change(..) => ("change hook", format!("hooks/{about}")),
            Order::Delete(_) => ("delete hook", format!("hooks/{about}")),
            Order::Test(hook) => ("test hook", format!("hooks/{hook}")),
            Order::Redeliver(_) => ("redeliver", format!("deliveries/{about}")),
        };
        let before = match order {
            Order::Change(id, _) | Order::Delete(id) => store::hook::get(self.store, *id).await?,
            Order::Create(_) | Order::Test(_) | Order::Redeliver(_) => None,
        };
        let after = changes.hooks.first().filter(|hook| hook.deleted_at.is_none());
        let (before, after) = (before.as_ref().map(AuditedHook::from), after.map(AuditedHook::from));
        Ok(by.line(self.writer.next_id(self.now), self.now, (action, subject), before.as_ref(), after.as_ref()))
    }

    /// Writes down what many delivery queues have found out, in one transaction.
    pub async fn write_down(&mut self, found: impl Iterator<Item = &Found>) -> Result<(), Refused> {
        let mut changes = Changes::default();
        for found in found {
            match found {
                Found::Attempted(attempted) => self.attempted(attempted, &mut changes).await?,
                Found::Back(hook) => changes.outbox.hastened.push((*hook, self.now)),
            }
        }
        store::hook::hide(self.store, &mut changes.hooks)?;
        self.writer.commit(&changes).await?;
        for HookRow { id, name, .. } in &changes.hooks {
            tracing::error!(hook = %id, name, "the target of a hook is gone (410): the hook is disabled and told nothing until somebody enables it, at /hooks or by PATCH /v1/hooks/ID");
        }
        Ok(())
    }

    async fn create(&mut self, new: &NewHook, changes: &mut Changes) -> Result<Id, Refused> {
        if store::hook::all(self.store).await?.len() >= MOST_HOOKS {
            return Err(Refused::conflict("title_too_many_hooks", message!("too_many_hooks", most = MOST_HOOKS)));
        }
        let id = self.writer.next_id(self.now);
        let NewHook { body, kind, secret, .. } = new;
        let row = HookRow {
            id,
            name: body.name.clone().unwrap_or_else(|| kind.name().to_owned()),
            kind: kind.name().to_owned(),
            url: body.url.clone(),
            authorization: body.authorization.clone(),
            secret: secret.as_ref().map(|secret| secret.reveal()),
            old_secret: None,
            filter: json::written(&body.filter),
            batch: body.batch,
            expect: body.expect.as_ref().map(json::written),
            enabled: body.enabled,
            disabled_because: None,
            created_at: self.now,
            changed_at: self.now,
            deleted_at: None,
        };
        if row.enabled {
            self.introduce(&row, &HashMap::new(), &mut changes.outbox).await?;
        }
        changes.hooks.push(row);
        Ok(id)
    }

    /// Reads how every alert stands, for a hook that begins to listen: it hears what others were spared because it was
    /// found late.
    async fn read_alerts(&mut self) -> Result<(), StoreError> {
        if self.alerts.is_some() {
            return Ok(());
        }
        let rows = store::alerts::all(self.store).await?;
        let naming = NameLookup { tables: &self.store.names().read(), new: None };
        // One that cannot be read is told to nobody; the next look at it names the damage.
        let standing = |row: &AlertRow| {
            let (alert, body) = (Alert { suppressed: None, ..row.alert }, Some(naming.alert(row, self.now).ok()?));
            Some(AlertUpdate { id: row.id, alert, action: Action::Silent, step: None, body, cause: None })
        };
        self.alerts = Some(rows.iter().filter_map(standing).collect());
        Ok(())
    }

    /// The hook hears how things stand.
    async fn introduce(
        &mut self,
        row: &HookRow,
        heard: &HashMap<Id, Severity>,
        outbox: &mut OutboxChanges,
    ) -> Result<(), StoreError> {
        self.read_alerts().await?;
        let mut context = OutboxContext { now: self.now, ids: self.writer.ids(), outbox };
        introduce(&Subscription::of(row)?, heard, self.alerts.iter().flatten(), &mut context)
    }

    /// A hook that was disabled has missed what was not told it. What still waited is old by now: it hears how things
    /// stand instead, by what it has taken before.
    async fn take_up(&mut self, row: &HookRow, outbox: &mut OutboxChanges) -> Result<(), StoreError> {
        outbox.dropped.push((row.id, self.now));
        outbox.forgotten.push(row.id);
        // Of what fires it is told again, whatever it has heard.
        let taken = store::hook::delivered_firing(self.store, row.id).await?;
        let heard = self.heard_firing(taken.into_keys()).await?;
        self.introduce(row, &heard, outbox).await
    }

    /// Of what fires and was never taken the hook is told again, and of the end of what it took to fire, where nothing
    /// that waits does so.
    async fn renotify(&mut self, hook: Id, outbox: &mut OutboxChanges) -> Result<(), StoreError> {
        let Some(row) = store::hook::get(self.store, hook).await?.filter(|row| row.enabled) else { return Ok(()) };
        let DeadLetters { fires, ends } = store::hook::dead_letters(self.store, hook).await?;
        let heard = self.heard_firing(ends).await?;
        self.notify_of(&row, &heard, |alert| fires.contains(&alert) || heard.contains_key(&alert), outbox).await
    }

    /// Those of these alerts that have ended, as a hook has heard of them that took no more than that they fire.
    async fn heard_firing(
        &mut self,
        alerts: impl IntoIterator<Item = Id>,
    ) -> Result<HashMap<Id, Severity>, StoreError> {
        self.read_alerts().await?;
        let is_over = |one: &&AlertUpdate| one.alert.status == Status::Resolved;
        let over: HashSet<Id> = self.alerts.iter().flatten().filter(is_over).map(|one| one.id).collect();
        Ok(alerts.into_iter().filter(|id| over.contains(id)).map(|id| (id, Severity::Warning)).collect())
    }

    /// The hook, which has `heard` so of alerts that have ended, is told of those alerts that fire, whatever it has
    /// heard, and of those ends, where nothing that waits does so.
    async fn notify_of(
        &mut self,
        row: &HookRow,
        heard: &HashMap<Id, Severity>,
        is_told: impl Fn(Id) -> bool,
        outbox: &mut OutboxChanges,
    ) -> Result<(), StoreError> {
        self.read_alerts().await?;
        let waiting = store::hook::waiting_alerts(self.store, row.id).await?;
        let queued = outbox.queued.iter().filter(|new| new.hook == row.id).flat_map(|new| &new.parts);
        let queued: HashSet<Id> = queued.map(|part| part.alert).chain(waiting).collect();
        let told = self.alerts.iter().flatten().filter(|one| is_told(one.id) && !queued.contains(&one.id));
        let mut context = OutboxContext { now: self.now, ids: self.writer.ids(), outbox };
        introduce(&Subscription::of(row)?, heard, told, &mut context)
    }

    async fn change(&mut self, id: Id, patch: &HookPatch, changes: &mut Changes) -> Result<Id, Refused> {
        let mut hook = self.hook(id).await?;
        let was_enabled = hook.enabled;
        let HookPatch { body: patch, secret } = patch;
        if let Some(secret) = secret {
            if secret.is_none() && hook.kind == HookKind::StandardWebhooks.name() {
                return Err(Refused::not_storable("/secret", message!("secret_needed")));
            }
            let earlier = std::mem::replace(&mut hook.secret, secret.as_ref().map(|secret| secret.reveal()));
            // The same secret again replaces nothing, and what ends signing ends it for the secret before too.
            if hook.secret.is_none() {
                hook.old_secret = None;
            } else if earlier != hook.secret {
                hook.old_secret = earlier.map(|earlier| (earlier, self.old_secret_until));
            }
        }
        let is_mail = hook.kind == HookKind::Email.name();
        if patch.url.as_ref().is_some_and(|url| url.starts_with("mailto:") != is_mail) {
            return Err(Refused::not_storable("/url", message!("target_of_other_kind")));
        }
        hook.name = patch.name.clone().unwrap_or(hook.name);
        let is_elsewhere = patch.url.as_ref().is_some_and(|url| *url != hook.url);
        hook.url = patch.url.clone().unwrap_or(hook.url);
        hook.authorization = patch.authorization.clone().unwrap_or(hook.authorization);
        hook.filter = patch.filter.as_ref().map_or(hook.filter, json::written);
        hook.batch = patch.batch.unwrap_or(hook.batch);
        if let Some(expect) = &patch.expect {
            hook.expect = expect.as_ref().map(json::written);
        }
        if let Some(enabled) = patch.enabled {
            (hook.enabled, hook.disabled_because) = (enabled, None);
        }
        match (was_enabled, hook.enabled) {
            (false, true) => self.take_up(&hook, &mut changes.outbox).await?,
            (true, true) => {
                changes.outbox.hastened.push((id, self.now));
                if is_elsewhere {
                    // Nobody there has heard anything.
                    self.notify_of(&hook, &HashMap::new(), |_| true, &mut changes.outbox).await?;
                } else if patch.filter.is_some() {
                    let heard = store::hook::heard_by(self.store, id).await?;
                    self.introduce(&hook, &heard, &mut changes.outbox).await?;
                }
            }
            (_, false) => {}
        }
        changes.hooks.push(HookRow { changed_at: self.now, ..hook });
        Ok(id)
    }

    async fn test(&mut self, hook: Id, changes: &mut Changes) -> Result<Id, Refused> {
        self.enabled_hook(hook).await?;
        let id = self.writer.next_id(self.now);
        let (subject, queued_at) = (DeliverySubject::Test, self.now);
        let test = NewDelivery { id, hook, subject, queued_at, action: None, parts: Vec::new(), digest: None };
        changes.outbox.queued.push(test);
        Ok(id)
    }

    async fn redeliver(&mut self, id: Id, outbox: &mut OutboxChanges) -> Result<Id, Refused> {
        let delivery = store::delivery::get(self.store, id).await?.ok_or_else(|| Problem::no_such_delivery(id))?;
        self.enabled_hook(delivery.hook).await?;
        match delivery.state {
            DeliveryState::Behind => {
                Err(Refused::conflict("title_not_its_turn", message!("still_behind", id = text(id))))
            }
            DeliveryState::Dropped => {
                Err(Refused::conflict("title_delivery_dropped", message!("delivery_dropped", id = text(id))))
            }
            DeliveryState::Waiting | DeliveryState::Delivered | DeliveryState::Dead => {
                outbox.replayed.push((id, self.now));
                Ok(id)
            }
        }
    }

    async fn attempted(&mut self, attempted: &Attempted, changes: &mut Changes) -> Result<(), StoreError> {
        if attempted.perhaps_written && self.is_written(&attempted.attempt).await? {
            return Ok(());
        }
        let attempt = AttemptRow { id: self.writer.next_id(self.now), ..attempted.attempt.clone() };
        changes.outbox.attempts.push((attempt, attempted.progress));
        if attempted.hasten {
            changes.outbox.hastened.push((attempted.hook, self.now));
        }
        if attempted.renotify {
            self.renotify(attempted.hook, &mut changes.outbox).await?;
        }
        let Some(url) = &attempted.gone else { return Ok(()) };
        // Who has changed or disabled the hook meanwhile has heard already.
        let is_news =
            |hook: &HookRow| hook.url == *url && hook.enabled && changes.hooks.iter().all(|it| it.id != hook.id);
        if let Some(hook) = store::hook::get(self.store, attempted.hook).await?.filter(is_news) {
            let because = to_stored(&message!("target_gone", at = time::format(attempted.attempt.at)));
            let (disabled_because, changed_at) = (Some(because), self.now);
            let disabled = HookRow { enabled: false, disabled_because, changed_at, ..hook.clone() };
            let (before, after) = (AuditedHook::from(&hook), AuditedHook::from(&disabled));
            let what = ("disable hook", format!("hooks/{}", hook.id));
            let line = self.writer.next_id(self.now);
            changes.access.audit.push(Actor::by_caller().line(line, self.now, what, Some(&before), Some(&after)));
            changes.hooks.push(disabled);
        }
        Ok(())
    }

    async fn is_written(&self, attempt: &AttemptRow) -> Result<bool, StoreError> {
        let delivery = store::delivery::get(self.store, attempt.delivery).await?;
        Ok(delivery.is_some_and(|delivery| delivery.attempts.iter().any(|written| written.at == attempt.at)))
    }

    async fn hook(&self, id: Id) -> Result<HookRow, Refused> {
        Ok(store::hook::get(self.store, id).await?.ok_or_else(|| Problem::no_such_hook(id))?)
    }

    async fn enabled_hook(&self, id: Id) -> Result<HookRow, Refused> {
        let hook = self.hook(id).await?;
        if hook.enabled {
            Ok(hook)
        } else {
            Err(Refused::conflict("title_hook_disabled", message!("hook_disabled", id = text(id))))
        }
    }
}
