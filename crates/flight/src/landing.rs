//! Landing design: the items that bring a fixed-wing plane down on a point.
//!
//! The heights of a landing's last waypoints need no tuning by hand, because no height that comes before has a part in
//! them. The plane goes round a circle that touches the extended final leg until it has the height of the leg's
//! beginning, leaves it along the tangent, and flies one straight slope to the point:
//!
//! ```text
//!                 ___
//!               /     \      circle down (NAV_LOITER_TO_ALT)
//!              |   +   |
//!               \     /
//!   ─ ─ ─ ─ ─ ─ ─ ─●─────────────────────────────▶ ✕
//!                  leaves    final leg, one slope   touchdown (NAV_LAND)
//! ```
//!
//! It is the pattern of QGroundControl's fixed-wing landing (`FixedWingLandingComplexItem`), with what an ArduPlane
//! needs: `NAV_LAND` after the place where the slope begins (`AP_Landing_Slope` takes the line from there to the point
//! for the glide slope), and `DO_LAND_START` before all, so that "land" and a return find it.
//!
//! The height of the ground at the point is home's unless it is given, and [`LandingCaution::GroundNotKnown`] says so.
//! [`design_landing_over`] takes it from a map, and looks how near the approach comes to the ground; obstacles are not
//! in any map of heights: the pilot has to look for them.

use std::f64::consts::TAU;

use crate::error::{FlightError, LandingProblem, Result};
use crate::geodesy::{GeoPoint, direct, distance_m, inverse, wrap_180_deg, wrap_360_deg};
use crate::guidance::GRAVITY_M_S2;
use crate::guidance::l1::L1Params;
use crate::plan::MissionItem;
use crate::words::words;

/// Slope, height over distance, above which an approach is steep: a plane without flaps or airbrakes gains speed on it
/// and lands long. ArduPilot's guide to automatic landings advises 1 in 10.
pub const STEEP_SLOPE: f64 = 0.10;
/// Wind below this has no direction to land into, m/s.
pub const CALM_M_S: f64 = 1.0;
/// Tailwind on the final leg that is worth a word, m/s.
const TAILWIND_M_S: f64 = 2.0;
/// How far away a place must lie to give the final leg its direction, m: less is the error of a position.
const NEAREST_FROM_M: f64 = 20.0;
/// Slower than this over ground a plane does not come in, m/s.
const MIN_GROUNDSPEED_M_S: f64 = 3.0;
/// Bank in the circle, degrees: 10 below ArduPlane's default limit of 45 (`ROLL_LIMIT_DEG`), to correct with.
const CIRCLE_BANK_DEG: f64 = 35.0;
/// The circle's radius is a multiple of this, m: ArduPilot keeps whole metres.
const RADIUS_STEP_M: f64 = 5.0;
/// Distance between two looks at the ground below the final leg, m; no map has heights nearer to each other than some
/// metres.
const LOOKED_AT_EVERY_M: f64 = 10.0;
/// Height above the point below which the ground is not looked at, m.
const LOOKED_AT_FROM_M: f64 = 15.0;
/// Height above the ground that is enough anywhere on the approach, m.
const CLEARANCE_M: f64 = 30.0;

/// Wind that a plan is made for; calm by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(deny_unknown_fields), schema(as = PlanWind))]
pub struct Wind {
    /// Where it comes from, degrees from true north.
    pub from_deg: f64,
    /// Its speed, m/s, 0 to 60.
    pub speed_m_s: f64,
}

/// How a landing is laid out, with the defaults of a small foam plane on an ArduPlane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandingOptions {
    /// Course of the final leg, degrees from true north, when the runway has one.
    pub course_deg: Option<f64>,
    /// Where the plane comes from. Without a course the final leg has the direction from there to the point, unless it
    /// is nearer than 20 m.
    pub coming_from: Option<GeoPoint>,
    /// Wind; `None`: unknown. Without a course or a place to come from the plane lands into it.
    pub wind: Option<Wind>,
    /// Height of the ground at the point above home, m, −1000 to 1000; `None`: unknown, home's is taken.
    pub ground_rel_home_m: Option<f64>,
    /// Airspeed of the approach, m/s, 5 to 60. Default 22 (`AIRSPEED_CRUISE`).
    pub airspeed_m_s: f64,
    /// Steepest slope of the final leg, height over distance, 0.02 to 0.25. Default 0.08: 1 in 12.5, 4.6 degrees.
    pub slope: f64,
    /// Height above the ground where the final leg begins, m, 15 to 200. Default 40.
    pub final_height_m: f64,
    /// Smallest radius of the circle, m, 20 to 500. Default 80, wider than an ArduPlane's usual one (`WP_LOITER_RAD`,
    /// 60): a plane that goes down flies it slowly, and the wind must not carry it off. For a known vehicle
    /// [`crate::approaches`] takes its own.
    pub radius_m: f64,
    /// Whether the circle is flown clockwise, to the right of the final leg. Default yes.
    pub is_clockwise: bool,
    /// Whether `DO_LAND_START` goes before it. An ArduPlane with `RTL_AUTOLAND` 0 does not arm with one. Default yes.
    pub has_land_start: bool,
}

impl Default for LandingOptions {
    fn default() -> Self {
        Self {
            course_deg: None,
            coming_from: None,
            wind: None,
            ground_rel_home_m: None,
            airspeed_m_s: 22.0,
            slope: 0.08,
            final_height_m: 40.0,
            radius_m: 80.0,
            is_clockwise: true,
            has_land_start: true,
        }
    }
}

words! {
    /// What gave a final leg its direction.
    LandingDirection {
        /// The course that was asked for.
        Course = "course",
        /// The place that the plane comes from.
        ComingFrom = "coming-from",
        /// The wind, against which it lands.
        IntoWind = "into-wind",
    }
}

/// A caution about a landing, for the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LandingCaution {
    /// The height of the ground at the point is not known; home's was taken.
    GroundNotKnown,
    /// The slope is steeper than [`STEEP_SLOPE`].
    Steep {
        /// Height over distance.
        slope: f64,
    },
    /// The wind comes from behind.
    Tailwind {
        /// Its part along the final leg, m/s.
        speed_m_s: f64,
    },
    /// The ground comes near the final leg or the circle.
    GroundNear {
        /// How near, at the worst place, m; negative below the ground.
        clearance_m: f64,
        /// How much it should be there, m.
        wanted_m: f64,
        /// How far from the point, m.
        distance_m: f64,
    },
}

impl LandingCaution {
    /// A stable name, fit for scripts.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::GroundNotKnown => "ground-not-known",
            Self::Steep { .. } => "steep-approach",
            Self::Tailwind { .. } => "tailwind",
            Self::GroundNear { .. } => "ground-near",
        }
    }
}

impl std::fmt::Display for LandingCaution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::GroundNotKnown => f.write_str(
                "the height of the ground at the landing point is not known: home's was taken; give it where the field is not level",
            ),
            Self::Steep { slope } => {
                write!(f, "the final leg drops 1 m in {:.1}: the plane gains speed and lands long", 1.0 / slope)
            }
            Self::Tailwind { speed_m_s } => {
                write!(f, "{speed_m_s:.0} m/s of the wind come from behind on the final leg: the plane lands long and fast")
            }
            Self::GroundNear { clearance_m, wanted_m, distance_m } => write!(
                f,
                "{distance_m:.0} m before the point the approach is {:.0} m above the ground, and should be {wanted_m:.0}: come from another side or steeper",
                clearance_m.max(0.0)
            ),
        }
    }
}

/// A landing, ready to be the end of a mission.
#[derive(Debug, Clone, PartialEq)]
pub struct Landing {
    /// DO_LAND_START where asked for, NAV_LOITER_TO_ALT, NAV_LAND; heights above home.
    pub items: Vec<MissionItem>,
    /// Course of the final leg at the point, degrees from true north, 0 to 360.
    pub course_deg: f64,
    /// Its origin.
    pub direction: LandingDirection,
    /// Where the final leg begins.
    pub leaves: GeoPoint,
    /// Height there, m above home.
    pub leaves_alt_rel_home_m: f64,
    /// Length of the final leg, m.
    pub final_m: f64,
    /// Its slope, height over distance.
    pub slope: f64,
    /// Radius of the circle, m.
    pub radius_m: f64,
    /// Part of the wind against the plane on the final leg, m/s, negative from behind; `None`: no wind is known.
    pub headwind_m_s: Option<f64>,
    /// Speed over ground on the final leg, m/s; `None`: no wind is known.
    pub groundspeed_m_s: Option<f64>,
    /// Cautions for the pilot.
    pub cautions: Vec<LandingCaution>,
}

/// Time on the final leg that the plane needs to be steady on it before it flares, s.
///
/// The L1 law is a second-order loop with period T and damping ζ at every speed ([`crate::guidance::l1`]), so its error
/// is below 5 % after 3 / (ζ ω), ω = 2π / T (K. Ogata, "Modern Control Engineering", 5th ed., eq. 5-22). Twice that:
/// the height settles after the course has.
pub fn settling_time_s() -> f64 {
    let law = L1Params::default();
    2.0 * 3.0 * law.period_s / (law.damping * TAU)
}

/// Designs a landing at a point.
///
/// - The final leg is `final_height_m / slope` long, or longer where the plane would be on it for less than
///   [`settling_time_s`]: then the slope is gentler. A plane that is followed by the wind gets a longer leg.
/// - Its groundspeed is that of the wind triangle: √(V² − W⊥²) − W∥ with the wind's parts across and against the
///   course.
/// - The circle can be flown all round at 35° of bank with the wind behind: r = (V + W)² / (g tan φ), from the balance
///   of a level turn; never below `radius_m`. Its centre lies a radius to the side of where it is left.
///
/// # Errors
/// [`FlightError::BadLanding`] for an option out of its range, when neither course, origin nor wind determines the
/// direction, and when the wind is so strong that the plane would not come in.
pub fn design_landing(point: GeoPoint, options: &LandingOptions) -> Result<Landing> {
    check(options)?;
    let (course_deg, direction) = course(point, options)?;
    let mut cautions = Vec::new();
    if options.ground_rel_home_m.is_none() {
        cautions.push(LandingCaution::GroundNotKnown);
    }
    let ground_m = options.ground_rel_home_m.unwrap_or(0.0);

    let along = options.wind.map(|wind| along_leg(options.airspeed_m_s, wind, course_deg)).transpose()?;
    let groundspeed_m_s = along.map(|(_, groundspeed_m_s)| groundspeed_m_s);
    let settled_m = settling_time_s() * groundspeed_m_s.unwrap_or(options.airspeed_m_s);
    let final_m = (options.final_height_m / options.slope).max(settled_m);
    let slope = options.final_height_m / final_m;
    if slope > STEEP_SLOPE {
        cautions.push(LandingCaution::Steep { slope });
    }
    let headwind_m_s = along.map(|(headwind_m_s, _)| headwind_m_s);
    if let Some(headwind_m_s) = headwind_m_s.filter(|headwind_m_s| *headwind_m_s < -TAILWIND_M_S) {
        cautions.push(LandingCaution::Tailwind { speed_m_s: -headwind_m_s });
    }

    let fastest_m_s = options.airspeed_m_s + options.wind.map_or(0.0, |wind| wind.speed_m_s);
    let turn_m = fastest_m_s * fastest_m_s / (GRAVITY_M_S2 * CIRCLE_BANK_DEG.to_radians().tan());
    let radius_m = options.radius_m.max((turn_m / RADIUS_STEP_M).ceil() * RADIUS_STEP_M);

    let leaves = direct(point, course_deg + 180.0, final_m);
    // Seen from there: a geodesic turns on its way.
    let onward_deg = inverse(leaves, point).bearing_start_deg;
    let side = if options.is_clockwise { 1.0 } else { -1.0 };
    let centre = direct(leaves, onward_deg + side * 90.0, radius_m);
    let alt_m = ground_m + options.final_height_m;
    let mut items = Vec::with_capacity(3);
    if options.has_land_start {
        items.push(MissionItem::land_start(leaves.lat_deg(), leaves.lon_deg(), alt_m));
    }
    items.push(MissionItem::loiter_to_alt(centre.lat_deg(), centre.lon_deg(), alt_m, side * radius_m));
    items.push(MissionItem::land(point.lat_deg(), point.lon_deg(), ground_m));
    Ok(Landing {
        items,
        course_deg,
        direction,
        leaves,
        leaves_alt_rel_home_m: alt_m,
        final_m,
        slope,
        radius_m,
        headwind_m_s,
        groundspeed_m_s,
        cautions,
    })
}

/// Designs a landing over ground that is known.
///
/// `ground_rel_home_m` tells its height above home, m, and `None` where it is not known. The point's height is taken
/// from it where [`LandingOptions::ground_rel_home_m`] gives none. Along the final leg and the circle, half the height
/// above the point must be left above the ground, 30 m at most; below 15 m nothing is required, because terrain data
/// are off by as much.
///
/// # Errors
/// Those of [`design_landing`].
pub fn design_landing_over(
    point: GeoPoint,
    options: &LandingOptions,
    ground_rel_home_m: &dyn Fn(GeoPoint) -> Option<f64>,
) -> Result<Landing> {
    let field_m = options.ground_rel_home_m.or_else(|| ground_rel_home_m(point));
    let mut landing = design_landing(point, &LandingOptions { ground_rel_home_m: field_m, ..*options })?;
    let from_m = landing.leaves_alt_rel_home_m - field_m.unwrap_or(0.0);
    let steps = (landing.final_m / LOOKED_AT_EVERY_M).ceil();
    let leg = (0..=steps as u32).map(|step| f64::from(step) / steps).map(|part| {
        (
            direct(landing.leaves, inverse(landing.leaves, point).bearing_start_deg, landing.final_m * part),
            from_m * (1.0 - part),
        )
    });
    let side = if options.is_clockwise { 1.0 } else { -1.0 };
    let centre =
        direct(landing.leaves, inverse(landing.leaves, point).bearing_start_deg + side * 90.0, landing.radius_m);
    let circle = (0..36).map(|part| (direct(centre, f64::from(part) * 10.0, landing.radius_m), from_m));
    let near = leg.chain(circle).filter(|(_, height_m)| *height_m >= LOOKED_AT_FROM_M).filter_map(|(at, height_m)| {
        let clearance_m = height_m + field_m.unwrap_or(0.0) - ground_rel_home_m(at)?;
        let wanted_m = CLEARANCE_M.min(0.5 * height_m);
        (clearance_m < wanted_m).then(|| (clearance_m, wanted_m, distance_m(at, point)))
    });
    let worst = near.min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
    if let Some((clearance_m, wanted_m, distance_m)) = worst {
        landing.cautions.push(LandingCaution::GroundNear { clearance_m, wanted_m, distance_m });
    }
    Ok(landing)
}

/// Whatever can be out of its range, and its range.
fn check(options: &LandingOptions) -> Result<()> {
    let wind = options.wind.unwrap_or_default();
    for (option, value, low, high) in [
        ("course_deg", options.course_deg.unwrap_or(0.0), -360.0, 360.0),
        ("wind from_deg", wind.from_deg, -360.0, 360.0),
        ("wind speed_m_s", wind.speed_m_s, 0.0, 60.0),
        ("ground_rel_home_m", options.ground_rel_home_m.unwrap_or(0.0), -1000.0, 1000.0),
        ("airspeed_m_s", options.airspeed_m_s, 5.0, 60.0),
        ("slope", options.slope, 0.02, 0.25),
        ("final_height_m", options.final_height_m, 15.0, 200.0),
        ("radius_m", options.radius_m, 20.0, 500.0),
    ] {
        // NaN is in no range.
        if !(low..=high).contains(&value) {
            return Err(FlightError::BadLanding(LandingProblem::OutOfRange { option, value, low, high }));
        }
    }
    Ok(())
}

fn course(point: GeoPoint, options: &LandingOptions) -> Result<(f64, LandingDirection)> {
    if let Some(course_deg) = options.course_deg {
        return Ok((wrap_360_deg(course_deg), LandingDirection::Course));
    }
    if let Some(from) = options.coming_from.filter(|from| distance_m(*from, point) >= NEAREST_FROM_M) {
        return Ok((inverse(from, point).bearing_end_deg, LandingDirection::ComingFrom));
    }
    if let Some(wind) = options.wind.filter(|wind| wind.speed_m_s >= CALM_M_S) {
        return Ok((wrap_360_deg(wind.from_deg), LandingDirection::IntoWind));
    }
    Err(FlightError::BadLanding(LandingProblem::NoDirection { nearest_m: NEAREST_FROM_M }))
}

/// Headwind and groundspeed on a course, m/s.
fn along_leg(airspeed_m_s: f64, wind: Wind, course_deg: f64) -> Result<(f64, f64)> {
    on_course(airspeed_m_s, wind, course_deg).ok_or(FlightError::BadLanding(LandingProblem::TooMuchWind {
        wind_m_s: wind.speed_m_s,
        airspeed_m_s,
        course_deg,
    }))
}

/// Headwind and groundspeed on a course, m/s, by the wind triangle; `None` where the plane would not get along.
pub(crate) fn on_course(airspeed_m_s: f64, wind: Wind, course_deg: f64) -> Option<(f64, f64)> {
    let angle = wrap_180_deg(wind.from_deg - course_deg).to_radians();
    let (headwind_m_s, crosswind_m_s) = (wind.speed_m_s * angle.cos(), wind.speed_m_s * angle.sin());
    let ahead = airspeed_m_s * airspeed_m_s - crosswind_m_s * crosswind_m_s;
    let groundspeed_m_s = ahead.max(0.0).sqrt() - headwind_m_s;
    (ahead > 0.0 && groundspeed_m_s >= MIN_GROUNDSPEED_M_S).then_some((headwind_m_s, groundspeed_m_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{CheckContext, check_plan};
    use crate::geodesy::leg_offset;
    use crate::plan::{Command, Mission, Plan};
    use proptest::prelude::*;

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    fn circle(landing: &Landing) -> (GeoPoint, f64) {
        let item = landing.items.iter().find(|item| item.command == Command::NAV_LOITER_TO_ALT).unwrap();
        (item.point().unwrap(), item.params[1].unwrap())
    }

    #[test]
    fn a_small_plane_from_the_west() {
        let point = at(40.3332, -3.7978);
        let options = LandingOptions { coming_from: Some(at(40.3332, -3.82)), ..LandingOptions::default() };
        let landing = design_landing(point, &options).unwrap();
        assert_eq!(
            landing.items.iter().map(|item| item.command).collect::<Vec<_>>(),
            [Command::DO_LAND_START, Command::NAV_LOITER_TO_ALT, Command::NAV_LAND]
        );
        assert_eq!((landing.final_m, landing.slope, landing.radius_m), (500.0, 0.08, 80.0));
        assert_eq!((landing.direction, landing.leaves_alt_rel_home_m), (LandingDirection::ComingFrom, 40.0));
        assert!((landing.course_deg - 90.0).abs() < 0.1, "{}", landing.course_deg);
        assert_eq!(landing.items[2].point(), Some(point));
        assert_eq!(
            landing.items.iter().map(MissionItem::alt_m).collect::<Vec<_>>(),
            [Some(40.0), Some(40.0), Some(0.0)]
        );
        assert_eq!(landing.cautions, [LandingCaution::GroundNotKnown]);
        assert_eq!((landing.headwind_m_s, landing.groundspeed_m_s), (None, None), "no wind is known");
        let (centre, radius_m) = circle(&landing);
        assert!(
            radius_m > 0.0 && centre.lat_deg() < point.lat_deg(),
            "clockwise: to the right, south of an eastward leg"
        );
    }

    #[test]
    fn the_runway_comes_before_the_place_and_that_before_the_wind() {
        let point = at(-33.9, 151.2);
        let wind = Some(Wind { from_deg: 225.0, speed_m_s: 6.0 });
        let mut options = LandingOptions { wind, ..LandingOptions::default() };
        let landing = design_landing(point, &options).unwrap();
        assert_eq!((landing.course_deg, landing.direction), (225.0, LandingDirection::IntoWind));
        assert!(
            (landing.headwind_m_s.unwrap() - 6.0).abs() < 1e-9
                && (landing.groundspeed_m_s.unwrap() - 16.0).abs() < 1e-9
        );
        options.coming_from = Some(direct(point, 0.0, 19.0));
        assert_eq!(design_landing(point, &options).unwrap().direction, LandingDirection::IntoWind, "too near to tell");
        options.coming_from = Some(direct(point, 0.0, 2000.0));
        let landing = design_landing(point, &options).unwrap();
        assert_eq!(landing.direction, LandingDirection::ComingFrom);
        assert!((landing.course_deg - 180.0).abs() < 1e-6);
        options.course_deg = Some(-90.0);
        let landing = design_landing(point, &options).unwrap();
        assert_eq!((landing.course_deg, landing.direction), (270.0, LandingDirection::Course));
    }

    #[test]
    fn what_the_pilot_should_know_is_said() {
        let point = at(40.0, -4.0);
        let wind = Some(Wind { from_deg: 180.0, speed_m_s: 8.0 });
        let options =
            LandingOptions { course_deg: Some(0.0), wind, ground_rel_home_m: Some(12.0), ..LandingOptions::default() };
        let landing = design_landing(point, &options).unwrap();
        assert_eq!(landing.cautions, [LandingCaution::Tailwind { speed_m_s: 8.0 }]);
        assert!(landing.cautions[0].to_string().starts_with("8 m/s of the wind come from behind"));
        assert!(landing.final_m > 500.0 && landing.slope < 0.08, "the leg grows so that the plane is as long on it");
        assert_eq!(
            landing.items.iter().map(MissionItem::alt_m).collect::<Vec<_>>(),
            [Some(52.0), Some(52.0), Some(12.0)]
        );
        let steep = LandingOptions {
            slope: 0.2,
            final_height_m: 100.0,
            course_deg: Some(0.0),
            ground_rel_home_m: Some(0.0),
            ..LandingOptions::default()
        };
        let landing = design_landing(point, &steep).unwrap();
        assert_eq!(landing.cautions, [LandingCaution::Steep { slope: 0.2 }]);
        assert!(landing.cautions[0].to_string().contains("1 m in 5.0"));
        let eighth = LandingOptions { slope: 0.125, ..steep };
        assert_eq!(design_landing(point, &eighth).unwrap().cautions.len(), 1, "1 in 8 is steep");
        let gentle = LandingOptions { slope: 0.1, ..steep };
        assert!(design_landing(point, &gentle).unwrap().cautions.is_empty());
    }

    #[test]
    fn ground_near_the_approach_is_told() {
        let point = at(40.0, -4.0);
        let options = LandingOptions { course_deg: Some(90.0), ..LandingOptions::default() };
        // The field lies 12 m above home; 300 m before the point, where the plane is 24 m above it, a bank rises.
        let over = |bank_m: f64| {
            let bank = direct(point, 270.0, 300.0);
            design_landing_over(point, &options, &|at| {
                Some(12.0 + if distance_m(at, bank) < 25.0 { bank_m } else { 0.0 })
            })
            .unwrap()
        };
        let level = over(0.0);
        assert_eq!((level.items[2].alt_m(), level.leaves_alt_rel_home_m, level.cautions.len()), (Some(12.0), 52.0, 0));
        assert!(over(10.0).cautions.is_empty());
        let cautions = over(16.0).cautions;
        let [LandingCaution::GroundNear { clearance_m, wanted_m, distance_m }] = cautions[..] else {
            panic!("{cautions:?}")
        };
        assert!((5.5..8.0).contains(&clearance_m) && (11.0..12.5).contains(&wanted_m), "{clearance_m} {wanted_m}");
        assert!((275.0..325.0).contains(&distance_m), "{distance_m}");
        assert!(cautions[0].to_string().contains("m before the point the approach is"), "{}", cautions[0]);
        // A hill under the circle alone.
        let hill = |at: GeoPoint| Some(if at.lat_deg() < 39.999 { 25.0 } else { 0.0 });
        let landing = design_landing_over(point, &options, &hill).unwrap();
        assert!(matches!(landing.cautions[..], [LandingCaution::GroundNear { wanted_m: 20.0, .. }]), "{landing:?}");
        let unknown = design_landing_over(point, &options, &|_| None).unwrap();
        assert_eq!(unknown, design_landing(point, &options).unwrap());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let point = at(40.0, -4.0);
        let fine = LandingOptions { course_deg: Some(0.0), ..LandingOptions::default() };
        let wind = |from_deg, speed_m_s| Some(Wind { from_deg, speed_m_s });
        for (options, says) in [
            (LandingOptions::default(), "nothing says in which direction to land"),
            (LandingOptions { wind: wind(90.0, 0.5), ..LandingOptions::default() }, "nothing says"),
            (LandingOptions { course_deg: Some(f64::NAN), ..fine }, "course_deg is NaN"),
            (LandingOptions { slope: 0.5, ..fine }, "slope is 0.5, should be 0.02 to 0.25"),
            (LandingOptions { slope: 0.0, ..fine }, "slope is 0,"),
            (LandingOptions { final_height_m: 5.0, ..fine }, "final_height_m is 5"),
            (LandingOptions { radius_m: f64::INFINITY, ..fine }, "radius_m is inf"),
            (LandingOptions { airspeed_m_s: 0.0, ..fine }, "airspeed_m_s is 0"),
            (LandingOptions { ground_rel_home_m: Some(1e9), ..fine }, "ground_rel_home_m"),
            (LandingOptions { wind: wind(0.0, 100.0), ..fine }, "wind speed_m_s is 100"),
            (LandingOptions { wind: wind(0.0, 25.0), ..fine }, "does not come in on course 0"),
            (LandingOptions { wind: wind(90.0, 23.0), ..fine }, "does not come in"),
        ] {
            let error = design_landing(point, &options).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    fn options() -> impl Strategy<Value = LandingOptions> {
        let wind = proptest::option::of((0.0..360.0, 0.0..12.0));
        let direction = (proptest::option::of(0.0..360.0), 0.0..360.0, 30.0..20_000.0);
        let shape = (0.02..=0.25, 15.0..=200.0, 20.0..=500.0, 16.0..=40.0, any::<bool>(), any::<bool>());
        (wind, direction, proptest::option::of(-50.0..300.0), shape).prop_map(
            |(wind, (course_deg, bearing_deg, far_m), ground_rel_home_m, shape)| {
                let (slope, final_height_m, radius_m, airspeed_m_s, is_clockwise, has_land_start) = shape;
                LandingOptions {
                    course_deg,
                    // Turned into a place beside the point by the test.
                    coming_from: Some(direct(at(0.0, 0.0), bearing_deg, far_m)),
                    wind: wind.map(|(from_deg, speed_m_s)| Wind { from_deg, speed_m_s }),
                    ground_rel_home_m,
                    airspeed_m_s,
                    slope,
                    final_height_m,
                    radius_m,
                    is_clockwise,
                    has_land_start,
                }
            },
        )
    }

    proptest! {
        /// Wherever on the globe and however it is asked for: the circle touches the leg where the leg begins, the leg
        /// leads to the point on its course and drops by what it should, and the checks of a plan find nothing.
        #[test]
        fn the_circle_touches_the_leg_and_the_leg_leads_to_the_point(
            lat_deg in -80.0..80.0, lon_deg in -180.0..180.0, options in options()
        ) {
            let point = at(lat_deg, lon_deg);
            let seen = inverse(at(0.0, 0.0), options.coming_from.unwrap());
            let from = direct(point, seen.bearing_start_deg, seen.distance_m);
            let options = LandingOptions { coming_from: Some(from), ..options };
            let landing = design_landing(point, &options).unwrap();

            let leg = inverse(landing.leaves, point);
            prop_assert!((leg.distance_m - landing.final_m).abs() < 1e-3);
            prop_assert!(wrap_180_deg(leg.bearing_end_deg - landing.course_deg).abs() < 1e-3);
            let wanted_deg = options.course_deg.unwrap_or_else(|| inverse(from, point).bearing_end_deg);
            prop_assert!(wrap_180_deg(landing.course_deg - wanted_deg).abs() < 1e-9);

            let (centre, radius_m) = circle(&landing);
            prop_assert_eq!(radius_m.abs(), landing.radius_m);
            let offset = leg_offset(landing.leaves, point, centre);
            prop_assert!(offset.along_m.abs() < 0.5, "the centre is abeam of where the circle is left: {offset:?}");
            prop_assert!((offset.cross_m - radius_m).abs() < 0.5, "to the right when clockwise: {offset:?}");

            prop_assert!(landing.slope <= options.slope + 1e-12);
            prop_assert!((landing.slope * landing.final_m - options.final_height_m).abs() < 1e-6);
            let ground_m = options.ground_rel_home_m.unwrap_or(0.0);
            let land = landing.items.last().unwrap();
            prop_assert_eq!((land.command, land.point(), land.alt_m()), (Command::NAV_LAND, Some(point), Some(ground_m)));
            prop_assert_eq!(landing.leaves_alt_rel_home_m, ground_m + options.final_height_m);
            prop_assert_eq!(landing.items.len(), if options.has_land_start { 3 } else { 2 });
            prop_assert_eq!(landing.items[0].command == Command::DO_LAND_START, options.has_land_start);
            prop_assert_eq!(landing.cautions.contains(&LandingCaution::GroundNotKnown), options.ground_rel_home_m.is_none());
            prop_assert_eq!(
                landing.cautions.contains(&LandingCaution::Steep { slope: landing.slope }), landing.slope > STEEP_SLOPE
            );

            // The checks of a whole plan find nothing in an approach that is not steep.
            let mission = Mission { items: landing.items.clone(), ..Mission::default() };
            let plan = Plan { mission, ..Plan::default() };
            let context = CheckContext { far_from_home_m: f64::MAX, ..CheckContext::default() };
            let said: Vec<_> = check_plan(&plan, &context).iter().map(ToString::to_string).collect();
            let of_approach = |text: &&String| text.contains("approach to") || text.contains("DO_LAND_START");
            // Within a hair of the limit the two may differ: the circle's centre lies farther than its edge.
            if landing.slope <= STEEP_SLOPE {
                prop_assert_eq!(said.iter().find(of_approach), None);
            }
        }

        /// The plane can fly it: long enough on the leg, no steeper turn than the bank allows, forward over the ground.
        #[test]
        fn the_plane_can_fly_it_in_any_wind(options in options(), from_deg in 0.0..360.0, speed_m_s in 0.0..12.0) {
            let point = at(40.0, -4.0);
            let wind = Wind { from_deg, speed_m_s };
            let options = LandingOptions { coming_from: Some(at(40.1, -4.0)), wind: Some(wind), ..options };
            let landing = design_landing(point, &options).unwrap();
            let (headwind, groundspeed) = (landing.headwind_m_s.unwrap(), landing.groundspeed_m_s.unwrap());
            // The wind triangle, made again from its vectors: air velocity is ground velocity less the wind's.
            let (course, from) = (landing.course_deg.to_radians(), from_deg.to_radians());
            let air = [
                groundspeed * course.cos() + speed_m_s * from.cos(),
                groundspeed * course.sin() + speed_m_s * from.sin(),
            ];
            prop_assert!((air[0].hypot(air[1]) - options.airspeed_m_s).abs() < 1e-6);
            prop_assert!(headwind.abs() <= speed_m_s + 1e-12);
            prop_assert!(landing.final_m / groundspeed >= settling_time_s() - 1e-9);
            let fastest = options.airspeed_m_s + speed_m_s;
            let bank_deg = (fastest * fastest / (GRAVITY_M_S2 * landing.radius_m)).atan().to_degrees();
            prop_assert!(bank_deg <= CIRCLE_BANK_DEG + 1e-9, "{bank_deg}");
            prop_assert!(landing.radius_m >= options.radius_m);
        }
    }
}
