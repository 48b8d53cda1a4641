//! Cameras on the wire.

use serde::Serialize;
use utoipa::ToSchema;

use crate::video::{Camera, CameraState as State, Codec, RecordingStatus, footage};

/// Whether a camera's pictures come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
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

/// How a camera encodes its pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum VideoCodec {
    /// H.264.
    H264,
    /// JPEG pictures.
    Jpeg,
}

/// A recording of a camera.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CameraRecording {
    /// Name of the file, in the data folder of the machine that the camera is at.
    pub file: String,
    /// How long it is.
    pub duration_s: f64,
    /// How large it is.
    pub bytes: u64,
    /// Why it ended before it was told to, in English; null while it is being written.
    #[schema(required = true)]
    pub problem: Option<String>,
}

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
            state: match status.state {
                State::Standby => CameraState::Standby,
                State::Starting => CameraState::Starting,
                State::Live => CameraState::Live,
                State::Stalled => CameraState::Stalled,
                State::Dead => CameraState::Dead,
            },
            reason: status.reason,
            codec: status.codec.map(|codec| match codec {
                Codec::H264 => VideoCodec::H264,
                Codec::Jpeg => VideoCodec::Jpeg,
            }),
            width: status.size.map(|(width, _)| width),
            height: status.size.map(|(_, height)| height),
            rate_hz: finite(status.rate_hz),
            bitrate_bit_s: finite(status.bitrate_bit_s),
            age_s: camera.newest_unix_us().map(|at| now_unix_us.saturating_sub(at) as f64 / 1e6),
            viewers: u32::try_from(camera.viewers()).unwrap_or(u32::MAX),
            recording: status.recording.map(|RecordingStatus { file, duration_s, bytes, problem }| CameraRecording {
                file,
                duration_s: if duration_s.is_finite() { duration_s } else { 0.0 },
                bytes,
                problem,
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

/// What a file of footage holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FootageKind {
    /// A recording: Matroska.
    Video,
    /// A still picture: JPEG.
    Picture,
}

impl From<footage::FootageKind> for FootageKind {
    fn from(kind: footage::FootageKind) -> Self {
        match kind {
            footage::FootageKind::Video => Self::Video,
            footage::FootageKind::Picture => Self::Picture,
        }
    }
}

/// A recording or picture of a camera on the server's disk.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Footage {
    /// The file's name.
    pub name: String,
    /// What it holds.
    pub kind: FootageKind,
    /// The camera's name.
    pub camera: String,
    /// When it was begun or taken, to the second: seconds since 1970, UTC.
    pub begin_unix_s: u64,
    /// How long a recording is; null for pictures, while it is being written, and when it was not ended in order.
    #[schema(required = true)]
    pub duration_s: Option<f64>,
    /// How large it is.
    pub bytes: u64,
    /// Whether it is being written.
    pub is_current: bool,
}

impl From<footage::Footage> for Footage {
    fn from(found: footage::Footage) -> Self {
        let footage::Footage { name, kind, camera, begin_unix_s, duration_s, bytes, is_current } = found;
        Self { name, kind: kind.into(), camera, begin_unix_s, duration_s, bytes, is_current }
    }
}
