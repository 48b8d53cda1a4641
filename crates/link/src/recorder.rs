//! Owns recording: files that grow, one per session or hour, never overwritten, in a folder of their own. What is in them is a
//! [`Format`]'s: all frames, both ways, as `.tlog` ([`Frames`]); a fleet's history has its own.
//!
//! The links' tasks only put frames into a bounded queue; a thread of its own writes. Nothing that happens to the disk
//! reaches the links: frames that cannot be written are counted, the reason is in the [`RecorderStatus`], and the
//! recorder tries again, at first soon, then at ever longer intervals. A disk that does not answer at all shows in the status
//! too, which is looked at from outside the thread that waits for it.
//!
//! What is written at most five times a second is handed to the system, and once a second forced to the disk. The
//! folder is kept below a quota by deleting the oldest recordings (files named as the recorder names them, nothing
//! else, never one being written, here or by another process, and never one that somebody keeps); below a floor of free
//! space nothing is written at all.

mod format;
mod frames;
mod storage;

use std::collections::VecDeque;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{Frame, MonoTime};
use vencejo_store::Floors;

use self::storage::utc_stamp;
use crate::clock::Clock;
use crate::port::LinkId;
use crate::router::SETUP_SIGNING_ID;

pub use self::format::Format;
pub use self::frames::{Frames, Noted};
pub use self::storage::{Folder, Names, Storage, StorageFile, StoredFile, is_kept_recording, keep_recording};

/// Frames that wait for the disk: about 16 s at 1,000 frames/s. Overflow: the oldest are dropped and counted.
const QUEUE_ITEMS: usize = 16_384;
/// So many waiting frames wake the writer before its time.
const WAKE_ITEMS: usize = QUEUE_ITEMS / 4;
/// How often the writer looks for frames.
const WRITE_INTERVAL: Duration = Duration::from_millis(200);
/// How often what was written is forced to the disk, and space and quota are looked at.
const SYNC_INTERVAL: Duration = Duration::from_secs(1);
/// A disk that has not answered for so long counts as one that does not write.
const STALLED_AFTER: Duration = Duration::from_secs(3);

/// The recorder's limits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderConfig {
    /// A file that has grown to this size is closed, and the next one begun. 512 MiB by default: about two days of an
    /// aircraft at 10 Hz.
    pub max_file_bytes: u64,
    /// And one that has grown this old; never by default.
    pub max_file_age: Option<Duration>,
    /// What all recordings of the folder may take together, 8 GiB by default. Never less than one file.
    pub quota_bytes: u64,
    /// Free space of the disk below which nothing is written, 500 MB by default.
    pub free_floor_bytes: u64,
    /// The wait before another try when writing has failed, 1 s by default; it doubles with each try that fails.
    pub retry_after: Duration,
    /// The longest wait before another try, 30 s by default.
    pub retry_at_most: Duration,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self {
            max_file_bytes: 512 << 20,
            max_file_age: None,
            quota_bytes: 8 << 30,
            free_floor_bytes: Floors::default().bytes(vencejo_store::Class::Telemetry),
            retry_after: Duration::from_secs(1),
            retry_at_most: Duration::from_secs(30),
        }
    }
}

/// How the recording is going.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderStatus {
    /// What it is doing.
    pub state: RecorderState,
    /// Since when it has been recording, or not.
    pub since: MonoTime,
    /// Frames written in this session.
    pub frames: u64,
    /// Bytes written in this session.
    pub bytes: u64,
    /// Frames that were not recorded: queue full, or nothing could be written.
    pub dropped: u64,
}

/// What the recorder is doing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecorderState {
    /// About to open its file.
    Starting,
    /// Writing.
    Recording {
        /// The file's name in the folder.
        file: String,
    },
    /// Nothing is written, because the disk is nearly full.
    LowSpace {
        /// Free bytes.
        free_bytes: u64,
        /// Free bytes that are needed.
        floor_bytes: u64,
    },
    /// Nothing is written, because writing failed; it is tried again.
    Failing {
        /// What went wrong.
        error: String,
    },
    /// Nothing is written, because the disk does not answer.
    Stalled,
    /// Closed.
    Closed,
}

impl RecorderState {
    /// Why nothing is written, in English; `None` while it is, or is about to be.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        match self {
            Self::Starting | Self::Recording { .. } => None,
            Self::LowSpace { free_bytes, floor_bytes } => Some(format!(
                "only {} MB are free on the disk, and {} MB stay free of telemetry",
                free_bytes / 1_000_000,
                floor_bytes / 1_000_000
            )),
            Self::Failing { error } => Some(error.clone()),
            Self::Stalled => Some("the disk does not answer".to_owned()),
            Self::Closed => Some("closed".to_owned()),
        }
    }
}

struct Queue<T> {
    items: VecDeque<T>,
    dropped: u64,
    closing: bool,
}

struct Shared<T> {
    queue: Mutex<Queue<T>>,
    wake: Condvar,
    /// Since when the thread has been waiting for the disk, µs on the clock plus one; 0 while it does not.
    busy_since_us: AtomicU64,
}

impl<T> Shared<T> {
    fn new() -> Self {
        let queue = Queue { items: VecDeque::new(), dropped: 0, closing: false };
        Self { queue: Mutex::new(queue), wake: Condvar::new(), busy_since_us: AtomicU64::new(0) }
    }

    fn queue(&self) -> MutexGuard<'_, Queue<T>> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The way into a recorder. Never waits.
pub struct RecorderHandle<F: Format = Frames> {
    shared: Arc<Shared<F::Item>>,
}

impl<F: Format> Clone for RecorderHandle<F> {
    fn clone(&self) -> Self {
        Self { shared: self.shared.clone() }
    }
}

impl<F: Format> RecorderHandle<F> {
    /// Has something written.
    pub fn put(&self, item: F::Item) {
        let mut queue = self.shared.queue();
        if queue.closing {
            return;
        }
        if queue.items.len() >= QUEUE_ITEMS {
            queue.items.pop_front();
            queue.dropped += 1;
        }
        queue.items.push_back(item);
        let wake = queue.items.len() == WAKE_ITEMS;
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

/// A running recorder. Dropping it ends the recording in the background; [`Self::close`] waits until it is on the disk.
pub struct Recorder<F: Format = Frames> {
    shared: Arc<Shared<F::Item>>,
    clock: Arc<dyn Clock>,
    status: watch::Receiver<RecorderStatus>,
    thread: Option<JoinHandle<()>>,
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
        let shared = Arc::new(Shared::new());
        let (mut writer, status) = Writer::new(format, storage, config, clock.clone());
        let (queue, watched) = (shared.clone(), clock.clone());
        let thread = std::thread::Builder::new().name("vencejo-recorder".to_owned()).spawn(move || {
            loop {
                let (batch, dropped, closing) = wait(&queue);
                queue.busy_since_us.store(watched.now().as_micros() + 1, Ordering::Release);
                writer.on_items(&batch, dropped);
                if closing {
                    return writer.close();
                }
                queue.busy_since_us.store(0, Ordering::Release);
            }
        })?;
        Ok(Self { shared, clock, status, thread: Some(thread) })
    }

    /// The way in, for [`Hub::set_recorder`](crate::Hub::set_recorder).
    pub fn handle(&self) -> RecorderHandle<F> {
        RecorderHandle { shared: self.shared.clone() }
    }

    /// How it is going, also while its thread waits for the disk.
    pub fn status(&self) -> RecorderStatus {
        let mut status = self.status.borrow().clone();
        if let Some(busy_since_us) = self.shared.busy_since_us.load(Ordering::Acquire).checked_sub(1) {
            let busy_since = MonoTime::from_micros(busy_since_us);
            let is_writing = matches!(status.state, RecorderState::Starting | RecorderState::Recording { .. });
            if is_writing && self.clock.now().since(busy_since) >= STALLED_AFTER {
                status.state = RecorderState::Stalled;
                status.since = busy_since;
            }
        }
        status.dropped += self.shared.queue().dropped;
        status
    }

    /// Writes what is waiting, forces it to the disk and ends. Blocks as long as the disk does.
    pub fn close(mut self) -> RecorderStatus {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A panic in the thread has been reported already.
            let _ = thread.join();
        }
        self.status()
    }

    fn stop(&self) {
        self.shared.queue().closing = true;
        self.shared.wake.notify_one();
    }
}

impl<F: Format> Drop for Recorder<F> {
    fn drop(&mut self) {
        self.stop();
    }
}

fn wait<T>(shared: &Shared<T>) -> (VecDeque<T>, u64, bool) {
    let idle = |queue: &mut Queue<T>| !queue.closing && queue.items.len() < WAKE_ITEMS;
    let waited = shared.wake.wait_timeout_while(shared.queue(), WRITE_INTERVAL, idle);
    let (mut queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
    let dropped = std::mem::take(&mut queue.dropped);
    (std::mem::take(&mut queue.items), dropped, queue.closing)
}

/// A file being written.
struct OpenFile {
    name: String,
    file: Box<dyn StorageFile>,
    bytes: u64,
    begun_at: MonoTime,
}

/// What the thread does, without the thread.
struct Writer<F: Format = Frames> {
    format: F,
    storage: Box<dyn Storage>,
    config: RecorderConfig,
    clock: Arc<dyn Clock>,
    status: watch::Sender<RecorderStatus>,
    now: RecorderStatus,
    open: Option<OpenFile>,
    /// Not before this moment is writing tried again.
    retry_at: MonoTime,
    /// How long is waited after the next failure.
    retry_wait: Duration,
    synced_at: MonoTime,
    batch: Vec<u8>,
}

impl<F: Format> Writer<F> {
    fn new(
        format: F,
        storage: Box<dyn Storage>,
        config: RecorderConfig,
        clock: Arc<dyn Clock>,
    ) -> (Self, watch::Receiver<RecorderStatus>) {
        let started = clock.now();
        let now = RecorderStatus { state: RecorderState::Starting, since: started, frames: 0, bytes: 0, dropped: 0 };
        let (status, watch) = watch::channel(now.clone());
        let config = RecorderConfig { quota_bytes: config.quota_bytes.max(config.max_file_bytes), ..config };
        let retry_wait = config.retry_after;
        let writer = Self {
            format,
            storage,
            config,
            clock,
            status,
            now,
            open: None,
            retry_at: started,
            retry_wait,
            synced_at: started,
            batch: Vec::new(),
        };
        (writer, watch)
    }

    /// Writes what came. Called several times a second, also without any.
    fn on_items(&mut self, items: &VecDeque<F::Item>, dropped: u64) {
        let now = self.clock.now();
        self.now.dropped += dropped;
        if self.open.is_none() && now >= self.retry_at && (F::BEGINS_AT_ONCE || !items.is_empty()) {
            self.begin(now);
        }
        if let Err((error, lost)) = self.write(items) {
            self.now.dropped += lost;
            self.fail(&error, now);
        }
        let has_to_prove = self.open.is_some() && self.now.state.problem().is_some();
        if has_to_prove || now.since(self.synced_at) >= SYNC_INTERVAL {
            self.synced_at = now;
            self.keep_house(now);
        }
        self.publish();
    }

    fn write(&mut self, items: &VecDeque<F::Item>) -> Result<(), (io::Error, u64)> {
        if self.open.is_none() {
            self.now.dropped += items.len() as u64;
            return Ok(());
        }
        self.format.write(items, &mut self.batch);
        self.put_out().map_err(|error| (error, items.len() as u64))?;
        self.now.frames += items.len() as u64;
        Ok(())
    }

    /// Hands the batch to the system.
    fn put_out(&mut self) -> io::Result<()> {
        let batch = std::mem::take(&mut self.batch);
        let Some(open) = self.open.as_mut().filter(|_| !batch.is_empty()) else { return Ok(()) };
        open.file.write_all(&batch)?;
        open.bytes += batch.len() as u64;
        self.now.bytes += batch.len() as u64;
        self.batch = batch;
        self.batch.clear();
        Ok(())
    }

    /// Forces to the disk, looks at free space and quota, and begins the next file when this one is full.
    fn keep_house(&mut self, now: MonoTime) {
        if self.open.is_some() {
            self.format.flush(&mut self.batch);
        }
        if let Err(error) = self.put_out() {
            return self.fail(&error, now);
        }
        let Some(open) = &mut self.open else { return };
        if let Err(error) = open.file.sync() {
            return self.fail(&error, now);
        }
        let is_old = self.config.max_file_age.is_some_and(|age| now.since(open.begun_at) >= age);
        let (file, is_full) = (open.name.clone(), is_old || open.bytes >= self.config.max_file_bytes);
        self.retry_wait = self.config.retry_after;
        if self.now.state.problem().is_some() {
            self.enter(RecorderState::Recording { file }, now);
        }
        if is_full {
            self.end_file(true);
            if F::BEGINS_AT_ONCE {
                self.begin(now);
            }
            return;
        }
        if self.has_space(now) {
            self.enforce_quota();
        }
    }

    /// Opens a new file, unless there is no space.
    fn begin(&mut self, now: MonoTime) {
        if !self.has_space(now) {
            return;
        }
        let begun_unix_us = self.clock.unix_us();
        let stamp = utc_stamp(begun_unix_us / 1_000_000);
        let created = (0..1000).find_map(|number| {
            let name = self.format.names().name(&stamp, number);
            match self.storage.create_new(&name) {
                Ok(file) => Some(Ok((name, file))),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => None,
                Err(error) => Some(Err(error)),
            }
        });
        match created.unwrap_or_else(|| Err(io::ErrorKind::AlreadyExists.into())) {
            Ok((name, file)) => {
                // After a failure it has to show first that it can be written.
                if self.now.state.problem().is_none() {
                    self.enter(RecorderState::Recording { file: name.clone() }, now);
                }
                self.format.begin(now, begun_unix_us);
                self.open = Some(OpenFile { name, file, bytes: 0, begun_at: now });
                self.enforce_quota();
            }
            Err(error) => self.fail(&error, now),
        }
    }

    /// Stops writing when the disk is nearly full.
    fn has_space(&mut self, now: MonoTime) -> bool {
        match self.storage.free_bytes() {
            // A disk that cannot say is tried: writing will tell.
            Err(_) => true,
            Ok(free_bytes) if free_bytes >= self.config.free_floor_bytes => true,
            Ok(free_bytes) => {
                let floor_bytes = self.config.free_floor_bytes;
                self.stop(RecorderState::LowSpace { free_bytes, floor_bytes }, now);
                false
            }
        }
    }

    fn fail(&mut self, error: &io::Error, now: MonoTime) {
        self.stop(RecorderState::Failing { error: error.to_string() }, now);
    }

    /// Ends the file and waits before the next try, longer each time.
    fn stop(&mut self, state: RecorderState, now: MonoTime) {
        // Behind bytes that were not written nothing more is.
        self.end_file(!matches!(state, RecorderState::Failing { .. }));
        self.retry_at = now + self.retry_wait;
        self.retry_wait = (self.retry_wait * 2).min(self.config.retry_at_most);
        self.enter(state, now);
    }

    fn enter(&mut self, state: RecorderState, now: MonoTime) {
        if state.problem().is_some() != self.now.state.problem().is_some() {
            self.now.since = now;
        }
        self.now.state = state;
    }

    /// Deletes the oldest recordings until all together fit; what somebody keeps does not count. What cannot be listed or
    /// deleted is left as it is.
    fn enforce_quota(&mut self) {
        let Ok(files) = self.storage.list() else { return };
        let mut recordings: Vec<_> = files
            .into_iter()
            .filter(|file| !file.is_kept)
            .filter_map(|file| Some((self.format.names().age_key(&file.name)?, file)))
            .collect();
        recordings.sort_by(|(a, _), (b, _)| a.cmp(b));
        let mut total: u64 = recordings.iter().map(|(_, file)| file.bytes).sum();
        for (_, file) in recordings {
            if total <= self.config.quota_bytes {
                return;
            }
            let is_current = self.open.as_ref().is_some_and(|open| open.name == file.name);
            if !is_current && self.storage.remove(&file.name).is_ok() {
                total -= file.bytes;
            }
        }
    }

    /// Closes the file; a recording of nothing is not left behind.
    fn end_file(&mut self, is_sound: bool) {
        self.batch.clear();
        if is_sound && self.open.as_ref().is_some_and(|open| open.bytes > 0) {
            self.format.end(&mut self.batch);
        }
        // Whatever fails now has been, or will be, reported by the next try.
        let _ = self.put_out();
        let Some(mut open) = self.open.take() else { return };
        let _ = open.file.sync();
        drop(open.file);
        if open.bytes == 0 {
            let _ = self.storage.remove(&open.name);
        }
    }

    fn close(&mut self) {
        self.end_file(true);
        self.enter(RecorderState::Closed, self.clock.now());
        self.publish();
    }

    fn publish(&mut self) {
        self.status.send_if_modified(|status| {
            let changed = *status != self.now;
            status.clone_from(&self.now);
            changed
        });
    }
}

#[cfg(test)]
mod tests;
