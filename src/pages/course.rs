//! A gyro's course: its plot by one of the methods, and what happened to it.

use std::sync::Arc;

use maud::{Markup, html};

use super::layout::instant;
use super::plot::{Band, Mark, Plot, Point, Series, Strip, millis};
use super::text::Text;
use super::viewer::Viewer;
use crate::config::JudgedMethod;
use crate::core::bench::BenchMethod;
use crate::core::judge::history::Measured;
use crate::core::time::UtcMicros;
use crate::pipeline::{Baseline, BenchRow, Course, Figures, Tables, sample_of};

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
            JudgedMethod::Rigid => self.method_rigid,
            JudgedMethod::Published => self.method_published,
        }
    }
}

/// `IMU-07 G1`.
pub(super) fn seat(figures: &Figures, tables: &Tables) -> String {
    format!("{} {}", name(tables.imus.name(figures.imu)), figures.slot.name())
}

pub(super) fn name(name: Option<&Arc<str>>) -> &str {
    name.map_or("", |name| &**name)
}

pub(super) fn plot(viewer: &Viewer, serial: &str, shown: Shown, course: &Course, tables: &Tables) -> Plot {
    let t = viewer.text();
    let bench_only = shown == Shown::Bench;
    let budgets = [course.limits.d_i.baseline, course.limits.d_s.baseline, course.limits.closure];
    let columns = if bench_only { 0..2 } else { 0..3 };
    let strips = columns.map(|column| {
        let band = |baseline: &Baseline| {
            let level = baseline.level[column]?;
            Some((millis(baseline.from), millis(baseline.until), level, budgets[column]))
        };
        let bands: Vec<_> = course.baselines.iter().filter_map(band).collect();
        let mut series = Vec::new();
        if !bench_only && !course.figures.is_empty() {
            let points = separated(&course.figures, shown.separation(), column, (&bands, tables));
            series.push(Series::new(shown.title(t), false, &points));
        }
        for method in BenchMethod::ALL.into_iter().filter(|_| column < 2) {
            let points = benched(&course.benches, method, column, tables);
            if !points.is_empty() {
                series.push(Series::new(t.method(method.name()), true, &points));
            }
        }
        Strip {
            symbol: ["D_I", "D_S", "D_O"][column],
            series,
            bands: course.baselines.iter().filter_map(band).collect(),
        }
    });
    let since = course.baselines.last().filter(|_| course.baselines.len() > 1).map(|baseline| millis(baseline.from));
    Plot {
        name: serial.to_owned(),
        unit: t.unit,
        strips: strips.collect(),
        marks: marks(t, course, tables),
        states: [t.within, t.indeterminate, t.flagged, t.exceeded],
        since,
    }
}

fn separated(rows: &[Figures], method: JudgedMethod, column: usize, (bands, tables): (&[Band], &Tables)) -> Vec<Point> {
    let outside = |at: UtcMicros, value: f64| {
        let of_time = |band: &&Band| (band.0..=band.1).contains(&millis(at));
        bands.iter().rfind(of_time).is_some_and(|band| band.3.is_some_and(|budget| (value - band.2).abs() > budget))
    };
    let point = |figures: &Figures| Point {
        at: figures.at,
        measured: sample_of(figures, method).d[column],
        state: figures.states.0[column],
        outside: outside(figures.at, sample_of(figures, method).d[column].value),
        place: format!("{} · {}", seat(figures, tables), name(tables.stations.name(figures.station))),
    };
    rows.iter().map(point).collect()
}

fn benched(rows: &[BenchRow], method: BenchMethod, column: usize, tables: &Tables) -> Vec<Point> {
    let point = |row: &BenchRow| Point {
        at: row.measured_at,
        measured: Measured { value: row.d[column], sd: row.sd[column] },
        state: None,
        outside: false,
        place: name(tables.stations.name(row.station)).to_owned(),
    };
    rows.iter().filter(|row| row.method == method).map(point).collect()
}

/// A change from one calibration to the next.
struct Change {
    at: UtcMicros,
    /// Another seat; if not, another station.
    seat: bool,
    from: String,
    to: String,
}

fn changes(course: &Course, tables: &Tables) -> Vec<Change> {
    let mut changes = Vec::new();
    for pair in course.figures.windows(2) {
        let (old, new) = (&pair[0], &pair[1]);
        if (old.imu, old.slot) != (new.imu, new.slot) {
            changes.push(Change { at: new.at, seat: true, from: seat(old, tables), to: seat(new, tables) });
        }
        if old.station != new.station {
            let of = |figures: &Figures| name(tables.stations.name(figures.station)).to_owned();
            changes.push(Change { at: new.at, seat: false, from: of(old), to: of(new) });
        }
    }
    changes
}

fn marks(t: &Text, course: &Course, tables: &Tables) -> Vec<Mark> {
    let events = course.events.iter();
    let mut marks: Vec<Mark> =
        events.map(|event| Mark { t: millis(event.at), label: t.event(event.event).to_owned(), event: true }).collect();
    let changes = changes(course, tables);
    if changes.len() <= MOST_CHANGES {
        marks.extend(changes.into_iter().map(|change| Mark { t: millis(change.at), label: change.to, event: false }));
    }
    marks
}

/// Events and changes in the order of time, newest first.
pub(super) fn happenings(viewer: &Viewer, course: &Course, tables: &Tables) -> Markup {
    let t = viewer.text();
    let changes = changes(course, tables);
    let mut all: Vec<(UtcMicros, Markup)> = course
        .events
        .iter()
        .map(|event| {
            let said = html! {
                td { strong { (t.event(event.event)) } }
                td { (event.reason) @if let Some(author) = &event.author { " " span.quiet { "(" (author) ")" } } }
            };
            (event.at, said)
        })
        .chain(changes.iter().map(|change| {
            let what = if change.seat { t.moved } else { t.other_station };
            (change.at, html! { td { (what) } td { (change.from) " → " (change.to) } })
        }))
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
