//! Orders to diagnose many campaigns, and hypotheses of one's own, taken by the one writer.

use serde_json::json;

use super::models::{Competing, ModelCache};
use crate::core::effects::Effect;
use crate::core::message::sent;
use crate::pipeline::prelude::*;
use crate::store::{CampaignFilter, HypothesisRow, JobChanges, NewJob, Writer};
use crate::wire::diagnoses::WhichBody;
use crate::wire::hypothesis::HypothesisBody;
use crate::wire::json::written;

/// So many compete at most: each raises what a name takes, and the time of every diagnosis.
const MOST_HYPOTHESES: usize = 16;

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
) -> Result<Accepted, Refused> {
    let (id, diagnosis_jobs, action, after) = match order {
        DiagnosisOrder::Start(WantedDiagnoses { asked, which }) => {
            let (wanted, which, again) = (asked, *which, asked.again);
            let asked = written(wanted);
            if let Some(id) = store::diagnosis_job::open_as_asked(store, &asked).await? {
                return Ok(Accepted::there(id));
            }
            let (id, asked_by) = (writer.next_id(now), by.name().to_owned());
            let started = vec![NewJob { id, asked_at: now, asked_by, asked, which, again, program }];
            (id, JobChanges { started, ..JobChanges::default() }, "start diagnoses", Some(wanted))
        }
        DiagnosisOrder::Cancel(id) => {
            let row = store::diagnosis_job::get(store, *id).await?.ok_or_else(|| Problem::no_such_diagnoses(id))?;
            match (row.canceled, row.ended_at) {
                (true, _) => return Ok(Accepted::there(*id)),
                (false, Some(_)) => {
                    let ended = message!("diagnoses_ended", id = text(id));
                    return Err(Refused::conflict("title_diagnoses_ended", ended));
                }
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

/// What is to become of hypotheses.
#[derive(Debug)]
pub enum HypothesisOrder {
    /// An effect that is one's own, who says so, and why.
    Add { effect: Effect, author: String, reason: String },
    /// The one with this name is taken out.
    End(String),
}

/// Carries out one order; on disk when this returns. The same again changes nothing.
pub(crate) async fn order_hypothesis(
    store: &Store,
    writer: &mut Writer,
    now: UtcMicros,
    cache: &ModelCache,
    order: &HypothesisOrder,
    by: &Actor,
) -> Result<Accepted, Refused> {
    let known = Competing::read(store).await?.hypotheses;
    let named = |name: &str| known.iter().find(|stored| stored.effect.id() == name);
    let (row, action, name) = match order {
        HypothesisOrder::Add { effect, author, reason } => {
            let name = effect.id().to_owned();
            match named(&name) {
                Some(same) if same.effect == *effect => return Ok(Accepted::there(same.row.id)),
                Some(_) => {
                    let taken = message!("hypothesis_taken", name = sent(&name));
                    return Err(Refused::conflict("title_hypothesis_taken", taken));
                }
                None if known.len() >= MOST_HYPOTHESES => {
                    let many = message!("hypotheses_too_many", most = MOST_HYPOTHESES);
                    return Err(Refused::conflict("title_too_many_hypotheses", many));
                }
                None => {}
            }
            let own = effect.hypothesis().map(|own| HypothesisBody::from(&own.written));
            let (id, body) = (writer.next_id(now), written(&own));
            let (author, reason) = (author.clone(), reason.clone());
            let row = HypothesisRow { id, body, author, reason, added_at: now, ended_at: None };
            (row, "add hypothesis", name)
        }
        HypothesisOrder::End(name) => {
            let known = named(name).ok_or_else(|| Problem::no_such_hypothesis(name))?;
            (HypothesisRow { ended_at: Some(now), ..known.row.clone() }, "end hypothesis", name.clone())
        }
    };
    let hypothesis: serde_json::Value = serde_json::from_str(&row.body).unwrap_or_default();
    let said = json!({ "author": row.author, "reason": row.reason, "hypothesis": hypothesis });
    let (before, after) = if row.ended_at.is_some() { (Some(&said), None) } else { (None, Some(&said)) };
    let line = writer.next_id(now);
    let (id, mut changes) = (row.id, Changes::default());
    changes.access.audit.push(by.line(line, now, (action, format!("hypotheses/{name}")), before, after));
    changes.hypotheses.push(row);
    writer.commit(&changes).await?;
    cache.read_again(store).await?;
    Ok(Accepted::stored(id))
}
