//! Pictures whose four corners are known, drawn as Web Mercator tiles by the projective map that takes corners to
//! corners (P. Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989, section 2.2.3).

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;

use crate::crs::{Crs, MERCATOR_HALF_M};
use crate::error::{MapError, Result};
use crate::geo::{Bounds, Corner};
use crate::grid::{TileGrid, TileId};
use crate::kind::{Kind, Opened, Opening, check_path};
use crate::live::{About, TileFile};
use crate::memory::{Lease, Shelved};
use crate::raster::Raster;
use crate::settings::{Role, SourceKind, SourceSettings};
use crate::sniff::{self, Picture};

/// Pixels of a picture at most: 160 MB unpacked.
pub const MAX_PX: u64 = 40_000_000;
/// Bytes of its file at most.
const MAX_BYTES: u64 = 64 * 1024 * 1024;
const TILE_PX: u32 = 256;

/// How sources of this kind are opened and read.
pub(crate) struct Driver;

impl Kind for Driver {
    fn fields(&self) -> &'static [&'static str] {
        &["path", "corners"]
    }

    fn roles(&self) -> &'static [Role] {
        &[Role::Base, Role::Overlay]
    }

    fn faults(&self, settings: &SourceSettings, faults: &mut Vec<String>) {
        check_path(settings, "", faults);
        let is_place = |at: &Corner| at.lat_deg.abs() <= 85.0 && at.lon_deg.abs() <= 180.0;
        if settings.corners.len() != 4 || !settings.corners.iter().all(is_place) {
            faults.push(
                "corners: four are needed, top left, top right, bottom right and bottom left, within ±85° and ±180°"
                    .to_owned(),
            );
        }
    }

    fn open(&self, opening: &Opening<'_>) -> Opened {
        opening.zoomed(Overlay::open(&opening.path(), &opening.settings.corners))
    }

    fn file_ends(&self) -> &'static [&'static str] {
        &[".png", ".jpg", ".jpeg", ".webp"]
    }

    fn look(&self, path: &Path) -> std::result::Result<(SourceKind, About), String> {
        Raster::read(&read_file(path)?, MAX_PX)?;
        Ok((SourceKind::Image, About { is_overlay: true, ..About::default() }))
    }

    fn picture(&self, path: &Path) -> Option<std::result::Result<Vec<u8>, String>> {
        Some(read_file(path))
    }
}

/// A picture with its corners.
pub struct Overlay {
    path: PathBuf,
    unpacked: Shelved,
    /// Held while it is unpacked: one does, the others wait.
    unpacking: Mutex<()>,
    /// From Web Mercator to the picture, 0 to 1 in both directions.
    unit_from_mercator: [[f64; 3]; 3],
    grid: TileGrid,
    about: About,
}

impl std::fmt::Debug for Overlay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Overlay").field("path", &self.path).finish_non_exhaustive()
    }
}

/// The bytes of a picture's file.
///
/// # Errors
/// The fault, as a sentence.
pub fn read_file(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let about = std::fs::metadata(path).map_err(|error| error.to_string())?;
    if about.len() > MAX_BYTES {
        return Err(format!("the picture has more than {MAX_BYTES} bytes"));
    }
    std::fs::read(path).map_err(|error| error.to_string())
}

/// Width and height of a picture by its header, where it is one that can be read.
fn size_of(path: &Path) -> std::result::Result<(u32, u32), String> {
    let bytes = read_file(path)?;
    let kind = Picture::of(&bytes).ok_or_else(|| format!("no picture but {}", sniff::describe(&bytes)))?;
    let (width, height) = sniff::size_px(kind, &bytes).ok_or("the picture's header is cut short")?;
    if u64::from(width) * u64::from(height) > MAX_PX || width == 0 || height == 0 {
        return Err(format!("the picture has {width} × {height} pixels; at most {MAX_PX} in all are taken"));
    }
    Ok((width, height))
}

impl Overlay {
    /// Opens a picture. Corners: top left, top right, bottom right, bottom left of the picture.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub fn open(path: &Path, corners: &[Corner]) -> std::result::Result<Self, String> {
        let [a, b, c, d] = *corners else { return Err("four corners are needed".to_owned()) };
        // Over the date line longitudes continue beyond ±180°.
        let lon = |corner: Corner| a.lon_deg + vencejo_flight::geodesy::wrap_180_deg(corner.lon_deg - a.lon_deg);
        let quad = [a, b, c, d].map(|corner| Crs::WebMercator.project(corner.lat_deg, lon(corner)));
        let mercator_from_unit = from_unit_square(quad).ok_or("the corners lie on a line or cross over")?;
        let unit_from_mercator = inverse(mercator_from_unit).ok_or("the corners lie on a line or cross over")?;
        // Its pixels are unpacked when they are drawn; where they lie depends on their number alone.
        let (width, height) = size_of(path)?;
        let side = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let finest = (side(quad[0], quad[1]) / f64::from(width)).min(side(quad[0], quad[3]) / f64::from(height));
        let zoom = (2.0 * MERCATOR_HALF_M / f64::from(TILE_PX) / finest.max(1e-3)).log2().ceil().clamp(0.0, 24.0);
        let fold = |axis: usize, pick: fn(f64, f64) -> f64| quad.iter().map(|p| p[axis]).fold(quad[0][axis], pick);
        let extent = [fold(0, f64::min), fold(1, f64::min), fold(0, f64::max), fold(1, f64::max)];
        let lats = [a, b, c, d].map(|corner| corner.lat_deg);
        let wrap = vencejo_flight::geodesy::wrap_180_deg;
        let lons = [a, b, c, d].map(lon);
        let bounds = Bounds {
            west_deg: wrap(lons.into_iter().fold(f64::INFINITY, f64::min)),
            south_deg: lats.into_iter().fold(f64::INFINITY, f64::min),
            east_deg: wrap(lons.into_iter().fold(f64::NEG_INFINITY, f64::max)),
            north_deg: lats.into_iter().fold(f64::NEG_INFINITY, f64::max),
        };
        let mut grid = TileGrid::standard(Crs::WebMercator, TILE_PX, 0, zoom as u8);
        grid.extent = Some(extent);
        let about = About { bounds: Some(bounds), is_overlay: true, ..About::default() };
        Ok(Self {
            path: path.to_owned(),
            unpacked: Shelved::unpacked(),
            unpacking: Mutex::default(),
            unit_from_mercator,
            grid,
            about,
        })
    }

    /// The picture, and the memory that it holds while the shelf has no room for it.
    fn picture(&self) -> Result<(Option<Lease>, Arc<Raster>)> {
        let _turn = self.unpacking.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(picture) = self.unpacked.get(0, 0) {
            return Ok((None, picture));
        }
        let broken = |reason| MapError::file(self.path.display().to_string(), reason);
        let read = Raster::read_leased(&read_file(&self.path).map_err(broken)?, MAX_PX).map_err(broken)?;
        let (picture, lease) = (Arc::new(read.0), read.1);
        let is_kept = self.unpacked.put(0, 0, &picture, picture.rgba.len());
        Ok(((!is_kept).then_some(lease), picture))
    }
}

impl TileFile for Overlay {
    fn grid(&self) -> &TileGrid {
        &self.grid
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn tile(&self, tile: TileId) -> Result<Option<Bytes>> {
        let Some([left, _, _, top]) = self.grid.tile_extent(tile) else { return Ok(None) };
        // The lease goes last.
        let (_lease, picture) = self.picture()?;
        let resolution = self.grid.levels[usize::from(tile.level)].resolution;
        let world = 2.0 * MERCATOR_HALF_M;
        // The picture may lie beyond the date line, on either side of the tile's own turn of the world.
        let extent = self.grid.extent.unwrap_or_default();
        let turn = [0.0, world, -world]
            .into_iter()
            .find(|turn| left + turn < extent[2] && left + turn + f64::from(TILE_PX) * resolution > extent[0]);
        let Some(turn) = turn else { return Ok(None) };
        let mut raster = Raster::filled(TILE_PX, TILE_PX, [0; 4]);
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        for row in 0..TILE_PX {
            let y = top - (f64::from(row) + 0.5) * resolution;
            for column in 0..TILE_PX {
                let x = left + turn + (f64::from(column) + 0.5) * resolution;
                let Some([u, v]) = apply(&self.unit_from_mercator, [x, y]) else { continue };
                if (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v) {
                    raster.set(column, row, between(&picture, u * width - 0.5, v * height - 0.5));
                }
            }
        }
        Ok((!raster.is_clear()).then(|| raster.to_png().into()))
    }
}

/// The colour between four pixels, by their weights and opacities.
fn between(picture: &Raster, x: f64, y: f64) -> [u8; 4] {
    let (x, y) = (x.clamp(0.0, f64::from(picture.width - 1)), y.clamp(0.0, f64::from(picture.height - 1)));
    let mut sum = [0.0; 4];
    for (weight, [column, row]) in crate::elevation::corners(x, y) {
        if weight > 0.0 {
            let pixel = picture.pixel(column, row);
            let alpha = f64::from(pixel[3]) * weight;
            for (total, band) in sum.iter_mut().zip(&pixel[..3]) {
                *total += f64::from(*band) * alpha;
            }
            sum[3] += alpha;
        }
    }
    if sum[3] <= 0.0 {
        return [0; 4];
    }
    let colour = |band: f64| (band / sum[3]).round().clamp(0.0, 255.0) as u8;
    [colour(sum[0]), colour(sum[1]), colour(sum[2]), sum[3].round().clamp(0.0, 255.0) as u8]
}

/// The projective map of the unit square to four points: (0,0), (1,0), (1,1), (0,1) in this order.
fn from_unit_square([p0, p1, p2, p3]: [[f64; 2]; 4]) -> Option<[[f64; 3]; 3]> {
    let d1 = [p1[0] - p2[0], p1[1] - p2[1]];
    let d2 = [p3[0] - p2[0], p3[1] - p2[1]];
    let sum = [p0[0] - p1[0] + p2[0] - p3[0], p0[1] - p1[1] + p2[1] - p3[1]];
    let determinant = d1[0] * d2[1] - d2[0] * d1[1];
    let size = d1[0].hypot(d1[1]) * d2[0].hypot(d2[1]);
    if determinant.abs() <= size * 1e-9 {
        return None;
    }
    let g = (sum[0] * d2[1] - d2[0] * sum[1]) / determinant;
    let h = (d1[0] * sum[1] - sum[0] * d1[1]) / determinant;
    // Beyond these the horizon runs through the picture.
    if g <= -1.0 || h <= -1.0 || g + h <= -1.0 {
        return None;
    }
    Some([
        [p1[0] - p0[0] + g * p1[0], p3[0] - p0[0] + h * p3[0], p0[0]],
        [p1[1] - p0[1] + g * p1[1], p3[1] - p0[1] + h * p3[1], p0[1]],
        [g, h, 1.0],
    ])
}

fn inverse(m: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let minor = |r: [usize; 2], c: [usize; 2]| m[r[0]][c[0]] * m[r[1]][c[1]] - m[r[0]][c[1]] * m[r[1]][c[0]];
    let adjugate = [
        [minor([1, 2], [1, 2]), -minor([0, 2], [1, 2]), minor([0, 1], [1, 2])],
        [-minor([1, 2], [0, 2]), minor([0, 2], [0, 2]), -minor([0, 1], [0, 2])],
        [minor([1, 2], [0, 1]), -minor([0, 2], [0, 1]), minor([0, 1], [0, 1])],
    ];
    let determinant = (0..3).map(|i| m[0][i] * adjugate[i][0]).sum::<f64>();
    (determinant.is_finite() && determinant != 0.0).then(|| adjugate.map(|row| row.map(|number| number / determinant)))
}

fn apply(m: &[[f64; 3]; 3], [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let [u, v, w] = m.map(|row| row[0] * x + row[1] * y + row[2]);
    (w > 0.0).then(|| [u / w, v / w])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Folder;

    const fn at(lat_deg: f64, lon_deg: f64) -> Corner {
        Corner { lat_deg, lon_deg }
    }

    fn overlay(folder: &Folder, corners: &[Corner]) -> std::result::Result<Overlay, String> {
        let path = folder.path().join("a.png");
        let mut picture = Raster::filled(200, 100, [10, 20, 30, 255]);
        for (x, y) in [(0, 0), (199, 0), (199, 99), (0, 99)] {
            picture.set(x, y, [255, 0, 0, 255]);
        }
        picture.set(100, 50, [0, 255, 0, 255]);
        std::fs::write(&path, picture.to_png()).expect("written");
        Overlay::open(&path, corners)
    }

    /// The colour that is drawn at a place on the finest level.
    fn drawn(overlay: &Overlay, lat: f64, lon: f64) -> [u8; 4] {
        let grid = overlay.grid();
        let level = &grid.levels[usize::from(grid.max_level)];
        let [x, y] = grid.position(level, Crs::WebMercator.project(lat, lon));
        let tile = TileId { level: grid.max_level, column: x as u32, row: y as u32 };
        let Some(png) = overlay.tile(tile).expect("read") else { return [0; 4] };
        let px = |position: f64| (position.fract() * 256.0) as u32;
        Raster::read(&png, 1 << 20).expect("a picture").pixel(px(x), px(y))
    }

    #[test]
    fn corners_lie_where_they_were_put_even_turned() {
        let folder = Folder::new();
        // A quarter turn: the picture's top left is in the east.
        let corners = [at(40.01, -3.98), at(40.01 - 0.02, -3.98), at(39.99, -4.0), at(40.01, -4.0)];
        let overlay = overlay(&folder, &corners).expect("an overlay");
        let inside = |corner: Corner| {
            let (lat, lon) = (40.0 + (corner.lat_deg - 40.0) * 0.994, -3.99 + (corner.lon_deg + 3.99) * 0.994);
            drawn(&overlay, lat, lon)
        };
        for corner in corners {
            let colour = inside(corner);
            assert!(colour[0] > 100 && colour[1] < 60 && colour[3] == 255, "{corner:?} {colour:?}");
        }
        assert_eq!(drawn(&overlay, 40.02, -3.99)[3], 0, "outside");
        assert_eq!(drawn(&overlay, 40.0, -3.985), [10, 20, 30, 255]);
        assert_eq!(overlay.about().bounds.expect("known").west_deg, -4.0);
    }

    #[test]
    fn over_the_date_line() {
        let folder = Folder::new();
        let corners = [at(-17.0, 179.99), at(-17.0, -179.99), at(-17.01, -179.99), at(-17.01, 179.99)];
        let overlay = overlay(&folder, &corners).expect("an overlay");
        for lon in [179.995, -179.995] {
            assert_eq!(drawn(&overlay, -17.007, lon), [10, 20, 30, 255], "{lon}");
        }
        let bounds = overlay.about().bounds.expect("known");
        assert!(bounds.west_deg > bounds.east_deg, "{bounds:?}");
    }

    #[test]
    fn corners_that_make_no_picture_are_refused() {
        let folder = Folder::new();
        for corners in [
            [at(0.0, 0.0), at(0.0, 1.0), at(0.0, 2.0), at(0.0, 3.0)],
            [at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(0.0, 0.0)],
            [at(0.0, 0.0); 4],
        ] {
            assert!(overlay(&folder, &corners).is_err(), "{corners:?}");
        }
    }
}
