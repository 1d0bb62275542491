//! Where the database may be: `postgres://user@one,two:5433/database?target_session_attrs=read-write` names several
//! hosts, as libpq does. They are tried in turn; the driver knows of one.

use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use sqlx::postgres::PgConnectOptions;
use sqlx::{ConnectOptions, PgConnection, Row as _};

use super::bounded::{LastTimeout, within};
use crate::message;
use crate::store::error::{Result, StoreError};

/// The hosts of one database, and the one that answered last.
#[derive(Debug, Clone)]
pub(crate) struct Hosts {
    all: Arc<[PgConnectOptions]>,
    last: Arc<AtomicUsize>,
    /// Whether a host that does not take writes is passed over.
    read_write: bool,
    pub(super) silence: LastTimeout,
}

/// How long one of several hosts is waited for before the next is tried.
const FOR_EACH: Duration = Duration::from_secs(2);

impl Hosts {
    pub fn of(url: &str) -> Result<Self> {
        let (scheme, rest) = url.split_once("://").ok_or_else(|| StoreError::File(message!("address_foreign")))?;
        let (authority, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        let (user, hosts) = authority.rsplit_once('@').map_or(("", authority), |(user, hosts)| (user, hosts));
        let user = if user.is_empty() { String::new() } else { format!("{user}@") };
        let (path, query) = path.split_once('?').unwrap_or((path, ""));
        let (wanted, others): (Vec<&str>, Vec<&str>) = query
            .split('&')
            .filter(|part| !part.is_empty())
            .partition(|part| part.starts_with("target_session_attrs="));
        let read_write = match wanted.first().and_then(|part| part.split_once('=')).map(|(_, value)| value) {
            None if hosts.contains(',') => true,
            None | Some("any") => false,
            Some("read-write" | "primary") => true,
            Some(other) => {
                return Err(StoreError::File(message!("address_read_only", value = other.to_owned())));
            }
        };
        let one = |host: &str| {
            let query = others.join("&");
            let options = PgConnectOptions::from_str(&format!("{scheme}://{user}{host}{path}?{query}"))?;
            // A pooler refuses what it does not know at the start of a session; figures travel as they are, not as
            // digits.
            let options = options.application_name("gyrowatch").extra_float_digits(None);
            Ok(options.statement_cache_capacity(256).disable_statement_logging())
        };
        let all: Result<Vec<_>, sqlx::Error> = hosts.split(',').map(one).collect();
        Ok(Self { all: all?.into(), last: Arc::default(), read_write, silence: LastTimeout::default() })
    }

    /// The one that answered last.
    pub fn last(&self) -> &PgConnectOptions {
        &self.all[self.last.load(Ordering::Relaxed)]
    }

    pub fn are_several(&self) -> bool {
        self.all.len() > 1
    }

    /// A connection to the first that answers and does what it is wanted for, unless none does within `patience`.
    ///
    /// # Errors
    /// [`StoreError`] of the last that was tried.
    pub async fn reach(&self, patience: Duration) -> Result<PgConnection> {
        let (end, first) = (Instant::now() + patience, self.last.load(Ordering::Relaxed));
        let for_each = if self.are_several() { FOR_EACH.min(patience) } else { patience };
        let mut refused = None;
        for place in (0..self.all.len()).map(|i| (first + i) % self.all.len()) {
            let left = end.saturating_duration_since(Instant::now());
            match within(for_each.min(left), self.open(place)).await {
                Ok(connection) => {
                    self.last.store(place, Ordering::Relaxed);
                    return Ok(connection);
                }
                Err(error) => refused = Some(error),
            }
        }
        Err(refused.expect("there is at least one host").into())
    }

    async fn open(&self, place: usize) -> Result<PgConnection, sqlx::Error> {
        let mut connection = self.all[place].connect().await?;
        if self.read_write {
            let asked = sqlx::raw_sql("SHOW transaction_read_only").fetch_one(&mut connection).await?;
            if asked.try_get::<String, _>(0)? == "on" {
                let why = format!("{} takes no writes", self.all[place].get_host());
                return Err(sqlx::Error::Io(std::io::Error::other(why)));
            }
        }
        Ok(connection)
    }
}

/// An address for people to read.
pub(crate) fn without_password(url: &str) -> String {
    let Some((scheme, rest)) = url.split_once("://") else { return url.to_owned() };
    let (authority, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
    let shown = match authority.rsplit_once('@').map(|(user, hosts)| (user.split_once(':'), hosts)) {
        Some((Some((user, _)), hosts)) => format!("{scheme}://{user}:hidden@{hosts}"),
        _ => format!("{scheme}://{authority}"),
    };
    let (path, query) = path.split_once('?').unwrap_or((path, ""));
    let hidden =
        |part: &str| if part.starts_with("password=") { "password=hidden".to_owned() } else { part.to_owned() };
    let query: Vec<String> = query.split('&').filter(|part| !part.is_empty()).map(hidden).collect();
    let query = if query.is_empty() { String::new() } else { format!("?{}", query.join("&")) };
    format!("{shown}{path}{query}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hosts(url: &str) -> Vec<(String, u16)> {
        let hosts = Hosts::of(url).unwrap();
        hosts.all.iter().map(|one| (one.get_host().to_owned(), one.get_port())).collect()
    }

    #[test]
    fn every_host_of_an_address_is_found_with_its_port() {
        let one = hosts("postgres://u:p@db.example/gyrowatch?sslmode=disable");
        assert_eq!(one, [("db.example".to_owned(), 5432)]);
        let three =
            hosts("postgresql://u@one,two:5433,[::1]:5434/gyrowatch?target_session_attrs=read-write&sslmode=disable");
        assert_eq!(three.iter().map(|(_, port)| *port).collect::<Vec<_>>(), [5432, 5433, 5434]);
        assert_eq!([&three[0].0, &three[1].0], ["one", "two"]);
    }

    #[test]
    fn who_takes_no_writes_is_passed_over_where_there_are_several_or_it_is_asked_for() {
        let passes = |url: &str| Hosts::of(url).unwrap().read_write;
        assert!(!passes("postgres://u@one/g") && passes("postgres://u@one,two/g"));
        assert!(!passes("postgres://u@one,two/g?target_session_attrs=any"));
        assert!(passes("postgres://u@one/g?target_session_attrs=primary"));
        let refused = Hosts::of("postgres://u@one/g?target_session_attrs=standby").unwrap_err();
        assert_eq!(refused.to_string(), "address_read_only (value: standby)");
    }

    #[test]
    fn no_password_is_shown() {
        for (url, shown) in [
            (
                "postgres://u:secret@one,two:5433/g?sslmode=require",
                "postgres://u:hidden@one,two:5433/g?sslmode=require",
            ),
            ("postgres://u@one/g", "postgres://u@one/g"),
            ("postgres:///g?host=/run&password=secret", "postgres:///g?host=/run&password=hidden"),
            ("postgres://u:se@cret@one", "postgres://u:hidden@one"),
            ("sqlite://gyrowatch.db", "sqlite://gyrowatch.db"),
        ] {
            assert_eq!(without_password(url), shown);
        }
    }
}
