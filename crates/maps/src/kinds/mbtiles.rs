//! MBTiles files (specification 1.3): pictures in SQLite, rows counted from the bottom.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use rusqlite::config::DbConfig;
use rusqlite::hooks::{AuthAction, AuthContext, Authorization};
use rusqlite::limits::Limit;
use rusqlite::{Connection, ErrorCode, OpenFlags, OptionalExtension, params};

use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening};
use crate::live::{About, TileFile};
use crate::memory::{Deadline, lease};
use crate::settings::{Attribution, SourceKind};
use crate::sniff::{self, Picture};

/// Connections that wait for the next reader.
const READERS: usize = 4;
/// Bytes of a tile at most.
const MAX_TILE: usize = 16 * 1024 * 1024;
/// How long one question may take.
const PATIENCE: Duration = Duration::from_secs(3);
/// Bytes that one question may take: a value, its copy, and SQLite's own pages.
pub(crate) const MEMORY: u64 = 3 * MAX_TILE as u64;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "tile_px", "encoding", "below_sea_level"]
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        opening.zoomed(Mbtiles::open(&opening.path(), opening.tile_px()))
    }

    fn file_ends(&self) -> &'static [&'static str] {
        &[".mbtiles"]
    }

    fn look(&self, path: &Path) -> std::result::Result<(SourceKind, About), String> {
        Ok((SourceKind::Mbtiles, Mbtiles::open(path, 256)?.about()))
    }
}

/// An MBTiles file that is open for reading.
#[derive(Debug)]
pub struct Mbtiles {
    path: std::path::PathBuf,
    readers: Mutex<Vec<Reader>>,
    grid: TileGrid,
    about: About,
}

/// A restricted connection for untrusted files: reads of tables and views only, with limits on time and
/// size of values (sqlite.org/security.html, "Untrusted SQLite Database Files").
#[derive(Debug)]
pub(crate) struct Reader {
    connection: Connection,
    /// When what is being asked has taken too long.
    until: Arc<Mutex<Deadline>>,
}

impl Reader {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> rusqlite::Result<Self> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        connection.busy_timeout(PATIENCE)?;
        for (option, is_on) in [
            (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
            (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
            (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
        ] {
            connection.set_db_config(option, is_on)?;
        }
        for (limit, most) in [
            (Limit::SQLITE_LIMIT_LENGTH, MAX_TILE),
            (Limit::SQLITE_LIMIT_SQL_LENGTH, 64 * 1024),
            (Limit::SQLITE_LIMIT_COLUMN, 100),
            (Limit::SQLITE_LIMIT_EXPR_DEPTH, 50),
            (Limit::SQLITE_LIMIT_COMPOUND_SELECT, 8),
            (Limit::SQLITE_LIMIT_VDBE_OP, 20_000),
            (Limit::SQLITE_LIMIT_FUNCTION_ARG, 8),
            (Limit::SQLITE_LIMIT_ATTACHED, 0),
            (Limit::SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 100),
            (Limit::SQLITE_LIMIT_TRIGGER_DEPTH, 1),
            (Limit::SQLITE_LIMIT_WORKER_THREADS, 0),
        ] {
            connection.set_limit(limit, i32::try_from(most).unwrap_or(i32::MAX))?;
        }
        connection.execute_batch(
            "PRAGMA mmap_size=0; PRAGMA cache_size=-4000; PRAGMA temp_store=FILE; PRAGMA cell_size_check=ON",
        )?;
        let until = Arc::new(Mutex::new(Deadline::after(PATIENCE)));
        let asked = until.clone();
        let is_late = move || asked.lock().unwrap_or_else(PoisonError::into_inner).is_over();
        connection.progress_handler(1000, Some(is_late))?;
        let reader = Self { connection, until };
        reader.connection.authorizer(Some(allow))?;
        Ok(reader)
    }

    /// The connection, for a question that has its time from now on.
    pub(crate) fn ask(&self) -> &Connection {
        *self.until.lock().unwrap_or_else(PoisonError::into_inner) = Deadline::after(PATIENCE);
        &self.connection
    }

    /// Why its tiles and notes are not read, when they are made by more than a view over tables.
    pub(crate) fn fault(&self) -> rusqlite::Result<Option<String>> {
        let mut found = self.ask().prepare("SELECT type, name, rootpage, sql FROM sqlite_master LIMIT 1000")?;
        let rows = found.query_map([], |row| {
            let text = |index| row.get::<_, Option<String>>(index).map(Option::unwrap_or_default);
            Ok((text(0)?, text(1)?.to_ascii_lowercase(), row.get::<_, Option<i64>>(2)?, text(3)?.to_ascii_lowercase()))
        })?;
        let things = rows.collect::<rusqlite::Result<Vec<_>>>()?;
        let views: Vec<&str> =
            things.iter().filter(|(kind, ..)| kind == "view").map(|(_, name, ..)| name.as_str()).collect();
        for (kind, name, root, sql) in &things {
            // Words of the statement; a name in quotes is one as well.
            let has_word = |word: &str| sql.split(|c: char| !c.is_alphanumeric() && c != '_').any(|part| part == word);
            if kind == "table" && (root.is_none_or(|page| page == 0) || has_word("virtual") || has_word("generated")) {
                return Ok(Some(format!("its table '{}' is a program, not data", sniff::one_line(name, 40))));
            }
            if kind == "view" && !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
                return Ok(Some("one of its views has no plain name".to_owned()));
            }
            let is_read = kind == "view" && ["tiles", "metadata"].contains(&name.as_str());
            if is_read && views.iter().any(|view| view != name && has_word(view)) {
                return Ok(Some(format!("its view '{name}' is made of other views; only views over tables are read")));
            }
        }
        Ok(None)
    }
}

/// Authorizes statements, views of the file included: reading tables and harmless functions.
fn allow(asked: AuthContext<'_>) -> Authorization {
    match asked.action {
        AuthAction::Select | AuthAction::Read { .. } => Authorization::Allow,
        AuthAction::Function { function_name } => {
            let is_harmless = ["min", "max", "count", "coalesce", "ifnull"]
                .iter()
                .any(|name| function_name.eq_ignore_ascii_case(name));
            if is_harmless { Authorization::Allow } else { Authorization::Deny }
        }
        _ => Authorization::Deny,
    }
}

/// What SQLite says, for people.
pub(crate) fn words(error: &rusqlite::Error) -> String {
    match error.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => {
            format!(
                "a question to it takes more than {} s; it needs an index on zoom_level, tile_column, tile_row",
                PATIENCE.as_secs()
            )
        }
        Some(ErrorCode::AuthorizationForStatementDenied) => {
            "its views compute more than tiles; only views over tables are read".to_owned()
        }
        Some(ErrorCode::TooBig) => format!("a value in it has more than {MAX_TILE} bytes"),
        _ => error.to_string(),
    }
}

impl Mbtiles {
    /// Opens a file.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn open(path: &Path, tile_px: u32) -> std::result::Result<Self, String> {
        let failed = |error: rusqlite::Error| format!("no MBTiles file: {}", words(&error));
        if !path.is_file() {
            return Err(format!("{} is not a file", path.display()));
        }
        let _lease = lease(Some(MEMORY))?;
        let reader = Reader::open(path).map_err(failed)?;
        if let Some(fault) = reader.fault().map_err(failed)? {
            return Err(format!("no MBTiles file that can be read: {fault}"));
        }
        let note = |name: &str| -> std::result::Result<Option<String>, String> {
            let asked = reader.ask();
            let found =
                asked.query_row("SELECT value FROM metadata WHERE name=?", [name], |row| row.get::<_, String>(0));
            match found.optional() {
                Err(rusqlite::Error::SqliteFailure(..)) if name == "format" => Ok(None),
                found => found.map_err(failed),
            }
        };
        let sample: Option<Vec<u8>> = reader
            .ask()
            .query_row("SELECT tile_data FROM tiles WHERE tile_data IS NOT NULL LIMIT 1", [], |row| row.get(0))
            .optional()
            .map_err(failed)?;
        let sample = sample.ok_or("the file has no tiles")?;
        if Picture::of(&sample).is_none() {
            return Err(format!("its tiles are no pictures but {}", sniff::describe(&sample)));
        }
        // One at a time: each is found by the index alone.
        let zoom = |which: &str| -> std::result::Result<Option<u8>, String> {
            let asked = format!("SELECT {which}(zoom_level) FROM tiles");
            reader.ask().query_row(&asked, [], |row| row.get(0)).map_err(failed)
        };
        let (min_zoom, max_zoom) = (zoom("MIN")?.unwrap_or(0), zoom("MAX")?.unwrap_or(0).min(30));
        let bounds = note("bounds")?.and_then(|text| bounds_of(&text));
        let attribution =
            note("attribution")?.map(|text| sniff::words(text.as_bytes())).filter(|text| !text.is_empty());
        let about = About {
            name: note("name")?.map(|name| sniff::one_line(&name, 100)).filter(|name| !name.is_empty()),
            bounds,
            attribution: attribution.map(|text| Attribution { text, url: None }),
            is_overlay: note("type")?.as_deref() == Some("overlay"),
            max_zoom: Some(max_zoom),
        };
        let grid = TileGrid::standard(Crs::WebMercator, tile_px, min_zoom, max_zoom).within(bounds.as_ref());
        Ok(Self { path: path.to_owned(), readers: Mutex::new(vec![reader]), grid, about })
    }
}

/// `west,south,east,north`, as the specification has it.
fn bounds_of(text: &str) -> Option<Bounds> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    let [west_deg, south_deg, east_deg, north_deg] = *numbers.as_slice() else { return None };
    let bounds = Bounds { west_deg, south_deg, east_deg, north_deg };
    bounds.fault().is_none().then_some(bounds)
}

impl TileFile for Mbtiles {
    fn grid(&self) -> &TileGrid {
        &self.grid
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn tile(&self, tile: TileId) -> Result<Option<Bytes>> {
        let broken = |reason: String| MapError::file(self.path.display().to_string(), reason);
        let _lease = lease(Some(MEMORY)).map_err(broken)?;
        let free = self.readers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let reader = match free {
            Some(reader) => reader,
            None => Reader::open(&self.path).map_err(|error| broken(words(&error)))?,
        };
        let row = (1_u64 << tile.level.min(62)).wrapping_sub(1 + u64::from(tile.row));
        let found = reader
            .ask()
            .prepare_cached("SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=?")
            .and_then(|mut query| {
                query
                    .query_row(params![tile.level, tile.column, row.cast_signed()], |row| {
                        Ok(row.get_ref(0)?.as_blob_or_null()?.map(Bytes::copy_from_slice))
                    })
                    .optional()
            })
            .map_err(|error| broken(words(&error)))?;
        let mut readers = self.readers.lock().unwrap_or_else(PoisonError::into_inner);
        if readers.len() < READERS {
            readers.push(reader);
        }
        drop(readers);
        match found.flatten() {
            Some(data) if data.len() > MAX_TILE => Err(broken(format!("tile {tile} has {} bytes", data.len()))),
            found => Ok(found),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::testing::Folder;

    fn make(path: &Path, data: &[u8]) {
        let file = Connection::open(path).expect("a database");
        file.execute_batch(
            "CREATE TABLE metadata (name TEXT, value TEXT); CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, \
             tile_row INTEGER, tile_data BLOB); INSERT INTO metadata VALUES ('name', 'Field'), ('bounds', '-4,40,-3,41'), \
             ('attribution', '<a href=\"x\">Ana</a> & co'), ('type', 'overlay')",
        )
        .expect("tables");
        file.execute("INSERT INTO tiles VALUES (3, 3, 4, ?)", [data]).expect("a tile");
    }

    #[test]
    fn rows_are_counted_from_the_bottom() {
        let folder = Folder::new();
        let path = folder.path().join("a.mbtiles");
        let png = Raster::filled(1, 1, [1, 2, 3, 255]).to_png();
        make(&path, &png);
        let file = Mbtiles::open(&path, 256).expect("a file");
        let about = file.about();
        assert_eq!((about.name.as_deref(), about.is_overlay, about.max_zoom), (Some("Field"), true, Some(3)));
        assert_eq!(about.attribution.expect("named").text, "Ana & co");
        assert_eq!(file.tile(TileId { level: 3, column: 3, row: 3 }).expect("read").as_deref(), Some(&*png));
        assert_eq!(file.tile(TileId { level: 3, column: 3, row: 4 }).expect("read"), None);
        assert!(file.grid().contains(TileId { level: 3, column: 3, row: 3 }));
    }

    #[test]
    fn what_cannot_be_shown_says_why() {
        let folder = Folder::new();
        let path = folder.path().join("v.mbtiles");
        make(&path, &[0x1f, 0x8b, 8, 0]);
        assert!(Mbtiles::open(&path, 256).unwrap_err().contains("vector"));
        std::fs::write(folder.path().join("t"), "text that is no database, of some length, as it happens to be")
            .expect("written");
        assert!(Mbtiles::open(&folder.path().join("t"), 256).unwrap_err().contains("no MBTiles"));
        assert!(Mbtiles::open(folder.path(), 256).unwrap_err().contains("not a file"));
    }
}
