//! What nearly every page is made with.

pub(super) use axum::extract::Path;
pub(super) use axum::response::{IntoResponse, Response};
pub(super) use maud::{Markup, html};

pub(super) use super::layout::{Page, Section};
pub(super) use super::sent::{Form, Query};
pub(super) use super::state::Pages;
pub(super) use super::table::{tall_table, wide_table};
pub(super) use super::text::Text;
pub(super) use super::viewer::{Viewer, Visit};
pub(super) use crate::core::access::Role;
pub(super) use crate::message;
pub(super) use crate::wire::problem::Problem;
