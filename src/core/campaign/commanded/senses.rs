//! Whether a turning table and the Earth show a gyro the same input axis.
//!
//! Static dwells give E from the Earth's rate, turning ones from the table's. Where a station reversed or exchanged
//! axes of the turning rates alone, w' = M w with a signed permutation M, and the fit of the turning dwells finds
//! E' = M E: every such M is tried, and M = 1 must leave the least sum over the gyros of |E - M^T E'|^2. Where a gyro's
//! E' lies along its E and is of another length, its outputs were written in two units.

use nalgebra::{DVector, Matrix3, Vector3};

use super::transform::RATE_UNITS;
use super::{AffectedDwells, CommandFinding, MistakeKind, Symptom, Vectors};
use crate::core::calibrate::design::Design;
use crate::core::campaign::{Campaign, Phase};
use crate::core::model::{Term, Terms};
use crate::core::mounting::Slot;
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

/// ln of the ratio of both lengths of one gyro's E from which on its scale is another: no effect makes it so.
const ONE_SCALE: f64 = 0.4;

/// How many times its variance the square of E must be there, and how near both directions must be, rad.
const SCALE_SEEN: f64 = 100.0;
const SAME_AXIS: f64 = 0.3;

/// Most causes that are named beside one another.
const MOST_CAUSES: usize = 3;

/// E of each gyro (pulse/arcsec) from static and from turning dwells.
struct Senses {
    gyros: Vec<SensedAxes>,
    /// Axes that both determine.
    axes: [bool; 3],
}

/// E of one gyro.
struct SensedAxes {
    slot: Slot,
    still: Vector3<f64>,
    turning: Vector3<f64>,
    /// Sum of the variances of both along the axes that both determine.
    variance: f64,
}

impl SensedAxes {
    /// ln(|E'|/|E|).
    fn log_ratio(&self) -> f64 {
        (self.turning.norm() / self.still.norm()).ln()
    }

    /// Whether E' is E with another length, far beyond noise.
    fn is_of_another_scale(&self) -> bool {
        let seen = self.still.norm_squared() > SCALE_SEEN * self.variance;
        seen && self.still.angle(&self.turning) < SAME_AXIS && self.log_ratio().abs() > ONE_SCALE
    }
}

/// How the terms beside E are fitted.
#[derive(Clone, Copy, PartialEq)]
enum OtherTerms {
    /// To both kinds of dwells: they are those of one gyro.
    Shared,
    /// To each kind: outputs in two units have two of each.
    Apart,
}

impl Senses {
    fn of(campaign: &Campaign, other_terms: OtherTerms) -> Option<Self> {
        let n = campaign.dwells.len();
        let turns = |k: usize| campaign.dwells[k].phase == Phase::Rate;
        if !(0..n).any(turns) || (0..n).all(turns) {
            return None;
        }
        let others = Design::new(&campaign.dwells, Terms::of(&[Term::Bias, Term::GLinear, Term::GSquared])).reduced;
        let terms = others.ncols();
        let first = if other_terms == OtherTerms::Apart { 2 * terms } else { terms };
        let mut design = others.resize_horizontally(first + 6, 0.0);
        for (k, dwell) in campaign.dwells.iter().enumerate() {
            let place = first + if turns(k) { 3 } else { 0 };
            design.view_mut((k, place), (1, 3)).copy_from(&dwell.rate_arcsec_s.transpose());
            if other_terms == OtherTerms::Apart && turns(k) {
                (0..terms).for_each(|term| design.swap((k, term), (k, terms + term)));
            }
        }
        let mut senses = Self { gyros: Vec::new(), axes: [true; 3] };
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
            senses.gyros.push(SensedAxes {
                slot: campaign.gyros[j].slot,
                still: fit.estimate.fixed_rows::<3>(first).into_owned(),
                turning: fit.estimate.fixed_rows::<3>(first + 3).into_owned(),
                variance: scale * along.sum::<f64>(),
            });
        }
        (senses.axes.contains(&true) && !senses.gyros.is_empty()).then_some(senses)
    }

    /// Sum over gyros and determined axes of |E - M^T E'|^2.
    fn left(&self, m: &Matrix3<f64>) -> f64 {
        let apart = |gyro: &SensedAxes| {
            let apart = gyro.still - m.tr_mul(&gyro.turning);
            (0..3).filter(|i| self.axes[*i]).map(|i| apart[i] * apart[i]).sum::<f64>()
        };
        self.gyros.iter().map(apart).sum()
    }

    /// Sum over the gyros of |E|^2.
    fn still_squared(&self) -> f64 {
        self.gyros.iter().map(|gyro| gyro.still.norm_squared()).sum()
    }

    fn variance(&self) -> f64 {
        self.gyros.iter().map(|gyro| gyro.variance).sum()
    }

    /// The unit of the turning rates, where the E of all gyros differ by it.
    fn unit(&self) -> Option<MistakeKind> {
        let still = self.still_squared();
        let turning: f64 = self.gyros.iter().map(|gyro| gyro.turning.norm_squared()).sum();
        let ratio = 0.5 * (turning / still).ln();
        let seen = self.axes == [true; 3] && still > TIMES_VARIANCE * self.variance();
        if !seen || ratio.abs() < ONE_UNIT {
            return None;
        }
        let (unit, size) = RATE_UNITS.into_iter().find(|(_, size)| (ratio - size.ln()).abs() < UNIT_ROOM)?;
        let is_of_all = self.gyros.iter().all(|gyro| (gyro.log_ratio() - size.ln()).abs() < 2.0 * UNIT_ROOM);
        is_of_all.then_some(MistakeKind::RateUnit { unit, part: AffectedDwells::Turning })
    }

    /// The gyros whose outputs were written in two units, and how many times as strongly they answer the turning table.
    fn scale(&self) -> Option<(MistakeKind, f64)> {
        let other: Vec<&SensedAxes> = self.gyros.iter().filter(|gyro| gyro.is_of_another_scale()).collect();
        let of = Slot::ALL.map(|slot| other.iter().any(|gyro| gyro.slot == slot));
        let ratio = other.iter().map(|gyro| gyro.log_ratio()).max_by(|a, b| a.abs().total_cmp(&b.abs()))?.exp();
        Some((MistakeKind::OutputScale { of }, ratio))
    }

    /// What was done to the axes of the turning rates, where E says that something was.
    fn causes(&self) -> Option<Vec<MistakeKind>> {
        let as_sent = self.left(&Matrix3::identity());
        let tried: Vec<(Matrix3<f64>, f64)> =
            signed_permutations().filter(|m| self.concerns(m)).map(|m| (m, self.left(&m))).collect();
        let least = tried.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
        let is_clear = as_sent > CLEARLY * least && as_sent - least > TIMES_VARIANCE * self.variance();
        let by_seating = SEATED_ANEW * SEATED_ANEW * self.still_squared();
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

/// Turning rates whose axes or unit, or whose outputs' unit, are not those of the static ones.
pub(super) fn senses(campaign: &Campaign) -> Option<CommandFinding> {
    let senses = Senses::of(campaign, OtherTerms::Shared)?;
    let apart = Senses::of(campaign, OtherTerms::Apart).filter(|apart| apart.axes == [true; 3]);
    let found = |symptom: Symptom, causes: Vec<MistakeKind>, measured: f64| {
        let turning = campaign.dwells.iter().enumerate().filter(|(_, d)| d.phase == Phase::Rate);
        let dwells = turning.map(|(k, _)| (k, measured)).collect();
        Some(CommandFinding::of_all(symptom, causes, dwells, true))
    };
    let angle = senses.gyros.iter().map(|gyro| gyro.still.angle(&gyro.turning).to_degrees()).fold(0.0, f64::max);
    if let Some(unit) = apart.as_ref().unwrap_or(&senses).unit() {
        return found(Symptom::Senses, vec![unit], angle);
    }
    if let Some((scale, ratio)) = apart.and_then(|apart| apart.scale()) {
        return found(Symptom::Scale, vec![scale], ratio);
    }
    found(Symptom::Senses, senses.causes()?, angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of one gyro or several.
    fn senses_of(gyros: impl IntoIterator<Item = (Vector3<f64>, Vector3<f64>)>, axes: [bool; 3]) -> Senses {
        let of = |(slot, (still, turning))| SensedAxes { slot, still, turning, variance: 1e-9 };
        Senses { gyros: Slot::ALL.into_iter().zip(gyros).map(of).collect(), axes }
    }

    #[test]
    fn outputs_in_two_units_are_told_gyro_by_gyro_and_from_rates_in_another_unit() {
        let e = [Vector3::new(0.8, 0.1, -0.6), Vector3::new(-0.2, 1.0, 0.3), Vector3::new(0.1, 0.2, 1.0)];
        let with = |scales: [f64; 3]| senses_of(e.iter().zip(scales).map(|(e, scale)| (*e, scale * e)), [true; 3]);
        for scale in [10.0, 0.1, 2.0, 1.0 / 180.0] {
            let (mistake, ratio) = with([scale, 1.0, 1.0]).scale().unwrap();
            assert_eq!(mistake, MistakeKind::OutputScale { of: [true, false, false] });
            assert!((ratio / scale - 1.0).abs() < 1e-12);
            assert_eq!(with([scale; 3]).scale().unwrap().0, MistakeKind::OutputScale { of: [true; 3] });
        }
        assert_eq!(with([1.0, 1.3, 0.8]).scale(), None);
        // Root mean square over the gyros: 3.6, a thousandth of a degree in arcsec.
        assert_eq!(with([6.08, 1.0, 1.0]).unit(), None);
        assert!(matches!(with([3.6; 3]).unit(), Some(MistakeKind::RateUnit { unit: "mdeg/s", .. })));
    }

    #[test]
    fn each_signed_permutation_is_tried_once_and_undone() {
        let all: Vec<Matrix3<f64>> = signed_permutations().collect();
        assert_eq!(all.len(), 48);
        assert!(all.iter().enumerate().all(|(i, m)| !all[..i].contains(m) && m * m.transpose() == Matrix3::identity()));
        let e = [Vector3::new(0.8, 0.1, -0.6), Vector3::new(-0.2, 1.0, 0.3)];
        for m in all {
            let senses = senses_of(e.map(|e| (e, m * e)), [true; 3]);
            assert!(senses.left(&m) < 1e-18);
            assert_eq!(senses.causes().is_some(), m != Matrix3::identity(), "{m}");
        }
    }

    #[test]
    fn an_axis_that_only_one_phase_shows_says_nothing() {
        let e = Vector3::new(0.8, 0.1, -0.6);
        let reversed = Vector3::new(0.8, 0.1, 0.6);
        assert_eq!(senses_of([(e, reversed)], [true, true, false]).causes(), None);
    }

    #[test]
    fn one_gyro_that_was_seated_anew_accuses_no_axis() {
        let still = Vector3::new(1.3, 0.001, -0.002);
        for turning in [Vector3::new(1.3, 0.001, 0.002), Vector3::new(1.3, -0.002, 0.001)] {
            assert_eq!(senses_of([(still, turning)], [true; 3]).causes(), None, "{turning}");
        }
        let reversed = senses_of([(still, Vector3::new(-1.3, 0.001, -0.002))], [true; 3]);
        let causes = vec![MistakeKind::AxisReversed { axis: 0, of: Vectors::Rate }, MistakeKind::RateReversed];
        assert_eq!(reversed.causes(), Some(causes));
    }
}
