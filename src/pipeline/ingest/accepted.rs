//! What has become of a submission.

use crate::pipeline::prelude::*;

/// The answer to one submission.
pub type Reply = Result<Accepted, Refused>;

/// What has become of a submission.
#[derive(Debug, Clone, PartialEq)]
pub enum Accepted {
    /// It is new, and on disk once [`Ingest::submit`](super::Ingest::submit) has returned it.
    Stored { id: Id, judged: Arc<[Judged]>, notes: Arc<[Note]> },
    /// An item with the same key has been there before; whether it says the same is for
    /// [`Ingest::settle`](super::Ingest::settle) to find out.
    /// `counts`: it was not voided or set aside, and no other stands in its place, as far as was looked.
    There { id: Id, same_bytes: bool, counts: bool },
}

impl Accepted {
    /// It was there before, says the same and counts.
    pub fn there(id: Id) -> Self {
        Self::There { id, same_bytes: true, counts: true }
    }

    /// What is to be said of it, where it is new.
    pub fn notes(&self) -> &[Note] {
        match self {
            Self::Stored { notes, .. } => notes,
            Self::There { .. } => &[],
        }
    }

    /// It is new, and there is nothing to be said of it.
    pub fn stored(id: Id) -> Self {
        Self::Stored { id, judged: [].into(), notes: [].into() }
    }
}

/// A gyro's verdicts on the record that was submitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    pub serial: Arc<str>,
    pub verdicts: Vec<Verdict>,
}
