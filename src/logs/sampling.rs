//! The sampling interval of a log by all of its stamps, and whether these jitter about regular sampling.

/// Stamps regressed on the numbers of their samples, lost ones counted; pauses begin another line of the same slope.
#[derive(Debug, Clone, Default)]
pub struct Sampling {
    seen: usize,
    /// The interval that stamps are compared with, s.
    nominal_s: f64,
    last_s: f64,
    /// Where number 0 would come, by the latest stamps, s.
    phase_s: f64,
    /// In the stretch since the last pause: samples, the number of the last, and means of numbers and deviations.
    count: f64,
    number: f64,
    means: [f64; 2],
    /// Over all stretches, about their means: squares of numbers, products, squares of deviations.
    sums: [f64; 3],
    samples: f64,
    /// Single steps, the sum of their deviations, and of these squared.
    steps: [f64; 3],
}

/// Stamps from which the interval is first taken.
const FIRST: usize = 256;
/// Intervals without a sample that are a pause.
const PAUSE: f64 = 20.0;
/// What the newest stamp weighs in the phase.
const OF_LATE: f64 = 0.125;
/// Variance about the line over that of steps, halved, up to which the sampling is regular.
const REGULAR: f64 = 1.2;
/// Part of an interval to which stamps are as good as regular.
const EXACT: f64 = 1e-3;
/// Stamps, at least, and part of the interval to which they have to tell it.
const FEWEST: f64 = 1000.0;
const TOLD: f64 = 1e-5;

impl Sampling {
    /// The next stamp, and the median interval of the first ones.
    pub fn see(&mut self, at_s: f64, interval_s: f64) {
        self.seen += 1;
        let step_s = at_s - std::mem::replace(&mut self.last_s, at_s);
        if self.seen <= FIRST {
            self.nominal_s = interval_s;
            return;
        }
        // From where stamps have come of late: from one late stamp alone the next would seem lost.
        let number = ((at_s - self.phase_s) / self.nominal_s).round();
        let begins = self.count == 0.0 || number - self.number > PAUSE;
        let number = if begins { 0.0 } else { number };
        if begins {
            self.pause();
            self.phase_s = at_s;
        }
        self.phase_s += OF_LATE * (at_s - number * self.nominal_s - self.phase_s);
        let intervals = number - std::mem::replace(&mut self.number, number);
        if intervals == 1.0 {
            let off = step_s - self.nominal_s;
            [1.0, off, off * off].iter().zip(&mut self.steps).for_each(|(own, sum)| *sum += own);
        }
        self.count += 1.0;
        self.samples += 1.0;
        let values = [self.number, at_s - self.number * self.nominal_s];
        let before = [values[0] - self.means[0], values[1] - self.means[1]];
        self.means.iter_mut().zip(before).for_each(|(mean, off)| *mean += off / self.count);
        let after = [values[0] - self.means[0], values[1] - self.means[1]];
        let own = [before[0] * after[0], before[0] * after[1], before[1] * after[1]];
        self.sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }

    /// What follows has a phase of its own.
    pub fn pause(&mut self) {
        (self.count, self.number, self.means) = (0.0, 0.0, [0.0; 2]);
    }

    /// The interval, where samples are regular and their stamps jitter.
    pub fn regular_s(&self) -> Option<f64> {
        let [numbers, products, deviations] = self.sums;
        let [steps, sum, squares] = self.steps;
        let slope = products / numbers;
        let about_line = (deviations - slope * products) / self.samples;
        let of_steps = squares / steps - (sum / steps).powi(2);
        let most = (REGULAR * 0.5 * of_steps).max((EXACT * self.nominal_s).powi(2));
        let sd = (about_line.max(0.0) / numbers).sqrt();
        let is_told = self.samples >= FEWEST && sd < TOLD * self.nominal_s;
        (is_told && about_line < most).then_some(self.nominal_s + slope)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn stamps_that_jitter_about_a_regular_clock_give_its_interval() {
        let seen = |jitter: f64, drift: f64| {
            let (mut sampling, mut rng) = (Sampling::default(), ChaCha8Rng::seed_from_u64(5));
            for k in (0..200_000).filter(|k| k % 997 != 0 && !(70_000..90_000).contains(k)) {
                let time = 0.01 * f64::from(k);
                let stamp = time + drift * time * time + jitter * rng.random_range(-1.0..1.0);
                sampling.see(stamp, 0.010_03);
            }
            sampling.regular_s()
        };
        let found = seen(1e-3, 0.0).unwrap();
        assert!((found - 0.01).abs() < 3e-10, "{found}");
        assert_eq!(seen(1e-3, 1e-8), None, "the clock runs ever slower");
        assert!((seen(0.0, 0.0).unwrap() - 0.01).abs() < 1e-10);
    }

    /// A stamp is late by a tenth of an interval, seldom by most of it: then a lost sample looks as if none was.
    #[test]
    fn stamps_that_are_late_lose_no_sample() {
        let (mut sampling, mut rng) = (Sampling::default(), ChaCha8Rng::seed_from_u64(6));
        for k in (0..400_000).filter(|k| k % 997 != 0) {
            let late = -1e-3 * rng.random_range(1e-4_f64..1.0).ln();
            sampling.see(0.01 * f64::from(k) + late, 0.01);
        }
        assert!((sampling.regular_s().unwrap() - 0.01).abs() < 1e-9);
    }

    #[test]
    fn few_stamps_tell_no_interval() {
        let (mut sampling, mut rng) = (Sampling::default(), ChaCha8Rng::seed_from_u64(7));
        for k in 0..260 {
            sampling.see(0.01 * f64::from(k) + 1e-3 * rng.random_range(-1.0..1.0), 0.01);
        }
        assert_eq!(sampling.regular_s(), None);
    }

    #[test]
    fn nothing_seen_is_not_regular() {
        assert_eq!(Sampling::default().regular_s(), None);
    }
}
