//! `range`: max - min over the newest records against the budget.

use super::Case;
use crate::core::judge::decide::{Pair, widest};
use crate::core::judge::limits::{Limit, RMS_RECORDS};
use crate::core::judge::{Finding, Measured, Older, Rule, Sample, Verdict};
use crate::core::time::UtcMicros;

/// Of up to so many records every pair is looked at, and single outliers are left out; of more, the extremes alone.
const PAIRWISE: usize = 64;

/// The value is max - min over the records of `range_days` up to the judged one, or over the newest
/// `range_min_records` where those days hold fewer; of several pairs, that one which exceeds with the largest
/// probability.
///
/// A single record that both of its neighbours contradict (farther than the limit from either, on the same side,
/// while they agree) is an outlier from which the gyro has returned: it is left out. `confirmed` when no single
/// record is to blame: leave out the highest or the lowest, and what remains still exceeds, beside what stations differ
/// by.
pub(crate) fn range(case: &Case<'_>, limit: Limit) -> Verdict {
    let (samples, now) = (&case.history.samples[..=case.k], case.now().at);
    let first = case.history.first_since_reset(case.k, Rule::Range);
    let need = case.limits.range_min_records.max(2);
    let too_old = |sample: &Sample| now.days_since(sample.at) > case.limits.range_days;
    let within_days = first + samples[first..].partition_point(too_old);
    let older = if within_days == 0 { case.history.older } else { Older::NONE };
    let start = if older.records > 0 { 0 } else { within_days.min(samples.len().saturating_sub(need)).max(first) };
    let records = older.records + samples.len() - start;
    if records < need {
        return case.too_few(Rule::Range, limit, records, need);
    }
    let found = if records <= PAIRWISE { of_few(case, &samples[first..], start - first, limit.value) } else { None };
    let Some(Found { pair, records, without_one }) = found.or_else(|| of_many(case, older, start, records)) else {
        return case.too_few(Rule::Range, limit, records, need);
    };
    let outcome = pair.outcome(records, limit.value, case.limits.confidence);
    let since = if older.records > 0 { pair.low.0.min(pair.high.0) } else { samples[start].at };
    let of = |(at, measured): (UtcMicros, Measured)| (at, measured.value);
    let finding = Finding::Range { records, since, lowest: of(pair.low), highest: of(pair.high) };
    let between = Some(pair.between).filter(|between| *between > 0.0);
    let without_one = Measured { value: without_one, sd: between };
    case.verdict(Rule::Range, limit, pair.difference(), outcome, finding)
        .between_stations(between)
        .confirmed_if(case.exceeds(without_one, limit.value))
}

struct Found {
    pair: Pair<UtcMicros>,
    /// Those that were compared.
    records: usize,
    /// The smaller of the two ranges that are left without the lowest or the highest.
    without_one: f64,
}

/// `samples` since the last reset, of which those from `start` on are compared.
fn of_few(case: &Case<'_>, samples: &[Sample], start: usize, limit: f64) -> Option<Found> {
    let value = |k: usize| case.value(&samples[k]);
    // Records before the window are there as far as the rule with the longest memory needs them.
    let reachable = start.min(samples.len().saturating_sub(RMS_RECORDS));
    let is_outlier = |k: usize| {
        let (Some(before), Some(_)) = (k.checked_sub(1).filter(|k| *k >= reachable), samples.get(k + 1)) else {
            return false;
        };
        let [before, after] = [before, k + 1].map(|k| value(k).value);
        let (off_before, off_after) = (value(k).value - before, value(k).value - after);
        off_before * off_after > 0.0 && off_before.abs().min(off_after.abs()) > limit && (after - before).abs() <= limit
    };
    let kept: Vec<(&Sample, Measured)> =
        (start..samples.len()).filter(|k| !is_outlier(*k)).map(|k| (&samples[k], value(k))).collect();
    let between = |a: &&Sample, b: &&Sample| if a.station == b.station { 0.0 } else { case.between_two_stations() };
    let (Pair { low, high, between }, without_one) = widest(&kept, between, limit)?;
    let of = |(sample, measured): (&Sample, Measured)| (sample.at, measured);
    Some(Found { pair: Pair { low: of(low), high: of(high), between }, records: kept.len(), without_one })
}

fn of_many(case: &Case<'_>, older: Older, start: usize, records: usize) -> Option<Found> {
    let samples = case.history.samples;
    let here = samples.extremes(case.column, start..case.k + 1);
    let extremes = older.extremes[case.column].and(here.at(|place| (samples[place].at, case.value(&samples[place]))));
    let (low, high) = extremes.lowest.zip(extremes.highest)?;
    // Of many records the stations of the extremes are not kept: they may be two unless all are seen to be of one.
    let is_of_one =
        older.records == 0 && samples[start..=case.k].iter().all(|sample| sample.station == case.now().station);
    let between = if is_of_one { 0.0 } else { case.between_two_stations() };
    Some(Found { pair: Pair { low, high, between }, records, without_one: extremes.range_without_one() })
}
