//! Files of a vehicle over MAVFTP (<https://mavlink.io/en/services/ftp.html>): reading, writing, and their shared
//! parts.
//!
//! ArduPilot's behaviour, which the clients are designed for (`GCS_FTP.cpp`, captures/mission-upload-ftp.tlog):
//!
//! - Up to 4.7 one session for all channels and stations. A client with an open file keeps it until 3 s without an answer have
//!   passed; others get InvalidSession. From 4.8 on five sessions, told apart by station, channel and id; one that is idle
//!   for 3 s gives way to a sixth, one that is idle for 20 s is closed. So each of our sessions has an id of its own
//!   ([`super::FtpSessions`]), and when the end of one was lost, the next ends it.
//! - An uploaded plan becomes the plan when its session ends, not before. With several sessions a file can be opened and
//!   read while that end is still missing, and holds the old plan: what is read counts only when the vehicle has answered
//!   to the end of the upload before it was opened ([`Closing`]).
//! - Requests are worked off in order, so several can be on the way: also those that follow an open that is not answered
//!   yet. Five are queued in each turn of the main loop, a sixth is dropped: `pace`.
//! - A repeated request (same number as the last one answered) gets the last answer again. An open is therefore repeated
//!   with its number; reads and writes, which may be done twice, get a new one.

mod pace;
mod read;
mod requests;
mod write;

pub use read::FtpGet;
pub(crate) use read::{FileEnd, FileRead};
pub(crate) use write::FileWrite;

use vencejo_proto::ftp::{FtpError, FtpOpcode, FtpPayload};
use vencejo_proto::{Address, Message, MonoTime};

use super::config::FtpLease;
use super::items::Outbox;
use super::timing::{FTP_ABSENT_AFTER, FTP_BUSY_WAIT, FTP_FIRST_TIMEOUT, RESTARTS, RoundTrip, SILENCE_LIMIT};
use super::{TransferConfig, TransferError, TransferOutput};

/// How often a session of ours is ended before another station is suspected.
const EVICTIONS: u32 = 3;

/// Messages that end an upload's session so that the vehicle does not take its file, should it still be open: the magic
/// number at its front is overwritten first.
pub(crate) fn abandon(config: &TransferConfig, session: u8) -> [Message; 2] {
    let sequence = config.ftp_sessions.lease().sequence;
    [
        FtpPayload::request(FtpOpcode::WRITE_FILE, session, sequence, 0, &[0; 10]),
        FtpPayload::request(FtpOpcode::TERMINATE_SESSION, session, sequence.wrapping_add(1), 0, &[]),
    ]
    .map(|payload| payload.to_message(config.vehicle))
}

/// One file on one vehicle: numbers, opening with all its ways to fail, and when to give up.
#[derive(Debug)]
struct Session {
    config: TransferConfig,
    path: String,
    lease: FtpLease,
    /// The session's id as the vehicle counts: ours on ArduPilot, else the one that it gave.
    id: u8,
    next_sequence: u16,
    opcode: FtpOpcode,
    opening: Opening,
    /// A session to end before opening.
    closing: Option<Closing>,
    round_trip: RoundTrip,
    began: MonoTime,
    /// When the transfer last progressed.
    progressed: MonoTime,
    was_heard: bool,
    /// How often the vehicle refused because another session is open.
    busy: u32,
    has_waited: bool,
    restarts: u32,
    out: Outbox,
}

/// A session of ours to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Closing {
    /// One that carried an upload: the vehicle must have answered before anything is read.
    Upload(u8),
    /// One that was left open, most likely: the end of it was lost. Done when the file opens.
    Stale(u8),
}

impl Closing {
    fn session(self) -> u8 {
        match self {
            Self::Upload(session) | Self::Stale(session) => session,
        }
    }

    /// What ends it. A reset ends the session that it names where there is one for all, else all that are ours, also
    /// those of a program that ended before.
    fn opcode(self) -> FtpOpcode {
        match self {
            Self::Upload(_) => FtpOpcode::TERMINATE_SESSION,
            Self::Stale(_) => FtpOpcode::RESET_SESSIONS,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Opening {
    /// An upload must be ended before the file is opened: asked again at a time.
    Closing { retry_at: MonoTime },
    /// Asked for with this number, so often; to be repeated at a time.
    Asked { sequence: u16, first: MonoTime, tries: u32, retry_at: MonoTime },
    /// Another session is open; ask anew at a time.
    Busy { retry_at: MonoTime },
    /// Open since.
    Open { since: MonoTime },
}

/// The meaning of an answer for the session.
#[derive(Debug, PartialEq)]
enum Event {
    /// Nothing.
    None,
    /// The file is open now.
    Opened,
    /// The open was refused because of another session; requests that went with it are void.
    Busy,
    /// Everything has to be repeated in a new session.
    Restart,
    /// An answer to a request of the reader or writer.
    Answer(FtpPayload),
    /// It is over.
    Failed(TransferError),
}

impl Session {
    fn new(config: &TransferConfig, path: &str, opcode: FtpOpcode, upload: Option<u8>, now: MonoTime) -> Self {
        let lease = config.ftp_sessions.lease();
        let mut session = Self {
            config: config.clone(),
            path: path.to_owned(),
            lease,
            id: lease.session,
            next_sequence: lease.sequence,
            opcode,
            opening: Opening::Busy { retry_at: now },
            closing: upload.map(Closing::Upload),
            round_trip: RoundTrip::new(config.round_trip, FTP_FIRST_TIMEOUT),
            began: now,
            progressed: now,
            was_heard: false,
            busy: 0,
            has_waited: false,
            restarts: 0,
            out: Outbox::new(),
        };
        session.open(now);
        session
    }

    fn is_open(&self) -> bool {
        matches!(self.opening, Opening::Open { .. })
    }

    /// Whether requests may follow the open without waiting for its answer.
    fn may_follow(&self) -> bool {
        self.is_open() || (self.config.is_ardupilot && matches!(self.opening, Opening::Asked { .. }))
    }

    /// Sends a request with a new number, which is returned.
    fn send(&mut self, make: impl FnOnce(u8, u16) -> FtpPayload) -> u16 {
        let sequence = self.next_sequence;
        self.next_sequence = sequence.wrapping_add(1);
        let message = make(self.id, sequence).to_message(self.config.vehicle);
        self.out.push_back(TransferOutput::Send(message));
        sequence
    }

    fn terminate(&mut self, session: u8) {
        self.send(|_, sequence| FtpPayload::request(FtpOpcode::TERMINATE_SESSION, session, sequence, 0, &[]));
    }

    /// Ends the session that is to be ended before opening, if there is one.
    fn close(&mut self) {
        if let Some(closing) = self.closing {
            self.send(|_, sequence| FtpPayload::request(closing.opcode(), closing.session(), sequence, 0, &[]));
        }
    }

    /// Asks to open the file, with a new number.
    fn open(&mut self, now: MonoTime) {
        self.close();
        let (opcode, path) = (self.opcode, self.path.clone());
        let sequence = self.send(|id, sequence| FtpPayload::request(opcode, id, sequence, 0, path.as_bytes()));
        let retry_at = now + self.round_trip.timeout();
        self.opening = Opening::Asked { sequence, first: now, tries: 1, retry_at };
    }

    /// Starts anew in a new session; an error when that was done too often.
    fn restart(&mut self, now: MonoTime) -> Result<(), TransferError> {
        self.restarts += 1;
        if self.restarts > RESTARTS {
            return Err(TransferError::NoProgress { step: "transferring a file by MAVFTP", attempts: self.restarts });
        }
        self.closing = Some(Closing::Stale(self.id));
        self.take_new_lease();
        self.open(now);
        Ok(())
    }

    fn take_new_lease(&mut self) {
        self.lease = self.config.ftp_sessions.lease();
        self.id = self.lease.session;
        self.next_sequence = self.lease.sequence;
    }

    /// The file is open. Before an upload is known to have ended that is too early: what would be read may be what was
    /// there before. Then the upload is ended first, and the file opened anew, in a session with which no late answer
    /// can be confused.
    fn opened(&mut self, now: MonoTime) -> Event {
        self.busy = 0;
        self.progress(now);
        if let Some(Closing::Upload(_)) = self.closing {
            self.terminate(self.id);
            self.take_new_lease();
            self.close();
            self.opening = Opening::Closing { retry_at: now + self.round_trip.timeout() };
            return Event::Busy;
        }
        self.closing = None;
        self.opening = Opening::Open { since: now };
        Event::Opened
    }

    fn failed(&self, step: &'static str, error: FtpError) -> TransferError {
        TransferError::Ftp { step, path: self.path.clone(), error }
    }

    /// Sorts an incoming message.
    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) -> Event {
        if !self.config.concerns_us(from, message) {
            return Event::None;
        }
        let Some((_, answer)) = FtpPayload::from_message(message) else { return Event::None };
        if answer.opcode != FtpOpcode::ACK && answer.opcode != FtpOpcode::NAK {
            return Event::None;
        }
        if answer.req_opcode == FtpOpcode::TERMINATE_SESSION || answer.req_opcode == FtpOpcode::RESET_SESSIONS {
            // A refusal too says that it is no longer open; whether the vehicle took its file is for the reader to see.
            if self.closing.is_some_and(|closing| closing.session() == answer.session) {
                self.closing = None;
                self.was_heard = true;
                if let Opening::Closing { .. } = self.opening {
                    self.open(now);
                }
            }
            return Event::None;
        }
        if answer.req_opcode == self.opcode {
            return self.on_opened(&answer, now);
        }
        if answer.session != self.id {
            return Event::None;
        }
        self.was_heard = true;
        // An answer to what followed the open says that the open was done, though its own answer may be lost.
        if answer.opcode == FtpOpcode::ACK
            && self.config.is_ardupilot
            && !self.is_open()
            && self.opened(now) == Event::Busy
        {
            return Event::Busy;
        }
        Event::Answer(answer)
    }

    /// Notes progress.
    fn progress(&mut self, now: MonoTime) {
        self.progressed = now;
    }

    fn on_opened(&mut self, answer: &FtpPayload, now: MonoTime) -> Event {
        let Opening::Asked { sequence, first, tries, .. } = self.opening else { return Event::None };
        if answer.sequence != sequence.wrapping_add(1) || (self.config.is_ardupilot && answer.session != self.id) {
            return Event::None;
        }
        self.was_heard = true;
        if tries == 1 {
            self.round_trip.sample(now.since(first));
        }
        match answer.error() {
            None => {
                self.id = answer.session;
                self.opened(now)
            }
            // It is open already, and in our session: a repeated request of ours.
            Some(error) if error.code == FtpError::FAIL && self.config.is_ardupilot => self.opened(now),
            Some(error) if error.code == FtpError::INVALID_SESSION || error.code == FtpError::NO_SESSIONS_AVAILABLE => {
                self.on_busy(now)
            }
            // ArduPilot takes one upload at a time (`AP_Filesystem_Mission::open`): another session has one open.
            Some(error) if self.is_create_refused(error) => self.on_busy(now),
            Some(error) => Event::Failed(self.failed("opening", error)),
        }
    }

    fn is_create_refused(&self, error: FtpError) -> bool {
        self.config.is_ardupilot && self.opcode == FtpOpcode::CREATE_FILE && error.code == FtpError::FAIL_ERRNO
    }

    /// Another session is open.
    fn on_busy(&mut self, now: MonoTime) -> Event {
        self.busy += 1;
        let retry_at = if self.busy <= EVICTIONS {
            // Most likely it is ours: its end was lost, or overtaken by this open, or a late duplicate has opened it
            // again. Once that is ended, it is free.
            self.closing.get_or_insert(Closing::Stale(self.lease.previous));
            if self.busy == 1 { now } else { now + self.round_trip.timeout() }
        } else if self.has_waited {
            return Event::Failed(TransferError::FtpBusy { path: self.path.clone() });
        } else {
            self.has_waited = true;
            now + FTP_BUSY_WAIT
        };
        self.opening = Opening::Busy { retry_at };
        Event::Busy
    }

    /// A file that was open is no longer, or a request came before the open.
    fn on_not_open(&mut self, now: MonoTime) -> Event {
        match &mut self.opening {
            Opening::Asked { retry_at, .. } => {
                *retry_at = now;
                Event::None
            }
            Opening::Busy { .. } | Opening::Closing { .. } => Event::None,
            // A late answer to what followed an open that was lost.
            Opening::Open { since } if now.since(*since) < self.round_trip.timeout() => Event::None,
            Opening::Open { .. } => Event::Restart,
        }
    }

    /// When a vehicle that has answered nothing has no MAVFTP. Where the link is slow, its first answer may take longer
    /// than was measured.
    fn absent_at(&self) -> MonoTime {
        self.began + FTP_ABSENT_AFTER.max(self.round_trip.first_timeout() * 3)
    }

    /// Advances time; `Event::Opened` when the open was requested anew.
    fn on_time(&mut self, now: MonoTime) -> Event {
        let waited = now.since(self.progressed);
        if !self.was_heard && now >= self.absent_at() {
            return Event::Failed(TransferError::FtpAbsent { waited });
        }
        if waited >= self.round_trip.limit(SILENCE_LIMIT) {
            return Event::Failed(TransferError::Timeout { step: "transferring a file by MAVFTP", waited });
        }
        match self.opening {
            Opening::Asked { sequence, first, tries, retry_at } if now >= retry_at => {
                self.round_trip.timed_out();
                self.close();
                let open = FtpPayload::request(self.opcode, self.id, sequence, 0, self.path.as_bytes());
                self.out.push_back(TransferOutput::Send(open.to_message(self.config.vehicle)));
                let retry_at = now + self.round_trip.timeout();
                self.opening = Opening::Asked { sequence, first, tries: tries + 1, retry_at };
                Event::Opened
            }
            Opening::Busy { retry_at } if now >= retry_at => {
                self.open(now);
                Event::Opened
            }
            Opening::Closing { retry_at } if now >= retry_at => {
                self.round_trip.timed_out();
                self.close();
                self.opening = Opening::Closing { retry_at: now + self.round_trip.timeout() };
                Event::None
            }
            _ => Event::None,
        }
    }

    fn deadline(&self) -> MonoTime {
        let gone = self.progressed + self.round_trip.limit(SILENCE_LIMIT);
        let gone = if self.was_heard { gone } else { gone.min(self.absent_at()) };
        match self.opening {
            Opening::Asked { retry_at, .. } | Opening::Busy { retry_at } | Opening::Closing { retry_at } => {
                gone.min(retry_at)
            }
            Opening::Open { .. } => gone,
        }
    }
}
