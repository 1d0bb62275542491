//! Words for people: messages of the core and the edges in English and in Chinese (Project Fluent).
//!
//! Which language is asked for is known to the task: [`asked`]. The outermost middleware of the service says it for
//! each request, by the cookie of the pages or by `Accept-Language`; on the command line the environment says it.
//! Elsewhere it is English.
//!
//! One message a code, in `en/*.ftl` and `zh/*.ftl`; `tests/words.rs` proves that both languages have the same codes
//! with the same parameters.

use std::borrow::Cow;
use std::env;
use std::sync::{LazyLock, OnceLock};

use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource, FluentValue};

use crate::core::judge::Verdict;
use crate::core::message::{Message, Parameter};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Language {
    #[default]
    English,
    Chinese,
}

tokio::task_local! {
    static ASKED: Language;
}

static OF_PROCESS: OnceLock<Language> = OnceLock::new();

/// The language that this task's answer was asked for in.
pub fn asked() -> Language {
    ASKED.try_with(|language| *language).unwrap_or_else(|_| OF_PROCESS.get().copied().unwrap_or_default())
}

/// Does `work` for somebody who has asked for this language.
pub async fn asked_in<T>(language: Language, work: impl Future<Output = T>) -> T {
    ASKED.scope(language, work).await
}

/// As tokio's, in the language of this task.
pub fn spawn_blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> tokio::task::JoinHandle<T> {
    let language = asked();
    tokio::task::spawn_blocking(move || ASKED.sync_scope(language, work))
}

/// Every message of a language as its sources have it: a line a code, with the names of its parameters.
pub fn sources(language: Language) -> &'static [&'static str] {
    match language {
        Language::English => ENGLISH,
        Language::Chinese => CHINESE,
    }
}

/// The language of the environment (`LC_ALL`, else `LANG`).
pub fn of_environment() -> Language {
    let set = ["LC_ALL", "LANG"].into_iter().filter_map(|name| env::var(name).ok()).find(|value| !value.is_empty());
    set.and_then(|locale| Language::from_tag(&locale.replace(['_', '.'], "-"))).unwrap_or_default()
}

/// Takes the language of the environment for this process. Not for a service: what it stores is not its operator's.
pub fn speak_as_the_environment() {
    OF_PROCESS.get_or_init(of_environment);
}

/// The sources of both languages, by file.
macro_rules! sources {
    ($($file:literal),*) => {
        const ENGLISH: &[&str] = &[$(include_str!(concat!("en/", $file, ".ftl"))),*];
        const CHINESE: &[&str] = &[$(include_str!(concat!("zh/", $file, ".ftl"))),*];
    };
}

sources!("common", "verdicts", "notes", "faults", "refusals", "diagnosis", "history", "stations", "pages", "terminal");

static BUNDLES: LazyLock<[FluentBundle<FluentResource>; 2]> =
    LazyLock::new(|| [Language::English, Language::Chinese].map(Language::bundle));

impl Language {
    pub const ALL: [Self; 2] = [Self::English, Self::Chinese];

    /// Its tag (RFC 5646).
    pub fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::Chinese => "zh",
        }
    }

    /// By the first subtag of a language tag (RFC 5646), as `zh` of `zh-Hans-CN`.
    pub fn from_tag(tag: &str) -> Option<Self> {
        let first = tag.trim().split('-').next()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|language| language.tag() == first)
    }

    /// The first language of an `Accept-Language` that there is, by weight; English where there is none.
    pub fn preferred(accepted: &str) -> Self {
        let mut wanted: Vec<(f32, Self)> = accepted
            .split(',')
            .filter_map(|part| {
                let (tag, weight) = part.split_once(';').unwrap_or((part, ""));
                let weight: f32 = weight.trim().strip_prefix("q=").map_or(Some(1.0), |weight| weight.parse().ok())?;
                (weight > 0.0).then_some((weight, Self::from_tag(tag)?))
            })
            .collect();
        wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
        wanted.first().map_or(Self::English, |(_, language)| *language)
    }

    /// A message in words. A code that no language has, as one of a later version may be, reads as in a log.
    pub fn words(self, message: &Message) -> String {
        let bundle = &BUNDLES[self as usize];
        let Some(pattern) = bundle.get_message(&message.code).and_then(|found| found.value()) else {
            return message.to_string();
        };
        let mut arguments = FluentArgs::with_capacity(message.parameters.len());
        for (name, parameter) in &message.parameters {
            arguments.set(name.as_ref(), self.value(parameter));
        }
        let mut errors = Vec::new();
        let words = bundle.format_pattern(pattern, Some(&arguments), &mut errors);
        if errors.is_empty() { words.into_owned() } else { message.to_string() }
    }

    /// A message without parameters, by its code. Nothing is copied: the words are part of the program.
    pub fn word(self, code: &str) -> &'static str {
        let bundle = &BUNDLES[self as usize];
        let found = bundle.get_message(code).and_then(|found| found.value());
        match found.map(|pattern| bundle.format_pattern(pattern, None, &mut Vec::new())) {
            Some(Cow::Borrowed(words)) => words,
            // No such message, or one that needs parameters.
            _ => "",
        }
    }

    /// One after the other; a phrase alone is not copied.
    pub fn sentences(self, messages: &[Message]) -> Cow<'static, str> {
        if let [phrase] = messages
            && phrase.parameters.is_empty()
        {
            let word = self.word(&phrase.code);
            if !word.is_empty() {
                return Cow::Borrowed(word);
            }
        }
        let sentences: Vec<String> = messages.iter().map(|message| self.words(message)).collect();
        let between = match self {
            Self::English => " ",
            Self::Chinese => "",
        };
        Cow::Owned(sentences.join(between))
    }

    /// Why a verdict is what it is.
    pub fn reason(self, verdict: &Verdict) -> Cow<'static, str> {
        self.sentences(&verdict.messages())
    }

    fn value<'p>(self, parameter: &'p Parameter) -> FluentValue<'p> {
        match parameter {
            Parameter::Text(text) => FluentValue::from(text.as_ref()),
            Parameter::Count(count) => FluentValue::from(*count),
            Parameter::Message(message) => FluentValue::from(self.words(message)),
            Parameter::List(list) => {
                let items: Vec<String> = list.iter().map(|one| self.plain(one)).collect();
                FluentValue::from(items.join(match self {
                    Self::English => ", ",
                    Self::Chinese => "、",
                }))
            }
        }
    }

    fn plain(self, parameter: &Parameter) -> String {
        match parameter {
            Parameter::Message(message) => self.words(message),
            Parameter::List(list) => list.iter().map(|one| self.plain(one)).collect::<Vec<_>>().join(", "),
            other => other.to_string(),
        }
    }

    fn bundle(self) -> FluentBundle<FluentResource> {
        let tag = self.tag().parse().expect("the tags are well-formed");
        let mut bundle = FluentBundle::new_concurrent(vec![tag]);
        // Marks around what is filled in would get into JSON, CSV and what people copy.
        bundle.set_use_isolating(false);
        for source in sources(self) {
            let resource = FluentResource::try_new((*source).to_owned()).expect("tests read every source");
            bundle.add_resource(resource).expect("tests know that no code is said twice");
        }
        bundle
    }
}

#[cfg(test)]
mod verdict_tests;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::message::{figure, list};
    use crate::message;

    #[test]
    fn the_preferred_language_is_the_first_that_there_is() {
        for (accepted, language) in [
            ("zh-CN,zh;q=0.9,en;q=0.8", Language::Chinese),
            ("en-GB,zh;q=0.9", Language::English),
            ("fr, zh-TW; q=0.3, en;q=0.2", Language::Chinese),
            ("en;q=0, zh;q=0.1", Language::Chinese),
            ("de", Language::English),
            ("zh;q=0", Language::English),
            ("", Language::English),
        ] {
            assert_eq!(Language::preferred(accepted), language, "{accepted}");
        }
    }

    #[test]
    fn whoever_acts_has_not_always_adopted_something() {
        assert_eq!(Language::ALL.map(|language| language.word("page_author")), ["By", "操作人"]);
    }

    #[test]
    fn a_message_is_said_with_its_parameters_and_without_marks() {
        let unknown = message!("no_such_code_anywhere", value = figure(0.5, 2), of = list(["a", "b"]));
        assert_eq!(Language::Chinese.words(&unknown), "no_such_code_anywhere (value: 0.50, of: a, b)");
        let said = Language::English.words(&message!("beside", first = "a", second = "b"));
        assert_eq!(said, "a and b");
        assert_eq!(Language::Chinese.words(&message!("beside", first = "a", second = "b")), "a与b");
    }
}
