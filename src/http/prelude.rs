//! What nearly every file of the service over HTTP is written with.

pub(super) use axum::extract::Path;
pub(super) use axum::http::header::LOCATION;
pub(super) use axum::http::{HeaderMap, StatusCode, Uri};
pub(super) use axum::response::{IntoResponse, Response};
pub(super) use serde::{Deserialize, Serialize};
pub(super) use utoipa::{IntoParams, ToSchema};

pub(super) use super::app::App;
pub(super) use super::document::Document;
pub(super) use super::json_response::Json;
pub(super) use super::problem::Answer;
pub(super) use super::query::{self, Parameters};
pub(super) use crate::core::fault::Faults;
pub(super) use crate::core::id::Id;
pub(super) use crate::core::time::UtcMicros;
pub(super) use crate::message;
pub(super) use crate::wire::cursor::List;
pub(super) use crate::wire::problem::Problem;
pub(super) use crate::wire::{json, text, time};
