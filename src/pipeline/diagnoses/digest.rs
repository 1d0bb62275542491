//! What a summary of many diagnoses says of each.

use serde::{Deserialize, Serialize};

use crate::core::campaign::Campaign;
use crate::core::message::Message;
use crate::store::{DigestRow, StoreError};
use crate::wire::body::{ToBody, bodies};
use crate::wire::diagnosis::{DiagnosisBody, EffectBody, ImpactBody, SignBody};
use crate::wire::forecast::{ComparedBody, ForecastPointBody, LargestForecastError};

/// The verdict of a campaign that leaves nothing to diagnose.
pub(super) const REFUSED: &str = "refused";

/// What was concluded of a campaign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conclusion {
    /// As the diagnosis names it, or `refused`.
    pub verdict: String,
    pub effects: Vec<String>,
}

/// Verdict, gyros and effects of one diagnosis, as they are kept beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Digest {
    /// As the diagnosis names it, or [`REFUSED`].
    pub verdict: String,
    /// All of the campaign.
    pub gyros: Vec<MountedGyro>,
    pub effects: Vec<NamedDigest>,
    pub impact: Vec<ShiftDigest>,
    pub signs: Vec<Sign>,
    /// Where the campaign lies outside what was foretold of it; [`OUTSIDE`] finds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside_forecast: Option<LargestForecastError>,
}

/// What only the digest of a campaign outside its forecast holds.
pub(super) const OUTSIDE: &str = "\"outside_forecast\":{";

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct MountedGyro {
    pub slot: String,
    pub serial: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct NamedDigest {
    pub effect: String,
    pub class: Vec<String>,
    /// Slots.
    pub gyros: Vec<String>,
    pub closure: f64,
}

/// Of D_I or D_S by all named effects, beyond its noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ShiftDigest {
    pub slot: String,
    pub coefficient: String,
    pub shift: f64,
    pub of_budget: f64,
}

/// That more remains than is named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Sign {
    pub kind: String,
    /// Slots.
    pub gyros: Vec<String>,
}

bodies! {
    NamedDigest of EffectBody: effect, class, gyros, closure = held_out.closure;
    ShiftDigest of ImpactBody: slot, coefficient, shift, of_budget;
    Sign of SignBody: kind, gyros;
}

pub(super) fn seats(campaign: &Campaign) -> Vec<MountedGyro> {
    let seat = |gyro: &crate::core::campaign::CampaignGyro| MountedGyro {
        slot: gyro.slot.name().to_owned(),
        serial: gyro.serial.to_string(),
    };
    campaign.gyros.iter().map(seat).collect()
}

impl Digest {
    pub fn of(gyros: Vec<MountedGyro>, diagnosed: &Result<DiagnosisBody, Message>) -> Self {
        let nothing = Self {
            verdict: REFUSED.to_owned(),
            gyros,
            effects: Vec::new(),
            impact: Vec::new(),
            signs: Vec::new(),
            outside_forecast: None,
        };
        let Ok(d) = diagnosed else { return nothing };
        Self {
            verdict: d.verdict.clone(),
            outside_forecast: d.forecast.as_ref().and_then(ForecastPointBody::outside).and_then(ComparedBody::furthest),
            effects: d.effects.to_body(),
            impact: d.impact.to_body(),
            signs: d.remaining.signs.to_body(),
            ..nothing
        }
    }

    /// As it is kept.
    pub fn of_row(row: &DigestRow) -> Result<Self, StoreError> {
        serde_json::from_str(&row.gist)
            .map_err(|error| StoreError::damaged(format_args!("the gist of diagnosis {}: {error}", row.record)))
    }

    pub fn serial(&self, slot: &str) -> Option<&str> {
        self.gyros.iter().find(|seat| seat.slot == slot).map(|seat| seat.serial.as_str())
    }
}
