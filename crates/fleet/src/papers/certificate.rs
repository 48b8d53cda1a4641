//! The organisation's own certificate authority, and what it signs: X.509 (RFC 5280), keys on the curve P-256.

use std::fmt;

use rcgen::{
    BasicConstraints, CertificateParams, CertificateSigningRequestParams, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose, PublicKeyData, SerialNumber, SigningKey,
};
use ring::digest::{SHA256, digest};
use ring::signature::{
    ECDSA_P256_SHA256_ASN1, ECDSA_P384_SHA384_ASN1, ED25519, RSA_PKCS1_2048_8192_SHA256, UnparsedPublicKey,
    VerificationAlgorithm,
};
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, CertificateSigningRequestDer};
use time::OffsetDateTime;
use x509_parser::certificate::X509Certificate;
use x509_parser::extensions::GeneralName;
use x509_parser::prelude::FromDer;
use x509_parser::public_key::PublicKey;

use super::DAY_S;
use crate::error::FleetError;
use crate::key::Name;
use crate::operator::random;

/// Validity of the certificate of an aircraft or a ground station.
pub const CERTIFICATE_DAYS: u64 = 90;
/// Validity of the authority's certificate.
pub const CA_DAYS: u64 = 20 * 365;
/// A certificate with less than this left is renewed, where its authority can be reached.
pub const RENEW_BEFORE_S: u64 = 30 * DAY_S;
/// With less than this left there is a warning: renewal has failed for ten days.
pub const WARN_BEFORE_S: u64 = 20 * DAY_S;
/// How long before its issue a certificate is valid: a clock on board may be behind.
const BACKDATED_S: u64 = DAY_S;
/// The earliest plausible time: 2026. A computer without a battery-backed clock starts in 1970, and certificates that
/// it issues then have expired.
const CLOCK_BEGINS: u64 = 1_767_225_600;
/// Most host names and addresses in a certificate.
const MAX_NAMES: usize = 64;

/// Prefix of the common name of a ground station's or a router's certificate. No aircraft can have such a name, and no
/// public authority signs one: Zenoh trusts those too, so this is checked besides.
pub const STATION_PREFIX: &str = "_";

/// A certificate, its key and the trusted authority, as PEM. The key is never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Identity {
    /// The authority's certificate.
    pub ca: String,
    /// The certificate.
    pub certificate: String,
    /// Its private key.
    pub key: String,
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Identity").field("certificate", &self.certificate).finish_non_exhaustive()
    }
}

/// The facts of a certificate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facts {
    /// Its common name.
    pub common_name: String,
    /// Start of its validity, seconds since 1970.
    pub begins: u64,
    /// End of its validity, seconds since 1970.
    pub ends: u64,
    /// Its host names and addresses.
    pub names: Vec<String>,
    /// Whether it may sign others.
    pub is_ca: bool,
    /// SHA-256 of its public key.
    pub key: [u8; 32],
}

impl Facts {
    /// Whether to renew it: it ends soon, or is not valid yet because it was issued by a clock that was ahead.
    pub fn is_due(&self, now: u64) -> bool {
        self.ends < now.saturating_add(RENEW_BEFORE_S) || self.begins > now
    }
}

fn wrong(what: &str, problem: impl fmt::Display) -> FleetError {
    FleetError::Certificate { what: what.to_owned(), problem: problem.to_string() }
}

fn random_serial() -> Result<SerialNumber, FleetError> {
    let mut serial = random::<16>()?;
    serial[0] &= 0x7f; // positive, as ASN.1 has it
    Ok(SerialNumber::from_slice(&serial))
}

fn moment(unix_s: u64) -> Result<OffsetDateTime, FleetError> {
    let moment = i64::try_from(unix_s).ok().and_then(|unix_s| OffsetDateTime::from_unix_timestamp(unix_s).ok());
    moment.ok_or_else(|| wrong("the clock", "its year has more than four digits"))
}

/// The validity of a certificate issued now.
fn validity(now: u64, days: u64) -> Result<(OffsetDateTime, OffsetDateTime), FleetError> {
    if now < CLOCK_BEGINS {
        return Err(wrong(
            "the clock here",
            format!("it says {}, so that no certificate can be made: set it (timedatectl)", day(now)),
        ));
    }
    Ok((moment(now - BACKDATED_S)?, moment(now + days * DAY_S)?))
}

/// A day of UTC as people write it, such as `2026-11-24`.
pub fn day(unix_s: u64) -> String {
    moment(unix_s)
        .map_or_else(|_| "?".to_owned(), |at| format!("{:04}-{:02}-{:02}", at.year(), u8::from(at.month()), at.day()))
}

/// SHA-256 of some bytes.
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    let mut hash = [0; 32];
    hash.copy_from_slice(digest(&SHA256, bytes).as_ref());
    hash
}

/// The bytes of a certificate in PEM.
///
/// # Errors
/// [`FleetError::Certificate`].
pub fn der_of(pem: &str) -> Result<CertificateDer<'static>, FleetError> {
    CertificateDer::from_pem_slice(pem.as_bytes()).map_err(|error| wrong("the certificate", error))
}

/// The facts of a certificate in PEM.
///
/// # Errors
/// [`FleetError::Certificate`].
pub fn facts(pem: &str) -> Result<Facts, FleetError> {
    facts_of_der(&der_of(pem)?)
}

/// The facts of a certificate.
///
/// # Errors
/// [`FleetError::Certificate`].
pub fn facts_of_der(der: &[u8]) -> Result<Facts, FleetError> {
    let (_, parsed) = X509Certificate::from_der(der).map_err(|error| wrong("the certificate", error))?;
    let common_name = parsed.subject().iter_common_name().next().and_then(|name| name.as_str().ok());
    let names = parsed.subject_alternative_name().ok().flatten();
    let named = |name: &GeneralName<'_>| match name {
        GeneralName::DNSName(name) => Some((*name).to_owned()),
        GeneralName::IPAddress(bytes) => address_of(bytes),
        _ => None,
    };
    let seconds = |moment: i64| u64::try_from(moment).unwrap_or(0);
    Ok(Facts {
        common_name: common_name.unwrap_or_default().to_owned(),
        begins: seconds(parsed.validity().not_before.timestamp()),
        ends: seconds(parsed.validity().not_after.timestamp()),
        names: names.map(|names| names.value.general_names.iter().filter_map(named).collect()).unwrap_or_default(),
        is_ca: parsed.is_ca(),
        key: sha256(parsed.public_key().raw),
    })
}

fn address_of(bytes: &[u8]) -> Option<String> {
    if let Ok(v4) = <[u8; 4]>::try_from(bytes) {
        return Some(core::net::Ipv4Addr::from(v4).to_string());
    }
    <[u8; 16]>::try_from(bytes).ok().map(|v6| core::net::Ipv6Addr::from(v6).to_string())
}

/// Whether a signature of some bytes was made with the key of a certificate (PEM).
///
/// # Errors
/// [`FleetError::Certificate`] for one that cannot be read, or a key of a kind that is not known here.
pub fn verifies(certificate: &str, bytes: &[u8], signature: &[u8]) -> Result<bool, FleetError> {
    let der = der_of(certificate)?;
    let (_, parsed) = X509Certificate::from_der(&der).map_err(|error| wrong("the certificate", error))?;
    let public = parsed.public_key();
    // As rcgen signs with keys of these kinds.
    let algorithm: &'static dyn VerificationAlgorithm = match public.parsed() {
        Ok(PublicKey::EC(point)) if point.key_size() == 256 => &ECDSA_P256_SHA256_ASN1,
        Ok(PublicKey::EC(point)) if point.key_size() == 384 => &ECDSA_P384_SHA384_ASN1,
        Ok(PublicKey::RSA(_)) => &RSA_PKCS1_2048_8192_SHA256,
        Ok(PublicKey::Unknown(_)) if public.subject_public_key.data.len() == 32 => &ED25519,
        _ => return Err(wrong("the authority's certificate", "its key is of a kind that is not known here")),
    };
    Ok(UnparsedPublicKey::new(algorithm, &public.subject_public_key.data).verify(bytes, signature).is_ok())
}

/// A new private key, as PEM (PKCS #8).
///
/// # Errors
/// [`FleetError::NoRandom`].
pub fn new_key() -> Result<String, FleetError> {
    Ok(KeyPair::generate().map_err(|error| FleetError::NoRandom(error.to_string()))?.serialize_pem())
}

fn key_pair(pem: &str, what: &str) -> Result<KeyPair, FleetError> {
    // The error must not show the key.
    KeyPair::from_pem(pem).map_err(|_| {
        wrong(what, "it holds no private key of a kind known here (PKCS #8 in PEM, of P-256, P-384, Ed25519 or RSA; openssl pkcs8 -topk8 -nodes makes that of others)")
    })
}

/// SHA-256 of the public key that belongs to a private one.
///
/// # Errors
/// [`FleetError::Certificate`].
pub fn public_of(key: &str) -> Result<[u8; 32], FleetError> {
    Ok(sha256(&key_pair(key, "the key")?.subject_public_key_info()))
}

/// A certificate request (PKCS #10) for this key. The authority decides on the name.
///
/// # Errors
/// [`FleetError::Certificate`].
pub fn request(key: &str) -> Result<Vec<u8>, FleetError> {
    let mut params = CertificateParams::default();
    params.distinguished_name = rcgen::DistinguishedName::new();
    let made =
        params.serialize_request(&key_pair(key, "the key on board")?).map_err(|error| wrong("the request", error))?;
    Ok(made.der().to_vec())
}

/// The organisation's own authority.
pub struct Ca {
    /// Its certificate, as PEM.
    pub certificate: String,
    issuer: Issuer<'static, KeyPair>,
}

impl Ca {
    /// Creates one; returns its certificate and key as PEM.
    ///
    /// # Errors
    /// [`FleetError::NoRandom`], [`FleetError::Certificate`].
    pub fn make(org: &Name, now: u64) -> Result<(String, String), FleetError> {
        let key = new_key()?;
        let mut params = CertificateParams::default();
        params.serial_number = Some(random_serial()?);
        (params.not_before, params.not_after) = validity(now, CA_DAYS)?;
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, format!("Vencejo fleet {org}"));
        // No intermediate authorities.
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        let made = params.self_signed(&key_pair(&key, "the key")?).map_err(|error| wrong("the authority", error))?;
        Ok((made.pem(), key))
    }

    /// The authority with this certificate and key, which belong together.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn read(certificate: &str, key: &str) -> Result<Self, FleetError> {
        let what = "the authority (CA)";
        let facts = facts(certificate)
            .map_err(|error| wrong(what, format!("its certificate cannot be read ({error}): give it as PEM")))?;
        if !facts.is_ca {
            return Err(wrong(what, "its certificate may not sign others; give the one of an authority"));
        }
        let key = key_pair(key, "the authority's key")?;
        if sha256(&key.subject_public_key_info()) != facts.key {
            return Err(wrong(what, "its certificate and its key do not belong together"));
        }
        let issuer = Issuer::from_ca_cert_pem(certificate, key).map_err(|error| wrong(what, error))?;
        Ok(Self { certificate: certificate.to_owned(), issuer })
    }

    /// A certificate for a ground station or a router, good for these host names and addresses, for a key of ours.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn for_station(&self, common_name: &str, names: &[String], key: &str, now: u64) -> Result<String, FleetError> {
        self.serving(common_name, names, &key_pair(key, "the key")?, now)
    }

    fn serving(
        &self,
        common_name: &str,
        names: &[String],
        key: &impl PublicKeyData,
        now: u64,
    ) -> Result<String, FleetError> {
        if names.len() > MAX_NAMES {
            return Err(wrong(
                "the certificate",
                format!("{} names and addresses are too many: at most {MAX_NAMES}", names.len()),
            ));
        }
        let params = CertificateParams::new(names.to_vec()).map_err(|error| wrong("a host name", error))?;
        // It dials other routers, too.
        let usages = vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
        self.certify(params, common_name, usages, key, now)
    }

    /// A certificate for an aircraft or another ground station, for the key of its request (PKCS #10), which it has.
    /// Other contents of the request are ignored.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn for_member(&self, common_name: &str, request: &[u8], now: u64) -> Result<String, FleetError> {
        let request = CertificateSigningRequestDer::from(request);
        let request =
            CertificateSigningRequestParams::from_der(&request).map_err(|error| wrong("the request", error))?;
        let usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
        self.certify(CertificateParams::default(), common_name, usages, &request.public_key, now)
    }

    /// The same for one that is a router at these host names and addresses as well.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn for_router(
        &self,
        common_name: &str,
        names: &[String],
        request: &[u8],
        now: u64,
    ) -> Result<String, FleetError> {
        let request = CertificateSigningRequestDer::from(request);
        let request =
            CertificateSigningRequestParams::from_der(&request).map_err(|error| wrong("the request", error))?;
        self.serving(common_name, names, &request.public_key, now)
    }

    /// Signs bytes, which begin with a context that no certificate begins with.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn sign(&self, bytes: &[u8]) -> Result<Vec<u8>, FleetError> {
        self.issuer.key().sign(bytes).map_err(|error| wrong("the authority's key", error))
    }

    fn certify(
        &self,
        mut params: CertificateParams,
        common_name: &str,
        usages: Vec<ExtendedKeyUsagePurpose>,
        key: &impl PublicKeyData,
        now: u64,
    ) -> Result<String, FleetError> {
        params.serial_number = Some(random_serial()?);
        (params.not_before, params.not_after) = validity(now, CERTIFICATE_DAYS)?;
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, common_name);
        params.is_ca = IsCa::ExplicitNoCa;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = usages;
        params.use_authority_key_identifier_extension = true;
        let made = params.signed_by(key, &self.issuer).map_err(|error| wrong("the certificate", error))?;
        Ok(made.pem())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: u64 = 1_800_000_000;

    fn name(text: &str) -> Name {
        text.parse().expect("a name")
    }

    #[test]
    fn an_authority_signs_for_the_name_it_chose_and_the_key_that_asked() {
        let (certificate, key) = Ca::make(&name("acme"), NOW).expect("made");
        let ca = Ca::read(&certificate, &key).expect("read");
        let about = facts(&certificate).expect("a certificate");
        assert!(about.is_ca && about.ends == NOW + CA_DAYS * DAY_S);

        let board = new_key().expect("a key");
        let signed = ca.for_member("plane7", &request(&board).expect("made"), NOW).expect("signed");
        let about = facts(&signed).expect("a certificate");
        assert_eq!((about.common_name.as_str(), about.is_ca), ("plane7", false));
        assert_eq!((about.begins, about.ends), (NOW - DAY_S, NOW + 90 * DAY_S));
        assert_eq!(Ok(about.key), public_of(&board));
        assert!(!about.is_due(NOW + 60 * DAY_S) && about.is_due(NOW + 60 * DAY_S + 1));
        assert!(!about.is_due(NOW - DAY_S) && about.is_due(NOW - DAY_S - 1), "nobody believes it yet");

        let names = ["ground.local".to_owned(), "192.168.1.2".to_owned(), "fe80::1".to_owned()];
        let signed = ca.for_station("_ground", &names, &key, NOW).expect("signed");
        assert_eq!(facts(&signed).expect("a certificate").names, names);
    }

    #[test]
    fn what_an_authority_of_any_kind_signs_is_known_to_be_its_own() {
        for kind in [&rcgen::PKCS_ECDSA_P256_SHA256, &rcgen::PKCS_ECDSA_P384_SHA384, &rcgen::PKCS_ED25519] {
            let key = KeyPair::generate_for(kind).expect("a key");
            let certificate = CertificateParams::default().self_signed(&key).expect("made").pem();
            let signature = key.sign(b"these bytes").expect("signed");
            assert_eq!(verifies(&certificate, b"these bytes", &signature), Ok(true), "{kind:?}");
            assert_eq!(verifies(&certificate, b"those bytes", &signature), Ok(false), "{kind:?}");
        }
    }

    #[test]
    fn a_computer_that_does_not_know_the_time_signs_nothing() {
        let error = Ca::make(&name("acme"), 86_400).expect_err("1970").to_string();
        assert!(error.contains("it says 1970-01-02") && error.contains("timedatectl"), "{error}");
        assert_eq!((day(NOW), day(u64::MAX)), ("2027-01-15".to_owned(), "?".to_owned()));
    }

    #[test]
    fn what_cannot_be_an_authority_is_told() {
        let (certificate, key) = Ca::make(&name("acme"), NOW).expect("made");
        let (_, other) = Ca::make(&name("acme"), NOW).expect("made");
        let ca = Ca::read(&certificate, &key).expect("read");
        let leaf = ca.for_station("_ground", &[], &key, NOW).expect("signed");
        for (certificate, key, says) in [
            (certificate.as_str(), other.as_str(), "belong together"),
            (leaf.as_str(), key.as_str(), "may not sign"),
            ("nonsense", key.as_str(), "certificate"),
            (certificate.as_str(), "nonsense", "no private key"),
        ] {
            let error = Ca::read(certificate, key).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(says), "{error}");
            assert!(!error.contains("nonsense"), "what was given is not shown: {error}");
        }
    }

    #[test]
    fn a_request_that_is_not_signed_by_its_key_is_refused() {
        let (certificate, key) = Ca::make(&name("acme"), NOW).expect("made");
        let ca = Ca::read(&certificate, &key).expect("read");
        let mut asked = request(&new_key().expect("a key")).expect("made");
        assert!(ca.for_member("plane7", &[], NOW).is_err());
        let last = asked.len() - 1;
        asked[last] ^= 1;
        assert!(ca.for_member("plane7", &asked, NOW).is_err());
    }
}
