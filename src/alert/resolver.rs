//! Names of targets become addresses here, and only allowed ones come out.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;

use reqwest::dns::{Addrs, Name, Resolve, Resolving};

use super::target::TargetPolicy;
use crate::core::message::Message;
use crate::message;
use crate::wire::cause;

type AddressLookup = Pin<Box<dyn Future<Output = io::Result<Vec<IpAddr>>> + Send>>;

/// Asks the system, or whom a test says, and keeps what the policy allows. A pooled connection was dialled through here
/// once, so that a name that changes its mind gains nothing.
pub struct GuardedResolver {
    policy: TargetPolicy,
    lookup: Arc<dyn Fn(String) -> AddressLookup + Send + Sync>,
    /// Names of proxies: whoever runs the service has named them, wherever they are.
    trusted: Vec<String>,
}

/// Why a name leads nowhere.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ResolveError(pub Message);

impl GuardedResolver {
    /// Asks the system's resolver.
    pub fn system(policy: TargetPolicy) -> Self {
        Self::with_lookup(policy, |name| {
            Box::pin(async move { Ok(tokio::net::lookup_host((name, 0)).await?.map(|a| a.ip()).collect()) })
        })
    }

    /// Asks `lookup` instead of the system.
    pub fn with_lookup(policy: TargetPolicy, lookup: impl Fn(String) -> AddressLookup + Send + Sync + 'static) -> Self {
        Self { policy, lookup: Arc::new(lookup), trusted: Vec::new() }
    }

    /// Lets these names lead anywhere; they replace those that were trusted before.
    pub fn trusting(self, names: Vec<String>) -> Self {
        Self { trusted: names, ..self }
    }
}

impl Resolve for GuardedResolver {
    fn resolve(&self, name: Name) -> Resolving {
        let name = name.as_str().to_owned();
        let found = (self.lookup)(name.clone());
        let policy = self.policy.clone();
        let trusted = self.trusted.contains(&name.to_ascii_lowercase());
        Box::pin(async move {
            let unknown = |why| message!("name_unknown", name = name.clone(), why = cause::of_lookup(&why));
            let addresses = found.await.map_err(|why: io::Error| ResolveError(unknown(why)))?;
            let allowed = if trusted { addresses } else { allowed(&policy, &name, addresses)? };
            let addrs: Addrs = Box::new(allowed.into_iter().map(|ip| SocketAddr::new(ip, 0)));
            Ok(addrs)
        })
    }
}

fn allowed(policy: &TargetPolicy, name: &str, addresses: Vec<IpAddr>) -> Result<Vec<IpAddr>, ResolveError> {
    let (mut allowed, mut refused) = (Vec::new(), None);
    for address in addresses {
        match policy.check(address) {
            Ok(()) => allowed.push(address),
            Err(why) => refused = Some(why),
        }
    }
    match refused {
        _ if !allowed.is_empty() => Ok(allowed),
        Some(why) => Err(ResolveError(message!("name_forbidden", name = name.to_owned(), why))),
        None => Err(ResolveError(message!("name_empty", name = name.to_owned()))),
    }
}
