//! Where the gap of a campaign lies: in which gyros, phases and dwells.

use crate::core::campaign::Phase;
use crate::core::diagnose as core;
use crate::wire::prelude::*;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WhereBody {
    pub gyros: Vec<GyroShareBody>,
    pub phases: Vec<PhaseShareBody>,
    pub dwells: Vec<DwellShareBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroShareBody {
    pub slot: String,
    pub share: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PhaseShareBody {
    pub phase: String,
    pub share: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DwellShareBody {
    pub index: usize,
    pub slot: String,
    pub residual_deg_per_h: f64,
    pub share: f64,
}

bodies! {
    WhereBody of core::Located: gyros, phases, dwells;
    DwellShareBody of core::DwellShare: index, slot, residual_deg_per_h, share;
    GyroShareBody of (Slot, f64): slot = 0, share = 1;
    PhaseShareBody of (Phase, f64): phase = 0, share = 1;
}
