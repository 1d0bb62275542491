//! A diagnosis as one HTML file that needs nothing else: no script, no font, no network. It can be mailed, printed
//! and filed with the campaign.

use maud::{DOCTYPE, PreEscaped};

use super::sections;
use crate::core::campaign::Campaign;
use crate::pages::assets::STYLE;
use crate::pages::prelude::*;
use crate::pages::reference;
use crate::pages::residuals::Setting;
use crate::wire::diagnosis::DiagnosisBody;
use crate::words::Language;

/// Whose campaign it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    pub imu: String,
    pub station: String,
    /// RFC 3339.
    pub measured_at: String,
    /// How each dwell was set.
    pub settings: Vec<Setting>,
    /// Slot and serial of each gyro.
    pub gyros: Vec<(String, String)>,
}

impl Subject {
    pub fn of(campaign: &Campaign) -> Self {
        Self {
            imu: campaign.imu.to_string(),
            station: campaign.station.to_string(),
            measured_at: time::format(campaign.measured_at),
            settings: Setting::of_all(campaign),
            gyros: campaign.gyros.iter().map(|gyro| (gyro.slot.name().to_owned(), gyro.serial.to_string())).collect(),
        }
    }
}

/// The whole report in `language`, as an HTML document.
pub fn report(subject: &Subject, diagnosis: &DiagnosisBody, language: Language) -> String {
    let t = language.text();
    let title = format!("{} · {}", t.diagnosis, subject.imu);
    let gyros: Vec<String> = subject.gyros.iter().map(|(slot, serial)| format!("{slot} {serial}")).collect();
    let against = html! {
        @if let Some(split) = &diagnosis.reference { section { h2 { (t.against) } (reference::parts(t, split)) } }
    };
    html! {
        (DOCTYPE)
        html lang=(language.tag()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE.content)) }
            }
            body { main {
                h1 { (title) }
                p.note {
                    (t.station) " " (subject.station) " · " (t.measured) " " (written(&subject.measured_at)) " · "
                    (gyros.join(", ")) " · " (subject.settings.len()) " " (t.dwells)
                }
                (sections::of(t, diagnosis, (&subject.gyros, &subject.settings), &against))
            } }
        }
    }
    .into_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::augmented::Options;
    use crate::core::diagnose::diagnose;
    use crate::wire::document;

    fn report_of(file: &str, language: Language) -> String {
        let bytes = std::fs::read(format!("tests/data/practice/{file}")).unwrap();
        let campaign = document::parse(&bytes).unwrap();
        let diagnosis = DiagnosisBody::from(&diagnose(&campaign, &Options::default()).unwrap()).said_in(language);
        let subject = Subject { imu: "IMU <7>".into(), station: "ST & Co".into(), ..Subject::of(&campaign) };
        report(&subject, &diagnosis, language)
    }

    #[test]
    fn a_report_needs_nothing_else_and_escapes_what_stations_write() {
        for language in Language::ALL {
            let page = report_of("campaign-02.json", language);
            for loader in ["<script", "src=", "http://", "https://", "@import", "url(", "href="] {
                assert!(!page.contains(loader), "{loader}");
            }
            assert!(page.contains("IMU &lt;7&gt;") && page.contains("ST &amp; Co"));
            assert!(page.contains("temperature_bias"));
            // The effect's own evidence, with its fit; and the way from the gap to the noise.
            assert!(page.contains("<polyline class=\"fit\"") && page.contains("<table class=\"ladder\""));
        }
    }

    #[test]
    fn every_dwell_of_every_gyro_is_drawn() {
        let page = report_of("campaign-02.json", Language::English);
        let pictures: Vec<&str> = page.split("<figure class=\"chart\"").skip(1).collect();
        let of_dwells = pictures.iter().filter(|picture| picture.contains(">dwell</text>"));
        let drawn: usize = of_dwells.map(|picture| picture.matches("<circle class=\"plain\"").count()).sum();
        assert_eq!(drawn, 2 * 3 * 78);
        let body = page.split("<main>").nth(1).unwrap();
        assert!(!body.contains("NaN") && !body.contains(">inf") && !body.contains("\"inf"));
    }
}
