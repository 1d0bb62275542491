//! What happens in the demo: what it tells the service, in the order of its time.

use nalgebra::Vector3;
use serde_json::json;

use crate::core::bench::BenchMethod;
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;
use crate::wire::bench::BenchBody;
use crate::wire::campaign::CampaignBody;
use crate::wire::geometry::GeometryBody;
use crate::wire::record::{GyroBody, RecordBody};
use crate::wire::time;

/// What the demo tells the service, in the order of its time.
pub(super) enum DemoInput {
    Record(Box<RecordBody>),
    Bench(BenchBody),
    Campaign(Box<CampaignBody>),
    Repair { serial: String, at: String, reason: String },
}

impl DemoInput {
    /// When it happened, RFC 3339 in UTC: every instant of the demo lies on a whole second, so that texts sort as
    /// times.
    pub(super) fn at(&self) -> &str {
        match self {
            Self::Record(record) => &record.calibrated_at,
            Self::Bench(bench) => &bench.measured_at,
            Self::Campaign(campaign) => &campaign.measured_at,
            Self::Repair { at, .. } => at,
        }
    }

    pub(super) fn request(&self) -> serde_json::Result<(String, Vec<u8>)> {
        Ok(match self {
            Self::Record(record) => ("/v1/records".to_owned(), serde_json::to_vec(record)?),
            Self::Bench(bench) => ("/v1/bench-results".to_owned(), serde_json::to_vec(bench)?),
            Self::Campaign(campaign) => ("/v1/campaigns".to_owned(), serde_json::to_vec(campaign)?),
            Self::Repair { serial, at, reason } => {
                let body = json!({"event": "repair", "at": at, "reason": reason, "author": "demo"});
                (format!("/v1/gyros/{serial}/events"), serde_json::to_vec(&body)?)
            }
        })
    }
}

/// A record with nothing but what it must have.
pub(super) fn record_body(imu: String, station: &str, at: UtcMicros, geometry: GeometryBody) -> RecordBody {
    RecordBody {
        imu,
        station: station.into(),
        calibrated_at: time::format(at),
        geometry,
        gyros: Vec::new(),
        temperature_c: None,
        campaign: None,
        operator: None,
        note: None,
    }
}

/// E in pulse/arcsec and G in pulse/(s g0), without standard deviations.
pub(super) fn gyro_body(slot: Slot, serial: &str, e: Vector3<f64>, g: Vector3<f64>) -> GyroBody {
    GyroBody {
        slot,
        serial: serial.into(),
        e_pulse_per_arcsec: e.into(),
        g_pulse_per_s_g0: Some(g.into()),
        g_deg_per_h_g0: None,
        p_pulse_per_s_g02: None,
        bias_pulse_per_s: None,
        e_sd: None,
        g_sd: None,
    }
}

/// D_I and D_S in deg/(h g0), without standard deviations.
pub(super) fn bench_body(serial: &str, station: &str, at: UtcMicros, [d_i, d_s]: [f64; 2]) -> BenchBody {
    BenchBody {
        serial: serial.into(),
        station: station.into(),
        measured_at: time::format(at),
        method: BenchMethod::TorqueFeedback,
        d_i_deg_per_h_g0: d_i,
        d_s_deg_per_h_g0: d_s,
        d_i_sd: None,
        d_s_sd: None,
        temperature_c: None,
        operator: None,
        note: None,
    }
}
