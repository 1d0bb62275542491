use super::*;
use crate::core::time::UtcMicros;

const DAY_0: i64 = 1_767_225_600_000_000; // 2026-01-01T00:00:00Z

fn day(n: f64) -> UtcMicros {
    UtcMicros(DAY_0).plus_days(n)
}

/// D_I as given, D_S constant, D_O zero.
fn samples(sd: Option<f64>, points: &[(f64, f64)]) -> Vec<Sample> {
    let fixed = |value| Measured { value, sd };
    points.iter().map(|&(at, d_i)| Sample { at: day(at), d: [fixed(d_i), fixed(5.0), fixed(0.0)] }).collect()
}

fn verdict(samples: &[Sample], marks: &[Mark], k: usize, rule: Rule, limits: &Limits) -> Verdict {
    let since = baseline_since(marks, samples[k].at);
    let baseline: Vec<Sample> =
        samples.iter().filter(|s| since.is_none_or(|t| s.at >= t)).take(BASELINE_RECORDS).copied().collect();
    let history = History { samples, baseline: &baseline, marks };
    let mut verdicts = Vec::new();
    judge(&history, k, limits, &mut verdicts);
    *verdicts.iter().find(|v| v.rule == rule && v.coefficient == Coefficient::DI).expect("the rule has a limit")
}

fn latest(points: &[(f64, f64)], rule: Rule) -> Verdict {
    verdict(&samples(None, points), &[], points.len() - 1, rule, &Limits::default())
}

#[test]
fn a_step_beyond_the_budget_is_exceeded_and_names_both_values() {
    let v = latest(&[(0.0, 3.0), (14.0, 3.0123)], Rule::Step);
    assert_eq!(v.state, State::Exceeded);
    assert!((v.value.unwrap() - 0.0123).abs() < 1e-12);
    assert_eq!(
        v.reason(),
        "D_I changed by +0.01230 from 3.00000 on 2026-01-01 to 3.01230; the limit is 0.01000 deg/(h g0). \
         No standard deviation is known: the figures are compared as they stand."
    );
    assert_eq!(latest(&[(0.0, 3.0), (14.0, 2.9901)], Rule::Step).state, State::Within);
    assert_eq!(latest(&[(0.0, 3.0), (14.0, 2.9877)], Rule::Step).state, State::Exceeded);
}

#[test]
fn one_record_alone_is_too_few() {
    for rule in [Rule::Step, Rule::Range, Rule::Baseline] {
        let v = latest(&[(0.0, 3.0)], rule);
        assert_eq!((v.state, v.value, v.probability), (State::Indeterminate, None, None));
    }
}

#[test]
fn an_uncertainty_that_straddles_the_budget_is_indeterminate_with_its_probability() {
    let points = samples(Some(0.0004), &[(0.0, 3.0), (1.0, 3.0103)]);
    let v = verdict(&points, &[], 1, Rule::Step, &Limits::default());
    assert_eq!(v.state, State::Indeterminate);
    // z = 0.0003/(0.0004 sqrt 2) = 0.53033; the normal table gives 0.7020.
    assert!((v.probability.unwrap() - 0.7020).abs() < 1e-4);
    assert!((v.sd.unwrap() - 5.656_854e-4).abs() < 1e-9);
}

#[test]
fn the_range_is_over_thirty_days_and_needs_three_records() {
    let v = latest(&[(0.0, 3.0), (31.0, 3.011), (40.0, 3.012), (60.0, 3.013)], Rule::Range);
    assert_eq!(v.state, State::Within);
    assert!((v.value.unwrap() - 0.002).abs() < 1e-12, "the record of day 0 is out of the window");
    assert_eq!(latest(&[(0.0, 3.0), (31.0, 3.011), (60.0, 3.02)], Rule::Range).state, State::Indeterminate);
    assert_eq!(latest(&[(0.0, 3.0), (15.0, 3.004), (30.0, 3.0101)], Rule::Range).state, State::Exceeded);
}

#[test]
fn a_range_that_one_record_explains_is_not_confirmed() {
    let outlier = latest(&[(0.0, 3.0), (5.0, 3.001), (10.0, 3.02), (15.0, 3.001)], Rule::Range);
    assert_eq!((outlier.state, outlier.confirmed), (State::Exceeded, false));
    let moved = latest(&[(0.0, 3.0), (5.0, 3.001), (10.0, 3.02), (15.0, 3.021)], Rule::Range);
    assert_eq!((moved.state, moved.confirmed), (State::Exceeded, true));
    assert_eq!(moved.severity(), Some(Severity::Critical));
}

#[test]
fn the_baseline_is_the_mean_of_the_first_three_since_the_last_mark() {
    let points = [(0.0, 3.0), (10.0, 3.003), (20.0, 3.006), (30.0, 3.014), (50.0, 3.0), (60.0, 3.0), (70.0, 3.0)];
    let v = latest(&points[..4], Rule::Baseline);
    assert_eq!(v.state, State::Exceeded);
    assert!((v.value.unwrap() - 0.011).abs() < 1e-12);
    assert_eq!(latest(&points[..3], Rule::Baseline).state, State::Indeterminate, "its own records are not judged");

    let marks = [Mark { at: day(40.0), event: Event::Repair }];
    let mut points = points.to_vec();
    points.push((80.0, 3.009));
    let after = verdict(&samples(None, &points), &marks, 7, Rule::Baseline, &Limits::default());
    assert_eq!(after.state, State::Within);
    assert!((after.value.unwrap() - 0.009).abs() < 1e-12);
}

#[test]
fn a_repair_parts_the_records_before_from_those_after() {
    let points = samples(None, &[(0.0, 3.0), (10.0, 3.5)]);
    let repaired = |event| verdict(&points, &[Mark { at: day(5.0), event }], 1, Rule::Step, &Limits::default()).state;
    assert_eq!(repaired(Event::Repair), State::Indeterminate);
    assert_eq!(repaired(Event::Transport), State::Exceeded);
    assert_eq!(repaired(Event::Reinstallation), State::Exceeded);
}

#[test]
fn a_second_campaign_confirms_a_step_and_an_outlier_is_not_confirmed() {
    let stays = latest(&[(0.0, 3.0), (10.0, 3.02), (20.0, 3.021)], Rule::Step);
    assert_eq!((stays.state, stays.confirmed), (State::Within, true));
    let returns = latest(&[(0.0, 3.0), (10.0, 3.02), (20.0, 3.001)], Rule::Step);
    assert_eq!((returns.state, returns.confirmed), (State::Exceeded, false));
}

#[test]
fn a_late_record_is_judged_in_its_place_and_those_after_it_again() {
    let need = Need::of(&Limits::default());
    let later: Vec<UtcMicros> = (1..=100).map(|n| day(f64::from(n))).collect();
    assert_eq!(need.reach(day(0.5), &later), 30);
    assert_eq!(need.reach(day(0.5), &later[..2]), 2);
}
