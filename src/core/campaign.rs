//! A validated campaign: raw dwells of an IMU on a two-axis table, or of one gyro on a test fixture.

use std::borrow::Cow;

use nalgebra::Vector3;

use super::frames::{Body, Nav, Rotation, Vector};
use super::model::{Term, Terms};
use super::mounting::{Geometry, Slot};
use super::record::Name;
use super::time::UtcMicros;
use super::units::EARTH_RATE_DEG_H;
use crate::core::named::named;

mod check;
mod columns;
pub mod commanded;
mod contradicting;
mod earth_rate;
pub mod gravity;
mod note;
pub mod repeats;
mod stated_errors;
mod station_uncertainty;
mod steps;
mod stuck;
mod temperatures;

pub use check::{CampaignLimits, check_dwells};
pub use columns::notes;
pub use earth_rate::{with_earth_rate, with_exact_rates};
pub use note::{CampaignNote, DriftOfGyro, DwellColumn, EffectNotFitted, StationUndetermined};
use stated_errors::Stated;
pub use station_uncertainty::{StationPart, StationUncertainty};
pub use steps::{CoarseStep, GyroNoise, Stepped, coarse_steps, rounded_vertical};
pub use stuck::{StuckOutput, constant, stuck};
pub use temperatures::{Temperatures, any_kelvin};

named! {
/// Whether the IMU stood still on the Earth or the table turned during a dwell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Phase {
    Static = "static",
    Rate = "rate",
}
}

named! {
/// What was on the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestKind {
    /// A whole IMU, the default.
    Imu = "imu",
    /// One gyro, torque feedback (polar-axis tumble): output in pulse/s.
    TorqueFeedback = "torque_feedback",
    /// One gyro on a servo turntable: output is the table rate in arcsec/s.
    TurntableServo = "turntable_servo",
}
}

/// Where the table stands: what the Earth does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Geodetic latitude, radians.
    pub latitude: f64,
    /// Local gravity, g0.
    pub gravity_g0: f64,
    /// Direction of the magnetic field in East, North, Up, where the station knows it.
    pub magnetic_field_nav: Option<Vector3<f64>>,
}

impl Site {
    /// The Earth's rate in East, North, Up, deg/h (the same number in arcsec/s): Omega [0, cos L, sin L] at the
    /// geodetic latitude L.
    pub fn earth_rate(&self) -> Vector<Nav> {
        Vector::new(EARTH_RATE_DEG_H * Vector3::new(0.0, self.latitude.cos(), self.latitude.sin()))
    }
}

/// A gyro of the campaign's IMU.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignGyro {
    pub slot: Slot,
    pub serial: Name,
    /// E in pulse/arcsec that is held instead of fitted (an IMU without rate dwells).
    pub known_e: Option<Vector3<f64>>,
}

impl CampaignGyro {
    /// Of the terms of a model those that are fitted to this gyro: a held E is taken off its outputs first.
    pub fn fitted_terms(&self, terms: Terms) -> Terms {
        if self.known_e.is_some() { terms.without(Term::Scale) } else { terms }
    }
}

/// One averaging interval. Vectors are the commanded ones, in body axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    pub phase: Phase,
    /// Start, seconds after the start of the first dwell's clock.
    pub start_s: f64,
    pub duration_s: f64,
    /// In a rate dwell, the attitude at its start; the table then turns about the vertical over whole turns.
    pub attitude: Option<Rotation<Nav, Body>>,
    /// Mean specific force, g0.
    pub specific_force_g0: Vector3<f64>,
    /// Mean inertial rate, Earth rate included, arcsec/s (the same number in deg/h).
    pub rate_arcsec_s: Vector3<f64>,
    pub temperature_c: Option<f64>,
    /// Mean output of each gyro, pulse/s, in the order of the campaign's gyros.
    pub output_pulse_s: Vec<f64>,
    /// Standard errors of those means, pulse/s.
    pub output_sem_pulse_s: Option<Vec<f64>>,
}

impl Dwell {
    /// Middle of the averaging interval, s.
    pub fn mid_s(&self) -> f64 {
        self.start_s + 0.5 * self.duration_s
    }
}

/// The raw data behind a calibration: averaged outputs in commanded attitudes and at commanded rates.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    pub imu: Name,
    pub station: Name,
    pub measured_at: UtcMicros,
    pub geometry: Geometry,
    pub site: Option<Site>,
    pub station_uncertainty: StationUncertainty,
    pub gyros: Vec<CampaignGyro>,
    /// In time order, never empty.
    pub dwells: Vec<Dwell>,
    /// Step in which rates were sent, arcsec/s, where [`with_exact_rates`] has put the exact ones in their place.
    pub rates_sent_in_steps: Option<f64>,
    pub test: TestKind,
    /// The terms that the station asks to be fitted, where it asks.
    pub model: Option<Terms>,
    pub temperature_c: Option<f64>,
    pub operator: Option<String>,
    pub note: Option<String>,
}

impl Campaign {
    /// When its last dwell ends.
    pub fn ends_at(&self) -> UtcMicros {
        let length_s = self.dwells.last().map_or(0.0, |last| last.start_s + last.duration_s);
        self.measured_at.plus_days(length_s / 86_400.0)
    }

    /// Inertial rate of one of its dwells as it was sent, arcsec/s.
    pub fn sent_rate(&self, dwell: &Dwell) -> Vector3<f64> {
        let scale = self.rates_sent_in_steps.map(|step| (1.0 / step).round());
        scale.map_or(dwell.rate_arcsec_s, |scale| dwell.rate_arcsec_s.map(|x| (x * scale).round() / scale))
    }

    /// Whether the output of gyro `j` is the same in every dwell: nothing can be said of it.
    pub fn is_silent(&self, j: usize) -> bool {
        self.dwells.windows(2).all(|pair| pair[0].output_pulse_s[j] == pair[1].output_pulse_s[j])
    }

    /// The same with gyros in the order of `slots`, as far as those name them all.
    pub fn in_order_of(&self, slots: &[Slot]) -> Cow<'_, Self> {
        let places = slots.iter().map(|slot| self.gyros.iter().position(|gyro| gyro.slot == *slot));
        let Some(places) = places.collect::<Option<Vec<usize>>>().filter(|p| p.len() == self.gyros.len()) else {
            return Cow::Borrowed(self);
        };
        if places.is_sorted() {
            return Cow::Borrowed(self);
        }
        let ordered = |values: &[f64]| places.iter().map(|place| values[*place]).collect();
        let mut campaign = self.clone();
        campaign.gyros = places.iter().map(|place| self.gyros[*place].clone()).collect();
        for dwell in &mut campaign.dwells {
            dwell.output_pulse_s = ordered(&dwell.output_pulse_s);
            dwell.output_sem_pulse_s = dwell.output_sem_pulse_s.as_deref().map(ordered);
        }
        Cow::Owned(campaign)
    }

    /// Outputs of gyro `j` by dwell, less what its E makes of the rates where that is held, pulse/s.
    pub fn free_outputs(&self, j: usize) -> impl ExactSizeIterator<Item = f64> {
        let e = self.gyros[j].known_e;
        self.dwells.iter().map(move |d| d.output_pulse_s[j] - e.map_or(0.0, |e| e.dot(&d.rate_arcsec_s)))
    }

    /// The terms to fit: those asked for, else model (6).
    pub fn terms(&self) -> Terms {
        self.model.unwrap_or_default()
    }

    /// Whether any dwell states standard errors.
    pub fn states_errors(&self) -> bool {
        self.dwells.iter().any(|d| d.output_sem_pulse_s.is_some())
    }

    /// Standard errors of gyro `j` by dwell, none where no dwell states any. A dwell without one gets what the law of
    /// the others gives it: [`stated_errors`].
    pub fn errors_of(&self, j: usize) -> Option<Vec<f64>> {
        let stated: Vec<Option<f64>> = self.stated_errors(j).collect();
        if stated.iter().all(Option::is_some) {
            return stated.into_iter().collect();
        }
        let law = self.laws_of_errors()?.swap_remove(j);
        Some(stated.into_iter().zip(law).map(|(sem, law)| sem.unwrap_or(law)).collect())
    }

    /// What the standard errors go by in duration and rate, by gyro and dwell, pulse/s; none where no dwell states any.
    pub fn laws_of_errors(&self) -> Option<Vec<Vec<f64>>> {
        let dwells: Vec<_> = self.dwells.iter().map(|d| (d.duration_s, d.rate_arcsec_s)).collect();
        let gyros = self.gyros.iter().enumerate().map(|(gyro, CampaignGyro { slot, .. })| Stated {
            errors: self.stated_errors(gyro).collect(),
            input: self.geometry.triad(*slot).map(|triad| triad.input()),
        });
        self.states_errors().then(|| stated_errors::laws(&dwells, &gyros.collect::<Vec<_>>()))
    }

    fn stated_errors(&self, j: usize) -> impl Iterator<Item = Option<f64>> {
        self.dwells.iter().map(move |d| Some(d.output_sem_pulse_s.as_ref()?[j]))
    }
}

#[cfg(test)]
pub(crate) mod made_for_tests;
