//! Why a verdict is what it is, as answers show it and as the database keeps it.

use std::borrow::Cow;

use serde::de::{Deserialize, Deserializer};
use serde::ser::{Serialize, Serializer};

use super::message;
use crate::core::judge::Verdict;
use crate::wire::prelude::*;

/// The form of what is kept.
const VERSION: u64 = 1;

/// Sentence by sentence. In answers `code` and `parameters` of the first, and `reason`, all of them in the language
/// that the request asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason(pub Vec<Message>);

/// The members of an answer that say why.
#[derive(serde::Serialize, ToSchema)]
#[schema(as = Reason)]
struct ReasonBody {
    /// What the rule saw, for programs; `verbatim` where an earlier version kept words alone. Figures are rounded as
    /// people read them: those to go on with stand beside it.
    #[serde(flatten)]
    finding: MessageBody,
    /// The same, the limit and how certain it is, in words.
    #[schema(example = "In tolerance.")]
    reason: Cow<'static, str>,
}

impl Reason {
    /// What the verdict's rule saw, its limit and certainty.
    pub fn of(verdict: &Verdict) -> Self {
        Self(verdict.messages())
    }

    #[must_use]
    pub fn and(mut self, sentence: Message) -> Self {
        self.0.push(sentence);
        self
    }

    /// As sentences.
    pub fn words(&self, language: Language) -> Cow<'static, str> {
        language.sentences(&self.0)
    }

    /// As the database keeps it, in place of words.
    pub fn kept(&self) -> Value {
        json!({ "v": VERSION, "sentences": self.0.iter().map(message::to_part).collect::<Vec<_>>() })
    }

    /// Words are those of an earlier version, or of another service: they are said as they are.
    fn read(kept: &Value) -> Option<Self> {
        match kept {
            Value::String(words) => Some(Self(vec![Message::verbatim(words)])),
            kept => kept.get("sentences")?.as_array()?.iter().map(message::read).collect::<Option<_>>().map(Self),
        }
    }
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let language = asked();
        let finding = self.0.first().map_or_else(MessageBody::default, |first| MessageBody::of(first, language));
        ReasonBody { finding, reason: self.words(language) }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Reason {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        struct Read {
            reason: Value,
        }
        let Read { reason } = Read::deserialize(deserializer)?;
        Self::read(&reason).ok_or_else(|| serde::de::Error::custom("reason: neither words nor sentences"))
    }
}

impl utoipa::PartialSchema for Reason {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::schema::Schema> {
        ReasonBody::schema()
    }
}

impl ToSchema for Reason {
    fn schemas(schemas: &mut Vec<(String, utoipa::openapi::RefOr<utoipa::openapi::schema::Schema>)>) {
        ReasonBody::schemas(schemas);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::message::list;
    use crate::message;

    fn reason() -> Reason {
        let value = message!("measured", value = "0.0123", unit = message!("unit_drift"));
        let step = message!("step", name = "D_I", value, side = "below", level = "3.0000");
        Reason(vec![step, message!("requirement_others", figures = list(["E_x", "E_y"]))])
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
    fn words_of_earlier_versions_stay_as_they_are() {
        let read: Reason = serde_json::from_value(json!({ "reason": "D_I has lain above." })).unwrap();
        assert_eq!(read.words(Language::Chinese), "D_I has lain above.");
        assert_eq!(read, serde_json::from_value(json!({ "reason": read.kept() })).unwrap());
        for bad in [json!({}), json!({ "reason": 3 }), json!({ "reason": { "v": 1, "sentences": [{ "code": 1 }] } })] {
            assert!(serde_json::from_value::<Reason>(bad.clone()).is_err(), "{bad}");
        }
    }

    #[tokio::test]
    async fn an_answer_holds_code_and_parameters_and_words_in_the_language_that_is_asked_for() {
        for language in Language::ALL {
            let said = crate::words::asked_in(language, async { serde_json::to_value(reason()).unwrap() }).await;
            assert_eq!((&said["code"], &said["reason"]), (&json!("step"), &json!(reason().words(language))));
            let parameters = &said["parameters"];
            assert_eq!((&parameters["name"], &parameters["side"]), (&json!("D_I"), &json!("below")));
            assert_eq!(parameters["value"]["code"], "measured");
        }
    }
}
