//! Owns recording: files that grow, one per session or hour, never overwritten, in a folder of their own. What is in them is a
//! [`Format`]'s: all frames, both ways, as `.tlog` ([`Frames`]); a fleet's history has its own.
//!
//! The links' tasks only put frames into a bounded queue; a thread of its own writes. Nothing that happens to the disk
//! reaches the links: frames that cannot be written are counted, the reason is in the [`RecorderStatus`], and the
//! recorder tries again, at first soon, then at ever longer intervals. A disk that does not answer at all shows in the status
//! too, which is looked at from outside the thread that waits for it.
//!
//! What is written at most five times a second is handed to the system, and once a second forced to the disk: beside the
//! writing, for that takes seconds on a busy disk, and what waits in memory is lost with the process. The folder is kept below a quota by deleting the oldest recordings (files named as the recorder names them, nothing
//! else, never one being written, here or by another process, and never one that somebody keeps); below a floor of free
//! space nothing is written at all.
//!
//! One thread serves one file ([`Recorder`]) or many that grow side by side in one folder ([`Recorders`]): then a bounded number of them is
//! open at a time, and what is wrong with one is told of that one.

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

/// Of so many parts of a full queue one wakes the writer before its time.
const WAKE_PART: usize = 4;
/// A disk that has not answered for so long counts as one that does not write.
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

/// The way into a recorder. Never waits.
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
    /// Has something written. Where the queue is full the oldest in it is dropped, and counted.
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

    /// Has something written, unless the queue is full: for what can be had again. Whether it was taken.
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
    /// Notes a frame that was received or sent. Keys (`SETUP_SIGNING`) are not recorded.
    pub fn record(&self, link: LinkId, frame: &Frame, now: MonoTime) {
        if frame.message_id() != SETUP_SIGNING_ID {
            self.put(Noted { at: now, link, frame: frame.clone() });
        }
    }
}

/// One of the files that grow side by side, and each that follows it.
pub struct Line<F: Format> {
    handle: RecorderHandle<F>,
    clock: Arc<dyn Clock>,
    status: watch::Receiver<RecorderStatus>,
}

impl<F: Format> Line<F> {
    /// The way in.
    pub fn handle(&self) -> &RecorderHandle<F> {
        &self.handle
    }

    /// How it is going, also while the thread waits for the disk.
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

/// One thread that writes many files of a folder side by side. Dropping it ends them in the background; [`Self::close`] waits until they are
/// on the disk.
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
    /// When the system gives no thread. What is wrong with the disk shows in the status of each line.
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

    /// One more line. Never waits.
    pub fn add(&self, format: F) -> Line<F> {
        let (writer, status) = Writer::new(format, self.config.retry_after, self.clock.now());
        let mut queue = self.shared.queue();
        queue.newcomers.push(writer);
        queue.dropped.push(0);
        let handle = RecorderHandle { shared: self.shared.clone(), line: queue.dropped.len() - 1 };
        Line { handle, clock: self.clock.clone(), status }
    }

    /// Writes what is waiting, forces it to the disk and ends. Blocks as long as the disk does.
    pub fn close(mut self) {
        self.shared.stop();
        if let Some(thread) = self.thread.take() {
            // A panic in the thread has been reported already.
            let _ = thread.join();
        }
    }
}

impl<F: Format> Drop for Recorders<F> {
    fn drop(&mut self) {
        self.shared.stop();
    }
}

/// A running recorder of one line. Dropping it ends the recording in the background; [`Self::close`] waits until it is on the disk.
pub struct Recorder<F: Format = Frames> {
    all: Recorders<F>,
    line: Line<F>,
}

impl Recorder {
    /// Starts a recorder that writes into `folder`.
    ///
    /// # Errors
    /// When the system gives no thread. What is wrong with the folder shows in the status.
    pub fn start(folder: impl Into<PathBuf>, config: RecorderConfig, clock: Arc<dyn Clock>) -> io::Result<Self> {
        Self::start_with(Box::new(Folder::new(folder)), config, clock)
    }

    /// The same with a storage of the caller's.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start_with(storage: Box<dyn Storage>, config: RecorderConfig, clock: Arc<dyn Clock>) -> io::Result<Self> {
        Self::start_format(Frames::default(), storage, config, clock)
    }
}

impl<F: Format> Recorder<F> {
    /// Starts a recorder of any format.
    ///
    /// # Errors
    /// When the system gives no thread. What is wrong with the disk shows in the status.
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

    /// The way in, for [`Hub::set_recorder`](crate::Hub::set_recorder).
    pub fn handle(&self) -> RecorderHandle<F> {
        self.line.handle.clone()
    }

    /// How it is going, also while its thread waits for the disk.
    pub fn status(&self) -> RecorderStatus {
        self.line.status()
    }

    /// Writes what is waiting, forces it to the disk and ends. Blocks as long as the disk does.
    pub fn close(self) -> RecorderStatus {
        self.all.close();
        self.line.status()
    }
}

/// What came since the last time: new lines, items, and how much of each line was dropped; and whether this is the end.
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
