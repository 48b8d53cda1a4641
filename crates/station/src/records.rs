//! Persisted knowledge of the missions on board, one file per aircraft: read when the station starts and when a vehicle
//! is heard for the first time, written by a thread of its own.
//!
//! An unreadable file counts as a doubt, because it may have recorded one. It is left as it is until a new record
//! replaces it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use vencejo_proto::SystemId;
use vencejo_proto::plan_file::{decode_plan_file, encode_plan_file};
use vencejo_store::Access;
use vencejo_vehicle::{Doubt, PlanRecord, StoredRecord, VehicleId, VehicleKey, Writer};

/// Most records that are read; of more, the newest.
const MAX_RECORDS: usize = 256;
/// Longest file, bytes. A mission of 65,535 items in hexadecimal would be longer, but no vehicle holds that many.
const MAX_FILE: u64 = 1 << 20;
/// Suffix of the file names.
const ENDING: &str = ".json";

/// A record in its file format, JSON.
#[derive(Serialize, Deserialize)]
struct OnDisk {
    format: u32,
    system: Option<u8>,
    verified: Option<Fingerprint>,
    doubt: Option<DoubtOnDisk>,
}

#[derive(Serialize, Deserialize)]
struct Fingerprint {
    count: u16,
    hash: String,
}

#[derive(Serialize, Deserialize)]
struct DoubtOnDisk {
    writer: WriterOnDisk,
    /// The item list that was being sent: ArduPilot's plan file in hexadecimal.
    sent: Option<String>,
    before: Option<String>,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum WriterOnDisk {
    Us,
    Another,
    NotKnown,
}

impl From<Writer> for WriterOnDisk {
    fn from(writer: Writer) -> Self {
        match writer {
            Writer::Us => Self::Us,
            Writer::Another => Self::Another,
            Writer::NotKnown => Self::NotKnown,
        }
    }
}

impl From<WriterOnDisk> for Writer {
    fn from(writer: WriterOnDisk) -> Self {
        match writer {
            WriterOnDisk::Us => Self::Us,
            WriterOnDisk::Another => Self::Another,
            WriterOnDisk::NotKnown => Self::NotKnown,
        }
    }
}

const FORMAT: u32 = 1;

fn hash_text(hash: u64) -> String {
    format!("{hash:016x}")
}

fn hash_of(text: &str) -> Option<u64> {
    u64::from_str_radix(text, 16).ok()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let digits = text.as_bytes().chunks_exact(2);
    let is_whole = digits.remainder().is_empty();
    let bytes: Option<Vec<_>> =
        digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect();
    bytes.filter(|_| is_whole)
}

fn to_text(stored: &StoredRecord) -> String {
    let doubt = stored.record.doubt.as_ref().map(|doubt| DoubtOnDisk {
        writer: doubt.writer.into(),
        sent: doubt.sent.as_ref().map(|items| hex(&encode_plan_file(0, items))),
        before: doubt.before.map(hash_text),
    });
    let verified = stored.record.verified.map(|(count, hash)| Fingerprint { count, hash: hash_text(hash) });
    let on_disk = OnDisk { format: FORMAT, system: stored.system.map(|system| system.0), verified, doubt };
    serde_json::to_string_pretty(&on_disk).unwrap_or_default()
}

fn of_text(key: VehicleKey, text: &[u8]) -> Option<StoredRecord> {
    let on_disk: OnDisk = serde_json::from_slice(text).ok().filter(|on_disk: &OnDisk| on_disk.format == FORMAT)?;
    let doubt = on_disk.doubt.map(|doubt| Doubt {
        writer: doubt.writer.into(),
        sent: doubt.sent.and_then(|sent| Some(Arc::new(decode_plan_file(&unhex(&sent)?).ok()?.1))),
        before: doubt.before.as_deref().and_then(hash_of),
    });
    let verified = on_disk.verified.and_then(|verified| Some((verified.count, hash_of(&verified.hash)?)));
    Some(StoredRecord { key, system: on_disk.system.map(SystemId), record: PlanRecord { verified, doubt } })
}

/// The records in a folder, newest first. It blocks.
pub(crate) fn read_all(folder: &Path) -> Vec<StoredRecord> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<_> = entries
        .flatten()
        .filter_map(|entry| {
            let key = VehicleKey::parse(entry.file_name().to_str()?.strip_suffix(ENDING)?)?;
            let about = entry.metadata().ok()?;
            Some((about.modified().ok()?, key, entry.path(), about.len()))
        })
        .collect();
    files.sort_by(|one, other| other.cmp(one));
    files.truncate(MAX_RECORDS);
    let read = |(_, key, path, len): (_, VehicleKey, PathBuf, u64)| {
        let text = (len <= MAX_FILE).then(|| std::fs::read(&path).ok()).flatten();
        text.and_then(|text| of_text(key.clone(), &text)).unwrap_or_else(|| {
            tracing::warn!(file = %path.display(), "the record of a mission cannot be read: that mission is doubted");
            StoredRecord { system: key.system(), key, record: PlanRecord::damaged() }
        })
    };
    files.into_iter().map(read).collect()
}

fn write(folder: &Path, stored: &StoredRecord) -> std::io::Result<()> {
    let path = folder.join(format!("{}{ENDING}", stored.key));
    if stored.record == PlanRecord::default() {
        return match std::fs::remove_file(&path) {
            Ok(()) => vencejo_store::sync_folder(folder),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
            Err(error) => Err(error),
        };
    }
    vencejo_store::write(&path, to_text(stored).as_bytes(), Access::Owner)
}

/// How often writing is retried after a failure.
const TRY_AGAIN: Duration = Duration::from_secs(5);

/// The vehicle that wants a record written, and whose record it is.
type Key = (VehicleId, VehicleKey);
/// A record with its ticket.
type Ticketed = (u64, StoredRecord);
/// The newest record for each key, so that at most one per key waits for a slow disk.
type Newest = BTreeMap<Key, Ticketed>;

#[derive(Default)]
struct Waiting {
    records: Newest,
    /// Records whose writing has failed.
    unwritten: Newest,
    /// The error of the last failure.
    fault: String,
    is_closing: bool,
    is_last_try: bool,
}

impl Waiting {
    /// Queues the failed records again, except those with a newer record waiting.
    fn try_again(&mut self) {
        for (key, record) in &self.unwritten {
            self.records.entry(key.clone()).or_insert_with(|| record.clone());
        }
    }

    /// A record is on the disk: the failed ones are retried at once.
    fn on_written(&mut self, key: &Key) {
        self.unwritten.remove(key);
        self.try_again();
    }

    /// A record could not be written. Returns whether all others are on the disk.
    fn on_fault(&mut self, key: Key, record: Ticketed, fault: String) -> bool {
        let is_first = self.unwritten.is_empty();
        if self.unwritten.len() < MAX_RECORDS || self.unwritten.contains_key(&key) {
            self.unwritten.insert(key, record);
        }
        self.fault = fault;
        is_first
    }
}

#[derive(Default)]
struct Desk {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next record to write; `None` after closing, when every failed record has been tried a last time.
    fn next(&self) -> Option<(Key, Ticketed)> {
        let mut waiting = self.lock();
        loop {
            if let Some(next) = waiting.records.pop_first() {
                return Some(next);
            }
            if waiting.is_closing {
                if waiting.is_last_try {
                    return None;
                }
                waiting.is_last_try = true;
                waiting.try_again();
            } else if waiting.unwritten.is_empty() {
                waiting = self.news.wait(waiting).unwrap_or_else(PoisonError::into_inner);
            } else {
                let (woken, timeout) =
                    self.news.wait_timeout(waiting, TRY_AGAIN).unwrap_or_else(PoisonError::into_inner);
                waiting = woken;
                if timeout.timed_out() {
                    waiting.try_again();
                }
            }
        }
    }
}

/// The writer of the records.
pub(crate) struct Records {
    folder: PathBuf,
    desk: Arc<Desk>,
    thread: Option<JoinHandle<()>>,
}

impl Records {
    /// Starts the thread that writes into `folder`. It calls `on_kept` with the vehicle and the ticket of a record that
    /// is on the disk, or could not be written.
    pub(crate) fn start(folder: PathBuf, on_kept: impl Fn(VehicleId, u64) + Send + 'static) -> std::io::Result<Self> {
        let desk = Arc::new(Desk::default());
        let (theirs, into) = (desk.clone(), folder.clone());
        let thread = std::thread::Builder::new().name("vencejo records".to_owned()).spawn(move || {
            while let Some((key, (ticket, stored))) = theirs.next() {
                let system = key.0;
                match write(&into, &stored) {
                    Ok(()) => theirs.lock().on_written(&key),
                    Err(error) => {
                        if theirs.lock().on_fault(key, (ticket, stored), error.to_string()) {
                            tracing::error!(folder = %into.display(), %error, "the record of a mission cannot be written");
                        }
                    }
                }
                on_kept(system, ticket);
            }
        })?;
        Ok(Self { folder, desk, thread: Some(thread) })
    }

    /// Where the records are.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Why a record is not on the disk; `None` when all are. It is lost if the program ends before the disk works
    /// again.
    pub(crate) fn fault(&self) -> Option<String> {
        let waiting = self.desk.lock();
        (!waiting.unwritten.is_empty()).then(|| waiting.fault.clone())
    }

    /// Queues a record for writing. Does not wait for the disk.
    pub(crate) fn keep(&self, system: VehicleId, ticket: u64, stored: StoredRecord) {
        self.desk.lock().records.insert((system, stored.key.clone()), (ticket, stored));
        self.desk.news.notify_one();
    }

    /// Writes all queued records and ends the thread. Blocks.
    pub(crate) fn close(mut self) {
        self.end();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that writes the records of missions panicked");
        }
    }

    fn end(&self) {
        self.desk.lock().is_closing = true;
        self.desk.news.notify_one();
    }
}

impl Drop for Records {
    /// For a station that is dropped without being closed: its thread writes all queued records and ends.
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;
    use vencejo_flight::plan::{Mission, MissionItem};
    use vencejo_proto::Address;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("vencejo-records-{name}-{}", std::process::id()));
        let _unless_first = std::fs::remove_dir_all(&folder);
        folder
    }

    fn stored(system: u8) -> StoredRecord {
        let items = vec![MissionItem::waypoint(40.1, -3.2, 50.0), MissionItem::waypoint(40.2, -3.1, 60.0)];
        let wire = Mission { home: None, items }.to_wire(Address::new(0, 0), false).expect("sendable");
        let doubt = Doubt { writer: Writer::Another, sent: Some(Arc::new(wire)), before: Some(7) };
        StoredRecord {
            key: VehicleKey::of_system(SystemId(system)),
            system: Some(SystemId(system)),
            record: PlanRecord { verified: Some((12, 0xabcd)), doubt: Some(doubt) },
        }
    }

    #[test]
    fn records_are_read_as_written_and_empty_ones_are_removed() {
        let folder = folder("there-and-back");
        let (sender, kept) = mpsc::channel();
        let records = Records::start(folder.clone(), move |system, ticket| {
            sender.send((system, ticket)).expect("the test listens");
        })
        .expect("a thread");
        for system in [1, 2] {
            records.keep(SystemId(system).into(), u64::from(system), stored(system));
        }
        let mut told = [kept.recv().expect("kept"), kept.recv().expect("kept")];
        told.sort();
        assert_eq!(told, [(VehicleId::new(1), 1), (VehicleId::new(2), 2)]);
        let mut read = read_all(&folder);
        read.sort_by(|one, other| one.key.cmp(&other.key));
        assert_eq!(read, [stored(1), stored(2)]);
        records.keep(VehicleId::new(1), 3, StoredRecord { record: PlanRecord::default(), ..stored(1) });
        records.close();
        assert_eq!(read_all(&folder), [stored(2)]);
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn a_failed_record_is_written_when_the_disk_works_again() {
        let folder = folder("tried-again");
        std::fs::write(&folder, b"in the way").expect("written");
        let (sender, kept) = mpsc::channel();
        let on_kept = move |system, ticket| sender.send((system, ticket)).expect("the test listens");
        let records = Records::start(folder.clone(), on_kept).expect("a thread");
        records.keep(VehicleId::new(1), 1, stored(1));
        assert_eq!(kept.recv(), Ok((VehicleId::new(1), 1)), "the caller is released");
        assert!(records.fault().is_some());
        std::fs::remove_file(&folder).expect("removed");
        records.keep(VehicleId::new(2), 2, stored(2));
        assert_eq!(kept.recv(), Ok((VehicleId::new(2), 2)));
        assert_eq!(kept.recv(), Ok((VehicleId::new(1), 1)), "retried with the first that is written");
        assert_eq!(records.fault(), None);
        std::fs::remove_dir_all(&folder).expect("removed");
        std::fs::write(&folder, b"in the way").expect("written");
        records.keep(VehicleId::new(3), 3, stored(3));
        assert_eq!(kept.recv(), Ok((VehicleId::new(3), 3)));
        std::fs::remove_file(&folder).expect("removed");
        records.close();
        assert_eq!(read_all(&folder), [stored(3)], "and a last time at the end");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn unreadable_files_count_as_doubts_and_a_failed_write_releases_the_caller() {
        let folder = folder("damaged");
        std::fs::create_dir_all(&folder).expect("made");
        for (name, text) in [
            ("system-1.json", &b"{"[..]),
            ("system-2.json", b"{\"format\": 9, \"system\": 2}"),
            ("../evil.json", b""),
            ("notes.txt", b"hello"),
        ] {
            let _unless_above = std::fs::write(folder.join(name.replace("../", "..-")), text);
        }
        std::fs::write(folder.join("system-3.json"), to_text(&stored(3))).expect("written");
        std::fs::write(folder.join("uid-000000000000002a.json"), &to_text(&stored(4))[..40]).expect("written");
        // Each unreadable record counts as a doubt; files that are not named like a record are ignored.
        let mut read: Vec<_> = read_all(&folder).into_iter().map(|stored| (stored.key.to_string(), stored)).collect();
        read.sort_by(|one, other| one.0.cmp(&other.0));
        let names: Vec<_> = read.iter().map(|(name, stored)| (name.as_str(), stored.system)).collect();
        let system = |id| Some(SystemId(id));
        assert_eq!(
            names,
            [("system-1", system(1)), ("system-2", system(2)), ("system-3", system(3)), ("uid-000000000000002a", None)]
        );
        for (name, read) in &read {
            let expected = if name == "system-3" { stored(3).record } else { PlanRecord::damaged() };
            assert_eq!(read.record, expected, "{name}");
        }
        // A file where the folder should be.
        let (sender, kept) = mpsc::channel();
        let no_folder = folder.join("system-3.json");
        let records = Records::start(no_folder, move |_, ticket| sender.send(ticket).expect("the test listens"));
        let records = records.expect("a thread");
        records.keep(VehicleId::new(3), 5, stored(3));
        assert_eq!(kept.recv(), Ok(5), "the caller is released");
        assert!(records.fault().is_some(), "and the fault reported");
        records.close();
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
