//! What people say of alerts, and what is answered about them.

use crate::core::alert_decision;
use crate::core::time::UtcMicros;
use crate::pipeline::{Actor, Job, Pipeline, Refused};
use crate::store;
use crate::store::{AlertFilter, AlertRow, Id, Remark, StoreError};
use crate::wire::alert::AlertBody;

use super::Naming;
use super::book::{AlertBook, Pen};
use tokio::sync::oneshot;

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
}

impl AlertChange {
    pub fn name(self) -> &'static str {
        match self {
            Self::Acknowledge => "acknowledge",
            Self::Unacknowledge => "unacknowledge",
            Self::Silence { .. } => "silence",
        }
    }
}

/// An alert with what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct AlertRecord {
    pub alert: AlertBody,
    /// Oldest first.
    pub steps: Vec<AlertStep>,
}

/// One step of an alert's history.
#[derive(Debug, Clone, PartialEq)]
pub struct AlertStep {
    pub id: Id,
    pub at: UtcMicros,
    pub action: String,
    pub told: bool,
    pub author: Option<String>,
    pub reason: Option<String>,
    /// The alert as it then was.
    pub alert: AlertBody,
}

/// Most steps that an answer holds; older ones are left out.
const MOST_STEPS: u32 = 1000;

impl Pipeline {
    /// Alerts that a filter lets through, newest first, each with its identifier.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn alerts(
        &self,
        filter: &AlertFilter,
        before: Option<Id>,
        limit: u32,
    ) -> Result<Vec<(Id, AlertBody)>, StoreError> {
        let now = self.clock.now();
        let rows = store::alerts::find(&self.store, filter, now, before, limit).await?;
        let tables = self.store.names().read();
        let naming = Naming { tables: &tables, new: None };
        rows.iter().map(|row| Ok((row.id, naming.alert(row, now)?))).collect()
    }

    /// One alert and its newest steps.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn alert(&self, id: Id) -> Result<Option<AlertRecord>, StoreError> {
        let Some(row) = store::alerts::get(&self.store, id).await? else { return Ok(None) };
        let steps = store::alerts::steps(&self.store, id, MOST_STEPS).await?;
        let steps = steps.into_iter().map(|step| {
            let alert = serde_json::from_str(&step.body)
                .map_err(|error| StoreError::Damaged(format!("step {} of alert {id}: {error}", step.id)))?;
            let crate::store::StepRow { id, at, action, told, author, reason, .. } = step;
            Ok(AlertStep { id, at, action, told, author, reason, alert })
        });
        let steps = steps.collect::<Result<_, StoreError>>()?;
        let tables = self.store.names().read();
        let alert = Naming { tables: &tables, new: None }.alert(&row, self.clock.now())?;
        Ok(Some(AlertRecord { alert, steps }))
    }

    /// Acknowledges an alert or takes that back, or silences it; returns it once that is on disk.
    ///
    /// # Errors
    /// [`Refused::UnknownAlert`], [`Refused::AlertResolved`], or as [`Pipeline::submit`].
    pub async fn change_alert(&self, order: AlertOrder) -> Result<AlertBody, Refused> {
        let (reply, answer) = oneshot::channel();
        self.offer(Job::Alert { order, by: Actor::by_caller(), reply })?;
        answer.await.map_err(|_| Refused::Stopping)?
    }
}

impl AlertBook {
    /// Does what somebody has said; returns the alert as it then is.
    pub fn obey(&mut self, order: &AlertOrder, pen: &mut Pen<'_>) -> Result<AlertRow, Refused> {
        let unknown = || Refused::UnknownAlert { id: order.alert };
        let row = self.alert(order.alert).ok_or_else(unknown)?;
        let remark = Remark { by: order.by.clone(), reason: order.reason.clone(), at: pen.now };
        let changed = match order.change {
            AlertChange::Acknowledge if row.alert.status == alert_decision::Status::Resolved => {
                return Err(Refused::AlertResolved { id: order.alert });
            }
            // There is nothing to take back.
            AlertChange::Unacknowledge if !row.alert.acknowledged => Some(row.clone()),
            AlertChange::Unacknowledge => {
                let change = |row: &mut AlertRow| {
                    row.alert = alert_decision::unacknowledge(&row.alert);
                    row.acknowledged = None;
                };
                self.say(order.alert, order.change.name(), &remark, change, pen)
            }
            AlertChange::Acknowledge => {
                let change = |row: &mut AlertRow| {
                    row.alert = alert_decision::acknowledge(&row.alert);
                    row.acknowledged = Some(remark.clone());
                };
                self.say(order.alert, order.change.name(), &remark, change, pen)
            }
            AlertChange::Silence { until } => {
                let change = |row: &mut AlertRow| {
                    row.alert = alert_decision::silence(&row.alert, Some(until));
                    row.silenced = Some(remark.clone());
                };
                self.say(order.alert, order.change.name(), &remark, change, pen)
            }
        };
        changed.ok_or_else(unknown)
    }
}
