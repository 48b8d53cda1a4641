//! What a request sends, told without a vehicle: its danger and its name in reports are known by it.

use vencejo_proto::{Address, Heartbeat, Message, MonoTime};

use super::steps::{Context, Step};
use crate::command::{CommandMessage, CommandName, cmd};
use crate::modes::{Action, ModeFamily};
use crate::request::Request;
use crate::telemetry::Telemetry;

/// The commands that an ArduPlane gets for a request that stands disarmed in GUIDED; none for what is not done by commands, or holds values
/// that may not be sent.
pub(crate) fn commands_of(request: &Request) -> Vec<CommandMessage> {
    let custom_mode = Action::Guided.mode(ModeFamily::ArduPlane).map_or(0, |mode| mode.custom_mode);
    let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, custom_mode, ..Heartbeat::default() };
    let mut telemetry = Telemetry::new();
    telemetry.apply(&Message::Heartbeat(heartbeat), MonoTime::ZERO);
    let context = Context {
        vehicle: Address::new(1, 1),
        telemetry: &telemetry,
        preparation: None,
        first_nav: 0,
        has_command_int: true,
        now: MonoTime::ZERO,
    };
    let steps = context.steps(request.clone()).unwrap_or_default();
    let commands = steps.into_iter().filter_map(|step| match step {
        Step::Command { message, .. } => Some(message),
        _ => None,
    });
    commands.collect()
}

impl Request {
    /// The command that stands for it where nobody knows what became of it: the last that it sends, else one that changes the mode.
    #[must_use]
    pub fn command(&self) -> CommandName {
        CommandName(commands_of(self).last().map_or(cmd::DO_SET_MODE, CommandMessage::command))
    }
}
