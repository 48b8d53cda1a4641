//! Ways in to a place: the landings of a runway or a point, ranked for a wind, and a landing of which one part is
//! moved.
//!
//! The landing itself is [`design_landing`]'s. Here stands which ones there are to choose from, how each of them would
//! be flown by this plane ([`rehearse`]), and why one is better than another.

mod moved;
mod reason;

pub(crate) use moved::designed_items;
pub use moved::{LandingPart, move_landing};
pub use reason::{LandingReason, Verdict};

use crate::checks::CLEARANCE_M;
use crate::error::{FlightError, LandingProblem, Result};
use crate::geodesy::{GeoPoint, direct, distance_m, inverse, wrap_180_deg, wrap_360_deg};
use crate::guidance::GRAVITY_M_S2;
use crate::landing::{CALM_M_S, Landing, LandingCaution, LandingOptions, Wind, design_landing, design_landing_over};
use crate::plan::{Home, Mission, MissionItem, Plan};
use crate::progress::Circled;
use crate::rehearsal::{Aircraft, Autoland, Conditions, Doing, Ending, Origin, Start, rehearse};

/// Shortest and longest runway, m: less is the error of two positions, and more is a mistake.
const RUNWAY_M: (f64, f64) = (20.0, 10_000.0);
/// How far beyond the threshold the landing point lies at most, m: the aiming point of runways shorter than 800 m (ICAO
/// Annex 14, volume I, table 5-1).
const AIM_M: f64 = 150.0;
/// Angle between two courses to choose from where no runway gives one, degrees.
const FAN_DEG: f64 = 30.0;
/// How far above the beginning of the final leg a rehearsed approach begins, m.
const ABOVE_FINAL_M: f64 = 30.0;
/// How far outside its circle a rehearsed approach begins at most, m: enough to join the circle from that side. The way
/// there belongs to the plan, not to the landing, and is flown at heights that the landing does not know.
const FLOWN_FROM_M: f64 = 1_000.0;
/// Places at which the ground is looked up on the way to the circle.
const GROUND_PLACES: u32 = 20;
/// How long it may take from there, s: what takes longer does not come down.
const LONGEST_S: f64 = 3_600.0;
/// Crosswind that is worth a word, m/s.
const CROSSWIND_M_S: f64 = 2.0;
/// How far `NAV_LAND` is moved at most so that the plane rests on the point, m: a larger error does not come from the
/// flare.
const FARTHEST_MOVED_M: f64 = 60.0;
/// Winds and distances that differ by less do not make one landing better than another, m/s and m.
const SAME_WIND_M_S: f64 = 0.5;
const SAME_OFF_M: f64 = 10.0;
/// Bank that a plane keeps in reserve on its circle, degrees, and the least that it flies a circle with.
const BANK_RESERVE_DEG: f64 = 10.0;
const BANK_LEAST_DEG: f64 = 15.0;
/// The same as [`LandingOptions`] says of its fields.
const RADIUS_M: (f64, f64) = (20.0, 500.0);
const AIRSPEED_M_S: (f64, f64) = (5.0, 60.0);
const SLOPE: (f64, f64) = (0.02, 0.25);

/// A line to land on, in either direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Runway {
    /// One end.
    pub begin: GeoPoint,
    /// The other.
    pub end: GeoPoint,
}

impl Runway {
    /// A runway of 20 m to 10 km.
    ///
    /// # Errors
    /// [`FlightError::BadLanding`] for another length.
    pub fn new(begin: GeoPoint, end: GeoPoint) -> Result<Self> {
        let (low, high) = RUNWAY_M;
        let value = distance_m(begin, end);
        if (low..=high).contains(&value) {
            return Ok(Self { begin, end });
        }
        Err(FlightError::BadLanding(LandingProblem::OutOfRange { option: "runway length_m", value, low, high }))
    }

    /// Its length, m.
    pub fn length_m(&self) -> f64 {
        distance_m(self.begin, self.end)
    }

    /// Course from `begin` to `end`, degrees from true north, 0 to 360.
    pub fn course_deg(&self) -> f64 {
        wrap_360_deg(inverse(self.begin, self.end).bearing_start_deg)
    }

    /// The same, landed on the other way round.
    pub const fn reversed(&self) -> Self {
        Self { begin: self.end, end: self.begin }
    }

    /// How far beyond its threshold the landing point lies, m: in the middle, and on a long one at 150 m.
    pub fn aim_m(&self) -> f64 {
        (self.length_m() / 2.0).min(AIM_M)
    }

    /// The landing point from `begin` to `end`.
    pub fn aim(&self) -> GeoPoint {
        direct(self.begin, self.course_deg(), self.aim_m())
    }
}

/// Where to land.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Site {
    /// At a point.
    Point(GeoPoint),
    /// On a runway, in the direction that suits.
    Runway(Runway),
}

/// How far around a place the ground of its approaches is looked up, m: a wide circle before a long final leg.
const AROUND_M: f64 = 2_500.0;

impl Site {
    /// A plan of places around it, whose ground is that of its approaches: for [`crate::ground::squares_around`].
    pub fn surroundings(&self) -> Plan {
        let at = match self {
            Self::Point(point) => *point,
            Self::Runway(runway) => runway.aim(),
        };
        let sides = [0.0, 90.0, 180.0, 270.0].map(|bearing_deg| direct(at, bearing_deg, AROUND_M));
        let items = sides.map(|side| MissionItem::waypoint(side.lat_deg(), side.lon_deg(), 0.0)).to_vec();
        Plan::from_mission(Mission { items, ..Mission::default() })
    }

    /// The courses to land on: a runway's or the one asked for and its opposite, else a fan that begins into the wind,
    /// or where the plane comes from, or at north. With the point and how much of a runway lies before and behind it.
    fn directions(&self, options: &LandingOptions) -> Vec<Direction> {
        match self {
            Self::Runway(runway) => [*runway, runway.reversed()].map(|runway| Direction::on(&runway)).to_vec(),
            Self::Point(point) => {
                let (first_deg, step_deg) = options.course_deg.map_or_else(
                    || {
                        let wind = options.wind.filter(|wind| wind.speed_m_s >= CALM_M_S).map(|wind| wind.from_deg);
                        let from = || options.coming_from.map(|from| inverse(from, *point).bearing_end_deg);
                        (wind.or_else(from).unwrap_or(0.0), FAN_DEG)
                    },
                    |course_deg| (course_deg, 180.0),
                );
                let courses = (360.0 / step_deg).round() as u32;
                (0..courses)
                    .map(|number| Direction {
                        point: *point,
                        course_deg: wrap_360_deg(first_deg + f64::from(number) * step_deg),
                        runway: None,
                    })
                    .collect()
            }
        }
    }
}

/// One direction to land in.
#[derive(Debug, Clone, Copy)]
struct Direction {
    point: GeoPoint,
    course_deg: f64,
    /// Metres of the runway before and beyond the point.
    runway: Option<(f64, f64)>,
}

impl Direction {
    fn on(runway: &Runway) -> Self {
        let before_m = runway.aim_m();
        let course_deg = runway.course_deg();
        Self { point: runway.aim(), course_deg, runway: Some((before_m, runway.length_m() - before_m)) }
    }

    fn landing(&self, options: &LandingOptions, below: Option<&Below<'_>>) -> Result<Landing> {
        designed(self.point, &LandingOptions { course_deg: Some(self.course_deg), ..*options }, below)
    }
}

/// Height of the ground above home, m, where it is known.
pub type Below<'a> = dyn Fn(GeoPoint) -> Option<f64> + 'a;

fn designed(point: GeoPoint, options: &LandingOptions, below: Option<&Below<'_>>) -> Result<Landing> {
    below.map_or_else(|| design_landing(point, options), |below| design_landing_over(point, options, below))
}

/// The end of a rehearsed approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flown {
    /// How it ends.
    pub ending: Ending,
    /// Where the ground is touched, m beyond the point along the final leg, negative before it; `None`: nowhere.
    pub touch_down_m: Option<f64>,
    /// Where the plane comes to rest, likewise; `None`: it does not land.
    pub rest_m: Option<f64>,
    /// Time from its beginning, s: from the place that the plane comes from, or home.
    pub duration_s: f64,
}

/// A landing to choose.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// The landing.
    pub landing: Landing,
    /// Whether its circle is flown clockwise, to the right of the final leg.
    pub is_clockwise: bool,
    /// The wind across the final leg, m/s, positive from the right; `None`: no wind is known.
    pub crosswind_m_s: Option<f64>,
    /// The rehearsed approach.
    pub flown: Flown,
    /// Reasons for and against it.
    pub reasons: Vec<LandingReason>,
    /// What follows from that.
    pub verdict: Verdict,
}

/// Options for a landing of this plane in a wind.
///
/// - The airspeed is that of its approach (`TECS_LAND_ARSPD`, else between cruise and slowest).
/// - The circle is its own (`WP_LOITER_RAD` with its direction), or as wide as cruise with the wind behind needs at 10°
///   less than its bank limit, 35° at most.
/// - The slope is gentle enough for the plane to need power on it: it sinks no faster than at idle (`TECS_SINK_MIN`).
/// - `DO_LAND_START` goes before it where a return looks for it (`RTL_AUTOLAND`).
pub fn options_of(plane: &Aircraft, wind: Option<Wind>) -> LandingOptions {
    let usual = LandingOptions::default();
    let (slowest, fastest) = AIRSPEED_M_S;
    let airspeed_m_s = plane.approach_airspeed().clamp(slowest, fastest);
    let bank_deg = (plane.bank_max_deg - BANK_RESERVE_DEG).clamp(BANK_LEAST_DEG, 35.0);
    let behind_m_s = plane.airspeed_cruise_m_s + wind.map_or(0.0, |wind| wind.speed_m_s);
    let turn_m = behind_m_s * behind_m_s / (GRAVITY_M_S2 * bank_deg.to_radians().tan());
    let radius_m = plane.loiter_radius_m.abs().max((turn_m / 5.0).ceil() * 5.0).clamp(RADIUS_M.0, RADIUS_M.1);
    LandingOptions {
        wind,
        airspeed_m_s,
        slope: (plane.tecs.sink_min_m_s / airspeed_m_s).clamp(SLOPE.0, usual.slope),
        radius_m,
        is_clockwise: plane.loiter_radius_m >= 0.0,
        has_land_start: plane.autoland != Autoland::Never,
        ..usual
    }
}

/// Designs a landing at a place: on a runway in the direction that has the wind ahead, in calm air from its `begin` to
/// its `end`, or in the one that is nearest to the course asked for; over the ground where that is given, as
/// [`design_landing_over`].
///
/// # Errors
/// As [`design_landing`].
pub fn design(site: Site, options: &LandingOptions, below: Option<&Below<'_>>) -> Result<Landing> {
    let runway = match site {
        Site::Point(point) => return designed(point, options, below),
        Site::Runway(runway) => runway,
    };
    let wind = options.wind.filter(|wind| wind.speed_m_s >= CALM_M_S).map(|wind| wind.from_deg);
    let wanted_deg = options.course_deg.or(wind).unwrap_or_else(|| runway.course_deg());
    let is_ahead = wrap_180_deg(wanted_deg - runway.course_deg()).abs() <= 90.0;
    Direction::on(&if is_ahead { runway } else { runway.reversed() }).landing(options, below)
}

/// The landings at a place, the best first: each direction with its circle on either side, flown by the plane of
/// `conditions` in their air from where `options` says that it comes from, else from home, 30 m above the beginning of
/// the final leg.
///
/// Where the conditions have ground and a home above it, the landings are laid out and flown over it, and one that it
/// comes near ranks lower.
///
/// Those with the best verdict of the rehearsal come first; then the one with less tailwind, with less crosswind, that
/// comes to rest nearer to the point, and that is down first. Differences below 0.5 m/s and 10 m do not count.
/// Directions in which the wind does not let the plane come in are left out.
///
/// # Errors
/// As [`design_landing`], when no direction can be flown.
pub fn landing_alternatives(
    site: Site,
    options: &LandingOptions,
    conditions: &Conditions<'_>,
) -> Result<Vec<Alternative>> {
    let mut found = Vec::new();
    let mut problem = None;
    let home = conditions.home.and_then(|home| home.point().ok());
    let over = conditions.ground.and_then(|ground| Some((ground, ground(home?)?)));
    let below = |at: GeoPoint| over.and_then(|(ground, home_m)| Some(ground(at)? - home_m));
    let below = over.is_some().then_some(&below as &Below<'_>);
    for direction in site.directions(options) {
        for is_clockwise in [options.is_clockwise, !options.is_clockwise] {
            let options = LandingOptions { is_clockwise, ..*options };
            match direction.landing(&options, below) {
                Ok(landing) => found.push(judged(&direction, landing, &options, below, conditions)),
                Err(error) => problem = Some(error),
            }
        }
    }
    match problem {
        Some(error) if found.is_empty() => return Err(error),
        _ => {}
    }
    let steps = |value: f64, step: f64| (value / step).round() as i64;
    found.sort_by_cached_key(|one| {
        let tailwind_m_s = one.landing.headwind_m_s.map_or(0.0, |headwind_m_s| (-headwind_m_s).max(0.0));
        (
            one.verdict,
            steps(tailwind_m_s, SAME_WIND_M_S),
            steps(one.crosswind_m_s.unwrap_or(0.0).abs(), SAME_WIND_M_S),
            steps(one.flown.rest_m.map_or(0.0, f64::abs), SAME_OFF_M),
            steps(one.flown.duration_s, 1.0),
        )
    });
    Ok(found)
}

/// The landing adjusted to this plane: where its airframe is known and not guessed, `NAV_LAND` lies as far beyond the
/// point as the rehearsed plane comes to rest before it (or the other way round), so that it rests on the point. With a
/// guessed airframe the correction would be a guess too.
fn settled(
    direction: &Direction,
    landing: Landing,
    options: &LandingOptions,
    below: Option<&Below<'_>>,
    conditions: &Conditions<'_>,
) -> (Landing, Flown) {
    let asked = flown(direction, &landing, options, conditions);
    let is_known = conditions.plane.airframe.origin != Origin::Parameters;
    let Some(rest_m) = asked.rest_m.filter(|rest_m| is_known && rest_m.abs() <= FARTHEST_MOVED_M) else {
        return (landing, asked);
    };
    let moved = Direction { point: direct(direction.point, landing.course_deg, -rest_m), ..*direction };
    match moved.landing(options, below) {
        Ok(landing) => {
            let flown = flown(direction, &landing, options, conditions);
            (landing, flown)
        }
        Err(_) => (landing, asked),
    }
}

fn judged(
    direction: &Direction,
    landing: Landing,
    options: &LandingOptions,
    below: Option<&Below<'_>>,
    conditions: &Conditions<'_>,
) -> Alternative {
    let is_clockwise = options.is_clockwise;
    let crosswind_m_s =
        options.wind.map(|wind| wind.speed_m_s * wrap_180_deg(wind.from_deg - landing.course_deg).to_radians().sin());
    let (landing, flown) = settled(direction, landing, options, below, conditions);
    let mut reasons = Vec::new();
    match landing.headwind_m_s {
        Some(speed_m_s) if speed_m_s >= CALM_M_S => reasons.push(LandingReason::Headwind { speed_m_s }),
        Some(speed_m_s) if speed_m_s <= -CALM_M_S => reasons.push(LandingReason::Tailwind { speed_m_s: -speed_m_s }),
        Some(_) if options.wind.is_some_and(|wind| wind.speed_m_s < CALM_M_S) => reasons.push(LandingReason::Calm {}),
        _ => {}
    }
    if let Some(speed_m_s) = crosswind_m_s.filter(|speed_m_s| speed_m_s.abs() >= CROSSWIND_M_S) {
        reasons.push(LandingReason::Crosswind { speed_m_s: speed_m_s.abs(), is_from_right: speed_m_s > 0.0 });
    }
    for caution in &landing.cautions {
        match *caution {
            LandingCaution::Steep { slope } => reasons.push(LandingReason::Steep { slope }),
            LandingCaution::GroundNear { clearance_m, wanted_m, distance_m } => {
                reasons.push(LandingReason::GroundNear { clearance_m, wanted_m, distance_m });
            }
            LandingCaution::GroundNotKnown | LandingCaution::Tailwind { .. } => {}
        }
    }
    reasons.push(flown.rest_m.map_or(LandingReason::DoesNotLand { ending: flown.ending }, |rest_m| {
        LandingReason::ComesToRest { distance_m: rest_m.abs(), is_beyond: rest_m > 0.0 }
    }));
    if let Some((before_m, beyond_m)) = direction.runway {
        let touch_down_m = flown.touch_down_m.unwrap_or(0.0);
        if touch_down_m < -before_m {
            reasons.push(LandingReason::BeforeRunway { distance_m: -before_m - touch_down_m });
        }
        if let Some(rest_m) = flown.rest_m.filter(|rest_m| *rest_m > beyond_m) {
            reasons.push(LandingReason::BeyondRunway { distance_m: rest_m - beyond_m });
        }
    }
    let verdict = reasons.iter().map(LandingReason::verdict).max().unwrap_or(Verdict::Good);
    Alternative { landing, is_clockwise, crosswind_m_s, flown, reasons, verdict }
}

/// The approach as the plane of the conditions would fly it.
fn flown(direction: &Direction, landing: &Landing, options: &LandingOptions, conditions: &Conditions<'_>) -> Flown {
    let here = Home { lat_deg: direction.point.lat_deg(), lon_deg: direction.point.lon_deg(), alt_amsl_m: 0.0 };
    let home = conditions.home.filter(|home| home.point().is_ok()).unwrap_or(here);
    let from = options.coming_from.or_else(|| home.point().ok()).unwrap_or(direction.point);
    let index = usize::from(options.has_land_start);
    let circle = landing.items.get(index).and_then(MissionItem::point).unwrap_or(direction.point);
    let away = inverse(circle, from);
    let far_m = away.distance_m.min(FLOWN_FROM_M + options.radius_m);
    let from = direct(circle, away.bearing_start_deg, far_m);
    let ground_m = |place: GeoPoint| conditions.ground.and_then(|ground| ground(place));
    let home_ground_m = home.point().ok().and_then(ground_m).unwrap_or(home.alt_amsl_m);
    let way_there = (0..=GROUND_PLACES).map(|n| far_m * f64::from(n) / f64::from(GROUND_PLACES));
    let grounds = way_there.filter_map(|from_m| ground_m(direct(circle, away.bearing_start_deg, from_m)));
    let free_m = grounds.map(|amsl_m| amsl_m - home_ground_m + CLEARANCE_M).fold(f64::NEG_INFINITY, f64::max);
    let start = Start::Air {
        point: from,
        height_m: free_m.max(landing.leaves_alt_rel_home_m + ABOVE_FINAL_M),
        heading_deg: inverse(from, circle).bearing_start_deg,
        airspeed_m_s: conditions.plane.airspeed_cruise_m_s,
        index,
        doing: Doing::Mission,
        circled: Circled::Nothing,
    };
    let plan = Plan { mission: Mission { home: Some(home), items: landing.items.clone() }, ..Plan::default() };
    let rehearsed = rehearse(&plan, &Conditions { home: Some(home), start, longest_s: LONGEST_S, ..*conditions });
    let beyond_m = |place: GeoPoint| {
        let line = inverse(direction.point, place);
        line.distance_m * wrap_180_deg(line.bearing_start_deg - landing.course_deg).to_radians().cos()
    };
    rehearsed.ok().map_or(
        Flown { ending: Ending::NotRehearsed, touch_down_m: None, rest_m: None, duration_s: 0.0 },
        |rehearsed| Flown {
            ending: rehearsed.ending,
            touch_down_m: rehearsed.touch_down.map(|sample| beyond_m(sample.point)),
            rest_m: rehearsed
                .track
                .last()
                .filter(|_| rehearsed.ending == Ending::Landed)
                .map(|sample| beyond_m(sample.point)),
            duration_s: rehearsed.duration_s,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landing::settling_time_s;
    use crate::rehearsal::Air;
    use proptest::prelude::*;

    const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

    fn here() -> GeoPoint {
        HOME.point().unwrap()
    }

    fn alternatives(site: Site, wind: Wind) -> Vec<Alternative> {
        let plane = Aircraft::default();
        let conditions = Conditions { home: Some(HOME), ..Conditions::new(&plane, Air::from(wind)) };
        landing_alternatives(site, &options_of(&plane, Some(wind)), &conditions).unwrap()
    }

    fn runway(course_deg: f64, length_m: f64) -> Runway {
        Runway::new(here(), direct(here(), course_deg, length_m)).unwrap()
    }

    /// A real ArduPlane in its simulator comes to rest some 14 m before `NAV_LAND`: the item is moved as far beyond.
    #[test]
    fn a_plane_that_is_known_rests_on_the_point() {
        let known = |name: &str| {
            [("SIM_RATE_HZ", 1_200.0), ("LAND_FLARE_SEC", 3.0)]
                .iter()
                .find(|(one, _)| *one == name)
                .map(|(_, value)| *value)
        };
        let plane = Aircraft::from_ardupilot(known);
        let wind = Wind { from_deg: 250.0, speed_m_s: 6.0 };
        let conditions = Conditions { home: Some(HOME), ..Conditions::new(&plane, Air::from(wind)) };
        let found = landing_alternatives(Site::Point(here()), &options_of(&plane, Some(wind)), &conditions).unwrap();
        let best = &found[0];
        assert!(best.flown.rest_m.unwrap().abs() < 2.0, "{:?}", best.flown);
        let told = best.landing.items.last().unwrap().point().unwrap();
        assert!((3.0..FARTHEST_MOVED_M).contains(&distance_m(told, here())), "{told}");
    }

    #[test]
    fn a_runway_is_landed_on_into_the_wind_from_either_side() {
        let site = Site::Runway(runway(90.0, 300.0));
        let found = alternatives(site, Wind { from_deg: 250.0, speed_m_s: 6.0 });
        let courses: Vec<_> = found.iter().map(|one| one.landing.course_deg.round()).collect();
        assert_eq!(courses, [270.0, 270.0, 90.0, 90.0]);
        assert_ne!(found[0].is_clockwise, found[1].is_clockwise);
        assert_eq!((found[0].verdict, found[2].verdict), (Verdict::Good, Verdict::Doubtful));
        let said: Vec<_> = found[0].reasons.iter().map(ToString::to_string).collect();
        assert_eq!(said[..2], ["6 m/s of headwind", "2 m/s of crosswind from the left"]);
        assert!(said[2].starts_with("comes to rest "), "{said:?}");
        assert!(matches!(found[2].reasons[0], LandingReason::Tailwind { .. }));
        // The point is in the middle, the other way round as well.
        for one in &found {
            let point = one.landing.items.last().unwrap().point().unwrap();
            assert!((distance_m(point, here()) - 150.0).abs() < 0.01, "{point}");
        }
        assert!(found[..2].iter().all(|one| one.flown.rest_m.unwrap().abs() < 30.0), "{found:?}");
        assert_eq!(
            design(site, &options_of(&Aircraft::default(), Some(Wind { from_deg: 250.0, speed_m_s: 6.0 })), None)
                .unwrap()
                .course_deg
                .round(),
            270.0
        );
        assert_eq!(
            design(site, &LandingOptions::default(), None).unwrap().course_deg.round(),
            90.0,
            "calm: from its beginning"
        );
    }

    #[test]
    fn an_approach_that_takes_longer_than_an_hour_does_not_come_down() {
        // Half a turn takes this plane hours.
        let plane = Aircraft { bank_max_deg: 0.1, ..Aircraft::default() };
        let conditions = Conditions { home: Some(HOME), ..Conditions::new(&plane, Air::default()) };
        let site = Site::Runway(runway(90.0, 300.0));
        for one in landing_alternatives(site, &options_of(&plane, None), &conditions).unwrap() {
            assert!(one.flown.duration_s <= LONGEST_S + 1.0 && one.flown.rest_m.is_none(), "{:?}", one.flown);
        }
    }

    #[test]
    fn higher_ground_where_the_plane_comes_from_is_no_fault_of_a_landing() {
        // Level for 1.7 km around the field, 150 m higher beyond; at 900 m a hill of 60 m.
        let far = |at: GeoPoint| {
            let away_m = distance_m(here(), at);
            let north_m = inverse(here(), at).bearing_start_deg.to_radians().cos() * away_m;
            Some(
                600.0
                    + if away_m > 1_700.0 {
                        150.0
                    } else if north_m > 1_100.0 {
                        60.0
                    } else {
                        0.0
                    },
            )
        };
        let plane = Aircraft::default();
        let conditions = Conditions { home: Some(HOME), ground: Some(&far), ..Conditions::new(&plane, Air::default()) };
        let options = LandingOptions { coming_from: Some(direct(here(), 0.0, 2_500.0)), ..options_of(&plane, None) };
        let found = landing_alternatives(Site::Point(here()), &options, &conditions).unwrap();
        let lands = found.iter().filter(|one| one.flown.rest_m.is_some()).count();
        assert_eq!((found.len(), lands), (24, 24));
    }

    #[test]
    fn a_landing_is_not_flown_from_the_other_side_of_the_earth() {
        let plane = Aircraft::default();
        let far = Home { lat_deg: -40.0, lon_deg: 177.0, alt_amsl_m: 0.0 };
        let conditions = Conditions { home: Some(far), ..Conditions::new(&plane, Air::default()) };
        let found = landing_alternatives(Site::Point(here()), &options_of(&plane, None), &conditions).unwrap();
        let durations: Vec<f64> = found.iter().map(|one| one.flown.duration_s).collect();
        // Flown there, each would go on until the six hours of a rehearsal are over.
        assert!(durations.iter().all(|duration_s| *duration_s < 10_800.0), "{durations:?}");
    }

    #[test]
    fn a_long_runway_is_touched_near_its_threshold_and_a_short_one_is_told() {
        let long = runway(0.0, 2_000.0);
        assert_eq!((long.aim_m().round(), long.reversed().aim_m().round()), (150.0, 150.0));
        assert!((distance_m(long.reversed().aim(), long.begin) - 1_850.0).abs() < 0.1);
        let short = alternatives(Site::Runway(runway(0.0, 25.0)), Wind::default());
        assert!(short.iter().all(|one| one.verdict == Verdict::Bad), "{short:?}");
        assert!(short[0].reasons.iter().any(|reason| matches!(reason, LandingReason::BeforeRunway { .. })));
        assert!(Runway::new(here(), here()).unwrap_err().to_string().contains("runway length_m is 0"));
    }

    #[test]
    fn without_a_runway_a_fan_of_courses_begins_into_the_wind() {
        let found = alternatives(Site::Point(here()), Wind { from_deg: 200.0, speed_m_s: 7.0 });
        assert_eq!(found.len(), 24);
        assert!((found[0].landing.course_deg - 200.0).abs() < 1e-6);
        assert!(found.windows(2).all(|pair| pair[0].verdict <= pair[1].verdict));
        let last = found.last().unwrap();
        assert!(last.landing.headwind_m_s.unwrap() < -5.0, "{last:?}");
    }

    #[test]
    fn a_landing_with_a_hill_before_it_ranks_below_the_ones_round_it() {
        // 35 m high, 300 m south of the point: where the wind has one come from.
        let hill = |at: GeoPoint| {
            let line = inverse(here(), at);
            let south_m = -line.distance_m * line.bearing_start_deg.to_radians().cos();
            Some(if (200.0..500.0).contains(&south_m) { 635.0 } else { 600.0 })
        };
        let plane = Aircraft::default();
        let wind = Wind { from_deg: 0.0, speed_m_s: 4.0 };
        let home = Home { lat_deg: here().lat_deg(), lon_deg: here().lon_deg(), alt_amsl_m: 600.0 };
        let level = Conditions { home: Some(home), ..Conditions::new(&plane, Air::from(wind)) };
        let options = options_of(&plane, Some(wind));
        let ranked =
            |conditions: &Conditions<'_>| landing_alternatives(Site::Point(here()), &options, conditions).unwrap();
        assert!((ranked(&level)[0].landing.course_deg).abs() < 1e-6, "into the wind");
        let over = ranked(&Conditions { ground: Some(&hill), ..level });
        let near =
            |one: &Alternative| one.reasons.iter().any(|reason| matches!(reason, LandingReason::GroundNear { .. }));
        assert!(!near(&over[0]) && (over[0].landing.course_deg).abs() > 1.0, "{:?}", over[0]);
        let north: Vec<_> = over.iter().filter(|one| one.landing.course_deg.abs() < 1e-6).collect();
        assert_eq!(north.len(), 2);
        assert!(north.iter().all(|one| near(one) && one.verdict == Verdict::Bad), "{north:?}");
        // The ground at the point is known now.
        assert!(over.iter().all(|one| !one.landing.cautions.contains(&LandingCaution::GroundNotKnown)));
    }

    #[test]
    fn where_the_wind_lets_nobody_come_in_it_is_said() {
        let plane = Aircraft::default();
        let gale = Wind { from_deg: 90.0, speed_m_s: 30.0 };
        let conditions = Conditions::new(&plane, Air::from(gale));
        let across = LandingOptions { course_deg: Some(0.0), ..options_of(&plane, Some(gale)) };
        let error = landing_alternatives(Site::Point(here()), &across, &conditions).unwrap_err();
        assert!(error.to_string().contains("does not come in"), "{error}");
    }

    #[test]
    fn a_landing_is_laid_out_for_its_plane() {
        let values = |name: &str| match name {
            "TECS_LAND_ARSPD" => Some(12.0),
            "WP_LOITER_RAD" => Some(-120.0),
            "TECS_SINK_MIN" => Some(0.6),
            "RTL_AUTOLAND" => Some(2.0),
            _ => None,
        };
        let options = options_of(&Aircraft::from_ardupilot(values), None);
        assert_eq!((options.airspeed_m_s, options.radius_m, options.is_clockwise), (12.0, 120.0, false));
        assert!((options.slope - 0.05).abs() < 1e-9 && options.has_land_start);
        let fast = Aircraft { airspeed_cruise_m_s: 30.0, ..Aircraft::default() };
        let options = options_of(&fast, Some(Wind { from_deg: 0.0, speed_m_s: 5.0 }));
        // 35 m/s at 35 degrees of bank: v² / (g tan φ) = 178 m.
        assert_eq!((options.radius_m, options.has_land_start), (180.0, false));
    }

    #[test]
    fn what_was_not_designed_is_not_moved() {
        let only = [MissionItem::land(40.0, -4.0, 0.0)];
        let error = move_landing(&only, LandingPart::Point, here(), &LandingOptions::default()).unwrap_err();
        assert!(error.to_string().contains("circle down"), "{error}");
    }

    proptest! {
        /// A part that is moved is where it was moved to, and moved to where it is, nothing changes.
        #[test]
        fn the_rest_follows_the_part_that_is_moved(
            course_deg in 0.0..360.0_f64, final_height_m in 20.0..100.0_f64, slope in 0.03..0.1_f64, radius_m in 60.0..200.0_f64,
            is_clockwise: bool, has_land_start: bool, bearing_deg in 0.0..360.0_f64, by_m in 0.0..150.0_f64,
        ) {
            let options = LandingOptions {
                course_deg: Some(course_deg), ground_rel_home_m: Some(7.0), final_height_m, slope, radius_m, is_clockwise, has_land_start,
                ..LandingOptions::default()
            };
            let landing = design_landing(here(), &options).unwrap();
            let circle = landing.items[usize::from(has_land_start)].point().unwrap();
            let rest = LandingOptions::default();
            for (part, place) in
                [(LandingPart::Point, here()), (LandingPart::FinalLeg, landing.leaves), (LandingPart::Circle, circle)]
            {
                let same = move_landing(&landing.items, part, place, &rest).unwrap();
                for (one, other) in same.items.iter().zip(&landing.items) {
                    prop_assert!(distance_m(one.point().unwrap(), other.point().unwrap()) < 0.5, "{part:?}");
                    prop_assert_eq!((one.command, one.alt_m()), (other.command, other.alt_m()));
                }
                prop_assert!((same.slope - landing.slope).abs() < 1e-3);

                let to = direct(place, bearing_deg, by_m);
                let moved = move_landing(&landing.items, part, to, &rest).unwrap();
                let at = match part {
                    LandingPart::Point => moved.items.last().unwrap().point().unwrap(),
                    LandingPart::FinalLeg => moved.leaves,
                    LandingPart::Circle => moved.items[usize::from(has_land_start)].point().unwrap(),
                };
                // No shorter than the plane needs on it, no flatter than it flies.
                let shortest_m = settling_time_s() * rest.airspeed_m_s;
                let is_held = moved.final_m > shortest_m + 0.01 && moved.slope > 0.0201;
                prop_assert!(distance_m(at, to) < 1.0 || !is_held, "{part:?}: {} m", distance_m(at, to));
                prop_assert_eq!(moved.items.len(), landing.items.len());
            }
        }
    }
}
