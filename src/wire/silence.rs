//! Silences of many alerts as clients write and read them.

use crate::wire::prelude::*;

/// Which alerts a silence is of. Every alert has to match all that is given; at least one is.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
#[schema(min_properties = 1)]
pub struct MatchersBody {
    /// Of one gyro.
    pub serial: Option<String>,
    /// Of the gyros that were in this IMU when they were last judged.
    pub imu: Option<String>,
    /// Of the gyros that were last judged by a calibration at this station.
    pub station: Option<String>,
    /// Of one rule.
    pub rule: Option<String>,
}

/// A silence to be begun.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewSilenceBody {
    pub matchers: MatchersBody,
    /// RFC 3339; in the future.
    pub until: String,
    #[schema(min_length = 1, max_length = 64)]
    pub by: String,
    #[schema(min_length = 1, max_length = 4096)]
    pub reason: String,
}

/// A silence of every alert that matches.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct MatchingSilenceBody {
    pub id: String,
    pub matchers: MatchersBody,
    pub until: String,
    pub by: String,
    pub reason: String,
    /// When it was begun.
    pub at: String,
    /// Whether it holds now.
    pub active: bool,
    /// Who ended it before its time, why and when.
    #[schema(required)]
    pub ended: Option<EndedSilenceBody>,
}

/// Somebody has ended a silence.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct EndedSilenceBody {
    pub by: String,
    pub reason: String,
    pub at: String,
}
