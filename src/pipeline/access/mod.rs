//! Who may use the service: tokens, browsers that signed in with one, and the trail of what everybody did.
//!
//! The book of tokens is in memory; a request costs one look and one comparison. Whoever is not in it makes it be read
//! anew, so that what the command line wrote into the database counts at once; what it revoked counts within
//! [`REREAD`]. As long as no token was ever made, everybody on this machine is an administrator, and nobody else is let in.

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
