//! A drawn fleet in a service of its own, sent and asked over HTTP as stations and engineers do.

use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, ensure};
use bytes::Bytes;
use serde_json::json;
use tokio::net::TcpListener;
use tokio::sync::oneshot;

use super::serve;
use crate::blindcheck::history::draw::DrawnFleet;
use crate::blindcheck::history::score::Answers;
use crate::blindcheck::history::sent::{records, serial};
use crate::cli::client::{JSON, Sent, Service};
use crate::config::Config;
use crate::core::judge::Mark;
use crate::http::{self, App};
use crate::routes::Routes;
use crate::system::Clock;
use crate::wire::record::RecordBody;
use crate::wire::time;

/// How long a drawn fleet's last request may take.
const GRACE: Duration = Duration::from_secs(5);

/// Sends the fleet's records and events to a new service, on a new file, and asks it for the diagnosis of every gyro.
pub(super) async fn ask(fleet: &DrawnFleet) -> anyhow::Result<Answers> {
    let dir = tempfile::tempdir()?;
    let mut config = Config::defaults();
    config.access.open = true;
    config.database.url = format!("sqlite://{}", dir.path().join("gyrowatch.db").display());
    config.judging.overrides.extend(limits(fleet)?);
    let config = Arc::new(config);

    let (pipeline, written) = serve::open(&config).await?;
    let pipeline = Arc::new(pipeline);
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let address = listener.local_addr()?;
    let app = App { config: Arc::clone(&config), clock: Clock::System, pipeline: Arc::clone(&pipeline) };
    let router = http::router(app, Routes::default());
    let (stop, stopped) = oneshot::channel::<()>();
    let served = tokio::spawn(async move {
        let told_or_gone = async { drop(stopped.await) };
        http::server::serve(listener, None, router, &config.server, told_or_gone).await;
    });

    let answered = async {
        let service = Service::at(&address.to_string(), None)?;
        send(&service, fleet).await?;
        let mut answers = Answers::new();
        for gyro in 0..fleet.gyros.len() {
            let serial = serial(gyro);
            let number = pipeline.queries.names().gyro_number(serial.as_str());
            let number = number.with_context(|| format!("{serial} is not known to the service"))?;
            answers.push(pipeline.queries.histories.explain(number, serial.as_str()).await?.coefficients);
        }
        anyhow::Ok(answers)
    }
    .await;
    drop(stop);
    let _ended = tokio::time::timeout(GRACE, served).await;
    drop(pipeline);
    written.await.context("the writer failed")?;
    answered
}

/// The budget that the asked gyro has, where it has one: from a stated baseline.
fn limits(fleet: &DrawnFleet) -> anyhow::Result<Option<crate::config::Override>> {
    let Some(budget) = fleet.budget() else { return Ok(None) };
    let coefficient = ["D_I", "D_S"][fleet.column];
    let limits = json!({
        "serial": serial(fleet.asked).as_str(),
        "coefficient": coefficient,
        "rules": {"baseline": budget.limit, "fixed_baseline": {"value": budget.baseline}},
    });
    Ok(Some(serde_json::from_value(limits)?))
}

async fn send(service: &Service, fleet: &DrawnFleet) -> anyhow::Result<()> {
    let records = records(fleet);
    let mut lines = Vec::new();
    for record in &records {
        serde_json::to_writer(&mut lines, &RecordBody::from(record))?;
        lines.push(b'\n');
    }
    for answer in service.import(Bytes::from(lines), records.len()).await? {
        ensure!(answer.status == 201, "a drawn record was answered {}: {:?}", answer.status, answer.error);
    }
    for (gyro, history) in fleet.gyros.iter().enumerate() {
        for Mark { at, event, .. } in &history.marks {
            let body =
                json!({"event": event.name(), "at": time::format(*at), "reason": "drawn", "author": "blindcheck"});
            let route = format!("/v1/gyros/{}/events", serial(gyro));
            let sent = service.post(&route, JSON, Bytes::from(body.to_string())).await?;
            ensure!(matches!(sent, Sent::Stored(_)), "{route}: {sent:?}");
        }
    }
    Ok(())
}
