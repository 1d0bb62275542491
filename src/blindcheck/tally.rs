//! Proportions with honest intervals.

use serde::Serialize;

use crate::core::numerics::normal::normal_quantile;

/// Successes out of trials.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    pub hits: usize,
    pub trials: usize,
}

impl Tally {
    /// Counts one trial.
    pub fn add(&mut self, hit: bool) {
        self.hits += usize::from(hit);
        self.trials += 1;
    }

    /// Counts them all.
    pub fn of(hits: impl IntoIterator<Item = bool>) -> Self {
        let mut tally = Self::default();
        hits.into_iter().for_each(|hit| tally.add(hit));
        tally
    }

    /// Share of hits; none without trials.
    pub fn rate(&self) -> Option<f64> {
        (self.trials > 0).then(|| self.hits as f64 / self.trials as f64)
    }

    /// Wilson's score interval at 95 % (Wilson 1927): solves |p - hits/n| = z sqrt(p(1-p)/n) for p.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let p = self.rate()?;
        let n = self.trials as f64;
        let z = normal_quantile(0.975);
        let centre = p + z * z / (2.0 * n);
        let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        let scale = 1.0 + z * z / n;
        Some([((centre - half) / scale).max(0.0), ((centre + half) / scale).min(1.0)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_s_interval_is_the_published_one() {
        // Newcombe 1998, table I, method 3: 81 of 263 and 0 of 20.
        let [low, high] = Tally { hits: 81, trials: 263 }.interval().unwrap();
        assert!((low - 0.2553).abs() < 5e-5 && (high - 0.3662).abs() < 5e-5, "{low} {high}");
        let [low, high] = Tally { hits: 0, trials: 20 }.interval().unwrap();
        assert!(low.abs() < 1e-12 && (high - 0.1611).abs() < 5e-5, "{low} {high}");
    }

    #[test]
    fn without_trials_there_is_no_rate() {
        assert_eq!(Tally::default().rate(), None);
        assert_eq!(Tally::default().interval(), None);
    }
}
