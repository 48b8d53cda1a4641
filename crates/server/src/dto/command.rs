//! What is asked of a vehicle at once.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
