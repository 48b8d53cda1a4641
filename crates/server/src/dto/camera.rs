//! Cameras on the wire.

use serde::Serialize;
use utoipa::ToSchema;

use vencejo_video::{Camera, CameraRecording, CameraState, VideoCodec};

/// A camera.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CameraInfo {
    /// Its name, which its paths hold.
    pub name: String,
    /// Where its pictures come from, without passwords.
    pub source: String,
    /// Whether they come.
    pub state: CameraState,
    /// Why they do not, in English.
    #[schema(required = true)]
    pub reason: Option<String>,
    /// How the source encodes; null when that is not known yet, or when its pictures are encoded here.
    #[schema(required = true)]
    pub codec: Option<VideoCodec>,
    /// Pixels.
    #[schema(required = true)]
    pub width: Option<u16>,
    /// Pixels.
    #[schema(required = true)]
    pub height: Option<u16>,
    /// Pictures a second, lately.
    #[schema(required = true)]
    pub rate_hz: Option<f64>,
    /// Bits a second from the source, lately.
    #[schema(required = true)]
    pub bitrate_bit_s: Option<f64>,
    /// Age of the newest picture.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// How many look.
    pub viewers: u32,
    /// The recording under way, or the last if a fault ended it.
    #[schema(required = true)]
    pub recording: Option<CameraRecording>,
}

impl CameraInfo {
    /// What a camera is at a time of day.
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

/// What the server says on a camera's stream, beside its pictures.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum CameraMessage {
    /// How the camera is: when that changes, and each second.
    Camera(CameraInfo),
    /// What the time is at the server, so that the age of a picture can be told: each second.
    Clock {
        /// Microseconds since 1970, UTC.
        unix_us: u64,
    },
}
