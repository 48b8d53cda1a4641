//! The reads and writes of MAVFTP on the way.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};

use crate::transfer::timing::SILENCE_LIMIT;

/// A request for one chunk of the file.
#[derive(Debug, Clone, Copy)]
struct Sent {
    sequence: u16,
    chunk: usize,
    at: MonoTime,
}

/// What an answer says about the requests.
#[derive(Debug)]
pub(super) struct Answered {
    pub chunk: usize,
    pub round_trip: Duration,
    /// Chunks of the requests before it, which the vehicle would have answered first: they were lost, most likely.
    pub overtaken: Vec<usize>,
}

/// The requests on the way, in the order of sending, and those that were given up.
///
/// The number of an answer tells which request it is to. So one that comes late counts all the same, and tells the
/// round trip even if the request was repeated meanwhile: where the delay has grown, no answer would be in time else.
#[derive(Debug)]
pub(super) struct Requests {
    on_the_way: VecDeque<Sent>,
    /// Given up in the last [`SILENCE_LIMIT`].
    given_up: VecDeque<Sent>,
    /// Whether the vehicle works them off in order.
    is_in_order: bool,
}

impl Requests {
    pub(super) fn new(is_in_order: bool) -> Self {
        Self { on_the_way: VecDeque::new(), given_up: VecDeque::new(), is_in_order }
    }

    /// Number of requests on the way.
    pub(super) fn len(&self) -> usize {
        self.on_the_way.len()
    }

    pub(super) fn has(&self, chunk: usize) -> bool {
        self.on_the_way.iter().any(|sent| sent.chunk == chunk)
    }

    /// When the oldest on the way was sent.
    pub(super) fn oldest(&self) -> Option<MonoTime> {
        self.on_the_way.front().map(|sent| sent.at)
    }

    pub(super) fn sent(&mut self, sequence: u16, chunk: usize, now: MonoTime) {
        self.given_up.retain(|sent| now < sent.at + SILENCE_LIMIT);
        self.on_the_way.push_back(Sent { sequence, chunk, at: now });
    }

    /// Takes the request that an answer is to. A late refusal says nothing that is not known: the chunk is to be asked
    /// for anew.
    pub(super) fn answered(&mut self, answer: &FtpPayload, now: MonoTime) -> Option<Answered> {
        let is_it = |sent: &Sent| sent.sequence == answer.sequence.wrapping_sub(1);
        let mut overtaken = Vec::new();
        let sent = match self.on_the_way.iter().position(is_it) {
            Some(place) => {
                if self.is_in_order {
                    overtaken.extend(self.on_the_way.iter().take(place).map(|sent| sent.chunk));
                    self.given_up.extend(self.on_the_way.drain(..place));
                    self.on_the_way.pop_front()
                } else {
                    self.on_the_way.remove(place)
                }
            }
            None if answer.opcode == FtpOpcode::ACK => {
                let place = self.given_up.iter().position(is_it)?;
                self.given_up.remove(place)
            }
            None => None,
        }?;
        Some(Answered { chunk: sent.chunk, round_trip: now.since(sent.at), overtaken })
    }

    /// Gives up the requests that have waited for so long, and tells their chunks.
    pub(super) fn give_up(&mut self, timeout: Duration, now: MonoTime) -> Vec<usize> {
        let late = self.on_the_way.iter().take_while(|sent| now >= sent.at + timeout).count();
        let chunks = self.on_the_way.iter().take(late).map(|sent| sent.chunk).collect();
        self.given_up.extend(self.on_the_way.drain(..late));
        chunks
    }

    /// Forgets all: their answers do not count any more.
    pub(super) fn clear(&mut self) {
        self.on_the_way.clear();
        self.given_up.clear();
    }
}
