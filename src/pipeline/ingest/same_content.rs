//! The same key again: does it say the same?

use serde::Serialize;
use serde_json::Value;

use crate::pipeline::ingest::submission::anything;
use crate::pipeline::prelude::*;
use crate::wire::bench::BenchBody;
use crate::wire::campaign;
use crate::wire::differences::Differences;
use crate::wire::json::parse;
use crate::wire::record::RecordBody;

/// What was sent: what kind of document, and its text.
#[derive(Debug, Clone, Copy)]
pub enum Sent<'a> {
    Calibration(Kind, &'a str),
    Bench(&'a str),
}

/// In what the stored item under this identifier and the one sent differ.
pub(super) async fn differences(store: &Store, id: Id, sent: Sent<'_>) -> Result<Differences, StoreError> {
    Ok(match sent {
        Sent::Calibration(kind, body) => match store::record::get(store, id).await? {
            Some(stored) if stored.kind == kind => calibrations_differ(kind, &stored.body, body),
            _ => Differences::in_everything(),
        },
        Sent::Bench(body) => match store::bench::get(store, id).await? {
            Some(stored) => benches_differ(&stored.body, body),
            None => Differences::in_everything(),
        },
    })
}

/// Whether two calibrations of the same kind say the same, however they are written.
pub(crate) fn says_the_same(kind: Kind, a: &str, b: &str) -> bool {
    calibrations_differ(kind, a, b).is_empty()
}

/// Whether two bench results say the same, however they are written.
pub(crate) fn benches_agree(a: &str, b: &str) -> bool {
    benches_differ(a, b).is_empty()
}

fn calibrations_differ(kind: Kind, stored: &str, sent: &str) -> Differences {
    Differences::between(value_of(kind, stored), &value_of(kind, sent))
}

fn benches_differ(stored: &str, sent: &str) -> Differences {
    Differences::between(bench_value(stored), &bench_value(sent))
}

/// A calibration's document in its one canonical form.
fn value_of(kind: Kind, body: &str) -> Value {
    let canonical = match kind {
        Kind::Record => {
            let record = parse::<RecordBody>(body.as_bytes()).and_then(|record| record.to_core(&anything()));
            record.ok().and_then(|record| to_value(&RecordBody::from(&record)))
        }
        Kind::Campaign => campaign_value(body),
    };
    canonical.unwrap_or_else(|| as_it_stands(body))
}

fn bench_value(body: &str) -> Value {
    let result = parse::<BenchBody>(body.as_bytes()).and_then(|bench| bench.to_core(f64::INFINITY));
    let value = result.ok().and_then(|result| to_value(&BenchBody::from(&result)));
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
