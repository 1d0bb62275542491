//! Gyros whose course is known, calibrated through the years, and judged as the service judges them: record by record
//! as they arrive, one alert per coefficient and rule.

use std::collections::BTreeMap;

use gyrowatch::core::judge::{
    BASELINE_RECORDS, Coefficient, History, Limits, Measured, Rule, Sample, Series, Verdict, judge,
};
use gyrowatch::core::notify::{Action, Alert, Policy, follow};
use gyrowatch::core::time::UtcMicros;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What really happens to D_I, deg/(h g0). D_S and D_O stay where they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    Stable,
    Step { at_day: f64, size: f64 },
    Ramp { from_day: f64, per_year: f64 },
}

impl Course {
    fn value(self, day: f64) -> f64 {
        match self {
            Course::Stable => 0.0,
            Course::Step { at_day, size } => size * f64::from(day >= at_day),
            Course::Ramp { from_day, per_year } => per_year / 365.25 * (day - from_day).max(0.0),
        }
    }
}

/// How the gyros of a fleet are calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fleet {
    pub course: Course,
    /// Days between campaigns; each comes up to a third of it early or late.
    pub interval_days: f64,
    /// True scatter from campaign to campaign, deg/(h g0): the gyro's own and the station's together.
    pub scatter: f64,
    /// What the station reports of it as standard deviation; none where it reports nothing.
    pub reported_sd: Option<f64>,
    /// Share of the records that arrive only after the next ones.
    pub late: f64,
    pub years: f64,
}

/// A calibration record on its way: judged when it arrives, in its place by `sample.at`.
#[derive(Debug, Clone, Copy)]
pub struct Arrival {
    pub day: f64,
    pub sample: Sample,
}

const BEGIN: UtcMicros = UtcMicros(1_767_225_600_000_000);

impl Fleet {
    /// One gyro's records, in the order in which they arrive.
    pub fn arrivals(&self, rng: &mut ChaCha8Rng) -> Vec<Arrival> {
        let (mut day, mut arrivals) = (0.0, Vec::new());
        while day < self.years * 365.25 {
            let mut figure = |truth: f64| {
                let z: f64 = StandardNormal.sample(rng);
                Measured { value: truth + self.scatter * z, sd: self.reported_sd }
            };
            let d = [figure(3.0 + self.course.value(day)), figure(5.0), figure(0.0)];
            let delay = if rng.random_bool(self.late) { self.interval_days * rng.random_range(1.0..4.0) } else { 0.0 };
            arrivals.push(Arrival { day: day + delay, sample: Sample { at: BEGIN.plus_days(day), d } });
            day += self.interval_days * rng.random_range(2.0 / 3.0..4.0 / 3.0);
        }
        arrivals.sort_by(|a, b| a.day.total_cmp(&b.day));
        arrivals
    }

    pub fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }
}

/// An alert that began to fire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fired {
    pub coefficient: Coefficient,
    pub rule: Rule,
    /// When the record that raised it arrived.
    pub day: f64,
    /// Records that had arrived by then, that one included.
    pub records: usize,
}

/// Judges one gyro's records as they arrive and collects every alert that begins to fire.
pub fn replay(arrivals: &[Arrival], limits: &Limits) -> Vec<Fired> {
    let policy = Policy::default();
    let (mut samples, mut alerts, mut fired) = (Series::default(), BTreeMap::<_, Alert>::new(), Vec::new());
    let mut verdicts: Vec<Verdict> = Vec::new();
    for (i, arrival) in arrivals.iter().enumerate() {
        samples.insert([arrival.sample]);
        let newest = samples.len() - 1;
        let history = History::of(&samples, &samples[..BASELINE_RECORDS.min(samples.len())], &[]);
        verdicts.clear();
        judge(&history, newest, limits, &mut verdicts);
        let now = BEGIN.plus_days(arrival.day);
        for verdict in &verdicts {
            let key = (verdict.coefficient, verdict.rule);
            let decision = follow(alerts.get(&key), verdict, samples[newest].at, now, &policy);
            alerts.extend(decision.alert.map(|alert| (key, alert)));
            if decision.action == Action::Fire {
                fired.push(Fired {
                    coefficient: verdict.coefficient,
                    rule: verdict.rule,
                    day: arrival.day,
                    records: i + 1,
                });
            }
        }
    }
    fired
}
