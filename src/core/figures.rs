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

/// The last digits may differ between builds of this program; no bit that matters may.
const TOLERANCE: f64 = 1e-9;

/// Whether two computations of one number agree.
pub fn near(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()).max(1e-3)
}

impl Figures {
    /// Whether the numbers are those of `other`, whatever the states are.
    pub fn agrees(&self, other: &Self) -> bool {
        let (own, others) = (self.numbers(), other.numbers());
        own.len() == others.len() && own.iter().zip(&others).all(|(a, b)| near(*a, *b))
    }

    fn numbers(&self) -> Vec<f64> {
        let mut numbers = self.rigid.to_vec();
        numbers.extend(self.rigid_sd.iter().flatten());
        numbers.extend(self.published.iter().flat_map(|p| {
            [f64::from(p.branch), p.d[0], p.d[1], p.closure_rms].into_iter().chain(p.sd.into_iter().flatten())
        }));
        numbers
    }
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
