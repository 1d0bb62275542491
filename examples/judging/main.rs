//! What the rules are worth on simulated fleets: false alarms by kind of noise beside well-known charts, detection
//! delays, and whether the dates of `trend` are right.
//!
//! ```text
//! cargo run --release --example judging            the tables of docs/judging.md
//! cargo run --release --example judging alarms     one of them: alarms, rules, delays, dates
//! ```

mod charts;
mod fleet;

use charts::CHARTS;
use fleet::{Arrival, BEGIN, Course, Fired, Fleet, Noise, replay};
use gyrowatch::core::judge::{Coefficient, Finding, History, Limits, Rule, Series, Verdict, judge};
use rand::RngExt;

fn main() {
    let tables: [(&str, fn()); 4] = [("alarms", alarms), ("rules", by_rule), ("delays", delays), ("dates", dates)];
    let wanted = std::env::args().nth(1);
    match wanted.as_deref() {
        None => tables.iter().for_each(|(_, table)| table()),
        Some(name) => match tables.iter().find(|(known, _)| *known == name) {
            Some((_, table)) => table(),
            None => eprintln!("unknown table {name:?}: alarms, rules, delays or dates"),
        },
    }
}

/// Rules that see a gyro's history, in the order of the tables.
const RULES: [Rule; 7] =
    [Rule::Step, Rule::Range, Rule::Baseline, Rule::RmsSuccessive, Rule::Closure, Rule::Trend, Rule::Shift];

/// Gyros whose history the constants of the fleet are taken from.
const OTHERS: u64 = 30;

fn with_constants_of(fleet: &Fleet) -> Limits {
    Limits { noise: fleet.constants(OTHERS).noise, ..Limits::default() }
}

fn noises() -> [(&'static str, Noise); 7] {
    let white = Noise::WHITE;
    [
        ("independent", white),
        ("AR(1) 0.2", Noise { phi: 0.2, ..white }),
        ("AR(1) 0.4", Noise { phi: 0.4, ..white }),
        ("AR(1) 0.6", Noise { phi: 0.6, ..white }),
        ("walk 0.001", Noise { walk: 1e-3, ..white }),
        ("walk 0.002", Noise { walk: 2e-3, ..white }),
        ("t, 3 dof", Noise { heavy_tails: true, ..white }),
    ]
}

/// Alerts that begin to fire on gyros to which nothing happens, per gyro and year, D_I, D_S and D_O together.
fn alarms() {
    println!("## Alerts per gyro and year of the whole set, nothing happens\n");
    println!("| every | noise | defaults | constants of the fleet | {} |", CHARTS.map(|(name, _)| name).join(" | "));
    println!("|---|---|---|---|---|---|---|");
    for (every, days, gyros) in [("14 days", 14.0, 1000_u64), ("60 days", 60.0, 1000), ("day", 1.0, 100)] {
        for (name, noise) in noises() {
            let years = if days > 30.0 { 12.0 } else { 4.0 };
            let fleet = Fleet { noise, interval_days: days, years, ..Fleet::of(Course::Stable) };
            let of_fleet = with_constants_of(&fleet);
            let (mut by_default, mut by_fleet, mut by_chart) = (0, 0, [0; CHARTS.len()]);
            let mut watched = 0.0;
            for seed in 0..gyros {
                let arrivals = fleet.arrivals(&mut Fleet::rng(seed));
                by_default += replay(&arrivals, &Limits::default()).len();
                by_fleet += replay(&arrivals, &of_fleet).len();
                for (count, (_, chart)) in by_chart.iter_mut().zip(CHARTS) {
                    *count += charts::alarms(chart, &arrivals).0;
                }
                watched += charts::alarms(CHARTS[0].1, &arrivals).1;
            }
            let years = gyros as f64 * fleet.years;
            let charts =
                by_chart.map(|count| if watched > 0.0 { format!("{:.2}", count as f64 / watched) } else { "-".into() });
            println!(
                "| {every} | {name} | {:.3} | {:.3} | {} |",
                f64::from(by_default as u32) / years,
                f64::from(by_fleet as u32) / years,
                charts.join(" | ")
            );
        }
    }
    println!();
}

fn header(first: &str) {
    let names: Vec<&str> = RULES.iter().map(|rule| rule.name()).collect();
    println!("| {first} | {} | whole set |", names.join(" | "));
    println!("|---|{}---|", "---|".repeat(RULES.len()));
}

/// The same by rule, with the constants of the fleet.
fn by_rule() {
    println!("## Alerts per gyro and year by rule, constants of the fleet\n");
    header("stable fleet");
    let stable = Fleet::of(Course::Stable);
    let scatter = |scatter, sd| Fleet { noise: Noise { scatter, ..Noise::WHITE }, reported_sd: Some(sd), ..stable };
    for (name, fleet) in [
        ("every 14 days, scatter 0.0005", scatter(5e-4, 3e-4)),
        ("every 14 days, scatter 0.001", stable),
        ("the same, no standard deviations", Fleet { reported_sd: None, ..stable }),
        ("the same, a fifth of the records late", Fleet { late: 0.2, ..stable }),
        ("every 3 days, scatter 0.001", Fleet { interval_days: 3.0, ..stable }),
        ("every 90 days, scatter 0.001", Fleet { interval_days: 90.0, years: 10.0, ..stable }),
        ("every 14 days, scatter 0.002", scatter(2e-3, 1e-3)),
        ("every 14 days, scatter 0.003", scatter(3e-3, 1e-3)),
    ] {
        const GYROS: u64 = 1000;
        let limits = with_constants_of(&fleet);
        let fired: Vec<Fired> =
            (0..GYROS).flat_map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), &limits)).collect();
        let rate = |n: usize| format!("{:.3}", n as f64 / (GYROS as f64 * fleet.years));
        let of = |rule| rate(fired.iter().filter(|fired| fired.rule == rule).count());
        println!("| {name} | {} | {} |", RULES.map(of).join(" | "), rate(fired.len()));
    }
    println!();
}

/// Days from the onset to the first alert on D_I: median and 90 % point, and the share of gyros that ever raise it.
fn delays() {
    println!("## Days from the onset to the alert: median / 90 % (share of gyros within two years)\n");
    header("what happens to D_I after 2 years");
    let onset = 2.0 * 365.25;
    let step = |size| Fleet::of(Course::Step { at_day: onset, size });
    let ramp = |per_year| Fleet::of(Course::Ramp { from_day: onset, per_year });
    let row = |name: &str, fleet: &Fleet, limits: &Limits| {
        const GYROS: u64 = 1000;
        let gyros: Vec<Vec<Fired>> = (0..GYROS)
            .map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), limits))
            .map(|fired| fired.into_iter().filter(|f| f.coefficient == Coefficient::DI && f.day >= onset).collect())
            .collect();
        let delay = |wanted: &dyn Fn(&Fired) -> bool| {
            let mut days: Vec<f64> =
                gyros.iter().filter_map(|fired| fired.iter().find(|f| wanted(f)).map(|f| f.day - onset)).collect();
            days.sort_by(f64::total_cmp);
            let share = days.len() as f64 / gyros.len() as f64;
            if share < 0.005 {
                return "-".to_owned();
            }
            format!("{:.0} / {:.0} ({:.0} %)", days[days.len() / 2], days[days.len() * 9 / 10], 100.0 * share)
        };
        let by_rule = RULES.map(|rule| delay(&|f: &Fired| f.rule == rule));
        println!("| {name} | {} | {} |", by_rule.join(" | "), delay(&|_: &Fired| true));
    };
    for (name, fleet) in [
        ("steps by 0.003", step(0.003)),
        ("steps by 0.005", step(0.005)),
        ("steps by 0.015", step(0.015)),
        ("the same, a fifth of the records late", Fleet { late: 0.2, ..step(0.015) }),
        ("the same, every 90 days", Fleet { interval_days: 90.0, ..step(0.015) }),
        ("drifts by 0.005 a year", ramp(0.005)),
        ("drifts by 0.01 a year", ramp(0.01)),
        ("drifts by 0.02 a year", ramp(0.02)),
        ("drifts by 0.02 a year, AR(1) 0.6", Fleet { noise: Noise { phi: 0.6, ..Noise::WHITE }, ..ramp(0.02) }),
    ] {
        row(&format!("{name}, defaults"), &fleet, &Limits::default());
        row(&format!("{name}, fleet"), &fleet, &with_constants_of(&fleet));
    }
    println!();
}

/// Whether the standard deviation of `trend` and its dates are right: on ramps that are older than the window.
fn dates() {
    println!("## Forecasts of trend: 3,000 ramps of 0.004 to 0.01 a year, older than the window\n");
    println!(
        "| noise | constants | trends | rms(error/sd) | 95 % dates cover | of younger ramps, provisional | not provisional |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, noise) in noises().into_iter().filter(|(_, noise)| !noise.heavy_tails) {
        let still = Fleet { noise, ..Fleet::of(Course::Stable) };
        for (constants, limits) in [("defaults", Limits::default()), ("fleet", with_constants_of(&still))] {
            let old = forecasts(noise, 0.0, &limits);
            let young = forecasts(noise, 2.0 * 365.25, &limits);
            let share = |of: &dyn Fn(&&Forecast) -> bool| {
                let all: Vec<&Forecast> = young.iter().filter(of).collect();
                let covered = all.iter().filter(|forecast| forecast.covered).count();
                format!("{:.1} % of {}", 100.0 * covered as f64 / (all.len() as f64).max(1.0), all.len())
            };
            let rms = (old.iter().map(|of| of.score * of.score).sum::<f64>() / old.len() as f64).sqrt();
            let covered = 100.0 * old.iter().filter(|of| of.covered).count() as f64 / old.len() as f64;
            println!(
                "| {name} | {constants} | {} | {rms:.2} | {covered:.1} % | {} | {} |",
                old.len(),
                share(&|of| of.provisional),
                share(&|of| !of.provisional)
            );
        }
    }
    println!();
}

/// What one trend foretold of one ramp, held against its true course.
struct Forecast {
    /// (Deviation foretold at the horizon - true one)/standard deviation.
    score: f64,
    /// Whether the true date lies in the 95 % interval.
    covered: bool,
    provisional: bool,
}

/// One a ramp that begins at `onset`: at a record 26 to 40 after the first one where that is 0, else 6 to 20 after
/// the onset.
fn forecasts(noise: Noise, onset: f64, limits: &Limits) -> Vec<Forecast> {
    let of = |seed: u64| {
        let mut rng = Fleet::rng(5_000_000 + seed);
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let per_year = rng.random_range(0.004..0.01) * if onset > 0.0 { 2.0 } else { 1.0 };
        let course = Course::Ramp { from_day: onset, per_year: side * per_year };
        let fleet = Fleet { noise, years: onset / 365.25 + 8.0, ..Fleet::of(course) };
        let all = fleet.arrivals(&mut Fleet::rng(seed));
        let first = all.partition_point(|arrival| arrival.day < onset);
        let k = first + if onset > 0.0 { rng.random_range(6..20) } else { rng.random_range(26..40) };
        let series = all.iter().map(|arrival| arrival.sample).collect::<Vec<_>>().into();
        forecast(&all, &series, k, limits)
    };
    (0..3000).filter_map(of).collect()
}

fn forecast(all: &[Arrival], series: &Series, k: usize, limits: &Limits) -> Option<Forecast> {
    let mut verdicts = Vec::new();
    judge(&History::whole(series, k), k, limits, &mut verdicts);
    let of_trend = |verdict: &&Verdict| (verdict.coefficient, verdict.rule) == (Coefficient::DI, Rule::Trend);
    let verdict = verdicts.iter().find(of_trend)?;
    let Finding::Trend { per_year, deviation, horizon_days, reach, provisional, .. } = verdict.finding else {
        return None;
    };
    let baseline = all[..3].iter().map(|arrival| arrival.level).sum::<f64>() / 3.0;
    let at = |day: f64| {
        let next = all.partition_point(|arrival| arrival.day < day).clamp(1, all.len() - 1);
        let (a, b) = (&all[next - 1], &all[next]);
        a.level + (b.level - a.level) * (day - a.day) / (b.day - a.day) - baseline
    };
    let budget = verdict.limit * per_year.value.signum();
    let beyond = |arrival: &&Arrival| (arrival.level - baseline - budget) * budget >= 0.0;
    let crossed = all.iter().find(beyond)?;
    if crossed.day <= all[k].day {
        return None;
    }
    let true_date = {
        let next = all.partition_point(|arrival| arrival.day < crossed.day);
        let (a, b) = (&all[next - 1], &all[next]);
        let part = (budget + baseline - a.level) / (b.level - a.level);
        BEGIN.plus_days(a.day + part * (b.day - a.day))
    };
    let foretold = deviation + per_year.value * horizon_days / 365.25;
    let [first, _, last] = reach;
    Some(Forecast {
        score: (foretold - at(all[k].day + horizon_days)) / verdict.sd?,
        covered: first.is_some_and(|first| first <= true_date) && last.is_none_or(|last| true_date <= last),
        provisional,
    })
}
