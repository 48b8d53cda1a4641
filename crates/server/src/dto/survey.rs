//! Surveys: design request, layout, and coverage by their images.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::Finding;
use vencejo_flight::formats::ComplexItem;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::Home;
use vencejo_flight::survey::{Camera, LineCourse};

use super::plan::{LatLon, PlanItem};

/// A named camera model.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct NamedCamera {
    /// Name, as QGroundControl has it where it knows the camera.
    pub name: String,
    /// Camera data.
    pub camera: Camera,
}

/// Design request for a survey. It needs a camera and either `gsd_m` or `height_m`; or, without a camera, `height_m`
/// and `spacing_m`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SurveyRequest {
    /// Corners of the area in order, 3 to 1,000; or points of the line of a corridor, 2 to 1,000.
    pub places: Vec<LatLon>,
    /// Width of a corridor, 0 to 5,000 (0: a single pass); absent or null for an area.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// The camera.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// Whether the wide side of the image is across the track; true by default.
    #[serde(default = "super::plan::yes")]
    pub is_landscape: bool,
    /// Ground sample distance, 0.0005 to 10.
    #[serde(default)]
    pub gsd_m: Option<f64>,
    /// Height above the ground, 5 to 10,000.
    #[serde(default)]
    pub height_m: Option<f64>,
    /// Overlap with the next image on the line, 0 to 0.95; 0.75 by default.
    #[serde(default)]
    pub front_overlap: Option<f64>,
    /// Overlap with the images of the next line, 0 to 0.95; 0.65 by default.
    #[serde(default)]
    pub side_overlap: Option<f64>,
    /// Distance between lines, in place of the one derived from the overlap.
    #[serde(default)]
    pub spacing_m: Option<f64>,
    /// Distance between images, in place of the one derived from the overlap.
    #[serde(default)]
    pub trigger_m: Option<f64>,
    /// Course of an area's lines, from true north; by default across the wind, or along the area in calm air.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Expected wind.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Distance by which images extend beyond the edge; by default as much as keeps the overlap up to the edge.
    #[serde(default)]
    pub margin_m: Option<f64>,
    /// Straight distance before a line; by default as much as the plane needs to settle on it.
    #[serde(default)]
    pub lead_in_m: Option<f64>,
    /// Whether altitudes are relative to the terrain, which must be known to the vehicle, and not to home.
    #[serde(default)]
    pub is_above_terrain: bool,
    /// Ground elevation above home; 0 when unknown.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Airspeed, set by a mission item, 5 to 60; the plane's cruise airspeed by default.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Reference of the altitudes; the vehicle's home by default.
    #[serde(default)]
    pub home: Option<Home>,
    /// Position near which the survey begins, at the nearest of its corners; by default it begins downwind and proceeds
    /// upwind.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// Vehicle that is to fly it, whose parameters are used; a default ArduPlane when absent.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// Position of a complex item's items in the mission of its plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ComplexPart {
    /// `survey`, `CorridorScan`, `fwLandingPattern`, `StructureScan`….
    pub kind: String,
    /// First item, counted from 1; null when its items were edited and are now ordinary items.
    #[schema(required = true)]
    pub first_item: Option<usize>,
    /// Number of items that it generated.
    pub count: usize,
    /// Design request of a survey or corridor, to be changed and repeated; null for other kinds.
    #[schema(required = true)]
    pub survey: Option<SurveyRequest>,
}

/// A survey, ready to be inserted in a mission, with its rehearsal.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Survey {
    /// Waypoints and camera commands; the first waypoint leads to the first line, the last one away from the last line.
    pub items: Vec<PlanItem>,
    /// Lines photographed without interruption, in the order flown.
    pub lines: Vec<Vec<LatLon>>,
    /// Next corner at which it can begin instead; as `coming_from` of another request, it makes the survey begin there.
    #[schema(required = true)]
    pub next_entry: Option<LatLon>,
    /// Course of the first line, from true north.
    pub course_deg: f64,
    /// What determined the course.
    pub course_from: LineCourse,
    /// Height above the ground.
    pub height_m: f64,
    /// Ground sample distance; null without a camera.
    #[schema(required = true)]
    pub gsd_m: Option<f64>,
    /// Width of an image on the ground across the track; null without a camera.
    #[schema(required = true)]
    pub footprint_across_m: Option<f64>,
    /// Length of an image on the ground along the track; null without a camera.
    #[schema(required = true)]
    pub footprint_along_m: Option<f64>,
    /// Distance between lines.
    pub spacing_m: f64,
    /// Distance between images; null when the camera is not triggered.
    #[schema(required = true)]
    pub trigger_m: Option<f64>,
    /// Radius of the turns.
    pub turn_radius_m: f64,
    /// Straight distance before the first image of a line.
    pub lead_in_m: f64,
    /// Straight distance after the last image of a line.
    pub lead_out_m: f64,
    /// Lowest ground speed on the lines.
    pub groundspeed_min_m_s: f64,
    /// Highest ground speed on the lines.
    pub groundspeed_max_m_s: f64,
    /// Largest crab angle on the lines (between heading and course).
    pub crab_deg: f64,
    /// Size of the area or corridor.
    pub area_m2: f64,
    /// Total length photographed.
    pub line_m: f64,
    /// Total length flown.
    pub length_m: f64,
    /// Duration in this wind.
    pub duration_s: f64,
    /// Number of images.
    pub photos: u64,
    /// Cautions for the pilot.
    pub cautions: Vec<SurveyCaution>,
    /// The survey as a complex item of QGroundControl, to be put in the plan's `complex_items` along with its items.
    pub complex_item: ComplexItem,
    /// Its rehearsal.
    pub flown: FlownSurvey,
}

/// A caution for the pilot before a survey is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SurveyCaution {
    /// `ground-not-known`, `camera-too-slow`, `along-wind`, `tight-turns` or `gaps`.
    pub code: String,
    /// The caution in English.
    pub message: String,
}

/// Coverage by the images of a survey flown as rehearsed.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct FlownSurvey {
    /// Whether the plane's own parameters were known; otherwise a default ArduPlane is assumed.
    pub knows_parameters: bool,
    /// Position of the plane at each image.
    pub photos: Vec<LatLon>,
    /// Ground corners of each image, in order around it; null for an image that includes the horizon, and without a
    /// camera.
    pub footprints: Vec<Option<Vec<LatLon>>>,
    /// Fraction of the area that at least one image covers, 0 to 1; null without a camera.
    #[schema(required = true)]
    pub covered: Option<f64>,
    /// Fraction of the area covered by as many images as the overlap promises, 0 to 1; null without a camera.
    #[schema(required = true)]
    pub overlapped: Option<f64>,
    /// That number of images.
    pub views_promised: u64,
    /// Largest uncovered places, at most 20.
    pub holes: Vec<SurveyHole>,
    /// Lines as flown, in the order of `lines`.
    pub lines: Vec<FlownLine>,
    /// Duration.
    pub duration_s: f64,
    /// Errors and doubts found.
    pub findings: Vec<Finding>,
}

/// An uncovered place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct SurveyHole {
    /// Its centre.
    pub at: LatLon,
    /// Its size.
    pub area_m2: f64,
}

/// A survey line as flown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct FlownLine {
    /// Largest distance from the line while images are taken; null when it is not flown.
    #[schema(required = true)]
    pub off_m: Option<f64>,
    /// Number of images on it.
    pub photos: u64,
    /// Whether it is not flown, or so far off that no overlap with the next line remains.
    pub is_missed: bool,
}
