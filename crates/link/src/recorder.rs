//! Owns the recording of all frames, both ways, to `.tlog` files: one per session, never overwritten, in a folder of
//! their own.
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

use std::collections::{HashSet, VecDeque};
use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{Frame, MonoTime};
use vencejo_store::{Floors, Space};

use crate::clock::Clock;
use crate::port::LinkId;
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
/// A disk that has not answered for so long counts as one that does not write.
const STALLED_AFTER: Duration = Duration::from_secs(3);
/// The end of the name of the empty file beside a recording that somebody keeps.
const KEPT: &str = ".keep";

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
    /// The wait before another try when writing has failed, 1 s by default; it doubles with each try that fails.
    pub retry_after: Duration,
    /// The longest wait before another try, 30 s by default.
    pub retry_at_most: Duration,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self {
            max_file_bytes: 512 << 20,
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

/// A recording in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// The file's name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// Whether somebody keeps it, so that it is not deleted to make room.
    pub is_kept: bool,
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
    /// Deletes a file that nobody is writing.
    ///
    /// # Errors
    /// [`io::ErrorKind::WouldBlock`] when another process is writing it, otherwise whatever the disk says.
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
    space: Space,
}

impl Folder {
    /// The folder at `path`, made when the first recording is.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), space: Space::default() }
    }

    /// The same on a disk whose free space something else tells.
    #[must_use]
    pub fn with_space(self, space: Space) -> Self {
        Self { space, ..self }
    }
}

/// Whether somebody keeps a recording of a folder.
#[must_use]
pub fn is_kept_recording(folder: &std::path::Path, name: &str) -> bool {
    folder.join(format!("{name}{KEPT}")).exists()
}

/// Keeps a recording of a folder: it is not deleted to make room for new ones. Or lets it go again.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] when there is none of that name, otherwise whatever the disk says.
pub fn keep_recording(folder: &std::path::Path, name: &str, is_kept: bool) -> io::Result<()> {
    if age_key(name).is_none() || !folder.join(name).is_file() {
        return Err(io::ErrorKind::NotFound.into());
    }
    let mark = folder.join(format!("{name}{KEPT}"));
    if is_kept {
        return vencejo_store::create(&mark, b"", vencejo_store::Access::Usual).map(drop);
    }
    match fs::remove_file(&mark) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => vencejo_store::sync_folder(folder),
    }
}

impl Storage for Folder {
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>> {
        vencejo_store::make_folder(&self.path)?;
        let file = fs::OpenOptions::new().write(true).create_new(true).open(self.path.join(name))?;
        // So that no other process deletes it to make room. Nobody else can have it yet.
        vencejo_store::lock::try_hold(&file)?;
        vencejo_store::sync_folder(&self.path)?;
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
                files.push(StoredFile { name, bytes: metadata.len(), is_kept: false });
            }
        }
        let names: HashSet<String> = files.iter().map(|file| file.name.clone()).collect();
        for file in &mut files {
            file.is_kept = names.contains(&format!("{}{KEPT}", file.name));
        }
        Ok(files)
    }

    fn remove(&mut self, name: &str) -> io::Result<()> {
        let path = self.path.join(name);
        if !vencejo_store::lock::try_hold(&fs::File::open(&path)?)? {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        fs::remove_file(path)
    }

    fn free_bytes(&mut self) -> io::Result<u64> {
        self.space.free_bytes(&self.path)
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
    /// Since when the thread has been waiting for the disk, µs on the clock plus one; 0 while it does not.
    busy_since_us: AtomicU64,
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
        let shared = Arc::new(Shared::default());
        let (mut writer, status) = Writer::new(storage, config, clock.clone());
        let (queue, watched) = (shared.clone(), clock.clone());
        let thread = std::thread::Builder::new().name("vencejo-recorder".to_owned()).spawn(move || {
            loop {
                let (batch, dropped, closing) = wait(&queue);
                queue.busy_since_us.store(watched.now().as_micros() + 1, Ordering::Release);
                writer.on_frames(&batch, dropped);
                if closing {
                    return writer.close();
                }
                queue.busy_since_us.store(0, Ordering::Release);
            }
        })?;
        Ok(Self { shared, clock, status, thread: Some(thread) })
    }

    /// The way in, for [`Hub::set_recorder`](crate::Hub::set_recorder).
    pub fn handle(&self) -> RecorderHandle {
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
    newest_us: u64,
}

impl OpenFile {
    /// The time of the next entry, never less than that of the last: what is received and what is sent come from several
    /// threads, whose moments overtake each other by some 0.1 ms on the way here. Some readers take the lowest two bits as the
    /// number of the link.
    fn next_unix_us(&mut self, at: MonoTime, link: LinkId) -> u64 {
        let base = i128::from(self.begun_unix_us);
        let offset = i128::from(at.as_micros()) - i128::from(self.begun_at.as_micros());
        self.newest_us = self.newest_us.max(u64::try_from(base + offset).unwrap_or(0) & !3);
        self.newest_us | u64::from(link.0.wrapping_sub(1) & 3)
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
    /// How long is waited after the next failure.
    retry_wait: Duration,
    synced_at: MonoTime,
    batch: Vec<u8>,
}

impl Writer {
    fn new(
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
        let has_to_prove = self.open.is_some() && self.now.state.problem().is_some();
        if has_to_prove || now.since(self.synced_at) >= SYNC_INTERVAL {
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
            write_entry(&mut self.batch, open.next_unix_us(noted.at, noted.link), &noted.frame);
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
        let (file, is_full) = (open.name.clone(), open.bytes >= self.config.max_file_bytes);
        self.retry_wait = self.config.retry_after;
        if self.now.state.problem().is_some() {
            self.enter(RecorderState::Recording { file }, now);
        }
        if is_full {
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
                // After a failure it has to show first that it can be written.
                if self.now.state.problem().is_none() {
                    self.enter(RecorderState::Recording { file: name.clone() }, now);
                }
                self.open = Some(OpenFile { name, file, bytes: 0, begun_at: now, begun_unix_us, newest_us: 0 });
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
        self.end_file();
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
            .filter_map(|file| Some((age_key(&file.name)?, file)))
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

/// No recording of ours is older.
const CLOCK_SET: &str = "2020";

/// `2026-11-21T08-50-12Z.tlog`, with a number when that one is taken.
fn file_name(stamp: &str, number: u32) -> String {
    if number == 0 { format!("{stamp}.tlog") } else { format!("{stamp}-{number}.tlog") }
}

/// The order of age of a name that [`file_name`] made; `None` for any other name. Those that were made before the clock of a
/// computer without a battery was set come last: nobody knows how old they are.
fn age_key(name: &str) -> Option<(bool, String, u32)> {
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
    Some((stamp < CLOCK_SET, stamp.to_owned(), number))
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
