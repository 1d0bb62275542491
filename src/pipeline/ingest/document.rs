//! Any one document that was read, and what it is compared with.

use std::sync::Arc;

use crate::core::kind::Kind;
use crate::pipeline::ingest::same_content::{Sent, benches_agree, says_the_same};
use crate::pipeline::ingest::submission::Submission;

/// A document that can be stored, and how it would be compared with one that is there.
#[derive(Debug, Clone)]
pub struct ReadDocument {
    pub submission: Submission,
    pub origin: Origin,
}

/// What a submission was read from.
#[derive(Debug, Clone)]
pub struct Origin {
    pub(super) kind: OriginKind,
    pub(super) body: Arc<str>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum OriginKind {
    Record,
    Campaign,
    Bench,
}

impl Origin {
    /// To be compared with what is there.
    pub(super) fn sent(&self) -> Sent<'_> {
        match self.kind {
            OriginKind::Record => Sent::Calibration(Kind::Record, &self.body),
            OriginKind::Campaign => Sent::Calibration(Kind::Campaign, &self.body),
            OriginKind::Bench => Sent::Bench(&self.body),
        }
    }

    /// Whether both say the same, however they are written.
    pub(crate) fn says_the_same_as(&self, other: &Self) -> bool {
        match (self.kind, other.kind) {
            (OriginKind::Record, OriginKind::Record) => says_the_same(Kind::Record, &self.body, &other.body),
            (OriginKind::Campaign, OriginKind::Campaign) => says_the_same(Kind::Campaign, &self.body, &other.body),
            (OriginKind::Bench, OriginKind::Bench) => benches_agree(&self.body, &other.body),
            _ => false,
        }
    }
}
