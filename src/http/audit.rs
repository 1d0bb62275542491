//! `/v1/audit`: who did what, when and from where.

use axum::http::header::CONTENT_TYPE;
use serde_json::value::RawValue;

use crate::core::access::{AuditEntry, AuditFilter};
use crate::http::prelude::*;
use crate::wire::csv_text::csv_text;

const MOST_LINES: usize = 10_000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct AuditQuery {
    /// Not before this time: a day (UTC) or an RFC 3339 time.
    from: Option<String>,
    /// Not after this time: a day (UTC) or an RFC 3339 time.
    to: Option<String>,
    /// Only what the holder of the token of this name did.
    who: Option<String>,
    /// Only this kind of act, such as `acknowledge` or `revoke token`.
    action: Option<String>,
    /// Only acts on this, such as `gyros/LFG-0101`.
    subject: Option<String>,
    /// At most so many; 100 unless it is given.
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// `json` or `csv`; without it, `Accept` decides.
    format: Option<String>,
}

/// One act.
#[derive(Serialize, ToSchema)]
struct AuditLine {
    id: String,
    at: String,
    /// Name of the token; `local` before there was one, `command line`, or `service`.
    who: String,
    /// Identifier of the token.
    #[schema(required)]
    token: Option<String>,
    /// The address that it came from.
    source: String,
    /// The program that was used, by its own word (`User-Agent`).
    #[schema(required)]
    agent: Option<String>,
    action: String,
    subject: String,
    /// What it was about, as it was; null where it was not.
    #[schema(required, value_type = Option<Object>)]
    before: Option<Box<RawValue>>,
    /// What it became; null where it is no more.
    #[schema(required, value_type = Option<Object>)]
    after: Option<Box<RawValue>>,
}

#[derive(Serialize, ToSchema)]
struct Audit {
    /// Newest first.
    lines: Vec<AuditLine>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// The audit trail, newest first. It is only ever added to.
#[utoipa::path(get, path = "/v1/audit", tag = "access",
    params(AuditQuery),
    responses(
        (status = 200, description = "the lines", content((Audit = "application/json"), (String = "text/csv")),
            headers(("Link" = Option<String>, description = "where it goes on")))))]
pub async fn get_audit(
    app: App,
    headers: HeaderMap,
    uri: Uri,
    Parameters(asked): Parameters<AuditQuery>,
) -> Answer<Response> {
    let csv = query::wants_csv(asked.format.as_deref(), &headers)?;
    let limit = query::limit(asked.limit, 100, MOST_LINES)?;
    let before = query::position(List::Audit, asked.cursor.as_deref())?.map(Id);
    let span = query::span(asked.from.as_deref(), asked.to.as_deref())?;
    let AuditQuery { who, action, subject, .. } = asked;
    let filter = AuditFilter { from: Some(span.from), to: Some(span.to), who, action, subject };
    let rows = app.pipeline.access.audit(&filter, before, limit as u32 + 1).await?;
    let (rows, next) = query::page(List::Audit, rows, limit, |last| Some(last.id));
    let link = query::link(&uri, next.as_deref());
    if csv {
        let text = csv_text("id,at,who,token,source,action,subject,before,after,agent", rows.into_iter().map(cells));
        return Ok((link, [(CONTENT_TYPE, "text/csv; charset=utf-8")], text).into_response());
    }
    let lines = rows.into_iter().map(line).collect::<Result<_, _>>()?;
    Ok((link, Json(Audit { lines, next })).into_response())
}

fn line(row: AuditEntry) -> Answer<AuditLine> {
    let damaged = |_| Problem::new(500, "title_damaged_database", message!("audit_not_json", id = row.id.to_string()));
    let json = |text: Option<String>| text.map(RawValue::from_string).transpose().map_err(damaged);
    let (before, after) = (json(row.before)?, json(row.after)?);
    let (id, at, token) = (row.id.to_string(), time::format(row.at), row.token.map(|token| token.to_string()));
    let AuditEntry { who, source, agent, action, subject, .. } = row;
    Ok(AuditLine { id, at, who, token, source, agent, action, subject, before, after })
}

fn cells(row: AuditEntry) -> [String; 10] {
    let AuditEntry { id, at, who, token, source, action, subject, before, after, agent } = row;
    let token = token.map(|token| token.to_string());
    let [token, before, after, agent] = [token, before, after, agent].map(Option::unwrap_or_default);
    [id.to_string(), time::format(at), who, token, source, action, subject, before, after, agent]
}
