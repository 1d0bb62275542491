//! What people say of alerts, done by the one writer.

use super::cache::{AlertCache, AlertContext};
use super::silences::{MOST_SILENCES, body};
use crate::core::access::AuditEntry;
use crate::core::alert_decision;
use crate::core::alert_filter::Matchers;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow, Remark, SilenceRow};

/// Somebody says something of an alert.
#[derive(Debug, Clone, PartialEq)]
pub struct AlertOrder {
    pub alert: Id,
    pub change: AlertChange,
    pub by: String,
    pub reason: String,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlertChange {
    /// Somebody knows.
    Acknowledge,
    /// Nobody does, after all.
    Unacknowledge,
    /// Nobody is to be told before a time.
    Silence { until: UtcMicros },
    /// It is over.
    Unsilence,
    /// Something is said of it, and nothing changes.
    Comment,
}

impl AlertChange {
    pub fn name(self) -> &'static str {
        match self {
            Self::Acknowledge => "acknowledge",
            Self::Unacknowledge => "unacknowledge",
            Self::Silence { .. } => "silence",
            Self::Unsilence => "unsilence",
            Self::Comment => "comment",
        }
    }
}

/// Somebody begins or ends a silence of many alerts.
#[derive(Debug, Clone, PartialEq)]
pub enum SilenceOrder {
    Begin { matchers: Matchers, until: UtcMicros, by: String, reason: String },
    End { silence: Id, by: String, reason: String },
}

impl AlertCache {
    /// Does what somebody has said; returns the alert as it then is. What a silence that ends has left untold is told
    /// at once.
    pub fn apply_order(&mut self, order: &AlertOrder, context: &mut AlertContext<'_>) -> Result<AlertRow, Refused> {
        let unknown = || Problem::unknown_alert(order.alert);
        let row = self.alert(order.alert).ok_or_else(unknown)?;
        let remark = Remark { by: order.by.clone(), reason: order.reason.clone(), at: context.now };
        match order.change {
            AlertChange::Acknowledge if row.alert.status == alert_decision::Status::Resolved => {
                let resolved = message!("alert_resolved", id = text(order.alert));
                return Err(Refused::conflict("title_alert_resolved", resolved));
            }
            // There is nothing to take back.
            AlertChange::Unacknowledge if !row.alert.acknowledged => return Ok(row.clone()),
            AlertChange::Unsilence if row.alert.silenced_until.is_none() => return Ok(row.clone()),
            _ => {}
        }
        let now = context.now;
        let change = |row: &mut AlertRow| match order.change {
            AlertChange::Unacknowledge => {
                row.alert = alert_decision::unacknowledge(&row.alert);
                row.acknowledged = None;
            }
            AlertChange::Acknowledge => {
                row.alert = alert_decision::acknowledge(&row.alert);
                row.acknowledged = Some(remark.clone());
            }
            AlertChange::Comment => {}
            AlertChange::Silence { until } => {
                row.alert = alert_decision::silence(&row.alert, Some(until));
                row.silenced = Some(remark.clone());
            }
            AlertChange::Unsilence => {
                // It is over with the tick that follows.
                row.alert = alert_decision::silence(&row.alert, Some(now));
                row.silenced = None;
            }
        };
        let of = self.say(order.alert, order.change.name(), &remark, change, context).ok_or_else(unknown)?.of;
        if order.change == AlertChange::Unsilence {
            self.tick(&BTreeSet::from([of]), context);
        }
        Ok(self.alert(order.alert).cloned().ok_or_else(unknown)?)
    }

    /// Begins or ends a silence. What is untold at the end is told at once.
    pub fn order_silence(
        &mut self,
        order: &SilenceOrder,
        known: Option<SilenceRow>,
        by: &Actor,
        context: &mut AlertContext<'_>,
    ) -> Result<(Id, Changes), Refused> {
        let mut changes = Changes::default();
        let (before, after, action) = match (order, known) {
            (SilenceOrder::Begin { matchers, until, by, reason }, _) => {
                self.silences.pass(context.now);
                if self.silences.0.len() >= MOST_SILENCES as usize {
                    let many = message!("too_many_silences", most = MOST_SILENCES as usize);
                    return Err(Refused::conflict("title_too_many_silences", many));
                }
                let said = Remark { by: by.clone(), reason: reason.clone(), at: context.now };
                let id = context.writer.next_id(context.now);
                let row = SilenceRow { id, matchers: matchers.clone(), until: *until, said, ended: None };
                self.silences.0.push(row.clone());
                (None, row, "begin silence")
            }
            (SilenceOrder::End { silence, .. }, None) => return Err(Problem::unknown_silence(silence).into()),
            // It is over already.
            (SilenceOrder::End { silence, .. }, Some(row)) if row.ended.is_some() || row.until <= context.now => {
                return Ok((*silence, changes));
            }
            (SilenceOrder::End { silence, by, reason }, Some(row)) => {
                self.silences.0.retain(|one| one.id != *silence);
                let ended = Some(Remark { by: by.clone(), reason: reason.clone(), at: context.now });
                (Some(row.clone()), SilenceRow { ended, ..row }, "end silence")
            }
        };
        let all: BTreeSet<AlertOf> = self.alerts.keys().copied().collect();
        for at in self.places(all.iter().copied()) {
            let row = &self.alerts[&at.0][at.1];
            let was_muted = row.alert.muted_until.is_some();
            let muting = self.silences.of_row(row, &context.naming, context.now);
            // One that ends now is over with the tick that follows.
            let until = muting.as_ref().map(|(_, until)| *until).or(was_muted.then_some(context.now));
            if until != row.alert.muted_until {
                let row = &mut self.alerts.get_mut(&at.0).expect("it was found")[at.1];
                row.alert.muted_until = until;
                row.muted = muting.map(|(muted, _)| muted).or(row.muted.take());
                self.changed.insert(at);
            }
        }
        self.tick(&all, context);
        changes.access.audit.push(audited(context, by, action, before.as_ref(), &after));
        let id = after.id;
        changes.silences.push(after);
        Ok((id, changes))
    }
}

fn audited(
    context: &mut AlertContext<'_>,
    by: &Actor,
    action: &str,
    before: Option<&SilenceRow>,
    after: &SilenceRow,
) -> AuditEntry {
    let (before, now) = (before.map(|row| body(row, context.now)), context.now);
    let line = context.writer.next_id(now);
    by.line(line, now, (action, format!("silences/{}", after.id)), before.as_ref(), Some(&body(after, now)))
}
