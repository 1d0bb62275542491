//! Silences of many alerts: which alerts match, and what people order.

use super::body::{Naming, Origin, finding_of};
use super::book::{AlertBook, Pen};
use crate::core::judge::{Rule, Verdict};
use crate::core::time::UtcMicros;
use crate::pipeline::{Actor, Job, Pipeline, Refused};
use crate::store;
use crate::store::{AlertRow, AuditRow, Changes, Id, Matchers, Remark, SilenceRow, Store, StoreError};
use crate::wire::silence::{EndedBody, MatchersBody, MatchingSilenceBody};
use crate::wire::time;
use tokio::sync::oneshot;

/// Silences in force at a time.
const MOST_SILENCES: u32 = 1000;

/// Somebody begins or ends a silence of many alerts.
#[derive(Debug, Clone, PartialEq)]
pub enum SilenceOrder {
    Begin { matchers: Matchers, until: UtcMicros, by: String, reason: String },
    End { silence: Id, by: String, reason: String },
}

/// Those in force.
#[derive(Debug, Default)]
pub(super) struct Silences(Vec<SilenceRow>);

impl Silences {
    pub async fn load(store: &Store, now: UtcMicros) -> Result<Self, StoreError> {
        store::silence::list(store, Some(now), MOST_SILENCES).await.map(Self)
    }

    /// Those whose time has come are in force no more.
    pub fn pass(&mut self, now: UtcMicros) {
        self.0.retain(|silence| now < silence.until);
    }

    /// What silences the alert of a verdict the longest: the silence, and until when.
    pub fn of(
        &self,
        gyro: u32,
        verdict: &Verdict,
        origin: &Origin,
        naming: &Naming<'_>,
        now: UtcMicros,
    ) -> Option<((Id, Remark), UtcMicros)> {
        if self.0.is_empty() {
            return None;
        }
        let finding = naming.finding(verdict, origin);
        self.longest((&naming.gyro(gyro), finding.imu.as_deref(), finding.station.as_deref(), verdict.rule), now)
    }

    fn of_row(&self, row: &AlertRow, naming: &Naming<'_>, now: UtcMicros) -> Option<((Id, Remark), UtcMicros)> {
        // A finding that cannot be read names no place: the next look at the alert names the damage.
        let finding = finding_of(row).ok();
        let place = finding.as_ref().map(|finding| (finding.imu.as_deref(), finding.station.as_deref()));
        let (imu, station) = place.unwrap_or_default();
        self.longest((&naming.gyro(row.gyro), imu, station, row.rule), now)
    }

    fn longest(
        &self,
        (serial, imu, station, rule): (&str, Option<&str>, Option<&str>, Rule),
        now: UtcMicros,
    ) -> Option<((Id, Remark), UtcMicros)> {
        let fits = |wanted: &Option<String>, is: Option<&str>| wanted.is_none() || wanted.as_deref() == is;
        let matching = self.0.iter().filter(|SilenceRow { matchers, until, .. }| {
            now < *until
                && fits(&matchers.serial, Some(serial))
                && fits(&matchers.imu, imu)
                && fits(&matchers.station, station)
                && matchers.rule.is_none_or(|wanted| wanted == rule)
        });
        matching.max_by_key(|silence| silence.until).map(|one| ((one.id, one.said.clone()), one.until))
    }
}

impl AlertBook {
    /// Begins or ends a silence. What is untold at the end is told at once.
    ///
    /// # Errors
    /// [`Refused::TooManySilences`].
    pub fn order_silence(
        &mut self,
        order: &SilenceOrder,
        known: Option<SilenceRow>,
        by: &Actor,
        pen: &mut Pen<'_>,
    ) -> Result<(Id, Changes), Refused> {
        let mut changes = Changes::default();
        let (before, after, action) = match (order, known) {
            (SilenceOrder::Begin { matchers, until, by, reason }, _) => {
                self.silences.pass(pen.now);
                if self.silences.0.len() >= MOST_SILENCES as usize {
                    return Err(Refused::TooManySilences { most: MOST_SILENCES as usize });
                }
                let said = Remark { by: by.clone(), reason: reason.clone(), at: pen.now };
                let id = pen.writer.next_id(pen.now);
                let row = SilenceRow { id, matchers: matchers.clone(), until: *until, said, ended: None };
                self.silences.0.push(row.clone());
                (None, row, "begin silence")
            }
            (SilenceOrder::End { silence, .. }, None) => return Err(Refused::UnknownSilence { id: *silence }),
            // It is over already.
            (SilenceOrder::End { silence, .. }, Some(row)) if row.ended.is_some() || row.until <= pen.now => {
                return Ok((*silence, changes));
            }
            (SilenceOrder::End { silence, by, reason }, Some(row)) => {
                self.silences.0.retain(|one| one.id != *silence);
                let ended = Some(Remark { by: by.clone(), reason: reason.clone(), at: pen.now });
                (Some(row.clone()), SilenceRow { ended, ..row }, "end silence")
            }
        };
        for at in self.places() {
            let row = &self.alerts[&at.0][at.1];
            let was_muted = row.alert.muted_until.is_some();
            let muting = self.silences.of_row(row, &pen.naming, pen.now);
            // One that ends now is over with the tick that follows.
            let until = muting.as_ref().map(|(_, until)| *until).or(was_muted.then_some(pen.now));
            if until != row.alert.muted_until {
                let row = &mut self.alerts.get_mut(&at.0).expect("it was found")[at.1];
                row.alert.muted_until = until;
                row.muted = muting.map(|(muted, _)| muted).or(row.muted.take());
                self.changed.insert(at);
            }
        }
        self.tick(pen);
        changes.access.audit.push(audited(pen, by, action, before.as_ref(), &after));
        let id = after.id;
        changes.silences.push(after);
        Ok((id, changes))
    }
}

fn audited(pen: &mut Pen<'_>, by: &Actor, action: &str, before: Option<&SilenceRow>, after: &SilenceRow) -> AuditRow {
    let (before, now) = (before.map(|row| body(row, pen.now)), pen.now);
    let line = pen.writer.next_id(now);
    by.line(line, now, (action, format!("silences/{}", after.id)), before.as_ref(), Some(&body(after, now)))
}

fn body(row: &SilenceRow, now: UtcMicros) -> MatchingSilenceBody {
    let Matchers { serial, imu, station, rule } = row.matchers.clone();
    let ended = row.ended.as_ref();
    MatchingSilenceBody {
        id: row.id.to_string(),
        matchers: MatchersBody { serial, imu, station, rule: rule.map(|rule| rule.name().to_owned()) },
        until: time::format(row.until),
        by: row.said.by.clone(),
        reason: row.said.reason.clone(),
        at: time::format(row.said.at),
        active: ended.is_none() && now < row.until,
        ended: ended.map(|said| EndedBody {
            by: said.by.clone(),
            reason: said.reason.clone(),
            at: time::format(said.at),
        }),
    }
}

impl Pipeline {
    /// Silences of many alerts, the newest first: those in force, or the newest of all.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn silences(&self, all: bool) -> Result<Vec<MatchingSilenceBody>, StoreError> {
        let now = self.clock.now();
        let rows = store::silence::list(&self.store, (!all).then_some(now), MOST_SILENCES).await?;
        Ok(rows.iter().map(|row| body(row, now)).collect())
    }

    /// # Errors
    /// [`StoreError`].
    pub async fn silence(&self, id: Id) -> Result<Option<MatchingSilenceBody>, StoreError> {
        Ok(store::silence::get(&self.store, id).await?.map(|row| body(&row, self.clock.now())))
    }

    /// Begins or ends a silence of many alerts; returns its identifier once that is on disk.
    ///
    /// # Errors
    /// [`Refused::UnknownSilence`], [`Refused::TooManySilences`], or as [`Pipeline::submit`].
    pub async fn order_silence(&self, order: SilenceOrder) -> Result<Id, Refused> {
        let (reply, answer) = oneshot::channel();
        self.offer(Job::Silence { order, by: Actor::by_caller(), reply })?;
        answer.await.map_err(|_| Refused::Stopping)?
    }
}
