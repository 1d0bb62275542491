//! A form with a file, as a browser sends it without a script: `multipart/form-data` (RFC 7578).

use memchr::memmem;

/// A field of the form.
#[derive(Debug, PartialEq)]
pub(super) struct Part<'b> {
    pub name: &'b str,
    /// Of a file its name, as far as it is UTF-8; empty where none was chosen.
    pub file: &'b str,
    pub content: &'b [u8],
}

/// What a content type says that parts are separated by; none of another kind of form.
pub(super) fn boundary(content_type: &str) -> Option<&str> {
    let parameters = content_type.strip_prefix("multipart/form-data;")?;
    let boundary = parameters.split(';').find_map(|one| one.trim().strip_prefix("boundary="))?;
    Some(boundary.trim_matches('"'))
}

/// The fields up to the first that is not whole.
pub(super) fn parts<'b>(body: &'b [u8], boundary: &str) -> Vec<Part<'b>> {
    let delimiter = format!("\r\n--{boundary}");
    let opening = &delimiter.as_bytes()["\r\n".len()..];
    let mut rest = body.strip_prefix(opening).unwrap_or_default();
    let mut parts = Vec::new();
    while let Some(end) = memmem::find(rest, delimiter.as_bytes()) {
        parts.extend(part(&rest[..end]));
        rest = &rest[end + delimiter.len()..];
    }
    parts
}

fn part(text: &[u8]) -> Option<Part<'_>> {
    const BLANK: &[u8] = b"\r\n\r\n";
    let at = memmem::find(text, BLANK)?;
    let head = str::from_utf8(&text[..at]).unwrap_or_default();
    let said = head.lines().find(|line| line.to_ascii_lowercase().starts_with("content-disposition:"))?;
    let quoted = |name: &str| said.split_once(name)?.1.split('"').next();
    let name = quoted("; name=\"")?;
    Some(Part { name, file: quoted("; filename=\"").unwrap_or_default(), content: &text[at + BLANK.len()..] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_taken_apart_byte_by_byte() {
        let body = b"--x-1\r\nContent-Disposition: form-data; name=\"map\"\r\n\r\na = 1\r\nb = 2\r\n\
            --x-1\r\nContent-Disposition: form-data; name=\"document\"; filename=\"ST-2 \xe5\x8f\xb0.csv\"\r\n\
            Content-Type: text/csv\r\n\r\n# imu\r\n--x\n\x00\xff\r\n\r\n\
            --x-1\r\nContent-Disposition: form-data; name=\"empty\"; filename=\"\"\r\n\r\n\r\n--x-1--\r\n";
        let field = |name, file, content| Part { name, file, content };
        let found = parts(body, boundary("multipart/form-data; boundary=\"x-1\"").unwrap());
        assert_eq!(
            found,
            [
                field("map", "", &b"a = 1\r\nb = 2"[..]),
                field("document", "ST-2 \u{53f0}.csv", &b"# imu\r\n--x\n\x00\xff\r\n"[..]),
                field("empty", "", &b""[..]),
            ]
        );
    }

    #[test]
    fn what_is_no_such_form_has_no_parts() {
        assert_eq!(boundary("text/plain; boundary=x"), None);
        assert_eq!(boundary("multipart/form-data"), None);
        for body in ["", "--x", "--x--", "text", "--x\r\nname\r\n--x--", "--x\r\n\r\n\r\na\r\n--x--"] {
            assert_eq!(parts(body.as_bytes(), "x"), [], "{body:?}");
        }
        // A body that was cut.
        assert_eq!(parts(b"--x\r\nContent-Disposition: form-data; name=\"text\"\r\n\r\n{}", "x"), []);
    }
}
