//! One step of a request: a command with its proof and fallback, a message, a transfer.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Message, MissionItemInt};

use crate::command::{CommandMessage, Unanswered, WhenBusy};
use crate::modes::FlightMode;
use crate::telemetry::Severity;
use crate::transfer::ParamName;

/// The effect that proves a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Effect {
    /// The acknowledgement alone.
    Acknowledged,
    /// HEARTBEAT shows armed, or not.
    Armed(bool),
    /// HEARTBEAT shows the mode.
    Mode(FlightMode),
    /// HEARTBEAT shows the mode, and MISSION_CURRENT, where it comes, a mission that runs in it, or that waits for home
    /// unless it `has_begun`. An ArduPlane without a mission shows AUTO for a moment, and returns.
    MissionMode { mode: FlightMode, has_begun: bool },
    /// The vehicle leaves the ground. An acknowledgement is enough; this is checked only without one.
    Airborne,
    /// The current mission item has changed from this one. As above.
    JumpedFrom(Option<u16>),
    /// MISSION_CURRENT shows the item `to`; not while it shows the item `from`. As above. Any other item may have come
    /// without the jump, or after it.
    JumpedTo { from: u16, to: u16 },
    /// MISSION_CURRENT shows the item.
    Current(u16),
    /// MISSION_CURRENT shows the item or a later one.
    NotBefore(u16),
    /// MISSION_CURRENT shows this item, the first navigation item, or an earlier one.
    AtBeginning(u16),
    /// The message arrives.
    Received(u32),
    /// No text says that the target is outside of the fence. A PX4 acknowledges the change of mode, then looks at the
    /// target.
    Unobjected,
    /// The vehicle restarts. An acknowledgement is enough.
    Restarted,
}

impl Effect {
    /// The mode that it shows.
    pub fn mode(self) -> Option<FlightMode> {
        match self {
            Self::Mode(mode) | Self::MissionMode { mode, .. } => Some(mode),
            _ => None,
        }
    }
}

/// What to do when the vehicle does not support a command.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a few live for the length of a request")]
pub(crate) enum Fallback {
    /// Send another command.
    Command(CommandMessage),
    /// Send a message that is not acknowledged, and wait for the effect.
    Message(Message, Effect),
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a few live for the length of a request")]
pub(crate) enum Step {
    Command {
        message: CommandMessage,
        unanswered: Unanswered,
        when_busy: WhenBusy,
        effect: Effect,
        fallback: Option<Fallback>,
    },
    /// A message without COMMAND_ACK in place of `command`, for old firmware.
    Tell {
        command: CommandMessage,
        message: Message,
        effect: Effect,
    },
    /// A message without an answer: done when it is sent.
    Send(Message),
    /// Sets the mission to this item where it shows an earlier one.
    GoOnFrom(u16),
    /// A note among the vehicle's texts.
    Note(Severity, String),
    Upload(PlanKind, Vec<MissionItemInt>),
    Download(PlanKind),
    Clear(PlanKind),
    ParamList,
    ParamRead(ParamName),
    ParamSet(ParamName, f64),
}

impl Step {
    pub(super) fn command(message: CommandMessage) -> Self {
        Self::Command {
            unanswered: Unanswered::for_command(message.command()),
            message,
            when_busy: WhenBusy::Refuse,
            effect: Effect::Acknowledged,
            fallback: None,
        }
    }

    /// Proved by an effect; repeated only after the vehicle shows that the effect is missing.
    pub(crate) fn proved_by(self, proof: Effect) -> Self {
        match self {
            Self::Command { message, when_busy, fallback, .. } => {
                Self::Command { message, unanswered: Unanswered::Ask, when_busy, effect: proof, fallback }
            }
            other => other,
        }
    }

    /// Refused by a text that follows the acknowledgement; repeated only while no pilot has changed the mode.
    pub(super) fn unless_objected(self) -> Self {
        self.proved_by(Effect::Unobjected)
    }

    /// Repeated until it is answered, whatever the vehicle shows.
    pub(super) fn repeated(self) -> Self {
        match self {
            Self::Command { message, when_busy, effect, fallback, .. } => {
                Self::Command { message, unanswered: Unanswered::Repeat, when_busy, effect, fallback }
            }
            other => other,
        }
    }

    pub(super) fn or(self, other: Fallback) -> Self {
        match self {
            Self::Command { message, unanswered, when_busy, effect, .. } => {
                Self::Command { message, unanswered, when_busy, effect, fallback: Some(other) }
            }
            step => step,
        }
    }

    pub(super) fn waiting(self, effect: Effect) -> Self {
        match self {
            Self::Command { message, unanswered, fallback, .. } => {
                Self::Command { message, unanswered, when_busy: WhenBusy::Wait, effect, fallback }
            }
            other => other,
        }
    }
}
