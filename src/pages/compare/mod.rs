//! `/compare`: 2 to 8 gyros over one another (`?gyro=A&gyro=B`), or two campaigns side by side
//! (`?campaign=A&campaign=B`).

mod campaigns;
mod gyros;

use super::prelude::*;
use super::report;

/// Gyros at the most: more lines than that are told apart by nobody.
const MOST_GYROS: usize = 8;

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Query(asked): Query<Vec<(String, String)>>,
) -> Result<Response, Problem> {
    let of = |key: &str| -> Vec<&str> {
        let mut found: Vec<&str> = Vec::new();
        for (name, value) in &asked {
            if name == key && !value.is_empty() && !found.contains(&value.as_str()) {
                found.push(value);
            }
        }
        found
    };
    let (gyros, campaigns) = (of("gyro"), of("campaign"));
    let aligned = of("align").contains(&"baseline");
    let page = match campaigns.as_slice() {
        [a, b] if gyros.is_empty() => campaigns::page(pages, viewer, [*a, *b]).await?,
        [] if (2..=MOST_GYROS).contains(&gyros.len()) => gyros::page(pages, viewer, &gyros, aligned).await?,
        _ => return Err(Problem::new(400, "title_bad_query", message!("compare_what", most = MOST_GYROS))),
    };
    let body = html! { (page.body) div.on-paper { (report::as_of(pages, viewer.text())) } };
    Ok(viewer.show_for_paper(&Page { body, ..page.clone() }, &[&page.title]))
}
