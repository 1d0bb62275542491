//! A first map for a log that nobody has described yet, with the reason for every line. It is to be checked by somebody
//! who knows the station: what the file does not say stays a question mark, which `dwells` refuses.

use std::fmt::Write;
use std::path::PathBuf;

use super::column::Column;
use super::error::LogError;
use super::source::Source;
use super::units::Quantity;
use crate::core::message::Message;
use crate::core::units::STANDARD_GRAVITY_M_S2;
use crate::message;

/// Rows that are looked at.
const ROWS: usize = 5000;
/// Room about a unit's gravity.
const ROOM: f64 = 0.12;
/// Rows for each change of a command, at least.
const SELDOM: usize = 20;
const UNKNOWN: &str = "?";
const HALF_A_DAY_S: f64 = 43_200.0;
/// Rows up to which a log may be a table of averages.
const FEW_ROWS: usize = 500;

struct Looked {
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
    /// Columns of times of day or dates, which are read as seconds.
    clocks: Vec<usize>,
}

/// One line of the map: what it says, and why.
#[derive(Clone)]
struct Line {
    text: String,
    reason: String,
}

/// The map of logs as far as names, units and numbers show it.
///
/// # Errors
/// As [`Source::open`].
pub fn guess(paths: &[PathBuf]) -> Result<String, LogError> {
    let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let open = |path: &PathBuf| Ok((name(path), Source::open(path)?));
    guess_of(paths.iter().map(open).collect::<Result<_, LogError>>()?)
}

/// As [`guess`], of logs that are open, each with its name.
///
/// # Errors
/// A log without rows.
pub fn guess_of(sources: Vec<(String, Source)>) -> Result<String, LogError> {
    let names: Vec<String> = sources.iter().map(|(name, _)| name.clone()).collect();
    let mut looked = Vec::new();
    for (name, source) in sources {
        looked.push(look(&name, source)?);
    }
    // Logs of the same columns follow one another; others run beside one another.
    if looked.iter().all(|own| own.columns == looked[0].columns) {
        looked.truncate(1);
    }
    Ok(map(&looked, &names.join(", ")))
}

fn look(name: &str, mut source: Source) -> Result<Looked, LogError> {
    source.leniently();
    let columns = source.columns().to_vec();
    let wanted: Vec<usize> = (0..columns.len()).collect();
    let mut values = vec![Vec::new(); columns.len()];
    const ENOUGH: &str = "enough";
    let read = source.rows(name, &wanted, &mut |sample| {
        for (list, value) in values.iter_mut().zip(sample.values) {
            list.push(*value);
        }
        if values[0].len() < ROWS { Ok(()) } else { Err(Message::verbatim(ENOUGH)) }
    });
    let stopped = values[0].len() >= ROWS;
    match read {
        Err(error) if !stopped && values[0].is_empty() => Err(error),
        _ => Ok(Looked { columns, values, clocks: source.clocks().to_vec() }),
    }
}

/// What one log has of a map.
struct Parts {
    time: Option<Line>,
    /// With their number.
    output: Option<(usize, Line)>,
    force: Option<Line>,
    rate: Option<Line>,
    temperature: Option<Line>,
}

fn map(logs: &[Looked], name: &str) -> String {
    let mut text = format!("# Guessed from {name}: check every line, and fill in what is \"{UNKNOWN}\".\n");
    text.push_str("imu = \"?\"\nstation = \"?\"\nmeasured_at = \"?\"  # such as 2026-03-01T08:00:00Z\n");
    text.push_str("geometry = \"orthogonal\"  # or \"skewed\", or axes by slot\n");
    text.push_str("site = { latitude_deg = \"?\", gravity_g0 = \"?\" }  # of the station\n");
    let parts: Vec<Parts> = logs.iter().map(Looked::parts).collect();
    let gyros = parts.iter().find_map(|part| part.output.as_ref()).map_or(3, |(gyros, _)| *gyros);
    let serials: Vec<String> = (1..=gyros).map(|k| format!("\"G{k} SERIAL-{k}\"")).collect();
    writeln!(text, "gyros = [{}]", serials.join(", ")).expect("a string takes everything");
    if logs.iter().any(|log| log.values[0].len() <= FEW_ROWS) {
        text.push_str("# few rows: if each is an average already, say averaged = true, and duration or samples\n");
    }
    let first = |of: fn(&Parts) -> Option<Line>| {
        let found = parts.iter().enumerate().find_map(|(k, part)| Some((k, of(part)?)));
        found.map(|(k, line)| if logs.len() > 1 { line.in_log(k + 1) } else { line })
    };
    let unknown = |text: &str, reason: &str| Some(Line { text: text.to_owned(), reason: reason.to_owned() });
    let lines = [
        parts[0]
            .time
            .clone()
            .or_else(|| unknown("rate_hz = \"?\"", "no column rises steadily: say how many samples a second")),
        first(|part| Some(part.output.clone()?.1))
            .or_else(|| unknown("output = { columns = [], unit = \"?\" }", "no column looks like a gyro's")),
        first(|part| part.force.clone()),
        first(|part| part.rate.clone()),
        first(|part| part.temperature.clone()),
    ];
    for line in lines.into_iter().flatten() {
        writeln!(text, "# {}\n{}", line.reason, line.text).expect("a string takes everything");
    }
    text
}

impl Line {
    /// The line of a log that runs beside others.
    fn in_log(self, log: usize) -> Self {
        let text = self.text.strip_suffix(" }").map_or(self.text.clone(), |text| format!("{text}, log = {log} }}"));
        Self { text, ..self }
    }
}

impl Looked {
    fn parts(&self) -> Parts {
        let time = self.time();
        let force = self.triple(&["acc", "accel", "force", "beschl", "加速度", "加表", "加计"], &["a", "f"]);
        let (force, output) = self.by_numbers(time.as_ref().map(|t| t.0), force, self.output_triple());
        let taken: Vec<usize> = [output.clone(), force.clone()].into_iter().flatten().flatten().collect();
        Parts {
            time: time.map(|time| time.1),
            output: output.map(|places| (places.len(), self.output(&places))),
            force: force.map(|places| self.force(&places)),
            rate: self.rate(&taken),
            temperature: self.temperature(),
        }
    }

    /// How a column is named in the map: by its name where it has one of its own.
    fn named(&self, place: usize) -> String {
        let name = &self.columns[place].name;
        let alone = self.columns.iter().filter(|c| c.name == *name).count() == 1;
        if name.is_empty() || !alone { (place + 1).to_string() } else { format!("{name:?}") }
    }

    fn list(&self, places: &[usize]) -> String {
        places.iter().map(|&p| self.named(p)).collect::<Vec<_>>().join(", ")
    }

    fn rises(&self, place: usize) -> bool {
        let values = &self.values[place];
        // A time of day begins anew at midnight.
        let is_clock = self.clocks.contains(&place);
        let goes_on = |p: &[f64]| p[1] >= p[0] || is_clock && p[0] - p[1] > HALF_A_DAY_S;
        values.len() > 2 && values.windows(2).all(goes_on) && values[values.len() - 1] != values[0]
    }

    fn step(&self, place: usize) -> f64 {
        let mut steps: Vec<f64> = self.values[place].windows(2).map(|p| p[1] - p[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(0.0)
    }

    fn time(&self) -> Option<(usize, Line)> {
        let lower = |k: &usize| self.columns[*k].name.to_lowercase();
        let rising: Vec<usize> = (0..self.columns.len()).filter(|&k| self.rises(k) && self.step(k) > 0.0).collect();
        let says =
            |k: &&usize| ["time", "zeit", "stamp", "时间"].iter().any(|w| lower(k).contains(w)) || lower(k) == "t";
        let named = rising.iter().find(says);
        let place = *named.or(rising.first().filter(|_| rising.len() == 1 || self.columns[0].name.is_empty()))?;
        let step = self.step(place);
        if self.clocks.contains(&place) {
            let reason = format!("times of day or dates: read as seconds, {step:.4} from row to row");
            return Some((
                place,
                Line { text: format!("time = {{ column = {}, unit = \"s\" }}", self.named(place)), reason },
            ));
        }
        let (first, stated) = (self.values[place][0], self.columns[place].unit.clone());
        let absolute = [("unix_s", 1.0), ("unix_ms", 1e3), ("unix_us", 1e6), ("unix_ns", 1e9)];
        let since_1970 = absolute.iter().find(|(_, factor)| (8e8..4e9).contains(&(first / factor)));
        let unit = match (stated.filter(|u| Quantity::Time.unit(u).is_some()), since_1970) {
            (Some(unit), None) => unit,
            (_, Some((unit, _))) => (*unit).to_owned(),
            (None, None) if step < 0.5 => "s".to_owned(),
            (None, None) if step < 500.0 => "ms".to_owned(),
            (None, None) if step < 5e5 => "us".to_owned(),
            (None, None) => "ns".to_owned(),
        };
        let reason =
            format!("rises by {step} from row to row; {unit} gives {:.1} samples a second", self.hz(step, &unit));
        Some((place, Line { text: format!("time = {{ column = {}, unit = \"{unit}\" }}", self.named(place)), reason }))
    }

    fn hz(&self, step: f64, unit: &str) -> f64 {
        Quantity::Time.unit(unit).map_or(0.0, |u| (step * u.factor).recip())
    }

    /// The gyros: columns named for what they count before those named for a rate, which the table may have.
    fn output_triple(&self) -> Option<Vec<usize>> {
        let plain = self
            .triple(&["gyr", "pulse", "puls", "imp", "count", "kreisel", "output", "ausgang", "陀螺", "脉冲"], &["g"]);
        let rates = || self.triple(&["omega", "rate", "dreh", "角速度"], &["w"]);
        plain.or_else(|| rates().filter(|places| !places.iter().any(|&p| self.is_command(p))))
    }

    /// A value that stands for long and has no noise: what was told, not what was measured.
    fn is_command(&self, place: usize) -> bool {
        let values = &self.values[place];
        let changes = values.windows(2).filter(|pair| pair[0] != pair[1]).count();
        values.len() > 1 && SELDOM * changes <= values.len()
    }

    /// The rate of the table: what is named as a rate and is not the gyros'.
    fn rate(&self, taken: &[usize]) -> Option<Line> {
        const STEMS: [&str; 6] = ["rate", "omega", "dreh", "turn", "转速", "角速度"];
        let is_rate = |c: &Column| c.unit.as_deref().is_some_and(|u| Quantity::Rate.unit(u).is_some());
        let named = |c: &Column| STEMS.iter().any(|stem| c.name.to_lowercase().contains(stem)) || is_rate(c);
        let three = self.triple(&STEMS, &["w"]).filter(|places| !places.iter().any(|p| taken.contains(p)));
        let one = || {
            let mut free = (0..self.columns.len()).filter(|k| !taken.contains(k) && named(&self.columns[*k]));
            free.find(|&k| self.is_command(k)).map(|k| vec![k])
        };
        let places = three.or_else(one)?;
        let stated = self.columns[places[0]].unit.clone().filter(|u| Quantity::Rate.unit(u).is_some());
        let unit = stated.unwrap_or_else(|| UNKNOWN.to_owned());
        let text = format!("rate = {{ columns = [{}], unit = \"{unit}\" }}", self.list(&places));
        Some(Line { text, reason: "named as a rate, and not that of the gyros: taken for the table's".to_owned() })
    }

    /// Three columns whose names share a stem and end in x, y, z or 1, 2, 3.
    fn triple(&self, stems: &[&str], letters: &[&str]) -> Option<Vec<usize>> {
        let names: Vec<String> = self.columns.iter().map(|c| c.name.to_lowercase()).collect();
        for ends in [["x", "y", "z"], ["1", "2", "3"]] {
            for (k, name) in names.iter().enumerate() {
                let Some(stem) = name.strip_suffix(ends[0]) else { continue };
                let plain = stem.trim_end_matches(['_', ' ', '.', '-']);
                let fits = stems.iter().any(|s| plain.contains(s)) || letters.contains(&plain);
                let other = |end: &str| names.iter().position(|n| *n == format!("{stem}{end}"));
                if let (true, Some(y), Some(z)) = (fits, other(ends[1]), other(ends[2])) {
                    return Some(vec![k, y, z]);
                }
            }
        }
        None
    }

    /// Without names: three columns of constant length are the force, three others the gyros.
    fn by_numbers(
        &self,
        time: Option<usize>,
        force: Option<Vec<usize>>,
        output: Option<Vec<usize>>,
    ) -> (Option<Vec<usize>>, Option<Vec<usize>>) {
        if force.is_some() || output.is_some() {
            return (force, output);
        }
        let free = |places: &[usize]| places.iter().all(|&p| p < self.columns.len() && Some(p) != time);
        let numeric = |places: &[usize]| {
            places
                .iter()
                .all(|&p| self.values[p].iter().all(|v| v.is_finite()) && self.values[p].iter().any(|v| *v != 0.0))
        };
        let threes: Vec<Vec<usize>> = (0..self.columns.len())
            .map(|k| vec![k, k + 1, k + 2])
            .filter(|places| free(places) && numeric(places))
            .collect();
        let force = threes.iter().find(|places| self.gravity(places).is_some()).cloned();
        let apart = |places: &&Vec<usize>| force.as_ref().is_none_or(|f| places.iter().all(|p| !f.contains(p)));
        let output = threes.iter().find(apart).cloned();
        (force, output)
    }

    /// The unit in which most rows of three columns are as long as gravity.
    fn gravity(&self, places: &[usize]) -> Option<(&'static str, f64)> {
        let count = self.values[places[0]].len();
        let square = |k: usize| places.iter().map(|&p| self.values[p][k].powi(2)).sum::<f64>();
        let mut lengths: Vec<f64> = (0..count).map(|k| square(k).sqrt()).collect();
        lengths.sort_by(f64::total_cmp);
        let usual = *lengths.get(count / 2)?;
        let units =
            [("m/s^2", STANDARD_GRAVITY_M_S2), ("g0", 1.0), ("mg", 1e3), ("cm/s^2", 100.0 * STANDARD_GRAVITY_M_S2)];
        let fits = units.into_iter().find(|(_, g)| (usual / g - 1.0).abs() < ROOM)?;
        Some((fits.0, usual))
    }

    fn output(&self, places: &[usize]) -> Line {
        let stated = self.columns[places[0]].unit.clone().filter(|u| Quantity::Output.unit(u).is_some());
        let (unit, reason) = match stated {
            Some(unit) => (unit.clone(), format!("the header says {unit}")),
            None => {
                (UNKNOWN.to_owned(), "nothing says the unit of the gyros: pulse/s, pulse, deg/s, rad/s ...".to_owned())
            }
        };
        Line { text: format!("output = {{ columns = [{}], unit = \"{unit}\" }}", self.list(places)), reason }
    }

    fn force(&self, places: &[usize]) -> Line {
        let stated = self.columns[places[0]].unit.clone().filter(|u| Quantity::Force.unit(u).is_some());
        let (unit, reason) = match (stated, self.gravity(places)) {
            (Some(unit), _) => (unit.clone(), format!("the header says {unit}")),
            (None, Some((unit, length))) => {
                (unit.to_owned(), format!("its length is {length:.4} in most rows, which is gravity in {unit}"))
            }
            (None, None) => {
                let why = "its length is gravity in no unit: say with scale and offset what a count is";
                (UNKNOWN.to_owned(), why.to_owned())
            }
        };
        Line { text: format!("force = {{ columns = [{}], unit = \"{unit}\" }}", self.list(places)), reason }
    }

    fn temperature(&self) -> Option<Line> {
        let is = |c: &Column| {
            let name = c.name.to_lowercase();
            name.contains("temp")
                || name.contains("温度")
                || name == "t_c"
                || c.unit.as_deref().is_some_and(|u| Quantity::Temperature.unit(u).is_some())
        };
        let place = self.columns.iter().position(is)?;
        let unit = self.columns[place].unit.clone().filter(|u| Quantity::Temperature.unit(u).is_some());
        let (unit, reason) = match unit {
            Some(unit) => (unit.clone(), format!("the header says {unit}")),
            None => ("C".to_owned(), "named as a temperature; taken for degrees Celsius".to_owned()),
        };
        Some(Line { text: format!("temperature = {{ column = {}, unit = \"{unit}\" }}", self.named(place)), reason })
    }
}

/// Whether a map still has question marks in it.
///
/// # Errors
/// The line of the first.
pub fn answered(text: &str) -> Result<(), Message> {
    let open = |line: &str| line.split('#').next().is_some_and(|said| said.contains("\"?\""));
    match text.lines().position(open) {
        Some(line) => Err(message!("at_line", line = line + 1, fault = message!("map_unanswered"))),
        None => Ok(()),
    }
}
