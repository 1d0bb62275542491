//! `/stations/{name}/suspect` and `/stations/{name}/trust`: what a station measured in a window of time does not count,
//! and counts again.

use super::form::{ActionForm, Word, see_other, typed_time};
use super::prelude::*;
use crate::core::suspect_window::{Mark, SuspectWindow};
use crate::pipeline::WindowMark;
use crate::wire::text;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Window {
    #[serde(flatten)]
    word: Word,
    from: String,
    to: String,
}

/// The page on which a window is suspected, or with `TRUSTED` trusted again.
pub(super) async fn ask<const TRUSTED: bool>(
    PageContext(ref pages, ref viewer): PageContext,
    Path(name): Path<String>,
    Query(window): Query<Window>,
) -> Result<Page, Problem> {
    known(pages, &name).await?;
    Ok(form(viewer.text(), &name, &window, TRUSTED).fresh(viewer, &window.word))
}

async fn known(pages: &Pages, name: &str) -> Result<(), Problem> {
    let is_known = pages.pipeline.queries.is_station(name).await?;
    is_known.then_some(()).ok_or_else(|| Problem::no_such_station(name))
}

pub(super) async fn act<const TRUSTED: bool>(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref name): Path<String>,
    Form(ref said): Form<Window>,
) -> Result<Response, Problem> {
    known(pages, name).await?;
    let mut faults = Faults::default();
    said.word.check(&mut faults);
    let span = text::span(("from", &typed_time(&said.from)), ("to", &typed_time(&said.to)), &mut faults);
    if !faults.is_empty() {
        return Ok(form(viewer.text(), name, said, TRUSTED).again(viewer, &said.word, &faults));
    }
    let Word { by: author, reason, .. } = said.word.clone();
    let mark = Mark { window: SuspectWindow { span, author, reason }, trusted: TRUSTED };
    let mark = WindowMark { station: name.to_owned(), mark };
    match pages.pipeline.mark_window(mark).await?.refused.into_iter().next() {
        Some((_, why)) => Err(why.into()),
        None => Ok(see_other(&format!("/stations/{}", encoded(name)))),
    }
}

fn form(t: &Text, name: &str, said: &Window, trusted: bool) -> ActionForm {
    let (title, what, path) =
        if trusted { (t.trust_window, t.trust_what, "trust") } else { (t.suspect_window, t.suspect_what, "suspect") };
    let home = format!("/stations/{}", encoded(name));
    ActionForm {
        section: Section::Stations,
        title: title.into(),
        what: html! { p.lead { (t.station) " " span translate="no" { (name) } } p { (what) } },
        fields: html! {
            label { (t.window_from) input name="from" value=(said.from) required data-time placeholder="2026-06-01 08:00"; }
            label { (t.window_to) input name="to" value=(said.to) required data-time placeholder="2026-06-08 18:00"; }
        },
        action: format!("{home}/{path}"),
        button: title,
        back: home,
        ..ActionForm::default()
    }
}
