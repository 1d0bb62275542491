//! `imu_shift`: an IMU of which every gyro has moved in its newest calibration. Judged by the clock, over the fleet, and
//! not by one record.
//!
//! d_g = x_g - b_g is the deviation of gyro g from its own baseline, or d_g - M where that is less and its station or batch
//! has moved by M ([`group_shift`](super::group_shift())), which may be over for this IMU. Gyros drift by themselves,
//! and do not all do so on one day: where the smallest |d_g| of [`GYROS`] or more exceeds the limit, and none of them did
//! before, the IMU, its mounting or that calibration is to be looked at first. Signs and sizes may differ: each gyro has
//! its own place in the IMU.

use crate::core::judge::decide::{Conformity, beyond};
use crate::core::judge::{Coefficient, Finding, Limit, Measured, NewestCalibration, Rule, State, Verdict};

/// Fewer gyros may have moved on one day by themselves.
const GYROS: usize = 3;

/// What is asked of an IMU: the limit, deg/(h g0), what each of its gyros has moved by with its station and batch (M),
/// whether one of them has exceeded its limit before the others, and whether a second campaign has confirmed what one of
/// them exceeds.
pub struct ImuShiftCriteria<'a> {
    pub limit: Limit,
    pub confidence: f64,
    pub shared: &'a dyn Fn(&NewestCalibration) -> Vec<Measured>,
    pub one_did_before: bool,
    pub confirmed: bool,
}

/// Judges the gyros of one IMU in its newest calibration (column 0: D_I, 1: D_S); `newest` are theirs. Those without a
/// baseline have nothing to be compared with.
pub fn imu_shift(newest: &[&NewestCalibration], column: usize, asked: &ImuShiftCriteria<'_>) -> Verdict {
    let coefficient = [Coefficient::DI, Coefficient::DS][column];
    let verdict = |finding| Verdict::undecided(coefficient, Rule::ImuShift, asked.limit, finding);
    let last = newest.iter().map(|one| one.at).max();
    let together = newest.iter().filter(|one| Some(one.at) == last);
    let beside = |of: Measured, shift: &Measured| {
        let left = Measured { value: of.value - shift.value, ..of.beside(shift.sd.unwrap_or(0.0)) };
        if left.value.abs() < of.value.abs() { left } else { of }
    };
    let own = |one: &&NewestCalibration| Some((asked.shared)(one).iter().fold(one.deviation[column]?, beside));
    let moved: Vec<Measured> = together.filter_map(own).collect();
    let least = moved.iter().min_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
    let Some(least) = least.filter(|_| moved.len() >= GYROS) else {
        return verdict(Finding::TooFew { have: moved.len(), need: GYROS });
    };
    let states = moved.iter().map(|of| beyond(*of, asked.limit.value, asked.confidence).state);
    let all = !asked.one_did_before && states.clone().all(|state| state == State::Exceeded);
    let outcome = beyond(*least, asked.limit.value, asked.confidence);
    let state = if outcome.state == State::Exceeded && !all { State::Indeterminate } else { outcome.state };
    let finding = Finding::ImuShift { gyros: moved.len() };
    Conformity { state, ..outcome }.of(least.size(), verdict(finding)).confirmed_if(asked.confirmed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::LimitKey;
    use crate::core::time::UtcMicros;

    const LIMIT: f64 = 0.01;
    const SD: f64 = 5e-4;

    fn gyros(deviations: &[Option<f64>]) -> Vec<NewestCalibration> {
        let of = |(k, d_s): (usize, &Option<f64>)| NewestCalibration {
            gyro: k as u32,
            imu: 1,
            station: 1,
            at: UtcMicros(0),
            deviation: [None, d_s.map(|value| Measured { value, sd: Some(SD) })],
            batch: None,
        };
        deviations.iter().enumerate().map(of).collect()
    }

    fn told(newest: &[NewestCalibration], station: Option<Measured>, confirmed: bool) -> Verdict {
        judged(newest, station, [false, confirmed])
    }

    fn judged(
        newest: &[NewestCalibration],
        station: Option<Measured>,
        [one_did_before, confirmed]: [bool; 2],
    ) -> Verdict {
        let limit = Limit { value: LIMIT, from: LimitKey::BUDGET };
        let shared = |_: &NewestCalibration| station.into_iter().collect();
        let asked = ImuShiftCriteria { limit, confidence: 0.95, shared: &shared, one_did_before, confirmed };
        imu_shift(&newest.iter().collect::<Vec<_>>(), 1, &asked)
    }

    #[test]
    fn an_imu_of_which_every_gyro_has_moved_is_told_by_the_one_that_moved_least() {
        let all = gyros(&[Some(0.05), Some(-0.02), Some(0.03)]);
        let verdict = told(&all, None, false);
        assert_eq!((verdict.state, verdict.coefficient, verdict.confirmed), (State::Exceeded, Coefficient::DS, false));
        assert_eq!((verdict.value, verdict.finding), (Some(0.02), Finding::ImuShift { gyros: 3 }));
        assert!(told(&all, None, true).confirmed);
    }

    #[test]
    fn one_that_stays_or_is_not_sure_to_have_moved_keeps_the_others_by_themselves() {
        assert_eq!(told(&gyros(&[Some(0.05), Some(0.001), Some(0.03)]), None, true).state, State::Within);
        let unsure = told(&gyros(&[Some(0.05), Some(0.0102), Some(0.03)]), None, true);
        assert_eq!((unsure.state, unsure.confirmed), (State::Indeterminate, false));
        // The largest of them is uncertain, though the least is not.
        let mut uncertain = gyros(&[Some(0.05), Some(0.02), Some(0.03)]);
        uncertain[0].deviation[1] = Some(Measured { value: 0.05, sd: Some(0.05) });
        assert_eq!(told(&uncertain, None, false).state, State::Indeterminate);
    }

    #[test]
    fn two_gyros_or_three_of_two_days_are_too_few() {
        let two = told(&gyros(&[Some(0.05), None, Some(0.03)]), None, false);
        assert_eq!((two.value, two.finding), (None, Finding::TooFew { have: 2, need: 3 }));
        let mut apart = gyros(&[Some(0.05), Some(0.02), Some(0.03)]);
        apart[1].at = UtcMicros(0).plus_days(-1.0);
        assert_eq!(told(&apart, None, false).value, None);
        assert_eq!(told(&[], None, false).value, None);
    }

    #[test]
    fn what_the_station_has_done_is_not_the_imus() {
        let station = Some(Measured { value: 0.02, sd: Some(SD) });
        assert_eq!(told(&gyros(&[Some(0.021), Some(0.0195), Some(0.02)]), station, false).state, State::Within);
        let besides = told(&gyros(&[Some(0.05), Some(0.035), Some(0.05)]), station, false);
        assert_eq!(besides.state, State::Exceeded);
        assert!((besides.sd.unwrap() - SD * 2f64.sqrt()).abs() < 1e-12);
        // The station is in order again, or was for this IMU.
        assert_eq!(told(&gyros(&[Some(0.001), Some(-0.0005), Some(0.0)]), station, false).state, State::Within);
    }

    #[test]
    fn gyros_that_exceed_one_after_the_other_have_not_moved_at_once() {
        let all = gyros(&[Some(0.05), Some(-0.02), Some(0.03)]);
        let verdict = judged(&all, None, [true, true]);
        assert_eq!((verdict.state, verdict.confirmed), (State::Indeterminate, false));
    }
}
