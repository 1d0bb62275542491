//! What a station says of its log, once: which columns are what, in which units, with which axes and signs.

use nalgebra::Vector3;
use serde::{Deserialize, Deserializer};

use super::error::LogError;
use super::source::Source;
use super::units::{Quantity, Unit};
use crate::core::message::{Message, list, sent};
use crate::core::mounting::Slot;
use crate::message;
use crate::wire::campaign::SiteBody;
use crate::wire::geometry::GeometryBody;
use crate::wire::text::map_fault;

/// A map, in TOML.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// Head of the campaign.
    pub imu: Option<String>,
    pub station: Option<String>,
    pub measured_at: Option<String>,
    pub geometry: Option<GeometryBody>,
    pub site: Option<SiteBody>,
    /// `G1 LFG-0101`, in the order of the outputs.
    #[serde(default)]
    pub gyros: Vec<String>,
    /// E that is held, pulse/arcsec, by gyro.
    pub known_e: Option<Vec<[f64; 3]>>,
    pub operator: Option<String>,
    pub note: Option<String>,
    /// The time column, or the rate of samples where there is none.
    pub time: Option<Columns>,
    pub rate_hz: Option<f64>,
    pub output: Columns,
    pub force: Option<Columns>,
    /// Rate of the table: one column about the vertical, or three in body axes, without the Earth's.
    pub rate: Option<Columns>,
    pub table: Option<TableColumns>,
    /// w, x, y, z of the campaign's attitude.
    pub attitude: Option<Columns>,
    pub temperature: Option<Columns>,
    /// Rows are averages already, one a dwell.
    #[serde(default)]
    pub averaged: bool,
    /// With `averaged`: how many samples each row is of, or how long it lasted.
    pub samples: Option<Columns>,
    pub duration: Option<Columns>,
    /// With `averaged`: standard errors of the outputs, in their unit where none is stated.
    pub standard_error: Option<Columns>,
    pub min_s: Option<f64>,
    pub cut_s: Option<f64>,
}

/// Columns of one kind.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    #[serde(alias = "column", deserialize_with = "one_or_more")]
    pub columns: Vec<ColumnName>,
    /// What the numbers are in after `scale` and `offset`; else the unit of the header.
    pub unit: Option<String>,
    /// value = scale * (number - offset), for all columns or each.
    #[serde(default, deserialize_with = "one_or_more")]
    pub scale: Vec<f64>,
    #[serde(default, deserialize_with = "one_or_more")]
    pub offset: Vec<f64>,
    /// Which of the logs named on the command line, from 1.
    pub log: Option<usize>,
    /// Of the force: believe its direction alone, and take the length from the site's gravity.
    #[serde(default)]
    pub direction_only: bool,
    /// Of three rates of averages: the Earth's is in them, or it is not.
    pub inertial: Option<bool>,
}

/// Angles of a two-axis table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableColumns {
    /// Outer axis, then inner.
    pub columns: [ColumnName; 2],
    pub unit: Option<String>,
    pub log: Option<usize>,
    /// Where the outer axis points: `east`, `north` or `up`, with a minus for the opposite.
    #[serde(default = "north")]
    pub outer: String,
    /// Body axis along the inner axis.
    #[serde(default = "z_axis")]
    pub inner: String,
    /// Body axes that point up and north with both angles at zero.
    #[serde(default = "z_axis")]
    pub zero_up: String,
    #[serde(default = "y_axis")]
    pub zero_north: String,
}

fn north() -> String {
    "north".to_owned()
}

fn z_axis() -> String {
    "+Z".to_owned()
}

fn y_axis() -> String {
    "+Y".to_owned()
}

/// A column by its name or number, with a minus where its sign is to be changed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum ColumnName {
    Number(i64),
    Name(String),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMore<T> {
    More(Vec<T>),
    One(T),
}

fn one_or_more<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    Ok(match OneOrMore::deserialize(from)? {
        OneOrMore::One(one) => vec![one],
        OneOrMore::More(more) => more,
    })
}

/// A column of a log, and what makes a value of its numbers: factor * number + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    pub log: usize,
    pub column: usize,
    pub factor: f64,
    pub offset: f64,
}

/// Columns as they were found, and what they were taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    pub readings: Vec<Reading>,
    pub unit: Unit,
    pub unit_name: String,
    pub header: Header,
}

/// What the header says of a unit.
#[derive(Debug, Clone, PartialEq)]
pub enum Header {
    Says,
    /// Nothing, or the map's unit too, or that of numbers before they are scaled.
    Silent,
    /// What is no unit here.
    Unknown(String),
}

impl std::fmt::Display for ColumnName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

impl Map {
    pub fn parse(text: &str) -> Result<Self, Message> {
        toml::from_str(text).map_err(|error| map_fault(&error, text))
    }

    /// Nominal input axes of the gyros, where all are known.
    pub fn input_axes(&self) -> Option<Vec<Vector3<f64>>> {
        let geometry = self.geometry.as_ref()?.to_core().ok()?;
        let slot = |text: &str| Slot::from_name(text.trim().split([' ', '=', ':']).next()?);
        self.gyros.iter().map(|text| Some(geometry.triad(slot(text)?)?.input())).collect()
    }

    /// How many logs run beside one another.
    pub fn logs(&self) -> usize {
        let of = |columns: &Option<Columns>| columns.as_ref().and_then(|c| c.log).unwrap_or(1);
        let table = self.table.as_ref().and_then(|t| t.log).unwrap_or(1);
        [of(&self.force), of(&self.rate), of(&self.attitude), of(&self.temperature), table]
            .into_iter()
            .fold(self.output.log.unwrap_or(1), usize::max)
    }
}

impl ColumnName {
    /// Place and sign in a log. A name that itself begins with a minus comes first.
    pub fn find(&self, source: &Source) -> Result<(usize, f64), Message> {
        match self {
            Self::Number(number) => {
                let columns = source.columns().len();
                let place = number.unsigned_abs() as usize;
                if place == 0 || place > columns {
                    return Err(message!("log_column_number", number = place, columns));
                }
                Ok((place - 1, if *number < 0 { -1.0 } else { 1.0 }))
            }
            Self::Name(name) => match (source.column(name), name.strip_prefix('-')) {
                (Ok(place), _) => Ok((place, 1.0)),
                (Err(fault), None) => Err(fault),
                (Err(_), Some(bare)) => source.column(bare).map(|place| (place, -1.0)),
            },
        }
    }
}

impl TableColumns {
    /// The angles' columns as any other signal's.
    pub fn as_columns(&self) -> Columns {
        let (columns, unit) = (self.columns.to_vec(), self.unit.clone());
        Columns { columns, unit, log: self.log, ..Columns::default() }
    }
}

impl Columns {
    /// The same in a unit, where none is stated.
    pub fn or_unit(&self, unit: &str) -> Self {
        Self { unit: self.unit.clone().or_else(|| Some(unit.to_owned())), ..self.clone() }
    }

    /// Columns of plain numbers: their places and signs.
    pub fn plain(&self, key: &'static str, sources: &[(String, Source)]) -> Result<Vec<Reading>, LogError> {
        let (log, (place, source)) = log_of(key, self.log, sources)?;
        let reading = |name: &ColumnName| {
            let (column, factor) = name.find(source)?;
            Ok(Reading { log, column, factor, offset: 0.0 })
        };
        let readings: Result<Vec<Reading>, Message> = self.columns.iter().map(reading).collect();
        readings.map_err(|fault| LogError::new(place, message!("at_map_key", key, fault)))
    }

    /// The columns in their log.
    ///
    /// # Errors
    /// No such log or column; a unit that is none of the quantity, is nowhere said, or is not that of the header.
    pub fn find(&self, key: &'static str, of: Quantity, sources: &[(String, Source)]) -> Result<Found, LogError> {
        let (log, (place, source)) = log_of(key, self.log, sources)?;
        let fail = |fault: Message| LogError::new(place, message!("at_map_key", key, fault));
        let count = self.columns.len();
        for (name, list) in [("scale", &self.scale), ("offset", &self.offset)] {
            if list.len() > 1 && list.len() != count {
                return Err(fail(message!("map_each", name, have = list.len(), columns = count)));
            }
        }
        let (unit, unit_name, header) = self.unit(of, source).map_err(fail)?;
        let each = |list: &[f64], k: usize, default: f64| *list.get(k).or(list.first()).unwrap_or(&default);
        let reading = |(k, name): (usize, &ColumnName)| {
            let (column, sign) = name.find(source).map_err(fail)?;
            let scale = sign * each(&self.scale, k, 1.0) * unit.factor;
            // Of a temperature the unit's zero is no part of its scale.
            Ok(Reading { log, column, factor: scale, offset: unit.offset - scale * each(&self.offset, k, 0.0) })
        };
        let readings: Vec<Reading> = self.columns.iter().enumerate().map(reading).collect::<Result<_, _>>()?;
        let again = |(k, own): (usize, &Reading)| readings[..k].iter().any(|other| other.column == own.column);
        if let Some((k, _)) = readings.iter().enumerate().find(|own| again(*own)) {
            let name = self.columns[k].to_string();
            return Err(fail(message!("map_column_again", name = sent(&name))));
        }
        Ok(Found { readings, unit, unit_name, header })
    }

    /// The unit that the numbers are in, its name, and what the header says of it.
    pub fn unit(&self, of: Quantity, source: &Source) -> Result<(Unit, String, Header), Message> {
        let (first, _) = match self.columns.first() {
            Some(name) => name.find(source)?,
            None => return Err(message!("map_no_columns")),
        };
        // What is scaled is not in the unit of its header any more.
        let heading = source.columns()[first].unit.as_deref().filter(|_| self.scale.is_empty());
        let of_header = heading.map(|name| (name, of.unit(name)));
        let units = || list(of.units().iter().copied());
        let Some(stated) = &self.unit else {
            return match of_header {
                Some((name, Some(unit))) => Ok((unit, name.to_owned(), Header::Says)),
                Some((name, None)) => Err(message!("map_unit_of_header_alone", header = sent(name), known = units())),
                None => Err(message!("map_unit_missing", known = units())),
            };
        };
        let unit = of.unit(stated).ok_or_else(|| message!("map_unit_unknown", unit = sent(stated), known = units()))?;
        match of_header {
            Some((name, Some(other))) if other.factor != unit.factor => {
                Err(message!("map_unit_of_header", unit = sent(stated), header = sent(name)))
            }
            Some((name, None)) => Ok((unit, stated.clone(), Header::Unknown(name.to_owned()))),
            _ => Ok((unit, stated.clone(), Header::Silent)),
        }
    }
}

/// The log that columns are in.
pub fn log_of<'a>(
    key: &'static str,
    log: Option<usize>,
    sources: &'a [(String, Source)],
) -> Result<(usize, (&'a str, &'a Source)), LogError> {
    let log = log.unwrap_or(1);
    match log.checked_sub(1).and_then(|k| sources.get(k)) {
        Some((place, source)) => Ok((log - 1, (place.as_str(), source))),
        None => {
            let fault = message!("map_log", log, logs = sources.len());
            Err(LogError::new("map", message!("at_map_key", key, fault)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: &str = "
        output = { columns = [\"gx\", \"-gy\", 4], unit = \"deg/s\", scale = 0.01, offset = [1, 2, 3] }
        time = { column = \"t\", unit = \"ms\" }
    ";

    #[test]
    fn columns_have_names_numbers_signs_scales_and_offsets() {
        let map = Map::parse(SHORT).unwrap();
        let names = [ColumnName::Name("gx".into()), ColumnName::Name("-gy".into()), ColumnName::Number(4)];
        assert_eq!(map.output.columns, names);
        assert_eq!(
            (map.output.scale.as_slice(), map.output.offset.as_slice()),
            ([0.01].as_slice(), [1.0, 2.0, 3.0].as_slice())
        );
        assert_eq!(map.time.unwrap().columns.len(), 1);
        let unknown = Map::parse("outputs = 1").unwrap_err();
        assert_eq!(unknown.code, "at_line");
    }
}
