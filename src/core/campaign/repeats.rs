//! Dwells that repeat one another: the same phase and the same commanded specific force, rate and attitude. What
//! differs between them is noise, whatever the model: an unmodelled effect of the heading is none.

use crate::core::campaign::Dwell;

/// Commanded values closer than this are the same position: the rounding of files, far below any table step. Rates
/// are the same to this or to this share of them.
const SAME_FORCE_G0: f64 = 1e-6;
const SAME_RATE_ARCSEC_S: f64 = 1e-3;
const SAME_RATE_SHARE: f64 = 1e-6;
/// Elements of the attitude's matrix.
const SAME_ATTITUDE: f64 = 1e-6;

/// Groups of two or more dwells that repeat one another, as indices in time order, in the order of their first.
pub fn repeats(dwells: &[Dwell]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..dwells.len()).collect();
    order.sort_by(|&i, &j| {
        let key = |d: &Dwell| d.specific_force_g0.x;
        key(&dwells[i]).total_cmp(&key(&dwells[j])).then(i.cmp(&j))
    });
    // Members of a group lie within SAME_FORCE_G0 of its first in the sorted coordinate, so only the groups
    // opened that recently are compared.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut oldest_open = 0;
    for i in order {
        let x = dwells[i].specific_force_g0.x;
        while groups.get(oldest_open).is_some_and(|g| x - dwells[g[0]].specific_force_g0.x > SAME_FORCE_G0) {
            oldest_open += 1;
        }
        match groups[oldest_open..].iter_mut().find(|g| same_position(&dwells[g[0]], &dwells[i])) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    groups.retain(|group| group.len() > 1);
    for group in &mut groups {
        group.sort_unstable();
    }
    groups.sort_unstable();
    groups
}

/// How many different positions there are.
pub(super) fn positions(dwells: &[Dwell]) -> usize {
    dwells.len() - repeats(dwells).iter().map(|group| group.len() - 1).sum::<usize>()
}

fn same_position(a: &Dwell, b: &Dwell) -> bool {
    let turned = match (&a.attitude, &b.attitude) {
        (Some(p), Some(q)) => (p.matrix() - q.matrix()).amax() > SAME_ATTITUDE,
        _ => false,
    };
    let rate_room = SAME_RATE_ARCSEC_S.max(SAME_RATE_SHARE * a.rate_arcsec_s.amax());
    a.phase == b.phase
        && !turned
        && (a.specific_force_g0 - b.specific_force_g0).amax() <= SAME_FORCE_G0
        && (a.rate_arcsec_s - b.rate_arcsec_s).amax() <= rate_room
}

/// Spread of repeated dwells about their own weighted means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PureError {
    /// Sum of ((y - mean)/sd)^2 over all groups.
    pub chi2: f64,
    /// Dwells in groups less the number of groups.
    pub dof: usize,
}

impl PureError {
    /// `y` and `sd` by dwell.
    pub fn of(groups: &[Vec<usize>], y: impl Fn(usize) -> f64, sd: impl Fn(usize) -> f64) -> Self {
        let mut sum = Self::default();
        for group in groups {
            let weight = |&i: &usize| sd(i).powi(-2);
            let total: f64 = group.iter().map(weight).sum();
            let mean = group.iter().map(|i| weight(i) * y(*i)).sum::<f64>() / total;
            sum.chi2 += group.iter().map(|i| weight(i) * (y(*i) - mean).powi(2)).sum::<f64>();
            sum.dof += group.len() - 1;
        }
        sum
    }

    /// Both together: sums of squares and degrees of freedom add.
    pub fn plus(self, other: Self) -> Self {
        Self { chi2: self.chi2 + other.chi2, dof: self.dof + other.dof }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::campaign::{Phase, made_for_tests};
    use nalgebra::Vector3;

    fn dwell(phase: Phase, force: Vector3<f64>, rate: Vector3<f64>) -> Dwell {
        Dwell { phase, ..made_for_tests::dwell(0, force, rate, vec![0.0]) }
    }

    #[test]
    fn positions_are_told_apart_by_every_command_and_by_the_phase() {
        // Sixteen positions, far apart in the coordinate that is sorted or not at all; each four times, off by
        // rounding or by more.
        let mut dwells = Vec::new();
        for turn in 0..4 {
            for at in 0..16 {
                let base = Vector3::new([0.0, 0.5, -0.5, 1.0][at / 4], 0.1 * (at % 4) as f64, 0.3);
                let axis = [Vector3::x(), Vector3::y(), Vector3::z()][at % 3];
                // The second is rounded, the third beyond rounding in force, the fourth in rate or phase.
                let force = base + axis * [0.0, 0.9e-6, 3.1e-6, 0.0][turn];
                let rate = axis * [0.0, 0.9e-3, 0.0, if at < 8 { 3.1e-3 } else { 0.0 }][turn];
                let phase = if turn == 3 && at >= 8 { Phase::Rate } else { Phase::Static };
                dwells.push(dwell(phase, force, rate));
            }
        }
        let pairs: Vec<Vec<usize>> = (0..16).map(|at| vec![at, at + 16]).collect();
        assert_eq!(repeats(&dwells), pairs);
    }

    #[test]
    fn the_spread_of_repeats_is_about_their_weighted_means() {
        // (y - y')^2/(s^2 + s'^2) of a pair: 4/(1 + 3); three of 1, 2, 6 with sd 2 about 3: (4 + 1 + 9)/4.
        let (y, sd) = ([5.0, 1.0, 7.0, 2.0, 99.0, 6.0], [1.0, 2.0, 3.0_f64.sqrt(), 2.0, 1.0, 2.0]);
        let found = PureError::of(&[vec![0, 2], vec![1, 3, 5]], |k| y[k], |k| sd[k]);
        assert!((found.chi2 - 4.5).abs() < 1e-12 && found.dof == 3, "{found:?}");
        let twice = found.plus(PureError { chi2: 2.0, dof: 1 });
        assert!((twice.chi2 - 6.5).abs() < 1e-12 && twice.dof == 4);
    }
}
