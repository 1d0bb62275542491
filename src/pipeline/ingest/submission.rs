//! What can be submitted, and reading it: parsed, checked and separated before anything queues.

use std::sync::Arc;

use crate::config::PlausibilityKeys;
use crate::core::bench::BenchResult;
use crate::core::fault::{Fault, Faults};
use crate::core::history_note::is_unset;
use crate::core::judge::{Event, FixedLevels, Verdict};
use crate::core::message::text;
use crate::core::mounting::Slot;
use crate::core::record::{GyroParameters, Name, Plausibility, Record};
use crate::core::separate::{CovarianceEg, Separation, Unseparable, separate, stated_covariance};
use crate::core::time::UtcMicros;
use crate::message;
use crate::pipeline::{Actor, Pipeline};
use crate::store::{Id, Kind};
use crate::system::sha256;
use crate::wire::bench::parse_bench_result;
use crate::wire::json::without_mark;
use crate::wire::record::parse_record;
use crate::wire::time;

/// Something to store.
#[derive(Debug, Clone)]
pub enum Submission {
    Calibration(Box<Calibration>),
    Bench(Box<BenchTest>),
    Event(GyroEvent),
    Correction(Box<Correction>),
    Confirmation(Confirmation),
}

impl Submission {
    /// The calibration that it brings.
    pub fn calibration(&self) -> Option<&Calibration> {
        match self {
            Self::Calibration(calibration) => Some(calibration),
            Self::Correction(correction) => correction.replacement.as_ref(),
            Self::Bench(_) | Self::Event(_) | Self::Confirmation(_) => None,
        }
    }

    /// The station that it was measured at; none for what people say.
    pub fn station(&self) -> Option<&str> {
        match self {
            Self::Calibration(calibration) => Some(calibration.station.as_str()),
            Self::Bench(bench) => Some(bench.result.station.as_str()),
            Self::Correction(correction) => correction.replacement.as_ref().map(|new| new.station.as_str()),
            Self::Event(_) | Self::Confirmation(_) => None,
        }
    }
}

/// A stored item is to count no more: it is voided, or revised by what stands in its place.
#[derive(Debug, Clone)]
pub struct Correction {
    pub item: Corrected,
    pub author: String,
    pub reason: String,
    pub replacement: Option<Calibration>,
    pub by: Actor,
}

/// The time of a record that was set aside is right: it counts from now on.
#[derive(Debug, Clone)]
pub struct Confirmation {
    pub id: Id,
    pub author: String,
    pub reason: String,
    pub by: Actor,
}

/// What is corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corrected {
    /// A record, or a campaign; of a certain kind, where one is named.
    Calibration {
        id: Id,
        kind: Option<Kind>,
    },
    Bench(Id),
}

impl Corrected {
    pub fn id(self) -> Id {
        match self {
            Self::Calibration { id, .. } | Self::Bench(id) => id,
        }
    }
}

/// An IMU's calibration, separated: from a record, or from a campaign that was fitted here.
#[derive(Debug, Clone)]
pub struct Calibration {
    pub kind: Kind,
    pub imu: Name,
    pub station: Name,
    pub calibrated_at: UtcMicros,
    /// The adopted model that it was fitted with, if it was one.
    pub model: Option<Id>,
    pub gyros: Vec<CalibratedGyro>,
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    pub idempotency_key: Option<String>,
}

#[derive(Debug, Clone)]
pub struct CalibratedGyro {
    /// Its place among the gyros that were sent: a campaign's gyro that cannot be separated is not among these.
    pub place: usize,
    pub slot: Slot,
    pub serial: Name,
    pub separation: Separation,
    /// On E and G, which need no history.
    pub requirements: [Option<Verdict>; 2],
}

#[derive(Debug, Clone)]
pub struct BenchTest {
    pub result: BenchResult,
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    pub idempotency_key: Option<String>,
}

/// Something that was done to a gyro.
#[derive(Debug, Clone)]
pub struct GyroEvent {
    pub serial: Name,
    pub at: UtcMicros,
    pub event: Event,
    /// When it was over, of what took time.
    pub until: Option<UtcMicros>,
    /// Which environmental test it was.
    pub test: Option<String>,
    /// Levels that a baseline mark states.
    pub fixed: FixedLevels,
    pub reason: String,
    pub author: Option<String>,
    /// Who says so.
    pub by: Actor,
}

impl Pipeline {
    /// Reads, checks and separates a record.
    ///
    /// # Errors
    /// Every fault, by its pointer.
    pub fn read_record(&self, bytes: &[u8]) -> Result<Calibration, Faults> {
        let record = parse_record(bytes, &self.config.plausibility.limits())?;
        let serials = record.gyros.iter().map(|gyro| &gyro.serial);
        check_names(&[("/imu", &record.imu), ("/station", &record.station)], serials)?;
        self.check_time("/calibrated_at", record.calibrated_at)?;
        self.separated(record, bytes)
    }

    /// Reads a stored record: it was plausible once, whatever today's limits are.
    pub(crate) fn reread_record(&self, body: &str) -> Result<Calibration, Faults> {
        self.separated(parse_record(body.as_bytes(), &anything())?, body.as_bytes())
    }

    fn separated(&self, record: Record, bytes: &[u8]) -> Result<Calibration, Faults> {
        let gyros = record.gyros.iter().enumerate().map(|(i, gyro)| {
            let covariance = stated_covariance(gyro);
            self.calibrated(&record, (i, gyro), covariance.as_ref()).map_err(|why| {
                Fault { pointer: format!("/gyros/{i}/e_pulse_per_arcsec"), message: why.message() }.into()
            })
        });
        let gyros = gyros.collect::<Result<_, Faults>>()?;
        let Record { imu, station, calibrated_at, .. } = record;
        let (body, body_sha256) = kept(bytes)?;
        Ok(Calibration {
            kind: Kind::Record,
            imu,
            station,
            calibrated_at,
            model: None,
            gyros,
            body,
            body_sha256,
            idempotency_key: None,
        })
    }

    /// Separates one gyro and holds it to the requirements.
    ///
    /// # Errors
    /// Why E and G cannot be separated.
    pub fn calibrated(
        &self,
        Record { geometry, imu, .. }: &Record,
        (place, gyro): (usize, &GyroParameters),
        covariance: Option<&CovarianceEg>,
    ) -> Result<CalibratedGyro, Unseparable> {
        let separation = separate(geometry, gyro.slot, &gyro.e, &gyro.g, covariance)?;
        let (whose, sds) = ((gyro.slot, imu, &gyro.serial), (gyro.e_sd.as_ref(), gyro.g_sd.as_ref()));
        let requirements = self.config.judging.of_parameters(geometry, whose, (&gyro.e, &gyro.g), sds);
        Ok(CalibratedGyro { place, slot: gyro.slot, serial: gyro.serial.clone(), separation, requirements })
    }

    /// Reads and checks a bench result.
    ///
    /// # Errors
    /// Every fault, by its pointer.
    pub fn read_bench_result(&self, bytes: &[u8]) -> Result<BenchTest, Faults> {
        let result = parse_bench_result(bytes, self.config.plausibility.max_drift_deg_per_h_g0)?;
        check_names(&[("/serial", &result.serial), ("/station", &result.station)], [].into_iter())?;
        self.check_time("/measured_at", result.measured_at)?;
        let (body, body_sha256) = kept(bytes)?;
        Ok(BenchTest { result, body, body_sha256, idempotency_key: None })
    }

    /// Refuses a time that cannot be: the sender's clock is wrong, or its year. What lies too far ahead of the clock would stay the newest
    /// for as long, what lies long before all else would become the baseline.
    pub fn check_time(&self, pointer: &str, at: UtcMicros) -> Result<(), Faults> {
        let PlausibilityKeys { max_future_hours: hours, earliest, clock_epochs, .. } = &self.config.plausibility;
        let message = if at > self.clock.now().plus_days(hours / 24.0) {
            message!("time_in_future", hours = text(hours))
        } else if at < *earliest {
            message!("before_earliest", earliest = text(time::format(*earliest)))
        } else if is_unset(at) && clock_epochs.contains(&UtcMicros(0)) {
            message!("clock_never_set")
        } else {
            return Ok(());
        };
        Err(Fault { pointer: pointer.to_owned(), message }.into())
    }
}

/// Refuses new names in which something cannot be seen; what is stored under such a name is read all the same.
pub(crate) fn check_names<'a>(named: &[(&str, &Name)], serials: impl Iterator<Item = &'a Name>) -> Result<(), Faults> {
    let mut faults = Faults::default();
    for (pointer, name) in named {
        name.check_seen().unwrap_or_else(|detail| faults.push(*pointer, detail));
    }
    for (i, serial) in serials.enumerate() {
        serial.check_seen().unwrap_or_else(|detail| faults.push(format!("/gyros/{i}/serial"), detail));
    }
    faults.or(())
}

/// The body as it is kept, without a byte-order mark, and its hash.
pub(crate) fn kept(bytes: &[u8]) -> Result<(Arc<str>, [u8; 32]), Faults> {
    let bytes = without_mark(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        Faults::from(Fault { pointer: String::new(), message: message!("not_utf8", why = text(error)) })
    })?;
    Ok((text.into(), sha256(bytes)))
}

/// Limits that refuse nothing that was ever stored.
pub(crate) fn anything() -> Plausibility {
    Plausibility {
        scale_factor: (f64::MIN_POSITIVE, f64::MAX),
        max_misalignment: f64::INFINITY,
        max_drift: f64::INFINITY,
    }
}
