//! What a file holds: one document, several in an array, or one a line; each with the line on which it begins.

use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use crate::wire::campaign::Form;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece<'a> {
    /// Counting from 1.
    pub line: usize,
    pub text: &'a str,
    pub form: Form,
}

/// The content decides, not a name. What is no JSON is read as a campaign's CSV.
pub(super) fn pieces(text: &str) -> Vec<Piece<'_>> {
    let text = text.trim_start_matches('\u{feff}');
    let body = text.trim();
    let mut lines_passed = Lines { whole: text, passed: 0, line: 1 };
    let mut piece = |part, form| Piece { line: lines_passed.line_of(part), text: part, form };
    let mut json = |part| piece(part, Form::Json);
    if body.is_empty() {
        return Vec::new();
    }
    if let Ok(members) = serde_json::from_str::<Vec<&RawValue>>(body) {
        return members.into_iter().map(|member| json(member.get())).collect();
    }
    let lines = body.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_several = lines.clone().nth(1).is_some();
    let is_object = |line: &str| line.starts_with('{') && serde_json::from_str::<IgnoredAny>(line).is_ok();
    if is_several && lines.clone().next().is_some_and(is_object) {
        return lines.map(json).collect();
    }
    if body.starts_with(['{', '[', '"']) {
        return vec![json(body)];
    }
    vec![piece(body, Form::Csv)]
}

/// The lines of a text as far as its parts, which ascend, have come: every line is counted once, however many parts
/// there are.
struct Lines<'a> {
    whole: &'a str,
    passed: usize,
    line: usize,
}

impl Lines<'_> {
    fn line_of(&mut self, part: &str) -> usize {
        let start = part.as_ptr() as usize - self.whole.as_ptr() as usize;
        self.line += self.whole[self.passed..start].matches('\n').count();
        self.passed = start;
        self.line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(usize, &str)> {
        pieces(text).into_iter().map(|piece| (piece.line, piece.text)).collect()
    }

    #[test]
    fn files_are_taken_apart_by_what_they_hold() {
        assert_eq!(lines("\u{feff}\n{\n \"a\": 1\n}\n"), [(2, "{\n \"a\": 1\n}")]);
        assert_eq!(
            lines("{\"a\": 1}\n\n  {\"b\": 2}\n{ broken"),
            [(1, "{\"a\": 1}"), (3, "{\"b\": 2}"), (4, "{ broken")]
        );
        assert_eq!(lines("[{\"a\": 1},\n {\"b\": 2}]"), [(1, "{\"a\": 1}"), (2, "{\"b\": 2}")]);
        assert_eq!(lines("{ broken"), [(1, "{ broken")]);
        assert!(lines(" \n").is_empty());
        let csv = pieces("# imu: A\nphase,start_s\n");
        assert_eq!((csv.len(), csv[0].form), (1, Form::Csv));
    }

    #[test]
    fn a_large_file_of_tiny_documents_takes_no_longer_than_another_of_its_size() {
        // Counting from its start for each of them would take hours.
        const DOCUMENTS: usize = (4 << 20) / 3;
        let (tell, told) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let text = "{}\n".repeat(DOCUMENTS);
            tell.send(pieces(&text).last().map(|piece| piece.line))
        });
        assert_eq!(told.recv_timeout(std::time::Duration::from_secs(60)), Ok(Some(DOCUMENTS)));
    }
}
