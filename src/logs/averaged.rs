//! Tables whose rows are averages already: one row, one dwell.

use std::ops::Range;

use nalgebra::Vector3;

use super::assemble::{
    Commanded, Dwell, TURNING, agree, align_programme, by_accelerometers, missing, one_clock, table,
};
use super::error::LogError;
use super::gather::{counted, same_layout};
use super::map::{Columns, Map, Reading, TableColumns};
use super::repeats::Rows;
use super::source::Source;
use super::text::SkippedLines;
use super::units::{Counts, Quantity, Unit};
use crate::core::campaign::{Phase, Site};
use crate::core::dwells::explained::is_another;
use crate::core::dwells::programme::{Clock, LoggedInterval, Position, REST_ARCSEC_S, Table, clock_offset};
use crate::core::frames::{Body, Nav, Rotation, Vector};
use crate::core::message::{Message, figure};
use crate::core::units::EARTH_RATE_DEG_H;
use crate::message;

/// More rows than any table has positions: samples that were taken for averages.
const MOST_ROWS: usize = 20_000;
/// Room about the Earth's rate of what a table's rates at rest are, relative.
const EARTHS: f64 = 0.05;
/// Output, in the smaller ones of a table, that is a turn's: the Earth and gravity make less difference at rest.
const LARGER: f64 = 30.0;
/// Room about the length one of an attitude.
const LENGTH: f64 = 0.01;

/// One row, as it stands.
struct Row {
    start_s: Option<f64>,
    duration_s: Option<f64>,
    output: Vec<f64>,
    sem: Vec<f64>,
    force: Option<Vector3<f64>>,
    rate: Vec<f64>,
    attitude: Option<Rotation<Nav, Body>>,
    temperature_c: Option<f64>,
}

/// The dwells of a table of averages.
///
/// # Errors
/// Columns that are not there; more rows than any campaign has; what nothing says of the commands.
pub fn dwells(
    map: &Map,
    sources: &mut [(String, Source)],
    site: Option<Site>,
    programme: Option<&[Position]>,
) -> Result<(Vec<Dwell>, Unit, Vec<Message>), LogError> {
    let of_map = |fault: Message| LogError::new("map", fault);
    let output = map.output.find("output", Quantity::Output, sources)?;
    let counts = output.unit.counts;
    let has_duration = map.duration.is_some() || map.samples.is_some() && map.rate_hz.is_some();
    if counts == Counts::Total || counts == Counts::Increment && !has_duration {
        return Err(of_map(message!("averaged_counts")));
    }
    if map.logs() > 1 {
        return Err(of_map(message!("averaged_beside")));
    }
    let (rows, mut remarks) = rows(map, sources, counts, &output.unit_name)?;
    let has = |what: fn(&Row) -> bool| rows.first().is_some_and(what);
    remarks.insert(0, message!("averaged_rows", count = rows.len()));
    if !has(|row| !row.sem.is_empty()) {
        remarks.push(message!("averaged_errors"));
    }
    if !has(|row| row.duration_s.is_some()) {
        remarks.push(message!("averaged_durations"));
    }
    let spans = spans(&rows);
    let inertial = inertial(map, &rows, &mut remarks).map_err(of_map)?;
    let turns: Vec<Option<f64>> = rows.iter().map(|row| turn(row, inertial, site)).collect();
    let positions = match programme {
        Some(programme) => {
            positions((map, counts, site), &rows, &turns, &spans, programme, &mut remarks).map_err(of_map)?
        }
        None => vec![None; rows.len()],
    };
    if programme.is_none() && map.rate.is_none() {
        at_rest(&rows, counts).map_err(of_map)?;
    }
    let unit = Unit { counts: if counts == Counts::Increment { Counts::Rate } else { counts }, ..output.unit };
    let counts = unit.counts;
    let direction_only = map.force.as_ref().is_some_and(|f| f.direction_only);
    let mut made = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        if programme.is_some() && positions[k].is_none() {
            continue;
        }
        let of_row = commanded(row, positions[k], turns[k], inertial, site, counts, direction_only);
        made.push(Dwell {
            commanded: of_row.map_err(of_map)?,
            start_s: spans[k].0,
            duration_s: row.duration_s.unwrap_or(1.0),
            temperature_c: row.temperature_c,
            output: row.output.clone(),
            output_sem: row.sem.clone(),
        });
    }
    contradicted(&made, &rows, &positions, programme.is_some()).map_err(of_map)?;
    Ok((made, unit, remarks))
}

/// What was commanded in a row, or stands for it; `position`: by the programme.
fn commanded(
    row: &Row,
    position: Option<Position>,
    turn: Option<f64>,
    inertial: bool,
    site: Option<Site>,
    counts: Counts,
    direction_only: bool,
) -> Result<Commanded, Message> {
    let turning = turn.filter(|turn| turn.abs() >= REST_ARCSEC_S);
    let own = row.attitude.map(|attitude| Position {
        attitude,
        turn_arcsec_s: turning.unwrap_or(0.0),
        start_s: None,
        duration_s: None,
    });
    let no_site = || message!("map_site_missing");
    match (position.or(own), &row.rate[..]) {
        (position, &[x, y, z]) if inertial && (position.is_some() || row.force.is_some()) => {
            let of_position = |p: Position| site.map(|site| p.commanded(&site).0);
            let by_turn = if turning.is_some() { Phase::Rate } else { Phase::Static };
            Ok(Commanded {
                phase: position.map_or(by_turn, |p| p.phase()),
                attitude: position.map(|p| p.attitude),
                force_g0: position.and_then(of_position).or(row.force).ok_or_else(no_site)?,
                rate_arcsec_s: Vector3::new(x, y, z),
            })
        }
        (Some(position), _) => {
            let (force_g0, rate_arcsec_s) = position.commanded(&site.ok_or_else(no_site)?);
            Ok(Commanded { phase: position.phase(), attitude: Some(position.attitude), force_g0, rate_arcsec_s })
        }
        (None, _) => by_accelerometers(row.force, turn, site, counts, direction_only),
    }
}

/// Which readings of a row are what.
struct ReadingLayout {
    readings: Vec<Reading>,
    output: Range<usize>,
    sem: Range<usize>,
    force: Range<usize>,
    rate: Range<usize>,
    angles: Range<usize>,
    time: Range<usize>,
    duration: Range<usize>,
    temperature: Range<usize>,
    attitude: Range<usize>,
    samples: Range<usize>,
}

impl ReadingLayout {
    /// `unit`: of the output.
    fn of(map: &Map, sources: &[(String, Source)], unit: &str) -> Result<Self, LogError> {
        let mut readings: Vec<Reading> = Vec::new();
        // The places of some columns among all; none where the map has no such key. What is of no quantity has no unit.
        let mut places = |key, columns: Option<&Columns>, of: Option<Quantity>, allowed: &[usize]| {
            let from = readings.len();
            if let Some(columns) = columns {
                let found = match of {
                    Some(of) => columns.find(key, of, sources)?.readings,
                    None => columns.plain(key, sources)?,
                };
                counted(key, found.len(), allowed)?;
                readings.extend(found);
            }
            Ok::<_, LogError>(from..readings.len())
        };
        let gyros = map.output.columns.len();
        let sem = map.standard_error.as_ref().map(|columns| columns.or_unit(unit));
        let angles = map.table.as_ref().map(TableColumns::as_columns);
        Ok(Self {
            output: places("output", Some(&map.output), Some(Quantity::Output), &[1, 2, 3])?,
            sem: places("standard_error", sem.as_ref(), Some(Quantity::Output), &[gyros])?,
            force: places("force", map.force.as_ref(), Some(Quantity::Force), &[3])?,
            rate: places("rate", map.rate.as_ref(), Some(Quantity::Rate), &[1, 3])?,
            angles: places("table", angles.as_ref(), Some(Quantity::Angle), &[2])?,
            time: places("time", map.time.as_ref(), Some(Quantity::Time), &[1])?,
            duration: places("duration", map.duration.as_ref(), Some(Quantity::Time), &[1])?,
            temperature: places("temperature", map.temperature.as_ref(), Some(Quantity::Temperature), &[1])?,
            attitude: places("attitude", map.attitude.as_ref(), None, &[4])?,
            samples: places("samples", map.samples.as_ref(), None, &[1])?,
            readings,
        })
    }

    /// What the numbers of a row say; `hz`: of its samples, where it states how many they are.
    fn row(&self, row: &[f64], hz: Option<f64>, counts: Counts, table: Option<Table>) -> Result<Row, Message> {
        let value = |k: usize| self.readings[k].factor * row[k] + self.readings[k].offset;
        let of = |places: &Range<usize>| -> Vec<f64> { places.clone().map(value).collect() };
        let one = |places: &Range<usize>| places.clone().next().map(value);
        let counted = one(&self.samples).and_then(|samples| Some(samples.max(1.0) / hz?));
        let duration_s = one(&self.duration).or(counted);
        if let Some(duration_s) = duration_s.filter(|d| *d <= 0.0) {
            return Err(message!("averaged_duration", seconds = figure(duration_s, 3)));
        }
        // Pulses of a whole dwell are a rate by its length.
        let per = if counts == Counts::Increment { duration_s.unwrap_or(1.0) } else { 1.0 };
        let sem: Vec<f64> = of(&self.sem).iter().map(|v| v / per).collect();
        if let Some(wrong) = sem.iter().find(|v| **v <= 0.0) {
            return Err(message!("averaged_error", value = figure(*wrong, 4)));
        }
        let attitude = match of(&self.attitude)[..] {
            [w, x, y, z] => {
                let length = (w * w + x * x + y * y + z * z).sqrt();
                if (length - 1.0).abs() > LENGTH {
                    return Err(message!("averaged_attitude", length = figure(length, 4)));
                }
                Some(Rotation::from_attitude([w, x, y, z]))
            }
            _ => None,
        };
        let of_table = |table: Table| table.attitude(value(self.angles.start), value(self.angles.start + 1));
        Ok(Row {
            start_s: one(&self.time),
            duration_s,
            output: of(&self.output).iter().map(|v| v / per).collect(),
            sem,
            force: (!self.force.is_empty()).then(|| Vector3::from_vec(of(&self.force))),
            rate: of(&self.rate),
            attitude: attitude.or(table.map(of_table)),
            temperature_c: one(&self.temperature).filter(|t| t.is_finite()),
        })
    }
}

fn rows(
    map: &Map,
    sources: &mut [(String, Source)],
    counts: Counts,
    unit: &str,
) -> Result<(Vec<Row>, Vec<Message>), LogError> {
    let places = ReadingLayout::of(map, sources, unit)?;
    let table = table(map)?;
    let wanted: Vec<usize> = places.readings.iter().map(|r| r.column).collect();
    let hz = map.rate_hz.filter(|hz| *hz > 0.0);
    let (mut found, mut incomplete, mut bad) = (Vec::new(), 0_usize, SkippedLines::default());
    let mut seen: Vec<Rows> = Vec::new();
    let mut each = |seen: &mut Rows, row: &[f64]| {
        seen.see(row, None);
        // A temperature may be missing in some dwells.
        let may_be_empty = |k: usize| places.temperature.contains(&k);
        if row.iter().enumerate().any(|(k, v)| v.is_nan() && !may_be_empty(k)) {
            incomplete += 1;
            return Ok(());
        }
        if found.len() == MOST_ROWS {
            return Err(message!("averaged_many", most = MOST_ROWS));
        }
        found.push(places.row(row, hz, counts, table)?);
        Ok(())
    };
    for k in 0..sources.len() {
        same_layout(&sources[0], &sources[k])?;
        let (place, source) = &mut sources[k];
        let mut own = Rows::new(place);
        bad.add(source.rows(place, &wanted, &mut |row| each(&mut own, row))?);
        let twice = || seen.iter().find_map(|earlier| own.again(earlier));
        if let Some(fault) = source.several(&wanted).or_else(twice) {
            return Err(LogError::new(place.as_str(), fault));
        }
        seen.push(own);
    }
    if found.is_empty() {
        return Err(LogError::new(&sources[0].0, message!("no_rows", count = incomplete)));
    }
    let mut remarks = Vec::new();
    if incomplete > 0 {
        remarks.push(message!("rows_incomplete", count = incomplete));
    }
    remarks.extend(bad.remark());
    Ok((found, remarks))
}

/// Outputs of rows in which nothing says that the table turned must be those of rest.
fn at_rest(rows: &[Row], counts: Counts) -> Result<(), Message> {
    let size = |row: &Row| row.output.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut sizes: Vec<f64> = rows.iter().map(size).collect();
    sizes.sort_by(f64::total_cmp);
    let most = if counts == Counts::Angular { TURNING } else { LARGER * sizes[sizes.len() / 10] };
    let turning = sizes.iter().filter(|size| **size > most && **size > REST_ARCSEC_S).count();
    if turning == 0 { Ok(()) } else { Err(message!("averaged_turning", count = turning, of = rows.len())) }
}

/// Begin and end of each row: as stated, else one after the other.
fn spans(rows: &[Row]) -> Vec<(f64, f64)> {
    let first = rows[0].start_s.unwrap_or(0.0);
    // A clock that counts from 1970, or from midnight, begins with the first row.
    let origin = if !(0.0..=86_400.0).contains(&first) { first } else { 0.0 };
    let mut clock = 0.0;
    let span = |row: &Row| {
        let start = row.start_s.map_or(clock, |start| start - origin);
        clock = start + row.duration_s.unwrap_or(1.0);
        (start, clock)
    };
    rows.iter().map(span).collect()
}

/// Whether three rates are inertial, with the Earth's rate in them: as the map says, or as they are at rest.
fn inertial(map: &Map, rows: &[Row], remarks: &mut Vec<Message>) -> Result<bool, Message> {
    if rows[0].rate.len() != 3 {
        return Ok(false);
    }
    let stated = map.rate.as_ref().and_then(|rate| rate.inertial);
    let length = |row: &Row| row.rate.iter().map(|c| c * c).sum::<f64>().sqrt();
    let least = rows.iter().map(length).fold(f64::INFINITY, f64::min);
    let earths = (least / EARTH_RATE_DEG_H - 1.0).abs() < EARTHS;
    let found = match stated {
        Some(stated) => stated,
        None if earths => true,
        None if least < EARTHS * EARTH_RATE_DEG_H => false,
        None => return Err(message!("rates_unknown", least = figure(least, 2))),
    };
    remarks.push(if found { message!("rates_inertial") } else { message!("rates_table") });
    Ok(found)
}

/// Rate of the table about the vertical, arcsec/s.
fn turn(row: &Row, inertial: bool, site: Option<Site>) -> Option<f64> {
    let stated = row.attitude.map(|attitude| (attitude * Vector::new(Vector3::z())).0);
    let up = stated.or(row.force.and_then(|force| force.try_normalize(0.0)));
    match (&row.rate[..], up) {
        (&[rate], _) => Some(rate),
        (&[x, y, z], up) => {
            let rate = Vector3::new(x, y, z);
            let along = up.map_or(rate.norm(), |up| rate.dot(&up));
            Some(if inertial { along - site.map_or(0.0, |site| site.earth_rate().0.z) } else { along })
        }
        _ => None,
    }
}

fn positions(
    of: (&Map, Counts, Option<Site>),
    rows: &[Row],
    turns: &[Option<f64>],
    spans: &[(f64, f64)],
    programme: &[Position],
    remarks: &mut Vec<Message>,
) -> Result<Vec<Option<Position>>, Message> {
    let up = |row: &Row| row.force.and_then(|force| force.try_normalize(0.0));
    let seen: Vec<LoggedInterval> =
        rows.iter().zip(turns).map(|(row, turn)| LoggedInterval { up: up(row), turn_arcsec_s: *turn }).collect();
    let blind = seen.iter().all(|s| s.up.is_none() && s.turn_arcsec_s.is_none());
    let clock = rows[0].start_s.and_then(|_| clock_offset(spans, &seen, programme));
    if rows[0].start_s.is_some() {
        remarks.extend(one_clock(clock, spans, &seen, programme)?);
    }
    let matched: Vec<Option<usize>> = match clock {
        Some(Clock { offset_s: offset, .. }) => {
            remarks.push(message!("programme_clock", seconds = figure(offset, 2)));
            spans.iter().map(|span| by_the_clock(*span, programme, offset)).collect()
        }
        None if blind && rows.len() != programme.len() => {
            return Err(message!("programme_count", intervals = rows.len(), rows = programme.len()));
        }
        None => {
            let means = rows.iter().map(|row| row.output.clone()).collect();
            align_programme(of, &seen, spans.to_vec(), means, programme)?
        }
    };
    let taken: Vec<usize> = matched.iter().flatten().copied().collect();
    if is_another(taken.len(), rows.len()) {
        let (matched, intervals, rows) = (taken.len(), rows.len(), programme.len());
        return Err(message!("programme_other", matched, intervals, rows));
    }
    if taken.len() < rows.len() {
        remarks.push(message!("programme_left", count = rows.len() - taken.len()));
    }
    remarks.extend(missing(&taken, programme));
    Ok(matched.into_iter().map(|row| row.map(|row| programme[row])).collect())
}

/// The position whose time a span has most of, where it is at least half of the span.
fn by_the_clock((from, to): (f64, f64), programme: &[Position], offset: f64) -> Option<usize> {
    let shared = |p: &Position| {
        let start = p.start_s? + offset;
        Some((to.min(start + p.duration_s?) - from.max(start)).max(0.0))
    };
    let all = programme.iter().enumerate().filter_map(|(row, p)| Some((row, shared(p)?)));
    let best = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (best.1 >= 0.5 * (to - from)).then_some(best.0)
}

/// A stated force, or rate at rest, must agree with the position that was stated too.
fn contradicted(
    dwells: &[Dwell],
    rows: &[Row],
    positions: &[Option<Position>],
    programme: bool,
) -> Result<(), Message> {
    let kept = rows.iter().zip(positions).filter(|(_, position)| !programme || position.is_some());
    let off: Vec<(f64, f64)> = dwells
        .iter()
        .zip(kept)
        .filter(|(dwell, _)| dwell.commanded.attitude.is_some())
        .filter_map(|(dwell, (row, _))| Some((dwell.start_s, row.force?.angle(&dwell.commanded.force_g0))))
        .collect();
    agree(&off)
}
