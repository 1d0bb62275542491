//! Hands out identifiers.

use crate::core::id::Id;
use crate::core::time::UtcMicros;

/// Of the 63 bits of an identifier, those that keep items of one millisecond apart.
const SEQUENCE_BITS: u32 = 21;

/// Hands out identifiers. They ascend whatever the clock does.
#[derive(Debug)]
pub struct IdSource {
    last: i64,
}

impl IdSource {
    /// Continues after the greatest identifier in the database.
    pub fn after(last: i64) -> Self {
        Self { last }
    }

    /// Others have handed out up to `last`.
    pub(super) fn go_on_after(&mut self, last: i64) {
        self.last = self.last.max(last);
    }

    pub(super) fn last(&self) -> i64 {
        self.last
    }

    pub fn next(&mut self, now: UtcMicros) -> Id {
        let from_clock = (now.0.max(0) / 1000) << SEQUENCE_BITS;
        self.last = from_clock.max(self.last + 1);
        Id(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_ascend_while_the_clock_stands_or_goes_back() {
        let mut source = IdSource::after(0);
        let day = UtcMicros(UtcMicros::DAY * 20_000);
        let ids = [day, day, UtcMicros(0), UtcMicros(day.0 + 1000)].map(|now| source.next(now));
        assert!(ids.is_sorted_by(|a, b| a < b), "{ids:?}");
        assert_eq!(ids[0].0 >> SEQUENCE_BITS, day.0 / 1000);
    }
}
