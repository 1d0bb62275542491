//! One IMU separated: three gyros, both methods and as printed, covariance of all. To reach: 2 microseconds.
//!
//! `cargo bench --bench separation`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use gyrowatch::core::mounting::{Geometry, Slot};
use gyrowatch::core::separate::{diagonal_covariance, separate};
use nalgebra::Vector3;

/// Tables 3 and 4 of the paper.
const TABLES_3_4: [([f64; 3], [f64; 3]); 3] = [
    ([0.8473, -0.6011, 1.0367], [2.4210, 4.0554, 6.5179]),
    ([0.8478, -0.6000, -1.0381], [0.8634, 4.6419, -3.4081]),
    ([0.8533, 1.2062, -0.0008], [0.9901, 1.4495, -9.9775]),
];

fn one_imu(c: &mut Criterion) {
    let covariance = diagonal_covariance(Some(&Vector3::repeat(2e-5)), Some(&Vector3::repeat(3e-4)));
    c.bench_function("separation of one IMU", |b| {
        b.iter(|| {
            for (slot, (e, g)) in Slot::ALL.into_iter().zip(black_box(&TABLES_3_4)) {
                let separation = separate(
                    black_box(&Geometry::Skewed),
                    slot,
                    &Vector3::from(*e),
                    &Vector3::from(*g),
                    black_box(covariance.as_ref()),
                );
                let _ = black_box(separation);
            }
        });
    });
}

criterion_group!(benches, one_imu);
criterion_main!(benches);
