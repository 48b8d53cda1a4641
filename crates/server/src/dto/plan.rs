//! Plans: what they hold, what is found in them, how they lie on the map, and what is known of those on board.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::{Finding, FixKind};
use vencejo_flight::ending::MissionEnd;
use vencejo_flight::formats::ComplexItem;
use vencejo_flight::plan::{Change, Home, UnknownLevel};
use vencejo_flight::profile::Profile;
use vencejo_flight::way::{Jump, Stop};
use vencejo_vehicle::AltFrame;

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

/// One part of the plan on board, as far as it is known.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PlanOnBoard {
    /// How far that is.
    pub state: PlanState,
    /// That part of it as it was read from the vehicle, with nothing in the others; null while it is not known.
    #[schema(required = true)]
    pub plan: Option<Plan>,
}

/// How a plan differs from what a vehicle has on board, part by part; a part is null while it is not known what is there.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PlanComparison {
    /// The mission.
    #[schema(required = true)]
    pub mission: Option<PartComparison>,
    /// The fence: its items are the corners and circles in order, then the return point.
    #[schema(required = true)]
    pub fence: Option<PartComparison>,
    /// The rally points.
    #[schema(required = true)]
    pub rally: Option<PartComparison>,
}

/// How one part of a plan differs from the one on board.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PartComparison {
    /// What it was compared with: the fingerprint of `PlanState`; null for nothing on board.
    #[schema(required = true)]
    pub hash: Option<String>,
    /// From what is on board to the plan; empty when the vehicle, as it keeps items, has it as it is.
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

pub(super) fn yes() -> bool {
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
    /// Items of the mission that stand for several in a `.plan` file: kept so that it is written as it was read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub complex_items: Vec<ComplexItem>,
}

/// How to write a plan to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlanFormat {
    /// QGroundControl's JSON: mission, fence and rally.
    Plan,
    /// "QGC WPL 110": the mission alone.
    Waypoints,
    /// Google Earth's XML: everything.
    Kml,
    /// The same in a zip.
    Kmz,
    /// RFC 7946: everything.
    Geojson,
    /// The places of the mission as a route, heights above mean sea level.
    Gpx,
    /// A table with a row for each item: everything.
    Csv,
}

/// Items whose heights are to count from another level.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameChange {
    /// They, and home; without a home the vehicle's is taken. Nothing else of it is looked at.
    pub plan: Plan,
    /// What they are to count from.
    pub frame: AltFrame,
    /// The vehicle that is to fly them.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// Items whose heights count from another level.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CountedItems {
    /// They.
    pub items: Vec<PlanItem>,
    /// Those that are not at the same height in space: they keep their number, since a level is not known.
    pub unconverted: Vec<Unconverted>,
}

/// An item whose height could not be converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Unconverted {
    /// It, counted from 1.
    pub item: usize,
    /// What is not known.
    pub level: UnknownLevel,
}

/// A plan to look over.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanCheck {
    /// The plan.
    pub plan: Plan,
    /// The vehicle that is to fly it: its kind, its place and whether it is on the ground are taken into account.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// A plan to lay out.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WayRequest {
    /// The plan.
    pub plan: Plan,
    /// The vehicle that is to fly it; an ArduPlane as it comes when absent.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Height above the ground that should be kept, 0 to 1000; 30 by default.
    #[serde(default)]
    pub clearance_m: Option<f64>,
}

/// A mission as it is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Way {
    /// The items that the vehicle flies to, in the order of the plan.
    pub stops: Vec<Stop>,
    /// The jumps between them.
    pub jumps: Vec<Jump>,
    /// How it ends.
    pub end: MissionEnd,
    /// Its heights along that way, and the ground below, as far as that is at hand.
    pub profile: Profile,
    /// Whether more of the ground is being looked up: ask again in a moment.
    pub is_ground_pending: bool,
}

/// A finding, and a change that resolves it: with `items` in the place of others it is gone, and no error is there that was not.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct FindingFix {
    /// The finding.
    pub finding: Finding,
    /// What is changed, in English.
    pub message: String,
    /// What is changed.
    #[serde(flatten)]
    pub kind: FixKind,
    /// The first item that is replaced, counted from 1; one more than there are: what is added stands at the end.
    pub first_item: usize,
    /// How many are replaced; 0: what is added stands before `first_item`.
    pub count: usize,
    /// What stands there then. Jumps to items behind lead there still, and are to be numbered anew.
    pub items: Vec<PlanItem>,
}
