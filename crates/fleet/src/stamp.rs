//! Stamps of states: by them the station on board knows that an order is based on a state that it has sent. No I/O.
//!
//! The age of an order is measured by the clock on board in the state that its operator saw. The network could fake a
//! state of a future moment and deliver then what was ordered now. So each state has a mark (a MAC) that cannot be
//! computed without the key on board.

use ring::hmac;
use vencejo_proto::MonoTime;

/// Domain separation of the MAC.
const CONTEXT: &[u8] = b"vencejo.v1.Picture\0";

/// A time on board, in whole milliseconds, and its mark: the state that an order is based on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StateStamp {
    /// The clock on board.
    pub at: MonoTime,
    /// The mark of that time.
    pub mark: u64,
}

/// Computes the stamps of one boot.
#[derive(Debug, Clone)]
pub struct Stamper(hmac::Key);

impl Stamper {
    /// With this secret, which is random and never leaves the program.
    pub fn new(secret: &[u8; 32]) -> Self {
        Self(hmac::Key::new(hmac::HMAC_SHA256, secret))
    }

    /// The stamp of a time: the first 64 bits of HMAC-SHA-256 (RFC 2104). Each guess has to be sent to the aircraft.
    pub fn stamp(&self, clock_ms: u64) -> StateStamp {
        let tag = hmac::sign(&self.0, &[CONTEXT, &clock_ms.to_be_bytes()].concat());
        let mark = tag.as_ref().first_chunk().map_or(0, |mark| u64::from_be_bytes(*mark));
        StateStamp { at: MonoTime::from_millis(clock_ms), mark }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_moment_and_no_boot_has_the_mark_of_another() {
        let (first, second) = (Stamper::new(&[1; 32]), Stamper::new(&[2; 32]));
        let picture = first.stamp(1_000);
        assert_eq!((picture.at, picture), (MonoTime::from_millis(1_000), first.stamp(1_000)));
        assert_ne!(picture.mark, first.stamp(1_001).mark);
        assert_ne!(picture.mark, second.stamp(1_000).mark);
    }
}
