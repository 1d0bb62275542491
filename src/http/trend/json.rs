//! A trend as JSON with a list for each member of its points, in the order in which they are asked for.

use serde::{Serialize, Serializer};
use serde_json::value::{RawValue, to_raw_value};

use super::body::{LEVELS, LevelColumn, Point, PointColumn, Trend};
use crate::http::events::EventBody;
use crate::wire::time;

#[derive(Serialize)]
struct Lists<'a> {
    serial: &'a str,
    coefficient: &'static str,
    unit: &'static str,
    #[serde(serialize_with = "in_order")]
    columns: Vec<(&'static str, Box<RawValue>)>,
    events: &'a [EventBody],
    next: &'a Option<String>,
}

/// The points as one list per member.
pub(super) fn columns(trend: &Trend<'_>, of: &[PointColumn], with_levels: bool) -> serde_json::Result<Vec<u8>> {
    let &Trend { serial, coefficient, unit, ref points, events, ref next } = trend;
    let member = |column: &PointColumn| {
        let list = match column {
            PointColumn::CalibratedAt => list(points, |point| time::format(point.calibrated_at)),
            PointColumn::Value => list(points, |point| point.value),
            PointColumn::Sd => list(points, |point| point.sd),
            PointColumn::Method => list(points, |point| point.method),
            PointColumn::Imu => list(points, |point| point.imu),
            PointColumn::Slot => list(points, |point| point.slot),
            PointColumn::Station => list(points, |point| point.station),
            PointColumn::Record => list(points, |point| point.record.to_string()),
            PointColumn::State => list(points, |point| point.state),
            PointColumn::Status => list(points, |point| point.status),
        };
        Ok((column.name(), list?))
    };
    let level = |(name, figure): &LevelColumn| Ok((*name, list(points, |point| point.level.and_then(figure))?));
    let levels = if with_levels { &LEVELS[..] } else { &[] };
    let columns = of.iter().map(member).chain(levels.iter().map(level)).collect::<serde_json::Result<_>>()?;
    serde_json::to_vec(&Lists { serial, coefficient, unit, columns, events, next })
}

fn list<'a, T: Serialize>(points: &[Point<'a>], of: impl Fn(&Point<'a>) -> T) -> serde_json::Result<Box<RawValue>> {
    to_raw_value(&points.iter().map(of).collect::<Vec<_>>())
}

fn in_order<S: Serializer>(columns: &[(&'static str, Box<RawValue>)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(columns.iter().map(|(name, list)| (name, list)))
}
