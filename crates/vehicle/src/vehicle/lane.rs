//! The running transfer: any machine of [`crate::transfer`] behind one interface.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::board::Incoming;
use super::identity::state::Doubted;
use crate::plan_state::PlanState;
use crate::request::RequestId;
use crate::transfer::{
    Others, Param, ParamList, ParamRead, ParamSet, PlanClear, PlanDownload, PlanUpload, Transfer, TransferError,
    TransferOutput,
};

/// The state of a plan before a transfer of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlanBefore {
    pub kind: PlanKind,
    pub state: PlanState,
    /// The doubt about the mission.
    pub doubt: Option<Doubted>,
}

/// Our last writing of a plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Written {
    /// When it ended.
    pub at: MonoTime,
    /// The id that the vehicle gave the plan.
    pub plan_id: Option<u32>,
    /// Whether it failed: what was sent may become the plan later, when the vehicle closes the file.
    pub is_unfinished: bool,
}

/// A transfer and the request that it serves.
#[derive(Debug)]
pub(super) struct Lane {
    pub id: RequestId,
    pub machine: Machine,
    /// The plan it is about, and its state before.
    pub plan_before: Option<PlanBefore>,
    /// Another station changed the plan while it was read.
    pub is_disturbed: bool,
    /// Another station wrote the plan after the vehicle had all of ours.
    pub is_followed: bool,
    /// The mission that it had all of then, of another station.
    pub theirs: Option<Incoming>,
    /// Its result, while the identity of the vehicle is not confirmed.
    pub ended: Option<Result<Yield, TransferError>>,
    pub began: MonoTime,
    /// Whether the vehicle has answered anything of it.
    pub is_answered: bool,
}

impl Lane {
    /// Its result, once; that of a downloaded mission stays here while `is_held`.
    pub fn end(&mut self, is_held: bool) -> Option<Result<Yield, TransferError>> {
        self.ended = self.ended.take().or_else(|| self.machine.result());
        let is_judged = matches!(self.machine, Machine::Download(_)) && self.is_about(PlanKind::Mission);
        self.ended.take_if(|ended| !(is_held && is_judged && ended.is_ok()))
    }

    /// Cancels it.
    pub fn cancel(&mut self, now: MonoTime) {
        self.machine.cancel(now);
        if let Some(ended) = &mut self.ended {
            *ended = Err(TransferError::Cancelled);
        }
    }

    /// Whether it moves a plan of this kind.
    pub fn is_about(&self, kind: PlanKind) -> bool {
        self.plan_before.as_ref().is_some_and(|before| before.kind == kind)
    }
}

#[derive(Debug)]
pub(super) enum Machine {
    Upload(Box<PlanUpload>),
    Download(Box<PlanDownload>),
    Clear(Box<PlanClear>, PlanKind),
    List(Box<ParamList>),
    Read(Box<ParamRead>),
    Set(Box<ParamSet>),
}

/// The result of a transfer.
#[derive(Debug)]
pub(super) enum Yield {
    /// With the rounding error of its positions, if any.
    Plan {
        kind: PlanKind,
        wire: Vec<MissionItemInt>,
        position_error_m: Option<f64>,
    },
    Parameters(Vec<Param>),
    Parameter(Param),
}

macro_rules! each {
    ($self:expr, $machine:ident => $call:expr) => {
        match $self {
            Machine::Upload($machine) => $call,
            Machine::Download($machine) => $call,
            Machine::Clear($machine, _) => $call,
            Machine::List($machine) => $call,
            Machine::Read($machine) => $call,
            Machine::Set($machine) => $call,
        }
    };
}

impl Machine {
    /// Its name for people.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Upload(_) => "plan upload",
            Self::Download(_) => "plan download",
            Self::Clear(..) => "plan removal",
            Self::List(_) => "parameter list",
            Self::Read(_) => "parameter read",
            Self::Set(_) => "parameter write",
        }
    }

    /// Whether it changes the plan on board, so that its failure leaves that unknown.
    pub fn writes_plan(&self) -> bool {
        matches!(self, Self::Upload(_) | Self::Clear(..))
    }

    /// Another station does something to the plan that is written.
    pub fn on_others(&mut self, others: Others, now: MonoTime) {
        match self {
            Self::Upload(machine) => machine.on_others(others, now),
            Self::Clear(machine, _) => machine.on_others(others, now),
            Self::Download(_) | Self::List(_) | Self::Read(_) | Self::Set(_) => {}
        }
    }

    /// How many items the vehicle has when it has what was written, where it has said so and that is only looked at
    /// yet, and how it calls them, where it says so. `home` is what it keeps of a mission that was removed.
    pub fn written(&self, home: u16) -> Option<(usize, Option<u32>)> {
        match self {
            Self::Upload(machine) => machine.is_sent().then(|| (machine.count(), machine.plan_id())),
            Self::Clear(machine, _) => machine.is_cleared().then_some((home.into(), None)),
            Self::Download(_) | Self::List(_) | Self::Read(_) | Self::Set(_) => None,
        }
    }

    /// The id that the vehicle gave the plan that was written, where it told one.
    pub fn plan_id(&self) -> Option<u32> {
        match self {
            Self::Upload(machine) => machine.plan_id(),
            _ => None,
        }
    }

    pub fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        each!(self, machine => machine.on_message(from, message, now));
    }

    pub fn on_time(&mut self, now: MonoTime) {
        each!(self, machine => machine.on_time(now));
    }

    pub fn deadline(&self) -> Option<MonoTime> {
        each!(self, machine => machine.deadline())
    }

    pub fn poll_output(&mut self) -> Option<TransferOutput> {
        each!(self, machine => machine.poll_output())
    }

    pub fn cancel(&mut self, now: MonoTime) {
        each!(self, machine => machine.cancel(now));
    }

    pub fn result(&mut self) -> Option<Result<Yield, TransferError>> {
        Some(match self {
            Self::Upload(machine) => machine.result()?.map(|plan| Yield::Plan {
                kind: plan.kind,
                wire: plan.items,
                position_error_m: plan.position_error_m,
            }),
            Self::Download(machine) => {
                machine.result()?.map(|plan| Yield::Plan { kind: plan.kind, wire: plan.items, position_error_m: None })
            }
            Self::Clear(machine, kind) => {
                machine.result()?.map(|()| Yield::Plan { kind: *kind, wire: Vec::new(), position_error_m: None })
            }
            Self::List(machine) => machine.result()?.map(Yield::Parameters),
            Self::Read(machine) => machine.result()?.map(Yield::Parameter),
            Self::Set(machine) => machine.result()?.map(Yield::Parameter),
        })
    }
}
