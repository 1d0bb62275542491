//! `diagnose --all`: has a running service diagnose its stored campaigns, follows it, and prints what they say
//! together.
//!
//! The service works and remembers. Breaking off here breaks nothing off there: the same command finds the same order
//! again.

use std::time::{Duration, Instant};

use bytes::Bytes;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::cli::client::{ClientError, Connection, JSON, Sent, Service};
use crate::cli::common::{block_on, progress};
use crate::cli::document::{part_of, verdict};
use crate::cli::prelude::*;
use crate::core::message::Message;
use crate::wire::diagnoses::{
    CoverageBody, DoubtBody, FailureBody, FindingBody, JobDetailBody, SummaryBody, WhichBody,
};

/// How often progress is asked for.
const STEP: Duration = Duration::from_millis(500);
/// For how long a service that is away or busy is asked again.
const PATIENCE: Duration = Duration::from_secs(60);
/// Failures that are named; all are counted.
const MOST_NAMED: usize = 1000;

/// Which service, and which of its campaigns.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "With --all")]
pub struct FleetArgs {
    /// Campaigns of this IMU alone
    #[arg(long, conflicts_with = "campaign")]
    imu: Option<String>,

    /// Campaigns of this station alone
    #[arg(long, conflicts_with = "campaign")]
    station: Option<String>,

    /// Campaigns measured from this time on, RFC 3339
    #[arg(long, value_name = "TIME", conflicts_with = "campaign")]
    since: Option<String>,

    /// Campaigns measured up to this time, RFC 3339
    #[arg(long, value_name = "TIME", conflicts_with = "campaign")]
    until: Option<String>,

    /// Also those whose diagnosis is up to date: made by this version of the program, against the model in force
    #[arg(long, conflicts_with = "campaign")]
    again: bool,

    #[command(flatten)]
    connection: Connection,
}

impl FleetArgs {
    /// The service that is asked.
    pub fn service(&self) -> anyhow::Result<Service> {
        self.connection.service()
    }

    fn which(&self) -> WhichBody {
        let Self { imu, station, since, until, again, .. } = self;
        WhichBody {
            imu: imu.clone(),
            station: station.clone(),
            since: since.clone(),
            until: until.clone(),
            again: *again,
        }
    }

    /// Of the summary of the same campaigns.
    fn query(&self) -> String {
        let all = [("imu", &self.imu), ("station", &self.station), ("since", &self.since), ("until", &self.until)];
        let stated = all.into_iter().filter_map(|(name, value)| Some((name, value.as_ref()?)));
        url::form_urlencoded::Serializer::new(String::new()).extend_pairs(stated).finish()
    }
}

pub fn run(fleet: &FleetArgs, format: Format) -> anyhow::Result<()> {
    let service = fleet.service()?;
    block_on(all(fleet, &service, format))
}

async fn all(fleet: &FleetArgs, service: &Service, format: Format) -> anyhow::Result<()> {
    let order = order(fleet, service).await?;
    let ended = follow(service, order).await?;
    for FailureBody { campaign, imu, measured_at, reason } in ended.failures {
        eprintln!("{}", said(message!("terminal_diagnosis_failed", campaign, imu, at = measured_at, reason)));
    }
    if ended.job.state == "canceled" {
        let (id, count) = (ended.job.id, ended.job.counts.canceled);
        bail!(said(message!("terminal_order_canceled", id, count)));
    }
    let route = format!("/v1/diagnoses/summary?{}", fleet.query());
    let summary: SummaryBody = patiently(async || service.ask(&route).await).await?;
    format.show(&summary, || tables(&summary))?;
    match ended.job.counts.failed {
        0 => Ok(()),
        failed => bail!(said(message!("terminal_not_diagnosed", failed, count = ended.job.counts.campaigns))),
    }
}

/// Begins an order, or finds the one that is being worked off.
async fn order(fleet: &FleetArgs, service: &Service) -> anyhow::Result<JobDetailBody> {
    let body = Bytes::from(serde_json::to_vec(&fleet.which())?);
    let post = async || match service.post("/v1/diagnoses", JSON, body.clone()).await? {
        Sent::Stored(answer) | Sent::Known(answer) => Ok(answer),
        Sent::Refused(problem) => Err(ClientError::stop(None, problem.detail)),
    };
    patiently(post).await
}

/// Until the order has ended, also over a restart of the service.
async fn follow(service: &Service, mut order: JobDetailBody) -> anyhow::Result<JobDetailBody> {
    let bar = progress(order.job.counts.campaigns, "{bar:30} {pos}/{len} campaigns, {eta} to go {msg}");
    let path = format!("/v1/diagnoses/{}?limit={MOST_NAMED}", order.job.id);
    loop {
        let counts = order.job.counts;
        bar.set_position(counts.campaigns - counts.waiting);
        if counts.failed > 0 {
            bar.set_message(format!("({} failed)", counts.failed));
        }
        if order.job.ended_at.is_some() {
            bar.finish_and_clear();
            return Ok(order);
        }
        tokio::time::sleep(STEP).await;
        let goes_on = || said(message!("terminal_order_goes_on", id = order.job.id.clone()));
        order = patiently(async || service.ask(&path).await).await.with_context(goes_on)?;
    }
}

/// Asks until there is an answer, as long as that can help.
async fn patiently<T: DeserializeOwned>(ask: impl AsyncFn() -> Result<Value, ClientError>) -> anyhow::Result<T> {
    let begun = Instant::now();
    let answer = loop {
        match ask().await {
            Ok(answer) => break answer,
            Err(trouble) => wait(trouble, begun).await?,
        }
    };
    serde_json::from_value(answer).with_context(|| word("terminal_foreign_answer"))
}

/// Waits before another try, where one can help and patience is left.
async fn wait(trouble: ClientError, begun: Instant) -> anyhow::Result<()> {
    let pause = match &trouble {
        ClientError::Fatal { .. } => return Err(trouble.into()),
        ClientError::Unreachable(_) => STEP,
        ClientError::Retry { after, .. } => after.unwrap_or(STEP),
    };
    if begun.elapsed() + pause > PATIENCE {
        return Err(trouble.into());
    }
    tokio::time::sleep(pause).await;
    Ok(())
}

fn tables(summary: &SummaryBody) -> String {
    let sections = [findings(&summary.findings), doubts(&summary.doubts)];
    let mut out = coverage(&summary.campaigns);
    for section in sections.into_iter().flatten() {
        out.push_str("\n\n");
        out.push_str(&section);
    }
    out
}

fn coverage(c: &CoverageBody) -> String {
    let joined = |counts: &[(u64, Message)]| {
        let some = counts.iter().filter(|(count, _)| *count > 0);
        some.map(|(_, what)| said(what)).collect::<Vec<_>>().join(", ")
    };
    let outcomes = joined(&[
        (c.no_gap, message!("terminal_clean", count = c.no_gap)),
        (c.explained, message!("terminal_count_explained", count = c.explained)),
        (c.partly_explained, message!("terminal_count_partly", count = c.partly_explained)),
        (c.unexplained, message!("terminal_count_unexplained", count = c.unexplained)),
    ]);
    let beside = joined(&[
        (c.outdated, message!("terminal_count_outdated", count = c.outdated)),
        (c.refused, message!("terminal_count_refused", count = c.refused)),
        (c.waiting, message!("terminal_count_waiting", count = c.waiting)),
    ]);
    let outcomes = if outcomes.is_empty() { outcomes } else { format!(": {outcomes}") };
    let beside = if beside.is_empty() { beside } else { format!("; {beside}") };
    format!("{}{outcomes}{beside}", said(message!("terminal_diagnosed", count = c.diagnosed)))
}

fn findings(all: &[FindingBody]) -> Option<String> {
    let mut rows = table_of("terminal_findings_head", 7..11);
    for f in all {
        let others: Vec<&str> = f.class.iter().map(String::as_str).filter(|id| *id != f.effect).collect();
        let or = || said(message!("terminal_or", effects = others.join(", ")));
        let effect = if others.is_empty() { f.effect.clone() } else { format!("{}\n({})", f.effect, or()) };
        let stations: Vec<String> =
            f.stations.iter().map(|at| format!("{} {}/{}", at.station, at.campaigns, at.of)).collect();
        let shift = |name: &str| {
            let found = f.impact.iter().find(|i| i.coefficient == name);
            found.map_or_else(|| "-".to_owned(), |i| format!("{:+.6}\n{:.0} %", i.shift, 100.0 * i.of_budget))
        };
        let c = &f.closure;
        let range = message!("terminal_to", from = format!("{:.2}", c.least), to = format!("{:.2}", c.greatest));
        rows.add_row([
            effect,
            format!("{} {}", f.serial, f.slot),
            f.imu.clone(),
            stations.join("\n"),
            day(f.clear_at.as_deref().unwrap_or("-")),
            day(&f.first.measured_at),
            day(&f.last.measured_at),
            part_of(format!("{}/{}", f.campaigns, f.of_since), f.of),
            format!("{:.2}\n({})", c.median, said(range)),
            shift("D_I"),
            shift("D_S"),
        ]);
    }
    let (title, key) = (word("terminal_effects"), said(message!("terminal_findings_key")));
    (!all.is_empty()).then(|| format!("{title}\n{rows}\n{key}"))
}

fn doubts(all: &[DoubtBody]) -> Option<String> {
    let mut rows = table_of("terminal_doubts_head", 5..6);
    for d in all {
        rows.add_row([
            d.imu.clone(),
            said(verdict(&d.verdict)),
            d.gyros.join(" "),
            d.signs.join("\n"),
            d.stations.join("\n"),
            part_of(d.campaigns.to_string(), d.of),
            day(&d.first.measured_at),
            day(&d.last.measured_at),
        ]);
    }
    (!all.is_empty()).then(|| format!("{}\n{rows}", word("terminal_doubts")))
}

/// The date of an RFC 3339 time.
fn day(at: &str) -> String {
    at.split('T').next().unwrap_or(at).to_owned()
}
