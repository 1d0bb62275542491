//! `station_shift`, `batch_shift`: what the gyros of a group have moved by together: those that a station calibrated last,
//! or those of a batch of production. Judged by the clock, over the fleet, and not by one record.
//!
//! d_g = x_g - b_g is the deviation of gyro g from its own baseline in its newest calibration. What n gyros of m IMUs
//! share is the median M of d_g. Its standard error is sqrt(pi/2) s / sqrt(m): gyros of an IMU are calibrated together
//! and move together, so that m and not n counts. Those that have moved by half of M at least are told of. s is the
//! scatter about M, 1.4826 median |d_g - M|, and no smaller than what is stated of the d_g. A few gyros that moved by
//! themselves do not move M.
//!
//! Of a station the newest calibrations of [`IMUS`] IMUs count, within a fortnight: what it did before says nothing of
//! what it does now. Gyros of a batch change each in its own time: all count that were calibrated in [`LATELY`] days.
//!
//! It is the group's only where others do not share it: neither the rest of the fleet, nor is it that of one batch alone
//! among a station's gyros, nor of one station alone among a batch's. What tells no batch from a station is the station's.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

use crate::core::judge::decide::{Conformity, beyond};
use crate::core::judge::{Coefficient, Finding, Limit, Measured, Rule, State, Verdict};
use crate::core::numerics::median::median_of;
use crate::core::numerics::normal::{MEDIAN_ERROR, SD_OF_MEDIAN};
use crate::core::time::UtcMicros;

/// How long before the newest calibration of a station another may lie to count with it, days.
const TOGETHER_DAYS: f64 = 14.0;
/// The same of a batch, and of the rest of the fleet that either is compared with, days.
pub const LATELY: f64 = 60.0;
/// Gyros and IMUs that are looked at, the newest; fewer tell no shift, and no fewer than `GYROS_TO_STAY` keep one that
/// was told.
const GYROS: usize = 6;
const IMUS: usize = 3;
const GYROS_TO_STAY: usize = 3;

/// A gyro's newest calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct NewestCalibration {
    pub gyro: u32,
    pub imu: u32,
    pub station: u32,
    pub at: UtcMicros,
    /// D_I and D_S from their baselines, deg/(h g0); none before these are complete.
    pub deviation: [Option<Measured>; 2],
    /// Of production, where that was said.
    pub batch: Option<Arc<str>>,
}

/// Gyros that may have moved together.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    Station(u32),
    Batch(Arc<str>),
}

impl Group {
    /// The rule that watches such a group.
    pub fn rule(&self) -> Rule {
        match self {
            Self::Station(_) => Rule::StationShift,
            Self::Batch(_) => Rule::BatchShift,
        }
    }

    /// Whether a calibrated gyro belongs to it.
    pub fn holds(&self, one: &NewestCalibration) -> bool {
        match self {
            Self::Station(station) => one.station == *station,
            Self::Batch(batch) => one.batch.as_ref() == Some(batch),
        }
    }

    /// How long before its newest calibration another counts with it, days.
    fn together_days(&self) -> f64 {
        if matches!(self, Self::Station(_)) { TOGETHER_DAYS } else { LATELY }
    }

    /// What else most of these gyros have in common: the batch of a station's, the station of a batch's.
    fn rival(&self, gyros: &[&NewestCalibration]) -> Option<Self> {
        let of = |one: &&NewestCalibration| match self {
            Self::Station(_) => one.batch.clone().map(Self::Batch),
            Self::Batch(_) => Some(Self::Station(one.station)),
        };
        let count = |group: &Self| gyros.iter().filter(|one| group.holds(one)).count();
        gyros.iter().filter_map(of).max_by_key(|group| (count(group), group.clone()))
    }
}

/// What is asked of a group: a limit of the shift, and the whole budget, beyond which it is critical, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupShiftCriteria {
    pub limit: Limit,
    pub budget: f64,
    pub confidence: f64,
    /// Since when, where it has been told already: what was calibrated before does not bear it out.
    pub fires_since: Option<UtcMicros>,
}

/// Judges what the gyros of `group` share among `newest` (column 0: D_I, 1: D_S), the newest calibrations of a fleet.
/// With too few gyros there is nothing to compare.
pub fn group_shift(newest: &[NewestCalibration], group: &Group, column: usize, asked: &GroupShiftCriteria) -> Verdict {
    let coefficient = [Coefficient::DI, Coefficient::DS][column];
    let verdict = |finding| Verdict::undecided(coefficient, group.rule(), asked.limit, finding);
    let few = |have: usize, need: usize| verdict(Finding::TooFew { have, need });
    let is_of_it = |one: &&NewestCalibration| asked.fires_since.is_none_or(|since| one.at >= since);
    let here: Vec<&NewestCalibration> = newest.iter().filter(|one| group.holds(one)).filter(is_of_it).collect();
    let Some(last) = here.iter().map(|one| one.at).max() else { return few(0, GYROS) };
    let together =
        |one: &&NewestCalibration| one.deviation[column].is_some() && last.days_since(one.at) <= group.together_days();
    let mut here: Vec<&NewestCalibration> = here.into_iter().filter(together).collect();
    if let Group::Station(_) = group {
        here = newest_of(here);
    }
    let (gyros, imus) = (here.len(), imus_of(&here));
    let enough = if asked.fires_since.is_some() { gyros >= GYROS_TO_STAY } else { gyros >= GYROS && imus >= IMUS };
    let Some(shift) = shared(&here, column).filter(|_| enough) else { return few(gyros, GYROS) };
    let outcome = beyond(shift, asked.limit.value, asked.confidence);
    let exceeds = outcome.state == State::Exceeded;
    let counted: Vec<&NewestCalibration> =
        here.iter().filter(|one| !exceeds || has_moved(one, column, shift)).copied().collect();
    let (gyros, imus) = (counted.len(), imus_of(&counted));
    let alone = || imus_that_moved(&here, column, shift) < 2;
    let lately: Vec<&NewestCalibration> = newest.iter().filter(|one| last.days_since(one.at) <= LATELY).collect();
    let is_groups = !exceeds || (!alone() && is_of_group(&lately, &here, group, column, shift));
    let since = counted.iter().map(|one| one.at).min().unwrap_or(last);
    let outcome = Conformity { state: if is_groups { outcome.state } else { State::Indeterminate }, ..outcome };
    outcome
        .of(shift.size(), verdict(Finding::GroupShift { gyros, imus, since, until: last, shift: shift.value }))
        .confirmed_if(beyond(shift, asked.budget, asked.confidence).state == State::Exceeded)
}

/// The newest of them, IMU by IMU, as many as are looked at.
fn newest_of(mut here: Vec<&NewestCalibration>) -> Vec<&NewestCalibration> {
    here.sort_by_key(|one| (std::cmp::Reverse(one.at), one.imu));
    let mut counted: Vec<&NewestCalibration> = Vec::new();
    for one in here {
        let is_known = counted.iter().any(|known| known.imu == one.imu);
        if !is_known && counted.len() >= GYROS && imus_of(&counted) >= IMUS {
            break;
        }
        counted.push(one);
    }
    counted
}

fn imus_of(gyros: &[&NewestCalibration]) -> usize {
    gyros.iter().map(|one| one.imu).collect::<BTreeSet<u32>>().len()
}

/// The median deviation, and its standard error.
fn shared(gyros: &[&NewestCalibration], column: usize) -> Option<Measured> {
    let deviations: Vec<Measured> = gyros.iter().filter_map(|one| one.deviation[column]).collect();
    let stated = median_of(deviations.iter().filter_map(|one| one.sd)).unwrap_or(0.0);
    let values: Vec<f64> = deviations.iter().map(|one| one.value).collect();
    in_common(&values, imus_of(gyros), stated)
}

/// Median of values that scatter about it, and its standard error sqrt(pi/2) s/sqrt(independent) with
/// s = max(1.4826 median |x - M|, least), as of normal values; none of nothing.
pub fn in_common(values: &[f64], independent: usize, least: f64) -> Option<Measured> {
    let centre = median_of(values.iter().copied())?;
    let off = median_of(values.iter().map(|value| (value - centre).abs()))?;
    let scatter = (SD_OF_MEDIAN * off).max(least);
    Some(Measured { value: centre, sd: Some(MEDIAN_ERROR * scatter / (independent as f64).sqrt()) })
}

/// Whether a gyro has moved by at least half of the shift.
fn has_moved(one: &NewestCalibration, column: usize, shift: Measured) -> bool {
    one.deviation[column].is_some_and(|of| is_half_of(of, shift))
}

/// IMUs of which most gyros have: one of them may have by chance.
fn imus_that_moved(here: &[&NewestCalibration], column: usize, shift: Measured) -> usize {
    let imus: BTreeSet<u32> = here.iter().map(|one| one.imu).collect();
    let has_moved = |imu: &u32| {
        let of_imu: Vec<&NewestCalibration> = here.iter().filter(|one| one.imu == *imu).copied().collect();
        shared(&of_imu, column).is_some_and(|of| is_half_of(of, shift))
    };
    imus.into_iter().filter(has_moved).count()
}

fn is_half_of(of: Measured, shift: Measured) -> bool {
    of.value * shift.value.signum() >= 0.5 * shift.value.abs()
}

/// Whether neither the rest of the fleet has moved alike, nor only those of its gyros that have something else in common.
fn is_of_group(
    newest: &[&NewestCalibration],
    here: &[&NewestCalibration],
    group: &Group,
    column: usize,
    shift: Measured,
) -> bool {
    // None where too few tell.
    let moved = |gyros: &[&NewestCalibration], fewest: usize| {
        let known: Vec<&NewestCalibration> =
            gyros.iter().filter(|one| one.deviation[column].is_some()).copied().collect();
        shared(&known, column).filter(|_| known.len() >= fewest).map(|of| is_half_of(of, shift))
    };
    let is_station = matches!(group, Group::Station(_));
    let rest: Vec<&NewestCalibration> = newest.iter().filter(|one| !group.holds(one)).copied().collect();
    if moved(&rest, GYROS).unwrap_or(!is_station) {
        return false;
    }
    let Some(rival) = group.rival(here) else { return true };
    let without: Vec<&NewestCalibration> = here.iter().filter(|one| !rival.holds(one)).copied().collect();
    let of_rival: Vec<&NewestCalibration> = rest.into_iter().filter(|one| rival.holds(one)).collect();
    let others_moved = moved(&without, GYROS_TO_STAY);
    others_moved.or_else(|| moved(&of_rival, GYROS_TO_STAY).map(|moved| !moved)).unwrap_or(is_station)
}

/// Since when calibrations of a group show what it has moved by: of each its time, its IMU and how far a gyro was from
/// its baseline. That of an IMU shows it where most of its gyros lie off by half of the `shift` at least, and the group
/// since the oldest after which every one does. None where the newest does not.
pub fn shift_began(calibrated: impl IntoIterator<Item = (UtcMicros, u32, f64)>, shift: f64) -> Option<UtcMicros> {
    let mut campaigns: BTreeMap<(UtcMicros, u32), Vec<f64>> = BTreeMap::new();
    calibrated.into_iter().for_each(|(at, imu, by)| campaigns.entry((at, imu)).or_default().push(by));
    let shows = |of: Vec<f64>| median_of(of).is_some_and(|by| is_half_of(Measured::exact(by), Measured::exact(shift)));
    campaigns.into_iter().rev().map_while(|((at, _), of)| shows(of).then_some(at)).last()
}

/// What a rule says of one gyro that a shift may explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExplicableVerdict {
    pub rule: Rule,
    /// The magnitude that exceeds the limit, deg/(h g0).
    pub value: f64,
    pub limit: f64,
    pub sd: Option<f64>,
    /// Whether the gyro lies above its level; none where that is not known.
    pub above: Option<bool>,
}

impl ExplicableVerdict {
    /// Of a verdict.
    pub fn of(verdict: &Verdict) -> Option<Self> {
        let above = match verdict.finding {
            Finding::Step { level, now } | Finding::Baseline { level, now, .. } | Finding::Shift { level, now, .. } => {
                Some(now > level)
            }
            Finding::BeforeAfter { before, now, .. } => Some(now > before.1),
            Finding::Trend { deviation, .. } => Some(deviation > 0.0),
            _ => None,
        };
        let Verdict { rule, limit, sd, .. } = *verdict;
        Some(Self { rule, value: verdict.value?, limit, sd, above })
    }
}

/// Whether a gyro may lie within its limit by itself, beside what its group has moved by: the `shift` with its
/// standard error. What moves the gyro beyond the limit all the same is its own doing.
pub fn is_explained(suspected: &ExplicableVerdict, shift: Measured, confidence: f64) -> bool {
    let ExplicableVerdict { rule, value, limit, sd, above } = *suspected;
    let towards = above.map(|above| if above { shift.value } else { -shift.value });
    let own = match (rule, towards) {
        // There and back is the station's doing alike.
        (Rule::Step | Rule::BeforeAfter, Some(_)) => value - shift.value.abs(),
        (Rule::Baseline | Rule::Shift | Rule::Trend, Some(towards)) => (value - towards).abs(),
        (Rule::Range, _) => value - shift.value.abs(),
        // 1.2 times the rms of ten differences, two of which it makes.
        (Rule::RmsSuccessive, _) => value - 1.2 * 0.2_f64.sqrt() * shift.value.abs(),
        _ => return false,
    };
    let sd = shift.sd.unwrap_or(0.0).hypot(sd.unwrap_or(0.0));
    beyond(Measured { value: own.max(0.0), sd: Some(sd) }, limit, confidence).state != State::Exceeded
}

/// Whether it exceeds its limit by what it has come to since it was `then`: what its IMU has not done to it.
pub fn has_grown(suspected: &ExplicableVerdict, then: f64, confidence: f64) -> bool {
    let ExplicableVerdict { value, limit, sd, .. } = *suspected;
    let growth = Measured { value: (value - then).max(0.0), sd: sd.map(|sd| SQRT_2 * sd) };
    beyond(growth, limit, confidence).state == State::Exceeded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::LimitKey;

    const SD: f64 = 5e-4;
    const ST_1: Group = Group::Station(1);

    fn asked(fires: bool) -> GroupShiftCriteria {
        let limit = Limit { value: 2.5e-3, from: LimitKey::BUDGET };
        GroupShiftCriteria { limit, budget: 0.01, confidence: 0.95, fires_since: fires.then_some(UtcMicros(0)) }
    }

    /// Fixed figures about zero, with scatter of about 1.
    fn scatter(k: u32) -> f64 {
        [0.3, -1.1, 0.8, 0.1, -0.6, 1.2, -0.2, -0.9, 0.5, 0.7, -1.0, 0.4, -0.3, 1.0, -0.8, 0.2, 0.6][k as usize % 17]
    }

    /// IMUs of three gyros, a day apart, `d_i` from their baselines beside the scatter.
    fn imus(station: u32, first: u32, count: u32, d_i: f64) -> Vec<NewestCalibration> {
        let gyro = |k: u32| NewestCalibration {
            gyro: k,
            imu: k / 3,
            station,
            at: UtcMicros(0).plus_days(f64::from(k / 3)),
            deviation: [Some(Measured { value: d_i + SD * scatter(k), sd: Some(SD) }), None],
            batch: None,
        };
        (3 * first..3 * (first + count)).map(gyro).collect()
    }

    fn state(newest: &[NewestCalibration]) -> State {
        group_shift(newest, &ST_1, 0, &asked(false)).state
    }

    #[test]
    fn gyros_of_three_imus_that_moved_together_are_the_stations() {
        let fleet = imus(1, 0, 5, 0.015);
        let told = group_shift(&fleet, &ST_1, 0, &asked(false));
        assert_eq!((told.state, told.confirmed, told.coefficient), (State::Exceeded, true, Coefficient::DI));
        let Finding::GroupShift { gyros, imus, since, until, shift } = told.finding else { panic!("{told:?}") };
        assert_eq!((gyros, imus), (9, 3), "the newest");
        assert_eq!((since, until), (UtcMicros(0).plus_days(2.0), UtcMicros(0).plus_days(4.0)));
        assert!((shift - 0.015).abs() < 3e-4 && told.sd.unwrap() < 1e-3, "{told:?}");
        let smaller = group_shift(&imus_shifted(-0.006), &ST_1, 0, &asked(false));
        assert_eq!((smaller.state, smaller.confirmed), (State::Exceeded, false));
        assert_eq!(state(&imus_shifted(0.0)), State::Within);
        assert_eq!(group_shift(&fleet, &ST_1, 1, &asked(false)).value, None, "nothing is known of D_S");
    }

    fn imus_shifted(by: f64) -> Vec<NewestCalibration> {
        imus(1, 0, 5, by)
    }

    #[test]
    fn what_a_station_does_now_is_told_whatever_it_did_before() {
        let mut fleet = imus(1, 0, 3, 0.0);
        fleet.extend(imus(1, 3, 2, 0.015));
        let told = group_shift(&fleet, &ST_1, 0, &asked(false));
        let Finding::GroupShift { gyros, imus: of, since, .. } = told.finding else { panic!("{told:?}") };
        assert_eq!((told.state, gyros, of), (State::Exceeded, 6, 2), "it has begun: the third IMU has not moved");
        assert_eq!(since, UtcMicros(0).plus_days(3.0));
        fleet.extend(imus(1, 5, 1, 0.015));
        assert_eq!(state(&fleet), State::Exceeded);
        fleet.extend(imus(1, 6, 3, 0.0));
        assert_eq!(group_shift(&fleet, &ST_1, 0, &asked(true)).state, State::Within, "it is over");
    }

    #[test]
    fn one_imu_of_many_gyros_is_not_a_station() {
        let mut fleet = imus(1, 0, 4, 0.015);
        fleet.iter_mut().filter(|one| one.imu < 2).for_each(|one| one.imu = 3);
        fleet.iter_mut().filter(|one| one.imu == 2).for_each(|one| one.deviation[0].as_mut().unwrap().value -= 0.015);
        fleet.extend(imus(1, 4, 1, 0.0));
        assert_eq!(state(&fleet), State::Indeterminate, "nine gyros of one IMU");
        let chance = fleet.iter_mut().find(|one| one.imu == 2).expect("the last IMU");
        chance.deviation[0].as_mut().expect("known").value += 0.01;
        assert_eq!(state(&fleet), State::Indeterminate, "and one of another by chance");
    }

    #[test]
    fn a_few_gyros_tell_nothing_and_do_not_end_what_was_told() {
        let few = imus(1, 0, 2, 0.015);
        assert_eq!(group_shift(&few, &ST_1, 0, &asked(false)).value, None);
        assert_eq!(group_shift(&few, &ST_1, 0, &asked(true)).state, State::Exceeded);
        assert_eq!(group_shift(&few[..2], &ST_1, 0, &asked(true)).value, None);
        // What is older than a fortnight does not count with what is new.
        let mut old = imus(1, 0, 5, 0.015);
        old.iter_mut().filter(|one| one.imu > 1).for_each(|one| one.at = one.at.plus_days(30.0));
        assert_eq!(group_shift(&old, &ST_1, 0, &asked(false)).value.map(|_| ()), Some(()));
        old.iter_mut().filter(|one| one.imu > 2).for_each(|one| one.at = one.at.plus_days(30.0));
        assert_eq!(group_shift(&old, &ST_1, 0, &asked(false)).value, None);
    }

    #[test]
    fn what_was_calibrated_before_a_shift_that_was_told_does_not_keep_it() {
        // What has shown it is set aside: what is left of the station is older, and as uncertain as can be.
        let mut before = imus(1, 0, 5, 0.0);
        before.iter_mut().for_each(|one| one.deviation[0].as_mut().unwrap().sd = Some(5e-3));
        let since = |day: f64| GroupShiftCriteria { fires_since: Some(UtcMicros(0).plus_days(day)), ..asked(true) };
        assert_eq!(group_shift(&before, &ST_1, 0, &since(0.0)).state, State::Indeterminate);
        assert_eq!(group_shift(&before, &ST_1, 0, &since(10.0)).value, None, "nothing is left");
        let mut nearly = before.clone();
        nearly.extend(imus(1, 10, 1, 0.015).drain(..2));
        assert_eq!(group_shift(&nearly, &ST_1, 0, &since(10.0)).value, None, "two gyros are too few");
    }

    #[test]
    fn a_shift_began_with_the_first_imu_that_shows_it_and_not_with_a_gyro_that_was_off_by_itself() {
        let imu = |day: f64, imu: u32, by: [f64; 3]| by.map(|by| (UtcMicros(0).plus_days(day), imu, by));
        let all = [
            imu(80.0, 2, [0.009, 0.008, 0.007]),
            imu(90.0, 1, [0.02, 0.001, -0.001]),
            imu(100.0, 2, [0.006, 0.0052, 0.001]),
            imu(101.0, 1, [0.025, 0.007, 0.005]),
            imu(110.0, 2, [0.006, 0.0058, 0.0061]),
        ];
        let began = |shift| shift_began(all.into_iter().flatten(), shift);
        assert_eq!(began(0.006), Some(UtcMicros(0).plus_days(100.0)));
        assert_eq!(began(-0.006), None, "they lie on the other side");
    }

    #[test]
    fn gyros_that_move_by_themselves_or_everywhere_or_as_one_batch_are_not_the_stations() {
        let mut some = imus(1, 0, 5, 0.0);
        some.iter_mut().take(5).for_each(|one| one.deviation[0].as_mut().unwrap().value += 0.03);
        assert_eq!(state(&some), State::Within, "by themselves, and before");
        for one in some.iter_mut().filter(|one| one.imu > 1 && one.gyro % 3 == 0) {
            one.deviation[0].as_mut().unwrap().value += 0.03;
        }
        assert_eq!(state(&some), State::Within, "a third of them by themselves");
        let mut everywhere = imus(1, 0, 5, 0.015);
        everywhere.extend(imus(2, 5, 5, 0.015));
        assert_eq!(state(&everywhere), State::Indeterminate);
        let mut elsewhere_still = imus(1, 0, 5, 0.015);
        elsewhere_still.extend(imus(2, 5, 5, 0.0));
        assert_eq!(state(&elsewhere_still), State::Exceeded);
        let mut batch = imus(1, 0, 5, 0.015);
        for one in &mut batch {
            one.batch = Some(if one.imu < 4 { "B-7" } else { "B-8" }.into());
        }
        assert_eq!(state(&batch), State::Exceeded, "both batches moved");
        batch.iter_mut().filter(|one| one.imu == 4).for_each(|one| {
            one.deviation[0].as_mut().unwrap().value -= 0.015;
        });
        assert_eq!(state(&batch), State::Indeterminate, "only one batch did");
    }

    /// Two stations of five IMUs each; gyros of batch B-7 are in IMUs of both, or of some IMUs of one.
    fn batch_of(imus_of_it: &[u32], d_i: f64) -> Vec<NewestCalibration> {
        let mut fleet: Vec<NewestCalibration> = imus(1, 0, 5, 0.0);
        fleet.extend(imus(2, 5, 5, 0.0));
        for one in fleet.iter_mut().filter(|one| imus_of_it.contains(&one.imu)) {
            one.batch = Some("B-7".into());
            one.deviation[0].as_mut().unwrap().value += d_i;
        }
        fleet
    }

    fn of_batch(newest: &[NewestCalibration]) -> Verdict {
        group_shift(newest, &Group::Batch("B-7".into()), 0, &asked(false))
    }

    #[test]
    fn gyros_of_a_batch_that_moved_together_are_the_batchs_and_no_stations() {
        let fleet = batch_of(&[1, 3, 6, 8], -0.015);
        let told = of_batch(&fleet);
        assert_eq!((told.state, told.confirmed, told.rule), (State::Exceeded, true, Rule::BatchShift), "{told:?}");
        let Finding::GroupShift { gyros, imus, shift, .. } = told.finding else { panic!("{told:?}") };
        assert!((gyros, imus) == (12, 4) && (shift + 0.015).abs() < 3e-4, "{told:?}");
        for station in [1, 2] {
            assert_ne!(group_shift(&fleet, &Group::Station(station), 0, &asked(false)).state, State::Exceeded);
        }
        assert_eq!(of_batch(&batch_of(&[1, 3, 6, 8], 0.0)).state, State::Within);
        // Three of its IMUs of four at one station, whose newest they are: still the batch.
        let fleet = batch_of(&[2, 3, 4, 6], 0.015);
        assert_eq!(of_batch(&fleet).state, State::Exceeded);
        assert_ne!(state(&fleet), State::Exceeded, "the fourth moved elsewhere");
    }

    #[test]
    fn what_a_station_or_an_imu_does_to_gyros_of_a_batch_is_not_the_batchs() {
        let mut fleet = batch_of(&[1, 3, 4, 6], 0.0);
        let shift = |fleet: &mut [NewestCalibration], of: &dyn Fn(&NewestCalibration) -> bool| {
            fleet.iter_mut().filter(|one| of(one)).for_each(|one| one.deviation[0].as_mut().unwrap().value += 0.015);
        };
        shift(&mut fleet, &|one| one.station == 1);
        assert_eq!((of_batch(&fleet).state, state(&fleet)), (State::Indeterminate, State::Exceeded));
        let mut fleet = batch_of(&[1, 3, 6, 8], 0.0);
        shift(&mut fleet, &|one| one.imu == 3);
        assert_eq!(of_batch(&fleet).state, State::Within, "an IMU");
        shift(&mut fleet, &|_| true);
        assert_ne!(of_batch(&fleet).state, State::Exceeded, "everywhere");
        // A station that has calibrated nothing but the batch: nothing tells them apart.
        let mut only = imus(1, 0, 5, 0.015);
        only.iter_mut().for_each(|one| one.batch = Some("B-7".into()));
        only.extend(imus(2, 5, 5, 0.0));
        assert_eq!((of_batch(&only).state, state(&only)), (State::Indeterminate, State::Exceeded));
        let few: Vec<NewestCalibration> = batch_of(&[1, 6], 0.015);
        assert_eq!(of_batch(&few).state, State::Indeterminate, "of two IMUs: too few");
    }

    /// Gyros that drift each by itself by half a budget, IMUs that are a quarter off: no group of them has moved.
    #[test]
    fn of_clean_fleets_one_in_a_hundred_at_most_is_told_of() {
        use rand::{RngExt, SeedableRng};
        use rand_distr::{Distribution, StandardNormal};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(36);
        let (mut told, mut asked_of) = ([0; 2], [0; 2]);
        for _ in 0..500 {
            let mut fleet: Vec<NewestCalibration> = Vec::new();
            for imu in 0..20 {
                let [station, day] = [rng.random_range(1..3), rng.random_range(0..60)];
                let of_imu: f64 = StandardNormal.sample(&mut rng);
                for slot in 0..3 {
                    let own: f64 = StandardNormal.sample(&mut rng);
                    let batch = Some(Arc::from(["B-1", "B-2", "B-3"][rng.random_range(0..3_usize)]));
                    let at = UtcMicros(0).plus_days(f64::from(day));
                    let value = 5e-3 * own + 2.5e-3 * of_imu;
                    let deviation = [Some(Measured { value, sd: Some(SD) }), None];
                    fleet.push(NewestCalibration { gyro: 3 * imu + slot, imu, station, at, deviation, batch });
                }
            }
            let batches = ["B-1", "B-2", "B-3"].map(|name| Group::Batch(name.into()));
            for group in [Group::Station(1), Group::Station(2)].into_iter().chain(batches) {
                let k = usize::from(group.rule() == Rule::BatchShift);
                asked_of[k] += 1;
                told[k] += usize::from(group_shift(&fleet, &group, 0, &asked(false)).state == State::Exceeded);
            }
        }
        assert!(told[0] <= 10 && told[1] <= 15, "{told:?} of {asked_of:?}");
    }

    #[test]
    fn a_gyro_has_grown_where_what_it_came_to_since_exceeds_its_limit() {
        let now =
            |value| ExplicableVerdict { rule: Rule::Baseline, value, limit: 0.01, sd: Some(5e-4), above: Some(true) };
        let grown = |value| has_grown(&now(value), 0.03, 0.95);
        assert!(grown(0.0425) && !grown(0.039) && !grown(0.0405) && !grown(0.01), "beyond 0.04 and its uncertainty");
    }

    #[test]
    fn a_gyro_is_explained_where_it_may_lie_within_its_limit_beside_the_shift() {
        let shift = Measured { value: 0.015, sd: Some(3e-4) };
        let says = |rule, value, above| {
            is_explained(&ExplicableVerdict { rule, value, limit: 0.01, sd: Some(5e-4), above }, shift, 0.95)
        };
        for rule in [Rule::Baseline, Rule::Step, Rule::Shift, Rule::Trend, Rule::BeforeAfter] {
            assert!(says(rule, 0.0155, Some(true)), "{rule:?}");
            assert!(!says(rule, 0.0285, Some(true)), "{rule:?}: 0.0135 of its own");
        }
        assert!(!says(Rule::Baseline, 0.0155, Some(false)), "it moved by twice as much against the station");
        assert!(says(Rule::Step, 0.0155, Some(false)), "back");
        assert!(says(Rule::Range, 0.02, None) && !says(Rule::Range, 0.028, None));
        assert!(says(Rule::RmsSuccessive, 0.0105, None) && !says(Rule::RmsSuccessive, 0.0195, None));
        for rule in [Rule::Closure, Rule::Overdue, Rule::Requirement, Rule::Agreement] {
            assert!(!says(rule, 0.0155, Some(true)), "{rule:?}");
        }
    }
}
