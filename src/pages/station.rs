//! `/stations/{name}`: one station by what the gyros of the fleet share there.

use super::alerts::{self, is_open_of};
use super::bullet::percent;
use super::course::CoefficientSeries;
use super::layout::day;
use super::prelude::*;
use crate::core::alert_filter::AlertFilter;
use crate::core::changes::{FleetStations, Shared, Spread, StationColumn, StationFigures};
use crate::core::suspect_window::SuspectWindow;

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref name): Path<String>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let fleet = &pages.pipeline.queries.fleet;
    let (found, overdue) = (fleet.station_figures().await?, fleet.overdue_of_stations().await?);
    let overdue = overdue.get(name).copied().unwrap_or_default();
    let told = pages.pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
    let open: Vec<&AlertBody> = told.iter().filter(|alert| is_open_of(alert, name)).collect();
    let figures = found.as_ref().and_then(|found| found.stations.iter().find(|station| *station.name == *name));
    let windows = pages.pipeline.queries.suspect_windows(name).await?;
    let windows = windows.ok_or_else(|| Problem::no_such_station(name))?;
    let known = found.as_deref().zip(figures);
    let body = html! {
        h1 { (t.station) " " (name) }
        @if let Some((_, figures)) = known { p.lead {
            (t.last_seen) " " (instant(figures.last)) " · " (t.words(&message!("calibrations_counted", count = figures.records)))
            " · " a href={ "/fleet?station=" (encoded(name)) "&station_when=ever" } { (t.count_of_gyros(figures.gyros)) }
            @if figures.imus > 0 { " · " (t.words(&message!("imus_counted", count = figures.imus))) }
            " · " (t.words(&message!("overdue_counted", count = overdue)))
            " · " a href={ "/v1/stations/" (encoded(name)) } { "JSON" }
        } } @else { p.lead { (t.nothing_counts) } }
        @if let Some((_, figures)) = known { (did(t, figures, pages.config.judging.budget)) }
        @if !open.is_empty() { (alerts::table(viewer, open.into_iter(), false, None)) }
        @if viewer.may(Role::Engineer) {
            p {
                a.action href={ "/stations/" (encoded(name)) "/suspect" } { (t.suspect_window) } " "
                @if !windows.is_empty() { a.action href={ "/stations/" (encoded(name)) "/trust" } { (t.trust_window) } }
            }
        }
        @if !windows.is_empty() { (suspect(viewer, name, &windows)) }
        @if let Some((found, figures)) = known { (compared(viewer, name, found, figures, pages.config.judging.budget)) }
    };
    Ok(Page { title: format!("{} {name}", t.station), section: Section::Stations, body })
}

/// The newest change of each coefficient, and its drift where it has one: nothing, where it did nothing.
fn did(t: &Text, figures: &StationFigures, budget: f64) -> Markup {
    let share = |size: &Shared| percent(Measured { value: size.value, sd: Some(size.sd) }.in_units_of(budget));
    html! {
        @for unlike in &figures.unlike { p.lead { (t.words(&unlike.message())) } }
        @for (column, coefficient) in figures.columns.iter().zip(DRIFTS) {
            @if let Some((from, until, size)) = changes(column).pop() {
                p.lead {
                    strong { (symbol(coefficient)) (t.colon) } (found(t, until)) " " (day(from))
                    @if let Some(until) = until { " … " (day(until)) }
                    ", " (share(size)) (t.share_of_budget_unit)
                }
            }
            @if let Some(drift) = column.drift.as_ref().filter(|_| column.drifts) {
                p.lead {
                    strong { (symbol(coefficient)) (t.colon) } (t.drift_a_year) " " (share(drift)) (t.share_of_budget_unit)
                    (drift_since(t, column))
                }
            }
        }
    }
}

/// What it does beside the other stations, coefficient by coefficient.
fn compared(viewer: &Viewer, name: &str, found: &FleetStations, figures: &StationFigures, budget: f64) -> Markup {
    let t = viewer.text();
    html! {
        p.note { (t.station_figures_note) " " (t.unit) }
        @for (column, coefficient) in figures.columns.iter().zip(DRIFTS) {
            @let against = figures.against.as_ref().unwrap_or(&found.against);
            (section(viewer, name, coefficient, column, (against, budget)))
        }
        @if found.reproducibility.iter().any(Option::is_some) {
            section {
                h2 { (t.reproducibility) }
                p.note { (t.reproducibility_note) }
                dl.facts { @for (spread, coefficient) in found.reproducibility.iter().zip(DRIFTS) {
                    dt { (symbol(coefficient)) } dd { (said(spread.as_ref())) }
                } }
            }
        }
    }
}

/// The windows in which what it measures does not count.
fn suspect(viewer: &Viewer, name: &str, windows: &[SuspectWindow]) -> Markup {
    let t = viewer.text();
    html! {
        section {
            h2 { (t.suspect_windows) }
            dl { @for SuspectWindow { span, author, reason } in windows {
                dt { (instant(span.from)) " … " (instant(span.to)) }
                dd {
                    (reason) " (" span translate="no" { (author) } ")"
                    @if viewer.may(Role::Engineer) {
                        " " a.action href={
                            "/stations/" (encoded(name)) "/trust?from=" (time::format(span.from)) "&to=" (time::format(span.to))
                        } { (t.trust_this_window) }
                    }
                }
            } }
        }
    }
}

fn section(
    viewer: &Viewer,
    name: &str,
    coefficient: &str,
    column: &StationColumn,
    (against, budget): (&str, f64),
) -> Markup {
    let t = viewer.text();
    let course = CoefficientSeries {
        symbol: coefficient,
        name,
        budget: Some(budget),
        points: column.course.iter().map(|point| (point.at, point.value, Some(point.sd))).collect(),
        lines: Vec::new(),
        marks: changes(column).into_iter().map(|(from, until, _)| (from, found(t, until).to_owned())).collect(),
    };
    html! {
        section id=(coefficient) {
            h2 { (symbol(coefficient)) }
            (course.markup(t))
            dl.facts {
                dt { (t.repeatability) } dd { (said(column.repeatability.as_ref())) }
                @if let Some(offset) = &column.offset {
                    dt { (t.offset_against) " " (against) } dd { (shared(offset)) }
                }
                @if let Some(drift) = &column.drift {
                    dt { (t.drift_a_year) } dd {
                        (shared(drift)) (drift_since(t, column))
                        @if !column.drifts { " (" (remark(t, drift)) ")" }
                    }
                }
                @for (from, until, size) in changes(column) {
                    dt {
                        (found(t, until)) " " (instant(from))
                        @if let Some(until) = until { " … " (instant(until)) }
                    }
                    dd { (shared(size)) @if viewer.may(Role::Engineer) {
                        " " a.action href={
                            "/stations/" (encoded(name)) "/suspect?from=" (time::format(from))
                            @if let Some(until) = until { "&to=" (time::format(UtcMicros(until.0 - 1))) }
                        } { (t.suspect_from_here) }
                    } }
                }
                @if let Some(by_gyro) = &column.by_gyro { dt { (t.gyro_by_station) } dd { (said(Some(by_gyro))) } }
            }
        }
    }
}

/// What a change is called: a window where it ended.
fn found(t: &Text, until: Option<UtcMicros>) -> &'static str {
    if until.is_some() { t.off_found } else { t.step_found }
}

/// Where a drift began within the records.
pub(super) fn drift_since(t: &Text, column: &StationColumn) -> Markup {
    html! { @if let Some(at) = column.drift_since { ", " (t.since_then) " " (day(at)) } }
}

/// Of a drift that is not said to be the station's.
fn remark(t: &Text, drift: &Shared) -> &'static str {
    if drift.is_beyond_chance() { t.drift_of_gyros } else { t.within_chance }
}

/// Its steps and the windows in which it was off: when each began and ended, and its size. Oldest first.
pub(super) fn changes(column: &StationColumn) -> Vec<(UtcMicros, Option<UtcMicros>, &Shared)> {
    let steps = column.steps.iter().map(|(at, size)| (*at, None, size));
    let mut all: Vec<_> =
        steps.chain(column.windows.iter().map(|([from, until], size)| (*from, Some(*until), size))).collect();
    all.sort_by_key(|(from, ..)| *from);
    all
}

fn shared(shared: &Shared) -> Markup {
    html! { (figure::signed_drift(shared.value, Some(shared.sd))) }
}

/// A standard deviation with its interval.
fn said(spread: Option<&Spread>) -> Markup {
    html! {
        @if let Some(Spread { sd, interval: [low, high], .. }) = spread {
            (figure::fixed(*sd, 6)) " (" (figure::fixed(*low, 6)) " … " (figure::fixed(*high, 6)) ")"
        } @else { "–" }
    }
}
