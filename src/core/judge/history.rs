//! What a rule is given: the stretch of one gyro's history that it needs, oldest first, and what happened to the gyro.

use crate::core::time::UtcMicros;

use crate::core::judge::{
    BASELINE_RECORDS, Limits, Mark, Older, Rule, Sample, Series, baseline_since, cells, reset_before,
};

/// The stretch of one gyro's history that the judging of one record needs.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    /// Consecutive records without the voided ones and without [repeats](Sample::repeats), oldest first, as far back
    /// as [`Need`] says, and the gyro's events. What comes after the judged record does no harm.
    pub samples: &'a Series,
    /// The first [`BASELINE_RECORDS`] records at or after [`baseline_since`], or fewer where there are not so many.
    pub baseline: &'a [Sample],
    /// The same since the gyro came to where it is mounted ([`seat_baseline_of`]).
    pub seat_baseline: &'a [Sample],
    /// Records before `samples` that are not there one by one: those that `range` compares with the judged one.
    pub older: Older,
}

/// The first records of the baseline of a record at `at`, among all of a gyro's records.
pub fn baseline_of<'a>(samples: &'a [Sample], marks: &[Mark], at: UtcMicros) -> &'a [Sample] {
    let start = baseline_since(marks, at).map_or(0, |since| samples.partition_point(|sample| sample.at < since));
    first_few(&samples[start..])
}

/// The same of those since the gyro was mounted where it is at `at`: what belongs to the mounting starts anew there.
pub fn seat_baseline_of<'a>(samples: &'a [Sample], marks: &[Mark], at: UtcMicros) -> &'a [Sample] {
    let since = baseline_since(marks, at);
    let upto = &samples[..samples.partition_point(|sample| sample.at <= at)];
    let Some(newest) = upto.last() else { return &[] };
    let here = |sample: &&Sample| sample.seat == newest.seat && since.is_none_or(|since| sample.at >= since);
    first_few(&samples[upto.len() - upto.iter().rev().take_while(here).count()..])
}

fn first_few(samples: &[Sample]) -> &[Sample] {
    &samples[..samples.len().min(BASELINE_RECORDS)]
}

/// How far back the rules look from the record that they judge (besides the baseline's records, the marks, and the
/// [cells](Series::reaches_all_cells) of the control rules).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// At least so many records before it, where there are so many.
    pub records: usize,
    /// And every record of so many days before it.
    pub days: f64,
}

impl Need {
    /// What the rules with these limits look back to.
    pub fn of(limits: &Limits) -> Self {
        // A week, so that the judged record's own cell is there.
        Self { records: limits.longest_memory() - 1, days: limits.range_days.max(7.0) }
    }

    /// How many of the records after `changed` (oldest first) must be judged again when a record at
    /// `changed` is inserted, voided or revised. Where that alters the baseline's records, all of them must.
    pub fn reach(&self, changed: UtcMicros, later: &[Sample]) -> usize {
        let within_days = later.partition_point(|sample| sample.at.days_since(changed) <= self.days);
        within_days.max(self.records.min(later.len())).max(cells::reach(changed, later))
    }
}

impl<'a> History<'a> {
    /// Of records that are all there one by one, judged at `k`.
    ///
    /// # Panics
    /// Where `k` is not an index of `samples`.
    pub fn whole(samples: &'a Series, k: usize) -> Self {
        let (marks, at) = (samples.marks(), samples[k].at);
        Self {
            samples,
            baseline: baseline_of(samples, marks, at),
            seat_baseline: seat_baseline_of(samples, marks, at),
            older: Older::NONE,
        }
    }

    pub(crate) fn marks(&self) -> &'a [Mark] {
        self.samples.marks()
    }

    /// The records that `rule` may compare with record `k`: from the last event that resets the rule, `k` included.
    pub(crate) fn since_reset(&self, k: usize, rule: Rule) -> &'a [Sample] {
        &self.samples[self.first_since_reset(k, rule)..=k]
    }

    /// Place of the first of [`History::since_reset`].
    pub(crate) fn first_since_reset(&self, k: usize, rule: Rule) -> usize {
        let upto = &self.samples[..=k];
        let reset = reset_before(self.marks(), self.samples[k].at, rule);
        reset.map_or(0, |reset| upto.partition_point(|sample| sample.at < reset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{Event, Measured, Seat};

    fn day(n: i64) -> UtcMicros {
        UtcMicros(n * UtcMicros::DAY)
    }

    fn samples(days: std::ops::Range<i64>) -> Vec<Sample> {
        days.map(|n| Sample { at: day(n), seat: Seat::default(), station: 0, d: [Measured::exact(n as f64); 3] })
            .collect()
    }

    #[test]
    fn a_baseline_in_one_seat_begins_with_the_record_of_the_mark_and_holds_nothing_older() {
        let (samples, marks) = (samples(0..9), [Mark::of(day(4), Event::Repair)]);
        let first = |at| seat_baseline_of(&samples, &marks, day(at)).first().map(|sample| sample.at);
        assert_eq!(first(8), Some(day(4)));
        assert_eq!(first(3), Some(day(0)));
    }

    #[test]
    fn a_record_of_the_very_instant_of_an_event_belongs_to_what_comes_after_it() {
        let series = Series::new(samples(0..9), vec![Mark::of(day(4), Event::Repair)]);
        let first = |k| History::whole(&series, k).first_since_reset(k, Rule::Range);
        assert_eq!((first(3), first(4), first(8)), (0, 4, 4));
    }
}
