//! The tiles of one source that were shown lately, in memory: a map that is panned to and fro, or that several people
//! look at, is not read from the disk each time. All sources share one shelf ([`crate::memory`]), which does not grow
//! with them.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use crate::grid::TileId;
use crate::memory::Shelved;
use crate::tile::Tile;

/// How exactly it is known when a tile was used last: noting it costs a write.
const NOTED_S: i64 = 60;

struct Entry {
    tile: Tile,
    /// It is new until then, seconds since 1970.
    until_s: i64,
    /// When its use was noted, seconds since 1970.
    noted_s: AtomicI64,
}

/// A tile from memory.
pub(crate) struct Found {
    pub(crate) tile: Tile,
    /// For how many seconds it is new.
    pub(crate) left_s: i64,
    /// Whether it is time to note that it is used.
    pub(crate) is_to_be_noted: bool,
}

/// Recently served tiles of a source.
pub(crate) struct Shown(Shelved);

impl Default for Shown {
    fn default() -> Self {
        Self(Shelved::tiles())
    }
}

const fn key(tile: TileId) -> (u64, u64) {
    ((tile.level as u64) << 32 | tile.column as u64, tile.row as u64)
}

impl Shown {
    /// A tile, while it is new.
    pub(crate) fn get(&self, tile: TileId, now_s: i64) -> Option<Found> {
        let (a, b) = key(tile);
        let entry = self.0.get::<Entry>(a, b)?;
        let left_s = entry.until_s.saturating_sub(now_s);
        // A clock that was set back does not extend freshness.
        let noted_s = entry.noted_s.load(Ordering::Relaxed);
        if left_s <= 0 || now_s < noted_s {
            return None;
        }
        let is_to_be_noted = now_s - noted_s >= NOTED_S;
        if is_to_be_noted {
            entry.noted_s.store(now_s, Ordering::Relaxed);
        }
        Some(Found { tile: entry.tile.clone(), left_s, is_to_be_noted })
    }

    /// Keeps a tile that is new until then, and whose use was noted just now.
    pub(crate) fn put(&self, id: TileId, tile: &Tile, until_s: i64, now_s: i64) {
        let (a, b) = key(id);
        let entry = Entry { tile: tile.clone(), until_s, noted_s: AtomicI64::new(now_s) };
        // One that finds no room is read again.
        let _ = self.0.put(a, b, &Arc::new(entry), tile.data.len() + size_of::<Entry>());
    }

    /// Drops a tile that was replaced.
    pub(crate) fn forget(&self, tile: TileId) {
        let (a, b) = key(tile);
        self.0.forget(a, b);
    }

    /// Forgets all.
    pub(crate) fn clear(&self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;
    use crate::sniff::Picture;
    use crate::tile::Origin;

    fn tile(data: &'static [u8]) -> Tile {
        Tile { data: Bytes::from_static(data), picture: Picture::Png, hash: 1, origin: Origin::Hit, max_age_s: 0 }
    }

    #[test]
    fn a_tile_is_shown_while_it_is_new_and_its_use_noted_once_a_minute() {
        let (shown, id) = (Shown::default(), TileId { level: 3, column: 1, row: 2 });
        assert!(shown.get(id, 0).is_none());
        shown.put(id, &tile(b"one"), 200, 100);
        let look = |now_s| shown.get(id, now_s).map(|found| (found.tile.data, found.left_s, found.is_to_be_noted));
        let one = Bytes::from_static(b"one");
        assert_eq!(look(159), Some((one.clone(), 41, false)));
        assert_eq!(look(160), Some((one.clone(), 40, true)));
        assert_eq!(look(160), Some((one, 40, false)));
        assert_eq!((look(200), look(99)), (None, None), "neither when it is old nor by a clock that was set back");
        assert!(Shown::default().get(id, 160).is_none(), "another source has its own");
        assert!(shown.get(TileId { level: 3, column: 2, row: 1 }, 160).is_none());
        shown.put(id, &tile(b"two"), 300, 160);
        assert_eq!(look(170).map(|(data, ..)| data), Some(Bytes::from_static(b"two")));
        shown.forget(id);
        assert!(look(170).is_none());
        shown.put(id, &tile(b"two"), 300, 160);
        shown.clear();
        assert!(look(170).is_none());
    }
}
