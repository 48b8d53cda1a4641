//! The lists of a TIFF (TIFF 6.0, section 2; BigTIFF), looked through before the `tiff` crate reads them: it makes room
//! for as many values as a tag announces, and a tag may announce any number.

use std::io::{Read, Seek, SeekFrom};

/// Values of one tag at most: the places of a million pieces.
const MAX_VALUES: u64 = 1 << 20;
/// Values of all tags of a file at most.
const MAX_ALL: u64 = 4 << 20;
/// Tags of an image at most.
const MAX_TAGS: u64 = 1024;

/// Looks through the first images of a file.
///
/// # Errors
/// What no file that is meant to be read has, in words.
pub(super) fn check(input: &mut (impl Read + Seek + ?Sized), max_images: usize) -> Result<(), String> {
    let bytes = input.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
    let mut at = Cursor { input, is_big_endian: false, is_wide: false };
    at.go(0)?;
    let mark: [u8; 2] = at.array()?;
    at.is_big_endian = match &mark {
        b"II" => false,
        b"MM" => true,
        _ => return Err("no TIFF".to_owned()),
    };
    at.is_wide = match at.number(2)? {
        42 => false,
        43 => true,
        _ => return Err("no TIFF".to_owned()),
    };
    let (wide, mut all) = (at.is_wide, 0_u64);
    at.go(if wide { 8 } else { 4 })?;
    let mut next = at.place()?;
    for _ in 0..max_images {
        if next == 0 {
            break;
        }
        at.go(next)?;
        let tags = at.number(if wide { 8 } else { 2 })?;
        if tags > MAX_TAGS {
            return Err(format!("one of its images has {tags} tags; at most {MAX_TAGS} are read"));
        }
        for _ in 0..tags {
            let (tag, kind) = (at.number(2)?, at.number(2)?);
            let count = at.place()?;
            at.place()?;
            let size: u64 = match kind {
                3 | 8 => 2,
                4 | 9 | 11 | 13 => 4,
                5 | 10 | 12 | 16..=18 => 8,
                _ => 1,
            };
            all = all.saturating_add(count);
            let is_there = count.checked_mul(size).is_some_and(|length| length <= bytes);
            if count > MAX_VALUES || all > MAX_ALL || !is_there {
                return Err(format!(
                    "its tag {tag} announces {count} values, more than are in the file or can be read; make it with gdal_translate \
                     -of COG"
                ));
            }
        }
        next = at.place()?;
    }
    Ok(())
}

struct Cursor<'a, R: ?Sized> {
    input: &'a mut R,
    is_big_endian: bool,
    /// Whether places and counts have eight bytes.
    is_wide: bool,
}

impl<R: Read + Seek + ?Sized> Cursor<'_, R> {
    fn go(&mut self, to: u64) -> Result<(), String> {
        self.input.seek(SeekFrom::Start(to)).map(drop).map_err(|error| error.to_string())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.input.read_exact(&mut bytes).map_err(|error| format!("no TIFF: {error}"))?;
        Ok(bytes)
    }

    fn number(&mut self, size: usize) -> Result<u64, String> {
        let mut bytes = [0_u8; 8];
        let (from, to) = if self.is_big_endian { (8 - size, 8) } else { (0, size) };
        let read = self.input.read_exact(&mut bytes[from..to]);
        read.map_err(|error| format!("no TIFF: {error}"))?;
        Ok(if self.is_big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    fn place(&mut self) -> Result<u64, String> {
        self.number(if self.is_wide { 8 } else { 4 })
    }
}
