//! Messages on the WebSocket, in both directions.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::landing::Wind;
use vencejo_vehicle::telemetry::TelemetryGroups;

use super::roster::{RosterChange, RosterRow};
use super::storage::StorageProblem;
use super::{
    Assessment, Cause, FleetNetwork, LinkInfo, MissionProgress, Operation, Param, Plan, PlanKind, PlanState,
    PlaneProfile, RawMessage, SessionInfo, Text, VehicleSummary, Way,
};

/// Messages from a client.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
#[allow(clippy::large_enum_variant, reason = "read and answered at once, never kept")]
pub enum ClientMessage {
    /// Subscribes to a vehicle's telemetry; repeated with another rate, it changes the rate.
    Subscribe {
        /// Id of the vehicle; it need not have been heard yet.
        vehicle: u16,
        /// Messages per second, 1 to 50.
        #[schema(minimum = 1, maximum = 50)]
        rate_hz: f64,
    },
    /// Ends the subscription to a vehicle's telemetry.
    Unsubscribe {
        /// Id of the vehicle.
        vehicle: u16,
    },
    /// Subscribes to the fleet list as `roster`, in place of `vehicles`: first all rows, then changes, at most once a
    /// second for each vehicle.
    SubscribeRoster,
    /// Returns to `vehicles`.
    UnsubscribeRoster,
    /// Subscribes to a vehicle's raw messages, the newest of each sender; repeated with other names or another rate, it
    /// changes them.
    SubscribeMessages {
        /// Id of the vehicle; it need not have been heard yet.
        vehicle: u16,
        /// Names of the messages; all when absent.
        #[serde(default)]
        #[schema(max_items = 64)]
        names: Option<Vec<String>>,
        /// Highest rate of each message, 1 to 50 per second.
        #[schema(minimum = 1, maximum = 50)]
        rate_hz: f64,
    },
    /// Ends the subscription to a vehicle's raw messages.
    UnsubscribeMessages {
        /// Id of the vehicle.
        vehicle: u16,
    },
    /// Requests the assessment of a plan, for example while one of its points is dragged. One request at a time is
    /// answered; of those that arrive meanwhile, only the newest is kept.
    AssessPlan {
        /// Request number, repeated in the answer.
        seq: u64,
        /// Vehicle that is to fly the plan; a default ArduPlane when absent.
        #[serde(default)]
        vehicle: Option<u16>,
        /// The plan.
        plan: Plan,
        /// Wind of the rehearsal; the plan is not rehearsed when absent.
        #[serde(default)]
        rehearse_in: Option<Wind>,
        /// Clearance that the rehearsed flight should keep above the ground, 0 to 1000; 30 by default.
        #[serde(default)]
        clearance_m: Option<f64>,
        /// Plane for the rehearsal, in place of the vehicle's.
        #[serde(default)]
        profile: PlaneProfile,
    },
    /// Requests the route of a plan's mission with its altitude profile, as `POST /plan/way` does. One request at a
    /// time is answered; of those that arrive meanwhile, only the newest is kept. It does not wait for assessments.
    PlanWay {
        /// Request number, repeated in the answer.
        seq: u64,
        /// Vehicle that is to fly the plan; a default ArduPlane when absent.
        #[serde(default)]
        vehicle: Option<u16>,
        /// Clearance to keep above the ground, 0 to 1000; 30 by default.
        #[serde(default)]
        clearance_m: Option<f64>,
        /// The plan.
        plan: Plan,
    },
}

/// Messages from the server. Telemetry, lists and states are the newest at the time of sending: a slow client misses
/// intermediate ones. Texts and events are queued; when too many are waiting, the connection is closed with code 1013.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "made and written at once, never kept")]
pub enum ServerMessage {
    /// The first message.
    Hello {
        /// Version of the server.
        version: String,
        /// Time of sending, seconds on the station's clock.
        time_s: f64,
        /// Session of the client.
        #[serde(flatten)]
        session: SessionInfo,
    },
    /// The vehicles heard so far: on connection, when one appears or disappears, and once a second.
    Vehicles {
        /// Vehicles by id.
        vehicles: Vec<VehicleSummary>,
    },
    /// Changes in the fleet list, for subscribers.
    Roster {
        /// Time of these values, seconds on the station's clock.
        time_s: f64,
        /// Changed rows, each with its changed fields; new rows with all fields.
        #[schema(value_type = Vec<RosterRow>)]
        rows: Vec<RosterChange>,
        /// Ids of vehicles that disappeared.
        gone: Vec<u16>,
        /// Vehicles whose telemetry this client is subscribed to, as in `vehicles`.
        followed: Vec<VehicleSummary>,
    },
    /// Changed values of a subscribed vehicle.
    Telemetry {
        /// Id of the vehicle.
        vehicle: u16,
        /// Time of these values, seconds on the station's clock.
        time_s: f64,
        /// The groups that changed.
        groups: TelemetryGroups,
        /// Mission progress; absent when unchanged.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(nullable = false)]
        progress: Option<MissionProgress>,
    },
    /// A subscribed raw message: the newest with this name and sender.
    Message {
        /// Id of the vehicle.
        vehicle: u16,
        /// Number of such messages since subscribing, including those that were not sent to the client.
        count: u64,
        /// The message.
        message: RawMessage,
    },
    /// A status text from a vehicle.
    Text {
        /// Id of the vehicle.
        vehicle: u16,
        /// The text.
        #[serde(flatten)]
        text: Text,
    },
    /// An event of a vehicle.
    Event {
        /// Id of the vehicle.
        vehicle: u16,
        /// `lost`, `regained`, `unreached` (it is heard, but does not hear us), `reached`, `rebooted`, `mode`, `armed`,
        /// `disarmed`, `landed`, `item`, `item_reached`, `mission_complete`, `target_elsewhere` (an alarm: it flies to
        /// a position other than its plan's), `target_as_planned`, `home`, `streams_fell_back`, `contested`,
        /// `uncontested`, `terrain_unknown` (it requests ground elevations that no map contains), `terrain_known`.
        kind: String,
        /// Details by name: `mode` and `from`, `landed`, or `item`; `distance_m` for `target_elsewhere`.
        #[schema(value_type = BTreeMap<String, EventDetail>)]
        detail: BTreeMap<&'static str, EventDetail>,
        /// Time of the event, seconds on the station's clock.
        time_s: f64,
    },
    /// The state of a plan on board changed.
    PlanState {
        /// Id of the vehicle.
        vehicle: u16,
        /// Part of the plan.
        kind: PlanKind,
        /// New state.
        state: PlanState,
    },
    /// A parameter that is known has another value than before, whoever set it. Values read in a list are not reported.
    Param {
        /// Id of the vehicle.
        vehicle: u16,
        /// The parameter.
        param: Param,
    },
    /// Answer to `assess_plan`.
    Assessment {
        /// Number of the request.
        seq: u64,
        /// The assessment.
        #[serde(flatten)]
        assessment: Assessment,
    },
    /// Answer to `plan_way`.
    Way {
        /// Number of the request.
        seq: u64,
        /// The route.
        #[serde(flatten)]
        way: Way,
    },
    /// An operation started, progressed or ended; without its result.
    Operation(Operation),
    /// The links, once a second.
    Links {
        /// Links by id.
        links: Vec<LinkInfo>,
    },
    /// The fleets that this station is in, and whether their networks are connected: on connection and on change.
    Networks {
        /// The fleets; empty when it is in none.
        networks: Vec<FleetNetwork>,
    },
    /// Map sources or offline areas have changed, or a download has progressed; at most once a second. Clients fetch
    /// them again.
    Maps,
    /// Storage faults: on connection and on change.
    Storage {
        /// Faults, the flight recorder's first; empty when there are none.
        problems: Vec<StorageProblem>,
    },
    /// The draft of the plan has a new revision.
    Draft {
        /// The revision.
        revision: u64,
        /// Browser or program that wrote it.
        author: String,
    },
    /// The holder of control has changed.
    Control {
        /// Whether this session holds control.
        has_control: bool,
        /// Name of the session that holds control; null when there is none.
        #[schema(required = true)]
        holder: Option<String>,
        /// Name of the session that requests control; null when there is none.
        #[schema(required = true)]
        requested_by: Option<String>,
    },
    /// A message of the client could not be carried out.
    Error {
        /// Why, in English.
        detail: String,
        /// Machine-readable cause.
        cause: Cause,
        /// Number of the request about a plan; absent for other messages.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(nullable = false)]
        seq: Option<u64>,
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
