//! One attempt to tell one target. It ends within seconds whatever the target does, reads a few kilobytes at most,
//! and says how it went: what is decided from that is the caller's.

use std::error::Error;
use std::time::{Duration, Instant};

use reqwest::header::{AUTHORIZATION, CONTENT_TYPE, HeaderMap, HeaderValue, LOCATION, RETRY_AFTER};
use reqwest::{Certificate, Client, Response, StatusCode};
use url::Url;

use super::mail::{Mailer, SendFailure, recipients};
use super::message::HookKind;
use super::payload::Payload;
use super::resolver::{GuardedResolver, ResolveError};
use super::target::TargetPolicy;
use crate::core::message::{Message, Parameter, text};
use crate::core::time::UtcMicros;
use crate::message;
use crate::system::{self, Proxies};
use crate::wire::cause;
use crate::wire::hook::ExpectBody;

/// How long a target may take, and how much of its answer is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AttemptLimits {
    pub connect: Duration,
    /// From the name's resolution to the end of what is read of the answer.
    pub whole: Duration,
    /// For the answer's body, once its status is there: the status alone decides.
    pub body: Duration,
    pub body_bytes: usize,
}

impl Default for AttemptLimits {
    fn default() -> Self {
        Self {
            connect: Duration::from_secs(5),
            whole: Duration::from_secs(15),
            body: Duration::from_secs(2),
            body_bytes: 4096,
        }
    }
}

/// Where to, and with which headers beside the payload's own.
#[derive(Clone, Copy)]
pub struct Destination<'a> {
    pub kind: HookKind,
    pub url: &'a str,
    /// The whole value of the `Authorization` header.
    pub authorization: Option<&'a str>,
    /// What a 2xx answer is to say; none where its status is enough.
    pub expect: Option<&'a ExpectBody>,
}

/// How an attempt went.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attempt {
    pub outcome: DeliveryOutcome,
    pub status: Option<u16>,
    /// For people; empty where nothing is worth a word.
    pub detail: Option<Message>,
    /// The beginning of what the target said, printable; none where it said nothing.
    pub answer: Option<String>,
    pub took: Duration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryOutcome {
    /// The target has it.
    Delivered,
    /// Trying again may help.
    Failed { retry_after: Option<Duration> },
    /// Some of the recipients have it: trying again may help the others, and the target is there.
    Partly,
    /// The target refuses the message for good, whatever it is told later.
    Refused,
    /// 410: the target wants to hear no more.
    Gone,
    /// There is nothing to say: all that it tells is the end of what the target was never told.
    Needless,
}

/// The client that all attempts share.
pub struct Courier {
    client: Client,
    policy: TargetPolicy,
    limits: AttemptLimits,
    /// A proxy resolves the names of targets.
    proxied: bool,
    /// None where the configuration names no mail server.
    pub mailer: Option<Mailer>,
}

impl Courier {
    /// By way of proxies, where there are any, which then decide what names lead to. `extra_roots`: certificates in PEM
    /// that are trusted beside the system's, for a laboratory's own authority.
    pub fn through(
        proxies: &Proxies,
        policy: TargetPolicy,
        limits: AttemptLimits,
        extra_roots: Option<&[u8]>,
    ) -> reqwest::Result<Self> {
        let resolver = GuardedResolver::system(policy.clone()).trusting(proxies.hosts());
        Self::with_resolver(proxies, resolver, policy, limits, extra_roots)
    }

    /// As [`Courier::through`], with names looked up by `resolver`.
    pub fn with_resolver(
        proxies: &Proxies,
        resolver: GuardedResolver,
        policy: TargetPolicy,
        limits: AttemptLimits,
        extra_roots: Option<&[u8]>,
    ) -> reqwest::Result<Self> {
        let roots = extra_roots.map(Certificate::from_pem_bundle).transpose()?.unwrap_or_default();
        let client = system::http_client_through(proxies, limits.connect, limits.whole)?
            .dns_resolver(std::sync::Arc::new(resolver))
            .pool_max_idle_per_host(4)
            .tls_certs_merge(roots)
            .build()?;
        Ok(Self { client, policy, limits, proxied: *proxies != Proxies::None, mailer: None })
    }

    /// One e-mail, under the identifier of the message. The limits hold for each recipient.
    pub async fn mail(&self, to: Destination<'_>, id: &str, payload: &Payload) -> Attempt {
        let started = Instant::now();
        let sending = async {
            let mailer = self.mailer.as_ref().ok_or_else(|| SendFailure::later(message!("no_mail_server")))?;
            mailer.send(recipients(to.url).map_err(SendFailure::later)?, id, payload).await
        };
        let (outcome, status, detail) = match sending.await {
            Ok(code) => (DeliveryOutcome::Delivered, Some(code), None),
            Err(SendFailure { why, for_good: true, .. }) => (DeliveryOutcome::Refused, None, Some(why)),
            Err(SendFailure { why, status, taken_by_some: true, .. }) => (DeliveryOutcome::Partly, status, Some(why)),
            Err(SendFailure { why, status, .. }) => (DeliveryOutcome::Failed { retry_after: None }, status, Some(why)),
        };
        Attempt { outcome, status, detail, answer: None, took: started.elapsed() }
    }

    /// Sends one payload. `signature`: the headers that [`super::sign::headers`] made for it.
    pub async fn attempt(
        &self,
        to: Destination<'_>,
        signature: &[(&'static str, String)],
        payload: Payload,
        now: UtcMicros,
    ) -> Attempt {
        let started = Instant::now();
        let mut attempt = match self.exchange(to, signature, payload).await {
            Ok(response) => self.read_answer(response, to.expect, now).await,
            Err(why) => {
                let outcome = DeliveryOutcome::Failed { retry_after: None };
                Attempt { outcome, status: None, detail: Some(why), answer: None, took: Duration::ZERO }
            }
        };
        attempt.took = started.elapsed();
        attempt
    }

    async fn exchange(
        &self,
        to: Destination<'_>,
        signature: &[(&'static str, String)],
        payload: Payload,
    ) -> Result<Response, Message> {
        let url = endpoint(to.kind, self.policy.check_url(to.url)?);
        if self.proxied {
            self.policy.check_name(&url)?;
        }
        let mut headers = HeaderMap::new();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(payload.content_type));
        for (name, value) in signature {
            headers.insert(*name, header_value(value)?);
        }
        if let Some(authorization) = to.authorization {
            let mut value = header_value(authorization)?;
            value.set_sensitive(true);
            headers.insert(AUTHORIZATION, value);
        }
        let request = self.client.post(url).headers(headers).body(payload.body);
        request.send().await.map_err(|error| self.describe(&error))
    }

    async fn read_answer(&self, response: Response, expect: Option<&ExpectBody>, now: UtcMicros) -> Attempt {
        let status = response.status();
        let retry_after = response.headers().get(RETRY_AFTER).and_then(|value| read_retry_after(value, now));
        let location = response.headers().get(LOCATION);
        let location = location.map(|to| printable(&String::from_utf8_lossy(to.as_bytes()), MOST_OF_A_LINE));
        let (bytes, cut) = self.read_body(response).await;
        let text = String::from_utf8_lossy(&bytes);
        let unexpected = expect.filter(|_| status.is_success()).and_then(|expect| expect.differs(&bytes));
        let with = |what, answer: Parameter| message!("with_answer", what, answer);
        let said = |what: Message| {
            let line = Some(printable(&text, MOST_OF_A_LINE)).filter(|line| !line.is_empty());
            let parts = [line.map(Parameter::from), cut.clone().map(Parameter::from)];
            parts.into_iter().flatten().fold(what, with)
        };
        let answered = format_args!("{status}");
        let detail = match (&unexpected, location) {
            (Some(why), _) => Some(said(message!("answered_but", status = answered, why = shortened(why)))),
            _ if status.is_success() => cut.clone(),
            (None, Some(to)) if status.is_redirection() => Some(message!("redirected", status = answered, to)),
            _ => Some(said(message!("answered", status = answered))),
        };
        let outcome = match status {
            StatusCode::GONE => DeliveryOutcome::Gone,
            _ if status.is_success() && unexpected.is_none() => DeliveryOutcome::Delivered,
            _ => DeliveryOutcome::Failed { retry_after },
        };
        let answer = Some(printable(&text, MOST_OF_AN_ANSWER)).filter(|answer| !answer.is_empty());
        Attempt { outcome, status: Some(status.as_u16()), detail, answer, took: Duration::ZERO }
    }

    /// The beginning of the body, and why it is not the whole of it.
    async fn read_body(&self, mut response: Response) -> (Vec<u8>, Option<Message>) {
        let mut bytes = Vec::new();
        let reading = async {
            while let Some(chunk) = response.chunk().await? {
                let room = self.limits.body_bytes - bytes.len();
                bytes.extend_from_slice(&chunk[..chunk.len().min(room)]);
                if chunk.len() > room {
                    return Ok(false);
                }
            }
            Ok::<_, reqwest::Error>(true)
        };
        let cut = match tokio::time::timeout(self.limits.body, reading).await {
            Ok(Ok(true)) => None,
            Ok(Ok(false)) => Some(message!("answer_cut", bytes = self.limits.body_bytes)),
            Ok(Err(error)) => Some(message!("answer_broke_off", why = self.describe(&error))),
            Err(_) => Some(message!("answer_did_not_end", seconds = seconds(self.limits.body))),
        };
        (bytes, cut)
    }

    /// What went wrong, without the address: it may hold a secret, and whoever reads this knows the hook.
    fn describe(&self, error: &reqwest::Error) -> Message {
        let causes: Vec<&(dyn Error + 'static)> = std::iter::successors(error.source(), |&e| e.source()).collect();
        if let Some(ResolveError(why)) = causes.iter().find_map(|cause| cause.downcast_ref()) {
            return why.clone();
        }
        let root = causes.last().map_or_else(|| Message::verbatim(""), |cause| cause::root_of(*cause));
        let root = shortened(&root);
        match (error.is_timeout(), error.is_connect()) {
            (true, true) => message!("no_connection_within", seconds = seconds(self.limits.connect)),
            (true, false) => message!("no_answer_within", seconds = seconds(self.limits.whole)),
            (false, true) if causes.iter().any(|cause| is_tls(*cause)) => message!("tls_failed", why = root),
            (false, true) => message!("no_connection", why = root),
            (false, false) => message!("no_http_answer", why = root),
        }
    }
}

/// The URL that is posted to.
pub fn endpoint(kind: HookKind, mut url: Url) -> Url {
    const PUSH: &str = "/api/v2/alerts";
    if kind == HookKind::Alertmanager && !url.path().ends_with(PUSH) {
        url.set_path(&format!("{}{PUSH}", url.path().trim_end_matches('/')));
    }
    url
}

fn header_value(text: &str) -> Result<HeaderValue, Message> {
    HeaderValue::from_str(text).map_err(|_| message!("header_control_character"))
}

fn seconds(time: Duration) -> Parameter {
    text(time.as_secs_f64())
}

/// What an answer says within a message, no longer than a line.
fn shortened(message: &Message) -> Message {
    let short = |parameter: &Parameter| match parameter {
        Parameter::Text(text) => printable(text, MOST_OF_A_LINE).into(),
        other => other.clone(),
    };
    let parameters = message.parameters.iter().map(|(name, value)| (name.clone(), short(value))).collect();
    Message { code: message.code.clone(), parameters }
}

/// rustls hides inside `io::Error`s within `io::Error`s, whose `source` skips what they wrap.
fn is_tls(error: &(dyn Error + 'static)) -> bool {
    let inner = error.downcast_ref::<std::io::Error>().and_then(|io| io.get_ref());
    error.is::<rustls::Error>() || inner.is_some_and(|inner| is_tls(inner))
}

/// Seconds, or a date (RFC 9110, 10.2.3).
fn read_retry_after(value: &HeaderValue, now: UtcMicros) -> Option<Duration> {
    let text = value.to_str().ok()?.trim();
    if let Ok(seconds) = text.parse() {
        return Some(Duration::from_secs(seconds));
    }
    let date = jiff::fmt::rfc2822::DateTimeParser::new().parse_timestamp(text).ok()?;
    u64::try_from(date.as_microsecond() - now.0).ok().map(Duration::from_micros)
}

/// Bytes of what a target says: in the words of what went wrong, and of its answer.
const MOST_OF_A_LINE: usize = 300;
const MOST_OF_AN_ANSWER: usize = 1024;

/// What a target says, fit for one line of a table, of `most` bytes at the most.
fn printable(text: &str, most: usize) -> String {
    let clean = |c: char| if c.is_control() || c == '\u{fffd}' { ' ' } else { c };
    let words: String = text.chars().map(clean).collect();
    let mut line = words.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.len() > most {
        let end = line.floor_char_boundary(most);
        line.truncate(end);
        line.push('…');
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retry_after_is_read_as_seconds_or_as_a_date() {
        let now = UtcMicros(784_111_777 * UtcMicros::SECOND); // Sun, 06 Nov 1994 08:49:37 GMT
        let read = |text: &str| read_retry_after(&HeaderValue::from_str(text).unwrap(), now);
        assert_eq!(read("120"), Some(Duration::from_secs(120)));
        assert_eq!(read("Sun, 06 Nov 1994 08:51:37 GMT"), Some(Duration::from_secs(120)));
        assert_eq!(read("Sun, 06 Nov 1994 08:49:36 GMT"), None);
        assert_eq!(read("-5"), None);
        assert_eq!(read("soon"), None);
    }

    #[test]
    fn an_alertmanager_is_posted_to_where_it_takes_alerts() {
        let at = |url: &str| endpoint(HookKind::Alertmanager, Url::parse(url).unwrap()).to_string();
        assert_eq!(at("http://am:9093"), "http://am:9093/api/v2/alerts");
        assert_eq!(at("http://am/prefix/"), "http://am/prefix/api/v2/alerts");
        assert_eq!(at("http://am/api/v2/alerts"), "http://am/api/v2/alerts");
        let hook = endpoint(HookKind::CloudEvents, Url::parse("http://am/x").unwrap());
        assert_eq!(hook.to_string(), "http://am/x");
    }

    #[test]
    fn what_a_target_says_becomes_one_short_line() {
        assert_eq!(printable("a\r\n\x1b[31mb\u{0}\t c", 300), "a [31mb c");
        assert_eq!(printable(&"x".repeat(1000), 300).chars().count(), 301);
        assert_eq!(printable(&"é".repeat(10), 5), "éé…", "no character is cut in two");
    }
}
