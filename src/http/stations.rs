//! `/v1/stations`: what each station does to every gyro that it measures.

use axum::Json;
use axum::extract::{Path, State};

use super::app::App;
use crate::wire::problem::Problem;
use crate::wire::stations::{StationBody, StationsBody};

/// Every station: repeatability, offset, drift and steps as the gyros of the fleet share them, gyro x station, and how
/// the stations spread (gauge repeatability and reproducibility), each with its uncertainty.
#[utoipa::path(get, path = "/v1/stations", tag = "stations",
    responses((status = 200, description = "the stations, by name", body = StationsBody)))]
pub async fn get_stations(State(app): State<App>) -> Result<Json<StationsBody>, Problem> {
    let found = app.pipeline.queries.fleet.station_figures().await?;
    Ok(Json(StationsBody::from(found.as_ref())))
}

/// One station.
#[utoipa::path(get, path = "/v1/stations/{name}", tag = "stations",
    params(("name" = String, Path, description = "name of the station")),
    responses((status = 200, description = "the station", body = StationBody)))]
pub async fn get_station(State(app): State<App>, Path(name): Path<String>) -> Result<Json<StationBody>, Problem> {
    let found = app.pipeline.queries.fleet.station_figures().await?;
    let stations = found.map(|found| found.stations).unwrap_or_default();
    let station = stations.iter().find(|station| *station.name == *name);
    Ok(Json(StationBody::from(station.ok_or_else(|| Problem::no_such_station(&name))?)))
}
