//! Standard Webhooks 1.0: `type`, `timestamp`, `data`.

use serde::Serialize;
use serde_json::{Value, json};

use super::{Payload, to_json};
use crate::alert::message::{Event, Message};
use crate::wire::time;

#[derive(Serialize)]
struct Body {
    r#type: &'static str,
    timestamp: String,
    data: Value,
}

pub fn render(message: &Message) -> Payload {
    let body = Body { r#type: message.event.name(), timestamp: time::format(message.at), data: data(&message.event) };
    Payload { content_type: "application/json", body: to_json(&body) }
}

/// The alert as `GET /v1/alerts/{id}` shows it, as it was when the message came about.
pub fn data(event: &Event) -> Value {
    match event {
        Event::Alert(_, alert) => {
            serde_json::to_value(alert).expect("an alert has string keys, and every figure is finite or null")
        }
        Event::Test => json!({ "test": true }),
    }
}
