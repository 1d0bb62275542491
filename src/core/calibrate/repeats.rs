//! Dwells that repeat one another: the same phase and the same commanded specific force and rate.

use crate::core::campaign::Dwell;

/// Commanded values closer than this are the same position: the rounding of files, far below any table step.
const SAME_FORCE_G0: f64 = 1e-6;
const SAME_RATE_ARCSEC_S: f64 = 1e-3;

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

fn same_position(a: &Dwell, b: &Dwell) -> bool {
    a.phase == b.phase
        && (a.specific_force_g0 - b.specific_force_g0).amax() <= SAME_FORCE_G0
        && (a.rate_arcsec_s - b.rate_arcsec_s).amax() <= SAME_RATE_ARCSEC_S
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

    pub fn plus(self, other: Self) -> Self {
        Self { chi2: self.chi2 + other.chi2, dof: self.dof + other.dof }
    }
}
