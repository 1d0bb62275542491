//! Alertmanager's two formats: the alerts that are pushed to it, and the body (version 4) that it posts to others.
//!
//! An Alertmanager knows an alert by its label set, so labels hold what lasts (gyro, coefficient, rule) and the
//! severity, by which people route; figures and the IMU of the day are annotations. When the severity rises, the
//! label set of the lower one is resolved in the same breath.

use std::collections::BTreeMap;

use serde::Serialize;

use super::body::{Context, Payload, alert_page, most_listed, summary};
use crate::alert::message::{AlertTransition, HookEvent, HookMessage};
use crate::core::alert_decision::Action;
use crate::core::judge::Severity;
use crate::core::time::UtcMicros;
use crate::message;
use crate::wire::alert::AlertBody;
use crate::wire::{time, unit};
use crate::words::asked;

/// A pushed alert expires by itself when so many pushes have failed to come, but not within a day: a service that is
/// down for the night must not look like gyros that have recovered.
pub const EXPIRES_AFTER_RESENDS: i64 = 4;
const EXPIRES_NOT_WITHIN: i64 = 86_400 * 1_000_000;

/// What Go's zero time looks like: an alert that has no end yet.
const NO_END: &str = "0001-01-01T00:00:00Z";

type Labels = BTreeMap<&'static str, String>;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct PostedAlert {
    labels: Labels,
    annotations: Labels,
    starts_at: String,
    ends_at: String,
    #[serde(rename = "generatorURL")]
    generator_url: String,
}

#[derive(Serialize)]
struct ReceivedAlert {
    status: &'static str,
    #[serde(flatten)]
    alert: PostedAlert,
    fingerprint: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Webhook<'a> {
    version: &'static str,
    group_key: String,
    truncated_alerts: usize,
    status: &'static str,
    receiver: &'a str,
    group_labels: Labels,
    common_labels: Labels,
    common_annotations: Labels,
    #[serde(rename = "externalURL")]
    external_url: &'a str,
    alerts: Vec<ReceivedAlert>,
}

/// `POST /api/v2/alerts` of a message.
pub fn render_push(message: &HookMessage, context: &Context<'_>) -> Payload {
    let alerts = alerts_of(message, context, &time::format(expiry(context))).into_iter();
    let alerts: Vec<PostedAlert> = alerts.map(|received| received.alert).collect();
    Payload::json("application/json", &alerts)
}

/// `POST /api/v2/alerts` of everything that fires: sent again and again, so that an Alertmanager that was restarted
/// knows it too and one that is not told any more lets it go.
///
/// Each with the severity that was told: the label set that the Alertmanager knows.
pub fn push_firing(firing: &[(String, AlertBody)], context: &Context<'_>) -> Payload {
    let expiry = time::format(expiry(context));
    let told = |(severity, alert): &(String, AlertBody)| of_alert(alert, severity, &expiry, context);
    let alerts: Vec<PostedAlert> = firing.iter().map(told).collect();
    Payload::json("application/json", &alerts)
}

/// The body that an Alertmanager would post to its webhook receivers.
pub fn render_webhook(message: &HookMessage, context: &Context<'_>) -> Payload {
    let mut alerts = alerts_of(message, context, NO_END);
    let most = most_listed(&message.event);
    let truncated_alerts = alerts.len().saturating_sub(most);
    alerts.truncate(most);
    let status = if alerts.iter().any(|alert| alert.status == "firing") { "firing" } else { "resolved" };
    let group_labels = group_labels(&message.event);
    let body = Webhook {
        version: "4",
        group_key: group_key(&group_labels),
        truncated_alerts,
        status,
        receiver: context.hook,
        group_labels,
        common_labels: common(alerts.iter().map(|alert| &alert.alert.labels)),
        common_annotations: common(alerts.iter().map(|alert| &alert.alert.annotations)),
        external_url: context.external_url.unwrap_or_default(),
        alerts,
    };
    Payload::json("application/json", &body)
}

fn expiry(context: &Context<'_>) -> UtcMicros {
    let after = context.resend_every.saturating_mul(EXPIRES_AFTER_RESENDS).max(EXPIRES_NOT_WITHIN);
    UtcMicros(context.now.0.saturating_add(after))
}

/// The alerts of the message, each that has changed its severity followed by that of the other severity, resolved: the
/// severity is a label, and with other labels it is another alert.
fn alerts_of(message: &HookMessage, context: &Context<'_>, open_end: &str) -> Vec<ReceivedAlert> {
    if message.event == HookEvent::Test {
        return vec![received("firing", test_alert(message, context, open_end))];
    }
    let at = time::format(message.at);
    message.event.changes().iter().flat_map(|change| alerts_of_change(change, &at, context, open_end)).collect()
}

fn alerts_of_change(
    AlertTransition { action, alert }: &AlertTransition,
    at: &str,
    context: &Context<'_>,
    open_end: &str,
) -> Vec<ReceivedAlert> {
    if *action == Action::Resolve {
        return vec![received("resolved", of_alert(alert, &alert.severity, at, context))];
    }
    let mut alerts = vec![received("firing", of_alert(alert, &alert.severity, open_end, context))];
    if matches!(action, Action::Escalate | Action::Lower) {
        let others = Severity::ALL.into_iter().filter(|severity| severity.name() != alert.severity);
        alerts.extend(others.map(|severity| received("resolved", of_alert(alert, severity.name(), at, context))));
    }
    alerts
}

fn of_alert(alert: &AlertBody, severity: &str, ends_at: &str, context: &Context<'_>) -> PostedAlert {
    let mut labels = identity(alert);
    labels.insert("severity", severity.to_owned());
    let finding = &alert.finding;
    let mut annotations = Labels::from([
        ("summary", summary(alert, alert.state == "resolved")),
        ("description", finding.reason.words(asked()).into_owned()),
        ("limit", format!("{} {}", finding.limit, unit::of_people(&finding.unit))),
    ]);
    let known = [
        ("value", finding.value.map(|value| format!("{value} {}", unit::of_people(&finding.unit)))),
        ("imu", finding.imu.clone()),
        ("slot", finding.slot.as_ref().map(ToString::to_string)),
        ("station", finding.station.clone()),
        ("record", finding.record.clone()),
        ("calibrated_at", finding.calibrated_at.clone()),
    ];
    annotations.extend(known.into_iter().filter_map(|(name, text)| Some((name, text?))));
    PostedAlert {
        labels,
        annotations,
        starts_at: alert.fired_at.clone(),
        ends_at: ends_at.to_owned(),
        generator_url: alert_page(context, alert),
    }
}

fn test_alert(message: &HookMessage, context: &Context<'_>, ends_at: &str) -> PostedAlert {
    let summary = asked().words(&message!("mail_test", hook = context.hook.to_owned()));
    PostedAlert {
        labels: Labels::from([("alertname", "GyrowatchTest".to_owned()), ("severity", "none".to_owned())]),
        annotations: Labels::from([("summary", summary)]),
        starts_at: time::format(message.at),
        ends_at: ends_at.to_owned(),
        generator_url: context.external_url.unwrap_or_default().to_owned(),
    }
}

/// What makes the alert this alert, whatever its severity.
fn identity(alert: &AlertBody) -> Labels {
    let subject = match alert.subject.as_ref() {
        AlertBody::OF_STATION => "station",
        AlertBody::OF_IMU => "imu",
        AlertBody::OF_BATCH => "batch",
        _ => "serial",
    };
    Labels::from([
        ("alertname", alert_name(&alert.rule)),
        (subject, alert.name().to_owned()),
        ("coefficient", alert.coefficient.to_string()),
        ("rule", alert.rule.to_string()),
    ])
}

/// What all alerts of the message have in common of what makes each this alert.
fn group_labels(event: &HookEvent) -> Labels {
    if *event == HookEvent::Test {
        return Labels::from([("alertname", "GyrowatchTest".to_owned())]);
    }
    let identities: Vec<Labels> = event.changes().iter().map(|change| identity(&change.alert)).collect();
    common(identities.iter())
}

/// `rms_successive` -> `GyroRmsSuccessive`.
fn alert_name(rule: &str) -> String {
    let mut name = "Gyro".to_owned();
    for word in rule.split('_') {
        let mut chars = word.chars();
        name.extend(chars.next().map(|first| first.to_ascii_uppercase()));
        name.push_str(chars.as_str());
    }
    name
}

/// `{}:{alertname="GyroStep", …}`, as Alertmanager writes a group of its root route.
fn group_key(labels: &Labels) -> String {
    let pairs: Vec<String> = labels.iter().map(|(name, value)| format!("{name}={value:?}")).collect();
    format!("{{}}:{{{}}}", pairs.join(", "))
}

/// The pairs that all have.
fn common<'l>(mut all: impl Iterator<Item = &'l Labels>) -> Labels {
    let mut common = all.next().cloned().unwrap_or_default();
    for other in all {
        common.retain(|name, value| other.get(name) == Some(value));
    }
    common
}

fn received(status: &'static str, alert: PostedAlert) -> ReceivedAlert {
    let fingerprint = format!("{:016x}", fingerprint(&alert.labels));
    ReceivedAlert { status, alert, fingerprint }
}

/// How Alertmanager knows a label set: FNV-1a (64 bit) over the sorted names and values, each followed by 0xff.
fn fingerprint(labels: &Labels) -> u64 {
    let bytes = labels.iter().flat_map(|(name, value)| {
        name.bytes().chain(std::iter::once(0xff)).chain(value.bytes()).chain(std::iter::once(0xff))
    });
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
