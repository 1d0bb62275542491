//! `/v1/imus/{imu}/model`, `/forecast`: the error model that the campaigns of an IMU are fitted with and compared with,
//! and what it foretold of them.

use std::sync::Arc;

use super::document::outcome;
use crate::http::prelude::*;
use crate::pipeline::{AdoptedModel, Adoption};
use crate::wire::body::{ToBody, bodies};
use crate::wire::forecast::ForecastSeriesBody;
use crate::wire::model::{AdoptionBody, ModelBody};

/// The model in force, and every one before it.
#[derive(Serialize, ToSchema)]
pub struct ImuModelBody {
    imu: String,
    /// In force now; without terms and effects it is the plain model, each campaign's own terms.
    model: ModelBody,
    /// Newest first; empty where none was ever adopted.
    history: Vec<AdoptedBody>,
}

/// A model as it was adopted.
#[derive(Serialize, ToSchema)]
pub struct AdoptedBody {
    id: String,
    adopted_at: String,
    author: String,
    reason: String,
    model: ModelBody,
    /// Stored campaigns that are fitted and stated with it.
    campaigns: u64,
}

bodies! {
    AdoptedBody of AdoptedModel: id = row.id, adopted_at = row.adopted_at, author = row.author, reason = row.reason,
        model: |adopted| ModelBody::from(&*adopted.model), campaigns;
}

/// The error model in force for the IMU, with its history.
#[utoipa::path(get, path = "/v1/imus/{imu}/model", tag = "imus",
    responses((status = 200, description = "the model and its history", body = ImuModelBody)))]
pub async fn get_model(app: App, Path(imu): Path<String>) -> Answer<Json<ImuModelBody>> {
    let models = app.pipeline.diagnoses.models(&imu).await?;
    let models = models.ok_or_else(|| query::unknown_imu(&app, &imu))?;
    let history: Vec<AdoptedBody> = models.to_body();
    let model = history.first().map(|newest| newest.model.clone()).unwrap_or_default();
    Ok(Json(ImuModelBody { imu, model, history }))
}

/// Adopts the content of a model file for the IMU: its stored campaigns are fitted with it anew and judged again, its
/// later ones are fitted with it, and its diagnoses are reported against it.
///
/// A body without terms and effects undoes what was adopted before, in the same way. A campaign that the model cannot
/// be fitted to stays as it is.
#[utoipa::path(post, path = "/v1/imus/{imu}/model", tag = "imus", request_body = AdoptionBody,
    responses(
        (status = 201, description = "in force from now on", body = AdoptedBody),
        (status = 200, description = "was in force before", body = AdoptedBody),
        (status = 422, description = "JSON that is no model, or one of another IMU or other gyros; the places are named")))]
pub async fn post_model(app: App, Path(imu): Path<String>, body: Document) -> Answer<(StatusCode, Json<AdoptedBody>)> {
    let (model, author, reason) = body.read(|bytes| json::parse::<AdoptionBody>(bytes)?.to_core_of(&imu))?;
    let adoption = Adoption { imu: imu.clone(), model: Arc::new(model), author, reason };
    let (status, id) = outcome(&app.pipeline.diagnoses.adopt(adoption).await?);
    let Json(now) = get_model(app, Path(imu)).await?;
    let adopted = now.history.into_iter().find(|adopted| adopted.id == id.to_string());
    adopted
        .map(|adopted| (status, Json(adopted)))
        .ok_or_else(|| Problem::new(500, "title_internal_error", message!("model_lost")))
}

/// Most forecasts in one answer.
const MOST_FORECASTS: usize = 100;

/// How many forecasts.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct ForecastQuery {
    /// The newest so many campaigns; 20 by default, at most 100.
    #[param(minimum = 1, maximum = 100)]
    limit: Option<usize>,
}

/// What was foretold of the IMU's campaigns, and how far it came true.
///
/// Each campaign is foretold by the model in force when it came in: by its coefficients where the model file holds
/// them, else by those of up to five campaigns before it, fitted with the terms and effects in force. Forecasts are
/// made and kept beside the diagnoses; the newest is answered dwell by dwell.
#[utoipa::path(get, path = "/v1/imus/{imu}/forecast", tag = "imus", params(ForecastQuery),
    responses((status = 200, description = "the forecasts, oldest first", body = ForecastSeriesBody)))]
pub async fn get_forecast(
    app: App,
    Path(imu): Path<String>,
    Parameters(asked): Parameters<ForecastQuery>,
) -> Answer<Json<ForecastSeriesBody>> {
    let limit = query::limit(asked.limit, 20, MOST_FORECASTS)?;
    let series = app.pipeline.diagnoses.forecasts(&imu, limit as u32).await?;
    series.map(Json).ok_or_else(|| query::unknown_imu(&app, &imu))
}
