//! How far and how long a mission still is.
//!
//! The route is walked item by item as the autopilot would fly it: legs are geodesics, circles count with their
//! circumference, jumps are followed, and what an ArduPlane passes over has no length. What cannot be known is `None`,
//! never a guess at zero.

use std::collections::HashMap;

use crate::geodesy::{GeoPoint, LocalFrame, distance_m};
use crate::plan::{Command, MavFrame, Mission, MissionItem, Support};
use crate::radius::{named_radius_m, own_radius_m};

/// Ground speed below which no time is given, metres per second: the plane stands or hangs in the wind.
pub const MIN_GROUND_SPEED_M_S: f64 = 1.0;

/// What orders the vehicle's own airspeed, in the place of one.
const OWN_SPEED: f64 = -2.0;

/// Most items that a walk visits, repeats of jumps included; a longer mission has no known length.
const MAX_STEPS: usize = 100_000;

/// What the walk needs to know of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgressOptions {
    /// Radius of circles that give none, metres; negative where they turn anticlockwise, whatever the item's sense.
    /// Default 60 (`WP_LOITER_RAD` of ArduPlane; one of 1 m and less counts as it does there, see [`own_radius_m`]).
    pub loiter_radius_m: f64,
    /// Speed of climb and descent in a loiter-to-height, metres per second. Default 2.5.
    pub climb_rate_m_s: f64,
    /// Whether it flies the arcs of `NAV_ARC_WAYPOINT`, as ArduCopter does from 4.7 on; ArduPlane passes them over.
    /// Default `false`.
    pub flies_arcs: bool,
    /// Its own speed, that a mission goes back to where it orders -2 (`AIRSPEED_CRUISE` of ArduPlane), metres per
    /// second; `None`, the default: not known.
    pub own_speed_m_s: Option<f64>,
    /// Lowest airspeed that a mission may order (`AIRSPEED_MIN`), metres per second; lower ones are ignored, as are
    /// those above the highest (`AIRSPEED_MAX`). `None`, the default: unknown, no limit.
    pub airspeed_min_m_s: Option<f64>,
    /// Highest airspeed; as `airspeed_min_m_s`.
    pub airspeed_max_m_s: Option<f64>,
}

impl Default for ProgressOptions {
    fn default() -> Self {
        Self {
            loiter_radius_m: 60.0,
            climb_rate_m_s: 2.5,
            flies_arcs: false,
            own_speed_m_s: None,
            airspeed_min_m_s: None,
            airspeed_max_m_s: None,
        }
    }
}

/// How much was flown of the circle at the item in execution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Circled {
    /// None: the plane is on its way there, or the item has no circle.
    #[default]
    Nothing,
    /// This much since it was reached.
    Flown {
        /// Turns about the centre, in the circle's own sense.
        turns: f64,
        /// Time on it by the vehicle's clock, s.
        time_s: f64,
    },
    /// The plane circles, and the beginning was missed.
    Unknown,
}

impl Circled {
    /// Turns, and seconds, that were flown, where they are known.
    pub fn flown(self) -> Option<(f64, f64)> {
        match self {
            Self::Flown { turns, time_s } => Some((turns, time_s)),
            Self::Nothing | Self::Unknown => None,
        }
    }
}

/// Remaining part of a mission.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Remaining {
    /// Distance to the end of the mission, metres. `None` when it has no end (a jump for ever), needs a
    /// home that is unknown, or holds an item of unknown length.
    pub distance_m: Option<f64>,
    /// Time to the end, seconds. `None` when the distance is, or without ground speed.
    pub time_s: Option<f64>,
    /// Distance to the current destination, metres. `None` without one.
    pub leg_m: Option<f64>,
}

/// How a mission ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), serde(rename_all = "snake_case"))]
pub enum TripEnd {
    /// At its landing, its return to launch or after its last item.
    End,
    /// In a circle without end.
    Unlimited,
    /// Never: a jump repeats for ever.
    Endless,
}

/// A mission as it is flown, in calm air at the speeds that are known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct Trip {
    /// Length of the way over ground, circles included, metres; up to the circle without end where it ends in one. Null
    /// when it never ends, needs a home that is unknown, or holds an item of unknown length.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub distance_m: Option<f64>,
    /// Time for that, seconds; null when the distance is, or without a speed.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub time_s: Option<f64>,
    /// How it ends.
    pub end: TripEnd,
    /// Whether the distance depends on values that are not in the plan: a speed, a climb rate, the vehicle's own
    /// radius.
    pub is_estimate: bool,
}

impl Trip {
    const UNKNOWN: Self = Self { distance_m: None, time_s: None, end: TripEnd::End, is_estimate: false };
    const ENDLESS: Self = Self { end: TripEnd::Endless, ..Self::UNKNOWN };
}

/// The whole mission from home, or from its first destination when home is unknown, begun at this speed (m/s), which is
/// the vehicle's own.
pub fn trip(mission: &Mission, speed_m_s: Option<f64>, options: &ProgressOptions) -> Trip {
    let home = mission.home.and_then(|home| home.point().ok());
    match home.or_else(|| mission.items.iter().find_map(|item| place(item, options))) {
        Some(start) => walk(
            mission,
            0,
            start,
            Circled::Nothing,
            speed_m_s,
            &ProgressOptions { own_speed_m_s: speed_m_s, ..*options },
        ),
        None => Trip::UNKNOWN,
    }
}

/// The remaining mission from a position, with the item in execution at `current_index` of `mission.items` (on
/// ArduPilot the seq of `MISSION_CURRENT` minus 1).
///
/// The mission ends at its first landing, at a loiter without end, at a return to launch, or after its last item.
/// Repeats of jumps that are already flown are not known and count as still to come; of the loiter in execution what
/// was flown counts where it is known. A take-off counts no distance: its place is not flown to. Changes of speed on
/// the way are taken as ground speeds; where one goes back to the vehicle's own, which is not known, no time is given.
pub fn remaining(
    mission: &Mission,
    current_index: usize,
    position: GeoPoint,
    circled: Circled,
    ground_speed_m_s: Option<f64>,
    options: &ProgressOptions,
) -> Remaining {
    let leg_m = destination(mission, current_index, options).map(|(index, point)| {
        let item = &mission.items[index];
        let start = mission.items[..index].iter().rev().find_map(|item| place(item, options));
        way_m(item, start, position, point)
    });
    let Trip { distance_m, time_s, .. } = walk(mission, current_index, position, circled, ground_speed_m_s, options);
    Remaining { distance_m, time_s, leg_m }
}

/// Where the plane flies to at an item: its own place, or that of the next item that has one; with that item's index.
fn destination(mission: &Mission, index: usize, options: &ProgressOptions) -> Option<(usize, GeoPoint)> {
    for (offset, item) in mission.items.get(index..)?.iter().enumerate() {
        if let Some(point) = place(item, options) {
            return Some((index + offset, point));
        }
        if item.command == Command::NAV_RETURN_TO_LAUNCH {
            return Some((index + offset, mission.home?.point().ok()?));
        }
        if item.command == Command::DO_JUMP || item.command == Command::DO_JUMP_TAG {
            return None;
        }
    }
    None
}

/// The place of an item that a plane flies to; what an ArduPlane stores and passes over has none.
pub(crate) fn target(item: &MissionItem) -> Option<GeoPoint> {
    let is_passed_over = item.command.info().is_some_and(|info| info.support == Support::Ignored);
    item.point().filter(|_| item.command.is_destination() && !is_passed_over)
}

/// The place of an item that this vehicle flies to.
pub(crate) fn place(item: &MissionItem, options: &ProgressOptions) -> Option<GeoPoint> {
    if options.flies_arcs && item.command == Command::NAV_ARC_WAYPOINT { item.point() } else { target(item) }
}

/// Length of the way from a position to an item's place: of the rest of the arc that began at `start`, else straight.
fn way_m(item: &MissionItem, start: Option<GeoPoint>, position: GeoPoint, to: GeoPoint) -> f64 {
    let straight_m = distance_m(position, to);
    if item.command != Command::NAV_ARC_WAYPOINT {
        return straight_m;
    }
    let angle_deg = item.param(1).unwrap_or(0.0);
    start.and_then(|start| rest_of_arc_m(start, to, angle_deg, position)).unwrap_or(straight_m)
}

/// Length along the arc from the point nearest to `position` to the end, metres. `None` where there is no arc (no
/// angle, a full turn, both ends in one place), and for a position that is not beside it.
///
/// `NAV_ARC_WAYPOINT` in MAVLink's common.xml: a circular arc in the north-east plane that turns by param1 degrees,
/// clockwise positive, from the place before to this one; its radius is the chord over 2 sin(angle / 2).
fn rest_of_arc_m(from: GeoPoint, to: GeoPoint, angle_deg: f64, position: GeoPoint) -> Option<f64> {
    let turn = angle_deg.to_radians();
    let half_sin = (turn / 2.0).sin();
    let frame = LocalFrame::new(to, 0.0);
    let [north, east, _] = frame.ned_m(from, 0.0);
    let chord_m = north.hypot(east);
    if turn.abs() >= std::f64::consts::TAU || half_sin.abs() < 1e-3 || chord_m < 0.01 {
        return None;
    }
    let radius_m = chord_m / 2.0 / half_sin.abs();
    // The centre: at right angles to the way in which the end is left, on the side to which it turns.
    let out = (-east).atan2(-north) + turn / 2.0 + std::f64::consts::FRAC_PI_2.copysign(turn);
    let centre = [radius_m * out.cos(), radius_m * out.sin()];
    let [north, east, _] = frame.ned_m(position, 0.0);
    let bearing = |north: f64, east: f64| (east - centre[1]).atan2(north - centre[0]);
    let left = ((bearing(0.0, 0.0) - bearing(north, east)) * turn.signum()).rem_euclid(std::f64::consts::TAU);
    // The start is on the arc, whatever rounding says.
    (left <= turn.abs() + 1e-6).then_some(left * radius_m)
}

/// Height above mean sea level of an item with a position, metres; `None` above terrain or without home.
pub(crate) fn alt_amsl_m(item: &MissionItem, home_alt_amsl_m: Option<f64>) -> Option<f64> {
    let alt_m = item.alt_m()?;
    match item.frame {
        MavFrame::Global | MavFrame::Mission => Some(alt_m),
        MavFrame::GlobalRelativeAlt => home_alt_amsl_m.map(|home_m| home_m + alt_m),
        MavFrame::GlobalTerrainAlt | MavFrame::Other(_) => None,
    }
}

/// Height above home of an item with a position, metres; `None` above terrain, and above the sea without home.
pub(crate) fn rel_home_m(item: &MissionItem, home_alt_amsl_m: Option<f64>) -> Option<f64> {
    match item.frame {
        MavFrame::GlobalRelativeAlt => item.alt_m(),
        _ => Some(alt_amsl_m(item, home_alt_amsl_m)? - home_alt_amsl_m?),
    }
}

/// The way along the mission from an item on.
fn walk(
    mission: &Mission,
    start_index: usize,
    start: GeoPoint,
    mut circled: Circled,
    ground_speed_m_s: Option<f64>,
    options: &ProgressOptions,
) -> Trip {
    let home_alt_amsl_m = mission.home.map(|home| home.alt_amsl_m);
    let mut point = start;
    // Where the leg begins that the position is on.
    let before = mission.items.get(..start_index).unwrap_or_default();
    let mut leg_start = before.iter().rev().find_map(|item| place(item, options)).or(Some(start));
    let mut alt_m = None;
    let mut pace = Pace::new(ground_speed_m_s.filter(|speed| *speed >= MIN_GROUND_SPEED_M_S));
    let mut distance_total_m = 0.0;
    let mut time_total_s = Some(0.0);
    let mut is_estimate = false;
    let mut repeats_left: HashMap<usize, u32> = HashMap::new();
    let mut index = start_index;

    for _ in 0..MAX_STEPS {
        let Some(item) = mission.items.get(index) else {
            return Trip { distance_m: Some(distance_total_m), time_s: time_total_s, end: TripEnd::End, is_estimate };
        };
        // Of the item in execution: where a jump leads back to it, it is flown whole.
        let (turns_flown, time_flown_s) = std::mem::take(&mut circled).flown().unwrap_or_default();
        index += 1;
        pace.order(item, options);
        let speed_m_s = pace.m_s();
        let mut leg_m = 0.0;
        let mut wait_s = 0.0;
        let mut end = None;
        if let Some(there) = place(item, options) {
            leg_m = way_m(item, leg_start, point, there);
            point = there;
            leg_start = Some(there);
        }
        match item.command {
            Command::NAV_RETURN_TO_LAUNCH => {
                let Some(home) = mission.home.and_then(|home| home.point().ok()) else { return Trip::UNKNOWN };
                leg_m = distance_m(point, home);
                end = Some(TripEnd::End);
            }
            Command::NAV_LAND | Command::NAV_VTOL_LAND => end = Some(TripEnd::End),
            Command::NAV_LOITER_UNLIM => end = Some(TripEnd::Unlimited),
            Command::NAV_LOITER_TURNS => {
                let item_m =
                    item.param(3).map(|radius_m| named_radius_m(radius_m).abs()).filter(|radius_m| *radius_m > 0.0);
                is_estimate |= item_m.is_none();
                let radius_m = item_m.unwrap_or_else(|| own_radius_m(options.loiter_radius_m).abs());
                let turns = (item.param(1).unwrap_or(0.0) - turns_flown).max(0.0);
                leg_m += turns * std::f64::consts::TAU * radius_m;
            }
            // A plane in the air passes NAV_DELAY over (`ModeAuto::verify_nav_delay`).
            Command::NAV_LOITER_TIME => {
                wait_s = (item.param(1).unwrap_or(0.0) - time_flown_s).max(0.0);
            }
            Command::NAV_SCRIPT_TIME => wait_s = item.param(2).unwrap_or(0.0).max(0.0),
            Command::NAV_LOITER_TO_ALT => {
                let change_m = alt_amsl_m(item, home_alt_amsl_m)
                    .zip(alt_m)
                    .map_or(0.0, |(to_m, from_m): (f64, f64)| (to_m - from_m).abs());
                is_estimate = true;
                if options.climb_rate_m_s > 0.0 {
                    let climb_s = change_m / options.climb_rate_m_s;
                    // it climbs on the leg already
                    wait_s = speed_m_s.map_or(0.0, |speed| (climb_s - leg_m / speed).max(0.0));
                }
            }
            Command::NAV_CONTINUE_AND_CHANGE_ALT | Command::NAV_ALTITUDE_WAIT => return Trip::UNKNOWN,
            Command::DO_JUMP | Command::DO_JUMP_TAG => {
                let Some(to) = jump_index(&mission.items, item) else { return Trip::UNKNOWN };
                let repeats = item.param(2).unwrap_or(0.0);
                if repeats < 0.0 {
                    return Trip::ENDLESS;
                }
                let left = repeats_left.entry(index).or_insert(repeats as u32);
                if *left > 0 {
                    *left -= 1;
                    index = to;
                }
                continue;
            }
            _ => {}
        }
        alt_m = alt_amsl_m(item, home_alt_amsl_m).or(alt_m);
        is_estimate |= wait_s > 0.0;
        distance_total_m += leg_m + speed_m_s.map_or(0.0, |speed| speed * wait_s);
        time_total_s = time_total_s.zip(speed_m_s).map(|(time_s, speed)| time_s + leg_m / speed + wait_s);
        if let Some(end) = end {
            return Trip { distance_m: Some(distance_total_m), time_s: time_total_s, end, is_estimate };
        }
    }
    Trip::UNKNOWN
}

/// How fast a mission is flown, as its `DO_CHANGE_SPEED` items order it (`Plane::do_change_speed` of ArduPilot).
#[derive(Clone, Copy)]
pub(crate) struct Pace {
    /// In calm air; `None`: not known.
    speed_m_s: Option<f64>,
    /// Lowest ground speed: in calm air the plane flies no slower.
    least_m_s: f64,
}

impl Pace {
    pub(crate) const fn new(speed_m_s: Option<f64>) -> Self {
        Self { speed_m_s, least_m_s: 0.0 }
    }

    pub(crate) fn m_s(self) -> Option<f64> {
        self.speed_m_s.map(|speed_m_s| speed_m_s.max(self.least_m_s))
    }

    /// Takes what an item orders; airspeeds that the vehicle does not take, climb rates and other items change nothing.
    pub(crate) fn order(&mut self, item: &MissionItem, options: &ProgressOptions) {
        let Some(speed_m_s) = item.param(2).filter(|_| item.command == Command::DO_CHANGE_SPEED) else { return };
        let kind = item.param(1).unwrap_or(0.0) as i64;
        let is_taken = options.airspeed_min_m_s.is_none_or(|min| speed_m_s >= min)
            && options.airspeed_max_m_s.is_none_or(|max| speed_m_s <= max);
        match kind {
            0 if speed_m_s == OWN_SPEED => self.speed_m_s = self.speed_m_s.and(options.own_speed_m_s),
            0 if speed_m_s >= MIN_GROUND_SPEED_M_S && is_taken => self.speed_m_s = self.speed_m_s.map(|_| speed_m_s),
            1 if speed_m_s >= 0.0 => self.least_m_s = speed_m_s,
            _ => {}
        }
    }
}

/// Index in a mission's items of the target of a jump; `None` when there is no such item.
pub(crate) fn jump_index(items: &[MissionItem], jump: &MissionItem) -> Option<usize> {
    let target = jump.param(1).filter(|target| target.fract() == 0.0 && *target >= 0.0)?;
    if jump.command == Command::DO_JUMP_TAG {
        return items.iter().position(|item| item.command == Command::JUMP_TAG && item.param(1) == Some(target));
    }
    // seq 0 is home
    let index = (target as usize).checked_sub(1)?;
    (index < items.len()).then_some(index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::direct;
    use crate::plan::Home;
    use vencejo_proto::MissionSeq;

    const HOME: Home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };

    fn north(distance_m: f64) -> (f64, f64) {
        let point = direct(HOME.point().unwrap(), 0.0, distance_m);
        (point.lat_deg(), point.lon_deg())
    }

    fn waypoint(distance_m: f64) -> MissionItem {
        let (lat_deg, lon_deg) = north(distance_m);
        MissionItem::waypoint(lat_deg, lon_deg, 100.0)
    }

    fn check(items: Vec<MissionItem>, expected: Option<(f64, f64)>) {
        let mission = Mission { home: Some(HOME), items };
        let found =
            remaining(&mission, 0, HOME.point().unwrap(), Circled::Nothing, Some(10.0), &ProgressOptions::default());
        match expected {
            None => assert_eq!((found.distance_m, found.time_s), (None, None)),
            Some((distance_m, time_s)) => {
                assert!((found.distance_m.unwrap() - distance_m).abs() < 0.01, "{found:?}");
                assert!((found.time_s.unwrap() - time_s).abs() < 0.01, "{found:?}");
            }
        }
    }

    #[test]
    fn what_was_flown_of_a_circle_is_not_flown_again() {
        let (lat_deg, lon_deg) = north(0.0);
        let seconds = |item: &MissionItem, circled, repeats| {
            let items = vec![item.clone(), waypoint(0.0), MissionItem::jump(MissionSeq(1), repeats)];
            let mission = Mission { home: Some(HOME), items };
            let here = HOME.point().unwrap();
            remaining(&mission, 0, here, circled, Some(10.0), &ProgressOptions::default()).time_s.unwrap()
        };
        let flown = |turns, time_s| Circled::Flown { turns, time_s };
        let turns = MissionItem::loiter_turns(lat_deg, lon_deg, 100.0, 3.0, 50.0);
        let waits = MissionItem::loiter_time(lat_deg, lon_deg, 100.0, 60.0, true);
        let turn_s = std::f64::consts::TAU * 5.0;
        for (item, circled, whole_s, rest_s) in [
            (&turns, Circled::Unknown, 3.0 * turn_s, 3.0 * turn_s),
            (&turns, flown(2.5, 400.0), 3.0 * turn_s, 0.5 * turn_s),
            (&turns, flown(3.2, 400.0), 3.0 * turn_s, 0.0),
            (&waits, Circled::Nothing, 60.0, 60.0),
            (&waits, flown(9.0, 45.0), 60.0, 15.0),
        ] {
            // A jump leads back to the whole of it.
            for repeats in [0, 2] {
                let found_s = seconds(item, circled, repeats);
                let expected_s = rest_s + f64::from(repeats) * whole_s;
                assert!((found_s - expected_s).abs() < 0.01, "{circled:?}, {repeats} repeats: {found_s}");
            }
        }
    }

    #[test]
    fn legs_add_up_and_the_landing_ends() {
        let (lat_deg, lon_deg) = north(500.0);
        let land = MissionItem::land(lat_deg, lon_deg, 0.0);
        check(vec![waypoint(1_000.0), waypoint(2_000.0), land, waypoint(9_000.0)], Some((3_500.0, 350.0)));
        check(vec![], Some((0.0, 0.0)));
    }

    #[test]
    fn a_take_off_counts_nothing_and_a_return_counts_to_home() {
        let takeoff = MissionItem::takeoff(41.0, -3.0, 50.0, 12.0);
        check(vec![takeoff, waypoint(1_000.0), MissionItem::return_to_launch()], Some((2_000.0, 200.0)));
    }

    #[test]
    fn circles_and_waiting_count() {
        let (lat_deg, lon_deg) = north(1_000.0);
        let turns = |radius_m| MissionItem::loiter_turns(lat_deg, lon_deg, 100.0, 2.0, radius_m);
        let circles_m = 2.0 * std::f64::consts::TAU * 50.0;
        check(vec![turns(-50.0)], Some((1_000.0 + circles_m, (1_000.0 + circles_m) / 10.0)));
        let anticlockwise = ProgressOptions { loiter_radius_m: -50.0, ..ProgressOptions::default() };
        let mission = Mission { home: Some(HOME), items: vec![turns(0.0)] };
        let by_own_m = trip(&mission, None, &anticlockwise).distance_m.unwrap();
        assert!((by_own_m - 1_000.0 - circles_m).abs() < 0.01, "{by_own_m}");
        let time = MissionItem::loiter_time(lat_deg, lon_deg, 100.0, 30.0, true);
        check(vec![time], Some((1_300.0, 130.0)));
        let unlimited = MissionItem::loiter_unlimited(lat_deg, lon_deg, 100.0, 0.0);
        check(vec![unlimited, waypoint(5_000.0)], Some((1_000.0, 100.0)));
        // 300 m up at 2.5 m/s are 120 s, of which 10 pass on the leg of 100 m
        let (lat_deg, lon_deg) = north(1_100.0);
        let to_alt = MissionItem::loiter_to_alt(lat_deg, lon_deg, 400.0, 60.0);
        check(vec![waypoint(1_000.0), to_alt], Some((2_200.0, 220.0)));
    }

    #[test]
    fn a_trip_says_how_it_ends_and_what_it_rests_on() {
        let of = |items: Vec<MissionItem>| {
            let mission = Mission { home: Some(HOME), items };
            trip(&mission, Some(20.0), &ProgressOptions::default())
        };
        let (lat_deg, lon_deg) = north(1_000.0);
        let turns = |radius_m| MissionItem::loiter_turns(lat_deg, lon_deg, 100.0, 1.0, radius_m);
        assert!(!of(vec![turns(-100.0)]).is_estimate);
        assert!(of(vec![turns(0.0)]).is_estimate, "the vehicle's own radius, which may be another");
        let unlimited = of(vec![MissionItem::loiter_unlimited(lat_deg, lon_deg, 100.0, 0.0), waypoint(9_000.0)]);
        assert_eq!((unlimited.end, unlimited.is_estimate), (TripEnd::Unlimited, false));
        assert!((unlimited.distance_m.unwrap() - 1_000.0).abs() < 0.1);
        assert_eq!(of(vec![waypoint(1_000.0), MissionItem::jump(MissionSeq(1), -1)]), Trip::ENDLESS);
        assert_eq!(of(vec![waypoint(1_000.0), MissionItem::jump(MissionSeq(9), 1)]), Trip::UNKNOWN);
        let slower = MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, 10.0, -1.0, 0.0]);
        let found = of(vec![slower, MissionItem::loiter_time(lat_deg, lon_deg, 100.0, 30.0, true)]);
        assert!((found.time_s.unwrap() - 130.0).abs() < 0.1 && found.is_estimate, "{found:?}");
        assert_eq!(trip(&Mission::default(), Some(20.0), &ProgressOptions::default()), Trip::UNKNOWN);
    }

    #[test]
    fn the_vehicles_own_speed_comes_back() {
        let (lat_deg, lon_deg) = north(2_000.0);
        let waits = MissionItem::loiter_time(lat_deg, lon_deg, 100.0, 30.0, true);
        let change = MissionItem::change_airspeed;
        let items = vec![change(10.0), waypoint(1_000.0), change(-2.0), waits];
        let mission = Mission { home: Some(HOME), items };
        // 1,000 m at 10 m/s, then 1,000 m and 30 s at 20 m/s.
        let found = trip(&mission, Some(20.0), &ProgressOptions::default());
        assert!((found.time_s.unwrap() - 180.0).abs() < 0.1 && (found.distance_m.unwrap() - 2_600.0).abs() < 0.1);
        // In flight that is not the speed over ground at the moment.
        let known = ProgressOptions { own_speed_m_s: Some(20.0), ..ProgressOptions::default() };
        let left =
            |options| remaining(&mission, 1, HOME.point().unwrap(), Circled::Nothing, Some(10.0), options).time_s;
        assert!((left(&known).unwrap() - 180.0).abs() < 0.1);
        assert_eq!(left(&ProgressOptions::default()), None);
    }

    #[test]
    fn jumps_are_followed() {
        let lap = |repeats| vec![waypoint(1_000.0), waypoint(2_000.0), MissionItem::jump(MissionSeq(1), repeats)];
        check(lap(0), Some((2_000.0, 200.0)));
        check(lap(2), Some((6_000.0, 600.0)));
        check(lap(-1), None);
        check(vec![MissionItem::jump(MissionSeq(9), 1)], None);
        // a mission of jumps alone ends too
        check(vec![MissionItem::jump(MissionSeq(1), 32_767)], Some((0.0, 0.0)));
        let tag = MissionItem::action(Command::JUMP_TAG, [7.0, 0.0, 0.0, 0.0]);
        let to_tag = MissionItem::action(Command::DO_JUMP_TAG, [7.0, 1.0, 0.0, 0.0]);
        check(vec![tag, waypoint(1_000.0), waypoint(2_000.0), to_tag], Some((4_000.0, 400.0)));
    }

    #[test]
    fn speed_changes_and_no_speed() {
        check(vec![waypoint(1_000.0), MissionItem::change_airspeed(20.0), waypoint(2_000.0)], Some((2_000.0, 150.0)));
        let mission = Mission { home: Some(HOME), items: vec![waypoint(1_000.0), waypoint(3_000.0)] };
        let here = HOME.point().unwrap();
        for speed in [None, Some(0.3)] {
            let found = remaining(&mission, 1, here, Circled::Nothing, speed, &ProgressOptions::default());
            assert_eq!(found.time_s, None);
            assert!((found.distance_m.unwrap() - 3_000.0).abs() < 0.01);
            assert!((found.leg_m.unwrap() - 3_000.0).abs() < 0.01);
        }
        let past_the_end = remaining(&mission, 7, here, Circled::Nothing, Some(10.0), &ProgressOptions::default());
        assert_eq!(past_the_end, Remaining { distance_m: Some(0.0), time_s: Some(0.0), leg_m: None });
    }

    #[test]
    fn arcs_have_the_length_of_arcs_where_they_are_flown() {
        let arc = |distance_m: f64, angle_deg: f64| MissionItem {
            command: Command::NAV_ARC_WAYPOINT,
            params: [
                Some(angle_deg),
                None,
                None,
                None,
                waypoint(distance_m).params[4],
                waypoint(distance_m).params[5],
                Some(100.0),
            ],
            ..waypoint(distance_m)
        };
        let pi = std::f64::consts::PI;
        let copter = ProgressOptions { flies_arcs: true, ..ProgressOptions::default() };
        // From 1 km to 2 km north of home: chord 1,000 m.
        for (angle_deg, length_m) in [
            (180.0, pi * 500.0),
            (-180.0, pi * 500.0),
            (90.0, pi / 2.0 * 1_000.0 / 2.0_f64.sqrt()),
            (-270.0, pi * 1.5 * 1_000.0 / 2.0_f64.sqrt()),
            (1.0, 1_000.0),
            (0.0, 1_000.0),
            (360.0, 1_000.0),
        ] {
            let items = vec![waypoint(1_000.0), arc(2_000.0, angle_deg), waypoint(3_000.0)];
            let mission = Mission { home: Some(HOME), items };
            let found = trip(&mission, None, &copter).distance_m.unwrap();
            assert!((found - 2_000.0 - length_m).abs() < 0.05, "{angle_deg}: {found}");
            // On the way: the rest of the arc. It turns right, so half-way lies to the west of the chord.
            if angle_deg == 180.0 {
                let (lat_deg, lon_deg) = north(1_500.0);
                let middle = direct(GeoPoint::new(lat_deg, lon_deg).unwrap(), 270.0, 500.0);
                let left = remaining(&mission, 1, middle, Circled::Nothing, None, &copter);
                assert!((left.leg_m.unwrap() - length_m / 2.0).abs() < 0.1, "{left:?}");
                assert!((left.distance_m.unwrap() - length_m / 2.0 - 1_000.0).abs() < 0.1, "{left:?}");
                // Beside the arc, before its start: the straight line.
                let away = direct(middle, 90.0, 5_000.0);
                let left = remaining(&mission, 1, away, Circled::Nothing, None, &copter);
                assert!((left.leg_m.unwrap() - distance_m(away, arc(2_000.0, 0.0).point().unwrap())).abs() < 0.01);
            }
            // ArduPlane goes straight from the first to the last.
            assert!((trip(&mission, None, &ProgressOptions::default()).distance_m.unwrap() - 3_000.0).abs() < 0.01);
            let left =
                remaining(&mission, 1, HOME.point().unwrap(), Circled::Nothing, None, &ProgressOptions::default());
            assert!((left.leg_m.unwrap() - 3_000.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_speed_that_the_vehicle_does_not_take_changes_nothing() {
        let to =
            |kind: f64, speed_m_s: f64| MissionItem::action(Command::DO_CHANGE_SPEED, [kind, speed_m_s, -1.0, 0.0]);
        let options = ProgressOptions {
            airspeed_min_m_s: Some(12.0),
            airspeed_max_m_s: Some(30.0),
            ..ProgressOptions::default()
        };
        for (kind, speed_m_s, flown_m_s) in [
            (0.0, 8.0, 20.0),
            (0.0, 31.0, 20.0),
            (0.0, 15.0, 15.0),
            (1.0, 8.0, 20.0),
            (1.0, 25.0, 25.0),
            (2.0, 3.0, 20.0),
        ] {
            let mission = Mission { home: Some(HOME), items: vec![to(kind, speed_m_s), waypoint(3_000.0)] };
            let time_s = trip(&mission, Some(20.0), &options).time_s.unwrap();
            assert!((time_s - 3_000.0 / flown_m_s).abs() < 0.1, "{kind} {speed_m_s}: {time_s}");
        }
        // Nor does a wait that holds a plane on the ground alone.
        let wait = MissionItem::action(Command::NAV_DELAY, [60.0, -1.0, -1.0, -1.0]);
        check(vec![wait, waypoint(1_000.0)], Some((1_000.0, 100.0)));
    }

    #[test]
    fn a_whole_mission_has_a_length() {
        let mut mission = Mission { home: Some(HOME), items: vec![waypoint(1_000.0), waypoint(3_000.0)] };
        let length_m = |mission: &Mission| trip(mission, None, &ProgressOptions::default()).distance_m;
        assert!((length_m(&mission).unwrap() - 3_000.0).abs() < 0.01);
        mission.home = None;
        assert!((length_m(&mission).unwrap() - 2_000.0).abs() < 0.01);
        assert_eq!(length_m(&Mission::default()), None);
    }
}
