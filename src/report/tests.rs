use super::*;
use crate::core::augmented::Options;
use crate::core::diagnose::diagnose;
use crate::wire::document;

fn report_of(file: &str) -> String {
    let bytes = std::fs::read(format!("tests/data/practice/{file}")).unwrap();
    let campaign = document::parse(&bytes).unwrap();
    let diagnosis = DiagnosisBody::from(&diagnose(&campaign, &Options::default()).unwrap());
    let subject = Subject {
        imu: "IMU <7>".into(),
        station: "ST & Co".into(),
        measured_at: "2026-03-01T08:00:00Z".into(),
        dwells: campaign.dwells.len(),
        gyros: campaign.gyros.iter().map(|g| (g.slot.name().into(), g.serial.to_string())).collect(),
    };
    html(&subject, &diagnosis)
}

#[test]
fn a_report_needs_nothing_else_and_escapes_what_stations_write() {
    let page = report_of("campaign-02.json");
    for loader in ["<script", "src=", "http://", "https://", "@import", "url("] {
        assert!(!page.contains(loader), "{loader}");
    }
    assert!(page.contains("IMU &lt;7&gt;") && page.contains("ST &amp; Co"));
    assert!(page.contains("temperature_bias"));
}

#[test]
fn every_dwell_of_every_gyro_is_drawn() {
    let page = report_of("campaign-02.json");
    assert_eq!(page.matches("<circle").count(), 2 * 3 * 78);
    assert!(!page.contains("NaN") && !page.contains("inf"));
}

#[test]
fn figures_have_three_significant_digits() {
    let shown = [0.0, 12.345, 0.001_234_5, -0.5, 1e-7, 123_456.0].map(figure);
    assert_eq!(shown, ["0", "12.3", "0.00123", "-0.500", "1.00e-7", "1.23e5"]);
}
