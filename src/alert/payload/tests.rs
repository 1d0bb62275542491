use insta::assert_json_snapshot;
use serde_json::Value;

use super::*;
use crate::alert::message::{AlertTransition, HookEvent};
use crate::core::alert_decision::Action;
use crate::core::time::UtcMicros;
use crate::message;
use crate::wire::alert::{AlertBody, AlertFindingBody};
use crate::wire::reason::Reason;

fn alert() -> AlertBody {
    AlertBody {
        id: "a1".into(),
        subject: AlertBody::OF_GYRO.into(),
        serial: "LFG 01/01".into(),
        coefficient: "D_I".into(),
        rule: "rms_successive".into(),
        state: "firing".into(),
        status: None,
        severity: "critical".into(),
        since: Some("2026-02-28T08:00:00Z".into()),
        fired_at: "2026-03-01T08:00:00Z".into(),
        resolved_at: None,
        finding: AlertFindingBody {
            value: Some(0.0123),
            limit: 0.01,
            unit: "deg/(h g0)".into(),
            sd: None,
            probability: None,
            reason: Reason(vec![message!("rms_explained", explained = "0.00720")]),
            record: Some("r1".into()),
            calibrated_at: Some("2026-02-28T08:00:00Z".into()),
            imu: Some("IMU-07".into()),
            slot: Some("G1".into()),
            station: Some("ST-2".into()),
            batch: None,
            with_imu: None,
        },
        acknowledged: None,
        silenced: None,
        inhibited_by: None,
    }
}

fn message(action: Action) -> HookMessage {
    let mut alert = alert();
    if action == Action::Resolve {
        alert.state = "resolved".into();
        alert.resolved_at = Some("2026-03-01T09:00:00Z".into());
    }
    // 2026-03-01T09:00:00Z
    HookMessage {
        id: "evt_1".into(),
        at: UtcMicros(1_772_355_600_000_000),
        event: HookEvent::Alerts(vec![AlertTransition { action, alert }]),
    }
}

const CONTEXT: Context<'static> = Context {
    hook: "pager",
    external_url: Some("https://gyros.example"),
    resend_every: 60_000_000,
    now: UtcMicros(1_772_355_610_000_000),
};

fn rendered(kind: HookKind, message: &HookMessage) -> Value {
    serde_json::from_slice(&render(kind, message, &CONTEXT).body).unwrap()
}

#[test]
fn a_standard_webhook_holds_type_timestamp_and_the_alert() {
    let body = rendered(HookKind::StandardWebhooks, &message(Action::Fire));
    assert_eq!(body["type"], "alert.fired");
    assert_eq!(body["timestamp"], "2026-03-01T09:00:00Z");
    let told: AlertBody = serde_json::from_value(body["data"].clone()).unwrap();
    assert_eq!(AlertBody { finding: alert().finding, ..told }, alert());
    assert_eq!(
        (&body["data"]["code"], &body["data"]["parameters"]["explained"]),
        (&"rms_explained".into(), &"0.00720".into())
    );
    assert_eq!(body["data"]["reason"], "Stated standard deviations explain 0.00720.");
    assert_eq!(
        body["data"]["links"],
        serde_json::json!({ "alert": "https://gyros.example/alerts/a1", "gyro": "https://gyros.example/gyros/LFG%2001%2F01" })
    );
    assert_eq!(body["alerts"][0]["event"], "alert.fired");
    assert_eq!(body.as_object().unwrap().len(), 4);
}

#[test]
fn a_cloud_event_is_complete() {
    let mut body = rendered(HookKind::CloudEvents, &message(Action::Resolve));
    assert_eq!(body["data"].take()["serial"], "LFG 01/01");
    assert_json_snapshot!(body, @r#"
    {
      "data": null,
      "datacontenttype": "application/json",
      "id": "evt_1",
      "source": "https://gyros.example",
      "specversion": "1.0",
      "subject": "LFG 01/01",
      "time": "2026-03-01T09:00:00Z",
      "type": "gyrowatch.alert.resolved"
    }
    "#);
}

#[test]
fn a_pushed_alert_expires_when_pushes_stop() {
    assert_json_snapshot!(rendered(HookKind::Alertmanager, &message(Action::Fire)), @r#"
    [
      {
        "annotations": {
          "calibrated_at": "2026-02-28T08:00:00Z",
          "description": "Stated standard deviations explain 0.00720.",
          "imu": "IMU-07",
          "limit": "0.01 deg/(h g0)",
          "record": "r1",
          "slot": "G1",
          "station": "ST-2",
          "summary": "LFG 01/01: D_I rms_successive fires (critical)",
          "value": "0.0123 deg/(h g0)"
        },
        "endsAt": "2026-03-02T09:00:10Z",
        "generatorURL": "https://gyros.example/alerts/a1",
        "labels": {
          "alertname": "GyroRmsSuccessive",
          "coefficient": "D_I",
          "rule": "rms_successive",
          "serial": "LFG 01/01",
          "severity": "critical"
        },
        "startsAt": "2026-03-01T08:00:00Z"
      }
    ]
    "#);
}

#[test]
fn an_alertmanager_is_told_that_the_warning_ended_when_the_alert_became_critical() {
    let body = rendered(HookKind::Alertmanager, &message(Action::Escalate));
    let ends: Vec<_> = body.as_array().unwrap().iter().map(|a| (&a["labels"]["severity"], &a["endsAt"])).collect();
    assert_eq!(ends.len(), 2);
    assert_eq!(ends[0], (&Value::from("critical"), &Value::from("2026-03-02T09:00:10Z")));
    assert_eq!(ends[1], (&Value::from("warning"), &Value::from("2026-03-01T09:00:00Z")));
}

#[test]
fn an_alertmanager_is_told_that_the_critical_alert_ended_when_it_is_confirmed_no_more() {
    let body = rendered(
        HookKind::Alertmanager,
        &HookMessage {
            event: HookEvent::Alerts(vec![AlertTransition {
                action: Action::Lower,
                alert: AlertBody { severity: "warning".into(), ..alert() },
            }]),
            ..message(Action::Lower)
        },
    );
    let ends: Vec<_> = body.as_array().unwrap().iter().map(|a| (&a["labels"]["severity"], &a["endsAt"])).collect();
    assert_eq!(ends[0], (&Value::from("warning"), &Value::from("2026-03-02T09:00:10Z")));
    assert_eq!(ends[1..], [(&Value::from("critical"), &Value::from("2026-03-01T09:00:00Z"))]);
}

#[test]
fn labels_are_the_same_when_it_fires_and_when_it_resolves() {
    let labels = |action| rendered(HookKind::Alertmanager, &message(action))[0]["labels"].clone();
    assert_eq!(labels(Action::Fire), labels(Action::Resolve));
    let ends_at = &rendered(HookKind::Alertmanager, &message(Action::Resolve))[0]["endsAt"];
    assert_eq!(ends_at, "2026-03-01T09:00:00Z");
}

#[test]
fn a_push_of_all_that_fires_holds_them_all() {
    let pushed = push_firing(
        &[("critical".into(), alert()), ("warning".into(), AlertBody { serial: "LFG-2".into(), ..alert() })],
        &CONTEXT,
    );
    let body: Value = serde_json::from_slice(&pushed.body).unwrap();
    assert_eq!(body[0], rendered(HookKind::Alertmanager, &message(Action::Repeat))[0]);
    assert_eq!(body[1]["labels"]["serial"], "LFG-2");
    assert_eq!(body[1]["labels"]["severity"], "warning", "as it was told, whatever it has become");
}

#[test]
fn the_webhook_body_is_what_alertmanager_posts() {
    let mut body = rendered(HookKind::AlertmanagerWebhook, &message(Action::Fire));
    assert_eq!(body["alerts"][0]["annotations"].take(), body["commonAnnotations"].take());
    assert_json_snapshot!(body, @r#"
    {
      "alerts": [
        {
          "annotations": null,
          "endsAt": "0001-01-01T00:00:00Z",
          "fingerprint": "524e15a1f4e6caa5",
          "generatorURL": "https://gyros.example/alerts/a1",
          "labels": {
            "alertname": "GyroRmsSuccessive",
            "coefficient": "D_I",
            "rule": "rms_successive",
            "serial": "LFG 01/01",
            "severity": "critical"
          },
          "startsAt": "2026-03-01T08:00:00Z",
          "status": "firing"
        }
      ],
      "commonAnnotations": null,
      "commonLabels": {
        "alertname": "GyroRmsSuccessive",
        "coefficient": "D_I",
        "rule": "rms_successive",
        "serial": "LFG 01/01",
        "severity": "critical"
      },
      "externalURL": "https://gyros.example",
      "groupKey": "{}:{alertname=\"GyroRmsSuccessive\", coefficient=\"D_I\", rule=\"rms_successive\", serial=\"LFG 01/01\"}",
      "groupLabels": {
        "alertname": "GyroRmsSuccessive",
        "coefficient": "D_I",
        "rule": "rms_successive",
        "serial": "LFG 01/01"
      },
      "receiver": "pager",
      "status": "firing",
      "truncatedAlerts": 0,
      "version": "4"
    }
    "#);
    let resolved = rendered(HookKind::AlertmanagerWebhook, &message(Action::Resolve));
    assert_eq!((&resolved["status"], &resolved["alerts"][0]["status"]), (&"resolved".into(), &"resolved".into()));
    let escalated = rendered(HookKind::AlertmanagerWebhook, &message(Action::Escalate));
    assert_eq!(escalated["status"], "firing");
    assert_eq!(escalated["alerts"][1]["status"], "resolved");
    assert!(escalated["commonLabels"].get("severity").is_none());
}

/// Two alerts of one gyro, the second of which has ended.
fn batch() -> HookMessage {
    let ended = AlertBody { id: "a2".into(), rule: "step".into(), state: "resolved".into(), ..alert() };
    let changes = vec![
        AlertTransition { action: Action::Escalate, alert: alert() },
        AlertTransition { action: Action::Resolve, alert: ended },
    ];
    HookMessage { event: HookEvent::Alerts(changes), ..message(Action::Fire) }
}

#[test]
fn one_message_of_many_alerts_is_the_gravest_with_all_beside_it() {
    let body = rendered(HookKind::StandardWebhooks, &batch());
    assert_eq!((&body["type"], &body["data"]["id"]), (&"alert.escalated".into(), &"a1".into()));
    let events: Vec<_> = body["alerts"].as_array().unwrap().iter().map(|one| (&one["id"], &one["event"])).collect();
    assert_eq!(events, [(&"a1".into(), &"alert.escalated".into()), (&"a2".into(), &"alert.resolved".into())]);
    let event = rendered(HookKind::CloudEvents, &batch());
    assert_eq!((&event["data"]["id"], &event["data"]["alerts"]), (&body["data"]["id"], &body["alerts"]));
    assert!(event.get("alerts").is_none(), "an attribute of a CloudEvent holds no list");

    let webhook = rendered(HookKind::AlertmanagerWebhook, &batch());
    let stands: Vec<_> = webhook["alerts"].as_array().unwrap().iter().map(|one| &one["status"]).collect();
    assert_eq!(stands, ["firing", "resolved", "resolved"], "the warning of what is critical now, and the other");
    assert_eq!(webhook["groupLabels"], serde_json::json!({ "coefficient": "D_I", "serial": "LFG 01/01" }));
    assert_eq!(rendered(HookKind::Alertmanager, &batch()).as_array().unwrap().len(), 3);
}

#[test]
fn a_digest_counts_all_and_lists_the_first_hundred() {
    let all: Vec<AlertBody> = (0..250)
        .map(|i| AlertBody {
            serial: format!("G{}", i / 2),
            severity: if i < 20 { "critical" } else { "warning" }.into(),
            rule: if i % 5 == 0 { "step" } else { "baseline" }.into(),
            ..alert()
        })
        .collect();
    let counts = crate::wire::hook::DigestBody::of(&all.iter().collect::<Vec<_>>());
    let changes = all.into_iter().map(|alert| AlertTransition { action: Action::Fire, alert }).collect();
    let message = HookMessage { event: HookEvent::Digest(counts, changes), ..message(Action::Fire) };
    let body = rendered(HookKind::StandardWebhooks, &message);
    assert_eq!(body["type"], "alerts.digest");
    assert_eq!(
        body["data"],
        serde_json::json!({ "total": 250, "gyros": 125, "critical": 20, "warning": 230, "listed": 100,
            "rules": { "baseline": 200, "step": 50 }, "links": { "alerts": "https://gyros.example/alerts" } })
    );
    assert_eq!(body["alerts"].as_array().unwrap().len(), 100);
    let event = rendered(HookKind::CloudEvents, &message);
    assert_eq!((&event["type"], &event["data"]["total"]), (&"gyrowatch.alerts.digest".into(), &250.into()));
    let webhook = rendered(HookKind::AlertmanagerWebhook, &message);
    assert_eq!((webhook["alerts"].as_array().unwrap().len(), &webhook["truncatedAlerts"]), (100, &150.into()));
    assert_eq!(rendered(HookKind::Alertmanager, &message).as_array().unwrap().len(), 250, "it has to know each");
}

#[test]
fn without_an_address_of_the_service_a_link_is_the_path_alone() {
    let context = Context { external_url: None, ..CONTEXT };
    for kind in HookKind::ALL {
        let body = String::from_utf8(render(kind, &message(Action::Fire), &context).body).unwrap();
        let paths = ["/alerts/a1", "/gyros/LFG%2001%2F01"];
        let links: Vec<usize> = paths.iter().flat_map(|path| body.match_indices(path)).map(|(at, _)| at).collect();
        assert!(!links.is_empty(), "{kind:?} leads nowhere");
        assert!(links.iter().all(|&at| body[..at].ends_with(['"', ' '])), "{kind:?}: {body}");
    }
}

#[test]
fn a_mail_has_a_subject_an_empty_line_and_a_link() {
    let mail = render(HookKind::Email, &message(Action::Fire), &CONTEXT);
    let text = String::from_utf8(mail.body).unwrap();
    let (subject, body) = text.split_once("\n\n").unwrap();
    assert_eq!(subject, "LFG 01/01: D_I rms_successive fires (critical)");
    assert!(body.contains("https://gyros.example/gyros/LFG%2001%2F01\n") && body.contains("IMU-07"), "{body}");
}

#[test]
fn a_test_says_that_nothing_is_wrong() {
    let test = HookMessage { id: "evt_2".into(), at: CONTEXT.now, event: HookEvent::Test };
    assert_eq!(rendered(HookKind::StandardWebhooks, &test)["type"], "hook.test");
    assert_eq!(rendered(HookKind::CloudEvents, &test)["type"], "gyrowatch.hook.test");
    for kind in [HookKind::Alertmanager, HookKind::AlertmanagerWebhook] {
        let body = rendered(kind, &test);
        let alert = body.get(0).or(body.pointer("/alerts/0")).unwrap();
        assert_eq!(alert["labels"]["alertname"], "GyrowatchTest");
        assert_eq!(alert["annotations"]["summary"], "Test of the hook pager: nothing is wrong");
    }
}

#[test]
fn attempts_of_one_message_are_the_same_bytes() {
    let later = Context { now: UtcMicros(CONTEXT.now.0 + 1_000_000), ..CONTEXT };
    for kind in HookKind::ALL {
        let message = message(Action::Fire);
        let same = render(kind, &message, &CONTEXT).body == render(kind, &message, &later).body;
        assert_eq!(same, kind != HookKind::Alertmanager, "{kind:?}");
    }
}
