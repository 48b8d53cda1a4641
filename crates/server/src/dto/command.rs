//! What is asked of a vehicle at once, where it has another form than in the core.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Nothing more to say: the vehicle did it, and shows it where that can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Done {}

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
