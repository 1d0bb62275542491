//! Who may use the service: tokens, browsers that signed in with one, and the trail of what everybody did.
//!
//! The book of tokens is in memory; a request costs one look and one comparison. Whoever is not in it makes it be read
//! anew, so that what the command line wrote into the database counts at once; what it revoked counts within
//! [`REREAD`]. As long as no token was ever made, a caller from this machine may do what an engineer may, unless a proxy was seen: behind
//! one everybody comes from this machine. Administrators then show the setup secret of the start.

mod audit;
mod guard;
mod limits;
mod orders;
mod secret;

pub use audit::{Actor, By, Caller};

pub use guard::{Denied, Guard};
pub(super) use orders::Registrar;
pub use orders::{AccessOrder, NewToken, SignedIn, create_beside, revoke_beside};
pub use secret::Secret;

/// Under which name a browser keeps what it was given when it signed in.
pub const SESSION_COOKIE: &str = "gyrowatch_session";

use std::time::Duration;

/// How long a token that was revoked by the command line may still be used.
pub const REREAD: Duration = Duration::from_secs(1);
