//! What happens in the demo: what it tells the service, in the order of its time.

use serde_json::json;

use crate::wire::bench::BenchBody;
use crate::wire::campaign::CampaignBody;
use crate::wire::record::RecordBody;

/// What the demo tells the service, in the order of its time.
pub(super) enum Happening {
    Record(Box<RecordBody>),
    Bench(BenchBody),
    Campaign(Box<CampaignBody>),
    Repair { serial: String, at: String, reason: String },
}

impl Happening {
    /// When it happened, RFC 3339 in UTC: every instant of the demo lies on a whole second, so that texts sort as
    /// times.
    pub(super) fn at(&self) -> &str {
        match self {
            Self::Record(record) => &record.calibrated_at,
            Self::Bench(bench) => &bench.measured_at,
            Self::Campaign(campaign) => &campaign.measured_at,
            Self::Repair { at, .. } => at,
        }
    }

    pub(super) fn request(&self) -> serde_json::Result<(String, Vec<u8>)> {
        Ok(match self {
            Self::Record(record) => ("/v1/records".to_owned(), serde_json::to_vec(record)?),
            Self::Bench(bench) => ("/v1/bench-results".to_owned(), serde_json::to_vec(bench)?),
            Self::Campaign(campaign) => ("/v1/campaigns".to_owned(), serde_json::to_vec(campaign)?),
            Self::Repair { serial, at, reason } => {
                let body = json!({"event": "repair", "at": at, "reason": reason, "author": "demo"});
                (format!("/v1/gyros/{serial}/events"), serde_json::to_vec(&body)?)
            }
        })
    }
}
