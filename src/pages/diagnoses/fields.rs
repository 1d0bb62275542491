//! What somebody wrote into the fields of a form.

/// What somebody wrote into a field, if anything.
pub(super) fn said(text: &str) -> Option<String> {
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}

/// A date stands for its first instant, in UTC.
pub(super) fn beginning(text: &str) -> Option<String> {
    said(text).map(|text| if is_date(&text) { text + "T00:00:00Z" } else { text })
}

/// A date stands for its last instant, in UTC.
pub(super) fn end(text: &str) -> Option<String> {
    said(text).map(|text| if is_date(&text) { text + "T23:59:59.999999Z" } else { text })
}

fn is_date(text: &str) -> bool {
    text.len() == 10 && text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_stands_for_the_whole_day_and_a_time_for_itself() {
        assert_eq!(beginning(" 2026-03-01 ").as_deref(), Some("2026-03-01T00:00:00Z"));
        assert_eq!(end("2026-03-01").as_deref(), Some("2026-03-01T23:59:59.999999Z"));
        assert_eq!(end("2026-03-01T08:00:00Z").as_deref(), Some("2026-03-01T08:00:00Z"));
        assert_eq!((beginning(""), end("  ")), (None, None));
    }
}
