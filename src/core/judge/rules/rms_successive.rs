//! `rms_successive`: root mean square of successive differences, the criterion that Apollo's gyros were watched by.

use super::Case;
use crate::core::judge::decide::Conformity;
use crate::core::judge::limits::{Limit, RMS_RECORDS};
use crate::core::judge::{Finding, Measured, Rule, Sample, Verdict};
use crate::core::numerics::normal::normal_cdf;

/// Makes up for the record that is left out: at a scatter of 0.3 budgets the rule speaks as often as over all eleven.
const FACTOR: f64 = 1.2;

/// The value is 1.2 sqrt(mean (x_i - x_(i-1))^2) over the last [`RMS_RECORDS`] records, that one left out which
/// leaves the least: one bad record makes two large differences, and says nothing of the gyro.
///
/// Slow drift hardly enters it: it tells a restless gyro (bearing, suspension) from one that ages. Where standard
/// deviations are known, what they explain of the mean square is taken off before the limit is asked, and so is what
/// stations differ by: 2 sigma_b^2 of each difference of two, known no better than the square of one normal figure.
/// `confirmed` is never set: ten campaigns have spoken already.
pub(crate) fn rms_successive(case: &Case<'_>, limit: Limit) -> Verdict {
    let samples = case.since_reset(Rule::RmsSuccessive);
    let Some(window) = samples.len().checked_sub(RMS_RECORDS).map(|start| &samples[start..]) else {
        return case.too_few(Rule::RmsSuccessive, limit, samples.len(), RMS_RECORDS);
    };
    let least = (0..RMS_RECORDS).map(|left_out| SuccessiveDifferences::of(case, window, left_out));
    let Some(differences) = least.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square())) else {
        return case.too_few(Rule::RmsSuccessive, limit, samples.len(), RMS_RECORDS);
    };
    // In units of the largest figure, as the squares of variances overflow long before the figures do.
    let scale = differences.largest().max(limit.value);
    let differences = differences.divided_by(scale);
    let rms = differences.mean_square().sqrt();
    let between = differences.of_two_stations * (case.between_two_stations() / scale).powi(2);
    let noise = differences.noise().map(|noise| noise.and(between));
    let noise = noise.or_else(|| (between > 0.0).then(|| NoiseShare::NONE.and(between)));
    let (outcome, sd) = match noise {
        Some(noise) if noise.variance > 0.0 => {
            let excess = rms * rms - noise.explained - (limit.value / (FACTOR * scale)).powi(2);
            let probability = normal_cdf(excess / noise.variance.sqrt());
            let outcome = Conformity::by_probability(excess > 0.0, probability, case.limits.confidence);
            let sd = if rms > 0.0 { noise.variance.sqrt() / (2.0 * rms) } else { noise.explained.sqrt() };
            (outcome, Some(FACTOR * sd * scale))
        }
        _ => (Conformity::certain(FACTOR * rms * scale > limit.value), None),
    };
    let finding = Finding::RmsSuccessive {
        since: window[0].at,
        explained: noise.map(|noise| FACTOR * noise.explained.max(0.0).sqrt() * scale),
    };
    case.verdict(Rule::RmsSuccessive, limit, Measured { value: FACTOR * rms * scale, sd }, outcome, finding)
}

/// Records that are left, and their differences.
const KEPT: usize = RMS_RECORDS - 1;

/// Successive differences d and the tridiagonal covariance V of their errors: sums of two variances on its diagonal,
/// minus the shared one beside it.
struct SuccessiveDifferences {
    d: [f64; KEPT - 1],
    /// Variances of the records themselves.
    variance: Option<[f64; KEPT]>,
    /// The share of them that are of two stations.
    of_two_stations: f64,
}

/// What measurement noise does to the mean square m = d.d/n, to second order in the noise.
#[derive(Clone, Copy)]
struct NoiseShare {
    /// tr V / n: the part of m that it explains.
    explained: f64,
    /// (2 tr V^2 + 4 delta.V delta)/n^2, with delta.V delta estimated by d.V d - tr V^2 >= 0.
    variance: f64,
}

impl NoiseShare {
    const NONE: Self = Self { explained: 0.0, variance: 0.0 };

    /// Beside a part that a normal figure makes, squared, of which only the mean is known.
    fn and(self, part: f64) -> Self {
        Self { explained: self.explained + part, variance: self.variance + 2.0 * part * part }
    }
}

impl SuccessiveDifferences {
    fn of(case: &Case<'_>, window: &[Sample], left_out: usize) -> Self {
        let kept = |i: usize| &window[if i < left_out { i } else { i + 1 }];
        let value = |i: usize| case.value(kept(i));
        let d = std::array::from_fn(|i| value(i + 1).value - value(i).value);
        let known = (0..KEPT).all(|i| value(i).sd.is_some());
        let variance = known.then(|| std::array::from_fn(|i| value(i).sd.map_or(0.0, |sd| sd * sd)));
        let of_two = (1..KEPT).filter(|i| kept(*i).station != kept(i - 1).station).count();
        Self { d, variance, of_two_stations: of_two as f64 / (KEPT - 1) as f64 }
    }

    fn largest(&self) -> f64 {
        let variance = self.variance.iter().flatten().copied().fold(0.0, f64::max);
        self.d.iter().map(|d| d.abs()).fold(variance.sqrt(), f64::max)
    }

    fn divided_by(&self, scale: f64) -> Self {
        let square = scale * scale;
        let variance = self.variance.map(|variances| variances.map(|v| v / square));
        Self { d: self.d.map(|d| d / scale), variance, ..*self }
    }

    fn mean_square(&self) -> f64 {
        self.d.iter().map(|d| d * d).sum::<f64>() / self.d.len() as f64
    }

    fn noise(&self) -> Option<NoiseShare> {
        let variance = self.variance?;
        let n = self.d.len();
        let (mut trace, mut trace_of_square, mut d_v_d) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let own = variance[i] + variance[i + 1];
            trace += own;
            trace_of_square += own * own;
            d_v_d += self.d[i] * self.d[i] * own;
            if i + 1 < n {
                let shared = -variance[i + 1];
                trace_of_square += 2.0 * shared * shared;
                d_v_d += 2.0 * self.d[i] * self.d[i + 1] * shared;
            }
        }
        let n = n as f64;
        let structure = (d_v_d - trace_of_square).max(0.0);
        Some(NoiseShare { explained: trace / n, variance: (2.0 * trace_of_square + 4.0 * structure) / (n * n) })
    }
}
