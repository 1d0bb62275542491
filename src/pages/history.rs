//! A gyro's course: its plot by one of the methods, and what happened to it.

use maud::{Markup, html};

use super::corrections;
use super::layout::{DRIFTS, instant};
use super::plot::{ALONE, Band, Mark, Plot, Point, Series, Strip, millis, shown};
use super::text::Text;
use super::viewer::Viewer;
use crate::config::JudgedMethod;
use crate::core::bench::BenchMethod;
use crate::core::figures::Figures;
use crate::core::judge::limits::DEFAULT_BUDGET;
use crate::core::judge::{Limits, Rule, Status};
use crate::core::judge::{Measured, Sample};
use crate::core::time::UtcMicros;
use crate::pipeline::{Baseline, BenchItem, Course, EventItem, Names, Statuses, sample_of};

/// Changes of seat or station that are drawn at the most: two stations in turn would hide the plot behind lines.
const MOST_CHANGES: usize = 30;

/// Whose figures are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shown {
    Separation(JudgedMethod),
    /// The bench alone; separations beside it are by the rigid method.
    Bench,
}

impl Shown {
    pub const ALL: [Shown; 3] =
        [Shown::Separation(JudgedMethod::Rigid), Shown::Separation(JudgedMethod::Published), Shown::Bench];

    pub fn asked(name: Option<&str>, judged: JudgedMethod) -> Self {
        Self::ALL.into_iter().find(|shown| Some(shown.name()) == name).unwrap_or(Self::Separation(judged))
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Separation(JudgedMethod::Rigid) => "rigid",
            Self::Separation(JudgedMethod::Published) => "published",
            Self::Bench => "bench",
        }
    }

    pub fn title(self, t: &Text) -> &'static str {
        match self {
            Self::Separation(method) => t.method_of(method),
            Self::Bench => t.method_bench,
        }
    }

    pub fn separation(self) -> JudgedMethod {
        match self {
            Self::Separation(method) => method,
            Self::Bench => JudgedMethod::Rigid,
        }
    }

    /// Of the separation, as the API calls it.
    pub fn separation_name(self) -> &'static str {
        Self::Separation(self.separation()).name()
    }
}

impl Text {
    pub fn method_of(&self, method: JudgedMethod) -> &'static str {
        match method {
            JudgedMethod::Rigid => self.method("rigid"),
            JudgedMethod::Published => self.method("published"),
        }
    }
}

/// `IMU-07 G1`.
pub(super) fn seat(figures: &Figures, names: &Names<'_>) -> String {
    format!("{} {}", names.imu(figures.imu), figures.slot.name())
}

pub(super) fn plot(
    viewer: &Viewer,
    serial: &str,
    shown: Shown,
    (course, bands, statuses): (&Course, &Bands, &Statuses),
    names: &Names<'_>,
) -> Plot {
    let t = viewer.text();
    let bench_only = shown == Shown::Bench;
    let columns = if bench_only { 0..2 } else { 0..3 };
    let strips = columns.map(|column| {
        let bands = &bands[column];
        let mut series = Vec::new();
        if !bench_only && !course.figures.is_empty() {
            let judged = (statuses, names);
            series.push(separated(shown.title(t), &course.figures, (shown.separation(), column), judged));
        }
        for method in BenchMethod::ALL.into_iter().filter(|_| column < 2) {
            let of_method: Vec<&BenchItem> = course.benches.iter().filter(|row| row.method == method).collect();
            if !of_method.is_empty() {
                series.push(benched(t.method(method.name()), &of_method, column));
            }
        }
        let around = budgets(&course.limits)[column].unwrap_or(DEFAULT_BUDGET);
        Strip { symbol: DRIFTS[column], series, bands: bands.clone(), around }
    });
    let own = course.baselines.iter().skip(1).rfind(|baseline| !baseline.moved);
    let since = own.map(|baseline| millis(baseline.from));
    Plot {
        name: serial.to_owned(),
        unit: t.unit,
        strips: strips.collect(),
        marks: marks(t, course, names),
        statuses: Status::ALL.map(|status| (status.name(), t.status(status))),
        since,
        alone: ALONE,
    }
}

/// How far D_I, D_S and D_O may lie from their baselines.
fn budgets(limits: &Limits) -> [Option<f64>; 3] {
    [limits.d_i.of(Rule::Baseline), limits.d_s.of(Rule::Baseline), limits.closure]
        .map(|limit| limit.map(|limit| limit.value))
}

/// The levels of D_I, D_S and D_O, with what they are held against.
pub(super) type Bands = [Vec<Band>; 3];

/// What is drawn of a course: the rows whose statuses are told.
pub(super) fn drawn(course: &Course, method: JudgedMethod) -> impl Iterator<Item = &Figures> {
    (0..3).flat_map(move |column| shown(&course.figures, |figures| sample_of(figures, method).d[column].value))
}

/// The stretches of one column: D_I and D_S go on where the gyro has moved, D_O does not.
fn stretches(baselines: &[Baseline], column: usize) -> Vec<Baseline> {
    let mut joined: Vec<Baseline> = Vec::new();
    for baseline in baselines {
        match joined.last_mut() {
            Some(before) if baseline.moved && column < 2 => before.until = baseline.until,
            _ => joined.push(*baseline),
        }
    }
    joined
}

pub(super) fn bands(course: &Course, method: JudgedMethod) -> Bands {
    let budgets = budgets(&course.limits);
    let samples: Vec<Sample> = course.figures.iter().map(|figures| sample_of(figures, method)).collect();
    [0, 1, 2].map(|column| {
        let baselines = stretches(&course.baselines, column);
        let last = baselines.len().saturating_sub(1);
        let band = |(k, baseline): (usize, &Baseline)| {
            let start = samples.partition_point(|sample| sample.at < baseline.from);
            let end = if k == last { samples.len() } else { samples.partition_point(|s| s.at < baseline.until) };
            let values: Vec<f64> =
                samples.get(start..end).unwrap_or_default().iter().map(|sample| sample.d[column].value).collect();
            let (from, until) = (millis(baseline.from), millis(baseline.until));
            Some((from, until, baseline.level[column]?, budgets[column], control(&values)))
        };
        baselines.iter().enumerate().filter_map(band).collect()
    })
}

/// Successive differences that are needed to know a gyro's own scatter.
const LEAST_RANGES: usize = 7;
/// The mean difference of two values over their standard deviation: 2/sqrt(pi).
const MEAN_RANGE: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// How far a gyro's own scatter reaches: three standard deviations, from the mean of successive differences (a
/// control chart of individual values and moving ranges, ISO 7870-2).
fn control(values: &[f64]) -> Option<f64> {
    let ranges = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let count = ranges.len();
    (count >= LEAST_RANGES).then(|| 3.0 * ranges.sum::<f64>() / (count as f64 * MEAN_RANGE))
}

fn separated(
    name_of_method: &str,
    rows: &[Figures],
    (method, column): (JudgedMethod, usize),
    (statuses, names): (&Statuses, &Names<'_>),
) -> Series {
    let measured = |figures: &Figures| sample_of(figures, method).d[column];
    let point = |figures: &Figures| Point {
        at: figures.at,
        measured: measured(figures),
        status: Some(statuses.get(figures, column)),
        place: format!("{} · {}", seat(figures, names), names.station(figures.station)),
    };
    Series::new(name_of_method, false, rows, |figures| measured(figures).value, point)
}

fn benched(name_of_method: &str, rows: &[&BenchItem], column: usize) -> Series {
    let point = |row: &&BenchItem| Point {
        at: row.measured_at,
        measured: Measured { value: row.d[column], sd: row.sd[column] },
        status: None,
        place: row.station.clone(),
    };
    Series::new(name_of_method, true, rows, |row| row.d[column], point)
}

/// A change from one calibration to the next.
struct Change {
    at: UtcMicros,
    /// Another seat; if not, another station.
    seat: bool,
    from: String,
    to: String,
}

fn changes(course: &Course, names: &Names<'_>) -> Vec<Change> {
    let mut changes = Vec::new();
    for pair in course.figures.windows(2) {
        let (old, new) = (&pair[0], &pair[1]);
        if (old.imu, old.slot) != (new.imu, new.slot) {
            changes.push(Change { at: new.at, seat: true, from: seat(old, names), to: seat(new, names) });
        }
        if old.station != new.station {
            let of = |figures: &Figures| names.station(figures.station).to_owned();
            changes.push(Change { at: new.at, seat: false, from: of(old), to: of(new) });
        }
    }
    changes
}

fn marks(t: &Text, course: &Course, names: &Names<'_>) -> Vec<Mark> {
    let events = course.events.iter();
    let mark = |event: &EventItem| Mark {
        t: millis(event.at),
        until: event.until.map(millis),
        label: label(t, event),
        event: true,
    };
    let mut marks: Vec<Mark> = events.map(mark).collect();
    let changes = changes(course, names);
    if changes.len() <= MOST_CHANGES {
        marks.extend(changes.into_iter().map(|change| Mark {
            t: millis(change.at),
            until: None,
            label: change.to,
            event: false,
        }));
    }
    marks
}

/// `environmental test: vibration`.
fn label(t: &Text, event: &EventItem) -> String {
    let name = t.event(event.event);
    event.test.as_ref().map_or_else(|| name.to_owned(), |test| format!("{name}{}{test}", t.colon))
}

/// The same on a page, of which the test's name is not translated.
pub(super) fn event_name(t: &Text, event: &EventItem) -> Markup {
    html! { (t.event(event.event)) @if let Some(test) = &event.test { (t.colon) span translate="no" { (test) } } }
}

/// Events and changes in the order of time, newest first.
pub(super) fn happenings(viewer: &Viewer, course: &Course, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    let changes = changes(course, names);
    let mut all: Vec<(UtcMicros, Markup)> = course
        .events
        .iter()
        .map(|event| {
            let said = html! {
                td {
                    strong { (event_name(t, event)) }
                    @if let Some(until) = event.until { br; span.quiet { (t.until) " " (instant(until)) } }
                }
                td translate="no" { (event.reason) @if let Some(author) = &event.author { " " span.quiet { "(" (author) ")" } } }
            };
            (event.at, said)
        })
        .chain(changes.iter().map(|change| {
            let what = if change.seat { t.moved } else { t.other_station };
            (change.at, html! { td { (what) } td { (change.from) " → " (change.to) } })
        }))
        .chain(course.corrections.iter().map(|one| (one.correction.at, corrections::happening(viewer, one))))
        .chain(course.set_aside.iter().map(|&(id, at)| (at, corrections::aside(viewer, id, at))))
        .collect();
    all.sort_by_key(|(at, _)| std::cmp::Reverse(*at));
    html! {
        section #happenings {
            h2 { (t.events) }
            @if all.is_empty() { p { (t.no_events) } }
            @else {
                div.scroll.tall.happenings tabindex="0" { table { tbody { @for (at, said) in all { tr { td { (instant(at)) } (said) } } } } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_limits_are_three_of_the_scatter_that_successive_values_show() {
        // +1, -1, +1 …: every difference is 2, and 3 x 2/1.128 = 5.317.
        let swinging: Vec<f64> = (0..20).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert!((control(&swinging).unwrap() - 5.317).abs() < 1e-3);
        // A drift of 0.1 from one to the next hardly widens them, however far it goes.
        let drifting: Vec<f64> = (0..20).map(|k| 0.1 * f64::from(k)).collect();
        assert!(control(&drifting).unwrap() < 0.27);
        assert_eq!(control(&swinging[..7]), None, "six differences are too few");
    }

    #[test]
    fn where_a_gyro_moves_only_the_level_of_d_o_begins_anew() {
        let stretch = |from: i64, until: i64, moved| Baseline {
            from: UtcMicros(from),
            until: UtcMicros(until),
            moved,
            level: [Some(1.0), Some(2.0), Some(from as f64)],
        };
        let all = [stretch(0, 10, false), stretch(10, 20, true), stretch(20, 30, false), stretch(30, 40, true)];
        let seen = |column| -> Vec<(i64, i64)> {
            stretches(&all, column).iter().map(|one| (one.from.0, one.until.0)).collect()
        };
        assert_eq!((seen(0), seen(1)), (vec![(0, 20), (20, 40)], vec![(0, 20), (20, 40)]));
        assert_eq!(seen(2), [(0, 10), (10, 20), (20, 30), (30, 40)]);
    }
}
