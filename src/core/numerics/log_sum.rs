//! Sums of what is only known by its logarithm.

/// ln of a sum of exponentials, kept in units of its largest term: one exponential a term, one logarithm in the end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LogSum {
    pub top: f64,
    pub sum: f64,
}

impl Default for LogSum {
    fn default() -> Self {
        Self { top: f64::NEG_INFINITY, sum: 0.0 }
    }
}

impl LogSum {
    /// Terms below this, in logarithms, do not change a sum of 1.
    const NOTHING: f64 = -37.0;

    /// Of terms that are given by their logarithms.
    pub fn of(logs: &[f64]) -> Self {
        let mut sum = Self::default();
        logs.iter().for_each(|log| sum.add(*log));
        sum
    }

    /// Of one term.
    pub fn of_one(log: f64) -> Self {
        Self { top: log, sum: 1.0 }
    }

    /// Adds e^`log`.
    pub fn add(&mut self, log: f64) {
        if log > self.top {
            self.sum = 1.0 + self.sum * (self.top - log).exp();
            self.top = log;
        } else if log - self.top > Self::NOTHING {
            self.sum += (log - self.top).exp();
        }
    }

    /// ln of the sum; minus infinity of nothing.
    pub fn log(&self) -> f64 {
        self.top + self.sum.ln()
    }

    /// The sum over `count`.
    pub fn mean(&self, count: usize) -> Self {
        Self { top: self.top, sum: self.sum / count as f64 }
    }

    /// ln of the sum over `count`.
    pub fn log_mean(&self, count: usize) -> f64 {
        self.mean(count).log()
    }
}
