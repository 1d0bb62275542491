//! Standard Webhooks 1.0: `type`, `timestamp`, `data`; beside them `alerts`, all that the message tells of.

use serde::Serialize;
use serde_json::{Value, json};

use super::body::{Context, MOST_LISTED, Payload, alert_page, most_listed, page};
use crate::alert::message::{AlertTransition, HookEvent, HookMessage, event_name};
use crate::wire::time;

#[derive(Serialize)]
struct StandardBody {
    r#type: &'static str,
    timestamp: String,
    data: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    alerts: Option<Vec<Value>>,
}

pub fn render(message: &HookMessage, context: &Context<'_>) -> Payload {
    let body = StandardBody {
        r#type: message.event.name(),
        timestamp: time::format(message.at),
        data: data(&message.event, context),
        alerts: alerts(&message.event, context),
    };
    Payload::json("application/json", &body)
}

/// The gravest alert as `GET /v1/alerts/{id}` shows it, as it was when the message came about; of a digest its counts.
pub fn data(event: &HookEvent, context: &Context<'_>) -> Value {
    match event {
        HookEvent::Alerts(changes) => changes.first().map_or(Value::Null, |change| alert(change, context)),
        HookEvent::Digest(counts, changes) => {
            let mut data = serde_json::to_value(counts).expect("counts have string keys");
            data["listed"] = changes.len().min(MOST_LISTED).into();
            data["links"] = json!({ "alerts": format!("{}/alerts", context.external_url.unwrap_or_default()) });
            data
        }
        HookEvent::Test => json!({ "test": true }),
    }
}

/// Every alert that the message tells of, each with its own `event`; of a digest the first of them. None for a test.
pub fn alerts(event: &HookEvent, context: &Context<'_>) -> Option<Vec<Value>> {
    let told = |change: &AlertTransition| {
        let mut told = alert(change, context);
        told["event"] = event_name(Some(change.action)).into();
        told
    };
    let changes = event.changes();
    (!changes.is_empty()).then(|| changes.iter().take(most_listed(event)).map(told).collect())
}

fn alert(change: &AlertTransition, context: &Context<'_>) -> Value {
    let mut alert =
        serde_json::to_value(&change.alert).expect("an alert has string keys, and every figure is finite or null");
    let mut links = json!({ "alert": alert_page(context, &change.alert) });
    links[&*change.alert.subject] = page(context, &change.alert).into();
    alert["links"] = links;
    alert
}
