//! Errors as clients read them: problem details for HTTP APIs (RFC 9457).

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::core::fault::Faults;

/// What went wrong, for a program (`status`, `errors`) and for a person (`title`, `detail`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// Short, the same for every occurrence.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What happened this time.
    pub detail: String,
    /// The places in the body at fault, where there are any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<Place>,
    /// The id of the stored item that stands in the way, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub existing: Option<String>,
}

/// One place at fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Place {
    /// JSON pointer into the body as it was sent; empty for the whole document.
    pub pointer: String,
    pub detail: String,
}

impl Problem {
    pub fn new(status: u16, title: &str, detail: impl Into<String>) -> Self {
        Self { title: title.to_owned(), status, detail: detail.into(), errors: Vec::new(), existing: None }
    }

    pub fn unknown_gyro(serial: &str) -> Self {
        Self::new(404, "Unknown gyro", format!("no gyro with the serial {serial} is known"))
    }

    /// Nothing of that kind has the identifier.
    pub fn no_such(what: &str, id: impl std::fmt::Display) -> Self {
        Self::new(404, &format!("No such {what}"), format!("there is no {what} {id}"))
    }

    /// A body that is no JSON (400) or says what cannot be stored (422).
    pub fn of_faults(status: u16, title: &str, faults: Faults) -> Self {
        let detail = faults.to_string();
        let errors = faults.0.into_iter().map(|f| Place { pointer: f.pointer, detail: f.detail }).collect();
        Self { errors, ..Self::new(status, title, detail) }
    }
}

impl Problem {
    pub fn with_existing(mut self, id: impl ToString) -> Self {
        self.existing = Some(id.to_string());
        self
    }

    pub fn with_place(mut self, place: Place) -> Self {
        self.errors.push(place);
        self
    }
}
