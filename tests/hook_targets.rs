//! What targets of hooks may do to the service: nothing, and every one of their faults has a name.
//!
//! Each test makes one attempt against a real socket on this machine; the allow-list lets that one address pass.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::prelude::*;
use crate::support::{asked, seed};
use gyrowatch::alert::deliver::{Attempt, AttemptLimits, Courier, DeliveryOutcome, Destination};
use gyrowatch::alert::payload::Payload;
use gyrowatch::alert::resolver::GuardedResolver;
use gyrowatch::alert::sign::{self, Secret};
use gyrowatch::alert::target::TargetPolicy;
use gyrowatch::alert::{HookKind, HookMessage};
use gyrowatch::core::time::UtcMicros;
use gyrowatch::system::Proxies;
use gyrowatch::words::Language;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

const LIMITS: AttemptLimits = AttemptLimits {
    connect: Duration::from_millis(500),
    whole: Duration::from_millis(1500),
    body: Duration::from_millis(300),
    body_bytes: 4096,
};
const NOW: UtcMicros = UtcMicros(1_772_355_600_000_000);

fn local() -> TargetPolicy {
    TargetPolicy { allow: vec!["127.0.0.1/32".parse().unwrap()], loopback: false }
}

fn courier(policy: TargetPolicy) -> Courier {
    gyrowatch::system::install_crypto();
    Courier::through(&Proxies::None, policy, LIMITS, None).unwrap()
}

async fn attempt_with(courier: &Courier, url: &str) -> Attempt {
    let payload = Payload { content_type: "application/json", body: b"{}".to_vec() };
    let to = Destination { kind: HookKind::StandardWebhooks, url, authorization: Some("Bearer hunter2"), expect: None };
    courier.attempt(to, &sign::headers("evt_1", NOW, b"{}", &[]), payload, NOW).await
}

async fn attempt(url: &str) -> Attempt {
    attempt_with(&courier(local()), url).await
}

/// A target that answers every connection with `talk`; its address, and how often it was connected to.
async fn target<F>(talk: impl Fn(TcpStream) -> F + Send + 'static) -> (SocketAddr, Arc<AtomicUsize>)
where
    F: Future<Output = io::Result<()>> + Send + 'static,
{
    target_at(Ipv4Addr::LOCALHOST.into(), talk).await
}

async fn target_at<F>(ip: IpAddr, talk: impl Fn(TcpStream) -> F + Send + 'static) -> (SocketAddr, Arc<AtomicUsize>)
where
    F: Future<Output = io::Result<()>> + Send + 'static,
{
    let listener = TcpListener::bind((ip, 0)).await.unwrap();
    let address = listener.local_addr().unwrap();
    let connections = Arc::new(AtomicUsize::new(0));
    let counted = connections.clone();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            counted.fetch_add(1, Ordering::SeqCst);
            tokio::spawn(talk(stream));
        }
    });
    (address, connections)
}

/// A target that reads the request and then says `answer`.
async fn says(answer: &'static [u8]) -> String {
    let (address, _) = target(move |mut stream| async move {
        read_request(&mut stream).await?;
        stream.write_all(answer).await
    })
    .await;
    format!("http://{address}/hook?token=hunter2")
}

async fn read_request(stream: &mut TcpStream) -> io::Result<String> {
    let mut request = Vec::new();
    while !request.ends_with(b"\r\n\r\n{}") {
        let mut buffer = [0; 1024];
        match stream.read(&mut buffer).await? {
            0 => break,
            n => request.extend_from_slice(&buffer[..n]),
        }
    }
    Ok(String::from_utf8_lossy(&request).into_owned())
}

/// What went wrong, in words.
fn said(attempt: &Attempt) -> String {
    attempt.detail.as_ref().map(|why| Language::English.words(why)).unwrap_or_default()
}

/// The attempt failed, soon, and its words hold `detail` and no secret.
#[track_caller]
fn failed(attempt: &Attempt, status: Option<u16>, detail: &str) {
    assert!(matches!(attempt.outcome, DeliveryOutcome::Failed { .. }), "{attempt:?}");
    assert_eq!(attempt.status, status, "{attempt:?}");
    let said = said(attempt);
    assert!(said.contains(detail) && !said.contains("hunter2"), "{said}: {attempt:?}");
    assert!(attempt.took < Duration::from_secs(3), "{attempt:?}");
}

#[tokio::test]
async fn a_target_that_takes_the_message_is_done_with() {
    let got = attempt(&says(b"HTTP/1.1 204 No Content\r\n\r\n").await).await;
    assert_eq!((got.outcome, got.status, said(&got).as_str()), (DeliveryOutcome::Delivered, Some(204), ""));
}

#[tokio::test]
async fn the_request_carries_id_time_authorization_and_body() {
    let (seen, mut requests) = tokio::sync::mpsc::unbounded_channel();
    let (address, _) = target(move |mut stream| {
        let seen = seen.clone();
        async move {
            _ = seen.send(read_request(&mut stream).await?);
            stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").await
        }
    })
    .await;
    assert_eq!(attempt(&format!("http://{address}/hook?x=1")).await.outcome, DeliveryOutcome::Delivered);
    let request = requests.recv().await.unwrap();
    assert!(request.starts_with("POST /hook?x=1 HTTP/1.1\r\n"), "{request}");
    for line in [
        "webhook-id: evt_1",
        "webhook-timestamp: 1772355600",
        "content-type: application/json",
        "authorization: Bearer hunter2",
        "content-length: 2",
    ] {
        assert!(request.contains(&format!("{line}\r\n")), "{line} in {request}");
    }
}

#[tokio::test]
async fn an_error_is_told_with_what_the_target_said_about_it() {
    let answer = b"HTTP/1.1 500 Oops\r\ncontent-length: 22\r\n\r\nno such\r\n\x1b[31m channel\xff";
    failed(&attempt(&says(answer).await).await, Some(500), "answered 500 Internal Server Error: no such [31m channel");
}

#[tokio::test]
async fn a_busy_target_says_when_to_come_again() {
    let got = attempt(&says(b"HTTP/1.1 503 Busy\r\nretry-after: 77\r\ncontent-length: 0\r\n\r\n").await).await;
    assert_eq!(got.outcome, DeliveryOutcome::Failed { retry_after: Some(Duration::from_secs(77)) });
}

#[tokio::test]
async fn a_target_that_is_gone_says_so() {
    let got = attempt(&says(b"HTTP/1.1 410 Gone\r\ncontent-length: 0\r\n\r\n").await).await;
    assert_eq!((got.outcome, got.status), (DeliveryOutcome::Gone, Some(410)));
}

#[tokio::test]
async fn a_redirect_is_not_followed() {
    let (elsewhere, connections) = target(|_| async { Ok(()) }).await;
    let (address, _) = target(move |mut stream| async move {
        read_request(&mut stream).await?;
        let answer = format!("HTTP/1.1 302 Found\r\nlocation: http://{elsewhere}/\r\ncontent-length: 0\r\n\r\n");
        stream.write_all(answer.as_bytes()).await
    })
    .await;
    failed(&attempt(&format!("http://{address}/")).await, Some(302), "redirects are not followed");
    assert_eq!(connections.load(Ordering::SeqCst), 0);
}

#[tokio::test]
async fn garbage_is_no_answer() {
    failed(&attempt(&says(b"\x00\x01SSH-2.0-OpenSSH\r\n\r\n").await).await, None, "no HTTP answer");
}

#[tokio::test]
async fn a_target_that_hangs_up_has_not_answered() {
    failed(&attempt(&says(b"").await).await, None, "no HTTP answer");
}

#[tokio::test]
async fn a_port_where_nobody_listens_refuses_the_connection() {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    failed(&attempt(&format!("http://{address}/")).await, None, "no connection: ");
}

#[tokio::test]
async fn a_target_that_hangs_is_given_up() {
    let (address, _) = target(|stream| async move {
        tokio::time::sleep(Duration::from_secs(60)).await;
        drop(stream);
        Ok(())
    })
    .await;
    failed(&attempt(&format!("http://{address}/")).await, None, "no answer within 1.5 s");
}

#[tokio::test]
async fn a_slow_drip_of_headers_is_given_up() {
    let (address, _) = target(|mut stream| async move {
        read_request(&mut stream).await?;
        stream.write_all(b"HTTP/1.1 200 OK\r\n").await?;
        loop {
            stream.write_all(b"x-drip: drop\r\n").await?;
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    })
    .await;
    failed(&attempt(&format!("http://{address}/")).await, None, "no answer within 1.5 s");
}

#[tokio::test]
async fn headers_without_end_are_given_up() {
    let (address, _) = target(|mut stream| async move {
        read_request(&mut stream).await?;
        stream.write_all(b"HTTP/1.1 200 OK\r\nx-flood: ").await?;
        loop {
            stream.write_all(&[b'a'; 65_536]).await?;
        }
    })
    .await;
    failed(&attempt(&format!("http://{address}/")).await, None, "no HTTP answer");
}

#[tokio::test]
async fn ten_megabytes_of_answer_are_not_read() {
    let sent = Arc::new(AtomicUsize::new(0));
    let counted = sent.clone();
    let (address, _) = target(move |mut stream| {
        let sent = counted.clone();
        async move {
            read_request(&mut stream).await?;
            stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 104857600\r\n\r\n").await?;
            for _ in 0..1600 {
                stream.write_all(&[b'a'; 65_536]).await?;
                sent.fetch_add(65_536, Ordering::SeqCst);
            }
            Ok(())
        }
    })
    .await;
    let got = attempt(&format!("http://{address}/")).await;
    assert_eq!(got.outcome, DeliveryOutcome::Delivered);
    assert_eq!(said(&got), "the answer was cut off after 4096 bytes");
    tokio::time::sleep(Duration::from_millis(200)).await;
    let sent = sent.load(Ordering::SeqCst);
    assert!(sent < 16 << 20, "{sent} bytes of 100 MB went through before the connection was closed");
}

#[tokio::test]
async fn a_slow_drip_of_body_is_cut_off() {
    let (address, _) = target(|mut stream| async move {
        read_request(&mut stream).await?;
        stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 100000\r\n\r\n").await?;
        loop {
            stream.write_all(b"a").await?;
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    let got = attempt(&format!("http://{address}/")).await;
    assert_eq!((got.outcome, said(&got).as_str()), (DeliveryOutcome::Delivered, "the answer did not end within 0.3 s"));
    assert!(got.took < Duration::from_secs(1), "{got:?}");
}

#[tokio::test]
async fn tls_that_fails_is_named() {
    let (address, _) = target(|mut stream| async move {
        stream.write_all(b"HTTP/1.1 400 Bad Request\r\ncontent-length: 0\r\n\r\n").await?;
        stream.shutdown().await
    })
    .await;
    failed(&attempt(&format!("https://{address}/")).await, None, "TLS failed: ");
}

/// Every spelling of an address that listens, none of which may reach it.
#[tokio::test]
async fn a_forbidden_address_is_never_connected_to_however_it_is_spelt() {
    let (address, connections) = target(|_| async { Ok(()) }).await;
    let port = address.port();
    let courier = courier(TargetPolicy::default());
    for host in [
        "127.0.0.1",
        "0x7f.1",
        "2130706433",
        "0177.1",
        "[::1]",
        "[::ffff:127.0.0.1]",
        "[64:ff9b::7f00:1]",
        "localhost",
        "LOCALHOST",
        "0",
        "0.0.0.0",
        "[::]",
    ] {
        failed(&attempt_with(&courier, &format!("http://{host}:{port}/")).await, None, "refused: ");
    }
    assert_eq!(connections.load(Ordering::SeqCst), 0);
}

/// A number of an address as it may be written: decimal, octal or hexadecimal, with zeros before it.
fn number(value: u32, chance: &mut ChaCha8Rng) -> String {
    let zeros = "0".repeat(chance.random_range(0..4));
    match chance.random_range(0..4) {
        0 => format!("0x{zeros}{value:x}"),
        1 => format!("0X{value:X}"),
        2 => format!("0{zeros}{value:o}"),
        _ => value.to_string(),
    }
}

/// One to four numbers, the last of which takes what is left of the address.
fn spelt_v4(address: Ipv4Addr, chance: &mut ChaCha8Rng) -> String {
    let before = chance.random_range(0..4);
    let mut words: Vec<String> =
        address.octets()[..before].iter().map(|octet| number(u32::from(*octet), chance)).collect();
    words.push(number(u32::from(address) & (u32::MAX >> (8 * before)), chance));
    words.join(".") + if chance.random_bool(0.2) { "." } else { "" }
}

/// An IPv6 address that carries it: mapped, compatible, NAT64 of both kinds, 6to4 or Teredo; short, or every digit
/// written.
fn spelt_v6(address: Ipv4Addr, chance: &mut ChaCha8Rng) -> String {
    let [a, b, c, d] = address.octets();
    let (high, low) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
    let segments = *[
        [0, 0, 0, 0, 0, 0xffff, high, low],
        [0, 0, 0, 0, 0, 0, high, low],
        [0x64, 0xff9b, 0, 0, 0, 0, high, low],
        [0x64, 0xff9b, 1, 0, 0, 0, high, low],
        [0x2002, high, low, 0, 0, 0, 0, 1],
        [0x2001, 0, 1, 2, 3, 4, !high, !low],
    ]
    .choose(chance)
    .unwrap();
    let digits = segments.map(|segment| format!("{segment:04X}"));
    match chance.random_range(0..3) {
        0 => format!("[{}]", digits.join(":")),
        1 if segments[7] == low => format!("[{}:{address}]", digits[..6].join(":")),
        _ => format!("[{}]", Ipv6Addr::from(segments)),
    }
}

/// Characters that mean the same in the name of a host: wide ones, escaped ones, other full stops, and such as are
/// left out.
fn disguised(host: &str, chance: &mut ChaCha8Rng) -> String {
    let disguise = |c: char| match (chance.random_range(0..12), c) {
        (0, '.') => (*["\u{3002}", "\u{ff0e}", "\u{ff61}", "%2E"].choose(chance).unwrap()).to_owned(),
        (0, c) => char::from_u32(u32::from(c) + 0xfee0).map_or_else(|| c.to_string(), String::from),
        (1, c) => format!("%{:02x}", u32::from(c)),
        (2, c) => format!("{c}{}", ["\u{ad}", "\u{200b}", "\t", "\n"].choose(chance).unwrap()),
        (3, c) => c.to_ascii_uppercase().to_string(),
        (_, c) => c.to_string(),
    };
    host.chars().map(disguise).collect()
}

/// A host that leads to this machine, or to where credentials are kept.
fn forbidden_host(chance: &mut ChaCha8Rng) -> String {
    let address = match chance.random_range(0..8) {
        0 => Ipv4Addr::from(0x7f00_0000 | chance.random_range(0..0x0100_0000)),
        1 => Ipv4Addr::UNSPECIFIED,
        2 => Ipv4Addr::new(169, 254, 169, 254),
        _ => Ipv4Addr::LOCALHOST,
    };
    match chance.random_range(0..8) {
        0 | 1 => spelt_v6(address, chance),
        2 => (*["[::1]", "[::]", "[0:0::0:1]", "[0000:0000:0000:0000:0000:0000:0000:0001]"].choose(chance).unwrap())
            .to_owned(),
        3 => disguised("localhost", chance) + if chance.random() { "." } else { "" },
        4 | 5 => disguised(&spelt_v4(address, chance), chance),
        _ => spelt_v4(address, chance),
    }
}

/// Such a host in a URL, at `port`.
fn spelt_url(port: u16, chance: &mut ChaCha8Rng) -> String {
    let host = forbidden_host(chance);
    let scheme = ["http://", "HTTP://", "http:/", "http:", "http:///", "http:\\\\", " \thttp://", "ht\ntp://"]
        .choose(chance)
        .unwrap();
    let who = ["", "", "", "", "", "x@", "x:y@", "alerts.example.org@", "%00@"].choose(chance).unwrap();
    let zeros = "0".repeat(chance.random_range(0..3));
    let path = ["", "/", "?x", "/a/../b", "\\x"].choose(chance).unwrap();
    format!("{scheme}{who}{host}:{zeros}{port}{path}")
}

/// `scripts/soak spellings`. That many of them do lead to this machine is seen where the policy lets them.
#[tokio::test]
async fn a_forbidden_address_is_never_connected_to_however_chance_spells_it() {
    let rounds = asked("GYROWATCH_SOAK_ROUNDS", 400);
    let anywhere = || target_at(Ipv6Addr::UNSPECIFIED.into(), |_| async { Ok(()) });
    let ((closed, unwanted), (open, reached)) = (anywhere().await, anywhere().await);
    let (guarded, lax) =
        (courier(TargetPolicy::default()), courier(TargetPolicy { loopback: true, ..TargetPolicy::default() }));
    for round in 0..rounds {
        let url = spelt_url(closed.port(), &mut ChaCha8Rng::seed_from_u64(seed(round)));
        let got = attempt_with(&guarded, &url).await;
        let what = format!("seed {}: {url:?}: {got:?}", seed(round));
        assert!(matches!(got.outcome, DeliveryOutcome::Failed { .. }) && !said(&got).contains("hunter2"), "{what}");
        // By the policy, or because it is no URL and no name; never because dialling it came to nothing.
        let refused = ["address_refused", "not_a_url", "url_credentials", "name_unknown"]
            .iter()
            .any(|code| got.detail.as_ref().is_some_and(|why| why.to_string().contains(code)));
        assert!(refused, "{what}");
        assert_eq!(unwanted.load(Ordering::SeqCst), 0, "{what}");
        attempt_with(&lax, &spelt_url(open.port(), &mut ChaCha8Rng::seed_from_u64(seed(round)))).await;
    }
    assert_eq!(unwanted.load(Ordering::SeqCst), 0);
    let reached = reached.load(Ordering::SeqCst);
    println!(
        "spellings: {rounds}, of which {reached} lead to this machine where that is allowed; 0 connections where it is not"
    );
    assert!(reached > rounds / 10, "{reached} of {rounds}");
}

#[tokio::test]
async fn a_name_that_changes_its_mind_after_registration_is_checked_when_it_is_dialled() {
    gyrowatch::system::install_crypto();
    let (address, connections) = target(|_| async { Ok(()) }).await;
    let metadata = IpAddr::from([169, 254, 169, 254]);
    for answers in [vec![address.ip()], vec![metadata], vec![address.ip(), metadata]] {
        let resolver = GuardedResolver::with_lookup(TargetPolicy::default(), move |_| {
            let answers = answers.clone();
            Box::pin(async move { Ok(answers) })
        });
        let courier = Courier::with_resolver(&Proxies::None, resolver, TargetPolicy::default(), LIMITS, None).unwrap();
        let url = format!("http://rebinding.example:{}/", address.port());
        failed(&attempt_with(&courier, &url).await, None, "rebinding.example resolves to a forbidden address: ");
    }
    assert_eq!(connections.load(Ordering::SeqCst), 0);
}

#[tokio::test]
async fn a_name_with_a_forbidden_and_an_allowed_address_uses_the_allowed_one() {
    gyrowatch::system::install_crypto();
    let url = says(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").await.replace("127.0.0.1", "both.example");
    let resolver = GuardedResolver::with_lookup(local(), |_| {
        Box::pin(async { Ok(vec![[169, 254, 169, 254].into(), [127, 0, 0, 1].into()]) })
    });
    let courier = Courier::with_resolver(&Proxies::None, resolver, local(), LIMITS, None).unwrap();
    assert_eq!(attempt_with(&courier, &url).await.outcome, DeliveryOutcome::Delivered);
}

#[tokio::test]
async fn a_name_that_does_not_exist_is_named() {
    gyrowatch::system::install_crypto();
    let resolver = GuardedResolver::with_lookup(local(), |_| {
        Box::pin(async { Err(io::Error::new(io::ErrorKind::NotFound, "no such name")) })
    });
    let courier = Courier::with_resolver(&Proxies::None, resolver, local(), LIMITS, None).unwrap();
    let got = attempt_with(&courier, "http://nowhere.example/").await;
    failed(&got, None, "nowhere.example does not resolve: no such name");
}

/// The reference implementation of Standard Webhooks verifies what is signed here, also while a secret is replaced.
#[test]
fn the_reference_verifier_accepts_signatures_by_either_active_secret() {
    let (old, new, other) = (Secret::generate().unwrap(), Secret::generate().unwrap(), Secret::generate().unwrap());
    // The verifier compares with the machine's clock.
    let now = gyrowatch::system::Clock::System.now();
    let message = HookMessage { id: "evt_1".into(), at: now, event: gyrowatch::alert::HookEvent::Test };
    let context = gyrowatch::alert::payload::Context { hook: "h", external_url: None, resend_every: 1, now };
    let body = gyrowatch::alert::payload::render(HookKind::StandardWebhooks, &message, &context).body;
    let mut headers = axum::http::HeaderMap::new();
    for (name, value) in sign::headers(&message.id, now, &body, &[new.clone(), old.clone()]) {
        headers.insert(name, value.parse().unwrap());
    }
    let verifies = |secret: &Secret, body: &[u8]| {
        standardwebhooks::Webhook::new(&secret.reveal()).unwrap().verify(body, &headers).is_ok()
    };
    assert!(verifies(&old, &body) && verifies(&new, &body));
    assert!(!verifies(&other, &body));
    assert!(!verifies(&new, b"{\"type\":\"alert.resolved\"}"));
}
