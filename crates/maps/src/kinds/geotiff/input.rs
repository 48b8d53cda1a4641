//! Input of a TIFF, and the decoder of one of its images.

use std::io::{self, BufReader, Read, Seek};

use tiff::decoder::{Decoder, Limits};
use tiff::tags::Tag;

/// Bytes of one piece at most: packed, unpacked and as colours or numbers.
pub(super) const MAX_PIECE: usize = 48 * 1024 * 1024;

/// Input of a TIFF.
pub(crate) trait Input: Read + Seek + Send {}

impl<T: Read + Seek + Send> Input for T {}

/// Opens what a TIFF is read from, once for each of its images.
pub(crate) type OpenInput = Box<dyn Fn() -> io::Result<Box<dyn Input>> + Send + Sync>;

pub(super) type TiffDecoder = Decoder<BufReader<Box<dyn Input>>>;

/// A decoder of one of its images.
pub(super) fn decoder(input: &OpenInput, image: usize) -> Result<TiffDecoder, String> {
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

pub(super) fn doubles(decoder: &mut TiffDecoder, tag: u16) -> Option<Vec<f64>> {
    decoder.get_tag_f64_vec(Tag::Unknown(tag)).ok()
}
