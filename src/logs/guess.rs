//! A first map for a log that nobody has described yet, with the reason for every line. It is to be checked by somebody
//! who knows the station: what the file does not say stays a question mark, which `dwells` refuses.

use std::path::{Path, PathBuf};

use super::column::Column;
use super::error::LogError;
use super::source::{Source, name};
use super::units::{Counts, Quantity};
use crate::core::message::{Message, figure, text};
use crate::core::numerics::median::upper_median_of;
use crate::core::units::STANDARD_GRAVITY_M_S2;
use crate::message;
use crate::words::Language;

/// Rows that are looked at.
const ROWS: usize = 5000;
/// Room about a unit's gravity.
const ROOM: f64 = 0.12;
/// Rows for each change of a command, at least.
const SELDOM: usize = 20;
const UNKNOWN: &str = "?";
const HALF_A_DAY_S: f64 = 43_200.0;
/// Counts after which a counter of 16, 24 or 32 bits begins anew.
const COUNTERS: [f64; 3] = [65_536.0, 16_777_216.0, 4_294_967_296.0];
/// Rows up to which a log may be a table of averages.
const FEW_ROWS: usize = 500;

struct ScannedFile {
    /// What the file's name says that it holds.
    holds: Option<FileContent>,
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
    /// Columns of times of day or dates, which are read as seconds.
    clocks: Vec<usize>,
    /// That it holds several IMUs.
    several: Option<Message>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum FileContent {
    Force,
    Output,
}

/// What a time column is taken for.
struct TimeUnit {
    unit: String,
    scale: Option<f64>,
    reason: Message,
}

/// One line of the map: what it says, and why.
#[derive(Clone)]
struct Line {
    text: String,
    reason: Message,
}

/// The map of logs as far as names, units and numbers show it.
pub fn guess(paths: &[PathBuf], language: Language) -> Result<String, LogError> {
    let last = |path: &PathBuf| name(Path::new(path.file_name().unwrap_or(path.as_os_str())));
    let open = |path: &PathBuf| Ok((last(path), Source::open(path)?));
    guess_of(paths.iter().map(open).collect::<Result<_, LogError>>()?, language)
}

/// As [`guess`], of logs that are open, each with its name.
pub fn guess_of(sources: Vec<(String, Source)>, language: Language) -> Result<String, LogError> {
    let names: Vec<String> = sources.iter().map(|(name, _)| name.clone()).collect();
    let mut looked = Vec::new();
    for (name, source) in sources {
        looked.push(look(&name, source)?);
    }
    // Logs of the same columns follow one another; others run beside one another.
    if looked.iter().all(|own| own.columns == looked[0].columns && own.holds == looked[0].holds) {
        looked.truncate(1);
    }
    Ok(map(&looked, &names.join(", "), language))
}

fn look(name: &str, mut source: Source) -> Result<ScannedFile, LogError> {
    source.leniently();
    let columns = source.columns().to_vec();
    let wanted: Vec<usize> = (0..columns.len()).collect();
    let mut values = vec![Vec::new(); columns.len()];
    const ENOUGH: &str = "enough";
    let read = source.rows(name, &wanted, &mut |row| {
        for (list, value) in values.iter_mut().zip(row) {
            list.push(*value);
        }
        if values[0].len() < ROWS { Ok(()) } else { Err(Message::verbatim(ENOUGH)) }
    });
    let stopped = values[0].len() >= ROWS;
    match read {
        Err(error) if !stopped && values[0].is_empty() => Err(error),
        _ => {
            let (clocks, several) = (source.clocks().to_vec(), source.several(&[]));
            Ok(ScannedFile { holds: FileContent::by_name(name), columns, values, clocks, several })
        }
    }
}

impl FileContent {
    fn by_name(file: &str) -> Option<Self> {
        let name = file.to_lowercase();
        let has = |words: [&str; 3]| words.iter().any(|word| name.contains(word));
        match (has(["acc", "加速度", "加表"]), has(["gyr", "陀螺", "kreisel"])) {
            (true, false) => Some(Self::Force),
            (false, true) => Some(Self::Output),
            _ => None,
        }
    }
}

/// What one log has of a map.
struct Parts {
    time: Line,
    /// With their number.
    output: Option<(usize, Line)>,
    force: Option<Line>,
    rate: Option<Line>,
    temperature: Option<Line>,
}

fn map(logs: &[ScannedFile], name: &str, language: Language) -> String {
    let say = |message: Message| language.words(&message);
    let mut text = format!("# {}\n", say(message!("guess_head", logs = name.to_owned())));
    let example = say(message!("guess_time_example"));
    text.push_str(&format!("imu = \"?\"\nstation = \"?\"\nmeasured_at = \"?\"  # {example}\n"));
    text.push_str(&format!("geometry = \"orthogonal\"  # {}\n", say(message!("guess_geometry"))));
    let of_station = say(message!("guess_site"));
    text.push_str(&format!("site = {{ latitude_deg = \"?\", gravity_g0 = \"?\" }}  # {of_station}\n"));
    let parts: Vec<Parts> = logs.iter().map(ScannedFile::parts).collect();
    let gyros = parts.iter().find_map(|part| part.output.as_ref()).map_or(3, |(gyros, _)| *gyros);
    let serials: Vec<String> = (1..=gyros).map(|k| format!("\"G{k} SERIAL-{k}\"")).collect();
    text.push_str(&format!("gyros = [{}]\n", serials.join(", ")));
    for said in logs.iter().filter_map(|log| log.several.as_ref()) {
        text.push_str(&format!("# {}\n", language.words(said)));
    }
    if logs.iter().any(|log| log.values[0].len() <= FEW_ROWS) {
        text.push_str(&format!("# {}\n", say(message!("guess_few_rows"))));
    }
    let first = |of: fn(&Parts) -> Option<Line>| {
        let found = parts.iter().enumerate().find_map(|(k, part)| Some((k, of(part)?)));
        found.map(|(k, line)| if logs.len() > 1 { line.in_log(k + 1) } else { line })
    };
    let no_output = || Line {
        text: format!("output = {{ columns = [], unit = \"{UNKNOWN}\" }}"),
        reason: message!("guess_no_output"),
    };
    let lines = [
        Some(parts[0].time.clone()),
        first(|part| Some(part.output.clone()?.1)).or_else(|| Some(no_output())),
        first(|part| part.force.clone()),
        first(|part| part.rate.clone()),
        first(|part| part.temperature.clone()),
    ];
    for line in lines.into_iter().flatten() {
        text.push_str(&format!("# {}\n{}\n", say(line.reason), line.text));
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

impl ScannedFile {
    fn parts(&self) -> Parts {
        let time = self.time();
        let force = self.triple(&["acc", "accel", "force", "beschl", "加速度", "加表", "加计"], &["a", "f"]);
        let (force, output) = self.by_numbers(time.0, force, self.output_triple());
        let taken: Vec<usize> = [output.clone(), force.clone()].into_iter().flatten().flatten().collect();
        Parts {
            time: time.1,
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
        // A counter begins anew when it is full.
        let is_full = |fall: f64| COUNTERS.iter().any(|most| (0.99 * most..*most).contains(&fall));
        let goes_on = |p: &[f64]| p[1] >= p[0] || is_clock && p[0] - p[1] > HALF_A_DAY_S || is_full(p[0] - p[1]);
        values.len() > 2 && values.windows(2).all(goes_on) && values[values.len() - 1] != values[0]
    }

    fn step(&self, place: usize) -> f64 {
        upper_median_of(self.values[place].windows(2).map(|p| p[1] - p[0])).unwrap_or(0.0)
    }

    /// The time column, where one can be told, and its line; else the line that asks for the rate.
    fn time(&self) -> (Option<usize>, Line) {
        let is_time = |k: &usize| self.rises(*k) && self.step(*k) > 0.0 && !self.is_temperature(*k);
        let (counts, rising): (Vec<usize>, Vec<usize>) =
            (0..self.columns.len()).filter(is_time).partition(|&k| self.counts_rows(k));
        let alone = || rising.first().filter(|_| rising.len() == 1 || self.columns[0].name.is_empty());
        let told = rising.iter().find(|&&k| self.is_called_time(k)).or_else(alone).copied();
        let unsaid = |reason: Message| (None, Line { text: format!("rate_hz = \"{UNKNOWN}\""), reason });
        let Some(place) = told else {
            let named = (0..self.columns.len()).find(|&k| self.is_called_time(k));
            return unsaid(match (named, counts.first()) {
                (Some(k), _) if self.values[k].iter().all(|v| v.is_nan()) => {
                    message!("guess_time_unread", column = self.named(k))
                }
                (Some(k), _) => message!("guess_time_unsteady", column = self.named(k)),
                (None, Some(&k)) => message!("guess_time_counts", column = self.named(k)),
                (None, None) => message!("guess_no_time"),
            });
        };
        if self.columns[place].name == "T" && self.columns[place].unit.is_none() && !self.begins_at_zero(place) {
            return unsaid(message!("guess_time_or_temperature"));
        }
        let TimeUnit { unit, scale, reason } = self.time_unit(place);
        let scale = scale.map_or_else(String::new, |scale| format!(", scale = {scale}"));
        let text = format!("time = {{ column = {}, unit = \"{unit}\"{scale} }}", self.named(place));
        (Some(place), Line { text, reason })
    }

    fn time_unit(&self, place: usize) -> TimeUnit {
        let step = self.step(place);
        let hz = |unit: &str, scale: f64| Quantity::Time.unit(unit).map_or(0.0, |u| (step * scale * u.factor).recip());
        let taken = |unit: &str, scale: Option<f64>| {
            let (hz, step) = (figure(hz(unit, scale.unwrap_or(1.0)), 1), text(short(step)));
            let (name, count) = (unit.to_owned(), text(scale.unwrap_or(1.0)));
            let reason = match scale {
                None => message!("guess_time", step, unit = name, hz),
                Some(_) => message!("guess_time_ticks", step, count, unit = name, hz),
            };
            TimeUnit { unit: unit.to_owned(), scale, reason }
        };
        if self.clocks.contains(&place) {
            let reason = message!("guess_clock", step = figure(step, 4));
            return TimeUnit { unit: "s".to_owned(), scale: None, reason };
        }
        let (first, name) = (self.values[place][0], self.columns[place].name.to_lowercase());
        let absolute = [("unix_s", 1.0), ("unix_ms", 1e3), ("unix_us", 1e6), ("unix_ns", 1e9)];
        if let Some((unit, _)) = absolute.iter().find(|(_, factor)| (8e8..4e9).contains(&(first / factor))) {
            return taken(unit, None);
        }
        if let Some(unit) = self.stated(place, Quantity::Time) {
            return taken(unit, None);
        }
        // `time_ms`, `t_s`.
        let last = name.rsplit(['_', ' ', '.', '-']).next().filter(|last| last.len() < name.len());
        if let Some(unit) = ["s", "sec", "ms", "us", "ns"].into_iter().find(|unit| last == Some(unit)) {
            return taken(unit, None);
        }
        // A spreadsheet's days since 1900.
        if (30_000.0..80_000.0).contains(&first) && step < 0.1 {
            return taken("h", Some(24.0));
        }
        // Xsens: of some models in us, of others in ticks of 100 us.
        if name == "sampletimefine" {
            return taken("us", (hz("us", 1.0) > 4000.0).then_some(100.0));
        }
        match step {
            ..0.5 => taken("s", None),
            // Slow loggers keep seconds, fast ones milliseconds.
            ..5.0 => TimeUnit {
                unit: UNKNOWN.to_owned(),
                scale: None,
                reason: message!(
                    "guess_time_unit",
                    step = text(short(step)),
                    of_s = figure(hz("s", 1.0), 1),
                    of_ms = figure(hz("ms", 1.0), 1)
                ),
            },
            ..500.0 => taken("ms", None),
            ..5e5 => taken("us", None),
            _ => taken("ns", None),
        }
    }

    /// The unit that the heading states, where it is one of this quantity.
    fn stated(&self, place: usize, of: Quantity) -> Option<&str> {
        self.columns[place].unit.as_deref().filter(|unit| of.unit(unit).is_some())
    }

    fn is_called_time(&self, place: usize) -> bool {
        const WORDS: [&str; 9] = ["time", "zeit", "stamp", "epoch", "date", "datum", "时间", "时刻", "日期"];
        let letter = &self.columns[place].name;
        let name = letter.to_lowercase();
        let of_unit = self.stated(place, Quantity::Time).is_some();
        let is_letter = *letter == "t" || ["t_s", "t_ms", "t_us", "t_ns", "sec", "tow"].contains(&name.as_str());
        (WORDS.iter().any(|word| name.contains(word)) || is_letter || of_unit) && !self.is_temperature(place)
    }

    fn is_temperature(&self, place: usize) -> bool {
        let name = &self.columns[place].name;
        let of = |quantity: Quantity| self.stated(place, quantity).is_some();
        let lower = name.to_lowercase();
        let named = lower.contains("temp") || name.contains("温度") || lower == "t_c" || lower == "tmp";
        // `T` beside a time.
        let beside = || name == "T" && (0..self.columns.len()).any(|k| k != place && self.is_called_time(k));
        !of(Quantity::Time) && (named || of(Quantity::Temperature) || beside())
    }

    /// A number of the row or the packet.
    fn counts_rows(&self, place: usize) -> bool {
        let name = self.columns[place].name.to_lowercase();
        let named = ["packet", "counter", "index", "sequence", "序号"].iter().any(|word| name.contains(word));
        named
            || ["n", "no", "no.", "nr", "nr.", "#", "seq", "sample", "samples", "row", "line", "id"]
                .contains(&name.as_str())
    }

    fn begins_at_zero(&self, place: usize) -> bool {
        self.values[place][0].abs() < 10.0 * self.step(place)
    }

    /// The gyros: columns named for what they count before those named for a rate, which the table may have.
    fn output_triple(&self) -> Option<Vec<usize>> {
        let plain = self
            .triple(&["gyr", "pulse", "puls", "imp", "count", "kreisel", "output", "ausgang", "陀螺", "脉冲"], &["g"]);
        let rates = || self.triple(&["omega", "rate", "dreh", "角速度"], &["w"]);
        plain
            .or_else(|| self.in_pulses())
            .or_else(|| rates().filter(|places| !places.iter().any(|&p| self.is_command(p))))
    }

    /// Columns whose headings say pulses, whatever their names.
    fn in_pulses(&self) -> Option<Vec<usize>> {
        let unit = |k: &usize| Quantity::Output.unit(self.columns[*k].unit.as_deref()?);
        let is_pulse = |k: &usize| unit(k).is_some_and(|unit| unit.counts != Counts::Angular);
        Some((0..self.columns.len()).filter(is_pulse).collect::<Vec<_>>())
            .filter(|found| (1..=3).contains(&found.len()))
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
        let stem_in = |name: &str| STEMS.iter().any(|stem| name.contains(stem));
        let named =
            |k: usize| stem_in(&self.columns[k].name.to_lowercase()) || self.stated(k, Quantity::Rate).is_some();
        let three = self.triple(&STEMS, &["w"]).filter(|places| !places.iter().any(|p| taken.contains(p)));
        let one = || {
            let mut free = (0..self.columns.len()).filter(|k| !taken.contains(k) && named(*k));
            free.find(|&k| self.is_command(k)).map(|k| vec![k])
        };
        let places = three.or_else(one)?;
        let stated = self.stated(places[0], Quantity::Rate).map(str::to_owned);
        let unit = stated.unwrap_or_else(|| UNKNOWN.to_owned());
        let text = format!("rate = {{ columns = [{}], unit = \"{unit}\" }}", self.list(&places));
        Some(Line { text, reason: message!("guess_rate") })
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
        let is_other =
            |p: usize| Some(p) == time || self.is_temperature(p) || self.counts_rows(p) || self.is_called_time(p);
        let free = |places: &[usize]| places.iter().all(|&p| p < self.columns.len() && !is_other(p));
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
        if self.holds == Some(FileContent::Force) {
            return (force.or(threes.first().cloned()), None);
        }
        let apart = |places: &&Vec<usize>| force.as_ref().is_none_or(|f| places.iter().all(|p| !f.contains(p)));
        let output = threes.iter().find(apart).cloned();
        (force, output)
    }

    /// The unit in which most rows of three columns are as long as gravity.
    fn gravity(&self, places: &[usize]) -> Option<(&'static str, f64)> {
        let square = |k: usize| places.iter().map(|&p| self.values[p][k].powi(2)).sum::<f64>();
        let usual = upper_median_of((0..self.values[places[0]].len()).map(|k| square(k).sqrt()))?;
        let units =
            [("m/s^2", STANDARD_GRAVITY_M_S2), ("g0", 1.0), ("mg", 1e3), ("cm/s^2", 100.0 * STANDARD_GRAVITY_M_S2)];
        let fits = units.into_iter().find(|(_, g)| (usual / g - 1.0).abs() < ROOM)?;
        Some((fits.0, usual))
    }

    fn output(&self, places: &[usize]) -> Line {
        let columns = format!("columns = [{}]", self.list(places));
        let unsaid = || (UNKNOWN, message!("guess_output_unit"));
        self.in_unit("output", &columns, (places[0], Quantity::Output), unsaid)
    }

    fn force(&self, places: &[usize]) -> Line {
        let columns = format!("columns = [{}]", self.list(places));
        let unsaid = || match self.gravity(places) {
            Some((unit, length)) => (unit, message!("guess_gravity", length = figure(length, 4), unit)),
            None => (UNKNOWN, message!("guess_no_gravity")),
        };
        self.in_unit("force", &columns, (places[0], Quantity::Force), unsaid)
    }

    fn temperature(&self) -> Option<Line> {
        let place = (0..self.columns.len()).find(|&k| self.is_temperature(k))?;
        let column = format!("column = {}", self.named(place));
        let unsaid = || ("C", message!("guess_celsius"));
        Some(self.in_unit("temperature", &column, (place, Quantity::Temperature), unsaid))
    }

    /// The line of some columns, in the unit that the heading of the one at a place states, or as else.
    fn in_unit(
        &self,
        key: &str,
        columns: &str,
        (place, of): (usize, Quantity),
        or: impl FnOnce() -> (&'static str, Message),
    ) -> Line {
        let (unit, reason) = match self.stated(place, of) {
            Some(unit) => (unit, message!("guess_header", unit = unit.to_owned())),
            None => or(),
        };
        Line { text: format!("{key} = {{ {columns}, unit = \"{unit}\" }}"), reason }
    }
}

/// A number without the noise of its last digits.
fn short(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Whether a map still has question marks in it.
pub fn answered(text: &str) -> Result<(), Message> {
    let open = |line: &str| line.split('#').next().is_some_and(|said| said.contains("\"?\""));
    match text.lines().position(open) {
        Some(line) => Err(message!("at_line", line = line + 1, fault = message!("map_unanswered"))),
        None => Ok(()),
    }
}
