//! Areas in the database of their source: their tiles, their progress, and which process fetches them.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use rusqlite::{Connection, ErrorCode, params};

use super::area::{Area, AreaState, NewArea};
use crate::cache::{Cache, counted};
use crate::error::{MapError, Result};
use crate::grid::TileId;
use crate::task::blocking;

/// How often it is looked whether an area that another process fetches is left to this one, at first and at least.
const CLAIM_WAIT: (Duration, Duration) = (Duration::from_millis(20), Duration::from_secs(2));
/// Tiles that are taken in hand at once.
const BATCH: u32 = 128;
const COLUMNS: &str = "id, name, shape, min_level, max_level, state, detail, created_s, bytes";

fn read_area(row: &rusqlite::Row<'_>, source: &str) -> rusqlite::Result<Area> {
    let shape: String = row.get(2)?;
    let wrong = |error| rusqlite::Error::FromSqlConversionFailure(2, rusqlite::types::Type::Text, Box::new(error));
    Ok(Area {
        id: row.get(0)?,
        source: source.to_owned(),
        name: row.get(1)?,
        shape: serde_json::from_str(&shape).map_err(wrong)?,
        min_level: row.get(3)?,
        max_level: row.get(4)?,
        state: AreaState::of(&row.get::<_, String>(5)?),
        detail: row.get(6)?,
        tiles: 0,
        done: 0,
        failed: 0,
        bytes: row.get::<_, i64>(8)?.cast_unsigned(),
        created_at: row.get(7)?,
        rate_tiles_s: None,
    })
}

pub(super) fn areas_of(cache: &Cache, source: &str) -> Result<Vec<Area>> {
    cache.read(|reader| {
        let mut query = reader.prepare_cached(&format!("SELECT {COLUMNS} FROM areas ORDER BY created_s, id"))?;
        let mut areas: Vec<Area> =
            query.query_map([], |row| read_area(row, source))?.collect::<rusqlite::Result<_>>()?;
        for area in &mut areas {
            let [open, done, failed] =
                [OPEN, DONE, FAILED].map(|state| counted(reader, &format!("area/{}/{state}", area.id)));
            (area.done, area.failed) = (done?, failed?);
            area.tiles = open? + area.done + area.failed;
        }
        Ok(areas)
    })
}

/// States of a tile of an area.
pub(super) const OPEN: i64 = 0;
pub(crate) const DONE: i64 = 1;
pub(super) const FAILED: i64 = 2;

pub(super) fn add_area(cache: &Cache, id: &str, area: &NewArea, tiles: &[TileId], now_s: i64) -> Result<()> {
    let shape = serde_json::to_string(&area.shape).map_err(MapError::storage)?;
    let mut writer = cache.writer();
    let transaction = writer.transaction()?;
    transaction.execute(
        "INSERT INTO areas (id, name, shape, min_level, max_level, state, created_s) VALUES (?, ?, ?, ?, ?, 'running', ?)",
        params![id, area.name, shape, area.min_level, area.max_level, now_s],
    )?;
    {
        let mut insert =
            transaction.prepare("INSERT INTO area_tiles (level, col, row, area, state) VALUES (?, ?, ?, ?, ?)")?;
        for tile in tiles {
            insert.execute(params![tile.level, tile.column, tile.row, id, OPEN])?;
        }
    }
    transaction.commit()?;
    Ok(())
}

pub(super) fn set_state(cache: &Cache, id: &str, state: AreaState, detail: Option<&str>) -> Result<()> {
    cache.writer().execute("UPDATE areas SET state=?, detail=? WHERE id=?", params![state.name(), detail, id])?;
    Ok(())
}

/// Records a download's progress; `false` when it is to stop: it was paused or removed, perhaps by another process.
pub(super) fn set_running(cache: &Cache, id: &str, state: AreaState, detail: Option<&str>) -> Result<bool> {
    let sql = "UPDATE areas SET state=?, detail=? WHERE id=? AND state='running'";
    Ok(cache.writer().execute(sql, params![state.name(), detail, id])? > 0)
}

/// Lock by which one of the processes that use the folder fetches an area; it ends with its process, however that ends.
/// SQLite's, because every system has it. `None`: another process fetches it.
fn claim(cache: &Cache, id: &str) -> Result<Option<Claim>> {
    let path = cache.path().with_file_name(format!(".area-{id}.lock"));
    let lock = Connection::open(&path)?;
    match lock.execute_batch("PRAGMA journal_mode=MEMORY; PRAGMA synchronous=OFF; BEGIN EXCLUSIVE;") {
        Ok(()) => Ok(Some(Claim { _lock: Mutex::new(lock), path })),
        Err(error) if error.sqlite_error_code() == Some(ErrorCode::DatabaseBusy) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Waits for the right to fetch an area: its holder may be about to end. `None` when it is no longer to be fetched.
pub(super) async fn claimed(cache: &Arc<Cache>, id: &str) -> Result<Option<Claim>> {
    let mut wait = CLAIM_WAIT.0;
    loop {
        let (cache, id) = (cache.clone(), id.to_owned());
        let (got, is_wanted) = blocking(move || {
            let got = claim(&cache, &id)?;
            let sql = "SELECT 1 FROM areas WHERE id=? AND state='running'";
            Ok((got, cache.read(|reader| reader.prepare_cached(sql)?.exists([&id]))?))
        })
        .await?;
        match (got, is_wanted) {
            (_, false) => return Ok(None),
            (Some(claim), true) => return Ok(Some(claim)),
            (None, true) => tokio::time::sleep(wait).await,
        }
        wait = (wait * 2).min(CLAIM_WAIT.1);
    }
}

/// The right to fetch an area.
pub(super) struct Claim {
    _lock: Mutex<Connection>,
    path: std::path::PathBuf,
}

impl Drop for Claim {
    fn drop(&mut self) {
        // A process that opened it meanwhile holds an unlinked file and fetches as well, which only costs time.
        let _ = std::fs::remove_file(&self.path);
    }
}

pub(super) fn open_tiles(cache: &Cache, id: &str) -> Result<Vec<TileId>> {
    cache.read(|reader| {
        let mut query = reader.prepare_cached(
            "SELECT level, col, row FROM area_tiles WHERE area=? AND state=? ORDER BY level, row, col LIMIT ?",
        )?;
        let rows = query.query_map(params![id, OPEN, BATCH], |row| {
            Ok(TileId { level: row.get(0)?, column: row.get(1)?, row: row.get(2)? })
        })?;
        rows.collect()
    })
}

pub(super) fn mark(cache: &Cache, id: &str, marks: &[(TileId, i64)], bytes: u64) -> Result<()> {
    let mut writer = cache.writer();
    let transaction = writer.transaction()?;
    {
        let mut update =
            transaction.prepare_cached("UPDATE area_tiles SET state=? WHERE level=? AND col=? AND row=? AND area=?")?;
        for (tile, state) in marks {
            update.execute(params![state, tile.level, tile.column, tile.row, id])?;
        }
        transaction.execute("UPDATE areas SET bytes=bytes+? WHERE id=?", params![bytes.cast_signed(), id])?;
    }
    transaction.commit()?;
    Ok(())
}
