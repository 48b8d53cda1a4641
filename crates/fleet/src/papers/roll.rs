//! The roll of a fleet: enrolled and revoked aircraft and ground stations, and pending tokens. The organisation's
//! authority keeps it on the ground. Members are identified by the common name of their certificate, which for a ground
//! station begins with `_`.

use core::net::IpAddr;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::certificate::STATION_PREFIX;
use super::stations::{Admitted, GROUND, Listed, MAX_ROUTERS, MAX_STATIONS, Stations};
use super::ticket::{Ticket, hex};
use crate::authority::Role;
use crate::error::FleetError;
use crate::key::Name;
use crate::payload::VERSION as PAYLOAD_VERSION;
use crate::signature::PublicKey;

/// The version of the file. The first had aircraft only, whose common names are their names.
const VERSION: u32 = 2;
/// Most aircraft on a roll: the sessions of a router.
const MAX_AIRCRAFT: usize = 10_000;
/// Most pending tokens.
const MAX_TOKENS: usize = 1_000;

/// A ground station's role, and the addresses of its router, if it has one.
pub type AsStation = (Role, Vec<String>);

/// The recipient of a token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Newcomer {
    /// An aircraft.
    Aircraft(Name),
    /// A ground station, with its addresses if it is a router.
    Station(Name, Role, Vec<String>),
}

impl Newcomer {
    /// The common name of its certificate.
    pub fn common_name(&self) -> String {
        match self {
            Self::Aircraft(name) => name.to_string(),
            Self::Station(name, ..) => station_called(name),
        }
    }

    /// Whether the name is allowed.
    ///
    /// # Errors
    /// [`FleetError::Refused`]: that of the ground station that has the authority is taken.
    pub fn check(&self) -> Result<(), FleetError> {
        if self.common_name() == format!("{STATION_PREFIX}{GROUND}") {
            return Err(refused(format!("{GROUND} is the ground station that has the authority: take another name")));
        }
        Ok(())
    }

    /// Its role, where it is a ground station.
    pub fn role(&self) -> Option<Role> {
        match self {
            Self::Aircraft(_) => None,
            Self::Station(_, role, _) => Some(*role),
        }
    }

    /// Its addresses as a router.
    pub fn routers(&self) -> &[String] {
        match self {
            Self::Aircraft(_) => &[],
            Self::Station(_, _, routers) => routers,
        }
    }
}

/// The common name of a ground station's certificate.
pub fn station_called(name: &Name) -> String {
    format!("{STATION_PREFIX}{name}")
}

/// The display name of a common name, and the command that enrols it.
fn called(common_name: &str) -> (&str, String) {
    match common_name.strip_prefix(STATION_PREFIX) {
        Some(name) => (name, format!("vencejo fleet enrol --station {name}")),
        None => (common_name, format!("vencejo fleet enrol {common_name}")),
    }
}

/// A ground station's entry.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Post {
    /// Its role.
    pub role: Role,
    /// The key that it signs orders with, in hexadecimal digits.
    pub operator: String,
    /// Its addresses as a router, if it is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub routers: Vec<String>,
}

/// One aircraft, or ground station.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// When it was enrolled, seconds since 1970.
    pub enrolled: u64,
    /// When its last certificate ends.
    pub ends: u64,
    /// SHA-256 of the key of that certificate, in hexadecimal digits.
    pub key: String,
    /// The same of the certificate used for the renewal: the answer may have been lost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// When it was revoked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revoked: Option<u64>,
    /// Its entry as a ground station.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub post: Option<Post>,
}

/// A pending token.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Out {
    /// SHA-256 of its secret, in hexadecimal digits; the secret is not stored.
    pub hash: String,
    /// Its recipient: a common name.
    pub name: String,
    /// The role, where that is a ground station.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// Where that is a router, if it is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub routers: Vec<String>,
    /// When it ends, seconds since 1970.
    pub ends: u64,
    /// SHA-256 of the key that used it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub used_by: Option<String>,
}

/// The roll of a fleet.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Roll {
    version: u32,
    /// Host names and addresses of the ground station.
    pub hosts: Vec<String>,
    /// Where routers are, as the ground station last served.
    #[serde(default)]
    pub routers: Vec<String>,
    /// Where aircraft are enrolled, likewise.
    #[serde(default)]
    pub doors: Vec<String>,
    /// The key that the ground station which has the authority signs orders with, in hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// The number of the list of ground stations.
    #[serde(default)]
    pub number: u64,
    /// The number of the list of aircraft that other routers let in.
    #[serde(default)]
    pub admitted_number: u64,
    /// The members, by common name.
    #[serde(default, alias = "aircraft")]
    pub members: BTreeMap<String, Entry>,
    #[serde(default)]
    tokens: Vec<Out>,
}

fn refused(why: impl Into<String>) -> FleetError {
    FleetError::Refused(why.into())
}

impl Roll {
    /// An empty roll.
    pub fn new(hosts: Vec<String>) -> Self {
        Self {
            version: VERSION,
            hosts,
            routers: Vec::new(),
            doors: Vec::new(),
            operator: None,
            number: 0,
            admitted_number: 0,
            members: BTreeMap::new(),
            tokens: Vec::new(),
        }
    }

    /// Reads the file of a roll.
    ///
    /// # Errors
    /// The reason, as text.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut json = serde_json::Deserializer::from_slice(bytes);
        // With the path of the value, such as `members.plane7.serial`: its line alone says little to a person.
        let roll: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| error.to_string())?;
        json.end().map_err(|error| error.to_string())?;
        match roll.version {
            1..=VERSION => Ok(Self { version: VERSION, ..roll }),
            other => Err(format!("it is of version {other}, this program knows those to {VERSION}")),
        }
    }

    /// The file of the roll.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).expect("invariant: texts and numbers are JSON");
        bytes.push(b'\n');
        bytes
    }

    /// Common names of the aircraft, or of the ground stations, that routers admit.
    pub fn admitted(&self, stations: bool) -> impl Iterator<Item = &str> {
        let is_in = move |entry: &Entry| entry.revoked.is_none() && entry.post.is_some() == stations;
        self.members.iter().filter(move |(_, entry)| is_in(entry)).map(|(name, _)| name.as_str())
    }

    /// The public list of ground stations and addresses.
    pub fn stations(&self, org: &Name) -> Stations {
        let listed = |name: &str, role: Role, operator: &str, routers: &[String]| {
            let key = operator.parse::<PublicKey>().ok()?.0.to_vec();
            Some(Listed { name: name.to_owned(), key, role: role.as_str().to_owned(), routers: routers.to_vec() })
        };
        let own = self.operator.as_ref().and_then(|key| listed(GROUND, Role::Operator, key, &[]));
        let others = self.members.iter().filter(|(_, entry)| entry.revoked.is_none());
        let others = others.filter_map(|(name, entry)| Some((called(name).0, entry.post.as_ref()?)));
        let others = others.filter_map(|(name, post)| listed(name, post.role, &post.operator, &post.routers));
        let stations: Vec<_> = own.into_iter().chain(others).collect();
        let of_others = stations.iter().flat_map(|each| &each.routers).filter(|router| !self.routers.contains(router));
        let routers = self.routers.iter().chain(of_others).take(MAX_ROUTERS).cloned().collect();
        Stations {
            version: PAYLOAD_VERSION,
            org: org.to_string(),
            number: self.number,
            stations,
            routers,
            doors: self.doors.clone(),
        }
    }

    /// Common names of the members that were revoked.
    pub fn revoked(&self) -> impl Iterator<Item = &str> {
        self.members.iter().filter(|(_, entry)| entry.revoked.is_some()).map(|(name, _)| name.as_str())
    }

    /// The aircraft that routers admit.
    pub fn aircraft(&self, org: &Name) -> Admitted {
        Admitted {
            version: PAYLOAD_VERSION,
            org: org.to_string(),
            number: self.admitted_number,
            aircraft: self.admitted(false).map(str::to_owned).collect(),
        }
    }

    /// Numbers the lists that differ from those `before`. By the clock, so that a restored copy of the roll continues
    /// above all numbers issued since.
    pub fn number_after(&mut self, before: &Self, org: &Name, now: u64) {
        if self.stations(org) != before.stations(org) {
            self.number = now.max(before.number + 1);
        }
        if !self.admitted(false).eq(before.admitted(false)) {
            self.admitted_number = now.max(before.admitted_number + 1);
        }
    }

    /// The valid tokens and their recipients.
    pub fn open_tokens(&self, now: u64) -> impl Iterator<Item = &Out> {
        self.tokens.iter().filter(move |out| out.used_by.is_none() && out.ends > now)
    }

    /// Adds a token. A member may be enrolled again, on another computer.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn promise(&mut self, newcomer: &Newcomer, ticket: &Ticket, lasts_s: u64, now: u64) -> Result<(), FleetError> {
        self.tokens.retain(|out| out.ends > now);
        let common_name = newcomer.common_name();
        let name = called(&common_name).0;
        newcomer.check()?;
        if let Some(entry) = self.members.get(&common_name).filter(|entry| entry.revoked.is_some() && entry.ends > now)
        {
            let days = (entry.ends - now).div_ceil(super::DAY_S);
            return Err(refused(format!(
                "{name} was revoked, and its old certificate, wherever that is, ends in {days} days: take another name until then"
            )));
        }
        if self.tokens.len() >= MAX_TOKENS {
            return Err(refused(format!("{MAX_TOKENS} tokens are out: wait until some of them end")));
        }
        let is_new = !self.members.contains_key(&common_name);
        let role = newcomer.role();
        if is_new
            && role.is_none()
            && self.members.values().filter(|entry| entry.post.is_none()).count() >= MAX_AIRCRAFT
        {
            return Err(refused(format!("{MAX_AIRCRAFT} aircraft are enrolled: more cannot be")));
        }
        // One is the ground station that has the authority.
        if is_new && role.is_some() && self.admitted(true).count() + 1 >= MAX_STATIONS {
            return Err(refused(format!("{MAX_STATIONS} ground stations are enrolled: more cannot be")));
        }
        // One token per recipient: an older one is void.
        self.tokens.retain(|out| out.name != common_name);
        let routers = newcomer.routers().to_vec();
        self.tokens.push(Out {
            hash: ticket.hash(),
            name: common_name,
            role,
            routers,
            ends: now + lasts_s,
            used_by: None,
        });
        Ok(())
    }

    /// Redeems a token's secret for this key; returns the common name. From now on the token is bound to this key:
    /// after a lost answer the same key can ask again, and no other.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn redeem(
        &mut self,
        secret: &[u8],
        key: &[u8; 32],
        now: u64,
    ) -> Result<(String, Option<AsStation>), FleetError> {
        let ticket = Ticket { secret: secret.to_vec(), ..Ticket::default() };
        let (hash, key) = (ticket.hash(), hex(key));
        let Some(out) = self.tokens.iter_mut().find(|out| out.hash == hash) else {
            return Err(refused("it does not know this token; ask for another with: vencejo fleet enrol NAME"));
        };
        let enrol = called(&out.name).1;
        if out.ends <= now {
            return Err(refused(format!("this token has expired; ask for another with: {enrol}")));
        }
        if out.used_by.as_ref().is_some_and(|used| *used != key) {
            return Err(refused(format!(
                "this token has been used, by another computer; if that was not yours, run: {}",
                enrol.replace(" enrol ", " revoke ")
            )));
        }
        out.used_by = Some(key);
        Ok((out.name.clone(), out.role.map(|role| (role, out.routers.clone()))))
    }

    /// Whether the holder of a valid certificate of this key gets another one: not if it was enrolled again elsewhere.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn renew(&self, common_name: &str, key: &[u8; 32]) -> Result<(), FleetError> {
        let (key, name) = (hex(key), called(common_name).0);
        match self.members.get(common_name) {
            Some(entry) if entry.revoked.is_some() => Err(refused(format!("{name} was revoked"))),
            Some(entry) if entry.key == key || entry.before.as_ref() == Some(&key) => Ok(()),
            Some(_) => Err(refused(format!("{name} was enrolled again since, on another computer"))),
            None => Err(refused(format!("no {name} is enrolled"))),
        }
    }

    /// Records an issued certificate: its key, and the key that was used to request it.
    pub fn enter(&mut self, common_name: &str, key: &[u8; 32], before: Option<&[u8; 32]>, ends: u64, now: u64) {
        let already = self.members.get(common_name).filter(|entry| entry.revoked.is_none());
        let (enrolled, post) = already.map_or((now, None), |entry| (entry.enrolled, entry.post.clone()));
        let before = before.map(|key| hex(key));
        self.members
            .insert(common_name.to_owned(), Entry { enrolled, ends, key: hex(key), before, revoked: None, post });
    }

    /// Records the role of a ground station that has joined, the key that it signs orders with, and its addresses as a
    /// router.
    ///
    /// # Errors
    /// [`FleetError::Refused`] for a key that is another's.
    pub fn post(
        &mut self,
        common_name: &str,
        (role, routers): AsStation,
        operator: &PublicKey,
    ) -> Result<(), FleetError> {
        let operator = operator.to_string();
        let others = self.members.iter().filter(|(name, entry)| *name != common_name && entry.revoked.is_none());
        let is_taken = |entry: &Entry| entry.post.as_ref().is_some_and(|post| post.operator == operator);
        if self.operator.as_ref() == Some(&operator) || others.into_iter().any(|(_, entry)| is_taken(entry)) {
            return Err(refused("its key is another ground station's: move the file of its key away, and join again"));
        }
        if let Some(entry) = self.members.get_mut(common_name) {
            entry.post = Some(Post { role, operator, routers });
        }
        Ok(())
    }

    /// Revokes a member and its tokens.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where there is none of that common name.
    pub fn revoke(&mut self, common_name: &str, now: u64) -> Result<(), FleetError> {
        let tokens = self.tokens.len();
        self.tokens.retain(|out| out.name != common_name);
        match self.members.get_mut(common_name) {
            Some(entry) => {
                entry.revoked.get_or_insert(now);
                Ok(())
            }
            None if self.tokens.len() < tokens => Ok(()),
            None => {
                let what = if common_name.starts_with(STATION_PREFIX) { "ground station" } else { "aircraft" };
                Err(refused(format!("no {what} {} is enrolled", called(common_name).0)))
            }
        }
    }
}

/// Wrong secrets from one address in [`WINDOW`] before it has to wait.
const MAX_WRONG: usize = 10;
/// How long a wrong secret counts.
const WINDOW: Duration = Duration::from_secs(60);
/// Most addresses remembered; the oldest is forgotten.
const MAX_ADDRESSES: usize = 1_024;

/// A rate limit for wrong secrets. 128 bits cannot be guessed at any rate; this protects the log and the processor.
#[derive(Debug, Default)]
pub struct Guesses(VecDeque<(IpAddr, Duration)>);

impl Guesses {
    /// Whether an address has to wait. `now` is a clock that only goes on.
    pub fn must_wait(&mut self, from: IpAddr, now: Duration) -> bool {
        self.0.retain(|(_, at)| now.saturating_sub(*at) < WINDOW);
        self.0.iter().filter(|(address, _)| *address == from).count() >= MAX_WRONG
    }

    /// An address showed a wrong secret.
    pub fn wrong(&mut self, from: IpAddr, now: Duration) {
        if self.0.len() >= MAX_ADDRESSES * MAX_WRONG {
            self.0.pop_front();
        }
        self.0.push_back((from, now));
    }
}

#[cfg(test)]
mod tests;
