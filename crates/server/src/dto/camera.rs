//! Cameras.

use serde::Serialize;
use utoipa::ToSchema;

use vencejo_video::{Camera, CameraRecording, CameraState, VideoCodec};

/// A camera.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CameraInfo {
    /// Name, as used in the camera's paths.
    pub name: String,
    /// Source of its images, without passwords.
    pub source: String,
    /// State of the image stream.
    pub state: CameraState,
    /// Why no images arrive, in English; null when they do.
    #[schema(required = true)]
    pub reason: Option<String>,
    /// Codec of the source; null when unknown, or when the images are encoded by this server.
    #[schema(required = true)]
    pub codec: Option<VideoCodec>,
    /// Image width, pixels.
    #[schema(required = true)]
    pub width: Option<u16>,
    /// Image height, pixels.
    #[schema(required = true)]
    pub height: Option<u16>,
    /// Recent frame rate.
    #[schema(required = true)]
    pub rate_hz: Option<f64>,
    /// Recent bit rate of the source.
    #[schema(required = true)]
    pub bitrate_bit_s: Option<f64>,
    /// Age of the newest image.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Number of viewers.
    pub viewers: u32,
    /// Recording in progress, or the last one if it ended with a fault.
    #[schema(required = true)]
    pub recording: Option<CameraRecording>,
}

impl CameraInfo {
    /// State of a camera at a time of day, microseconds since 1970.
    pub fn of(camera: &Camera, now_unix_us: u64) -> Self {
        let status = camera.status();
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Self {
            name: camera.name().to_owned(),
            source: camera.source().to_owned(),
            state: status.state,
            reason: status.reason,
            codec: status.codec,
            width: status.size.map(|(width, _)| width),
            height: status.size.map(|(_, height)| height),
            rate_hz: finite(status.rate_hz),
            bitrate_bit_s: finite(status.bitrate_bit_s),
            age_s: camera.newest_unix_us().map(|at| now_unix_us.saturating_sub(at) as f64 / 1e6),
            viewers: u32::try_from(camera.viewers()).unwrap_or(u32::MAX),
            recording: status.recording.map(|recording| CameraRecording {
                duration_s: finite(Some(recording.duration_s)).unwrap_or_default(),
                ..recording
            }),
        }
    }
}

/// Text messages on a camera's stream, beside the images.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum CameraMessage {
    /// State of the camera: on change, and once a second.
    Camera(CameraInfo),
    /// Server time, once a second, from which clients compute the age of an image.
    Clock {
        /// Microseconds since 1970, UTC.
        unix_us: u64,
    },
}
