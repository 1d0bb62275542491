//! What was done to gyros.

use super::judge::{Event, FixedLevels};
use super::time::UtcMicros;

/// Something that was done to a gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroEvent {
    pub at: UtcMicros,
    pub event: Event,
    /// When it was over, of what took time.
    pub until: Option<UtcMicros>,
    /// Which environmental test it was.
    pub test: Option<String>,
    /// Levels that a baseline mark states.
    pub fixed: FixedLevels,
    pub reason: String,
    pub author: Option<String>,
}

impl GyroEvent {
    /// When it was over.
    pub fn end(&self) -> UtcMicros {
        self.until.map_or(self.at, |until| until.max(self.at))
    }
}

/// The decision that stands, of events that are oldest first: the last one that was not withdrawn.
pub fn standing_decision<'a>(events: impl Iterator<Item = &'a GyroEvent>) -> Option<&'a GyroEvent> {
    let mut standing = Vec::new();
    for done in events.filter(|done| done.event.is_decision()) {
        if done.event == Event::DecisionWithdrawn {
            standing.pop();
        } else {
            standing.push(done);
        }
    }
    standing.pop()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_withdrawal_takes_back_the_decision_before_it_alone() {
        use Event::{DecisionRelease as Release, DecisionRemove as Remove, DecisionWithdrawn as Withdrawn, Repair};
        for (events, standing) in [
            (vec![], None),
            (vec![Release, Repair], Some(Release)),
            (vec![Remove, Withdrawn], None),
            (vec![Release, Remove, Withdrawn], Some(Release)),
            (vec![Release, Remove, Withdrawn, Withdrawn, Withdrawn], None),
            (vec![Remove, Withdrawn, Release], Some(Release)),
        ] {
            let done = |event: &Event| GyroEvent {
                at: UtcMicros(0),
                event: *event,
                until: None,
                test: None,
                fixed: [None; 2],
                reason: String::new(),
                author: None,
            };
            let all: Vec<GyroEvent> = events.iter().map(done).collect();
            assert_eq!(standing_decision(all.iter()).map(|done| done.event), standing, "{events:?}");
        }
    }
}
