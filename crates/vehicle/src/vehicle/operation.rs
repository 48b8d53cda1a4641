//! A request under way: its steps, and the state of the one that is being done.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::{Message, MonoTime};

use super::lane::PlanBefore;
use super::steps::{Effect, Fallback, Step};
use crate::command::{CommandId, CommandMessage, CommandName, CommandResult};
use crate::modes::FlightMode;
use crate::request::RequestId;

/// How long an effect may take to show after the command was accepted: several heartbeats.
pub(super) const EFFECT_WITHIN: Duration = Duration::from_secs(5);
/// And how long when the vehicle has said nothing since that speaks for it or against it: where every second heartbeat is lost, one in thirty
/// commands has no word within five seconds.
pub(super) const WORD_WITHIN: Duration = Duration::from_secs(10);

/// A request under way.
#[derive(Debug)]
pub(super) struct Op {
    pub id: RequestId,
    pub steps: VecDeque<Step>,
    pub state: State,
    /// `result_param2` of the last command's acknowledgement, for the requests that return it.
    pub acknowledged: Option<i32>,
    pub wants_acknowledgement: bool,
}

impl Op {
    pub fn new(id: RequestId, steps: VecDeque<Step>) -> Self {
        Self { id, steps, state: State::Ready, acknowledged: None, wants_acknowledgement: false }
    }
}

#[derive(Debug)]
pub(super) enum State {
    /// The next step is to begin.
    Ready,
    /// A command is under way.
    Commanding { command: Commanding, id: CommandId, asked: bool },
    /// It was refused; the vehicle may write why.
    Refused { command: Commanding, result: CommandResult, until: MonoTime },
    /// It was accepted; its effect has to show. Once it is overdue the next word about it decides.
    Awaiting { command: Commanding, until: MonoTime, is_overdue: bool },
    /// A message without acknowledgement was sent; its effect has to show.
    Telling(Box<Telling>),
    /// A transfer waits until it is written down that it begins.
    Recording { step: Step, before: PlanBefore, ticket: u64, until: MonoTime },
    /// A transfer runs in a lane.
    Transferring,
    /// A parameter waits for the lane.
    WaitingForLane(Step),
}

/// A command and what proves it.
#[derive(Debug, Clone)]
pub(super) struct Commanding {
    pub message: CommandMessage,
    pub effect: Effect,
    pub fallback: Option<Fallback>,
    pub first_sent: MonoTime,
    pub last_sent: MonoTime,
    pub mode_before: Option<FlightMode>,
}

impl Commanding {
    pub fn name(&self) -> CommandName {
        CommandName(self.message.command())
    }
}

/// How an effect looks from here.
#[derive(Debug, PartialEq)]
pub(super) enum Seen {
    /// It is there.
    Shown,
    /// The vehicle has said since that it is not.
    NotShown,
    /// Somebody else did something else.
    Overtaken(String),
    /// Nothing has been said since.
    NotYet,
}

/// A message of which the effect is waited for. Once it is overdue it is not sent again, and the next word about it decides.
#[derive(Debug)]
pub(super) struct Telling {
    /// What it stands for, and its effect.
    pub command: Commanding,
    pub message: Message,
    /// Whether MISSION_ACK answers it.
    pub wants_ack: bool,
    pub has_ack: bool,
    pub attempts: u32,
    pub retry_at: MonoTime,
    pub until: MonoTime,
    pub is_overdue: bool,
}

impl Telling {
    pub(super) fn deadline(&self) -> MonoTime {
        if self.is_overdue { self.until } else { self.retry_at.min(self.until) }
    }

    /// Whether it waits for its answer, and not for its effect.
    pub(super) fn waits_for_ack(&self) -> bool {
        self.wants_ack && !self.has_ack
    }
}
