//! `/gyros/{serial}/report` and `/imus/{imu}/report`: one to put into the acceptance file. Whole without scripts, its
//! plots drawn by the service; the style sheet keeps what belongs together on one sheet of paper.

use axum::extract::{Path, State as Held};
use axum::response::Response;
use maud::{Markup, html};

use super::gyro::{Facts, agreement, calibration_table, known};
use super::layout::{Page, Section, instant, symbol};
use super::viewer::Viewer;
use super::{Pages, alerts, before_after, chart, figure, imu, verdicts};
use crate::core::judge::Rule;
use crate::core::kind::Kind;
use crate::pages::history;
use crate::pages::history::Shown;
use crate::wire::problem::Problem;

/// Calibrations that a report on a gyro lists; all are in its pictures.
const ROWS: usize = super::gyro::MOST_ROWS;

pub(super) async fn gyro(Held(pages): Held<Pages>, viewer: Viewer, Path(serial): Path<String>) -> Response {
    viewer.show(of_gyro(&pages, &viewer, &serial).await)
}

pub(super) async fn imu(Held(pages): Held<Pages>, viewer: Viewer, Path(imu): Path<String>) -> Response {
    viewer.show(of_imu(&pages, &viewer, &imu).await)
}

pub(super) async fn of_gyro(pages: &Pages, viewer: &Viewer, serial: &str) -> Result<Page, Problem> {
    let t = viewer.text();
    let number = known(pages, serial)?;
    let shown = Shown::asked(None, pages.config.judging.method);
    let facts = Facts::of(pages, number, serial, shown, 0).await?;
    let names = pages.pipeline.queries.names();
    let count = facts.course.figures.len();
    let body = html! {
        article.report {
            h1 { (t.report_of_gyro) " " (serial) " " (facts.badge(t)) }
            (as_of(pages, viewer))
            section { h2 { (t.identity) } (identity(viewer, serial, shown, &facts, &names)) }
            section { h2 { (t.verdicts) } (verdicts::all(viewer, &facts.verdicts)) }
            section { h2 { (t.history) } p.note { (t.report_plot_note) } (chart::strips(&history::plot(viewer, serial, shown, facts.plotted(), &names))) }
            (before_after::section(viewer, &facts.course, pages.config.judging.method))
            (agreement(viewer, serial, &facts.comparison))
            (history::happenings(viewer, &facts.course, &names))
            (open_alerts(viewer, &facts))
            section {
                h2 { (t.calibrations) }
                p.note { (t.newest_of) " " (count.min(ROWS)) " / " (count) ", " (t.method_of(shown.separation())) ", " (t.unit) }
                (calibration_table(viewer, shown, &facts.statuses, facts.course.figures.iter().rev().take(ROWS), &names, false))
            }
            (signature(viewer))
        }
    };
    Ok(Page { title: format!("{} {serial}", t.report_of_gyro), section: Section::Fleet, plots: false, body })
}

async fn of_imu(pages: &Pages, viewer: &Viewer, name: &str) -> Result<Page, Problem> {
    let t = viewer.text();
    let found = imu::Facts::of(pages, viewer, name).await?;
    let shown = Shown::asked(None, pages.config.judging.method);
    let mut gyros = Vec::new();
    for standing in &found.seats.now {
        gyros.push((standing.serial.clone(), Facts::of(pages, standing.number, &standing.serial, shown, 0).await?));
    }
    let names = pages.pipeline.queries.names();
    let campaigns = found.records.iter().filter(|head| head.kind == Kind::Campaign).count();
    let body = html! {
        article.report {
            h1 { (t.report_of_imu) " " (name) }
            (as_of(pages, viewer))
            section {
                h2 { (t.identity) }
                dl.facts {
                    dt { (t.imu) } dd { (name) }
                    @if let Some(newest) = found.records.first() { dt { (t.calibrated) } dd { (instant(newest.calibrated_at)) } }
                    dt { (t.records_word) } dd { (found.records.len()) " (" (t.kind_campaign) ": " (campaigns) ")" }
                    dt { (t.judged_by) } dd { (t.method_of(shown.separation())) }
                }
            }
            (imu::seated(pages, t, &found.seats))
            @if let Some(newest) = &found.parameters { section { h2 { (t.newest_parameters) } (newest) } }
            @for (serial, facts) in &gyros {
                section.sheet {
                    h2 { (t.serial) " " (serial) " " (facts.badge(t)) }
                    (verdicts::all(viewer, &facts.verdicts))
                    (chart::strips(&history::plot(viewer, serial, shown, facts.plotted(), &names)))
                    (before_after::section(viewer, &facts.course, pages.config.judging.method))
                    (agreement(viewer, serial, &facts.comparison))
                    (history::happenings(viewer, &facts.course, &names))
                    (open_alerts(viewer, facts))
                }
            }
            (signature(viewer))
        }
    };
    Ok(Page { title: format!("{} {name}", t.report_of_imu), section: Section::Fleet, plots: false, body })
}

fn as_of(pages: &Pages, viewer: &Viewer) -> Markup {
    html! { p.note { (viewer.text().printed_at) " " (instant(pages.clock.now())) " · gyrowatch " (env!("CARGO_PKG_VERSION")) } }
}

fn identity(viewer: &Viewer, serial: &str, shown: Shown, facts: &Facts, names: &crate::pipeline::Names<'_>) -> Markup {
    let t = viewer.text();
    let limits = &facts.course.limits;
    let budgets =
        [("D_I", limits.d_i.of(Rule::Baseline)), ("D_S", limits.d_s.of(Rule::Baseline)), ("D_O", limits.closure)];
    html! {
        dl.facts {
            dt { (t.serial) } dd { (serial) }
            @if let Some(newest) = facts.course.figures.last() {
                dt { (t.imu) } dd { (history::seat(newest, names)) }
                dt { (t.station) } dd { (names.station(newest.station)) }
                dt { (t.calibrated) } dd { (instant(newest.at)) }
            } @else { dt { (t.calibrated) } dd { (t.never_calibrated) } }
            dt { (t.records_word) } dd { (facts.course.figures.len()) }
            dt { (t.judged_by) } dd { (t.method_of(shown.separation())) }
            dt { (t.budget_word) }
            dd {
                @for (name, budget) in budgets {
                    @if let Some(budget) = budget { span.nowrap { (symbol(name)) " ± " (figure::short(budget.value)) } " (" code { (budget.from) } ") " }
                }
                (t.unit)
            }
        }
    }
}

fn open_alerts(viewer: &Viewer, facts: &Facts) -> Markup {
    let t = viewer.text();
    html! {
        section {
            h2 { (t.alerts_open) }
            @if facts.alerts.is_empty() { p { (t.no_open_alerts) } }
            @else { (alerts::table(viewer, facts.alerts.iter(), false, None)) }
        }
    }
}

fn signature(viewer: &Viewer) -> Markup {
    html! { p.signature { (viewer.text().signature) ":" } }
}
