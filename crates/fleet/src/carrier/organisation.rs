//! A fleet's folder on the ground: its authority (CA), the ground station's certificate, and the roll. Readable by its
//! owner only.

use std::path::{Path, PathBuf};

use serde_json::Value;
use vencejo_store::{Access, Lock, lock::PATIENCE};

use super::CONTROL_QUEUE;
use super::endpoint::{Endpoint, Transport, bracketed, split};
use crate::error::FleetError;
use crate::key::Name;
use crate::operator::random;
use crate::papers::access::{self, LetIn};
use crate::papers::certificate::{Ca, Facts, Identity, STATION_PREFIX, der_of, facts, new_key, sha256};
use crate::papers::roll::{Newcomer, Roll};
use crate::papers::stations::{GROUND, MAX_ROUTERS};
use crate::papers::ticket::{MAX_DOORS, SECRET_LEN, Ticket};
use crate::papers::wire;
use crate::signature::PublicKey;

/// The default address of the door.
pub const DOOR_PORT: u16 = 7448;
/// Loopback names: certificates have them for programs on this machine; aircraft do not get them.
const HERE: [&str; 2] = ["127.0.0.1", "localhost"];

/// The folder of one organisation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Organisation {
    org: Name,
    folder: PathBuf,
}

/// The result of [`Organisation::init`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// Whether the authority was made now.
    pub authority: bool,
    /// Host names and addresses that are new in the ground station's certificate.
    pub hosts: Vec<String>,
}

impl Organisation {
    /// The organisation of this name below a folder, whether or not it exists.
    pub fn below(folder: &Path, org: Name) -> Self {
        let folder = folder.join(org.as_str());
        Self { org, folder }
    }

    /// Whether it exists.
    pub fn exists(&self) -> bool {
        self.path("roll.json").is_file()
    }

    /// Its name.
    pub fn org(&self) -> &Name {
        &self.org
    }

    /// One of its files.
    pub(super) fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// The common name of the ground station here.
    pub fn station() -> String {
        format!("{STATION_PREFIX}{GROUND}")
    }

    /// Creates the authority if there is none, of a given certificate and key (PEM) or new; and adds hosts. Idempotent.
    ///
    /// # Errors
    /// [`FleetError::Certificate`] for an invalid authority, [`FleetError::Host`] for an invalid host,
    /// [`FleetError::File`].
    pub fn init(&self, hosts: &[String], given: Option<(String, String)>, now: u64) -> Result<Made, FleetError> {
        for host in hosts {
            // Without brackets, as in a certificate.
            if host.parse::<std::net::Ipv6Addr>().is_err() && split(&format!("{host}:1")).is_none() {
                return Err(FleetError::Host(vencejo_proto::plain(host, 80)));
            }
        }
        let _lock = self.lock()?;
        if self.exists() {
            let is_other =
                given.is_some_and(|(certificate, _)| self.read("ca.crt").is_ok_and(|ours| ours != certificate));
            if is_other {
                let problem = "another authority (CA) is there already, and aircraft may trust it: remove the folder to begin anew".to_owned();
                return Err(FleetError::File { path: self.folder.display().to_string(), problem });
            }
            let mut roll = self.roll()?;
            let new: Vec<_> = hosts.iter().filter(|host| !roll.hosts.contains(host)).cloned().collect();
            if !new.is_empty() {
                roll.hosts.extend(new.iter().cloned());
                let ca = self.ca()?;
                self.certify(&ca, &roll.hosts, &self.read("station.key")?, now)?;
                self.write("roll.json", &roll.bytes())?;
            }
            return Ok(Made { authority: false, hosts: new });
        }
        let (certificate, key) = match given {
            Some(given) => given,
            None => Ca::make(&self.org, now)?,
        };
        let ca = Ca::read(&certificate, &key)?;
        self.write("ca.key", key.as_bytes())?;
        self.write("ca.crt", certificate.as_bytes())?;
        let own = new_key()?;
        self.write("station.key", own.as_bytes())?;
        let mut all = hosts.to_vec();
        all.extend(HERE.iter().map(|here| (*here).to_owned()).filter(|here| !hosts.contains(here)));
        self.certify(&ca, &all, &own, now)?;
        // The roll last: it marks the folder as complete.
        self.write("roll.json", &Roll::new(all.clone()).bytes())?;
        Ok(Made { authority: true, hosts: all })
    }

    fn certify(&self, ca: &Ca, hosts: &[String], key: &str, now: u64) -> Result<(), FleetError> {
        self.write("station.crt", ca.for_station(&Self::station(), hosts, key, now)?.as_bytes())
    }

    fn lock(&self) -> Result<Lock, FleetError> {
        let path = self.path("roll.json");
        Lock::of(&path, PATIENCE)
            .map_err(|error| FleetError::File { path: path.display().to_string(), problem: error.to_string() })
    }

    pub(super) fn read(&self, file: &str) -> Result<String, FleetError> {
        let path = self.path(file);
        vencejo_store::read_small_text(&path)
            .map_err(|error| FleetError::File { path: path.display().to_string(), problem: error.to_string() })
    }

    fn write(&self, file: &str, bytes: &[u8]) -> Result<(), FleetError> {
        let path = self.path(file);
        vencejo_store::write(&path, bytes, Access::Owner)
            .map_err(|error| FleetError::File { path: path.display().to_string(), problem: error.to_string() })
    }

    fn ca(&self) -> Result<Ca, FleetError> {
        Ca::read(&self.read("ca.crt")?, &self.read("ca.key")?)
    }

    /// The facts of the authority's and the ground station's certificates.
    ///
    /// # Errors
    /// [`FleetError::File`], [`FleetError::Certificate`].
    pub fn facts(&self) -> Result<(Facts, Facts), FleetError> {
        Ok((facts(&self.read("ca.crt")?)?, facts(&self.read("station.crt")?)?))
    }

    /// The roll.
    ///
    /// # Errors
    /// [`FleetError::File`].
    pub fn roll(&self) -> Result<Roll, FleetError> {
        let text = self.read("roll.json")?;
        let path = self.path("roll.json").display().to_string();
        Roll::read(text.as_bytes()).map_err(|problem| FleetError::File { path, problem })
    }

    /// The list of ground stations as it is now, signed.
    ///
    /// # Errors
    /// [`FleetError::File`], [`FleetError::Certificate`], [`FleetError::Refused`] if it is too long.
    pub(super) fn stations(&self) -> Result<Vec<u8>, FleetError> {
        self.roll()?.stations(&self.org).signed(&self.ca()?)
    }

    /// Changes the roll; nothing is stored on failure.
    ///
    /// # Errors
    /// [`FleetError::File`], and the error of `change`.
    pub fn change<T>(&self, change: impl FnOnce(&mut Roll) -> Result<T, FleetError>) -> Result<T, FleetError> {
        let _lock = self.lock()?;
        let before = self.roll()?;
        let mut roll = before.clone();
        let value = change(&mut roll)?;
        roll.number_after(&before, &self.org, super::unix_now());
        if roll != before {
            self.write("roll.json", &roll.bytes())?;
        }
        Ok(value)
    }

    /// The ground station's identity, renewed if due.
    ///
    /// # Errors
    /// [`FleetError::File`], [`FleetError::Certificate`].
    pub fn identity(&self, now: u64) -> Result<Identity, FleetError> {
        if facts(&self.read("station.crt")?)?.is_due(now) {
            let _lock = self.lock()?;
            self.certify(&self.ca()?, &self.roll()?.hosts, &self.read("station.key")?, now)?;
        }
        Ok(Identity {
            ca: self.read("ca.crt")?,
            certificate: self.read("station.crt")?,
            key: self.read("station.key")?,
        })
    }

    /// The access control of a router, as it is now.
    ///
    /// # Errors
    /// [`FleetError::File`].
    pub fn access(&self) -> Result<Value, FleetError> {
        Ok(access::control(&self.org, &self.let_in()?))
    }

    fn let_in(&self) -> Result<LetIn, FleetError> {
        let roll = self.roll()?;
        let aircraft = roll.admitted(false).map(str::to_owned).collect();
        Ok(LetIn { aircraft, ..roll.stations(&self.org).let_in(GROUND) })
    }

    /// The signed list of aircraft that routers admit, if newer than this number.
    ///
    /// # Errors
    /// [`FleetError::File`], [`FleetError::Certificate`], [`FleetError::Refused`] if it is too long.
    pub(super) fn admitted(&self, have: u64) -> Result<Option<Vec<u8>>, FleetError> {
        let roll = self.roll()?;
        if roll.admitted_number <= have {
            return Ok(None);
        }
        roll.aircraft(&self.org).signed(&self.ca()?).map(Some)
    }

    /// Settings for an existing `zenohd`: encrypted transports only, access control, no scouting.
    ///
    /// # Errors
    /// [`FleetError::File`].
    pub fn router_config(&self) -> Result<Value, FleetError> {
        // Another of its kind shows the same certificate.
        let mut let_in = self.let_in()?;
        let_in.routers.push(Self::station());
        let path = |file: &str| self.path(file).display().to_string();
        Ok(serde_json::json!({
            "mode": "router",
            "listen": {"endpoints": ["tls/0.0.0.0:7447"]},
            "scouting": {"multicast": {"enabled": false}, "gossip": {"enabled": false}},
            "adminspace": {"enabled": false},
            "transport": {
                "unicast": {"max_sessions": 10_000, "accept_pending": 10_000},
                "link": {"protocols": ["tls", "quic"], "tx": {"queue": {"size": {"control": CONTROL_QUEUE}}}, "tls": {
                    "enable_mtls": true, "verify_name_on_connect": true, "close_link_on_expiration": true,
                    "root_ca_certificate": path("ca.crt"),
                    "listen_certificate": path("station.crt"), "listen_private_key": path("station.key"),
                    "connect_certificate": path("station.crt"), "connect_private_key": path("station.key"),
                }},
            },
            "access_control": access::control(&self.org, &let_in),
        }))
    }

    /// Checks a new member's name and router addresses, without network access.
    ///
    /// # Errors
    /// [`FleetError::Refused`] for a name that is taken, [`FleetError::Address`] for an address that others cannot
    /// reach over TLS or QUIC.
    pub fn check(newcomer: &Newcomer) -> Result<(), FleetError> {
        newcomer.check()?;
        for router in newcomer.routers() {
            let at = router.parse::<Endpoint>()?;
            if at.transport() == Transport::Tcp || at.is_any() {
                return Err(FleetError::Address(router.clone()));
            }
        }
        Ok(())
    }

    /// A token for an aircraft or a ground station, good for `lasts_s`. The token is returned and stored nowhere.
    ///
    /// # Errors
    /// [`FleetError::Refused`], [`FleetError::File`].
    pub fn enrol(&self, newcomer: &Newcomer, lasts_s: u64, now: u64) -> Result<Ticket, FleetError> {
        Self::check(newcomer)?;
        let fingerprint = sha256(&der_of(&self.read("ca.crt")?)?).to_vec();
        let secret = random::<SECRET_LEN>()?.to_vec();
        self.change(|roll| {
            let doors = if roll.doors.is_empty() { reached_at(&roll.hosts, DOOR_PORT) } else { roll.doors.clone() };
            let (doors, org) = (doors.into_iter().take(MAX_DOORS).collect(), self.org.to_string());
            let ticket = Ticket { fingerprint, secret, doors, org, is_station: newcomer.role().is_some() };
            roll.promise(newcomer, &ticket, lasts_s, now)?;
            Ok(ticket)
        })
    }

    /// Issues a certificate to a caller of the door: with a token's secret, or with its present certificate.
    ///
    /// # Errors
    /// [`FleetError::Refused`], [`FleetError::Certificate`], [`FleetError::File`].
    pub fn judge(&self, asked: &wire::Asked, shown: Option<&Facts>, now: u64) -> Result<(String, String), FleetError> {
        let ca = self.ca()?;
        self.change(|roll| {
            // A trial signature validates the request and has its key.
            let key = || Ok::<_, FleetError>(facts(&ca.for_member(self.org.as_str(), &asked.request, now)?)?.key);
            let (name, role, before) = match shown {
                Some(shown) if asked.secret.is_empty() => {
                    roll.renew(&shown.common_name, &shown.key)?;
                    (shown.common_name.clone(), None, Some(&shown.key))
                }
                _ => {
                    let (name, role) = roll.redeem(&asked.secret, &key()?, now)?;
                    (name, role, None)
                }
            };
            let key = key()?;
            let routers = match &role {
                Some((_, routers)) => routers.as_slice(),
                None => roll
                    .members
                    .get(&name)
                    .and_then(|entry| Some(entry.post.as_ref()?.routers.as_slice()))
                    .unwrap_or_default(),
            };
            let certificate = match routers {
                [] => ca.for_member(&name, &asked.request, now)?,
                routers => ca.for_router(&name, &hosts_of(routers)?, &asked.request, now)?,
            };
            roll.enter(&name, &key, before, facts(&certificate)?.ends, now);
            if let Some(role) = role {
                let operator = asked.operator.as_slice().try_into().map(PublicKey);
                let operator = operator
                    .map_err(|_| FleetError::Refused("it sent no key: join with `vencejo serve --join`".into()))?;
                roll.post(&name, role, &operator)?;
            }
            Ok((name, certificate))
        })
    }

    /// The addresses by which others reach an address of this machine.
    ///
    /// # Errors
    /// [`FleetError::File`].
    pub(super) fn routers(&self, listen: &Endpoint, is_dialled: bool) -> Result<Vec<String>, FleetError> {
        let is_here = is_dialled && HERE.contains(&listen.host());
        if !(listen.is_any() || is_here) {
            return Ok(vec![listen.to_string()]);
        }
        let hosts = abroad(&self.roll()?.hosts);
        Ok(hosts.iter().take(MAX_ROUTERS).map(|host| listen.at(host).to_string()).collect())
    }

    /// The same for the door.
    pub(super) fn doors(&self, listen: std::net::SocketAddr) -> Result<Vec<String>, FleetError> {
        if !listen.ip().is_unspecified() {
            return Ok(vec![listen.to_string()]);
        }
        Ok(reached_at(&self.roll()?.hosts, listen.port()).into_iter().take(MAX_DOORS).collect())
    }
}

/// The hosts by which others reach this machine; loopback names if there are none.
fn abroad(hosts: &[String]) -> Vec<String> {
    let far: Vec<_> = hosts.iter().filter(|host| !HERE.contains(&host.as_str())).cloned().collect();
    if far.is_empty() { hosts.to_vec() } else { far }
}

/// The hosts for the certificate of a router at these addresses: theirs, and the loopback names.
fn hosts_of(routers: &[String]) -> Result<Vec<String>, FleetError> {
    let mut hosts = HERE.map(str::to_owned).to_vec();
    for router in routers {
        let host = router.parse::<Endpoint>()?.host().to_owned();
        if !hosts.contains(&host) {
            hosts.push(host);
        }
    }
    Ok(hosts)
}

fn reached_at(hosts: &[String], port: u16) -> Vec<String> {
    abroad(hosts).iter().map(|host| format!("{}:{port}", bracketed(host))).collect()
}
