//! Any one document that was read, and what it is compared with.

use crate::pipeline::ingest::same_content::{benches_agree, says_the_same};
use crate::pipeline::prelude::*;
use crate::pipeline::{Sent, Submission};
use crate::wire::document::DocumentKind;

/// A document that can be stored, and how it would be compared with one that is there.
#[derive(Debug, Clone)]
pub struct ReadDocument {
    pub submission: Submission,
    pub origin: Origin,
}

/// What a submission was read from.
#[derive(Debug, Clone)]
pub struct Origin {
    pub(super) kind: DocumentKind,
    pub(super) body: Arc<str>,
}

impl Origin {
    /// To be compared with what is there.
    pub(super) fn sent(&self) -> Sent<'_> {
        match self.kind {
            DocumentKind::Record => Sent::Calibration(Kind::Record, &self.body),
            DocumentKind::Campaign => Sent::Calibration(Kind::Campaign, &self.body),
            DocumentKind::Bench => Sent::Bench(&self.body),
        }
    }

    /// Whether both say the same, however they are written.
    pub(crate) fn says_the_same_as(&self, other: &Self) -> bool {
        self.kind == other.kind
            && match self.sent() {
                Sent::Calibration(kind, body) => says_the_same(kind, body, &other.body),
                Sent::Bench(body) => benches_agree(body, &other.body),
            }
    }
}
