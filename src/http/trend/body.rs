//! A trend, and a point of it, as they are answered.

use serde::Serializer;

use crate::core::named::named;
use crate::http::events::EventBody;
use crate::http::prelude::*;
use crate::http::query::not_one_of;
use crate::pipeline::Levels;
use crate::wire::time::Stamp;

/// The history of one coefficient, oldest first.
#[derive(Serialize, ToSchema)]
pub(super) struct Trend<'a> {
    pub serial: &'a str,
    pub coefficient: &'static str,
    /// `deg/(h*g0)`.
    pub unit: &'static str,
    pub points: Vec<Point<'a>>,
    /// What was done to the gyro in the stretch that was asked for, oldest first.
    #[schema(value_type = Vec<EventBody>)]
    pub events: &'a [EventBody],
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    pub next: Option<String>,
}

/// The history of one coefficient with a list for each member of a point that `columns` asks for.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes what is written member by member")]
pub(super) struct ColumnTrend {
    serial: String,
    coefficient: String,
    unit: String,
    columns: Columns,
    events: Vec<EventBody>,
    #[schema(required)]
    next: Option<String>,
}

#[derive(ToSchema)]
#[expect(dead_code, reason = "describes what is written member by member")]
struct Columns {
    calibrated_at: Option<Vec<String>>,
    value: Option<Vec<f64>>,
    sd: Option<Vec<Option<f64>>>,
    method: Option<Vec<String>>,
    imu: Option<Vec<Option<String>>>,
    slot: Option<Vec<Option<String>>>,
    station: Option<Vec<String>>,
    record: Option<Vec<String>>,
    state: Option<Vec<Option<String>>>,
    status: Option<Vec<Option<String>>>,
    /// With `levels=include`, and `lower` and `upper` with it.
    baseline: Option<Vec<Option<f64>>>,
    lower: Option<Vec<Option<f64>>>,
    upper: Option<Vec<Option<f64>>>,
}

/// The baseline that a point is held against, and between which limits it is in tolerance (rule `baseline`).
#[derive(Serialize, ToSchema, Clone, Copy)]
pub(super) struct PointLevel {
    pub baseline: f64,
    /// Null where the rule is off, as `upper`.
    #[schema(required)]
    pub lower: Option<f64>,
    #[schema(required)]
    pub upper: Option<f64>,
}

/// A member of a [`PointLevel`] as a column.
pub(super) type LevelColumn = (&'static str, fn(PointLevel) -> Option<f64>);

pub(super) const LEVELS: [LevelColumn; 3] =
    [("baseline", |level| Some(level.baseline)), ("lower", |level| level.lower), ("upper", |level| level.upper)];

impl PointLevel {
    fn at(levels: &Levels, at: UtcMicros) -> Option<Self> {
        let baseline = levels.at(at)?;
        let limit = |side: f64| levels.budget.map(|budget| baseline + side * budget);
        Some(Self { baseline, lower: limit(-1.0), upper: limit(1.0) })
    }
}

#[derive(Serialize, ToSchema)]
pub(super) struct Point<'a> {
    #[serde(serialize_with = "stamp")]
    #[schema(value_type = String)]
    pub calibrated_at: UtcMicros,
    pub value: f64,
    #[schema(required)]
    pub sd: Option<f64>,
    pub method: &'static str,
    /// IMU and slot; null on a bench.
    #[schema(required)]
    pub imu: Option<&'a str>,
    #[schema(required)]
    pub slot: Option<&'static str>,
    pub station: &'a str,
    /// Identifier of the record, or of the bench result.
    #[serde(serialize_with = "shown")]
    #[schema(value_type = String)]
    pub record: Id,
    /// `within`, `exceeded` or `indeterminate`, as it was judged; null for what is not judged.
    #[schema(required)]
    pub state: Option<&'static str>,
    /// What the verdicts on it come to: `confirmed`, `out_of_tolerance`, `unconfirmed`, `drifting`, `borderline`,
    /// `too_uncertain`, `not_enough_data` or `in_tolerance`; null for what is not judged.
    #[schema(required)]
    pub status: Option<&'static str>,
    /// True where it does not count any more; shown where voided points are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voided: Option<bool>,
    /// Of these one that counts again when somebody confirms its time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_aside: Option<bool>,
    /// With `levels=include`, once there are enough records for a baseline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<PointLevel>,
}

impl Point<'_> {
    pub fn held_against(self, levels: Option<&Levels>) -> Self {
        Self { level: levels.and_then(|levels| PointLevel::at(levels, self.calibrated_at)), ..self }
    }
}

named! {
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PointColumn {
    CalibratedAt = "calibrated_at",
    Value = "value",
    Sd = "sd",
    Method = "method",
    Imu = "imu",
    Slot = "slot",
    Station = "station",
    Record = "record",
    State = "state",
    Status = "status",
}
}

impl PointColumn {
    /// Those of a query: names separated by commas, or `all`.
    pub fn read(asked: &str) -> Answer<Vec<Self>> {
        if asked == "all" {
            return Ok(Self::ALL.to_vec());
        }
        let known = || Self::ALL.map(Self::name).into_iter().chain(["all"]);
        let one = |name: &str| Self::from_name(name.trim()).ok_or_else(|| not_one_of("columns", known(), name));
        asked.split(',').map(one).collect()
    }
}

fn stamp<S: Serializer>(at: &UtcMicros, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&Stamp(*at))
}

fn shown<S: Serializer>(id: &Id, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(id)
}
