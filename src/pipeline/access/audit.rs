//! Who is at work, and the line that their doings leave in the audit trail.
//!
//! Who asks accompanies a request as its task does ([`Caller::during`]), so that whatever changes something down the
//! line can say who it was without every function on the way handing them on. Without anybody it was the service
//! itself.

use std::net::IpAddr;

use serde::Serialize;

use crate::core::access::{AuditEntry, Role};
use crate::pipeline::prelude::*;
use crate::wire::json;

tokio::task_local! {
    static CALLER: Caller;
}

/// The name of a caller who has shown the setup secret.
pub(super) const SETUP: &str = "setup";

/// By what somebody is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Credential {
    /// There is no token yet, and they are on this machine.
    Presence,
    /// There is no token yet, and they have shown the setup secret.
    Setup,
    /// A token sent along.
    Token(Id),
    /// A cookie, after signing in with a token.
    Session { session: Id, token: Id },
}

/// Who asks for something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    pub name: String,
    pub role: Role,
    /// The only station that they may send for.
    pub station: Option<String>,
    pub by: Credential,
    pub source: IpAddr,
    /// The program that they ask with, by its own word.
    pub agent: Option<String>,
}

/// Characters of the name of a program that are kept.
const LONGEST_AGENT: usize = 200;

impl Caller {
    /// The program that somebody asks with, of its own word as it was sent.
    pub fn agent(sent: &[u8]) -> Option<String> {
        let text = String::from_utf8_lossy(sent);
        let agent: String = text.chars().filter(|c| !c.is_control()).take(LONGEST_AGENT).collect();
        Some(agent).filter(|agent| !agent.is_empty())
    }

    pub fn token(&self) -> Option<Id> {
        match self.by {
            Credential::Presence | Credential::Setup => None,
            Credential::Token(token) | Credential::Session { token, .. } => Some(token),
        }
    }

    /// Does `work` as this caller.
    pub async fn during<T>(self, work: impl Future<Output = T>) -> T {
        CALLER.scope(self, work).await
    }

    /// Who asks for what this task does.
    pub fn current() -> Option<Self> {
        CALLER.try_with(Self::clone).ok()
    }
}

/// Who did something, as the audit trail has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Actor {
    who: String,
    token: Option<Id>,
    source: String,
    agent: Option<String>,
}

impl Actor {
    /// Begins a line about what this task's caller does.
    pub fn by_caller() -> Self {
        Caller::current().map_or_else(|| Self::nobody("service"), |caller| Self::by(&caller))
    }

    pub fn by(caller: &Caller) -> Self {
        let (who, source) = (caller.name.clone(), caller.source.to_string());
        Self { who, token: caller.token(), source, agent: caller.agent.clone() }
    }

    pub fn by_command_line() -> Self {
        Self::nobody("command line")
    }

    fn nobody(who: &str) -> Self {
        Self { who: who.to_owned(), token: None, source: String::new(), agent: None }
    }

    pub(super) fn is_setup(&self) -> bool {
        self.token.is_none() && self.who == SETUP
    }

    pub fn name(&self) -> &str {
        &self.who
    }

    pub fn line(
        &self,
        id: Id,
        at: UtcMicros,
        (action, subject): (&str, String),
        before: Option<&impl Serialize>,
        after: Option<&impl Serialize>,
    ) -> AuditEntry {
        AuditEntry {
            id,
            at,
            who: self.who.clone(),
            token: self.token,
            source: self.source.clone(),
            agent: self.agent.clone(),
            action: action.to_owned(),
            subject,
            before: before.map(json::written),
            after: after.map(json::written),
        }
    }
}
