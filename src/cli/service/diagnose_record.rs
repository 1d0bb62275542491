//! `diagnose RECORD`: what the closure of a calibration record says, where there are no dwells to ask.

use super::settings;
use crate::cli::document::verdict;
use crate::cli::prelude::*;
use crate::core::diagnose::closures;
use crate::core::message::list;
use crate::core::record::GyroParameters;
use crate::core::separate::{separate, stated_covariance};
use crate::wire::closure::ClosureBody;
use crate::wire::record::parse_record;

pub fn run(bytes: &[u8], format: Format) -> anyhow::Result<()> {
    let record = parse_record(bytes, &settings::plausibility()?)?;
    let separated = |gyro: &GyroParameters| {
        separate(&record.geometry, gyro.slot, &gyro.e, &gyro.g, stated_covariance(gyro).as_ref())
    };
    let separations = record.gyros.iter().map(separated).collect::<Result<Vec<_>, _>>()?;
    let answer = ClosureBody::from(&closures(separations.iter().map(|s| (s.slot, s))));
    let head = said(message!(
        "terminal_calibrated_by",
        imu = record.imu.to_string(),
        station = record.station.to_string(),
        at = time::format(record.calibrated_at),
        verdict = verdict(&answer.verdict)
    ));
    format.show(&answer, || tables(&head, &answer))
}

fn tables(head: &str, answer: &ClosureBody) -> String {
    let mut rows = table_of("terminal_closure_head", 1..6);
    for gyro in &answer.located.gyros {
        let clocking =
            answer.effects.iter().flat_map(|e| &e.estimates).find(|e| e.slot == gyro.slot && e.unit == "rad");
        let impact = answer.impact.iter().find(|i| i.slot == gyro.slot);
        rows.add_row([
            gyro.slot.clone(),
            super::separate::figure(gyro.d_o, gyro.sd),
            format!("{:.0} %", 100.0 * gyro.of_budget),
            gyro.p_value.map_or("-".to_owned(), |p| format!("{p:.1e}")),
            clocking.map_or("-".to_owned(), |e| format!("{:+.4}", e.value.to_degrees())),
            impact.map_or("-".to_owned(), |i| format!("{:+.6} ({:+.6})", i.augmented, i.shift)),
        ]);
    }
    let mut text = format!("{head}\n\n{}\n{rows}\n", word("terminal_closure"));
    for effect in &answer.effects {
        let class = message!("terminal_one_class", effects = list(effect.class.iter().cloned()));
        text.push_str(&format!("\n{}\n", said(class)));
    }
    for (k, next) in answer.next_measurements.iter().enumerate() {
        text.push_str(&format!("{}. {}\n", k + 1, next.measurement));
    }
    for note in &answer.notes {
        text.push_str(&format!("\n{}", document::note(note)));
    }
    text
}
