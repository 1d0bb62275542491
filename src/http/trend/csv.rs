//! A trend as CSV.

use super::body::{LEVELS, LevelColumn, Trend};
use super::request::Request;
use crate::wire::time;

const COLUMNS: [&str; 12] = [
    "serial",
    "coefficient",
    "unit",
    "calibrated_at",
    "value",
    "sd",
    "method",
    "imu",
    "slot",
    "station",
    "record",
    "state",
];

/// RFC 4180: one header line, times in UTC, every point at full precision; a column more where voided points are
/// asked for, three where levels are, `status` always last.
pub(super) fn written(trend: &Trend<'_>, &Request { voided: with_voided, levels, .. }: &Request) -> Option<Vec<u8>> {
    let asked = if levels { &LEVELS[..] } else { &[] };
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let more = with_voided.then_some("voided").into_iter().chain(asked.iter().map(|(name, _)| *name)).chain(["status"]);
    writer.write_record(COLUMNS.into_iter().chain(more)).ok()?;
    for point in &trend.points {
        let (at, value) = (time::format(point.calibrated_at), point.value.to_string());
        let sd = point.sd.map(|sd| sd.to_string()).unwrap_or_default();
        let (imu, slot) = (point.imu.unwrap_or_default(), point.slot.unwrap_or_default());
        let (record, state) = (point.record.to_string(), point.state.unwrap_or_default());
        let head = [trend.serial, trend.coefficient, trend.unit, &at, &value, &sd, point.method];
        let voided = point.voided.map(|voided| if voided { "true" } else { "false" });
        let tail = [imu, slot, point.station, &record, state];
        let level = |(_, figure): &LevelColumn| point.level.and_then(figure).map(|x| x.to_string()).unwrap_or_default();
        let levels: Vec<String> = asked.iter().map(level).collect();
        let more = voided.into_iter().chain(levels.iter().map(String::as_str));
        let status = point.status.unwrap_or_default();
        writer.write_record(head.into_iter().chain(tail).chain(more).chain([status])).ok()?;
    }
    writer.into_inner().ok()
}
