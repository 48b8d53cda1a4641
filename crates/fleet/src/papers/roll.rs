//! Who is enrolled in a fleet, aircraft and ground stations, who no longer is, and which tokens are out. The organisation's authority keeps
//! it on the ground. Each is on it by the common name of its certificate, which for a ground station begins with `_`.

use core::net::IpAddr;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::certificate::STATION_PREFIX;
use super::stations::{Listed, MAX_STATIONS, Stations};
use super::ticket::{Ticket, hex};
use crate::authority::Role;
use crate::error::FleetError;
use crate::key::Name;
use crate::payload::VERSION as PAYLOAD_VERSION;
use crate::signature::PublicKey;

/// The version of what is kept. The first knew aircraft alone, which are members by their names here.
const VERSION: u32 = 2;
/// How long a token is good unless said otherwise, s.
pub const TOKEN_S: u64 = 3_600;
/// Aircraft on a roll at most: sessions that a router takes.
const MAX_AIRCRAFT: usize = 10_000;
/// Tokens that are out at most.
const MAX_TOKENS: usize = 1_000;

/// Name of the ground station that has the authority.
pub const GROUND: &str = "ground";

/// Whom a token is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Newcomer {
    /// An aircraft.
    Aircraft(Name),
    /// A ground station.
    Station(Name, Role),
}

impl Newcomer {
    /// The common name of its certificate.
    #[must_use]
    pub fn common_name(&self) -> String {
        match self {
            Self::Aircraft(name) => name.to_string(),
            Self::Station(name, _) => station_called(name),
        }
    }

    /// Whether there may be one of that name.
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
    #[must_use]
    pub fn role(&self) -> Option<Role> {
        match self {
            Self::Aircraft(_) => None,
            Self::Station(_, role) => Some(*role),
        }
    }
}

/// The common name of a ground station's certificate.
#[must_use]
pub fn station_called(name: &Name) -> String {
    format!("{STATION_PREFIX}{name}")
}

/// What a person calls whoever has a common name, and how one is enrolled.
fn called(common_name: &str) -> (&str, String) {
    match common_name.strip_prefix(STATION_PREFIX) {
        Some(name) => (name, format!("vencejo fleet enrol --station {name}")),
        None => (common_name, format!("vencejo fleet enrol {common_name}")),
    }
}

/// A ground station's place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Post {
    /// Its role.
    pub role: Role,
    /// The key that it signs orders with, in hexadecimal digits.
    pub operator: String,
}

/// One aircraft, or ground station.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// When it was enrolled, seconds since 1970.
    pub enrolled: u64,
    /// When the last certificate that it got ends.
    pub ends: u64,
    /// SHA-256 of the key of that certificate, in hexadecimal digits.
    pub key: String,
    /// The same of the one that was shown for it: its bearer may not have heard the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// When it was put out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revoked: Option<u64>,
    /// What it may do, where it is a ground station.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub post: Option<Post>,
}

/// One token that is out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Out {
    /// SHA-256 of its secret, in hexadecimal digits: the secret is nowhere.
    pub hash: String,
    /// Whom it is for: a common name.
    pub name: String,
    /// The role, where that is a ground station.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
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
    /// Who is enrolled, by common name.
    #[serde(default, alias = "aircraft")]
    pub members: BTreeMap<String, Entry>,
    #[serde(default)]
    tokens: Vec<Out>,
}

fn refused(why: impl Into<String>) -> FleetError {
    FleetError::Refused(why.into())
}

impl Roll {
    /// One without anybody.
    #[must_use]
    pub fn new(hosts: Vec<String>) -> Self {
        Self {
            version: VERSION,
            hosts,
            routers: Vec::new(),
            doors: Vec::new(),
            operator: None,
            number: 0,
            members: BTreeMap::new(),
            tokens: Vec::new(),
        }
    }

    /// The roll as it is kept.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let roll: Self = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
        match roll.version {
            1..=VERSION => Ok(Self { version: VERSION, ..roll }),
            other => Err(format!("it is of version {other}, this program knows those to {VERSION}")),
        }
    }

    /// As it is kept.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).expect("invariant: texts and numbers are JSON");
        bytes.push(b'\n');
        bytes
    }

    /// Common names of the aircraft, or of the ground stations, that routers let in.
    pub fn admitted(&self, stations: bool) -> impl Iterator<Item = &str> {
        let is_in = move |entry: &Entry| entry.revoked.is_none() && entry.post.is_some() == stations;
        self.members.iter().filter(move |(_, entry)| is_in(entry)).map(|(name, _)| name.as_str())
    }

    /// The ground stations whose orders count, and the addresses, for all to know.
    #[must_use]
    pub fn stations(&self, org: &Name) -> Stations {
        let listed = |name: &str, role: Role, operator: &str| {
            let key = operator.parse::<PublicKey>().ok()?.0.to_vec();
            Some(Listed { name: name.to_owned(), key, role: role.as_str().to_owned() })
        };
        let own = self.operator.as_ref().and_then(|key| listed(GROUND, Role::Operator, key));
        let others = self.members.iter().filter(|(_, entry)| entry.revoked.is_none());
        let others = others.filter_map(|(name, entry)| Some((called(name).0, entry.post.as_ref()?)));
        let others = others.filter_map(|(name, post)| listed(name, post.role, &post.operator));
        Stations {
            version: PAYLOAD_VERSION,
            org: org.to_string(),
            number: self.number,
            stations: own.into_iter().chain(others).collect(),
            routers: self.routers.clone(),
            doors: self.doors.clone(),
        }
    }

    /// Gives the list of ground stations its number, where it differs from the one `before`. A clock's, so that a copy of the roll that is
    /// put back years later goes on above all that were given out since.
    pub fn number_after(&mut self, before: &Self, org: &Name, now: u64) {
        if self.stations(org) != before.stations(org) {
            self.number = now.max(before.number + 1);
        }
    }

    /// Tokens that are good still, and whom for.
    pub fn open_tokens(&self, now: u64) -> impl Iterator<Item = &Out> {
        self.tokens.iter().filter(move |out| out.used_by.is_none() && out.ends > now)
    }

    /// Takes note of a token. Who is enrolled already may be enrolled again, on another computer.
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
        // One token each: the older one is void.
        self.tokens.retain(|out| out.name != common_name);
        self.tokens.push(Out { hash: ticket.hash(), name: common_name, role, ends: now + lasts_s, used_by: None });
        Ok(())
    }

    /// Whose certificate a request with this secret and this key is for. From now on the token is this key's: whoever lost the answer
    /// asks again with the same key, and nobody else can.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn redeem(&mut self, secret: &[u8], key: &[u8; 32], now: u64) -> Result<(String, Option<Role>), FleetError> {
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
        Ok((out.name.clone(), out.role))
    }

    /// Whether whoever shows a good certificate, of this key, gets another: one that was enrolled again, elsewhere, does not.
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

    /// Takes note of a certificate that somebody gets, for a key, and of the key that it showed for it.
    pub fn enter(&mut self, common_name: &str, key: &[u8; 32], before: Option<&[u8; 32]>, ends: u64, now: u64) {
        let already = self.members.get(common_name).filter(|entry| entry.revoked.is_none());
        let (enrolled, post) = already.map_or((now, None), |entry| (entry.enrolled, entry.post.clone()));
        let before = before.map(|key| hex(key));
        self.members
            .insert(common_name.to_owned(), Entry { enrolled, ends, key: hex(key), before, revoked: None, post });
    }

    /// Gives a ground station that has joined its role, and takes note of the key that it signs orders with.
    ///
    /// # Errors
    /// [`FleetError::Refused`] for a key that is another's.
    pub fn post(&mut self, common_name: &str, role: Role, operator: &PublicKey) -> Result<(), FleetError> {
        let operator = operator.to_string();
        let others = self.members.iter().filter(|(name, entry)| *name != common_name && entry.revoked.is_none());
        let is_taken = |entry: &Entry| entry.post.as_ref().is_some_and(|post| post.operator == operator);
        if self.operator.as_ref() == Some(&operator) || others.into_iter().any(|(_, entry)| is_taken(entry)) {
            return Err(refused("its key is another ground station's: move the file of its key away, and join again"));
        }
        if let Some(entry) = self.members.get_mut(common_name) {
            entry.post = Some(Post { role, operator });
        }
        Ok(())
    }

    /// Puts somebody out, with the tokens for it.
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
/// Addresses that are remembered at most; the oldest is forgotten.
const MAX_ADDRESSES: usize = 1_024;

/// Who guesses. A secret has 128 bits, so that no rate would find one; this keeps the log and the processor free.
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
mod tests {
    use super::*;
    use crate::papers::DAY_S;

    const NOW: u64 = 1_800_000_000;

    fn plane(text: &str) -> Newcomer {
        Newcomer::Aircraft(text.parse().expect("a name"))
    }

    fn ticket(secret: u8) -> Ticket {
        Ticket { secret: vec![secret; 16], ..Ticket::default() }
    }

    fn says(result: Result<impl std::fmt::Debug, FleetError>, what: &str) {
        let error = result.expect_err(what).to_string();
        assert!(error.contains(what), "{error}");
    }

    #[test]
    fn a_token_is_good_once_and_for_its_time() {
        let mut roll = Roll::new(vec![]);
        roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW).expect("promised");
        assert_eq!(roll.open_tokens(NOW).count(), 1);
        assert!(!String::from_utf8(roll.bytes()).expect("text").contains(&hex(&[1; 16])), "the secret is not kept");
        says(roll.redeem(&[2; 16], &[1; 32], NOW), "does not know");
        says(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S), "expired");
        assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(("plane7".to_owned(), None)));
        // The answer was lost: the same computer asks again.
        assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(("plane7".to_owned(), None)));
        says(roll.redeem(&[1; 16], &[3; 32], NOW), "has been used");
        assert_eq!(roll.open_tokens(NOW).count(), 0);
        roll.promise(&plane("plane7"), &ticket(4), TOKEN_S, NOW).expect("promised");
        says(roll.redeem(&[1; 16], &[1; 32], NOW), "does not know");
    }

    #[test]
    fn who_was_put_out_stays_out_and_its_name_waits_for_its_certificate() {
        let mut roll = Roll::new(vec![]);
        says(roll.revoke("plane7", NOW), "no aircraft plane7");
        roll.enter("plane7", &[1; 32], None, NOW + 90 * DAY_S, NOW);
        roll.enter("plane8", &[2; 32], None, NOW + 90 * DAY_S, NOW);
        assert_eq!(roll.renew("plane7", &[1; 32]), Ok(()));
        says(roll.renew("plane7", &[2; 32]), "enrolled again");
        says(roll.renew("plane9", &[1; 32]), "no plane9");
        // It has a new key, or has not heard that it has.
        roll.enter("plane7", &[3; 32], Some(&[1; 32]), NOW + 90 * DAY_S, NOW);
        assert_eq!(roll.renew("plane7", &[1; 32]), roll.renew("plane7", &[3; 32]));
        roll.enter("plane7", &[4; 32], Some(&[3; 32]), NOW + 90 * DAY_S, NOW);
        says(roll.renew("plane7", &[1; 32]), "enrolled again");
        roll.revoke("plane7", NOW).expect("revoked");
        says(roll.renew("plane7", &[4; 32]), "revoked");
        assert_eq!(roll.admitted(false).collect::<Vec<_>>(), ["plane8"]);
        says(roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW), "ends in 90 days");
        roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW + 90 * DAY_S).expect("free again");
    }

    #[test]
    fn a_ground_station_is_listed_with_its_role_until_it_is_put_out() {
        let org = "acme".parse().expect("a name");
        let mut roll = Roll::new(vec![]);
        roll.operator = Some(PublicKey([9; 32]).to_string());
        let tower = |role| Newcomer::Station("tower".parse().expect("a name"), role);
        roll.promise(&tower(Role::Chief), &ticket(1), TOKEN_S, NOW).expect("promised");
        let before = roll.clone();
        let (name, role) = roll.redeem(&[1; 16], &[1; 32], NOW).expect("good");
        assert_eq!((name.as_str(), role), ("_tower", Some(Role::Chief)));
        roll.enter(&name, &[1; 32], None, NOW + 90 * DAY_S, NOW);
        says(roll.clone().post(&name, Role::Chief, &PublicKey([9; 32])), "another ground station's");
        roll.post(&name, Role::Chief, &PublicKey([1; 32])).expect("posted");
        roll.number_after(&before, &org, NOW);
        let listed: Vec<_> = roll.stations(&org).stations.into_iter().map(|each| (each.name, each.role)).collect();
        assert_eq!(listed, [("ground".into(), "operator".into()), ("tower".into(), "chief".into())]);
        assert_eq!(roll.number, NOW);
        assert_eq!((roll.admitted(true).count(), roll.admitted(false).count()), (1, 0));
        // An aircraft of the same name is somebody else, and changes nothing of the list.
        let before = roll.clone();
        roll.enter("tower", &[2; 32], None, NOW + 90 * DAY_S, NOW);
        roll.number_after(&before, &org, NOW + 1);
        assert_eq!(roll.number, NOW);
        // A renewed certificate leaves it its role. Put out, it is on the list no more, whatever the clock says.
        roll.enter(&name, &[3; 32], Some(&[1; 32]), NOW + 90 * DAY_S, NOW);
        assert_eq!(roll.stations(&org), before.stations(&org));
        roll.revoke(&name, NOW).expect("revoked");
        roll.number_after(&before, &org, NOW - 7);
        assert_eq!((roll.stations(&org).stations.len(), roll.number), (1, NOW + 1));
        says(roll.promise(&tower(Role::Operator), &ticket(2), TOKEN_S, NOW), "tower was revoked");
        let ground = Newcomer::Station("ground".parse().expect("a name"), Role::Operator);
        says(roll.promise(&ground, &ticket(2), TOKEN_S, NOW), "has the authority");
    }

    #[test]
    fn a_roll_is_read_as_it_is_kept() {
        let mut roll = Roll::new(vec!["ground.local".into()]);
        roll.enter("plane7", &[1; 32], None, NOW, NOW);
        roll.promise(&plane("plane8"), &ticket(1), TOKEN_S, NOW).expect("promised");
        assert_eq!(Roll::read(&roll.bytes()), Ok(roll));
        assert!(Roll::read(b"{\"version\": 3, \"hosts\": []}").is_err_and(|error| error.contains("version 3")));
        let first = br#"{"version": 1, "hosts": ["ground"], "aircraft": {"plane7": {"enrolled": 1, "ends": 2, "key": "00", "revoked": 2}}}"#;
        let read = Roll::read(first).expect("the first version");
        assert_eq!(read.members["plane7"].revoked, Some(2), "whoever was put out stays out");
        assert_eq!(Roll::read(&read.bytes()), Ok(read));
    }

    #[test]
    fn whoever_guesses_has_to_wait_and_nobody_else() {
        let (eve, ana) = (IpAddr::from([10, 0, 0, 1]), IpAddr::from([10, 0, 0, 2]));
        let mut guesses = Guesses::default();
        for second in 0..10 {
            assert!(!guesses.must_wait(eve, Duration::from_secs(second)));
            guesses.wrong(eve, Duration::from_secs(second));
        }
        assert!(guesses.must_wait(eve, Duration::from_secs(59)) && !guesses.must_wait(ana, Duration::from_secs(59)));
        assert!(!guesses.must_wait(eve, Duration::from_secs(60)));
    }
}
