//! Talks to a running service the way a station does.
//!
//! Every answer is sorted into one of three: the service has the document ([`Sent`]), the document is at fault
//! ([`Sent::Refused`]), or something else is ([`ClientError`]): then the document stays where it is.

use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use reqwest::header::{ACCEPT_LANGUAGE, CONTENT_TYPE, RETRY_AFTER};
use reqwest::{Certificate, Method, StatusCode};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::common::{service_address, wrong};
use super::prelude::*;
use crate::core::message::sent;
use crate::system::{self, Proxies};
use crate::wire::cause;
use crate::wire::note::NoteBody;
use crate::wire::problem::ProblemBody;
use crate::words;

pub const JSON: &str = "application/json";
pub const NDJSON: &str = "application/x-ndjson";

const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
const ANSWER_TIMEOUT: Duration = Duration::from_secs(120);

/// What became of a document that reached the service.
#[derive(Debug, PartialEq)]
pub enum Sent {
    Stored(Value),
    /// The same content was already there.
    Known(Value),
    Refused(ProblemBody),
}

/// Why nothing can be said about the document.
#[derive(Debug, PartialEq)]
pub enum ClientError {
    /// No service answers at the address.
    Unreachable(String),
    /// It answers that it is busy or unwell: sending again can help.
    Retry { why: String, after: Option<Duration> },
    /// It cannot, until somebody changes the address, the token or the service; the status, where that says so.
    Fatal { status: Option<StatusCode>, why: String },
}

impl ClientError {
    pub fn stop(status: impl Into<Option<StatusCode>>, why: String) -> Self {
        Self::Fatal { status: status.into(), why }
    }

    /// Whether there is nothing at the address that was asked.
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::Fatal { status: Some(StatusCode::NOT_FOUND), .. })
    }
}

impl std::fmt::Display for ClientError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unreachable(why) | Self::Retry { why, .. } | Self::Fatal { why, .. } => f.write_str(why),
        }
    }
}

impl std::error::Error for ClientError {}

/// One line of the answer of `POST /v1/import`.
#[derive(Debug, Deserialize)]
pub struct ImportLineAnswer {
    pub status: u16,
    pub error: Option<ProblemBody>,
    #[serde(default)]
    pub notes: Vec<NoteBody>,
}

/// What the service is shown, and the file that it was read from.
#[derive(Debug, Clone, Default)]
struct Token {
    now: Arc<Mutex<Option<String>>>,
    file: Option<PathBuf>,
}

impl Token {
    fn given(token: Option<String>) -> Self {
        Self { now: Arc::new(Mutex::new(token)), file: None }
    }

    fn in_file(path: &Path) -> std::io::Result<Self> {
        let token = read_token(path)?;
        Ok(Self { file: Some(path.to_owned()), ..Self::given(Some(token)) })
    }

    fn now(&self) -> Option<String> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether the file holds another one than the service has refused, which is shown from now on.
    fn read_again(&self, refused: Option<&str>) -> bool {
        let Some(token) = self.file.as_deref().and_then(|file| read_token(file).ok()) else { return false };
        let is_other = refused != Some(&token);
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = Some(token);
        is_other
    }
}

fn read_token(path: &Path) -> std::io::Result<String> {
    Ok(String::from_utf8_lossy(&std::fs::read(path)?).trim().to_owned())
}

#[derive(Debug, Clone)]
pub struct Service {
    base: String,
    token: Token,
    http: reqwest::Client,
    /// The query of what is sent: who is told of what is found late.
    notify_query: &'static str,
}

/// Where the service is, and how it is spoken to.
#[derive(Debug, clap::Args)]
pub struct Connection {
    /// Address of the service
    #[arg(long, env = "GYROWATCH_URL", default_value_t = service_address())]
    url: String,

    /// Access token, where the service asks for one
    #[arg(long, env = "GYROWATCH_TOKEN", hide_env_values = true)]
    token: Option<String>,

    /// File with the access token, which then stands in no list of processes
    #[arg(long, value_name = "FILE", conflicts_with = "token")]
    token_file: Option<PathBuf>,

    /// Certificate (PEM) of the authority that signed the service's, where this machine does not know it
    #[arg(long, value_name = "FILE")]
    ca_file: Option<PathBuf>,

    /// Proxy on the way there: `http://host:port`, or `environment` for what HTTPS_PROXY, HTTP_PROXY and NO_PROXY say
    #[arg(long, env = "GYROWATCH_PROXY", value_name = "PROXY", default_value = "", hide_default_value = true,
          hide_env_values = true, value_parser = proxies)]
    proxy: Proxies,
}

fn proxies(text: &str) -> Result<Proxies, String> {
    Proxies::parse(text).ok_or_else(|| wrong(message!("config_proxy")))
}

impl Connection {
    pub fn service(&self) -> anyhow::Result<Service> {
        let read = |path: &PathBuf| std::fs::read(path).with_context(|| path.display().to_string());
        let token = match &self.token_file {
            Some(path) => Token::in_file(path).with_context(|| path.display().to_string())?,
            None => Token::given(self.token.clone()),
        };
        let authorities = match &self.ca_file {
            Some(path) => {
                let found = Certificate::from_pem_bundle(&read(path)?).unwrap_or_default();
                if found.is_empty() {
                    bail!(said(message!("terminal_no_certificate", file = path.display().to_string())));
                }
                found
            }
            None => Vec::new(),
        };
        Service::by_way_of(&self.proxy, &self.url, token, authorities)
    }
}

impl Service {
    /// `address`: `http://host:port`, or `host:port` alone as `GYROWATCH_LISTEN` gives it.
    pub fn at(address: &str, token: Option<String>) -> anyhow::Result<Self> {
        Self::by_way_of(&Proxies::None, address, Token::given(token), Vec::new())
    }

    /// As [`Service::at`], trusting also what these authorities have signed.
    fn by_way_of(
        proxies: &Proxies,
        address: &str,
        token: Token,
        authorities: Vec<Certificate>,
    ) -> anyhow::Result<Self> {
        let with_port = address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
        let base = match address.contains("://") {
            false if with_port => format!("http://{address}"),
            _ => address.to_owned(),
        };
        let known = reqwest::Url::parse(&base).ok().filter(|url| url.has_host());
        let Some(url) = known else {
            bail!(said(message!("terminal_no_address", address = sent(address))));
        };
        if !matches!(url.scheme(), "http" | "https") {
            bail!(said(message!("config_http", value = sent(address))));
        }
        let client = system::http_client_through(proxies, CONNECT_TIMEOUT, ANSWER_TIMEOUT);
        let client = client.context("--proxy")?;
        let client = if authorities.is_empty() { client } else { client.tls_certs_merge(authorities) };
        let http = client.build()?;
        Ok(Self { base: base.trim_end_matches('/').to_owned(), token, http, notify_query: "" })
    }

    /// Has everything that is sent say who is told of what is found late.
    pub fn with_notify_query(self, query: &'static str) -> Self {
        Self { notify_query: query, ..self }
    }

    pub fn base(&self) -> &str {
        &self.base
    }

    /// Asks for a JSON document.
    pub async fn get<T: DeserializeOwned>(&self, route: &str) -> anyhow::Result<T> {
        let (status, _, body) = self.answer(self.request(Method::GET, route)).await?;
        if !status.is_success() {
            bail!("{route}: {}", why(status, &body));
        }
        serde_json::from_slice(&body).with_context(|| format!("{route}: {}", word("terminal_foreign_answer")))
    }

    /// As [`Service::get`], telling what another try may help from what it does not.
    pub async fn ask(&self, route: &str) -> Result<Value, ClientError> {
        let (status, after, body) = self.answer(self.request(Method::GET, route)).await?;
        if status == StatusCode::OK {
            return serde_json::from_slice(&body).map_err(|error| foreign(None, error));
        }
        Err(match sort(status, after, &body)? {
            Sent::Refused(problem) => ClientError::stop(status, format!("{status}: {}", problem.detail)),
            Sent::Stored(_) | Sent::Known(_) => foreign(status, format!("{route}: {status}")),
        })
    }

    /// Posts one document to its own endpoint.
    pub async fn post(&self, route: &str, content_type: &str, body: Bytes) -> Result<Sent, ClientError> {
        let (status, after, body) = self.call(route, content_type, body).await?;
        sort(status, after, &body)
    }

    /// Posts a batch of lines; one answer a line, in order.
    pub async fn import(&self, lines: Bytes, count: usize) -> Result<Vec<ImportLineAnswer>, ClientError> {
        let (status, after, body) = self.call("/v1/import", NDJSON, lines).await?;
        if status != StatusCode::OK {
            return Err(match sort(status, after, &body)? {
                Sent::Refused(problem) => {
                    ClientError::stop(status, said(message!("terminal_batch_refused", why = problem.detail)))
                }
                Sent::Stored(_) | Sent::Known(_) => foreign(status, format!("/v1/import: {status}")),
            });
        }
        let answers: Result<Vec<ImportLineAnswer>, _> =
            body.split(|&b| b == b'\n').filter(|line| !line.is_empty()).map(serde_json::from_slice).collect();
        match answers {
            Ok(answers) if answers.len() == count => Ok(answers),
            Ok(answers) => {
                let (sent, answered) = (count.to_string(), answers.len().to_string());
                let why = said(message!("terminal_answers_missing", sent, answered));
                Err(ClientError::Retry { why, after: None })
            }
            Err(error) => Err(foreign(None, error)),
        }
    }

    fn request(&self, method: Method, route: &str) -> reqwest::RequestBuilder {
        let request = self.http.request(method, format!("{}{route}", self.base));
        request.header(ACCEPT_LANGUAGE, words::asked().tag())
    }

    async fn call(
        &self,
        route: &str,
        content_type: &str,
        body: Bytes,
    ) -> Result<(StatusCode, Option<Duration>, Bytes), ClientError> {
        self.answer(
            self.request(Method::POST, &format!("{route}{}", self.notify_query))
                .body(body)
                .header(CONTENT_TYPE, content_type),
        )
        .await
    }

    /// Where the token is refused and its file holds another one by now, it is asked once more with that.
    async fn answer(
        &self,
        request: reqwest::RequestBuilder,
    ) -> Result<(StatusCode, Option<Duration>, Bytes), ClientError> {
        let (again, token) = (request.try_clone(), self.token.now());
        let answer = self.answer_to(request, token.as_deref()).await?;
        match again.filter(|_| answer.0 == StatusCode::UNAUTHORIZED && self.token.read_again(token.as_deref())) {
            Some(again) => {
                let file = self.token.file.as_deref().unwrap_or(Path::new("")).display().to_string();
                eprintln!("{}", said(message!("terminal_token_read_again", file)));
                self.answer_to(again, self.token.now().as_deref()).await
            }
            None => Ok(answer),
        }
    }

    async fn answer_to(
        &self,
        request: reqwest::RequestBuilder,
        token: Option<&str>,
    ) -> Result<(StatusCode, Option<Duration>, Bytes), ClientError> {
        let request = match token {
            Some(token) => request.bearer_auth(token),
            None => request,
        };
        let away = |error: reqwest::Error| {
            let why = if error.is_timeout() { message!("no_answer_in_time") } else { cause::root_of(&error) };
            let why = said(message!("terminal_cannot_reach", address = self.base.clone(), why));
            // A certificate is mended by a person.
            if cause::is_of_certificate(&error) { ClientError::stop(None, why) } else { ClientError::Unreachable(why) }
        };
        let answer = request.send().await.map_err(away)?;
        let status = answer.status();
        let after = answer.headers().get(RETRY_AFTER).and_then(|v| v.to_str().ok()).and_then(|v| v.parse().ok());
        let body = answer.bytes().await.map_err(away)?;
        Ok((status, after.map(Duration::from_secs), body))
    }
}

/// What answers is something else, such as a proxy.
fn foreign(status: impl Into<Option<StatusCode>>, what: impl Display) -> ClientError {
    ClientError::stop(status, format!("{} ({what})", word("terminal_foreign_answer")))
}

/// A 2xx counts only with the JSON of the service in it, so that a proxy's "200 OK" page acknowledges nothing; and
/// only what the document itself can cause refuses it.
fn sort(status: StatusCode, after: Option<Duration>, body: &[u8]) -> Result<Sent, ClientError> {
    let problem = || serde_json::from_slice::<ProblemBody>(body).ok();
    match status.as_u16() {
        code @ (200..=202) => match serde_json::from_slice::<Value>(body) {
            Ok(answer) if answer.get("id").is_some() => {
                Ok(if code == 200 { Sent::Known(answer) } else { Sent::Stored(answer) })
            }
            _ => Err(foreign(status, status)),
        },
        400 | 409 | 413 | 415 | 422 => match problem() {
            Some(problem) => Ok(Sent::Refused(problem)),
            None => Err(foreign(status, status)),
        },
        408 | 425 | 429 | 500.. => Err(ClientError::Retry { why: why(status, body), after }),
        _ => Err(ClientError::stop(status, why(status, body))),
    }
}

/// What the service says of a request that it does not take, and where this program is given a token.
fn why(status: StatusCode, body: &[u8]) -> String {
    let said = serde_json::from_slice::<ProblemBody>(body).ok();
    let why = said.map_or_else(|| status.to_string(), |problem| format!("{status}: {}", problem.detail));
    match status {
        StatusCode::UNAUTHORIZED => format!("{why} (--token-file FILE, or GYROWATCH_TOKEN)"),
        _ => why,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROBLEM: &[u8] = br#"{"title":"T","status":422,"detail":"D","errors":[{"pointer":"/imu","detail":"x"}]}"#;

    fn sorted(status: u16, body: &[u8]) -> Result<Sent, ClientError> {
        sort(StatusCode::from_u16(status).unwrap(), None, body)
    }

    #[test]
    fn only_an_answer_of_the_service_acknowledges() {
        for status in [201, 202] {
            assert!(matches!(sorted(status, br#"{"id":"r1"}"#), Ok(Sent::Stored(_))));
        }
        assert!(matches!(sorted(200, br#"{"id":"r1"}"#), Ok(Sent::Known(_))));
        for page in [&b"<html>Welcome to the guest network</html>"[..], b"{}", b""] {
            assert!(matches!(sorted(200, page), Err(ClientError::Fatal { .. })));
        }
        assert!(matches!(sorted(302, b""), Err(ClientError::Fatal { .. })));
    }

    #[test]
    fn only_the_documents_own_faults_refuse_it() {
        for status in [400, 409, 413, 415, 422] {
            assert!(matches!(sorted(status, PROBLEM), Ok(Sent::Refused(_))), "{status}");
            assert!(matches!(sorted(status, b"<html>"), Err(ClientError::Fatal { .. })), "{status}");
        }
        for status in [401, 403, 404, 405] {
            assert!(matches!(sorted(status, PROBLEM), Err(ClientError::Fatal { .. })), "{status}");
        }
        for status in [408, 429, 500, 502, 503, 507] {
            assert!(matches!(sorted(status, PROBLEM), Err(ClientError::Retry { .. })), "{status}");
        }
    }

    #[test]
    fn an_address_may_leave_out_the_scheme() {
        system::install_crypto();
        assert_eq!(Service::at("127.0.0.1:8080", None).unwrap().base(), "http://127.0.0.1:8080");
        assert_eq!(Service::at("https://host/", None).unwrap().base(), "https://host");
        assert!(Service::at("ftp://host", None).is_err());
        for no_address in ["foo", "http://", ":8080", "/tmp/x", ""] {
            let said = Service::at(no_address, None).unwrap_err().to_string();
            assert!(said.contains("such as http://127.0.0.1:8080"), "{said}");
        }
    }
}
