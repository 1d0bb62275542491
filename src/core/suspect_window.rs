//! Windows of time in which what a station measured is suspect.

use super::time::{Span, UtcMicros};

/// What is calibrated in `span`, its ends included, does not count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SuspectWindow {
    pub span: Span,
    pub author: String,
    pub reason: String,
}

/// How somebody marked a window: as suspect, or as to be trusted again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    pub window: SuspectWindow,
    pub trusted: bool,
}

/// The windows that are suspect by all marks, oldest mark first: where two meet, the later holds.
/// They do not meet one another, and are in order of time.
pub fn in_force<'a>(marks: impl IntoIterator<Item = &'a Mark>) -> Vec<SuspectWindow> {
    let mut windows: Vec<SuspectWindow> = Vec::new();
    for Mark { window, trusted } in marks {
        windows = windows.into_iter().flat_map(|earlier| outside(earlier, window.span)).collect();
        if !trusted {
            windows.push(window.clone());
        }
    }
    windows.sort_by_key(|window| window.span.from);
    windows
}

/// The parts of a window before and after a span.
fn outside(window: SuspectWindow, cut: Span) -> impl Iterator<Item = SuspectWindow> {
    let Span { from, to } = window.span;
    let before = Span { from, to: to.min(UtcMicros(cut.from.0.saturating_sub(1))) };
    let after = Span { from: from.max(UtcMicros(cut.to.0.saturating_add(1))), to };
    let is_whole = to < cut.from || cut.to < from;
    let parts = if is_whole { vec![window.span] } else { vec![before, after] };
    parts.into_iter().filter(|span| span.from <= span.to).map(move |span| SuspectWindow { span, ..window.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(from: i64, to: i64, trusted: bool) -> Mark {
        let span = Span { from: UtcMicros(from), to: UtcMicros(to) };
        Mark { window: SuspectWindow { span, author: "Li Wei".into(), reason: format!("{from}") }, trusted }
    }

    fn spans(marks: &[Mark]) -> Vec<(i64, i64, String)> {
        in_force(marks).into_iter().map(|it| (it.span.from.0, it.span.to.0, it.reason)).collect()
    }

    #[test]
    fn of_two_marks_the_later_holds_where_they_meet() {
        let ten = mark(10, 20, false);
        let whole = (10, 20, "10".to_owned());
        for (then, left) in [
            (mark(0, 9, true), vec![whole.clone()]),
            (mark(21, 30, true), vec![whole]),
            (mark(10, 20, true), vec![]),
            (mark(0, 99, true), vec![]),
            (mark(0, 10, true), vec![(11, 20, "10".into())]),
            (mark(13, 15, true), vec![(10, 12, "10".into()), (16, 20, "10".into())]),
            (mark(20, 25, true), vec![(10, 19, "10".into())]),
            (mark(15, 25, false), vec![(10, 14, "10".into()), (15, 25, "15".into())]),
            (mark(0, 12, false), vec![(0, 12, "0".into()), (13, 20, "10".into())]),
        ] {
            assert_eq!(spans(&[ten.clone(), then.clone()]), left, "{then:?}");
        }
        assert_eq!(
            spans(&[mark(10, 20, true), ten.clone()]),
            [(10, 20, "10".to_owned())],
            "doubted after it was trusted"
        );
        let ever = mark(i64::MIN, i64::MAX, true);
        assert_eq!(spans(&[ten, ever]), []);
    }
}
