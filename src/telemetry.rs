//! What the service counts about itself, for Prometheus: every metric is named and described here.
//!
//! The recorder is one a process, as the `metrics` macros want it. Without [`start`] (tests, command line) they count
//! nothing.

use std::sync::OnceLock;
use std::time::Duration;

use metrics::{Unit, counter, describe_counter, describe_gauge, describe_histogram, gauge, histogram};
use metrics_exporter_prometheus::{BuildError, Matcher, PrometheusBuilder, PrometheusHandle};
use metrics_process::Collector;

use crate::alert::HookKind;
use crate::core::judge::{Rule, State, Status};

pub const REQUESTS: &str = "gyrowatch_http_requests_total";
pub const REQUEST_TIME: &str = "gyrowatch_http_request_duration_seconds";
pub const ITEMS: &str = "gyrowatch_items_total";
pub const VERDICTS: &str = "gyrowatch_verdicts_total";
pub const STATUSES: &str = "gyrowatch_verdict_statuses_total";
pub const JUDGING: &str = "gyrowatch_judging_duration_seconds";
pub const COMMIT: &str = "gyrowatch_commit_duration_seconds";
pub const GROUP: &str = "gyrowatch_commit_items";
pub const WAITING: &str = "gyrowatch_writes_waiting";
pub const DATABASE: &str = "gyrowatch_database_size_bytes";
pub const LOG: &str = "gyrowatch_database_log_size_bytes";
pub const ATTEMPTS: &str = "gyrowatch_delivery_attempts_total";
pub const ATTEMPT_TIME: &str = "gyrowatch_delivery_attempt_duration_seconds";
pub const OUTBOX_AGE: &str = "gyrowatch_outbox_age_seconds";
pub const OUTBOX: &str = "gyrowatch_outbox_deliveries";
pub const HOOKS_DISABLED: &str = "gyrowatch_hooks_disabled";
pub const DIAGNOSES: &str = "gyrowatch_diagnoses_total";
pub const DIAGNOSIS_TIME: &str = "gyrowatch_diagnosis_duration_seconds";
pub const FORECAST_RMS: &str = "gyrowatch_forecast_rms_over_sd";
pub const DIAGNOSES_WAITING: &str = "gyrowatch_diagnoses_waiting";
pub const GYROS: &str = "gyrowatch_gyros";
pub const ALERTS: &str = "gyrowatch_alerts_firing";
pub const NEWEST_CALIBRATION: &str = "gyrowatch_station_newest_calibration_timestamp_seconds";
pub const STATION_OVERDUE: &str = "gyrowatch_station_overdue_gyros";
const BUILD: &str = "gyrowatch_build_info";

/// What items are, and what becomes of them.
pub const ITEM_KINDS: [&str; 8] =
    ["calibration", "bench_result", "event", "correction", "confirmation", "doubt", "window", "attributes"];
pub const ITEM_OUTCOMES: [&str; 4] = ["stored", "there", "refused", "failed"];
pub const ATTEMPT_OUTCOMES: [&str; 5] = ["delivered", "failed", "dead", "gone", "needless"];
pub const DIAGNOSIS_OUTCOMES: [&str; 3] = ["made", "refused", "failed"];

/// Upper bounds of the buckets of durations, seconds.
const DURATIONS: [f64; 11] = [0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0, 10.0];
/// Upper bounds of the buckets of group sizes.
const SIZES: [f64; 9] = [1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 256.0, 1024.0, 8192.0];
/// Upper bounds of the buckets of errors over their standard deviations.
const DEVIATIONS: [f64; 9] = [0.5, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0];
/// How often what was measured is sorted into its buckets: until then it takes memory.
const UPKEEP: Duration = Duration::from_secs(5);

static EXPORTER: OnceLock<PrometheusHandle> = OnceLock::new();

/// Begins to count. A second call changes nothing. Call it on a runtime: a task keeps the memory bounded.
///
/// # Errors
/// [`BuildError`] where another recorder is at work already.
pub fn start() -> Result<(), BuildError> {
    if EXPORTER.get().is_some() {
        return Ok(());
    }
    let handle = PrometheusBuilder::new()
        .set_buckets(&DURATIONS)?
        .set_buckets_for_metric(Matcher::Full(GROUP.to_owned()), &SIZES)?
        .set_buckets_for_metric(Matcher::Full(FORECAST_RMS.to_owned()), &DEVIATIONS)?
        .install_recorder()?;
    describe();
    begin_at_zero();
    Collector::default().describe();
    let exporter = EXPORTER.get_or_init(|| handle);
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(UPKEEP).await;
            exporter.run_upkeep();
        }
    });
    Ok(())
}

/// Everything counted so far and what the process takes, in Prometheus' text format; nothing before [`start`].
pub fn render() -> String {
    let Some(exporter) = EXPORTER.get() else { return String::new() };
    Collector::default().collect();
    exporter.render()
}

/// Every counter and histogram whose labels are known beforehand: `rate` and `increase` see nothing of one that begins
/// at 1. A histogram is there from when it is named.
fn begin_at_zero() {
    for (kind, outcome) in pairs(ITEM_KINDS, ITEM_OUTCOMES) {
        counter!(ITEMS, "kind" => kind, "outcome" => outcome).absolute(0);
    }
    for rule in Rule::ALL.map(Rule::name) {
        for state in State::ALL.map(State::name) {
            counter!(VERDICTS, "rule" => rule, "state" => state).absolute(0);
        }
        for status in Status::ALL.map(Status::name) {
            counter!(STATUSES, "rule" => rule, "status" => status).absolute(0);
        }
    }
    for (kind, outcome) in pairs(HookKind::ALL.map(HookKind::name), ATTEMPT_OUTCOMES) {
        counter!(ATTEMPTS, "kind" => kind, "outcome" => outcome).absolute(0);
    }
    for kind in HookKind::ALL.map(HookKind::name) {
        let _begun = histogram!(ATTEMPT_TIME, "kind" => kind);
    }
    for unlabelled in [JUDGING, COMMIT, GROUP, DIAGNOSIS_TIME, FORECAST_RMS] {
        let _begun = histogram!(unlabelled);
    }
    for outcome in DIAGNOSIS_OUTCOMES {
        counter!(DIAGNOSES, "outcome" => outcome).absolute(0);
    }
}

fn pairs<const N: usize, const M: usize>(
    first: [&'static str; N],
    second: [&'static str; M],
) -> impl Iterator<Item = (&'static str, &'static str)> {
    first.into_iter().flat_map(move |a| second.into_iter().map(move |b| (a, b)))
}

fn describe() {
    describe_counter!(REQUESTS, "Requests answered, by method, route and status.");
    describe_histogram!(REQUEST_TIME, Unit::Seconds, "From the request's head to the answer's, by method and route.");
    describe_counter!(
        ITEMS,
        "Items submitted, by kind and what became of them: stored, there before, refused, failed."
    );
    describe_counter!(VERDICTS, "Verdicts on new records, by rule and state.");
    describe_counter!(STATUSES, "Verdicts on new records, by rule and status.");
    describe_histogram!(JUDGING, Unit::Seconds, "Judging one group of items.");
    describe_histogram!(COMMIT, Unit::Seconds, "Writing one group of items until it is on disk.");
    describe_histogram!(GROUP, "Items that shared one commit.");
    describe_gauge!(WAITING, "Writes that wait for the writer.");
    describe_gauge!(DATABASE, Unit::Bytes, "Size of the database file.");
    describe_gauge!(LOG, Unit::Bytes, "Size of the write-ahead log beside it.");
    describe_counter!(
        ATTEMPTS,
        "Attempts to tell hooks, by kind and outcome: delivered, failed, dead, gone, needless."
    );
    describe_histogram!(ATTEMPT_TIME, Unit::Seconds, "One attempt to tell a hook, by kind.");
    describe_gauge!(OUTBOX_AGE, Unit::Seconds, "Age of the oldest delivery that enabled hooks are still to be told.");
    describe_gauge!(OUTBOX, "Deliveries, by state: open, dead.");
    describe_gauge!(HOOKS_DISABLED, "Hooks that the service has disabled: their targets are gone.");
    describe_counter!(
        DIAGNOSES,
        "Diagnoses that came to an end, by outcome: made, refused (the campaign leaves nothing to diagnose), failed."
    );
    describe_histogram!(DIAGNOSIS_TIME, Unit::Seconds, "Computing one diagnosis, behind all other work.");
    describe_histogram!(FORECAST_RMS, "Errors of a campaign's forecast over their standard deviations, rms.");
    describe_gauge!(DIAGNOSES_WAITING, "Campaigns that wait to be diagnosed, by what for: stored, ordered.");
    describe_gauge!(GYROS, "Gyros, by status: the worst of their verdicts and alerts, overdue ones by themselves.");
    describe_gauge!(
        ALERTS,
        "Alerts that fire and no other explains, acknowledged and silenced ones among them, by severity."
    );
    describe_gauge!(
        NEWEST_CALIBRATION,
        Unit::Seconds,
        "When the newest calibration of a station was made, Unix time, by station."
    );
    describe_gauge!(STATION_OVERDUE, "Gyros that are overdue, by the station that calibrated them last.");
    describe_gauge!(BUILD, "1, labelled with the version.");
    gauge!(BUILD, "version" => env!("CARGO_PKG_VERSION")).set(1.0);
}
