//! What waits for one viewer: bounded, newest first. Who is too slow for H.264 goes on at the next key frame; of JPEG
//! pictures only the newest waits.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use tokio::sync::Notify;
use tokio::time::{Duration, Instant};

use super::codec::Codec;

/// Once the oldest picture has waited for this long, those that wait are dropped.
pub const MAX_WAIT: Duration = Duration::from_millis(1000);
/// So many bytes wait at most.
pub const MAX_BYTES: usize = 16 * 1024 * 1024;

/// A picture as it goes over the wire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueuedFrame {
    /// How it is encoded.
    pub codec: Codec,
    /// Whether it can be shown without those before it.
    pub is_key: bool,
    /// Header and code.
    pub bytes: Bytes,
}

/// The next thing to send.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// How the camera is.
    Text(Utf8Bytes),
    /// A picture.
    Picture(Bytes),
    /// The camera is gone: there is nothing more.
    End,
}

#[derive(Debug, Default)]
struct State {
    text: Option<Utf8Bytes>,
    frames: VecDeque<(Instant, QueuedFrame)>,
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

/// What waits for one viewer. Putting something in never waits.
#[derive(Debug, Default)]
pub struct ViewerQueue {
    state: Mutex<State>,
    news: Notify,
}

impl ViewerQueue {
    /// Puts in what can be shown at once: a key frame and what followed it, or nothing.
    pub fn begin(&self, frames: Vec<QueuedFrame>) {
        let mut state = self.lock();
        state.needs_key = frames.is_empty();
        let now = Instant::now();
        state.bytes = frames.iter().map(|frame| frame.bytes.len()).sum();
        state.frames = frames.into_iter().map(|frame| (now, frame)).collect();
        drop(state);
        self.news.notify_one();
    }

    /// Adds a picture, and drops what waits when that is too old or too much.
    pub fn push(&self, frame: QueuedFrame) {
        let mut state = self.lock();
        let now = Instant::now();
        let is_late = state.frames.front().is_some_and(|(since, _)| now.duration_since(*since) > MAX_WAIT);
        let is_late = is_late || state.bytes + frame.bytes.len() > MAX_BYTES;
        match frame.codec {
            Codec::Jpeg => state.drop_all(),
            Codec::H264 if is_late => {
                state.drop_all();
                state.needs_key = true;
            }
            Codec::H264 => {}
        }
        if state.needs_key && !frame.is_key {
            state.dropped += 1;
            return;
        }
        state.needs_key = false;
        state.bytes += frame.bytes.len();
        state.frames.push_back((now, frame));
        drop(state);
        self.news.notify_one();
    }

    /// Replaces what is to be said of the camera.
    pub fn tell(&self, text: Utf8Bytes) {
        self.lock().text = Some(text);
        self.news.notify_one();
    }

    /// There is nothing more to come.
    pub fn end(&self) {
        self.lock().has_ended = true;
        self.news.notify_one();
    }

    /// The next thing to send.
    pub fn take(&self) -> Option<Outgoing> {
        let mut state = self.lock();
        if let Some(text) = state.text.take() {
            return Some(Outgoing::Text(text));
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
        self.news.notified().await;
    }

    /// Pictures that this viewer was too slow for.
    pub fn dropped(&self) -> u64 {
        self.lock().dropped
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
