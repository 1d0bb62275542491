//! The words of a record's verdicts beside judging and storing it, in one run: what counts is the ratio.
//!
//! `cargo bench --bench wording`
//!
//! Records of one IMU are judged and stored one after the other, without HTTP. Then the verdicts of each are put into
//! the JSON of an answer.

mod client;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gyrowatch::config::Config;
use gyrowatch::pipeline::{Accepted, Pipeline, Submission};
use gyrowatch::store;
use gyrowatch::system::Clock;
use gyrowatch::wire::answer::VerdictBody;
use gyrowatch::words::{Language, asked_in};
use tempfile::TempDir;

const RECORDS: usize = 2_000;
/// Of the paper's first gyro, pulse/(s g0).
const G_X: &str = "2.4210";

fn main() {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    runtime.block_on(async {
        measure("in tolerance", |k| client::record(0, k)).await;
        // Every other record is 0.05 pulse/(s g0) off: step, range and baseline are out of tolerance.
        let restless = |k: usize| client::record(0, k).replace(G_X, if k.is_multiple_of(2) { G_X } else { "2.4710" });
        measure("out of tolerance", restless).await;
    });
}

async fn measure(what: &str, record: impl Fn(usize) -> String) {
    let dir = TempDir::new().expect("a directory");
    let mut config = Config::defaults();
    config.database.url = format!("sqlite://{}", dir.path().join("gyrowatch.db").display());
    let config = Arc::new(config);
    let (store, writer) = store::open(&config.database.options()).await.expect("a database");
    let (pipeline, written) = Pipeline::start(store, writer, config, Clock::System).await.expect("a pipeline");
    let (mut stored, mut worded) = (Duration::ZERO, [Duration::ZERO; Language::ALL.len()]);
    let mut verdicts = 0;
    for k in 0..RECORDS {
        let begun = Instant::now();
        let calibration = pipeline.reader.record(record(k).as_bytes()).expect("a record");
        let accepted = pipeline.ingest.submit(Submission::Calibration(Box::new(calibration))).await;
        stored += begun.elapsed();
        let Ok(Accepted::Stored { judged, .. }) = accepted else { panic!("record {k} was not stored") };
        verdicts += judged.iter().map(|gyro| gyro.verdicts.len()).sum::<usize>();
        for (language, worded) in Language::ALL.into_iter().zip(&mut worded) {
            let begun = Instant::now();
            let words = async {
                let verdicts =
                    judged.iter().flat_map(|gyro| gyro.verdicts.iter().map(|v| VerdictBody::of(&gyro.serial, v)));
                serde_json::to_vec(&verdicts.collect::<Vec<_>>())
            };
            black_box(asked_in(language, words).await.expect("JSON"));
            *worded += begun.elapsed();
        }
    }
    drop(pipeline);
    written.await.expect("the writer stops");
    let each = |time: Duration| time.as_secs_f64() * 1e6 / RECORDS as f64;
    print!("{what}: {} verdicts a record, judged and stored in {:.0} us", verdicts / RECORDS, each(stored));
    for (language, worded) in Language::ALL.into_iter().zip(worded) {
        let percent = 100.0 * worded.as_secs_f64() / stored.as_secs_f64();
        print!("; {}: {:.1} us, {percent:.1} %", language.tag(), each(worded));
    }
    println!();
}
