//! `/alerts`: what fires, what has fired, a gyro on a line; and what people say of it.

mod bulk;
mod one;
mod table;

use std::collections::HashMap;

use super::form::{ActionForm, Word, choice, rule_choice, see_other};
use super::layout::{query, written_day};
use super::prelude::*;
use super::silences::{days_field, silent_until};
use super::verdicts::violated;
use super::{bullet, fleet, silences, status};
use crate::core::alert_decision::AlertState;
use crate::core::alert_filter::AlertFilter;
use crate::core::judge::{Coefficient, Severity};
use crate::core::named::{Named, named};
use crate::pipeline::{self, AlertChange, AlertOrder, BEYOND, Violation};
use crate::wire::problem::not_one_of;
use table::known;

/// Whatever the standing.
const ALL: &str = "all";
/// Gyros on one page.
const ROWS: usize = 30;
/// Gyros of an IMU with one cause: of one record more likely the file or the station than each of them; overdue, one
/// job for a station.
const TOGETHER: usize = 3;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Filters {
    /// A standing by its name, or `all`; what fires, where it is left out.
    state: String,
    serial: String,
    rule: String,
    severity: String,
    page: usize,
    /// What has just been done, and to which alerts, parted by commas: that can be taken back.
    deed: String,
    done: String,
}

impl Filters {
    fn state(&self) -> &str {
        if self.state.is_empty() { "firing" } else { &self.state }
    }

    /// None for all.
    fn standing(&self) -> Result<Option<AlertState>, Problem> {
        let (known, state) = (AlertState::NAMES.iter().copied().chain([ALL]), self.state());
        match AlertState::from_name(state) {
            None if state != ALL => Err(not_one_of("state", known, state)),
            found => Ok(found),
        }
    }

    fn address(&self, state: &str, page: usize) -> String {
        let page = if page > 0 { page.to_string() } else { String::new() };
        let all = [
            ("state", state),
            ("serial", self.serial.trim()),
            ("rule", &self.rule),
            ("severity", &self.severity),
            ("page", &page),
        ];
        format!("/alerts?{}", query(all))
    }
}

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Query(ref filters): Query<Filters>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let serial = filters.serial.trim();
    let gyro = pages.pipeline.queries.names().gyro_number(serial);
    let any = AlertFilter {
        gyro,
        rule: fleet::named("rule", &filters.rule)?,
        severity: fleet::named("severity", &filters.severity)?,
        ..AlertFilter::default()
    };
    let nobody = gyro.is_none() && !serial.is_empty();
    let pipeline = &pages.pipeline.alerts;
    let counts = if nobody { HashMap::new() } else { pipeline.counts_by_state(&any).await? };
    let of = |standing: AlertState| counts.get(&standing).copied().unwrap_or(0);
    let wanted = filters.standing()?;
    let filter = AlertFilter { standing: wanted, ..any };
    let above = filters.page.saturating_mul(ROWS);
    let mut found = if nobody { Vec::new() } else { pipeline.by_gyro(&filter, above, ROWS + 1).await? };
    let of_no_gyro = if filters.page > 0 || nobody { Vec::new() } else { pipeline.of_no_gyro(&filter).await? };
    let of_subject = |subject: &str| of_no_gyro.iter().filter(|alert| alert.subject == subject).collect::<Vec<_>>();
    let [stations, batches, imus] = [AlertBody::OF_STATION, AlertBody::OF_BATCH, AlertBody::OF_IMU].map(of_subject);
    let more = found.len() > ROWS;
    found.truncate(ROWS);
    let groups = together(standing_with_alerts(pages, found).await?);
    let silences = silences::list(pages, viewer).await?;
    let here = filters.address(filters.state(), filters.page);
    let all: usize = AlertState::ALL.iter().map(|standing| of(*standing)).sum();
    let tabs = AlertState::ALL.map(|standing| (standing.name(), t.standing(standing.name()), of(standing)));
    let tabs = tabs.into_iter().chain([(ALL, t.alert_all, all)]);
    let may = viewer.may(Role::Engineer) && wanted != Some(AlertState::Resolved);
    let body = html! {
        @if !groups.is_empty() { a.skip href="#first" { (t.skip_to_first) } }
        h1 { (t.alerts) }
        (bulk::done(viewer, &filters.deed, &filters.done, &here))
        nav.tabs aria-label=(t.handling) {
            @for (name, word, count) in tabs {
                a href=(filters.address(name, 0)) aria-current=[(name == filters.state()).then_some("true")] {
                    (word) " " span.count { (count) }
                }
            }
        }
        (search(t, filters))
        p.note { (t.alerts_note) }
        @for (word, alerts) in [(t.stations_alerts, &stations), (t.batches_alerts, &batches), (t.imus_alerts, &imus)] {
            @if !alerts.is_empty() {
                section.together {
                    h2 { (word) }
                    (table(viewer, alerts.iter().copied(), true, may.then_some(here.as_str())))
                }
            }
        }
        @if groups.is_empty() { @if of_no_gyro.is_empty() { p.lead { (t.no_alerts) } } }
        @else {
            @for (k, group) in groups.iter().enumerate() { (group.shown(viewer, k == 0, may, &here)) }
            @if may { (bulk::bar(viewer, &here)) }
        }
        @if more || filters.page > 0 {
            p.on-paper { (t.printed_part) " " (filters.page + 1) @if more { " …" } }
            nav.pager aria-label=(t.alerts) {
                @if filters.page > 0 { a rel="prev" href=(filters.address(filters.state(), filters.page - 1)) { (t.previous) } }
                @if more { a rel="next" href=(filters.address(filters.state(), filters.page + 1)) { (t.next) } }
            }
        }
        (silences)
    };
    Ok(Page { title: t.alerts.into(), section: Section::Alerts, body })
}

fn search(t: &Text, filters: &Filters) -> Markup {
    html! {
        form.search role="search" action="/alerts" method="get" {
            input type="hidden" name="state" value=(filters.state());
            input type="search" name="serial" value=(filters.serial) placeholder=(t.serial) aria-label=(t.serial);
            (rule_choice(t, &filters.rule))
            (choice(t, t.is_confirmed, "severity", [(Severity::Critical.name(), t.yes), (Severity::Warning.name(), t.no)], &filters.severity))
            button { (t.search) }
        }
    }
}

/// A gyro and its alerts.
struct Alerted {
    /// None for one that has just been removed.
    standing: Option<pipeline::GyroStatus>,
    alerts: Vec<AlertBody>,
}

async fn standing_with_alerts(pages: &Pages, found: Vec<(u32, Vec<AlertBody>)>) -> Result<Vec<Alerted>, Problem> {
    let gyros: Vec<u32> = found.iter().map(|(gyro, _)| *gyro).collect();
    let mut standings = pages.pipeline.queries.fleet.standings_of(&gyros).await?.into_iter().peekable();
    let with_standing = |(gyro, alerts)| Alerted { standing: standings.next_if(|one| one.number == gyro), alerts };
    Ok(found.into_iter().map(with_standing).collect())
}

/// Gyros whose alerts stand together: one, or those of an IMU that one record has shown.
struct Group {
    /// Where there are several.
    imu: Option<String>,
    /// Whether none of them has been calibrated in time.
    overdue: bool,
    gyros: Vec<Alerted>,
}

/// What gyros have in common that fire together.
#[derive(Debug, Clone, PartialEq)]
enum Cause {
    /// And since when it is so: what began with an earlier record is not what this one has shown.
    Record(String, Option<String>),
    /// No record of this IMU.
    Overdue(String),
}

impl Cause {
    fn of(alerts: &[AlertBody]) -> Option<Self> {
        let first = alerts.first()?;
        if first.rule == Rule::Overdue.name() {
            return first.finding.imu.clone().map(Self::Overdue);
        }
        first.finding.record.clone().map(|record| Self::Record(record, since(alerts).map(str::to_owned)))
    }
}

/// Gyros of one cause stand together where there are [`TOGETHER`] of them, where the first of them does.
fn together(found: Vec<Alerted>) -> Vec<Group> {
    let causes: Vec<Option<Cause>> = found.iter().map(|gyro| Cause::of(&gyro.alerts)).collect();
    let is_common = |cause: &&Cause| causes.iter().flatten().filter(|one| one == cause).count() >= TOGETHER;
    let mut groups: Vec<(Option<&Cause>, Group)> = Vec::new();
    for (gyro, cause) in found.into_iter().zip(&causes) {
        let cause = cause.as_ref().filter(is_common);
        match groups.iter_mut().find(|(of, _)| cause.is_some() && *of == cause) {
            Some((_, group)) => group.gyros.push(gyro),
            None => {
                let imu = gyro.alerts.first().and_then(|alert| alert.finding.imu.clone()).filter(|_| cause.is_some());
                let overdue = matches!(cause, Some(Cause::Overdue(_)));
                groups.push((cause, Group { imu, overdue, gyros: vec![gyro] }));
            }
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

impl Group {
    /// `first`: whether it is the first of the page, which the keyboard skips to.
    fn shown(&self, viewer: &Viewer, first: bool, may: bool, here: &str) -> Markup {
        let t = viewer.text();
        let gyros = html! { @for (k, gyro) in self.gyros.iter().enumerate() { (of_gyro(viewer, gyro, first && k == 0, may, here)) } };
        html! {
            @if let Some(imu) = &self.imu {
                section.together {
                    h2 {
                        a.id href={ "/imus/" (encoded(imu)) } { (imu) } " "
                        span.note {
                            @if self.overdue { (t.count_of_gyros(self.gyros.len())) " · " (t.status(Status::Overdue)) }
                            @else { (self.gyros.len()) " " (t.gyros_of_one_record) }
                        }
                    }
                    (gyros)
                }
            } @else { (gyros) }
        }
    }
}

/// As the fleet says it: of what is beyond a specification where something is.
fn since(alerts: &[AlertBody]) -> Option<&str> {
    let is_beyond = |alert: &AlertBody| alert.status().is_some_and(|status| BEYOND.contains(&status));
    let has_worse = alerts.iter().any(is_beyond);
    let of_worst = alerts.iter().filter(|alert| !has_worse || is_beyond(alert));
    of_worst.filter_map(|alert| alert.since.as_deref()).min()
}

/// A gyro on one line, what it is told of folded under it.
fn of_gyro(viewer: &Viewer, gyro: &Alerted, first_of_page: bool, may: bool, here: &str) -> Markup {
    let t = viewer.text();
    let Alerted { standing, alerts } = gyro;
    let Some(first) = alerts.first() else { return html! {} };
    let (serial, finding) = (&first.serial, &first.finding);
    // What another alert explains is in another list, and as bad.
    let stands = standing.as_ref().filter(|_| alerts.iter().any(is_open)).and_then(|standing| standing.status);
    let worst = alerts.iter().filter_map(|alert| alert.status()).max().max(stands);
    let open: Vec<Violation> = alerts.iter().filter(|alert| is_open(alert)).filter_map(violation).collect();
    let is_known = |alert: &AlertBody| alert.state != AlertState::Firing.name();
    html! {
        article.alerted {
            header {
                @if may { input type="checkbox" name="gyro" value=(serial) form="bulk" aria-label=(serial); }
                (status::badge(t, worst))
                strong { a.id id=[first_of_page.then_some("first")] href={ "/gyros/" (encoded(serial)) } { (serial) } }
                @if let Some(imu) = &finding.imu {
                    span { a.id href={ "/imus/" (encoded(imu)) } { (imu) } @if let Some(slot) = &finding.slot { " " span.quiet { (slot) } } }
                }
                @if let Some(standing) = standing { span.nowrap { (bullet::leading(t, standing, &open)) } }
                @if let Some(since) = since(alerts) { span.quiet { (t.since) " " (written_day(since)) } }
                @if may && !alerts.iter().all(is_known) { (bulk::acknowledge(viewer, serial, here)) }
            }
            details {
                summary { @for alert in alerts { span.violated { (violated(t, alert)) } " " } }
                (table(viewer, alerts.iter(), false, may.then_some(here)))
                @if let Some(at) = finding.record.as_ref().and(finding.calibrated_at.as_ref()) {
                    p.note { (t.calibrated) " " (written(at)) @if let Some(station) = &finding.station { " · " span.id { (station) } } }
                }
            }
        }
    }
}

pub(super) fn is_open_of(alert: &AlertBody, station: &str) -> bool {
    alert.is_of_station() && alert.name() == station && is_open(alert)
}

/// None where it names what this version does not know.
pub(super) fn violation(alert: &AlertBody) -> Option<Violation> {
    Some(Violation {
        coefficient: Coefficient::from_name(&alert.coefficient)?,
        rule: Rule::from_name(&alert.rule)?,
        status: alert.status()?,
        load: alert.finding.value.map(|value| value / alert.finding.limit),
    })
}

pub(super) use bulk::{act as act_bulk, ask as ask_bulk, done as done_to_alerts};
pub(super) use one::page as one;
pub(super) use table::{is_open, open_ones, open_ones_of_imu, table};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct AlertForm {
    #[serde(flatten)]
    word: Word,
    /// How long a silence lasts.
    days: String,
}

named! {
    /// What can be done about an alert.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum AlertAction {
        Acknowledge = "acknowledge",
        Unacknowledge = "unacknowledge",
        Silence = "silence",
        Unsilence = "unsilence",
    }
}

impl AlertAction {
    /// By its name in the address.
    fn of(deed: &str) -> Result<Self, Problem> {
        let unknown =
            || Problem::new(404, "title_no_such_page", message!("not_done_to_alerts", action = deed.to_owned()));
        Self::from_name(deed).ok_or_else(unknown)
    }
}

/// The page on which something is done about an alert.
pub(super) async fn ask(
    PageContext(ref pages, ref viewer): PageContext,
    Path((ref id, ref deed)): Path<(String, String)>,
    Query(word): Query<Word>,
) -> Result<Page, Problem> {
    let action = AlertAction::of(deed)?;
    let (_, alert) = known(pages, id).await?;
    let said = AlertForm { word, ..AlertForm::default() };
    Ok(form(viewer, &alert, action, &said).fresh(viewer, &said.word))
}

pub(super) async fn act(
    PageContext(ref pages, ref viewer): PageContext,
    Path((ref id, ref deed)): Path<(String, String)>,
    Form(ref said): Form<AlertForm>,
) -> Result<Response, Problem> {
    let action = AlertAction::of(deed)?;
    let (number, alert) = known(pages, id).await?;
    let mut faults = Faults::default();
    said.word.check(&mut faults);
    let change = match action {
        AlertAction::Acknowledge => AlertChange::Acknowledge,
        AlertAction::Unacknowledge => AlertChange::Unacknowledge,
        AlertAction::Silence => AlertChange::Silence { until: silent_until(pages, &said.days, &mut faults) },
        AlertAction::Unsilence => AlertChange::Unsilence,
    };
    if !faults.is_empty() {
        return Ok(form(viewer, &alert, action, said).again(viewer, &said.word, &faults));
    }
    let Word { by, reason, .. } = said.word.clone();
    pages.pipeline.alerts.change(AlertOrder { alert: number, change, by, reason }).await?;
    Ok(see_other(said.word.back_or("/alerts")))
}

fn form(viewer: &Viewer, alert: &AlertBody, action: AlertAction, said: &AlertForm) -> ActionForm {
    let t = viewer.text();
    let (title, does, button) = match action {
        AlertAction::Acknowledge => (t.acknowledge_title, t.acknowledge_what, t.acknowledge),
        AlertAction::Unacknowledge => (t.unacknowledge_title, t.unacknowledge_what, t.unacknowledge),
        AlertAction::Silence => (t.silence_title, t.silence_what, t.silence),
        AlertAction::Unsilence => (t.unsilence_title, t.end_silence_what, t.unsilence),
    };
    let what = html! { (table(viewer, std::iter::once(alert), true, None)) p.lead { (does) } };
    let fields = html! { @if action == AlertAction::Silence { (days_field(t, &said.days, true)) } };
    ActionForm {
        section: Section::Alerts,
        title: title.into(),
        what,
        fields,
        action: format!("/alerts/{}/{}", alert.id, action.name()),
        button,
        back: said.word.back_or("/alerts").to_owned(),
        ..ActionForm::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_standing_is_refused_and_all_is_none() {
        let of =
            |state: &str| Filters { state: state.into(), ..Filters::default() }.standing().map_err(|why| why.status);
        assert_eq!(of(""), Ok(Some(AlertState::Firing)));
        assert_eq!(of("resolved"), Ok(Some(AlertState::Resolved)));
        assert_eq!(of("all"), Ok(None));
        assert_eq!(of("foo"), Err(400));
    }
}
