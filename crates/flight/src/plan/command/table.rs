//! The table itself: every command that ArduPlane takes in missions, fences and rally lists, and every one that it
//! refuses.

use super::info::{Category, Choice, ChoiceWord, Command, CommandInfo, ParamInfo, RefusedCommand, Support, Unit};
use super::storage::Storage;

const fn choice(value: f64, word: ChoiceWord) -> Choice {
    Choice { value, word }
}

const ON_OFF: &[Choice] = &[choice(0.0, ChoiceWord::Off), choice(1.0, ChoiceWord::On)];
const SENSES: &[Choice] = &[choice(1.0, ChoiceWord::Clockwise), choice(-1.0, ChoiceWord::CounterClockwise)];
const EXITS: &[Choice] = &[choice(0.0, ChoiceWord::Centre), choice(1.0, ChoiceWord::Tangent)];
const DONE_WHEN: &[Choice] =
    &[choice(0.0, ChoiceWord::Whenever), choice(1.0, ChoiceWord::Above), choice(2.0, ChoiceWord::Below)];
const SPEEDS: &[Choice] = &[
    choice(0.0, ChoiceWord::Airspeed),
    choice(1.0, ChoiceWord::Groundspeed),
    choice(2.0, ChoiceWord::Climb),
    choice(3.0, ChoiceWord::Descent),
];
const FENCE_ACTIONS: &[Choice] =
    &[choice(0.0, ChoiceWord::Off), choice(1.0, ChoiceWord::On), choice(2.0, ChoiceWord::FloorOff)];
const PARACHUTE_ACTIONS: &[Choice] =
    &[choice(0.0, ChoiceWord::Off), choice(1.0, ChoiceWord::On), choice(2.0, ChoiceWord::Deploy)];
const GRIPPER_ACTIONS: &[Choice] = &[choice(0.0, ChoiceWord::Release), choice(1.0, ChoiceWord::Grab)];
const SWITCH_POSITIONS: &[Choice] =
    &[choice(0.0, ChoiceWord::Low), choice(1.0, ChoiceWord::Middle), choice(2.0, ChoiceWord::High)];
const VTOL_STATES: &[Choice] = &[choice(3.0, ChoiceWord::Hover), choice(4.0, ChoiceWord::Cruise)];

impl ParamInfo {
    const fn within(mut self, min: f64, max: f64) -> Self {
        (self.min, self.max) = (Some(min), Some(max));
        self
    }

    const fn at_least(mut self, min: f64) -> Self {
        self.min = Some(min);
        self
    }

    const fn one_of(mut self, choices: &'static [Choice]) -> Self {
        self.choices = choices;
        self
    }

    const fn default(mut self, value: f64) -> Self {
        self.default = Some(value);
        self
    }
}

const fn p(label: &'static str, unit: Unit, storage: Storage) -> ParamInfo {
    let choices = if matches!(unit, Unit::Flag) { ON_OFF } else { &[] };
    ParamInfo { label, unit, min: None, max: None, default: None, storage, choices }
}

const NONE: ParamInfo = p("", Unit::None, Storage::Dropped);
const LAT: ParamInfo = p("Latitude", Unit::Degrees, Storage::DegE7).within(-90.0, 90.0);
const LON: ParamInfo = p("Longitude", Unit::Degrees, Storage::DegE7).within(-180.0, 180.0);
const ALT: ParamInfo = p("Height", Unit::Metres, Storage::Centimetres).within(-83_000.0, 83_000.0);
const WHOLE_ALT: ParamInfo = p("Height", Unit::Metres, Storage::I16).within(-32_768.0, 32_767.0);

/// Pads the parameters of a row to seven with unused ones.
const fn seven<const N: usize>(given: [ParamInfo; N]) -> [ParamInfo; 7] {
    let mut params = [NONE; 7];
    let mut index = 0;
    while index < N {
        params[index] = given[index];
        index += 1;
    }
    params
}

/// Whether a plane flies to the position of the item.
const DESTINATION: bool = true;
const OTHER: bool = false;
/// Whether a refused command has a position.
const POSITION: bool = true;
const NO_POSITION: bool = false;

/// One row per command: `NAME = number, title, category, support, DESTINATION or OTHER: [parameters 1 to 4, x, y, z]`.
/// Trailing unused parameters are left out. Makes the constant `Command::NAME` and the entry of [`COMMANDS`].
macro_rules! commands {
    ($($name:ident = $number:literal, $title:literal, $category:ident, $support:ident, $flown_to:ident: [$($param:expr),* $(,)?],)*) => {
        impl Command {
            $(
                #[doc = concat!(stringify!($number), ": ", $title, ".")]
                pub const $name: Self = Self($number);
            )*
        }

        /// All commands that ArduPlane takes in missions, fences and rally lists, by number.
        pub const COMMANDS: &[CommandInfo] = &[$(CommandInfo {
            command: Command::$name,
            name: concat!("MAV_CMD_", stringify!($name)),
            title: $title,
            category: Category::$category,
            has_position: matches!(seven([$($param),*])[4].storage, Storage::DegE7),
            is_destination: $flown_to,
            support: Support::$support,
            params: seven([$($param),*]),
        }),*];
    };
}

/// One row per refused command: `NAME = number, POSITION or NO_POSITION;`.
macro_rules! refused {
    ($($name:ident = $number:literal, $has_position:ident;)*) => {
        impl Command {
            $(
                #[doc = concat!(stringify!($number), ": refused by ArduPlane in a plan.")]
                pub const $name: Self = Self($number);
            )*
        }

        /// Commands that ArduPlane refuses in a plan (`MAV_MISSION_UNSUPPORTED`), by number.
        pub const REFUSED: &[RefusedCommand] = &[$(RefusedCommand {
            command: Command::$name,
            name: concat!("MAV_CMD_", stringify!($name)),
            has_position: $has_position,
        }),*];
    };
}

commands! {
    NAV_WAYPOINT = 16, "Waypoint", Nav, Flown, DESTINATION: [
        p("Hold time", Unit::Seconds, Storage::Dropped).at_least(0.0),
        p("Acceptance radius", Unit::Metres, Storage::U16Max255).within(0.0, 255.0).default(0.0),
        p("Pass by", Unit::Metres, Storage::U16Max255).within(0.0, 255.0).default(0.0),
        p("Heading", Unit::Degrees, Storage::Dropped),
        LAT, LON, ALT,
    ],
    NAV_LOITER_UNLIM = 17, "Loiter (unlimited)", Nav, Flown, DESTINATION: [
        NONE, NONE,
        p("Radius", Unit::Metres, Storage::SignedU16).within(-65535.0, 65535.0).default(0.0),
        p("Heading", Unit::Degrees, Storage::Dropped),
        LAT, LON, ALT,
    ],
    NAV_LOITER_TURNS = 18, "Loiter (turns)", Nav, Flown, DESTINATION: [
        p("Turns", Unit::Count, Storage::Turns).within(0.0, 255.0).default(1.0),
        NONE,
        p("Radius", Unit::Metres, Storage::TurnsRadius).within(-2550.0, 2550.0).default(0.0),
        p("Leave towards next from", Unit::Choice, Storage::Positive).within(0.0, 1.0).default(1.0).one_of(EXITS),
        LAT, LON, ALT,
    ],
    NAV_LOITER_TIME = 19, "Loiter (time)", Nav, Flown, DESTINATION: [
        p("Time", Unit::Seconds, Storage::U16).within(0.0, 65535.0).default(60.0),
        NONE,
        p("Direction", Unit::Choice, Storage::LoiterSign).default(1.0).one_of(SENSES),
        p("Leave towards next from", Unit::Choice, Storage::Positive).within(0.0, 1.0).default(1.0).one_of(EXITS),
        LAT, LON, ALT,
    ],
    NAV_RETURN_TO_LAUNCH = 20, "Return to launch", Nav, Flown, OTHER: [],
    NAV_LAND = 21, "Land", Nav, Flown, DESTINATION: [
        p("Abort height", Unit::Metres, Storage::U16).within(0.0, 32_767.0).default(0.0),
        NONE, NONE,
        p("Turn direction (deep stall)", Unit::Choice, Storage::YawSign),
        LAT, LON, ALT,
    ],
    NAV_TAKEOFF = 22, "Take off", Nav, Flown, OTHER: [
        p("Minimum pitch", Unit::Degrees, Storage::U16).within(0.0, 90.0).default(15.0),
        NONE, NONE,
        p("Heading", Unit::Degrees, Storage::Dropped),
        LAT, LON, ALT,
    ],
    NAV_CONTINUE_AND_CHANGE_ALT = 30, "Continue and change height", Nav, Flown, OTHER: [
        p("Done when", Unit::Choice, Storage::U16).within(0.0, 2.0).default(0.0).one_of(DONE_WHEN),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    NAV_LOITER_TO_ALT = 31, "Loiter to height", Nav, Flown, DESTINATION: [
        p("Heading required", Unit::Flag, Storage::Dropped).within(0.0, 1.0),
        p("Radius", Unit::Metres, Storage::SignedU16).within(-65535.0, 65535.0).default(0.0),
        NONE,
        p("Leave towards next from", Unit::Choice, Storage::Positive).within(0.0, 1.0).default(1.0).one_of(EXITS),
        LAT, LON, ALT,
    ],
    NAV_ARC_WAYPOINT = 36, "Arc waypoint", Nav, Ignored, DESTINATION: [
        p("Arc angle", Unit::Degrees, Storage::SignedU16).within(-359.0, 359.0).default(90.0),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    NAV_ALTITUDE_WAIT = 83, "Wait for height (balloon)", Nav, Flown, OTHER: [
        p("Height above sea level", Unit::Metres, Storage::Float),
        p("Descent speed", Unit::MetresPerSecond, Storage::Float).at_least(0.0),
        p("Servo wiggle period", Unit::Seconds, Storage::U8).within(0.0, 255.0),
    ],
    // It goes straight up (`QuadPlane::do_vtol_takeoff`).
    NAV_VTOL_TAKEOFF = 84, "VTOL take-off", Nav, NeedsVtol, OTHER: [
        NONE,
        p("Transition heading", Unit::Choice, Storage::Dropped),
        NONE,
        p("Heading", Unit::Degrees, Storage::Dropped),
        LAT, LON, ALT,
    ],
    NAV_VTOL_LAND = 85, "VTOL land", Nav, NeedsVtol, DESTINATION: [
        p("Options", Unit::Choice, Storage::U16).within(0.0, 65535.0).default(0.0),
        NONE,
        p("Approach height", Unit::Metres, Storage::Dropped),
        p("Heading", Unit::Degrees, Storage::Dropped),
        LAT, LON, ALT,
    ],
    NAV_GUIDED_ENABLE = 92, "Hand over to external control", Nav, Ignored, OTHER: [
        p("On", Unit::Flag, Storage::U16).within(0.0, 1.0),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    NAV_DELAY = 93, "Delay", Nav, Flown, OTHER: [
        p("Delay", Unit::Seconds, Storage::Float).at_least(-1.0),
        p("Hour (UTC)", Unit::Hours, Storage::I8).within(-1.0, 23.0).default(-1.0),
        p("Minute (UTC)", Unit::Minutes, Storage::I8).within(-1.0, 59.0).default(-1.0),
        p("Second (UTC)", Unit::Seconds, Storage::I8).within(-1.0, 59.0).default(-1.0),
    ],
    NAV_PAYLOAD_PLACE = 94, "Place payload", Nav, NeedsVtol, DESTINATION: [
        p("Largest descent", Unit::Metres, Storage::CentiU16).within(0.0, 655.35),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    CONDITION_DELAY = 112, "Wait before next action", Condition, Flown, OTHER: [
        p("Delay", Unit::Seconds, Storage::Float).at_least(0.0),
    ],
    CONDITION_DISTANCE = 114, "Wait until near next waypoint", Condition, Flown, OTHER: [
        p("Distance", Unit::Metres, Storage::Float).at_least(0.0),
    ],
    CONDITION_YAW = 115, "Wait for heading", Condition, Ignored, OTHER: [
        p("Heading", Unit::Degrees, Storage::Float).within(0.0, 360.0),
        p("Turn rate", Unit::DegreesPerSecond, Storage::Float).at_least(0.0),
        p("Direction", Unit::Choice, Storage::I8).within(-1.0, 1.0),
        p("Relative", Unit::Flag, Storage::U8).within(0.0, 1.0),
    ],
    DO_JUMP = 177, "Jump to item", Do, Flown, OTHER: [
        p("Item", Unit::Item, Storage::U16).within(1.0, 65535.0).default(1.0),
        p("Repeats", Unit::Count, Storage::I16).within(-1.0, 32767.0).default(1.0),
    ],
    DO_CHANGE_SPEED = 178, "Change speed", Do, Flown, OTHER: [
        p("Kind of speed", Unit::Choice, Storage::U8).within(0.0, 3.0).default(0.0).one_of(SPEEDS),
        p("Speed", Unit::MetresPerSecond, Storage::Float).at_least(-2.0).default(15.0),
        // −1: the throttle stays as it is.
        p("Throttle", Unit::Percent, Storage::Float).within(-2.0, 100.0).default(-1.0),
    ],
    DO_SET_HOME = 179, "Set home", Do, Flown, OTHER: [
        p("Use current position", Unit::Flag, Storage::U16).within(0.0, 1.0).default(0.0),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    DO_SET_RELAY = 181, "Set relay", Do, Flown, OTHER: [
        p("Relay", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("State", Unit::Flag, Storage::U8).within(0.0, 1.0),
    ],
    DO_REPEAT_RELAY = 182, "Cycle relay", Do, Flown, OTHER: [
        p("Relay", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Repeats", Unit::Count, Storage::I16).within(0.0, 32767.0),
        p("Cycle time", Unit::Seconds, Storage::Float).at_least(0.0),
    ],
    DO_SET_SERVO = 183, "Set servo", Do, Flown, OTHER: [
        p("Servo", Unit::Number, Storage::U8).within(1.0, 255.0),
        p("Pulse", Unit::Microseconds, Storage::U16).within(0.0, 65535.0),
    ],
    DO_REPEAT_SERVO = 184, "Cycle servo", Do, Flown, OTHER: [
        p("Servo", Unit::Number, Storage::U8).within(1.0, 255.0),
        p("Pulse", Unit::Microseconds, Storage::U16).within(0.0, 65535.0),
        p("Repeats", Unit::Count, Storage::I16).within(0.0, 32767.0),
        p("Cycle time", Unit::Seconds, Storage::Float).at_least(0.0),
    ],
    DO_RETURN_PATH_START = 188, "Start of return path", Do, Flown, OTHER: [NONE, NONE, NONE, NONE, LAT, LON, ALT],
    DO_LAND_START = 189, "Start of landing sequence", Do, Flown, OTHER: [NONE, NONE, NONE, NONE, LAT, LON, ALT],
    DO_GO_AROUND = 191, "Go around", Do, Flown, OTHER: [
        p("Height", Unit::Metres, Storage::Dropped),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    DO_PAUSE_CONTINUE = 193, "Pause or continue", Do, Ignored, OTHER: [
        p("Continue", Unit::Flag, Storage::U16).within(0.0, 1.0),
    ],
    DO_SET_REVERSE = 194, "Drive backwards", Do, Ignored, OTHER: [
        p("Backwards", Unit::Flag, Storage::U16).within(0.0, 1.0),
    ],
    DO_SET_ROI_LOCATION = 195, "Point camera at place", Do, Flown, OTHER: [
        p("Gimbal", Unit::Number, Storage::U16).within(0.0, 255.0),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    DO_SET_ROI_NONE = 197, "Point camera freely", Do, Flown, OTHER: [
        p("Gimbal", Unit::Number, Storage::U16).within(0.0, 255.0),
    ],
    DO_SET_ROI = 201, "Point camera (legacy)", Do, Flown, OTHER: [
        p("Mode", Unit::Choice, Storage::U16).within(0.0, 4.0),
        NONE, NONE, NONE, LAT, LON, ALT,
    ],
    DO_DIGICAM_CONFIGURE = 202, "Configure camera", Do, Flown, OTHER: [
        p("Mode", Unit::Choice, Storage::U8).within(0.0, 255.0),
        p("Shutter speed", Unit::None, Storage::U16).within(0.0, 65535.0),
        p("Aperture", Unit::None, Storage::U8).within(0.0, 255.0),
        p("ISO", Unit::None, Storage::U16).within(0.0, 65535.0),
        p("Exposure type", Unit::Choice, Storage::LowU8),
        p("Command identity", Unit::Number, Storage::LowU8),
        p("Engine cut-off", Unit::Seconds, Storage::Float),
    ],
    DO_DIGICAM_CONTROL = 203, "Trigger camera", Do, Flown, OTHER: [
        p("Session", Unit::Choice, Storage::U8).within(0.0, 255.0),
        p("Zoom position", Unit::None, Storage::U8).within(0.0, 255.0),
        p("Zoom step", Unit::None, Storage::I8).within(-128.0, 127.0),
        p("Focus lock", Unit::Choice, Storage::U8).within(0.0, 255.0),
        p("Shoot", Unit::Flag, Storage::LowU8),
        p("Command identity", Unit::Number, Storage::LowU8),
        p("Shot identity", Unit::Number, Storage::Dropped),
    ],
    DO_MOUNT_CONTROL = 205, "Point gimbal", Do, Flown, OTHER: [
        p("Pitch", Unit::Degrees, Storage::Float),
        p("Roll", Unit::Degrees, Storage::Float),
        p("Yaw", Unit::Degrees, Storage::Float),
        NONE, NONE, NONE,
        p("Mode", Unit::Choice, Storage::Two),
    ],
    DO_SET_CAM_TRIGG_DIST = 206, "Trigger camera by distance", Do, Flown, OTHER: [
        p("Distance", Unit::Metres, Storage::Float).at_least(0.0),
        NONE,
        p("Trigger at once", Unit::Flag, Storage::U8).within(0.0, 1.0),
    ],
    DO_FENCE_ENABLE = 207, "Switch fence", Do, Flown, OTHER: [
        p("Action", Unit::Choice, Storage::U16).within(0.0, 2.0).one_of(FENCE_ACTIONS),
    ],
    DO_PARACHUTE = 208, "Parachute", Do, Flown, OTHER: [
        p("Action", Unit::Choice, Storage::U16).within(0.0, 2.0).one_of(PARACHUTE_ACTIONS),
    ],
    DO_INVERTED_FLIGHT = 210, "Fly inverted", Do, Flown, OTHER: [
        p("Inverted", Unit::Flag, Storage::U16).within(0.0, 1.0),
    ],
    DO_GRIPPER = 211, "Gripper", Do, Flown, OTHER: [
        p("Gripper", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Action", Unit::Choice, Storage::U8).within(0.0, 1.0).one_of(GRIPPER_ACTIONS),
    ],
    DO_AUTOTUNE_ENABLE = 212, "Switch autotune", Do, Flown, OTHER: [
        p("On", Unit::Flag, Storage::U16).within(0.0, 1.0),
    ],
    NAV_SET_YAW_SPEED = 213, "Set heading and speed", Nav, Ignored, OTHER: [
        p("Heading", Unit::Degrees, Storage::Float),
        p("Speed", Unit::MetresPerSecond, Storage::Float),
        p("Relative", Unit::Flag, Storage::U8).within(0.0, 1.0),
    ],
    DO_SET_RESUME_REPEAT_DIST = 215, "Distance to repeat on resume", Do, Flown, OTHER: [
        p("Distance", Unit::Metres, Storage::U16).within(0.0, 65535.0),
    ],
    DO_SPRAYER = 216, "Switch sprayer", Do, Ignored, OTHER: [p("On", Unit::Flag, Storage::U16).within(0.0, 1.0)],
    DO_SEND_SCRIPT_MESSAGE = 217, "Message to script", Do, Flown, OTHER: [
        p("Message", Unit::Number, Storage::U16).within(0.0, 65535.0),
        p("Value 1", Unit::None, Storage::Float),
        p("Value 2", Unit::None, Storage::Float),
        p("Value 3", Unit::None, Storage::Float),
    ],
    DO_AUX_FUNCTION = 218, "Auxiliary function", Do, Flown, OTHER: [
        p("Function", Unit::Choice, Storage::U16).within(0.0, 65535.0),
        p("Switch position", Unit::Choice, Storage::U8).within(0.0, 2.0).one_of(SWITCH_POSITIONS),
    ],
    DO_GUIDED_LIMITS = 222, "Limits of external control", Do, Ignored, OTHER: [
        p("Longest time", Unit::Seconds, Storage::U16).within(0.0, 65535.0),
        p("Lowest height", Unit::Metres, Storage::Float),
        p("Greatest height", Unit::Metres, Storage::Float),
        p("Farthest", Unit::Metres, Storage::Float).at_least(0.0),
    ],
    DO_ENGINE_CONTROL = 223, "Engine control", Do, Flown, OTHER: [
        p("Start", Unit::Flag, Storage::Positive).within(0.0, 1.0),
        p("Cold start", Unit::Flag, Storage::Positive).within(0.0, 1.0),
        p("Start above", Unit::Metres, Storage::CentiU16).within(0.0, 655.35),
        p("Options", Unit::Choice, Storage::Bit0).within(0.0, 1.0),
    ],
    SET_CAMERA_ZOOM = 531, "Zoom camera", Do, Flown, OTHER: [
        p("Kind", Unit::Choice, Storage::U8).within(0.0, 3.0),
        p("Value", Unit::None, Storage::Float),
    ],
    SET_CAMERA_FOCUS = 532, "Focus camera", Do, Flown, OTHER: [
        p("Kind", Unit::Choice, Storage::U8).within(0.0, 7.0),
        p("Value", Unit::None, Storage::Float),
    ],
    SET_CAMERA_SOURCE = 534, "Camera source", Do, Flown, OTHER: [
        p("Camera", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Primary source", Unit::Choice, Storage::U8).within(0.0, 255.0),
        p("Secondary source", Unit::Choice, Storage::U8).within(0.0, 255.0),
    ],
    JUMP_TAG = 600, "Jump label", Do, Flown, OTHER: [p("Label", Unit::Number, Storage::U16).within(0.0, 65535.0)],
    DO_JUMP_TAG = 601, "Jump to label", Do, Flown, OTHER: [
        p("Label", Unit::Number, Storage::U16).within(0.0, 65535.0),
        p("Repeats", Unit::Count, Storage::I16).within(-1.0, 32767.0).default(1.0),
    ],
    DO_GIMBAL_MANAGER_PITCHYAW = 1000, "Gimbal pitch and yaw", Do, Flown, OTHER: [
        p("Pitch", Unit::Degrees, Storage::I8).within(-128.0, 127.0),
        p("Yaw", Unit::Degrees, Storage::I16).within(-32768.0, 32767.0),
        p("Pitch rate", Unit::DegreesPerSecond, Storage::I8).within(-128.0, 127.0),
        p("Yaw rate", Unit::DegreesPerSecond, Storage::I8).within(-128.0, 127.0),
        p("Flags", Unit::Choice, Storage::LowU8),
        NONE,
        p("Gimbal", Unit::Number, Storage::U8).within(0.0, 255.0),
    ],
    IMAGE_START_CAPTURE = 2000, "Take pictures", Do, Flown, OTHER: [
        p("Camera", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Interval", Unit::Seconds, Storage::Float).at_least(0.0),
        p("Pictures", Unit::Count, Storage::U16).within(0.0, 65535.0),
        p("First number", Unit::Number, Storage::U16).within(0.0, 65535.0),
    ],
    IMAGE_STOP_CAPTURE = 2001, "Stop taking pictures", Do, Flown, OTHER: [
        p("Camera", Unit::Number, Storage::U16).within(0.0, 255.0),
    ],
    VIDEO_START_CAPTURE = 2500, "Start video", Do, Flown, OTHER: [
        p("Stream", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Status rate", Unit::Hertz, Storage::Dropped).at_least(0.0),
    ],
    VIDEO_STOP_CAPTURE = 2501, "Stop video", Do, Flown, OTHER: [
        p("Stream", Unit::Number, Storage::U8).within(0.0, 255.0),
    ],
    DO_VTOL_TRANSITION = 3000, "VTOL transition", Do, NeedsVtol, OTHER: [
        p("State", Unit::Choice, Storage::U8).within(3.0, 4.0).one_of(VTOL_STATES),
    ],
    NAV_FENCE_RETURN_POINT = 5000, "Fence return point", Fence, List, OTHER: [NONE, NONE, NONE, NONE, LAT, LON],
    NAV_FENCE_POLYGON_VERTEX_INCLUSION = 5001, "Corner of an inclusion polygon", Fence, List, OTHER: [
        p("Corners", Unit::Count, Storage::U8).within(3.0, 255.0),
        NONE, NONE, NONE, LAT, LON,
    ],
    NAV_FENCE_POLYGON_VERTEX_EXCLUSION = 5002, "Corner of an exclusion polygon", Fence, List, OTHER: [
        p("Corners", Unit::Count, Storage::U8).within(3.0, 255.0),
        NONE, NONE, NONE, LAT, LON,
    ],
    NAV_FENCE_CIRCLE_INCLUSION = 5003, "Inclusion circle", Fence, List, OTHER: [
        p("Radius", Unit::Metres, Storage::FenceRadius).at_least(0.0),
        NONE, NONE, NONE, LAT, LON,
    ],
    NAV_FENCE_CIRCLE_EXCLUSION = 5004, "Exclusion circle", Fence, List, OTHER: [
        p("Radius", Unit::Metres, Storage::FenceRadius).at_least(0.0),
        NONE, NONE, NONE, LAT, LON,
    ],
    NAV_RALLY_POINT = 5100, "Rally point", Rally, List, OTHER: [NONE, NONE, NONE, NONE, LAT, LON, WHOLE_ALT],
    DO_WINCH = 42600, "Winch", Do, Ignored, OTHER: [
        p("Winch", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Action", Unit::Choice, Storage::U8).within(0.0, 255.0),
        p("Length", Unit::Metres, Storage::Float),
        p("Speed", Unit::MetresPerSecond, Storage::Float),
    ],
    NAV_SCRIPT_TIME = 42702, "Script for a time", Nav, Flown, OTHER: [
        p("Script command", Unit::Number, Storage::U8).within(0.0, 255.0),
        p("Time-out", Unit::Seconds, Storage::U8).within(0.0, 255.0),
        p("Value 1", Unit::None, Storage::Half).within(-65504.0, 65504.0),
        p("Value 2", Unit::None, Storage::Half).within(-65504.0, 65504.0),
        p("Value 3", Unit::None, Storage::LowI16).within(-32768.0, 32767.0),
        p("Value 4", Unit::None, Storage::LowI16).within(-32768.0, 32767.0),
    ],
    NAV_ATTITUDE_TIME = 42703, "Hold attitude for a time", Nav, Ignored, OTHER: [
        p("Time", Unit::Seconds, Storage::U16).within(0.0, 65535.0),
        p("Roll", Unit::Degrees, Storage::RollDegrees).within(-180.0, 180.0),
        p("Pitch", Unit::Degrees, Storage::PitchDegrees).within(-90.0, 90.0),
        p("Yaw", Unit::Degrees, Storage::YawDegrees).within(-180.0, 360.0),
        p("Climb rate", Unit::MetresPerSecond, Storage::LowI16),
    ],
}

refused! {
    NAV_LAND_LOCAL = 23, POSITION;
    NAV_TAKEOFF_LOCAL = 24, POSITION;
    NAV_FOLLOW = 25, POSITION;
    DO_FOLLOW = 32, NO_POSITION;
    DO_FOLLOW_REPOSITION = 33, NO_POSITION;
    DO_ORBIT = 34, NO_POSITION;
    DO_FIGURE_EIGHT = 35, NO_POSITION;
    NAV_ROI = 80, POSITION;
    NAV_PATHPLANNING = 81, POSITION;
    NAV_SPLINE_WAYPOINT = 82, POSITION;
    NAV_LAST = 95, NO_POSITION;
    CONDITION_CHANGE_ALT = 113, NO_POSITION;
    CONDITION_LAST = 159, NO_POSITION;
    DO_SET_MODE = 176, NO_POSITION;
    DO_SET_PARAMETER = 180, NO_POSITION;
    DO_FLIGHTTERMINATION = 185, NO_POSITION;
    DO_CHANGE_ALTITUDE = 186, NO_POSITION;
    DO_SET_ACTUATOR = 187, NO_POSITION;
    DO_RALLY_LAND = 190, NO_POSITION;
    DO_REPOSITION = 192, POSITION;
    DO_SET_ROI_WPNEXT_OFFSET = 196, NO_POSITION;
    DO_SET_ROI_SYSID = 198, NO_POSITION;
    DO_CONTROL_VIDEO = 200, NO_POSITION;
    DO_MOUNT_CONFIGURE = 204, NO_POSITION;
    DO_MOTOR_TEST = 209, NO_POSITION;
    DO_SET_CAM_TRIGG_INTERVAL = 214, NO_POSITION;
    DO_MOUNT_CONTROL_QUAT = 220, NO_POSITION;
    DO_GUIDED_MASTER = 221, NO_POSITION;
    DO_SET_MISSION_CURRENT = 224, NO_POSITION;
    DO_LAST = 240, NO_POSITION;
    PREFLIGHT_CALIBRATION = 241, NO_POSITION;
    PREFLIGHT_SET_SENSOR_OFFSETS = 242, NO_POSITION;
    PREFLIGHT_UAVCAN = 243, NO_POSITION;
    PREFLIGHT_STORAGE = 245, NO_POSITION;
    PREFLIGHT_REBOOT_SHUTDOWN = 246, NO_POSITION;
    OVERRIDE_GOTO = 252, POSITION;
    OBLIQUE_SURVEY = 260, NO_POSITION;
    DO_SET_STANDARD_MODE = 262, NO_POSITION;
    MISSION_START = 300, NO_POSITION;
    ACTUATOR_TEST = 310, NO_POSITION;
    CONFIGURE_ACTUATOR = 311, NO_POSITION;
    COMPONENT_ARM_DISARM = 400, NO_POSITION;
    RUN_PREARM_CHECKS = 401, NO_POSITION;
    ILLUMINATOR_ON_OFF = 405, NO_POSITION;
    DO_ILLUMINATOR_CONFIGURE = 406, NO_POSITION;
    GET_HOME_POSITION = 410, NO_POSITION;
    INJECT_FAILURE = 420, NO_POSITION;
    START_RX_PAIR = 500, NO_POSITION;
    GET_MESSAGE_INTERVAL = 510, NO_POSITION;
    SET_MESSAGE_INTERVAL = 511, NO_POSITION;
    REQUEST_MESSAGE = 512, NO_POSITION;
    REQUEST_PROTOCOL_VERSION = 519, NO_POSITION;
    REQUEST_AUTOPILOT_CAPABILITIES = 520, NO_POSITION;
    REQUEST_CAMERA_INFORMATION = 521, NO_POSITION;
    REQUEST_CAMERA_SETTINGS = 522, NO_POSITION;
    REQUEST_STORAGE_INFORMATION = 525, NO_POSITION;
    STORAGE_FORMAT = 526, NO_POSITION;
    REQUEST_CAMERA_CAPTURE_STATUS = 527, NO_POSITION;
    REQUEST_FLIGHT_INFORMATION = 528, NO_POSITION;
    RESET_CAMERA_SETTINGS = 529, NO_POSITION;
    SET_CAMERA_MODE = 530, NO_POSITION;
    SET_STORAGE_USAGE = 533, NO_POSITION;
    DO_GIMBAL_MANAGER_CONFIGURE = 1001, NO_POSITION;
    DO_TRIGGER_CONTROL = 2003, NO_POSITION;
    CAMERA_TRACK_POINT = 2004, NO_POSITION;
    CAMERA_TRACK_RECTANGLE = 2005, NO_POSITION;
    CAMERA_STOP_TRACKING = 2010, NO_POSITION;
    VIDEO_START_STREAMING = 2502, NO_POSITION;
    VIDEO_STOP_STREAMING = 2503, NO_POSITION;
    REQUEST_VIDEO_STREAM_INFORMATION = 2504, NO_POSITION;
    REQUEST_VIDEO_STREAM_STATUS = 2505, NO_POSITION;
    LOGGING_START = 2510, NO_POSITION;
    LOGGING_STOP = 2511, NO_POSITION;
    AIRFRAME_CONFIGURATION = 2520, NO_POSITION;
    CONTROL_HIGH_LATENCY = 2600, NO_POSITION;
    PANORAMA_CREATE = 2800, NO_POSITION;
    ARM_AUTHORIZATION_REQUEST = 3001, NO_POSITION;
    SET_GUIDED_SUBMODE_STANDARD = 4000, NO_POSITION;
    SET_GUIDED_SUBMODE_CIRCLE = 4001, POSITION;
    UAVCAN_GET_NODE_INFO = 5200, NO_POSITION;
    DO_SET_SAFETY_SWITCH_STATE = 5300, NO_POSITION;
    DO_ADSB_OUT_IDENT = 10001, NO_POSITION;
    PAYLOAD_PREPARE_DEPLOY = 30001, POSITION;
    PAYLOAD_CONTROL_DEPLOY = 30002, NO_POSITION;
    WAYPOINT_USER_1 = 31000, POSITION;
    WAYPOINT_USER_2 = 31001, POSITION;
    WAYPOINT_USER_3 = 31002, POSITION;
    WAYPOINT_USER_4 = 31003, POSITION;
    WAYPOINT_USER_5 = 31004, POSITION;
    SPATIAL_USER_1 = 31005, POSITION;
    SPATIAL_USER_2 = 31006, POSITION;
    SPATIAL_USER_3 = 31007, POSITION;
    SPATIAL_USER_4 = 31008, POSITION;
    SPATIAL_USER_5 = 31009, POSITION;
    USER_1 = 31010, NO_POSITION;
    USER_2 = 31011, NO_POSITION;
    USER_3 = 31012, NO_POSITION;
    USER_4 = 31013, NO_POSITION;
    USER_5 = 31014, NO_POSITION;
    CAN_FORWARD = 32000, NO_POSITION;
    POWER_OFF_INITIATED = 42000, NO_POSITION;
    SOLO_BTN_FLY_CLICK = 42001, NO_POSITION;
    SOLO_BTN_FLY_HOLD = 42002, NO_POSITION;
    SOLO_BTN_PAUSE_CLICK = 42003, NO_POSITION;
    FIXED_MAG_CAL = 42004, NO_POSITION;
    FIXED_MAG_CAL_FIELD = 42005, NO_POSITION;
    FIXED_MAG_CAL_YAW = 42006, POSITION;
    SET_EKF_SOURCE_SET = 42007, NO_POSITION;
    DO_START_MAG_CAL = 42424, NO_POSITION;
    DO_ACCEPT_MAG_CAL = 42425, NO_POSITION;
    DO_CANCEL_MAG_CAL = 42426, NO_POSITION;
    SET_FACTORY_TEST_MODE = 42427, NO_POSITION;
    DO_SEND_BANNER = 42428, NO_POSITION;
    ACCELCAL_VEHICLE_POS = 42429, NO_POSITION;
    GIMBAL_RESET = 42501, NO_POSITION;
    GIMBAL_AXIS_CALIBRATION_STATUS = 42502, NO_POSITION;
    GIMBAL_REQUEST_AXIS_CALIBRATION = 42503, NO_POSITION;
    GIMBAL_FULL_RESET = 42505, NO_POSITION;
    FLASH_BOOTLOADER = 42650, NO_POSITION;
    BATTERY_RESET = 42651, NO_POSITION;
    DEBUG_TRAP = 42700, NO_POSITION;
    SCRIPTING = 42701, NO_POSITION;
    GUIDED_CHANGE_SPEED = 43000, NO_POSITION;
    GUIDED_CHANGE_ALTITUDE = 43001, NO_POSITION;
    GUIDED_CHANGE_HEADING = 43002, NO_POSITION;
    EXTERNAL_POSITION_ESTIMATE = 43003, POSITION;
    SET_HAGL = 43005, NO_POSITION;
}
