//! What the system, TLS and HTTP say of a connection that failed, in words of ours.

use std::error::Error;
use std::io::{self, ErrorKind};

use rustls::CertificateError as Certificate;

use crate::core::message::{Message, text};
use crate::message;

/// What a certificate is refused with that is an authority's own.
const AN_AUTHORITYS: &str = "CaUsedAsEndEntity";

/// The innermost error: what a person can act on.
pub fn root_of(error: &(dyn Error + 'static)) -> Message {
    said(innermost(error))
}

/// Whether it is the certificate of the other side that is not taken: no other try helps.
pub fn is_of_certificate(error: &(dyn Error + 'static)) -> bool {
    let mut cause = innermost(error);
    while let Some(inner) = cause.downcast_ref::<io::Error>().and_then(io::Error::get_ref) {
        cause = inner;
    }
    matches!(cause.downcast_ref(), Some(rustls::Error::InvalidCertificate(_)))
}

fn innermost<'a>(error: &'a (dyn Error + 'static)) -> &'a (dyn Error + 'static) {
    let mut cause = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    cause
}

fn said(error: &(dyn Error + 'static)) -> Message {
    let known = if let Some(error) = error.downcast_ref::<io::Error>() {
        // rustls hides inside `io::Error`s within `io::Error`s, whose `source` skips what they wrap.
        error.get_ref().map_or_else(|| by_system(error), |inner| Some(said(inner)))
    } else if let Some(error) = error.downcast_ref::<rustls::Error>() {
        by_tls(error)
    } else {
        error.downcast_ref::<hyper::Error>().and_then(by_http)
    };
    known.unwrap_or_else(|| Message::verbatim(error.to_string()))
}

/// What the operating system says of a file or a connection.
pub fn by_system(error: &io::Error) -> Option<Message> {
    let number = text(error.raw_os_error()?);
    Some(match error.kind() {
        ErrorKind::NotFound => message!("file_not_found", number),
        ErrorKind::AlreadyExists => message!("file_exists", number),
        ErrorKind::PermissionDenied => message!("permission_denied", number),
        ErrorKind::IsADirectory => message!("is_a_directory", number),
        ErrorKind::NotADirectory => message!("not_a_directory", number),
        ErrorKind::ReadOnlyFilesystem => message!("read_only_files", number),
        ErrorKind::StorageFull => message!("no_space_left", number),
        ErrorKind::AddrInUse => message!("address_in_use", number),
        ErrorKind::ConnectionRefused => message!("connection_refused", number),
        ErrorKind::ConnectionReset => message!("connection_reset", number),
        ErrorKind::HostUnreachable => message!("no_route_to_host", number),
        ErrorKind::NetworkUnreachable => message!("no_route_to_network", number),
        _ => return None,
    })
}

fn by_tls(error: &rustls::Error) -> Option<Message> {
    Some(match error {
        rustls::Error::InvalidCertificate(Certificate::UnknownIssuer) => message!("certificate_of_unknown_authority"),
        rustls::Error::InvalidCertificate(
            Certificate::Expired
            | Certificate::ExpiredContext { .. }
            | Certificate::NotValidYet
            | Certificate::NotValidYetContext { .. },
        ) => message!("certificate_not_in_time"),
        rustls::Error::InvalidCertificate(
            Certificate::NotValidForName | Certificate::NotValidForNameContext { .. },
        ) => message!("certificate_for_other_name"),
        // Of the verifier, which has no type of its own for it.
        rustls::Error::InvalidCertificate(Certificate::Other(other)) if other.to_string() == AN_AUTHORITYS => {
            message!("certificate_of_an_authority")
        }
        rustls::Error::InvalidMessage(_) => message!("no_tls_there"),
        _ => return None,
    })
}

fn by_http(error: &hyper::Error) -> Option<Message> {
    if error.is_incomplete_message() {
        return Some(message!("hung_up"));
    }
    error.is_parse().then(|| message!("not_http"))
}

/// Why a name leads to no address.
pub fn of_lookup(error: &io::Error) -> Message {
    let said = error.to_string();
    match said.strip_prefix("failed to lookup address information: ") {
        Some(why) if why.starts_with("Temporary failure") => message!("no_name_server"),
        Some(_) => message!("no_such_name"),
        None => Message::verbatim(said),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_failed_is_said_in_words_of_ours() {
        let tls = |error: rustls::Error| io::Error::new(ErrorKind::InvalidData, io::Error::other(error));
        let unknown = tls(rustls::Error::InvalidCertificate(Certificate::UnknownIssuer));
        for (error, code) in [
            (io::Error::from_raw_os_error(111), "connection_refused"),
            (io::Error::from_raw_os_error(101), "no_route_to_network"),
            (unknown, "certificate_of_unknown_authority"),
            (tls(rustls::Error::InvalidMessage(rustls::InvalidMessage::InvalidContentType)), "no_tls_there"),
        ] {
            assert_eq!(root_of(&error).code, code, "{error}");
        }
        let certificate = tls(rustls::Error::InvalidCertificate(Certificate::NotValidForName));
        assert!(is_of_certificate(&certificate) && !is_of_certificate(&io::Error::from_raw_os_error(111)));
        let lookup = |why: &str| of_lookup(&io::Error::other(format!("failed to lookup address information: {why}")));
        assert_eq!(lookup("Name or service not known").code, "no_such_name");
        assert_eq!(lookup("Temporary failure in name resolution").code, "no_name_server");
    }
}
