//! How well the noise of a gyro is known: from its own scatter, and from the other gyros' where they are alike.
//!
//! One station states the standard errors of all gyros by one procedure, so a factor by which they are wrong is wrong
//! for all of them. Known from one gyro alone, with some seventy degrees of freedom, that factor costs an effect at
//! the limit of detection a seventh of its evidence; known from three, a twentieth.

/// Sum of squares over the stated variances, and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatter {
    pub rss: f64,
    pub nu: f64,
}

impl Scatter {
    /// The variance over the stated one.
    pub fn variance(&self) -> f64 {
        self.rss / self.nu
    }
}

/// Standard deviations by which a gyro's scatter may differ from that of all.
const ALIKE: f64 = 3.0;

/// Gives every gyro the scatter of all, where no gyro differs from it beyond chance: a gyro whose standard errors are
/// wrong in a way of their own, or that has an effect which stands out, is judged by itself, and so are the others
/// then. Answers which.
pub(crate) fn pool(gyros: &mut [Scatter]) -> bool {
    let all = gyros
        .iter()
        .fold(Scatter { rss: 0.0, nu: 0.0 }, |sum, own| Scatter { rss: sum.rss + own.rss, nu: sum.nu + own.nu });
    let alike = |own: &Scatter| (own.variance() / all.variance()).ln().abs() <= ALIKE * (2.0 / own.nu).sqrt();
    let pooled = gyros.iter().all(alike);
    if pooled {
        gyros.fill(all);
    }
    pooled
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pooled(rss: [f64; 3]) -> Vec<Scatter> {
        let mut gyros = rss.map(|rss| Scatter { rss, nu: 70.0 }).to_vec();
        pool(&mut gyros);
        gyros
    }

    #[test]
    fn gyros_that_scatter_alike_know_their_noise_from_one_another() {
        assert_eq!(pooled([60.0, 75.0, 81.0]), vec![Scatter { rss: 216.0, nu: 210.0 }; 3]);
    }

    #[test]
    fn a_gyro_that_differs_beyond_chance_is_judged_by_itself() {
        // A variance three times the others' is some four standard deviations off.
        let alone = pooled([70.0, 70.0, 210.0]);
        assert_eq!(alone.iter().map(|own| own.rss).collect::<Vec<_>>(), [70.0, 70.0, 210.0]);
        assert!(alone.iter().all(|own| own.nu == 70.0));
    }
}
