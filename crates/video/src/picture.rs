//! An image: its codec, and its wire format to viewers.

use bytes::Bytes;

/// Largest frame, bytes: more than any sensible image.
pub const MAX_FRAME_BYTES: usize = 16 * 1024 * 1024;

/// Codec of a camera's images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(rename_all = "snake_case"))]
pub enum VideoCodec {
    /// H.264 byte stream (ITU-T H.264 annex B), one access unit per image; key frames contain their parameter sets.
    H264,
    /// JPEG images.
    Jpeg,
}

impl VideoCodec {
    /// Code of the codec in an image's header.
    fn number(self) -> u8 {
        match self {
            Self::H264 => 1,
            Self::Jpeg => 2,
        }
    }
}

/// Codecs that a viewer can decode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accepts {
    /// H.264; otherwise images are sent as JPEG, which every viewer can decode.
    pub h264: bool,
}

/// An encoded image.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Codec.
    pub codec: VideoCodec,
    /// Whether it can be decoded without previous images.
    pub is_key: bool,
    /// Width, pixels.
    pub width: u16,
    /// Height, pixels.
    pub height: u16,
    /// Time of capture: microseconds since 1970, UTC.
    pub captured_unix_us: u64,
    /// Encoded data.
    pub data: &'a [u8],
}

/// Size of the header before each image, bytes.
pub const HEADER_BYTES: usize = 20;

/// An image in its wire format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WireFrame {
    /// Codec.
    pub codec: VideoCodec,
    /// Whether it can be decoded without previous images.
    pub is_key: bool,
    /// Header and encoded data. All numbers of the header are little-endian: version (1 byte, is 1), codec (1 byte: 1
    /// H.264, 2 JPEG), flags (1 byte: bit 0 key), 0, width and height (2 bytes each), time of capture (8 bytes,
    /// microseconds since 1970), number of the image (4 bytes).
    pub bytes: Bytes,
}

impl WireFrame {
    pub(crate) fn new(picture: &Picture<'_>, number: u32) -> Self {
        let Picture { codec, is_key, width, height, captured_unix_us, data } = *picture;
        let mut bytes = Vec::with_capacity(HEADER_BYTES + data.len());
        bytes.extend([1, codec.number(), u8::from(is_key), 0]);
        bytes.extend(width.to_le_bytes());
        bytes.extend(height.to_le_bytes());
        bytes.extend(captured_unix_us.to_le_bytes());
        bytes.extend(number.to_le_bytes());
        bytes.extend(data);
        Self { codec, is_key, bytes: bytes.into() }
    }
}

/// H.264 images since the last key frame, with which the next viewer begins; empty when that is too long ago.
#[derive(Debug, Default)]
pub(crate) struct Group {
    frames: Vec<WireFrame>,
    bytes: usize,
}

impl Group {
    const MAX_FRAMES: usize = 600;
    const MAX_BYTES: usize = 8 * 1024 * 1024;

    pub(crate) fn push(&mut self, frame: &WireFrame) {
        if frame.is_key {
            self.clear();
        } else if self.frames.is_empty() {
            return;
        }
        self.bytes += frame.bytes.len();
        self.frames.push(frame.clone());
        if self.frames.len() > Self::MAX_FRAMES || self.bytes > Self::MAX_BYTES {
            self.clear();
        }
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn frames(&self) -> Vec<WireFrame> {
        self.frames.clone()
    }
}
