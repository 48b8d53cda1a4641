//! Pictures as pixels: reading PNG, JPEG and WebP within bounds, writing PNG.

use std::io::Cursor;

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::memory::{Lease, lease};
use crate::sniff::{self, Picture};

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
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self { width, height, rgba: colour.repeat(width as usize * height as usize) }
    }

    /// The colour of a pixel that is inside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// Sets the colour of a pixel that is inside.
    pub fn set(&mut self, x: u32, y: u32, colour: [u8; 4]) {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        self.rgba[at..at + 4].copy_from_slice(&colour);
    }

    /// Whether all of it is transparent.
    pub fn is_clear(&self) -> bool {
        self.rgba.chunks_exact(4).all(|pixel| pixel[3] == 0)
    }

    /// As a PNG file.
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
    /// The fault, as a sentence.
    pub fn read(bytes: &[u8], max_px: u64) -> Result<Self, String> {
        Self::read_leased(bytes, max_px).map(|(read, _)| read)
    }

    /// The same, with the memory that it was read under: to be held by the reader until the pixels are counted
    /// elsewhere.
    ///
    /// # Errors
    /// The fault, as a sentence.
    pub(crate) fn read_leased(bytes: &[u8], max_px: u64) -> Result<(Self, Lease), String> {
        let kind = Picture::of(bytes).ok_or_else(|| format!("no picture but {}", sniff::describe(bytes)))?;
        let (width, height) = sniff::size_px(kind, bytes).ok_or("the picture's header is cut short")?;
        if u64::from(width) * u64::from(height) > max_px || width == 0 || height == 0 {
            return Err(format!("the picture has {width} × {height} pixels; at most {max_px} in all are taken"));
        }
        let size = [width, height];
        let cost = match kind {
            // Rows of up to 16 bits a band, packed and not.
            Picture::Png => 32 * u64::from(width) + 1_000_000,
            Picture::Jpeg => jpeg_cost(bytes, |frame| frame == size)?,
            Picture::Webp => webp_cost(bytes, size)?,
            Picture::Gif => return Err("GIF pictures cannot be read; make it PNG".to_owned()),
        };
        let pixels = u64::from(width) * u64::from(height);
        let mut lease = lease(pixels.checked_mul(4).and_then(|rgba| rgba.checked_add(cost)))?;
        let read = match kind {
            Picture::Png => read_png(bytes, size)?,
            Picture::Jpeg => read_jpeg(bytes, size)?,
            _ => read_webp(bytes, size)?,
        };
        let is_whole = read.rgba.len() == read.width as usize * read.height as usize * 4;
        if is_whole && (read.width, read.height) == (width, height) {
            lease.shrink(read.rgba.len() as u64);
            Ok((read, lease))
        } else {
            Err("the picture does not hold the pixels that its header announces".to_owned())
        }
    }
}

/// Compares the size that a decoder reports with the header's before allocating.
fn same(found: Option<(usize, usize)>, [width, height]: [u32; 2]) -> Result<(), String> {
    let is_same = found == Some((width as usize, height as usize));
    if is_same { Ok(()) } else { Err("the picture says two different sizes of itself".to_owned()) }
}

fn read_png(bytes: &[u8], size: [u32; 2]) -> Result<Raster, String> {
    // Beside the pixels, which are ours: tables and a few rows.
    let most = 64 * size[0] as usize + 1_000_000;
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: most });
    // Packed texts and profiles are not wanted.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    same(Some((reader.info().width as usize, reader.info().height as usize)), size)?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
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

fn read_jpeg(bytes: &[u8], size: [u32; 2]) -> Result<Raster, String> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGBA)
        .set_max_width(size[0] as usize)
        .set_max_height(size[1] as usize);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| format!("{error:?}"))?;
    same(decoder.info().map(|info| (info.width.into(), info.height.into())), size)?;
    let pixels = decoder.decode().map_err(|error| format!("{error:?}"))?;
    let rgba = match decoder.output_colorspace().map_or(4, |space| space.num_components()) {
        4 => pixels,
        bands => rgba_from(&pixels, bands),
    };
    Ok(Raster { width: size[0], height: size[1], rgba })
}

fn read_webp(bytes: &[u8], size: [u32; 2]) -> Result<Raster, String> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    decoder.set_memory_limit(bytes.len());
    let (width, height) = decoder.dimensions();
    same(Some((width as usize, height as usize)), size)?;
    let mut pixels = vec![0; decoder.output_buffer_size().ok_or("the picture is too large")?];
    decoder.read_image(&mut pixels).map_err(|error| error.to_string())?;
    let rgba = if decoder.has_alpha() { pixels } else { rgba_from(&pixels, 3) };
    Ok(Raster { width, height, rgba })
}

/// Bytes that decoding a JPEG file takes, its colours included. Every frame header counts (ITU-T T.81, B.2.2), also one
/// that is not where it should be: decoders differ in which one they use.
///
/// # Errors
/// A frame whose size or sampling is not supported.
pub(crate) fn jpeg_cost(bytes: &[u8], is_taken: impl Fn([u32; 2]) -> bool) -> Result<u64, String> {
    let mut most = 0;
    for at in memchr_ff(bytes) {
        let Some([marker, high, length, depth, h1, h0, w1, w0, bands]) =
            bytes.get(at + 1..at + 10).and_then(|head| <[u8; 9]>::try_from(head).ok())
        else {
            break;
        };
        let is_frame = matches!(marker, 0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf);
        if !is_frame || high != 0 || u16::from(length) != 8 + 3 * u16::from(bands) || depth > 16 {
            continue;
        }
        let size = [u32::from(u16::from_be_bytes([w1, w0])), u32::from(u16::from_be_bytes([h1, h0]))];
        if !is_taken(size) {
            return Err(format!("its JPEG holds {} × {} pixels, which is not what was announced", size[0], size[1]));
        }
        let factors: Vec<(u64, u64)> = bytes
            .get(at + 10..)
            .unwrap_or_default()
            .chunks_exact(3)
            .take(bands.into())
            .map(|band| (u64::from(band[1] >> 4), u64::from(band[1] & 15)))
            .collect();
        if bands > 4 || factors.iter().any(|(across, down)| !(1..=4).contains(across) || !(1..=4).contains(down)) {
            return Err("its JPEG has bands or samplings that are not read".to_owned());
        }
        let (across, down) = factors.iter().fold((1, 1), |(h, v), (across, down)| (h.max(*across), v.max(*down)));
        // Whole units of 8 × 8 samples of the coarsest band.
        let pixels = u64::from(size[0]).next_multiple_of(8 * across) * u64::from(size[1]).next_multiple_of(8 * down);
        let parts: u64 = factors.iter().map(|(across, down)| across * down).sum();
        // Coefficients of two bytes, all of them where the file comes in several scans; the colours; rows in work.
        let rows = u64::from(size[0]) * 64 * u64::from(bands) * down;
        most = most.max(pixels * parts * 2 / (across * down) + pixels * 4 + rows);
    }
    Ok(most)
}

/// Where bytes of 255 are.
fn memchr_ff(bytes: &[u8]) -> impl Iterator<Item = usize> {
    bytes.iter().enumerate().filter(|(_, byte)| **byte == 0xff).map(|(at, _)| at)
}

/// Bytes that decoding a WebP file takes beside its colours (RFC 9649, section 2.7). A picture inside must have the
/// file's size.
fn webp_cost(bytes: &[u8], [width, height]: [u32; 2]) -> Result<u64, String> {
    let mut at = 12_usize;
    while let Some((name, length)) = bytes.get(at..at + 4).zip(sniff::u32_le(bytes, at + 4)) {
        let inside = match name {
            b"VP8 " => sniff::size_px(Picture::Webp, &[&bytes[..12], &bytes[at..(at + 18).min(bytes.len())]].concat()),
            b"ANIM" | b"ANMF" => return Err("moving pictures are not read; make it PNG".to_owned()),
            _ => None,
        };
        if inside.is_some_and(|inside| inside != (width, height)) {
            return Err("the picture says two different sizes of itself".to_owned());
        }
        let next = usize::try_from(length)
            .ok()
            .and_then(|length| at.checked_add(8)?.checked_add(length)?.checked_add(length & 1));
        let Some(next) = next else { break };
        at = next;
    }
    // Brightness and colour of whole blocks of 16 pixels, opacity twice, and colours without opacity.
    Ok(u64::from(width.next_multiple_of(16)) * u64::from(height.next_multiple_of(16)) * 8)
}

/// Pixels of grey, grey and alpha, or red, green and blue as those with four bytes.
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

    /// A JPEG header of one frame, and nothing behind it.
    fn jpeg(width: u16, height: u16, marker: u8, sampling: u8) -> Vec<u8> {
        let (w, h) = (width.to_be_bytes(), height.to_be_bytes());
        let frame = [0xff, marker, 0, 17, 8, h[0], h[1], w[0], w[1], 3, 1, sampling, 0, 2, 0x11, 0, 3, 0x11, 0];
        [&[0xff, 0xd8][..], &frame, &[0xff, 0xd9]].concat()
    }

    #[test]
    fn a_jpeg_costs_what_its_frames_say_wherever_they_are() {
        let any = |_: [u32; 2]| true;
        let cost = jpeg_cost(&jpeg(1000, 1000, 0xc2, 0x22), any).expect("read");
        assert!((7_000_000..8_000_000).contains(&cost), "{cost}");
        let two = [jpeg(16, 16, 0xc0, 0x11), jpeg(60_000, 60_000, 0xc2, 0x11)].concat();
        assert!(jpeg_cost(&two, any).expect("read") > 30_000_000_000);
        assert!(jpeg_cost(&two, |size| size == [16, 16]).unwrap_err().contains("60000 × 60000"));
        assert!(jpeg_cost(&jpeg(16, 16, 0xc0, 0xf1), any).unwrap_err().contains("sampling"));
        assert!(Raster::read(&jpeg(60_000, 60_000, 0xc2, 0x11), u64::MAX).unwrap_err().contains("MB"));
    }

    #[test]
    fn a_webp_with_another_picture_inside_is_refused() {
        let mut webp = b"RIFF\x40\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0\x0f\0\0\x0f\0\0VP8 \x10\0\0\0".to_vec();
        webp.extend([0, 0, 0, 0x9d, 0x01, 0x2a, 0xff, 0x3f, 0xff, 0x3f, 0, 0, 0, 0, 0, 0]);
        assert_eq!(sniff::size_px(Picture::Webp, &webp), Some((16, 16)));
        assert!(Raster::read(&webp, 1 << 30).unwrap_err().contains("two different sizes"));
    }

    // fault 49: pictures are refused by their header
    #[test]
    fn a_bomb_is_refused_by_its_header() {
        let mut png = Raster::filled(1, 1, [0; 4]).to_png();
        png[18] = 0xff;
        assert!(Raster::read(&png, 10_000).unwrap_err().contains("at most"));
        assert!(Raster::read(b"<html>", 10).is_err());
    }
}
