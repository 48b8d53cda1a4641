//! The guard against flying a mission that may be a mixture, or that leads out of reach: which messages arm, start a
//! mission or jump in it, and whether they may be sent. Every message of a request or a caller to a vehicle passes here.

use vencejo_flight::checks::{CheckContext, OutOfReach, first_out_of_reach};
use vencejo_flight::plan::{Command, PlanKind};
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Message, MonoTime, StatusText};

use super::Vehicle;
use super::raw;
use super::steps::{Fallback, Step};
use crate::command::{CommandMessage, aux, whole};
use crate::error::VehicleError;
use crate::modes::{FlightMode, ModeFamily};
use crate::telemetry::Severity;
use vencejo_proto::ComponentId;

/// An act that is dangerous with a mixed mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Act {
    Arm,
    FollowMission,
    Jump,
}

impl Act {
    fn name(self) -> &'static str {
        match self {
            Self::Arm => "arming",
            Self::FollowMission => "following the mission",
            Self::Jump => "jumping in the mission",
        }
    }
}

/// `MAV_MODE_FLAG_AUTO_ENABLED`, for modes without a custom mode.
const AUTO_FLAG: u32 = 4;
/// `MAV_MODE_FLAG_CUSTOM_MODE_ENABLED`.
const CUSTOM_FLAG: u32 = 1;

fn mode_follows(family: ModeFamily, base_mode: u32, custom_mode: u32) -> bool {
    if base_mode & CUSTOM_FLAG == 0 {
        return base_mode & AUTO_FLAG != 0;
    }
    match family {
        // AUTO alone, and AUTO_RTL, which flies the mission's landing.
        ModeFamily::ArduCopter => matches!(custom_mode, 3 | 27),
        // Its main mode AUTO without a sub mode is the mission.
        ModeFamily::Px4 if custom_mode == 4 << 16 => true,
        _ => FlightMode { family, custom_mode }.follows_mission(),
    }
}

fn act_of_command(family: ModeFamily, command: Command, params: &[f32]) -> Option<Act> {
    let param = |number: usize| params.get(number - 1).copied().unwrap_or_default();
    match command {
        Command::COMPONENT_ARM_DISARM => (whole(param(1)) == 1).then_some(Act::Arm),
        Command::DO_SET_MODE => {
            let custom_mode = match family {
                ModeFamily::Px4 => whole(param(2)) << 16 | whole(param(3)) << 24,
                _ => whole(param(2)),
            };
            mode_follows(family, whole(param(1)), custom_mode).then_some(Act::FollowMission)
        }
        Command::MISSION_START => Some(Act::FollowMission),
        Command::DO_PAUSE_CONTINUE => (whole(param(1)) == 1).then_some(Act::FollowMission),
        Command::DO_SET_MISSION_CURRENT
        | Command::DO_LAND_START
        | Command::DO_RETURN_PATH_START
        | Command::DO_JUMP_TAG => Some(Act::Jump),
        Command::DO_AUX_FUNCTION if whole(param(2)) > 0 => match whole(param(1)) {
            aux::AUTO => Some(Act::FollowMission),
            aux::MISSION_RESET => Some(Act::Jump),
            aux::ARMDISARM_OLD | aux::ARMDISARM | aux::ARMDISARM_AIRMODE | aux::ARM_EMERGENCY_STOP => Some(Act::Arm),
            _ => None,
        },
        _ => None,
    }
}

fn starts_mission(message: &Message) -> bool {
    let command = match message {
        Message::CommandLong(long) => long.command,
        Message::CommandInt(int) => int.command,
        _ => return false,
    };
    matches!(Command(command), Command::MISSION_START | Command::DO_LAND_START)
}

fn act_of(family: ModeFamily, message: &Message) -> Option<Act> {
    match message {
        Message::CommandLong(long) => act_of_command(family, Command(long.command), &long.params),
        Message::CommandInt(int) => act_of_command(family, Command(int.command), &int.params),
        Message::Dialect(MavMessage::SET_MODE(mode)) => {
            mode_follows(family, u32::from(mode.base_mode.bits()), mode.custom_mode).then_some(Act::FollowMission)
        }
        Message::Dialect(MavMessage::MISSION_SET_CURRENT(_)) => Some(Act::Jump),
        _ => None,
    }
}

impl Vehicle {
    pub(super) fn act_of(&self, message: &Message) -> Option<Act> {
        if !message.target().includes(self.address) {
            return None;
        }
        match self.family() {
            // A disarmed PX4 takes DO_LAND_START for MISSION_START, which arms it too (`navigator_main.cpp`, `Commander.cpp`).
            Some(ModeFamily::Px4) if starts_mission(message) && self.telemetry.is_armed() != Some(true) => {
                Some(Act::FollowMission)
            }
            Some(family) => act_of(family, message),
            // Before its first heartbeat: what it would be to any.
            None => ModeFamily::KNOWN.into_iter().find_map(|family| act_of(family, message)),
        }
    }

    fn act_of_step(&self, step: &Step) -> Option<Act> {
        let of_command = |command: &CommandMessage| self.act_of(&command.to_message());
        match step {
            Step::Command { message, fallback, .. } => of_command(message).or_else(|| match fallback {
                Some(Fallback::Command(command)) => of_command(command),
                Some(Fallback::Message(message, _)) => self.act_of(message),
                None => None,
            }),
            Step::Tell { command, message, .. } => of_command(command).or_else(|| self.act_of(message)),
            Step::Send(message) => self.act_of(message),
            _ => None,
        }
    }

    /// Whether these steps may be taken.
    pub(super) fn guard_steps<'a>(
        &mut self,
        steps: impl IntoIterator<Item = &'a Step>,
        despite: bool,
        now: MonoTime,
    ) -> Result<(), VehicleError> {
        let mut acts = Vec::new();
        for step in steps {
            self.guard_landing_by(step, now)?;
            acts.extend(self.act_of_step(step));
        }
        self.guard(&acts, despite, now)
    }

    /// Checks a raw message of a caller to this vehicle, and notes its effect on the plans on board.
    ///
    /// # Errors
    /// [`VehicleError::PlanUnknown`] for one that arms, starts the mission or jumps in it while that may be a mixture,
    /// and [`VehicleError::OutOfReach`] or [`VehicleError::HomeUnknown`] for one that has it follow a mission out of reach,
    /// or perhaps out of reach, unless it is `despite_mixed_plan`; [`VehicleError::Landing`] for one that would disturb the
    /// landing of an ArduPlane; [`VehicleError::InvalidValue`] for a number that an autopilot cannot take.
    pub fn on_sending(
        &mut self,
        message: &Message,
        despite_mixed_plan: bool,
        now: MonoTime,
    ) -> Result<(), VehicleError> {
        if !message.target().includes(self.address) {
            return Ok(());
        }
        raw::check_message(message, self.is_ardupilot())?;
        self.guard_landing(message, now)?;
        self.guard(self.act_of(message).as_slice(), despite_mixed_plan, now)?;
        self.on_written(self.our, message, now);
        Ok(())
    }

    fn guard(&mut self, acts: &[Act], despite: bool, now: MonoTime) -> Result<(), VehicleError> {
        let Some((act, error)) = self.doubted(acts) else { return Ok(()) };
        if !despite {
            return Err(error);
        }
        let doubt = match error {
            VehicleError::PlanUnknown { state, .. } => format!("the mission on board is {state}"),
            VehicleError::OutOfReach { item, .. } => format!("item {item} of the mission on board is out of reach"),
            _ => "it is not known whether the mission on board is in reach".to_owned(),
        };
        tracing::warn!(vehicle = %self.address, act = act.name(), doubt, "done despite the mission on board");
        self.note(Severity::WARNING, format!("{} by override, although {doubt}", act.name()), now);
        Ok(())
    }

    /// The first act that the mission on board speaks against, and why.
    fn doubted(&self, acts: &[Act]) -> Option<(Act, VehicleError)> {
        let first = *acts.first()?;
        let state = self.plans.get(PlanKind::Mission);
        if state.may_be_mixed() {
            return Some((first, VehicleError::PlanUnknown { kind: PlanKind::Mission, state }));
        }
        let follows = |act: &Act| match act {
            Act::FollowMission => true,
            Act::Arm => self.conduct().follows_mission == Some(true),
            Act::Jump => false,
        };
        let act = *acts.iter().find(|act| follows(act))?;
        Some((act, self.beyond_reach()?))
    }

    /// Why the mission on board, where it is known, must not be followed: it leads out of reach, or that cannot be judged
    /// yet. The checks before an upload may not have known home and position either.
    fn beyond_reach(&self) -> Option<VehicleError> {
        let items = &self.mission()?.items;
        let CheckContext { home, position, on_ground, .. } = self.check_context();
        let home = home.and_then(|home| home.point().ok());
        if home.is_none() && position.is_none() {
            let is_flying = on_ground == Some(false);
            return (!is_flying && items.iter().any(|item| item.point().is_some()))
                .then_some(VehicleError::HomeUnknown);
        }
        let (index, OutOfReach { distance_m, is_swapped }) = first_out_of_reach(items, home, position)?;
        Some(VehicleError::OutOfReach { item: index + 1, distance_m, is_swapped })
    }

    /// Adds a text of ours to those of the vehicle.
    pub(super) fn note(&mut self, severity: Severity, text: String, now: MonoTime) {
        let text = StatusText { severity: severity.0, text, id: 0, chunk_seq: 0 };
        self.on_text(ComponentId::GROUND_STATION, &text, now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vencejo_proto::dialect::{MISSION_SET_CURRENT_DATA, MavModeFlag, SET_MODE_DATA};
    use vencejo_proto::{Address, CommandInt, CommandLong};

    const PLANE: ModeFamily = ModeFamily::ArduPlane;
    const TARGET: Address = Address::new(1, 1);

    fn long(command: u16, params: [f32; 7]) -> Message {
        Message::CommandLong(CommandLong { target: TARGET, command, confirmation: 0, params })
    }

    fn first(command: u16, p1: f32, p2: f32) -> Option<Act> {
        let by_long = act_of(PLANE, &long(command, [p1, p2, 0.0, 0.0, 0.0, 0.0, 0.0]));
        let int = CommandInt {
            target: TARGET,
            frame: 0,
            command,
            current: 0,
            autocontinue: 0,
            params: [p1, p2, 0.0, 0.0],
            x: 0,
            y: 0,
            z: 0.0,
        };
        assert_eq!(act_of(PLANE, &Message::CommandInt(int)), by_long, "{command} by COMMAND_INT");
        by_long
    }

    #[test]
    fn what_arms_follows_the_mission_or_jumps_is_known_by_its_messages() {
        for (command, p1, p2, act) in [
            (400, 1.0, 0.0, Some(Act::Arm)),
            (400, 1.0, 21_196.0, Some(Act::Arm)),
            (400, 0.0, 0.0, None),
            (176, 1.0, 10.0, Some(Act::FollowMission)),
            (176, 81.0, 10.0, Some(Act::FollowMission)),
            (176, 220.0, 0.0, Some(Act::FollowMission)),
            (176, 1.0, 11.0, None),
            (176, 1.0, 0.0, None),
            (300, 0.0, 0.0, Some(Act::FollowMission)),
            (193, 1.0, 0.0, Some(Act::FollowMission)),
            (193, 0.0, 0.0, None),
            (224, 3.0, 0.0, Some(Act::Jump)),
            (189, 0.0, 0.0, Some(Act::Jump)),
            (188, 0.0, 0.0, Some(Act::Jump)),
            (601, 1.0, 0.0, Some(Act::Jump)),
            (218, 16.0, 2.0, Some(Act::FollowMission)),
            (218, 153.0, 2.0, Some(Act::Arm)),
            (218, 153.0, 0.0, None),
            (218, 24.0, 2.0, Some(Act::Jump)),
            (20, 0.0, 0.0, None),
            (191, 0.0, 0.0, None),
        ] {
            assert_eq!(first(command, p1, p2), act, "command {command}, {p1}, {p2}");
        }
        let mode = |base_mode: u8, custom_mode| {
            Message::Dialect(MavMessage::SET_MODE(SET_MODE_DATA {
                custom_mode,
                target_system: 1,
                base_mode: MavModeFlag::from_bits_truncate(base_mode),
            }))
        };
        assert_eq!(act_of(PLANE, &mode(1, 10)), Some(Act::FollowMission));
        assert_eq!(act_of(PLANE, &mode(217, 10)), Some(Act::FollowMission));
        assert_eq!(act_of(PLANE, &mode(217, 12)), None);
        let jump = Message::Dialect(MavMessage::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA::default()));
        assert_eq!(act_of(PLANE, &jump), Some(Act::Jump));
        let mission = |family, main, sub| act_of(family, &long(176, [1.0, main, sub, 0.0, 0.0, 0.0, 0.0]));
        assert_eq!(mission(ModeFamily::ArduCopter, 3.0, 0.0), Some(Act::FollowMission));
        assert_eq!(mission(ModeFamily::ArduCopter, 27.0, 0.0), Some(Act::FollowMission));
        assert_eq!(mission(ModeFamily::ArduCopter, 10.0, 0.0), None);
        assert_eq!(mission(ModeFamily::Px4, 4.0, 4.0), Some(Act::FollowMission));
        assert_eq!(mission(ModeFamily::Px4, 4.0, 0.0), Some(Act::FollowMission));
        assert_eq!(mission(ModeFamily::Px4, 4.0, 5.0), None, "RTL");
    }
}
