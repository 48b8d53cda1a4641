//! A running request: its steps, and the state of the present one.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_flight::plan::Command;
use vencejo_proto::{Message, MonoTime};

use super::lane::PlanBefore;
use super::steps::{Effect, Fallback, Step};
use crate::command::{CommandId, CommandMessage, CommandResult};
use crate::modes::FlightMode;
use crate::request::{Reply, RequestId};

/// How long an effect may take to be shown after the command was accepted: several heartbeats.
pub(super) const EFFECT_WITHIN: Duration = Duration::from_secs(5);
/// The same without any report for or against it: with every second heartbeat lost, one in thirty commands has no
/// report within five seconds.
pub(super) const WORD_WITHIN: Duration = Duration::from_secs(10);

/// A running request.
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
    /// The next step can begin.
    Ready,
    /// A command is in flight.
    Commanding { command: Commanding, id: CommandId, asked: bool },
    /// It was refused; the vehicle may send texts about it.
    Refused { command: Commanding, result: CommandResult, until: MonoTime },
    /// It was accepted; its effect has to be shown. Once overdue, the next report decides.
    Awaiting { command: Commanding, until: MonoTime, is_overdue: bool },
    /// A message without acknowledgement was sent; its effect has to be shown.
    Telling(Box<Telling>),
    /// A transfer waits until its beginning is recorded.
    Recording { step: Step, before: PlanBefore, ticket: u64, until: MonoTime },
    /// A transfer runs in a lane.
    Transferring,
    /// A mission was uploaded; the vehicle's own checks of it have to be told, from `from` on.
    Judging { reply: Box<Reply>, began: MonoTime, from: MonoTime, until: MonoTime },
    /// A parameter waits for the lane.
    WaitingForLane(Step),
}

/// A command and its proof.
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
    pub fn name(&self) -> Command {
        self.message.command()
    }
}

/// Whether an effect is shown.
#[derive(Debug, PartialEq)]
pub(super) enum Seen {
    /// The vehicle shows it.
    Shown,
    /// The vehicle has since reported otherwise.
    NotShown,
    /// Another station or the pilot has intervened.
    Overtaken(String),
    /// No report since.
    NotYet,
}

/// A message without COMMAND_ACK, awaiting its effect. Once overdue it is not sent again, and the next report decides.
#[derive(Debug)]
pub(super) struct Telling {
    /// The command that it stands for, and its effect.
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

    /// Whether it waits for its answer rather than its effect.
    pub(super) fn waits_for_ack(&self) -> bool {
        self.wants_ack && !self.has_ack
    }
}
