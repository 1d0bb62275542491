//! What the rules are worth on simulated fleets: false alarms, detection delays, and the thresholds of `cusum`.
//!
//! ```text
//! cargo run --release --example judging              the tables of docs/judging.md
//! cargo run --release --example judging thresholds   run lengths of cusum against its threshold
//! ```

mod fleet;

use fleet::{Course, Fired, Fleet, replay};
use gyrowatch::core::judge::{
    Coefficient, CusumLimits, DriftLimits, History, Limits, Measured, Rule, Sample, Series, judge,
};
use gyrowatch::core::time::UtcMicros;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

fn main() {
    match std::env::args().nth(1).as_deref() {
        None => {
            false_alarms();
            delays();
        }
        Some("thresholds") => thresholds(),
        Some(other) => eprintln!("unknown table {other:?}; there is only \"thresholds\" besides the default"),
    }
}

/// Rules that see a gyro's history, in the order of the tables.
const RULES: [Rule; 7] =
    [Rule::Step, Rule::Range, Rule::Baseline, Rule::RmsSuccessive, Rule::Closure, Rule::Trend, Rule::Cusum];

fn fleet(course: Course) -> Fleet {
    Fleet { course, interval_days: 14.0, scatter: 1e-3, reported_sd: Some(5e-4), late: 0.0, years: 4.0 }
}

fn header(first: &str) {
    let names: Vec<&str> = RULES.iter().map(|rule| rule.name()).collect();
    println!("| {first} | {} | whole set |", names.join(" | "));
    println!("|---|{}---|", "---|".repeat(RULES.len()));
}

/// Alerts that begin to fire on gyros to which nothing happens, per gyro and year, D_I, D_S and D_O together.
fn false_alarms() {
    println!("## False alarms per gyro and year\n");
    header("stable fleet");
    let stable = fleet(Course::Stable);
    for (name, fleet) in [
        ("every 14 days, scatter 0.0005", Fleet { scatter: 5e-4, reported_sd: Some(3e-4), ..stable }),
        ("every 14 days, scatter 0.001", stable),
        ("the same, no standard deviations", Fleet { reported_sd: None, ..stable }),
        ("the same, a fifth of the records late", Fleet { late: 0.2, ..stable }),
        ("every 3 days, scatter 0.001", Fleet { interval_days: 3.0, ..stable }),
        ("every 90 days, scatter 0.001 (sparse)", Fleet { interval_days: 90.0, years: 10.0, ..stable }),
        ("every 14 days, scatter 0.002", Fleet { scatter: 2e-3, reported_sd: Some(1e-3), ..stable }),
        ("every 14 days, scatter 0.003", Fleet { scatter: 3e-3, reported_sd: Some(1e-3), ..stable }),
    ] {
        const GYROS: u64 = 1500;
        let fired: Vec<Fired> =
            (0..GYROS).flat_map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), &Limits::default())).collect();
        let rate = |n: usize| format!("{:.3}", n as f64 / (GYROS as f64 * fleet.years));
        let of = |rule| rate(fired.iter().filter(|fired| fired.rule == rule).count());
        println!("| {name} | {} | {} |", RULES.map(of).join(" | "), rate(fired.len()));
    }
}

/// Days from the onset to the first alert on D_I: median, and in brackets the share of gyros that ever raise it.
fn delays() {
    println!(
        "\n## Detection\n\nMedian days from the onset to the alert (share of gyros that raise it within the two years after)\n"
    );
    header("what happens to D_I after 2 years");
    let onset = 2.0 * 365.25;
    let step = |size| fleet(Course::Step { at_day: onset, size });
    let ramp = |per_year| fleet(Course::Ramp { from_day: onset, per_year });
    for (name, fleet) in [
        ("steps by 0.002", step(0.002)),
        ("steps by 0.005", step(0.005)),
        ("steps by 0.012", step(0.012)),
        ("steps by 0.02", step(0.02)),
        ("the same, a fifth of the records late", Fleet { late: 0.2, ..step(0.02) }),
        ("the same, every 90 days (sparse)", Fleet { interval_days: 90.0, ..step(0.02) }),
        ("drifts by 0.005 a year", ramp(0.005)),
        ("drifts by 0.01 a year", ramp(0.01)),
        ("the same, every 90 days (sparse)", Fleet { interval_days: 90.0, ..ramp(0.01) }),
        ("drifts by 0.03 a year", ramp(0.03)),
    ] {
        const GYROS: u64 = 400;
        let gyros: Vec<Vec<Fired>> = (0..GYROS)
            .map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), &Limits::default()))
            .map(|fired| fired.into_iter().filter(|f| f.coefficient == Coefficient::DI && f.day >= onset).collect())
            .collect();
        let delay = |wanted: &dyn Fn(&Fired) -> bool| {
            let mut days: Vec<f64> =
                gyros.iter().filter_map(|fired| fired.iter().find(|f| wanted(f)).map(|f| f.day - onset)).collect();
            days.sort_by(f64::total_cmp);
            let share = days.len() as f64 / gyros.len() as f64;
            match days.get(days.len() / 2) {
                Some(median) if share >= 0.005 => format!("{median:.0} ({:.0} %)", 100.0 * share),
                _ => "-".to_owned(),
            }
        };
        let by_rule = RULES.map(|rule| delay(&|f: &Fired| f.rule == rule));
        println!("| {name} | {} | {} |", by_rule.join(" | "), delay(&|_: &Fired| true));
    }
}

/// Mean run length of the two-sided sum on a stable coefficient, from its first record to its first alarm.
fn thresholds() {
    let thresholds: Vec<f64> = (0..=20).map(|i| 2.5 + 0.25 * f64::from(i)).collect();
    let mut lengths = vec![(0.0, 0usize); thresholds.len()];
    let runs = 4000;
    for seed in 0..runs {
        let mut rng = Fleet::rng(seed);
        first_passages(&mut rng, &thresholds, &mut lengths);
    }
    println!("| threshold | records per false alarm |\n|---|---|");
    for (threshold, (sum, n)) in thresholds.iter().zip(&lengths) {
        println!("| {threshold:.2} | {:.0} |", sum / *n as f64);
    }
}

/// Adds, for each threshold, the record at which one simulated run first passes it (cut off at 100,000 records).
fn first_passages(rng: &mut ChaCha8Rng, thresholds: &[f64], lengths: &mut [(f64, usize)]) {
    const LONGEST: usize = 100_000;
    const KEEP: usize = 40;
    let limits = Limits { d_i: only_cusum(), d_s: DriftLimits::none(), closure: None, ..Limits::default() };
    let (mut samples, mut verdicts) = (Series::default(), Vec::new());
    let mut open = 0;
    for n in 1..=LONGEST {
        let z: f64 = StandardNormal.sample(rng);
        let at = UtcMicros(0).plus_days(n as f64);
        if samples.len() == KEEP {
            samples.forget(1);
        }
        samples.push(Sample { at, d: [Measured::exact(z); 3] });
        verdicts.clear();
        judge(&History::of(&samples, &[], &[]), samples.len() - 1, &limits, &mut verdicts);
        let sum = verdicts[0].value.unwrap_or(0.0);
        while open < thresholds.len() && sum > thresholds[open] {
            lengths[open].0 += n as f64;
            lengths[open].1 += 1;
            open += 1;
        }
        if open == thresholds.len() {
            return;
        }
    }
    for length in &mut lengths[open..] {
        length.0 += LONGEST as f64;
        length.1 += 1;
    }
}

fn only_cusum() -> DriftLimits {
    let cusum = CusumLimits { records_per_false_alarm: 500.0, least_scatter: 0.0 };
    DriftLimits { cusum: Some(cusum), ..DriftLimits::none() }
}
