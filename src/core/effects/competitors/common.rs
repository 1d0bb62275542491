//! What the columns of several competitors are made of.

use crate::core::effects::entry::Shape;
use crate::core::effects::setting::Setting;

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
