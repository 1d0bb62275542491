//! `/stations`: what each station does to results.

use axum::extract::State as Held;
use axum::response::Response;
use maud::{Markup, html};

use super::Pages;
use super::figure;
use super::layout::{DRIFTS, Page, Section, encoded, instant, symbol};
use super::text::Text;
use super::viewer::Viewer;
use crate::pipeline::StationEffect;
use crate::wire::problem::Problem;

pub(super) async fn page(Held(pages): Held<Pages>, viewer: Viewer) -> Response {
    viewer.show(build(&pages, &viewer).await)
}

async fn build(pages: &Pages, viewer: &Viewer) -> Result<Page, Problem> {
    let t = viewer.text();
    let fleet = &pages.pipeline.queries.fleet;
    let (stations, overdue) = (fleet.stations().await?, fleet.overdue_of_stations().await?);
    let body = html! {
        h1 { (t.stations) }
        @if stations.is_empty() { p.lead { (t.nothing_yet) } } @else {
            p.note { (t.station_note) " " (t.unit) }
            div.scroll tabindex="0" { table.cards {
                thead { tr {
                    th { (t.station) } th { (t.last_seen) } th.n { (t.calibrations_seen) } th.n { (t.overdue_gyros) }
                    th.n { (t.scatter) " " (symbol("D_I")) } th.n { (t.scatter) " " (symbol("D_S")) }
                    th.n { (t.on_arrival) " " (symbol("D_I")) } th.n { (t.on_arrival) " " (symbol("D_S")) } th.n.capital { (t.changes_seen) }
                } }
                tbody { @for station in &stations { (line(t, station, overdue.get(&*station.name).copied().unwrap_or_default())) } }
            } }
        }
    };
    Ok(Page { title: t.stations.into(), section: Section::Stations, body })
}

fn line(t: &Text, station: &StationEffect, overdue: usize) -> Markup {
    html! {
        tr {
            th scope="row" { a href={ "/stations/" (encoded(&station.name)) } { (station.name) } " · " a href={ "/fleet?station=" (encoded(&station.name)) } { (t.gyros) } }
            td data-label=(t.last_seen) { (instant(station.last)) }
            td.n data-label=(t.calibrations_seen) { (station.records) }
            td.n data-label=(t.overdue_gyros) { (overdue) }
            @for (scatter, name) in station.scatter.into_iter().zip(DRIFTS) { td.n data-label={ (t.scatter) " " (name) } { @if let Some(scatter) = scatter { (figure::fixed(scatter, 6)) } @else { "–" } } }
            @for (arrival, name) in station.arrival.into_iter().zip(DRIFTS) {
                td.n data-label={ (t.on_arrival) " " (name) } { @if let Some((mean, error)) = arrival { (figure::with_sd(mean, error, 6)) } @else { "–" } }
            }
            td.n data-label=(t.changes_seen) { (station.arrivals) }
        }
    }
}
