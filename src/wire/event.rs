//! What was done to a gyro, as it is sent.

use super::text;
use crate::core::fault::Faults;
use crate::core::judge::Event;
use crate::core::time::UtcMicros;

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
                faults.push(place, format!("belongs to environmental_test, not to {}", event.name()));
            }
        }
        return (None, None);
    }
    let test = text::short("/kind", &kind, faults).filter(|kind| !kind.trim().is_empty());
    if test.is_none() && faults.is_empty() {
        faults.push("/kind", "must say which test it was, as vibration or thermal cycling");
    }
    let Some(to) = to else {
        faults.push("/to", "must say when the test was over");
        return (None, test);
    };
    let until = text::instant("/to", &to, faults);
    if until < from && faults.is_empty() {
        faults.push("/to", "lies before the beginning of the test");
    }
    (Some(until), test)
}
