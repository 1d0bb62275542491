//! `/import`: what a file says, and by line everything that is wrong with it or stands in its way, before anything is
//! stored; then storing it.
//!
//! A file is sent with the form as it stands, with or without a script. What was looked at is stored as `text/plain`,
//! which is the text as it stands.

pub(super) mod in_place;
mod located;
mod logs;
mod multipart;
mod numbered;
mod replace;

use std::sync::Arc;

use axum::Extension;
use axum::extract::Request;

use self::multipart::Upload;
use super::fleet::violated;
use super::layout::{day, joined, noted};
use super::prelude::*;
use super::upload_parts::{Piece, pieces};
use super::{bullet, off_the_loop, status};
use crate::core::alert_decision::Late;
use crate::core::fault::Fault;
use crate::core::history_note::HistoryNote;
use crate::core::note::Note;
use crate::logs::campaign::LogCampaign;
use crate::logs::report;
use crate::pipeline::{
    Accepted, Calibration, CalibrationPreview, Caller, GyroPreview, Origin, Pipeline, Preview, Refused, Reply,
    Submission,
};
use crate::wire::campaign::Form;
use crate::wire::document::is_csv;
use crate::wire::json::from_line;
use crate::wire::note::NoteBody;
use crate::wire::record_table::{TableMap, documents, is_table};
use crate::wire::table::open_end;
use located::Place;
use logs::{Sent, UploadContent};

/// Documents of one form that are shown; all are read and all are stored. So many of the sound ones are held against
/// what is stored, each with queries of its own: all that are shown, and no more, for a file may hold tens of
/// thousands.
const MOST_SHOWN: usize = 200;

pub(super) async fn page(viewer: Viewer) -> Page {
    framed(viewer.text(), &Sent::default(), html! {})
}

/// What the text says, or what is wrong with it. Stores nothing.
pub(super) async fn preview(
    PageContext(pages, viewer): PageContext,
    Extension(caller): Extension<Caller>,
    request: Request,
) -> Result<Response, Problem> {
    let form = match Upload::of(request).await {
        Ok(form) => form,
        Err(status) if status == StatusCode::PAYLOAD_TOO_LARGE => {
            let most = pages.config.server.max_body_bytes;
            let fault = message!("log_too_large", most, key = "server.max_body_bytes");
            return Ok((status, unread(viewer.text(), Sent::default(), &UploadContent::Faulty(fault))).into_response());
        }
        Err(_) => return Err(Problem::new(400, "title_broken_off", message!("body_broke_off"))),
    };
    let pipeline = pages.pipeline.clone();
    let looked = off_the_loop(move || {
        let sent = Sent::of_form(&form);
        let (text, made) = match logs::look(&sent) {
            UploadContent::Text(text) => (text, None),
            UploadContent::LogCampaign(made, text) => (text, Some(made)),
            other => return Err(Box::new((sent, other))),
        };
        let read = read_all(&pipeline, &caller, &text);
        if made.is_none() && logs::is_foreign(&text, &read) {
            let guessed = logs::guessed(&sent);
            if matches!(guessed, UploadContent::Guessed(_)) {
                return Err(Box::new((sent, guessed)));
            }
        }
        let places = places(&text, &read);
        let open = open_end(text.as_bytes()).filter(|_| is_csv(text.as_bytes()));
        Ok((Source { sent, text, made, places, open }, read))
    })
    .await;
    let (source, read) = match looked {
        Ok(looked) => looked,
        Err(unreadable) => {
            let (sent, looked) = *unreadable;
            return Ok(unread(viewer.text(), sent, &looked).into_response());
        }
    };
    let prospects = previews(&pages.pipeline, read).await?;
    Ok(off_the_loop(move || previewed(&viewer, &prospects, &source)).await.into_response())
}

/// What is looked at.
struct Source {
    sent: Sent,
    /// The documents in it: those that it is, or the campaign of a log.
    text: String,
    made: Option<Box<LogCampaign>>,
    /// What is faulty in the text.
    places: Vec<Place>,
    /// That a table may have been cut.
    open: Option<Note>,
}

/// A log that needs a map, or a file that is none.
fn unread(t: &Text, mut sent: Sent, looked: &UploadContent) -> Page {
    if let UploadContent::Guessed(map) = looked {
        sent.map.clone_from(map);
    }
    let body = html! {
        section.preview #preview aria-live="polite" {
            h2 { (t.preview) @if !sent.file.is_empty() { " · " span translate="no" { (sent.file) } } }
            @if let UploadContent::Faulty(fault) = looked { p.fault { (t.words(fault)) } }
            @else { p.doubt { (t.log_needs_map) } }
        }
    };
    framed(t, &sent, body)
}

/// Where the faults are of the first that have some.
fn places(text: &str, read: &[(usize, Result<Submission, Faults>)]) -> Vec<Place> {
    let pieces = if is_table(text, &TableMap::default()) {
        // Its faults name lines of the whole.
        vec![Piece { line: 1, text, form: Form::Csv }; read.len()]
    } else {
        pieces(text)
    };
    let faulty = pieces.iter().zip(read).filter_map(|(piece, (_, read))| Some((piece, read.as_ref().err()?)));
    let of_piece = |(piece, faults): (&Piece<'_>, &Faults)| -> Vec<Place> {
        faults.0.iter().map(|fault| located::place(piece, fault)).collect()
    };
    faulty.take(MOST_SHOWN).flat_map(of_piece).collect()
}

/// What storing a document would come to.
enum ImportPreview {
    Faulty(Faults),
    Refused(Refused),
    /// Another document of the text, on this line, holds its place with other content.
    Contradicts(usize),
    /// What is foreseen of it where it is a calibration.
    Sound(Box<Submission>, Arc<[Note]>, Option<CalibrationPreview>),
}

/// Every document with its line, and what storing it would come to: what is stored already may stand in the way of
/// the first [`MOST_SHOWN`] that are sound.
async fn previews(
    pipeline: &Pipeline,
    read: Vec<(usize, Result<Submission, Faults>)>,
) -> Result<Vec<(usize, ImportPreview)>, Problem> {
    let sound: Vec<(usize, &Submission)> =
        read.iter().filter_map(|(line, read)| Some((*line, read.as_ref().ok()?))).collect();
    let documents: Vec<&Submission> = sound.iter().map(|(_, document)| *document).take(MOST_SHOWN).collect();
    let outcomes = pipeline.ingest.preview(&documents).await;
    let mut forecasts = Vec::with_capacity(documents.len());
    for document in &documents {
        forecasts.push(match document.calibration() {
            Some(calibration) => Some(pipeline.queries.preview_calibration(calibration).await?),
            None => None,
        });
    }
    let lines: Vec<usize> = sound.iter().map(|(line, _)| *line).collect();
    let mut outcomes = outcomes.into_iter().zip(forecasts);
    let mut prospect = |read| match read {
        Err(faults) => ImportPreview::Faulty(faults),
        Ok(submission) => match outcomes.next() {
            Some((Preview::Refused(why), _)) => ImportPreview::Refused(why),
            Some((Preview::Contradicts(earlier), _)) => ImportPreview::Contradicts(lines[earlier]),
            Some((Preview::Taken { notes }, forecast)) => ImportPreview::Sound(Box::new(submission), notes, forecast),
            None => ImportPreview::Sound(Box::new(submission), [].into(), None),
        },
    };
    Ok(read.into_iter().map(|(line, read)| (line, prospect(read))).collect())
}

pub(super) async fn store(
    PageContext(pages, viewer): PageContext,
    Extension(caller): Extension<Caller>,
    form: String,
) -> Page {
    let pipeline = pages.pipeline.clone();
    let read = off_the_loop(move || read_all(&pipeline, &caller, &Sent::of(&form).text)).await;
    let outcomes = submit(&pages.pipeline, read).await;
    outcome(viewer.text(), &outcomes)
}

/// What a piece says, if this caller may send it.
fn read(pipeline: &Pipeline, caller: &Caller, piece: &Piece) -> Result<Submission, Faults> {
    let document = match piece.form {
        Form::Json => {
            let read = pipeline.reader.document(piece.text.as_bytes());
            read.map_err(|faults| from_line(piece.line, piece.text, faults))
        }
        Form::Csv => {
            pipeline.reader.campaign_document(piece.text.as_bytes(), Form::Csv).map(|campaign| campaign.submission)
        }
    }?;
    let refused = |refused: Refused| Fault { pointer: "/station".into(), message: refused.message() };
    document.may_be_sent_by(caller).map_err(refused)?;
    Ok(document)
}

fn previewed(viewer: &Viewer, prospects: &[(usize, ImportPreview)], source: &Source) -> Page {
    let t = viewer.text();
    let is_sound = |(_, prospect): &&(usize, ImportPreview)| matches!(prospect, ImportPreview::Sound(..));
    let sound = prospects.iter().filter(is_sound).count();
    let faulty = prospects.len() - sound;
    let read = prospects.iter().filter(|(_, prospect)| !matches!(prospect, ImportPreview::Faulty(_))).count();
    // A table of records has no text of its own for each.
    let parts = if is_table(&source.text, &TableMap::default()) { Vec::new() } else { pieces(&source.text) };
    let doubtful = prospects.iter().filter(|(_, prospect)| prospect.is_doubtful()).count();
    let at = |line: usize| place_of(t, line, prospects.len());
    let body = html! {
        section.preview #preview aria-live="polite" {
            h2 { (t.preview) @if !source.sent.file.is_empty() { " · " span translate="no" { (source.sent.file) } } }
            @if prospects.is_empty() { p.fault { (t.no_document) } }
            p.lead {
                (sound) " " (t.can_be_stored)
                @if faulty > 0 { " · " strong { (faulty) " " (t.cannot_be_stored) } }
                @if doubtful > 0 { " · " strong.doubt { (doubtful) " " (t.to_be_checked) } }
            }
            @if let Some(open) = source.open.as_ref().filter(|_| sound > 0) {
                p.doubt { strong { (t.check_first) } " " (NoteBody::of(open).detail) }
            }
            @if read > MOST_SHOWN { p.note { (t.first_foreseen) " " (MOST_SHOWN) } }
            @let unsound = prospects.iter().enumerate().filter(|(_, one)| !is_sound(one));
            @for (k, (line, prospect)) in unsound.take(MOST_SHOWN) {
                @match prospect {
                    ImportPreview::Faulty(faults) => (refused(t, &at(*line), faults)),
                    ImportPreview::Refused(why) => {
                        @let offer = parts.get(k).map(|piece| replace::offer(viewer, why, piece.text));
                        (hindered(t, &at(*line), &t.words(&why.message()), offer))
                    }
                    ImportPreview::Contradicts(earlier) => (hindered(t, &at(*line), &format!("{} {earlier}", t.contradicts_line), None)),
                    ImportPreview::Sound(..) => {}
                }
            }
            (numbered::shown(t, &source.text, &source.places))
            @for (line, prospect) in prospects.iter().take(MOST_SHOWN) {
                @if let ImportPreview::Sound(submission, notes, forecast) = prospect {
                    (sound_document(t, &at(*line), submission, notes, forecast.as_ref()))
                }
            }
            @if let Some(made) = &source.made {
                section.log { h3 { (t.of_the_log) } (report::shown(made, t.language())) }
            }
            @if sound > 0 {
                form.confirm action="/import/store" method="post" enctype="text/plain" {
                    textarea name="text" hidden { (source.text) }
                    button.primary { (t.store) " (" (sound) ")" }
                    span.note { (t.store_note) }
                }
            }
        }
    };
    framed(t, &source.sent, body)
}

/// What one document has come to.
enum Outcome {
    Faulty(Faults),
    Refused(Refused),
    Stored { id: Id, is_new: bool, place: &'static str },
}

/// Every document of the text, with the line on which it begins.
fn read_all(pipeline: &Pipeline, caller: &Caller, text: &str) -> Vec<(usize, Result<Submission, Faults>)> {
    let Some(table) = documents(text, &TableMap::default()) else {
        return pieces(text).iter().map(|piece| (piece.line, read(pipeline, caller, piece))).collect();
    };
    let rows = match table {
        Ok(rows) => rows,
        Err(faults) => return vec![(1, Err(faults))],
    };
    let at = |line: usize, fault: Fault| Fault { message: message!("at_line", line, fault = fault.message), ..fault };
    let read = |(line, document): (usize, serde_json::Value)| {
        let text = document.to_string();
        let read = read(pipeline, caller, &Piece { line, text: &text, form: Form::Json });
        let placed = |faults: Faults| Faults(faults.0.into_iter().map(|fault| at(line, fault)).collect());
        (line, read.map_err(placed))
    };
    rows.into_iter().map(read).collect()
}

/// Submits all together, so that they share their flushes of the disk.
async fn submit(pipeline: &Pipeline, read: Vec<(usize, Result<Submission, Faults>)>) -> Vec<(usize, Outcome)> {
    let (mut outcomes, mut sound, mut submissions) = (Vec::new(), Vec::new(), Vec::new());
    for (line, document) in read {
        match document {
            Ok(submission) => {
                let bench = matches!(submission, Submission::Bench(_));
                sound.push((line, Origin::of(&submission), if bench { "v1/bench-results" } else { "records" }));
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
        let outcome = match settle(pipeline, reply, origin.as_ref()).await {
            Ok((id, is_new)) => Outcome::Stored { id, is_new, place },
            Err(refused) => Outcome::Refused(refused),
        };
        outcomes.push((line, outcome));
    }
    outcomes.sort_by_key(|(line, _)| *line);
    outcomes
}

async fn settle(pipeline: &Pipeline, reply: Reply, origin: Option<&Origin>) -> Result<(Id, bool), Refused> {
    let accepted = reply?;
    let id = pipeline.ingest.settle(&accepted, origin).await?;
    Ok((id, matches!(accepted, Accepted::Stored { .. })))
}

fn outcome(t: &Text, outcomes: &[(usize, Outcome)]) -> Page {
    let at = |line: usize| place_of(t, line, outcomes.len());
    let body = html! {
        section.preview {
            h2 { (t.result) }
            @for (line, outcome) in outcomes {
                @match outcome {
                    Outcome::Faulty(faults) => (refused(t, &at(*line), faults)),
                    Outcome::Refused(why) => p.fault { (at(*line)) (t.words(&why.message())) },
                    Outcome::Stored { id, is_new, place } => p {
                        (at(*line)) (if *is_new { t.is_stored } else { t.was_there }) " "
                        a href={ "/" (place) "/" (id) } { (id) }
                    },
                }
            }
        }
    };
    framed(t, &Sent::default(), body)
}

fn framed(t: &Text, sent: &Sent, after: Markup) -> Page {
    let body = html! {
        h1 { (t.import) }
        p.lead { (t.import_note) }
        form.import action="/import/preview#preview" method="post" enctype="multipart/form-data" data-drop {
            p { label { (t.choose_file) " " input type="file" name="document" accept=".json,.ndjson,.jsonl,.csv,.txt,.log,.xlsx,.mat"; } }
            details open[!sent.map.is_empty()] {
                summary { (t.of_a_log) }
                label { (t.map_of_log) textarea name="map" rows="14" spellcheck="false" { (sent.map) } }
                label { (t.programme_of_log) textarea name="programme" rows="3" spellcheck="false" { (sent.programme) } }
            }
            label { (t.or_paste) textarea name="text" rows="10" spellcheck="false" { (sent.text) } }
            button.primary { (t.preview) }
        }
        (after)
    };
    Page { title: t.import.into(), section: Section::Import, body }
}

/// `Line 3 · `: where one of several documents begins.
fn place_of(t: &Text, line: usize, documents: usize) -> Markup {
    html! { @if documents > 1 { (t.line) " " (line) " · " } }
}

fn refused(t: &Text, place: &Markup, faults: &Faults) -> Markup {
    // What a table's fault says names line and column itself.
    let names_line = |fault: &Fault| fault.message.code.starts_with("at_");
    html! {
        article.fault {
            h3 { @if !faults.0.iter().any(names_line) { (place) } (t.refused) }
            ul { @for fault in &faults.0 {
                li { @if !names_line(fault) { (named(t, &fault.pointer)) } (t.words(&fault.message)) }
            } }
        }
    }
}

/// What a fault is about, in words: `gyro 2, e_pulse_per_arcsec: `. Members have the names that files have.
fn named(t: &Text, pointer: &str) -> Markup {
    let tokens: Vec<String> =
        pointer.split('/').skip(1).map(|token| token.replace("~1", "/").replace("~0", "~")).collect();
    let of_list = |k: usize| tokens.get(k + 1).and_then(|place| place.parse::<usize>().ok());
    let (mut parts, mut k) = (Vec::new(), 0);
    while let Some(token) = tokens.get(k) {
        match (token.as_str(), of_list(k)) {
            ("gyros", Some(place)) => parts.push(html! { (t.gyro_word) " " (place + 1) }),
            ("dwells", Some(place)) => parts.push(html! { (t.dwell) " " (place + 1) }),
            (name, Some(place)) => parts.push(html! { code { (name) } " " (place + 1) }),
            (name, None) => parts.push(html! { code { (name) } }),
        }
        k += if of_list(k).is_some() { 2 } else { 1 };
    }
    html! {
        (joined(", ", &parts))
        @if !parts.is_empty() { ": " }
    }
}

/// A sound document that something else stands in the way of.
fn hindered(t: &Text, place: &Markup, why: &str, offer: Option<Markup>) -> Markup {
    html! {
        article.fault {
            h3 { (place) (t.refused) }
            p { (why) }
            @if let Some(offer) = offer { (offer) }
        }
    }
}

/// Budgets by which a gyro hardly ever moves.
const FAR: f64 = 5.0;

impl ImportPreview {
    /// Whether somebody should look at it before it is stored.
    fn is_doubtful(&self) -> bool {
        match self {
            ImportPreview::Sound(submission, notes, forecast) => {
                notes.iter().any(is_doubt)
                    || forecast.as_ref().zip(submission.calibration()).is_some_and(|(forecast, calibration)| {
                        !forecast.station_is_known
                            || !unknown_serials(calibration, forecast).is_empty()
                            || forecast.gyros.iter().any(|gyro| far(gyro).is_some() || !gyro.unmet.is_empty())
                    })
            }
            _ => false,
        }
    }
}

/// Notes that say what a file is to be doubted for; others say what it lacks.
fn is_doubt(note: &Note) -> bool {
    matches!(note, Note::History(note) if !matches!(note, HistoryNote::Moved { .. }))
}

/// Gyros that nobody knows, in an IMU that is known.
fn unknown_serials<'c>(calibration: &'c Calibration, forecast: &CalibrationPreview) -> Vec<&'c str> {
    let unknown = calibration.gyros.iter().zip(&forecast.gyros).filter(|(_, foreseen)| !foreseen.is_known);
    unknown.filter(|_| forecast.imu_is_known).map(|(gyro, _)| gyro.serial.as_str()).collect()
}

/// What of a gyro is farther from its last value than it ever moves.
fn far(gyro: &GyroPreview) -> Option<(usize, Measured)> {
    let changes = gyro.change.iter().enumerate().filter_map(|(column, change)| Some((column, (*change)?)));
    changes
        .filter(|(_, change)| change.value.abs() > FAR)
        .max_by(|(_, a), (_, b)| a.value.abs().total_cmp(&b.value.abs()))
}

fn sound_document(
    t: &Text,
    place: &Markup,
    submission: &Submission,
    notes: &[Note],
    forecast: Option<&CalibrationPreview>,
) -> Markup {
    let (doubts, others): (Vec<&Note>, Vec<&Note>) = notes.iter().partition(|note| is_doubt(note));
    let others: Vec<NoteBody> = others.into_iter().map(NoteBody::of).collect();
    let of_calibration = submission.calibration().zip(forecast);
    let doubted = of_calibration.map_or(html! {}, |(calibration, forecast)| doubted(t, calibration, forecast));
    let is_doubtful = !doubts.is_empty() || !doubted.0.is_empty();
    html! {
        article.(if is_doubtful { "doubtful" } else { "sound" }) {
            @match submission {
                Submission::Calibration(calibration) => {
                    h3 { (place) (calibration.imu) }
                    p.note { (t.station) " " (calibration.station) " · " (t.calibrated) " " (instant(calibration.calibrated_at)) }
                }
                Submission::Bench(bench) => {
                    h3 { (place) (bench.result.serial) " · " (t.method(bench.result.method.name())) }
                    p {
                        (t.station) " " (bench.result.station) " · " (instant(bench.result.measured_at)) " · "
                        (symbol("D_I")) " " (figure::drift(bench.result.d_i, bench.result.d_i_sd)) " · "
                        (symbol("D_S")) " " (figure::drift(bench.result.d_s, bench.result.d_s_sd)) " " (t.unit)
                    }
                }
                _ => {}
            }
            @if is_doubtful {
                p.doubt { strong { (t.check_first) } }
                ul { @for note in &doubts { li { (NoteBody::of(note).detail) } } (doubted) }
            }
            @match (submission, forecast) {
                (Submission::Calibration(calibration), Some(forecast)) => (calibration_preview(t, calibration, forecast)),
                (Submission::Calibration(calibration), None) => (plain(calibration)),
                _ => {}
            }
            (noted(t, &others))
        }
    }
}

/// What the notes of intake do not say: of the station, of serials, of gyros one by one.
fn doubted(t: &Text, calibration: &Calibration, forecast: &CalibrationPreview) -> Markup {
    html! {
        @if !forecast.station_is_known { li { (t.station_unknown) " " strong translate="no" { (calibration.station) } } }
        @for serial in unknown_serials(calibration, forecast) { li { (t.serial_unknown) " " strong translate="no" { (serial) } } }
        @for (gyro, foreseen) in calibration.gyros.iter().zip(&forecast.gyros) {
            @if let Some((column, change)) = far(foreseen) {
                li { strong translate="no" { (gyro.serial) } ": " (symbol(DRIFTS[column])) " " (bullet::percent(change)) (t.share_of_budget_unit) ", " (t.from_last_value) }
            }
            @for one in &foreseen.unmet {
                @let verdict = gyro.requirements.iter().flatten().find(|verdict| verdict.coefficient == one.coefficient);
                li {
                    strong translate="no" { (gyro.serial) } ": " (violated(t, std::slice::from_ref(one)))
                    @for said in verdict.into_iter().flat_map(|verdict| verdict.messages().into_iter().take(1)) {
                        (t.colon) (t.words(&said))
                    }
                }
            }
        }
    }
}

/// Each coefficient beside its last value, and what it would be judged to be.
fn calibration_preview(t: &Text, calibration: &Calibration, forecast: &CalibrationPreview) -> Markup {
    html! {
        div.scroll tabindex="0" { table.foreseen {
            thead { tr {
                th { (t.slot) } th { (t.serial) }
                th { span.hidden { (t.coefficient) } } th.n { (t.value) ", " (t.unit) }
                th.n { (t.last_value) } th { (t.date) } th.n { (t.change_of_budget) }
                th.n { (t.load_word) } th { (t.status_word) }
            } }
            @for (gyro, foreseen) in calibration.gyros.iter().zip(&forecast.gyros) {
                tbody { @for (column, name) in DRIFTS.into_iter().enumerate() { tr {
                    @if column == 0 {
                        td rowspan="3" { (gyro.slot.name()) }
                        th scope="rowgroup" rowspan="3" {
                            @if foreseen.is_known { a href={ "/gyros/" (encoded(gyro.serial.as_str())) } { (gyro.serial) } }
                            @else { span translate="no" { (gyro.serial) } }
                            br; (status::badge(t, Some(foreseen.status)))
                        }
                    }
                    td { (symbol(name)) }
                    td.n { (figure::drift(foreseen.d[column].value, foreseen.d[column].sd)) }
                    @if let Some((at, last)) = &foreseen.last {
                        td.n { (figure::drift(last[column].value, last[column].sd)) } td { (day(*at)) }
                    } @else { td.n { "–" } td { (t.first_calibration) } }
                    td.n { (share(foreseen.change[column])) }
                    td.n { (share(foreseen.projection.load[column])) }
                    td { (status::badge(t, Some(foreseen.drift[column]))) }
                } } }
            }
        } }
    }
}

fn share(share: Option<Measured>) -> Markup {
    or_dash(share.map(bullet::percent))
}

/// Where it is not held against what is stored.
fn plain(calibration: &Calibration) -> Markup {
    html! {
        (wide_table("", html! {
            td {} td {} @for name in DRIFTS { th.n { (symbol(name)) } }
        }, html! { @for gyro in &calibration.gyros {
            @let rigid = &gyro.separation.rigid;
            @let sd = rigid.sd();
            tr {
                td { (gyro.slot.name()) } th scope="row" { (gyro.serial) }
                @for (i, value) in [rigid.d_i, rigid.d_s, rigid.d_o].into_iter().enumerate() {
                    td.n { (figure::drift(value, sd.map(|sd| sd[i]))) }
                }
            }
        } }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_comes_out_of_the_form_as_the_file_had_it() {
        let text = |form: &str| Sent::of(form).text;
        assert_eq!(text("text={\r\n \"a\": 1\r\n}\r\n"), "{\n \"a\": 1\n}");
        assert_eq!(text("text=a=b\r\n"), "a=b");
        assert_eq!(text("text=file=b\r\ntext=c\r\n"), "file=b\ntext=c");
        let named = Sent::of("file=ST-2 \u{53f0}.csv\r\ntext=# imu: A\r\n1\r\n");
        assert_eq!((named.file.as_str(), named.text.as_str()), ("ST-2 \u{53f0}.csv", "# imu: A\n1"));
        assert_eq!(Sent::of("text=a").file, "");
        let log = Sent::of("file=l.csv\r\nmap=imu = \"A\"\r\na = 1\r\nprogramme=24\r\ntext=t,g\r\n0,1\r\n");
        assert_eq!((log.map.as_str(), log.programme.as_str()), ("imu = \"A\"\na = 1", "24"));
        assert_eq!((log.file.as_str(), log.text.as_str()), ("l.csv", "t,g\n0,1"));
        let none = Sent::of("map=\r\nprogramme=\r\ntext=a\r\n");
        assert_eq!((none.map.as_str(), none.programme.as_str(), none.text.as_str()), ("", "", "a"));
    }
}
