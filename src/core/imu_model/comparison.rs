//! How far a forecast came true, and how much of its error goes away with the adopted effects.
//!
//! Errors of one forecast are correlated: all come from one set of coefficients. Taken dwell by dwell, each held
//! against the forecast and the dwells before it, they are independent:
//!
//! ```text
//! z_i = (y_i - x_i.theta_i)/sqrt(x_i'C_i x_i + s_i^2)
//! ```
//!
//! with `theta_i`, `C_i` as the dwells before `i` leave them (the innovations of a Kalman filter). The probability
//! integral transform and the chi-square test are of those. Where the scale of the noise is estimated the transform is
//! that of Student's t, with the scale as the model and the errors before have it.

use nalgebra::{DMatrix, DVector};

use super::forecast::{Forecast, predict};
use super::identified::Identified;
use super::programme::{CoefficientEstimate, ForecastGyro, NoForecast, StackedDesign};
use crate::core::campaign::Campaign;
use crate::core::effects::Effect;
use crate::core::judge::{FALSE_ALARMS, ForecastErrors, GyroForecastErrors, Unseen};
use crate::core::mounting::Slot;
use crate::core::numerics::bisection::bisect;
use crate::core::numerics::normal::normal_quantile;
use crate::core::numerics::tails::{squares_tail, t_cdf};

/// Chance, over all dwells, below which a dwell has missed its forecast.
const MISSED: f64 = 0.01;
/// Of a two-sided interval of 95 %.
const NORMAL_95: f64 = 1.959_963_985;

/// A forecast held against what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastComparison {
    pub forecast: Forecast,
    pub gyros: Vec<GyroComparison>,
    /// Dwells and gyros that were foretold.
    pub count: usize,
    /// Root mean square of error over stated standard deviation.
    pub rms_over_sd: f64,
    /// Root mean square of the error, weighted by 1/noise^2, and of the noise alone, deg/h.
    pub rms_deg_per_h: f64,
    pub noise_deg_per_h: f64,
    /// That the errors are as large if model and noise are right.
    pub p_value: f64,
    /// Kolmogorov's test that the probability integral transform is uniform.
    pub pit_p_value: f64,
    /// Beyond what chance has over all dwells, the furthest first.
    pub missed: Vec<OutlyingDwell>,
    /// Whether the model has seen the temperatures, rates and attitudes of half the dwells: those alone are judged.
    is_mostly_seen: bool,
    /// None where the model holds no effects.
    pub closing: Option<ErrorReduction>,
}

/// One gyro's outputs held against its forecast.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroComparison {
    pub slot: Slot,
    /// Measured less foretold, pulse/s, by dwell.
    pub error: Vec<f64>,
    /// Over the stated standard deviation; zero where nothing was foretold.
    pub z: Vec<f64>,
    /// The transform of each independent error, dwell by dwell of those that are foretold.
    pub pit: Vec<f64>,
    pub rms_over_sd: f64,
    /// That the errors of this gyro are as large.
    pub p_value: f64,
    /// What that is judged by.
    pub errors: GyroForecastErrors,
}

impl ForecastComparison {
    /// As a rule judges it.
    pub fn foretold(&self, model: &Identified) -> ForecastErrors {
        let is_left_out = |unseen: &Unseen| self.is_mostly_seen && unseen.is_of_dwells();
        let contradicts = self.p_value < FALSE_ALARMS;
        ForecastErrors {
            gyros: self.gyros.iter().map(|gyro| gyro.errors).collect(),
            campaigns: model.campaigns.len(),
            unseen: self.unseen().find(|unseen| !is_left_out(unseen)),
            contradicted: self.unseen().find(is_left_out).filter(|_| contradicts),
        }
    }

    fn unseen(&self) -> impl Iterator<Item = Unseen> {
        self.forecast.notes.iter().filter_map(|note| Unseen::from_name(&note.code))
    }

    /// Of dwells whose rates and attitudes the model has seen, `beyond` the temperatures that it has.
    fn judge_beyond_seen(&mut self, beyond: &StackedDesign, estimate: &CoefficientEstimate, measured: &DVector<f64>) {
        if self.unseen().any(|unseen| !unseen.is_of_dwells()) {
            return;
        }
        let n = beyond.dwells;
        let is_judged = |i: usize| {
            let seen = beyond.seen[i % n];
            seen.rate && seen.attitude && self.forecast.gyros[i / n].foretold[i % n]
        };
        let innovations = innovations(beyond, estimate, measured, is_judged);
        let judged = |j: usize| {
            let rows = (j * n..(j + 1) * n).filter(|i| is_judged(*i));
            let squares: f64 = rows.clone().map(|i| innovations[i][0].powi(2)).sum();
            (rows.count(), squares * beyond.gyros[j].t_variance)
        };
        let judged: Vec<_> = (0..self.gyros.len()).map(judged).collect();
        for (gyro, judged) in self.gyros.iter_mut().zip(judged) {
            gyro.errors.beyond_seen = (judged.0 > 0).then_some(judged);
        }
    }
}

/// A dwell far from its forecast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlyingDwell {
    pub slot: Slot,
    pub dwell: usize,
    pub z: f64,
}

/// How much of the forecast error above the noise goes away with the adopted effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorReduction {
    /// Root mean square of the error without and with them, deg/h.
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    /// 1 - (after^2 - noise^2)/(before^2 - noise^2), at most 1.
    pub closure: f64,
    /// 95 %; none where the error without them does not exceed the noise.
    pub interval: Option<[f64; 2]>,
}

/// One step of a sequence of nested models.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelStep {
    /// The effect that this step adds; none for model (6) alone.
    pub effect: Option<Effect>,
    pub rms_deg_per_h: f64,
    pub rms_over_sd: f64,
}

/// Holds a measured campaign against its forecast.
///
/// # Errors
/// [`NoForecast`]; also where the model was fitted to the campaign.
pub fn compare(model: &Identified, campaign: &Campaign) -> Result<ForecastComparison, NoForecast> {
    let programme = StackedDesign::of_another(model, campaign)?;
    let estimate = CoefficientEstimate::of(model, campaign, &programme, model.effects.len());
    let measured = programme.measured(campaign);
    let mut compared = compared(&programme, &estimate, &measured);
    if !compared.is_mostly_seen {
        let beyond = programme.beyond_seen();
        let estimate = CoefficientEstimate::of(model, campaign, &beyond, model.effects.len());
        compared.judge_beyond_seen(&beyond, &estimate, &measured);
    }
    if !model.effects.is_empty() {
        let plain = CoefficientEstimate::of(model, campaign, &programme, 0);
        compared.closing = Some(WeightedErrors::of(&programme, &estimate, &plain, &compared.forecast).seen(&measured));
    }
    Ok(compared)
}

/// What the model promises of [`ErrorReduction`] before the campaign is measured.
///
/// # Errors
/// As [`compare`].
pub fn promised(model: &Identified, campaign: &Campaign) -> Result<Option<ErrorReduction>, NoForecast> {
    if model.effects.is_empty() {
        return Ok(None);
    }
    let programme = StackedDesign::of(model, campaign)?;
    let (estimate, plain) = (
        CoefficientEstimate::of(model, campaign, &programme, model.effects.len()),
        CoefficientEstimate::of(model, campaign, &programme, 0),
    );
    let forecast = predict(&programme, &estimate);
    Ok(Some(WeightedErrors::of(&programme, &estimate, &plain, &forecast).promised()))
}

/// Model (6) alone, then effect by effect: the error of each one's forecast.
///
/// # Errors
/// As [`compare`].
pub fn ladder(model: &Identified, campaign: &Campaign) -> Result<Vec<ModelStep>, NoForecast> {
    let programme = StackedDesign::of_another(model, campaign)?;
    let measured = programme.measured(campaign);
    let step = |effects: usize| {
        let compared = compared(&programme, &CoefficientEstimate::of(model, campaign, &programme, effects), &measured);
        ModelStep {
            effect: effects.checked_sub(1).map(|last| model.effects[last].effect),
            rms_deg_per_h: compared.rms_deg_per_h,
            rms_over_sd: compared.rms_over_sd,
        }
    };
    Ok((0..=model.effects.len()).map(step).collect())
}

fn compared(programme: &StackedDesign, estimate: &CoefficientEstimate, measured: &DVector<f64>) -> ForecastComparison {
    let forecast = predict(programme, estimate);
    let n = programme.dwells;
    let is_told = |i: usize| forecast.gyros[i / n].foretold[i % n];
    let innovations = innovations(programme, estimate, measured, is_told);
    let judged = JudgedInnovations::of(programme, estimate, measured, (&forecast, &innovations));
    let mut scale = VarianceScale::of(scale_dof(programme));
    let mut gyros = Vec::new();
    let mut missed = Vec::new();
    let (mut squares, mut all_independent, mut count) = (0.0, 0.0, 0);
    let (mut errors, mut weights) = (0.0, 0.0);
    for (j, gyro) in forecast.gyros.iter().enumerate() {
        let error: Vec<f64> =
            (0..n).map(|k| measured[j * n + k] + programme.held[j * n + k] - gyro.predicted[k]).collect();
        let z: Vec<f64> = (0..n).map(|k| if gyro.foretold[k] { error[k] / gyro.sd[k] } else { 0.0 }).collect();
        let told: Vec<usize> = (0..n).filter(|k| gyro.foretold[*k]).collect();
        let of_gyro: f64 = z.iter().map(|z| z * z).sum();
        let ForecastGyro { dof, t_variance, .. } = programme.gyros[j];
        let independent: Vec<f64> = told.iter().map(|k| innovations[j * n + k][0] * t_variance.sqrt()).collect();
        let squares_of_gyro: f64 = independent.iter().map(|error| error * error).sum();
        if !programme.one_scale {
            scale = VarianceScale::of(dof);
        }
        for k in &told {
            let weight = (gyro.scale / gyro.noise[*k]).powi(2);
            errors += weight * (error[*k] / gyro.scale).powi(2);
            weights += weight;
            missed.push(OutlyingDwell { slot: gyro.slot, dwell: *k, z: z[*k] });
        }
        squares += of_gyro;
        all_independent += squares_of_gyro;
        count += told.len();
        gyros.push(GyroComparison {
            slot: gyro.slot,
            errors: gyro_errors(programme, &forecast, &judged, j, &z),
            error,
            z,
            pit: independent.into_iter().map(|error| scale.transformed(error)).collect(),
            rms_over_sd: (of_gyro / told.len().max(1) as f64).sqrt(),
            p_value: squares_tail(squares_of_gyro, told.len(), dof),
        });
    }
    let each = 1.0 - (1.0 - MISSED).powf(1.0 / count.max(1) as f64);
    let limit = -normal_quantile(0.5 * each);
    missed.retain(|miss| miss.z.abs() > limit);
    missed.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    let pit: Vec<f64> = gyros.iter().flat_map(|gyro| &gyro.pit).copied().collect();
    ForecastComparison {
        gyros,
        count,
        rms_over_sd: (squares / count.max(1) as f64).sqrt(),
        rms_deg_per_h: (errors / weights).sqrt(),
        noise_deg_per_h: (count as f64 / weights).sqrt(),
        p_value: squares_tail(all_independent, count, scale_dof(programme)),
        pit_p_value: kolmogorov(&pit),
        missed,
        is_mostly_seen: judged.is_mostly_seen,
        closing: None,
        forecast,
    }
}

/// What a rule judges: the dwells of which the model has seen the like, where they are half of all.
struct JudgedInnovations {
    is_mostly_seen: bool,
    innovations: Vec<[f64; 3]>,
}

impl JudgedInnovations {
    fn of(
        programme: &StackedDesign,
        estimate: &CoefficientEstimate,
        measured: &DVector<f64>,
        (forecast, of_all): (&Forecast, &[[f64; 3]]),
    ) -> Self {
        let n = programme.dwells;
        let seen = programme.seen.iter().filter(|seen| seen.whole()).count();
        let is_mostly_seen = 2 * seen >= n;
        if !is_mostly_seen || seen == n {
            return Self { is_mostly_seen, innovations: of_all.to_vec() };
        }
        let is_judged = |i: usize| programme.seen[i % n].whole() && forecast.gyros[i / n].foretold[i % n];
        Self { is_mostly_seen, innovations: innovations(programme, estimate, measured, is_judged) }
    }

    fn counts(&self, programme: &StackedDesign, dwell: usize) -> bool {
        programme.seen[dwell].whole() || !self.is_mostly_seen
    }
}

fn gyro_errors(
    programme: &StackedDesign,
    forecast: &Forecast,
    judged: &JudgedInnovations,
    j: usize,
    z: &[f64],
) -> GyroForecastErrors {
    let (n, gyro) = (programme.dwells, &programme.gyros[j]);
    let foretold = &forecast.gyros[j].foretold;
    let told: Vec<usize> = (0..n).filter(|k| foretold[*k] && judged.counts(programme, *k)).collect();
    let sum = |of: usize| told.iter().map(|k| judged.innovations[j * n + k][of].powi(2)).sum::<f64>();
    GyroForecastErrors {
        slot: gyro.slot,
        count: told.len(),
        dof: gyro.dof,
        squares: sum(0) * gyro.t_variance,
        noncentrality: [sum(1), sum(2)].map(|noncentrality| noncentrality * gyro.t_variance),
        beyond_seen: None,
        furthest: told.iter().map(|k| (*k, z[*k])).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())),
    }
}

/// Degrees of freedom of the noise of all gyros together: one scale is known as well as by any of them, scales of
/// their own add up.
fn scale_dof(programme: &StackedDesign) -> f64 {
    let dof = programme.gyros.iter().map(|gyro| gyro.dof);
    if programme.one_scale { dof.fold(f64::INFINITY, f64::min) } else { dof.sum() }
}

/// Errors one by one, each over its standard deviation given those before, and what a step of D_I and of D_S of the
/// row's gyro by 1 deg/(h g0) adds to it; zero of what is left out.
fn innovations(
    programme: &StackedDesign,
    estimate: &CoefficientEstimate,
    measured: &DVector<f64>,
    is_told: impl Fn(usize) -> bool,
) -> Vec<[f64; 3]> {
    let n = programme.dwells;
    let CoefficientEstimate { values, mut covariance } = estimate.clone();
    // What the rows before have told: of the campaign, and of one whose D_I or D_S alone differs.
    let mut told = [values.clone(), DVector::zeros(values.len()), DVector::zeros(values.len())];
    let mut found = vec![[0.0; 3]; measured.len()];
    for (i, found) in found.iter_mut().enumerate() {
        if i % n == 0 {
            told[1..].iter_mut().for_each(|step| step.fill(0.0));
        }
        if !is_told(i) {
            continue;
        }
        let row = programme.columns.row(i).transpose();
        let spread = &covariance * &row;
        let variance = row.dot(&spread).max(0.0) + programme.noise[i].powi(2);
        let [d_i, d_s] = programme.steps[i];
        for ((told, outcome), found) in told.iter_mut().zip([measured[i], d_i, d_s]).zip(found) {
            let error = outcome - row.dot(told);
            *found = error / variance.sqrt();
            told.axpy(error / variance, &spread, 1.0);
        }
        covariance.ger(-1.0 / variance, &spread, &spread, 1.0);
    }
    found
}

/// What the scale of the noise is known by: of the model, then of the errors before as well.
struct VarianceScale {
    /// Over the variance that the model has.
    squares: f64,
    dof: f64,
}

impl VarianceScale {
    fn of(dof: f64) -> Self {
        Self { squares: dof, dof }
    }

    /// The probability integral transform of the next error, over the standard deviation that the model has.
    fn transformed(&mut self, error: f64) -> f64 {
        let scale = if self.dof.is_finite() { (self.squares / self.dof).sqrt() } else { 1.0 };
        let transformed = t_cdf(error / scale, self.dof);
        *self = Self { squares: self.squares + error * error, dof: self.dof + 1.0 };
        transformed
    }
}

/// P of Kolmogorov's statistic for numbers that should be uniform (Stephens 1970).
pub(super) fn kolmogorov(uniform: &[f64]) -> f64 {
    let mut sorted = uniform.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    if sorted.is_empty() {
        return 1.0;
    }
    let away = |(i, u): (usize, &f64)| ((i as f64 + 1.0) / n - u).max(u - i as f64 / n);
    let distance = sorted.iter().enumerate().map(away).fold(0.0, f64::max);
    let x = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    let term = |k: i32| f64::from(if k % 2 == 1 { 2 } else { -2 }) * (-2.0 * f64::from(k * k) * x * x).exp();
    if x < 0.3 { 1.0 } else { (1..=100).map(term).sum::<f64>().clamp(0.0, 1.0) }
}

/// The two forecasts over the noise: with the effects and without them.
///
/// With `W = 1/noise^2` and `d` the difference of the forecasts, `A = e'We - N` and `B = (e + d)'W(e + d) - N` are what
/// the errors with and without the effects exceed the noise by. Both are quadratic in normal errors, and their ratio
/// has Fieller's interval.
struct WeightedErrors {
    /// Rows that are foretold.
    rows: Vec<usize>,
    predicted: DVector<f64>,
    weight: DVector<f64>,
    difference: DVector<f64>,
    /// tr(CM), tr((CM)^2), tr((CM)^3); M = X'WX.
    traces: [f64; 3],
    /// d'Wd, d'WPWd, d'WPWPWd; P = XCX'.
    powers: [f64; 3],
    /// rms over sqrt of a mean square in units of the noise, deg/h.
    unit: f64,
    /// Degrees of freedom that the noise is known by: it is in A and B alike, N^2 2/dof.
    dof: f64,
}

impl WeightedErrors {
    fn of(
        programme: &StackedDesign,
        with: &CoefficientEstimate,
        without: &CoefficientEstimate,
        forecast: &Forecast,
    ) -> Self {
        let n = programme.dwells;
        let rows: Vec<usize> = (0..programme.noise.len()).filter(|i| forecast.gyros[i / n].foretold[i % n]).collect();
        let x = programme.columns.select_rows(&rows);
        let weight = programme.noise.select_rows(&rows).map(|s| s.powi(-2));
        let (predicted, difference) = (&x * &with.values, &x * (&with.values - &without.values));
        let weighted = DMatrix::from_fn(x.nrows(), x.ncols(), |i, c| x[(i, c)] * weight[i]);
        let cm = &with.covariance * x.tr_mul(&weighted);
        let squared = &cm * &cm;
        let along = weighted.tr_mul(&difference);
        let spread = &with.covariance * &along;
        let scales: f64 = rows.iter().map(|i| (programme.gyros[i / n].scale / programme.noise[*i]).powi(2)).sum();
        Self {
            traces: [cm.trace(), squared.trace(), (&squared * &cm).trace()],
            powers: [
                difference.component_mul(&difference).dot(&weight),
                along.dot(&spread),
                spread.dot(&x.tr_mul(&weighted).tr_mul(&spread)),
            ],
            unit: (rows.len() as f64 / scales).sqrt(),
            dof: scale_dof(programme),
            rows,
            predicted,
            weight,
            difference,
        }
    }

    /// A is a sum of squares few of which may be large: the errors of a few coefficients. The quantiles of A - r B are
    /// those of Pearson's type III with its first three cumulants.
    fn promised(&self) -> ErrorReduction {
        let n = self.rows.len() as f64;
        let [t1, t2, t3] = self.traces;
        let [p1, p2, p3] = self.powers;
        let below_zero = |r: f64, quantile: f64| {
            let (own, rest) = (1.0 - r, 4.0 * r * r);
            let mean = own * t1 - r * p1;
            let of_noise = 2.0 * n * n / self.dof;
            let sd = (own * own * (2.0 * (n + 2.0 * t1 + t2) + of_noise) + rest * (p1 + p2)).sqrt();
            let third = own.powi(3) * 8.0 * (n + 3.0 * t1 + 3.0 * t2 + t3) + 6.0 * own * rest * (p1 + 2.0 * p2 + p3);
            -mean - sd * pearson(quantile, third / sd.powi(3))
        };
        let root = |quantile: f64| {
            let (low, high) = (-3.0, 1.0);
            if below_zero(low, quantile) > 0.0 || below_zero(high, quantile) < 0.0 {
                return None;
            }
            Some(1.0 - bisect(low, high, 60, |r| below_zero(r, quantile) < 0.0).1)
        };
        let interval = root(0.975).zip(root(0.025)).map(|(low, high)| [low.min(1.0), high.min(1.0)]);
        let rms = |excess: f64| self.unit * ((excess + n) / n).sqrt();
        ErrorReduction {
            before_deg_per_h: rms(t1 + p1),
            after_deg_per_h: rms(t1),
            closure: p1 / (t1 + p1).max(f64::MIN_POSITIVE),
            interval,
        }
    }

    fn seen(&self, measured: &DVector<f64>) -> ErrorReduction {
        let n = self.rows.len() as f64;
        let with = measured.select_rows(&self.rows) - &self.predicted;
        let without = &with + &self.difference;
        let product = |x: &DVector<f64>, y: &DVector<f64>| x.component_mul(y).dot(&self.weight) - n;
        let (a, b, c) = (product(&with, &with), product(&without, &without), product(&with, &without));
        let variance = |x: f64| 2.0 * n + 4.0 * x.max(0.0);
        self.closing(a, b, variance(a), variance(b), 2.0 * n + 4.0 * c.max(0.0))
    }

    /// Of excesses `a`, `b`, their variances and covariance.
    fn closing(&self, a: f64, b: f64, of_a: f64, of_b: f64, of_both: f64) -> ErrorReduction {
        let n = self.rows.len() as f64;
        let rms = |excess: f64| self.unit * ((excess + n).max(0.0) / n).sqrt();
        let closure = |ratio: f64| (1.0 - ratio).min(1.0);
        let z = NORMAL_95 * NORMAL_95;
        let [of_a, of_b, of_both] = [of_a, of_b, of_both].map(|v| v + 2.0 * n * n / self.dof);
        // (a - r b)^2 = z^2 (var a - 2 r cov + r^2 var b).
        let (square, half, rest) = (b * b - z * of_b, a * b - z * of_both, a * a - z * of_a);
        let root = half * half - square * rest;
        let bounded = b > 0.0 && square > 0.0 && root >= 0.0;
        let interval = bounded.then(|| [1.0, -1.0].map(|sign| closure((half + sign * root.sqrt()) / square)));
        ErrorReduction {
            before_deg_per_h: rms(b),
            after_deg_per_h: rms(a),
            closure: if b > 0.0 { closure(a / b) } else { 0.0 },
            interval,
        }
    }
}

/// Quantile of Pearson's type III with mean 0, variance 1 and this skewness (Wilson and Hilferty 1931).
fn pearson(quantile: f64, skewness: f64) -> f64 {
    let z = normal_quantile(quantile);
    if skewness.abs() < 1e-6 {
        return z;
    }
    let g = skewness / 6.0;
    ((1.0 + g * z - g * g).powi(3) - 1.0) / (3.0 * g)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_pearsons_type_iii_are_those_of_chi_square() {
        // Upper and lower 2.5 % of 8 degrees of freedom: 17.535 and 2.180 (Pearson and Hartley); skewness sqrt(8/8).
        for (p, chi2) in [(0.975, 17.535), (0.025, 2.180)] {
            let found = 8.0 + 4.0 * pearson(p, 1.0);
            assert!((found / chi2 - 1.0).abs() < 0.02, "{found} {chi2}");
        }
    }

    #[test]
    fn a_scale_that_is_estimated_makes_t_of_errors_and_is_known_better_after_each() {
        // P(t < 1) of 3 degrees of freedom, then P(t < 2) of 4 (Abramowitz and Stegun 26.7.3, 26.7.4).
        let mut estimated = VarianceScale::of(3.0);
        let expected = [0.804_499, 0.941_942];
        for (error, expected) in [1.0, 2.0].into_iter().zip(expected) {
            let found = estimated.transformed(error);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        let mut known = VarianceScale::of(f64::INFINITY);
        assert!(known.transformed(9.0) > 0.999 && (known.transformed(1.644_853_627) - 0.95).abs() < 1e-9);
    }

    #[test]
    fn kolmogorovs_p_is_that_of_the_tables() {
        // sqrt(n) D = 1.358 has p = 0.05, 1.628 has p = 0.01 for many numbers (Smirnov 1948).
        let n = 40_000;
        for (x, p) in [(1.358, 0.05), (1.628, 0.01)] {
            let shift = x / f64::from(n).sqrt();
            let moved: Vec<f64> = (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n) * (1.0 - shift)).collect();
            assert!((kolmogorov(&moved) / p - 1.0).abs() < 0.05, "{x}: {}", kolmogorov(&moved));
        }
        let even: Vec<f64> = (0..500).map(|i| (f64::from(i) + 0.5) / 500.0).collect();
        assert_eq!(kolmogorov(&even), 1.0);
    }
}
