//! The design of a survey: speeds, distances and course, from which lines and way are laid out.

use std::f64::consts::TAU;

use super::camera::{Camera, Footprint};
use super::order::{next_entry, race_track};
use super::region::{Region, SurveyShape, merged, range};
use super::turn::{Pose, corners};
use crate::error::{FlightError, Result, SurveyProblem};
use crate::geodesy::{GeoPoint, wrap_180_deg, wrap_360_deg};
use crate::guidance::{GRAVITY_M_S2, NorthEast};
use crate::landing::{CALM_M_S, Wind, on_course};
use crate::plan::{Command, MavFrame, MissionItem};
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
/// Radius within which a waypoint counts that an item can say at most, m (ArduPilot keeps 8 bits).
const MOST_ACCEPTED_M: f64 = 255.0;

/// How a survey is flown, with defaults. Ground sample distance or height, and a camera or a spacing, have to be given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurveyOptions {
    /// The camera; `None`: none is known, and `height_m` and `spacing_m` are given.
    pub camera: Option<Camera>,
    /// Whether the wide side of the picture lies across the track. Default yes.
    pub is_landscape: bool,
    /// Ground that a pixel is to cover, m, 0.0005 to 10; `None`: as `height_m` gives it.
    pub gsd_m: Option<f64>,
    /// Height above the ground, m, 5 to 10,000; `None`: as `gsd_m` gives it.
    pub height_m: Option<f64>,
    /// Part of a picture that the next one on the line shows too, 0 to 0.95. Default 0.75.
    pub front_overlap: f64,
    /// Part of a picture that those of the next line show too, 0 to 0.95. Default 0.65.
    pub side_overlap: f64,
    /// Distance between two lines, m, 1 to 10,000, in place of the one that `side_overlap` gives.
    pub spacing_m: Option<f64>,
    /// Distance between two pictures, m, 0.5 to 10,000, in place of the one that `front_overlap` gives; without a camera `None` takes none.
    pub trigger_m: Option<f64>,
    /// Course of the lines of an area, degrees from true north; `None`: across the wind, in calm air along the area.
    pub course_deg: Option<f64>,
    /// Wind that is expected; `None`: none.
    pub wind: Option<Wind>,
    /// How far beyond the edge pictures reach, m, 0 to 1,000; `None`: so far that the overlap holds up to the edge.
    pub margin_m: Option<f64>,
    /// Straight way before the first picture of a line, m, 0 to 5,000; `None`: until the plane is settled on it.
    pub lead_in_m: Option<f64>,
    /// Whether heights count from the ground below (frame 10) and not from home.
    pub is_above_terrain: bool,
    /// Height of the ground above home, m, −1,000 to 10,000; `None`: unknown, home's is taken. Nothing above terrain.
    pub ground_rel_home_m: Option<f64>,
    /// Airspeed of the survey, m/s EAS, 5 to 60, set by an item; `None`: the plane's cruise.
    pub airspeed_m_s: Option<f64>,
    /// Height of home above the sea, m: thin air needs wider turns. Default 0.
    pub home_amsl_m: f64,
    /// Where the plane comes from: the survey begins at the end that is nearest; `None`: downwind, and goes on against the wind.
    pub coming_from: Option<GeoPoint>,
    /// Items that the vehicle holds. Default 650, of which home is one.
    pub max_items: usize,
}

impl Default for SurveyOptions {
    fn default() -> Self {
        Self {
            camera: None,
            is_landscape: true,
            gsd_m: None,
            height_m: None,
            front_overlap: 0.75,
            side_overlap: 0.65,
            spacing_m: None,
            trigger_m: None,
            course_deg: None,
            wind: None,
            margin_m: None,
            lead_in_m: None,
            is_above_terrain: false,
            ground_rel_home_m: None,
            airspeed_m_s: None,
            home_amsl_m: 0.0,
            coming_from: None,
            max_items: 650,
        }
    }
}

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
        }
    }
}

/// A stretch that is photographed without a stop.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyLine {
    /// From the first picture to the last, with the corners of a corridor between.
    pub points: Vec<GeoPoint>,
    /// Index in `items` of the waypoint where pictures begin; the camera is switched on after it.
    pub entry: usize,
    /// Index in `items` of the waypoint where they end.
    pub exit: usize,
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
/// - Height and ground sample distance give each other ([`Camera`]); a picture's width and the overlaps give the
///   distance between lines and pictures. A plane that crabs by θ turns its pictures: a strip of pictures `a` wide and
///   `l` long, `b` apart, has no gap within `a cos θ + sin θ (l − 2 b cos θ)`, and that width is overlapped.
/// - Lines lie across the wind unless a course is given ([`LineCourse::AcrossWind`]). A line is photographed from where
///   the strip on either side of it enters the area to where it leaves it; a bay of a concave area is flown through
///   with the camera off.
/// - Turns have the radius `(V + W)² / (g tan φ)` with the wind from behind and a bank of 10° less than the plane may
///   (`ROLL_LIMIT_DEG`, or where it would stall). They are the shortest that the plane can fly ([`corners`]); each
///   waypoint says how far before it the turn begins. Lines nearer to each other than two radii are flown in race-track
///   order ([`race_track`]).
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

fn unclear<T>(problem: &'static str) -> Result<T> {
    Err(FlightError::BadSurvey(SurveyProblem::Unclear(problem)))
}

fn in_range(option: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    // NaN is in no range.
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(FlightError::BadSurvey(SurveyProblem::OutOfRange { option, value, low, high }))
    }
}

/// Whatever can be out of its range, and its range.
fn check(shape: &SurveyShape, options: &SurveyOptions) -> Result<()> {
    let or = |value: Option<f64>, fine: f64| value.unwrap_or(fine);
    let wind = options.wind.unwrap_or_default();
    for (option, value, low, high) in [
        ("gsd_m", or(options.gsd_m, 1.0), 0.000_5, 10.0),
        ("height_m", or(options.height_m, 5.0), 5.0, 10_000.0),
        ("front_overlap", options.front_overlap, 0.0, 0.95),
        ("side_overlap", options.side_overlap, 0.0, 0.95),
        ("spacing_m", or(options.spacing_m, 1.0), 1.0, 10_000.0),
        ("trigger_m", or(options.trigger_m, 1.0), 0.5, 10_000.0),
        ("course_deg", or(options.course_deg, 0.0), -360.0, 360.0),
        ("wind from_deg", wind.from_deg, -360.0, 360.0),
        ("wind speed_m_s", wind.speed_m_s, 0.0, 60.0),
        ("margin_m", or(options.margin_m, 0.0), 0.0, 1_000.0),
        ("lead_in_m", or(options.lead_in_m, 0.0), 0.0, 5_000.0),
        ("ground_rel_home_m", or(options.ground_rel_home_m, 0.0), -1_000.0, 10_000.0),
        ("airspeed_m_s", or(options.airspeed_m_s, 5.0), 5.0, 60.0),
        ("home_amsl_m", options.home_amsl_m, -1_000.0, 10_000.0),
    ] {
        in_range(option, value, low, high)?;
    }
    if let SurveyShape::Corridor { width_m, .. } = shape {
        in_range("width_m", *width_m, 0.0, 5_000.0)?;
    }
    if let Some(camera) = options.camera {
        for (option, value, low, high) in [
            ("sensor_width_mm", camera.sensor_width_mm, 0.5, 200.0),
            ("sensor_height_mm", camera.sensor_height_mm, 0.5, 200.0),
            ("image_width_px", f64::from(camera.image_width_px), 16.0, 100_000.0),
            ("image_height_px", f64::from(camera.image_height_px), 16.0, 100_000.0),
            ("focal_length_mm", camera.focal_length_mm, 0.5, 2_000.0),
            ("min_interval_s", camera.min_interval_s, 0.0, 60.0),
        ] {
            in_range(option, value, low, high)?;
        }
    }
    Ok(())
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

/// A piece of a pass that is flown without a turn that would bank the camera away.
#[derive(Debug, Clone, PartialEq)]
struct Leg {
    /// Two places or more.
    points: Vec<NorthEast>,
    /// Where pictures are taken: from and to, m along it, in order.
    shots: Vec<(f64, f64)>,
}

impl Leg {
    /// The whole way, photographed from end to end.
    fn whole(points: Vec<NorthEast>) -> Self {
        let length_m = points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
        Self { points, shots: vec![(0.0, length_m)] }
    }

    fn start(&self) -> NorthEast {
        self.points[0]
    }

    fn end(&self) -> NorthEast {
        self.points[self.points.len() - 1]
    }

    fn course_rad(&self) -> f64 {
        (self.points[1] - self.points[0]).bearing_rad()
    }

    fn course_deg(&self) -> f64 {
        wrap_360_deg(self.course_rad().to_degrees())
    }

    fn last_course_rad(&self) -> f64 {
        (self.end() - self.points[self.points.len() - 2]).bearing_rad()
    }

    fn reversed(mut self) -> Self {
        let length_m: f64 = self.points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
        self.points.reverse();
        self.shots = self.shots.iter().rev().map(|(from, to)| (length_m - to, length_m - from)).collect();
        self
    }

    /// A place of it.
    fn at(&self, along_m: f64) -> NorthEast {
        let mut left_m = along_m;
        let last = self.points.len() - 2;
        for (index, pair) in self.points.windows(2).enumerate() {
            let side = pair[1] - pair[0];
            if left_m <= side.length() || index == last {
                return pair[0] + side.unit_or(side) * left_m;
            }
            left_m -= side.length();
        }
        self.end()
    }
}

/// One flight over the region, of one leg or more.
type Pass = Vec<Leg>;

/// What lines are laid out with.
struct Layout<'a> {
    region: &'a Region,
    spacing_m: f64,
    /// Width that a line's pictures show without a gap.
    strip_m: f64,
    /// How far beyond the edge pictures reach: along the lines, and across.
    margins_m: (f64, f64),
    /// Gaps between stretches that are photographed rather than left out.
    join_m: f64,
    /// Course change that is flown with the camera on.
    gentle_rad: f64,
}

impl Layout<'_> {
    /// How many lines a width takes and how far the first lies from its middle; their number where they are too many.
    fn across(&self, width_m: f64, most: usize) -> std::result::Result<(usize, f64), usize> {
        let count = (width_m / self.spacing_m - 1e-9).ceil().max(1.0) as usize;
        let first_m = -0.5 * (count as f64 - 1.0) * self.spacing_m;
        if count > most { Err(count) } else { Ok((count, first_m)) }
    }

    /// Parallel lines over an area, those on the left of the course first.
    fn over_area(&self, course_rad: f64, most: usize) -> std::result::Result<Vec<Pass>, usize> {
        let ahead = NorthEast::from_bearing(course_rad);
        let right = NorthEast::from_bearing(course_rad + 0.25 * TAU);
        let (along_m, across_m) = self.margins_m;
        let (low, high) = range(self.region.points.iter().map(|at| at.dot(right)));
        let (count, first_m) = self.across(high - low + 2.0 * across_m, most)?;
        let middle_m = 0.5 * (low + high);
        let passes = (0..count).filter_map(|index| {
            let line_m = middle_m + first_m + index as f64 * self.spacing_m;
            let half_m = 0.5 * self.spacing_m + across_m;
            let inside = self.within(ahead, right, line_m - half_m, line_m + half_m);
            let wide = inside.into_iter().map(|(from, to)| (from - along_m, to + along_m)).collect();
            let shots = merged(wide, self.join_m);
            let (from, to) = (shots.first()?.0, shots.last()?.1);
            let points = [from, to].map(|at| ahead * at + right * line_m).to_vec();
            Some(vec![Leg { points, shots: shots.iter().map(|(begin, end)| (begin - from, end - from)).collect() }])
        });
        Ok(passes.collect())
    }

    /// Where, along the lines, the area has a part in the strip between two distances to their right.
    ///
    /// Whatever of it lies in the strip ends at its sides, or at the border of the strip inside it; so these reach as far.
    fn within(&self, ahead: NorthEast, right: NorthEast, low_m: f64, high_m: f64) -> Vec<(f64, f64)> {
        let mut found = Vec::new();
        let mut crossings = [Vec::new(), Vec::new()];
        for (from, to) in self.region.sides() {
            let (one, other) = ((from.dot(ahead), from.dot(right)), (to.dot(ahead), to.dot(right)));
            let at = |across: f64| one.0 + (other.0 - one.0) * ((across - one.1) / (other.1 - one.1));
            for (border, crossed) in [low_m, high_m].into_iter().zip(&mut crossings) {
                if (one.1 > border) != (other.1 > border) {
                    crossed.push(at(border));
                }
            }
            let (least, most) = (one.1.min(other.1).max(low_m), one.1.max(other.1).min(high_m));
            if least <= most {
                let ends = if (other.1 - one.1).abs() < 1e-9 { [one.0, other.0] } else { [at(least), at(most)] };
                found.push((ends[0].min(ends[1]), ends[0].max(ends[1])));
            }
        }
        for mut crossed in crossings {
            crossed.sort_by(f64::total_cmp);
            found.extend(crossed.chunks_exact(2).map(|pair| (pair[0], pair[1])));
        }
        merged(found, 1e-6)
    }

    /// Passes along a corridor's line, those on its left first.
    fn along_line(&self, width_m: f64, most: usize) -> std::result::Result<Vec<Pass>, usize> {
        let (along_m, across_m) = self.margins_m;
        // One pass shows a strip: a narrower corridor needs no more.
        let width_m = if width_m <= self.strip_m { 0.0 } else { width_m + 2.0 * across_m };
        let (count, first_m) = self.across(width_m, most)?;
        let stretches = self.stretches();
        if count.saturating_mul(stretches.len()) > most {
            return Err(count.saturating_mul(stretches.len()));
        }
        let half_m = 0.5 * width_m.max(self.spacing_m);
        let pass = |index: usize| {
            let aside_m = first_m + index as f64 * self.spacing_m;
            let leg = |(number, stretch): (usize, &Vec<NorthEast>)| {
                let mut points = beside(stretch, aside_m);
                // Beyond a corner that is flown straight over, as far as the corner of the strip lies.
                let beyond = |other: Option<&Vec<NorthEast>>| {
                    other
                        .map_or(along_m, |other| along_m + half_m * (0.5 * turn_between(stretch, other)).tan().min(2.0))
                };
                let before = number.checked_sub(1).and_then(|before| stretches.get(before));
                lengthen(&mut points, beyond(before), beyond(stretches.get(number + 1)));
                Leg::whole(points)
            };
            stretches.iter().enumerate().map(leg).collect()
        };
        Ok((0..count).map(pass).collect())
    }

    /// The line cut at the corners that cannot be flown with the camera on.
    fn stretches(&self) -> Vec<Vec<NorthEast>> {
        let mut stretches = vec![vec![self.region.points[0]]];
        for (index, point) in self.region.points.iter().enumerate().skip(1) {
            if let Some(stretch) = stretches.last_mut() {
                stretch.push(*point);
            }
            let Some(next) = self.region.points.get(index + 1) else { break };
            let before = *point - self.region.points[index - 1];
            let onward = *next - *point;
            if crate::guidance::wrap_pi(onward.bearing_rad() - before.bearing_rad()).abs() > self.gentle_rad {
                stretches.push(vec![*point]);
            }
        }
        stretches
    }
}

/// Angle between the end of one stretch and the beginning of another that follows or goes before it, radians, 0 to π.
fn turn_between(one: &[NorthEast], other: &[NorthEast]) -> f64 {
    let (first, then) = if one.last() == other.first() { (one, other) } else { (other, one) };
    let out = (first[first.len() - 1] - first[first.len() - 2]).bearing_rad();
    crate::guidance::wrap_pi((then[1] - then[0]).bearing_rad() - out).abs()
}

/// A line beside another, m to its right; its corners lie where the sides beside meet.
fn beside(line: &[NorthEast], aside_m: f64) -> Vec<NorthEast> {
    let right = |index: usize| {
        let side = line[index + 1] - line[index];
        NorthEast::from_bearing(side.bearing_rad() + 0.25 * TAU)
    };
    let last = line.len() - 1;
    let place = |index: usize| {
        let (before, after) = (right(index.saturating_sub(1)), right(index.min(last - 1)));
        // Both are a right angle from their side: their sum leads to where the two lines meet. Gentle corners alone are here.
        let both = before + after;
        line[index] + both * (2.0 * aside_m / both.dot(both).max(0.5))
    };
    (0..=last).map(place).collect()
}

/// Moves the ends of a line outward.
fn lengthen(points: &mut [NorthEast], before_m: f64, after_m: f64) {
    let last = points.len() - 1;
    let first_side = points[1] - points[0];
    let last_side = points[last] - points[last - 1];
    points[0] = points[0] - first_side.unit_or(first_side) * before_m;
    points[last] = points[last] + last_side.unit_or(last_side) * after_m;
}

/// Passes in the order and the direction in which they are flown: every other one backwards, and from the end that lies best.
fn in_order(passes: Vec<Pass>, apart: usize, region: &Region, coming_from: Option<GeoPoint>, wind: Wind) -> Vec<Pass> {
    let order = race_track(passes.len(), apart);
    let flown = |is_from_right: bool, is_backwards: bool| {
        let last = passes.len().saturating_sub(1);
        let number = |index: &usize| if is_from_right { last - *index } else { *index };
        let turned = order.iter().map(number).enumerate().map(|(flown, index)| {
            let pass = passes[index].clone();
            if (flown % 2 == 1) == is_backwards { pass } else { pass.into_iter().rev().map(Leg::reversed).collect() }
        });
        turned.collect::<Vec<Pass>>()
    };
    let ways = [(false, true), (false, false), (true, true), (true, false)].map(|(right, back)| flown(right, back));
    let upwind = NorthEast::from_bearing(wind.from_deg.to_radians());
    let begins = |way: &Vec<Pass>| way.first().and_then(|pass| pass.first()).map(Leg::start).unwrap_or_default();
    let cost = |way: &Vec<Pass>| match coming_from {
        Some(from) => (region.plane.at(from) - begins(way)).length(),
        None if wind.speed_m_s >= CALM_M_S => begins(way).dot(upwind),
        None => 0.0,
    };
    let best = ways.iter().enumerate().min_by(|(_, one), (_, other)| cost(one).total_cmp(&cost(other)));
    best.map(|(index, _)| ways[index].clone()).unwrap_or_default()
}

/// A step of the mission.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// Flies to a place; how far before it the turn begins, m, where there is one.
    To(NorthEast, Option<f64>),
    /// Switches the camera on or off.
    Camera(bool),
}

struct Route {
    steps: Vec<Step>,
}

impl Route {
    fn along(passes: &[Pass], radius_m: f64, lead_in_m: f64, lead_out_m: f64) -> Self {
        let mut steps = Vec::new();
        let mut left: Option<Pose> = None;
        for leg in passes.iter().flatten() {
            let (course, last_course) = (leg.course_rad(), leg.last_course_rad());
            let ahead = NorthEast::from_bearing(course);
            let begins = Pose { at: leg.start() - ahead * lead_in_m, course_rad: course };
            match left {
                // From wherever it comes, it turns onto the line there.
                None => steps.push(Step::To(begins.at - ahead * radius_m, None)),
                Some(left) => {
                    steps.extend(
                        corners(left, begins, radius_m)
                            .iter()
                            .map(|corner| Step::To(corner.at, Some(corner.tangent_m))),
                    );
                }
            }
            let mut events: Vec<(f64, Option<bool>)> =
                leg.shots.iter().flat_map(|(from, to)| [(*from, Some(true)), (*to, Some(false))]).collect();
            let mut along_m = 0.0;
            for pair in leg.points.windows(2).take(leg.points.len() - 2) {
                along_m += (pair[1] - pair[0]).length();
                events.push((along_m, None));
            }
            events.sort_by(|one, other| one.0.total_cmp(&other.0));
            for (along_m, camera) in events {
                steps.push(Step::To(leg.at(along_m), None));
                steps.extend(camera.map(Step::Camera));
            }
            let onward = NorthEast::from_bearing(last_course);
            left = Some(Pose { at: leg.end() + onward * lead_out_m, course_rad: last_course });
        }
        if let Some(left) = left {
            // Straight ahead, so that the last waypoint with pictures counts abeam.
            steps.push(Step::To(left.at + NorthEast::from_bearing(left.course_rad) * radius_m, None));
        }
        Self { steps }
    }

    fn places(&self) -> impl Iterator<Item = NorthEast> + '_ {
        self.steps.iter().filter_map(|step| match step {
            Step::To(at, _) => Some(*at),
            Step::Camera(_) => None,
        })
    }

    /// The mission items, and what is photographed.
    fn items(
        &self,
        region: &Region,
        options: &SurveyOptions,
        above_home_m: f64,
        height_m: f64,
        trigger_m: Option<f64>,
        rolls_in_m: f64,
    ) -> (Vec<MissionItem>, Vec<SurveyLine>) {
        let mut items = Vec::with_capacity(self.steps.len() + 2);
        let mut lines: Vec<SurveyLine> = Vec::new();
        let mut is_on = false;
        if let Some(airspeed_m_s) = options.airspeed_m_s {
            items.push(MissionItem::change_airspeed(airspeed_m_s));
        }
        let (frame, alt_m) = if options.is_above_terrain {
            (MavFrame::GlobalTerrainAlt, height_m)
        } else {
            (MavFrame::GlobalRelativeAlt, above_home_m)
        };
        for step in &self.steps {
            match step {
                Step::To(at, tangent_m) => {
                    let point = region.plane.point(*at);
                    let mut item =
                        MissionItem { frame, ..MissionItem::waypoint(point.lat_deg(), point.lon_deg(), alt_m) };
                    // The bank takes its time to come; ArduPilot keeps whole metres.
                    let accepts_m =
                        tangent_m.map_or(0.0, |tangent_m| (tangent_m + rolls_in_m).round().clamp(1.0, MOST_ACCEPTED_M));
                    item.params[1] = Some(accepts_m);
                    if let Some(line) = lines.last_mut().filter(|_| is_on) {
                        line.points.push(point);
                        line.exit = items.len();
                    }
                    items.push(item);
                }
                Step::Camera(on) => {
                    is_on = *on;
                    if *on && let Some(entry) = items.len().checked_sub(1) {
                        lines.push(SurveyLine {
                            points: items[entry].point().into_iter().collect(),
                            entry,
                            exit: entry,
                        });
                    }
                    if let Some(trigger_m) = trigger_m {
                        let (distance_m, at_once) = if *on { (trigger_m, 1.0) } else { (0.0, 0.0) };
                        items
                            .push(MissionItem::action(Command::DO_SET_CAM_TRIGG_DIST, [distance_m, 0.0, at_once, 0.0]));
                    }
                }
            }
        }
        if options.airspeed_m_s.is_some() {
            // Back to the plane's own (ArduPlane's `do_change_speed`).
            items.push(MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, -2.0, -1.0, 0.0]));
        }
        (items, lines)
    }
}
