//! `/stations`: what each station does to results, the one that is furthest out first.

use super::alerts::is_open_of;
use super::bullet;
use super::layout::day;
use super::prelude::*;
use super::station::{changes, drift_since};
use crate::core::alert_filter::AlertFilter;
use crate::core::changes::{Shared, StationFigures};

pub(super) async fn page(PageContext(ref pages, ref viewer): PageContext) -> Result<Page, Problem> {
    let t = viewer.text();
    let fleet = &pages.pipeline.queries.fleet;
    let (found, overdue) = (fleet.station_figures().await?, fleet.overdue_of_stations().await?);
    let mut stations: Vec<&StationFigures> = found.iter().flat_map(|found| &found.stations).collect();
    stations.sort_by(|a, b| furthest(b).total_cmp(&furthest(a)));
    let told = pages.pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
    let budget = pages.config.judging.budget;
    let body = html! {
        h1 { (t.stations) }
        @if let Some(found) = &found {
            p.note { (t.offset_against) " " (found.against) ". " (t.stations_note) }
            (wide_table("cards", html! {
                th { (t.station) } th.capital { (t.alerts) }
                @for name in DRIFTS.iter().take(2) { th.nowrap { (t.offset) " " (symbol(name)) } }
                th { (t.repeatability_short) } th { (t.drift_a_year) } th { (t.last_step) }
                th.n.capital { (t.overdue_gyros) } th { (t.last_seen) }
            }, html! { @for station in stations {
                @let is_open = |alert: &&_| is_open_of(alert, &station.name);
                @let alerts = told.iter().filter(is_open).count();
                (line(t, station, budget, alerts, overdue.get(&*station.name).copied().unwrap_or_default()))
            } }))
        } @else { p.lead { (t.nothing_yet) } }
    };
    Ok(Page { title: t.stations.into(), section: Section::Stations, body })
}

/// How far a station is out, deg/(h g0): the largest of its offsets, its drifts in a year where they are beyond chance,
/// and the repeatability of its records.
fn furthest(station: &StationFigures) -> f64 {
    let sizes = station.columns.iter().flat_map(|column| {
        let offset = column.offset.as_ref().map(|offset| offset.value.abs());
        let drift = column.drift.as_ref().filter(|_| column.drifts).map(|drift| drift.value.abs());
        [offset, drift, column.repeatability.as_ref().map(|spread| spread.sd)]
    });
    sizes.flatten().fold(0.0, f64::max)
}

fn line(t: &Text, station: &StationFigures, budget: f64, alerts: usize, overdue: usize) -> Markup {
    let load = |shared: &Shared| Measured { value: shared.value, sd: Some(shared.sd) }.in_units_of(budget);
    let columns = || station.columns.iter().zip(DRIFTS);
    html! {
        tr {
            th.nowrap scope="row" {
                a href={ "/stations/" (encoded(&station.name)) } { (station.name) }
                " · " a href={ "/fleet?station=" (encoded(&station.name)) "&station_when=ever" } {
                    (t.count_of_gyros(station.gyros))
                }
            }
            td data-label=(t.alerts) { @if alerts > 0 { a href={ "/stations/" (encoded(&station.name)) } { (alerts) } } }
            @for (column, name) in columns() {
                td.trend {
                    @if let Some(load) = column.offset.as_ref().map(load) {
                        (label(t.offset, name))
                        @let status = if load.value.abs() > 1.0 { Status::OutOfTolerance } else { Status::InTolerance };
                        (bullet::bar(load, status)) span.n { (bullet::percent(load)) }
                    }
                }
            }
            td data-label=(t.repeatability_short) { @for (column, name) in columns() {
                @if let Some(spread) = &column.repeatability {
                    span.slope { (symbol(name)) " " (format!("{:.1}", 100.0 * spread.sd / budget)) } " "
                }
            } }
            td data-label=(t.drift_a_year) { @for (column, name) in columns() {
                @if let Some(drift) = column.drift.as_ref().filter(|drift| column.drifts || drift.is_beyond_chance()) {
                    span.slope {
                        (symbol(name)) " " (bullet::percent(load(drift))) (drift_since(t, column))
                        @if !column.drifts { " (" (t.drift_of_gyros) ")" }
                    } " "
                }
            } }
            td data-label=(t.last_step) {
                @if let Some(unlike) = station.unlike.last() {
                    span.slope {
                        (day(unlike.from)) " … " @if let Some(until) = unlike.until { (day(until)) }
                        " " (t.words(&unlike.in_brief()))
                    } " "
                }
                @for (column, name) in columns() {
                @if let Some((from, until, size)) = changes(column).pop() {
                    span.slope {
                        (day(from)) @if let Some(until) = until { " … " (day(until)) }
                        " " (symbol(name)) " " (bullet::percent(load(size)))
                    } " "
                }
            } }
            td.n data-label=(t.overdue_gyros) { (overdue) }
            td data-label=(t.last_seen) { (day(station.last)) }
        }
    }
}
