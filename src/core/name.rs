//! Names of IMUs, stations and gyros: one spelling each, and which names look or read alike.

use std::borrow::Cow;

use unicode_normalization::UnicodeNormalization;
use unicode_properties::{GeneralCategory, UnicodeGeneralCategory};
use unicode_security::confusable_detection::skeleton;

use crate::core::message::Message;
use crate::message;

/// Longest identifier (IMU, station, serial, operator, campaign) in characters.
pub const MAX_NAME_CHARS: usize = 64;

/// A non-empty identifier without control characters, in its [normal form](normal_form).
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(String);

impl Name {
    /// Reads a name as it was sent or stored. What nobody can see in it stays: see [`Name::unseen`].
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, Message> {
        if text.trim().is_empty() {
            return Err(message!("empty_text"));
        }
        let chars = text.chars().count();
        if chars > MAX_NAME_CHARS {
            return Err(message!("too_many_characters", most = MAX_NAME_CHARS, have = chars));
        }
        if let Some(c) = text.chars().find(|c| c.is_control()) {
            return Err(message!("control_character", character = format_args!("U+{:04X}", c as u32)));
        }
        Ok(Self(normal_form(text).into_owned()))
    }

    /// In its one spelling.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The first character that nobody can see: a new name must have none.
    pub fn unseen(&self) -> Option<char> {
        self.0.chars().find(|&c| is_unseen(c))
    }

    /// # Errors
    /// Where the name has a character that nobody can see.
    pub fn check_seen(&self) -> Result<(), Message> {
        self.unseen()
            .map_or(Ok(()), |c| Err(message!("invisible_character", character = format_args!("U+{:04X}", c as u32))))
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// Composed characters (NFC), no blanks at the ends, one space for each run of blanks within.
pub fn normal_form(text: &str) -> Cow<'_, str> {
    let plain = |(before, c): (u8, u8)| c.is_ascii_graphic() || c == b' ' && before != b' ';
    let pairs = std::iter::once(b' ').chain(text.bytes()).zip(text.bytes());
    if pairs.into_iter().all(plain) && !text.ends_with(' ') {
        return Cow::Borrowed(text);
    }
    let words: Vec<&str> = text.split_whitespace().collect();
    Cow::Owned(words.join(" ").nfc().collect())
}

/// Whether a character takes no ink: format characters, and what Unicode calls ignorable by default
/// (Default_Ignorable_Code_Point).
fn is_unseen(c: char) -> bool {
    if c.is_ascii() {
        return false;
    }
    let of_format = matches!(
        c.general_category(),
        GeneralCategory::Format | GeneralCategory::LineSeparator | GeneralCategory::ParagraphSeparator
    );
    of_format
        || matches!(c,
            '\u{034F}' | '\u{115F}' | '\u{1160}' | '\u{17B4}' | '\u{17B5}' | '\u{180B}'..='\u{180F}' | '\u{2065}'
            | '\u{2800}' | '\u{3164}' | '\u{FE00}'..='\u{FE0F}' | '\u{FFA0}' | '\u{FFF0}'..='\u{FFF8}'
            | '\u{E0000}'..='\u{E0FFF}')
}

/// The keys under which a name is known to its look-alikes: two names look alike where they share one. The first is
/// how it looks (Unicode TS 39, so that O and 0, l and 1, Latin and Cyrillic are one), the second how it reads in
/// small letters. Hyphens, spaces and underscores count in neither but between digits: 1-11 is not 11-1.
pub fn look_keys(name: &str) -> [String; 2] {
    // What looks like 1 is kept apart from a capital L, whose small form it is.
    let looks =
        without_gaps(skeleton(name).map(|c| if c == 'l' { '\u{1}' } else { c }), &['O', '\u{1}']).to_lowercase();
    [format!("\u{2}{looks}"), without_gaps(name.chars(), &[]).to_lowercase()]
}

/// Without hyphens, spaces and underscores; between digits, and what looks like them, there is one for each run.
fn without_gaps(name: impl Iterator<Item = char>, like_digits: &[char]) -> String {
    let is_digit = |c: char| c.is_ascii_digit() || like_digits.contains(&c);
    let (mut kept, mut gap) = (String::new(), false);
    for c in name {
        if matches!(c, '-' | '_' | ' ') {
            gap = true;
            continue;
        }
        if gap && is_digit(c) && kept.chars().next_back().is_some_and(is_digit) {
            kept.push('-');
        }
        gap = false;
        kept.push(c);
    }
    kept
}

/// How many characters are to be changed, put in, left out or exchanged with their neighbour to make `a` of `b`; none
/// where more than `most`.
pub fn distance(a: &str, b: &str, most: usize) -> Option<usize> {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > most {
        return None;
    }
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let changed = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = changed.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(before[j - 2] + 1);
            }
            row.push(least);
        }
        if row.iter().all(|&d| d > most) {
            return None;
        }
        before = std::mem::replace(&mut above, row);
    }
    above.last().copied().filter(|&d| d <= most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_one_spelling() {
        for (sent, name) in [
            ("LFG-0101", "LFG-0101"),
            (" LFG-0101\u{a0}", "LFG-0101"),
            ("\u{3000}ST 2", "ST 2"),
            ("ST  2", "ST 2"),
            ("ST\u{a0}\u{2003}2", "ST 2"),
            ("Caf\u{65}\u{301}", "Caf\u{e9}"),
            ("\u{212b}", "\u{c5}"),
            ("IMU 07", "IMU 07"),
        ] {
            assert_eq!(Name::parse(sent).unwrap().as_str(), name, "{sent:?}");
            assert_eq!(normal_form(name), name, "the normal form of itself");
        }
        for none in ["", " ", "\u{a0}\u{3000}", "a\u{7}", "a\tb", "x\n"] {
            assert!(Name::parse(none).is_err(), "{none:?}");
        }
        assert!(Name::parse(&"x".repeat(65)).is_err());
    }

    #[test]
    fn what_nobody_can_see_is_named() {
        let marks = [
            '\u{200b}',
            '\u{200d}',
            '\u{feff}',
            '\u{202e}',
            '\u{2066}',
            '\u{ad}',
            '\u{fe0f}',
            '\u{e0041}',
            '\u{e0100}',
            '\u{2060}',
            '\u{61c}',
            '\u{3164}',
            '\u{34f}',
            '\u{180e}',
            '\u{2028}',
        ];
        for mark in marks {
            for sent in [format!("M{mark}3"), format!("{mark}M3"), format!("M3{mark}")] {
                let name = Name::parse(&sent).unwrap();
                // The line separator is a blank, and goes with the others.
                assert_eq!(name.unseen(), Some(mark).filter(|_| mark != '\u{2028}'), "{sent:?}");
            }
        }
        for seen in ["LFG-0101", "№ 7", "IMU-07", "Müller", "Б-12", "ﾊ-1", "e\u{301}"] {
            assert_eq!(Name::parse(seen).unwrap().unseen(), None, "{seen}");
        }
    }

    fn alike(a: &str, b: &str) -> bool {
        let (a, b) = (look_keys(a), look_keys(b));
        a.iter().any(|key| b.contains(key))
    }

    #[test]
    fn names_that_look_alike_share_a_key() {
        for (a, b) in [
            ("LFG-0101", "LFG-O101"),
            ("LFG-0101", "LFG-0l01"),
            ("LFG-0101", "LFG-OIOI"),
            ("M3", "\u{41c}3"),
            ("AB-1", "\u{391}\u{392}-1"),
            ("LFG-0101", "lfg-0101"),
            ("LFG-0101", "LFG\u{2010}0101"),
            ("IMU-10", "IMU10"),
            ("IMU-10", "imu 10"),
            ("ST_2", "ST-2"),
            ("ST_2", "ST2"),
            ("A0-1", "AO_1"),
        ] {
            assert!(alike(a, b), "{a} {b}");
        }
        for (a, b) in
            [("LFG-0101", "LFG-0102"), ("GL-1", "G1-1"), ("ST-2", "ST-Z"), ("A8", "AB"), ("G5", "GS"), ("1-11", "11-1")]
        {
            assert!(!alike(a, b), "{a} {b}");
        }
    }

    #[test]
    fn the_distance_counts_slips_of_the_pen() {
        for (a, b, d) in [
            ("LFG-0101", "LFG-0101", Some(0)),
            ("LFG-0101", "LFG-0110", Some(1)),
            ("LFG-0101", "LFG-101", Some(1)),
            ("LFG-0101", "LGF-0191", Some(2)),
            ("kitten", "sitting", None),
            ("", "ab", Some(2)),
        ] {
            assert_eq!(distance(a, b, 2), d, "{a} {b}");
        }
        assert_eq!(distance("kitten", "sitting", 3), Some(3));
    }
}
