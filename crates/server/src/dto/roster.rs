//! The fleet list: one row for each vehicle, sent as changes.

use serde::Serialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

/// Row of a vehicle in the fleet list. In a `roster` message, an absent field is unchanged and null is unknown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RosterRow {
    /// Id of the vehicle in this API.
    pub id: u16,
    /// Name of a vehicle in its fleet, or of the recording that it comes from; null for one on a link of this server.
    pub remote_name: Option<String>,
    /// Whether it comes from a recording and takes no commands.
    pub is_recorded: Option<bool>,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    pub mav_type: Option<u8>,
    /// Flight mode by name.
    pub mode: Option<String>,
    /// Whether it is armed.
    pub is_armed: Option<bool>,
    /// Whether it reports being on the ground.
    pub is_on_ground: Option<bool>,
    /// WGS-84 latitude, to 0.1 m.
    pub lat_deg: Option<f64>,
    /// WGS-84 longitude, to 0.1 m.
    pub lon_deg: Option<f64>,
    /// Altitude above home, to 0.1 m.
    pub alt_rel_home_m: Option<f64>,
    /// Heading of the nose, 0 to 360, whole degrees.
    pub heading_deg: Option<f64>,
    /// Airspeed, to 0.1 m/s.
    pub airspeed_m_s: Option<f64>,
    /// Remaining charge, 0 to 100.
    pub battery_pct: Option<f64>,
    /// Time when it was last heard, seconds on the station's clock, to 0.1 s.
    pub heard_s: Option<f64>,
    /// Share of its frames that were lost, to 0.1 %; null for a remote vehicle.
    pub loss_pct: Option<f64>,
    /// Whether it hears us; null when unknown.
    pub is_reached: Option<bool>,
    /// Whether another vehicle with the same system id is heard, or another computer uses its name.
    pub is_contested: Option<bool>,
    /// What the station on board of a remote vehicle reports of its links to the autopilot, in English, while the
    /// autopilot is silent; null when it is heard, and when the station on board is not heard either.
    pub silence: Option<String>,
    /// Holder of control of a remote vehicle; null when there is none.
    pub holder: Option<String>,
    /// Whether an operator of this station is the holder of a remote vehicle.
    pub is_held_here: Option<bool>,
    /// Operator who asks for control of a remote vehicle; null when there is none.
    pub requested_by: Option<String>,
    /// Whether that is an operator of this station.
    pub is_requested_here: Option<bool>,
    /// Whether its certificate was revoked, as far as this station knows.
    pub is_revoked: Option<bool>,
    /// Current mission item, counted from 1.
    pub item: Option<u16>,
    /// Number of items in its mission.
    pub items: Option<u16>,
    /// Whether its mission has been completed.
    pub is_complete: Option<bool>,
    /// An alarm: distance between the position it flies to and the current item of its plan; null when there is no
    /// alarm.
    pub target_off_m: Option<f64>,
    /// Whether the mission on board may be a mixture of two.
    pub may_be_mixed: Option<bool>,
    /// Newest text of severity warning or worse in the last minute; null when there is none.
    pub alarm: Option<RosterText>,
}

/// A status text of a vehicle in the fleet list.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RosterText {
    /// `MAV_SEVERITY`: 0 emergency to 4 warning.
    pub severity: u8,
    /// The text.
    pub text: String,
    /// Time of reception, seconds on the station's clock.
    pub time_s: f64,
}

/// Changed fields of a row; `id` is always included.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct RosterChange(pub Map<String, Value>);
