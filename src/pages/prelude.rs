//! What nearly every page is made with.

pub(super) use axum::extract::Path;
pub(super) use axum::http::StatusCode;
pub(super) use axum::response::{IntoResponse, Response};
pub(super) use maud::{Markup, html};
pub(super) use serde::Deserialize;

pub(super) use super::figure;
pub(super) use super::layout::{DRIFTS, Page, Section, encoded, instant, label, or_dash, symbol, written};
pub(super) use super::sent::{Form, Query};
pub(super) use super::state::Pages;
pub(super) use super::table::{tall_table, wide_table};
pub(super) use super::text::Text;
pub(super) use super::viewer::{PageContext, Viewer};
pub(super) use crate::core::access::Role;
pub(super) use crate::core::fault::Faults;
pub(super) use crate::core::id::Id;
pub(super) use crate::core::judge::{Measured, Rule, Status};
pub(super) use crate::core::message::Message;
pub(super) use crate::core::time::UtcMicros;
pub(super) use crate::message;
pub(super) use crate::wire::alert::AlertBody;
pub(super) use crate::wire::problem::{self, Problem};
pub(super) use crate::wire::time;
