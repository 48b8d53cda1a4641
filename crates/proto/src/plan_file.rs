//! The plan files that ArduPilot serves over MAVFTP: `@MISSION/mission.dat`, `fence.dat` and `rally.dat`.
//!
//! A header of five little-endian u16 (magic 0x763d, `MAV_MISSION_TYPE`, options, first seq, count), then one packed
//! 38-byte MISSION_ITEM_INT per item. ArduPilot refuses an uploaded file whose length does not fit its count or that
//! holds an item of zeros only: an item that was never written.

use crate::wire::MissionItemInt;

/// Bytes of the header.
pub const PLAN_FILE_HEADER_LEN: usize = 10;
/// Bytes of one item.
pub const PLAN_FILE_ITEM_LEN: usize = MissionItemInt::PACKED_LEN;
const MAGIC: u16 = 0x763d;

/// Why a plan file could not be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanFileError {
    /// Shorter than a header.
    #[error("plan file has {len} bytes, less than its header of {PLAN_FILE_HEADER_LEN}")]
    NoHeader {
        /// Length found.
        len: usize,
    },
    /// Not a plan file.
    #[error("plan file starts with {magic:#06x} instead of 0x763d")]
    BadMagic {
        /// First two bytes.
        magic: u16,
    },
    /// Length and count disagree.
    #[error("plan file says {count} items, which is {expected} bytes, but has {len}")]
    BadLength {
        /// Items by the header.
        count: u16,
        /// Length that the count asks for.
        expected: usize,
        /// Length found.
        len: usize,
    },
}

/// The header of a plan file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanFileHeader {
    /// `MAV_MISSION_TYPE`.
    pub mission_type: u16,
    /// Bit 0: do not clear the plan first.
    pub options: u16,
    /// Seq of the first item in the file.
    pub first: u16,
    /// Number of items in the file.
    pub count: u16,
}

impl PlanFileHeader {
    /// Reads the header at the front of a file.
    ///
    /// # Errors
    /// [`PlanFileError::NoHeader`] or [`PlanFileError::BadMagic`].
    pub fn decode(bytes: &[u8]) -> Result<Self, PlanFileError> {
        let Some(header) = bytes.get(..PLAN_FILE_HEADER_LEN) else {
            return Err(PlanFileError::NoHeader { len: bytes.len() });
        };
        let field = |index: usize| u16::from_le_bytes([header[2 * index], header[2 * index + 1]]);
        if field(0) != MAGIC {
            return Err(PlanFileError::BadMagic { magic: field(0) });
        }
        Ok(Self { mission_type: field(1), options: field(2), first: field(3), count: field(4) })
    }

    /// The header's bytes.
    pub fn encode(&self) -> [u8; PLAN_FILE_HEADER_LEN] {
        let mut bytes = [0u8; PLAN_FILE_HEADER_LEN];
        let fields = [MAGIC, self.mission_type, self.options, self.first, self.count];
        for (slot, field) in bytes.chunks_exact_mut(2).zip(fields) {
            slot.copy_from_slice(&field.to_le_bytes());
        }
        bytes
    }

    /// Length of the whole file, bytes.
    pub fn file_len(&self) -> usize {
        PLAN_FILE_HEADER_LEN + usize::from(self.count) * PLAN_FILE_ITEM_LEN
    }
}

/// Writes a whole plan file.
///
/// The items' address, seq and kind are written as they are; more than 65,535 items do not fit and are cut.
pub fn encode_plan_file(mission_type: u8, items: &[MissionItemInt]) -> Vec<u8> {
    let items = &items[..items.len().min(usize::from(u16::MAX))];
    let header =
        PlanFileHeader { mission_type: u16::from(mission_type), options: 0, first: 0, count: items.len() as u16 };
    let mut bytes = Vec::with_capacity(header.file_len());
    bytes.extend_from_slice(&header.encode());
    for item in items {
        bytes.extend_from_slice(&item.to_packed());
    }
    bytes
}

/// Reads a whole plan file.
///
/// # Errors
/// [`PlanFileError`] when it is not a plan file, or when its length does not match its count.
pub fn decode_plan_file(bytes: &[u8]) -> Result<(PlanFileHeader, Vec<MissionItemInt>), PlanFileError> {
    let header = PlanFileHeader::decode(bytes)?;
    if bytes.len() != header.file_len() {
        return Err(PlanFileError::BadLength { count: header.count, expected: header.file_len(), len: bytes.len() });
    }
    let items =
        bytes[PLAN_FILE_HEADER_LEN..].chunks_exact(PLAN_FILE_ITEM_LEN).map(MissionItemInt::from_payload).collect();
    Ok((header, items))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `tests/fixtures/captures/mission.dat`: uploaded to a real ArduPlane.
    const GOLDEN: &[u8] = include_bytes!("../../../tests/fixtures/captures/mission.dat");

    #[test]
    fn a_file_taken_by_a_real_arduplane_reads_and_writes_byte_for_byte() {
        let (header, items) = decode_plan_file(GOLDEN).expect("a plan file");
        assert_eq!(header, PlanFileHeader { mission_type: 0, options: 0, first: 0, count: 12 });
        assert_eq!(items.len(), 12);
        assert_eq!((items[0].x, items[0].y, items[0].z), (403_332_000, -37_978_000, 600.0));
        assert_eq!((items[11].seq, items[11].command), (11, 21));
        assert_eq!(encode_plan_file(0, &items), GOLDEN);
    }

    #[test]
    fn wrong_files_are_named() {
        assert_eq!(decode_plan_file(&GOLDEN[..9]), Err(PlanFileError::NoHeader { len: 9 }));
        let len = GOLDEN.len();
        let short = decode_plan_file(&GOLDEN[..len - 1]);
        assert_eq!(short, Err(PlanFileError::BadLength { count: 12, expected: len, len: len - 1 }));
        let mut other = GOLDEN.to_vec();
        other[0] = 0;
        assert_eq!(decode_plan_file(&other), Err(PlanFileError::BadMagic { magic: 0x7600 }));
    }

    proptest! {
        // fault 53 (256 cases): any bytes as a MAVFTP plan file
        #[test]
        fn any_bytes_decode_or_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let _ = decode_plan_file(&bytes);
        }

        #[test]
        fn whole_items_survive(raw in proptest::collection::vec(any::<[u8; 32]>(), 0..20)) {
            let items: Vec<_> = raw.iter().map(|bytes| MissionItemInt::from_payload(bytes)).collect();
            let file = encode_plan_file(1, &items);
            let (header, again) = decode_plan_file(&file).expect("our own file");
            prop_assert_eq!(usize::from(header.count), items.len());
            // Compared as bytes: a NaN is kept bit for bit, but is not equal to itself.
            prop_assert_eq!(encode_plan_file(1, &again), file);
        }
    }
}
