//! A campaign that was read and is ready to be stored, with its fit.

use crate::core::calibrate::outcome::Outcome;
use crate::core::campaign::Campaign;
use crate::core::fault::Faults;
use crate::pipeline::ingest::submission::Submission;
use crate::pipeline::prelude::*;
use crate::store::RecordRow;
use crate::wire::campaign;

/// A campaign that can be stored.
#[derive(Debug, Clone)]
pub struct ReadCampaign {
    /// Of an IMU a calibration, of a single gyro on a bench a bench test.
    pub submission: Submission,
    /// What its answer is made of.
    pub fit: CampaignFit,
    /// As it is kept: JSON, whichever form it came in.
    pub body: Arc<str>,
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
