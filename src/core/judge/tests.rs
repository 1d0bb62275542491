//! Each rule and how they act together. Longer than 400 lines: it is mostly tables of expected verdicts, which read best in one place.

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
    let mut verdicts = Vec::new();
    judge(&History::of(&samples.into(), &baseline, marks), k, limits, &mut verdicts);
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
fn too_few_are_counted_as_a_reader_counts_them_with_the_judged_one() {
    for (rule, first, third) in [
        (Rule::Step, "needs 2 records, 1 is there", None),
        (Rule::Range, "needs 3 records, 1 is there", None),
        (Rule::Baseline, "needs 4 records, 1 is there", Some("needs 4 records, 3 are there")),
    ] {
        let points = [(0.0, 3.0), (1.0, 3.0), (2.0, 3.0)];
        assert!(latest(&points[..1], rule).reason().contains(first), "{rule:?}");
        let reason = latest(&points, rule).reason();
        assert!(third.is_none_or(|third| reason.contains(third)), "{reason}");
    }
    // After a mark its records count alone.
    let points = samples(None, &[(0.0, 3.0), (10.0, 3.0), (20.0, 3.0), (30.0, 3.0), (50.0, 3.0)]);
    let marked = verdict(&points, &[Mark::of(day(40.0), Event::Baseline)], 4, Rule::Baseline, &Limits::default());
    assert!(marked.reason().contains("needs 4 records, 1 is there"), "{}", marked.reason());
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

    let marks = [Mark::of(day(40.0), Event::Repair)];
    let mut points = points.to_vec();
    points.push((80.0, 3.009));
    let after = verdict(&samples(None, &points), &marks, 7, Rule::Baseline, &Limits::default());
    assert_eq!(after.state, State::Within);
    assert!((after.value.unwrap() - 0.009).abs() < 1e-12);
}

#[test]
fn a_repair_parts_the_records_before_from_those_after() {
    let points = samples(None, &[(0.0, 3.0), (10.0, 3.5)]);
    let repaired = |event| verdict(&points, &[Mark::of(day(5.0), event)], 1, Rule::Step, &Limits::default()).state;
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
fn a_late_record_calls_for_the_records_after_it_to_be_judged_again() {
    let need = Need::of(&Limits::default());
    let every =
        |days: f64, count: i32| samples(None, &(1..=count).map(|n| (days * f64::from(n), 3.0)).collect::<Vec<_>>());
    let daily = every(1.0, 100);
    assert_eq!(need.reach(day(0.5), &daily), 39, "as many as the longest memory");
    let hourly = every(1.0 / 24.0, 2000);
    assert_eq!(need.reach(day(0.0), &hourly), 720, "all of the range's thirty days");
    assert_eq!(need.reach(day(0.5), &daily[..2]), 2);
}

/// Deterministic scatter, about normal with unit sd: sums of four phases of irrational turns.
fn scatter(i: usize) -> f64 {
    let phase = |factor: f64| (i as f64 * factor).fract() - 0.5;
    (phase(0.618_034) + phase(0.414_214) + phase(0.732_051) + phase(0.236_068)) * 3.0_f64.sqrt()
}

fn series(n: usize, value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    (0..n).map(|i| (14.0 * i as f64, value(i))).collect()
}

#[test]
fn a_ramp_is_told_with_its_slope_and_the_date_at_which_the_budget_is_reached() {
    // 0.0002 a fortnight and no scatter to speak of: 0.0052178 a year. Record 20 lies 0.0038 from the baseline (mean of
    // records 0 to 2, that is record 1); the remaining 0.0062 take 31 fortnights, 434 days, from day 280.
    let ramp = series(21, |i| 3.0 + 2e-4 * i as f64 + 1e-8 * scatter(i));
    let v = latest(&ramp, Rule::Trend);
    let Finding::Trend { per_day, deviation, reach, .. } = v.finding else { panic!("{v:?}") };
    assert!((per_day[1] * 14.0 - 2e-4).abs() < 1e-8 && per_day[0] <= per_day[1] && per_day[1] <= per_day[2]);
    assert!((deviation - 0.0038).abs() < 1e-6);
    assert!(reach[1].days_since(day(280.0 + 434.0)).abs() < 0.5, "{}", reach[1].date());
    assert_eq!(v.state, State::Within, "beyond the horizon of 90 days");
    assert!((v.value.unwrap() - (0.0038 + 2e-4 * 90.0 / 14.0)).abs() < 1e-6);
    let said = format!("to {}, when it lay +0.00380 from its baseline; carried on", day(280.0).date());
    let ahead = format!("it would reach the budget about {} (", reach[1].date());
    assert!(v.reason().contains(&said) && v.reason().contains(&ahead), "{}", v.reason());

    let later = latest(&series(47, |i| 3.0 + 2e-4 * i as f64 + 1e-8 * scatter(i)), Rule::Trend);
    assert_eq!(later.state, State::Exceeded, "the budget is reached within the horizon");
    assert_eq!(later.severity(), Some(Severity::Warning));
    assert!(later.reason().contains("D_I drifts by +0.00522 a year"), "{}", later.reason());

    let beyond = latest(&series(60, |i| 3.0 + 2e-4 * i as f64 + 1e-8 * scatter(i)), Rule::Trend).reason();
    assert!(beyond.contains("it has passed the budget") && !beyond.contains("reach the budget"), "{beyond}");
}

#[test]
fn a_step_is_no_trend_and_scatter_is_none_either() {
    let step = latest(&series(24, |i| 3.0 + if i < 12 { 0.0 } else { 0.02 } + 5e-4 * scatter(i)), Rule::Trend);
    assert_eq!(step.state, State::Within);
    assert!(matches!(step.finding, Finding::NoTrend { step: Some(at), .. } if at == day(14.0 * 12.0)), "{step:?}");
    let still = latest(&series(24, |i| 3.0 + 3e-3 * scatter(i)), Rule::Trend);
    assert!(matches!(still.finding, Finding::NoTrend { step: None, .. }), "{still:?}");
}

#[test]
fn a_trend_over_days_does_not_foretell_a_quarter() {
    let days: Vec<(f64, f64)> = (0..10).map(|i| (f64::from(i), 3.0 + 5e-4 * f64::from(i))).collect();
    let v = latest(&days, Rule::Trend);
    let Finding::Trend { horizon_days, .. } = v.finding else { panic!("{v:?}") };
    assert!((horizon_days - 9.0).abs() < 1e-9);
}

#[test]
fn a_lasting_shift_below_the_budget_is_found_by_cusum_and_by_no_specification() {
    let shifted = series(30, |i| 3.0 + 1e-3 * scatter(i) + if i < 15 { 0.0 } else { 0.0025 });
    let v = latest(&shifted, Rule::Cusum);
    assert_eq!(v.state, State::Exceeded);
    assert!(matches!(v.finding, Finding::Cusum { upward: true, .. }));
    assert_eq!(v.severity(), Some(Severity::Warning));
    assert_eq!(latest(&shifted, Rule::Baseline).state, State::Within);
    assert_eq!(latest(&series(30, |i| 3.0 + 1e-3 * scatter(i)), Rule::Cusum).state, State::Within);
}

#[test]
fn one_wild_record_does_not_raise_the_cumulative_sum() {
    let wild = latest(&series(30, |i| 3.0 + 1e-3 * scatter(i) + if i == 29 { 0.5 } else { 0.0 }), Rule::Cusum);
    assert_eq!(wild.state, State::Within, "{}", wild.reason());
}

#[test]
fn a_shift_that_does_not_matter_raises_nothing() {
    // Ten of its own standard deviations, and a hundredth of the budget.
    let tiny = latest(&series(30, |i| 3.0 + 1e-5 * scatter(i) + if i < 15 { 0.0 } else { 1e-4 }), Rule::Cusum);
    assert_eq!(tiny.state, State::Within, "{}", tiny.reason());
}

#[test]
fn the_rms_of_successive_differences_is_over_eleven_records_and_knows_what_noise_explains() {
    // +-0.003 by turns: every difference is 0.006.
    let restless = series(11, |i| 3.0 + if i % 2 == 0 { 3e-3 } else { -3e-3 });
    let v = latest(&restless, Rule::RmsSuccessive);
    assert_eq!(v.state, State::Exceeded);
    assert!((v.value.unwrap() - 0.006).abs() < 1e-12 && (v.limit - 0.005).abs() < 1e-15);
    assert_eq!(latest(&restless[..10], Rule::RmsSuccessive).state, State::Indeterminate);
    // Campaigns of sd 0.006/sqrt 2 explain all of it.
    let noisy = samples(Some(0.004_243), &restless);
    let v = verdict(&noisy, &[], 10, Rule::RmsSuccessive, &Limits::default());
    assert_ne!(v.state, State::Exceeded);
    assert!(v.reason().contains("explain 0.006001"), "{}", v.reason());
}

#[test]
fn a_closure_that_moved_is_told_as_a_turn_of_the_mounting() {
    let mut points = samples(None, &series(5, |_| 3.0));
    // 10 arcmin about the input axis at D_S = 5: D_O moves by 5 tan(10').
    points[4].d[2].value = 5.0 * (10.0_f64 / 60.0).to_radians().tan();
    let mut verdicts = Vec::new();
    judge(&History::of(&points.clone().into(), &points[..3], &[]), 4, &Limits::default(), &mut verdicts);
    let v = verdicts.iter().find(|v| v.rule == Rule::Closure).expect("the closure has a limit");
    assert_eq!((v.coefficient, v.state), (Coefficient::DO, State::Exceeded));
    let cause = "as a turn of +10.0 arcmin about the input axis would: mounting, or an output-axis term, rather than D_I or D_S";
    assert!(v.reason().contains(cause), "{}", v.reason());
    assert!(verdicts.iter().filter(|v| v.coefficient != Coefficient::DO).all(|v| v.state != State::Exceeded));
}

#[test]
fn a_closure_within_its_limit_is_given_no_cause_and_no_turn_that_rounds_to_nothing() {
    for (moved, turn) in [(0.002, Some("as a turn of +1.4 arcmin")), (1e-5, None)] {
        let mut points = samples(Some(1e-3), &series(5, |_| 3.0));
        points[4].d[2].value = moved;
        let mut verdicts = Vec::new();
        judge(&History::of(&points.clone().into(), &points[..3], &[]), 4, &Limits::default(), &mut verdicts);
        let v = verdicts.iter().find(|v| v.rule == Rule::Closure).expect("the closure has a limit");
        assert_eq!(v.state, State::Within);
        assert!(!v.reason().contains("mounting"), "{}", v.reason());
        assert_eq!(v.reason().contains("arcmin"), turn.is_some(), "{}", v.reason());
        assert!(v.reason().contains(turn.unwrap_or_default()), "{}", v.reason());
    }
}

#[test]
fn table_5_agrees_by_its_range_column() {
    // Single-gyro test, separation, single-gyro test; range in 1e-4 deg/(h g0).
    let table_5 = [
        ([4.193101, 4.192621, 4.192798], 4.800),
        ([5.771452, 5.771440, 5.772109], 6.690),
        ([1.584331, 1.584334, 1.584927], 5.960),
        ([6.132195, 6.131210, 6.132201], 9.910),
        ([1.686599, 1.686447, 1.6865143], 1.520),
        ([-9.977666, -9.976657, -9.976365], 13.010),
    ];
    let bench = Source::Bench(crate::core::bench::BenchMethod::TorqueFeedback);
    for (values, range) in table_5 {
        let result = |(i, value)| SourcedResult {
            source: if i == 1 { Source::Separation } else { bench },
            at: day(i as f64),
            measured: Measured::exact(value),
        };
        let results: Vec<_> = values.into_iter().enumerate().map(result).collect();
        let v = agreement(Coefficient::DI, &results, None, 1e-3, 0.95);
        assert!((v.value.unwrap() * 1e4 - range).abs() < 1e-6, "{v:?}");
        assert_eq!(v.state == State::Exceeded, range > 10.0);
    }
    assert_eq!(agreement(Coefficient::DI, &[], None, 1e-3, 0.95).state, State::Indeterminate);
}

#[test]
fn tables_3_and_4_meet_their_requirements_and_what_does_not_is_named() {
    use nalgebra::Vector3;
    let tables = [
        ([0.8473, -0.6011, 1.0367], [2.4210, 4.0554, 6.5179]),
        ([0.8478, -0.6000, -1.0381], [0.8634, 4.6419, -3.4081]),
        ([0.8533, 1.2062, -0.0008], [0.9901, 1.4495, -9.9775]),
    ];
    for ((e, g), required) in tables.iter().zip(Requirement::tables_3_and_4()) {
        let verdicts = requirement(&required, &Vector3::from(*e), &Vector3::from(*g), None, None, 0.95);
        assert!(verdicts.iter().flatten().all(|v| v.state == State::Within) && verdicts.iter().all(Option::is_some));
    }
    let (required, g) = (&Requirement::tables_3_and_4()[0], Vector3::new(0.0, 0.0, -13.5));
    let e = Vector3::new(0.86, -0.7, 1.0367);
    let [Some(of_e), Some(of_g)] = requirement(required, &e, &g, None, None, 0.95) else { panic!("both are required") };
    assert_eq!((of_e.state, of_g.state), (State::Exceeded, State::Exceeded));
    assert!(of_e.reason().starts_with("E_y = -0.7000 lies outside -0.6052 to -0.5935, and so does 1 more"), "{of_e}");
    assert!(of_g.reason().starts_with("G_z = -13.50 lies outside"), "{of_g}");
    let sd = Vector3::repeat(1e-3);
    let near = Vector3::new(0.8473, -0.6050, 1.0367);
    let [Some(near), _] = requirement(required, &near, &g, Some(&sd), None, 0.95) else { panic!("E is required") };
    assert_eq!(near.state, State::Indeterminate, "{near}");
    assert_eq!(requirement(&Requirement::default(), &e, &g, None, None, 0.95), [None, None]);
}

#[test]
fn a_gyro_is_overdue_after_its_interval() {
    assert_eq!(overdue(day(0.0), day(30.0), 30.0).state, State::Within);
    let v = overdue(day(0.0), day(45.5), 30.0);
    assert_eq!(v.state, State::Exceeded);
    assert_eq!(v.reason(), "Last calibrated on 2026-01-01, 45.5 days ago; the limit is 30.00 days.");
    assert_eq!(overdue(day(9.0), day(0.0), 30.0).value, Some(0.0), "a record from the future is not minus overdue");
}

#[test]
fn events_reset_what_they_should() {
    let restarts = |event: Event| Rule::ALL.into_iter().filter(|&rule| event.resets(rule)).count();
    assert_eq!(restarts(Event::Repair), Rule::ALL.len());
    assert_eq!((restarts(Event::Transport), restarts(Event::Note)), (0, 0));
    assert!(Event::Reinstallation.resets(Rule::Closure) && !Event::Reinstallation.resets(Rule::Step));
    assert!(Event::Firmware.resets(Rule::Cusum) && !Event::Firmware.resets(Rule::Baseline));
    for event in Event::ALL {
        assert_eq!(event.resets_baseline(), event.resets(Rule::Baseline), "{event:?}");
        assert_eq!(Event::from_name(event.name()), Some(event));
    }
}

#[test]
fn every_name_is_read_back() {
    assert!(Rule::ALL.into_iter().all(|x| Rule::from_name(x.name()) == Some(x)));
    assert!(Coefficient::ALL.into_iter().all(|x| Coefficient::from_name(x.name()) == Some(x)));
    assert!(State::ALL.into_iter().all(|x| State::from_name(x.name()) == Some(x)));
    assert!(Severity::ALL.into_iter().all(|x| Severity::from_name(x.name()) == Some(x)));
}

mod properties {
    use super::*;
    use proptest::prelude::*;

    fn sample() -> impl Strategy<Value = (f64, [f64; 3], Option<f64>)> {
        (0.01..40.0, [-0.02..0.02, -0.02..0.02, -0.02..0.02], prop::option::of(0.0..0.01))
    }

    fn history_of(steps: &[(f64, [f64; 3], Option<f64>)]) -> Vec<Sample> {
        let mut at = 0.0;
        let row = |&(days, values, sd): &(f64, [f64; 3], Option<f64>)| {
            at += days;
            Sample { at: day(at), d: values.map(|value| Measured { value, sd }) }
        };
        steps.iter().map(row).collect()
    }

    fn verdicts(samples: &[Sample], all: &[Sample], marks: &[Mark], k: usize) -> Vec<Verdict> {
        let since = baseline_since(marks, samples[k].at);
        let baseline: Vec<Sample> =
            all.iter().filter(|s| since.is_none_or(|t| s.at >= t)).take(BASELINE_RECORDS).copied().collect();
        let mut verdicts = Vec::new();
        judge(&History::of(&samples.into(), &baseline, marks), k, &Limits::default(), &mut verdicts);
        verdicts
    }

    proptest! {
        #[test]
        fn what_need_asks_for_is_enough_and_what_comes_after_does_no_harm(
            steps in prop::collection::vec(sample(), 1..90),
            marks in prop::collection::vec((0.0..2000.0, prop::sample::select(Event::ALL.to_vec())), 0..4),
            pick in 0.0..1.0,
        ) {
            let all = history_of(&steps);
            let mut marks: Vec<Mark> = marks.into_iter().map(|(at, event)| Mark::of(day(at), event)).collect();
            marks.sort_by_key(|mark| mark.at);
            let k = ((all.len() as f64 * pick) as usize).min(all.len() - 1);
            let need = Need::of(&Limits::default());
            let by_days = all.partition_point(|s| all[k].at.days_since(s.at) > need.days);
            let start = by_days.min(k.saturating_sub(need.records));
            prop_assert_eq!(verdicts(&all, &all, &marks, k), verdicts(&all[start..=k], &all, &marks, k - start));
        }

        #[test]
        fn no_history_makes_it_panic_or_answer_what_is_not_finite(
            steps in prop::collection::vec(
                (0.0..4000.0, prop::array::uniform3(-1e100..1e100f64), prop::option::of(0.0..1e100)), 1..60)
        ) {
            let all = history_of(&steps);
            for v in verdicts(&all, &all, &[], all.len() - 1) {
                let figures = [v.value, v.sd, v.probability];
                prop_assert!(figures.into_iter().flatten().all(f64::is_finite), "{v:?}");
                prop_assert!(!v.reason().is_empty());
            }
        }

        #[test]
        fn a_rule_sees_the_same_in_the_mirror(steps in prop::collection::vec(sample(), 1..60)) {
            let all = history_of(&steps);
            let mut mirrored = all.clone();
            mirrored.iter_mut().flat_map(|s| &mut s.d).for_each(|m| m.value = -m.value);
            let k = all.len() - 1;
            for (a, b) in verdicts(&all, &all, &[], k).iter().zip(verdicts(&mirrored, &mirrored, &[], k)) {
                prop_assert_eq!((a.rule, a.state, a.confirmed), (b.rule, b.state, b.confirmed));
                prop_assert_eq!(a.value.map(|v| (v * 1e12).round()), b.value.map(|v| (v * 1e12).round()));
            }
        }
    }
}
