//! Cameras for Python: hands encoded pictures to the server, and its requests to Python.

use std::sync::Mutex;
use std::sync::PoisonError;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use vencejo_video::{
    CameraError, CameraRecording, CameraRequest, CameraState, CameraStatus, PendingRequest, Picture, VideoCodec,
    VideoFeed,
};

use crate::{errors, runtime};

/// Adds this module's classes.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyVideoFeed>()?;
    module.add_class::<PyVideoRequest>()
}

/// The Python exception for an error of a camera.
pub fn raise(error: &CameraError) -> PyErr {
    let kind = match error {
        CameraError::Gone => "ClosedError",
        CameraError::BadName(_) | CameraError::Taken(_) | CameraError::BadPicture(_) => "InvalidRequest",
        _ => "VencejoError",
    };
    errors::raise(kind, error)
}

fn invalid(text: String) -> PyErr {
    errors::raise("InvalidRequest", text)
}

fn codec(name: &str) -> PyResult<VideoCodec> {
    match name {
        "h264" => Ok(VideoCodec::H264),
        "jpeg" => Ok(VideoCodec::Jpeg),
        _ => Err(invalid(format!("codec is '{name}': it is h264 or jpeg"))),
    }
}

/// Microseconds since 1970 of seconds since 1970.
fn unix_us(unix_s: f64) -> PyResult<u64> {
    if !(0.0..1e11).contains(&unix_s) {
        return Err(invalid(format!("captured_unix_s is {unix_s}: it is in seconds since 1970")));
    }
    Ok((unix_s * 1e6).round() as u64)
}

/// Feeds one camera.
#[pyclass(frozen, name = "VideoFeed", module = "vencejo._native")]
pub struct PyVideoFeed {
    feed: VideoFeed,
}

impl PyVideoFeed {
    /// The feed of a camera that was just added.
    pub fn new(feed: VideoFeed) -> Self {
        Self { feed }
    }
}

#[pymethods]
impl PyVideoFeed {
    fn publish(
        &self,
        data: &[u8],
        codec: &str,
        is_key: bool,
        width: u16,
        height: u16,
        captured_unix_s: f64,
    ) -> PyResult<()> {
        let (codec, captured_unix_us) = (self::codec(codec)?, unix_us(captured_unix_s)?);
        // Copies the code once and waits for nobody: too short to give the GIL away for.
        let picture = Picture { codec, is_key, width, height, captured_unix_us, data };
        self.feed.publish(&picture).map_err(|error| raise(&error))
    }

    #[allow(clippy::too_many_arguments, reason = "the fields of one status")]
    fn set_status(
        &self,
        state: &str,
        reason: Option<String>,
        codec: Option<&str>,
        size: Option<(u16, u16)>,
        rate_hz: Option<f64>,
        bitrate_bit_s: Option<f64>,
        recording: Option<(String, f64, u64, Option<String>)>,
    ) -> PyResult<()> {
        let state = match state {
            "standby" => CameraState::Standby,
            "starting" => CameraState::Starting,
            "live" => CameraState::Live,
            "stalled" => CameraState::Stalled,
            "dead" => CameraState::Dead,
            _ => return Err(invalid(format!("state is '{state}': it is standby, starting, live, stalled or dead"))),
        };
        let codec = codec.map(self::codec).transpose()?;
        let recording =
            recording.map(|(file, duration_s, bytes, problem)| CameraRecording { file, duration_s, bytes, problem });
        self.feed.set_status(CameraStatus { state, reason, codec, size, rate_hz, bitrate_bit_s, recording });
        Ok(())
    }

    /// Numbers of viewers that are sent H.264, and JPEG.
    fn demand(&self) -> (usize, usize) {
        let demand = self.feed.demand();
        (demand.h264, demand.jpeg)
    }

    /// The next request; `None` in `timeout_s`, or when viewers came.
    fn next_request(&self, py: Python<'_>, timeout_s: f64) -> PyResult<Option<PyVideoRequest>> {
        let next = async {
            tokio::select! {
                biased;
                request = self.feed.next_request() => Some(request),
                () = self.feed.demand_changed() => None,
            }
        };
        match runtime::wait(py, Some(runtime::timeout(timeout_s)?), next)?.flatten() {
            Some(Some(request)) => Ok(Some(PyVideoRequest { request: Mutex::new(Some(request)) })),
            Some(None) => Err(raise(&CameraError::Gone)),
            None => Ok(None),
        }
    }

    fn close(&self) {
        self.feed.close();
    }
}

/// Something that a browser wants of a camera.
#[pyclass(frozen, name = "VideoRequest", module = "vencejo._native")]
pub struct PyVideoRequest {
    request: Mutex<Option<PendingRequest>>,
}

#[pymethods]
impl PyVideoRequest {
    #[getter]
    fn kind(&self) -> Option<&'static str> {
        let request = self.request.lock().unwrap_or_else(PoisonError::into_inner);
        request.as_ref().map(|pending| match pending.request {
            CameraRequest::Snapshot => "snapshot",
            CameraRequest::KeepSnapshot => "keep_snapshot",
            CameraRequest::StartRecording => "start_recording",
            CameraRequest::StopRecording => "stop_recording",
        })
    }

    fn answer(&self, data: &Bound<'_, PyBytes>) {
        self.end(Ok(data.as_bytes().to_vec()));
    }

    fn refuse(&self, reason: String) {
        self.end(Err(reason));
    }
}

impl PyVideoRequest {
    fn end(&self, answer: Result<Vec<u8>, String>) {
        let request = self.request.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(request) = request {
            request.answer(answer);
        }
    }
}
