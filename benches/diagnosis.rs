//! One campaign diagnosed: 78 dwells, 3 gyros, the whole catalogue, closure with its interval. `cargo bench --bench
//! diagnosis`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

use gyrowatch::core::augmented::Options;
use gyrowatch::core::diagnose::{Verdict, diagnose};
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

criterion_group!(benches, diagnosis);
criterion_main!(benches);
