//! Owns the recording of all frames, both ways, to `.tlog` files: one per session, never overwritten, in a folder of
//! their own.
//!
//! The links' tasks only put frames into a bounded queue; a thread of its own writes. Nothing that happens to the disk
//! reaches the links: frames that cannot be written are counted, the reason is in the [`RecorderStatus`], and the
//! recorder tries again.
//!
//! What is written at most five times a second is handed to the system, and once a second forced to the disk. The
//! folder is kept below a quota by deleting the oldest recordings (files named as the recorder names them, nothing
//! else, never the one being written); below a floor of free space nothing is written at all.

use std::collections::VecDeque;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{Frame, MonoTime};

use crate::clock::Clock;
use crate::hub::LinkId;
use crate::router::SETUP_SIGNING_ID;
use crate::tlog::write_entry;

/// Frames that wait for the disk: about 16 s at 1,000 frames/s. Overflow: the oldest are dropped and counted.
const QUEUE_FRAMES: usize = 16_384;
/// So many waiting frames wake the writer before its time.
const WAKE_FRAMES: usize = QUEUE_FRAMES / 4;
/// How often the writer looks for frames.
const WRITE_INTERVAL: Duration = Duration::from_millis(200);
/// How often what was written is forced to the disk, and space and quota are looked at.
const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// The recorder's limits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderConfig {
    /// A file that has grown to this size is closed, and the next one begun. 512 MiB by default: about two days of an
    /// aircraft at 10 Hz.
    pub max_file_bytes: u64,
    /// What all recordings of the folder may take together, 8 GiB by default. Never less than one file.
    pub quota_bytes: u64,
    /// Free space of the disk below which nothing is written, 500 MB by default.
    pub free_floor_bytes: u64,
    /// The wait before another try when writing has failed, 5 s by default.
    pub retry_after: Duration,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self {
            max_file_bytes: 512 << 20,
            quota_bytes: 8 << 30,
            free_floor_bytes: 500_000_000,
            retry_after: Duration::from_secs(5),
        }
    }
}

/// How the recording is going.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderStatus {
    /// What it is doing.
    pub state: RecorderState,
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
    /// Closed.
    Closed,
}

/// A recording in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// The file's name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
}

/// Where recordings are kept; injected, so that tests can let it fail.
pub trait Storage: Send {
    /// Makes a file that does not exist yet.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`] when it does, otherwise whatever the disk says.
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>>;
    /// All files.
    ///
    /// # Errors
    /// Whatever the disk says.
    fn list(&mut self) -> io::Result<Vec<StoredFile>>;
    /// Deletes a file.
    ///
    /// # Errors
    /// Whatever the disk says.
    fn remove(&mut self, name: &str) -> io::Result<()>;
    /// Free space.
    ///
    /// # Errors
    /// Whatever the disk says.
    fn free_bytes(&mut self) -> io::Result<u64>;
}

/// A recording being written.
pub trait StorageFile: Write + Send {
    /// Forces what was written to the disk.
    ///
    /// # Errors
    /// Whatever the disk says.
    fn sync(&mut self) -> io::Result<()>;
}

/// A folder of the file system.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder at `path`, made when the first recording is.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Makes the entry of a new file durable too.
    fn sync_folder(&self) -> io::Result<()> {
        #[cfg(unix)]
        fs::File::open(&self.path)?.sync_all()?;
        Ok(())
    }
}

impl Storage for Folder {
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>> {
        fs::create_dir_all(&self.path)?;
        let file = fs::OpenOptions::new().write(true).create_new(true).open(self.path.join(name))?;
        self.sync_folder()?;
        Ok(Box::new(file))
    }

    fn list(&mut self) -> io::Result<Vec<StoredFile>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let metadata = entry.metadata()?;
            if metadata.is_file()
                && let Ok(name) = entry.file_name().into_string()
            {
                files.push(StoredFile { name, bytes: metadata.len() });
            }
        }
        Ok(files)
    }

    fn remove(&mut self, name: &str) -> io::Result<()> {
        fs::remove_file(self.path.join(name))
    }

    #[cfg(unix)]
    fn free_bytes(&mut self) -> io::Result<u64> {
        let existing = self.path.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
        let facts = rustix::fs::statvfs(existing)?;
        Ok(facts.f_bavail.saturating_mul(facts.f_frsize))
    }

    #[cfg(not(unix))]
    fn free_bytes(&mut self) -> io::Result<u64> {
        Ok(u64::MAX)
    }
}

impl StorageFile for fs::File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

/// A frame on its way to the disk.
struct Noted {
    at: MonoTime,
    link: LinkId,
    frame: Frame,
}

#[derive(Default)]
struct Queue {
    frames: VecDeque<Noted>,
    dropped: u64,
    closing: bool,
}

#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    wake: Condvar,
}

impl Shared {
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The way into a recorder. Never waits.
#[derive(Clone)]
pub struct RecorderHandle {
    shared: Arc<Shared>,
}

impl RecorderHandle {
    /// Notes a frame that was received or sent. Keys (`SETUP_SIGNING`) are not recorded.
    pub fn record(&self, link: LinkId, frame: &Frame, now: MonoTime) {
        if frame.message_id() == SETUP_SIGNING_ID {
            return;
        }
        let mut queue = self.shared.queue();
        if queue.closing {
            return;
        }
        if queue.frames.len() >= QUEUE_FRAMES {
            queue.frames.pop_front();
            queue.dropped += 1;
        }
        queue.frames.push_back(Noted { at: now, link, frame: frame.clone() });
        let wake = queue.frames.len() == WAKE_FRAMES;
        drop(queue);
        if wake {
            self.shared.wake.notify_one();
        }
    }
}

/// A running recorder. Dropping it ends the recording in the background; [`Self::close`] waits until it is on the disk.
pub struct Recorder {
    shared: Arc<Shared>,
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
        let shared = Arc::new(Shared::default());
        let (mut writer, status) = Writer::new(storage, config, clock);
        let queue = shared.clone();
        let thread = std::thread::Builder::new().name("vencejo-recorder".to_owned()).spawn(move || {
            loop {
                let (batch, dropped, closing) = wait(&queue);
                writer.on_frames(&batch, dropped);
                if closing {
                    return writer.close();
                }
            }
        })?;
        Ok(Self { shared, status, thread: Some(thread) })
    }

    /// The way in, for [`Hub::set_recorder`](crate::Hub::set_recorder).
    pub fn handle(&self) -> RecorderHandle {
        RecorderHandle { shared: self.shared.clone() }
    }

    /// How it is going.
    pub fn status(&self) -> RecorderStatus {
        self.status.borrow().clone()
    }

    /// How it is going, as it changes (about once a second).
    pub fn watch(&self) -> watch::Receiver<RecorderStatus> {
        self.status.clone()
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

impl Drop for Recorder {
    fn drop(&mut self) {
        self.stop();
    }
}

fn wait(shared: &Shared) -> (VecDeque<Noted>, u64, bool) {
    let idle = |queue: &mut Queue| !queue.closing && queue.frames.len() < WAKE_FRAMES;
    let waited = shared.wake.wait_timeout_while(shared.queue(), WRITE_INTERVAL, idle);
    let (mut queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
    let dropped = std::mem::take(&mut queue.dropped);
    (std::mem::take(&mut queue.frames), dropped, queue.closing)
}

/// A file being written. Its times follow the monotonic clock from the wall time at which it was begun, so that they
/// never step back when the wall clock is set.
struct OpenFile {
    name: String,
    file: Box<dyn StorageFile>,
    bytes: u64,
    begun_at: MonoTime,
    begun_unix_us: u64,
}

impl OpenFile {
    fn unix_us(&self, at: MonoTime) -> u64 {
        let base = i128::from(self.begun_unix_us);
        let offset = i128::from(at.as_micros()) - i128::from(self.begun_at.as_micros());
        u64::try_from(base + offset).unwrap_or(0)
    }
}

/// What the thread does, without the thread.
struct Writer {
    storage: Box<dyn Storage>,
    config: RecorderConfig,
    clock: Arc<dyn Clock>,
    status: watch::Sender<RecorderStatus>,
    now: RecorderStatus,
    open: Option<OpenFile>,
    /// Not before this moment is writing tried again.
    retry_at: MonoTime,
    synced_at: MonoTime,
    batch: Vec<u8>,
}

impl Writer {
    fn new(
        storage: Box<dyn Storage>,
        config: RecorderConfig,
        clock: Arc<dyn Clock>,
    ) -> (Self, watch::Receiver<RecorderStatus>) {
        let now = RecorderStatus { state: RecorderState::Starting, frames: 0, bytes: 0, dropped: 0 };
        let (status, watch) = watch::channel(now.clone());
        let started = clock.now();
        let config = RecorderConfig { quota_bytes: config.quota_bytes.max(config.max_file_bytes), ..config };
        let writer = Self {
            storage,
            config,
            clock,
            status,
            now,
            open: None,
            retry_at: started,
            synced_at: started,
            batch: Vec::new(),
        };
        (writer, watch)
    }

    /// Writes frames. Called several times a second, also without any.
    fn on_frames(&mut self, frames: &VecDeque<Noted>, dropped: u64) {
        let now = self.clock.now();
        self.now.dropped += dropped;
        if self.open.is_none() && now >= self.retry_at {
            self.begin(now);
        }
        if let Err((error, lost)) = self.write(frames) {
            self.now.dropped += lost;
            self.fail(&error, now);
        }
        if now.since(self.synced_at) >= SYNC_INTERVAL {
            self.synced_at = now;
            self.keep_house(now);
        }
        self.publish();
    }

    fn write(&mut self, frames: &VecDeque<Noted>) -> Result<(), (io::Error, u64)> {
        let Some(open) = &mut self.open else {
            self.now.dropped += frames.len() as u64;
            return Ok(());
        };
        self.batch.clear();
        for noted in frames {
            // Some readers take the lowest two bits as the number of the link.
            let unix_us = (open.unix_us(noted.at) & !3) | u64::from(noted.link.0.wrapping_sub(1) & 3);
            write_entry(&mut self.batch, unix_us, &noted.frame);
        }
        if let Err(error) = open.file.write_all(&self.batch) {
            return Err((error, frames.len() as u64));
        }
        open.bytes += self.batch.len() as u64;
        self.now.frames += frames.len() as u64;
        self.now.bytes += self.batch.len() as u64;
        Ok(())
    }

    /// Forces to the disk, looks at free space and quota, and begins the next file when this one is full.
    fn keep_house(&mut self, now: MonoTime) {
        let Some(open) = &mut self.open else { return };
        if let Err(error) = open.file.sync() {
            return self.fail(&error, now);
        }
        if open.bytes >= self.config.max_file_bytes {
            self.open = None;
            return self.begin(now);
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
            let name = file_name(&stamp, number);
            match self.storage.create_new(&name) {
                Ok(file) => Some(Ok((name, file))),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => None,
                Err(error) => Some(Err(error)),
            }
        });
        match created.unwrap_or_else(|| Err(io::ErrorKind::AlreadyExists.into())) {
            Ok((name, file)) => {
                self.now.state = RecorderState::Recording { file: name.clone() };
                self.open = Some(OpenFile { name, file, bytes: 0, begun_at: now, begun_unix_us });
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
                self.end_file();
                self.retry_at = now + self.config.retry_after;
                self.now.state = RecorderState::LowSpace { free_bytes, floor_bytes: self.config.free_floor_bytes };
                false
            }
        }
    }

    fn fail(&mut self, error: &io::Error, now: MonoTime) {
        self.end_file();
        self.retry_at = now + self.config.retry_after;
        self.now.state = RecorderState::Failing { error: error.to_string() };
    }

    /// Deletes the oldest recordings until all together fit. What cannot be listed or deleted is left as it is.
    fn enforce_quota(&mut self) {
        let Ok(files) = self.storage.list() else { return };
        let mut recordings: Vec<_> = files.into_iter().filter_map(|file| Some((age_key(&file.name)?, file))).collect();
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
    fn end_file(&mut self) {
        let Some(mut open) = self.open.take() else { return };
        // Whatever fails now has been, or will be, reported by the next try.
        let _ = open.file.sync();
        drop(open.file);
        if open.bytes == 0 {
            let _ = self.storage.remove(&open.name);
        }
    }

    fn close(&mut self) {
        self.end_file();
        self.now.state = RecorderState::Closed;
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

/// `2026-11-21T08-50-12Z.tlog`, with a number when that one is taken.
fn file_name(stamp: &str, number: u32) -> String {
    if number == 0 { format!("{stamp}.tlog") } else { format!("{stamp}-{number}.tlog") }
}

/// The order of age of a name that [`file_name`] made; `None` for any other name.
fn age_key(name: &str) -> Option<(String, u32)> {
    let stem = name.strip_suffix(".tlog")?;
    let (stamp, rest) = stem.split_at_checked(20)?;
    let pattern = b"dddd-dd-ddTdd-dd-ddZ";
    let fits = stamp
        .bytes()
        .zip(pattern)
        .all(|(byte, kind)| if *kind == b'd' { byte.is_ascii_digit() } else { byte == *kind });
    if !fits {
        return None;
    }
    let number = match rest {
        "" => 0,
        rest => rest.strip_prefix('-')?.parse().ok()?,
    };
    Some((stamp.to_owned(), number))
}

/// The UTC time of a file name. Days to a date as in Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms".
fn utc_stamp(unix_s: u64) -> String {
    let (days, second) = (unix_s / 86_400, unix_s % 86_400);
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let day_of_era = shifted % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}-{:02}-{:02}Z", second / 3600, second / 60 % 60, second % 60)
}

#[cfg(test)]
mod tests;
