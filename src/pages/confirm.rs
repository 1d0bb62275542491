//! `/records/{id}/confirm`: the time of a record that was set aside is right, said on a page that shows what it is
//! about.

use axum::Form;
use axum::extract::{Path, Query, State as Held};
use axum::response::Response;
use maud::{Markup, html};

use super::Pages;
use super::form::{Deed, Word, answered, see_other};
use super::layout::{Section, instant};
use super::notes::noted;
use super::viewer::Viewer;
use crate::core::fault::Faults;
use crate::core::id::Id;
use crate::core::message::text;
use crate::message;
use crate::pipeline::{Actor, Confirmation, Submission};
use crate::wire::note;
use crate::wire::problem::Problem;

/// What is to be confirmed, as it is shown to whoever is about to.
struct Item {
    id: Id,
    home: String,
    action: String,
    shown: Markup,
}

pub(super) async fn ask(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path(id): Path<String>,
    Query(word): Query<Word>,
) -> Response {
    let item = item(&pages, &viewer, &id).await;
    viewer.show(item.map(|item| form(&viewer, &item, &word).fresh(&viewer, &word)))
}

pub(super) async fn act(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Path(id): Path<String>,
    Form(word): Form<Word>,
) -> Response {
    let item = item(&pages, &viewer, &id).await;
    answered(&viewer, confirm(&pages, &viewer, item, word).await)
}

async fn confirm(pages: &Pages, viewer: &Viewer, item: Result<Item, Problem>, word: Word) -> Result<Response, Problem> {
    let item = item?;
    let mut faults = Faults::default();
    word.check(viewer, &mut faults);
    if !faults.is_empty() {
        return Ok(form(viewer, &item, &word).again(viewer, &word, &faults));
    }
    let home = word.back_or(&item.home).to_owned();
    let Word { by: author, reason, .. } = word;
    let confirmation = Confirmation { id: item.id, author, reason, by: Actor::by_caller() };
    pages.pipeline.ingest.submit(Submission::Confirmation(confirmation)).await?;
    Ok(see_other(&home))
}

async fn item(pages: &Pages, viewer: &Viewer, id: &str) -> Result<Item, Problem> {
    let unknown = || Problem::no_such_record(id);
    let number: Id = id.parse().map_err(|_| unknown())?;
    let records = &pages.pipeline.queries.records;
    let item = records.sent(number).await?.ok_or_else(unknown)?;
    if !records.status(number).await?.set_aside {
        let detail = message!("not_set_aside", id = text(number));
        return Err(Problem::new(409, "title_not_set_aside", detail));
    }
    let t = viewer.text();
    let shown = html! {
        p.lead {
            (item.imu) " · " (t.station) " " (item.station)
            " · " (t.calibrated) " " (instant(item.calibrated_at)) " · " (t.received) " " (instant(item.received_at))
        }
        (noted(t, &note::read(item.notes.as_deref())))
    };
    Ok(Item { id: number, home: format!("/records/{number}"), action: format!("/records/{number}/confirm"), shown })
}

fn form(viewer: &Viewer, item: &Item, word: &Word) -> Deed {
    let t = viewer.text();
    Deed {
        section: Section::Fleet,
        title: t.confirm_time.into(),
        what: html! { (item.shown) p.lead { (t.confirm_what) } },
        fields: html! {},
        action: item.action.clone(),
        button: t.confirm_time,
        back: word.back_or(&item.home).to_owned(),
        reasoned: true,
    }
}
