//! Bodies that come packed: `Content-Encoding: gzip`.

use std::io::Error;

use async_compression::tokio::bufread::GzipDecoder;
use axum::body::Body;
use axum::extract::Request;
use axum::http::header::{CONTENT_ENCODING, CONTENT_LENGTH};
use futures::TryStreamExt;
use tokio_util::io::{ReaderStream, StreamReader};

/// The request with its body unpacked as it is read, all members of it (RFC 1952, section 2.2). Another coding is left
/// as it is: the handlers say what they accept. What cannot be unpacked is an error of reading the body.
pub fn unpacked(request: Request) -> Request {
    let coding = request.headers().get(CONTENT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    if !["gzip", "x-gzip"].iter().any(|name| coding.trim().eq_ignore_ascii_case(name)) {
        return request;
    }
    let (mut parts, body) = request.into_parts();
    parts.headers.remove(CONTENT_ENCODING);
    parts.headers.remove(CONTENT_LENGTH);
    let packed = StreamReader::new(body.into_data_stream().map_err(Error::other));
    let mut decoder = GzipDecoder::new(packed);
    decoder.multiple_members(true);
    Request::from_parts(parts, Body::from_stream(ReaderStream::new(decoder)))
}
