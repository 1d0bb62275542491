//! `/reports`: the reports on several gyros, each on sheets of its own.

use tokio::time::Instant;

use super::prelude::*;
use super::report;

/// Gyros of one page.
const MOST: usize = 30;

pub(super) async fn page(
    Visit(ref pages, ref viewer): Visit,
    Query(asked): Query<Vec<(String, String)>>,
) -> Result<Response, Problem> {
    let serials = asked.iter().filter(|(name, _)| name == "gyro").map(|(_, serial)| serial.as_str());
    let serials: Vec<&str> = serials.take(MOST).collect();
    let t = viewer.text();
    let until = Instant::now() + report::PATIENCE;
    let mut sheets = Vec::new();
    for serial in &serials {
        sheets.push(report::of_gyro(pages, viewer, serial, until).await?.body);
    }
    let body = html! {
        @if sheets.is_empty() { h1 { (t.reports) } p.lead { (t.none_selected) } }
        @for (k, sheet) in sheets.iter().enumerate() { section.{ "about" (k) }.sheet[k > 0] { (sheet) } }
    };
    let page = Page { title: t.reports.into(), section: Section::Fleet, body };
    Ok(viewer.show_for_paper(&page, &serials))
}
