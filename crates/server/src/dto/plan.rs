//! Plans: their contents, findings, route on the map, and state on board.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::{Finding, FixKind};
use vencejo_flight::ending::MissionEnd;
use vencejo_flight::formats::{ComplexItem, PlannedFor};
use vencejo_flight::plan::{Change, Home, UnknownLevel};
use vencejo_flight::profile::Profile;
use vencejo_flight::way::{Jump, Stop};
use vencejo_vehicle::AltFrame;

/// Part of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanKind {
    /// Items to fly.
    Mission,
    /// Geofence.
    Fence,
    /// Rally points: where to return to when home is farther.
    Rally,
}

/// Certainty about a plan on board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanCertainty {
    /// Unknown.
    Unknown,
    /// Empty.
    Empty,
    /// Read back from the vehicle.
    Verified,
}

/// Why a plan on board is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanUncertainty {
    /// It was never read.
    NeverRead,
    /// A transfer is in progress.
    Transferring,
    /// A transfer failed or was cancelled half-way.
    TransferFailed,
    /// The vehicle rebooted.
    Rebooted,
    /// Another station changed it.
    ChangedElsewhere,
    /// Another station is uploading one, or the end of its upload was not observed; the plan may be a mixture of two.
    SentElsewhere,
    /// The stored record of it is unreadable, and may have marked it as a mixture.
    RecordDamaged,
    /// It was read, but matches neither the last uploaded mission nor the one before, so it may not be whole.
    Mixed,
}

/// State of a plan on board.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlanState {
    /// Certainty about the plan.
    pub state: PlanCertainty,
    /// Number of items, without home; null when unknown.
    #[schema(required = true)]
    pub count: Option<u16>,
    /// Fingerprint of the items as the vehicle stores them; null when unknown.
    #[schema(required = true)]
    pub hash: Option<String>,
    /// Why it is unknown; absent when it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub reason: Option<PlanUncertainty>,
    /// Whether it may be a mixture of two plans. If so, the vehicle is not armed, and its mission is neither started
    /// nor set to another item, unless the request says `despite_mixed_plan`.
    pub may_be_mixed: bool,
    /// Description in English.
    pub detail: String,
}

/// States of the plans on board.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PlanStates {
    /// The mission.
    pub mission: PlanState,
    /// The fence.
    pub fence: PlanState,
    /// The rally points.
    pub rally: PlanState,
}

/// One part of the plan on board, as far as it is known.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PlanOnBoard {
    /// State of that part.
    pub state: PlanState,
    /// That part as read from the vehicle, with the other parts empty; null while it is unknown.
    #[schema(required = true)]
    pub plan: Option<Plan>,
}

/// Differences between a plan and the one on board, by part; a part is null while its state on board is unknown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PlanComparison {
    /// The mission.
    #[schema(required = true)]
    pub mission: Option<PartComparison>,
    /// The fence; its items are the corners and circles in order, then the return point.
    #[schema(required = true)]
    pub fence: Option<PartComparison>,
    /// The rally points.
    #[schema(required = true)]
    pub rally: Option<PartComparison>,
}

/// Differences in one part of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PartComparison {
    /// Fingerprint (as in `PlanState`) of the part on board that was compared; null when there is none on board.
    #[schema(required = true)]
    pub hash: Option<String>,
    /// Changes from the plan on board to this plan; empty when the vehicle, with its storage precision, already has it.
    pub changes: Vec<Change>,
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

/// One item of a mission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanItem {
    /// `MAV_CMD` number.
    pub command: u16,
    /// Name of the command without `MAV_CMD_`. Ignored in requests.
    #[serde(default)]
    #[schema(required = true)]
    pub name: String,
    /// `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain, 2 no position.
    pub frame: u8,
    /// Parameters 1 to 4, then latitude, longitude and altitude of a command with a position; null where unset.
    #[schema(value_type = Vec<Option<f64>>, min_items = 7, max_items = 7)]
    pub params: [Option<f64>; 7],
    /// Whether the mission continues with the next item by itself.
    #[serde(default = "yes")]
    #[schema(required = true)]
    pub autocontinue: bool,
}

pub(super) fn yes() -> bool {
    true
}

/// Shape of a fence zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ZoneShape {
    /// Three or more corners in order.
    Polygon,
    /// Centre and radius.
    Circle,
}

/// One zone of a fence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FenceZone {
    /// True: the vehicle must stay inside; false: it must stay outside.
    pub inclusion: bool,
    /// Shape of the zone.
    pub shape: ZoneShape,
    /// Corners of a polygon, or the centre of a circle.
    pub points: Vec<LatLon>,
    /// Radius of a circle; null for a polygon.
    #[serde(default)]
    #[schema(required = true)]
    pub radius_m: Option<f64>,
}

/// Position to return to after a breach of the fence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReturnPoint {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Altitude above home.
    pub alt_rel_home_m: f64,
}

/// A geofence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Fence {
    /// Zones. All of them apply, unless the vehicle takes the union of its inclusion zones (`FENCE_OPTIONS`, bit 1).
    pub zones: Vec<FenceZone>,
    /// Position to return to after a breach; null when there is none.
    #[serde(default)]
    #[schema(required = true)]
    pub return_point: Option<ReturnPoint>,
}

/// Rally point: a position to return to instead of home.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RallyPoint {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Altitude, in `frame`.
    pub alt_m: f64,
    /// `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain.
    pub frame: u8,
}

/// A plan: mission, fence and rally points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Mission items in order, without home.
    #[serde(default)]
    #[schema(required = true)]
    pub items: Vec<PlanItem>,
    /// Planned home; the vehicle sets its own on arming.
    #[serde(default)]
    #[schema(required = true)]
    pub home: Option<Home>,
    /// Geofence.
    #[serde(default)]
    #[schema(required = true)]
    pub fence: Fence,
    /// Rally points: where to return to when home is farther.
    #[serde(default)]
    #[schema(required = true)]
    pub rally: Vec<RallyPoint>,
    /// Groups of mission items that a `.plan` file stores as one complex item, kept so that the file can be written
    /// unchanged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub complex_items: Vec<ComplexItem>,
    /// Vehicle that a `.plan` file was planned for, kept so that the file is written for the same one; null for a fixed-wing
    /// ArduPilot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planned_for: Option<PlannedFor>,
}

/// File format of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanFormat {
    /// QGroundControl's JSON: mission, fence and rally.
    Plan,
    /// "QGC WPL 110": the mission alone.
    Waypoints,
    /// Google Earth's KML: everything.
    Kml,
    /// KML in a zip archive: everything.
    Kmz,
    /// GeoJSON (RFC 7946): everything.
    Geojson,
    /// Positions of the mission as a GPX route, with altitudes above mean sea level.
    Gpx,
    /// A table with one row per item: everything.
    Csv,
}

/// Items whose altitudes are to be converted to another frame.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameChange {
    /// The items, and their home; when it has none, the vehicle's home is used. The rest of the plan is ignored.
    pub plan: Plan,
    /// New frame.
    pub frame: AltFrame,
    /// Vehicle that is to fly them.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// Items with converted altitudes.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CountedItems {
    /// The items.
    pub items: Vec<PlanItem>,
    /// Items that were not converted: their altitude value is unchanged, since a reference level is unknown.
    pub unconverted: Vec<Unconverted>,
}

/// An item whose altitude could not be converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Unconverted {
    /// Number of the item, counted from 1.
    pub item: usize,
    /// The unknown reference level.
    pub level: UnknownLevel,
}

/// A plan to check.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanCheck {
    /// The plan.
    pub plan: Plan,
    /// Vehicle that is to fly it. Its type, its position and whether it is on the ground are considered.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// A plan whose route is wanted.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WayRequest {
    /// The plan.
    pub plan: Plan,
    /// Vehicle that is to fly it; a default ArduPlane when absent.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Clearance to keep above the ground, 0 to 1000; 30 by default.
    #[serde(default)]
    pub clearance_m: Option<f64>,
}

/// Route of a mission, as drawn on the map.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Way {
    /// Items that the vehicle flies to, in order.
    pub stops: Vec<Stop>,
    /// Jumps between them.
    pub jumps: Vec<Jump>,
    /// How the mission ends.
    pub end: MissionEnd,
    /// Altitude profile along the route, with the terrain below as far as it is loaded.
    pub profile: Profile,
    /// Whether more terrain is still being loaded: repeat the request a moment later.
    pub is_ground_pending: bool,
}

/// A finding and a change that resolves it. With `items` in place of the replaced ones, the finding disappears and no
/// new error appears.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct FindingFix {
    /// The finding.
    pub finding: Finding,
    /// Description of the change, in English.
    pub message: String,
    /// Kind of the change.
    #[serde(flatten)]
    pub kind: FixKind,
    /// First replaced item, counted from 1; one past the last item when the new items are appended.
    pub first_item: usize,
    /// Number of replaced items; 0 when the new items are inserted before `first_item`.
    pub count: usize,
    /// New items. The plan's jumps to items after the replaced ones keep their destinations, so their numbers must be
    /// adapted.
    pub items: Vec<PlanItem>,
}
