//! `…/void`: a record, a campaign or a bench result counts no more, said on a page that tells what that changes; and
//! how an item stands that was voided or revised.

use super::form::{ActionForm, ItemAction, Word, see_other};
use super::prelude::*;
use crate::core::correction::{CorrectedResult, CorrectionItem};
use crate::core::kind::Kind;
use crate::core::message::text;
use crate::pipeline::{Corrected, Correction, Submission};

async fn void(pages: &Pages, item: Corrected, form: ActionForm, word: Word) -> Result<Response, Problem> {
    let Word { by: author, reason, .. } = word;
    let correction = Correction { item, author, reason, replacement: None };
    pages.pipeline.ingest.submit(Submission::Correction(Box::new(correction))).await?;
    Ok(see_other(&form.back))
}

/// Of a record or campaign that still counts.
pub(super) struct VoidCalibration;

impl ItemAction for VoidCalibration {
    type Item = Corrected;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, word: &Word) -> Result<(Corrected, ActionForm), Problem> {
        let number = problem::id(id, Problem::no_such_record)?;
        let stored = pages.pipeline.queries.records.record(number).await?;
        let stored = stored.ok_or_else(|| Problem::no_such_record(id))?;
        still_counts(pages, number).await?;
        let t = viewer.text();
        let (item, names) = (&stored.item, pages.pipeline.queries.names());
        let campaign = item.kind == Kind::Campaign;
        let shown = html! {
            p.lead {
                (if campaign { t.campaign } else { t.record }) " · " (names.imu(item.imu))
                " · " (t.station) " " (names.station(item.station))
                " · " (t.calibrated) " " (instant(item.calibrated_at))
            }
            (wide_table("cards", html! {
                th { (t.serial) } @for name in DRIFTS { th.n { (symbol(name)) } }
            }, html! { @for one in &stored.answer.separations { tr {
                th scope="row" { (one.slot.name()) " " (one.serial) }
                @for (value, name) in [&one.d_i, &one.d_s, &one.d_o].into_iter().zip(DRIFTS) {
                    td.n { (label("", name)) (figure::drift(value.value, value.sd)) }
                }
            } } }))
        };
        let place = if campaign { "campaigns" } else { "records" };
        let home = format!("/{place}/{number}");
        let title = if campaign { t.void_campaign } else { t.void_record };
        let form = form(t, title, &shown, (&format!("{home}/void"), word.back_or(&home)));
        Ok((Corrected::Calibration { id: number, kind: Some(item.kind) }, form))
    }

    async fn run(pages: &Pages, item: Corrected, form: ActionForm, word: Word) -> Result<Response, Problem> {
        void(pages, item, form, word).await
    }
}

pub(super) struct VoidBench;

impl ItemAction for VoidBench {
    type Item = Corrected;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, word: &Word) -> Result<(Corrected, ActionForm), Problem> {
        let number = problem::id(id, Problem::no_such_bench_result)?;
        let bench = pages.pipeline.queries.records.bench(number).await?;
        let bench = bench.ok_or_else(|| Problem::no_such_bench_result(id))?;
        still_counts(pages, number).await?;
        let t = viewer.text();
        let names = pages.pipeline.queries.names();
        let serial = names.gyro(bench.gyro);
        let shown = html! {
            p.lead {
                (serial) " · " (t.method(bench.method.name())) " · " (t.station) " " (names.station(bench.station))
                " · " (t.measured) " " (instant(bench.measured_at))
            }
            p {
                (symbol("D_I")) " " (figure::drift(bench.d[0], bench.sd[0])) " · "
                (symbol("D_S")) " " (figure::drift(bench.d[1], bench.sd[1])) " " (t.unit)
            }
        };
        let home = format!("/gyros/{}", encoded(serial));
        let action = format!("/bench-results/{number}/void");
        Ok((Corrected::Bench(number), form(t, t.void_bench, &shown, (&action, word.back_or(&home)))))
    }

    async fn run(pages: &Pages, item: Corrected, form: ActionForm, word: Word) -> Result<Response, Problem> {
        void(pages, item, form, word).await
    }
}

async fn still_counts(pages: &Pages, id: Id) -> Result<(), Problem> {
    let status = pages.pipeline.queries.records.status(id).await?;
    if status.set_aside || status.counts() {
        return Ok(());
    }
    Err(Problem::new(409, "title_already_corrected", message!("already_corrected", id = text(id))))
}

/// Sent to `action`; `back` is where to go on.
fn form(t: &Text, title: &'static str, shown: &Markup, (action, back): (&str, &str)) -> ActionForm {
    ActionForm {
        section: Section::Fleet,
        title: title.into(),
        what: html! { (shown) p.lead { (t.void_what) } },
        action: action.to_owned(),
        button: t.void,
        back: back.to_owned(),
        is_final: true,
        ..ActionForm::default()
    }
}

/// How a calibration stands.
pub(super) struct CorrectionStatus {
    /// Whether it has neither been voided nor revised.
    pub counts: bool,
    /// What was said of it, where it does not count any more or stands in another's place; and the way to void one
    /// that counts.
    pub said: Markup,
}

pub(super) async fn standing(pages: &Pages, viewer: &Viewer, kind: Kind, id: Id) -> Result<CorrectionStatus, Problem> {
    let t = viewer.text();
    let status = pages.pipeline.queries.records.status(id).await?;
    let (counts, aside) = (status.counts(), status.set_aside);
    let place = if kind == Kind::Campaign { "campaigns" } else { "records" };
    let said = html! {
        @for row in &status.corrections { (remark(t, row, id)) }
        @if let Some(row) = &status.confirmation {
            p.sound { strong { (t.was_confirmed) } " " (instant(row.at)) " · " (t.said_by) " " span translate="no" { (row.author) ": " (row.reason) } }
        }
        @if aside {
            p.fault { strong { (t.was_set_aside) } }
            @if viewer.may(Role::Engineer) {
                p.actions { a.action href={ "/records/" (id) "/confirm?back=" (encoded(&viewer.here)) } { (t.confirm_time) } }
            }
        }
        @if (counts || aside) && viewer.may(Role::Engineer) {
            p.actions { a.action href={ "/" (place) "/" (id) "/void?back=" (encoded(&viewer.here)) } {
                (if kind == Kind::Campaign { t.void_campaign } else { t.void_record })
            } }
        }
    };
    Ok(CorrectionStatus { counts, said })
}

fn remark(t: &Text, row: &CorrectionItem, id: Id) -> Markup {
    html! {
        p.(if row.item == id { "fault" } else { "sound" }) {
            @match row.replaced_by {
                None => strong { (t.was_voided) },
                Some(_) if row.item != id => { strong { (t.stands_for) } " " a href={ "/records/" (row.item) } { code { (row.item) } } },
                Some(other) => { strong { (t.was_revised) } " " a href={ "/records/" (other) } { code { (other) } } },
            }
            " · " (instant(row.at)) " · " (said(t.said_by, row))
        }
    }
}

fn said(by: &str, row: &CorrectionItem) -> Markup {
    html! { (by) " " span translate="no" { (row.author) ": " (row.reason) } }
}

/// A record that is set aside, as a line of a gyro's course.
pub(super) fn aside(t: &Text, id: Id, at: UtcMicros) -> Markup {
    html! {
        td { strong { (t.set_aside) } }
        td { (t.calibration_of) " " a href={ "/records/" (id) } { (instant(at)) } }
    }
}

/// What does not count any more, as a line of a gyro's course: what it was, who said so and why.
pub(super) fn happening(t: &Text, correction: &CorrectedResult) -> Markup {
    let row = &correction.correction;
    html! {
        td { strong { (if row.replaced_by.is_some() { t.revised } else { t.voided }) } }
        td {
            (if correction.is_bench { t.bench_result } else { t.calibration_of }) " "
            @if correction.is_bench { (instant(correction.measured_at)) }
            @else { a href={ "/records/" (row.item) } { (instant(correction.measured_at)) } }
            @if let Some(other) = row.replaced_by { " → " a href={ "/records/" (other) } { (t.replacement) } }
            " · " (said(t.said_by, row))
        }
    }
}
