//! What stations do beyond white, independent noise gets no wrong name. A few campaigns a kind; the figures are those
//! of `gyrowatch blindcheck --kind all`.

use gyrowatch::blindcheck::answer::Answer;
use gyrowatch::blindcheck::kind::{Kind, KindRow, row};
use gyrowatch::core::augmented::Options;
use gyrowatch::core::diagnose::diagnose;
use gyrowatch::wire;

const COUNT: usize = 14;

fn answer(text: &str) -> Result<Answer, String> {
    let campaign = wire::campaign::parse_json(text.as_bytes()).map_err(|faults| faults.to_string())?;
    let diagnosis = diagnose(&campaign, &Options::default()).map_err(|refusal| refusal.to_string())?;
    let json = serde_json::to_value(wire::diagnosis::DiagnosisBody::from(&diagnosis)).map_err(|e| e.to_string())?;
    serde_json::from_value(json).map_err(|e| e.to_string())
}

fn of(kind: &str) -> KindRow {
    let row = row(Kind::from_name(kind).unwrap(), 60_611, COUNT, &answer);
    assert_eq!(row.errors, 0, "{kind}");
    row
}

fn wrong(row: &KindRow) -> usize {
    row.confident_wrong.hits + row.doubted_wrong.hits
}

#[test]
fn noise_that_gyros_share_is_no_effect_and_is_said() {
    let row = of("shared_noise_0.95");
    assert!(wrong(&row) <= 1 && row.gap_without_a_name.hits <= 1, "{row:?}");
}

#[test]
fn standard_errors_that_do_not_follow_duration_or_time_are_no_effect() {
    for kind in ["unequal_dwells", "growing_noise"] {
        let row = of(kind);
        assert!(wrong(&row) <= 1, "{kind}: {row:?}");
    }
}

#[test]
fn a_bias_that_wanders_is_noise_with_a_memory() {
    let row = of("flicker_2");
    assert!(wrong(&row) <= 1 && row.noise_said.hits >= COUNT / 2, "{row:?}");
}

#[test]
fn an_imu_that_was_reseated_is_named_so_and_a_field_is_still_found() {
    let row = of("reseated_60");
    assert!(wrong(&row) == 0 && row.found.hits >= COUNT - 1, "{row:?}");
    let row = of("magnetic");
    assert!(row.found.hits >= COUNT - 1, "{row:?}");
}

#[test]
fn what_acts_for_a_part_of_the_time_is_not_explained_as_a_whole() {
    let row = of("third");
    assert!(row.explained_as_whole.hits <= 1 && row.confident_wrong.hits <= 1, "{row:?}");
}
