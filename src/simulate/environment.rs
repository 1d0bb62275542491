//! The temperature of the IMU through a campaign.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::core::fault::Faults;

use super::fault_at::fault;
use super::gaussian;
use super::scenario::{Profile, Temperature};
use crate::core::message::text;
use crate::message;

/// True temperature in deg C at each of the mid-times (hours, ascending).
pub fn temperatures(spec: &Temperature, mid_h: &[f64], rng: &mut ChaCha8Rng) -> Result<Vec<f64>, Faults> {
    for (name, value) in [("size_k", spec.size_k), ("time_h", spec.time_h), ("reading_sd_k", spec.reading_sd_k)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(fault(&format!("/temperature/{name}"), message!("not_zero_or_more", value = text(value))));
        }
    }
    if spec.time_h == 0.0 {
        return Err(fault("/temperature/time_h", message!("must_not_be_zero")));
    }
    let deviation: Vec<f64> = match spec.profile {
        Profile::Constant => vec![0.0; mid_h.len()],
        Profile::Ramp => ramp(spec.size_k, mid_h, rng),
        Profile::Cycle => {
            let phase = rng.random_range(0.0..std::f64::consts::TAU);
            let angle = |t: f64| std::f64::consts::TAU * t / spec.time_h + phase;
            mid_h.iter().map(|&t| spec.size_k * angle(t).sin()).collect()
        }
        Profile::Wander => wander(spec.size_k, spec.time_h, mid_h, rng),
    };
    Ok(deviation.into_iter().map(|d| spec.mean_c + d).collect())
}

/// From one end of the span to the other, up or down, with a thermostat's 2 per cent of wander on it: without any,
/// temperature and time would be one and the same.
fn ramp(span_k: f64, mid_h: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let end = mid_h.last().copied().unwrap_or(0.0).max(1e-9);
    let ripple = wander(0.02 * span_k, 0.1 * end, mid_h, rng);
    mid_h.iter().zip(ripple).map(|(&t, r)| sign * span_k * (t / end - 0.5) + r).collect()
}

/// Gauss-Markov process of standard deviation `sd` and correlation time `tau_h`.
fn wander(sd: f64, tau_h: f64, mid_h: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut x = 0.0;
    let mut before = None;
    mid_h
        .iter()
        .map(|&t| {
            let kept = before.map_or(0.0, |b: f64| (-(t - b) / tau_h).exp());
            x = kept * x + (1.0 - kept * kept).sqrt() * sd * gaussian(rng);
            before = Some(t);
            x
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Stream, random};

    #[test]
    fn a_wander_has_the_stated_spread_and_correlation() {
        let spec = Temperature { size_k: 0.5, time_h: 2.0, ..Default::default() };
        let mid_h: Vec<f64> = (0..40_000).map(|k| f64::from(k) * 0.5).collect();
        let t = temperatures(&spec, &mid_h, &mut random(1, Stream::Temperature)).unwrap();
        let d: Vec<f64> = t.iter().map(|x| x - 45.0).collect();
        let power = d.iter().map(|x| x * x).sum::<f64>() / d.len() as f64;
        let lag1 = d.windows(2).map(|p| p[0] * p[1]).sum::<f64>() / d.len() as f64;
        assert!((power.sqrt() - 0.5).abs() < 0.03, "{}", power.sqrt());
        assert!((lag1 / power - (-0.25_f64).exp()).abs() < 0.02);
    }

    #[test]
    fn a_ramp_spans_what_was_asked_and_a_constant_nothing() {
        let mid_h: Vec<f64> = (0..78).map(|k| f64::from(k) / 15.0).collect();
        let spec = Temperature { profile: Profile::Ramp, size_k: 2.0, ..Default::default() };
        let t = temperatures(&spec, &mid_h, &mut random(1, Stream::Temperature)).unwrap();
        assert!(((t[77] - t[0]).abs() - 2.0).abs() < 0.3);
        let spec = Temperature { profile: Profile::Constant, ..spec };
        assert_eq!(temperatures(&spec, &mid_h, &mut random(1, Stream::Temperature)).unwrap(), vec![45.0; 78]);
    }
}
