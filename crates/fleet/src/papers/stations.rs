//! The list of a fleet's ground stations, their keys and roles, and where routers are: signed by the authority, and numbered.
//!
//! Every aircraft keeps the newest that it has seen, whoever brought it: who carries a list can neither make one nor change it, and an
//! older one is never taken in place of a newer.

use std::collections::BTreeMap;

use prost::Message;

use super::certificate::{Ca, verifies};
use crate::authority::Role;
use crate::error::FleetError;
use crate::payload::VERSION;
use crate::signature::PublicKey;

/// Says what is signed, so that a signature of the authority for something else, such as a certificate, is none here.
const CONTEXT: &[u8] = b"vencejo.v1.Stations\0";
/// Bytes of a signed list at most.
pub const MAX_BYTES: usize = 12 * 1024;
/// Ground stations in it at most.
pub const MAX_STATIONS: usize = 64;
/// Addresses of routers in it at most.
pub const MAX_ROUTERS: usize = 16;

/// One ground station.
#[derive(Clone, PartialEq, Message)]
pub struct Listed {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// The key that it signs orders with.
    #[prost(bytes = "vec", tag = "2")]
    pub key: Vec<u8>,
    /// Its role, by name. One that is not known here is none.
    #[prost(string, tag = "3")]
    pub role: String,
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
    /// Grows with each list.
    #[prost(uint64, tag = "3")]
    pub number: u64,
    /// The ground stations.
    #[prost(message, repeated, tag = "4")]
    pub stations: Vec<Listed>,
    /// Where routers are, in the order in which they are tried.
    #[prost(string, repeated, tag = "5")]
    pub routers: Vec<String>,
    /// Where certificates are renewed, `HOST:PORT`.
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

impl Stations {
    /// The list as it goes out.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is too long, [`FleetError::Certificate`].
    pub fn signed(&self, ca: &Ca) -> Result<Vec<u8>, FleetError> {
        let list = self.encode_to_vec();
        let signature = ca.sign(&[CONTEXT, &list].concat())?;
        let signed = SignedStations { list, signature }.encode_to_vec();
        if signed.len() > MAX_BYTES {
            return Err(FleetError::Refused(format!(
                "the list of ground stations and routers has {} bytes, at most {MAX_BYTES} can be: revoke some, or give shorter names of hosts",
                signed.len()
            )));
        }
        Ok(signed)
    }

    /// A list from anybody, whose signature is looked at.
    ///
    /// # Errors
    /// [`FleetError::Refused`] where it is not of this authority (PEM) and organisation, or cannot be read.
    pub fn read(signed: &[u8], ca: &str, org: &str) -> Result<Self, FleetError> {
        let bad = |why: &str| FleetError::Refused(format!("the list of ground stations {why}"));
        if signed.len() > MAX_BYTES {
            return Err(bad("is too long"));
        }
        let signed = SignedStations::decode(signed).map_err(|_| bad("cannot be read"))?;
        if !verifies(ca, &[CONTEXT, &signed.list].concat(), &signed.signature)? {
            return Err(bad("is not signed by this fleet's authority"));
        }
        let list = Self::decode(signed.list.as_slice()).map_err(|_| bad("cannot be read"))?;
        if list.version != VERSION {
            return Err(bad("is of another version: use the same version of Vencejo on board and on the ground"));
        }
        if list.org != org {
            return Err(bad("is of another fleet"));
        }
        Ok(list)
    }

    /// The keys whose orders count, with their roles.
    #[must_use]
    pub fn roles(&self) -> BTreeMap<PublicKey, Role> {
        let role = |each: &Listed| Some((PublicKey(each.key.as_slice().try_into().ok()?), Role::named(&each.role)?));
        self.stations.iter().filter_map(role).collect()
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
        let listed = |role: &str, key: u8| Listed { name: role.into(), key: vec![key; 32], role: role.into() };
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
        // A role of a later version is none here.
        assert_eq!(read.roles(), [(PublicKey([1; 32]), Role::Chief), (PublicKey([2; 32]), Role::Observer)].into());
        let forged = list.signed(&Ca::read(&other, &other_key).expect("read")).expect("signed");
        let changed = SignedStations {
            list: Stations { number: 8, ..list.clone() }.encode_to_vec(),
            ..SignedStations::decode(signed.as_slice()).expect("a list")
        };
        let later = Stations { version: 2, ..list.clone() }.signed(&ca).expect("signed");
        for (bytes, org, says) in [
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
}
