//! The plane that is rehearsed: its autopilot's settings, and what its airframe can do.

use super::air::is_ardupilots_simulator;
use super::airframe::Airframe;
use super::battery::{Battery, BatterySettings};
use super::failsafe::Failsafes;
use crate::guidance::attitude::AttitudeParams;
use crate::guidance::l1::{L1Params, Turn};
use crate::guidance::pilot::PilotParams;
use crate::guidance::tecs::TecsParams;
use crate::radius::own_radius_m;

/// When a return to launch turns into the mission's own landing (`RTL_AUTOLAND`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Autoland {
    /// Never: the plane circles over home or its rally point.
    #[default]
    Never,
    /// Once it circles there.
    AfterReturn,
    /// At once.
    AtOnce,
    /// At once, on the nearest leg after a DO_RETURN_PATH_START.
    ReturnPath,
}

impl Autoland {
    /// What a value of `RTL_AUTOLAND` means for a return; 3, a landing for go-arounds alone, does not count.
    pub(crate) fn of_parameter(value: f64) -> Self {
        match value as i64 {
            1 => Self::AfterReturn,
            2 => Self::AtOnce,
            4 => Self::ReturnPath,
            _ => Self::Never,
        }
    }
}

/// An ArduPlane and its airframe. Defaults are those of a foam pusher with the parameters of ArduPilot's simulated
/// plane.
///
/// Values without a parameter have their source at the field, and can be learned from a recorded flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aircraft {
    /// Lateral guidance (`NAVL1_*`).
    pub l1: L1Params,
    /// Height and speed (`TECS_*`, `AIRSPEED_MIN`, `AIRSPEED_MAX`, `TRIM_THROTTLE`, `THR_SLEWRATE`).
    pub tecs: TecsParams,
    /// Attitude (`RLL_RATE_*`, `PTCH_RATE_*`…), where the airframe's moments are known.
    pub attitude: AttitudeParams,
    /// Cruise airspeed, m/s EAS; default 22 (`AIRSPEED_CRUISE`, before 4.5 `TRIM_ARSPD_CM`).
    pub airspeed_cruise_m_s: f64,
    /// Slowest speed over ground that the autopilot accepts, m/s; default 0, off (`MIN_GROUNDSPEED`).
    pub groundspeed_min_m_s: f64,
    /// Bank limit, degrees; default 45 (`ROLL_LIMIT_DEG`, before 4.5 `LIM_ROLL_CD`).
    pub bank_max_deg: f64,
    /// Bank limit near the ground, degrees; default 5 (`LEVEL_ROLL_LIMIT`).
    pub bank_level_deg: f64,
    /// Whether bank is limited by airspeed, and speed raised by bank; default yes (`STALL_PREVENTION`).
    pub prevents_stall: bool,
    /// Time from a bank error to its rate, s; default 0.5 (`RLL2SRV_TCONST`).
    pub roll_tau_s: f64,
    /// Fastest roll, degrees a second; default 0, no limit (`RLL2SRV_RMAX`).
    pub roll_rate_max_deg_s: f64,
    /// Time from a pitch error to its rate, s; default 0.5 (`PTCH2SRV_TCONST`).
    pub pitch_tau_s: f64,
    /// Highest pitch that height control asks for, degrees; default 15 (`TECS_PITCH_MAX` within `PTCH_LIM_MAX_DEG`).
    pub pitch_max_deg: f64,
    /// Lowest pitch that height control asks for, degrees; default −20 (`TECS_PITCH_MIN` within `PTCH_LIM_MIN_DEG`).
    pub pitch_min_deg: f64,
    /// Most throttle, 0 to 1; default 1 (`THR_MAX`).
    pub throttle_max: f64,
    /// Least throttle, 0 to 1; default 0 (`THR_MIN`; reverse thrust is not rehearsed).
    pub throttle_min: f64,
    /// Radius within which a waypoint counts, m; default 50 (`WP_RADIUS`).
    pub waypoint_radius_m: f64,
    /// Largest distance from a waypoint at which it counts, m; default 0: no limit (`WP_MAX_RADIUS`).
    pub waypoint_max_radius_m: f64,
    /// Radius of circles without their own, m, negative anticlockwise; default 60 (`WP_LOITER_RAD`).
    pub loiter_radius_m: f64,
    /// Bank that circles are widened for in thin air, degrees; default 0, off (`NAVL1_LIM_BANK`).
    pub loiter_bank_deg: f64,
    /// Smallest change of height that is flown as a slope, m; default 15 (`ALT_SLOPE_MIN`).
    pub slope_min_m: f64,
    /// How far above a climbing slope a new one begins, m; default 5 (`ALT_SLOPE_MAXHGT`).
    pub slope_max_above_m: f64,
    /// Whether climbs are flown at once, not as slopes (bit 10 of `FLIGHT_OPTIONS`).
    pub climbs_at_once: bool,
    /// Height of a return, m above home; negative keeps the height. Default 100 (`RTL_ALTITUDE`).
    pub return_height_m: f64,
    /// Radius of the circle that ends a return, m, negative anticlockwise; default 0, as other circles (`RTL_RADIUS`).
    pub return_radius_m: f64,
    /// Climb before a return turns, m; default 0 (`RTL_CLIMB_MIN`).
    pub return_climb_min_m: f64,
    /// How a return uses the mission's landing (`RTL_AUTOLAND`).
    pub autoland: Autoland,
    /// Distance from a rally point beyond which home is preferred, m; default 5,000 (`RALLY_LIMIT_KM`).
    pub rally_limit_m: f64,
    /// Whether home takes part beside rally points (`RALLY_INCL_HOME`).
    pub rally_includes_home: bool,
    /// Whether one of several inclusion zones of the fence is enough; default no (`FENCE_OPTIONS`, bit 1).
    pub is_fence_union: bool,
    /// Whether the autopilot knows the ground where the rehearsal does; default yes (`TERRAIN_ENABLE`).
    pub knows_terrain: bool,
    /// How far ahead it looks for rising ground while its height counts from it, m; default 2,000 (`TERRAIN_LOOKAHD`).
    pub terrain_lookahead_m: f64,
    /// Distance between two looks ahead, m; default 100 (`TERRAIN_SPACING`).
    pub terrain_spacing_m: f64,
    /// Whether the height of a return counts from the ground (bits 0 and 4 of `TERRAIN_FOLLOW`).
    pub return_follows_terrain: bool,
    /// Speed at which the nose may rise in a take-off run, m/s EAS; default 0, any (`TKOFF_ROTATE_SPD`).
    pub rotate_airspeed_m_s: f64,
    /// Wait between the start of a take-off and the throttle, s; default 0.2 (`TKOFF_THR_DELAY`).
    pub takeoff_delay_s: f64,
    /// Throttle of a take-off, 0 to 1; default 1 (`TKOFF_THR_MAX`).
    pub takeoff_throttle: f64,
    /// Time before the height of a take-off over which its least pitch fades, s; default 2 (`TKOFF_PLIM_SEC`).
    pub takeoff_level_off_s: f64,
    /// Height below which a take-off's bank is limited, m; default 10 (`TKOFF_LVL_ALT`).
    pub takeoff_level_height_m: f64,
    /// Whether a take-off is thrown or shot into the air, not rolled (`TKOFF_THR_MINACC` above 0).
    pub is_launched: bool,
    /// Height of the flare, m; default 3 (`LAND_FLARE_ALT`).
    pub flare_height_m: f64,
    /// The same as time to the ground, s; default 2 (`LAND_FLARE_SEC`).
    pub flare_time_s: f64,
    /// Part of the sink rate that the flare is taken to remove at once, 0 to 1; default 0.5 (`LAND_FLARE_AIM`).
    pub flare_aim: f64,
    /// Height of the pre-flare, m; default 10 (`LAND_PF_ALT`).
    pub preflare_height_m: f64,
    /// The same as time to the ground, s; default 6 (`LAND_PF_SEC`).
    pub preflare_time_s: f64,
    /// Airspeed of the pre-flare, m/s; default 0, off (`LAND_PF_ARSPD`).
    pub preflare_airspeed_m_s: f64,
    /// Airspeed of the approach, m/s; `None`: between cruise and slowest (`TECS_LAND_ARSPD`).
    pub approach_airspeed_m_s: Option<f64>,
    /// Part of a headwind that is added to the approach's airspeed, 0 to 1; default 0.5 (`LAND_WIND_COMP`).
    pub approach_wind_part: f64,
    /// Highest pitch of the flare, degrees; default 10 (`TECS_LAND_PMAX`; 0: as in flight).
    pub flare_pitch_max_deg: f64,
    /// Least pitch at touch-down, degrees; default 0 (`LAND_PITCH_DEG`).
    pub flare_pitch_deg: f64,
    /// Height below which the flare's sink rate is the one of touch-down, m; default 1 (`TECS_FLARE_HGT`).
    pub flare_hold_height_m: f64,
    /// Pitch that the autopilot adds to its demand, degrees (`PTCH_TRIM_DEG`, before 4.5 `TRIM_PITCH_CD`).
    pub pitch_trim_deg: f64,
    /// Its failsafes (`FS_*`, `THR_FAILSAFE`, `BATT_FS_*`).
    pub failsafes: Failsafes,
    /// Its battery (`BATT_*`).
    pub battery: Battery,
    /// What flies.
    pub airframe: Airframe,
}

impl Default for Aircraft {
    fn default() -> Self {
        let tecs = TecsParams::default();
        Self {
            l1: L1Params::default(),
            tecs,
            attitude: AttitudeParams::default(),
            airspeed_cruise_m_s: 22.0,
            groundspeed_min_m_s: 0.0,
            bank_max_deg: 45.0,
            bank_level_deg: 5.0,
            prevents_stall: true,
            roll_tau_s: 0.5,
            roll_rate_max_deg_s: 0.0,
            pitch_tau_s: 0.5,
            pitch_max_deg: 15.0,
            pitch_min_deg: -20.0,
            throttle_max: 1.0,
            throttle_min: 0.0,
            waypoint_radius_m: 50.0,
            waypoint_max_radius_m: 0.0,
            loiter_radius_m: 60.0,
            loiter_bank_deg: 0.0,
            slope_min_m: 15.0,
            slope_max_above_m: 5.0,
            climbs_at_once: false,
            return_height_m: 100.0,
            return_radius_m: 0.0,
            return_climb_min_m: 0.0,
            autoland: Autoland::Never,
            rally_limit_m: 5_000.0,
            rally_includes_home: false,
            is_fence_union: false,
            knows_terrain: true,
            terrain_lookahead_m: 2_000.0,
            terrain_spacing_m: 100.0,
            return_follows_terrain: false,
            rotate_airspeed_m_s: 0.0,
            takeoff_delay_s: 0.2,
            takeoff_throttle: 1.0,
            takeoff_level_off_s: 2.0,
            takeoff_level_height_m: 10.0,
            is_launched: false,
            flare_height_m: 3.0,
            flare_time_s: 2.0,
            flare_aim: 0.5,
            preflare_height_m: 10.0,
            preflare_time_s: 6.0,
            preflare_airspeed_m_s: 0.0,
            approach_airspeed_m_s: None,
            approach_wind_part: 0.5,
            flare_pitch_max_deg: 10.0,
            flare_pitch_deg: 0.0,
            flare_hold_height_m: 1.0,
            pitch_trim_deg: 0.0,
            failsafes: Failsafes::default(),
            battery: Battery::default(),
            airframe: Airframe::of_parameters(22.0, &tecs, 0.0),
        }
    }
}

impl Aircraft {
    /// From an ArduPlane's parameters; a name that `get` does not know keeps its default. Names from before ArduPlane
    /// 4.5 are read where the present one is absent.
    pub fn from_ardupilot(get: impl Fn(&str) -> Option<f64>) -> Self {
        // Since 4.5 a name and a unit may be another; the pair is one setting.
        let get = |name: &str| {
            let before = |old: &str, factor: f64| get(old).map(|value| value * factor);
            get(name).or_else(|| match name {
                "AIRSPEED_CRUISE" => before("TRIM_ARSPD_CM", 0.01),
                "AIRSPEED_MIN" => before("ARSPD_FBW_MIN", 1.0),
                "AIRSPEED_MAX" => before("ARSPD_FBW_MAX", 1.0),
                "MIN_GROUNDSPEED" => before("MIN_GNDSPD_CM", 0.01),
                "ROLL_LIMIT_DEG" => before("LIM_ROLL_CD", 0.01),
                "PTCH_LIM_MAX_DEG" => before("LIM_PITCH_MAX", 0.01),
                "PTCH_LIM_MIN_DEG" => before("LIM_PITCH_MIN", 0.01),
                "PTCH_TRIM_DEG" => before("TRIM_PITCH_CD", 0.01),
                "LAND_PITCH_DEG" => before("LAND_PITCH_CD", 0.01),
                "RTL_ALTITUDE" => before("ALT_HOLD_RTL", 0.01),
                "ALT_SLOPE_MIN" => before("GLIDE_SLOPE_MIN", 1.0),
                "ALT_SLOPE_MAXHGT" => before("GLIDE_SLOPE_THR", 1.0),
                _ => None,
            })
        };
        let get = |name: &str| get(name).filter(|value| value.is_finite());
        let pilot = PilotParams::from_ardupilot(get);
        let mut plane = Self { l1: pilot.l1, tecs: pilot.tecs, attitude: pilot.attitude, ..Self::default() };
        let read = |name: &str, into: &mut f64, factor: f64| {
            if let Some(value) = get(name) {
                *into = value * factor;
            }
        };
        read("AIRSPEED_CRUISE", &mut plane.airspeed_cruise_m_s, 1.0);
        read("MIN_GROUNDSPEED", &mut plane.groundspeed_min_m_s, 1.0);
        read("ROLL_LIMIT_DEG", &mut plane.bank_max_deg, 1.0);
        read("LEVEL_ROLL_LIMIT", &mut plane.bank_level_deg, 1.0);
        read("RLL2SRV_TCONST", &mut plane.roll_tau_s, 1.0);
        read("RLL2SRV_RMAX", &mut plane.roll_rate_max_deg_s, 1.0);
        read("PTCH2SRV_TCONST", &mut plane.pitch_tau_s, 1.0);
        read("THR_MAX", &mut plane.throttle_max, 0.01);
        read("THR_MIN", &mut plane.throttle_min, 0.01);
        read("WP_RADIUS", &mut plane.waypoint_radius_m, 1.0);
        read("WP_MAX_RADIUS", &mut plane.waypoint_max_radius_m, 1.0);
        plane.loiter_radius_m = get("WP_LOITER_RAD").map_or(plane.loiter_radius_m, own_radius_m);
        read("NAVL1_LIM_BANK", &mut plane.loiter_bank_deg, 1.0);
        read("ALT_SLOPE_MIN", &mut plane.slope_min_m, 1.0);
        read("ALT_SLOPE_MAXHGT", &mut plane.slope_max_above_m, 1.0);
        read("RTL_ALTITUDE", &mut plane.return_height_m, 1.0);
        read("RTL_RADIUS", &mut plane.return_radius_m, 1.0);
        read("RTL_CLIMB_MIN", &mut plane.return_climb_min_m, 1.0);
        read("RALLY_LIMIT_KM", &mut plane.rally_limit_m, 1_000.0);
        read("TERRAIN_LOOKAHD", &mut plane.terrain_lookahead_m, 1.0);
        read("TERRAIN_SPACING", &mut plane.terrain_spacing_m, 1.0);
        read("TKOFF_ROTATE_SPD", &mut plane.rotate_airspeed_m_s, 1.0);
        read("TKOFF_THR_DELAY", &mut plane.takeoff_delay_s, 0.1);
        read("TKOFF_PLIM_SEC", &mut plane.takeoff_level_off_s, 1.0);
        read("TKOFF_LVL_ALT", &mut plane.takeoff_level_height_m, 1.0);
        read("LAND_FLARE_ALT", &mut plane.flare_height_m, 1.0);
        read("LAND_FLARE_SEC", &mut plane.flare_time_s, 1.0);
        read("LAND_FLARE_AIM", &mut plane.flare_aim, 0.01);
        read("LAND_PF_ALT", &mut plane.preflare_height_m, 1.0);
        read("LAND_PF_SEC", &mut plane.preflare_time_s, 1.0);
        read("LAND_PF_ARSPD", &mut plane.preflare_airspeed_m_s, 1.0);
        read("LAND_WIND_COMP", &mut plane.approach_wind_part, 0.01);
        read("LAND_PITCH_DEG", &mut plane.flare_pitch_deg, 1.0);
        read("TECS_LAND_PMAX", &mut plane.flare_pitch_max_deg, 1.0);
        read("TECS_FLARE_HGT", &mut plane.flare_hold_height_m, 1.0);
        read("PTCH_TRIM_DEG", &mut plane.pitch_trim_deg, 1.0);

        let limit = |own: &str, outer: &str, default: f64| {
            let outer = get(outer).unwrap_or(default);
            get(own).filter(|own| *own != 0.0 && own.abs() < outer.abs()).unwrap_or(outer)
        };
        plane.pitch_max_deg = limit("TECS_PITCH_MAX", "PTCH_LIM_MAX_DEG", 20.0);
        plane.pitch_min_deg = limit("TECS_PITCH_MIN", "PTCH_LIM_MIN_DEG", -25.0);
        plane.prevents_stall = get("STALL_PREVENTION").is_none_or(|value| value != 0.0);
        plane.climbs_at_once = get("FLIGHT_OPTIONS").is_some_and(|value| value as i64 & (1 << 10) != 0);
        plane.rally_includes_home = get("RALLY_INCL_HOME").is_some_and(|value| value != 0.0);
        plane.is_fence_union = get("FENCE_OPTIONS").is_some_and(|value| value as i64 & 1 << 1 != 0);
        plane.knows_terrain = get("TERRAIN_ENABLE").is_none_or(|value| value != 0.0);
        plane.return_follows_terrain = get("TERRAIN_FOLLOW").is_some_and(|value| value as i64 & (1 | 1 << 4) != 0);
        plane.is_launched = get("TKOFF_THR_MINACC").is_some_and(|value| value > 0.0);
        plane.takeoff_throttle =
            get("TKOFF_THR_MAX").filter(|value| *value > 0.0).map_or(plane.throttle_max, |value| value * 0.01);
        plane.approach_airspeed_m_s = get("TECS_LAND_ARSPD").filter(|value| *value > 0.0);
        plane.autoland = get("RTL_AUTOLAND").map_or(Autoland::Never, Autoland::of_parameter);
        plane.failsafes = Failsafes::from_ardupilot(get);
        plane.battery = Battery::from_ardupilot(get);
        plane.airframe = if is_ardupilots_simulator(get) {
            Airframe::of_simulator(plane.airspeed_cruise_m_s, pilot.attitude.rudder_mix)
        } else {
            Airframe::of_parameters(plane.airspeed_cruise_m_s, &plane.tecs, plane.pitch_trim_deg)
        };
        plane
    }

    /// With an airframe and a battery chosen by the user, where given.
    #[must_use]
    pub fn with(self, airframe: Option<Airframe>, battery: Option<&BatterySettings>) -> Self {
        let said = battery.copied().unwrap_or_default();
        let airframe = airframe.unwrap_or(self.airframe);
        let power_cruise_w = said.power_cruise_w.or(airframe.power_cruise_w);
        Self { airframe: Airframe { power_cruise_w, ..airframe }, battery: self.battery.with(&said), ..self }
    }

    /// Airspeed of an approach without headwind, m/s EAS.
    pub fn approach_airspeed(&self) -> f64 {
        self.approach_airspeed_m_s.unwrap_or(0.5 * (self.airspeed_cruise_m_s + self.tecs.airspeed_min_m_s))
    }

    /// Radius (0 or 1 and less: the vehicle's own) and direction of a circle.
    pub(super) fn circle(&self, radius_m: f64, is_anticlockwise: bool) -> (f64, Turn) {
        if radius_m > 1.0 {
            return (radius_m, if is_anticlockwise { Turn::Anticlockwise } else { Turn::Clockwise });
        }
        let own_m = self.loiter_radius_m;
        let turn = if is_anticlockwise || own_m < 0.0 { Turn::Anticlockwise } else { Turn::Clockwise };
        (own_m.abs(), turn)
    }
}
