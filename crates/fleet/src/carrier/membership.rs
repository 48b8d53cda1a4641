//! The membership of an aircraft, or of a ground station without the authority: one file, readable by its owner only;
//! joining and renewal.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::net::TcpStream;
use tokio_rustls::client::TlsStream;
use vencejo_store::lock;
use vencejo_store::{Access, Lock};

use super::door::{blocking, read_message, write_message};
use super::endpoint::{Endpoint, Transport, host_of};
use super::handshake::{self, PATIENCE, REFUSAL};
use super::tls::{self, Fault, Known};
use super::unix_now;
use crate::authority::Role;
use crate::error::FleetError;
use crate::key::Name;
use crate::papers::access::{self, LetIn};
use crate::papers::certificate::{Facts, Identity, STATION_PREFIX, der_of, facts, new_key, public_of, request, sha256};
use crate::papers::stations::{Admitted, Stations};
use crate::papers::ticket::Ticket;
use crate::papers::wire::{Asked, BAD_REQUEST, Given};
use crate::payload::VERSION;
use crate::signature::PublicKey;

/// How long a router may hang up: a ground station opens its router anew when somebody was enrolled or revoked.
const RESTART: Duration = Duration::from_secs(3);
/// The pause before it is tried again.
const AGAIN: Duration = Duration::from_millis(50);
/// The version of the file.
const FILE_VERSION: u32 = 2;

/// The membership of an aircraft or a ground station in a fleet.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Membership {
    version: u32,
    org: String,
    /// The common name of the certificate.
    name: String,
    ca: String,
    certificate: String,
    key: String,
    /// The newest signed list of ground stations, in base64.
    stations: String,
    /// The newest signed list of aircraft that routers admit, in base64, if it is a router.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    admitted: String,
    /// SHA-256 of the secret of its token, so that the same command may be run again.
    token: String,
}

impl std::fmt::Debug for Membership {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Membership({}/{})", self.org, self.name)
    }
}

impl Membership {
    /// Reads a file; `None` if there is none.
    ///
    /// # Errors
    /// [`FleetError::File`].
    pub fn read(file: &Path) -> Result<Option<Self>, FleetError> {
        let bad = |problem: String| FleetError::File { path: file.display().to_string(), problem };
        let text = match vencejo_store::read_small_text(file) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(bad(error.to_string())),
        };
        // Its content is not shown: it has a key.
        let damaged = || bad("it is damaged; join the fleet again with a new token".to_owned());
        let read: Value = serde_json::from_str(&text).map_err(|_| damaged())?;
        let version = read["version"].as_u64().ok_or_else(damaged)?;
        if version != u64::from(FILE_VERSION) {
            return Err(bad(format!(
                "it is of version {version}, this program knows {FILE_VERSION}: join the fleet again with a new token"
            )));
        }
        serde_json::from_value(read).map(Some).map_err(|_| damaged())
    }

    fn write(&self, file: &Path) -> Result<(), FleetError> {
        let bytes = serde_json::to_vec_pretty(self).expect("invariant: texts and numbers are JSON");
        vencejo_store::write(file, &bytes, Access::Owner)
            .map_err(|error| FleetError::File { path: file.display().to_string(), problem: error.to_string() })
    }

    /// The organisation.
    ///
    /// # Errors
    /// [`FleetError::Name`].
    pub fn org(&self) -> Result<Name, FleetError> {
        Ok(self.org.parse()?)
    }

    /// Its name there.
    ///
    /// # Errors
    /// [`FleetError::Name`].
    pub fn name(&self) -> Result<Name, FleetError> {
        Ok(self.name.strip_prefix(STATION_PREFIX).unwrap_or(&self.name).parse()?)
    }

    /// Whether it is a ground station.
    pub fn is_station(&self) -> bool {
        self.name.starts_with(STATION_PREFIX)
    }

    /// The newest signed list of ground stations.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn signed_stations(&self) -> Result<Vec<u8>, FleetError> {
        STANDARD
            .decode(&self.stations)
            .map_err(|_| FleetError::Refused("its list of ground stations is damaged".into()))
    }

    /// That list.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn stations(&self) -> Result<Stations, FleetError> {
        Stations::read(&self.signed_stations()?, &self.ca, &self.org)
    }

    /// The routers, in the order in which they are tried.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn routers(&self) -> Result<Vec<Endpoint>, FleetError> {
        let dialled = |router: &String| router.parse::<Endpoint>().and_then(Endpoint::dialled).ok();
        // Addresses of kinds that a later version has are skipped.
        Ok(self
            .stations()?
            .routers
            .iter()
            .filter_map(dialled)
            .filter(|router| router.transport() != Transport::Tcp)
            .collect())
    }

    /// The ground stations whose orders count, with their roles.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn roles(&self) -> Result<BTreeMap<PublicKey, Role>, FleetError> {
        Ok(self.stations()?.roles())
    }

    /// The doors at which its certificate is renewed.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn doors(&self) -> Result<Vec<String>, FleetError> {
        Ok(self.stations()?.doors)
    }

    /// Its own role, if it is a listed ground station.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn role(&self) -> Result<Option<Role>, FleetError> {
        let (name, list) = (self.name()?, self.stations()?);
        let own = list.stations.iter().find(|each| self.is_station() && each.name == name.as_str());
        Ok(own.and_then(|own| Role::named(&own.role)))
    }

    /// Its own addresses as a router; empty unless it was enrolled as one.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn serves(&self) -> Result<Vec<Endpoint>, FleetError> {
        let (name, list) = (self.name()?, self.stations()?);
        let own = list.stations.iter().filter(|each| self.is_station() && each.name == name.as_str());
        Ok(own.flat_map(|own| &own.routers).filter_map(|router| router.parse().ok()).collect())
    }

    /// The signed list of aircraft that routers admit, and its number; `None` before it has one.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub(super) fn admitted(&self) -> Result<Option<(Admitted, Vec<u8>)>, FleetError> {
        if self.admitted.is_empty() {
            return Ok(None);
        }
        let damaged = |_| FleetError::Refused("its list of aircraft is damaged".into());
        let signed = STANDARD.decode(&self.admitted).map_err(damaged)?;
        Ok(Some((Admitted::read(&signed, &self.ca, &self.org)?, signed)))
    }

    /// The access control of its router.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub(super) fn access(&self) -> Result<Value, FleetError> {
        let aircraft = self.admitted()?.map(|(list, _)| list.aircraft).unwrap_or_default();
        let let_in = LetIn { aircraft, ..self.stations()?.let_in(self.name()?.as_str()) };
        Ok(access::control(&self.org()?, &let_in))
    }

    /// Stores a received list of aircraft if it is valid and newer.
    fn take_admitted(&mut self, signed: &[u8]) -> Result<bool, FleetError> {
        let list = Admitted::read(signed, &self.ca, &self.org)?;
        if self.admitted()?.is_some_and(|(ours, _)| list.number <= ours.number) {
            return Ok(false);
        }
        self.admitted = STANDARD.encode(signed);
        Ok(true)
    }

    /// Stores a received list of ground stations if it is valid and newer.
    ///
    /// # Errors
    /// [`FleetError::Refused`] for an invalid one.
    pub fn take(&mut self, signed: &[u8]) -> Result<bool, FleetError> {
        let list = Stations::read(signed, &self.ca, &self.org)?;
        if list.number <= self.stations()?.number {
            return Ok(false);
        }
        self.stations = STANDARD.encode(signed);
        Ok(true)
    }

    /// Writes this to its file with the newer list of both, if the membership there is still of the same token: a new
    /// enrolment by another program is not undone.
    pub(super) fn keep(mut self, file: &Path) -> Result<Self, FleetError> {
        let problem =
            |error: io::Error| FleetError::File { path: file.display().to_string(), problem: error.to_string() };
        let _lock = Lock::of(file, lock::PATIENCE).map_err(problem)?;
        match Self::read(file)? {
            Some(now) if now.token == self.token => {
                self.take(&now.signed_stations()?)?;
                if let Some((_, signed)) = now.admitted()? {
                    self.take_admitted(&signed)?;
                }
                self.write(file)?;
                Ok(self)
            }
            _ => Err(FleetError::Refused("this computer has joined anew since; start it again".into())),
        }
    }

    /// Writes a newer list of ground stations to the file, and keeps the certificate there.
    pub(super) fn keep_stations(file: &Path, signed: &[u8]) -> Result<(), FleetError> {
        Self::keep_list(file, |member| member.take(signed))
    }

    /// The same for the list of aircraft that routers admit.
    pub(super) fn keep_admitted(file: &Path, signed: &[u8]) -> Result<(), FleetError> {
        Self::keep_list(file, |member| member.take_admitted(signed))
    }

    fn keep_list(file: &Path, take: impl FnOnce(&mut Self) -> Result<bool, FleetError>) -> Result<(), FleetError> {
        let problem =
            |error: io::Error| FleetError::File { path: file.display().to_string(), problem: error.to_string() };
        let _lock = Lock::of(file, lock::PATIENCE).map_err(problem)?;
        let Some(mut now) = Self::read(file)? else { return Ok(()) };
        if take(&mut now)? { now.write(file) } else { Ok(()) }
    }

    /// Its identity.
    pub fn identity(&self) -> Identity {
        Identity { ca: self.ca.clone(), certificate: self.certificate.clone(), key: self.key.clone() }
    }

    /// The facts of its certificate.
    ///
    /// # Errors
    /// [`FleetError::Certificate`].
    pub fn facts(&self) -> Result<Facts, FleetError> {
        facts(&self.certificate)
    }

    /// Validates the answer of a door.
    fn of(
        given: Given,
        key: String,
        ca: Option<&str>,
        fingerprint: Option<&[u8]>,
        token: String,
    ) -> Result<Self, FleetError> {
        let wrong =
            |why: &str| FleetError::Refused(format!("its answer makes no sense ({why}); update Vencejo on both sides"));
        let Given { org, name, certificate, ca: theirs, stations, .. } = given;
        let is_known = ca.is_none_or(|ours| ours == theirs)
            && fingerprint.is_none_or(|ours| der_of(&theirs).is_ok_and(|der| sha256(&der) == ours));
        if !is_known {
            return Err(wrong("another authority"));
        }
        let stations = STANDARD.encode(stations);
        let admitted = String::new();
        let made = Self { version: FILE_VERSION, org, name, ca: theirs, certificate, key, stations, admitted, token };
        made.name()?;
        let facts = made.facts()?;
        if facts.common_name != made.name || facts.key != public_of(&made.key)? {
            return Err(wrong("the certificate is not for us"));
        }
        if made.routers()?.is_empty() {
            return Err(wrong("no router"));
        }
        made.org()?;
        Ok(made)
    }
}

/// Joins a fleet with a token and stores the membership in a file; a ground station passes the key that it signs orders
/// with. Joining again with the same token is a no-op; after a lost answer the same key is used again. Returns whether
/// it was joined now.
///
/// # Errors
/// [`FleetError::Token`], [`FleetError::Refused`], [`FleetError::Network`], [`FleetError::File`].
pub async fn join(token: &str, file: &Path, operator: Option<PublicKey>) -> Result<(Membership, bool), FleetError> {
    let ticket: Ticket = token.parse()?;
    if ticket.is_station != operator.is_some() {
        return Err(FleetError::TokenFor(match ticket.is_station {
            true => "a ground station: vencejo serve --join TOKEN",
            false => "an aircraft: vencejo onboard --join TOKEN",
        }));
    }
    let hash = ticket.hash();
    let path = file.to_owned();
    // A damaged file is replaced.
    let before = blocking(move || Ok(Membership::read(&path).ok().flatten())).await?;
    if let Some(member) = before.filter(|member| member.token == hash) {
        return Ok((member, false));
    }
    let key_file = file.with_extension("joining");
    let path = key_file.clone();
    let key = blocking(move || {
        let bad = |error: io::Error| FleetError::File { path: path.display().to_string(), problem: error.to_string() };
        // Stored before it is used, so that a lost answer can be requested again with the same key.
        vencejo_store::create(&path, new_key()?.as_bytes(), Access::Owner).map_err(bad)?;
        vencejo_store::read_small_text(&path).map_err(bad)
    })
    .await?;
    let fingerprint: [u8; 32] =
        ticket.fingerprint.as_slice().try_into().map_err(|_| FleetError::Token("it is of another version".into()))?;
    let operator = operator.map(|key| key.0.to_vec()).unwrap_or_default();
    let asked = Asked { version: VERSION, secret: ticket.secret.clone(), request: request(&key)?, operator };
    let given = ask_one_of(&ticket.doors, &Known::Fingerprint(fingerprint), None, &asked).await?;
    let member = Membership::of(given, key, None, Some(&fingerprint), hash)?;
    let (kept, path) = (member.clone(), file.to_owned());
    blocking(move || {
        kept.write(&path)?;
        // It is in the file now; left behind, it would be used for the next token.
        let _ = std::fs::remove_file(&key_file);
        Ok(())
    })
    .await?;
    Ok((member, true))
}

fn nothing() -> Asked {
    Asked { version: VERSION, ..Asked::default() }
}

/// Requests the next certificate, for a new key, with the present one; the file gets both or neither.
///
/// # Errors
/// [`FleetError::Refused`], [`FleetError::Network`], [`FleetError::File`].
pub async fn renew(member: &Membership, file: &Path) -> Result<Membership, FleetError> {
    let key = new_key()?;
    let asked = Asked { request: request(&key)?, ..nothing() };
    let identity = member.identity();
    let given = ask_one_of(&member.doors()?, &Known::Ca(member.ca.clone()), Some(&identity), &asked).await?;
    let renewed = Membership::of(given, key, Some(&member.ca), None, member.token.clone())?;
    if (&renewed.org, &renewed.name) != (&member.org, &member.name) {
        return Err(FleetError::Refused("it gave somebody else's certificate".into()));
    }
    let path = file.to_owned();
    blocking(move || renewed.keep(&path)).await
}

/// Checks whether the next certificate would be issued. None is issued, and nothing changes.
///
/// # Errors
/// The reason, as text.
pub async fn standing(member: &Membership) -> Result<(), String> {
    let asked = nothing();
    let (known, identity) = (Known::Ca(member.ca.clone()), member.identity());
    let doors = member.doors().map_err(|error| error.to_string())?;
    match ask_one_of(&doors, &known, Some(&identity), &asked).await {
        Err(FleetError::Refused(why)) if why == BAD_REQUEST => Ok(()),
        Err(error) => Err(error.to_string()),
        Ok(_) => Err("it gave a certificate for nothing".to_owned()),
    }
}

/// How far an attempt at a door came. Of several, the fault of the one that came furthest is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Came {
    /// Its name has no address here: mostly one of several names of the same computer.
    Nowhere,
    /// Nobody answered there.
    Unanswered,
    /// A peer was there, with a wrong certificate for instance.
    There,
}

/// Tries each door until one answers.
async fn ask_one_of(
    doors: &[String],
    known: &Known,
    identity: Option<&Identity>,
    asked: &Asked,
) -> Result<Given, FleetError> {
    let mut furthest: Option<(Came, FleetError)> = None;
    for door in doors {
        match ask(door, known, identity, asked).await {
            Ok(given) => return Ok(given),
            Err((_, error @ FleetError::Refused(_))) => return Err(error),
            Err((came, error)) => {
                if furthest.as_ref().is_none_or(|(before, _)| came > *before) {
                    furthest = Some((came, error));
                }
            }
        }
    }
    Err(furthest.map_or_else(|| FleetError::Token("it names no address".into()), |(_, error)| error))
}

/// Asks a door.
async fn ask(
    door: &str,
    known: &Known,
    identity: Option<&Identity>,
    asked: &Asked,
) -> Result<Given, (Came, FleetError)> {
    let mut stream = connect(door, known, identity)
        .await
        .map_err(|(came, problem)| (came, FleetError::Network { address: door.to_owned(), problem }))?;
    let talk = async {
        write_message(&mut stream, asked).await?;
        read_message::<Given>(&mut stream).await
    };
    let host = host_of(door).unwrap_or(door);
    let heard = tokio::time::timeout(2 * PATIENCE, talk).await.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()));
    let given = heard.map_err(|error| {
        let problem = Fault::from(&error).in_a_fleet(host, unix_now());
        (Came::There, FleetError::Network { address: door.to_owned(), problem })
    })?;
    given.checked().map_err(|error| (Came::There, error))
}

/// Performs a handshake with `HOST:PORT`. An error has whether a peer was there, and the reason as text.
async fn connect(
    address: &str,
    known: &Known,
    identity: Option<&Identity>,
) -> Result<TlsStream<TcpStream>, (Came, String)> {
    let config = tls::client(known.clone(), identity).map_err(|error| (Came::Nowhere, error.to_string()))?;
    let host = host_of(address).ok_or_else(|| (Came::Nowhere, "this is no address: one is HOST:PORT".to_owned()))?;
    let stream = handshake::begin(address, config).await;
    stream.map_err(|(is_there, fault)| {
        let came = match fault {
            _ if is_there => Came::There,
            Fault::NoAddress => Came::Nowhere,
            _ => Came::Unanswered,
        };
        (came, fault.in_a_fleet(host, unix_now()))
    })
}

/// Checks whether a router, or a door over TLS, admits us.
///
/// # Errors
/// The reason, as text.
pub async fn try_address(router: &Endpoint, identity: &Identity) -> Result<(), String> {
    refusal(router, Known::Ca(identity.ca.clone()), Some(identity), REFUSAL).await
}

/// Performs a handshake and waits for a refusal. An error has the reason as text.
pub(super) async fn refusal(
    router: &Endpoint,
    known: Known,
    identity: Option<&Identity>,
    wait: Duration,
) -> Result<(), String> {
    let config = tls::client(known, identity).map_err(|error| error.to_string())?;
    let (began, mut hung_up) = (Instant::now(), false);
    loop {
        let tried = handshake::refusal(router.transport(), &router.authority(), config.clone(), wait).await;
        hung_up |= tried == Err(Fault::HangsUp);
        let may_restart = hung_up && matches!(tried, Err(Fault::HangsUp | Fault::NobodyListens));
        if !may_restart || began.elapsed() >= RESTART {
            return tried.map_err(|fault| fault.in_a_fleet(router.host(), unix_now()));
        }
        tokio::time::sleep(AGAIN).await;
    }
}
