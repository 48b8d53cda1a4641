//! Separation of planned flights.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::landing::Wind;
use vencejo_flight::rehearsal::Ending;

use super::Plan;

/// Planned flights whose separation is to be checked.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SeparationRequest {
    /// Two to 32 flights.
    #[schema(min_items = 2, max_items = 32)]
    pub flights: Vec<PlannedFlight>,
    /// Wind in which all flights are rehearsed; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Horizontal limit of separation, 1 to 10,000; 100 when absent. Flights conflict below both limits.
    #[serde(default)]
    pub horizontal_m: Option<f64>,
    /// Vertical limit of separation, 1 to 10,000; 30 when absent.
    #[serde(default)]
    pub vertical_m: Option<f64>,
    /// Time by which each flight may be earlier or later than rehearsed, relative to another, 0 to 3,600; 10 when
    /// absent.
    #[serde(default)]
    pub window_s: Option<f64>,
}

/// A planned flight.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedFlight {
    /// Vehicle that is to fly it; a default ArduPlane when absent.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Plan; when absent, the one on board the vehicle.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Start time on a clock common to all flights, 0 to 86,400; 0 when absent.
    #[serde(default)]
    pub starts_s: Option<f64>,
}

/// Result of a separation check.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Separation {
    /// Assumptions about each flight, in the order of the request.
    pub flights: Vec<AssumedFlight>,
    /// Wind in which all flights were rehearsed.
    pub wind: Wind,
    /// Limits in use.
    pub limits: SeparationLimits,
    /// Conflicts, earliest first; empty when all flights are separated.
    pub conflicts: Vec<Conflict>,
}

/// Assumptions about a flight.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AssumedFlight {
    /// The vehicle.
    #[schema(required = true)]
    pub vehicle: Option<u16>,
    /// Time of its start, on the ground at its home.
    pub starts_s: f64,
    /// Time at which its rehearsal ends.
    pub ends_s: f64,
    /// How its rehearsal ends.
    pub ending: Ending,
}

/// Limits of separation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct SeparationLimits {
    /// Horizontal distance.
    pub horizontal_m: f64,
    /// Vertical distance.
    pub vertical_m: f64,
    /// Time.
    pub window_s: f64,
}

/// A conflict between two flights.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Conflict {
    /// The two flights, counted from 1 in the order of the request.
    pub flights: [usize; 2],
    /// Time at which the first flight enters the conflict.
    pub begins_s: f64,
    /// Time at which the conflict ends.
    pub ends_s: f64,
    /// Positions of both flights at their smallest horizontal distance.
    pub nearest: [ConflictPlace; 2],
    /// Horizontal distance there.
    pub horizontal_m: f64,
    /// Vertical distance there.
    pub vertical_m: f64,
    /// Description in English.
    pub message: String,
}

/// Position of a flight at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct ConflictPlace {
    /// Time.
    pub time_s: f64,
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Altitude above mean sea level.
    pub alt_amsl_m: f64,
}
