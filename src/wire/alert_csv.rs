//! Alerts as CSV (RFC 4180), one a line, times in UTC.

use super::alert::AlertBody;
use super::csv_text::csv_text;
use crate::words::asked;

/// The names of the columns.
const HEADER: &str = "id,serial,coefficient,rule,state,severity,fired_at,resolved_at,value,limit,unit,sd,probability,\
                          record,calibrated_at,imu,slot,station,acknowledged_by,acknowledged_at,silenced_by,\
                          silenced_until,reason,since,status,subject,inhibited_by,batch";

/// Alerts with the header line.
pub fn to_csv<'a>(alerts: impl IntoIterator<Item = &'a AlertBody>) -> String {
    csv_text(HEADER, alerts.into_iter().map(line))
}

fn line(alert: &AlertBody) -> [String; 28] {
    let finding = &alert.finding;
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    let [value, limit, sd, probability] =
        [finding.value, Some(finding.limit), finding.sd, finding.probability].map(number);
    let reason = finding.reason.words(asked());
    let acknowledged = alert.acknowledged.as_ref();
    let silenced = alert.silenced.as_ref();
    let cells: [Option<&str>; 28] = [
        Some(&alert.id),
        Some(&alert.serial),
        Some(&alert.coefficient),
        Some(&alert.rule),
        Some(&alert.state),
        Some(&alert.severity),
        Some(&alert.fired_at),
        alert.resolved_at.as_deref(),
        value.as_deref(),
        limit.as_deref(),
        Some(&finding.unit),
        sd.as_deref(),
        probability.as_deref(),
        finding.record.as_deref(),
        finding.calibrated_at.as_deref(),
        finding.imu.as_deref(),
        finding.slot.as_deref(),
        finding.station.as_deref(),
        acknowledged.map(|a| a.by.as_str()),
        acknowledged.map(|a| a.at.as_str()),
        silenced.map(|s| s.by.as_str()),
        silenced.map(|s| s.until.as_str()),
        Some(&reason),
        alert.since.as_deref(),
        alert.status.as_deref(),
        Some(&alert.subject),
        alert.inhibited_by.as_deref(),
        finding.batch.as_deref(),
    ];
    cells.map(|cell| cell.unwrap_or_default().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::alert::{AcknowledgementBody, AlertFindingBody};

    #[test]
    fn a_line_has_a_cell_for_every_column_and_quotes_what_needs_it() {
        let alert = AlertBody {
            id: "1".into(),
            subject: AlertBody::OF_GYRO.into(),
            serial: "A,\"7\"".into(),
            coefficient: "D_I".into(),
            rule: "step".into(),
            state: "acknowledged".into(),
            status: Some("confirmed".into()),
            severity: "critical".into(),
            since: Some("2025-12-31T00:00:00Z".into()),
            fired_at: "2026-01-01T00:00:00Z".into(),
            resolved_at: None,
            finding: AlertFindingBody {
                value: Some(0.0125),
                limit: 0.01,
                unit: "deg/(h g0)".into(),
                sd: None,
                probability: None,
                reason: crate::wire::reason::Reason(vec![crate::core::message::Message::verbatim(
                    "D_I changed, and how",
                )]),
                record: Some("9".into()),
                calibrated_at: None,
                imu: Some("IMU-1".into()),
                slot: Some("G1".into()),
                station: None,
                batch: None,
                with_imu: None,
            },
            acknowledged: Some(AcknowledgementBody {
                by: "Li".into(),
                reason: "known".into(),
                at: "2026-01-02T00:00:00Z".into(),
            }),
            silenced: None,
            inhibited_by: None,
        };
        let text = to_csv([&alert]);
        let (header, line) = text.split_once('\n').unwrap();
        assert_eq!(
            line,
            "1,\"A,\"\"7\"\"\",D_I,step,acknowledged,critical,2026-01-01T00:00:00Z,,0.0125,0.01,deg/(h g0),,,9,,IMU-1,G1,,\
             Li,2026-01-02T00:00:00Z,,,\"D_I changed, and how\",2025-12-31T00:00:00Z,confirmed,gyro,,\n"
        );
        // Two commas stand within quotes.
        assert_eq!(header.matches(',').count() + 2, line.matches(',').count());
    }
}
