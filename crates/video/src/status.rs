//! What a feeder reports of its camera.

use crate::picture::VideoCodec;

/// The state of a camera, as its feeder reports it.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraStatus {
    /// Whether pictures come.
    pub state: CameraState,
    /// Why they do not, in English.
    pub reason: Option<String>,
    /// How the source itself encodes; `None` before the first picture, and for pictures that are not encoded.
    pub codec: Option<VideoCodec>,
    /// Pixels of the newest picture.
    pub size: Option<(u16, u16)>,
    /// Pictures a second, lately.
    pub rate_hz: Option<f64>,
    /// Bits a second, lately.
    pub bitrate_bit_s: Option<f64>,
    /// The recording under way, or the one that a fault ended.
    pub recording: Option<CameraRecording>,
}

impl Default for CameraStatus {
    fn default() -> Self {
        Self {
            state: CameraState::Starting,
            reason: None,
            codec: None,
            size: None,
            rate_hz: None,
            bitrate_bit_s: None,
            recording: None,
        }
    }
}

/// Whether a camera's pictures come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(rename_all = "snake_case"))]
pub enum CameraState {
    /// The source is read on demand, and nobody looks or records.
    Standby,
    /// On the way to the first picture.
    Starting,
    /// They come.
    Live,
    /// The source is there, but nothing comes.
    Stalled,
    /// The source is not there; it is tried again for ever.
    Dead,
}

/// A recording of a camera.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct CameraRecording {
    /// Name of the file, in the data folder of the machine that the camera is at.
    pub file: String,
    /// How long it is.
    pub duration_s: f64,
    /// How large it is.
    pub bytes: u64,
    /// Why it ended before it was told to, in English; null while it is being written.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub problem: Option<String>,
}
