//! The rules on gyros whose course is known: a short form of the tables of `docs/judging.md`, on other seeds.

#[path = "../examples/judging/fleet.rs"]
mod fleet;

use fleet::{Arrival, Course, Fired, Fleet, Noise, replay};
use gyrowatch::core::judge::{Coefficient, Finding, History, Limits, Rule, Sample, Series, Verdict, judge};

const ONSET: f64 = 2.0 * 365.25;
/// Not those of the tables.
const SEED: u64 = 770_000;

fn fired_by(fleet: &Fleet, gyros: u64, limits: &Limits) -> Vec<Vec<Fired>> {
    (SEED..SEED + gyros).map(|seed| replay(&fleet.arrivals(&mut Fleet::rng(seed)), limits)).collect()
}

fn of_fleet(fleet: &Fleet) -> Limits {
    Limits { noise: fleet.constants(30).noise, ..Limits::default() }
}

/// Alerts per gyro and year.
fn rate(fired: &[Vec<Fired>], years: f64, wanted: impl Fn(&Fired) -> bool) -> f64 {
    fired.iter().flatten().filter(|fired| wanted(fired)).count() as f64 / (fired.len() as f64 * years)
}

/// Median days to the first wanted alert on D_I after the onset, of the gyros that raise it, and their share.
fn delay(fired: &[Vec<Fired>], wanted: impl Fn(&Fired) -> bool) -> (f64, f64) {
    let wanted = |f: &&Fired| f.coefficient == Coefficient::DI && f.day >= ONSET && wanted(f);
    let mut days: Vec<f64> = fired.iter().filter_map(|gyro| gyro.iter().find(wanted).map(|f| f.day - ONSET)).collect();
    days.sort_by(f64::total_cmp);
    (days.get(days.len() / 2).copied().unwrap_or(f64::INFINITY), days.len() as f64 / fired.len() as f64)
}

#[test]
fn gyros_to_which_nothing_happens_raise_hardly_any_alarm_whatever_their_noise() {
    let white = Noise::WHITE;
    // Alerts per gyro and year to keep below, a third more than what is promised over many gyros.
    for (name, noise, most) in [
        ("independent", white, 0.03),
        ("AR(1) 0.4", Noise { phi: 0.4, ..white }, 0.10),
        ("AR(1) 0.6", Noise { phi: 0.6, ..white }, 0.13),
        ("walk 0.001", Noise { walk: 1e-3, ..white }, 0.13),
    ] {
        for (days, gyros) in [(14.0, 200), (60.0, 200), (1.0, 10)] {
            let fleet = Fleet { noise, interval_days: days, ..Fleet::of(Course::Stable) };
            for limits in [Limits::default(), of_fleet(&fleet)] {
                let fired = fired_by(&fleet, gyros, &limits);
                let all = rate(&fired, fleet.years, |_| true);
                assert!(all <= most, "{name} every {days} days: {all} a gyro and year");
                let broken = rate(&fired, fleet.years, |f| !matches!(f.rule, Rule::Shift | Rule::Trend));
                assert_eq!(broken, 0.0, "{name}: no budget is exceeded by scatter");
            }
        }
    }
    let restless = Fleet { noise: Noise { walk: 2e-3, ..white }, ..Fleet::of(Course::Stable) };
    let all = rate(&fired_by(&restless, 200, &of_fleet(&restless)), restless.years, |_| true);
    assert!(all <= 0.15, "a walk of 0.002: {all}");
}

#[test]
fn the_constants_of_a_fleet_are_found_in_its_history() {
    for (phi, walk) in [(0.0, 0.0), (0.6, 0.0), (0.0, 1e-3), (0.4, 2e-3)] {
        let fleet = Fleet { noise: Noise { phi, walk, ..Noise::WHITE }, ..Fleet::of(Course::Stable) };
        let found = fleet.constants(60);
        let (fitted, scatter) = (found.fitted.expect("a fit"), found.scatter.expect("a fit"));
        assert!((fitted.phi - phi).abs() < 0.12, "{phi} {walk}: {fitted:?}");
        assert!((fitted.walk - walk).abs() < 6e-4, "{phi} {walk}: {fitted:?}");
        assert!((scatter / 1e-3 - 1.0).abs() < 0.2, "{phi} {walk}: scatter {scatter}");
        assert!(found.noise.of_fleet && found.cells > 60 * 2 * 90 && found.moving < 12, "{found:?}");
    }
    // A short history leaves the defaults in force, and gyros that move are left out.
    let young = Fleet { years: 0.1, ..Fleet::of(Course::Stable) }.constants(5);
    assert_eq!((young.fitted, young.noise), (None, Limits::default().noise));
    let moving = |seed: u64| Fleet::of(Course::Ramp { from_day: 0.0, per_year: 0.02 }).series(&mut Fleet::rng(seed));
    let still = |seed: u64| Fleet::of(Course::Stable).series(&mut Fleet::rng(seed));
    let all: Vec<Series> = (0..20).map(still).chain((20..24).map(moving)).collect();
    let found = gyrowatch::core::judge::fit_fleet(&all);
    assert_eq!(found.moving, 4, "D_I of four gyros");
    assert!(found.fitted.expect("a fit").walk < 6e-4, "{found:?}");
}

#[test]
fn steps_and_ramps_are_found_in_time() {
    let step = |size| Fleet::of(Course::Step { at_day: ONSET, size });
    let ramp = |per_year| Fleet::of(Course::Ramp { from_day: ONSET, per_year });
    for (name, fleet, most) in [
        ("a step of 0.015", step(0.015), 8.5),
        ("a step of 0.005", step(0.005), 25.0),
        ("0.02 a year", ramp(0.02), 75.0),
        ("0.01 a year", ramp(0.01), 125.0),
    ] {
        let (days, share) = delay(&fired_by(&fleet, 200, &of_fleet(&fleet)), |_| true);
        assert!(days <= most && share == 1.0, "{name}: {days} days, {share}");
    }
    let fired = fired_by(&step(0.02), 60, &Limits::default());
    for rule in [Rule::Step, Rule::Baseline] {
        let (days, share) = delay(&fired, |f| f.rule == rule);
        assert!(days < 19.0 && share == 1.0, "{rule:?}: {days} days, {share}");
    }
}

#[test]
fn a_slow_ramp_is_foretold_before_it_reaches_the_budget() {
    let fleet = Fleet::of(Course::Ramp { from_day: ONSET, per_year: 0.01 });
    let fired = fired_by(&fleet, 60, &of_fleet(&fleet));
    let (trend, share) = delay(&fired, |f| f.rule == Rule::Trend);
    let (baseline, _) = delay(&fired, |f| f.rule == Rule::Baseline);
    assert!(share > 0.95 && trend + 30.0 < baseline, "trend after {trend} days, baseline after {baseline}");
}

/// (foretold - true deviation after the horizon)/sd, and whether the true date lies in its interval, of ramps older
/// than the window.
fn forecasts(noise: Noise, limits: &Limits) -> Vec<(f64, bool)> {
    let of = |seed: u64| {
        let per_year = [0.005, -0.006, 0.007, -0.008][seed as usize % 4];
        let fleet = Fleet { noise, years: 8.0, ..Fleet::of(Course::Ramp { from_day: 0.0, per_year }) };
        let all = fleet.arrivals(&mut Fleet::rng(SEED + seed));
        let k = 27 + seed as usize % 11;
        let samples: Vec<Sample> = all.iter().map(|arrival| arrival.sample).collect();
        let (series, mut verdicts) = (Series::from(samples), Vec::new());
        judge(&History::whole(&series, k), k, limits, &mut verdicts);
        let of_trend = |v: &&Verdict| (v.coefficient, v.rule) == (Coefficient::DI, Rule::Trend);
        let verdict = verdicts.iter().find(of_trend)?;
        let Finding::Trend { per_year, deviation, horizon_days, reach: [first, _, last], .. } = verdict.finding else {
            return None;
        };
        let origin = all[..3].iter().map(|arrival| arrival.level).sum::<f64>() / 3.0;
        let line = |a: &Arrival, b: &Arrival, day: f64| a.level + (b.level - a.level) * (day - a.day) / (b.day - a.day);
        let at = |day: f64| {
            let next = all.partition_point(|arrival| arrival.day < day);
            line(&all[next - 1], &all[next], day) - origin
        };
        let budget = 0.01 * per_year.value.signum();
        let crossing = all.windows(2).find(|pair| (pair[1].level - origin - budget) * budget > 0.0)?;
        if crossing[1].day <= all[k].day {
            return None;
        }
        let (a, b) = (&crossing[0], &crossing[1]);
        let day = a.day + (b.day - a.day) * (budget + origin - a.level) / (b.level - a.level);
        let date = fleet::BEGIN.plus_days(day);
        let covered = first.is_some_and(|first| first <= date) && last.is_none_or(|last| date <= last);
        let foretold = deviation + per_year.value * horizon_days / 365.25;
        Some(((foretold - at(all[k].day + horizon_days)) / verdict.sd?, covered))
    };
    (0..1500).filter_map(of).collect()
}

#[test]
fn the_standard_deviation_of_a_forecast_is_right_from_both_sides_and_its_dates_cover_the_true_one() {
    for (phi, walk, tolerance) in [(0.0, 0.0, 2.5), (0.4, 0.0, 3.0), (0.0, 1e-3, 3.5)] {
        let noise = Noise { phi, walk, ..Noise::WHITE };
        let limits = of_fleet(&Fleet { noise, ..Fleet::of(Course::Stable) });
        let all = forecasts(noise, &limits);
        let rms = (all.iter().map(|(score, _)| score * score).sum::<f64>() / all.len() as f64).sqrt();
        let covered = 100.0 * all.iter().filter(|(_, covered)| *covered).count() as f64 / all.len() as f64;
        assert!(all.len() > 500 && (0.88..1.12).contains(&rms), "{phi} {walk}: rms {rms} over {}", all.len());
        assert!((covered - 95.0).abs() < tolerance, "{phi} {walk}: {covered} %");
    }
}

#[test]
fn records_that_arrive_late_end_in_the_same_verdicts() {
    let late = Fleet { late: 0.3, ..Fleet::of(Course::Step { at_day: ONSET, size: 0.01 }) };
    for seed in 0..20 {
        let arrivals = late.arrivals(&mut Fleet::rng(seed));
        let mut in_order: Vec<Sample> = arrivals.iter().map(|arrival| arrival.sample).collect();
        assert!(!in_order.is_sorted_by_key(|sample| sample.at), "some must be late");
        in_order.sort_by_key(|sample| sample.at);
        let mut inserted = Series::default();
        arrivals.iter().for_each(|arrival| inserted.insert([arrival.sample]));
        assert_eq!(newest(&in_order.into()), newest(&inserted));
    }
    let (days, share) = delay(&fired_by(&late, 60, &Limits::default()), |f| f.rule == Rule::Shift);
    assert!(days < 60.0 && share > 0.95, "{days} days, {share}");
}

fn newest(samples: &Series) -> Vec<Verdict> {
    let (mut verdicts, k) = (Vec::new(), samples.len() - 1);
    judge(&History::whole(samples, k), k, &Limits::default(), &mut verdicts);
    verdicts
}
