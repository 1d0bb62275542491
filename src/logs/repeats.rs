//! What is kept of a log's rows, so that they are known again in another: a file named twice, or parts that overlap.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hasher};

use crate::core::message::{Message, figure, sent};
use crate::message;

/// Rows that are kept of a log, at most: those whose digests end in so many zeros.
const MOST_KEPT: usize = 1 << 16;
/// Kept rows that two logs share from which it is no chance.
const FEWEST: usize = 8;

/// The rows of one log.
pub struct Rows {
    pub place: String,
    whole: DefaultHasher,
    count: usize,
    /// First and last time, s.
    span: Option<(f64, f64)>,
    /// Times of some rows, s, by digest.
    kept: BTreeMap<u64, f64>,
    mask: u64,
}

impl Rows {
    pub fn new(place: &str) -> Self {
        let whole = DefaultHasher::new();
        Self { place: place.to_owned(), whole, count: 0, span: None, kept: BTreeMap::new(), mask: 0 }
    }

    /// The next row, and its time by the log's own clock, s, where it has one.
    pub fn see(&mut self, row: &[f64], time_s: Option<f64>) {
        let mut own = DefaultHasher::new();
        row.iter().for_each(|value| own.write_u64(value.to_bits()));
        let digest = own.finish();
        self.whole.write_u64(digest);
        self.count += 1;
        let Some(time_s) = time_s else { return };
        let (from, to) = self.span.unwrap_or((time_s, time_s));
        self.span = Some((from.min(time_s), to.max(time_s)));
        if digest & self.mask == 0 {
            self.kept.insert(digest, time_s);
        }
        while self.kept.len() > MOST_KEPT {
            let mask = 2 * self.mask + 1;
            self.mask = mask;
            self.kept.retain(|digest, _| digest & mask == 0);
        }
    }

    /// That rows of an earlier log are here again: all of them, or all from the time that both have.
    pub fn again(&self, earlier: &Self) -> Option<Message> {
        let other = sent(&earlier.place);
        if self.count == earlier.count && self.whole.finish() == earlier.whole.finish() {
            return Some(message!("log_twice", rows = self.count, other));
        }
        let (from, to) = earlier.span?;
        let mask = self.mask | earlier.mask;
        let is_of_both = |(digest, time): &(&u64, &f64)| *digest & mask == 0 && (from..=to).contains(time);
        let shared: Vec<(&u64, &f64)> = self.kept.iter().filter(is_of_both).collect();
        if shared.len() < FEWEST || !shared.iter().all(|(digest, _)| earlier.kept.contains_key(digest)) {
            return None;
        }
        let times = || shared.iter().map(|(_, time)| **time);
        let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
        let [seconds, from, to] = [last - first, first, last].map(|time| figure(time, 1));
        Some(message!("log_repeats", seconds, other, from, to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a value by time, from one time to another.
    fn rows(from: u32, to: u32, value: impl Fn(u32) -> f64) -> Rows {
        let mut rows = Rows::new("log.csv");
        (from..to).for_each(|time| rows.see(&[value(time), f64::from(time)], Some(f64::from(time))));
        rows
    }

    #[test]
    fn logs_that_are_one_or_overlap_are_known_by_their_rows() {
        let code = |earlier: &Rows, later: &Rows| later.again(earlier).map(|said| said.code.to_string());
        let one = |time: u32| f64::from(time.wrapping_mul(2_654_435_761) % 1000);
        let other = |time: u32| f64::from(time % 3);
        assert_eq!(code(&rows(0, 500, one), &rows(0, 500, one)).as_deref(), Some("log_twice"));
        let said = rows(400, 900, one).again(&rows(0, 500, one)).unwrap();
        assert_eq!(said.parameter("seconds"), Some(&figure(99.0, 1)), "{said}");
        assert_eq!(code(&rows(400, 900, one), &rows(0, 500, one)).as_deref(), Some("log_repeats"), "in either order");
        assert_eq!(code(&rows(0, 500, one), &rows(500, 900, one)), None);
        // Each from 0: counts are the same here and there.
        assert_eq!(code(&rows(0, 500, one), &rows(0, 500, other)), None);
        assert_eq!(code(&rows(0, 500, |_| 0.0), &rows(0, 500, |time| f64::from(u32::from(time == 250)))), None);
        // Of long logs a part of the rows is kept.
        let said = rows(300_000, 600_000, one).again(&rows(0, 400_000, one)).unwrap();
        assert_eq!(said.code, "log_repeats");
    }
}
