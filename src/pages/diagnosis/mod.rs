//! `/campaigns/{id}/diagnosis`: where campaign and model part, what parts them, how far the gap shrinks, what cannot
//! be told, and what to measure next. The same answer as `/v1/campaigns/{id}/diagnosis`, to look at.

mod report;
pub(super) mod sections;

use std::time::Duration;

use axum::http::header::REFRESH;

pub use report::{Subject, report};

use super::calibration::stored_campaign;
use super::prelude::*;
use super::reference::{ReferenceComparison, ReferenceQuery};
use super::residuals::Setting;
use crate::pipeline::{DiagnosisAnswer, StoredCampaign};
use crate::wire::campaign;
use crate::words;

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(id): Path<String>,
    Query(asked): Query<ReferenceQuery>,
) -> Result<Response, Problem> {
    let page = build(pages, viewer, &id, &asked).await?;
    Ok(page.map_or_else(|| waiting(viewer.text()), IntoResponse::into_response))
}

/// Others are being made: the browser asks again by itself.
fn waiting(t: &Text) -> Response {
    let body = html! { h1 { (t.diagnosis) } p.lead #waiting { (t.diagnosis_waiting) } };
    let page = Page { title: t.diagnosis.into(), section: Section::Fleet, body };
    (StatusCode::ACCEPTED, [(REFRESH, "3")], page).into_response()
}

/// How long a viewer waits for a diagnosis that is being made.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);

/// The page; none while the diagnosis waits for others.
async fn build(pages: &Pages, viewer: &Viewer, id: &str, asked: &ReferenceQuery) -> Result<Option<Page>, Problem> {
    let t = viewer.text();
    let stored = stored_campaign(pages, id).await?;
    let diagnosis = match pages.pipeline.diagnoses.of_campaign(stored.item.id, PATIENCE).await? {
        DiagnosisAnswer::NoSuchCampaign => return Err(Problem::no_such_campaign(id)),
        DiagnosisAnswer::Waiting => return Ok(None),
        DiagnosisAnswer::Answered(diagnosed) => match &*diagnosed {
            Ok(diagnosis) => diagnosis.clone().said_in(words::asked()),
            Err(why) => return Err(Problem::new(422, "title_nothing_to_diagnose", why.clone())),
        },
    };
    let slots: Vec<(String, String)> =
        stored.answer.calibration.gyros.iter().map(|gyro| (gyro.slot.name().to_owned(), gyro.serial.clone())).collect();
    let campaign = campaign::parse_json(stored.item.body.as_bytes());
    let settings = campaign.map(|campaign| Setting::of_all(&campaign)).unwrap_or_default();
    let against = ReferenceComparison::of(pages, &stored, &diagnosis, asked).await?;
    let may_adopt = viewer.may(Role::Engineer) && !diagnosis.effects.is_empty();
    let body = html! {
        (head(t, &stored))
        @if may_adopt {
            p.actions { a.action href={ "/campaigns/" (stored.item.id) "/adopt" } { (t.adopt) } }
        }
        (sections::of(t, &diagnosis, (&slots, &settings), &against.section(t)))
    };
    let title = format!("{} · {}", t.diagnosis, stored.answer.imu);
    Ok(Some(Page { title, section: Section::Fleet, body }))
}

fn head(t: &Text, stored: &StoredCampaign) -> Markup {
    let answer = &stored.answer;
    html! {
        h1 { (t.diagnosis) " " a href={ "/imus/" (encoded(&answer.imu)) } { (answer.imu) } }
        p.note {
            (t.station) " " (answer.station) " · " (t.measured) " " (instant(stored.item.calibrated_at)) " · "
            (answer.calibration.dwells) " " (t.dwells) " · "
            a href={ "/campaigns/" (stored.item.id) } { (t.campaign) } " · "
            a href={ "/v1/campaigns/" (stored.item.id) "/diagnosis" } { "JSON" }
        }
    }
}
