//! Fleets whose hidden cause is known, asked for through the very function that the service answers with.
//!
//! In reading order: [`draw`] a fleet, [`score`] its answers, [`report`] the table. [`speed`] is asked apart.

pub mod draw;
pub mod report;
pub mod score;
pub mod speed;

use rayon::prelude::*;

use draw::{Draw, Kind};
use score::{Diagnoser, Score};

/// `count` fleets of each of `kinds`.
pub fn run(seed: u64, count: usize, kinds: &[Kind], ask: &Diagnoser<'_>, done: &(dyn Fn() + Sync)) -> Vec<Score> {
    let all: Vec<(u64, Kind)> = (kinds.iter().enumerate())
        .flat_map(|(k, kind)| (0..count).map(move |number| ((number * 64 + k) as u64, *kind)))
        .collect();
    let score = |(number, kind): (u64, Kind)| {
        let score = Draw::of(seed, number).fleet(kind).score(ask);
        done();
        score
    };
    all.into_par_iter().map(score).collect()
}
