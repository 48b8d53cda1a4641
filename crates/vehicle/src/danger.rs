//! Which acts can end a flight or destroy data on board: the one classification that every front end uses, however an
//! act is expressed (a request, a raw command, a raw message, a parameter).

use std::fmt;

use vencejo_flight::plan::{Command, PlanKind};
use vencejo_proto::{FieldValue, Message, MonoTime, SystemId};

use crate::command::{CommandMessage, aux, whole};
use crate::request::Request;
use crate::telemetry::{LOST_AFTER, Telemetry};
use crate::vehicle::commands_of;

/// Ground speed below which a fixed wing that does not report whether it flies counts as standing…
const STANDS_BELOW_M_S: f64 = 3.0;
/// …unless it has this airspeed: against a strong wind it flies without moving over the ground.
const MAY_FLY_FROM_M_S: f64 = 6.0;
/// `MAV_TYPE_FIXED_WING`: for hovering vehicles ground speed is no indication.
const FIXED_WING: u8 = 1;

/// A dangerous act, which a person has to confirm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Danger {
    /// Arms in spite of the vehicle's own checks.
    ForceArm,
    /// Stops the motors whatever the vehicle does: by force, by the emergency stop, by the safety switch, by the
    /// engine's control.
    ForceDisarm,
    /// Disarms a vehicle that flies, or that is not known to stand.
    DisarmInFlight,
    /// Ends the flight where it is: flight termination, parachute.
    Terminate,
    /// Removes one kind of plan.
    Clear(PlanKind),
    /// Removes mission, fence and rally points.
    ClearAll,
    /// Restarts or switches off the autopilot.
    Reboot,
    /// Switches the fence, or its action, off.
    FenceOff,
    /// Resets parameters of the vehicle to their defaults, or erases its storage.
    Erase,
    /// Writes to the vehicle's files or its bootloader directly.
    WriteFiles,
    /// Moves home of a vehicle that flies, or that is not known to stand: to there it returns by itself, and from there
    /// heights are counted.
    MoveHome,
}

impl Danger {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::ForceArm,
        Self::ForceDisarm,
        Self::DisarmInFlight,
        Self::Terminate,
        Self::Clear(PlanKind::Mission),
        Self::Clear(PlanKind::Fence),
        Self::Clear(PlanKind::Rally),
        Self::ClearAll,
        Self::Reboot,
        Self::FenceOff,
        Self::Erase,
        Self::WriteFiles,
        Self::MoveHome,
    ];

    /// Its stable name, by which a program confirms it.
    pub const fn code(self) -> &'static str {
        match self {
            Self::ForceArm => "force-arm",
            Self::ForceDisarm => "force-disarm",
            Self::DisarmInFlight => "disarm-in-flight",
            Self::Terminate => "terminate",
            Self::Clear(PlanKind::Mission) => "clear-mission",
            Self::Clear(PlanKind::Fence) => "clear-fence",
            Self::Clear(PlanKind::Rally) => "clear-rally",
            Self::ClearAll => "clear-all",
            Self::Reboot => "reboot",
            Self::FenceOff => "fence-off",
            Self::Erase => "erase",
            Self::WriteFiles => "write-files",
            Self::MoveHome => "move-home",
        }
    }

    /// What it does, as a phrase.
    pub const fn words(self) -> &'static str {
        match self {
            Self::ForceArm => "arms in spite of the vehicle's own checks",
            Self::ForceDisarm => "stops the motors, in the air too",
            Self::DisarmInFlight => "disarms a vehicle that flies or is not known to stand",
            Self::Terminate => "ends the flight where the vehicle is",
            Self::Clear(PlanKind::Mission) => "removes the mission on board",
            Self::Clear(PlanKind::Fence) => "removes the fence on board",
            Self::Clear(PlanKind::Rally) => "removes the rally points on board",
            Self::ClearAll => "removes mission, fence and rally points on board",
            Self::Reboot => "restarts or switches off the autopilot",
            Self::FenceOff => "switches the fence off",
            Self::Erase => "resets the vehicle's parameters or erases what it has stored",
            Self::WriteFiles => "writes to the vehicle's files",
            Self::MoveHome => "moves home in flight: the vehicle returns there, and counts heights from there",
        }
    }

    /// The one with this name.
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|danger| danger.code() == code)
    }

    /// The danger of a request to a vehicle with this telemetry.
    pub fn of_request(request: &Request, telemetry: &Telemetry, now: MonoTime) -> Option<Self> {
        match request {
            Request::RawCommandLong(command) => of_command(Command(command.command), &command.params, telemetry, now),
            Request::RawCommandInt(command) => of_command(Command(command.command), &command.params, telemetry, now),
            Request::ClearPlan { kind } => Some(Self::Clear(*kind)),
            // An empty list clears.
            Request::UploadPlan { kind, items, .. } => items.is_empty().then_some(Self::Clear(*kind)),
            Request::ParamSet { name, value } => of_param(name, *value),
            Request::DespiteMixedPlan(request) => Self::of_request(request, telemetry, now),
            // By the commands that it sends.
            request => commands_of(request).iter().find_map(|command| match command {
                CommandMessage::Long(command) => of_command(Command(command.command), &command.params, telemetry, now),
                CommandMessage::Int(command) => of_command(Command(command.command), &command.params, telemetry, now),
            }),
        }
    }

    /// The danger of a raw message sent through this vehicle, which has this telemetry.
    pub fn of_message(message: &Message, vehicle: SystemId, telemetry: &Telemetry, now: MonoTime) -> Option<Self> {
        // To others, or to all: the telemetry of this one does not apply to them.
        let others = Telemetry::default();
        let telemetry = if message.target().system == Some(vehicle) { telemetry } else { &others };
        match message {
            Message::CommandLong(command) => of_command(Command(command.command), &command.params, telemetry, now),
            Message::CommandInt(command) => of_command(Command(command.command), &command.params, telemetry, now),
            // So old ArduPlanes take it.
            Message::Dialect(_) if message.name() == "SET_HOME_POSITION" => {
                may_fly(telemetry, now).then_some(Danger::MoveHome)
            }
            Message::Dialect(_) => of_dialect(message),
            _ => None,
        }
    }
}

impl fmt::Display for Danger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

/// Whether a vehicle flies, or is not known to stand.
fn may_fly(telemetry: &Telemetry, now: MonoTime) -> bool {
    let is_fresh = |at: MonoTime| now.since(at) <= LOST_AFTER;
    if telemetry.heartbeat.is_some_and(|heartbeat| is_fresh(heartbeat.at) && !heartbeat.value.is_armed) {
        return false;
    }
    if let (Some(is_on_ground), Some(extended)) = (telemetry.is_on_ground(), telemetry.extended)
        && is_fresh(extended.at)
    {
        return !is_on_ground;
    }
    let is_fixed_wing = telemetry.heartbeat.is_some_and(|heartbeat| heartbeat.value.mav_type == FIXED_WING);
    let stands = telemetry.hud.is_some_and(|hud| {
        is_fresh(hud.at)
            && hud.value.groundspeed_m_s.is_some_and(|speed| speed < STANDS_BELOW_M_S)
            && hud.value.airspeed_m_s.is_none_or(|speed| speed < MAY_FLY_FROM_M_S)
    });
    !(is_fixed_wing && stands)
}

/// The danger of a command. A value left to the vehicle (NaN) may be any.
fn of_command(command: Command, params: &[f32], telemetry: &Telemetry, now: MonoTime) -> Option<Danger> {
    let param = |number: usize| params.get(number - 1).copied().unwrap_or(0.0);
    match command {
        Command::COMPONENT_ARM_DISARM => {
            // Each autopilot has its own magic numbers here; only 0 keeps its checks.
            let is_forced = param(2) != 0.0;
            match param(1) {
                0.0 if is_forced => Some(Danger::ForceDisarm),
                0.0 => may_fly(telemetry, now).then_some(Danger::DisarmInFlight),
                1.0 => is_forced.then_some(Danger::ForceArm),
                _ => Some(Danger::ForceArm),
            }
        }
        Command::DO_FLIGHTTERMINATION | Command::DO_PARACHUTE => Some(Danger::Terminate),
        Command::DO_SET_HOME => may_fly(telemetry, now).then_some(Danger::MoveHome),
        Command::DO_FENCE_ENABLE => (param(1) != 1.0).then_some(Danger::FenceOff),
        Command::DO_SET_MODE => of_mode(whole(param(1)), whole(param(2))),
        Command::DO_SET_SAFETY_SWITCH_STATE => (param(1) != 1.0).then_some(Danger::ForceDisarm),
        Command::DO_ENGINE_CONTROL => (param(1) != 1.0).then_some(Danger::ForceDisarm),
        Command::DO_AUX_FUNCTION => of_aux_function(whole(param(1)), whole(param(2)), telemetry, now),
        Command::PREFLIGHT_REBOOT_SHUTDOWN | Command::DEBUG_TRAP => Some(Danger::Reboot),
        Command::STORAGE_FORMAT => Some(Danger::Erase),
        Command::FLASH_BOOTLOADER => Some(Danger::WriteFiles),
        // Only writing (1) the present values is harmless; reading back (0) drops unsaved ones.
        Command::PREFLIGHT_STORAGE => {
            ([param(1), param(2)].iter().any(|value| !matches!(value, 0.0 | 1.0))).then_some(Danger::Erase)
        }
        _ => None,
    }
}

/// `MAV_MODE_FLAG_DECODE_POSITION_SAFETY`: for ArduPilot not a mode but its safety switch, where only 0 enables the
/// outputs.
const SAFETY_FLAG: u32 = 128;

/// The danger of a mode.
fn of_mode(base_mode: u32, custom_mode: u32) -> Option<Danger> {
    (base_mode == SAFETY_FLAG && custom_mode != 0).then_some(Danger::ForceDisarm)
}

/// Positions of the switch of an auxiliary function; 1 is in the middle.
const LOW: u32 = 0;
const HIGH: u32 = 2;

/// The danger of an auxiliary function in a position of its switch.
fn of_aux_function(function: u32, position: u32, telemetry: &Telemetry, now: MonoTime) -> Option<Danger> {
    match (function, position) {
        (aux::FENCE, position) => (position != HIGH).then_some(Danger::FenceOff),
        (aux::PARACHUTE_RELEASE | aux::PARACHUTE_3POS, HIGH) => Some(Danger::Terminate),
        (aux::MOTOR_ESTOP, HIGH) | (aux::ARM_EMERGENCY_STOP | aux::ICE_START_STOP, LOW) => Some(Danger::ForceDisarm),
        // In the air too: ArduPlane checks whether it flies only for COMPONENT_ARM_DISARM.
        (aux::DISARM, HIGH) | (aux::ARMDISARM_OLD | aux::ARMDISARM | aux::ARMDISARM_AIRMODE, LOW) => {
            may_fly(telemetry, now).then_some(Danger::DisarmInFlight)
        }
        (aux::CLEAR_WP, HIGH) => Some(Danger::Clear(PlanKind::Mission)),
        _ => None,
    }
}

/// The danger of a parameter's value.
fn of_param(name: &str, value: f64) -> Option<Danger> {
    // Compared as the vehicle may read it, which ignores everything after a zero byte.
    let name = name.split('\0').next().unwrap_or_default().trim().to_ascii_uppercase();
    match name.as_str() {
        // ArduPilot; PX4.
        "FENCE_ENABLE" | "FENCE_ACTION" | "FENCE_TYPE" | "GF_ACTION" => {
            (value.trunc() == 0.0 || !value.is_finite()).then_some(Danger::FenceOff)
        }
        "AFS_TERMINATE" => (value != 0.0).then_some(Danger::Terminate),
        // Numbers of stored items: lowering them removes items.
        "MIS_TOTAL" => Some(Danger::Clear(PlanKind::Mission)),
        "FENCE_TOTAL" => Some(Danger::Clear(PlanKind::Fence)),
        "RALLY_TOTAL" => Some(Danger::Clear(PlanKind::Rally)),
        "FORMAT_VERSION" | "SYSID_SW_MREV" | "SYS_AUTOCONFIG" => Some(Danger::Erase),
        _ => None,
    }
}

/// MAVFTP's requests that change nothing: none, terminate and reset sessions, list, open to read, read, checksum, burst
/// read.
const FTP_READS: [u8; 8] = [0, 1, 2, 3, 4, 5, 14, 15];

/// The danger of one of the dialect's messages.
fn of_dialect(message: &Message) -> Option<Danger> {
    let is_of_interest = matches!(
        message.name(),
        "MISSION_CLEAR_ALL"
            | "MISSION_COUNT"
            | "MISSION_WRITE_PARTIAL_LIST"
            | "PARAM_SET"
            | "PARAM_EXT_SET"
            | "FILE_TRANSFER_PROTOCOL"
            | "SET_MODE"
            | "LOG_ERASE"
    );
    if !is_of_interest {
        return None;
    }
    let fields = message.fields();
    let field = |name: &str| fields.iter().find(|(key, _)| *key == name).map(|(_, value)| value);
    let number = |name: &str| match field(name) {
        Some(FieldValue::Unsigned(value)) => Some(*value as f64),
        Some(FieldValue::Signed(value)) => Some(*value as f64),
        Some(FieldValue::Float(value)) => Some(*value),
        _ => None,
    };
    let text = |name: &str| match field(name) {
        Some(FieldValue::Text(text)) => text.as_str(),
        _ => "",
    };
    match message.name() {
        // A list that is announced by hand replaces what is there, whatever its length.
        "MISSION_CLEAR_ALL" | "MISSION_COUNT" | "MISSION_WRITE_PARTIAL_LIST" => Some(match number("mission_type") {
            Some(0.0) => Danger::Clear(PlanKind::Mission),
            Some(1.0) => Danger::Clear(PlanKind::Fence),
            Some(2.0) => Danger::Clear(PlanKind::Rally),
            _ => Danger::ClearAll,
        }),
        "SET_MODE" => {
            let number = |name: &str| number(name).map_or(0, |value| value as u32);
            of_mode(number("base_mode"), number("custom_mode"))
        }
        "LOG_ERASE" => Some(Danger::Erase),
        "PARAM_SET" => {
            let value = number("param_value").unwrap_or(f64::NAN);
            // PX4 and some ArduPilots send whole numbers as the bits of a float: both readings count.
            let bits = f64::from((value as f32).to_bits() as i32);
            of_param(text("param_id"), value).or_else(|| of_param(text("param_id"), bits))
        }
        // Its value has another encoding; its name is enough.
        "PARAM_EXT_SET" => of_param(text("param_id"), 0.0).or_else(|| of_param(text("param_id"), 1.0)),
        "FILE_TRANSFER_PROTOCOL" => {
            // The fourth byte of its payload is the request (mavlink.io, "File Transfer Protocol").
            let opcode = match field("payload") {
                Some(FieldValue::List(bytes)) => match bytes.get(3) {
                    Some(FieldValue::Unsigned(opcode)) => u8::try_from(*opcode).ok(),
                    _ => None,
                },
                _ => None,
            };
            (!opcode.is_some_and(|opcode| FTP_READS.contains(&opcode))).then_some(Danger::WriteFiles)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use vencejo_flight::plan::MissionItem;
    use vencejo_proto::dialect::{EXTENDED_SYS_STATE_DATA, MavLandedState, MavMessage, VFR_HUD_DATA};
    use vencejo_proto::{Address, CommandInt, CommandLong, Heartbeat, MavVersion, encode_fields};

    use super::*;

    const NOW: MonoTime = MonoTime::ZERO;
    const ONE: SystemId = SystemId(1);

    /// What an armed plane says that is on the ground, in the air, or does not tell.
    fn armed(landed: MavLandedState) -> Telemetry {
        let mut telemetry = Telemetry::new();
        let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, base_mode: 0x80, ..Heartbeat::default() };
        telemetry.apply(&Message::Heartbeat(heartbeat), NOW);
        let extended = EXTENDED_SYS_STATE_DATA { landed_state: landed, ..Default::default() };
        telemetry.apply(&Message::Dialect(MavMessage::EXTENDED_SYS_STATE(extended)), NOW);
        telemetry
    }

    fn flying() -> Telemetry {
        armed(MavLandedState::MAV_LANDED_STATE_IN_AIR)
    }

    fn landed() -> Telemetry {
        armed(MavLandedState::MAV_LANDED_STATE_ON_GROUND)
    }

    /// The same command both ways, as a request and as a raw message.
    fn spelled(command: u16, params: &[f32], telemetry: &Telemetry) -> Option<Danger> {
        let target = Address::new(1, 1);
        let mut seven = [0.0; 7];
        seven[..params.len()].copy_from_slice(params);
        let long = CommandLong { target, command, confirmation: 0, params: seven };
        let four = [seven[0], seven[1], seven[2], seven[3]];
        let int =
            CommandInt { target, command, frame: 0, current: 0, autocontinue: 0, params: four, x: 0, y: 0, z: 0.0 };
        let found = [
            Danger::of_request(&Request::RawCommandLong(long), telemetry, NOW),
            Danger::of_request(&Request::RawCommandInt(int), telemetry, NOW),
            Danger::of_message(&Message::CommandLong(long), ONE, telemetry, NOW),
            Danger::of_message(&Message::CommandInt(int), ONE, telemetry, NOW),
        ];
        assert!(found.iter().all(|danger| *danger == found[0]), "command {command}: {found:?}");
        found[0]
    }

    fn raw(name: &str, fields: &[(&str, FieldValue)]) -> Option<Danger> {
        let fields: BTreeMap<_, _> = fields.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        let (id, payload) = encode_fields(name, &fields).expect("a message");
        let message = Message::from_payload(MavVersion::V2, id, &payload).expect("decodes");
        Danger::of_message(&message, ONE, &flying(), NOW)
    }

    #[test]
    fn commands_are_known_however_they_are_spelled() {
        for (command, params, expected) in [
            (400, &[1.0][..], None),
            (400, &[1.0, 21_196.0], Some(Danger::ForceArm)),
            (400, &[1.0, 2_989.0], Some(Danger::ForceArm)),
            (400, &[f32::NAN], Some(Danger::ForceArm)),
            (400, &[0.0], Some(Danger::DisarmInFlight)),
            (400, &[0.0, 21_196.0], Some(Danger::ForceDisarm)),
            (185, &[1.0], Some(Danger::Terminate)),
            (208, &[2.0], Some(Danger::Terminate)),
            (207, &[0.0], Some(Danger::FenceOff)),
            (207, &[f32::NAN], Some(Danger::FenceOff)),
            (207, &[1.0], None),
            (246, &[1.0], Some(Danger::Reboot)),
            (245, &[2.0], Some(Danger::Erase)),
            (245, &[1.0, 1.0], None),
            (176, &[128.0, 1.0], Some(Danger::ForceDisarm)),
            (176, &[1.0, 10.0], None),
            (5300, &[0.0], Some(Danger::ForceDisarm)),
            (5300, &[1.0], None),
            (223, &[0.0], Some(Danger::ForceDisarm)),
            (223, &[1.0], None),
            (218, &[31.0, 2.0], Some(Danger::ForceDisarm)),
            (218, &[165.0, 0.0], Some(Danger::ForceDisarm)),
            (218, &[81.0, 2.0], Some(Danger::DisarmInFlight)),
            (218, &[153.0, 0.0], Some(Danger::DisarmInFlight)),
            (218, &[153.0, 2.0], None),
            (218, &[11.0, 0.0], Some(Danger::FenceOff)),
            (218, &[11.0, 2.0], None),
            (218, &[22.0, 2.0], Some(Danger::Terminate)),
            (218, &[58.0, 2.0], Some(Danger::Clear(PlanKind::Mission))),
            (218, &[9.0, 2.0], None),
            (526, &[1.0, 1.0], Some(Danger::Erase)),
            (42_650, &[], Some(Danger::WriteFiles)),
            (42_700, &[32_451.0], Some(Danger::Reboot)),
            (179, &[1.0], Some(Danger::MoveHome)),
            (178, &[1.0, 20.0], None),
        ] {
            assert_eq!(spelled(command, params, &flying()), expected, "{command} {params:?}");
        }
    }

    #[test]
    fn a_vehicle_that_is_not_known_to_stand_may_fly() {
        let disarm = Request::Disarm { force: false };
        let of = |telemetry: &Telemetry, now| Danger::of_request(&disarm, telemetry, now);
        let unknown = armed(MavLandedState::MAV_LANDED_STATE_UNDEFINED);
        assert_eq!(of(&flying(), NOW), Some(Danger::DisarmInFlight));
        assert_eq!(of(&landed(), NOW), None);
        assert_eq!(of(&unknown, NOW), Some(Danger::DisarmInFlight));
        assert_eq!(of(&landed(), NOW + LOST_AFTER * 2), Some(Danger::DisarmInFlight), "that was long ago");
        let with = |groundspeed: f32, airspeed: f32, mav_type: u8| {
            let mut telemetry = unknown;
            let heartbeat = Heartbeat { mav_type, autopilot: 3, base_mode: 0x80, ..Heartbeat::default() };
            telemetry.apply(&Message::Heartbeat(heartbeat), NOW);
            let hud = VFR_HUD_DATA { groundspeed, airspeed, ..Default::default() };
            telemetry.apply(&Message::Dialect(MavMessage::VFR_HUD(hud)), NOW);
            of(&telemetry, NOW)
        };
        assert_eq!(with(0.4, 2.0, 1), None);
        assert_eq!(with(0.4, 12.0, 1), Some(Danger::DisarmInFlight), "against a strong wind");
        assert_eq!(with(0.4, 0.0, 2), Some(Danger::DisarmInFlight), "a copter hovers");
        assert_eq!(of(&Telemetry::new(), NOW), Some(Danger::DisarmInFlight));
        assert_eq!(spelled(400, &[0.0], &landed()), None);
        assert_eq!(spelled(179, &[1.0], &landed()), None);
        let to = |system: u8| {
            let target = Address::new(system, 1);
            let command = CommandLong { target, command: 400, confirmation: 0, params: [0.0; 7] };
            Danger::of_message(&Message::CommandLong(command), ONE, &landed(), NOW)
        };
        assert_eq!((to(1), to(2), to(0)), (None, Some(Danger::DisarmInFlight), Some(Danger::DisarmInFlight)));
    }

    #[test]
    fn requests_messages_and_parameters_that_clear_or_switch_off() {
        let of = |request: Request| Danger::of_request(&request, &flying(), NOW);
        let upload = |items: Vec<MissionItem>| Request::UploadPlan {
            kind: PlanKind::Fence,
            items,
            home: None,
            despite_findings: false,
        };
        assert_eq!(of(Request::Arm { force: true }), Some(Danger::ForceArm));
        assert_eq!(of(Request::Arm { force: false }), None);
        assert_eq!(of(Request::Reboot), Some(Danger::Reboot));
        assert_eq!(of(Request::SwitchFence { on: false }), Some(Danger::FenceOff));
        assert_eq!(of(Request::SwitchFence { on: true }), None);
        assert_eq!(of(Request::ClearPlan { kind: PlanKind::Rally }), Some(Danger::Clear(PlanKind::Rally)));
        assert_eq!(of(upload(Vec::new())), Some(Danger::Clear(PlanKind::Fence)));
        let set = |name: &str, value: f64| of(Request::ParamSet { name: name.to_owned(), value });
        for (name, value, expected) in [
            ("FENCE_ENABLE", 0.0, Some(Danger::FenceOff)),
            ("fence_enable ", 0.4, Some(Danger::FenceOff)),
            ("FENCE_ENABLE", 1.0, None),
            ("FENCE_ACTION", 0.0, Some(Danger::FenceOff)),
            ("AFS_TERMINATE", 1.0, Some(Danger::Terminate)),
            ("MIS_TOTAL", 3.0, Some(Danger::Clear(PlanKind::Mission))),
            ("WP_RADIUS", 0.0, None),
        ] {
            assert_eq!(set(name, value), expected, "{name} = {value}");
            let fields = [
                ("param_id", FieldValue::Text(name.to_owned())),
                ("param_type", FieldValue::Unsigned(9)),
                ("param_value", FieldValue::Float(value)),
            ];
            assert_eq!(raw("PARAM_SET", &fields), expected, "PARAM_SET {name} = {value}");
        }
        let kind = |number: u64| [("mission_type", FieldValue::Unsigned(number))];
        assert_eq!(raw("MISSION_CLEAR_ALL", &kind(0)), Some(Danger::Clear(PlanKind::Mission)));
        assert_eq!(raw("MISSION_CLEAR_ALL", &kind(255)), Some(Danger::ClearAll));
        assert_eq!(raw("MISSION_COUNT", &kind(1)), Some(Danger::Clear(PlanKind::Fence)));
        assert_eq!(raw("MISSION_WRITE_PARTIAL_LIST", &kind(0)), Some(Danger::Clear(PlanKind::Mission)));
        assert_eq!(raw("LOG_ERASE", &[]), Some(Danger::Erase));
        let mode =
            |base, custom| [("base_mode", FieldValue::Unsigned(base)), ("custom_mode", FieldValue::Unsigned(custom))];
        assert_eq!(raw("SET_MODE", &mode(128, 1)), Some(Danger::ForceDisarm), "the safety switch");
        assert_eq!(raw("SET_MODE", &mode(1, 10)), None);
        let ftp = |opcode: u64| {
            let bytes = [0, 0, 0, opcode].map(FieldValue::Unsigned).to_vec();
            raw("FILE_TRANSFER_PROTOCOL", &[("payload", FieldValue::List(bytes))])
        };
        assert_eq!((ftp(4), ftp(6), ftp(8)), (None, Some(Danger::WriteFiles), Some(Danger::WriteFiles)));
        assert_eq!(raw("MISSION_REQUEST_LIST", &kind(0)), None);
    }

    #[test]
    fn names_are_stable_and_each_its_own() {
        for danger in Danger::ALL {
            assert_eq!(Danger::from_code(danger.code()), Some(danger));
        }
        assert_eq!(Danger::from_code("arm"), None);
    }
}
