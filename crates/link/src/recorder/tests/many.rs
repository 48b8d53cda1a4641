//! Tests of many files that grow side by side.

use std::collections::VecDeque;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use tokio::sync::watch;

use super::super::writer::{MAX_OPEN, Writer, Writers};
use super::super::*;
use crate::clock::testing::ManualClock;
use crate::testing::TempDir;

/// Lines of text, with a word at the end of each file.
struct Text {
    names: Names,
}

impl Format for Text {
    type Item = u8;
    const BEGINS_AT_ONCE: bool = false;

    fn names(&self) -> &Names {
        &self.names
    }

    fn begin(&mut self, _at: MonoTime, _unix_us: u64) {}

    fn write(&mut self, items: &VecDeque<u8>, out: &mut Vec<u8>) {
        out.extend(items);
    }

    fn end(&mut self, out: &mut Vec<u8>) {
        out.extend(b"end");
    }
}

struct Many {
    clock: Arc<ManualClock>,
    writers: Writers<Text>,
    statuses: Vec<watch::Receiver<RecorderStatus>>,
}

impl Many {
    fn new(folder: &Path, count: usize, config: RecorderConfig) -> Self {
        let clock = Arc::new(ManualClock::default());
        let text = |line| Text { names: Names { prefix: format!("plane{line}_"), ending: "txt" } };
        let lines = (0..count).map(|line| Writer::new(text(line), config.retry_after, clock.now()));
        let (lines, statuses) = lines.unzip();
        let mut writers = Writers::new(Box::new(Folder::new(folder)), config, clock.clone());
        writers.add(lines);
        Self { clock, writers, statuses }
    }

    /// Each of these lines gets a letter, and all that is due is forced to the disk.
    fn write(&mut self, lines: impl IntoIterator<Item = usize>, letter: u8, ms: u64) {
        self.clock.advance_ms(ms);
        self.take(lines.into_iter().map(|line| (line, letter)).collect());
    }

    /// Writes what came, and waits for the disk.
    fn take(&mut self, items: VecDeque<(usize, u8)>) {
        self.writers.on_items(items, &[]);
        while self.writers.busy_since_us.load(Ordering::Acquire) > 0 {
            std::thread::yield_now();
            self.writers.on_items(VecDeque::new(), &[]);
        }
    }

    fn file(&self, line: usize) -> String {
        match self.statuses[line].borrow().state.clone() {
            RecorderState::Recording { file } => file,
            other => panic!("line {line}: {other:?}"),
        }
    }
}

fn no_floor() -> RecorderConfig {
    RecorderConfig { free_floor_bytes: 0, ..RecorderConfig::default() }
}

#[test]
fn many_files_grow_with_few_of_them_open_and_each_is_whole() {
    let folder = TempDir::new();
    let count = 200;
    let mut many = Many::new(&folder.0, count, no_floor());
    for letter in b'a'..=b'c' {
        many.write(0..count, letter, 2000);
        assert!(many.writers.open_files() <= MAX_OPEN, "{} are open", many.writers.open_files());
    }
    let files: Vec<_> = (0..count).map(|line| many.file(line)).collect();
    assert!(many.statuses.iter().all(|status| status.borrow().synced == 3), "all of it is on the disk");
    many.writers.close();
    assert_eq!(many.writers.open_files(), 0);
    for (line, file) in files.iter().enumerate() {
        assert!(file.starts_with(&format!("plane{line}_")), "{file}");
        assert_eq!(fs::read_to_string(folder.0.join(file)).unwrap(), "abcend");
    }
}

#[test]
fn what_is_wrong_with_one_file_is_told_of_that_one_and_it_goes_on_in_another() {
    let folder = TempDir::new();
    let count = 2 * MAX_OPEN;
    let mut many = Many::new(&folder.0, count, no_floor());
    many.write(0..count, b'a', 2000);
    // The last files rest: one is damaged by somebody, one is deleted.
    let (damaged, deleted) = (count - 1, count - 2);
    let first = [many.file(damaged), many.file(deleted)];
    fs::write(folder.0.join(&first[0]), "something else").unwrap();
    fs::remove_file(folder.0.join(&first[1])).unwrap();
    many.write(0..count, b'b', 2000);
    let problem = |line: usize| many.statuses[line].borrow().state.problem();
    assert!(problem(damaged).unwrap().contains("something else changed it"), "{:?}", problem(damaged));
    assert!(problem(deleted).is_some());
    assert!((0..count - 2).all(|line| problem(line).is_none()), "of no other");
    for line in [damaged, deleted] {
        let status = many.statuses[line].borrow().clone();
        assert_eq!((status.dropped, status.failures), (1, 1), "counted, so that it is fetched again");
    }
    many.write(0..count, b'c', 2000);
    assert_ne!(many.file(damaged), first[0]);
    many.writers.close();
    assert_eq!(fs::read_to_string(folder.0.join(&first[0])).unwrap(), "something else", "and left as it is");
}

#[test]
fn the_quota_has_room_for_what_is_not_being_written() {
    let folder = TempDir::new();
    let count = 8;
    let config = RecorderConfig { quota_bytes: 4 << 20, max_file_bytes: 1 << 20, ..no_floor() };
    let mut many = Many::new(&folder.0, count, config);
    for _ in 0..40 {
        for _ in 0..2 {
            many.clock.advance_ms(1000);
            let letters = (0..count).flat_map(|line| std::iter::repeat_n((line, b'x'), 50_000));
            // What waits for the disk cannot be deleted: here 80 s of data come in one.
            many.take(letters.collect());
        }
        let files: Vec<_> = fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap()).collect();
        let held: u64 = files.iter().map(|file| file.metadata().unwrap().len()).sum();
        assert!(held <= (4 << 20) + 8 * 250_000, "{held} bytes in {} files", files.len());
        assert!(files.len() <= 40, "{} files", files.len());
    }
    assert!(many.statuses.iter().all(|status| status.borrow().dropped == 0));
}
