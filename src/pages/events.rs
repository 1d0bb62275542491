//! `/gyros/{serial}/events/new`: what was done to a gyro, or a new baseline, on a page that says what that changes.

use tokio::time::Instant;

use super::form::{self, ActionForm, Word, see_other, typed_time};
use super::gyro::{PATIENCE, explained};
use super::gyro_facts::Facts;
use super::gyro_head;
use super::prelude::*;
use super::view::View;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::Event;
use crate::core::record::Name;
use crate::pipeline::{Accepted, EventOrder, Submission};
use crate::wire::event::read_test;
use crate::wire::text;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct EventForm {
    #[serde(flatten)]
    word: Word,
    event: String,
    /// RFC 3339; now, where it is empty.
    at: String,
    /// Of an environmental test.
    to: String,
    kind: String,
}

/// What a form is for: a baseline, a decision, or whatever else was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum About {
    Baseline,
    Decision,
    Other,
}

impl About {
    fn of(event: Option<Event>) -> Self {
        match event {
            Some(Event::Baseline) => Self::Baseline,
            Some(event) if event.is_decision() => Self::Decision,
            _ => Self::Other,
        }
    }

    fn title(self, t: &Text) -> &'static str {
        match self {
            Self::Baseline => t.start_baseline,
            Self::Decision => t.record_decision,
            Self::Other => t.add_event,
        }
    }

    fn events(self) -> impl Iterator<Item = Event> {
        Event::ALL.into_iter().filter(move |event| Self::of(Some(*event)) == self)
    }
}

/// The page on which an event is noted; `?event=baseline` starts a baseline, `?event=decision_retest` records a
/// decision.
pub(super) async fn ask(
    PageContext(ref pages, ref viewer): PageContext,
    Path(serial): Path<String>,
    Query(said): Query<EventForm>,
) -> Result<Page, Problem> {
    let (t, name) = (viewer.text(), known(pages, &serial)?);
    let stands = how_it_stands(pages, t, &serial, &said).await?;
    Ok(form(t, &name, &said, &stands).fresh(viewer, &said.word))
}

/// What a decision is made by: status and suggestion, as on the gyro's page. Nothing where none is made.
async fn how_it_stands(pages: &Pages, t: &Text, serial: &str, said: &EventForm) -> Result<Markup, Problem> {
    if About::of(Event::from_name(&said.event)) != About::Decision {
        return Ok(Markup::default());
    }
    let number = pages.gyro_number(serial)?;
    let facts = Facts::of(pages, number, serial, &View::whole(pages.config.judging.method), 0).await?;
    let explained = explained(pages, number, serial, &facts, Instant::now() + PATIENCE).await?;
    let status = facts.standing.as_ref().and_then(|standing| standing.status);
    let is_out = status.is_some_and(|status| status > Status::Drifting);
    Ok(html! {
        p.lead { (facts.badge(t)) }
        (gyro_head::doubted(t, &facts))
        (gyro_head::suggested(t, &facts, explained.as_ref()))
        (gyro_head::decision(t, &facts))
        @if is_out { p.lead { strong { (t.release_though_out) } } }
    })
}

fn known(pages: &Pages, serial: &str) -> Result<Name, Problem> {
    pages.gyro_number(serial)?;
    Name::parse(serial).map_err(|_| Problem::unknown_gyro(serial))
}

pub(super) async fn act(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref serial): Path<String>,
    Form(ref said): Form<EventForm>,
) -> Result<Response, Problem> {
    let name = known(pages, serial)?;
    let mut faults = Faults::default();
    said.word.check(&mut faults);
    let event = Event::from_name(&said.event);
    if event.is_none() {
        faults.push("event", message!("event_needed"));
    }
    let mut of_time = Faults::default();
    let at = match said.at.trim() {
        "" => pages.clock.now(),
        at => text::start("at", &typed_time(at), &mut of_time),
    };
    // What cannot be read is no time that could be impossible.
    let of_time = of_time.or(()).and_then(|()| pages.pipeline.reader.check_time("at", at));
    of_time.unwrap_or_else(|of_time| faults.absorb("", of_time));
    let test = event.map(|event| {
        read_test(event, at, (form::said(&said.to).map(|to| typed_time(&to)), form::said(&said.kind)), &mut faults)
    });
    let Some((event, (until, test))) = event.zip(test).filter(|_| faults.is_empty()) else {
        let stands = how_it_stands(pages, viewer.text(), serial, said).await?;
        return Ok(form(viewer.text(), &name, said, &stands).again(viewer, &said.word, &faults));
    };
    let Word { by, reason, .. } = said.word.clone();
    let event = GyroEvent { at, event, until, test, fixed: [None; 2], reason, author: Some(by) };
    let order = EventOrder { serial: name, event };
    match pages.pipeline.ingest.submit(Submission::Event(order)).await? {
        Accepted::Stored { .. } | Accepted::There { same_bytes: true, .. } => {
            Ok(see_other(&format!("/gyros/{}#happenings", encoded(serial))))
        }
        Accepted::There { id, .. } => {
            let detail = message!("event_there");
            Err(Problem::new(409, "title_differs", detail).with_existing(id))
        }
    }
}

/// `stands`: how the gyro stands, where that matters.
fn form(t: &Text, serial: &Name, said: &EventForm, stands: &Markup) -> ActionForm {
    let about = About::of(Event::from_name(&said.event));
    let title = about.title(t);
    let path = format!("/gyros/{}", encoded(serial.as_str()));
    let fields = html! {
        @if about == About::Baseline { input type="hidden" name="event" value=(said.event); }
        @else {
            label { (if about == About::Decision { t.decision } else { t.event_word }) select name="event" {
                @for event in about.events() {
                    option value=(event.name()) selected[event.name() == said.event] { (t.event(event)) }
                }
            } }
        }
        label { (t.event_at) input name="at" value=(said.at) data-time placeholder="2026-03-01 16:00"; }
        @if about == About::Other {
            label { (t.event_test_kind) input name="kind" value=(said.kind); }
            label { (t.event_test_to) input name="to" value=(said.to) data-time placeholder="2026-03-03 16:00"; }
        }
    };
    ActionForm {
        section: Section::Fleet,
        title: format!("{title}: {serial}"),
        what: html! { (stands) (what_it_resets(t, about)) },
        fields,
        action: format!("{path}/events/new"),
        button: title,
        back: path,
        ..ActionForm::default()
    }
}

/// What the rules will no longer compare with what came before.
fn what_it_resets(t: &Text, about: About) -> Markup {
    let resets = |event: Event| -> Vec<&str> { event.rules_reset().map(|rule| t.rule(rule)).collect() };
    html! {
        p.lead { (if about == About::Decision { t.decision_what } else { t.event_what }) }
        @if about != About::Decision { ul {
            @for event in about.events() {
                @let rules = resets(event);
                @let said = if rules.is_empty() { t.resets_nothing.to_owned() } else { rules.join(", ") };
                li { strong { (t.event(event)) } ": " (said) }
            }
        } }
    }
}
