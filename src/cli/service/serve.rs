//! `gyrowatch serve`: the service, until it is told to stop.

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tracing_subscriber::EnvFilter;

use super::notify;
use super::settings::{ConfigArgs, unread_variables};
use crate::cli::prelude::*;
use crate::config::{Config, Log, LogFormat};
use crate::core::message::text;
use crate::http::tls::Tls;
use crate::http::{self, App};
use crate::pages::{self, Pages};
use crate::pipeline::{Outbox, Pipeline};
use crate::system::Clock;
use crate::{store, telemetry};

/// Run the service
#[derive(Debug, Args)]
pub struct Serve {
    #[command(flatten)]
    config: ConfigArgs,
}

impl Serve {
    pub fn run(self) -> anyhow::Result<()> {
        run(self.config.load()?, |_| {})
    }
}

/// Serves until told to stop. `ready` is called once, with the address, when connections are accepted.
pub(super) fn run(config: Config, ready: impl FnOnce(SocketAddr)) -> anyhow::Result<()> {
    start_log(&config.log)?;
    for warning in unread_variables() {
        tracing::warn!("{}", said(warning));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let served = runtime.block_on(async {
        let (stopping, stop) = watch::channel(false);
        let grace = Duration::from_secs_f64(config.server.shutdown_grace_s);
        let stopped = stop_signal()?;
        tokio::spawn(async move {
            stopped.await;
            let _ended_already = stopping.send(true);
        });
        let over = over(stop.clone(), grace);
        tokio::select! {
            served = serve(config, ready, told(stop)) => served,
            () = over => Err(anyhow::anyhow!(said(message!("terminal_not_ended", seconds = text(grace.as_secs_f64()))))),
        }
    });
    // What is not at its end now waits for a host that does not answer.
    runtime.shutdown_background();
    served
}

/// Resolves once it is to stop.
async fn told(mut stop: watch::Receiver<bool>) {
    let _ending = stop.wait_for(|stop| *stop).await;
}

async fn over(stop: watch::Receiver<bool>, grace: Duration) {
    told(stop).await;
    tokio::time::sleep(grace).await;
}

async fn serve(
    mut config: Config,
    ready: impl FnOnce(SocketAddr),
    stop: impl Future<Output = ()>,
) -> anyhow::Result<()> {
    telemetry::start()?;
    config.server.check_exposure()?;
    let tls = config.server.tls_files().map(|(certificate, key)| Tls::start(certificate, key)).transpose()?;
    let listener = TcpListener::bind(config.server.listen)
        .await
        .with_context(|| said(message!("terminal_cannot_listen", address = text(config.server.listen))))?;
    let address = listener.local_addr()?;
    let url = format!("{}://{address}", if tls.is_some() { "https" } else { "http" });
    if config.hooks.external_url().is_none() && !address.ip().is_unspecified() {
        config.hooks.external_url.clone_from(&url);
    }
    let config = Arc::new(config);
    let (pipeline, writing) = open(&config).await?;
    let served = serve_with(pipeline, config, (listener, address, &url), tls, stop, ready).await;
    // The router and the worker are gone, and with them the last sender: the writer finishes what is queued and
    // closes the database.
    writing.await.context("the writer failed")?;
    served?;
    tracing::info!("stopped");
    Ok(())
}

/// The pipeline on the database of the configuration, and the end of its writing.
pub(super) async fn open(config: &Arc<Config>) -> anyhow::Result<(Pipeline, JoinHandle<()>)> {
    let database = || said(message!("terminal_cannot_use", database = config.database.options().shown()));
    let (store, mut writer) = store::open(&config.database.options()).await.with_context(database)?;
    let store = store.with(config.secrets.clone());
    let hidden = store::hide_stored_secrets(&store, &mut writer).await.with_context(database)?;
    if hidden > 0 {
        tracing::info!(hooks = hidden, "the secrets of hooks are encrypted now");
    }
    Pipeline::start(store, writer, Arc::clone(config), Clock::System).await.with_context(database)
}

async fn serve_with(
    pipeline: Pipeline,
    config: Arc<Config>,
    (listener, address, url): (TcpListener, SocketAddr, &str),
    tls: Option<Tls>,
    stop: impl Future<Output = ()>,
    ready: impl FnOnce(SocketAddr),
) -> anyhow::Result<()> {
    if !address.ip().is_loopback() && !pipeline.access.guard().asks_for_tokens() {
        anyhow::bail!(said(message!("terminal_token_first", address = text(address))));
    }
    warn_without_tokens(&pipeline);
    let outbox = Outbox::start(&pipeline.hooks)?;
    let pipeline = Arc::new(pipeline);
    let api = serde_json::to_value(http::description(&config.server))?;
    let pages = Pages {
        config: Arc::clone(&config),
        clock: Clock::System,
        pipeline: Arc::clone(&pipeline),
        api: Arc::new(api),
    };
    let app = App { config: Arc::clone(&config), clock: Clock::System, pipeline };
    let router = http::router(app, pages::router(pages));
    tracing::info!(%address, database = %config.database.options().shown(), "listening");
    println!("{}", said(message!("terminal_listens", url = url.to_owned())));
    notify::tell(notify::READY);
    ready(address);
    http::server::serve(listener, tls, router, &config.server, stop).await;
    outbox.stop().await;
    Ok(())
}

/// Until there is a token, who asks is told by their address, which a reverse proxy on this machine shares with all
/// whom it lets through.
fn warn_without_tokens(pipeline: &Pipeline) {
    let guard = pipeline.access.guard();
    match guard.setup_secret() {
        _ if guard.asks_for_tokens() => {}
        Some(secret) => tracing::warn!(
            setup_secret = secret.reveal(),
            "no token has been made: whoever reaches this address may read, post and acknowledge, and behind a reverse proxy that is \
             everybody. Behind a proxy make a token first: `gyrowatch token create NAME --role admin`, or POST /v1/tokens with \
             `Authorization: Bearer` and this setup secret, which the first token uses up"
        ),
        None => tracing::warn!(
            "no token has been made and access.open is set: whoever reaches this address may do everything, and behind a reverse \
             proxy that is everybody. Behind a proxy make a token first: `gyrowatch token create NAME --role admin`"
        ),
    }
}

/// Resolves at SIGTERM or SIGINT.
fn stop_signal() -> anyhow::Result<impl Future<Output = ()>> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    Ok(async move {
        let name = tokio::select! { _ = terminate.recv() => "SIGTERM", _ = interrupt.recv() => "SIGINT" };
        notify::tell(notify::STOPPING);
        tracing::info!(signal = name, "stopping: requests in flight are finished");
    })
}

fn start_log(log: &Log) -> anyhow::Result<()> {
    let filter = EnvFilter::try_new(&log.filter).with_context(|| format!("log.filter: {:?}", log.filter))?;
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours);
    // A log that cannot be written, on a disk that is full say, must not end what it tells of: the complaint about it
    // panics.
    let builder = builder.log_internal_errors(false);
    let started = match log.format {
        LogFormat::Text => builder.try_init(),
        LogFormat::Json => builder.json().try_init(),
    };
    started.map_err(|error| anyhow::anyhow!(error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::routes::AccessRule;

    #[test]
    fn the_table_of_the_documentation_is_that_of_the_service() {
        let config = Config::defaults();
        let (api, pages) = (http::routes(&config.server), pages::routes());
        let description = serde_json::to_value(api.description()).unwrap();
        let row = |rule: &AccessRule| {
            let role = rule.least.map_or("-", |role| role.name());
            format!("| {} | `{}` | {role} |", rule.method, rule.path)
        };
        // What the description has an operation of, and the rest.
        let (calls, pages): (Vec<_>, Vec<_>) =
            api.rules().iter().chain(pages.rules()).partition(|rule| rule.takes.is_some());
        let calls = calls.into_iter().map(|rule| {
            let summary = &description["paths"][&rule.path][rule.method.as_str().to_lowercase()]["summary"];
            format!("{} {} |\n", row(rule), summary.as_str().unwrap().replace('\n', " "))
        });
        let pages = pages.into_iter().map(|rule| row(rule) + "\n");
        let expected = format!(
            "| method | route | role | what it does |\n|---|---|---|---|\n{}\n## Pages\n\n\
             <!-- printed by the test of src/cli/service/serve.rs -->\n\n\
             | method | route | role |\n|---|---|---|\n{}",
            calls.collect::<String>(),
            pages.collect::<String>()
        );
        let (_, documented) = include_str!("../../../docs/routes.md").split_once("-->\n\n").unwrap();
        assert!(documented == expected, "docs/routes.md has to say\n{expected}");
    }
}
