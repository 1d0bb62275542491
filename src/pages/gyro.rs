//! `/gyros/{serial}`: one gyro, from its plot down to every figure.

use axum::extract::{Path, Query, State as Held};
use axum::response::Response;
use maud::{Markup, html};
use serde::Deserialize;

use super::figure;
use super::layout::{DRIFTS, Page, Section, encoded, instant, symbol};
use super::text::Text;
use super::verdicts::{self, Said};
use super::viewer::Viewer;
use super::{Pages, alerts, before_after};
use crate::core::access::Role;
use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::judge::Status;
use crate::core::time::UtcMicros;
use crate::pages::history;
use crate::pages::history::{Bands, Shown};
use crate::pages::status;
use crate::pipeline::{Comparison, Course, Names, Standing, Statuses, sample_of};
use crate::wire::alert::AlertBody;
use crate::wire::answer::VerdictBody;
use crate::wire::problem::Problem;

/// Calibrations in one table, on the page and in a report.
const ROWS: usize = 30;
pub(super) const MOST_ROWS: usize = 40;

#[derive(Debug, Default, Deserialize)]
pub(super) struct Asked {
    /// `rigid`, `published` or `bench`; the judged one where it is left out.
    method: Option<String>,
    /// Names of older calibrations: how many to pass over.
    #[serde(default)]
    skip: usize,
}

pub(super) async fn page(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path(serial): Path<String>,
    Query(asked): Query<Asked>,
) -> Response {
    viewer.show(build(&pages, &viewer, &serial, &asked).await)
}

/// All that is known of a gyro, by the method that is shown.
pub(super) struct Facts {
    pub course: Course,
    /// What its course is held against.
    pub bands: Bands,
    pub comparison: Comparison,
    /// How it stands; none for a gyro that has neither a calibration nor a bench result.
    pub standing: Option<Standing>,
    /// What the rules say of the records that are drawn and listed.
    pub statuses: Statuses,
    /// On its newest record.
    pub verdicts: Vec<Said>,
    /// Those that are not resolved.
    pub alerts: Vec<AlertBody>,
}

impl Facts {
    /// `skip`: how many of the newest records the table passes over.
    pub async fn of(pages: &Pages, number: u32, serial: &str, shown: Shown, skip: usize) -> Result<Self, Problem> {
        let pipeline = &pages.pipeline;
        let course = pipeline.queries.histories.course(number, serial, shown.separation()).await?;
        let comparison = pipeline.queries.histories.compare_methods(number, None).await?;
        let bands = history::bands(&course, shown.separation());
        let standing = pipeline.queries.fleet.standings(vec![(number, course.figures.last().copied())]).await?.pop();
        let mut verdicts = newest_verdicts(pages, serial, &course).await?;
        for violation in standing.iter().flat_map(|standing| &standing.violations) {
            verdicts.iter_mut().for_each(|said| said.is_known_to_be(violation));
        }
        let drawn = history::drawn(&course, shown.separation());
        let listed = course.figures.iter().rev().skip(first_row(skip, course.figures.len())).take(MOST_ROWS);
        let statuses = pipeline.queries.histories.statuses(number, drawn.chain(listed), &[0, 1, 2]).await?;
        let alerts = alerts::open_ones(pages, number).await?;
        Ok(Self { course, bands, comparison, standing, statuses, verdicts, alerts })
    }

    /// Its status, and that it is out of use where it is.
    pub fn badge(&self, t: &Text) -> Markup {
        let (status, ended) = self.standing.as_ref().map_or((None, None), |one| (one.status, one.out_of_use));
        html! { (status::badge(t, status)) " " (status::out_of_use(t, ended)) }
    }

    /// What its plot is made from.
    pub fn plotted(&self) -> (&Course, &Bands, &Statuses) {
        (&self.course, &self.bands, &self.statuses)
    }
}

/// Where a page of the table begins; beyond the oldest there is the last page.
fn first_row(skip: usize, count: usize) -> usize {
    if skip < count { skip } else { count.saturating_sub(1) / ROWS * ROWS }
}

/// The number of a gyro.
pub(super) fn known(pages: &Pages, serial: &str) -> Result<u32, Problem> {
    let number = pages.pipeline.queries.names().gyro_number(serial);
    number.ok_or_else(|| Problem::unknown_gyro(serial))
}

async fn build(pages: &Pages, viewer: &Viewer, serial: &str, asked: &Asked) -> Result<Page, Problem> {
    let number = known(pages, serial)?;
    let shown = Shown::asked(asked.method.as_deref(), pages.config.judging.method);
    let facts = Facts::of(pages, number, serial, shown, asked.skip).await?;
    let names = pages.pipeline.queries.names();
    let body = html! {
        (head(viewer, serial, &facts, &names))
        (deeds(viewer, serial))
        (verdict_section(viewer, &facts.verdicts))
        (history(viewer, serial, shown, &facts, &names))
        (before_after::section(viewer, &facts.course, pages.config.judging.method))
        (alert_section(viewer, &facts.alerts))
        (agreement(viewer, serial, &facts.comparison))
        (history::happenings(viewer, &facts.course, &names))
        (changes_explained(viewer, serial))
        (benches(viewer, &facts.course))
        (calibrations(viewer, serial, shown, asked.skip, &facts, &names))
    };
    Ok(Page { title: serial.to_owned(), section: Section::Fleet, plots: true, body })
}

/// What can be done about it.
fn deeds(viewer: &Viewer, serial: &str) -> Markup {
    let t = viewer.text();
    let path = format!("/gyros/{}", encoded(serial));
    html! {
        p.actions {
            @if viewer.may(Role::Engineer) {
                a.action href={ (path) "/events/new" } { (t.add_event) }
                a.action href={ (path) "/events/new?event=baseline" } { (t.start_baseline) }
            }
            a.action href={ (path) "/report" } { (t.report) }
        }
    }
}

fn alert_section(viewer: &Viewer, open: &[AlertBody]) -> Markup {
    html! {
        @if !open.is_empty() {
            section #alerts {
                h2 { (viewer.text().alerts_open) }
                (alerts::table(viewer, open.iter(), false, Some(&viewer.here)))
            }
        }
    }
}

async fn newest_verdicts(pages: &Pages, serial: &str, course: &Course) -> Result<Vec<Said>, Problem> {
    let Some(newest) = course.figures.last() else { return Ok(Vec::new()) };
    let stored = pages.pipeline.queries.records.record(newest.record).await?;
    Ok(stored.map_or_else(Vec::new, |stored| Said::of_gyro(serial, &stored.answer.verdicts, &stored.seen)))
}

fn head(viewer: &Viewer, serial: &str, facts: &Facts, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    html! {
        h1 {
            (serial) " "
            (facts.badge(t))
        }
        @if let Some(figures) = facts.course.figures.last() {
            p.lead {
                a href={ "/imus/" (encoded(names.imu(figures.imu))) } { (history::seat(figures, names)) }
                " · " (t.station) " " (names.station(figures.station))
                " · " (t.calibrated) " " (instant(figures.at))
                @match facts.alerts.len() {
                    0 => {}
                    1 => { " · " a href="#alerts" { (t.alert_one) } }
                    several => { " · " a href="#alerts" { (several) " " (t.alerts_count) } }
                }
            }
        } @else {
            p.lead { (t.never_calibrated) }
        }
    }
}

fn verdict_section(viewer: &Viewer, verdicts: &[Said]) -> Markup {
    html! {
        @if !verdicts.is_empty() {
            section {
                h2 { (viewer.text().verdicts) }
                (verdicts::list(viewer, verdicts))
            }
        }
    }
}

fn history(viewer: &Viewer, serial: &str, shown: Shown, facts: &Facts, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    let plot = history::plot(viewer, serial, shown, facts.plotted(), names);
    let left_out = plot.strips.iter().flat_map(|strip| &strip.series).find_map(|series| series.thinned());
    html! {
        section {
            h2 { (t.history) }
            nav.tabs aria-label=(t.method) {
                @for one in Shown::ALL {
                    a href={ "?method=" (one.name()) } aria-current=[(one == shown).then_some("true")] { (one.title(t)) }
                }
            }
            (plot.markup(t))
            p.note {
                (t.plot_note) " "
                @if let Some(of) = left_out { (of) " " (t.thinned) ". " }
                (t.csv) ": "
                @for coefficient in DRIFTS {
                    a href={ "/v1/gyros/" (encoded(serial)) "/trend?coefficient=" (coefficient) "&method="
                             (shown.separation_name()) "&format=csv" }
                      download={ (serial) "-" (coefficient) ".csv" } { (symbol(coefficient)) } " "
                }
            }
        }
    }
}

/// Results side by side in the form of the paper's Table 5.
pub(super) fn agreement(viewer: &Viewer, serial: &str, comparison: &Comparison) -> Markup {
    let t = viewer.text();
    html! {
        section {
            h2 { (t.agreement) }
            @if comparison.results.len() < 2 {
                p { (t.one_result) }
            }
            @if !comparison.results.is_empty() {
                p.note { (t.agreement_note) " " (t.unit) }
                div.scroll tabindex="0" { table.cards {
                    thead { tr {
                        th { (t.method) } th { (t.date) } th { (t.station) }
                        th.n { (symbol("D_I")) } th.n { (symbol("D_S")) }
                    } }
                    tbody { @for result in &comparison.results {
                        tr.beside[!result.counts] {
                            th scope="row" { (t.method(result.method)) @if !result.counts { br; span.quiet { (t.not_counted) } } }
                            td { (instant(result.at)) }
                            td {
                                (result.station)
                                @if let Some((imu, slot)) = &result.seat { br; span.quiet { (imu) " " (slot.name()) } }
                            }
                            @for (measured, name) in result.d.iter().zip(DRIFTS) {
                                td.n data-label=(name) { (figure::drift(measured.value, measured.sd)) }
                            }
                        }
                    } }
                    tfoot { tr {
                        th scope="row" colspan="3" { (t.range) }
                        @for (range, name) in comparison.range.into_iter().zip(DRIFTS) {
                            td.n data-label=(name) { @if let Some(range) = range { (figure::fixed(range, 6)) } }
                        }
                    } }
                } }
                @let verdicts: Vec<_> = comparison.verdicts.iter().map(|v| Said { body: VerdictBody::of(serial, v), seen: Some(*v) }).collect();
                (verdicts::list(viewer, &verdicts))
            }
        }
    }
}

/// Where the diagnosis of its history is; it asks after the whole fleet, which is too much for every view of a page.
fn changes_explained(viewer: &Viewer, serial: &str) -> Markup {
    let t = viewer.text();
    html! {
        section #diagnosis {
            h2 { (t.history_diagnosis) }
            p {
                (t.history_diagnosis_note) " "
                a href={ "/gyros/" (encoded(serial)) "/diagnosis" } { (t.history_diagnosis) } " · "
                a href={ "/v1/gyros/" (encoded(serial)) "/diagnosis" } { "JSON" }
            }
        }
    }
}

fn calibrations(viewer: &Viewer, serial: &str, shown: Shown, skip: usize, facts: &Facts, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    let count = facts.course.figures.len();
    let skip = first_row(skip, count);
    let rows = facts.course.figures.iter().rev().skip(skip).take(ROWS);
    let to = |skip: usize| format!("/gyros/{}?method={}&skip={skip}#calibrations", encoded(serial), shown.name());
    html! {
        @if count > 0 {
            section #calibrations {
                h2 { (t.calibrations) }
                p.note {
                    (skip + 1) "–" ((skip + ROWS).min(count)) " / " (count) ", "
                    (t.method_of(shown.separation())) ", " (t.unit)
                }
                (calibration_table(viewer, shown, &facts.statuses, rows, names, viewer.may(Role::Engineer)))
                nav.pager aria-label=(t.calibrations) {
                    @if skip > 0 { a href=(to(0)) { (t.newer) } }
                    @if skip + ROWS < count { a rel="next" href=(to(skip + ROWS)) { (t.older) } }
                }
            }
        }
    }
}

/// `deeds`: whether each line leads to voiding it.
pub(super) fn calibration_table<'a>(
    viewer: &Viewer,
    shown: Shown,
    statuses: &Statuses,
    rows: impl Iterator<Item = &'a Figures>,
    names: &Names<'_>,
    deeds: bool,
) -> Markup {
    let t = viewer.text();
    html! {
        div.scroll tabindex="0" { table.cards {
            thead { tr {
                th { (t.calibrated) } th { (t.imu) } th { (t.station) }
                th.n { (symbol("D_I")) } th.n { (symbol("D_S")) } th.n { (symbol("D_O")) } th { (t.status_word) }
                @if deeds { th { (t.actions_word) } }
            } }
            tbody { @for figures in rows { (calibration(viewer, shown, figures, (statuses, names), deeds)) } }
        } }
    }
}

fn calibration(
    viewer: &Viewer,
    shown: Shown,
    figures: &Figures,
    (statuses, names): (&Statuses, &Names<'_>),
    deeds: bool,
) -> Markup {
    let t = viewer.text();
    let sample = sample_of(figures, shown.separation());
    let worst = statuses.worst(figures);
    let grave = Status::ALL.into_iter().rev().filter(|status| *status > Status::NotEnoughData && *status <= worst);
    let of_status = |status: Status| (0..3).filter(move |&column| statuses.get(figures, column) == status);
    html! {
        tr {
            td { a href={ "/records/" (figures.record) } { (instant(figures.at)) } }
            td { (history::seat(figures, names)) }
            td { (names.station(figures.station)) }
            @for (measured, name) in sample.d.iter().zip(DRIFTS) {
                td.n data-label=(name) { (figure::drift(measured.value, measured.sd)) }
            }
            td {
                @for status in grave {
                    @if of_status(status).next().is_some() {
                        (status::badge(t, Some(status))) " " @for column in of_status(status) { (symbol(DRIFTS[column])) " " }
                    }
                }
                @if worst <= Status::NotEnoughData { (status::badge(t, Some(worst))) }
            }
            @if deeds { td { (void_link(viewer, "records", figures.record, figures.at)) } }
        }
    }
}

/// Each bench result by itself, newest first.
fn benches(viewer: &Viewer, course: &Course) -> Markup {
    let t = viewer.text();
    html! {
        @if !course.benches.is_empty() {
            @let may_void = viewer.may(Role::Engineer);
            section #benches {
                h2 { (t.bench_results) }
                div.scroll.tall tabindex="0" { table.cards {
                    thead { tr {
                        th { (t.date) } th { (t.method) } th { (t.station) }
                        th.n { (symbol("D_I")) } th.n { (symbol("D_S")) } @if may_void { th { (t.actions_word) } }
                    } }
                    tbody { @for row in course.benches.iter().rev() {
                        tr {
                            td { (instant(row.measured_at)) }
                            td { (t.method(row.method.name())) }
                            td { (row.station) }
                            @for i in 0..2 { td.n data-label=(DRIFTS[i]) { (figure::drift(row.d[i], row.sd[i])) } }
                            @if may_void { td { (void_link(viewer, "bench-results", row.id, row.measured_at)) } }
                        }
                    } }
                } }
            }
        }
    }
}

/// To the page that voids an item; for a screen reader, which one.
fn void_link(viewer: &Viewer, place: &str, id: Id, at: UtcMicros) -> Markup {
    let t = viewer.text();
    let href = format!("/{place}/{id}/void?back={}", encoded(&viewer.here));
    html! { a.no-print href=(href) aria-label={ (t.void) " " (at.date()) } { (t.void) } }
}
