//! From logs and a map to the campaign's document.

use std::path::PathBuf;

use super::assemble::{Commanded, Dwell, assemble, one_orientation};
use super::clock::Epoch;
use super::error::LogError;
use super::gather::{LogSeries, gather};
use super::map::Map;
use super::source::{Source, name};
use super::units::{Counts, Quantity, Unit};
use super::{averaged, programme};
use crate::core::campaign::{Campaign, Phase, Site};
use crate::core::dwells::explained::{Contradiction, contradiction, input_axis};
use crate::core::dwells::programme::Position;
use crate::core::fault::Faults;
use crate::core::message::{Message, figure, list, sent, text};
use crate::core::time::UtcMicros;
use crate::core::units::radians;
use crate::message;
use crate::wire::campaign::{CampaignBody, CampaignGyroBody, DwellBody, commanded};
use crate::wire::numbers::tidy;
use crate::wire::time;

pub struct LogCampaign {
    pub body: CampaignBody,
    pub dwells: Vec<Dwell>,
    pub remarks: Vec<Message>,
    /// None of a log of averages.
    pub gathered: Option<LogSeries>,
    /// The unit of the outputs.
    unit: Unit,
}

/// |E| of gyros that measure rates of turn, whose pulse is one arcsec.
const ONE_ARCSEC: std::ops::Range<f64> = 0.5..2.0;
/// Days by which the map's date may be off the log's clock: a day, and any zone.
const ONE_DATE_DAYS: f64 = 1.6;
/// 2021-01-01. Clocks that were never set begin in 1970, 1980, 2000 or 2020.
const EARLIEST: UtcMicros = UtcMicros(1_609_459_200_000_000);
/// Room about a unit's factor.
const UNIT_ROOM: f64 = 0.1;

impl LogCampaign {
    /// The campaign, held against the Earth.
    ///
    /// # Errors
    /// What is wrong with it. Of gyros that are quiet enough to see the Earth's horizontal rate the headings must be
    /// known: the fault that their lack makes is not the rates'.
    pub fn campaign(&self) -> Result<Campaign, Faults> {
        let campaign = self.body.to_core()?;
        let has_headings = self.dwells.iter().any(|dwell| dwell.commanded.attitude.is_some());
        let of_rates = |faults: &Faults| faults.0.iter().all(|fault| fault.pointer.ends_with("/rate_arcsec_s"));
        match commanded::check(&campaign) {
            Ok(()) => {
                let faults = self.other_scale(&campaign).or_else(|| contradicted(&campaign));
                faults.map_or(Ok(campaign), |message| Err(message.into()))
            }
            Err(faults) if !has_headings && of_rates(&faults) => Err(message!("commanded_heading_seen").into()),
            Err(faults) => Err(faults),
        }
    }

    /// Gyros that measure rates of turn, in another unit or at other rates than are stated.
    fn other_scale(&self, campaign: &Campaign) -> Option<Message> {
        let fitted = campaign.gyros.iter().enumerate().filter(|(_, gyro)| gyro.known_e.is_none());
        let scales = fitted.filter_map(|(j, gyro)| Some((gyro.slot, input_axis(campaign, j)?.norm())));
        let is_turned = campaign.dwells.iter().any(|dwell| dwell.phase == Phase::Rate);
        let mut off = scales.filter(|(_, scale)| !ONE_ARCSEC.contains(scale));
        let (slot, scale) = off.next().filter(|_| is_turned && self.unit.counts == Counts::Angular)?;
        let is_unit = |name: &&&str| {
            let unit = Quantity::Output.unit(name).filter(|unit| unit.counts == Counts::Angular);
            unit.is_some_and(|unit| (unit.factor * scale / self.unit.factor - 1.0).abs() < UNIT_ROOM)
        };
        let (slot, scale) = (slot.name(), figure(scale, 4));
        Some(match Quantity::Output.units().iter().find(is_unit) {
            Some(unit) => message!("output_other_unit", slot, scale, unit = *unit),
            None => message!("output_other_scale", slot, scale),
        })
    }
}

/// Outputs that contradict what was commanded, with the dwells.
fn contradicted(campaign: &Campaign) -> Option<Message> {
    let Contradiction { times, dwells, rest_agrees } = contradiction(campaign)?;
    let at = |k: &usize| text(format_args!("{} ({:.0} s)", k + 1, campaign.dwells[*k].start_s));
    let (dwells, times) = (list(dwells.iter().map(at)), figure(times, 0));
    Some(match rest_agrees {
        true => message!("outputs_contradict_in", dwells, times),
        false => message!("outputs_contradict", dwells, times, of = campaign.dwells.len()),
    })
}

/// Reads the logs once and makes their campaign.
///
/// # Errors
/// Why they hold none, with the file, and with line and column where there is one.
pub fn campaign_of(files: &[PathBuf], map: &Map, programme: Option<&str>) -> Result<LogCampaign, LogError> {
    let positions = programme.map(programme::read).transpose()?;
    let open = |path: &PathBuf| Ok((name(path), Source::open(path)?));
    let sources = files.iter().map(open).collect::<Result<Vec<_>, LogError>>()?;
    campaign_from(sources, map, positions.as_deref())
}

/// As [`campaign_of`], of logs that are open, each with its name.
pub fn campaign_from(
    mut sources: Vec<(String, Source)>,
    map: &Map,
    positions: Option<&[Position]>,
) -> Result<LogCampaign, LogError> {
    let site = site_of(map);
    let (dwells, unit, mut remarks, gathered) = if map.averaged {
        let (dwells, unit, remarks) = averaged::dwells(map, &mut sources, site, positions)?;
        (dwells, unit, remarks, None)
    } else {
        let place = sources.first().map(|(place, _)| place.clone()).unwrap_or_default();
        let mut gathered = gather(map, sources)?;
        gathered.remarks.extend(clock_agrees(map, &gathered)?);
        let made = assemble(map, &mut gathered, site, positions)
            .map_err(|error| if error.place == "log" { LogError { place, ..error } } else { error })?;
        (made.dwells, gathered.unit, made.remarks, Some(gathered))
    };
    if one_orientation(&dwells) {
        remarks.push(message!("one_orientation", count = dwells.len()));
    }
    let mut made = LogCampaign { body: body(map, &dwells, gathered.as_ref())?, dwells, remarks, gathered, unit };
    hold_e(&mut made, map)?;
    Ok(made)
}

/// That the map's date is that of the log's clock, but for the zone; what is said of a clock that was never set.
fn clock_agrees(map: &Map, log: &LogSeries) -> Result<Option<Message>, LogError> {
    let Some((stated, (epoch, began_s))) = map.measured_at.as_ref().zip(log.began) else { return Ok(None) };
    // What is no time is refused with the campaign.
    let Ok(at) = time::parse(stated) else { return Ok(None) };
    let ended_s = began_s + log.series.end_s(log.series.number.len());
    let [from, to] = [began_s, ended_s].map(|seconds| epoch.moment(seconds));
    if at >= from.plus_days(-ONE_DATE_DAYS) && at <= to.plus_days(ONE_DATE_DAYS) {
        return Ok(None);
    }
    let (stated, [from, to]) = (sent(stated), [began_s, ended_s].map(|seconds| text(epoch.written(seconds))));
    if epoch.moment(began_s) < EARLIEST {
        return Ok(Some(message!("clock_unset", from, stated)));
    }
    let fault = message!("clock_of_another_date", stated, from, to);
    Err(LogError::new("map", message!("at_map_key", key = "measured_at", fault)))
}

fn site_of(map: &Map) -> Option<Site> {
    let site = map.site.as_ref()?;
    let (latitude, gravity_g0) = (radians(site.latitude_deg), site.gravity_g0);
    Some(Site { latitude, gravity_g0, magnetic_field_nav: None })
}

fn body(map: &Map, dwells: &[Dwell], gathered: Option<&LogSeries>) -> Result<CampaignBody, LogError> {
    let missing = |key: &'static str| LogError::new("map", message!("map_missing", key));
    let began = gathered.and_then(|g| g.began).filter(|(epoch, _)| *epoch == Epoch::Unix);
    let began = began.map(|(epoch, began_s)| time::format(epoch.moment(began_s)));
    if map.gyros.is_empty() {
        return Err(missing("gyros"));
    }
    Ok(CampaignBody {
        imu: map.imu.clone().ok_or_else(|| missing("imu"))?,
        station: map.station.clone().ok_or_else(|| missing("station"))?,
        measured_at: map.measured_at.clone().or(began).ok_or_else(|| missing("measured_at"))?,
        geometry: map.geometry.clone().ok_or_else(|| missing("geometry"))?,
        site: map.site.clone(),
        station_uncertainty: None,
        gyros: map.gyros.iter().map(|text| gyro(text)).collect::<Result<_, _>>()?,
        dwells: dwells.iter().map(DwellBody::from).collect(),
        rates: None,
        test: None,
        model: None,
        temperature_c: None,
        operator: map.operator.clone(),
        note: map.note.clone(),
    })
}

fn gyro(text: &str) -> Result<CampaignGyroBody, LogError> {
    let parts = text.trim().split_once([' ', '=', ':']);
    let (slot, serial) =
        parts.ok_or_else(|| LogError::new("map", message!("not_slot_and_serial", text = sent(text))))?;
    let serial = serial.trim_start_matches(['=', ':', ' ']).trim().to_owned();
    Ok(CampaignGyroBody { slot: Some(slot.trim().to_owned()), serial, known_e_pulse_per_arcsec: None })
}

/// Where nothing turned at a known rate, E cannot be fitted. Of gyros that measure rates of turn it is the input axis:
/// one pulse is one arcsec.
fn hold_e(made: &mut LogCampaign, map: &Map) -> Result<(), LogError> {
    let known = match &map.known_e {
        Some(known) if known.len() != made.body.gyros.len() => {
            let fault = message!("map_known_e", have = known.len(), gyros = made.body.gyros.len());
            return Err(LogError::new("map", fault));
        }
        Some(known) => known.clone(),
        None if made.unit.counts != Counts::Angular || made.dwells.iter().any(|d| d.commanded.phase == Phase::Rate) => {
            return Ok(());
        }
        None => {
            let Some(axes) = map.input_axes() else { return Ok(()) };
            made.remarks.push(message!("e_held"));
            axes.into_iter().map(<[f64; 3]>::from).collect()
        }
    };
    for (gyro, e) in made.body.gyros.iter_mut().zip(known) {
        gyro.known_e_pulse_per_arcsec = Some(e.as_slice().into());
    }
    Ok(())
}

impl From<&Dwell> for DwellBody {
    fn from(d: &Dwell) -> Self {
        let Commanded { phase, attitude, force_g0, rate_arcsec_s } = &d.commanded;
        Self {
            phase: phase.name().to_owned(),
            start_s: d.start_s,
            duration_s: d.duration_s,
            attitude: attitude.map(|c| c.to_attitude().as_slice().into()),
            specific_force_g0: (&force_g0.map(tidy)).into(),
            rate_arcsec_s: (&rate_arcsec_s.map(tidy)).into(),
            temperature_c: d.temperature_c,
            output_pulse_s: d.output.as_slice().into(),
            output_sem_pulse_s: d
                .output_sem
                .first()
                .filter(|_| d.output_sem.iter().all(|sem| *sem > 0.0))
                .map(|_| d.output_sem.as_slice().into()),
        }
    }
}
