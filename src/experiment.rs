//! The paper's experiment (section 4.3, Table 5) on simulated gyros: D_I and D_S from the bench before, from the IMU
//! and from the bench after, and the range of the three, by the rigid and by the published method.

use rayon::prelude::*;

use crate::core::calibrate::bench::calibrate_bench;
use crate::core::calibrate::calibrate;
use crate::core::message::Message;
use crate::core::mounting::Slot;
use crate::core::record::Plausibility;
use crate::simulate::experiment::{Stage, tests};
use crate::simulate::{Simulated, simulate};
use crate::wire::problem::summary;
use crate::words::Language;

/// The paper's headline: the largest range of its Table 5, deg/(h g0).
pub const HEADLINE: f64 = 1.301e-3;

/// One coefficient of one gyro by every method, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodComparison {
    pub slot: Slot,
    /// "D_I" or "D_S".
    pub coefficient: &'static str,
    pub bench_before: f64,
    pub rigid: f64,
    /// None where eqs. (8)-(13) do not apply.
    pub published: Option<f64>,
    pub bench_after: f64,
}

impl MethodComparison {
    /// Table 5's last column with the rigid method in the middle.
    pub fn rigid_range(&self) -> f64 {
        range([self.bench_before, self.rigid, self.bench_after])
    }

    pub fn published_range(&self) -> Option<f64> {
        self.published.map(|d| range([self.bench_before, d, self.bench_after]))
    }
}

fn range(results: [f64; 3]) -> f64 {
    results.into_iter().fold(f64::MIN, f64::max) - results.into_iter().fold(f64::MAX, f64::min)
}

/// One experiment: three gyros, two coefficients each. An error says which test failed and why.
pub fn compare(seed: u64) -> Result<Vec<MethodComparison>, String> {
    let mut benches: [Vec<[f64; 2]>; 2] = Default::default();
    let mut system = Vec::new();
    for test in tests(seed) {
        let failed = |why: String| format!("seed {seed}, {}: {why}", test.name());
        let simulated = simulate(&test.scenario).map_err(|faults| failed(summary(&faults.0, Language::English)))?;
        match test.stage {
            Stage::System => system = separated(&simulated).map_err(failed)?,
            Stage::BenchBefore => benches[0].push(benched(&simulated).map_err(failed)?),
            Stage::BenchAfter => benches[1].push(benched(&simulated).map_err(failed)?),
        }
    }
    let mut comparisons = Vec::new();
    for (k, slot) in Slot::ALL.into_iter().enumerate() {
        for (c, coefficient) in ["D_I", "D_S"].into_iter().enumerate() {
            let (rigid, published) = &system[k];
            comparisons.push(MethodComparison {
                slot,
                coefficient,
                bench_before: benches[0][k][c],
                rigid: rigid[c],
                published: published.map(|d| d[c]),
                bench_after: benches[1][k][c],
            });
        }
    }
    Ok(comparisons)
}

pub fn compare_many(first_seed: u64, count: u64) -> Result<Vec<Vec<MethodComparison>>, String> {
    (0..count).into_par_iter().map(|k| compare(first_seed.wrapping_add(k))).collect()
}

fn in_english(message: &Message) -> String {
    Language::English.words(message)
}

fn benched(simulated: &Simulated) -> Result<[f64; 2], String> {
    let fitted = calibrate_bench(&simulated.campaign).map_err(|e| in_english(&e.message()))?;
    let result = fitted.result(&simulated.campaign);
    Ok([result.d_i, result.d_s])
}

type Separated = ([f64; 2], Option<[f64; 2]>);

fn separated(simulated: &Simulated) -> Result<Vec<Separated>, String> {
    let campaign = &simulated.campaign;
    let separations = calibrate(campaign, campaign.terms()).separate(&campaign.geometry, &Plausibility::default());
    separations
        .into_iter()
        .map(|separation| {
            let separation = separation.map_err(|e| in_english(&e.message()))?;
            let published = separation.published.ok().map(|p| [p.d_i, p.d_s]);
            Ok(([separation.rigid.d_i, separation.rigid.d_s], published))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms(values: impl Iterator<Item = f64> + Clone) -> f64 {
        (values.clone().map(|v| v * v).sum::<f64>() / values.count() as f64).sqrt()
    }

    #[test]
    fn rigid_agrees_with_the_bench_as_table_5_does_and_published_does_not() {
        let experiments = compare_many(1, 60).unwrap();
        let all: Vec<&MethodComparison> = experiments.iter().flatten().collect();
        let below = all.iter().filter(|c| c.rigid_range() < HEADLINE).count();
        assert!(below as f64 >= 0.99 * all.len() as f64, "{below} of {}", all.len());
        let published = all.iter().filter(|c| c.published_range().is_some_and(|r| r < HEADLINE)).count();
        assert!((published as f64) < 0.8 * all.len() as f64, "{published} of {}", all.len());
    }

    #[test]
    fn the_benches_are_no_better_than_the_paper_s_by_more_than_a_factor_of_three() {
        // Table 5: bench before less bench after.
        let table_5 = [3.03e-4, -6.57e-4, -5.96e-4, -0.06e-4, 0.847e-4, -13.01e-4];
        let experiments = compare_many(100, 40).unwrap();
        let ours = rms(experiments.iter().flatten().map(|c| c.bench_before - c.bench_after));
        let ratio = ours / rms(table_5.into_iter());
        assert!((1.0 / 3.0..1.5).contains(&ratio), "{ours} is {ratio} of Table 5's");
    }

    #[test]
    fn the_same_seed_compares_the_same() {
        assert_eq!(compare(7).unwrap(), compare(7).unwrap());
        assert_eq!(compare(7).unwrap().len(), 6);
    }
}
