//! The same key again: does it say the same?

use serde::Serialize;
use serde_json::Value;

use super::read::anything;
use super::{Accepted, Pipeline, Refused};
use crate::store::{Id, Kind};
use crate::wire::bench::BenchBody;
use crate::wire::campaign;
use crate::wire::json::{first_difference, parse};
use crate::wire::record::RecordBody;

/// What was sent: what kind of document, and its text.
#[derive(Debug, Clone, Copy)]
pub enum Sent<'a> {
    Calibration(Kind, &'a str),
    Bench(&'a str),
}

impl Pipeline {
    /// The id, where an item that was already there says the same as the one sent: however it is written, in whatever
    /// order of members, unit of time or offset.
    ///
    /// # Errors
    /// [`Refused::Differs`] with the first member that differs.
    pub async fn settle(&self, accepted: &Accepted, sent: Sent<'_>) -> Result<Id, Refused> {
        let (id, same_bytes) = match accepted {
            Accepted::Stored { id, .. } => (*id, true),
            Accepted::There { id, same_bytes } => (*id, *same_bytes),
        };
        if same_bytes {
            return Ok(id);
        }
        let difference = match sent {
            Sent::Calibration(kind, body) => match self.store.record(id).await? {
                Some(stored) if stored.kind == kind => {
                    first_difference(&value_of(kind, &stored.body), &value_of(kind, body))
                }
                _ => Some(String::new()),
            },
            Sent::Bench(body) => match self.store.bench_result(id).await? {
                Some(stored) => first_difference(&bench_value(&stored.body), &bench_value(body)),
                None => Some(String::new()),
            },
        };
        difference.map_or(Ok(id), |pointer| Err(Refused::Differs { existing: id, pointer }))
    }
}

/// Whether two calibrations of the same kind say the same, however they are written.
pub(super) fn says_the_same(kind: Kind, a: &str, b: &str) -> bool {
    first_difference(&value_of(kind, a), &value_of(kind, b)).is_none()
}

/// Whether two bench results say the same, however they are written.
pub(super) fn benches_agree(a: &str, b: &str) -> bool {
    first_difference(&bench_value(a), &bench_value(b)).is_none()
}

/// A calibration's document in its one canonical form.
fn value_of(kind: Kind, body: &str) -> Value {
    let canonical = match kind {
        Kind::Record => {
            let record = parse::<RecordBody>(body.as_bytes()).and_then(|record| record.to_core(&anything()));
            record.ok().and_then(|record| to_value(&RecordBody::of(&record)))
        }
        Kind::Campaign => campaign_value(body),
    };
    canonical.unwrap_or_else(|| as_it_stands(body))
}

fn bench_value(body: &str) -> Value {
    let result = parse::<BenchBody>(body.as_bytes()).and_then(|bench| bench.to_core(f64::INFINITY));
    let value = result.ok().and_then(|result| to_value(&BenchBody::of(&result)));
    value.or_else(|| campaign_value(body)).unwrap_or_else(|| as_it_stands(body))
}

/// Of a campaign, or a raw bench test.
fn campaign_value(body: &str) -> Option<Value> {
    let campaign = campaign::parse_json(body.as_bytes()).ok()?;
    serde_json::from_str(&campaign::to_json(&campaign)).ok()
}

fn to_value(body: &impl Serialize) -> Option<Value> {
    serde_json::to_value(body).ok()
}

fn as_it_stands(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or_else(|_| Value::String(body.to_owned()))
}
