//! On which way a request came: the client's address, scheme and host by the word of proxies that are trusted, and of
//! no others.

use std::net::{IpAddr, SocketAddr};

use axum::http::header::{FORWARDED, HOST, VIA};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use ipnet::IpNet;

use crate::http::prefer_header::outside_quotes;

/// What is known of the way that a request came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ForwardedRequest {
    pub client: IpAddr,
    /// None: nobody who is trusted says, so the connection itself does.
    pub https: Option<bool>,
    pub host: Option<HeaderValue>,
    /// It has a header that only proxies add, trusted or not.
    pub is_forwarded: bool,
}

/// What one proxy says of the request that it took.
#[derive(Debug, Clone, Default)]
struct Hop {
    client: Option<IpAddr>,
    proto: Option<String>,
    host: Option<String>,
}

impl ForwardedRequest {
    pub fn of(headers: &HeaderMap, peer: IpAddr, trusted: &[IpNet]) -> Self {
        let is_forwarded = headers.keys().any(only_proxies_add);
        let peer = peer.to_canonical();
        let direct = Self { client: peer, https: None, host: None, is_forwarded };
        let is_trusted = |address: &IpAddr| trusted.iter().any(|network| network.contains(address));
        if !is_forwarded || !is_trusted(&peer) {
            return direct;
        }
        let hops = hops(headers);
        let mut client = peer;
        let mut said = None;
        for hop in hops.iter().rev() {
            said = Some(hop);
            // What cannot be read, an address that a proxy hides say, ends what can be known.
            let Some(address) = hop.client else { break };
            client = address;
            if !is_trusted(&address) {
                break;
            }
        }
        let https = said.and_then(|hop| hop.proto.as_ref()).map(|proto| proto.eq_ignore_ascii_case("https"));
        let host = said.and_then(|hop| HeaderValue::from_str(hop.host.as_ref()?).ok());
        Self { client, https, host, ..direct }
    }
}

fn only_proxies_add(name: &HeaderName) -> bool {
    *name == FORWARDED || *name == VIA || name.as_str().starts_with("x-forwarded-") || name.as_str() == "x-real-ip"
}

/// Every hop, that of the nearest proxy last. Where there are headers of both kinds, `X-Forwarded-…` are believed:
/// proxies that write these pass on what a client sends as `Forwarded`.
fn hops(headers: &HeaderMap) -> Vec<Hop> {
    let all = |name: &str| -> Vec<String> {
        let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
        let items = values.flat_map(|value| outside_quotes(value, ',')).map(str::trim);
        items.filter(|item| !item.is_empty()).map(str::to_owned).collect()
    };
    let mut clients = all("x-forwarded-for");
    // Proxies put one value here, or add to the end: the nearest one's word counts.
    let (proto, host) = (all("x-forwarded-proto").pop(), all("x-forwarded-host").pop());
    if !clients.is_empty() || proto.is_some() || host.is_some() {
        if clients.is_empty() {
            clients.push(String::new());
        }
        let hop = |text: String| Hop { client: address(&text), proto: proto.clone(), host: host.clone() };
        return clients.into_iter().map(hop).collect();
    }
    all(FORWARDED.as_str()).iter().map(|element| forwarded(element)).collect()
}

/// An element of `Forwarded` (RFC 7239).
fn forwarded(element: &str) -> Hop {
    let mut hop = Hop::default();
    for pair in outside_quotes(element, ';') {
        let Some((name, value)) = pair.split_once('=') else { continue };
        let value = value.trim().trim_matches('"').to_owned();
        match name.trim().to_ascii_lowercase().as_str() {
            "for" => hop.client = address(&value),
            "proto" => hop.proto = Some(value),
            name if name == HOST.as_str() => hop.host = Some(value),
            _ => {}
        }
    }
    hop
}

/// An address as proxies write it: with or without a port, that of IPv6 in brackets or bare.
fn address(text: &str) -> Option<IpAddr> {
    let bare = text.trim().trim_start_matches('[').trim_end_matches(']');
    let address = bare.parse().ok().or_else(|| Some(text.trim().parse::<SocketAddr>().ok()?.ip()));
    address.map(|address| address.to_canonical())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(peer: &str, sent: &[(&'static str, &str)]) -> ForwardedRequest {
        let headers = sent.iter().map(|(name, value)| (name.parse().unwrap(), value.parse().unwrap())).collect();
        let trusted = ["127.0.0.0/8", "10.0.0.0/8", "fd00::/8"].map(|network| network.parse().unwrap());
        ForwardedRequest::of(&headers, peer.parse().unwrap(), &trusted)
    }

    #[test]
    fn the_client_is_the_last_address_that_no_trusted_proxy_has() {
        let client = |sent: &str| way("127.0.0.1", &[("x-forwarded-for", sent)]).client.to_string();
        for (sent, expected) in [
            ("192.0.2.7", "192.0.2.7"),
            ("198.51.100.1, 192.0.2.7", "192.0.2.7"),
            ("198.51.100.1, 192.0.2.7, 10.1.2.3", "192.0.2.7"),
            ("10.9.9.9, 10.1.2.3", "10.9.9.9"),
            ("192.0.2.7:4711", "192.0.2.7"),
            ("[2001:db8::1]:4711", "2001:db8::1"),
            ("2001:db8::1", "2001:db8::1"),
            ("::ffff:192.0.2.7", "192.0.2.7"),
            ("192.0.2.7, unknown", "127.0.0.1"),
            ("192.0.2.7, nonsense, 10.1.2.3", "10.1.2.3"),
            ("", "127.0.0.1"),
        ] {
            assert_eq!(client(sent), expected, "{sent}");
        }
        let mut headers = HeaderMap::new();
        for address in ["192.0.2.7", "192.0.2.8"] {
            headers.append("x-forwarded-for", address.parse().unwrap());
        }
        let found = ForwardedRequest::of(&headers, "127.0.0.1".parse().unwrap(), &["127.0.0.1/32".parse().unwrap()]);
        assert_eq!(found.client.to_string(), "192.0.2.8", "of two headers the last");
    }

    #[test]
    fn nobody_else_is_believed() {
        let sent =
            [("x-forwarded-for", "192.0.2.7"), ("x-forwarded-proto", "https"), ("x-forwarded-host", "g.example")];
        let foreign = way("203.0.113.9", &sent);
        assert_eq!((foreign.client.to_string().as_str(), foreign.https, &foreign.host), ("203.0.113.9", None, &None));
        assert!(foreign.is_forwarded);
        let own = way("::ffff:10.0.0.1", &sent);
        assert_eq!((own.client.to_string().as_str(), own.https), ("192.0.2.7", Some(true)));
        assert_eq!(own.host.unwrap(), "g.example");
    }

    #[test]
    fn forwarded_is_read_as_its_standard_says() {
        let sent = "for=198.51.100.1;proto=http, for=\"[2001:db8::7]:1\";Proto=HTTPS;host=\"g.example:8443\", for=10.0.0.5;proto=http";
        let found = way("127.0.0.1", &[("forwarded", sent)]);
        assert_eq!((found.client.to_string().as_str(), found.https), ("2001:db8::7", Some(true)));
        assert_eq!(found.host.unwrap(), "g.example:8443");
        let hidden = way("127.0.0.1", &[("forwarded", "for=_hidden;proto=https")]);
        assert_eq!((hidden.client.to_string().as_str(), hidden.https), ("127.0.0.1", Some(true)));
        let both = way("127.0.0.1", &[("forwarded", "for=198.51.100.1;proto=https"), ("x-forwarded-for", "192.0.2.7")]);
        assert_eq!((both.client.to_string().as_str(), both.https), ("192.0.2.7", None), "what a client sends along");
    }

    #[test]
    fn headers_of_proxies_are_seen_and_others_are_not() {
        for name in ["forwarded", "via", "x-real-ip", "x-forwarded-for", "x-forwarded-port"] {
            assert!(way("203.0.113.9", &[(name, "1")]).is_forwarded, "{name}");
        }
        assert!(!way("127.0.0.1", &[("host", "localhost"), ("x-request-id", "1")]).is_forwarded);
    }
}
