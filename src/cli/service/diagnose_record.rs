//! `diagnose RECORD`: what the closure of a calibration record says, where there are no dwells to ask.

use super::settings;
use crate::cli::document::{Format, table};
use crate::core::diagnose::closures;
use crate::core::separate::{separate, stated_covariance};
use crate::wire::closure::ClosureBody;
use crate::wire::record::parse_record;
use crate::wire::time;

/// Prints the diagnosis of a record.
pub fn run(bytes: &[u8], format: Format) -> anyhow::Result<()> {
    let record = parse_record(bytes, &settings::plausibility()?)?;
    let separations = record
        .gyros
        .iter()
        .map(|gyro| {
            let covariance = stated_covariance(gyro);
            separate(&record.geometry, gyro.slot, &gyro.e, &gyro.g, covariance.as_ref()).map(|s| (gyro.slot, s))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let answer = ClosureBody::from(&closures(separations.iter().map(|(slot, s)| (*slot, s))));
    let head = format!(
        "{}, calibrated by {} at {}: {}",
        record.imu,
        record.station,
        time::format(record.calibrated_at),
        answer.verdict.replace('_', " ")
    );
    format.show(&answer, || tables(&head, &answer))
}

fn tables(head: &str, answer: &ClosureBody) -> String {
    let mut rows =
        table(["gyro", "D_O, deg/(h g0)", "of the budget", "p, noise alone", "clocking, deg", "D_S if clocking"], 1..6);
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
    let mut text = format!("{head}\n\nClosure: what two coefficients leave of G\n{rows}\n");
    for effect in &answer.effects {
        text.push_str(&format!("\nOne class, not to be told apart here: {}\n", effect.class.join(", ")));
    }
    for (k, next) in answer.next_measurements.iter().enumerate() {
        text.push_str(&format!("{}. {}\n", k + 1, next.measurement));
    }
    for note in &answer.notes {
        text.push_str(&format!("\nnote: {note}"));
    }
    text
}
