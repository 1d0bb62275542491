//! `requirement`: E and G against the requirement columns of the paper's Tables 3 and 4.

use nalgebra::Vector3;

use crate::core::judge::decide::outside;
use crate::core::judge::history::Measured;
use crate::core::judge::limits::{Bounds, Requirement};
use crate::core::judge::{Coefficient, Finding, Rule, Verdict};

/// A figure of the record, its name, and what it must lie between.
struct Figure {
    name: &'static str,
    measured: Measured,
    bounds: Bounds,
}

impl Figure {
    /// How far outside (positive) or inside (negative) it lies, in widths of its bounds.
    fn excess(&self) -> f64 {
        let Bounds { low, high } = self.bounds;
        (low - self.measured.value).max(self.measured.value - high) / (high - low)
    }

    fn nearest_bound(&self) -> f64 {
        let Bounds { low, high } = self.bounds;
        if self.measured.value - low < high - self.measured.value { low } else { high }
    }
}

/// One verdict on E (|E| and its three components) and one on G, each about the figure that lies farthest out; the
/// value is that figure and the limit its nearest bound. None where nothing is required.
pub fn requirement(
    required: &Requirement,
    e: &Vector3<f64>,
    g: &Vector3<f64>,
    e_sd: Option<&Vector3<f64>>,
    g_sd: Option<&Vector3<f64>>,
    confidence: f64,
) -> [Option<Verdict>; 2] {
    const E_NAMES: [&str; 3] = ["E_x", "E_y", "E_z"];
    const G_NAMES: [&str; 3] = ["G_x", "G_y", "G_z"];
    let component = |v: &Vector3<f64>, sd: Option<&Vector3<f64>>, axis: usize| Measured {
        value: v[axis],
        sd: sd.map(|sd| sd[axis]),
    };
    let of_e = (0..3).map(|axis| (E_NAMES[axis], component(e, e_sd, axis), required.e[axis]));
    let norm = (E_NAME_OF_NORM, Measured { value: e.norm(), sd: e_sd.map(|sd| sd.component_mul(e).norm() / e.norm()) });
    let of_g = (0..3).map(|axis| (G_NAMES[axis], component(g, g_sd, axis), required.g[axis]));
    [
        judged(Coefficient::E, of_e.chain([(norm.0, norm.1, required.e_norm)]), confidence),
        judged(Coefficient::G, of_g, confidence),
    ]
}

const E_NAME_OF_NORM: &str = "|E|";

fn judged(
    coefficient: Coefficient,
    figures: impl Iterator<Item = (&'static str, Measured, Option<Bounds>)>,
    confidence: f64,
) -> Option<Verdict> {
    let (mut worst, mut outside_count): (Option<Figure>, usize) = (None, 0);
    for (name, measured, bounds) in figures {
        let Some(bounds) = bounds else { continue };
        let figure = Figure { name, measured, bounds };
        outside_count += usize::from(figure.excess() > 0.0);
        if worst.as_ref().is_none_or(|worst| figure.excess() > worst.excess()) {
            worst = Some(figure);
        }
    }
    let worst = worst?;
    let Bounds { low, high } = worst.bounds;
    let outcome = outside(worst.measured, low, high, confidence);
    Some(Verdict {
        coefficient,
        rule: Rule::Requirement,
        state: outcome.state,
        value: Some(worst.measured.value),
        limit: worst.nearest_bound(),
        sd: worst.measured.sd,
        probability: outcome.probability,
        // The figures of one record: a second campaign is judged by its own.
        confirmed: false,
        finding: Finding::Requirement {
            figure: worst.name,
            low,
            high,
            others_outside: outside_count.saturating_sub(1),
        },
    })
}
