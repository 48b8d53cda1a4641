//! The checksum of a frame: CRC-16/MCRF4XX over everything after the start mark, then the message's seed
//! (mavlink.io, "Packet Serialization", checksum and CRC_EXTRA).

use crc::{CRC_16_MCRF4XX, Crc, Table};

static CRC: Crc<u16, Table<16>> = Crc::<u16, Table<16>>::new(&CRC_16_MCRF4XX);

/// The checksum of `bytes` (header without start mark, and payload) with the seed of the message.
#[inline]
pub(crate) fn checksum(bytes: &[u8], extra_crc: u8) -> u16 {
    let mut digest = CRC.digest();
    digest.update(bytes);
    digest.update(&[extra_crc]);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_generated_dialect() {
        let bytes: Vec<u8> = (0..=255).collect();
        for len in [0, 1, 15, 16, 17, 64, 255] {
            assert_eq!(checksum(&bytes[..len], 152), mavlink::calculate_crc(&bytes[..len], 152), "{len} bytes");
        }
    }
}
