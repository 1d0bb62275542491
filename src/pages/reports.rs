//! `/reports`: the reports on several gyros, each on sheets of its own.

use axum::extract::State as Held;
use axum::response::Response;
use maud::html;

use super::Pages;
use super::layout::{Page, Section};
use super::report;
use super::viewer::Viewer;
use crate::pages::sent::Query;
use crate::wire::problem::Problem;

/// Gyros of one page.
const MOST: usize = 30;

pub(super) async fn page(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Query(asked): Query<Vec<(String, String)>>,
) -> Response {
    let serials = asked.iter().filter(|(name, _)| name == "gyro").map(|(_, serial)| serial.as_str());
    let serials: Vec<&str> = serials.take(MOST).collect();
    viewer.show_for_paper(build(&pages, &viewer, &serials).await, &serials)
}

async fn build(pages: &Pages, viewer: &Viewer, serials: &[&str]) -> Result<Page, Problem> {
    let t = viewer.text();
    let mut sheets = Vec::new();
    for serial in serials {
        sheets.push(report::of_gyro(pages, viewer, serial).await?.body);
    }
    let body = html! {
        @if sheets.is_empty() { h1 { (t.reports) } p.lead { (t.none_selected) } }
        @for (k, sheet) in sheets.iter().enumerate() { section.{ "about" (k) }.sheet[k > 0] { (sheet) } }
    };
    Ok(Page { title: t.reports.into(), section: Section::Fleet, body })
}
