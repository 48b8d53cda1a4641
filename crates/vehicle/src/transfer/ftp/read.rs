//! Reading a file over MAVFTP: a burst, then the gaps left by losses.

use std::fmt;
use std::time::Duration;

use vencejo_proto::ftp::{FTP_MAX_DATA, FtpError, FtpOpcode, FtpPayload};
use vencejo_proto::{Address, Message, MonoTime};

use super::pace::Pace;
use super::requests::{Answered, Requests};
use super::{Event, Session};
use crate::transfer::{Transfer, TransferConfig, TransferError, TransferOutput};

/// Bytes of a read. One size for the whole file: ArduPilot's parameter file is padded by it and refuses another.
const CHUNK: usize = FTP_MAX_DATA;

/// Missing chunks at the end from which on another burst is requested; fewer are read singly.
const BURST_WORTH: usize = 8;

/// Most parts of one burst (ArduPilot sends 500), with room to spare.
const MAX_BURST: u16 = 2000;

/// Where a file ends, as its first bytes tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileEnd {
    /// At this length.
    At(usize),
    /// Where a read comes back short. (The size reported at opening may be invented: ArduPilot reports 1 MiB for a
    /// plan.)
    WhenShort,
}

/// Reads a file's end from its first chunk; a text when it is not the file that was wanted.
pub(crate) type EndOf = Box<dyn Fn(&[u8]) -> Result<FileEnd, String> + Send + Sync>;

/// Reads a file.
pub(crate) struct FileRead {
    session: Session,
    max_len: usize,
    end_of: EndOf,
    data: Vec<u8>,
    has: Vec<bool>,
    have: usize,
    /// Length of the file, once known.
    end: Option<usize>,
    burst: Burst,
    /// Number of the burst's request; its parts count on from there.
    burst_sequence: u16,
    /// Bursts of which no part has come yet.
    awaited: Vec<AwaitedBurst>,
    requests: Requests,
    pace: Pace,
    result: Option<Result<Vec<u8>, TransferError>>,
    is_over: bool,
}

#[derive(Debug, Clone, Copy)]
enum Burst {
    /// None runs.
    Off,
    /// One was asked for.
    Asked { at: MonoTime },
    /// One runs: when its last part came, and how far parts are apart.
    Runs { last: MonoTime, apart: Duration },
    /// The vehicle does not know bursts.
    Unknown,
}

#[derive(Debug, Clone, Copy)]
struct AwaitedBurst {
    sequence: u16,
    offset: u32,
    at: MonoTime,
}

impl AwaitedBurst {
    /// Whether a part is of this burst: both its number and its place count on from those of the request. (By the number
    /// alone it may be of a burst that was asked for shortly before.)
    fn has(&self, part: &FtpPayload) -> bool {
        let nth = u32::from(part.sequence.wrapping_sub(self.sequence).wrapping_sub(1));
        part.offset.wrapping_sub(self.offset) == nth * CHUNK as u32
    }
}

impl fmt::Debug for FileRead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FileRead")
            .field("session", &self.session)
            .field("have", &self.have)
            .field("end", &self.end)
            .field("burst", &self.burst)
            .field("requests", &self.requests)
            .finish_non_exhaustive()
    }
}

impl FileRead {
    /// Begins to read the file at `path`, at most `max_len` bytes of it; `upload` is a session to end first, with
    /// the file that it carried.
    pub(crate) fn new(
        config: &TransferConfig,
        path: &str,
        max_len: usize,
        end_of: EndOf,
        upload: Option<u8>,
        now: MonoTime,
    ) -> Self {
        let mut read = Self {
            session: Session::new(config, path, FtpOpcode::OPEN_FILE_RO, upload, now),
            max_len,
            end_of,
            data: Vec::new(),
            has: Vec::new(),
            have: 0,
            end: None,
            burst: Burst::Off,
            burst_sequence: 0,
            awaited: Vec::new(),
            requests: Requests::new(config.is_ardupilot),
            pace: Pace::new(config.is_ardupilot),
            result: None,
            is_over: false,
        };
        read.pump(now);
        read
    }

    fn end(&mut self, result: Result<Vec<u8>, TransferError>) {
        if self.session.is_open() {
            let id = self.session.id;
            self.session.terminate(id);
        }
        self.is_over = true;
        self.result = Some(result);
    }

    fn bad_file(&mut self, problem: String) {
        let path = self.session.path.clone();
        self.end(Err(TransferError::BadFile { path, problem }));
    }

    /// Whether any part of it was read.
    pub(crate) fn has_any(&self) -> bool {
        self.have > 0
    }

    /// Chunks of the file, when its length is known.
    fn chunks(&self) -> Option<usize> {
        self.end.map(|end| end.div_ceil(CHUNK))
    }

    fn has(&self, chunk: usize) -> bool {
        self.has.get(chunk).copied().unwrap_or(false)
    }

    /// Asks for what is missing: by a burst when nothing, or much at the end, is; else chunk by chunk.
    fn pump(&mut self, now: MonoTime) {
        if self.is_over || !self.session.may_follow() {
            return;
        }
        let bursts = !matches!(self.burst, Burst::Unknown);
        if matches!(self.burst, Burst::Asked { .. } | Burst::Runs { .. }) {
            return;
        }
        let known = self.has.iter().rposition(|has| *has).map_or(0, |last| last + 1);
        let chunks = self.chunks();
        let tail = chunks.map_or(usize::MAX, |chunks| chunks.saturating_sub(known));
        if bursts && self.requests.len() == 0 && (known == 0 || chunks.is_some() && tail >= BURST_WORTH) && tail > 0 {
            let offset = (known * CHUNK) as u32;
            self.burst_sequence = self.session.send(|id, sequence| {
                FtpPayload::read_request(FtpOpcode::BURST_READ_FILE, id, sequence, offset, CHUNK as u8)
            });
            self.awaited.push(AwaitedBurst { sequence: self.burst_sequence, offset, at: now });
            self.burst = Burst::Asked { at: now };
            return;
        }
        // Without a known end, one more behind what is there finds it.
        let last = chunks.unwrap_or(known + 1);
        for chunk in 0..last {
            if self.has(chunk) || self.requests.has(chunk) {
                continue;
            }
            if !self.pace.may_send(self.requests.len(), &self.session.round_trip, now) {
                break;
            }
            let offset = (chunk * CHUNK) as u32;
            let sequence = self
                .session
                .send(|id, sequence| FtpPayload::read_request(FtpOpcode::READ_FILE, id, sequence, offset, CHUNK as u8));
            self.requests.sent(sequence, chunk, now);
            self.pace.sent(now);
        }
    }

    /// Whether anything is missing that is not asked for.
    fn wants_more(&self) -> bool {
        let last = self.chunks().unwrap_or(self.has.len() + 1);
        (0..last).any(|chunk| !self.has(chunk) && !self.requests.has(chunk))
    }

    fn forget_all(&mut self) {
        self.data.clear();
        self.has.clear();
        self.have = 0;
        self.end = None;
        self.requests.clear();
        self.awaited.clear();
        self.burst = Burst::Off;
    }

    fn restart(&mut self, now: MonoTime) {
        self.forget_all();
        if let Err(error) = self.session.restart(now) {
            self.end(Err(error));
        }
    }

    /// Keeps a part of the file.
    fn store(&mut self, offset: u32, data: &[u8], now: MonoTime) {
        let offset = offset as usize;
        if !offset.is_multiple_of(CHUNK) || data.is_empty() || data.len() > CHUNK || self.has(offset / CHUNK) {
            return;
        }
        let mut data = data;
        if let Some(end) = self.end {
            // Bytes behind the end: padding, or a plan that grows while it is read.
            let Some(room) = end.checked_sub(offset).filter(|room| *room > 0) else { return };
            data = &data[..data.len().min(room)];
            if data.len() < CHUNK.min(room) {
                // Shorter than its header said: it changes while it is read.
                return self.restart(now);
            }
        }
        let len = offset + data.len();
        if len > self.max_len {
            let (count, limit) = (len as u64, self.max_len as u64);
            return self.end(Err(TransferError::TooMany { what: "bytes of a file", count, limit }));
        }
        let chunk = offset / CHUNK;
        if self.has.len() <= chunk {
            self.has.resize(chunk + 1, false);
            self.data.resize(len.max(self.data.len()), 0);
        }
        let until = len.max(self.data.len());
        self.data.resize(until, 0);
        self.data[offset..len].copy_from_slice(data);
        self.has[chunk] = true;
        self.have += 1;
        self.session.progress(now);
        if chunk == 0 && self.end.is_none() {
            match (self.end_of)(data) {
                Err(problem) => return self.bad_file(problem),
                Ok(FileEnd::WhenShort) => {}
                Ok(FileEnd::At(end)) if end > self.max_len => {
                    let (count, limit) = (end as u64, self.max_len as u64);
                    return self.end(Err(TransferError::TooMany { what: "bytes of a file", count, limit }));
                }
                Ok(FileEnd::At(end)) => self.end = Some(end),
            }
            if let Some(end) = self.end {
                if data.len() < CHUNK.min(end) {
                    return self.restart(now);
                }
                // What came before the front may be longer than the file.
                self.data.truncate(end.max(data.len()));
            }
        }
        if self.end.is_none() && data.len() < CHUNK {
            self.end = Some(len);
        }
        let total = self.end.unwrap_or(0) as u32;
        self.session
            .out
            .push_back(TransferOutput::Progress { done: (self.have * CHUNK).min(self.data.len()) as u32, total });
        self.finish_when_whole();
    }

    fn finish_when_whole(&mut self) {
        let (Some(end), Some(chunks)) = (self.end, self.chunks()) else { return };
        if self.have >= chunks && (0..chunks).all(|chunk| self.has(chunk)) {
            let mut data = std::mem::take(&mut self.data);
            data.truncate(end);
            self.end(Ok(data));
        }
    }

    fn on_answer(&mut self, answer: &FtpPayload, now: MonoTime) {
        match (answer.req_opcode, answer.error()) {
            (FtpOpcode::BURST_READ_FILE, None) => {
                if let Some(place) = self.awaited.iter().position(|burst| burst.has(answer)) {
                    self.session.round_trip.sample(now.since(self.awaited[place].at));
                    self.awaited.drain(..=place);
                }
                self.burst = match self.burst {
                    Burst::Runs { last, apart } => {
                        Burst::Runs { last: now, apart: apart * 7 / 8 + now.since(last) / 8 }
                    }
                    Burst::Asked { .. } => Burst::Runs { last: now, apart: Duration::ZERO },
                    other => other,
                };
                if answer.burst_complete {
                    self.burst = Burst::Off;
                }
                self.store(answer.offset, &answer.data, now);
            }
            (FtpOpcode::READ_FILE, None) => {
                let Some(Answered { chunk, round_trip, .. }) = self.requests.answered(answer, now) else { return };
                if answer.offset as usize == chunk * CHUNK {
                    self.session.round_trip.sample(round_trip);
                    self.pace.answered(round_trip, self.requests.len(), &self.session.round_trip);
                    self.store(answer.offset, &answer.data, now);
                }
            }
            // Of a previous burst.
            (FtpOpcode::BURST_READ_FILE, Some(_))
                if !(1..=MAX_BURST).contains(&answer.sequence.wrapping_sub(self.burst_sequence)) => {}
            (FtpOpcode::BURST_READ_FILE, Some(error)) => match error.code {
                // What is there is there; where the end is, the reads find out.
                FtpError::END_OF_FILE => {
                    if !matches!(self.burst, Burst::Unknown) {
                        self.burst = Burst::Off;
                    }
                    if self.have == 0 {
                        self.burst = Burst::Unknown;
                    }
                }
                FtpError::UNKNOWN_COMMAND => self.burst = Burst::Unknown,
                _ => self.on_refused(error, now),
            },
            (FtpOpcode::READ_FILE, Some(error)) => {
                let Some(Answered { chunk, .. }) = self.requests.answered(answer, now) else { return };
                match error.code {
                    FtpError::END_OF_FILE if self.end.is_none() => {
                        self.end = Some(chunk * CHUNK);
                        self.finish_when_whole();
                    }
                    // The file became shorter.
                    FtpError::END_OF_FILE => self.restart(now),
                    _ => self.on_refused(error, now),
                }
            }
            _ => {}
        }
    }

    fn on_refused(&mut self, error: FtpError, now: MonoTime) {
        match error.code {
            FtpError::FILE_NOT_FOUND | FtpError::INVALID_SESSION | FtpError::FAIL => {
                if self.session.on_not_open(now) == Event::Restart {
                    self.restart(now);
                }
            }
            _ => {
                let error = self.session.failed("reading", error);
                self.end(Err(error));
            }
        }
    }

    fn handle(&mut self, event: Event, now: MonoTime) {
        match event {
            Event::None | Event::Opened => {}
            Event::Busy => self.forget_all(),
            Event::Restart => self.restart(now),
            Event::Answer(answer) => self.on_answer(&answer, now),
            Event::Failed(error) => self.end(Err(error)),
        }
    }

    /// When a burst counts as over though its end was not seen.
    fn burst_patience(&self) -> Option<MonoTime> {
        let timeout = self.session.round_trip.timeout();
        match self.burst {
            Burst::Asked { at } => Some(at + timeout),
            Burst::Runs { last, apart } => Some(last + timeout.max(4 * apart)),
            Burst::Off | Burst::Unknown => None,
        }
    }
}

impl Transfer for FileRead {
    type Value = Vec<u8>;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        if self.is_over {
            return;
        }
        let event = self.session.on_message(from, message, now);
        self.handle(event, now);
        self.pump(now);
    }

    fn on_time(&mut self, now: MonoTime) {
        if self.is_over {
            return;
        }
        let event = self.session.on_time(now);
        if event == Event::Opened {
            // The open goes out again, and what follows it too.
            self.burst = if let Burst::Unknown = self.burst { Burst::Unknown } else { Burst::Off };
            self.requests.clear();
        }
        self.handle(event, now);
        if self.is_over {
            return;
        }
        if self.burst_patience().is_some_and(|at| now >= at) {
            if let Burst::Asked { .. } = self.burst {
                self.session.round_trip.timed_out();
            }
            self.burst = Burst::Off;
        }
        let timeout = self.session.round_trip.timeout();
        if !self.requests.give_up(timeout, now).is_empty() {
            self.session.round_trip.timed_out();
        }
        self.pump(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        if self.is_over {
            return None;
        }
        let mut at = self.session.deadline();
        if let Some(patience) = self.burst_patience() {
            at = at.min(patience);
        } else if self.session.may_follow()
            && self.wants_more()
            && let Some(next) = self.pace.next_at(self.requests.len(), &self.session.round_trip)
        {
            at = at.min(next);
        }
        if let Some(oldest) = self.requests.oldest() {
            at = at.min(oldest + self.session.round_trip.timeout());
        }
        Some(at)
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.session.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<Vec<u8>, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, _now: MonoTime) {
        if !self.is_over {
            self.session.out.clear();
            let id = self.session.id;
            self.session.terminate(id);
            self.is_over = true;
            self.result = Some(Err(TransferError::Cancelled));
        }
    }
}

/// Reads any file of the vehicle. See [`crate::transfer`].
#[derive(Debug)]
pub struct FtpGet(FileRead);

impl FtpGet {
    /// Begins to read the file at `path` on the vehicle, at most `max_len` bytes of it.
    ///
    /// # Errors
    /// [`TransferError::BadFile`] when the path is empty or longer than a message takes.
    pub fn new(config: &TransferConfig, path: &str, max_len: usize, now: MonoTime) -> Result<Self, TransferError> {
        if path.is_empty() || path.len() > FTP_MAX_DATA {
            let problem = format!("a path takes 1 to {FTP_MAX_DATA} bytes");
            return Err(TransferError::BadFile { path: path.chars().take(60).collect(), problem });
        }
        let end_of = Box::new(|_: &[u8]| Ok(FileEnd::WhenShort));
        Ok(Self(FileRead::new(config, path, max_len, end_of, None, now)))
    }
}

impl Transfer for FtpGet {
    type Value = Vec<u8>;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        self.0.on_message(from, message, now);
    }

    fn on_time(&mut self, now: MonoTime) {
        self.0.on_time(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.0.deadline()
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.0.poll_output()
    }

    fn result(&mut self) -> Option<Result<Vec<u8>, TransferError>> {
        self.0.result()
    }

    fn cancel(&mut self, now: MonoTime) {
        self.0.cancel(now);
    }
}
