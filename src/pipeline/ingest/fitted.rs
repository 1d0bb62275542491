//! What was read and is ready to be stored: any one document, or a campaign with its fit.

use crate::core::calibrate::outcome::Outcome;
use crate::core::campaign::Campaign;
use crate::core::fault::Faults;
use crate::pipeline::ingest::same_content::Origin;
use crate::pipeline::ingest::submission::{BenchTest, Calibration, Submission};
use crate::pipeline::prelude::*;
use crate::store::RecordRow;
use crate::wire::campaign;
use crate::wire::document::DocumentKind;

/// A document that can be stored, and how it would be compared with one that is there.
#[derive(Debug, Clone)]
pub struct ReadDocument {
    pub submission: Submission,
    pub origin: Origin,
}

/// A campaign that can be stored.
#[derive(Debug, Clone)]
pub struct ReadCampaign {
    pub fitted: Fitted,
    /// What its answer is made of.
    pub fit: CampaignFit,
    /// As it is kept: JSON, whichever form it came in.
    pub body: Arc<str>,
}

/// What dwells become.
#[derive(Debug, Clone)]
pub enum Fitted {
    /// Of an IMU.
    Calibration(Box<Calibration>),
    /// Of a single gyro on a bench.
    Bench(Box<BenchTest>),
}

impl Fitted {
    /// Of the document that it is stored as.
    pub fn kind(&self) -> DocumentKind {
        match self {
            Self::Calibration(_) => DocumentKind::Campaign,
            Self::Bench(_) => DocumentKind::Bench,
        }
    }

    pub fn with_key(mut self, key: Option<String>) -> Self {
        match &mut self {
            Self::Calibration(calibration) => calibration.idempotency_key = key,
            Self::Bench(bench) => bench.idempotency_key = key,
        }
        self
    }
}

impl From<Fitted> for Submission {
    fn from(fitted: Fitted) -> Self {
        match fitted {
            Fitted::Calibration(calibration) => Self::Calibration(calibration),
            Fitted::Bench(bench) => Self::Bench(bench),
        }
    }
}

/// A campaign as it is fitted when it comes, and again whenever it is read.
#[derive(Debug, Clone)]
pub struct CampaignFit {
    pub(crate) campaign: Campaign,
    pub(crate) outcome: Outcome,
    /// The adopted model that it is fitted with.
    pub(crate) model: Option<Id>,
}

/// A stored campaign.
pub(crate) fn campaign_of(row: &RecordRow) -> Result<Campaign, StoreError> {
    campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(row.id, &faults))
}

pub(crate) fn damaged(id: Id, faults: &Faults) -> StoreError {
    StoreError::damaged(format_args!("the body of campaign {id} cannot be read: {faults}"))
}
