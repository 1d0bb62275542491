//! How far the mean of a dwell is known: from the Allan variance within dwells, so that flicker is counted.
//!
//! The Allan variance of pairs of means over tau, pooled over dwells, is fitted by (IEEE Std 952, annex C)
//!
//! ```text
//! A(tau) = 3 Q^2/tau^2 + N^2/tau + 2 ln 2 h + K^2 tau/3
//! ```
//!
//! quantisation Q, white N, flicker of one-sided spectrum h/f, random walk K. The variance of a mean over T in a log
//! of length L is then 2 Q^2/T^2 + N^2/T + h (ln(L/T) + 3/2 - gamma - ln 2 pi) + K^2 T/3: the integral of each spectrum
//! times sinc^2(pi f T), flicker from f = 1/L on. What walks from dwell to dwell beyond that is a change of the gyro
//! and not an error of a mean.

/// Sum of squares of differences between neighbouring means over `tau_s`, halved: `pairs` times the Allan variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Octave {
    pub tau_s: f64,
    pub pairs: f64,
    pub variance: f64,
}

/// Noise of one channel, in its unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Noise {
    /// 3 Q^2, N^2, 2 ln 2 h, K^2/3: the parts of the Allan variance at tau = 1 s.
    parts: [f64; 4],
}

/// Octaves below the longest that are fitted: what filters do to shorter times says nothing of a dwell's mean.
const OCTAVES: usize = 8;
const ROUNDS: usize = 1000;
/// What quantisation and walk must gain in minus twice the logarithm of the likelihood.
const FURTHER: f64 = 3.0;
/// What slow noise of their own must gain in it for turns.
const OTHER_NOISE: f64 = 9.0;
const EULER: f64 = 0.577_215_664_901_532_9;

fn used(octaves: &[Octave]) -> Vec<&Octave> {
    let longest = octaves.iter().map(|o| o.tau_s).fold(0.0, f64::max);
    let least = longest / 2f64.powi(OCTAVES as i32);
    octaves.iter().filter(|o| o.tau_s > least && o.pairs > 0.0).collect()
}

fn powers(tau: f64) -> [f64; 4] {
    [tau.powi(-2), tau.recip(), 1.0, tau]
}

/// The free parts at the likelihood's top, from a start; a part that is zero stays so.
fn climbed(octaves: &[&Octave], mut parts: [f64; 4], free: [bool; 4]) -> Noise {
    for _ in 0..ROUNDS {
        let (mut up, mut down) = ([0.0; 4], [0.0; 4]);
        for octave in octaves {
            let at = powers(octave.tau_s);
            let model: f64 = at.iter().zip(&parts).map(|(a, p)| a * p).sum::<f64>().max(1e-300);
            for k in 0..4 {
                up[k] += octave.pairs * at[k] * octave.variance / (model * model);
                down[k] += octave.pairs * at[k] / model;
            }
        }
        for k in (0..4).filter(|&k| free[k]) {
            parts[k] *= (up[k] / down[k]).sqrt();
        }
    }
    Noise { parts }
}

/// Allan variances of means `values` over `step_s` seconds each, over octaves and over half of the whole. Each counts
/// by its weight, so that of counts the mean over any window is right to a pulse.
pub fn octaves(values: &[f64], weights: &[f64], step_s: f64) -> Vec<Octave> {
    let (mut sums, mut weight) = (vec![0.0], vec![0.0]);
    let origin = values.first().copied().unwrap_or_default();
    for (k, (value, own)) in values.iter().zip(weights).enumerate() {
        sums.push(sums[k] + own * (value - origin));
        weight.push(weight[k] + own);
    }
    let half = values.len() / 2;
    let mut widths: Vec<usize> = std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|&m| m <= half).collect();
    if widths.last().is_some_and(|&last| 5 * half >= 6 * last) {
        widths.push(half);
    }
    let octave = |m: usize| {
        let mean = |k: usize| (sums[(k + 1) * m] - sums[k * m]) / (weight[(k + 1) * m] - weight[k * m]);
        let pairs = values.len() / (2 * m);
        let squares: f64 = (0..pairs).map(|k| (mean(2 * k + 1) - mean(2 * k)).powi(2)).sum();
        Octave { tau_s: m as f64 * step_s, pairs: pairs as f64, variance: 0.5 * squares / pairs as f64 }
    };
    widths.into_iter().map(octave).collect()
}

impl Noise {
    /// Fits the octaves of all dwells of one channel.
    ///
    /// Each octave's variance is a mean of squares of normal values, so the likelihood is that of a chi-squared
    /// variance; the parts stay positive (multiplicative steps, which never lower it). Quantisation and walk are taken
    /// in only where the likelihood asks for them: of few dwells the long octaves are mere chance. A counter rounds to
    /// a `pulse`, 3 Q^2 = pulse^2/4, also where a steady rate does not show it.
    pub fn fit(octaves: &[Octave], pulse: f64) -> Self {
        let used = used(octaves);
        if used.iter().all(|o| o.variance <= 0.0) {
            return Self { parts: [0.25 * pulse * pulse, 0.0, 0.0, 0.0] };
        }
        let mut fit = Self::likeliest(&used);
        fit.parts[0] = fit.parts[0].max(0.25 * pulse * pulse);
        let longest = used.iter().map(|o| o.tau_s).fold(0.0, f64::max);
        // Of counts, where rounding hides what else there is.
        if pulse > 0.0 && fit.parts[0] > longest * fit.parts[1] {
            fit.parts[2] = fit.expected_flicker(&used);
        }
        fit
    }

    /// Noise at rest and in turns. What is taken out of a turn takes slow noise with it: that of rest holds for turns
    /// too, unless they plainly have more.
    pub fn fit_both(still: &[Octave], turning: &[Octave], pulse: f64) -> [Self; 2] {
        let [one, own] = [still, turning].map(|octaves| Self::fit(octaves, pulse));
        if still.is_empty() || turning.is_empty() {
            return [one, own];
        }
        let [q, n, ..] = own.parts;
        let [.., h, k] = one.parts;
        let used = used(turning);
        let start = [q.max(f64::MIN_POSITIVE), n.max(f64::MIN_POSITIVE), h, k];
        let mut of_rest = climbed(&used, start, [true, true, false, false]);
        of_rest.parts[0] = of_rest.parts[0].max(0.25 * pulse * pulse);
        if of_rest.misfit(&used) - own.misfit(&used) <= OTHER_NOISE {
            return [one, of_rest];
        }
        [one, Self { parts: [q, n, h.max(own.parts[2]), k.max(own.parts[3])] }]
    }

    fn likeliest(used: &[&Octave]) -> Self {
        let longest = used.iter().map(|o| o.tau_s).fold(0.0, f64::max);
        let least = longest / 2f64.powi(OCTAVES as i32);
        let level = used.iter().map(|o| o.variance).fold(0.0, f64::max);
        // A start at which every part matters somewhere.
        let middle = (longest * least).sqrt();
        let start = powers(middle).map(|p| 0.25 * level / p);
        let models = [[0.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.0], [1.0; 4]];
        let fits = models.iter().zip([0.0, 1.0, 2.0]).map(|(model, further)| {
            let mut parts = start;
            parts.iter_mut().zip(model).for_each(|(part, there)| *part *= there);
            let fit = climbed(used, parts, [true; 4]);
            (fit.misfit(used) + FURTHER * further, fit)
        });
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Self::default, |(_, fit)| fit)
    }

    /// The mean of flicker by its likelihood, the other parts held. Quantisation hides flicker of a dwell's own size:
    /// the likeliest would be none in one log and twice too much in the next.
    fn expected_flicker(&self, octaves: &[&Octave]) -> f64 {
        const POINTS: usize = 200;
        const UNLIKELY: f64 = 20.0;
        let [q, n, likeliest, k] = self.parts;
        let misfit = |h: f64| Self { parts: [q, n, h, k] }.misfit(octaves);
        let level = octaves.iter().map(|o| o.variance).fold(0.0, f64::max);
        let (mut top, most) = (likeliest.max(1e-12 * level), misfit(likeliest) + UNLIKELY);
        while misfit(top) < most && top < level {
            top *= 2.0;
        }
        let points: Vec<f64> = (0..POINTS).map(|k| top * (k as f64 + 0.5) / POINTS as f64).collect();
        let misfits: Vec<f64> = points.iter().map(|&h| misfit(h)).collect();
        let least = misfits.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = misfits.iter().map(|misfit| (0.5 * (least - misfit)).exp()).collect();
        points.iter().zip(&weights).map(|(h, weight)| h * weight).sum::<f64>() / weights.iter().sum::<f64>()
    }

    /// Minus twice the logarithm of the likelihood.
    fn misfit(&self, octaves: &[&Octave]) -> f64 {
        let of = |o: &&Octave| {
            let model = self.allan(o.tau_s).max(1e-300);
            o.pairs * (model.ln() + o.variance / model)
        };
        octaves.iter().map(of).sum()
    }

    /// The Allan variance at tau (s): the sum over the parts of quantisation, white noise, flicker and random walk
    /// (IEEE Std 952, annex C), in the squared unit of the samples.
    pub fn allan(&self, tau_s: f64) -> f64 {
        powers(tau_s).iter().zip(&self.parts).map(|(power, part)| power * part).sum()
    }

    /// Standard deviation of white noise in a mean over one second, N: unit of the samples times sqrt(s).
    pub fn white(&self) -> f64 {
        self.parts[1].sqrt()
    }

    /// Floor of the Allan deviation of flicker, sqrt(2 ln 2 h), in the unit of the samples.
    pub fn flicker(&self) -> f64 {
        self.parts[2].sqrt()
    }

    /// Whether white noise is most of the Allan variance at tau (s).
    pub fn is_white(&self, tau_s: f64) -> bool {
        self.parts[1] / tau_s > 0.5 * self.allan(tau_s)
    }

    /// The same with white noise of `times` the variance.
    pub fn with_white(&self, times: f64) -> Self {
        let [q, n, h, k] = self.parts;
        Self { parts: [q, n * times, h, k] }
    }

    /// Standard error of a mean over `dwell_s` of which `observed_s` were sampled, in a log of `log_s`.
    pub fn standard_error(&self, dwell_s: f64, observed_s: f64, log_s: f64) -> f64 {
        let [q, n, h, k] = self.parts;
        let lowest = ((log_s / dwell_s).max(1.0).ln() + 1.5 - EULER - std::f64::consts::TAU.ln()).max(1.0);
        let flicker = h / (2.0 * std::f64::consts::LN_2) * lowest;
        (2.0 / 3.0 * q / (dwell_s * dwell_s) + n / observed_s + flicker + k * dwell_s).sqrt()
    }
}
