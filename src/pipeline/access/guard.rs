//! Lets callers in, or says why not.

use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, Weak};
use std::time::Instant;

use super::audit::{Caller, Credential, SETUP};
use super::limits::{Allowance, Failures};
use super::secret::Secret;
use crate::config::AccessConfig;
use crate::core::access::{Role, Token};
use crate::pipeline::prelude::*;
use crate::store::SessionRow;

/// How long a token that was revoked by the command line may still be used.
const REREAD: Duration = Duration::from_secs(1);

/// Why somebody is not let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Denied {
    NoToken,
    /// No token was ever made, and the request is not from this machine.
    NotHere,
    /// No token was ever made, and a reverse proxy is in front.
    Proxied,
    Wrong,
    Revoked,
    Expired,
    SignedOut,
    TooManyFailures {
        wait: Duration,
    },
    TooManyRequests {
        wait: Duration,
    },
    Unreadable,
}

impl Denied {
    pub fn problem(&self) -> Problem {
        let (status, title, message) = match self {
            Self::NoToken => (401, "title_token_needed", message!("no_token")),
            Self::SignedOut => (401, "title_token_needed", message!("signed_out")),
            Self::Wrong => (401, "title_token_not_valid", message!("wrong_token")),
            Self::Revoked => (401, "title_token_not_valid", message!("revoked_token")),
            Self::Expired => (401, "title_token_not_valid", message!("expired_token")),
            Self::NotHere => (403, "title_not_allowed", message!("not_here")),
            Self::Proxied => (403, "title_not_allowed", message!("proxied")),
            Self::TooManyFailures { .. } => (429, "title_too_many_wrong_tokens", message!("too_many_failures")),
            Self::TooManyRequests { .. } => (429, "title_too_many_requests", message!("too_many_requests")),
            Self::Unreadable => (503, "title_try_again", message!("access_unreadable")),
        };
        Problem::new(status, title, message)
    }
}

#[derive(Debug, Default)]
struct CredentialCache {
    tokens: HashMap<Id, Token>,
    sessions: HashMap<Id, SessionRow>,
}

/// Cheap to clone.
#[derive(Debug, Clone)]
pub struct Guard(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    store: Store,
    settings: AccessConfig,
    cache: RwLock<CredentialCache>,
    failures: Mutex<Failures>,
    allowances: Mutex<HashMap<Id, Allowance>>,
    /// Makes the first token; in memory alone, and of no use once there is one.
    setup: Option<Secret>,
    /// A proxy has been seen, or is configured: an address says nothing about who asks.
    behind_proxy: AtomicBool,
    /// When the cache was last begun to be read.
    reading: tokio::sync::Mutex<Instant>,
}

impl Guard {
    /// Reads the cache, and goes on reading it as long as a clone is alive.
    pub async fn start(store: Store, settings: AccessConfig, behind_proxy: bool) -> Result<Self, StoreError> {
        let failures = Mutex::new(Failures::new(settings.failures_per_minute));
        let setup = Secret::draw(Id(0)).map_err(StoreError::other)?;
        let setup = (!settings.open).then_some(setup);
        let guard = Self(Arc::new(Inner {
            store,
            settings,
            cache: RwLock::default(),
            failures,
            allowances: Mutex::default(),
            setup,
            behind_proxy: AtomicBool::new(behind_proxy),
            reading: tokio::sync::Mutex::new(Instant::now()),
        }));
        guard.read_again().await?;
        tokio::spawn(keep_reading(Arc::downgrade(&guard.0)));
        Ok(guard)
    }

    /// Takes over what the database says.
    pub async fn read_again(&self) -> Result<(), StoreError> {
        let tokens = store::access::tokens(&self.0.store).await?.into_iter().map(|token| (token.id, token)).collect();
        let sessions =
            store::access::sessions(&self.0.store).await?.into_iter().map(|session| (session.id, session)).collect();
        *self.0.cache.write().unwrap_or_else(PoisonError::into_inner) = CredentialCache { tokens, sessions };
        Ok(())
    }

    /// Whether a token was ever made. Revoking the last one does not open the doors again.
    pub fn asks_for_tokens(&self) -> bool {
        !self.cache().tokens.is_empty()
    }

    /// What makes the first token, where there is none.
    pub fn setup_secret(&self) -> Option<&Secret> {
        self.0.setup.as_ref().filter(|_| !self.asks_for_tokens())
    }

    /// A request came through a proxy: from now on nobody is let in for being on this machine.
    pub fn note_proxy(&self) {
        let is_known = self.0.behind_proxy.load(Ordering::Relaxed);
        if !is_known && !self.0.behind_proxy.swap(true, Ordering::Relaxed) && !self.asks_for_tokens() {
            tracing::warn!("a request came through a proxy: nothing is answered any more until a token is made");
        }
    }

    /// Who asks: by the token that was sent along, or else by the cookie.
    pub async fn caller(
        &self,
        (token, cookie): (Option<&str>, Option<&str>),
        source: IpAddr,
        now: UtcMicros,
    ) -> Result<Caller, Denied> {
        let arrived = Instant::now();
        match (token, cookie) {
            (None, _) if !self.asks_for_tokens() => self.present(source),
            (Some(token), _) if self.is_setup(token) => Ok(nameless(SETUP, Role::Admin, Credential::Setup, source)),
            (Some(token), _) => {
                let row = self.by_token(token, source, arrived).await?;
                self.admit(row, Credential::Token, source, now, arrived)
            }
            (None, Some(cookie)) => {
                let session =
                    self.by_cookie(cookie).filter(|session| now < session.expires_at).ok_or(Denied::SignedOut)?;
                let row = self.cache().tokens.get(&session.token).cloned().ok_or(Denied::SignedOut)?;
                self.admit(row, |token| Credential::Session { session: session.id, token }, source, now, arrived)
            }
            (None, None) => Err(Denied::NoToken),
        }
    }

    /// The caller that a token typed into the sign-in page stands for.
    pub async fn sign_in(&self, token: &str, source: IpAddr, now: UtcMicros) -> Result<Caller, Denied> {
        let arrived = Instant::now();
        let row = self.by_token(token.trim(), source, arrived).await?;
        self.admit(row, Credential::Token, source, now, arrived)
    }

    fn admit(
        &self,
        row: Token,
        by: impl FnOnce(Id) -> Credential,
        source: IpAddr,
        now: UtcMicros,
        arrived: Instant,
    ) -> Result<Caller, Denied> {
        if row.revoked_at.is_some() {
            return Err(Denied::Revoked);
        }
        if !row.is_valid(now) {
            return Err(Denied::Expired);
        }
        let per_second = self.0.settings.requests_per_second;
        let mut allowances = lock(&self.0.allowances);
        let allowance = allowances.entry(row.id).or_insert_with(|| Allowance::full(per_second, arrived));
        allowance.take(per_second, arrived).map_err(|wait| Denied::TooManyRequests { wait })?;
        drop(allowances);
        Ok(Caller { name: row.name, role: row.role, station: row.station, by: by(row.id), source, agent: None })
    }

    /// Somebody without a token, before there are any.
    fn present(&self, source: IpAddr) -> Result<Caller, Denied> {
        if self.0.behind_proxy.load(Ordering::Relaxed) {
            return Err(Denied::Proxied);
        }
        if !source.to_canonical().is_loopback() {
            return Err(Denied::NotHere);
        }
        let role = if self.0.settings.open { Role::Admin } else { Role::Engineer };
        Ok(nameless("local", role, Credential::Presence, source))
    }

    fn is_setup(&self, token: &str) -> bool {
        let kept = self.setup_secret().map(Secret::sha256);
        Secret::read(token).is_some_and(|sent| sent.is(kept.as_ref()))
    }

    /// A right token is let in whatever wrong ones came from its address: a guess has one chance in 2^256, and stations
    /// behind one address must not be able to shut each other out.
    async fn by_token(&self, text: &str, source: IpAddr, arrived: Instant) -> Result<Token, Denied> {
        let secret = Secret::read(text);
        let find = |guard: &Self| {
            let secret = secret.as_ref()?;
            let cache = guard.cache();
            let row = cache.tokens.get(&secret.id);
            secret.is(row.map(|row| &row.secret_sha256)).then(|| row.cloned()).flatten()
        };
        if let Some(row) = find(self) {
            return Ok(row);
        }
        if let Some(wait) = lock(&self.0.failures).wait(source, arrived) {
            return Err(Denied::TooManyFailures { wait });
        }
        if secret.is_some() {
            self.read_since(arrived).await.map_err(|error| {
                tracing::error!(%error, "the tokens cannot be read");
                Denied::Unreadable
            })?;
            if let Some(row) = find(self) {
                return Ok(row);
            }
        }
        lock(&self.0.failures).note(source, arrived);
        tracing::warn!(%source, "a wrong token");
        Err(Denied::Wrong)
    }

    /// Reads the cache unless that was begun after `arrived`: of many who wait for it one reads for all.
    async fn read_since(&self, arrived: Instant) -> Result<(), StoreError> {
        let mut reading = self.0.reading.lock().await;
        if *reading < arrived {
            *reading = Instant::now();
            self.read_again().await?;
        }
        Ok(())
    }

    fn by_cookie(&self, cookie: &str) -> Option<SessionRow> {
        let secret = Secret::read(cookie)?;
        let cache = self.cache();
        let row = cache.sessions.get(&secret.id);
        secret.is(row.map(|row| &row.secret_sha256)).then(|| row.cloned()).flatten()
    }

    /// Sessions that are over.
    pub(super) fn ended_sessions(&self, now: UtcMicros) -> Vec<Id> {
        self.cache().sessions.values().filter(|session| session.expires_at <= now).map(|session| session.id).collect()
    }

    pub(super) fn session_us(&self) -> i64 {
        (self.0.settings.session_hours * 3.6e9) as i64
    }

    fn cache(&self) -> RwLockReadGuard<'_, CredentialCache> {
        self.0.cache.read().unwrap_or_else(PoisonError::into_inner)
    }
}

async fn keep_reading(guard: Weak<Inner>) {
    loop {
        tokio::time::sleep(REREAD).await;
        let Some(inner) = guard.upgrade() else { return };
        if let Err(error) = Guard(inner).read_again().await {
            tracing::debug!(%error, "the tokens cannot be read; those known before count");
        }
    }
}

/// Somebody before there are tokens.
fn nameless(name: &str, role: Role, by: Credential, source: IpAddr) -> Caller {
    Caller { name: name.to_owned(), role, station: None, by, source, agent: None }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
