//! Whether a turning table and the Earth show a gyro the same input axis.
//!
//! Static dwells give E from the Earth's rate, turning ones from the table's. Where a station reversed or exchanged
//! axes of the turning rates alone, w' = M w with a signed permutation M, and the fit of the turning dwells finds
//! E' = M E: every such M is tried, and M = 1 must leave the least sum over the gyros of |E - M^T E'|^2.

use nalgebra::{DVector, Matrix3, Vector3};

use super::transform::RATE_UNITS;
use super::{AffectedDwells, CommandFinding, MistakeKind, Symptom, Vectors};
use crate::core::calibrate::design::Design;
use crate::core::campaign::{Campaign, Phase};
use crate::core::model::{Term, Terms};
use crate::core::numerics::least_squares::Factor;

/// How many times its own variance a sum of squares must change by to mean anything.
const TIMES_VARIANCE: f64 = 25.0;

/// How many times fewer squares another M must leave.
const CLEARLY: f64 = 4.0;

/// An IMU that is seated anew between rest and rotation turns by less, rad. One gyro cannot tell that from an axis in
/// which it has next to nothing.
const SEATED_ANEW: f64 = std::f64::consts::PI / 180.0;

/// ln of the ratio of both lengths of E within which a unit explains it, and within which there is nothing to explain.
const UNIT_ROOM: f64 = 0.2;
const ONE_UNIT: f64 = std::f64::consts::LN_2;

/// Most causes that are named beside one another.
const MOST_CAUSES: usize = 3;

/// E of each gyro (pulse/arcsec) from static and from turning dwells, the other terms fitted to both.
struct Senses {
    still: Vec<Vector3<f64>>,
    turning: Vec<Vector3<f64>>,
    /// Sum of the variances of both along the axes that both determine.
    variance: f64,
    /// Axes that both determine.
    axes: [bool; 3],
}

impl Senses {
    fn of(campaign: &Campaign) -> Option<Self> {
        let n = campaign.dwells.len();
        let turns = |k: usize| campaign.dwells[k].phase == Phase::Rate;
        if !(0..n).any(turns) || (0..n).all(turns) {
            return None;
        }
        let others = Design::new(&campaign.dwells, Terms::of(&[Term::Bias, Term::GLinear, Term::GSquared])).reduced;
        let first = others.ncols();
        let mut design = others.resize_horizontally(first + 6, 0.0);
        for (k, dwell) in campaign.dwells.iter().enumerate() {
            let place = first + if turns(k) { 3 } else { 0 };
            design.view_mut((k, place), (1, 3)).copy_from(&dwell.rate_arcsec_s.transpose());
        }
        let mut senses = Self { still: Vec::new(), turning: Vec::new(), variance: 0.0, axes: [true; 3] };
        let mut known: Option<(Vec<f64>, Factor)> = None;
        let is_asked = |j: &usize| campaign.gyros[*j].known_e.is_none() && !campaign.is_silent(*j);
        for j in (0..campaign.gyros.len()).filter(is_asked) {
            let sd = campaign.errors_of(j).unwrap_or_else(|| vec![1.0; n]);
            if known.as_ref().is_none_or(|(used, _)| *used != sd) {
                known = Some((sd.clone(), Factor::new(design.clone(), &sd)));
            }
            let factor = &known.as_ref()?.1;
            let fit = factor.fit(&DVector::from_fn(n, |k, _| campaign.dwells[k].output_pulse_s[j]));
            if fit.dof == 0 {
                return None;
            }
            let determined = |i: usize| factor.determines_parameter(first + i);
            (0..3).for_each(|i| senses.axes[i] &= determined(i) && determined(3 + i));
            let scale = fit.chi2 / fit.dof as f64;
            let along = (0..6).filter(|i| senses.axes[i % 3]).map(|i| fit.covariance[(first + i, first + i)]);
            senses.variance += scale * along.sum::<f64>();
            senses.still.push(fit.estimate.fixed_rows::<3>(first).into_owned());
            senses.turning.push(fit.estimate.fixed_rows::<3>(first + 3).into_owned());
        }
        (senses.axes.contains(&true) && !senses.still.is_empty()).then_some(senses)
    }

    /// Sum over gyros and determined axes of |E - M^T E'|^2.
    fn left(&self, m: &Matrix3<f64>) -> f64 {
        let apart = |(e, turning): (&Vector3<f64>, &Vector3<f64>)| {
            let apart = e - m.tr_mul(turning);
            (0..3).filter(|i| self.axes[*i]).map(|i| apart[i] * apart[i]).sum::<f64>()
        };
        self.still.iter().zip(&self.turning).map(apart).sum()
    }

    /// The unit of the turning rates, where E differs by it.
    fn unit(&self) -> Option<MistakeKind> {
        let squares = |all: &[Vector3<f64>]| all.iter().map(Vector3::norm_squared).sum::<f64>();
        let (still, turning) = (squares(&self.still), squares(&self.turning));
        let ratio = 0.5 * (turning / still).ln();
        let seen = self.axes == [true; 3] && still > TIMES_VARIANCE * self.variance;
        if !seen || ratio.abs() < ONE_UNIT {
            return None;
        }
        let unit = RATE_UNITS.iter().find(|(_, size)| (ratio - size.ln()).abs() < UNIT_ROOM)?;
        Some(MistakeKind::RateUnit { unit: unit.0, part: AffectedDwells::Turning })
    }

    /// What was done to the turning rates, where E says that something was.
    fn causes(&self) -> Option<Vec<MistakeKind>> {
        if let Some(unit) = self.unit() {
            return Some(vec![unit]);
        }
        let as_sent = self.left(&Matrix3::identity());
        let tried: Vec<(Matrix3<f64>, f64)> =
            signed_permutations().filter(|m| self.concerns(m)).map(|m| (m, self.left(&m))).collect();
        let least = tried.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
        let is_clear = as_sent > CLEARLY * least && as_sent - least > TIMES_VARIANCE * self.variance;
        let by_seating = SEATED_ANEW * SEATED_ANEW * self.still.iter().map(Vector3::norm_squared).sum::<f64>();
        if !is_clear || as_sent < by_seating {
            return None;
        }
        let as_good = |left: f64| left < least + 0.1 * (as_sent - least);
        let mut causes: Vec<MistakeKind> =
            tried.iter().filter(|(_, left)| as_good(*left)).filter_map(|(m, _)| cause(m)).collect();
        causes.truncate(MOST_CAUSES);
        Some(causes)
    }

    /// Whether M leaves alone what is not determined.
    fn concerns(&self, m: &Matrix3<f64>) -> bool {
        (0..3).all(|i| self.axes[i] || m[(i, i)] == 1.0)
    }
}

/// The 48 of them.
fn signed_permutations() -> impl Iterator<Item = Matrix3<f64>> {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let sign = |signs: usize, i: usize| if signs >> i & 1 == 1 { -1.0 } else { 1.0 };
    ORDERS.into_iter().flat_map(move |order| {
        (0..8).map(move |signs| Matrix3::from_fn(|i, k| if order[i] == k { sign(signs, i) } else { 0.0 }))
    })
}

fn cause(m: &Matrix3<f64>) -> Option<MistakeKind> {
    let of = Vectors::Rate;
    if *m == -Matrix3::identity() {
        return Some(MistakeKind::RateReversed);
    }
    let moved: Vec<usize> = (0..3).filter(|&i| m[(i, i)] != 1.0).collect();
    match moved[..] {
        [axis] => Some(MistakeKind::AxisReversed { axis, of }),
        [a, b] if m[(a, b)] == 1.0 && m[(b, a)] == 1.0 => Some(MistakeKind::AxesExchanged { axes: (a, b), of }),
        _ => None,
    }
}

/// Turning rates whose axes or unit are not those of the static ones.
pub(super) fn senses(campaign: &Campaign) -> Option<CommandFinding> {
    let senses = Senses::of(campaign)?;
    let causes = senses.causes()?;
    let turning = campaign.dwells.iter().enumerate().filter(|(_, d)| d.phase == Phase::Rate);
    let angle = |(e, turning): (&Vector3<f64>, &Vector3<f64>)| e.angle(turning).to_degrees();
    let apart = senses.still.iter().zip(&senses.turning).map(angle).fold(0.0, f64::max);
    Some(CommandFinding::of_all(Symptom::Senses, causes, turning.map(|(k, _)| (k, apart)).collect(), true))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_signed_permutation_is_tried_once_and_undone() {
        let all: Vec<Matrix3<f64>> = signed_permutations().collect();
        assert_eq!(all.len(), 48);
        assert!(all.iter().enumerate().all(|(i, m)| !all[..i].contains(m) && m * m.transpose() == Matrix3::identity()));
        let e = [Vector3::new(0.8, 0.1, -0.6), Vector3::new(-0.2, 1.0, 0.3)];
        for m in all {
            let turning = e.iter().map(|e| m * e).collect();
            let senses = Senses { still: e.to_vec(), turning, variance: 1e-9, axes: [true; 3] };
            assert!(senses.left(&m) < 1e-18);
            assert_eq!(senses.causes().is_some(), m != Matrix3::identity(), "{m}");
        }
    }

    #[test]
    fn an_axis_that_only_one_phase_shows_says_nothing() {
        let e = Vector3::new(0.8, 0.1, -0.6);
        let reversed = Vector3::new(0.8, 0.1, 0.6);
        let axes = [true, true, false];
        let senses = Senses { still: vec![e], turning: vec![reversed], variance: 1e-9, axes };
        assert_eq!(senses.causes(), None);
    }

    #[test]
    fn one_gyro_that_was_seated_anew_accuses_no_axis() {
        let still = vec![Vector3::new(1.3, 0.001, -0.002)];
        for turning in [Vector3::new(1.3, 0.001, 0.002), Vector3::new(1.3, -0.002, 0.001)] {
            let senses = Senses { still: still.clone(), turning: vec![turning], variance: 1e-9, axes: [true; 3] };
            assert_eq!(senses.causes(), None, "{turning}");
        }
        let reversed =
            Senses { still, turning: vec![Vector3::new(-1.3, 0.001, -0.002)], variance: 1e-9, axes: [true; 3] };
        let causes = vec![MistakeKind::AxisReversed { axis: 0, of: Vectors::Rate }, MistakeKind::RateReversed];
        assert_eq!(reversed.causes(), Some(causes));
    }
}
