//! Optional columns of the dwells, which some or all of them may lack, and what there is to note about them.

use super::commanded::{findings, median};
use super::{Campaign, CampaignNote, Column, Dwell, Phase};
use crate::core::note::Note;

impl Campaign {
    /// Whether any dwell states standard errors.
    pub fn states_errors(&self) -> bool {
        self.dwells.iter().any(|d| d.output_sem_pulse_s.is_some())
    }

    /// Standard errors of gyro `j` by dwell, none where no dwell states any. A dwell without one gets the median of those of its phase (of
    /// all, where its phase has none), each brought to its duration: means over longer times scatter less.
    pub fn errors_of(&self, j: usize) -> Option<Vec<f64>> {
        let own = |d: &Dwell| d.output_sem_pulse_s.as_ref().map(|sem| sem[j]);
        if !self.states_errors() {
            return None;
        }
        let per_root_s = |phase: Option<Phase>| {
            let of_phase = self.dwells.iter().filter(|d| phase.is_none_or(|phase| d.phase == phase));
            median(of_phase.filter_map(|d| Some(own(d)? * d.duration_s.sqrt())))
        };
        let usual =
            |d: &Dwell| per_root_s(Some(d.phase)).or_else(|| per_root_s(None)).unwrap_or(1.0) / d.duration_s.sqrt();
        Some(self.dwells.iter().map(|d| own(d).unwrap_or_else(|| usual(d))).collect())
    }
}

/// What the dwells lack and what is odd about them: for the campaign's answer.
pub fn notes(campaign: &Campaign) -> Vec<Note> {
    let mut notes: Vec<CampaignNote> = findings(campaign).into_iter().map(CampaignNote::Commanded).collect();
    if notes.is_empty() {
        notes.extend(rate_not_of_attitude(campaign));
    }
    let mut notes: Vec<Note> = notes.into_iter().map(Note::Campaign).collect();
    let lacks = |column, has: fn(&Dwell) -> bool| {
        let dwells: Vec<usize> = (0..campaign.dwells.len()).filter(|&k| !has(&campaign.dwells[k])).collect();
        let of = campaign.dwells.len();
        let all = dwells.len() == of;
        (all, (!all && !dwells.is_empty()).then_some(Note::Campaign(CampaignNote::Missing { column, dwells, of })))
    };
    let (none, some) = lacks(Column::Attitude, |d| d.attitude.is_some());
    notes.extend(none.then_some(Note::NoAttitudes).or(some));
    notes.extend(campaign.site.is_none().then_some(Note::NoSite));
    let (none, some) = lacks(Column::Temperature, |d| d.temperature_c.is_some());
    notes.extend(none.then_some(Note::NoTemperatures).or(some));
    notes.extend(temperature_outliers(campaign));
    notes.extend(lacks(Column::StandardErrors, |d| d.output_sem_pulse_s.is_some()).1);
    notes
}

/// Dwells whose temperature is left out.
pub(crate) fn temperature_outliers(campaign: &Campaign) -> impl Iterator<Item = Note> {
    let temperatures = campaign.temperatures();
    let median = temperatures.median;
    let note = move |(dwell, celsius)| Note::Campaign(CampaignNote::TemperatureOutlier { dwell, celsius, median });
    temperatures.outliers.into_iter().map(note)
}

/// By how much the commanded rate of a static dwell may differ from the Earth's, arcsec/s: a heading that is 2 degrees off.
const EARTH_RATE_OFF: f64 = 0.5;

/// Static dwells whose rate is not the Earth's at their attitude. It is no fault: the model is fitted to what was commanded.
fn rate_not_of_attitude(campaign: &Campaign) -> Option<CampaignNote> {
    let earth = campaign.site?.earth_rate();
    let still = || campaign.dwells.iter().enumerate().filter(|(_, d)| d.phase == Phase::Static);
    let off = |(k, d): (usize, &Dwell)| Some((k, (d.rate_arcsec_s - (d.attitude? * earth).0).norm()));
    let off: Vec<(usize, f64)> = still().filter_map(off).filter(|(_, off)| *off > EARTH_RATE_OFF).collect();
    let (dwell, most_arcsec_s) = off.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(CampaignNote::RateNotOfAttitude { off: off.len(), of: still().count(), dwell, most_arcsec_s })
}
