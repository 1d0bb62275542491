//! Effects of what came before: the gyro remembers the orientation it was in.

use super::entry::{Effect, Entry, PLAIN};

pub(super) const ENTRIES: &[&Entry] = &[&HYSTERESIS];

pub const HYSTERESIS: Entry = Entry {
    effect: Effect::Hysteresis,
    id: "hysteresis",
    cause: "the float's pivots and flex leads keep a set from the load along the output axis in the dwell before",
    equation: "k a_O(i - 1), a_O(0) = 0",
    unit: "deg/(h g0)",
    typical: [1e-3, 0.1], // IEEE 517, elastic restraint and hysteresis after re-orientation
    plausible: 1e3,
    confused_with: &[Effect::OutlierDwell],
    columns: &|s, j, _| vec![s.column(|k| if k == 0 { 0.0 } else { s.force[k - 1].dot(&s.gyros[j].output) })],
    ..PLAIN
};
