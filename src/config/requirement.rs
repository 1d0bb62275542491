//! `[judging.requirement]` and `requirement` of an override: what E and G must keep, where the paper's tables are not
//! to hold.

use serde::Deserialize;

use super::error::MessageError;
use crate::core::judge::limits::{Bounds, LimitKey, Requirement};
use crate::core::mounting::Slot;
use crate::message;

/// Bounds by slot; those of a slot go before those of `all`. What is left out stays as the layer before has it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlotRequirements {
    all: RequirementKeys,
    #[serde(rename = "G1")]
    g1: RequirementKeys,
    #[serde(rename = "G2")]
    g2: RequirementKeys,
    #[serde(rename = "G3")]
    g3: RequirementKeys,
}

/// E, its length |E| (pulse/arcsec) and G (pulse/(s g0)).
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RequirementKeys {
    e_norm: Option<BoundsKey>,
    e_x: Option<BoundsKey>,
    e_y: Option<BoundsKey>,
    e_z: Option<BoundsKey>,
    g_x: Option<BoundsKey>,
    g_y: Option<BoundsKey>,
    g_z: Option<BoundsKey>,
}

/// `[low, high]`, or `[]` where nothing is required.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Vec<f64>")]
struct BoundsKey(Option<[f64; 2]>);

impl TryFrom<Vec<f64>> for BoundsKey {
    type Error = MessageError;

    fn try_from(bounds: Vec<f64>) -> Result<Self, MessageError> {
        match bounds[..] {
            [] => Ok(Self(None)),
            [low, high] if low.is_finite() && high.is_finite() && low < high => Ok(Self(Some([low, high]))),
            _ => Err(MessageError(message!("config_bounds", bounds = format_args!("{bounds:?}")))),
        }
    }
}

impl SlotRequirements {
    /// Changes what these keys name for the gyro in `slot`. `place` is that of the override that holds them.
    pub(super) fn apply(&self, slot: Slot, place: Option<u16>, required: &mut Requirement) {
        let (own, key) = match slot {
            Slot::G1 => (&self.g1, "requirement.G1"),
            Slot::G2 => (&self.g2, "requirement.G2"),
            Slot::G3 => (&self.g3, "requirement.G3"),
        };
        for (keys, key) in [(&self.all, "requirement.all"), (own, key)] {
            keys.apply(LimitKey { place, key }, required);
        }
    }
}

impl RequirementKeys {
    fn apply(&self, from: LimitKey, required: &mut Requirement) {
        let [e_x, e_y, e_z] = &mut required.e;
        let [g_x, g_y, g_z] = &mut required.g;
        for (bounds, key) in [
            (&mut required.e_norm, self.e_norm),
            (e_x, self.e_x),
            (e_y, self.e_y),
            (e_z, self.e_z),
            (g_x, self.g_x),
            (g_y, self.g_y),
            (g_z, self.g_z),
        ] {
            if let Some(BoundsKey(own)) = key {
                *bounds = own.map(|[low, high]| Bounds { low, high, from });
            }
        }
    }
}
