//! What members and parameters of one name have in common, described once: a time is a time, a name is a name, and what
//! must be one of several is one of those that are read. What a type says itself stays.

use std::collections::BTreeSet;

use serde_json::Value;
use utoipa::openapi::schema::{Array, ArrayItems, Components, KnownFormat, Object, SchemaFormat, SchemaType, Type};
use utoipa::openapi::{OpenApi, PathItem, RefOr, Schema};

use crate::core::access::Role;
use crate::core::alert_decision::AlertState;
use crate::core::campaign::{Phase, TestKind};
use crate::core::delivery::DeliveryState;
use crate::core::fleet_order::FleetOrder;
use crate::core::judge::{Coefficient, Event, Rule, Severity, State, Status};
use crate::core::model::Term;
use crate::core::mounting::Slot;
use crate::core::name::MAX_NAME_CHARS;
use crate::core::period::Period;
use crate::core::record::MAX_NOTE_CHARS;
use crate::pipeline::HookKind;
use crate::routes::operations;
use crate::wire::campaign::MAX_UNCERTAINTY_ARCSEC;
use crate::wire::numbers::LARGEST;
use crate::wire::text::{LARGEST_DEVIATION, TEMPERATURE_RANGE_C};

/// Text of one line, and such that says something; text of several lines, and such that says something. JSON Schema
/// has the regular expressions of JavaScript.
const LINE: &str = r"^[^\u0000-\u001f\u007f-\u009f]*$";
const SPOKEN_LINE: &str =
    concat!(r"^[^\u0000-\u001f\u007f-\u009f]*[^\s\u0000-\u001f\u007f-\u009f]", r"[^\u0000-\u001f\u007f-\u009f]*$");
const NOTE: &str = r"^[^\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f]*$";
const SPOKEN_NOTE: &str = concat!(
    r"^[^\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f]*[^\s\u0000-\u001f\u007f-\u009f]",
    r"[^\u0000-\u0008\u000b\u000c\u000e-\u001f\u007f-\u009f]*$"
);
/// Nine bytes in base64 ([`crate::wire::cursor`]).
const CURSOR: &str = "^[A-Za-z0-9_-]{12}$";
/// 24 to 64 bytes in base64 ([`crate::alert::sign`]).
const SECRET: &str = "^whsec_([A-Za-z0-9+/]{4}){8,21}([A-Za-z0-9+/][AQgw]==)?$|\
                      ^whsec_([A-Za-z0-9+/]{4}){8,20}[A-Za-z0-9+/]{2}[AEIMQUYcgkosw048]=$";
const AUTHORIZATION: &str = "^[!-~]([ -~]*[!-~])?$";
const URL: &str = "^(https?://|mailto:).";
const COLUMNS: &str = "^(all|(calibrated_at|value|sd|method|imu|slot|station|record|state|status)\
                       (,(calibrated_at|value|sd|method|imu|slot|station|record|state|status))*)$";
/// A day, or an RFC 3339 time.
const DAY_OR_TIME: &str = "^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])\
                           ([Tt]([01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9]([.][0-9]{1,9})?\
                           ([Zz]|[+-]([01][0-9]|2[0-3]):[0-5][0-9]))?$";
const HYPOTHESIS_ID: &str = "^[a-z][a-z0-9_]{0,47}$";

enum Constraint {
    Time,
    /// A regular expression, and the least and most characters.
    Text(&'static str, usize, usize),
    OneOf(Vec<&'static str>),
    /// A list of which each is named once.
    Set(Vec<&'static str>),
    Number(f64, f64),
    Positive(f64),
    /// An object with at least one member, and with at most so many.
    Members(usize),
}

fn one_of<const N: usize>(names: [&'static str; N]) -> Constraint {
    Constraint::OneOf(names.to_vec())
}

/// Describes members and parameters in the whole document.
pub fn describe(openapi: &mut OpenApi) {
    let sent = sent(openapi);
    if let Some(Components { schemas, .. }) = &mut openapi.components {
        for (name, schema) in schemas {
            let RefOr::T(Schema::Object(object)) = schema else { continue };
            for (member, schema) in &mut object.properties {
                if let RefOr::T(schema) = schema {
                    describe_one(schema, of_member((name, member), sent.contains(name)));
                }
            }
        }
    }
    for item in openapi.paths.paths.values_mut() {
        for (_, operation) in operations(item) {
            let id = operation.operation_id.clone().unwrap_or_default();
            for parameter in operation.parameters.iter_mut().flatten() {
                if let RefOr::T(parameter) = parameter
                    && let Some(RefOr::T(schema)) = &mut parameter.schema
                {
                    describe_one(schema, of_parameter(&id, &parameter.name));
                }
            }
        }
    }
}

fn describe_one(schema: &mut Schema, what: Option<Constraint>) {
    match (schema, what) {
        (Schema::Array(Array { items: ArrayItems::RefOrSchema(items), unique_items, .. }), Some(what)) => {
            if let RefOr::T(schema) = &mut **items {
                *unique_items = matches!(what, Constraint::Set(_));
                describe_one(schema, Some(what));
            }
        }
        (Schema::Object(object), Some(what)) => what.put(object),
        // Text that is required to say something, by its own word.
        (Schema::Object(object), None) if object.min_length == Some(1) && object.pattern.is_none() => {
            let of_one_line = object.max_length == Some(MAX_NAME_CHARS);
            object.pattern = Some(if of_one_line { SPOKEN_LINE } else { SPOKEN_NOTE }.to_owned());
        }
        _ => {}
    }
}

impl Constraint {
    fn put(self, object: &mut Object) {
        let is = |wanted: &Type| match &object.schema_type {
            SchemaType::Type(of) => of == wanted,
            SchemaType::Array(of) => of.contains(wanted),
            SchemaType::AnyValue => false,
        };
        let (text, whole, nullable) = (is(&Type::String), is(&Type::Integer), is(&Type::Null));
        let number = whole || is(&Type::Number);
        match self {
            Self::Time if text => object.format = Some(SchemaFormat::KnownFormat(KnownFormat::DateTime)),
            Self::Text(pattern, least, most) if text => {
                object.pattern = Some(pattern.to_owned());
                (object.min_length, object.max_length) = ((least > 0).then_some(least), Some(most));
            }
            Self::OneOf(names) | Self::Set(names) if text => {
                let null = nullable.then_some(Value::Null);
                object.enum_values = Some(names.into_iter().map(Into::into).chain(null).collect());
            }
            Self::Number(least, most) if number => {
                // A client that draws values from the limits sends them as they stand, and `1.0` is no count.
                let limit = |value: f64| match whole {
                    true => utoipa::Number::Int(value as isize),
                    false => utoipa::Number::Float(value),
                };
                (object.minimum, object.maximum) = (Some(limit(least)), Some(limit(most)));
            }
            Self::Positive(most) if number => {
                (object.exclusive_minimum, object.maximum) =
                    (Some(utoipa::Number::Float(0.0)), Some(utoipa::Number::Float(most)));
            }
            Self::Members(most) => (object.min_properties, object.max_properties) = (Some(1), Some(most)),
            _ => {}
        }
    }
}

/// What a member is; some limits hold only for what is `sent`: answers may hold what was stored under others.
fn of_member((schema, member): (&str, &str), sent: bool) -> Option<Constraint> {
    use Constraint::{Members, Number, OneOf, Positive, Set, Text, Time};
    let name = || Text(SPOKEN_LINE, 1, MAX_NAME_CHARS);
    let slots = Slot::ALL.map(Slot::name);
    Some(match (schema, member) {
        ("NewTokenBody" | "TokenBody", "role") => one_of(Role::ALL.map(Role::name)),
        ("NewEvent" | "EventBody", "event") => one_of(Event::ALL.map(Event::name)),
        ("NewHookBody" | "HookBody", "kind") => one_of(HookKind::ALL.map(HookKind::name)),
        ("FilterBody", "rules") | ("MatchersBody", "rule") => one_of(Rule::ALL.map(Rule::name)),
        ("FilterBody", "min_severity") => one_of(Severity::ALL.map(Severity::name)),
        ("DeliveryBody", "state") => one_of(DeliveryState::ALL.map(DeliveryState::name)),
        ("Gyro", "status") | ("StatusesBody", _) => one_of(Status::ALL.map(Status::name)),
        ("Gyro", "state") | ("StatesBody", _) => one_of(State::ALL.map(State::name)),
        ("DwellBody", "phase") => one_of([Phase::Static, Phase::Rate].map(Phase::name)),
        ("CampaignBody", "rates") => one_of(["inertial", "table"]),
        ("CampaignBody", "test") => {
            one_of([TestKind::Imu, TestKind::TorqueFeedback, TestKind::TurntableServo].map(TestKind::name))
        }
        ("CampaignBody", "model") | ("AdoptionBody" | "ModelBody", "terms") => Set(Term::ALL.map(Term::name).to_vec()),
        ("KnownEffectBody", "gyros") => Set(slots.to_vec()),
        ("CampaignGyroBody" | "ModelGyroBody", "slot") => one_of(slots),
        ("KnownEstimateBody" | "ModelCoefficientBody", "slot") => OneOf([slots.as_slice(), &["all"]].concat()),
        ("ShapeBody", "axes") => one_of(["input_spin"]),
        ("ShapeBody", "product") => Number(0.0, 2.0),
        ("AdoptionBody" | "ModelBody", "version") => Number(1.0, 2.0),
        ("WindowOrder", "from" | "to")
        | ("WhichBody", "since" | "until")
        | ("NewEvent", "at" | "to")
        | ("BaselineBody", "at") => Text(DAY_OR_TIME, 10, 35),
        ("ReachBody", "earliest" | "latest") | (_, "at" | "until" | "since" | "from" | "to") => Time,
        (_, member) if member.ends_with("_at") => Time,
        _ if !sent => return None,
        ("DwellBody", "start_s") => Number(0.0, LARGEST),
        ("DwellBody", "duration_s") => Positive(LARGEST),
        // Each of a unit quaternion, as far as rounding goes.
        ("DwellBody", "attitude") => Number(-1.0001, 1.0001),
        ("DwellBody", "output_sem_pulse_s") => Number(1e-12, LARGEST),
        ("DwellBody", "specific_force_g0" | "rate_arcsec_s" | "output_pulse_s")
        | ("CampaignGyroBody", "known_e_pulse_per_arcsec")
        | ("SiteBody", "magnetic_field_nav")
        | ("KnownEstimateBody" | "ModelCoefficientBody", "value") => Number(-LARGEST, LARGEST),
        ("KnownEstimateBody" | "ModelCoefficientBody", "sd") => Number(0.0, LARGEST),
        ("ExpectBody", "json") => Members(32),
        ("StationUncertaintyBody", _) => Number(0.0, MAX_UNCERTAINTY_ARCSEC),
        ("SiteBody", "latitude_deg") => Number(-90.0, 90.0),
        ("SiteBody", "gravity_g0") => Number(0.9, 1.1),
        ("HypothesisBody", "plausible" | "typical") => Positive(f64::MAX),
        ("HypothesisBody", "id") => Text(HYPOTHESIS_ID, 1, 48),
        ("HypothesisBody", "words") => Text(SPOKEN_LINE, 1, 200),
        ("HypothesisBody", "cause") => Text(LINE, 0, 200),
        ("NewHookBody" | "HookPatchBody", "name") | ("FilterBody", "gyros") => name(),
        ("NewHookBody" | "HookPatchBody", "secret") => Text(SECRET, 38, 94),
        ("NewHookBody" | "HookPatchBody", "authorization") => Text(AUTHORIZATION, 1, 4096),
        ("NewHookBody" | "HookPatchBody", "url") => Text(URL, 8, 8192),
        ("AttributesPatchBody", _) | (_, "imu" | "station" | "serial") => name(),
        (_, "d_i_sd" | "d_s_sd" | "D_I_sd" | "D_S_sd") => Number(0.0, LARGEST_DEVIATION),
        (_, "temperature_c") if schema != "ValidityBody" => {
            Number(*TEMPERATURE_RANGE_C.start(), *TEMPERATURE_RANGE_C.end())
        }
        ("RecordBody" | "CampaignBody" | "BenchBody", "operator")
        | ("RecordBody", "campaign")
        | ("NewEvent" | "BaselineBody", "author")
        | ("NewEvent", "kind") => Text(LINE, 0, MAX_NAME_CHARS),
        (_, "note") => Text(NOTE, 0, MAX_NOTE_CHARS),
        _ => return None,
    })
}

fn of_parameter(operation: &str, parameter: &str) -> Option<Constraint> {
    use Constraint::{Number, Text};
    Some(match (operation, parameter) {
        ("get_alerts", "state") => one_of(AlertState::ALL.map(AlertState::name)),
        ("get_gyros", "state") => one_of(State::ALL.map(State::name)),
        ("get_deliveries", "state") => one_of(DeliveryState::ALL.map(DeliveryState::name)),
        ("get_silences", "state") => one_of(["active", "all"]),
        ("get_gyros", "sort") => one_of(FleetOrder::ALL.map(FleetOrder::name)),
        (_, "status") => one_of(Status::ALL.map(Status::name)),
        (_, "severity") => one_of(Severity::ALL.map(Severity::name)),
        (_, "rule") => one_of(Rule::ALL.map(Rule::name)),
        ("get_trend", "coefficient") => one_of(["D_I", "D_S", "D_O"]),
        (_, "coefficient") => one_of(Coefficient::ALL.map(Coefficient::name)),
        (_, "method") => one_of(["rigid", "published", "torque_feedback", "turntable_servo"]),
        (_, "every") => one_of(Period::ALL.map(Period::name)),
        (_, "voided" | "levels") => one_of(["include", "exclude"]),
        (_, "station_when") => one_of(["now", "ever"]),
        (_, "notify") => one_of(["all", "digest", "none"]),
        (_, "format") => one_of(["json", "csv"]),
        (_, "columns") => Text(COLUMNS, 2, 1000),
        (_, "cursor") => Text(CURSOR, 12, 12),
        (_, "from" | "to" | "since" | "until" | "calibrated_since" | "changed_since") => Text(DAY_OR_TIME, 10, 35),
        (_, "wait") => Number(0.0, 10.0),
        ("get_diagnosis_orders", "limit") => Number(1.0, 100.0),
        ("get_diagnosis_order" | "get_deliveries", "limit") => Number(1.0, 1000.0),
        ("get_alerts" | "get_audit" | "get_gyros", "limit") => Number(1.0, 10_000.0),
        ("get_trend", "limit" | "last") => Number(1.0, 100_000.0),
        (_, "Idempotency-Key") => Text(AUTHORIZATION, 1, 255),
        _ => return None,
    })
}

/// The names of schemas that bodies of requests are made of.
fn sent(openapi: &OpenApi) -> BTreeSet<String> {
    let (mut found, mut left) = (BTreeSet::new(), Vec::new());
    let of_operation =
        |item: &PathItem| [&item.post, &item.put, &item.patch].map(|of| of.as_ref()?.request_body.clone());
    for body in openapi.paths.paths.values().flat_map(of_operation).flatten() {
        references(&serde_json::to_value(body).unwrap_or_default(), &mut left);
    }
    while let Some(name) = left.pop() {
        let schema = openapi.components.as_ref().and_then(|components| components.schemas.get(&name));
        if found.insert(name) {
            references(&serde_json::to_value(schema).unwrap_or_default(), &mut left);
        }
    }
    found
}

/// Every schema that a part of the document refers to.
fn references(part: &Value, found: &mut Vec<String>) {
    match part {
        Value::Object(members) => {
            if let Some(Value::String(target)) = members.get("$ref") {
                found.extend(target.rsplit('/').next().map(str::to_owned));
            }
            members.values().for_each(|member| references(member, found));
        }
        Value::Array(items) => items.iter().for_each(|item| references(item, found)),
        _ => {}
    }
}
