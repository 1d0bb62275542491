//! A validated bench result: what a single-gyro test outside the IMU says of one gyro.

use std::sync::Arc;

use super::id::Id;
use super::named::named;
use super::record::Name;
use super::time::UtcMicros;

named! {
/// How a single gyro was tested (the paper's schemes one and three).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BenchMethod("method_") {
    /// Polar-axis tumble, the float held by the torquer.
    TorqueFeedback = "torque_feedback",
    /// The gyro steers a servo turntable.
    TurntableServo = "turntable_servo",
}
}

/// D_I and D_S of equation (5), deg/(h g0), as a bench found them for one gyro alone; with standard deviations in the
/// same unit where it states them. `temperature_c` is in degrees Celsius.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchResult {
    pub serial: Name,
    pub station: Name,
    pub measured_at: UtcMicros,
    pub method: BenchMethod,
    pub d_i: f64,
    pub d_s: f64,
    pub d_i_sd: Option<f64>,
    pub d_s_sd: Option<f64>,
    pub temperature_c: Option<f64>,
    pub operator: Option<String>,
    pub note: Option<String>,
}

/// A bench result as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchItem {
    pub id: Id,
    pub gyro: u32,
    pub station: u32,
    pub measured_at: UtcMicros,
    pub method: BenchMethod,
    /// D_I and D_S, deg/(h g0).
    pub d: [f64; 2],
    pub sd: [Option<f64>; 2],
    /// It does not count any more.
    pub voided: bool,
    pub received_at: UtcMicros,
    /// Word for word.
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    /// The line of the audit trail that says who sent it.
    pub sent_by: Option<Id>,
}

/// What a product of specific forces that is not fitted would do to a coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alias {
    /// D_SI, D_IO or D_OS: of a_S a_I, a_I a_O or a_O a_S; D_III, D_IIS, D_ISS or D_SSS: of a_I^3, a_I^2 a_S and so on.
    pub product: &'static str,
    pub coefficient: &'static str,
    /// By how much one deg/(h g0^2), of the third degree one deg/(h g0^3), of it moves the coefficient, in the
    /// coefficient's unit: deg/(h g0) for D_I and D_S.
    pub moves: f64,
}
