//! Chance in the output of one gyro: white noise, wander of the bias, and the grain of the counter.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::core::fault::Faults;

use super::programme::Planned;
use super::scenario::OutputNoise;
use super::{SECONDS_PER_HOUR, gaussian};
use crate::core::message::text;
use crate::message;

/// Correlation times of the Gauss-Markov processes that together make up the bias instability: over two decades
/// their sum has the flat Allan deviation of flicker noise.
const INSTABILITY_TIMES_H: [f64; 5] = [0.03, 0.1, 0.3, 1.0, 3.0];
/// Sub-intervals over which a Gauss-Markov process is averaged within a dwell.
const STEPS_A_DWELL: usize = 6;

impl OutputNoise {
    /// Checks that every figure makes sense.
    ///
    /// # Errors
    /// Each figure that is negative or not finite, and a correlation above 1, by its JSON pointer.
    pub fn check(&self) -> Result<(), Faults> {
        let mut faults = Faults::default();
        for (name, value) in [
            ("angle_random_walk_deg_per_sqrt_h", self.angle_random_walk_deg_per_sqrt_h),
            ("rate_noise_ppm", self.rate_noise_ppm),
            ("bias_instability_deg_per_h", self.bias_instability_deg_per_h),
            ("rate_random_walk_deg_per_h_sqrt_h", self.rate_random_walk_deg_per_h_sqrt_h),
            ("turn_on_bias_deg_per_h", self.turn_on_bias_deg_per_h),
            ("pulse_quantum", self.pulse_quantum),
            ("correlation", self.correlation),
            ("growth", self.growth),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(format!("/noise/{name}"), message!("not_zero_or_more", value = text(value)));
            }
        }
        if self.correlation > 1.0 {
            faults.push("/noise/correlation", message!("not_zero_or_more", value = text(1.0 - self.correlation)));
        }
        faults.or(())
    }

    /// How much larger the white noise is than at first, after this share of the campaign's time.
    pub fn grown(&self, share: f64) -> f64 {
        self.growth.powf(share)
    }

    /// Standard deviation of the mean output over a dwell, pulse/s, white noise and grain together.
    ///
    /// N/sqrt(T) deg/h from angle random walk, a share of the input rate, and q/(T sqrt 6) from the difference of two
    /// truncated counts.
    pub fn white_sd_pulse_s(&self, duration_s: f64, w_input_arcsec_s: f64, scale_factor: f64) -> f64 {
        let walk = self.angle_random_walk_deg_per_sqrt_h / (duration_s / SECONDS_PER_HOUR).sqrt();
        let uneven = 1e-6 * self.rate_noise_ppm * w_input_arcsec_s;
        let grain = self.pulse_quantum / (duration_s * 6.0_f64.sqrt());
        (scale_factor * walk).hypot(scale_factor * uneven).hypot(grain)
    }

    /// The counter's mean over a dwell: the difference of two truncated counts, whose phase is unknown.
    pub fn counted(&self, output_pulse_s: f64, duration_s: f64, rng: &mut ChaCha8Rng) -> f64 {
        if self.pulse_quantum == 0.0 {
            return output_pulse_s;
        }
        let phase: f64 = rng.random();
        let quanta = output_pulse_s * duration_s / self.pulse_quantum;
        (quanta + phase).floor() * self.pulse_quantum / duration_s
    }
}

/// White noise of the mean over a dwell of `duration_s` seconds, pulse/s, without the grain (which
/// [`OutputNoise::counted`] makes): sd (sqrt(r) shared + sqrt(1 - r) own), with r the correlation between gyros,
/// `shared` the standard normal deviate that all of them have in common, and sd that of
/// [`OutputNoise::white_sd_pulse_s`] at the rate `w_input` about the input axis.
pub fn white(
    noise: &OutputNoise,
    duration_s: f64,
    w_input: f64,
    scale_factor: f64,
    shared: f64,
    rng: &mut ChaCha8Rng,
) -> f64 {
    let smooth = OutputNoise { pulse_quantum: 0.0, ..noise.clone() };
    let deviate = noise.correlation.sqrt() * shared + (1.0 - noise.correlation).sqrt() * gaussian(rng);
    smooth.white_sd_pulse_s(duration_s, w_input, scale_factor) * deviate
}

/// How the bias of one gyro wanders: its mean over each dwell, deg/h.
pub fn bias_wander(noise: &OutputNoise, plan: &[Planned], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut bias = rate_random_walk(noise.rate_random_walk_deg_per_h_sqrt_h, plan, rng);
    let each = noise.bias_instability_deg_per_h / (INSTABILITY_TIMES_H.len() as f64).sqrt();
    for tau_h in INSTABILITY_TIMES_H {
        add(&mut bias, &gauss_markov(each, tau_h, plan, rng));
    }
    add(&mut bias, &turn_on(noise.turn_on_bias_deg_per_h, plan, rng));
    bias
}

fn add(to: &mut [f64], more: &[f64]) {
    to.iter_mut().zip(more).for_each(|(t, m)| *t += m);
}

/// Brownian motion K W(t): its mean over a dwell given both ends is their mean with variance K^2 T/12.
fn rate_random_walk(k: f64, plan: &[Planned], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (mut level, mut clock_h) = (0.0, 0.0);
    plan.iter()
        .map(|dwell| {
            let (start, length) = (dwell.start_s / SECONDS_PER_HOUR, dwell.duration_s / SECONDS_PER_HOUR);
            let at_start = level + k * (start - clock_h).max(0.0).sqrt() * gaussian(rng);
            let at_end = at_start + k * length.sqrt() * gaussian(rng);
            (level, clock_h) = (at_end, start + length);
            0.5 * (at_start + at_end) + k * (length / 12.0).sqrt() * gaussian(rng)
        })
        .collect()
}

/// Stationary Gauss-Markov process of standard deviation `sd`, averaged over each dwell.
fn gauss_markov(sd: f64, tau_h: f64, plan: &[Planned], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut x = sd * gaussian(rng);
    let mut clock_h = 0.0;
    let mut at = |t_h: f64| {
        let kept = (-(t_h - clock_h).max(0.0) / tau_h).exp();
        x = kept * x + sd * (1.0 - kept * kept).sqrt() * gaussian(rng);
        clock_h = t_h;
        x
    };
    plan.iter()
        .map(|dwell| {
            let step_h = dwell.duration_s / SECONDS_PER_HOUR / STEPS_A_DWELL as f64;
            let start_h = dwell.start_s / SECONDS_PER_HOUR;
            let sum: f64 = (0..STEPS_A_DWELL).map(|s| at(start_h + (s as f64 + 0.5) * step_h)).sum();
            sum / STEPS_A_DWELL as f64
        })
        .collect()
}

fn turn_on(sd: f64, plan: &[Planned], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let powered = plan.last().map_or(0, |dwell| dwell.power_up + 1);
    let levels: Vec<f64> = (0..powered).map(|k| if k == 0 { 0.0 } else { sd * gaussian(rng) }).collect();
    plan.iter().map(|dwell| levels[dwell.power_up]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::programme::{Programme, plan};
    use crate::simulate::{Stream, random};

    /// Dwells end to end, without pauses.
    fn contiguous(cycles: usize, dwell_s: f64) -> Vec<Planned> {
        let programme =
            Programme { rates_arcsec_s: vec![], repeats: 0, cycles, dwell_s, settle_s: 0.0, ..Default::default() };
        plan(&programme, 0.6, &mut random(1, Stream::Programme)).unwrap()
    }

    /// Allan variance of means at `m` dwells.
    fn allan(means: &[f64], m: usize) -> f64 {
        let clusters: Vec<f64> = means.chunks_exact(m).map(|c| c.iter().sum::<f64>() / m as f64).collect();
        let d: Vec<f64> = clusters.windows(2).map(|p| (p[1] - p[0]).powi(2)).collect();
        d.iter().sum::<f64>() / (2.0 * d.len() as f64)
    }

    #[test]
    fn white_noise_averages_down_with_the_root_of_time() {
        let noise = OutputNoise { rate_noise_ppm: 0.0, ..Default::default() };
        let mut rng = random(2, Stream::Noise);
        let means: Vec<f64> = (0..40_000).map(|_| white(&noise, 180.0, 0.0, 1.0, 0.0, &mut rng)).collect();
        // sigma^2(tau) = N^2/tau of IEEE 952, tau in hours.
        for m in [1, 4, 16] {
            let expected = noise.angle_random_walk_deg_per_sqrt_h.powi(2) / (m as f64 * 0.05);
            assert!((allan(&means, m) / expected - 1.0).abs() < 0.1, "{m}: {}", allan(&means, m) / expected);
        }
    }

    #[test]
    fn rate_random_walk_has_the_allan_variance_of_the_standard() {
        let noise = OutputNoise { rate_random_walk_deg_per_h_sqrt_h: 0.01, ..Default::default() };
        let dwells = contiguous(600, 180.0);
        let means = bias_wander(&noise, &dwells, &mut random(7, Stream::Noise));
        // sigma^2(tau) = K^2 tau/3 of IEEE 952.
        for m in [1, 4] {
            let expected = 0.01_f64.powi(2) * (m as f64 * 0.05) / 3.0;
            let ratio = allan(&means, m) / expected;
            assert!((ratio - 1.0).abs() < 0.08, "{m}: {ratio}");
        }
    }

    #[test]
    fn bias_instability_has_a_flat_allan_deviation_over_its_decades() {
        let noise = OutputNoise { bias_instability_deg_per_h: 0.01, ..Default::default() };
        let dwells = contiguous(1200, 180.0);
        let means = bias_wander(&noise, &dwells, &mut random(9, Stream::Noise));
        let deviations: Vec<f64> = [1, 2, 4, 8, 16].iter().map(|&m| allan(&means, m).sqrt()).collect();
        let (least, most) =
            (deviations.iter().copied().fold(f64::MAX, f64::min), deviations.iter().copied().fold(0.0, f64::max));
        assert!(most / least < 1.35, "{deviations:?}");
        let power = means.iter().map(|x| x * x).sum::<f64>() / means.len() as f64;
        assert!((0.007..0.011).contains(&power.sqrt()), "{}", power.sqrt());
    }

    #[test]
    fn a_counter_steps_by_its_quantum_and_is_right_on_average() {
        let noise = OutputNoise { pulse_quantum: 1.0, angle_random_walk_deg_per_sqrt_h: 0.0, ..Default::default() };
        let mut rng = random(4, Stream::Noise);
        let true_rate = 3.217_4;
        let counted: Vec<f64> = (0..20_000).map(|_| noise.counted(true_rate, 180.0, &mut rng) * 180.0).collect();
        assert!(counted.iter().all(|c| (c - c.round()).abs() < 1e-9 && (c - true_rate * 180.0).abs() < 1.0));
        let mean = counted.iter().sum::<f64>() / counted.len() as f64;
        assert!((mean / 180.0 - true_rate).abs() < 1e-4);
        // Over all fractions of a pulse the mean square of the truncation is 1/6.
        let errors: f64 = (0..60_000)
            .map(|k| {
                let rate = 2.0 + f64::from(k) / 60_000.0 / 180.0;
                (noise.counted(rate, 180.0, &mut rng) - rate).powi(2)
            })
            .sum::<f64>()
            / 60_000.0;
        let stated = noise.white_sd_pulse_s(180.0, 0.0, 1.0).powi(2);
        assert!((errors / stated - 1.0).abs() < 0.03, "{}", errors / stated);
    }

    #[test]
    fn bias_changes_between_power_ups_only() {
        let noise = OutputNoise { turn_on_bias_deg_per_h: 0.1, ..Default::default() };
        let programme = Programme { power_ups: 3, ..Default::default() };
        let dwells = plan(&programme, 0.6, &mut random(1, Stream::Programme)).unwrap();
        let bias = bias_wander(&noise, &dwells, &mut random(3, Stream::Noise));
        assert_eq!(dwells.last().unwrap().power_up, 2);
        for (pair, levels) in dwells.windows(2).zip(bias.windows(2)) {
            assert_eq!(pair[0].power_up == pair[1].power_up, levels[0] == levels[1]);
        }
    }

    #[test]
    fn a_negative_noise_is_refused_by_name() {
        let noise = OutputNoise { pulse_quantum: -1.0, ..Default::default() };
        assert_eq!(noise.check().unwrap_err().0[0].pointer, "/noise/pulse_quantum");
    }
}
