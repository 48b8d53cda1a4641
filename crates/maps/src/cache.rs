//! The cache of one source: an SQLite file that other programs can read as MBTiles (its view `tiles`), with what is
//! needed to ask again, to forget the least recently used, and to keep the tiles of offline areas.
//!
//! Calls block; the service makes them off the runtime's threads.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use rusqlite::{Connection, ErrorCode, OpenFlags, OptionalExtension, TransactionBehavior, params};

use crate::error::{MapError, Result};
use crate::grid::TileId;
use crate::sniff;

/// Connections that read at once at most.
const READERS: usize = 4;
/// Uses that are noted in memory before they are written.
const TOUCHES: usize = 512;
/// Every how many tiles the size is looked at.
const LOOK_EVERY: u64 = 32;
/// Bytes that the write-ahead log keeps on disk when it is empty.
const WAL_BYTES: i64 = 16 * 1024 * 1024;
/// Version of the tables.
const SCHEMA: i64 = 1;

const TABLES: &str = "
    CREATE TABLE IF NOT EXISTS metadata (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS images (
        id INTEGER PRIMARY KEY, level INTEGER NOT NULL, col INTEGER NOT NULL, row INTEGER NOT NULL,
        etag TEXT, last_modified TEXT, hash INTEGER NOT NULL,
        fetched_s INTEGER NOT NULL, expires_s INTEGER NOT NULL, used_s INTEGER NOT NULL,
        data BLOB, -- NULL: the service has none there
        UNIQUE (level, col, row));
    CREATE INDEX IF NOT EXISTS images_by_use ON images (used_s);
    CREATE INDEX IF NOT EXISTS images_by_end ON images (expires_s);
    CREATE VIEW IF NOT EXISTS tiles AS
        SELECT level AS zoom_level, col AS tile_column, (1 << level) - 1 - row AS tile_row, data AS tile_data
        FROM images WHERE data IS NOT NULL;
    CREATE TABLE IF NOT EXISTS areas (
        id TEXT PRIMARY KEY, name TEXT NOT NULL, shape TEXT NOT NULL, min_level INTEGER NOT NULL, max_level INTEGER NOT NULL,
        state TEXT NOT NULL, detail TEXT, created_s INTEGER NOT NULL, bytes INTEGER NOT NULL DEFAULT 0) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS area_tiles (
        level INTEGER NOT NULL, col INTEGER NOT NULL, row INTEGER NOT NULL, area TEXT NOT NULL, state INTEGER NOT NULL,
        PRIMARY KEY (level, col, row, area)) WITHOUT ROWID;
    CREATE INDEX IF NOT EXISTS area_tiles_by_state ON area_tiles (area, state);
";

/// Counts maintained by triggers of the database, whichever process writes: counting half a million rows
/// on each request would keep a core busy. Names: `images`, `pinned` (different tiles that areas keep), and
/// `area/ID/STATE` (tiles of an area).
const COUNTS: &str = "
    CREATE TABLE counts (name TEXT PRIMARY KEY, number INTEGER NOT NULL) WITHOUT ROWID;
    CREATE TRIGGER image_in AFTER INSERT ON images BEGIN
        UPDATE counts SET number=number+1 WHERE name='images';
    END;
    CREATE TRIGGER image_out AFTER DELETE ON images BEGIN
        UPDATE counts SET number=number-1 WHERE name='images';
    END;
    CREATE TRIGGER area_tile_in AFTER INSERT ON area_tiles BEGIN
        INSERT INTO counts VALUES ('area/' || new.area || '/' || new.state, 1) ON CONFLICT DO UPDATE SET number=number+1;
    END;
    CREATE TRIGGER area_tile_out AFTER DELETE ON area_tiles BEGIN
        UPDATE counts SET number=number-1 WHERE name='area/' || old.area || '/' || old.state;
    END;
    CREATE TRIGGER area_tile_marked AFTER UPDATE OF state ON area_tiles WHEN new.state<>old.state BEGIN
        UPDATE counts SET number=number-1 WHERE name='area/' || old.area || '/' || old.state;
        INSERT INTO counts VALUES ('area/' || new.area || '/' || new.state, 1) ON CONFLICT DO UPDATE SET number=number+1;
    END;
    CREATE TRIGGER pinned_in AFTER INSERT ON area_tiles WHEN new.state=1 BEGIN
        UPDATE counts SET number=number+1 WHERE name='pinned' AND NOT EXISTS (SELECT 1 FROM area_tiles AS other WHERE
            other.level=new.level AND other.col=new.col AND other.row=new.row AND other.area<>new.area AND other.state=1);
    END;
    CREATE TRIGGER pinned_out AFTER DELETE ON area_tiles WHEN old.state=1 BEGIN
        UPDATE counts SET number=number-1 WHERE name='pinned' AND NOT EXISTS (SELECT 1 FROM area_tiles AS other WHERE
            other.level=old.level AND other.col=old.col AND other.row=old.row AND other.area<>old.area AND other.state=1);
    END;
    CREATE TRIGGER pinned_marked AFTER UPDATE OF state ON area_tiles WHEN (new.state=1)<>(old.state=1) BEGIN
        UPDATE counts SET number=number+iif(new.state=1, 1, -1) WHERE name='pinned' AND NOT EXISTS (SELECT 1 FROM area_tiles
            AS other WHERE other.level=new.level AND other.col=new.col AND other.row=new.row AND other.area<>new.area
            AND other.state=1);
    END;
    CREATE TRIGGER area_out AFTER DELETE ON areas BEGIN
        DELETE FROM counts WHERE number=0 AND name IN ('area/' || old.id || '/0', 'area/' || old.id || '/1', 'area/' || old.id || '/2');
    END;
";

/// Counts what is there already, in a cache that an older Vencejo made.
const COUNT_ALL: &str = "
    INSERT INTO counts SELECT 'images', COUNT(*) FROM images
        UNION ALL SELECT 'pinned', COUNT(*) FROM (SELECT DISTINCT level, col, row FROM area_tiles WHERE state=1)
        UNION ALL SELECT 'area/' || area || '/' || state, COUNT(*) FROM area_tiles GROUP BY area, state;
";

/// A tile as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedTile {
    /// The picture; `None` when the service has no tile there.
    pub data: Option<Bytes>,
    /// Of the service, to ask again with.
    pub etag: Option<String>,
    /// Of the service, to ask again with.
    pub last_modified: Option<String>,
    /// Of the picture, for browsers.
    pub hash: u64,
    /// When it was fetched or found to be the same, seconds since 1970.
    pub fetched_s: i64,
    /// Until when it is new, seconds since 1970.
    pub expires_s: i64,
}

impl CachedTile {
    /// A new picture, or the fact that there is no tile.
    pub fn new(data: Option<Bytes>, now_s: i64, lifetime: Duration) -> Self {
        let hash = data.as_ref().map_or(0, |data| sniff::hash(data));
        let lifetime = i64::try_from(lifetime.as_secs()).unwrap_or(i64::MAX / 4).min(i64::MAX / 4);
        Self { data, etag: None, last_modified: None, hash, fetched_s: now_s, expires_s: now_s + lifetime }
    }
}

/// How full a cache is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fill {
    /// Tiles, absent ones included.
    pub tiles: u64,
    /// Bytes of the file, without its free pages.
    pub bytes: u64,
    /// Tiles that offline areas keep.
    pub pinned_tiles: u64,
}

/// The cache of one source.
#[derive(Debug)]
pub struct Cache {
    path: PathBuf,
    /// Whether it is on a read-only disk: then it never changes.
    is_frozen: bool,
    /// New name of a damaged cache that was replaced when this was opened.
    set_aside_as: Option<PathBuf>,
    writer: Mutex<Connection>,
    readers: Mutex<Vec<Connection>>,
    /// Which tiles were used, and when; not yet in the file.
    touched: Mutex<HashMap<TileId, i64>>,
    max_bytes: AtomicU64,
    written: AtomicU64,
}

impl Cache {
    /// Opens the cache of a path, or makes it.
    ///
    /// # Errors
    /// [`MapError::Storage`] when the file is not a cache or cannot be used.
    pub fn open(path: &Path, max_bytes: u64) -> Result<Self> {
        if let Some(folder) = path.parent() {
            // A read-only one is detected below.
            let _ = vencejo_store::make_folder(folder);
        }
        let mut set_aside_as = None;
        let writer = match prepare(path) {
            Err(Unready::Broken(reason)) => {
                let aside = set_aside(path)?;
                set_aside_as = Some(aside.clone());
                tracing::error!(
                    path = %path.display(), reason, aside = %aside.display(),
                    "the cache of a map source was broken: it was put aside, and a new one begun"
                );
                prepare(path)
            }
            other => other,
        };
        // In a folder that cannot be written what was kept before is still shown.
        let (writer, is_frozen) = match writer {
            Err(Unready::Unwritable(error)) => (open_frozen(path).map_err(|_| Unready::Other(error)), true),
            other => (other, false),
        };
        if is_frozen && writer.is_ok() {
            tracing::warn!(path = %path.display(), "the cache of a map source cannot be written: what it has is shown, nothing more is kept");
        }
        let writer = writer.map_err(|unready| match unready {
            Unready::Broken(reason) => MapError::storage(format!("{}: {reason}", path.display())),
            Unready::Unwritable(error) | Unready::Other(error) => error,
        })?;
        Ok(Self {
            path: path.to_owned(),
            is_frozen,
            set_aside_as,
            writer: Mutex::new(writer),
            readers: Mutex::default(),
            touched: Mutex::default(),
            max_bytes: AtomicU64::new(max_bytes),
            written: AtomicU64::new(0),
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether nothing more is kept, because the disk is read-only.
    pub const fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// New name of a damaged cache in its place, renamed when this was opened.
    pub fn set_aside_as(&self) -> Option<&Path> {
        self.set_aside_as.as_deref()
    }

    /// Bytes at most, but for what offline areas keep.
    pub fn set_max_bytes(&self, max_bytes: u64) {
        self.max_bytes.store(max_bytes, Ordering::Relaxed);
    }

    /// Bytes at most.
    pub fn max_bytes(&self) -> u64 {
        self.max_bytes.load(Ordering::Relaxed)
    }

    /// The connection that writes.
    pub(crate) fn writer(&self) -> MutexGuard<'_, Connection> {
        self.writer.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn read<T>(&self, read: impl FnOnce(&Connection) -> rusqlite::Result<T>) -> Result<T> {
        let free = self.readers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let reader = match free {
            Some(reader) => reader,
            None if self.is_frozen => open_frozen(&self.path)?,
            None => {
                let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
                let reader = Connection::open_with_flags(&self.path, flags)?;
                reader.busy_timeout(Duration::from_secs(10))?;
                reader
            }
        };
        let result = read(&reader);
        let mut readers = self.readers.lock().unwrap_or_else(PoisonError::into_inner);
        if readers.len() < READERS {
            readers.push(reader);
        }
        Ok(result?)
    }

    /// A tile, when it is there; it counts as used.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn get(&self, tile: TileId, now_s: i64) -> Result<Option<CachedTile>> {
        let found = self.read(|reader| {
            let mut query = reader.prepare_cached(
                "SELECT data, etag, last_modified, hash, fetched_s, expires_s FROM images WHERE level=? AND col=? AND row=?",
            )?;
            query
                .query_row(params![tile.level, tile.column, tile.row], |row| {
                    let data = row.get_ref(0)?.as_blob_or_null()?.map(Bytes::copy_from_slice);
                    Ok(CachedTile {
                        data,
                        etag: row.get(1)?,
                        last_modified: row.get(2)?,
                        hash: row.get::<_, i64>(3)?.cast_unsigned(),
                        fetched_s: row.get(4)?,
                        expires_s: row.get(5)?,
                    })
                })
                .optional()
        })?;
        if found.is_some() && self.note_use(tile, now_s) >= TOUCHES {
            self.flush()?;
        }
        Ok(found)
    }

    /// Notes in memory that a tile is used; returns how many uses are not yet in the file.
    pub fn note_use(&self, tile: TileId, now_s: i64) -> usize {
        if self.is_frozen {
            return 0;
        }
        let mut touched = self.touched.lock().unwrap_or_else(PoisonError::into_inner);
        touched.insert(tile, now_s);
        touched.len()
    }

    /// Writes down which tiles were used when, so that those are not forgotten first.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn flush(&self) -> Result<()> {
        let uses = std::mem::take(&mut *self.touched.lock().unwrap_or_else(PoisonError::into_inner));
        if uses.is_empty() { Ok(()) } else { self.note_uses(&uses) }
    }

    /// Whether a tile, or its absence, is cached, without counting as a use.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn has(&self, tile: TileId) -> Result<bool> {
        self.read(|reader| {
            let mut query = reader.prepare_cached("SELECT 1 FROM images WHERE level=? AND col=? AND row=?")?;
            query.exists(params![tile.level, tile.column, tile.row])
        })
    }

    fn note_uses(&self, uses: &HashMap<TileId, i64>) -> Result<()> {
        let mut writer = self.writer();
        let transaction = writer.transaction()?;
        {
            let mut note =
                transaction.prepare_cached("UPDATE images SET used_s=? WHERE level=? AND col=? AND row=?")?;
            for (tile, used_s) in uses {
                note.execute(params![used_s, tile.level, tile.column, tile.row])?;
            }
        }
        transaction.commit()?;
        Ok(())
    }

    /// Keeps a tile.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn put(&self, tile: TileId, kept: &CachedTile) -> Result<()> {
        {
            let writer = self.writer();
            put(&writer, tile, kept)?;
        }
        if self.written.fetch_add(1, Ordering::Relaxed).is_multiple_of(LOOK_EVERY) {
            self.shrink()?;
        }
        Ok(())
    }

    /// Notes that a tile is still the same.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn renew(&self, tile: TileId, now_s: i64, expires_s: i64) -> Result<()> {
        let writer = self.writer();
        writer
            .prepare_cached("UPDATE images SET fetched_s=?, expires_s=?, used_s=? WHERE level=? AND col=? AND row=?")?
            .execute(params![now_s, expires_s, now_s, tile.level, tile.column, tile.row])?;
        Ok(())
    }

    /// Forgets the least recently used until the rest fits; offline areas keep theirs.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn shrink(&self) -> Result<()> {
        let max_bytes = self.max_bytes();
        let mut bytes = self.bytes()?;
        if bytes <= max_bytes {
            return Ok(());
        }
        self.flush()?;
        // Down to nine tenths, so that it is not done for each tile.
        let aim = max_bytes / 10 * 9;
        while bytes > aim {
            let writer = self.writer();
            let mean = bytes / counted(&writer, "images")?.max(1) + 1;
            let gone = writer.execute(
                "DELETE FROM images WHERE id IN (SELECT id FROM images AS old WHERE NOT EXISTS (SELECT 1 FROM area_tiles AS kept \
                 WHERE kept.level=old.level AND kept.col=old.col AND kept.row=old.row) ORDER BY used_s LIMIT ?)",
                [((bytes - aim) / mean + 1).cast_signed()],
            )?;
            drop(writer);
            if gone == 0 {
                break;
            }
            bytes = self.bytes()?;
        }
        Ok(())
    }

    /// Removes expired tiles.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn drop_expired(&self, now_s: i64) -> Result<()> {
        self.writer().prepare_cached("DELETE FROM images WHERE expires_s <= ?")?.execute([now_s])?;
        Ok(())
    }

    /// Forgets all but what offline areas keep.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn clear(&self) -> Result<()> {
        let writer = self.writer();
        writer.execute(
            "DELETE FROM images WHERE NOT EXISTS (SELECT 1 FROM area_tiles AS kept \
             WHERE kept.level=images.level AND kept.col=images.col AND kept.row=images.row)",
            [],
        )?;
        writer.execute_batch("VACUUM; PRAGMA wal_checkpoint(TRUNCATE);")?;
        Ok(())
    }

    fn bytes(&self) -> Result<u64> {
        self.read(|reader| {
            let number = |name: &str| reader.pragma_query_value(None, name, |row| row.get::<_, i64>(0));
            let pages = number("page_count")? - number("freelist_count")?;
            Ok((pages * number("page_size")?).max(0).cast_unsigned())
        })
    }

    /// How full it is.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn fill(&self) -> Result<Fill> {
        let bytes = self.bytes()?;
        self.read(|reader| {
            Ok(Fill { tiles: counted(reader, "images")?, bytes, pinned_tiles: counted(reader, "pinned")? })
        })
    }

    /// Bytes of a tile by those that are here; `None` with fewer than ten.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn mean_bytes(&self, min_level: u8, max_level: u8) -> Result<Option<u64>> {
        self.read(|reader| {
            let (count, bytes): (i64, Option<f64>) = reader.query_row(
                "SELECT COUNT(*), AVG(LENGTH(data)) FROM (SELECT data FROM images WHERE data IS NOT NULL \
                 AND level BETWEEN ? AND ? LIMIT 2000)",
                params![min_level, max_level],
                |row| Ok((row.get(0)?, row.get(1)?)),
            )?;
            Ok(bytes.filter(|_| count >= 10).map(|bytes| bytes as u64))
        })
    }

    /// A note of the source's, such as what its service said of itself.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn note(&self, name: &str) -> Result<Option<String>> {
        self.read(|reader| {
            reader.query_row("SELECT value FROM metadata WHERE name=?", [name], |row| row.get(0)).optional()
        })
    }

    /// Writes a note.
    ///
    /// # Errors
    /// [`MapError::Storage`].
    pub fn set_note(&self, name: &str, value: &str) -> Result<()> {
        self.writer().execute("INSERT OR REPLACE INTO metadata VALUES (?, ?)", params![name, value])?;
        Ok(())
    }
}

/// A number that the database keeps ([`COUNTS`]); 0 of what never was.
pub(crate) fn counted(connection: &Connection, name: &str) -> rusqlite::Result<u64> {
    let mut query = connection.prepare_cached("SELECT number FROM counts WHERE name=?")?;
    let number: Option<i64> = query.query_row([name], |row| row.get(0)).optional()?;
    Ok(number.unwrap_or_default().max(0).cast_unsigned())
}

fn has_counts(connection: &Connection) -> rusqlite::Result<bool> {
    connection.prepare("SELECT 1 FROM sqlite_master WHERE type='table' AND name='counts'")?.exists([])
}

/// Why a file cannot be used as a cache.
enum Unready {
    /// It is not a database, or a damaged one: after a power failure, or on a worn card.
    Broken(String),
    /// Its disk, or it, cannot be written.
    Unwritable(MapError),
    Other(MapError),
}

impl From<rusqlite::Error> for Unready {
    fn from(error: rusqlite::Error) -> Self {
        match error.sqlite_error_code() {
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => Self::Broken(error.to_string()),
            Some(ErrorCode::ReadOnly | ErrorCode::CannotOpen) => Self::Unwritable(error.into()),
            _ => Self::Other(error.into()),
        }
    }
}

/// Opens the connection that writes, with its tables.
fn prepare(path: &Path) -> std::result::Result<Connection, Unready> {
    let mut writer = Connection::open(path)?;
    writer.busy_timeout(Duration::from_secs(10))?;
    // Readers do not wait for the writer; a power cut may lose the last tiles, never the file.
    writer.pragma_update(None, "journal_mode", "WAL")?;
    writer.pragma_update(None, "synchronous", "NORMAL")?;
    writer.pragma_update(None, "journal_size_limit", WAL_BYTES)?;
    // "MPBX", the application id of MBTiles files.
    writer.pragma_update(None, "application_id", 0x4d50_4258)?;
    let version: i64 = writer.pragma_query_value(None, "user_version", |row| row.get(0))?;
    if version > SCHEMA {
        let reason = format!("{} was made by a newer Vencejo", path.display());
        return Err(Unready::Other(MapError::storage(reason)));
    }
    writer.execute_batch(TABLES)?;
    // Another process may be about to do the same.
    let transaction = writer.transaction_with_behavior(TransactionBehavior::Immediate)?;
    if !has_counts(&transaction)? {
        transaction.execute_batch(COUNTS)?;
        transaction.execute_batch(COUNT_ALL)?;
    }
    transaction.commit()?;
    writer.pragma_update(None, "user_version", SCHEMA)?;
    Ok(writer)
}

/// Opens a cache on a read-only disk. SQLite is told that no other process writes either, or it would create files
/// beside it.
fn open_frozen(path: &Path) -> rusqlite::Result<Connection> {
    let wrong = || rusqlite::Error::InvalidPath(path.to_owned());
    let mut address =
        url::Url::from_file_path(std::path::absolute(path).map_err(|_| wrong())?).map_err(|()| wrong())?;
    address.set_query(Some("immutable=1"));
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let reader = Connection::open_with_flags(address.as_str(), flags)?;
    reader.query_row("SELECT COUNT(*) FROM areas", [], |_| Ok(()))?;
    if !has_counts(&reader)? {
        // Of an older Vencejo and unchangeable: the counts are kept in memory.
        reader.execute_batch("CREATE TEMP TABLE counts (name TEXT PRIMARY KEY, number INTEGER NOT NULL);")?;
        reader.execute_batch(COUNT_ALL)?;
    }
    Ok(reader)
}

/// Renames a broken file, without its journals: its content may be worth saving.
fn set_aside(path: &Path) -> Result<PathBuf> {
    let aside = vencejo_store::set_aside(path)?;
    for end in ["-wal", "-shm"] {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        let _ = std::fs::remove_file(name);
    }
    Ok(aside)
}

/// Writes a tile with a connection, in whose transaction it may be.
pub(crate) fn put(connection: &Connection, tile: TileId, kept: &CachedTile) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO images (level, col, row, etag, last_modified, hash, fetched_s, expires_s, used_s, data) \
             VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (level, col, row) DO UPDATE SET etag=excluded.etag, \
             last_modified=excluded.last_modified, hash=excluded.hash, fetched_s=excluded.fetched_s, \
             expires_s=excluded.expires_s, used_s=excluded.used_s, data=excluded.data",
        )?
        .execute(params![
            tile.level,
            tile.column,
            tile.row,
            kept.etag,
            kept.last_modified,
            kept.hash.cast_signed(),
            kept.fetched_s,
            kept.expires_s,
            kept.fetched_s,
            kept.data.as_deref()
        ])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Folder;

    fn tile(column: u32) -> TileId {
        TileId { level: 10, column, row: 3 }
    }

    fn kept(bytes: usize, now_s: i64) -> CachedTile {
        CachedTile::new(Some(Bytes::from(vec![7; bytes])), now_s, Duration::from_secs(60))
    }

    #[test]
    fn tiles_are_kept_over_a_restart_and_read_as_mbtiles() {
        let folder = Folder::new();
        let path = folder.path().join("cache/a.mbtiles");
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        assert_eq!(cache.get(tile(1), 0).expect("read"), None);
        let mut picture = kept(5, 100);
        (picture.etag, picture.last_modified) = (Some("\"e\"".into()), Some("date".into()));
        cache.put(tile(1), &picture).expect("kept");
        cache.put(tile(2), &CachedTile::new(None, 100, Duration::from_secs(60))).expect("kept");
        cache.set_note("grid", "g").expect("noted");
        drop(cache);
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        assert_eq!(cache.get(tile(1), 0).expect("read"), Some(picture.clone()));
        assert_eq!(cache.get(tile(2), 0).expect("read").expect("known").data, None);
        assert!(cache.has(tile(2)).expect("read") && !cache.has(tile(3)).expect("read"));
        assert_eq!(cache.note("grid").expect("read").as_deref(), Some("g"));
        cache.renew(tile(1), 200, 300).expect("renewed");
        let renewed = cache.get(tile(1), 0).expect("read").expect("there");
        assert_eq!((renewed.fetched_s, renewed.expires_s, renewed.hash), (200, 300, picture.hash));
        let rows = cache.read(|reader| {
            reader.query_row("SELECT zoom_level, tile_column, tile_row, LENGTH(tile_data) FROM tiles", [], |row| {
                Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, row.get::<_, i64>(2)?, row.get::<_, i64>(3)?))
            })
        });
        assert_eq!(rows.expect("one row"), (10, 1, 1020, 5));
    }

    #[test]
    fn the_least_recently_used_go_first_and_areas_stay() {
        let folder = Folder::new();
        let cache = Cache::open(&folder.path().join("a.mbtiles"), 400_000).expect("a cache");
        cache.writer().execute("INSERT INTO area_tiles VALUES (10, 0, 3, 'a', 1)", []).expect("pinned");
        for column in 0..100 {
            cache.put(tile(column), &kept(10_000, i64::from(column))).expect("kept");
            // The second is used all the time.
            cache.get(tile(1), i64::from(column)).expect("read");
        }
        cache.shrink().expect("shrunk");
        let fill = cache.fill().expect("read");
        assert!(fill.bytes <= 400_000 && fill.tiles > 10, "{fill:?}");
        assert_eq!(fill.pinned_tiles, 1);
        for (column, stays) in [(0, true), (1, true), (2, false), (3, false), (99, true)] {
            assert_eq!(cache.has(tile(column)).expect("read"), stays, "{column}");
        }
        assert_eq!(cache.mean_bytes(0, 20).expect("read"), Some(10_000));
        cache.clear().expect("cleared");
        assert_eq!(cache.fill().expect("read").tiles, 1);
    }

    #[test]
    fn what_was_kept_is_shown_where_nothing_can_be_written() {
        let folder = Folder::new();
        let path = folder.path().join("a b?.mbtiles");
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        cache.put(tile(1), &kept(5, 100)).expect("kept");
        cache.writer().query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(())).expect("all in one file");
        drop(cache);
        // SQLite's journal cannot be created, for any user.
        for end in ["-shm", "-wal"] {
            let _ = std::fs::remove_file(folder.path().join(format!("a b?.mbtiles{end}")));
        }
        std::fs::create_dir_all(folder.path().join("a b?.mbtiles-shm/x")).expect("made");
        std::fs::create_dir_all(folder.path().join("a b?.mbtiles-wal/x")).expect("made");
        let cache = Cache::open(&path, 1 << 30).expect("readable");
        assert!(cache.is_frozen());
        assert_eq!(cache.get(tile(1), 0).expect("read"), Some(kept(5, 100)));
        assert_eq!(cache.fill().expect("read").tiles, 1);
        assert!(matches!(cache.put(tile(2), &kept(5, 100)), Err(MapError::Storage(_))));
        cache.flush().expect("nothing is noted");
    }

    /// The counts that a cache reports, and the real ones.
    fn assert_counts_are_right(cache: &Cache) {
        cache
            .read(|reader| {
                let count = |sql: &str| reader.query_row(sql, [], |row| row.get::<_, i64>(0)).map(i64::cast_unsigned);
                assert_eq!(counted(reader, "images")?, count("SELECT COUNT(*) FROM images")?);
                let pinned = "SELECT COUNT(*) FROM (SELECT DISTINCT level, col, row FROM area_tiles WHERE state=1)";
                assert_eq!(counted(reader, "pinned")?, count(pinned)?);
                for (area, state) in ["a", "b"].into_iter().flat_map(|area| [0, 1, 2].map(|state| (area, state))) {
                    let tiles =
                        count(&format!("SELECT COUNT(*) FROM area_tiles WHERE area='{area}' AND state={state}"))?;
                    assert_eq!(counted(reader, &format!("area/{area}/{state}"))?, tiles, "{area} {state}");
                }
                Ok(())
            })
            .expect("read");
    }

    #[test]
    fn counts_are_kept_and_not_made_when_asked_for() {
        let folder = Folder::new();
        let path = folder.path().join("a.mbtiles");
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        let run = |sql: &str| {
            cache.writer().execute_batch(sql).expect(sql);
            assert_counts_are_right(&cache);
        };
        for column in 0..5 {
            cache.put(tile(column), &kept(5, 0)).expect("kept");
        }
        // The same tile again does not count.
        cache.put(tile(1), &kept(7, 1)).expect("kept");
        assert_eq!(cache.fill().expect("read").tiles, 5);
        run(
            "INSERT INTO areas (id, name, shape, min_level, max_level, state, created_s) VALUES ('a', '', '', 0, 1, 'running', 0)",
        );
        for column in 0..6 {
            run(&format!("INSERT INTO area_tiles VALUES (10, {column}, 3, 'a', 0)"));
        }
        // Two areas that share tiles keep each of them once.
        run("INSERT OR IGNORE INTO area_tiles VALUES (10, 1, 3, 'b', 1), (10, 2, 3, 'b', 1), (10, 1, 3, 'b', 1)");
        run("UPDATE area_tiles SET state=1 WHERE area='a' AND col<3");
        run("UPDATE area_tiles SET state=2 WHERE area='a' AND col=3");
        run("UPDATE area_tiles SET state=2 WHERE area='a' AND col=1");
        run("UPDATE area_tiles SET state=0 WHERE area='a' AND state=2");
        assert_eq!(cache.fill().expect("read").pinned_tiles, 3);
        run("DELETE FROM images WHERE col=4");
        run("DELETE FROM area_tiles WHERE area='a'");
        run("DELETE FROM areas WHERE id='a'");
        let left = cache.read(|reader| {
            reader.query_row("SELECT COUNT(*) FROM counts WHERE name LIKE 'area/a/%'", [], |row| row.get(0))
        });
        assert_eq!(left, Ok(0));
        // Counting reads no row.
        cache
            .writer()
            .execute("UPDATE counts SET number=7000 WHERE name IN ('images', 'pinned')", [])
            .expect("changed");
        let fill = cache.fill().expect("read");
        assert_eq!((fill.tiles, fill.pinned_tiles), (7000, 7000));
    }

    #[test]
    fn an_older_cache_is_counted_once() {
        let folder = Folder::new();
        let path = folder.path().join("a.mbtiles");
        let older = |path: &Path| {
            let cache = Cache::open(path, 1 << 30).expect("a cache");
            cache.put(tile(1), &kept(5, 0)).expect("kept");
            cache
                .writer()
                .execute_batch(
                    "INSERT INTO area_tiles VALUES (10, 1, 3, 'a', 1), (10, 2, 3, 'a', 0), (10, 1, 3, 'b', 1);
                     DROP TRIGGER image_in; DROP TRIGGER image_out; DROP TRIGGER area_tile_in; DROP TRIGGER area_tile_out;
                     DROP TRIGGER area_tile_marked; DROP TRIGGER pinned_in; DROP TRIGGER pinned_out; DROP TRIGGER pinned_marked;
                     DROP TRIGGER area_out; DROP TABLE counts; PRAGMA wal_checkpoint(TRUNCATE);",
                )
                .expect("as it was");
        };
        older(&path);
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        assert_counts_are_right(&cache);
        cache.put(tile(2), &kept(5, 0)).expect("kept");
        let fill = cache.fill().expect("read");
        assert_eq!((fill.tiles, fill.pinned_tiles), (2, 1));
        // Also when it has become read-only.
        let path = folder.path().join("b.mbtiles");
        older(&path);
        let reader = open_frozen(&path).expect("readable");
        assert_eq!((counted(&reader, "images"), counted(&reader, "area/a/0")), (Ok(1), Ok(1)));
    }

    #[test]
    fn a_broken_cache_is_put_aside_and_a_new_one_begun() {
        let folder = Folder::new();
        let path = folder.path().join("a.mbtiles");
        let text = "no database at all, but long enough to be read as one, which it is not";
        std::fs::write(&path, text).expect("written");
        let cache = Cache::open(&path, 1 << 30).expect("a new one");
        cache.put(tile(1), &kept(5, 0)).expect("kept");
        let aside = cache.set_aside_as().expect("told");
        assert_eq!(aside, folder.path().join("a.mbtiles.broken"));
        assert_eq!(std::fs::read_to_string(aside).expect("read"), text);
        // A folder in its place cannot be renamed aside.
        std::fs::create_dir_all(folder.path().join("b.mbtiles/x")).expect("made");
        assert!(matches!(Cache::open(&folder.path().join("b.mbtiles"), 1), Err(MapError::Storage(_))));
    }

    #[test]
    fn what_was_used_is_remembered_over_a_restart() {
        let folder = Folder::new();
        let path = folder.path().join("a.mbtiles");
        let cache = Cache::open(&path, 1 << 30).expect("a cache");
        for column in 0..100 {
            cache.put(tile(column), &kept(10_000, 0)).expect("kept");
        }
        cache.get(tile(7), 50).expect("read");
        cache.flush().expect("noted");
        drop(cache);
        let cache = Cache::open(&path, 300_000).expect("a cache");
        cache.shrink().expect("shrunk");
        assert!(cache.has(tile(7)).expect("read") && cache.fill().expect("read").tiles < 40);
    }

    /// Where a process of its own keeps tiles until it is killed.
    const KILLED_FOLDER: &str = "VENCEJO_TEST_CACHE_UNTIL_KILLED";

    /// Run by the test below in a process of its own: one tile after the other, each told once it is kept.
    #[test]
    fn keeps_tiles_until_it_is_killed() {
        let Some(folder) = std::env::var_os(KILLED_FOLDER) else { return };
        let cache = Cache::open(&Path::new(&folder).join("a.mbtiles"), 2_000_000).expect("a cache");
        for column in 0.. {
            cache.put(tile(column % 1024), &kept(9_000 + column as usize % 7, i64::from(column))).expect("kept");
            if column % 50 == 49 {
                cache.shrink().expect("shrunk");
            }
            println!("tile {column}");
        }
    }

    // fault 56 (4 kills): the tile cache, killed while it is written and shrunk: SQLite's integrity_check is ok, every
    // tile that was reported is whole
    #[test]
    fn a_kill_at_any_moment_leaves_the_database_whole() {
        use std::io::BufRead;
        let kills: u64 = std::env::var("VENCEJO_TEST_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(4);
        for kill in 0..kills {
            let folder = Folder::new();
            let mut child = std::process::Command::new(std::env::current_exe().expect("this program"))
                .args(["--exact", "cache::tests::keeps_tiles_until_it_is_killed", "--nocapture"])
                .env(KILLED_FOLDER, folder.path())
                .stdout(std::process::Stdio::piped())
                .spawn()
                .expect("started");
            let mut lines = std::io::BufReader::new(child.stdout.take().expect("piped")).lines();
            let wanted = 1 + (kill * 211 + 97) % 400;
            let mut told = 0;
            while told < wanted {
                told += u64::from(lines.next().expect("it goes on").expect("text").starts_with("tile"));
            }
            child.kill().expect("killed");
            child.wait().expect("ended");
            // On a busy machine it may have been far ahead of the reader of its output.
            told += lines.map_while(|line| line.ok()).filter(|line| line.starts_with("tile")).count() as u64;
            let path = folder.path().join("a.mbtiles");
            let database = Connection::open(&path).expect("opened");
            let check: String = database.query_row("PRAGMA integrity_check", [], |row| row.get(0)).expect("checked");
            assert_eq!(check, "ok", "kill {kill}");
            drop(database);
            let cache = Cache::open(&path, 2_000_000).expect("a cache");
            assert!(!path.with_extension("mbtiles.broken").exists(), "it was not put aside");
            // The newest are not what makes room.
            let newest = u32::try_from(told - 1).expect("few");
            let found = cache.get(tile(newest % 1024), 0).expect("read").expect("the last that was told");
            assert_eq!(found.data.expect("a picture").len(), 9_000 + newest as usize % 7);
        }
    }

    #[test]
    fn readers_and_writers_at_once_lose_nothing_and_keep_to_the_limit() {
        let folder = Folder::new();
        let cache = Cache::open(&folder.path().join("a.mbtiles"), 1_000_000).expect("a cache");
        // Time goes on for all threads alike.
        let clock = std::sync::atomic::AtomicI64::new(0);
        std::thread::scope(|scope| {
            for thread in 0..4_u32 {
                let (cache, clock) = (&cache, &clock);
                scope.spawn(move || {
                    for turn in 0..100 {
                        let (tile, now_s) = (tile(thread * 1000 + turn), clock.fetch_add(1, Ordering::SeqCst));
                        cache.put(tile, &kept(10_000, now_s)).expect("kept");
                        if let Some(found) = cache.get(tile, now_s).expect("read") {
                            assert_eq!(found.data, kept(10_000, 0).data);
                        }
                        // One that all use must not be forgotten.
                        cache.put(TileId { level: 1, column: 0, row: 0 }, &kept(100, now_s)).expect("kept");
                    }
                });
            }
        });
        cache.shrink().expect("shrunk");
        let fill = cache.fill().expect("read");
        assert!(fill.bytes <= 1_000_000 && fill.tiles > 20, "{fill:?}");
        assert!(cache.has(TileId { level: 1, column: 0, row: 0 }).expect("read"));
    }
}
