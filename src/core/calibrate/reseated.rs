//! Whether the input axes of all gyros turned as one between campaigns: an IMU that was taken off and seated anew.
//!
//! The input axes of a campaign against those of the first are i' = R i, R the rotation by theta. Gauss and Newton:
//! what is left, t.(i' - R i) along two axes t across R i, changes by -(R i x t).dtheta; its covariance is that of both
//! directions. Seated anew it is where theta = 0 leaves too much (chi-square of three degrees of freedom), and the
//! rotation does not.

use nalgebra::{Matrix2x3, Matrix3, Rotation3, Vector2, Vector3};

use super::outcome::Outcome;
use super::repeats_between::output_axis_drift;
use crate::core::campaign::Campaign;
use crate::core::mounting::Slot;
use crate::core::numerics::between::{Observation, Scatter};
use crate::core::numerics::tails::chi2_tail;

/// Chance of what one seat leaves below which there were two, and of what a rotation leaves below which it is none.
const CHANCE: f64 = 1e-3;

/// Chance below which a coefficient differs between campaigns.
const DIFFERS: f64 = 0.05;

/// Rounds of Gauss and Newton: each squares the error, and rotations are of arc-minutes.
const ROUNDS: usize = 4;

/// One campaign against the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Reseated {
    /// Its place among the campaigns.
    pub campaign: usize,
    /// Rotation about the body axes, rad, and its standard deviations.
    pub rotation: Vector3<f64>,
    pub sd: Vector3<f64>,
    /// Gyros whose D_O differs between these two campaigns (p < 0.05), and does not once the rotation is undone.
    pub explains: Vec<Slot>,
}

/// Direction of a gyro's input axis and its covariance.
struct InputAxis {
    direction: Vector3<f64>,
    covariance: Matrix3<f64>,
}

/// The campaigns in which the input axes of two gyros or more are turned together against the first: i' = R i, with R
/// (rad, body axes) and its standard deviations. Campaigns of which nothing can be told are left out.
pub fn reseated(fitted: &[(&Campaign, &Outcome)]) -> Vec<Reseated> {
    let Some((first, rest)) = fitted.split_first() else { return Vec::new() };
    rest.iter().enumerate().filter_map(|(i, other)| one(i + 1, *first, *other)).collect()
}

fn one(campaign: usize, first: (&Campaign, &Outcome), other: (&Campaign, &Outcome)) -> Option<Reseated> {
    let slots: Vec<Slot> = first.0.gyros.iter().map(|gyro| gyro.slot).collect();
    let both = |slot: &Slot| Some((input_axis(first.1, *slot)?, input_axis(other.1, *slot)?));
    let pairs: Vec<(InputAxis, InputAxis)> = slots.iter().filter_map(both).collect();
    let dof = (2 * pairs.len()).checked_sub(3).filter(|dof| *dof > 0)?;
    let mut rotation = Vector3::zeros();
    let as_one_seat = Left::of(&pairs, &rotation)?;
    let mut left = as_one_seat.clone();
    for _ in 0..ROUNDS {
        rotation += left.normal.cholesky()?.solve(&left.side);
        left = Left::of(&pairs, &rotation)?;
    }
    let turned = chi2_tail(as_one_seat.chi2 - left.chi2, 3).is_some_and(|chance| chance < CHANCE);
    let together = chi2_tail(left.chi2, dof).is_some_and(|chance| chance >= CHANCE);
    if !turned || !together {
        return None;
    }
    let covariance = left.normal.cholesky()?.inverse();
    let differs = |pair: [Observation; 2]| Scatter::of(&pair)?.p_value().map(|p| p < DIFFERS);
    let explains = |slot: &Slot| {
        let drift = |(of, outcome), back: Vector3<f64>| output_axis_drift(of, outcome, *slot, &back);
        let still = Vector3::zeros();
        let (before, after, undone) = (drift(first, still)?, drift(other, still)?, drift(other, -rotation)?);
        // Undone by a rotation that is known to so much: D_O changes by D_S for every rad about the input axis.
        let input = input_axis(first.1, *slot)?.direction;
        let by_rotation = after.d_s * input.dot(&(covariance * input)).sqrt();
        let sd = undone.d_o.sd.hypot(by_rotation);
        let undone = Observation { sd, ..undone.d_o };
        (differs([before.d_o, after.d_o])? && !differs([before.d_o, undone])?).then_some(*slot)
    };
    Some(Reseated {
        campaign,
        rotation,
        sd: covariance.diagonal().map(f64::sqrt),
        explains: slots.iter().filter_map(explains).collect(),
    })
}

/// None where E is held or its noise unknown.
fn input_axis(outcome: &Outcome, slot: Slot) -> Option<InputAxis> {
    let Outcome::Imu { calibration, separations, .. } = outcome else { return None };
    let (gyro, separation) = calibration.gyros.iter().zip(separations).find(|(gyro, _)| gyro.slot == slot)?;
    separation.as_ref().ok()?;
    let (e, covariance) = (gyro.e()?, gyro.covariance_eg()?);
    let covariance = covariance.fixed_view::<3, 3>(0, 0) / e.norm_squared();
    (covariance.trace() > 0.0).then(|| InputAxis { direction: e.normalize(), covariance })
}

/// What a rotation leaves between the axes.
#[derive(Clone)]
struct Left {
    chi2: f64,
    normal: Matrix3<f64>,
    side: Vector3<f64>,
}

impl Left {
    fn of(pairs: &[(InputAxis, InputAxis)], rotation: &Vector3<f64>) -> Option<Self> {
        let turn = Rotation3::new(*rotation);
        let mut all = Self { chi2: 0.0, normal: Matrix3::zeros(), side: Vector3::zeros() };
        for (first, other) in pairs {
            let from = turn * first.direction;
            let across = across(&from);
            let covariance = turn * first.covariance * turn.inverse() + other.covariance;
            let noise = (across * covariance * across.transpose()).cholesky()?;
            let off: Vector2<f64> = across * (other.direction - from);
            let by = Matrix2x3::from_rows(&[0, 1].map(|row| from.cross(&across.row(row).transpose()).transpose()));
            let weighed = noise.solve(&off);
            all.chi2 += off.dot(&weighed);
            all.side += by.tr_mul(&weighed);
            all.normal += by.tr_mul(&noise.solve(&by));
        }
        Some(all)
    }
}

/// Two unit vectors across this one, as rows.
fn across(direction: &Vector3<f64>) -> Matrix2x3<f64> {
    let least = direction.iamin();
    let first = direction.cross(&Vector3::ith(least, 1.0)).normalize();
    Matrix2x3::from_rows(&[first.transpose(), direction.cross(&first).transpose()])
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;
    use crate::core::calibrate::outcome::evaluate;
    use crate::core::campaign::made_for_tests::{self, name};
    use crate::core::campaign::{CampaignGyro, Dwell, Phase};
    use crate::core::record::Plausibility;
    use crate::core::units::radians_from_arcsec;

    /// Three gyros along x, y and z of D_I 2 and D_S 3; the input axis of each is turned by its own rotation.
    fn campaign(turns: [Vector3<f64>; 3], seed: u64) -> Campaign {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let up = |k: usize| axes[k % 3] * if k % 6 < 3 { 1.0 } else { -1.0 };
        let dwell = |k: usize| {
            let (force, rate) = (up(k), up(k) * [0.0, 0.0, 600.0, -600.0, 1800.0, -1800.0][k / 6 % 6]);
            let output = |j: usize| {
                let turn = Rotation3::new(turns[j]);
                let (input, spin) = (turn * axes[j], turn * axes[(j + 1) % 3]);
                let noise: f64 = rng.sample(StandardNormal);
                1.4 * (input.dot(&rate) + (2.0 * input + 3.0 * spin).dot(&force)) + 1e-3 * noise
            };
            Dwell {
                phase: if rate.norm() > 20.0 { Phase::Rate } else { Phase::Static },
                output_sem_pulse_s: Some(vec![1e-3; 3]),
                ..made_for_tests::dwell(k, force, rate, (0..3).map(output).collect())
            }
        };
        let slots = [Slot::G1, Slot::G2, Slot::G3].into_iter().zip(["A", "B", "C"]);
        let gyros = slots.map(|(slot, serial)| CampaignGyro { slot, serial: name(serial), known_e: None });
        made_for_tests::campaign(gyros.collect(), (0..72).map(dwell).collect())
    }

    #[test]
    fn a_rotation_that_all_input_axes_share_is_found_and_one_gyro_that_turned_is_none() {
        let compared = |first: [Vector3<f64>; 3], other: [Vector3<f64>; 3]| {
            let campaigns = [campaign(first, 71), campaign(other, 72)];
            let outcomes =
                campaigns.each_ref().map(|one| evaluate(one, &Plausibility::default()).expect("it is fitted"));
            let pairs: Vec<_> = campaigns.iter().zip(&outcomes).collect();
            reseated(&pairs)
        };
        let zero = Vector3::zeros();
        let turn = Vector3::new(120.0, -60.0, 200.0).map(radians_from_arcsec);
        assert_eq!(compared([zero; 3], [zero; 3]), []);
        let found = compared([zero; 3], [turn; 3]);
        let [one] = found.as_slice() else { panic!("{found:?}") };
        let off = (one.rotation - turn).component_div(&one.sd);
        assert!(one.campaign == 1 && off.amax() < 4.0 && one.sd.amax() < 0.01 * turn.norm(), "{one:?}");
        // D_O follows D_S by the turn about the input axis: 3 x 120, 60 and 200 arcsec, beyond the noise in each.
        assert_eq!(one.explains, [Slot::G1, Slot::G2, Slot::G3]);
        assert_eq!(compared([zero; 3], [zero, zero, turn]), [], "a gyro that turned in its IMU");
    }
}
