//! `cusum`: a lasting shift too small for `step`, found by a two-sided self-starting cumulative sum.

use super::Case;
use crate::core::judge::decide::{Outcome, plain};
use crate::core::judge::history::{Measured, Sample};
use crate::core::judge::limits::CusumLimits;
use crate::core::judge::{Finding, Rule, Verdict};

/// Records that the rule looks back over.
pub const CUSUM_RECORDS: usize = 40;
/// Records before it says anything: the gyro's own level and scatter are learned from them.
pub const CUSUM_MIN_RECORDS: usize = 8;
/// Half of the shift that is looked for, in standard deviations.
const REFERENCE: f64 = 0.5;
/// No single record counts for more standard deviations: one bad campaign cannot raise the alarm.
const MOST: f64 = 3.0;

/// The value is the larger of the two sums max(0, S + (+-U) - 1/2) at the judged record, in standard deviations.
///
/// U_n is the normal score of (x_n - mean)/(scatter) against the records *before* n (Hawkins and Olwell, Cumulative Sum
/// Charts, 1998, ch. 7): on a stable gyro it is standard normal whatever its level and scatter are, so no baseline
/// has to be known first. The scatter is taken no smaller than the record's own standard deviation and than
/// `limits.least_scatter`: a shift that does not matter raises no alarm. `confirmed` is never set, several campaigns have
/// spoken already.
pub(crate) fn cusum(case: &Case<'_>, limits: &CusumLimits) -> Verdict {
    let samples = case.since_reset(Rule::Cusum);
    let window = &samples[samples.len().saturating_sub(CUSUM_RECORDS)..];
    let threshold = limits.threshold();
    if window.len() < CUSUM_MIN_RECORDS {
        return case.too_few(Rule::Cusum, threshold, window.len(), CUSUM_MIN_RECORDS);
    }
    let (up, down) = sums(case, window, limits.least_scatter);
    let (side, upward) = if up.sum >= down.sum { (up, true) } else { (down, false) };
    let outcome = Outcome { state: plain(side.sum, threshold), probability: None };
    let finding = Finding::Cusum {
        records: window.len() - side.onset,
        onset: window.get(side.onset).unwrap_or(case.now()).at,
        upward,
        records_per_false_alarm: limits.records_per_false_alarm,
    };
    case.verdict(Rule::Cusum, threshold, Measured::exact(side.sum), outcome, finding)
}

/// One side's sum, and the index of the first record since it last was zero.
#[derive(Clone, Copy, Default)]
struct Side {
    sum: f64,
    onset: usize,
}

impl Side {
    fn add(&mut self, i: usize, score: f64) {
        self.sum += score - REFERENCE;
        if self.sum <= 0.0 {
            *self = Side { sum: 0.0, onset: i + 1 };
        }
    }
}

/// 1/n, so that the running mean does not wait for a division at every record.
const RECIPROCAL: [f64; CUSUM_RECORDS + 1] = {
    let mut table = [0.0; CUSUM_RECORDS + 1];
    let mut n = 1;
    while n <= CUSUM_RECORDS {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};

fn sums(case: &Case<'_>, window: &[Sample], least_scatter: f64) -> (Side, Side) {
    let (mut up, mut down) = (Side::default(), Side::default());
    let (mut mean, mut squares) = (0.0, 0.0);
    for (i, sample) in window.iter().enumerate() {
        let x = case.value(sample);
        let off = x.value - mean;
        if i >= 2 {
            let least = least_scatter.max(x.sd.unwrap_or(0.0));
            let scatter_squared = (squares * RECIPROCAL[i - 1]).max(least * least);
            let t_squared = off * off * i as f64 * RECIPROCAL[i + 1] / scatter_squared;
            let u = if scatter_squared > 0.0 { score(t_squared, i - 1).copysign(off) } else { 0.0 };
            up.add(i, u);
            down.add(i, -u);
        }
        mean += off * RECIPROCAL[i + 1];
        squares += off * (x.value - mean);
    }
    (up, down)
}

/// |z| of Student's t with nu degrees of freedom: t (1 - 1/(4 nu))/sqrt(1 + t^2/(2 nu)) (Abramowitz and Stegun 26.7.8),
/// bounded by [`MOST`]. The thresholds are simulated with it, so what it lacks in accuracy they make up for.
fn score(t_squared: f64, nu: usize) -> f64 {
    let inverse = RECIPROCAL[nu];
    ((1.0 - 0.25 * inverse) * (t_squared / (1.0 + 0.5 * inverse * t_squared)).sqrt()).min(MOST)
}
