//! GeoTIFF files (OGC 19-008r4) as tiles of their own coordinate reference system, and as heights. Overviews inside the
//! file, as cloud-optimised GeoTIFFs have them, are used.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use flate2::bufread::ZlibDecoder;
use tiff::tags::Tag;

use super::georef::{Measure, TILE_PX, crs_of, is_ellipsoidal, own_grid, transform_of};
use super::image::{Colours, Image, Mask, Piece, convert, image, mask, piece_size};
use super::input::{MAX_PIECE, OpenInput, TiffDecoder, decoder};
use super::{lzw, tags};
use crate::crs::Crs;
use crate::elevation;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{Level, TileGrid, TileId};
use crate::live::{About, TileFile};
use crate::memory::{Deadline, Lease, Shelved, lease};
use crate::raster::{self, Raster};
use crate::stamp::{REPLACED, Stamp};

/// Images in a file that are looked at: the picture, its overviews and their masks.
const MAX_IMAGES: usize = 32;
/// Pixels that are read for one tile at most.
const MAX_READ_PX: u64 = 32 * 1024 * 1024;
/// How long one tile may take to make.
const TILE_TIME: Duration = Duration::from_secs(10);

/// A GeoTIFF that is open for reading.
pub struct GeoTiff {
    name: String,
    /// The file of this machine that it is, and what that was when it was opened.
    file: Option<(PathBuf, Option<Stamp>)>,
    input: OpenInput,
    crs: Crs,
    /// Top left corner of the top left pixel.
    origin: [f64; 2],
    /// Of a pixel, both positive.
    pixel: [f64; 2],
    /// The picture first, then overviews, fine to coarse.
    images: Vec<Image>,
    no_data: Option<f64>,
    /// Whether it has a mask that is not read.
    is_mask_unread: bool,
    /// Whether it says that its numbers are heights above an ellipsoid.
    is_ellipsoidal: bool,
    /// How heights come of its numbers, or why they do not.
    measure: std::result::Result<Measure, String>,
    grid: TileGrid,
    about: About,
    decoders: Mutex<HashMap<usize, TiffDecoder>>,
    unpacked: Shelved,
}

impl std::fmt::Debug for GeoTiff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GeoTiff").field("name", &self.name).field("crs", &self.crs).finish_non_exhaustive()
    }
}

impl GeoTiff {
    /// Opens a file.
    ///
    /// # Errors
    /// The fault and its remedy, as a sentence.
    pub fn open(path: &Path) -> std::result::Result<Self, String> {
        let (name, path) = (path.display().to_string(), path.to_owned());
        let opened = (path.clone(), Stamp::at(&path));
        let mut file = Self::read(name, Box::new(move || Ok(Box::new(File::open(&path)?))))?;
        file.file = Some(opened);
        Ok(file)
    }

    /// Reads what is needed of a TIFF before its pixels.
    ///
    /// # Errors
    /// The fault and its remedy, as a sentence.
    pub(crate) fn read(name: String, input: OpenInput) -> std::result::Result<Self, String> {
        // Before the crate makes room for what the lists announce.
        tags::check(&mut BufReader::new(input().map_err(|error| error.to_string())?), MAX_IMAGES)?;
        let mut first = decoder(&input, 0)?;
        let crs = crs_of(&mut first)?;
        let is_ellipsoidal = is_ellipsoidal(&mut first);
        let measure = Measure::of(&mut first);
        let (origin, pixel) = transform_of(&mut first)?;
        let no_data = first.get_tag_ascii_string(Tag::GdalNodata).ok();
        let no_data = no_data.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        let mut mark = [0; 2];
        input().and_then(|mut input| input.read_exact(&mut mark)).map_err(|error| error.to_string())?;
        // "MM" as opposed to "II".
        let is_big_endian = mark == *b"MM";
        let mut images = vec![image(&mut first, 0, is_big_endian)?];
        let (mut masks, mut is_mask_unread) = (Vec::new(), false);
        for index in 1..MAX_IMAGES {
            if !first.more_images() || first.next_image().is_err() {
                break;
            }
            // Bit 0: a smaller copy; bit 2: a mask (TIFF 6.0, NewSubfileType).
            let subfile: u32 = first.find_tag_unsigned(Tag::NewSubfileType).ok().flatten().unwrap_or(0);
            if subfile & 0b100 != 0 {
                let mask = mask(&mut first, index);
                is_mask_unread |= mask.is_none();
                masks.extend(mask);
            } else if subfile & 0b101 == 0b001
                && let Ok(overview) = image(&mut first, index, is_big_endian)
            {
                images.push(overview);
            }
        }
        images.sort_by_key(|image| std::cmp::Reverse(image.width));
        for image in &mut images {
            image.mask = masks.iter().find(|mask| (mask.width, mask.height) == (image.width, image.height)).cloned();
        }
        let size = [images[0].width, images[0].height];
        let far = [origin[0] + f64::from(size[0]) * pixel[0], origin[1] - f64::from(size[1]) * pixel[1]];
        let extent = [origin[0], far[1], far[0], origin[1]];
        let bounds =
            Bounds::around(crs, extent).ok_or("it lies off the Earth: its coordinates and its system do not fit")?;
        let grid = own_grid(crs, origin, pixel, size, extent);
        let about = About { bounds: Some(bounds), is_overlay: true, ..About::default() };
        drop(first);
        let (decoders, unpacked) = (Mutex::default(), Shelved::unpacked());
        Ok(Self {
            name,
            file: None,
            input,
            crs,
            origin,
            pixel,
            images,
            no_data,
            is_mask_unread,
            is_ellipsoidal,
            measure,
            grid,
            about,
            decoders,
            unpacked,
        })
    }

    /// Whether it holds heights, or one band that can be taken for such.
    pub fn has_numbers(&self) -> bool {
        matches!(self.images[0].colours, Colours::Numbers | Colours::Bands(1))
    }

    /// Whether it holds numbers that are not colours.
    pub fn is_heights(&self) -> bool {
        matches!(self.images[0].colours, Colours::Numbers)
    }

    /// Why its numbers cannot be used as heights, when they cannot.
    pub fn height_fault(&self) -> Option<String> {
        let faults = [
            (!self.has_numbers(), "it holds colours, not heights"),
            (
                self.is_mask_unread,
                "it has a mask that is not packed by Deflate, so it is not known where it has no heights; make it with gdal_translate \
                 -of COG",
            ),
            (
                self.is_ellipsoidal,
                "its heights are above an ellipsoid, not above mean sea level, up to 100 m away; convert it with gdalwarp -s_srs \
                 EPSG:4979 -t_srs EPSG:4326+5773",
            ),
        ];
        let fault = faults.into_iter().find_map(|(is_so, fault)| is_so.then(|| fault.to_owned()));
        fault.or_else(|| self.measure.as_ref().err().cloned())
    }

    /// Where it lies.
    pub fn bounds(&self) -> Option<Bounds> {
        self.about.bounds
    }

    /// Metres of a pixel, about.
    pub fn resolution_m(&self) -> f64 {
        self.pixel[1] * self.crs.metres_per_unit()
    }

    fn broken(&self, reason: impl Into<String>) -> MapError {
        MapError::file(self.name.clone(), reason)
    }

    /// That the file is still the one whose pieces were found when it was opened.
    fn check_same(&self) -> Result<()> {
        let is_same = self.file.as_ref().is_none_or(|(path, opened)| Stamp::at(path) == *opened);
        if is_same { Ok(()) } else { Err(self.broken(REPLACED)) }
    }

    /// The ground's height at a place, between the four pixels around it; `None` where one of them is void, or off the
    /// file. Heights below sea level are land, or else the sea floor, which counts as 0 m
    /// ([`crate::elevation::surface_m`]). Blocks.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when the file is broken.
    pub fn height_m(&self, lat_deg: f64, lon_deg: f64, has_land_below_sea: bool) -> Result<Option<f64>> {
        let [x, y] = self.crs.project(lat_deg, lon_deg);
        // Pixels stand for their middles.
        let column = (x - self.origin[0]) / self.pixel[0] - 0.5;
        let row = (self.origin[1] - y) / self.pixel[1] - 0.5;
        let image = &self.images[0];
        let (width, height) = (f64::from(image.width), f64::from(image.height));
        // Half a pixel beyond the outermost middles is still the file's own ground.
        if !(-0.5..=width - 0.5).contains(&column) || !(-0.5..=height - 0.5).contains(&row) {
            return Ok(None);
        }
        self.check_same()?;
        let (column, row) = (column.clamp(0.0, width - 1.0), row.clamp(0.0, height - 1.0));
        let mut sum = 0.0;
        for (weight, [at_column, at_row]) in elevation::corners(column, row) {
            if weight == 0.0 {
                continue;
            }
            match self.number(image, at_column, at_row)? {
                Some(value) => sum += weight * elevation::surface_m(value, has_land_below_sea),
                None => return Ok(None),
            }
        }
        Ok(Some(sum))
    }

    fn number(&self, image: &Image, column: u32, row: u32) -> Result<Option<f64>> {
        if let Some(mask) = &image.mask
            && !self.is_seen(mask, column, row, &mut None)?
        {
            return Ok(None);
        }
        let (piece, [x, y]) = self.piece_of(image, column, row);
        let value = match &*self.piece(image, piece)? {
            Piece::Numbers { width, values } => values.get(y as usize * *width as usize + x as usize).copied(),
            Piece::Empty => None,
            Piece::Colours(_) | Piece::Mask(_) => return Err(self.broken("it holds colours, not heights")),
        };
        // By what they are kept as: a tag of −9999.9 names another number than the nearest of 32 bits.
        let value = value.filter(|value| self.no_data.is_none_or(|void| void as f32 != *value)).map(f64::from);
        let Measure { scale, offset_m } = self.measure.as_ref().map_err(|fault| self.broken(fault))?;
        let value = value.filter(|value| !elevation::is_usual_void(*value));
        Ok(value.and_then(|value| elevation::land_m(value * scale + offset_m)))
    }

    /// The coarsest image that is still fine enough for a level, and its pixels for one of the finest.
    fn image_for(&self, level: &Level) -> Result<(&Image, [f64; 2])> {
        let [width, height] = [self.images[0].width, self.images[0].height].map(f64::from);
        let scale = |image: &Image| width / f64::from(image.width);
        let wanted = level.resolution / self.pixel[0];
        let image = self.images.iter().rev().find(|image| scale(image) <= wanted * 1.01).unwrap_or(&self.images[0]);
        let pixels = f64::from(TILE_PX) * wanted / scale(image);
        if pixels * pixels > MAX_READ_PX as f64 {
            let reason =
                "it has no overviews, so it cannot be shown from this far; make some with gdaladdo, or use -of COG";
            return Err(self.broken(reason));
        }
        Ok((image, [f64::from(image.width) / width, f64::from(image.height) / height]))
    }

    /// Bytes of the file that a tile is made of, but for the pieces that are unpacked already.
    ///
    /// # Errors
    /// As for the tile.
    pub(crate) fn needs(&self, tile: TileId) -> Result<Vec<Range<u64>>> {
        let Some([left, bottom, right, top]) = self.grid.tile_extent(tile) else { return Ok(Vec::new()) };
        let (image, ratio) = self.image_for(&self.grid.levels[usize::from(tile.level)])?;
        let span = |from: f64, to: f64, size: u32, piece: u32| {
            let last = f64::from(size) - 1.0;
            let is_off = to < 0.0 || from > last;
            (!is_off).then(|| from.clamp(0.0, last) as u32 / piece..=to.clamp(0.0, last) as u32 / piece)
        };
        let column = |x: f64| (x - self.origin[0]) / self.pixel[0] * ratio[0];
        let row = |y: f64| (self.origin[1] - y) / self.pixel[1] * ratio[1];
        let columns = span(column(left), column(right), image.width, image.piece.0);
        let rows = span(row(top), row(bottom), image.height, image.piece.1);
        let (Some(columns), Some(rows)) = (columns, rows) else { return Ok(Vec::new()) };
        let of_image = (image.index, image.width, image.piece, &image.places, columns, rows);
        let of_mask = image.mask.as_ref().and_then(|mask| {
            let columns = span(column(left), column(right), mask.width, mask.piece.0)?;
            let rows = span(row(top), row(bottom), mask.height, mask.piece.1)?;
            Some((mask.index, mask.width, mask.piece, &mask.places, columns, rows))
        });
        let mut ranges = Vec::new();
        for (index, width, piece, places, columns, rows) in std::iter::once(of_image).chain(of_mask) {
            let across = width.div_ceil(piece.0);
            for number in rows.flat_map(|row| columns.clone().map(move |column| row * across + column)) {
                let is_known = self.unpacked.get::<Piece>(index as u64, number.into()).is_some();
                if let Some((at, bytes)) = places.get(number as usize).filter(|(_, bytes)| !is_known && *bytes > 0) {
                    ranges.push(*at..at.saturating_add(*bytes));
                }
            }
        }
        Ok(ranges)
    }

    fn piece_of(&self, image: &Image, column: u32, row: u32) -> (u32, [u32; 2]) {
        let across = image.width.div_ceil(image.piece.0);
        let piece = row / image.piece.1 * across + column / image.piece.0;
        (piece, [column % image.piece.0, row % image.piece.1])
    }

    fn piece(&self, image: &Image, piece: u32) -> Result<Arc<Piece>> {
        let key = (image.index as u64, u64::from(piece));
        if let Some(known) = self.unpacked.get(key.0, key.1) {
            return Ok(known);
        }
        let (at, bytes) = image.places.get(piece as usize).copied().unwrap_or((0, 0));
        if bytes == 0 {
            return Ok(Arc::new(Piece::Empty));
        }
        let broken = |reason: String| self.broken(reason);
        let (width, height) = piece_size(image, piece);
        let mut decoders = self.decoders.lock().unwrap_or_else(PoisonError::into_inner);
        // Another may have unpacked it meanwhile.
        if let Some(known) = self.unpacked.get(key.0, key.1) {
            return Ok(known);
        }
        let decoder = match decoders.entry(image.index) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(free) => free.insert(decoder(&self.input, image.index).map_err(broken)?),
        };
        let _lease = self.lease_for(image, at, bytes).map_err(broken)?;
        let decoded = match image.lzw {
            Some(layout) => {
                // The last strip has the rows that are left; tiles are whole.
                let layout = lzw::Layout { height: if layout.is_tiled { layout.height } else { height }, ..layout };
                let packed = self.bytes(at, bytes).map_err(broken)?;
                lzw::unpack(&packed, layout, width, height).map_err(broken)?
            }
            None => decoder.read_chunk(piece).map_err(|error| self.broken(error.to_string()))?,
        };
        let read = Arc::new(convert(&image.colours, decoded, width, height).map_err(broken)?);
        self.unpacked.put(key.0, key.1, &read, read.bytes());
        Ok(read)
    }

    /// Memory for decoding a piece: as it is packed, unpacked (twice, where rows are cut), and as colours or numbers.
    fn lease_for(&self, image: &Image, at: u64, packed: u64) -> std::result::Result<Lease, String> {
        if packed > MAX_PIECE as u64 {
            return Err(format!("a piece of it has {packed} bytes; at most {MAX_PIECE} are read at once"));
        }
        let pixels = u64::from(image.piece.0) * u64::from(image.piece_rows());
        let own = if image.is_jpeg {
            // A JPEG file has a size of its own, which its decoder trusts.
            let (bytes, most) = (self.bytes(at, packed)?, [image.piece.0, image.piece_rows()]);
            raster::jpeg_cost(&bytes, |[width, height]| width <= most[0] && height <= most[1].next_multiple_of(16))?
        } else {
            0
        };
        let unpacked = pixels.checked_mul(2 * image.depth + 4);
        lease(unpacked.and_then(|unpacked| unpacked.checked_add(packed)?.checked_add(own)))
    }

    /// Bytes of the file as they are.
    fn bytes(&self, at: u64, count: u64) -> std::result::Result<Vec<u8>, String> {
        let mut read = Vec::new();
        let mut input = (self.input)().map_err(|error| error.to_string())?;
        let taken = input.seek(io::SeekFrom::Start(at)).and_then(|_| input.take(count).read_to_end(&mut read));
        taken.map_err(|error| error.to_string())?;
        Ok(read)
    }

    /// Whether a pixel is to be seen.
    fn is_seen(&self, mask: &Mask, column: u32, row: u32, last: &mut Option<(u32, Arc<Piece>)>) -> Result<bool> {
        let across = mask.width.div_ceil(mask.piece.0);
        let number = row / mask.piece.1 * across + column / mask.piece.0;
        let piece = match last {
            Some((known, piece)) if *known == number => piece.clone(),
            _ => {
                let piece = self.mask_piece(mask, number)?;
                *last = Some((number, piece.clone()));
                piece
            }
        };
        let (x, y) = (column % mask.piece.0, row % mask.piece.1);
        let stride = mask.piece.0.div_ceil(8);
        Ok(match &*piece {
            Piece::Mask(bits) => {
                let at = u64::from(y) * u64::from(stride) + u64::from(x / 8);
                bits.get(at as usize).is_some_and(|byte| byte >> (7 - x % 8) & 1 == 1)
            }
            _ => true,
        })
    }

    fn mask_piece(&self, mask: &Mask, number: u32) -> Result<Arc<Piece>> {
        let (first, second) = (mask.index as u64, u64::from(number));
        if let Some(known) = self.unpacked.get(first, second) {
            return Ok(known);
        }
        let (at, bytes) = mask.places.get(number as usize).copied().unwrap_or((0, 0));
        let whole = u64::from(mask.piece.0.div_ceil(8)) * u64::from(mask.piece.1);
        let mut bits = Vec::new();
        // A piece that was never written hides all.
        if bytes > 0 {
            let broken = |reason: String| self.broken(format!("its mask: {reason}"));
            if bytes > MAX_PIECE as u64 || whole > MAX_PIECE as u64 {
                return Err(broken(format!("a piece of it has more than {MAX_PIECE} bytes")));
            }
            let _lease = lease(Some(bytes + 2 * whole)).map_err(broken)?;
            let packed = self.bytes(at, bytes).map_err(broken)?;
            let unpacked = ZlibDecoder::new(&*packed).take(whole).read_to_end(&mut bits);
            unpacked.map_err(|error| broken(error.to_string()))?;
        }
        let piece = Arc::new(Piece::Mask(bits));
        self.unpacked.put(first, second, &piece, piece.bytes());
        Ok(piece)
    }

    fn colour(&self, image: &Image, column: u32, row: u32, last: &mut Option<(u32, Arc<Piece>)>) -> Result<[u8; 4]> {
        let (number, [x, y]) = self.piece_of(image, column, row);
        let piece = match last {
            Some((known, piece)) if *known == number => piece.clone(),
            _ => {
                let piece = self.piece(image, number)?;
                *last = Some((number, piece.clone()));
                piece
            }
        };
        match &*piece {
            Piece::Colours(raster) if x < raster.width && y < raster.height => {
                let pixel = raster.pixel(x, y);
                let is_void = self.no_data.is_some_and(|void| pixel[..3].iter().all(|band| f64::from(*band) == void));
                Ok(if is_void { [0; 4] } else { pixel })
            }
            Piece::Numbers { width, values } if x < *width => {
                // One band of bytes is grey; heights are not drawn.
                let value = values.get(y as usize * *width as usize + x as usize).copied().unwrap_or(0.0);
                let is_void = value.is_nan() || self.no_data.is_some_and(|void| void == f64::from(value));
                let grey = value.clamp(0.0, 255.0) as u8;
                Ok(if is_void { [0; 4] } else { [grey, grey, grey, 255] })
            }
            _ => Ok([0; 4]),
        }
    }
}

impl TileFile for GeoTiff {
    fn grid(&self) -> &TileGrid {
        &self.grid
    }

    fn about(&self) -> About {
        self.about.clone()
    }

    fn tile(&self, tile: TileId) -> Result<Option<Bytes>> {
        if matches!(self.images[0].colours, Colours::Numbers) {
            return Err(self.broken("it holds numbers, not colours; use it as heights, kind dem"));
        }
        self.check_same()?;
        let Some([left, _, _, top]) = self.grid.tile_extent(tile) else { return Ok(None) };
        let level = &self.grid.levels[usize::from(tile.level)];
        let (image, ratio) = self.image_for(level)?;
        let mut raster = Raster::filled(TILE_PX, TILE_PX, [0; 4]);
        let (mut last, mut last_mask) = (None, None);
        let deadline = Deadline::after(TILE_TIME);
        for row in 0..TILE_PX {
            if deadline.is_over() {
                let seconds = TILE_TIME.as_secs();
                return Err(self.broken(format!("a tile of it takes more than {seconds} s to make; use -of COG")));
            }
            let y = top - (f64::from(row) + 0.5) * level.resolution;
            let from_row = ((self.origin[1] - y) / self.pixel[1] * ratio[1]).floor();
            if from_row < 0.0 || from_row >= f64::from(image.height) {
                continue;
            }
            for column in 0..TILE_PX {
                let x = left + (f64::from(column) + 0.5) * level.resolution;
                let from_column = ((x - self.origin[0]) / self.pixel[0] * ratio[0]).floor();
                if from_column < 0.0 || from_column >= f64::from(image.width) {
                    continue;
                }
                let (x, y) = (from_column as u32, from_row as u32);
                if let Some(mask) = &image.mask
                    && !self.is_seen(mask, x, y, &mut last_mask)?
                {
                    continue;
                }
                raster.set(column, row, self.colour(image, x, y, &mut last)?);
            }
        }
        Ok((!raster.is_clear()).then(|| raster.to_png().into()))
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
