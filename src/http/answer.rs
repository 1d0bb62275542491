//! Answers with many verdicts in words, written into one buffer that need not grow.

use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::message;
use crate::pipeline::Judged;
use crate::wire::answer::{CAPACITY, with_verdicts};
use crate::wire::problem::Problem;

/// As axum's `Json`, which begins with 128 bytes and copies what it has at every doubling.
pub struct Answer<T>(pub T);

impl<T: Serialize> IntoResponse for Answer<T> {
    fn into_response(self) -> Response {
        let mut body = Vec::with_capacity(CAPACITY);
        let written = serde_json::to_writer(&mut body, &self.0);
        json(written.map(|()| body).map_err(Into::into))
    }
}

/// An answer, its own verdicts the last member and empty, with those that were just decided.
pub struct JustJudged<'a, T> {
    pub answer: &'a T,
    pub judged: &'a [Judged],
}

impl<T: Serialize> IntoResponse for JustJudged<'_, T> {
    fn into_response(self) -> Response {
        let verdicts = self.judged.iter().map(|gyro| (&*gyro.serial, gyro.verdicts.as_slice()));
        json(with_verdicts(self.answer, verdicts))
    }
}

fn json(written: std::io::Result<Vec<u8>>) -> Response {
    match written {
        Ok(body) => ([(CONTENT_TYPE, "application/json")], body).into_response(),
        Err(error) => {
            tracing::error!(%error, "an answer could not be put into JSON");
            Problem::new(500, "title_internal_error", message!("service_failed")).into_response()
        }
    }
}
