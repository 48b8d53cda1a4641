//! The way of a mission as it is drawn: to which items the vehicle flies, by which line, how far, and how it circles
//! there.
//!
//! The items are taken as they stand in the plan: jumps are not followed, and what comes after a landing or a circle
//! without end is there too, since a pilot edits it. Arcs are arcs, splines are curves, and to and from a circle it
//! goes along the tangent; radii and angles are those of the plan. Rounded corners and the effect of wind are shown by
//! the rehearsal.

use crate::geodesy::{GeoPoint, LocalFrame, direct, distance_m, inverse, points_along, wrap_360_deg};
use crate::landing::STEEP_SLOPE;
use crate::plan::{Command, MavFrame, Mission, MissionItem};
use crate::progress::{Pace, ProgressOptions, alt_amsl_m, jump_index, place, rel_home_m};
use crate::radius::{named_radius_m, own_radius_m};
use crate::words::words;

/// Turn between two points of a curve, degrees.
const STEP_DEG: f64 = 5.0;
/// Pieces of a spline.
const SPLINE_PIECES: u32 = 24;
/// A straight line of more than this is divided, since a map bends it.
const STRAIGHT_M: f64 = 20_000.0;
/// Two places as near as this are one.
const SAME_M: f64 = 0.01;
/// A tangent from one circle to another depends on its other end; after this many iterations it lies within
/// centimetres.
const TANGENT_ROUNDS: usize = 6;
/// A cubic spline is not entered or left faster than this many lengths of its leg (`AC_WPNav`, `SplineCurve` of
/// ArduPilot).
const SPLINE_SPEED: f64 = 4.0;

words! {
    /// Kind of leg.
    #[cfg_attr(feature = "describe", schema(as = WayLegKind))]
    LegKind {
        /// To a take-off's place, or from it.
        Takeoff = "takeoff",
        /// From one place to another.
        Flown = "flown",
        /// To a landing.
        Approach = "approach",
        /// Back home.
        Return = "return",
    }
}

words! {
    /// Until when the plane circles.
    #[cfg_attr(feature = "describe", schema(as = WayCircling))]
    Circling {
        /// So many turns.
        Turns = "turns",
        /// For a time.
        Time = "time",
        /// Until a height is reached.
        Height = "height",
        /// Without end.
        Unlimited = "unlimited",
    }
}

/// The line from one place to the next.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = WayLeg))]
pub struct Leg {
    /// The item that it comes from, counted from 1; null for home.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub from_item: Option<usize>,
    /// Its kind.
    pub kind: LegKind,
    /// From place to place, metres: of a tangent the straight line, of an arc the arc.
    pub length_m: f64,
    /// Course at its beginning from place to place, degrees from true north.
    pub course_deg: f64,
    /// The line that is flown, degrees: at a circle it begins or ends on it.
    pub lat_deg: Vec<f64>,
    /// The same points' longitudes.
    pub lon_deg: Vec<f64>,
    /// Of an approach, its descent; null for other legs, and where the two heights count from different levels.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub descent: Option<Descent>,
}

/// The descent of an approach.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = WayDescent))]
pub struct Descent {
    /// Height lost, metres.
    pub drop_m: f64,
    /// Whether it is steeper than [`STEEP_SLOPE`], or does not lead down.
    pub is_doubtful: bool,
}

impl Leg {
    /// The points of its line.
    pub fn points(&self) -> impl Iterator<Item = GeoPoint> {
        self.lat_deg.iter().zip(&self.lon_deg).filter_map(|(lat_deg, lon_deg)| GeoPoint::new(*lat_deg, *lon_deg).ok())
    }
}

/// So much steeper may a slope be that was meant to be just [`STEEP_SLOPE`]: places and heights are rounded.
const SLOPE_ROUNDING: f64 = 1e-3;

/// The circle at an item.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = WayLoiter))]
pub struct Loiter {
    /// Until when.
    pub kind: Circling,
    /// Radius, metres.
    pub radius_m: f64,
    /// Its sense.
    pub is_clockwise: bool,
    /// Whether the radius is the item's own; false where the vehicle flies its usual one (`WP_LOITER_RAD`).
    pub is_own_radius: bool,
    /// Way in it, metres; null when it has no end or is not known.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub length_m: Option<f64>,
    /// Time in it, seconds; null likewise.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub time_s: Option<f64>,
    /// Whether that depends on values that are not in the plan: a speed, a climb rate, the vehicle's own radius.
    pub is_estimate: bool,
    /// Of a circle to a height: how much of the change is done when it begins, 0 to 1; 1 for the others.
    pub changed_before: f64,
}

/// An item that the vehicle flies to.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = WayStop))]
pub struct Stop {
    /// It, counted from 1.
    pub item: usize,
    /// The way to it; null where the whole way begins there, or the place is the one before.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub leg: Option<Leg>,
    /// The circle there; null without one.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub loiter: Option<Loiter>,
}

/// Where a jump leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = WayJump))]
pub struct Jump {
    /// The jump, counted from 1.
    pub item: usize,
    /// The item that it leads to.
    pub to_item: usize,
}

/// A mission as it is drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Way {
    /// The items that the vehicle flies to, in the order of the plan.
    pub stops: Vec<Stop>,
    /// The jumps between them.
    pub jumps: Vec<Jump>,
}

#[derive(Clone, Copy)]
pub(crate) struct Circle {
    pub(crate) centre: GeoPoint,
    pub(crate) radius_m: f64,
    pub(crate) is_clockwise: bool,
}

/// A place on the way, with what was flown to.
struct Place<'a> {
    at: GeoPoint,
    /// `None` for home.
    item: Option<(usize, &'a MissionItem)>,
}

/// The way of a mission from its home, or from its first place when home is not known, begun at this speed (m/s), which
/// is the vehicle's own.
pub fn way(mission: &Mission, speed_m_s: f64, options: &ProgressOptions) -> Way {
    let home = mission.home.and_then(|home| home.point().ok());
    let home_alt_m = mission.home.map(|home| home.alt_amsl_m);
    let mut pace = Pace::new(Some(speed_m_s));
    let options = &ProgressOptions { own_speed_m_s: Some(speed_m_s), ..*options };
    // what is flown to, and the speed on the way
    let mut places: Vec<(Place<'_>, f64)> = Vec::new();
    for (index, item) in mission.items.iter().enumerate() {
        pace.order(item, options);
        let at = match item.command {
            Command::NAV_RETURN_TO_LAUNCH => home,
            command if command.is_takeoff() => item.point(),
            _ => place(item, options),
        };
        if let Some(at) = at {
            places.push((Place { at, item: Some((index, item)) }, pace.m_s().unwrap_or(speed_m_s)));
        }
    }
    let start = home.map(|at| Place { at, item: None });
    let before = |index: usize| match index.checked_sub(1) {
        Some(index) => Some(&places[index].0),
        None => start.as_ref(),
    };
    let stops = (0..places.len()).filter_map(|index| {
        let (to, speed_m_s) = &places[index];
        let (number, item) = to.item?;
        let from = before(index);
        let around = Around {
            before: index.checked_sub(1).and_then(before),
            after: places.get(index + 1).map(|(place, _)| place),
        };
        let leg = from
            .filter(|from| distance_m(from.at, to.at) > SAME_M)
            .map(|from| leg(from, to.at, item, &around, home_alt_m, options));
        let leg_m = leg.as_ref().map_or(0.0, |leg| leg.length_m);
        let from_item = from.and_then(|from| from.item).map(|(_, item)| item);
        let loiter = loiter(item, from_item, leg_m, *speed_m_s, home_alt_m, options);
        Some(Stop { item: number + 1, leg, loiter })
    });
    let jumps = mission.items.iter().enumerate().filter_map(|(index, item)| {
        let is_jump = matches!(item.command, Command::DO_JUMP | Command::DO_JUMP_TAG);
        let to = is_jump.then(|| jump_index(&mission.items, item))??;
        Some(Jump { item: index + 1, to_item: to + 1 })
    });
    Way { stops: stops.collect(), jumps: jumps.collect() }
}

/// The places beside a leg, which a spline bends to.
struct Around<'a> {
    before: Option<&'a Place<'a>>,
    after: Option<&'a Place<'a>>,
}

fn leg(
    from: &Place<'_>,
    to: GeoPoint,
    item: &MissionItem,
    around: &Around<'_>,
    home_alt_m: Option<f64>,
    options: &ProgressOptions,
) -> Leg {
    let came_from_takeoff = from.item.is_some_and(|(_, item)| item.command.is_takeoff());
    let kind = match item.command {
        Command::NAV_RETURN_TO_LAUNCH => LegKind::Return,
        command if command.is_landing() => LegKind::Approach,
        command if command.is_takeoff() || came_from_takeoff => LegKind::Takeoff,
        _ => LegKind::Flown,
    };
    let straight = inverse(from.at, to);
    let turn_deg = arc_deg(item);
    let line = match (item.command, turn_deg) {
        (Command::NAV_ARC_WAYPOINT, Some(turn_deg)) => arc(from.at, to, turn_deg),
        (Command::NAV_SPLINE_WAYPOINT, _) => {
            let is_spline =
                |place: &&Place<'_>| place.item.is_some_and(|(_, item)| item.command == Command::NAV_SPLINE_WAYPOINT);
            spline(around.before.map(|one| one.at), from.at, to, around.after.filter(is_spline).map(|one| one.at))
        }
        _ => {
            // parameter 4 above 0 leaves a circle from where it is flown, 0 goes for the line from its centre
            let leaves = from.item.filter(|(_, item)| item.param(4).unwrap_or(0.0) > 0.0);
            let leaving = leaves.and_then(|(_, item)| circle(item, options));
            let entering = if kind == LegKind::Return { None } else { circle(item, options) };
            tangent(from.at, leaving, to, entering)
        }
    };
    let length_m = match turn_deg {
        Some(turn_deg) => {
            let turn = turn_deg.abs().to_radians();
            straight.distance_m * turn / 2.0 / (turn / 2.0).sin()
        }
        None => straight.distance_m,
    };
    Leg {
        from_item: from.item.map(|(index, _)| index + 1),
        kind,
        length_m: rounded(length_m, 2),
        course_deg: rounded(straight.bearing_start_deg, 2),
        lat_deg: line.iter().map(|point| rounded(point.lat_deg(), 7)).collect(),
        lon_deg: line.iter().map(|point| rounded(point.lon_deg(), 7)).collect(),
        descent: if kind == LegKind::Approach { descent(from, item, length_m, home_alt_m) } else { None },
    }
}

fn descent(from: &Place<'_>, item: &MissionItem, length_m: f64, home_alt_m: Option<f64>) -> Option<Descent> {
    let high_m = from.item.map_or(Some(0.0), |(_, before)| rel_home_m(before, home_alt_m))?;
    let drop_m = rounded(high_m - rel_home_m(item, home_alt_m)?, 2);
    let is_doubtful = drop_m <= 0.0 || drop_m > (STEEP_SLOPE + SLOPE_ROUNDING) * length_m;
    Some(Descent { drop_m, is_doubtful })
}

/// How far an arc turns, degrees, clockwise positive; `None` for a straight leg: no arc, no turn, or a full one.
fn arc_deg(item: &MissionItem) -> Option<f64> {
    let turn_deg = item.param(1).filter(|_| item.command == Command::NAV_ARC_WAYPOINT)?;
    (0.5..360.0).contains(&turn_deg.abs()).then_some(turn_deg)
}

/// `NAV_ARC_WAYPOINT` in MAVLink's common.xml: an arc that turns by param1 degrees on the way; a chord leaves it with
/// half of the angle that it spans.
fn arc(from: GeoPoint, to: GeoPoint, turn_deg: f64) -> Vec<GeoPoint> {
    let chord = inverse(from, to);
    let radius_m = chord.distance_m / 2.0 / (turn_deg.abs().to_radians() / 2.0).sin();
    let begin_deg = chord.bearing_start_deg - turn_deg / 2.0;
    let pieces = (turn_deg.abs() / STEP_DEG).ceil().max(2.0) as u32;
    let inner = (1..pieces).map(|piece| {
        let turned_deg = turn_deg * f64::from(piece) / f64::from(pieces);
        let away_m = 2.0 * radius_m * (turned_deg.abs().to_radians() / 2.0).sin();
        direct(from, wrap_360_deg(begin_deg + turned_deg / 2.0), away_m)
    });
    std::iter::once(from).chain(inner).chain(std::iter::once(to)).collect()
}

/// The cubic Hermite curve whose ends are passed as ArduPilot passes them (`SplineCurve`): at a spline along the line
/// between its neighbours, at a straight one along the leg.
fn spline(before: Option<GeoPoint>, from: GeoPoint, to: GeoPoint, after: Option<GeoPoint>) -> Vec<GeoPoint> {
    let flat = |a: GeoPoint, b: GeoPoint| {
        let [north_m, east_m, _] = LocalFrame::new(a, 0.0).ned_m(b, 0.0);
        [north_m, east_m]
    };
    let length = |[north, east]: [f64; 2]| north.hypot(east);
    let leg = flat(from, to);
    let mut leave = before.map_or([0.0, 0.0], |before| flat(before, to));
    let mut arrive = after.map_or(leg, |after| flat(from, after));
    let (speed, most) = (length(leave) + length(arrive), SPLINE_SPEED * length(leg));
    if speed > most {
        for part in leave.iter_mut().chain(&mut arrive) {
            *part *= most / speed;
        }
    }
    let inner = (1..SPLINE_PIECES).map(|piece| {
        let s = f64::from(piece) / f64::from(SPLINE_PIECES);
        let (h10, h01, h11) = (s * (1.0 - s).powi(2), s * s * (3.0 - 2.0 * s), s * s * (s - 1.0));
        let at = |axis: usize| h10 * leave[axis] + h01 * leg[axis] + h11 * arrive[axis];
        direct(from, wrap_360_deg(at(1).atan2(at(0)).to_degrees()), at(0).hypot(at(1)))
    });
    std::iter::once(from).chain(inner).chain(std::iter::once(to)).collect()
}

/// From circle to circle, place to circle, or circle to place.
fn tangent(from: GeoPoint, leaving: Option<Circle>, to: GeoPoint, entering: Option<Circle>) -> Vec<GeoPoint> {
    let (mut begin, mut end) = (from, to);
    let rounds = if leaving.is_some() && entering.is_some() { TANGENT_ROUNDS } else { 1 };
    for _ in 0..rounds {
        begin = leaving.and_then(|circle| exit(circle, end)).unwrap_or(from);
        end = entering.and_then(|circle| entry(begin, circle)).unwrap_or(to);
    }
    points_along(begin, end, STRAIGHT_M)
}

/// Where a line from a place touches a circle in its sense; `None` from inside of it.
fn entry(from: GeoPoint, Circle { centre, radius_m, is_clockwise }: Circle) -> Option<GeoPoint> {
    let line = inverse(from, centre);
    if line.distance_m <= radius_m {
        return None;
    }
    // a clockwise circle has its centre on the right of the plane
    let aside_deg = (radius_m / line.distance_m).asin().to_degrees() * if is_clockwise { -1.0 } else { 1.0 };
    let length_m = (line.distance_m * line.distance_m - radius_m * radius_m).sqrt();
    Some(direct(from, wrap_360_deg(line.bearing_start_deg + aside_deg), length_m))
}

/// Where a plane leaves a circle straight to a place; `None` when that lies inside. Flown backwards it is an entry, the
/// other way round.
fn exit(circle: Circle, to: GeoPoint) -> Option<GeoPoint> {
    entry(to, Circle { is_clockwise: !circle.is_clockwise, ..circle })
}

/// Kind of the circle at an item, with its radius, whose sign is its sense: 0, or -0, for the vehicle's own, which one
/// of 1 m and less asks for too.
pub(crate) fn signed_radius_m(item: &MissionItem) -> Option<(Circling, f64)> {
    let (kind, signed_m) = match item.command {
        Command::NAV_LOITER_TURNS => (Circling::Turns, item.param(3).unwrap_or(0.0)),
        Command::NAV_LOITER_UNLIM => (Circling::Unlimited, item.param(3).unwrap_or(0.0)),
        Command::NAV_LOITER_TO_ALT => (Circling::Height, item.param(2).unwrap_or(0.0)),
        // ArduPlane keeps the sign alone, and flies it with its own radius
        Command::NAV_LOITER_TIME => (Circling::Time, 0.0_f64.copysign(item.param(3).unwrap_or(1.0))),
        _ => return None,
    };
    Some((kind, named_radius_m(signed_m)))
}

/// The circle at an item; `None` without one, or without a place of its own. The vehicle's own radius has a sense as
/// well (`Plane::update_loiter` of ArduPilot 4.7).
pub(crate) fn circle(item: &MissionItem, options: &ProgressOptions) -> Option<Circle> {
    let (_, signed_m) = signed_radius_m(item)?;
    let (is_own, own_m) = (signed_m == 0.0, own_radius_m(options.loiter_radius_m));
    let radius_m = if is_own { own_m.abs() } else { signed_m.abs() };
    let is_anticlockwise = signed_m.is_sign_negative() || is_own && own_m < 0.0;
    Some(Circle { centre: item.point()?, radius_m, is_clockwise: !is_anticlockwise })
}

/// How far and how long the plane circles at an item; `None` where it does not. Counted as by
/// [`crate::progress::trip`].
fn loiter(
    item: &MissionItem,
    before: Option<&MissionItem>,
    leg_m: f64,
    speed_m_s: f64,
    home_alt_m: Option<f64>,
    options: &ProgressOptions,
) -> Option<Loiter> {
    let (kind, signed_m) = signed_radius_m(item)?;
    let Circle { radius_m, is_clockwise, .. } = circle(item, options)?;
    let is_own_radius = signed_m != 0.0;
    let amount = item.param(1).unwrap_or(0.0).max(0.0);
    let mut changed_before = 1.0;
    let (length_m, time_s) = match kind {
        Circling::Turns => {
            let length_m = amount * std::f64::consts::TAU * radius_m;
            (Some(length_m), Some(length_m / speed_m_s))
        }
        Circling::Time => (Some(amount * speed_m_s), Some(amount)),
        Circling::Height => {
            // both above home, or both above the sea
            let height_m = |item: &MissionItem| alt_amsl_m(item, Some(home_alt_m.unwrap_or(0.0)));
            let is_known = |item: &MissionItem| home_alt_m.is_some() || item.frame == MavFrame::GlobalRelativeAlt;
            let heights = before.filter(|before| is_known(before) && is_known(item));
            match heights.and_then(height_m).zip(height_m(item)) {
                None => (None, None),
                Some((from_m, to_m)) => {
                    // it climbs on the leg already
                    let change_s = (to_m - from_m).abs() / options.climb_rate_m_s.max(0.1);
                    let leg_s = leg_m / speed_m_s;
                    if change_s > leg_s {
                        changed_before = leg_s / change_s;
                    }
                    let time_s = (change_s - leg_s).max(0.0);
                    (Some(time_s * speed_m_s), Some(time_s))
                }
            }
        }
        Circling::Unlimited => (None, None),
    };
    let is_estimate = match kind {
        Circling::Turns => !is_own_radius,
        Circling::Time | Circling::Height => true,
        Circling::Unlimited => false,
    };
    let short = |value: Option<f64>| value.map(|value| rounded(value, 2));
    Some(Loiter {
        kind,
        radius_m: rounded(radius_m, 2),
        is_clockwise,
        is_own_radius,
        length_m: short(length_m),
        time_s: short(time_s),
        is_estimate,
        changed_before,
    })
}

pub(crate) fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    let scaled = value * scale;
    if scaled.is_finite() { scaled.round() / scale } else { value }
}

#[cfg(test)]
#[path = "way_tests.rs"]
mod tests;
