//! A drawn fleet as its stations send it.

use nalgebra::Vector3;

use super::draw::DrawnFleet;
use crate::core::changes::GyroHistory;
use crate::core::mounting::Geometry;
use crate::core::record::{GyroParameters, Name, Record};

/// Pulses per arcsecond.
const SCALE: f64 = 1.4676;
/// Gyros of an IMU.
const AN_IMU: usize = 3;

pub fn serial(gyro: usize) -> Name {
    name(&format!("GYRO-{gyro:02}"))
}

/// A record for the three gyros of an IMU at a time, oldest first. E is that of the mounting, so D_I, D_S and D_O are
/// what was drawn.
pub fn records(fleet: &DrawnFleet) -> Vec<Record> {
    let of_imu = |(imu, gyros): (usize, &[GyroHistory])| {
        (0..gyros[0].entries.len()).map(|k| record(imu * AN_IMU, gyros, k)).collect::<Vec<_>>()
    };
    let mut all: Vec<Record> = fleet.gyros.chunks(AN_IMU).enumerate().flat_map(of_imu).collect();
    all.sort_by_key(|record| record.calibrated_at);
    all
}

fn name(text: &str) -> Name {
    Name::parse(text).expect("a name that is drawn can be one")
}

/// Record `k` of the IMU whose first gyro is the fleet's gyro `first`.
fn record(first: usize, gyros: &[GyroHistory], k: usize) -> Record {
    let occasion = &gyros[0].entries[k];
    let parameters = |(g, gyro): (usize, &GyroHistory)| {
        let entry = &gyro.entries[k];
        let triad = Geometry::Skewed.triad(entry.slot).expect("skewed names every slot");
        let [d_i, d_s, d_o] = entry.d.map(|figure| figure.value);
        GyroParameters {
            slot: entry.slot,
            serial: serial(first + g),
            e: triad.input() * SCALE,
            g: (triad.input() * d_i + triad.spin() * d_s + triad.output() * d_o) * SCALE,
            p: Vector3::zeros(),
            bias: 0.0,
            e_sd: Some(Vector3::zeros()),
            g_sd: entry.d[0].sd.map(|sd| Vector3::repeat(sd * SCALE)),
            g_is_ratio: false,
        }
    };
    Record {
        imu: name(&occasion.imu),
        station: name(&occasion.station),
        calibrated_at: occasion.at,
        geometry: Geometry::Skewed,
        gyros: gyros.iter().enumerate().map(parameters).collect(),
        temperature_c: occasion.temperature_c,
        campaign: None,
        operator: None,
        note: None,
    }
}
