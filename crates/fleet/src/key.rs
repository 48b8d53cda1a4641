//! Names of organisations and aircraft, and the keys under which their data goes: version 1 of the key space.
//!
//! `vencejo/1/<org>/<aircraft>/…`: the aircraft before the kind, so that one prefix is one access rule and
//! `vencejo/1/<org>/*/state` lists all. An aircraft's name is never its MAVLink system id, which is not unique.

use std::borrow::Borrow;
use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Most characters of a name.
const MAX_NAME: usize = 32;

/// Name of an organisation or an aircraft: 1 to 32 of `a-z`, `0-9` and `-`, none of which the network interprets.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(String);

/// An invalid name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is not a valid name: use 1 to 32 of a-z, 0-9 and '-'")]
pub struct BadName(pub String);

impl Name {
    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for Name {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let is_good = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
        if text.is_empty() || text.len() > MAX_NAME || !text.bytes().all(is_good) {
            // Only its beginning is shown.
            return Err(BadName(vencejo_proto::plain(text, 2 * MAX_NAME)));
        }
        Ok(Self(text.to_owned()))
    }
}

/// A map by name can be searched by the text of a key.
impl Borrow<str> for Name {
    fn borrow(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The kinds of keys of an aircraft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A liveliness token: the station on board is reachable, whether or not the autopilot is heard.
    Alive,
    /// [`State`](crate::payload::State), again and again; the oldest is dropped.
    State,
    /// [`Event`](crate::payload::Event), numbered; queried with `from=NUMBER` it replies with those from there on.
    Event,
    /// Receives a signed [`Order`](crate::payload::Order), replies with an [`Answer`](crate::payload::Answer).
    Order,
    /// Replies with the [`Index`](crate::history::Index) of the history on board.
    HistoryIndex,
    /// Receives a [`Wanted`](crate::history::Wanted), replies with a [`Piece`](crate::history::Piece).
    HistoryChunk,
    /// Queried with `list=DIGEST;from=OFFSET` it replies with that piece of a list, or with nothing for an unknown
    /// list.
    List,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Alive, Self::State, Self::Event, Self::Order, Self::List, Self::HistoryIndex, Self::HistoryChunk];

    /// Its part of the key.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::State => "state",
            Self::Event => "event",
            Self::Order => "order",
            Self::HistoryIndex => "history/index",
            Self::HistoryChunk => "history/chunk",
            Self::List => "list",
        }
    }
}

/// The key of one kind of an aircraft.
pub fn key_of(org: &Name, aircraft: &Name, kind: Kind) -> String {
    format!("vencejo/1/{org}/{aircraft}/{}", kind.as_str())
}

/// The keys of one kind of all aircraft.
pub fn keys_of_all(org: &Name, kind: Kind) -> String {
    format!("vencejo/1/{org}/*/{}", kind.as_str())
}

/// The key of echoes, by which an aircraft measures the route to the router. No aircraft can have that name.
pub fn echo_key(org: &Name) -> String {
    format!("vencejo/1/{org}/_hub/echo")
}

/// The key of the list of ground stations, queried with `have=NUMBER`: the reply is a newer list, or nothing.
pub fn stations_key(org: &Name) -> String {
    format!("vencejo/1/{org}/_hub/stations")
}

/// The key of the list of aircraft, queried likewise by routers without the authority.
pub fn admitted_key(org: &Name) -> String {
    format!("vencejo/1/{org}/_hub/admitted")
}

/// The keys of all three.
pub fn keys_of_hub(org: &Name) -> String {
    format!("vencejo/1/{org}/_hub/*")
}

/// The aircraft part of a key of this organisation and kind.
pub fn aircraft_of<'a>(org: &Name, kind: Kind, key: &'a str) -> Option<&'a str> {
    let rest = key.strip_prefix("vencejo/1/")?.strip_prefix(org.as_str())?.strip_prefix('/')?;
    rest.strip_suffix(kind.as_str())?.strip_suffix('/').filter(|name| !name.contains('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_mean_nothing_to_the_network() {
        for good in ["a", "plane7", "north-1", &"x".repeat(32)] {
            assert_eq!(good.parse::<Name>().map(|name| name.to_string()), Ok(good.to_owned()));
        }
        for bad in ["", "Plane", "a/b", "*", "$x", "a b", "_hub", "#", "?", "@", "ñ", &"x".repeat(33)] {
            assert!(bad.parse::<Name>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_key_tells_whose_it_is() {
        let (org, aircraft): (Name, Name) = ("acme".parse().expect("a name"), "plane7".parse().expect("a name"));
        for kind in Kind::ALL {
            let key = key_of(&org, &aircraft, kind);
            assert_eq!(aircraft_of(&org, kind, &key), Some(aircraft.as_str()), "{key}");
            assert_eq!(keys_of_all(&org, kind).replace('*', aircraft.as_str()), key);
        }
        let state = Kind::State;
        for other in ["vencejo/1/acme/plane7/event", "vencejo/1/acme2/plane7/state", "vencejo/2/acme/plane7/state"] {
            assert_eq!(aircraft_of(&org, state, other), None, "{other}");
        }
        assert!(
            aircraft_of(&org, state, "vencejo/1/acme/_hub/state").is_some_and(|name| name.parse::<Name>().is_err())
        );
        assert_eq!(aircraft_of(&org, state, "vencejo/1/acme/a/b/state"), None);
    }
}
