//! Bounded queue of one viewer. A viewer too slow for H.264 continues at the next key frame; of JPEG images, only the
//! newest is kept.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;
use tokio::time::{Duration, Instant};

use crate::picture::{VideoCodec, WireFrame};

/// Waiting time of the oldest image after which all waiting ones are dropped.
pub const MAX_WAIT: Duration = Duration::from_millis(1000);
/// Largest size of the waiting images, bytes.
pub const MAX_BYTES: usize = 16 * 1024 * 1024;

/// Next message for a viewer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// The camera's state has changed: send the newest.
    Status,
    /// An image.
    Picture(Bytes),
    /// The camera was removed; this is the last message.
    End,
}

#[derive(Debug, Default)]
struct State {
    has_status: bool,
    frames: VecDeque<(Instant, WireFrame)>,
    bytes: usize,
    /// Images that depend on others are useless before the next key frame.
    needs_key: bool,
    dropped: u64,
    has_ended: bool,
}

impl State {
    fn drop_all(&mut self) {
        self.dropped += self.frames.len() as u64;
        self.frames.clear();
        self.bytes = 0;
    }
}

/// Queue of one viewer. Adding to it never blocks.
#[derive(Debug, Default)]
pub struct ViewerQueue {
    state: Mutex<State>,
    changed: Notify,
}

impl ViewerQueue {
    /// Adds what can be shown at once: a key frame and the images after it, or nothing.
    pub fn begin(&self, frames: Vec<WireFrame>) {
        let mut state = self.lock();
        state.needs_key = frames.is_empty();
        let now = Instant::now();
        state.bytes = frames.iter().map(|frame| frame.bytes.len()).sum();
        state.frames = frames.into_iter().map(|frame| (now, frame)).collect();
        drop(state);
        self.changed.notify_one();
    }

    /// Adds an image, and drops the waiting ones if they are too old or too large.
    pub fn push(&self, frame: WireFrame) {
        let mut state = self.lock();
        let now = Instant::now();
        let is_late = state.frames.front().is_some_and(|(since, _)| now.duration_since(*since) > MAX_WAIT);
        let is_late = is_late || state.bytes + frame.bytes.len() > MAX_BYTES;
        match frame.codec {
            VideoCodec::Jpeg => state.drop_all(),
            VideoCodec::H264 if is_late => {
                state.drop_all();
                state.needs_key = true;
            }
            VideoCodec::H264 => {}
        }
        if state.needs_key && !frame.is_key {
            state.dropped += 1;
            return;
        }
        state.needs_key = false;
        state.bytes += frame.bytes.len();
        state.frames.push_back((now, frame));
        drop(state);
        self.changed.notify_one();
    }

    /// Records that the camera's state changed.
    pub fn note_status(&self) {
        self.lock().has_status = true;
        self.changed.notify_one();
    }

    /// Marks the end of the queue.
    pub fn end(&self) {
        self.lock().has_ended = true;
        self.changed.notify_one();
    }

    /// Next message.
    pub fn take(&self) -> Option<Outgoing> {
        let mut state = self.lock();
        if std::mem::take(&mut state.has_status) {
            return Some(Outgoing::Status);
        }
        if state.has_ended {
            return Some(Outgoing::End);
        }
        let (_, frame) = state.frames.pop_front()?;
        state.bytes -= frame.bytes.len();
        Some(Outgoing::Picture(frame.bytes))
    }

    /// Waits until there may be a message to take.
    pub async fn wait(&self) {
        self.changed.notified().await;
    }

    /// Number of images dropped because the viewer was too slow.
    pub fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
