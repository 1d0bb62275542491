//! One record of one gyro judged by every rule, with two years of history behind it.
//!
//! `cargo bench --bench judging`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use gyrowatch::core::judge::{History, Limits, Measured, Sample, Seat, Series, judge};
use gyrowatch::core::time::UtcMicros;

fn one_gyro(c: &mut Criterion) {
    let wobble = |i: usize, factor: f64| ((i as f64 * factor).fract() - 0.5) * 3e-3;
    let history = |per_record: f64| -> Series {
        let figure = |value| Measured { value, sd: Some(5e-4) };
        let d = |i| [3.0 + wobble(i, 0.618) + per_record * i as f64, 5.0 + wobble(i, 0.414), wobble(i, 0.732)];
        let at = |i: usize| UtcMicros(0).plus_days(14.0 * i as f64);
        let sample = |i| Sample { at: at(i), seat: Seat::default(), station: 0, d: d(i).map(figure) };
        (0..52).map(sample).collect::<Vec<_>>().into()
    };
    let limits = Limits::default();
    for (name, per_record) in [("a stable gyro", 0.0), ("a drifting gyro", 4e-4)] {
        let samples = history(per_record);
        let mut verdicts = Vec::new();
        c.bench_function(&format!("all rules on one record of {name}"), |b| {
            b.iter(|| {
                verdicts.clear();
                let history = History::whole(black_box(&samples), samples.len() - 1);
                judge(&history, samples.len() - 1, black_box(&limits), &mut verdicts);
                black_box(verdicts.len())
            });
        });
    }
}

criterion_group!(benches, one_gyro);
criterion_main!(benches);
