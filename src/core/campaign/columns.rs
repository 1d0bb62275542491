//! What there is to note about the columns of the dwells, some of which may lack.

use std::ops::RangeInclusive;

use super::commanded::findings;
use super::contradicting::contradicting;
use super::temperatures::Temperatures;
use super::{Campaign, CampaignNote, Dwell, DwellColumn, Phase, stuck};
use crate::core::note::Note;
use crate::core::numerics::median::median_of;

/// What the dwells lack and what is odd about them: for the campaign's answer.
pub fn notes(campaign: &Campaign) -> Vec<Note> {
    let mut notes: Vec<CampaignNote> = findings(campaign).into_iter().map(CampaignNote::Commanded).collect();
    if notes.is_empty() {
        notes.extend(rate_not_of_attitude(campaign));
    }
    notes.extend(contradicting(campaign));
    notes.extend(stuck(campaign).into_iter().map(CampaignNote::OutputStuck));
    let mut notes: Vec<Note> = notes.into_iter().map(Note::Campaign).collect();
    let (none, some) = lacks(campaign, DwellColumn::Attitude, |d| d.attitude.is_some());
    notes.extend(none.then_some(Note::NoAttitudes).or(some));
    notes.extend(campaign.site.is_none().then_some(Note::NoSite));
    let (none, some) = lacks(campaign, DwellColumn::Temperature, |d| d.temperature_c.is_some());
    notes.extend(none.then_some(Note::NoTemperatures).or(some));
    notes.extend(temperature_outliers(campaign));
    let stated = [Temperatures::of(campaign).median].into_iter().chain(campaign.temperature_c);
    let in_another_unit = stated.filter(|celsius| !CALIBRATED_AT.contains(celsius));
    notes.extend(in_another_unit.take(1).map(|median| Note::Campaign(CampaignNote::TemperatureUnit { median })));
    notes.extend(time_unit(campaign).map(Note::Campaign));
    notes.extend(missing_errors(campaign));
    notes
}

/// How long a dwell may last, s, in the median: shorter or longer ones are in hours or in milliseconds.
const DWELLS_LAST: RangeInclusive<f64> = 1.0..=43_200.0;
/// A rate dwell goes over whole turns: where none turns by so much, degrees, times are in minutes or in hours.
const LEAST_TURN: f64 = 90.0;

/// Dwells whose times are in another unit: effects of time are then off by that factor.
fn time_unit(campaign: &Campaign) -> Option<CampaignNote> {
    let median_s = median_of(campaign.dwells.iter().map(|d| d.duration_s))?;
    let turns = campaign.dwells.iter().filter(|d| d.phase == Phase::Rate);
    let turn_deg = turns.map(|d| d.rate_arcsec_s.norm() * d.duration_s / 3600.0).reduce(f64::max);
    let turn_deg = turn_deg.filter(|turn| *turn > 0.0 && *turn < LEAST_TURN);
    (turn_deg.is_some() || !DWELLS_LAST.contains(&median_s)).then_some(CampaignNote::TimeUnit { median_s, turn_deg })
}

/// Temperatures at which gyros are calibrated, deg C. What lies outside is in kelvin or in degrees Fahrenheit.
const CALIBRATED_AT: RangeInclusive<f64> = -60.0..=100.0;

/// Whether all dwells lack a column, and what to note where some do.
fn lacks(campaign: &Campaign, column: DwellColumn, has: fn(&Dwell) -> bool) -> (bool, Option<Note>) {
    let of = campaign.dwells.len();
    let dwells: Vec<usize> = (0..of).filter(|&k| !has(&campaign.dwells[k])).collect();
    let all = dwells.len() == of;
    (all, (!all && !dwells.is_empty()).then_some(Note::Campaign(CampaignNote::Missing { column, dwells, of })))
}

/// Dwells whose standard errors are filled in.
fn missing_errors(campaign: &Campaign) -> Option<Note> {
    lacks(campaign, DwellColumn::StandardErrors, |d| d.output_sem_pulse_s.is_some()).1
}

/// Dwells whose temperature is left out.
fn temperature_outliers(campaign: &Campaign) -> impl Iterator<Item = Note> {
    let temperatures = Temperatures::of(campaign);
    let median = temperatures.median;
    let note = move |(dwell, celsius)| Note::Campaign(CampaignNote::TemperatureOutlier { dwell, celsius, median });
    temperatures.outliers.into_iter().map(note)
}

/// By how much the commanded rate of a static dwell may differ from the Earth's, arcsec/s: a heading that is 2
/// degrees off.
const EARTH_RATE_OFF: f64 = 0.5;

/// Static dwells whose rate is not the Earth's at their attitude. It is no fault: the model is fitted to what was
/// commanded.
fn rate_not_of_attitude(campaign: &Campaign) -> Option<CampaignNote> {
    let earth = campaign.site?.earth_rate();
    let still = || campaign.dwells.iter().enumerate().filter(|(_, d)| d.phase == Phase::Static);
    let off = |(k, d): (usize, &Dwell)| Some((k, (d.rate_arcsec_s - (d.attitude? * earth).0).norm()));
    let off: Vec<(usize, f64)> = still().filter_map(off).filter(|(_, off)| *off > EARTH_RATE_OFF).collect();
    let (dwell, most_arcsec_s) = off.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(CampaignNote::RateNotOfAttitude { off: off.len(), of: still().count(), dwell, most_arcsec_s })
}
