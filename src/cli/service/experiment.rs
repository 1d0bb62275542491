//! The table of the paper's experiment, simulated.

use std::io::Write;

use crate::cli::document::table;
use crate::experiment::{HEADLINE, MethodComparison, compare_many};

/// Runs `count` experiments and prints the ranges of Table 5 by both methods, or every result as CSV.
pub fn print(seed: u64, count: u64, csv: bool) -> anyhow::Result<()> {
    let experiments = compare_many(seed, count).map_err(anyhow::Error::msg)?;
    let all: Vec<&MethodComparison> = experiments.iter().flatten().collect();
    let mut out = std::io::stdout().lock();
    if csv {
        return results(&mut out, seed, &experiments);
    }
    writeln!(out, "range of bench before, IMU, bench after; {count} simulated experiments from seed {seed}")?;
    writeln!(out, "{}", ranges(&all))?;
    let whole = |range: fn(&MethodComparison) -> Option<f64>| {
        let below = |e: &&Vec<MethodComparison>| e.iter().all(|c| range(c).is_some_and(|r| r < HEADLINE));
        experiments.iter().filter(below).count()
    };
    writeln!(out, "all six ranges of an experiment below {HEADLINE:e} deg/(h g0):")?;
    writeln!(out, "  rigid      {} of {count}", whole(|c| Some(c.rigid_range())))?;
    writeln!(out, "  published  {} of {count}", whole(MethodComparison::published_range))?;
    Ok(())
}

fn results(mut out: impl Write, seed: u64, experiments: &[Vec<MethodComparison>]) -> anyhow::Result<()> {
    writeln!(out, "seed,slot,coefficient,bench_before,rigid,published,bench_after")?;
    for (k, experiment) in experiments.iter().enumerate() {
        for c in experiment {
            let (seed, slot, published) =
                (seed + k as u64, c.slot.name(), c.published.map_or(String::new(), |d| format!("{d:.9}")));
            let MethodComparison { coefficient, bench_before, rigid, bench_after, .. } = c;
            writeln!(out, "{seed},{slot},{coefficient},{bench_before:.9},{rigid:.9},{published},{bench_after:.9}")?;
        }
    }
    Ok(())
}

fn ranges(all: &[&MethodComparison]) -> comfy_table::Table {
    let mut table = table(["gyro", "coefficient", "method", "median", "95 %", "largest", "below 1.301e-3"], 3..7);
    let mut kinds: Vec<_> = all.iter().map(|c| (c.slot, c.coefficient)).collect();
    kinds.sort();
    kinds.dedup();
    for (slot, coefficient) in kinds {
        let of = || all.iter().filter(|c| (c.slot, c.coefficient) == (slot, coefficient));
        let rigid = of().map(|c| c.rigid_range()).collect();
        let published = of().filter_map(|c| c.published_range()).collect();
        for (method, values) in [("rigid", rigid), ("published", published)] {
            let mut cells = vec![slot.name().to_owned(), coefficient.to_owned(), method.to_owned()];
            cells.extend(summary(values));
            table.add_row(cells);
        }
    }
    table
}

/// Median, 95th percentile, largest, and how many are below the headline.
fn summary(mut values: Vec<f64>) -> [String; 4] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let value = values.get((share * (values.len().max(1) - 1) as f64).round() as usize);
        value.map_or(String::new(), |v| format!("{v:.2e}"))
    };
    let below = values.iter().filter(|v| **v < HEADLINE).count();
    [at(0.5), at(0.95), at(1.0), format!("{below} of {}", values.len())]
}
