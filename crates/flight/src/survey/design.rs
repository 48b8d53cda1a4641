//! The design of a survey: speeds, distances and course, from which lines and way are laid out.

use std::f64::consts::TAU;

use super::camera::Footprint;
use super::layout::{Layout, Leg, SurveyLine};
use super::options::{SurveyOptions, check, in_range, unclear};
use super::order::next_entry;
use super::region::{Region, SurveyShape, range};
use super::route::{Route, in_order};
use crate::error::{FlightError, Result, SurveyProblem};
use crate::geodesy::{GeoPoint, wrap_180_deg, wrap_360_deg};
use crate::guidance::{GRAVITY_M_S2, NorthEast};
use crate::landing::{CALM_M_S, Wind, on_course};
use crate::plan::MissionItem;
use crate::rehearsal::{Aircraft, eas_to_tas};
use crate::words::words;

/// Bank of a turn below the plane's limit, degrees: what is left to correct with.
const BANK_LEFT_DEG: f64 = 10.0;
/// Distance from its line at which a plane is settled on it, m.
const SETTLED_M: f64 = 3.0;
/// Time on the line after its last picture, s: a shutter needs some.
const LEAVES_AFTER_S: f64 = 1.0;
/// Part of the wind along the lines that is worth a word, m/s.
const ALONG_M_S: f64 = 2.0;
/// Pictures that are rather taken than the camera stopped and started again for.
const RATHER_PICTURES: f64 = 5.0;
/// Course change that is flown with the camera on where no camera is known, degrees.
const GENTLE_DEG: f64 = 20.0;

words! {
    /// What gave the lines their course.
    LineCourse {
        /// The course that was asked for.
        Asked = "asked",
        /// The wind, across which they lie: the plane is as fast on the way out as on the way back, so that pictures
        /// are equally far apart and equally sharp, and it crabs by one known angle.
        AcrossWind = "across-wind",
        /// The area, along which they are fewest.
        AlongArea = "along-area",
        /// The line of the corridor.
        Corridor = "corridor",
    }
}

/// A caution about a survey, for the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurveyCaution {
    /// Heights count from home, and the height of the ground is not known; home's was taken.
    GroundNotKnown,
    /// The camera cannot take pictures as fast as they are asked for.
    CameraTooSlow {
        /// Time between two pictures, s.
        interval_s: f64,
        /// The least that the camera can, s.
        least_s: f64,
    },
    /// The wind blows along the lines.
    AlongWind {
        /// Speeds over ground on the way out and back, m/s.
        slow_m_s: f64,
        /// The faster one.
        fast_m_s: f64,
    },
    /// Lines are too few and too near to each other to turn from one to another in half a circle.
    TightTurns {
        /// Distance between lines, m.
        spacing_m: f64,
        /// Radius of the turns, m.
        radius_m: f64,
    },
    /// Neighbouring pictures do not touch, along a line or across.
    Gaps,
    /// The airspeed lies outside the limits of the plane, which will fly at its own.
    SpeedNotTaken {
        /// The airspeed asked for, m/s EAS.
        airspeed_m_s: f64,
        /// The lowest that the plane takes, m/s EAS (`AIRSPEED_MIN`).
        min_m_s: f64,
        /// The highest that it takes, m/s EAS (`AIRSPEED_MAX`).
        max_m_s: f64,
    },
}

impl SurveyCaution {
    /// A stable name, fit for scripts.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::GroundNotKnown => "ground-not-known",
            Self::CameraTooSlow { .. } => "camera-too-slow",
            Self::AlongWind { .. } => "along-wind",
            Self::TightTurns { .. } => "tight-turns",
            Self::Gaps => "gaps",
            Self::SpeedNotTaken { .. } => "speed-not-taken",
        }
    }
}

impl std::fmt::Display for SurveyCaution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::GroundNotKnown => f.write_str(
                "the height of the ground is not known: home's was taken; where it is higher pictures show less and overlap less",
            ),
            Self::CameraTooSlow { interval_s, least_s } => write!(
                f,
                "a picture is due every {interval_s:.1} s, the camera needs {least_s:.1} s: fly slower or higher, or overlap less"
            ),
            Self::AlongWind { slow_m_s, fast_m_s } => write!(
                f,
                "the wind blows along the lines: {slow_m_s:.0} m/s over ground one way and {fast_m_s:.0} m/s the other; across the wind both are the same"
            ),
            Self::TightTurns { spacing_m, radius_m } => write!(
                f,
                "lines {spacing_m:.0} m apart are too few to leave some out where the plane turns within {radius_m:.0} m: it swings out at each end"
            ),
            Self::Gaps => f.write_str("pictures do not touch: there is ground between them that none shows"),
            Self::SpeedNotTaken { airspeed_m_s, min_m_s, max_m_s } => write!(
                f,
                "the plane does not take an airspeed of {airspeed_m_s} m/s and flies at its own, so times and turns are others: choose from {min_m_s} to {max_m_s} m/s"
            ),
        }
    }
}

/// A survey, ready to be placed in a mission.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The area or corridor.
    pub shape: SurveyShape,
    /// The options that it was laid out with.
    pub options: SurveyOptions,
    /// Waypoints and camera; the first waypoint leads to the first line, the last one away from the last.
    pub items: Vec<MissionItem>,
    /// Photographed lines, in the order flown.
    pub lines: Vec<SurveyLine>,
    /// Course of the first line, degrees from true north, 0 to 360.
    pub course_deg: f64,
    /// Origin of the course.
    pub course_from: LineCourse,
    /// Height above the ground, m.
    pub height_m: f64,
    /// Ground that a pixel covers, m; `None` without a camera.
    pub gsd_m: Option<f64>,
    /// Ground that a picture shows; `None` without a camera.
    pub footprint: Option<Footprint>,
    /// Distance between two lines, m.
    pub spacing_m: f64,
    /// Distance between two pictures, m; `None`: the camera is not triggered.
    pub trigger_m: Option<f64>,
    /// Radius that turns are laid out with, m.
    pub turn_radius_m: f64,
    /// Straight way before the first picture of a line, m.
    pub lead_in_m: f64,
    /// Straight way after the last, m.
    pub lead_out_m: f64,
    /// Slower and faster speed over ground on the lines, m/s.
    pub groundspeed_m_s: (f64, f64),
    /// Angle between heading and course on the lines, degrees.
    pub crab_deg: f64,
    /// Size of the area, or of the strip, m².
    pub area_m2: f64,
    /// Length of all that is photographed, m.
    pub line_m: f64,
    /// Length of the way from the first waypoint to the last, m.
    pub length_m: f64,
    /// Time for it, s, in this wind.
    pub duration_s: f64,
    /// Pictures: one more than fits into each line, as fast as the camera can.
    pub photos: usize,
    /// Cautions for the pilot.
    pub cautions: Vec<SurveyCaution>,
}

impl Survey {
    /// Where it can begin in place of where it does: at the next of its corners, in turn around it. Asked for as the
    /// place that the plane comes from ([`SurveyOptions::coming_from`]) it begins there.
    pub fn next_entry(&self) -> Option<GeoPoint> {
        next_entry(&self.lines.iter().map(|line| line.points.as_slice()).collect::<Vec<_>>())
    }
}

/// Lays out a survey.
///
/// - Height and ground sample distance give each other ([`Camera`](super::Camera)); a picture's width and the overlaps give the
///   distance between lines and pictures. A plane that crabs by θ turns its pictures: a strip of pictures `a` wide and
///   `l` long, `b` apart, has no gap within `a cos θ + sin θ (l − 2 b cos θ)`, and that width is overlapped.
/// - Lines lie across the wind unless a course is given ([`LineCourse::AcrossWind`]). A line is photographed from where
///   the strip on either side of it enters the area to where it leaves it; a bay of a concave area is flown through
///   with the camera off.
/// - Turns have the radius `(V + W)² / (g tan φ)` with the wind from behind and a bank of 10° less than the plane may
///   (`ROLL_LIMIT_DEG`, or where it would stall). They are the shortest that the plane can fly (`turn::corners`); each
///   waypoint says how far before it the turn begins. Lines nearer to each other than two radii are flown in race-track
///   order (`order::race_track`).
/// - Before its first picture the plane is straight on the line for `V ln(R / 3 m) / (ζ ω)`: the time in which the L1
///   law, a second-order loop of period T = 2π / ω and damping ζ, brings an error of a turn's radius below 3 m (K.
///   Ogata, "Modern Control Engineering", 5th ed., eq. 5-22).
/// - The camera is switched by `DO_SET_CAM_TRIGG_DIST` where pictures begin and end. The waypoints there lie on a
///   straight leg, so that ArduPlane counts them when it is abeam, not before.
/// - A corridor's passes are parallel to its line. A corner that would bank the plane so much that its pictures leave
///   the strip is flown straight over, and the next leg approached again.
///
/// # Errors
/// [`FlightError::BadSurvey`], which names the option or the corner, and what to change.
pub fn design_survey(shape: &SurveyShape, options: &SurveyOptions, plane: &Aircraft) -> Result<Survey> {
    check(shape, options)?;
    let region = Region::new(shape)?;
    let height_m = match (options.camera, options.gsd_m, options.height_m) {
        (_, None, Some(height_m)) => height_m,
        (Some(camera), Some(gsd_m), None) => camera.height_m(gsd_m),
        (None, Some(_), None) => return unclear("a ground sample distance needs a camera: give one, or a height"),
        _ => return unclear("give either the ground sample distance or the height"),
    };
    in_range("height_m", height_m, 5.0, 10_000.0)?;
    let footprint = options.camera.map(|camera| camera.footprint(height_m, options.is_landscape));

    let above_home_m = height_m + options.ground_rel_home_m.unwrap_or(0.0);
    let airspeed_eas_m_s = options.airspeed_m_s.unwrap_or(plane.airspeed_cruise_m_s);
    in_range("airspeed_m_s", airspeed_eas_m_s, 5.0, 60.0)?;
    let airspeed_m_s = airspeed_eas_m_s * eas_to_tas(options.home_amsl_m + above_home_m);
    let wind = options.wind.unwrap_or_default();
    let speed_on = |course: f64| {
        let problem =
            SurveyProblem::TooMuchWind { wind_m_s: wind.speed_m_s, airspeed_m_s, course_deg: wrap_360_deg(course) };
        on_course(airspeed_m_s, wind, course).map(|(_, speed)| speed).ok_or(FlightError::BadSurvey(problem))
    };
    let radius_m = turn_radius_m(plane, airspeed_eas_m_s, airspeed_m_s + wind.speed_m_s);

    let (course_deg, course_from) = course(&region, options, wind);
    // A corridor's legs have courses of their own; the worst of them counts.
    let courses: Vec<f64> = match region.width_m {
        None => vec![course_deg],
        Some(_) => region.sides().map(|(from, to)| (to - from).bearing_rad().to_degrees()).collect(),
    };
    let mut groundspeed = (f64::INFINITY, 0.0_f64);
    let mut crab_rad = 0.0_f64;
    for course in &courses {
        for course in [*course, *course + 180.0] {
            let speed = speed_on(course)?;
            groundspeed = (groundspeed.0.min(speed), groundspeed.1.max(speed));
            let across = wind.speed_m_s * wrap_180_deg(wind.from_deg - course).to_radians().sin();
            crab_rad = crab_rad.max((across / airspeed_m_s).abs().min(1.0).asin());
        }
    }

    let trigger_m = options.trigger_m.or(footprint.map(|print| print.along_m * (1.0 - options.front_overlap)));
    let strip_m = footprint.map(|print| {
        let (sin, cos) = crab_rad.sin_cos();
        let apart_m = trigger_m.unwrap_or(0.0);
        (print.across_m * cos + sin * (print.along_m - 2.0 * apart_m * cos)).min(print.across_m)
    });
    let Some(spacing_m) = options.spacing_m.or(strip_m.map(|strip_m| strip_m * (1.0 - options.side_overlap))) else {
        return unclear("without a camera give the distance between lines");
    };
    in_range("spacing_m", spacing_m, 1.0, 10_000.0)?;
    if let Some(trigger_m) = trigger_m {
        in_range("trigger_m", trigger_m, 0.5, 10_000.0)?;
    }

    let law = &plane.l1;
    let damped_per_s = (law.damping * TAU / law.period_s).max(0.05);
    let settled_m = groundspeed.1 * (radius_m / SETTLED_M).max(1.0).ln() / damped_per_s;
    let lead_in_m = options.lead_in_m.unwrap_or(settled_m);
    let lead_out_m = groundspeed.1 * (plane.roll_tau_s + LEAVES_AFTER_S);
    let layout = Layout {
        region: &region,
        spacing_m,
        strip_m: strip_m.unwrap_or(spacing_m),
        // Pictures reach as far beyond the edge as they look back.
        margins_m: match (options.margin_m, footprint) {
            (Some(margin_m), _) => (margin_m, margin_m),
            (None, Some(print)) => (0.5 * print.along_m, 0.5 * (strip_m.unwrap_or(0.0) - spacing_m).max(0.0)),
            (None, None) => (0.0, 0.0),
        },
        join_m: RATHER_PICTURES * trigger_m.unwrap_or(spacing_m),
        gentle_rad: gentle_rad(plane, footprint.map(|print| (print.across_m - spacing_m, height_m)), groundspeed.1),
    };
    // Four items to each line at the least; more lines than that are not even laid out.
    let room = options.max_items.saturating_sub(1);
    let most_lines = room / 4 + 1;
    let passes = match region.width_m {
        None => layout.over_area(course_deg.to_radians(), most_lines),
        Some(width_m) => layout.along_line(width_m, most_lines),
    }
    .map_err(|lines| {
        FlightError::BadSurvey(SurveyProblem::TooManyItems { count: lines.saturating_mul(4), max: room })
    })?;

    let apart = (2.0 * radius_m / spacing_m).ceil() as usize;
    let passes = in_order(passes, apart, &region, options.coming_from, wind);
    let route = Route::along(&passes, radius_m, lead_in_m, lead_out_m);
    let (items, lines) =
        route.items(&region, options, above_home_m, height_m, trigger_m, groundspeed.1 * plane.roll_tau_s);
    let count = items.len();
    if count > room {
        return Err(FlightError::BadSurvey(SurveyProblem::TooManyItems { count, max: room }));
    }

    let (mut length_m, mut duration_s) = (0.0, 0.0);
    let places: Vec<NorthEast> = route.places().collect();
    for pair in places.windows(2) {
        let leg = pair[1] - pair[0];
        length_m += leg.length();
        // A turn goes through all courses; where it could not be held the airspeed stands in.
        duration_s += leg.length() / speed_on(leg.bearing_rad().to_degrees()).unwrap_or(airspeed_m_s);
    }
    let shot_m = |(from, to): &(f64, f64)| to - from;
    let shots = || passes.iter().flatten().flat_map(|leg| &leg.shots);
    let least_s = options.camera.map_or(0.0, |camera| camera.min_interval_s);
    let pictures = |leg: &Leg| {
        let Some(trigger_m) = trigger_m else { return 0 };
        let apart_m = trigger_m.max(least_s * speed_on(leg.course_deg()).unwrap_or(airspeed_m_s));
        leg.shots.iter().map(|shot| (shot_m(shot) / apart_m) as usize + 1).sum()
    };
    let photos = passes.iter().flatten().map(pictures).sum();

    let mut cautions = Vec::new();
    let (min_m_s, max_m_s) = (plane.tecs.airspeed_min_m_s, plane.tecs.airspeed_max_m_s);
    if let Some(airspeed_m_s) = options.airspeed_m_s.filter(|asked_m_s| !(min_m_s..=max_m_s).contains(asked_m_s)) {
        cautions.push(SurveyCaution::SpeedNotTaken { airspeed_m_s, min_m_s, max_m_s });
    }
    if options.ground_rel_home_m.is_none() && !options.is_above_terrain {
        cautions.push(SurveyCaution::GroundNotKnown);
    }
    if let Some(interval_s) = trigger_m.map(|trigger_m| trigger_m / groundspeed.1).filter(|time_s| *time_s < least_s) {
        cautions.push(SurveyCaution::CameraTooSlow { interval_s, least_s });
    }
    if region.width_m.is_none() && groundspeed.1 - groundspeed.0 > 2.0 * ALONG_M_S {
        cautions.push(SurveyCaution::AlongWind { slow_m_s: groundspeed.0, fast_m_s: groundspeed.1 });
    }
    if passes.len() > 1 && apart > passes.len() / 2 {
        cautions.push(SurveyCaution::TightTurns { spacing_m, radius_m });
    }
    if let Some((print, trigger_m)) = footprint.zip(trigger_m)
        && (trigger_m > print.along_m || spacing_m > strip_m.unwrap_or(print.across_m))
    {
        cautions.push(SurveyCaution::Gaps);
    }
    Ok(Survey {
        shape: shape.clone(),
        options: *options,
        course_deg: passes.first().and_then(|pass| pass.first()).map_or(course_deg, Leg::course_deg),
        course_from,
        height_m,
        gsd_m: options.camera.map(|camera| camera.gsd_m(height_m)),
        footprint,
        spacing_m,
        trigger_m,
        turn_radius_m: radius_m,
        lead_in_m,
        lead_out_m,
        groundspeed_m_s: groundspeed,
        crab_deg: crab_rad.to_degrees(),
        area_m2: region.area_m2(),
        line_m: shots().map(shot_m).sum(),
        length_m,
        duration_s,
        photos,
        items,
        lines,
        cautions,
    })
}

/// Radius of a turn that is flown with bank to spare, m: `V² / (g tan φ)`, the balance of a level turn.
///
/// Where the autopilot keeps the plane from stalling it banks no further than its load factor allows, `cos φ = (V_min /
/// V)²` (ArduPlane's `Plane::update_load_factor`).
fn turn_radius_m(plane: &Aircraft, airspeed_eas_m_s: f64, fastest_m_s: f64) -> f64 {
    let slow = (plane.tecs.airspeed_min_m_s / airspeed_eas_m_s).clamp(0.0, 1.0);
    let stall_deg = if plane.prevents_stall { (slow * slow).acos().to_degrees().max(25.0) } else { 90.0 };
    let bank_deg = plane.bank_max_deg.min(stall_deg);
    let bank_deg = (bank_deg - BANK_LEFT_DEG).max(0.5 * bank_deg).clamp(5.0, 75.0);
    fastest_m_s * fastest_m_s / (GRAVITY_M_S2 * bank_deg.to_radians().tan())
}

/// Course change of a corridor that is flown with the camera on, radians: the L1 law banks for it by no more than what
/// moves the picture half the overlap aside. At most an acceleration of `4 π ζ V sin η / T` comes from a course that is
/// off by η ([`crate::guidance::l1`], with `L1 = ζ T V / π`).
fn gentle_rad(plane: &Aircraft, spare_and_height_m: Option<(f64, f64)>, groundspeed_m_s: f64) -> f64 {
    let Some((spare_m, height_m)) = spare_and_height_m else { return GENTLE_DEG.to_radians() };
    let tan_bank = (0.5 * spare_m / height_m).max(0.0);
    let law = &plane.l1;
    let most = 2.0 * TAU * law.damping * groundspeed_m_s / (law.period_s * GRAVITY_M_S2);
    (tan_bank / most.max(1e-6)).min(1.0).asin()
}

/// Course of the lines, degrees, and its origin.
fn course(region: &Region, options: &SurveyOptions, wind: Wind) -> (f64, LineCourse) {
    if region.width_m.is_some() {
        let first = region.sides().next().map_or(0.0, |(from, to)| (to - from).bearing_rad());
        return (wrap_360_deg(first.to_degrees()), LineCourse::Corridor);
    }
    if let Some(course_deg) = options.course_deg {
        return (wrap_360_deg(course_deg), LineCourse::Asked);
    }
    if wind.speed_m_s >= CALM_M_S {
        return (wrap_360_deg(wind.from_deg + 90.0), LineCourse::AcrossWind);
    }
    // The narrowest strip that holds an area has one of its sides on its edge.
    let width = |course: f64| {
        let across = NorthEast::from_bearing(course + 0.25 * TAU);
        let (low, high) = range(region.points.iter().map(|at| at.dot(across)));
        high - low
    };
    let sides = region.sides().map(|(from, to)| (to - from).bearing_rad());
    let course = sides.min_by(|one, other| width(*one).total_cmp(&width(*other))).unwrap_or(0.0);
    (wrap_360_deg(course.to_degrees()), LineCourse::AlongArea)
}
