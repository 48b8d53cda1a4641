//! Plans: what they hold, and what is known of those on board.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::Finding;
use vencejo_flight::progress::Trip;

/// Which plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanKind {
    /// What to fly.
    Mission,
    /// Where to stay.
    Fence,
    /// Where to return to when home is farther.
    Rally,
}

/// How sure we are of a plan on board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanCertainty {
    /// It may be anything.
    Unknown,
    /// There is none.
    Empty,
    /// Read back from the vehicle.
    Verified,
}

/// Why a plan on board is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanUncertainty {
    /// It was never read.
    NeverRead,
    /// A transfer runs.
    Transferring,
    /// A transfer failed or was given up half-way.
    TransferFailed,
    /// The vehicle restarted.
    Rebooted,
    /// Another station changed it.
    ChangedElsewhere,
    /// Another station is sending one, or was not seen to end it; it may be a mixture.
    SentElsewhere,
    /// What was written down of it cannot be read, and may have said that it is a mixture.
    RecordDamaged,
    /// It was read, and is no mission that is known to be whole: neither what was sent last nor what was there before.
    Mixed,
}

/// What is known of a plan on board.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlanState {
    /// How sure we are.
    pub state: PlanCertainty,
    /// Items, home not counted.
    #[schema(required = true)]
    pub count: Option<u16>,
    /// Fingerprint of the items as the vehicle holds them.
    #[schema(required = true)]
    pub hash: Option<String>,
    /// Why it is not known; absent when it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub reason: Option<PlanUncertainty>,
    /// Whether it may be a mixture of two: then the vehicle is not armed, and its mission neither started nor jumped in, unless
    /// that is asked for despite it (`despite_mixed_plan`).
    pub may_be_mixed: bool,
    /// All that in English words.
    pub detail: String,
}

/// What is known of the plans on board.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlanStates {
    /// The mission.
    pub mission: PlanState,
    /// The fence.
    pub fence: PlanState,
    /// The rally points.
    pub rally: PlanState,
}

/// What the core says of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Assessment {
    /// What is wrong or doubtful in it.
    pub findings: Vec<Finding>,
    /// Its mission as it is flown.
    pub trip: Trip,
}

/// One part of the plan on board, as far as it is known.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PlanOnBoard {
    /// How far that is.
    pub state: PlanState,
    /// That part of it as it was read from the vehicle, with nothing in the others; null while it is not known.
    #[schema(required = true)]
    pub plan: Option<Plan>,
}

/// A position on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LatLon {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
}

/// A place with its height above mean sea level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Home {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height above mean sea level.
    pub alt_amsl_m: f64,
}

/// One item of a mission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanItem {
    /// `MAV_CMD` number.
    pub command: u16,
    /// Its name without `MAV_CMD_`. Ignored in a request.
    #[serde(default)]
    #[schema(required = true)]
    pub name: String,
    /// `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain, 2 no position.
    pub frame: u8,
    /// Parameters 1 to 4, then latitude, longitude and height of a command that has a position; null where unset.
    #[schema(value_type = Vec<Option<f64>>, min_items = 7, max_items = 7)]
    pub params: [Option<f64>; 7],
    /// Whether the mission goes on by itself after it.
    #[serde(default = "yes")]
    #[schema(required = true)]
    pub autocontinue: bool,
}

fn yes() -> bool {
    true
}

/// Shape of a fence zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ZoneShape {
    /// Three or more corners in order.
    Polygon,
    /// One point and a radius.
    Circle,
}

/// One zone of a fence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FenceZone {
    /// `true`: stay inside; `false`: stay outside.
    pub inclusion: bool,
    /// Its shape.
    pub shape: ZoneShape,
    /// Corners of a polygon, or the centre of a circle.
    pub points: Vec<LatLon>,
    /// Radius of a circle; null for a polygon.
    #[serde(default)]
    #[schema(required = true)]
    pub radius_m: Option<f64>,
}

/// Where to return to after a breach of the fence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReturnPoint {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height above home.
    pub alt_rel_home_m: f64,
}

/// A geofence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Fence {
    /// Zones, all of which apply.
    pub zones: Vec<FenceZone>,
    /// Where to return to after a breach.
    #[serde(default)]
    #[schema(required = true)]
    pub return_point: Option<ReturnPoint>,
}

/// A place to return to instead of home.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RallyPoint {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height, counted as `frame` says.
    pub alt_m: f64,
    /// `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain.
    pub frame: u8,
}

/// A plan: mission, fence and rally points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// What to do, in order, without home.
    #[serde(default)]
    #[schema(required = true)]
    pub items: Vec<PlanItem>,
    /// Planned home; the vehicle sets its own when it arms.
    #[serde(default)]
    #[schema(required = true)]
    pub home: Option<Home>,
    /// Where to stay.
    #[serde(default)]
    #[schema(required = true)]
    pub fence: Fence,
    /// Where to return to when home is farther.
    #[serde(default)]
    #[schema(required = true)]
    pub rally: Vec<RallyPoint>,
}

/// How to write a plan to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanFormat {
    /// QGroundControl's JSON: mission, fence and rally.
    Plan,
    /// "QGC WPL 110": the mission alone.
    Waypoints,
}

/// What a landing is designed from. What is not given is that of a small plane on an ArduPlane.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingRequest {
    /// Where to touch down.
    pub at: LatLon,
    /// Course of the final leg from true north, where the runway has one; else `coming_from` gives it, else the wind.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Where the plane comes from; nearer than 20 m it gives no direction.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// Below 1 m/s it gives no direction.
    #[serde(default)]
    pub wind: Option<LandingWind>,
    /// Height of the ground at the point above home, −1000 to 1000; home's is taken when it is not known.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Of the approach, 5 to 60; 22 by default.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Steepest slope of the final leg, height over distance, 0.02 to 0.25; 0.08 by default.
    #[serde(default)]
    pub slope: Option<f64>,
    /// Height above the ground where the final leg begins, 15 to 200; 40 by default.
    #[serde(default)]
    pub final_height_m: Option<f64>,
    /// Smallest radius of the circle, 20 to 500; 80 by default.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Whether the circle is flown clockwise, to the right of the final leg; so by default.
    #[serde(default = "yes")]
    pub is_clockwise: bool,
    /// Whether `DO_LAND_START` goes before it; so by default. An ArduPlane with `RTL_AUTOLAND` 0 does not arm with one.
    #[serde(default = "yes")]
    pub has_land_start: bool,
}

/// Wind over a landing.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingWind {
    /// Where it comes from, from true north.
    pub from_deg: f64,
    /// Its speed, 0 to 60.
    pub speed_m_s: f64,
}

/// A landing, ready to be the end of a mission.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Landing {
    /// `DO_LAND_START` where asked for, `NAV_LOITER_TO_ALT`, `NAV_LAND`; heights above home.
    pub items: Vec<PlanItem>,
    /// Course of the final leg at the point from true north, 0 to 360.
    pub course_deg: f64,
    /// What gave it.
    pub direction: LandingDirection,
    /// Where the final leg begins.
    pub leaves: LatLon,
    /// Height there.
    pub leaves_alt_rel_home_m: f64,
    /// Length of the final leg.
    pub final_m: f64,
    /// Its slope, height over distance.
    pub slope: f64,
    /// Radius of the circle.
    pub radius_m: f64,
    /// Part of the wind against the plane on the final leg, negative from behind; null when no wind is known.
    #[schema(required = true)]
    pub headwind_m_s: Option<f64>,
    /// Speed over ground on the final leg; null when no wind is known.
    #[schema(required = true)]
    pub groundspeed_m_s: Option<f64>,
    /// What the pilot should know.
    pub cautions: Vec<LandingCaution>,
}

/// What gave a final leg its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LandingDirection {
    /// The course that was asked for.
    Course,
    /// The place that the plane comes from.
    ComingFrom,
    /// The wind, against which it lands.
    IntoWind,
}

/// What the pilot should know of a landing before it is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingCaution {
    /// `ground-not-known`, `steep-approach` or `tailwind`.
    pub code: String,
    /// It in English.
    pub message: String,
}

/// A plan to look over.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanCheck {
    /// The plan.
    pub plan: Plan,
    /// The vehicle that is to fly it: its kind, its place and whether it is on the ground are taken into account.
    #[serde(default)]
    pub vehicle: Option<u8>,
}
