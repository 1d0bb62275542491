//! `/v1/gyros/{serial}/events`: what was done to a gyro, so that the rules know what not to compare.

use super::baseline::FixedBody;
use super::remark::{self, SentRemark};
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::{Event, Rule};
use crate::http::prelude::*;
use crate::wire::event::read_test;

/// What was done to a gyro.
#[derive(Serialize, ToSchema)]
pub struct EventBody {
    id: String,
    at: String,
    /// `baseline`, `repair`, `reinstallation`, `transport`, `firmware`, `note`, `environmental_test`, `retired`,
    /// `in_storage`, `decision_release`, `decision_retest`, `decision_remove` or `decision_withdrawn`.
    event: &'static str,
    /// Which environmental test it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<String>,
    /// When it was over, of what took time.
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<String>,
    reason: String,
    #[schema(required)]
    author: Option<String>,
    /// Rules that do not compare what was before with what comes after.
    resets: Vec<&'static str>,
    /// The levels that a baseline mark states.
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed: Option<FixedBody>,
}

impl EventBody {
    pub fn of(id: Id, done: &GyroEvent) -> Self {
        let GyroEvent { at, event, until, test, fixed, reason, author } = done;
        Self {
            id: id.to_string(),
            at: time::format(*at),
            event: event.name(),
            kind: test.clone(),
            to: until.map(time::format),
            reason: reason.clone(),
            author: author.clone(),
            resets: event.rules_reset().map(Rule::name).collect(),
            fixed: FixedBody::of(fixed),
        }
    }

    pub fn all(events: &[(Id, GyroEvent)]) -> Vec<Self> {
        events.iter().map(|(id, done)| Self::of(*id, done)).collect()
    }
}

/// Events, oldest first.
#[derive(Serialize, ToSchema)]
pub struct Events {
    serial: String,
    events: Vec<EventBody>,
}

/// What was done to a gyro, oldest first.
#[utoipa::path(get, path = "/v1/gyros/{serial}/events", tag = "gyros",
    responses((status = 200, description = "the events", body = Events)))]
pub async fn get_events(app: App, Path(serial): Path<String>) -> Answer<Json<Events>> {
    let events = app.pipeline.queries.histories.events(query::gyro(&app, &serial)?).await?;
    Ok(Json(Events { serial, events: EventBody::all(&events) }))
}

/// What was done, when and why.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct NewEvent {
    /// `repair`, `reinstallation`, `transport`, `firmware`, `note`, `environmental_test`, `retired`, `in_storage`,
    /// `decision_release`, `decision_retest`, `decision_remove`, `decision_withdrawn` or `baseline`.
    event: String,
    /// In words.
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
    /// When, a day (UTC) or an RFC 3339 time; now, where it is left out.
    #[serde(default, alias = "from")]
    at: Option<String>,
    /// Of an environmental test: when it was over.
    to: Option<String>,
    /// Of an environmental test: which, as `vibration` or `thermal cycling`.
    kind: Option<String>,
    author: Option<String>,
}

/// Says what was done to a gyro. What the event resets is judged again.
#[utoipa::path(post, path = "/v1/gyros/{serial}/events", tag = "gyros", request_body = NewEvent,
    responses(
        (status = 201, description = "the event is stored", body = EventBody),
        (status = 200, description = "was stored before, with the same words", body = EventBody),
        (status = 409, description = "the same kind of event is stored at that very time, with other words")))]
pub async fn post_event(app: App, Path(serial): Path<String>, body: Document) -> Answer<(StatusCode, Json<EventBody>)> {
    let (status, id, event) = remark::post(&app, &serial, &body, read, message!("event_there")).await?;
    Ok((status, Json(EventBody::of(id, &event))))
}

fn read(app: &App, bytes: &[u8]) -> Result<GyroEvent, Faults> {
    let NewEvent { event, reason, at, to, kind, author } = json::parse(bytes)?;
    let mut faults = Faults::default();
    // People write re-installation in more than one way.
    let event = if matches!(&*event, "re_installation" | "re-installation") { "reinstallation" } else { &event };
    let event = text::named("/event", event, &mut faults).unwrap_or(Event::Note);
    let (reason, at, author) = SentRemark { reason, at, author }.read(app, message!("empty_text"), &mut faults);
    let (until, test) = read_test(event, at, (to, kind), &mut faults);
    faults.or(GyroEvent { at, event, until, test, fixed: [None; 2], reason, author })
}
