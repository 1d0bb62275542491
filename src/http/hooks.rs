//! `/v1/hooks` and `/v1/deliveries`: whom to tell, and what has become of what they were told.

use crate::http::prelude::*;
use crate::pipeline::Order;
use crate::wire::hook::{DeliveryBody, HookBody, HookPatchBody, NewHookBody};

const MOST_DELIVERIES: usize = 1000;

#[derive(Serialize, ToSchema)]
pub struct Hooks {
    /// Oldest first.
    hooks: Vec<HookBody>,
}

/// Every hook, without its secrets.
#[utoipa::path(get, path = "/v1/hooks", tag = "hooks",
    responses((status = 200, description = "the hooks", body = Hooks)))]
pub async fn get_hooks(app: App) -> Answer<Json<Hooks>> {
    Ok(Json(Hooks { hooks: app.pipeline.hooks.all().await? }))
}

/// Sets up a hook: from here on it is told of every alert that its filter lets through.
///
/// A secret that the service has drawn is in the answer, this once.
#[utoipa::path(post, path = "/v1/hooks", tag = "hooks", request_body = NewHookBody,
    responses(
        (status = 201, description = "set up", body = HookBody, headers(("Location" = String, description = "where it is"))),
        (status = 409, description = "there are too many"),
        (status = 422, description = "an unknown kind, a forbidden address, a short secret …; the places are named")))]
pub async fn post_hook(app: App, body: Document) -> Answer<Response> {
    let new = body.read(|bytes| app.pipeline.hooks.check(json::parse(bytes)?))?;
    let drawn = new.drawn();
    let id = app.pipeline.hooks.order(Order::Create(new)).await?;
    let hook = app.pipeline.hooks.get(id, drawn.as_ref()).await?.ok_or_else(|| Problem::no_such_hook(id))?;
    Ok((StatusCode::CREATED, [(LOCATION, format!("/v1/hooks/{id}"))], Json(hook)).into_response())
}

/// One hook.
#[utoipa::path(get, path = "/v1/hooks/{id}", tag = "hooks",
    responses((status = 200, description = "the hook", body = HookBody)))]
pub async fn get_hook(app: App, Path(id): Path<String>) -> Answer<Json<HookBody>> {
    let hook = app.pipeline.hooks.get(query::id(&id, Problem::no_such_hook)?, None).await?;
    Ok(Json(hook.ok_or_else(|| Problem::no_such_hook(id))?))
}

/// Changes a hook. A secret that is replaced signs beside the new one for a while; `enabled: true` sends what waits
/// at once.
#[utoipa::path(patch, path = "/v1/hooks/{id}", tag = "hooks", request_body = HookPatchBody,
    responses(
        (status = 200, description = "changed", body = HookBody),
        (status = 422, description = "a forbidden address, a short secret …; the places are named")))]
pub async fn patch_hook(app: App, Path(id): Path<String>, body: Document) -> Answer<Json<HookBody>> {
    let id = query::id(&id, Problem::no_such_hook)?;
    let patch = body.read(|bytes| app.pipeline.hooks.check_patch(json::parse(bytes)?))?;
    let drawn = patch.drawn();
    app.pipeline.hooks.order(Order::Change(id, patch)).await?;
    Ok(Json(app.pipeline.hooks.get(id, drawn.as_ref()).await?.ok_or_else(|| Problem::no_such_hook(id))?))
}

/// Deletes a hook and what it was still to be told.
#[utoipa::path(delete, path = "/v1/hooks/{id}", tag = "hooks", responses((status = 204, description = "deleted")))]
pub async fn delete_hook(app: App, Path(id): Path<String>) -> Answer<StatusCode> {
    app.pipeline.hooks.order(Order::Delete(query::id(&id, Problem::no_such_hook)?)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Sends a hook a message that says that nothing is wrong, before whatever waits; its delivery tells how that went.
#[utoipa::path(post, path = "/v1/hooks/{id}/test", tag = "hooks",
    responses(
        (status = 202, description = "queued", body = DeliveryBody, headers(("Location" = String, description = "its delivery"))),
        (status = 409, description = "the hook is disabled")))]
pub async fn test_hook(app: App, Path(id): Path<String>) -> Answer<Response> {
    let delivery = app.pipeline.hooks.order(Order::Test(query::id(&id, Problem::no_such_hook)?)).await?;
    queued(&app, delivery).await
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct DeliveriesQuery {
    /// Only those that are `behind`, `waiting`, `delivered`, `dead` or `dropped`.
    state: Option<String>,
    /// At most so many; 100 unless it is given.
    limit: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
}

#[derive(Serialize, ToSchema)]
pub struct Deliveries {
    /// Newest first.
    deliveries: Vec<DeliveryBody>,
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

/// What a hook was told and is to be told, newest first, with every attempt; `state=dead` lists the dead letters.
#[utoipa::path(get, path = "/v1/hooks/{id}/deliveries", tag = "hooks",
    params(DeliveriesQuery),
    responses((status = 200, description = "the deliveries", body = Deliveries,
        headers(("Link" = Option<String>, description = "the next page")))))]
pub async fn get_deliveries(
    app: App,
    uri: Uri,
    Path(id): Path<String>,
    Parameters(asked): Parameters<DeliveriesQuery>,
) -> Answer<Response> {
    let hook = query::id(&id, Problem::no_such_hook)?;
    let state = query::named("state", asked.state.as_deref())?;
    let limit = query::limit(asked.limit, 100, MOST_DELIVERIES)?;
    let before = query::position(List::Deliveries, asked.cursor.as_deref())?.map(Id);
    if app.pipeline.hooks.get(hook, None).await?.is_none() {
        return Err(Problem::no_such_hook(&id));
    }
    let deliveries = app.pipeline.hooks.deliveries(hook, state, before, limit + 1).await?;
    let (deliveries, next) = query::page(List::Deliveries, deliveries, limit, |last| last.id.parse().ok());
    Ok((query::link(&uri, next.as_deref()), Json(Deliveries { deliveries, next })).into_response())
}

/// One delivery with every attempt.
#[utoipa::path(get, path = "/v1/deliveries/{id}", tag = "hooks",
    responses((status = 200, description = "the delivery", body = DeliveryBody)))]
pub async fn get_delivery(app: App, Path(id): Path<String>) -> Answer<Json<DeliveryBody>> {
    let delivery = app.pipeline.hooks.delivery(query::id(&id, Problem::no_such_delivery)?).await?;
    Ok(Json(delivery.ok_or_else(|| Problem::no_such_delivery(id))?))
}

/// Sends a delivery again that is done or a dead letter, from the start of the ladder; one that waits, at once.
#[utoipa::path(post, path = "/v1/deliveries/{id}/redeliver", tag = "hooks",
    responses(
        (status = 202, description = "queued again", body = DeliveryBody, headers(("Location" = String, description = "the delivery"))),
        (status = 409, description = "an earlier one comes first, it was dropped, or the hook is disabled")))]
pub async fn redeliver(app: App, Path(id): Path<String>) -> Answer<Response> {
    let delivery = app.pipeline.hooks.order(Order::Redeliver(query::id(&id, Problem::no_such_delivery)?)).await?;
    queued(&app, delivery).await
}

async fn queued(app: &App, id: Id) -> Answer<Response> {
    let delivery = app.pipeline.hooks.delivery(id).await?.ok_or_else(|| Problem::no_such_delivery(id))?;
    Ok((StatusCode::ACCEPTED, [(LOCATION, format!("/v1/deliveries/{id}"))], Json(delivery)).into_response())
}
