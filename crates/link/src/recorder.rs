//! Owns recording: append-only files, one per session or hour, never overwritten, in a folder of their own. Their
//! content is a [`Format`]: all frames in both directions as `.tlog` ([`Frames`]); a fleet's history has its own.
//!
//! The links' tasks only put frames into a bounded queue; a separate thread writes them. Disk errors do not affect
//! links: frames that cannot be written are counted, the reason is in the [`RecorderStatus`], and the recorder retries
//! with a growing back-off. A hanging disk shows in the status too, which is computed outside the thread that waits for
//! it.
//!
//! Frames are written at most five times a second, and synced to disk (fsync) once a second in the background: a sync
//! takes seconds on a busy disk, and what is only in memory is lost with the process. The folder is kept below a quota
//! by deleting the oldest recordings (only files named as the recorder names them, never one being written by this or
//! another process, never one marked as kept); below a floor of free space nothing is written.
//!
//! One thread serves one file ([`Recorder`]) or many files of a folder at once ([`Recorders`]): then a bounded number
//! of them is open at a time, and each has a status of its own.

mod format;
mod frames;
mod status;
mod storage;
mod writer;

use std::collections::VecDeque;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{Frame, MonoTime};

use self::status::WRITE_INTERVAL;
use self::writer::{Writer, Writers};
use crate::clock::Clock;
use crate::port::LinkId;
use crate::router::SETUP_SIGNING_ID;

pub use self::format::Format;
pub use self::frames::{Frames, Noted};
pub use self::status::{RecorderConfig, RecorderState, RecorderStatus};
pub use self::storage::{Folder, Names, Storage, StorageFile, StoredFile, Syncing, is_kept_recording, keep_recording};

/// A queue filled to one part in this many wakes the writer early.
const WAKE_PART: usize = 4;
/// A disk that has not answered for this long counts as hanging.
const STALLED_AFTER: Duration = Duration::from_secs(3);

struct Queue<F: Format> {
    /// With the number of its line.
    items: VecDeque<(usize, F::Item)>,
    /// Of each line.
    dropped: Vec<u64>,
    newcomers: Vec<Writer<F>>,
    closing: bool,
}

struct Shared<F: Format> {
    queue: Mutex<Queue<F>>,
    queue_items: usize,
    wake: Condvar,
    /// See [`Writers::busy_since_us`].
    busy_since_us: Arc<AtomicU64>,
}

impl<F: Format> Shared<F> {
    fn new(queue_items: usize, busy_since_us: Arc<AtomicU64>) -> Self {
        let queue = Queue { items: VecDeque::new(), dropped: Vec::new(), newcomers: Vec::new(), closing: false };
        Self { queue: Mutex::new(queue), queue_items, wake: Condvar::new(), busy_since_us }
    }

    fn queue(&self) -> MutexGuard<'_, Queue<F>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stop(&self) {
        self.queue().closing = true;
        self.wake.notify_one();
    }
}

/// A handle that puts items into a recorder. Never waits.
pub struct RecorderHandle<F: Format = Frames> {
    shared: Arc<Shared<F>>,
    line: usize,
}

impl<F: Format> Clone for RecorderHandle<F> {
    fn clone(&self) -> Self {
        Self { shared: self.shared.clone(), line: self.line }
    }
}

impl<F: Format> RecorderHandle<F> {
    /// Queues an item. When the queue is full its oldest item is dropped and counted.
    pub fn put(&self, item: F::Item) {
        let mut queue = self.shared.queue();
        if !queue.closing
            && queue.items.len() >= self.shared.queue_items
            && let Some((line, _)) = queue.items.pop_front()
        {
            queue.dropped[line] += 1;
        }
        self.push(queue, item);
    }

    /// Queues an item unless the queue is full, for items that can be fetched again. Returns whether it was taken.
    pub fn offer(&self, item: F::Item) -> bool {
        let queue = self.shared.queue();
        let has_room = queue.items.len() < self.shared.queue_items && !queue.closing;
        if has_room {
            self.push(queue, item);
        }
        has_room
    }

    fn push(&self, mut queue: MutexGuard<'_, Queue<F>>, item: F::Item) {
        if queue.closing {
            return;
        }
        queue.items.push_back((self.line, item));
        let wake = queue.items.len() == self.shared.queue_items / WAKE_PART;
        drop(queue);
        if wake {
            self.shared.wake.notify_one();
        }
    }
}

impl RecorderHandle {
    /// Records a frame that was received or sent, except keys (`SETUP_SIGNING`).
    pub fn record(&self, link: LinkId, frame: &Frame, now: MonoTime) {
        if frame.message_id() != SETUP_SIGNING_ID {
            self.put(Noted { at: now, link, frame: frame.clone() });
        }
    }
}

/// One of several files written at once, and its successors.
pub struct Line<F: Format> {
    handle: RecorderHandle<F>,
    clock: Arc<dyn Clock>,
    status: watch::Receiver<RecorderStatus>,
}

impl<F: Format> Line<F> {
    /// The handle to put items in.
    pub fn handle(&self) -> &RecorderHandle<F> {
        &self.handle
    }

    /// Its status, also while the thread waits for the disk.
    pub fn status(&self) -> RecorderStatus {
        let mut status = self.status.borrow().clone();
        let RecorderHandle { shared, line } = &self.handle;
        if let Some(busy_since_us) = shared.busy_since_us.load(Ordering::Acquire).checked_sub(1) {
            let busy_since = MonoTime::from_micros(busy_since_us);
            let is_writing = matches!(status.state, RecorderState::Starting | RecorderState::Recording { .. });
            if is_writing && self.clock.now().since(busy_since) >= STALLED_AFTER {
                status.state = RecorderState::Stalled;
                status.since = busy_since;
            }
        }
        status.dropped += shared.queue().dropped[*line];
        status
    }
}

/// One thread that writes many files of a folder at once. Dropping it ends them in the background; [`Self::close`]
/// waits until they are on disk.
pub struct Recorders<F: Format> {
    shared: Arc<Shared<F>>,
    clock: Arc<dyn Clock>,
    config: RecorderConfig,
    thread: Option<JoinHandle<()>>,
}

impl<F: Format> Recorders<F> {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the thread cannot be started. Disk errors show in the status of each line.
    pub fn start(storage: Box<dyn Storage>, config: RecorderConfig, clock: Arc<dyn Clock>) -> io::Result<Self> {
        let mut writers = Writers::new(storage, config.clone(), clock.clone());
        let shared = Arc::new(Shared::new(config.queue_items, writers.busy_since_us.clone()));
        let queue = shared.clone();
        let thread = std::thread::Builder::new().name("vencejo-recorder".to_owned()).spawn(move || {
            loop {
                let (newcomers, batch, dropped, closing) = wait(&queue);
                writers.add(newcomers);
                writers.on_items(batch, &dropped);
                if closing {
                    return writers.close();
                }
            }
        })?;
        Ok(Self { shared, clock, config, thread: Some(thread) })
    }

    /// Adds a line. Never waits.
    pub fn add(&self, format: F) -> Line<F> {
        let (writer, status) = Writer::new(format, self.config.retry_after, self.clock.now());
        let mut queue = self.shared.queue();
        queue.newcomers.push(writer);
        queue.dropped.push(0);
        let handle = RecorderHandle { shared: self.shared.clone(), line: queue.dropped.len() - 1 };
        Line { handle, clock: self.clock.clone(), status }
    }

    /// Writes and syncs what is queued, and ends. Blocks as long as the disk does.
    pub fn close(mut self) {
        self.shared.stop();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported.
            let _ = thread.join();
        }
    }
}

impl<F: Format> Drop for Recorders<F> {
    fn drop(&mut self) {
        self.shared.stop();
    }
}

/// A running recorder of one line. Dropping it ends the recording in the background; [`Self::close`]
/// waits until it is on disk.
pub struct Recorder<F: Format = Frames> {
    all: Recorders<F>,
    line: Line<F>,
}

impl Recorder {
    /// Starts a recorder that writes into `folder`.
    ///
    /// # Errors
    /// When the thread cannot be started. Errors of the folder show in the status.
    pub fn start(folder: impl Into<PathBuf>, config: RecorderConfig, clock: Arc<dyn Clock>) -> io::Result<Self> {
        Self::start_with(Box::new(Folder::new(folder)), config, clock)
    }

    /// Starts a recorder with the caller's storage.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn start_with(storage: Box<dyn Storage>, config: RecorderConfig, clock: Arc<dyn Clock>) -> io::Result<Self> {
        Self::start_format(Frames::default(), storage, config, clock)
    }
}

impl<F: Format> Recorder<F> {
    /// Starts a recorder of any format.
    ///
    /// # Errors
    /// When the thread cannot be started. Disk errors show in the status.
    pub fn start_format(
        format: F,
        storage: Box<dyn Storage>,
        config: RecorderConfig,
        clock: Arc<dyn Clock>,
    ) -> io::Result<Self> {
        let all = Recorders::start(storage, config, clock)?;
        let line = all.add(format);
        Ok(Self { all, line })
    }

    /// The handle to put frames in, for [`Hub::set_recorder`](crate::Hub::set_recorder).
    pub fn handle(&self) -> RecorderHandle<F> {
        self.line.handle.clone()
    }

    /// Its status, also while its thread waits for the disk.
    pub fn status(&self) -> RecorderStatus {
        self.line.status()
    }

    /// Writes and syncs what is queued, and ends. Blocks as long as the disk does.
    pub fn close(self) -> RecorderStatus {
        self.all.close();
        self.line.status()
    }
}

/// What was queued since the last time: new lines, items, dropped items of each line; and whether the recorder ends.
type News<F> = (Vec<Writer<F>>, VecDeque<(usize, <F as Format>::Item)>, Vec<u64>, bool);

fn wait<F: Format>(shared: &Shared<F>) -> News<F> {
    let wake_items = shared.queue_items / WAKE_PART;
    let idle = |queue: &mut Queue<F>| !queue.closing && queue.newcomers.is_empty() && queue.items.len() < wake_items;
    let waited = shared.wake.wait_timeout_while(shared.queue(), WRITE_INTERVAL, idle);
    let (mut queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
    let dropped = queue.dropped.iter_mut().map(std::mem::take).collect();
    (std::mem::take(&mut queue.newcomers), std::mem::take(&mut queue.items), dropped, queue.closing)
}

#[cfg(test)]
mod tests;
