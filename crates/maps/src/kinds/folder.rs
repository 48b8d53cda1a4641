//! Folders of tiles, a picture a file: `{z}/{x}/{y}.png`, `.jpg` or `.webp`, as gdal2tiles, MOBAC and many other
//! programs write them. Rows are counted from the top (XYZ) or from the bottom (TMS), which the names do not show.
//!
//! Only files whose whole path are numbers are read, and none that a link leads to out of the folder.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use bytes::Bytes;

use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening};
use crate::live::{About, TileFile};
use crate::memory::lease;
use crate::settings::MAX_ZOOM;

/// Bytes of a tile at most.
const MAX_TILE: u64 = 16 * 1024 * 1024;
/// Entries of a folder and of those inside it that are looked at.
const MAX_ENTRIES: usize = 1_000_000;
/// Ends of the names of tiles, the likeliest first.
const ENDS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "tms", "tile_px", "encoding", "below_sea_level"]
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        opening.zoomed(Tiles::open(&opening.path(), opening.settings.tms, opening.tile_px()))
    }

    fn folder_bytes(&self, folder: &Path) -> Option<u64> {
        let mut bytes = None;
        let mut walk = Walk::default();
        walk.tiles(folder, &mut |_, _, path| {
            let size = fs::metadata(path).map_or(0, |about| about.len());
            bytes = Some(bytes.unwrap_or(0) + size);
        });
        bytes
    }
}

/// Most entries of a folder that are examined; larger folders are seen in part.
#[derive(Default)]
struct Walk {
    entries: usize,
}

impl Walk {
    /// The entries of a folder whose names are numbers, with what `of` makes of each name.
    fn numbered(&mut self, folder: &Path, of: impl Fn(&str) -> Option<u32>) -> Vec<(u32, PathBuf)> {
        let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
        let left = MAX_ENTRIES.saturating_sub(self.entries);
        let entries = entries.take(left).inspect(|_| self.entries += 1).flatten();
        entries.filter_map(|entry| Some((of(entry.file_name().to_str()?)?, entry.path()))).collect()
    }

    /// Gives level, column and row, and the path, of each file that is named as a tile.
    fn tiles(&mut self, folder: &Path, take: &mut dyn FnMut(u8, [u32; 2], &Path)) {
        for (level, of_level) in self.numbered(folder, number) {
            let Some(level) = u8::try_from(level).ok().filter(|level| *level <= MAX_ZOOM) else { continue };
            let side = 1_u32 << level;
            for (column, of_column) in self.numbered(&of_level, number).into_iter().filter(|(column, _)| *column < side)
            {
                for (row, path) in self.numbered(&of_column, row_of).into_iter().filter(|(row, _)| *row < side) {
                    take(level, [column, row], &path);
                }
            }
        }
    }
}

/// The number that a name is: decimal digits alone, without zeros before it.
fn number(name: &str) -> Option<u32> {
    let number: u32 = name.parse().ok()?;
    (number.to_string() == name).then_some(number)
}

/// The row that a file's name says.
fn row_of(name: &str) -> Option<u32> {
    let (row, end) = name.split_once('.')?;
    number(row).filter(|_| ENDS.contains(&end))
}

/// Columns or rows from the first to behind the last, counted in tiles of [`MAX_ZOOM`].
type Span = (u64, u64);

/// A span with the tiles of a coarser level. Tiles that are there for finer ones alone make it no wider.
fn with_level(span: Option<Span>, level: u8, (first, last): (u32, u32)) -> Span {
    let unit = 1_u64 << (MAX_ZOOM - level);
    let own = (u64::from(first) * unit, (u64::from(last) + 1) * unit);
    let Some((from, to)) = span else { return own };
    let around = (from / unit * unit, to.div_ceil(unit) * unit);
    (if own.0 < around.0 { own.0 } else { from }, if own.1 > around.1 { own.1 } else { to })
}

/// A number of tiles of [`MAX_ZOOM`] as a part of the world.
fn share(tiles: u64) -> f64 {
    tiles as f64 / f64::from(1_u32 << MAX_ZOOM)
}

/// Longitude of the left edge of a column (OpenStreetMap wiki, "Slippy map tilenames").
fn lon_deg(column: u64) -> f64 {
    share(column) * 360.0 - 180.0
}

/// Latitude of the upper edge of a row (the same).
fn lat_deg(row: u64) -> f64 {
    (PI * (1.0 - 2.0 * share(row))).sinh().atan().to_degrees()
}

/// A folder of tiles that is open for reading.
#[derive(Debug)]
pub struct Tiles {
    /// With links resolved, so that paths can be compared.
    folder: PathBuf,
    is_tms: bool,
    grid: TileGrid,
    about: About,
}

impl Tiles {
    /// Opens a folder: zooms and bounds follow from the names of its files.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn open(folder: &Path, is_tms: bool, tile_px: u32) -> std::result::Result<Self, String> {
        let folder = folder.canonicalize().map_err(|error| format!("the folder cannot be read: {error}"))?;
        if !folder.is_dir() {
            return Err("it is a file; a folder of tiles has folders 0, 1, 2 … for its zooms".to_owned());
        }
        // Of each level the first and last column, and the first and last row from the top.
        let mut found: BTreeMap<u8, [(u32, u32); 2]> = BTreeMap::new();
        let mut walk = Walk::default();
        walk.tiles(&folder, &mut |level, [column, row], _| {
            let row = if is_tms { (1 << level) - 1 - row } else { row };
            let widen =
                |(first, last): &mut (u32, u32), with: u32| (*first, *last) = ((*first).min(with), (*last).max(with));
            let [columns, rows] = found.entry(level).or_insert([(column, column), (row, row)]);
            widen(columns, column);
            widen(rows, row);
        });
        let none = "it has no tiles {z}/{x}/{y}.png, .jpg or .webp";
        let (min_zoom, max_zoom) = found.keys().next().zip(found.keys().next_back()).ok_or(none)?;
        let (min_zoom, max_zoom) = (*min_zoom, *max_zoom);
        let spans = [0, 1].map(|axis| {
            let finest_first = found.iter().rev();
            finest_first.fold(None, |span, (level, ranges)| Some(with_level(span, *level, ranges[axis])))
        });
        // Where not all was looked at there may be more.
        let is_whole = walk.entries < MAX_ENTRIES;
        let bounds = spans[0].zip(spans[1]).filter(|_| is_whole).map(|((left, right), (top, bottom))| Bounds {
            west_deg: lon_deg(left),
            south_deg: lat_deg(bottom),
            east_deg: lon_deg(right),
            north_deg: lat_deg(top),
        });
        let about = About { bounds, max_zoom: Some(max_zoom), ..About::default() };
        let grid = TileGrid::standard(Crs::WebMercator, tile_px, min_zoom, max_zoom).within(bounds.as_ref());
        Ok(Self { folder, is_tms, grid, about })
    }

    /// The file of a tile, where there is one inside the folder.
    fn find(&self, tile: TileId) -> std::io::Result<Option<File>> {
        let TileId { level, column, row } = tile;
        let row = if self.is_tms { (1_u32 << level.min(31)).wrapping_sub(1).wrapping_sub(row) } else { row };
        let place = self.folder.join(level.to_string()).join(column.to_string());
        for end in ENDS {
            // Links are followed before it is looked where the file lies.
            let path = match place.join(format!("{row}.{end}")).canonicalize() {
                Ok(path) => path,
                Err(error)
                    if matches!(error.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory) =>
                {
                    continue;
                }
                Err(error) => return Err(error),
            };
            if !path.starts_with(&self.folder) {
                return Err(std::io::Error::other("a link leads out of the folder"));
            }
            // Reading anything but a plain file might block for ever.
            if !fs::metadata(&path)?.is_file() {
                return Err(std::io::Error::other("it is not a plain file"));
            }
            return File::open(path).map(Some);
        }
        Ok(None)
    }
}

impl TileFile for Tiles {
    fn grid(&self) -> &TileGrid {
        &self.grid
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn tile(&self, tile: TileId) -> Result<Option<Bytes>> {
        let broken =
            |reason: String| MapError::file(self.folder.display().to_string(), format!("tile {tile}: {reason}"));
        let failed = |error: std::io::Error| broken(error.to_string());
        let Some(file) = self.find(tile).map_err(failed)? else { return Ok(None) };
        let bytes = file.metadata().map_err(failed)?.len();
        if bytes > MAX_TILE {
            return Err(broken(format!("has {bytes} bytes; at most {MAX_TILE} are read")));
        }
        let _lease = lease(Some(bytes)).map_err(broken)?;
        let mut data = Vec::with_capacity(usize::try_from(bytes).unwrap_or_default());
        // It may grow while it is read.
        file.take(MAX_TILE).read_to_end(&mut data).map_err(failed)?;
        Ok(Some(data.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::testing::Folder;

    fn png(shade: u8) -> Vec<u8> {
        Raster::filled(1, 1, [shade, 0, 0, 255]).to_png()
    }

    fn put(folder: &Path, name: &str, data: &[u8]) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, data).expect("written");
    }

    const fn at(level: u8, column: u32, row: u32) -> TileId {
        TileId { level, column, row }
    }

    #[test]
    fn zooms_and_bounds_are_found_by_looking_and_tms_counts_from_the_bottom() {
        let folder = Folder::new();
        for (name, shade) in
            [("3/3/2.png", 1), ("4/7/5.jpg", 2), ("4/8/5.webp", 3), ("5/notes.txt", 4), ("25/0/0.png", 5)]
        {
            put(folder.path(), name, &png(shade));
        }
        for stranger in ["4/07/5.png", "4/+7/5.png", "4/7/5.png.png", "4/99/0.png", "tilemapresource.xml"] {
            put(folder.path(), stranger, &png(9));
        }
        let file = Tiles::open(folder.path(), false, 256).expect("a folder");
        assert_eq!((file.grid().min_level, file.grid().max_level, file.about().max_zoom), (3, 4, Some(4)));
        assert_eq!(file.tile(at(4, 7, 5)).expect("read").as_deref(), Some(&*png(2)));
        assert_eq!(file.tile(at(4, 7, 6)).expect("read"), None);
        // Zoom 4: columns 7 and 8 lie on both sides of Greenwich, 22.5° wide each; row 5 from 40.98° to 55.78° N.
        let bounds = file.about().bounds.expect("known");
        let near = |a: f64, b: f64| (a - b).abs() < 0.01;
        assert!(near(bounds.west_deg, -22.5) && near(bounds.east_deg, 22.5), "{bounds:?}");
        assert!(near(bounds.south_deg, 40.98) && near(bounds.north_deg, 55.78), "{bounds:?}");
        assert!(file.grid().contains(at(4, 8, 5)) && !file.grid().contains(at(4, 8, 10)));
        // A coarse tile elsewhere counts; the coarse one around the fine ones makes it no wider.
        put(folder.path(), "3/7/2.png", &png(6));
        let wider = Tiles::open(folder.path(), false, 256).expect("a folder").about().bounds.expect("known");
        assert!(
            near(wider.west_deg, -22.5) && near(wider.east_deg, 180.0) && near(wider.south_deg, 40.98),
            "{wider:?}"
        );

        let tms = Tiles::open(folder.path(), true, 256).expect("a folder");
        assert_eq!(tms.tile(at(4, 7, 10)).expect("read").as_deref(), Some(&*png(2)));
        assert!(near(tms.about().bounds.expect("known").north_deg, -40.98));
        fs::remove_file(folder.path().join("3/7/2.png")).expect("removed");
        assert!(
            Driver.folder_bytes(folder.path()).is_some() && Driver.folder_bytes(&folder.path().join("4")).is_none()
        );
    }

    #[test]
    fn what_is_hostile_is_refused_with_a_reason() {
        let folder = Folder::new();
        let inside = folder.path().join("tiles");
        put(&inside, "1/0/0.png", &png(1));
        File::create(inside.join("1/0/1.jpg")).and_then(|file| file.set_len(MAX_TILE + 1)).expect("made");
        put(&inside, "1/1/1.png", &png(2));
        put(folder.path(), "secret.png", &png(7));
        let refused = |tile: TileId| {
            let file = Tiles::open(&inside, false, 256).expect("a folder");
            file.tile(tile).expect_err("refused").to_string()
        };
        assert!(refused(at(1, 0, 1)).contains("bytes"), "{}", refused(at(1, 0, 1)));
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            symlink("../../../secret.png", inside.join("1/1/0.png")).expect("linked");
            assert!(refused(at(1, 1, 0)).contains("out of the folder"), "{}", refused(at(1, 1, 0)));
            // One that stays inside is what deduplicated caches are made of.
            fs::remove_file(inside.join("1/1/1.png")).expect("removed");
            symlink("../0/0.png", inside.join("1/1/1.png")).expect("linked");
            let file = Tiles::open(&inside, false, 256).expect("a folder");
            assert_eq!(file.tile(at(1, 1, 1)).expect("read").as_deref(), Some(&*png(1)));
        }
        let empty = folder.path().join("empty");
        fs::create_dir_all(empty.join("12/5")).expect("made");
        assert!(Tiles::open(&empty, false, 256).unwrap_err().contains("no tiles"));
        assert!(Tiles::open(&folder.path().join("secret.png"), false, 256).unwrap_err().contains("it is a file"));
        assert!(Tiles::open(&folder.path().join("gone"), false, 256).unwrap_err().contains("cannot be read"));
    }
}
