//! `/v1/gyros/{serial}/trend`: the history of one coefficient.

mod answer;
mod body;
mod csv;
mod json;
mod periods;
mod point;
mod request;

use self::answer::answer;
use self::body::{ColumnTrend, Point, Trend};
use self::periods::PeriodTrend;
use self::point::{Seen, bench_point, seen_bench, separated_point};
use self::request::{PointMethod, Request, TrendQuery};
use super::events::EventBody;
use crate::core::bench::BenchItem;
use crate::http::prelude::*;

/// Points, lists where `columns` asks for them, or periods where `every` does.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the two forms of the answer in the OpenAPI document")]
enum TrendAnswer<'a> {
    Points(Trend<'a>),
    Columns(Box<ColumnTrend>),
    Periods(PeriodTrend<'a>),
}

/// The history of one coefficient of a gyro, oldest first.
#[utoipa::path(get, path = "/v1/gyros/{serial}/trend", tag = "gyros",
    params(TrendQuery),
    responses(
        (status = 200, description = "the points, or with `every` the periods", content((TrendAnswer = "application/json"), (String = "text/csv")),
            headers(("ETag" = String, description = "changes when the points do"), ("Link" = String, description = "the next page"))),
        (status = 304, description = "as it was")))]
pub async fn get_trend(
    app: App,
    Path(serial): Path<String>,
    Parameters(asked): Parameters<TrendQuery>,
    uri: Uri,
    headers: HeaderMap,
) -> Answer<Response> {
    let gyro = query::gyro(&app, &serial)?;
    let request = Request::read(&app, &asked, &headers)?;
    let mut events = app.pipeline.queries.histories.events(gyro).await?;
    // What took time is seen wherever it reaches into the stretch.
    events.retain(|(_, done)| done.at <= request.span.to && done.until.unwrap_or(done.at) >= request.span.from);
    let done = EventBody::all(&events);
    let seen = |rows: &mut dyn Iterator<Item = Seen>| {
        rows.chain(events.iter().map(|(id, _)| (id.0, None))).collect::<Vec<_>>()
    };
    if let Some(period) = request.every {
        let (summaries, next) = request.periods(&app, gyro, period).await?;
        let events: Vec<i64> = events.iter().map(|(id, _)| id.0).collect();
        let holds = (summaries.iter().map(periods::shown).collect::<Vec<_>>(), events);
        let written = |next| request.written_by_period(&serial, period, &summaries, &done, next);
        return answer((&uri, &headers), &request, &holds, next, written);
    }
    let levels = request.levels(&app, gyro, &serial).await?;
    match request.method {
        PointMethod::Separated(method) => {
            let (rows, next) = request.history(&app, gyro).await?;
            let (column, figures) = (request.column(), rows.iter().map(|row| &row.figures));
            let statuses = app.pipeline.queries.histories.statuses(gyro, figures, &[column]).await?;
            let holds = (seen(&mut rows.iter().map(|row| row.seen(&statuses, column, method))), &levels);
            answer((&uri, &headers), &request, &holds, next, |next| {
                let names = app.pipeline.queries.names();
                let points = rows.iter().map(|row| separated_point(row, (column, &statuses), method, &names));
                let points = points.map(|point| point.held_against(levels.as_ref())).collect();
                written(&request, &serial, points, &done, next)
            })
        }
        PointMethod::Bench(method) => {
            let (rows, next) = request.benches(&app, gyro, method).await?;
            let holds = (seen(&mut rows.iter().map(seen_bench)), &levels);
            answer((&uri, &headers), &request, &holds, next, |next| {
                let names = app.pipeline.queries.names();
                let flag = |row: &BenchItem| request.voided.then_some(row.voided);
                let points = rows.iter().filter_map(|row| bench_point(row, flag(row), request.coefficient, &names));
                let points = points.map(|point| point.held_against(levels.as_ref())).collect();
                written(&request, &serial, points, &done, next)
            })
        }
    }
}

fn written(
    request: &Request,
    serial: &str,
    points: Vec<Point<'_>>,
    events: &[EventBody],
    next: Option<String>,
) -> Option<Vec<u8>> {
    let trend = Trend { serial, coefficient: request.coefficient.name(), unit: "deg/(h*g0)", points, events, next };
    match &request.columns {
        _ if request.csv => csv::written(&trend, request),
        Some(columns) => json::columns(&trend, columns, request.levels),
        None => json::written(&trend),
    }
}
