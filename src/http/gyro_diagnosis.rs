//! `/v1/gyros/{serial}/diagnosis`: why the coefficients of a gyro changed over its history.

use axum::Json;
use axum::extract::{Path, State};

use super::app::App;
use super::query;
use crate::wire::history::HistoryDiagnosisBody;
use crate::wire::problem::Problem;

/// Why the coefficients of the gyro changed: ageing, an event, a re-mounting, a station, temperature, clocking, or a
/// step that nothing on record explains. Stations are told apart by what they do to the other gyros that they
/// measured.
#[utoipa::path(get, path = "/v1/gyros/{serial}/diagnosis", tag = "gyros",
    responses((status = 200, description = "the causes, coefficient by coefficient", body = HistoryDiagnosisBody)))]
pub async fn get_gyro_diagnosis(
    State(app): State<App>,
    Path(serial): Path<String>,
) -> Result<Json<HistoryDiagnosisBody>, Problem> {
    let number = query::gyro(&app, &serial)?;
    let explained = app.pipeline.queries.histories.explain(number).await?;
    Ok(Json(HistoryDiagnosisBody::new(&serial, explained.peers, &explained.coefficients)))
}
