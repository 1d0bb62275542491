//! Where the gap of a campaign lies: in which gyros, phases and dwells.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::core::diagnose as core;

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

impl From<&core::Located> for WhereBody {
    fn from(w: &core::Located) -> Self {
        Self {
            gyros: w.gyros.iter().map(|&(s, share)| GyroShareBody { slot: s.name().to_owned(), share }).collect(),
            phases: w.phases.iter().map(|&(p, share)| PhaseShareBody { phase: p.name().to_owned(), share }).collect(),
            dwells: w
                .dwells
                .iter()
                .map(|d| DwellShareBody {
                    index: d.index,
                    slot: d.slot.name().to_owned(),
                    residual_deg_per_h: d.residual_deg_per_h,
                    share: d.share,
                })
                .collect(),
        }
    }
}
