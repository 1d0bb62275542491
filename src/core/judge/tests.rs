//! Each rule and how they act together. Longer than 400 lines: it is mostly tables of expected verdicts, which read
//! best in one place.

use super::limits::Requirement;
use super::*;
use crate::core::time::UtcMicros;

const DAY_0: i64 = 1_767_225_600_000_000; // 2026-01-01T00:00:00Z

fn day(n: f64) -> UtcMicros {
    UtcMicros(DAY_0).plus_days(n)
}

/// D_I as given, D_S and D_O constant.
fn samples(sd: Option<f64>, points: &[(f64, f64)]) -> Vec<Sample> {
    let fixed = |value| Measured { value, sd };
    let d = |d_i| [fixed(d_i), fixed(5.0), fixed(0.0)];
    points.iter().map(|&(at, d_i)| Sample { at: day(at), seat: Seat::default(), station: 0, d: d(d_i) }).collect()
}

/// The records as they were measured at these stations, by their places.
fn at_stations(mut samples: Vec<Sample>, station: impl Fn(usize) -> u32) -> Vec<Sample> {
    samples.iter_mut().enumerate().for_each(|(k, sample)| sample.station = station(k));
    samples
}

/// Without memory and walk in the noise.
fn white() -> Limits {
    Limits { noise: NoiseParameters { phi: 0.0, walk: 0.0, of_fleet: true }, ..Limits::default() }
}

fn ten_days_apart(values: &[f64]) -> Vec<(f64, f64)> {
    values.iter().enumerate().map(|(i, value)| (10.0 * i as f64, *value)).collect()
}

fn all_verdicts(samples: &[Sample], marks: &[Mark], k: usize, limits: &Limits) -> Vec<Verdict> {
    let (series, mut verdicts) = (Series::new(samples.to_vec(), marks.to_vec()), Vec::new());
    judge(&History::whole(&series, k), k, limits, &mut verdicts);
    verdicts
}

fn verdict(samples: &[Sample], marks: &[Mark], k: usize, rule: Rule, limits: &Limits) -> Verdict {
    let verdicts = all_verdicts(samples, marks, k, limits);
    *verdicts.iter().find(|v| v.rule == rule && v.coefficient == Coefficient::DI).expect("the rule has a limit")
}

fn closure(samples: &[Sample], k: usize) -> Verdict {
    let verdicts = all_verdicts(samples, &[], k, &Limits::default());
    *verdicts.iter().find(|v| v.rule == Rule::Closure).expect("the closure has a limit")
}

fn latest(points: &[(f64, f64)], rule: Rule) -> Verdict {
    verdict(&samples(None, points), &[], points.len() - 1, rule, &Limits::default())
}

#[test]
fn a_step_beyond_the_budget_is_exceeded_and_names_the_limit_and_its_key() {
    let v = latest(&[(0.0, 3.0), (14.0, 3.0123)], Rule::Step);
    assert_eq!((v.state, v.status()), (State::Exceeded, Status::Unconfirmed));
    assert!((v.value.unwrap() - 0.0123).abs() < 1e-12);
    assert_eq!(
        v.to_string(),
        "step (name: D_I, value: measured (value: 0.0123, unit: unit_drift), side: above, level: 3.0000); \
         limit_exceeded (limit: measured (value: 0.0100, unit: unit_drift), from: judging.budget, percent: 123); \
         no_standard_deviation"
    );
    assert_eq!(latest(&[(0.0, 3.0), (14.0, 2.9901)], Rule::Step).state, State::Within);
    assert_eq!(latest(&[(0.0, 3.0), (14.0, 2.9877)], Rule::Step).state, State::Exceeded);
}

/// A gyro that stands still between two stations that differ by 0.014, where stations are known to differ by as much.
#[test]
fn a_still_gyro_between_two_stations_is_neither_restless_nor_out_of_tolerance() {
    let points: Vec<(f64, f64)> = (0..12).map(|k| (7.0 * k as f64, 3.0 + 0.014 * f64::from(k % 2))).collect();
    for sd in [Some(2e-4), None] {
        let samples = at_stations(samples(sd, &points), |k| k as u32 % 2);
        let exceeded = |limits: &Limits| -> Vec<Rule> {
            let all = all_verdicts(&samples, &[], 11, limits);
            all.iter().filter(|v| v.state == State::Exceeded && v.confirmed).map(|v| v.rule).collect()
        };
        let known = Limits { between_stations: [0.01; 2], ..Limits::default() };
        assert_eq!(exceeded(&known), [], "{sd:?}");
        assert!(exceeded(&Limits::default()).contains(&Rule::Range));
        let restless = |limits| verdict(&samples, &[], 11, Rule::RmsSuccessive, limits).state;
        assert_eq!([restless(&known), restless(&Limits::default())], [State::Indeterminate, State::Exceeded]);
    }
}

#[test]
fn what_stations_differ_by_counts_where_records_of_different_stations_are_compared() {
    const BETWEEN: f64 = 1.5e-3;
    let limits = Limits { between_stations: [BETWEEN, 0.0], ..Limits::default() };
    let points = [(0.0, 3.0), (30.0, 3.0), (60.0, 3.0), (90.0, 3.0115)];
    let at_stations = |stations: [u32; 4]| at_stations(samples(Some(2e-4), &points), |k| stations[k]);
    for rule in [Rule::Step, Rule::Baseline] {
        let of = |stations, limits: &Limits| verdict(&at_stations(stations), &[], 3, rule, limits);
        let alone = of([1; 4], &Limits::default());
        assert_eq!((alone.state, alone.between), (State::Exceeded, None));
        assert_eq!(of([1; 4], &limits), alone, "one station");
        assert_eq!(of([1, 1, 1, 2], &Limits::default()), alone, "nothing is known of stations");
        // Weights of the stations: 1 and -1; 2/3, -1/3, -1/3.
        for (stations, squares) in [([1, 1, 1, 2], 2.0), ([1, 2, 3, 1], 6.0 / 9.0)] {
            let v = of(stations, &limits);
            let between = BETWEEN * f64::sqrt(squares);
            assert!((v.between.unwrap() / between - 1.0).abs() < 1e-12, "{v:?}");
            assert!((v.sd.unwrap() / alone.sd.unwrap().hypot(between) - 1.0).abs() < 1e-12, "{v:?}");
            assert_eq!(v.state, State::Indeterminate, "{v:?}");
            assert!(v.messages().iter().any(|said| said.code == "between_stations"), "{v}");
        }
    }
    // The extremes are of two stations: neither exceeded nor confirmed; of one they are.
    let of = |stations, limits: &Limits| verdict(&at_stations(stations), &[], 3, Rule::Range, limits);
    let (alone, apart) = (of([1; 4], &Limits::default()), of([1, 1, 1, 2], &limits));
    assert_eq!((alone.state, of([1; 4], &limits)), (State::Exceeded, alone));
    let between = BETWEEN * std::f64::consts::SQRT_2;
    assert!((apart.between.unwrap() / between - 1.0).abs() < 1e-12, "{apart:?}");
    assert_eq!((apart.state, apart.confirmed), (State::Indeterminate, false), "{apart:?}");
    let other = at_stations([1, 1, 1, 2]);
    let d_s = all_verdicts(&other, &[], 3, &limits);
    assert!(d_s.iter().all(|v| v.between.is_none() || v.coefficient == Coefficient::DI));
}

#[test]
fn a_step_is_measured_from_the_median_of_the_three_records_before() {
    let v = latest(&[(0.0, 9.0), (10.0, 3.004), (20.0, 3.05), (30.0, 3.0), (40.0, 3.015)], Rule::Step);
    assert!((v.value.unwrap() - 0.011).abs() < 1e-12, "3.015 - 3.004");
    // Equal standard deviations: the median of three has 0.6698 of one (order statistics), and the difference sqrt(1 + 0.4487).
    let points = samples(Some(2e-3), &[(0.0, 3.0), (10.0, 3.001), (20.0, 3.002), (30.0, 3.0)]);
    let v = verdict(&points, &[], 3, Rule::Step, &Limits::default());
    assert!((v.sd.unwrap() / (2e-3 * 1.448_671_f64.sqrt()) - 1.0).abs() < 1e-6);
}

#[test]
fn one_record_alone_is_too_few() {
    for rule in [Rule::Step, Rule::Range, Rule::Baseline, Rule::Trend, Rule::Shift, Rule::RmsSuccessive] {
        let v = latest(&[(0.0, 3.0)], rule);
        assert_eq!((v.state, v.value, v.probability), (State::Indeterminate, None, None));
        assert_eq!(v.status(), Status::NotEnoughData);
    }
}

#[test]
fn too_few_are_counted_as_a_reader_counts_them_with_the_judged_one() {
    for (rule, first, third) in [
        (Rule::Step, "need: 2, have: 1, of: records", None),
        (Rule::Range, "need: 3, have: 1, of: records", None),
        (Rule::Baseline, "need: 4, have: 1, of: records", Some("need: 4, have: 3,")),
        (Rule::Shift, "need: 8, have: 1, of: weeks", Some("have: 1,")),
    ] {
        let points = [(0.0, 3.0), (1.0, 3.0), (2.0, 3.0)];
        assert!(latest(&points[..1], rule).to_string().contains(first), "{rule:?}");
        let reason = latest(&points, rule).to_string();
        assert!(third.is_none_or(|third| reason.contains(third)), "{reason}");
    }
    // After a mark its records count alone.
    let points = samples(None, &[(0.0, 3.0), (10.0, 3.0), (20.0, 3.0), (30.0, 3.0), (50.0, 3.0)]);
    let marked = verdict(&points, &[Mark::of(day(40.0), Event::Baseline)], 4, Rule::Baseline, &Limits::default());
    assert_eq!(marked.finding, Finding::TooFew { have: 1, need: 4 });
}

#[test]
fn an_uncertainty_that_straddles_the_budget_is_indeterminate_with_its_probability() {
    let points = samples(Some(0.0004), &[(0.0, 3.0), (1.0, 3.0103)]);
    let v = verdict(&points, &[], 1, Rule::Step, &Limits::default());
    assert_eq!((v.state, v.status()), (State::Indeterminate, Status::Borderline));
    // z = 0.0003/(0.0004 sqrt 2) = 0.53033; the normal table gives 0.7020.
    assert!((v.probability.unwrap() - 0.7020).abs() < 1e-4);
    assert!((v.sd.unwrap() - 5.656_854e-4).abs() < 1e-9);
    assert!(v.to_string().ends_with("; probability_beyond (percent: = 70.2)"), "{v}");
}

#[test]
fn uncertainty_alone_exceeds_no_limit() {
    // Five records with the same figures, the last with a standard deviation of twenty budgets, and every other
    // number of records.
    for n in 2..45 {
        let mut points = samples(Some(4e-4), &series(n, |_| 3.0));
        points[n - 1].d.iter_mut().for_each(|d| d.sd = Some(0.2));
        for v in all_verdicts(&points, &[], n - 1, &Limits::default()) {
            assert_ne!(v.state, State::Exceeded, "{n}: {v}");
            let certain = matches!(v.rule, Rule::Shift | Rule::Trend | Rule::RmsSuccessive);
            assert!(certain || v.state == State::Indeterminate, "{n}: {v}");
        }
    }
    let mut points = samples(Some(4e-4), &series(5, |_| 3.0));
    points[4].d[0].sd = Some(0.2);
    let v = verdict(&points, &[], 4, Rule::Step, &Limits::default());
    assert_eq!(v.status(), Status::TooUncertain);
    assert!(v.to_string().ends_with("; too_uncertain (sd: 0.2000, limit: 0.0100)"), "{v}");
    // A certain figure inside is within.
    assert_eq!(verdict(&points, &[], 3, Rule::Step, &Limits::default()).status(), Status::InTolerance);
}

#[test]
fn one_bad_record_fires_and_the_return_resolves_and_confirms_nothing() {
    use crate::core::alert_decision::{Action, Alert, Policy, follow};
    for sd in [None, Some(3e-4)] {
        // A week apart, a fortnight, a month and a quarter, with one to forty good records before.
        for (days, before) in [(7.0, 4), (14.0, 4), (31.0, 4), (91.0, 12), (14.0, 40), (1.0, 20)] {
            let values = |i: usize| if i == before { 3.02 } else { 3.0 + 1e-5 * scatter(i) };
            let points: Vec<(f64, f64)> = (0..before + 12).map(|i| (days * i as f64, values(i))).collect();
            let points = samples(sd, &points);
            let mut alerts = std::collections::BTreeMap::<(Coefficient, Rule), Alert>::new();
            for k in 0..points.len() {
                for v in all_verdicts(&points, &[], k, &Limits::default()) {
                    let key = (v.coefficient, v.rule);
                    let now = points[k].at;
                    let decision = follow(alerts.get(&key), &v, now, now, &Policy::default());
                    alerts.extend(decision.alert.map(|alert| (key, alert)));
                    assert!(!v.confirmed, "{days} {k}: {v}");
                    assert_ne!(decision.action, Action::Escalate, "{days} {k}: {v}");
                    assert!(v.severity().is_none() || k == before, "{days} {k}: {v}");
                }
                let firing =
                    alerts.values().filter(|alert| alert.status == crate::core::alert_decision::Status::Firing).count();
                assert_eq!(firing > 0, k == before, "{days} {k}: {firing} fire");
            }
        }
    }
}

#[test]
fn the_range_is_over_thirty_days_or_the_newest_three_records() {
    let v = latest(&[(0.0, 3.0), (31.0, 3.011), (40.0, 3.012), (60.0, 3.013)], Rule::Range);
    assert_eq!(v.state, State::Within);
    assert!((v.value.unwrap() - 0.002).abs() < 1e-12, "the record of day 0 is out of the window");
    let sparse = latest(&[(0.0, 9.0), (100.0, 3.0), (190.0, 3.011), (280.0, 3.02)], Rule::Range);
    assert!((sparse.value.unwrap() - 0.02).abs() < 1e-12, "three records a quarter apart, and not the one before");
    assert_eq!(sparse.state, State::Exceeded);
    assert_eq!(latest(&[(0.0, 3.0), (90.0, 3.02)], Rule::Range).status(), Status::NotEnoughData);
    assert_eq!(latest(&[(0.0, 3.0), (15.0, 3.004), (30.0, 3.0101)], Rule::Range).state, State::Exceeded);
}

#[test]
fn an_outlier_that_its_neighbours_contradict_is_left_out_of_the_range() {
    let at = |outlier: f64, last: f64| latest(&[(0.0, 3.0), (5.0, 3.001), (10.0, outlier), (15.0, last)], Rule::Range);
    let returned = at(3.02, 3.003);
    assert_eq!((returned.state, returned.confirmed), (State::Within, false));
    assert!((returned.value.unwrap() - 0.003).abs() < 1e-12);
    assert_eq!(at(2.98, 3.003).state, State::Within, "on the other side too");
    // While it is the newest nobody contradicts it; when the next stays there it is no outlier.
    let newest = latest(&[(0.0, 3.0), (5.0, 3.001), (10.0, 3.02)], Rule::Range);
    assert_eq!((newest.state, newest.confirmed), (State::Exceeded, false));
    let moved = at(3.02, 3.021);
    assert_eq!((moved.state, moved.confirmed, moved.status()), (State::Exceeded, true, Status::Confirmed));
    assert_eq!(moved.severity(), Some(Severity::Critical));
    assert!(moved.to_string().contains("; not_a_single_result;"), "{moved}");
    // Neighbours that do not agree with each other contradict nothing.
    assert_eq!(at(3.03, 3.015).state, State::Exceeded);
    // In the window of the last record stands the outlier alone; what contradicts it came before.
    let before = [(0.0, 3.0), (20.0, 3.0), (34.0, 3.02), (48.0, 3.0), (62.0, 3.0)];
    assert_eq!(latest(&before, Rule::Range).state, State::Within);
}

#[test]
fn more_evidence_makes_no_violation_less_certain() {
    let limits = Limits::default();
    let measured = |value, sd| Measured { value, sd: Some(sd) };
    // Two certain results disagree; a third one is worth nothing.
    let of = |(i, (value, sd)): (usize, (f64, f64))| SourcedResult {
        source: FigureSource::Separation,
        at: day(i as f64),
        measured: measured(value, sd),
    };
    let agree = |results: &[(f64, f64)]| {
        let results: Vec<_> = results.iter().copied().enumerate().map(of).collect();
        agreement(Coefficient::DI, &results, None, limits.agreement(Coefficient::DI).unwrap(), 0.95)
    };
    assert_eq!(agree(&[(3.0, 1e-4), (3.012, 1e-4)]).state, State::Exceeded);
    let with_a_third = agree(&[(3.0, 1e-4), (3.012, 1e-4), (3.02, 0.5)]);
    assert_eq!(with_a_third.state, State::Exceeded);
    assert!((with_a_third.value.unwrap() - 0.012).abs() < 1e-12, "the pair that is certain");
    // The same for a range.
    let mut points = samples(Some(1e-4), &[(0.0, 3.0), (7.0, 3.012), (14.0, 3.02)]);
    points[2].d[0].sd = Some(0.5);
    let v = verdict(&points, &[], 2, Rule::Range, &limits);
    assert_eq!(v.state, State::Exceeded, "{v}");
    // And for the figures of a record, of which all are named.
    let required = &Requirement::tables_3_and_4()[0];
    let e = nalgebra::Vector3::new(0.8900, -0.6, 1.5);
    let sd = nalgebra::Vector3::new(1e-4, 1e-4, 0.4);
    let [Some(v), _] = requirement(required, &e, &e, Some(&sd), None, 0.95) else { panic!("E is required") };
    assert_eq!(v.state, State::Exceeded, "E_x is outside for certain: {v}");
    let measured = "measured_with_sd (value: 0.890, sd: 0.0001, unit: unit_pulse_per_arcsec)";
    let outside = format!("requirement (figure: E_x, value: {measured}, place: outside, low: 0.843, high: 0.853)");
    assert!(v.to_string().starts_with(&outside), "{v}");
    assert!(v.to_string().contains("; requirement_others (figures: E_z);"), "{v}");
}

#[test]
fn the_baseline_is_the_median_of_the_first_three_since_the_last_mark() {
    let points = [(0.0, 3.0), (10.0, 9.0), (20.0, 3.006), (30.0, 3.017), (50.0, 3.0), (60.0, 3.0), (70.0, 3.0)];
    let v = latest(&points[..4], Rule::Baseline);
    assert_eq!(v.state, State::Exceeded);
    assert!((v.value.unwrap() - 0.011).abs() < 1e-12);
    assert!(v.to_string().contains("side: above, level: 3.0060, origin: level_from (since: 2026-01-01)"), "{v}");
    assert_eq!(latest(&points[..3], Rule::Baseline).state, State::Indeterminate, "its own records are not judged");

    let marks = [Mark::of(day(40.0), Event::Repair)];
    let mut points = points.to_vec();
    points.push((80.0, 3.009));
    let after = verdict(&samples(None, &points), &marks, 7, Rule::Baseline, &Limits::default());
    assert_eq!(after.state, State::Within);
    assert!((after.value.unwrap() - 0.009).abs() < 1e-12);
}

#[test]
fn a_baseline_is_confirmed_by_the_record_before_on_the_same_side_which_is_none_of_its_own() {
    let of = |values: &[f64]| {
        let v = latest(&ten_days_apart(values), Rule::Baseline);
        (v.state, v.confirmed)
    };
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.012, 3.013]), (State::Exceeded, true));
    assert_eq!(of(&[3.0, 3.0, 3.0, 2.988, 3.013]), (State::Exceeded, false), "the other side");
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.002, 3.013]), (State::Exceeded, false), "the record before lies within");
    assert_eq!(of(&[3.0, 3.0, 3.012, 3.013]), (State::Exceeded, false), "the record before makes the baseline");
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.012, 3.009]), (State::Within, false));
    // A stated level has no records of its own.
    let mut limits = Limits::default();
    limits.d_i.fixed_baseline = Some(Measured::exact(3.0));
    let v = verdict(&samples(None, &[(0.0, 3.012), (10.0, 3.013)]), &[], 1, Rule::Baseline, &limits);
    assert_eq!((v.state, v.confirmed), (State::Exceeded, true));
    assert!(v.to_string().contains("level: 3.0000, origin: level_fixed"), "{v}");
}

#[test]
fn a_level_that_the_mark_states_goes_before_all_others() {
    let stated =
        Mark { fixed: [Some(Measured { value: 3.02, sd: Some(1e-4) }), None], ..Mark::of(day(5.0), Event::Baseline) };
    let mut limits = Limits::default();
    limits.d_i.fixed_baseline = Some(Measured::exact(2.0));
    let points = samples(Some(3e-4), &[(0.0, 3.0), (10.0, 3.025)]);
    let v = verdict(&points, &[stated], 1, Rule::Baseline, &limits);
    assert!((v.value.unwrap() - 0.005).abs() < 1e-12 && (v.sd.unwrap() - 10.0_f64.sqrt() * 1e-4).abs() < 1e-12, "{v}");
    let before = verdict(&points, &[stated], 0, Rule::Baseline, &limits);
    assert!((before.value.unwrap() - 1.0).abs() < 1e-12, "the configured one holds before the mark");
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
fn a_second_campaign_on_the_same_side_confirms_a_step() {
    let of = |values: &[f64]| {
        let v = latest(&ten_days_apart(values), Rule::Step);
        (v.state, v.confirmed)
    };
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.02, 3.021]), (State::Exceeded, true));
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.02, 2.98]), (State::Exceeded, false), "the other side");
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.02, 3.001]), (State::Within, false), "back again");
    assert_eq!(of(&[3.0, 3.0, 3.0, 3.02, 3.021, 3.02]), (State::Within, false), "the level before is the new one now");
    assert_eq!(of(&[3.0, 3.02, 3.021]), (State::Exceeded, true), "of two records before, the earlier one is the level");
    assert_eq!(of(&[3.0, 3.02, 3.001]), (State::Within, false));
}

#[test]
fn a_late_record_calls_for_the_records_after_it_to_be_judged_again() {
    let need = Need::of(&Limits::default());
    let every =
        |days: f64, count: i32| samples(None, &(1..=count).map(|n| (days * f64::from(n), 3.0)).collect::<Vec<_>>());
    assert_eq!(need.records, 11, "ten after an environmental test, and the one before it");
    let daily = every(1.0, 1000);
    assert_eq!(need.reach(day(0.5), &daily), 550, "as many days as the weekly means may reach back");
    let rare = every(100.0, 30);
    assert_eq!(need.reach(day(0.5), &rare), 11, "or as many cells, and their own");
    assert_eq!(need.reach(day(0.5), &daily[..2]), 2);
}

#[test]
fn a_test_is_judged_by_the_last_record_before_and_the_first_after() {
    let test = Mark { until: Some(day(32.0)), ..Mark::of(day(22.0), Event::EnvironmentalTest) };
    let of = |values: &[f64]| {
        let points = samples(Some(2e-4), &ten_days_apart(values));
        let all = all_verdicts(&points, &[test], points.len() - 1, &Limits::default());
        all.into_iter().find(|v| v.rule == Rule::BeforeAfter && v.coefficient == Coefficient::DI)
    };
    // Days 0, 10, 20 before, 30 within, 40 the first after.
    assert_eq!(of(&[3.0, 3.1, 3.001]), None, "before the test");
    assert_eq!(of(&[3.0, 3.1, 3.001, 3.5]), None, "during the test");
    let passed = of(&[3.0, 3.1, 3.001, 3.5, 3.004]).expect("the first after is judged");
    assert_eq!((passed.state, passed.status()), (State::Within, Status::InTolerance));
    assert!((passed.value.unwrap() - 0.003).abs() < 1e-12);
    let Finding::BeforeAfter { before, from, until, .. } = passed.finding else { panic!("{passed:?}") };
    assert_eq!((before, from, until), ((day(20.0), 3.001), day(22.0), day(32.0)));
    assert_eq!(passed.to_string(), "in_tolerance");
    assert_eq!(of(&[3.0, 3.1, 3.001, 3.5, 3.004, 3.02]), None, "it has passed: what comes later is not the test's");
    let failed = of(&[3.0, 3.1, 3.001, 3.5, 3.02]).expect("a verdict");
    assert_eq!((failed.state, failed.confirmed, failed.status()), (State::Exceeded, false, Status::Unconfirmed));
    let again = of(&[3.0, 3.1, 3.001, 3.5, 3.02, 3.021]).expect("a verdict");
    assert_eq!((again.state, again.confirmed), (State::Exceeded, true));
    let other_side = of(&[3.0, 3.1, 3.001, 3.5, 3.02, 2.98]).expect("a verdict");
    assert_eq!((other_side.state, other_side.confirmed), (State::Exceeded, false));
    let returned = of(&[3.0, 3.1, 3.001, 3.5, 3.02, 3.002]).expect("a verdict");
    assert_eq!(returned.state, State::Within);
    assert_eq!(of(&[3.0, 3.1, 3.001, 3.5, 3.02, 3.002, 3.02]), None, "it had come back");
    // The record in the test is one of the twelve that are looked back over: nine after it, and the one before.
    let mut long = vec![3.0, 3.1, 3.001, 3.5];
    long.extend([3.02; 11]);
    assert!(of(&long[..14]).is_some() && of(&long).is_none());
}

#[test]
fn what_parts_a_gyro_parts_before_and_after_too() {
    let points = samples(Some(2e-4), &[(0.0, 3.0), (40.0, 3.02)]);
    let test = Mark { until: Some(day(32.0)), ..Mark::of(day(22.0), Event::EnvironmentalTest) };
    let judged = |marks: &[Mark]| {
        all_verdicts(&points, marks, 1, &Limits::default()).iter().filter(|v| v.rule == Rule::BeforeAfter).count()
    };
    assert_eq!(judged(&[test]), 2, "D_I and D_S");
    assert_eq!(judged(&[test, Mark::of(day(35.0), Event::Repair)]), 0);
    assert_eq!(judged(&[test, Mark::of(day(35.0), Event::Transport)]), 2);
    assert_eq!(judged(&[]), 0);
    assert_eq!(judged(&[Mark::of(day(22.0), Event::Transport)]), 0, "no test");
    let later = Mark { until: Some(day(90.0)), ..Mark::of(day(80.0), Event::EnvironmentalTest) };
    assert_eq!(judged(&[later]), 0, "a test to come");
}

#[test]
fn a_move_begins_a_new_level_of_the_closure_by_itself() {
    let mut points = samples(Some(2e-4), &series(12, |_| 3.0));
    for (k, sample) in points.iter_mut().enumerate().skip(4) {
        sample.seat = Seat { imu: 7, ..Seat::default() };
        sample.d[2].value = if k < 11 { 0.05 } else { 0.075 };
    }
    let closure = |k: usize| closure(&points, k);
    assert_eq!(closure(3).state, State::Within);
    for k in 4..7 {
        let v = closure(k);
        assert_eq!((v.state, v.status()), (State::Indeterminate, Status::NotEnoughData), "{k}: {v}");
        assert_eq!(v.finding, Finding::Moved { since: day(14.0 * 4.0), have: k - 3, need: 4 });
    }
    let settled = closure(7);
    assert_eq!(settled.state, State::Within);
    assert!(matches!(settled.finding, Finding::Closure { moved: true, .. }), "{settled:?}");
    assert_eq!(closure(11).state, State::Exceeded, "from the new level");
    // D_I and D_S are the gyro's own: they go on.
    let drift = all_verdicts(&points, &[], 7, &Limits::default());
    let baseline = drift.iter().find(|v| (v.rule, v.coefficient) == (Rule::Baseline, Coefficient::DI)).unwrap();
    assert!(
        matches!(baseline.finding, Finding::Baseline { since: Some(since), .. } if since == day(0.0)),
        "{baseline:?}"
    );
}

/// Deterministic scatter, about normal with unit sd: sums of four uniform numbers of a generator by Steele, Lea and
/// Flood (SplitMix64).
fn scatter(i: usize) -> f64 {
    let uniform = |k: u64| {
        let mut z = (4 * i as u64 + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64 - 0.5
    };
    (0..4).map(uniform).sum::<f64>() * 3.0_f64.sqrt()
}

fn series(n: usize, value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    (0..n).map(|i| (14.0 * i as f64, value(i))).collect()
}

#[test]
fn a_ramp_is_told_with_its_slope_and_the_dates_at_which_the_budget_is_reached() {
    // 0.0002 a fortnight: 0.0052178 a year. Record 40 lies 0.0078 from the baseline (median of records 0 to 2, that
    // is record 1); the remaining 0.0022 take 11 fortnights, 154 days, from day 560.
    let limits = white();
    let ramp = |n: usize| {
        let points = samples(None, &series(n, |i| 3.0 + 2e-4 * i as f64 + 1e-8 * scatter(i)));
        verdict(&points, &[], n - 1, Rule::Trend, &limits)
    };
    let v = ramp(41);
    let Finding::Trend { cells, per_year, deviation, reach, provisional, .. } = v.finding else { panic!("{v:?}") };
    assert_eq!((cells, provisional), (24, false));
    assert!((per_year.value * 14.0 / 365.25 - 2e-4).abs() < 1e-8);
    assert!((deviation - 0.0078).abs() < 1e-6);
    let [Some(first), Some(middle), Some(last)] = reach else { panic!("{v:?}") };
    assert!(middle.days_since(day(560.0 + 154.0)).abs() < 0.5, "{}", middle.date());
    assert!(first < middle && middle < last);
    assert!((v.value.unwrap() - (0.0078 + 2e-4 * 90.0 / 14.0)).abs() < 1e-6);
    let said = format!("trend_reaches (at: {}, first: {}, last: {})", middle.date(), first.date(), last.date());
    assert!(v.to_string().contains(&said) && !v.to_string().contains("provisional"), "{v}");
    let rate = "trend (name: D_I, rate: measured_with_sd (value: +0.0052, sd: 0.0004, unit: unit_drift), cells: 24,";
    assert!(v.to_string().starts_with(rate), "within its limit, and told all the same: {v}");
    assert_eq!(v.state, State::Within, "beyond the horizon of 90 days");
    assert_eq!(ramp(45).status(), Status::Borderline, "likely within it, and not certain");

    let later = ramp(50);
    assert_eq!((later.state, later.status()), (State::Exceeded, Status::Drifting), "{later}");
    assert_eq!(later.severity(), Some(Severity::Warning));
    let beyond = ramp(60).to_string();
    assert!(beyond.contains("; trend_passed;") && !beyond.contains("trend_reaches"), "{beyond}");
    let young = ramp(14);
    assert!(matches!(young.finding, Finding::Trend { provisional: true, .. }), "{young:?}");
    assert!(young.to_string().contains("; trend_provisional"), "{young}");
}

#[test]
fn the_standard_deviation_of_a_line_counts_level_slope_scatter_and_walk() {
    // Independent scatter, no walk, and a stated level: var(x0 + b t) = s^2 (1/n + (t - mean t)^2/Sxx), and s^2 is
    // the budget's tenth drawn to the residuals, here (5 s0^2 + 0)/(5 + 22).
    let mut limits = white();
    limits.d_i.fixed_baseline = Some(Measured { value: 3.0, sd: Some(3e-4) });
    let points = samples(None, &series(30, |i| 3.0 + 2e-4 * i as f64));
    let expected = |walk: f64, v: &Verdict| {
        let s2: f64 = (5.0 * 1e-6_f64 / 27.0).max(0.25e-6);
        let t: Vec<f64> = (0..24).map(|i| 14.0 * (f64::from(i) - 23.0) / 365.25).collect();
        let mean = t.iter().sum::<f64>() / 24.0;
        let sxx: f64 = t.iter().map(|t| (t - mean).powi(2)).sum();
        let tau = 90.0 / 365.25;
        let weight = |ti: f64| 1.0 / 24.0 + (tau - mean) * (ti - mean) / sxx;
        let scatter = s2 * t.iter().map(|ti| weight(*ti).powi(2)).sum::<f64>();
        // By the matrix: what the line sees of a walk that begins at the first cell, less the level at the newest,
        // and the walk to come.
        let mut w: Vec<f64> = t.iter().map(|ti| weight(*ti)).collect();
        w[23] -= 1.0;
        let shared = |i: usize, j: usize| (t[i].min(t[j]) - t[0]) * walk * walk;
        let seen: f64 =
            (0..24).flat_map(|i| (0..24).map(move |j| (i, j))).map(|(i, j)| w[i] * w[j] * shared(i, j)).sum();
        let all = scatter + seen + walk * walk * tau + 9e-8;
        assert!((v.sd.unwrap() / all.sqrt() - 1.0).abs() < 1e-9, "{} {}", v.sd.unwrap(), all.sqrt());
    };
    expected(0.0, &verdict(&points, &[], 29, Rule::Trend, &limits));
    limits.noise.walk = 1e-3;
    expected(1e-3, &verdict(&points, &[], 29, Rule::Trend, &limits));
}

#[test]
fn a_step_is_no_trend_and_scatter_is_none_either() {
    let limits = white();
    let trend = |n: usize, value: &dyn Fn(usize) -> f64| {
        let points = samples(None, &series(n, value));
        verdict(&points, &[], n - 1, Rule::Trend, &limits)
    };
    let step = trend(24, &|i| 3.0 + if i < 12 { 0.0 } else { 0.02 } + 5e-4 * scatter(i));
    assert_eq!(step.state, State::Within);
    assert!(matches!(step.finding, Finding::NoTrend { step: Some(at), .. } if at == day(14.0 * 12.0)), "{step:?}");
    assert_eq!(step.to_string(), "no_trend_but_step");
    assert!((step.value.unwrap() - 0.025).abs() < 2e-3, "the line's end, off the baseline: {step}");
    let still = trend(24, &|i| 3.0 + 3e-3 * scatter(i));
    assert!(matches!(still.finding, Finding::NoTrend { step: None, .. }), "{still:?}");
    // A course that bends within the shortest window is no line: the last deviation is shown.
    let bent = trend(24, &|i| 3.0 + 2e-3 * (i as f64 - 18.0).powi(2));
    assert!(matches!(bent.finding, Finding::NoTrend { .. }), "{bent:?}");
    let baseline = 2e-3 * 17.0_f64.powi(2);
    assert!((bent.value.unwrap() - (baseline - 2e-3 * 25.0)).abs() < 1e-12, "{bent}");
    assert_eq!(still.to_string(), "no_trend");
}

#[test]
fn one_wild_record_makes_and_hides_no_trend() {
    let wild =
        |at: usize| latest(&series(30, |i| 3.0 + 2e-4 * i as f64 + if i == at { 0.5 } else { 0.0 }), Rule::Trend);
    for at in 6..30 {
        let v = wild(at);
        let Finding::Trend { per_year, .. } = v.finding else { panic!("{at}: {v}") };
        assert!((per_year.value - 2e-4 * 365.25 / 14.0).abs() < 1e-9, "{at}: {v}");
    }
    let still = latest(&series(30, |i| 3.0 + if i == 29 { 0.5 } else { 0.0 }), Rule::Trend);
    assert!(matches!(still.finding, Finding::NoTrend { .. }), "{still}");
}

#[test]
fn a_course_that_bends_is_looked_at_over_its_straight_end() {
    // Level for fifteen fortnights, then up by a fifth of the budget each.
    let v = latest(&series(30, |i| 3.0 + 2e-3 * (i as f64 - 15.0).max(0.0)), Rule::Trend);
    let Finding::Trend { cells, provisional, .. } = v.finding else { panic!("{v}") };
    assert_eq!((cells, provisional), (16, true), "{v}");
}

#[test]
fn a_trend_over_weeks_does_not_foretell_a_quarter() {
    let weeks: Vec<(f64, f64)> = (0..9).map(|i| (7.0 * f64::from(i), 3.0 + 1.5e-3 * f64::from(i))).collect();
    let v = latest(&weeks, Rule::Trend);
    let Finding::Trend { horizon_days, .. } = v.finding else { panic!("{v:?}") };
    assert!((horizon_days - 49.0).abs() < 1e-9, "eight cells of nine: {v}");
}

#[test]
fn a_week_of_records_counts_as_one() {
    let of = |points: &[(f64, f64)]| latest(points, Rule::Shift);
    let daily: Vec<(f64, f64)> = (0..55).map(|i| (f64::from(i), 3.0)).collect();
    assert_eq!(of(&daily[..49]).status(), Status::NotEnoughData, "{}", of(&daily[..49]));
    let v = of(&daily);
    let Finding::Shift { before, .. } = v.finding else { panic!("{v}") };
    assert_eq!(before, 5, "2026-01-01 is a Thursday, as 1970-01-01 was: whole weeks");
    // The mean of a week, whatever is in it: one of seven days off by 0.014 moves it by 0.002.
    let off: Vec<(f64, f64)> =
        (0..56).map(|i| (f64::from(i), if (38..).contains(&i) && i % 7 == 3 { 3.014 } else { 3.0 })).collect();
    let v = of(&off);
    assert!((v.value.unwrap() - 0.002).abs() < 1e-12, "{v}");
}

#[test]
fn a_lasting_shift_below_the_budget_is_found_and_no_specification_is_broken() {
    let shifted = series(30, |i| 3.0 + 5e-4 * scatter(i) + if i < 27 { 0.0 } else { 0.005 });
    let v = latest(&shifted, Rule::Shift);
    assert_eq!((v.state, v.status()), (State::Exceeded, Status::Drifting));
    let Finding::Shift { before: 27, since, now, level, .. } = v.finding else { panic!("{v}") };
    assert_eq!(since, day(14.0 * 27.0));
    assert!((now - level - v.value.unwrap()).abs() < 1e-12 && (v.value.unwrap() - 0.005).abs() < 1e-3);
    assert_eq!(v.severity(), Some(Severity::Warning));
    assert_eq!(latest(&shifted, Rule::Baseline).state, State::Within);
    assert_eq!(latest(&series(30, |i| 3.0 + 5e-4 * scatter(i)), Rule::Shift).state, State::Within);
    let down = latest(&series(30, |i| 3.0 - if i < 27 { 0.0 } else { 0.005 }), Rule::Shift);
    assert!(down.to_string().contains("side: below, level: 3.00000, before: 27"), "{down}");
}

#[test]
fn a_gyro_that_goes_on_to_another_station_has_not_shifted() {
    let mut records = samples(None, &series(30, |i| 3.0 + 5e-4 * scatter(i) + if i < 27 { 0.0 } else { 0.005 }));
    let known = Limits { between_stations: [4e-3, 0.0], ..Limits::default() };
    let of = |records: &[Sample], limits: &Limits| verdict(records, &[], 29, Rule::Shift, limits);
    let alone = of(&records, &known);
    assert_eq!((alone.state, alone.between), (State::Exceeded, None), "of one station: {alone}");
    records[27..].iter_mut().for_each(|record| record.station = 7);
    assert_eq!(of(&records, &Limits::default()), alone, "nothing is known of stations");
    let moved = of(&records, &known);
    let between = 4e-3 * std::f64::consts::SQRT_2;
    assert_eq!(moved.state, State::Indeterminate, "{moved}");
    assert!((moved.between.unwrap() / between - 1.0).abs() < 1e-12, "{moved}");
    assert!((moved.sd.unwrap() / alone.sd.unwrap().hypot(between) - 1.0).abs() < 1e-12, "{moved}");
    // One of the newest three weeks: its station has a third of the weight.
    records[27..29].iter_mut().for_each(|record| record.station = 0);
    let one = of(&records, &known);
    assert!((one.between.unwrap() / (between / 3.0) - 1.0).abs() < 1e-12, "{one}");
    // Weeks of both stations are alike, whatever the stations do.
    let both = samples(None, &(0..120).map(|i| (3.5 * f64::from(i), 3.0)).collect::<Vec<_>>());
    let both = at_stations(both, |k| k as u32 % 2);
    assert_eq!(verdict(&both, &[], 119, Rule::Shift, &known).between, None);
}

#[test]
fn what_stations_differ_by_counts_in_a_trend_over_several() {
    let points = series(24, |i| 3.0 + 1e-4 * scatter(i) + 2e-4 * i as f64);
    let at = |station: fn(usize) -> u32| at_stations(samples(None, &points), station);
    let known = Limits { between_stations: [4e-4, 0.0], ..Limits::default() };
    let of = |records: &[Sample], limits: &Limits| verdict(records, &[], 23, Rule::Trend, limits);
    let alone = of(&at(|_| 1), &known);
    let Finding::Trend { horizon_days, reach, .. } = alone.finding else { panic!("{alone}") };
    assert_eq!(alone.between, None, "of one station");
    assert_eq!(of(&at(|k| u32::from(k >= 12)), &Limits::default()), alone, "nothing is known of stations");
    // By hand: least squares carried to the horizon, less the mean of the three that make the baseline; of each station
    // the sum of its weights.
    let expected = |station: fn(usize) -> u32| {
        let weeks: Vec<f64> = points.iter().map(|point| point.0).collect();
        let mean = weeks.iter().sum::<f64>() / 24.0;
        let spread: f64 = weeks.iter().map(|t| (t - mean).powi(2)).sum();
        let ahead = weeks[23] + horizon_days - mean;
        let weight = |k: usize| 1.0 / 24.0 + ahead * (weeks[k] - mean) / spread - if k < 3 { 1.0 / 3.0 } else { 0.0 };
        let of = |one: u32| (0..24).filter(|k| station(*k) == one).map(weight).sum::<f64>();
        4e-4 * of(0).hypot(of(1))
    };
    for station in [|k: usize| u32::from(k >= 12), |k: usize| k as u32 % 2] {
        let apart = of(&at(station), &known);
        let between = apart.between.unwrap();
        assert!((between / expected(station) - 1.0).abs() < 1e-6, "{apart}: {}", expected(station));
        assert!((apart.sd.unwrap() / alone.sd.unwrap().hypot(between) - 1.0).abs() < 1e-9, "{apart}");
        let Finding::Trend { reach: wider, .. } = apart.finding else { panic!("{apart}") };
        assert!(wider[0] < reach[0] && wider[1] == reach[1] && wider[2].is_none_or(|last| Some(last) > reach[2]));
    }
    // A station each half, 1.5e-3 apart: the gyro went on to another station, and has no slope.
    let known = Limits { between_stations: [4e-3, 0.0], ..known };
    assert!(matches!(of(&at(|k| u32::from(k >= 12)), &known).finding, Finding::NoTrend { .. }));
}

#[test]
fn one_wild_record_shifts_no_level() {
    for at in [5, 27, 28, 29] {
        let wild = latest(&series(30, |i| 3.0 + 5e-4 * scatter(i) + if i == at { 0.5 } else { 0.0 }), Rule::Shift);
        assert_eq!(wild.state, State::Within, "{at}: {wild}");
    }
}

#[test]
fn a_shift_that_does_not_matter_raises_nothing_and_noise_widens_the_limit() {
    // Many of its own standard deviations, and less than a quarter of the budget.
    let tiny = latest(&series(30, |i| 3.0 + 1e-5 * scatter(i) + if i < 15 { 0.0 } else { 2.4e-3 }), Rule::Shift);
    assert_eq!((tiny.state, tiny.limit), (State::Within, 0.0025), "{tiny}");
    let noisy = latest(&series(40, |i| 3.0 + 2.5e-3 * scatter(i)), Rule::Shift);
    assert!((noisy.limit - 3.0 * noisy.sd.unwrap()).abs() < 1e-15 && noisy.limit > 0.0025, "{noisy}");
    assert!(matches!(noisy.finding, Finding::Shift { least: 0.0025, .. }), "{noisy:?}");
    let wild = latest(&series(40, |i| 3.0 + 2e-2 * scatter(i)), Rule::Shift);
    assert_eq!((wild.state, wild.status()), (State::Indeterminate, Status::TooUncertain), "{wild}");
    assert!(
        wild.to_string().contains("; limit_of_three_sd (") && wild.to_string().ends_with("; too_uncertain_for_shift"),
        "{wild}"
    );
    // By the gyro's scatter where its records state a thirtieth of it or nothing, by theirs where they state as much.
    let is_scatter = |verdict: Verdict, stated: Option<f64>| verdict.is_too_scattered(stated);
    assert!(is_scatter(wild, None) && is_scatter(wild, Some(7e-4)) && !is_scatter(wild, Some(2e-2)), "{wild}");
    let of_stations = Verdict { between: wild.sd, ..wild };
    assert!(!is_scatter(noisy, Some(7e-4)) && !is_scatter(of_stations, Some(7e-4)), "{noisy} {of_stations}");
}

#[test]
fn the_standard_deviation_of_a_shift_follows_the_noise_model() {
    // k equal cells before: s^2 = 5 s0^2/(5 + k - F), and no less than s0^2/4, with F = k var(mean of k) of AR(1),
    // here by the matrix.
    let noise = NoiseParameters { phi: 0.5, walk: 8e-4, of_fleet: true };
    let limits = Limits { noise, ..Limits::default() };
    for n in [10, 14, 40] {
        let v = verdict(
            &samples(None, &series(n + 5, |_| 3.0)),
            &[Mark::of(day(60.0), Event::Firmware)],
            n + 4,
            Rule::Shift,
            &limits,
        );
        let k = n - 3;
        let w: Vec<f64> = (0..n).map(|i| if i < k { -1.0 / k as f64 } else { 1.0 / 3.0 }).collect();
        let t = |i: usize| 14.0 * i as f64 / 365.25;
        let (mut scatter, mut walk, mut inflation) = (0.115 * 0.5, 0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                let correlated = 0.5_f64.powi((i as i32 - j as i32).abs());
                scatter += w[i] * w[j] * correlated;
                walk += w[i] * w[j] * 64e-8 * t(i.min(j));
                inflation += if i < k && j < k { correlated / k as f64 } else { 0.0 };
            }
        }
        let s2 = (5e-6 / (5.0 + k as f64 - inflation)).max(0.25e-6);
        assert!((v.sd.unwrap() / (s2 * scatter + walk).sqrt() - 1.0).abs() < 1e-9, "{n}: {v}");
        let Finding::Shift { scatter, .. } = v.finding else { panic!("{v}") };
        assert!((scatter * scatter / s2 - 1.0).abs() < 1e-9, "{n}");
    }
}

#[test]
fn the_rms_of_successive_differences_leaves_one_record_out_and_knows_what_noise_explains() {
    // +-0.003 by turns: every difference is 0.006, but for the one that bridges a record that is left out inside,
    // which is 0. Without an end, nine of 0.006; inside, eight of 0.006 and one of 0: 1.2 * 0.006 * sqrt(8/9).
    let restless = series(11, |i| 3.0 + if i % 2 == 0 { 3e-3 } else { -3e-3 });
    let v = latest(&restless, Rule::RmsSuccessive);
    assert_eq!((v.state, v.status()), (State::Exceeded, Status::OutOfTolerance));
    assert!((v.value.unwrap() - 1.2 * 0.006 * (8.0_f64 / 9.0).sqrt()).abs() < 1e-12 && (v.limit - 0.005).abs() < 1e-15);
    assert_eq!(latest(&restless[..10], Rule::RmsSuccessive).state, State::Indeterminate);
    // Campaigns of sd 0.006/sqrt 2 explain more than all of it.
    let noisy = samples(Some(0.004_243), &restless);
    let v = verdict(&noisy, &[], 10, Rule::RmsSuccessive, &Limits::default());
    assert_ne!(v.state, State::Exceeded);
    let Finding::RmsSuccessive { explained: Some(explained), .. } = v.finding else { panic!("{v:?}") };
    assert!((explained - 0.0072).abs() < 1e-5, "{explained}");
    for outlier in 0..11 {
        let one = latest(&series(11, |i| 3.0 + if i == outlier { 0.05 } else { 0.0 }), Rule::RmsSuccessive);
        assert_eq!((one.state, one.value), (State::Within, Some(0.0)), "one bad record says nothing of the gyro");
    }
}

#[test]
fn successive_differences_share_the_noise_of_the_record_between_them() {
    // Ten records left of sd s, all alike, so that the mean square is noise alone: its variance is 2 tr V^2/n^2 with
    // V = s^2 tridiag(-1, 2, -1), tr V^2 = s^4 (4 n + 2 (n - 1)), n = 9. With rms 0, sd = 1.2 sqrt(explained),
    // explained = 2 s^2; P = Phi(-(2 s^2 + (L/1.2)^2)/sqrt(var)).
    let s: f64 = 4e-3;
    let v = verdict(&samples(Some(s), &series(11, |_| 3.0)), &[], 10, Rule::RmsSuccessive, &Limits::default());
    let variance = 2.0 * s.powi(4) * (36.0 + 16.0) / 81.0;
    let z = -(2.0 * s * s + (0.005_f64 / 1.2).powi(2)) / variance.sqrt();
    assert!((v.probability.unwrap() - crate::core::numerics::normal::normal_cdf(z)).abs() < 1e-12, "{v}");
    assert!((v.sd.unwrap() - 1.2 * 2.0_f64.sqrt() * s).abs() < 1e-12);

    // Records that do move, each with a standard deviation of its own, by the full matrix V = D S D^T (D takes
    // differences, S is diagonal): m = d.d/n is off by tr V/n, with variance (2 tr V^2 + 4 (d.V d - tr V^2))/n^2. The
    // last record is the one that is left out.
    let x = [0.0, 4e-3, 1e-3, 6e-3, 2e-3, 7e-3, 1e-3, 5e-3, 0.0, 4e-3, 0.5];
    let mut points = samples(None, &series(11, |i| 3.0 + x[i]));
    let sd = |i: usize| 1e-3 * (1.0 + 0.1 * i as f64);
    points.iter_mut().enumerate().for_each(|(i, sample)| sample.d[0].sd = Some(sd(i)));
    let v = verdict(&points, &[], 10, Rule::RmsSuccessive, &Limits::default());
    let d: Vec<f64> = (0..9).map(|i| x[i + 1] - x[i]).collect();
    let entry = |i: usize, j: usize| {
        let by = |row: usize, record: usize| f64::from(i32::from(record == row + 1) - i32::from(record == row));
        (0..10).map(|record| by(i, record) * sd(record).powi(2) * by(j, record)).sum::<f64>()
    };
    let (mut trace, mut square, mut d_v_d) = (0.0, 0.0, 0.0);
    for i in 0..9 {
        trace += entry(i, i);
        for j in 0..9 {
            square += entry(i, j) * entry(j, i);
            d_v_d += d[i] * entry(i, j) * d[j];
        }
    }
    let m = d.iter().map(|d| d * d).sum::<f64>() / 9.0;
    let variance = (2.0 * square + 4.0 * (d_v_d - square)) / 81.0;
    assert!(d_v_d > 2.0 * square && (v.value.unwrap() - 1.2 * m.sqrt()).abs() < 1e-12);
    let z = (m - trace / 9.0 - (0.005_f64 / 1.2).powi(2)) / variance.sqrt();
    assert!((v.probability.unwrap() - crate::core::numerics::normal::normal_cdf(z)).abs() < 1e-9, "{v}");
    assert!((v.sd.unwrap() - 1.2 * variance.sqrt() / (2.0 * m.sqrt())).abs() < 1e-12);
}

#[test]
fn a_closure_that_moved_is_told_as_a_turn_of_the_mounting() {
    let mut points = samples(None, &series(5, |_| 3.0));
    // 10 arcmin about the input axis at D_S = 5: D_O moves by 5 tan(10').
    points[4].d[2].value = 5.0 * (10.0_f64 / 60.0).to_radians().tan();
    let verdicts = all_verdicts(&points, &[], 4, &Limits::default());
    let v = verdicts.iter().find(|v| v.rule == Rule::Closure).expect("the closure has a limit");
    assert_eq!((v.coefficient, v.state), (Coefficient::DO, State::Exceeded));
    assert!(v.to_string().contains("; closure_turn (turn: +10.0); closure_cause;"), "{v}");
    assert!(verdicts.iter().filter(|v| v.coefficient != Coefficient::DO).all(|v| v.state != State::Exceeded));
}

#[test]
fn a_closure_within_its_limit_is_given_no_cause_and_no_turn_that_rounds_to_nothing() {
    for (moved, turn) in [(0.002, Some("+1.4")), (1e-5, None)] {
        let mut points = samples(Some(1e-3), &series(5, |_| 3.0));
        points[4].d[2].value = moved;
        let v = closure(&points, 4);
        assert_eq!(v.state, State::Within);
        assert_eq!(v.to_string(), "in_tolerance");
        // Of one that is not certain to be within it.
        let undecided = Verdict { state: State::Indeterminate, ..v };
        let turn = turn.map_or(String::new(), |turn| format!("; closure_turn (turn: {turn})"));
        assert!(undecided.to_string().contains(&format!("since: 2026-01-01)){turn}; limit_is (")), "{undecided}");
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
    let bench = FigureSource::Bench(crate::core::bench::BenchMethod::TorqueFeedback);
    let limit = Limit { value: 1e-3, from: LimitKey::BUDGET };
    for (values, range) in table_5 {
        let result = |(i, value)| SourcedResult {
            source: if i == 1 { FigureSource::Separation } else { bench },
            at: day(i as f64),
            measured: Measured::exact(value),
        };
        let results: Vec<_> = values.into_iter().enumerate().map(result).collect();
        let v = agreement(Coefficient::DI, &results, None, limit, 0.95);
        assert!((v.value.unwrap() * 1e4 - range).abs() < 1e-6, "{v:?}");
        assert_eq!(v.state == State::Exceeded, range > 10.0);
    }
    assert_eq!(agreement(Coefficient::DI, &[], None, limit, 0.95).state, State::Indeterminate);
    let near = |values: &[f64]| {
        let result = |value: &f64| SourcedResult { source: bench, at: day(0.0), measured: Measured::exact(*value) };
        agreement(Coefficient::DI, &values.iter().map(result).collect::<Vec<_>>(), None, limit, 0.95)
    };
    assert!(!near(&[3.0, 3.0, 3.002]).confirmed, "one result is to blame");
    let disagree = near(&[3.0, 3.0, 3.002, 3.002]);
    assert_eq!((disagree.confirmed, disagree.severity()), (true, Some(Severity::Critical)));
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
    let outside = "requirement (figure: E_y, value: measured (value: -0.700, unit: unit_pulse_per_arcsec), place: outside, \
                   low: -0.605, high: -0.594); requirement_others (figures: E_x); limits_from (from: judging.requirements)";
    assert!(of_e.to_string().starts_with(outside), "{of_e}");
    let outside =
        "requirement (figure: G_z, value: measured (value: -13.5, unit: unit_pulse_per_second), place: outside";
    assert!(of_g.to_string().starts_with(outside), "{of_g}");
    assert_eq!(of_g.limit, -13.23, "the bound that it passed");
    let sd = Vector3::repeat(1e-3);
    let near = Vector3::new(0.8473, -0.6050, 1.0367);
    let [Some(near), _] = requirement(required, &near, &g, Some(&sd), None, 0.95) else { panic!("E is required") };
    assert_eq!(near.state, State::Indeterminate, "{near}");
    assert_eq!(requirement(&Requirement::default(), &e, &g, None, None, 0.95), [None, None]);
    // The sd of |E|, by hand: |(0.1 x 3, 0.2 x 4, 9 x 0)|/5.
    let length = Requirement { e_norm: required.e[0], ..Requirement::default() };
    let (e, sd) = (Vector3::new(3.0, 4.0, 0.0), Vector3::new(0.1, 0.2, 9.0));
    let [Some(of_length), None] = requirement(&length, &e, &g, Some(&sd), None, 0.95) else { panic!("of |E| alone") };
    assert!((of_length.sd.unwrap() - 0.73_f64.sqrt() / 5.0).abs() < 1e-12, "{of_length}");
}

#[test]
fn of_figures_outside_alike_the_farthest_leads() {
    use nalgebra::Vector3;
    let required = &Requirement::tables_3_and_4()[0];
    let [low, high] = [required.e[0].unwrap(), required.e[1].unwrap()].map(|bounds| [bounds.low, bounds.high]);
    let width = |[low, high]: [f64; 2]| high - low;
    for (x, y, name) in [(3.0, 2.0, "E_x"), (2.0, 3.0, "E_y")] {
        let e = Vector3::new(low[1] + x * width(low), high[1] + y * width(high), 1.0367);
        let [Some(of_e), _] = requirement(required, &e, &Vector3::zeros(), None, None, 0.95) else {
            panic!("required")
        };
        assert!(matches!(of_e.finding, Finding::Requirement { figure, .. } if figure == name), "{of_e:?}");
    }
}

#[test]
fn a_probability_is_rounded_only_beyond_999_in_1000() {
    let points = samples(Some(1e-3), &[(0.0, 3.0), (14.0, 3.0123)]);
    let mut v = verdict(&points, &[], 1, Rule::Step, &Limits::default());
    for (probability, percent) in [(0.999, "= 99.9"), (0.9995, "> 99.9"), (0.001, "= 0.1"), (0.0005, "< 0.1")] {
        v.probability = Some(probability);
        let said = format!("probability_beyond (percent: {percent})");
        assert!(v.to_string().ends_with(&said), "{probability}: {v}");
    }
}

#[test]
fn a_gyro_is_overdue_after_its_interval() {
    let interval = Limit { value: 30.0, from: LimitKey { place: Some(2), key: "interval_days" } };
    assert_eq!(overdue(day(0.0), day(30.0), interval).state, State::Within);
    let v = overdue(day(0.0), day(45.5), interval);
    assert_eq!((v.state, v.status()), (State::Exceeded, Status::Overdue));
    assert_eq!(
        v.to_string(),
        "overdue (last: 2026-01-01, days: 45.5); limit_exceeded (limit: measured (value: 30.0, unit: unit_days), \
         from: judging.overrides[2].interval_days, percent: 152)"
    );
    assert_eq!(overdue(day(9.0), day(0.0), interval).value, Some(0.0), "a record from the future is not minus overdue");
}

#[test]
fn events_reset_what_they_should() {
    let restarts = |event: Event| Rule::ALL.into_iter().filter(|&rule| event.resets(rule)).count();
    assert_eq!(restarts(Event::Repair), Rule::ALL.len() - 4, "all but what a station, a batch or an IMU does");
    assert_eq!((restarts(Event::Transport), restarts(Event::Note)), (0, 0));
    assert!(Event::Reinstallation.resets(Rule::Closure) && !Event::Reinstallation.resets(Rule::Step));
    assert!(Event::Firmware.resets(Rule::Shift) && !Event::Firmware.resets(Rule::Baseline));
    for event in [Event::EnvironmentalTest, Event::Retired, Event::InStorage] {
        assert_eq!(restarts(event), 0, "{event:?}");
    }
    assert!(Event::ALL.iter().all(|event| event.resets(Rule::Shift) == event.resets(Rule::Trend)));
    for event in Event::ALL {
        assert_eq!(event.resets_baseline(), event.resets(Rule::Baseline), "{event:?}");
        assert_eq!(Event::from_name(event.name()), Some(event));
    }
}

#[test]
fn every_coefficient_of_a_history_has_its_column() {
    let columns = Coefficient::ALL.map(Coefficient::column);
    assert_eq!(columns.iter().flatten().collect::<Vec<_>>(), [&0, &1, &2]);
    assert_eq!(
        [Coefficient::DI, Coefficient::DS, Coefficient::DO].map(Coefficient::column),
        [Some(0), Some(1), Some(2)]
    );
}

#[test]
fn every_name_is_read_back() {
    assert!(Rule::ALL.into_iter().all(|x| Rule::from_name(x.name()) == Some(x)));
    assert!(Coefficient::ALL.into_iter().all(|x| Coefficient::from_name(x.name()) == Some(x)));
    assert!(State::ALL.into_iter().all(|x| State::from_name(x.name()) == Some(x)));
    use crate::core::alert_decision::{Action, AlertState};
    assert!(AlertState::ALL.into_iter().all(|x| AlertState::from_name(x.name()) == Some(x)));
    assert!(Action::ALL.into_iter().all(|x| Action::from_name(x.name()) == Some(x)));
    assert!(Status::ALL.into_iter().all(|x| Status::from_name(x.name()) == Some(x)));
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
            let seat = Seat { imu: (at / 150.0) as u32, ..Seat::default() };
            Sample { at: day(at), seat, station: 0, d: values.map(|value| Measured { value, sd }) }
        };
        steps.iter().map(row).collect()
    }

    fn verdicts(samples: &[Sample], k: usize) -> Vec<Verdict> {
        all_verdicts(samples, &[], k, &Limits::default())
    }

    proptest! {
        #[test]
        fn what_need_asks_for_is_enough_and_what_comes_after_does_no_harm(
            steps in prop::collection::vec(sample(), 1..120),
            marks in prop::collection::vec((0.0..2000.0, prop::sample::select(Event::ALL.to_vec()), 0.0..100.0), 0..4),
            pick in 0.0..1.0,
        ) {
            let all = history_of(&steps);
            let mark = |(at, event, days): (f64, Event, f64)| Mark { until: Some(day(at + days)), ..Mark::of(day(at), event) };
            let mut marks: Vec<Mark> = marks.into_iter().map(mark).collect();
            marks.sort_by_key(|mark| mark.at);
            let k = ((all.len() as f64 * pick) as usize).min(all.len() - 1);
            let need = Need::of(&Limits::default());
            let by_days = all.partition_point(|s| all[k].at.days_since(s.at) > need.days);
            let start = by_days.min(k.saturating_sub(need.records));
            let whole = Series::new(all.clone(), marks.clone());
            // Records before the stretch are forgotten; their cells stay.
            let mut stretch = Series::new(all[..=k].to_vec(), marks);
            stretch.forget(start);
            let (mut expected, mut found) = (Vec::new(), Vec::new());
            judge(&History::whole(&whole, k), k, &Limits::default(), &mut expected);
            let of_whole = History::whole(&whole, k);
            judge(&History { samples: &stretch, ..of_whole }, k - start, &Limits::default(), &mut found);
            prop_assert_eq!(expected, found);
        }

        #[test]
        fn a_record_reaches_no_farther_than_need_says(
            steps in prop::collection::vec(sample(), 4..80),
            pick in 0.0..1.0,
        ) {
            let all = history_of(&steps);
            // Not one of a baseline's, and not one that parts two seats.
            let changed = 3 + ((all.len() - 3) as f64 * pick) as usize % (all.len() - 3);
            let of_seat = all[..changed].iter().rev().take_while(|s| s.seat == all[changed].seat).count();
            prop_assume!(of_seat >= 3);
            let mut other = all.clone();
            other[changed].d.iter_mut().for_each(|d| d.value += 0.05);
            let reach = Need::of(&Limits::default()).reach(all[changed].at, &all[changed + 1..]);
            for k in changed + 1 + reach..all.len() {
                prop_assert_eq!(verdicts(&all, k), verdicts(&other, k));
            }
        }

        #[test]
        fn no_history_makes_it_panic_or_answer_what_is_not_finite(
            steps in prop::collection::vec(
                (0.0..4000.0, prop::array::uniform3(-1e100..1e100f64), prop::option::of(0.0..1e100)), 1..60)
        ) {
            let all = history_of(&steps);
            for v in verdicts(&all, all.len() - 1) {
                let figures = [v.value, v.sd, v.probability];
                prop_assert!(figures.into_iter().flatten().all(f64::is_finite), "{v:?}");
                prop_assert!(!v.messages().is_empty());
            }
        }

        #[test]
        fn a_rule_sees_the_same_in_the_mirror(steps in prop::collection::vec(sample(), 1..60)) {
            let all = history_of(&steps);
            let mut mirrored = all.clone();
            mirrored.iter_mut().flat_map(|s| &mut s.d).for_each(|m| m.value = -m.value);
            let k = all.len() - 1;
            for (a, b) in verdicts(&all, k).iter().zip(verdicts(&mirrored, k)) {
                prop_assert_eq!((a.rule, a.state, a.confirmed), (b.rule, b.state, b.confirmed));
                prop_assert_eq!(a.value.map(|v| (v * 1e12).round()), b.value.map(|v| (v * 1e12).round()));
            }
        }
    }
}
