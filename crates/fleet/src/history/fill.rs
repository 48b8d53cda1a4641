//! What a ground station lacks of one aircraft's history, and when it asks for it. No I/O; time comes in.
//!
//! One question at a time. A piece is as large as comes back soon, and after it the way is left alone for as long as
//! the piece took: so orders keep their way. What the aircraft has no more is noted, and not asked for again.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use vencejo_proto::MonoTime;

use super::ranges::Ranges;
use super::record::{BadPiece, Index, MAX_PIECE_BYTES, Piece, Record, Stream, Wanted};
use crate::budget::Fastest;
use crate::payload::VERSION;

/// How often it is asked what there is, where nothing is missing.
pub const INDEX_EVERY: Duration = Duration::from_secs(30);
/// How long after something was missed: what is said is on the disk a second later.
const HOLE_AFTER: Duration = Duration::from_secs(2);
/// The least that is asked for.
const LEAST_BYTES: u32 = 1024;
/// What is asked for first.
const FIRST_BYTES: u32 = 2 * 1024;
/// So much more is asked for after a piece that came soon.
const MORE_BYTES: u32 = 1024;
/// A piece that takes so much longer than the fastest answer was too large.
const LATE: Duration = Duration::from_millis(100);
/// How long the fastest answer counts, at least. In that time there is an index, which is small whatever pieces are.
const MEMORY: Duration = Duration::from_secs(60);
/// The shortest rest between two questions.
const REST: Duration = Duration::from_millis(20);
/// How long an answer is waited for.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(5);
/// The wait after silence; twice as long each time…
const AGAIN_AFTER: Duration = Duration::from_secs(1);
/// …up to this.
const AGAIN_AT_MOST: Duration = Duration::from_secs(30);

/// A question to the aircraft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Question {
    /// What is kept on board? With a number that the answer repeats.
    Index(u64),
    /// These, please.
    Piece(Wanted),
}

/// Numbers that are not in the archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// The boot.
    pub boot: u64,
    /// The stream.
    pub stream: Stream,
    /// The first number.
    pub first: u64,
    /// The last.
    pub last: u64,
    /// Whether it is not to be had any more.
    pub is_lost: bool,
}

/// One stream of one boot.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Held {
    /// What is in the archive.
    pub have: Ranges,
    /// What is not to be had.
    pub lost: Ranges,
    /// What is on board, as far as it was told.
    kept: Ranges,
}

impl Held {
    /// One with this much.
    pub fn of(have: Ranges, lost: Ranges) -> Self {
        Self { have, lost, kept: Ranges::default() }
    }

    /// What another has is here as well.
    pub fn add(&mut self, other: &Self) {
        other.have.iter().for_each(|(first, last)| self.have.add(first, last));
    }

    /// What is to be had and missing, ascending.
    fn wanted(&self) -> impl Iterator<Item = (u64, u64)> {
        let missing = self.kept.iter().flat_map(|(first, last)| self.have.missing(first, last));
        missing.flat_map(|(first, last)| self.lost.missing(first, last))
    }

    /// What is missing in `spans` is not to be had.
    fn lose(&mut self, spans: impl IntoIterator<Item = (u64, u64)>) {
        for (first, last) in spans {
            for (first, last) in self.have.missing(first, last) {
                self.lost.add(first, last);
            }
        }
    }
}

/// The archive of one aircraft, by numbers.
#[derive(Debug, Clone)]
pub struct Fill {
    held: BTreeMap<(u64, Stream), Held>,
    /// Boots, newest first, as the aircraft told them.
    boots: Vec<u64>,
    asked: Option<(Question, MonoTime)>,
    nonce: u64,
    /// Boots that were known when the last index was asked for.
    asked_about: BTreeSet<u64>,
    due: MonoTime,
    index_due: MonoTime,
    silences: u32,
    piece_bytes: u32,
    fastest: Fastest,
    /// Whether nothing was missing when that was looked at, and nothing came since that could change it.
    is_whole: bool,
}

impl Fill {
    /// With what is in the archive already.
    pub fn new(held: BTreeMap<(u64, Stream), Held>) -> Self {
        Self {
            held,
            boots: Vec::new(),
            asked: None,
            nonce: 0,
            asked_about: BTreeSet::new(),
            due: MonoTime::ZERO,
            index_due: MonoTime::ZERO,
            silences: 0,
            piece_bytes: FIRST_BYTES,
            fastest: Fastest::new(MEMORY, MonoTime::ZERO),
            is_whole: false,
        }
    }

    /// What is in the archive.
    pub fn held(&self) -> &BTreeMap<(u64, Stream), Held> {
        &self.held
    }

    /// These were found in the archive besides.
    pub fn add(&mut self, found: &BTreeMap<(u64, Stream), Held>) {
        for (key, found) in found {
            self.held.entry(*key).or_default().add(found);
        }
    }

    /// A record that was taken could not be kept: it is missing again.
    pub fn drop_again(&mut self, boot: u64, stream: Stream, number: u64) {
        if let Some(held) = self.held.get_mut(&(boot, stream)) {
            held.have.remove(number);
            self.is_whole = false;
        }
    }

    /// Takes back what was believed to be in the archive: it goes on from an earlier picture.
    pub fn back_to(&mut self, earlier: BTreeMap<(u64, Stream), Held>) {
        self.held = earlier;
        (self.index_due, self.is_whole) = (MonoTime::ZERO, false);
    }

    /// A record came, by whatever way; whether it belongs into the archive: it is not there yet.
    pub fn take(&mut self, boot: u64, stream: Stream, number: u64) -> bool {
        let held = self.held.entry((boot, stream)).or_default();
        let is_new = number > 0 && number < u64::MAX && !held.have.contains(number);
        if is_new {
            held.have.add(number, number);
        }
        is_new
    }

    /// The aircraft is there again: what is kept is asked at once.
    pub fn on_present(&mut self, now: MonoTime) {
        (self.due, self.index_due, self.silences) = (now, now, 0);
    }

    /// Something was missed, or an aircraft is new: it is asked soon what is kept, when that is on the disk there.
    pub fn on_hole(&mut self, now: MonoTime) {
        self.index_due = self.index_due.min(now + HOLE_AFTER);
    }

    /// What is in the archive, to be remembered: of more than `most` boots those that the aircraft has.
    pub fn remembered(&self, most: usize) -> BTreeMap<(u64, Stream), Held> {
        let mut held = self.held.clone();
        let boots = held.keys().map(|(boot, _)| *boot).collect::<BTreeSet<_>>().len();
        held.retain(|(boot, _), _| boots <= most || self.boots.contains(boot));
        held
    }

    /// Whether there may be a question now. Costs nothing, so that many are looked at often.
    pub fn is_due(&self, now: MonoTime) -> bool {
        self.asked.is_none() && now >= self.due && (!self.is_whole || now >= self.index_due)
    }

    /// The next question, where one is due.
    pub fn ask(&mut self, now: MonoTime) -> Option<Question> {
        if !self.is_due(now) {
            return None;
        }
        let question = match self.next_wanted() {
            _ if now >= self.index_due => {
                self.nonce += 1;
                self.asked_about = self.held.keys().map(|(boot, _)| *boot).collect();
                Question::Index(self.nonce)
            }
            Some(wanted) => Question::Piece(wanted),
            None => {
                self.is_whole = true;
                return None;
            }
        };
        self.asked = Some((question, now));
        Some(question)
    }

    fn next_wanted(&self) -> Option<Wanted> {
        for boot in &self.boots {
            for stream in Stream::ALL {
                let Some((first, last)) = self.held.get(&(*boot, stream)).and_then(|held| held.wanted().next()) else {
                    continue;
                };
                let (boot, stream, max_bytes) = (*boot, stream.code(), self.piece_bytes);
                return Some(Wanted { version: VERSION, boot, stream, first, last, max_bytes });
            }
        }
        None
    }

    /// An index came. `false`: nobody asked for it now, and it is not used.
    pub fn on_index(&mut self, index: &Index, now: MonoTime) -> bool {
        let Some((Question::Index(nonce), asked_at)) = self.asked else { return false };
        if index.nonce != nonce {
            return false;
        }
        self.answered(now.since(asked_at), now);
        (self.index_due, self.is_whole) = (now + INDEX_EVERY, false);
        self.held.values_mut().for_each(|held| held.kept = Ranges::default());
        self.boots.clear();
        for kept in &index.kept {
            let Some(stream) = Stream::of_code(kept.stream) else { continue };
            if !self.boots.contains(&kept.boot) {
                self.boots.push(kept.boot);
            }
            let held = self.held.entry((kept.boot, stream)).or_default();
            held.kept = kept.spans.iter().map(|span| (span.first, span.last)).collect();
        }
        if !index.is_whole {
            return true;
        }
        for ((boot, _), held) in &mut self.held {
            if held.kept.spans() == 0 && !self.asked_about.contains(boot) {
                // It began after this was told.
                continue;
            }
            // What runs on is told again; all else is over, up to the last that anybody has of it.
            let end = if *boot == index.boot { held.kept.last() } else { held.have.last().max(held.kept.last()) };
            if let Some(end) = end {
                held.lose(held.kept.missing(1, end));
            }
        }
        true
    }

    /// A piece came; gives what is new in it, which belongs into the archive.
    ///
    /// # Errors
    /// [`BadPiece`]: it is not used, and the question is asked again.
    pub fn on_piece(&mut self, piece: &Piece, now: MonoTime) -> Result<Vec<Record>, BadPiece> {
        let Some((Question::Piece(wanted), asked_at)) = self.asked else { return Err(BadPiece::Other) };
        let numbers = || piece.entries.iter().map(|entry| entry.number);
        let is_answer = (piece.boot, piece.stream, piece.first) == (wanted.boot, wanted.stream, wanted.first)
            && (wanted.first..=wanted.last).contains(&piece.last)
            && numbers().all(|number| (piece.first..=piece.last).contains(&number))
            && numbers().zip(numbers().skip(1)).all(|(one, next)| one < next);
        let (true, Some(stream)) = (is_answer, Stream::of_code(wanted.stream)) else { return Err(BadPiece::Other) };
        let took = now.since(asked_at);
        let fastest = self.answered(took, now);
        self.piece_bytes = if took > (fastest * 2).max(fastest + LATE) {
            (self.piece_bytes / 2).max(LEAST_BYTES)
        } else {
            (self.piece_bytes + MORE_BYTES).min(MAX_PIECE_BYTES)
        };
        let new = piece.entries.iter().filter(|entry| self.take(piece.boot, stream, entry.number));
        let record = |entry: &super::record::Entry| Record {
            stream,
            boot: piece.boot,
            number: entry.number,
            clock_ms: entry.clock_ms,
            unix_ns: entry.unix_ns,
            data: entry.data.clone(),
        };
        let new = new.map(record).collect();
        if let Some(held) = self.held.get_mut(&(piece.boot, stream)) {
            held.lose([(piece.first, piece.last)]);
        }
        Ok(new)
    }

    /// An answer came after this time; gives the fastest of late.
    fn answered(&mut self, took: Duration, now: MonoTime) -> Duration {
        (self.asked, self.silences) = (None, 0);
        // As long as it took: half of the way is left to others.
        self.due = now + took.max(REST);
        self.fastest.on_answer(took, now)
    }

    /// No answer came, or none that can be used.
    pub fn on_silence(&mut self, now: MonoTime) {
        self.asked = None;
        self.piece_bytes = (self.piece_bytes / 2).max(LEAST_BYTES);
        self.due = now + (AGAIN_AFTER * (1 << self.silences.min(5))).min(AGAIN_AT_MOST);
        self.silences += 1;
        // The way there may be another one now.
        self.fastest = Fastest::new(MEMORY, now);
    }

    /// What is not in the archive, oldest number first.
    pub fn gaps(&self) -> Vec<Gap> {
        let mut gaps = Vec::new();
        for (&(boot, stream), held) in &self.held {
            let end = held.have.last().max(held.kept.last()).max(held.lost.last()).unwrap_or(0);
            for (first, last) in held.have.missing(1, end) {
                let open = held.lost.missing(first, last);
                let open = open.iter().map(|&(first, last)| (first, last, false));
                let lost = held.lost.iter().filter(|&(from, to)| from <= last && to >= first);
                let lost = lost.map(|(from, to)| (from.max(first), to.min(last), true));
                let mut parts: Vec<_> = open.chain(lost).collect();
                parts.sort_unstable();
                gaps.extend(parts.into_iter().map(|(first, last, is_lost)| Gap { boot, stream, first, last, is_lost }));
            }
        }
        gaps
    }
}

#[cfg(test)]
mod tests;
