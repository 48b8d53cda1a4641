//! The plan laid out for the rehearsal: places in metres around home, heights above it, jumps and returns.

use super::aircraft::Aircraft;
use super::body::Body;
use crate::geodesy::{GeoPoint, LocalFrame, direct, inverse};
use crate::guidance::NorthEast;
use crate::plan::{Category, Command, Home, MavFrame, MissionItem, Plan, ardupilot_stored};
use crate::progress::jump_index;

/// How far from home the tangent plane gives places, m.
const NEAR_M: f64 = 20_000.0;
/// Mean radius of the Earth, m (IUGG).
const EARTH_M: f64 = 6_371_009.0;

/// How far from home or a landing point the field is taken to be level, m, and by how much the known ground may differ
/// there: SRTM is mostly within 8 m (Rodríguez et al. 2006), and a plane rolls on what is there, not on what a map has.
const FIELD_M: f64 = 300.0;
const FIELD_OFF_M: f64 = 10.0;
/// How far below a place of the plan that lies below home the ground is assumed where it is not known, m.
const UNKNOWN_BELOW_M: f64 = 30.0;

/// A place and a height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub at: NorthEast,
    /// Above home, or above the ground below the plane where it follows that.
    pub height_m: f64,
    /// Whether the height counts from the ground below the plane.
    pub follows_ground: bool,
}

impl Spot {
    /// Where the plane is.
    pub fn of(body: &Body) -> Self {
        Self { at: body.position, height_m: body.height_m, follows_ground: false }
    }

    /// Distance from the plane, m, height included.
    fn away_m(self, body: &Body) -> f64 {
        (self.at - body.position).length().hypot(self.height_m - body.height_m)
    }
}

/// Height of the ground, m above mean sea level, where it is known.
pub type Ground<'a> = dyn Fn(GeoPoint) -> Option<f64> + Sync + 'a;

/// A plan around its home.
///
/// Places are laid out by bearing and distance from home (azimuthal equidistant): exact along every line through home,
/// and off by less than 1 m between two places 20 km from it.
pub(super) struct Course<'a> {
    pub home: Home,
    origin: GeoPoint,
    frame: LocalFrame,
    /// As the vehicle keeps them.
    pub items: Vec<MissionItem>,
    /// Where each item is; `None` without a place.
    pub places: Vec<Option<NorthEast>>,
    rally: Vec<Spot>,
    ground: Option<&'a Ground<'a>>,
    home_ground_m: Option<f64>,
    /// Level of the ground where it is not known, m above home: on the field of home, and elsewhere.
    level_m: (f64, f64),
}

impl<'a> Course<'a> {
    /// `None` when home is not a place on Earth.
    pub fn new(plan: &Plan, home: Home, ground: Option<&'a Ground<'a>>) -> Option<Self> {
        let origin = home.point().ok()?;
        let items: Vec<MissionItem> = plan.mission.items.iter().map(ardupilot_stored).collect();
        let places = items.iter().map(|item| item.point().map(|point| place(origin, point))).collect();
        let frame = LocalFrame::new(origin, 0.0);
        let home_ground_m = ground.and_then(|ground| ground(origin));
        let mut course =
            Self { home, origin, frame, items, places, rally: Vec::new(), ground, home_ground_m, level_m: (0.0, 0.0) };
        course.rally = plan
            .rally
            .points
            .iter()
            .map(|rally| course.spot_at(place(origin, rally.point), rally.alt_m, rally.frame))
            .collect();
        course.level_m.1 = course.below_plan_m();
        Some(course)
    }

    /// Sets the level of the ground where it is not known, m above home.
    pub const fn set_level(&mut self, level_m: f64) {
        self.level_m = (level_m, level_m);
    }

    /// Home's level, or below the lowest place of a plan that leads below home: the ground there is unknown, but
    /// certainly not at home's level.
    fn below_plan_m(&self) -> f64 {
        let flown = self.items.iter().zip(&self.places).filter(|(item, _)| is_flown(item));
        let grounds = flown.filter_map(|(item, at)| {
            let height_m = self.resolved_m(self.spot_at((*at)?, item.alt_m()?, item.frame));
            Some((height_m, if item.command == Command::NAV_LAND { 0.0 } else { UNKNOWN_BELOW_M }))
        });
        let rally = self.rally.iter().map(|rally| (self.resolved_m(*rally), UNKNOWN_BELOW_M));
        let below = grounds.chain(rally).filter(|(height_m, _)| *height_m < 0.0);
        below.map(|(height_m, below_m)| height_m - below_m).fold(0.0, f64::min)
    }

    /// How far home lies above the ground that is known there, m.
    pub fn home_above_ground_m(&self) -> Option<f64> {
        self.home_ground_m.map(|ground_m| self.home.alt_amsl_m - ground_m)
    }

    /// Home.
    pub fn origin(&self) -> GeoPoint {
        self.origin
    }

    /// Where a place on Earth lies.
    pub fn position(&self, point: GeoPoint) -> NorthEast {
        place(self.origin, point)
    }

    /// The place on Earth of a position: near home by way of its tangent plane, within a centimetre of the geodesic up
    /// to 5 km, within 0.3 m up to 20 km, and ten times as fast.
    pub fn point(&self, at: NorthEast) -> GeoPoint {
        let distance_m = at.length();
        if distance_m > NEAR_M {
            return direct(self.origin, at.bearing_rad().to_degrees(), distance_m);
        }
        // An arc s of a sphere reaches R sin(s/R) along the plane, and lies R (1 − cos(s/R)) below it.
        let arc = distance_m / EARTH_M;
        let along = 1.0 - arc * arc / 6.0;
        self.frame.geodetic_from_ned([at.north * along, at.east * along, 0.5 * distance_m * arc]).0
    }

    /// Height of the ground below a position above home, m, where it is known.
    ///
    /// It counts from the ground known at home, on which the plane stands: what a map is off in all its heights
    /// cancels, as in ArduPlane (`AP_Terrain::update_reference_offset`).
    pub fn ground_m(&self, at: NorthEast) -> Option<f64> {
        let amsl_m = self.ground.and_then(|ground| ground(self.point(at)))?;
        Some(amsl_m - self.home_ground_m.unwrap_or(self.home.alt_amsl_m))
    }

    /// The same; where it is not known, home's level on the field, and elsewhere a level below the whole plan.
    pub fn assumed_ground_m(&self, at: NorthEast) -> f64 {
        let (field_m, elsewhere_m) = self.level_m;
        self.ground_m(at).unwrap_or(if at.length() > FIELD_M { elsewhere_m } else { field_m })
    }

    /// A height above home, m, counted from the ground where that lies below home: in a valley the wind's profile
    /// begins at its ground.
    pub fn above_level_m(&self, at: NorthEast, height_m: f64) -> f64 {
        height_m - self.assumed_ground_m(at).min(0.0)
    }

    /// The ground as an autopilot knows it, which needs the ground at home too
    /// (`AP_Terrain::height_relative_home_equivalent`).
    pub fn followed_ground_m(&self, at: NorthEast) -> Option<f64> {
        self.home_ground_m.and_then(|_| self.ground_m(at))
    }

    /// Height of the ground that stops the plane, m above home: the known or assumed one; on the field itself, and
    /// where none is known on the way to a landing, the level of home or of that landing.
    pub fn stopping_ground_m(&self, item: Option<usize>, at: NorthEast) -> f64 {
        let item = item.and_then(|index| self.items.get(index)).filter(|item| item.command == Command::NAV_LAND);
        let field = item.and_then(MissionItem::point).map_or(NorthEast::default(), |point| place(self.origin, point));
        let land_m = item.map(|item| self.resolved_m(self.spot_at(field, item.alt_m().unwrap_or(0.0), item.frame)));
        let level_m = land_m.unwrap_or(0.0);
        match self.ground_m(at) {
            Some(ground_m) if (at - field).length() > FIELD_M || (ground_m - level_m).abs() > FIELD_OFF_M => ground_m,
            Some(_) => level_m,
            None => land_m.unwrap_or_else(|| self.assumed_ground_m(at)),
        }
    }

    fn spot_at(&self, at: NorthEast, alt_m: f64, frame: MavFrame) -> Spot {
        let height_m = if frame == MavFrame::Global { alt_m - self.home.alt_amsl_m } else { alt_m };
        Spot { at, height_m, follows_ground: frame == MavFrame::GlobalTerrainAlt }
    }

    /// Height of a spot above home, m; one above ground that is not known counts from home, as ArduPlane takes it.
    pub fn resolved_m(&self, spot: Spot) -> f64 {
        let ground_m = spot.follows_ground.then(|| self.followed_ground_m(spot.at)).flatten();
        spot.height_m + ground_m.unwrap_or(0.0)
    }

    /// A place at the height of an item; where it has none, at the plane's.
    pub fn at_height_of(&self, at: NorthEast, item: &MissionItem, body: &Body) -> Spot {
        // Some commands have a height and no place.
        let alt_m = item.alt_m().or(item.param(7));
        alt_m.map_or(Spot { at, ..Spot::of(body) }, |alt_m| self.spot_at(at, alt_m, item.frame))
    }

    /// Where an item leads: 0/0 means here, and with height 0 at this height.
    pub fn spot(&self, item: &MissionItem, body: &Body) -> Spot {
        match item.point() {
            Some(point) => self.at_height_of(place(self.origin, point), item, body),
            None if item.alt_m().unwrap_or(0.0) == 0.0 => Spot::of(body),
            None => self.at_height_of(body.position, item, body),
        }
    }

    /// The same with its height above home.
    fn spot_above_home(&self, item: &MissionItem, body: &Body) -> Spot {
        let spot = self.spot(item, body);
        Spot { height_m: self.resolved_m(spot), follows_ground: false, ..spot }
    }

    /// Height above home, m, and least pitch, rad, of a take-off.
    pub fn take_off(&self, item: &MissionItem, body: &Body) -> (f64, f64) {
        let pitch_deg = item.param(1).filter(|pitch_deg| *pitch_deg > 0.0).unwrap_or(4.0);
        (self.spot(item, body).height_m, pitch_deg.to_radians())
    }

    /// Where the item after a waypoint lies, as the turn to it is planned; `None` where no turn is.
    ///
    /// An item without a place counts as latitude and longitude 0.
    pub fn onward(&self, item: &MissionItem) -> Option<NorthEast> {
        if matches!(item.command, Command::NAV_DELAY | Command::NAV_GUIDED_ENABLE | Command::NAV_SET_YAW_SPEED) {
            return None;
        }
        match item.point() {
            Some(point) => Some(place(self.origin, point)),
            None => GeoPoint::new(0.0, 0.0).ok().map(|point| place(self.origin, point)),
        }
    }

    /// The place that an item is flown over; a take-off's is not flown to, a circle's is its centre.
    pub fn passed_place(&self, index: usize) -> Option<NorthEast> {
        let item = self.items.get(index)?;
        let is_passed = matches!(item.command, Command::NAV_WAYPOINT | Command::NAV_LAND);
        self.places[index].filter(|_| is_passed)
    }

    /// The first place away from home.
    pub fn first_place(&self) -> Option<Spot> {
        self.items.iter().zip(&self.places).find_map(|(item, at)| {
            let at = at.filter(|at| at.length() > 1.0)?;
            let spot = self.spot_at(at, item.alt_m()?, item.frame);
            Some(Spot { height_m: self.resolved_m(spot), follows_ground: false, ..spot })
        })
    }

    /// Whether the first flown item is a take-off.
    pub fn begins_with_take_off(&self) -> bool {
        self.items.iter().find(|item| is_flown(item)).is_none_or(|item| item.command == Command::NAV_TAKEOFF)
    }

    /// Index where a jump leads.
    pub fn jump(&self, item: &MissionItem) -> Option<usize> {
        jump_index(&self.items, item)
    }

    /// Where a return leads: the nearest rally point within reach, or home.
    pub fn nearest_return(&self, body: &Body, height_m: f64, plane: &Aircraft) -> Spot {
        let home = Spot { at: NorthEast::default(), height_m, follows_ground: false };
        let distance = |spot: &Spot| (spot.at - body.position).length();
        let Some(rally) = self.rally.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))) else { return home };
        let is_far = plane.rally_limit_m > 0.0 && distance(rally) > plane.rally_limit_m;
        if is_far || (plane.rally_includes_home && distance(&home) < distance(rally)) { home } else { *rally }
    }

    /// Index of the nearest start of a landing sequence: where its DO_LAND_START is, or what is flown after it.
    pub fn nearest_landing(&self, body: &Body) -> Option<usize> {
        let starts = (0..self.items.len()).filter(|index| self.items[*index].command == Command::DO_LAND_START);
        let distances = starts.filter_map(|index| {
            let placed = |item: &MissionItem| item.point().is_some();
            let items = self.items[index..].iter();
            let mut of_sequence =
                items.take(1).chain(self.items[index + 1..].iter().filter(|item| is_flown(item)).take(1));
            let spot = of_sequence.find(|item| placed(item)).map(|item| self.spot_above_home(item, body))?;
            Some((index, spot.away_m(body)))
        });
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    /// Index of the nearest start of a planned abort pattern (`AP_Mission::jump_to_abort_landing_sequence`).
    pub fn nearest_abort(&self, body: &Body) -> Option<usize> {
        let starts = self.items.iter().enumerate().filter(|(_, item)| item.command == Command::DO_GO_AROUND);
        let away_m = |index: usize| self.places[index].map_or(f64::MAX, |at| (at - body.position).length());
        starts.map(|(index, _)| (index, away_m(index))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    /// Index of the item whose leg from the one before lies nearest, between a DO_RETURN_PATH_START and the landing
    /// after it (`AP_Mission::jump_to_closest_mission_leg`; jumps on the way are not followed).
    pub fn nearest_on_return_path(&self, body: &Body) -> Option<usize> {
        let mut nearest: Option<(usize, f64)> = None;
        let mut is_on_path = false;
        let mut from: Option<Spot> = None;
        for (index, item) in self.items.iter().enumerate() {
            if item.command == Command::DO_RETURN_PATH_START {
                (is_on_path, from) = (true, None);
            }
            if is_on_path && item.point().is_some() {
                let to = self.spot_above_home(item, body);
                let away_m = from.map_or_else(|| to.away_m(body), |from| leg_away_m(from, to, body));
                if nearest.is_none_or(|(_, nearest_m)| away_m < nearest_m) {
                    nearest = Some((index, away_m));
                }
                from = Some(to);
            }
            is_on_path &= !matches!(item.command, Command::DO_LAND_START | Command::NAV_LAND);
        }
        nearest.map(|(index, _)| index)
    }
}

/// Distance of the plane from a leg, m, height included.
fn leg_away_m(from: Spot, to: Spot, body: &Body) -> f64 {
    let (leg, up) = (to.at - from.at, to.height_m - from.height_m);
    let (away, above) = (body.position - from.at, body.height_m - from.height_m);
    let square = leg.dot(leg) + up * up;
    let part = if square > 0.0 { ((away.dot(leg) + above * up) / square).clamp(0.0, 1.0) } else { 0.0 };
    Spot { at: from.at + leg * part, height_m: from.height_m + up * part, ..from }.away_m(body)
}

/// Whether an item is flown, not an action.
pub(super) fn is_flown(item: &MissionItem) -> bool {
    item.command.info().is_some_and(|info| info.category == Category::Nav)
}

fn place(origin: GeoPoint, point: GeoPoint) -> NorthEast {
    let line = inverse(origin, point);
    NorthEast::from_bearing(line.bearing_start_deg.to_radians()) * line.distance_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::distance_m;
    use crate::plan::Mission;

    #[test]
    fn places_near_home_are_those_of_the_geodesic() {
        for lat_deg in [-60.0, 0.0, 40.3332, 75.0] {
            let home = Home { lat_deg, lon_deg: 179.95, alt_amsl_m: 0.0 };
            let course = Course::new(&Plan::from_mission(Mission::default()), home, None).unwrap();
            for (distance, within_m) in
                [(10.0, 0.001), (1_000.0, 0.001), (5_000.0, 0.01), (19_000.0, 0.3), (90_000.0, 0.01)]
            {
                for bearing in 0..12 {
                    let at = NorthEast::from_bearing(f64::from(bearing) * 0.55) * distance;
                    let exact = direct(course.origin(), at.bearing_rad().to_degrees(), distance);
                    let off_m = distance_m(course.point(at), exact);
                    assert!(off_m < within_m, "{lat_deg} {distance} {bearing}: {off_m}");
                    assert!((course.position(exact) - at).length() < 0.001);
                }
            }
        }
    }
}
