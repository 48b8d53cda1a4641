//! MAVLink 2 message signing: the signature of a frame, and what one key has signed and accepted so far.
//!
//! A signature is 13 bytes behind the checksum: a link id, 48 bits of time in units of 10 µs since 2015, and the first
//! 48 bits of SHA-256 over key, frame and those seven bytes (mavlink.io, "Message Signing"). It proves the sender and
//! prevents replay; it does not encrypt.
//!
//! [`KeyUse`] is the state machine of one key. Nothing in a frame is believed before its tag is verified, not even its
//! time (a forged time far in the future would silence the true sender); times too far in the future are refused; the
//! signing time never repeats, is never lower than one that was seen, and ends before it would wrap.

use std::collections::HashMap;
use std::fmt;
use std::time::Duration;

use bytes::{BufMut, BytesMut};
use sha2::{Digest, Sha256};

use crate::checksum::checksum;
use crate::frame::{CHECKSUM_LEN, Frame, HEADER_LEN_V2, IFLAG_SIGNED, MavVersion, SIGNATURE_LEN};
use crate::ids::Address;
use crate::info::info;

/// Bytes of the tag at the end of a signature.
const TAG_LEN: usize = 6;
/// Bytes of a timestamp.
const TIME_LEN: usize = 6;
/// 2015-01-01T00:00:00Z, where signing time begins, in microseconds since the UNIX epoch.
const EPOCH_UNIX_US: u64 = 1_420_070_400_000_000;
/// 2026-01-01T00:00:00Z: a clock that says less has not been set.
const LEAST_UNIX_US: u64 = 1_767_225_600_000_000;
/// A stream that was not heard before must not be older than this (mavlink.io, "Message Signing", timestamp handling).
const NEWCOMER_AGE: Duration = Duration::from_secs(60);
/// How far ahead of our own time a stream may be: an autopilot adds a minute each time that it starts, a clock may be
/// set to another time zone. Nothing honest is further ahead.
const FUTURE: Duration = Duration::from_secs(24 * 3600);
/// Never believed, whatever our own clock says: the last year before the 48 bits end (in 2104).
const LAST: SigningTime = SigningTime(SigningTime::MAX.0 - 365 * 24 * 3600 * 100_000);
/// How far ahead [`KeyUse::reserve`] reserves.
const RESERVE: Duration = Duration::from_secs(60);
/// Streams followed for one key. Only who has the key can open one.
const MAX_STREAMS: usize = 256;

/// A secret key. Never printed, neither in a log nor in an error.
#[derive(Clone, PartialEq, Eq)]
pub struct SigningKey([u8; Self::LEN]);

impl SigningKey {
    /// Bytes of a key.
    pub const LEN: usize = 32;

    /// A key of these bytes. `None` for zeros: on the wire they mean "sign no more".
    pub fn new(bytes: [u8; Self::LEN]) -> Option<Self> {
        bytes.iter().any(|byte| *byte != 0).then_some(Self(bytes))
    }

    /// The key that other ground stations make of a passphrase: its SHA-256.
    pub fn from_passphrase(passphrase: &str) -> Self {
        Self(Sha256::digest(passphrase.as_bytes()).into())
    }

    /// The bytes, for the message that carries them and for the file that keeps them.
    pub fn expose(&self) -> &[u8; Self::LEN] {
        &self.0
    }

    fn tag(&self, signed: &[u8]) -> [u8; TAG_LEN] {
        let digest = Sha256::new().chain_update(self.0).chain_update(signed).finalize();
        let mut tag = [0; TAG_LEN];
        tag.copy_from_slice(&digest[..TAG_LEN]);
        tag
    }
}

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SigningKey(secret)")
    }
}

/// A signature timestamp: units of 10 µs since 2015-01-01T00:00:00Z, 48 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct SigningTime(u64);

impl SigningTime {
    /// The last one, in 2104.
    pub const MAX: Self = Self((1 << 48) - 1);

    /// From its number; larger ones become [`Self::MAX`].
    pub fn from_ticks(ticks: u64) -> Self {
        Self(ticks.min(Self::MAX.0))
    }

    /// From wall time. Moments before 2015 become 0.
    pub fn from_unix_us(unix_us: u64) -> Self {
        Self::from_ticks(unix_us.saturating_sub(EPOCH_UNIX_US) / 10)
    }

    /// Its number.
    pub fn ticks(self) -> u64 {
        self.0
    }

    /// The moment in wall time, in microseconds since the UNIX epoch.
    pub fn unix_us(self) -> u64 {
        EPOCH_UNIX_US + self.0 * 10
    }

    /// Later by a duration, at most [`Self::MAX`].
    pub fn after(self, wait: Duration) -> Self {
        Self::from_ticks(self.0.saturating_add(u64::try_from(wait.as_micros() / 10).unwrap_or(u64::MAX)))
    }
}

/// The contents of a frame's signature, not verified yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signature {
    /// The sender's number of the link.
    pub link_id: u8,
    /// When it was signed, as the sender says.
    pub time: SigningTime,
    tag: [u8; TAG_LEN],
}

impl Frame {
    /// The signature, if there is one.
    pub fn signature(&self) -> Option<Signature> {
        if !self.is_signed() {
            return None;
        }
        let bytes = self.bytes();
        let (_, signature) = bytes.split_at(bytes.len() - SIGNATURE_LEN);
        let mut time = [0; 8];
        time[..TIME_LEN].copy_from_slice(&signature[1..=TIME_LEN]);
        let mut tag = [0; TAG_LEN];
        tag.copy_from_slice(&signature[1 + TIME_LEN..]);
        Some(Signature { link_id: signature[0], time: SigningTime(u64::from_le_bytes(time)), tag })
    }

    /// The same message without its signature. The checksum covers the signature flag, so it changes.
    pub fn without_signature(&self) -> Self {
        if !self.is_signed() {
            return self.clone();
        }
        let checksum_at = self.bytes().len() - SIGNATURE_LEN - CHECKSUM_LEN;
        let old = u16::from_le_bytes([self.bytes()[checksum_at], self.bytes()[checksum_at + 1]]);
        let mut bytes = BytesMut::from(&self.bytes()[..checksum_at]);
        // The seed of a message that the dialect does not have follows from the checksum that was there.
        let found = || (0..=u8::MAX).find(|seed| checksum(&bytes[1..], *seed) == old);
        let seed = info(self.message_id()).map(|info| info.extra_crc).or_else(found);
        bytes[2] &= !IFLAG_SIGNED;
        let renewed = seed.map_or(old, |seed| checksum(&bytes[1..], seed));
        bytes.put_u16_le(renewed);
        Self::from_checked(bytes.freeze())
    }

    /// The same message with a signature; one that it has is replaced. `None` when it cannot have one: MAVLink 1, or a
    /// message that the dialect does not have.
    pub fn signed(&self, key: &SigningKey, link_id: u8, time: SigningTime) -> Option<Self> {
        let extra_crc = info(self.message_id())?.extra_crc;
        if self.version() == MavVersion::V1 {
            return None;
        }
        let checked_len = HEADER_LEN_V2 + self.payload().len();
        let mut bytes = BytesMut::with_capacity(checked_len + CHECKSUM_LEN + SIGNATURE_LEN);
        bytes.extend_from_slice(&self.bytes()[..checked_len]);
        bytes[2] |= IFLAG_SIGNED;
        let checksum = checksum(&bytes[1..], extra_crc);
        bytes.put_u16_le(checksum);
        bytes.put_u8(link_id);
        bytes.extend_from_slice(&time.0.to_le_bytes()[..TIME_LEN]);
        let tag = key.tag(&bytes);
        bytes.extend_from_slice(&tag);
        Some(Self::from_checked(bytes.freeze()))
    }
}

/// Why a frame was not accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum SignatureFault {
    /// It carries no signature.
    #[error("the frame is not signed")]
    Unsigned,
    /// Signed with another key, or changed on the way.
    #[error("the frame was signed with another key, or changed on the way")]
    WrongKey,
    /// Not later than what was accepted from that stream.
    #[error("the frame is not later than one that was accepted before")]
    Replayed,
    /// The first of its stream, and older than a minute.
    #[error("the first frame of its stream is older than a minute")]
    Old,
    /// Too far ahead of our time.
    #[error("the frame's time lies in the future")]
    Future,
    /// More senders use the key than are followed.
    #[error("more than {MAX_STREAMS} senders and links use the key")]
    TooManyStreams,
}

impl SignatureFault {
    /// Whether the sender has the key, and only the time was wrong.
    pub fn has_key(self) -> bool {
        !matches!(self, Self::Unsigned | Self::WrongKey)
    }
}

/// The times that can be signed with have come to their end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("nothing can be signed after the year 2104: set this machine's clock, and make a new key")]
pub struct TimeExhausted;

/// One key: what was signed with it and what was accepted.
///
/// Time comes in as the wall clock's, in microseconds since the UNIX epoch, and is mistrusted: it may be that of a
/// machine without a battery-backed clock, or jump.
#[derive(Debug)]
pub struct KeyUse {
    key: SigningKey,
    /// The latest time that was signed with or accepted.
    latest: SigningTime,
    /// The latest of our own clock; what others say does not move it.
    own: SigningTime,
    /// All that an earlier run may have signed or accepted lies at or before this.
    resumed: SigningTime,
    /// The last time accepted of each sender and link.
    streams: HashMap<(Address, u8), SigningTime>,
}

impl KeyUse {
    /// A key whose earlier use ended at or before `resumed`: what [`Self::reserve`] or [`Self::latest`] said in that
    /// run.
    pub fn new(key: SigningKey, resumed: SigningTime) -> Self {
        let resumed = resumed.min(LAST);
        Self { key, latest: resumed, own: resumed, resumed, streams: HashMap::new() }
    }

    /// The key.
    pub fn key(&self) -> &SigningKey {
        &self.key
    }

    /// The latest time that was signed with or accepted: where the next run may resume when this one ends in order.
    pub fn latest(&self) -> SigningTime {
        self.latest
    }

    /// The time to put on disk now, at least once a minute: the next run resumes there however this one ends.
    pub fn reserve(&mut self, unix_us: u64) -> SigningTime {
        self.look_at_clock(unix_us);
        self.latest.max(self.own).after(RESERVE).min(LAST)
    }

    /// Signs a frame as it leaves. `None` when the frame cannot be signed: see [`Frame::signed`].
    ///
    /// # Errors
    /// [`TimeExhausted`].
    pub fn sign(&mut self, frame: &Frame, link_id: u8, unix_us: u64) -> Result<Option<Frame>, TimeExhausted> {
        let time = self.next_time(unix_us)?;
        Ok(frame.signed(&self.key, link_id, time))
    }

    /// A time to sign with that was not used before.
    ///
    /// # Errors
    /// [`TimeExhausted`].
    pub fn next_time(&mut self, unix_us: u64) -> Result<SigningTime, TimeExhausted> {
        self.look_at_clock(unix_us);
        let next = SigningTime(self.latest.0 + 1).max(self.own);
        if next > SigningTime::MAX {
            return Err(TimeExhausted);
        }
        self.latest = next;
        Ok(next)
    }

    /// Whether a frame is signed with the key and newer than all before.
    ///
    /// # Errors
    /// The [`SignatureFault`]; a frame that is at fault changes nothing.
    pub fn accept(&mut self, frame: &Frame, unix_us: u64) -> Result<(), SignatureFault> {
        let signature = frame.signature().ok_or(SignatureFault::Unsigned)?;
        let bytes = frame.bytes();
        if !same_tag(self.key.tag(&bytes[..bytes.len() - TAG_LEN]), signature.tag) {
            return Err(SignatureFault::WrongKey);
        }
        self.look_at_clock(unix_us);
        let time = signature.time;
        let stream = (frame.source(), signature.link_id);
        match self.streams.get(&stream) {
            Some(last) if time <= *last => return Err(SignatureFault::Replayed),
            Some(_) => {}
            None if time <= self.resumed => return Err(SignatureFault::Replayed),
            None if time.after(NEWCOMER_AGE) < self.latest.max(self.own) => return Err(SignatureFault::Old),
            None if self.streams.len() == MAX_STREAMS => return Err(SignatureFault::TooManyStreams),
            None => {}
        }
        // A clock that was never set, or that is behind what an earlier run saw, says nothing about the future.
        let knows_time = unix_us >= LEAST_UNIX_US && SigningTime::from_unix_us(unix_us).after(FUTURE) >= self.resumed;
        if time > LAST || (knows_time && time > self.own.after(FUTURE)) {
            return Err(SignatureFault::Future);
        }
        self.streams.insert(stream, time);
        self.latest = self.latest.max(time);
        Ok(())
    }

    /// Our own time never goes back, and does not follow a clock into the last year.
    fn look_at_clock(&mut self, unix_us: u64) {
        let clock = SigningTime::from_unix_us(unix_us);
        if clock <= LAST {
            self.own = self.own.max(clock);
        }
    }
}

/// Compares in constant time.
fn same_tag(a: [u8; TAG_LEN], b: [u8; TAG_LEN]) -> bool {
    a.iter().zip(b).fold(0, |different, (a, b)| different | (a ^ b)) == 0
}

#[cfg(test)]
mod tests;
