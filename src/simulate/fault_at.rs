//! One fault at one place of a scenario.

use crate::core::fault::Faults;

pub(crate) fn fault(pointer: &str, detail: String) -> Faults {
    let mut faults = Faults::default();
    faults.push(pointer, detail);
    faults
}

pub(super) fn below(prefix: &str, part: Faults) -> Faults {
    let mut faults = Faults::default();
    faults.absorb(prefix, part);
    faults
}
