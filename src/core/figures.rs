//! What a calibration has found of one gyro.

use crate::core::id::Id;
use crate::core::judge::State;
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;

/// One gyro in one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    pub at: UtcMicros,
    pub record: Id,
    pub imu: u32,
    pub station: u32,
    pub slot: Slot,
    /// D_I, D_S, D_O by the rigid method, deg/(h g0).
    pub rigid: [f64; 3],
    pub rigid_sd: Option<[f64; 3]>,
    pub published: Option<PublishedFigures>,
    pub states: States,
    /// Its record counts no more.
    pub voided: bool,
}

/// Eqs. (8)-(13), the errata applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedFigures {
    /// Number of the equation.
    pub branch: u8,
    pub d: [f64; 2],
    pub closure_rms: f64,
    pub sd: Option<[f64; 2]>,
}

/// The worst that any rule says of D_I, D_S and the closure; none where no rule could judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct States(pub [Option<State>; 3]);

impl States {
    /// The worst of the three.
    pub fn worst(self) -> Option<State> {
        self.0.into_iter().flatten().max()
    }
}
