//! The same key again: does it say the same?

use serde_json::Value;

use crate::pipeline::ingest::submission::{Calibration, Submission, anything};
use crate::pipeline::prelude::*;
use crate::wire::bench::BenchBody;
use crate::wire::campaign;
use crate::wire::differences::Differences;
use crate::wire::document::DocumentKind;
use crate::wire::json::parse;
use crate::wire::record::RecordBody;

/// What a submission was read from, to be compared with what is there.
#[derive(Debug, Clone)]
pub struct Origin {
    pub kind: DocumentKind,
    pub body: Arc<str>,
}

impl Origin {
    /// None of what was not sent as a document.
    pub fn of(sent: &Submission) -> Option<Self> {
        match sent {
            Submission::Calibration(sent) => Some(sent.as_ref().into()),
            Submission::Bench(sent) => Some(Self { kind: DocumentKind::Bench, body: Arc::clone(&sent.body) }),
            _ => None,
        }
    }

    /// Whether both say the same, however they are written.
    pub(super) fn say_the_same(one: &Option<Self>, other: &Option<Self>) -> bool {
        let both = one.as_ref().zip(other.as_ref());
        both.is_some_and(|(one, other)| one.kind == other.kind && says_the_same(one.kind, &one.body, &other.body))
    }
}

impl From<&Calibration> for Origin {
    fn from(sent: &Calibration) -> Self {
        Self { kind: sent.kind.into(), body: Arc::clone(&sent.body) }
    }
}

/// In what the stored item under this identifier and the one sent differ.
pub(super) async fn differences(store: &Store, id: Id, sent: &Origin) -> Result<Differences, StoreError> {
    let stored = match sent.kind {
        DocumentKind::Bench => store::bench::get(store, id).await?.map(|stored| stored.body),
        kind => {
            let stored = store::record::get(store, id).await?;
            stored.filter(|stored| kind == stored.kind.into()).map(|stored| stored.body)
        }
    };
    Ok(stored.map_or_else(Differences::in_everything, |stored| differ(sent.kind, &stored, &sent.body)))
}

/// Whether two documents of the same kind say the same, however they are written.
pub(crate) fn says_the_same(kind: DocumentKind, a: &str, b: &str) -> bool {
    differ(kind, a, b).is_empty()
}

fn differ(kind: DocumentKind, stored: &str, sent: &str) -> Differences {
    Differences::between(value_of(kind, stored), &value_of(kind, sent))
}

/// A document in its one canonical form.
fn value_of(kind: DocumentKind, body: &str) -> Value {
    let canonical = match kind {
        DocumentKind::Record => {
            let record = parse::<RecordBody>(body.as_bytes()).and_then(|record| record.to_core(&anything()));
            record.ok().and_then(|record| serde_json::to_value(RecordBody::from(&record)).ok())
        }
        DocumentKind::Campaign => campaign_value(body),
        DocumentKind::Bench => {
            let result = parse::<BenchBody>(body.as_bytes()).and_then(|bench| bench.to_core(f64::INFINITY));
            let value = result.ok().and_then(|result| serde_json::to_value(BenchBody::from(&result)).ok());
            value.or_else(|| campaign_value(body))
        }
    };
    canonical.unwrap_or_else(|| serde_json::from_str(body).unwrap_or_else(|_| Value::String(body.to_owned())))
}

/// Of a campaign, or a raw bench test.
fn campaign_value(body: &str) -> Option<Value> {
    let campaign = campaign::parse_json(body.as_bytes()).ok()?;
    serde_json::from_str(&campaign::to_json(&campaign)).ok()
}
