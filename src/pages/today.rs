//! `/`: what there is to be done. Five blocks, and a sixth where a forecast failed, each with its first few lines and the
//! way to all of them.

use std::collections::HashMap;
use std::sync::Arc;

use axum::http::Uri;
use axum::response::{IntoResponse, Redirect, Response};
use maud::{Markup, html};
use serde::Deserialize;

use super::alerts::{self, done_to_alerts, is_open, open_ones};
use super::fleet::{Filters, as_day, bad_parameter, tiles, trend, violated};
use super::layout::{DRIFTS, Page, Section, day, encoded, symbol, written_day};
use super::text::Text;
use super::viewer::{Viewer, Visit};
use super::{Pages, bullet, figure};
use crate::core::access::Role;
use crate::core::alert_filter::AlertFilter;
use crate::core::judge::{Coefficient, Measured, Status};
use crate::core::time::UtcMicros;
use crate::pages::sent::Query;
use crate::pages::status as badges;
use crate::pipeline::{DueImu, FirstOf, FleetFilter, FleetPage, Names, Standing, Today, Together, today};
use crate::wire::alert::AlertBody;
use crate::wire::problem::Problem;
use crate::wire::time;

/// Lines of a block.
const LINES: usize = 6;
/// What is new, unless another day is asked for.
const DAYS: f64 = 7.0;
/// Parameters of the fleet, which stood here in earlier versions.
const OF_FLEET: [&str; 5] = ["q", "status", "state", "station", "page"];

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Asked {
    /// A day, or a time.
    since: String,
    /// What has just been done, and to which alerts, parted by commas: that can be taken back.
    deed: String,
    done: String,
}

pub(super) async fn page(
    Visit { ref pages, ref viewer }: Visit,
    uri: Uri,
    Query(asked): Query<Asked>,
) -> Result<Response, Problem> {
    let query = uri.query().unwrap_or_default();
    let is_of_fleet = |one: &str| OF_FLEET.contains(&one.split('=').next().unwrap_or_default());
    if query.split('&').any(is_of_fleet) {
        return Ok(Redirect::permanent(&format!("{}/fleet?{query}", viewer.base_path)).into_response());
    }
    Ok(build(pages, viewer, &asked).await?.into_response())
}

async fn build(pages: &Pages, viewer: &Viewer, asked: &Asked) -> Result<Page, Problem> {
    let (t, now) = (viewer.text(), pages.clock.now());
    let since = match asked.since.trim() {
        "" => now.plus_days(-DAYS),
        said => time::parse_start(said).map_err(|fault| bad_parameter("since", fault))?,
    };
    let queries = &pages.pipeline.queries;
    let today = today(&queries.fleet, since, LINES).await?;
    let fleet = queries.fleet.page(&FleetFilter::default(), 0, LINES).await?;
    let shown = fleet.gyros.iter().chain(&today.worse.first);
    let dealt = dealt_with(pages, viewer, shown).await?;
    let gone = no_longer_in_it(pages, &today.overdue.first).await?;
    let told = pages.pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
    let names = queries.names();
    let out = still(&fleet, &today.worse);
    let of_stations: Vec<&AlertBody> = told.iter().filter(|alert| alert.is_of_station() && is_open(alert)).collect();
    let body = html! {
        @if !today.worse.first.is_empty() || !out.is_empty() { a.skip href="#first" { (t.skip_to_first) } }
        h1 { (t.today_title) }
        (done_to_alerts(viewer, &asked.deed, &asked.done, "/"))
        (tiles(viewer, &fleet, &Filters::default()))
        div.blocks {
            (worse(viewer, &today.worse, since, &dealt, &names))
            (still_out(viewer, &fleet, (&today.worse, &out), &dealt, &names))
            (approaching(t, &today.approaching, &names))
            (due(t, &today, &gone, now))
            (several(viewer, &today, &of_stations))
            @if today.outside.of > 0 { (outside(t, &today)) }
        }
    };
    Ok(Page { title: t.today_title.into(), section: Section::Today, body })
}

fn block(title: &Markup, count: usize, nothing: &str, body: &Markup, all: Option<(&str, String)>) -> Markup {
    html! {
        section.block {
            h2 { (title) " " span.count { (count) } }
            @if count == 0 { p.note { (nothing) } } @else { (body) }
            @if let Some((words, address)) = all { p { a href=(address) { (words) " →" } } }
        }
    }
}

/// What was decided of gyros since they are as they are, or who knows of all that fires: of those of which somebody
/// does.
async fn dealt_with(
    pages: &Pages,
    viewer: &Viewer,
    gyros: impl Iterator<Item = &Standing>,
) -> Result<HashMap<u32, Markup>, Problem> {
    let t = viewer.text();
    let mut dealt = HashMap::new();
    for Standing { number, since, .. } in gyros {
        let events = pages.pipeline.queries.histories.events(*number).await?;
        let decision =
            events.iter().rev().find(|one| one.event.is_decision() && since.is_none_or(|since| since <= one.at));
        let alerts = open_ones(pages, *number).await?;
        let known: Option<Vec<_>> = alerts.iter().map(|alert| alert.acknowledged.as_ref()).collect();
        let said = match (decision, known.and_then(|known| known.into_iter().max_by_key(|known| known.at.clone()))) {
            (Some(decision), _) => Some((t.event(decision.event), decision.author.as_deref(), day(decision.at))),
            (None, Some(known)) => Some((t.alert_acknowledged, Some(&*known.by), written_day(&known.at))),
            (None, None) => None,
        };
        dealt.extend(said.map(|(what, who, at)| {
            let who = html! { @if let Some(who) = who { " · " span translate="no" { (who) } } };
            (*number, html! { span.quiet { (what) (who) " · " (at) } })
        }));
    }
    Ok(dealt)
}

/// Overdue gyros whose place in the IMU another one has taken.
async fn no_longer_in_it(pages: &Pages, overdue: &[DueImu]) -> Result<HashMap<Arc<str>, Vec<Arc<str>>>, Problem> {
    let mut gone = HashMap::new();
    for DueImu { imu, .. } in overdue {
        let number = pages.pipeline.queries.names().imu_number(imu);
        let Some(number) = number else { continue };
        let before = pages.pipeline.queries.fleet.seated_in(number).await?.before.into_iter();
        let late: Vec<Arc<str>> = before.filter(|one| one.overdue_days.is_some()).map(|one| one.serial).collect();
        if !late.is_empty() {
            gone.insert(imu.clone(), late);
        }
    }
    Ok(gone)
}

/// The way to all, where there are more than are shown.
fn all_of<'a, T>(t: &'a Text, list: &FirstOf<T>, address: impl FnOnce() -> String) -> Option<(&'a str, String)> {
    (list.of > list.first.len()).then(|| (t.all_of_them, address()))
}

/// `first`: whether it is the first of the page, which the keyboard skips to.
fn gyro(standing: &Standing, first: bool, names: &Names<'_>) -> Markup {
    html! {
        th scope="row" { a.id id=[first.then_some("first")] href={ "/gyros/" (encoded(&standing.serial)) } { (standing.serial) } }
        td {
            @if let Some(newest) = &standing.newest {
                @let imu = names.imu(newest.imu);
                a.id href={ "/imus/" (encoded(imu)) } { (imu) } " " span.quiet { (newest.slot.name()) }
            }
        }
    }
}

fn worse(
    viewer: &Viewer,
    list: &FirstOf<Standing>,
    since: UtcMicros,
    dealt: &HashMap<u32, Markup>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let from = as_day(since);
    let title = html! { (t.worse_since) " " (day(since)) };
    let rows = violating(viewer, list.first.iter(), true, dealt, names);
    let form = html! {
        form.search.no-print action="/" method="get" {
            label { (t.since_day) " " input type="date" name="since" value=(from); }
            button { (t.search) }
        }
    };
    let address = || Filters { changed_since: from.clone(), ..Filters::default() }.at_page(0);
    let shown = block(&title, list.of, t.nothing_worse, &rows, all_of(t, list, address));
    html! { div { (shown) (form) } }
}

const OUT: [Status; 4] = [Status::Drifting, Status::Unconfirmed, Status::OutOfTolerance, Status::Confirmed];

/// What is out of tolerance or drifting and has not changed since: the worst of the fleet, without those in `worse`.
fn still<'a>(fleet: &'a FleetPage, worse: &FirstOf<Standing>) -> Vec<&'a Standing> {
    let is_out = |standing: &&Standing| {
        let is_above = worse.first.iter().any(|above| above.serial == standing.serial);
        standing.status.is_some_and(|status| OUT.contains(&status)) && !is_above
    };
    fleet.gyros.iter().filter(is_out).collect()
}

fn still_out(
    viewer: &Viewer,
    fleet: &FleetPage,
    (worse, out): (&FirstOf<Standing>, &[&Standing]),
    dealt: &HashMap<u32, Markup>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let count: usize = OUT.map(|status| fleet.of_status[status as usize]).iter().sum();
    let above = worse.first.iter().filter(|one| one.status.is_some_and(|status| OUT.contains(&status))).count();
    let rows = violating(viewer, out.iter().copied(), worse.first.is_empty(), dealt, names);
    let all = (count > out.len() + above).then(|| (t.all_of_them, "/fleet".to_owned()));
    block(&html! { (t.still_out) }, count.saturating_sub(above), t.nothing_else_out, &rows, all)
}

/// Gyros with what they violate, one a line. `first`: whether they are the first of the page.
fn violating<'a>(
    viewer: &Viewer,
    gyros: impl Iterator<Item = &'a Standing>,
    first: bool,
    dealt: &HashMap<u32, Markup>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let ack = |serial: &str| format!("/alerts/bulk?gyro={}&back=%2F", encoded(serial));
    html! {
        div.scroll tabindex="0" { table.lines { tbody { @for (k, standing) in gyros.enumerate() {
            tr {
                td { (badges::badge(t, standing.status)) }
                (gyro(standing, first && k == 0, names))
                td.nowrap { (bullet::leading(t, standing, &standing.violations)) }
                td { (violated(t, &standing.violations)) }
                td.nowrap { @if let Some(at) = standing.since { span.quiet { (t.since) " " } (day(at)) } }
                td {
                    @if let Some(dealt) = dealt.get(&standing.number) { (dealt) }
                    @else if viewer.may(Role::Engineer) { a.no-print href=(ack(&standing.serial)) { (t.acknowledge) } }
                }
            }
        } } } }
    }
}

fn approaching(t: &Text, list: &FirstOf<Standing>, names: &Names<'_>) -> Markup {
    let of_reach = |coefficient: Coefficient| coefficient.column().unwrap_or_default();
    let rows = html! {
        div.scroll tabindex="0" { table.lines { tbody { @for standing in &list.first {
            @if let Some(reach) = standing.outlook.reach {
                tr {
                    td.nowrap { strong { (day(reach.at)) } @if reach.provisional { " ?" } }
                    (gyro(standing, false, names))
                    td.nowrap {
                        @let column = of_reach(reach.coefficient);
                        (bullet::of_coefficient(t, standing, column))
                    }
                    td.nowrap { (trend(t, &Standing { status: Some(Status::Confirmed), ..standing.clone() })) }
                    td.nowrap.quiet {
                        @let [early, late] = reach.between;
                        @if let Some(early) = early { (day(early)) } " … " @if let Some(late) = late { (day(late)) } @else { (t.never) }
                    }
                }
            }
        } } } }
        p.note { (t.reach_note) }
    };
    let address = || Filters { sort: "eta".into(), ..Filters::default() }.at_page(0);
    block(&html! { (t.will_cross) }, list.of, t.nothing_crosses, &rows, all_of(t, list, address))
}

fn due(t: &Text, today: &Today, gone: &HashMap<Arc<str>, Vec<Arc<str>>>, now: UtcMicros) -> Markup {
    let lines = |list: &FirstOf<DueImu>, is_over: bool| {
        html! {
            @for due in &list.first {
                tr {
                    td { @if is_over { (badges::badge(t, Some(Status::Overdue))) } @else { span.quiet { (t.due_word) } } }
                    th scope="row" { a.id href={ "/imus/" (encoded(&due.imu)) } { (due.imu) } }
                    td {
                        span.nowrap { (t.count_of_gyros(due.gyros)) }
                        @if let Some(gone) = gone.get(&due.imu).filter(|_| is_over) {
                            " · " (t.gyros_before) (t.colon)
                            @for serial in gone { " " a.id href={ "/gyros/" (encoded(serial)) } { (serial) } }
                        }
                    }
                    td.nowrap { (day(due.at)) " " span.quiet { (days_to(t, due.at, now)) } }
                }
            }
        }
    };
    let rows = html! {
        div.scroll tabindex="0" { table.lines { tbody { (lines(&today.overdue, true)) (lines(&today.due, false)) } } }
        @if today.due.of > today.due.first.len() { p.note { (t.due_more) " " (today.due.of) } }
    };
    let count = today.overdue.of + today.due.of;
    let address = || Filters { status: "overdue".into(), ..Filters::default() }.at_page(0);
    block(&html! { (t.overdue_and_due) }, count, t.nothing_due, &rows, all_of(t, &today.overdue, address))
}

fn days_to(t: &Text, at: UtcMicros, now: UtcMicros) -> Markup {
    let days = at.days_since(now);
    html! {
        @if days < 0.0 { (figure::whole_days(-days)) " " (t.days_ago) }
        @else { (t.in_days) " " (format!("{days:.0}")) " " (t.days_word) }
    }
}

/// Where gyros moved together: the station, or the file, before the gyros.
fn several(viewer: &Viewer, today: &Today, of_stations: &[&AlertBody]) -> Markup {
    let t = viewer.text();
    let rows = html! {
        @if !of_stations.is_empty() { (alerts::table(viewer, of_stations.iter().copied(), false, None)) }
        ul.findings {
            @for moved in &today.moved {
                li {
                    a.id href={ "/imus/" (encoded(&moved.imu)) } { (moved.imu) } " · "
                    a href={ "/records/" (moved.record) } { (day(moved.at)) } ": "
                    (t.all_moved_by) " " (format!("{:.0}", moved.least)) " " (t.budgets_or_more) " (" (t.count_of_gyros(moved.gyros)) "). "
                    strong { (t.wrong_file) }
                }
            }
            @for found in &today.shifts {
                li {
                    @match &found.of {
                        Together::Station(name) => a.id href={ "/stations/" (encoded(name)) } { (name) },
                        Together::Batch(name) => a.id href={ "/fleet?batch=" (encoded(name)) } { (t.batch) " " (name) },
                    }
                    ", "
                    (day(found.between[0])) " … " (day(found.between[1])) ": "
                    (symbol(DRIFTS[found.column])) ", " (t.count_of_gyros(found.shift.gyros)) ", " (t.median_word) " "
                    (bullet::percent(Measured { value: found.shift.median, sd: Some(found.shift.error) })) (t.share_of_budget_unit)
                }
            }
        }
        p.note { (t.several_note) }
    };
    let count = of_stations.len() + today.moved.len() + today.shifts.len();
    block(&html! { (t.several_at_once) }, count, t.nothing_together, &rows, None)
}

/// Campaigns of which something else was foretold.
fn outside(t: &Text, today: &Today) -> Markup {
    let rows = html! {
        div.scroll tabindex="0" { table.lines { tbody { @for found in &today.outside.first {
            tr {
                th scope="row" { a.id href={ "/imus/" (encoded(&found.imu)) "#forecasts" } { (found.imu) } }
                td.nowrap {
                    a href={ "/campaigns/" (found.campaign.campaign) "/diagnosis#forecast" } { (found.campaign.measured_at[..10]) }
                }
                td { (found.campaign.station) } td { (found.slot) }
                td.nowrap { (t.error_in_sd) " " (figure::short(found.rms_over_sd)) }
            }
        } } } }
        p.note { (t.outside_note) }
    };
    block(&html! { (t.outside_forecast_title) }, today.outside.of, "", &rows, None)
}
