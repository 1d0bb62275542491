//! `/gyros/{serial}/diagnosis`: why a gyro's coefficients changed, with the common course of its stations under its
//! own.

use super::course::CoefficientSeries;
use super::gyro_head::{named, own_first};
use super::prelude::*;
use crate::core::changes::{DriftBudget, HistoryDiagnosis};
use crate::pipeline::ExplainedHistory;

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref serial): Path<String>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let number = pages.gyro_number(serial)?;
    let explained = pages.pipeline.queries.histories.explain(number, serial).await?;
    let body = html! {
        h1 { (serial) ": " (t.history_diagnosis) }
        p.lead {
            a href={ "/gyros/" (encoded(serial)) } { (serial) }
            " · " (t.peers_of_stations) " " (explained.peers)
            " · " a href={ "/v1/gyros/" (encoded(serial)) "/diagnosis" } { "JSON" }
        }
        @for (answer, budget) in explained.coefficients.iter().zip(explained.budgets) {
            (section(t, serial, (answer, budget), &explained))
        }
    };
    Ok(Page { title: format!("{serial}: {}", t.history_diagnosis), section: Section::Fleet, body })
}

fn section(
    t: &Text,
    serial: &str,
    (answer, budget): (&HistoryDiagnosis, Option<DriftBudget>),
    explained: &ExplainedHistory,
) -> Markup {
    let name = answer.coefficient.name();
    html! {
        section id=(name) {
            h2 { (symbol(name)) }
            p.lead.capital { (named(t, answer)) (t.words(&answer.opening())) }
            @for said in answer.besides(explained.as_of).into_iter().chain(answer.looked_at(explained.as_of.records)) {
                p { (t.words(&said)) }
            }
            (drawn(t, serial, answer, budget))
            @if !answer.causes.is_empty() {
                (wide_table("cards", html! {
                    th { (t.cause) } th { (t.tied_to) } th.n { (t.estimate) } th { (t.unit_word) }
                    th.n { (t.change_closed) } th.n { (t.adjusted_p) }
                }, html! { @for cause in own_first(answer) { tr {
                    th scope="row" { (t.words(&cause.cause.word())) }
                    td data-label=(t.tied_to) {
                        (t.words(&cause.tie.message()))
                        @if let Some(others) = cause.others() { ". " (t.words(&others)) }
                    }
                    td.n data-label=(t.estimate) { (figure::signed_drift(cause.estimate.value, Some(cause.estimate.sd))) }
                    td data-label=(t.unit_word) { (t.unit_of(cause.estimate.unit)) }
                    td.n data-label=(t.change_closed) { @if let Some(held_out) = cause.held_out { (figure::share(held_out.closure, Some(held_out.interval))) } }
                    td.n data-label=(t.adjusted_p) { (format!("{:.1e}", cause.p_value_adjusted)) }
                } } }))
            }
            @if !answer.rejected.is_empty() {
                details {
                    summary { (t.ruled_out) " (" (answer.rejected.len()) ")" }
                    (wide_table("cards", html! {
                        th { (t.cause) } th { (t.tied_to) } th { (t.why) }
                    }, html! { @for one in &answer.rejected { tr {
                        th scope="row" { (t.words(&one.cause.word())) }
                        td data-label=(t.tied_to) { (t.words(&one.tie.message())) }
                        td data-label=(t.why) { (t.words(&one.why.message())) }
                    } } }))
                }
            }
        }
    }
}

/// The records about their baseline, what explains them, and what the stations did under it.
fn drawn(t: &Text, serial: &str, answer: &HistoryDiagnosis, budget: Option<DriftBudget>) -> Markup {
    let n = answer.course.len().max(1) as f64;
    let mean = answer.course.iter().map(|one| one.measured.value).sum::<f64>() / n;
    let zero = budget.map_or(mean, |budget| budget.baseline);
    let of_stations = answer.course.iter().any(|one| one.station != 0.0);
    let station = of_stations.then(|| answer.course.iter().map(|one| (one.at, one.station)).collect());
    let explained: Vec<(UtcMicros, f64)> = answer.course.iter().map(|one| (one.at, one.explained - zero)).collect();
    let explained = (!answer.causes.is_empty()).then_some(("explained", explained));
    let course = CoefficientSeries {
        symbol: answer.coefficient.name(),
        name: serial,
        budget: budget.map(|budget| budget.limit),
        points: answer.course.iter().map(|one| (one.at, one.measured.value - zero, one.measured.sd)).collect(),
        lines: explained.into_iter().chain(station.map(|line| ("station", line))).collect(),
        marks: answer.outliers.iter().map(|one| (one.at, t.outlier.to_owned())).collect(),
    };
    html! {
        (course.markup(t))
        @if !answer.course.is_empty() {
            p.note {
                @if budget.is_none() { (t.about_mean) }
                @if !answer.causes.is_empty() { " " (t.line_explained) }
                @if of_stations { " " (t.line_station) }
            }
        }
    }
}
