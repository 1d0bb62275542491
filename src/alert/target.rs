//! Where hooks may go. Decided for the address that is dialled, at every attempt: a name may resolve to anything.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

use ipnet::IpNet;
use url::{Host, ParseError, Url};

use crate::core::message::Message;
use crate::message;

/// Longest address of a target, in characters.
pub const MAX_URL_CHARS: usize = 2048;

/// Which addresses may be dialled.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TargetPolicy {
    /// Only these networks, where any are given. Naming loopback here allows it.
    pub allow: Vec<IpNet>,
    /// Whether loopback passes where no networks are given: when the service itself listens on loopback alone, the
    /// machine's own programs are its company; otherwise they would be exposed to whoever may set up a hook.
    pub loopback: bool,
}

impl TargetPolicy {
    /// Checks an address on its way to being dialled; the error names it and the reason.
    ///
    /// IPv6 forms that carry an IPv4 address are judged by the address that they carry.
    pub fn check(&self, address: IpAddr) -> Result<(), Message> {
        let refuse = |why: Message| Err(message!("address_refused", address = format_args!("{address}"), why));
        if let Some(why) = never(address) {
            return refuse(why);
        }
        if let IpAddr::V6(v6) = address
            && let Some(v4) = carried_v4(v6)
        {
            return self.check(v4.into());
        }
        if !self.allow.is_empty() {
            let allowed = self.allow.iter().any(|network| network.contains(&address));
            return if allowed { Ok(()) } else { refuse(message!("outside_networks")) };
        }
        if address.is_loopback() && !self.loopback {
            return refuse(message!("loopback_refused"));
        }
        Ok(())
    }

    /// Checks what can be seen of a target without asking the name service: its form, and the address if it is one.
    /// `url` parses IPv4 addresses in all their spellings (`0x7f.1`, `2130706433`), so that what is checked is dialled.
    pub fn check_url(&self, text: &str) -> Result<Url, Message> {
        if text.chars().count() > MAX_URL_CHARS {
            return Err(message!("url_too_long", most = MAX_URL_CHARS));
        }
        let url = Url::parse(text).map_err(|error| message!("not_a_url", why = fault_of_url(error)))?;
        if !matches!(url.scheme(), "http" | "https") {
            return Err(message!("url_scheme", scheme = format_args!("{}", url.scheme())));
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err(message!("url_credentials"));
        }
        if url.fragment().is_some() {
            return Err(message!("url_fragment"));
        }
        if url.port() == Some(0) {
            return Err(message!("url_port_0"));
        }
        self.check_host(&url)?;
        Ok(url)
    }

    /// Checks a name that a proxy will resolve: what it leads to there is not seen here.
    pub fn check_name(&self, url: &Url) -> Result<(), Message> {
        let Some(Host::Domain(name)) = url.host() else { return Ok(()) };
        let name = name.trim_end_matches('.');
        if NEVER_NAMED.contains(&name) || name.ends_with(".localhost") {
            let why = message!("leads_to_the_proxy");
            return Err(message!("address_refused", address = format_args!("{name}"), why));
        }
        Ok(())
    }

    /// An address is never asked of the name service, so it is checked here, at every attempt.
    pub fn check_host(&self, url: &Url) -> Result<(), Message> {
        match url.host() {
            Some(Host::Ipv4(v4)) => self.check(v4.into()),
            Some(Host::Ipv6(v6)) => self.check(v6.into()),
            Some(Host::Domain(_)) => Ok(()),
            None => Err(message!("url_no_host")),
        }
    }
}

/// What is wrong with a URL.
fn fault_of_url(error: ParseError) -> Message {
    match error {
        ParseError::RelativeUrlWithoutBase | ParseError::RelativeUrlWithCannotBeABaseBase => message!("url_no_scheme"),
        ParseError::EmptyHost => message!("url_no_host"),
        ParseError::InvalidPort => message!("url_port_range"),
        ParseError::InvalidIpv4Address | ParseError::InvalidIpv6Address => message!("url_ip_address"),
        _ => message!("url_host_name"),
    }
}

/// Names that lead to the machine that resolves them, or to its cloud's metadata.
const NEVER_NAMED: [&str; 5] =
    ["localhost", "metadata", "metadata.google.internal", "instance-data", "instance-data.ec2.internal"];

/// What no configuration allows.
fn never(address: IpAddr) -> Option<Message> {
    let link_local = || message!("link_local");
    match address {
        IpAddr::V4(v4) if v4.is_link_local() => Some(link_local()),
        IpAddr::V4(v4) if METADATA_V4.contains(&v4) => Some(message!("cloud_credentials")),
        IpAddr::V4(v4) if v4.octets()[0] == 0 => Some(message!("no_destination")),
        IpAddr::V4(v4) if v4.is_multicast() || v4.octets()[0] >= 240 => Some(message!("no_single_host")),
        IpAddr::V6(v6) if v6.is_unicast_link_local() => Some(link_local()),
        IpAddr::V6(v6) if METADATA_V6.contains(&v6) => Some(message!("cloud_credentials")),
        IpAddr::V6(v6) if v6.is_unspecified() => Some(message!("no_destination")),
        IpAddr::V6(v6) if v6.is_multicast() => Some(message!("no_single_host")),
        _ => None,
    }
}

/// Alibaba's and Oracle's metadata, Azure's wire server: outside 169.254.0.0/16.
const METADATA_V4: [Ipv4Addr; 3] =
    [Ipv4Addr::new(100, 100, 100, 200), Ipv4Addr::new(192, 0, 0, 192), Ipv4Addr::new(168, 63, 129, 16)];
/// Amazon's metadata over IPv6, and Google's.
const METADATA_V6: [Ipv6Addr; 2] =
    [Ipv6Addr::new(0xfd00, 0xec2, 0, 0, 0, 0, 0, 0x254), Ipv6Addr::new(0xfd20, 0xce, 0, 0, 0, 0, 0, 0x254)];

/// The IPv4 address inside an IPv4-mapped (RFC 4291, 2.5.5.2), IPv4-compatible (2.5.5.1), NAT64 (RFC 6052, RFC 8215),
/// 6to4 (RFC 3056) or Teredo (RFC 4380) address.
fn carried_v4(v6: Ipv6Addr) -> Option<Ipv4Addr> {
    let s = v6.segments();
    let pair = |high: u16, low: u16| Ipv4Addr::from((u32::from(high) << 16) | u32::from(low));
    match s {
        [0, 0, 0, 0, 0, 0xffff, high, low] => Some(pair(high, low)),
        [0, 0, 0, 0, 0, 0, 0, 0 | 1] => None,
        [0, 0, 0, 0, 0, 0, high, low] => Some(pair(high, low)),
        [0x64, 0xff9b, 0 | 1, _, _, _, high, low] => Some(pair(high, low)),
        [0x2002, high, low, ..] => Some(pair(high, low)),
        [0x2001, 0, _, _, _, _, high, low] => Some(pair(!high, !low)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn policy(loopback: bool, allow: &[&str]) -> TargetPolicy {
        TargetPolicy { allow: allow.iter().map(|network| network.parse().unwrap()).collect(), loopback }
    }

    #[test]
    fn public_and_private_addresses_pass() {
        for url in [
            "http://alerts.example.org/hook",
            "https://93.184.216.34/",
            "http://192.168.7.2:9093/",
            "http://10.0.0.1",
            "http://100.64.0.9/",
            "http://[fd12::7]/",
            "https://[2606:2800:220:1::1]:8443/x?y=z",
            "http://localhost:9093",
        ] {
            assert!(policy(false, &[]).check_url(url).is_ok(), "{url}");
        }
    }

    #[test]
    fn loopback_is_refused_in_every_spelling_unless_the_service_listens_there_too() {
        for host in [
            "127.0.0.1",
            "127.9.9.9",
            "0x7f.1",
            "0x7f000001",
            "2130706433",
            "017700000001",
            "127.1",
            "0177.0.0.1",
            "１２７.0.0.1",
            "[::1]",
            "[::ffff:127.0.0.1]",
            "[::ffff:7f00:1]",
            "[::127.0.0.1]",
            "[64:ff9b::127.0.0.1]",
            "[2002:7f00:1::]",
        ] {
            let url = format!("http://{host}:9/");
            let error = policy(false, &[]).check_url(&url).unwrap_err();
            assert!(error.to_string().contains("loopback_refused"), "{url}: {error}");
            assert!(policy(true, &[]).check_url(&url).is_ok(), "{url}");
        }
    }

    #[test]
    fn metadata_is_refused_whatever_is_configured() {
        for host in [
            "169.254.169.254",
            "2852039166",
            "0xa9fea9fe",
            "[fe80::1]",
            "[::ffff:169.254.169.254]",
            "[64:ff9b::a9fe:a9fe]",
            "[2001:0:1:2:3:4:5601:5601]",
            "100.100.100.200",
            "[fd00:ec2::254]",
            "0.0.0.0",
            "0",
            "[::]",
            "255.255.255.255",
            "224.0.0.1",
            "[ff02::1]",
        ] {
            let url = format!("http://{host}/latest/meta-data");
            assert!(policy(true, &["0.0.0.0/0", "::/0"]).check_url(&url).is_err(), "{url}");
        }
    }

    #[test]
    fn names_of_the_machine_itself_are_refused_to_a_proxy() {
        let check = |url: &str| TargetPolicy::default().check_name(&Url::parse(url).unwrap());
        for name in ["localhost", "LOCALHOST.", "a.localhost", "metadata.google.internal"] {
            assert!(check(&format!("http://{name}:9/")).unwrap_err().to_string().contains("leads_to_the_proxy"));
        }
        assert_eq!(check("https://alerts.example.org/localhost"), Ok(()));
    }

    #[test]
    fn configured_networks_are_the_only_ones() {
        let policy = policy(true, &["10.1.0.0/16", "127.0.0.1/32", "fd12::/16"]);
        for host in ["10.1.2.3", "127.0.0.1", "[fd12::9]", "[::ffff:10.1.0.1]"] {
            assert!(policy.check_url(&format!("http://{host}/")).is_ok(), "{host}");
        }
        for host in ["10.2.0.1", "127.0.0.2", "93.184.216.34", "[::1]", "[fd13::9]", "[::ffff:10.2.0.1]"] {
            let error = policy.check_url(&format!("http://{host}/")).unwrap_err();
            assert!(error.to_string().contains("why: outside_networks"), "{error}");
        }
    }

    #[test]
    fn what_is_no_target_says_why() {
        for (url, code) in [
            ("ftp://x.example/", "url_scheme"),
            ("file:///etc/passwd", "url_scheme"),
            ("alerts.example.org/hook", "not_a_url"),
            ("http://", "not_a_url"),
            ("http://u:p@x.example/", "url_credentials"),
            ("http://x.example/#a", "url_fragment"),
            ("http://x.example:0/", "url_port_0"),
            ("http://256.1.1.1/", "not_a_url"),
            ("http://x.example:99999/", "not_a_url"),
        ] {
            assert_eq!(policy(true, &[]).check_url(url).unwrap_err().code, code, "{url}");
        }
        for (url, why) in [
            ("alerts.example.org/hook", "url_no_scheme"),
            ("http://", "url_no_host"),
            ("http://[::1/", "url_ip_address"),
            ("http://256.1.1.1/", "url_ip_address"),
            ("http://x.example:99999/", "url_port_range"),
            ("http://a b/", "url_host_name"),
        ] {
            let said = policy(true, &[]).check_url(url).unwrap_err();
            assert_eq!(
                said,
                message!("not_a_url", why = Message { code: why.into(), parameters: Vec::new() }),
                "{url}"
            );
        }
        let long = format!("http://x.example/{}", "a".repeat(MAX_URL_CHARS));
        assert!(policy(true, &[]).check_url(&long).unwrap_err().to_string().contains("2048"));
    }
}
