//! Bayes factors of the contract's hypotheses from tables, for the many draws of
//! [`crate::core::diagnose::search::null_distribution`].
//!
//! With nothing adopted a flat block's Bayes factor is a function of one number, the share `u = |U'r|^2/R` of the
//! residual that it explains: a table of it for each number of columns and of degrees of freedom replaces logarithms
//! and exponentials by a look-up. Linear interpolation errs by less than a thousandth where the threshold lies.

use std::ops::Range;

use crate::core::diagnose::search::bayes_factor::score;
use crate::core::diagnose::search::hypotheses::{Bank, Hypothesis};
use crate::core::diagnose::search::projections::GyroStatistics;
use crate::core::diagnose::search::projections::MAX_GYROS;
use crate::core::effects::Effect;

/// Cells of a table over u from 0 to 1.
const CELLS: usize = 1024;

/// Logarithms of Bayes factors are cut off here: the product of three gyros still is a number, and so rare is noise
/// alone.
const MOST: f64 = 200.0;

/// One block's Bayes factor over u.
struct Table(Vec<f64>);

/// Where a block's products lie, how many, and which table they ask; none where the design hides it in this gyro.
type Place = Option<(usize, usize, usize)>;

/// One kind's hypotheses: prior weight, and its block in each gyro. Common ones are not flat and go the long way.
enum Entries {
    Flat(Vec<(f64, [Place; MAX_GYROS])>),
    Common(Effect, Range<usize>),
}

pub(crate) struct BayesFactorTables<'a> {
    bank: &'a Bank,
    gyros: usize,
    tables: Vec<Table>,
    kinds: Vec<Entries>,
}

impl<'a> BayesFactorTables<'a> {
    /// `nu` are the degrees of freedom of each gyro.
    pub fn of(bank: &'a Bank, kinds: &[&(Effect, Range<usize>)], nu: &[f64]) -> Self {
        // Gyros with as many degrees of freedom share their tables.
        let mut known: Vec<(f64, usize, &'static [f64])> = Vec::new();
        let mut place = |hypothesis: &Hypothesis, j: usize| -> Place {
            let block = &hypothesis.blocks[j];
            let key = (nu[j], block.len, hypothesis.powers);
            let table = known.iter().position(|k| *k == key).unwrap_or_else(|| {
                known.push(key);
                known.len() - 1
            });
            (block.len > 0).then_some((block.start, block.len, table))
        };
        let mut entries = Vec::new();
        for (kind, range) in kinds {
            let hypotheses = &bank.hypotheses[range.clone()];
            entries.push(if hypotheses.iter().any(|hypothesis| hypothesis.common) {
                Entries::Common(*kind, range.clone())
            } else {
                let flat = hypotheses.iter().map(|hypothesis| {
                    let mut places = [None; MAX_GYROS];
                    (0..nu.len()).for_each(|j| places[j] = place(hypothesis, j));
                    (hypothesis.log_weight.exp(), places)
                });
                Entries::Flat(flat.collect())
            });
        }
        let tables = known.iter().map(|&(nu, len, powers)| Table::of(nu, len, powers)).collect();
        Self { bank, gyros: nu.len(), tables, kinds: entries }
    }

    /// ln of the Bayes factor of each kind.
    pub fn evidence(&self, seen: &[GyroStatistics]) -> impl Iterator<Item = f64> {
        let none = 0.5_f64.powi(self.gyros as i32);
        self.kinds.iter().map(move |entries| match entries {
            Entries::Common(kind, range) => score(self.bank, *kind, range.clone(), seen).log_evidence,
            Entries::Flat(hypotheses) => {
                let factor = |(seen, place): (&GyroStatistics, &Place)| match place {
                    Some((start, len, table)) => {
                        let explained: f64 = seen.with_residual[*start..][..*len].iter().map(|b| b * b).sum();
                        0.5 + 0.5 * self.tables[*table].at(explained / seen.rss)
                    }
                    None => 1.0,
                };
                let sum: f64 = hypotheses
                    .iter()
                    .map(|(weight, places)| weight * (seen.iter().zip(places).map(factor).product::<f64>() - none))
                    .sum();
                (sum / (1.0 - none)).ln()
            }
        })
    }
}

impl Table {
    fn of(nu: f64, len: usize, powers: &[f64]) -> Self {
        let at = |u: f64| {
            let of_power = |power: &f64| {
                let gain = -0.5 * nu * (1.0 - (power / (1.0 + power) * u).min(1.0 - 1e-12)).ln();
                (gain - 0.5 * len as f64 * power.ln_1p()).min(MOST).exp()
            };
            powers.iter().map(of_power).sum::<f64>() / powers.len() as f64
        };
        Self((0..=CELLS + 1).map(|i| at(i as f64 / CELLS as f64)).collect())
    }

    fn at(&self, u: f64) -> f64 {
        let x = u.clamp(0.0, 1.0) * CELLS as f64;
        let cell = x as usize;
        let (low, high) = (self.0[cell], self.0[cell + 1]);
        low + (high - low) * (x - cell as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_bayes_factor_it_stands_for() {
        // nu = 78, two coefficients of prior power 8: (1 + 8)^-1 (1 - 8/9 u)^-39.
        let table = Table::of(78.0, 2, &[8.0]);
        for u in [0.0_f64, 0.05, 0.21, 0.37, 0.5] {
            let exact = (1.0 - 8.0 / 9.0 * u).powf(-39.0) / 9.0;
            assert!((table.at(u) / exact - 1.0).abs() < 1e-3, "{u}: {} {exact}", table.at(u));
        }
        assert!(table.at(1.0).is_finite() && table.at(2.0) == table.at(1.0));
    }
}
