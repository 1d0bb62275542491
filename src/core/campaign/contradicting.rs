//! Single dwells whose outputs contradict all others: a wrong sign, a fault value of a logger, a row in another's place.

use nalgebra::DVector;

use super::{Campaign, CampaignNote, TestKind};
use crate::core::calibrate::design::{self, Design};
use crate::core::model::Term;
use crate::core::numerics::least_squares::{Factor, Fit};
use crate::core::numerics::median::median_of;
use crate::core::numerics::normal::SD_OF_MEDIAN;
use crate::core::units::EARTH_RATE_DEG_H;

/// A gyro that reads more than this beside the others' model in single dwells has not measured them, arcsec/s.
const LEAST: f64 = EARTH_RATE_DEG_H;

/// And more than this many times the scatter of all dwells.
const TIMES_SCATTER: f64 = 30.0;

/// Up to this share, such dwells are single ones; of more, nobody knows which are right.
const SINGLE: f64 = 0.2;

/// Fits by which the sum of absolute residuals comes near its least.
const ROUNDS: usize = 30;

/// Dwells whose outputs are further from model (6) than [`LEAST`] and [`TIMES_SCATTER`], where it is fitted by least
/// absolute deviations (E. J. Schlossmacher, J. Am. Stat. Assoc. 68, 1973, 857: weights 1/|r|, again and again), which
/// a few wrong dwells hardly move.
pub(super) fn contradicting(campaign: &Campaign) -> Option<CampaignNote> {
    if campaign.test != TestKind::Imu {
        return None;
    }
    let mut off = vec![0.0_f64; campaign.dwells.len()];
    for j in (0..campaign.gyros.len()).filter(|j| !campaign.is_silent(*j)) {
        for (worst, off) in off.iter_mut().zip(far_off(campaign, j)?) {
            *worst = worst.max(off);
        }
    }
    let dwells: Vec<usize> = (0..off.len()).filter(|&k| off[k] > 0.0).collect();
    let single = dwells.len() as f64 <= SINGLE * off.len() as f64;
    let most_arcsec_s = off.iter().copied().fold(0.0, f64::max);
    (single && !dwells.is_empty()).then_some(CampaignNote::OutputsContradict { dwells, most_arcsec_s })
}

/// By how much each output of gyro `j` is too far off, arcsec/s; zero where it is not. None where the dwells do not
/// determine the model.
fn far_off(campaign: &Campaign, j: usize) -> Option<Vec<f64>> {
    let (n, held) = (campaign.dwells.len(), campaign.gyros[j].known_e);
    let terms = campaign.gyros[j].fitted_terms(campaign.terms());
    if terms.is_empty() || !(held.is_some() || terms.contains(Term::Scale)) {
        return None;
    }
    let design = Design::new(&campaign.dwells, terms);
    let outputs = DVector::from_iterator(n, campaign.free_outputs(j));
    let scale = |fit: &Fit| match held {
        Some(e) => e.norm(),
        None => (&design.expand * &fit.estimate).rows(design::first_column(terms, Term::Scale), 3).norm(),
    };
    let factor = Factor::new(design.reduced.clone(), &vec![1.0; n]);
    let mut fit = factor.fit(&outputs);
    if fit.dof == 0 || fit.rank < design.reduced.ncols() {
        return None;
    }
    // Least squares spread what one dwell is off over the others: they show a part of it.
    if fit.residuals.amax() < 0.1 * LEAST * scale(&fit) {
        return Some(vec![0.0; n]);
    }
    for _ in 0..ROUNDS {
        let least = (1e-6 * fit.residuals.amax()).max(f64::MIN_POSITIVE);
        let sd: Vec<f64> = fit.residuals.iter().map(|r| r.abs().max(least).sqrt()).collect();
        fit = Factor::new(design.reduced.clone(), &sd).fit(&outputs);
    }
    let scatter = SD_OF_MEDIAN * median_of(fit.residuals.iter().map(|r| r.abs()))?;
    let scale = scale(&fit);
    let far = |r: &f64| if r.abs() > (LEAST * scale).max(TIMES_SCATTER * scatter) { r.abs() / scale } else { 0.0 };
    Some(fit.residuals.iter().map(far).collect())
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::core::campaign::made_for_tests::{self, name};
    use crate::core::campaign::{CampaignGyro, Dwell, Phase};
    use crate::core::mounting::Slot;

    const E: [[f64; 3]; 3] = [[1.7, 0.2, -0.4], [0.3, -1.9, 0.5], [-0.6, 0.4, 1.8]];

    /// Twelve dwells at rest and twenty-four turns, three skewed gyros that drift, noise of `deg_per_h`, far from
    /// normal.
    fn campaign(deg_per_h: f64, held: bool, change: impl Fn(usize, &mut Dwell)) -> Campaign {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let mut commanded: Vec<(Phase, Vector3<f64>, Vector3<f64>)> = Vec::new();
        for (k, axis) in axes.iter().enumerate() {
            for sign in [1.0, -1.0] {
                for next in [1, 2] {
                    commanded.push((Phase::Static, sign * axis, 13.0 * axes[(k + next) % 3] + sign * 7.5 * axis));
                }
                for rate in [3600.0, 7200.0, 18_000.0, 36_000.0] {
                    commanded.push((Phase::Rate, sign * axis, sign * rate * axis));
                }
            }
        }
        let dwells = commanded.iter().enumerate().map(|(k, (phase, f, w))| {
            let output = |j: usize| {
                let noise = deg_per_h * (1.0 + (1.7 * (3 * k + j) as f64 * (k + 2) as f64).sin()).powi(3) / 4.0;
                let e = Vector3::from(E[j]);
                e.dot(w) + 3.0 * f[j] - 1.5 * f[(j + 1) % 3] + 4.0 + e.norm() * noise
            };
            let outputs = (0..3).map(output).collect();
            let mut dwell = Dwell { phase: *phase, ..made_for_tests::dwell(k, *f, *w, outputs) };
            change(k, &mut dwell);
            dwell
        });
        let known_e = |j: usize| held.then(|| Vector3::from(E[j]));
        let gyro = |(j, slot): (usize, Slot)| CampaignGyro { slot, serial: name(slot.name()), known_e: known_e(j) };
        made_for_tests::campaign(Slot::ALL.into_iter().enumerate().map(gyro).collect(), dwells.collect())
    }

    fn named(campaign: &Campaign) -> Vec<usize> {
        match contradicting(campaign) {
            Some(CampaignNote::OutputsContradict { dwells, .. }) => dwells,
            other => {
                assert_eq!(other, None);
                Vec::new()
            }
        }
    }

    #[test]
    fn single_wrong_dwells_are_named_and_no_other() {
        let reverse = |dwell: &mut Dwell| dwell.output_pulse_s.iter_mut().for_each(|y| *y = -*y);
        for held in [false, true] {
            let fault_value = campaign(1e-3, held, |k, d| {
                if k == 7 {
                    d.output_pulse_s.fill(-9999.0)
                }
            });
            assert_eq!(named(&fault_value), [7]);
            let one_gyro = campaign(1e-3, held, |k, d| {
                if k == 0 {
                    d.output_pulse_s[1] *= 10.0
                }
            });
            assert_eq!(named(&one_gyro), [0]);
            let senses = campaign(1e-3, held, |k, d| {
                if [3, 10, 16, 22, 28, 34].contains(&k) {
                    reverse(d)
                }
            });
            assert_eq!(named(&senses), [3, 10, 16, 22, 28, 34]);
        }
    }

    #[test]
    fn noise_steps_and_a_campaign_that_is_wrong_as_a_whole_are_not_single_dwells() {
        for deg_per_h in [0.0, 1e-3, 20.0, 300.0] {
            assert_eq!(named(&campaign(deg_per_h, false, |_, _| ())), [0; 0], "{deg_per_h} deg/h");
        }
        let step = campaign(1e-3, false, |k, d| {
            if k > 31 {
                d.output_pulse_s[0] += 8.0
            }
        });
        assert_eq!(named(&step), [0; 0], "a step of 4 deg/h");
        let most = campaign(1e-3, false, |k, d| {
            if k % 3 == 0 {
                d.output_pulse_s.fill(-9999.0)
            }
        });
        assert_eq!(named(&most), [0; 0], "a third of the dwells");
    }
}
