//! Flight modes by name and number, for ArduPlane, ArduCopter and PX4.
//!
//! Numbers: HEARTBEAT's `custom_mode`. ArduPilot: mavlink.io, `PLANE_MODE` and `COPTER_MODE`. PX4: main mode in bits 16
//! to 23 and sub mode in bits 24 to 31 (PX4 user guide, "Flight Modes"; `px4_custom_mode`).

use std::fmt;

use thiserror::Error;

use crate::kind::VehicleKind;
use crate::refusal::Refusal;

/// The numbering of flight modes that a vehicle uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ModeFamily {
    /// ArduPilot on a fixed wing or a VTOL.
    ArduPlane,
    /// ArduPilot on a multicopter or helicopter.
    ArduCopter,
    /// PX4 on anything.
    Px4,
    /// Unknown autopilot: modes have numbers only.
    Other,
}

impl ModeFamily {
    /// The family of a vehicle by its HEARTBEAT (`MAV_AUTOPILOT`, `MAV_TYPE`).
    pub fn of(autopilot: u8, mav_type: u8) -> Self {
        match (autopilot, VehicleKind::of(mav_type)) {
            (3, Some(VehicleKind::Plane | VehicleKind::Vtol)) => Self::ArduPlane,
            (3, Some(VehicleKind::Copter)) => Self::ArduCopter,
            (12, _) => Self::Px4,
            _ => Self::Other,
        }
    }

    /// Whether it flies the arcs of `NAV_ARC_WAYPOINT`: among the ArduPilots only ArduCopter does, from 4.7 on.
    pub fn flies_arcs(self) -> bool {
        self == Self::ArduCopter
    }

    /// Families with known modes.
    pub const KNOWN: [Self; 3] = [Self::ArduPlane, Self::ArduCopter, Self::Px4];

    /// Its modes: number and name, by number.
    pub fn modes(self) -> &'static [(u32, &'static str)] {
        match self {
            Self::ArduPlane => ARDUPLANE,
            Self::ArduCopter => ARDUCOPTER,
            Self::Px4 => PX4,
            Self::Other => &[],
        }
    }

    /// Those of its modes that a vehicle of this type can be set to.
    pub fn modes_of(self, mav_type: u8) -> impl Iterator<Item = (u32, &'static str)> {
        let cannot = move |mode: u32| self == Self::Px4 && px4_cannot_be_set(mode, mav_type);
        self.modes().iter().copied().filter(move |(mode, _)| !cannot(*mode))
    }

    /// A mode by name: case, spaces, underscores and hyphens do not matter. `"mode 42"` and `"42"` are accepted as
    /// numbers.
    ///
    /// # Errors
    /// [`UnknownMode`] with the most similar names.
    pub fn parse(self, name: &str) -> Result<FlightMode, UnknownMode> {
        let wanted = folded(name);
        let by_name = self.modes().iter().find(|(_, known)| folded(known) == wanted).map(|(number, _)| *number);
        let by_alias = || self.aliases().iter().find(|(alias, _)| folded(alias) == wanted).map(|(_, number)| *number);
        // Digits only: "1.5" would fold to the number of another mode.
        let by_number = || {
            let text = name.trim();
            let number = match text.get(..4) {
                Some(begin) if begin.eq_ignore_ascii_case("mode") => text[4..].trim_matches([' ', '_', '(', ')']),
                _ => text,
            };
            number.parse().ok().filter(|_| number.bytes().all(|byte| byte.is_ascii_digit()))
        };
        match by_name.or_else(by_alias).or_else(by_number) {
            Some(custom_mode) => Ok(FlightMode { family: self, custom_mode }),
            None => Err(UnknownMode {
                family: self,
                name: name.chars().take(40).collect(),
                suggestions: self.nearest(&wanted),
            }),
        }
    }

    /// Other names in use: those of the configuration tools and of MAVLink's enums.
    fn aliases(self) -> &'static [(&'static str, u32)] {
        match self {
            Self::ArduPlane => &[
                ("FLY_BY_WIRE_A", 5),
                ("FLY_BY_WIRE_B", 6),
                ("INITIALIZING", 16),
                ("LOITER_TO_QLAND", 25),
                ("LOITER2QLAND", 25),
            ],
            Self::ArduCopter => &[("POSITION_HOLD", 16), ("SYSTEM_ID", 25)],
            Self::Px4 => PX4_ALIASES,
            Self::Other => &[],
        }
    }

    /// Up to three names that resemble `wanted` (folded).
    fn nearest(self, wanted: &str) -> Vec<&'static str> {
        let mut near: Vec<_> = self
            .modes()
            .iter()
            .filter_map(|(_, name)| {
                let known = folded(name);
                let is_part = wanted.len() >= 2 && (known.contains(wanted) || wanted.contains(&known));
                let distance = edit_distance(&known, wanted);
                (is_part || distance <= 2.max(known.len() / 3)).then_some((distance, *name))
            })
            .collect();
        near.sort();
        near.truncate(3);
        near.into_iter().map(|(_, name)| name).collect()
    }
}

/// A flight mode of a vehicle. Shown by name, or as "mode 42" when the number is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FlightMode {
    /// The numbering.
    pub family: ModeFamily,
    /// HEARTBEAT's `custom_mode`.
    pub custom_mode: u32,
}

impl FlightMode {
    /// Its name, such as `"FBWA"`.
    pub fn name(self) -> Option<&'static str> {
        self.family.modes().iter().find(|(number, _)| *number == self.custom_mode).map(|(_, name)| *name)
    }

    /// Whether the vehicle follows its mission in this mode.
    pub fn follows_mission(self) -> bool {
        Some(self) == Action::Mission.mode(self.family)
    }

    /// The mode to change to before arming; `None` when the vehicle arms in this one, and stays where it is when armed.
    ///
    /// An ArduPlane does not arm in modes that return or land (`pre_arm_checks` of its modes: RTL, QRTL, QLAND,
    /// INITIALISING), and in one that flies by itself it would take off as soon as it is armed: MANUAL, the mode it
    /// boots into, does neither. A copter arms for a mission in GUIDED. A PX4 that has landed after its mission stays in
    /// AUTO_MISSION, and takes off when it is armed there; in AUTO_LOITER it stays on the ground. The needs of others
    /// are unknown: they are left as they are.
    #[must_use]
    pub fn to_arm_in(self) -> Option<Self> {
        let (arms, instead): (&[u32], u32) = match self.family {
            // The modes flown by stick, of fixed wings and of VTOLs.
            ModeFamily::ArduPlane => (&[0, 2, 3, 4, 5, 6, 7, 8, 17, 18, 19, 22, 23], 0),
            ModeFamily::ArduCopter => (&[0, 1, 2, 4, 5, 13, 16, 20], 4),
            ModeFamily::Px4 => (PX4_BY_STICK_OR_LOITER, px4(4, 3)),
            ModeFamily::Other => return None,
        };
        (!arms.contains(&self.custom_mode)).then_some(Self { custom_mode: instead, ..self })
    }

    /// The mode that resolves a refusal to arm, where one of its reasons is about the mode or the landing sequence.
    pub(crate) fn curing(self, reasons: &[String]) -> Option<Self> {
        let is_about = |refusal| reasons.iter().any(|reason| Refusal::of(reason) == Some(refusal));
        // A mode flown by stick, entered on the ground, ends a landing sequence.
        let ends_landing = self.family == ModeFamily::ArduPlane && is_about(Refusal::LandingSequence);
        if !ends_landing && !is_about(Refusal::ModeNotArmable) {
            return None;
        }
        let another = u32::from(self.custom_mode == 0) * 5;
        self.to_arm_in().or(ends_landing.then_some(Self { custom_mode: another, ..self }))
    }

    /// The parameters 2 and 3 of MAV_CMD_DO_SET_MODE. PX4 takes its main and sub mode apart.
    pub(crate) fn command_params(self) -> (f32, f32) {
        match self.family {
            ModeFamily::Px4 => (((self.custom_mode >> 16) & 0xff) as f32, (self.custom_mode >> 24) as f32),
            // Mode numbers are small; a float holds them exactly.
            _ => (self.custom_mode as f32, 0.0),
        }
    }
}

impl fmt::Display for FlightMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "mode {}", self.custom_mode),
        }
    }
}

/// Actions for which vehicles have a mode, under different names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// Follow the mission.
    Mission,
    /// Stay here: circle or hover.
    Loiter,
    /// Return to launch.
    ReturnToLaunch,
    /// Land here. Not for a fixed wing.
    Land,
    /// Take off in a mode of its own: the fixed wings.
    Takeoff,
    /// Fly where a ground station says.
    Guided,
}

impl Action {
    /// The mode for it.
    pub fn mode(self, family: ModeFamily) -> Option<FlightMode> {
        let custom_mode = match (family, self) {
            (ModeFamily::ArduPlane, Self::Mission) => 10,
            (ModeFamily::ArduPlane, Self::Loiter) => 12,
            (ModeFamily::ArduPlane, Self::ReturnToLaunch) => 11,
            (ModeFamily::ArduPlane, Self::Takeoff) => 13,
            (ModeFamily::ArduPlane, Self::Guided) => 15,
            (ModeFamily::ArduCopter, Self::Mission) => 3,
            (ModeFamily::ArduCopter, Self::Guided) => 4,
            (ModeFamily::ArduCopter, Self::Loiter) => 5,
            (ModeFamily::ArduCopter, Self::ReturnToLaunch) => 6,
            (ModeFamily::ArduCopter, Self::Land) => 9,
            (ModeFamily::Px4, Self::Mission) => px4(4, 4),
            (ModeFamily::Px4, Self::Loiter) => px4(4, 3),
            (ModeFamily::Px4, Self::ReturnToLaunch) => px4(4, 5),
            (ModeFamily::Px4, Self::Land) => px4(4, 6),
            _ => return None,
        };
        Some(FlightMode { family, custom_mode })
    }

    /// Its description for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mission => "following a mission",
            Self::Loiter => "loitering",
            Self::ReturnToLaunch => "returning to launch",
            Self::Land => "landing",
            Self::Takeoff => "taking off",
            Self::Guided => "flying where it is told",
        }
    }
}

/// A mode name that the vehicle does not have.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("no flight mode is called {name:?}{}", suggest(*family, suggestions))]
pub struct UnknownMode {
    /// Whose modes were looked at.
    pub family: ModeFamily,
    /// The name given (its first 40 characters).
    pub name: String,
    /// Similar names.
    pub suggestions: Vec<&'static str>,
}

/// The similar names, or where there are none all.
fn suggest(family: ModeFamily, suggestions: &[&str]) -> String {
    let names: Vec<_> = family.modes().iter().map(|(_, name)| *name).collect();
    match (suggestions, &names[..]) {
        ([], []) => String::new(),
        ([], names) => format!("; it has {}", names.join(", ")),
        (suggestions, _) => format!("; did you mean {}?", suggestions.join(" or ")),
    }
}

/// Upper case, letters and digits only.
fn folded(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).map(|c| c.to_ascii_uppercase()).take(40).collect()
}

/// Levenshtein's distance, for short names.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

const ARDUPLANE: &[(u32, &str)] = &[
    (0, "MANUAL"),
    (1, "CIRCLE"),
    (2, "STABILIZE"),
    (3, "TRAINING"),
    (4, "ACRO"),
    (5, "FBWA"),
    (6, "FBWB"),
    (7, "CRUISE"),
    (8, "AUTOTUNE"),
    (10, "AUTO"),
    (11, "RTL"),
    (12, "LOITER"),
    (13, "TAKEOFF"),
    (14, "AVOID_ADSB"),
    (15, "GUIDED"),
    (16, "INITIALISING"),
    (17, "QSTABILIZE"),
    (18, "QHOVER"),
    (19, "QLOITER"),
    (20, "QLAND"),
    (21, "QRTL"),
    (22, "QAUTOTUNE"),
    (23, "QACRO"),
    (24, "THERMAL"),
    (25, "LOITER_ALT_QLAND"),
    (26, "AUTOLAND"),
];

const ARDUCOPTER: &[(u32, &str)] = &[
    (0, "STABILIZE"),
    (1, "ACRO"),
    (2, "ALT_HOLD"),
    (3, "AUTO"),
    (4, "GUIDED"),
    (5, "LOITER"),
    (6, "RTL"),
    (7, "CIRCLE"),
    (9, "LAND"),
    (11, "DRIFT"),
    (13, "SPORT"),
    (14, "FLIP"),
    (15, "AUTOTUNE"),
    (16, "POSHOLD"),
    (17, "BRAKE"),
    (18, "THROW"),
    (19, "AVOID_ADSB"),
    (20, "GUIDED_NOGPS"),
    (21, "SMART_RTL"),
    (22, "FLOWHOLD"),
    (23, "FOLLOW"),
    (24, "ZIGZAG"),
    (25, "SYSTEMID"),
    (26, "AUTOROTATE"),
    (27, "AUTO_RTL"),
    (28, "TURTLE"),
];

/// PX4's `custom_mode` of a main and a sub mode.
const fn px4(main: u32, sub: u32) -> u32 {
    (main << 16) | (sub << 24)
}

const PX4: &[(u32, &str)] = &[
    (px4(1, 0), "MANUAL"),
    (px4(2, 0), "ALTCTL"),
    (px4(3, 0), "POSCTL"),
    (px4(3, 1), "POSCTL_ORBIT"),
    (px4(3, 2), "POSCTL_SLOW"),
    (px4(4, 1), "AUTO_READY"),
    (px4(4, 2), "AUTO_TAKEOFF"),
    (px4(4, 3), "AUTO_LOITER"),
    (px4(4, 4), "AUTO_MISSION"),
    (px4(4, 5), "AUTO_RTL"),
    (px4(4, 6), "AUTO_LAND"),
    (px4(4, 8), "AUTO_FOLLOW_TARGET"),
    (px4(4, 9), "AUTO_PRECLAND"),
    (px4(4, 10), "AUTO_VTOL_TAKEOFF"),
    (px4(4, 11), "EXTERNAL1"),
    (px4(4, 12), "EXTERNAL2"),
    (px4(4, 13), "EXTERNAL3"),
    (px4(4, 14), "EXTERNAL4"),
    (px4(4, 15), "EXTERNAL5"),
    (px4(4, 16), "EXTERNAL6"),
    (px4(4, 17), "EXTERNAL7"),
    (px4(4, 18), "EXTERNAL8"),
    (px4(5, 0), "ACRO"),
    (px4(6, 0), "OFFBOARD"),
    (px4(7, 0), "STABILIZED"),
    (px4(8, 0), "RATTITUDE"),
    (px4(10, 0), "TERMINATION"),
];

/// Whether a PX4 (v1.17) refuses to be set to a mode: those of older versions, and those of other airframes. Whether there is
/// one of an external component is not known.
fn px4_cannot_be_set(mode: u32, mav_type: u8) -> bool {
    let kind = VehicleKind::of(mav_type);
    match mode {
        _ if mode == px4(4, 1) || mode == px4(8, 0) || mode == px4(10, 0) => true,
        _ if (px4(4, 11)..=px4(4, 18)).contains(&mode) && mode & 0xff_ffff == px4(4, 0) => true,
        _ if mode == px4(4, 10) => kind != Some(VehicleKind::Vtol),
        _ if [px4(3, 1), px4(3, 2), px4(4, 8), px4(4, 9)].contains(&mode) => kind == Some(VehicleKind::Plane),
        _ => false,
    }
}

/// The modes in which a PX4 that is armed on the ground stays there: those flown by stick, and AUTO_LOITER.
const PX4_BY_STICK_OR_LOITER: &[u32] =
    &[px4(1, 0), px4(2, 0), px4(3, 0), px4(3, 2), px4(4, 3), px4(5, 0), px4(7, 0), px4(8, 0)];

const PX4_ALIASES: &[(&str, u32)] = &[
    ("ALTITUDE", px4(2, 0)),
    ("POSITION", px4(3, 0)),
    ("HOLD", px4(4, 3)),
    ("LOITER", px4(4, 3)),
    ("MISSION", px4(4, 4)),
    ("TAKEOFF", px4(4, 2)),
    ("RTL", px4(4, 5)),
    ("RETURN", px4(4, 5)),
    ("LAND", px4(4, 6)),
];

#[cfg(test)]
mod tests {
    use super::*;

    const FAMILIES: [ModeFamily; 3] = [ModeFamily::ArduPlane, ModeFamily::ArduCopter, ModeFamily::Px4];

    #[test]
    fn every_mode_goes_there_and_back() {
        let mut checked = 0;
        for family in FAMILIES {
            for (custom_mode, name) in family.modes() {
                let mode = family.parse(name).expect("known");
                assert_eq!(mode.custom_mode, *custom_mode, "{name}");
                assert_eq!(mode.to_string(), *name);
                checked += 1;
            }
            for (alias, number) in family.aliases() {
                let mode = family.parse(alias).expect("alias");
                assert_eq!(mode.custom_mode, *number);
                assert!(mode.name().is_some(), "{alias} names an unknown mode");
            }
        }
        assert_eq!(checked, 26 + 26 + 27);
    }

    #[test]
    fn modes_to_choose_from_are_those_of_the_airframe() {
        let of = |mav_type| ModeFamily::Px4.modes_of(mav_type).map(|(_, name)| name).collect::<Vec<_>>();
        assert_eq!(
            of(1),
            [
                "MANUAL",
                "ALTCTL",
                "POSCTL",
                "AUTO_TAKEOFF",
                "AUTO_LOITER",
                "AUTO_MISSION",
                "AUTO_RTL",
                "AUTO_LAND",
                "ACRO",
                "OFFBOARD",
                "STABILIZED"
            ]
        );
        assert!(of(2).contains(&"AUTO_PRECLAND") && of(22).contains(&"AUTO_VTOL_TAKEOFF"));
        assert_eq!(ModeFamily::ArduPlane.modes_of(1).count(), ARDUPLANE.len());
    }

    #[test]
    fn spelling_does_not_matter() {
        for spelling in ["avoid adsb", "AVOID_ADSB", "Avoid-Adsb", " avoidadsb "] {
            assert_eq!(ModeFamily::ArduPlane.parse(spelling).expect("known").custom_mode, 14, "{spelling}");
        }
        assert_eq!(ModeFamily::Px4.parse("auto.mission").expect("known").custom_mode, 0x0404_0000);
    }

    #[test]
    fn numbers_stand_for_modes_without_a_name() {
        let mode = ModeFamily::ArduPlane.parse("mode 42").expect("number");
        assert_eq!((mode.custom_mode, mode.name(), mode.to_string()), (42, None, "mode 42".into()));
        assert_eq!(ModeFamily::ArduPlane.parse(&mode.to_string()), Ok(mode));
        assert_eq!(ModeFamily::Other.parse("3").expect("number").custom_mode, 3);
    }

    #[test]
    fn a_wrong_name_says_what_comes_near() {
        let check = |name: &str, near: &str| {
            let error = ModeFamily::ArduPlane.parse(name).expect_err("unknown");
            assert!(error.suggestions.contains(&near), "{name}: {error}");
            assert!(error.suggestions.len() <= 3);
        };
        check("guidd", "GUIDED");
        check("STABILISE", "STABILIZE");
        check("fbw", "FBWA");
        let error = ModeFamily::ArduPlane.parse("xyzzyplugh").expect_err("unknown");
        let text = error.to_string();
        assert!(text.starts_with("no flight mode is called \"xyzzyplugh\"; it has MANUAL, "), "{text}");
        for no_number in ["", "1.5", "[1]", "1,5", "-5", "+5", "1e1", "mode"] {
            assert!(ModeFamily::ArduPlane.parse(no_number).is_err(), "{no_number}");
        }
    }

    #[test]
    fn families_come_from_the_heartbeat() {
        assert_eq!(ModeFamily::of(3, 1), ModeFamily::ArduPlane);
        assert_eq!(ModeFamily::of(3, 20), ModeFamily::ArduPlane);
        assert_eq!(ModeFamily::of(3, 2), ModeFamily::ArduCopter);
        assert_eq!(ModeFamily::of(12, 1), ModeFamily::Px4);
        assert_eq!(ModeFamily::of(0, 1), ModeFamily::Other);
    }

    #[test]
    fn arming_for_a_flight_needs_a_mode_that_arms_and_stays() {
        let check = |family: ModeFamily, name: &str, instead: Option<&str>| {
            let mode = family.parse(name).expect("known");
            assert_eq!(mode.to_arm_in().and_then(FlightMode::name), instead, "{name}");
        };
        for name in
            ["AUTO", "RTL", "TAKEOFF", "GUIDED", "LOITER", "CIRCLE", "INITIALISING", "QLAND", "QRTL", "AUTOLAND"]
        {
            check(ModeFamily::ArduPlane, name, Some("MANUAL"));
        }
        for name in ["MANUAL", "STABILIZE", "FBWA", "FBWB", "CRUISE", "QHOVER", "QLOITER"] {
            check(ModeFamily::ArduPlane, name, None);
        }
        for name in ["AUTO", "RTL", "LAND", "SMART_RTL", "AUTO_RTL"] {
            check(ModeFamily::ArduCopter, name, Some("GUIDED"));
        }
        check(ModeFamily::ArduCopter, "LOITER", None);
        for name in ["AUTO_MISSION", "AUTO_TAKEOFF", "AUTO_RTL", "AUTO_LAND", "AUTO_VTOL_TAKEOFF", "OFFBOARD"] {
            check(ModeFamily::Px4, name, Some("AUTO_LOITER"));
        }
        for name in ["MANUAL", "ALTCTL", "POSCTL", "ACRO", "STABILIZED", "AUTO_LOITER"] {
            check(ModeFamily::Px4, name, None);
        }
    }

    #[test]
    fn a_refusal_that_a_mode_cures_names_it() {
        let check = |name: &str, reason: &str, cure: Option<&str>| {
            let mode = ModeFamily::ArduPlane.parse(name).expect("known");
            let reasons = ["PreArm: Compass not healthy".to_owned(), reason.to_owned()];
            assert_eq!(mode.curing(&reasons).and_then(FlightMode::name), cure, "{name}: {reason}");
        };
        check("RTL", "PreArm: RTL mode not armable", Some("MANUAL"));
        check("AUTO", "PreArm: In landing sequence", Some("MANUAL"));
        // Taken over by stick on the approach: the landing sequence is still there.
        check("FBWA", "Arm: In landing sequence", Some("MANUAL"));
        check("MANUAL", "Arm: In landing sequence", Some("FBWA"));
        check("AUTO", "PreArm: GPS 1: Bad fix", None);
        check("MANUAL", "Throttle mode not armable", None);
    }

    #[test]
    fn px4_modes_are_commanded_in_two_parts() {
        let mission = Action::Mission.mode(ModeFamily::Px4).expect("exists");
        assert_eq!(mission.command_params(), (4.0, 4.0));
        assert!(mission.follows_mission());
        assert_eq!(Action::Land.mode(ModeFamily::ArduPlane), None);
    }
}
