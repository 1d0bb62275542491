//! Alerts by e-mail, for laboratories that have nothing else: one message, handed over for each recipient of a hook.

use std::collections::{BTreeMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use futures::{StreamExt, stream};
use lettre::address::Envelope;
use lettre::message::header::ContentType;
use lettre::message::{Mailbox, Mailboxes};
use lettre::transport::smtp::client::{Certificate, Tls, TlsParameters};
use lettre::transport::smtp::{AsyncSmtpTransportBuilder, Error};
use lettre::{Address, AsyncSmtpTransport, AsyncTransport, Tokio1Executor};
use url::Url;

use super::payload::Payload;
use crate::core::message::{Message, Parameter, list, text};
use crate::message;

/// Recipients that a hook may have.
const MOST_RECIPIENTS: usize = 50;

/// Recipients that are served at the same time: mail servers take few connections from one client.
const AT_ONCE: usize = 5;

/// Messages from which on it is forgotten who has taken the oldest.
const MOST_MESSAGES: usize = 1000;

/// Where e-mail is handed over, and who it is from.
#[derive(Debug, Clone)]
pub struct Mailer {
    transport: AsyncSmtpTransport<Tokio1Executor>,
    from: Mailbox,
    /// How long it may take to serve one recipient.
    limit: Duration,
    /// Who has taken the messages, by identifier, that others have not taken yet. Forgotten with the process.
    taken: Arc<Mutex<BTreeMap<String, HashSet<Address>>>>,
}

/// Why no e-mail can be sent.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.message())]
pub enum MailError {
    /// The text may hold a password.
    Address,
    From,
    Authority(Error),
}

impl MailError {
    /// The reason as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::Address => message!("config_mail_server"),
            Self::From => message!("config_mail_from"),
            Self::Authority(why) => message!("config_mail_authority", why = text(why)),
        }
    }
}

/// Why an e-mail was not handed over.
#[derive(Debug)]
pub struct SendFailure {
    pub why: Message,
    /// What the server says of this message, where it answers: of a recipient who may take it later.
    pub status: Option<u16>,
    /// The server has taken it for another recipient: it is there.
    pub taken_by_some: bool,
    /// Every recipient was refused as one who does not exist or takes no mail; what is wrong with the server or the
    /// account (535, 421) may be mended.
    pub for_good: bool,
}

impl Mailer {
    /// `url`: `smtps://user:password@host:465`, `smtp://host:587?tls=required`, or `smtp://host:25` in the open;
    /// `roots`: certificates in PEM that are trusted beside the system's.
    pub fn new(url: &str, from: &str, timeout: Duration, roots: Option<&[u8]>) -> Result<Self, MailError> {
        let from = from.parse().map_err(|_| MailError::From)?;
        let parsed = Url::parse(url).map_err(|_| MailError::Address)?;
        let host = parsed.host_str().filter(|host| !host.is_empty()).ok_or(MailError::Address)?;
        let mut builder = AsyncSmtpTransport::<Tokio1Executor>::from_url(url).map_err(|_| MailError::Address)?;
        if let Some(roots) = roots {
            builder = trusting(builder, &parsed, host, roots).map_err(MailError::Authority)?;
        }
        Ok(Self { transport: builder.timeout(Some(timeout)).build(), from, limit: timeout, taken: Arc::default() })
    }

    /// Hands one message over, for each recipient by itself: one whom the server refuses, or whom it serves slowly,
    /// keeps it from nobody else, and who has taken it is not sent it again. Its `Message-ID` is the same at every
    /// attempt, so that a repetition is recognised.
    ///
    /// # Errors
    /// What the server, or the way to it, said: of any recipient who may still get it, or of all.
    pub async fn send(&self, to: Mailboxes, id: &str, payload: &Payload) -> Result<u16, SendFailure> {
        let said = String::from_utf8_lossy(&payload.body);
        let (subject, body) = said.split_once("\n\n").unwrap_or((&said, ""));
        let mut mail = lettre::Message::builder()
            .from(self.from.clone())
            .message_id(Some(format!("<{id}@gyrowatch>")))
            .subject(subject)
            .header(ContentType::TEXT_PLAIN);
        for recipient in to {
            mail = mail.to(recipient);
        }
        let unsendable = |why: Parameter| SendFailure::later(message!("mail_failed", why));
        let mail = mail.body(body.to_owned()).map_err(|error| unsendable(text(error)))?;
        let (envelope, mail) = (mail.envelope(), mail.formatted());
        let taken = self.taken_of(id);
        let left = envelope.to().iter().filter(|recipient| !taken.contains(recipient));
        let serving: Vec<_> = left.map(|recipient| self.hand_over(recipient.clone(), &mail)).collect();
        let mut served = stream::iter(serving).buffer_unordered(AT_ONCE);
        let (mut accepted, mut status) = (None, None);
        let (mut refused, mut later) = (Vec::new(), Vec::new());
        while let Some((recipient, served)) = served.next().await {
            match served {
                Ok(code) => {
                    accepted = Some(code);
                    self.note(id, recipient);
                }
                Err(SendFailure { why, for_good: true, .. }) => refused.push(unserved(&recipient, why)),
                Err(SendFailure { why, status: said, .. }) => {
                    status = status.or(said);
                    later.push(unserved(&recipient, why));
                }
            }
        }
        if later.is_empty() {
            self.forget(id);
            if accepted.is_some() || !taken.is_empty() {
                refused.iter().for_each(|why| tracing::warn!(id, %why, "a recipient of an alert was refused"));
                return Ok(accepted.unwrap_or(TAKEN));
            }
        }
        let for_good = later.is_empty();
        let why = list(later.into_iter().chain(refused));
        Err(SendFailure { for_good, status, taken_by_some: accepted.is_some(), ..unsendable(why) })
    }

    async fn hand_over(&self, recipient: Address, mail: &[u8]) -> (Address, Result<u16, SendFailure>) {
        let sending = async {
            let alone = Envelope::new(Some(self.from.email.clone()), vec![recipient.clone()])
                .map_err(|error| SendFailure::later(Message::verbatim(error)))?;
            self.transport.send_raw(&alone, mail).await.map_err(|error| SendFailure::of(&error))
        };
        let sent = tokio::time::timeout(self.limit, sending).await;
        let in_vain = || SendFailure::later(message!("no_answer_in_time"));
        (recipient, sent.unwrap_or_else(|_| Err(in_vain())).map(|answer| answer.code().into()))
    }

    fn taken_of(&self, id: &str) -> HashSet<Address> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).get(id).cloned().unwrap_or_default()
    }

    fn note(&self, id: &str, recipient: Address) {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if taken.len() >= MOST_MESSAGES && !taken.contains_key(id) {
            // The oldest: identifiers ascend.
            taken.pop_first();
        }
        taken.entry(id.to_owned()).or_default().insert(recipient);
    }

    fn forget(&self, id: &str) {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner).remove(id);
    }
}

/// The answer to a message that was taken.
const TAKEN: u16 = 250;
/// The server is closing down: that is not of the message.
const CLOSING: u16 = 421;

impl SendFailure {
    /// It may be sent later.
    pub fn later(why: Message) -> Self {
        Self { why, status: None, taken_by_some: false, for_good: false }
    }

    /// Of one recipient.
    fn of(error: &Error) -> Self {
        let status = error.status().map(u16::from).filter(|code| *code != CLOSING);
        Self { status, for_good: is_for_good(error), ..Self::later(Message::verbatim(error)) }
    }
}

fn unserved(recipient: &Address, why: Message) -> Message {
    message!("recipient_not_served", recipient = recipient.to_string(), why)
}

/// 55x: what the server says of a mailbox (RFC 5321, 4.2.1), not of the account or the conversation.
fn is_for_good(error: &Error) -> bool {
    let said = error.status().map(u16::from);
    error.is_permanent() && said.is_some_and(|code| matches!(code, 550..560))
}

fn trusting(
    builder: AsyncSmtpTransportBuilder,
    url: &Url,
    host: &str,
    roots: &[u8],
) -> Result<AsyncSmtpTransportBuilder, Error> {
    let parameters =
        TlsParameters::builder(host.to_owned()).add_root_certificate(Certificate::from_pem(roots)?).build()?;
    let starts = url.query_pairs().find(|(name, _)| name == "tls").map(|(_, value)| value.into_owned());
    Ok(match (url.scheme(), starts.as_deref()) {
        ("smtps", _) => builder.tls(Tls::Wrapper(parameters)),
        (_, Some("required")) => builder.tls(Tls::Required(parameters)),
        (_, Some("opportunistic")) => builder.tls(Tls::Opportunistic(parameters)),
        _ => builder,
    })
}

/// The recipients of `mailto:wei.li@lab.example,weber@lab.example`.
pub fn recipients(url: &str) -> Result<Mailboxes, Message> {
    let listed = url.strip_prefix("mailto:").ok_or_else(|| message!("mail_scheme"))?;
    let mut all = Mailboxes::new();
    for one in listed.split(',') {
        let mailbox = one.trim().parse::<Mailbox>().ok().filter(|_| !one.contains('?'));
        all.push(mailbox.ok_or_else(|| message!("no_mail_address", value = one.to_owned()))?);
    }
    if all.iter().count() > MOST_RECIPIENTS {
        return Err(message!("too_many_recipients", most = MOST_RECIPIENTS));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipients_are_addresses_parted_by_commas() {
        let two = recipients("mailto:wei.li@lab.example, weber@lab.example").unwrap();
        let addresses: Vec<String> = two.iter().map(|mailbox| mailbox.email.to_string()).collect();
        assert_eq!(addresses, ["wei.li@lab.example", "weber@lab.example"]);
        for bad in ["wei.li@lab.example", "mailto:", "mailto:nobody", "mailto:a@b,", "mailto:a@b?subject=x"] {
            assert!(recipients(bad).is_err(), "{bad}");
        }
        assert!(recipients(&format!("mailto:{}", ["a@lab.example"; 51].join(","))).is_err());
    }

    #[test]
    fn an_address_of_a_mail_server_is_checked_and_never_repeated() {
        crate::system::install_crypto();
        let made = |url, from| Mailer::new(url, from, Duration::from_secs(1), None).map(|_| ());
        assert!(made("smtps://u:p@mail.example", "gyrowatch@lab.example").is_ok());
        assert!(made("smtp://mail.example:587?tls=required", "Gyros <gyrowatch@lab.example>").is_ok());
        for (url, from) in [("https://u:secret@mail.example", "a@b.example"), ("mail.example", "a@b.example")] {
            let said = made(url, from).unwrap_err().to_string();
            assert!(!said.contains("secret"), "{said}");
        }
        assert!(matches!(made("smtp://mail.example", "nobody"), Err(MailError::From)));
    }
}
