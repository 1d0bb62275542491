//! Orders to diagnose many campaigns: read, taken, canceled, shown.

use tokio::sync::oneshot;

use super::program;
use crate::core::fault::Faults;
use crate::core::time::UtcMicros;
use crate::message;
use crate::pipeline::access::Actor;
use crate::pipeline::{Accepted, Job, Pipeline, Refused};
use crate::store;
use crate::store::{
    AccessChanges, CampaignFilter, Changes, FailedTask, Id, JobChanges, JobRow, NewJob, Span, Store, StoreError,
    TaskCounts, Writer,
};
use crate::wire::diagnoses::{CountsBody, FailureBody, JobBody, JobDetailBody, WhichBody};
use crate::wire::message::from_stored;
use crate::wire::{cursor, json, text, time};
use crate::words;

/// Which campaigns somebody wants diagnosed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WantedDiagnoses {
    /// With times in UTC: two orders that mean the same read the same.
    asked: WhichBody,
    which: CampaignFilter,
}

/// What is to become of orders.
#[derive(Debug)]
pub enum DiagnosisOrder {
    Start(WantedDiagnoses),
    Cancel(Id),
}

/// The writer at work on orders.
pub(crate) struct JobDesk<'a> {
    pub store: &'a Store,
    pub writer: &'a mut Writer,
    pub now: UtcMicros,
}

impl JobDesk<'_> {
    /// Carries out one order; on disk when this returns. One that is already being worked off is not begun a second time.
    pub async fn carry_out(&mut self, order: &DiagnosisOrder, by: &Actor) -> Result<Accepted, Refused> {
        match order {
            DiagnosisOrder::Start(wanted) => self.start(wanted, by).await,
            DiagnosisOrder::Cancel(id) => self.cancel(*id, by).await,
        }
    }

    async fn start(&mut self, wanted: &WantedDiagnoses, by: &Actor) -> Result<Accepted, Refused> {
        let asked = super::text(&wanted.asked);
        if let Some(id) = store::diagnosis_job::open_as_asked(self.store, &asked).await? {
            return Ok(Accepted::There { id, same_bytes: true });
        }
        let (now, id) = (self.now, self.writer.next_id(self.now));
        let job = NewJob {
            id,
            asked_at: now,
            asked_by: by.name().to_owned(),
            asked,
            which: wanted.which,
            again: wanted.asked.again,
            program: program(),
        };
        let started = JobChanges { started: vec![job], ..JobChanges::default() };
        self.commit(started, "start diagnoses", id, by, Some(&wanted.asked)).await?;
        Ok(Accepted::stored(id))
    }

    async fn cancel(&mut self, id: Id, by: &Actor) -> Result<Accepted, Refused> {
        let row = store::diagnosis_job::get(self.store, id).await?.ok_or(Refused::NoSuchDiagnoses { id })?;
        match (row.canceled, row.ended_at) {
            (true, _) => return Ok(Accepted::There { id, same_bytes: true }),
            (false, Some(_)) => return Err(Refused::DiagnosesEnded { id }),
            (false, None) => {}
        }
        let canceled = JobChanges { canceled: vec![(id, self.now)], ..JobChanges::default() };
        self.commit(canceled, "cancel diagnoses", id, by, None).await?;
        Ok(Accepted::stored(id))
    }

    async fn commit(
        &mut self,
        diagnosis_jobs: JobChanges,
        action: &str,
        id: Id,
        by: &Actor,
        after: Option<&WhichBody>,
    ) -> Result<(), StoreError> {
        let line = self.writer.next_id(self.now);
        let audit = vec![by.line(line, self.now, (action, format!("diagnoses/{id}")), None::<&()>, after)];
        let access = AccessChanges { audit, ..AccessChanges::default() };
        self.writer.commit(&Changes { diagnosis_jobs, access, ..Changes::default() }).await
    }
}

fn shown(row: JobRow, counts: TaskCounts) -> Result<JobBody, StoreError> {
    let damaged = |error| StoreError::Damaged(format!("order {} of diagnoses cannot be read: {error}", row.id));
    let asked: WhichBody = serde_json::from_str(&row.asked).map_err(damaged)?;
    let state = match (row.canceled, row.ended_at, row.begun_at) {
        (true, ..) => "canceled",
        (false, Some(_), _) => "done",
        (false, None, Some(_)) => "running",
        (false, None, None) => "waiting",
    };
    let TaskCounts { waiting, done, failed, canceled } = counts;
    Ok(JobBody {
        id: row.id.to_string(),
        state: state.to_owned(),
        asked,
        asked_by: row.asked_by,
        asked_at: time::format(row.asked_at),
        begun_at: row.begun_at.map(time::format),
        ended_at: row.ended_at.map(time::format),
        counts: CountsBody { campaigns: waiting + done + failed + canceled, waiting, done, failed, canceled },
    })
}

impl Pipeline {
    /// Reads which campaigns are to be diagnosed.
    ///
    /// # Errors
    /// Every fault by its place.
    pub fn read_wanted_diagnoses(&self, bytes: &[u8]) -> Result<WantedDiagnoses, Faults> {
        self.check_wanted_diagnoses(json::parse(bytes)?)
    }

    /// As [`Pipeline::read_wanted_diagnoses`], of what has been taken apart already.
    ///
    /// # Errors
    /// Every fault by its place.
    pub fn check_wanted_diagnoses(&self, asked: WhichBody) -> Result<WantedDiagnoses, Faults> {
        let mut faults = Faults::default();
        let which = self.campaign_filter(&asked, &mut faults);
        let in_utc = |at: Option<String>, instant| at.map(|_| time::format(instant));
        let asked = WhichBody {
            since: in_utc(asked.since, which.measured.from),
            until: in_utc(asked.until, which.measured.to),
            ..asked
        };
        faults.or(WantedDiagnoses { asked, which })
    }

    /// The campaigns that are meant, faults noted at their places.
    pub(super) fn campaign_filter(&self, asked: &WhichBody, faults: &mut Faults) -> CampaignFilter {
        let mut known = |what: &str, name: &Option<String>, number: Option<u32>| {
            if let (Some(name), None) = (name, number) {
                let unknown = match what {
                    "imu" => message!("unknown_imu", imu = name.clone()),
                    _ => message!("unknown_station", station = name.clone()),
                };
                faults.push(format!("/{what}"), unknown);
            }
            number
        };
        let (imu, station) = {
            let tables = self.store.names().read();
            let imu = asked.imu.as_deref().and_then(|name| tables.imus.number(name));
            let station = asked.station.as_deref().and_then(|name| tables.stations.number(name));
            (known("imu", &asked.imu, imu), known("station", &asked.station, station))
        };
        let mut instant = |place: &str, at: &Option<String>, otherwise| {
            at.as_deref().map_or(otherwise, |at| text::instant(place, at, faults))
        };
        let from = instant("/since", &asked.since, Span::EVER.from);
        let to = instant("/until", &asked.until, Span::EVER.to);
        if faults.is_empty() && from > to {
            faults.push("/until", message!("until_before_since"));
        }
        CampaignFilter { imu, station, measured: Span { from, to } }
    }

    /// Has the writer carry out an order about many diagnoses; returns once it is on disk.
    ///
    /// # Errors
    /// [`Refused`]; then nothing has changed, but after [`StoreError::Unanswered`](crate::store::StoreError) that is not known.
    pub async fn order_diagnoses(&self, order: DiagnosisOrder) -> Result<Accepted, Refused> {
        let (reply, answer) = oneshot::channel();
        self.offer(Job::Diagnoses { order, by: Actor::by_caller(), reply })?;
        answer.await.map_err(|_| Refused::Stopping)?
    }

    /// Orders with their progress, newest first, those before `before`.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn diagnosis_jobs(&self, before: Option<Id>, limit: u32) -> Result<Vec<JobBody>, StoreError> {
        let mut bodies = Vec::new();
        for row in store::diagnosis_job::list(&self.store, before, limit).await? {
            let counts = store::diagnosis_job::task_counts(&self.store, row.id).await?;
            bodies.push(shown(row, counts)?);
        }
        Ok(bodies)
    }

    /// One order, and what failed of it after `after`.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn diagnosis_job(
        &self,
        id: Id,
        after: Option<Id>,
        limit: u32,
    ) -> Result<Option<JobDetailBody>, StoreError> {
        let Some(row) = store::diagnosis_job::get(&self.store, id).await? else { return Ok(None) };
        let job = shown(row, store::diagnosis_job::task_counts(&self.store, id).await?)?;
        let mut failed = store::diagnosis_job::failed_tasks(&self.store, id, after, limit + 1).await?;
        let more = failed.len() > limit as usize;
        failed.truncate(limit as usize);
        let next = failed.last().filter(|_| more).map(|last| cursor::encode(last.record.0));
        let tables = self.store.names().read();
        let failure = |task: FailedTask| FailureBody {
            campaign: task.record.to_string(),
            imu: tables.imus.name(task.imu).map_or_else(String::new, |name| name.to_string()),
            measured_at: time::format(task.measured_at),
            reason: words::asked().words(&from_stored(&task.reason)),
        };
        Ok(Some(JobDetailBody { job, failures: failed.into_iter().map(failure).collect(), next }))
    }

    /// Campaigns that wait for their first diagnosis, and those that orders wait for.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn diagnoses_waiting(&self) -> Result<(u64, u64), StoreError> {
        store::diagnosis_job::diagnoses_waiting(&self.store).await
    }
}
