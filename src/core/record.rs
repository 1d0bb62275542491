//! A validated calibration record: the parameters of model (6) that a station has already fitted.

use nalgebra::Vector3;

use super::fault::Faults;
use super::frames::angle_between;
use super::mounting::{Geometry, Slot};
use super::time::UtcMicros;
use crate::core::message::{Message, figure, text};
use crate::message;

pub use super::name::{MAX_NAME_CHARS, Name};

/// Longest free text.
pub const MAX_NOTE_CHARS: usize = 4096;

/// One gyro's row of model (6), and who the gyro is.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroParameters {
    pub slot: Slot,
    pub serial: Name,
    /// E, pulse/arcsec, body axes.
    pub e: Vector3<f64>,
    /// G, pulse/(s g0), body axes.
    pub g: Vector3<f64>,
    /// P, pulse/(s g0^2), body axes.
    pub p: Vector3<f64>,
    /// D0, pulse/s.
    pub bias: f64,
    pub e_sd: Option<Vector3<f64>>,
    pub g_sd: Option<Vector3<f64>>,
    /// Whether the station states G/|E|: `g_sd` is then |E| times that of the ratio, and an error of |E| moves G as
    /// well.
    pub g_is_ratio: bool,
}

/// What the station sent, checked. At most one gyro a slot, no serial twice.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    pub imu: Name,
    pub station: Name,
    pub calibrated_at: UtcMicros,
    pub geometry: Geometry,
    pub gyros: Vec<GyroParameters>,
    pub temperature_c: Option<f64>,
    pub campaign: Option<String>,
    pub operator: Option<String>,
    pub note: Option<String>,
}

/// What is refused as impossible (not what is merely out of requirement, which is stored and flagged).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plausibility {
    /// Accepted |E|, pulse/arcsec.
    pub scale_factor: (f64, f64),
    /// Largest angle between the measured and the nominal input axis, radians.
    pub max_misalignment: f64,
    /// Largest |G/E| component, deg/(h g0).
    pub max_drift: f64,
}

impl Default for Plausibility {
    /// Wide enough for floated gyros (1 to 3 pulse/arcsec) and for others (1 where a pulse is an arcsec, 0.005 of raw
    /// counts), too narrow for a floated gyro's pulses per degree (3600 times as many), and for drift in deg/s or per
    /// hour where it should be per second.
    fn default() -> Self {
        Self { scale_factor: (0.001, 1000.0), max_misalignment: 5.0_f64.to_radians(), max_drift: 1e3 }
    }
}

impl Plausibility {
    /// What every campaign that was ever stored satisfies: those that lie there are read with it, whatever the limits
    /// are today.
    pub fn ever() -> Self {
        Self { scale_factor: (1e-6, 1e6), max_drift: f64::INFINITY, ..Self::default() }
    }

    /// Whether `e` (pulse/arcsec) is a possible row of E for the gyro in `slot`. A slot without axes is not held
    /// against any.
    ///
    /// # Errors
    /// |E| out of range, or its direction too far from the nominal input axis, and whose axis it fits instead.
    pub fn check_scale(&self, e: &Vector3<f64>, geometry: &Geometry, slot: Slot) -> Result<(), Message> {
        let norm = e.norm();
        let (low, high) = self.scale_factor;
        if !(low..=high).contains(&norm) {
            return Err(message!("scale_factor_range", norm = short(norm), low = text(low), high = text(high)));
        }
        let direction = e / norm;
        let angle_from = |slot| {
            let input = geometry.triad(slot)?.input();
            Some(angle_between(&direction, &input))
        };
        let Some(angle) = angle_from(slot).filter(|angle| *angle > self.max_misalignment) else { return Ok(()) };
        let others = Slot::ALL.into_iter().filter_map(|slot| Some((slot, angle_from(slot)?)));
        let instead = others.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, angle)| *angle <= self.max_misalignment);
        let (angle, most) = (figure(angle.to_degrees(), 3), figure(self.max_misalignment.to_degrees(), 3));
        Err(match instead {
            Some((other, _)) => {
                message!("direction_of_another", angle, slot = slot.name(), most, other = other.name())
            }
            None => message!("direction_off_axis", angle, slot = slot.name(), most),
        })
    }
}

impl Record {
    /// Checks what a type cannot: names are unique, E is a possible row of the declared geometry.
    pub fn check(&self, limits: &Plausibility) -> Result<(), Faults> {
        let mut faults = Faults::default();
        if self.gyros.is_empty() || self.gyros.len() > 3 {
            faults.push("/gyros", message!("gyros_one_to_three", have = self.gyros.len()));
        }
        for (i, gyro) in self.gyros.iter().enumerate() {
            // A gyro in another's slot would be held against the wrong axes.
            if check_unique(&self.gyros, i, &mut faults) {
                check_against_geometry(&self.geometry, gyro, i, limits, &mut faults);
            }
        }
        faults.or(())
    }
}

/// Whether the gyro has its slot for itself.
fn check_unique(gyros: &[GyroParameters], i: usize, faults: &mut Faults) -> bool {
    let (gyro, before) = (&gyros[i], &gyros[..i]);
    let slot_twin = before.iter().position(|g| g.slot == gyro.slot);
    if let Some(twin) = slot_twin {
        faults.push(
            format!("/gyros/{i}/slot"),
            message!("slot_taken", slot = gyro.slot.name(), place = format_args!("/gyros/{twin}")),
        );
    }
    if let Some(twin) = before.iter().position(|g| g.serial == gyro.serial) {
        faults.push(
            format!("/gyros/{i}/serial"),
            message!("serial_taken", serial = text(&gyro.serial), place = format_args!("/gyros/{twin}")),
        );
    }
    slot_twin.is_none()
}

fn check_against_geometry(
    geometry: &Geometry,
    gyro: &GyroParameters,
    i: usize,
    limits: &Plausibility,
    faults: &mut Faults,
) {
    let pointer = format!("/gyros/{i}/e_pulse_per_arcsec");
    if geometry.triad(gyro.slot).is_none() {
        faults.push(format!("/gyros/{i}/slot"), message!("no_axes_for", slot = text(gyro.slot.name())));
        return;
    }
    if let Err(reason) = limits.check_scale(&gyro.e, geometry, gyro.slot) {
        faults.push(pointer, reason);
    }
    let norm = gyro.e.norm();
    let drift = gyro.g.amax() / norm;
    if norm > 0.0 && drift > limits.max_drift {
        let member = if gyro.g_is_ratio { "g_deg_per_h_g0" } else { "g_pulse_per_s_g0" };
        faults.push(
            format!("/gyros/{i}/{member}"),
            message!("drift_range", value = short(drift), most = text(limits.max_drift)),
        );
    }
}

/// A figure of any size in a message.
pub fn short(x: f64) -> String {
    if x == 0.0 || (1e-6..1e9).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}
