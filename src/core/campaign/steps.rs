//! Steps in which a station writes what it commanded, or counts what it measured, where they are not small against the
//! noise of a dwell.

use super::{Campaign, Dwell, Phase};
use crate::core::message::{Message, figure, significant, text};
use crate::core::mounting::Slot;
use crate::core::numerics::median::median_of;
use crate::core::units::EARTH_RATE_DEG_H;
use crate::message;

/// What comes in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stepped {
    Force,
    Rate,
    /// A rate that [`super::with_exact_rates`] has put the exact one in place of.
    SentRate,
    Output,
}

/// A step, and the gyro that shows it most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseStep {
    pub of: Stepped,
    /// g0, arcsec/s or pulse/s (in a dwell of median duration).
    pub step: f64,
    pub slot: Slot,
    /// Standard deviation of a number that is rounded to the step, over the noise of a dwell.
    pub times: f64,
}

/// How a gyro sees steps, pulse/s.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroNoise {
    pub slot: Slot,
    /// |G|, pulse/(s g0), and |E|, pulse/arcsec.
    pub g: f64,
    pub e: f64,
    /// Noise by dwell, pulse/s.
    pub sd: Vec<f64>,
}

/// Rounded commands move D_I and D_S by as many of their standard deviations: repeats are rounded alike, and neither
/// they nor stated errors show it.
const COMMANDS: f64 = 0.3;

/// Counts are seen in the residuals too: from here on D_I and D_S are off by a tenth more than their standard
/// deviations. Repeats then fall on the same count.
const COUNTS: f64 = 0.8;

/// Beyond it the noise is nothing.
const MOST_TIMES: f64 = 1e3;

/// Standard deviation of what is evenly distributed within a step.
fn evenly(step: f64) -> f64 {
    step / 12.0_f64.sqrt()
}

impl CoarseStep {
    /// Its name in answers; never changes once it has been given out.
    pub fn code(&self) -> &'static str {
        match self.of {
            Stepped::Force | Stepped::Rate | Stepped::SentRate => "commands_rounded",
            Stepped::Output => "outputs_coarse",
        }
    }

    /// Whether it is in what was fitted to: in the commands as they are used.
    pub fn is_of_commands(&self) -> bool {
        matches!(self.of, Stepped::Force | Stepped::Rate)
    }

    /// What is said of it.
    pub fn message(&self) -> Message {
        let (slot, times) = (self.slot.name(), figure(self.times, 1));
        match self.of {
            Stepped::Output => message!("outputs_coarse", slot, step = significant(self.step, 2), times),
            Stepped::Force => message!("commands_rounded", of = "force", step = text(self.step), slot, times),
            Stepped::Rate => message!("commands_rounded", of = "rate", step = text(self.step), slot, times),
            Stepped::SentRate => message!("commands_rounded", of = "sent", step = text(self.step), slot, times),
        }
    }
}

/// Where commanded values are written with so few digits, or outputs come in so coarse counts, that it matters: each by
/// the gyro of `gyros` (those of the campaign, in its order) that shows it most.
pub fn coarse_steps(campaign: &Campaign, gyros: &[Option<GyroNoise>]) -> Vec<CoarseStep> {
    let worst = |a: &CoarseStep, b: &CoarseStep| a.times.total_cmp(&b.times);
    let steps = [
        (Stepped::Force, commanded_step(campaign, Stepped::Force)),
        (Stepped::Rate, commanded_step(campaign, Stepped::Rate)),
        (Stepped::SentRate, campaign.rates_sent_in_steps.unwrap_or(0.0)),
    ];
    let commanded = steps.into_iter().filter_map(|(of, step)| {
        let of_gyros = gyros.iter().flatten().filter_map(|gyro| rounded(of, step, gyro));
        of_gyros.max_by(worst)
    });
    let counted = gyros.iter().enumerate().filter_map(|(j, gyro)| counted(campaign, j, gyro.as_ref()?));
    commanded.chain(counted.max_by(worst)).collect()
}

fn rounded(of: Stepped, step: f64, gyro: &GyroNoise) -> Option<CoarseStep> {
    let per_unit = if of == Stepped::Force { gyro.g } else { gyro.e };
    let times = (evenly(per_unit * step) / median_of(gyro.sd.iter().copied())?).min(MOST_TIMES);
    (step > 0.0 && times > COMMANDS).then_some(CoarseStep { of, step, slot: gyro.slot, times })
}

/// Standard uncertainty (GUM 2008, 4.3.7) of the vertical part of the Earth's rate that rounded rates have in common
/// over the specific force, deg/(h g0): what is the same in all dwells is in D_I, and in no residual. Where the
/// vertical is rounded otherwise from dwell to dwell its mean is as much better. Zero where nothing is rounded, or
/// static rates are not the Earth's.
pub fn rounded_vertical(campaign: &Campaign) -> f64 {
    let step = commanded_step(campaign, Stepped::Rate);
    let still = || campaign.dwells.iter().filter(|d| d.phase == Phase::Static && d.specific_force_g0.norm() > 0.0);
    let Some(force) = median_of(still().map(|d| d.specific_force_g0.norm())).filter(|_| step > 0.0) else { return 0.0 };
    if still().any(|d| (d.rate_arcsec_s.norm() - EARTH_RATE_DEG_H).abs() > step) {
        return 0.0;
    }
    let along = |d: &Dwell| d.rate_arcsec_s.dot(&d.specific_force_g0.normalize());
    let vertical: Vec<f64> = still().map(along).collect();
    let (half, n) = (evenly(step), vertical.len() as f64);
    let mean = vertical.iter().sum::<f64>() / n;
    let differs = vertical.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / n;
    (half * half - differs).max(half * half / n).sqrt() / force
}

/// The decimal step of what was commanded; 0 where its lengths are gravity or the Earth's rate nevertheless: then
/// those are what has few digits, and nothing was rounded.
fn commanded_step(campaign: &Campaign, of: Stepped) -> f64 {
    let vector = |d: &Dwell| if of == Stepped::Force { d.specific_force_g0 } else { d.rate_arcsec_s };
    let step = step_of(campaign.dwells.iter().flat_map(|d| <[f64; 3]>::from(vector(d))), of);
    let still = || campaign.dwells.iter().filter(|d| d.phase == Phase::Static).map(|d| vector(d).norm());
    let length = match of {
        Stepped::Force => campaign.site.map(|site| site.gravity_g0).or_else(|| median_of(still())),
        _ => Some(EARTH_RATE_DEG_H),
    };
    const EXACT: f64 = 0.01;
    let is_exact = length.is_some_and(|length| still().all(|own| (own - length).abs() < EXACT * step));
    if is_exact { 0.0 } else { step }
}

/// As [`decimal_step`]; 0 where whole numbers, and tenths of g0, are all there is, or where they have more than six
/// digits behind the point.
fn step_of(numbers: impl Iterator<Item = f64> + Clone, of: Stepped) -> f64 {
    let step = decimal_step(numbers);
    if step < if of == Stepped::Force { 0.05 } else { 0.5 } { step } else { 0.0 }
}

/// The decimal step, 1 or less, that all numbers are multiples of; 0 where they have more than six digits behind the
/// point.
pub(super) fn decimal_step(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let is_multiple = |places: i32| {
        let scale = 10_f64.powi(places);
        numbers.clone().all(|x| (x * scale - (x * scale).round()).abs() < 1e-4)
    };
    (0..=6).find(|places| is_multiple(*places)).map_or(0.0, |places| 10_f64.powi(-places))
}

/// Counts over a dwell, or decimals of an output.
fn counted(campaign: &Campaign, j: usize, gyro: &GyroNoise) -> Option<CoarseStep> {
    let outputs = || campaign.dwells.iter().map(|d| d.output_pulse_s[j]);
    let durations = || campaign.dwells.iter().map(|d| d.duration_s);
    let usual = median_of(durations())?;
    let step = |of: &dyn Fn(f64) -> f64| {
        let noise = median_of(gyro.sd.iter().zip(durations()).map(|(sd, duration)| sd * of(duration)))?;
        let least = COUNTS * 12.0_f64.sqrt() * noise;
        let count = count_of(outputs().zip(durations()).map(|(y, duration)| y * of(duration)).collect(), least)?;
        let times = (evenly(count) / noise).min(MOST_TIMES);
        Some(CoarseStep { of: Stepped::Output, step: count / of(usual), slot: gyro.slot, times })
    };
    step(&|duration| duration).or_else(|| step(&|_| 1.0))
}

/// The count that all numbers are multiples of, `least` or more: the least difference of two or a part of it.
fn count_of(mut numbers: Vec<f64>, least: f64) -> Option<f64> {
    const PARTS: usize = 12;
    // Chance has one number in five near a multiple.
    const DISTINCT: usize = 12;
    const NEAR: f64 = 0.1;
    numbers.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let mut sorted = numbers.clone();
    sorted.sort_by(f64::total_cmp);
    let largest = numbers.last()?.abs();
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > NEAR * least + 1e-12 * largest);
    let (number, smallest) = steps.fold((1, f64::INFINITY), |(number, least), step| (number + 1, step.min(least)));
    if number < DISTINCT {
        return None;
    }
    let is_count = |first: f64| {
        // What a count is follows from ever larger multiples.
        let (mut products, mut squares) = (first, 1.0);
        for x in &numbers {
            let count: f64 = products / squares;
            let times = (x / count).round();
            if (x - times * count).abs() > NEAR * count {
                return None;
            }
            (products, squares) = (products + times * x, squares + times * times);
        }
        Some(products / squares)
    };
    let parts = (1..=PARTS).map(|part| smallest / part as f64).take_while(|count| *count >= least);
    parts.into_iter().find_map(is_count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_is_found_among_its_multiples_and_nowhere_else() {
        let numbers = |count: f64, digits: i32| -> Vec<f64> {
            let number =
                |k: usize| ((k as f64 * 1.618).sin() * 3e3 * 10_f64.powi(k as i32 % 3) / count).round() * count;
            (0..40).map(|k| (number(k) * 10_f64.powi(digits)).round() / 10_f64.powi(digits)).collect()
        };
        for count in [1.0, 2.857_142_857, 10.0, 0.7] {
            let found = count_of(numbers(count, 8), 0.5 * count).expect("a count");
            assert!((found / count - 1.0).abs() < 1e-6 || (found / count).fract() < 1e-6, "{found} {count}");
            assert_eq!(count_of(numbers(count, 8), 40.0 * count), None, "it is small against the noise");
        }
        let smooth: Vec<f64> = (0..40).map(|k| (k as f64 * 1.618).sin() * 3e3).collect();
        assert_eq!(count_of(smooth.clone(), 1e-3), None);
        assert_eq!(count_of(vec![0.0; 40], 1e-3), None);
        assert_eq!(count_of((0..11).map(f64::from).collect(), 0.5), None, "too few");
    }

    #[test]
    fn a_decimal_step_is_none_of_whole_numbers_and_of_many_digits() {
        let step = |numbers: &[f64], of| step_of(numbers.iter().copied(), of);
        assert_eq!(step(&[1.0, -0.5, 0.0], Stepped::Force), 0.0);
        assert_eq!(step(&[0.999, -0.706, 0.0], Stepped::Force), 1e-3);
        assert_eq!(step(&[0.999_05, 1.0 / 3.0], Stepped::Force), 0.0);
        assert_eq!(step(&[12.4, 0.0, 8.5], Stepped::Rate), 0.1, "tenths of a rate are coarse");
        assert_eq!(step(&[7200.0, 15.0], Stepped::Rate), 0.0);
    }

    #[test]
    fn what_is_not_rounded_is_not_said_to_be() {
        let gyro = GyroNoise { slot: Slot::G1, g: f64::INFINITY, e: 1.5, sd: vec![0.0; 3] };
        assert_eq!(rounded(Stepped::Force, 0.0, &gyro), None);
        assert!(rounded(Stepped::Rate, 1e-3, &gyro).is_some_and(|step| step.of == Stepped::Rate));
    }
}
