//! Fleets with a hidden cause: IMUs of three gyros, calibrated by one or two stations at irregular times.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::core::changes::{ChangeCause, GyroHistory, HistoryEntry};
use crate::core::judge::{Event, Mark, Measured};
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::time::UtcMicros;

named! {
    /// What is hidden in a fleet.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum HiddenCause {
        Nothing = "nothing",
        Ageing = "ageing",
        StepAtEvent = "step_at_event",
        Step = "step",
        Temperature = "temperature",
        TemperatureMissing = "temperature_missing",
        StationOffset = "station_offset",
        StationDrifts = "station_drifts",
        StationRelevelled = "station_relevelled",
        StationOff = "station_off_for_weeks",
        OneOfTwoDrifts = "one_of_two_drifts",
        MovedWithPeers = "moved_with_peers",
        StepAtStationChange = "step_at_station_change",
        Clocking = "clocking",
        AgeingAndStation = "ageing_and_station",
        NoisyStation = "noisy_station",
        LoneImuMoved = "lone_imu_moved",
        Wanders = "wanders",
        AgeingLate = "ageing_late",
        StationDriftsLate = "station_drifts_late",
    }
}

/// Records of a gyro that the service would hold, with the truth beside them.
#[derive(Debug, Clone)]
pub struct DrawnFleet {
    pub kind: HiddenCause,
    pub gyros: Vec<GyroHistory>,
    /// The gyro and the column (D_I, D_S, D_O) that are asked about.
    pub asked: usize,
    pub column: usize,
    /// Causes that the asked coefficient has.
    pub truth: Vec<ChangeCause>,
    /// Causes that have to be in the class of what is named.
    pub class: Vec<ChangeCause>,
    /// What they did to each record of the asked gyro, deg/(h g0).
    pub signal: Vec<f64>,
    /// How the asked coefficient ages, where its date is asked for.
    pub ageing: Option<Ageing>,
    /// Whether every gyro shows the asked column's cause too.
    pub shared: bool,
}

pub(super) const YEAR_DAYS: f64 = 365.25;

/// A level, and a slope a year from so many years after the first record on.
#[derive(Debug, Clone, Copy)]
pub struct Ageing {
    pub level: f64,
    pub slope: f64,
    pub begins: f64,
}

/// How far the asked coefficient may be from where it began, and when it will be there.
#[derive(Debug, Clone, Copy)]
pub struct HiddenBudget {
    pub baseline: f64,
    pub limit: f64,
    /// From the first record on.
    pub years_from_first: f64,
}

impl DrawnFleet {
    /// Half as far again as the coefficient has aged by the newest record.
    pub fn budget(&self) -> Option<HiddenBudget> {
        let Ageing { level, slope, begins } = self.ageing?;
        let limit = 1.5 * slope.abs() * (self.years(self.signal.len() - 1) - begins);
        Some(HiddenBudget { baseline: level, limit, years_from_first: begins + limit / slope.abs() })
    }

    pub(super) fn entries(&self) -> &[HistoryEntry] {
        &self.gyros[self.asked].entries
    }

    /// From the asked gyro's first record to its record `k`.
    pub(super) fn years(&self, k: usize) -> f64 {
        self.entries()[k].at.days_since(self.entries()[0].at) / YEAR_DAYS
    }
}

pub struct FleetDraw {
    rng: ChaCha8Rng,
}

/// When, where and how warm the records of one IMU are.
struct Occasion {
    years: f64,
    station: usize,
    temperature_c: f64,
}

/// How large each cause is, and when it begins.
struct Sizes {
    step: f64,
    /// A year.
    slope: f64,
    /// As far by the end, from the instant on.
    late_slope: f64,
    per_kelvin: f64,
    offset: f64,
    station_slope: f64,
    late_station_slope: f64,
    /// Years.
    instant: f64,
    /// Of each record.
    walk: Vec<f64>,
    /// The station is off between these, years.
    off: [f64; 2],
}

impl Sizes {
    /// What record `k` of the asked gyro shows of a cause of its own. `turned`: what clocking takes of D_S.
    fn of_gyro(&self, kind: HiddenCause, k: usize, occasion: &Occasion, turned: f64) -> f64 {
        let &Occasion { years, station, temperature_c } = occasion;
        match kind {
            HiddenCause::Ageing | HiddenCause::NoisyStation | HiddenCause::AgeingAndStation => self.slope * years,
            HiddenCause::AgeingLate => self.late_slope * (years - self.instant).max(0.0),
            HiddenCause::StepAtEvent | HiddenCause::Step if years >= self.instant => self.step,
            HiddenCause::StepAtStationChange if station == 1 => self.step,
            HiddenCause::Temperature | HiddenCause::TemperatureMissing => self.per_kelvin * temperature_c,
            HiddenCause::Clocking => turned,
            HiddenCause::Wanders => self.walk[k],
            _ => 0.0,
        }
    }

    /// What every gyro shows of a cause of its station.
    fn of_station(&self, kind: HiddenCause, occasion: &Occasion) -> f64 {
        let &Occasion { years, station, .. } = occasion;
        match kind {
            HiddenCause::StationOffset
            | HiddenCause::MovedWithPeers
            | HiddenCause::LoneImuMoved
            | HiddenCause::AgeingAndStation
                if station == 1 =>
            {
                self.offset
            }
            HiddenCause::StationDrifts => self.station_slope * years,
            HiddenCause::StationDriftsLate if station == 0 => self.late_station_slope * (years - self.instant).max(0.0),
            HiddenCause::OneOfTwoDrifts if station == 1 => 1.5 * self.station_slope * years,
            HiddenCause::StationRelevelled if years >= self.instant => self.step,
            HiddenCause::StationOff if (self.off[0]..self.off[1]).contains(&years) => self.step,
            _ => 0.0,
        }
    }

    /// How a coefficient ages that is at `level` before, where its date is asked for.
    fn ageing(&self, kind: HiddenCause, level: f64, first: f64) -> Option<Ageing> {
        match kind {
            HiddenCause::Ageing | HiddenCause::NoisyStation => {
                Some(Ageing { level: level + self.slope * first, slope: self.slope, begins: 0.0 })
            }
            HiddenCause::AgeingLate => Some(Ageing { level, slope: self.late_slope, begins: self.instant - first }),
            _ => None,
        }
    }
}

impl HiddenCause {
    /// Causes that the asked coefficient has.
    fn truth(self) -> Vec<ChangeCause> {
        match self {
            Self::Nothing | Self::Wanders => vec![],
            Self::Ageing | Self::NoisyStation | Self::AgeingLate => vec![ChangeCause::Ageing],
            Self::StepAtEvent => vec![ChangeCause::StepAtEvent],
            Self::Step | Self::StepAtStationChange => vec![ChangeCause::Step],
            Self::Temperature | Self::TemperatureMissing => vec![ChangeCause::Temperature],
            Self::Clocking => vec![ChangeCause::Clocking],
            Self::AgeingAndStation => vec![ChangeCause::Station, ChangeCause::Ageing],
            _ => vec![ChangeCause::Station],
        }
    }
}

impl FleetDraw {
    pub fn of(seed: u64, number: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number);
        Self { rng }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.rng.random_range(low..high)
    }

    fn sign(&mut self) -> f64 {
        if self.rng.random_bool(0.5) { 1.0 } else { -1.0 }
    }

    /// Draws gyros, stations and records, with the cause of this kind hidden in one of them.
    pub fn fleet(mut self, kind: HiddenCause) -> DrawnFleet {
        let lone = kind == HiddenCause::LoneImuMoved;
        let imus = if lone { 1 } else { self.rng.random_range(5..=8) };
        let records = self.rng.random_range(20..=30);
        let span = self.between(1.5, 2.5);
        let stated = self.between(4e-4, 8e-4);
        let sigma = stated * self.between(0.85, 1.1);
        // Half of those that drift late are measured nowhere else.
        let single = match kind {
            HiddenCause::StationDrifts | HiddenCause::StationRelevelled | HiddenCause::StationOff => true,
            HiddenCause::StationDriftsLate => imus % 2 == 0,
            _ => false,
        };
        let moves =
            matches!(kind, HiddenCause::MovedWithPeers | HiddenCause::StepAtStationChange | HiddenCause::LoneImuMoved);
        let noisy = if kind == HiddenCause::NoisyStation { self.between(3.0, 6.0) } else { 1.0 };
        let (asked_imu, asked_slot) = (self.rng.random_range(0..imus), self.rng.random_range(0..3_usize));
        let column = if kind == HiddenCause::Clocking { 2 } else { self.rng.random_range(0..2_usize) };

        // The moves of a fleet: the asked IMU and some others go to the second station for good.
        let moved: Vec<bool> = (0..imus).map(|imu| imu == asked_imu || imu % 2 == asked_imu % 2).collect();
        let move_at = span * self.between(0.35, 0.65);
        let occasions: Vec<Vec<Occasion>> = (0..imus)
            .map(|imu| self.occasions(records, span, single, moves.then_some((moved[imu], move_at))))
            .collect();

        let sizes = self.sizes(kind, sigma, span, &occasions[asked_imu]);

        let mut gyros = Vec::new();
        let mut signal = Vec::new();
        let mut ageing = None;
        for (imu, occasions) in occasions.iter().enumerate() {
            for (slot, seat) in Slot::ALL.into_iter().enumerate() {
                let asked = imu == asked_imu && slot == asked_slot;
                let level = [5.0 * self.normal(), 7.0 * self.normal(), 0.03 * self.normal()];
                let clocking = self.sign() * self.between(0.02, 0.08);
                let spin = self.between(6.0, 10.0) * sigma / clocking.abs();
                let phase = self.between(0.0, 6.0);
                let mut entries = Vec::new();
                for (k, occasion) in occasions.iter().enumerate() {
                    let late = f64::from(u8::from(occasion.years >= sizes.instant));
                    let spin = spin * (0.7 * (occasion.years * 5.0 + phase).sin() + 0.8 * late);
                    let of_gyro = if asked { sizes.of_gyro(kind, k, occasion, clocking * spin) } else { 0.0 };
                    let change = of_gyro + sizes.of_station(kind, occasion);
                    let more = if occasion.station == 1 { noisy } else { 1.0 };
                    let mut d = [0, 1, 2].map(|c| level[c] + sigma * more * self.normal());
                    d[column] += change;
                    if kind == HiddenCause::Clocking && asked {
                        d[1] += spin;
                    }
                    if asked {
                        signal.push(change);
                        ageing = sizes.ageing(kind, level[column], occasions[0].years);
                    }
                    entries.push(HistoryEntry {
                        at: at(occasion.years),
                        station: Arc::from(["ST-A", "ST-B"][occasion.station]),
                        imu: Arc::from(format!("IMU-{imu}")),
                        slot: seat,
                        temperature_c: Some(45.0 + occasion.temperature_c),
                        d: d.map(|value| Measured { value, sd: Some(stated * more) }),
                    });
                }
                gyros.push(GyroHistory { entries, marks: Vec::new() });
            }
        }
        let asked = 3 * asked_imu + asked_slot;
        self.finish(kind, &mut gyros, asked, sizes.instant);
        let truth = kind.truth();
        let class = if lone { vec![ChangeCause::Station, ChangeCause::Step] } else { truth.clone() };
        let shared = truth.contains(&ChangeCause::Station);
        DrawnFleet { kind, gyros, asked, column, truth, class, signal, ageing, shared }
    }

    fn sizes(&mut self, kind: HiddenCause, sigma: f64, span: f64, occasions: &[Occasion]) -> Sizes {
        let sign = self.sign();
        let step = sign * sigma * self.between(5.0, 9.0);
        let slope = sign * sigma * self.between(7.0, 13.0) / span;
        let per_kelvin = sign * sigma * self.between(2.0, 4.0);
        let offset = self.sign() * sigma * self.between(5.0, 9.0);
        let station_slope = self.sign() * sigma * self.between(4.5, 9.0) / span;
        let instant = span * self.between(0.3, 0.7);
        let walk = self.walk(occasions, sigma, span);
        let off = if kind == HiddenCause::StationOff { self.window(occasions) } else { [0.0; 2] };
        let [late_slope, late_station_slope] = [slope, station_slope].map(|slope| slope * span / (span - instant));
        Sizes { step, slope, late_slope, per_kelvin, offset, station_slope, late_station_slope, instant, walk, off }
    }

    /// Gyros of IMUs of their own, calibrated weekly by one of two stations; nothing is hidden.
    pub fn weekly(mut self, gyros: usize, records: usize) -> Vec<GyroHistory> {
        let of_gyro = |gyro: usize| {
            let entry = |k: usize| HistoryEntry {
                at: at(k as f64 / 52.0),
                station: Arc::from(["ST-A", "ST-B"][self.rng.random_range(0..2)]),
                imu: Arc::from(format!("IMU-{gyro}")),
                slot: Slot::ALL[0],
                temperature_c: Some(45.0 + self.normal()),
                d: [3.0, 4.0, 0.02].map(|level| Measured { value: level + 5e-4 * self.normal(), sd: Some(5e-4) }),
            };
            GyroHistory { entries: (0..records).map(entry).collect(), marks: Vec::new() }
        };
        (0..gyros).map(of_gyro).collect()
    }

    /// What only some kinds have: an event, a temperature that nobody wrote down, ordinary events elsewhere.
    fn finish(&mut self, kind: HiddenCause, gyros: &mut [GyroHistory], asked: usize, instant: f64) {
        if kind == HiddenCause::StepAtEvent {
            gyros[asked].marks.push(Mark::of(at(instant), Event::Transport));
        }
        if kind == HiddenCause::TemperatureMissing {
            let n = gyros[asked].entries.len();
            let missing = self.rng.random_range(0..n);
            let first = asked - asked % 3;
            for gyro in &mut gyros[first..first + 3] {
                gyro.entries[missing].temperature_c = None;
            }
        }
    }

    fn occasions(&mut self, records: usize, span: f64, single: bool, moves: Option<(bool, f64)>) -> Vec<Occasion> {
        let regular = self.rng.random_bool(0.5);
        let share = self.between(0.35, 0.65);
        let mut years: Vec<f64> = (0..records)
            .map(|k| {
                let at =
                    if regular { k as f64 + 0.6 * self.rng.random::<f64>() } else { self.between(0.0, records as f64) };
                span * at / records as f64
            })
            .collect();
        years.sort_by(f64::total_cmp);
        let mut occasions = Vec::new();
        for years in years {
            let station = match moves {
                _ if single => 0,
                Some((moved, at)) => usize::from(moved && years >= at),
                None => usize::from(self.rng.random_bool(share)),
            };
            occasions.push(Occasion { years, station, temperature_c: self.normal() });
        }
        occasions
    }

    /// From some days before one of these to some days after it: four to nine weeks altogether, years.
    fn window(&mut self, occasions: &[Occasion]) -> [f64; 2] {
        let within = occasions[self.rng.random_range(2..occasions.len() - 2)].years;
        let long = self.between(28.0, 63.0) / YEAR_DAYS;
        let from = within - long * self.between(0.1, 0.9);
        [from, from + long]
    }

    /// A walk by record, a walk in time, or 1/f noise, of three to nine sigma altogether.
    fn walk(&mut self, occasions: &[Occasion], sigma: f64, span: f64) -> Vec<f64> {
        let size = sigma * self.between(3.0, 9.0);
        let process = self.rng.random_range(0..3);
        let n = occasions.len() as f64;
        let mut sum = 0.0;
        let mut memories = [0.0; 4];
        for memory in &mut memories {
            *memory = self.normal();
        }
        let mut before = 0.0;
        let mut out = Vec::new();
        for occasion in occasions {
            let lag = occasion.years - before;
            before = occasion.years;
            out.push(match process {
                0 => {
                    sum += size / n.sqrt() * self.normal();
                    sum
                }
                1 => {
                    sum += size * (lag / span).sqrt() * self.normal();
                    sum
                }
                _ => {
                    for (k, memory) in memories.iter_mut().enumerate() {
                        let keep = (-lag / span * 4_f64.powi(k as i32)).exp();
                        *memory =
                            keep * *memory + (1.0 - keep * keep).sqrt() * self.rng.sample::<f64, _>(StandardNormal);
                    }
                    0.5 * size * memories.iter().sum::<f64>() / 2.0
                }
            });
        }
        out
    }
}

fn at(years: f64) -> UtcMicros {
    // 2024-01-01.
    UtcMicros(1_704_067_200_000_000).plus_days(years * YEAR_DAYS)
}
