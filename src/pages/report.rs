//! `/gyros/{serial}/report` and `/imus/{imu}/report`: one to put into the acceptance file; `/reports`: those on several
//! gyros, each on sheets of its own. Whole without scripts, plots drawn by the service; the style sheet keeps what
//! belongs together on one sheet of paper.

use std::collections::BTreeSet;
use std::time::Duration;

use tokio::time::Instant;

use super::gyro::{agreement, calibration_table, explained};
use super::gyro_facts::{Facts, MOST_ROWS};
use super::prelude::*;
use super::view::View;
use super::{alerts, before_after, gyro_head, history, history_plot, imu, verdicts};
use crate::core::judge::{Event, Limits};
use crate::core::kind::Kind;
use crate::pipeline::{ExplainedHistory, Names};
use crate::system;

/// Gyros of one page.
const MOST_GYROS: usize = 30;
/// How long a report waits for the diagnoses of all its histories: paper has no page to turn to.
const PATIENCE: Duration = Duration::from_secs(10);

pub(super) async fn gyro(
    PageContext(ref pages, ref viewer): PageContext,
    Path(serial): Path<String>,
) -> Result<Response, Problem> {
    Ok(viewer.show_for_paper(&of_gyro(pages, viewer, &serial, Instant::now() + PATIENCE).await?, &[&serial]))
}

pub(super) async fn imu(
    PageContext(ref pages, ref viewer): PageContext,
    Path(imu): Path<String>,
) -> Result<Response, Problem> {
    Ok(viewer.show_for_paper(&of_imu(pages, viewer, &imu).await?, &[&imu]))
}

pub(super) async fn several(
    PageContext(ref pages, ref viewer): PageContext,
    Query(asked): Query<Vec<(String, String)>>,
) -> Result<Response, Problem> {
    let serials = asked.iter().filter(|(name, _)| name == "gyro").map(|(_, serial)| serial.as_str());
    let serials: Vec<&str> = serials.take(MOST_GYROS).collect();
    let t = viewer.text();
    let until = Instant::now() + PATIENCE;
    let mut sheets = Vec::new();
    for serial in &serials {
        sheets.push(of_gyro(pages, viewer, serial, until).await?.body);
    }
    let body = html! {
        @if sheets.is_empty() { h1 { (t.reports) } p.lead { (t.none_selected) } }
        @for (k, sheet) in sheets.iter().enumerate() { section.{ "about" (k) }.sheet[k > 0] { (sheet) } }
    };
    let page = Page { title: t.reports.into(), section: Section::Fleet, body };
    Ok(viewer.show_for_paper(&page, &serials))
}

/// Of one gyro, with the cause of its changes where that is found by `until`.
async fn of_gyro(pages: &Pages, viewer: &Viewer, serial: &str, until: Instant) -> Result<Page, Problem> {
    let t = viewer.text();
    let number = pages.gyro_number(serial)?;
    let view = View::whole(pages.config.judging.method);
    let facts = Facts::of(pages, number, serial, &view, 0).await?;
    let explained = explained(pages, number, serial, &facts, until).await?;
    let hashes = hashes(pages, t, &facts).await?;
    let parameters = match facts.course.figures.last() {
        Some(newest) => imu::parameters_of(pages, t, newest.record, Some(serial)).await?,
        None => None,
    };
    let names = pages.pipeline.queries.names();
    let plots = history_plot::plots(t, serial, view, facts.seen(), &names, "");
    let count = facts.course.figures.len();
    let body = html! {
        article.report {
            section.decide {
                h1 { (t.report_of_gyro) " " (serial) " " (facts.badge(t)) }
                (as_of(pages, t))
                (identity(t, serial, &view, &facts, &names))
                (gyro_head::loads(t, &facts.stands(view.judged)))
                div.causes { (gyro_head::causes(t, &facts, explained.as_ref())) }
                (conclusion(t, &facts, explained.as_ref()))
                (plots.of(&[0, 1]))
                (plots.signs(t))
                div.beside { (limits(t, &facts.course.limits)) (hashes) }
                (boxes(t))
            }
            @if let Some(parameters) = parameters { section { h2 { (t.newest_parameters) } (parameters) } }
            section { h2 { (t.verdicts) } (verdicts::table(viewer, &facts.verdicts, &facts.alerts, None)) }
            section { h2 { (symbol("D_O")) ": " (t.meaning_d_o) } (plots.of(&[2])) }
            (before_after::section(t, &facts.course, view.judged))
            (agreement(t, serial, &facts.comparison))
            (history::happenings(t, &facts.course, &names))
            section {
                h2 { (t.calibrations) }
                p.note {
                    (t.newest_of) " " (count.min(MOST_ROWS)) " / " (count) ", " (t.method_of(view.shown.separation())) ", "
                    (t.unit)
                }
                @let rows = facts.course.figures.iter().rev().take(MOST_ROWS);
                (calibration_table(viewer, view.shown, &facts.statuses, rows, &names, false))
            }
        }
    };
    Ok(Page { title: format!("{} {serial}", t.report_of_gyro), section: Section::Fleet, body })
}

/// The newest record and those that made the baseline of D_I, as they were sent.
async fn hashes(pages: &Pages, t: &Text, facts: &Facts) -> Result<Markup, Problem> {
    let rows = &facts.course.figures;
    let made = facts.epochs[0].last().and_then(|epoch| epoch.made);
    let of_baseline = rows.iter().filter(|row| made.is_some_and(|(from, until)| from <= row.at && row.at <= until));
    let newest = rows.last().map(|row| (t.newest_record, row));
    let mut lines = Vec::new();
    for (what, row) in newest.into_iter().chain(of_baseline.map(|row| (t.baseline_record, row))) {
        if let Some(item) = pages.pipeline.queries.records.sent(row.record).await? {
            let sha256 = hex::encode(system::sha256(item.body.as_bytes()));
            lines.push(html! { tr {
                td { (what) } td { (instant(row.at)) }
                td { a href={ "/records/" (row.record) } { code { (row.record) } } } td { code { (sha256) } }
            } });
        }
    }
    Ok(html! {
        @if !lines.is_empty() {
            (wide_table("small", html! {
                th { (t.records_judged) } th { (t.calibrated) } th { (t.identifier) } th { "SHA-256" }
            }, html! { @for line in &lines { (line) } }))
        }
    })
}

/// What the verdicts suggest, and what was decided.
fn conclusion(t: &Text, facts: &Facts, explained: Option<&ExplainedHistory>) -> Markup {
    html! {
        (gyro_head::doubted(t, facts))
        (gyro_head::suggested(t, facts, explained))
        (gyro_head::decision(t, facts))
    }
}

/// Everything that the gyro is held to, each with the key that sets it.
fn limits(t: &Text, limits: &Limits) -> Markup {
    let of_rule = |rule: Rule| {
        let closure = limits.closure.filter(|_| rule == Rule::Closure);
        [limits.d_i.stated(rule), limits.d_s.stated(rule), closure]
    };
    let rules = Rule::ALL.map(|rule| (rule, of_rule(rule))).into_iter();
    html! { div {
        (wide_table("small", html! {
            th { (t.limits_in_force) } @for name in DRIFTS { th.n { (symbol(name)) } } th { (t.set_by) }
        }, html! {
            @for (rule, all) in rules.filter(|(_, all)| all.iter().any(Option::is_some)) {
                tr {
                    td { (t.rule(rule)) }
                    @for limit in &all { td.n { @if let Some(limit) = limit { (figure::limit(rule, *limit)) } } }
                    @let keys = all.iter().flatten().map(|limit| limit.from.to_string());
                    td { @for key in keys.collect::<BTreeSet<String>>() { code { (key) } " " } }
                }
            }
            @if let Some(limit) = &limits.interval_days {
                tr {
                    td { (t.rule(Rule::Overdue)) } td.n colspan="3" { (limit.value) " " (t.days) }
                    td { code { (limit.from) } }
                }
            }
        }))
        p.note { (t.unit) " · " (t.confidence_word) " " (figure::percent(limits.confidence)) }
    } }
}

/// To be ticked and signed by hand.
fn boxes(t: &Text) -> Markup {
    let decisions = [Event::DecisionRelease, Event::DecisionRetest, Event::DecisionRemove];
    html! {
        div.boxes {
            @for event in decisions { span { span.tick {} (t.event(event)) } }
        }
        p.signature { (t.reason_word) ":" }
        p.signature { (t.signature) ":" }
    }
}

async fn of_imu(pages: &Pages, viewer: &Viewer, name: &str) -> Result<Page, Problem> {
    let t = viewer.text();
    let found = imu::Facts::of(pages, viewer, name).await?;
    let view = View::whole(pages.config.judging.method);
    let until = Instant::now() + PATIENCE;
    let mut gyros = Vec::new();
    for standing in &found.seats.now {
        let facts = Facts::of(pages, standing.number, &standing.serial, &view, 0).await?;
        let explained = explained(pages, standing.number, &standing.serial, &facts, until).await?;
        gyros.push((standing.serial.clone(), facts, explained));
    }
    let names = pages.pipeline.queries.names();
    let campaigns = found.records.iter().filter(|head| head.kind == Kind::Campaign).count();
    let body = html! {
        article.report {
            h1 { (t.report_of_imu) " " (name) }
            (as_of(pages, t))
            section {
                h2 { (t.identity) }
                dl.facts {
                    dt { (t.imu) } dd { (name) }
                    @if let Some(newest) = found.records.first() {
                        dt { (t.calibrated) } dd { (instant(newest.calibrated_at)) }
                    }
                    dt { (t.records_word) } dd { (found.records.len()) " (" (t.kind_campaign) ": " (campaigns) ")" }
                    dt { (t.judged_by) } dd { (t.method_of(view.shown.separation())) }
                }
            }
            @if !found.alerts.is_empty() { (alerts::table(viewer, found.alerts.iter(), false, None)) }
            (imu::seated(pages, t, &found.seats))
            @if let Some(newest) = &found.parameters { section { h2 { (t.newest_parameters) } (newest) } }
            @for (serial, facts, explained) in &gyros {
                section.sheet {
                    h2 { (t.serial) " " (serial) " " (facts.badge(t)) }
                    (gyro_head::loads(t, &facts.stands(view.judged)))
                    (conclusion(t, facts, explained.as_ref()))
                    (limits(t, &facts.course.limits))
                    (verdicts::table(viewer, &facts.verdicts, &facts.alerts, None))
                    @let plots = history_plot::plots(t, serial, view, facts.seen(), &names, &format!("-{serial}"));
                    (plots.of(&[0, 1, 2])) (plots.signs(t))
                    (before_after::section(t, &facts.course, pages.config.judging.method))
                    (agreement(t, serial, &facts.comparison))
                    (history::happenings(t, &facts.course, &names))
                }
            }
            p.signature { (t.signature) ":" }
        }
    };
    Ok(Page { title: format!("{} {name}", t.report_of_imu), section: Section::Fleet, body })
}

pub(super) fn as_of(pages: &Pages, t: &Text) -> Markup {
    html! { p.note { (t.printed_at) " " (instant(pages.clock.now())) " · gyrowatch " (env!("CARGO_PKG_VERSION")) } }
}

fn identity(t: &Text, serial: &str, view: &View, facts: &Facts, names: &Names<'_>) -> Markup {
    html! {
        dl.facts {
            dt { (t.serial) } dd { (serial) }
            @if let Some(newest) = facts.course.figures.last() {
                dt { (t.imu) } dd { (history::seat(newest, names)) }
                dt { (t.station) } dd { (names.station(newest.station)) }
                dt { (t.calibrated) } dd { (instant(newest.at)) }
            } @else { dt { (t.calibrated) } dd { (t.never_calibrated) } }
            dt { (t.records_word) } dd { (facts.course.figures.len()) }
            dt { (t.judged_by) } dd { (t.method_of(view.shown.separation())) }
        }
    }
}
