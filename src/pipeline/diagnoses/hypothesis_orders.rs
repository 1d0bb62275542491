//! Hypotheses of one's own, added and taken out by the one writer.

use super::models::{Competing, ModelCache};
use crate::core::effects::Effect;
use crate::pipeline::prelude::*;
use crate::store::{HypothesisRow, Writer};
use crate::wire::hypothesis::HypothesisBody;
use crate::wire::json;

/// So many compete at most: each raises what a name takes, and the time of every diagnosis.
const MOST: usize = 16;

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
) -> Result<Accepted, OrderError> {
    let known = Competing::read(store).await?.hypotheses;
    let named = |name: &str| known.iter().find(|stored| stored.effect.id() == name);
    let (row, action, name) = match order {
        HypothesisOrder::Add { effect, author, reason } => {
            let name = effect.id().to_owned();
            match named(&name) {
                Some(same) if same.effect == *effect => return Ok(Accepted::there(same.row.id)),
                Some(_) => return Err(OrderError::HypothesisTaken(name)),
                None if known.len() >= MOST => return Err(OrderError::TooManyHypotheses(MOST)),
                None => {}
            }
            let written = effect.hypothesis().map(|own| HypothesisBody::from(&own.written));
            let (id, body) = (writer.next_id(now), json::written(&written));
            let (author, reason) = (author.clone(), reason.clone());
            let row = HypothesisRow { id, body, author, reason, added_at: now, ended_at: None };
            (row, "add hypothesis", name)
        }
        HypothesisOrder::End(name) => {
            let known = named(name).ok_or_else(|| OrderError::NoSuchHypothesis(name.clone()))?;
            (HypothesisRow { ended_at: Some(now), ..known.row.clone() }, "end hypothesis", name.clone())
        }
    };
    let hypothesis: serde_json::Value = serde_json::from_str(&row.body).unwrap_or_default();
    let said = serde_json::json!({ "author": row.author, "reason": row.reason, "hypothesis": hypothesis });
    let (before, after) = if row.ended_at.is_some() { (Some(&said), None) } else { (None, Some(&said)) };
    let line = writer.next_id(now);
    let (id, mut changes) = (row.id, Changes::default());
    changes.access.audit.push(by.line(line, now, (action, format!("hypotheses/{name}")), before, after));
    changes.hypotheses.push(row);
    writer.commit(&changes).await?;
    cache.read_again(store).await?;
    Ok(Accepted::stored(id))
}
