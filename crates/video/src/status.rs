//! Reports of a camera's feeder.

use crate::picture::VideoCodec;

/// State of a camera, as reported by its feeder.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraStatus {
    /// State of the image stream.
    pub state: CameraState,
    /// Why no images arrive, in English.
    pub reason: Option<String>,
    /// Codec of the source; `None` before the first image, and for sources without encoding.
    pub codec: Option<VideoCodec>,
    /// Size of the newest image, pixels.
    pub size: Option<(u16, u16)>,
    /// Recent frame rate.
    pub rate_hz: Option<f64>,
    /// Recent bit rate.
    pub bitrate_bit_s: Option<f64>,
    /// Recording in progress, or the last one if it ended with a fault.
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

/// State of a camera's image stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(rename_all = "snake_case"))]
pub enum CameraState {
    /// The source is read on demand, and there are no viewers or recordings.
    Standby,
    /// Waiting for the first image.
    Starting,
    /// Images arrive.
    Live,
    /// The source is connected, but no images arrive.
    Stalled,
    /// The source is not available; connecting is retried forever.
    Dead,
}

/// A recording of a camera.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct CameraRecording {
    /// File name, in the data folder of the machine to which the camera is connected.
    pub file: String,
    /// Duration.
    pub duration_s: f64,
    /// File size.
    pub bytes: u64,
    /// Why it ended unexpectedly, in English; null while it is being recorded.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub problem: Option<String>,
}
