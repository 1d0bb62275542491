//! Query and form of a page: where they cannot be read, a page says why in words of ours.

use axum::extract::rejection::FormRejection;
use axum::extract::{self, FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;

use super::Pages;
use super::viewer::Viewer;
use crate::wire::problem::Problem;
use crate::wire::unreadable;

pub(super) struct Query<T>(pub T);

pub(super) struct Form<T>(pub T);

impl<T: DeserializeOwned> FromRequestParts<Pages> for Query<T> {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, pages: &Pages) -> Result<Self, Response> {
        let Ok(viewer) = Viewer::from_request_parts(parts, pages).await;
        let read = extract::Query::from_request_parts(parts, pages).await;
        read.map(|extract::Query(asked)| Self(asked)).map_err(|why| refused(&viewer, &why.body_text()))
    }
}

impl<T: DeserializeOwned> FromRequest<Pages> for Form<T> {
    type Rejection = Response;

    async fn from_request(request: Request, pages: &Pages) -> Result<Self, Response> {
        let (mut parts, body) = request.into_parts();
        let Ok(viewer) = Viewer::from_request_parts(&mut parts, pages).await;
        match axum::Form::from_request(Request::from_parts(parts, body), pages).await {
            Ok(axum::Form(said)) => Ok(Self(said)),
            Err(
                rejection @ (FormRejection::FailedToDeserializeForm(_) | FormRejection::FailedToDeserializeFormBody(_)),
            ) => Err(refused(&viewer, &rejection.body_text())),
            // No form of this site sends such.
            Err(rejection) => Err(rejection.into_response()),
        }
    }
}

fn refused(viewer: &Viewer, said: &str) -> Response {
    viewer.show(Err(Problem::new(400, "title_bad_query", unreadable::in_words(said))))
}
