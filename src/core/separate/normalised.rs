//! Where both methods start: eq. (7), the input axis, and G per unit of scale.

use nalgebra::{Matrix6, Vector3};

use crate::core::message::{Message, figure};
use crate::core::mounting::Slot;
use crate::message;

/// Covariance of (E_x, E_y, E_z, G_x, G_y, G_z) of one gyro, in the units of E and G.
pub type CovarianceEg = Matrix6<f64>;

/// Why E and G cannot be separated at all.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum Unseparable {
    NoAxes(Slot),
    ZeroScale,
    NotFinite,
    PointsAway(f64),
}

impl Unseparable {
    /// The reason as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::NoAxes(slot) => message!("no_axes_for", slot = slot.name()),
            Self::ZeroScale => message!("zero_scale"),
            Self::NotFinite => message!("quotient_not_finite"),
            Self::PointsAway(angle) => message!("points_away", angle = figure(angle.to_degrees(), 1)),
        }
    }
}

/// The measured input axis and G resolved per unit of scale: what both methods start from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normalised {
    /// |E|, pulse/arcsec.
    pub scale: f64,
    /// I^ = E/|E|.
    pub input: Vector3<f64>,
    /// y = G/|E|, deg/(h g0), body axes.
    pub y: Vector3<f64>,
}

impl Normalised {
    pub(super) fn of(e: &Vector3<f64>, g: &Vector3<f64>) -> Result<Self, Unseparable> {
        if !(e.iter().chain(g.iter()).all(|x| x.is_finite())) {
            return Err(Unseparable::NotFinite);
        }
        let largest = e.amax();
        if largest == 0.0 {
            return Err(Unseparable::ZeroScale);
        }
        // Scaled first: squares of 1e-200 or 1e200 would be 0 or infinite. Twice, as 1/largest may itself overflow.
        let scaled = e.map(|x| x / largest);
        let length = scaled.norm();
        let (scale, input) = (largest * length, scaled / length);
        let y = g.map(|x| x / scale);
        if !scale.is_finite() || y.iter().any(|x| !x.is_finite()) {
            return Err(Unseparable::NotFinite);
        }
        Ok(Self { scale, input, y })
    }
}
