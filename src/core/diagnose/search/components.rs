//! What the residuals go with, without a form: one variance component for each thing that a dwell has.
//!
//! Each says which dwells ought to err alike, by a kernel K that is constant in deg/h. With W the factor of K (K = B B')
//! whitened and off all that is fitted, scaled to a mean eigenvalue of one, y the residual and k what the stated noise
//! is worth,
//!
//! ```text
//! ln B = ln mean over phi of exp[-1/2 ln det(1 + phi W'W) - (nu+k)/2 ln((k + y'(1 + phi W W')^-1 y)/(k + y'y))]
//! ```
//!
//! and gyros add up as ln((1 + B)/2). A name that one of them leads clearly has the wrong form; what no name explains is
//! described by them (variance components, Searle, Casella and McCulloch 1992).

use nalgebra::{DMatrix, Rotation3, Vector3};

use super::projections::State;
use crate::core::campaign::Phase;
use crate::core::diagnose::diagnosis::Variable;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::Setting;
use crate::core::numerics::log_sum::LogSum;
use crate::core::numerics::pivoted_cholesky::pivoted_cholesky;

/// Observations of unit noise that the stated errors are worth.
const K: f64 = 4.0;

/// Power of a component over the noise, phi.
const POWERS: [f64; 11] = [0.1, 0.316, 1.0, 3.16, 10.0, 31.6, 100.0, 316.0, 1e3, 3.16e3, 1e4];

/// Largest rank that is kept of a kernel, and share of its trace that may be left out.
const MOST: usize = 24;
const LEFT_OUT: f64 = 1e-3;

/// One kernel, by its factor: dwells x rank.
pub(crate) struct Component {
    pub variable: Variable,
    /// Whether a name falls by it: not by what is an entry of the catalogue itself.
    pub competes: bool,
    /// Of how many it is one that are as likely together as any other alone.
    among: usize,
    factor: DMatrix<f64>,
}

/// Width of a course in time that another variable takes, over the span.
const SLOW: f64 = 0.35;

/// Angle within which directions and attitudes are alike, rad.
const ALIKE: f64 = 0.5;

/// Of single dwells: their share, how much larger their variance is, and the others' over that of all.
const SHARES: [f64; 3] = [0.02, 0.06, 0.2];
const SPREADS: [f64; 3] = [9.0, 90.0, 900.0];
const SCALES: [f64; 6] = [0.02, 0.05, 0.1, 0.25, 0.5, 1.0];

/// Dwells' directions are the same within this angle, and rates within this share, rad.
const SAME: f64 = 1e-3;

/// Every component that a campaign can show.
pub(crate) fn components(s: &Setting) -> Vec<Component> {
    let mut found = Found { s, all: Vec::new() };
    of_a_field(&mut found);
    of_time(&mut found);
    of_temperature(&mut found);
    of_faces(&mut found);
    of_one_face(&mut found);
    if (0..s.dwells()).any(|k| turns(s, k)) {
        of_rate(&mut found);
        of_phases(&mut found);
    }
    of_orientation_before(&mut found);
    of_near_attitudes(&mut found);
    of_two_variables(&mut found);
    found.all
}

struct Found<'a> {
    s: &'a Setting,
    all: Vec<Component>,
}

impl Found<'_> {
    /// One by which names fall.
    fn add(&mut self, variable: Variable, like: impl Fn(usize, usize) -> f64) {
        self.component(variable, true, like);
    }

    fn component(&mut self, variable: Variable, competes: bool, like: impl Fn(usize, usize) -> f64) {
        let n = self.s.dwells();
        let factor = pivoted_cholesky(&DMatrix::from_fn(n, n, like), MOST, LEFT_OUT);
        if factor.ncols() > 0 {
            self.all.push(Component { variable, competes, among: 1, factor });
        }
    }
}

/// What a field along north makes of each body axis: `magnetic` itself.
fn of_a_field(found: &mut Found) {
    let s = found.s;
    let Some(c) = &s.nav_to_body else { return };
    let north = |k: usize| c[k] * Vector3::y();
    let still = |k: usize| both(s.phase[k] == Phase::Static);
    found.component(Variable::Heading, false, |a, b| still(a) * still(b) * north(a).dot(&north(b)));
}

fn of_time(found: &mut Found) {
    let (s, span) = (found.s, span(found.s));
    for share in [0.2, 0.06, 0.02] {
        found.add(Variable::Time, |a, b| gaussian((s.time[a] - s.time[b]) / (share * span)));
    }
    found.add(Variable::Time, |a, b| s.elapsed(a).min(s.elapsed(b)) / span);
}

fn of_temperature(found: &mut Found) {
    let s = found.s;
    let Some(t) = s.temperature.as_ref().filter(|t| t.iter().any(|x| *x != 0.0)) else { return };
    let rate: Vec<f64> = slope(&s.time, t);
    for share in [0.35, 0.12] {
        let width = (share * range(t)).max(f64::MIN_POSITIVE);
        found.add(Variable::Temperature, |a, b| gaussian((t[a] - t[b]) / width));
    }
    let width = (0.35 * range(&rate)).max(f64::MIN_POSITIVE);
    found.add(Variable::TemperatureRate, |a, b| gaussian((rate[a] - rate[b]) / width));
}

fn of_faces(found: &mut Found) {
    let s = found.s;
    found.add(Variable::UpDirection, |a, b| both(same_face(s, a, b)));
    let Some(c) = &s.nav_to_body else { return };
    let north: Vec<Vector3<f64>> = c.iter().map(|c| c * Vector3::y()).collect();
    let still = |a: usize, b: usize| !turns(s, a) && !turns(s, b);
    found.add(Variable::Heading, |a, b| both(still(a, b) && same_face(s, a, b)) * north[a].dot(&north[b]));
    found.component(Variable::Heading, false, |a, b| both(still(a, b)) * north[a].dot(&north[b]).powi(2));
}

/// A single face, at rest, of which there are several dwells, by itself and with time or temperature: something touches or
/// sticks there.
fn of_one_face(found: &mut Found) {
    let s = found.s;
    let on = |k: usize| (0..s.dwells()).filter(move |&other| !turns(s, other) && same_face(s, k, other));
    let firsts = (0..s.dwells()).filter(|&k| !turns(s, k) && on(k).next() == Some(k) && on(k).nth(1).is_some());
    let firsts: Vec<usize> = firsts.collect();
    let before = found.all.len();
    for &first in &firsts {
        let here = |k: usize| both(!turns(s, k) && same_face(s, k, first));
        found.component(Variable::UpDirection, false, |a, b| here(a) * here(b));
        let middle = |k: usize| here(k) * (s.elapsed(k) / span(s) - 0.5);
        found.component(Variable::TimeAndForce, false, |a, b| middle(a) * middle(b));
        if let Some(t) = &s.temperature {
            found.component(Variable::TemperatureAndForce, false, |a, b| here(a) * t[a] * here(b) * t[b]);
        }
    }
    found.all[before..].iter_mut().for_each(|component| component.among = firsts.len());
}

/// Of dwells at rate: their levels, axes and senses.
fn of_rate(found: &mut Found) {
    let s = found.s;
    let (speed, top) = speeds(s);
    let pair = |a: usize, b: usize| turns(s, a) && turns(s, b);
    // The Earth's own rate makes the two senses of one table rate differ by twice 15 arcsec/s.
    let alike = |a: usize, b: usize| (speed[a] - speed[b]).abs() < 35.0_f64.max(0.01 * speed[a]);
    let sense = |k: usize| s.rate[k].dot(&s.force[k]).signum();
    let signed = |k: usize| sense(k) * speed[k] / top;
    let one_axis = |a: usize, b: usize| s.force[a].cross(&s.force[b]).norm() < SAME;
    found.add(Variable::RateLevel, |a, b| both(pair(a, b) && alike(a, b)));
    found.add(Variable::RateLevel, |a, b| both(pair(a, b) && (s.rate[a] - s.rate[b]).norm() < 1e-3 * top));
    found.add(Variable::RateAxis, |a, b| both(pair(a, b) && same_face(s, a, b)) * speed[a] * speed[b] / top.powi(2));
    found.add(Variable::RateAxis, |a, b| both(pair(a, b) && one_axis(a, b)) * signed(a) * signed(b));
    found.add(Variable::RateAxis, |a, b| both(pair(a, b) && same_face(s, a, b)) * sense(a) * sense(b));
}

/// What rates before a dwell leave in it, and the two phases of a campaign.
fn of_phases(found: &mut Found) {
    let s = found.s;
    let (speed, top) = speeds(s);
    for lag in [1_usize, 3, 8] {
        let before: Vec<f64> = (0..s.dwells())
            .map(|k| (k.saturating_sub(lag)..k).map(|i| (speed[i] / top).powi(2)).sum::<f64>() / lag as f64)
            .collect();
        found.add(Variable::RateHistory, |a, b| before[a] * before[b]);
    }
    found.add(Variable::RateHistory, |a, b| {
        both(a > 0 && b > 0) * s.rate[a.max(1) - 1].dot(&s.rate[b.max(1) - 1]) / top.powi(2)
    });
    let phase = |k: usize| both(turns(s, k)) - 0.5;
    found.add(Variable::Phase, |a, b| phase(a) * phase(b));
}

/// Which attitude came before, or before that, and how long the present one was held.
fn of_orientation_before(found: &mut Found) {
    let (s, span) = (found.s, span(found.s));
    found.add(Variable::OrientationBefore, |a, b| both(a > 0 && b > 0 && same_face(s, a.max(1) - 1, b.max(1) - 1)));
    for lag in [1_usize, 2] {
        let before = |k: usize| k.checked_sub(lag).map_or_else(Vector3::zeros, |before| s.force[before]);
        found.component(Variable::OrientationBefore, false, |a, b| before(a).dot(&before(b)));
    }
    found.component(Variable::OrientationBefore, false, |a, b| {
        both(a > 1 && b > 1 && same_face(s, a.max(2) - 2, b.max(2) - 2))
    });
    let mut held_since = s.time[0];
    let age: Vec<f64> = (0..s.dwells())
        .map(|k| {
            if k > 0 && !same_face(s, k, k - 1) {
                held_since = s.time[k];
            }
            (s.time[k] - held_since) / span
        })
        .collect();
    found.add(Variable::OrientationAge, |a, b| age[a] * age[b]);
}

fn of_near_attitudes(found: &mut Found) {
    let s = found.s;
    found.add(Variable::UpDirection, |a, b| gaussian(s.force[a].angle(&s.force[b]) / ALIKE));
    let Some(c) = &s.nav_to_body else { return };
    let apart = |a: usize, b: usize| Rotation3::from_matrix_unchecked(c[a] * c[b].transpose()).angle();
    found.add(Variable::Heading, |a, b| both(!turns(s, a) && !turns(s, b)) * gaussian(apart(a, b) / ALIKE));
}

/// Two variables together: no name falls by them, for some are entries themselves.
fn of_two_variables(found: &mut Found) {
    let (s, span) = (found.s, span(found.s));
    let (speed, top) = speeds(s);
    let force = |a: usize, b: usize| s.force[a].dot(&s.force[b]);
    let rate = |a: usize, b: usize| s.rate[a].dot(&s.rate[b]) / top.powi(2);
    let middle = |k: usize| s.elapsed(k) / span - 0.5;
    let slow = |a: usize, b: usize| gaussian((s.time[a] - s.time[b]) / (SLOW * span));
    let level = |a: usize, b: usize| both(turns(s, a) && turns(s, b)) * speed[a] * speed[b] / top.powi(2);
    let face = |a: usize, b: usize| both(same_face(s, a, b));
    let still = |k: usize| both(!turns(s, k));
    let north: Option<Vec<Vector3<f64>>> =
        s.nav_to_body.as_ref().map(|c| (0..s.dwells()).map(|k| still(k) * (c[k] * Vector3::y())).collect());
    found.component(Variable::TimeAndForce, false, |a, b| middle(a) * middle(b) * force(a, b));
    found.component(Variable::TimeAndForce, false, |a, b| slow(a, b) * force(a, b));
    found.component(Variable::TimeAndRate, false, |a, b| middle(a) * middle(b) * rate(a, b));
    found.component(Variable::TimeAndRate, false, |a, b| slow(a, b) * rate(a, b));
    found.component(Variable::TimeAndForce, false, |a, b| middle(a) * middle(b) * face(a, b));
    found.component(Variable::TimeAndRate, false, |a, b| middle(a) * middle(b) * level(a, b));
    if let Some(north) = &north {
        let heading = |a: usize, b: usize| north[a].dot(&north[b]);
        found.component(Variable::TimeAndHeading, false, |a, b| middle(a) * middle(b) * heading(a, b));
        found.component(Variable::TimeAndHeading, false, |a, b| slow(a, b) * heading(a, b));
    }
    let Some(t) = &s.temperature else { return };
    found.component(Variable::TemperatureAndForce, false, |a, b| t[a] * t[b] * force(a, b));
    found.component(Variable::TemperatureAndRate, false, |a, b| t[a] * t[b] * rate(a, b));
    found.component(Variable::TemperatureAndForce, false, |a, b| t[a] * t[b] * face(a, b));
    found.component(Variable::TemperatureAndRate, false, |a, b| t[a] * t[b] * level(a, b));
    if let Some(north) = &north {
        found.component(Variable::TemperatureAndHeading, false, |a, b| t[a] * t[b] * north[a].dot(&north[b]));
    }
    found.component(Variable::TemperatureAndTime, false, |a, b| t[a] * t[b] * middle(a) * middle(b));
    found.component(Variable::Temperature, false, |a, b| (t[a] * t[b]).powi(2));
}

fn same_face(s: &Setting, a: usize, b: usize) -> bool {
    s.force[a].angle(&s.force[b]) < SAME
}

fn turns(s: &Setting, k: usize) -> bool {
    s.phase[k] == Phase::Rate
}

fn span(s: &Setting) -> f64 {
    s.span().max(f64::MIN_POSITIVE)
}

/// The dwells' rates, and the largest.
fn speeds(s: &Setting) -> (Vec<f64>, f64) {
    let speed: Vec<f64> = s.rate.iter().map(Vector3::norm).collect();
    let top = speed.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    (speed, top)
}

fn both(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

fn gaussian(apart: f64) -> f64 {
    (-0.5 * apart * apart).exp()
}

/// ln of the odds of a few dwells with a larger spread than the rest against one spread for all: a share e of dwells
/// with 1 + p times the variance, the mean over e, p and the scale, gyros added up as components are.
pub(crate) fn of_single_dwells(state: &State) -> f64 {
    let of_gyro = |residual: &Vec<f64>| {
        let n = residual.len() as f64;
        let variance = residual.iter().map(|r| r * r).sum::<f64>() / n;
        let mut sum = LogSum::default();
        for scale in SCALES.map(|share| share * variance) {
            for share in SHARES {
                for times in SPREADS {
                    let of = |r: f64, v: f64| (-0.5 * r * r / v).exp() / v.sqrt();
                    let mixed = |r: &f64| ((1.0 - share) * of(*r, scale) + share * of(*r, scale * (1.0 + times))).ln();
                    sum.add(residual.iter().map(mixed).sum::<f64>());
                }
            }
        }
        sum.log_mean(SCALES.len() * SHARES.len() * SPREADS.len()) + 0.5 * n * (variance.ln() + 1.0)
    };
    let each = state.iter().filter(|gyro| gyro.residual.iter().any(|r| *r != 0.0));
    each.map(|gyro| LogSum::of(&[0.0, of_gyro(&gyro.residual)]).log() - std::f64::consts::LN_2).sum()
}

impl Component {
    /// ln of the Bayes factor for this component of variance beside what was fitted; each gyro has it or not, with one
    /// half each.
    pub fn evidence(&self, frame: &Frame, state: &State) -> f64 {
        let whitened = |j: usize| {
            let columns = self.factor.column_iter();
            columns.map(|column| frame.gyros[j].whiten(column.iter().copied().collect())).collect()
        };
        evidence_of(frame, state, whitened) + self.share().ln()
    }

    /// How likely it is beforehand, against a component that is one by itself.
    pub fn share(&self) -> f64 {
        1.0 / self.among as f64
    }
}

/// The same of the columns of an entry (whitened, by gyro): what is held against components is weighed as they are. A
/// Bayes factor of coefficients ends where their prior does, and what leads it by the size of the effect has not
/// explained more.
pub(crate) fn evidence_of(frame: &Frame, state: &State, whitened: impl Fn(usize) -> Vec<Vec<f64>>) -> f64 {
    let of_gyro = |j: usize| {
        let (gyro, left) = (&frame.gyros[j], &state[j]);
        let mut columns = whitened(j);
        for column in &mut columns {
            gyro.basis.project_out(column);
            left.extra.basis.project_out(column);
        }
        let nu = (gyro.dof() - left.extra.basis.rank().min(gyro.dof())) as f64;
        log_bayes(&columns, &left.residual, nu, frame.noise.stated)
    };
    let each = (0..frame.gyros.len()).map(of_gyro);
    each.map(|log| LogSum::of(&[0.0, log]).log() - std::f64::consts::LN_2).sum()
}

fn log_bayes(columns: &[Vec<f64>], y: &[f64], nu: f64, stated: bool) -> f64 {
    let r = columns.len();
    let n = y.len();
    let w = DMatrix::from_fn(n, r, |k, c| columns[c][k]);
    let trace = w.norm_squared();
    if nu < 1.0 || trace <= 0.0 {
        return 0.0;
    }
    let scale = nu / trace;
    let axes = (w.tr_mul(&w) * scale).symmetric_eigen();
    let y = DMatrix::from_column_slice(n, 1, y);
    let along = axes.eigenvectors.tr_mul(&(w.tr_mul(&y) * scale.sqrt()));
    let (rss, k) = (y.norm_squared(), if stated { K } else { 0.0 });
    let mut sum = LogSum::default();
    for phi in POWERS {
        let (mut log_det, mut taken) = (0.0, 0.0);
        for i in 0..r {
            let l = axes.eigenvalues[i].max(0.0);
            log_det += (phi * l).ln_1p();
            taken += phi * along[i] * along[i] / (1.0 + phi * l);
        }
        let left = ((k + rss - taken) / (k + rss)).max(1e-12);
        sum.add(-0.5 * log_det - 0.5 * (nu + k) * left.ln());
    }
    sum.log_mean(POWERS.len())
}

fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    high - low
}

/// Slope at each dwell from its neighbours.
fn slope(time: &[f64], values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    let of = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        if b > a { (values[b] - values[a]) / (time[b] - time[a]).max(f64::MIN_POSITIVE) } else { 0.0 }
    };
    (0..values.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, Normal};

    use super::*;
    use crate::core::diagnose::residuals::pooled_noise::Scatter;
    use crate::core::diagnose::search::projections::{Extra, GyroState};

    #[test]
    fn a_component_is_worth_what_the_determinants_say() {
        // One column of unit length times the root of nu = 4, residual y: det(1 + phi W'W) = 1 + 4 phi.
        let y = [1.0, -2.0, 0.5, 3.0];
        let column = vec![0.5, 0.5, 0.5, 0.5];
        let along: f64 = y.iter().map(|y| 0.5 * y).sum();
        let rss: f64 = y.iter().map(|y| y * y).sum();
        let of = |phi: f64| {
            let left = (4.0 + rss - 4.0 * phi * along * along / (1.0 + 4.0 * phi)) / (4.0 + rss);
            (-0.5 * (1.0 + 4.0 * phi).ln() - 4.0 * left.ln()).exp()
        };
        let expected = (POWERS.map(of).iter().sum::<f64>() / POWERS.len() as f64).ln();
        assert!((log_bayes(&[column], &y, 4.0, true) - expected).abs() < 1e-9);
    }

    #[test]
    fn a_few_dwells_apart_are_said_to_be_few() {
        let gyro = |residual: Vec<f64>| {
            let rss = residual.iter().map(|r| r * r).sum();
            vec![GyroState::of(Extra::default(), residual, |left| Scatter { rss, nu: left.len() as f64 })]
        };
        // Normal scores: (k + 1/2)/60 of a normal distribution, and the same with three dwells off.
        let normal = Normal::standard();
        let mut scores: Vec<f64> = (0..60).map(|k| normal.inverse_cdf((f64::from(k) + 0.5) / 60.0)).collect();
        assert!(of_single_dwells(&gyro(scores.clone())) < 1.0);
        for k in [7, 30, 41] {
            scores[k] = 9.0;
        }
        assert!(of_single_dwells(&gyro(scores)) > 10.0);
    }
}
