//! The list of a fleet's ground stations, their keys and roles, and where routers are: signed by the authority, and
//! numbered.
//!
//! Every aircraft keeps the newest that it has seen, from any source: a list cannot be forged or modified in transit,
//! and an older one never replaces a newer one.

use std::collections::BTreeMap;

use prost::Message;

use super::access::LetIn;
use super::certificate::{Ca, STATION_PREFIX, verifies};
use crate::authority::Role;
use crate::error::FleetError;
use crate::payload::VERSION;
use crate::signature::PublicKey;

/// Most bytes of a signed list.
pub const MAX_BYTES: usize = 12 * 1024;
/// Most bytes of the list of aircraft: one message.
pub const MAX_ADMITTED: usize = crate::payload::MAX_BYTES;
/// Most ground stations in it.
pub const MAX_STATIONS: usize = 64;
/// Most addresses of routers in it.
pub const MAX_ROUTERS: usize = 16;

/// Name of the ground station that has the authority.
pub const GROUND: &str = "ground";

/// One ground station.
#[derive(Clone, PartialEq, Message)]
pub struct Listed {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// The key that it signs orders with.
    #[prost(bytes = "vec", tag = "2")]
    pub key: Vec<u8>,
    /// Its role, by name. Unknown roles are ignored.
    #[prost(string, tag = "3")]
    pub role: String,
    /// Its addresses as a router, if it is one.
    #[prost(string, repeated, tag = "4")]
    pub routers: Vec<String>,
}

/// The list.
#[derive(Clone, PartialEq, Message)]
pub struct Stations {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The organisation.
    #[prost(string, tag = "2")]
    pub org: String,
    /// Incremented with each list.
    #[prost(uint64, tag = "3")]
    pub number: u64,
    /// The ground stations.
    #[prost(message, repeated, tag = "4")]
    pub stations: Vec<Listed>,
    /// Addresses of routers, in the order in which they are tried.
    #[prost(string, repeated, tag = "5")]
    pub routers: Vec<String>,
    /// Addresses of doors, where certificates are renewed, `HOST:PORT`.
    #[prost(string, repeated, tag = "6")]
    pub doors: Vec<String>,
}

/// The list as it goes over the network and into files.
#[derive(Clone, PartialEq, Message)]
pub struct SignedStations {
    /// A [`Stations`].
    #[prost(bytes = "vec", tag = "1")]
    pub list: Vec<u8>,
    /// The authority's signature of it.
    #[prost(bytes = "vec", tag = "2")]
    pub signature: Vec<u8>,
}

/// A list that the authority signs. A signature is valid for one kind of list, version and organisation.
trait Kind: Message + Default {
    /// Domain separation of the signature, for example from certificates.
    const CONTEXT: &'static [u8];
    /// Its name, and how to shorten it.
    const NAME: &'static str;
    const SHORTER: &'static str;
    /// Most bytes, signature included.
    const LIMIT: usize;

    /// Its version and organisation.
    fn of(&self) -> (u32, &str);
}

fn refused<T: Kind>(why: &str) -> FleetError {
    FleetError::Refused(format!("{} {why}", T::NAME))
}

fn sign<T: Kind>(list: &T, ca: &Ca) -> Result<Vec<u8>, FleetError> {
    let list = list.encode_to_vec();
    let signature = ca.sign(&[T::CONTEXT, &list].concat())?;
    let signed = SignedStations { list, signature }.encode_to_vec();
    if signed.len() > T::LIMIT {
        let why = format!("has {} bytes, at most {} can be: {}", signed.len(), T::LIMIT, T::SHORTER);
        return Err(refused::<T>(&why));
    }
    Ok(signed)
}

fn read<T: Kind>(signed: &[u8], ca: &str, org: &str) -> Result<T, FleetError> {
    if signed.len() > T::LIMIT {
        return Err(refused::<T>("is too long"));
    }
    let unreadable = |_| refused::<T>("cannot be read");
    let signed = SignedStations::decode(signed).map_err(unreadable)?;
    if !verifies(ca, &[T::CONTEXT, &signed.list].concat(), &signed.signature)? {
        return Err(refused::<T>("is not signed by this fleet's authority"));
    }
    let list = T::decode(signed.list.as_slice()).map_err(unreadable)?;
    let (version, whose) = list.of();
    if version != VERSION {
        return Err(refused::<T>("is of another version: use the same version of Vencejo on board and on the ground"));
    }
    if whose != org {
        return Err(refused::<T>("is of another fleet"));
    }
    Ok(list)
}

/// The aircraft that routers admit, from which a router without the authority makes its access control. Signed and
/// numbered like the list of stations.
#[derive(Clone, PartialEq, Message)]
pub struct Admitted {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The organisation.
    #[prost(string, tag = "2")]
    pub org: String,
    /// Incremented with each list.
    #[prost(uint64, tag = "3")]
    pub number: u64,
    /// Their names.
    #[prost(string, repeated, tag = "4")]
    pub aircraft: Vec<String>,
}

impl Kind for Admitted {
    const CONTEXT: &'static [u8] = b"vencejo.v1.Admitted\0";
    const NAME: &'static str = "the list of aircraft";
    const SHORTER: &'static str = "give shorter names, or revoke some";
    const LIMIT: usize = MAX_ADMITTED;

    fn of(&self) -> (u32, &str) {
        (self.version, &self.org)
    }
}

impl Kind for Stations {
    const CONTEXT: &'static [u8] = b"vencejo.v1.Stations\0";
    const NAME: &'static str = "the list of ground stations and routers";
    const SHORTER: &'static str = "revoke some, or give shorter names of hosts";
    const LIMIT: usize = MAX_BYTES;

    fn of(&self) -> (u32, &str) {
        (self.version, &self.org)
    }
}

impl Admitted {
    /// The list as it goes out.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is too long, [`FleetError::Certificate`].
    pub fn signed(&self, ca: &Ca) -> Result<Vec<u8>, FleetError> {
        sign(self, ca)
    }

    /// Reads an untrusted list and verifies its signature.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is not of this authority (PEM) and organisation, or cannot be read.
    pub fn read(signed: &[u8], ca: &str, org: &str) -> Result<Self, FleetError> {
        read(signed, ca, org)
    }
}

impl Stations {
    /// The list as it goes out.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is too long, [`FleetError::Certificate`].
    pub fn signed(&self, ca: &Ca) -> Result<Vec<u8>, FleetError> {
        sign(self, ca)
    }

    /// Reads an untrusted list and verifies its signature.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is not of this authority (PEM) and organisation, or cannot be read.
    pub fn read(signed: &[u8], ca: &str, org: &str) -> Result<Self, FleetError> {
        read(signed, ca, org)
    }

    /// The members that the router of this station admits, aircraft aside.
    pub fn let_in(&self, own: &str) -> LetIn {
        let called = |each: &Listed| format!("{STATION_PREFIX}{}", each.name);
        // The station with the authority is a router for all others.
        let is_router = |each: &&Listed| !each.routers.is_empty() || each.name == GROUND;
        let (routers, stations): (Vec<_>, Vec<_>) = self.stations.iter().partition(is_router);
        let (own, ground) = (format!("{STATION_PREFIX}{own}"), format!("{STATION_PREFIX}{GROUND}"));
        let mut routers: Vec<_> = routers.into_iter().map(called).chain([ground]).filter(|name| *name != own).collect();
        routers.sort();
        routers.dedup();
        // Programs on its own machine show its certificate.
        let stations = [own].into_iter().chain(stations.into_iter().map(called)).collect();
        LetIn { stations, routers, aircraft: Vec::new() }
    }

    /// The keys whose orders count, with their roles.
    pub fn roles(&self) -> BTreeMap<PublicKey, Role> {
        let role = |each: &Listed| Some((PublicKey(each.key.as_slice().try_into().ok()?), Role::named(&each.role)?));
        self.stations.iter().filter_map(role).collect()
    }

    /// The names of the stations, by their keys.
    pub fn names(&self) -> BTreeMap<PublicKey, String> {
        let named = |each: &Listed| Some((PublicKey(each.key.as_slice().try_into().ok()?), each.name.clone()));
        self.stations.iter().filter_map(named).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::papers::certificate::Ca;

    #[test]
    fn a_list_is_believed_of_its_authority_alone() {
        let now = 1_800_000_000;
        let org = "acme".parse().expect("a name");
        let (certificate, key) = Ca::make(&org, now).expect("made");
        let (other, other_key) = Ca::make(&org, now).expect("made");
        let ca = Ca::read(&certificate, &key).expect("read");
        let listed =
            |role: &str, key: u8| Listed { name: role.into(), key: vec![key; 32], role: role.into(), routers: vec![] };
        let list = Stations {
            version: VERSION,
            org: "acme".into(),
            number: 7,
            stations: vec![listed("chief", 1), listed("observer", 2), listed("emperor", 3)],
            ..Stations::default()
        };
        let signed = list.signed(&ca).expect("signed");
        let read = Stations::read(&signed, &certificate, "acme").expect("good");
        assert_eq!(read, list);
        assert_eq!(read.names().get(&PublicKey([2; 32])).map(String::as_str), Some("observer"));
        // A role of a later version is none here.
        assert_eq!(read.roles(), [(PublicKey([1; 32]), Role::Chief), (PublicKey([2; 32]), Role::Observer)].into());
        let forged = list.signed(&Ca::read(&other, &other_key).expect("read")).expect("signed");
        let changed = SignedStations {
            list: Stations { number: 8, ..list.clone() }.encode_to_vec(),
            ..SignedStations::decode(signed.as_slice()).expect("a list")
        };
        let later = Stations { version: 2, ..list.clone() }.signed(&ca).expect("signed");
        let admitted = Admitted { version: VERSION, org: "acme".into(), number: 7, aircraft: vec!["plane7".into()] };
        let told = admitted.signed(&ca).expect("signed");
        assert_eq!(Admitted::read(&told, &certificate, "acme"), Ok(admitted));
        for (bytes, org, says) in [(&signed, "acme", "not signed"), (&told, "other", "another fleet")] {
            let error = Admitted::read(bytes, &certificate, org).expect_err(says).to_string();
            assert!(error.contains(says), "{error}");
        }
        for (bytes, org, says) in [
            (&told, "acme", "not signed by this fleet's authority"),
            (&forged, "acme", "not signed by this fleet's authority"),
            (&changed.encode_to_vec(), "acme", "not signed"),
            (&signed, "other", "of another fleet"),
            (&later, "acme", "the same version of Vencejo"),
            (&vec![0xff], "acme", "cannot be read"),
            (&vec![0; MAX_BYTES + 1], "acme", "too long"),
        ] {
            let error = Stations::read(bytes, &certificate, org).expect_err(says).to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn a_router_takes_another_for_one_only_by_the_list() {
        let listed = |name: &str, routers: Vec<String>| Listed { name: name.into(), routers, ..Listed::default() };
        let hill = vec!["tls/hill:7447".to_owned()];
        let stations = vec![listed("ground", vec![]), listed("hill", hill.clone()), listed("tower", vec![])];
        let list = Stations { stations, ..Stations::default() };
        let LetIn { stations, routers, .. } = list.let_in("ground");
        assert_eq!((stations, routers), (vec!["_ground".into(), "_tower".into()], vec!["_hill".to_owned()]));
        let LetIn { stations, routers, .. } = list.let_in("hill");
        assert_eq!((stations, routers), (vec!["_hill".into(), "_tower".into()], vec!["_ground".to_owned()]));
    }
}
