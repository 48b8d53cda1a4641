//! Where a router of ROS 2 is, how it is reached, and what keeps us from it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rustls::ClientConfig;
use zenoh::Session;

use crate::carrier::endpoint::{Endpoint, Transport};
use crate::carrier::handshake::{self, REFUSAL};
use crate::carrier::network::{self, Papers, Part};
use crate::carrier::tls::{self, Fault, Known};
use crate::carrier::unix_now;
use crate::error::FleetError;
use crate::papers::certificate::{Identity, facts};
use crate::ros2::name::BadRosName;

/// How long a router is waited for.
const CONNECT: Duration = Duration::from_secs(3);
/// How long a handshake is waited for before it is tried whether somebody speaks in the clear there: who does answers
/// none.
const SILENT: Duration = Duration::from_millis(500);
/// Until one that has hung up is tried again.
const AGAIN: Duration = Duration::from_millis(300);
/// The largest `ROS_DOMAIN_ID`.
const MAX_DOMAIN: u32 = 232;
/// What a doctor calls it when nobody is there that speaks Zenoh.
const NO_ROUTER: &str = "no-router";

/// Files with what is believed of a router and shown to it, as PEM; and what may go without.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosPapers {
    /// Certificates of the authorities by which it is known.
    pub ca: Option<PathBuf>,
    /// A certificate that it is shown, with those between it and the authority.
    pub certificate: Option<PathBuf>,
    /// Its private key.
    pub key: Option<PathBuf>,
    /// Whether a router of another machine may be reached in the clear.
    pub is_plain_meant: bool,
}

/// Where a router of ROS 2 is, and what is believed of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosRouter {
    at: Endpoint,
    ca: Option<String>,
    own: Option<Identity>,
}

impl RosRouter {
    /// A router at `tcp/HOST:PORT`, `tls/…` or `quic/…`. The files are read now, and once.
    ///
    /// # Errors
    /// [`FleetError::RosRouter`] for what is no address, [`FleetError::RosPlain`] for one in the clear elsewhere that
    /// is not meant, [`FleetError::RosPapers`] for files that are missing or too many, [`FleetError::File`] for one
    /// that cannot be used.
    pub fn new(address: &str, papers: &RosPapers) -> Result<Self, FleetError> {
        let at = Endpoint::of_ros(address)?;
        let wrong = |problem| FleetError::RosPapers { address: at.to_string(), problem };
        let RosPapers { ca, certificate, key, is_plain_meant } = papers;
        if at.transport() == Transport::Tcp {
            return match (ca, certificate, key) {
                (None, None, None) if at.is_here() || *is_plain_meant => Ok(Self { at, ca: None, own: None }),
                (None, None, None) => Err(FleetError::RosPlain(at.to_string())),
                _ => Err(wrong("certificates are for tls/ and quic/, and this is in the clear")),
            };
        }
        let ca_file = ca.as_deref().ok_or_else(|| {
            wrong("who answers there is known by the certificate of an authority: give its file with --ros2-ca")
        })?;
        let ca = read(ca_file)?;
        tls::client(Known::Ca(ca.clone()), None)
            .map_err(|_| of_file(ca_file, "there is no certificate in it, as PEM"))?;
        let own = match (certificate, key) {
            (None, None) => None,
            (Some(certificate), Some(key)) => Some(own(&ca, certificate, key)?),
            (Some(_), None) => return Err(wrong("--ros2-cert needs its private key: give its file with --ros2-key")),
            (None, Some(_)) => return Err(wrong("--ros2-key needs its certificate: give its file with --ros2-cert")),
        };
        Ok(Self { at, ca: Some(ca), own })
    }

    /// Whether it is on this machine.
    pub(super) fn is_here(&self) -> bool {
        self.at.is_here()
    }

    async fn enter(&self, at: Endpoint) -> Result<Session, FleetError> {
        let papers = self.ca.as_deref().map(|ca| Papers { ca, own: self.own.as_ref() });
        network::join(Part::Client(std::slice::from_ref(&at), CONNECT), papers).await
    }

    /// Whether it lets us in over TLS, and is believed. Zenoh alone would say only that it did not come about.
    async fn encrypted(&self) -> Result<(), FleetError> {
        let ca = Known::Ca(self.ca.clone().unwrap_or_default());
        let (config, authority) = (tls::client(ca, self.own.as_ref())?, self.at.authority());
        let in_the_clear = || {
            let problem =
                "it speaks in the clear, and this is TLS: give it a certificate and an address tls/ in its settings";
            self.unreached("tls-missing", problem.to_owned())
        };
        tokio::select! {
            tried = self.handshake(&authority, config) => match tried {
                Err(Fault::HangsUp | Fault::NoTls) if self.speaks_in_the_clear().await => Err(in_the_clear()),
                tried => tried.map_err(|fault| self.why(&fault)),
            },
            true = async { tokio::time::sleep(SILENT).await; self.speaks_in_the_clear().await } => Err(in_the_clear()),
        }
    }

    /// A handshake; a second one with a router that hangs up without a reason, as one does that starts or is busy.
    async fn handshake(&self, authority: &str, config: Arc<ClientConfig>) -> Result<(), Fault> {
        let tried = || handshake::refusal(self.at.transport(), authority, config.clone(), REFUSAL);
        match tried().await {
            Err(Fault::HangsUp) => {
                tokio::time::sleep(AGAIN).await;
                tried().await
            }
            ended => ended,
        }
    }

    async fn speaks_in_the_clear(&self) -> bool {
        let Ok(session) = self.enter(self.at.by(Transport::Tcp)).await else { return false };
        // What it declared ends with it, whatever it says.
        let _ = session.close().await;
        true
    }

    async fn speaks_tls(&self) -> Result<bool, FleetError> {
        let tried = handshake::refusal(Transport::Tls, &self.at.authority(), tls::stranger()?, REFUSAL).await;
        Ok(tried.map_or_else(|fault| is_of_tls(&fault), |()| true))
    }

    fn why(&self, fault: &Fault) -> FleetError {
        let (code, what_to_do) = named(fault);
        self.unreached(code, fault.plainly(self.at.host(), unix_now()) + what_to_do)
    }

    fn unreached(&self, code: &'static str, problem: String) -> FleetError {
        FleetError::RosUnreached { address: self.at.to_string(), code, problem }
    }
}

impl fmt::Display for RosRouter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.at.fmt(f)
    }
}

fn of_file(file: &Path, problem: impl fmt::Display) -> FleetError {
    FleetError::File { path: file.display().to_string(), problem: problem.to_string() }
}

fn read(file: &Path) -> Result<String, FleetError> {
    vencejo_store::read_small_text(file).map_err(|error| of_file(file, format!("it cannot be read: {error}")))
}

/// A certificate with its key, which belong together.
fn own(ca: &str, certificate: &Path, key: &Path) -> Result<Identity, FleetError> {
    let own = Identity { ca: ca.to_owned(), certificate: read(certificate)?, key: read(key)? };
    facts(&own.certificate).map_err(|_| of_file(certificate, "there is no certificate in it, as PEM"))?;
    if !tls::has_key(&own) {
        return Err(of_file(key, "there is no private key in it, as PEM and without a password"));
    }
    let usable = tls::client(Known::Ca(ca.to_owned()), Some(&own));
    usable.map_err(|_| {
        of_file(key, format!("it is not the key of {}, or of a kind not known here", certificate.display()))
    })?;
    Ok(own)
}

/// Refuses a domain that cannot be.
pub(super) fn check_domain(domain: u32) -> Result<(), FleetError> {
    if domain > MAX_DOMAIN { Err(BadRosName::Domain(domain).into()) } else { Ok(()) }
}

/// A name for what keeps us from a router that speaks TLS, or should; and what to do, where there is more to say than
/// what it is.
fn named(fault: &Fault) -> (&'static str, &'static str) {
    match fault {
        Fault::NobodyListens => (
            NO_ROUTER,
            ": start one there, such as `ros2 run rmw_zenoh_cpp rmw_zenohd`, or name another with --ros2-router",
        ),
        Fault::Stranger | Fault::OtherAuthority => {
            ("other-authority", " than those of --ros2-ca: give the file of the one that signed it")
        }
        Fault::OtherName => {
            ("other-name", ": dial it by a name or an address that is in it, or have one made for this")
        }
        Fault::Ended | Fault::NotYet => ("certificate-ended", ""),
        Fault::OursEnded => ("own-certificate-ended", ""),
        Fault::WantsOurs => ("certificate-wanted", ": give one that its authority signed, --ros2-cert and --ros2-key"),
        Fault::RefusesOurs => ("certificate-refused", " than those that it believes: give another with --ros2-cert"),
        Fault::Certificate(_) | Fault::Alert(_) => ("tls-failed", ""),
        Fault::NoAddress
        | Fault::Silent
        | Fault::SilentUdp
        | Fault::SilentUdpAt(_)
        | Fault::HangsUp
        | Fault::NoTls
        | Fault::Other(_) => (NO_ROUTER, ""),
    }
}

/// Whether one who speaks TLS can be at fault so.
fn is_of_tls(fault: &Fault) -> bool {
    !matches!(fault, Fault::Other(_)) && named(fault).0 != NO_ROUTER
}

/// Joins the network of a router; in plain words why not.
pub(super) async fn open(router: &RosRouter) -> Result<Session, FleetError> {
    let tried = match router.at.transport() {
        Transport::Tcp => handshake::reach(&router.at.authority()).await.map(drop).map_err(|fault| router.why(&fault)),
        Transport::Tls | Transport::Quic => router.encrypted().await,
    };
    tried?;
    match router.enter(router.at.clone()).await {
        Ok(session) => Ok(session),
        Err(_) if router.at.transport() == Transport::Tcp && router.speaks_tls().await? => {
            let problem = "it speaks TLS, and this is in the clear: use tls/ in place of tcp/, with --ros2-ca";
            Err(router.unreached("tls-spoken", problem.to_owned()))
        }
        Err(error) => {
            Err(router.unreached(NO_ROUTER, format!("something answers there that is not a Zenoh 1 router ({error})")))
        }
    }
}
