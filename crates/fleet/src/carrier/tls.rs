//! TLS as it is spoken at the door, and its failures in plain words.

use std::io;
use std::sync::Arc;

use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use rustls::server::WebPkiClientVerifier;
use rustls::version::TLS13;
use rustls::{
    AlertDescription, CertificateError, ClientConfig, DigitallySignedStruct, RootCertStore, ServerConfig,
    SignatureScheme,
};

use crate::error::FleetError;
use crate::papers::certificate::{Identity, day, der_of, sha256};

/// By what the other end is known.
#[derive(Debug, Clone)]
pub(super) enum Known {
    /// By the authority, whose certificate is at hand.
    Ca(String),
    /// By the SHA-256 of the authority's certificate, which it shows.
    Fingerprint([u8; 32]),
}

/// Believes whoever shows a certificate of the authority with a fingerprint, for the name that was dialled.
#[derive(Debug)]
struct Pinned {
    fingerprint: [u8; 32],
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Pinned {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        intermediates: &[CertificateDer<'_>],
        name: &ServerName<'_>,
        ocsp: &[u8],
        now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        let authority = intermediates.iter().find(|certificate| sha256(certificate) == self.fingerprint);
        // What those of others fail with is said of them; this is the one that means somebody else.
        let authority = authority.ok_or(CertificateError::ApplicationVerificationFailure)?;
        let mut roots = RootCertStore::empty();
        roots.add(authority.clone().into_owned())?;
        let verifier = WebPkiServerVerifier::builder_with_provider(roots.into(), self.provider.clone()).build();
        let verifier = verifier.map_err(|error| rustls::Error::General(error.to_string()))?;
        verifier.verify_server_cert(end_entity, &[], name, ocsp, now)
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        verify_tls12_signature(message, certificate, signed, &self.provider.signature_verification_algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        verify_tls13_signature(message, certificate, signed, &self.provider.signature_verification_algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}

fn unusable(what: &str, problem: impl std::fmt::Display) -> FleetError {
    FleetError::Certificate { what: what.to_owned(), problem: problem.to_string() }
}

fn roots(ca: &str) -> Result<Arc<RootCertStore>, FleetError> {
    let mut roots = RootCertStore::empty();
    roots.add(der_of(ca)?).map_err(|error| unusable("the authority's certificate", error))?;
    Ok(roots.into())
}

fn key_of(identity: &Identity) -> Result<PrivateKeyDer<'static>, FleetError> {
    // Nothing of a key is shown.
    PrivateKeyDer::from_pem_slice(identity.key.as_bytes()).map_err(|_| unusable("the key", "it cannot be read"))
}

/// How a door is asked, or a router tried; with a certificate, or without where there is none yet.
pub(super) fn client(known: Known, identity: Option<&Identity>) -> Result<Arc<ClientConfig>, FleetError> {
    let provider = Arc::new(ring::default_provider());
    let builder = ClientConfig::builder_with_provider(provider.clone())
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| unusable("TLS", error))?;
    let builder = match known {
        Known::Ca(ca) => builder.with_root_certificates(roots(&ca)?),
        Known::Fingerprint(fingerprint) => {
            builder.dangerous().with_custom_certificate_verifier(Arc::new(Pinned { fingerprint, provider }))
        }
    };
    Ok(Arc::new(match identity {
        Some(identity) => builder
            .with_client_auth_cert(vec![der_of(&identity.certificate)?], key_of(identity)?)
            .map_err(|error| unusable("the certificate", error))?,
        None => builder.with_no_client_auth(),
    }))
}

/// How the door answers: to whoever comes, and knowing who has a certificate of the authority.
pub(super) fn server(identity: &Identity) -> Result<Arc<ServerConfig>, FleetError> {
    let provider = Arc::new(ring::default_provider());
    let verifier = WebPkiClientVerifier::builder_with_provider(roots(&identity.ca)?, provider.clone())
        .allow_unauthenticated()
        .build()
        .map_err(|error| unusable("the authority's certificate", error))?;
    // The authority's own certificate goes along: by its fingerprint those know it who have nothing else yet.
    let chain = vec![der_of(&identity.certificate)?, der_of(&identity.ca)?];
    let config = ServerConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| unusable("TLS", error))?
        .with_client_cert_verifier(verifier)
        .with_single_cert(chain, key_of(identity)?)
        .map_err(|error| unusable("the ground station's certificate", error))?;
    Ok(Arc::new(config))
}

/// What went wrong with whoever answers at `host`, and what to do.
pub(super) fn plain_words(error: &io::Error, host: &str, now: u64) -> String {
    let Some(tls) = error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) else {
        return match error.kind() {
            io::ErrorKind::ConnectionRefused => {
                "nobody listens there: is `vencejo serve --fleet` running, and is this its address?".to_owned()
            }
            io::ErrorKind::TimedOut => {
                "no answer: is the address right, and does a firewall let it through?".to_owned()
            }
            io::ErrorKind::UnexpectedEof | io::ErrorKind::ConnectionReset => {
                "it hung up before it said anything: it may not speak TLS there".to_owned()
            }
            _ => error.to_string(),
        };
    };
    let clock = format!("the clock here says {}", day(now));
    match tls {
        rustls::Error::InvalidCertificate(problem) => match problem {
            CertificateError::ApplicationVerificationFailure => {
                "somebody else answers there than who made this token: another fleet, or one who listens in on the way. \
                 Nothing was told to it"
                    .to_owned()
            }
            CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
                format!("its certificate has ended, or {clock} and is ahead")
            }
            CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
                format!("its certificate is not good yet, as {clock}: set it (timedatectl)")
            }
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
                format!("its certificate is not for {host}: on the ground run vencejo fleet init ORG --host {host}")
            }
            CertificateError::UnknownIssuer | CertificateError::BadSignature => {
                "its certificate is of another authority: it is no ground station of this fleet".to_owned()
            }
            other => format!("its certificate is not accepted: {other}"),
        },
        rustls::Error::AlertReceived(alert) => match alert {
            AlertDescription::CertificateExpired => {
                format!("it says that our certificate has ended, or is not good yet; {clock}")
            }
            AlertDescription::CertificateRequired => "it wants a certificate, and we have none".to_owned(),
            AlertDescription::UnknownCA | AlertDescription::BadCertificate | AlertDescription::DecryptError => {
                "it does not take our certificate, which is of another authority: enrol again".to_owned()
            }
            other => format!("it ended the handshake: {other:?}"),
        },
        rustls::Error::InvalidMessage(_) => "it does not speak TLS there: is the port right?".to_owned(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_wrong_is_said_with_what_to_do() {
        let now = 1_800_000_000;
        let tls = |error: rustls::Error| plain_words(&io::Error::other(error), "ground.local", now);
        let shown = |problem: CertificateError| tls(rustls::Error::InvalidCertificate(problem));
        for (said, says) in [
            (shown(CertificateError::NotValidYet), "the clock here says 2027-01-15: set it (timedatectl)"),
            (
                shown(CertificateError::Expired),
                "its certificate has ended, or the clock here says 2027-01-15 and is ahead",
            ),
            (shown(CertificateError::NotValidForName), "vencejo fleet init ORG --host ground.local"),
            (shown(CertificateError::UnknownIssuer), "another authority"),
            (shown(CertificateError::ApplicationVerificationFailure), "Nothing was told to it"),
            (tls(rustls::Error::AlertReceived(AlertDescription::CertificateExpired)), "our certificate has ended"),
            (tls(rustls::Error::AlertReceived(AlertDescription::CertificateRequired)), "we have none"),
            (tls(rustls::Error::AlertReceived(AlertDescription::UnknownCA)), "enrol again"),
            (plain_words(&io::ErrorKind::ConnectionRefused.into(), "", now), "nobody listens there"),
            (plain_words(&io::ErrorKind::TimedOut.into(), "", now), "firewall"),
            (plain_words(&io::ErrorKind::UnexpectedEof.into(), "", now), "may not speak TLS"),
        ] {
            assert!(said.contains(says), "{said}");
        }
    }
}
