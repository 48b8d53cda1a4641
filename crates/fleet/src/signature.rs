//! Signatures of orders: Ed25519 (RFC 8032). Who carries an order can neither make one nor change it.

use std::fmt;
use std::str::FromStr;

use ring::signature::{ED25519, Ed25519KeyPair, KeyPair, UnparsedPublicKey};
use thiserror::Error;

/// Says what is signed, so that a signature made for something else is none here.
const CONTEXT: &[u8] = b"vencejo.v1.Order\0";

/// An operator's public key, as 64 hexadecimal digits where people see it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PublicKey(pub [u8; 32]);

/// A text that is no public key.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is not a public key: one has 64 hexadecimal digits; `vencejo serve --fleet` shows its own")]
pub struct BadKey(pub String);

impl fmt::Display for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PublicKey({self})")
    }
}

impl FromStr for PublicKey {
    type Err = BadKey;

    fn from_str(text: &str) -> Result<Self, BadKey> {
        let bad = || BadKey(vencejo_proto::plain(text, 80));
        let mut key = [0; 32];
        if text.len() != 64 || !text.is_ascii() {
            return Err(bad());
        }
        for (byte, digits) in key.iter_mut().zip(text.as_bytes().chunks(2)) {
            let digits = str::from_utf8(digits).map_err(|_| bad())?;
            *byte = u8::from_str_radix(digits, 16).map_err(|_| bad())?;
        }
        Ok(Self(key))
    }
}

impl PublicKey {
    /// Whether `signature` is what the owner of this key made of these bytes.
    pub fn verifies(&self, bytes: &[u8], signature: &[u8]) -> bool {
        UnparsedPublicKey::new(&ED25519, self.0).verify(&[CONTEXT, bytes].concat(), signature).is_ok()
    }
}

/// What signs. Its secret shows nowhere.
pub struct Signer(Ed25519KeyPair);

impl Signer {
    /// Bytes of the secret.
    pub const SEED_LEN: usize = 32;

    /// The signer with this secret, all of which are good.
    pub fn from_seed(seed: &[u8; Self::SEED_LEN]) -> Self {
        Self(Ed25519KeyPair::from_seed_unchecked(seed).expect("invariant: any 32 bytes are a secret of Ed25519"))
    }

    /// Its public key.
    pub fn public(&self) -> PublicKey {
        let mut key = [0; 32];
        key.copy_from_slice(self.0.public_key().as_ref());
        PublicKey(key)
    }

    /// The signature of these bytes.
    pub fn sign(&self, bytes: &[u8]) -> Vec<u8> {
        self.0.sign(&[CONTEXT, bytes].concat()).as_ref().to_vec()
    }
}

impl fmt::Debug for Signer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Signer({})", self.public())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_owner_signs_and_only_what_it_signed() {
        let (ana, eve) = (Signer::from_seed(&[1; 32]), Signer::from_seed(&[2; 32]));
        let signature = ana.sign(b"arm");
        assert!(ana.public().verifies(b"arm", &signature));
        assert!(!ana.public().verifies(b"disarm", &signature));
        assert!(!eve.public().verifies(b"arm", &signature));
        assert!(!ana.public().verifies(b"arm", &eve.sign(b"arm")));
        assert!(!ana.public().verifies(b"arm", &[]) && !PublicKey([0xff; 32]).verifies(b"arm", &signature));
        let bare = ana.0.sign(b"arm");
        assert!(!ana.public().verifies(b"arm", bare.as_ref()), "made for something else");
    }

    #[test]
    fn the_first_vector_of_rfc_8032() {
        let seed = "9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60".parse::<PublicKey>();
        let public = "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a";
        assert_eq!(Signer::from_seed(&seed.expect("hexadecimal").0).public().to_string(), public);
    }

    #[test]
    fn keys_are_read_as_they_are_shown() {
        let key = Signer::from_seed(&[7; 32]).public();
        assert_eq!(key.to_string().parse(), Ok(key));
        for bad in ["", "abc", &"g".repeat(64), &"é".repeat(32)] {
            assert!(bad.parse::<PublicKey>().is_err(), "{bad}");
        }
    }
}
