//! What a rule is given: the stretch of one gyro's history that it needs, oldest first, and what happened to the gyro.

use crate::core::time::UtcMicros;

use super::limits::Limits;
use super::{Coefficient, Older, Rule, Series, cells};
use crate::core::mounting::Slot;
use crate::core::named::named;

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
    pub fn exact(value: f64) -> Self {
        Self { value, sd: None }
    }

    /// `self - earlier`, the two taken as independent campaigns.
    pub(crate) fn minus(self, earlier: Self) -> Self {
        let sd = self.sd.zip(earlier.sd).map(|(a, b)| (a * a + b * b).sqrt());
        Self { value: self.value - earlier.value, sd }
    }

    /// Median of three independent figures, the earlier one of two; its standard deviation is known when all of theirs are.
    ///
    /// The variance of the median of three normal figures with one mean and variances a, b, c is, from E[max^2] = E[min^2],
    /// (a + b + c)/2 - (1/pi)(sum a asin(a/sqrt((a+b)(a+c))) + sqrt(ab + bc + ca)): 0.449 a where they are equal, a where one of
    /// them is worth nothing.
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
    /// D_I, D_S, and the closure (D_O, or the published closure where that method is judged), deg/(h g0).
    pub d: [Measured; COLUMNS],
}

impl Sample {
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

named! {
/// What was done to a gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Event("event_") {
    /// An engineer declares a new baseline.
    Baseline = "baseline",
    Repair = "repair",
    /// Taken out of an IMU and mounted again, there or elsewhere.
    Reinstallation = "reinstallation",
    Transport = "transport",
    Firmware = "firmware",
    Note = "note",
    /// An environmental test: the gyro is judged before and after.
    EnvironmentalTest = "environmental_test",
    /// Taken out of use for good.
    Retired = "retired",
    /// Not to be calibrated until it comes back.
    InStorage = "in_storage",
}
}

impl Event {
    /// Whether the next records form a new baseline.
    pub fn resets_baseline(self) -> bool {
        matches!(self, Event::Baseline | Event::Repair | Event::Reinstallation)
    }

    /// Whether no calibration is expected after it, until the next one comes.
    pub fn ends_calibrations(self) -> bool {
        matches!(self, Event::Retired | Event::InStorage)
    }

    /// Whether records before the event are not to be compared by `rule` with those after it.
    ///
    /// * A repair makes another gyro of it: everything restarts.
    /// * A baseline mark and a re-installation restart what is measured from a level (baseline, closure, trend,
    ///   shift, before_after). `step`, `range` and `rms_successive` go on: D_I and D_S belong to the gyro, not to its seat, and
    ///   a jump over a re-installation is what an engineer wants to see.
    /// * New firmware may change how pulses are counted: the control rules restart, the budgets hold.
    /// * Transport and environmental tests are what the budgets are there to survive; the rest changes nothing.
    pub fn resets(self, rule: Rule) -> bool {
        match self {
            Event::Repair => true,
            Event::Baseline | Event::Reinstallation => matches!(
                rule,
                Rule::Baseline | Rule::Closure | Rule::Trend | Rule::Shift | Rule::Cusum | Rule::BeforeAfter
            ),
            Event::Firmware => matches!(rule, Rule::Trend | Rule::Shift | Rule::Cusum),
            Event::Transport | Event::Note | Event::EnvironmentalTest | Event::Retired | Event::InStorage => false,
        }
    }
}

/// An event on a gyro's time line. It parts the records before `at` from those at or after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    pub at: UtcMicros,
    pub event: Event,
    /// When what began at `at` was over; none for what took no time.
    pub until: Option<UtcMicros>,
    /// Levels of what comes after it, where it begins a baseline and states them.
    pub fixed: FixedLevels,
}

/// D_I and D_S that are stated instead of measured, deg/(h g0).
pub type FixedLevels = [Option<Measured>; 2];

impl Mark {
    /// One that states no levels.
    pub fn of(at: UtcMicros, event: Event) -> Self {
        Self { at, event, until: None, fixed: [None; 2] }
    }
}

/// The stretch of one gyro's history that the judging of one record needs.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    /// Consecutive records without the voided ones and without [repeats](Sample::repeats), oldest first, as far back as [`Need`] says, and the
    /// gyro's events. What comes after the judged record does no harm.
    pub samples: &'a Series,
    /// The first [`BASELINE_RECORDS`] records at or after [`baseline_since`], or fewer where there are not so many.
    pub baseline: &'a [Sample],
    /// The same since the gyro came to where it is mounted ([`seat_baseline_of`]).
    pub seat_baseline: &'a [Sample],
    /// Records before `samples` that are not there one by one: those that `range` compares with the judged one.
    pub older: Older,
}

/// Where the baseline of a record at `at` begins: at the last event that resets it, or at the very first record (none).
pub fn baseline_since(marks: &[Mark], at: UtcMicros) -> Option<UtcMicros> {
    baseline_mark(marks, at).map(|mark| mark.at)
}

/// When `rule` began anew for a record at `at`.
pub fn reset_before(marks: &[Mark], at: UtcMicros, rule: Rule) -> Option<UtcMicros> {
    marks.iter().rev().find(|mark| mark.at <= at && mark.event.resets(rule)).map(|mark| mark.at)
}

/// The level that the mark states which begins the baseline of a record at `at`.
pub fn stated_level(marks: &[Mark], at: UtcMicros, column: usize) -> Option<Measured> {
    baseline_mark(marks, at).and_then(|mark| mark.fixed.get(column).copied().flatten())
}

fn baseline_mark(marks: &[Mark], at: UtcMicros) -> Option<&Mark> {
    marks.iter().rev().find(|mark| mark.at <= at && mark.event.resets_baseline())
}

/// The first records of the baseline of a record at `at`, among all of a gyro's records.
pub fn baseline_of<'a>(samples: &'a [Sample], marks: &[Mark], at: UtcMicros) -> &'a [Sample] {
    let start = baseline_since(marks, at).map_or(0, |since| samples.partition_point(|sample| sample.at < since));
    first_few(&samples[start..])
}

/// The same of those since the gyro was mounted where it is at `at`: what belongs to the mounting starts anew there.
pub fn seat_baseline_of<'a>(samples: &'a [Sample], marks: &[Mark], at: UtcMicros) -> &'a [Sample] {
    let since = baseline_since(marks, at);
    let upto = &samples[..samples.partition_point(|sample| sample.at <= at)];
    let Some(newest) = upto.last() else { return &[] };
    let here = |sample: &&Sample| sample.seat == newest.seat && since.is_none_or(|since| sample.at >= since);
    first_few(&samples[upto.len() - upto.iter().rev().take_while(here).count()..])
}

fn first_few(samples: &[Sample]) -> &[Sample] {
    &samples[..samples.len().min(BASELINE_RECORDS)]
}

/// How far back the rules look from the record that they judge (besides the baseline's records, the marks, and the
/// [cells](Series::reaches_all_cells) of the control rules).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// At least so many records before it, where there are so many.
    pub records: usize,
    /// And every record of so many days before it.
    pub days: f64,
}

impl Need {
    pub fn of(limits: &Limits) -> Self {
        // A week, so that the judged record's own cell is there.
        Self { records: limits.longest_memory() - 1, days: limits.range_days.max(7.0) }
    }

    /// How many of the records after `changed` (oldest first) must be judged again when a record at
    /// `changed` is inserted, voided or revised. Where that alters the baseline's records, all of them must.
    pub fn reach(&self, changed: UtcMicros, later: &[Sample]) -> usize {
        let within_days = later.partition_point(|sample| sample.at.days_since(changed) <= self.days);
        within_days.max(self.records.min(later.len())).max(cells::reach(changed, later))
    }
}

impl<'a> History<'a> {
    /// Of records that are all there one by one, judged at `k`.
    ///
    /// # Panics
    /// Where `k` is not an index of `samples`.
    pub fn whole(samples: &'a Series, k: usize) -> Self {
        let (marks, at) = (samples.marks(), samples[k].at);
        Self {
            samples,
            baseline: baseline_of(samples, marks, at),
            seat_baseline: seat_baseline_of(samples, marks, at),
            older: Older::NONE,
        }
    }

    pub(crate) fn marks(&self) -> &'a [Mark] {
        self.samples.marks()
    }

    /// The records that `rule` may compare with record `k`: from the last event that resets the rule, `k` included.
    pub(crate) fn since_reset(&self, k: usize, rule: Rule) -> &'a [Sample] {
        &self.samples[self.first_since_reset(k, rule)..=k]
    }

    /// Place of the first of [`History::since_reset`].
    pub(crate) fn first_since_reset(&self, k: usize, rule: Rule) -> usize {
        let upto = &self.samples[..=k];
        let reset = reset_before(self.marks(), self.samples[k].at, rule);
        reset.map_or(0, |reset| upto.partition_point(|sample| sample.at < reset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_a_median_of_three_is_that_of_sorted_normal_figures() {
        // 0.448671 for equal ones is tabled (order statistics of three); the others by integrating x^2 over the density of the median,
        // sum f_i [F_j (1 - F_k) + F_k (1 - F_j)], with 4,000 steps.
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
            Sample { at: UtcMicros(0).plus_days(day), seat: Seat::default(), d }
        };
        assert!(at(0.9, 3.0).repeats(&at(0.0, 3.0)) && at(0.0, 3.0).repeats(&at(0.9, 3.0)));
        assert!(!at(1.0, 3.0).repeats(&at(0.0, 3.0)), "daily records of a gyro that shows the same figures");
        assert!(!at(0.5, 3.0 + 1e-15).repeats(&at(0.0, 3.0)));
        let noisy = Sample { d: at(0.0, 3.0).d.map(|of| Measured { sd: Some(0.2), ..of }), ..at(0.5, 3.0) };
        assert!(!noisy.repeats(&at(0.0, 3.0)), "other standard deviations are another measurement");
    }
}
