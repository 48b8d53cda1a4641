//! Reactions of an ArduPlane to failures in a mission.
//!
//! The rules are those of `ArduPlane/events.cpp`, `system.cpp` (`check_long_failsafe`, `check_short_failsafe`),
//! `radio.cpp` and `AP_BattMonitor_Backend.cpp` of ArduPilot 4.7; the defaults are those of a fixed-wing plane.

use crate::words::words;

/// Default time for which a voltage must stay low to count, s (`BATT_LOW_TIMER`).
const VOLTAGE_LOW_S: f64 = 10.0;

words! {
    /// What fails in flight, or is asked for.
    #[cfg_attr(feature = "describe", derive(serde::Deserialize))]
    Trigger {
        /// RTL is commanded.
        ReturnAsked = "return-asked",
        /// The vehicle hears no ground station any more (`FS_GCS_ENABL`, `FS_LONG_ACTN`).
        LinkLost = "link-lost",
        /// It does not hear its remote control any more (`THR_FAILSAFE`, `FS_SHORT_ACTN`, `FS_LONG_ACTN`).
        RadioLost = "radio-lost",
        /// The battery reaches its low mark (`BATT_FS_LOW_ACT`).
        BatteryLow = "battery-low",
        /// The battery reaches its critical mark (`BATT_FS_CRT_ACT`).
        BatteryCritical = "battery-critical",
        /// A landing is aborted on its final leg (MAV_CMD_DO_GO_AROUND).
        GoAround = "go-around",
        /// The engine stops. The autopilot does not notice and tries to hold its height.
        EngineStopped = "engine-stopped",
    }
}

words! {
    /// Reaction of the vehicle.
    Reaction {
        /// It goes on as before: with the mission, or what else it did.
        GoesOn = "goes-on",
        /// It flies the mission, which it did not before.
        FliesMission = "flies-mission",
        /// It returns, as RTL does with `RTL_AUTOLAND` and rally points.
        Returns = "returns",
        /// It goes to the mission's nearest landing sequence.
        Lands = "lands",
        /// It climbs away from a landing, and begins that again.
        GoesAround = "goes-around",
        /// It circles where it is and as high as it is (CIRCLE).
        Circles = "circles",
        /// It glides straight ahead, throttle closed and nose level (FBWA, without stick input).
        Glides = "glides",
        /// Something that is not rehearsed: a parachute, a termination, a landing on rotors, a mode that needs a pilot.
        NotRehearsed = "not-rehearsed",
    }
}

/// Action of a battery failsafe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BatteryAction {
    /// Nothing, or no mark is set that would set it off.
    #[default]
    Nothing,
    /// RTL.
    Return,
    /// The mission's landing, or RTL without one.
    Land,
    /// Termination or a parachute.
    Other,
}

/// The autopilot's failsafes. Defaults are ArduPlane's: it goes on with its mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Failsafes {
    /// Whether silence of the ground station is acted on (`FS_GCS_ENABL` 1, 2 or 3).
    pub watches_station: bool,
    /// Whether that is so in AUTO alone (`FS_GCS_ENABL` 3).
    pub watches_station_in_mission_only: bool,
    /// Whether silence of the remote control is acted on (`THR_FAILSAFE` 1).
    pub watches_radio: bool,
    /// First action (`FS_SHORT_ACTN`: 0 nothing in AUTO, 1 CIRCLE, 2 FBWA, 3 off, 4 FBWB).
    pub short_action: i64,
    /// After how long, s: `FS_SHORT_TIMEOUT`; from ArduPlane 4.8 on, which has none, `RC_FS_TIMEOUT` and 0.2 s.
    pub short_s: f64,
    /// Later action (`FS_LONG_ACTN`: 0 nothing in AUTO, 1 RTL, 2 FBWA, 3 parachute, 4 AUTO).
    pub long_action: i64,
    /// After how long, s (`FS_LONG_TIMEOUT`).
    pub long_s: f64,
    /// Whether that is counted from the first action on a lost remote control, as before ArduPlane 4.8, or from the last
    /// valid frame.
    pub long_follows_short: bool,
    /// At the battery's low mark (`BATT_FS_LOW_ACT`, with `BATT_LOW_VOLT` or `BATT_LOW_MAH`).
    pub battery_low: BatteryAction,
    /// After how long below it, s (`BATT_LOW_TIMER`): a voltage may only sag, a charge is acted on at once.
    pub battery_low_s: f64,
    /// At its critical mark (`BATT_FS_CRT_ACT`, with `BATT_CRT_VOLT` or `BATT_CRT_MAH`).
    pub battery_critical: BatteryAction,
    /// After how long below it, s, likewise.
    pub battery_critical_s: f64,
    /// Whether a battery failsafe goes on with a mission that reaches its landing sooner (bit 1 of `MIS_OPTIONS`).
    pub prefers_nearer_landing: bool,
}

impl Default for Failsafes {
    fn default() -> Self {
        Self {
            watches_station: false,
            watches_station_in_mission_only: false,
            watches_radio: true,
            short_action: 0,
            short_s: 1.5,
            long_action: 0,
            long_s: 5.0,
            long_follows_short: true,
            battery_low: BatteryAction::Nothing,
            battery_low_s: 0.0,
            battery_critical: BatteryAction::Nothing,
            battery_critical_s: 0.0,
            prefers_nearer_landing: false,
        }
    }
}

/// Mode of the vehicle at the decision, in the groups that its failsafes distinguish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Duty {
    /// AUTO.
    Mission,
    /// GUIDED.
    Guided,
    /// LOITER and THERMAL.
    Loiter,
    /// RTL.
    Return,
    /// CIRCLE, and TAKEOFF after its climb.
    Circling,
    /// A mode that a pilot steers in, FBWA among them.
    Piloted,
}

/// Where in its mission the vehicle is when it has to decide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Situation {
    pub duty: Duty,
    /// It flies its NAV_LAND.
    pub is_landing: bool,
    /// It passed a DO_LAND_START, or flies its NAV_LAND.
    pub is_in_landing_sequence: bool,
    /// A return goes to the landing at once (`RTL_AUTOLAND` 2).
    pub returns_to_landing: bool,
    /// Its mission leads it to a landing on a way no longer than that by the nearest DO_LAND_START.
    pub is_near_its_landing: bool,
}

impl Failsafes {
    /// From an ArduPlane's parameters; a name that `get` does not know keeps its default.
    pub fn from_ardupilot(get: impl Fn(&str) -> Option<f64>) -> Self {
        let number = |name: &str, default: f64| get(name).filter(|value| value.is_finite()).unwrap_or(default);
        let has_rotors = number("Q_ENABLE", 0.0) != 0.0;
        let voltage_s = number("BATT_LOW_TIMER", VOLTAGE_LOW_S);
        let battery = |action: &str, voltage: &str, charge: &str| {
            let by_voltage = number(voltage, 0.0) > 0.0 && voltage_s > 0.0;
            let is_set_off = by_voltage || number(charge, 0.0) > 0.0;
            let action = match number(action, 0.0) as i64 {
                _ if number("BATT_MONITOR", 1.0) == 0.0 || !is_set_off => BatteryAction::Nothing,
                0 => BatteryAction::Nothing,
                1 => BatteryAction::Return,
                4 | 6 if has_rotors => BatteryAction::Other,
                2 | 4 | 6 => BatteryAction::Land,
                _ => BatteryAction::Other,
            };
            (action, if by_voltage { voltage_s } else { 0.0 })
        };
        let (battery_low, battery_low_s) = battery("BATT_FS_LOW_ACT", "BATT_LOW_VOLT", "BATT_LOW_MAH");
        let (battery_critical, battery_critical_s) = battery("BATT_FS_CRT_ACT", "BATT_CRT_VOLT", "BATT_CRT_MAH");
        let default = Self::default();
        // Source: `Plane::check_short_rc_failsafe`, `check_long_failsafe`.
        let rc_timeout_s = get("RC_FS_TIMEOUT").filter(|_| get("FS_SHORT_TIMEOUT").is_none());
        Self {
            watches_station: matches!(number("FS_GCS_ENABL", 0.0) as i64, 1..=3),
            watches_station_in_mission_only: number("FS_GCS_ENABL", 0.0) as i64 == 3,
            watches_radio: number("THR_FAILSAFE", 1.0) as i64 == 1,
            short_action: number("FS_SHORT_ACTN", 0.0) as i64,
            short_s: match rc_timeout_s {
                Some(timeout_s) => (timeout_s + 0.2).max(0.0),
                None => number("FS_SHORT_TIMEOUT", default.short_s).max(0.0),
            },
            long_action: number("FS_LONG_ACTN", 0.0) as i64,
            long_s: number("FS_LONG_TIMEOUT", default.long_s).max(0.0),
            long_follows_short: rc_timeout_s.is_none(),
            battery_low,
            battery_low_s,
            battery_critical,
            battery_critical_s,
            prefers_nearer_landing: number("MIS_OPTIONS", 0.0) as i64 & 2 != 0,
        }
    }

    /// How long after a trigger the vehicle decides, s; a lost remote control twice.
    pub(super) fn decides_after(&self, trigger: Trigger, now: Situation) -> Vec<f64> {
        let hears_nobody = self.watches_station && (now.duty == Duty::Mission || !self.watches_station_in_mission_only);
        match trigger {
            Trigger::LinkLost if hears_nobody => vec![self.long_s],
            Trigger::GoAround if now.is_landing => vec![0.0],
            // Without a short failsafe the long one counts from the last that was heard.
            Trigger::RadioLost if self.watches_radio && self.short_action == 3 => vec![self.long_s],
            Trigger::RadioLost if self.watches_radio => {
                let before_s = if self.long_follows_short { self.short_s } else { 0.0 };
                vec![self.short_s, (before_s + self.long_s).max(self.short_s)]
            }
            Trigger::ReturnAsked => vec![0.0],
            Trigger::BatteryLow => vec![self.battery_low_s],
            Trigger::BatteryCritical => vec![self.battery_critical_s],
            Trigger::LinkLost | Trigger::RadioLost | Trigger::GoAround | Trigger::EngineStopped => Vec::new(),
        }
    }

    /// The vehicle's decision; `is_last` is the later one of two.
    pub(super) fn decides(&self, trigger: Trigger, is_last: bool, now: Situation) -> Reaction {
        match trigger {
            Trigger::ReturnAsked => Reaction::Returns,
            Trigger::RadioLost if !is_last => self.short(now),
            Trigger::LinkLost | Trigger::RadioLost => self.long(now),
            Trigger::BatteryLow => self.battery(self.battery_low, now),
            Trigger::BatteryCritical => self.battery(self.battery_critical, now),
            Trigger::GoAround => Reaction::GoesAround,
            Trigger::EngineStopped => Reaction::GoesOn,
        }
    }

    fn short(&self, now: Situation) -> Reaction {
        match self.short_action {
            _ if matches!(now.duty, Duty::Return | Duty::Circling) => Reaction::GoesOn,
            _ if now.duty == Duty::Mission && now.is_in_landing_sequence => Reaction::GoesOn,
            0 if now.duty == Duty::Piloted => Reaction::Circles,
            1 => Reaction::Circles,
            2 => Reaction::Glides,
            4 => Reaction::NotRehearsed,
            _ => Reaction::GoesOn,
        }
    }

    fn long(&self, now: Situation) -> Reaction {
        match self.long_action {
            _ if now.duty == Duty::Mission && now.is_in_landing_sequence => Reaction::GoesOn,
            4 if now.duty == Duty::Mission => Reaction::GoesOn,
            4 => Reaction::FliesMission,
            _ if now.duty == Duty::Return => Reaction::GoesOn,
            // Where AUTO continues, CIRCLE, LOITER and FBWA return.
            0 if matches!(now.duty, Duty::Mission | Duty::Guided) => Reaction::GoesOn,
            0 | 1 => Reaction::Returns,
            2 => Reaction::Glides,
            _ => Reaction::NotRehearsed,
        }
    }

    fn battery(&self, action: BatteryAction, now: Situation) -> Reaction {
        let reaches_landing = now.is_in_landing_sequence || (self.prefers_nearer_landing && now.is_near_its_landing);
        match action {
            BatteryAction::Other => Reaction::NotRehearsed,
            _ if now.is_landing => Reaction::GoesOn,
            BatteryAction::Nothing => Reaction::GoesOn,
            BatteryAction::Land if reaches_landing => Reaction::GoesOn,
            BatteryAction::Land => Reaction::Lands,
            BatteryAction::Return if now.returns_to_landing && reaches_landing => Reaction::GoesOn,
            BatteryAction::Return => Reaction::Returns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MISSION: Situation = Situation {
        duty: Duty::Mission,
        is_landing: false,
        is_in_landing_sequence: false,
        returns_to_landing: false,
        is_near_its_landing: false,
    };

    fn with(settings: &[(&str, f64)]) -> Failsafes {
        Failsafes::from_ardupilot(|name| settings.iter().find(|(known, _)| *known == name).map(|(_, value)| *value))
    }

    #[test]
    fn an_arduplane_as_it_comes_goes_on() {
        let none = with(&[]);
        assert_eq!(none, Failsafes::default());
        for &trigger in Trigger::ALL {
            let wanted = match trigger {
                Trigger::ReturnAsked => Reaction::Returns,
                Trigger::GoAround => Reaction::GoesAround,
                _ => Reaction::GoesOn,
            };
            assert_eq!(none.decides(trigger, true, MISSION), wanted, "{trigger:?}");
        }
        assert!(none.decides_after(Trigger::LinkLost, MISSION).is_empty());
    }

    #[test]
    fn silence_is_answered_first_shortly_and_then_for_long() {
        let set =
            with(&[("FS_SHORT_ACTN", 1.0), ("FS_LONG_ACTN", 1.0), ("FS_LONG_TIMEOUT", 20.0), ("FS_GCS_ENABL", 1.0)]);
        assert_eq!(set.decides_after(Trigger::RadioLost, MISSION), [1.5, 21.5]);
        let newer = with(&[("RC_FS_TIMEOUT", 1.0), ("FS_LONG_TIMEOUT", 20.0)]);
        assert_eq!(newer.decides_after(Trigger::RadioLost, MISSION), [1.2, 20.0], "ArduPlane 4.8");
        assert_eq!(set.decides_after(Trigger::LinkLost, MISSION), [20.0]);
        assert_eq!(set.decides(Trigger::RadioLost, false, MISSION), Reaction::Circles);
        assert_eq!(set.decides(Trigger::LinkLost, true, MISSION), Reaction::Returns);
        let landing = Situation { is_in_landing_sequence: true, ..MISSION };
        assert_eq!(set.decides(Trigger::LinkLost, true, landing), Reaction::GoesOn);
        // CIRCLE is left for RTL where AUTO would have gone on.
        let circles = with(&[("FS_SHORT_ACTN", 1.0)]);
        assert_eq!(circles.decides(Trigger::RadioLost, true, MISSION), Reaction::GoesOn);
        let left = Situation { duty: Duty::Circling, ..MISSION };
        assert_eq!(circles.decides(Trigger::RadioLost, true, left), Reaction::Returns);
    }

    #[test]
    fn a_battery_acts_where_a_mark_is_set_and_never_in_a_landing() {
        let unset = with(&[("BATT_FS_LOW_ACT", 2.0)]);
        assert_eq!(unset.decides(Trigger::BatteryLow, true, MISSION), Reaction::GoesOn);
        let set = with(&[
            ("BATT_FS_LOW_ACT", 1.0),
            ("BATT_LOW_VOLT", 10.5),
            ("BATT_FS_CRT_ACT", 2.0),
            ("BATT_CRT_MAH", 300.0),
        ]);
        assert_eq!(set.decides(Trigger::BatteryLow, true, MISSION), Reaction::Returns);
        assert_eq!(set.decides(Trigger::BatteryCritical, true, MISSION), Reaction::Lands);
        let final_leg = Situation { is_landing: true, is_in_landing_sequence: true, ..MISSION };
        assert_eq!(set.decides(Trigger::BatteryCritical, true, final_leg), Reaction::GoesOn);
        let without_monitor = with(&[("BATT_MONITOR", 0.0), ("BATT_FS_LOW_ACT", 1.0), ("BATT_LOW_VOLT", 10.5)]);
        assert_eq!(without_monitor.battery_low, BatteryAction::Nothing);
        // A voltage has to stay low for BATT_LOW_TIMER, which switches it off when 0; a charge does not.
        assert_eq!(set.decides_after(Trigger::BatteryLow, MISSION), [10.0]);
        assert_eq!(set.decides_after(Trigger::BatteryCritical, MISSION), [0.0]);
        let soon = with(&[("BATT_FS_LOW_ACT", 1.0), ("BATT_LOW_VOLT", 10.5), ("BATT_LOW_TIMER", 3.0)]);
        assert_eq!(soon.decides_after(Trigger::BatteryLow, MISSION), [3.0]);
        let off = with(&[("BATT_FS_LOW_ACT", 1.0), ("BATT_LOW_VOLT", 10.5), ("BATT_LOW_TIMER", 0.0)]);
        assert_eq!(off.decides(Trigger::BatteryLow, true, MISSION), Reaction::GoesOn);
        let charge_alone = with(&[("BATT_FS_LOW_ACT", 1.0), ("BATT_LOW_MAH", 500.0), ("BATT_LOW_TIMER", 0.0)]);
        assert_eq!(charge_alone.decides(Trigger::BatteryLow, true, MISSION), Reaction::Returns);
        // "Use the distance to the landing": a mission that comes down sooner goes on.
        let nearer = with(&[("BATT_FS_LOW_ACT", 2.0), ("BATT_LOW_VOLT", 10.5), ("MIS_OPTIONS", 2.0)]);
        let near = Situation { is_near_its_landing: true, ..MISSION };
        assert_eq!(nearer.decides(Trigger::BatteryLow, true, near), Reaction::GoesOn);
        assert_eq!(nearer.decides(Trigger::BatteryLow, true, MISSION), Reaction::Lands);
    }
}
