//! Why a verdict is what it is, as answers show it and as the database keeps it.

use std::borrow::Cow;

use serde::de::{Deserialize, Deserializer};
use serde::ser::{Serialize, Serializer};
use serde_json::{Map, Value, json};
use utoipa::ToSchema;

use crate::core::judge::Verdict;
use crate::core::message::{Message, Parameter};
use crate::words::{Language, asked};

/// The form of what is kept.
const VERSION: u64 = 1;

/// In answers `code`, `parameters` and `reason`, in the language that the request asks for. Kept as codes with parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    Sentences(Vec<Message>),
    /// In the words of another service, or of a version before 0.2: in no other language than its own.
    Prose(String),
}

impl Reason {
    pub fn of(verdict: &Verdict) -> Self {
        Self::Sentences(verdict.messages())
    }

    /// With a sentence more.
    #[must_use]
    pub fn and(self, message: Message) -> Self {
        match self {
            Self::Sentences(mut sentences) => {
                sentences.push(message);
                Self::Sentences(sentences)
            }
            prose @ Self::Prose(_) => prose,
        }
    }

    pub fn words(&self, language: Language) -> String {
        match self {
            Self::Sentences(sentences) => language.sentences(sentences),
            Self::Prose(words) => words.clone(),
        }
    }

    /// As the database keeps it, in place of words.
    pub fn kept(&self) -> Value {
        match self {
            Self::Sentences(sentences) => {
                json!({ "v": VERSION, "sentences": sentences.iter().map(message_value).collect::<Vec<_>>() })
            }
            Self::Prose(words) => words.as_str().into(),
        }
    }

    fn read(value: Value) -> Option<Self> {
        match value {
            Value::String(words) => Some(Self::Prose(words)),
            Value::Object(mut kept) => {
                let Value::Array(sentences) = kept.remove("sentences")? else { return None };
                Some(Self::Sentences(sentences.into_iter().map(message).collect::<Option<_>>()?))
            }
            _ => None,
        }
    }
}

/// The members of an answer that say why.
#[derive(serde::Serialize, ToSchema)]
#[schema(as = Reason)]
pub struct ReasonBody<'a> {
    /// What the rule saw: its first sentence, for programs. None where an earlier version kept words alone.
    code: Option<Cow<'a, str>>,
    /// What that sentence names, by parameter: figures as people read them, counts as numbers, what has words of its own as another code.
    parameters: Map<String, Value>,
    /// The verdict in words.
    reason: String,
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let first = match self {
            Self::Sentences(sentences) => sentences.first(),
            Self::Prose(_) => None,
        };
        ReasonBody {
            code: first.map(|first| first.code.as_ref().into()),
            parameters: first.map(parameters).unwrap_or_default(),
            reason: self.words(asked()),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Reason {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        struct Read {
            reason: Value,
        }
        let Read { reason } = Read::deserialize(deserializer)?;
        Self::read(reason).ok_or_else(|| serde::de::Error::custom("reason: neither words nor sentences"))
    }
}

impl utoipa::PartialSchema for Reason {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::schema::Schema> {
        ReasonBody::schema()
    }
}

impl ToSchema for Reason {}

/// The parameters of a message as JSON.
pub fn parameters(message: &Message) -> Map<String, Value> {
    message.parameters.iter().map(|(name, parameter)| (name.clone().into_owned(), parameter_value(parameter))).collect()
}

fn message_value(message: &Message) -> Value {
    json!({ "code": message.code, "parameters": parameters(message) })
}

fn parameter_value(parameter: &Parameter) -> Value {
    match parameter {
        Parameter::Text(text) => text.as_ref().into(),
        Parameter::Count(count) => (*count).into(),
        Parameter::Message(message) => message_value(message),
        Parameter::List(list) => list.iter().map(parameter_value).collect(),
    }
}

fn message(value: Value) -> Option<Message> {
    let Value::Object(mut members) = value else { return None };
    let (Value::String(code), Value::Object(parameters)) = (members.remove("code")?, members.remove("parameters")?) else {
        return None;
    };
    let parameters = parameters.into_iter().map(|(name, value)| Some((name.into(), parameter(value)?)));
    Some(Message { code: code.into(), parameters: parameters.collect::<Option<_>>()? })
}

fn parameter(value: Value) -> Option<Parameter> {
    match value {
        Value::String(text) => Some(text.into()),
        Value::Number(count) => count.as_u64().map(Parameter::Count),
        Value::Object(_) => message(value).map(Parameter::Message),
        Value::Array(list) => list.into_iter().map(parameter).collect::<Option<_>>().map(Parameter::List),
        Value::Null | Value::Bool(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::message::list;
    use crate::message;

    fn reason() -> Reason {
        let value = message!("measured", value = "0.0123", unit = message!("unit_drift"));
        let step = message!("step", name = "D_I", value = value, side = "below", level = "3.0000");
        Reason::Sentences(vec![step, message!("requirement_others", figures = list(["E_x", "E_y"]))])
    }

    #[test]
    fn what_is_kept_is_said_in_any_language() {
        let kept = json!({ "reason": reason().kept() });
        let read: Reason = serde_json::from_value(kept).unwrap();
        assert_eq!(
            read.words(Language::English),
            "D_I is 0.0123 deg/(h g0) below the records before (median 3.0000). Also outside: E_x, E_y."
        );
        assert_eq!(read.words(Language::Chinese), reason().words(Language::Chinese));
        assert_eq!(read.kept(), reason().kept());
    }

    #[test]
    fn an_answer_holds_code_parameters_and_words() {
        let unit = json!({ "code": "unit_drift", "parameters": {} });
        let value = json!({ "code": "measured", "parameters": { "value": "0.0123", "unit": unit } });
        let said = serde_json::to_value(reason()).unwrap();
        assert_eq!(said["code"], "step");
        assert_eq!(
            said["parameters"],
            json!({ "name": "D_I", "value": value, "side": "below", "level": "3.0000" })
        );
        assert_eq!(said["reason"], reason().words(Language::English));
    }

    #[test]
    fn words_of_earlier_versions_stay_as_they_are() {
        let read: Reason = serde_json::from_value(json!({ "reason": "D_I has lain above." })).unwrap();
        assert_eq!(read, Reason::Prose("D_I has lain above.".into()));
        assert_eq!(read.words(Language::Chinese), "D_I has lain above.");
        assert_eq!(read.kept(), "D_I has lain above.");
        for bad in [json!({}), json!({ "reason": 3 }), json!({ "reason": { "v": 1, "sentences": [{ "code": 1 }] } })] {
            assert!(serde_json::from_value::<Reason>(bad.clone()).is_err(), "{bad}");
        }
    }

    #[tokio::test]
    async fn an_answer_is_in_the_language_that_is_asked_for() {
        let said = crate::words::asking(Language::Chinese, async { serde_json::to_value(reason()).unwrap() }).await;
        assert_eq!(said["reason"], reason().words(Language::Chinese));
    }
}
