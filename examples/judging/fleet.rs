//! Gyros whose course is known, calibrated through the years, and judged as the service judges them: record by record
//! as they arrive, one alert per coefficient and rule.

use std::collections::BTreeMap;

use gyrowatch::core::alert_decision::{Action, Alert, Policy, follow};
use gyrowatch::core::judge::{
    Coefficient, FleetNoise, History, Limits, Measured, Rule, Sample, Seat, Series, State, Verdict, fit_fleet, judge,
};
use gyrowatch::core::time::UtcMicros;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// What really happens to D_I, deg/(h g0). D_S and D_O have no part in it.
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

/// How figures scatter about the course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Marginal standard deviation from campaign to campaign, deg/(h g0): the gyro's own and the station's together.
    pub scatter: f64,
    /// Correlation from one record to the next, AR(1).
    pub phi: f64,
    /// Random walk that is added, deg/(h g0) a root year.
    pub walk: f64,
    /// Student's t with 3 degrees of freedom, scaled to the same standard deviation, instead of the normal
    /// distribution.
    pub heavy_tails: bool,
}

impl Noise {
    pub const WHITE: Self = Self { scatter: 1e-3, phi: 0.0, walk: 0.0, heavy_tails: false };

    fn innovation(&self, rng: &mut ChaCha8Rng) -> f64 {
        if self.heavy_tails {
            let t: f64 = StudentT::new(3.0).expect("3 is a number of degrees of freedom").sample(rng);
            t / 3.0_f64.sqrt()
        } else {
            StandardNormal.sample(rng)
        }
    }
}

/// How the gyros of a fleet are calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fleet {
    pub course: Course,
    pub noise: Noise,
    /// Days between campaigns; each comes up to a third of it early or late.
    pub interval_days: f64,
    /// What the station reports as standard deviation; none where it reports nothing.
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
    /// D_I without its scatter.
    pub level: f64,
}

pub const BEGIN: UtcMicros = UtcMicros(1_767_225_600_000_000);

impl Fleet {
    /// Every other week, scatter a tenth of the budget, half of it reported, four years.
    pub fn of(course: Course) -> Self {
        Self { course, noise: Noise::WHITE, interval_days: 14.0, reported_sd: Some(5e-4), late: 0.0, years: 4.0 }
    }

    /// One gyro's records, in the order in which they arrive.
    pub fn arrivals(&self, rng: &mut ChaCha8Rng) -> Vec<Arrival> {
        let (mut day, mut before, mut arrivals) = (0.0, f64::NEG_INFINITY, Vec::new());
        let (mut walks, mut scatters) = ([0.0; 3], [0.0; 3].map(|_: f64| self.noise.innovation(rng)));
        while day < self.years * 365.25 {
            let mut figure = |column: usize, level: f64| {
                let z: f64 = StandardNormal.sample(rng);
                walks[column] +=
                    self.noise.walk * (if before.is_finite() { day - before } else { 0.0 } / 365.25).sqrt() * z;
                if before.is_finite() {
                    let phi = self.noise.phi;
                    scatters[column] = phi * scatters[column] + (1.0 - phi * phi).sqrt() * self.noise.innovation(rng);
                }
                let value = level + walks[column] + self.noise.scatter * scatters[column];
                Measured { value, sd: self.reported_sd }
            };
            let d = [figure(0, 3.0 + self.course.value(day)), figure(1, 5.0), figure(2, 0.0)];
            let delay = if rng.random_bool(self.late) { self.interval_days * rng.random_range(1.0..4.0) } else { 0.0 };
            let sample = Sample { at: BEGIN.plus_days(day), seat: Seat::default(), station: 0, d };
            arrivals.push(Arrival { day: day + delay, sample, level: 3.0 + self.course.value(day) + walks[0] });
            before = day;
            day += self.interval_days * rng.random_range(2.0 / 3.0..4.0 / 3.0);
        }
        arrivals.sort_by(|a, b| a.day.total_cmp(&b.day));
        arrivals
    }

    /// One gyro's records in the order of time.
    pub fn series(&self, rng: &mut ChaCha8Rng) -> Series {
        let mut samples: Vec<Sample> = self.arrivals(rng).iter().map(|arrival| arrival.sample).collect();
        samples.sort_by_key(|sample| sample.at);
        samples.into()
    }

    /// What `gyrowatch fleet-noise` would find in so many other gyros of this kind, to which nothing happens.
    pub fn constants(&self, gyros: u64) -> FleetNoise {
        let still = Self { course: Course::Stable, late: 0.0, ..*self };
        let histories: Vec<Series> = (0..gyros).map(|seed| still.series(&mut Self::rng(9_000_000 + seed))).collect();
        fit_fleet(&histories)
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
}

/// Judges one gyro's records as they arrive and collects every alert that begins to fire.
pub fn replay(arrivals: &[Arrival], limits: &Limits) -> Vec<Fired> {
    let policy = Policy::default();
    let (mut samples, mut alerts, mut fired) = (Series::default(), BTreeMap::<_, Alert>::new(), Vec::new());
    let mut verdicts: Vec<Verdict> = Vec::new();
    for arrival in arrivals {
        samples.insert([arrival.sample]);
        let newest = samples.len() - 1;
        verdicts.clear();
        judge(&History::whole(&samples, newest), newest, limits, &mut verdicts);
        let now = BEGIN.plus_days(arrival.day);
        for verdict in &verdicts {
            let key = (verdict.coefficient, verdict.rule);
            let known = alerts.get(&key);
            if known.is_none() && verdict.state != State::Exceeded {
                continue;
            }
            let decision = follow(known, verdict, samples[newest].at, now, &policy);
            alerts.extend(decision.alert.map(|alert| (key, alert)));
            if decision.action == Action::Fire {
                fired.push(Fired { coefficient: verdict.coefficient, rule: verdict.rule, day: arrival.day });
            }
        }
    }
    fired
}
