//! `demo`: a service with a history in it, to look at.

mod campaigns;
mod fleet;
mod input;
mod paper;

use std::net::SocketAddr;

use bytes::Bytes;
use indicatif::ProgressBar;
use serde_json::Value;

use super::serve;
use crate::cli::client::{JSON, Sent, Service};
use crate::cli::errors::with_causes;
use crate::cli::prelude::*;
use crate::core::message::text;
use input::DemoInput;

use crate::config::Config;
use crate::core::time::UtcMicros;
use crate::system::Clock;

/// Run the service on a file of its own, with the paper's figures and a fleet of two years in it
///
/// Everything is posted through the service's own HTTP API. Started again, it shows what is there already.
#[derive(Debug, Args)]
pub struct Demo {
    /// The database; created where it is missing.
    #[arg(long, value_name = "FILE", default_value = "gyrowatch-demo.db")]
    database: PathBuf,
    /// Address to listen on; port 0 takes a free one.
    #[arg(long, env = "GYROWATCH_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
}

impl Demo {
    pub fn run(self) -> anyhow::Result<()> {
        let keys = [
            ("GYROWATCH_SERVER__LISTEN".to_owned(), self.listen.to_string()),
            ("GYROWATCH_DATABASE__URL".to_owned(), format!("sqlite://{}", self.database.display())),
            ("GYROWATCH_ACCESS__OPEN".to_owned(), "true".to_owned()),
            ("GYROWATCH_LOG__FILTER".to_owned(), "warn".to_owned()),
            ("GYROWATCH_JUDGING__INTERVAL_DAYS".to_owned(), "90".to_owned()),
            ("GYROWATCH_JUDGING__REQUIREMENTS".to_owned(), "true".to_owned()),
        ];
        let config = Config::load(&[], keys)?;
        serve::run(config, |address| {
            tokio::spawn(async move {
                if let Err(error) = seed(address).await {
                    eprintln!("gyrowatch: {}", said(message!("terminal_demo_not_posted", why = with_causes(&error))));
                }
            });
        })
        .with_context(|| said(message!("terminal_demo_on", address = text(self.listen))))
    }
}

/// Posts paper and fleet, unless they are there, and says what to look at.
async fn seed(address: SocketAddr) -> anyhow::Result<()> {
    let service = Service::at(&address.to_string(), None)?;
    let gyros: Value = service.get("/v1/gyros?limit=1").await?;
    if gyros["gyros"].as_array().is_none_or(Vec::is_empty) {
        post_all(&service).await?;
    }
    let base = service.base();
    println!("\n{}", said(message!("terminal_demo_pages", base = base.to_owned())));
    Ok(())
}

async fn post_all(service: &Service) -> anyhow::Result<()> {
    let today = last_friday(Clock::System.now());
    let mut inputs = paper::inputs(today);
    inputs.extend(fleet::draw(today));
    inputs.extend(campaigns::inputs(today)?);
    inputs.sort_by(|a, b| a.at().cmp(b.at()));
    let bar = ProgressBar::new(inputs.len() as u64);
    for happening in &inputs {
        let (route, body) = happening.request()?;
        match service.post(&route, JSON, Bytes::from(body)).await {
            Ok(Sent::Stored(_) | Sent::Known(_)) => bar.inc(1),
            Ok(Sent::Refused(problem)) => bail!("{route} {}: {}", happening.at(), problem.detail),
            Err(trouble) => return Err(trouble).context(route),
        }
    }
    bar.finish_and_clear();
    println!("{}", said(message!("terminal_demo_posted", count = inputs.len().to_string())));
    Ok(())
}

/// The beginning of the newest Friday (UTC): rules that average calendar weeks find the same in the demo on every day.
fn last_friday(now: UtcMicros) -> UtcMicros {
    // The first day of the count, 1970-01-01, was a Thursday.
    let friday = UtcMicros::DAY;
    UtcMicros(now.0 - (now.0 - friday).rem_euclid(7 * UtcMicros::DAY))
}
