//! Planned flights held against each other.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::landing::Wind;
use vencejo_flight::rehearsal::Ending;

use super::Plan;

/// Flights to be held against each other.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SeparationRequest {
    /// Two to 32.
    #[schema(min_items = 2, max_items = 32)]
    pub flights: Vec<PlannedFlight>,
    /// The wind that all are rehearsed in; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Distance over ground below which they are too near, 1 to 10,000; 100 when absent.
    #[serde(default)]
    pub horizontal_m: Option<f64>,
    /// Difference in height below which they are too near, 1 to 10,000; 30 when absent.
    #[serde(default)]
    pub vertical_m: Option<f64>,
    /// How much earlier or later one may be, against another, than its rehearsal says, 0 to 3,600; 10 when absent.
    #[serde(default)]
    pub window_s: Option<f64>,
}

/// A flight that is planned.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedFlight {
    /// The vehicle that is to fly it; an ArduPlane as it comes when absent.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The plan; the one on board of the vehicle when absent.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// When it starts, on a clock that all have in common, 0 to 86,400; 0 when absent.
    #[serde(default)]
    pub starts_s: Option<f64>,
}

/// Where flights come too near to each other.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Separation {
    /// What was assumed of each flight, in the order of the request.
    pub flights: Vec<AssumedFlight>,
    /// The wind that all were rehearsed in.
    pub wind: Wind,
    /// The limits that were asked for.
    pub limits: SeparationLimits,
    /// Earliest first; none when all are far enough apart.
    pub conflicts: Vec<Conflict>,
}

/// What was assumed of a flight.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AssumedFlight {
    /// The vehicle.
    #[schema(required = true)]
    pub vehicle: Option<u16>,
    /// When it starts, from the ground at its home.
    pub starts_s: f64,
    /// When its rehearsal ends.
    pub ends_s: f64,
    /// How.
    pub ending: Ending,
}

/// How far apart flights are to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct SeparationLimits {
    /// Over ground.
    pub horizontal_m: f64,
    /// In height.
    pub vertical_m: f64,
    /// In time.
    pub window_s: f64,
}

/// Two flights that come too near to each other.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Conflict {
    /// The two flights, counted from 1 in the order of the request.
    pub flights: [usize; 2],
    /// Since when the first is too near.
    pub begins_s: f64,
    /// Until when.
    pub ends_s: f64,
    /// Where each is where they come nearest over ground.
    pub nearest: [ConflictPlace; 2],
    /// Distance over ground there.
    pub horizontal_m: f64,
    /// Difference in height there.
    pub vertical_m: f64,
    /// The same in English.
    pub message: String,
}

/// Where a flight is at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct ConflictPlace {
    /// When.
    pub time_s: f64,
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height above mean sea level.
    pub alt_amsl_m: f64,
}
