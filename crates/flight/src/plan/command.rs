//! The mission commands: one table that says what each is called, what its parameters mean, and what an
//! ArduPlane keeps of them.
//!
//! Sources: names, units and positions from the MAVLink common and ardupilotmega dialects
//! (<https://mavlink.io/en/messages/common.html#mav_commands>); which commands ArduPlane takes, and in
//! what form it stores each field, from an ArduPlane 4.8 (`tests/fixtures/facts/`, walked by a test) and
//! the packing rules of ArduPilot's mission library.

use crate::words::words;

/// A `MAV_CMD` number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Command(pub u16);

/// What a command is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Category {
    /// Flown until done; one at a time.
    Nav,
    /// Holds back the actions that follow it.
    Condition,
    /// Done at once, beside the flying.
    Do,
    /// Part of a fence list.
    Fence,
    /// Part of a rally list.
    Rally,
}

/// What an ArduPlane does with a command in a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Support {
    /// Stored and done.
    Flown,
    /// Stored, and done by a plane that can hover (quadplane); skipped by others.
    NeedsVtol,
    /// Stored, but skipped in flight: it is meant for other vehicles.
    Ignored,
    /// Taken in fence or rally lists only.
    List,
}

/// Unit of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unit {
    /// A bare number.
    None,
    /// Seconds.
    Seconds,
    /// Minutes.
    Minutes,
    /// Hours.
    Hours,
    /// Metres.
    Metres,
    /// Metres per second.
    MetresPerSecond,
    /// Degrees.
    Degrees,
    /// Degrees per second.
    DegreesPerSecond,
    /// Percent.
    Percent,
    /// Microseconds (servo pulse).
    Microseconds,
    /// Hertz.
    Hertz,
    /// How many.
    Count,
    /// Which one.
    Number,
    /// Sequence number of another item.
    Item,
    /// 0 or 1.
    Flag,
    /// One of a few values with a meaning each.
    Choice,
}

impl Unit {
    /// Symbol to show after a value; empty when there is none.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Seconds => "s",
            Self::Minutes => "min",
            Self::Hours => "h",
            Self::Metres => "m",
            Self::MetresPerSecond => "m/s",
            Self::Degrees => "°",
            Self::DegreesPerSecond => "°/s",
            Self::Percent => "%",
            Self::Microseconds => "µs",
            Self::Hertz => "Hz",
            Self::None | Self::Count | Self::Number | Self::Item | Self::Flag | Self::Choice => "",
        }
    }
}

/// In what form ArduPlane keeps a field, hence what it reads back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Storage {
    /// Not kept: reads back as 0.
    Dropped,
    /// Kept as it is (32-bit float).
    Float,
    /// Kept as a half-precision float.
    Half,
    /// Cut to a whole number of 8 bits, 0 to 255.
    U8,
    /// Cut to a whole number of 8 bits, −128 to 127.
    I8,
    /// Cut to a whole number of 16 bits, 0 to 65,535.
    U16,
    /// Cut to a whole number of 16 bits, −32,768 to 32,767.
    I16,
    /// As [`Storage::U16`], then at most 255 (half of a 16-bit field).
    U16Max255,
    /// Hundredths in 16 bits, 0 to 655.35.
    CentiU16,
    /// Magnitude as [`Storage::U16`], sign kept (negative: counter-clockwise).
    SignedU16,
    /// More than 0 reads back as 1, anything else as 0.
    Positive,
    /// Lowest bit of the whole number.
    Bit0,
    /// Negative reads back as −1, anything else as 1.
    LoiterSign,
    /// As [`Storage::LoiterSign`]; unset (NaN) reads back as 1.
    YawSign,
    /// Whole turns 0 to 255; a part of one turn in steps of 1/256.
    Turns,
    /// Metres up to 255, above that tens of metres up to 2,550; sign kept.
    TurnsRadius,
    /// A whole number on the wire, lowest 8 bits kept.
    LowU8,
    /// A whole number on the wire, lowest 16 bits kept as a signed number.
    LowI16,
    /// Reads back as 2 whatever was sent.
    Two,
    /// Whole degrees within ±180, else 0.
    RollDegrees,
    /// Whole degrees within ±90, else 0.
    PitchDegrees,
    /// Whole degrees from −180 to 360, else 0.
    YawDegrees,
    /// Metres; whole when within a millimetre above a whole number.
    FenceRadius,
    /// degE7 on the wire, kept exactly.
    DegE7,
    /// Whole centimetres, cut towards 0.
    Centimetres,
}

impl Storage {
    /// Whether a vehicle can make of a value what it keeps: a whole number of at most 32 bits, on the way at least, where it is no float.
    ///
    /// What cannot be converted is undefined there (ISO C++, 7.10): ArduPilot's simulator ends, a board keeps anything.
    pub fn converts(self, sent: f32) -> bool {
        let factor = match self {
            Self::Dropped | Self::Float | Self::Half => return true,
            Self::CentiU16 | Self::Centimetres => 100.0,
            _ => 1.0,
        };
        (sent * factor).abs() < 2_147_483_648.0
    }

    /// What a value that is sent (as the 32-bit float of the wire) reads back as.
    ///
    /// Values beyond the range of the storage saturate here; what a vehicle makes of them is not
    /// defined, so the checks refuse them.
    pub fn keep(self, sent: f32) -> f32 {
        let whole_within = |low: f32, high: f32| {
            if (low..=high).contains(&sent) { sent.trunc() } else { 0.0 }
        };
        match self {
            Self::Dropped => 0.0,
            Self::Float | Self::DegE7 => sent,
            Self::Half => half_precision(sent),
            Self::U8 => f32::from(sent as u8),
            Self::I8 => f32::from(sent as i8),
            Self::U16 => f32::from(sent as u16),
            Self::I16 => f32::from(sent as i16),
            Self::U16Max255 => f32::from((sent as u16).min(255)),
            Self::CentiU16 => f32::from((sent * 100.0) as u16) * 0.01,
            Self::SignedU16 => with_sign(f32::from(sent.abs() as u16), sent),
            Self::Positive => f32::from(u8::from(sent > 0.0)),
            Self::Bit0 => ((sent as u32) & 1) as f32,
            Self::LoiterSign => {
                if sent < 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Self::YawSign => {
                if sent <= -f32::EPSILON {
                    -1.0
                } else {
                    1.0
                }
            }
            Self::Turns => {
                if sent > 0.0 && sent < 1.0 {
                    f32::from((sent * 256.0) as u8) / 256.0
                } else {
                    f32::from(sent.min(255.0) as u8)
                }
            }
            Self::TurnsRadius => {
                let radius_m = sent.abs();
                let kept_m = if radius_m <= 255.0 {
                    f32::from(radius_m as u8)
                } else {
                    f32::from((radius_m * 0.1).min(255.0) as u8) * 10.0
                };
                with_sign(kept_m, sent)
            }
            Self::LowU8 => f32::from(sent as i32 as u8),
            Self::LowI16 => f32::from(sent as i32 as i16),
            Self::Two => 2.0,
            Self::RollDegrees => whole_within(-180.0, 180.0),
            Self::PitchDegrees => whole_within(-90.0, 90.0),
            Self::YawDegrees => whole_within(-180.0, 360.0),
            Self::FenceRadius => {
                if sent - sent.trunc() < 0.001 {
                    sent.trunc()
                } else {
                    sent
                }
            }
            Self::Centimetres => ((sent * 100.0) as i32) as f32 / 100.0,
        }
    }
}

fn with_sign(magnitude: f32, sign: f32) -> f32 {
    if sign < 0.0 { -magnitude } else { magnitude }
}

/// Nearest value that an IEEE 754 half-precision float can hold, as ArduPilot rounds: the lowest twelve
/// bits of the fraction are cut, then half up.
fn half_precision(value: f32) -> f32 {
    const MAX: f32 = 65_504.0;
    if value.is_nan() {
        return value;
    }
    let magnitude = f32::from_bits(value.abs().to_bits() & 0xFFFF_F000);
    // Step of a half float: 2^-10 of the power of two below the value, 2^-24 for subnormals.
    let exponent = (magnitude.to_bits() >> 23) as i32 - 127;
    let step = 2.0_f32.powi(exponent.max(-14) - 10);
    with_sign(((magnitude / step + 0.5).floor() * step).min(MAX), value)
}

words! {
    /// What a value of a parameter that is one of a few stands for.
    ChoiceWord {
        /// Off, no.
        Off = "off",
        /// On, yes.
        On = "on",
        /// To the right.
        Clockwise = "clockwise",
        /// To the left.
        CounterClockwise = "counter-clockwise",
        /// The track after a circle is the line from its centre.
        Centre = "centre",
        /// The track after a circle is the tangent of it.
        Tangent = "tangent",
        /// Speed through the air.
        Airspeed = "airspeed",
        /// Speed over the ground.
        Groundspeed = "groundspeed",
        /// Speed upwards.
        Climb = "climb",
        /// Speed downwards.
        Descent = "descent",
        /// The item is done at any height.
        Whenever = "whenever",
        /// The item is done above its height.
        Above = "above",
        /// The item is done below its height.
        Below = "below",
        /// The lower limit of the fence alone is switched off.
        FloorOff = "floor-off",
        /// The parachute is released.
        Deploy = "deploy",
        /// The gripper opens.
        Release = "release",
        /// The gripper closes.
        Grab = "grab",
        /// A switch's low position.
        Low = "low",
        /// A switch's middle position.
        Middle = "middle",
        /// A switch's high position.
        High = "high",
        /// As a multicopter.
        Hover = "hover",
        /// As a plane.
        Cruise = "cruise",
    }
}

/// A value of a parameter that is one of a few.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = CommandChoiceInfo))]
pub struct Choice {
    /// It.
    pub value: f64,
    /// What it stands for.
    pub word: ChoiceWord,
}

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

/// What one parameter of a command means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParamInfo {
    /// Name to show, English; empty when the command does not use the parameter.
    pub label: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Smallest value that makes sense and is kept.
    pub min: Option<f64>,
    /// Largest value that makes sense and is kept.
    pub max: Option<f64>,
    /// Value to offer for a new item; 0 where none is given.
    pub default: Option<f64>,
    /// What ArduPlane keeps.
    pub storage: Storage,
    /// The values with a meaning each, where it is one of a few: of every flag, and of choices as far as an ArduPlane knows them.
    pub choices: &'static [Choice],
}

impl ParamInfo {
    /// Whether a vehicle can make whole numbers of 32 bits of a value where it does: of what it keeps ([`Storage::converts`]), and of times,
    /// lengths, speeds and angles in thousandths, as which ArduPilot counts some of them once the command is done.
    pub fn takes(&self, value: f64) -> bool {
        let is_measure = !matches!(
            self.unit,
            Unit::None | Unit::Count | Unit::Number | Unit::Item | Unit::Flag | Unit::Choice | Unit::Microseconds
        );
        self.storage.converts(value as f32) && (!is_measure || (value * 1e3).abs() < 2_147_483_648.0)
    }

    /// `true` when the command gives this parameter a meaning.
    pub const fn is_used(&self) -> bool {
        !self.label.is_empty()
    }

    const fn range(mut self, min: Option<f64>, max: Option<f64>) -> Self {
        self.min = min;
        self.max = max;
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
const LAT: ParamInfo = p("Latitude", Unit::Degrees, Storage::DegE7).range(Some(-90.0), Some(90.0));
const LON: ParamInfo = p("Longitude", Unit::Degrees, Storage::DegE7).range(Some(-180.0), Some(180.0));
const ALT: ParamInfo = p("Height", Unit::Metres, Storage::Centimetres).range(Some(-83_000.0), Some(83_000.0));
const NO_ALT: ParamInfo = NONE;
const WHOLE_ALT: ParamInfo = p("Height", Unit::Metres, Storage::I16).range(Some(-32_768.0), Some(32_767.0));

/// What is known of a command that ArduPlane takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandInfo {
    /// Its number.
    pub command: Command,
    /// Name in MAVLink, as in `MAV_CMD_NAV_WAYPOINT`.
    pub name: &'static str,
    /// Name to show, English.
    pub title: &'static str,
    /// What it is for.
    pub category: Category,
    /// `true` when x, y and z are latitude, longitude and height.
    pub has_position: bool,
    /// `true` when a plane flies to that position.
    pub is_destination: bool,
    /// What ArduPlane does with it.
    pub support: Support,
    /// Parameters 1 to 4, x, y, z.
    pub params: [ParamInfo; 7],
}

impl std::fmt::Display for Command {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name.strip_prefix("MAV_CMD_").unwrap_or(name)),
            None => write!(f, "command {}", self.0),
        }
    }
}

impl Command {
    /// 16: Waypoint.
    pub const NAV_WAYPOINT: Self = Self(16);
    /// 17: Loiter (unlimited).
    pub const NAV_LOITER_UNLIM: Self = Self(17);
    /// 18: Loiter (turns).
    pub const NAV_LOITER_TURNS: Self = Self(18);
    /// 19: Loiter (time).
    pub const NAV_LOITER_TIME: Self = Self(19);
    /// 20: Return to launch.
    pub const NAV_RETURN_TO_LAUNCH: Self = Self(20);
    /// 21: Land.
    pub const NAV_LAND: Self = Self(21);
    /// 22: Take off.
    pub const NAV_TAKEOFF: Self = Self(22);
    /// 30: Continue and change height.
    pub const NAV_CONTINUE_AND_CHANGE_ALT: Self = Self(30);
    /// 31: Loiter to height.
    pub const NAV_LOITER_TO_ALT: Self = Self(31);
    /// 36: Arc waypoint.
    pub const NAV_ARC_WAYPOINT: Self = Self(36);
    /// 82: Spline waypoint, which ArduPlane refuses.
    pub const NAV_SPLINE_WAYPOINT: Self = Self(82);
    /// 83: Wait for height (balloon).
    pub const NAV_ALTITUDE_WAIT: Self = Self(83);
    /// 84: VTOL take-off.
    pub const NAV_VTOL_TAKEOFF: Self = Self(84);
    /// 85: VTOL land.
    pub const NAV_VTOL_LAND: Self = Self(85);
    /// 92: Hand over to external control.
    pub const NAV_GUIDED_ENABLE: Self = Self(92);
    /// 93: Delay.
    pub const NAV_DELAY: Self = Self(93);
    /// 94: Place payload.
    pub const NAV_PAYLOAD_PLACE: Self = Self(94);
    /// 112: Wait before next action.
    pub const CONDITION_DELAY: Self = Self(112);
    /// 114: Wait until near next waypoint.
    pub const CONDITION_DISTANCE: Self = Self(114);
    /// 115: Wait for heading.
    pub const CONDITION_YAW: Self = Self(115);
    /// 177: Jump to item.
    pub const DO_JUMP: Self = Self(177);
    /// 178: Change speed.
    pub const DO_CHANGE_SPEED: Self = Self(178);
    /// 179: Set home.
    pub const DO_SET_HOME: Self = Self(179);
    /// 181: Set relay.
    pub const DO_SET_RELAY: Self = Self(181);
    /// 182: Cycle relay.
    pub const DO_REPEAT_RELAY: Self = Self(182);
    /// 183: Set servo.
    pub const DO_SET_SERVO: Self = Self(183);
    /// 184: Cycle servo.
    pub const DO_REPEAT_SERVO: Self = Self(184);
    /// 188: Start of return path.
    pub const DO_RETURN_PATH_START: Self = Self(188);
    /// 189: Start of landing sequence.
    pub const DO_LAND_START: Self = Self(189);
    /// 191: Go around.
    pub const DO_GO_AROUND: Self = Self(191);
    /// 193: Pause or continue.
    pub const DO_PAUSE_CONTINUE: Self = Self(193);
    /// 194: Drive backwards.
    pub const DO_SET_REVERSE: Self = Self(194);
    /// 195: Point camera at place.
    pub const DO_SET_ROI_LOCATION: Self = Self(195);
    /// 197: Point camera freely.
    pub const DO_SET_ROI_NONE: Self = Self(197);
    /// 201: Point camera (legacy).
    pub const DO_SET_ROI: Self = Self(201);
    /// 202: Configure camera.
    pub const DO_DIGICAM_CONFIGURE: Self = Self(202);
    /// 203: Trigger camera.
    pub const DO_DIGICAM_CONTROL: Self = Self(203);
    /// 205: Point gimbal.
    pub const DO_MOUNT_CONTROL: Self = Self(205);
    /// 206: Trigger camera by distance.
    pub const DO_SET_CAM_TRIGG_DIST: Self = Self(206);
    /// 207: Switch fence.
    pub const DO_FENCE_ENABLE: Self = Self(207);
    /// 208: Parachute.
    pub const DO_PARACHUTE: Self = Self(208);
    /// 210: Fly inverted.
    pub const DO_INVERTED_FLIGHT: Self = Self(210);
    /// 211: Gripper.
    pub const DO_GRIPPER: Self = Self(211);
    /// 212: Switch autotune.
    pub const DO_AUTOTUNE_ENABLE: Self = Self(212);
    /// 213: Set heading and speed.
    pub const NAV_SET_YAW_SPEED: Self = Self(213);
    /// 215: Distance to repeat on resume.
    pub const DO_SET_RESUME_REPEAT_DIST: Self = Self(215);
    /// 216: Switch sprayer.
    pub const DO_SPRAYER: Self = Self(216);
    /// 217: Message to script.
    pub const DO_SEND_SCRIPT_MESSAGE: Self = Self(217);
    /// 218: Auxiliary function.
    pub const DO_AUX_FUNCTION: Self = Self(218);
    /// 222: Limits of external control.
    pub const DO_GUIDED_LIMITS: Self = Self(222);
    /// 223: Engine control.
    pub const DO_ENGINE_CONTROL: Self = Self(223);
    /// 531: Zoom camera.
    pub const SET_CAMERA_ZOOM: Self = Self(531);
    /// 532: Focus camera.
    pub const SET_CAMERA_FOCUS: Self = Self(532);
    /// 534: Camera source.
    pub const SET_CAMERA_SOURCE: Self = Self(534);
    /// 600: Jump label.
    pub const JUMP_TAG: Self = Self(600);
    /// 601: Jump to label.
    pub const DO_JUMP_TAG: Self = Self(601);
    /// 1000: Gimbal pitch and yaw.
    pub const DO_GIMBAL_MANAGER_PITCHYAW: Self = Self(1000);
    /// 2000: Take pictures.
    pub const IMAGE_START_CAPTURE: Self = Self(2000);
    /// 2001: Stop taking pictures.
    pub const IMAGE_STOP_CAPTURE: Self = Self(2001);
    /// 2500: Start video.
    pub const VIDEO_START_CAPTURE: Self = Self(2500);
    /// 2501: Stop video.
    pub const VIDEO_STOP_CAPTURE: Self = Self(2501);
    /// 3000: VTOL transition.
    pub const DO_VTOL_TRANSITION: Self = Self(3000);
    /// 5000: Fence return point.
    pub const NAV_FENCE_RETURN_POINT: Self = Self(5000);
    /// 5001: Corner of an inclusion polygon.
    pub const NAV_FENCE_POLYGON_VERTEX_INCLUSION: Self = Self(5001);
    /// 5002: Corner of an exclusion polygon.
    pub const NAV_FENCE_POLYGON_VERTEX_EXCLUSION: Self = Self(5002);
    /// 5003: Inclusion circle.
    pub const NAV_FENCE_CIRCLE_INCLUSION: Self = Self(5003);
    /// 5004: Exclusion circle.
    pub const NAV_FENCE_CIRCLE_EXCLUSION: Self = Self(5004);
    /// 5100: Rally point.
    pub const NAV_RALLY_POINT: Self = Self(5100);
    /// 42600: Winch.
    pub const DO_WINCH: Self = Self(42600);
    /// 42702: Script for a time.
    pub const NAV_SCRIPT_TIME: Self = Self(42702);
    /// 42703: Hold attitude for a time.
    pub const NAV_ATTITUDE_TIME: Self = Self(42703);
    /// Everything known of a command that ArduPlane takes; `None` for the others.
    pub fn info(self) -> Option<&'static CommandInfo> {
        let index = COMMANDS.binary_search_by_key(&self, |info| info.command).ok()?;
        COMMANDS.get(index)
    }

    /// Name in MAVLink, as in `MAV_CMD_NAV_WAYPOINT`; `None` for a number that Vencejo does not know.
    pub fn name(self) -> Option<&'static str> {
        self.info().map(|info| info.name).or_else(|| self.refused().map(|(_, name, _)| *name))
    }

    /// The command of a name, with or without `MAV_CMD_`, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        let bare = |name: &str| {
            let upper = name.trim().to_ascii_uppercase();
            upper.strip_prefix("MAV_CMD_").map(str::to_owned).unwrap_or(upper)
        };
        let wanted = bare(name);
        let known = COMMANDS.iter().map(|info| (info.command, info.name));
        let refused = REFUSED.iter().map(|(number, name, _)| (Self(*number), *name));
        known.chain(refused).find(|(_, name)| bare(name) == wanted).map(|(command, _)| command)
    }

    /// Whether x, y and z are a position; `None` for a number that Vencejo does not know.
    pub fn has_position(self) -> Option<bool> {
        self.info().map(|info| info.has_position).or_else(|| self.refused().map(|(_, _, position)| *position))
    }

    /// `true` when ArduPlane takes it in a mission.
    pub fn is_mission_command(self) -> bool {
        self.info().is_some_and(|info| info.support != Support::List)
    }

    /// `true` when a vehicle flies to the position of the item. Beside the commands of the table that is the spline waypoint of
    /// copters.
    pub fn is_destination(self) -> bool {
        self.info().map_or(self == Self::NAV_SPLINE_WAYPOINT, |info| info.is_destination)
    }

    /// `true` when the mission stands at the item until it is done, and not for an action beside the flying. A number that is in no
    /// table is one up to `MAV_CMD_NAV_LAST`.
    pub fn is_nav(self) -> bool {
        const NAV_LAST: u16 = 95;
        self.info().map_or(self.0 < NAV_LAST, |info| info.category == Category::Nav)
    }

    /// `true` for the landings.
    pub const fn is_landing(self) -> bool {
        matches!(self, Self::NAV_LAND | Self::NAV_VTOL_LAND)
    }

    /// `true` for the take-offs.
    pub const fn is_takeoff(self) -> bool {
        matches!(self, Self::NAV_TAKEOFF | Self::NAV_VTOL_TAKEOFF)
    }

    /// `true` when 0/0 (or unset) coordinates have a meaning: the place where the vehicle is then.
    pub const fn may_stay_in_place(self) -> bool {
        matches!(
            self,
            Self::NAV_TAKEOFF
                | Self::NAV_VTOL_TAKEOFF
                | Self::NAV_LOITER_UNLIM
                | Self::NAV_LOITER_TURNS
                | Self::NAV_LOITER_TIME
                | Self::NAV_LOITER_TO_ALT
                | Self::NAV_CONTINUE_AND_CHANGE_ALT
                | Self::NAV_GUIDED_ENABLE
                | Self::DO_LAND_START
                | Self::DO_RETURN_PATH_START
                | Self::DO_GO_AROUND
                | Self::DO_SET_HOME
        )
    }

    /// `true` when ArduPilot takes NaN in `params[index]` (the heading, mostly); it refuses others.
    pub const fn param_may_be_unset(self, index: usize) -> bool {
        match self {
            Self::NAV_WAYPOINT
            | Self::NAV_LOITER_UNLIM
            | Self::NAV_LAND
            | Self::NAV_TAKEOFF
            | Self::NAV_VTOL_TAKEOFF => index == 3,
            Self::NAV_VTOL_LAND => index == 2 || index == 3,
            _ => false,
        }
    }

    fn refused(self) -> Option<&'static (u16, &'static str, bool)> {
        let index = REFUSED.binary_search_by_key(&self.0, |(number, ..)| *number).ok()?;
        REFUSED.get(index)
    }
}

/// All commands that ArduPlane takes in missions, fences and rally lists, by number.
pub const COMMANDS: &[CommandInfo] = &[
    CommandInfo {
        command: Command::NAV_WAYPOINT,
        name: "MAV_CMD_NAV_WAYPOINT",
        title: "Waypoint",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            p("Hold time", Unit::Seconds, Storage::Dropped).range(Some(0.0), None),
            p("Acceptance radius", Unit::Metres, Storage::U16Max255).range(Some(0.0), Some(255.0)).default(0.0),
            p("Pass by", Unit::Metres, Storage::U16Max255).range(Some(0.0), Some(255.0)).default(0.0),
            p("Heading", Unit::Degrees, Storage::Dropped),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_LOITER_UNLIM,
        name: "MAV_CMD_NAV_LOITER_UNLIM",
        title: "Loiter (unlimited)",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            NONE,
            NONE,
            p("Radius", Unit::Metres, Storage::SignedU16).range(Some(-65535.0), Some(65535.0)).default(0.0),
            p("Heading", Unit::Degrees, Storage::Dropped),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_LOITER_TURNS,
        name: "MAV_CMD_NAV_LOITER_TURNS",
        title: "Loiter (turns)",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            p("Turns", Unit::Count, Storage::Turns).range(Some(0.0), Some(255.0)).default(1.0),
            NONE,
            p("Radius", Unit::Metres, Storage::TurnsRadius).range(Some(-2550.0), Some(2550.0)).default(0.0),
            p("Leave towards next from", Unit::Choice, Storage::Positive)
                .range(Some(0.0), Some(1.0))
                .default(1.0)
                .one_of(EXITS),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_LOITER_TIME,
        name: "MAV_CMD_NAV_LOITER_TIME",
        title: "Loiter (time)",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            p("Time", Unit::Seconds, Storage::U16).range(Some(0.0), Some(65535.0)).default(60.0),
            NONE,
            p("Direction", Unit::Choice, Storage::LoiterSign).default(1.0).one_of(SENSES),
            p("Leave towards next from", Unit::Choice, Storage::Positive)
                .range(Some(0.0), Some(1.0))
                .default(1.0)
                .one_of(EXITS),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_RETURN_TO_LAUNCH,
        name: "MAV_CMD_NAV_RETURN_TO_LAUNCH",
        title: "Return to launch",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [NONE, NONE, NONE, NONE, NONE, NONE, NONE],
    },
    CommandInfo {
        command: Command::NAV_LAND,
        name: "MAV_CMD_NAV_LAND",
        title: "Land",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            p("Abort height", Unit::Metres, Storage::U16).range(Some(0.0), Some(32_767.0)).default(0.0),
            NONE,
            NONE,
            p("Turn direction (deep stall)", Unit::Choice, Storage::YawSign),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_TAKEOFF,
        name: "MAV_CMD_NAV_TAKEOFF",
        title: "Take off",
        category: Category::Nav,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Minimum pitch", Unit::Degrees, Storage::U16).range(Some(0.0), Some(90.0)).default(15.0),
            NONE,
            NONE,
            p("Heading", Unit::Degrees, Storage::Dropped),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_CONTINUE_AND_CHANGE_ALT,
        name: "MAV_CMD_NAV_CONTINUE_AND_CHANGE_ALT",
        title: "Continue and change height",
        category: Category::Nav,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Done when", Unit::Choice, Storage::U16).range(Some(0.0), Some(2.0)).default(0.0).one_of(DONE_WHEN),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_LOITER_TO_ALT,
        name: "MAV_CMD_NAV_LOITER_TO_ALT",
        title: "Loiter to height",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Flown,
        params: [
            p("Heading required", Unit::Flag, Storage::Dropped).range(Some(0.0), Some(1.0)),
            p("Radius", Unit::Metres, Storage::SignedU16).range(Some(-65535.0), Some(65535.0)).default(0.0),
            NONE,
            p("Leave towards next from", Unit::Choice, Storage::Positive)
                .range(Some(0.0), Some(1.0))
                .default(1.0)
                .one_of(EXITS),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_ARC_WAYPOINT,
        name: "MAV_CMD_NAV_ARC_WAYPOINT",
        title: "Arc waypoint",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::Ignored,
        params: [
            p("Arc angle", Unit::Degrees, Storage::SignedU16).range(Some(-359.0), Some(359.0)).default(90.0),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_ALTITUDE_WAIT,
        name: "MAV_CMD_NAV_ALTITUDE_WAIT",
        title: "Wait for height (balloon)",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Height above sea level", Unit::Metres, Storage::Float),
            p("Descent speed", Unit::MetresPerSecond, Storage::Float).range(Some(0.0), None),
            p("Servo wiggle period", Unit::Seconds, Storage::U8).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::NAV_VTOL_TAKEOFF,
        name: "MAV_CMD_NAV_VTOL_TAKEOFF",
        title: "VTOL take-off",
        category: Category::Nav,
        has_position: true,
        // It goes straight up (`QuadPlane::do_vtol_takeoff`).
        is_destination: false,
        support: Support::NeedsVtol,
        params: [
            NONE,
            p("Transition heading", Unit::Choice, Storage::Dropped),
            NONE,
            p("Heading", Unit::Degrees, Storage::Dropped),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_VTOL_LAND,
        name: "MAV_CMD_NAV_VTOL_LAND",
        title: "VTOL land",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::NeedsVtol,
        params: [
            p("Options", Unit::Choice, Storage::U16).range(Some(0.0), Some(65535.0)).default(0.0),
            NONE,
            p("Approach height", Unit::Metres, Storage::Dropped),
            p("Heading", Unit::Degrees, Storage::Dropped),
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_GUIDED_ENABLE,
        name: "MAV_CMD_NAV_GUIDED_ENABLE",
        title: "Hand over to external control",
        category: Category::Nav,
        has_position: true,
        is_destination: false,
        support: Support::Ignored,
        params: [p("On", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)), NONE, NONE, NONE, LAT, LON, ALT],
    },
    CommandInfo {
        command: Command::NAV_DELAY,
        name: "MAV_CMD_NAV_DELAY",
        title: "Delay",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Delay", Unit::Seconds, Storage::Float).range(Some(-1.0), None),
            p("Hour (UTC)", Unit::Hours, Storage::I8).range(Some(-1.0), Some(23.0)).default(-1.0),
            p("Minute (UTC)", Unit::Minutes, Storage::I8).range(Some(-1.0), Some(59.0)).default(-1.0),
            p("Second (UTC)", Unit::Seconds, Storage::I8).range(Some(-1.0), Some(59.0)).default(-1.0),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::NAV_PAYLOAD_PLACE,
        name: "MAV_CMD_NAV_PAYLOAD_PLACE",
        title: "Place payload",
        category: Category::Nav,
        has_position: true,
        is_destination: true,
        support: Support::NeedsVtol,
        params: [
            p("Largest descent", Unit::Metres, Storage::CentiU16).range(Some(0.0), Some(655.35)),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::CONDITION_DELAY,
        name: "MAV_CMD_CONDITION_DELAY",
        title: "Wait before next action",
        category: Category::Condition,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [p("Delay", Unit::Seconds, Storage::Float).range(Some(0.0), None), NONE, NONE, NONE, NONE, NONE, NONE],
    },
    CommandInfo {
        command: Command::CONDITION_DISTANCE,
        name: "MAV_CMD_CONDITION_DISTANCE",
        title: "Wait until near next waypoint",
        category: Category::Condition,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Distance", Unit::Metres, Storage::Float).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::CONDITION_YAW,
        name: "MAV_CMD_CONDITION_YAW",
        title: "Wait for heading",
        category: Category::Condition,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Heading", Unit::Degrees, Storage::Float).range(Some(0.0), Some(360.0)),
            p("Turn rate", Unit::DegreesPerSecond, Storage::Float).range(Some(0.0), None),
            p("Direction", Unit::Choice, Storage::I8).range(Some(-1.0), Some(1.0)),
            p("Relative", Unit::Flag, Storage::U8).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_JUMP,
        name: "MAV_CMD_DO_JUMP",
        title: "Jump to item",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Item", Unit::Item, Storage::U16).range(Some(1.0), Some(65535.0)).default(1.0),
            p("Repeats", Unit::Count, Storage::I16).range(Some(-1.0), Some(32767.0)).default(1.0),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_CHANGE_SPEED,
        name: "MAV_CMD_DO_CHANGE_SPEED",
        title: "Change speed",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Kind of speed", Unit::Choice, Storage::U8).range(Some(0.0), Some(3.0)).default(0.0).one_of(SPEEDS),
            p("Speed", Unit::MetresPerSecond, Storage::Float).range(Some(-2.0), None).default(15.0),
            // −1: the throttle stays as it is
            p("Throttle", Unit::Percent, Storage::Float).range(Some(-2.0), Some(100.0)).default(-1.0),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_HOME,
        name: "MAV_CMD_DO_SET_HOME",
        title: "Set home",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Use current position", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)).default(0.0),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_RELAY,
        name: "MAV_CMD_DO_SET_RELAY",
        title: "Set relay",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Relay", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("State", Unit::Flag, Storage::U8).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_REPEAT_RELAY,
        name: "MAV_CMD_DO_REPEAT_RELAY",
        title: "Cycle relay",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Relay", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Repeats", Unit::Count, Storage::I16).range(Some(0.0), Some(32767.0)),
            p("Cycle time", Unit::Seconds, Storage::Float).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_SERVO,
        name: "MAV_CMD_DO_SET_SERVO",
        title: "Set servo",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Servo", Unit::Number, Storage::U8).range(Some(1.0), Some(255.0)),
            p("Pulse", Unit::Microseconds, Storage::U16).range(Some(0.0), Some(65535.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_REPEAT_SERVO,
        name: "MAV_CMD_DO_REPEAT_SERVO",
        title: "Cycle servo",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Servo", Unit::Number, Storage::U8).range(Some(1.0), Some(255.0)),
            p("Pulse", Unit::Microseconds, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Repeats", Unit::Count, Storage::I16).range(Some(0.0), Some(32767.0)),
            p("Cycle time", Unit::Seconds, Storage::Float).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_RETURN_PATH_START,
        name: "MAV_CMD_DO_RETURN_PATH_START",
        title: "Start of return path",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [NONE, NONE, NONE, NONE, LAT, LON, ALT],
    },
    CommandInfo {
        command: Command::DO_LAND_START,
        name: "MAV_CMD_DO_LAND_START",
        title: "Start of landing sequence",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [NONE, NONE, NONE, NONE, LAT, LON, ALT],
    },
    CommandInfo {
        command: Command::DO_GO_AROUND,
        name: "MAV_CMD_DO_GO_AROUND",
        title: "Go around",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Ignored,
        params: [p("Height", Unit::Metres, Storage::Dropped), NONE, NONE, NONE, LAT, LON, ALT],
    },
    CommandInfo {
        command: Command::DO_PAUSE_CONTINUE,
        name: "MAV_CMD_DO_PAUSE_CONTINUE",
        title: "Pause or continue",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Continue", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_REVERSE,
        name: "MAV_CMD_DO_SET_REVERSE",
        title: "Drive backwards",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Backwards", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_ROI_LOCATION,
        name: "MAV_CMD_DO_SET_ROI_LOCATION",
        title: "Point camera at place",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Gimbal", Unit::Number, Storage::U16).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            ALT,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_ROI_NONE,
        name: "MAV_CMD_DO_SET_ROI_NONE",
        title: "Point camera freely",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Gimbal", Unit::Number, Storage::U16).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_ROI,
        name: "MAV_CMD_DO_SET_ROI",
        title: "Point camera (legacy)",
        category: Category::Do,
        has_position: true,
        is_destination: false,
        support: Support::Flown,
        params: [p("Mode", Unit::Choice, Storage::U16).range(Some(0.0), Some(4.0)), NONE, NONE, NONE, LAT, LON, ALT],
    },
    CommandInfo {
        command: Command::DO_DIGICAM_CONFIGURE,
        name: "MAV_CMD_DO_DIGICAM_CONFIGURE",
        title: "Configure camera",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Mode", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Shutter speed", Unit::None, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Aperture", Unit::None, Storage::U8).range(Some(0.0), Some(255.0)),
            p("ISO", Unit::None, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Exposure type", Unit::Choice, Storage::LowU8),
            p("Command identity", Unit::Number, Storage::LowU8),
            p("Engine cut-off", Unit::Seconds, Storage::Float),
        ],
    },
    CommandInfo {
        command: Command::DO_DIGICAM_CONTROL,
        name: "MAV_CMD_DO_DIGICAM_CONTROL",
        title: "Trigger camera",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Session", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Zoom position", Unit::None, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Zoom step", Unit::None, Storage::I8).range(Some(-128.0), Some(127.0)),
            p("Focus lock", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Shoot", Unit::Flag, Storage::LowU8),
            p("Command identity", Unit::Number, Storage::LowU8),
            p("Shot identity", Unit::Number, Storage::Dropped),
        ],
    },
    CommandInfo {
        command: Command::DO_MOUNT_CONTROL,
        name: "MAV_CMD_DO_MOUNT_CONTROL",
        title: "Point gimbal",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Pitch", Unit::Degrees, Storage::Float),
            p("Roll", Unit::Degrees, Storage::Float),
            p("Yaw", Unit::Degrees, Storage::Float),
            NONE,
            NONE,
            NONE,
            p("Mode", Unit::Choice, Storage::Two),
        ],
    },
    CommandInfo {
        command: Command::DO_SET_CAM_TRIGG_DIST,
        name: "MAV_CMD_DO_SET_CAM_TRIGG_DIST",
        title: "Trigger camera by distance",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Distance", Unit::Metres, Storage::Float).range(Some(0.0), None),
            NONE,
            p("Trigger at once", Unit::Flag, Storage::U8).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_FENCE_ENABLE,
        name: "MAV_CMD_DO_FENCE_ENABLE",
        title: "Switch fence",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Action", Unit::Choice, Storage::U16).range(Some(0.0), Some(3.0)).one_of(FENCE_ACTIONS),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_PARACHUTE,
        name: "MAV_CMD_DO_PARACHUTE",
        title: "Parachute",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Action", Unit::Choice, Storage::U16).range(Some(0.0), Some(2.0)).one_of(PARACHUTE_ACTIONS),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_INVERTED_FLIGHT,
        name: "MAV_CMD_DO_INVERTED_FLIGHT",
        title: "Fly inverted",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Inverted", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_GRIPPER,
        name: "MAV_CMD_DO_GRIPPER",
        title: "Gripper",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Gripper", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Action", Unit::Choice, Storage::U8).range(Some(0.0), Some(1.0)).one_of(GRIPPER_ACTIONS),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_AUTOTUNE_ENABLE,
        name: "MAV_CMD_DO_AUTOTUNE_ENABLE",
        title: "Switch autotune",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [p("On", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)), NONE, NONE, NONE, NONE, NONE, NONE],
    },
    CommandInfo {
        command: Command::NAV_SET_YAW_SPEED,
        name: "MAV_CMD_NAV_SET_YAW_SPEED",
        title: "Set heading and speed",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Heading", Unit::Degrees, Storage::Float),
            p("Speed", Unit::MetresPerSecond, Storage::Float),
            p("Relative", Unit::Flag, Storage::U8).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SET_RESUME_REPEAT_DIST,
        name: "MAV_CMD_DO_SET_RESUME_REPEAT_DIST",
        title: "Distance to repeat on resume",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Distance", Unit::Metres, Storage::U16).range(Some(0.0), Some(65535.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_SPRAYER,
        name: "MAV_CMD_DO_SPRAYER",
        title: "Switch sprayer",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [p("On", Unit::Flag, Storage::U16).range(Some(0.0), Some(1.0)), NONE, NONE, NONE, NONE, NONE, NONE],
    },
    CommandInfo {
        command: Command::DO_SEND_SCRIPT_MESSAGE,
        name: "MAV_CMD_DO_SEND_SCRIPT_MESSAGE",
        title: "Message to script",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Message", Unit::Number, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Value 1", Unit::None, Storage::Float),
            p("Value 2", Unit::None, Storage::Float),
            p("Value 3", Unit::None, Storage::Float),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_AUX_FUNCTION,
        name: "MAV_CMD_DO_AUX_FUNCTION",
        title: "Auxiliary function",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Function", Unit::Choice, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Switch position", Unit::Choice, Storage::U8).range(Some(0.0), Some(2.0)).one_of(SWITCH_POSITIONS),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_GUIDED_LIMITS,
        name: "MAV_CMD_DO_GUIDED_LIMITS",
        title: "Limits of external control",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Longest time", Unit::Seconds, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Lowest height", Unit::Metres, Storage::Float),
            p("Greatest height", Unit::Metres, Storage::Float),
            p("Farthest", Unit::Metres, Storage::Float).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_ENGINE_CONTROL,
        name: "MAV_CMD_DO_ENGINE_CONTROL",
        title: "Engine control",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Start", Unit::Flag, Storage::Positive).range(Some(0.0), Some(1.0)),
            p("Cold start", Unit::Flag, Storage::Positive).range(Some(0.0), Some(1.0)),
            p("Start above", Unit::Metres, Storage::CentiU16).range(Some(0.0), Some(655.35)),
            p("Options", Unit::Choice, Storage::Bit0).range(Some(0.0), Some(1.0)),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::SET_CAMERA_ZOOM,
        name: "MAV_CMD_SET_CAMERA_ZOOM",
        title: "Zoom camera",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Kind", Unit::Choice, Storage::U8).range(Some(0.0), Some(3.0)),
            p("Value", Unit::None, Storage::Float),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::SET_CAMERA_FOCUS,
        name: "MAV_CMD_SET_CAMERA_FOCUS",
        title: "Focus camera",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Kind", Unit::Choice, Storage::U8).range(Some(0.0), Some(7.0)),
            p("Value", Unit::None, Storage::Float),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::SET_CAMERA_SOURCE,
        name: "MAV_CMD_SET_CAMERA_SOURCE",
        title: "Camera source",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Camera", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Primary source", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Secondary source", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::JUMP_TAG,
        name: "MAV_CMD_JUMP_TAG",
        title: "Jump label",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Label", Unit::Number, Storage::U16).range(Some(0.0), Some(65535.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_JUMP_TAG,
        name: "MAV_CMD_DO_JUMP_TAG",
        title: "Jump to label",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Label", Unit::Number, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Repeats", Unit::Count, Storage::I16).range(Some(-1.0), Some(32767.0)).default(1.0),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_GIMBAL_MANAGER_PITCHYAW,
        name: "MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW",
        title: "Gimbal pitch and yaw",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Pitch", Unit::Degrees, Storage::I8).range(Some(-128.0), Some(127.0)),
            p("Yaw", Unit::Degrees, Storage::I16).range(Some(-32768.0), Some(32767.0)),
            p("Pitch rate", Unit::DegreesPerSecond, Storage::I8).range(Some(-128.0), Some(127.0)),
            p("Yaw rate", Unit::DegreesPerSecond, Storage::I8).range(Some(-128.0), Some(127.0)),
            p("Flags", Unit::Choice, Storage::LowU8),
            NONE,
            p("Gimbal", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
        ],
    },
    CommandInfo {
        command: Command::IMAGE_START_CAPTURE,
        name: "MAV_CMD_IMAGE_START_CAPTURE",
        title: "Take pictures",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Camera", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Interval", Unit::Seconds, Storage::Float).range(Some(0.0), None),
            p("Pictures", Unit::Count, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("First number", Unit::Number, Storage::U16).range(Some(0.0), Some(65535.0)),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::IMAGE_STOP_CAPTURE,
        name: "MAV_CMD_IMAGE_STOP_CAPTURE",
        title: "Stop taking pictures",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Camera", Unit::Number, Storage::U16).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::VIDEO_START_CAPTURE,
        name: "MAV_CMD_VIDEO_START_CAPTURE",
        title: "Start video",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Stream", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Status rate", Unit::Hertz, Storage::Dropped).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::VIDEO_STOP_CAPTURE,
        name: "MAV_CMD_VIDEO_STOP_CAPTURE",
        title: "Stop video",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Stream", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::DO_VTOL_TRANSITION,
        name: "MAV_CMD_DO_VTOL_TRANSITION",
        title: "VTOL transition",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::NeedsVtol,
        params: [
            p("State", Unit::Choice, Storage::U8).range(Some(3.0), Some(4.0)).one_of(VTOL_STATES),
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::NAV_FENCE_RETURN_POINT,
        name: "MAV_CMD_NAV_FENCE_RETURN_POINT",
        title: "Fence return point",
        category: Category::Fence,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [NONE, NONE, NONE, NONE, LAT, LON, NO_ALT],
    },
    CommandInfo {
        command: Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION,
        name: "MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION",
        title: "Corner of an inclusion polygon",
        category: Category::Fence,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [
            p("Corners", Unit::Count, Storage::U8).range(Some(3.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            NO_ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
        name: "MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION",
        title: "Corner of an exclusion polygon",
        category: Category::Fence,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [
            p("Corners", Unit::Count, Storage::U8).range(Some(3.0), Some(255.0)),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            NO_ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_FENCE_CIRCLE_INCLUSION,
        name: "MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION",
        title: "Inclusion circle",
        category: Category::Fence,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [
            p("Radius", Unit::Metres, Storage::FenceRadius).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            NO_ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_FENCE_CIRCLE_EXCLUSION,
        name: "MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION",
        title: "Exclusion circle",
        category: Category::Fence,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [
            p("Radius", Unit::Metres, Storage::FenceRadius).range(Some(0.0), None),
            NONE,
            NONE,
            NONE,
            LAT,
            LON,
            NO_ALT,
        ],
    },
    CommandInfo {
        command: Command::NAV_RALLY_POINT,
        name: "MAV_CMD_NAV_RALLY_POINT",
        title: "Rally point",
        category: Category::Rally,
        has_position: true,
        is_destination: false,
        support: Support::List,
        params: [NONE, NONE, NONE, NONE, LAT, LON, WHOLE_ALT],
    },
    CommandInfo {
        command: Command::DO_WINCH,
        name: "MAV_CMD_DO_WINCH",
        title: "Winch",
        category: Category::Do,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Winch", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Action", Unit::Choice, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Length", Unit::Metres, Storage::Float),
            p("Speed", Unit::MetresPerSecond, Storage::Float),
            NONE,
            NONE,
            NONE,
        ],
    },
    CommandInfo {
        command: Command::NAV_SCRIPT_TIME,
        name: "MAV_CMD_NAV_SCRIPT_TIME",
        title: "Script for a time",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Flown,
        params: [
            p("Script command", Unit::Number, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Time-out", Unit::Seconds, Storage::U8).range(Some(0.0), Some(255.0)),
            p("Value 1", Unit::None, Storage::Half).range(Some(-65504.0), Some(65504.0)),
            p("Value 2", Unit::None, Storage::Half).range(Some(-65504.0), Some(65504.0)),
            p("Value 3", Unit::None, Storage::LowI16).range(Some(-32768.0), Some(32767.0)),
            p("Value 4", Unit::None, Storage::LowI16).range(Some(-32768.0), Some(32767.0)),
            NONE,
        ],
    },
    CommandInfo {
        command: Command::NAV_ATTITUDE_TIME,
        name: "MAV_CMD_NAV_ATTITUDE_TIME",
        title: "Hold attitude for a time",
        category: Category::Nav,
        has_position: false,
        is_destination: false,
        support: Support::Ignored,
        params: [
            p("Time", Unit::Seconds, Storage::U16).range(Some(0.0), Some(65535.0)),
            p("Roll", Unit::Degrees, Storage::RollDegrees).range(Some(-180.0), Some(180.0)),
            p("Pitch", Unit::Degrees, Storage::PitchDegrees).range(Some(-90.0), Some(90.0)),
            p("Yaw", Unit::Degrees, Storage::YawDegrees).range(Some(-180.0), Some(360.0)),
            p("Climb rate", Unit::MetresPerSecond, Storage::LowI16),
            NONE,
            NONE,
        ],
    },
];

/// Commands that ArduPlane refuses in a plan (`MAV_MISSION_UNSUPPORTED`): number, name, whether they have
/// a position. Known so that a plan that holds one can be read, shown and explained.
pub const REFUSED: &[(u16, &str, bool)] = &[
    (23, "MAV_CMD_NAV_LAND_LOCAL", true),
    (24, "MAV_CMD_NAV_TAKEOFF_LOCAL", true),
    (25, "MAV_CMD_NAV_FOLLOW", true),
    (32, "MAV_CMD_DO_FOLLOW", false),
    (33, "MAV_CMD_DO_FOLLOW_REPOSITION", false),
    (34, "MAV_CMD_DO_ORBIT", false),
    (35, "MAV_CMD_DO_FIGURE_EIGHT", false),
    (80, "MAV_CMD_NAV_ROI", true),
    (81, "MAV_CMD_NAV_PATHPLANNING", true),
    (82, "MAV_CMD_NAV_SPLINE_WAYPOINT", true),
    (95, "MAV_CMD_NAV_LAST", false),
    (113, "MAV_CMD_CONDITION_CHANGE_ALT", false),
    (159, "MAV_CMD_CONDITION_LAST", false),
    (176, "MAV_CMD_DO_SET_MODE", false),
    (180, "MAV_CMD_DO_SET_PARAMETER", false),
    (185, "MAV_CMD_DO_FLIGHTTERMINATION", false),
    (186, "MAV_CMD_DO_CHANGE_ALTITUDE", false),
    (187, "MAV_CMD_DO_SET_ACTUATOR", false),
    (190, "MAV_CMD_DO_RALLY_LAND", false),
    (192, "MAV_CMD_DO_REPOSITION", true),
    (196, "MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET", false),
    (198, "MAV_CMD_DO_SET_ROI_SYSID", false),
    (200, "MAV_CMD_DO_CONTROL_VIDEO", false),
    (204, "MAV_CMD_DO_MOUNT_CONFIGURE", false),
    (209, "MAV_CMD_DO_MOTOR_TEST", false),
    (214, "MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL", false),
    (220, "MAV_CMD_DO_MOUNT_CONTROL_QUAT", false),
    (221, "MAV_CMD_DO_GUIDED_MASTER", false),
    (224, "MAV_CMD_DO_SET_MISSION_CURRENT", false),
    (240, "MAV_CMD_DO_LAST", false),
    (241, "MAV_CMD_PREFLIGHT_CALIBRATION", false),
    (242, "MAV_CMD_PREFLIGHT_SET_SENSOR_OFFSETS", false),
    (243, "MAV_CMD_PREFLIGHT_UAVCAN", false),
    (245, "MAV_CMD_PREFLIGHT_STORAGE", false),
    (246, "MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN", false),
    (252, "MAV_CMD_OVERRIDE_GOTO", true),
    (260, "MAV_CMD_OBLIQUE_SURVEY", false),
    (262, "MAV_CMD_DO_SET_STANDARD_MODE", false),
    (300, "MAV_CMD_MISSION_START", false),
    (310, "MAV_CMD_ACTUATOR_TEST", false),
    (311, "MAV_CMD_CONFIGURE_ACTUATOR", false),
    (400, "MAV_CMD_COMPONENT_ARM_DISARM", false),
    (401, "MAV_CMD_RUN_PREARM_CHECKS", false),
    (405, "MAV_CMD_ILLUMINATOR_ON_OFF", false),
    (406, "MAV_CMD_DO_ILLUMINATOR_CONFIGURE", false),
    (410, "MAV_CMD_GET_HOME_POSITION", false),
    (420, "MAV_CMD_INJECT_FAILURE", false),
    (500, "MAV_CMD_START_RX_PAIR", false),
    (510, "MAV_CMD_GET_MESSAGE_INTERVAL", false),
    (511, "MAV_CMD_SET_MESSAGE_INTERVAL", false),
    (512, "MAV_CMD_REQUEST_MESSAGE", false),
    (519, "MAV_CMD_REQUEST_PROTOCOL_VERSION", false),
    (520, "MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES", false),
    (521, "MAV_CMD_REQUEST_CAMERA_INFORMATION", false),
    (522, "MAV_CMD_REQUEST_CAMERA_SETTINGS", false),
    (525, "MAV_CMD_REQUEST_STORAGE_INFORMATION", false),
    (526, "MAV_CMD_STORAGE_FORMAT", false),
    (527, "MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS", false),
    (528, "MAV_CMD_REQUEST_FLIGHT_INFORMATION", false),
    (529, "MAV_CMD_RESET_CAMERA_SETTINGS", false),
    (530, "MAV_CMD_SET_CAMERA_MODE", false),
    (533, "MAV_CMD_SET_STORAGE_USAGE", false),
    (1001, "MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE", false),
    (2003, "MAV_CMD_DO_TRIGGER_CONTROL", false),
    (2004, "MAV_CMD_CAMERA_TRACK_POINT", false),
    (2005, "MAV_CMD_CAMERA_TRACK_RECTANGLE", false),
    (2010, "MAV_CMD_CAMERA_STOP_TRACKING", false),
    (2502, "MAV_CMD_VIDEO_START_STREAMING", false),
    (2503, "MAV_CMD_VIDEO_STOP_STREAMING", false),
    (2504, "MAV_CMD_REQUEST_VIDEO_STREAM_INFORMATION", false),
    (2505, "MAV_CMD_REQUEST_VIDEO_STREAM_STATUS", false),
    (2510, "MAV_CMD_LOGGING_START", false),
    (2511, "MAV_CMD_LOGGING_STOP", false),
    (2520, "MAV_CMD_AIRFRAME_CONFIGURATION", false),
    (2600, "MAV_CMD_CONTROL_HIGH_LATENCY", false),
    (2800, "MAV_CMD_PANORAMA_CREATE", false),
    (3001, "MAV_CMD_ARM_AUTHORIZATION_REQUEST", false),
    (4000, "MAV_CMD_SET_GUIDED_SUBMODE_STANDARD", false),
    (4001, "MAV_CMD_SET_GUIDED_SUBMODE_CIRCLE", true),
    (5200, "MAV_CMD_UAVCAN_GET_NODE_INFO", false),
    (5300, "MAV_CMD_DO_SET_SAFETY_SWITCH_STATE", false),
    (10001, "MAV_CMD_DO_ADSB_OUT_IDENT", false),
    (30001, "MAV_CMD_PAYLOAD_PREPARE_DEPLOY", true),
    (30002, "MAV_CMD_PAYLOAD_CONTROL_DEPLOY", false),
    (31000, "MAV_CMD_WAYPOINT_USER_1", true),
    (31001, "MAV_CMD_WAYPOINT_USER_2", true),
    (31002, "MAV_CMD_WAYPOINT_USER_3", true),
    (31003, "MAV_CMD_WAYPOINT_USER_4", true),
    (31004, "MAV_CMD_WAYPOINT_USER_5", true),
    (31005, "MAV_CMD_SPATIAL_USER_1", true),
    (31006, "MAV_CMD_SPATIAL_USER_2", true),
    (31007, "MAV_CMD_SPATIAL_USER_3", true),
    (31008, "MAV_CMD_SPATIAL_USER_4", true),
    (31009, "MAV_CMD_SPATIAL_USER_5", true),
    (31010, "MAV_CMD_USER_1", false),
    (31011, "MAV_CMD_USER_2", false),
    (31012, "MAV_CMD_USER_3", false),
    (31013, "MAV_CMD_USER_4", false),
    (31014, "MAV_CMD_USER_5", false),
    (32000, "MAV_CMD_CAN_FORWARD", false),
    (42000, "MAV_CMD_POWER_OFF_INITIATED", false),
    (42001, "MAV_CMD_SOLO_BTN_FLY_CLICK", false),
    (42002, "MAV_CMD_SOLO_BTN_FLY_HOLD", false),
    (42003, "MAV_CMD_SOLO_BTN_PAUSE_CLICK", false),
    (42004, "MAV_CMD_FIXED_MAG_CAL", false),
    (42005, "MAV_CMD_FIXED_MAG_CAL_FIELD", false),
    (42006, "MAV_CMD_FIXED_MAG_CAL_YAW", true),
    (42007, "MAV_CMD_SET_EKF_SOURCE_SET", false),
    (42424, "MAV_CMD_DO_START_MAG_CAL", false),
    (42425, "MAV_CMD_DO_ACCEPT_MAG_CAL", false),
    (42426, "MAV_CMD_DO_CANCEL_MAG_CAL", false),
    (42427, "MAV_CMD_SET_FACTORY_TEST_MODE", false),
    (42428, "MAV_CMD_DO_SEND_BANNER", false),
    (42429, "MAV_CMD_ACCELCAL_VEHICLE_POS", false),
    (42501, "MAV_CMD_GIMBAL_RESET", false),
    (42502, "MAV_CMD_GIMBAL_AXIS_CALIBRATION_STATUS", false),
    (42503, "MAV_CMD_GIMBAL_REQUEST_AXIS_CALIBRATION", false),
    (42505, "MAV_CMD_GIMBAL_FULL_RESET", false),
    (42650, "MAV_CMD_FLASH_BOOTLOADER", false),
    (42651, "MAV_CMD_BATTERY_RESET", false),
    (42700, "MAV_CMD_DEBUG_TRAP", false),
    (42701, "MAV_CMD_SCRIPTING", false),
    (43000, "MAV_CMD_GUIDED_CHANGE_SPEED", false),
    (43001, "MAV_CMD_GUIDED_CHANGE_ALTITUDE", false),
    (43002, "MAV_CMD_GUIDED_CHANGE_HEADING", false),
    (43003, "MAV_CMD_EXTERNAL_POSITION_ESTIMATE", true),
    (43005, "MAV_CMD_SET_HAGL", false),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted_and_disjoint() {
        assert!(COMMANDS.windows(2).all(|pair| pair[0].command < pair[1].command));
        assert!(REFUSED.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(REFUSED.iter().all(|(number, ..)| Command(*number).info().is_none()));
        assert!(COMMANDS.iter().all(|info| info.name.starts_with("MAV_CMD_") && !info.title.is_empty()));
    }

    #[test]
    fn a_default_lies_in_its_range_and_is_kept() {
        let mut checked = 0;
        for info in COMMANDS {
            for param in info.params {
                let Some(default) = param.default else { continue };
                assert!(param.min.is_none_or(|min| default >= min), "{}", info.name);
                assert!(param.max.is_none_or(|max| default <= max), "{}", info.name);
                let kept = f64::from(param.storage.keep(default as f32));
                assert_eq!(kept, default, "{} {}", info.name, param.label);
                checked += 1;
            }
        }
        assert!(checked > 15);
    }

    #[test]
    fn one_table_says_where_a_mission_stands_and_what_is_flown_to() {
        let nav = |number: u16| Command(number).is_nav();
        assert!([16, 20, 22, 25, 82, 83, 92, 93, 94, 213, 42_702].into_iter().all(nav));
        assert!(![95, 112, 177, 178, 189, 195, 5_001, 9_999].into_iter().any(nav));
        let flown: Vec<u16> = (0..=u16::MAX).filter(|number| Command(*number).is_destination()).collect();
        assert_eq!(flown, [16, 17, 18, 19, 21, 31, 36, 82, 85, 94]);
        assert!(flown.into_iter().all(nav));
    }

    #[test]
    fn names_go_both_ways() {
        assert_eq!(Command::from_name("nav_waypoint"), Some(Command::NAV_WAYPOINT));
        assert_eq!(Command::from_name("MAV_CMD_DO_JUMP"), Some(Command::DO_JUMP));
        assert_eq!(Command::from_name("MAV_CMD_NAV_SPLINE_WAYPOINT"), Some(Command(82)));
        assert_eq!(Command::from_name("fly away"), None);
        for info in COMMANDS {
            assert_eq!(Command::from_name(info.name), Some(info.command));
        }
        assert_eq!(Command(16).to_string(), "NAV_WAYPOINT");
        assert_eq!(Command(9999).to_string(), "command 9999");
    }

    #[test]
    fn loiter_turns_keep_a_byte_of_turns_and_a_byte_of_radius() {
        let turns = |v| Storage::Turns.keep(v);
        assert_eq!(
            [turns(0.0), turns(0.5), turns(0.999), turns(1.0), turns(2.75), turns(300.0)],
            [0.0, 0.5, 255.0 / 256.0, 1.0, 2.0, 255.0]
        );
        let radius = |v| Storage::TurnsRadius.keep(v);
        assert_eq!([radius(80.9), radius(-80.9), radius(255.0), radius(256.0)], [80.0, -80.0, 255.0, 250.0]);
        assert_eq!([radius(-1234.0), radius(9999.0)], [-1230.0, 2550.0]);
    }

    #[test]
    fn half_floats_round_as_the_vehicle_does() {
        // Bit patterns of IEEE 754 binary16: 3.75 and 4.5 are exact, 0.1 becomes 0x2E66.
        for exact in [0.0, 1.0, -2.0, 3.75, 4.5, 0.25, 65_504.0] {
            assert_eq!(half_precision(exact), exact);
        }
        assert_eq!(half_precision(0.1), 0.099_975_586);
        assert_eq!(half_precision(1000.7), 1000.5);
        assert_eq!(half_precision(1e9), 65_504.0);
    }
}
