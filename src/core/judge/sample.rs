//! What a history is made of: figures with their standard deviations, and records.

use super::coefficient::Coefficient;
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;

/// A baseline is the median of this many records after the last mark that resets it.
pub const BASELINE_RECORDS: usize = 3;

/// The same figures to the last bit within so many days are one measurement that was sent with several times.
const REPEATED_WITHIN_DAYS: f64 = 1.0;

/// A figure and its standard deviation, where the station gave what it takes to know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    pub value: f64,
    pub sd: Option<f64>,
}

impl Measured {
    /// A value whose standard deviation is unknown.
    pub fn exact(value: f64) -> Self {
        Self { value, sd: None }
    }

    /// Its magnitude.
    pub(crate) fn size(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    /// In units of `of`, which is more than zero.
    pub fn in_units_of(self, of: f64) -> Self {
        Self { value: self.value / of, sd: self.sd.map(|sd| sd / of) }
    }

    /// With another standard deviation beside its own.
    #[must_use]
    pub(crate) fn beside(self, sd: f64) -> Self {
        if sd == 0.0 { self } else { Self { sd: Some(self.sd.unwrap_or(0.0).hypot(sd)), ..self } }
    }

    /// `self - earlier`, the two taken as independent campaigns.
    pub(crate) fn minus(self, earlier: Self) -> Self {
        let sd = self.sd.zip(earlier.sd).map(|(a, b)| (a * a + b * b).sqrt());
        Self { value: self.value - earlier.value, sd }
    }

    /// Median of three independent figures, the earlier one of two; its standard deviation is known when all of
    /// theirs are.
    ///
    /// The variance of the median of three normal figures with one mean and variances a, b, c is, from E[max^2] =
    /// E[min^2], (a + b + c)/2 - (1/pi)(sum a asin(a/sqrt((a+b)(a+c))) + sqrt(ab + bc + ca)): 0.449 a where they are
    /// equal, a where one of them is worth nothing.
    pub fn median(of: &[Self]) -> Option<Self> {
        let [a, b, c] = *of else { return of.first().copied() };
        let mut values = [a.value, b.value, c.value];
        values.sort_unstable_by(f64::total_cmp);
        let variances = a.sd.zip(b.sd).zip(c.sd).map(|((a, b), c)| [a * a, b * b, c * c]);
        Some(Self { value: values[1], sd: variances.map(|variances| median_variance(variances).sqrt()) })
    }
}

fn median_variance(variances: [f64; 3]) -> f64 {
    let largest = variances.into_iter().fold(0.0, f64::max);
    if largest == 0.0 {
        return 0.0;
    }
    let [a, b, c] = variances.map(|variance| variance / largest);
    let root = (a * b + b * c + c * a).sqrt();
    // asin(a/sqrt((a+b)(a+c))) = atan(a/root), which loses nothing near pi/2.
    let sum = [a, b, c].into_iter().map(|variance| variance * variance.atan2(root)).sum::<f64>() + root;
    largest * (0.5 * (a + b + c) - sum / std::f64::consts::PI).max(0.0)
}

/// D_I, D_S, and the closure.
pub(super) const COLUMNS: usize = 3;

/// Where a gyro is mounted: the number of its IMU, and the slot there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Seat {
    pub imu: u32,
    pub slot: Slot,
}

/// One gyro in one calibration record: the row that the store keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    pub at: UtcMicros,
    pub seat: Seat,
    /// Number of the station that measured it.
    pub station: u32,
    /// D_I, D_S, and the closure (D_O, or the published closure where that method is judged), deg/(h g0).
    pub d: [Measured; COLUMNS],
}

impl Sample {
    /// D_I, D_S or the closure; none of any other coefficient.
    pub fn get(&self, coefficient: Coefficient) -> Option<Measured> {
        coefficient.column().map(|column| self.d[column])
    }

    /// Whether it is the measurement of `earlier` once more, sent with another time: no rule counts it again.
    pub fn repeats(&self, earlier: &Self) -> bool {
        let same = |a: &Measured, b: &Measured| {
            a.value.to_bits() == b.value.to_bits() && a.sd.map(f64::to_bits) == b.sd.map(f64::to_bits)
        };
        self.at.days_since(earlier.at).abs() < REPEATED_WITHIN_DAYS
            && self.d.iter().zip(&earlier.d).all(|(a, b)| same(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_a_median_of_three_is_that_of_sorted_normal_figures() {
        // 0.448671 for equal ones is tabled (order statistics of three); the others by integrating x^2 over the
        // density of the median, sum f_i [F_j (1 - F_k) + F_k (1 - F_j)], with 4,000 steps.
        let density = |x: f64, sd: f64| (-0.5 * x * x / (sd * sd)).exp() / (sd * (2.0 * std::f64::consts::PI).sqrt());
        let below = |x: f64, sd: f64| crate::core::numerics::normal::normal_cdf(x / sd);
        let integrated = |sds: [f64; 3]| {
            let end = 9.0 * sds.iter().copied().fold(0.0, f64::max);
            let step = end / 2000.0;
            let at = |k: i32| {
                let x = f64::from(k) * step;
                let one = |i: usize, j: usize, k: usize| {
                    let (fj, fk) = (below(x, sds[j]), below(x, sds[k]));
                    density(x, sds[i]) * (fj * (1.0 - fk) + fk * (1.0 - fj))
                };
                x * x * (one(0, 1, 2) + one(1, 0, 2) + one(2, 0, 1)) * step
            };
            (-2000..=2000).map(at).sum::<f64>()
        };
        assert!((median_variance([1.0; 3]) - 0.448_671).abs() < 1e-6);
        for sds in [[1.0, 1.0, 1.0], [1.0, 2.0, 3.0], [0.5, 0.5, 4.0], [1.0, 1.0, 0.1]] {
            let exact = median_variance(sds.map(|sd| sd * sd));
            assert!((exact / integrated(sds) - 1.0).abs() < 2e-3, "{sds:?}: {exact} {}", integrated(sds));
        }
        assert!((median_variance([1.0, 1.0, 1e12]) - 1.0).abs() < 1e-3, "one of them is worth nothing");
        assert_eq!((median_variance([0.0; 3]), median_variance([0.0, 0.0, 4.0])), (0.0, 0.0));
    }

    #[test]
    fn a_median_takes_the_middle_figure_and_of_two_the_earlier() {
        let of = |values: &[f64]| {
            let all: Vec<Measured> = values.iter().map(|value| Measured::exact(*value)).collect();
            Measured::median(&all).map(|median| median.value)
        };
        assert_eq!(
            [of(&[]), of(&[2.0]), of(&[2.0, 1.0]), of(&[9.0, 1.0, 2.0])],
            [None, Some(2.0), Some(2.0), Some(2.0)]
        );
    }

    #[test]
    fn the_same_figures_within_a_day_are_a_repeat_and_a_month_later_are_not() {
        let at = |day: f64, d_i: f64| {
            let d = [d_i, 5.0, 0.0].map(|value| Measured { value, sd: Some(1e-4) });
            Sample { at: UtcMicros(0).plus_days(day), seat: Seat::default(), station: 0, d }
        };
        assert!(at(0.9, 3.0).repeats(&at(0.0, 3.0)) && at(0.0, 3.0).repeats(&at(0.9, 3.0)));
        assert!(!at(1.0, 3.0).repeats(&at(0.0, 3.0)), "daily records of a gyro that shows the same figures");
        assert!(!at(0.5, 3.0 + 1e-15).repeats(&at(0.0, 3.0)));
        let noisy = Sample { d: at(0.0, 3.0).d.map(|of| Measured { sd: Some(0.2), ..of }), ..at(0.5, 3.0) };
        assert!(!noisy.repeats(&at(0.0, 3.0)), "other standard deviations are another measurement");
    }
}
