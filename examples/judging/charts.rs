//! Control charts that everyone knows, on the same histories: each learns mean and standard deviation of D_I and of
//! D_S from the first 26 records, and counts an alarm whenever it begins to speak.

use crate::fleet::Arrival;

/// Records that a chart learns from.
const LEARNED: usize = 26;

pub const CHARTS: [(&str, fn(&[f64]) -> usize); 3] =
    [("Western Electric", western_electric), ("EWMA 0.2", ewma), ("CUSUM 0.5/5", cusum)];

/// Alarms of a chart on both coefficients of a gyro, and the years that it watched.
pub fn alarms(chart: fn(&[f64]) -> usize, arrivals: &[Arrival]) -> (usize, f64) {
    let (Some(first), Some(last)) = (arrivals.get(LEARNED), arrivals.last()) else { return (0, 0.0) };
    let of_column = |column: usize| {
        let x: Vec<f64> = arrivals.iter().map(|arrival| arrival.sample.d[column].value).collect();
        let (learned, watched) = x.split_at(LEARNED);
        let mean = learned.iter().sum::<f64>() / LEARNED as f64;
        let variance = learned.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (LEARNED - 1) as f64;
        chart(&watched.iter().map(|x| (x - mean) / variance.sqrt()).collect::<Vec<f64>>())
    };
    (of_column(0) + of_column(1), (last.day - first.day) / 365.25)
}

/// How often a condition begins to hold.
fn begins(speaks: impl Iterator<Item = bool>) -> usize {
    let mut before = false;
    speaks.filter(|now| std::mem::replace(&mut before, *now) != *now && *now).count()
}

/// One beyond 3 sd; two of three beyond 2 sd, four of five beyond 1 sd, eight in a row, on one side.
fn western_electric(z: &[f64]) -> usize {
    let speaks = |k: usize| {
        let many = |of: usize, need: usize, beyond: f64| {
            let window = &z[(k + 1).saturating_sub(of)..=k];
            [1.0, -1.0].iter().any(|side| window.iter().filter(|z| **z * side > beyond).count() >= need)
        };
        many(1, 1, 3.0) || many(3, 2, 2.0) || many(5, 4, 1.0) || many(8, 8, 0.0)
    };
    begins((0..z.len()).map(speaks))
}

/// Exponentially weighted mean, lambda 0.2, limits at 2.86 sd.
fn ewma(z: &[f64]) -> usize {
    let (lambda, mut mean, mut weight) = (0.2, 0.0, 1.0);
    begins(z.iter().map(|z| {
        mean += lambda * (z - mean);
        weight *= (1.0_f64 - lambda).powi(2);
        f64::abs(mean) > 2.86 * (lambda / (2.0 - lambda) * (1.0 - weight)).sqrt()
    }))
}

/// Two-sided sum, reference 0.5, limit 5; begins anew after an alarm.
fn cusum(z: &[f64]) -> usize {
    let (mut up, mut down, mut count) = (0.0_f64, 0.0_f64, 0);
    for z in z {
        up = (up + z - 0.5).max(0.0);
        down = (down - z - 0.5).max(0.0);
        if up > 5.0 || down > 5.0 {
            (up, down, count) = (0.0, 0.0, count + 1);
        }
    }
    count
}
