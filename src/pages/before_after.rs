//! What a gyro was before and after each environmental test.

use super::history::event_name;
use super::prelude::*;
use super::status;
use crate::config::JudgedMethod;
use crate::core::figures::Figures;
use crate::core::judge::{Event, Limit};
use crate::pipeline::{GyroTimeline, Tested, sample_of};

/// By the judged method, the newest test first; nothing for a gyro that was never tested.
pub(super) fn section(t: &Text, course: &GyroTimeline, method: JudgedMethod) -> Markup {
    html! {
        @if !course.tests.is_empty() {
            section #tests {
                h2 { (t.before_after) }
                p.note { (t.before_after_test_note) " " (t.unit) }
                (wide_table("cards", html! {
                    th { (t.event(Event::EnvironmentalTest)) } th { (t.coefficient) }
                    th.n { (t.last_before) } th.n { (t.first_after) }
                    th.n { (t.difference) } th.n { (t.limit) } th { (t.status_word) }
                }, html! { @for test in course.tests.iter().rev() {
                    @for column in 0..2 { (line(t, course, test, (method, column))) }
                } }))
            }
        }
    }
}

fn line(t: &Text, course: &GyroTimeline, test: &Tested, (method, column): (JudgedMethod, usize)) -> Markup {
    let of = |figures: &Option<Figures>| figures.as_ref().map(|figures| sample_of(figures, method).d[column]);
    let (before, after) = (of(&test.before), of(&test.after));
    let difference = before.zip(after).map(|(before, after)| Measured {
        value: after.value - before.value,
        sd: before.sd.zip(after.sd).map(|(before, after)| before.hypot(after)),
    });
    let verdict = &test.verdicts[column];
    let asked = [course.limits.d_i, course.limits.d_s][column].of(Rule::BeforeAfter);
    // The key of today's limit names that of the verdict only where the two are the same.
    let key =
        |limit: f64| asked.filter(|asked: &Limit| asked.value.to_bits() == limit.to_bits()).map(|asked| asked.from);
    let missing = asked.is_some() && (before.is_none() || after.is_none());
    html! {
        tr {
            @if column == 0 {
                th scope="rowgroup" rowspan="2" {
                    (event_name(t, &test.event)) br;
                    span.quiet { (instant(test.event.at)) @if test.event.until.is_some() { " – " (instant(test.until())) } }
                }
            }
            td { (symbol(DRIFTS[column])) }
            @for (label, measured, record) in [(t.last_before, before, &test.before), (t.first_after, after, &test.after)] {
                td.n data-label=(label) { div {
                    @if let Some((measured, record)) = measured.zip(record.as_ref()) {
                        (figure::drift(measured.value, measured.sd)) br;
                        a.quiet href={ "/records/" (record.record) } { (instant(record.at)) }
                    } @else { "–" }
                } }
            }
            td.n data-label=(t.difference) { (or_dash(difference.map(|of| figure::signed_drift(of.value, of.sd)))) }
            td.n data-label=(t.limit) { div {
                @if let Some(verdict) = verdict {
                    (figure::short(verdict.limit)) @if let Some(key) = key(verdict.limit) { br; code.quiet { (key) } }
                } @else { "–" }
            } }
            td {
                @if let Some(verdict) = verdict { (status::badge(t, Some(verdict.status()))) }
                @else if missing { (status::badge(t, Some(Status::NotEnoughData))) }
                @else { (t.not_compared) }
            }
        }
    }
}
