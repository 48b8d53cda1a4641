//! The commands of a request, determined without a vehicle: for its danger and its name in reports.

use std::collections::VecDeque;

use vencejo_flight::plan::Command;
use vencejo_proto::{Address, Heartbeat, Message, MonoTime};

use super::steps::{Context, Step};
use crate::command::CommandMessage;
use crate::error::VehicleError;
use crate::kind::FIXED_WING;
use crate::modes::{Action, ModeFamily};
use crate::request::Request;
use crate::telemetry::Telemetry;

/// The commands of a request to an ArduPlane that is disarmed in GUIDED; empty for requests without commands, or with
/// invalid values.
pub(crate) fn commands_of(request: &Request) -> Vec<CommandMessage> {
    let steps = steps_of(request, ModeFamily::ArduPlane, FIXED_WING).unwrap_or_default();
    let commands = steps.into_iter().filter_map(|step| match step {
        Step::Command { message, .. } => Some(message),
        _ => None,
    });
    commands.collect()
}

/// The steps of a request to an ArduPilot of this kind that is disarmed in GUIDED.
fn steps_of(request: &Request, family: ModeFamily, mav_type: u8) -> Result<VecDeque<Step>, VehicleError> {
    let custom_mode = Action::Guided.mode(family).map_or(0, |mode| mode.custom_mode);
    let heartbeat = Heartbeat { mav_type, autopilot: 3, custom_mode, ..Heartbeat::default() };
    let mut telemetry = Telemetry::new();
    telemetry.apply(&Message::Heartbeat(heartbeat), MonoTime::ZERO);
    let context = Context {
        vehicle: Address::new(1, 1),
        telemetry: &telemetry,
        heartbeat_at: MonoTime::ZERO,
        preparation: None,
        first_nav: 0,
        is_landing: false,
        unmarked_landing: None,
        has_landing: None,
        lands: None,
        is_complete: false,
        left_at: None,
        has_command_int: true,
        now: MonoTime::ZERO,
    };
    context.steps(request.clone())
}

/// The error of a request that neither a plane nor a copter takes; `None` if one of them does.
#[cfg(all(test, feature = "describe"))]
pub(crate) fn refusal_of(request: &Request) -> Option<VehicleError> {
    const QUADROTOR: u8 = 2;
    steps_of(request, ModeFamily::ArduPlane, FIXED_WING).err()?;
    steps_of(request, ModeFamily::ArduCopter, QUADROTOR).err()
}

impl Request {
    /// The command that stands for it when its result is unknown: the last that it sends, of a go-to the first, which its
    /// speed follows; else DO_SET_MODE.
    pub fn command(&self) -> Command {
        let sent = commands_of(self);
        let it = if matches!(self, Self::Reposition { .. }) { sent.first() } else { sent.last() };
        it.map_or(Command::DO_SET_MODE, CommandMessage::command)
    }
}
