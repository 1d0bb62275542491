//! Which mistake explains what cannot be.

use nalgebra::Vector3;

use super::measure::{HEADING_ROOM, Measures, RATE_ROOM};
use super::senses::senses;
use super::transform::{Mistake, mistakes, other_headings, single_axes};
use super::trial_fit::{TrialFit, TrialFits};
use super::{AffectedDwells, CommandFinding, EARTH, MistakeKind, Symptom};
use crate::core::campaign::steps::decimal_step;
use crate::core::campaign::{Campaign, Dwell, Phase, Site, with_earth_rate};
use crate::core::numerics::median::median_of;
use crate::core::numerics::normal::{MEDIAN_ERROR, SD_OF_MEDIAN};

/// A mistake that explains a campaign leaves at most this share of its dwells unexplained.
const LEFT_OVER: f64 = 0.05;

/// Up to this share, bad dwells are single ones, and the campaign is not wrong as a whole.
const SINGLE: f64 = 0.2;

/// Causes that are named beside one another.
const MOST_CAUSES: usize = 3;

/// A static dwell whose rate is below this has none, arcsec/s: the Earth's was left out.
const NO_RATE: f64 = 0.5;

/// Common deviations of |w| and w.f/|f| that are looked into, arcsec/s: above what two printed decimals and a tenth
/// of a degree of latitude come to.
const COMMON_RATE: f64 = 0.03;

/// Of the latter from here on where digits do not explain it: it is in D_I, whose budget is as much in deg/(h g0).
const COMMON_VERTICAL: f64 = 0.01;

/// A latitude whose last digit is a larger one, degrees, may end in noughts that are not written.
const LATITUDE_STEP: f64 = 0.01;

/// Largest share by which specific force may be off in most dwells without its unit being wrong.
const FORCE_ROOM: f64 = 0.02;

/// How many times fewer squares a mirrored body must leave where nothing but the outputs speaks.
const CLEARLY: f64 = 100.0;

/// How many times fewer squares they must leave with the Earth's rate.
const BETTER: f64 = 4.0;

/// Gravity is known to this share, not better.
const LEAST_SHARE: f64 = 2e-6;

/// Gravity on the Earth's surface, g0.
const GRAVITY_ON_EARTH: (f64, f64) = (0.995, 1.003);

/// Everything that was commanded as the Earth does not allow it.
pub fn findings(campaign: &Campaign) -> Vec<CommandFinding> {
    let measures = Measures::of(campaign);
    let mut found: Vec<CommandFinding> = rates(campaign, &measures).into_iter().collect();
    let axes = |campaign: &Campaign, _: &Measures| senses(campaign);
    for look in [common_offset, headings, outputs, axes, earth_rate_while_turning] {
        if found.is_empty() {
            found.extend(look(campaign, &measures));
        }
    }
    found.extend(gravity(campaign, &measures));
    found
}

/// What is wrong with rates, directions and attitudes.
fn rates(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let symptoms = measures.symptoms();
    let bad: Vec<usize> = (0..symptoms.len()).filter(|&k| symptoms[k].is_some()).collect();
    let symptom = *bad.iter().find_map(|&k| symptoms[k].as_ref())?;
    let worst = [Symptom::Attitude, Symptom::StaticRate, Symptom::VerticalRate, Symptom::TurningRate];
    let count = |s: Symptom| symptoms.iter().filter(|x| **x == Some(s)).count();
    let symptom = worst.into_iter().filter(|s| count(*s) > 0).max_by_key(|s| count(*s)).unwrap_or(symptom);
    let mut trial_fits = TrialFits::new(campaign);
    let single = bad.len() as f64 <= SINGLE * symptoms.len() as f64;
    let of_all_dwells = explained(campaign, measures, mistakes(), |_| true, &mut trial_fits);
    let everywhere = !of_all_dwells.is_empty();
    let causes = if everywhere {
        of_all_dwells
    } else if single {
        let these = |k: usize| bad.contains(&k);
        let silent = bad.iter().all(|&k| measures.dwells[k].rate < NO_RATE);
        let found = explained(campaign, measures, mistakes(), these, &mut trial_fits);
        if found.is_empty() && silent { vec![MistakeKind::EarthRateLeftOut] } else { found }
    } else {
        let in_phase =
            |phase| explained(campaign, measures, mistakes(), |k| campaign.dwells[k].phase == phase, &mut trial_fits);
        let found = [Phase::Rate, Phase::Static].map(in_phase).into_iter().find(|causes| !causes.is_empty());
        found.unwrap_or_else(|| of_all(measures))
    };
    let single = single && !everywhere;
    let shown = |k: &usize| single || symptoms[*k] == Some(symptom);
    let dwells: Vec<(usize, f64)> =
        bad.into_iter().filter(shown).map(|k| (k, measures.dwells[k].value(symptom))).collect();
    let phase = if symptom == Symptom::TurningRate { Phase::Rate } else { Phase::Static };
    let kind = |d: &&Dwell| symptom == Symptom::Attitude || single || d.phase == phase;
    let of = campaign.dwells.iter().filter(kind).count();
    Some(CommandFinding {
        symptom,
        causes,
        single,
        expected: match symptom {
            Symptom::StaticRate => Some(EARTH),
            Symptom::VerticalRate => measures.vertical,
            _ => None,
        },
        of,
        dwells,
        matters: symptom == Symptom::Attitude || trial_fits.earth_is_above_noise(),
    })
}

/// The mistakes that, undone in the dwells that `concerned` picks, leave dwells as they should be. Of several, those
/// whose fit is not much worse than the best.
fn explained(
    campaign: &Campaign,
    measures: &Measures,
    families: impl IntoIterator<Item = Vec<Mistake>>,
    concerned: impl Fn(usize) -> bool + Copy,
    trial_fits: &mut TrialFits,
) -> Vec<MistakeKind> {
    let n = measures.dwells.len();
    let some = !(0..n).all(concerned);
    let needed = if some { n } else { n - (LEFT_OVER * n as f64) as usize };
    let before = measures.good();
    for family in families {
        let usable = |m: &&Mistake| !some || m.of_single_dwells();
        let right = family.iter().filter(usable).filter_map(|m| Some((m.cause, m.undone(campaign, concerned)?)));
        let passing = right.filter(|(_, right)| {
            let good = Measures::of(right).good();
            good >= needed && good > before
        });
        let tried: Vec<(MistakeKind, TrialFit)> = passing.map(|(cause, right)| (cause, TrialFit::of(&right))).collect();
        let mut causes = trial_fits.best(tried, 1.0);
        let unit_of_all = causes.iter().find_map(|cause| match cause {
            MistakeKind::RateUnit { unit, part: AffectedDwells::All } => Some(*unit),
            _ => None,
        });
        causes.retain(|cause| match cause {
            MistakeKind::RateUnit { unit, part } => *part == AffectedDwells::All || Some(*unit) != unit_of_all,
            _ => true,
        });
        if causes.iter().any(|cause| matches!(cause, MistakeKind::RateUnit { .. })) {
            causes.retain(|cause| *cause != MistakeKind::EarthRateLeftOut);
        }
        if !causes.is_empty() {
            causes.truncate(MOST_CAUSES);
            return causes;
        }
    }
    Vec::new()
}

/// What the medians over all static dwells say where no mistake explains each of them.
fn of_all(measures: &Measures) -> Vec<MistakeKind> {
    let most = |test: &dyn Fn(f64, f64) -> bool| {
        let (count, all) =
            measures.still().fold((0, 0), |(c, n), m| (c + usize::from(test(m.rate, m.vertical)), n + 1));
        all > 0 && count as f64 >= (1.0 - LEFT_OVER) * f64::from(all)
    };
    let Some(rate) = median_of(measures.still().map(|m| m.rate)) else { return Vec::new() };
    let vertical = median_of(measures.still().map(|m| m.vertical)).unwrap_or(0.0);
    let is_earths = (rate - EARTH).abs() <= RATE_ROOM;
    let is_of_site = measures.vertical.is_some_and(|expected| (vertical - expected).abs() <= RATE_ROOM);
    if most(&|rate, _| rate < NO_RATE) {
        vec![MistakeKind::EarthRateLeftOut]
    } else if is_earths && is_of_site {
        Vec::new()
    } else if most(&|r, v| (r - EARTH).abs() <= RATE_ROOM && (v - vertical).abs() <= RATE_ROOM) {
        vec![other_latitude(vertical, rate)]
    } else if !is_earths && most(&|r, _| (r - rate).abs() <= RATE_ROOM) {
        vec![MistakeKind::OtherEarthRate { arcsec_s: rate }]
    } else {
        Vec::new()
    }
}

fn other_latitude(vertical: f64, rate: f64) -> MistakeKind {
    MistakeKind::OtherLatitude { degrees: latitude(vertical, rate) }
}

/// That whose sine is the vertical part of the rate over the whole, degrees.
fn latitude(vertical: f64, rate: f64) -> f64 {
    (vertical / rate).clamp(-1.0, 1.0).asin().to_degrees()
}

/// The static dwells, each with what it measures.
fn still(campaign: &Campaign, measures: &Measures, symptom: Symptom) -> Vec<(usize, f64)> {
    let still = campaign.dwells.iter().zip(&measures.dwells).enumerate().filter(|(_, (d, _))| d.phase == Phase::Static);
    still.map(|(k, (_, m))| (k, m.value(symptom))).collect()
}

/// A small deviation that all static dwells share: another value of the Earth's rate, the latitude of another place.
fn common_offset(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let site = campaign.site?;
    let (sin, expected) = (site.latitude.sin(), measures.vertical?);
    let rate = median_of(measures.still().map(|m| m.rate))?;
    let vertical = median_of(measures.still().map(|m| m.vertical))?;
    let rate_is_other = (rate - EARTH).abs() > COMMON_RATE;
    let shift = vertical - expected;
    if !rate_is_other && shift.abs() <= by_digits(campaign, latitude_step(site)).clamp(COMMON_VERTICAL, COMMON_RATE) {
        return None;
    }
    let shift = if rate_is_other { shift.abs().max((rate - EARTH).abs() * sin.abs()) } else { shift.abs() };
    let (symptom, cause, expected) = if rate_is_other {
        (Symptom::StaticRate, MistakeKind::OtherEarthRate { arcsec_s: rate }, EARTH)
    } else {
        (Symptom::VerticalRate, other_latitude(vertical, rate), expected)
    };
    let (dwells, matters) = (still(campaign, measures, symptom), TrialFits::new(campaign).moved_by_rate(shift));
    let found = CommandFinding::of_all(symptom, vec![cause], dwells, matters);
    Some(CommandFinding { expected: Some(expected), ..found })
}

/// Rates that are the Earth's, but not at the attitude: only the outputs tell which of the two is wrong, and the fit
/// rests on the rates.
fn headings(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let (n, of) = (measures.dwells.len(), measures.still().count());
    let off = |k: &usize| measures.dwells[*k].off.is_some_and(|off| off > HEADING_ROOM);
    let dwells: Vec<usize> = (0..n).filter(off).collect();
    if (dwells.len() as f64) <= SINGLE * of as f64 {
        return None;
    }
    let mut trial_fits = TrialFits::new(campaign);
    let families = mistakes().into_iter().chain([other_headings()]);
    let causes = explained(campaign, measures, families, |_| true, &mut trial_fits);
    let matters = trial_fits.fits_better_undone() && trial_fits.earth_is_above_noise();
    let dwells = dwells.into_iter().map(|k| (k, measures.dwells[k].value(Symptom::Heading))).collect();
    (matters && !causes.is_empty())
        .then(|| CommandFinding { of, ..CommandFinding::of_all(Symptom::Heading, causes, dwells, matters) })
}

/// A mirrored body leaves specific force and rate at peace with the Earth and with one another. Where E is fitted its
/// direction tells; where it is held, and no attitude speaks, the outputs do.
fn outputs(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let held = campaign.gyros.iter().all(|gyro| gyro.known_e.is_some());
    if !held || measures.dwells.iter().any(|m| m.tilt.is_some()) {
        return None;
    }
    let mut trial_fits = TrialFits::new(campaign);
    let left = trial_fits.left_beyond_noise()?;
    let n = measures.dwells.len();
    let undone = single_axes().into_iter().filter_map(|m| Some((m.cause, m.undone(campaign, |_| true)?)));
    let right = undone.filter(|(_, c)| Measures::of(c).good() == n).map(|(cause, c)| (cause, TrialFit::of(&c)));
    let mut causes = trial_fits.best(right.collect(), CLEARLY);
    causes.truncate(MOST_CAUSES);
    let dwells = (0..campaign.dwells.len()).map(|k| (k, left)).collect();
    (!causes.is_empty())
        .then(|| CommandFinding::of_all(Symptom::Output, causes, dwells, trial_fits.earth_is_above_noise()))
}

/// Turning rates without the Earth's, or with it reversed, break no rule by themselves. But the vertical part of the
/// Earth's rate then makes no sense of rotation faster, or the wrong one; and the outputs tell.
fn earth_rate_while_turning(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let turning = |sense: f64| {
        let rates = measures.dwells.iter().filter(|m| m.phase == Phase::Rate).map(|m| sense * m.vertical);
        median_of(rates.filter(|rate| *rate > 0.0))
    };
    let faster = 0.5 * (turning(1.0)? - turning(-1.0)?);
    let vertical = measures.vertical?;
    if (faster - vertical).abs() < 0.5 * vertical.abs() {
        return None;
    }
    let added = with_earth_rate(campaign, AffectedDwells::Turning).ok()?;
    let reversed = with_earth_rate(&added, AffectedDwells::Turning).ok()?;
    let mut trial_fits = TrialFits::new(campaign);
    let left = trial_fits.left_beyond_noise()?;
    let tried = [(MistakeKind::EarthRateLeftOut, &added), (MistakeKind::NedForEnu, &reversed)];
    let causes = trial_fits.best(tried.map(|(cause, right)| (cause, TrialFit::of(right))).into(), BETTER);
    let turning = campaign.dwells.iter().enumerate().filter(|(_, dwell)| dwell.phase == Phase::Rate);
    let dwells = turning.map(|(k, _)| (k, left)).collect();
    (!causes.is_empty()).then(|| CommandFinding::of_all(Symptom::Output, causes, dwells, true))
}

/// Median of |f| of static dwells over gravity (g0), and its standard deviation.
fn force_ratio(measures: &Measures, gravity: f64) -> Option<(f64, f64)> {
    median_and_error(|| measures.still().map(|m| m.force / gravity))
}

/// A median and its standard deviation.
fn median_and_error<T: Iterator<Item = f64>>(values: impl Fn() -> T) -> Option<(f64, f64)> {
    let median = median_of(values())?;
    let spread = median_of(values().map(|value| (value - median).abs())).unwrap_or(0.0);
    Some((median, MEDIAN_ERROR * SD_OF_MEDIAN * spread / (values().count() as f64).sqrt()))
}

/// By what share the specific force of static dwells is longer than the site's gravity, where that is neither chance
/// nor the rounding of the latter: too little for a finding, but D_I and D_S are smaller by it. And whether rounding of
/// the former explains it.
pub fn force_off_gravity(campaign: &Campaign) -> Option<(f64, bool)> {
    let gravity = campaign.site?.gravity_g0;
    let (ratio, error) = force_ratio(&Measures::of(campaign), gravity)?;
    let share = ratio - 1.0;
    let least = (0.5 * decimal_step([gravity].into_iter()) / gravity).max(3.0 * error).max(LEAST_SHARE);
    let step = step_at_rest(campaign, |d| d.specific_force_g0);
    (least..FORCE_ROOM).contains(&share.abs()).then_some((share, share.abs() * gravity < step))
}

/// The latitude that static rates are made with (degrees), and by how much their vertical part is off that of the site
/// (arcsec/s), where printed digits do not explain it: too little for a finding, but D_I is off by it.
pub fn latitude_of_rates(campaign: &Campaign) -> Option<(f64, f64)> {
    let (site, measures) = (campaign.site?, Measures::of(campaign));
    let rate = median_of(measures.still().map(|m| m.rate))?;
    let (vertical, error) = median_and_error(|| measures.still().map(|m| m.vertical))?;
    let off = (vertical - measures.vertical?).abs();
    let least = by_digits(campaign, latitude_step(site).min(LATITUDE_STEP)).max(3.0 * error).max(LEAST_SHARE * EARTH);
    let is_earths = (rate - EARTH).abs() <= COMMON_RATE;
    (is_earths && off > least).then_some((latitude(vertical, rate), off))
}

/// Of the last digit of the site's latitude, degrees.
fn latitude_step(site: Site) -> f64 {
    decimal_step([site.latitude.to_degrees()].into_iter())
}

/// What the digits of static rates and of the latitude leave of the vertical part of the Earth's rate, arcsec/s.
fn by_digits(campaign: &Campaign, latitude_step: f64) -> f64 {
    0.5 * (step_at_rest(campaign, |d| d.rate_arcsec_s) + EARTH * latitude_step.to_radians())
}

/// Of the last digit of a vector of the static dwells.
fn step_at_rest(campaign: &Campaign, of: fn(&Dwell) -> Vector3<f64>) -> f64 {
    let still = campaign.dwells.iter().filter(|dwell| dwell.phase == Phase::Static);
    decimal_step(still.flat_map(|dwell| <[f64; 3]>::from(of(dwell))))
}

/// Whether specific force has the length that gravity has.
fn gravity(campaign: &Campaign, measures: &Measures) -> Option<CommandFinding> {
    let expected = campaign.site.map(|site| site.gravity_g0);
    let gravity = expected.unwrap_or(1.0);
    let dwells = still(campaign, measures, Symptom::Gravity);
    let (ratio, error) = force_ratio(measures, gravity)?;
    let finding = |cause, matters| {
        let found = CommandFinding::of_all(Symptom::Gravity, Vec::from_iter(cause), dwells.clone(), matters);
        Some(CommandFinding { expected: Some(gravity), ..found })
    };
    if (ratio - 1.0).abs() > FORCE_ROOM {
        let units = [("m/s^2", 9.806_65), ("mg", 1e3), ("cm/s^2", 980.665), ("ft/s^2", 32.174)];
        let unit = units.into_iter().find(|(_, size)| (ratio / size - 1.0).abs() < FORCE_ROOM);
        return finding(unit.map(|(unit, _)| MistakeKind::ForceUnit { unit }), true);
    }
    let common = (ratio - 1.0).abs() > 3.0 * error;
    let impossible = expected.is_none() && !(GRAVITY_ON_EARTH.0..=GRAVITY_ON_EARTH.1).contains(&ratio);
    let worth_telling = expected.is_some() && (ratio - 1.0).abs() > 1e-4;
    if !common || !(impossible || worth_telling) {
        return None;
    }
    let matters = TrialFits::new(campaign).moved_by_force(ratio);
    let normalised = expected.is_some() && (ratio * gravity - 1.0).abs() < 1e-5 + 3.0 * error;
    let cause = if normalised { MistakeKind::ForceNormalised } else { MistakeKind::ForceScale { ratio } };
    // A measured specific force is rarely right to a per mille; where it moves nothing, nothing is said of less.
    if matters || (ratio - 1.0).abs() > 1e-3 { finding(Some(cause), matters) } else { None }
}
