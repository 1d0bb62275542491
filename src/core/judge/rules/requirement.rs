//! `requirement`: E and G against what is required of them, as in the requirement columns of the paper's Tables 3 and 4.

use nalgebra::Vector3;

use crate::core::judge::decide::{Conformity, outside};
use crate::core::judge::limits::{Bounds, Limit, Requirement};
use crate::core::judge::rule::MOST_FIGURES;
use crate::core::judge::{Coefficient, Finding, Measured, Rule, State, Verdict};

/// A figure of the record, its name, and what it must lie between.
struct NamedFigure {
    name: &'static str,
    measured: Measured,
    bounds: Bounds,
    outcome: Conformity,
}

impl NamedFigure {
    /// How far outside (positive) or inside (negative) it lies, in widths of its bounds.
    fn excess(&self) -> f64 {
        let Bounds { low, high, .. } = self.bounds;
        (low - self.measured.value).max(self.measured.value - high) / (high - low)
    }

    fn nearest_bound(&self) -> f64 {
        let Bounds { low, high, .. } = self.bounds;
        if self.measured.value - low < high - self.measured.value { low } else { high }
    }

    /// Larger for what lies outside with more certainty, and then for what lies farther out.
    fn rank(&self) -> (f64, f64) {
        let certainty = match (self.outcome.probability, self.outcome.state) {
            (Some(probability), _) => probability,
            (None, State::Exceeded) => 1.0,
            (None, _) => 0.0,
        };
        (certainty, self.excess())
    }
}

/// One verdict on E (|E| and its three components) and one on G, each about the figure that lies outside with the
/// largest probability; the value is that figure and the limit its nearest bound. The finding names every figure that
/// lies outside. None where nothing is required.
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
    let norm = ("|E|", Measured { value: e.norm(), sd: e_sd.map(|sd| sd.component_mul(e).norm() / e.norm()) });
    let of_g = (0..3).map(|axis| (G_NAMES[axis], component(g, g_sd, axis), required.g[axis]));
    [
        judged(Coefficient::E, of_e.chain([(norm.0, norm.1, required.e_norm)]), confidence),
        judged(Coefficient::G, of_g, confidence),
    ]
}

fn judged(
    coefficient: Coefficient,
    figures: impl Iterator<Item = (&'static str, Measured, Option<Bounds>)>,
    confidence: f64,
) -> Option<Verdict> {
    let required = figures.filter_map(|(name, measured, bounds)| {
        let bounds = bounds?;
        Some(NamedFigure { name, measured, bounds, outcome: outside(measured, bounds.low, bounds.high, confidence) })
    });
    let all: Vec<NamedFigure> = required.collect();
    let worst = all.iter().max_by(|a, b| {
        let (a, b) = (a.rank(), b.rank());
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    })?;
    let mut others = [None; MOST_FIGURES - 1];
    let outside = all.iter().filter(|figure| figure.name != worst.name && figure.excess() > 0.0);
    others.iter_mut().zip(outside).for_each(|(other, figure)| *other = Some(figure.name));
    let limit = Limit { value: worst.nearest_bound(), from: worst.bounds.from };
    let finding = Finding::Requirement { figure: worst.name, low: worst.bounds.low, high: worst.bounds.high, others };
    // Never confirmed: the figures are one record's, and a second campaign is judged by its own.
    let undecided = Verdict::undecided(coefficient, Rule::Requirement, limit, finding);
    Some(worst.outcome.of(worst.measured, undecided))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::LimitKey;

    fn figure(value: f64, low: f64, high: f64) -> NamedFigure {
        let measured = Measured::exact(value);
        let bounds = Bounds { low, high, from: LimitKey::BUDGET };
        NamedFigure { name: "E_x", measured, bounds, outcome: outside(measured, low, high, 0.95) }
    }

    #[test]
    fn the_excess_is_how_far_a_figure_is_beyond_its_nearest_bound_in_widths() {
        assert_eq!(figure(2.5, 2.0, 3.0).excess(), -0.5);
        assert_eq!(figure(4.0, 2.0, 3.0).excess(), 1.0);
        assert_eq!(figure(1.5, 2.0, 3.0).excess(), 0.5);
        assert_eq!(figure(4.0, -1.0, 3.0).excess(), 0.25);
        assert_eq!(figure(-2.0, -1.0, 3.0).excess(), 0.25);
    }

    #[test]
    fn the_verdict_is_about_the_figure_that_is_farthest_out_in_widths() {
        let narrow = Bounds { low: 1.0, high: 1.1, from: LimitKey::BUDGET };
        let wide = Bounds { low: 1.0, high: 3.0, from: LimitKey::BUDGET };
        let g = [("G_x", Measured::exact(3.5), Some(wide)), ("G_y", Measured::exact(1.2), Some(narrow))];
        let inside = ("G_z", Measured::exact(2.0), Some(wide));
        let verdict = judged(Coefficient::G, g.into_iter().chain([inside]), 0.95).unwrap();
        let Finding::Requirement { figure, others, .. } = verdict.finding else { panic!("{verdict}") };
        assert_eq!((figure, others), ("G_y", [Some("G_x"), None, None]));
    }
}
