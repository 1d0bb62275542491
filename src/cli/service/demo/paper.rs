//! The paper's own figures: Tables 3 and 4 as one record, the three result columns of Table 5 as a second.
//!
//! Table 5's separation column does not follow from Tables 3 and 4 (see `docs/method.md`). They are two sets of data,
//! and get IMUs and serial numbers of their own. The paper prints no E and G for Table 5: those here are what gives
//! its D_I and D_S at one pulse per arc second, and their axes are stated one by one, for Tables 3 and 4 are required
//! of the geometry `skewed`.

use super::input::{DemoInput, bench_body, gyro_body, record_body};
use crate::core::mounting::{Geometry, Slot};
use crate::core::time::UtcMicros;
use crate::wire::geometry::{GeometryBody, NamedGeometry};
use crate::wire::record::{GyroBody, RecordBody};

/// Tables 3 and 4: E in pulse/arcsec, G in pulse/(s g0).
const TABLES_3_4: [([f64; 3], [f64; 3]); 3] = [
    ([0.8473, -0.6011, 1.0367], [2.4210, 4.0554, 6.5179]),
    ([0.8478, -0.6000, -1.0381], [0.8634, 4.6419, -3.4081]),
    ([0.8533, 1.2062, -0.0008], [0.9901, 1.4495, -9.9775]),
];

/// Table 5, [D_I, D_S] of each gyro: bench before, separation, bench after; deg/(h g0).
const TABLE_5: [[[f64; 2]; 3]; 3] = [
    [[4.193101, 5.771452], [4.192621, 5.771440], [4.192798, 5.772109]],
    [[1.584331, 6.132195], [1.584334, 6.131210], [1.584927, 6.132201]],
    [[1.686599, -9.977666], [1.686447, -9.976657], [1.6865143, -9.976365]],
];

/// Days before today: bench, calibration in the IMU, bench again.
const DAYS_AGO: [f64; 3] = [44.0, 30.0, 16.0];
const TABLES_3_4_SERIALS: [&str; 3] = ["PAPER-T4-G1", "PAPER-T4-G2", "PAPER-T4-G3"];
const TABLE_5_SERIALS: [&str; 3] = ["PAPER-T5-G1", "PAPER-T5-G2", "PAPER-T5-G3"];

pub fn inputs(today: UtcMicros) -> Vec<DemoInput> {
    let calibrated = today.plus_days(-DAYS_AGO[1]);
    let printed = Slot::ALL.map(|slot| {
        let (e, g) = TABLES_3_4[slot.index()];
        gyro_body(slot, TABLES_3_4_SERIALS[slot.index()], e.into(), g.into())
    });
    let nominal = Slot::ALL.map(|slot| {
        let [_, [d_i, d_s], _] = TABLE_5[slot.index()];
        let triad = Geometry::Skewed.triad(slot).expect("the skewed geometry names every slot");
        gyro_body(slot, TABLE_5_SERIALS[slot.index()], triad.input(), d_i * triad.input() + d_s * triad.spin())
    });
    let stated = Geometry::Custom(Slot::ALL.map(|slot| Geometry::Skewed.triad(slot)));
    let mut inputs = vec![
        record("IMU-PAPER-T4", calibrated, GeometryBody::Named(NamedGeometry::Skewed), printed),
        record("IMU-PAPER-T5", calibrated, GeometryBody::of(&stated), nominal),
    ];
    for (column, days) in [(0, DAYS_AGO[0]), (2, DAYS_AGO[2])] {
        for slot in 0..3 {
            let (serial, drift) = (TABLE_5_SERIALS[slot], TABLE_5[slot][column]);
            inputs.push(DemoInput::Bench(bench_body(serial, "BENCH-PAPER", today.plus_days(-days), drift)));
        }
    }
    inputs
}

fn record(imu: &str, calibrated: UtcMicros, geometry: GeometryBody, gyros: [GyroBody; 3]) -> DemoInput {
    DemoInput::Record(Box::new(RecordBody {
        gyros: gyros.into(),
        note: Some("doi 10.11918/j.issn.0367-6234.2015.01.015".into()),
        ..record_body(imu.into(), "ST-PAPER", calibrated, geometry)
    }))
}
