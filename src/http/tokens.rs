//! `/v1/tokens`: who may use the service.

use crate::core::access::{Role, Token};
use crate::http::prelude::*;
use crate::pipeline::{AccessOrder, NewToken};
use crate::wire::body::{ToBody, bodies};

/// A token. Its secret is in the answer to its making, and nowhere else.
#[derive(Serialize, ToSchema)]
struct TokenBody {
    id: String,
    name: String,
    /// `viewer`, `station`, `engineer` or `admin`.
    role: &'static str,
    /// The only station that it may send for; null for any.
    #[schema(required)]
    station: Option<String>,
    created_at: String,
    #[schema(required)]
    expires_at: Option<String>,
    #[schema(required)]
    revoked_at: Option<String>,
    /// To be sent as `Authorization: Bearer`. Shown this once.
    #[serde(skip_serializing_if = "Option::is_none")]
    token: Option<String>,
}

bodies! {
    TokenBody of Token: id, name, role, station, created_at, expires_at, revoked_at, token: |_| None;
}

#[derive(Serialize, ToSchema)]
pub struct Tokens {
    /// Oldest first, those that were revoked or have expired too.
    tokens: Vec<TokenBody>,
}

/// Every token, without its secret.
#[utoipa::path(get, path = "/v1/tokens", tag = "access",
    responses((status = 200, description = "the tokens", body = Tokens)))]
pub async fn get_tokens(app: App) -> Answer<Json<Tokens>> {
    let rows = app.pipeline.access.tokens().await?;
    Ok(Json(Tokens { tokens: rows.to_body() }))
}

/// For whom, and what they may do.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct NewTokenBody {
    /// Who or what will use it.
    #[schema(min_length = 1, max_length = 64)]
    name: String,
    /// `viewer`, `station`, `engineer` or `admin`.
    role: String,
    /// The only station that it may send for.
    station: Option<String>,
    /// RFC 3339; never, where it is left out.
    expires_at: Option<String>,
}

/// Makes a token. From the first one on, every request needs one.
#[utoipa::path(post, path = "/v1/tokens", tag = "access", request_body = NewTokenBody,
    responses(
        (status = 201, description = "made; its secret is shown this once", body = TokenBody, headers(("Location" = String, description = "where it is"))),
        (status = 422, description = "an unknown role, an expiry in the past …; the places are named")))]
pub async fn post_token(app: App, body: Document) -> Answer<Response> {
    let new = body.read(|bytes| read(&app, bytes))?;
    let lost = || Problem::new(500, "title_internal_error", message!("token_lost"));
    let secret = app.pipeline.access.order(AccessOrder::Create(new)).await?.ok_or_else(lost)?;
    let rows = app.pipeline.access.tokens().await?;
    let row = rows.iter().find(|row| row.id == secret.id).ok_or_else(lost)?;
    let body = TokenBody { token: Some(secret.reveal()), ..TokenBody::from(row) };
    Ok((StatusCode::CREATED, [(LOCATION, format!("/v1/tokens/{}", row.id))], Json(body)).into_response())
}

/// Revokes a token, at once and for good, and signs out who has signed in with it.
#[utoipa::path(delete, path = "/v1/tokens/{id}", tag = "access",
    responses((status = 204, description = "revoked, now or before")))]
pub async fn delete_token(app: App, Path(id): Path<String>) -> Answer<StatusCode> {
    let id = query::id(&id, Problem::no_such_token)?;
    app.pipeline.access.order(AccessOrder::Revoke(id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

fn read(app: &App, bytes: &[u8]) -> Result<NewToken, Faults> {
    let NewTokenBody { name, role, station, expires_at } = json::parse(bytes)?;
    let mut faults = Faults::default();
    let role = text::named("/role", &role, &mut faults).unwrap_or(Role::Station);
    let name = text::required_short("/name", name, &mut faults);
    NewToken::check_station(role, station.as_deref(), "/station", &mut faults);
    let station = station.map(|station| text::name("/station", &station, &mut faults).to_string());
    let expires_at = expires_at.map(|at| text::instant("/expires_at", &at, &mut faults));
    if expires_at.is_some_and(|at| at <= app.clock.now()) {
        faults.push("/expires_at", message!("not_in_future"));
    }
    faults.or(NewToken { name, role, station, expires_at })
}
