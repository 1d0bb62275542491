//! `/v1/imus`: the IMUs of the fleet, and the gyros that were calibrated in each.

use super::gyros::Gyro;
use crate::core::judge::Status;
use crate::http::prelude::*;
use crate::pipeline::{GyroStatus, Seats};

const DEFAULT_IMUS: usize = 100;
const MOST_IMUS: usize = 1000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct ImusQuery {
    /// At most so many; 100 unless it is given.
    #[param(minimum = 1, maximum = 1000)]
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
}

/// IMUs by name.
#[derive(Serialize, ToSchema)]
pub struct Imus {
    imus: Vec<ListedImuBody>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// An IMU in a list.
#[derive(Serialize, ToSchema)]
struct ListedImuBody {
    imu: String,
    /// The worst status of the gyros in it; null where none is.
    #[schema(required)]
    status: Option<&'static str>,
    /// Serials of the gyros in it, in the order of their slots.
    gyros: Vec<String>,
    /// The newest calibration of any gyro that is in it; null where none is.
    #[schema(required)]
    calibrated_at: Option<String>,
}

/// An IMU: the gyros in it and those that have left it.
#[derive(Serialize, ToSchema)]
pub struct ImuDetail {
    imu: String,
    /// The worst status of the gyros in it; null where none is.
    #[schema(required)]
    status: Option<&'static str>,
    /// In it, in the order of their slots.
    gyros: Vec<Gyro>,
    /// Another gyro has been calibrated in their slot since; the last to leave first.
    gyros_before: Vec<Gyro>,
}

/// Every IMU, by name.
#[utoipa::path(get, path = "/v1/imus", tag = "imus", params(ImusQuery),
    responses((status = 200, description = "the IMUs", body = Imus,
        headers(("Link" = Option<String>, description = "the next page")))))]
pub async fn get_imus(app: App, Parameters(asked): Parameters<ImusQuery>, uri: Uri) -> Answer<Response> {
    let limit = query::limit(asked.limit, DEFAULT_IMUS, MOST_IMUS)?;
    let after = query::number_before(List::Imus, asked.cursor.as_deref())?;
    let found = app.pipeline.queries.fleet.imus(after, limit as u32 + 1).await?;
    let (found, next) = query::page(List::Imus, found, limit, |imu| Some(Id(i64::from(imu.number))));
    let imus = found.into_iter().map(|found| ListedImuBody {
        imu: found.name,
        status: worst(&found.seats),
        gyros: found.seats.now.iter().map(|standing| standing.serial.to_string()).collect(),
        calibrated_at: newest(&found.seats),
    });
    Ok((query::link(&uri, next.as_deref()), Json(Imus { imus: imus.collect(), next })).into_response())
}

/// One IMU: its gyros and how each stands.
#[utoipa::path(get, path = "/v1/imus/{imu}", tag = "imus",
    responses((status = 200, description = "the IMU", body = ImuDetail)))]
pub async fn get_imu(app: App, Path(imu): Path<String>) -> Answer<Json<ImuDetail>> {
    let number = app.pipeline.queries.names().imu_number(&imu);
    let number = number.ok_or_else(|| query::unknown_imu(&app, &imu))?;
    let seats = app.pipeline.queries.fleet.seated_in(number).await?;
    let names = app.pipeline.queries.names();
    let body = |standings: &[GyroStatus]| {
        standings.iter().map(|standing| Gyro::of(standing, app.config.judging.method, &names)).collect()
    };
    let (gyros, gyros_before) = (body(&seats.now), body(&seats.before));
    Ok(Json(ImuDetail { imu: names.imu(number).to_owned(), status: worst(&seats), gyros, gyros_before }))
}

fn worst(seats: &Seats) -> Option<&'static str> {
    let worst = seats.now.iter().filter_map(|standing| standing.status).max();
    worst.map(Status::name)
}

fn newest(seats: &Seats) -> Option<String> {
    let newest = seats.now.iter().filter_map(|standing| standing.newest.map(|figures| figures.at)).max();
    newest.map(time::format)
}
