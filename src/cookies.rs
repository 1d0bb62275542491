//! What browsers send back of the cookies that they were given.

use axum::http::HeaderMap;
use axum::http::header::COOKIE;

/// The value of the cookie of a name.
pub fn sent<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    let all = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
    let mut pairs = all.flat_map(|value| value.split(';')).filter_map(|pair| pair.trim().split_once('='));
    pairs.find(|(key, _)| *key == name).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cookie_is_found_among_others() {
        let mut headers = HeaderMap::new();
        headers.insert(COOKIE, "a=b; theme=dark;language=zh".parse().unwrap());
        headers.append(COOKIE, "gyrowatch_session=s".parse().unwrap());
        assert_eq!((sent(&headers, "theme"), sent(&headers, "language")), (Some("dark"), Some("zh")));
        assert_eq!((sent(&headers, "gyrowatch_session"), sent(&headers, "other")), (Some("s"), None));
    }
}
