//! What acts at one moment of a campaign, and what a cause makes of it.

use nalgebra::Vector3;

use super::station::Moment;

/// When a dwell happens and what was before it; the same for every gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct Situation {
    pub index: usize,
    /// Which of the body's axes is nearest to the vertical: +x, -x, +y, -y, +z, -z.
    pub face: usize,
    /// Whether the table turns.
    pub turning: bool,
    /// Middle of the dwell, hours after the start.
    pub time_h: f64,
    pub since_power_up_h: f64,
    /// Hours since the body's vertical last changed, at mid-dwell.
    pub since_face_change_h: f64,
    /// True temperature less that at which its effects are nothing, K.
    pub temperature_k: f64,
    /// Mean specific force of the dwell before, body axes; none in the first.
    pub a_before: Option<Vector3<f64>>,
    /// Mean inertial rate of the dwell before, body axes.
    pub w_before: Option<Vector3<f64>>,
}

/// One moment in the axes of one gyro (components along I, S, O).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensed {
    pub a: Vector3<f64>,
    pub w: Vector3<f64>,
    pub field: Vector3<f64>,
    pub a_before: Option<Vector3<f64>>,
    pub w_before: Option<Vector3<f64>>,
    /// The same moment in body axes.
    pub body: Moment,
}

/// What a cause adds: drift in deg/h, and a relative change of the scale factor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Disturbance {
    pub drift: f64,
    pub scale: f64,
}

/// What something of size one does to a gyro at one moment.
pub type Action = fn(&Sensed, &Situation) -> Disturbance;

/// A drift alone, deg/h.
pub const fn drift(drift: f64) -> Disturbance {
    Disturbance { drift, scale: 0.0 }
}

/// A relative change of the scale factor alone.
pub const fn scale(scale: f64) -> Disturbance {
    Disturbance { drift: 0.0, scale }
}
