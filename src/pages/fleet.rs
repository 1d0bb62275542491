//! `/`: the fleet at a glance. What is narrowed down stays in the address.

use axum::extract::{Query, State as Held};
use axum::response::Response;
use maud::{Markup, html};
use serde::Deserialize;

use super::Pages;
use super::figure;
use super::layout::{DRIFTS, Page, Section, encoded, instant, symbol};
use super::spark;
use super::viewer::Viewer;
use crate::core::judge::Measured;
use crate::core::judge::Status;
use crate::core::time::UtcMicros;
use crate::pages::status as badges;
use crate::pipeline::{BEYOND, FleetFilter, FleetPage, Names, RecentValues, Standing, Violation, sample_of};
use crate::wire::problem::Problem;

/// Gyros on one page, and values in one small line.
const ROWS: usize = 40;
const VALUES: usize = 24;

#[derive(Debug, Default, Deserialize)]
pub(super) struct Filters {
    /// Part of a serial, IMU or station.
    #[serde(default)]
    q: String,
    /// By its name on the wire.
    #[serde(default)]
    status: String,
    /// As links of earlier versions have it: `exceeded`, `warning`, `indeterminate`, `within` or `overdue`.
    #[serde(default)]
    state: String,
    #[serde(default)]
    station: String,
    #[serde(default)]
    page: usize,
}

pub(super) async fn page(Held(pages): Held<Pages>, viewer: Viewer, Query(filters): Query<Filters>) -> Response {
    viewer.show(build(&pages, &viewer, &filters).await)
}

async fn build(pages: &Pages, viewer: &Viewer, filters: &Filters) -> Result<Page, Problem> {
    let t = viewer.text();
    let filter = FleetFilter { text: &filters.q, station: &filters.station, statuses: filters.statuses() };
    let found = pages.pipeline.queries.fleet.page(&filter, filters.page, ROWS).await?;
    let gyros: Vec<&Standing> = found.gyros.iter().collect();
    let recent_values = pages.pipeline.queries.fleet.recent_values(&gyros, VALUES).await?;
    let rows: Vec<Row> = {
        let names = pages.pipeline.queries.names();
        gyros.iter().zip(&recent_values).map(|(standing, recent)| Row::of(standing, recent, &names)).collect()
    };
    let now = pages.clock.now();
    let body = html! {
        h1 { (t.fleet) }
        (tiles(viewer, &found, filters))
        (search(viewer, filters))
        @if found.total == 0 {
            p.lead { (t.nothing_yet) }
        } @else if rows.is_empty() {
            p.lead { (t.none_found) }
        } @else {
            p.note { (found.found) " " (t.gyros_found) " " (t.band_note) }
            (table(viewer, pages, &rows, now))
            (pager(viewer, filters, found.number, found.last))
        }
        (stations(viewer, &found))
    };
    Ok(Page { title: t.fleet.into(), section: Section::Fleet, body })
}

/// A gyro with its names and last values.
struct Row<'a> {
    standing: &'a Standing,
    recent: &'a RecentValues,
    imu: String,
    station: String,
}

impl<'a> Row<'a> {
    fn of(standing: &'a Standing, recent: &'a RecentValues, names: &Names<'_>) -> Self {
        let newest = standing.newest.as_ref();
        let imu = newest.map_or("", |figures| names.imu(figures.imu)).to_owned();
        let station = newest.map_or("", |figures| names.station(figures.station)).to_owned();
        Self { standing, recent, imu, station }
    }
}

impl Filters {
    /// What is wanted; none where all is.
    fn statuses(&self) -> Option<&'static [Status]> {
        if !self.status.is_empty() {
            let one = Status::ALL.iter().position(|status| status.name() == self.status);
            return Some(one.map_or(&[], |place| &Status::ALL[place..=place]));
        }
        match self.state.as_str() {
            "" => None,
            "exceeded" => Some(&BEYOND),
            "warning" => Some(&[Status::Drifting]),
            "indeterminate" => Some(&[Status::Borderline, Status::TooUncertain, Status::NotEnoughData]),
            "within" => Some(&[Status::InTolerance]),
            "overdue" => Some(&[Status::Overdue]),
            _ => Some(&[]),
        }
    }

    /// The address of another page of the same list.
    fn page(&self, page: usize) -> String {
        self.with((&self.status, &self.state), page)
    }

    /// The address of the same list with another status.
    fn address(&self, status: &str) -> String {
        self.with((status, ""), 0)
    }

    fn with(&self, (status, state): (&str, &str), page: usize) -> String {
        let page = if page > 0 { page.to_string() } else { String::new() };
        let all =
            [("q", self.q.trim()), ("status", status), ("state", state), ("station", &self.station), ("page", &page)];
        let given = all.iter().filter(|(_, value)| !value.is_empty());
        let query: Vec<String> = given.map(|(key, value)| format!("{key}={}", encoded(value))).collect();
        if query.is_empty() { "/".into() } else { format!("/?{}", query.join("&")) }
    }
}

/// How many of the fleet have each status; each leads to them.
fn tiles(viewer: &Viewer, fleet: &FleetPage, filters: &Filters) -> Markup {
    let t = viewer.text();
    let of_status = |status: Status| (status.name(), t.status(status), fleet.of_status[status as usize]);
    let there = |(name, _, count): &(&str, &str, usize)| *count > 0 || filters.status == *name;
    let counts = Status::ALL.into_iter().rev().map(of_status).filter(there);
    let counts = counts.chain([("", t.all_states, fleet.total)]);
    html! {
        ul.tiles {
            @for (status, name, count) in counts {
                li {
                    a.(if status.is_empty() { "total" } else { status }) href=(filters.address(status))
                        aria-current=[(filters.status == status && filters.state.is_empty()).then_some("true")] {
                        strong { (count) } span { (name) }
                    }
                }
            }
        }
    }
}

fn search(viewer: &Viewer, filters: &Filters) -> Markup {
    let t = viewer.text();
    let narrowed = !(filters.q.is_empty() && filters.statuses().is_none() && filters.station.is_empty());
    html! {
        form.search role="search" action="/" method="get" {
            input type="search" name="q" value=(filters.q) placeholder=(t.search_hint) aria-label=(t.search_hint);
            @for (name, value) in [("status", &filters.status), ("state", &filters.state)] {
                @if !value.is_empty() { input type="hidden" name=(name) value=(value); }
            }
            @if !filters.station.is_empty() { input type="hidden" name="station" value=(filters.station); }
            button { (t.search) }
            @if !filters.station.is_empty() { span.note { (t.station) ": " (filters.station) } }
            @if narrowed { a href="/" { (t.clear_filters) } }
        }
    }
}

fn table(viewer: &Viewer, pages: &Pages, rows: &[Row<'_>], now: UtcMicros) -> Markup {
    let t = viewer.text();
    html! {
        div.scroll tabindex="0" {
            table.fleet {
                thead { tr {
                    th { (t.status_word) } th { (t.serial) } th { (t.imu) }
                    th { (symbol("D_I")) ", " (t.unit) } th { (symbol("D_S")) ", " (t.unit) }
                    th { (t.violates) } th { (t.calibrated) }
                } }
                tbody { @for row in rows { (line(viewer, pages, row, now)) } }
            }
        }
    }
}

fn line(viewer: &Viewer, pages: &Pages, row: &Row<'_>, now: UtcMicros) -> Markup {
    let (t, standing) = (viewer.text(), row.standing);
    let newest = standing.newest.as_ref().map(|figures| sample_of(figures, pages.config.judging.method));
    html! {
        tr {
            td { (badges::badge(t, standing.status)) " " (badges::out_of_use(t, standing.out_of_use)) }
            th scope="row" { a.id href={ "/gyros/" (encoded(&standing.serial)) } { (standing.serial) } }
            td {
                @if let Some(figures) = &standing.newest {
                    a.id href={ "/imus/" (encoded(&row.imu)) } { (row.imu) } " " span.quiet { (figures.slot.name()) }
                }
            }
            @for column in 0..2 {
                td.trend data-label=(DRIFTS[column]) {
                    @if let Some(sample) = &newest { (trend(row.recent, column, sample.d[column])) }
                }
            }
            td {
                @for Violation { coefficient, rule, status } in &standing.violations {
                    span.broken.(status.name()) title=(t.status(*status)) { (symbol(coefficient.name())) " " (t.rule(*rule)) }
                }
                @if standing.overdue_days.is_some() { span.broken.overdue { (t.status(Status::Overdue)) } }
            }
            td { @if let Some(figures) = &standing.newest { (age(viewer, figures.at, now, &row.station)) } }
        }
    }
}

fn trend(recent: &RecentValues, column: usize, newest: Measured) -> Markup {
    let values: Vec<f64> = recent.samples.iter().map(|sample| sample.d[column].value).collect();
    let written = figure::drift(newest.value, newest.sd);
    html! {
        (spark::line(&values, recent.level[column], recent.budget[column], &written))
        span.n { (written) }
    }
}

fn age(viewer: &Viewer, at: UtcMicros, now: UtcMicros, station: &str) -> Markup {
    let t = viewer.text();
    let days = now.days_since(at).floor();
    html! {
        span.nowrap { (instant(at)) }
        br;
        span.quiet {
            span.nowrap {
                @if days < 1.0 { (t.today) } @else if days < 2.0 { (t.yesterday) } @else { (format!("{days:.0}")) " " (t.days_ago) }
                " ·"
            }
            " " span.id { (station) }
        }
    }
}

fn pager(viewer: &Viewer, filters: &Filters, number: usize, last: usize) -> Markup {
    let t = viewer.text();
    html! {
        @if last > 0 {
            nav.pager aria-label=(t.page_of) {
                @if number > 0 { a rel="prev" href=(filters.page(number - 1)) { (t.previous) } }
                span { (number + 1) " / " (last + 1) }
                @if number < last { a rel="next" href=(filters.page(number + 1)) { (t.next) } }
            }
        }
    }
}

/// The stations that calibrated the gyros last.
fn stations(viewer: &Viewer, fleet: &FleetPage) -> Markup {
    let t = viewer.text();
    html! {
        @if !fleet.of_station.is_empty() {
            h2 { (t.stations) }
            div.scroll tabindex="0" { table {
                thead { tr { th { (t.station) } th.n.capital { (t.gyros) } th.n.capital { (t.beyond) } th { (t.last_seen) } } }
                tbody { @for (name, of_station) in &fleet.of_station {
                    tr {
                        th scope="row" { a.id href={ "/?station=" (encoded(name)) } { (name) } }
                        td.n { (of_station.gyros) } td.n { (of_station.beyond) }
                        td { (instant(of_station.last_calibrated)) }
                    }
                } }
            } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_stay_in_the_address() {
        let filters =
            Filters { q: " IMU 07&".into(), station: "ST-2".into(), status: "confirmed".into(), ..Filters::default() };
        assert_eq!(filters.page(2), "/?q=IMU%2007%26&status=confirmed&station=ST-2&page=2");
        assert_eq!(filters.address("overdue"), "/?q=IMU%2007%26&status=overdue&station=ST-2");
        assert_eq!(Filters::default().page(0), "/");
    }

    #[test]
    fn addresses_of_earlier_versions_find_what_they_found() {
        let of = |state: &str| Filters { state: state.into(), ..Filters::default() };
        assert_eq!(of("exceeded").page(1), "/?state=exceeded&page=1");
        assert_eq!(of("exceeded").address("drifting"), "/?status=drifting", "another choice takes its place");
        let every: Vec<&Status> = ["exceeded", "warning", "indeterminate", "within", "overdue"]
            .iter()
            .flat_map(|old| of(old).statuses().unwrap())
            .collect();
        assert!(every.len() == Status::ALL.len() && Status::ALL.iter().all(|status| every.contains(&status)));
        assert_eq!((of("").statuses(), of("nonsense").statuses()), (None, Some(&[][..])));
    }
}
