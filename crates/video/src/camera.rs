//! One camera, as its viewers see it: its state, the newest images for new viewers, and the queue of each viewer.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use tokio::sync::{Notify, mpsc};

use crate::error::CameraError;
use crate::picture::{Accepts, Group, MAX_FRAME_BYTES, Picture, VideoCodec, WireFrame};
use crate::queue::ViewerQueue;
use crate::request::{CameraRequest, PendingRequest};
use crate::status::CameraStatus;

/// Number of viewers by codec.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Demand {
    /// Viewers that are sent H.264.
    pub h264: usize,
    /// Viewers that are sent JPEG.
    pub jpeg: usize,
}

/// One camera, as its viewers see it.
#[derive(Debug)]
pub struct Camera {
    name: String,
    source: String,
    state: Mutex<State>,
    requests: mpsc::Sender<PendingRequest>,
    /// Notified when viewers or their codecs change.
    demand_changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    status: CameraStatus,
    viewers: Vec<(Accepts, Weak<ViewerQueue>)>,
    /// H.264 images for the next viewer.
    group: Group,
    /// Newest JPEG image for the next viewer.
    still: Option<WireFrame>,
    newest_unix_us: Option<u64>,
    pictures: u32,
    is_gone: bool,
}

impl State {
    fn sent_to(&self, accepts: Accepts) -> VideoCodec {
        if accepts.h264 && self.status.codec == Some(VideoCodec::H264) { VideoCodec::H264 } else { VideoCodec::Jpeg }
    }

    fn viewers(&mut self) -> Vec<(Accepts, Arc<ViewerQueue>)> {
        self.viewers.retain(|(_, viewer)| viewer.strong_count() > 0);
        self.viewers.iter().filter_map(|(accepts, viewer)| Some((*accepts, viewer.upgrade()?))).collect()
    }

    fn keep(&mut self, frame: &WireFrame) {
        match frame.codec {
            VideoCodec::Jpeg => self.still = Some(frame.clone()),
            VideoCodec::H264 => self.group.push(frame),
        }
    }

    /// Drops what cannot be shown before images of another codec.
    fn begin_codec(&mut self, codec: Option<VideoCodec>) {
        // The first images may have arrived before their codec was reported.
        if codec != Some(VideoCodec::H264) {
            self.group.clear();
        }
        if codec != Some(VideoCodec::Jpeg) {
            self.still = None;
        }
        if codec == Some(VideoCodec::H264) {
            for (accepts, viewer) in self.viewers() {
                if accepts.h264 {
                    viewer.begin(self.group.frames());
                }
            }
        }
    }
}

impl Camera {
    /// Name of the camera.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Source of its images.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// State, as last reported by its feeder.
    pub fn status(&self) -> CameraStatus {
        self.lock().status.clone()
    }

    /// Time of capture of the newest image: microseconds since 1970.
    pub fn newest_unix_us(&self) -> Option<u64> {
        self.lock().newest_unix_us
    }

    /// Number of viewers.
    pub fn viewers(&self) -> usize {
        self.lock().viewers().len()
    }

    /// Number of viewers by codec.
    pub fn demand(&self) -> Demand {
        let mut state = self.lock();
        let mut demand = Demand::default();
        for (accepts, _) in state.viewers() {
            match state.sent_to(accepts) {
                VideoCodec::H264 => demand.h264 += 1,
                VideoCodec::Jpeg => demand.jpeg += 1,
            }
        }
        demand
    }

    /// Adds a viewer, whose queue contains everything that can be shown at once. The viewer leaves when the queue is
    /// dropped.
    pub fn watch(&self, accepts: Accepts) -> Arc<ViewerQueue> {
        let mut state = self.lock();
        let queue = Arc::new(ViewerQueue::default());
        match state.sent_to(accepts) {
            VideoCodec::H264 => queue.begin(state.group.frames()),
            VideoCodec::Jpeg => queue.begin(state.still.iter().cloned().collect()),
        }
        if state.is_gone {
            queue.end();
        }
        state.viewers.push((accepts, Arc::downgrade(&queue)));
        drop(state);
        self.demand_changed.notify_one();
        queue
    }

    /// Sends a request to the feeder.
    ///
    /// # Errors
    /// [`CameraError::Gone`], [`CameraError::Busy`], and the feeder's own reason: [`CameraError::Refused`].
    pub async fn ask(&self, request: CameraRequest) -> Result<Vec<u8>, CameraError> {
        if self.lock().is_gone {
            return Err(CameraError::Gone);
        }
        let (request, answered) = PendingRequest::new(request);
        self.requests.try_send(request).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => CameraError::Busy,
            mpsc::error::TrySendError::Closed(_) => CameraError::Gone,
        })?;
        match answered.await {
            Ok(answer) => answer.map_err(CameraError::Refused),
            Err(_) => Err(CameraError::Gone),
        }
    }

    /// A camera without images, whose requests are sent to `requests`.
    pub(crate) fn new(name: &str, source: &str, requests: mpsc::Sender<PendingRequest>) -> Self {
        Self {
            name: name.to_owned(),
            source: source.to_owned(),
            state: Mutex::default(),
            requests,
            demand_changed: Notify::new(),
        }
    }

    /// Distributes an image to all viewers of its codec.
    pub(crate) fn publish(&self, picture: &Picture<'_>) -> Result<(), CameraError> {
        if picture.data.is_empty() || picture.data.len() > MAX_FRAME_BYTES {
            return Err(CameraError::BadPicture(picture.data.len()));
        }
        let mut state = self.lock();
        if state.is_gone {
            return Err(CameraError::Gone);
        }
        state.pictures = state.pictures.wrapping_add(1);
        let frame = WireFrame::new(picture, state.pictures);
        state.newest_unix_us = Some(picture.captured_unix_us);
        state.keep(&frame);
        for (accepts, viewer) in state.viewers() {
            if state.sent_to(accepts) == picture.codec {
                viewer.push(frame.clone());
            }
        }
        Ok(())
    }

    /// Sets the state reported by its feeder; viewers are notified if it changed.
    pub(crate) fn set_status(&self, status: CameraStatus) {
        let mut state = self.lock();
        if state.status == status {
            return;
        }
        if state.status.codec != status.codec {
            state.begin_codec(status.codec);
        }
        state.status = status;
        for (_, viewer) in state.viewers() {
            viewer.note_status();
        }
        drop(state);
        self.demand_changed.notify_one();
    }

    /// Waits until viewers or their codecs change.
    pub(crate) async fn demand_changed(&self) {
        self.demand_changed.notified().await;
    }

    /// Marks the end of the images.
    pub(crate) fn end(&self) {
        let mut state = self.lock();
        state.is_gone = true;
        for (_, viewer) in state.viewers() {
            viewer.end();
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
