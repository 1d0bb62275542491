//! `/gyros/{serial}`: one gyro, from its plot down to every figure.

use std::time::Duration;

use tokio::time::Instant;

use super::gyro_facts::{Facts, ROWS, first_row};
use super::prelude::*;
use super::verdicts::{self, SeenVerdict};
use super::view::{ShownMethod, View, ViewQuery};
use super::{before_after, gyro_attributes, gyro_head, history, history_plot, status};
use crate::core::figures::Figures;
use crate::pipeline::{Comparison, ExplainedHistory, GyroTimeline, Names, Statuses, sample_of};
use crate::wire::answer::VerdictBody;

#[derive(Debug, Default, Deserialize)]
pub(super) struct GyroQuery {
    #[serde(flatten)]
    view: ViewQuery,
    /// Names of older calibrations: how many to pass over.
    #[serde(default)]
    skip: String,
}

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref serial): Path<String>,
    Query(ref asked): Query<GyroQuery>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let number = pages.gyro_number(serial)?;
    let judged = pages.config.judging.method;
    let view = View::asked(&asked.view, judged);
    let skip = asked.skip.parse().unwrap_or(0);
    let facts = Facts::of(pages, number, serial, &view, skip).await?;
    let explained = explained(pages, number, serial, &facts, Instant::now() + PATIENCE).await?;
    let names = pages.pipeline.queries.names();
    let judges = !facts.verdicts.is_empty() || !facts.alerts.is_empty();
    let body = html! {
        @if judges { a.skip href="#verdicts" { (t.skip_to_verdicts) } }
        (gyro_head::head(viewer, serial, &facts, judged, explained.as_ref(), &names))
        (history(t, serial, &view, &facts, &names))
        @if judges {
            section #verdicts {
                h2 { (t.verdicts) }
                (verdicts::table(viewer, &facts.verdicts, &facts.alerts, Some(&viewer.here)))
            }
        }
        (before_after::section(t, &facts.course, judged))
        (agreement(t, serial, &facts.comparison))
        (history::happenings(t, &facts.course, &names))
        (benches(viewer, &facts.course, &names))
        (calibrations(viewer, serial, (&view, skip), &facts, &names))
        (gyro_attributes::edit(viewer, serial))
    };
    Ok(Page { title: serial.to_owned(), section: Section::Fleet, body })
}

/// How long the page waits for the diagnosis of the history; it has a page of its own.
pub(super) const PATIENCE: Duration = Duration::from_millis(400);

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

fn history(t: &Text, serial: &str, view: &View, facts: &Facts, names: &Names<'_>) -> Markup {
    let plots = history_plot::plots(t, serial, *view, facts.seen(), names, "");
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
                    @for shown in ShownMethod::ALL {
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
pub(super) fn agreement(t: &Text, serial: &str, comparison: &Comparison) -> Markup {
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
                            th scope="row" {
                                (t.method(result.method)) @if !result.counts { br; span.quiet { (t.not_counted) } }
                            }
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
                @let verdicts: Vec<_> = comparison.verdicts.iter().map(|v| SeenVerdict { body: VerdictBody::of(serial, v), seen: Some(*v) }).collect();
                (verdicts::list(t, &verdicts))
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
    shown: ShownMethod,
    statuses: &Statuses,
    rows: impl Iterator<Item = &'a Figures>,
    names: &Names<'_>,
    deeds: bool,
) -> Markup {
    let t = viewer.text();
    html! {
        (wide_table("cards", html! {
            th { (t.calibrated) } th { (t.imu) } th { (t.station) }
            @for name in DRIFTS { th.n { (symbol(name)) } } th { (t.status_word) }
            @if deeds { th.no-print { (t.actions_word) } }
        }, html! { @for figures in rows { tr {
            td { a href={ "/records/" (figures.record) } { (instant(figures.at)) } }
            td { (history::seat(figures, names)) }
            td { (names.station(figures.station)) }
            @for (measured, name) in sample_of(figures, shown.separation()).d.iter().zip(DRIFTS) {
                td.n { (label("", name)) (figure::drift(measured.value, measured.sd)) }
            }
            td { (judged(t, statuses, figures)) }
            @if deeds { td.no-print { (void_link(viewer, "records", figures.record, figures.at)) } }
        } } }))
    }
}

/// Each status that speaks, the gravest first, with its coefficients; else the one of the record.
fn judged(t: &Text, statuses: &Statuses, figures: &Figures) -> Markup {
    let worst = statuses.worst(figures);
    let grave = Status::ALL.into_iter().rev().filter(|status| *status > Status::NotEnoughData && *status <= worst);
    let of_status = |status: Status| (0..3).filter(move |&column| statuses.get(figures, column) == status);
    html! {
        @for status in grave {
            @if of_status(status).next().is_some() {
                (status::badge(t, Some(status))) " " @for column in of_status(status) { (symbol(DRIFTS[column])) " " }
            }
        }
        @if worst <= Status::NotEnoughData { (status::badge(t, Some(worst))) }
    }
}

/// Each bench result by itself, newest first.
fn benches(viewer: &Viewer, course: &GyroTimeline, names: &Names<'_>) -> Markup {
    let t = viewer.text();
    html! {
        @if !course.benches.is_empty() {
            @let may_void = viewer.may(Role::Engineer);
            section #benches {
                h2 { (t.bench_results) }
                (tall_table("cards", html! {
                    th { (t.date) } th { (t.method) } th { (t.station) }
                    th.n { (symbol("D_I")) } th.n { (symbol("D_S")) } @if may_void { th.no-print { (t.actions_word) } }
                }, html! { @for row in course.benches.iter().rev() { tr {
                    td { (instant(row.measured_at)) }
                    td { (t.method(row.method.name())) }
                    td { (names.station(row.station)) }
                    @for i in 0..2 { td.n { (label("", DRIFTS[i])) (figure::drift(row.d[i], row.sd[i])) } }
                    @if may_void { td.no-print { (void_link(viewer, "bench-results", row.id, row.measured_at)) } }
                } } }))
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
