//! Orders to diagnose many campaigns, taken and canceled by the one writer.

use super::made::text;
use crate::pipeline::prelude::*;
use crate::store::{CampaignFilter, JobChanges, NewJob, Writer};
use crate::wire::diagnoses::WhichBody;

/// Which campaigns somebody wants diagnosed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WantedDiagnoses {
    /// With times in UTC: two orders that mean the same read the same.
    pub(super) asked: WhichBody,
    pub(super) which: CampaignFilter,
}

/// What is to become of orders.
#[derive(Debug)]
pub enum DiagnosisOrder {
    Start(WantedDiagnoses),
    Cancel(Id),
}

/// The writer at work on orders.
pub(crate) struct DiagnosisHandler<'a> {
    pub store: &'a Store,
    pub writer: &'a mut Writer,
    pub now: UtcMicros,
    /// What makes diagnoses now.
    pub program: String,
}

impl DiagnosisHandler<'_> {
    /// Carries out one order; on disk when this returns. One that is already being worked off is not begun a second
    /// time.
    pub async fn carry_out(&mut self, order: &DiagnosisOrder, by: &Actor) -> Result<Accepted, OrderError> {
        match order {
            DiagnosisOrder::Start(wanted) => self.start(wanted, by).await,
            DiagnosisOrder::Cancel(id) => self.cancel(*id, by).await,
        }
    }

    async fn start(&mut self, wanted: &WantedDiagnoses, by: &Actor) -> Result<Accepted, OrderError> {
        let asked = text(&wanted.asked);
        if let Some(id) = store::diagnosis_job::open_as_asked(self.store, &asked).await? {
            return Ok(Accepted::there(id));
        }
        let (now, id) = (self.now, self.writer.next_id(self.now));
        let job = NewJob {
            id,
            asked_at: now,
            asked_by: by.name().to_owned(),
            asked,
            which: wanted.which,
            again: wanted.asked.again,
            program: self.program.clone(),
        };
        let started = JobChanges { started: vec![job], ..JobChanges::default() };
        self.commit(started, "start diagnoses", id, by, Some(&wanted.asked)).await?;
        Ok(Accepted::stored(id))
    }

    async fn cancel(&mut self, id: Id, by: &Actor) -> Result<Accepted, OrderError> {
        let row = store::diagnosis_job::get(self.store, id).await?.ok_or(OrderError::NoSuchDiagnoses(id))?;
        match (row.canceled, row.ended_at) {
            (true, _) => return Ok(Accepted::there(id)),
            (false, Some(_)) => return Err(OrderError::DiagnosesEnded(id)),
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
        let mut changes = Changes { diagnosis_jobs, ..Changes::default() };
        changes.access.audit.push(by.line(line, self.now, (action, format!("diagnoses/{id}")), None::<&()>, after));
        self.writer.commit(&changes).await
    }
}
