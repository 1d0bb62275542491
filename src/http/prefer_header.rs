//! How much of an answer a client wants (RFC 7240): whoever only has to know that what it sent is stored asks for
//! `return=minimal`, and neither side spends time on figures and words. What was stored before is read as for a whole
//! answer.

use std::convert::Infallible;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use utoipa::PartialSchema;
use utoipa::openapi::path::{Parameter, ParameterIn};

use crate::core::judge::State;
use crate::http::prelude::*;
use crate::wire::note::NoteBody;

/// What `Prefer` says of the answer to something that was sent; all that is not understood is passed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prefer {
    Whole,
    Minimal,
}

impl<S: Sync> FromRequestParts<S> for Prefer {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self::of(&parts.headers))
    }
}

impl IntoParams for Prefer {
    fn into_params(_: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let minimal = "`return=minimal`: the answer is the identifier and how many verdicts there are of each state";
        let prefer = Parameter::builder().name("Prefer").parameter_in(ParameterIn::Header).description(Some(minimal));
        vec![prefer.schema(Some(String::schema())).build()]
    }
}

impl Prefer {
    fn of(headers: &HeaderMap) -> Self {
        let said = headers.get_all("prefer").iter().filter_map(|value| value.to_str().ok());
        let preferences = said.flat_map(|value| outside_quotes(value, ','));
        let mut named = preferences.map(|preference| {
            let said = outside_quotes(preference, ';').next().unwrap_or_default();
            said.split_once('=').unwrap_or((said, ""))
        });
        // Of several the first counts.
        let returned = named.find(|(name, _)| name.trim().eq_ignore_ascii_case("return"));
        match returned.map(|(_, value)| value.trim().trim_matches('"')) {
            Some(value) if value.eq_ignore_ascii_case("minimal") => Self::Minimal,
            _ => Self::Whole,
        }
    }

    /// The header that tells the client that its preference was followed.
    pub fn applied(self) -> Option<[(&'static str, &'static str); 1]> {
        (self == Self::Minimal).then_some([("preference-applied", "return=minimal")])
    }
}

/// The parts of `text` between `separator`s that are not within quotation marks.
pub(super) fn outside_quotes(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let (mut quoted, mut escaped) = (false, false);
    text.split(move |letter| {
        quoted ^= letter == '"' && !escaped;
        escaped = quoted && letter == '\\' && !escaped;
        letter == separator && !quoted
    })
}

/// The answer to `Prefer: return=minimal`.
#[derive(Debug, PartialEq, Serialize, ToSchema)]
pub struct MinimalAnswer {
    id: String,
    states: VerdictCounts,
    /// What was noticed beside what is known of the IMU and its gyros.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<NoteBody>,
}

/// How many verdicts there are of each state.
#[derive(Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
struct VerdictCounts {
    within: usize,
    indeterminate: usize,
    exceeded: usize,
}

impl MinimalAnswer {
    pub fn of(id: Id, states: impl Iterator<Item = State>, notes: Vec<NoteBody>) -> Self {
        let mut counts = VerdictCounts::default();
        for state in states {
            *match state {
                State::Within => &mut counts.within,
                State::Indeterminate => &mut counts.indeterminate,
                State::Exceeded => &mut counts.exceeded,
            } += 1;
        }
        Self { id: id.to_string(), states: counts, notes }
    }
}

/// As much of an answer as was wanted.
#[derive(Serialize)]
#[serde(untagged)]
pub enum AsWanted<T> {
    Whole(T),
    Minimal(MinimalAnswer),
}

impl<T> AsWanted<T> {
    /// `whole`, or what is left of it: the identifier, the `states` of its verdicts and its notes.
    pub fn of(wanted: Prefer, whole: T, id: Id, states: impl Iterator<Item = State>, notes: Vec<NoteBody>) -> Self {
        match wanted {
            Prefer::Whole => Self::Whole(whole),
            Prefer::Minimal => Self::Minimal(MinimalAnswer::of(id, states, notes)),
        }
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;
    use rstest::rstest;

    use super::*;

    #[rstest]
    #[case::nothing(&[], Prefer::Whole)]
    #[case::alone(&["return=minimal"], Prefer::Minimal)]
    #[case::in_any_case(&["Return=Minimal"], Prefer::Minimal)]
    #[case::quoted(&["return=\"minimal\""], Prefer::Minimal)]
    #[case::among_others(&["respond-async, wait=10, return=minimal"], Prefer::Minimal)]
    #[case::with_parameters(&["return = minimal ; foo=bar"], Prefer::Minimal)]
    #[case::in_another_line(&["respond-async", "return=minimal"], Prefer::Minimal)]
    #[case::the_first_counts(&["return=representation, return=minimal"], Prefer::Whole)]
    #[case::in_a_quotation(&["note=\"a, return=minimal\""], Prefer::Whole)]
    #[case::in_a_quotation_with_a_quotation_mark(&["note=\"a\\\", return=minimal\""], Prefer::Whole)]
    #[case::of_another_name(&["returns=minimal"], Prefer::Whole)]
    #[case::without_a_value(&["return"], Prefer::Whole)]
    #[case::the_first_counts_without_a_value_too(&["return, return=minimal"], Prefer::Whole)]
    #[case::no_text(&["\u{fc}\u{ff}"], Prefer::Whole)]
    fn a_preference_is_read_as_rfc_7240_has_it(#[case] values: &[&'static str], #[case] wanted: Prefer) {
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append("prefer", HeaderValue::from_bytes(value.as_bytes()).unwrap());
        }
        assert_eq!(Prefer::of(&headers), wanted);
    }
}
