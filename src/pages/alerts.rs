//! `/alerts`: what fires, what has fired; and what people say of it, each on a page of its own.

use axum::Form;
use axum::extract::{Path, Query, State as Held};
use axum::response::Response;
use maud::{Markup, html};
use serde::Deserialize;

use super::Pages;
use super::form::{Deed, Word, answered, see_other};
use super::layout::{Page, Section, encoded, remark, symbol, written};
use super::silences;
use super::silences::LONGEST_SILENCE;
use super::text::Text;
use super::viewer::Viewer;
use crate::core::access::Role;
use crate::core::alert_decision::Standing;
use crate::core::alert_filter::AlertFilter;
use crate::core::fault::Faults;
use crate::core::id::Id;
use crate::core::judge::{Rule, Severity, Status};
use crate::core::message::Message;
use crate::message;
use crate::pages::status;
use crate::pipeline::{AlertChange, AlertOrder};
use crate::wire::alert::AlertBody;
use crate::wire::problem::Problem;

/// Alerts on one page.
const ROWS: usize = 60;
/// Alerts of one gyro, one for each coefficient and rule: never more than so many.
const MOST_OF_A_GYRO: u32 = 200;
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Filters {
    /// A standing by its name, or `all`; what fires, where it is left out.
    state: String,
    serial: String,
    rule: String,
    severity: String,
    /// Only older ones than this.
    before: String,
}

impl Filters {
    fn state(&self) -> &str {
        if self.state.is_empty() { "firing" } else { &self.state }
    }

    fn address(&self, state: &str, before: &str) -> String {
        let all = [
            ("state", state),
            ("serial", self.serial.trim()),
            ("rule", &self.rule),
            ("severity", &self.severity),
            ("before", before),
        ];
        let given = all.iter().filter(|(_, value)| !value.is_empty());
        let query: Vec<String> = given.map(|(key, value)| format!("{key}={}", encoded(value))).collect();
        format!("/alerts?{}", query.join("&"))
    }
}

pub(super) async fn page(Held(pages): Held<Pages>, viewer: Viewer, Query(filters): Query<Filters>) -> Response {
    viewer.show(build(&pages, &viewer, &filters).await)
}

async fn build(pages: &Pages, viewer: &Viewer, filters: &Filters) -> Result<Page, Problem> {
    let t = viewer.text();
    let serial = filters.serial.trim();
    let gyro = pages.pipeline.queries.names().gyro_number(serial);
    let filter = AlertFilter {
        standing: Standing::from_name(filters.state()),
        gyro,
        rule: Rule::from_name(&filters.rule),
        severity: Severity::from_name(&filters.severity),
        ..AlertFilter::default()
    };
    let nobody = gyro.is_none() && !serial.is_empty();
    let before = filters.before.parse::<Id>().ok();
    let mut found =
        if nobody { Vec::new() } else { pages.pipeline.alerts.find(&filter, before, ROWS as u32 + 1).await? };
    let more = found.len() > ROWS;
    found.truncate(ROWS);
    let silences = silences::list(pages, viewer).await?;
    let body = html! {
        h1 { (t.alerts) }
        nav.tabs aria-label=(t.state) {
            @for name in Standing::ALL.map(Standing::name) {
                a href=(filters.address(name, "")) aria-current=[(name == filters.state()).then_some("true")] { (t.standing(name)) }
            }
            a href=(filters.address("all", "")) aria-current=[(filters.state() == "all").then_some("true")] { (t.alert_all) }
        }
        (search(viewer, filters))
        p.note { (t.alerts_note) }
        @if found.is_empty() { p.lead { (t.no_alerts) } }
        @else { (by_gyro_and_record(viewer, found.iter().map(|(_, alert)| alert))) }
        @if more && let Some((last, _)) = found.last() {
            nav.pager aria-label=(t.alerts) { a rel="next" href=(filters.address(filters.state(), &last.to_string())) { (t.older) } }
        }
        (silences)
    };
    Ok(Page { title: t.alerts.into(), section: Section::Alerts, body })
}

fn search(viewer: &Viewer, filters: &Filters) -> Markup {
    let t = viewer.text();
    html! {
        form.search role="search" action="/alerts" method="get" {
            input type="hidden" name="state" value=(filters.state());
            input type="search" name="serial" value=(filters.serial) placeholder=(t.serial) aria-label=(t.serial);
            label { (t.rule_word) " " select name="rule" {
                option value="" { (t.any) }
                @for rule in Rule::ALL { option value=(rule.name()) selected[rule.name() == filters.rule] { (t.rule(rule)) } }
            } }
            label { (t.severity) " " select name="severity" {
                option value="" { (t.any) }
                @for one in Severity::ALL { option value=(one.name()) selected[one.name() == filters.severity] { (t.severity(one)) } }
            } }
            button { (t.search) }
        }
    }
}

/// Alerts of a gyro that are not resolved, critical ones first, then the newest.
pub(super) async fn open_ones(pages: &Pages, gyro: u32) -> Result<Vec<AlertBody>, Problem> {
    let filter = AlertFilter { gyro: Some(gyro), ..AlertFilter::default() };
    let found = pages.pipeline.alerts.find(&filter, None, MOST_OF_A_GYRO).await?;
    let resolved = Standing::Resolved.name();
    let mut open: Vec<AlertBody> =
        found.into_iter().map(|(_, alert)| alert).filter(|alert| alert.state != resolved).collect();
    open.sort_by_key(|alert| alert.severity != Severity::Critical.name());
    Ok(open)
}

/// Alerts that stand together: of one gyro, and among those of one record. Gyros and their records come in the order
/// in which their first alerts do.
fn groups<'a>(alerts: impl Iterator<Item = &'a AlertBody>) -> Vec<Vec<&'a AlertBody>> {
    let mut gyros: Vec<(&str, Vec<Vec<&AlertBody>>)> = Vec::new();
    for alert in alerts {
        let place = gyros.iter().position(|(serial, _)| *serial == alert.serial).unwrap_or_else(|| {
            gyros.push((&alert.serial, Vec::new()));
            gyros.len() - 1
        });
        let records = &mut gyros[place].1;
        match records.iter_mut().find(|group| group[0].finding.record == alert.finding.record) {
            Some(group) => group.push(alert),
            None => records.push(vec![alert]),
        }
    }
    gyros.into_iter().flat_map(|(_, records)| records).collect()
}

fn by_gyro_and_record<'a>(viewer: &Viewer, alerts: impl Iterator<Item = &'a AlertBody>) -> Markup {
    html! {
        div.scroll tabindex="0" { table.alerts {
            (heading(viewer, false))
            @for group in groups(alerts) {
                tbody {
                    tr.group { th.words scope="rowgroup" colspan="6" { (group_heading(viewer, &group)) } }
                    @for alert in group { (line(viewer, alert, false, Some(&viewer.here))) }
                }
            }
        } }
    }
}

/// The gyro, what it violates, and the record that shows it.
fn group_heading(viewer: &Viewer, group: &[&AlertBody]) -> Markup {
    let t = viewer.text();
    let (serial, finding) = (&group[0].serial, &group[0].finding);
    html! {
        a.id href={ "/gyros/" (encoded(serial)) } { (serial) }
        @for alert in group { " " span.violated { (violated(t, alert)) } }
        @if let Some(at) = finding.record.as_ref().and(finding.calibrated_at.as_ref()) {
            " " span.quiet {
                (t.calibrated) " " (written(at))
                @for place in [&finding.imu, &finding.station].into_iter().flatten() { " · " span.id { (place) } }
            }
        }
    }
}

fn violated(t: &Text, alert: &AlertBody) -> Markup {
    html! { (symbol(&alert.coefficient)) " " (Rule::from_name(&alert.rule).map_or("", |rule| t.rule(rule))) }
}

fn heading(viewer: &Viewer, gyros: bool) -> Markup {
    let t = viewer.text();
    html! {
        thead { tr {
            th { (t.status_word) }
            @if gyros { th { (t.serial) } }
            th { (t.violates) } th { (t.reason_word) } th { (t.since) } th { (t.fired) } th { (t.state) }
        } }
    }
}

/// `gyros`: whether each line names its gyro. `here`: where to come back to from what is done; none where nothing can
/// be.
pub(super) fn table<'a>(
    viewer: &Viewer,
    alerts: impl Iterator<Item = &'a AlertBody>,
    gyros: bool,
    here: Option<&str>,
) -> Markup {
    html! {
        div.scroll tabindex="0" { table.alerts {
            (heading(viewer, gyros))
            tbody { @for alert in alerts { (line(viewer, alert, gyros, here)) } }
        } }
    }
}

fn line(viewer: &Viewer, alert: &AlertBody, gyros: bool, here: Option<&str>) -> Markup {
    let t = viewer.text();
    let open = alert.state != Standing::Resolved.name();
    let deed = |deed: &str, here: &str| format!("/alerts/{}/{deed}?back={}", alert.id, encoded(here));
    html! {
        tr {
            td { (status::badge(t, alert.status.as_deref().and_then(Status::from_name))) }
            @if gyros { th scope="row" { a.id href={ "/gyros/" (encoded(&alert.serial)) } { (alert.serial) } } }
            td.nowrap { (violated(t, alert)) }
            td.words {
                (alert.finding.reason.words(viewer.language))
                @if let Some(record) = alert.finding.record.as_ref().filter(|_| alert.rule != Rule::Agreement.name()) {
                    " " a href={ "/records/" (record) } { (t.record) }
                }
            }
            td data-label=(t.since) { @if let Some(since) = &alert.since { (written(since)) } }
            td data-label=(t.fired) { (written(&alert.fired_at)) }
            td.words {
                (t.standing(&alert.state))
                @if let Some(said) = &alert.acknowledged { (remark(t.said_by, &said.by, &said.reason)) }
                @if let Some(said) = &alert.silenced { " " (t.until) " " (written(&said.until)) (remark(t.said_by, &said.by, &said.reason)) }
                @if let Some(at) = &alert.resolved_at { " " (written(at)) }
                @if let Some(here) = here.filter(|_| open && viewer.may(Role::Engineer)) {
                    span.actions.no-print {
                        @if alert.acknowledged.is_none() { a href=(deed("acknowledge", here)) { (t.acknowledge) } }
                        @else { a href=(deed("unacknowledge", here)) { (t.unacknowledge) } }
                        a href=(deed("silence", here)) { (t.silence) }
                    }
                }
            }
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Said {
    #[serde(flatten)]
    word: Word,
    /// How long a silence lasts.
    days: String,
}

/// What can be done about an alert.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    Acknowledge,
    Unacknowledge,
    Silence,
}

impl Doing {
    /// By its name in the address.
    fn of(deed: &str) -> Result<Self, Problem> {
        let unknown =
            || Problem::new(404, "title_no_such_page", message!("not_done_to_alerts", action = deed.to_owned()));
        [Self::Acknowledge, Self::Unacknowledge, Self::Silence]
            .into_iter()
            .find(|one| one.name() == deed)
            .ok_or_else(unknown)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Acknowledge => "acknowledge",
            Self::Unacknowledge => "unacknowledge",
            Self::Silence => "silence",
        }
    }
}

async fn known(pages: &Pages, id: &str) -> Result<(Id, AlertBody), Problem> {
    let unknown = || Problem::new(404, "title_unknown_alert", message!("unknown_alert", id = id.to_owned()));
    let number = id.parse::<Id>().map_err(|_| unknown())?;
    Ok((number, pages.pipeline.alerts.get(number).await?.ok_or_else(unknown)?.alert))
}

/// The page on which something is done about an alert.
pub(super) async fn ask(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path((id, deed)): Path<(String, String)>,
    Query(word): Query<Word>,
) -> Response {
    let found = match Doing::of(&deed) {
        Ok(doing) => known(&pages, &id).await.map(|(_, alert)| (doing, alert)),
        Err(problem) => Err(problem),
    };
    let said = Said { word, ..Said::default() };
    viewer.show(found.map(|(doing, alert)| {
        with_form(&viewer, &alert, doing, &said, |deed| deed.page(&viewer, &said.word, &Faults::default()))
    }))
}

pub(super) async fn act(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path((id, deed)): Path<(String, String)>,
    Form(said): Form<Said>,
) -> Response {
    answered(&viewer, done(&pages, &viewer, (&id, &deed), &said).await)
}

async fn done(pages: &Pages, viewer: &Viewer, (id, deed): (&str, &str), said: &Said) -> Result<Response, Problem> {
    let doing = Doing::of(deed)?;
    let silence = doing == Doing::Silence;
    let (number, alert) = known(pages, id).await?;
    let mut faults = Faults::default();
    said.word.check(viewer, &mut faults);
    let days = said.days.trim().parse().ok().filter(|days| *days > 0.0 && *days <= LONGEST_SILENCE);
    if silence && days.is_none() {
        faults.push("days", Message::verbatim(format_args!("0 … {LONGEST_SILENCE}")));
    }
    if !faults.is_empty() {
        return Ok(with_form(viewer, &alert, doing, said, |deed| deed.again(viewer, &said.word, &faults)));
    }
    let until = pages.clock.now().plus_days(days.unwrap_or_default());
    let change = match doing {
        Doing::Acknowledge => AlertChange::Acknowledge,
        Doing::Unacknowledge => AlertChange::Unacknowledge,
        Doing::Silence => AlertChange::Silence { until },
    };
    let Word { by, reason, .. } = said.word.clone();
    pages.pipeline.alerts.change(AlertOrder { alert: number, change, by, reason }).await?;
    Ok(see_other(said.word.back_or("/alerts")))
}

fn with_form<T>(viewer: &Viewer, alert: &AlertBody, doing: Doing, said: &Said, show: impl FnOnce(&Deed<'_>) -> T) -> T {
    let t = viewer.text();
    let (title, does, button) = match doing {
        Doing::Acknowledge => (t.acknowledge_title, t.acknowledge_what, t.acknowledge),
        Doing::Unacknowledge => (t.unacknowledge_title, t.unacknowledge_what, t.unacknowledge),
        Doing::Silence => (t.silence_title, t.silence_what, t.silence),
    };
    let what = html! { (table(viewer, std::iter::once(alert), true, None)) p.lead { (does) } };
    let days = if said.days.is_empty() { "7" } else { &said.days };
    let fields = html! {
        @if doing == Doing::Silence {
            label { (t.silence_days) input name="days" type="number" min="0.1" max=(LONGEST_SILENCE) step="0.1" value=(days) required; }
        }
    };
    show(&Deed {
        section: Section::Alerts,
        title,
        what,
        fields,
        action: &format!("/alerts/{}/{}", alert.id, doing.name()),
        button,
        back: said.word.back_or("/alerts"),
        reasoned: true,
    })
}
