//! The configuration: defaults, files, environment, in that order; checked whole before anything starts.

mod access;
mod alerts;
mod error;
mod hooks;
mod judging;
mod log;
mod requirement;
mod rules;
mod stations;
mod values;
mod variables;

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use config::builder::DefaultState;
use config::{Config as Layers, ConfigBuilder, File, FileFormat};
use ipnet::IpNet;
use serde::Deserialize;
use serde_json::Value;

use crate::alert::target::TargetPolicy;
use crate::core::message::{sent, text};
use crate::core::record::Plausibility;
use crate::core::time::UtcMicros;
use crate::message;
use crate::store::{Options, Secrets, without_password};

pub use crate::core::separate::JudgedMethod;
pub use access::AccessConfig;
pub use alerts::AlertsConfig;
pub use error::ConfigError;
use error::{not_negative, of_serde};
pub use hooks::HooksConfig;
pub use judging::{Judging, Override};
pub use log::{Log, LogFormat};
pub use requirement::SlotRequirements;
pub use rules::FixedBaseline;
pub use stations::{StatedUncertainty, Stations};
pub use variables::unread;
use variables::{DEFAULTS, variables};

/// What `server.plain_http` must say for HTTP beyond this machine.
pub const PLAIN_HTTP: &str = "anybody on the network can read tokens and records, and change them";

type LayersBuilder = ConfigBuilder<DefaultState>;

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    pub server: Server,
    pub access: AccessConfig,
    pub database: Database,
    pub judging: Judging,
    pub stations: Stations,
    pub alerts: AlertsConfig,
    pub hooks: HooksConfig,
    pub plausibility: PlausibilityKeys,
    pub log: Log,
    /// The key that the secrets of hooks are encrypted with: of the environment alone, in no file.
    #[serde(skip)]
    pub secrets: Secrets,
    #[serde(skip)]
    pub stated: StatedKeys,
}

/// What files and environment say, each by itself: where the value of a key comes from.
#[derive(Debug, Clone, Default)]
pub struct StatedKeys {
    files: Value,
    environment: Value,
}

/// Where the value of a key comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    Default,
    File,
    Environment,
}

impl StatedKeys {
    /// Of a key such as `judging.budget`, or a table of keys.
    pub fn layer_of(&self, key: &str) -> Layer {
        let pointer = format!("/{}", key.replace('[', ".").replace(']', "").replace('.', "/"));
        match () {
            () if self.environment.pointer(&pointer).is_some() => Layer::Environment,
            () if self.files.pointer(&pointer).is_some() => Layer::File,
            () => Layer::Default,
        }
    }
}

const SECRETS_KEY: &str = "GYROWATCH_SECRETS_KEY";

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Server {
    #[serde(deserialize_with = "values::address")]
    pub listen: SocketAddr,
    pub tls_certificate: Option<PathBuf>,
    pub tls_key: Option<PathBuf>,
    pub plain_http: String,
    #[serde(deserialize_with = "values::networks")]
    pub trusted_proxies: Vec<IpNet>,
    pub base_path: String,
    pub max_body_bytes: usize,
    pub max_import_bytes: usize,
    pub max_import_line_bytes: usize,
    pub header_timeout_s: f64,
    pub body_timeout_s: f64,
    pub request_timeout_s: f64,
    pub max_connections: usize,
    pub shutdown_grace_s: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Database {
    pub url: String,
    pub readers: u32,
    pub busy_timeout_s: f64,
    pub cache_kib: u32,
    pub checkpoint_pages: u32,
    pub lease_s: f64,
    pub max_waiting_writes: usize,
    pub max_group: usize,
    pub writers: usize,
}

impl Server {
    /// Whether what travels is encrypted here.
    pub fn is_encrypted(&self) -> bool {
        self.tls_certificate.is_some()
    }

    /// Whether the configuration says that a proxy stands in front.
    pub fn is_behind_proxy(&self) -> bool {
        !(self.trusted_proxies.is_empty() && self.base_path.is_empty())
    }

    /// Certificate and key, where there are any.
    pub fn tls_files(&self) -> Option<(&Path, &Path)> {
        self.tls_certificate.as_deref().zip(self.tls_key.as_deref())
    }

    /// Whether the service may be reached at its address by what the configuration says.
    ///
    /// # Errors
    /// [`ConfigError::Key`] where tokens would travel in the open and nobody has said that they may.
    pub fn check_exposure(&self) -> Result<(), ConfigError> {
        if self.listen.ip().is_loopback() || self.is_encrypted() || self.plain_http == PLAIN_HTTP {
            return Ok(());
        }
        let fault = message!("config_in_the_open", address = text(self.listen), value = PLAIN_HTTP);
        Err(ConfigError::of("server.listen", fault))
    }

    fn check(&self) -> Result<(), ConfigError> {
        let require = |holds, key: &str, fault| ConfigError::unless(holds, format!("server.{key}"), fault);
        let (certificate, key) = (self.tls_certificate.is_some(), self.tls_key.is_some());
        require(key || !certificate, "tls_key", message!("missing_beside", member = "server.tls_certificate"))?;
        require(certificate || !key, "tls_certificate", message!("missing_beside", member = "server.tls_key"))?;
        let is_agreed = self.plain_http.is_empty() || self.plain_http == PLAIN_HTTP;
        require(is_agreed, "plain_http", message!("config_plain_http", wanted = PLAIN_HTTP))?;
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_~.".contains(c);
        let is_segment = |part: &str| !part.is_empty() && part != "." && part != ".." && part.chars().all(is_plain);
        let segments = self.base_path.strip_prefix('/').map(|rest| rest.split('/').all(is_segment));
        let is_prefix = self.base_path.is_empty() || segments == Some(true);
        require(is_prefix, "base_path", message!("config_base_path", value = sent(&self.base_path)))
    }
}

/// What the address of a database may begin with.
const DATABASES: [&str; 3] = ["sqlite:", "postgres://", "postgresql://"];

impl Database {
    /// An address without a scheme would be taken for a file of that name.
    fn check(&self) -> Result<(), ConfigError> {
        if DATABASES.iter().any(|scheme| self.url.starts_with(scheme)) {
            return Ok(());
        }
        Err(ConfigError::of("database.url", message!("config_database", value = sent(&self.options().shown()))))
    }

    /// How the store is to be opened. On a server the pool of readers also has one connection per writer.
    pub fn options(&self) -> Options {
        let mut options = Options {
            url: self.url.clone(),
            readers: self.readers,
            busy_timeout: Duration::from_secs_f64(self.busy_timeout_s),
            cache_kib: self.cache_kib,
            checkpoint_pages: self.checkpoint_pages,
            lease: Duration::from_secs_f64(self.lease_s),
        };
        if options.is_server() {
            // Each writer reads while it writes.
            options.readers += self.writers as u32;
        }
        options
    }
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlausibilityKeys {
    pub min_scale_factor: f64,
    pub max_scale_factor: f64,
    pub max_misalignment_deg: f64,
    pub max_drift_deg_per_h_g0: f64,
    #[serde(deserialize_with = "values::instant")]
    pub earliest: UtcMicros,
    #[serde(deserialize_with = "values::instants")]
    pub clock_epochs: Vec<UtcMicros>,
    pub max_future_hours: f64,
}

impl PlausibilityKeys {
    fn check(&self) -> Result<(), ConfigError> {
        let (least, most) = (self.min_scale_factor, self.max_scale_factor);
        let fault =
            message!("config_above_max", max = "plausibility.max_scale_factor", value = text(least), most = text(most));
        ConfigError::unless(least < most, "plausibility.min_scale_factor", fault)?;
        not_negative("plausibility.max_future_hours", self.max_future_hours)
    }

    /// The limits in the core's units: angles in radians.
    pub fn limits(&self) -> Plausibility {
        Plausibility {
            scale_factor: (self.min_scale_factor, self.max_scale_factor),
            max_misalignment: self.max_misalignment_deg.to_radians(),
            max_drift: self.max_drift_deg_per_h_g0,
        }
    }
}

impl Config {
    /// Defaults, then `files` (or `config/*.toml` but `default.toml`, where none are named), then `environment`.
    pub fn load(
        files: &[PathBuf],
        environment: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self, ConfigError> {
        Self::of(&files_or_found(files), environment)
    }

    fn of(files: &[PathBuf], environment: impl IntoIterator<Item = (String, String)>) -> Result<Self, ConfigError> {
        let environment: Vec<_> = environment.into_iter().collect();
        let secrets = secrets(&environment)?;
        let stated = StatedKeys {
            files: of_files(Layers::builder(), files).build()?.try_deserialize()?,
            environment: Layers::builder().add_source(variables(environment.clone())).build()?.try_deserialize()?,
        };
        Ok(Self { secrets, stated, ..Self::read(merged(files, environment)?)? })
    }

    /// What [`Config::load`] takes its values from, as one file (TOML), once it has been checked. A password within
    /// an address is left out.
    pub fn in_force(
        files: &[PathBuf],
        environment: impl IntoIterator<Item = (String, String)>,
    ) -> Result<String, ConfigError> {
        let environment: Vec<_> = environment.into_iter().collect();
        let _checked = secrets(&environment)?;
        let mut merged = merged(&files_or_found(files), environment)?;
        Self::read(merged.clone())?;
        for key in ["/hooks/external_url", "/hooks/proxy", "/hooks/smtp_url", "/database/url"] {
            if let Some(Value::String(address)) = merged.pointer_mut(key) {
                *address = without_password(address);
            }
        }
        toml::to_string(&merged).map_err(|error| ConfigError::Unreadable(error.to_string()))
    }

    fn read(merged: Value) -> Result<Self, ConfigError> {
        let config: Self = serde_path_to_error::deserialize(merged)
            .map_err(|e| ConfigError::of(e.path().to_string(), of_serde(e.inner())))?;
        config.check()?;
        Ok(config)
    }

    /// The defaults alone.
    ///
    /// # Panics
    /// Never: a test loads them.
    pub fn defaults() -> Self {
        Self::of(&[], []).expect("the built-in defaults are checked by a test")
    }

    fn check(&self) -> Result<(), ConfigError> {
        let positive = [
            ("server.header_timeout_s", self.server.header_timeout_s),
            ("server.body_timeout_s", self.server.body_timeout_s),
            ("server.request_timeout_s", self.server.request_timeout_s),
            ("server.max_body_bytes", self.server.max_body_bytes as f64),
            ("server.max_import_bytes", self.server.max_import_bytes as f64),
            ("server.max_import_line_bytes", self.server.max_import_line_bytes as f64),
            ("server.max_connections", self.server.max_connections as f64),
            ("database.busy_timeout_s", self.database.busy_timeout_s),
            ("database.lease_s", self.database.lease_s),
            ("database.checkpoint_pages", f64::from(self.database.checkpoint_pages)),
            ("database.readers", f64::from(self.database.readers)),
            ("database.max_waiting_writes", self.database.max_waiting_writes as f64),
            ("database.max_group", self.database.max_group as f64),
            ("database.writers", self.database.writers as f64),
            ("plausibility.min_scale_factor", self.plausibility.min_scale_factor),
            ("plausibility.max_scale_factor", self.plausibility.max_scale_factor),
            ("plausibility.max_misalignment_deg", self.plausibility.max_misalignment_deg),
            ("plausibility.max_drift_deg_per_h_g0", self.plausibility.max_drift_deg_per_h_g0),
            ("alerts.repeat_days", self.alerts.repeat_days),
            ("judging.budget", self.judging.budget),
            ("judging.range_days", self.judging.range_days),
            ("judging.agreement_days", self.judging.agreement_days),
            ("judging.remembered_records", self.judging.remembered_records as f64),
        ];
        for (key, value) in positive {
            ConfigError::unless(value.is_finite() && value > 0.0, key, message!("not_positive", value = text(value)))?;
        }
        not_negative("server.shutdown_grace_s", self.server.shutdown_grace_s)?;
        self.server.check()?;
        self.database.check()?;
        self.access.check()?;
        self.alerts.check()?;
        self.hooks.check()?;
        self.stations.check()?;
        self.plausibility.check()?;
        self.log.check()?;
        self.judging.check()
    }

    /// Where hooks may go: to loopback only in the company of a service that listens on loopback alone.
    pub fn target_policy(&self) -> TargetPolicy {
        TargetPolicy { allow: self.hooks.allow.clone(), loopback: self.server.listen.ip().is_loopback() }
    }
}

fn secrets(environment: &[(String, String)]) -> Result<Secrets, ConfigError> {
    let text = environment.iter().find(|(name, _)| name == SECRETS_KEY).map_or("", |(_, text)| text.as_str());
    // It is secret, so that it is not repeated.
    Secrets::with_key(text).ok_or_else(|| ConfigError::of(SECRETS_KEY, message!("config_secrets_key")))
}

/// Defaults, files and environment, the later ones over the earlier.
fn merged(files: &[PathBuf], environment: impl IntoIterator<Item = (String, String)>) -> Result<Value, ConfigError> {
    let layers = Layers::builder().add_source(File::from_str(DEFAULTS, FileFormat::Toml));
    Ok(of_files(layers, files).add_source(variables(environment)).build()?.try_deserialize()?)
}

fn of_files(layers: LayersBuilder, files: &[PathBuf]) -> LayersBuilder {
    files.iter().fold(layers, |layers, file| layers.add_source(File::from(file.as_path()).format(FileFormat::Toml)))
}

/// The files that were named, or else those of the working directory.
fn files_or_found(files: &[PathBuf]) -> Vec<PathBuf> {
    if files.is_empty() { files_in(Path::new("config")) } else { files.to_vec() }
}

fn files_in(directory: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(directory) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension().is_some_and(|e| e == "toml") && path.file_stem().is_some_and(|s| s != "default")
        })
        .collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests;
