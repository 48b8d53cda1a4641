//! Owns recordings that are played from any place: an index of a `.tlog`, made in one pass when it is opened.
//!
//! A place is the time that was played until there: pauses of more than an hour, and steps back, mean that the recorder's
//! clock was set, and count nothing.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::time::Duration;

use vencejo_proto::{Address, Frame};

use crate::tlog::{DISORDER_US, LONGEST_ENTRY, SkippedBytes, TlogDecoder, TlogEntry};

/// A longer pause, or a step back, means that the recorder's clock was set.
const LONGEST_PAUSE_US: u64 = 60 * 60 * 1_000_000;
/// Bytes of one read.
const READ_BYTES: usize = 64 * 1024;
/// Most places that the index knows; with more, every other one is dropped. The frames between two are read again: of
/// a file of 2 GB some 8 MB.
const MAX_PLACES: usize = 512;
/// Bytes between two places at first.
const FIRST_SPACING: u64 = 64 * 1024;
/// Most pairs of sender and message of which the newest frame is known; further ones come from noise.
const MAX_KINDS: usize = 512;
/// Most frames known that count one by one; the oldest are forgotten.
const MAX_EACH: usize = 4096;
/// Most of those before a place that belong to it.
const EACH_BEFORE: usize = 64;

/// The played time of entries.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlayedTime {
    /// The newest stamp.
    previous_us: Option<u64>,
    played_us: u64,
}

impl PlayedTime {
    /// The played time until an entry with this stamp, microseconds.
    pub(crate) fn until(&mut self, unix_us: u64) -> u64 {
        match self.previous_us {
            // Entries of several threads are a little out of order.
            Some(previous) if (previous.saturating_sub(DISORDER_US)..previous).contains(&unix_us) => {}
            Some(previous) if (previous..=previous.saturating_add(LONGEST_PAUSE_US)).contains(&unix_us) => {
                self.played_us += unix_us - previous;
                self.previous_us = Some(unix_us);
            }
            _ => self.previous_us = Some(unix_us),
        }
        self.played_us
    }
}

/// A frame of a recording and its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlayedFrame {
    /// The played time until then.
    pub at: Duration,
    /// Microseconds since the UNIX epoch, as recorded.
    pub unix_us: u64,
    /// The frame.
    pub frame: Frame,
}

/// Where a frame is.
#[derive(Debug, Clone, Copy)]
struct Spot {
    offset: u64,
    unix_us: u64,
    /// The played time until it.
    time: PlayedTime,
}

impl Spot {
    fn at_us(&self) -> u64 {
        self.time.played_us
    }
}

/// A place from which reading can begin, with the newest frame of each kind before it.
#[derive(Debug)]
struct Place {
    next: Spot,
    newest: Vec<Spot>,
}

/// A `.tlog` that can be played from any place. All that it does blocks.
#[derive(Debug)]
pub struct TlogFile {
    file: File,
    /// How much of the file there was when it was opened: it may be growing.
    len: u64,
    each: Vec<u32>,
    places: Vec<Place>,
    spots_of_each: VecDeque<Spot>,
    start_unix_us: Option<u64>,
    duration: Duration,
    skipped: SkippedBytes,
    reading: Reading,
}

/// Reading from a place on.
#[derive(Debug)]
struct Reading {
    decoder: TlogDecoder,
    time: PlayedTime,
    /// Offset of the next read.
    offset: u64,
    /// Offset of the place.
    began: u64,
    has_ended: bool,
}

impl Reading {
    fn whole() -> Self {
        let (decoder, time) = (TlogDecoder::new(), PlayedTime::default());
        Self { decoder, time, offset: 0, began: 0, has_ended: false }
    }

    fn from(spot: Spot) -> Self {
        let decoder = TlogDecoder::at_entry(spot.unix_us);
        Self { decoder, time: spot.time, offset: spot.offset, began: spot.offset, has_ended: false }
    }

    fn next(&mut self, file: &mut File, len: u64) -> io::Result<Option<(Spot, Frame)>> {
        let mut piece = Vec::new();
        loop {
            if let Some((offset, TlogEntry { unix_us, frame })) = self.decoder.next_placed() {
                self.time.until(unix_us);
                return Ok(Some((Spot { offset: self.began + offset, unix_us, time: self.time }, frame)));
            }
            if self.has_ended {
                return Ok(None);
            }
            piece.resize(READ_BYTES.min(usize::try_from(len - self.offset).unwrap_or(READ_BYTES)), 0);
            file.seek(SeekFrom::Start(self.offset))?;
            match file.read(&mut piece) {
                Ok(0) => {
                    self.has_ended = true;
                    self.decoder.finish();
                }
                Ok(count) => {
                    self.decoder.push(&piece[..count]);
                    self.offset += count as u64;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl TlogFile {
    /// Opens a recording in any condition and reads it once: some seconds for a file of 2 GB. The index takes at most a
    /// few megabytes. Messages with an id in `each` count one by one, such as texts; of all others the newest counts.
    /// `look` sees every frame.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn open(path: &Path, each: &[u32], mut look: impl FnMut(Duration, &Frame)) -> io::Result<Self> {
        let file = File::open(path)?;
        let len = file.metadata()?.len();
        let mut opened = Self {
            file,
            len,
            each: each.to_vec(),
            places: Vec::new(),
            spots_of_each: VecDeque::new(),
            start_unix_us: None,
            duration: Duration::ZERO,
            skipped: SkippedBytes::default(),
            reading: Reading::whole(),
        };
        let mut newest: BTreeMap<(Address, u32), Spot> = BTreeMap::new();
        let (mut spacing, mut due) = (FIRST_SPACING, 0);
        while let Some((spot, frame)) = opened.reading.next(&mut opened.file, len)? {
            opened.start_unix_us.get_or_insert(spot.unix_us);
            opened.duration = Duration::from_micros(spot.at_us());
            if spot.offset >= due {
                opened.places.push(Place { next: spot, newest: newest.values().copied().collect() });
                if opened.places.len() >= MAX_PLACES {
                    let mut is_kept = false;
                    opened.places.retain(|_| {
                        is_kept = !is_kept;
                        is_kept
                    });
                    spacing *= 2;
                }
                due = spot.offset + spacing;
            }
            look(opened.duration, &frame);
            if each.contains(&frame.message_id()) {
                if opened.spots_of_each.len() == MAX_EACH {
                    opened.spots_of_each.pop_front();
                }
                opened.spots_of_each.push_back(spot);
            } else if frame.is_known() {
                let kind = (frame.source(), frame.message_id());
                if newest.len() < MAX_KINDS || newest.contains_key(&kind) {
                    newest.insert(kind, spot);
                }
            }
        }
        opened.skipped = opened.reading.decoder.skipped();
        opened.rewind();
        Ok(opened)
    }

    /// The stamp of the first frame, microseconds since the UNIX epoch; `None` without frames.
    pub fn start_unix_us(&self) -> Option<u64> {
        self.start_unix_us
    }

    /// The played time from the first frame to the last.
    pub fn duration(&self) -> Duration {
        self.duration
    }

    /// Bytes that belong to no whole entry.
    pub fn skipped(&self) -> SkippedBytes {
        self.skipped
    }

    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn next_frame(&mut self) -> io::Result<Option<PlayedFrame>> {
        let next = self.reading.next(&mut self.file, self.len)?;
        Ok(next.map(|(spot, frame)| played(spot, frame)))
    }

    /// Goes to a place: [`Self::next_frame`] goes on with the first frame after it. Returns what was the newest there: of
    /// each sender the newest frame of each message until then, and the last of those that count one by one, oldest
    /// first.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn seek(&mut self, to: Duration) -> io::Result<Vec<PlayedFrame>> {
        let to_us = u64::try_from(to.as_micros()).unwrap_or(u64::MAX);
        let place = self.places.partition_point(|place| place.next.at_us() <= to_us).checked_sub(1);
        let Some(place) = place.map(|place| &self.places[place]) else {
            self.rewind();
            return Ok(Vec::new());
        };
        let began = place.next;
        let mut newest = BTreeMap::new();
        for spot in &place.newest {
            if let Some(frame) = frame_at(&mut self.file, self.len, *spot)? {
                newest.insert((frame.source(), frame.message_id()), played(*spot, frame));
            }
        }
        let before = self.spots_of_each.partition_point(|spot| spot.offset < began.offset);
        let mut each = Vec::new();
        for spot in self.spots_of_each.range(before.saturating_sub(EACH_BEFORE)..before) {
            each.extend(frame_at(&mut self.file, self.len, *spot)?.map(|frame| played(*spot, frame)));
        }
        self.reading = Reading::from(began);
        while let Some((spot, frame)) = self.reading.next(&mut self.file, self.len)? {
            if spot.at_us() > to_us {
                // The first one after the place is read again.
                self.reading = Reading::from(spot);
                break;
            }
            if self.each.contains(&frame.message_id()) {
                each.push(played(spot, frame));
            } else if frame.is_known() {
                newest.insert((frame.source(), frame.message_id()), played(spot, frame));
            }
        }
        each.drain(..each.len().saturating_sub(EACH_BEFORE));
        let mut found: Vec<_> = newest.into_values().chain(each).collect();
        found.sort_by_key(|played| played.at);
        Ok(found)
    }

    fn rewind(&mut self) {
        self.reading = Reading::whole();
    }
}

fn played(spot: Spot, frame: Frame) -> PlayedFrame {
    PlayedFrame { at: Duration::from_micros(spot.at_us()), unix_us: spot.unix_us, frame }
}

/// The frame of a spot; `None` when the file is no longer what it was.
fn frame_at(file: &mut File, len: u64, spot: Spot) -> io::Result<Option<Frame>> {
    file.seek(SeekFrom::Start(spot.offset))?;
    let mut bytes = Vec::with_capacity(LONGEST_ENTRY);
    file.take((LONGEST_ENTRY as u64).min(len - spot.offset)).read_to_end(&mut bytes)?;
    let mut decoder = TlogDecoder::at_entry(spot.unix_us);
    decoder.push(&bytes);
    decoder.finish();
    Ok(decoder.next_placed().filter(|(offset, _)| *offset == 0).map(|(_, entry)| entry.frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{TempDir, heartbeat, unknown};
    use crate::tlog::write_entry;

    const START_US: u64 = 1_700_000_000_000_000;

    /// `count` entries, 100 ms apart: of two systems in turn, and one unknown message in ten.
    fn recording(folder: &TempDir, count: u64) -> std::path::PathBuf {
        let mut bytes = Vec::new();
        for n in 0..count {
            let system = if n % 2 == 0 { 1 } else { 2 };
            let frame = if n % 10 == 9 { unknown(9, 9, n as u8) } else { heartbeat(system, 1, n as u8) };
            write_entry(&mut bytes, START_US + n * 100_000, &frame);
        }
        let path = folder.0.join("flight.tlog");
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn at(n: u64) -> Duration {
        Duration::from_millis(100 * n)
    }

    #[test]
    fn every_place_has_what_was_the_newest_there_and_goes_on_after_it() {
        let folder = TempDir::new();
        // More than fit: places are dropped, and the others are as good.
        let count = 200_000;
        let path = recording(&folder, count);
        let mut seen = 0;
        let mut file = TlogFile::open(&path, &[], |_, _| seen += 1).unwrap();
        assert_eq!((seen, file.duration(), file.start_unix_us()), (count, at(count - 1), Some(START_US)));
        assert!((10..MAX_PLACES).contains(&file.places.len()), "{}", file.places.len());
        for n in [0, 1, 2, 3, 1_000, 77_777, count - 1, 500, 500] {
            let newest: Vec<_> = file.seek(at(n)).unwrap();
            let of = |system| newest.iter().filter(move |one| one.frame.source().system.0 == system).map(|one| one.at);
            let of_one: Vec<_> = of(1).collect();
            assert_eq!(of_one, [at(n - n % 2)], "the newest of one sender at {n}");
            assert!(newest.is_sorted_by_key(|one| one.at));
            let next = file.next_frame().unwrap();
            assert_eq!(
                next.map(|next| (next.at, next.unix_us)),
                (n + 1 < count).then(|| (at(n + 1), START_US + (n + 1) * 100_000))
            );
        }
        assert_eq!(file.seek(Duration::MAX).unwrap().len(), 2);
        assert_eq!(file.next_frame().unwrap(), None);
        file.seek(Duration::ZERO).unwrap();
        assert_eq!(file.next_frame().unwrap().map(|next| next.at), Some(at(1)));
    }

    #[test]
    fn those_that_count_one_by_one_are_there_as_far_as_they_are_kept() {
        let folder = TempDir::new();
        let mut file = TlogFile::open(&recording(&folder, 20_000), &[0], |_, _| ()).unwrap();
        let times: Vec<_> = file.seek(at(10_000)).unwrap().into_iter().map(|one| one.at).collect();
        assert_eq!((times.len(), times.last()), (EACH_BEFORE, Some(&at(10_000))));
    }

    #[test]
    fn a_clock_that_was_set_takes_no_time_and_damage_is_counted() {
        let folder = TempDir::new();
        let mut bytes = Vec::new();
        let year_us = 365 * 24 * 3600 * 1_000_000;
        for (n, us) in [0, 1_000_000, year_us, year_us + 500_000, 10, 500_010].into_iter().enumerate() {
            write_entry(&mut bytes, START_US + us, &heartbeat(1, 1, n as u8));
        }
        bytes.extend_from_slice(b"torn");
        let path = folder.0.join("flight.tlog");
        std::fs::write(&path, bytes).unwrap();
        let mut file = TlogFile::open(&path, &[], |_, _| ()).unwrap();
        assert_eq!((file.duration(), file.skipped().total()), (Duration::from_secs(2), 4));
        let mut time = PlayedTime::default();
        let of_two_threads = [0, 300, 200, 400, 100, 500].map(|ms| time.until(START_US + ms * 1000) / 1000);
        assert_eq!(of_two_threads, [0, 300, 300, 400, 400, 500]);
        assert_eq!(file.seek(Duration::from_millis(1200)).unwrap().len(), 1);
        assert_eq!(file.next_frame().unwrap().map(|next| next.unix_us), Some(START_US + year_us + 500_000));
        std::fs::write(&path, b"no recording at all").unwrap();
        let mut empty = TlogFile::open(&path, &[], |_, _| ()).unwrap();
        assert_eq!((empty.start_unix_us(), empty.seek(at(7)).unwrap().len()), (None, 0));
    }
}
