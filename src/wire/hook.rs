//! Hooks and their deliveries as clients write and read them.

use std::collections::{BTreeMap, BTreeSet};

use super::alert::AlertBody;
use super::json::present;
use crate::core::judge::{Rule, Severity};
use crate::core::message::{sent, text};
use crate::core::name::{Name, normal_form};
use crate::wire::prelude::*;

/// A hook to be set up.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewHookBody {
    /// For people, and the `receiver` of Alertmanager's body. The kind, where it is left out.
    pub name: Option<String>,
    /// What the target understands, as `standard-webhooks`. The fault of an unknown kind lists all.
    pub kind: String,
    /// `http://` or `https://`. For `alertmanager` its base address: `/api/v2/alerts` is added.
    pub url: String,
    /// `whsec_` and 24 to 64 bytes in base64. `standard-webhooks` draws one where it is left out; other kinds are then
    /// not signed.
    pub secret: Option<String>,
    /// The whole value of an `Authorization` header, as `Bearer …`.
    pub authorization: Option<String>,
    #[serde(default)]
    pub filter: FilterBody,
    #[serde(default = "yes")]
    pub enabled: bool,
    /// One message for all that a record changes; one for each alert where this is `false`.
    #[serde(default = "yes")]
    pub batch: bool,
    /// What an answer is to say for the message to count as delivered.
    pub expect: Option<ExpectBody>,
}

fn yes() -> bool {
    true
}

/// What is to change of a hook; what is left out stays.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HookPatchBody {
    pub name: Option<String>,
    pub url: Option<String>,
    /// A new secret; the one before signs beside it for a while. `null` ends signing.
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<String>)]
    pub secret: Option<Option<String>>,
    /// Draws a new secret, which the answer shows; the one before signs beside it for a while.
    pub rotate_secret: bool,
    /// `null` takes it away.
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<String>)]
    pub authorization: Option<Option<String>>,
    pub filter: Option<FilterBody>,
    /// `true` also sends what waits at once. A hook that was disabled is first told what fires; what waited is dropped.
    pub enabled: Option<bool>,
    pub batch: Option<bool>,
    /// `null`: the status alone decides again.
    #[serde(deserialize_with = "present")]
    #[schema(value_type = Option<ExpectBody>)]
    pub expect: Option<Option<ExpectBody>>,
}

/// What an answer is to say. A 2xx that does not say it is a failed attempt: chat robots answer 200 with an error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectBody {
    /// Members that the answer, a JSON object, must have with these values, as `{"errcode": 0}`.
    #[schema(value_type = Object)]
    pub json: serde_json::Map<String, serde_json::Value>,
}

/// Members that an answer is asked for.
const MOST_EXPECTED: usize = 32;

impl ExpectBody {
    /// Adds a fault where it asks for no member, or for too many.
    pub fn check(&self, pointer: &str, faults: &mut Faults) {
        if !(1..=MOST_EXPECTED).contains(&self.json.len()) {
            faults.push(format!("{pointer}/json"), message!("expected_members", most = MOST_EXPECTED));
        }
    }

    /// What keeps an answer from being the expected one; none where it is.
    pub fn differs(&self, answer: &[u8]) -> Option<Message> {
        let Ok(serde_json::Value::Object(said)) = serde_json::from_slice(answer) else {
            return Some(message!("answer_not_object"));
        };
        self.json.iter().find_map(|(name, wanted)| match said.get(name) {
            Some(value) if same(value, wanted) => None,
            Some(value) => {
                Some(message!("answer_differs", member = name.clone(), value = text(value), wanted = text(wanted)))
            }
            None => Some(message!("answer_lacks", member = name.clone())),
        })
    }
}

/// 0 and 0.0 are the same number.
fn same(a: &serde_json::Value, b: &serde_json::Value) -> bool {
    a == b || a.as_f64().is_some_and(|a| Some(a) == b.as_f64())
}

/// Which alerts a hook is told of; an empty list lets all through.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilterBody {
    /// Names of rules, as `step`.
    #[schema(max_items = 10_000)]
    pub rules: Vec<String>,
    /// Serials of gyros.
    #[schema(max_items = 10_000)]
    pub gyros: Vec<String>,
    /// The least severity, `warning` or `critical`. An alert that has been told never falls below it, so that its end
    /// is told as well.
    pub min_severity: Option<String>,
}

const MOST_FILTERED: usize = 10_000;

impl FilterBody {
    /// Adds a fault for every rule, serial or severity that cannot be, and every list that is too long.
    pub fn check(&self, pointer: &str, faults: &mut Faults) {
        for (i, rule) in self.rules.iter().enumerate() {
            if Rule::from_name(rule).is_none() {
                faults.push(format!("{pointer}/rules/{i}"), message!("unknown_rule", rule = sent(rule)));
            }
        }
        for (i, serial) in self.gyros.iter().enumerate() {
            if let Err(why) = Name::parse(serial).and_then(|name| name.check_seen()) {
                faults.push(format!("{pointer}/gyros/{i}"), why);
            }
        }
        for (list, length) in [("rules", self.rules.len()), ("gyros", self.gyros.len())] {
            if length > MOST_FILTERED {
                faults.push(
                    format!("{pointer}/{list}"),
                    message!("too_many_entries", most = MOST_FILTERED, have = length),
                );
            }
        }
        if let Some(severity) = &self.min_severity
            && Severity::from_name(severity).is_none()
        {
            faults.push(format!("{pointer}/min_severity"), message!("unknown_severity"));
        }
    }

    /// Whether the alert passes: every list that is not empty must hold it.
    pub fn wants(&self, alert: &AlertBody) -> bool {
        // The alert of a station, batch or IMU stands for those of gyros that it explains.
        let of_rule = |rule: &String| {
            *rule == alert.rule || alert.explains_others() && Rule::from_name(rule).is_some_and(Rule::can_be_shared)
        };
        let of_gyro = |gyro: &String| !alert.is_of_gyro() || normal_form(gyro) == normal_form(&alert.serial);
        let severity = Severity::from_name(&alert.severity);
        (self.rules.is_empty() || self.rules.iter().any(of_rule))
            && (self.gyros.is_empty() || self.gyros.iter().any(of_gyro))
            && self.min_severity.as_deref().is_none_or(|least| severity >= Severity::from_name(least))
    }
}

/// What an import has left firing since long ago, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DigestBody {
    /// Alerts that fire.
    pub total: usize,
    /// Gyros that they are of.
    pub gyros: usize,
    pub critical: usize,
    pub warning: usize,
    /// How many of each rule.
    pub rules: BTreeMap<String, usize>,
}

impl DigestBody {
    /// Counts alerts, gyros, severities and rules.
    pub fn of(alerts: &[&AlertBody]) -> Self {
        let of_gyros = alerts.iter().filter(|alert| alert.is_of_gyro());
        let gyros: BTreeSet<&str> = of_gyros.map(|alert| alert.serial.as_str()).collect();
        let mut rules = BTreeMap::new();
        for alert in alerts {
            *rules.entry(alert.rule.to_string()).or_default() += 1;
        }
        let critical = alerts.iter().filter(|alert| alert.severity == Severity::Critical.name()).count();
        let total = alerts.len();
        Self { total, gyros: gyros.len(), critical, warning: total - critical, rules }
    }
}

/// A hook, without its secrets.
#[derive(Debug, Serialize, ToSchema)]
pub struct HookBody {
    pub id: String,
    pub name: String,
    pub kind: String,
    pub url: String,
    /// Whether an `Authorization` header is sent.
    pub authorized: bool,
    /// Whether what is sent is signed.
    pub signed: bool,
    /// Until when the secret before signs as well.
    #[schema(required)]
    pub old_secret_until: Option<String>,
    pub filter: FilterBody,
    pub enabled: bool,
    /// Whether all that a record changes comes in one message.
    pub batch: bool,
    #[schema(required)]
    pub expect: Option<ExpectBody>,
    /// Why the service itself has disabled it.
    #[schema(required)]
    pub disabled_because: Option<String>,
    pub created_at: String,
    pub changed_at: String,
    pub queue: QueueBody,
    /// Shown once, where the service has drawn it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secret: Option<String>,
}

/// How a hook's queue stands.
#[derive(Debug, Serialize, ToSchema)]
pub struct QueueBody {
    /// Deliveries that are still to be made.
    pub open: i64,
    /// When the oldest of them was queued.
    #[schema(required)]
    pub oldest_open: Option<String>,
    /// Given up after the whole ladder.
    pub dead: i64,
}

/// Something that a hook is told.
#[derive(Debug, Serialize, ToSchema)]
pub struct DeliveryBody {
    pub id: String,
    pub hook: String,
    /// The message's `webhook-id`, the same at every attempt.
    pub webhook_id: String,
    /// `alert.fired`, `alert.escalated`, `alert.lowered`, `alert.repeated`, `alert.resolved`, `alerts.digest` or `hook.test`.
    pub event: &'static str,
    /// The gravest, where it tells of many.
    #[schema(required)]
    pub alert: Option<String>,
    pub queued_at: String,
    /// `behind` (an earlier one of the same alert comes first), `waiting`, `delivered`, `dead` (given up) or `dropped`
    /// (the hook was deleted, or disabled and then told of everything that fires).
    pub state: &'static str,
    /// When it is tried next, where it waits.
    #[schema(required)]
    pub due_at: Option<String>,
    #[schema(required)]
    pub finished_at: Option<String>,
    /// Oldest first.
    pub attempts: Vec<AttemptBody>,
}

/// One attempt to deliver.
#[derive(Debug, Serialize, ToSchema)]
pub struct AttemptBody {
    pub at: String,
    /// The HTTP status; null where none was answered.
    #[schema(required)]
    pub status: Option<u16>,
    /// What went wrong, in words.
    pub detail: String,
    /// The same for programs.
    #[serde(flatten)]
    pub message: Option<MessageBody>,
    /// The first kilobyte of what the target answered, made printable; null where it said nothing.
    #[schema(required)]
    pub answer: Option<String>,
    pub took_ms: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alert(rule: &'static str, serial: &str, severity: &'static str) -> AlertBody {
        let json = serde_json::json!({
            "id": "a", "serial": serial, "coefficient": "D_I", "rule": rule, "state": "firing", "severity": severity,
            "fired_at": "2026-03-01T08:00:00Z", "limit": 0.01, "unit": "deg/(h g0)", "reason": "",
        });
        serde_json::from_value(json).unwrap()
    }

    fn filter(json: serde_json::Value) -> FilterBody {
        serde_json::from_value(json).unwrap()
    }

    #[test]
    fn a_filter_lets_through_what_it_names() {
        let step = alert("step", "A", "warning");
        assert!(FilterBody::default().wants(&step));
        for (body, wants) in [
            (serde_json::json!({ "rules": ["step", "range"] }), true),
            (serde_json::json!({ "rules": ["range"] }), false),
            (serde_json::json!({ "gyros": ["A"] }), true),
            (serde_json::json!({ "gyros": ["B"] }), false),
            (serde_json::json!({ "rules": ["step"], "gyros": ["B"] }), false),
            (serde_json::json!({ "min_severity": "warning" }), true),
            (serde_json::json!({ "min_severity": "critical" }), false),
        ] {
            assert_eq!(filter(body.clone()).wants(&step), wants, "{body}");
        }
        assert!(filter(serde_json::json!({ "min_severity": "warning" })).wants(&alert("step", "A", "critical")));
    }

    #[test]
    fn a_filter_that_names_nothing_that_exists_is_refused_at_its_place() {
        let mut faults = Faults::default();
        let wrong = serde_json::json!({ "rules": ["step", "stpe"], "gyros": [""], "min_severity": "fatal" });
        filter(wrong).check("/filter", &mut faults);
        let places: Vec<&str> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(places, ["/filter/rules/1", "/filter/gyros/0", "/filter/min_severity"]);
    }

    #[test]
    fn null_is_told_from_left_out() {
        let read = |text: &str| serde_json::from_str::<HookPatchBody>(text).unwrap();
        assert_eq!(read("{}").secret, None);
        assert_eq!(read(r#"{"secret": null}"#).secret, Some(None));
        assert_eq!(read(r#"{"secret": "x"}"#).secret, Some(Some("x".into())));
    }

    #[test]
    fn an_answer_says_what_it_is_to_say_or_in_which_member_it_does_not() {
        let expect: ExpectBody =
            serde_json::from_value(serde_json::json!({ "json": { "errcode": 0, "ok": true } })).unwrap();
        let differs = |answer: &str| expect.differs(answer.as_bytes()).map(|why| why.to_string());
        assert_eq!(differs(r#"{"errcode": 0, "ok": true, "errmsg": "ok"}"#), None);
        assert_eq!(differs(r#"{"ok": true, "errcode": 0.0}"#), None, "the same number");
        assert_eq!(
            differs(r#"{"errcode": 40001, "ok": true}"#).unwrap(),
            "answer_differs (member: errcode, value: 40001, wanted: 0)"
        );
        assert_eq!(
            differs(r#"{"errcode": "0", "ok": true}"#).unwrap(),
            "answer_differs (member: errcode, value: \"0\", wanted: 0)"
        );
        assert_eq!(differs(r#"{"errcode": 0}"#).unwrap(), "answer_lacks (member: ok)");
        for answer in ["", "ok", "[0]", "{\"errcode\": 0, \"ok\": tr"] {
            assert_eq!(differs(answer).unwrap(), "answer_not_object", "{answer}");
        }
        let mut faults = Faults::default();
        ExpectBody { json: serde_json::Map::new() }.check("/expect", &mut faults);
        assert_eq!(faults.0[0].pointer, "/expect/json");
    }
}
