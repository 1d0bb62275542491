//! CloudEvents 1.0 in the structured JSON format.

use serde::Serialize;
use serde_json::Value;

use super::body::{Context, Payload};
use super::standard;
use crate::alert::message::{HookEvent, HookMessage};
use crate::wire::time;

#[derive(Serialize)]
struct CloudEvent<'a> {
    specversion: &'static str,
    id: &'a str,
    source: &'a str,
    r#type: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<&'a str>,
    time: String,
    datacontenttype: &'static str,
    data: Value,
}

pub fn render(message: &HookMessage, context: &Context<'_>) -> Payload {
    let subject = match &message.event {
        HookEvent::Alerts(changes) => changes.first().map(|change| change.alert.name()),
        HookEvent::Digest(..) | HookEvent::Test => None,
    };
    // An attribute beside `data` may hold no list.
    let mut data = standard::data(&message.event, context);
    if let Some(alerts) = standard::alerts(&message.event, context) {
        data["alerts"] = alerts.into();
    }
    let body = CloudEvent {
        specversion: "1.0",
        id: &message.id,
        source: context.external_url.unwrap_or("/gyrowatch"),
        r#type: format!("gyrowatch.{}", message.event.name()),
        subject,
        time: time::format(message.at),
        datacontenttype: "application/json",
        data,
    };
    Payload::json("application/cloudevents+json; charset=UTF-8", &body)
}
