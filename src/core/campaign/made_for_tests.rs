//! Campaigns for unit tests: what each of them says of its gyros and dwells, and nothing else.

use super::*;

/// A name that is one.
pub(crate) fn name(text: &str) -> Name {
    Name::parse(text).expect("a name")
}

/// An orthogonal IMU.
pub(crate) fn campaign(gyros: Vec<CampaignGyro>, dwells: Vec<Dwell>) -> Campaign {
    Campaign {
        imu: name("IMU"),
        station: name("ST"),
        measured_at: UtcMicros(0),
        geometry: Geometry::Orthogonal,
        site: None,
        station_uncertainty: StationUncertainty::default(),
        gyros,
        dwells,
        rates_sent_in_steps: None,
        test: TestKind::Imu,
        model: None,
        temperature_c: None,
        operator: None,
        note: None,
    }
}

/// The `k`th static dwell without attitude, temperature and standard errors: three minutes, four after the one before.
pub(crate) fn dwell(k: usize, force: Vector3<f64>, rate: Vector3<f64>, outputs: Vec<f64>) -> Dwell {
    Dwell {
        phase: Phase::Static,
        start_s: 240.0 * k as f64,
        duration_s: 180.0,
        attitude: None,
        specific_force_g0: force,
        rate_arcsec_s: rate,
        temperature_c: None,
        output_pulse_s: outputs,
        output_sem_pulse_s: None,
    }
}
