//! One campaign diagnosed: 78 dwells, 3 gyros, the whole catalogue, closure with its interval; and what
//! the model of an IMU foretells of one. `cargo bench --bench diagnosis`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

use gyrowatch::core::augmented::Options;
use gyrowatch::core::diagnose::{Verdict, diagnose};
use gyrowatch::core::imu_model::{CampaignSample, compare, forecast, identify, named};
use gyrowatch::wire::campaign::parse_json;

fn diagnosis(c: &mut Criterion) {
    let campaigns = [
        ("nothing hidden", include_bytes!("../tests/data/practice/campaign-00.json").as_slice(), Verdict::NoGap),
        ("one effect", include_bytes!("../tests/data/practice/campaign-02.json").as_slice(), Verdict::Explained),
        ("two effects", include_bytes!("../tests/data/practice/campaign-09.json").as_slice(), Verdict::Explained),
    ];
    let mut group = c.benchmark_group("diagnosis");
    group.sample_size(20);
    for (name, bytes, verdict) in campaigns {
        let campaign = parse_json(bytes).expect("the practice campaigns are sound");
        assert_eq!((campaign.dwells.len(), campaign.gyros.len()), (78, 3));
        let found = diagnose(&campaign, &Options::default()).expect("it can be diagnosed").verdict;
        assert_eq!(found, verdict, "{name}");
        group.bench_function(name, |b| b.iter(|| diagnose(black_box(&campaign), &Options::default())));
    }
    group.finish();
}

/// What the model of an IMU foretells of a campaign of 78 dwells, and how that is held against what was measured.
fn forecasts(c: &mut Criterion) {
    let bytes = include_bytes!("../tests/data/practice/campaign-02.json").as_slice();
    let campaign = parse_json(bytes).expect("the practice campaigns are sound");
    let chosen = named(&[&campaign], None).expect("it can be diagnosed");
    let sample = CampaignSample { campaign: &campaign, source: None, occasions: chosen.occasions[0].clone() };
    let model = identify(&[sample], &chosen.model).expect("it makes a model");
    let mut next = campaign.clone();
    next.measured_at = next.measured_at.plus_days(30.0);
    assert_eq!((next.dwells.len(), model.effects.len()), (78, 1));
    let mut group = c.benchmark_group("forecast of 78 dwells");
    group.bench_function("foretold", |b| b.iter(|| forecast(&model, black_box(&next))));
    group.bench_function("held against the campaign", |b| b.iter(|| compare(&model, black_box(&next))));
    group.finish();
}

criterion_group!(benches, diagnosis, forecasts);
criterion_main!(benches);
