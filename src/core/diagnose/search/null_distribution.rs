//! What noise alone makes of the search: how often the largest evidence over everything that is tried exceeds a value.
//!
//! Drawing noise and counting would need thousands of draws for a probability of one in a thousand. Instead each draw
//! adds a hypothesis taken from the bank at random, with coefficients from its prior: under that mixture Q the density
//! of the residuals is the mean of all kinds' Bayes factors times that under noise alone, so
//!
//! ```text
//! P(max evidence > x) = E_Q[ 1(max evidence > x) / mean of the Bayes factors ]
//! ```
//!
//! (importance sampling of a scan statistic, Naiman and Priebe 2001). Rare values are common under Q, and their
//! correlations are the campaign's own. The draws are a fixed sequence: the same campaign gets the same answer.

use std::cell::LazyCell;

use nalgebra::DMatrix;

use crate::core::diagnose::residuals::pooled_noise::{Scatter, pool};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::bayes_factor::together;
use crate::core::diagnose::search::hypotheses::Bank;
use crate::core::diagnose::search::null_tables::BayesFactorTables;
use crate::core::diagnose::search::projections::GyroStatistics;
use crate::core::numerics::log_sum::LogSum;

const DRAWS: usize = 160;

/// Tail probability of the largest evidence under noise.
#[derive(Debug, Clone)]
pub(crate) struct Null {
    /// Largest evidence of each draw, descending, and the probability under noise of at least that.
    tail: Vec<(f64, f64)>,
}

impl Null {
    /// Draws noise as the frame's dwells have it and scores it with the bank's own hypotheses. The random numbers are
    /// the same for every campaign.
    pub fn of(frame: &Frame, bank: &Bank) -> Self {
        let kinds: Vec<_> = bank.kinds.iter().filter(|(kind, _)| kind.is_nameable()).collect();
        let mut random = Random::new(0x5851_F42D_4C95_7F2D);
        let signals: Vec<Signal> =
            (0..DRAWS).map(|d| Signal::draw(bank, &kinds[d % kinds.len()].1, &mut random)).collect();
        let n = frame.dwells();
        let mut scatters: Vec<Vec<Scatter>> = Vec::new();
        let mut products = Vec::new();
        for (j, gyro) in frame.gyros.iter().enumerate() {
            let mut drawn = DMatrix::from_fn(n, DRAWS, |_, _| random.normal());
            let scatter = frame.noise.log_scatter;
            if scatter > 0.0 {
                drawn.iter_mut().for_each(|x| *x *= (scatter * random.normal()).exp());
            }
            for (signal, mut column) in signals.iter().zip(drawn.column_iter_mut()) {
                for (i, &coefficient) in signal.coefficients[j].iter().enumerate() {
                    column.axpy(coefficient, &bank.column(j, signal.starts[j] + i), 1.0);
                }
            }
            let within = gyro.basis.matrix(n).transpose() * &drawn;
            let left = |d: usize| drawn.column(d).norm_squared() - within.column(d).norm_squared();
            scatters.push((0..DRAWS).map(|d| frame.noise.with_stated(left(d), gyro.dof() as f64)).collect());
            products.push(bank.columns[j].columns(0, bank.contract_columns[j]).transpose() * &drawn);
        }
        let nu: Vec<f64> = scatters.iter().map(|of_gyro| of_gyro[0].nu).collect();
        // A draw's gyros count alone or together, as they are alike or not.
        let alone = LazyCell::new(|| BayesFactorTables::of(bank, &kinds, &nu));
        let pooled = LazyCell::new(|| BayesFactorTables::of(bank, &kinds, &vec![nu.iter().sum::<f64>(); nu.len()]));
        let mut draws: Vec<(f64, f64)> = (0..DRAWS)
            .map(|d| {
                let mut scatter: Vec<Scatter> = scatters.iter().map(|of_gyro| of_gyro[d]).collect();
                let tabled = if frame.noise.stated && pool(&mut scatter) { &*pooled } else { &*alone };
                let seen: Vec<GyroStatistics> = (0..frame.gyros.len())
                    .map(|j| GyroStatistics {
                        with_residual: &products[j].as_slice()[d * products[j].nrows()..][..products[j].nrows()],
                        with_extra: &[],
                        adopted: 0,
                        rss: scatter[j].rss,
                        nu: scatter[j].nu,
                    })
                    .collect();
                let evidence: Vec<f64> = tabled.evidence(&seen).collect();
                let mut sum = LogSum::default();
                evidence.iter().for_each(|log| sum.add(*log));
                (together(evidence.iter().copied()), (-sum.log_mean(evidence.len())).exp())
            })
            .collect();
        draws.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut sum = 0.0;
        let tail = draws
            .into_iter()
            .map(|(top, weight)| {
                sum += weight;
                (top, (sum / DRAWS as f64).min(1.0))
            })
            .collect();
        Self { tail }
    }

    /// Probability that noise alone reaches an evidence of `log_evidence` somewhere in the search: the largest
    /// `alpha` of which [`Self::threshold`] is not reached, so that what a level refuses never has a smaller
    /// probability than that level.
    pub fn p_value(&self, log_evidence: f64) -> f64 {
        let (mut below, mut largest) = (0.0, 0.0_f64);
        for (i, &(top, p)) in self.reliable().iter().enumerate() {
            // Levels between the draw before and this one, or above the last, are those that `threshold` anchors here.
            let highest = if i + 1 == self.reliable().len() { 1.0 } else { p };
            let anchored = p * (top - log_evidence).exp();
            if anchored > below {
                largest = anchored.min(highest);
            }
            below = p;
        }
        largest.clamp(1e-300, 1.0)
    }

    /// Evidence that noise alone exceeds with probability `alpha`.
    ///
    /// Between and beyond the draws `p e^x` is taken as constant, which is its behaviour in the tail.
    pub fn threshold(&self, alpha: f64) -> f64 {
        let (top, p) = self.reliable().iter().find(|(_, p)| *p >= alpha).copied().unwrap_or(self.tail[DRAWS - 1]);
        top + (p / alpha).ln()
    }

    /// The few largest draws alone are a poor sum: those from the one on that a tenth exceed.
    fn reliable(&self) -> &[(f64, f64)] {
        &self.tail[DRAWS / 10..]
    }
}

/// Coefficients of one hypothesis drawn from its prior.
struct Signal {
    starts: Vec<usize>,
    coefficients: Vec<Vec<f64>>,
}

impl Signal {
    fn draw(bank: &Bank, range: &std::ops::Range<usize>, random: &mut Random) -> Self {
        let mut rest = random.uniform();
        let mut chosen = range.end - 1;
        for i in range.clone() {
            rest -= bank.hypotheses[i].log_weight.exp();
            if rest < 0.0 {
                chosen = i;
                break;
            }
        }
        let hypothesis = &bank.hypotheses[chosen];
        let gyros = hypothesis.blocks.len();
        let subset = 1 + (random.uniform() * f64::from((1_u32 << gyros) - 1)) as u32;
        let powers = hypothesis.powers;
        let mut size = |_: usize| powers[(random.uniform() * powers.len() as f64) as usize].sqrt();
        let sizes: Vec<f64> = (0..gyros).map(&mut size).collect();
        let widest = hypothesis.blocks.iter().map(|block| block.len).max().unwrap_or(0);
        let shared: Vec<f64> = (0..widest).map(|_| sizes[0] * random.normal()).collect();
        let coefficients = (hypothesis.blocks.iter().enumerate())
            .map(|(j, block)| match hypothesis.common {
                true => shared[..block.len].to_vec(),
                false if subset >> j & 1 == 1 => (0..block.len).map(|_| sizes[j] * random.normal()).collect(),
                false => Vec::new(),
            })
            .collect();
        Self { starts: hypothesis.blocks.iter().map(|block| block.start).collect(), coefficients }
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014) and the polar method: a fixed sequence of normal deviates, not chance.
struct Random {
    state: u64,
    /// The polar method makes two at a time.
    spare: Option<f64>,
}

impl Random {
    fn new(state: u64) -> Self {
        Self { state, spare: None }
    }

    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (x, y) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                let length = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(y * length);
                return x * length;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tail as draws make it: about e^-x, ragged.
    fn ragged(seed: u64) -> Null {
        let mut random = Random::new(seed);
        let mut tops: Vec<f64> = (0..DRAWS).map(|_| -2.0 + 14.0 * random.uniform()).collect();
        tops.sort_by(|a, b| b.total_cmp(a));
        let mut sum = 0.0;
        let tail = tops.into_iter().map(|top| {
            sum += 14.0 / DRAWS as f64 * (-top).exp() * random.uniform();
            (top, sum.min(1.0))
        });
        Null { tail: tail.collect() }
    }

    #[test]
    fn what_a_level_refuses_never_has_a_smaller_probability_than_the_level() {
        for seed in 0..50 {
            let null = ragged(seed);
            let mut before = 1.0;
            for step in 0..300 {
                let x = -3.0 + 0.06 * f64::from(step);
                let p = null.p_value(x);
                assert!(p <= before, "seed {seed}: {p} at {x} after {before}");
                before = p;
                for alpha in [0.3, 0.05, 0.01, 0.008, 0.005, 1e-4] {
                    let refused = x < null.threshold(alpha);
                    assert!(!refused || p >= alpha * (1.0 - 1e-9), "seed {seed}: {p} at {x}, level {alpha}");
                    // What is taken may have a little more: the tail is ragged.
                    assert!(refused || p < 3.0 * alpha, "seed {seed}: {p} at {x}, level {alpha}");
                }
            }
        }
    }
}
