//! The encodings in which pictures go to the viewers.

/// How a picture is encoded on its way to the viewers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Codec {
    /// H.264 as a byte stream (ITU-T H.264 annex B), one access unit a frame; key frames bring their parameter sets.
    H264,
    /// One JPEG picture a frame.
    Jpeg,
}

impl Codec {
    /// The number that stands for it in a frame's header.
    pub(super) fn number(self) -> u8 {
        match self {
            Self::H264 => 1,
            Self::Jpeg => 2,
        }
    }
}
