//! Pictures as pixels: reading PNG, JPEG and WebP within bounds, writing PNG.

use std::io::Cursor;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::sniff::Picture;

/// Pixels with red, green, blue and alpha, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a pixel.
    pub rgba: Vec<u8>,
}

impl Raster {
    /// Pixels of one colour.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self { width, height, rgba: colour.repeat(width as usize * height as usize) }
    }

    /// The colour of a pixel that is inside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// Sets the colour of a pixel that is inside.
    pub fn set(&mut self, x: u32, y: u32, colour: [u8; 4]) {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        self.rgba[at..at + 4].copy_from_slice(&colour);
    }

    /// Whether nothing of it is to be seen.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        self.rgba.chunks_exact(4).all(|pixel| pixel[3] == 0)
    }

    /// As a PNG file.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&self.rgba));
        written.expect("invariant: the pixels fill the picture, and memory takes what is written");
        bytes
    }

    /// The pixels of a picture of at most `max_px` pixels.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn read(bytes: &[u8], max_px: u64) -> Result<Self, String> {
        let kind = Picture::of(bytes).ok_or_else(|| format!("no picture but {}", crate::sniff::describe(bytes)))?;
        let (width, height) = crate::sniff::size_px(kind, bytes).ok_or("the picture's header is cut short")?;
        if u64::from(width) * u64::from(height) > max_px || width == 0 || height == 0 {
            return Err(format!("the picture has {width} × {height} pixels; at most {max_px} in all are taken"));
        }
        let read = match kind {
            Picture::Png => read_png(bytes),
            Picture::Jpeg => read_jpeg(bytes),
            Picture::Webp => read_webp(bytes),
            Picture::Gif => Err("GIF pictures cannot be read; make it PNG".to_owned()),
        }?;
        let is_whole = read.rgba.len() == read.width as usize * read.height as usize * 4;
        if is_whole && (read.width, read.height) == (width, height) {
            Ok(read)
        } else {
            Err("the picture does not hold the pixels that its header announces".to_owned())
        }
    }
}

/// Bytes that a decoder may take for itself.
const MAX_BYTES: usize = 512 * 1024 * 1024;

fn read_png(bytes: &[u8]) -> Result<Raster, String> {
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: MAX_BYTES });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let size = reader.output_buffer_size().ok_or("the picture is too large")?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|error| error.to_string())?;
    pixels.truncate(info.buffer_size());
    let rgba = match info.color_type {
        png::ColorType::Rgba => pixels,
        png::ColorType::Rgb => rgba_from(&pixels, 3),
        png::ColorType::GrayscaleAlpha => rgba_from(&pixels, 2),
        png::ColorType::Grayscale => rgba_from(&pixels, 1),
        png::ColorType::Indexed => return Err("the picture's palette was not resolved".to_owned()),
    };
    Ok(Raster { width: info.width, height: info.height, rgba })
}

fn read_jpeg(bytes: &[u8]) -> Result<Raster, String> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(1 << 16)
        .set_max_height(1 << 16);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let pixels = decoder.decode().map_err(|error| format!("{error:?}"))?;
    let info = decoder.info().ok_or("the picture has no header")?;
    let bands = decoder.output_colorspace().map_or(3, |space| space.num_components());
    Ok(Raster { width: info.width.into(), height: info.height.into(), rgba: rgba_from(&pixels, bands) })
}

fn read_webp(bytes: &[u8]) -> Result<Raster, String> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    decoder.set_memory_limit(MAX_BYTES);
    let (width, height) = decoder.dimensions();
    let mut pixels = vec![0; decoder.output_buffer_size().ok_or("the picture is too large")?];
    decoder.read_image(&mut pixels).map_err(|error| error.to_string())?;
    let rgba = if decoder.has_alpha() { pixels } else { rgba_from(&pixels, 3) };
    Ok(Raster { width, height, rgba })
}

/// Pixels of grey, grey and alpha, or red, green and blue as those with four bytes.
#[must_use]
pub fn rgba_from(pixels: &[u8], bands: usize) -> Vec<u8> {
    pixels
        .chunks_exact(bands.max(1))
        .flat_map(|pixel| match *pixel {
            [grey] => [grey, grey, grey, 255],
            [grey, alpha] => [grey, grey, grey, alpha],
            [red, green, blue] => [red, green, blue, 255],
            [red, green, blue, alpha, ..] => [red, green, blue, alpha],
            [] => [0; 4],
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let mut raster = Raster::filled(5, 4, [10, 20, 30, 255]);
        raster.set(4, 3, [200, 100, 50, 0]);
        let read = Raster::read(&raster.to_png(), 100).expect("a picture");
        assert_eq!(read, raster);
        assert_eq!(read.pixel(4, 3), [200, 100, 50, 0]);
        assert!(!read.is_clear() && Raster::filled(1, 1, [9, 9, 9, 0]).is_clear());
    }

    #[test]
    fn a_bomb_is_refused_by_its_header() {
        let mut png = Raster::filled(1, 1, [0; 4]).to_png();
        png[18] = 0xff;
        assert!(Raster::read(&png, 10_000).unwrap_err().contains("at most"));
        assert!(Raster::read(b"<html>", 10).is_err());
    }
}
