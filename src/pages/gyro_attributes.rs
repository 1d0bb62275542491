//! `/gyros/{serial}/attributes`: batch, type and unit of a gyro, shown and edited.

use super::form::{ActionForm, Word, see_other};
use super::layout::joined;
use super::prelude::*;
use crate::core::gyro_attributes::{GyroAttributes, GyroAttributesPatch};
use crate::core::record::Name;
use crate::pipeline::{AttributesOrder, Submission};
use crate::wire::text;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Attributes {
    #[serde(flatten)]
    word: Word,
    batch: String,
    r#type: String,
    unit: String,
}

/// What is said of a gyro.
pub(super) fn line(t: &Text, attributes: &GyroAttributes) -> Markup {
    let said = [(t.batch, &attributes.batch), (t.gyro_type, &attributes.r#type), (t.gyro_unit, &attributes.unit)];
    let said: Vec<(&str, &String)> = said.into_iter().filter_map(|(of, word)| Some((of, word.as_ref()?))).collect();
    html! {
        @if !said.is_empty() {
            p.note {
                (joined(" · ", said.iter().map(|(of, word)| html! { (of) " " span translate="no" { (word) } })))
                @if let Some(batch) = &attributes.batch {
                    " (" a href={ "/fleet?batch=" (encoded(batch)) } { (t.gyros) } ")"
                }
            }
        }
    }
}

/// The way to change it.
pub(super) fn edit(viewer: &Viewer, serial: &str) -> Markup {
    html! {
        @if viewer.may(Role::Engineer) {
            p.no-print { a href={ "/gyros/" (encoded(serial)) "/attributes" } { (viewer.text().edit_attributes) } }
        }
    }
}

pub(super) async fn ask(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref serial): Path<String>,
) -> Result<Page, Problem> {
    let number = pages.gyro_number(serial)?;
    let found = pages.pipeline.queries.fleet.standing_in_words(number).await?;
    let (standing, _) = found.ok_or_else(|| Problem::unknown_gyro(serial))?;
    let GyroAttributes { batch, r#type, unit } = standing.attributes;
    let [batch, r#type, unit] = [batch, r#type, unit].map(Option::unwrap_or_default);
    let said = Attributes { word: Word::default(), batch, r#type, unit };
    Ok(form(viewer.text(), serial, &said).fresh(viewer, &said.word))
}

pub(super) async fn act(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref serial): Path<String>,
    Form(ref said): Form<Attributes>,
) -> Result<Response, Problem> {
    pages.gyro_number(serial)?;
    let name = Name::parse(serial).map_err(|_| Problem::unknown_gyro(serial))?;
    let mut faults = Faults::default();
    let mut word = |pointer: &str, word: &str| match word.trim() {
        "" => Some(None),
        word => Some(text::matched(pointer, word, &mut faults)),
    };
    let [batch, r#type, unit] = [("batch", &said.batch), ("type", &said.r#type), ("unit", &said.unit)]
        .map(|(pointer, said)| word(pointer, said));
    if !faults.is_empty() {
        return Ok(form(viewer.text(), serial, said).again(viewer, &said.word, &faults));
    }
    let patch = GyroAttributesPatch { batch, r#type, unit };
    let order = AttributesOrder { serial: name, patch };
    pages.pipeline.ingest.submit(Submission::Attributes(order)).await?;
    Ok(see_other(&format!("/gyros/{}", encoded(serial))))
}

fn form(t: &Text, serial: &str, said: &Attributes) -> ActionForm {
    let home = format!("/gyros/{}", encoded(serial));
    ActionForm {
        section: Section::Fleet,
        title: t.edit_attributes.into(),
        what: html! { p.lead translate="no" { (serial) } p { (t.edit_attributes_what) } },
        fields: html! {
            label { (t.batch) input name="batch" value=(said.batch) maxlength="64"; }
            label { (t.gyro_type) input name="type" value=(said.r#type) maxlength="64"; }
            label { (t.gyro_unit) input name="unit" value=(said.unit) maxlength="64"; }
        },
        action: format!("{home}/attributes"),
        button: t.edit_attributes,
        back: home,
        unreasoned: true,
        ..ActionForm::default()
    }
}
