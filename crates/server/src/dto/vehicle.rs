//! State and parameters of a vehicle.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_vehicle::telemetry::TelemetryGroups;

use super::replay::Replay;
use super::{LinkInfo, PlanStates, VehicleControl};

/// Summary of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleSummary {
    /// Id of the vehicle in this API: the MAVLink system id of one on a link, 256 to 65,535 for a remote or replayed one.
    pub system_id: u16,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    #[schema(required = true)]
    pub mav_type: Option<u8>,
    /// `MAV_AUTOPILOT`; 3 is ArduPilot.
    #[schema(required = true)]
    pub autopilot: Option<u8>,
    /// Flight mode by name.
    #[schema(required = true)]
    pub mode: Option<String>,
    /// Whether it is armed.
    #[schema(required = true)]
    pub is_armed: Option<bool>,
    /// Time since it was last heard; stale after 3.5 s, lost after 5 s.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Name of a vehicle that is not on a link of this server: in its fleet, where a station on board is asked for it, or of
    /// the recording that it comes from.
    #[schema(required = true)]
    pub remote_name: Option<String>,
    /// Who has control of a remote vehicle; null for one on a link, and for a recording.
    #[schema(required = true)]
    pub control: Option<VehicleControl>,
    /// Whether the certificate of a remote vehicle was revoked, as far as this station knows.
    pub is_revoked: bool,
    /// Id of the link over which it is reached.
    #[schema(required = true)]
    pub link: Option<u32>,
    /// Share of its frames that were lost, percent.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round-trip time of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
    /// Whether it hears us: false when it is heard but answers nothing of ours, so that the link works in one direction
    /// only; null when unknown.
    #[schema(required = true)]
    pub is_reached: Option<bool>,
    /// Where another vehicle with the same system id is heard, to which nothing is sent; for a remote vehicle, another
    /// computer with the same name: orders go only to the one heard first. Null when there is none.
    #[schema(required = true)]
    pub rival: Option<String>,
    /// What the station on board of a remote vehicle reports of its links to the autopilot, in English, while the
    /// autopilot is silent; null when it is heard, and when the station on board is not heard either.
    #[schema(required = true)]
    pub silence: Option<String>,
    /// Whether it comes from a recording and takes no commands: a replay, or a link that plays one.
    pub is_recorded: bool,
    /// The replay that it belongs to; null when there is none.
    #[schema(required = true)]
    pub replay: Option<Replay>,
    /// Whether it requests ground elevations at positions that no map of this server contains.
    pub lacks_terrain: bool,
    /// Flight characteristics according to its parameters, as far as they were read.
    pub flight_parameters: FlightParameters,
}

/// Flight characteristics according to an ArduPlane's parameters, which the station reads by itself; null where not
/// read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct FlightParameters {
    /// Radius of circles without a radius of their own (`WP_LOITER_RAD`).
    #[schema(required = true)]
    pub loiter_radius_m: Option<f64>,
    /// Airspeed in automatic flight (`AIRSPEED_CRUISE`, before 4.5 `TRIM_ARSPD_CM`).
    #[schema(required = true)]
    pub airspeed_m_s: Option<f64>,
    /// Whether a return uses the mission's landing (`RTL_AUTOLAND` is not 0); otherwise the vehicle refuses to arm with
    /// a `DO_LAND_START`.
    #[schema(required = true)]
    pub finds_landing: Option<bool>,
}

/// Steps needed before a flight, which `POST /vehicles/{id}/prepare-flight` carries out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FlightPreparation {
    /// Present mode.
    pub from_mode: String,
    /// Mode to change to; null when it arms in the present one.
    #[schema(required = true)]
    pub mode: Option<String>,
    /// Whether the mission is reset to its beginning; false when there is none.
    pub rewinds_mission: bool,
}

/// Automatic flight and mission progress of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema, Default)]
pub struct MissionProgress {
    /// Whether its mode flies the mission; null while its mode is unknown.
    #[schema(required = true)]
    pub follows_mission: Option<bool>,
    /// Whether it is descending to land, so that the landing can be aborted; null when unknown, as in a mission that
    /// was not read.
    #[schema(required = true)]
    pub is_landing: Option<bool>,
    /// Turn rate of its course while it circles by itself, clockwise positive; null in other modes, and when unknown.
    #[schema(required = true)]
    pub turn_rate_deg_s: Option<f64>,
    /// Current item, counted from 1.
    #[schema(required = true)]
    pub item: Option<u16>,
    /// Number of items in the mission.
    #[schema(required = true)]
    pub total: Option<u16>,
    /// Reached items, ascending.
    pub reached: Vec<u16>,
    /// Whether the mission has been completed.
    pub is_complete: bool,
    /// Distance over ground to the end of the mission.
    #[schema(required = true)]
    pub distance_m: Option<f64>,
    /// Time for that distance at the present speed.
    #[schema(required = true)]
    pub time_s: Option<f64>,
    /// Distance to the current item.
    #[schema(required = true)]
    pub leg_distance_m: Option<f64>,
    /// Turns flown of the circle at the current item; null while it circles at none, and when the beginning of the
    /// circle was not heard.
    #[schema(required = true)]
    pub circled_turns: Option<f64>,
    /// Time on that circle by the vehicle's clock; null in the same cases.
    #[schema(required = true)]
    pub circled_s: Option<f64>,
    /// An alarm: distance between the position it flies to and the current item of the plan that was read from it; null
    /// when there is no alarm.
    #[schema(required = true)]
    pub target_off_m: Option<f64>,
    /// Steps needed before a flight; null when there are none, and while it is armed or in the air.
    #[schema(required = true)]
    pub preparation: Option<FlightPreparation>,
}

/// State of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleState {
    /// Id of the vehicle in this API: the MAVLink system id of one on a link, 256 to 65,535 for a remote or replayed one.
    pub system_id: u16,
    /// Time of this snapshot, seconds on the station's clock.
    pub time_s: f64,
    /// Newest telemetry values by group.
    pub telemetry: TelemetryGroups,
    /// Mission progress.
    pub progress: MissionProgress,
    /// States of the plans on board.
    pub plan_states: PlanStates,
    /// Names of its flight modes.
    pub mode_names: Vec<String>,
    /// Whether it flies the arcs of `NAV_ARC_WAYPOINT`; a plane passes straight over such items.
    pub flies_arcs: bool,
    /// Link over which it is reached, with counters of this vehicle alone.
    #[schema(required = true)]
    pub link: Option<LinkInfo>,
}

/// A status text from the vehicle (STATUSTEXT).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Text {
    /// Time of reception, seconds on the station's clock; of a replay, the position in its recording.
    pub time_s: f64,
    /// Of a replay, the time at which it was recorded, seconds since 1970; null when unknown, and for other vehicles.
    #[schema(required = true)]
    pub unix_s: Option<f64>,
    /// `MAV_SEVERITY`: 0 emergency to 7 debug.
    pub severity: u8,
    /// The text.
    pub text: String,
}

/// A parameter of the vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Param {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// MAVLink type: `int8` … `real32`.
    pub kind: String,
    /// Default value on this vehicle; null when it is not reported. Only lists read over MAVFTP from an ArduPilot since
    /// 4.2 report it.
    #[schema(required = true)]
    pub default: Option<f64>,
}

/// New value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewParam {
    /// The value.
    pub value: f64,
}
