//! What a history is made of, and how a ground station asks for what it has not heard.

use thiserror::Error;

use super::ranges::Ranges;
use crate::payload::{Answer, BadPayload, MAX_BYTES, Order, VERSION};

/// Bytes of records in one piece at most.
pub const MAX_PIECE_BYTES: u32 = 32 * 1024;
/// Bytes of an answer at most: a piece, and what stands around each of its records.
pub const MAX_ANSWER_BYTES: usize = 48 * 1024;
/// Ranges in one index at most.
pub const MAX_SPANS: usize = 400;

/// Numbered from 1 in each boot, without holes, each on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stream {
    /// [`State`](crate::payload::State), by its sequence.
    State,
    /// [`Event`](crate::payload::Event).
    Event,
    /// [`Audit`].
    Audit,
}

impl Stream {
    /// All, in the order in which they are asked for: what is small and matters most comes first.
    pub const ALL: [Self; 3] = [Self::Audit, Self::Event, Self::State];

    /// Its number in questions.
    pub const fn code(self) -> u32 {
        match self {
            Self::State => 1,
            Self::Event => 2,
            Self::Audit => 3,
        }
    }

    /// The stream of this number.
    pub fn of_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|stream| stream.code() == code)
    }

    /// Its name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::State => "state",
            Self::Event => "event",
            Self::Audit => "audit",
        }
    }
}

/// One entry of a history: the bytes as they were told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Of which stream.
    pub stream: Stream,
    /// Of which boot.
    pub boot: u64,
    /// Its number there.
    pub number: u64,
    /// The clock on board, ms.
    pub clock_ms: u64,
    /// UTC as it was estimated where it was written, ns since 1970. Of no use for any order: a computer without a clock
    /// begins in 1970.
    pub unix_ns: u64,
    /// A [`State`](crate::payload::State), an [`Event`](crate::payload::Event) or an [`Audit`].
    pub data: Vec<u8>,
}

/// What was ordered and what became of it. Written on board.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Audit {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// As in [`State`](crate::payload::State).
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// Its number in this boot; without holes.
    #[prost(uint64, tag = "3")]
    pub number: u64,
    /// The clock on board, ms.
    #[prost(uint64, tag = "4")]
    pub clock_ms: u64,
    /// Public key of the sender; empty where it could not be read.
    #[prost(bytes = "vec", tag = "5")]
    pub key: Vec<u8>,
    /// The order; absent where its signature does not hold or its sender is not trusted.
    #[prost(message, optional, tag = "6")]
    pub order: Option<Order>,
    /// The answer that was given.
    #[prost(message, optional, tag = "7")]
    pub answer: Option<Answer>,
}

/// A frame of the autopilot or to it, as it was on the link.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MavlinkFrame {
    /// As in [`State`](crate::payload::State).
    #[prost(fixed64, tag = "1")]
    pub boot: u64,
    /// The clock on board, ms.
    #[prost(uint64, tag = "2")]
    pub clock_ms: u64,
    /// The frame.
    #[prost(bytes = "vec", tag = "3")]
    pub frame: Vec<u8>,
}

/// Numbers from one to another.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Span {
    /// The first.
    #[prost(uint64, tag = "1")]
    pub first: u64,
    /// The last.
    #[prost(uint64, tag = "2")]
    pub last: u64,
}

/// What is kept of one stream of one boot.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Kept {
    /// The boot.
    #[prost(fixed64, tag = "1")]
    pub boot: u64,
    /// [`Stream::code`].
    #[prost(uint32, tag = "2")]
    pub stream: u32,
    /// The numbers.
    #[prost(message, repeated, tag = "3")]
    pub spans: Vec<Span>,
}

/// A question for the index.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct IndexWanted {
    /// The answer has the same: one to an earlier question may be long on its way.
    #[prost(fixed64, tag = "1")]
    pub nonce: u64,
}

/// What is on the disk on board, newest boot first.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Index {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The boot that runs.
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// Whether this is all of it.
    #[prost(bool, tag = "3")]
    pub is_whole: bool,
    /// What is kept.
    #[prost(message, repeated, tag = "4")]
    pub kept: Vec<Kept>,
    /// As it was asked.
    #[prost(fixed64, tag = "5")]
    pub nonce: u64,
}

/// A question for records.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Wanted {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The boot.
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// [`Stream::code`].
    #[prost(uint32, tag = "3")]
    pub stream: u32,
    /// The first number.
    #[prost(uint64, tag = "4")]
    pub first: u64,
    /// The last.
    #[prost(uint64, tag = "5")]
    pub last: u64,
    /// Bytes of records that the answer may have; one comes whatever its size.
    #[prost(uint32, tag = "6")]
    pub max_bytes: u32,
}

/// One record in a piece.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Entry {
    /// Its number.
    #[prost(uint64, tag = "1")]
    pub number: u64,
    /// [`Record::clock_ms`].
    #[prost(uint64, tag = "2")]
    pub clock_ms: u64,
    /// [`Record::unix_ns`].
    #[prost(fixed64, tag = "3")]
    pub unix_ns: u64,
    /// [`Record::data`].
    #[prost(bytes = "vec", tag = "4")]
    pub data: Vec<u8>,
}

/// The answer: the records from `first` to `last`. What is missing among them is not to be had.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Piece {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// As it was asked.
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// As it was asked.
    #[prost(uint32, tag = "3")]
    pub stream: u32,
    /// As it was asked.
    #[prost(uint64, tag = "4")]
    pub first: u64,
    /// To where this answers the question: as it was asked, or less.
    #[prost(uint64, tag = "5")]
    pub last: u64,
    /// The records.
    #[prost(message, repeated, tag = "6")]
    pub entries: Vec<Entry>,
    /// SHA-256 of all of the above.
    #[prost(bytes = "vec", tag = "7")]
    pub digest: Vec<u8>,
}

/// A piece that is not used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BadPiece {
    /// It cannot be read.
    #[error(transparent)]
    Payload(#[from] BadPayload),
    /// Its digest is of something else.
    #[error("its digest is of something else")]
    Digest,
    /// It answers another question.
    #[error("it answers another question")]
    Other,
}

fn checked<T: prost::Message + Default>(bytes: &[u8], most: usize) -> Result<T, BadPayload> {
    if bytes.len() > most {
        return Err(BadPayload::TooLarge(bytes.len()));
    }
    T::decode(bytes).map_err(|error| BadPayload::Undecodable(error.to_string()))
}

fn of_our_version(version: u32) -> Result<(), BadPayload> {
    if version == VERSION { Ok(()) } else { Err(BadPayload::Version(version)) }
}

impl Index {
    /// Of what is kept, newest boot first as far as that is known.
    pub fn of(nonce: u64, boot: u64, kept: impl IntoIterator<Item = (u64, Stream, Ranges)>) -> Self {
        let mut index = Self { version: VERSION, boot, is_whole: true, kept: Vec::new(), nonce };
        let mut left = MAX_SPANS;
        for (boot, stream, ranges) in kept {
            if ranges.spans() > left {
                index.is_whole = false;
                break;
            }
            left -= ranges.spans();
            let spans = ranges.iter().map(|(first, last)| Span { first, last }).collect();
            index.kept.push(Kept { boot, stream: stream.code(), spans });
        }
        index
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        let index: Self = checked(bytes, MAX_BYTES)?;
        of_our_version(index.version)?;
        let is_good = |span: &Span| 0 < span.first && span.first <= span.last && span.last < u64::MAX;
        if !index.kept.iter().flat_map(|kept| &kept.spans).all(is_good) {
            return Err(BadPayload::Field("spans"));
        }
        Ok(index)
    }
}

impl Wanted {
    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        let wanted: Self = checked(bytes, MAX_BYTES)?;
        of_our_version(wanted.version)?;
        if wanted.first == 0 || wanted.last < wanted.first {
            return Err(BadPayload::Field("first or last"));
        }
        Ok(wanted)
    }
}

impl Piece {
    /// The answer to a question, signed with its digest.
    pub fn of(wanted: &Wanted, last: u64, entries: Vec<Entry>) -> Self {
        let Wanted { boot, stream, first, .. } = *wanted;
        let piece = Self { version: VERSION, boot, stream, first, last, entries, digest: Vec::new() };
        Self { digest: piece.digest(), ..piece }
    }

    fn digest(&self) -> Vec<u8> {
        let bare = Self { digest: Vec::new(), ..self.clone() };
        ring::digest::digest(&ring::digest::SHA256, &prost::Message::encode_to_vec(&bare)).as_ref().to_vec()
    }

    /// Reads one, whose digest holds.
    ///
    /// # Errors
    /// [`BadPiece`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPiece> {
        let piece: Self = checked(bytes, MAX_ANSWER_BYTES)?;
        of_our_version(piece.version)?;
        if piece.digest() != piece.digest {
            return Err(BadPiece::Digest);
        }
        Ok(piece)
    }
}
