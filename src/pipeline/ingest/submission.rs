//! What can be submitted.

use crate::core::bench::BenchResult;
use crate::core::effects::Effect;
use crate::core::gyro_attributes::GyroAttributesPatch;
use crate::core::gyro_event::GyroEvent;
use crate::core::mounting::Slot;
use crate::core::name::normal_form;
use crate::core::record::{Name, Plausibility};
use crate::core::separate::Separation;
use crate::core::suspect_window::Mark;
use crate::pipeline::Caller;
use crate::pipeline::prelude::*;
use crate::system::sha256;
use crate::wire::json::without_mark;

/// Something to store.
#[derive(Debug, Clone)]
pub enum Submission {
    Calibration(Box<Calibration>),
    Bench(Box<BenchTest>),
    Event(EventOrder),
    Correction(Box<Correction>),
    Confirmation(Confirmation),
    SetAside(SetAsideOrder),
    Window(WindowMark),
    Attributes(AttributesOrder),
}

impl Submission {
    /// The calibration that it brings.
    pub fn calibration(&self) -> Option<&Calibration> {
        match self {
            Self::Calibration(calibration) => Some(calibration),
            Self::Correction(correction) => correction.replacement.as_ref(),
            _ => None,
        }
    }

    /// The station that it was measured at; none for what people say.
    pub fn station(&self) -> Option<&str> {
        match self {
            Self::Bench(bench) => Some(bench.result.station.as_str()),
            _ => self.calibration().map(|sent| sent.station.as_str()),
        }
    }

    /// The key that it bears, and the hash of what was sent under it.
    pub fn key(&self) -> Option<(&str, &[u8; 32])> {
        let (key, hash) = match self {
            Self::Calibration(sent) => (&sent.idempotency_key, &sent.body_sha256),
            Self::Bench(sent) => (&sent.idempotency_key, &sent.body_sha256),
            _ => return None,
        };
        Some((key.as_deref()?, hash))
    }

    /// With the key under which its sender may send it again.
    pub fn with_key(mut self, key: Option<String>) -> Self {
        match &mut self {
            Self::Calibration(sent) => sent.idempotency_key = key,
            Self::Bench(sent) => sent.idempotency_key = key,
            _ => {}
        }
        self
    }

    /// The gyro that it is about, where it is about one alone.
    pub fn serial(&self) -> Option<&str> {
        match self {
            Self::Bench(bench) => Some(bench.result.serial.as_str()),
            Self::Event(order) => Some(order.serial.as_str()),
            Self::Attributes(order) => Some(order.serial.as_str()),
            _ => None,
        }
    }

    /// Whether a caller may send what was measured where this was.
    pub fn may_be_sent_by(&self, caller: &Caller) -> Result<(), Refused> {
        match (&caller.station, self.station()) {
            (Some(own), Some(station)) if normal_form(own) != normal_form(station) => {
                let other = message!("other_station", station = own.clone());
                Err(Problem::new(403, "title_other_station", other).into())
            }
            _ => Ok(()),
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
}

/// The time of a record that was set aside is right: it counts from now on.
#[derive(Debug, Clone)]
pub struct Confirmation {
    pub id: Id,
    /// With a window that is trusted: not where that is suspect again.
    pub of_window: bool,
    pub author: String,
    pub reason: String,
    /// The record as the model states it that has come into force since it was stored, and that model: the writer
    /// fills it in.
    pub restated: Option<Box<(Calibration, Id)>>,
}

/// What a station measured in a window is suspect: the stored record is set aside until somebody confirms it.
#[derive(Debug, Clone)]
pub struct SetAsideOrder {
    pub id: Id,
    pub author: String,
    pub reason: String,
}

/// A window of a station is suspect, or to be trusted again: that holds for what is yet to come of it.
#[derive(Debug, Clone)]
pub struct WindowMark {
    pub station: String,
    pub mark: Mark,
}

/// What a laboratory says of a gyro changes.
#[derive(Debug, Clone)]
pub struct AttributesOrder {
    pub serial: Name,
    pub patch: GyroAttributesPatch,
}

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
    /// Of a campaign, when its last dwell ended.
    pub ends_at: UtcMicros,
    /// The adopted model that it was fitted with, or a record restated by, if it was one.
    pub model: Option<Id>,
    pub gyros: Vec<CalibratedGyro>,
    /// As the record states it; of a campaign, the mean of what its dwells state and can be relied on, deg C.
    pub temperature_c: Option<f64>,
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
    /// Of a record that is stated at the temperature of its IMU's model: its own temperature, deg C, and what it is
    /// there.
    pub as_measured: Option<Box<(f64, Separation)>>,
    /// Of a record that states no temperature, whether its standard deviations hold what any would do.
    pub at_any_temperature: bool,
    /// Of a record, effects of temperature in its IMU's model of which nothing is known of this very gyro.
    pub not_restated: Vec<Effect>,
    /// On E and G, which need no history.
    pub requirements: [Option<Verdict>; 2],
}

impl CalibratedGyro {
    /// As it was measured.
    pub(super) fn new(
        (place, slot, serial): (usize, Slot, &Name),
        separation: Separation,
        requirements: [Option<Verdict>; 2],
    ) -> Self {
        Self {
            place,
            slot,
            serial: serial.clone(),
            separation,
            as_measured: None,
            at_any_temperature: false,
            not_restated: Vec::new(),
            requirements,
        }
    }
}

#[derive(Debug, Clone)]
pub struct BenchTest {
    pub result: BenchResult,
    /// When its last dwell ended; when it was measured, of what states no dwells.
    pub ends_at: UtcMicros,
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    pub idempotency_key: Option<String>,
}

/// That something was done to a gyro.
#[derive(Debug, Clone)]
pub struct EventOrder {
    pub serial: Name,
    pub event: GyroEvent,
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
    let text = std::str::from_utf8(bytes).map_err(|error| Faults::from(message!("not_utf8", why = text(error))))?;
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
