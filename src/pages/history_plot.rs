//! A gyro's history as pictures of D_I, D_S and D_O.

use std::collections::HashMap;

use super::chart::{Chart, DataPoint, Extrapolation, Flag, Level, Segment, Track, XAxis, bounds, millis, widened};
use super::history::{event_label, seat};
use super::layout::clock;
use super::prelude::*;
use super::status::sign;
use super::verdicts::{SeenVerdict, seen};
use super::view::{ShownMethod, View};
use super::{bullet, downsample};
use crate::config::JudgedMethod;
use crate::core::bench::{BenchItem, BenchMethod};
use crate::core::figures::Figures;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::limits::DEFAULT_BUDGET;
use crate::core::judge::{Finding, Sample};
use crate::pipeline::{Baseline, GyroTimeline, Names, Statuses, sample_of};

/// Points of one coefficient that are drawn one by one at the most.
pub(super) const MOST_POINTS: usize = 1000;
/// Points whose verdicts are asked for where there are more, and stretches of their envelope.
const EXTREMES: usize = 400;
const STRETCHES: usize = 240;
/// Stretches of a lane at the most: two stations in turn would be stripes.
const MOST_STRETCHES: usize = 80;
/// Flags that are drawn at the most, the newest.
pub(super) const MOST_FLAGS: usize = 40;
/// How far a picture reaches beyond the newest record to show where a trend leads, as a part of what it shows.
const AHEAD: f64 = 0.35;
/// How far the axis of time reaches on either side of what stands alone, ms.
const ALONE: f64 = 15.0 * 864e5;
const YEAR: f64 = 365.25 * 864e5;
/// On either side of the records that made a baseline, ms.
const MARGIN: f64 = 3.0 * 864e5;

/// The records between two resets of one coefficient, and the level that they are compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Epoch {
    pub from: UtcMicros,
    pub until: UtcMicros,
    /// None while there are too few records.
    pub level: Option<f64>,
    /// What deviations count from: the level, or else the first record.
    pub zero: f64,
    pub control: Option<f64>,
    /// First and last of the records that made the level.
    pub made: Option<(UtcMicros, UtcMicros)>,
}

/// Of D_I, D_S and D_O.
pub(super) type Epochs = [Vec<Epoch>; 3];

/// What the pictures are made from.
#[derive(Clone, Copy)]
pub(super) struct PlotData<'a> {
    pub course: &'a GyroTimeline,
    pub epochs: &'a Epochs,
    pub statuses: &'a Statuses,
    /// On its newest record.
    pub verdicts: &'a [SeenVerdict],
}

/// The pictures, and what explains their signs.
pub(super) struct Plots {
    /// By column.
    pub charts: Vec<(usize, Chart)>,
    /// Calibrations in view, where they are too many to be drawn one by one.
    pub condensed: Option<usize>,
    legend: Markup,
    flags: Markup,
}

pub(super) fn epochs(course: &GyroTimeline, method: JudgedMethod) -> Epochs {
    let samples: Vec<Sample> = course.figures.iter().map(|figures| sample_of(figures, method)).collect();
    [0, 1, 2].map(|column| {
        let baselines = Baseline::stretches(&course.baselines, column);
        let last = baselines.len().saturating_sub(1);
        let epoch = |(k, baseline): (usize, &Baseline)| {
            let start = samples.partition_point(|sample| sample.at < baseline.from);
            let end = if k == last { samples.len() } else { samples.partition_point(|s| s.at < baseline.until) };
            let values: Vec<f64> =
                samples.get(start..end).unwrap_or_default().iter().map(|sample| sample.d[column].value).collect();
            let level = baseline.level[column];
            Epoch {
                from: baseline.from,
                until: baseline.until,
                level,
                zero: level.or(values.first().copied()).unwrap_or(0.0),
                control: control(&values).filter(|_| level.is_some()),
                made: baseline.made[column],
            }
        };
        baselines.iter().enumerate().map(epoch).collect()
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

fn in_view<'a>(course: &'a GyroTimeline, view: &View) -> Vec<&'a Figures> {
    course.figures.iter().filter(|figures| view.holds(figures.at)).collect()
}

/// The rows whose statuses the pictures need.
pub(super) fn drawn<'a>(course: &'a GyroTimeline, view: &View) -> Vec<&'a Figures> {
    let rows = in_view(course, view);
    if rows.len() <= MOST_POINTS {
        return rows;
    }
    let method = view.shown.separation();
    let of_column = |column: usize| {
        let values: Vec<f64> = rows.iter().map(|figures| sample_of(figures, method).d[column].value).collect();
        downsample::indices(&values, EXTREMES)
    };
    (0..3).flat_map(of_column).map(|k| rows[k]).collect()
}

/// The epoch of an instant; what comes before the first belongs to it.
pub(super) fn epoch_of(epochs: &[Epoch], at: UtcMicros) -> Option<&Epoch> {
    epochs.get(epochs.partition_point(|epoch| epoch.from <= at).saturating_sub(1))
}

/// What the pictures of one view have in common.
struct Drawing<'a> {
    t: &'a Text,
    serial: &'a str,
    view: View,
    seen: PlotData<'a>,
    names: &'a Names<'a>,
    rows: Vec<&'a Figures>,
    flags: Vec<Flag>,
    lanes: Vec<Vec<Segment>>,
    budgets: [Option<f64>; 3],
}

/// `place` keeps apart what stands on one page for several gyros.
pub(super) fn plots(t: &Text, serial: &str, view: View, seen: PlotData<'_>, names: &Names<'_>, place: &str) -> Plots {
    let rows = in_view(seen.course, &view);
    let drawing = Drawing {
        t,
        serial,
        view,
        seen,
        names,
        flags: flags(t, seen.course, &view, place),
        lanes: lanes(&rows, names),
        budgets: seen.course.limits.budgets(),
        rows,
    };
    let columns = if view.shown == ShownMethod::Bench { 0..2 } else { 0..3 };
    let charts: Vec<(usize, Chart)> = columns.map(|column| (column, drawing.chart(column))).collect();
    let condensed = (drawing.rows.len() > MOST_POINTS).then_some(drawing.rows.len());
    Plots { condensed, legend: legend(t, &charts, &drawing), flags: list(&drawing.flags), charts }
}

impl Drawing<'_> {
    fn around(&self, column: usize) -> f64 {
        self.budgets[column].unwrap_or(DEFAULT_BUDGET)
    }

    fn epochs(&self, column: usize) -> &[Epoch] {
        &self.seen.epochs[column]
    }

    fn chart(&self, column: usize) -> Chart {
        let (t, absolute) = (self.t, self.view.absolute);
        let mut tracks = Vec::new();
        if self.view.shown != ShownMethod::Bench && !self.rows.is_empty() {
            tracks.push(self.records(column));
        }
        if column < 2 {
            tracks.extend(
                BenchMethod::ALL.into_iter().enumerate().filter_map(|(k, method)| self.bench(column, k, method)),
            );
        }
        let ends = bounds(tracks.iter().flat_map(|track| {
            let points = track.dots.iter().map(|dot| dot.x);
            points.chain(track.envelope.iter().map(|[x, ..]| *x))
        }));
        // The strips of a gyro stand over the same stretch of time.
        let own = bounds(self.rows.iter().map(|figures| millis(figures.at)));
        let (first, last) = bounds([ends, own].into_iter().flatten().flat_map(|(a, b)| [a, b])).unwrap_or((0.0, 0.0));
        let (from, to) = (self.view.from.map_or(first, millis), self.view.to.map_or(last, millis));
        let trend = self.trend(column).filter(|_| self.view.to.is_none());
        let room = AHEAD * (to - from);
        let end = trend.as_ref().map_or(to, |trend| trend.end.clamp(to, to + room));
        let x = widened((from, end.max(from)), 0.02, ALONE);
        let caption = html! {
            span { (symbol(DRIFTS[column])) ", " (if absolute { t.value_absolute } else { t.deviation }) ", " (t.unit) }
            @if !absolute { span.quiet { (t.percent_of_budget) } }
        };
        let label = format!(
            "{} {}, {}. {}",
            self.serial,
            DRIFTS[column],
            if absolute { t.value_absolute } else { t.deviation },
            t.chart_keys
        );
        Chart {
            around: self.around(column),
            whole: (!absolute).then(|| self.around(column)),
            signed: !absolute,
            clips: !absolute,
            levels: self.levels(column, x),
            ahead: trend.map(|trend| trend.drawn(x.1)),
            lanes: self.lanes.clone(),
            flags: self.flags.iter().filter(|flag| (x.0..=x.1).contains(&flag.x)).cloned().collect(),
            tracks,
            ..Chart::new(label, caption, XAxis::Time, x)
        }
    }

    /// On the axis that is shown.
    fn y(&self, column: usize, at: UtcMicros, value: f64) -> f64 {
        let epoch = epoch_of(self.epochs(column), at).filter(|_| !self.view.absolute);
        value - epoch.map_or_else(|| self.zero(column), |epoch| epoch.zero)
    }

    /// Where no calibration gives a level, deviations count from the first bench result.
    fn zero(&self, column: usize) -> f64 {
        let first = self.seen.course.benches.first().filter(|_| !self.view.absolute && column < 2);
        first.map_or(0.0, |row| row.d[column])
    }

    fn levels(&self, column: usize, x: (f64, f64)) -> Vec<Level> {
        let (absolute, budget) = (self.view.absolute, self.budgets[column]);
        let all = self.epochs(column);
        let in_view = |(from, until): &(f64, f64)| *until > x.0 && *from < x.1;
        let level = |(k, epoch): (usize, &Epoch)| {
            let from = if k == 0 { x.0 } else { millis(epoch.from) };
            let until = if k + 1 == all.len() { x.1 } else { millis(epoch.until) };
            if until < x.0 || from > x.1 || (absolute && epoch.level.is_none()) {
                return None;
            }
            let label = match epoch.level {
                Some(level) => format!("{} {}", self.t.baseline_word, figure::fixed(level, 5)),
                None => format!("{} {}", self.t.no_baseline_yet, figure::fixed(epoch.zero, 5)),
            };
            Some(Level {
                from: from.max(x.0),
                until: until.min(x.1),
                at: if absolute { epoch.zero } else { 0.0 },
                budget,
                control: epoch.control,
                shade: None,
                made: epoch.made.map(|(from, until)| (millis(from) - MARGIN, millis(until) + MARGIN)).filter(in_view),
                label,
            })
        };
        let found: Vec<Level> = all.iter().enumerate().filter_map(level).collect();
        if found.is_empty() && !absolute {
            return vec![Level { from: x.0, until: x.1, budget, ..Level::default() }];
        }
        found
    }

    fn records(&self, column: usize) -> Track {
        let method = self.view.shown.separation();
        let measured = |figures: &Figures| sample_of(figures, method).d[column];
        let breaks = self.epochs(column).iter().skip(1).map(|epoch| millis(epoch.from)).collect();
        let dot = |figures: &Figures| self.dot(column, figures, measured(figures));
        if self.rows.len() <= MOST_POINTS {
            let dots = self.rows.iter().map(|figures| dot(figures)).collect();
            return Track { class: "record".into(), dots, breaks, joined: true, envelope: Vec::new() };
        }
        let values: Vec<f64> = self.rows.iter().map(|f| self.y(column, f.at, measured(f).value)).collect();
        let newest = self.rows.len() - 1;
        let kept = downsample::indices(&values, EXTREMES).into_iter();
        let speaks = |k: &usize| *k == newest || self.seen.statuses.get(self.rows[*k], column) >= Status::Drifting;
        let dots = kept.filter(speaks).map(|k| dot(self.rows[k])).collect();
        let times: Vec<f64> = self.rows.iter().map(|figures| millis(figures.at)).collect();
        Track { class: "record".into(), dots, breaks, joined: false, envelope: envelope(&times, &values) }
    }

    fn dot(&self, column: usize, figures: &Figures, measured: Measured) -> DataPoint {
        let t = self.t;
        let status = self.seen.statuses.get(figures, column);
        let rules = self.seen.statuses.rules(figures, column);
        let y = self.y(column, figures.at, measured.value);
        let why = rules.iter().map(|rule| t.rule(*rule)).collect::<Vec<_>>().join(", ");
        let status_said = match why.as_str() {
            "" => t.status(status).to_owned(),
            why => format!("{}{}{why}", t.status(status), t.colon),
        };
        let place = format!("{} · {}", seat(figures, self.names), self.names.station(figures.station));
        DataPoint {
            x: millis(figures.at),
            y,
            sd: measured.sd,
            status: Some(status),
            letters: rules.into_iter().map(Rule::letter).collect(),
            href: Some(format!("/records/{}", figures.record)),
            said: self.said(column, figures.at, (y, measured), &[&status_said, &place]),
        }
    }

    /// `2026-11-24 00:01 UTC · D_I +0.0251 ± 0.0007 deg/(h g0), +251 ± 7 % · confirmed: step · IMU-02 G1 · ST-2`.
    fn said(&self, column: usize, at: UtcMicros, (y, measured): (f64, Measured), more: &[&str]) -> String {
        let t = self.t;
        let utc = time::format(at);
        let figure = if self.view.absolute {
            format!("{} {} {}", DRIFTS[column], figure::drift(measured.value, measured.sd), t.unit)
        } else {
            let budget = self.around(column);
            let load = bullet::percent(Measured { value: y, sd: measured.sd }.in_units_of(budget));
            format!("{} {} {}, {load} %", DRIFTS[column], figure::signed_drift(y, measured.sd), t.unit)
        };
        format!("{} {} · {figure} · {}", at.date(), clock(&utc), more.join(" · "))
    }

    fn bench(&self, column: usize, k: usize, method: BenchMethod) -> Option<Track> {
        let rows =
            self.seen.course.benches.iter().filter(|row| row.method == method && self.view.holds(row.measured_at));
        let dot = |row: &BenchItem| {
            let measured = Measured { value: row.d[column], sd: row.sd[column] };
            let y = self.y(column, row.measured_at, measured.value);
            DataPoint {
                x: millis(row.measured_at),
                y,
                sd: measured.sd,
                said: self.said(
                    column,
                    row.measured_at,
                    (y, measured),
                    &[self.t.method(method.name()), self.names.station(row.station)],
                ),
                ..DataPoint::default()
            }
        };
        let dots: Vec<DataPoint> = rows.map(dot).collect();
        (!dots.is_empty()).then(|| Track { class: format!("bench{k}"), dots, ..Track::default() })
    }

    /// What the trend rule says of the newest record, on the axis that is shown.
    fn trend(&self, column: usize) -> Option<Trend> {
        if !self.view.is_judged() {
            return None;
        }
        let name = DRIFTS[column];
        let verdict = seen(self.seen.verdicts)
            .filter(|verdict| verdict.coefficient.name() == name)
            .find(|verdict| verdict.rule == Rule::Trend)?;
        let Finding::Trend { since, until, per_year, deviation, horizon_days, reach, .. } = verdict.finding else {
            return None;
        };
        let epoch = epoch_of(self.epochs(column), until).filter(|_| self.view.absolute);
        let base = epoch.map_or(0.0, |epoch| epoch.zero);
        let (slope, now) = (per_year.value / YEAR, millis(until));
        let along = |x: f64| (x, base + deviation + slope * (x - now));
        let edge = base + verdict.limit.copysign(slope);
        let [early, line, late] = reach.map(|at| at.map(millis).filter(|at| *at > now));
        let end = line.unwrap_or(now + horizon_days * 864e5);
        Some(Trend {
            line: [along(millis(since)), along(now), along(end)],
            cone: early
                .map(|early| [(early, edge), late.map_or((f64::INFINITY, base + deviation), |late| (late, edge))]),
            end: late.unwrap_or(end).max(end),
        })
    }
}

/// A course carried on beyond the newest record, before it is cut to a picture.
struct Trend {
    line: [(f64, f64); 3],
    cone: Option<[(f64, f64); 2]>,
    /// How far it would like to be seen.
    end: f64,
}

impl Trend {
    fn drawn(&self, edge: f64) -> Extrapolation {
        let [first, now, end] = self.line;
        Extrapolation {
            line: [first, now, cut(now, end, edge)],
            cone: self.cone.map(|ends| ends.map(|end| cut(now, end, edge))),
        }
    }
}

/// The end of a line from one point to another, no further than an edge.
fn cut((x0, y0): (f64, f64), (x1, y1): (f64, f64), edge: f64) -> (f64, f64) {
    if x1 <= edge {
        (x1, y1)
    } else if x1.is_infinite() {
        (edge, y1)
    } else {
        (edge, y0 + (y1 - y0) * (edge - x0) / (x1 - x0))
    }
}

/// Of equal stretches of time that hold a point the middle, the lowest, the median, the highest.
fn envelope(times: &[f64], values: &[f64]) -> Vec<[f64; 4]> {
    let Some((first, last)) = bounds(times.iter().copied()) else { return Vec::new() };
    let width = ((last - first) / STRETCHES as f64).max(1.0);
    let mut found: Vec<(usize, Vec<f64>)> = Vec::new();
    for (t, v) in times.iter().zip(values) {
        let place = (((t - first) / width) as usize).min(STRETCHES - 1);
        match found.last_mut() {
            Some((last, of)) if *last == place => of.push(*v),
            _ => found.push((place, vec![*v])),
        }
    }
    found
        .into_iter()
        .map(|(place, mut of)| {
            of.sort_unstable_by(f64::total_cmp);
            let median = 0.5 * (of[(of.len() - 1) / 2] + of[of.len() / 2]);
            [first + width * (place as f64 + 0.5), of[0], median, of[of.len() - 1]]
        })
        .collect()
}

/// What happened, numbered as in the list under the pictures.
fn flags(t: &Text, course: &GyroTimeline, view: &View, place: &str) -> Vec<Flag> {
    let flag = |(k, event): (usize, &GyroEvent)| Flag {
        x: millis(event.at),
        until: event.until.map(millis),
        number: k + 1,
        anchor: format!("event{place}-{}", k + 1),
        label: format!("{} {}", event.at.date(), event_label(t, event)),
    };
    let mut all: Vec<Flag> =
        course.events.iter().enumerate().filter(|(_, event)| view.holds(event.at)).map(flag).collect();
    all.drain(..all.len().saturating_sub(MOST_FLAGS));
    all
}

pub(super) fn list(flags: &[Flag]) -> Markup {
    html! {
        @if !flags.is_empty() {
            ol.flags {
                @for flag in flags { li id=(flag.anchor) value=(flag.number) { span translate="no" { (flag.label) } } }
            }
        }
    }
}

/// Where the gyro was, and at which station: a lane each.
fn lanes(rows: &[&Figures], names: &Names<'_>) -> Vec<Vec<Segment>> {
    let seats = lane(rows, |figures| seat(figures, names));
    let stations = lane(rows, |figures| names.station(figures.station).to_owned());
    [seats, stations].into_iter().filter(|lane| lane.len() <= MOST_STRETCHES).collect()
}

fn lane(rows: &[&Figures], name: impl Fn(&Figures) -> String) -> Vec<Segment> {
    let mut kinds: HashMap<String, usize> = HashMap::new();
    let mut lane: Vec<Segment> = Vec::new();
    for figures in rows {
        let (at, label) = (millis(figures.at), name(figures));
        if let Some(last) = lane.last_mut() {
            last.until = at;
            if last.label == label {
                continue;
            }
        }
        let next = kinds.len();
        let kind = *kinds.entry(label.clone()).or_insert(next);
        lane.push(Segment { from: at, until: at, label, kind });
    }
    lane
}

/// Every sign that occurs, with its word.
fn legend(t: &Text, charts: &[(usize, Chart)], drawing: &Drawing<'_>) -> Markup {
    let tracks = || charts.iter().flat_map(|(_, chart)| &chart.tracks);
    let occurs = |status: &Status| tracks().flat_map(|track| &track.dots).any(|dot| dot.status == Some(*status));
    let speaks = |rule: &Rule| tracks().flat_map(|track| &track.dots).any(|dot| dot.letters.contains(rule.letter()));
    let benches = BenchMethod::ALL
        .into_iter()
        .enumerate()
        .filter(|(k, _)| tracks().any(|track| track.class == format!("bench{k}")));
    let any = |of: fn(&Chart) -> bool| charts.iter().any(|(_, chart)| of(chart));
    let mark = |class: &str, shape: Markup| {
        html! { svg.key aria-hidden="true" viewBox="-7 -7 14 14" { g class=(class) { (shape) } } }
    };
    let of_status = |status: Status| html! { path class=(status.name()) d=(sign(status)) {} };
    let has_budget = drawing.budgets.iter().any(Option::is_some);
    let has_control = any(|chart| chart.levels.iter().any(|level| level.control.is_some()));
    let has_made = any(|chart| chart.levels.iter().any(|level| level.made.is_some()));
    let lines = [
        (has_budget, html! { line.budget x1="-7" x2="7" {} }, t.budget_line),
        (has_control, html! { line.control x1="-7" x2="7" {} }, t.control_line),
        (has_made, html! { rect.made x="-7" y="-5" width="14" height="10" {} }, t.baseline_records),
        (any(|chart| chart.ahead.is_some()), html! { polyline.ahead points="-7,4 7,-4" {} }, t.trend_line),
    ];
    html! {
        ul.legend {
            @for status in Status::ALL.into_iter().filter(occurs) {
                li { (mark("record", of_status(status))) (t.status(status)) }
            }
            @for (k, method) in benches {
                li { (mark(&format!("bench{k}"), html! { circle.plain r="3" {} })) (t.method(method.name())) }
            }
            @for rule in Rule::ALL.into_iter().filter(speaks) { li { b { (rule.letter()) } " " (t.rule(rule)) } }
            @for (occurs, shape, word) in lines { @if occurs { li { (mark("", shape)) (word) } } }
            @for stretch in charts.first().map(|(_, chart)| chart.unnamed()).unwrap_or_default() {
                li {
                    (mark("", html! { rect class={ "lane" (stretch.kind % 6) } x="-7" y="-5" width="14" height="10" {} }))
                    (stretch.label)
                }
            }
        }
    }
}

impl Plots {
    /// The pictures of some columns, side by side.
    pub fn of(&self, columns: &[usize]) -> Markup {
        html! {
            div.charts {
                @for (_, chart) in self.charts.iter().filter(|(column, _)| columns.contains(column)) {
                    (chart.markup())
                }
            }
        }
    }

    /// What explains the signs, and what happened by its numbers.
    pub fn signs(&self, t: &Text) -> Markup {
        html! {
            (self.legend)
            (self.flags)
            @if let Some(of) = self.condensed { p.note { (of) " " (t.condensed) } }
        }
    }

    /// All of it; D_O folded while nothing is said of it.
    pub fn folded(&self, t: &Text) -> Markup {
        let speaks = |chart: &Chart| {
            let newest = chart.tracks.first().and_then(|track| track.dots.last());
            newest.and_then(|dot| dot.status).is_some_and(|status| status > Status::NotEnoughData)
        };
        html! {
            (self.of(&[0, 1]))
            @for (_, chart) in self.charts.iter().filter(|(column, _)| *column == 2) {
                details.charts open[speaks(chart)] { summary { (symbol("D_O")) ": " (t.meaning_d_o) } (chart.markup()) }
            }
            (self.signs(t))
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
            made: [None; 3],
        };
        let all = [stretch(0, 10, false), stretch(10, 20, true), stretch(20, 30, false), stretch(30, 40, true)];
        let seen = |column| -> Vec<(i64, i64)> {
            Baseline::stretches(&all, column).iter().map(|one| (one.from.0, one.until.0)).collect()
        };
        assert_eq!((seen(0), seen(1)), (vec![(0, 20), (20, 40)], vec![(0, 20), (20, 40)]));
        assert_eq!(seen(2), [(0, 10), (10, 20), (20, 30), (30, 40)]);
    }

    #[test]
    fn an_envelope_holds_every_extreme_and_its_median_ignores_one_of_many() {
        let times: Vec<f64> = (0..24_000).map(f64::from).collect();
        let values: Vec<f64> = (0..24_000).map(|k| if k == 7_777 { 9.0 } else { (f64::from(k)).sin() }).collect();
        let found = envelope(&times, &values);
        assert_eq!(found.len(), STRETCHES);
        assert_eq!(found.iter().map(|[_, _, _, high]| *high).fold(f64::MIN, f64::max), 9.0);
        assert!(found.iter().all(|[_, low, median, high]| low <= median && median <= high && median.abs() < 0.2));
    }

    #[test]
    fn a_line_ends_at_the_edge_of_its_picture_on_its_own_course() {
        assert_eq!(cut((0.0, 0.0), (10.0, 5.0), 20.0), (10.0, 5.0));
        assert_eq!(cut((0.0, 0.0), (10.0, 5.0), 4.0), (4.0, 2.0));
        assert_eq!(cut((0.0, 1.0), (f64::INFINITY, 1.0), 4.0), (4.0, 1.0));
    }

    #[test]
    fn every_rule_has_a_letter_of_its_own() {
        let letters: std::collections::BTreeSet<char> = Rule::ALL.into_iter().map(Rule::letter).collect();
        assert_eq!(letters.len(), Rule::ALL.len());
    }
}
