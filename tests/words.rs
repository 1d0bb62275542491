//! What people read is said in both languages alike, and as CONTRIBUTING.md asks.
//!
//! The messages are read with Fluent's own parser; the code's uses of `message!` from the sources.

use std::fs;

use gyrowatch::core::bench::BenchMethod;
use gyrowatch::core::changes::ChangeCause;
use gyrowatch::core::diagnose::Variable;
use gyrowatch::core::effects::{CATALOGUE, COMPETITORS};
use gyrowatch::core::judge::{Event, Rule, Severity, Status, Suggestion, Unseen};

use fluent_syntax::ast::{CallArguments, Entry, Expression, InlineExpression, Pattern, PatternElement};

use crate::prelude::*;

/// A message: the text with its places marked, and the names of its parameters.
struct Said {
    text: String,
    parameters: BTreeSet<String>,
}

fn files_below(dir: &Path, extension: &str) -> Vec<PathBuf> {
    let (mut found, mut open) = (Vec::new(), vec![dir.to_owned()]);
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(&dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn read(said: &mut Said, pattern: &Pattern<String>) {
    for element in &pattern.elements {
        match element {
            PatternElement::TextElement { value } => said.text.push_str(value),
            PatternElement::Placeable { expression } => read_expression(said, expression),
        }
    }
}

fn read_expression(said: &mut Said, expression: &Expression<String>) {
    match expression {
        Expression::Inline(inline) => read_inline(said, inline),
        Expression::Select { selector, variants } => {
            let mut unread = Said { text: String::new(), parameters: BTreeSet::new() };
            read_inline(&mut unread, selector);
            said.parameters.extend(unread.parameters);
            // Each variant is a text of its own.
            for variant in variants {
                said.text.push('\n');
                read(said, &variant.value);
            }
        }
    }
}

fn read_inline(said: &mut Said, inline: &InlineExpression<String>) {
    match inline {
        InlineExpression::VariableReference { id } => {
            said.text.push('\u{25a1}');
            said.parameters.insert(id.name.clone());
        }
        InlineExpression::FunctionReference { arguments: CallArguments { positional, .. }, .. } => {
            positional.iter().for_each(|inline| read_inline(said, inline));
        }
        InlineExpression::StringLiteral { value } => said.text.push_str(value),
        InlineExpression::Placeable { expression } => read_expression(said, expression),
        _ => said.text.push('\u{25a1}'),
    }
}

/// The messages of a language by their codes.
fn messages(language: &str) -> BTreeMap<String, Said> {
    let mut found = BTreeMap::new();
    for file in files_below(&root().join("src/words").join(language), "ftl") {
        let source = fs::read_to_string(&file).unwrap();
        let resource =
            fluent_syntax::parser::parse(source).unwrap_or_else(|(_, errors)| panic!("{file:?}: {errors:?}"));
        for entry in resource.body {
            let Entry::Message(message) = entry else { continue };
            let mut said = Said { text: String::new(), parameters: BTreeSet::new() };
            read(&mut said, &message.value.expect("a message has a text"));
            let code = message.id.name;
            assert!(found.insert(code.clone(), said).is_none(), "{code} is said twice in {language}");
        }
    }
    found
}

/// The uses of `message!` in a source: code and names of parameters.
fn uses(source: &str) -> Vec<(String, BTreeSet<String>)> {
    let production = source.find("\n#[cfg(test)]").map_or(source, |end| &source[..end]);
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    let production = &production.lines().filter(is_code).collect::<Vec<_>>().join("\n");
    let mut found = Vec::new();
    for (at, _) in production.match_indices("message!(") {
        let rest = &production[at + "message!(".len()..];
        let inside = &rest[..closing(rest)];
        let Some(code) = inside.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next()) else {
            continue;
        };
        found.push((code.to_owned(), names(&inside[inside.find(code).unwrap() + code.len() + 1..])));
    }
    found
}

/// Where the parenthesis that is open closes.
fn closing(text: &str) -> usize {
    let (mut depth, mut quoted, mut escaped) = (1, false, false);
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => {
                depth -= 1;
                if depth == 0 {
                    return at;
                }
            }
            _ => {}
        }
    }
    text.len()
}

/// `a`, `b` and `d` of `, a = 1, b = f(c = 2), d`.
fn names(arguments: &str) -> BTreeSet<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0, false);
    for c in arguments.chars() {
        match c {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => parts.push(String::new()),
            c if depth == 0 => parts.last_mut().unwrap().push(c),
            _ => {}
        }
    }
    let name = |part: &String| part.split_whitespace().next().map(str::to_owned);
    parts.iter().filter_map(name).collect()
}

#[test]
fn both_languages_say_the_same_with_the_same_parameters() {
    let [english, chinese] = ["en", "zh"].map(messages);
    let mut faults = Vec::new();
    for (code, said) in &english {
        match chinese.get(code) {
            None => faults.push(format!("{code}: not said in Chinese")),
            Some(other) if other.parameters != said.parameters => {
                faults.push(format!("{code}: {:?} in English, {:?} in Chinese", said.parameters, other.parameters));
            }
            Some(_) => {}
        }
    }
    faults.extend(
        chinese.keys().filter(|code| !english.contains_key(*code)).map(|code| format!("{code}: not in English")),
    );
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// A head of a table has as many columns in both languages.
#[test]
fn heads_of_tables_have_the_same_columns() {
    let [english, chinese] = ["en", "zh"].map(messages);
    let heads: Vec<&String> = english.keys().filter(|code| code.ends_with("_head")).collect();
    assert!(heads.len() > 5, "{heads:?}");
    for code in heads {
        let columns = |said: &Said| said.text.split(" | ").count();
        assert_eq!(columns(&english[code]), columns(&chinese[code]), "{code}");
    }
}

/// The codes of what has a name: rules, statuses, severities, events and methods (`core/named.rs`), and effects.
fn named() -> BTreeSet<String> {
    let codes = [
        Rule::ALL.map(Rule::word).to_vec(),
        Status::ALL.map(Status::word).to_vec(),
        Severity::ALL.map(Severity::word).to_vec(),
        Event::ALL.map(Event::word).to_vec(),
        BenchMethod::ALL.map(BenchMethod::word).to_vec(),
        Variable::ALL.map(Variable::word).to_vec(),
        Suggestion::ALL.map(Suggestion::word).to_vec(),
        Unseen::ALL.map(Unseen::word).to_vec(),
        ChangeCause::ALL.map(ChangeCause::word).to_vec(),
    ];
    // The macro makes `page_search` of `search`.
    let of_pages = fs::read_to_string(root().join("src/pages/text/words.rs")).unwrap();
    let fields = of_pages.split_once("\nwords_of_pages! {").expect("the fields").1.lines();
    let fields = fields.filter(|line| !line.trim_start().starts_with("//")).flat_map(str::split_whitespace);
    let of_pages: Vec<String> = fields.filter(|field| *field != "}").map(|field| format!("page_{field}")).collect();
    assert!(of_pages.len() > 500, "{of_pages:?}");
    let effects = CATALOGUE.iter().chain(&COMPETITORS).map(|entry| entry.effect.word());
    let needs = CATALOGUE.iter().map(|entry| entry.effect.needs());
    codes
        .into_iter()
        .flatten()
        .chain(effects)
        .chain(needs)
        .map(|message| message.code.into_owned())
        .chain(of_pages)
        .collect()
}

#[test]
fn what_the_code_says_has_words_with_its_parameters() {
    let sample =
        "f(message!(\"a_b\", x = g(y = 1), z = \"q, w = 1\", v));\nmessage!(\"c\")\n#[cfg(test)]\nmessage!(\"d\")";
    let found = uses(sample);
    assert_eq!(found[0], ("a_b".to_owned(), ["v", "x", "z"].map(str::to_owned).into()));
    assert_eq!(found.len(), 2);

    let english = messages("en");
    let mut faults: Vec<String> = named()
        .into_iter()
        .filter(|code| !english.contains_key(code))
        .map(|code| format!("{code} has no words"))
        .collect();
    for file in files_below(&root().join("src"), "rs") {
        for (code, parameters) in uses(&fs::read_to_string(&file).unwrap()) {
            match english.get(&code) {
                None => faults.push(format!("{}: {code} has no words", file.display())),
                Some(said) if said.parameters != parameters => {
                    faults.push(format!(
                        "{}: {code} has {parameters:?}, its words {:?}",
                        file.display(),
                        said.parameters
                    ));
                }
                Some(_) => {}
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn no_words_are_left_that_nothing_says() {
    let sources: Vec<String> =
        files_below(&root().join("src"), "rs").iter().map(|file| fs::read_to_string(file).unwrap()).collect();
    let named = named();
    let is_quoted = |text: &str| sources.iter().any(|source| source.contains(&format!("\"{text}\"")));
    // Of a test for more, or of what the noise is known from: the code has the name alone.
    let is_of_diagnosis = |code: &str| {
        code.strip_prefix("sign_").is_some_and(is_quoted)
            || code.strip_prefix("noise_").is_some_and(|source| is_quoted(&source.replace('_', "+")))
    };
    let unsaid = |code: &&String| !named.contains(*code) && !is_quoted(code) && !is_of_diagnosis(code);
    let unsaid: Vec<String> = messages("en").keys().filter(unsaid).cloned().collect();
    // Of the renderer's own test.
    assert_eq!(unsaid, [""; 0]);
}

const MOST_WORDS: usize = 40;

/// Wordings that are replaced by plainer ones.
const REPLACED: [&str; 36] = [
    " lies ",
    "has lain",
    "what parts",
    "whoever",
    "whatever is",
    "where anything",
    "is named below",
    "somewhere in",
    "a name asks for",
    "stands out for",
    "have left, so",
    "closes of what",
    "somebody knows",
    "and mean it",
    "without doing it",
    "narrows nothing",
    "rules that are kept",
    "there ever was",
    "none of this service",
    "given out",
    "the copy is whole",
    "parted by",
    "a row a gyro",
    "import it again to go on",
    "on a fast hour",
    "by turns with",
    "beside other work",
    "memory of the attitude",
    "north is off",
    "yields across",
    "one dwell is wrong",
    "no more repeats",
    "why it changed",
    "what happened to it",
    "nothing is noted",
    "read what this does",
];

/// Wordings of Chinese that are replaced by the paper's.
const REPLACED_CHINESE: [&str; 6] = ["警报", "台站", "位置段", "经历", "自转轴", "超限"];

#[test]
fn sentences_are_short_and_plain() {
    let mut faults = Vec::new();
    for (code, said) in messages("en") {
        let text = said.text.to_lowercase();
        for sentence in text.split(['.', '\n', ':', ';']) {
            let words = sentence.split_whitespace().count();
            if words > MOST_WORDS {
                faults.push(format!("{code}: a sentence of {words} words"));
            }
        }
        faults.extend(REPLACED.iter().filter(|old| text.contains(*old)).map(|old| format!("{code}: says {old:?}")));
    }
    for (code, said) in messages("zh") {
        let old = REPLACED_CHINESE.iter().filter(|old| said.text.contains(*old));
        faults.extend(old.map(|old| format!("{code}: says {old:?} in Chinese")));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// Zero-width and direction marks get into what people copy, and break it.
#[test]
fn no_words_hold_marks_that_nobody_sees() {
    let is_mark =
        |c: char| matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    for language in ["en", "zh"] {
        for (code, said) in messages(language) {
            assert!(!said.text.contains(is_mark), "{language}: {code}");
        }
    }
}
