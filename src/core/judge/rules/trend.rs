//! `trend`: where a robust slope carries the coefficient, and when it reaches the budget.

use super::Case;
use super::baseline::{LEVEL_RECORDS, Level};
use crate::core::judge::decide::{Outcome, normal_quantile};
use crate::core::judge::history::{Measured, Sample};
use crate::core::judge::limits::TrendLimits;
use crate::core::judge::{Finding, Rule, State, Verdict};

/// Records that the slope is taken over.
pub const TREND_RECORDS: usize = 24;
/// Records before it says anything.
pub const TREND_MIN_RECORDS: usize = 8;
const PAIRS: usize = TREND_RECORDS * (TREND_RECORDS - 1) / 2;

/// The value is |deviation from the baseline that the slope leads to| at the horizon, the limit is the budget.
///
/// The slope is that of Theil and Sen (median over all pairs of records), its interval Sen's, from the distribution of
/// Kendall's S (Sen 1968); at the stated confidence an interval that holds zero establishes no slope, and then nothing is
/// exceeded. The horizon is `limits.horizon_days`, but never longer than the time that the records span: nine days of
/// records do not foretell a quarter. A step explains a slope away where it fits the records better than a line.
/// `confirmed` is never set, many campaigns have spoken already.
pub(crate) fn trend(case: &Case<'_>, limits: &TrendLimits, fixed: Option<Measured>) -> Verdict {
    let samples = case.since_reset(Rule::Trend);
    let window = &samples[samples.len().saturating_sub(TREND_RECORDS)..];
    if window.len() < TREND_MIN_RECORDS {
        return case.too_few(Rule::Trend, limits.budget, window.len(), TREND_MIN_RECORDS);
    }
    let level = match Level::of(case, fixed) {
        Ok(level) => level.level.value,
        Err(have) => return case.too_few(Rule::Trend, limits.budget, have, LEVEL_RECORDS),
    };
    let records = Records::of(case, window);
    let span = -records.t[0];
    let horizon = limits.horizon_days.min(span);
    let nothing = |slope, step| {
        let value = Measured::exact(records.median_deviation(level, slope));
        let outcome = Outcome { state: State::Within, probability: None };
        let finding = Finding::NoTrend { records: window.len(), since: window[0].at, step };
        case.verdict(Rule::Trend, limits.budget, value, outcome, finding)
    };
    let z = normal_quantile(0.5 + 0.5 * limits.confidence);
    if records.kendall_s().abs() <= z * records.kendall_sd() {
        return nothing(0.0, None);
    }
    let slope = records.slope(z);
    if slope.low <= 0.0 && slope.high >= 0.0 {
        return nothing(slope.median, None);
    }
    if let Some(step) = records.step_that_fits_better() {
        return nothing(0.0, Some(window[step].at));
    }
    let deviation = records.median_deviation(level, slope.median);
    let sd = (slope.high - slope.low) / (2.0 * z) * horizon;
    let ahead = Measured { value: deviation + slope.median * horizon, sd: Some(sd) };
    let reach = [slope.steeper(), slope.median, slope.shallower()]
        .map(|slope| days_to_budget(deviation, slope, limits.budget))
        .map(|days| case.now().at.plus_days(days));
    let finding = Finding::Trend {
        records: window.len(),
        since: window[0].at,
        until: case.now().at,
        per_day: [slope.low, slope.median, slope.high],
        deviation,
        horizon_days: horizon,
        reach,
    };
    case.verdict(Rule::Trend, limits.budget, ahead, case.beyond(ahead, limits.budget), finding)
}

/// Days until a deviation with this slope lies at the budget on the side that it moves to; 0 where it is there already.
fn days_to_budget(deviation: f64, per_day: f64, budget: f64) -> f64 {
    ((budget * per_day.signum() - deviation) / per_day).max(0.0)
}

/// Records as days before the judged one (so t <= 0) and values.
struct Records {
    t: [f64; TREND_RECORDS],
    x: [f64; TREND_RECORDS],
    n: usize,
}

struct Slope {
    low: f64,
    median: f64,
    high: f64,
}

impl Slope {
    fn steeper(&self) -> f64 {
        if self.median > 0.0 { self.high } else { self.low }
    }

    fn shallower(&self) -> f64 {
        if self.median > 0.0 { self.low } else { self.high }
    }
}

impl Records {
    fn of(case: &Case<'_>, window: &[Sample]) -> Self {
        let (mut t, mut x) = ([0.0; TREND_RECORDS], [0.0; TREND_RECORDS]);
        for (i, sample) in window.iter().enumerate() {
            t[i] = sample.at.days_since(case.now().at);
            x[i] = case.value(sample).value;
        }
        Self { t, x, n: window.len() }
    }

    fn kendall_s(&self) -> f64 {
        let x = &self.x[..self.n];
        let mut s = 0;
        for (i, later) in x.iter().enumerate() {
            s += x[..i].iter().map(|earlier| i32::from(later > earlier) - i32::from(later < earlier)).sum::<i32>();
        }
        f64::from(s)
    }

    /// sqrt(n (n-1) (2n+5)/18), the standard deviation of S without a trend.
    fn kendall_sd(&self) -> f64 {
        let n = self.n as f64;
        (n * (n - 1.0) * (2.0 * n + 5.0) / 18.0).sqrt()
    }

    /// Theil-Sen slope per day, and Sen's interval among the N pairs: the slopes of rank (N - z sd(S))/2 and
    /// (N + z sd(S))/2 + 1, counted from 1, which a change of sign turns into one another.
    fn slope(&self, z: f64) -> Slope {
        let mut slopes = [0.0; PAIRS];
        let mut pairs = 0;
        for j in 1..self.n {
            for i in 0..j {
                let days = self.t[j] - self.t[i];
                if days > 0.0 {
                    slopes[pairs] = (self.x[j] - self.x[i]) / days;
                    pairs += 1;
                }
            }
        }
        let slopes = &mut slopes[..pairs];
        slopes.sort_unstable_by(f64::total_cmp);
        let half = z * self.kendall_sd() / 2.0;
        let rank = |r: f64| slopes[(r.max(0.0) as usize).min(pairs - 1)];
        let middle = pairs as f64 / 2.0;
        let median = 0.5 * (slopes[(pairs - 1) / 2] + slopes[pairs / 2]);
        Slope { low: rank((middle - half).floor() - 1.0), median, high: rank((middle + half).ceil()) }
    }

    /// Median of x - slope t, minus the baseline: the deviation at the judged record.
    fn median_deviation(&self, baseline: f64, per_day: f64) -> f64 {
        let mut off: [f64; TREND_RECORDS] = std::array::from_fn(|i| self.x[i] - per_day * self.t[i] - baseline);
        let (lower, &mut upper_middle, _) = off[..self.n].select_nth_unstable_by(self.n / 2, f64::total_cmp);
        if self.n % 2 == 1 {
            return upper_middle;
        }
        let lower_middle = lower.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (lower_middle + upper_middle)
    }

    /// The record at which a change of level explains the values better (by least squares) than a line does.
    fn step_that_fits_better(&self) -> Option<usize> {
        let (t, x, n) = (&self.t[..self.n], &self.x[..self.n], self.n as f64);
        let (mean_t, mean_x) = (t.iter().sum::<f64>() / n, x.iter().sum::<f64>() / n);
        let (mut tt, mut tx) = (0.0, 0.0);
        for (t, x) in t.iter().zip(x) {
            tt += (t - mean_t) * (t - mean_t);
            tx += (t - mean_t) * (x - mean_x);
        }
        let explained_by_line = if tt > 0.0 { tx * tx / tt } else { 0.0 };
        // A step between two groups explains n1 n2/n (difference of their means)^2 = n/(n1 n2) (sum over one group)^2.
        let mut sum = 0.0;
        let explained_by_step = (1..self.n).map(|first| {
            sum += x[first - 1] - mean_x;
            let n1 = first as f64;
            (sum * sum * n / (n1 * (n - n1)), first)
        });
        let best = explained_by_step.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > explained_by_line).then_some(best.1)
    }
}
