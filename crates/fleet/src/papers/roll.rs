//! Who is enrolled in a fleet, who no longer is, and which tokens are out. The organisation's authority keeps it on the ground.

use core::net::IpAddr;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::ticket::{Ticket, hex};
use crate::error::FleetError;
use crate::key::Name;

/// The version of what is kept.
const VERSION: u32 = 1;
/// How long a token is good unless said otherwise, s.
pub const TOKEN_S: u64 = 3_600;
/// Aircraft on a roll at most: sessions that a router takes.
const MAX_AIRCRAFT: usize = 10_000;
/// Tokens that are out at most.
const MAX_TOKENS: usize = 1_000;

/// One aircraft.
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
}

/// One token that is out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Out {
    /// SHA-256 of its secret, in hexadecimal digits: the secret is nowhere.
    pub hash: String,
    /// The aircraft it is for.
    pub name: String,
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
    /// The aircraft, by name.
    #[serde(default)]
    pub aircraft: BTreeMap<String, Entry>,
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
        let (routers, doors) = (Vec::new(), Vec::new());
        Self { version: VERSION, hosts, routers, doors, aircraft: BTreeMap::new(), tokens: Vec::new() }
    }

    /// The roll as it is kept.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let roll: Self = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
        if roll.version == VERSION {
            Ok(roll)
        } else {
            Err(format!("it is of version {}, this program knows {VERSION}", roll.version))
        }
    }

    /// As it is kept.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).expect("invariant: texts and numbers are JSON");
        bytes.push(b'\n');
        bytes
    }

    /// The aircraft that routers let in.
    pub fn admitted(&self) -> impl Iterator<Item = &str> {
        self.aircraft.iter().filter(|(_, entry)| entry.revoked.is_none()).map(|(name, _)| name.as_str())
    }

    /// Tokens that are good still, with their aircraft.
    pub fn open_tokens(&self, now: u64) -> impl Iterator<Item = &Out> {
        self.tokens.iter().filter(move |out| out.used_by.is_none() && out.ends > now)
    }

    /// Takes note of a token for an aircraft. One that is enrolled already may be enrolled again, on another card.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn promise(&mut self, name: &Name, ticket: &Ticket, lasts_s: u64, now: u64) -> Result<(), FleetError> {
        self.tokens.retain(|out| out.ends > now);
        if let Some(entry) =
            self.aircraft.get(name.as_str()).filter(|entry| entry.revoked.is_some() && entry.ends > now)
        {
            let days = (entry.ends - now).div_ceil(super::DAY_S);
            return Err(refused(format!(
                "{name} was revoked, and its old certificate, wherever that is, ends in {days} days: take another name until then"
            )));
        }
        if self.tokens.len() >= MAX_TOKENS {
            return Err(refused(format!("{MAX_TOKENS} tokens are out: wait until some of them end")));
        }
        if self.aircraft.len() >= MAX_AIRCRAFT && !self.aircraft.contains_key(name.as_str()) {
            return Err(refused(format!("{MAX_AIRCRAFT} aircraft are enrolled: more cannot be")));
        }
        // One token an aircraft: the older one is void.
        self.tokens.retain(|out| out.name != name.as_str());
        let hash = ticket.hash();
        self.tokens.push(Out { hash, name: name.to_string(), ends: now + lasts_s, used_by: None });
        Ok(())
    }

    /// Whose certificate a request with this secret and this key is for. From now on the token is this key's: whoever lost the answer
    /// asks again with the same key, and nobody else can.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn redeem(&mut self, secret: &[u8], key: &[u8; 32], now: u64) -> Result<Name, FleetError> {
        let ticket = Ticket { secret: secret.to_vec(), ..Ticket::default() };
        let (hash, key) = (ticket.hash(), hex(key));
        let again = "ask for another with: vencejo fleet enrol";
        let Some(out) = self.tokens.iter_mut().find(|out| out.hash == hash) else {
            return Err(refused(format!("it does not know this token; {again} NAME")));
        };
        if out.ends <= now {
            return Err(refused(format!("this token has expired; {again} {}", out.name)));
        }
        if out.used_by.as_ref().is_some_and(|used| *used != key) {
            return Err(refused(format!(
                "this token has been used, by another computer; if that was not yours, run: vencejo fleet revoke {}",
                out.name
            )));
        }
        out.used_by = Some(key);
        Ok(out.name.parse()?)
    }

    /// Whether an aircraft that shows a good certificate, of this key, gets another: one that was enrolled again, elsewhere, does not.
    ///
    /// # Errors
    /// [`FleetError::Refused`].
    pub fn renew(&self, common_name: &str, key: &[u8; 32]) -> Result<Name, FleetError> {
        let key = hex(key);
        match self.aircraft.get(common_name) {
            Some(entry) if entry.revoked.is_some() => Err(refused(format!("{common_name} was revoked"))),
            Some(entry) if entry.key == key || entry.before.as_ref() == Some(&key) => Ok(common_name.parse()?),
            Some(_) => Err(refused(format!("{common_name} was enrolled again since, on another computer"))),
            None => Err(refused(format!("no aircraft {common_name} is enrolled"))),
        }
    }

    /// Takes note of a certificate that an aircraft gets, for a key, and of the key that it showed for it.
    pub fn enter(&mut self, name: &Name, key: &[u8; 32], before: Option<&[u8; 32]>, ends: u64, now: u64) {
        let enrolled = self
            .aircraft
            .get(name.as_str())
            .filter(|entry| entry.revoked.is_none())
            .map_or(now, |entry| entry.enrolled);
        self.aircraft.insert(
            name.to_string(),
            Entry { enrolled, ends, key: hex(key), before: before.map(|key| hex(key)), revoked: None },
        );
    }

    /// Puts an aircraft out, with its tokens.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where there is none of that name.
    pub fn revoke(&mut self, name: &Name, now: u64) -> Result<(), FleetError> {
        let tokens = self.tokens.len();
        self.tokens.retain(|out| out.name != name.as_str());
        match self.aircraft.get_mut(name.as_str()) {
            Some(entry) => {
                entry.revoked.get_or_insert(now);
                Ok(())
            }
            None if self.tokens.len() < tokens => Ok(()),
            None => Err(refused(format!("no aircraft {name} is enrolled"))),
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

    fn name(text: &str) -> Name {
        text.parse().expect("a name")
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
        roll.promise(&name("plane7"), &ticket(1), TOKEN_S, NOW).expect("promised");
        assert_eq!(roll.open_tokens(NOW).count(), 1);
        assert!(!String::from_utf8(roll.bytes()).expect("text").contains(&hex(&[1; 16])), "the secret is not kept");
        says(roll.redeem(&[2; 16], &[1; 32], NOW), "does not know");
        says(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S), "expired");
        assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(name("plane7")));
        // The answer was lost: the same computer asks again.
        assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(name("plane7")));
        says(roll.redeem(&[1; 16], &[3; 32], NOW), "has been used");
        assert_eq!(roll.open_tokens(NOW).count(), 0);
        roll.promise(&name("plane7"), &ticket(4), TOKEN_S, NOW).expect("promised");
        says(roll.redeem(&[1; 16], &[1; 32], NOW), "does not know");
    }

    #[test]
    fn who_was_put_out_stays_out_and_its_name_waits_for_its_certificate() {
        let mut roll = Roll::new(vec![]);
        says(roll.revoke(&name("plane7"), NOW), "no aircraft plane7");
        roll.enter(&name("plane7"), &[1; 32], None, NOW + 90 * DAY_S, NOW);
        roll.enter(&name("plane8"), &[2; 32], None, NOW + 90 * DAY_S, NOW);
        assert_eq!(roll.renew("plane7", &[1; 32]), Ok(name("plane7")));
        says(roll.renew("plane7", &[2; 32]), "enrolled again");
        says(roll.renew("plane9", &[1; 32]), "no aircraft");
        // It has a new key, or has not heard that it has.
        roll.enter(&name("plane7"), &[3; 32], Some(&[1; 32]), NOW + 90 * DAY_S, NOW);
        assert_eq!(roll.renew("plane7", &[1; 32]), roll.renew("plane7", &[3; 32]));
        roll.enter(&name("plane7"), &[4; 32], Some(&[3; 32]), NOW + 90 * DAY_S, NOW);
        says(roll.renew("plane7", &[1; 32]), "enrolled again");
        roll.revoke(&name("plane7"), NOW).expect("revoked");
        says(roll.renew("plane7", &[4; 32]), "revoked");
        assert_eq!(roll.admitted().collect::<Vec<_>>(), ["plane8"]);
        says(roll.promise(&name("plane7"), &ticket(1), TOKEN_S, NOW), "ends in 90 days");
        roll.promise(&name("plane7"), &ticket(1), TOKEN_S, NOW + 90 * DAY_S).expect("free again");
    }

    #[test]
    fn a_roll_is_read_as_it_is_kept() {
        let mut roll = Roll::new(vec!["ground.local".into()]);
        roll.enter(&name("plane7"), &[1; 32], None, NOW, NOW);
        roll.promise(&name("plane8"), &ticket(1), TOKEN_S, NOW).expect("promised");
        assert_eq!(Roll::read(&roll.bytes()), Ok(roll));
        assert!(Roll::read(b"{\"version\": 2, \"hosts\": []}").is_err_and(|error| error.contains("version 2")));
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
