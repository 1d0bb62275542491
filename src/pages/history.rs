//! What happened to a gyro: events, changes of seat and station, results that count no more.

use super::corrections;
use super::prelude::*;
use crate::core::figures::Figures;
use crate::core::gyro_event::GyroEvent;
use crate::pipeline::{GyroTimeline, Names};

/// `IMU-07 G1`.
pub(super) fn seat(figures: &Figures, names: &Names<'_>) -> String {
    format!("{} {}", names.imu(figures.imu), figures.slot.name())
}

/// Changes of seat and of station from one calibration to the next.
fn changes(t: &Text, course: &GyroTimeline, names: &Names<'_>) -> Vec<(UtcMicros, Markup)> {
    let mut changes = Vec::new();
    for pair in course.figures.windows(2) {
        let (old, new) = (&pair[0], &pair[1]);
        let mut push = |what: &str, from: &str, to: &str| {
            changes.push((new.at, html! { td { (what) } td { (from) " → " (to) } }));
        };
        if (old.imu, old.slot) != (new.imu, new.slot) {
            push(t.moved, &seat(old, names), &seat(new, names));
        }
        if old.station != new.station {
            push(t.other_station, names.station(old.station), names.station(new.station));
        }
    }
    changes
}

/// `environmental test: vibration`.
pub(super) fn event_label(t: &Text, event: &GyroEvent) -> String {
    let name = t.event(event.event);
    event.test.as_ref().map_or_else(|| name.to_owned(), |test| format!("{name}{}{test}", t.colon))
}

/// The same on a page, of which the test's name is not translated.
pub(super) fn event_name(t: &Text, event: &GyroEvent) -> Markup {
    html! { (t.event(event.event)) @if let Some(test) = &event.test { (t.colon) span translate="no" { (test) } } }
}

/// Events and changes in the order of time, newest first.
pub(super) fn happenings(t: &Text, course: &GyroTimeline, names: &Names<'_>) -> Markup {
    let mut all: Vec<(UtcMicros, Markup)> = course
        .events
        .iter()
        .map(|event| {
            let said = html! {
                td {
                    strong { (event_name(t, event)) }
                    @if let Some(until) = event.until { br; span.quiet { (t.until) " " (instant(until)) } }
                }
                td translate="no" {
                    (event.reason) @if let Some(author) = &event.author { " " span.quiet { "(" (author) ")" } }
                }
            };
            (event.at, said)
        })
        .chain(changes(t, course, names))
        .chain(course.corrections.iter().map(|one| (one.correction.at, corrections::happening(t, one))))
        .chain(course.set_aside.iter().map(|&(id, at)| (at, corrections::aside(t, id, at))))
        .collect();
    all.sort_by_key(|(at, _)| std::cmp::Reverse(*at));
    html! {
        section #happenings {
            h2 { (t.events) }
            @if all.is_empty() { p { (t.no_events) } }
            @else {
                div.scroll.tall.happenings tabindex="0" {
                    table { tbody { @for (at, said) in all { tr { td { (instant(at)) } (said) } } } }
                }
            }
        }
    }
}
