//! Heights in files: SRTM `.hgt` (plain or `.hgt.gz`) and GeoTIFF, one file or a folder of them.

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use flate2::read::GzDecoder;

use super::geotiff::file::GeoTiff;
use crate::elevation;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::kind::{Kind, Opened, Opening, Shelf};
use crate::live::{About, Height, HeightFile, Live};
use crate::memory::{Shelved, lease};
use crate::settings::{Role, SourceKind};
use crate::stamp::{REPLACED, Stamp};

/// Files of a folder at most.
const MAX_FILES: usize = 20_000;
/// Bytes of the largest SRTM tile: 3601 × 3601 heights of two bytes.
const MAX_HGT: u64 = 3601 * 3601 * 2;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "datum", "below_sea_level"]
    }

    fn roles(&self) -> &'static [Role] {
        &[Role::Elevation]
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        let dem = Dem::open(&opening.path(), opening.settings.below_sea_level);
        Ok(Live::Heights(Arc::new(opening.named(dem)?)))
    }

    fn file_ends(&self) -> &'static [&'static str] {
        &[".hgt", ".hgt.gz"]
    }

    fn look(&self, _path: &Path) -> std::result::Result<(SourceKind, About), String> {
        Ok((SourceKind::Dem, About::default()))
    }

    fn shelf(&self) -> Option<Shelf> {
        // Heights lie together: their names say where they belong.
        Some(Shelf { folder: "heights", name: "Heights from files" })
    }

    fn folder_bytes(&self, folder: &Path) -> Option<u64> {
        let heights = std::fs::read_dir(folder).ok()?.flatten().filter(|entry| is_height_file(&entry.path()));
        let bytes: Vec<u64> = heights.filter_map(|entry| entry.metadata().ok()).map(|about| about.len()).collect();
        (!bytes.is_empty()).then(|| bytes.iter().sum())
    }
}

/// A tile of one degree: heights at the corners and edges too, rows from the north (SRTM Topo, section 2.1).
#[derive(Debug, Clone)]
struct Hgt {
    corner: (i16, i16),
    path: PathBuf,
    /// Of the file whose side this is.
    stamp: Stamp,
    side: u32,
    is_packed: bool,
}

/// Heights of files.
#[derive(Debug)]
pub struct Dem {
    /// By the latitude and longitude of their south-west corner.
    tiles: HashMap<(i16, i16), Hgt>,
    rasters: Vec<GeoTiff>,
    /// Whether heights of GeoTIFFs below sea level are land. Tiles of SRTM have no floor of the sea: what is below in
    /// them is.
    has_land_below_sea: bool,
    unpacked: Shelved,
    /// Held while a tile is unpacked, so that it is done once.
    unpacking: Mutex<()>,
    bounds: Option<Bounds>,
}

impl HeightFile for Dem {
    fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    fn height(&self, lat_deg: f64, lon_deg: f64) -> Result<Option<Height>> {
        // A damaged file does not hide the heights of others.
        let mut fault = None;
        let mut best: Option<Height> = None;
        for raster in &self.rasters {
            if best.is_some_and(|best| raster.resolution_m() >= best.resolution_m) {
                continue;
            }
            match raster.height_m(lat_deg, lon_deg, self.has_land_below_sea) {
                Ok(Some(alt_m)) => best = Some(Height { alt_m, resolution_m: raster.resolution_m() }),
                Ok(None) => {}
                Err(error) => fault = Some(error),
            }
        }
        if best.is_some() {
            return Ok(best);
        }
        // Neighbours share their edges, so a place on one may be in either.
        let (lat, lon) = (lat_deg.floor(), lon_deg.floor());
        for (south, west) in [(lat, lon), (lat - 1.0, lon), (lat, lon - 1.0), (lat - 1.0, lon - 1.0)] {
            let (down, right) = (south + 1.0 - lat_deg, lon_deg - west);
            if !(0.0..=1.0).contains(&down) || !(0.0..=1.0).contains(&right) {
                continue;
            }
            let west = if west >= 180.0 {
                west - 360.0
            } else if west < -180.0 {
                west + 360.0
            } else {
                west
            };
            let Some(tile) = self.tiles.get(&(south as i16, west as i16)) else { continue };
            let steps = f64::from(tile.side - 1);
            let resolution_m = crate::crs::METRES_PER_DEGREE / steps;
            match self.between(tile, right * steps, down * steps) {
                Ok(Some(alt_m)) => return Ok(Some(Height { alt_m, resolution_m })),
                Ok(None) => {}
                Err(error) => fault = Some(error),
            }
        }
        fault.map_or(Ok(None), Err)
    }
}

impl Dem {
    /// Opens a file or a folder. Heights of GeoTIFFs below sea level are land, or else the sea floor, which counts as 0
    /// m.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn open(path: &Path, has_land_below_sea: bool) -> std::result::Result<Self, String> {
        let about = std::fs::metadata(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let (unpacked, unpacking) = (Shelved::unpacked(), Mutex::default());
        let (tiles, rasters) = (HashMap::new(), Vec::new());
        let mut dem = Self { tiles, rasters, has_land_below_sea, unpacked, unpacking, bounds: None };
        let mut faults = Vec::new();
        if about.is_dir() {
            let listed = std::fs::read_dir(path).map_err(|error| format!("{}: {error}", path.display()))?;
            let mut files: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).take(MAX_FILES).collect();
            files.sort();
            for file in files.iter().filter(|file| is_height_file(file)) {
                if let Err(fault) = dem.add(file) {
                    faults.push(format!("{}: {fault}", file.display()));
                }
            }
        } else {
            dem.add(path)?;
        }
        if dem.tiles.is_empty() && dem.rasters.is_empty() {
            return Err(faults
                .into_iter()
                .next()
                .unwrap_or_else(|| "it has no .hgt, .hgt.gz or .tif files".to_owned()));
        }
        for fault in faults {
            tracing::warn!(%fault, "a file of heights is not used");
        }
        let of_tiles = dem.tiles.keys().map(|(lat, lon)| {
            let (lat, lon) = (f64::from(*lat), f64::from(*lon));
            Bounds { west_deg: lon, south_deg: lat, east_deg: lon + 1.0, north_deg: lat + 1.0 }
        });
        dem.bounds = of_tiles.chain(dem.rasters.iter().filter_map(GeoTiff::bounds)).reduce(|a, b| Bounds {
            west_deg: a.west_deg.min(b.west_deg),
            south_deg: a.south_deg.min(b.south_deg),
            east_deg: a.east_deg.max(b.east_deg),
            north_deg: a.north_deg.max(b.north_deg),
        });
        Ok(dem)
    }

    fn add(&mut self, path: &Path) -> std::result::Result<(), String> {
        let name = path.file_name().map(|name| name.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        if name.ends_with(".tif") || name.ends_with(".tiff") {
            let raster = GeoTiff::open(path)?;
            return match raster.height_fault() {
                Some(fault) => Err(fault),
                None => {
                    self.rasters.push(raster);
                    Ok(())
                }
            };
        }
        let corner = corner_of(&name).ok_or("its name is not like N40W004.hgt, which says where it lies")?;
        let is_packed = name.ends_with(".gz");
        let about = std::fs::metadata(path).map_err(|error| error.to_string())?;
        let bytes = if is_packed { unpacked_bytes(path)? } else { about.len() };
        let side = [1201_u32, 3601, 1801, 601].into_iter().find(|side| u64::from(*side).pow(2) * 2 == bytes);
        let side = side.ok_or_else(|| format!("it has {bytes} bytes, which is not a square of heights"))?;
        self.tiles.insert(corner, Hgt { corner, path: path.to_owned(), stamp: Stamp::of(&about), side, is_packed });
        Ok(())
    }

    fn between(&self, tile: &Hgt, column: f64, row: f64) -> Result<Option<f64>> {
        let broken = |error: String| MapError::file(tile.path.display().to_string(), error);
        let mut file = File::open(&tile.path).map_err(|error| broken(error.to_string()))?;
        let about = file.metadata().map_err(|error| broken(error.to_string()))?;
        if Stamp::of(&about) != tile.stamp {
            return Err(broken(REPLACED.to_owned()));
        }
        let unpacked = if tile.is_packed { Some(self.unpacked(tile, &file).map_err(broken)?) } else { None };
        let mut sum = 0.0;
        for (weight, [column, row]) in elevation::corners(column, row) {
            if weight == 0.0 {
                continue;
            }
            let at = (u64::from(row) * u64::from(tile.side) + u64::from(column)) * 2;
            let mut bytes = [0_u8; 2];
            if let Some(unpacked) = &unpacked {
                let found = usize::try_from(at).ok().and_then(|at| unpacked.get(at..at + 2));
                bytes.copy_from_slice(found.ok_or_else(|| broken("it was cut short".to_owned()))?);
            } else {
                let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut bytes));
                read.map_err(|error| broken(error.to_string()))?;
            }
            let height = i16::from_be_bytes(bytes);
            let Some(alt_m) = elevation::land_m(height.into()) else { return Ok(None) };
            sum += weight * alt_m;
        }
        Ok(Some(sum))
    }

    fn unpacked(&self, tile: &Hgt, file: &File) -> std::result::Result<Arc<Vec<u8>>, String> {
        let _turn = self.unpacking.lock().unwrap_or_else(PoisonError::into_inner);
        let (south, west) = tile.corner;
        let key = (u64::from(south.cast_unsigned()), u64::from(west.cast_unsigned()));
        if let Some(known) = self.unpacked.get(key.0, key.1) {
            return Ok(known);
        }
        let bytes = Arc::new(unpack(file)?);
        let said = u64::from(tile.side).pow(2) * 2;
        if bytes.len() as u64 != said {
            return Err(format!("it unpacks to {} bytes, not to the {said} that it says", bytes.len()));
        }
        self.unpacked.put(key.0, key.1, &bytes, bytes.len());
        Ok(bytes)
    }
}

/// Whether a file's name is that of heights.
pub fn is_height_file(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    [".hgt", ".hgt.gz", ".tif", ".tiff"].iter().any(|end| name.ends_with(end))
}

/// How many bytes a packed file says it unpacks to (RFC 1952, ISIZE). Twenty thousand files are not unpacked to know
/// that.
fn unpacked_bytes(path: &Path) -> std::result::Result<u64, String> {
    let mut end = [0; 4];
    let read = File::open(path).and_then(|mut file| {
        file.seek(SeekFrom::End(-4))?;
        file.read_exact(&mut end)
    });
    read.map_err(|error| error.to_string())?;
    Ok(u32::from_le_bytes(end).into())
}

fn unpack(file: &File) -> std::result::Result<Vec<u8>, String> {
    let _lease = lease(Some(2 * MAX_HGT))?;
    let mut bytes = Vec::new();
    GzDecoder::new(file).take(MAX_HGT + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MAX_HGT { Err("it packs too much".to_owned()) } else { Ok(bytes) }
}

/// South-west corner by a name such as `n40w004.hgt`.
fn corner_of(name: &str) -> Option<(i16, i16)> {
    let bytes = name.as_bytes();
    let number = |range: std::ops::Range<usize>| name.get(range)?.parse::<i16>().ok();
    let lat = number(1..3)?
        * match bytes.first()? {
            b'n' => 1,
            b's' => -1,
            _ => return None,
        };
    let lon = number(4..7)?
        * match bytes.get(3)? {
            b'e' => 1,
            b'w' => -1,
            _ => return None,
        };
    (name.get(7..8) == Some(".") && (-90..90).contains(&lat) && (-180..180).contains(&lon)).then_some((lat, lon))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Folder;
    use std::io::Write;

    /// Heights that grow by 1 a row to the south and 0.. a column to the east, so that every place is known.
    fn hgt(void_at: Option<usize>) -> Vec<u8> {
        let height = |i: usize| if Some(i) == void_at { i16::MIN } else { (i / 1201 + 2 * (i % 1201)) as i16 };
        (0..1201 * 1201).flat_map(|i| height(i).to_be_bytes()).collect()
    }

    #[test]
    fn srtm_tiles_are_read_plain_and_packed() {
        let folder = Folder::new();
        std::fs::write(folder.path().join("N40W004.hgt"), hgt(Some(600 * 1201 + 600))).expect("written");
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&hgt(None)).expect("packed");
        std::fs::write(folder.path().join("S01E179.hgt.gz"), packed.finish().expect("packed")).expect("written");
        std::fs::write(folder.path().join("N41W004.hgt"), b"short").expect("written");
        let dem = Dem::open(folder.path(), false).expect("heights");
        let height = |lat: f64, lon: f64| dem.height(lat, lon).expect("read").map(|height| height.alt_m);
        let step = 1.0 / 1200.0;
        assert_eq!(height(41.0, -4.0), Some(0.0));
        assert_eq!(height(40.0, -3.0), Some(1200.0 + 2400.0));
        let between = height(41.0 - 2.5 * step, -4.0 + 3.25 * step).expect("known");
        assert!((between - 9.0).abs() < 1e-6, "{between}");
        assert_eq!(height(40.5, -3.5), None, "void");
        assert_eq!(height(40.5 + step, -3.5), Some(599.0 + 1200.0), "beside it");
        assert_eq!(height(40.5 + step / 2.0, -3.5), None, "half of it is void");
        assert_eq!(height(39.5, -3.5), None, "no file");
        assert_eq!(height(-0.5, 179.5).map(f64::round), Some(600.0 + 1200.0));
        assert!((dem.height(41.0, -4.0).expect("read").expect("known").resolution_m - 92.8).abs() < 0.1);
        assert_eq!(dem.bounds().expect("known").east_deg, 180.0);
    }

    #[test]
    fn what_cannot_be_land_is_void() {
        let folder = Folder::new();
        let path = folder.path().join("N40W004.hgt");
        for void in [-9_999, -32_767, 9_999, i16::MAX] {
            let heights = (0..601 * 601).flat_map(|i| if i == 300 * 601 + 300 { void } else { 500_i16 }.to_be_bytes());
            std::fs::write(&path, heights.collect::<Vec<u8>>()).expect("written");
            let dem = Dem::open(&path, false).expect("heights");
            let height = |lat: f64| dem.height(lat, -3.5).expect("read").map(|height| height.alt_m);
            assert_eq!((height(40.5), height(40.5 + 0.5 / 600.0), height(40.6)), (None, None, Some(500.0)), "{void}");
        }
    }

    #[test]
    fn a_damaged_file_takes_no_heights_of_others_away() {
        let folder = Folder::new();
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&hgt(None)).expect("packed");
        let mut damaged = packed.finish().expect("packed");
        let middle = damaged.len() / 2;
        damaged[middle..middle + 200].fill(0);
        std::fs::write(folder.path().join("N41W004.hgt.gz"), damaged).expect("written");
        std::fs::write(folder.path().join("N40W004.hgt"), hgt(None)).expect("written");
        let dem = Dem::open(folder.path(), false).expect("heights");
        assert!(dem.height(41.5, -3.5).is_err());
        // Both have the parallel between them.
        assert_eq!(dem.height(41.0, -4.0).expect("read").map(|height| height.alt_m), Some(0.0));
    }

    #[test]
    fn a_file_that_was_replaced_is_not_read_by_what_the_old_one_was() {
        let folder = Folder::new();
        let pack = |heights: &[u8]| {
            let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            packed.write_all(heights).expect("packed");
            packed.finish().expect("packed")
        };
        let fine: Vec<u8> = (0..1801 * 1801).flat_map(|i| ((i / 1801) as i16).to_be_bytes()).collect();
        for (name, before, after) in
            [("N40W004.hgt", hgt(None), fine.clone()), ("N40W004.hgt.gz", pack(&hgt(None)), pack(&fine))]
        {
            let path = folder.path().join(name);
            std::fs::write(&path, before).expect("written");
            let dem = Dem::open(&path, false).expect("heights");
            assert_eq!(dem.height(40.0, -4.0).expect("read").map(|height| height.alt_m), Some(1200.0));
            std::fs::write(&path, after).expect("written");
            let refused = dem.height(40.0, -4.0).expect_err("another file").to_string();
            assert!(refused.contains(name) && refused.contains("replaced"), "{refused}");
            let anew = Dem::open(&path, false).expect("heights").height(40.0, -4.0).expect("read");
            assert_eq!(anew.map(|height| height.alt_m), Some(1800.0));
        }
    }

    #[test]
    fn names_say_where_tiles_lie() {
        assert_eq!(corner_of("n40w004.hgt"), Some((40, -4)));
        assert_eq!(corner_of("s01e179.hgt.gz"), Some((-1, 179)));
        for name in ["x40w004.hgt", "n40x004.hgt", "n4w4.hgt", "nñ.hgt", "n99w004.hgt", "n40w004"] {
            assert_eq!(corner_of(name), None, "{name}");
        }
    }
}
