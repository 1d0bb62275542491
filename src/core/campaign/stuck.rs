//! Gyros that did not answer: an output that is exactly the same in dwells in which it cannot be.

use std::ops::Range;

use nalgebra::DVector;

use super::repeats::positions;
use super::{Campaign, TestKind};
use crate::core::calibrate::design::Design;
use crate::core::message::{Message, text};
use crate::core::mounting::Slot;
use crate::core::numerics::least_squares::Factor;
use crate::message;

/// An output that is the same in fewer positions may be so by chance, or by coarse counts.
const POSITIONS: usize = 5;

/// What the other dwells predict differs from a stuck output by more than so many standard deviations and a count.
const BEYOND_NOISE: f64 = 5.0;

/// And by more than this share of the range of outputs: rounding.
const ROUNDING: f64 = 1e-6;

/// Share of that range which is more than the noise of outputs that are told apart.
const NOISE: f64 = 1e-3;

/// The output of a gyro is exactly the same in these dwells on end, which command different outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct StuckOutput {
    pub slot: Slot,
    /// By index.
    pub dwells: Vec<usize>,
    pub pulse_s: f64,
}

impl StuckOutput {
    /// What is said of it.
    pub fn message(&self) -> Message {
        let (value, first) = (text(self.pulse_s), format_args!("/dwells/{}", self.dwells[0]));
        message!("output_stuck", slot = self.slot.name(), value, count = self.dwells.len(), first)
    }
}

/// Gyros of an IMU, by index, whose output is the same in every dwell: their E, D_I and D_S are of nothing.
pub fn constant(campaign: &Campaign) -> impl Iterator<Item = usize> {
    let many = campaign.test == TestKind::Imu && positions(&campaign.dwells) >= POSITIONS;
    (0..campaign.gyros.len()).filter(move |j| many && campaign.is_silent(*j))
}

/// Dwells on end in which the output (pulse/s) of a gyro is exactly the same, in [`POSITIONS`] positions or more, where
/// the model of its other dwells predicts something else. Coarse counts alone never do that.
pub fn stuck(campaign: &Campaign) -> Vec<StuckOutput> {
    let of_gyro = |j: usize| {
        let runs: Vec<Range<usize>> = runs(campaign, j);
        let is_stuck = is_stuck(campaign, j, &runs);
        let note = move |run: Range<usize>| StuckOutput {
            slot: campaign.gyros[j].slot,
            pulse_s: campaign.dwells[run.start].output_pulse_s[j],
            dwells: run.collect(),
        };
        runs.into_iter().zip(is_stuck).filter(|(_, is)| *is).map(move |(run, _)| note(run))
    };
    let gyros = (0..campaign.gyros.len()).filter(|_| campaign.test == TestKind::Imu);
    gyros.filter(|j| !campaign.is_silent(*j)).flat_map(of_gyro).collect()
}

fn runs(campaign: &Campaign, j: usize) -> Vec<Range<usize>> {
    let mut start = 0;
    let alike = campaign.dwells.chunk_by(|a, b| a.output_pulse_s[j] == b.output_pulse_s[j]).map(|run| {
        start += run.len();
        (start - run.len()..start, run)
    });
    alike.filter(|(_, run)| run.len() >= POSITIONS && positions(run) >= POSITIONS).map(|(range, _)| range).collect()
}

fn is_stuck(campaign: &Campaign, j: usize, runs: &[Range<usize>]) -> Vec<bool> {
    let none = vec![false; runs.len()];
    let terms = campaign.gyros[j].fitted_terms(campaign.terms());
    let others: Vec<usize> = (0..campaign.dwells.len()).filter(|k| !runs.iter().any(|run| run.contains(k))).collect();
    if runs.is_empty() || terms.is_empty() || others.is_empty() {
        return none;
    }
    let design = Design::new(&campaign.dwells, terms).reduced;
    let outputs = DVector::from_iterator(campaign.dwells.len(), campaign.free_outputs(j));
    let factor = Factor::new(design.select_rows(&others), &vec![1.0; others.len()]);
    let fit = factor.fit(&outputs.select_rows(&others));
    let (step, range) = step_and_range(campaign, j);
    // Where no residual tells the noise, it is below a part of the range, or a count hides it.
    let unknown = (NOISE * range).hypot(step);
    let variance = if fit.dof > 0 { fit.chi2 / fit.dof as f64 } else { unknown * unknown };
    let is_elsewhere = |k: usize| {
        let row = design.row(k).transpose();
        let sd = (variance * (1.0 + (factor.covariance() * &row).dot(&row))).sqrt();
        let off = (outputs[k] - row.dot(&fit.estimate)).abs();
        factor.determines(&row) && off > BEYOND_NOISE * sd + step + ROUNDING * range
    };
    runs.iter().map(|run| run.clone().any(is_elsewhere)).collect()
}

/// Least difference of two outputs, a count where those are coarse, and the largest.
fn step_and_range(campaign: &Campaign, j: usize) -> (f64, f64) {
    let mut sorted: Vec<f64> = campaign.dwells.iter().map(|d| d.output_pulse_s[j]).collect();
    sorted.sort_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    (steps.fold(f64::INFINITY, f64::min), sorted[sorted.len() - 1] - sorted[0])
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::core::campaign::made_for_tests::{self, name};
    use crate::core::campaign::{CampaignGyro, Dwell, Phase};
    use crate::core::mounting::Slot;

    /// 24 dwells at rest (twelve positions, twice) and 24 turns of up to `rate` arcsec/s; one gyro of `scale`
    /// pulse/arcsec and G of some `scale` pulse/(s g0), noise of `noise` pulse/s, counts of `count` pulses.
    fn campaign(scale: f64, rate: f64, noise: f64, count: f64) -> Campaign {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let position = |k: usize| -> (Phase, Vector3<f64>, Vector3<f64>) {
            let axis = if k.is_multiple_of(2) { 1.0 } else { -1.0 } * axes[k / 2 % 3];
            match k {
                0..24 => (Phase::Static, axis, 12.0 * axes[(k / 2 + 1 + k / 6 % 2) % 3] + 8.5 * axis),
                _ => (
                    Phase::Rate,
                    axis,
                    rate / (1 << (k / 6 % 4)) as f64 * if (k / 12).is_multiple_of(2) { 1.0 } else { -1.0 } * axis,
                ),
            }
        };
        let dwells = (0..48).map(|k| {
            let (phase, f, w) = position(k);
            let chance = (0..12).map(|i| (1.7 * (k + 3) as f64 * (i + 5) as f64 * (k + i) as f64).sin()).sum::<f64>()
                / 6.0_f64.sqrt();
            let sensed = w.x + 0.01 * w.y + 3.0 * f.x - 1.5 * f.y + 0.7 * f.z + 4.0;
            let output = scale * sensed + noise * chance;
            let output = if count > 0.0 { (output * 180.0 / count).round() * count / 180.0 } else { output };
            Dwell { phase, ..made_for_tests::dwell(k, f, w, vec![output]) }
        });
        let gyro = CampaignGyro { slot: Slot::G1, serial: name("A"), known_e: None };
        made_for_tests::campaign(vec![gyro], dwells.collect())
    }

    fn found(campaign: &Campaign) -> Vec<(usize, usize)> {
        let ends = |stuck: &StuckOutput| (stuck.dwells[0], stuck.dwells[stuck.dwells.len() - 1]);
        stuck(campaign).iter().map(ends).collect()
    }

    #[test]
    fn an_output_that_stands_still_is_named_from_where_to_where() {
        for (from, to) in [(30, 47), (20, 40), (0, 18), (12, 20)] {
            for count in [0.0, 10.0] {
                let mut stands = campaign(1.4, 7200.0, 1e-3, count);
                let value = stands.dwells[from].output_pulse_s[0];
                stands.dwells[from..=to].iter_mut().for_each(|d| d.output_pulse_s[0] = value);
                assert_eq!(found(&stands), [(from, to)], "{count}");
                assert_eq!(constant(&stands).count(), 0);
            }
        }
    }

    #[test]
    fn it_is_named_before_as_few_dwells_as_determine_the_model() {
        let of_dwells = |honest: &Campaign, places: &[usize]| Campaign {
            dwells: places.iter().map(|k| honest.dwells[*k].clone()).collect(),
            ..honest.clone()
        };
        // Six positions or seven, and a turn about each axis.
        let honest = campaign(1.4, 7200.0, 1e-3, 0.0);
        for last in [&[0, 1, 2, 3, 4, 5, 6, 24, 26, 28][..], &[0, 1, 2, 3, 4, 5, 24, 26, 28]] {
            let before: Vec<usize> = (0..48).filter(|k| !last.contains(k)).collect();
            let mut stands = of_dwells(&honest, &[&before, last].concat());
            let value = stands.dwells[0].output_pulse_s[0];
            stands.dwells[..before.len()].iter_mut().for_each(|d| d.output_pulse_s[0] = value);
            assert_eq!(found(&stands), [(0, before.len() - 1)], "{last:?}");
        }
        for scale in [1.4, 1e-2, 1e-4, 1e-6] {
            for count in [0.0, 1.0, 10.0, 100.0, 1e3] {
                let honest = campaign(scale, 7200.0, 1e-3, count);
                for from in 0..38 {
                    let part = of_dwells(&honest, &(from..48).collect::<Vec<_>>());
                    assert_eq!(found(&part), [], "{scale} {count} {from}");
                }
            }
        }
    }

    #[test]
    fn coarse_counts_a_dull_gyro_and_repeats_are_no_output_that_stands_still() {
        for scale in [1.4, 1e-2, 1e-4, 1e-6] {
            for count in [0.0, 1.0, 10.0, 100.0, 1e3] {
                for (rate, noise) in [(7200.0, 1e-3), (7200.0, 0.0), (20.0, 1e-3), (20.0, 0.1)] {
                    let honest = campaign(scale, rate, noise, count);
                    assert_eq!(found(&honest), [], "{scale} {count} {rate} {noise}");
                }
            }
        }
        let mut again = campaign(1.4, 7200.0, 0.0, 0.0);
        let first = again.dwells[0].clone();
        again.dwells[1..20].fill(first);
        assert_eq!(found(&again), []);
    }

    #[test]
    fn an_output_is_constant_where_positions_differ() {
        let mut dead = campaign(1.4, 7200.0, 1e-3, 0.0);
        dead.dwells.iter_mut().for_each(|d| d.output_pulse_s[0] = 12.5);
        assert_eq!(constant(&dead).collect::<Vec<_>>(), [0]);
        assert_eq!(found(&dead), []);
        dead.dwells.truncate(4);
        assert_eq!(constant(&dead).count(), 0);
    }
}
