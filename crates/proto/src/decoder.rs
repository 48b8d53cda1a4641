//! Finds frames in a byte stream, and resynchronises after garbage.

use bytes::{Buf, BytesMut};

use crate::checksum::checksum;
use crate::frame::{CHECKSUM_LEN, Frame, HEADER_LEN_V1, HEADER_LEN_V2, IFLAG_SIGNED, SIGNATURE_LEN, STX_V1, STX_V2};
use crate::info::{MessageInfo, info};

/// What a decoder has seen since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DecoderStats {
    /// Frames handed out, unknown ids included.
    pub frames: u64,
    /// Bytes pushed in.
    pub bytes: u64,
    /// Candidates of a known id whose checksum was wrong.
    pub bad_crc: u64,
    /// Bytes that belonged to no frame.
    pub garbage_bytes: u64,
    /// Frames handed out whose id is not in the dialect, so that their checksum could not be checked.
    pub unknown_id: u64,
}

/// Turns bytes, in pieces of any size, into frames.
///
/// A wrong candidate costs one byte, never the frames behind it: the search goes on right after its first byte. At most
/// one frame (280 bytes) is held back waiting for its end. A frame of an unknown id, which cannot be checked, waits for
/// the end of any known frame whose beginning it may cover.
#[derive(Debug, Default)]
pub struct FrameDecoder {
    buffer: BytesMut,
    /// Whether the next piece may continue what is in the buffer.
    is_stream: bool,
    wrong: Wrong,
    stats: DecoderStats,
}

/// Positions in the stream of candidates whose checksum was wrong. Candidates may overlap, and each new piece restarts
/// the search: without this, short pieces of hostile bytes would cost the square of a frame's length each.
#[derive(Debug, Default)]
struct Wrong(Vec<u64>);

impl Wrong {
    /// More than the bytes of the longest frame, so that no position within the buffer's first frame is dropped.
    const PLACES: usize = 512;

    fn holds(&self, place: u64) -> bool {
        self.0.get(place as usize % Self::PLACES) == Some(&(place + 1))
    }

    fn add(&mut self, place: u64) {
        self.0.resize(Self::PLACES, 0);
        self.0[place as usize % Self::PLACES] = place + 1;
    }
}

/// What stands at the front of the buffer.
enum Front {
    /// A whole frame, with its length in bytes.
    Frame { len: usize, known: bool },
    /// The beginning of what may be a frame.
    Incomplete,
    /// Not a frame; `bad_crc` when it looked like one to the end.
    Garbage { bad_crc: bool },
}

impl FrameDecoder {
    /// An empty decoder.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in bytes from a link. Call [`Self::next_frame`] until it returns `None` before the next push.
    pub fn push(&mut self, bytes: &[u8]) {
        self.is_stream = true;
        self.take_in(bytes);
    }

    fn take_in(&mut self, bytes: &[u8]) {
        self.stats.bytes += bytes.len() as u64;
        self.buffer.extend_from_slice(bytes);
    }

    /// Takes in a datagram. As [`Self::push`], but a beginning that was left over is given up when the datagram starts
    /// with a whole frame of its own: frames do not go on in the next datagram, and garbage must not hold one up.
    pub fn push_datagram(&mut self, datagram: &[u8]) {
        if !self.buffer.is_empty() && begins_with_known(datagram) {
            self.discard(self.buffer.len());
        }
        self.is_stream = false;
        self.take_in(datagram);
    }

    /// The next whole frame, if there is one.
    pub fn next_frame(&mut self) -> Option<Frame> {
        loop {
            let skip =
                self.buffer.iter().position(|byte| matches!(*byte, STX_V1 | STX_V2)).unwrap_or(self.buffer.len());
            if skip > 0 {
                self.discard(skip);
            }
            let place = self.stats.bytes - self.buffer.len() as u64;
            match front(&self.buffer, self.is_stream, place, &mut self.wrong) {
                Front::Frame { len, known } => {
                    self.stats.frames += 1;
                    self.stats.unknown_id += u64::from(!known);
                    return Some(Frame::from_checked(self.buffer.split_to(len).freeze()));
                }
                Front::Incomplete => return None,
                Front::Garbage { bad_crc } => {
                    self.stats.bad_crc += u64::from(bad_crc);
                    self.discard(1);
                }
            }
        }
    }

    /// What was seen so far.
    pub fn stats(&self) -> DecoderStats {
        self.stats
    }

    fn discard(&mut self, count: usize) {
        self.stats.garbage_bytes += count as u64;
        self.buffer.advance(count);
    }
}

/// The header fields of a candidate.
struct Candidate {
    id: u32,
    /// Header and payload.
    checked_len: usize,
    /// Checksum and signature included.
    len: usize,
}

impl Candidate {
    fn is_whole(&self, buffer: &[u8]) -> bool {
        buffer.len() >= self.len
    }
}

/// Reads a candidate's header; `Err` says whether it is incomplete or invalid.
fn candidate(buffer: &[u8]) -> Result<Candidate, Front> {
    let (header_len, signature_len, id) = match *buffer {
        [STX_V1, _, _, _, _, id, ..] => (HEADER_LEN_V1, 0, u32::from(id)),
        // A frame with an incompatibility flag that we do not know must be dropped (mavlink.io, "Incompatibility
        // Flags").
        [STX_V2, _, flags, ..] if flags & !IFLAG_SIGNED != 0 => return Err(Front::Garbage { bad_crc: false }),
        [STX_V2, _, flags, _, _, _, _, id0, id1, id2, ..] => {
            let signature_len = if flags & IFLAG_SIGNED != 0 { SIGNATURE_LEN } else { 0 };
            (HEADER_LEN_V2, signature_len, u32::from_le_bytes([id0, id1, id2, 0]))
        }
        _ => return Err(Front::Incomplete),
    };
    let checked_len = header_len + usize::from(buffer[1]);
    Ok(Candidate { id, checked_len, len: checked_len + CHECKSUM_LEN + signature_len })
}

fn checksum_is_right(buffer: &[u8], candidate: &Candidate, extra_crc: u8) -> bool {
    #[cfg(test)]
    tests::CHECKED.set(tests::CHECKED.get() + 1);
    let (checked, rest) = buffer.split_at(candidate.checked_len);
    checksum(&checked[1..], extra_crc) == u16::from_le_bytes([rest[0], rest[1]])
}

fn begins_with_known(bytes: &[u8]) -> bool {
    candidate(bytes).is_ok_and(|candidate| {
        let is_right = |info: &MessageInfo| checksum_is_right(bytes, &candidate, info.extra_crc);
        candidate.is_whole(bytes) && info(candidate.id).is_some_and(is_right)
    })
}

/// Classifies the front of the buffer, which is at this position of the stream.
fn front(buffer: &[u8], is_stream: bool, place: u64, wrong: &mut Wrong) -> Front {
    let candidate = match candidate(buffer) {
        Ok(candidate) if candidate.is_whole(buffer) => candidate,
        Ok(_) => return Front::Incomplete,
        Err(front) => return front,
    };
    match info(candidate.id) {
        Some(info) if !wrong.holds(place) && checksum_is_right(buffer, &candidate, info.extra_crc) => {
            Front::Frame { len: candidate.len, known: true }
        }
        Some(_) => Front::Garbage { bad_crc: true },
        None => unknown(buffer, candidate.len, is_stream, place, wrong),
    }
}

/// Without the definition there is no checksum to tell a frame from noise: it counts as one only when another frame, or
/// nothing, follows it, and when it does not cover the beginning of a frame that can be checked.
fn unknown(buffer: &[u8], len: usize, is_stream: bool, place: u64, wrong: &mut Wrong) -> Front {
    if !matches!(buffer.get(len), None | Some(&STX_V1 | &STX_V2)) {
        return Front::Garbage { bad_crc: false };
    }
    let mut may_cover = false;
    for at in 1..len {
        let (inner, place) = (&buffer[at..], place + at as u64);
        match candidate(inner) {
            Ok(candidate) => match info(candidate.id) {
                Some(_) if !candidate.is_whole(inner) => may_cover = true,
                Some(_) if wrong.holds(place) => {}
                Some(info) if checksum_is_right(inner, &candidate, info.extra_crc) => {
                    return Front::Garbage { bad_crc: false };
                }
                Some(_) => wrong.add(place),
                None => {}
            },
            Err(Front::Incomplete) => may_cover |= matches!(inner[0], STX_V1 | STX_V2),
            Err(_) => {}
        }
    }
    if may_cover && is_stream { Front::Incomplete } else { Front::Frame { len, known: false } }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    thread_local! {
        /// Checksums that were calculated.
        pub(super) static CHECKED: Cell<usize> = const { Cell::new(0) };
    }

    // fault 53: bytes of which each may begin a frame, one at a time: as many checksums as bytes at most
    #[test]
    fn no_candidate_is_checked_twice_however_short_the_pieces_are() {
        // An unknown frame, repeated, full of beginnings of known frames.
        let mut bytes = [STX_V1; 4096];
        bytes.iter_mut().skip(5).step_by(262).for_each(|id| *id = 0xff);
        let (mut decoder, mut found) = (FrameDecoder::new(), 0);
        for byte in bytes {
            decoder.push(&[byte]);
            found += std::iter::from_fn(|| decoder.next_frame()).count();
        }
        assert!(found > 10 && CHECKED.get() > bytes.len() / 2, "{found} frames");
        assert!(CHECKED.get() <= bytes.len(), "{} checksums of {} bytes", CHECKED.get(), bytes.len());
    }
}
