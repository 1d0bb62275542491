//! The answers to `GET /v1/stations` and `/v1/stations/{name}`: what each station does to every gyro that it measures.

use std::collections::BTreeMap;

use crate::core::changes::{CoursePoint, FleetStations, Shared, Spread, StationColumn, StationFigures, Unlike};
use crate::core::suspect_window::SuspectWindow;
use crate::wire::prelude::*;
use crate::wire::time;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationsBody {
    pub unit: String,
    /// The station that most offsets count from.
    #[schema(required)]
    pub against: Option<String>,
    pub stations: Vec<StationBody>,
    /// Spread of the stations' offsets; null where there is one station.
    pub reproducibility: BothBody<Option<SpreadBody>>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationBody {
    pub name: String,
    /// That count, each once for all gyros in it. Stations are compared by the newest hundred of each gyro, and of a fleet
    /// of more than 600 gyros by those of some at every station.
    pub records: usize,
    /// That it has ever calibrated.
    pub gyros: usize,
    pub imus: usize,
    /// Times of the records; null where none counts.
    #[schema(required)]
    pub first: Option<String>,
    #[schema(required)]
    pub last: Option<String>,
    /// The station that its offsets count from; left out of that one, and where no gyros lead to another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<String>,
    /// Gyros that it calibrated last and that were not calibrated in their interval.
    pub overdue: usize,
    /// When many of its gyros were off, each in a direction of its own, oldest first; left out where they never were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unlike: Vec<UnlikeBody>,
    #[serde(flatten)]
    pub coefficients: BothBody<StationColumnBody>,
    /// Windows in which what it measures does not count, oldest first; only where one station is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suspect_windows: Option<Vec<SuspectWindowBody>>,
}

/// Many gyros of a station were off from then on, and until then no more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UnlikeBody {
    pub from: String,
    /// Null where they still are.
    #[schema(required)]
    pub until: Option<String>,
    /// How many, of how many.
    pub gyros: usize,
    pub of: usize,
}

/// What was calibrated from then to then does not count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SuspectWindowBody {
    pub from: String,
    pub to: String,
    pub by: String,
    pub reason: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BothBody<T> {
    #[serde(rename = "D_I")]
    pub d_i: T,
    #[serde(rename = "D_S")]
    pub d_s: T,
}

/// One coefficient at a station, deg/(h*g0).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationColumnBody {
    /// Standard deviation of one record; null with too few.
    #[schema(required)]
    pub repeatability: Option<SpreadBody>,
    /// How much more it reads than the station that offsets count from; null of that one, and where no gyros lead from
    /// one to the other.
    #[schema(required)]
    pub offset: Option<SharedBody>,
    /// A year; null where nothing can be said.
    #[schema(required)]
    pub drift: Option<SharedBody>,
    /// Whether the drift is beyond chance, and the gyros of several IMUs share it.
    pub drifts: bool,
    /// When the drift began; left out where it is as old as the records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_since: Option<String>,
    /// Re-levellings and the like that were found, oldest first.
    pub steps: Vec<StationStepBody>,
    /// Times for which it was off, oldest first.
    #[serde(default)]
    pub windows: Vec<StationWindowBody>,
    /// What single gyros show beyond the common offset: gyro x station; null with too few.
    #[schema(required)]
    pub gyro_by_station: Option<SpreadBody>,
    /// What its gyros read about their own levels, oldest first.
    pub course: Vec<CoursePointBody>,
}

/// A standard deviation with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SpreadBody {
    pub sd: f64,
    pub interval: [f64; 2],
}

/// What the gyros share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SharedBody {
    pub value: f64,
    pub sd: f64,
    /// From so many gyros of so many IMUs.
    pub gyros: usize,
    pub imus: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationStepBody {
    pub at: String,
    #[serde(flatten)]
    pub size: SharedBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationWindowBody {
    /// Its first record that is off, and the first after it that is not.
    pub from: String,
    pub until: String,
    #[serde(flatten)]
    pub size: SharedBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CoursePointBody {
    pub at: String,
    pub value: f64,
    pub sd: f64,
    pub records: usize,
}

impl StationsBody {
    /// `overdue`: of each station, gyros that are.
    pub fn of(found: Option<&FleetStations>, overdue: &BTreeMap<String, usize>) -> Self {
        let of_station = |figures: &StationFigures| StationBody::of(figures, overdue);
        let spread = |column: usize| found.and_then(|found| found.reproducibility[column]).to_body();
        Self {
            unit: "deg/(h*g0)".to_owned(),
            against: found.map(|found| found.against.to_string()),
            stations: found.map_or_else(Vec::new, |found| found.stations.iter().map(of_station).collect()),
            reproducibility: BothBody { d_i: spread(0), d_s: spread(1) },
        }
    }
}

impl StationBody {
    /// A station's figures as answers write them; `overdue` counts gyros by station.
    pub fn of(figures: &StationFigures, overdue: &BTreeMap<String, usize>) -> Self {
        let [d_i, d_s] = [0, 1].map(|column| StationColumnBody::from(&figures.columns[column]));
        Self {
            name: figures.name.to_string(),
            records: figures.records,
            gyros: figures.gyros,
            imus: figures.imus,
            first: Some(time::format(figures.first)),
            last: Some(time::format(figures.last)),
            against: figures.against.as_ref().map(ToString::to_string),
            overdue: overdue.get(&*figures.name).copied().unwrap_or_default(),
            unlike: figures.unlike.to_body(),
            coefficients: BothBody { d_i, d_s },
            suspect_windows: None,
        }
    }

    /// Of a station of which no record counts.
    pub fn of_none(name: String) -> Self {
        Self { name, ..Self::default() }
    }
}

bodies! {
    StationColumnBody of StationColumn: repeatability, offset, drift, drifts, drift_since, steps, windows, gyro_by_station = by_gyro,
        course;
    SpreadBody of Spread: sd, interval;
    UnlikeBody of Unlike: from, until, gyros, of;
    SuspectWindowBody of SuspectWindow: from = span.from, to = span.to, by = author, reason;
    SharedBody of Shared: value, sd, gyros, imus;
    CoursePointBody of CoursePoint: at, value, sd, records;
    StationStepBody of (UtcMicros, Shared): at = 0, size = 1;
    StationWindowBody of ([UtcMicros; 2], Shared): from: |(at, _)| at[0].to_body(), until: |(at, _)| at[1].to_body(),
        size = 1;
}
