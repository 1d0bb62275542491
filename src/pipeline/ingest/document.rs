//! Any one document: told by what it holds, read, and settled.

use std::sync::Arc;

use crate::core::fault::Faults;
use crate::pipeline::ingest::same_content::{benches_agree, says_the_same};
use crate::pipeline::{Accepted, Fitted, Id, Kind, Pipeline, ReadCampaign, Refused, Sent, Submission};
use crate::wire::campaign::Form;
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
    kind: OriginKind,
    body: Arc<str>,
}

#[derive(Debug, Clone, Copy)]
enum OriginKind {
    Record,
    Campaign,
    Bench,
}

impl Origin {
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

impl Pipeline {
    /// Reads a record, a campaign or a bench result, whichever the JSON holds.
    ///
    /// # Errors
    /// Every fault, by its pointer.
    pub fn read_document(&self, bytes: &[u8]) -> Result<ReadDocument, Faults> {
        let kind = DocumentKind::of(bytes);
        self.read_as(kind, bytes).or_else(|faults| match DocumentKind::instead_of(kind, bytes) {
            // What it lacks is the time by which its kind is told at a glance.
            Some(other) => self.read_as(other, bytes),
            None => Err(faults),
        })
    }

    fn read_as(&self, kind: DocumentKind, bytes: &[u8]) -> Result<ReadDocument, Faults> {
        match kind {
            DocumentKind::Record => {
                let calibration = self.read_record(bytes)?;
                let origin = Origin { kind: OriginKind::Record, body: Arc::clone(&calibration.body) };
                Ok(ReadDocument { submission: Submission::Calibration(Box::new(calibration)), origin })
            }
            DocumentKind::Campaign => self.read_campaign_document(bytes, Form::Json),
            DocumentKind::Bench => {
                let bench = self.read_bench_result(bytes)?;
                let origin = Origin { kind: OriginKind::Bench, body: Arc::clone(&bench.body) };
                Ok(ReadDocument { submission: Submission::Bench(Box::new(bench)), origin })
            }
        }
    }

    /// Reads a campaign in JSON or CSV.
    ///
    /// # Errors
    /// Every fault, by its pointer, or its line and column.
    pub fn read_campaign_document(&self, bytes: &[u8], form: Form) -> Result<ReadDocument, Faults> {
        let ReadCampaign { fitted, body, .. } = self.read_campaign(bytes, form)?;
        let kind = match fitted {
            Fitted::Calibration(_) => OriginKind::Campaign,
            Fitted::Bench(_) => OriginKind::Bench,
        };
        Ok(ReadDocument { submission: fitted.into(), origin: Origin { kind, body } })
    }

    /// The id of what was submitted: newly stored, or there already with the same content.
    ///
    /// # Errors
    /// [`Refused::Differs`] where it is there with other content.
    pub async fn settle_document(&self, accepted: &Accepted, origin: &Origin) -> Result<Id, Refused> {
        let sent = match origin.kind {
            OriginKind::Record => Sent::Calibration(Kind::Record, &origin.body),
            OriginKind::Campaign => Sent::Calibration(Kind::Campaign, &origin.body),
            OriginKind::Bench => Sent::Bench(&origin.body),
        };
        self.settle(accepted, sent).await
    }
}
