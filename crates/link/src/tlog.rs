//! Owns the `.tlog` format: 8 bytes of big-endian microseconds since the UNIX epoch, then the raw frame, again and
//! again. (Mission Planner, QGroundControl, MAVProxy and pymavlink write and read it; some of them take the lowest two
//! bits of the time as the number of the link.)
//!
//! [`TlogReader`] also reads damaged files: bytes that belong to no entry are skipped and counted, a torn end too.

use std::collections::VecDeque;
use std::io::{self, Read};

use vencejo_proto::{Frame, FrameDecoder};

/// Bytes of the time stamp.
const STAMP_LEN: usize = 8;
const STX_V1: u8 = 0xfe;
const STX_V2: u8 = 0xfd;
const IFLAG_SIGNED: u8 = 0x01;
const SIGNATURE_LEN: usize = 13;
/// The longest entry: a signed MAVLink 2 frame with 255 bytes of payload.
pub(crate) const LONGEST_ENTRY: usize = STAMP_LEN + 10 + 255 + 2 + SIGNATURE_LEN;
/// The length of a frame is known after this many of its bytes.
const FRAME_START_LEN: usize = 10;

/// Entries of several threads may be out of order by this much.
pub(crate) const DISORDER_US: u64 = 1_000_000;
/// Longest pause that is believed after the first entry and before the last one, which have a neighbour on one side only.
const LONGEST_PAUSE_US: u64 = 3_600_000_000;

/// One entry of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TlogEntry {
    /// Microseconds since the UNIX epoch, as recorded; a damaged stamp is that of the entry before.
    pub unix_us: u64,
    /// The frame.
    pub frame: Frame,
}

/// Bytes that a reader skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SkippedBytes {
    /// In the middle: damaged, or of another format.
    pub garbage: u64,
    /// At the end: the beginning of an entry that was never written out.
    pub torn_tail: u64,
}

impl SkippedBytes {
    /// Both.
    pub fn total(self) -> u64 {
        self.garbage + self.torn_tail
    }
}

/// Decodes entries from chunks of bytes.
#[derive(Debug, Default)]
pub struct TlogDecoder {
    buffer: Vec<u8>,
    /// Offset at which the next entry may begin.
    at: usize,
    /// Bytes of the recording before the buffer.
    before: u64,
    ended: bool,
    /// Whether the entry before this offset was valid.
    in_step: bool,
    /// Checks one frame at a time.
    checker: FrameDecoder,
    skipped: SkippedBytes,
    /// Entries that are held back until the stamps after them are known.
    held: VecDeque<(u64, TlogEntry)>,
    /// The stamp of the entry before, and whether another one confirmed it.
    previous_us: Option<(u64, bool)>,
}

enum Candidate {
    Entry(TlogEntry, usize),
    Incomplete,
    No,
}

impl TlogDecoder {
    /// A decoder at the beginning of a recording.
    pub fn new() -> Self {
        Self { in_step: true, ..Self::default() }
    }

    /// A decoder at an entry that was decoded before with this stamp, which is believed again.
    pub(crate) fn at_entry(unix_us: u64) -> Self {
        Self { previous_us: Some((unix_us, true)), ..Self::new() }
    }

    /// Appends bytes. Call [`Self::next_entry`] until it returns `None` before the next push.
    pub fn push(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.at);
        self.before += self.at as u64;
        self.at = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// Marks the end of the recording.
    pub fn finish(&mut self) {
        self.ended = true;
    }

    /// The next entry. `None` when more bytes are needed or, after [`Self::finish`], at the end. An entry comes when the
    /// one after it is known, the first one when two are.
    pub fn next_entry(&mut self) -> Option<TlogEntry> {
        self.next_placed().map(|(_, entry)| entry)
    }

    /// The same, with the offset at which the entry begins, counted from the first byte that was pushed.
    pub fn next_placed(&mut self) -> Option<(u64, TlogEntry)> {
        let ahead = if self.previous_us.is_none() { 2 } else { 1 };
        while self.held.len() <= ahead {
            match self.decode_entry() {
                Some(entry) => self.held.push_back(entry),
                None if self.ended => break,
                None => return None,
            }
        }
        let (offset, mut entry) = self.held.pop_front()?;
        let (unix_us, is_confirmed) = self.sound_stamp(entry.unix_us);
        self.previous_us = Some((unix_us, is_confirmed));
        entry.unix_us = unix_us;
        Some((offset, entry))
    }

    /// No checksum covers a stamp. One that lies outside its neighbours, which are in order, is damaged and counts as the
    /// one before, the first one as the one after. Also gives whether a neighbour confirms it: one that none confirms does not
    /// judge the last one.
    fn sound_stamp(&self, stamp_us: u64) -> (u64, bool) {
        let believed = |from: u64| from..=from.saturating_add(LONGEST_PAUSE_US);
        let mut after = self.held.iter().map(|(_, entry)| entry.unix_us);
        let (earliest, latest, instead) = match (self.previous_us, after.next(), after.next()) {
            (Some((previous, _)), Some(next), _) if previous <= next => (previous, next, previous),
            (Some((previous, true)), None, _) => (previous, *believed(previous).end(), previous),
            (None, Some(next), Some(second)) if believed(next).contains(&second) => {
                (next.saturating_sub(LONGEST_PAUSE_US), second, next)
            }
            (Some((previous, is_confirmed)), ..) => {
                return (stamp_us, is_confirmed || believed(previous).contains(&stamp_us));
            }
            _ => return (stamp_us, false),
        };
        let sound = earliest.saturating_sub(DISORDER_US)..=latest.saturating_add(DISORDER_US);
        (if sound.contains(&stamp_us) { stamp_us } else { instead }, true)
    }

    fn decode_entry(&mut self) -> Option<(u64, TlogEntry)> {
        loop {
            match self.candidate() {
                Candidate::Entry(entry, len) => {
                    let offset = self.before + self.at as u64;
                    self.at += len;
                    self.in_step = true;
                    return Some((offset, entry));
                }
                Candidate::Incomplete if !self.ended => return None,
                Candidate::Incomplete => {
                    let left = self.buffer.len() - self.at;
                    if left == 0 {
                        return None;
                    }
                    // A torn end, or garbage that looks like the beginning of an entry and hides the last good ones.
                    if !self.holds_entry_after(1) {
                        self.skipped.torn_tail += left as u64;
                        self.at = self.buffer.len();
                        return None;
                    }
                    self.skip();
                }
                Candidate::No => self.skip(),
            }
        }
    }

    /// The bytes skipped so far.
    pub fn skipped(&self) -> SkippedBytes {
        self.skipped
    }

    fn skip(&mut self) {
        self.at += 1;
        self.skipped.garbage += 1;
        self.in_step = false;
    }

    fn holds_entry_after(&mut self, offset: usize) -> bool {
        let (at, in_step) = (self.at, self.in_step);
        self.in_step = false;
        let found = (at + offset..self.buffer.len()).any(|candidate| {
            self.at = candidate;
            matches!(self.candidate(), Candidate::Entry(..))
        });
        (self.at, self.in_step) = (at, in_step);
        found
    }

    fn candidate(&mut self) -> Candidate {
        let rest = &self.buffer[self.at..];
        match rest.get(STAMP_LEN) {
            None => return Candidate::Incomplete,
            Some(&STX_V1 | &STX_V2) => {}
            Some(_) => return Candidate::No,
        }
        let Some(len) = frame_len(&rest[STAMP_LEN..]) else { return Candidate::Incomplete };
        let Some(bytes) = rest.get(STAMP_LEN..STAMP_LEN + len) else { return Candidate::Incomplete };
        self.checker.push_datagram(bytes);
        let frame = match self.checker.next_frame() {
            Some(frame) if frame.bytes().len() == len => frame,
            _ => {
                self.checker = FrameDecoder::new();
                return Candidate::No;
            }
        };
        // The checksum of a message unknown to the dialect cannot be verified: its valid neighbours vouch for it.
        let follows = rest.get(STAMP_LEN + len + STAMP_LEN).is_none_or(|byte| matches!(*byte, STX_V1 | STX_V2));
        let vouched_for = frame.is_known() || (self.in_step && follows);
        if !vouched_for {
            return Candidate::No;
        }
        let mut stamp = [0; STAMP_LEN];
        stamp.copy_from_slice(&rest[..STAMP_LEN]);
        Candidate::Entry(TlogEntry { unix_us: u64::from_be_bytes(stamp), frame }, STAMP_LEN + len)
    }
}

/// The length of a frame from its first bytes; `None` while there are too few.
fn frame_len(bytes: &[u8]) -> Option<usize> {
    match *bytes {
        [STX_V1, payload, ..] => Some(6 + usize::from(payload) + 2),
        [STX_V2, payload, flags, ..] => {
            let signature = if flags & IFLAG_SIGNED != 0 { SIGNATURE_LEN } else { 0 };
            Some(FRAME_START_LEN + usize::from(payload) + 2 + signature)
        }
        _ => None,
    }
}

/// Reads a recording, entry by entry.
///
/// ```
/// use vencejo_link::TlogReader;
/// # fn main() -> std::io::Result<()> {
/// let bytes: &[u8] = b"not a recording";
/// let mut reader = TlogReader::new(bytes);
/// assert_eq!(reader.by_ref().count(), 0);
/// assert_eq!(reader.skipped().total(), 15);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct TlogReader<R> {
    source: R,
    decoder: TlogDecoder,
    ended: bool,
}

impl<R: Read> TlogReader<R> {
    /// Reads from `source`, in large pieces: it needs no buffer of its own.
    pub fn new(source: R) -> Self {
        Self { source, decoder: TlogDecoder::new(), ended: false }
    }

    /// The bytes skipped so far.
    pub fn skipped(&self) -> SkippedBytes {
        self.decoder.skipped()
    }
}

impl<R: Read> Iterator for TlogReader<R> {
    type Item = io::Result<TlogEntry>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(entry) = self.decoder.next_entry() {
                return Some(Ok(entry));
            }
            if self.ended {
                return None;
            }
            let mut piece = [0; 8 * 1024];
            match self.source.read(&mut piece) {
                Ok(0) => {
                    self.ended = true;
                    self.decoder.finish();
                }
                Ok(count) => self.decoder.push(&piece[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => {
                    self.ended = true;
                    self.decoder.finish();
                    return Some(Err(error));
                }
            }
        }
    }
}

/// Appends an entry to `out`. Signatures are removed: many signatures of known frames allow a search for the key, and a
/// signed frame could be replayed. The frame stays valid.
pub fn write_entry(out: &mut Vec<u8>, unix_us: u64, frame: &Frame) {
    out.reserve(LONGEST_ENTRY);
    out.extend_from_slice(&unix_us.to_be_bytes());
    out.extend_from_slice(frame.without_signature().bytes());
}

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};

    use super::*;
    use crate::testing::{heartbeat, signed, unknown};

    fn recording(count: u8) -> (Vec<u8>, Vec<TlogEntry>) {
        let mut bytes = Vec::new();
        let entries: Vec<_> = (0..count)
            .map(|n| {
                let frame = if n % 5 == 4 { unknown(9, 9, n) } else { heartbeat(1, 1, n) };
                TlogEntry { unix_us: 1_700_000_000_000_000 + u64::from(n) * 1000, frame }
            })
            .collect();
        for entry in &entries {
            write_entry(&mut bytes, entry.unix_us, &entry.frame);
        }
        (bytes, entries)
    }

    fn read(bytes: &[u8]) -> (Vec<TlogEntry>, SkippedBytes) {
        let mut reader = TlogReader::new(bytes);
        let entries = reader.by_ref().map(Result::unwrap).collect();
        (entries, reader.skipped())
    }

    /// What is read of entries with these times.
    fn stamps(times_us: &[u64], damage: impl FnOnce(&mut [u8], usize)) -> Vec<u64> {
        let mut bytes = Vec::new();
        for (sequence, us) in times_us.iter().enumerate() {
            write_entry(&mut bytes, *us, &heartbeat(1, 1, sequence as u8));
        }
        let len = bytes.len() / times_us.len();
        damage(&mut bytes, len);
        TlogReader::new(&bytes[..]).map(|entry| entry.unwrap().unix_us).collect()
    }

    #[test]
    fn a_damaged_stamp_counts_as_its_neighbour() {
        let times_us = [0, 100_000, 200_000, 300_000, 400_000_u64].map(|us| 1_700_000_000_000_000 + us);
        for count in 1..=times_us.len() {
            let (times_us, last) = (&times_us[..count], count - 1);
            for (entry, bit) in (0..count).flat_map(|entry| (0..64).map(move |bit| (entry, bit))) {
                let read = stamps(times_us, |bytes, len| bytes[entry * len + bit / 8] ^= 1 << (bit % 8));
                assert_eq!(read.len(), count, "{entry}, {bit}");
                let most = if [0, last].contains(&entry) { LONGEST_PAUSE_US } else { DISORDER_US };
                let is_wrong = |(read, recorded): &(&u64, &u64)| read.abs_diff(**recorded) > most + 100_000;
                let wrong: Vec<_> = read.iter().zip(times_us).filter(is_wrong).collect();
                // Of two it is not known which one is damaged.
                assert!(wrong.len() <= usize::from(count < 3), "{entry} of {count}, {bit}: {wrong:?}");
            }
        }
        let with_pause = [times_us[0], times_us[1], times_us[1] + 2 * LONGEST_PAUSE_US];
        assert_eq!(stamps(&with_pause, |bytes, _| bytes[0] ^= 1)[1..], with_pause[1..]);
    }

    #[test]
    fn what_is_written_is_read() {
        let (bytes, entries) = recording(100);
        assert_eq!(read(&bytes), (entries, SkippedBytes::default()));
    }

    #[test]
    fn a_torn_tail_costs_the_last_entry_only() {
        let (bytes, entries) = recording(6);
        let last = STAMP_LEN + entries[5].frame.bytes().len();
        for cut in 1..last {
            let (found, skipped) = read(&bytes[..bytes.len() - cut]);
            assert_eq!(found, entries[..5], "cut {cut}");
            assert_eq!(skipped, SkippedBytes { garbage: 0, torn_tail: (last - cut) as u64 });
        }
    }

    #[test]
    fn garbage_is_skipped_and_counted() {
        let (bytes, entries) = recording(9);
        let split = bytes.len() / 3;
        let at =
            (0..).find(|at| *at >= split && bytes[at + STAMP_LEN] == STX_V2 && bytes[at + STAMP_LEN + 1] == 9).unwrap();
        let mut random = StdRng::seed_from_u64(7);
        for len in [1, 7, 8, 9, 100, 5000] {
            let noise: Vec<u8> = (0..len).map(|_| random.random()).collect();
            let damaged = [&bytes[..at], &noise, &bytes[at..]].concat();
            let (found, skipped) = read(&damaged);
            assert_eq!(found, entries, "{len} bytes of noise");
            assert_eq!(skipped.total(), len as u64);
        }
    }

    #[test]
    fn noise_holds_no_entries() {
        let mut random = StdRng::seed_from_u64(8);
        let noise: Vec<u8> = (0..1 << 18).map(|_| random.random()).collect();
        let (found, skipped) = read(&noise);
        assert_eq!(found.len(), 0);
        assert_eq!(skipped.total(), 1 << 18);
    }

    #[test]
    fn a_whole_flight_is_read_from_every_piece_size() {
        let bytes = include_bytes!("../../../tests/fixtures/captures/fence-and-rally-upload.tlog");
        let (entries, skipped) = read(bytes);
        assert!(entries.len() > 50, "{}", entries.len());
        assert_eq!(skipped, SkippedBytes::default());
        for size in [1, 3, 64, 1000] {
            let mut decoder = TlogDecoder::new();
            let mut found = Vec::new();
            for piece in bytes.chunks(size) {
                decoder.push(piece);
                found.extend(std::iter::from_fn(|| decoder.next_entry()));
            }
            decoder.finish();
            found.extend(std::iter::from_fn(|| decoder.next_entry()));
            assert_eq!(found, entries, "pieces of {size}");
        }
        let mut again = Vec::new();
        for entry in &entries {
            write_entry(&mut again, entry.unix_us, &entry.frame);
        }
        assert_eq!(again, bytes, "and written it is the same");
    }

    #[test]
    fn signatures_are_taken_off_and_frames_stay_valid() {
        for plain in [heartbeat(1, 1, 3), unknown(1, 1, 3)] {
            let frame = signed(&plain);
            assert!(frame.is_signed());
            let mut bytes = Vec::new();
            write_entry(&mut bytes, 5, &frame);
            let (entries, skipped) = read(&bytes);
            assert_eq!(skipped.total(), 0);
            assert_eq!(entries.len(), 1);
            assert!(!entries[0].frame.is_signed());
            assert_eq!(entries[0].frame.payload(), plain.payload());
            if plain.is_known() {
                assert_eq!(entries[0].frame, plain);
            }
        }
    }
}
