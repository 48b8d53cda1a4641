//! TLS configurations of the door and its callers, and TLS errors in plain words.

use std::io;
use std::net::SocketAddr;
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

/// How the other end is authenticated.
#[derive(Debug, Clone)]
pub(super) enum Known {
    /// By the authority's certificate.
    Ca(String),
    /// By the SHA-256 of the authority's certificate, which the server sends.
    Fingerprint([u8; 32]),
}

/// Trusts certificates of the authority with this fingerprint, for the name that was dialled.
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
        // This error means another authority; other errors are passed on.
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

/// All certificates of a PEM, one at least.
fn chain(pem: &str, what: &str) -> Result<Vec<CertificateDer<'static>>, FleetError> {
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(pem.as_bytes()).collect();
    let found = found.map_err(|error| unusable(what, error))?;
    if found.is_empty() { Err(unusable(what, "there is none in it, as PEM")) } else { Ok(found) }
}

fn roots(ca: &str) -> Result<Arc<RootCertStore>, FleetError> {
    let (mut roots, what) = (RootCertStore::empty(), "the authority's certificate");
    for authority in chain(ca, what)? {
        roots.add(authority).map_err(|error| unusable(what, error))?;
    }
    Ok(roots.into())
}

fn key_of(identity: &Identity) -> Result<PrivateKeyDer<'static>, FleetError> {
    // The error must not show the key.
    PrivateKeyDer::from_pem_slice(identity.key.as_bytes()).map_err(|_| unusable("the key", "it cannot be read"))
}

/// Whether an identity has a private key; not whether it matches its certificate.
pub(super) fn has_key(identity: &Identity) -> bool {
    key_of(identity).is_ok()
}

/// A client that trusts no one: to find out whether the other end speaks TLS at all.
pub(super) fn stranger() -> Result<Arc<ClientConfig>, FleetError> {
    let builder = ClientConfig::builder_with_provider(ring::default_provider().into())
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| unusable("TLS", error))?;
    Ok(builder.with_root_certificates(RootCertStore::empty()).with_no_client_auth().into())
}

/// The client configuration for doors and routers, with or without a certificate.
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
            .with_client_auth_cert(chain(&identity.certificate, "the certificate")?, key_of(identity)?)
            .map_err(|error| unusable("the certificate", error))?,
        None => builder.with_no_client_auth(),
    }))
}

/// The server configuration of the door: client certificates are optional and verified.
pub(super) fn server(identity: &Identity) -> Result<Arc<ServerConfig>, FleetError> {
    let provider = Arc::new(ring::default_provider());
    let verifier = WebPkiClientVerifier::builder_with_provider(roots(&identity.ca)?, provider.clone())
        .allow_unauthenticated()
        .build()
        .map_err(|error| unusable("the authority's certificate", error))?;
    // The authority's own certificate is included: new members know its fingerprint only.
    let chain = vec![der_of(&identity.certificate)?, der_of(&identity.ca)?];
    let config = ServerConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&TLS13])
        .map_err(|error| unusable("TLS", error))?
        .with_client_cert_verifier(verifier)
        .with_single_cert(chain, key_of(identity)?)
        .map_err(|error| unusable("the ground station's certificate", error))?;
    Ok(Arc::new(config))
}

/// Why a TLS peer is not reached or not trusted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Fault {
    /// Its name has no address here.
    NoAddress,
    /// The connection was refused.
    NobodyListens,
    /// No answer.
    Silent,
    /// No answer over UDP, where nothing is refused either.
    SilentUdp,
    /// The same at this address, the first of several of a name.
    SilentUdpAt(SocketAddr),
    /// It ends the connection without a reason.
    HangsUp,
    /// It does not speak TLS.
    NoTls,
    /// Its authority is not the one with our fingerprint.
    Stranger,
    /// Its certificate has expired.
    Ended,
    /// Its certificate is not valid yet.
    NotYet,
    /// Its certificate is not for the name that was dialled.
    OtherName,
    /// Its certificate is of another authority.
    OtherAuthority,
    /// Its certificate is invalid for another reason.
    Certificate(String),
    /// It reports that our certificate has expired or is not valid yet.
    OursEnded,
    /// It requires a certificate, and got none.
    WantsOurs,
    /// It does not take our certificate.
    RefusesOurs,
    /// It ended the handshake for another reason.
    Alert(String),
    /// Something else.
    Other(String),
}

/// The side that raised an alert.
#[derive(Debug, Clone, Copy)]
pub(super) enum Side<'a> {
    /// Ours, about the other end; with the reason of rustls.
    Ours(&'a str),
    /// The other end, about us.
    Theirs,
}

impl Fault {
    /// The fault of an alert.
    pub(super) fn of_alert(alert: AlertDescription, side: Side<'_>) -> Self {
        match (side, alert) {
            (Side::Theirs, AlertDescription::CertificateExpired) => Self::OursEnded,
            (Side::Theirs, AlertDescription::CertificateRequired) => Self::WantsOurs,
            (
                Side::Theirs,
                AlertDescription::UnknownCA | AlertDescription::BadCertificate | AlertDescription::DecryptError,
            ) => Self::RefusesOurs,
            (Side::Theirs, other) => Self::Alert(format!("{other:?}")),
            // One alert for both ends of the validity.
            (Side::Ours(reason), AlertDescription::CertificateExpired) if reason.contains("not valid yet") => {
                Self::NotYet
            }
            (Side::Ours(_), AlertDescription::CertificateExpired) => Self::Ended,
            (Side::Ours(_), AlertDescription::UnknownCA | AlertDescription::DecryptError) => Self::OtherAuthority,
            (Side::Ours(reason), AlertDescription::BadCertificate) if reason.contains("not valid for name") => {
                Self::OtherName
            }
            (Side::Ours(reason), _) => Self::Certificate(reason.to_owned()),
        }
    }
}

impl From<&io::Error> for Fault {
    fn from(error: &io::Error) -> Self {
        let Some(tls) = error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) else {
            return match error.kind() {
                io::ErrorKind::ConnectionRefused => Self::NobodyListens,
                io::ErrorKind::TimedOut => Self::Silent,
                io::ErrorKind::UnexpectedEof | io::ErrorKind::ConnectionReset => Self::HangsUp,
                _ => Self::Other(error.to_string()),
            };
        };
        match tls {
            rustls::Error::InvalidCertificate(problem) => match problem {
                CertificateError::ApplicationVerificationFailure => Self::Stranger,
                CertificateError::Expired | CertificateError::ExpiredContext { .. } => Self::Ended,
                CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => Self::NotYet,
                CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => Self::OtherName,
                CertificateError::UnknownIssuer | CertificateError::BadSignature => Self::OtherAuthority,
                other => Self::Certificate(other.to_string()),
            },
            rustls::Error::AlertReceived(alert) => Self::of_alert(*alert, Side::Theirs),
            rustls::Error::InvalidMessage(_) => Self::NoTls,
            other => Self::Other(other.to_string()),
        }
    }
}

/// The time of our clock, which may be wrong.
fn clock(now: u64) -> String {
    format!("the clock here says {}", day(now))
}

impl Fault {
    /// The fault of the peer at `host`, as text.
    pub(super) fn plainly(&self, host: &str, now: u64) -> String {
        match self {
            Self::NoAddress => format!("no address is known here for the name {host}"),
            Self::NobodyListens => "nobody listens there".to_owned(),
            Self::Silent => "no answer: is the address right, and does a firewall let it through?".to_owned(),
            Self::SilentUdp => "no answer over UDP: is the address right, is it a router with QUIC, and does a firewall let UDP through?".to_owned(),
            Self::SilentUdpAt(at) => format!("no answer over UDP at {at}, the first of several addresses of {host}, and with QUIC no other is tried: give the address in place of the name, or tls/ in place of quic/"),
            Self::HangsUp => "it hung up without a reason: it may be starting again, or not speak TLS there".to_owned(),
            Self::NoTls => "it does not speak TLS there: is the port right?".to_owned(),
            Self::Stranger | Self::OtherAuthority => "its certificate is of another authority".to_owned(),
            Self::Ended => format!("its certificate has ended, or {} and is ahead", clock(now)),
            Self::NotYet => format!("its certificate is not good yet, as {}: set it (timedatectl), or, where that is today, the clock with which it was made", clock(now)),
            Self::OtherName => format!("its certificate is not for {host}"),
            Self::Certificate(problem) => format!("its certificate is not accepted: {problem}"),
            Self::OursEnded => format!("it says that our certificate has ended, or is not good yet; {}", clock(now)),
            Self::WantsOurs => "it wants a certificate, and we have none".to_owned(),
            Self::RefusesOurs => "it does not take our certificate, which is of another authority".to_owned(),
            Self::Alert(alert) => format!("it ended the handshake: {alert}"),
            Self::Other(problem) => problem.clone(),
        }
    }

    /// The same for a ground station of a fleet, with the remedy.
    pub(super) fn in_a_fleet(&self, host: &str, now: u64) -> String {
        let plainly = self.plainly(host, now);
        match self {
            Self::NobodyListens => format!("{plainly}: is `vencejo serve --fleet` running, and is this its address?"),
            Self::Stranger => {
                "somebody else answers there than who made this token: another fleet, or one who listens in on the way. \
                 Nothing was told to it"
                    .to_owned()
            }
            Self::OtherName => format!("{plainly}: on the ground run vencejo fleet init ORG --host {host}"),
            Self::OtherAuthority => format!("{plainly}: it is not a ground station of this fleet"),
            Self::RefusesOurs => format!("{plainly}: enrol again"),
            _ => plainly,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_wrong_is_said_with_what_to_do() {
        let now = 1_800_000_000;
        let said = |error: &io::Error, host: &str| Fault::from(error).in_a_fleet(host, now);
        let tls = |error: rustls::Error| said(&io::Error::other(error), "ground.local");
        let first = Fault::SilentUdpAt(([127, 0, 0, 1], 7447).into());
        let shown = |problem: CertificateError| tls(rustls::Error::InvalidCertificate(problem));
        for (told, says) in [
            (
                shown(CertificateError::NotValidYet),
                "the clock here says 2027-01-15: set it (timedatectl), or, where that is today, the clock with",
            ),
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
            (
                first.in_a_fleet("ground.local", now),
                "at 127.0.0.1:7447, the first of several addresses of ground.local",
            ),
            (said(&io::ErrorKind::ConnectionRefused.into(), ""), "nobody listens there"),
            (said(&io::ErrorKind::TimedOut.into(), ""), "firewall"),
            (said(&io::ErrorKind::UnexpectedEof.into(), ""), "or not speak TLS there"),
        ] {
            assert!(told.contains(says), "{told}");
        }
    }
}
