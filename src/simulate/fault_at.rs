//! One fault at one place of a scenario.

use crate::core::fault::Faults;
use crate::core::message::Message;

pub(crate) fn fault(pointer: &str, message: Message) -> Faults {
    let mut faults = Faults::default();
    faults.push(pointer, message);
    faults
}

pub(super) fn below(prefix: &str, part: Faults) -> Faults {
    let mut faults = Faults::default();
    faults.absorb(prefix, part);
    faults
}
