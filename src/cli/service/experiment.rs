//! The table of the paper's experiment, simulated.

use std::io::Write;

use crate::cli::document::part_of;
use crate::cli::prelude::*;
use crate::experiment::{HEADLINE, MethodComparison, compare_many};

const RIGID: &str = "method_rigid";
const PUBLISHED: &str = "terminal_published";

/// Runs `count` experiments and prints the ranges of Table 5 by both methods, or every result as CSV.
pub fn print(seed: u64, count: u64, csv: bool) -> anyhow::Result<()> {
    let experiments = compare_many(seed, count).map_err(anyhow::Error::msg)?;
    let all: Vec<&MethodComparison> = experiments.iter().flatten().collect();
    let mut out = std::io::stdout().lock();
    if csv {
        return results(&mut out, seed, &experiments);
    }
    writeln!(out, "{}", said(message!("terminal_ranges", count, seed = seed.to_string())))?;
    writeln!(out, "{}", ranges(&all))?;
    let whole = |range: fn(&MethodComparison) -> Option<f64>| {
        let below = |e: &&Vec<MethodComparison>| e.iter().all(|c| range(c).is_some_and(|r| r < HEADLINE));
        experiments.iter().filter(below).count()
    };
    writeln!(out, "{}", said(message!("terminal_ranges_below", headline = format!("{HEADLINE:e}"))))?;
    let rigid = whole(|c| Some(c.rigid_range()));
    for (method, below) in [(RIGID, rigid), (PUBLISHED, whole(MethodComparison::published_range))] {
        writeln!(out, "  {:<10} {}", word(method), part_of(below.to_string(), count))?;
    }
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
    let mut table = table_of("terminal_ranges_head", 3..7);
    let mut kinds: Vec<_> = all.iter().map(|c| (c.slot, c.coefficient)).collect();
    kinds.sort();
    kinds.dedup();
    for (slot, coefficient) in kinds {
        let of = || all.iter().filter(|c| (c.slot, c.coefficient) == (slot, coefficient));
        let rigid = of().map(|c| c.rigid_range()).collect();
        let published = of().filter_map(|c| c.published_range()).collect();
        for (method, values) in [(RIGID, rigid), (PUBLISHED, published)] {
            let mut cells = vec![slot.name().to_owned(), coefficient.to_owned(), word(method).to_owned()];
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
    [at(0.5), at(0.95), at(1.0), part_of(below.to_string(), values.len() as u64)]
}
