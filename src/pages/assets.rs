//! Style sheet and script. Their names carry a hash of their content, so that a browser may keep them for ever and a
//! new version is another name.

use std::sync::LazyLock;

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};

use super::prelude::*;

/// Something that pages load.
pub(super) struct Asset {
    /// Path on this service.
    pub path: String,
    media_type: &'static str,
    pub(super) content: &'static str,
}

pub(super) static STYLE: LazyLock<Asset> =
    LazyLock::new(|| Asset::new("style", "css", "text/css; charset=utf-8", include_str!("static/style.css")));
pub(super) static SCRIPT: LazyLock<Asset> =
    LazyLock::new(|| Asset::new("pages", "js", "text/javascript; charset=utf-8", include_str!("static/pages.js")));
impl Asset {
    fn new(stem: &str, ending: &str, media_type: &'static str, content: &'static str) -> Self {
        let path = format!("/assets/{stem}-{:08x}.{ending}", crc32fast::hash(content.as_bytes()));
        Self { path, media_type, content }
    }
}

pub(super) async fn serve(Path(name): Path<String>) -> Response {
    let all: [&'static Asset; 2] = [&STYLE, &SCRIPT];
    let Some(asset) = all.into_iter().find(|asset| asset.path.strip_prefix("/assets/") == Some(&name)) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let head = [(CONTENT_TYPE, asset.media_type), (CACHE_CONTROL, "public, max-age=31536000, immutable")];
    (head, asset.content).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Addresses that a string of a script begins with: what it could load. Names of XML's spaces are loaded by
    /// nobody, and in a comment an address stands in no quotes.
    fn addresses(script: &str) -> Vec<&str> {
        let is_address = |part: &&str| {
            let host = ["http://", "https://", "//"].iter().find_map(|scheme| part.strip_prefix(scheme));
            host.is_some_and(|host| host.starts_with(char::is_alphanumeric) && !host.starts_with("www.w3.org/"))
        };
        script.split(['"', '\'', '`']).filter(is_address).collect()
    }

    #[test]
    fn style_and_script_load_nothing_from_elsewhere() {
        for asset in [&STYLE, &SCRIPT] {
            assert!(addresses(asset.content).is_empty() && !asset.content.contains("url("), "{}", asset.path);
        }
        let loading = r#"/* http://a.example */ a.src="https://b.example/c.js"; d.href='//e.example'; f("http://www.w3.org/2000/svg")"#;
        assert_eq!(addresses(loading), ["https://b.example/c.js", "//e.example"]);
    }

    #[test]
    fn another_content_has_another_name() {
        let path = |content| Asset::new("style", "css", "text/css", content).path;
        assert_ne!(path("a{}"), path("b{}"));
        assert_eq!(path("a{}"), path("a{}"));
    }
}
