//! A list of many vehicles: what each row shows, and how a change of it is told.

use serde::Serialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

/// What a list shows of a vehicle. In a `roster` message a field that is absent is as it was told before; null is not known.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RosterRow {
    /// Its id here.
    pub id: u16,
    /// Its name in a fleet, when it is far away.
    pub remote_name: Option<String>,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    pub mav_type: Option<u8>,
    /// Flight mode by name.
    pub mode: Option<String>,
    /// Whether the motors can run.
    pub is_armed: Option<bool>,
    /// Whether it says that it is on the ground.
    pub is_on_ground: Option<bool>,
    /// WGS-84 latitude, to 0.1 m.
    pub lat_deg: Option<f64>,
    /// WGS-84 longitude, to 0.1 m.
    pub lon_deg: Option<f64>,
    /// Height above home, to 0.1 m.
    pub alt_rel_home_m: Option<f64>,
    /// Where the nose points, 0 to 360, whole degrees.
    pub heading_deg: Option<f64>,
    /// Speed through the air, to 0.1 m/s.
    pub airspeed_m_s: Option<f64>,
    /// Charge left, 0 to 100.
    pub battery_pct: Option<f64>,
    /// When it was heard last, seconds on the station's clock, to 0.1 s.
    pub heard_s: Option<f64>,
    /// Share of its frames that were lost, to 0.1 %; null far away.
    pub loss_pct: Option<f64>,
    /// Whether it hears us; null when that is not known.
    pub is_reached: Option<bool>,
    /// Whether another vehicle with its system id is heard, or another computer speaks by its name.
    pub is_contested: Option<bool>,
    /// Far away: who has control of it; null when nobody has.
    pub holder: Option<String>,
    /// Far away: whether that is an operator of this station.
    pub is_held_here: Option<bool>,
    /// Item of its mission in execution, counted from 1.
    pub item: Option<u16>,
    /// Items in its mission.
    pub items: Option<u16>,
    /// Whether its mission was flown to its end.
    pub is_complete: Option<bool>,
    /// An alarm: how far from the current item of its plan it flies to.
    pub target_off_m: Option<f64>,
    /// Whether the mission on board may be a mixture of two.
    pub may_be_mixed: Option<bool>,
    /// The newest text of the last minute that warns, or is worse.
    pub alarm: Option<RosterText>,
}

/// A text of a vehicle, in a list.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RosterText {
    /// `MAV_SEVERITY`: 0 emergency to 4 warning.
    pub severity: u8,
    /// What it wrote.
    pub text: String,
    /// When, seconds on the station's clock.
    pub time_s: f64,
}

/// The fields of a row that are to be told; `id` is always among them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct RosterChange(pub Map<String, Value>);
