//! A document of the import page takes the place of the one that is stored for its IMU and time.

use axum::Extension;

use super::logs::Sent;
use super::{framed, off_the_loop, read_all};
use crate::core::kind::Kind;
use crate::pages::form::{Word, fault_list, see_other};
use crate::pages::prelude::*;
use crate::pipeline::{Accepted, Caller, Corrected, Correction, Submission};

/// The right document, and which one it replaces.
#[derive(Deserialize)]
pub(in crate::pages) struct Order {
    id: String,
    text: String,
    #[serde(flatten)]
    word: Word,
}

pub(in crate::pages) async fn act(
    PageContext(ref pages, ref viewer): PageContext,
    Extension(caller): Extension<Caller>,
    Form(order): Form<Order>,
) -> Result<Response, Problem> {
    let mut faults = Faults::default();
    order.word.check(&mut faults);
    order.word.check_meant(viewer, &mut faults);
    let (pipeline, text) = (pages.pipeline.clone(), order.text.clone());
    let read = off_the_loop(move || read_all(&pipeline, &caller, &text)).await;
    let mut read = read.into_iter().map(|(_, read)| read);
    let new = match (read.next(), read.next()) {
        (Some(Ok(Submission::Calibration(new))), None) => Some(*new),
        (Some(Err(of_text)), None) => {
            faults.absorb("", of_text);
            None
        }
        _ => {
            faults.push("", message!("not_one_calibration"));
            None
        }
    };
    let id = problem::id(&order.id, Problem::no_such_record)?;
    let (Some(new), true) = (new, faults.is_empty()) else {
        let sent = Sent { text: order.text, ..Sent::default() };
        return Ok(framed(viewer.text(), &sent, fault_list(viewer.text(), &faults)).into_response());
    };
    let place = if new.kind == Kind::Campaign { "campaigns" } else { "records" };
    let item = Corrected::Calibration { id, kind: None };
    let Word { by: author, reason, .. } = order.word;
    let correction = Correction { item, author, reason, replacement: Some(new) };
    match pages.pipeline.ingest.submit(Submission::Correction(Box::new(correction))).await? {
        Accepted::Stored { id, .. } | Accepted::There { id, .. } => Ok(see_other(&format!("/{place}/{id}"))),
    }
}
