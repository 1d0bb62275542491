//! A status as a badge: told by its shape and word as well as by its colour.

use maud::{Markup, html};

use super::text::Text;
use crate::core::judge::{Event, Status};

/// None for a gyro that was never calibrated.
pub(super) fn badge(t: &Text, status: Option<Status>) -> Markup {
    let (name, word) = status.map_or(("none", t.no_record), |status| (status.name(), t.status(status)));
    html! { span class={ "badge " (name) } { (word) } }
}

/// That a gyro is retired or in storage.
pub(super) fn out_of_use(t: &Text, event: Option<Event>) -> Markup {
    html! { @if let Some(event) = event { span.badge.none { (t.event(event)) } } }
}
