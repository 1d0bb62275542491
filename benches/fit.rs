//! One campaign of 78 dwells and three gyros: read, fitted, separated. To reach: the fit in 0.5 ms on one core.
//!
//! `cargo bench --bench fit`

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use gyrowatch::core::calibrate::calibrate;
use gyrowatch::core::campaign::Campaign;
use gyrowatch::core::model::Terms;
use gyrowatch::core::record::Plausibility;
use gyrowatch::wire::campaign::{parse_json, to_json};
use gyrowatch::wire::campaign_csv::{parse_csv, to_csv};

/// Standard errors that differ from gyro to gyro: three factorisations, the slow case.
const CAMPAIGN: &[u8] = include_bytes!("../tests/data/practice/campaign-00.json");

fn one_campaign(c: &mut Criterion) {
    let campaign = parse_json(CAMPAIGN).expect("sound");
    let mut unweighted = campaign.clone();
    unweighted.dwells.iter_mut().for_each(|d| d.output_sem_pulse_s = None);
    let fit = |campaign: &Campaign| {
        let calibration = calibrate(campaign, Terms::MODEL_6);
        let separations = calibration.separate(&campaign.geometry, &Plausibility::default());
        (calibration, separations)
    };
    c.bench_function("fit of 78 dwells, three gyros", |b| b.iter(|| fit(black_box(&campaign))));
    c.bench_function("the same without standard errors", |b| b.iter(|| fit(black_box(&unweighted))));
    let (json, csv) = (to_json(&campaign), to_csv(&campaign));
    c.bench_function("reading it from JSON", |b| b.iter(|| parse_json(black_box(json.as_bytes()))));
    c.bench_function("reading it from CSV", |b| b.iter(|| parse_csv(black_box(csv.as_bytes()))));
}

criterion_group!(benches, one_campaign);
criterion_main!(benches);
