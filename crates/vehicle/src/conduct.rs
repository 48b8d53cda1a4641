//! The present conduct of a vehicle by its messages: whether it flies its mission, whether it lands, how it turns.

use vencejo_flight::guidance::GRAVITY_M_S2;
use vencejo_flight::plan::{Command, Mission};

use crate::modes::{Action, FlightMode, ModeFamily};
use crate::telemetry::{LandedState, Telemetry};

/// Speed below which a plane stands, and does not turn, metres per second.
const MOVING_M_S: f64 = 3.0;
/// Bank above which a plane is tumbling, not turning, radians.
const STEEPEST_RAD: f64 = 1.4;

/// The present conduct of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conduct {
    /// Whether its mode flies the mission; `None` while the mode is unknown.
    pub follows_mission: Option<bool>,
    /// Whether it is on its way down to land: only then can a landing be aborted (`Plane::trigger_land_abort`). `None`
    /// when that is unknown, as in a mission that was not read.
    pub is_landing: Option<bool>,
    /// How fast its course turns while it circles by itself, radians per second, clockwise positive: that of a
    /// coordinated turn at its bank and airspeed, g · tan(bank) / speed. `None` in other modes, whose turns end soon,
    /// and while bank or speed are not known.
    pub turn_rate_rad_s: Option<f64>,
}

impl Conduct {
    /// `mission` is the plan on board and `current` the index of its item in execution, where they are known.
    pub(crate) fn of(telemetry: &Telemetry, mission: Option<&Mission>, current: Option<usize>) -> Self {
        let Some(heartbeat) = telemetry.heartbeat.map(|heartbeat| heartbeat.value) else { return Self::default() };
        let lands_now = || {
            if telemetry.extended.is_some_and(|extended| extended.value.landed == LandedState::Landing) {
                return Some(true);
            }
            if !heartbeat.is_armed || telemetry.is_on_ground() == Some(true) {
                return Some(false);
            }
            if !heartbeat.mode.follows_mission() {
                return Some(lands(heartbeat.mode));
            }
            Some(mission?.items.get(current?).is_some_and(|item| item.command.is_landing()))
        };
        Self {
            follows_mission: Some(heartbeat.mode.follows_mission()),
            is_landing: lands_now(),
            turn_rate_rad_s: turn_rate_rad_s(telemetry).filter(|_| circles(heartbeat.mode)),
        }
    }
}

/// Whether the item at `index` leads to a landing: it lies between a `DO_LAND_START` and the landing item behind it, or
/// is the latter.
pub(crate) fn leads_to_landing(mission: &Mission, index: usize) -> bool {
    let Some((item, up_to)) = mission.items.get(index).zip(mission.items.get(..=index)) else { return false };
    let mut back = up_to.iter().rev().map(|item| item.command).take_while(|command| !command.is_landing());
    let has_begun = back.any(|command| command == Command::DO_LAND_START);
    let ends = mission.items[index..].iter().any(|item| item.command.is_landing());
    item.command.is_landing() || has_begun && ends
}

/// Whether a mode lands, whatever the mission says: of an ArduPlane QLAND and AUTOLAND.
fn lands(mode: FlightMode) -> bool {
    Action::Land.mode(mode.family) == Some(mode)
        || (mode.family == ModeFamily::ArduPlane && matches!(mode.custom_mode, 20 | 26))
}

/// Whether a plane that banks in this mode keeps circling. A copter banks to move.
fn circles(mode: FlightMode) -> bool {
    match mode.family {
        // CIRCLE, RTL, LOITER, GUIDED, QLOITER, QRTL, THERMAL, LOITER_ALT_QLAND
        ModeFamily::ArduPlane => matches!(mode.custom_mode, 1 | 11 | 12 | 15 | 19 | 21 | 24 | 25),
        _ => false,
    }
}

fn turn_rate_rad_s(telemetry: &Telemetry) -> Option<f64> {
    let bank_rad = telemetry.attitude?.value.roll_rad?;
    let hud = telemetry.hud?.value;
    let speed_m_s = hud.airspeed_m_s.or(hud.groundspeed_m_s)?;
    let turns = speed_m_s >= MOVING_M_S && bank_rad.abs() <= STEEPEST_RAD;
    Some(if turns { GRAVITY_M_S2 * bank_rad.tan() / speed_m_s } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use vencejo_flight::plan::{Command, MissionItem};
    use vencejo_proto::MonoTime;

    use super::*;
    use crate::telemetry::{Attitude, ExtendedState, HeartbeatState, Hud, Sampled, SystemStatus};

    fn sampled<T>(value: T) -> Option<Sampled<T>> {
        Some(Sampled { value, at: MonoTime::ZERO, invalid: false })
    }

    /// An armed vehicle in the air.
    fn flying(autopilot: u8, custom_mode: u32) -> Telemetry {
        let heartbeat = HeartbeatState {
            mode: FlightMode { family: ModeFamily::of(autopilot, 1), custom_mode },
            mode_number: custom_mode,
            is_armed: true,
            system_status: SystemStatus::Active,
            mav_type: 1,
            autopilot,
            base_mode: 0,
        };
        Telemetry {
            heartbeat: sampled(heartbeat),
            extended: sampled(ExtendedState { landed: LandedState::InAir, vtol: None }),
            ..Telemetry::default()
        }
    }

    #[test]
    fn a_landing_is_known_by_the_item_the_mode_or_the_vehicle() {
        let items = vec![
            MissionItem::waypoint(40.0, -3.0, 50.0),
            MissionItem::at(Command::NAV_LAND, [0.0; 4], 40.0, -3.0, 0.0),
        ];
        let mission = Mission { home: None, items };
        let is_landing = |telemetry: &Telemetry, current| Conduct::of(telemetry, Some(&mission), current).is_landing;
        let auto = flying(3, 10);
        assert_eq!(is_landing(&auto, Some(1)), Some(true));
        assert_eq!(is_landing(&auto, Some(0)), Some(false));
        let px4 = flying(12, 4 << 16 | 4 << 24);
        assert_eq!(is_landing(&px4, Some(1)), Some(true));
        assert_eq!(is_landing(&flying(3, 26), Some(0)), Some(true), "AUTOLAND");
        assert_eq!(is_landing(&flying(3, 11), Some(1)), Some(false), "RTL");
        let flares = ExtendedState { landed: LandedState::Landing, vtol: None };
        assert_eq!(is_landing(&Telemetry { extended: sampled(flares), ..flying(3, 5) }, None), Some(true));
        let landed = ExtendedState { landed: LandedState::OnGround, vtol: None };
        assert_eq!(is_landing(&Telemetry { extended: sampled(landed), ..auto }, Some(1)), Some(false));
        assert_eq!(is_landing(&auto, None), None);
        assert_eq!(Conduct::of(&auto, None, Some(1)).is_landing, None);
        assert_eq!(Conduct::of(&Telemetry::default(), None, None), Conduct::default());
    }

    #[test]
    fn an_approach_is_what_lies_between_its_start_and_the_landing() {
        let waypoint = MissionItem::waypoint(40.0, -3.0, 50.0);
        let start = MissionItem::action(Command::DO_LAND_START, [0.0; 4]);
        let land = MissionItem::land(40.0, -3.0, 0.0);
        let items = vec![waypoint.clone(), start.clone(), waypoint.clone(), land, waypoint.clone(), start, waypoint];
        let mission = Mission { home: None, items };
        let found: Vec<_> = (0..8).map(|index| leads_to_landing(&mission, index)).collect();
        assert_eq!(found, [false, true, true, true, false, false, false, false]);
    }

    #[test]
    fn it_follows_its_mission_in_the_mode_for_that_alone() {
        let follows = |autopilot, mode| Conduct::of(&flying(autopilot, mode), None, None).follows_mission;
        assert_eq!([10, 15, 8, 12].map(|mode| follows(3, mode)), [true, false, false, false].map(Some));
        assert_eq!(follows(12, 4 << 16 | 4 << 24), Some(true));
        assert_eq!(Conduct::of(&Telemetry::default(), None, None).follows_mission, None);
    }

    #[test]
    fn a_plane_that_circles_turns_as_its_bank_and_speed_say() {
        let turns_deg_s = |mode, roll_rad, airspeed_m_s: Option<f64>| {
            let telemetry = Telemetry {
                attitude: sampled(Attitude { roll_rad: Some(roll_rad), ..Attitude::default() }),
                hud: sampled(Hud { airspeed_m_s, groundspeed_m_s: Some(20.0), ..Hud::default() }),
                ..flying(3, mode)
            };
            Conduct::of(&telemetry, None, None).turn_rate_rad_s.map(|rate| (rate.to_degrees() * 100.0).round() / 100.0)
        };
        assert_eq!(turns_deg_s(12, PI / 6.0, Some(20.0)), Some(16.22));
        assert_eq!(turns_deg_s(12, -PI / 6.0, None), Some(-16.22));
        assert_eq!(turns_deg_s(12, 0.5, Some(0.0)), Some(0.0));
        assert_eq!(turns_deg_s(12, PI / 2.0 - 1e-4, Some(20.0)), Some(0.0));
        assert_eq!(turns_deg_s(10, PI / 6.0, Some(20.0)), None, "its turns end soon");
        assert_eq!(Conduct::of(&flying(3, 12), None, None).turn_rate_rad_s, None);
    }
}
