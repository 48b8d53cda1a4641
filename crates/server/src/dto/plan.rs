//! Plans: what they hold, and what is known of those on board.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::approaches::{LandingPart, LandingReason, Verdict};
use vencejo_flight::checks::{Finding, FixKind};
use vencejo_flight::ending::MissionEnd;
use vencejo_flight::formats::ComplexItem;
use vencejo_flight::landing::{LandingDirection, Wind};
use vencejo_flight::plan::{Change, Home, UnknownLevel};
use vencejo_flight::profile::{Clearance, Profile};
use vencejo_flight::progress::Trip;
use vencejo_flight::rehearsal::{
    Airframe, BatteryLack, BatterySettings, Doubts, Ending, Origin, Range, Reaction, Trigger,
};
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

/// What the core says of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Assessment {
    /// What is wrong or doubtful in it.
    pub findings: Vec<Finding>,
    /// Its mission as it is flown.
    pub trip: Trip,
    /// The plane's way through it; null where it was not asked for, or no home is known.
    #[schema(required = true)]
    pub rehearsal: Option<Rehearsal>,
}

/// A plan as the plane would fly it in a wind.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Rehearsal {
    /// What is taken for the plane.
    pub airframe: Origin,
    /// Whether the vehicle's own parameters were read; without, it is an ArduPlane as it comes.
    pub knows_parameters: bool,
    /// The wind of it.
    pub wind: Wind,
    /// What it shows to be wrong or doubtful; in an assessment these are among the plan's findings too.
    pub findings: Vec<Finding>,
    /// The track, as many moments as it takes to draw it within a metre.
    pub track: RehearsedTrack,
    /// Where each moment of the track stands in the height profile of the plan (`plan_way`), metres: each item is where it is there. After a jump it
    /// goes back.
    pub along_m: Vec<f64>,
    /// Where it is nearest to the ground, in that profile; take-off, landing and the climb out apart. Null where the ground is nowhere known.
    #[schema(required = true)]
    pub lowest: Option<Clearance>,
    /// The items in the order flown; jumps repeat them.
    pub passages: Vec<RehearsedPassage>,
    /// How it ends.
    pub ending: Ending,
    /// Where the ground is touched; null where it is not.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// Until its end, seconds.
    pub duration_s: f64,
    /// Way over ground, metres.
    pub distance_m: f64,
    /// Electrical energy; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// What is left of the battery; null where that cannot be told.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
    /// What is not known, so that it cannot; else null.
    #[schema(required = true)]
    pub battery_unknown: Option<BatteryLack>,
    /// Whether ground below the plan is still being looked up that this was flown without: ask again a moment later.
    pub is_ground_pending: bool,
}

/// What a flight leaves of a battery.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct BatteryLeft {
    /// Energy of a full one.
    pub capacity_wh: f64,
    /// Left at the end, of its capacity; below 0 as much more is wanted than it holds.
    pub left_pct: f64,
    /// What should be left, likewise.
    pub reserve_pct: f64,
    /// When it is empty, seconds since the rehearsed flight's beginning; null: it is not.
    #[schema(required = true)]
    pub empty_s: Option<f64>,
}

/// The airframe and the battery that a plan is rehearsed with in place of the vehicle's.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneProfile {
    /// As `POST /plan/learn` and `GET /vehicles/{id}/profile` tell it.
    #[serde(default)]
    pub airframe: Option<Airframe>,
    /// What is said of the battery.
    #[serde(default)]
    pub battery: Option<BatterySettings>,
}

/// What a flight taught of the plane that flew it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LearnedPlane {
    /// It.
    pub airframe: Airframe,
    /// The wind of that flight.
    pub wind: Wind,
    /// Moments that it rests on.
    pub moments: usize,
    /// How far measured and modelled airspeeds are apart, metres a second RMS.
    pub airspeed_error_m_s: f64,
}

/// What a vehicle's plans are rehearsed with.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleProfile {
    /// The airframe, as its parameters tell it; its power is that of its flight as far as it was followed.
    pub airframe: Airframe,
    /// Whether its parameters were read; without, it is an ArduPlane as it comes.
    pub knows_parameters: bool,
    /// Charge of a full battery, mAh; null where it is not known.
    #[schema(required = true)]
    pub capacity_mah: Option<f64>,
    /// Its voltage now; null where it is not known.
    #[schema(required = true)]
    pub voltage_v: Option<f64>,
    /// What it holds, of its capacity; 100 where nothing is told.
    pub charge_pct: f64,
    /// What should be left at a landing, of its capacity.
    pub reserve_pct: f64,
    /// What its flight teaches, as far as it was followed and no longer than the last ten minutes in the air; null where that is too little.
    #[schema(required = true)]
    pub learned: Option<LearnedPlane>,
}

/// A plan to fly many times.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpreadRequest {
    /// The plan; without a home the vehicle's is taken.
    pub plan: Plan,
    /// The vehicle that is to fly it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The expected wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// Flights, 1 to 1000; 200 by default.
    #[serde(default)]
    pub runs: Option<usize>,
    /// How much may be otherwise than expected.
    #[serde(default)]
    pub doubts: Doubts,
    /// Which winds and planes; the same seed gives the same answer. 0 by default.
    #[serde(default)]
    pub seed: u64,
}

/// What many flights of one plan show. A range is that of nine flights in ten.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Spread {
    /// Flights.
    pub runs: usize,
    /// How many ended how, the most first.
    pub endings: Vec<EndingCount>,
    /// Duration of those that ended as the expected one, seconds.
    pub duration_s: Range,
    /// Energy of the same, Wh; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<Range>,
    /// What the same leave of the battery, % of its capacity; null where that cannot be told.
    #[schema(required = true)]
    pub battery_left_pct: Option<Range>,
    /// How many of all leave less than its reserve; null likewise.
    #[schema(required = true)]
    pub below_reserve: Option<usize>,
    /// Distance of touch-downs from the expected one, metres; null without any.
    #[schema(required = true)]
    pub touch_down_m: Option<Range>,
    /// Where nine flights in ten pass, a moment every five seconds.
    pub corridor: Corridor,
}

/// How often a flight ended so.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EndingCount {
    /// How.
    pub ending: Ending,
    /// How often.
    pub count: usize,
}

/// Both sides of where flights pass, a list for each value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct Corridor {
    /// Moments of the expected flight, seconds, growing.
    pub time_s: Vec<f64>,
    /// The left side.
    pub left: Vec<LatLon>,
    /// The right side.
    pub right: Vec<LatLon>,
    /// Lowest above home, metres.
    pub low_m: Vec<f64>,
    /// Highest, likewise.
    pub high_m: Vec<f64>,
}

/// Moments of a rehearsed flight, a list for each value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct RehearsedTrack {
    /// Since its beginning, seconds, growing.
    pub time_s: Vec<f64>,
    /// Degrees.
    pub lat_deg: Vec<f64>,
    /// Degrees.
    pub lon_deg: Vec<f64>,
    /// Above home, metres.
    pub height_m: Vec<f64>,
    /// Height of the ground below, above home, metres; null where no map knows it.
    pub ground_m: Vec<Option<f64>>,
    /// Equivalent airspeed, metres a second.
    pub airspeed_m_s: Vec<f64>,
    /// Over ground, metres a second.
    pub groundspeed_m_s: Vec<f64>,
    /// Bank, degrees, to the right positive.
    pub bank_deg: Vec<f64>,
    /// Heading of the nose, degrees from true north.
    pub heading_deg: Vec<f64>,
    /// Item that is flown, counted from 1; null in a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// One item on the way.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedPassage {
    /// Counted from 1.
    pub item: u16,
    /// When the plane begins to fly to it, seconds.
    pub begins_s: f64,
    /// When it is reached or done; null: never.
    #[schema(required = true)]
    pub reached_s: Option<f64>,
    /// How near the plane comes to its place, metres; null for what is no waypoint and no landing.
    #[schema(required = true)]
    pub nearest_m: Option<f64>,
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

/// What a landing is designed from: a point or a runway. What is not given is the vehicle's, as far as its parameters were read, else that of a
/// small plane on an ArduPlane.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingRequest {
    /// Where to touch down, in place of a runway.
    #[serde(default)]
    pub at: Option<LatLon>,
    /// The runway, in place of a point: the landing point lies in its middle, on one of more than 300 m at 150 m.
    #[serde(default)]
    pub runway: Option<Runway>,
    /// The vehicle that is to land: airspeed, circle, slope and `DO_LAND_START` are laid out for it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Course of the final leg from true north; of a runway's two directions the nearer one is flown. Without it `coming_from` gives the course, else
    /// the wind; a runway is landed on into the wind, in calm air from its beginning.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Where the plane comes from; nearer than 20 m it gives no direction.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// The plan that it is to end, in place of `coming_from` and `home`: the plane comes from that plan's last place before the landing, and lands
    /// into a wind of 2 m/s or more where no course is asked for.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Below 1 m/s it gives no direction.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height of the ground at the point above home, −1000 to 1000; where it is not given, that of the maps, for which `home` is needed;
    /// else home's.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Where home is: with it the maps tell the ground below the approach, and how near that comes.
    #[serde(default)]
    pub home: Option<LatLon>,
    /// Of the approach, 5 to 60; the vehicle's, else 22.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Steepest slope of the final leg, height over distance, 0.02 to 0.25; 0.08 by default, less for a vehicle that sinks slowly.
    #[serde(default)]
    pub slope: Option<f64>,
    /// Height above the ground where the final leg begins, 15 to 200; 40 by default.
    #[serde(default)]
    pub final_height_m: Option<f64>,
    /// Smallest radius of the circle, 20 to 500; the vehicle's, else 80.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Whether the circle is flown clockwise, to the right of the final leg; as the vehicle circles, else yes. Alternatives have both sides.
    #[serde(default)]
    pub is_clockwise: Option<bool>,
    /// Whether `DO_LAND_START` goes before it; where the vehicle's return looks for it, else yes. An ArduPlane with `RTL_AUTOLAND` 0 does not arm
    /// with one.
    #[serde(default)]
    pub has_land_start: Option<bool>,
}

/// A line to land on, in either direction; 20 m to 10 km long.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Runway {
    /// One end.
    pub begin: LatLon,
    /// The other.
    pub end: LatLon,
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

/// A landing of which one part is moved.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingMove {
    /// The landing as it was designed: `DO_LAND_START` or not, `NAV_LOITER_TO_ALT`, `NAV_LAND`, with heights above home.
    pub items: Vec<PlanItem>,
    /// What is moved.
    pub part: LandingPart,
    /// Where to.
    pub to: LatLon,
    /// The wind, where it is known: the leg grows and the circle widens as it needs.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height of the ground above home where the point is moved to; without it the point keeps its height.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// The vehicle that is to land.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// A landing to choose.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingAlternative {
    /// The landing.
    pub landing: Landing,
    /// Whether its circle is flown clockwise, to the right of the final leg.
    pub is_clockwise: bool,
    /// The wind across the final leg, positive from the right; null when no wind is known.
    #[schema(required = true)]
    pub crosswind_m_s: Option<f64>,
    /// How the rehearsed approach ends.
    pub ending: Ending,
    /// Where it touches the ground, metres beyond the point along the final leg, negative before it; null where it does not.
    #[schema(required = true)]
    pub touch_down_m: Option<f64>,
    /// Where the plane comes to rest, likewise.
    #[schema(required = true)]
    pub rest_m: Option<f64>,
    /// Time from the place that the plane comes from, or from home.
    pub duration_s: f64,
    /// Whether to fly it.
    pub verdict: Verdict,
    /// What speaks for and against it.
    pub reasons: Vec<LandingReasonText>,
}

/// What speaks for or against a landing.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingReasonText {
    /// It in English.
    pub message: String,
    /// What it is, with its figures.
    #[serde(flatten)]
    pub reason: LandingReason,
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

/// What the pilot should know of a landing before it is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingCaution {
    /// `ground-not-known`, `steep-approach`, `tailwind` or `ground-near`.
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

/// A plan to rehearse.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RehearsalRequest {
    /// The plan; without a home the vehicle's is taken.
    pub plan: Plan,
    /// The vehicle that is to fly it: its parameters, as far as they were read, are the plane's.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height above the ground that the flight should keep, 0 to 1000; 30 by default.
    #[serde(default)]
    pub clearance_m: Option<f64>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
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

/// What may happen at a moment of a plan, and wants to be known.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WhatIfRequest {
    /// The plan, with `at_s`; without a home the vehicle's is taken. Absent both: from now on as the vehicle flies, in its mission, GUIDED,
    /// LOITER, CIRCLE, RTL, or a mode that a pilot steers.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// A moment of the plan, seconds since the rehearsed flight's beginning.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// The vehicle that is to fly it: its parameters, as far as they were read, are the plane's.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// What happens; everything when absent.
    #[serde(default)]
    pub triggers: Option<Vec<Trigger>>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// Of a flight that is followed: what was expected of it when that began, beside which it is told how it goes.
    #[serde(default)]
    pub begun: Option<Beginning>,
}

/// A flight as it was expected when somebody began to follow it, of an answer about now.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Beginning {
    /// `now` of that answer.
    pub now: FlightNow,
    /// The track of its `ahead`.
    pub track: ExpectedTrack,
}

/// Of a rehearsed track, what tells whether a flight is late or low: lists of one length.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedTrack {
    /// Since its beginning, seconds, growing.
    pub time_s: Vec<f64>,
    /// Degrees.
    pub lat_deg: Vec<f64>,
    /// Degrees.
    pub lon_deg: Vec<f64>,
    /// Above home, metres.
    pub height_m: Vec<f64>,
    /// Item that is flown, counted from 1; null in a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// A moment of a flight by the vehicle's own clock, which runs faster in some simulators.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FlightNow {
    /// Since the vehicle booted; null while it has not said.
    #[schema(required = true)]
    pub boot_s: Option<f64>,
    /// What is left of its battery; null likewise.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// How a flight goes beside what was expected; null is not known, as away from the expected track.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct Outlook {
    /// Later than expected; negative: earlier.
    #[schema(required = true)]
    pub late_s: Option<f64>,
    /// Lower than expected, metres; negative: higher.
    #[schema(required = true)]
    pub low_m: Option<f64>,
    /// What will be left of the battery at the end of `ahead`, if it goes on as since the beginning; null while less than 2 % were used.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// What follows from a moment of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIfs {
    /// When, seconds since the rehearsed flight's beginning; 0 is now where the vehicle flies it.
    pub at_s: f64,
    /// Where the plane is then; null on the ground and after the flight, where nothing follows.
    #[schema(required = true)]
    pub at: Option<LatLon>,
    /// Height above home then, metres.
    pub height_m: f64,
    /// The flight as it goes on when nothing happens; null where the moment is one of the plan's own rehearsal, and where
    /// a pilot steers.
    #[schema(required = true)]
    pub ahead: Option<RehearsedFlight>,
    /// Whether it is known how much was flown of the circle that the vehicle flies now. Where not, as when the station was started
    /// while it circled, `ahead` flies it whole, and nobody is told whether the flight is late until it goes on to the next item.
    pub is_circle_known: bool,
    /// Of a vehicle as it flies now, by what to know this moment later (`begun`); null for a moment of a plan, and while how much of
    /// its circle was flown is not known.
    #[schema(required = true)]
    pub now: Option<FlightNow>,
    /// How it goes beside what was expected when it began; null without `begun`, and without `ahead`.
    #[schema(required = true)]
    pub outlook: Option<Outlook>,
    /// One for each that was asked for.
    pub what_ifs: Vec<WhatIf>,
    /// The ground that may be reached without thrust, as a ring of places clockwise from north.
    pub glide_range: Vec<LatLon>,
}

/// What follows from one thing that happens.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIf {
    /// What happens.
    pub trigger: Trigger,
    /// What the vehicle decides, in order of time; none where its settings do not act on it.
    pub decisions: Vec<Decision>,
    /// What it ends with.
    pub reaction: Reaction,
    /// The flight from there; null where the mission goes on as rehearsed.
    #[schema(required = true)]
    pub flown: Option<RehearsedFlight>,
}

/// One decision of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Decision {
    /// When, seconds since the rehearsed flight's beginning.
    pub time_s: f64,
    /// What it does.
    pub reaction: Reaction,
}

/// A part of a rehearsed flight, to its end.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedFlight {
    /// The track, as many moments as it takes to draw it within a metre.
    pub track: RehearsedTrack,
    /// How it ends.
    pub ending: Ending,
    /// Where the ground is touched; null where it is not.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// Its end, seconds since the rehearsed flight's beginning.
    pub ends_s: f64,
    /// Way over ground since that beginning, metres.
    pub distance_m: f64,
    /// Electrical energy since that beginning; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// What is left of the battery; null where that cannot be told.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
}
