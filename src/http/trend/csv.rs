//! A trend as CSV.

use super::body::Trend;
use crate::wire::time::Stamp;

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
/// asked for, `status` always last.
pub(super) fn written(trend: &Trend<'_>, with_voided: bool) -> Option<Vec<u8>> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS.into_iter().chain(with_voided.then_some("voided")).chain(["status"])).ok()?;
    for point in &trend.points {
        let (at, value) = (Stamp::of(point.calibrated_at), point.value.to_string());
        let sd = point.sd.map(|sd| sd.to_string()).unwrap_or_default();
        let (imu, slot) = (point.imu.unwrap_or_default(), point.slot.unwrap_or_default());
        let (record, state) = (point.record.to_string(), point.state.unwrap_or_default());
        let head = [trend.serial, trend.coefficient, trend.unit, at.as_str(), &value, &sd, point.method];
        let voided = point.voided.map(|voided| if voided { "true" } else { "false" });
        let tail = [imu, slot, point.station, &record, state];
        writer
            .write_record(head.into_iter().chain(tail).chain(voided).chain([point.status.unwrap_or_default()]))
            .ok()?;
    }
    writer.into_inner().ok()
}
