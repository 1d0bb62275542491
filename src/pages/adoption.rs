//! `/campaigns/{id}/adopt`: what the diagnosis of a campaign names enters the model of its IMU.
//! `/imus/{imu}/model/undo`: the model before the newest is in force again.

use std::sync::Arc;

use axum::extract::Path;
use axum::response::Response;
use maud::html;

use super::Pages;
use super::calibration::stored_campaign;
use super::diagnosis::PATIENCE;
use super::diagnosis::sections::found;
use super::forecast::held;
use super::form::{Deed, Word, see_other};
use super::layout::{Page, Section, encoded, instant};
use super::viewer::{Viewer, Visit};
use crate::core::augmented::AugmentedModel;
use crate::core::id::Id;
use crate::core::message::text;
use crate::pages::sent::{Form, Query};
use crate::pipeline::{Adoption, DiagnosisAnswer};
use crate::wire::problem::Problem;
use crate::{message, words};

pub(super) async fn ask(
    Visit { ref pages, ref viewer }: Visit,
    Path(id): Path<String>,
    Query(word): Query<Word>,
) -> Result<Page, Problem> {
    let (_, form) = named(pages, viewer, &id, &word).await?;
    Ok(form.fresh(viewer, &word))
}

pub(super) async fn adopt(
    Visit { ref pages, ref viewer }: Visit,
    Path(id): Path<String>,
    Form(word): Form<Word>,
) -> Result<Response, Problem> {
    let (id, form) = named(pages, viewer, &id, &word).await?;
    if let Some(again) = form.incomplete(viewer, &word) {
        return Ok(again);
    }
    let adoption = pages.pipeline.diagnoses.adoption(id, word.by, word.reason).await?;
    put(pages, adoption.ok_or_else(|| nothing_named(id))?).await
}

/// A campaign whose diagnosis names something, and the form that asks whether that is to be adopted.
async fn named(pages: &Pages, viewer: &Viewer, id: &str, word: &Word) -> Result<(Id, Deed), Problem> {
    let t = viewer.text();
    let stored = stored_campaign(pages, id).await?;
    let number = stored.item.id;
    let answer = pages.pipeline.diagnoses.of_campaign(number, PATIENCE).await?;
    let diagnosis = match &answer {
        DiagnosisAnswer::Answered(diagnosed) => diagnosed.as_ref().as_ref().ok(),
        DiagnosisAnswer::NoSuchCampaign | DiagnosisAnswer::Waiting => None,
    };
    let diagnosis = diagnosis.filter(|diagnosis| !diagnosis.effects.is_empty()).ok_or_else(|| nothing_named(number))?;
    let diagnosis = diagnosis.clone().said_in(words::asked());
    let form = Deed {
        section: Section::Fleet,
        title: format!("{} · {}", t.adopt, stored.answer.imu),
        what: html! {
            p.lead { (t.campaign) " " (t.measured) " " (instant(stored.item.calibrated_at)) ": " (diagnosis.verdict_in_words(t.language())) }
            (found(t, &diagnosis))
            p { (t.adopt_what) }
        },
        fields: html! {},
        action: format!("/campaigns/{number}/adopt"),
        button: t.adopt,
        back: word.back_or(&format!("/campaigns/{number}/diagnosis")).to_owned(),
        reasoned: true,
        is_final: false,
    };
    Ok((number, form))
}

fn nothing_named(id: Id) -> Problem {
    Problem::new(409, "title_nothing_to_adopt", message!("nothing_to_adopt", id = text(id)))
}

/// Puts it in force and goes on with the models of the IMU.
async fn put(pages: &Pages, adoption: Adoption) -> Result<Response, Problem> {
    let home = format!("/imus/{}#models", encoded(&adoption.imu));
    pages.pipeline.diagnoses.adopt(adoption).await?;
    Ok(see_other(&home))
}

pub(super) async fn ask_undo(
    Visit { ref pages, ref viewer }: Visit,
    Path(imu): Path<String>,
    Query(word): Query<Word>,
) -> Result<Page, Problem> {
    let (_, form) = before(pages, viewer, &imu, &word).await?;
    Ok(form.fresh(viewer, &word))
}

pub(super) async fn undo(
    Visit { ref pages, ref viewer }: Visit,
    Path(imu): Path<String>,
    Form(word): Form<Word>,
) -> Result<Response, Problem> {
    let (model, form) = before(pages, viewer, &imu, &word).await?;
    if let Some(again) = form.incomplete(viewer, &word) {
        return Ok(again);
    }
    put(pages, Adoption { imu, model, author: word.by, reason: word.reason }).await
}

/// The model before the newest, the plain one where there was none, and the form that asks whether it is to hold again.
async fn before(
    pages: &Pages,
    viewer: &Viewer,
    imu: &str,
    word: &Word,
) -> Result<(Arc<AugmentedModel>, Deed), Problem> {
    let t = viewer.text();
    let models = pages.pipeline.diagnoses.models(imu).await?;
    let unknown = || Problem::new(404, "title_unknown_imu", pages.pipeline.queries.names().unknown_imu(imu));
    let models = models.ok_or_else(unknown)?;
    let newest = models.first().ok_or_else(|| {
        Problem::new(409, "title_nothing_to_adopt", message!("no_model_to_undo", imu = imu.to_owned()))
    })?;
    let model = models.get(1).map_or_else(Arc::default, |before| Arc::clone(&before.model));
    let form = Deed {
        section: Section::Fleet,
        title: format!("{} · {imu}", t.undo_model),
        what: html! {
            p.lead { (t.in_force) ": " code translate="no" { (held(t, &newest.model)) } }
            p.lead { (t.in_force_again) ": " code translate="no" { (held(t, &model)) } }
            p { (t.undo_model_what) }
        },
        fields: html! {},
        action: format!("/imus/{}/model/undo", encoded(imu)),
        button: t.undo_model,
        back: word.back_or(&format!("/imus/{}#models", encoded(imu))).to_owned(),
        reasoned: true,
        is_final: false,
    };
    Ok((model, form))
}
