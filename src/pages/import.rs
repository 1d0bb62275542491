//! `/import`: what a file says, and by line everything that is wrong with it or stands in its way, before anything is
//! stored; then storing it.
//!
//! The form is sent as `text/plain`, which is the text as it stands: it works without a script, and a file is no
//! larger on the way than it is.

use std::sync::Arc;

use axum::Extension;
use axum::extract::State as Held;
use axum::response::Response;
use maud::{Markup, html};

use super::Pages;
use super::figure;
use super::layout::{Page, Section, encoded, instant, symbol};
use super::notes::noted;
use super::off_the_loop;
use super::text::Text;
use super::viewer::Viewer;
use crate::core::alert_decision::Late;
use crate::core::fault::{Fault, Faults};
use crate::core::id::Id;
use crate::core::note::Note;
use crate::pages::upload_parts::{Piece, pieces};
use crate::pipeline::{Accepted, Caller, Origin, Pipeline, Preview, ReadDocument, Refused, Reply, Submission};
use crate::wire::campaign::Form;
use crate::wire::json::from_line;
use crate::wire::note::NoteBody;

/// Documents of one form that are shown; all are read and all are stored. So many of the sound ones are held against
/// what is stored, each with queries of its own: all that are shown, and no more, for a file may hold tens of
/// thousands.
const MOST_SHOWN: usize = 200;

pub(super) async fn page(viewer: Viewer) -> Response {
    viewer.show(Ok(framed(&viewer, "", html! {})))
}

/// What the text says, or what is wrong with it. Stores nothing.
pub(super) async fn preview(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Extension(caller): Extension<Caller>,
    form: String,
) -> Response {
    let pipeline = pages.pipeline.clone();
    let (text, read) = off_the_loop(move || {
        let text = text_of(&form);
        let read = read_all(&pipeline, &caller, &text);
        (text, read)
    })
    .await;
    let prospects = previews(&pages.pipeline, read).await;
    off_the_loop(move || viewer.show(Ok(previewed(&viewer, &prospects, &text)))).await
}

/// What storing a document would come to.
enum Prospect {
    Faulty(Faults),
    Refused(Refused),
    /// Another document of the text, on this line, holds its place with other content.
    Contradicts(usize),
    Sound(Box<Submission>, Arc<[Note]>),
}

/// Every document with its line, and what storing it would come to: what is stored already may stand in the way of
/// the first [`MOST_SHOWN`] that are sound.
async fn previews(pipeline: &Pipeline, read: Vec<(usize, Result<ReadDocument, Faults>)>) -> Vec<(usize, Prospect)> {
    let sound: Vec<(usize, &ReadDocument)> =
        read.iter().filter_map(|(line, read)| Some((*line, read.as_ref().ok()?))).collect();
    let documents: Vec<&ReadDocument> = sound.iter().map(|(_, document)| *document).take(MOST_SHOWN).collect();
    let outcomes = pipeline.ingest.preview(&documents).await;
    let lines: Vec<usize> = sound.iter().map(|(line, _)| *line).collect();
    let mut outcomes = outcomes.into_iter();
    let mut prospect = |read| match read {
        Err(faults) => Prospect::Faulty(faults),
        Ok(ReadDocument { submission, .. }) => match outcomes.next() {
            Some(Preview::Refused(why)) => Prospect::Refused(why),
            Some(Preview::Contradicts(earlier)) => Prospect::Contradicts(lines[earlier]),
            Some(Preview::Taken { notes }) => Prospect::Sound(Box::new(submission), notes),
            None => Prospect::Sound(Box::new(submission), [].into()),
        },
    };
    read.into_iter().map(|(line, read)| (line, prospect(read))).collect()
}

pub(super) async fn store(
    Held(pages): Held<Pages>,
    viewer: Viewer,
    Extension(caller): Extension<Caller>,
    form: String,
) -> Response {
    let pipeline = pages.pipeline.clone();
    let read = off_the_loop(move || read_all(&pipeline, &caller, &text_of(&form))).await;
    let outcomes = submit(&pages.pipeline, read).await;
    viewer.show(Ok(outcome(&viewer, &outcomes)))
}

/// The field `text` of a form sent as text/plain, with line ends as files have them.
fn text_of(form: &str) -> String {
    let text = form.strip_prefix("text=").unwrap_or(form);
    text.strip_suffix("\r\n").unwrap_or(text).replace("\r\n", "\n")
}

/// What a piece says, if this caller may send it.
fn read(pipeline: &Pipeline, caller: &Caller, piece: &Piece) -> Result<ReadDocument, Faults> {
    let document = match piece.form {
        Form::Json => {
            let read = pipeline.reader.document(piece.text.as_bytes());
            read.map_err(|faults| from_line(piece.line, piece.text, faults))
        }
        Form::Csv => pipeline.reader.campaign_document(piece.text.as_bytes(), Form::Csv),
    }?;
    let refused = |refused: Refused| Fault { pointer: "/station".into(), message: refused.message() };
    document.submission.may_be_sent_by(caller).map_err(refused)?;
    Ok(document)
}

fn previewed(viewer: &Viewer, prospects: &[(usize, Prospect)], text: &str) -> Page {
    let t = viewer.text();
    let is_sound = |(_, prospect): &&(usize, Prospect)| matches!(prospect, Prospect::Sound(..));
    let sound = prospects.iter().filter(is_sound).count();
    let faulty = prospects.len() - sound;
    let read = prospects.iter().filter(|(_, prospect)| !matches!(prospect, Prospect::Faulty(_))).count();
    let body = html! {
        section.preview aria-live="polite" {
            h2 { (t.preview) }
            @if prospects.is_empty() { p.fault { (t.no_document) } }
            p.lead {
                (sound) " " (t.can_be_stored)
                @if faulty > 0 { " · " strong { (faulty) " " (t.cannot_be_stored) } }
            }
            @if read > MOST_SHOWN { p.note { (t.first_foreseen) " " (MOST_SHOWN) } }
            @for (line, prospect) in prospects.iter().filter(|one| !is_sound(one)).take(MOST_SHOWN) {
                @match prospect {
                    Prospect::Faulty(faults) => (refused(t, *line, faults)),
                    Prospect::Refused(why) => (hindered(t, *line, &t.words(&why.message()))),
                    Prospect::Contradicts(earlier) => (hindered(t, *line, &format!("{} {earlier}", t.contradicts_line))),
                    Prospect::Sound(..) => {}
                }
            }
            @for (line, prospect) in prospects.iter().take(MOST_SHOWN) {
                @if let Prospect::Sound(submission, notes) = prospect { (sound_document(t, *line, submission, notes)) }
            }
            @if sound > 0 {
                form.confirm action="/import/store" method="post" enctype="text/plain" {
                    textarea name="text" hidden { (text) }
                    button.primary { (t.store) " (" (sound) ")" }
                    span.note { (t.store_note) }
                }
            }
        }
    };
    framed(viewer, text, body)
}

/// What one document has come to.
enum Outcome {
    Faulty(Faults),
    Refused(Refused),
    Stored { id: Id, is_new: bool, place: &'static str },
}

/// Every document of the text, with the line on which it begins.
fn read_all(pipeline: &Pipeline, caller: &Caller, text: &str) -> Vec<(usize, Result<ReadDocument, Faults>)> {
    pieces(text).iter().map(|piece| (piece.line, read(pipeline, caller, piece))).collect()
}

/// Submits all together, so that they share their flushes of the disk.
async fn submit(pipeline: &Pipeline, read: Vec<(usize, Result<ReadDocument, Faults>)>) -> Vec<(usize, Outcome)> {
    let (mut outcomes, mut sound, mut submissions) = (Vec::new(), Vec::new(), Vec::new());
    for (line, document) in read {
        match document {
            Ok(ReadDocument { submission, origin }) => {
                let bench = matches!(submission, Submission::Bench(_));
                sound.push((line, origin, if bench { "v1/bench-results" } else { "records" }));
                submissions.push(submission);
            }
            Err(faults) => outcomes.push((line, Outcome::Faulty(faults))),
        }
    }
    let replies = pipeline.ingest.enqueue(submissions, Late::Digest).await.await;
    if let Err(error) = pipeline.ingest.end_import().await {
        tracing::warn!(%error, "the digest of an import could not be queued; it is when nothing has come for a while");
    }
    for ((line, origin, place), reply) in sound.into_iter().zip(replies) {
        let outcome = match settle(pipeline, reply, &origin).await {
            Ok((id, is_new)) => Outcome::Stored { id, is_new, place },
            Err(refused) => Outcome::Refused(refused),
        };
        outcomes.push((line, outcome));
    }
    outcomes.sort_by_key(|(line, _)| *line);
    outcomes
}

async fn settle(pipeline: &Pipeline, reply: Reply, origin: &Origin) -> Result<(Id, bool), Refused> {
    let accepted = reply?;
    let id = pipeline.ingest.settle_document(&accepted, origin).await?;
    Ok((id, matches!(accepted, Accepted::Stored { .. })))
}

fn outcome(viewer: &Viewer, outcomes: &[(usize, Outcome)]) -> Page {
    let t = viewer.text();
    let body = html! {
        section.preview {
            h2 { (t.result) }
            @for (line, outcome) in outcomes {
                @match outcome {
                    Outcome::Faulty(faults) => (refused(t, *line, faults)),
                    Outcome::Refused(why) => p.fault { (t.line) " " (line) ": " (t.words(&why.message())) },
                    Outcome::Stored { id, is_new, place } => p {
                        (t.line) " " (line) ": "
                        (if *is_new { t.is_stored } else { t.was_there }) " "
                        a href={ "/" (place) "/" (id) } { (id) }
                    },
                }
            }
        }
    };
    framed(viewer, "", body)
}

fn framed(viewer: &Viewer, text: &str, after: Markup) -> Page {
    let t = viewer.text();
    let body = html! {
        h1 { (t.import) }
        p.lead { (t.import_note) }
        form.import action="/import/preview" method="post" enctype="text/plain" data-drop {
            p hidden { label { (t.choose_file) " " input type="file" accept=".json,.ndjson,.jsonl,.csv,.txt"; } }
            label { (t.or_paste) textarea name="text" rows="10" spellcheck="false" required { (text) } }
            button.primary { (t.preview) }
        }
        (after)
    };
    Page { title: t.import.into(), section: Section::Import, body }
}

fn refused(t: &Text, line: usize, faults: &Faults) -> Markup {
    html! {
        article.fault {
            h3 { (t.line) " " (line) " · " (t.refused) }
            ul { @for fault in &faults.0 {
                li { @if !fault.pointer.is_empty() { code { (fault.pointer) } ": " } (t.words(&fault.message)) }
            } }
        }
    }
}

/// A sound document that something else stands in the way of.
fn hindered(t: &Text, line: usize, why: &str) -> Markup {
    html! {
        article.fault {
            h3 { (t.line) " " (line) " · " (t.refused) }
            p { (why) }
        }
    }
}

fn sound_document(t: &Text, line: usize, submission: &Submission, notes: &[Note]) -> Markup {
    let notes: Vec<NoteBody> = notes.iter().map(NoteBody::of).collect();
    html! {
        article.sound {
            @match submission {
                Submission::Calibration(calibration) => {
                    h3 { (t.line) " " (line) " · " (calibration.imu) }
                    p.note { (t.station) " " (calibration.station) " · " (t.calibrated) " " (instant(calibration.calibrated_at)) }
                    div.scroll tabindex="0" { table {
                        thead { tr { th { (t.slot) } th { (t.serial) } th.n { (symbol("D_I")) } th.n { (symbol("D_S")) } th.n { (symbol("D_O")) } } }
                        tbody { @for gyro in &calibration.gyros {
                            @let rigid = &gyro.separation.rigid;
                            @let sd = rigid.sd();
                            tr {
                                td { (gyro.slot.name()) }
                                th scope="row" { a href={ "/gyros/" (encoded(gyro.serial.as_str())) } { (gyro.serial) } }
                                @for (i, value) in [rigid.d_i, rigid.d_s, rigid.d_o].into_iter().enumerate() {
                                    td.n { (figure::drift(value, sd.map(|sd| sd[i]))) }
                                }
                            }
                        } }
                    } }
                }
                Submission::Bench(bench) => {
                    h3 { (t.line) " " (line) " · " (bench.result.serial) " · " (t.method(bench.result.method.name())) }
                    p {
                        (t.station) " " (bench.result.station) " · " (instant(bench.result.measured_at)) " · "
                        (symbol("D_I")) " " (figure::drift(bench.result.d_i, bench.result.d_i_sd)) " · "
                        (symbol("D_S")) " " (figure::drift(bench.result.d_s, bench.result.d_s_sd)) " " (t.unit)
                    }
                }
                _ => {}
            }
            (noted(t, &notes))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_comes_out_of_the_form_as_the_file_had_it() {
        assert_eq!(text_of("text={\r\n \"a\": 1\r\n}\r\n"), "{\n \"a\": 1\n}");
        assert_eq!(text_of("text=a=b\r\n"), "a=b");
    }
}
