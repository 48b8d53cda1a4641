//! Tests of the recorder, on folders of their own.

use std::collections::BTreeMap;

use super::*;
use crate::clock::testing::{ManualClock, WALL_START_US};
use crate::testing::{TempDir, heartbeat, setup_signing, signed};
use crate::tlog::TlogReader;

/// A disk in memory that can be made to fail.
#[derive(Default)]
struct Disk {
    files: BTreeMap<String, Vec<u8>>,
    free_bytes: u64,
    create_fails: Option<io::ErrorKind>,
    sync_fails: Option<io::ErrorKind>,
    /// Bytes until writing fails with `StorageFull`.
    room: Option<usize>,
    syncs: u32,
}

#[derive(Clone)]
struct SharedDisk(Arc<Mutex<Disk>>);

impl SharedDisk {
    fn new() -> Self {
        Self(Arc::new(Mutex::new(Disk { free_bytes: u64::MAX, ..Disk::default() })))
    }

    fn change(&self, change: impl FnOnce(&mut Disk)) {
        change(&mut self.0.lock().unwrap());
    }

    fn names(&self) -> Vec<String> {
        self.0.lock().unwrap().files.keys().cloned().collect()
    }

    fn frames(&self, name: &str) -> (Vec<u8>, u64) {
        let bytes = self.0.lock().unwrap().files[name].clone();
        let mut reader = TlogReader::new(&bytes[..]);
        let sequences = reader.by_ref().map(|entry| entry.unwrap().frame.sequence()).collect();
        (sequences, reader.skipped().torn_tail)
    }
}

struct DiskFile {
    disk: SharedDisk,
    name: String,
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut disk = self.disk.0.lock().unwrap();
        let count = bytes.len().min(disk.room.unwrap_or(usize::MAX));
        if count == 0 && !bytes.is_empty() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        if let Some(room) = &mut disk.room {
            *room -= count;
        }
        // The file may have been deleted by the quota; that must never happen to this one.
        disk.files.get_mut(&self.name).expect("the current file exists").extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl StorageFile for DiskFile {
    fn sync(&mut self) -> io::Result<()> {
        let mut disk = self.disk.0.lock().unwrap();
        disk.syncs += 1;
        disk.sync_fails.map_or(Ok(()), |kind| Err(kind.into()))
    }
}

impl Storage for SharedDisk {
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>> {
        let mut disk = self.0.lock().unwrap();
        if let Some(kind) = disk.create_fails {
            return Err(kind.into());
        }
        if disk.files.contains_key(name) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        disk.files.insert(name.to_owned(), Vec::new());
        Ok(Box::new(DiskFile { disk: self.clone(), name: name.to_owned() }))
    }

    fn list(&mut self) -> io::Result<Vec<StoredFile>> {
        let disk = self.0.lock().unwrap();
        Ok(disk
            .files
            .iter()
            .map(|(name, bytes)| StoredFile { name: name.clone(), bytes: bytes.len() as u64 })
            .collect())
    }

    fn remove(&mut self, name: &str) -> io::Result<()> {
        self.0.lock().unwrap().files.remove(name).map(|_| ()).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn free_bytes(&mut self) -> io::Result<u64> {
        Ok(self.0.lock().unwrap().free_bytes)
    }
}

struct Bench {
    disk: SharedDisk,
    clock: Arc<ManualClock>,
    writer: Writer,
    status: watch::Receiver<RecorderStatus>,
    next: u8,
}

impl Bench {
    fn new(config: RecorderConfig) -> Self {
        Self::on(SharedDisk::new(), config)
    }

    fn on(disk: SharedDisk, config: RecorderConfig) -> Self {
        let clock = Arc::new(ManualClock::default());
        let (writer, status) = Writer::new(Box::new(disk.clone()), config, clock.clone());
        Self { disk, clock, writer, status, next: 0 }
    }

    /// So many frames come within 200 ms, and are written.
    fn write(&mut self, count: u8) {
        let frames = (0..count)
            .map(|n| Noted { at: self.clock.now(), link: LinkId(2), frame: heartbeat(1, 1, self.next.wrapping_add(n)) })
            .collect();
        self.next = self.next.wrapping_add(count);
        self.clock.advance_ms(200);
        self.writer.on_frames(&frames, 0);
    }

    fn state(&self) -> RecorderState {
        self.status.borrow().state.clone()
    }

    fn dropped(&self) -> u64 {
        self.status.borrow().dropped
    }
}

const ENTRY: u64 = 8 + 21;

#[test]
fn entries_carry_time_and_link() {
    let mut bench = Bench::new(RecorderConfig::default());
    bench.write(0);
    assert_eq!(bench.state(), RecorderState::Recording { file: "2026-11-21T08-00-00Z.tlog".to_owned() });
    bench.write(1);
    bench.write(1);
    bench.writer.close();
    let bytes = bench.disk.0.lock().unwrap().files["2026-11-21T08-00-00Z.tlog"].clone();
    let times: Vec<u64> = TlogReader::new(&bytes[..]).map(|entry| entry.unwrap().unix_us - WALL_START_US).collect();
    assert_eq!(times, [200_001, 400_001], "the second link is 1 in the lowest two bits");
    assert_eq!(bench.state(), RecorderState::Closed);
}

#[test]
fn it_is_forced_to_the_disk_every_second() {
    let mut bench = Bench::new(RecorderConfig::default());
    for _ in 0..50 {
        bench.write(3);
    }
    let syncs = bench.disk.0.lock().unwrap().syncs;
    assert_eq!(syncs, 10);
}

#[test]
fn nothing_is_ever_overwritten_and_an_empty_recording_is_not_left() {
    let disk = SharedDisk::new();
    for expected in ["2026-11-21T08-00-00Z.tlog", "2026-11-21T08-00-00Z-1.tlog", "2026-11-21T08-00-00Z-2.tlog"] {
        let mut bench = Bench::on(disk.clone(), RecorderConfig::default());
        bench.write(2);
        assert_eq!(bench.state(), RecorderState::Recording { file: expected.to_owned() });
        bench.writer.close();
    }
    let mut empty = Bench::on(disk.clone(), RecorderConfig::default());
    empty.write(0);
    assert_eq!(disk.names().len(), 4);
    empty.writer.close();
    assert_eq!(disk.names().len(), 3);
}

#[test]
fn a_full_file_is_followed_by_the_next_and_the_quota_takes_the_oldest() {
    let config = RecorderConfig { max_file_bytes: 20 * ENTRY, quota_bytes: 70 * ENTRY, ..RecorderConfig::default() };
    let mut bench = Bench::new(config);
    bench.disk.change(|disk| {
        disk.files.insert("2020-01-01T00-00-00Z.tlog".to_owned(), vec![0; 30 * ENTRY as usize]);
        disk.files.insert("holiday.tlog".to_owned(), vec![0; 1000 * ENTRY as usize]);
        disk.files.insert("2020-01-01.jpg".to_owned(), vec![0; 1000 * ENTRY as usize]);
    });
    for _ in 0..100 {
        bench.write(4);
        let RecorderState::Recording { file } = bench.state() else { panic!("{:?}", bench.state()) };
        assert!(bench.disk.names().contains(&file), "never the one being written");
    }
    let names = bench.disk.names();
    assert!(!names.contains(&"2020-01-01T00-00-00Z.tlog".to_owned()), "the oldest went first");
    assert!(
        names.contains(&"holiday.tlog".to_owned()) && names.contains(&"2020-01-01.jpg".to_owned()),
        "not ours to delete"
    );
    let disk = bench.disk.0.lock().unwrap();
    let ours: usize = disk.files.iter().filter(|(name, _)| age_key(name).is_some()).map(|(_, bytes)| bytes.len()).sum();
    assert!(ours as u64 <= 70 * ENTRY + 20 * ENTRY, "{ours}");
    assert_eq!(bench.status.borrow().frames, 400);
}

#[test]
fn below_the_floor_nothing_is_written_and_it_goes_on_when_there_is_space() {
    let mut bench = Bench::new(RecorderConfig::default());
    bench.write(5);
    bench.disk.change(|disk| disk.free_bytes = 499_999_999);
    for _ in 0..10 {
        bench.write(5);
    }
    assert_eq!(bench.state(), RecorderState::LowSpace { free_bytes: 499_999_999, floor_bytes: 500_000_000 });
    assert_eq!(bench.disk.names().len(), 1);
    let lost = bench.dropped();
    assert!((25..=50).contains(&lost), "noticed within a second: {lost}");
    bench.disk.change(|disk| disk.free_bytes = 500_000_000);
    for _ in 0..30 {
        bench.write(5);
    }
    assert!(matches!(bench.state(), RecorderState::Recording { .. }));
    assert_eq!(bench.disk.names().len(), 2);
    let status = bench.status.borrow();
    assert_eq!(status.frames + status.dropped, 5 * 41);
}

#[test]
fn a_failing_disk_is_reported_and_tried_again() {
    for (kind, words) in [
        (io::ErrorKind::ReadOnlyFilesystem, "read-only"),
        (io::ErrorKind::PermissionDenied, "permission denied"),
        (io::ErrorKind::Other, "other error"),
    ] {
        let mut bench = Bench::new(RecorderConfig::default());
        bench.disk.change(|disk| disk.create_fails = Some(kind));
        bench.write(5);
        let RecorderState::Failing { error } = bench.state() else { panic!("{:?}", bench.state()) };
        assert!(error.contains(words), "{error}");
        bench.disk.change(|disk| disk.create_fails = None);
        for _ in 0..26 {
            bench.write(5);
        }
        assert!(matches!(bench.state(), RecorderState::Recording { .. }), "{kind}");
        assert!((125..=135).contains(&bench.dropped()), "{}", bench.dropped());
    }
}

#[test]
fn a_disk_that_fills_up_leaves_a_readable_file() {
    let mut bench = Bench::new(RecorderConfig::default());
    bench.disk.change(|disk| disk.room = Some(10 * ENTRY as usize + 11));
    bench.write(8);
    bench.write(8);
    let RecorderState::Failing { error } = bench.state() else { panic!("{:?}", bench.state()) };
    assert!(error.contains("no storage space"), "{error}");
    assert_eq!(bench.dropped(), 8);
    let (sequences, torn) = bench.disk.frames("2026-11-21T08-00-00Z.tlog");
    assert_eq!((sequences, torn), ((0..10).collect(), 11));
    bench.disk.change(|disk| disk.room = None);
    for _ in 0..26 {
        bench.write(1);
    }
    assert_eq!(bench.disk.names().len(), 2, "it goes on in a new file");
}

#[test]
fn a_sync_that_fails_counts_as_a_failure() {
    let mut bench = Bench::new(RecorderConfig::default());
    bench.write(1);
    bench.disk.change(|disk| disk.sync_fails = Some(io::ErrorKind::Other));
    for _ in 0..5 {
        bench.write(1);
    }
    assert!(matches!(bench.state(), RecorderState::Failing { .. }));
}

#[test]
fn the_queue_is_bounded_and_drops_the_oldest() {
    let shared = Arc::new(Shared::default());
    let handle = RecorderHandle { shared: shared.clone() };
    for n in 0..QUEUE_FRAMES + 100 {
        handle.record(LinkId(1), &heartbeat(1, 1, (n % 256) as u8), MonoTime::from_micros(n as u64));
    }
    handle.record(LinkId(1), &setup_signing((255, 190), (1, 1), 0), MonoTime::ZERO);
    let (frames, dropped, closing) = wait(&shared);
    assert_eq!((frames.len(), dropped, closing), (QUEUE_FRAMES, 100, false));
    assert_eq!(frames[0].at, MonoTime::from_micros(100));
    assert!(frames.iter().all(|noted| noted.frame.message_id() == 0), "the key was not noted");
}

#[test]
fn a_real_folder() {
    let folder = TempDir::new();
    let path = folder.0.join("made/when needed");
    let config = RecorderConfig { free_floor_bytes: 0, ..RecorderConfig::default() };
    let recorder = Recorder::start(&path, config, Arc::new(crate::SystemClock::new())).unwrap();
    let handle = recorder.handle();
    for sequence in 0..100 {
        handle.record(LinkId(1), &signed_sometimes(sequence), MonoTime::ZERO);
    }
    let status = recorder.close();
    assert_eq!((status.state, status.frames, status.dropped), (RecorderState::Closed, 100, 0));
    handle.record(LinkId(1), &heartbeat(1, 1, 0), MonoTime::ZERO);
    let files = Folder::new(&path).list().unwrap();
    assert_eq!(files.len(), 1);
    assert!(age_key(&files[0].name).is_some(), "{}", files[0].name);
    let mut reader = TlogReader::new(fs::File::open(path.join(&files[0].name)).unwrap());
    let frames: Vec<_> = reader.by_ref().map(|entry| entry.unwrap().frame).collect();
    assert_eq!(frames.len(), 100);
    assert!(frames.iter().all(|frame| !frame.is_signed()), "signatures are taken off");
    assert_eq!(reader.skipped().total(), 0);
}

fn signed_sometimes(sequence: u8) -> Frame {
    let frame = heartbeat(1, 1, sequence);
    if sequence % 50 == 7 { signed(&frame) } else { frame }
}

#[test]
fn utc() {
    for (unix_s, expected) in [
        (0, "1970-01-01T00-00-00Z"),
        (951_827_696, "2000-02-29T12-34-56Z"),
        (1_709_251_199, "2024-02-29T23-59-59Z"),
        (WALL_START_US / 1_000_000, "2026-11-21T08-00-00Z"),
        (4_107_542_400, "2100-03-01T00-00-00Z"),
    ] {
        assert_eq!(utc_stamp(unix_s), expected);
    }
}

#[test]
fn ages() {
    let names = [
        "2026-11-21T08-00-00Z.tlog",
        "2026-11-21T08-00-00Z-1.tlog",
        "2026-11-21T08-00-00Z-10.tlog",
        "2026-11-21T08-00-01Z.tlog",
    ];
    let keys: Vec<_> = names.iter().map(|name| age_key(name).unwrap()).collect();
    assert!(keys.is_sorted());
    for other in [
        "mav.tlog",
        "2026-11-21.tlog",
        "2026-11-21T08-00-00Z.log",
        "2026-11-21T08-00-00Z-x.tlog",
        "2026-11-21T08-00-0éZ.tlog",
    ] {
        assert_eq!(age_key(other), None, "{other}");
    }
}
