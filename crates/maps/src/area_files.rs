//! Offline areas as MBTiles files: written for other programs and stations, and taken from them.

use std::path::{Path, PathBuf};

use bytes::Bytes;
use rusqlite::{Connection, OptionalExtension, params};

use crate::areas::{Area, DONE, MAX_TILES, new_id};
use crate::cache::{self, Cache, CachedTile};
use crate::cover::{self, Shape};
use crate::error::{MapError, Result};
use crate::grid::{TileGrid, TileId};
use crate::kinds::mbtiles;
use crate::memory::lease;
use crate::service::Maps;
use crate::settings::SourceSettings;
use crate::sniff;
use crate::task::blocking;

/// Bytes of a note of a file at most: the largest is an area's outline.
const MAX_NOTE: usize = 1024 * 1024;
/// How long an imported tile is new.
const IMPORTED: std::time::Duration = std::time::Duration::from_secs(30 * 86_400);

impl Maps {
    /// Writes what is here of an area into an MBTiles file of the folder for temporary ones, and gives its path.
    ///
    /// # Errors
    /// [`MapError::NoArea`], [`MapError::Storage`].
    pub async fn export_area(&self, id: &str) -> Result<(PathBuf, String)> {
        self.room()?;
        let (area, source, cache) = self.find(id).await?;
        let grid = self.known_grid(&source).await?;
        let folder = self.folder().join("tmp");
        let settings = source.settings.clone();
        blocking(move || {
            vencejo_store::make_folder(&folder)?;
            let path = folder.join(format!("{}-{}.mbtiles", area.id, new_id(&cache)?));
            let result = export(&cache, &area, &grid, &settings, &path);
            if result.is_err() {
                let _ = std::fs::remove_file(&path);
            }
            result.map(|()| (path, area.name))
        })
        .await
    }

    /// Imports the tiles of an MBTiles file into a source's cache, as a finished area.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when the file is not MBTiles or has another grid; [`MapError::OfflineRefused`].
    pub async fn import_area(&self, source: &str, name: &str, path: PathBuf) -> Result<Area> {
        self.room()?;
        let (source, cache) = self.cached_source(source)?;
        let grid = self.known_grid(&source).await?;
        let (name, now_s) = (sniff::one_line(name, 100), self.now_s());
        let into = source.clone();
        let id = blocking(move || import(&cache, &grid, &into.settings, &name, &path, now_s)).await?;
        source.shown.clear();
        self.notify_changes();
        self.area(&id).await
    }
}

/// The grid of an exported file.
fn grid_mark(grid: &TileGrid) -> String {
    let parts: Vec<_> =
        grid.levels.iter().map(|level| (level.resolution.to_bits(), level.origin, level.tile_px)).collect();
    format!("{}-{:016x}", grid.crs.code(), crate::settings::fnv1a(format!("{parts:?}").as_bytes()))
}

/// Rows of a level, by which MBTiles counts from the bottom.
fn rows(grid: &TileGrid, level: u8) -> u64 {
    let size = grid.levels.get(usize::from(level)).and_then(|level| level.size);
    size.map_or(1_u64 << level.min(62), |[_, rows]| rows.into())
}

fn export(cache: &Cache, area: &Area, grid: &TileGrid, settings: &SourceSettings, path: &Path) -> Result<()> {
    let out = Connection::open(path)?;
    out.execute_batch(
        "PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF; PRAGMA application_id=0x4d504258;
         CREATE TABLE metadata (name TEXT, value TEXT);
         CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB);",
    )?;
    out.execute("ATTACH ? AS cache", [cache.path().to_string_lossy()])?;
    for level in area.min_level..=area.max_level {
        out.execute(
            "INSERT INTO tiles SELECT level, col, ? - row, data FROM cache.images AS image WHERE level=? AND data IS NOT NULL \
             AND EXISTS (SELECT 1 FROM cache.area_tiles AS kept WHERE kept.level=image.level AND kept.col=image.col \
             AND kept.row=image.row AND kept.area=?)",
            params![rows(grid, level).cast_signed() - 1, level, area.id],
        )?;
    }
    out.execute_batch("CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row)")?;
    let sample: Option<Vec<u8>> =
        out.query_row("SELECT tile_data FROM tiles LIMIT 1", [], |row| row.get(0)).optional()?;
    let sample = sample.ok_or_else(|| MapError::Request("nothing of the area is here yet".to_owned()))?;
    let format = sniff::Picture::of(&sample).map_or("png", sniff::Picture::short);
    let named: Vec<&str> = settings.attribution.iter().map(|named| named.text.as_str()).collect();
    let mut notes = vec![
        ("name", area.name.clone()),
        ("format", format.to_owned()),
        ("type", "baselayer".to_owned()),
        ("minzoom", area.min_level.to_string()),
        ("maxzoom", area.max_level.to_string()),
        ("attribution", named.join(", ")),
        ("description", settings.name.clone()),
        ("vencejo_source", settings.id.clone()),
        ("vencejo_grid", grid_mark(grid)),
        ("vencejo_shape", serde_json::to_string(&area.shape).map_err(MapError::storage)?),
    ];
    if let Some(bounds) = cover::bounds(&area.shape) {
        notes.push((
            "bounds",
            format!("{},{},{},{}", bounds.west_deg, bounds.south_deg, bounds.east_deg, bounds.north_deg),
        ));
    }
    for (name, value) in notes {
        out.execute("INSERT INTO metadata VALUES (?, ?)", params![name, value])?;
    }
    Ok(())
}

fn import(
    cache: &Cache,
    grid: &TileGrid,
    settings: &SourceSettings,
    name: &str,
    path: &Path,
    now_s: i64,
) -> Result<String> {
    let wrong = |reason: String| MapError::file("the file", reason);
    let failed = |error: rusqlite::Error| wrong(format!("no MBTiles file: {}", mbtiles::words(&error)));
    let _lease = lease(Some(mbtiles::MEMORY)).map_err(wrong)?;
    let file = mbtiles::Reader::open(path).map_err(failed)?;
    if let Some(fault) = file.fault().map_err(failed)? {
        return Err(wrong(fault));
    }
    let note = |name: &str| -> Option<String> {
        let text =
            file.ask().query_row("SELECT value FROM metadata WHERE name=?", [name], |row| row.get::<_, String>(0));
        text.ok().filter(|text| text.len() <= MAX_NOTE)
    };
    let usual = TileGrid::standard(crate::crs::Crs::WebMercator, 256, 0, 0);
    let is_usual = grid.crs == usual.crs
        && grid.levels.iter().enumerate().all(|(zoom, level)| {
            let expected = usual.levels[0].resolution / f64::from(1_u32 << zoom.min(30));
            (level.resolution / expected - 1.0).abs() < 1e-9 && level.origin == usual.levels[0].origin
        });
    match note("vencejo_grid") {
        Some(mark) if mark != grid_mark(grid) => {
            return Err(wrong(format!("its tiles lie on another grid than those of '{}'", settings.id)));
        }
        None if !is_usual => {
            return Err(wrong(format!(
                "'{}' is not in Web Mercator, so only files that were exported of it fit",
                settings.id
            )));
        }
        _ => {}
    }
    let count: i64 = file.ask().query_row("SELECT COUNT(*) FROM tiles", [], |row| row.get(0)).map_err(failed)?;
    if count.cast_unsigned() > MAX_TILES {
        return Err(MapError::AreaTooLarge { tiles: count.cast_unsigned(), most: MAX_TILES });
    }
    let mut query =
        file.ask().prepare("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles").map_err(failed)?;
    let mut found = query.query([]).map_err(failed)?;
    let id = new_id(cache)?;
    let mut writer = cache.writer();
    let transaction = writer.transaction()?;
    let (mut min_level, mut max_level, mut tiles, mut bytes) = (u8::MAX, 0, 0_u64, 0_u64);
    let mut corners: Option<[f64; 4]> = None;
    {
        let mut insert = transaction
            .prepare("INSERT OR IGNORE INTO area_tiles (level, col, row, area, state) VALUES (?, ?, ?, ?, ?)")?;
        for seen in 0_u64.. {
            // Each row has its time.
            file.ask();
            let Some(row) = found.next().map_err(failed)? else { break };
            if seen >= MAX_TILES {
                return Err(MapError::AreaTooLarge { tiles: seen + 1, most: MAX_TILES });
            }
            let number = |index: usize| row.get::<_, i64>(index).map_err(failed);
            let level = u8::try_from(number(0)?).map_err(|_| wrong("a zoom is out of range".to_owned()))?;
            let from_top = (rows(grid, level).cast_signed() - 1).checked_sub(number(2)?);
            let place = u32::try_from(number(1)?).ok().zip(from_top.and_then(|row| u32::try_from(row).ok()));
            let Some((column, row_number)) = place else { return Err(wrong("a tile lies off the grid".to_owned())) };
            let tile = TileId { level, column, row: row_number };
            let Some(extent) = grid.tile_extent(tile) else { continue };
            let data: Vec<u8> = row.get(3).map_err(failed)?;
            sniff::check_picture(&data).map_err(|reason| wrong(format!("tile {tile} is {reason}")))?;
            bytes += data.len() as u64;
            cache::put(&transaction, tile, &CachedTile::new(Some(Bytes::from(data)), now_s, IMPORTED))?;
            insert.execute(params![tile.level, tile.column, tile.row, id, DONE])?;
            (min_level, max_level) = (min_level.min(level), max_level.max(level));
            let [a, b, c, d] = corners.unwrap_or(extent);
            corners = Some([a.min(extent[0]), b.min(extent[1]), c.max(extent[2]), d.max(extent[3])]);
            tiles += 1;
        }
    }
    let bounds = corners.and_then(|extent| crate::geo::Bounds::around(grid.crs, extent));
    let Some(bounds) = bounds.filter(|_| tiles > 0) else {
        return Err(wrong("it has no tiles that the source could show".to_owned()));
    };
    let shape: Option<Shape> = note("vencejo_shape").and_then(|text| serde_json::from_str(&text).ok());
    let shape = shape.filter(|shape| shape.check().is_ok()).unwrap_or(Shape::Box(bounds));
    let own = note("name").map(|name| sniff::one_line(&name, 100));
    let name = if name.trim().is_empty() { own.filter(|own| !own.is_empty()) } else { Some(name.to_owned()) };
    transaction.execute(
        "INSERT INTO areas (id, name, shape, min_level, max_level, state, created_s, bytes) VALUES (?, ?, ?, ?, ?, 'done', ?, ?)",
        params![
            id,
            name.unwrap_or_else(|| "imported".to_owned()),
            serde_json::to_string(&shape).map_err(MapError::storage)?,
            min_level,
            max_level,
            now_s,
            bytes.cast_signed()
        ],
    )?;
    transaction.commit()?;
    Ok(id)
}
