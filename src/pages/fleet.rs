//! `/fleet`: every gyro on a line, all loads on one scale; or by IMU. What is narrowed down stays in the address.

mod filters;
mod wall;

use std::collections::HashMap;
use std::time::Duration;

use super::layout::{DRIFTS, day, encoded, label, symbol};
use super::prelude::*;
use super::{bullet, figure, spark, status as badges};
use crate::core::judge::{Coefficient, Measured, Rule, Status};
use crate::core::time::{Span, UtcMicros};
use crate::pipeline::{BEYOND, DueDate, GyroStatus, Names, RecentValues, Violation, sample_of};
pub(super) use filters::{Filters, as_day, bad_parameter, named};

/// Gyros on one page, values in one small line, and how long that is.
const ROWS: usize = 40;
const VALUES: usize = 24;
const SPAN_DAYS: f64 = 365.0;
/// By when the budget is reached.
const BY_DATE: &str = "eta";
/// How long the page waits for the dates of gyros that drift.
const PATIENCE: Duration = Duration::from_millis(60);

pub(super) async fn page(PageContext(ref pages, ref viewer): PageContext, Query(filters): Query<Filters>) -> Response {
    let shown = match filters.is_wall() {
        true => wall::build(pages, viewer, &filters).await,
        false => build(pages, viewer, &filters).await,
    };
    filters.again(shown.into_response())
}

async fn build(pages: &Pages, viewer: &Viewer, filters: &Filters) -> Result<Page, Problem> {
    let t = viewer.text();
    let queries = &pages.pipeline.queries;
    let found = queries.fleet.page(&filters.filter()?, filters.page, ROWS).await?;
    let now = pages.clock.now();
    let (by_history, undated) = queries.dues.of(&found.gyros, PATIENCE).await?;
    let gyros: Vec<&GyroStatus> = found.gyros.iter().collect();
    let recent_values = queries.fleet.recent_values(&gyros, VALUES).await?;
    let table = {
        let row = |(standing, recent)| Row::of(standing, recent, &by_history);
        let mut rows: Vec<Row<'_>> = gyros.iter().copied().zip(&recent_values).map(row).collect();
        if filters.sort == BY_DATE {
            // A page was chosen by the dates of the rule `trend`, which is all that the fleet can be put in order by.
            rows.sort_by_key(|row| (row.due.is_none(), row.due.map(|due| due.at)));
        }
        table(t, pages, filters, &rows, now)
    };
    let body = html! {
        @if !gyros.is_empty() { a.skip href="#first" { (t.skip_to_first) } }
        h1 { (t.fleet) }
        (filters.tiles(t, &found))
        (filters.form(t, &found))
        @if found.total == 0 {
            p.lead { (t.nothing_yet) }
        } @else if gyros.is_empty() {
            p.lead { (t.none_found) }
        } @else {
            p.note { (found.found) " " (t.gyros_of) " " (t.load_note) span.of-spark { " " (t.spark_note) } }
            (table)
            @if filters.sort == BY_DATE && found.last > 0 { p.note { (t.by_date_note) } }
            @if undated > 0 { p.note { (t.dates_of_others) " " (t.count_of_gyros(undated)) } }
            (filters.pager(t, found.number, found.last))
            (selection(viewer))
        }
    };
    Ok(Page { title: t.fleet.into(), section: Section::Fleet, body })
}

/// A gyro with its last values.
struct Row<'a> {
    standing: &'a GyroStatus,
    recent: &'a RecentValues,
    /// When it reaches its budget by its course, as long as it is not known to be beyond.
    due: Option<DueDate>,
}

impl<'a> Row<'a> {
    fn of(standing: &'a GyroStatus, recent: &'a RecentValues, by_history: &HashMap<u32, DueDate>) -> Self {
        let is_ahead = standing.status.is_none_or(|status| !BEYOND.contains(&status));
        let due = by_history.get(&standing.number).copied().or_else(|| DueDate::by_trend(standing));
        Self { standing, recent, due: due.filter(|_| is_ahead) }
    }
}

fn table(t: &Text, pages: &Pages, filters: &Filters, rows: &[Row<'_>], now: UtcMicros) -> Markup {
    let head = |sort: &str, name: Markup| filters.head(sort, &name);
    let names = pages.pipeline.queries.names();
    html! {
        (wide_table("fleet", html! {
            th.no-print { span.hidden { (t.choose) } }
            (head("", html! { (t.status_word) }))
            (head("serial", html! { (t.serial) }))
            th { (t.imu) }
            (head("load", html! { (symbol("D_I")) (t.of_budget_unit) }))
            th { (symbol("D_S")) (t.of_budget_unit) }
            (head(BY_DATE, html! { (t.slope_or_date) }))
            th { (t.violates_besides) }
            th { (t.since) }
            (head("age", html! { (t.calibrated) }))
        }, html! { @for (k, row) in rows.iter().enumerate() { (line(t, pages, row, k == 0, now, &names)) } }))
    }
}

fn line(t: &Text, pages: &Pages, row: &Row<'_>, first: bool, now: UtcMicros, names: &Names<'_>) -> Markup {
    let standing = row.standing;
    let newest = standing.newest.as_ref().map(|figures| sample_of(figures, pages.config.judging.method));
    let is_worse = standing.status.is_some_and(|status| status >= Status::Drifting);
    html! {
        tr {
            td.choice.no-print {
                input type="checkbox" name="gyro" value=(standing.serial) form="selection" aria-label=(standing.serial);
            }
            td { (badges::badge(t, standing.status)) (badges::out_of_use(t, standing.out_of_use)) }
            (gyro(standing, first, names))
            @for column in 0..2 {
                td.trend {
                    @if let Some(sample) = &newest {
                        (label("", DRIFTS[column]))
                        (load(t, row.recent, column, (standing.projection.load[column], standing.drift[column]), sample.d[column], now))
                    }
                }
            }
            td data-label=(t.slope_or_date) { (slopes(t, standing)) (reaches(t, row.due)) }
            td data-label=(t.violates) { (violated(t, &besides(&standing.violations))) }
            td data-label=(t.since) { @if let Some(since) = standing.since.filter(|_| is_worse) { (day(since)) } }
            td data-label=(t.calibrated) {
                @if let Some(figures) = &standing.newest { (age(t, figures.at, now, names.station(figures.station))) }
            }
        }
    }
}

/// Which gyro it is, and where it was measured last. `first`: whether it is the first of the page, which the keyboard
/// skips to.
pub(super) fn gyro(standing: &GyroStatus, first: bool, names: &Names<'_>) -> Markup {
    html! {
        th scope="row" {
            a.id id=[first.then_some("first")] href={ "/gyros/" (encoded(&standing.serial)) } { (standing.serial) }
        }
        td {
            @if let Some(newest) = &standing.newest {
                @let imu = names.imu(newest.imu);
                a.id href={ "/imus/" (encoded(imu)) } { (imu) } " " span.quiet { (newest.slot.name()) }
            }
        }
    }
}

/// The last values, the load on the common scale, and in figures; before the baseline is complete, the value.
fn load(
    t: &Text,
    recent: &RecentValues,
    column: usize,
    (load, status): (Option<Measured>, Status),
    newest: Measured,
    now: UtcMicros,
) -> Markup {
    let values: Vec<(UtcMicros, f64)> =
        recent.samples.iter().map(|sample| (sample.at, sample.d[column].value)).collect();
    let span = Span { from: now.plus_days(-SPAN_DAYS), to: now };
    let value = figure::drift(newest.value, newest.sd);
    html! {
        @if let Some(load) = load {
            @let percent = bullet::in_column(t, load);
            (spark::line(&values, span, recent.level[column], recent.budget[column]))
            (bullet::bar(load, status))
            span.n title=(value) { (percent) }
        } @else { span.n.quiet { (value) " " (t.unit) } }
    }
}

/// Slopes that are established.
pub(super) fn slopes(t: &Text, standing: &GyroStatus) -> Markup {
    html! {
        @for (slope, name) in standing.projection.per_year.iter().zip(DRIFTS) {
            @if let Some(slope) = slope {
                span.slope { (symbol(name)) " " (bullet::percent(*slope)) (t.percent_a_year) } " "
            }
        }
    }
}

/// When a gyro reaches its budget.
fn reaches(t: &Text, due: Option<DueDate>) -> Markup {
    html! {
        @if let Some(due) = due {
            span.slope.quiet title=(t.reaches_budget) {
                (symbol(due.coefficient.name())) " " (day(due.at)) @if due.provisional { " ?" }
            }
        }
    }
}

/// What the loads do not show: all but the distances of D_I and D_S from their baselines.
fn besides(violations: &[Violation]) -> Vec<Violation> {
    let is_load =
        |one: &Violation| one.rule == Rule::Baseline && matches!(one.coefficient, Coefficient::DI | Coefficient::DS);
    violations.iter().copied().filter(|one| !is_load(one)).collect()
}

/// The gravest, and how many more.
pub(super) fn violated(t: &Text, violations: &[Violation]) -> Markup {
    let gravest = violations.iter().max_by_key(|violation| violation.status);
    html! {
        @if let Some(Violation { coefficient, rule, status, .. }) = gravest {
            span.broken.(status.name()) title=(t.status(*status)) { (symbol(coefficient.name())) " " (t.rule(*rule)) }
            @if violations.len() > 1 {
                @let all: Vec<String> =
                    violations.iter().map(|one| format!("{} {}", one.coefficient.name(), t.rule(one.rule))).collect();
                span.quiet title=(all.join(" · ")) { "+" (violations.len() - 1) }
            }
        }
    }
}

fn age(t: &Text, at: UtcMicros, now: UtcMicros, station: &str) -> Markup {
    html! {
        span.nowrap title=(as_day(at)) {
            (figure::whole_days(now.days_since(at))) " " (t.days_short) " " span.quiet { "· " span.id { (station) } }
        }
    }
}

/// What is done with the gyros that are ticked.
fn selection(viewer: &Viewer) -> Markup {
    let t = viewer.text();
    html! {
        form.selection.no-print #selection method="get" action="/compare" {
            label hidden { input type="checkbox" data-all="gyro"; " " (t.all_of_them) }
            span.quiet { (t.with_selected) }
            button formaction="/compare" { (t.compare_ticked) }
            @if viewer.may(Role::Engineer) { button formaction="/alerts/bulk" { (t.acknowledge) } }
            button formaction="/reports" { (t.reports) }
        }
    }
}
