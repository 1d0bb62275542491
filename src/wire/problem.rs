//! Errors as clients read them: problem details for HTTP APIs (RFC 9457).

use std::borrow::Cow;
use std::fmt::Display;

use utoipa::PartialSchema;
use utoipa::openapi::{RefOr, Schema};

use crate::core::id::Id;
use crate::core::message::{list, sent, text};
use crate::core::named::Named;
use crate::wire::prelude::*;

/// What went wrong, before it is words.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The HTTP status.
    pub status: u16,
    /// The code of its title: short, the same for every occurrence.
    pub title: &'static str,
    /// What happened this time.
    pub message: Message,
    /// The places in the body at fault, where there are any.
    pub places: Vec<Fault>,
    /// The stored item that stands in the way, where there is one.
    pub existing: Option<String>,
}

/// What went wrong, for a program (`status`, `code`, `parameters`, `errors`) and for a person (`title`, `detail`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// Short, the same for every occurrence.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What happened this time, and its parameters.
    #[serde(flatten)]
    pub message: MessageBody,
    /// The same in words, in the language of `Accept-Language`.
    pub detail: String,
    /// The places in the body at fault, where there are any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<Place>,
    /// The id of the stored item that stands in the way, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub existing: Option<String>,
}

/// One place at fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Place {
    /// JSON pointer into the body as it was sent; empty for the whole document.
    pub pointer: String,
    #[serde(flatten)]
    pub message: MessageBody,
    /// The same in words.
    pub detail: String,
}

/// Constructors of the 404s: what is asked for by this name or identifier is not there.
macro_rules! not_there {
    ($($of:ident($given:ident): $title:literal, $message:expr;)*) => {
        impl Problem {
            $(pub fn $of($given: impl Display) -> Self {
                Self::new(404, $title, $message)
            })*
        }
    };
}

not_there! {
    unknown_gyro(serial): "title_unknown_gyro", message!("unknown_gyro", serial = text(serial));
    unknown_alert(id): "title_unknown_alert", message!("unknown_alert", id = text(id));
    unknown_silence(id): "title_unknown_silence", message!("unknown_silence", id = text(id));
    no_such_station(name): "title_no_such_station", message!("no_such_station", name = text(name));
    no_such_record(id): "title_no_such_record", message!("no_such_record", id = text(id));
    no_such_campaign(id): "title_no_such_campaign", message!("no_such_campaign", id = text(id));
    no_such_bench_result(id): "title_no_such_bench_result", message!("no_such_bench_result", id = text(id));
    no_such_reference(id): "title_no_such_reference", message!("no_such_reference", id = text(id));
    no_such_hook(id): "title_no_such_hook", message!("no_such_hook", id = text(id));
    no_such_delivery(id): "title_no_such_delivery", message!("no_such_delivery", id = text(id));
    no_such_diagnoses(id): "title_no_such_diagnoses", message!("no_such_diagnoses", id = text(id));
    no_such_token(id): "title_no_such_token", message!("no_such_token", id = text(id));
    no_such_hypothesis(name): "title_no_such_hypothesis", message!("no_such_hypothesis", name = sent(&name.to_string()));
}

impl Problem {
    /// `title` is the code of the title's words.
    pub fn new(status: u16, title: &'static str, message: Message) -> Self {
        Self { status, title, message, places: Vec::new(), existing: None }
    }

    /// A body that is no JSON (400) or says what cannot be stored (422): the faults at their places.
    pub fn of_faults(status: u16, title: &'static str, faults: Faults) -> Self {
        Self { places: faults.0, ..Self::new(status, title, message!("faults_in_document")) }
    }

    /// Names what stands in the way.
    pub fn with_existing(mut self, id: impl ToString) -> Self {
        self.existing = Some(id.to_string());
        self
    }

    /// Names the place in the document that its message is about.
    pub fn at(self, pointer: impl Into<String>) -> Self {
        let message = self.message.clone();
        self.with_place(pointer, message)
    }

    /// Adds a place in the document, by its JSON pointer.
    pub fn with_place(mut self, pointer: impl Into<String>, message: Message) -> Self {
        self.places.push(Fault { pointer: pointer.into(), message });
        self
    }

    /// In words.
    pub fn body(&self, language: Language) -> ProblemBody {
        let place = |fault: &Fault| Place {
            pointer: fault.pointer.clone(),
            message: MessageBody::of(&fault.message, language),
            detail: language.words(&fault.message),
        };
        let errors = self.places.iter().map(place).collect();
        let detail = if self.message.code == "faults_in_document" {
            summary(&self.places, language)
        } else {
            language.words(&self.message)
        };
        let message = MessageBody::of(&self.message, language);
        // A title that is no code is said as it is.
        let title = Some(language.word(self.title)).filter(|words| !words.is_empty()).unwrap_or(self.title).to_owned();
        let existing = self.existing.clone();
        ProblemBody { title, status: self.status, message, detail, errors, existing }
    }
}

/// The answer to a parameter that must be one of those that are known: what is ignored would show more than was asked
/// for.
pub fn not_one_of(parameter: &'static str, known: impl IntoIterator<Item = &'static str>, value: &str) -> Problem {
    let fault = message!("parameter_one_of", parameter, known = list(known), value = value.to_owned());
    Problem::new(400, "title_bad_query", fault)
}

pub fn named<T: Named>(parameter: &'static str, asked: Option<&str>) -> Result<Option<T>, Problem> {
    let value = |name: &str| T::from_name(name).ok_or_else(|| not_one_of(parameter, T::NAMES.iter().copied(), name));
    asked.map(value).transpose()
}

/// The identifier in a path; `no_such` says that nothing has it.
pub fn id<'t>(text: &'t str, no_such: fn(&'t str) -> Problem) -> Result<Id, Problem> {
    text.parse().map_err(|_| no_such(text))
}

/// Every fault with its place, for those who show no more than the detail.
pub fn summary(faults: &[Fault], language: Language) -> String {
    let document = language.word("whole_document");
    let place = |fault: &Fault| {
        let pointer = if fault.pointer.is_empty() { document } else { &fault.pointer };
        format!("{pointer}: {}", language.words(&fault.message))
    };
    faults.iter().map(place).collect::<Vec<_>>().join("; ")
}

impl PartialSchema for Problem {
    fn schema() -> RefOr<Schema> {
        ProblemBody::schema()
    }
}

impl ToSchema for Problem {
    fn name() -> Cow<'static, str> {
        ProblemBody::name()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        ProblemBody::schemas(schemas);
    }
}
