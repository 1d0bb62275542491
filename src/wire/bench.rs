//! A bench result: D_I and D_S of a single gyro on its own fixture (Table 5's columns 1 and 3).

use super::{json, text};
use crate::core::bench::{BenchMethod, BenchResult};
use crate::core::message::text;
use crate::core::record::short;
use crate::wire::prelude::*;

/// A bench result as it stands on the wire.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BenchBody {
    pub serial: String,
    pub station: String,
    /// RFC 3339 with offset.
    pub measured_at: String,
    pub method: BenchMethod,
    pub d_i_deg_per_h_g0: f64,
    pub d_s_deg_per_h_g0: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_i_sd: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_s_sd: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Reads and checks a bench result; `max_drift` is the largest accepted |D|, deg/(h*g0).
pub fn parse_bench_result(bytes: &[u8], max_drift: f64) -> Result<BenchResult, Faults> {
    json::parse_and_read(bytes, |body: &BenchBody| body.to_core(max_drift))
}

impl BenchBody {
    /// Checks every member. `max_drift` is the largest |D_I| and |D_S|, deg/(h g0).
    pub fn to_core(&self, max_drift: f64) -> Result<BenchResult, Faults> {
        let mut faults = Faults::default();
        let result = BenchResult {
            serial: text::name("/serial", &self.serial, &mut faults),
            station: text::name("/station", &self.station, &mut faults),
            measured_at: text::instant("/measured_at", &self.measured_at, &mut faults),
            method: self.method,
            d_i: self.d_i_deg_per_h_g0,
            d_s: self.d_s_deg_per_h_g0,
            d_i_sd: text::deviation("/d_i_sd", self.d_i_sd, &mut faults),
            d_s_sd: text::deviation("/d_s_sd", self.d_s_sd, &mut faults),
            temperature_c: text::temperature("/temperature_c", self.temperature_c, &mut faults),
            operator: text::short("/operator", &self.operator, &mut faults),
            note: text::note("/note", &self.note, &mut faults),
        };
        for (pointer, value) in [("/d_i_deg_per_h_g0", result.d_i), ("/d_s_deg_per_h_g0", result.d_s)] {
            if value.abs() > max_drift {
                faults.push(pointer, message!("coefficient_range", value = short(value), most = text(max_drift)));
            }
        }
        faults.or(result)
    }
}

bodies! {
    BenchBody of BenchResult: serial, station, measured_at, method, d_i_deg_per_h_g0 = d_i, d_s_deg_per_h_g0 = d_s, d_i_sd,
        d_s_sd, temperature_c, operator, note;
}
