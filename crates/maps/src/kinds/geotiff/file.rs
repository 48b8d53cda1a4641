//! GeoTIFF files (OGC 19-008r4) as tiles of their own coordinate reference system, and as heights. Overviews inside the file,
//! as cloud-optimised GeoTIFFs have them, are used.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use flate2::bufread::ZlibDecoder;
use tiff::ColorType;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::{lzw, tags};
use crate::crs::Crs;
use crate::elevation::{HIGHEST_LAND_M, LOWEST_LAND_M};
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{Level, MAX_LEVELS, TileGrid, TileId};
use crate::live::{About, TileFile};
use crate::memory::{Deadline, Lease, Shelved, lease};
use crate::raster::{self, Raster, rgba_from};
use crate::stamp::{REPLACED, Stamp};

/// Pixels of the side of the tiles that are made.
const TILE_PX: u32 = 256;
/// Images in a file that are looked at: the picture, its overviews and their masks.
const MAX_IMAGES: usize = 32;
/// So many times as high as wide, or the other way, may a pixel be. Near the poles those of equal angles are stretched.
const MOST_STRETCHED: f64 = 1000.0;
/// Pixels that are read for one tile at most.
const MAX_READ_PX: u64 = 32 * 1024 * 1024;
/// Bytes of one piece at most: packed, unpacked and as colours or numbers.
const MAX_PIECE: usize = 48 * 1024 * 1024;
/// How long one tile may take to make.
const TILE_TIME: Duration = Duration::from_secs(10);

/// What a TIFF is read from.
pub(crate) trait Input: Read + Seek + Send {}

impl<T: Read + Seek + Send> Input for T {}

/// Opens what a TIFF is read from, once for each of its images.
pub(crate) type OpenInput = Box<dyn Fn() -> io::Result<Box<dyn Input>> + Send + Sync>;

type TiffDecoder = Decoder<BufReader<Box<dyn Input>>>;

/// One image of the file: the picture itself or an overview.
#[derive(Debug, Clone)]
struct Image {
    index: usize,
    width: u32,
    height: u32,
    piece: (u32, u32),
    colours: Colours,
    /// Where its pieces are in the file, and how many bytes they have.
    places: Arc<Vec<(u64, u64)>>,
    /// Which of its pixels are to be seen.
    mask: Option<Mask>,
    /// How its pieces are written, where they are packed by LZW.
    lzw: Option<lzw::Layout>,
    /// Whether its pieces are tiles, all of one size, or strips, the last of which is cut.
    is_tiled: bool,
    /// Whether its pieces are JPEG files, which say their own size.
    is_jpeg: bool,
    /// Bytes of a pixel as stored.
    depth: u64,
}

/// An image's mask: one bit a pixel, packed by Deflate, as GDAL writes them (TIFF 6.0, NewSubfileType, bit 2).
#[derive(Debug, Clone)]
struct Mask {
    index: usize,
    width: u32,
    height: u32,
    piece: (u32, u32),
    places: Arc<Vec<(u64, u64)>>,
}

#[derive(Debug, Clone)]
enum Colours {
    /// Bands of 8 or 16 bits.
    Bands(usize),
    /// Brightness and two differences of colour, as JPEG has them.
    YCbCr,
    /// Red, green, blue of each index.
    Palette(Arc<Vec<[u8; 3]>>),
    /// One band of numbers that are no colours: heights.
    Numbers,
}

/// A decoded piece: colours, or numbers.
#[derive(Debug)]
enum Piece {
    /// One that was never written: nothing is there.
    Empty,
    Colours(Raster),
    Numbers {
        width: u32,
        values: Vec<f32>,
    },
    /// Rows of whole bytes, the leftmost pixel in the highest bit.
    Mask(Vec<u8>),
}

impl Piece {
    fn bytes(&self) -> usize {
        match self {
            Self::Empty => 0,
            Self::Colours(raster) => raster.rgba.len(),
            Self::Numbers { values, .. } => values.len() * 4,
            Self::Mask(bits) => bits.len(),
        }
    }
}

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

fn decoder(input: &OpenInput, image: usize) -> std::result::Result<TiffDecoder, String> {
    let file = input().map_err(|error| error.to_string())?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_PIECE;
    limits.intermediate_buffer_size = MAX_PIECE;
    limits.ifd_value_size = MAX_PIECE;
    let mut decoder =
        Decoder::new(BufReader::new(file)).map_err(|error| format!("no TIFF: {error}"))?.with_limits(limits);
    decoder.seek_to_image(image).map_err(|error| format!("no TIFF: {error}"))?;
    Ok(decoder)
}

fn doubles(decoder: &mut TiffDecoder, tag: u16) -> Option<Vec<f64>> {
    decoder.get_tag_f64_vec(Tag::Unknown(tag)).ok()
}

impl GeoTiff {
    /// Opens a file.
    ///
    /// # Errors
    /// What is wrong with it, in words, and what helps.
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
    /// What is wrong with it, in words, and what helps.
    pub(crate) fn read(name: String, input: OpenInput) -> std::result::Result<Self, String> {
        // Before the crate makes room for what the lists announce.
        tags::check(&mut BufReader::new(input().map_err(|error| error.to_string())?), MAX_IMAGES)?;
        let mut first = decoder(&input, 0)?;
        let crs = crs_of(&mut first)?;
        let is_ellipsoidal = is_ellipsoidal(&mut first);
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

    /// Whether it holds numbers that are no colours.
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
        faults.into_iter().find_map(|(is_so, fault)| is_so.then(|| fault.to_owned()))
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

    /// The ground's height at a place, between the four pixels around it; `None` where one of them is void, or off the file. Heights
    /// below sea level are land, or else the sea's floor, whose surface is told ([`crate::elevation::surface_m`]). Blocks.
    ///
    /// # Errors
    /// [`MapError::MapFile`] when the file is broken.
    pub fn height_m(&self, lat_deg: f64, lon_deg: f64, has_land_below_sea: bool) -> Result<Option<f64>> {
        self.check_same()?;
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
        let (column, row) = (column.clamp(0.0, width - 1.0), row.clamp(0.0, height - 1.0));
        let mut sum = 0.0;
        for (weight, [at_column, at_row]) in crate::elevation::corners(column, row) {
            if weight == 0.0 {
                continue;
            }
            match self.number(image, at_column, at_row)? {
                Some(value) => sum += weight * crate::elevation::surface_m(value, has_land_below_sea),
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
        // −32768, −32767 and −9999 are voids, whether or not the file says so: there is no such land.
        Ok(value.filter(|value| (LOWEST_LAND_M..=HIGHEST_LAND_M).contains(value)))
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
            // A JPEG file says its size once more, and its decoder believes it.
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

impl Image {
    /// Rows of its largest piece as stored: a strip may claim more than there are.
    fn piece_rows(&self) -> u32 {
        if self.is_tiled { self.piece.1 } else { self.piece.1.min(self.height) }
    }
}

/// Pixels of a piece: those at the right and bottom edges are cut.
fn piece_size(image: &Image, piece: u32) -> (u32, u32) {
    let across = image.width.div_ceil(image.piece.0);
    let (column, row) = (piece % across, piece / across);
    let cut = |whole: u32, size: u32, number: u32| size.min(whole.saturating_sub(number.saturating_mul(size)));
    (cut(image.width, image.piece.0, column), cut(image.height, image.piece.1, row))
}

/// A grid whose finest level has the file's own pixels and whose coarsest holds it in one tile.
fn own_grid(crs: Crs, origin: [f64; 2], pixel: [f64; 2], size: [u32; 2], extent: [f64; 4]) -> TileGrid {
    let finest = pixel[0].min(pixel[1]);
    let sides = [f64::from(size[0]) * pixel[0] / finest, f64::from(size[1]) * pixel[1] / finest];
    let tiles = (sides[0].max(sides[1]) / f64::from(TILE_PX)).max(1.0);
    let count = (tiles.log2().ceil() as usize + 1).min(MAX_LEVELS);
    let levels = (0..count).map(|level| {
        let coarser = f64::from(1_u32 << (count - 1 - level));
        let tiles = sides.map(|side| (side / coarser / f64::from(TILE_PX)).ceil().max(1.0) as u32);
        Level { resolution: finest * coarser, origin, tile_px: [TILE_PX, TILE_PX], size: Some(tiles) }
    });
    let mut grid = TileGrid::new(crs, levels.collect());
    grid.extent = Some(extent);
    grid
}

fn image(decoder: &mut TiffDecoder, index: usize, is_big_endian: bool) -> std::result::Result<Image, String> {
    let (width, height) = decoder.dimensions().map_err(|error| error.to_string())?;
    let piece = decoder.chunk_dimensions();
    if width == 0 || height == 0 || piece.0 == 0 || piece.1 == 0 {
        return Err("the picture is empty".to_owned());
    }
    let planar: u32 = decoder.find_tag_unsigned(Tag::PlanarConfiguration).ok().flatten().unwrap_or(1);
    let colour = decoder.colortype().map_err(|error| error.to_string())?;
    let float: bool = decoder.get_tag_u16_vec(Tag::SampleFormat).is_ok_and(|formats| formats.first() != Some(&1));
    let colours = match colour {
        ColorType::Palette(_) => {
            let map = decoder.get_tag_u16_vec(Tag::ColorMap).map_err(|error| error.to_string())?;
            let third = map.len() / 3;
            let byte = |value: u16| (value >> 8) as u8;
            Colours::Palette(Arc::new(
                (0..third).map(|i| [byte(map[i]), byte(map[third + i]), byte(map[2 * third + i])]).collect(),
            ))
        }
        ColorType::Gray(8) if !float => Colours::Bands(1),
        ColorType::Gray(_) => Colours::Numbers,
        ColorType::GrayA(_) => Colours::Bands(2),
        ColorType::RGB(_) => Colours::Bands(3),
        ColorType::YCbCr(8) => Colours::YCbCr,
        ColorType::RGBA(_) => Colours::Bands(4),
        ColorType::Multiband { num_samples, .. } => Colours::Bands(num_samples.into()),
        other => return Err(format!("its colours are {other:?}; make it RGB with gdal_translate -expand rgb")),
    };
    if planar == 2 && !matches!(colours, Colours::Numbers | Colours::Bands(1)) {
        return Err("its bands are stored apart; make it with gdal_translate -co INTERLEAVE=PIXEL".to_owned());
    }
    let places = places(decoder)?;
    let lzw = lzw_layout(decoder, piece, is_big_endian);
    let mut number = |tag| decoder.find_tag_unsigned::<u32>(tag).ok().flatten();
    let is_jpeg = number(Tag::Compression) == Some(7);
    let samples = if planar == 2 { 1 } else { u64::from(number(Tag::SamplesPerPixel).unwrap_or(1)) };
    let bits = decoder.get_tag_u16_vec(Tag::BitsPerSample).ok().and_then(|bits| bits.first().copied()).unwrap_or(1);
    let depth = samples.saturating_mul(u64::from(bits.div_ceil(8)));
    let is_tiled = matches!(decoder.get_chunk_type(), ChunkType::Tile);
    let image = Image { index, width, height, piece, colours, places, mask: None, lzw, is_tiled, is_jpeg, depth };
    let pieces = u64::from(width.div_ceil(piece.0)) * u64::from(height.div_ceil(piece.1));
    if pieces > u64::from(u32::MAX) {
        return Err(format!("it has {pieces} pieces, more than can be counted"));
    }
    let pixels = u64::from(piece.0) * u64::from(image.piece_rows());
    // As colours or numbers a pixel has four bytes.
    if pixels.checked_mul(depth.max(4)).is_none_or(|bytes| bytes > MAX_PIECE as u64) {
        return Err(format!(
            "its pieces have {} × {} pixels of {depth} bytes, and at most {} MB are read at once; make it in small tiles with \
             gdal_translate -co TILED=YES, or -of COG",
            piece.0,
            image.piece_rows(),
            MAX_PIECE / 1_000_000
        ));
    }
    Ok(image)
}

/// Where the pieces of an image are, and how many bytes they have.
fn places(decoder: &mut TiffDecoder) -> std::result::Result<Arc<Vec<(u64, u64)>>, String> {
    let tags = match decoder.get_chunk_type() {
        ChunkType::Strip => (Tag::StripOffsets, Tag::StripByteCounts),
        ChunkType::Tile => (Tag::TileOffsets, Tag::TileByteCounts),
    };
    let mut numbers = |tag| decoder.get_tag_u64_vec(tag).map_err(|error| error.to_string());
    Ok(Arc::new(numbers(tags.0)?.into_iter().zip(numbers(tags.1)?).collect()))
}

/// How pieces that are packed by LZW are written; `None` for others, which the `tiff` crate reads.
fn lzw_layout(decoder: &mut TiffDecoder, piece: (u32, u32), is_big_endian: bool) -> Option<lzw::Layout> {
    let mut number = |tag| decoder.find_tag_unsigned::<u32>(tag).ok().flatten();
    if number(Tag::Compression)? != 5 {
        return None;
    }
    let is_apart = number(Tag::PlanarConfiguration) == Some(2);
    let samples = if is_apart { 1 } else { number(Tag::SamplesPerPixel).unwrap_or(1) as usize };
    let predictor = number(Tag::Predictor).unwrap_or(1);
    let all = |decoder: &mut TiffDecoder, tag| decoder.get_tag_u16_vec(tag).ok();
    let bits = all(decoder, Tag::BitsPerSample).unwrap_or_else(|| vec![1]);
    let format = all(decoder, Tag::SampleFormat).and_then(|all| all.first().copied()).unwrap_or(1);
    let bits = bits.first().copied().filter(|first| bits.iter().all(|bits| bits == first))?;
    let is_float = format == 3;
    let is_read = matches!((bits, is_float, predictor), (8 | 16 | 32, false, 1 | 2) | (32, true, 1 | 3));
    let is_tiled = matches!(decoder.get_chunk_type(), ChunkType::Tile);
    is_read.then_some(lzw::Layout {
        width: piece.0,
        height: piece.1,
        samples,
        bytes: usize::from(bits / 8),
        is_float,
        is_signed: format == 2,
        predictor,
        is_big_endian,
        is_tiled,
    })
}

/// A mask, when it is written as GDAL does; others are not used.
fn mask(decoder: &mut TiffDecoder, index: usize) -> Option<Mask> {
    let (width, height) = decoder.dimensions().ok()?;
    let piece = decoder.chunk_dimensions();
    let mut number = |tag| decoder.find_tag_unsigned::<u32>(tag).ok().flatten();
    let (bits, packing) = (number(Tag::BitsPerSample).unwrap_or(1), number(Tag::Compression)?);
    // 8 and 32946: Deflate, new and old.
    let is_read = bits == 1 && matches!(packing, 8 | 32_946) && width > 0 && height > 0 && piece.0 > 0 && piece.1 > 0;
    let places = places(decoder).ok().filter(|_| is_read)?;
    Some(Mask { index, width, height, piece, places })
}

fn convert(colours: &Colours, decoded: DecodingResult, width: u32, height: u32) -> std::result::Result<Piece, String> {
    let count = width as usize * height as usize;
    let piece = match (colours, decoded) {
        (Colours::Palette(palette), DecodingResult::U8(indexes)) => {
            let colour = |index: &u8| palette.get(usize::from(*index)).map_or([0; 4], |[r, g, b]| [*r, *g, *b, 255]);
            Piece::Colours(Raster { width, height, rgba: indexes.iter().flat_map(colour).collect() })
        }
        (Colours::Bands(1) | Colours::Numbers, decoded) => {
            let values: Vec<f32> = match decoded {
                DecodingResult::U8(values) => values.into_iter().map(f32::from).collect(),
                DecodingResult::I8(values) => values.into_iter().map(f32::from).collect(),
                DecodingResult::U16(values) => values.into_iter().map(f32::from).collect(),
                DecodingResult::I16(values) => values.into_iter().map(f32::from).collect(),
                DecodingResult::U32(values) => values.into_iter().map(|value| value as f32).collect(),
                DecodingResult::I32(values) => values.into_iter().map(|value| value as f32).collect(),
                DecodingResult::F32(values) => values,
                DecodingResult::F64(values) => values.into_iter().map(|value| value as f32).collect(),
                _ => return Err("its numbers are of a kind that is not read".to_owned()),
            };
            Piece::Numbers { width, values }
        }
        (Colours::YCbCr, DecodingResult::U8(values)) => {
            Piece::Colours(Raster { width, height, rgba: rgba_from_ycbcr(&values) })
        }
        (Colours::Bands(bands), DecodingResult::U8(values)) => {
            Piece::Colours(Raster { width, height, rgba: rgba_from(&values, *bands) })
        }
        (Colours::Bands(bands), DecodingResult::U16(values)) => {
            let bytes: Vec<u8> = values.into_iter().map(|value| (value >> 8) as u8).collect();
            Piece::Colours(Raster { width, height, rgba: rgba_from(&bytes, *bands) })
        }
        _ => return Err("its colours have neither 8 nor 16 bits".to_owned()),
    };
    let is_whole = match &piece {
        Piece::Mask(_) | Piece::Empty => true,
        Piece::Colours(raster) => raster.rgba.len() >= count * 4,
        Piece::Numbers { values, .. } => values.len() >= count,
    };
    if is_whole { Ok(piece) } else { Err("a piece of it was cut short".to_owned()) }
}

/// Red, green and blue from JPEG's brightness and differences (ITU-T T.871, section 7).
fn rgba_from_ycbcr(values: &[u8]) -> Vec<u8> {
    let colour = |pixel: &[u8]| {
        let [y, cb, cr] = [f32::from(pixel[0]), f32::from(pixel[1]) - 128.0, f32::from(pixel[2]) - 128.0];
        let byte = |value: f32| value.round().clamp(0.0, 255.0) as u8;
        [byte(y + 1.402 * cr), byte(y - 0.344_136 * cb - 0.714_136 * cr), byte(y + 1.772 * cb), 255]
    };
    values.chunks_exact(3).flat_map(colour).collect()
}

/// The system by the GeoKey directory (tag 34735): keys of four numbers each behind a header of four.
fn crs_of(decoder: &mut TiffDecoder) -> std::result::Result<Crs, String> {
    let keys = decoder
        .get_tag_u16_vec(Tag::GeoKeyDirectoryTag)
        .map_err(|_| "it is not georeferenced; use it as kind image, with its corners".to_owned())?;
    let key = |wanted: u16| keys.chunks_exact(4).skip(1).find(|key| key[0] == wanted && key[1] == 0).map(|key| key[3]);
    const PROJECTED: u16 = 3072;
    const GEOGRAPHIC: u16 = 2048;
    let code = if key(1024) == Some(2) { key(GEOGRAPHIC) } else { key(PROJECTED).or_else(|| key(GEOGRAPHIC)) };
    match code {
        Some(code) if code != 32_767 => Crs::from_epsg(code.into()).ok_or_else(|| {
            format!("it is in EPSG:{code}, which is not known here; make it with gdalwarp -t_srs EPSG:3857")
        }),
        _ => Err("its system has no EPSG code; make it with gdalwarp -t_srs EPSG:3857".to_owned()),
    }
}

/// Whether its vertical system (key 4096) is an ellipsoid: 5000 to 5099 (GeoTIFF 1.0, section 6.3.4.1).
fn is_ellipsoidal(decoder: &mut TiffDecoder) -> bool {
    const VERTICAL: u16 = 4096;
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    keys.chunks_exact(4).skip(1).any(|key| key[..2] == [VERTICAL, 0] && (5000..5100).contains(&key[3]))
}

/// Corner of the top left pixel, and a pixel's size.
fn transform_of(decoder: &mut TiffDecoder) -> std::result::Result<([f64; 2], [f64; 2]), String> {
    const RASTER_TYPE: u16 = 1025;
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let is_point = keys.chunks_exact(4).skip(1).any(|key| key[0] == RASTER_TYPE && key[3] == 2);
    let turned = || "it is turned against north; make it with gdalwarp".to_owned();
    let (mut origin, pixel) = if let Some(matrix) = doubles(decoder, 34_264) {
        let [a, b, _, d, e, f, _, h, ..] = matrix.as_slice() else {
            return Err("its transformation is broken".to_owned());
        };
        if *b != 0.0 || *e != 0.0 || *a <= 0.0 || *f >= 0.0 {
            return Err(turned());
        }
        ([*d, *h], [*a, -*f])
    } else {
        let scale =
            doubles(decoder, 33_550).ok_or("it does not say where it lies; use it as kind image, with its corners")?;
        let tie =
            doubles(decoder, 33_922).ok_or("it does not say where it lies; use it as kind image, with its corners")?;
        let ([sx, sy, ..], [i, j, _, x, y, ..]) = (scale.as_slice(), tie.as_slice()) else {
            return Err("its tie point is broken".to_owned());
        };
        ([x - i * sx, y + j * sy], [*sx, *sy])
    };
    if is_point {
        origin = [origin[0] - pixel[0] / 2.0, origin[1] + pixel[1] / 2.0];
    }
    let is_right =
        origin.iter().all(|number| number.is_finite()) && pixel.iter().all(|size| size.is_finite() && *size > 0.0);
    if !is_right {
        return Err(turned());
    }
    if pixel[0].max(pixel[1]) > pixel[0].min(pixel[1]) * MOST_STRETCHED {
        return Err(format!(
            "its pixels are {:e} by {:e}: those of the ground are about as high as wide",
            pixel[0], pixel[1]
        ));
    }
    Ok((origin, pixel))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Folder;
    use tiff::encoder::{TiffEncoder, colortype};

    fn keys(epsg: u16, is_geographic: bool, is_point: bool) -> Vec<u16> {
        let (kind, key) = if is_geographic { (2, 2048) } else { (1, 3072) };
        vec![1, 1, 0, 3, 1024, 0, 1, kind, 1025, 0, 1, 1 + u16::from(is_point), key, 0, 1, epsg]
    }

    fn heights(path: &Path, is_point: bool) {
        heights_of(path, is_point, [0.5, 0.5, 0.0]);
    }

    fn heights_of(path: &Path, is_point: bool, scale: [f64; 3]) {
        numbers(path, is_point, scale, Some("-9999"), [100.0, 200.0, -9999.0, 300.0, 400.0, 500.0], None);
    }

    /// Two rows of three numbers, with a void that is named and a mask that has been packed.
    fn numbers(
        path: &Path,
        is_point: bool,
        scale: [f64; 3],
        void: Option<&str>,
        numbers: [f32; 6],
        mask: Option<(&[u8], u16)>,
    ) {
        let mut file = File::create(path).expect("a file");
        let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
        let mut image = encoder.new_image::<colortype::Gray32Float>(3, 2).expect("an image");
        let tags = image.encoder();
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(4326, true, is_point)[..]).expect("keys");
        tags.write_tag(Tag::Unknown(33_550), &scale[..]).expect("scale");
        tags.write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, -4.0, 41.0, 0.0][..]).expect("tie");
        if let Some(void) = void {
            tags.write_tag(Tag::GdalNodata, void).expect("void");
        }
        image.write_data(&numbers).expect("data");
        let Some((packed, packing)) = mask else { return };
        let mut mask = encoder.image_directory().expect("a mask");
        let at = mask.write_data(packed).expect("bits");
        for (tag, value) in [
            (Tag::NewSubfileType, 4_u32),
            (Tag::ImageWidth, 3),
            (Tag::ImageLength, 2),
            (Tag::BitsPerSample, 1),
            (Tag::Compression, packing.into()),
            (Tag::PhotometricInterpretation, 4),
            (Tag::StripOffsets, u32::try_from(at).expect("small")),
            (Tag::SamplesPerPixel, 1),
            (Tag::RowsPerStrip, 2),
            (Tag::StripByteCounts, u32::try_from(packed.len()).expect("small")),
        ] {
            mask.write_tag(tag, value).expect("a tag");
        }
        mask.finish().expect("a mask");
    }

    #[test]
    fn voids_are_no_heights_whatever_names_them() {
        let folder = Folder::new();
        let path = folder.path().join("h.tif");
        let scale = [0.5, 0.5, 0.0];
        // The middle of the first pixel and of the second, and half-way between them.
        let read = |void: Option<&str>, second: f32, mask: Option<(&[u8], u16)>| {
            numbers(&path, false, scale, void, [1500.0, second, 1500.0, 1500.0, 1500.0, 1500.0], mask);
            let file = GeoTiff::open(&path).expect("a file");
            [-3.75, -3.25, -3.5].map(|lon| file.height_m(40.75, lon, true).expect("read"))
        };
        let void = [Some(1500.0), None, None];
        for second in [-9999.0, -32_767.0, -32_768.0, f32::MIN, f32::NAN, 12_345.0] {
            assert_eq!(read(None, second, None), void, "{second}");
        }
        assert_eq!(read(Some("-9.9"), -9.9, None), void, "named in more digits than it has");
        assert_eq!(read(None, -40.0, None), [Some(1500.0), Some(-40.0), Some(730.0)], "the shore of a salt lake");
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        io::Write::write_all(&mut packer, &[0b1010_0000, 0b1110_0000]).expect("packed");
        let packed = packer.finish().expect("packed");
        assert_eq!(read(None, 0.0, Some((&packed, 8))), void, "hidden by the mask");
        assert_eq!(GeoTiff::open(&path).expect("a file").height_fault(), None);
        numbers(&path, false, scale, None, [1500.0; 6], Some((&[0b1010_0000, 0b1110_0000], 1)));
        let fault = GeoTiff::open(&path).expect("a file").height_fault().expect("unread");
        assert!(fault.contains("mask"), "{fault}");
    }

    #[test]
    fn heights_lie_between_the_middles_of_pixels() {
        let folder = Folder::new();
        let path = folder.path().join("h.tif");
        heights(&path, false);
        let file = GeoTiff::open(&path).expect("a file");
        assert!(file.has_numbers());
        for (lat, lon, height) in [
            (40.75, -3.75, Some(100.0)),
            (40.75, -3.25, Some(200.0)),
            (40.25, -3.25, Some(400.0)),
            (40.5, -3.5, Some(250.0)),
            (40.75, -3.0, None),
            (40.25, -2.75, Some(500.0)),
            (41.0, -4.0, Some(100.0)),
            (41.1, -4.0, None),
        ] {
            let found = file.height_m(lat, lon, false).expect("read");
            assert_eq!(found, height, "{lat} {lon}");
        }
        heights(&path, true);
        let file = GeoTiff::open(&path).expect("a file");
        assert_eq!(file.height_m(41.0, -4.0, false).expect("read"), Some(100.0), "pixels are points");
        assert!(file.tile(TileId { level: 0, column: 0, row: 0 }).is_err(), "heights are not drawn");
        // One of another layout in its place is not read at the old places.
        std::fs::write(&path, [std::fs::read(&path).expect("read"), vec![0]].concat()).expect("written");
        assert!(file.height_m(41.0, -4.0, false).expect_err("another").to_string().contains("replaced"));
    }

    #[test]
    fn a_file_above_an_ellipsoid_is_no_source_of_heights() {
        let folder = Folder::new();
        for (vertical, is_refused) in [(5030, true), (5773, false)] {
            let path = folder.path().join(format!("{vertical}.tif"));
            let mut keys = [keys(4326, true, false), vec![4096, 0, 1, vertical]].concat();
            keys[3] += 1;
            let mut file = File::create(&path).expect("a file");
            let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
            let mut image = encoder.new_image::<colortype::Gray32Float>(1, 1).expect("an image");
            image.encoder().write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).expect("keys");
            image.encoder().write_tag(Tag::Unknown(33_550), &[0.5_f64, 0.5, 0.0][..]).expect("scale");
            image.encoder().write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, -4.0, 41.0, 0.0][..]).expect("tie");
            image.write_data(&[1500.0]).expect("data");
            let fault = GeoTiff::open(&path).expect("a file").height_fault();
            assert_eq!(fault.is_some_and(|fault| fault.contains("ellipsoid")), is_refused, "{vertical}");
        }
    }

    #[test]
    fn a_picture_is_drawn_where_it_lies() {
        let folder = Folder::new();
        let path = folder.path().join("p.tif");
        let (width, height) = (600_u32, 300_u32);
        let mut pixels = vec![50_u8; (width * height * 3) as usize];
        let at = ((10 * width + 580) * 3) as usize;
        pixels[at..at + 3].copy_from_slice(&[255, 0, 0]);
        let mut file = File::create(&path).expect("a file");
        let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
        let mut image = encoder.new_image::<colortype::RGB8>(width, height).expect("an image");
        image.encoder().write_tag(Tag::GeoKeyDirectoryTag, &keys(25_830, false, false)[..]).expect("keys");
        image.encoder().write_tag(Tag::Unknown(33_550), &[2.0_f64, 2.0, 0.0][..]).expect("scale");
        image
            .encoder()
            .write_tag(Tag::Unknown(33_922), &[0.0_f64, 0.0, 0.0, 432_000.0, 4_465_000.0, 0.0][..])
            .expect("tie");
        image.write_data(&pixels).expect("data");
        let file = GeoTiff::open(&path).expect("a file");
        let grid = file.grid();
        assert_eq!((grid.crs.code().as_str(), grid.max_level), ("EPSG:25830", 2));
        let bounds = file.about().bounds.expect("known");
        assert!((bounds.west_deg + 3.8).abs() < 0.01 && (bounds.north_deg - 40.33).abs() < 0.01, "{bounds:?}");
        let tile = file.tile(TileId { level: 2, column: 2, row: 0 }).expect("read").expect("there");
        let tile = Raster::read(&tile, 1 << 20).expect("a picture");
        assert_eq!(tile.pixel(580 - 512, 10), [255, 0, 0, 255]);
        assert_eq!(tile.pixel(580 - 512, 11), [50, 50, 50, 255]);
        assert_eq!(tile.pixel(100, 10)[3], 0, "beyond the file");
        assert!(file.tile(TileId { level: 0, column: 0, row: 0 }).expect("read").is_some());
    }

    #[test]
    fn what_lies_nowhere_says_what_helps() {
        let folder = Folder::new();
        let path = folder.path().join("p.tif");
        let mut file = File::create(&path).expect("a file");
        let mut encoder = TiffEncoder::new(&mut file).expect("a TIFF");
        encoder.write_image::<colortype::RGB8>(1, 1, &[1, 2, 3]).expect("written");
        assert!(GeoTiff::open(&path).expect_err("wrong").contains("corners"));
        heights_of(&path, false, [1e-300, 0.5, 0.0]);
        assert!(GeoTiff::open(&path).expect_err("wrong").contains("as high as wide"));
        std::fs::write(&path, b"text").expect("written");
        assert!(GeoTiff::open(&path).expect_err("wrong").contains("no TIFF"));
    }
}
