//! A message as JSON: `{"code": .., "parameters": {..}}`, in answers and, with a version, in the database.
//!
//! Texts are strings and counts are numbers; a nested message is an object, in answers with its words beside it.

use serde_json::Map;

use crate::core::message::Parameter;
use crate::wire::prelude::*;
use crate::wire::unit;

/// The version of the stored form.
const VERSION: u64 = 1;

/// What is said, for a program. Its words stand beside it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MessageBody {
    /// Never changes once it was published.
    #[schema(example = "not_positive")]
    #[serde(default)]
    pub code: String,
    /// By name; which there are depends on the code.
    #[schema(value_type = Object)]
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub parameters: Map<String, Value>,
}

impl MessageBody {
    /// Nested messages have their words in `language` as `text`.
    pub fn of(message: &Message, language: Language) -> Self {
        Self { code: message.code.to_string(), parameters: object(message, Some(language)) }
    }

    /// Its words in `language`, in which the words of what is nested are from now on, too.
    pub fn say(&mut self, language: Language) -> String {
        let nested = json!({ "code": self.code, "parameters": self.parameters });
        let Some(message) = read(&nested) else { return String::new() };
        *self = Self::of(&message, language);
        language.words(&message)
    }
}

fn object(message: &Message, language: Option<Language>) -> Map<String, Value> {
    message.parameters.iter().map(|(name, parameter)| (name.to_string(), value(parameter, language))).collect()
}

fn value(parameter: &Parameter, language: Option<Language>) -> Value {
    match parameter {
        Parameter::Text(text) => json!(text),
        Parameter::Count(count) => json!(count),
        Parameter::List(list) => list.iter().map(|one| value(one, language)).collect(),
        Parameter::Message(message) => {
            let mut nested = json!({ "code": message.code, "parameters": object(message, language) });
            if let Some(language) = language {
                nested["text"] = json!(match message.code.starts_with("unit_") && message.parameters.is_empty() {
                    // Spelled as in every format for machines, in every language.
                    true => unit::of_machines(&Language::English.words(message)),
                    false => language.words(message),
                });
            }
            nested
        }
    }
}

/// The stored form, which [`from_stored`] reads.
pub fn to_stored(message: &Message) -> String {
    json!({ "v": VERSION, "code": message.code, "parameters": object(message, None) }).to_string()
}

/// The stored form of a message that is part of something with a version of its own.
pub fn to_part(message: &Message) -> Value {
    json!({ "code": message.code, "parameters": object(message, None) })
}

/// A stored message. The prose that older versions stored is said as it is.
pub fn from_stored(text: &str) -> Message {
    let read = || {
        let stored: Value = serde_json::from_str(text).ok()?;
        (stored.get("v")? == VERSION).then(|| read(&stored)).flatten()
    };
    read().unwrap_or_else(|| Message::verbatim(text))
}

/// A message of [`to_part`].
pub fn read(value: &Value) -> Option<Message> {
    let code = value.get("code")?.as_str()?.to_owned();
    let parameters = value.get("parameters").and_then(Value::as_object).into_iter().flatten();
    let parameters = parameters.map(|(name, value)| Some((name.clone().into(), parameter(value)?)));
    Some(Message { code: code.into(), parameters: parameters.collect::<Option<_>>()? })
}

fn parameter(value: &Value) -> Option<Parameter> {
    Some(match value {
        Value::String(text) => Parameter::Text(text.clone().into()),
        Value::Number(count) => Parameter::Count(count.as_u64()?),
        Value::Array(list) => Parameter::List(list.iter().map(parameter).collect::<Option<_>>()?),
        Value::Object(_) => Parameter::Message(read(value)?),
        Value::Null | Value::Bool(_) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::message::list;
    use crate::message;

    #[test]
    fn what_is_stored_is_read_back() {
        let inner = message!("not_utf8_text");
        let said = message!("outer", line = 7_usize, fault = inner, known = list(["a", "b"]), key = "{\"x\"}");
        assert_eq!(from_stored(&to_stored(&said)).to_string().len(), said.to_string().len());
        let read = from_stored(&to_stored(&said));
        for (name, value) in &said.parameters {
            assert_eq!(read.parameter(name), Some(value), "{name}");
        }
    }

    #[test]
    fn old_prose_is_said_as_it_is() {
        for prose in ["answered 500", "", "{\"errcode\": 1}", "{\"v\":2,\"code\":\"x\"}", "{\"v\":1}"] {
            assert_eq!(Language::Chinese.words(&from_stored(prose)), prose);
        }
    }

    #[test]
    fn a_nested_message_has_its_words_beside_it() {
        let said = message!("at_line", line = 7_usize, fault = message!("not_utf8_text"));
        let body = serde_json::to_value(MessageBody::of(&said, Language::English)).unwrap();
        let words = Language::English.words(&message!("not_utf8_text"));
        let fault = json!({ "code": "not_utf8_text", "parameters": {}, "text": words });
        assert_eq!(body, json!({ "code": "at_line", "parameters": { "line": 7, "fault": fault } }));
    }

    #[test]
    fn a_nested_unit_is_spelled_for_machines_in_every_language() {
        let said = message!("of_unit", unit = message!("unit_drift"));
        for language in [Language::English, Language::Chinese] {
            let body = serde_json::to_value(MessageBody::of(&said, language)).unwrap();
            assert_eq!(body["parameters"]["unit"]["text"], "deg/(h*g0)");
        }
    }
}
