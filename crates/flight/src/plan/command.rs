//! The mission commands: one table that says what each is called, what its parameters mean, and what an
//! ArduPlane keeps of them.
//!
//! Sources: names, units and positions from the MAVLink common and ardupilotmega dialects
//! (<https://mavlink.io/en/messages/common.html#mav_commands>); which commands ArduPlane takes, and in
//! what form it stores each field, from an ArduPlane 4.8 (`tests/fixtures/facts/`, walked by a test) and
//! the packing rules of ArduPilot's mission library.

mod info;
mod storage;
mod table;

pub use self::info::{Category, Choice, ChoiceWord, Command, CommandInfo, ParamInfo, RefusedCommand, Support, Unit};
pub use self::storage::Storage;
pub use self::table::{COMMANDS, REFUSED};

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
