//! Fleets with a hidden cause, sent as records to a service and asked of it: a few of each kind.

use crate::command;

#[test]
fn hidden_causes_are_found_through_the_real_ingest() {
    let report = command::answer(&["blindcheck", "history", "--count", "4", "--seed", "2026"]);
    assert_eq!(report["fleets"], 80);
    let figure = |what: &str| {
        let rows = report["rows"].as_array().unwrap();
        let row = rows.iter().find(|row| row["what"] == what).unwrap_or_else(|| panic!("no row {what}: {report}"));
        let [hits, trials] = ["hits", "trials"].map(|key| row["tally"][key].as_f64().unwrap());
        (hits / trials, trials)
    };
    let (right, kinds) = report["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["what"].as_str().unwrap().starts_with("right: ") && row["what"] != "right: wanders")
        .fold((0.0, 0.0), |(hits, trials), row| {
            (hits + row["tally"]["hits"].as_f64().unwrap(), trials + row["tally"]["trials"].as_f64().unwrap())
        });
    assert_eq!(kinds, 76.0);
    assert!(right >= 0.93 * kinds, "{report}");
    assert!(figure("false names").0 <= 0.01, "{report}");
    assert_eq!(figure("the station's doing blamed on the gyro").0, 0.0, "{report}");
    assert!(figure("closure covered").0 >= 0.85, "{report}");
    let (in_time, asked) = figure("calibrated in time");
    assert!(asked >= 6.0 && in_time >= 0.8, "{report}");
}
