//! The POST of a document that is stored: records, campaigns and bench results are sent alike.

use axum::Extension;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use super::corrections::{Standing, StandingBody};
use super::notify_query::NotifyQuery;
use super::prefer_header::{AsWanted, MinimalAnswer, Prefer};
use super::query::IDEMPOTENCY_KEY;
use crate::core::alert_decision::Late;
use crate::core::judge::State;
use crate::core::note::Note;
use crate::http::prelude::*;
use crate::pipeline::{Accepted, Caller, Judged, Origin, Submission};
use crate::wire::answer::VerdictBody;
use crate::wire::note::NoteBody;

/// What a request says of the document that it sends.
pub struct DocumentPost {
    caller: Caller,
    key: Result<IdempotencyKey, Problem>,
    pub wanted: Prefer,
    notify_query: NotifyQuery,
    /// What the document itself shows, beside what is found of it.
    pub noted: Option<Note>,
}

/// What has become of a calibration.
pub enum PostOutcome {
    New(Response),
    There(Id),
}

impl<S: Send + Sync> FromRequestParts<S> for DocumentPost {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Response> {
        let Extension(caller) =
            Extension::from_request_parts(parts, state).await.map_err(IntoResponse::into_response)?;
        let key = IdempotencyKey::of(parts);
        let Ok(wanted) = Prefer::from_request_parts(parts, state).await;
        let notify_query = NotifyQuery::from_request_parts(parts, state).await.map_err(IntoResponse::into_response)?;
        Ok(Self { caller, key, wanted, notify_query, noted: None })
    }
}

impl DocumentPost {
    /// The idempotency key, where it is one. What is wrong with the document is said first.
    pub fn key(&self) -> Answer<Option<String>> {
        self.key.clone().map(|key| key.0)
    }

    /// Stores it.
    pub async fn submit(&self, app: &App, item: Submission) -> Answer<Accepted> {
        item.may_be_sent_by(&self.caller)?;
        let late = self.notify_query.late_or(Late::Quiet);
        let accepted = app.pipeline.ingest.submit_late(item, late).await?;
        self.notify_query.end(app, late).await;
        Ok(accepted)
    }

    /// Stores a calibration that is to be found in `collection`. What is new is answered with `whole`, or as much of that as is wanted.
    pub async fn store<T: Serialize>(
        &self,
        app: &App,
        item: Submission,
        collection: &str,
        whole: impl Fn(Id, Vec<NoteBody>, Vec<VerdictBody>) -> T,
    ) -> Answer<PostOutcome> {
        let origin = Origin::of(&item);
        let accepted = self.submit(app, item).await?;
        let Accepted::Stored { id, judged, notes } = &accepted else {
            return Ok(PostOutcome::There(app.pipeline.ingest.settle(&accepted, origin.as_ref()).await?));
        };
        let notes = self.noted.iter().chain(notes.iter()).map(NoteBody::of).collect();
        let answer = match self.wanted {
            Prefer::Whole => Json(whole(*id, notes, verdicts_of(judged))).into_response(),
            Prefer::Minimal => {
                let states = judged.iter().flat_map(|gyro| &gyro.verdicts).map(|verdict| verdict.state);
                Json(MinimalAnswer::of(*id, states, notes)).into_response()
            }
        };
        Ok(PostOutcome::New((StatusCode::CREATED, self.located(collection, *id), answer).into_response()))
    }

    /// The answer to a calibration that was there: `whole`, or as much of it as is wanted, and how it stands where
    /// that is to be said.
    pub fn again<T: Serialize>(
        &self,
        (collection, id): (&str, Id),
        (whole, states, notes): (T, impl Iterator<Item = State>, Vec<NoteBody>),
        standing: Option<StandingBody>,
    ) -> Response {
        let answer = AsWanted::of(self.wanted, whole, id, states, notes);
        (self.located(collection, id), Json(Standing { answer, standing })).into_response()
    }

    fn located(&self, collection: &str, id: Id) -> impl axum::response::IntoResponseParts + use<> {
        ([(LOCATION, format!("/v1/{collection}/{id}"))], self.wanted.applied())
    }
}

fn verdicts_of(judged: &[Judged]) -> Vec<VerdictBody> {
    let verdicts = judged.iter().flat_map(|gyro| gyro.verdicts.iter().map(move |verdict| (&gyro.serial, verdict)));
    verdicts.map(|(serial, verdict)| VerdictBody::of(serial, verdict)).collect()
}

/// At most 255 visible characters.
#[derive(Debug, Clone, IntoParams)]
#[into_params(names("Idempotency-Key"), parameter_in = Header)]
pub struct IdempotencyKey(
    /// One key a request, repeated when it is sent again. It is kept as long as what was sent: for ever.
    Option<String>,
);

impl IdempotencyKey {
    fn of(parts: &Parts) -> Answer<Self> {
        let Some(value) = parts.headers.get(IDEMPOTENCY_KEY) else { return Ok(Self(None)) };
        let key = value.to_str().ok().filter(|key| (1..=255).contains(&key.len()));
        let key =
            key.ok_or_else(|| Problem::new(400, "title_bad_idempotency_key", message!("idempotency_key_form")))?;
        Ok(Self(Some(key.to_owned())))
    }
}
