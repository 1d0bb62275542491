//! `/records/{id}/confirm`: the time of a record that was set aside is right, said on a page that shows what it is
//! about.

use super::form::{ActionForm, ItemAction, Word, see_other};
use super::layout::noted;
use super::prelude::*;
use crate::core::message::text;
use crate::pipeline::{Confirmation, Submission};
use crate::wire::note;

/// Of a record that is set aside.
pub(super) struct ConfirmTime;

impl ItemAction for ConfirmTime {
    type Item = Id;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, word: &Word) -> Result<(Id, ActionForm), Problem> {
        let number = problem::id(id, Problem::no_such_record)?;
        let records = &pages.pipeline.queries.records;
        let item = records.sent(number).await?.ok_or_else(|| Problem::no_such_record(id))?;
        if !records.status(number).await?.set_aside {
            let detail = message!("not_set_aside", id = text(number));
            return Err(Problem::new(409, "title_not_set_aside", detail));
        }
        let (t, names) = (viewer.text(), pages.pipeline.queries.names());
        let form = ActionForm {
            section: Section::Fleet,
            title: t.confirm_time.into(),
            what: html! {
                p.lead {
                    (names.imu(item.imu)) " · " (t.station) " " (names.station(item.station))
                    " · " (t.calibrated) " " (instant(item.calibrated_at)) " · " (t.received) " " (instant(item.received_at))
                }
                (noted(t, &note::read(item.notes.as_deref())))
                p.lead { (t.confirm_what) }
            },
            action: format!("/records/{number}/confirm"),
            button: t.confirm_time,
            back: word.back_or(&format!("/records/{number}")).to_owned(),
            ..ActionForm::default()
        };
        Ok((number, form))
    }

    async fn run(pages: &Pages, id: Id, form: ActionForm, word: Word) -> Result<Response, Problem> {
        let confirmation = Confirmation { id, of_window: false, author: word.by, reason: word.reason, restated: None };
        pages.pipeline.ingest.submit(Submission::Confirmation(confirmation)).await?;
        Ok(see_other(&form.back))
    }
}
