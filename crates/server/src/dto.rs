//! What goes over the wire of the HTTP API and the WebSocket: types of its own, so that the core may change without it.
//!
//! Units and datum are in the names. Absent is null, never NaN, 0 or −1. Items of a mission are counted from 1, without home.

pub mod camera;
pub mod cause;
pub mod maps;
pub mod message;
pub mod recording;
pub mod telemetry;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use cause::{Cause, PlanUncertainty};
pub use message::RawMessage;
pub use telemetry::TelemetryGroups;

/// What answers.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Info {
    /// Always `vencejo`.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Whether `POST /session` needs a token.
    pub needs_token: bool,
}

/// An error (RFC 9457), served as `application/problem+json`. Its texts are English; `cause` says the same to programs, so that
/// they can say it in another language.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Problem {
    /// Stable kind: `urn:vencejo:` and the code of `cause`, such as `urn:vencejo:command-refused`.
    pub r#type: String,
    /// The kind in words.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What was wrong, where, and what to do.
    pub detail: String,
    /// What the vehicle wrote about it, or the differences that were found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub reasons: Vec<String>,
    /// What to do about it, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub remedy: Option<String>,
    /// The same for programs.
    pub cause: Cause,
}

/// State of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkState {
    /// On its way up.
    Connecting,
    /// Open; nobody needs to have spoken yet.
    Up,
    /// Closed.
    Down,
    /// A recording that was played to its end.
    Ended,
}

/// A link and what went over it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LinkInfo {
    /// Its id.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Its link string.
    pub address: String,
    /// Address and port of its own socket while it is up.
    #[schema(required = true)]
    pub local_address: Option<String>,
    /// Its state.
    pub state: LinkState,
    /// Why it is not up.
    #[schema(required = true)]
    pub detail: Option<String>,
    /// Whether frames between it and the other links are passed on.
    pub forward: bool,
    /// Frames that came in.
    pub frames_received: u64,
    /// Frames that went out.
    pub frames_sent: u64,
    /// Bytes that came in.
    pub bytes_received: u64,
    /// Bytes that went out.
    pub bytes_sent: u64,
    /// Frames with a wrong checksum.
    pub bad_crc: u64,
    /// Bytes that belonged to no frame.
    pub garbage_bytes: u64,
    /// Frames missing by the senders' counters.
    pub frames_lost: u64,
    /// Share of all frames that were lost.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round trip of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
    /// Time since the newest frame.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Frames per second lately.
    pub frames_per_s: f64,
    /// Share of the frames that were lost lately.
    #[schema(required = true)]
    pub recent_loss_pct: Option<f64>,
}

/// A link to open.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewLink {
    /// Link string, such as `udpin:0.0.0.0:14550`.
    #[schema(max_length = 256)]
    pub address: String,
    /// Whether to pass frames on between it and the other links, for another ground station.
    #[serde(default)]
    pub forward: bool,
    /// Name to show; the link string when absent.
    #[serde(default)]
    pub name: Option<String>,
}

/// A vehicle in the list of vehicles.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleSummary {
    /// MAVLink system id.
    pub system_id: u8,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    #[schema(required = true)]
    pub mav_type: Option<u8>,
    /// `MAV_AUTOPILOT`; 3 is ArduPilot.
    #[schema(required = true)]
    pub autopilot: Option<u8>,
    /// Flight mode by name.
    #[schema(required = true)]
    pub mode: Option<String>,
    /// Whether the motors can run.
    #[schema(required = true)]
    pub is_armed: Option<bool>,
    /// Time since the vehicle was heard; stale after 3.5 s, lost after 5 s.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// The link that it is reached over.
    #[schema(required = true)]
    pub link: Option<u32>,
    /// Share of its frames that were lost.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round trip of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
}

/// Where the vehicle stands in its mission.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema, Default)]
pub struct MissionProgress {
    /// Item in execution, counted from 1.
    #[schema(required = true)]
    pub item: Option<u16>,
    /// Items in the mission.
    #[schema(required = true)]
    pub total: Option<u16>,
    /// Items reached, ascending.
    pub reached: Vec<u16>,
    /// Whether it was flown to its end.
    pub is_complete: bool,
    /// Distance over ground to the mission's end.
    #[schema(required = true)]
    pub distance_m: Option<f64>,
    /// Time for that at the present speed.
    #[schema(required = true)]
    pub time_s: Option<f64>,
    /// Distance to the item in execution.
    #[schema(required = true)]
    pub leg_distance_m: Option<f64>,
}

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

/// Everything that is known of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleState {
    /// MAVLink system id.
    pub system_id: u8,
    /// When this was taken, seconds on the station's clock.
    pub time_s: f64,
    /// The newest values by group.
    pub telemetry: TelemetryGroups,
    /// Where it stands in its mission.
    pub progress: MissionProgress,
    /// What is known of the plans on board.
    pub plan_states: PlanStates,
    /// Flight modes that it has, by name.
    pub mode_names: Vec<String>,
    /// The link that it is reached over, with the vehicle's own counters.
    #[schema(required = true)]
    pub link: Option<LinkInfo>,
}

/// A text that the vehicle wrote (STATUSTEXT).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Text {
    /// When, seconds on the station's clock.
    pub time_s: f64,
    /// `MAV_SEVERITY`: 0 emergency to 7 debug.
    pub severity: u8,
    /// What it wrote.
    pub text: String,
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

/// A plan to look over.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanCheck {
    /// The plan.
    pub plan: Plan,
    /// The vehicle that is to fly it: its place and whether it is on the ground are taken into account.
    #[serde(default)]
    pub vehicle: Option<u8>,
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FindingSeverity {
    /// Not to be sent.
    Error,
    /// For the pilot to judge.
    Warning,
}

/// Something wrong or doubtful in a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Finding {
    /// How bad it is.
    pub severity: FindingSeverity,
    /// Stable kind, such as `zero-coordinates`.
    pub code: String,
    /// The item, counted from 1; null when it is about the whole plan.
    #[schema(required = true)]
    pub item: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub remedy: String,
}

/// What a command is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandCategory {
    /// Flown until done; one at a time.
    Nav,
    /// Holds back the actions that follow it.
    Condition,
    /// Done at once, beside the flying.
    Do,
    /// Part of a fence list.
    Fence,
    /// Part of a rally list.
    Rally,
}

/// What an ArduPlane does with a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandSupport {
    /// Stored and done.
    Flown,
    /// Done by a plane that can hover; skipped by others.
    NeedsVtol,
    /// Stored, but skipped in flight.
    Ignored,
    /// Taken in fence or rally lists only.
    List,
}

/// What one parameter of a command means.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandParam {
    /// Name to show, English; empty when the command does not use the parameter.
    pub label: String,
    /// Symbol to show after a value; empty when there is none.
    pub unit: String,
    /// Smallest value that makes sense.
    #[schema(required = true)]
    pub min: Option<f64>,
    /// Largest value that makes sense.
    #[schema(required = true)]
    pub max: Option<f64>,
    /// Value to offer for a new item.
    #[schema(required = true)]
    pub default: Option<f64>,
}

/// A command of the table.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandInfo {
    /// `MAV_CMD` number.
    pub number: u16,
    /// Name without `MAV_CMD_`.
    pub name: String,
    /// Name to show, English.
    pub title: String,
    /// What it is for.
    pub category: CommandCategory,
    /// What an ArduPlane does with it.
    pub support: CommandSupport,
    /// Whether parameters 5 to 7 are latitude, longitude and height.
    pub has_position: bool,
    /// Whether a plane flies to that position.
    pub is_destination: bool,
    /// Parameters 1 to 7.
    #[schema(min_items = 7, max_items = 7)]
    pub params: Vec<CommandParam>,
}

/// A parameter of the vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Param {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its type on the wire: `int8` … `real32`.
    pub kind: String,
}

/// A parameter's new value.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewParam {
    /// The value.
    pub value: f64,
}

/// How an operation stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OperationState {
    /// Under way.
    Running,
    /// Succeeded.
    Done,
    /// Failed; `error` says why.
    Failed,
    /// Given up on request.
    Cancelled,
}

/// What an operation does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OperationKind {
    /// Sends a mission and reads it back.
    UploadMission,
    /// Sends a fence and reads it back.
    UploadFence,
    /// Sends rally points and reads them back.
    UploadRally,
    /// Reads the mission.
    DownloadMission,
    /// Reads the fence.
    DownloadFence,
    /// Reads the rally points.
    DownloadRally,
    /// Removes the mission.
    ClearMission,
    /// Removes the fence.
    ClearFence,
    /// Removes the rally points.
    ClearRally,
    /// Reads all parameters.
    ReadParams,
}

/// What an operation brought.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum OperationResult {
    /// The plan on board.
    Plan(Plan),
    /// All parameters, by name.
    Params(Vec<Param>),
}

/// Something that takes a while.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Operation {
    /// Its id.
    pub id: u64,
    /// The vehicle.
    pub vehicle: u8,
    /// What it does.
    pub kind: OperationKind,
    /// How it stands.
    pub state: OperationState,
    /// How much is done, in units of `total`.
    pub done: u32,
    /// How much there is; 0 when not known yet.
    pub total: u32,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub error: Option<Problem>,
    /// After an upload to a vehicle that keeps positions as 32-bit floats: how far the farthest place on board is from where it
    /// was sent to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub position_error_m: Option<f64>,
    /// What it brought; only at `GET /operations/{id}`, once done.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub result: Option<OperationResult>,
}

/// What a session may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Looks.
    Viewer,
    /// Commands as well, while it holds control.
    Operator,
}

/// Who wants a session.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct NewSession {
    /// The token from the server's terminal; needed when `GET /info` says so.
    #[serde(default)]
    pub token: Option<String>,
    /// Name to show to others, up to 40 characters.
    #[serde(default)]
    pub name: Option<String>,
}

/// A session as its owner sees it. The secret that proves it is in the cookie.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct SessionInfo {
    /// Public id.
    pub session: String,
    /// Its name.
    pub name: String,
    /// What it may do.
    pub role: Role,
    /// Whether it holds control.
    pub has_control: bool,
    /// Name of the session that holds control; null when nobody does.
    #[schema(required = true)]
    pub holder: Option<String>,
    /// Name of the session that asks for control; null when nobody does.
    #[schema(required = true)]
    pub requested_by: Option<String>,
}

/// Nothing more to say: the vehicle did it, and shows it where that can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Done {}

/// How to arm or disarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// In spite of the vehicle's own checks, or in the air.
    #[serde(default)]
    pub force: bool,
}

/// A flight mode: its name, one of the vehicle's `mode_names`, or its number on the wire.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum Mode {
    /// By number.
    Number(u32),
    /// By name.
    Name(String),
}

/// The flight mode to change to.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetMode {
    /// Which.
    pub mode: Mode,
}

/// A take-off.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Takeoff {
    /// Height to climb to, 1 to 10,000.
    pub alt_rel_home_m: f64,
}

/// What a height is counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AltFrame {
    /// Home.
    Home,
    /// Mean sea level.
    Amsl,
    /// The terrain below.
    Terrain,
}

/// A position to fly to and circle at.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Goto {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height, counted as `alt_frame` says.
    pub alt_m: f64,
    /// What `alt_m` is counted from.
    pub alt_frame: AltFrame,
    /// Radius of the circle; the vehicle's own when absent.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Sense of the circle; clockwise when absent.
    #[serde(default)]
    pub clockwise: Option<bool>,
    /// Ground speed; the vehicle's own when absent.
    #[serde(default)]
    pub speed_m_s: Option<f64>,
    /// Whether to enter GUIDED for it, which it does when absent; without it a vehicle in another mode refuses.
    #[serde(default)]
    pub change_mode: Option<bool>,
}

/// A course to fly.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FlyCourse {
    /// Course over ground from true north, 0 to below 360.
    pub course_deg: f64,
    /// Centripetal acceleration of the turn at most, 0.05 to 20; 5, a bank of 27 degrees, when absent.
    #[serde(default)]
    pub accel_m_s2: Option<f64>,
}

/// A height to climb or sink to at a rate.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ClimbTo {
    /// Height, counted as `alt_frame` says.
    pub alt_m: f64,
    /// What `alt_m` is counted from.
    pub alt_frame: AltFrame,
    /// How fast, above 0 to 50.
    pub rate_m_s: f64,
}

/// A velocity relative to the heading; what is absent is 0.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct SetVelocity {
    /// Forward, −50 to 50.
    pub forward_m_s: f64,
    /// To the right, −50 to 50.
    pub right_m_s: f64,
    /// Down, −50 to 50.
    pub down_m_s: f64,
    /// Clockwise seen from above, −10 to 10.
    pub yaw_rate_rad_s: f64,
}

/// A text of ours to stand beside the vehicle's own.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewNote {
    /// The text; cut to 500 characters.
    #[schema(max_length = 500)]
    pub text: String,
    /// `MAV_SEVERITY`: 0 emergency to 7 debug; 6 when absent.
    #[serde(default)]
    #[schema(maximum = 7)]
    pub severity: Option<u8>,
}

/// Which speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpeedKind {
    /// Through the air.
    Airspeed,
    /// Over ground.
    Groundspeed,
}

/// A new speed.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetSpeed {
    /// Which speed.
    pub kind: SpeedKind,
    /// How fast, above 0 to 200.
    pub speed_m_s: f64,
}

/// A new height.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetAltitude {
    /// Height, counted as `alt_frame` says.
    pub alt_m: f64,
    /// What `alt_m` is counted from.
    pub alt_frame: AltFrame,
}

/// How to abort a landing.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct AbortLanding {
    /// Height to climb to; the vehicle's own when absent.
    #[serde(default)]
    pub alt_rel_home_m: Option<f64>,
}

/// Where to begin a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct MissionStart {
    /// Item to begin with, counted from 1; where the vehicle stands when absent.
    #[serde(default)]
    pub from_item: Option<u16>,
}

/// The item to fly next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetItem {
    /// The item, counted from 1.
    pub item: u16,
}

/// A new home; all absent: where the vehicle is.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct SetHome {
    /// WGS-84 latitude.
    #[serde(default)]
    pub lat_deg: Option<f64>,
    /// WGS-84 longitude.
    #[serde(default)]
    pub lon_deg: Option<f64>,
    /// Height above mean sea level.
    #[serde(default)]
    pub alt_amsl_m: Option<f64>,
}

/// What a client says on the WebSocket.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum ClientMessage {
    /// Wants a vehicle's telemetry; again with another rate changes the rate.
    Subscribe {
        /// The vehicle's system id; it need not have been heard yet.
        vehicle: u8,
        /// Messages per second, 1 to 50.
        #[schema(minimum = 1, maximum = 50)]
        rate_hz: f64,
    },
    /// Wants it no more.
    Unsubscribe {
        /// The vehicle's system id.
        vehicle: u8,
    },
    /// Wants a vehicle's raw messages, the newest of each sender; again with other names or another rate changes that.
    SubscribeMessages {
        /// The vehicle's system id; it need not have been heard yet.
        vehicle: u8,
        /// Only these messages, by name; all when absent.
        #[serde(default)]
        #[schema(max_items = 64)]
        names: Option<Vec<String>>,
        /// How often each is told at most, 1 to 50 a second.
        #[schema(minimum = 1, maximum = 50)]
        rate_hz: f64,
    },
    /// Wants them no more.
    UnsubscribeMessages {
        /// The vehicle's system id.
        vehicle: u8,
    },
}

/// What the server says on the WebSocket. Telemetry, lists and states are the newest when they are sent: a client that
/// reads slowly misses older ones. Texts and events are queued; too many of them end the connection with code 1013.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "made and written at once, never kept")]
pub enum ServerMessage {
    /// The first message.
    Hello {
        /// The server's version.
        version: String,
        /// When this was sent, seconds on the station's clock.
        time_s: f64,
        /// Who we take the client for.
        #[serde(flatten)]
        session: SessionInfo,
    },
    /// The vehicles heard so far: at once, when one comes or goes, and each second.
    Vehicles {
        /// By system id.
        vehicles: Vec<VehicleSummary>,
    },
    /// A subscribed vehicle's values that changed.
    Telemetry {
        /// The vehicle.
        vehicle: u8,
        /// When they were taken, seconds on the station's clock.
        time_s: f64,
        /// Only the groups that changed.
        groups: TelemetryGroups,
        /// Where it stands in its mission; absent when that did not change.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(nullable = false)]
        progress: Option<MissionProgress>,
    },
    /// A subscribed raw message: the newest of this name and sender.
    Message {
        /// The vehicle.
        vehicle: u8,
        /// How many of it have come since it was subscribed to; those between were not told.
        count: u64,
        /// It.
        message: RawMessage,
    },
    /// A text that the vehicle wrote.
    Text {
        /// The vehicle.
        vehicle: u8,
        /// `MAV_SEVERITY`: 0 emergency to 7 debug.
        severity: u8,
        /// What it wrote.
        text: String,
        /// When, seconds on the station's clock.
        time_s: f64,
    },
    /// Something happened to a vehicle.
    Event {
        /// The vehicle.
        vehicle: u8,
        /// `lost`, `regained`, `rebooted`, `mode`, `armed`, `disarmed`, `landed`, `item`, `item_reached`, `mission_complete`,
        /// `home`, `streams_fell_back`.
        kind: String,
        /// What belongs to it: `mode` and `from`, `landed`, or `item`.
        #[schema(value_type = BTreeMap<String, EventDetail>)]
        detail: BTreeMap<&'static str, EventDetail>,
        /// When, seconds on the station's clock.
        time_s: f64,
    },
    /// What is known of a plan on board changed.
    PlanState {
        /// The vehicle.
        vehicle: u8,
        /// Which plan.
        kind: PlanKind,
        /// What is known now.
        state: PlanState,
    },
    /// An operation began, went on or ended; without its result.
    Operation(Operation),
    /// The links, each second.
    Links {
        /// By id.
        links: Vec<LinkInfo>,
    },
    /// Who holds control.
    Control {
        /// Whether this session holds it.
        has_control: bool,
        /// Name of the session that holds it; null when nobody does.
        #[schema(required = true)]
        holder: Option<String>,
        /// Name of the session that asks for it; null when nobody does.
        #[schema(required = true)]
        requested_by: Option<String>,
    },
    /// What the client said could not be done.
    Error {
        /// Why, in English.
        detail: String,
        /// The same for programs.
        cause: Cause,
    },
}

/// A detail of an event.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum EventDetail {
    /// A word.
    Text(String),
    /// A number.
    Number(u32),
}
