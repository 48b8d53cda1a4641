//! The images of a TIFF: how their pieces are written, and what a decoded piece holds.

use std::sync::Arc;

use tiff::ColorType;
use tiff::decoder::{ChunkType, DecodingResult};
use tiff::tags::Tag;

use super::input::{MAX_PIECE, TiffDecoder};
use super::lzw;
use crate::raster::{Raster, rgba_from};

/// One image of the file: the picture itself or an overview.
#[derive(Debug, Clone)]
pub(super) struct Image {
    pub(super) index: usize,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) piece: (u32, u32),
    pub(super) colours: Colours,
    /// Where its pieces are in the file, and how many bytes they have.
    pub(super) places: Arc<Vec<(u64, u64)>>,
    /// Which of its pixels are to be seen.
    pub(super) mask: Option<Mask>,
    /// How its pieces are written, where they are packed by LZW.
    pub(super) lzw: Option<lzw::Layout>,
    /// Whether its pieces are tiles, all of one size, or strips, the last of which is cut.
    pub(super) is_tiled: bool,
    /// Whether its pieces are JPEG files, which say their own size.
    pub(super) is_jpeg: bool,
    /// Bytes of a pixel as stored.
    pub(super) depth: u64,
}

/// An image's mask: one bit a pixel, packed by Deflate, as GDAL writes them (TIFF 6.0, NewSubfileType, bit 2).
#[derive(Debug, Clone)]
pub(super) struct Mask {
    pub(super) index: usize,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) piece: (u32, u32),
    pub(super) places: Arc<Vec<(u64, u64)>>,
}

#[derive(Debug, Clone)]
pub(super) enum Colours {
    /// Bands of 8 or 16 bits.
    Bands(usize),
    /// Brightness and two differences of colour, as JPEG has them.
    YCbCr,
    /// Red, green, blue of each index.
    Palette(Arc<Vec<[u8; 3]>>),
    /// One band of numbers that are not colours: heights.
    Numbers,
}

/// A decoded piece: colours, or numbers.
#[derive(Debug)]
pub(super) enum Piece {
    /// One that was never written: no data.
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
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Empty => 0,
            Self::Colours(raster) => raster.rgba.len(),
            Self::Numbers { values, .. } => values.len() * 4,
            Self::Mask(bits) => bits.len(),
        }
    }
}

impl Image {
    /// Rows of its largest piece as stored: a strip may claim more than there are.
    pub(super) fn piece_rows(&self) -> u32 {
        if self.is_tiled { self.piece.1 } else { self.piece.1.min(self.height) }
    }
}

/// Pixels of a piece: those at the right and bottom edges are cut.
pub(super) fn piece_size(image: &Image, piece: u32) -> (u32, u32) {
    let across = image.width.div_ceil(image.piece.0);
    let (column, row) = (piece % across, piece / across);
    let cut = |whole: u32, size: u32, number: u32| size.min(whole.saturating_sub(number.saturating_mul(size)));
    (cut(image.width, image.piece.0, column), cut(image.height, image.piece.1, row))
}

pub(super) fn image(decoder: &mut TiffDecoder, index: usize, is_big_endian: bool) -> Result<Image, String> {
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
pub(super) fn places(decoder: &mut TiffDecoder) -> Result<Arc<Vec<(u64, u64)>>, String> {
    let tags = match decoder.get_chunk_type() {
        ChunkType::Strip => (Tag::StripOffsets, Tag::StripByteCounts),
        ChunkType::Tile => (Tag::TileOffsets, Tag::TileByteCounts),
    };
    let mut numbers = |tag| decoder.get_tag_u64_vec(tag).map_err(|error| error.to_string());
    Ok(Arc::new(numbers(tags.0)?.into_iter().zip(numbers(tags.1)?).collect()))
}

/// How pieces that are packed by LZW are written; `None` for others, which the `tiff` crate reads.
pub(super) fn lzw_layout(decoder: &mut TiffDecoder, piece: (u32, u32), is_big_endian: bool) -> Option<lzw::Layout> {
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
pub(super) fn mask(decoder: &mut TiffDecoder, index: usize) -> Option<Mask> {
    let (width, height) = decoder.dimensions().ok()?;
    let piece = decoder.chunk_dimensions();
    let mut number = |tag| decoder.find_tag_unsigned::<u32>(tag).ok().flatten();
    let (bits, packing) = (number(Tag::BitsPerSample).unwrap_or(1), number(Tag::Compression)?);
    // 8 and 32946: Deflate, new and old.
    let is_read = bits == 1 && matches!(packing, 8 | 32_946) && width > 0 && height > 0 && piece.0 > 0 && piece.1 > 0;
    let places = places(decoder).ok().filter(|_| is_read)?;
    Some(Mask { index, width, height, piece, places })
}

pub(super) fn convert(colours: &Colours, decoded: DecodingResult, width: u32, height: u32) -> Result<Piece, String> {
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
pub(super) fn rgba_from_ycbcr(values: &[u8]) -> Vec<u8> {
    let colour = |pixel: &[u8]| {
        let [y, cb, cr] = [f32::from(pixel[0]), f32::from(pixel[1]) - 128.0, f32::from(pixel[2]) - 128.0];
        let byte = |value: f32| value.round().clamp(0.0, 255.0) as u8;
        [byte(y + 1.402 * cr), byte(y - 0.344_136 * cb - 0.714_136 * cr), byte(y + 1.772 * cb), 255]
    };
    values.chunks_exact(3).flat_map(colour).collect()
}
