//! `/v1/stations`: what each station does to every gyro that it measures.

use crate::core::suspect_window::{Mark, SuspectWindow};
use crate::http::prelude::*;
use crate::pipeline::{Refused, WindowMark, WindowOutcome};
use crate::wire::stations::{StationBody, StationsBody, SuspectWindowBody};

/// Every station: repeatability, offset, drift and steps as the gyros of the fleet share them, gyro x station, and how
/// the stations spread (gauge repeatability and reproducibility), each with its uncertainty.
#[utoipa::path(get, path = "/v1/stations", tag = "stations",
    responses((status = 200, description = "the stations, by name", body = StationsBody)))]
pub async fn get_stations(app: App) -> Answer<Json<StationsBody>> {
    let fleet = &app.pipeline.queries.fleet;
    let (found, overdue) = (fleet.station_figures().await?, fleet.overdue_of_stations().await?);
    Ok(Json(StationsBody::of(found.as_deref(), &overdue)))
}

/// One station.
#[utoipa::path(get, path = "/v1/stations/{name}", tag = "stations",
    responses((status = 200, description = "the station", body = StationBody)))]
pub async fn get_station(app: App, Path(name): Path<String>) -> Answer<Json<StationBody>> {
    let fleet = &app.pipeline.queries.fleet;
    let windows = app.pipeline.queries.suspect_windows(&name).await?.ok_or_else(|| Problem::no_such_station(&name))?;
    let (found, overdue) = (fleet.station_figures().await?, fleet.overdue_of_stations().await?);
    let station = found.iter().flat_map(|found| &found.stations).find(|station| *station.name == *name);
    let suspect_windows = Some(windows.iter().map(SuspectWindowBody::from).collect());
    let body = match station {
        Some(station) => StationBody::of(station, &overdue),
        None => StationBody::of_none(name),
    };
    Ok(Json(StationBody { suspect_windows, ..body }))
}

/// A window of time at a station, and who says what of it.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct WindowOrder {
    /// Calibrated then or later: a day (UTC) or an RFC 3339 time.
    from: String,
    /// Calibrated then or earlier.
    to: String,
    #[schema(min_length = 1, max_length = 64)]
    by: String,
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
}

/// What has come of the records of a window.
#[derive(Serialize, ToSchema)]
pub struct WindowBody {
    station: String,
    /// Identifiers of the records that were set aside, or count again.
    records: Vec<String>,
    /// Those of which that could not be done, and why.
    refused: Vec<RefusedBody>,
}

#[derive(Serialize, ToSchema)]
struct RefusedBody {
    record: String,
    detail: String,
}

/// What a station measured in a window of time is suspect: its records are set aside, those that come later too, and
/// what depends on them is judged again. Nothing is deleted. Windows that are suspect are members of the station.
#[utoipa::path(post, path = "/v1/stations/{name}/suspect", tag = "stations", request_body = WindowOrder,
    responses((status = 200, description = "the records that were set aside", body = WindowBody)))]
pub async fn suspect_window(app: App, Path(name): Path<String>, body: Document) -> Answer<Json<WindowBody>> {
    marked(&app, name, &body, false).await
}

/// What was marked as suspect in a window of time counts again.
#[utoipa::path(post, path = "/v1/stations/{name}/trust", tag = "stations", request_body = WindowOrder,
    responses((status = 200, description = "the records that count again", body = WindowBody)))]
pub async fn trust_window(app: App, Path(name): Path<String>, body: Document) -> Answer<Json<WindowBody>> {
    marked(&app, name, &body, true).await
}

async fn marked(app: &App, station: String, body: &Document, trusted: bool) -> Answer<Json<WindowBody>> {
    let window = body.read(|bytes| {
        let WindowOrder { from, to, by, reason } = json::parse(bytes)?;
        let mut faults = Faults::default();
        let span = text::span(("/from", &from), ("/to", &to), &mut faults);
        let (author, reason) = text::signed("/by", by, reason, &mut faults);
        faults.or(SuspectWindow { span, author, reason })
    })?;
    let mark = Mark { window, trusted };
    let mark = WindowMark { station: station.clone(), mark };
    Ok(Json(WindowBody::of(station, app.pipeline.mark_window(mark).await?)))
}

impl WindowBody {
    fn of(station: String, outcome: WindowOutcome) -> Self {
        let refused = |(id, why): (crate::core::id::Id, Refused)| RefusedBody {
            record: id.to_string(),
            detail: crate::words::asked().words(&why.message()),
        };
        Self {
            station,
            records: outcome.changed.iter().map(ToString::to_string).collect(),
            refused: outcome.refused.into_iter().map(refused).collect(),
        }
    }
}
