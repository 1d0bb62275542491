//! `/campaigns/{id}/adopt`: what the diagnosis of a campaign names enters the model of its IMU.
//! `/imus/{imu}/model/undo`: the model before the newest is in force again.

use std::sync::Arc;

use super::calibration::stored_campaign;
use super::diagnosis::PATIENCE;
use super::diagnosis::sections::found;
use super::forecast::held;
use super::form::{ActionForm, ItemAction, Word, see_other};
use super::prelude::*;
use crate::core::augmented::AugmentedModel;
use crate::core::message::text;
use crate::pipeline::{Adoption, DiagnosisAnswer};
use crate::words;

/// Of a campaign whose diagnosis names something.
pub(super) struct Adopt;

impl ItemAction for Adopt {
    type Item = Id;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, word: &Word) -> Result<(Id, ActionForm), Problem> {
        let t = viewer.text();
        let stored = stored_campaign(pages, id).await?;
        let number = stored.item.id;
        let answer = pages.pipeline.diagnoses.of_campaign(number, PATIENCE).await?;
        let diagnosis = match &answer {
            DiagnosisAnswer::Answered(diagnosed) => diagnosed.as_ref().as_ref().ok(),
            DiagnosisAnswer::NoSuchCampaign | DiagnosisAnswer::Waiting => None,
        };
        let diagnosis =
            diagnosis.filter(|diagnosis| !diagnosis.effects.is_empty()).ok_or_else(|| nothing_named(number))?;
        let diagnosis = diagnosis.clone().said_in(words::asked());
        let form = ActionForm {
            section: Section::Fleet,
            title: format!("{} · {}", t.adopt, stored.answer.imu),
            what: html! {
                p.lead { (t.campaign) " " (t.measured) " " (instant(stored.item.calibrated_at)) ": " (diagnosis.verdict_in_words(t.language())) }
                (found(t, &diagnosis))
                p { (t.adopt_what) }
            },
            action: format!("/campaigns/{number}/adopt"),
            button: t.adopt,
            back: word.back_or(&format!("/campaigns/{number}/diagnosis")).to_owned(),
            ..ActionForm::default()
        };
        Ok((number, form))
    }

    async fn run(pages: &Pages, id: Id, _: ActionForm, word: Word) -> Result<Response, Problem> {
        let adoption = pages.pipeline.diagnoses.adoption(id, word.by, word.reason).await?;
        put(pages, adoption.ok_or_else(|| nothing_named(id))?).await
    }
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

/// The model before the newest, the plain one where there was none, holds again.
pub(super) struct UndoModel;

impl ItemAction for UndoModel {
    /// The IMU, and what is to hold of it.
    type Item = (String, Arc<AugmentedModel>);

    async fn form(pages: &Pages, viewer: &Viewer, imu: &str, word: &Word) -> Result<(Self::Item, ActionForm), Problem> {
        let t = viewer.text();
        let models = pages.pipeline.diagnoses.models(imu).await?;
        let unknown = || Problem::new(404, "title_unknown_imu", pages.pipeline.queries.names().unknown_imu(imu));
        let models = models.ok_or_else(unknown)?;
        let newest = models.first().ok_or_else(|| {
            Problem::new(409, "title_nothing_to_adopt", message!("no_model_to_undo", imu = imu.to_owned()))
        })?;
        let model = models.get(1).map_or_else(Arc::default, |before| Arc::clone(&before.model));
        let form = ActionForm {
            section: Section::Fleet,
            title: format!("{} · {imu}", t.undo_model),
            what: html! {
                p.lead { (t.in_force) ": " code translate="no" { (held(t, &newest.model)) } }
                p.lead { (t.in_force_again) ": " code translate="no" { (held(t, &model)) } }
                p { (t.undo_model_what) }
            },
            action: format!("/imus/{}/model/undo", encoded(imu)),
            button: t.undo_model,
            back: word.back_or(&format!("/imus/{}#models", encoded(imu))).to_owned(),
            ..ActionForm::default()
        };
        Ok(((imu.to_owned(), model), form))
    }

    async fn run(pages: &Pages, (imu, model): Self::Item, _: ActionForm, word: Word) -> Result<Response, Problem> {
        put(pages, Adoption { imu, model, author: word.by, reason: word.reason }).await
    }
}
