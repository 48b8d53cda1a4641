//! Content types by the first and last bytes: what a service declares is not trusted.

/// A kind of picture that browsers show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Picture {
    /// PNG (RFC 2083).
    Png,
    /// JPEG (ITU-T T.81).
    Jpeg,
    /// WebP.
    Webp,
    /// GIF.
    Gif,
}

/// Pixels of a picture's side at most: what a browser unpacks stays bounded.
pub const MAX_SIDE_PX: u32 = 8192;

impl Picture {
    /// The media type.
    pub const fn mime(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::Webp => "image/webp",
            Self::Gif => "image/gif",
        }
    }

    /// The name that MBTiles files give the format.
    pub const fn short(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
            Self::Webp => "webp",
            Self::Gif => "gif",
        }
    }

    /// The kind of a picture, by its first bytes.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a, ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'G', b'I', b'F', b'8', b'7' | b'9', b'a', ..] => Some(Self::Gif),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::Webp),
            _ => None,
        }
    }
}

/// Checks that bytes are a whole picture of bounded size.
///
/// # Errors
/// What they are instead, as a phrase.
pub fn check_picture(bytes: &[u8]) -> Result<Picture, String> {
    let Some(kind) = Picture::of(bytes) else { return Err(format!("no picture but {}", describe(bytes))) };
    let (width, height) = size_px(kind, bytes).ok_or("a picture whose header is cut short")?;
    if width == 0 || height == 0 || width > MAX_SIDE_PX || height > MAX_SIDE_PX {
        return Err(format!("a picture of {width} × {height} pixels; at most {MAX_SIDE_PX} a side are taken"));
    }
    let is_whole = match kind {
        // The IEND chunk.
        Picture::Png => bytes.windows(4).rev().take(64).any(|word| word == b"IEND"),
        // End of image; some writers pad.
        Picture::Jpeg => bytes.windows(2).rev().take(4096).any(|word| word == [0xff, 0xd9]),
        Picture::Webp => u32_le(bytes, 4).is_some_and(|size| bytes.len() as u64 + 1 >= u64::from(size) + 8),
        Picture::Gif => bytes.iter().rev().take(64).any(|byte| *byte == 0x3b),
    };
    if is_whole { Ok(kind) } else { Err("a picture that was cut short".to_owned()) }
}

/// Width and height as a picture's header says.
pub fn size_px(kind: Picture, bytes: &[u8]) -> Option<(u32, u32)> {
    match kind {
        Picture::Png => Some((u32_be(bytes, 16)?, u32_be(bytes, 20)?)),
        Picture::Gif => Some((u16_le(bytes, 6)?.into(), u16_le(bytes, 8)?.into())),
        Picture::Webp => match bytes.get(12..16)? {
            b"VP8X" => Some((u24_le(bytes, 24)? + 1, u24_le(bytes, 27)? + 1)),
            b"VP8L" => {
                let bits = u32_le(bytes, 21)?;
                Some(((bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1))
            }
            b"VP8 " => Some(((u16_le(bytes, 26)? & 0x3fff).into(), (u16_le(bytes, 28)? & 0x3fff).into())),
            _ => None,
        },
        Picture::Jpeg => jpeg_size(bytes),
    }
}

/// Walks the segments of a JPEG to its frame header (T.81, B.2.2).
fn jpeg_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let mut at = 2;
    loop {
        if *bytes.get(at)? != 0xff {
            return None;
        }
        let marker = *bytes.get(at + 1)?;
        match marker {
            0xff => at += 1,
            0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                return Some((u16_be(bytes, at + 7)?.into(), u16_be(bytes, at + 5)?.into()));
            }
            _ => at += 2 + usize::from(u16_be(bytes, at + 2)?.max(2)),
        }
    }
}

/// Hash of a picture for ETags; stable within one version of the program.
pub fn hash(bytes: &[u8]) -> u64 {
    // A tenth of the time of SipHash; that two pictures of one place and one length have the same is one chance in 2³².
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    (bytes.len() as u64) << 32 | u64::from(crc.sum())
}

/// Describes bytes that are not a picture, for messages.
pub fn describe(bytes: &[u8]) -> String {
    let start = bytes.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(bytes.len());
    let start = &bytes[start..];
    let lower: Vec<u8> = start.iter().take(16).map(u8::to_ascii_lowercase).collect();
    match start {
        [] => "nothing".to_owned(),
        [0x1f, 0x8b, ..] => "gzip data (perhaps vector tiles, which are not shown)".to_owned(),
        [b'%', b'P', b'D', b'F', ..] => "a PDF".to_owned(),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            "a TIFF, which browsers do not show; choose image/png or image/jpeg".to_owned()
        }
        [0x1a, ..] => "a vector tile; only pictures are shown".to_owned(),
        _ if lower.starts_with(b"<!doctype html") || lower.starts_with(b"<html") => {
            format!("a web page: {}", words(start))
        }
        [b'<', ..] => format!("XML: {}", words(start)),
        [b'{' | b'[', ..] => format!("JSON: {}", words(start)),
        _ if start.iter().take(64).all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace()) => {
            format!("text: {}", words(start))
        }
        _ => format!("{} bytes of an unknown kind", bytes.len()),
    }
}

/// The words of a text without its markup, cut to a line.
pub fn words(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(16_384)]);
    let mut shown = String::new();
    let mut in_tag = false;
    for c in text.chars() {
        match c {
            '<' => in_tag = true,
            '>' if in_tag => {
                in_tag = false;
                shown.push(' ');
            }
            _ if in_tag => {}
            c if c.is_control() => shown.push(' '),
            c => shown.push(c),
        }
    }
    one_line(&shown, 200)
}

/// A text as one line of at most `most` characters.
pub fn one_line(text: &str, most: usize) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if text.chars().count() <= most { text } else { text.chars().take(most).chain(['…']).collect() }
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at + N)?.try_into().ok()
}

fn u16_be(bytes: &[u8], at: usize) -> Option<u16> {
    array(bytes, at).map(u16::from_be_bytes)
}

fn u16_le(bytes: &[u8], at: usize) -> Option<u16> {
    array(bytes, at).map(u16::from_le_bytes)
}

fn u24_le(bytes: &[u8], at: usize) -> Option<u32> {
    array(bytes, at).map(|[a, b, c]: [u8; 3]| u32::from_le_bytes([a, b, c, 0]))
}

fn u32_be(bytes: &[u8], at: usize) -> Option<u32> {
    array(bytes, at).map(u32::from_be_bytes)
}

pub(crate) fn u32_le(bytes: &[u8], at: usize) -> Option<u32> {
    array(bytes, at).map(u32::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;

    #[test]
    fn a_whole_png_is_taken_and_a_cut_one_is_not() {
        let png = Raster::filled(3, 2, [1, 2, 3, 255]).to_png();
        assert_eq!(check_picture(&png), Ok(Picture::Png));
        assert_eq!(size_px(Picture::Png, &png), Some((3, 2)));
        assert!(check_picture(&png[..png.len() - 20]).unwrap_err().contains("cut short"));
        let mut huge = png;
        huge[16] = 0x7f;
        assert!(check_picture(&huge).unwrap_err().contains("at most"));
    }

    #[test]
    fn what_is_no_picture_is_named() {
        for (bytes, said) in [
            (&b""[..], "nothing"),
            (b"<html><title>Sign in</title>", "a web page: Sign in"),
            (b"  <?xml version='1.0'?><a>no such layer</a>", "XML: no such layer"),
            (b"{\"error\": 1}", "JSON"),
            (b"quota exceeded", "text: quota exceeded"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"II*\0", "TIFF"),
        ] {
            assert!(check_picture(bytes).unwrap_err().contains(said), "{bytes:?}");
        }
    }

    #[test]
    fn a_jpeg_frame_is_found_behind_other_segments() {
        let jpeg = [0xff, 0xd8, 0xff, 0xe0, 0, 4, 0, 0, 0xff, 0xc0, 0, 11, 8, 0, 16, 0, 32, 1, 1, 0x11, 0, 0xff, 0xd9];
        assert_eq!(size_px(Picture::Jpeg, &jpeg), Some((32, 16)));
        assert_eq!(check_picture(&jpeg), Ok(Picture::Jpeg));
        assert!(check_picture(&jpeg[..9]).is_err());
    }
}
