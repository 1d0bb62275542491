//! `healthcheck`: whether the service on this machine is ready, for containers and supervisors.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, ensure};
use clap::Args;

use crate::cli::common::block_on;
use crate::config::{Config, Server};
use crate::system;

const PATIENCE: Duration = Duration::from_secs(10);

/// Ask the service on this machine whether it is ready; the exit status says so
#[derive(Debug, Args)]
pub struct Healthcheck {
    /// Configuration file that says where it listens; repeat for several, later ones win [default: config/*.toml]
    #[arg(long = "config", value_name = "FILE")]
    config: Vec<PathBuf>,
}

impl Healthcheck {
    pub fn run(self) -> anyhow::Result<()> {
        let address = address(&Config::load(&self.config, std::env::vars())?.server);
        // The certificate is for the service's name and not for this machine's loopback; nothing secret is sent.
        let client = system::http_client(PATIENCE, PATIENCE).danger_accept_invalid_certs(true).build()?;
        block_on(async {
            let answer = client.get(&address).send().await.with_context(|| format!("{address} does not answer"))?;
            let status = answer.status();
            ensure!(status.is_success(), "{address} answers {status}: {}", answer.text().await.unwrap_or_default());
            Ok(())
        })
    }
}

/// Where `/readyz` is on this machine.
fn address(server: &Server) -> String {
    let scheme = if server.is_encrypted() { "https" } else { "http" };
    let ip = match server.listen.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    format!("{scheme}://{}{}/readyz", SocketAddr::new(ip, server.listen.port()), server.base_path)
}
