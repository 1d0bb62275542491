//! Hypotheses of one's own as effects: one of each is kept for as long as the program runs.

use std::sync::{Mutex, PoisonError};

use super::entry::{Effect, Own};
use super::own_hypothesis::OwnHypothesis;
use crate::core::fault::{Fault, Faults};
use crate::message;

/// So many different ones are kept: a service that is asked with ever new ones does not grow for ever.
const MOST: usize = 10_000;

static KEPT: Mutex<Vec<Own>> = Mutex::new(Vec::new());

/// The effect that a hypothesis of one's own is; the same one for the same hypothesis.
///
/// # Errors
/// Where too many different ones were met since the program began.
pub fn own(hypothesis: OwnHypothesis) -> Result<Effect, Faults> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.iter().find(|known| *known.hypothesis() == hypothesis) {
        return Ok(Effect::Own(*known));
    }
    if kept.len() >= MOST {
        let message = message!("too_many_hypotheses", most = MOST);
        return Err(Fault { pointer: "/id".to_owned(), message }.into());
    }
    let new = Own::keeping(hypothesis);
    kept.push(new);
    Ok(Effect::Own(new))
}
