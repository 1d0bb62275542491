//! Fleets whose hidden cause is known: what a service answers that was sent their records.
//!
//! In reading order: [`draw`] a fleet, [`sent`] as its stations send it, [`score`] its answers, [`report`] the table.
//! [`speed`] is asked apart.

pub mod draw;
pub mod report;
pub mod score;
pub mod sent;
pub mod speed;

use rayon::prelude::*;

use draw::{FleetDraw, HiddenCause};
use score::{FleetDiagnoser, FleetScore};

/// `count` fleets of each of `kinds`.
///
/// # Errors
/// What `ask` could not answer, of the first fleet that it failed at.
pub fn run(
    seed: u64,
    count: usize,
    kinds: &[HiddenCause],
    ask: &FleetDiagnoser<'_>,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<FleetScore>, String> {
    let all: Vec<(u64, HiddenCause)> = (kinds.iter().enumerate())
        .flat_map(|(k, kind)| (0..count).map(move |number| ((number * 64 + k) as u64, *kind)))
        .collect();
    let score = |(number, kind): (u64, HiddenCause)| {
        let fleet = FleetDraw::of(seed, number).fleet(kind);
        let score = ask(&fleet).map(|answers| fleet.score(answers));
        done();
        score
    };
    all.into_par_iter().map(score).collect()
}
