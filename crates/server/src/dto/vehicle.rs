//! What is known of a vehicle, and its parameters.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_vehicle::telemetry::TelemetryGroups;

use super::{LinkInfo, PlanStates};

/// A vehicle in the list of vehicles.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleSummary {
    /// Its id here: the MAVLink system id of one at a link, 256 to 65,535 for one far away.
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
    /// Whether the motors can run.
    #[schema(required = true)]
    pub is_armed: Option<bool>,
    /// Time since the vehicle was heard; stale after 3.5 s, lost after 5 s.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Its name in a fleet, when it is far away: no link of this server reaches it, a station on board does.
    #[schema(required = true)]
    pub remote_name: Option<String>,
    /// The link that it is reached over.
    #[schema(required = true)]
    pub link: Option<u32>,
    /// Share of its frames that were lost.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round trip of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
    /// Whether it hears us: false when it is heard but answers nothing of ours, so that the link works in one direction only; null
    /// when that is not known.
    #[schema(required = true)]
    pub is_reached: Option<bool>,
    /// Where another vehicle with the same system id is heard, to which nothing is sent; far away, one with the same name: nothing is sent to either.
    #[schema(required = true)]
    pub rival: Option<String>,
    /// Whether it asks for the ground's altitude at places where no map of this server knows it.
    pub lacks_terrain: bool,
    /// What its parameters say of how it flies, as far as they were read.
    pub flight_parameters: FlightParameters,
}

/// What an ArduPlane's parameters say of how it flies; null is not read. The station reads them by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct FlightParameters {
    /// Radius of circles that give none (`WP_LOITER_RAD`).
    #[schema(required = true)]
    pub loiter_radius_m: Option<f64>,
    /// Airspeed that it flies by itself (`AIRSPEED_CRUISE`, before 4.5 `TRIM_ARSPD_CM`).
    #[schema(required = true)]
    pub airspeed_m_s: Option<f64>,
    /// Whether a return looks for the mission's landing (`RTL_AUTOLAND` is not 0); where it does not, it does not arm with a
    /// `DO_LAND_START`.
    #[schema(required = true)]
    pub finds_landing: Option<bool>,
}

/// What a flight needs first: `POST /vehicles/{id}/prepare-flight` does it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FlightPreparation {
    /// The mode that it is in.
    pub from_mode: String,
    /// The mode to change to; null when it arms as it is.
    #[schema(required = true)]
    pub mode: Option<String>,
    /// Whether the mission is set back to its beginning; false when there is none.
    pub rewinds_mission: bool,
}

/// What the vehicle does by itself, and where it stands in its mission.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema, Default)]
pub struct MissionProgress {
    /// Whether its mode flies the mission; null while its mode is not known.
    #[schema(required = true)]
    pub follows_mission: Option<bool>,
    /// Whether it is on its way down to land, so that this can be aborted; null when that is not known, as in a mission that was not read.
    #[schema(required = true)]
    pub is_landing: Option<bool>,
    /// How fast its course turns while it circles by itself, clockwise positive; null in other modes, and where that is not known.
    #[schema(required = true)]
    pub turn_rate_deg_s: Option<f64>,
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
    /// Turns that were flown of the circle at the item in execution; null while it circles at none, and where its beginning was not heard.
    #[schema(required = true)]
    pub circled_turns: Option<f64>,
    /// Time on that circle by the vehicle's clock; null likewise.
    #[schema(required = true)]
    pub circled_s: Option<f64>,
    /// An alarm: it flies to somewhere that is this far from the current item of the plan that was read from it; null while not.
    #[schema(required = true)]
    pub target_off_m: Option<f64>,
    /// What a flight needs first; null when nothing, and while it is armed or in the air.
    #[schema(required = true)]
    pub preparation: Option<FlightPreparation>,
}

/// Everything that is known of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleState {
    /// Its id here: the MAVLink system id of one at a link, 256 to 65,535 for one far away.
    pub system_id: u16,
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
    /// Whether it flies the arcs of `NAV_ARC_WAYPOINT`; a plane passes straight over such an item.
    pub flies_arcs: bool,
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
