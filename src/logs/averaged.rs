//! Logs whose rows are averages already: one row, one dwell.

use nalgebra::Vector3;

use super::assemble::{Dwell, by_accelerometers};
use super::error::LogError;
use super::map::{Map, Reading};
use super::source::Source;
use super::units::{Counts, Quantity};
use crate::core::campaign::Site;
use crate::core::message::{Message, list};
use crate::message;

/// More rows than any table has positions: samples that were taken for averages.
const MOST_ROWS: usize = 20_000;

/// The dwells of a log of averages.
///
/// # Errors
/// Columns that are not there; more rows than any campaign has; what [`by_accelerometers`] cannot know.
pub fn dwells(
    map: &Map,
    sources: &mut [(String, Source)],
    site: Option<Site>,
) -> Result<(Vec<Dwell>, Counts, Vec<Message>), LogError> {
    let output = map.output.find("output", Quantity::Output, sources)?;
    let force = map.force.as_ref().map(|c| c.find("force", Quantity::Force, sources)).transpose()?;
    let temperature =
        map.temperature.as_ref().map(|c| c.find("temperature", Quantity::Temperature, sources)).transpose()?;
    let counts = output.unit.counts;
    let of_map = |fault: Message| LogError::new("map", fault);
    let Some(force) = force else { return Err(of_map(message!("commanded_unknown"))) };
    if matches!(counts, Counts::Increment | Counts::Total) {
        return Err(of_map(message!("averaged_counts")));
    }
    if force.readings.len() != 3 {
        let fault = message!("map_column_count", need = list(["3"]), have = force.readings.len());
        return Err(of_map(message!("at_map_key", key = "force", fault = fault)));
    }
    let mut readings: Vec<Reading> = [output.readings.clone(), force.readings].concat();
    readings.extend(temperature.iter().flat_map(|t| t.readings.first()));
    let (place, source) = &mut sources[0];
    let samples = match map.samples.as_ref().and_then(|c| c.columns.first()) {
        Some(name) => {
            let fault = |fault| LogError::new(&*place, message!("at_map_key", key = "samples", fault = fault));
            Some(name.find(source).map_err(fault)?.0)
        }
        None => None,
    };
    let mut wanted: Vec<usize> = readings.iter().map(|r| r.column).collect();
    wanted.extend(samples);
    let hz = map.rate_hz.filter(|hz| *hz > 0.0);
    let direction_only = map.force.as_ref().is_some_and(|f| f.direction_only);
    let gyros = output.readings.len();
    let mut dwells = Vec::new();
    let mut clock = 0.0;
    source.rows(place, &wanted, &mut |sample| {
        if sample.values.iter().any(|v| v.is_nan()) {
            return Ok(());
        }
        if dwells.len() == MOST_ROWS {
            return Err(message!("averaged_many", most = MOST_ROWS));
        }
        let value = |k: usize| readings[k].factor * sample.values[k] + readings[k].offset;
        let count = samples.map_or(1.0, |_| sample.values[readings.len()].max(1.0));
        let duration_s = count / hz.unwrap_or(1.0);
        let measured = Vector3::new(value(gyros), value(gyros + 1), value(gyros + 2));
        let commanded = by_accelerometers(Some(measured), None, site, counts, direction_only)?;
        dwells.push(Dwell {
            phase: commanded.phase,
            start_s: clock,
            duration_s,
            attitude: None,
            force_g0: commanded.force_g0,
            rate_arcsec_s: commanded.rate_arcsec_s,
            temperature_c: temperature.is_some().then(|| value(gyros + 3)),
            output: (0..gyros).map(value).collect(),
            output_sem: Vec::new(),
        });
        clock += duration_s;
        Ok(())
    })?;
    let mut remarks = vec![message!("averaged_rows", count = dwells.len())];
    if hz.is_none() || samples.is_none() {
        remarks.push(message!("averaged_durations"));
    }
    Ok((dwells, counts, remarks))
}
