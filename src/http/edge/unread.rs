//! What of a body nobody has read when the answer is there: a refusal may come before the body does. A little is read
//! and thrown away, so that the connection can go on; with more to come the answer says that the connection closes.

use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, HttpBody};
use axum::extract::Request;
use axum::http::header::{CONNECTION, EXPECT};
use axum::http::{HeaderMap, HeaderValue};
use bytes::Bytes;
use http_body_util::{BodyExt, Limited};
use hyper::body::{Frame, SizeHint};

/// As much is thrown away, bytes.
const LITTLE: u64 = 64 << 10;
/// And waited for.
const PATIENCE: Duration = Duration::from_millis(200);

/// A body that a handler has, and that comes back where the handler is done with it.
#[derive(Debug, Clone)]
struct Lent(Arc<Mutex<Body>>);

impl Lent {
    fn with<T>(&self, look: impl FnOnce(&mut Body) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl HttpBody for Lent {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        self.with(|body| {
            let polled = Pin::new(&mut *body).poll_frame(context);
            if matches!(polled, Poll::Ready(None | Some(Err(_)))) {
                *body = Body::empty();
            }
            polled
        })
    }

    fn is_end_stream(&self) -> bool {
        self.with(|body| body.is_end_stream())
    }

    fn size_hint(&self) -> SizeHint {
        self.with(|body| body.size_hint())
    }
}

/// What may be left of the body of a request.
#[derive(Debug)]
pub(super) struct Unread {
    body: Lent,
    /// The sender waits for `100 Continue`, which asking for the body would bring.
    waits: bool,
}

impl Unread {
    /// Lends the body of a request to its handler.
    pub fn of(request: Request) -> (Request, Self) {
        let waits = request.headers().contains_key(EXPECT);
        let (parts, body) = request.into_parts();
        let body = Lent(Arc::new(Mutex::new(body)));
        (Request::from_parts(parts, Body::new(body.clone())), Self { body, waits })
    }

    /// Sees to what is left, before the answer with these `headers` leaves. What is still being read is left alone.
    pub async fn settle(self, headers: &mut HeaderMap) {
        let Some(body) = Arc::into_inner(self.body.0) else { return };
        let body = body.into_inner().unwrap_or_else(PoisonError::into_inner);
        if body.is_end_stream() || headers.contains_key(CONNECTION) {
            return;
        }
        let is_little = !self.waits && body.size_hint().lower() <= LITTLE;
        let rest = async { Limited::new(body, LITTLE as usize).collect().await.is_ok() };
        if !is_little || !tokio::time::timeout(PATIENCE, rest).await.unwrap_or(false) {
            headers.insert(CONNECTION, HeaderValue::from_static("close"));
        }
    }
}
