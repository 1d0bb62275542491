//! Alerts, in step with what is stored: every change of a group's verdicts becomes a step of an alert, written in the
//! transaction of the records that caused it.
//!
//! The cache holds the alerts of every gyro that was looked at, so that a record whose verdicts are all within costs one
//! look into a map. Deciding is the core's ([`crate::core::alert_decision`]);
//! this keeps the states, finds what each verdict is about, and writes down what became of it.

mod body;
mod cache;
mod orders;
mod shared;
mod silences;
mod sources;

use super::write_queue::{Job, WriteQueue};
use crate::core::alert_decision::AlertState;
use crate::core::alert_filter::AlertFilter;
use crate::core::history_note::{EARLIER_IN_DOUBT, SERVICE};
use crate::core::judge::Severity;
use crate::pipeline::cached_answer::CachedAnswer;
use crate::pipeline::prelude::*;
use crate::store::{AlertRow, StepRow};
use crate::wire::alert::AlertBody;
use crate::wire::silence::MatchingSilenceBody;
use silences::MOST_SILENCES;

pub use orders::{AlertChange, AlertOrder, SilenceOrder};

pub(super) use body::{NameLookup, Origin, finding_of, status_of};
pub(super) use cache::{AlertCache, AlertContext, AlertUpdate};
pub(super) use shared::SharedVerdict;
pub(super) use sources::{Causes, follow_clock, follow_group};

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
    pub reason: Option<Message>,
    /// The alert as it then was.
    pub alert: AlertBody,
}

/// Most steps that an answer holds; older ones are left out.
const MOST_STEPS: u32 = 1000;

/// Alerts and silences. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Alerts {
    pub(super) store: Store,
    pub(super) clock: Clock,
    pub(super) queue: WriteQueue,
    /// How many of all stand how.
    pub(super) counts: Arc<CachedAnswer<HashMap<AlertState, usize>>>,
}

impl Alerts {
    /// Alerts that a filter lets through, newest first.
    pub async fn find(
        &self,
        filter: &AlertFilter,
        before: Option<Id>,
        limit: u32,
    ) -> Result<Vec<AlertBody>, StoreError> {
        let now = self.clock.now();
        self.bodies(&store::alerts::find(&self.store, filter, now, before, limit).await?, now)
    }

    fn bodies<'a>(
        &self,
        rows: impl IntoIterator<Item = &'a AlertRow>,
        now: UtcMicros,
    ) -> Result<Vec<AlertBody>, StoreError> {
        let naming = NameLookup { tables: &self.store.names().read(), new: None };
        rows.into_iter().map(|row| naming.alert(row, now)).collect()
    }

    /// Gyros with their alerts that a filter lets through: those that stand worst first, of what is resolved those whose
    /// alert is the newest; from the gyro of place `skip` on, as many as `most`.
    pub async fn by_gyro(
        &self,
        filter: &AlertFilter,
        skip: usize,
        most: usize,
    ) -> Result<Vec<(u32, Vec<AlertBody>)>, StoreError> {
        let (now, is_newest_first) = (self.clock.now(), filter.standing == Some(AlertState::Resolved));
        let gyros = store::alerts::gyros_found(&self.store, filter, now, is_newest_first, [skip, most]).await?;
        let rows = store::alerts::found_of(&self.store, filter, now, &gyros).await?;
        let of_it = |gyro: u32| rows.iter().filter(move |row| row.of.gyro() == Some(gyro));
        gyros.iter().map(|gyro| Ok((*gyro, self.bodies(of_it(*gyro), now)?))).collect()
    }

    /// Alerts of stations, batches and IMUs that a filter lets through, the newest first.
    pub async fn of_no_gyro(&self, filter: &AlertFilter) -> Result<Vec<AlertBody>, StoreError> {
        let (now, mut rows) = (self.clock.now(), store::alerts::of_no_gyro(&self.store).await?);
        rows.retain(|row| {
            filter.gyro.is_none()
                && filter.standing.is_none_or(|standing| row.alert.standing(now) == standing)
                && filter.rule.is_none_or(|rule| row.rule == rule)
                && filter.severity.is_none_or(|severity| row.alert.severity == severity)
        });
        self.bodies(rows.iter().rev(), now)
    }

    /// Alerts of gyros that the alert of a station, batch or IMU explains.
    pub async fn inhibited_by(&self, station: Id) -> Result<Vec<AlertBody>, StoreError> {
        self.bodies(&store::alerts::inhibited_by(&self.store, station).await?, self.clock.now())
    }

    pub async fn of(&self, ids: &[Id]) -> Result<Vec<AlertBody>, StoreError> {
        self.bodies(&store::alerts::of_ids(&self.store, ids).await?, self.clock.now())
    }

    /// How many alerts stand how, among those that a filter lets through.
    pub async fn counts_by_state(&self, filter: &AlertFilter) -> Result<HashMap<AlertState, usize>, StoreError> {
        let (store, now) = (&self.store, self.clock.now());
        let count = store::alerts::counts_by_state(store, filter, now);
        if *filter != AlertFilter::default() {
            return count.await;
        }
        let of_all = async { Ok::<_, StoreError>((count.await?, store::alerts::same_until(store, now).await?)) };
        Ok((*self.counts.at(store::alerts::version(store), now, of_all).await?).clone())
    }

    /// How many alerts fire that no other explains, acknowledged and silenced ones among them, of each severity.
    pub async fn firing(&self) -> Result<[u64; Severity::ALL.len()], StoreError> {
        let counts = store::alerts::firing_by_severity(&self.store).await?;
        Ok(Severity::ALL.map(|severity| {
            let count = counts.iter().find(|(of, _)| *of == severity);
            count.map_or(0, |(_, count)| *count)
        }))
    }

    /// One alert and its newest steps.
    pub async fn get(&self, id: Id) -> Result<Option<AlertRecord>, StoreError> {
        let Some(row) = store::alerts::get(&self.store, id).await? else { return Ok(None) };
        let steps = store::alerts::steps(&self.store, id, MOST_STEPS).await?;
        let steps = steps.into_iter().map(|step| {
            let alert = serde_json::from_str(&step.body)
                .map_err(|error| StoreError::damaged(format_args!("step {} of alert {id}: {error}", step.id)))?;
            let StepRow { id, at, action, told, author, reason, .. } = step;
            let reason = reason.map(|reason| match (author.as_deref(), reason.as_str()) {
                (Some(SERVICE), EARLIER_IN_DOUBT) => message!("earlier_in_doubt"),
                _ => Message::verbatim(reason),
            });
            Ok(AlertStep { id, at, action, told, author, reason, alert })
        });
        let steps = steps.collect::<Result<_, StoreError>>()?;
        let naming = NameLookup { tables: &self.store.names().read(), new: None };
        let alert = naming.alert(&row, self.clock.now())?;
        Ok(Some(AlertRecord { alert, steps }))
    }

    /// Acknowledges an alert or takes that back, or silences it; returns it once that is on disk.
    pub async fn change(&self, order: AlertOrder) -> Result<AlertBody, Refused> {
        let by = Actor::by_caller();
        self.queue.ask(|reply| Job::Alert { order, by, reply }).await
    }

    /// Silences of many alerts, the newest first: those in force, or the newest of all.
    pub async fn silences(&self, all: bool) -> Result<Vec<MatchingSilenceBody>, StoreError> {
        let now = self.clock.now();
        let rows = store::silence::list(&self.store, (!all).then_some(now), MOST_SILENCES).await?;
        Ok(rows.iter().map(|row| silences::body(row, now)).collect())
    }

    pub async fn silence(&self, id: Id) -> Result<Option<MatchingSilenceBody>, StoreError> {
        Ok(store::silence::get(&self.store, id).await?.map(|row| silences::body(&row, self.clock.now())))
    }

    /// Begins or ends a silence of many alerts; returns its identifier once that is on disk.
    pub async fn order_silence(&self, order: SilenceOrder) -> Result<Id, Refused> {
        let by = Actor::by_caller();
        self.queue.ask(|reply| Job::Silence { order, by, reply }).await
    }
}
