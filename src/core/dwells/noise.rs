//! How far the mean of a dwell is known: from the Allan variance within dwells, so that flicker is counted.
//!
//! The Allan variance of pairs of means over tau, pooled over dwells, is fitted by (IEEE Std 952, annex C)
//!
//! ```text
//! A(tau) = 3 Q^2/tau^2 + N^2/tau + 2 ln 2 h + K^2 tau/3
//! ```
//!
//! quantisation Q, white N, flicker of one-sided spectrum h/f, random walk K. The variance of a mean over T in a log
//! of length L is then 2 Q^2/T^2 + N^2/T + h n ln n/(n - 1) + K^2 T/3: of flicker, that of n = L/T means about their
//! own mean (J. A. Barnes, NBS Technical Note 375, 1969, B1 for mu = 0), for what is common to a log belongs to the drift
//! coefficients. What walks from dwell to dwell beyond that is a change of the gyro and not an error of a mean.

/// Sum of squares of differences between neighbouring means over `tau_s`, halved: `pairs` times the Allan variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Octave {
    pub tau_s: f64,
    pub pairs: f64,
    pub variance: f64,
}

/// What the dwells of a gyro show, at rest and in turns, and one pulse of its counter.
#[derive(Debug, Clone)]
pub struct NoiseOctaves {
    pub still: Vec<Octave>,
    pub turning: Vec<Octave>,
    pub pulse: f64,
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
/// What each part must gain in minus twice the logarithm of the likelihood.
const GAIN: [f64; 4] = [3.0, 0.0, 1.0, 3.0];
const MODELS: [[f64; 4]; 5] =
    [[0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.0], [1.0; 4]];
/// What slow noise of their own must gain in it for a gyro and for turns.
const OTHER_NOISE: f64 = 9.0;
/// What a dwell's own rounding and white noise must gain in it.
const OWN_NOISE: f64 = 10.0;

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
    /// Noise of each gyro of a log, at rest and in turns.
    ///
    /// Few dwells say little of slow noise, and gyros of a kind have like ratios of it to the rest: those that all of
    /// them show together hold for each, unless it plainly has another. What is taken out of a turn takes slow noise
    /// with it: that of rest holds for turns too, unless they plainly have more.
    pub fn fit_all(gyros: &[NoiseOctaves]) -> Vec<[Self; 2]> {
        let mut still: Vec<Self> = gyros.iter().map(|gyro| Self::fit(&gyro.still, gyro.pulse)).collect();
        let longest = gyros.iter().flat_map(|gyro| &gyro.still).map(|o| o.tau_s).fold(0.0, f64::max);
        // In units of each one's noise at a time where all parts matter.
        let middle = longest / 2f64.powi(OCTAVES as i32 / 2);
        let units: Vec<f64> = still.iter().map(|own| own.allan(middle)).collect();
        let in_units = |(gyro, unit): (&NoiseOctaves, &f64)| -> Vec<Octave> {
            gyro.still.iter().map(|o| Octave { variance: o.variance / unit, ..*o }).collect()
        };
        let pooled = gyros.iter().zip(&units).filter(|(_, unit)| **unit > 0.0).flat_map(in_units);
        let [.., h, k] = Self::fit(&pooled.collect::<Vec<_>>(), 0.0).parts;
        for ((own, gyro), unit) in still.iter_mut().zip(gyros).zip(units) {
            *own = own.with_slow([h * unit, k * unit], &gyro.still, gyro.pulse).unwrap_or(*own);
        }
        let with_turns = |(rest, gyro): (&Self, &NoiseOctaves)| {
            let own = Self::fit(&gyro.turning, gyro.pulse);
            let ([q, n, h, k], [.., rest_h, rest_k]) = (own.parts, rest.parts);
            let more = Self { parts: [q, n, h.max(rest_h), k.max(rest_k)] };
            let alike = own.with_slow([rest_h, rest_k], &gyro.turning, gyro.pulse);
            [*rest, alike.filter(|_| !gyro.still.is_empty()).unwrap_or(more)]
        };
        still.iter().zip(gyros).map(with_turns).collect()
    }

    /// Fits the octaves of all dwells of one channel.
    ///
    /// Each octave's variance is a mean of squares of normal values, so the likelihood is that of a chi-squared
    /// variance; the parts stay positive (multiplicative steps, which never lower it). Parts but white noise are taken
    /// in only where the likelihood asks for them: of few dwells the long octaves are mere chance. A counter rounds to
    /// a `pulse`, 3 Q^2 = pulse^2/4, also where a steady rate does not show it.
    pub fn fit(octaves: &[Octave], pulse: f64) -> Self {
        let used = used(octaves);
        let longest = used.iter().map(|o| o.tau_s).fold(0.0, f64::max);
        let level = used.iter().map(|o| o.variance).fold(0.0, f64::max);
        if level <= 0.0 {
            return Self::default().rounded(pulse);
        }
        // A start at which every part matters somewhere.
        let start = powers(longest / 2f64.powi(OCTAVES as i32).sqrt()).map(|p| 0.25 * level / p);
        let fits = MODELS.iter().map(|model| {
            let fit = climbed(&used, [0, 1, 2, 3].map(|k| start[k] * model[k]), [true; 4]);
            let asked: f64 = model.iter().zip(GAIN).map(|(there, gain)| there * gain).sum();
            (fit.misfit(&used) + asked, fit)
        });
        let fit = fits.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Self::default, |(_, fit)| fit).rounded(pulse);
        let [q, n, _, k] = fit.parts;
        let is_hidden = q > longest * n;
        if is_hidden { Self { parts: [q, n, fit.expected_flicker(&used), k] } } else { fit }
    }

    /// The mean of flicker by its likelihood, the other parts held, its standard deviation as likely beforehand at any
    /// value. Rounding hides flicker of a dwell's own size: the likeliest would be none in one log and twice too much
    /// in the next.
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
        let points: Vec<f64> = (0..POINTS).map(|k| top * ((k as f64 + 0.5) / POINTS as f64).powi(2)).collect();
        let misfits: Vec<f64> = points.iter().map(|&h| misfit(h)).collect();
        let least = misfits.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = misfits.iter().map(|misfit| (0.5 * (least - misfit)).exp()).collect();
        points.iter().zip(&weights).map(|(h, weight)| h * weight).sum::<f64>() / weights.iter().sum::<f64>()
    }

    /// The same with no less quantisation than rounding to a pulse makes.
    fn rounded(mut self, pulse: f64) -> Self {
        self.parts[0] = self.parts[0].max(0.25 * pulse * pulse);
        self
    }

    /// The same channel with flicker and walk of others; none where its octaves are plainly not of such.
    fn with_slow(&self, [h, k]: [f64; 2], octaves: &[Octave], pulse: f64) -> Option<Self> {
        let (used, [q, n, ..]) = (used(octaves), self.parts);
        let fit = Self { parts: [q, n, h, k] }.beside_slow(&used, pulse);
        (!used.is_empty() && fit.misfit(&used) - self.misfit(&used) <= OTHER_NOISE).then_some(fit)
    }

    /// The same with rounding and white noise of one dwell alone, where they plainly are others.
    pub fn with_own(&self, octaves: &[Octave], pulse: f64) -> Self {
        let used = used(octaves);
        let own = self.beside_slow(&used, pulse);
        if self.misfit(&used) - own.misfit(&used) > OWN_NOISE { own } else { *self }
    }

    /// Rounding and white noise at the likelihood's top from these, flicker and walk held.
    fn beside_slow(&self, octaves: &[&Octave], pulse: f64) -> Self {
        let [q, n, h, k] = self.parts;
        let start = [q.max(f64::MIN_POSITIVE), n.max(f64::MIN_POSITIVE), h, k];
        climbed(octaves, start, [true, true, false, false]).rounded(pulse)
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

    /// Standard error of a mean over `dwell_s` of which `observed_s` were sampled, in a log of `log_s`.
    pub fn standard_error(&self, dwell_s: f64, observed_s: f64, log_s: f64) -> f64 {
        let [q, n, h, k] = self.parts;
        let means = (log_s / dwell_s).max(2.0);
        let flicker = h / (2.0 * std::f64::consts::LN_2) * means * means.ln() / (means - 1.0);
        (2.0 / 3.0 * q / (dwell_s * dwell_s) + n / observed_s + flicker + k * dwell_s).sqrt()
    }
}
