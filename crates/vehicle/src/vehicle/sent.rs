//! What a request sends, told without a vehicle: its danger and its name in reports are known by it.

use std::collections::VecDeque;

use vencejo_proto::{Address, Heartbeat, Message, MonoTime};

use super::steps::{Context, Step};
use crate::command::{CommandMessage, CommandName, cmd};
use crate::error::VehicleError;
use crate::modes::{Action, ModeFamily};
use crate::request::Request;
use crate::telemetry::Telemetry;

/// `MAV_TYPE_FIXED_WING`.
const FIXED_WING: u8 = 1;

/// The commands that an ArduPlane gets for a request that stands disarmed in GUIDED; none for what is not done by commands, or holds values
/// that may not be sent.
pub(crate) fn commands_of(request: &Request) -> Vec<CommandMessage> {
    let steps = steps_of(request, ModeFamily::ArduPlane, FIXED_WING).unwrap_or_default();
    let commands = steps.into_iter().filter_map(|step| match step {
        Step::Command { message, .. } => Some(message),
        _ => None,
    });
    commands.collect()
}

/// What is done for a request to an ArduPilot of this kind that stands disarmed in GUIDED.
fn steps_of(request: &Request, family: ModeFamily, mav_type: u8) -> Result<VecDeque<Step>, VehicleError> {
    let custom_mode = Action::Guided.mode(family).map_or(0, |mode| mode.custom_mode);
    let heartbeat = Heartbeat { mav_type, autopilot: 3, custom_mode, ..Heartbeat::default() };
    let mut telemetry = Telemetry::new();
    telemetry.apply(&Message::Heartbeat(heartbeat), MonoTime::ZERO);
    let context = Context {
        vehicle: Address::new(1, 1),
        telemetry: &telemetry,
        family: Some(family),
        heartbeat_at: MonoTime::ZERO,
        preparation: None,
        first_nav: 0,
        is_landing: false,
        has_command_int: true,
        now: MonoTime::ZERO,
    };
    context.steps(request.clone())
}

/// Why neither a plane nor a copter is sent a request; `None` where one of them is.
#[cfg(all(test, feature = "describe"))]
pub(crate) fn refusal_of(request: &Request) -> Option<VehicleError> {
    const QUADROTOR: u8 = 2;
    steps_of(request, ModeFamily::ArduPlane, FIXED_WING).err()?;
    steps_of(request, ModeFamily::ArduCopter, QUADROTOR).err()
}

impl Request {
    /// The command that stands for it where nobody knows what became of it: the last that it sends, else one that changes the mode.
    pub fn command(&self) -> CommandName {
        CommandName(commands_of(self).last().map_or(cmd::DO_SET_MODE, CommandMessage::command))
    }
}
