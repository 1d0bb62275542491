//! `/import`: what a file says, and everything that is wrong with it by line, before anything is stored; then storing it.
//!
//! The form is sent as `text/plain`, which is the text as it stands: it works without a script, and a file is no larger on
//! the way than it is.

use axum::extract::State as Held;
use axum::http::HeaderMap;
use axum::http::header::{HOST, ORIGIN};
use axum::response::Response;
use maud::{Markup, html};

use super::Pages;
use super::figure;
use super::layout::{Page, Section, encoded, instant, symbol};
use super::pieces::{Piece, pieces};
use super::text::Text;
use super::viewer::Viewer;
use crate::core::fault::Faults;
use crate::pipeline::{Accepted, Id, Pipeline, ReadDocument, Refused, Submission};
use crate::wire::campaign::Form;
use crate::wire::problem::Problem;

/// Documents of one form that are shown; all are read and all are stored.
const MOST_SHOWN: usize = 200;

pub(super) async fn page(viewer: Viewer) -> Response {
    viewer.show(Ok(framed(&viewer, "", html! {})))
}

/// What the text says, or what is wrong with it. Stores nothing.
pub(super) async fn preview(Held(pages): Held<Pages>, viewer: Viewer, headers: HeaderMap, form: String) -> Response {
    viewer.show(own_form(&headers).and_then(|()| previewed(&pages, &viewer, &text_of(&form))))
}

pub(super) async fn store(Held(pages): Held<Pages>, viewer: Viewer, headers: HeaderMap, form: String) -> Response {
    let page = match own_form(&headers) {
        Ok(()) => stored(&pages, &viewer, &text_of(&form)).await,
        Err(problem) => Err(problem),
    };
    viewer.show(page)
}

/// Refuses forms that another site's page sends with this viewer's hands.
fn own_form(headers: &HeaderMap) -> Result<(), Problem> {
    let text = |name| headers.get(name).and_then(|value: &axum::http::HeaderValue| value.to_str().ok());
    let same = match (text(ORIGIN), text(HOST)) {
        (None, _) => true,
        (Some(origin), host) => origin.split_once("://").map(|(_, host)| host) == host,
    };
    if same { Ok(()) } else { Err(Problem::new(403, "Foreign form", "the form was sent from another site")) }
}

/// The field `text` of a form sent as text/plain, with line ends as files have them.
fn text_of(form: &str) -> String {
    let text = form.strip_prefix("text=").unwrap_or(form);
    text.strip_suffix("\r\n").unwrap_or(text).replace("\r\n", "\n")
}

fn read(pipeline: &Pipeline, piece: &Piece) -> Result<ReadDocument, Faults> {
    match piece.form {
        Form::Json => pipeline.read_document(piece.text.as_bytes()),
        Form::Csv => pipeline.read_campaign_document(piece.text.as_bytes(), Form::Csv),
    }
}

fn previewed(pages: &Pages, viewer: &Viewer, text: &str) -> Result<Page, Problem> {
    let t = viewer.text();
    let pieces = pieces(text);
    let read: Vec<_> = pieces.iter().map(|piece| (piece, read(&pages.pipeline, piece))).collect();
    let faulty = read.iter().filter(|(_, read)| read.is_err()).count();
    let sound = read.len() - faulty;
    let body = html! {
        section.preview aria-live="polite" {
            h2 { (t.preview) }
            p.lead {
                (sound) " " (t.can_be_stored)
                @if faulty > 0 { " · " strong { (faulty) " " (t.cannot_be_stored) } }
            }
            @for (piece, read) in read.iter().filter(|(_, read)| read.is_err()).take(MOST_SHOWN) {
                @if let Err(faults) = read { (refused(t, piece, faults)) }
            }
            @for (piece, read) in read.iter().take(MOST_SHOWN) {
                @if let Ok(document) = read { (sound_document(t, piece, &document.submission)) }
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
    Ok(framed(viewer, text, body))
}

async fn stored(pages: &Pages, viewer: &Viewer, text: &str) -> Result<Page, Problem> {
    let t = viewer.text();
    let mut outcomes = Vec::new();
    for piece in pieces(text) {
        let outcome = match read(&pages.pipeline, &piece) {
            Ok(document) => Ok(submit(&pages.pipeline, document).await),
            Err(faults) => Err(faults),
        };
        outcomes.push((piece, outcome));
    }
    let body = html! {
        section.preview {
            h2 { (t.result) }
            @for (piece, outcome) in &outcomes {
                @match outcome {
                    Err(faults) => (refused(t, piece, faults)),
                    Ok(Err(why)) => p.fault { (t.line) " " (piece.line) ": " (why) },
                    Ok(Ok((id, is_new, place))) => p {
                        (t.line) " " (piece.line) ": "
                        (if *is_new { t.is_stored } else { t.was_there }) " "
                        a href={ "/" (place) "/" (id) } { (id) }
                    },
                }
            }
        }
    };
    Ok(framed(viewer, "", body))
}

/// Its id, whether it is new, and where it can be looked at.
async fn submit(pipeline: &Pipeline, document: ReadDocument) -> Result<(Id, bool, &'static str), Refused> {
    let place = if matches!(document.submission, Submission::Bench(_)) { "v1/bench-results" } else { "records" };
    let accepted = pipeline.submit(document.submission).await?;
    let id = pipeline.settle_document(&accepted, &document.origin).await?;
    Ok((id, matches!(accepted, Accepted::Stored { .. }), place))
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
    Page { title: t.import.into(), section: Section::Import, plots: false, body }
}

fn refused(t: &Text, piece: &Piece, faults: &Faults) -> Markup {
    html! {
        article.fault {
            h3 { (t.line) " " (piece.line) " · " (t.refused) }
            ul { @for fault in &faults.0 {
                li { @if !fault.pointer.is_empty() { code { (fault.pointer) } ": " } (fault.detail) }
            } }
        }
    }
}

fn sound_document(t: &Text, piece: &Piece, submission: &Submission) -> Markup {
    html! {
        article.sound {
            @match submission {
                Submission::Calibration(calibration) => {
                    h3 { (t.line) " " (piece.line) " · " (calibration.imu) }
                    p.note { (t.station) " " (calibration.station) " · " (t.calibrated) " " (instant(calibration.calibrated_at)) }
                    div.scroll { table {
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
                    h3 { (t.line) " " (piece.line) " · " (bench.result.serial) " · " (t.method(bench.result.method.name())) }
                    p {
                        (t.station) " " (bench.result.station) " · " (instant(bench.result.measured_at)) " · "
                        (symbol("D_I")) " " (figure::drift(bench.result.d_i, bench.result.d_i_sd)) " · "
                        (symbol("D_S")) " " (figure::drift(bench.result.d_s, bench.result.d_s_sd)) " " (t.unit)
                    }
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_taken_from_this_site_alone() {
        let with = |origin: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(HOST, "gyros.example:8080".parse().unwrap());
            if !origin.is_empty() {
                headers.insert(ORIGIN, origin.parse().unwrap());
            }
            own_form(&headers).map_err(|problem| problem.status)
        };
        assert_eq!((with(""), with("https://gyros.example:8080")), (Ok(()), Ok(())));
        assert_eq!((with("https://evil.example"), with("null")), (Err(403), Err(403)));
    }

    #[test]
    fn the_text_comes_out_of_the_form_as_the_file_had_it() {
        assert_eq!(text_of("text={\r\n \"a\": 1\r\n}\r\n"), "{\n \"a\": 1\n}");
        assert_eq!(text_of("text=a=b\r\n"), "a=b");
    }
}
