//! What is said on the WebSocket, both ways.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::landing::Wind;
use vencejo_vehicle::telemetry::TelemetryGroups;

use super::roster::{RosterChange, RosterRow};
use super::storage::StorageProblem;
use super::{
    Assessment, Cause, LinkInfo, MissionProgress, Operation, Plan, PlanKind, PlanState, PlaneProfile, RawMessage,
    SessionInfo, VehicleSummary, Way,
};

/// What a client says on the WebSocket.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
#[allow(clippy::large_enum_variant, reason = "read and answered at once, never kept")]
pub enum ClientMessage {
    /// Wants a vehicle's telemetry; again with another rate changes the rate.
    Subscribe {
        /// The vehicle's id; it need not have been heard yet.
        vehicle: u16,
        /// Messages per second, 1 to 50.
        #[schema(minimum = 1, maximum = 50)]
        rate_hz: f64,
    },
    /// Wants it no more.
    Unsubscribe {
        /// The vehicle's id.
        vehicle: u16,
    },
    /// Wants the list of all vehicles as `roster`, in place of `vehicles`: the whole at once, then what changed, at most once a second
    /// for each vehicle.
    SubscribeRoster,
    /// Wants `vehicles` again.
    UnsubscribeRoster,
    /// Wants a vehicle's raw messages, the newest of each sender; again with other names or another rate changes that.
    SubscribeMessages {
        /// The vehicle's id; it need not have been heard yet.
        vehicle: u16,
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
        /// The vehicle's id.
        vehicle: u16,
    },
    /// Wants to know what the core says of a plan, as while a point of it is dragged. One question at a time is answered, and of those
    /// that come meanwhile the newest alone.
    AssessPlan {
        /// Comes back with the answer.
        seq: u64,
        /// The vehicle that is to fly it; an ArduPlane as it comes when absent.
        #[serde(default)]
        vehicle: Option<u16>,
        /// It.
        plan: Plan,
        /// The wind that it is to be rehearsed in; it is not rehearsed when absent.
        #[serde(default)]
        rehearse_in: Option<Wind>,
        /// Height above the ground that the rehearsed flight should keep, 0 to 1000; 30 by default.
        #[serde(default)]
        clearance_m: Option<f64>,
        /// The plane that it is rehearsed with, in place of the vehicle's.
        #[serde(default)]
        profile: PlaneProfile,
    },
    /// Wants the way of a plan's mission as it is drawn, with its heights, as `POST /plan/way` tells it. One question at a time is answered, and of those
    /// that come meanwhile the newest alone; none waits for an assessment.
    PlanWay {
        /// Comes back with the answer.
        seq: u64,
        /// The vehicle that is to fly it; an ArduPlane as it comes when absent.
        #[serde(default)]
        vehicle: Option<u16>,
        /// Height above the ground that should be kept, 0 to 1000; 30 by default.
        #[serde(default)]
        clearance_m: Option<f64>,
        /// It.
        plan: Plan,
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
        /// By id.
        vehicles: Vec<VehicleSummary>,
    },
    /// What changed in the list of vehicles, for those who subscribed to it.
    Roster {
        /// When this was taken, seconds on the station's clock.
        time_s: f64,
        /// Rows that changed, each with the fields that changed; of a newcomer with all.
        #[schema(value_type = Vec<RosterRow>)]
        rows: Vec<RosterChange>,
        /// Ids of vehicles that went.
        gone: Vec<u16>,
        /// The vehicles that this client is subscribed to, as `vehicles` would list them.
        followed: Vec<VehicleSummary>,
    },
    /// A subscribed vehicle's values that changed.
    Telemetry {
        /// The vehicle.
        vehicle: u16,
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
        vehicle: u16,
        /// How many of it have come since it was subscribed to; those between were not told.
        count: u64,
        /// It.
        message: RawMessage,
    },
    /// A text that the vehicle wrote.
    Text {
        /// The vehicle.
        vehicle: u16,
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
        vehicle: u16,
        /// `lost`, `regained`, `unreached` (it is heard, but does not hear us), `reached`, `rebooted`,
        /// `mode`, `armed`, `disarmed`, `landed`, `item`, `item_reached`, `mission_complete`,
        /// `target_elsewhere` (it flies to somewhere else than its plan says, an alarm), `target_as_planned`, `home`,
        /// `streams_fell_back`, `contested`, `uncontested`,
        /// `terrain_unknown` (it asks for the ground's altitude where no map knows it), `terrain_known`.
        kind: String,
        /// What belongs to it: `mode` and `from`, `landed`, or `item`; `distance_m` of `target_elsewhere`.
        #[schema(value_type = BTreeMap<String, EventDetail>)]
        detail: BTreeMap<&'static str, EventDetail>,
        /// When, seconds on the station's clock.
        time_s: f64,
    },
    /// What is known of a plan on board changed.
    PlanState {
        /// The vehicle.
        vehicle: u16,
        /// Which plan.
        kind: PlanKind,
        /// What is known now.
        state: PlanState,
    },
    /// The answer to `assess_plan`.
    Assessment {
        /// The question's.
        seq: u64,
        /// What was found.
        #[serde(flatten)]
        assessment: Assessment,
    },
    /// The answer to `plan_way`.
    Way {
        /// The question's.
        seq: u64,
        /// The way.
        #[serde(flatten)]
        way: Way,
    },
    /// An operation began, went on or ended; without its result.
    Operation(Operation),
    /// The links, each second.
    Links {
        /// By id.
        links: Vec<LinkInfo>,
    },
    /// Something of the map sources or offline areas is another than before, or an area went on: at most once a second. Who
    /// shows them asks for them again.
    Maps,
    /// What of the server's disk does not work: at the start, and when it changes. Nothing is in the list when all is well.
    Storage {
        /// The flight recorder's first.
        problems: Vec<StorageProblem>,
    },
    /// The draft of the plan has another revision.
    Draft {
        /// Which.
        revision: u64,
        /// Which browser or program it comes from.
        author: String,
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
        /// The question's, where it was one about a plan; absent otherwise.
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
