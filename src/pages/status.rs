//! A status as a badge: told by its shape and word as well as by its colour.

use super::prelude::*;
use crate::core::judge::{Event, Status};

/// The sign of a status about the origin, in badges, pictures and legends alike: a disc is in order, a circle waits for
/// data, a diamond drifts, a triangle is beyond a limit, hollow until that is confirmed or filled, an octagon is confirmed.
pub(super) fn sign(status: Status) -> &'static str {
    match status {
        Status::InTolerance => "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0z",
        Status::NotEnoughData => {
            "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0zM-2.3 0a2.3 2.3 0 1 0 4.6 0a2.3 2.3 0 1 0-4.6 0z"
        }
        Status::TooUncertain => {
            "M-1-3.4a3.5 3.5 0 0 0 0 6.8v-1.3a2.3 2.3 0 0 1 0-4.2zM1-3.4a3.5 3.5 0 0 1 0 6.8v-1.3a2.3 2.3 0 0 0 0-4.2z"
        }
        Status::Borderline => "M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0zM0-2.3a2.3 2.3 0 0 1 0 4.6z",
        Status::Overdue => "M-3.5-3.5h7v7h-7zM-2.2-2.2v4.4h4.4v-4.4z",
        Status::Drifting => "M0-4.5 4.5 0 0 4.5-4.5 0z",
        Status::Unconfirmed => "M0-4.5 4.6 3.7h-9.2zM0-1.9-2.4 2.4h4.8z",
        Status::OutOfTolerance => "M0-4.5 4.6 3.7h-9.2z",
        Status::Confirmed => "M-1.7-4.2h3.4L4.2-1.7v3.4L1.7 4.2h-3.4L-4.2 1.7v-3.4z",
    }
}

/// It beside words, in the colour of the status that they have.
pub(super) fn mark(status: Status) -> Markup {
    html! { svg.sign aria-hidden="true" viewBox="-5 -5 10 10" { path d=(sign(status)) {} } }
}

/// None for a gyro that was never calibrated.
pub(super) fn badge(t: &Text, status: Option<Status>) -> Markup {
    said(status, status.map_or(t.no_record, |status| t.status(status)))
}

/// Something else that stands as well or as badly.
pub(super) fn said(status: Option<Status>, word: &str) -> Markup {
    html! {
        span class={ "badge " (status.map_or("none", Status::name)) } {
            @if let Some(status) = status { (mark(status)) } (word)
        }
    }
}

/// That a gyro is retired or in storage.
pub(super) fn out_of_use(t: &Text, event: Option<Event>) -> Markup {
    html! { @if let Some(event) = event { (said(None, t.event(event))) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_a_sign_of_its_own() {
        let signs: std::collections::BTreeSet<&str> = Status::ALL.into_iter().map(sign).collect();
        assert_eq!(signs.len(), Status::ALL.len());
    }
}
