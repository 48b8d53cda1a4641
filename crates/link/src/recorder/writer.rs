//! The work of the recorder's thread, without the thread.

use std::collections::{BTreeSet, VecDeque};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::MonoTime;

use super::format::Format;
use super::status::{RecorderConfig, RecorderState, RecorderStatus, SYNC_INTERVAL, WRITE_INTERVAL};
use super::storage::{Names, Storage, StorageFile, Syncing, utc_stamp};
use crate::clock::Clock;

/// Most files open at a time; further ones are reopened for each write.
pub(super) const MAX_OPEN: usize = 64;
/// Most syncs per second: a laptop's disk takes some 5 ms for one.
const SYNCS_PER_S: u32 = 100;
/// Most syncs in progress: as many as end before the writer looks again.
const SYNCS_AT_ONCE: usize = SYNCS_PER_S as usize / 5;
/// Written data is synced after this time at the latest, if the disk keeps up.
const LATEST_SYNC: Duration = Duration::from_secs(10);
/// The files being written may take one part in this many of the quota: they are never deleted.
const CURRENT_PART: u64 = 4;
/// No file is ended for that below this size.
const LEAST_FILE_BYTES: u64 = 64 << 10;

/// A file being written.
struct OpenFile {
    name: String,
    /// `None` while it is closed between writes.
    file: Option<Box<dyn StorageFile>>,
    bytes: u64,
    begun_at: MonoTime,
    /// Whether some of it may not be synced.
    is_unsynced: bool,
}

/// What all lines share: the folder, and what may be in it.
struct House {
    storage: Box<dyn Storage>,
    config: RecorderConfig,
    clock: Arc<dyn Clock>,
    lines: u32,
    /// Files that are being written.
    current: BTreeSet<String>,
    /// Those of them that are open.
    open_files: usize,
    /// Syncs in progress.
    syncs: usize,
    /// When a sync ended last, or none was in progress.
    answered_at: MonoTime,
    /// Free space when the disk was asked last, and when that was.
    free: Option<(MonoTime, Option<u64>)>,
    /// When the quota was checked last.
    tidied_at: Option<MonoTime>,
}

impl House {
    /// How often a file is synced: each second; with many files as often as the disk can.
    fn sync_interval(&self) -> Duration {
        (SYNC_INTERVAL * self.lines / SYNCS_PER_S).clamp(SYNC_INTERVAL, LATEST_SYNC)
    }

    /// The size at which a file is full. With many lines it is less, so that the quota has room for files that are not
    /// being written.
    fn file_bytes(&self) -> u64 {
        let share = self.config.quota_bytes / CURRENT_PART / u64::from(self.lines.max(1));
        if self.lines > 1 {
            self.config.max_file_bytes.min(share.max(LEAST_FILE_BYTES))
        } else {
            self.config.max_file_bytes
        }
    }

    /// Why nothing may be written: the disk is nearly full. Checked once for all lines that ask together.
    fn lacks_space(&mut self, now: MonoTime) -> Option<RecorderState> {
        let fresh = self.free.filter(|(at, _)| now.since(*at) < WRITE_INTERVAL);
        let (_, free_bytes) = *self.free.insert(fresh.unwrap_or_else(|| (now, self.storage.free_bytes().ok())));
        // When the disk does not report it, a write shows it.
        let floor_bytes = self.config.free_floor_bytes;
        free_bytes
            .filter(|free_bytes| *free_bytes < floor_bytes)
            .map(|free_bytes| RecorderState::LowSpace { free_bytes, floor_bytes })
    }

    /// Deletes the oldest recordings until the rest fits into the quota; kept ones do not count. What cannot be listed
    /// or deleted is left.
    fn tidy(&mut self, names: &Names, now: MonoTime) {
        if self.tidied_at.is_some_and(|at| now.since(at) < self.sync_interval()) {
            return;
        }
        self.tidied_at = Some(now);
        let Ok(files) = self.storage.list() else { return };
        let mut recordings: Vec<_> = files
            .into_iter()
            .filter(|file| !file.is_kept)
            .filter_map(|file| Some((names.age_key(&file.name)?, file)))
            .collect();
        recordings.sort_by(|(a, _), (b, _)| a.cmp(b));
        let mut total: u64 = recordings.iter().map(|(_, file)| file.bytes).sum();
        for (_, file) in recordings {
            if total <= self.config.quota_bytes {
                return;
            }
            if !self.current.contains(&file.name) && self.storage.remove(&file.name).is_ok() {
                total -= file.bytes;
            }
        }
    }

    /// A file, opened again where it rests.
    fn file<'a>(&mut self, open: &'a mut OpenFile) -> io::Result<&'a mut dyn StorageFile> {
        if open.file.is_none() {
            open.file = Some(self.storage.append(&open.name, open.bytes)?);
            self.open_files += 1;
        }
        Ok(open.file.as_mut().expect("invariant: opened above").as_mut())
    }

    fn rest(&mut self, open: &mut OpenFile) {
        if open.file.take().is_some() {
            self.open_files -= 1;
        }
    }
}

/// All lines of a thread.
pub(super) struct Writers<F: Format> {
    house: House,
    lines: Vec<(Writer<F>, VecDeque<F::Item>)>,
    /// Whose turn it is to be forced to the disk.
    next: usize,
    /// Since when it has been waiting for the disk, in a call because of one line or for something to be forced to it,
    /// µs on the clock plus one; 0 while it does not.
    pub(super) busy_since_us: Arc<AtomicU64>,
}

impl<F: Format> Writers<F> {
    pub(super) fn new(storage: Box<dyn Storage>, config: RecorderConfig, clock: Arc<dyn Clock>) -> Self {
        let config = RecorderConfig { quota_bytes: config.quota_bytes.max(config.max_file_bytes), ..config };
        let house = House {
            storage,
            config,
            clock,
            lines: 0,
            current: BTreeSet::new(),
            open_files: 0,
            syncs: 0,
            answered_at: MonoTime::ZERO,
            free: None,
            tidied_at: None,
        };
        Self { house, lines: Vec::new(), next: 0, busy_since_us: Arc::default() }
    }

    pub(super) fn add(&mut self, newcomers: Vec<Writer<F>>) {
        self.lines.extend(newcomers.into_iter().map(|writer| (writer, VecDeque::new())));
        self.house.lines = u32::try_from(self.lines.len()).unwrap_or(u32::MAX);
    }

    /// Writes what came, each item with the number of its line. Called several times a second, also without any.
    pub(super) fn on_items(&mut self, items: VecDeque<(usize, F::Item)>, dropped: &[u64]) {
        let now = self.mark_busy();
        if self.house.syncs == 0 {
            self.house.answered_at = now;
        }
        for (line, item) in items {
            self.lines[line].1.push_back(item);
        }
        for line in 0..self.lines.len() {
            let (writer, waiting) = &mut self.lines[line];
            writer.on_items(&mut self.house, waiting, dropped.get(line).copied().unwrap_or(0), now);
            waiting.clear();
            self.mark_busy();
        }
        // So long that what comes meanwhile has room; the others have their turn after it.
        let (count, from) = (self.lines.len(), self.next);
        for line in (0..count).map(|step| (from + step) % count) {
            if self.house.syncs >= SYNCS_AT_ONCE {
                break;
            }
            self.lines[line].0.look_after(&mut self.house, now);
            self.next = line + 1;
            if self.mark_busy().since(now) >= WRITE_INTERVAL {
                break;
            }
        }
        self.publish();
        let waits_since = (self.house.syncs > 0).then_some(self.house.answered_at);
        self.busy_since_us.store(waits_since.map_or(0, |since| since.as_micros() + 1), Ordering::Release);
    }

    pub(super) fn close(&mut self) {
        for line in 0..self.lines.len() {
            self.mark_busy();
            self.lines[line].0.close(&mut self.house);
        }
        self.publish();
    }

    /// From now on it waits for the disk, for another line than before.
    fn mark_busy(&self) -> MonoTime {
        let now = self.house.clock.now();
        self.busy_since_us.store(now.as_micros() + 1, Ordering::Release);
        now
    }

    fn publish(&self) {
        self.lines.iter().for_each(|(writer, _)| writer.publish());
    }

    #[cfg(test)]
    pub(super) fn line(&self, number: usize) -> &Writer<F> {
        &self.lines[number].0
    }

    #[cfg(test)]
    pub(super) fn open_files(&self) -> usize {
        self.house.open_files
    }
}

/// One line: a file that grows, and each that follows it.
pub(super) struct Writer<F: Format> {
    format: F,
    status: watch::Sender<RecorderStatus>,
    now: RecorderStatus,
    open: Option<OpenFile>,
    /// Not before this moment is writing tried again.
    pub(super) retry_at: MonoTime,
    /// How long is waited after the next failure.
    pub(super) retry_wait: Duration,
    /// When it was forced to the disk last, or that was begun.
    synced_at: MonoTime,
    /// What is being forced to the disk, each with the frames written before, in their order.
    syncing: VecDeque<(u64, Syncing)>,
    batch: Vec<u8>,
}

impl<F: Format> Writer<F> {
    pub(super) fn new(format: F, retry_wait: Duration, started: MonoTime) -> (Self, watch::Receiver<RecorderStatus>) {
        let now = RecorderStatus {
            state: RecorderState::Starting,
            since: started,
            frames: 0,
            synced: 0,
            bytes: 0,
            dropped: 0,
            failures: 0,
        };
        let (status, watch) = watch::channel(now.clone());
        let writer = Self {
            format,
            status,
            now,
            open: None,
            retry_at: started,
            retry_wait,
            synced_at: started,
            syncing: VecDeque::new(),
            batch: Vec::new(),
        };
        (writer, watch)
    }

    fn on_items(&mut self, house: &mut House, items: &VecDeque<F::Item>, dropped: u64, now: MonoTime) {
        self.now.dropped += dropped;
        self.on_synced(house, now);
        if self.open.is_none() && now >= self.retry_at && (F::BEGINS_AT_ONCE || !items.is_empty()) {
            self.begin(house, now);
        }
        if let Err((error, lost)) = self.write(house, items) {
            self.now.dropped += lost;
            self.fail(house, &error, now);
        }
        // Also while a slow disk is waited for: what is being written is never deleted for the quota.
        if house.syncs > 0 && self.is_full(house, now) {
            self.next_file(house, now);
        }
        self.spare(house);
    }

    /// Forces what was written to the disk, where that is due and not under way.
    fn look_after(&mut self, house: &mut House, now: MonoTime) {
        if !self.syncing.is_empty() {
            return;
        }
        let has_to_prove = self.open.is_some() && self.now.state.problem().is_some();
        if has_to_prove || now.since(self.synced_at) >= house.sync_interval() {
            self.synced_at = now;
            self.keep_house(house, now);
            self.spare(house);
        }
    }

    /// Lets its file rest where too many are open.
    fn spare(&mut self, house: &mut House) {
        if house.open_files > MAX_OPEN
            && let Some(open) = &mut self.open
        {
            house.rest(open);
        }
    }

    fn write(&mut self, house: &mut House, items: &VecDeque<F::Item>) -> Result<(), (io::Error, u64)> {
        if self.open.is_none() {
            self.now.dropped += items.len() as u64;
            return Ok(());
        }
        self.format.write(items, &mut self.batch);
        self.put_out(house).map_err(|error| (error, items.len() as u64))?;
        self.now.frames += items.len() as u64;
        Ok(())
    }

    /// Hands the batch to the system.
    fn put_out(&mut self, house: &mut House) -> io::Result<()> {
        let batch = std::mem::take(&mut self.batch);
        let Some(open) = self.open.as_mut().filter(|_| !batch.is_empty()) else { return Ok(()) };
        house.file(open)?.write_all(&batch)?;
        open.bytes += batch.len() as u64;
        open.is_unsynced = true;
        self.now.bytes += batch.len() as u64;
        self.batch = batch;
        self.batch.clear();
        Ok(())
    }

    /// Begins to force to the disk, looks at free space and quota, and begins the next file when this one is full.
    fn keep_house(&mut self, house: &mut House, now: MonoTime) {
        if self.open.is_some() {
            self.format.flush(&mut self.batch);
        }
        if let Err(error) = self.put_out(house) {
            return self.fail(house, &error, now);
        }
        self.sync(house);
        self.on_synced(house, now);
        if self.is_full(house, now) {
            self.next_file(house, now);
        } else if self.open.is_some() && self.has_space(house, now) {
            house.tidy(self.format.names(), now);
        }
    }

    /// Whether its file has reached its size or age.
    fn is_full(&self, house: &House, now: MonoTime) -> bool {
        self.open.as_ref().is_some_and(|open| {
            let is_old = house.config.max_file_age.is_some_and(|age| now.since(open.begun_at) >= age);
            is_old || open.bytes >= house.file_bytes()
        })
    }

    fn next_file(&mut self, house: &mut House, now: MonoTime) {
        self.end_file(house, true);
        if F::BEGINS_AT_ONCE {
            self.begin(house, now);
        }
    }

    /// Begins to force to the disk what has not been.
    fn sync(&mut self, house: &mut House) {
        let Some(open) = self.open.as_mut().filter(|open| open.is_unsynced) else { return };
        open.is_unsynced = false;
        let syncing = house.file(open).map_or_else(|error| Syncing::ended(Err(error)), StorageFile::sync);
        self.syncing.push_back((self.now.frames, syncing));
        house.syncs += 1;
    }

    /// Takes in how forcing to the disk ended.
    fn on_synced(&mut self, house: &mut House, now: MonoTime) {
        while let Some(end) = self.syncing.front().and_then(|(_, syncing)| syncing.end()) {
            let frames = self.syncing.pop_front().map_or(0, |(frames, _)| frames);
            house.syncs -= 1;
            house.answered_at = now;
            if let Err(error) = end {
                return self.fail(house, &error, now);
            }
            self.now.synced = frames;
            self.retry_wait = house.config.retry_after;
            if self.now.state.problem().is_some()
                && let Some(open) = &self.open
            {
                self.enter(RecorderState::Recording { file: open.name.clone() }, now);
            }
        }
    }

    /// Opens a new file, unless there is no space.
    fn begin(&mut self, house: &mut House, now: MonoTime) {
        if !self.has_space(house, now) {
            return;
        }
        let begun_unix_us = house.clock.unix_us();
        let stamp = utc_stamp(begun_unix_us / 1_000_000);
        let created = (0..1000).find_map(|number| {
            let name = self.format.names().name(&stamp, number);
            match house.storage.create_new(&name) {
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
                house.open_files += 1;
                house.current.insert(name.clone());
                self.open = Some(OpenFile { name, file: Some(file), bytes: 0, begun_at: now, is_unsynced: true });
                house.tidy(self.format.names(), now);
            }
            Err(error) => self.fail(house, &error, now),
        }
    }

    /// Stops writing when the disk is nearly full.
    fn has_space(&mut self, house: &mut House, now: MonoTime) -> bool {
        let lack = house.lacks_space(now);
        let has_space = lack.is_none();
        if let Some(lack) = lack {
            self.stop(house, lack, now);
        }
        has_space
    }

    fn fail(&mut self, house: &mut House, error: &io::Error, now: MonoTime) {
        self.stop(house, RecorderState::Failing { error: error.to_string() }, now);
    }

    /// Ends the file and waits before the next try, longer each time.
    fn stop(&mut self, house: &mut House, state: RecorderState, now: MonoTime) {
        // Behind bytes that were not written nothing more is, and nothing of that file counts as safe.
        let is_sound = !matches!(state, RecorderState::Failing { .. });
        self.end_file(house, is_sound);
        if !is_sound {
            house.syncs -= self.syncing.len();
            self.syncing.clear();
        }
        self.now.failures += 1;
        self.retry_at = now + self.retry_wait;
        self.retry_wait = (self.retry_wait * 2).min(house.config.retry_at_most);
        self.enter(state, now);
    }

    fn enter(&mut self, state: RecorderState, now: MonoTime) {
        if state.problem().is_some() != self.now.state.problem().is_some() {
            self.now.since = now;
        }
        self.now.state = state;
    }

    /// Closes the file; a recording of nothing is not left behind.
    fn end_file(&mut self, house: &mut House, is_sound: bool) {
        self.batch.clear();
        if is_sound && self.open.as_ref().is_some_and(|open| open.bytes > 0) {
            self.format.end(&mut self.batch);
        }
        // Whatever fails now has been, or will be, reported by the next try.
        let _ = self.put_out(house);
        self.sync(house);
        let Some(mut open) = self.open.take() else { return };
        house.rest(&mut open);
        house.current.remove(&open.name);
        if open.bytes == 0 {
            // While it is forced to the disk it is in use.
            self.settle(house);
            let _ = house.storage.remove(&open.name);
        }
    }

    /// Waits for all that is being forced to the disk. Whether that was done.
    fn settle(&mut self, house: &mut House) -> bool {
        house.syncs -= self.syncing.len();
        self.syncing.drain(..).all(|(frames, syncing)| {
            let is_done = syncing.wait().is_ok();
            if is_done {
                self.now.synced = frames;
            }
            is_done
        })
    }

    fn close(&mut self, house: &mut House) {
        self.end_file(house, true);
        if !self.settle(house) {
            self.now.failures += 1;
        }
        self.enter(RecorderState::Closed, house.clock.now());
    }

    fn publish(&self) {
        self.status.send_if_modified(|status| {
            let changed = *status != self.now;
            status.clone_from(&self.now);
            changed
        });
    }
}
