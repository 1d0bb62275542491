//! Forward selection with corrected significance, classes of equals, and the gain on records left out.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::core::judge::Coefficient;
use crate::core::numerics::least_squares::{Factor, Fit};
use crate::core::numerics::tails::f_tail;

use super::answer::{FEWEST_RECORDS, GyroHistory, HistoryDiagnosis, HistoryVerdict, NamedCause, Rejected};
use super::candidates::{self, Candidate};
use super::peers::{self, StationOffset};

/// Adjusted significance below which a cause is named, and below which something is said to remain.
const SIGNIFICANCE: f64 = 0.01;
/// Two candidates explain a change equally well where their sums of squares differ by less than this many variances
/// (the 1 % point of chi-square with one degree of freedom).
const EQUALLY_GOOD: f64 = 6.635;
/// An own offset within this many standard deviations of the fleet's is the station's.
const CONSISTENT: f64 = 3.0;
const MOST_CAUSES: usize = 4;

struct Trial {
    candidate: Candidate,
    fit: Fit,
    p_adjusted: f64,
    left_out: f64,
}

pub(super) fn diagnose(gyro: &GyroHistory, peers: &[GyroHistory], coefficient: Coefficient) -> HistoryDiagnosis {
    let column = coefficient.column().unwrap_or(0);
    let values: Vec<f64> = gyro.entries.iter().map(|e| e.d[column].value).collect();
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let y = DVector::from_iterator(n, values.iter().map(|v| v - mean));
    let mut answer = HistoryDiagnosis {
        coefficient,
        verdict: HistoryVerdict::TooFew,
        records: n,
        scatter: scatter(&y),
        spread: (y.norm_squared() / n.max(1) as f64).sqrt(),
        causes: Vec::new(),
        rejected: Vec::new(),
        remaining_p_value: 1.0,
    };
    if n < FEWEST_RECORDS || answer.spread <= 1e-12 * mean.abs().max(1e-12) {
        answer.verdict = if n < FEWEST_RECORDS { HistoryVerdict::TooFew } else { HistoryVerdict::NoChange };
        return answer;
    }
    let reference = most_used_station(gyro);
    let offsets = peers::station_offsets(peers, &reference, column);
    let mut pool = candidates::all(gyro, coefficient, &reference);
    let mut taken: Vec<Candidate> = Vec::new();
    while taken.len() < MOST_CAUSES {
        let Some((named, candidate)) = next_cause(&y, &taken, &pool, &offsets, answer.scatter) else { break };
        pool.retain(|c| c.column != candidate.column);
        taken.push(candidate);
        answer.causes.push(named);
    }
    restate_estimates(&y, &taken, &mut answer.causes);
    answer.rejected = rejected(&y, &taken, &pool, &offsets);
    let fit = fit_with(&y, &taken, None);
    answer.remaining_p_value = fit.map_or(1.0, |fit| von_neumann_p(&fit.residuals));
    answer.verdict = match (answer.causes.is_empty(), answer.remaining_p_value < SIGNIFICANCE) {
        (true, false) => HistoryVerdict::NoChange,
        (true, true) => HistoryVerdict::Unexplained,
        (false, false) => HistoryVerdict::Explained,
        (false, true) => HistoryVerdict::PartlyExplained,
    };
    answer
}

fn next_cause(
    y: &DVector<f64>,
    taken: &[Candidate],
    pool: &[Candidate],
    offsets: &BTreeMap<String, StationOffset>,
    scatter: f64,
) -> Option<(NamedCause, Candidate)> {
    let base = fit_with(y, taken, None)?;
    let kinds: usize = kinds(pool);
    let mut trials: Vec<Trial> = pool
        .iter()
        .filter_map(|c| trial(y, taken, c, &base, kinds))
        .filter(|t| t.p_adjusted < SIGNIFICANCE && contradicted(t, offsets).is_none())
        .collect();
    trials.sort_by(|a, b| a.fit.chi2.total_cmp(&b.fit.chi2));
    let best = trials.first()?;
    let tolerance = EQUALLY_GOOD * best.fit.chi2 / best.fit.dof.max(1) as f64;
    let ceiling = best.fit.chi2 + tolerance.max(1e-12 * base.chi2);
    let equals: Vec<&Trial> = trials.iter().filter(|t| t.fit.chi2 <= ceiling).collect();
    // What was recorded of the occasion comes before an instant that was only searched for, and what the whole fleet
    // shows comes before what one gyro suggests.
    let rank = |t: &Trial| match &t.candidate.station {
        Some(name) if offsets.get(name).is_some_and(|o| o.value.abs() > CONSISTENT * o.sd) => 0,
        _ if t.candidate.cause == "step" => 2,
        _ => 1,
    };
    let lead = equals.iter().min_by(|a, b| rank(a).cmp(&rank(b)).then(a.fit.chi2.total_cmp(&b.fit.chi2)))?;
    let mut class: Vec<&'static str> =
        equals.iter().filter(|t| rank(t) == rank(lead)).map(|t| t.candidate.cause).collect();
    class.sort_unstable();
    class.dedup();
    let before = left_out_rms(&base)?;
    if lead.left_out >= before {
        return None;
    }
    let floor = scatter.min(lead.left_out);
    let named = NamedCause {
        cause: lead.candidate.cause,
        class,
        detail: lead.candidate.detail.clone(),
        estimates: Vec::new(),
        before,
        after: lead.left_out,
        closure: 1.0 - (lead.left_out.powi(2) - floor.powi(2)) / (before.powi(2) - floor.powi(2)),
        p_value_adjusted: lead.p_adjusted,
    };
    Some((named, lead.candidate.clone()))
}

/// F test of one more column, corrected for every kind and every instant that was tried.
fn trial(y: &DVector<f64>, taken: &[Candidate], candidate: &Candidate, base: &Fit, kinds: usize) -> Option<Trial> {
    let fit = fit_with(y, taken, Some(candidate))?;
    if fit.rank <= base.rank || fit.dof < 2 {
        return None;
    }
    let gain = base.chi2 - fit.chi2;
    // Noise-free histories: rounding stands in for a variance of zero.
    let variance = (fit.chi2 / fit.dof as f64).max(1e-24 * base.chi2);
    let p = if gain > 0.0 { f_tail(gain / variance, 1.0, fit.dof as f64) } else { 1.0 };
    let p_adjusted = (p * (kinds * candidate.tried) as f64).min(1.0);
    let left_out = left_out_rms(&fit)?;
    Some(Trial { candidate: candidate.clone(), fit, p_adjusted, left_out })
}

/// Why a station's offset on this gyro is not the station's, where the other gyros it measured say so.
fn contradicted(trial: &Trial, offsets: &BTreeMap<String, StationOffset>) -> Option<String> {
    let offset = offsets.get(trial.candidate.station.as_deref()?)?;
    let last = trial.fit.estimate.len() - 1;
    let own = trial.fit.estimate[last];
    let own_sd = (trial.fit.covariance[(last, last)] * trial.fit.chi2 / trial.fit.dof as f64).sqrt();
    ((own - offset.value).abs() > CONSISTENT * own_sd.hypot(offset.sd)).then(|| {
        format!(
            "{own:+.4} here, but {:+.4} +- {:.4} on the {} other gyros that the station measured",
            offset.value, offset.sd, offset.gyros
        )
    })
}

fn rejected(
    y: &DVector<f64>,
    taken: &[Candidate],
    pool: &[Candidate],
    offsets: &BTreeMap<String, StationOffset>,
) -> Vec<Rejected> {
    let Some(base) = fit_with(y, taken, None) else { return Vec::new() };
    let mut best_step: Option<Rejected> = None;
    let mut best_p = f64::INFINITY;
    let mut out = Vec::new();
    for candidate in pool {
        let reason = match trial(y, taken, candidate, &base, kinds(pool)) {
            None => "cannot be told from what is already named".to_owned(),
            Some(t) => {
                let reason = contradicted(&t, offsets)
                    .unwrap_or_else(|| format!("not significant beside the rest (adjusted p = {:.2})", t.p_adjusted));
                if candidate.cause == "step" {
                    if t.p_adjusted < best_p {
                        best_p = t.p_adjusted;
                        best_step = Some(Rejected { cause: "step", detail: candidate.detail.clone(), reason });
                    }
                    continue;
                }
                reason
            }
        };
        if candidate.cause != "step" {
            out.push(Rejected { cause: candidate.cause, detail: candidate.detail.clone(), reason });
        }
    }
    out.extend(best_step);
    out
}

/// Estimates of all named causes from one fit of them together.
fn restate_estimates(y: &DVector<f64>, taken: &[Candidate], causes: &mut [NamedCause]) {
    let Some(fit) = fit_with(y, taken, None) else { return };
    let variance = fit.chi2 / fit.dof.max(1) as f64;
    for (k, (candidate, cause)) in taken.iter().zip(causes).enumerate() {
        let sd = (fit.covariance[(k + 1, k + 1)] * variance).sqrt();
        cause.estimates = vec![(candidate.parameter.to_owned(), fit.estimate[k + 1], sd, candidate.unit)];
    }
}

/// Constant + `taken` + `extra`, least squares; none where nothing would be left to judge by.
fn fit_with(y: &DVector<f64>, taken: &[Candidate], extra: Option<&Candidate>) -> Option<Fit> {
    let columns: Vec<&Candidate> = taken.iter().chain(extra).collect();
    if y.len() < columns.len() + 2 {
        return None;
    }
    let design =
        DMatrix::from_fn(y.len(), columns.len() + 1, |r, c| if c == 0 { 1.0 } else { columns[c - 1].column[r] });
    Some(Factor::new(design, &vec![1.0; y.len()]).fit(y))
}

/// Root mean square error of each record predicted from the others, r_i / (1 - h_i).
fn left_out_rms(fit: &Fit) -> Option<f64> {
    let mut sum = 0.0;
    for (r, h) in fit.residuals.iter().zip(fit.leverage.iter()) {
        let free = 1.0 - h;
        if free < 1e-9 {
            return None;
        }
        sum += (r / free).powi(2);
    }
    Some((sum / fit.residuals.len() as f64).sqrt())
}

/// Scatter from successive differences: median |d| / (0.6745 sqrt 2), which a step or a slow drift hardly moves.
fn scatter(y: &DVector<f64>) -> f64 {
    let mut d: Vec<f64> = y.as_slice().windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    if d.is_empty() {
        return 0.0;
    }
    d.sort_by(f64::total_cmp);
    let middle = d.len() / 2;
    let median = if d.len() % 2 == 1 { d[middle] } else { 0.5 * (d[middle - 1] + d[middle]) };
    median / (0.674_489_75 * std::f64::consts::SQRT_2)
}

/// Von Neumann's ratio of successive differences to variance: small where residuals follow one another.
/// Mean 2n/(n-1), variance 4 n^2 (n-2) / ((n+1) (n-1)^3) for independent normal residuals (von Neumann 1941).
fn von_neumann_p(residuals: &DVector<f64>) -> f64 {
    let n = residuals.len() as f64;
    let variance = residuals.norm_squared() / n;
    if variance <= f64::MIN_POSITIVE || n < 4.0 {
        return 1.0;
    }
    let differences: f64 = residuals.as_slice().windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (n - 1.0);
    let mean = 2.0 * n / (n - 1.0);
    let sd = (4.0 * n * n * (n - 2.0) / ((n + 1.0) * (n - 1.0).powi(3))).sqrt();
    Normal::standard().cdf((differences / variance - mean) / sd)
}

fn kinds(pool: &[Candidate]) -> usize {
    pool.iter().filter(|c| c.cause != "step").count() + 1
}

fn most_used_station(gyro: &GyroHistory) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in &gyro.entries {
        *counts.entry(&entry.station).or_default() += 1;
    }
    let most = counts.into_iter().max_by_key(|&(_, count)| count);
    most.map_or_else(String::new, |(name, _)| name.to_owned())
}
