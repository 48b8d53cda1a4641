//! History on the disk and over the network: written on board, kept on the ground, fetched after a cut, and replayed.
//!
//! Files are written by the flight recorder: append-only, synced each second, within a quota, above a floor of free
//! space. Their format is described in [`crate::history`].

mod archive;
mod board;
mod replay;
mod shelf;

use std::collections::VecDeque;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use vencejo_link::{Clock, Folder, Format, Names, Recorder, RecorderConfig, Recorders};
use vencejo_proto::MonoTime;
use vencejo_store::{Class, Space};

pub(super) use self::archive::Archive;
pub(super) use self::board::{Board, Entry};
pub use self::replay::{Contents, open_film};
use crate::history::pen::{About, Pen};
use crate::history::{Record, Stream};

/// A file has the records of at most an hour.
const FILE_AGE: Duration = Duration::from_secs(3600);
/// The largest file.
const FILE_BYTES: u64 = 64 << 20;
/// Most records queued for the disk on the ground: 6 s of a thousand aircraft with ten states a second, some 25 MB.
/// Records beyond are fetched later.
const QUEUE_ITEMS: usize = 65_536;

/// Where a history is kept.
#[derive(Debug, Clone)]
pub struct HistoryConfig {
    /// The folder.
    pub folder: PathBuf,
    /// Quota of all its files.
    pub quota_bytes: u64,
    /// The disk's free space. History stops with video, before the flight recorder.
    pub space: Space,
    /// Whether all frames of the autopilot are stored too; on board only.
    pub with_frames: bool,
}

/// A record to be written.
struct Item {
    /// When it came, by the recorder's clock.
    at: MonoTime,
    /// UTC, if known by another clock than ours.
    unix_ns: Option<u64>,
    /// `None` for a frame.
    stream: Option<Stream>,
    boot: u64,
    number: u64,
    clock_ms: u64,
    data: Vec<u8>,
}

/// The history of an aircraft as files have it.
struct Journal {
    names: Names,
    about: About,
    pen: Option<Pen>,
    begun: (MonoTime, u64),
}

impl Journal {
    fn new(about: About) -> Self {
        let names = Names { prefix: prefix(&about.aircraft), ending: "mcap" };
        Self { names, about, pen: None, begun: (MonoTime::ZERO, 0) }
    }

    /// What writes one aircraft's, on board.
    fn recorder(about: About, config: &HistoryConfig, clock: Arc<dyn Clock>) -> io::Result<Recorder<Self>> {
        let (folder, limits) = place(config);
        Recorder::start_format(Self::new(about), folder, limits, clock)
    }

    /// What writes those of all aircraft, on the ground.
    fn recorders(config: &HistoryConfig, clock: Arc<dyn Clock>) -> io::Result<Recorders<Self>> {
        let (folder, limits) = place(config);
        Recorders::start(folder, RecorderConfig { queue_items: QUEUE_ITEMS, ..limits }, clock)
    }
}

/// The folder, and what may be in it.
fn place(config: &HistoryConfig) -> (Box<Folder>, RecorderConfig) {
    let limits = RecorderConfig {
        max_file_bytes: FILE_BYTES.min(config.quota_bytes),
        max_file_age: Some(FILE_AGE),
        quota_bytes: config.quota_bytes,
        free_floor_bytes: config.space.floors().bytes(Class::Video),
        ..RecorderConfig::default()
    };
    (Box::new(Folder::new(&config.folder).with_space(config.space.clone())), limits)
}

/// How the files of an aircraft begin.
fn prefix(aircraft: &str) -> String {
    format!("{aircraft}_")
}

impl Format for Journal {
    type Item = Item;
    const BEGINS_AT_ONCE: bool = false;

    fn names(&self) -> &Names {
        &self.names
    }

    fn begin(&mut self, at: MonoTime, unix_us: u64) {
        (self.pen, self.begun) = (Some(Pen::new(&self.about)), (at, unix_us));
    }

    fn write(&mut self, items: &VecDeque<Item>, out: &mut Vec<u8>) {
        let Some(pen) = &mut self.pen else { return };
        for item in items {
            let Item { at, stream, boot, number, clock_ms, .. } = *item;
            let (begun_at, begun_us) = self.begun;
            let offset_us = i128::from(at.as_micros()) - i128::from(begun_at.as_micros());
            let ours = || u64::try_from((i128::from(begun_us) + offset_us) * 1000).unwrap_or(0);
            let unix_ns = item.unix_ns.unwrap_or_else(ours);
            match stream {
                Some(stream) => {
                    let data = item.data.clone();
                    pen.put(&Record { stream, boot, number, clock_ms, unix_ns, data });
                }
                None => pen.put_frame(boot, clock_ms, unix_ns, &item.data),
            }
        }
        out.append(&mut pen.take());
    }

    fn flush(&mut self, out: &mut Vec<u8>) {
        if let Some(pen) = &mut self.pen {
            pen.flush();
            out.append(&mut pen.take());
        }
    }

    fn end(&mut self, out: &mut Vec<u8>) {
        if let Some(mut pen) = self.pen.take() {
            pen.finish();
            out.append(&mut pen.take());
        }
    }
}
