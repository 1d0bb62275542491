//! What is known of one kind of structure outside the contract.

use crate::core::effects::entry::{Effect, Shape, Typical};
use crate::core::effects::setting::Setting;

/// How the coefficients of a competitor's columns are distributed before the data speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prior {
    /// Any direction in the span of the columns alike.
    Flat,
    /// In proportion to the columns' own lengths: a smooth curve as a sum of ever smaller waves.
    Smooth,
}

/// A kind of structure outside the contract.
#[derive(Debug, Clone, Copy)]
pub struct Competitor {
    pub id: &'static str,
    /// What it looks like, for people.
    pub looks_like: &'static str,
    pub cause: &'static str,
    /// Drift added, deg/h, with the letters of the crate page.
    pub equation: &'static str,
    /// Of the coefficients.
    pub unit: &'static str,
    pub typical: Typical,
    /// What a campaign must hold for it to be told from the contract's entries.
    pub needs: &'static str,
    pub confused_with: &'static [Effect],
    pub prior: Prior,
    pub shapes: fn(&Setting) -> Vec<(Shape, f64)>,
    pub columns: fn(&Setting, usize, Shape) -> Vec<Vec<f64>>,
}

pub(super) fn one(_: &Setting) -> Vec<(Shape, f64)> {
    vec![(Shape::Linear, 1.0)]
}

pub(super) fn picked(shape: Shape) -> &'static [usize] {
    match shape {
        Shape::Only(picked) => picked,
        _ => &[],
    }
}

/// Time from -1 at the first dwell to +1 at the last.
pub(super) fn mid(s: &Setting, k: usize) -> f64 {
    let span = s.span();
    if span > 0.0 { 2.0 * s.elapsed(k) / span - 1.0 } else { 0.0 }
}
