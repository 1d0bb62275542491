//! Who may use the service: tokens, browsers that signed in with one, and the trail of what everybody did.
//!
//! The cache of tokens is in memory; a request costs one look and one comparison. Whoever is not in it makes it be
//! read anew, so that what the command line wrote into the database counts at once; what it revoked counts within a
//! second. As long as no token was ever made, a caller from this machine may do what an engineer may, unless a proxy
//! was seen: behind one everybody comes from this machine. Administrators then show the setup secret of the start.

mod audit;
mod guard;
mod limits;
mod orders;
mod secret;

use std::net::IpAddr;

use super::write_queue::{Job, WriteQueue};
use crate::core::access::{AuditEntry, AuditFilter, Token};
use crate::pipeline::prelude::*;

pub use audit::{Actor, Caller, Credential};
pub use guard::{Denied, Guard};
pub(super) use orders::order_access;
pub use orders::{AccessOrder, NewToken, SignedIn, create_beside, revoke_beside};
pub use secret::Secret;

/// Under which name a browser keeps what it was given when it signed in.
pub const SESSION_COOKIE: &str = "gyrowatch_session";

/// Who may use the service, and what they did. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Access {
    pub(super) store: Store,
    pub(super) clock: Clock,
    pub(super) guard: Guard,
    pub(super) queue: WriteQueue,
}

impl Access {
    pub fn guard(&self) -> &Guard {
        &self.guard
    }

    /// Has the writer carry out an order about access.
    pub async fn order(&self, order: AccessOrder) -> Result<Option<Secret>, Refused> {
        self.order_by(order, Actor::by_caller()).await
    }

    async fn order_by(&self, order: AccessOrder, by: Actor) -> Result<Option<Secret>, Refused> {
        self.queue.ask(|reply| Job::Access { order, by, reply }).await
    }

    /// Signs a browser in with a token; what it is then to send along comes back.
    ///
    /// # Errors
    /// [`Denied`] where the token is not right, else why it cannot be written down.
    pub async fn sign_in(
        &self,
        token: &str,
        source: IpAddr,
        agent: Option<String>,
    ) -> Result<Result<SignedIn, Denied>, Refused> {
        let caller = match self.guard.sign_in(token, source, self.clock.now()).await {
            Ok(caller) => Caller { agent, ..caller },
            Err(denied) => return Ok(Err(denied)),
        };
        let Some(token) = caller.token() else { return Ok(Err(Denied::Wrong)) };
        let drawn = self.order_by(AccessOrder::SignIn { token }, Actor::by(&caller)).await?;
        let cookie = drawn.ok_or(Refused::Stopping)?;
        Ok(Ok(SignedIn { cookie, seconds: self.guard.session_us() / UtcMicros::SECOND }))
    }

    /// Ends the session of this task's caller, if it is one.
    pub async fn sign_out(&self) -> Result<(), Refused> {
        if let Some(Caller { by: Credential::Session { session, .. }, .. }) = Caller::current() {
            self.order(AccessOrder::SignOut { session }).await?;
        }
        Ok(())
    }

    /// Every token there ever was, oldest first.
    pub async fn tokens(&self) -> Result<Vec<Token>, StoreError> {
        store::access::tokens(&self.store).await
    }

    /// The audit trail, newest first.
    pub async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<Id>,
        limit: u32,
    ) -> Result<Vec<AuditEntry>, StoreError> {
        store::access::audit(&self.store, filter, before, limit).await
    }
}
