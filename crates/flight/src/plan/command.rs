//! The mission commands: one table that says what each is called, what its parameters mean, and what an
//! ArduPlane keeps of them.
//!
//! Sources: names, units and positions from the MAVLink common and ardupilotmega dialects
//! (<https://mavlink.io/en/messages/common.html#mav_commands>); which commands ArduPlane takes, and in
//! what form it stores each field, from an ArduPlane 4.8 (`tests/fixtures/facts/`, walked by a test) and
//! the packing rules of ArduPilot's mission library.

mod storage;
mod table;

use crate::words::words;

pub use self::storage::Storage;
pub use self::table::{COMMANDS, REFUSED};

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
}

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

impl std::fmt::Display for Command {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name.strip_prefix("MAV_CMD_").unwrap_or(name)),
            None => write!(f, "command {}", self.0),
        }
    }
}

impl Command {
    /// Everything known of a command that ArduPlane takes; `None` for the others.
    pub fn info(self) -> Option<&'static CommandInfo> {
        let index = COMMANDS.binary_search_by_key(&self, |info| info.command).ok()?;
        COMMANDS.get(index)
    }

    /// Name in MAVLink, as in `MAV_CMD_NAV_WAYPOINT`; `None` for a number that Vencejo does not know.
    pub fn name(self) -> Option<&'static str> {
        self.info().map(|info| info.name).or_else(|| self.refused().map(|refused| refused.name))
    }

    /// The command of a name, with or without `MAV_CMD_`, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        let bare = |name: &str| {
            let upper = name.trim().to_ascii_uppercase();
            upper.strip_prefix("MAV_CMD_").map(str::to_owned).unwrap_or(upper)
        };
        let wanted = bare(name);
        let known = COMMANDS.iter().map(|info| (info.command, info.name));
        let refused = REFUSED.iter().map(|refused| (refused.command, refused.name));
        known.chain(refused).find(|(_, name)| bare(name) == wanted).map(|(command, _)| command)
    }

    /// Whether x, y and z are a position; `None` for a number that Vencejo does not know.
    pub fn has_position(self) -> Option<bool> {
        self.info().map(|info| info.has_position).or_else(|| self.refused().map(|refused| refused.has_position))
    }

    /// `true` when ArduPlane takes it in a mission.
    pub fn is_mission_command(self) -> bool {
        self.info().is_some_and(|info| info.support != Support::List)
    }

    /// `true` when a vehicle flies to the position of the item. Beside the commands of the table that is the spline
    /// waypoint of copters.
    pub fn is_destination(self) -> bool {
        self.info().map_or(self == Self::NAV_SPLINE_WAYPOINT, |info| info.is_destination)
    }

    /// `true` for navigation commands, at which the mission waits until they are done. Numbers in neither table count
    /// as such below `MAV_CMD_NAV_LAST`.
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

    /// `true` when every ArduPilot takes NaN in `params[index]` (the heading, mostly); it refuses others. In
    /// NAV_LOITER_UNLIM NaN is accepted from 4.6 on only, and never stored.
    pub const fn param_may_be_unset(self, index: usize) -> bool {
        match self {
            Self::NAV_WAYPOINT | Self::NAV_LAND | Self::NAV_TAKEOFF | Self::NAV_VTOL_TAKEOFF => index == 3,
            Self::NAV_VTOL_LAND => index == 2 || index == 3,
            _ => false,
        }
    }

    fn refused(self) -> Option<&'static RefusedCommand> {
        let index = REFUSED.binary_search_by_key(&self, |refused| refused.command).ok()?;
        REFUSED.get(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted_and_disjoint() {
        assert!(COMMANDS.windows(2).all(|pair| pair[0].command < pair[1].command));
        assert!(REFUSED.windows(2).all(|pair| pair[0].command < pair[1].command));
        assert!(REFUSED.iter().all(|refused| refused.command.info().is_none()));
        assert!(COMMANDS.iter().all(|info| !info.title.is_empty()));
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
}
