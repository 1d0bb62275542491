//! `/v1/gyros/{serial}/trend`: the history of one coefficient.

mod answer;
mod csv;
mod json;
mod periods;
mod point;

use axum::extract::{Path, State};
use axum::http::header::ACCEPT;
use axum::http::{HeaderMap, Uri};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use self::answer::{Seen, answer, etag, is_known, not_modified};
use self::periods::PeriodTrend;
use self::point::{bench_point, separated_point};
use super::app::App;
use super::events::EventBody;
use super::query::{self, Parameters, bad, not_one_of};
use crate::config::JudgedMethod;
use crate::core::bench::BenchMethod;
use crate::core::judge::Coefficient;
use crate::core::period::Period;
use crate::core::time::UtcMicros;
use crate::message;
use crate::pipeline::store;
use crate::pipeline::{BenchRow, Figures, Id, Names, Span, Statuses, Tables};
use crate::wire::cursor;
use crate::wire::problem::Problem;

/// Points of one JSON answer unless `limit` says otherwise, and at the most.
const DEFAULT_POINTS: usize = 1000;
const MOST_POINTS: usize = 100_000;

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct TrendQuery {
    /// `D_I` (the default), `D_S` or `D_O`, the closure.
    coefficient: Option<String>,
    /// `rigid`, `published`, `torque_feedback` or `turntable_servo`; the judged method, where it is left out.
    method: Option<String>,
    /// Oldest instant, RFC 3339, itself included.
    from: Option<String>,
    /// Newest instant, itself included.
    to: Option<String>,
    /// At most so many points, oldest first; 1000 in JSON, all in CSV unless it is given.
    limit: Option<usize>,
    /// Instead of `limit`: the newest so many points, still oldest first.
    last: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// `json` or `csv`; without it, `Accept` decides.
    format: Option<String>,
    /// `day`, `week` or `month`: the least, largest, mean and last of each period instead of points.
    every: Option<String>,
    /// `include` shows what was voided or revised as well, each point flagged; such points are left out otherwise.
    voided: Option<String>,
}

/// Points, or periods where `every` asks for them.
#[derive(Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the two forms of the answer in the OpenAPI document")]
enum TrendAnswer<'a> {
    Points(Trend<'a>),
    Periods(PeriodTrend<'a>),
}

/// The history of one coefficient, oldest first.
#[derive(Serialize, ToSchema)]
struct Trend<'a> {
    serial: &'a str,
    coefficient: &'static str,
    /// `deg/(h*g0)`.
    unit: &'static str,
    points: Vec<Point<'a>>,
    /// What was done to the gyro in the stretch that was asked for, oldest first.
    #[schema(value_type = Vec<EventBody>)]
    events: &'a [EventBody],
    /// Cursor of the next page; null on the last.
    next: Option<String>,
}

#[derive(Serialize, ToSchema)]
struct Point<'a> {
    #[serde(serialize_with = "json::stamp")]
    #[schema(value_type = String)]
    calibrated_at: UtcMicros,
    value: f64,
    sd: Option<f64>,
    method: &'static str,
    /// IMU and slot; null on a bench.
    imu: Option<&'a str>,
    slot: Option<&'static str>,
    station: &'a str,
    /// Identifier of the record, or of the bench result.
    #[serde(serialize_with = "json::shown")]
    #[schema(value_type = String)]
    record: Id,
    /// `within`, `exceeded` or `indeterminate`, as it was judged; null for what is not judged.
    state: Option<&'static str>,
    /// What the verdicts on it come to: `confirmed`, `out_of_tolerance`, `unconfirmed`, `drifting`, `borderline`, `too_uncertain`,
    /// `not_enough_data` or `in_tolerance`; null for what is not judged.
    status: Option<&'static str>,
    /// True where it does not count any more; shown where voided points are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    voided: Option<bool>,
    /// Of these one that counts again when somebody confirms its time.
    #[serde(skip_serializing_if = "Option::is_none")]
    set_aside: Option<bool>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    Separated(JudgedMethod),
    Bench(BenchMethod),
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Self::Separated(JudgedMethod::Rigid) => "rigid",
            Self::Separated(JudgedMethod::Published) => "published",
            Self::Bench(method) => method.name(),
        }
    }
}

/// The history of one coefficient of a gyro, oldest first.
#[utoipa::path(get, path = "/v1/gyros/{serial}/trend", tag = "gyros",
    params(TrendQuery),
    responses(
        (status = 200, description = "the points, or with `every` the periods", content((TrendAnswer = "application/json"), (String = "text/csv")),
            headers(("ETag" = String, description = "changes when the points do"), ("Link" = String, description = "the next page"))),
        (status = 304, description = "as it was")))]
pub async fn get_trend(
    State(app): State<App>,
    Path(serial): Path<String>,
    Parameters(asked): Parameters<TrendQuery>,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let gyro = query::gyro(&app, &serial)?;
    let request = Request::read(&app, &asked, &headers)?;
    let mut events = store::event::of_gyro(app.pipeline.store(), gyro).await?;
    // What took time is seen wherever it reaches into the stretch.
    events.retain(|event| event.at <= request.span.to && event.until.unwrap_or(event.at) >= request.span.from);
    let done: Vec<EventBody> = events.iter().map(EventBody::of).collect();
    let seen = |rows: &mut dyn Iterator<Item = Seen>| {
        rows.chain(events.iter().map(|event| (event.id.0, None))).collect::<Vec<_>>()
    };
    if let Some(period) = request.every {
        let (summaries, next) = request.periods(&app, gyro, period).await?;
        let events: Vec<i64> = events.iter().map(|event| event.id.0).collect();
        let holds = (summaries.iter().map(periods::shown).collect::<Vec<_>>(), events);
        let tag = etag(&request, &holds, &next);
        if is_known(&headers, &tag) {
            return Ok(not_modified(&tag));
        }
        return Ok(answer(request.written_by_period(&serial, period, &summaries, &done, next)?, &tag, &uri));
    }
    let tag;
    let body = match request.method {
        Method::Separated(method) => {
            let (rows, next) = request.history(&app, gyro).await?;
            let (column, figures) = (request.column(), rows.iter().map(|row| &row.figures));
            let statuses = Statuses::of(app.pipeline.store(), gyro, figures, &[column]).await?;
            tag = etag(&request, &seen(&mut rows.iter().map(|row| row.seen(&statuses, column))), &next);
            if is_known(&headers, &tag) {
                return Ok(not_modified(&tag));
            }
            let names = app.pipeline.store().names();
            request.written(&serial, names, &done, next, |tables| {
                rows.iter().map(|row| separated_point(row, (column, &statuses), method, tables)).collect()
            })?
        }
        Method::Bench(method) => {
            let (rows, next) = request.benches(&app, gyro, method).await?;
            tag = etag(&request, &seen(&mut rows.iter().map(|row| (row.id.0, row.voided.then_some("voided")))), &next);
            if is_known(&headers, &tag) {
                return Ok(not_modified(&tag));
            }
            let names = app.pipeline.store().names();
            request.written(&serial, names, &done, next, |tables| {
                let flag = |row: &BenchRow| request.voided.then_some(row.voided);
                rows.iter().filter_map(|row| bench_point(row, flag(row), request.coefficient, tables)).collect()
            })?
        }
    };
    Ok(answer(body, &tag, &uri))
}

/// The query, checked.
#[derive(Debug)]
struct Request {
    coefficient: Coefficient,
    method: Method,
    span: Span,
    limit: usize,
    newest: bool,
    voided: bool,
    every: Option<Period>,
    csv: bool,
}

/// A record of the gyro; whether it does not count any more, where that is asked for.
struct Row {
    figures: Figures,
    voided: Option<bool>,
    set_aside: bool,
}

impl Row {
    fn seen(&self, statuses: &Statuses, column: usize) -> Seen {
        let judged = statuses.get(&self.figures, column).name();
        (self.figures.record.0, Some(if self.voided == Some(true) { "voided" } else { judged }))
    }
}

/// The points as text.
struct Written {
    text: Vec<u8>,
    csv: bool,
    next: Option<String>,
}

impl Request {
    fn read(app: &App, asked: &TrendQuery, headers: &HeaderMap) -> Result<Self, Problem> {
        let coefficient = asked.coefficient.as_deref().unwrap_or("D_I");
        let coefficient = Coefficient::from_name(coefficient)
            .filter(|c| c.column().is_some())
            .ok_or_else(|| not_one_of("coefficient", ["D_I", "D_S", "D_O"], coefficient))?;
        let method = match asked.method.as_deref() {
            None => Method::Separated(app.config.judging.method),
            Some("rigid") => Method::Separated(JudgedMethod::Rigid),
            Some("published") => Method::Separated(JudgedMethod::Published),
            Some(name) => Method::Bench(BenchMethod::from_name(name).ok_or_else(|| {
                not_one_of("method", ["rigid", "published", "torque_feedback", "turntable_servo"], name)
            })?),
        };
        let csv = match asked.format.as_deref() {
            Some("csv") => true,
            Some("json") => false,
            Some(other) => return Err(not_one_of("format", ["json", "csv"], other)),
            None => headers.get(ACCEPT).and_then(|a| a.to_str().ok()).is_some_and(|a| a.contains("text/csv")),
        };
        let voided = match asked.voided.as_deref() {
            None | Some("exclude") => false,
            Some("include") => true,
            Some(other) => return Err(not_one_of("voided", ["include", "exclude"], other)),
        };
        if asked.last.is_some() && (asked.limit.is_some() || asked.cursor.is_some()) {
            return Err(bad(message!("last_alone")));
        }
        let default = if csv { MOST_POINTS } else { DEFAULT_POINTS };
        let limit = query::limit(asked.last.or(asked.limit), default, MOST_POINTS)?;
        let mut span = query::span(asked.from.as_deref(), asked.to.as_deref())?;
        if let Some(cursor) = &asked.cursor {
            span.from = span.from.max(UtcMicros(query::position(cursor)?.saturating_add(1)));
        }
        let every = Self::period(asked.every.as_deref(), voided)?;
        Ok(Self { coefficient, method, span, limit, newest: asked.last.is_some(), voided, every, csv })
    }

    /// Of the coefficient, among D_I, D_S and D_O.
    fn column(&self) -> usize {
        self.coefficient.column().unwrap_or_default()
    }

    /// One page of rows, and where the next begins.
    async fn history(&self, app: &App, gyro: u32) -> Result<(Vec<Row>, Option<String>), Problem> {
        let store = app.pipeline.store();
        let counting = match self.newest {
            true => store::history::newest(store, gyro, self.span, self.limit).await?,
            false => store::history::oldest(store, gyro, self.span, self.limit + 1).await?,
        };
        let flag = |voided: bool| self.voided.then_some(voided);
        let row = |figures, voided, set_aside| Row { figures, voided: flag(voided), set_aside };
        let mut rows: Vec<Row> = counting.into_iter().map(|figures| row(figures, false, false)).collect();
        if self.voided {
            // What lies beyond the last row of a page that is full belongs to a later page.
            let full = !self.newest && rows.len() > self.limit;
            let end = rows.last().filter(|_| full).map_or(self.span.to, |last| last.figures.at);
            let voided = store::history::voided(store, gyro, Span { to: end, ..self.span }).await?;
            let aside = store::set_aside::of_gyro(store, gyro).await?;
            let is_aside = |figures: &Figures| aside.iter().any(|(id, _)| *id == figures.record);
            rows.extend(voided.into_iter().map(|figures| row(figures, true, is_aside(&figures))));
            rows.sort_by_key(|row| (row.figures.at, row.figures.record));
        }
        let next = self.page(&mut rows, |row| row.figures.at);
        Ok((rows, next))
    }

    /// Leaves one page; the cursor of the next, where something is left.
    fn page<T>(&self, rows: &mut Vec<T>, at: impl Fn(&T) -> UtcMicros) -> Option<String> {
        if self.newest {
            rows.drain(..rows.len().saturating_sub(self.limit));
            return None;
        }
        cut(rows, self.limit, at)
    }

    async fn benches(
        &self,
        app: &App,
        gyro: u32,
        method: BenchMethod,
    ) -> Result<(Vec<BenchRow>, Option<String>), Problem> {
        let mut rows = store::bench::all_of_gyro(app.pipeline.store(), gyro, self.span).await?;
        rows.retain(|row| row.method == method && (self.voided || !row.voided));
        let next = self.page(&mut rows, |row| row.measured_at);
        Ok((rows, next))
    }

    fn written(
        &self,
        serial: &str,
        names: &Names,
        events: &[EventBody],
        next: Option<String>,
        points: impl for<'t> FnOnce(&'t Tables) -> Vec<Point<'t>>,
    ) -> Result<Written, Problem> {
        let tables = names.read();
        let trend = Trend {
            serial,
            coefficient: self.coefficient.name(),
            unit: "deg/(h*g0)",
            points: points(&tables),
            events,
            next: next.clone(),
        };
        let text = if self.csv { csv::written(&trend, self.voided) } else { json::written(&trend) };
        let text = text.ok_or_else(|| Problem::new(500, "title_internal_error", message!("not_written")))?;
        Ok(Written { text, csv: self.csv, next })
    }
}

/// Cuts one page off; the cursor of the next, where something is left.
fn cut<T>(rows: &mut Vec<T>, limit: usize, at: impl Fn(&T) -> UtcMicros) -> Option<String> {
    let (last, first_left) = (rows.get(limit.checked_sub(1)?)?, rows.get(limit)?);
    // The next page begins after an instant: what is of the same instant stays together.
    let end = match at(last) == at(first_left) {
        true => rows.iter().skip(limit).position(|row| at(row) != at(last)).map_or(rows.len(), |more| limit + more),
        false => limit,
    };
    let next = (end < rows.len()).then(|| cursor::encode(at(last).0));
    rows.truncate(end);
    next
}
