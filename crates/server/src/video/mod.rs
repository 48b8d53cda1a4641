//! Video: the cameras that something in this process feeds, and those who look at them.
//!
//! A camera is fed by its [`VideoFeed`]: encoded frames go in, and are handed to each viewer's own bounded [`queue`]. A frame
//! that comes as JPEG or H.264 is passed on as it is. Nothing waits for a viewer, and no viewer for another; each has a
//! WebSocket of its own ([`stream`]), so that a big frame never stands before telemetry.
//!
//! What only the feeder can do (a picture with its position, recording) is asked of it as a [`CameraRequest`].

mod codec;
pub mod footage;
mod queue;
pub mod stream;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use thiserror::Error;
use tokio::sync::{Notify, mpsc, oneshot, watch};

pub use codec::Codec;
pub use queue::{QueuedFrame, ViewerQueue};

/// Cameras at most.
pub const MAX_CAMERAS: usize = 16;
/// Viewers of all cameras at most.
pub const MAX_VIEWERS: usize = 32;
/// Characters of a camera's name at most.
pub const MAX_NAME: usize = 32;
/// Bytes of one frame at most: more than any sensible picture.
pub const MAX_FRAME_BYTES: usize = 16 * 1024 * 1024;
/// Frames since the last key frame that are kept for those who come next.
const MAX_GROUP_FRAMES: usize = 600;
/// Bytes of them.
const MAX_GROUP_BYTES: usize = 8 * 1024 * 1024;
/// Requests that wait for one feeder.
const MAX_REQUESTS: usize = 8;

/// What a viewer can show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accepts {
    /// H.264; without it pictures come as JPEG, which every viewer shows.
    pub h264: bool,
}

/// An encoded picture.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// How it is encoded.
    pub codec: Codec,
    /// Whether it can be shown without those before it.
    pub is_key: bool,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// When it was taken: microseconds since 1970, UTC.
    pub captured_unix_us: u64,
    /// The code.
    pub data: &'a [u8],
}

/// Bytes of the header before each picture on the wire.
pub const HEADER_BYTES: usize = 20;

/// A picture as it goes to the viewers, header and code in one. All numbers are little-endian: version (1 byte, is 1), codec
/// (1 byte: 1 H.264, 2 JPEG), flags (1 byte: bit 0 key), 0, width and height (2 bytes each), time of capture (8 bytes,
/// microseconds since 1970), number of the picture (4 bytes).
fn on_wire(picture: &Picture<'_>, number: u32) -> Bytes {
    let mut bytes = Vec::with_capacity(HEADER_BYTES + picture.data.len());
    bytes.extend([1, picture.codec.number(), u8::from(picture.is_key), 0]);
    bytes.extend(picture.width.to_le_bytes());
    bytes.extend(picture.height.to_le_bytes());
    bytes.extend(picture.captured_unix_us.to_le_bytes());
    bytes.extend(number.to_le_bytes());
    bytes.extend(picture.data);
    Bytes::from(bytes)
}

/// What the feeder says of its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraStatus {
    /// Whether pictures come.
    pub state: CameraState,
    /// Why they do not, in English.
    pub reason: Option<String>,
    /// How the source itself encodes; `None` before the first picture, and for pictures that are not encoded.
    pub codec: Option<Codec>,
    /// Pixels of the newest picture.
    pub size: Option<(u16, u16)>,
    /// Pictures a second, lately.
    pub rate_hz: Option<f64>,
    /// Bits a second, lately.
    pub bitrate_bit_s: Option<f64>,
    /// The recording under way, or the one that a fault ended.
    pub recording: Option<RecordingStatus>,
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

/// Whether pictures come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraState {
    /// The source is read on demand, and nobody looks or records.
    Standby,
    /// On the way to the first picture.
    Starting,
    /// They come.
    Live,
    /// The source is there, but nothing comes.
    Stalled,
    /// The source is not there; it is tried again.
    Dead,
}

/// A recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingStatus {
    /// The file's name.
    pub file: String,
    /// How long it is.
    pub duration_s: f64,
    /// How large it is.
    pub bytes: u64,
    /// Why it ended before it was told to.
    pub problem: Option<String>,
}

/// Something that only the feeder can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraRequest {
    /// A still picture with its position: the answer is a JPEG file.
    Snapshot,
    /// The same, and that it is kept beside the recordings.
    KeepSnapshot,
    /// Begin to record.
    StartRecording,
    /// End the recording.
    StopRecording,
}

/// Why a camera cannot do what it was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A name that cannot be one.
    #[error("'{0}' is no name for a camera; one is 1 to {MAX_NAME} letters, digits, '-' or '_'")]
    BadName(String),
    /// The name is taken.
    #[error("there is a camera called '{0}' already; give this one another name")]
    Taken(String),
    /// All places are taken.
    #[error("{MAX_CAMERAS} cameras are there already")]
    TooMany,
    /// Nobody feeds the camera any more.
    #[error("the camera is gone")]
    Gone,
    /// The feeder has too much to do, or does not answer.
    #[error("the camera is busy; try again")]
    Busy,
    /// The feeder could not do it; its own words.
    #[error("{0}")]
    Refused(String),
    /// A picture that cannot be one.
    #[error("a picture of {0} bytes: it must have some, and {MAX_FRAME_BYTES} at most")]
    BadPicture(usize),
}

/// What the feeder answers.
pub type Answer = Result<Vec<u8>, String>;

/// A request on its way to the feeder. Dropped without an answer, it counts as refused.
#[derive(Debug)]
pub struct PendingRequest {
    /// What is wanted.
    pub request: CameraRequest,
    answer: oneshot::Sender<Answer>,
}

impl PendingRequest {
    /// Answers it: with a picture for a snapshot, with nothing for the others, or why it cannot be.
    pub fn answer(self, answer: Answer) {
        // Whoever asked may have gone.
        let _ = self.answer.send(answer);
    }
}

/// The cameras. Clones are handles to the same.
#[derive(Debug, Clone, Default)]
pub struct VideoHub {
    cameras: Arc<Mutex<BTreeMap<String, Arc<Camera>>>>,
}

impl VideoHub {
    /// Adds a camera; it is there until its feed is closed. `source` is what is shown of where it comes from: no secrets.
    ///
    /// # Errors
    /// [`CameraError::BadName`], [`CameraError::Taken`] and [`CameraError::TooMany`].
    pub fn add(&self, name: &str, source: &str) -> Result<VideoFeed, CameraError> {
        if !is_name(name) {
            return Err(CameraError::BadName(name.chars().take(MAX_NAME).collect()));
        }
        let mut cameras = self.lock();
        if cameras.contains_key(name) {
            return Err(CameraError::Taken(name.to_owned()));
        }
        if cameras.len() >= MAX_CAMERAS {
            return Err(CameraError::TooMany);
        }
        let (requests, waiting) = mpsc::channel(MAX_REQUESTS);
        let camera = Arc::new(Camera {
            name: name.to_owned(),
            source: source.to_owned(),
            state: Mutex::default(),
            requests,
            demand: Notify::new(),
        });
        cameras.insert(name.to_owned(), camera.clone());
        let waiting = tokio::sync::Mutex::new(waiting);
        Ok(VideoFeed { hub: self.clone(), camera, waiting, is_closed: watch::channel(false).0 })
    }

    /// A camera by name.
    pub fn camera(&self, name: &str) -> Option<Arc<Camera>> {
        self.lock().get(name).cloned()
    }

    /// All cameras, by name.
    pub fn cameras(&self) -> Vec<Arc<Camera>> {
        self.lock().values().cloned().collect()
    }

    /// Viewers of all cameras.
    pub fn viewers(&self) -> usize {
        self.cameras().iter().map(|camera| camera.viewers()).sum()
    }

    /// Names of the files that are being recorded.
    fn being_recorded(&self) -> Vec<String> {
        let recordings = self.cameras().into_iter().filter_map(|camera| camera.status().recording);
        recordings.filter(|recording| recording.problem.is_none()).map(|recording| recording.file).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Camera>>> {
        self.cameras.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn is_name(name: &str) -> bool {
    (1..=MAX_NAME).contains(&name.len())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte))
}

/// How many viewers want what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Demand {
    /// Those who are sent H.264.
    pub h264: usize,
    /// Those who are sent JPEG.
    pub jpeg: usize,
}

/// One camera, as those see it who look.
#[derive(Debug)]
pub struct Camera {
    name: String,
    source: String,
    state: Mutex<State>,
    requests: mpsc::Sender<PendingRequest>,
    /// The viewers, or what they want, changed.
    demand: Notify,
}

#[derive(Debug, Default)]
struct State {
    status: CameraStatus,
    viewers: Vec<(Accepts, Weak<ViewerQueue>)>,
    /// H.264 pictures since the last key frame, for those who come next; empty when it was too long ago.
    group: Vec<QueuedFrame>,
    /// The newest JPEG picture, likewise.
    still: Option<QueuedFrame>,
    newest_unix_us: Option<u64>,
    pictures: u32,
    is_gone: bool,
}

impl State {
    fn sent_to(&self, accepts: Accepts) -> Codec {
        if accepts.h264 && self.status.codec == Some(Codec::H264) { Codec::H264 } else { Codec::Jpeg }
    }

    fn viewers(&mut self) -> Vec<(Accepts, Arc<ViewerQueue>)> {
        self.viewers.retain(|(_, viewer)| viewer.strong_count() > 0);
        self.viewers.iter().filter_map(|(accepts, viewer)| Some((*accepts, viewer.upgrade()?))).collect()
    }

    fn keep(&mut self, frame: &QueuedFrame) {
        match frame.codec {
            Codec::Jpeg => self.still = Some(frame.clone()),
            Codec::H264 => {
                if frame.is_key {
                    self.group.clear();
                } else if self.group.is_empty() {
                    return;
                }
                self.group.push(frame.clone());
                let bytes: usize = self.group.iter().map(|frame| frame.bytes.len()).sum();
                if self.group.len() > MAX_GROUP_FRAMES || bytes > MAX_GROUP_BYTES {
                    self.group.clear();
                }
            }
        }
    }
}

impl Camera {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where its pictures come from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// What its feeder last said of it.
    pub fn status(&self) -> CameraStatus {
        self.lock().status.clone()
    }

    /// When the newest picture was taken: microseconds since 1970.
    pub fn newest_unix_us(&self) -> Option<u64> {
        self.lock().newest_unix_us
    }

    /// Those who look.
    pub fn viewers(&self) -> usize {
        self.lock().viewers().len()
    }

    /// How many of them want what.
    pub fn demand(&self) -> Demand {
        let mut state = self.lock();
        let mut demand = Demand::default();
        for (accepts, _) in state.viewers() {
            match state.sent_to(accepts) {
                Codec::H264 => demand.h264 += 1,
                Codec::Jpeg => demand.jpeg += 1,
            }
        }
        demand
    }

    /// Begins to look: what can be shown at once is in the queue. Ends when the queue is dropped.
    fn watch(&self, accepts: Accepts) -> Arc<ViewerQueue> {
        let mut state = self.lock();
        let queue = Arc::new(ViewerQueue::default());
        match state.sent_to(accepts) {
            Codec::H264 => queue.begin(state.group.clone()),
            Codec::Jpeg => queue.begin(state.still.iter().cloned().collect()),
        }
        if state.is_gone {
            queue.end();
        }
        state.viewers.push((accepts, Arc::downgrade(&queue)));
        drop(state);
        self.demand.notify_one();
        queue
    }

    /// Asks the feeder for something.
    ///
    /// # Errors
    /// [`CameraError::Gone`], [`CameraError::Busy`], and what the feeder says: [`CameraError::Refused`].
    pub async fn ask(&self, request: CameraRequest) -> Result<Vec<u8>, CameraError> {
        if self.lock().is_gone {
            return Err(CameraError::Gone);
        }
        let (answer, answered) = oneshot::channel();
        self.requests.try_send(PendingRequest { request, answer }).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => CameraError::Busy,
            mpsc::error::TrySendError::Closed(_) => CameraError::Gone,
        })?;
        match answered.await {
            Ok(answer) => answer.map_err(CameraError::Refused),
            Err(_) => Err(CameraError::Gone),
        }
    }

    fn tell(&self, text: &Utf8Bytes) {
        for (_, viewer) in self.lock().viewers() {
            viewer.tell(text.clone());
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What feeds one camera. Closing it, or dropping it, takes the camera away.
#[derive(Debug)]
pub struct VideoFeed {
    hub: VideoHub,
    camera: Arc<Camera>,
    waiting: tokio::sync::Mutex<mpsc::Receiver<PendingRequest>>,
    is_closed: watch::Sender<bool>,
}

impl VideoFeed {
    /// The camera that it feeds.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Hands a picture to all who want it so encoded. Never waits.
    ///
    /// # Errors
    /// [`CameraError::BadPicture`], and [`CameraError::Gone`] when the feed was closed.
    pub fn publish(&self, picture: &Picture<'_>) -> Result<(), CameraError> {
        if picture.data.is_empty() || picture.data.len() > MAX_FRAME_BYTES {
            return Err(CameraError::BadPicture(picture.data.len()));
        }
        let mut state = self.camera.lock();
        if state.is_gone {
            return Err(CameraError::Gone);
        }
        state.pictures = state.pictures.wrapping_add(1);
        let frame =
            QueuedFrame { codec: picture.codec, is_key: picture.is_key, bytes: on_wire(picture, state.pictures) };
        state.newest_unix_us = Some(picture.captured_unix_us);
        state.keep(&frame);
        for (accepts, viewer) in state.viewers() {
            if state.sent_to(accepts) == picture.codec {
                viewer.push(frame.clone());
            }
        }
        Ok(())
    }

    /// Says how the camera is; the viewers hear it when it changed.
    pub fn set_status(&self, status: CameraStatus) {
        let mut state = self.camera.lock();
        if state.status == status {
            return;
        }
        if state.status.codec != status.codec {
            // What comes next cannot be shown after what was encoded otherwise. The first pictures may have come before this.
            if status.codec != Some(Codec::H264) {
                state.group.clear();
            }
            if status.codec != Some(Codec::Jpeg) {
                state.still = None;
            }
            if status.codec == Some(Codec::H264) {
                for (accepts, viewer) in state.viewers() {
                    if accepts.h264 {
                        viewer.begin(state.group.clone());
                    }
                }
            }
        }
        state.status = status;
        drop(state);
        self.camera.demand.notify_one();
        self.camera.tell(&stream::camera_text(&self.camera));
    }

    /// How many viewers want what.
    pub fn demand(&self) -> Demand {
        self.camera.demand()
    }

    /// Waits until viewers came, or what they are sent is another; viewers that go are seen by asking now and then.
    pub async fn demand_changed(&self) {
        tokio::select! {
            () = self.camera.demand.notified() => {}
            () = self.closed() => {}
        }
    }

    /// The next request; `None` once the feed is closed.
    pub async fn next_request(&self) -> Option<PendingRequest> {
        let mut waiting = self.waiting.lock().await;
        tokio::select! {
            biased;
            () = self.closed() => {
                refuse_all(&mut waiting);
                None
            }
            request = waiting.recv() => request,
        }
    }

    /// Takes the camera away; its viewers are told. May be called again.
    pub fn close(&self) {
        let mut cameras = self.hub.lock();
        if cameras.get(&self.camera.name).is_some_and(|camera| Arc::ptr_eq(camera, &self.camera)) {
            cameras.remove(&self.camera.name);
        }
        drop(cameras);
        let mut state = self.camera.lock();
        state.is_gone = true;
        for (_, viewer) in state.viewers() {
            viewer.end();
        }
        drop(state);
        self.is_closed.send_replace(true);
        // Who waits for the next request holds it, and refuses them.
        if let Ok(mut waiting) = self.waiting.try_lock() {
            refuse_all(&mut waiting);
        }
    }

    async fn closed(&self) {
        // It cannot be dropped while we are here.
        let _ = self.is_closed.subscribe().wait_for(|is_closed| *is_closed).await;
    }
}

/// Lets those who asked know that there will be no answer.
fn refuse_all(waiting: &mut mpsc::Receiver<PendingRequest>) {
    waiting.close();
    while waiting.try_recv().is_ok() {}
}

impl Drop for VideoFeed {
    fn drop(&mut self) {
        self.close();
    }
}
