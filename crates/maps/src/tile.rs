//! A tile to show, and where it came from.

use bytes::Bytes;

use crate::sniff::Picture;

/// Where a tile came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// From the cache, and new.
    Hit,
    /// From the service.
    Fetched,
    /// From the cache; the service says that it is the same.
    Revalidated,
    /// From the cache, old: the service failed.
    Stale,
    /// From a file of this machine.
    File,
}

impl Origin {
    /// In a word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hit => "hit",
            Self::Fetched => "fetched",
            Self::Revalidated => "revalidated",
            Self::Stale => "stale",
            Self::File => "file",
        }
    }
}

/// A tile to show.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// The picture.
    pub data: Bytes,
    /// What kind of picture.
    pub picture: Picture,
    /// Hash of the picture, for ETags.
    pub hash: u64,
    /// Where it came from.
    pub origin: Origin,
    /// How long a browser may show it without asking again, seconds.
    pub max_age_s: i64,
}
