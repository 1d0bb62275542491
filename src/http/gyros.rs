//! `/v1/gyros`: every gyro with its newest figures, and one with what has happened to it.

use bytes::Bytes;

use super::document::check_media_type;
use super::events::EventBody;
use crate::config::JudgedMethod;
use crate::core::alert_decision::Late;
use crate::core::figures::Figures;
use crate::core::fleet_order::FleetOrder;
use crate::core::gyro_attributes::{GyroAttributes, GyroAttributesPatch};
use crate::core::judge::{BudgetCrossing, BudgetProjection, Event, State, Status};
use crate::core::record::Name;
use crate::core::time::Span;
use crate::http::prelude::*;
use crate::pipeline::{
    Accepted, AttributesOrder, FleetFilter, GyroStatus, Names, Queries, StatusFilter, Submission, sample_of,
};
use crate::wire::answer::{FigureBody, VerdictBody};
use crate::wire::body::{ToBody, bodies};
use crate::wire::gyro_table;
use crate::wire::gyro_table::GyroRow;
use crate::wire::json::present;

const MOST_GYROS: usize = 10_000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct GyrosQuery {
    /// At most so many; 1000 unless it is given.
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// Only gyros of this status; `overdue` finds those as well whose status is worse.
    status: Option<String>,
    /// Only gyros of this state.
    state: Option<String>,
    /// Only gyros with this in their serial, IMU or station.
    q: Option<String>,
    /// Only gyros that this station calibrated last, or with `station_when=ever` at any time.
    station: Option<String>,
    /// `now` or `ever`; `now` unless it is given.
    station_when: Option<String>,
    /// Only gyros that were last calibrated in this IMU.
    imu: Option<String>,
    /// Only gyros with an alert of this rule that is not resolved.
    rule: Option<String>,
    /// Only gyros of this batch.
    batch: Option<String>,
    /// Only gyros that were calibrated no earlier: a day (UTC) or a time.
    calibrated_since: Option<String>,
    /// Only gyros of which something began to be worse no earlier, or that became overdue since.
    changed_since: Option<String>,
    /// `serial`, which is the order unless it is given; `load`: the largest first; `eta`: what reaches its budget first;
    /// `age`: what was calibrated the longest ago. What changes between two pages may come twice or not at all.
    sort: Option<String>,
}

/// What a list is narrowed down to besides.
fn fleet_filter(asked: &GyrosQuery) -> Answer<FleetFilter<'_>> {
    let start = |name: &'static str, said: &Option<String>| query::instant(name, said.as_deref(), time::parse_start);
    let station = asked.station.as_deref().unwrap_or_default();
    let (now, ever) = match asked.station_when.as_deref() {
        None | Some("now") => (station, ""),
        Some("ever") => ("", station),
        Some(other) => return Err(query::not_one_of("station_when", ["now", "ever"], other)),
    };
    Ok(FleetFilter {
        text: asked.q.as_deref().unwrap_or_default(),
        station: now,
        ever,
        imu: asked.imu.as_deref().unwrap_or_default(),
        rule: query::named("rule", asked.rule.as_deref())?,
        order: query::named("sort", asked.sort.as_deref())?,
        batch: asked.batch.as_deref().unwrap_or_default(),
        calibrated_since: start("calibrated_since", &asked.calibrated_since)?,
        changed_since: start("changed_since", &asked.changed_since)?,
        ..FleetFilter::default()
    })
}

/// What a list is narrowed down to.
fn filter_of(asked: &GyrosQuery) -> Answer<StatusFilter> {
    let (status, state) = (asked.status.as_deref(), asked.state.as_deref());
    Ok(StatusFilter { status: query::named("status", status)?, state: query::named("state", state)? })
}

#[derive(Serialize, ToSchema)]
pub struct Gyros {
    /// In the order that is asked for.
    gyros: Vec<Gyro>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// A gyro and its newest calibration.
#[derive(Serialize, ToSchema)]
pub struct Gyro {
    serial: String,
    /// Null for a gyro that only a bench has seen.
    #[schema(required)]
    latest: Option<Latest>,
    /// The worst of what the rules that could judge say of its newest calibration, requirements on E and G included:
    /// `indeterminate` while none could judge its drift, null before the first. `exceeded` in any case while an alert
    /// of `agreement` is not resolved.
    #[schema(required)]
    state: Option<&'static str>,
    /// The worst of its verdicts and of what its alerts know besides, and whether its calibration is overdue:
    /// `confirmed`, `out_of_tolerance`, `unconfirmed`, `drifting`, `overdue`, `borderline`, `too_uncertain`,
    /// `not_enough_data` or `in_tolerance`, the worst first. The last but one for a gyro that only a bench has seen,
    /// or of which no calibration counts.
    #[schema(required)]
    status: Option<&'static str>,
    /// `retired` or `in_storage`, until it is calibrated again: it is never overdue.
    #[schema(required)]
    out_of_use: Option<&'static str>,
    /// Since when it is beyond its limits; where it is not, since when it drifts.
    #[schema(required)]
    since: Option<String>,
    attributes: AttributesBody,
}

/// What the laboratory says of a gyro, in words of its own.
#[derive(Serialize, ToSchema)]
struct AttributesBody {
    /// Of production.
    #[schema(required)]
    batch: Option<String>,
    #[schema(required)]
    r#type: Option<String>,
    /// The owner, or the vehicle that it flies in.
    #[schema(required)]
    unit: Option<String>,
}

bodies! { AttributesBody of GyroAttributes: batch, r#type, unit; }

/// What changes; `null` takes a word away, what is left out stays (RFC 7396).
#[derive(Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
struct AttributesPatchBody {
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<String>, max_length = 64)]
    batch: Option<Option<String>>,
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<String>, max_length = 64)]
    r#type: Option<Option<String>>,
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<String>, max_length = 64)]
    unit: Option<Option<String>>,
}

impl AttributesPatchBody {
    fn to_core(&self) -> Result<GyroAttributesPatch, Faults> {
        let mut faults = Faults::default();
        let mut word = |pointer: &str, patch: &Option<Option<String>>| {
            patch.as_ref().map(|word| text::matched(pointer, word.as_ref()?, &mut faults))
        };
        let (batch, r#type) = (word("/batch", &self.batch), word("/type", &self.r#type));
        let unit = word("/unit", &self.unit);
        faults.or(GyroAttributesPatch { batch, r#type, unit })
    }
}

/// The newest calibration, deg/(h*g0).
#[derive(Serialize, ToSchema)]
struct Latest {
    calibrated_at: String,
    imu: String,
    slot: &'static str,
    station: String,
    record: String,
    method: &'static str,
    d_i: FigureBody,
    d_s: FigureBody,
    /// The closure.
    d_o: FigureBody,
    states: StatesBody,
    statuses: StatusesBody,
    /// (value - baseline) / budget, signed: 1 at the budget.
    loads: LoadsBody,
    /// When a trend that is established carries D_I or D_S to the budget, whichever does so first; null without one.
    #[schema(required)]
    reach: Option<ReachBody>,
}

/// Each null before its baseline is complete.
#[derive(Serialize, ToSchema)]
struct LoadsBody {
    #[serde(rename = "D_I")]
    #[schema(required)]
    d_i: Option<FigureBody>,
    #[serde(rename = "D_S")]
    #[schema(required)]
    d_s: Option<FigureBody>,
    #[serde(rename = "D_O")]
    #[schema(required)]
    d_o: Option<FigureBody>,
}

/// By the trend's line, and by both edges of its 95 % band.
#[derive(Serialize, ToSchema)]
struct ReachBody {
    coefficient: &'static str,
    at: String,
    #[schema(required)]
    earliest: Option<String>,
    /// Null where the late edge never does.
    #[schema(required)]
    latest: Option<String>,
    /// The course is young: these dates may be off by more than they say.
    provisional: bool,
}

impl ReachBody {
    fn of(reach: BudgetCrossing) -> Self {
        let [earliest, latest] = reach.between.map(|at| at.map(time::format));
        let (coefficient, at) = (reach.coefficient.name(), time::format(reach.at));
        Self { coefficient, at, earliest, latest, provisional: reach.provisional }
    }
}

/// `within`, `exceeded`, or `indeterminate`.
#[derive(Serialize, ToSchema)]
struct StatesBody {
    #[serde(rename = "D_I")]
    d_i: &'static str,
    #[serde(rename = "D_S")]
    d_s: &'static str,
    #[serde(rename = "D_O")]
    d_o: &'static str,
}

/// What the verdicts on each come to, in the words of a gyro's `status`.
#[derive(Serialize, ToSchema)]
struct StatusesBody {
    #[serde(rename = "D_I")]
    d_i: &'static str,
    #[serde(rename = "D_S")]
    d_s: &'static str,
    #[serde(rename = "D_O")]
    d_o: &'static str,
}

/// Every gyro, with its newest figures and status.
#[utoipa::path(get, path = "/v1/gyros", tag = "gyros",
    params(GyrosQuery),
    responses((status = 200, description = "the gyros", body = Gyros,
        headers(("Link" = Option<String>, description = "the next page")))))]
pub async fn get_gyros(app: App, Parameters(asked): Parameters<GyrosQuery>, uri: Uri) -> Answer<Response> {
    let limit = query::limit(asked.limit, 1000, MOST_GYROS)?;
    let (of_status, of_fleet) = (filter_of(&asked)?, fleet_filter(&asked)?);
    let list = List::Gyros(of_fleet.order.unwrap_or(FleetOrder::Serial));
    let after = query::number_before(list, asked.cursor.as_deref())?;
    let standings = app.pipeline.queries.fleet.listed(after, limit as u32 + 1, of_status, &of_fleet).await?;
    let (standings, next) = query::page(list, standings, limit, |standing| Some(Id(i64::from(standing.number))));
    let names = app.pipeline.queries.names();
    let gyros = standings.iter().map(|standing| Gyro::of(standing, app.config.judging.method, &names));
    Ok((query::link(&uri, next.as_deref()), Json(Gyros { gyros: gyros.collect(), next })).into_response())
}

/// One gyro.
#[derive(Serialize, ToSchema)]
pub struct GyroDetail {
    #[serde(flatten)]
    gyro: Gyro,
    /// Verdicts on its newest record, each with its `status`; where a bench has measured it, also how the methods
    /// agree.
    verdicts: Vec<VerdictBody>,
    /// What was done to it, oldest first.
    events: Vec<EventBody>,
    /// How many calibrations and bench results there are.
    calibrations: usize,
    bench_results: usize,
}

/// One gyro: its newest figures, how they are judged, and what was done to it.
#[utoipa::path(get, path = "/v1/gyros/{serial}", tag = "gyros",
    responses((status = 200, description = "the gyro", body = GyroDetail)))]
pub async fn get_gyro(app: App, Path(serial): Path<String>) -> Answer<Json<GyroDetail>> {
    let number = query::gyro(&app, &serial)?;
    let Queries { fleet, histories, .. } = &app.pipeline.queries;
    let found = fleet.standing_in_words(number).await?;
    let (standing, mut verdicts) = found.ok_or_else(|| Problem::unknown_gyro(&serial))?;
    let events = EventBody::all(&histories.events(number).await?);
    let calibrations = histories.count(number).await?;
    let bench_results = histories.benches(number, Span::EVER).await?.len();
    if bench_results > 0 {
        let compared = histories.compare_methods(number, None).await?;
        verdicts.extend(compared.verdicts.iter().map(|verdict| VerdictBody::of(&serial, verdict)));
    }
    let gyro = Gyro::of(&standing, app.config.judging.method, &app.pipeline.queries.names());
    Ok(Json(GyroDetail { gyro, verdicts, events, calibrations, bench_results }))
}

/// Batch, type and unit of a gyro.
#[utoipa::path(patch, path = "/v1/gyros/{serial}", tag = "gyros", request_body = AttributesPatchBody,
    responses((status = 200, description = "the gyro as it is now", body = GyroDetail)))]
pub async fn patch_gyro(app: App, Path(serial): Path<String>, body: Document) -> Answer<Json<GyroDetail>> {
    let patch = body.read(|bytes| json::parse::<AttributesPatchBody>(bytes)?.to_core())?;
    query::gyro(&app, &serial)?;
    let name = Name::parse(&serial).map_err(|_| Problem::unknown_gyro(&serial))?;
    let order = AttributesOrder { serial: name, patch };
    app.pipeline.ingest.submit(Submission::Attributes(order)).await?;
    get_gyro(app, Path(serial)).await
}

/// What has come of a table of attributes.
#[derive(Serialize, ToSchema)]
pub struct AttributesChanged {
    /// Serials of the gyros of which something is different now.
    changed: Vec<String>,
    /// Rows that say what was known.
    unchanged: usize,
}

/// Batch, type and unit of many gyros: a table with the columns `serial` and any of `batch`, `type`, `unit`. An empty
/// cell leaves what is known. All of it, or nothing.
#[utoipa::path(patch, path = "/v1/gyros", tag = "gyros",
    request_body(content = String, content_type = "text/csv"),
    responses((status = 200, description = "what has changed", body = AttributesChanged)))]
pub async fn patch_gyros(app: App, headers: HeaderMap, body: Bytes) -> Answer<Json<AttributesChanged>> {
    check_media_type(&headers, &["text/csv"])?;
    let of_faults = |faults| Problem::of_faults(422, "title_cannot_be_stored", faults);
    let rows = gyro_table::parse(&body).map_err(of_faults)?;
    let mut faults = Faults::default();
    for GyroRow { line, serial, .. } in &rows {
        if app.pipeline.queries.names().gyro_number(serial.as_str()).is_none() {
            let unknown = message!("unknown_gyro", serial = serial.to_string());
            faults.push("", message!("at_line", line = *line, fault = unknown));
        }
    }
    faults.or(()).map_err(of_faults)?;
    let order = |row: &GyroRow| {
        let (serial, patch) = (row.serial.clone(), row.patch.clone());
        Submission::Attributes(AttributesOrder { serial, patch })
    };
    let replies = app.pipeline.ingest.enqueue(rows.iter().map(order).collect(), Late::Quiet).await.await;
    let mut changed = Vec::new();
    for (row, reply) in rows.iter().zip(replies) {
        if let Accepted::Stored { .. } = reply? {
            changed.push(row.serial.to_string());
        }
    }
    changed.dedup();
    let unchanged = rows.len() - changed.len();
    Ok(Json(AttributesChanged { changed, unchanged }))
}

impl Gyro {
    pub fn of(standing: &GyroStatus, method: JudgedMethod, names: &Names<'_>) -> Self {
        Self {
            serial: standing.serial.to_string(),
            latest: standing.newest.as_ref().map(|figures| Latest::of(figures, standing, method, names)),
            state: standing.state.map(State::name),
            status: standing.status.map(Status::name),
            out_of_use: standing.out_of_use.map(Event::name),
            since: standing.since.map(time::format),
            attributes: AttributesBody::from(&standing.attributes),
        }
    }
}

impl Latest {
    fn of(figures: &Figures, standing: &GyroStatus, method: JudgedMethod, names: &Names<'_>) -> Self {
        let [d_i, d_s, d_o] = sample_of(figures, method).d.to_body();
        let [i, s, o] = figures.states.0.map(|state| state.unwrap_or(State::Indeterminate).name());
        let [status_i, status_s, status_o] = standing.drift.map(Status::name);
        let BudgetProjection { load, reach, .. } = standing.projection;
        let [load_i, load_s, load_o] = load.to_body();
        Self {
            calibrated_at: time::format(figures.at),
            imu: names.imu(figures.imu).to_owned(),
            slot: figures.slot.name(),
            station: names.station(figures.station).to_owned(),
            record: figures.record.to_string(),
            method: if figures.published.is_some() { method } else { JudgedMethod::Rigid }.name(),
            d_i,
            d_s,
            d_o,
            states: StatesBody { d_i: i, d_s: s, d_o: o },
            statuses: StatusesBody { d_i: status_i, d_s: status_s, d_o: status_o },
            loads: LoadsBody { d_i: load_i, d_s: load_s, d_o: load_o },
            reach: reach.map(ReachBody::of),
        }
    }
}
