//! What is written apart from the campaign: the answer, in the form of a key by which a diagnosis is scored.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Keys of several campaigns by file name.
pub type Key = BTreeMap<String, KeyEntry>;

/// Label of a cause that is in no catalogue.
pub const OUTSIDE: &str = "outside the catalogue";

/// The truth about one campaign. Fields after `truth` may be missing in keys of other makers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyEntry {
    /// Ids of the catalogue, or [`OUTSIDE`]; empty where nothing was put in.
    pub effects: Vec<String>,
    /// In each effect's own unit.
    pub sizes: Vec<f64>,
    /// Set of static positions.
    pub design: String,
    /// Standard errors `exact`, `noisy` or `absent`.
    pub sem: String,
    /// Detectability d of everything that was put in, together.
    pub seen: f64,
    /// Slots that have an effect that can be seen.
    pub gyros: Vec<String>,
    pub truth: Vec<GyroKey>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Family of the cause outside the catalogue.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub family: Option<String>,
    /// Detectability of each effect alone, slot by slot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seen_by: Vec<BTreeMap<String, f64>>,
}

/// The truth about one gyro, in the order of the campaign's gyros.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GyroKey {
    #[serde(rename = "D_I")]
    pub d_i: f64,
    #[serde(rename = "D_S")]
    pub d_s: f64,
    /// Scale factor, pulse/arcsec.
    #[serde(rename = "K")]
    pub k: f64,
    #[serde(rename = "D_F")]
    pub d_f: f64,
    #[serde(rename = "I")]
    pub input: [f64; 3],
    #[serde(rename = "S")]
    pub spin: [f64; 3],
}
