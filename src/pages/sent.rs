//! Query and form of a page: where they cannot be read, a page says why in words of ours.

use axum::extract::rejection::FormRejection;
use axum::extract::{self, FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use super::Pages;
use super::prelude::*;
use crate::wire::unreadable;

pub(super) struct Query<T>(pub T);

pub(super) struct Form<T>(pub T);

impl<T: DeserializeOwned> FromRequestParts<Pages> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, pages: &Pages) -> Result<Self, Problem> {
        let read = extract::Query::from_request_parts(parts, pages).await;
        read.map(|extract::Query(asked)| Self(asked)).map_err(|why| refused(&why.body_text()))
    }
}

impl<T: DeserializeOwned> FromRequest<Pages> for Form<T> {
    type Rejection = Response;

    async fn from_request(request: Request, pages: &Pages) -> Result<Self, Response> {
        match axum::Form::from_request(request, pages).await {
            Ok(axum::Form(said)) => Ok(Self(said)),
            Err(
                rejection @ (FormRejection::FailedToDeserializeForm(_) | FormRejection::FailedToDeserializeFormBody(_)),
            ) => Err(refused(&rejection.body_text()).into_response()),
            // No form of this site sends such.
            Err(rejection) => Err(rejection.into_response()),
        }
    }
}

fn refused(said: &str) -> Problem {
    Problem::new(400, "title_bad_query", unreadable::in_words(said))
}
