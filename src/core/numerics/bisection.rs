//! Where a monotone condition changes.

/// Halves the interval from `low`, where `is_below` holds, to `high`, where it does not, so many times; answers its ends.
pub(crate) fn bisect(mut low: f64, mut high: f64, rounds: usize, is_below: impl Fn(f64) -> bool) -> (f64, f64) {
    for _ in 0..rounds {
        let middle = 0.5 * (low + high);
        if is_below(middle) { low = middle } else { high = middle }
    }
    (low, high)
}
