//! Writing a file over MAVFTP, with many writes in flight.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::ftp::{FTP_MAX_DATA, FtpError, FtpOpcode, FtpPayload};
use vencejo_proto::{Address, Message, MonoTime};

use super::pace::Pace;
use super::requests::{Answered, Requests};
use super::{Event, Session, abandon};
use crate::transfer::{Transfer, TransferConfig, TransferError, TransferOutput};

/// Writes a file and leaves it open: its value is the session, which whoever reads the file back ends first. An
/// ArduPilot makes an uploaded plan its plan when the session ends.
#[derive(Debug)]
pub(crate) struct FileWrite {
    session: Session,
    file: Vec<u8>,
    /// Where each write begins and ends.
    chunks: Vec<(usize, usize)>,
    is_written: Vec<bool>,
    written: usize,
    /// Chunks to be sent, in order.
    waiting: VecDeque<usize>,
    requests: Requests,
    pace: Pace,
    result: Option<Result<u8, TransferError>>,
    is_over: bool,
}

impl FileWrite {
    /// Begins to write `file`: a header of `header_len` bytes, then units of `unit` bytes, which no write cuts in two.
    pub(crate) fn new(
        config: &TransferConfig,
        path: &str,
        file: Vec<u8>,
        unit: usize,
        header_len: usize,
        now: MonoTime,
    ) -> Self {
        let whole = |room: usize| (room / unit.max(1)).max(1) * unit.max(1);
        let mut chunks = Vec::new();
        let mut at = 0;
        while at < file.len() {
            let len = if at == 0 { header_len + whole(FTP_MAX_DATA - header_len) } else { whole(FTP_MAX_DATA) };
            let end = (at + len).min(file.len());
            chunks.push((at, end));
            at = end;
        }
        let mut write = Self {
            session: Session::new(config, path, FtpOpcode::CREATE_FILE, None, now),
            is_written: vec![false; chunks.len()],
            waiting: (0..chunks.len()).collect(),
            file,
            chunks,
            written: 0,
            requests: Requests::new(config.is_ardupilot),
            pace: Pace::new(config.is_ardupilot),
            result: None,
            is_over: false,
        };
        write.pace.sent(now);
        write.pump(now);
        write
    }

    fn end(&mut self, result: Result<u8, TransferError>) {
        self.is_over = true;
        self.result = Some(result);
    }

    /// Requests on the way, the open among them.
    fn on_the_way(&self) -> usize {
        self.requests.len() + usize::from(!self.session.is_open())
    }

    /// Sends requests as the pace allows.
    fn pump(&mut self, now: MonoTime) {
        while !self.is_over
            && self.session.may_follow()
            && self.pace.may_send(self.on_the_way(), &self.session.round_trip, now)
        {
            let Some(chunk) = self.waiting.pop_front() else { break };
            if self.is_written[chunk] {
                continue;
            }
            self.send(chunk, now);
        }
    }

    fn send(&mut self, chunk: usize, now: MonoTime) {
        let (start, end) = self.chunks[chunk];
        let data = &self.file[start..end];
        let sequence = self
            .session
            .send(|id, sequence| FtpPayload::request(FtpOpcode::WRITE_FILE, id, sequence, start as u32, data));
        self.requests.sent(sequence, chunk, now);
        self.pace.sent(now);
    }

    /// Everything that is not written yet waits to be sent again.
    fn take_back_all(&mut self) {
        self.waiting = (0..self.chunks.len()).filter(|chunk| !self.is_written[*chunk]).collect();
    }

    fn restart(&mut self, now: MonoTime) {
        self.is_written.fill(false);
        self.written = 0;
        self.requests.clear();
        self.take_back_all();
        match self.session.restart(now) {
            Ok(()) => self.pace.sent(now),
            Err(error) => {
                self.leave();
                self.end(Err(error));
            }
        }
    }

    fn on_answer(&mut self, answer: &FtpPayload, now: MonoTime) {
        if answer.req_opcode != FtpOpcode::WRITE_FILE {
            return;
        }
        let Some(Answered { chunk, round_trip, overtaken }) = self.requests.answered(answer, now) else { return };
        overtaken.into_iter().rev().for_each(|chunk| self.waiting.push_front(chunk));
        match answer.error() {
            // ArduPilot reports where it wrote; an answer with another offset is not trusted.
            None if self.session.config.is_ardupilot && answer.offset != self.chunks[chunk].0 as u32 => {
                self.waiting.push_front(chunk);
            }
            None => {
                self.session.round_trip.sample(round_trip);
                self.pace.answered(round_trip, self.requests.len(), &self.session.round_trip);
                if !std::mem::replace(&mut self.is_written[chunk], true) {
                    self.written += 1;
                    self.session.progress(now);
                }
                let (done, total) = (self.written, self.chunks.len());
                let bytes = |chunks: usize| (self.file.len() * chunks / total) as u32;
                self.session.out.push_back(TransferOutput::Progress { done: bytes(done), total: bytes(total) });
                if done == total {
                    self.end(Ok(self.session.id));
                }
            }
            Some(error) => {
                self.waiting.push_front(chunk);
                match error.code {
                    FtpError::FILE_NOT_FOUND | FtpError::INVALID_SESSION | FtpError::FAIL => {
                        if self.session.on_not_open(now) == Event::Restart {
                            self.restart(now);
                        }
                    }
                    _ => {
                        let error = self.session.failed("writing", error);
                        self.leave();
                        self.end(Err(error));
                    }
                }
            }
        }
    }

    /// Ends the session so that the vehicle does not take the file.
    fn leave(&mut self) {
        self.session.out.clear();
        self.session.out.extend(abandon(&self.session.config, self.session.id).map(TransferOutput::Send));
    }

    fn handle(&mut self, event: Event, now: MonoTime) {
        match event {
            Event::None | Event::Opened => {}
            Event::Busy => {
                self.requests.clear();
                self.take_back_all();
            }
            Event::Restart => self.restart(now),
            Event::Answer(answer) => self.on_answer(&answer, now),
            Event::Failed(error) => {
                // Unless it was refused, the file may be open, and what is on the way may complete it.
                if !matches!(error, TransferError::Ftp { .. } | TransferError::FtpBusy { .. }) {
                    self.leave();
                }
                self.end(Err(error));
            }
        }
    }
}

impl Transfer for FileWrite {
    type Value = u8;

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
            // The open goes out again: what went out behind it has gone with it, or is answered all the same.
            self.requests.give_up(Duration::ZERO, now);
            self.take_back_all();
            self.pace.sent(now);
        }
        self.handle(event, now);
        let timeout = self.session.round_trip.timeout();
        let late = self.requests.give_up(timeout, now);
        if !late.is_empty() && !self.is_over {
            self.session.round_trip.timed_out();
            late.into_iter().rev().for_each(|chunk| self.waiting.push_front(chunk));
        }
        self.pump(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        if self.is_over {
            return None;
        }
        let mut at = self.session.deadline();
        if let Some(oldest) = self.requests.oldest() {
            at = at.min(oldest + self.session.round_trip.timeout());
        }
        if !self.waiting.is_empty()
            && self.session.may_follow()
            && let Some(next) = self.pace.next_at(self.on_the_way(), &self.session.round_trip)
        {
            at = at.min(next);
        }
        Some(at)
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.session.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<u8, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, _now: MonoTime) {
        if !self.is_over {
            self.leave();
            self.end(Err(TransferError::Cancelled));
        }
    }
}
