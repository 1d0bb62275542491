//! `GET /v1/records` and `GET /v1/campaigns`: what has been stored, the last to arrive first.

use crate::core::kind::{Kind, RecordEntry};
use crate::http::prelude::*;
use crate::pipeline::{ListFilter, Names};

const DEFAULT_RECORDS: usize = 100;
const MOST_RECORDS: usize = 1000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct RecordsQuery {
    /// Of one IMU.
    imu: Option<String>,
    /// Of one station.
    station: Option<String>,
    /// Calibrated then or later: a day (UTC) or an RFC 3339 time.
    from: Option<String>,
    /// Calibrated then or earlier: a day (UTC) or an RFC 3339 time.
    to: Option<String>,
    /// At most so many; 100 unless it is given.
    #[param(minimum = 1, maximum = 1000)]
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
}

/// Records and campaigns, the last to arrive first.
#[derive(Serialize, ToSchema)]
pub struct RecordList {
    records: Vec<ListedRecordBody>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// Campaigns, the last to arrive first.
#[derive(Serialize, ToSchema)]
pub struct CampaignList {
    campaigns: Vec<ListedRecordBody>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// A record or a campaign in a list.
#[derive(Serialize, ToSchema)]
struct ListedRecordBody {
    id: String,
    /// `record` or `campaign`.
    kind: &'static str,
    imu: String,
    station: String,
    calibrated_at: String,
    received_at: String,
    /// Whether it counts: it was neither voided nor revised nor set aside.
    valid: bool,
}

impl ListedRecordBody {
    fn of(entry: &RecordEntry, names: &Names<'_>) -> Self {
        Self {
            id: entry.id.to_string(),
            kind: match entry.kind {
                Kind::Record => "record",
                Kind::Campaign => "campaign",
            },
            imu: names.imu(entry.imu).to_owned(),
            station: names.station(entry.station).to_owned(),
            calibrated_at: time::format(entry.calibrated_at),
            received_at: time::format(entry.received_at),
            valid: !entry.voided,
        }
    }
}

/// Records and campaigns of the fleet, the last to arrive first.
#[utoipa::path(get, path = "/v1/records", tag = "records", params(RecordsQuery),
    responses((status = 200, description = "the records", body = RecordList,
        headers(("Link" = Option<String>, description = "the next page")))))]
pub async fn get_records(app: App, Parameters(asked): Parameters<RecordsQuery>, uri: Uri) -> Answer<Response> {
    let (records, next) = listed(&app, &asked, None).await?;
    Ok((query::link(&uri, next.as_deref()), Json(RecordList { records, next })).into_response())
}

/// Campaigns of the fleet, the last to arrive first.
#[utoipa::path(get, path = "/v1/campaigns", tag = "campaigns", params(RecordsQuery),
    responses((status = 200, description = "the campaigns", body = CampaignList,
        headers(("Link" = Option<String>, description = "the next page")))))]
pub async fn get_campaigns(app: App, Parameters(asked): Parameters<RecordsQuery>, uri: Uri) -> Answer<Response> {
    let (campaigns, next) = listed(&app, &asked, Some(Kind::Campaign)).await?;
    Ok((query::link(&uri, next.as_deref()), Json(CampaignList { campaigns, next })).into_response())
}

async fn listed(
    app: &App,
    asked: &RecordsQuery,
    kind: Option<Kind>,
) -> Answer<(Vec<ListedRecordBody>, Option<String>)> {
    let limit = query::limit(asked.limit, DEFAULT_RECORDS, MOST_RECORDS)?;
    let list = kind.map_or(List::Records, |_| List::Campaigns);
    let before = Id(query::position(list, asked.cursor.as_deref())?.unwrap_or(i64::MAX));
    let calibrated = query::span(asked.from.as_deref(), asked.to.as_deref())?;
    let filter = ListFilter { kind, imu: asked.imu.as_deref(), station: asked.station.as_deref(), calibrated };
    let found = app.pipeline.queries.records.listed(&filter, before, limit as u32 + 1).await?;
    let (found, next) = query::page(list, found, limit, |last| Some(last.id));
    let names = app.pipeline.queries.names();
    Ok((found.iter().map(|entry| ListedRecordBody::of(entry, &names)).collect(), next))
}
