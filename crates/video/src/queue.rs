//! The queue of one viewer: bounded, newest first. A viewer too slow for H.264 goes on at the next key frame; of JPEG
//! pictures only the newest waits.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;
use tokio::time::{Duration, Instant};

use crate::picture::{VideoCodec, WireFrame};

/// Once the oldest picture has waited for this long, those that wait are dropped.
pub const MAX_WAIT: Duration = Duration::from_millis(1000);
/// So many bytes wait at most.
pub const MAX_BYTES: usize = 16 * 1024 * 1024;

/// The next thing to send.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// The camera's state is another: send the newest.
    Status,
    /// A picture.
    Picture(Bytes),
    /// The camera is gone: there is nothing more.
    End,
}

#[derive(Debug, Default)]
struct State {
    has_status: bool,
    frames: VecDeque<(Instant, WireFrame)>,
    bytes: usize,
    /// Pictures that build on others make no sense before the next key frame.
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

/// The queue of one viewer. Putting something in never waits.
#[derive(Debug, Default)]
pub struct ViewerQueue {
    state: Mutex<State>,
    changed: Notify,
}

impl ViewerQueue {
    /// Puts in what can be shown at once: a key frame and what followed it, or nothing.
    pub fn begin(&self, frames: Vec<WireFrame>) {
        let mut state = self.lock();
        state.needs_key = frames.is_empty();
        let now = Instant::now();
        state.bytes = frames.iter().map(|frame| frame.bytes.len()).sum();
        state.frames = frames.into_iter().map(|frame| (now, frame)).collect();
        drop(state);
        self.changed.notify_one();
    }

    /// Adds a picture, and drops what waits when that is too old or too much.
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

    /// Notes that the camera's state changed.
    pub fn note_status(&self) {
        self.lock().has_status = true;
        self.changed.notify_one();
    }

    /// There is nothing more to come.
    pub fn end(&self) {
        self.lock().has_ended = true;
        self.changed.notify_one();
    }

    /// The next thing to send.
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

    /// Waits until there may be something to take.
    pub async fn wait(&self) {
        self.changed.notified().await;
    }

    /// Pictures that this viewer was too slow for.
    pub fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
