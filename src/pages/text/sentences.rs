//! What a diagnosis says in English, said in Chinese.
//!
//! Those words are made where they are known (`core/diagnose`), for programs as well as for people, and in one
//! language. Here each form of sentence stands beside its Chinese. `{}` stands for whatever was filled in; in Chinese `{0}`,
//! `{1}` … (`{a}` after `{9}`) for what the first, the second … held. What was filled in may be a sentence or the name of an effect itself.
//! What is not known is left as it is.

mod diagnosis;

use super::Text;
use crate::core::effects::Effect;
use crate::words::Language;

type Sentence = (&'static str, &'static str);

const ALL: [&[Sentence]; 1] = [diagnosis::SENTENCES];

impl Text {
    /// What a diagnosis says, in this language.
    pub fn spoken(&self, english: &str) -> String {
        if self.tag == "zh" { in_chinese(english) } else { english.to_owned() }
    }
}

fn in_chinese(english: &str) -> String {
    sentence_by_sentence(english).or_else(|| known(english)).unwrap_or_else(|| english.to_owned())
}

/// A reason is several sentences, each with a form of its own.
fn sentence_by_sentence(english: &str) -> Option<String> {
    let (first, rest) = english.split_once(". ")?;
    Some(known(&format!("{first}."))? + &sentence_by_sentence(rest).or_else(|| known(rest))?)
}

/// What has a form as a whole.
fn known(english: &str) -> Option<String> {
    if let Some(effect) = Effect::from_id(english) {
        return Some(Language::Chinese.text().effect(effect).to_owned());
    }
    let fits = |(form, chinese): &(&str, &'static str)| Some((fillings(form, english)?, *chinese));
    let (fillings, chinese) = ALL.iter().copied().flatten().find_map(fits)?;
    let mut text = chinese.to_owned();
    for (k, filling) in fillings.iter().enumerate() {
        text = text.replace(&format!("{{{k:x}}}"), &in_chinese(filling));
    }
    Some(text)
}

/// What stands in the places of a form, if the text has that form. Each place takes as little as it can.
fn fillings<'t>(form: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut fixed = form.split("{}");
    let mut rest = text.strip_prefix(fixed.next()?)?;
    let mut found = Vec::new();
    let parts: Vec<&str> = fixed.collect();
    let Some((last, inner)) = parts.split_last() else { return rest.is_empty().then_some(found) };
    for part in inner {
        let (filling, after) = rest.split_once(part)?;
        found.push(filling);
        rest = after;
    }
    found.push(rest.strip_suffix(last)?);
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::effects::CATALOGUE;

    /// Words of an equation that are the same in every language.
    const MATHEMATICS: [&str; 8] = ["sin", "cos", "tan", "exp", "sign", "tau", "phi", "period"];

    #[test]
    fn what_was_filled_in_is_kept_and_said_in_chinese_itself() {
        let reason = in_chinese("it explains the same dwells as warmup less well, and nothing beside it");
        assert!(reason.contains("上电预热") && reason.contains("位置段"), "{reason}");
        assert_eq!(in_chinese("what nobody has said before"), "what nobody has said before");
    }

    #[test]
    fn a_form_fits_whole_sentences_alone() {
        assert_eq!(fillings("a {} c", "a b c"), Some(vec!["b"]));
        assert_eq!(fillings("{}: {}", "a: b: c"), Some(vec!["a", "b: c"]));
        assert_eq!((fillings("a", "a b"), fillings("a {} c", "a b")), (None, None));
        assert_eq!(fillings("", ""), Some(vec![]));
    }

    #[test]
    fn every_sentence_uses_what_it_was_told_and_nothing_else() {
        for (english, chinese) in ALL.concat() {
            let places = english.matches("{}").count();
            for k in 0..16 {
                let used = chinese.contains(&format!("{{{k:x}}}"));
                assert!(k < places || !used, "{english}: {chinese}");
            }
            assert!(!chinese.is_ascii() || chinese.starts_with('{'), "{english}: {chinese}");
        }
    }

    #[test]
    fn everything_in_the_catalogue_of_effects_is_said_in_chinese() {
        for entry in CATALOGUE {
            let needs = in_chinese(entry.needs);
            assert!(!needs.is_ascii(), "{}: {needs}", entry.id);
            let equation = in_chinese(entry.equation);
            let words = equation.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| word.len() > 2);
            let english: Vec<&str> = words.filter(|word| !MATHEMATICS.contains(word)).collect();
            assert!(english.is_empty(), "{}: {equation}: {english:?}", entry.id);
        }
    }
}
