//! `/v1/gyros/{serial}/diagnosis`: why the coefficients of a gyro changed over its history.

use crate::http::prelude::*;
use crate::wire::history::HistoryDiagnosisBody;

/// Why the coefficients of the gyro changed: a station's offset, drift or step, ageing, an event, a re-mounting,
/// temperature, clocking, or a step that nothing on record explains. What the gyros of other IMUs share at a station
/// is the station's; the gyro is judged by what is left.
#[utoipa::path(get, path = "/v1/gyros/{serial}/diagnosis", tag = "gyros",
    responses((status = 200, description = "the causes, coefficient by coefficient", body = HistoryDiagnosisBody)))]
pub async fn get_gyro_diagnosis(app: App, Path(serial): Path<String>) -> Answer<Json<HistoryDiagnosisBody>> {
    let number = query::gyro(&app, &serial)?;
    let explained = app.pipeline.queries.histories.explain(number, &serial).await?;
    let coefficients = &explained.coefficients;
    Ok(Json(HistoryDiagnosisBody::new(&serial, explained.peers, explained.as_of, coefficients)))
}
