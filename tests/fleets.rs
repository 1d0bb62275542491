//! The rules on gyros whose course is known: a short form of the tables of `docs/judging.md`.

#[path = "../examples/judging/fleet.rs"]
mod fleet;

use fleet::{Course, Fired, Fleet, replay};
use gyrowatch::core::judge::{
    BASELINE_RECORDS, Coefficient, CusumLimits, DriftLimits, History, Limits, Measured, Rule, Sample, Series, Verdict,
    judge,
};
use gyrowatch::core::time::UtcMicros;
use rand_distr::{Distribution, StandardNormal};

const ONSET: f64 = 2.0 * 365.25;

fn fleet(course: Course) -> Fleet {
    Fleet { course, interval_days: 14.0, scatter: 1e-3, reported_sd: Some(5e-4), late: 0.0, years: 4.0 }
}

fn fired_by(fleet: &Fleet, gyros: u64) -> Vec<Vec<Fired>> {
    (0..gyros).map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), &Limits::default())).collect()
}

/// Alerts per gyro and year.
fn rate(fired: &[Vec<Fired>], years: f64, wanted: impl Fn(&Fired) -> bool) -> f64 {
    fired.iter().flatten().filter(|fired| wanted(fired)).count() as f64 / (fired.len() as f64 * years)
}

/// Days to the first wanted alert on D_I after the onset, of the gyros that raise it, and their share.
fn delay(fired: &[Vec<Fired>], rule: Rule) -> (f64, f64) {
    let wanted = |f: &&Fired| f.coefficient == Coefficient::DI && f.rule == rule && f.day >= ONSET;
    let mut days: Vec<f64> = fired.iter().filter_map(|gyro| gyro.iter().find(wanted).map(|f| f.day - ONSET)).collect();
    days.sort_by(f64::total_cmp);
    (days.get(days.len() / 2).copied().unwrap_or(f64::INFINITY), days.len() as f64 / fired.len() as f64)
}

#[test]
fn gyros_to_which_nothing_happens_raise_the_documented_number_of_alarms() {
    let stable = fleet(Course::Stable);
    let fired = fired_by(&stable, 400);
    let all = rate(&fired, stable.years, |_| true);
    assert!((0.07..0.13).contains(&all), "{all} a gyro and year");
    assert_eq!(rate(&fired, stable.years, |f| f.rule != Rule::Cusum), 0.0, "no budget is exceeded by scatter");
}

#[test]
fn sparse_data_raise_hardly_any_alarm() {
    let sparse = Fleet { interval_days: 90.0, years: 10.0, ..fleet(Course::Stable) };
    let all = rate(&fired_by(&sparse, 300), sparse.years, |_| true);
    assert!(all < 0.03, "{all} a gyro and year");
}

#[test]
fn a_step_of_two_budgets_is_told_by_the_first_record_after_it() {
    let fired = fired_by(&fleet(Course::Step { at_day: ONSET, size: 0.02 }), 100);
    for rule in [Rule::Step, Rule::Baseline] {
        let (days, share) = delay(&fired, rule);
        assert!(days < 19.0 && share == 1.0, "{rule:?}: {days} days, {share}");
    }
}

#[test]
fn a_step_of_a_fifth_of_the_budget_is_found_by_the_control_limit_alone() {
    let fired = fired_by(&fleet(Course::Step { at_day: ONSET, size: 0.002 }), 100);
    let (days, share) = delay(&fired, Rule::Cusum);
    assert!(days < 80.0 && share > 0.95, "{days} days, {share}");
    assert_eq!(delay(&fired, Rule::Baseline).1, 0.0);
}

#[test]
fn a_slow_ramp_is_foretold_before_it_reaches_the_budget() {
    let fired = fired_by(&fleet(Course::Ramp { from_day: ONSET, per_year: 0.01 }), 100);
    let (trend, share) = delay(&fired, Rule::Trend);
    let (baseline, _) = delay(&fired, Rule::Baseline);
    assert!(share > 0.95 && trend + 45.0 < baseline, "trend after {trend} days, baseline after {baseline}");
}

#[test]
fn records_that_arrive_late_end_in_the_same_verdicts() {
    let late = Fleet { late: 0.3, ..fleet(Course::Step { at_day: ONSET, size: 0.01 }) };
    for seed in 0..20 {
        let arrivals = late.arrivals(&mut Fleet::rng(seed));
        let mut in_order: Vec<Sample> = arrivals.iter().map(|arrival| arrival.sample).collect();
        assert!(!in_order.is_sorted_by_key(|sample| sample.at), "some must be late");
        in_order.sort_by_key(|sample| sample.at);
        let mut inserted: Vec<Sample> = Vec::new();
        for arrival in &arrivals {
            inserted.insert(inserted.partition_point(|s| s.at < arrival.sample.at), arrival.sample);
        }
        assert_eq!(newest(&in_order), newest(&inserted));
    }
    let (days, share) = delay(&fired_by(&late, 60), Rule::Cusum);
    assert!(days < 90.0 && share > 0.95, "{days} days, {share}");
}

fn newest(samples: &[Sample]) -> Vec<Verdict> {
    let mut verdicts = Vec::new();
    judge(
        &History::of(&samples.into(), &samples[..BASELINE_RECORDS], &[]),
        samples.len() - 1,
        &Limits::default(),
        &mut verdicts,
    );
    verdicts
}

#[test]
fn a_stable_coefficient_passes_the_cumulative_sum_once_in_as_many_records_as_configured() {
    for wanted in [200.0, 500.0] {
        let cusum = Some(CusumLimits { records_per_false_alarm: wanted, least_scatter: 0.0 });
        let limits = Limits {
            d_i: DriftLimits { cusum, ..DriftLimits::none() },
            d_s: DriftLimits::none(),
            closure: None,
            ..Limits::default()
        };
        let runs = 600;
        let mean = (0..runs).map(|seed| run_length(seed, &limits) as f64).sum::<f64>() / f64::from(runs);
        assert!((mean / wanted - 1.0).abs() < 0.12, "{mean} records instead of {wanted}");
    }
}

fn run_length(seed: u32, limits: &Limits) -> usize {
    let (mut rng, mut samples, mut verdicts) = (Fleet::rng(u64::from(seed)), Series::default(), Vec::new());
    loop {
        let z: f64 = StandardNormal.sample(&mut rng);
        let at = UtcMicros(0).plus_days(samples.len() as f64);
        samples.push(Sample { at, d: [Measured::exact(z); 3] });
        verdicts.clear();
        judge(&History::of(&samples, &[], &[]), samples.len() - 1, limits, &mut verdicts);
        if verdicts[0].value.is_some_and(|sum| sum > verdicts[0].limit) {
            return samples.len();
        }
    }
}
