//! What was done to a gyro, as it is sent.

use super::text;
use crate::core::judge::Event;
use crate::core::message::text;
use crate::wire::prelude::*;

/// End and kind of an environmental test, which other events do not have.
pub fn read_test(
    event: Event,
    from: UtcMicros,
    (to, kind): (Option<String>, Option<String>),
    faults: &mut Faults,
) -> (Option<UtcMicros>, Option<String>) {
    if event != Event::EnvironmentalTest {
        for (place, is_there) in [("/to", to.is_some()), ("/kind", kind.is_some())] {
            if is_there {
                faults.push(place, message!("only_environmental", event = text(event.name())));
            }
        }
        return (None, None);
    }
    let test = text::short("/kind", &kind, faults).filter(|kind| !kind.trim().is_empty());
    if test.is_none() && faults.is_empty() {
        faults.push("/kind", message!("which_test"));
    }
    let Some(to) = to else {
        faults.push("/to", message!("test_end"));
        return (None, test);
    };
    let until = text::end("/to", &to, faults);
    if until < from && faults.is_empty() {
        faults.push("/to", message!("end_before_begin"));
    }
    (Some(until), test)
}
