//! MBTiles files (specification 1.3): pictures in SQLite, rows counted from the bottom.

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use rusqlite::{Connection, OpenFlags, OptionalExtension, params};

use super::{About, TileFile};
use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::grid::{TileGrid, TileId};
use crate::settings::{Attribution, Bounds};
use crate::sniff::{self, Picture};

/// Connections that wait for the next reader.
const READERS: usize = 4;
/// Bytes of a tile at most.
const MAX_TILE: usize = 16 * 1024 * 1024;

/// An MBTiles file that is open for reading.
#[derive(Debug)]
pub struct Mbtiles {
    path: std::path::PathBuf,
    readers: Mutex<Vec<Connection>>,
    grid: TileGrid,
    about: About,
}

fn open(path: &Path) -> rusqlite::Result<Connection> {
    let reader = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX)?;
    reader.busy_timeout(Duration::from_secs(5))?;
    // A file of others may hold views and triggers with functions of its own.
    reader.set_db_config(rusqlite::config::DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    Ok(reader)
}

impl Mbtiles {
    /// Opens a file.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn open(path: &Path, tile_px: u32) -> std::result::Result<Self, String> {
        let failed = |error: rusqlite::Error| format!("no MBTiles file: {error}");
        if !path.is_file() {
            return Err(format!("{} is no file", path.display()));
        }
        let reader = open(path).map_err(failed)?;
        let note = |name: &str| -> std::result::Result<Option<String>, String> {
            let found =
                reader.query_row("SELECT value FROM metadata WHERE name=?", [name], |row| row.get::<_, String>(0));
            match found.optional() {
                Err(rusqlite::Error::SqliteFailure(..)) if name == "format" => Ok(None),
                found => found.map_err(failed),
            }
        };
        let sample: Option<Vec<u8>> = reader
            .query_row("SELECT tile_data FROM tiles WHERE tile_data IS NOT NULL LIMIT 1", [], |row| row.get(0))
            .optional()
            .map_err(failed)?;
        let sample = sample.ok_or("the file has no tiles")?;
        if Picture::of(&sample).is_none() {
            return Err(format!("its tiles are no pictures but {}", sniff::describe(&sample)));
        }
        let zooms: (Option<u8>, Option<u8>) = reader
            .query_row("SELECT MIN(zoom_level), MAX(zoom_level) FROM tiles", [], |row| Ok((row.get(0)?, row.get(1)?)))
            .map_err(failed)?;
        let (min_zoom, max_zoom) = (zooms.0.unwrap_or(0), zooms.1.unwrap_or(0).min(30));
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
        let free = self.readers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let reader = match free {
            Some(reader) => reader,
            None => open(&self.path).map_err(|error| broken(error.to_string()))?,
        };
        let row = (1_u64 << tile.level) - 1 - u64::from(tile.row);
        let found = reader
            .prepare_cached("SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=?")
            .and_then(|mut query| {
                query
                    .query_row(params![tile.level, tile.column, row.cast_signed()], |row| {
                        Ok(row.get_ref(0)?.as_blob_or_null()?.map(Bytes::copy_from_slice))
                    })
                    .optional()
            })
            .map_err(|error| broken(error.to_string()))?;
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
        assert!(Mbtiles::open(folder.path(), 256).unwrap_err().contains("no file"));
    }
}
