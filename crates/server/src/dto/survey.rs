//! Surveys: what is asked for, what is laid out, and what its pictures show.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::Finding;
use vencejo_flight::formats::ComplexItem;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::Home;
use vencejo_flight::survey::{Camera, LineCourse};

use super::plan::{LatLon, PlanItem};

/// A camera by name.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct NamedCamera {
    /// The name that QGroundControl has for it, where it has one.
    pub name: String,
    /// What it is.
    pub camera: Camera,
}

/// What a survey is laid out from. Either `gsd_m` or `height_m` is given, and a camera; or without one `height_m` and `spacing_m`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SurveyRequest {
    /// Corners of the area in order, 3 to 1,000, or points of the line of a corridor, 2 to 1,000.
    pub places: Vec<LatLon>,
    /// Width of a corridor, 0 to 5,000 (0: one pass); absent or null: an area.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// The camera.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Whether the wide side of the picture lies across the track; so by default.
    #[serde(default = "super::plan::yes")]
    pub is_landscape: bool,
    /// Ground that a pixel is to cover, 0.0005 to 10.
    #[serde(default)]
    pub gsd_m: Option<f64>,
    /// Height above the ground, 5 to 10,000.
    #[serde(default)]
    pub height_m: Option<f64>,
    /// Part of a picture that the next on the line shows too, 0 to 0.95; 0.75 by default.
    #[serde(default)]
    pub front_overlap: Option<f64>,
    /// Part of a picture that those of the next line show too, 0 to 0.95; 0.65 by default.
    #[serde(default)]
    pub side_overlap: Option<f64>,
    /// Distance between lines, in place of the one that the overlap gives.
    #[serde(default)]
    pub spacing_m: Option<f64>,
    /// Distance between pictures, in place of the one that the overlap gives.
    #[serde(default)]
    pub trigger_m: Option<f64>,
    /// Course of the lines of an area from true north; across the wind by default, in calm air along the area.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Wind that is expected.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// How far beyond the edge pictures reach; by default so far that the overlap holds up to the edge.
    #[serde(default)]
    pub margin_m: Option<f64>,
    /// Straight way before a line; by default until the plane is settled on it.
    #[serde(default)]
    pub lead_in_m: Option<f64>,
    /// Whether heights count from the ground below, which the vehicle has to know, and not from home.
    #[serde(default)]
    pub is_above_terrain: bool,
    /// Height of the ground above home; home's is taken when it is not known.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Airspeed, set by an item, 5 to 60; the plane's cruise by default.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Where heights count from; the vehicle's home by default.
    #[serde(default)]
    pub home: Option<Home>,
    /// The survey begins at the end that is nearest; downwind by default, and goes on against the wind.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// The vehicle that is to fly it, which has parameters of its own; an ArduPlane as it comes by default.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// Where the items of a complex item are in the mission of its plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ComplexPart {
    /// `survey`, `CorridorScan`, `fwLandingPattern`, `StructureScan`….
    pub kind: String,
    /// The first, counted from 1; null when they are no longer there as it made them: they were edited, and are items like others.
    #[schema(required = true)]
    pub first_item: Option<usize>,
    /// How many items it made.
    pub count: usize,
    /// What a survey or corridor was laid out from, to be laid out again with changes; null for what is none.
    #[schema(required = true)]
    pub survey: Option<SurveyRequest>,
}

/// A survey, ready to be placed in a mission, and rehearsed.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Survey {
    /// Waypoints and camera; the first waypoint leads to the first line, the last one away from the last.
    pub items: Vec<PlanItem>,
    /// What is photographed without a stop, in the order flown.
    pub lines: Vec<Vec<LatLon>>,
    /// Where it can begin in place of where it does, at the next of its corners: as `coming_from` of another request it begins there.
    #[schema(required = true)]
    pub next_entry: Option<LatLon>,
    /// Course of the first line from true north.
    pub course_deg: f64,
    /// What gave it.
    pub course_from: LineCourse,
    /// Height above the ground.
    pub height_m: f64,
    /// Ground that a pixel covers; null without a camera.
    #[schema(required = true)]
    pub gsd_m: Option<f64>,
    /// Ground that a picture shows across the track; null without a camera.
    #[schema(required = true)]
    pub footprint_across_m: Option<f64>,
    /// Ground that a picture shows along the track; null without a camera.
    #[schema(required = true)]
    pub footprint_along_m: Option<f64>,
    /// Distance between two lines.
    pub spacing_m: f64,
    /// Distance between two pictures; null when the camera is not triggered.
    #[schema(required = true)]
    pub trigger_m: Option<f64>,
    /// Radius of the turns.
    pub turn_radius_m: f64,
    /// Straight way before the first picture of a line.
    pub lead_in_m: f64,
    /// Straight way after the last.
    pub lead_out_m: f64,
    /// Slowest speed over ground on the lines.
    pub groundspeed_min_m_s: f64,
    /// Fastest speed over ground on the lines.
    pub groundspeed_max_m_s: f64,
    /// Angle between heading and course on the lines, at the most.
    pub crab_deg: f64,
    /// Size of the area, or of the strip.
    pub area_m2: f64,
    /// Length of all that is photographed.
    pub line_m: f64,
    /// Length of the whole way.
    pub length_m: f64,
    /// Time for it in this wind.
    pub duration_s: f64,
    /// Pictures.
    pub photos: u64,
    /// What the pilot should know.
    pub cautions: Vec<SurveyCaution>,
    /// It as QGroundControl's own survey or corridor, to go with its items in `complex_items` of a plan.
    pub complex_item: ComplexItem,
    /// It, rehearsed.
    pub flown: FlownSurvey,
}

/// What the pilot should know of a survey before it is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SurveyCaution {
    /// `ground-not-known`, `camera-too-slow`, `along-wind`, `tight-turns` or `gaps`.
    pub code: String,
    /// It in English.
    pub message: String,
}

/// What the pictures of a survey show when it is flown as rehearsed.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct FlownSurvey {
    /// Whether the plane's own parameters were known, or those of an ArduPlane as it comes were taken.
    pub knows_parameters: bool,
    /// Where the plane is when it takes each picture.
    pub photos: Vec<LatLon>,
    /// Corners of the ground that each shows, in order around it; null for one that looks beyond the horizon, and without a camera.
    pub footprints: Vec<Option<Vec<LatLon>>>,
    /// Part of the area that one picture or more show, 0 to 1; null without a camera.
    #[schema(required = true)]
    pub covered: Option<f64>,
    /// Part of the area that as many pictures show as the overlap promises, 0 to 1; null without a camera.
    #[schema(required = true)]
    pub overlapped: Option<f64>,
    /// How many that is.
    pub views_promised: u64,
    /// The largest places that no picture shows, at most 20.
    pub holes: Vec<SurveyHole>,
    /// The lines, as `lines`.
    pub lines: Vec<FlownLine>,
    /// Time for it.
    pub duration_s: f64,
    /// What is wrong or doubtful.
    pub findings: Vec<Finding>,
}

/// Ground that no picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct SurveyHole {
    /// Its middle.
    pub at: LatLon,
    /// Its size.
    pub area_m2: f64,
}

/// A line as it was flown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct FlownLine {
    /// Farthest from the line while pictures are taken; null when it is not flown.
    #[schema(required = true)]
    pub off_m: Option<f64>,
    /// Pictures on it.
    pub photos: u64,
    /// Whether it is not flown, or so far aside that nothing is left of the overlap with the next.
    pub is_missed: bool,
}
