//! `/gyros/{serial}`: one gyro, from its plot down to every figure.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::Path;
use maud::{Markup, html};
use serde::Deserialize;
use tokio::time::Instant;

use super::layout::{DRIFTS, Page, Section, encoded, instant, label, symbol};
use super::text::Text;
use super::verdicts::{self, Said};
use super::viewer::{Viewer, Visit};
use super::{Pages, alerts, before_after, figure, gyro_attributes};
use crate::core::access::Role;
use crate::core::figures::Figures;
use crate::core::id::Id;
use crate::core::judge::{State, Status};
use crate::core::time::UtcMicros;
use crate::pages::history_plot::{self, Epochs, Seen};
use crate::pages::sent::Query;
use crate::pages::view::{AskedView, Shown, View};
use crate::pages::{gyro_head, history, status};
use crate::pipeline::{Comparison, Course, ExplainedHistory, Names, Standing, Statuses, sample_of};
use crate::wire::alert::AlertBody;
use crate::wire::answer::VerdictBody;
use crate::wire::problem::Problem;

/// Records of a run that are told from what is only drifting; an older one began before.
const LONGEST_RUN: usize = 400;

/// Calibrations in one table, on the page and in a report.
const ROWS: usize = 30;
pub(super) const MOST_ROWS: usize = 40;

#[derive(Debug, Default, Deserialize)]
pub(super) struct Asked {
    #[serde(flatten)]
    view: AskedView,
    /// Names of older calibrations: how many to pass over.
    #[serde(default)]
    skip: String,
}

/// All that is known of a gyro, by the method that is shown.
pub(super) struct Facts {
    pub course: Course,
    /// What its course is held against.
    pub epochs: Epochs,
    pub comparison: Comparison,
    /// How it stands; none for a gyro that has neither a calibration nor a bench result.
    pub standing: Option<Standing>,
    /// What the rules say of the records that are drawn and listed.
    pub statuses: Statuses,
    /// On its newest record.
    pub verdicts: Vec<Said>,
    /// Those that are not resolved.
    pub alerts: Vec<AlertBody>,
    /// The gyro that has been calibrated in its slot since.
    pub successor: Option<Arc<str>>,
}

impl Facts {
    /// `skip`: how many of the newest records the table passes over.
    pub async fn of(pages: &Pages, number: u32, serial: &str, view: &View, skip: usize) -> Result<Self, Problem> {
        let pipeline = &pages.pipeline;
        let method = view.shown.separation();
        let course = pipeline.queries.histories.course(number, serial, method).await?;
        let comparison = pipeline.queries.histories.compare_methods(number, None).await?;
        let epochs = history_plot::epochs(&course, method);
        let standing = pipeline.queries.fleet.standings(vec![(number, course.figures.last().copied())]).await?.pop();
        let mut verdicts = newest_verdicts(pages, serial, &course).await?;
        for violation in standing.iter().flat_map(|standing| &standing.violations) {
            verdicts.iter_mut().for_each(|said| said.is_known_to_be(violation));
        }
        let drawn = history_plot::drawn(&course, view).into_iter();
        let listed = course.figures.iter().rev().skip(first_row(skip, course.figures.len())).take(MOST_ROWS);
        let beyond = |row: &&Figures| row.states.worst() == Some(State::Exceeded);
        let run = course.figures.iter().rev().take_while(beyond).take(LONGEST_RUN);
        let asked = drawn.chain(listed).chain(run);
        let statuses = pipeline.queries.histories.statuses(number, asked, &[0, 1, 2]).await?;
        let alerts = alerts::open_ones(pages, number).await?;
        let successor = match course.figures.last() {
            Some(newest) => pipeline.queries.fleet.seated_in(newest.imu).await?.successor(number),
            None => None,
        };
        Ok(Self { course, epochs, comparison, standing, statuses, verdicts, alerts, successor })
    }

    /// Its status, and that it is out of use where it is.
    pub fn badge(&self, t: &Text) -> Markup {
        let (status, ended) = self.standing.as_ref().map_or((None, None), |one| (one.status, one.out_of_use));
        html! { (status::badge(t, status)) " " (status::out_of_use(t, ended)) }
    }

    /// What its plot is made from.
    pub fn seen(&self) -> Seen<'_> {
        Seen { course: &self.course, epochs: &self.epochs, statuses: &self.statuses, verdicts: &self.verdicts }
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

pub(super) async fn page(
    Visit { ref pages, ref viewer }: Visit,
    Path(ref serial): Path<String>,
    Query(ref asked): Query<Asked>,
) -> Result<Page, Problem> {
    let number = known(pages, serial)?;
    let judged = pages.config.judging.method;
    let view = View::asked(&asked.view, judged);
    let skip = asked.skip.parse().unwrap_or(0);
    let facts = Facts::of(pages, number, serial, &view, skip).await?;
    let explained = explained(pages, number, serial, &facts, Instant::now() + PATIENCE).await?;
    let names = pages.pipeline.queries.names();
    let judges = !facts.verdicts.is_empty() || !facts.alerts.is_empty();
    let body = html! {
        @if judges { a.skip href="#verdicts" { (viewer.text().skip_to_verdicts) } }
        (gyro_head::head(viewer, serial, &facts, judged, explained.as_ref(), &names))
        (history(viewer, serial, &view, &facts, &names))
        @if judges { (verdict_section(viewer, &facts)) }
        (before_after::section(viewer, &facts.course, judged))
        (agreement(viewer, serial, &facts.comparison))
        (history::happenings(viewer, &facts.course, &names))
        (benches(viewer, &facts.course))
        (calibrations(viewer, serial, (&view, skip), &facts, &names))
        (gyro_attributes::edit(viewer, serial))
    };
    Ok(Page { title: serial.to_owned(), section: Section::Fleet, body })
}

/// How long the page waits for the diagnosis of the history; it has a page of its own.
const PATIENCE: Duration = Duration::from_millis(400);

/// Why its coefficients changed; none for a gyro without calibrations, and where it is not found by `until`.
pub(super) async fn explained(
    pages: &Pages,
    number: u32,
    serial: &str,
    facts: &Facts,
    until: Instant,
) -> Result<Option<ExplainedHistory>, Problem> {
    if facts.course.figures.is_empty() {
        return Ok(None);
    }
    let explained = tokio::time::timeout_at(until, pages.pipeline.queries.histories.explain(number, serial)).await;
    Ok(explained.ok().transpose()?)
}

async fn newest_verdicts(pages: &Pages, serial: &str, course: &Course) -> Result<Vec<Said>, Problem> {
    let Some(newest) = course.figures.last() else { return Ok(Vec::new()) };
    let stored = pages.pipeline.queries.records.record(newest.record).await?;
    Ok(stored.map_or_else(Vec::new, |stored| Said::of_gyro(serial, &stored.answer.verdicts, &stored.seen)))
}

fn verdict_section(viewer: &Viewer, facts: &Facts) -> Markup {
    html! {
        section #verdicts {
            h2 { (viewer.text().verdicts) }
            (verdicts::table(viewer, &facts.verdicts, &facts.alerts, Some(&viewer.here)))
        }
    }
}

fn history(viewer: &Viewer, serial: &str, view: &View, facts: &Facts, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    let plots = history_plot::plots(viewer, serial, *view, facts.seen(), names, "");
    let to = |view: View| format!("{}#history", view.address());
    let whole = View { from: None, to: None, ..*view };
    let year = facts.course.figures.last().map(|newest| newest.at.plus_days(-365.0));
    let baseline = facts.epochs[0].last().map(|epoch| epoch.from).filter(|_| facts.epochs[0].len() > 1);
    let since = [(t.since_baseline, baseline), (t.last_year, year)];
    html! {
        section #history data-picture=(serial) {
            h2 { (t.history) }
            div.tabs {
                nav aria-label=(t.axis_word) {
                    @for (name, absolute) in [(t.axis_deviation, false), (t.axis_absolute, true)] {
                        @let here = (absolute == view.absolute).then_some("true");
                        a href=(to(View { absolute, ..*view })) aria-current=[here] { (name) }
                    }
                }
                nav aria-label=(t.method) {
                    @for shown in Shown::ALL {
                        @let here = (shown == view.shown).then_some("true");
                        a href=(to(View { shown, ..*view })) aria-current=[here] { (shown.title(t)) }
                    }
                }
                nav aria-label=(t.span_word) {
                    a href=(to(whole)) aria-current=[(*view == whole).then_some("true")] { (t.whole_history) }
                    @for (name, from) in since {
                        @if from.is_some() {
                            @let part = View { from, ..whole };
                            a href=(to(part)) aria-current=[(part.address() == view.address()).then_some("true")] {
                                (name)
                            }
                        }
                    }
                }
                button type="button" data-save hidden { (t.save_picture) }
            }
            (plots.folded(t))
            p.note.no-print {
                (t.plot_note) " " (t.csv) ": "
                @for coefficient in DRIFTS {
                    a href={ "/v1/gyros/" (encoded(serial)) "/trend?coefficient=" (coefficient) "&method="
                             (view.shown.separation_name()) "&format=csv" }
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
                                td.n { (label("", name)) (figure::drift(measured.value, measured.sd)) }
                            }
                        }
                    } }
                    tfoot { tr {
                        th scope="row" colspan="3" { (t.range) }
                        @for (range, name) in comparison.range.into_iter().zip(DRIFTS) {
                            td.n { @if let Some(range) = range { (label("", name)) (figure::fixed(range, 6)) } }
                        }
                    } }
                } }
                @let verdicts: Vec<_> = comparison.verdicts.iter().map(|v| Said { body: VerdictBody::of(serial, v), seen: Some(*v) }).collect();
                (verdicts::list(viewer, &verdicts))
            }
        }
    }
}

fn calibrations(
    viewer: &Viewer,
    serial: &str,
    (view, skip): (&View, usize),
    facts: &Facts,
    names: &Names<'_>,
) -> Markup {
    let (t, shown) = (viewer.text(), view.shown);
    let count = facts.course.figures.len();
    let skip = first_row(skip, count);
    let rows = facts.course.figures.iter().rev().skip(skip).take(ROWS);
    let to = |skip: usize| format!("/gyros/{}{}&skip={skip}#calibrations", encoded(serial), view.address());
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
                @if deeds { th.no-print { (t.actions_word) } }
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
                td.n { (label("", name)) (figure::drift(measured.value, measured.sd)) }
            }
            td {
                @for status in grave {
                    @if of_status(status).next().is_some() {
                        (status::badge(t, Some(status))) " " @for column in of_status(status) { (symbol(DRIFTS[column])) " " }
                    }
                }
                @if worst <= Status::NotEnoughData { (status::badge(t, Some(worst))) }
            }
            @if deeds { td.no-print { (void_link(viewer, "records", figures.record, figures.at)) } }
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
                        th.n { (symbol("D_I")) } th.n { (symbol("D_S")) } @if may_void { th.no-print { (t.actions_word) } }
                    } }
                    tbody { @for row in course.benches.iter().rev() {
                        tr {
                            td { (instant(row.measured_at)) }
                            td { (t.method(row.method.name())) }
                            td { (row.station) }
                            @for i in 0..2 { td.n { (label("", DRIFTS[i])) (figure::drift(row.d[i], row.sd[i])) } }
                            @if may_void { td.no-print { (void_link(viewer, "bench-results", row.id, row.measured_at)) } }
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
