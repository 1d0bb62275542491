//! What is to be said of the standard errors that a station states.

use crate::core::calibrate::{Calibration, GyroCalibration};
use crate::core::campaign::CampaignNote;
use crate::core::campaign::repeats::PureError;
use crate::core::diagnose::diagnosis::Sign;
use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::diagnose::report::remaining::SPREAD;
use crate::core::message::{Message, figure, list};
use crate::core::numerics::tails::chi2_tail;
use crate::message;

/// Gyros whose standard errors are stated too large, and how many times.
pub(crate) fn too_large(fits: &Calibrated) -> Option<CampaignNote> {
    let gyros = fits.plain.overstated();
    (!gyros.is_empty()).then_some(CampaignNote::ErrorsOverstated { gyros })
}

/// How many times the standard errors of a station may be too small. What scatters more, of repeats as well or in a law
/// of the noise, may be what changes from one time to the next.
const MOST_UNDERSTATED: f64 = 2.5;

/// Gyros whose dwells scatter more than that.
pub(crate) fn beyond_belief(fit: &Calibration) -> Option<Sign> {
    let chance = |gyro: &GyroCalibration| chi2_tail(gyro.chi2 / MOST_UNDERSTATED.powi(2), gyro.dof);
    let beyond = fit.gyros.iter().filter(|_| fit.has_sem).filter_map(|gyro| Some((gyro.slot, chance(gyro)?)));
    let beyond: Vec<_> = beyond.filter(|(_, p_value)| *p_value < 1e-3).collect();
    let least = beyond.iter().map(|(_, p_value)| *p_value).reduce(f64::min)?;
    Some(Sign::of_no_dwell(SPREAD, beyond.into_iter().map(|(slot, _)| slot).collect(), least))
}

/// Gyros whose standard errors repeats show to be too small, and how many times; all together where none does alone.
/// Where nothing `remains`, the residuals are noise and join the repeats.
pub(crate) fn too_small(fits: &Calibrated, remains: bool) -> Option<Message> {
    let fit = fits.augmented();
    let scatter = |gyro: &GyroCalibration| match remains {
        true => gyro.noise.pure_error,
        false => PureError { chi2: gyro.chi2, dof: gyro.dof },
    };
    let beyond_chance = |gyros: &[&GyroCalibration]| {
        let sum = |of: &dyn Fn(&GyroCalibration) -> PureError| {
            gyros.iter().map(|gyro| of(gyro)).fold(PureError::default(), PureError::plus)
        };
        let (PureError { chi2, dof }, repeats) = (sum(&scatter), sum(&|gyro| gyro.noise.pure_error));
        let is = chi2_tail(chi2, dof).is_some_and(|p| p < 1e-3) && repeats.chi2 > repeats.dof as f64;
        is.then(|| (chi2 / dof as f64).sqrt())
    };
    let all: Vec<&GyroCalibration> = fit.gyros.iter().filter(|_| fit.has_sem).collect();
    let alone: Vec<&GyroCalibration> = all.iter().copied().filter(|gyro| beyond_chance(&[*gyro]).is_some()).collect();
    let gyros = if alone.is_empty() { all } else { alone };
    let times = beyond_chance(&gyros)?;
    let slots = list(gyros.iter().map(|gyro| gyro.slot.name()));
    Some(message!("standard_errors_understated", slots = slots, times = figure(times, 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::calibrate::calibrate;
    use crate::core::model::Terms;

    #[test]
    fn standard_errors_are_believed_to_be_too_small_up_to_a_factor() {
        let text = std::fs::read("tests/data/practice/campaign-00.json").expect("it is kept");
        let mut campaign = crate::wire::document::parse(&text).expect("it is whole");
        let mut beyond = |times: f64| {
            for sem in campaign.dwells.iter_mut().filter_map(|dwell| dwell.output_sem_pulse_s.as_mut()) {
                sem.iter_mut().for_each(|sem| *sem /= times);
            }
            beyond_belief(&calibrate(&campaign, Terms::MODEL_6))
        };
        // Nothing is in this one but its noise.
        assert_eq!((beyond(1.0), beyond(2.0)), (None, None));
        let four_times = beyond(2.0).expect("more than two and a half");
        assert_eq!((four_times.kind, four_times.slots.len()), (SPREAD, 3));
    }
}
