//! Alerts as clients and hooks read them.

use std::borrow::Cow;

use super::reason::Reason;
use super::text::encoded;
use crate::core::judge::{Rule, Status};
use crate::wire::prelude::*;

/// The alert of one gyro, station, IMU or batch, coefficient and rule. Its identity lasts: when it fires again it is the same alert.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AlertBody {
    pub id: String,
    /// `station`, `imu` or `batch`, where it is about the one that is named as such; left out where it is about a gyro.
    #[serde(default = "of_gyro", skip_serializing_if = "is_of_gyro")]
    pub subject: Cow<'static, str>,
    /// Of the gyro; left out where it is about something else.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub serial: String,
    pub coefficient: Cow<'static, str>,
    pub rule: Cow<'static, str>,
    /// `firing`, `acknowledged` (firing, and somebody knows), `silenced` (firing, and told to nobody until a time),
    /// `inhibited` (firing, and explained by the alert of a station, a batch or an IMU) or `resolved`.
    pub state: Cow<'static, str>,
    /// What the gyro is by it: `confirmed`, `out_of_tolerance`, `unconfirmed`, `drifting` or `overdue`;
    /// `in_tolerance` once it is resolved. None where an earlier version wrote this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<Cow<'static, str>>,
    /// `warning`, or `critical` once a second campaign has confirmed the violation of a specification.
    pub severity: Cow<'static, str>,
    /// When the gyro began to do this: the time of the record that began it. Null where an earlier version wrote this.
    #[schema(required)]
    pub since: Option<String>,
    /// When that was found.
    pub fired_at: String,
    #[schema(required)]
    pub resolved_at: Option<String>,
    /// The last verdict.
    #[serde(flatten)]
    pub finding: AlertFindingBody,
    #[schema(required)]
    pub acknowledged: Option<AcknowledgementBody>,
    #[schema(required)]
    pub silenced: Option<SilenceBody>,
    /// The alert of the station, batch or IMU that explains it; left out where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inhibited_by: Option<String>,
}

fn of_gyro() -> Cow<'static, str> {
    AlertBody::OF_GYRO.into()
}

fn is_of_gyro(subject: &str) -> bool {
    subject == AlertBody::OF_GYRO
}

impl AlertBody {
    pub const OF_GYRO: &'static str = "gyro";
    pub const OF_STATION: &'static str = "station";
    pub const OF_IMU: &'static str = "imu";
    pub const OF_BATCH: &'static str = "batch";

    /// None where there is none, or one that this version does not know.
    pub fn status(&self) -> Option<Status> {
        Status::from_name(self.status.as_deref()?)
    }

    /// Whether its subject is a gyro.
    pub fn is_of_gyro(&self) -> bool {
        is_of_gyro(&self.subject)
    }

    /// Whether its subject is a station.
    pub fn is_of_station(&self) -> bool {
        self.subject == Self::OF_STATION
    }

    /// Whether it may stand for alerts of gyros.
    pub fn explains_others(&self) -> bool {
        Rule::from_name(&self.rule).is_some_and(Rule::explains_others)
    }

    /// Serial of the gyro, or name of the station, IMU or batch.
    pub fn name(&self) -> &str {
        match self.subject.as_ref() {
            Self::OF_STATION => self.finding.station.as_deref().unwrap_or_default(),
            Self::OF_IMU => self.finding.imu.as_deref().unwrap_or_default(),
            Self::OF_BATCH => self.finding.batch.as_deref().unwrap_or_default(),
            _ => &self.serial,
        }
    }

    /// The path of the page of what it is about; of a batch, that of its gyros.
    pub fn page(&self) -> String {
        match self.subject.as_ref() {
            Self::OF_BATCH => format!("/fleet?batch={}", encoded(self.name())),
            subject => format!("/{subject}s/{}", encoded(self.name())),
        }
    }

    /// As the database keeps it.
    pub fn kept(&self) -> String {
        kept(self, &self.finding.reason)
    }

    /// The gyro and the record that it rests on; the gyro alone, where no record has caused it (`overdue`).
    pub fn group(&self) -> String {
        match &self.finding.record {
            Some(record) => format!("{}/{record}", self.name()),
            None => self.name().to_owned(),
        }
    }
}

/// What an alert says of the verdict that it follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AlertFindingBody {
    /// The magnitude that was compared with the limit.
    #[schema(required)]
    pub value: Option<f64>,
    pub limit: f64,
    pub unit: Cow<'static, str>,
    #[schema(required)]
    pub sd: Option<f64>,
    /// Probability that the true value exceeds the limit, where `sd` is known.
    #[schema(required)]
    pub probability: Option<f64>,
    #[serde(flatten)]
    pub reason: Reason,
    /// The record that was judged, and where it came from; none for `overdue`.
    #[schema(required)]
    pub record: Option<String>,
    #[schema(required)]
    pub calibrated_at: Option<String>,
    #[schema(required)]
    pub imu: Option<String>,
    #[schema(required)]
    pub slot: Option<Cow<'static, str>>,
    #[schema(required)]
    pub station: Option<String>,
    /// Of production; only where it is about a batch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch: Option<String>,
    /// The value at which the alert of its IMU began that explains it, or did until it had grown by a whole limit since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_imu: Option<f64>,
}

impl AlertFindingBody {
    /// As the database keeps it.
    pub fn kept(&self) -> String {
        kept(self, &self.reason)
    }
}

/// What an answer says, with the codes and parameters of its reason in place of words.
fn kept(answer: &impl Serialize, reason: &Reason) -> String {
    let mut answer = serde_json::to_value(answer).expect("names, numbers and times can always be written as JSON");
    if let Value::Object(members) = &mut answer {
        members.retain(|name, _| name != "code" && name != "parameters");
        members.insert("reason".to_owned(), reason.kept());
    }
    answer.to_string()
}

/// No more repeats.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct AcknowledgementBody {
    pub by: String,
    pub reason: String,
    pub at: String,
}

/// Nothing is told before `until`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct SilenceBody {
    /// The silence of many alerts (`/v1/silences`) that holds for this one; null where it is a silence of this alert
    /// alone.
    #[schema(required)]
    pub silence: Option<String>,
    pub by: String,
    pub reason: String,
    pub at: String,
    pub until: String,
}
