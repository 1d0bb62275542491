//! Orders to diagnose many campaigns, taken and canceled by the one writer.

use crate::pipeline::prelude::*;
use crate::store::{CampaignFilter, JobChanges, NewJob, Writer};
use crate::wire::diagnoses::WhichBody;
use crate::wire::json;

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

/// Carries out one order; on disk when this returns. One that is already being worked off is not begun a second time.
/// `program`: what makes diagnoses now.
pub(crate) async fn order_diagnoses(
    store: &Store,
    writer: &mut Writer,
    now: UtcMicros,
    program: String,
    order: &DiagnosisOrder,
    by: &Actor,
) -> Result<Accepted, OrderError> {
    let (id, diagnosis_jobs, action, after) = match order {
        DiagnosisOrder::Start(WantedDiagnoses { asked, which }) => {
            let (wanted, which, again) = (asked, *which, asked.again);
            let asked = json::written(wanted);
            if let Some(id) = store::diagnosis_job::open_as_asked(store, &asked).await? {
                return Ok(Accepted::there(id));
            }
            let (id, asked_by) = (writer.next_id(now), by.name().to_owned());
            let started = vec![NewJob { id, asked_at: now, asked_by, asked, which, again, program }];
            (id, JobChanges { started, ..JobChanges::default() }, "start diagnoses", Some(wanted))
        }
        DiagnosisOrder::Cancel(id) => {
            let row = store::diagnosis_job::get(store, *id).await?.ok_or(OrderError::NoSuchDiagnoses(*id))?;
            match (row.canceled, row.ended_at) {
                (true, _) => return Ok(Accepted::there(*id)),
                (false, Some(_)) => return Err(OrderError::DiagnosesEnded(*id)),
                (false, None) => {}
            }
            let canceled = vec![(*id, now)];
            (*id, JobChanges { canceled, ..JobChanges::default() }, "cancel diagnoses", None)
        }
    };
    let line = writer.next_id(now);
    let mut changes = Changes { diagnosis_jobs, ..Changes::default() };
    changes.access.audit.push(by.line(line, now, (action, format!("diagnoses/{id}")), None::<&()>, after));
    writer.commit(&changes).await?;
    Ok(Accepted::stored(id))
}
