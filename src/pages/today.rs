//! `/`: what there is to be done. Five blocks, and a sixth where a forecast failed, each with its first few lines and the
//! way to all of them.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

use axum::http::Uri;
use axum::response::Redirect;

use super::alerts::{self, done_to_alerts, is_open, open_ones};
use super::fleet::{Filters, as_day, bad_parameter, gyro, slopes, violated};
use super::layout::{day, written_day};
use super::prelude::*;
use super::station::changes;
use super::{bullet, status as badges, verdicts};
use crate::core::alert_decision;
use crate::core::alert_filter::AlertFilter;
use crate::core::changes::{FleetStations, Shared, StationFigures, Unlike};
use crate::core::first_of::{DueImu, FirstOf};
use crate::core::gyro_event::{GyroEvent, standing_decision};
use crate::core::message::text;
use crate::pipeline::{
    CommonFactor, CommonShift, DueDate, FleetFilter, FleetPage, GyroStatus, LINES, Names, Today, Violation, today,
};

/// Gyros that drift whose dates are asked for, beside those that their trends carry to the budget.
const DATED: usize = 12;
/// How long the page waits for the dates of gyros, and for the stations to be compared.
const PATIENCE: Duration = Duration::from_millis(400);
/// What is new, unless another day is asked for.
const DAYS: f64 = 7.0;
/// Parameters of the fleet, which stood here in earlier versions.
const OF_FLEET: [&str; 5] = ["q", "status", "state", "station", "page"];

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TodayQuery {
    /// A day, or a time.
    since: String,
    /// What has just been done, and to which alerts, parted by commas: that can be taken back.
    deed: String,
    done: String,
}

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    uri: Uri,
    Query(asked): Query<TodayQuery>,
) -> Result<Response, Problem> {
    let query = uri.query().unwrap_or_default();
    let is_of_fleet = |one: &str| OF_FLEET.contains(&one.split('=').next().unwrap_or_default());
    if query.split('&').any(is_of_fleet) {
        return Ok(Redirect::permanent(&format!("{}/fleet?{query}", viewer.base_path)).into_response());
    }
    Ok(build(pages, viewer, &asked).await?.into_response())
}

async fn build(pages: &Pages, viewer: &Viewer, asked: &TodayQuery) -> Result<Page, Problem> {
    let (t, now) = (viewer.text(), pages.clock.now());
    let since = match asked.since.trim() {
        "" => now.plus_days(-DAYS),
        said => time::parse_start(said).map_err(|fault| bad_parameter("since", fault))?,
    };
    let queries = &pages.pipeline.queries;
    let today = today(&queries.fleet, since).await?;
    let fleet = queries.fleet.page(&FleetFilter::default(), 0, LINES).await?;
    let hooks = pages.pipeline.hooks.disabled().await?;
    let shown = fleet.gyros.iter().chain(&today.worse.first);
    let known = known_of(pages, viewer, shown, since).await?;
    let stations = queries.fleet.station_figures_within(PATIENCE).await?;
    let unlike: Vec<(&str, &Unlike)> = (stations.iter().flat_map(|found| &found.stations))
        .flat_map(|station| station.unlike.iter().map(|one| (&*station.name, one)))
        .filter(|(_, one)| one.until.unwrap_or(now) >= since)
        .collect();
    let changed = stations.as_deref().map_or_else(Vec::new, |found| station_changes(found, since));
    let told = pages.pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
    let of_stations = {
        let (moving, names) = (moving(stations.as_deref(), &told, &changed), queries.names());
        let carried = |one: &GyroStatus| Some((one.number, carried_by(one, &moving, &names)?));
        today.approaching.first.iter().filter_map(carried).collect::<HashMap<u32, Arc<str>>>()
    };
    let drifting = queries.fleet.worst_of(&[Status::Drifting], DATED).await?;
    let is_new = |one: &&GyroStatus| drifting.iter().all(|known| known.number != one.number);
    let by_trend = today.approaching.first.iter().filter(|one| !of_stations.contains_key(&one.number)).take(LINES);
    let dated: Vec<GyroStatus> = drifting.iter().chain(by_trend.filter(is_new)).cloned().collect();
    let (dues, undated) = queries.dues.of(&dated, PATIENCE).await?;
    let undated = undated + fleet.of_status[Status::Drifting as usize].saturating_sub(drifting.len());
    let approaching = Approaching::of(&today.approaching, &dated, &dues, &of_stations);
    let gone = no_longer_in_it(pages, &today.overdue.first).await?;
    let names = queries.names();
    let out = still(&fleet, &today.worse);
    let is_of_group = |alert: &AlertBody| [AlertBody::OF_STATION, AlertBody::OF_BATCH].contains(&&*alert.subject);
    let of_groups: Vec<&AlertBody> = told.iter().filter(|alert| is_of_group(alert) && is_open(alert)).collect();
    let body = html! {
        @if !today.worse.first.is_empty() || !out.is_empty() { a.skip href="#first" { (t.skip_to_first) } }
        h1 { (t.today_title) }
        (done_to_alerts(viewer, &asked.deed, &asked.done, "/"))
        (Filters::default().tiles(t, &fleet))
        (disabled(viewer, &hooks))
        (misspelt(t, &today.misspelt))
        div.blocks {
            (worse(viewer, &today.worse, since, &known, &names))
            (still_out(viewer, &fleet, (&today.worse, &out), &known, &names))
            div {
                (several(viewer, &today, &of_groups, (&changed, &unlike), pages.config.judging.budget, &names))
                @if stations.is_none() && fleet.total > 0 { p.note { (t.stations_not_compared) } }
            }
            (approaching.shown(t, undated, now, &names))
            (due(t, &today, &gone, now, &names))
            @if today.outside.of > 0 { (outside(t, &today)) }
        }
    };
    Ok(Page { title: t.today_title.into(), section: Section::Today, body })
}

/// Hooks that the service has disabled: what fires is not told there.
fn disabled(viewer: &Viewer, hooks: &[(Id, String, Message)]) -> Markup {
    let t = viewer.text();
    html! {
        @for (id, name, why) in hooks {
            p.note {
                (badges::said(Some(Status::OutOfTolerance), t.disabled)) " " (t.hook) " "
                @if viewer.may(Role::Engineer) { a translate="no" href={ "/hooks/" (id) } { (name) } }
                @else { span translate="no" { (name) } }
                (t.colon) " " (t.words(why)) (t.stop) " " (t.hook_told_nothing)
            }
        }
    }
}

/// Gyros that may be known ones.
fn misspelt(t: &Text, found: &[[String; 2]]) -> Markup {
    html! {
        @for [name, known] in found {
            p.note {
                a.id href={ "/gyros/" (encoded(name)) } { (name) } (t.colon) " "
                (t.words(&message!("look_alike", of = "serial", name = text(name), known = text(known)))) (t.stop) " "
                (t.counted_apart)
            }
        }
    }
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

/// What the list of a gyro that is out or drifts tells beside how it stands.
#[derive(Default)]
struct Known {
    /// What was decided since it is as it is, or who knows of all that fires, where somebody does.
    dealt: Option<Markup>,
    /// What began since the day that is asked for, the gravest last, and of those the newest.
    new: Vec<(Violation, UtcMicros)>,
    /// When the last of what began before that day was found, where that is since: by a record that came late.
    late: Option<UtcMicros>,
}

async fn known_of(
    pages: &Pages,
    viewer: &Viewer,
    gyros: impl Iterator<Item = &GyroStatus>,
    day_asked: UtcMicros,
) -> Result<HashMap<u32, Known>, Problem> {
    let t = viewer.text();
    let mut all = HashMap::new();
    for GyroStatus { number, since, .. } in gyros {
        let events = pages.pipeline.queries.histories.events(*number).await?;
        let is_newer = |done: &&GyroEvent| since.is_none_or(|since| since <= done.at);
        let decision = standing_decision(events.iter().map(|(_, done)| done)).filter(is_newer);
        let alerts = open_ones(pages, *number).await?;
        let known: Option<Vec<_>> = alerts.iter().map(|alert| alert.acknowledged.as_ref()).collect();
        let said = match (decision, known.and_then(|known| known.into_iter().max_by_key(|known| known.at.clone()))) {
            (Some(decision), _) => Some((t.event(decision.event), decision.author.as_deref(), day(decision.at))),
            (None, Some(known)) => Some((t.alert_acknowledged, Some(&*known.by), written_day(&known.at))),
            (None, None) => None,
        };
        let dealt = said.map(|(what, who, at)| {
            let who = html! { @if let Some(who) = who { " · " span translate="no" { (who) } } };
            html! { span.quiet { (what) (who) " · " (at) } }
        });
        all.insert(
            *number,
            Known { dealt, new: began_since(&alerts, day_asked), late: found_late(&alerts, day_asked) },
        );
    }
    Ok(all)
}

/// What began no earlier than that, the gravest last, and of those the newest. Being overdue has a list of its own.
fn began_since(alerts: &[AlertBody], day_asked: UtcMicros) -> Vec<(Violation, UtcMicros)> {
    let of = |alert: &AlertBody| {
        let at = time::parse(alert.since.as_deref()?).ok()?;
        alerts::violation(alert).filter(|one| one.rule != Rule::Overdue && at >= day_asked).map(|one| (one, at))
    };
    let mut new: Vec<(Violation, UtcMicros)> = alerts.iter().filter_map(of).collect();
    new.sort_by_key(|(violation, at)| (violation.status, *at));
    new
}

/// When the last of what began before that day was found since; being overdue is found by the calendar.
fn found_late(alerts: &[AlertBody], day_asked: UtcMicros) -> Option<UtcMicros> {
    let late = alerts.iter().filter(|alert| alert.rule != Rule::Overdue.name()).filter_map(|alert| {
        let (began, found) = (time::parse(alert.since.as_deref()?).ok()?, time::parse(&alert.fired_at).ok()?);
        (began < day_asked && day_asked <= found).then_some(found)
    });
    late.max()
}

/// Overdue gyros whose place in the IMU another one has taken.
async fn no_longer_in_it(pages: &Pages, overdue: &[DueImu]) -> Result<HashMap<u32, Vec<Arc<str>>>, Problem> {
    let mut gone = HashMap::new();
    for DueImu { imu, .. } in overdue {
        let before = pages.pipeline.queries.fleet.seated_in(*imu).await?.before.into_iter();
        let late: Vec<Arc<str>> = before.filter(|one| one.overdue_days.is_some()).map(|one| one.serial).collect();
        if !late.is_empty() {
            gone.insert(*imu, late);
        }
    }
    Ok(gone)
}

/// The way to all, where there are more than are shown.
fn all_of<'a, T>(t: &'a Text, list: &FirstOf<T>, address: impl FnOnce() -> String) -> Option<(&'a str, String)> {
    (list.of > list.first.len()).then(|| (t.all_of_them, address()))
}

fn worse(
    viewer: &Viewer,
    list: &FirstOf<GyroStatus>,
    since: UtcMicros,
    known: &HashMap<u32, Known>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let from = as_day(since);
    let title = html! { (t.worse_since) " " (day(since)) };
    let new = |standing: &GyroStatus| known.get(&standing.number).map_or(&[][..], |known| &known.new);
    let rows = violating(viewer, list.first.iter().map(|one| (one, new(one))), true, known, names);
    let form = html! {
        form.search.no-print action="/" method="get" {
            label { (t.since_day) " " input type="date" name="since" value=(from); }
            button { (t.show_word) }
        }
    };
    let address = || Filters { changed_since: from.clone(), ..Filters::default() }.at_page(0);
    let shown = block(&title, list.of, t.nothing_worse, &rows, all_of(t, list, address));
    html! { div { (shown) (form) } }
}

const OUT: [Status; 4] = [Status::Drifting, Status::Unconfirmed, Status::OutOfTolerance, Status::Confirmed];

/// What is out of tolerance or drifting and has not changed since: the worst of the fleet, without those in `worse`.
fn still<'a>(fleet: &'a FleetPage, worse: &FirstOf<GyroStatus>) -> Vec<&'a GyroStatus> {
    let is_out = |standing: &&GyroStatus| {
        let is_above = worse.first.iter().any(|above| above.serial == standing.serial);
        standing.status.is_some_and(|status| OUT.contains(&status)) && !is_above
    };
    fleet.gyros.iter().filter(is_out).collect()
}

fn still_out(
    viewer: &Viewer,
    fleet: &FleetPage,
    (worse, out): (&FirstOf<GyroStatus>, &[&GyroStatus]),
    known: &HashMap<u32, Known>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let count: usize = OUT.map(|status| fleet.of_status[status as usize]).iter().sum();
    let above = worse.first.iter().filter(|one| one.status.is_some_and(|status| OUT.contains(&status))).count();
    let rows = violating(viewer, out.iter().map(|one| (*one, &[][..])), worse.first.is_empty(), known, names);
    let all = (count > out.len() + above).then(|| (t.all_of_them, "/fleet".to_owned()));
    block(&html! { (t.still_out) }, count.saturating_sub(above), t.nothing_else_out, &rows, all)
}

/// Gyros with what they violate, one a line: where some of it is new, with that and when it began. `first`: whether
/// they are the first of the page.
fn violating<'a>(
    viewer: &Viewer,
    gyros: impl Iterator<Item = (&'a GyroStatus, &'a [(Violation, UtcMicros)])>,
    first: bool,
    known: &HashMap<u32, Known>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let ack = |serial: &str| format!("/alerts/bulk?gyro={}&back=%2F", encoded(serial));
    html! {
        div.scroll tabindex="0" { table.lines { tbody { @for (k, (standing, new)) in gyros.enumerate() {
            @let (told, since) = match new.last() {
                Some((_, at)) => (new.iter().map(|(one, _)| *one).collect(), Some(*at)),
                None => (standing.violations.clone(), standing.since),
            };
            tr {
                td { (badges::badge(t, standing.status)) }
                (gyro(standing, first && k == 0, names))
                td.nowrap { (bullet::leading(t, standing, &of_same_coefficients(standing, &told))) }
                td { (violated(t, &told)) }
                @let late = known.get(&standing.number).and_then(|known| known.late).filter(|_| new.is_empty());
                td {
                    @if let Some(at) = since { span.nowrap { span.quiet { (t.since) " " } (day(at)) } }
                    @if let Some(found) = late { " " span.nowrap { span.quiet { (t.fired) " " } (day(found)) } }
                }
                td {
                    @if let Some(dealt) = known.get(&standing.number).and_then(|known| known.dealt.as_ref()) { (dealt) }
                    @else if viewer.may(Role::Engineer) { a.no-print href=(ack(&standing.serial)) { (t.acknowledge) } }
                }
            }
        } } } }
    }
}

/// All that is violated by the coefficients of some: by how much is told as on the page of alerts, whatever of it is new.
fn of_same_coefficients(standing: &GyroStatus, some: &[Violation]) -> Vec<Violation> {
    let is_same = |one: &&Violation| some.iter().any(|other| other.coefficient == one.coefficient);
    let all: Vec<Violation> = standing.violations.iter().filter(is_same).copied().collect();
    if all.is_empty() { some.to_vec() } else { all }
}

/// Gyros on their way to their budgets, and those that have reached them by their course and are not out of tolerance.
struct Approaching<'a> {
    /// The first to reach it first, and when.
    first: Vec<(&'a GyroStatus, DueDate)>,
    /// Those that their station carries there: how many of each, and when the first reaches it.
    of_stations: BTreeMap<Arc<str>, (usize, UtcMicros)>,
    of: usize,
    all: Option<String>,
}

impl<'a> Approaching<'a> {
    /// `by_trend`: what the rule `trend` carries there; `asked`: of which some have a date by their histories; `carried_by`
    /// which station others are.
    fn of(
        by_trend: &'a FirstOf<GyroStatus>,
        asked: &'a [GyroStatus],
        dues: &HashMap<u32, DueDate>,
        carried_by: &HashMap<u32, Arc<str>>,
    ) -> Self {
        let dated = asked.iter().filter_map(|standing| Some((standing, *dues.get(&standing.number)?)));
        let is_by_history = |(standing, _): &(&GyroStatus, _)| standing.projection.reach.is_none();
        let by_history_alone = dated.clone().filter(is_by_history).count();
        let others = by_trend.first.iter().filter(|standing| !dues.contains_key(&standing.number));
        let others = others.filter_map(|standing| Some((standing, DueDate::by_trend(standing)?)));
        let mut of_stations: BTreeMap<Arc<str>, (usize, UtcMicros)> = BTreeMap::new();
        let mut first: Vec<(&GyroStatus, DueDate)> = dated.collect();
        for (standing, due) in others {
            match carried_by.get(&standing.number) {
                Some(station) => {
                    let (gyros, at) = of_stations.entry(station.clone()).or_insert((0, due.at));
                    (*gyros, *at) = (*gyros + 1, due.at.min(*at));
                }
                None => first.push((standing, due)),
            }
        }
        first.sort_by_key(|(_, due)| due.at);
        first.truncate(LINES);
        let more = by_trend.of > LINES || !of_stations.is_empty();
        let all = more.then(|| Filters { sort: "eta".into(), ..Filters::default() }.at_page(0));
        Self { first, of_stations, of: by_trend.of + by_history_alone, all }
    }

    /// `undated`: how many gyros drift of which no date was asked for.
    fn shown(&self, t: &Text, undated: usize, now: UtcMicros, names: &Names<'_>) -> Markup {
        let rows = html! {
            div.scroll tabindex="0" { table.lines { tbody {
              @for (station, (gyros, at)) in &self.of_stations {
                tr {
                    td { strong.nowrap { (day(*at)) " ?" } @if *at < now { div.quiet { (t.reached_by_course) } } }
                    th scope="row" { a.id href={ "/stations/" (encoded(station)) } { (station) } }
                    td {} td {}
                    td { (t.words(&message!("gyros_check_station", gyros = *gyros))) }
                }
              }
              @for (standing, due) in &self.first {
                tr {
                    td {
                        strong.nowrap { (day(due.at)) @if due.provisional { " ?" } }
                        @if due.at < now { div.quiet { (t.reached_by_course) } }
                        @else { div.quiet {
                            @let [early, late] = due.between;
                            span.nowrap { @if let Some(early) = early { (day(early)) } " …" } " "
                            span.nowrap { @if let Some(late) = late { (day(late)) } @else { (t.never) } }
                        } }
                    }
                    (gyro(standing, false, names))
                    td.nowrap {
                        (bullet::of_coefficient(t, standing, due.coefficient.column().unwrap_or_default()))
                    }
                    td {
                        @if due.calibrate_by.is_some_and(|by| by < now) || due.at < now { (t.calibrate_now) }
                        @else if let Some(by) = due.calibrate_by { (t.calibrate_by) " " (day(by)) }
                        @else { (slopes(t, standing)) }
                    }
                }
            } } } }
            p.note { (t.reach_note) }
        };
        let others = html! {
            @if undated > 0 {
                p.note { (t.dates_of_others) " " a href="/fleet?status=drifting" { (t.count_of_gyros(undated)) } }
            }
        };
        let all = self.all.clone().map(|address| (t.all_of_them, address));
        let shown = block(&html! { (t.will_cross) }, self.of, t.nothing_crosses, &rows, all);
        html! { div { (shown) (others) } }
    }
}

/// What moves in the course of a station: the coefficient's column, and how fast or how far where that is known.
type Moving<'a> = (&'a str, usize, Option<f64>);

/// Stations that drift, have moved since the day that is asked for, or of which an alert says so.
fn moving<'a>(
    found: Option<&'a FleetStations>,
    told: &'a [AlertBody],
    changed: &[StationChange<'a>],
) -> Vec<Moving<'a>> {
    let of_station = |station: &'a StationFigures| {
        let drifting = station.columns.iter().enumerate().filter(|(_, figures)| figures.drifts);
        let drifts = drifting.map(|(column, figures)| (&*station.name, column, figures.drift.map(|drift| drift.value)));
        let is_off = station.unlike.last().is_some_and(|unlike| unlike.until.is_none());
        let unlike = [0, 1].map(|column| (&*station.name, column, None)).into_iter().filter(move |_| is_off);
        drifts.chain(unlike).collect::<Vec<Moving<'a>>>()
    };
    let told = told.iter().filter(|alert| alert.is_of_station() && is_open(alert)).filter_map(|alert| {
        let column = DRIFTS.iter().take(2).position(|name| *name == alert.coefficient)?;
        Some((alert.name(), column, None))
    });
    let changed = changed.iter().map(|one| (one.station, one.column, Some(one.size.value)));
    found.into_iter().flat_map(|found| &found.stations).flat_map(of_station).chain(told).chain(changed).collect()
}

/// The station that carries a gyro to its budget: where it was measured last, and moves to the side that the gyro does.
fn carried_by(standing: &GyroStatus, moving: &[Moving<'_>], names: &Names<'_>) -> Option<Arc<str>> {
    let column = standing.projection.reach?.coefficient.column()?;
    let station = names.station(standing.newest?.station);
    let slope = standing.projection.per_year.get(column).copied().flatten()?.value;
    let is_it = |(name, of, size): &&Moving<'_>| {
        *name == station && *of == column && size.is_none_or(|size| size * slope > 0.0)
    };
    moving.iter().find(is_it).map(|(name, ..)| Arc::from(*name))
}

fn due(t: &Text, today: &Today, gone: &HashMap<u32, Vec<Arc<str>>>, now: UtcMicros, names: &Names<'_>) -> Markup {
    let lines = |list: &FirstOf<DueImu>, is_over: bool| {
        html! {
            @for due in &list.first {
                tr {
                    td { @if is_over { (badges::badge(t, Some(Status::Overdue))) } @else { span.quiet { (t.due_word) } } }
                    @let gone = gone.get(&due.imu).filter(|_| is_over);
                    @let imu = names.imu(due.imu);
                    @let imu = html! { a.id href={ "/imus/" (encoded(imu)) } { (imu) } };
                    @let serials = html! {
                        @for serial in gone.into_iter().flatten() { a.id href={ "/gyros/" (encoded(serial)) } { (serial) } " " }
                    };
                    @if gone.is_some_and(|gone| gone.len() >= due.gyros) {
                        th scope="row" { (serials) }
                        td { (t.last_in) " " (imu) }
                    } @else {
                        th scope="row" { (imu) }
                        td {
                            span.nowrap { (t.count_of_gyros(due.gyros)) }
                            @if gone.is_some() { " · " (t.gyros_before) (t.colon) (serials) }
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

/// A step of a station, or a window in which it was off.
struct StationChange<'a> {
    station: &'a str,
    /// 0: D_I, 1: D_S.
    column: usize,
    from: UtcMicros,
    until: Option<UtcMicros>,
    size: &'a Shared,
}

/// What the stations did since an instant, the newest first: steps since then, and windows that reach into that time.
fn station_changes(found: &FleetStations, since: UtcMicros) -> Vec<StationChange<'_>> {
    let columns =
        found.stations.iter().flat_map(|station| station.columns.iter().enumerate().map(move |of| (station, of)));
    let all = columns.flat_map(|(station, (column, figures))| {
        let change = move |(from, until, size)| StationChange { station: &station.name, column, from, until, size };
        changes(figures).into_iter().map(change)
    });
    let mut recent: Vec<StationChange<'_>> = all.filter(|one| one.until.unwrap_or(one.from) >= since).collect();
    recent.sort_by_key(|one| std::cmp::Reverse(one.from));
    recent
}

/// Where gyros moved together: the station, or the file, before the gyros. What a change of a station says already, its
/// newest records need not say again.
fn several(
    viewer: &Viewer,
    today: &Today,
    of_groups: &[&AlertBody],
    (changed, unlike): (&[StationChange<'_>], &[(&str, &Unlike)]),
    budget: f64,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    let is_of = |one: &StationChange<'_>, found: &CommonShift| {
        one.column == found.column && matches!(&found.of, CommonFactor::Station(name) if **name == *one.station)
    };
    // What only the newest records show is told by these.
    let is_new = |one: &&StationChange<'_>| today.shifts.iter().any(|s| is_of(one, s) && s.between[0] <= one.from);
    let changed: Vec<&StationChange<'_>> = changed.iter().filter(|one| !is_new(one)).collect();
    // What is over says nothing of the newest records.
    let is_told = |found: &&CommonShift| {
        changed.iter().any(|one| is_of(one, found) && one.until.is_none_or(|until| until > found.between[1]))
    };
    let shifts: Vec<&CommonShift> = today.shifts.iter().filter(|found| !is_told(found)).collect();
    let rows = html! {
        ul.findings {
            @for alert in of_groups {
                li {
                    (badges::badge(t, alert.status())) " "
                    a.id href=(alert.page()) {
                        @if alert.subject == AlertBody::OF_BATCH { (t.batch) " " }
                        (alert.name())
                    } ", "
                    a href={ "/alerts/" (alert.id) } { (verdicts::violated(t, alert)) }
                    @if let Some(since) = &alert.since { " " (t.since_then) " " (written_day(since)) }
                    @if alert.state != alert_decision::AlertState::Firing.name() { ", " (t.standing(&alert.state)) }
                    (t.colon) " " (t.reason(&alert.finding.reason))
                }
            }
            @for moved in &today.moved {
                @let imu = names.imu(moved.imu);
                li {
                    a.id href={ "/imus/" (encoded(imu)) } { (imu) } " · "
                    a href={ "/records/" (moved.record) } { (day(moved.at)) } ": "
                    (t.all_moved_by) " " (format!("{:.0}", moved.least)) " " (t.budgets_or_more) " (" (t.count_of_gyros(moved.gyros)) "). "
                    strong { (t.wrong_file) }
                }
            }
            @for (station, unlike) in unlike {
                li { a.id href={ "/stations/" (encoded(station)) } { (station) } (t.colon) " " (t.words(&unlike.message())) }
            }
            @for StationChange { station, column, from, until, size } in &changed {
                li {
                    a.id href={ "/stations/" (encoded(station)) "#" (DRIFTS[*column]) } { (station) } ", "
                    @match until {
                        Some(until) => { (day(*from)) " … " (day(*until)) }
                        None => { (t.since_then) " " (day(*from)) }
                    }
                    ": " (symbol(DRIFTS[*column])) " "
                    (bullet::percent(Measured { value: size.value, sd: Some(size.sd) }.in_units_of(budget))) (t.share_of_budget_unit)
                    ", " (t.words(&message!("gyros_of_imus", gyros = size.gyros, imus = size.imus)))
                }
            }
            @for found in &shifts {
                li {
                    @match &found.of {
                        CommonFactor::Station(name) => a.id href={ "/stations/" (encoded(name)) } { (name) },
                        CommonFactor::Batch(name) => a.id href={ "/fleet?batch=" (encoded(name)) } { (t.batch) " " (name) },
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
    let count = of_groups.len() + today.moved.len() + unlike.len() + changed.len() + shifts.len();
    block(&html! { (t.several_at_once) }, count, t.nothing_together, &rows, None)
}

/// Campaigns of which something else was foretold.
fn outside(t: &Text, today: &Today) -> Markup {
    let rows = html! {
        div.scroll tabindex="0" { table.lines { tbody { @for found in &today.outside.first { tr {
            th scope="row" { a.id href={ "/imus/" (encoded(&found.imu)) "#forecasts" } { (found.imu) } }
            td.nowrap {
                a href={ "/campaigns/" (found.campaign.campaign) "/diagnosis#forecast" } { (found.campaign.measured_at[..10]) }
            }
            td { (found.campaign.station) } td { (found.slot) }
            td.nowrap { (t.error_in_sd) " " (figure::short(found.rms_over_sd)) }
        } } } } }
        p.note { (t.outside_note) }
    };
    block(&html! { (t.outside_forecast_title) }, today.outside.of, "", &rows, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{BudgetCrossing, BudgetProjection, Coefficient};

    /// A gyro that a trend carries to its budget on a day.
    fn carried(number: u32, reaches: i64) -> GyroStatus {
        let at = UtcMicros(reaches * UtcMicros::DAY);
        let reach = BudgetCrossing { coefficient: Coefficient::DI, at, between: [None; 2], provisional: false };
        GyroStatus::made_for_tests(number, BudgetProjection { reach: Some(reach), ..BudgetProjection::default() })
    }

    #[test]
    fn what_a_station_carries_to_the_budget_is_one_line_but_for_what_ages_by_itself() {
        let first: Vec<GyroStatus> = (0..20).map(|number| carried(number, 100 + i64::from(number))).collect();
        let by_trend = FirstOf { of: 20, first };
        let of_station: HashMap<u32, Arc<str>> = (0..18).map(|number| (number, Arc::from("ST-3"))).collect();
        let own = DueDate { provisional: false, ..DueDate::by_trend(&by_trend.first[4]).expect("a trend") };
        let asked = [by_trend.first[4].clone()];
        let found = Approaching::of(&by_trend, &asked, &HashMap::from([(4, own)]), &of_station);
        let day = UtcMicros(100 * UtcMicros::DAY);
        assert_eq!(found.of_stations, BTreeMap::from([(Arc::from("ST-3"), (17, day))]));
        assert_eq!(found.first.iter().map(|(gyro, _)| gyro.number).collect::<Vec<_>>(), [4, 18, 19]);
        assert!(found.of == 20 && found.all.is_some());
    }

    #[test]
    fn by_how_much_is_told_of_all_that_a_coefficient_violates_whatever_of_it_is_new() {
        let of = |coefficient, rule, status| Violation { coefficient, rule, status, load: Some(1.2) };
        let old = of(Coefficient::DI, Rule::Baseline, Status::Unconfirmed);
        let new = of(Coefficient::DI, Rule::RmsSuccessive, Status::Drifting);
        let other = of(Coefficient::DS, Rule::Trend, Status::Drifting);
        let standing = GyroStatus { violations: vec![old, new, other], ..carried(1, 100) };
        assert_eq!(of_same_coefficients(&standing, &[new]), [old, new]);
        let gone = of(Coefficient::DO, Rule::Closure, Status::Drifting);
        assert_eq!(of_same_coefficients(&standing, &[gone]), [gone], "what fires yet and is no more");
    }

    #[test]
    fn a_window_is_told_while_it_reaches_into_the_time_that_is_asked_for_and_a_step_since_it_came() {
        let day = |day: i64| UtcMicros(day * UtcMicros::DAY);
        let size = Shared { value: 0.0038, sd: 0.0002, gyros: 18, imus: 6, ..Shared::default() };
        let mut figures = StationFigures {
            name: "ST-2".into(),
            records: 200,
            gyros: 23,
            imus: 9,
            first: day(0),
            last: day(100),
            against: None,
            unlike: Vec::new(),
            columns: Default::default(),
        };
        figures.columns[0].windows = vec![([day(10), day(20)], size), ([day(40), day(60)], size)];
        figures.columns[1].steps = vec![(day(30), size), (day(70), size)];
        let found = FleetStations { stations: vec![figures], against: "ST-1".into(), reproducibility: [None; 2] };
        let told = |since: i64| -> Vec<(usize, UtcMicros)> {
            station_changes(&found, day(since)).iter().map(|one| (one.column, one.from)).collect()
        };
        assert_eq!(told(50), [(1, day(70)), (0, day(40))], "the newest first");
        assert_eq!(told(61), [(1, day(70))]);
        assert_eq!(told(0).len(), 4);
        assert_eq!(told(71), []);
    }
}
