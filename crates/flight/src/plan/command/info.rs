//! The description of a command: its number, category, support and parameters.

use super::storage::Storage;
use crate::words::words;

/// A `MAV_CMD` number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Command(pub u16);

/// Category of a command.
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

/// How an ArduPlane treats a command in a mission.
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
    /// Symbol to show after a value; empty for a unit without one.
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

words! {
    /// Meaning of an enumerated parameter value.
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

/// A value of an enumerated parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = CommandChoiceInfo))]
pub struct Choice {
    /// The value.
    pub value: f64,
    /// Its meaning.
    pub word: ChoiceWord,
}

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
    /// Value to offer for a new item; `None`: 0.
    pub default: Option<f64>,
    /// How ArduPlane stores it.
    pub storage: Storage,
    /// The values with a meaning each, where it is one of a few: of every flag, and of choices as far as an ArduPlane
    /// knows them.
    pub choices: &'static [Choice],
}

impl ParamInfo {
    /// Whether a vehicle can make whole numbers of 32 bits of a value where it does: of what it keeps
    /// ([`Storage::converts`]), and of times, lengths, speeds and angles in thousandths, as which ArduPilot counts some
    /// of them once the command is done.
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
}

/// Description of a command that ArduPlane takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandInfo {
    /// Its number.
    pub command: Command,
    /// Name in MAVLink, as in `MAV_CMD_NAV_WAYPOINT`.
    pub name: &'static str,
    /// Name to show, English.
    pub title: &'static str,
    /// Its category.
    pub category: Category,
    /// `true` when x, y and z are latitude, longitude and height.
    pub has_position: bool,
    /// `true` when a plane flies to that position.
    pub is_destination: bool,
    /// How ArduPlane treats it.
    pub support: Support,
    /// Parameters 1 to 4, x, y, z.
    pub params: [ParamInfo; 7],
}

/// A command that ArduPlane refuses in a plan. Known so that a plan that holds one can be read, shown and explained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RefusedCommand {
    /// Its number.
    pub command: Command,
    /// Name in MAVLink, as in `MAV_CMD_DO_SET_MODE`.
    pub name: &'static str,
    /// `true` when x, y and z are latitude, longitude and height.
    pub has_position: bool,
}
