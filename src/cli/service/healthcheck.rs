//! `healthcheck`: whether the service on this machine is ready, for containers and supervisors.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;

use anyhow::anyhow;
use serde_json::Value;

use super::settings::ConfigArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::config::Server;
use crate::system;
use crate::wire::cause;

const PATIENCE: Duration = Duration::from_secs(10);

/// Ask the service on this machine whether it is ready; the exit status says so
#[derive(Debug, Args)]
pub struct Healthcheck {
    #[command(flatten)]
    config: ConfigArgs,
}

impl Healthcheck {
    pub fn run(self) -> anyhow::Result<()> {
        let address = address(&self.config.load()?.server, "readyz");
        block_on(async {
            let away = |error: reqwest::Error| {
                let (address, why) = (address.clone(), cause::root_of(&error));
                anyhow!(said(message!("terminal_no_answer", address, why)))
            };
            let answer = client()?.get(&address).send().await.map_err(away)?;
            let status = answer.status();
            if status.is_success() {
                return Ok(());
            }
            let (status, why) = (status.to_string(), answer.text().await.unwrap_or_default());
            bail!(said(message!("terminal_answers", address, status, why)))
        })
    }
}

/// Whether a service answers where the configuration has one listen.
pub(super) async fn is_running(server: &Server) -> bool {
    let asked = async { client().ok()?.get(address(server, "healthz")).send().await.ok()?.text().await.ok() };
    let said: Option<Value> = asked.await.and_then(|text| serde_json::from_str(&text).ok());
    said.is_some_and(|said| said["status"] == "ok" && said["version"].is_string())
}

/// The certificate is for the service's name and not for this machine's loopback; nothing secret is sent.
fn client() -> reqwest::Result<reqwest::Client> {
    system::http_client(PATIENCE, PATIENCE).danger_accept_invalid_certs(true).build()
}

/// Where a route is on this machine.
fn address(server: &Server, route: &str) -> String {
    let scheme = if server.is_encrypted() { "https" } else { "http" };
    let ip = match server.listen.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    format!("{scheme}://{}{}/{route}", SocketAddr::new(ip, server.listen.port()), server.base_path)
}
