//! What a replay plays: a recording as moments in order, whatever its file format.

use std::fmt;
use std::io;
use std::time::Duration;

use vencejo_proto::{Address, Message};
use vencejo_vehicle::HeardPlan;

/// A message of a recording, and when it was said.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Time since the beginning of the recording.
    pub at: Duration,
    /// UTC, microseconds since 1970, if the recording has it.
    pub unix_us: Option<u64>,
    /// The sender.
    pub from: Address,
    /// The message.
    pub message: Message,
}

/// Something that happened, for the scale on which a place is chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    /// Time since the beginning of the recording.
    pub at: Duration,
    /// The autopilot.
    pub from: Address,
    /// What happened.
    pub kind: MarkKind,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MarkKind {
    /// It was armed.
    Armed,
    /// It was disarmed.
    Disarmed,
    /// It changed to this flight mode.
    Mode(String),
}

/// Most plans of a recording.
pub const MAX_PLANS: usize = 100;

/// Most marks of a recording.
pub const MAX_MARKS: usize = 500;

/// What a film is about.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FilmInfo {
    /// The autopilots that are shown, each as a vehicle.
    pub autopilots: Vec<Address>,
    /// The name of the aircraft, where the recording has one; else the file's name serves.
    pub aircraft: Option<String>,
    /// UTC of the beginning, microseconds since 1970, if it is known.
    pub start_unix_us: Option<u64>,
    /// From the first moment to the last.
    pub duration: Duration,
    /// What happened, in order; at most [`MAX_MARKS`].
    pub marks: Vec<Mark>,
    /// The plans on board, and from when on, in order.
    pub plans: Vec<(Duration, HeardPlan)>,
    /// Bytes that could not be read: damaged, or torn off at the end.
    pub skipped_bytes: u64,
}

/// A recording that can be played from any place. Its methods may block; they are called off the runtime's threads.
pub trait Film: Send + 'static {
    /// What it is about.
    fn info(&self) -> &FilmInfo;

    /// Goes to a place, from which [`Self::read`] goes on. Returns all that was known there, oldest first: what was said
    /// until then and not superseded.
    ///
    /// # Errors
    /// When the recording cannot be read any more.
    fn seek(&mut self, to: Duration) -> io::Result<Vec<Moment>>;

    /// The next moments, in order; none at the end.
    ///
    /// # Errors
    /// When the recording cannot be read any more.
    fn read(&mut self) -> io::Result<Vec<Moment>>;
}

impl fmt::Debug for dyn Film {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Film").field(self.info()).finish()
    }
}
