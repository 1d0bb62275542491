//! The text of a file with the numbers of its lines, the faulty ones marked.

use std::collections::BTreeMap;
use std::ops::Range;

use super::located::Place;
use crate::pages::prelude::*;

/// A text of no more lines is shown whole; of a longer one, so many about each faulty line.
const WHOLE: usize = 60;
const ABOUT: usize = 3;
/// Lines that are shown at most, and bytes of each.
const MOST_LINES: usize = 400;
const MOST_BYTES: usize = 600;

/// Nothing where nothing is wrong.
pub(super) fn shown(t: &Text, text: &str, places: &[Place]) -> Markup {
    let mut marked: BTreeMap<usize, Vec<&Range<usize>>> = BTreeMap::new();
    for place in places {
        marked.entry(place.line).or_default().extend(&place.part);
    }
    if marked.is_empty() {
        return html! {};
    }
    let is_whole = text.lines().take(WHOLE + 1).count() <= WHOLE;
    let is_near = |line: usize| is_whole || marked.range(line.saturating_sub(ABOUT)..=line + ABOUT).next().is_some();
    let lines = text.lines().enumerate().map(|(k, line)| (k + 1, line)).filter(|(number, _)| is_near(*number));
    let lines: Vec<(usize, &str)> = lines.take(MOST_LINES).collect();
    let follows = |k: usize| k.checked_sub(1).map_or(0, |before| lines[before].0) + 1 == lines[k].0;
    html! {
        section.source {
            h3 { (t.text_of_file) }
            div.scroll.tall tabindex="0" translate="no" {
                table.numbered {
                    tbody { @for (k, (number, line)) in lines.iter().enumerate() {
                        @if !follows(k) { tr.gap { td {} td { "…" } } }
                        @let parts = marked.get(number);
                        tr.faulty[parts.is_some()] id={ "line-" (number) } {
                            th scope="row" { (number) }
                            td { pre { (cut(line, parts.map_or(&[], Vec::as_slice))) } }
                        }
                    } }
                }
            }
        }
    }
}

/// A line with the parts underlined that faults are about.
fn cut(line: &str, parts: &[&Range<usize>]) -> Markup {
    let mut bounds: Vec<Range<usize>> = parts.iter().map(|part| (*part).clone()).collect();
    bounds.sort_by_key(|part| part.start);
    // Of a very long line, what stands about the first fault.
    let first = bounds.first().map_or(0, |part| part.start);
    let from = at_letter(line, if line.len() > MOST_BYTES { first.saturating_sub(MOST_BYTES / 4) } else { 0 });
    let to = at_letter(line, line.len().min(from + MOST_BYTES));
    let (mut at, mut pieces) = (from, Vec::new());
    for part in bounds {
        let [start, end] = [part.start, part.end].map(|byte| at_letter(line, byte).clamp(at, to));
        if start < end {
            pieces.extend([(&line[at..start], false), (&line[start..end], true)]);
            at = end;
        }
    }
    pieces.push((&line[at..to], false));
    html! {
        @if from > 0 { "…" }
        @for (text, is_marked) in pieces { @if is_marked { mark { (text) } } @else { (text) } }
        @if to < line.len() { "…" }
    }
}

/// No later than `at`, where a letter begins.
fn at_letter(line: &str, at: usize) -> usize {
    (0..=at.min(line.len())).rev().find(|at| line.is_char_boundary(*at)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::text::Language;

    fn of(text: &str, places: &[Place]) -> String {
        shown(Language::English.text(), text, places).into_string()
    }

    #[test]
    fn the_faulty_line_is_marked_and_its_cell_underlined() {
        let shown = of("a,b\n1,é<2,3\nlast", &[Place { line: 2, part: Some(2..6) }]);
        assert!(shown.contains("<pre>1,<mark>é&lt;2</mark>,3</pre>"), "{shown}");
        assert!(shown.contains("class=\"faulty\" id=\"line-2\"") && shown.contains("<pre>last</pre>"), "{shown}");
        assert_eq!(of("a\nb", &[]), "");
    }

    #[test]
    fn of_a_long_text_the_lines_about_a_fault_are_shown() {
        let text: String = (1..=500).map(|k| format!("row {k}\n")).collect();
        let shown = of(&text, &[Place { line: 7, part: None }, Place { line: 300, part: Some(0..900) }]);
        assert!(shown.contains("row 10<") && !shown.contains("row 11<") && shown.contains("<mark>row 300</mark>"));
        assert!(shown.contains("…") && !shown.contains("row 200<"), "{shown}");
        let long = format!("{}X{}", "é".repeat(2000), "z".repeat(2000));
        let shown = of(&long, &[Place { line: 1, part: Some(4000..4001) }]);
        assert!(shown.contains("<mark>X</mark>") && shown.len() < 2500, "{}", shown.len());
    }
}
