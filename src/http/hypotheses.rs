//! `/v1/hypotheses`: equations of one's own that compete with the catalogue in every diagnosis.

use super::document::outcome;
use crate::http::prelude::*;
use crate::pipeline::{HypothesisOrder, StoredHypothesis};
use crate::wire::hypothesis::HypothesisBody;
use crate::wire::unit;

/// A hypothesis that is to compete, who says so, and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewHypothesisBody {
    hypothesis: HypothesisBody,
    #[schema(min_length = 1, max_length = 64)]
    author: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
}

/// A hypothesis that competes in every diagnosis.
#[derive(Serialize, ToSchema)]
pub struct StoredHypothesisBody {
    hypothesis: HypothesisBody,
    author: String,
    reason: String,
    added_at: String,
}

/// Those that compete, in the order in which they were added.
#[derive(Serialize, ToSchema)]
pub struct HypothesesBody {
    hypotheses: Vec<StoredHypothesisBody>,
}

impl StoredHypothesisBody {
    fn of(stored: StoredHypothesis) -> Option<Self> {
        let StoredHypothesis { effect, row } = stored;
        let mut hypothesis = HypothesisBody::from(&effect.hypothesis()?.written);
        hypothesis.unit = unit::of_machines(&hypothesis.unit);
        Some(Self { hypothesis, author: row.author, reason: row.reason, added_at: time::format(row.added_at) })
    }
}

/// Hypotheses of one's own that compete with the catalogue.
#[utoipa::path(get, path = "/v1/hypotheses", tag = "diagnoses",
    responses((status = 200, description = "those that compete", body = HypothesesBody)))]
pub async fn get_hypotheses(app: App) -> Json<HypothesesBody> {
    let hypotheses = app.pipeline.diagnoses.hypotheses();
    Json(HypothesesBody { hypotheses: hypotheses.into_iter().filter_map(StoredHypothesisBody::of).collect() })
}

/// Has a hypothesis compete in every diagnosis from now on. Those made without it are out of date: order them again.
///
/// The body holds what `--hypothesis` reads from TOML, as JSON. Sixteen compete at most.
#[utoipa::path(post, path = "/v1/hypotheses", tag = "diagnoses", request_body = NewHypothesisBody,
    responses(
        (status = 201, description = "it competes", body = StoredHypothesisBody,
            headers(("Location" = String, description = "where it is taken out"))),
        (status = 200, description = "it did before", body = StoredHypothesisBody),
        (status = 409, description = "another has its name, or there are too many"),
        (status = 422, description = "it makes no sense; the places are named")))]
pub async fn post_hypothesis(app: App, body: Document) -> Answer<Response> {
    let order = body.read(read)?;
    let (status, id) = outcome(&app.pipeline.diagnoses.order_hypothesis(order).await?);
    let stored = app.pipeline.diagnoses.hypotheses().into_iter().find(|stored| stored.row.id == id);
    let body = stored.and_then(StoredHypothesisBody::of);
    let body = body.ok_or_else(|| Problem::new(500, "title_internal_error", message!("model_lost")))?;
    let location = format!("/v1/hypotheses/{}", body.hypothesis.id);
    Ok((status, [(LOCATION, location)], Json(body)).into_response())
}

fn read(bytes: &[u8]) -> Result<HypothesisOrder, Faults> {
    let NewHypothesisBody { hypothesis, author, reason } = json::parse(bytes)?;
    let mut faults = Faults::default();
    let (author, reason) = text::signed("/author", author, reason, &mut faults);
    let effect = hypothesis.to_core().map_err(|part| faults.absorb("/hypothesis", part));
    let Ok(effect) = effect else { return Err(faults) };
    faults.or(HypothesisOrder::Add { effect, author, reason })
}

/// Takes a hypothesis out of the competition. What a model holds of it stays.
#[utoipa::path(delete, path = "/v1/hypotheses/{id}", tag = "diagnoses",
    responses((status = 204, description = "it competes no more")))]
pub async fn delete_hypothesis(app: App, Path(id): Path<String>) -> Answer<StatusCode> {
    app.pipeline.diagnoses.order_hypothesis(HypothesisOrder::End(id)).await?;
    Ok(StatusCode::NO_CONTENT)
}
