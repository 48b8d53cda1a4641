//! Pieces of TIFFs packed by LZW (TIFF 6.0, sections 13 and 14; Adobe's Technical Note 3 for numbers with fractions).
//!
//! The `tiff` crate demands an end code with the reader that it uses since version 0.11 and then refuses whole files
//! that GDAL wrote (its issue 395); here a piece is whole when all its bytes are there.

use tiff::decoder::DecodingResult;
use weezl::{BitOrder, LzwStatus};

/// How a piece is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Pixels of a row as stored, edges included.
    pub width: u32,
    /// Rows as stored.
    pub height: u32,
    /// Numbers of a pixel.
    pub samples: usize,
    /// Bytes of a number: 1, 2 or 4.
    pub bytes: usize,
    /// Whether numbers have fractions.
    pub is_float: bool,
    /// Whether numbers have a sign.
    pub is_signed: bool,
    /// 1: none, 2: differences from pixel to pixel, 3: the same for numbers with fractions.
    pub predictor: u32,
    /// Whether the highest byte of a number comes first.
    pub is_big_endian: bool,
    /// Whether it is one of tiles, not of strips.
    pub is_tiled: bool,
}

/// Numbers of the left and upper part of a piece: what lies beyond the picture is left out.
pub(super) fn unpack(packed: &[u8], layout: Layout, width: u32, height: u32) -> Result<DecodingResult, String> {
    let stride = (layout.width as usize).checked_mul(layout.samples).and_then(|row| row.checked_mul(layout.bytes));
    let wanted = stride.and_then(|stride| stride.checked_mul(layout.height as usize));
    let (stride, wanted) = stride.zip(wanted).ok_or("a piece of it has more bytes than can be")?;
    if stride == 0 || width > layout.width {
        return Err("a piece of it has no pixels".to_owned());
    }
    let mut raw = decode(packed, wanted)?;
    for row in raw.chunks_exact_mut(stride) {
        match layout.predictor {
            2 => add_differences(row, layout),
            3 => join_planes(row, layout),
            _ => {}
        }
    }
    let kept = width as usize * layout.samples * layout.bytes;
    let rows = raw.chunks_exact(stride).take(height as usize).flat_map(|row| &row[..kept]).copied();
    let bytes: Vec<u8> = rows.collect();
    // The third predictor writes the highest byte first, whatever the file's order.
    let is_big = layout.is_big_endian || layout.predictor == 3;
    let word = |b: &[u8]| if is_big { [b[0], b[1]] } else { [b[1], b[0]] };
    let long = |b: &[u8]| if is_big { [b[0], b[1], b[2], b[3]] } else { [b[3], b[2], b[1], b[0]] };
    let (words, longs) = (|| bytes.chunks_exact(2).map(word), || bytes.chunks_exact(4).map(long));
    Ok(match (layout.bytes, layout.is_float, layout.is_signed) {
        (1, ..) => DecodingResult::U8(bytes),
        (2, false, false) => DecodingResult::U16(words().map(u16::from_be_bytes).collect()),
        (2, false, true) => DecodingResult::I16(words().map(i16::from_be_bytes).collect()),
        (4, true, _) => DecodingResult::F32(longs().map(f32::from_be_bytes).collect()),
        (4, false, true) => DecodingResult::I32(longs().map(i32::from_be_bytes).collect()),
        (4, false, false) => DecodingResult::U32(longs().map(u32::from_be_bytes).collect()),
        _ => return Err("its numbers are of a kind that is not read".to_owned()),
    })
}

/// Bytes that room is made for at first.
const STEP: usize = 64 * 1024;

fn decode(packed: &[u8], wanted: usize) -> Result<Vec<u8>, String> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
    let (mut raw, mut done, mut rest) = (Vec::new(), 0, packed);
    while done < wanted {
        if done == raw.len() {
            // Room is made as bytes come: a short piece that claims much gets little.
            raw.resize(wanted.min((done * 2).max(STEP)), 0);
        }
        let step = decoder.decode_bytes(rest, &mut raw[done..]);
        done += step.consumed_out;
        rest = &rest[step.consumed_in..];
        let is_stuck = step.consumed_in == 0 && step.consumed_out == 0;
        match step.status {
            _ if done == wanted => {}
            Ok(LzwStatus::Ok | LzwStatus::NoProgress) if !is_stuck => {}
            _ if done == raw.len() => {}
            Err(error) => return Err(format!("a piece of it is broken: {error}")),
            Ok(_) => return Err("a piece of it was cut short".to_owned()),
        }
    }
    Ok(raw)
}

fn add_differences(row: &mut [u8], layout: Layout) {
    let step = layout.samples * layout.bytes;
    let is_big = layout.is_big_endian;
    for at in (step..row.len()).step_by(layout.bytes) {
        match layout.bytes {
            1 => row[at] = row[at].wrapping_add(row[at - step]),
            2 => {
                let read = |at: usize| {
                    let two = [row[at], row[at + 1]];
                    if is_big { u16::from_be_bytes(two) } else { u16::from_le_bytes(two) }
                };
                let sum = read(at).wrapping_add(read(at - step));
                row[at..at + 2].copy_from_slice(&if is_big { sum.to_be_bytes() } else { sum.to_le_bytes() });
            }
            _ => {
                let read = |at: usize| {
                    let four = [row[at], row[at + 1], row[at + 2], row[at + 3]];
                    if is_big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) }
                };
                let sum = read(at).wrapping_add(read(at - step));
                row[at..at + 4].copy_from_slice(&if is_big { sum.to_be_bytes() } else { sum.to_le_bytes() });
            }
        }
    }
}

/// Differences from byte to byte; then all first bytes, all second ones and so on become numbers again.
fn join_planes(row: &mut [u8], layout: Layout) {
    for at in layout.samples..row.len() {
        row[at] = row[at].wrapping_add(row[at - layout.samples]);
    }
    let count = row.len() / layout.bytes;
    let planes = row.to_vec();
    for (number, bytes) in row.chunks_exact_mut(layout.bytes).enumerate() {
        for (plane, byte) in bytes.iter_mut().enumerate() {
            *byte = planes[plane * count + number];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(bytes: usize, predictor: u32, is_float: bool) -> Layout {
        let is_signed = false;
        let (is_big_endian, is_tiled) = (false, true);
        Layout { width: 4, height: 2, samples: 1, bytes, is_float, is_signed, predictor, is_big_endian, is_tiled }
    }

    fn pack(raw: &[u8]) -> Vec<u8> {
        weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(raw).expect("packed")
    }

    fn text(found: Result<DecodingResult, String>) -> String {
        format!("{found:?}")
    }

    #[test]
    fn numbers_come_back_whatever_predicted_them() {
        let plain = pack(&[1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(
            text(unpack(&plain, layout(1, 1, false), 3, 2)),
            text(Ok(DecodingResult::U8(vec![1, 2, 3, 5, 6, 7])))
        );
        assert_eq!(text(unpack(&plain, layout(1, 2, false), 4, 1)), text(Ok(DecodingResult::U8(vec![1, 3, 6, 10]))));
        let words = pack(&[0, 1, 1, 0, 255, 255, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0]);
        let found = unpack(&words, layout(2, 2, false), 4, 1);
        assert_eq!(text(found), text(Ok(DecodingResult::U16(vec![256, 257, 256, 256]))));
        // 1.5, 2.0, −1.0, 0.25: planes of bytes, highest first, each byte as its difference.
        let mut planes: Vec<u8> = Vec::new();
        let numbers = [1.5_f32, 2.0, -1.0, 0.25];
        for plane in 0..4 {
            planes.extend(numbers.iter().map(|number| number.to_be_bytes()[plane]));
        }
        let mut row: Vec<u8> = planes.clone();
        for at in (1..row.len()).rev() {
            row[at] = planes[at].wrapping_sub(planes[at - 1]);
        }
        let packed = pack(&[row.clone(), row].concat());
        assert_eq!(text(unpack(&packed, layout(4, 3, true), 4, 1)), text(Ok(DecodingResult::F32(numbers.to_vec()))));
    }

    #[test]
    fn an_end_code_is_not_needed_and_all_bytes_are() {
        let packed = pack(&[7; 8]);
        let without = &packed[..packed.len() - 1];
        assert_eq!(text(unpack(without, layout(1, 1, false), 4, 2)), text(Ok(DecodingResult::U8(vec![7; 8]))));
        assert!(unpack(&packed[..2], layout(1, 1, false), 4, 2).is_err());
        assert!(unpack(&[0xff; 40], layout(1, 1, false), 4, 2).is_err());
    }
}
