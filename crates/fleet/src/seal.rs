//! Marks of pictures: by them the station on board knows that the moment which an order is based on is one that it told of. No I/O.
//!
//! The age of an order is counted from the clock on board in the state that its operator saw. Whoever carries states could tell of a moment
//! to come, and bring then what was ordered now. So each state has a mark that nobody can make before the moment has come.

use ring::hmac;
use vencejo_proto::MonoTime;

/// Says what is marked.
const CONTEXT: &[u8] = b"vencejo.v1.Picture\0";

/// A moment on board, in whole milliseconds, and its mark: what an order is based on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Picture {
    /// The clock on board.
    pub at: MonoTime,
    /// The mark of that.
    pub mark: u64,
}

/// What makes the marks of one boot.
#[derive(Debug, Clone)]
pub struct Seal(hmac::Key);

impl Seal {
    /// With this secret, which is random and leaves the program in no way.
    pub fn new(secret: &[u8; 32]) -> Self {
        Self(hmac::Key::new(hmac::HMAC_SHA256, secret))
    }

    /// The picture of a moment: the first 64 bits of HMAC-SHA-256 (RFC 2104). Who guesses has to bring each guess on board.
    pub fn picture(&self, clock_ms: u64) -> Picture {
        let tag = hmac::sign(&self.0, &[CONTEXT, &clock_ms.to_be_bytes()].concat());
        let mark = tag.as_ref().first_chunk().map_or(0, |mark| u64::from_be_bytes(*mark));
        Picture { at: MonoTime::from_millis(clock_ms), mark }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_moment_and_no_boot_has_the_mark_of_another() {
        let (first, second) = (Seal::new(&[1; 32]), Seal::new(&[2; 32]));
        let picture = first.picture(1_000);
        assert_eq!((picture.at, picture), (MonoTime::from_millis(1_000), first.picture(1_000)));
        assert_ne!(picture.mark, first.picture(1_001).mark);
        assert_ne!(picture.mark, second.picture(1_000).mark);
    }
}
