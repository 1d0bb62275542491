//! A fleet to look at: a dozen IMUs, two stations, two years, and what happens to gyros in that time.
//!
//! Everything is drawn from one seed, so the same fleet comes out every day; only its dates count back from the last
//! Friday.
//! G follows from eq. (5)'s linear terms seen through the actual triad: G = |E| (D_I I + D_S S + D_O O).

use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::input::{DemoInput, bench_body, gyro_body, record_body};
use crate::core::bench::BenchMethod;
use crate::core::mounting::{Geometry, Slot};
use crate::core::time::UtcMicros;
use crate::core::units::radians_from_arcmin;
use crate::wire::bench::BenchBody;
use crate::wire::geometry::{GeometryBody, NamedGeometry};
use crate::wire::record::{GyroBody, RecordBody};
use crate::wire::time;

const SEED: u64 = 20150115;
pub const DAYS: f64 = 730.0;
const IMUS: usize = 12;
const SPARES: usize = 2;
/// How D_I and D_S of a steady gyro age, standard deviation over the fleet, deg/(h g0) a year: nothing that two years
/// would show.
const AGEING: f64 = 1e-4;
/// Scatter of D_I and D_S from campaign to campaign, deg/(h g0): a sixteenth of the budget.
const SCATTER: f64 = 6e-4;
/// Standard deviation of E, pulse/arcsec: what rate dwells of a two-axis table leave.
const E_SD: f64 = 3e-6;

/// What sets a gyro apart from its steady neighbours. Numbers count from 0: gyro 3 is LFG-0004.
mod stories {
    /// LFG-0004: D_I rises, and reaches the budget within the year.
    pub const RISING: (usize, f64) = (3, 0.013);
    /// LFG-0014: D_I begins to age, well within the budget: the control rules alone warn.
    pub const AGEING: (usize, f64, f64) = (13, 0.012, 520.0);
    /// LFG-0008: D_S jumps when its IMU is transported.
    pub const JUMPING: (usize, f64, f64) = (7, 430.0, 0.031);
    /// LFG-0011: D_S falls until it is taken out, repaired, and put into another IMU.
    pub const FALLING: (usize, f64) = (10, -0.021);
    pub const TAKEN_OUT: f64 = 395.0;
    pub const BACK: f64 = 448.0;
    /// Before a bench tests it, and it goes back.
    pub const REPAIRED: f64 = BACK - 3.0;
    /// LFG-0016 and LFG-0019 change places.
    pub const SWAPPED: (usize, usize, f64) = (15, 18, 301.0);
    /// LFG-0031: a bearing that does not settle.
    pub const RESTLESS: (usize, f64) = (30, 7.0);
    /// IMU-10 is taken off its frame and mounted again: the closures of its gyros move, D_I and D_S do not.
    pub const REMOUNTED: (usize, f64) = (9, 515.0);
    /// IMU-12 is forgotten.
    pub const FORGOTTEN: (usize, f64) = (11, 560.0);
    /// ST-2's oven runs warm for a fortnight: D_I of all that it measures then is off, by less than the budget.
    pub const WARM_OVEN: (&str, f64, f64, f64) = ("ST-2", 600.0, 614.0, 0.004);
}

/// The truth about one gyro.
struct Gyro {
    serial: String,
    /// D_I and D_S at the beginning, deg/(h g0).
    start: [f64; 2],
    /// Their slopes, deg/(h g0) per year.
    slope: [f64; 2],
    scatter: f64,
    /// |E|, pulse/arcsec.
    scale: f64,
}

/// A gyro in its place for a while. Every installation has its own mounting.
struct Installation {
    imu: usize,
    slot: Slot,
    gyro: usize,
    from: f64,
    to: f64,
    /// From the nominal triad to the actual one.
    mounting: Rotation3<f64>,
}

pub fn draw(today: UtcMicros) -> Vec<DemoInput> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let gyros: Vec<Gyro> = (0..3 * IMUS + SPARES).map(|n| Gyro::draw(n, &mut rng)).collect();
    let seats = seats(&mut rng);
    let first_day = today.plus_days(-DAYS);
    let mut inputs = Vec::new();
    for imu in 0..IMUS {
        for day in calibration_days(imu, &mut rng) {
            let record = record(imu, day, instant(first_day, day), &gyros, &seats, &mut rng);
            inputs.push(DemoInput::Record(Box::new(record)));
        }
    }
    for (gyro, day) in [(3, 1.0), (7, 1.2), (10, 1.4), (15, 1.6), (10, stories::BACK - 0.8), (36, 380.0)] {
        for method in [BenchMethod::TorqueFeedback, BenchMethod::TurntableServo] {
            inputs.push(DemoInput::Bench(bench(&gyros[gyro], gyro, day, method, first_day, &mut rng)));
        }
    }
    inputs.push(DemoInput::Repair {
        serial: gyros[stories::FALLING.0].serial.clone(),
        at: time::format(instant(first_day, stories::REPAIRED)),
        reason: "rotor bearing replaced, rebalanced; goes into IMU-09".into(),
    });
    inputs
}

impl Gyro {
    fn draw(n: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut slope = [normal(rng, AGEING), normal(rng, AGEING)];
        let mut scatter = SCATTER;
        let start = [normal(rng, 2.5), normal(rng, 4.0)];
        match n {
            _ if n == stories::RISING.0 => slope[0] = stories::RISING.1,
            _ if n == stories::FALLING.0 => slope[1] = stories::FALLING.1,
            _ if n == stories::RESTLESS.0 => scatter *= stories::RESTLESS.1,
            _ => {}
        }
        // Table 3 asks for a little more of the third gyro.
        let scale = if n % 3 == 2 { 1.4775 } else { 1.4680 } + normal(rng, 4e-4);
        Self { serial: format!("LFG-{:04}", n + 1), start, slope, scatter, scale }
    }

    /// D_I and D_S on a day, without scatter.
    fn drift(&self, number: usize, day: f64) -> [f64; 2] {
        let [mut d_i, mut d_s] = [0, 1].map(|c| self.start[c] + self.slope[c] * day / 365.25);
        let (ageing, per_year, since) = stories::AGEING;
        if number == ageing {
            d_i += per_year * (day - since).max(0.0) / 365.25;
        }
        if number == stories::JUMPING.0 && day >= stories::JUMPING.1 {
            d_s += stories::JUMPING.2;
        }
        if number == stories::FALLING.0 && day >= stories::REPAIRED {
            // Rebalanced: another level, and it stays there.
            (d_i, d_s) = (self.start[0] - 0.62, self.start[1] + 0.35);
        }
        [d_i, d_s]
    }
}

/// Who sits where and when: three gyros an IMU, in order of their numbers, and the moves of [`stories`].
fn seats(rng: &mut ChaCha8Rng) -> Vec<Installation> {
    let (out, back) = (stories::TAKEN_OUT, stories::BACK);
    let (one, other, swapped) = stories::SWAPPED;
    let (remounted, remounted_on) = stories::REMOUNTED;
    let mut seats = Vec::new();
    let mut sit = |place: usize, gyro: usize, from: f64, to: f64| {
        let (imu, slot) = (place / 3, Slot::ALL[place % 3]);
        let mounting = mounting(slot, rng);
        seats.push(Installation { imu, slot, gyro, from, to, mounting });
    };
    let (spare, displaced, falling) = (3 * IMUS, 25, stories::FALLING.0);
    for place in 0..3 * IMUS {
        match place {
            _ if place == one || place == other => {
                sit(place, place, 0.0, swapped);
                sit(place, if place == one { other } else { one }, swapped, DAYS);
            }
            _ if place == falling => {
                sit(place, falling, 0.0, out);
                sit(place, spare, out, DAYS);
            }
            _ if place == displaced => {
                sit(place, displaced, 0.0, back);
                sit(place, falling, back, DAYS);
            }
            _ if place / 3 == remounted => {
                sit(place, place, 0.0, remounted_on);
                sit(place, place, remounted_on, DAYS);
            }
            _ => sit(place, place, 0.0, DAYS),
        }
    }
    seats
}

/// An arc minute of tilt, which E shows, and half a degree of clocking about I, which only the closure shows.
fn mounting(slot: Slot, rng: &mut ChaCha8Rng) -> Rotation3<f64> {
    let input = Geometry::Skewed.triad(slot).expect("the skewed geometry names every slot").input();
    let clocking = Rotation3::new(input * normal(rng, 0.5_f64.to_radians()));
    Rotation3::new(Vector3::from_fn(|_, _| normal(rng, radians_from_arcmin(1.0)))) * clocking
}

/// Every three weeks or so, and again two days later after every fifth (the environmental tests).
fn calibration_days(imu: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let end = if imu == stories::FORGOTTEN.0 { stories::FORGOTTEN.1 } else { DAYS - 1.0 };
    let (mut day, mut days) = (4.0 + 1.7 * imu as f64, Vec::new());
    while day < end {
        days.push(day);
        if days.len() % 6 == 5 {
            days.push((day + 2.0).min(end));
        }
        day += rng.random_range(16.0..27.0);
    }
    days
}

fn station(imu: usize, day: f64) -> &'static str {
    let moved = imu == 4 && day >= 365.0;
    if imu.is_multiple_of(2) && !moved { "ST-1" } else { "ST-2" }
}

fn record(
    imu: usize,
    day: f64,
    at: UtcMicros,
    gyros: &[Gyro],
    seats: &[Installation],
    rng: &mut ChaCha8Rng,
) -> RecordBody {
    let station = station(imu, day);
    let seated = seats.iter().filter(|seat| seat.imu == imu && (seat.from..seat.to).contains(&day));
    let geometry = GeometryBody::Named(NamedGeometry::Skewed);
    RecordBody {
        gyros: seated.map(|seat| parameters(seat, &gyros[seat.gyro], station, day, rng)).collect(),
        temperature_c: Some(rounded(45.0 + normal(rng, 0.05), 1e2)),
        ..record_body(format!("IMU-{:02}", imu + 1), station, at, geometry)
    }
}

/// E and G as the station's fit gives them: the gyro's rows in body axes, and their scatter.
fn parameters(seat: &Installation, gyro: &Gyro, station: &str, day: f64, rng: &mut ChaCha8Rng) -> GyroBody {
    let nominal = Geometry::Skewed.triad(seat.slot).expect("the skewed geometry names every slot");
    let [input, spin] = [nominal.input(), nominal.spin()].map(|axis| seat.mounting * axis);
    let [mut d_i, d_s] = gyro.drift(seat.gyro, day);
    let (warm, from, to, off) = stories::WARM_OVEN;
    if station == warm && (from..to).contains(&day) {
        d_i += off;
    }
    let g_sd = gyro.scale * SCATTER;
    let noise = Vector3::from_fn(|_, _| normal(rng, gyro.scale * gyro.scatter));
    let e = (gyro.scale * input).map(|x| rounded(x + normal(rng, E_SD), 1e7));
    let g = (gyro.scale * (d_i * input + d_s * spin) + noise).map(|x| rounded(x, 1e6));
    GyroBody {
        e_sd: Some(Vector3::repeat(E_SD).into()),
        g_sd: Some(Vector3::repeat(rounded(g_sd, 1e7)).into()),
        ..gyro_body(seat.slot, &gyro.serial, e, g)
    }
}

fn bench(
    gyro: &Gyro,
    number: usize,
    day: f64,
    method: BenchMethod,
    first_day: UtcMicros,
    rng: &mut ChaCha8Rng,
) -> BenchBody {
    let later = if method == BenchMethod::TorqueFeedback { 0.0 } else { 0.3 };
    let drift = gyro.drift(number, day).map(|d| rounded(d + normal(rng, 4e-4), 1e6));
    let body = bench_body(&gyro.serial, "BENCH-1", instant(first_day, day + later), drift);
    BenchBody { method, d_i_sd: Some(4e-4), d_s_sd: Some(4e-4), ..body }
}

/// To the minute: nobody writes down more.
fn instant(first_day: UtcMicros, day: f64) -> UtcMicros {
    let at = first_day.plus_days(day).0;
    UtcMicros(at - at.rem_euclid(60 * UtcMicros::SECOND))
}

fn normal(rng: &mut ChaCha8Rng, sd: f64) -> f64 {
    let z: f64 = rng.sample(StandardNormal);
    sd * z
}

/// `x` to so many parts of one, as a station would print it.
fn rounded(x: f64, parts: f64) -> f64 {
    (x * parts).round() / parts
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::core::judge::{Event, History, LimitKind, Limits, Mark, Measured, Sample, Seat, Series, State, judge};
    use crate::core::record::{Plausibility, Record};
    use crate::core::separate::separate;

    const TODAY: UtcMicros = UtcMicros(20_400 * UtcMicros::DAY);

    fn records() -> Vec<Record> {
        let record = |happening| match happening {
            DemoInput::Record(body) => Some(body.to_core(&Plausibility::default()).expect("a record without fault")),
            _ => None,
        };
        let mut records: Vec<Record> = draw(TODAY).into_iter().filter_map(record).collect();
        records.sort_by_key(|record| record.calibrated_at);
        records
    }

    /// (day, D_I, D_S, D_O) of every gyro, oldest first, by the rigid method.
    fn histories() -> BTreeMap<String, Vec<[f64; 4]>> {
        let mut histories = BTreeMap::<_, Vec<_>>::new();
        for record in records() {
            for gyro in &record.gyros {
                let s = separate(&record.geometry, gyro.slot, &gyro.e, &gyro.g, None).expect("separable").rigid;
                let day = record.calibrated_at.days_since(TODAY) + DAYS;
                histories.entry(gyro.serial.to_string()).or_default().push([day, s.d_i, s.d_s, s.d_o]);
            }
        }
        histories
    }

    fn mean(history: &[[f64; 4]], column: usize, days: std::ops::Range<f64>) -> f64 {
        let chosen: Vec<f64> = history.iter().filter(|p| days.contains(&p[0])).map(|p| p[column]).collect();
        assert!(chosen.len() >= 3, "{days:?} holds {} records", chosen.len());
        chosen.iter().sum::<f64>() / chosen.len() as f64
    }

    #[test]
    fn the_fleet_is_what_a_station_could_send() {
        let records = records();
        let imus: std::collections::BTreeSet<_> = records.iter().map(|r| r.imu.as_str()).collect();
        let stations: std::collections::BTreeSet<_> = records.iter().map(|r| r.station.as_str()).collect();
        assert_eq!((imus.len(), stations.len()), (IMUS, 2));
        assert!(records.len() > 400, "{}", records.len());
        assert!(records.iter().all(|r| r.gyros.len() == 3 && r.calibrated_at < TODAY));
        assert!(records.iter().all(|r| r.calibrated_at.days_since(TODAY) > -DAYS));
    }

    #[test]
    fn the_same_fleet_comes_out_every_time() {
        assert_eq!(records(), records());
    }

    #[test]
    fn gyros_drift_jump_fall_and_come_back_repaired() {
        let histories = histories();
        let change = |serial: &str, column, before, after| {
            mean(&histories[serial], column, after) - mean(&histories[serial], column, before)
        };
        assert!((change("LFG-0004", 1, 0.0..100.0, 630.0..730.0) - 0.013 * 630.0 / 365.25).abs() < 2e-3);
        assert!((change("LFG-0008", 2, 330.0..430.0, 431.0..531.0) - 0.031).abs() < 2e-3);
        assert!((change("LFG-0011", 2, 0.0..100.0, 295.0..395.0) + 0.021 * 295.0 / 365.25).abs() < 3e-3);
        assert!(change("LFG-0011", 1, 295.0..395.0, 449.0..549.0) < -0.5);
        // The others hold their level well within the budget.
        assert!(change("LFG-0001", 1, 0.0..100.0, 630.0..730.0).abs() < 5e-3);
    }

    #[test]
    fn a_bench_tests_the_gyro_after_its_repair_and_finds_what_the_next_calibration_does() {
        let histories = histories();
        let (serial, mut repaired, mut tested) = ("LFG-0011", None, Vec::new());
        for happening in draw(TODAY) {
            match happening {
                DemoInput::Repair { at, .. } => repaired = Some(time::parse(&at).expect("a time")),
                DemoInput::Bench(bench) if bench.serial == serial => tested.push(bench),
                _ => {}
            }
        }
        let repaired = repaired.expect("a repair");
        let after: Vec<&BenchBody> =
            tested.iter().filter(|bench| time::parse(&bench.measured_at).expect("a time") > repaired).collect();
        assert_eq!((tested.len(), after.len()), (4, 2));
        let next = histories[serial].iter().find(|point| point[0] > stories::BACK - 1.0).expect("it is back");
        for bench in after {
            let apart = (bench.d_i_deg_per_h_g0 - next[1]).abs().max((bench.d_s_deg_per_h_g0 - next[2]).abs());
            assert!(apart < 5e-3, "{apart}");
        }
    }

    #[test]
    fn moves_and_remounting_show_in_the_closure_alone() {
        let histories = histories();
        for (serial, day) in [("LFG-0016", 301.0), ("LFG-0019", 301.0), ("LFG-0028", 515.0)] {
            let change = |column| {
                let history = &histories[serial];
                mean(history, column, day..day + 100.0) - mean(history, column, day - 100.0..day)
            };
            assert!(change(3).abs() > 3e-3, "{serial}: closure {}", change(3));
            assert!(change(1).abs() < 2e-3 && change(2).abs() < 3e-3, "{serial}: {} {}", change(1), change(2));
        }
    }

    /// What most of a fleet is: who looks at it learns what a state means from the few that are not.
    #[test]
    fn most_gyros_keep_their_limits_and_those_with_a_story_break_them() {
        let (mut broken, mut warned) = (BTreeSet::new(), BTreeSet::new());
        for (serial, history) in histories() {
            let sd = Some(SCATTER);
            let measured = |value: f64| Measured { value, sd };
            let sample = |[day, d_i, d_s, d_o]: [f64; 4]| Sample {
                at: TODAY.plus_days(day - DAYS),
                seat: Seat::default(),
                station: 0,
                d: [measured(d_i), measured(d_s), measured(d_o)],
            };
            let samples: Vec<Sample> = history.into_iter().map(sample).collect();
            let repaired = serial == "LFG-0011";
            let mark = Mark::of(TODAY.plus_days(stories::REPAIRED - DAYS), Event::Repair);
            let series = Series::new(samples, if repaired { vec![mark] } else { Vec::new() });
            let (mut verdicts, newest) = (Vec::new(), series.len() - 1);
            judge(&History::whole(&series, newest), newest, &Limits::default(), &mut verdicts);
            for verdict in verdicts.iter().filter(|verdict| verdict.state == State::Exceeded) {
                let control = verdict.rule.limit_kind() == LimitKind::Control;
                if control {
                    warned.insert(serial.clone())
                } else {
                    broken.insert(serial.clone())
                };
            }
        }
        warned.retain(|serial| !broken.contains(serial));
        let named: Vec<&str> = broken.iter().map(String::as_str).collect();
        assert_eq!(named, ["LFG-0004", "LFG-0008", "LFG-0016", "LFG-0029", "LFG-0031"]);
        assert_eq!(warned.iter().map(String::as_str).collect::<Vec<_>>(), ["LFG-0014"]);
    }

    #[test]
    fn one_imu_is_overdue() {
        let last = |imu: &str| records().iter().filter(|r| r.imu.as_str() == imu).map(|r| r.calibrated_at).max();
        assert!(TODAY.days_since(last("IMU-12").expect("it has records")) > 150.0);
        assert!(TODAY.days_since(last("IMU-01").expect("it has records")) < 30.0);
    }
}
