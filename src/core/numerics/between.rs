//! Values of one quantity that differ by more than their standard deviations say: whether (Cochran, Biometrics 10, 1954),
//! by how much (DerSimonian and Laird, Controlled Clinical Trials 7, 1986), and what that does to their mean.
//!
//! x_i = mu + u_g z_g + c_i + e_i: e_i of the stated standard deviation, z_g of unit variance common to a group of values
//! (u: what a station does to all of its campaigns), c_i of standard deviation tau, which nobody knows. V(tau) is the
//! covariance diag(sd^2 + tau^2) + u u' by groups. Of few values the likelihood of tau is wide: the mean is a mixture over
//! tau, whose prior is what like quantities show (the same tau with probability [`ALIKE`]).

use std::collections::BTreeMap;
use std::f64::consts::FRAC_2_PI;

use super::bisection::bisect;
use super::normal::normal_cdf;
use super::tails::chi2_tail;

/// Chance below which values differ by more than their standard deviations.
const BEYOND_NOISE: f64 = 0.05;
/// Prior probability that a quantity's tau is that of the others of its set, and a set's that of the other sets.
const ALIKE: [f64; 2] = [0.8, 0.7];
/// Sets that a quantity belongs to: its gyro's, and its coefficient's.
const GROUPINGS: usize = 2;
/// Prior probability that nothing differs; else tau is half-Cauchy of the scale of the standard deviations.
const NONE: f64 = 0.25;
/// Values of tau, of the scale: from this one on, each as much larger.
const FIRST: f64 = 0.05;
const STEP: f64 = 1.25;
/// Half a 95 % interval over the standard deviation, of a normal distribution.
const OF_95: f64 = 1.959_964;

/// One value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    pub value: f64,
    /// Of this value alone.
    pub sd: f64,
    /// Of what all values of the group share.
    pub shared_sd: f64,
    pub group: usize,
}

/// Sums over values of one or several quantities, each with a mean of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scatter {
    /// Q = (x - mean)' V(0)^-1 (x - mean) about the weighted mean.
    pub chi2: f64,
    pub dof: usize,
    /// dQ/d(tau^2) in expectation: the trace of V^-1 - V^-1 1 1' V^-1/(1' V^-1 1).
    weight: f64,
}

impl Observation {
    /// A value that shares nothing with others; `sd` in its unit.
    pub fn independent(value: f64, sd: f64) -> Self {
        Self { value, sd, shared_sd: 0.0, group: 0 }
    }
}

impl Scatter {
    /// Of one quantity: two values at least.
    pub fn of(values: &[Observation]) -> Option<Self> {
        let dof = values.len().checked_sub(1).filter(|dof| *dof > 0)?;
        let at = Weighted::of(values, 0.0);
        Some(Self { chi2: at.chi2, dof, weight: at.trace })
    }

    /// Both together: Q, degrees of freedom and weights add.
    pub fn plus(self, other: Self) -> Self {
        Self { chi2: self.chi2 + other.chi2, dof: self.dof + other.dof, weight: self.weight + other.weight }
    }

    /// P(chi-square >= Q) if the standard deviations hold.
    pub fn p_value(&self) -> Option<f64> {
        chi2_tail(self.chi2, self.dof)
    }

    /// Whether p < 0.05.
    pub fn is_beyond(&self) -> bool {
        self.p_value().is_some_and(|p| p < BEYOND_NOISE)
    }

    /// tau, the standard deviation beside those that are stated: zero where Q is within chance.
    pub fn beyond(&self) -> f64 {
        if self.is_beyond() { ((self.chi2 - self.dof as f64) / self.weight).max(0.0).sqrt() } else { 0.0 }
    }
}

/// Whether one of so many quantities that were tested is told to differ: its p, corrected (Bonferroni), is below 0.05.
pub fn differs(p: f64, tested: usize) -> bool {
    p * (tested as f64) < BEYOND_NOISE
}

/// A weighted mean and its standard deviation: half of its 95 % interval over 1.96.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    pub value: f64,
    pub sd: f64,
}

/// One quantity: two values at least, and the sets in which others may scatter alike, one of each grouping.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    pub sets: [usize; GROUPINGS],
    pub values: Vec<Observation>,
}

/// The means of quantities that may scatter alike. As stated where Q of all together is within chance and that of the
/// quantity as well.
pub fn means(all: &[Quantity]) -> Vec<Mean> {
    let scatters: Vec<Scatter> = all.iter().map(|one| Scatter::of(&one.values).unwrap_or_default()).collect();
    let together = scatters.iter().copied().fold(Scatter::default(), Scatter::plus);
    let is_beyond = |scatter: &Scatter| together.is_beyond() || scatter.is_beyond();
    let mixtures = if scatters.iter().any(is_beyond) { mixtures(all) } else { Vec::new() };
    let mean = |(i, one): (usize, &Quantity)| match mixtures.get(i).filter(|_| is_beyond(&scatters[i])) {
        Some(mixture) => mixture.mean(),
        None => {
            let Weighted { mean, variance, .. } = Weighted::of(&one.values, 0.0);
            Mean { value: mean, sd: variance.sqrt() }
        }
    };
    all.iter().enumerate().map(mean).collect()
}

/// What a value of tau makes of the values of one quantity.
#[derive(Debug, Clone, Copy)]
struct Weighted {
    mean: f64,
    variance: f64,
    chi2: f64,
    trace: f64,
    /// Restricted: -(ln|V| + ln(1' V^-1 1) + Q)/2.
    log_likelihood: f64,
}

impl Weighted {
    /// V^-1 by groups: W - W u u' W/(1 + u' W u), W = diag(1/(sd^2 + tau^2)) (Sherman and Morrison).
    fn of(values: &[Observation], tau: f64) -> Self {
        #[derive(Clone, Copy, Default)]
        struct Group {
            uu: f64,
            u1: f64,
            ux: f64,
        }
        let weight = |v: &Observation| 1.0 / (v.sd.powi(2) + tau.powi(2));
        let mut groups = vec![Group::default(); values.iter().map(|v| v.group + 1).max().unwrap_or(0)];
        let (mut s11, mut s1x, mut sxx, mut log_det) = (0.0, 0.0, 0.0, 0.0);
        // From the first value on: the squares of what is common to all would drown what differs.
        let origin = values.first().map_or(0.0, |v| v.value);
        for v in values {
            let (w, x, group) = (weight(v), v.value - origin, &mut groups[v.group]);
            (s11, s1x, sxx, log_det) = (s11 + w, s1x + w * x, sxx + w * x * x, log_det - w.ln());
            group.uu += w * v.shared_sd.powi(2);
            group.u1 += w * v.shared_sd;
            group.ux += w * v.shared_sd * x;
        }
        for Group { uu, u1, ux } in &groups {
            let by = 1.0 + uu;
            (s11, s1x, sxx, log_det) = (s11 - u1 * u1 / by, s1x - u1 * ux / by, sxx - ux * ux / by, log_det + by.ln());
        }
        let trace = |v: &Observation| {
            let (w, group) = (weight(v), groups[v.group]);
            let (own, row) = (w * v.shared_sd, w - w * v.shared_sd * group.u1 / (1.0 + group.uu));
            w - own * own / (1.0 + group.uu) - row * row / s11
        };
        let chi2 = (sxx - s1x * s1x / s11).max(0.0);
        Self {
            mean: origin + s1x / s11,
            variance: 1.0 / s11,
            chi2,
            trace: values.iter().map(trace).sum(),
            log_likelihood: -0.5 * (log_det + s11.ln() + chi2),
        }
    }
}

/// Weighted means of one quantity over values of tau, with their probabilities.
struct Mixture(Vec<(f64, Weighted)>);

impl Mixture {
    fn mean(&self) -> Mean {
        let value = self.0.iter().map(|(p, at)| p * at.mean).sum();
        let within = |half: f64| -> f64 {
            let share = |at: &Weighted| {
                let z = |end: f64| normal_cdf((end - at.mean) / at.variance.sqrt());
                z(value + half) - z(value - half)
            };
            self.0.iter().map(|(p, at)| p * share(at)).sum()
        };
        let mut most = 1.0;
        while within(most) < 0.95 && most < f64::MAX.sqrt() {
            most *= 2.0;
        }
        let (_, half) = bisect(0.0, most, 40, |half| within(half) < 0.95);
        Mean { value, sd: half / OF_95 }
    }
}

/// The mixture of every quantity.
fn mixtures(all: &[Quantity]) -> Vec<Mixture> {
    let mut sds: Vec<f64> = all.iter().flat_map(|one| &one.values).map(|v| v.sd).collect();
    sds.sort_by(f64::total_cmp);
    let scale = sds[sds.len() / 2];
    let range = |one: &Quantity| {
        let ends =
            one.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v.value), b.max(v.value)]);
        ends[1] - ends[0]
    };
    let widest = all.iter().map(range).fold(100.0 * scale, f64::max) * 3.0;
    let taus: Vec<f64> = std::iter::once(0.0)
        .chain(std::iter::successors(Some(FIRST * scale), |tau| Some(tau * STEP)).take_while(|tau| *tau < widest))
        .collect();
    let prior = prior(&taus, scale);
    let of_taus = |one: &Quantity| taus.iter().map(|tau| Weighted::of(&one.values, *tau)).collect();
    let weighted: Vec<Vec<Weighted>> = all.iter().map(of_taus).collect();
    let likelihoods: Vec<Vec<f64>> = weighted.iter().map(|at| likelihood(at)).collect();
    let groupings: [Grouping; GROUPINGS] = std::array::from_fn(|by| Grouping::of(all, by, &likelihoods, &prior));
    let evidence: f64 = groupings.iter().map(|grouping| grouping.evidence).sum();
    let mixture = |(i, at): (usize, Vec<Weighted>)| {
        let before = |k: usize| -> f64 { groupings.iter().map(|g| g.evidence / evidence * g.before[i][k]).sum() };
        let after = normalised(likelihoods[i].iter().enumerate().map(|(k, l)| before(k) * l).collect());
        Mixture(after.into_iter().zip(at).collect())
    };
    weighted.into_iter().enumerate().map(mixture).collect()
}

/// What quantities say of one another's tau where those of a set are alike.
struct Grouping {
    /// Probability of all values, up to what all groupings share.
    evidence: f64,
    /// Of every quantity: probabilities of the values of tau, by all others.
    before: Vec<Vec<f64>>,
}

impl Grouping {
    fn of(all: &[Quantity], by: usize, likelihoods: &[Vec<f64>], prior: &[f64]) -> Self {
        let mut sets: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        all.iter().enumerate().for_each(|(i, one)| sets.entry(one.sets[by]).or_default().push(i));
        let members = |set: &Vec<usize>, but: usize| -> Vec<&Vec<f64>> {
            set.iter().filter(|i| **i != but).map(|i| &likelihoods[*i]).collect()
        };
        let told: BTreeMap<usize, Vec<f64>> =
            sets.iter().map(|(set, of)| (*set, said(members(of, usize::MAX), ALIKE[0], prior))).collect();
        let alike = |others: Vec<f64>, share: f64, before: &[f64]| {
            let of_others = normalised(others.iter().zip(before).map(|(l, p)| l * p).collect());
            of_others.iter().zip(prior).map(|(a, b)| share * a + (1.0 - share) * b).collect::<Vec<f64>>()
        };
        let before = |(i, one): (usize, &Quantity)| {
            let set = one.sets[by];
            let other_sets = told.iter().filter(|(other, _)| **other != set).map(|(_, l)| l).collect();
            let of_set = alike(said(other_sets, ALIKE[1], prior), ALIKE[1], prior);
            alike(said(members(&sets[&set], i), ALIKE[0], prior), ALIKE[0], &of_set)
        };
        let before = all.iter().enumerate().map(before).collect();
        let of_all = said(told.values().collect(), ALIKE[1], prior);
        Self { evidence: of_all.iter().zip(prior).map(|(l, p)| l * p).sum(), before }
    }
}

/// Probabilities of the values of tau, each of what lies between its neighbours' midpoints.
fn prior(taus: &[f64], scale: f64) -> Vec<f64> {
    let below = |tau: f64| FRAC_2_PI * (tau / scale).atan();
    let end = |k: usize| match (taus.get(k), taus.get(k + 1)) {
        (Some(0.0), Some(next)) => below(next / STEP.sqrt()),
        (Some(tau), Some(next)) => below((tau * next).sqrt()),
        _ => 1.0,
    };
    let of = |k: usize| match k {
        0 => NONE + (1.0 - NONE) * end(0),
        k => (1.0 - NONE) * (end(k) - end(k - 1)),
    };
    (0..taus.len()).map(of).collect()
}

/// Of every tau, the largest 1.
fn likelihood(at: &[Weighted]) -> Vec<f64> {
    let top = at.iter().map(|at| at.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
    at.iter().map(|at| (at.log_likelihood - top).exp()).collect()
}

/// What several say of a tau that each has with probability `alike`, and else one of its own.
fn said(all: Vec<&Vec<f64>>, alike: f64, prior: &[f64]) -> Vec<f64> {
    all.into_iter().fold(vec![1.0; prior.len()], |product, one| {
        let own: f64 = one.iter().zip(prior).map(|(l, p)| l * p).sum();
        product.iter().zip(one).map(|(a, l)| a * (alike * l + (1.0 - alike) * own)).collect()
    })
}

fn normalised(mut all: Vec<f64>) -> Vec<f64> {
    let total: f64 = all.iter().sum();
    all.iter_mut().for_each(|one| *one /= total);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn of(values: &[(f64, f64)]) -> Vec<Observation> {
        values.iter().map(|(value, sd)| Observation::independent(*value, *sd)).collect()
    }

    #[test]
    fn what_a_group_shares_is_no_scatter_among_its_values() {
        // x = 1, 2, 4 of sd 1, of which all share 5: about their mean 7/3 they scatter by Q = 14/3.
        let shared = [1.0, 2.0, 4.0].map(|value| Observation { value, sd: 1.0, shared_sd: 5.0, group: 0 });
        let scatter = Scatter::of(&shared).unwrap();
        assert!((scatter.chi2 - 14.0 / 3.0).abs() < 1e-9 && (scatter.weight - 2.0).abs() < 1e-9, "{scatter:?}");
        let mean = Weighted::of(&shared, 0.0);
        assert!((mean.mean - 7.0 / 3.0).abs() < 1e-9 && (mean.variance - (25.0 + 1.0 / 3.0)).abs() < 1e-9, "{mean:?}");
    }

    #[test]
    fn groups_are_weighed_as_their_covariance_is_inverted() {
        let all = [(1.0, 1.0, 2.0, 0), (2.5, 0.5, 1.5, 0), (0.3, 2.0, 1.0, 1), (1.7, 1.2, 0.4, 1), (2.2, 0.9, 0.0, 2)]
            .map(|(value, sd, shared_sd, group)| Observation { value, sd, shared_sd, group });
        let tau = 0.7;
        let covariance = nalgebra::DMatrix::from_fn(5, 5, |i, j| {
            let (a, b) = (&all[i], &all[j]);
            let own = if i == j { a.sd.powi(2) + tau * tau } else { 0.0 };
            own + if a.group == b.group { a.shared_sd * b.shared_sd } else { 0.0 }
        });
        let inverse = covariance.clone().cholesky().unwrap().inverse();
        let (x, ones) = (nalgebra::DVector::from_fn(5, |i, _| all[i].value), nalgebra::DVector::repeat(5, 1.0));
        let s11 = ones.dot(&(&inverse * &ones));
        let mean = ones.dot(&(&inverse * &x)) / s11;
        let residual = &x - &ones * mean;
        let chi2 = residual.dot(&(&inverse * &residual));
        let projected = &inverse - &inverse * &ones * ones.transpose() * &inverse / s11;
        let found = Weighted::of(&all, tau);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-10 * b.abs().max(1.0);
        assert!(close(found.mean, mean) && close(found.variance, 1.0 / s11) && close(found.chi2, chi2), "{found:?}");
        assert!(close(found.trace, projected.trace()), "{found:?}");
        let likelihood = -0.5 * (covariance.determinant().ln() + s11.ln() + chi2);
        assert!(close(found.log_likelihood, likelihood), "{found:?}");
    }

    #[test]
    fn of_many_that_are_tested_one_differs_by_chance_in_a_twentieth() {
        let mut rng = ChaCha8Rng::seed_from_u64(20_261_201);
        let mut normal = || (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
        let mut of_a_set = || {
            let quantities: Vec<f64> = (0..15)
                .map(|_| {
                    let values: Vec<_> = (0..3).map(|_| Observation::independent(normal(), 1.0)).collect();
                    Scatter::of(&values).and_then(|scatter| scatter.p_value()).unwrap()
                })
                .collect();
            quantities.iter().any(|p| differs(*p, quantities.len()))
        };
        let told = (0..1_000).filter(|_| of_a_set()).count();
        assert!((25..75).contains(&told), "{told} of 1,000 sets of which nothing differs");
    }

    #[test]
    fn values_within_chance_have_the_mean_of_their_weights() {
        let found = means(&[Quantity { sets: [0, 0], values: of(&[(1.0, 1.0), (2.0, 2.0)]) }]);
        let expected = Mean { value: 1.2, sd: 0.8_f64.sqrt() };
        assert!((found[0].value - expected.value).abs() < 1e-12 && (found[0].sd - expected.sd).abs() < 1e-12);
    }

    /// The share of 95 % intervals that hold the mean, of three gyros with three coefficients each; the values of some
    /// scatter by `tau`, and those are counted.
    fn coverage(campaigns: usize, tau: f64, scatters: fn([usize; 2]) -> bool, seed: u64) -> f64 {
        const FLEETS: usize = 60;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || (0..12).map(|_| rng.random_range(0.0..1.0)).sum::<f64>() - 6.0;
        let (mut held, mut all) = (0, 0);
        for _ in 0..FLEETS {
            let mut quantity = |sets: [usize; 2]| {
                let sd = if scatters(sets) { tau.hypot(1.0) } else { 1.0 };
                Quantity {
                    sets,
                    values: (0..campaigns).map(|_| Observation::independent(normal() * sd, 1.0)).collect(),
                }
            };
            let quantities: Vec<Quantity> = (0..9).map(|k| quantity([k / 3, k % 3])).collect();
            let found = means(&quantities);
            let counted = quantities.iter().zip(&found).filter(|(one, _)| scatters(one.sets));
            all += counted.clone().count();
            held += counted.filter(|(_, mean)| mean.value.abs() < OF_95 * mean.sd).count();
        }
        held as f64 / all as f64
    }

    #[test]
    fn the_sd_of_a_mean_covers_what_few_values_do_not_tell() {
        let [all, one_gyro, one_coefficient]: [fn([usize; 2]) -> bool; 3] =
            [|_| true, |sets| sets[0] == 0, |sets| sets[1] == 0];
        for (campaigns, tau, scatters, bounds) in [
            (2, 0.0, all, 0.92..0.99),
            (2, 2.0, all, 0.90..0.98),
            (2, 20.0, all, 0.90..0.98),
            (3, 6.0, all, 0.91..0.98),
            (5, 2.0, all, 0.91..0.98),
            (10, 6.0, all, 0.92..0.98),
            (2, 20.0, one_gyro, 0.83..0.98),
            (3, 6.0, one_gyro, 0.86..0.98),
            (2, 20.0, one_coefficient, 0.83..0.98),
            (3, 6.0, one_coefficient, 0.86..0.98),
        ] {
            let found = coverage(campaigns, tau, scatters, 20_261_130);
            assert!(bounds.contains(&found), "{campaigns} campaigns, tau {tau}: {found}");
        }
    }
}
