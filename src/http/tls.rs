//! The certificate that the service shows, read again when its files change.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio::sync::watch;
use tokio_rustls::TlsAcceptor;

/// How soon a new certificate is shown.
const LOOK_AGAIN: Duration = Duration::from_secs(2);

/// Why a certificate cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    #[error("{key} {file}: {why}")]
    File { key: &'static str, file: PathBuf, why: String },
    #[error("server.tls_certificate and server.tls_key do not go together: {0}")]
    Pair(#[from] rustls::Error),
}

/// TLS with the certificate of the moment.
#[derive(Debug)]
pub struct Tls(watch::Receiver<Arc<ServerConfig>>);

impl Tls {
    /// Reads certificate and key, and again whenever they change. What cannot be used is logged, and the one before
    /// stays.
    pub fn start(certificate: &Path, key: &Path) -> Result<Self, TlsError> {
        let mut files = Files { certificate: certificate.to_owned(), key: key.to_owned(), seen: None };
        files.seen = files.contents();
        let (sender, receiver) = watch::channel(Arc::new(files.load()?));
        tokio::spawn(async move {
            while !sender.is_closed() {
                tokio::time::sleep(LOOK_AGAIN).await;
                let now = files.contents();
                // Of two files that are written one after the other, the first may be seen without the second.
                if now == files.seen || now.is_none() {
                    continue;
                }
                files.seen = now;
                match files.load() {
                    Ok(config) => {
                        sender.send_replace(Arc::new(config));
                        tracing::info!(certificate = %files.certificate.display(), "the new certificate is in use");
                    }
                    Err(error) => tracing::error!(%error, "the new certificate cannot be used; the one before is"),
                }
            }
        });
        Ok(Self(receiver))
    }

    /// Takes connections with the certificate in force.
    pub fn acceptor(&self) -> TlsAcceptor {
        TlsAcceptor::from(Arc::clone(&self.0.borrow()))
    }
}

struct Files {
    certificate: PathBuf,
    key: PathBuf,
    seen: Option<(Vec<u8>, Vec<u8>)>,
}

impl Files {
    fn contents(&self) -> Option<(Vec<u8>, Vec<u8>)> {
        Some((fs::read(&self.certificate).ok()?, fs::read(&self.key).ok()?))
    }

    fn load(&self) -> Result<ServerConfig, TlsError> {
        let wrong = |key, file: &Path, why: &dyn std::fmt::Display| TlsError::File {
            key,
            file: file.to_owned(),
            why: why.to_string(),
        };
        let chain: Vec<CertificateDer<'_>> = CertificateDer::pem_file_iter(&self.certificate)
            .and_then(Iterator::collect)
            .map_err(|why| wrong("server.tls_certificate", &self.certificate, &why))?;
        if chain.is_empty() {
            return Err(wrong("server.tls_certificate", &self.certificate, &"holds no certificate"));
        }
        let key = PrivateKeyDer::from_pem_file(&self.key).map_err(|why| wrong("server.tls_key", &self.key, &why))?;
        let mut config = ServerConfig::builder().with_no_client_auth().with_single_cert(chain, key)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(config)
    }
}
