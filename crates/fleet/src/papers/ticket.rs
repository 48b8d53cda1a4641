//! The token that brings one aircraft or ground station into a fleet, as the text that a person copies: whom to ask,
//! how to know them, and the secret.

use std::fmt;
use std::str::FromStr;

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use prost::Message;

use super::certificate::sha256;
use crate::error::FleetError;
use crate::key::Name;

/// How each begins: the version.
const PREFIX: &str = "vf1.";
/// Characters of a token at most.
const MAX_TEXT: usize = 2048;
/// Bytes at its end by which a slip of the copy is known.
const CHECK: usize = 4;
/// Bytes of its secret.
pub const SECRET_LEN: usize = 16;
/// Addresses in it at most.
pub const MAX_DOORS: usize = 8;

/// What a token says. Its secret shows nowhere but in the token.
#[derive(Clone, PartialEq, Message)]
pub struct Ticket {
    /// SHA-256 of the certificate of the organisation's authority: who answers shows one that it signed.
    #[prost(bytes = "vec", tag = "1")]
    pub fingerprint: Vec<u8>,
    /// What the newcomer shows.
    #[prost(bytes = "vec", tag = "2")]
    pub secret: Vec<u8>,
    /// Where to ask: `HOST:PORT`.
    #[prost(string, repeated, tag = "3")]
    pub doors: Vec<String>,
    /// The organisation, so that a computer knows before it asks where it keeps what it gets.
    #[prost(string, tag = "4")]
    pub org: String,
    /// Whether it is for a ground station.
    #[prost(bool, tag = "5")]
    pub is_station: bool,
}

impl Ticket {
    /// The token, to be shown once.
    pub fn text(&self) -> String {
        let mut bytes = self.encode_to_vec();
        let check = sha256(&bytes);
        bytes.extend_from_slice(&check[..CHECK]);
        format!("{PREFIX}{}", URL_SAFE_NO_PAD.encode(bytes))
    }

    /// What is kept of it on the ground.
    pub fn hash(&self) -> String {
        hex(&sha256(&self.secret))
    }
}

/// Bytes in hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    use fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a string never fails.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

impl FromStr for Ticket {
    type Err = FleetError;

    fn from_str(text: &str) -> Result<Self, FleetError> {
        let bad = |why: &str| FleetError::Token(why.to_owned());
        let text = text.trim();
        if text.len() > MAX_TEXT {
            return Err(bad("it is too long"));
        }
        let rest = text.strip_prefix(PREFIX).ok_or_else(|| bad("one begins with vf1."))?;
        let bytes = URL_SAFE_NO_PAD.decode(rest).map_err(|_| bad("a character of it is wrong, or missing"))?;
        let split = bytes.len().checked_sub(CHECK).ok_or_else(|| bad("a part of it is missing"))?;
        let (bytes, check) = bytes.split_at(split);
        if sha256(bytes)[..CHECK] != *check {
            return Err(bad("a character of it is wrong, or missing"));
        }
        let ticket = Self::decode(bytes).map_err(|_| bad("it is of another version"))?;
        let is_whole = ticket.fingerprint.len() == 32
            && ticket.org.parse::<Name>().is_ok()
            && ticket.secret.len() == SECRET_LEN
            && (1..=MAX_DOORS).contains(&ticket.doors.len());
        if is_whole { Ok(ticket) } else { Err(bad("it is of another version")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticket() -> Ticket {
        Ticket {
            fingerprint: vec![7; 32],
            secret: vec![9; 16],
            doors: vec!["ground.local:7448".into()],
            org: "acme".into(),
            is_station: true,
        }
    }

    #[test]
    fn a_token_is_read_as_it_is_shown_and_no_other_way() {
        let text = ticket().text();
        assert_eq!(format!(" {text}\n").parse::<Ticket>(), Ok(ticket()));
        for at in PREFIX.len()..text.len() {
            let mut slip = text.clone().into_bytes();
            slip[at] = if slip[at] == b'A' { b'B' } else { b'A' };
            let slip = String::from_utf8(slip).expect("letters");
            // The last character has bits that mean nothing, which must be zero.
            assert!(slip.parse::<Ticket>().is_err(), "{slip}");
        }
        for bad in ["", "vf1.", "vf2.AAAA", &text[..40], &"x".repeat(5000)] {
            let error = bad.parse::<Ticket>().expect_err("no token").to_string();
            assert!(error.contains("copy it again"), "{error}");
        }
    }
}
