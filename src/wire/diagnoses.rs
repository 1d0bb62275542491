//! Diagnoses of many campaigns: what is ordered, how far it has come, and what they say together.

use crate::wire::prelude::*;

/// Which stored campaigns are to be diagnosed; without any member, all that count.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WhichBody {
    /// Those of this IMU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<String>,
    /// Those measured at this station.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// Those measured from this time on: a day (UTC) or an RFC 3339 time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub since: Option<String>,
    /// Those measured up to this time: a day (UTC) or an RFC 3339 time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<String>,
    /// Also those whose diagnosis is of this version of the program and the model in force.
    pub again: bool,
}

/// An order and its progress.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct JobBody {
    pub id: String,
    /// `waiting`, `running`, `done` or `canceled`.
    pub state: String,
    pub asked: WhichBody,
    /// Name of the token that ordered it.
    pub asked_by: String,
    pub asked_at: String,
    /// When the first of its campaigns was taken up.
    #[schema(required)]
    pub begun_at: Option<String>,
    #[schema(required)]
    pub ended_at: Option<String>,
    pub counts: CountsBody,
}

/// How far an order has come, in campaigns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CountsBody {
    pub campaigns: u64,
    pub waiting: u64,
    pub done: u64,
    pub failed: u64,
    pub canceled: u64,
}

/// Orders, newest first.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct JobsBody {
    pub diagnoses: Vec<JobBody>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    pub next: Option<String>,
}

/// An order with what failed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct JobDetailBody {
    #[serde(flatten)]
    pub job: JobBody,
    /// In the order in which they were stored.
    pub failures: Vec<FailureBody>,
    /// Cursor of the next failures; null on the last page.
    #[schema(required)]
    pub next: Option<String>,
}

/// A campaign that could not be diagnosed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct FailureBody {
    pub campaign: String,
    pub imu: String,
    pub measured_at: String,
    pub reason: String,
}

/// What the diagnoses of many campaigns say together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SummaryBody {
    pub campaigns: CoverageBody,
    /// Each named effect, the one in most IMUs first.
    pub effects: Vec<OverviewBody>,
    /// Each named effect in each gyro that has it.
    pub findings: Vec<FindingBody>,
    /// IMUs whose gap the catalogue does not explain, or not wholly.
    pub doubts: Vec<DoubtBody>,
    /// Campaigns that lie outside what the model in force before them foretold, by IMU, oldest first. Left out where an
    /// effect is asked for.
    #[serde(default)]
    pub outside_forecast: Vec<OutsideForecastBody>,
}

/// A campaign that the rule `forecast` finds outside what was foretold, and the gyro that is furthest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OutsideForecastBody {
    pub imu: String,
    pub campaign: SightingBody,
    /// Empty where an earlier version made the diagnosis.
    pub slot: String,
    pub rms_over_sd: f64,
    /// Of errors as large, over all gyros.
    pub p_value: f64,
}

/// How many campaigns the summary rests on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CoverageBody {
    pub diagnosed: u64,
    pub no_gap: u64,
    pub explained: u64,
    pub partly_explained: u64,
    pub unexplained: u64,
    /// They leave nothing to diagnose.
    pub refused: u64,
    /// Not diagnosed yet.
    pub waiting: u64,
    /// Of those diagnosed, by another version of the program.
    pub outdated: u64,
}

/// One effect over all IMUs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OverviewBody {
    /// Catalogue name.
    pub effect: String,
    pub imus: Vec<String>,
    pub stations: Vec<String>,
    pub gyros: u64,
    /// With the effect in any gyro.
    pub campaigns: u64,
    pub first_at: String,
    pub last_at: String,
}

/// One effect in one gyro of one IMU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FindingBody {
    /// Catalogue name.
    pub effect: String,
    /// What none of its campaigns could tell it from, itself included.
    pub class: Vec<String>,
    pub imu: String,
    pub slot: String,
    pub serial: String,
    pub stations: Vec<AtStationBody>,
    /// In how many campaigns of the gyro it was named.
    pub campaigns: u64,
    /// Of how many that were diagnosed.
    pub of: u64,
    /// Of how many from the first one on.
    pub of_since: u64,
    /// The last campaign of the gyro before the first one with the effect; null where there is none.
    #[schema(required)]
    pub clear_at: Option<String>,
    pub first: SightingBody,
    pub last: SightingBody,
    pub closure: ClosuresBody,
    /// Where the named effects of a campaign move D_I or D_S beyond their noise: the largest shift of each.
    pub impact: Vec<LargestShiftBody>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct AtStationBody {
    pub station: String,
    /// With the effect.
    pub campaigns: u64,
    /// Of the gyro there.
    pub of: u64,
}

/// A campaign in which it was seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct SightingBody {
    pub campaign: String,
    pub measured_at: String,
    pub station: String,
}

/// How far the gap closes on held-out dwells once the effect is in the model, over the campaigns that name it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosuresBody {
    pub least: f64,
    pub median: f64,
    pub greatest: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LargestShiftBody {
    /// `D_I` or `D_S`.
    pub coefficient: String,
    /// Of all named effects of that campaign together, deg/(h*g0).
    pub shift: f64,
    pub of_budget: f64,
    pub campaign: String,
}

/// A gap of an IMU that the catalogue does not explain, or not wholly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DoubtBody {
    /// `unexplained` or `partly_explained`.
    pub verdict: String,
    pub imu: String,
    /// In which something shows that more remains.
    pub gyros: Vec<String>,
    /// What shows it, as the diagnoses name it.
    pub signs: Vec<String>,
    pub stations: Vec<String>,
    pub campaigns: u64,
    /// Of how many of the IMU that were diagnosed.
    pub of: u64,
    pub first: SightingBody,
    pub last: SightingBody,
}
