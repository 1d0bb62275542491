//! Whether a Chinese page says what is wrong with a document in Chinese.

use crate::support::Server;

/// Words that a document, its units or the mathematics have in every language: names of members and columns, their
/// values.
const OF_EVERY_LANGUAGE: [&str; 33] = [
    "inf",
    "station",
    "geometry",
    "test",
    "operator",
    "note",
    "model",
    "site",
    "gyros",
    "phase",
    "slot",
    "serial",
    "true",
    "false",
    "null",
    "static",
    "rate",
    "rates",
    "inertial",
    "table",
    "bias",
    "scale",
    "imu",
    "skewed",
    "orthogonal",
    "pulse",
    "arcsec",
    "deg",
    "nav",
    "rfc",
    "utf",
    "csv",
    "json",
];

/// What the import page finds wrong with a document and does not say in Chinese. Panics where it finds nothing wrong.
pub async fn english_left(server: &Server, document: &str) -> Vec<String> {
    if matches!(document.trim(), "" | "[]") {
        return Vec::new(); // There is no document in it.
    }
    let headers = [("content-type", "text/plain"), ("accept-language", "zh"), ("sec-fetch-site", "same-origin")];
    let page = server.call("POST", "/import/preview", &headers, format!("text={document}\r\n")).await.text();
    let (_, preview) = page.split_once("class=\"preview\"").unwrap_or_else(|| panic!("no preview: {page}"));
    let faults: Vec<String> = preview
        .split("<article class=\"fault\">")
        .skip(1)
        .flat_map(|article| article.split("</article>").next().unwrap().split("<li>").skip(1))
        .map(|item| said(item.split("</li>").next().unwrap()))
        .collect();
    assert!(!faults.is_empty(), "nothing is wrong with {document:.200}");
    faults.into_iter().filter(|fault| !english_words(fault).is_empty()).collect()
}

/// A fault as it is read, without the pointer before it.
fn said(item: &str) -> String {
    let text = item.rsplit("</code>").next().unwrap();
    unescaped(text)
}

/// Text of a page as a browser shows it.
pub fn unescaped(text: &str) -> String {
    text.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
}

/// Small words that are no name: neither quoted, nor with a digit or an underscore in them.
fn english_words(text: &str) -> Vec<String> {
    let mut bare = String::new();
    let mut quote = None;
    for c in text.chars() {
        match (quote, c) {
            (Some(end), c) if c == end => quote = None,
            (Some(_), _) => {}
            (None, '"' | '`') => quote = Some(c),
            (None, '“') => quote = Some('”'),
            (None, c) => bare.push(c),
        }
    }
    let words = bare.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '/'));
    let small = words.filter(|word| word.len() > 2 && word.bytes().all(|b| b.is_ascii_lowercase()));
    small.filter(|word| !OF_EVERY_LANGUAGE.contains(word)).map(str::to_owned).collect()
}
